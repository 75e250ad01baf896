!> IMPL-EX (Oliver, Huespe, Cante 2008) of a UMAT: the state of the law at the end of an increment, and the traction and
!> tangent with damage, ratio of friction and trial stress, and facets of a separation that is extrapolated.
!>
!> The tangent is symmetric and has no negative eigenvalue (asperity_aim). The errors tend to zero with the increment
!> (docs/how-to/convergence.md).
module asperity_implex
  use asperity_aim, only: frozen_response
  use asperity_checks, only: all_bounded
  use asperity_contract, only: i_duration, i_growth, i_jump, i_longest, plane_statev
  use asperity_interface, only: interface_type, plane_damage, separation_bound
  use asperity_kinds, only: wp
  use asperity_material, only: damping_lag
  use asperity_point, only: update_point
  implicit none
  private
  public :: update_extrapolated

  !> Longest increment over the one before for which the separation is extrapolated: the time may have another scale.
  real(wp), parameter :: largest_ratio = 10.0_wp
  !> Shortest increment over the longest one of a step for which a shorter one is requested: no increment is short
  !> enough for a snap.
  real(wp), parameter :: least_share = 2.0e-3_wp
  !> Error over the tolerance from which a shorter increment is requested, as iterations have larger errors than their
  !> end; smallest factor of a request; share of the tolerance at which the next error aims.
  real(wp), parameter :: excess = 2.0_wp, least_factor = 0.25_wp, safety = 0.8_wp
  !> Tolerance of the damage over that of the traction.
  real(wp), parameter :: traction_weight = 2.0_wp

contains

  !> Update a point over an increment.
  !>
  !> The first increment of a step, and one after an increment without a duration or with a much shorter one, take
  !> damage, friction and facets from the separation at the start.
  pure subroutine update_extrapolated(joint, s_old, s, first, dt, state, traction, tangent, factor)
    type(interface_type), intent(in) :: joint              !! material, pattern and tolerance
    real(wp), intent(in) :: s_old(3), s(3)                 !! separation (N, Tx, Ty) at start and end, length
    logical, intent(in) :: first                           !! whether it is the first increment of a step
    real(wp), intent(in) :: dt                             !! duration, >= 0, time
    real(wp), intent(inout) :: state(joint%n_umat_statev)  !! STATEV, start -> end
    real(wp), intent(out) :: traction(3)                   !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)                 !! d traction_i/d s_j, stress/length
    real(wp), intent(out) :: factor                        !! wanted size of the increment over this one, 1: as it is
    real(wp), dimension(joint%n_statev) :: ends, frozen, start
    real(wp), dimension(joint%pattern%n) :: alpha, guess, old
    real(wp) :: aim(3), at_aim(3), implicit(3), ratio, sigma0, strength
    integer :: k, last
    last = i_longest + joint%pattern%n
    start = state(:joint%n_statev)
    old = plane_damage(joint, start)
    associate (own => state(joint%n_statev + 1:))
      ratio = extrapolation(first, own(i_duration), dt)
      aim = s_old + ratio*own(i_jump:i_jump + 2)
      if (.not. all_bounded(3, aim, separation_bound(joint))) then
        ratio = 0.0_wp
        aim = s_old
      end if
      call update_point(joint, s_old, s, start, ends, implicit, tangent, dt)
      call update_point(joint, s_old, aim, start, frozen, at_aim, tangent, dt)
      alpha = plane_damage(joint, ends)
      ! the separation shows that a plane begins to break, its own growth how fast it does
      guess = max(plane_damage(joint, frozen), min(1.0_wp, old + ratio*own(i_growth:last)))
      frozen([(plane_statev(k), k=1, joint%pattern%n)]) = guess
      call frozen_response(joint, damping_lag(joint%material, dt), s_old, aim, s, start, frozen, at_aim, traction, &
        tangent, strength, secant=.true.)
      sigma0 = joint%material%k_n/sqrt(joint%material%inv_s01_2)
      own(i_jump:i_jump + 2) = s - s_old
      own(i_longest) = merge(dt, max(own(i_longest), dt), first)
      own(i_duration) = dt
      own(i_growth:last) = alpha - old
      own(last + 1:last + 2) = [maxval(abs(alpha - guess)), norm2(traction - implicit)/max(sigma0, strength)]
      factor = 1.0_wp
      if (ratio > 0.0_wp .and. dt > least_share*own(i_longest)) factor = wanted(joint%implex, own(last + 1), &
        own(last + 2))
    end associate
    state(:joint%n_statev) = ends
  end subroutine update_extrapolated

  !> Duration of an increment over that of the last one, or 0 where the separation is not extrapolated.
  pure function extrapolation(first, last, dt) result(ratio)
    logical, intent(in) :: first     !! whether it is the first increment of a step
    real(wp), intent(in) :: last     !! duration of the last increment, 0: none, time
    real(wp), intent(in) :: dt       !! duration, >= 0, time
    real(wp) :: ratio
    ratio = 0.0_wp
    if (first .or. .not. last > 0.0_wp) return
    if (dt/largest_ratio <= last) ratio = dt/last
  end function extrapolation

  !> Wanted size of an increment over that of one with these errors; 1 where they are small enough.
  pure function wanted(tolerance, e_a, e_t) result(factor)
    real(wp), intent(in) :: tolerance   !! of a damage
    real(wp), intent(in) :: e_a, e_t    !! errors of damage and traction
    real(wp) :: factor
    real(wp) :: error
    error = max(e_a, traction_weight*e_t)
    factor = 1.0_wp
    if (error > excess*tolerance) factor = max(least_factor, safety*tolerance/error)
  end function wanted

end module asperity_implex
