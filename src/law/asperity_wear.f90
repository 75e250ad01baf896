!> The share of a facet that its work wears and the pressure crushes, an extension of the paper (docs/extensions.md).
!>
!> Names are those of asperity_facet.
module asperity_wear
  use asperity_axes, only: uphill
  use asperity_contact, only: contact_stiffness, pressure
  use asperity_facet, only: exponentials
  use asperity_kinds, only: wp
  use asperity_types, only: bracket_type, crushed_type, facet_type, history_type, local_type, material_type, &
    plane_type, separation_type, vector_type
  implicit none
  private
  public :: crush_gradient, crushed_share, wear_drive, worn_share

contains

  !> Energy that a facet releases per worn share at a constant separation, over k_t:
  !> alpha (p dg/domega - tau_t ds_t/domega).
  pure function wear_drive(facet, alpha, p, tau_t) result(drive)
    type(facet_type), intent(in) :: facet    !! kinematics
    real(wp), intent(in) :: alpha            !! damage
    real(wp), intent(in) :: p                !! pressure, over k_t
    real(wp), intent(in) :: tau_t            !! stress of friction up the facet, over k_t
    real(wp) :: drive
    drive = alpha*(p*facet%n_omega - tau_t*facet%t_omega)
  end function wear_drive

  !> Worn share of a facet in an increment by its frictional work so far: it grows only where that releases energy.
  pure function worn_share(m, drive, old, wearing) result(omega)
    type(material_type), intent(in) :: m     !! constants
    real(wp), intent(in) :: drive            !! energy released per worn share at the start, over k_t
    type(history_type), intent(in) :: old    !! state at the start
    real(wp), intent(in) :: wearing          !! part of the wear of the increment that is done, 0 to 1
    real(wp) :: omega, unworn, spent
    call exponentials(m%by_points, old%wear_work*m%inv_w0, unworn, spent)
    omega = max(old%omega, spent*merge(1.0_wp, 0.0_wp, drive > 0.0_wp))
    omega = merge(omega, old%omega + wearing*(omega - old%omega), wearing >= 1.0_wp)
  end function worn_share

  !> Share of a facet that the pressure at a separation crushes: omega = omega_c(x) = 1 - log(1 + x)/x, where x is
  !> crush_factor times the pressure over `crush` on the facet of which omega is worn.
  !>
  !> Where the factor is not 0, the gap grows with omega. The closure and the gap, as functions of the pressure, then
  !> have an increasing sum, and its only root is the pressure sought. Halley's method finds it between 0 and the
  !> pressure on the unworn facet. It starts at the root for x/(2 + x) in place of omega_c and a closure that falls
  !> linearly from that of the unworn to that of the flat facet. After six steps no share of 2 million random facets is
  !> wrong by more than 1e-11, with slopes up to 89.5 degrees, and up to 65 degrees by more than rounding.
  pure function crushed_share(m, plane, s) result(omega)
    type(material_type), intent(in) :: m     !! constants
    type(plane_type), intent(in) :: plane    !! axes and slope; a flat plane has no asperity
    type(vector_type), intent(in) :: s       !! separation of the interface, length
    real(wp) :: omega
    type(crushed_type) :: facet
    type(bracket_type) :: root
    real(wp) :: a, b, closed, size, u, unworn, x
    u = max(uphill(plane, s), 0.0_wp)
    call exponentials(m%by_points, (max(u, m%foot) - m%foot)*(plane%slope*m%inv_height), facet%slope, facet%rise)
    facet%level = s%n
    facet%rise = m%height*facet%rise + min(u, m%foot)*plane%slope
    facet%slope = plane%slope*facet%slope
    facet%per_length = (m%kt_crush*crush_factor(m, facet))*m%kc_kt
    unworn = max((facet%rise - s%n)/sqrt(1.0_wp + facet%slope**2), 0.0_wp)
    ! a c^2 + b c - 2 (closure of the unworn facet) = 0
    a = facet%per_length - 2.0_wp*m%inv_largest_closure
    b = 2.0_wp - unworn*a + facet%per_length*max(s%n + unworn, 0.0_wp)
    size = sqrt(max(b**2 + 8.0_wp*(unworn*a), 0.0_wp))
    closed = merge(4.0_wp*unworn, 0.5_wp*(size - b), b >= 0.0_wp)/merge(b + size, a, b >= 0.0_wp)
    closed = min(closed, unworn, m%linear_from)
    root%at = closed/(1.0_wp - closed*m%inv_largest_closure)
    root%low = 0.0_wp
    root%high = unworn
    if (m%hyperbolic) root%high = pressure(m, local_type(-unworn, 0.0_wp, 0.0_wp))/m%kc_kt
    root = next_pressure(m, facet, root)
    root = next_pressure(m, facet, root)
    root = next_pressure(m, facet, root)
    root = next_pressure(m, facet, root)
    root = next_pressure(m, facet, root)
    root = next_pressure(m, facet, root)
    x = facet%per_length*root%at
    omega = x*crushed_ratio(x)
  end function crushed_share

  !> Factor of the pressure that crushes a facet, 0 to 1: max(0, 1 - (max(-w, 0) z'^2 + mu max(z - w, 0) z')/z), with
  !> height z and slope z' of the unworn facet; 0 at the foot and below.
  !>
  !> Where it is not 0, a facet that is climbed, whatever its friction, releases energy if it is flattened at a constant
  !> separation.
  pure function crush_factor(m, facet) result(factor)
    type(material_type), intent(in) :: m       !! constants
    type(crushed_type), intent(in) :: facet    !! the unworn facet
    real(wp) :: factor
    real(wp) :: c_2, rise
    ! the square of the cosine keeps products with the slope finite
    c_2 = 1.0_wp/(1.0_wp + facet%slope**2)
    rise = facet%rise*c_2
    factor = rise - max(-facet%level, 0.0_wp)*(facet%slope**2*c_2)
    factor = factor - m%mu*(max(facet%rise - facet%level, 0.0_wp)*(facet%slope*c_2))
    factor = max(factor, 0.0_wp)/max(rise, tiny(1.0_wp))
  end function crush_factor

  !> Next pressure on a facet that it crushes, by Halley's method; the middle of the bracket where that leaves it.
  pure function next_pressure(m, facet, root) result(next)
    type(material_type), intent(in) :: m       !! constants
    type(crushed_type), intent(in) :: facet    !! the unworn facet
    type(bracket_type), intent(in) :: root     !! pressure and its bracket
    type(bracket_type) :: next
    real(wp) :: bend, by_p, c, closed, excess, falls, gap, inverse, k, left, middle, move, q, ratio, rho, within, x
    x = facet%per_length*root%at
    ratio = crushed_ratio(x)
    ! gap and its derivative by omega, as in facet_at
    rho = 1.0_wp - x*ratio
    c = 1.0_wp/sqrt(1.0_wp + (rho*facet%slope)**2)
    q = (rho*facet%slope)*c
    gap = (facet%level - rho*facet%rise)*c
    q = c*(facet%rise + (gap*q)*facet%slope)
    inverse = 1.0_wp/(1.0_wp + x)
    by_p = q*(facet%per_length*(inverse - ratio))
    ! closure, its derivative and second derivative
    closed = root%at
    left = 1.0_wp
    bend = 0.0_wp
    if (m%hyperbolic) then
      within = min(root%at, m%linear_from/(1.0_wp - m%linear_from*m%inv_largest_closure))
      left = 1.0_wp/(1.0_wp + within*m%inv_largest_closure)
      closed = left*(within + left*(root%at - within))
      left = left**2
      bend = merge(-2.0_wp*m%inv_largest_closure*(left*sqrt(left)), 0.0_wp, root%at <= within)
    end if
    excess = closed + gap
    falls = max(left + by_p, left)
    move = -excess/falls
    ! second derivative times move, in products that cannot overflow
    k = facet%per_length*inverse
    bend = bend*move - ((k*move)*(k*q))*(1.0_wp + &
      merge((1.0_wp + x)/max(x, 0.01_wp)*(1.0_wp - 2.0_wp*ratio*(1.0_wp + x)), &
      -1.0_wp/3.0_wp, x > 0.01_wp))
    next%at = root%at + move/max(1.0_wp + 0.5_wp*bend/falls, 0.25_wp)
    next%low = merge(root%at, root%low, excess <= 0.0_wp)
    next%high = merge(root%high, root%at, excess <= 0.0_wp)
    ! both ends are tested: a distance from the middle is rounded, and would replace a root that has been found
    middle = 0.5_wp*(next%low + next%high)
    next%at = merge(merge(next%at, middle, next%at <= next%high), middle, next%at >= next%low)
  end function next_pressure

  !> Crushed share over x: (1 - log(1 + x)/x)/x, with its digits for small x.
  !>
  !> With y = x/(2 + x) the logarithm is 2 artanh(y), and x = 2 y/(1 - y).
  pure function crushed_ratio(x) result(ratio)
    real(wp), intent(in) :: x   !! pressure over `crush`, >= 0
    real(wp) :: ratio
    !> Up to here the series of artanh is used: its first omitted term is below a rounding error.
    real(wp), parameter :: short = 0.25_wp
    real(wp) :: far, y, y_2
    y = min(x, short)/(2.0_wp + min(x, short))
    y_2 = y**2
    far = max(x, short)
    ratio = merge(0.5_wp*(1.0_wp - y)*(1.0_wp - (1.0_wp - y)*y*(1.0_wp/3.0_wp + y_2*(1.0_wp/5.0_wp + &
      y_2*(1.0_wp/7.0_wp + &
      y_2*(1.0_wp/9.0_wp + y_2*(1.0_wp/11.0_wp + y_2*(1.0_wp/13.0_wp + y_2*(1.0_wp/15.0_wp)))))))), &
      (1.0_wp - log(1.0_wp + far)/far)/far, x < short)
  end function crushed_ratio

  !> Derivatives of the crushed share by the separation of the interface along (N, e, h): omega depends on the gap
  !> through the pressure, and on w and u through crush_factor.
  pure function crush_gradient(m, at, level, omega) result(gradient)
    type(material_type), intent(in) :: m      !! constants
    type(separation_type), intent(in) :: at   !! separations at the end
    real(wp), intent(in) :: level             !! opening of the interface at the end, length
    real(wp), intent(in) :: omega             !! the crushed share, 0: the pressure crushes nothing
    type(local_type) :: gradient
    type(crushed_type) :: unworn
    real(wp) :: by_gap, by_u, by_w, factor, p, rate, rho, steeper, x
    associate (facet => at%facet)
      rho = max(1.0_wp - omega, tiny(1.0_wp))
      unworn%level = level
      unworn%rise = facet%z/rho
      unworn%slope = facet%q/(facet%c*rho)
      factor = crush_factor(m, unworn)
      ! a facet that is flat to rounding keeps its share; where p is 0, no height is 0 or negative
      p = m%kt_crush*pressure(m, at%contact)
      p = merge(p, 0.0_wp, omega*(1.0_wp - omega) > 0.0_wp)
      x = p*factor
      rate = max(1.0_wp/(1.0_wp + x) - min(0.5_wp, omega/max(x, tiny(x))), 0.0_wp)
      by_gap = factor*(m%kt_crush*contact_stiffness(m, at%contact))
      rate = rate/max(1.0_wp + (rate*by_gap)*facet%n_omega, 1.0_wp)
      rate = merge(rate, 0.0_wp, omega*(1.0_wp - omega) > 0.0_wp)
      ! p times the derivatives of the factor; d z'/d u = -bend z'
      p = p/max(unworn%rise, tiny(1.0_wp))
      steeper = facet%bend*unworn%slope
      by_w = m%mu + merge(unworn%slope, 0.0_wp, level < 0.0_wp)
      by_w = p*(by_w*unworn%slope)
      by_u = p*(unworn%slope*((1.0_wp - factor) - m%mu*unworn%slope) + &
        steeper*(2.0_wp*max(-level, 0.0_wp)*unworn%slope + m%mu*(unworn%rise - level)))
      gradient = local_type(rate*(by_w - by_gap*facet%c), rate*(by_u + by_gap*(facet%q*facet%f)), 0.0_wp)
    end associate
  end function crush_gradient

end module asperity_wear
