!> One increment of a point under mixed control: for each component either the separation or the traction is prescribed.
!>
!> The increment follows its curve of equilibria. Where the curve ends, a motion leads to the next equilibrium: a snap
!> (docs/solver.md).
module asperity_increment
  use asperity_checks, only: all_bounded
  use asperity_equations, only: control_type, ended_complete, ended_endless, ended_limit, ended_lost, ended_refused, &
    ended_rejected, equations_type, evaluate, farthest_equilibrium, is_unstiff, largest_move, may_go_on, &
    new_equations, new_point, ramp, report_type
  use asperity_equilibrium_path, only: falls, follow, open_joint
  use asperity_kinds, only: wp
  use asperity_newton, only: newton_solve, newton_type
  use asperity_point_law, only: call_type, point_law, point_type
  use asperity_tolerances, only: fast_growth, first_motion, imperfection, largest_imperfection, largest_target, &
    least_cut, least_damping, least_rupture, less_damping, more_damping, more_imperfection, most_cut, most_resumed, &
    most_tries, most_updates, residual_tolerance, shortest_motion, shortest_resumed, slow_growth, &
    smallest_fraction, smallest_part, snap_resolution, unbalanced
  implicit none
  private
  public :: call_type, control_type, point_type, report_type, new_point, advance, snap
  public :: ended_complete, ended_endless, ended_limit, ended_lost, ended_refused, ended_rejected

  !> A jump of the law: a free traction is below its prescribed value at one side of a separation and above it at the
  !> other, however near they are.
  type :: jump_type
    integer :: component = 0               !! of the traction; 0: none
    real(wp) :: place = 0.0_wp             !! separation of this component, length
    real(wp) :: sides(2) = 0.0_wp          !! traction at both sides, stress
  end type jump_type

