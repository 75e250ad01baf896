!> Closure of a plane under a pressure, for those who ask for it outside of an update (asperity_contact.inc).
module asperity_contact
  use asperity_kinds, only: wp
  use asperity_material, only: material_type
  implicit none
  private
  public :: closure_under, stiffening

contains

  !> Closure at which a plane has a pressure, length; beyond m%linear_from it is that of the hyperbola.
  pure function closure_under(m, p) result(c)
    type(material_type), intent(in) :: m    !! constants
    real(wp), intent(in) :: p               !! pressure, >= 0, stress
    real(wp) :: c
    c = p/(m%k_c + p*m%inv_largest_closure)
  end function closure_under

  !> Derivative of the pressure by the closure at a closure, over k_c.
  pure function stiffening(m, c) result(ratio)
    type(material_type), intent(in) :: m    !! constants
    real(wp), intent(in) :: c               !! closure, >= 0, length
    real(wp) :: ratio
    ratio = 1.0_wp/(1.0_wp - min(c, m%linear_from)*m%inv_largest_closure)**2
  end function stiffening

end module asperity_contact
