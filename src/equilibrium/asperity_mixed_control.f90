!> One point under mixed control: for each component either the separation or the traction is prescribed.
!>
!> The solver is a semismooth Newton method with a line search. It follows a branch of equilibria by sub-increments.
!> Where the branch ends, an overdamped motion leads to the next equilibrium: a snap (docs/solver.md, "Branch", "Snap").
module asperity_mixed_control
  use asperity_branch, only: balances, continue_branch, find_leap, settle
  use asperity_call_checks, only: state_status
  use asperity_checks, only: all_bounded
  use asperity_contract, only: status_ok
  use asperity_control_point, only: balance_type, control_type, ledger, move_point, new_point, point_type, &
    set_balance
  use asperity_increment, only: path_type, set_share, values_at
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_newton, only: newton_solve, newton_type
  use asperity_snap_motion, only: close_opening, farthest_rest, move_on
  use asperity_tolerances, only: smallest_share, snap_resolution
  implicit none
  private
  public :: control_type, point_type, new_point, advance

  !> Methods: Newton alone; with halved increments; with continuation and motion through snaps.
  integer, parameter, public :: plain_newton = 1, halved_newton = 2, full_solver = 3
  !> End of an increment: complete, no equilibrium found, limit of updates reached, start or targets out of range; of a
  !> branch (module asperity_arc): without end, divided.
  integer, parameter, public :: ended_complete = 0, ended_lost = 1, ended_limit = 2, ended_rejected = 3, &
    ended_endless = 4, ended_divided = 5
  !> Largest number of updates of the law in an increment.
  integer, parameter, public :: most_updates = 50000
  !> Largest given value, so that the difference of two is finite.
  real(wp), parameter :: largest_target = 0.25_wp*huge(1.0_wp)

  !> Report of an increment.
  type, public :: report_type
    integer :: ended = ended_complete
    integer :: iterations = 0            !! tangent solves
    integer :: updates = 0               !! of the law
    integer :: parts = 0                 !! sub-increments that converged
    integer :: snaps = 0                 !! jumps from one branch to another
    real(wp) :: before(3) = 0.0_wp       !! separation (N, Tx, Ty) before the longest of them, length
    real(wp) :: after(3) = 0.0_wp        !! separation after it, length
    real(wp) :: released = 0.0_wp        !! energy released by all of them, stress*length
    real(wp) :: beyond(3) = 0.0_wp       !! given values for which no equilibrium was found
  end type report_type

