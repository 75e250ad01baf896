!> One point under mixed control: some components of the separation given, for the others the traction.
!>
!> Semismooth Newton with a line search, continuation along the branch by parts of the increment, and where the branch
!> ends the overdamped motion to the next equilibrium: a snap (docs/solver.md, "Branch" and "Snap").
module mixed_control
  use asperity_checks, only: bounded
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use control_point, only: balance_type, control_type, evaluate, free_matrix, new_balance, new_point, point_type, &
    released_energy, residual_tolerance, solve_linear, unstable, whole_separation
  use newton, only: max_iterations, newton_solve, newton_type, stiffness_scale
  use snap_motion, only: cannot_soften, farthest_rest, move_on, settle
  implicit none
  private
  public :: control_type, point_type, new_point, advance, direction_vector, confined_slip, max_iterations, &
    residual_tolerance

  !> Methods: Newton alone; with halved increments; with continuation and motion through snaps.
  integer, parameter, public :: plain_newton = 1, halved_newton = 2, full_solver = 3
  !> How an increment ended: complete, no equilibrium beyond, work limit, targets that are no numbers or out of range.
  integer, parameter, public :: ended_complete = 0, ended_lost = 1, ended_limit = 2, ended_rejected = 3
  !> Most updates of the law in an increment.
  integer, parameter, public :: most_updates = 50000
  !> Smallest jump of a separation that is a snap, of s0.
  real(wp), parameter, public :: snap_resolution = 0.01_wp
  !> Part of a move that the tangents need not explain: of s0 (a tenth of the jump of RP-32), or of the change of what
  !> is given if that is more.
  real(wp), parameter :: unexplained = 0.01_wp, unexplained_share = 0.025_wp
  !> Smallest step along an increment that is tried: the place of a fold is known as well as that.
  real(wp), parameter :: min_fraction = 2.0_wp**(-20)
  !> Largest given value that is tried: differences of two stay finite.
  real(wp), parameter :: largest_target = 0.25_wp*huge(1.0_wp)

  !> What happened in an increment.
  type, public :: report_type
    integer :: ended = ended_complete
    integer :: iterations = 0            !! tangent solves
    integer :: updates = 0               !! of the law
    integer :: parts = 0                 !! parts that converged, 1: the increment was solved whole
    integer :: snaps = 0                 !! jumps from one branch to another
    real(wp) :: before(3) = 0.0_wp       !! separation (N, Tx, Ty) before the longest of them, length
    real(wp) :: after(3) = 0.0_wp        !! and after it
    real(wp) :: released = 0.0_wp        !! energy that all of them set free, stress*length
    real(wp) :: beyond(3) = 0.0_wp       !! given values for which no equilibrium was found
  end type report_type

  !> An increment.
  type :: path_type
    type(control_type) :: control        !! what is given
    real(wp) :: start(3) = 0.0_wp        !! given values
    real(wp) :: target(3) = 0.0_wp
  end type path_type

