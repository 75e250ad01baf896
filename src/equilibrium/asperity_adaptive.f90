!> Adaptive increments: each step is solved as two halves and as one whole increment; their difference gives its size.
!>
!> The tolerance bounds the error of straight lines between the rows: tolerance*largest traction for the tractions, the
!> same fraction of the largest separation for the free separations, and likewise for rupture, friction and work by the
!> trapezoidal rule. The reported energies are extrapolated from both solutions and have a smaller error. The end of a
!> step alone does not show its error, because a single increment of the total law is often exact at its end. A step
!> that is too large, and in which a plane switches its regime, ends at the first switch (docs/solver.md).
module asperity_adaptive
  use asperity_contract, only: plane_statev, v_friction, v_rupture
  use asperity_control_point, only: control_type, point_type, whole_separation
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_law, only: kinematics_type, plane_kinematics
  use asperity_mixed_control, only: advance, plain_newton, report_type
  implicit none
  private
  public :: walk_type, new_walk, adaptive_step

  !> Range of the tolerance. A smaller one is below the errors of rounding and of the solver; a larger one has no
  !> effect.
  real(wp), parameter, public :: least_tolerance = 1.0e-8_wp, largest_tolerance = 0.1_wp

  !> Largest step, as a fraction of the load path to a target. An event that lasts for less than a step may be missed.
  real(wp), parameter :: largest_size = 0.125_wp
  !> Smallest step, as a multiple of the tolerance: a steeper change of the curve is drawn as a jump (snap).
  real(wp), parameter :: least_size = 1.0e-2_wp
  !> Smallest step, as a fraction of the load path: it gives as many rows as a step of fixed increments may have.
  real(wp), parameter :: least_step = 1.0e-7_wp
  !> Largest growth and cut of the step size, and safety factor on the tolerance.
  real(wp), parameter :: most_growth = 4.0_wp, most_cut = 0.1_wp, safety = 0.9_wp
  !> Error of the lines over the two halves, as a fraction of the distance from the middle to the line over the whole
  !> step: 1/4 on a parabola (0.3 is taken), up to 2 at a kink.
  real(wp), parameter :: smooth_share = 0.3_wp, kink_share = 2.0_wp
  !> Safety factor on the difference at the end of a step, because path errors of the slips accumulate over steps.
  real(wp), parameter :: path_share = 3.0_wp
  !> Relative error above which a switch is searched, instead of cutting the step to less than a third, and the largest
  !> number of planes for it. With more planes the search costs more than the rows it saves (docs/solver.md).
  real(wp), parameter :: search_threshold = 10.0_wp
  integer, parameter :: most_planes = 8
  !> Fraction of the step at which the regime of the planes at its start is evaluated.
  real(wp), parameter :: probe = 1.0e-6_wp

  !> Step control of a load path: tolerance, scales and step size.
  type :: walk_type
    real(wp) :: tolerance = 1.0e-3_wp  !! relative, least_tolerance to largest_tolerance
    real(wp) :: traction               !! scale: strength, or largest traction so far, stress
    real(wp) :: separation             !! scale: s_f, or largest separation of a free component so far, length
    real(wp) :: size = largest_size    !! next step, fraction of the load path to the target
    logical :: lands = .true.          !! whether rejected steps end at switches
    logical, allocatable :: does(:, :) !! regime of the planes at the start of the next step
    real(wp) :: tried = 0.0_wp         !! end of the last step tried, fraction of the load path
    integer :: solves = 0              !! increments solved, rejected ones included
    integer :: rejected = 0            !! steps rejected
  end type walk_type

