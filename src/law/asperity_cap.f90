!> Compressive strength of a joint, in series with its law (docs/extensions.md): the curve of the strength over the
!> plastic closure kappa, and by how much a traction exceeds it.
!>
!> kappa is a function of a parameter x, by which the vertical start of the parabola is no obstacle to Newton's method:
!> kappa = kp (1 - cos x) up to the peak at x = pi/2, and beyond it kp times the rest of x: a softening of any length
!> takes no digit of the closure. Without a kp the curve begins at the peak with x = 0, and s_f takes the place of kp.
module asperity_cap
  use asperity_contract, only: n_fixed_props, p_css, p_fc, p_fcr, p_gc, p_gfc, p_kp, p_sigma0
  use asperity_kinds, only: wp
  implicit none
  private
  public :: all_withstood, cap_type, curve_type, excess_type, new_cap, parameter_of, curve_at, excess_of, &
    largest_pressure, strength_at, withstands

  !> Constants of the strength.
  type :: cap_type
    real(wp) :: peak = 0.0_wp       !! strength fc, 0: none, stress
    real(wp) :: residual = 0.0_wp   !! its residual, stress
    real(wp) :: length = 0.0_wp     !! length of the softening Gfc/(fc - residual), length
    real(wp) :: weight = 0.0_wp     !! of the shear, Css
    real(wp) :: hardened = 0.0_wp   !! plastic closure at the peak, length
    real(wp) :: corner = 0.0_wp     !! parameter at the peak
    real(wp) :: unit = 0.0_wp       !! plastic closure by the parameter beyond the peak, length
  end type cap_type

  !> A point of the curve.
  type :: curve_type
    real(wp) :: kappa             !! plastic closure, length
    real(wp) :: strength          !! there, stress
    real(wp) :: kappa_slope       !! derivatives by the parameter, length
    real(wp) :: strength_slope    !! stress
  end type curve_type

  !> By how much the pressure of a traction exceeds what the strength admits, stress: not positive where it does not;
  !> with its gradient by the traction and its derivative by the strength.
  type :: excess_type
    real(wp) :: value
    real(wp) :: gradient(3)
    real(wp) :: by_strength
  end type excess_type

  !> Strength at the start of the parabola over that at the peak (Lourenco 1996).
  real(wp), parameter :: first_share = 1.0_wp/3.0_wp
  !> Exponent beyond which an exponential is no number.
  real(wp), parameter :: largest_exponent = 700.0_wp

