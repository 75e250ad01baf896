!> Contact of a plane: pressure, stiffness and energy of a closure, linear or hyperbolic (docs/extensions.md).
!>
!> The module asperity_law says how these functions are used and in which units. The closure c has the pressure K_c c/(1
!> - c/V_m) with the largest closure V_m, and beyond m%linear_from the tangent of that curve. A joint with linear
!> contact has 1/V_m = 0 and m%linear_from = huge. A dashpot adds a pressure.
module asperity_contact
  use asperity_kinds, only: wp
  use asperity_types, only: local_type, material_type
  implicit none
  private
  public :: add_dashpot, closure, closure_under, contact_stiffness, hyperbolic, opening, pressure, pressure_energy

contains

  !> Opening, the positive part of s_n.
  pure function opening(s) result(positive)
    type(local_type), intent(in) :: s   !! separation of the bond or of the contact
    real(wp) :: positive
    positive = max(s%n, 0.0_wp)
  end function opening

  !> Closure, the negative part of s_n with its sign changed.
  pure function closure(s) result(positive)
    type(local_type), intent(in) :: s   !! separation of the bond or of the contact
    real(wp) :: positive
    positive = max(s%n, 0.0_wp) - s%n
  end function closure

  !> Pressure p of a closed plane, over k_t.
  pure function pressure(m, s) result(p)
    type(material_type), intent(in) :: m    !! constants
    type(local_type), intent(in) :: s       !! separation of the bond or of the contact
    real(wp) :: p
    real(wp) :: c, within
    p = m%kc_kt*closure(s)
    if (m%hyperbolic) then
      c = closure(s)
      within = min(c, m%linear_from)
      p = m%kc_kt*(within/(1.0_wp - within*m%inv_largest_closure) + &
        (c - within)/(1.0_wp - within*m%inv_largest_closure)**2)
    end if
  end function pressure

  !> Closure under a pressure.
  pure function closure_under(m, p) result(c)
    type(material_type), intent(in) :: m    !! constants
    real(wp), intent(in) :: p               !! pressure, >= 0, over the stiffness of an open contact, length
    real(wp) :: c
    real(wp) :: left, within
    c = p
    if (m%hyperbolic) then
      within = min(p, m%linear_from/(1.0_wp - m%linear_from*m%inv_largest_closure))
      left = 1.0_wp/(1.0_wp + within*m%inv_largest_closure)
      c = left*(within + left*(p - within))
    end if
  end function closure_under

  !> Derivative of the pressure of a closed plane by its closure, over k_t.
  pure function contact_stiffness(m, s) result(stiffness)
    type(material_type), intent(in) :: m    !! constants
    type(local_type), intent(in) :: s       !! separation of the bond or of the contact
    real(wp) :: stiffness
    stiffness = m%kc_kt
    if (m%hyperbolic) stiffness = m%kc_kt/(1.0_wp - min(closure(s), m%linear_from)*m%inv_largest_closure)**2
  end function contact_stiffness

  !> Add a dashpot to the pressure of a closed plane and to its derivative, over k_t: c/dt times the change of the
  !> closure in the increment. The sum is no tension, and an open plane has none.
  pure subroutine add_dashpot(m, lag, start, s, p, stiffness)
    type(material_type), intent(in) :: m        !! constants
    real(wp), intent(in) :: lag                 !! c/(K_c dt)
    type(local_type), intent(in) :: start, s    !! separation of the contact at start and end
    real(wp), intent(inout) :: p                !! pressure
    real(wp), intent(inout) :: stiffness        !! its derivative by the closure
    real(wp) :: closed
    p = p + (lag*m%kc_kt)*(closure(s) - closure(start))
    ! conditions are reals: gfortran does not vectorise a logical expression of two comparisons
    closed = merge(1.0_wp, 0.0_wp, s%n <= 0.0_wp)
    stiffness = closed*merge(stiffness + lag*m%kc_kt, 0.0_wp, p >= 0.0_wp)
    p = closed*max(p, 0.0_wp)
  end subroutine add_dashpot

  !> Energy stored by the pressure of a closed plane, over k_t/2: -2 K_c V_m (c + V_m log(1 - c/V_m)), and further along
  !> the tangent of the pressure.
  pure function pressure_energy(m, s) result(energy)
    type(material_type), intent(in) :: m    !! constants
    type(local_type), intent(in) :: s       !! separation of the bond or of the contact
    real(wp) :: energy
    real(wp) :: beyond, within
    energy = pressure(m, s)*closure(s)
    if (m%hyperbolic) then
      within = min(closure(s), m%linear_from)
      beyond = closure(s) - within
      energy = (m%kc_kt*within)*within*hyperbolic(within*m%inv_largest_closure) + beyond*(pressure(m, s) + &
        m%kc_kt*within/(1.0_wp - within*m%inv_largest_closure))
    end if
  end function pressure_energy

  !> Energy of the hyperbola over that of its first tangent: -2 (x + log(1 - x))/x^2, with its digits for small x.
  !>
  !> With y = x/(2 - x) the logarithm is -2 artanh(y), and 2 y - x = x^2/(2 - x).
  pure function hyperbolic(x) result(ratio)
    real(wp), intent(in) :: x   !! closure over the largest one, 0 to largest_closure_share
    real(wp) :: ratio
    !> Up to here the series of artanh is used: its first omitted term is below a rounding error.
    real(wp), parameter :: short = 0.25_wp
    real(wp) :: far, y, y_2
    y = min(x, short)/(2.0_wp - min(x, short))
    y_2 = y**2
    far = max(x, short)
    ratio = merge(2.0_wp/(2.0_wp - min(x, short)) + 4.0_wp*y/(2.0_wp - min(x, short))**2*(1.0_wp/3.0_wp + &
      y_2*(1.0_wp/5.0_wp + y_2*(1.0_wp/7.0_wp + y_2*(1.0_wp/9.0_wp + y_2*(1.0_wp/11.0_wp + y_2*(1.0_wp/13.0_wp + &
      y_2*(1.0_wp/15.0_wp + y_2*(1.0_wp/17.0_wp + y_2*(1.0_wp/19.0_wp))))))))), &
      -2.0_wp*(far + log(1.0_wp - far))/far**2, x < short)
  end function hyperbolic

end module asperity_contact
