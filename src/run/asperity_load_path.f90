!> Run of a load path: every call gives the row of the next increment.
module asperity_load_path
  use asperity_branch, only: branch_step, branch_type, new_branch
  use asperity_equations, only: control_type, ended_complete, ended_endless, ended_limit, ended_refused, &
    ended_rejected, ramp, report_type
  use asperity_kinds, only: wp
  use asperity_increment, only: advance
  use asperity_point_law, only: call_type, event_length, name_event, point_law, point_type
  use asperity_stability, only: falling_direction
  use asperity_steps, only: component_names, step_type
  use asperity_text, only: append, integer_text, short, to_text
  use asperity_tolerances, only: endless, farthest, largest_arc, most_branch_steps, most_updates, smallest_part
  implicit none
  private
  public :: start_run, next_row, begin_row, end_row, set_point, name_events, explain_account, explain_end

  !> Difference of work and energies, over the largest of them, above which a path has a warning. It is of second order
  !> in the increment, and less than 0.001 in the figures of the paper.
  real(wp), parameter :: least_difference = 0.02_wp

  !> A row: the point at the end of an increment, without its state.
  type, public :: row_head
    integer :: step = 0, increment = 0               !! from 1; the increment counts in its step
    integer :: done = 0                              !! increments of the path so far, along a branch in proportion
    real(wp) :: position = 0.0_wp                    !! targets reached before, and the fraction of the next one
    real(wp) :: time = 0.0_wp
    real(wp) :: s(3) = 0.0_wp                        !! separation (N, Tx, Ty), length
    real(wp) :: traction(3) = 0.0_wp                 !! total, stress
    real(wp) :: tangent(3, 3) = 0.0_wp               !! d traction_i/d s_j, stress/length
    real(wp) :: p = 0.0_wp                           !! water pressure, by which the law carries more than the total t_N
    real(wp) :: work = 0.0_wp                        !! of the traction without water so far, stress*length
    type(report_type) :: report = report_type()      !! of the increment
    logical :: turn = .false.                        !! the prescribed values turn back, or forward again
    logical :: fork = .false.                        !! another branch crosses that which is followed
    logical :: lost = .false.                        !! no equilibrium was found beyond this row
    character(len=event_length) :: events = ""       !! names joined by +
  end type row_head

  !> A row with its state.
  type, extends(row_head), public :: row_type
    real(wp), allocatable :: state(:)                !! STATEV
  end type row_type

  !> What an increment prescribes. Tractions are those of the law: the total normal traction and the water pressure.
  type, public :: increment_type
    type(control_type) :: control = control_type()
    real(wp) :: given(3) = 0.0_wp                    !! values at its end: separation, or traction + spring*separation
    integer :: number(2) = 0                         !! of the step and of the increment, from 1; 0: none has begun
  end type increment_type

  !> A run, and its last increment.
  type, extends(increment_type), public :: run_type
    class(point_law), allocatable :: law             !! any
    type(step_type), allocatable :: steps(:)         !! checked
    type(point_type) :: before, point                !! at the start and at the end of the last increment
    integer :: total = 0                             !! increments of all steps
    integer, private :: step = 0, target = 0, n = 0  !! where the run is: increment n to this target of this step
    integer, private :: passed = 0, earlier = 0      !! targets that were reached before, and their increments
    real(wp), private :: fraction = 1.0_wp           !! of the increments to the target
    real(wp), private :: time = 0.0_wp               !! at the target before
    real(wp), private :: from(3) = 0.0_wp, to(3) = 0.0_wp   !! prescribed values at the target before and at this one
    real(wp), private :: start(3) = 0.0_wp           !! prescribed values at the start of the last increment
    real(wp), private :: offset(3) = 0.0_wp          !! spring*separation at the start of the step
    real(wp), private :: p_from = 0.0_wp, p_to = 0.0_wp   !! water pressure at the target before and at this one
    type(branch_type), private :: branch             !! progress along the branch
    integer, private :: fork = 0                     !! side to which the step has still to leave its branch, 0: none
    integer, private :: forks = 0                    !! in the step so far
    logical, private :: unforked = .false.           !! a step has not left its branch, which ends the path
    real(wp), private :: first_work = 0.0_wp, first_energies = 0.0_wp   !! at the start of the path, stress*length
    real(wp), private :: difference = 0.0_wp         !! largest one of the changes of work and energies so far
    real(wp), private :: energy = 0.0_wp             !! largest change of work or energies so far
    type(row_type), allocatable :: rows(:)           !! if they have been computed before, as those of a refined path
    integer, private :: given_rows = 0               !! of them
    logical, allocatable, private :: regime(:, :)    !! for the events
    type(call_type), private :: calls                !! of the law, with the number of attempts so far
  end type run_type