contains

  !> The strength from admissible PROPS.
  pure function new_cap(props) result(cap)
    real(wp), intent(in) :: props(n_fixed_props)   !! PROPS before the listed planes
    type(cap_type) :: cap
    if (.not. props(p_fc) > 0.0_wp) return
    cap%peak = props(p_fc)
    cap%residual = props(p_fcr)*cap%peak
    cap%length = props(p_gfc)/(cap%peak - cap%residual)
    cap%weight = props(p_css)
    cap%hardened = props(p_kp)
    cap%unit = 2.0_wp*props(p_gc)/props(p_sigma0)
    if (cap%hardened > 0.0_wp) then
      cap%corner = acos(0.0_wp)
      cap%unit = cap%hardened
    end if
  end function new_cap

  !> Parameter of a plastic closure.
  pure function parameter_of(cap, kappa) result(x)
    type(cap_type), intent(in) :: cap   !! constants
    real(wp), intent(in) :: kappa       !! >= 0, length
    real(wp) :: x
    if (kappa < cap%hardened) then
      x = 2.0_wp*asin(sqrt(0.5_wp*(kappa/cap%hardened)))
    else
      x = cap%corner + (kappa - cap%hardened)/cap%unit
    end if
  end function parameter_of

  !> Curve at a parameter.
  pure function curve_at(cap, x) result(curve)
    type(cap_type), intent(in) :: cap   !! constants
    real(wp), intent(in) :: x           !! >= 0
    type(curve_type) :: curve
    real(wp) :: beyond, falls
    if (x < cap%corner) then
      curve%kappa = 2.0_wp*cap%hardened*sin(0.5_wp*x)**2
      curve%kappa_slope = cap%hardened*sin(x)
      curve%strength = cap%peak*(first_share + (1.0_wp - first_share)*sin(x))
      curve%strength_slope = (1.0_wp - first_share)*cap%peak*cos(x)
    else
      beyond = cap%unit*(x - cap%corner)
      falls = (cap%peak - cap%residual)*exp(-min(beyond, largest_exponent*cap%length)/cap%length)
      curve%kappa = cap%hardened + beyond
      curve%kappa_slope = cap%unit
      curve%strength = cap%residual + falls
      curve%strength_slope = -(cap%unit/cap%length)*falls
    end if
  end function curve_at

  !> Strength at a plastic closure, stress.
  pure function strength_at(cap, kappa) result(strength)
    type(cap_type), intent(in) :: cap   !! constants
    real(wp), intent(in) :: kappa       !! >= 0, length
    real(wp) :: strength
    type(curve_type) :: curve
    curve = curve_at(cap, parameter_of(cap, kappa))
    strength = curve%strength
  end function strength_at

  !> Whether the strength withstands a traction at any plastic closure.
  pure function withstands(cap, traction) result(yes)
    type(cap_type), intent(in) :: cap         !! constants
    real(wp), intent(in) :: traction(3)       !! (N, Tx, Ty), stress
    logical :: yes
    yes = traction(1) >= 0.0_wp .and. .not. cap%weight > 0.0_wp
    if (.not. yes) yes = traction(1)**2 + cap%weight*(traction(2)**2 + traction(3)**2) <= &
      min(cap%residual, first_share*cap%peak)**2
  end function withstands

  !> Whether a strength withstands each of some tractions: one loop without branches.
  pure function all_withstood(cap, strength, n, traction) result(yes)
    type(cap_type), intent(in) :: cap          !! constants
    real(wp), intent(in) :: strength           !! at the plastic closure, stress
    integer, intent(in) :: n                   !! tractions
    real(wp), intent(in) :: traction(3, n)     !! (N, Tx, Ty), stress
    logical :: yes
    real(wp) :: most
    integer :: i
    most = 0.0_wp
    !$omp simd reduction(max:most)
    do i = 1, n
      most = max(most, min(traction(1, i), 0.0_wp)**2 + cap%weight*(traction(2, i)**2 + traction(3, i)**2))
    end do
    yes = most <= strength**2
  end function all_withstood

  !> Largest pressure beside the shear of a traction, stress.
  pure function largest_pressure(cap, strength, traction) result(p)
    type(cap_type), intent(in) :: cap         !! constants
    real(wp), intent(in) :: strength          !! at the plastic closure, stress
    real(wp), intent(in) :: traction(3)       !! (N, Tx, Ty), stress
    real(wp) :: p
    p = sqrt(max(strength**2 - cap%weight*(traction(2)**2 + traction(3)**2), 0.0_wp))
  end function largest_pressure

  !> Excess of a traction: of sqrt(p^2 + Css tau^2) over the strength or, where the shear alone exceeds it, of p over 0.
  pure function excess_of(cap, strength, traction) result(excess)
    type(cap_type), intent(in) :: cap         !! constants
    real(wp), intent(in) :: strength          !! at the plastic closure, stress
    real(wp), intent(in) :: traction(3)       !! (N, Tx, Ty), stress
    type(excess_type) :: excess
    real(wp) :: left, shear, size
    shear = cap%weight*(traction(2)**2 + traction(3)**2)
    left = strength**2 - shear
    excess%gradient = [-1.0_wp, 0.0_wp, 0.0_wp]
    excess%by_strength = 0.0_wp
    excess%value = -traction(1)
    if (.not. left > 0.0_wp) return
    if (traction(1) < 0.0_wp) then
      size = sqrt(traction(1)**2 + shear)
      excess%value = size - strength
      excess%gradient = [traction(1), cap%weight*traction(2:3)]/size
      excess%by_strength = -1.0_wp
    else
      excess%value = -traction(1) - sqrt(left)
      excess%gradient(2:3) = cap%weight*traction(2:3)/sqrt(left)
      excess%by_strength = -strength/sqrt(left)
    end if
  end function excess_of

end module asperity_cap
