!> Contact of a plane in double precision, for those who ask for it outside of an update.
module asperity_contact
  use asperity_kinds, only: wp
  use asperity_material, only: material_type
  use asperity_types_double, only: local_type
  implicit none
  private
  public :: closure_under, opening, closure, pressure, contact_stiffness, pressure_energy, hyperbolic, stiffening

contains

  include "asperity_contact.inc"

  !> Closure at which a plane has a pressure, length; the inverse of `pressure` up to m%linear_from.
  pure function closure_under(m, p) result(c)
    type(material_type), intent(in) :: m    !! constants
    real(wp), intent(in) :: p               !! pressure, >= 0, stress
    real(wp) :: c
    c = p/(m%k_c + p*m%inv_largest_closure)
  end function closure_under

end module asperity_contact
