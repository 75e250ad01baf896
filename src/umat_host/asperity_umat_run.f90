!> Run of a UMAT along a load path in a child: every call gives the next row that the child has sent.
module asperity_umat_run
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_funloc, c_loc, c_null_char, c_ptr
  use asperity_case, only: case_type
  use asperity_control_point, only: new_point, point_type, report_type
  use asperity_foreign_umat, only: foreign_law, n_header, open_umat
  use asperity_kinds, only: wp
  use asperity_load_path, only: begin_row, end_row, explain_loss, row_type, run_type, start_run
  use asperity_point_law, only: event_length
  use asperity_refine, only: refine_path
  use asperity_text, only: set_text
  use asperity_umat_worker, only: end_worker, leave_notes, receive_row, send_row, start_worker, worker_type
  implicit none
  private
  public :: start_umat_run, next_umat_row, end_umat_run

  !> A row without its state, as a child sends it, and how many numbers it takes.
  type :: sent_type
    integer :: step = 0, increment = 0, done = 0
    logical :: turn = .false., lost = .false.
    real(wp) :: position = 0.0_wp, time = 0.0_wp, s(3) = 0.0_wp, traction(3) = 0.0_wp, work = 0.0_wp
    type(report_type) :: report = report_type()
    character(len=event_length) :: events = ""
  end type sent_type
  type(sent_type), parameter :: nothing = sent_type()
  integer, parameter :: n_fixed = ceiling(real(storage_size(nothing), wp)/real(storage_size(1.0_wp), wp))

  !> What a child is to do.
  type :: task_type
    type(foreign_law) :: law                         !! the law
    type(case_type) :: case                          !! load path and start
  end type task_type

  !> A child and its run.
  type, public :: umat_run_type
    type(run_type) :: run                            !! at the end: of its increment what a caller may repeat
    character(len=:), allocatable :: failure         !! why the UMAT has failed; empty: it has not
    character(len=:), allocatable :: reason          !! why the path ends before its end, empty: it does not
    type(task_type), private :: task
    real(wp), allocatable, private :: numbers(:)     !! a row
  end type umat_run_type