contains

  !> Take a point from the given values `start` to `target`.
  !>
  !> The increment is solved whole, from the state at its start, wherever the branch of equilibria goes on: Newton's
  !> result is taken if the tangents explain it, else the branch is followed with smaller steps of the given values.
  !> Where the branch ends the point moves on to the first rest under what is held, a part of its own. If there is
  !> none it stays at the last equilibrium and `reached` is below 1.
  pure subroutine advance(joint, control, start, target, point, iterations, reached, parts, residuals, report, &
                          method)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given
    real(wp), intent(in) :: start(3)                !! given values now: separation, or traction + spring*separation
    real(wp), intent(in) :: target(3)               !! given values at the end
    type(point_type), intent(inout) :: point        !! the point, start -> end
    integer, intent(out) :: iterations              !! Newton iterations over all parts, failed ones included
    real(wp), intent(out) :: reached                !! share of the increment that converged, 1: all
    integer, intent(out), optional :: parts         !! parts that converged, 1: the increment was solved whole
    real(wp), intent(out), optional :: residuals(0:max_iterations)   !! of the last solve, relative to the scale of
                                                                     !! `residual_tolerance`; -1 where none was needed
    type(report_type), intent(out), optional :: report   !! what happened
    integer, intent(in), optional :: method         !! plain_newton, halved_newton or full_solver (the default)
    type(report_type) :: what
    type(balance_type) :: balance
    type(newton_type) :: result
    type(path_type) :: path
    integer :: chosen

    chosen = full_solver
    if (present(method)) chosen = method
    path = path_type(control, start, target)
    reached = 0.0_wp
    if (.not. all(bounded(target, largest_target))) then
      what%ended = ended_rejected
    else if (chosen /= full_solver) then
      call halve(joint, path, merge(1.0_wp, min_fraction, chosen == plain_newton), point, reached, what, result)
    end if
    do while (chosen == full_solver .and. reached < 1.0_wp .and. what%ended == ended_complete)
      call follow(joint, path, point, reached, what, result)
      if (reached >= 1.0_wp) exit
      balance = new_balance(control, values_at(path, min(1.0_wp, reached + min_fraction)), point)
      what%beyond = balance%given
      if (balance%n == 0) then
        what%ended = ended_lost
      else if (what%updates < most_updates) then
        call jump(joint, balance, point, what)
        if (what%ended == ended_complete) reached = min(1.0_wp, reached + min_fraction)
      end if
      if (reached < 1.0_wp .and. what%updates >= most_updates) what%ended = ended_limit
    end do
    iterations = what%iterations
    if (present(parts)) parts = what%parts
    if (present(residuals)) residuals = result%history
    if (present(report)) report = what
  end subroutine advance

  !> Equations at a share of an increment, from the point at another; without viscous damage no time is needed.
  pure function balance_at(path, share, reached, point) result(balance)
    type(path_type), intent(in) :: path    !! the increment
    real(wp), intent(in) :: share          !! 0 to 1
    real(wp), intent(in) :: reached        !! share of the point
    type(point_type), intent(in) :: point  !! where the equations start
    type(balance_type) :: balance
    balance = new_balance(path%control, values_at(path, share), point)
    balance%control%dt = (share - reached)*path%control%dt
  end function balance_at

  !> Given values at a share of an increment.
  pure function values_at(path, share) result(values)
    type(path_type), intent(in) :: path   !! the increment
    real(wp), intent(in) :: share         !! 0 to 1
    real(wp) :: values(3)
    values = path%start + share*(path%target - path%start)
    if (share >= 1.0_wp) values = path%target
  end function values_at

  !> Newton's method alone, the increment halved where it does not converge: what the full solver is measured against.
  pure subroutine halve(joint, path, least, point, reached, what, result)
    type(interface_type), intent(in) :: joint       !! the interface
    type(path_type), intent(in) :: path             !! the increment
    real(wp), intent(in) :: least                   !! smallest part that is tried
    type(point_type), intent(inout) :: point        !! the point, start -> end
    real(wp), intent(inout) :: reached              !! share that converged
    type(report_type), intent(inout) :: what        !! what happened
    type(newton_type), intent(out) :: result        !! of the last solve
    type(balance_type) :: balance
    type(point_type) :: trial
    real(wp) :: fraction, next
    fraction = 1.0_wp
    do while (reached < 1.0_wp .and. fraction >= least .and. what%updates < most_updates)
      next = min(1.0_wp, reached + fraction)
      balance = balance_at(path, next, reached, point)
      what%beyond = balance%given
      trial = point
      call newton_solve(joint, balance, .false., trial, result)
      call count_work(result, what)
      if (result%converged) then
        call settle(joint, balance, trial, what%updates)
        point = trial
        reached = next
        what%parts = what%parts + 1
        fraction = 2.0_wp*fraction
      else
        fraction = 0.5_wp*fraction
      end if
    end do
    if (reached < 1.0_wp) what%ended = merge(ended_limit, ended_lost, what%updates >= most_updates)
  end subroutine halve

  !> Follow the branch as far as it goes, in one part: the state at its start is that of the point.
  pure subroutine follow(joint, path, point, reached, what, result)
    type(interface_type), intent(in) :: joint       !! the interface
    type(path_type), intent(in) :: path             !! the increment
    type(point_type), intent(inout) :: point        !! the point at `reached` -> at the new `reached`
    real(wp), intent(inout) :: reached              !! share that converged
    type(report_type), intent(inout) :: what        !! what happened
    type(newton_type), intent(out) :: result        !! of the last solve
    type(balance_type) :: balance, last
    type(point_type) :: here, trial
    real(wp) :: next, share, step
    logical :: good

    here = point
    share = reached
    step = 1.0_wp
    do while (share < 1.0_wp .and. step >= min_fraction .and. what%updates < most_updates)
      next = min(1.0_wp, share + step)
      balance = balance_at(path, next, reached, point)
      trial = here
      call newton_solve(joint, balance, .true., trial, result)
      call count_work(result, what)
      if (.not. result%converged) call solve_from_tangent(joint, balance, &
        (next - share)*(path%target - path%start), here, trial, result, what)
      good = result%converged
      if (good) call check_branch(joint, balance, result, (next - share)*(path%target - path%start), here%s, &
        trial, good, what%updates)
      if (good) then
        here = trial
        share = next
        last = balance
        step = 2.0_wp*step
      else
        step = 0.5_wp*min(step, 1.0_wp - share)
      end if
    end do
    if (.not. share > reached) return
    call settle(joint, last, here, what%updates)
    point = here
    reached = share
    what%parts = what%parts + 1
  end subroutine follow

  !> Newton's method from where the tangent at the start of a part points: a contact that is stiff and hardly pressed
  !> would be lost from the separations of the start.
  pure subroutine solve_from_tangent(joint, balance, change, here, trial, result, what)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! equations of the part
    real(wp), intent(in) :: change(3)               !! of the given values in the part
    type(point_type), intent(in) :: here            !! the point at the start of the part
    type(point_type), intent(inout) :: trial        !! -> the point at its end
    type(newton_type), intent(inout) :: result      !! what came out; steps are told from the start of the part
    type(report_type), intent(inout) :: what        !! what happened so far
    real(wp) :: given(3), matrix(3, 3), r(3), step(3)
    integer :: n
    logical :: good
    n = balance%n
    matrix = free_matrix(balance, here)
    given = merge(0.0_wp, change, balance%control%traction)
    r = change - matmul(here%tangent, given)
    associate (free => balance%free(:n))
      call solve_linear(n, matrix, r(free), step, good)
      if (.not. good) return
      trial = here
      trial%s(free) = here%s(free) + step(:n)
    end associate
    call newton_solve(joint, balance, .true., trial, result)
    call count_work(result, what)
    result%first = matrix
    result%step(:n) = step(:n)
  end subroutine solve_from_tangent

  !> Add the work of a solve.
  pure subroutine count_work(result, what)
    type(newton_type), intent(in) :: result    !! of a solve
    type(report_type), intent(inout) :: what   !! what happened so far
    what%iterations = what%iterations + result%iterations
    what%updates = what%updates + result%updates
  end subroutine count_work

  !> Whether a converged part continues the branch it started from.
  !>
  !> It does if the tangents at both ends are those of stable equilibria and explain the move: it is the mean of what
  !> they predict, within `unexplained`. Where they differ much, the tangents on the straight way must be stable, too,
  !> and where one separation is free, no equilibrium may be passed on it. A move too short to tell is taken, and so
  !> is any where no plane can soften.
  pure subroutine check_branch(joint, balance, result, change, origin, point, good, updates)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! equations of the part
    type(newton_type), intent(in) :: result         !! of Newton's method
    real(wp), intent(in) :: change(3)               !! of the given values in the part
    real(wp), intent(in) :: origin(3)               !! separation at the start of the part, length
    type(point_type), intent(in) :: point           !! at the end of the part
    logical, intent(out) :: good                    !! whether it does
    integer, intent(inout) :: updates               !! of the law
    !> Change of the tangent, relative to the first one, that Newton's method bears: half of what Kantorovich allows.
    real(wp), parameter :: half = 0.5_wp
    !> Looks at the way: at least, at most, and one for this share of s0.
    integer, parameter :: least_looks = 7, most_looks = 63
    real(wp), parameter :: distance = 1.0_wp/16.0_wp
    type(point_type) :: between
    real(wp) :: column(3), extent, first(3), from(3), last(3), move(3), r(3), r_first, s0, scale, stiffness
    integer :: i, looks, n
    logical :: solved

    n = balance%n
    good = .true.
    if (n == 0 .or. result%iterations == 0) return
    stiffness = stiffness_scale(joint)
    s0 = joint%material%s0
    associate (free => balance%free(:n))
      from(:n) = origin(free)
      move(:n) = point%s(free) - from(:n)
      good = .not. unstable(n, result%last, stiffness) .and. maxval(abs(point%s)) <= farthest_rest(joint, balance)
      if (.not. good .or. maxval(abs(move(:n))) <= snap_resolution*s0) return
      good = result%stable
      if (.not. good) return
      if (cannot_soften(joint, balance%old)) return
      r(:n) = matmul(point%tangent(free, :), merge(0.0_wp, change, balance%control%traction)) - change(free)
    end associate
    first(:n) = result%step(:n)
    call solve_linear(n, result%last, -r, last, good)
    ! viscous damage never is complete: separations grow by shares of themselves
    extent = s0
    if (joint%material%tau_v > 0.0_wp .and. balance%control%dt > 0.0_wp) extent = max(s0, &
      maxval(abs(whole_separation(origin, point%state)), mask=balance%control%traction))
    if (good) good = maxval(abs(move(:n) - 0.5_wp*(first(:n) + last(:n)))) <= max(unexplained*extent, &
      unexplained_share*maxval(abs(change)/merge(stiffness, 1.0_wp, balance%control%traction)))
    if (.not. good) return
    solved = .false.
    do i = 1, n
      call solve_linear(n, result%first, result%last(:n, i) - result%first(:n, i), column, solved)
      if (solved) solved = sum(abs(column(:n))) <= half
      if (.not. solved) exit
    end do
    if (solved) return
    between = point
    looks = max(least_looks, min(most_looks, ceiling(maxval(abs(move(:n)))/(distance*s0))))
    r_first = 0.0_wp
    do i = 0, looks
      updates = updates + 1
      r(:n) = from(:n) + (real(i, wp)/real(looks + 1, wp))*move(:n)
      call evaluate(joint, balance, r(:n), between, column(:n), scale, good)
      if (.not. good) return
      if (i == 0) r_first = column(1)
      good = .not. unstable(n, free_matrix(balance, between), stiffness)
      if (n == 1) good = good .and. column(1)*r_first >= 0.0_wp
      if (.not. good) return
    end do
  end subroutine check_branch

  !> No part of the increment continues the branch: the point moves on under the values held now.
  pure subroutine jump(joint, balance, point, what)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! equations of the smallest part
    type(point_type), intent(inout) :: point        !! the point -> at the next rest, if there is one
    type(report_type), intent(inout) :: what        !! what happened
    type(point_type) :: trial
    type(control_type) :: at_once
    real(wp) :: length
    integer :: used, updates
    logical :: found

    trial = point
    at_once = balance%control
    at_once%dt = 0.0_wp   ! a snap takes no time
    call move_on(joint, at_once, balance%given, most_updates - what%updates, trial, updates, used, found)
    what%updates = what%updates + updates
    what%iterations = what%iterations + used
    if (found) found = .not. flows_away(joint, balance, trial)
    if (.not. found) then
      what%ended = merge(ended_limit, ended_lost, what%updates >= most_updates)
      return
    end if
    what%parts = what%parts + 1
    length = maxval(abs(trial%s - point%s), mask=balance%control%traction)
    if (length > snap_resolution*joint%material%s0) then
      what%snaps = what%snaps + 1
      what%released = what%released + released_energy(balance, point, trial)
      if (length > maxval(abs(what%after - what%before))) then
        what%before = point%s
        what%after = trial%s
      end if
    end if
    point = trial
  end subroutine jump

  !> Whether a rest is one of many on a way without end: almost as far as what counts as running away, and no nearer
  !> than where the branch ended. With viscous damage every place is a rest if no time passes.
  pure function flows_away(joint, balance, point) result(yes)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! the equations, the end of the branch at their start
    type(point_type), intent(in) :: point           !! the rest
    logical :: yes
    !> A branch is followed in parts that are halved.
    real(wp), parameter :: almost = 0.5_wp
    real(wp) :: way
    way = maxval(abs(point%s))
    yes = way >= almost*farthest_rest(joint, balance) .and. way >= maxval(abs(balance%old%s))
  end function flows_away

  !> Unit vector (Tx, Ty) at an angle from Tx towards Ty; exact along the axes.
  pure function direction_vector(direction) result(e)
    real(wp), intent(in) :: direction   !! degrees
    real(wp) :: e(2)
    real(wp), parameter :: degree = acos(-1.0_wp)/180.0_wp
    real(wp) :: angle
    integer :: i, quarter
    angle = modulo(direction, 360.0_wp)
    quarter = nint(angle/90.0_wp)
    angle = (angle - 90.0_wp*real(quarter, wp))*degree
    e = [cos(angle), sin(angle)]
    do i = 1, modulo(quarter, 4)
      e = [0.0_wp - e(2), e(1)]
    end do
  end function direction_vector

  !> Confined slip test: the normal traction is applied to a virgin point at zero slip and held, then the point follows
  !> slips along a direction in the Tx-Ty plane, the slip across it being zero. With a stiffness the normal traction
  !> changes from there on by -stiffness times the change of s_N.
  !>
  !> Where equilibrium is lost the path ends: rows beyond n_done are zero.
  pure subroutine confined_slip(joint, direction, slips, sigma_n, preload, separation, traction, state, &
                                iterations, n_done, times, preload_time, reports, method, stiffness, work)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in) :: direction               !! from Tx towards Ty, degrees
    real(wp), intent(in) :: slips(:)                !! (T) slips in their order, length
    real(wp), intent(in) :: sigma_n                 !! normal traction, stress
    integer, intent(in) :: preload                  !! increments of the preload, >= 1 (100 for energies to four digits)
    real(wp), intent(out) :: separation(:, :)       !! (3, T) separation (N, Tx, Ty), length
    real(wp), intent(out) :: traction(:, :)         !! (3, T) traction (N, Tx, Ty), stress
    real(wp), intent(out) :: state(:, :)            !! (nstatv, T) STATEV
    integer, intent(out) :: iterations(:)           !! (T) Newton iterations
    integer, intent(out) :: n_done                  !! slips that converged; fewer than T: equilibrium lost;
                                                    !! -1: by the preload, or a direction that is no number
    real(wp), intent(in), optional :: times(:)      !! (T) of the slips from the end of the preload on, not decreasing,
                                                    !! time; absent: no time passes
    real(wp), intent(in), optional :: preload_time  !! duration of the preload, >= 0, time; absent: 0
    type(report_type), intent(out), optional :: reports(0:)   !! (0:T) what happened; 0: in the preload
    integer, intent(in), optional :: method         !! of `advance`
    real(wp), intent(in), optional :: stiffness     !! normal stiffness of the surroundings while the point slips (CNS),
                                                    !! >= 0, stress/length; absent: 0
    real(wp), intent(out), optional :: work(:)      !! (T) of the traction on the separation, the preload included,
                                                    !! stress*length
    type(control_type) :: control
    type(report_type) :: report
    type(point_type) :: point
    real(wp) :: start(3), target(3), now, reached
    integer :: i, used

    separation = 0.0_wp
    traction = 0.0_wp
    state = 0.0_wp
    iterations = 0
    if (present(work)) work = 0.0_wp
    n_done = -1
    if (.not. bounded(direction, huge(direction))) return
    control%traction(1) = .true.
    if (present(preload_time)) control%dt = preload_time/real(preload, wp)
    point = new_point(joint)
    target = 0.0_wp
    do i = 1, preload
      start = target
      target(1) = sigma_n*(real(i, wp)/real(preload, wp))
      call advance(joint, control, start, target, point, used, reached, report=report, method=method)
      if (present(reports)) reports(0) = joined(reports(0), report)
      if (reached < 1.0_wp) return
    end do
    n_done = 0
    if (present(stiffness)) control%spring(1) = stiffness
    ! the spring is at rest where the slip begins
    target(1) = target(1) + control%spring(1)*point%s(1)
    control%dt = 0.0_wp
    now = 0.0_wp
    do i = 1, size(slips)
      if (present(times)) then
        control%dt = times(i) - now
        now = times(i)
      end if
      start = target
      target(2:3) = slips(i)*direction_vector(direction)
      call advance(joint, control, start, target, point, iterations(i), reached, report=report, method=method)
      if (present(reports)) reports(i) = report
      if (reached < 1.0_wp) return
      separation(:, i) = point%s
      traction(:, i) = point%traction
      state(:joint%n_statev, i) = point%state
      if (present(work)) work(i) = point%work
      n_done = i
    end do
  end subroutine confined_slip

  !> Reports of two increments as one.
  pure function joined(first, second) result(both)
    type(report_type), intent(in) :: first, second   !! in turn
    type(report_type) :: both
    both = second
    both%iterations = first%iterations + second%iterations
    both%updates = first%updates + second%updates
    both%parts = first%parts + second%parts
    both%snaps = first%snaps + second%snaps
    both%released = first%released + second%released
    if (maxval(abs(first%after - first%before)) > maxval(abs(second%after - second%before))) then
      both%before = first%before
      both%after = first%after
    end if
  end function joined

end module mixed_control
