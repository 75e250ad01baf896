!> One point under mixed control: for each component either the separation or the traction is prescribed.
!>
!> The solver is a semismooth Newton method with a line search. It follows a branch of equilibria by sub-increments.
!> Where the branch ends, an overdamped motion leads to the next equilibrium: a snap (docs/solver.md, "Branch", "Snap").
module asperity_mixed_control
  use asperity_checks, only: all_bounded
  use asperity_contract, only: status_ok
  use asperity_control_point, only: balance_type, control_type, elastic_stiffness, evaluate, free_matrix, free_part, &
    ledger, move_point, new_point, point_type, set_balance, unstable, whole_separation
  use asperity_elimination, only: eliminate
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_newton, only: newton_solve, newton_type
  use asperity_call_checks, only: state_status
  use asperity_snap_motion, only: cannot_soften, farthest_rest, move_on, close_opening
  use asperity_tolerances, only: smallest_share, snap_resolution, unexplained, unexplained_share
  implicit none
  private
  public :: control_type, point_type, new_point, advance

  !> Methods: Newton alone; with halved increments; with continuation and motion through snaps.
  integer, parameter, public :: plain_newton = 1, halved_newton = 2, full_solver = 3
  !> End of an increment: complete, no equilibrium found, limit of updates reached, start or targets out of range.
  integer, parameter, public :: ended_complete = 0, ended_lost = 1, ended_limit = 2, ended_rejected = 3
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

  !> Definition of an increment.
  type :: path_type
    type(control_type) :: control        !! what is given
    real(wp) :: start(3), target(3)      !! given values at both ends
    real(wp) :: change(3)                !! target - start
  end type path_type

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
    integer :: chosen

    chosen = full_solver
    if (present(method)) chosen = method
    reached = 0.0_wp
    if (.not. all_bounded(3, target, largest_target)) then
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
      if (reached >= 1.0_wp) exit
      what%beyond = values_at(path, min(1.0_wp, reached + smallest_share))
      if (.not. any(control%traction)) then
        what%ended = ended_lost
      else if (what%updates < most_updates) then
        call jump(joint, control, what%beyond, point, what)
        if (what%ended == ended_complete) reached = min(1.0_wp, reached + smallest_share)
      end if
      if (reached < 1.0_wp .and. what%updates >= most_updates) what%ended = ended_limit
    end do
    iterations = what%iterations
    if (present(report)) report = what
  end subroutine advance

  !> Equations at a fraction of an increment, from the point at another fraction.
  pure subroutine set_share(joint, path, share, reached, balance)
    type(interface_type), intent(in) :: joint      !! the interface
    type(path_type), intent(in) :: path            !! the increment
    real(wp), intent(in) :: share                  !! 0 to 1
    real(wp), intent(in) :: reached                !! fraction at which the point at the start is
    type(balance_type), intent(inout) :: balance   !! the equations, the point at their start
    call set_balance(joint, path%control, values_at(path, share), balance)
    balance%control%dt = (share - reached)*path%control%dt
  end subroutine set_share

  !> Given values at a fraction of an increment.
  pure function values_at(path, share) result(values)
    type(path_type), intent(in) :: path   !! the increment
    real(wp), intent(in) :: share         !! 0 to 1
    real(wp) :: values(3)
    values = path%start + share*path%change
    if (share >= 1.0_wp) values = path%target
  end function values_at

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
    type(newton_type) :: result
    type(point_type) :: here, trial
    real(wp) :: next, share, step
    logical :: good

    ! if `share` is beyond the start, the state there is the result of Newton's method
    here%s = point%s
    here%tangent = point%tangent
    call move_point(point, balance%old)
    share = reached
    step = 1.0_wp
    do while (share < 1.0_wp .and. step >= smallest_share .and. what%updates < most_updates)
      next = min(1.0_wp, share + step)
      call set_share(joint, path, next, reached, balance)
      trial%s = here%s
      call newton_solve(joint, balance, .true., trial, result)
      call count_work(result, what)
      if (.not. result%converged) call solve_from_tangent(joint, balance, (next - share)*path%change, here, trial, &
        result, what)
      good = result%converged
      if (good) call check_branch(joint, balance, result, (next - share)*path%change, here%s, trial, good, what%updates)
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
      if (share < 1.0_wp) call set_share(joint, path, share, reached, balance)
      call close_opening(joint, balance, here, what%updates)
      call move_point(here, point)
      reached = share
      what%parts = what%parts + 1
    else
      call move_point(balance%old, point)
    end if
  end subroutine follow

  !> Newton's method, started from the separations that the tangent at the start of a step predicts. Started from the
  !> separations at the start of the step, it may open a stiff contact under a small pressure.
  pure subroutine solve_from_tangent(joint, balance, change, here, trial, result, what)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! equations of the step
    real(wp), intent(in) :: change(3)               !! of the given values in the step
    type(point_type), intent(in) :: here            !! the point at its start
    type(point_type), intent(inout) :: trial        !! -> the point at its end
    type(newton_type), intent(inout) :: result      !! result; `first` and `step` are those at the start of the step
    type(report_type), intent(inout) :: what        !! report so far
    real(wp) :: matrix(3, 3), step(3), work(3, 3)
    logical :: good
    matrix = free_matrix(balance, here)
    work = matrix
    step = free_part(balance, change - matmul(here%tangent, merge(0.0_wp, change, balance%control%traction)))
    call eliminate(balance%n, work, step, good)
    if (.not. good) return
    trial%s = here%s
    associate (free => balance%free(:balance%n))
      trial%s(free) = here%s(free) + step(:balance%n)
    end associate
    call newton_solve(joint, balance, .true., trial, result)
    call count_work(result, what)
    result%first = matrix
    result%step = step
  end subroutine solve_from_tangent

  !> Add iterations and updates of a solve to the report.
  pure subroutine count_work(result, what)
    type(newton_type), intent(in) :: result    !! of a solve
    type(report_type), intent(inout) :: what   !! report so far
    what%iterations = what%iterations + result%iterations
    what%updates = what%updates + result%updates
  end subroutine count_work

  !> Whether a converged step continues the branch of its start.
  !>
  !> The step continues the branch if the equilibria at both ends are stable and if the step agrees with the mean of the
  !> predictions by both tangents within `unexplained`. If the tangents differ much, the tangents on the straight line
  !> between the ends must be stable, too; with one free separation, no other equilibrium may lie on that line. Steps
  !> below `snap_resolution`*s0, and steps from states that cannot soften, are accepted without this test.
  pure subroutine check_branch(joint, balance, result, change, origin, point, good, updates)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! equations of the step
    type(newton_type), intent(in) :: result         !! of Newton's method
    real(wp), intent(in) :: change(3)               !! of the given values in the step
    real(wp), intent(in) :: origin(3)               !! separation at the start of the step, length
    type(point_type), intent(in) :: point           !! at the end of the step
    logical, intent(out) :: good                    !! whether the step continues the branch
    integer, intent(inout) :: updates               !! of the law
    !> Change of the tangent, relative to the first one, below which Newton's method is certain to stay on the branch:
    !> half of Kantorovich's bound.
    real(wp), parameter :: half = 0.5_wp
    !> Test points on the line between the ends: smallest and largest number, and their distance as a fraction of s0.
    integer, parameter :: least_looks = 7, most_looks = 63
    real(wp), parameter :: distance = 1.0_wp/16.0_wp
    type(point_type) :: between
    real(wp) :: extent, from(3), last(3), matrix(3, 3), move(3), r(3), r_first, s0, scale, stiffness, x(3)
    integer :: i, k, looks, n
    logical :: solved

    n = balance%n
    good = .true.
    if (n == 0 .or. result%iterations == 0) return
    stiffness = elastic_stiffness(joint)
    s0 = joint%material%s0
    from = free_part(balance, origin)
    move = free_part(balance, point%s) - from
    good = .not. unstable(n, result%last, stiffness) .and. maxval(abs(point%s)) <= farthest_rest(joint, balance)
    if (.not. good .or. maxval(abs(move)) <= snap_resolution*s0) return
    good = result%stable
    if (.not. good) return
    if (cannot_soften(joint, balance%old)) return
    ! the step that the tangent at the end predicts
    last = free_part(balance, change - matmul(point%tangent, merge(0.0_wp, change, balance%control%traction)))
    matrix = result%last
    call eliminate(n, matrix, last, good)
    ! with viscous damage no plane is ever fully damaged: the tolerance grows with the separation
    extent = s0
    if (joint%material%tau_v > 0.0_wp .and. balance%control%dt > 0.0_wp) extent = max(s0, &
      maxval(abs(whole_separation(origin, point%state)), mask=balance%control%traction))
    if (good) good = maxval(abs(move - 0.5_wp*(result%step + last))) <= max(unexplained*extent, &
      unexplained_share*maxval(abs(change)/merge(stiffness, 1.0_wp, balance%control%traction)))
    if (.not. good) return
    solved = .false.
    do k = 1, n
      matrix = result%first
      x = result%last(:, k) - result%first(:, k)
      call eliminate(n, matrix, x, solved)
      if (solved) solved = sum(abs(x)) <= half
      if (.not. solved) exit
    end do
    if (solved) return
    looks = max(least_looks, min(most_looks, ceiling(maxval(abs(move))/(distance*s0))))
    r_first = 0.0_wp
    do i = 0, looks
      updates = updates + 1
      x = from + (real(i, wp)/real(looks + 1, wp))*move
      call evaluate(joint, balance, x, between, r, scale, good)
      if (.not. good) return
      if (i == 0) r_first = r(1)
      good = .not. unstable(n, free_matrix(balance, between), stiffness)
      if (n == 1) good = good .and. r(1)*r_first >= 0.0_wp
      if (.not. good) return
    end do
  end subroutine check_branch

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