contains

  !> Begin a run in a child. The traction at its start is STRESS, as only the child may call the UMAT.
  subroutine start_umat_run(law, case, run)
    type(foreign_law), intent(in) :: law               !! the law
    type(case_type), intent(in) :: case                !! the case, with a state
    type(umat_run_type), intent(out), target :: run    !! no row yet
    type(point_type) :: start
    integer :: i
    run%task%law = law
    run%task%case = case
    call set_text(run%failure, "")
    start%s = case%state%s
    start%state = case%state%statev
    do i = 1, 3
      if (law%umat%position(i) > 0) start%traction(i) = start%state(n_header + law%umat%position(i))
    end do
    start%work = sum(law%energies(start%state))
    if (case%state%has_work) start%work = case%state%work
    call start_run(law, case%steps, run%run, start)
    run%run%before = start
    allocate (run%numbers(n_fixed + law%n_state))
    call start_child(run%task)
  end subroutine start_umat_run

  !> Begin the work of a child, which has a copy of the task.
  subroutine start_child(task)
    type(task_type), intent(in), target :: task   !! what to do
    call start_worker(c_funloc(follow_path), c_loc(task), task%law%umat%limit)
  end subroutine start_child

  !> Wait for the next row.
  subroutine next_umat_row(run, row, found)
    type(umat_run_type), intent(inout) :: run   !! the run
    type(row_type), intent(inout) :: row        !! the next row, if there is one
    logical, intent(out) :: found               !! false: the child has ended
    type(row_type) :: next
    do
      found = receive_row(run%numbers, size(run%numbers)) /= 0
      if (.not. found) then
        call end_umat_run(run)
        if (len(run%failure) == 0 .or. .not. run%task%case%refines) return
        ! a path with a tolerance has its rows at its end only: it is taken again as far as it goes
        run%task%case%refines = .false.
        call start_child(run%task)
        cycle
      end if
      call unpack_row(run%numbers, next, run%run%done)
      if (next%step > 0) then
        row = next
        if (.not. row%lost) run%run%before = row%point_type
        return
      end if
      run%run%before = next%point_type
    end do
  end subroutine next_umat_row

  !> End a run, also before its last row.
  subroutine end_umat_run(run)
    type(umat_run_type), intent(inout) :: run   !! the run -> why it has ended
    type(worker_type) :: worker
    call end_worker(worker)
    associate (control => run%run%control, notes => worker%notes)
      run%run%given = notes(1:3)
      control%spring = notes(4:6)
      control%traction = notes(7:9) > 0.0_wp
      control%dt = notes(10)
      run%run%law%step = nint(notes(11))
      run%run%law%increment = nint(notes(12))
    end associate
    run%reason = worker%text
    if (len(run%failure) == 0) run%failure = worker%failure
  end subroutine end_umat_run

  !> The work of the child: rows, and if equilibrium is lost the start of the last increment, with step 0.
  subroutine follow_path(data) bind(c, name="asperity_umat_follow_path")
    type(c_ptr), value :: data   !! task
    type(task_type), pointer :: task
    type(point_type) :: start
    type(run_type) :: run
    type(row_type) :: row
    character(len=:), allocatable :: text
    integer :: n
    logical :: found
    call c_f_pointer(data, task)
    call open_umat(task%law)
    call set_text(text, "")
    associate (law => task%law, case => task%case)
      n = n_fixed + law%n_state
      start = new_point(law, case%state%statev, case%state%s)
      if (case%state%has_work) start%work = case%state%work
      if (case%refines) then
        call refine_path(law, case%steps, start, case%tolerance, run, text)
      else
        call start_run(law, case%steps, run, start)
      end if
    end associate
    do
      call begin_row(run, row, found)
      if (.not. found) exit
      call leave_notes(prescribed(run), 12, c_null_char)
      call end_row(run, row)
      call send_row(packed(row, run%done), n)
    end do
    if (row%lost .and. len(text) == 0) call explain_loss(run, row, text)
    row%step = 0
    row%point_type = run%before
    if (row%lost) call send_row(packed(row, run%done), n)
    call leave_notes(prescribed(run), 12, text // c_null_char)
  end subroutine follow_path

  !> Notes of an increment: what it prescribes, and its numbers.
  pure function prescribed(run) result(notes)
    type(run_type), intent(in) :: run   !! after the increment has begun
    real(wp) :: notes(12)
    associate (control => run%control)
      notes = [run%given, control%spring, merge(1.0_wp, 0.0_wp, control%traction), control%dt, &
        real([run%law%step, run%law%increment], wp)]
    end associate
  end function prescribed

  !> Numbers of a row.
  pure function packed(row, done) result(numbers)
    type(row_type), intent(in) :: row   !! the row
    integer, intent(in) :: done         !! increments so far
    real(wp) :: numbers(n_fixed + size(row%state))
    numbers(:n_fixed) = transfer(sent_type(row%step, row%increment, done, row%turn, row%lost, row%position, row%time, &
      row%s, row%traction, row%work, row%report, row%events), numbers, n_fixed)
    numbers(n_fixed + 1:) = row%state
  end function packed

  !> Row of its numbers.
  pure subroutine unpack_row(numbers, row, done)
    real(wp), intent(in) :: numbers(:)    !! as `packed` gives them
    type(row_type), intent(out) :: row    !! the row
    integer, intent(out) :: done          !! increments so far
    type(sent_type) :: sent
    sent = transfer(numbers(:n_fixed), nothing)
    done = sent%done
    row%step = sent%step
    row%increment = sent%increment
    row%turn = sent%turn
    row%lost = sent%lost
    row%position = sent%position
    row%time = sent%time
    row%s = sent%s
    row%traction = sent%traction
    row%work = sent%work
    row%report = sent%report
    row%events = sent%events
    row%state = numbers(n_fixed + 1:)
  end subroutine unpack_row

end module asperity_umat_run