contains

  !> Begin a run (not pure, as the law may be of any type).
  subroutine start_run(law, steps, run, start, p)
    class(point_law), intent(in) :: law                   !! the law
    type(step_type), intent(in) :: steps(:)               !! the load path, checked
    type(run_type), intent(out) :: run                    !! no row yet
    type(point_type), intent(in) :: start                 !! the point at its start
    real(wp), intent(in) :: p                             !! water pressure there, stress
    character(len=event_length) :: ignored
    integer :: i
    allocate (run%law, source=law)
    run%steps = steps
    do i = 1, size(steps)
      run%total = run%total + sum(steps(i)%increments)
    end do
    run%point = start
    call law%find_events(start%s, start%state, start%state, run%regime, ignored)
    run%given = run%point%s
    run%p_to = p
    run%first_work = start%work
    run%first_energies = sum(law%accounts(start%state))
  end subroutine start_run

  !> Take the next increment. After a row that is lost there is none, nor after a step that has not left its branch.
  subroutine next_row(run, row, has_row)
    type(run_type), intent(inout) :: run    !! the run
    type(row_type), intent(inout) :: row    !! the last row -> the next one
    logical, intent(out) :: has_row         !! false: the path has ended
    call begin_row(run, row, has_row)
    if (has_row) call end_row(run, row)
  end subroutine next_row

  !> Set what the next increment prescribes, without an update of the law.
  pure subroutine begin_row(run, row, has_row)
    type(run_type), intent(inout) :: run    !! the run
    type(row_type), intent(inout) :: row    !! the last row; at a new step its increments count from 0
    logical, intent(out) :: has_row         !! false: the path has ended
    integer :: parts
    if (allocated(run%rows)) then
      has_row = run%given_rows < size(run%rows)
      return
    end if
    has_row = .not. (row%lost .or. run%unforked) .and. run%step <= size(run%steps)
    if (has_row .and. .not. run%fraction < 1.0_wp) call next_target(run, row, has_row)
    if (.not. has_row) return
    run%before = run%point
    run%n = run%n + 1
    run%number = [run%step, row%increment + 1]
    run%calls%step = run%step
    run%calls%increment = row%increment + 1
    parts = run%steps(run%step)%increments(run%target)
    run%start = run%given
    if (run%steps(run%step)%arc > 0.0_wp) then
      run%given = run%to
    else
      run%given = run%from + (real(run%n, wp)*(run%to - run%from))/real(parts, wp)
      if (run%n == parts) run%given = run%to
      run%control%dt = run%steps(run%step)%durations(run%target)/real(parts, wp)
    end if
  end subroutine begin_row

  !> Take the increment that has begun.
  subroutine end_row(run, row)
    type(run_type), intent(inout) :: run    !! the run
    type(row_type), intent(inout) :: row    !! the last row -> the next one
    real(wp) :: reached
    integer :: parts
    logical :: branches
    if (allocated(run%rows)) then
      run%given_rows = run%given_rows + 1
      row = run%rows(run%given_rows)
      return
    end if
    parts = run%steps(run%step)%increments(run%target)
    branches = run%steps(run%step)%arc > 0.0_wp
    if (branches) then
      call branch_step(run%law, run%branch, run%point, row%report, run%calls)
      ! the largest load factor so far, so that time never decreases
      run%fraction = max(run%fraction, run%branch%factor)
      if (run%branch%left) run%fork = 0
      if (run%branch%forked) run%forks = run%forks + 1
    else
      call advance(run%law, run%control, run%start, run%given, run%point, reached, row%report, run%calls)
      run%fraction = ramp(run%fraction, real(run%n, wp)/real(parts, wp), reached)
    end if
    row%done = run%earlier + nint(run%fraction*real(parts, wp))
    row%time = ramp(run%time, run%time + run%steps(run%step)%durations(run%target), run%fraction)
    row%turn = branches .and. run%branch%turned
    row%fork = branches .and. run%branch%forked
    call set_point(row, run%point, ramp(run%p_from, run%p_to, merge(run%branch%factor, run%fraction, branches)))
    row%step = run%step
    row%increment = row%increment + 1
    row%position = real(run%passed - 1, wp) + run%fraction
    row%lost = row%report%ended /= ended_complete
    run%unforked = .not. (row%lost .or. run%fork == 0 .or. run%fraction < 1.0_wp) .and. &
      run%target == size(run%steps(run%step)%increments)
    call name_events(run%law, run%before%state, run%point%state, run%regime, row)
    if (.not. row%lost) call add_to_account(run)
  end subroutine end_row

  !> Compare the work of the path so far with its energies.
  pure subroutine add_to_account(run)
    type(run_type), intent(inout) :: run   !! the run, at the end of an increment
    real(wp) :: energies, work
    work = run%point%work - run%first_work
    energies = sum(run%law%accounts(run%point%state)) - run%first_energies
    run%difference = max(run%difference, abs(work - energies))
    run%energy = max(run%energy, abs(work), abs(energies))
  end subroutine add_to_account

  !> Set the point of a row.
  pure subroutine set_point(row, point, p)
    type(row_type), intent(inout) :: row     !! the row
    type(point_type), intent(in) :: point    !! its point
    real(wp), intent(in) :: p                !! its water pressure, stress
    row%s = point%s
    row%p = p
    row%traction = point%traction
    row%tangent = point%tangent
    row%traction(1) = point%traction(1) - p
    row%work = point%work
    row%state = point%state
  end subroutine set_point

  !> Begin the increments to the next target, if there is one.
  pure subroutine next_target(run, row, has_next)
    type(run_type), intent(inout) :: run    !! the run
    type(row_type), intent(inout) :: row    !! its last row; at a new step its increments count from 0
    logical, intent(out) :: has_next        !! whether there is one
    real(wp) :: arc
    logical :: begins
    begins = run%step == 0
    if (run%step > 0) then
      run%time = run%time + run%steps(run%step)%durations(run%target)
      run%earlier = run%earlier + run%steps(run%step)%increments(run%target)
      begins = run%target == size(run%steps(run%step)%increments)
    end if
    if (begins) then
      run%step = run%step + 1
      run%target = 0
    end if
    has_next = run%step <= size(run%steps)
    if (.not. has_next) return
    if (begins) row%increment = 0
    run%target = run%target + 1
    run%passed = run%passed + 1
    run%n = 0
    run%fraction = 0.0_wp
    run%control = run%steps(run%step)%control
    if (begins) then
      run%calls%began = run%time
      run%fork = run%steps(run%step)%fork
      run%forks = 0
      ! the force of the spring is zero at the start of the step
      run%offset = merge(run%control%spring*run%point%s, 0.0_wp, run%control%traction)
      where (run%steps(run%step)%changed) run%given = merge(run%point%traction + run%offset, run%point%s, &
        run%control%traction)
    end if
    run%from = run%given
    run%to = run%given
    where (run%steps(run%step)%has_target) run%to = run%steps(run%step)%targets(:, run%target) + run%offset
    run%p_from = run%p_to
    if (allocated(run%steps(run%step)%water)) run%p_to = run%steps(run%step)%water(run%target)
    ! the total traction is prescribed, or constant
    if (run%control%traction(1)) run%to(1) = run%to(1) + merge(run%p_to, run%p_to - run%p_from, &
      run%steps(run%step)%has_target(1))
    arc = run%steps(run%step)%arc
    if (arc > 0.0_wp) run%branch = new_branch(run%law, run%control, run%from, run%to, arc, run%fork)
  end subroutine next_target

  !> Name what happened between two states, and what the row says.
  pure subroutine name_events(law, old, new, regime, row)
    class(point_law), intent(in) :: law                    !! the law
    real(wp), intent(in) :: old(:), new(:)                 !! state of the last row and of this one
    logical, allocatable, intent(inout) :: regime(:, :)    !! at the last row -> at this one
    type(row_type), intent(inout) :: row                   !! the row, with its separation
    call law%find_events(row%s, old, new, regime, row%events)
    call name_event(row%events, "snap", row%report%snaps > 0)
    call name_event(row%events, "turn", row%turn)
    call name_event(row%events, "fork", row%fork)
    call name_event(row%events, "substeps", row%report%parts > 1)
    call name_event(row%events, "cut", row%report%cut)
    call name_event(row%events, "lost", row%lost)
  end subroutine name_events

  !> Append that the work of a path differs from its energies, nothing if it does not. A refined path is its finest run.
  pure subroutine explain_account(run, message)
    type(run_type), intent(in) :: run                         !! the run, at its end
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended
    associate (most => max(run%energy, run%law%stress*run%law%s_0))
      if (.not. run%difference > least_difference*most) return
      call append(message, "work and energies (stored, rupture, friction, crushing) differ by up to " // &
        short(run%difference) // ", " // integer_text(nint(100.0_wp*run%difference/most)) // &
        " % of the largest: expected " // integer_text(nint(100.0_wp*least_difference)) // &
        " % at most, try smaller increments")
    end associate
  end subroutine explain_account

  !> Append why a path has ended before its end, nothing if it has not: a loss of equilibrium, or a fork that was asked
  !> for and not taken.
  pure subroutine explain_end(run, row, message)
    type(run_type), intent(in) :: run                         !! the run
    type(row_type), intent(in) :: row                         !! its last row
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended
    character(len=:), allocatable :: text
    integer :: fork
    if (row%lost) call explain_loss(run, row, message)
    if (.not. run%unforked) return
    fork = run%steps(run%step)%fork
    text = "no other branch crosses in this step: expected fork = 0"
    if (run%forks > 0) text = "the branch was not left at its fork in this step: expected fork = " // &
      integer_text(-fork) // ", a farther target, or fork = 0"
    text = "step " // integer_text(run%step) // ": fork = " // integer_text(fork) // ": " // text
    call append(message, text)
  end subroutine explain_end

  !> Append why the last row is lost: how far none was found, and where the joint is least stable.
  pure subroutine explain_loss(run, row, message)
    type(run_type), intent(in) :: run                         !! the run
    type(row_type), intent(in) :: row                         !! its last row, lost
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended
    character(len=:), allocatable :: text
    real(wp) :: fall(3)
    allocate (character(len=0) :: text)
    if (row%report%ended == ended_refused) then
      text = "the law asks for less than " // to_text(smallest_part) // " of the increment"
      if (run%steps(row%step)%arc > 0.0_wp) text = "the law asks for a smaller step along the branch: expected a " // &
        "smaller arc"
      call append(message, text)
      return
    end if
    if (run%steps(row%step)%arc > 0.0_wp) then
      text = "the branch ends: no equilibrium continues it near its last point"
      if (row%report%ended == ended_endless) text = "the branch does not reach the prescribed values within a length " &
        // "of " // to_text(endless) // " s_f: the separation grows without end, or farther than that"
      if (row%report%ended == ended_rejected) text = "the branch has more than " // &
        to_text(most_branch_steps) // " steps of this length: expected a larger arc, up to " // &
        to_text(largest_arc) // ", or increments (follow = 'stable')"
    else if (row%report%ended == ended_rejected) then
      text = "the values to reach are out of range"
    else
      text = "none found: the motion under the prescribed tractions reaches no equilibrium within " // &
        to_text(farthest) // " s_f"
      if (row%report%ended == ended_limit) text = "the increment needs more than the limit of " // &
        integer_text(most_updates) // " updates of the law"
      if (row%report%jumps > 0) text = "the motion under the prescribed tractions stops, as the " // &
        "traction of the law jumps from t_" // trim(component_names(row%report%jumps)) // " = " // &
        short(row%report%sides(1)) // " to " // short(row%report%sides(2)) // &
        " there, and the prescribed one lies between"
      fall = falling_direction(run%point%tangent, run%control%traction, run%control%spring, &
        run%given - run%point%traction - run%control%spring*run%point%s)
      if (any(abs(fall) > 0.0_wp)) then
        if (row%report%jumps > 0 .or. row%report%ended == ended_limit) then
          text = text // "; the joint is least stable in the direction ("
        else
          text = text // "; the joint leaves its last equilibrium in the direction ("
        end if
        text = text // short(fall(1)) // ", " // short(fall(2)) // ", " // short(fall(3)) // ")"
      end if
    end if
    if (run%control%traction(1)) then
      if (max(run%p_from, run%p_to) > 0.0_wp) text = text // "; the water pressure is added to the total t_N"
      if (run%given(1) > 0.0_wp) text = text // "; tension is positive"
    end if
    call append(message, text)
  end subroutine explain_loss

end module asperity_load_path
