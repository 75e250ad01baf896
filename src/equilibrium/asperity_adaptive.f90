!> Adaptive increments: each step is solved as two halves and as one whole increment; their difference gives its size.
!>
!> The tolerance bounds the error of straight lines between the rows: tolerance*largest traction for the tractions, the
!> same fraction of the largest separation for the free separations, and likewise for rupture, friction and work by the
!> trapezoidal rule. The reported energies are extrapolated from both solutions and have a smaller error. The end of a
!> step alone does not show its error, because a single increment of the total law is often exact at its end. A half in
!> which planes switch is divided at the switches as a check. A step that is too large, and in which a plane switches,
!> ends at the first switch (docs/solver.md).
module asperity_adaptive
  use asperity_contract, only: v_friction, v_rupture
  use asperity_control_point, only: control_type, point_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, plain_newton, report_type
  use asperity_rates, only: rate_of, rate_type
  use asperity_regime, only: criteria, n_regimes, regime, slips, slips_back, switch_shares
  use asperity_walk, only: correct_state, distance, end_error, extrapolate, keep_scales, largest_size, &
    largest_tolerance, least_tolerance, lines_error, new_walk, state_difference, walk_type
  implicit none
  private
  public :: walk_type, new_walk, adaptive_step, least_tolerance, largest_tolerance

  !> Smallest step, as a multiple of the tolerance: a steeper change of the curve is drawn as a jump (snap).
  real(wp), parameter :: least_size = 1.0e-2_wp
  !> Smallest step, as a fraction of the load path: it gives as many rows as a step of fixed increments may have.
  real(wp), parameter :: least_step = 1.0e-7_wp
  !> Largest growth and cut of the step size, and safety factor on the tolerance.
  real(wp), parameter :: most_growth = 4.0_wp, most_cut = 0.1_wp, safety = 0.9_wp
  !> Relative error above which a switch is searched, instead of cutting the step to less than a third.
  real(wp), parameter :: search_threshold = 10.0_wp
  !> Change over an increment, relative to the tolerance, below which its switches are not checked.
  real(wp), parameter :: least_change = 0.5_wp
  !> Error of a line by the rates at its ends above which the switches between them are checked.
  real(wp), parameter :: suspicious = 0.1_wp
  !> Largest factor by which a step is extended to reach the target.
  real(wp), parameter :: stretch = 1.01_wp
  !> Difference of the results at the end of a step, relative to the tolerance, above which slips and damage are
  !> corrected.
  real(wp), parameter :: least_correction = 0.01_wp
  !> Fraction of the step at which the regime of the planes at its start is evaluated.
  real(wp), parameter :: probe = 1.0e-6_wp

