!> Enclosure of the traction over a box of separations, for straight planes without the guard.
!>
!> In the axes of a plane the traction is that of the bond, (1 - alpha) K s, the pressure, and alpha times the friction,
!> which is the trial separation times a factor from 0 to 1 and at most mu p. The numbers in brackets are equations of
!> asperity_plane.inc.
module asperity_traction_bounds
  use asperity_contract, only: plane_statev, v_offset
  use asperity_enclosure, only: combination, constant, difference_of, enclosure_type, limited, multiple, norm_of, &
    positive_part, product_of, reciprocal, secant, size_of, sum_of, ulp, unknown
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_material, only: damage_share, material_type
  use asperity_pattern, only: plane_normal
  implicit none
  private
  public :: enclose_traction, timed_constants

  !> Rounding errors of the law and of sums, relative to the magnitudes of their terms.
  real(wp), parameter, public :: rounding_of_law = 256.0_wp*epsilon(1.0_wp)

  !> Constants of the law over an increment: weights of the old damage and of (7) in the new damage.
  type, extends(material_type), public :: timed_type
    real(wp) :: keep, take, take_eta
  end type timed_type

contains

  !> The constants of the law for an increment of duration dt.
  pure function timed_constants(material, dt) result(timed)
    type(material_type), intent(in) :: material   !! constants
    real(wp), intent(in) :: dt                    !! duration, >= 0, time
    type(timed_type) :: timed
    timed%material_type = material
    timed%take = damage_share(material, dt)
    timed%keep = merge(1.0_wp - timed%take, 0.0_wp, material%tau_v > 0.0_wp)
    timed%take_eta = timed%take*material%inv_eta
  end function timed_constants

  !> Enclose the traction over a box, rounding errors of the law included.
  pure subroutine enclose_traction(joint, material, state, s, outward, traction, most)
    type(interface_type), intent(in) :: joint           !! the interface
    type(timed_type), intent(in) :: material            !! constants of the law over the increment
    real(wp), intent(in) :: state(:)                    !! STATEV at the start of the increment
    type(enclosure_type), intent(in) :: s(3)            !! separation (N, Tx, Ty)
    real(wp), intent(in) :: outward(3)                  !! a vector
    type(enclosure_type), intent(out) :: traction(3)    !! stress
    real(wp), intent(out) :: most                       !! upper bound of the traction in the direction of this vector
    type(enclosure_type) :: sigma(3), term, whole(3)
    real(wp) :: axes(3, 3), error(3), most_of_plane, weight
    integer :: i, j, k
    do i = 1, 3
      whole(i) = sum_of(s(i), constant(state(v_offset + i - 1)))
    end do
    error = 0.0_wp
    most = 0.0_wp
    do k = 1, joint%pattern%n
      axes(1, :) = plane_normal(joint%pattern, k)
      axes(2, :) = [joint%pattern%sin_theta(k), joint%pattern%cos_theta(k)*joint%pattern%e_x(k), &
        joint%pattern%cos_theta(k)*joint%pattern%e_y(k)]
      axes(3, :) = [0.0_wp, joint%pattern%h_x(k), joint%pattern%h_y(k)]
      weight = joint%pattern%gamma(k)*material%k_t
      associate (plane => state(plane_statev(k):plane_statev(k) + 2))
        call enclose_plane(material, plane, [(combination(axes(i, :), whole), i=1, 3)], matmul(axes, outward), &
          sigma, most_of_plane)
        error = error + weight*(abs(plane(2)) + abs(plane(3)))
      end associate
      most = most + weight*most_of_plane
      do j = 1, 3
        term = combination(weight*axes(:, j), sigma)
        error(j) = error(j) + size_of(term)
        traction(j) = enclosure_type(traction(j)%centre + term%centre, traction(j)%slope + term%slope, &
          traction(j)%error + term%error, traction(j)%low + term%low, traction(j)%high + term%high)
      end do
    end do
    error = rounding_of_law*error
    do j = 1, 3
      traction(j)%error = traction(j)%error + error(j)
      traction(j)%low = traction(j)%low - error(j)
      traction(j)%high = traction(j)%high + error(j)
    end do
  end subroutine enclose_traction

  !> Enclose the traction of a plane, over K_t, in its axes.
  pure subroutine enclose_plane(m, old, s, outward, sigma, most)
    type(timed_type), intent(in) :: m             !! constants of the law over the increment
    real(wp), intent(in) :: old(3)                   !! damage and inelastic slip at the start
    type(enclosure_type), intent(in) :: s(3)         !! separation of the plane
    real(wp), intent(in) :: outward(3)               !! a vector
    type(enclosure_type), intent(out) :: sigma(3)    !! its traction
    real(wp), intent(out) :: most                    !! upper bound of the traction in the direction of this vector
    type(enclosure_type) :: bond(3), damage, friction(2), left, norm, pressure
    real(wp) :: along, scale(3), strength
    logical :: stuck
    integer :: i
    ! norm (6), in which all separations at the onset of damage are 1
    scale = [sqrt(m%inv_s01_2), sqrt(m%inv_s02_2), sqrt(m%inv_s02_2)]
    bond = s
    bond(1) = positive_part(s(1))
    do i = 1, 3
      bond(i) = multiple(scale(i), bond(i))
    end do
    norm = norm_of(bond)
    left = bond_left(m, old(1), norm)
    strength = bond_strength(m, old(1), norm)
    sigma = constant(0.0_wp)
    most = 0.0_wp
    if (.not. (strength > 0.0_wp .or. s(1)%low < 0.0_wp)) return
    scale = [m%kn_kt, 1.0_wp, 1.0_wp]/scale
    do i = 1, 3
      bond(i) = multiple(scale(i), limited(product_of(left, bond(i)), -strength, strength))
    end do
    damage = difference_of(constant(1.0_wp), left)
    pressure = multiple(m%kc_kt, positive_part(multiple(-1.0_wp, s(1))))
    call enclose_friction(s(2:3), old(2:3), multiple(m%mu, pressure), friction, stuck)
    sigma(1) = difference_of(bond(1), pressure)
    do i = 1, 2
      if (stuck) then
        sigma(i + 1) = difference_of(s(i + 1), multiple(old(i + 1), damage))
      else
        sigma(i + 1) = sum_of(bond(i + 1), product_of(damage, friction(i)))
      end if
    end do
    ! the bond is inside its ellipse of strength, the contact inside the cone of friction
    along = strength*sqrt(sum((outward*scale)**2))
    most = min(along, sum(max(outward*bond%low, outward*bond%high))) + rounding_of_law*along
    along = m%mu*sqrt(outward(2)**2 + outward(3)**2)
    along = along - outward(1) + ulp*(along + abs(outward(1)))
    most = most + max(pressure%low*along, pressure%high*along)
  end subroutine enclose_plane

  !> Enclose the stress of friction (30)-(39) over K_t: the trial separation times min(1, mu p/its norm).
  pure subroutine enclose_friction(s, slip, strength, friction, stuck)
    type(enclosure_type), intent(in) :: s(2)               !! tangential separation
    real(wp), intent(in) :: slip(2)                        !! inelastic slip at the start
    type(enclosure_type), intent(in) :: strength           !! mu p
    type(enclosure_type), intent(out) :: friction(2)       !! stress of friction
    logical, intent(out) :: stuck                          !! whether it is the trial separation
    !> A norm of which less is known has no useful reciprocal.
    real(wp), parameter :: least = 0.01_wp
    type(enclosure_type) :: factor, norm, trial(3)
    integer :: i
    stuck = .false.
    friction = constant(0.0_wp)
    if (.not. strength%high > 0.0_wp) return
    trial = [difference_of(s(1), constant(slip(1))), difference_of(s(2), constant(slip(2))), constant(0.0_wp)]
    norm = norm_of(trial)
    stuck = norm%high <= strength%low
    friction = trial(1:2)
    if (stuck) return
    factor = unknown(0.0_wp, 1.0_wp)
    if (norm%low > least*norm%high) then
      factor = difference_of(constant(1.0_wp), product_of(strength, reciprocal(norm)))
      factor = difference_of(constant(1.0_wp), positive_part(factor))
    end if
    factor = limited(factor, strength%low/norm%high, 1.0_wp)
    do i = 1, 2
      friction(i) = limited(product_of(factor, trial(i)), -strength%high, strength%high)
    end do
  end subroutine enclose_friction

  !> Enclose the share 1 - alpha of the bond that is left after an increment to a norm (6).
  pure function bond_left(m, old, norm) result(left)
    type(timed_type), intent(in) :: m               !! constants of the law over the increment
    real(wp), intent(in) :: old                        !! damage at the start
    type(enclosure_type), intent(in) :: norm           !! 1 + beta
    type(enclosure_type) :: left
    real(wp) :: at(3), distances(3), first, last, rounding, slope
    integer :: i
    first = share(norm%low)
    last = share(norm%high)
    left = multiple(1.0_wp, constant(first))
    ! the share decreases with the norm, or it does not change
    if (.not. last < first) return
    slope = (last - first)/(norm%high - norm%low)
    ! the distance from the chord is largest at the kink of the onset, and smallest at that of full damage or where the
    ! derivative -take_eta/norm**2 between them is that of the chord, or zero at the ends
    at = [onset(m, old), 1.0_wp/(1.0_wp - m%eta), sqrt(-m%take_eta/slope)]
    do i = 1, size(at)
      at(i) = min(max(at(i), norm%low), norm%high)
      distances(i) = share(at(i)) - first - slope*(at(i) - norm%low)
    end do
    rounding = ulp*(1.0_wp + m%take_eta)
    left = secant(norm, norm%low, first, slope, minval(distances) - rounding, maxval(distances) + rounding, &
      last - rounding, first + rounding)

  contains

    !> Share of the bond at a norm.
    pure function share(at_norm)
      real(wp), intent(in) :: at_norm   !! 1 + beta
      real(wp) :: share
      share = 1.0_wp - damage_at(m, old, at_norm)
    end function share

  end function bond_left

  !> Upper bound of the strength (1 - alpha) (1 + beta) of a bond over a range of the norm 1 + beta. Without viscosity
  !> it is largest at the onset of damage.
  pure function bond_strength(m, old, norm) result(strength)
    type(timed_type), intent(in) :: m               !! constants of the law over the increment
    real(wp), intent(in) :: old                        !! damage at the start
    type(enclosure_type), intent(in) :: norm           !! 1 + beta
    real(wp) :: strength
    real(wp) :: peak
    strength = 0.0_wp
    if (damage_at(m, old, (1.0_wp - ulp)*norm%low) >= 1.0_wp) return
    peak = norm%high
    if (.not. m%keep > 0.0_wp) peak = min(max(onset(m, old), norm%low), norm%high)
    strength = (1.0_wp - damage_at(m, old, merge(norm%low, peak, m%keep > 0.0_wp)))*peak
    strength = strength + rounding_of_law*(1.0_wp + m%take_eta)*peak
  end function bond_strength

  !> Norm 1 + beta at which the damage begins to grow.
  pure function onset(m, old) result(norm)
    type(timed_type), intent(in) :: m   !! constants of the law over the increment
    real(wp), intent(in) :: old            !! damage at the start
    real(wp) :: norm
    norm = 1.0_wp/(1.0_wp - m%eta*old)
  end function onset

  !> Damage (7) with its history (25) where the norm 1 + beta of (6) has a value; it grows with this value.
  pure function damage_at(m, old, norm) result(alpha)
    type(timed_type), intent(in) :: m   !! constants of the law over the increment
    real(wp), intent(in) :: old            !! damage at the start
    real(wp), intent(in) :: norm           !! 1 + beta
    real(wp) :: alpha
    alpha = max(old, merge(1.0_wp - m%take, 0.0_wp, m%keep > 0.0_wp)*old + min(m%take, &
      m%take_eta*(1.0_wp - 1.0_wp/max(1.0_wp, norm))))
  end function damage_at

end module asperity_traction_bounds