contains

  !> Step control of a virgin point with zero traction.
  pure function new_walk(joint) result(walk)
    type(interface_type), intent(in) :: joint       !! the interface
    type(walk_type) :: walk
    associate (material => joint%material)
      walk%traction = material%k_n/sqrt(material%inv_s01_2)
      walk%separation = material%s0/(1.0_wp - material%eta)
    end associate
    walk%lands = joint%pattern%n <= most_planes
  end function new_walk

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
    type(point_type) :: ending, whole
    type(report_type) :: report
    real(wp) :: error, next, shorter, size, switch
    integer :: used
    logical :: landed, last, located, single, switched

    error = 0.0_wp
    single = .false.
    size = min(walk%size, largest_size)
    if (.not. at > 0.0_wp) then
      ! the control or the direction may have changed
      middle = point
      call solve_to(at, at + probe*size, middle, used, reached, walk%solves, reports(1))
      walk%does = regime(joint, point, middle)
    end if
    landed = .false.
    located = .false.
    switch = 0.0_wp
    shorter = 0.0_wp
    do
      next = at + size
      if (.not. landed) next = whole_way(at, size)
      size = next - at
      last = size <= max(least_size*walk%tolerance, least_step)
      at_middle = at + 0.5_wp*size
      whole = point
      middle = point
      iterations = 0
      ! Newton's method alone, if it converges: the full solver might use the two halves as sub-increments, and the
      ! difference would then be zero
      call solve_to(at, next, whole, used, reached, walk%solves, report, plain_newton)
      single = .not. reached < 1.0_wp
      if (.not. single) then
        whole = point
        call solve_to(at, next, whole, used, reached, walk%solves, report)
      end if
      call solve_to(at, at_middle, middle, iterations(1), reached, walk%solves, reports(1))
      ending = middle
      if (.not. reached < 1.0_wp) call solve_to(at_middle, next, ending, iterations(2), reached, walk%solves, &
        reports(2))
      if (reached < 1.0_wp) then
        if (last) exit
        error = 1.0_wp/most_cut**2
      else
        switched = any(walk%does .neqv. regime(joint, point, middle)) .or. &
          any(walk%does .neqv. regime(joint, middle, ending))
        single = single .and. maxval(reports%parts) == 1
        error = step_error(control, walk, path_weight(joint, control, size), point, whole, middle, ending, &
          switched, single)
        if (error <= 1.0_wp .or. last) exit
        if (walk%lands .and. .not. located .and. error > search_threshold) then
          call first_switch(joint, control, start, target, at, next, point, walk, switch)
          located = .true.
        end if
      end if
      walk%rejected = walk%rejected + 1
      shorter = size*max(most_cut, safety/sqrt(error))
      landed = located .and. switch > at + shorter .and. switch < next
      size = merge(switch - at, shorter, landed)
    end do
    if (reached < 1.0_wp) then
      ! up to the last equilibrium
      walk%tried = next
      call solve_to(at, next, point, iterations(1), reached, walk%solves, reports(1))
      at = at + reached*(next - at)
      at_middle = at
      middle = point
      reached = min(reached, 1.0_wp - epsilon(1.0_wp))
      return
    end if
    if (single) call extrapolate(point, whole, middle, ending)
    walk%traction = max(walk%traction, size_of(ending%traction))
    walk%separation = max(walk%separation, maxval(abs(ending%s), mask=control%traction))
    walk%size = size*min(most_growth, safety/sqrt(max(error, tiny(error))))
    if (landed) walk%size = min(walk%size, max(size, shorter))
    walk%does = regime(joint, middle, ending)
    point = ending
    at = next

  contains

    !> Take a point from one fraction of the load path to another.
    pure subroutine solve_to(from, to, moved, used, reached, solves, report, method)
      real(wp), intent(in) :: from, to            !! fractions of the load path
      type(point_type), intent(inout) :: moved    !! the point
      integer, intent(out) :: used                !! Newton iterations
      real(wp), intent(out) :: reached            !! 1: complete
      integer, intent(inout) :: solves            !! number of solves, increased
      type(report_type), intent(out) :: report    !! what happened
      integer, intent(in), optional :: method     !! method of `advance`
      call advance(joint, share_of(control, to - from), between(start, target, from), between(start, target, to), &
        moved, used, reached, report=report, method=method)
      solves = solves + 1
    end subroutine solve_to

  end subroutine adaptive_step

  !> End of a step of the given size; the step is extended if a very small step to the target would remain.
  pure function whole_way(at, size) result(next)
    real(wp), intent(in) :: at, size   !! fractions of the load path
    real(wp) :: next
    !> Largest factor by which a step is extended to reach the target.
    real(wp), parameter :: stretch = 1.01_wp
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

  !> Length of a vector.
  pure function size_of(v) result(length)
    real(wp), intent(in) :: v(3)   !! any
    real(wp) :: length
    length = sqrt(sum(v**2))
  end function size_of

  !> Weight of the difference at the end of a step. With viscous damage errors accumulate over the relaxation time, else
  !> only over a few steps of friction.
  pure function path_weight(joint, control, size) result(weight)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! dt is the duration of the whole load path
    real(wp), intent(in) :: size                    !! step, fraction of the load path
    real(wp) :: weight
    weight = path_share
    associate (tau_v => joint%material%tau_v)
      if (tau_v > 0.0_wp .and. control%dt > 0.0_wp) weight = max(weight, min(1.0_wp, tau_v/control%dt)/size)
    end associate
  end function path_weight

  !> Error of a step, relative to the tolerance.
  pure function step_error(control, walk, weight, old, whole, middle, ending, switched, single) result(error)
    type(control_type), intent(in) :: control                   !! what is given
    type(walk_type), intent(in) :: walk                         !! tolerance and scales
    real(wp), intent(in) :: weight                              !! of the difference at the end
    type(point_type), intent(in) :: old, whole, middle, ending  !! start, end in one increment, middle and end in two
    logical, intent(in) :: switched                             !! whether a plane switches within the step
    logical, intent(in) :: single                               !! whether no increment needed sub-increments
    real(wp) :: error
    real(wp) :: energy, separation, share, traction
    share = merge(kink_share, smooth_share, switched)
    traction = max(weight*size_of(whole%traction - ending%traction), &
                   share*size_of(middle%traction - 0.5_wp*(old%traction + ending%traction)))
    separation = maxval(merge(max(weight*abs(whole%s - ending%s), &
                                  share*abs(middle%s - 0.5_wp*(old%s + ending%s))), 0.0_wp, control%traction))
    energy = maxval(abs(spent(whole) - spent(ending)))
    traction = traction/max(walk%traction, size_of(ending%traction))
    separation = separation/max(walk%separation, maxval(abs(ending%s), mask=control%traction))
    energy = energy/max(tiny(1.0_wp), max(walk%traction, size_of(ending%traction))*(size_of(middle%s - old%s) &
      + size_of(ending%s - middle%s)))/3.0_wp
    ! if the step is smooth, the error after extrapolation is two orders smaller; not if sub-increments were needed
    if (.not. single) energy = 3.0_wp*energy
    if (single .and. .not. switched) energy = energy**2
    error = max(traction, separation, energy)/walk%tolerance
  end function step_error

  !> Remove the leading error of the trapezoidal rule from the energies of the two halves (Richardson extrapolation: the
  !> error of the whole increment is four times as large). The friction energy must not decrease.
  pure subroutine extrapolate(old, whole, middle, ending)
    type(point_type), intent(in) :: old, whole            !! start, end in one increment
    type(point_type), intent(inout) :: middle, ending     !! middle and end in two increments
    integer, parameter :: energies(2) = [v_rupture, v_friction]
    real(wp) :: correction(3)
    correction = (spent(ending) - spent(whole))/3.0_wp
    middle%state(energies) = middle%state(energies) + 0.5_wp*correction(:2)
    middle%work = middle%work + 0.5_wp*correction(3)
    ending%state(energies) = ending%state(energies) + correction(:2)
    ending%work = ending%work + correction(3)
    middle%state(v_friction) = max(middle%state(v_friction), old%state(v_friction))
    ending%state(v_friction) = max(ending%state(v_friction), middle%state(v_friction))
  end subroutine extrapolate

  !> Energies that are sums by the trapezoidal rule: rupture, friction, work, stress*length.
  pure function spent(point) result(energies)
    type(point_type), intent(in) :: point   !! the point
    real(wp) :: energies(3)
    energies = [point%state(v_rupture), point%state(v_friction), point%work]
  end function spent

  !> Regime of every plane in an increment: in contact, sliding in contact, damage growing, fully damaged.
  pure function regime(joint, old, new) result(does)
    type(interface_type), intent(in) :: joint       !! the interface
    type(point_type), intent(in) :: old, new        !! start and end of the increment
    logical :: does(4, joint%pattern%n)
    does = criteria(joint, old, new) > 0.0_wp
  end function regime

  !> Margins of the regime of every plane; a margin is positive if the plane is in contact, slides in contact, has
  !> growing damage or is fully damaged, in this order. Separations are relative to s0; damage (6), (7) and slip (38)
  !> are those of the law.
  pure function criteria(joint, old, new) result(margin)
    type(interface_type), intent(in) :: joint       !! the interface
    type(point_type), intent(in) :: old, new        !! start and end of the increment
    real(wp) :: margin(4, joint%pattern%n)
    !> Openings below this are rounding errors: a fully damaged plane without traction just touches.
    real(wp), parameter :: touching = 1.0e-10_wp
    type(kinematics_type) :: kinematics
    real(wp) :: alpha, r, reach, s(3)
    integer :: i, k
    s = whole_separation(new%s, new%state)
    associate (m => joint%material)
      do k = 1, joint%pattern%n
        i = plane_statev(k)
        alpha = old%state(i)
        kinematics = plane_kinematics(joint, k, s, new%state)
        associate (bond => kinematics%bond, contact => kinematics%contact)
          r = sqrt(m%inv_s01_2*max(bond(1), 0.0_wp)**2 + m%inv_s02_2*(bond(2)**2 + bond(3)**2))
          reach = sqrt((contact(2) - old%state(i + 1))**2 + (contact(3) - old%state(i + 2))**2) + &
            m%mu*m%kc_kt*contact(1)
          margin(1, k) = touching - contact(1)/m%s0
        end associate
        margin(2, k) = min(reach/m%s0, margin(1, k))
        margin(3, k) = r*(1.0_wp - m%eta*alpha) - 1.0_wp
        margin(4, k) = r*(1.0_wp - m%eta) - 1.0_wp
        ! the damage of a fully damaged plane does not grow
        if (alpha >= 1.0_wp) margin(3:4, k) = 1.0_wp
      end do
    end associate
  end function criteria

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
    real(wp), dimension(4, joint%pattern%n) :: far_margin, margin, near_margin
    real(wp) :: far, near, near_least, far_least, trial
    logical :: good
    integer :: i, side

    switch = 0.0_wp
    near = at + probe*(next - at)
    call margins_at(near, near_margin, good, walk%solves)
    if (.not. good) return
    far = next
    call margins_at(far, far_margin, good, walk%solves)
    if (.not. good .or. all(far_margin >= 0.0_wp)) return
    side = 0
    do i = 1, most
      if (far - near <= walk%tolerance*(next - at)) exit
      ! only planes that have switched at the far end count
      near_least = minval(near_margin, mask=far_margin < 0.0_wp)
      far_least = minval(far_margin)
      if (near_least <= 0.0_wp) return
      trial = near + (far - near)*near_least/(near_least - far_least)
      ! bisect if the same end moved twice: margins have kinks, and those of planes that just touch begin near zero
      if (abs(side) > 1 .or. .not. (trial > near .and. trial < far)) trial = 0.5_wp*(near + far)
      call margins_at(trial, margin, good, walk%solves)
      if (.not. good) return
      if (any(margin < 0.0_wp .and. far_margin < 0.0_wp)) then
        far = trial
        far_margin = margin
        side = merge(-1, min(side, 0) - 1, abs(side) > 1)
      else
        near = trial
        near_margin = margin
        side = merge(1, max(side, 0) + 1, abs(side) > 1)
      end if
    end do
    switch = far

  contains

    !> Margins of the planes at a fraction of the load path; a margin is negative if the regime is not that of the
    !> start.
    pure subroutine margins_at(share, margin, good, solves)
      real(wp), intent(in) :: share               !! of the load path
      real(wp), intent(out) :: margin(:, :)       !! of the regime of every plane
      logical, intent(out) :: good                !! whether there is equilibrium
      integer, intent(inout) :: solves            !! number of solves, increased
      real(wp) :: reached
      type(point_type) :: moved
      integer :: used
      moved = point
      margin = 0.0_wp
      call advance(joint, share_of(control, share - at), between(start, target, at), &
        between(start, target, share), moved, used, reached)
      solves = solves + 1
      good = .not. reached < 1.0_wp
      if (.not. good) return
      margin = criteria(joint, point, moved)
      margin = merge(margin, -margin, walk%does)
    end subroutine margins_at

  end subroutine first_switch

end module asperity_adaptive