contains

  !> Take one accepted step on the load path from `start` to `target`; its middle and its end are returned.
  !>
  !> If no equilibrium is found, `reached` is below 1, and `at`, `point` and `middle` are the last ones found.
  pure subroutine adaptive_step(joint, control, start, target, walk, at, point, at_middle, middle, iterations, &
                                reached, reports)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given; dt is the duration of the whole load path
    real(wp), intent(in) :: start(3), target(3)     !! given values at both ends, as of `advance`
    type(walk_type), intent(inout) :: walk          !! step size and scales
    real(wp), intent(inout) :: at                   !! fraction of the load path, before -> after
    type(point_type), intent(inout) :: point        !! the point, before -> after
    real(wp), intent(out) :: at_middle              !! fraction of the load path of the middle, <= `at`
    type(point_type), intent(out) :: middle         !! the point there
    integer, intent(out) :: iterations(2)           !! Newton iterations to the middle and from there to the end
    real(wp), intent(out) :: reached                !! 1, or below: equilibrium lost
    type(report_type), intent(out) :: reports(2)    !! what happened in both increments
    type(point_type) :: ending, previous, whole
    type(rate_type) :: rates(3)
    type(report_type) :: report
    real(wp) :: error, least, line, next, shorter, size, switch
    integer :: used
    logical :: checks(2), landed, last, located, single, switches(2), viscous

    viscous = joint%material%tau_v > 0.0_wp .and. control%dt > 0.0_wp
    least = max(least_size*walk%tolerance, least_step)
    line = 0.0_wp
    switches = .false.
    size = min(walk%size, largest_size)
    if (.not. at > 0.0_wp) then
      ! the control or the direction may have changed
      middle = point
      call solve_to(at, at + probe*size, middle, used, reached, walk, report)
      walk%does = regime(joint, point, middle)
      walk%slid = slips(joint, point, middle)
      call find_rate(at, point, size, rates(1), walk)
      walk%rate = rates(1)
      ! a jump at the start of the load path
      if (distance(control, walk, middle%traction, middle%s, point) > 1.0_wp) size = least
    end if
    landed = .false.
    located = .false.
    switch = 0.0_wp
    do
      size = max(size, least)
      next = at + size
      if (.not. landed) next = whole_way(at, size)
      size = next - at
      last = size <= stretch*least
      at_middle = at + 0.5_wp*size
      whole = point
      middle = point
      iterations = 0
      ! Newton's method alone, if it converges: the full solver might use the two halves as sub-increments, and the
      ! difference would then be zero
      call solve_to(at, next, whole, used, reached, walk, report, plain_newton)
      single = .not. reached < 1.0_wp
      if (.not. single) then
        whole = point
        call solve_to(at, next, whole, used, reached, walk, report)
      end if
      call solve_to(at, at_middle, middle, iterations(1), reached, walk, reports(1))
      ending = middle
      if (.not. reached < 1.0_wp) call solve_to(at_middle, next, ending, iterations(2), reached, walk, &
        reports(2))
      if (reached < 1.0_wp) then
        if (last) exit
        error = huge(error)
      else
        switches(1) = any(walk%does .neqv. regime(joint, point, middle)) .or. &
          slips_back(joint, walk%slid, slips(joint, point, middle), middle)
        switches(2) = any(regime(joint, point, middle) .neqv. regime(joint, middle, ending)) .or. &
          slips_back(joint, slips(joint, point, middle), slips(joint, middle, ending), ending)
        single = single .and. maxval(reports%parts) == 1
        error = end_error(joint, control, walk, size, point, whole, middle, ending, single, any(switches))
        if (error <= 1.0_wp .or. last .or. .not. viscous) then
          rates(1) = walk%rate
          call find_rate(at_middle, middle, 0.5_wp*size, rates(2), walk)
          call find_rate(next, ending, 0.5_wp*size, rates(3), walk)
          line = lines_error(control, walk, size, point, middle, ending, switches .or. viscous, rates)
          error = max(error, line)
        end if
        if (last) exit
        if (error <= 1.0_wp) then
          checks = (switches .or. .not. single) .and. (line > suspicious .or. .not. all(rates%known))
          if (checks(1)) then
            call check(point, at, middle, at_middle, error, switch, iterations(1), walk)
            if (error <= 1.0_wp) then
              ending = middle
              call solve_to(at_middle, next, ending, iterations(2), reached, walk, reports(2))
              if (reached < 1.0_wp) error = huge(error)
            end if
          end if
          if (error <= 1.0_wp .and. checks(2)) call check(middle, at_middle, ending, next, error, switch, &
            iterations(2), walk)
          located = error > 1.0_wp
        end if
        if (error <= 1.0_wp) exit
        if (walk%lands .and. .not. located .and. error > search_threshold) then
          call first_switch(joint, control, start, target, at, next, point, walk, switch)
          located = .true.
        end if
      end if
      walk%rejected = walk%rejected + 1
      shorter = size*max(most_cut, safety/sqrt(error))
      landed = located .and. switch > at + shorter .and. stretch*(switch - at) < size
      size = merge(switch - at, shorter, landed)
    end do
    if (reached < 1.0_wp) then
      ! up to the last equilibrium
      walk%tried = next
      call solve_to(at, next, point, iterations(1), reached, walk, reports(1))
      at = at + reached*(next - at)
      at_middle = at
      middle = point
      reached = min(reached, 1.0_wp - epsilon(1.0_wp))
      return
    end if
    if (single) call extrapolate(viscous .and. .not. any(switches), point, whole, middle, ending)
    call keep_scales(control, ending, walk)
    walk%coarse = error > 1.0_wp
    walk%size = size*min(most_growth, safety/sqrt(max(error, tiny(error))))
    if (landed) walk%size = min(walk%size, max(size, shorter))
    walk%rate = rates(3)
    walk%does = regime(joint, middle, ending)
    walk%slid = slips(joint, middle, ending)
    if (single .and. .not. any(switches) .and. max(distance(control, walk, whole%traction, whole%s, ending), &
        state_difference(joint, walk, whole, ending)/walk%tolerance) > least_correction) then
      previous = ending
      call correct_state(joint, control, between(start, target, next), point, whole, previous, 1.0_wp, ending)
      call correct_state(joint, control, between(start, target, at_middle), point, whole, previous, 0.5_wp, middle)
    end if
    point = ending
    at = next

  contains

    !> Take a point from one fraction of the load path to another.
    pure subroutine solve_to(from, to, moved, used, reached, walk, report, method)
      real(wp), intent(in) :: from, to            !! fractions of the load path
      type(point_type), intent(inout) :: moved    !! the point
      integer, intent(out) :: used                !! Newton iterations
      real(wp), intent(out) :: reached            !! 1: complete
      type(walk_type), intent(inout) :: walk      !! counts the solves
      type(report_type), intent(out) :: report    !! what happened
      integer, intent(in), optional :: method     !! method of `advance`
      call advance(joint, share_of(control, to - from), between(start, target, from), between(start, target, to), &
        moved, used, reached, report=report, method=method)
      walk%solves = walk%solves + 1
      walk%updates = walk%updates + report%updates
    end subroutine solve_to

    !> Rates at a point: by its tangent, or with viscous damage, which also grows while the given values stay constant,
    !> by a short increment from the point.
    pure subroutine find_rate(from, point, size, rate, walk)
      real(wp), intent(in) :: from                !! fraction of the load path
      type(point_type), intent(in) :: point       !! the point
      real(wp), intent(in) :: size                !! of the increment before it, fraction of the load path
      type(rate_type), intent(out) :: rate        !! rates
      type(walk_type), intent(inout) :: walk      !! counts the solves
      !> Length of the short increment.
      real(wp), parameter :: short = 1.0e-3_wp
      type(point_type) :: moved
      type(report_type) :: report
      real(wp) :: given(3), reached
      integer :: used
      if (.not. viscous) then
        rate = rate_of(joint, control, target - start, point)
        return
      end if
      moved = point
      given = start + from*(target - start)
      call advance(joint, share_of(control, short*size), given, given + short*size*(target - start), moved, used, &
        reached, report=report, method=plain_newton)
      walk%solves = walk%solves + 1
      walk%updates = walk%updates + report%updates
      rate%known = .not. reached < 1.0_wp
      rate%s = (moved%s - point%s)/(short*size)
      rate%traction = (moved%traction - point%traction)/(short*size)
    end subroutine find_rate

    !> Solve an increment in which planes switch once more, divided at the switches, and compare the results with the
    !> line over the increment and with its end. They replace the first result, except for its energies, which are
    !> extrapolated. Equal states at both ends do not show what happens between them: where a slip passes zero, the
    !> planes of one side of the asperities open while those of the other side close.
    pure subroutine check(old, from, new, to, error, place, used, walk)
      type(point_type), intent(in) :: old        !! start of the increment
      type(point_type), intent(inout) :: new     !! its end -> that of the divided increment
      real(wp), intent(in) :: from, to           !! fractions of the load path
      real(wp), intent(inout) :: error           !! relative to the tolerance, increased
      real(wp), intent(inout) :: place           !! -> first switch, fraction of the load path
      integer, intent(inout) :: used             !! Newton iterations -> those of the divided increment
      type(walk_type), intent(inout) :: walk     !! counts the solves
      !> Smallest part of the increment between two switches that is divided.
      real(wp), parameter :: wide = 0.25_wp, narrow = 0.02_wp
      type(point_type) :: moved
      type(report_type) :: report
      real(wp) :: here, last, reached, shares(5)
      integer :: i, more, snaps, total
      if (distance(control, walk, old%traction, old%s, new) < least_change) return
      shares([2, 4]) = switch_shares(joint, old, new)
      if (shares(4) <= shares(2) + narrow) shares(4) = 0.5_wp*(1.0_wp + shares(2))
      shares(3) = 0.5_wp*(shares(2) + shares(4))
      ! viscous damage that stops growing at a switch does not grow at all in an increment up to it
      shares(1) = 0.5_wp*shares(2)
      shares(5) = 1.0_wp
      place = between(from, to, shares(2))
      moved = old
      last = from
      snaps = sum(reports%snaps)
      total = 0
      do i = 1, ubound(shares, 1)
        if (i == 1 .and. .not. viscous) cycle
        if (i == 3 .and. shares(4) <= shares(2) + wide) cycle
        here = between(from, to, shares(i))
        call solve_to(last, here, moved, more, reached, walk, report)
        total = total + more
        snaps = snaps + report%snaps
        last = here
        error = max(error, distance(control, walk, between(old%traction, new%traction, shares(i)), &
          between(old%s, new%s, shares(i)), moved))
        if (reached < 1.0_wp) then
          error = huge(error)
          return
        end if
      end do
      ! a snap is reported by the increment as it was
      if (snaps > 0) return
      moved%state([v_rupture, v_friction]) = new%state([v_rupture, v_friction])
      moved%work = new%work
      new = moved
      used = total
    end subroutine check

  end subroutine adaptive_step

  !> End of a step of the given size; the step is extended if a very small step to the target would remain.
  pure function whole_way(at, size) result(next)
    real(wp), intent(in) :: at, size   !! fractions of the load path
    real(wp) :: next
    next = at + size
    if (at + stretch*size >= 1.0_wp) then
      next = 1.0_wp
    else if (at + 2.0_wp*size > 1.0_wp) then
      next = 0.5_wp*(at + 1.0_wp)
    end if
  end function whole_way

  !> Given values at a fraction of the load path, exact at both ends.
  pure elemental function between(start, target, share) result(value)
    real(wp), intent(in) :: start, target   !! values at the ends
    real(wp), intent(in) :: share           !! 0 to 1
    real(wp) :: value
    value = start + share*(target - start)
    if (share >= 1.0_wp) value = target
  end function between

  !> Control of an increment over a fraction of the load path, with the same fraction of the duration.
  pure function share_of(control, share) result(part)
    type(control_type), intent(in) :: control   !! of the whole load path
    real(wp), intent(in) :: share               !! 0 to 1
    type(control_type) :: part
    part = control
    part%dt = share*control%dt
  end function share_of

  !> Fraction of the load path just beyond the first switch of a plane, 0: none is found.
  !>
  !> The switch is located by false position and bisection on the smallest margin, relative to the regime at the start.
  pure subroutine first_switch(joint, control, start, target, at, next, point, walk, switch)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given
    real(wp), intent(in) :: start(3), target(3)     !! given values at both ends
    real(wp), intent(in) :: at, next                !! fractions of the load path that bound the search
    type(point_type), intent(in) :: point           !! the point at `at`
    type(walk_type), intent(inout) :: walk          !! counts the solves
    real(wp), intent(out) :: switch                 !! fraction of the load path
    !> Largest number of solves; bisection alone would need 20 for the same accuracy.
    integer, parameter :: most = 30
    ! stop when the bracket is as narrow as the tolerance: the kink inside is then drawn within the tolerance
    real(wp), dimension(n_regimes, joint%pattern%n) :: far_margin, margin, near_margin
    real(wp) :: far, near, near_least, far_least, trial
    logical :: far_moved, far_moves, good, twice
    integer :: i

    switch = 0.0_wp
    near = at + probe*(next - at)
    call margins_at(near, near_margin, good, walk)
    if (.not. good) return
    far = next
    call margins_at(far, far_margin, good, walk)
    if (.not. good .or. all(far_margin >= 0.0_wp)) return
    far_moved = .false.
    twice = .false.
    do i = 1, most
      if (far - near <= walk%tolerance*(next - at)) exit
      ! only planes that have switched at the far end count
      near_least = minval(near_margin, mask=far_margin < 0.0_wp)
      far_least = minval(far_margin)
      if (near_least <= 0.0_wp) return
      trial = near + (far - near)*near_least/(near_least - far_least)
      ! bisect if the same end has moved twice: margins have kinks, and those of planes that just touch begin near zero
      if (twice .or. .not. (trial > near .and. trial < far)) trial = 0.5_wp*(near + far)
      call margins_at(trial, margin, good, walk)
      if (.not. good) return
      far_moves = any(margin < 0.0_wp .and. far_margin < 0.0_wp)
      if (far_moves) then
        far = trial
        far_margin = margin
      else
        near = trial
        near_margin = margin
      end if
      twice = i > 1 .and. (far_moves .eqv. far_moved) .and. .not. twice
      far_moved = far_moves
    end do
    switch = far

  contains

    !> Margins of the planes at a fraction of the load path; a margin is negative if the regime is not that of the
    !> start.
    pure subroutine margins_at(share, margin, good, walk)
      real(wp), intent(in) :: share               !! of the load path
      real(wp), intent(out) :: margin(:, :)       !! of the regime of every plane
      logical, intent(out) :: good                !! whether there is equilibrium
      type(walk_type), intent(inout) :: walk      !! counts the solves
      real(wp) :: reached
      type(point_type) :: moved
      type(report_type) :: report
      integer :: used
      moved = point
      call advance(joint, share_of(control, share - at), between(start, target, at), &
        between(start, target, share), moved, used, reached, report=report)
      walk%solves = walk%solves + 1
      walk%updates = walk%updates + report%updates
      good = .not. reached < 1.0_wp
      if (.not. good) return
      margin = criteria(joint, point, moved)
      margin = merge(margin, -margin, walk%does)
    end subroutine margins_at

  end subroutine first_switch

end module asperity_adaptive