contains

  !> Take a point from the prescribed values `start` to `target`.
  !>
  !> Where the law asks for a part of the increment, the increment is taken from its start again in such parts, as hosts
  !> divide increments for PNEWDT. A law that asks for less than the smallest part ends it.
  subroutine advance(law, control, start, target, point, reached, report, calls)
    class(point_law), intent(in) :: law             !! the law
    type(control_type), intent(in) :: control       !! what is prescribed
    real(wp), intent(in) :: start(3)                !! values at the start: separation or traction + spring*separation
    real(wp), intent(in) :: target(3)               !! values at the end
    type(point_type), intent(inout) :: point        !! the point, start -> end
    real(wp), intent(out) :: reached                !! fraction of the increment that converged, 1: complete
    type(report_type), intent(out) :: report        !! of all parts
    type(call_type), intent(inout), optional :: calls   !! place in a load path; attempts are counted; absent: in none
    type(call_type) :: place
    type(control_type) :: of_part
    type(report_type) :: last
    real(wp) :: converged, from(3), part, to(3)
    if (present(calls)) place = calls
    reached = 0.0_wp
    part = 1.0_wp
    from = start
    of_part = control
    do
      part = min(part, 1.0_wp - reached)
      to = ramp(start, target, reached + part)
      of_part%dt = part*control%dt
      place%attempt = place%attempt + 1
      call take_part(law, of_part, from, to, place, point, converged, last)
      report%iterations = report%iterations + last%iterations
      report%updates = report%updates + last%updates
      if (last%requested < 1.0_wp) then
        report%cut = .true.
        part = min(max(least_cut, last%requested), most_cut)*part
        if (part >= smallest_part) cycle
        report%ended = ended_refused
        exit
      end if
      if (maxval(abs(last%after - last%before)) > maxval(abs(report%after - report%before))) then
        report%before = last%before
        report%after = last%after
      end if
      report%parts = report%parts + last%parts
      report%snaps = report%snaps + last%snaps
      report%released = report%released + last%released
      report%ended = last%ended
      report%jumps = last%jumps
      report%sides = last%sides
      if (converged >= 1.0_wp .and. reached + part >= 1.0_wp) then
        reached = 1.0_wp
      else
        reached = reached + converged*part
      end if
      if (converged < 1.0_wp .or. reached >= 1.0_wp) exit
      from = to
    end do
    if (present(calls)) calls%attempt = place%attempt
  end subroutine advance

  !> Take a part of an increment, or all of it.
  !>
  !> As long as the curve of equilibria continues, it is one update from the state at its start. Where the curve ends,
  !> another one may start, as where time passes. Else the point moves under constant values to the first stable
  !> equilibrium, from which a further curve is followed. If there is none, the point stays at the last equilibrium, and
  !> `reached` is below 1. If the law asks for less, the point stays at the start.
  !>
  !> A part in which a joint falls by wear is taken again in steps whose energies balance. If these steps do not reach
  !> as far, the first result stands.
  subroutine take_part(law, control, start, target, call, point, reached, report)
    class(point_law), intent(in) :: law             !! the law
    type(control_type), intent(in) :: control       !! what is prescribed
    real(wp), intent(in) :: start(3), target(3)     !! values at both ends
    type(call_type), intent(in) :: call             !! place in a load path
    type(point_type), intent(inout) :: point        !! the point, start -> end
    real(wp), intent(out) :: reached                !! fraction of the part that converged, 1: complete
    type(report_type), intent(out) :: report        !! report
    type(equations_type) :: equations, fallen
    real(wp) :: fallen_reached
    reached = 0.0_wp
    if (.not. (all_bounded(size(target), target, largest_target) .and. law%admissible(point%state))) then
      report%ended = ended_rejected
      return
    end if
    call new_equations(control, start, target, point, equations, call)
    call take_increment(law, equations, reached)
    if (equations%fell) then
      fallen = equations
      fallen_reached = reached
      call new_equations(control, start, target, point, equations, call)
      equations%in_balance = .true.
      equations%report%iterations = fallen%report%iterations
      equations%report%updates = fallen%report%updates
      equations%report%requested = fallen%report%requested
      call take_increment(law, equations, reached)
      if (reached < fallen_reached .and. .not. equations%report%requested < 1.0_wp) then
        fallen%report%iterations = equations%report%iterations
        fallen%report%updates = equations%report%updates
        equations = fallen
        reached = fallen_reached
      end if
    end if
    if (.not. equations%report%requested < 1.0_wp) then
      call note_fall(law, equations, point)
      point = equations%old
    end if
    report = equations%report
  end subroutine take_part

  !> Take the increment of the equations.
  subroutine take_increment(law, equations, reached)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! at the start -> at the fraction that was reached
    real(wp), intent(out) :: reached                    !! this fraction, 1: complete
    type(jump_type) :: jump
    type(point_type) :: before, begin, lifted, stopped
    logical :: has_equilibrium, holds, resumes, stays_open
    integer :: resumed
    resumed = 0
    reached = 0.0_wp
    do while (reached < 1.0_wp)
      begin = equations%old
      call follow(law, equations)
      if (equations%report%requested < 1.0_wp) exit
      before = equations%old
      if (equations%done > reached) call close_opening(law, equations)
      if (may_fall(law, begin, before)) call note_snap(law, equations, before)
      ! a curve that starts here has its own duration: what takes time resists more in it
      resumes = law%rate_dependent .and. equations%control%dt > 0.0_wp .and. &
        equations%done - reached > shortest_resumed .and. resumed < most_resumed
      reached = equations%done
      if (reached >= 1.0_wp) exit
      resumed = merge(resumed + 1, 0, resumes)
      if (resumes) cycle
      if (has_jumps(law, equations)) then
        call follow_at_jump(law, equations, holds)
        reached = equations%done
        if (equations%report%requested < 1.0_wp) exit
        if (holds) cycle
      end if
      ! the fold lies within the smallest step; just beyond it two equilibria may be too close to be told apart
      before = equations%old
      equations%done = min(1.0_wp, reached + 2.0_wp*smallest_fraction)
      has_equilibrium = any(equations%control%traction) .and. may_go_on(equations)
      stays_open = .false.
      if (has_equilibrium) call snap(law, equations, has_equilibrium)
      stopped = equations%old
      if (.not. has_equilibrium .and. equations%control%traction(1)) then
        ! the motion may stop on its way to an open joint, which is in equilibrium without prescribed tractions, and
        ! stays open beyond the limit of updates
        stays_open = equations%report%updates >= most_updates .and. .not. any(abs(before%traction) > 0.0_wp)
        if (stays_open) equations%done = 1.0_wp
        equations%old = before
        lifted%s = before%s
        call open_joint(law, equations, equations%done, lifted, has_equilibrium)
        if (has_equilibrium) equations%old = lifted
      end if
      if (.not. has_equilibrium) then
        equations%report%ended = merge(ended_limit, ended_lost, equations%report%updates >= most_updates)
        if (law%discontinuous .and. equations%report%ended == ended_lost) then
          call find_jump(law, equations, stopped, 2.0_wp*shortest_motion*law%s_0, jump)
          equations%report%jumps = jump%component
          equations%report%sides = jump%sides
        end if
        equations%old = before
        exit
      end if
      equations%report%parts = equations%report%parts + 1
      equations%displaced = merge(min(more_imperfection*equations%displaced, largest_imperfection), imperfection, &
        largest_move(equations, before, equations%old) <= more_imperfection*equations%displaced*law%s_0)
      call close_opening(law, equations)
      if (.not. stays_open) call note_snap(law, equations, before)
      reached = equations%done
    end do
  end subroutine take_increment

  !> Move from the end of a curve of equilibria to the first stable equilibrium under constant prescribed values:
  !> pseudo-transient continuation, implicit Euler steps of an overdamped motion, which the state follows. It takes no
  !> time and wears nothing. The steps are at most s0/200, and grow. A motion that stops without an equilibrium has met
  !> a jump of the law.
  !>
  !> Where the point lies at a jump, and the traction pushes back from both sides, this component stays there as long as
  !> that holds: on an axis of symmetry the traction at the jump itself is the prescribed one.
  subroutine snap(law, equations, has_equilibrium)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! prescribed values at the fraction `done`, the point at the
                                                        !! end of the curve -> at the equilibrium, or where it ended
    logical, intent(out) :: has_equilibrium             !! whether there is an equilibrium
    type(newton_type) :: result
    type(point_type) :: trial
    type(jump_type) :: jump
    real(wp) :: anchor(3), damping, drift(3), ends(2), far, limit, move, sides(2)
    integer :: tries
    logical :: good, may_jump

    equations%moving = .true.
    limit = first_motion*law%s_0
    damping = law%stiffness
    drift = 0.0_wp
    ! with viscous damage there are equilibria at every separation, as no time passes
    far = farthest_equilibrium(law, equations, 0.5_wp)
    has_equilibrium = .false.
    may_jump = has_jumps(law, equations)
    if (may_jump) call find_jump(law, equations, equations%old, equations%displaced*law%s_0, jump)
    call displace(law, equations, jump)
    anchor = equations%old%s
    tries = 0
    do while (tries < most_tries .and. may_go_on(equations))
      ! is there an equilibrium near the point?
      equations%damping = 0.0_wp
      trial%s = equations%old%s
      call newton_solve(law, equations, equations%done, limit, trial, result)
      move = largest_move(equations, equations%old, trial)
      if (result%converged .and. result%stable .and. move <= limit .and. maxval(abs(trial%s)) <= far) then
        has_equilibrium = balances(law, equations%old, trial, move)
        if (has_equilibrium) exit
        limit = 0.5_wp*move
      end if
      ! start in the direction of the last step, so that the tangent of a sliding plane is that of sliding
      equations%damping = damping
      trial%s = equations%old%s + drift
      if (jump%component == 0) then
        call newton_solve(law, equations, equations%done, limit, trial, result)
      else
        call solve_at_jump(law, equations, jump, limit, trial, result)
      end if
      move = largest_move(equations, equations%old, trial)
      good = result%converged .and. result%stable .and. move <= limit
      tries = tries + 1
      if (good) good = balances(law, equations%old, trial, move)
      if (.not. good) then
        damping = more_damping*damping
        drift = 0.0_wp
        ! a jump may begin on the way, where no damping lets Newton's method converge
        if (may_jump .and. jump%component == 0 .and. .not. result%converged) then
          call find_jump(law, equations, equations%old, 2.0_wp*shortest_motion*law%s_0, jump)
          if (jump%component > 0) call displace(law, equations, jump)
        end if
        cycle
      end if
      drift = trial%s - equations%old%s
      equations%old = trial
      if (maxval(abs(equations%old%s - anchor)) > shortest_motion*law%s_0) then
        anchor = equations%old%s
        tries = 0
      end if
      damping = max(less_damping*damping, least_damping*law%stiffness)
      limit = min(law%bound, limit*merge(fast_growth, slow_growth, law%cannot_soften(equations%old%state) .or. &
        is_unstiff(equations%old)))
      if (maxval(abs(equations%old%s)) > far) exit
      if (jump%component == 0) cycle
      call look_across(law, equations, equations%old, equations%displaced*law%s_0, jump, ends, sides)
      if (jump%component == 0) call displace(law, equations, jump)
    end do
    if (has_equilibrium) equations%old = trial
    equations%damping = 0.0_wp
    equations%moving = .false.
  end subroutine snap

  !> Whether the work of a step equals the energy that it stores and dissipates within `unbalanced`, so that the
  !> energies of a row that contains a snap balance, or the step is very short. The error is that of the trapezoidal
  !> rule.
  pure function balances(law, old, new, length) result(yes)
    class(point_law), intent(in) :: law        !! the law
    type(point_type), intent(in) :: old, new   !! the point before and after the step
    real(wp), intent(in) :: length             !! of the step
    logical :: yes
    real(wp) :: change(2), unit, work
    change = law%accounts(new%state) - law%accounts(old%state)
    work = new%work - old%work
    unit = max(law%stress*law%s_0, abs(work) + sum(abs(change)))
    yes = abs(work - sum(change)) <= unbalanced*min(1.0_wp, length/law%s_0)*unit .or. &
      length <= shortest_motion*law%s_0
  end function balances

  !> Report a motion if it was long enough to be a snap.
  pure subroutine note_snap(law, equations, before)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the point after the motion; the report is set
    type(point_type), intent(in) :: before              !! the point before it
    real(wp) :: length, work(3)
    length = largest_move(equations, before, equations%old)
    if (length <= snap_resolution*law%s_0) return
    associate (after => equations%old, control => equations%control, report => equations%report)
      report%snaps = report%snaps + 1
      ! work of the prescribed tractions less that on the springs and the energy stored and dissipated (docs/solver.md)
      work = (ramp(equations%start, equations%target, equations%done) - 0.5_wp*control%spring*(before%s + after%s))* &
        (after%s - before%s)
      report%released = report%released + sum(work, mask=control%traction) - &
        sum(law%accounts(after%state) - law%accounts(before%state))
      if (length > maxval(abs(report%after - report%before))) then
        report%before = before%s
        report%after = after%s
      end if
    end associate
  end subroutine note_snap

  !> Start a motion a little beside an equilibrium, as a symmetric one that is unstable has no motion of its own. The
  !> motion has constant prescribed values from there on: the energies of their last change are not its own.
  subroutine displace(law, equations, jump)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! prescribed values at `done`, the point -> beside it
    type(jump_type), intent(in) :: jump                 !! where one component stays, if it is there
    type(point_type) :: trial
    real(wp) :: error, residual(3)
    trial%s = equations%old%s
    if (count(equations%control%traction) > 1) trial%s = trial%s + equations%displaced*law%s_0
    if (jump%component > 0) trial%s(jump%component) = jump%place
    call evaluate(law, equations, trial%s, equations%done, trial, residual, error)
    if (error < huge(error)) equations%old = trial
  end subroutine displace

  !> Whether a free component may lie at a jump beside other free ones.
  pure function has_jumps(law, equations) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    logical :: yes
    yes = law%discontinuous .and. count(equations%control%traction) > 1
  end function has_jumps

  !> Follow the curve of equilibria on which one component stays at a jump, as on an axis of symmetry, where the tangent
  !> is that of one side: there its traction is the prescribed one, and both sides push back to it. A curve at whose end
  !> this does not hold is not taken.
  subroutine follow_at_jump(law, equations, holds)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations, at `done` -> at the new `done`
    logical, intent(out) :: holds                       !! whether there is such a curve
    type(equations_type) :: at_jump, next
    type(jump_type) :: jump, last
    next = equations
    call find_jump(law, next, next%old, next%displaced*law%s_0, jump)
    holds = jump%component > 0
    if (holds) then
      at_jump = held(next, jump)
      call follow(law, at_jump)
      next%report = at_jump%report
      holds = at_jump%done > next%done
    end if
    if (holds) call check_balance(law, next, at_jump%done, at_jump%old, holds)
    if (holds) then
      next%old = at_jump%old
      next%done = at_jump%done
      call find_jump(law, next, next%old, next%displaced*law%s_0, last)
      holds = last%component == jump%component
    end if
    if (holds) equations = next
    equations%report = next%report
  end subroutine follow_at_jump

  !> Check whether a point carries all prescribed tractions.
  subroutine check_balance(law, equations, fraction, point, balanced)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; the update is counted
    real(wp), intent(in) :: fraction                    !! of the increment
    type(point_type), intent(in) :: point               !! the point
    logical, intent(out) :: balanced                    !! whether it is an equilibrium
    type(point_type) :: again
    real(wp) :: error, residual(3)
    call evaluate(law, equations, point%s, fraction, again, residual, error)
    balanced = error <= residual_tolerance
  end subroutine check_balance

  !> The same equations with the separation of one component prescribed at a jump.
  pure function held(equations, jump) result(at_jump)
    type(equations_type), intent(in) :: equations   !! the equations
    type(jump_type), intent(in) :: jump             !! the jump
    type(equations_type) :: at_jump
    at_jump = equations
    at_jump%control%traction(jump%component) = .false.
    at_jump%start(jump%component) = jump%place
    at_jump%target(jump%component) = jump%place
  end function held

  !> Step of a motion with the separation of one component at a jump.
  subroutine solve_at_jump(law, equations, jump, reach, point, result)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates and iterations are counted
    type(jump_type), intent(in) :: jump                 !! the jump
    real(wp), intent(in) :: reach                       !! length from the guess beyond which no solution is wanted
    type(point_type), intent(inout) :: point            !! guess -> the point at the end
    type(newton_type), intent(out) :: result            !! result
    type(equations_type) :: at_jump
    at_jump = held(equations, jump)
    call newton_solve(law, at_jump, equations%done, reach, point, result)
    equations%report = at_jump%report
  end subroutine solve_at_jump

  !> Find the largest jump of the law near a point.
  subroutine find_jump(law, equations, point, distance, jump)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! prescribed values at the fraction `done`; updates are counted
    type(point_type), intent(in) :: point               !! the point
    real(wp), intent(in) :: distance                    !! from which both sides push back, length
    type(jump_type), intent(out) :: jump                !! the jump
    !> Change of a traction over a change of the separation that is no stiffness, relative to the largest one.
    real(wp), parameter :: steepest = 100.0_wp
    type(jump_type) :: next
    real(wp) :: ends(2), height, nearest, residual, residuals(2), traction
    integer :: i
    nearest = 2.0_wp*spacing(max(maxval(abs(point%s)), law%s_0))
    ! across a steep but continuous place the change is that of a stiffness, or a rounding error
    height = 2.0_wp*steepest*max(law%largest_stiffness, maxval(abs(point%tangent)))*nearest
    do i = 1, 3
      if (.not. equations%control%traction(i)) cycle
      next = jump_type(i, point%s(i))
      call look_across(law, equations, point, distance, next, ends, residuals)
      if (next%component == 0) cycle
      ! a facet begins at zero without an offset
      if (ends(1) < 0.0_wp .and. ends(2) > 0.0_wp) next%place = 0.0_wp
      do while (ends(2) - ends(1) > nearest)
        call look(law, equations, point, i, next%place, residual, traction)
        if (.not. abs(residual) > 0.0_wp) exit
        ends(merge(1, 2, residual < 0.0_wp)) = next%place
        next%place = 0.5_wp*sum(ends)
      end do
      if (abs(next%place) <= nearest) next%place = 0.0_wp
      ! the place itself may have a third traction
      call look_across(law, equations, point, nearest, next, ends, residuals)
      if (next%component == 0) cycle
      if (residuals(2) - residuals(1) <= height) cycle
      height = residuals(2) - residuals(1)
      jump = next
    end do
  end subroutine find_jump

  !> Residual and traction at both sides of a jump; it is none if they do not push back.
  subroutine look_across(law, equations, point, distance, jump, ends, residuals)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! prescribed values at the fraction `done`; updates are counted
    type(point_type), intent(in) :: point               !! the other separations
    real(wp), intent(in) :: distance                    !! of the sides, length
    type(jump_type), intent(inout) :: jump              !! component and place -> sides, or no component
    real(wp), intent(out) :: ends(2)                    !! separations at both sides, length
    real(wp), intent(out) :: residuals(2)               !! residuals there, stress
    integer :: j
    ends = jump%place + [-1.0_wp, 1.0_wp]*distance
    do j = 1, 2
      call look(law, equations, point, jump%component, ends(j), residuals(j), jump%sides(j))
    end do
    if (.not. (residuals(1) < 0.0_wp .and. residuals(2) > 0.0_wp)) jump%component = 0
  end subroutine look_across

  !> Residual and traction of a free component at another separation of it.
  subroutine look(law, equations, point, i, s, residual, traction)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! prescribed values at the fraction `done`; updates are counted
    type(point_type), intent(in) :: point               !! the other separations
    integer, intent(in) :: i                            !! component
    real(wp), intent(in) :: s                           !! its separation, length
    real(wp), intent(out) :: residual, traction         !! stress; the residual of an equilibrium is 0
    type(point_type) :: at
    real(wp) :: error, r(3), x(3)
    x = point%s
    x(i) = s
    call evaluate(law, equations, x, equations%done, at, r, error)
    ! what counts as an equilibrium has no sign
    residual = 0.0_wp
    if (error*abs(r(i)) > residual_tolerance*maxval(abs(r))) residual = r(i)
    traction = at%traction(i)
  end subroutine look

  !> Report a fall by wear, compared with the point at the start of the increment.
  pure subroutine note_fall(law, equations, before)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the point at the end of the increment; the report is set
    type(point_type), intent(in) :: before              !! the point at its start
    associate (after => equations%old, report => equations%report)
      if (report%snaps > 0) return
      if (.not. falls(law, equations, before, after, equations%done)) return
      report%snaps = 1
      report%before = before%s
      report%after = after%s
      ! friction and wear take what was stored: what does not balance is the error of the steps
      report%released = after%work - before%work - sum(law%accounts(after%state) - law%accounts(before%state))
    end associate
  end subroutine note_fall

  !> If every plane is open and fully damaged and t_N is prescribed, every larger opening is an equilibrium, too. In
  !> that case move to the equilibrium with the smallest |s_N|.
  subroutine close_opening(law, equations)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the increment and its point
    type(point_type) :: trial
    logical :: in_equilibrium
    if (.not. equations%control%traction(1) .or. equations%control%spring(1) > 0.0_wp) return
    if (.not. is_unstiff(equations%old)) return
    trial%s = equations%old%s
    call open_joint(law, equations, equations%done, trial, in_equilibrium)
    if (in_equilibrium) equations%old = trial
  end subroutine close_opening

  !> Whether closing the opening after a part of an increment is a snap: the joint has broken in it, or did not rest on
  !> its contacts at its start.
  pure function may_fall(law, begin, end) result(yes)
    class(point_law), intent(in) :: law         !! the law
    type(point_type), intent(in) :: begin, end   !! the point at both ends of the part
    logical :: yes
    real(wp) :: spent(2)
    spent = law%accounts(end%state) - law%accounts(begin%state)
    yes = spent(2) > least_rupture*law%stress*law%s_0
    if (.not. yes .and. is_unstiff(end)) yes = begin%s(1) - law%contact_opening(begin%s, begin%state) > &
      snap_resolution*law%s_0
  end function may_fall

end module asperity_increment