contains

  !> Take a point from the given values `start` to `target`.
  !>
  !> As long as the branch of equilibria continues, the increment is one update from the state at its start. The result
  !> of Newton's method is accepted if the tangents explain it; otherwise the branch is followed in smaller steps of the
  !> given values. Where the branch ends, the point moves under constant values to the first stable equilibrium; this
  !> motion is a sub-increment. If there is none, the point stays at the last equilibrium, and `reached` is below 1.
  pure subroutine advance(joint, control, start, target, point, iterations, reached, report, method)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given
    real(wp), intent(in) :: start(3)                !! values at the start: separation or traction + spring*separation
    real(wp), intent(in) :: target(3)               !! given values at the end
    type(point_type), intent(inout) :: point        !! the point, start -> end
    integer, intent(out) :: iterations              !! Newton iterations over all sub-increments, failed ones included
    real(wp), intent(out) :: reached                !! fraction of the increment that converged, 1: complete
    type(report_type), intent(out), optional :: report   !! report
    integer, intent(in), optional :: method         !! plain_newton, halved_newton or full_solver (the default)
    type(report_type) :: what
    type(path_type) :: path
    real(wp) :: next
    integer :: chosen

    chosen = full_solver
    if (present(method)) chosen = method
    reached = 0.0_wp
    if (.not. all_bounded(size(target), target, largest_target)) then
      what%ended = ended_rejected
    else if (state_status(joint, point%state) /= status_ok) then
      what%ended = ended_rejected
    else
      path = path_type(control, start, target, target - start)
      if (chosen /= full_solver) call halve(joint, path, merge(1.0_wp, smallest_share, chosen == plain_newton), point, &
        reached, what)
    end if
    do while (chosen == full_solver .and. reached < 1.0_wp .and. what%ended == ended_complete)
      call follow(joint, path, point, reached, what)
      if (reached >= 1.0_wp) cycle
      ! the fold lies within the smallest step; just beyond it two equilibria may be too close to be told apart
      next = min(1.0_wp, reached + 2.0_wp*smallest_share)
      what%beyond = values_at(path, next)
      if (.not. any(control%traction)) then
        what%ended = ended_lost
      else if (what%updates >= most_updates) then
        what%ended = ended_limit
      else
        call jump(joint, control, what%beyond, point, what)
        if (what%ended == ended_complete) reached = next
      end if
    end do
    iterations = what%iterations
    if (present(report)) report = what
  end subroutine advance

  !> Newton's method alone; the increment is halved if it does not converge. The full solver is compared with it.
  pure subroutine halve(joint, path, least, point, reached, what)
    type(interface_type), intent(in) :: joint       !! the interface
    type(path_type), intent(in) :: path             !! the increment
    real(wp), intent(in) :: least                   !! smallest sub-increment that is tried
    type(point_type), intent(inout) :: point        !! the point, start -> end
    real(wp), intent(inout) :: reached              !! fraction that converged
    type(report_type), intent(inout) :: what        !! report
    type(balance_type) :: balance
    type(newton_type) :: result
    type(point_type) :: trial
    real(wp) :: fraction, next
    fraction = 1.0_wp
    call move_point(point, balance%old)
    do while (reached < 1.0_wp .and. fraction >= least .and. what%updates < most_updates)
      next = min(1.0_wp, reached + fraction)
      call set_share(joint, path, next, reached, balance)
      what%beyond = balance%given
      trial%s = balance%old%s
      call newton_solve(joint, balance, .false., trial, result)
      call count_work(result, what)
      if (result%converged) then
        call close_opening(joint, balance, trial, what%updates)
        call move_point(trial, balance%old)
        reached = next
        what%parts = what%parts + 1
        fraction = 2.0_wp*fraction
      else
        fraction = 0.5_wp*fraction
      end if
    end do
    call move_point(balance%old, point)
    if (reached < 1.0_wp) what%ended = merge(ended_limit, ended_lost, what%updates >= most_updates)
  end subroutine halve

  !> Follow the branch to its end or to the target, as one sub-increment from the state of the point.
  pure subroutine follow(joint, path, point, reached, what)
    type(interface_type), intent(in) :: joint       !! the interface
    type(path_type), intent(in) :: path             !! the increment
    type(point_type), intent(inout) :: point        !! the point at `reached` -> at the new `reached`
    real(wp), intent(inout) :: reached              !! fraction that converged
    type(report_type), intent(inout) :: what        !! report
    type(balance_type) :: balance
    type(point_type) :: before, here, trial
    real(wp) :: next, place, share, step
    logical :: found, good

    ! if `share` is beyond the start, the state there is the result of Newton's method
    here%s = point%s
    here%tangent = point%tangent
    call move_point(point, balance%old)
    share = reached
    if (joint%material%wears) then
      call set_share(joint, path, share, reached, balance)
      call settle(joint, balance, most_updates, here, what%iterations, what%updates)
    end if
    step = 1.0_wp
    do while (share < 1.0_wp .and. step >= smallest_share .and. what%updates < most_updates)
      next = min(1.0_wp, share + step)
      call set_share(joint, path, next, reached, balance)
      call continue_branch(joint, balance, (next - share)*path%change, here, step < 2.0_wp*smallest_share, trial, &
        good, what%iterations, what%updates)
      if (good) then
        call move_point(trial, here)
        share = next
        step = 2.0_wp*step
      else
        step = 0.5_wp*min(step, 1.0_wp - share)
      end if
    end do
    if (share > reached) then
      ! the equations may still be those of a rejected step
      call set_share(joint, path, share, reached, balance)
      call close_opening(joint, balance, here, what%updates)
      if (.not. balances(joint, path, balance, here)) then
        before = balance%old
        call find_leap(joint, path, reached, share, before, place, found, what%iterations, what%updates, most_updates)
        if (found) share = place
        if (found) call move_point(before, here)
      end if
    end if
    if (share > reached) then
      call move_point(here, point)
      reached = share
      what%parts = what%parts + 1
    else
      call move_point(balance%old, point)
    end if
  end subroutine follow

  !> Add iterations and updates of a solve to the report.
  pure subroutine count_work(result, what)
    type(newton_type), intent(in) :: result    !! of a solve
    type(report_type), intent(inout) :: what   !! report so far
    what%iterations = what%iterations + result%iterations
    what%updates = what%updates + result%updates
  end subroutine count_work

  !> Move the point from the end of the branch to the next stable equilibrium under constant given values.
  pure subroutine jump(joint, control, given, point, what)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given
    real(wp), intent(in) :: given(3)                !! values at the end of the smallest step
    type(point_type), intent(inout) :: point        !! the point -> at that equilibrium, if there is one
    type(report_type), intent(inout) :: what        !! report
    type(balance_type) :: balance
    type(point_type) :: trial
    type(control_type) :: at_once
    real(wp) :: length
    integer :: used, updates
    logical :: found

    trial = point
    at_once = control
    at_once%dt = 0.0_wp   ! a snap takes no time
    call move_on(joint, at_once, given, most_updates - what%updates, trial, updates, used, found)
    what%updates = what%updates + updates
    what%iterations = what%iterations + used
    call set_balance(joint, control, given, balance)
    balance%old = point
    if (found) found = .not. flows_away(joint, balance, trial)
    if (.not. found) then
      what%ended = merge(ended_limit, ended_lost, what%updates >= most_updates)
      return
    end if
    what%parts = what%parts + 1
    length = maxval(abs(trial%s - point%s), mask=control%traction)
    if (length > snap_resolution*joint%material%s0) then
      what%snaps = what%snaps + 1
      what%released = what%released + released_energy(balance, point, trial)
      if (length > maxval(abs(what%after - what%before))) then
        what%before = point%s
        what%after = trial%s
      end if
    end if
    call move_point(trial, point)
  end subroutine jump

  !> Energy released by a motion under prescribed tractions, per unit area: the work of these tractions minus the work
  !> on the springs minus the energy that the interface stores and dissipates (docs/solver.md, "Snap").
  pure function released_energy(balance, old, new) result(energy)
    type(balance_type), intent(in) :: balance   !! what is given
    type(point_type), intent(in) :: old, new    !! before and after
    real(wp) :: energy
    real(wp) :: work(3)
    work = (balance%given - 0.5_wp*balance%control%spring*(old%s + new%s))*(new%s - old%s)
    energy = sum(work, mask=balance%control%traction) - sum(new%state(ledger) - old%state(ledger))
  end function released_energy

  !> Whether an equilibrium found with dt = 0 is spurious: with viscous damage no damage grows if no time passes, so
  !> that equilibria exist at every separation. It is spurious beyond half of `farthest_rest`, if it is not nearer than
  !> the end of the branch.
  pure function flows_away(joint, balance, point) result(yes)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! the equations, the end of the branch at their start
    type(point_type), intent(in) :: point           !! the equilibrium
    logical :: yes
    !> A branch is followed in steps that are halved.
    real(wp), parameter :: almost = 0.5_wp
    real(wp) :: distance
    distance = maxval(abs(point%s))
    yes = distance >= almost*farthest_rest(joint, balance) .and. distance >= maxval(abs(balance%old%s))
  end function flows_away

end module asperity_mixed_control
