!> Run of a UMAT along a load path in a child: every call gives the next row that the child has sent.
module asperity_umat_run
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_funloc, c_loc, c_null_char, c_ptr
  use asperity_control_point, only: new_point, point_type, report_type
  use asperity_foreign_umat, only: foreign_law, n_header, open_umat, umat_name
  use asperity_kinds, only: wp
  use asperity_load_path, only: begin_row, end_row, explain_loss, row_type, run_type, start_run
  use asperity_point_law, only: event_length
  use asperity_refine, only: refine_path
  use asperity_steps, only: step_type
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
  type, public :: umat_path_type
    type(foreign_law) :: law                         !! the law
    type(step_type), allocatable :: steps(:)         !! the load path, checked
    real(wp) :: s(3) = 0.0_wp                        !! separation at the start
    real(wp), allocatable :: state(:)                !! state at the start
    logical :: has_work = .false.                    !! false: the work is that of the energies
    real(wp) :: work = 0.0_wp                        !! work so far
    real(wp) :: tolerance = 0.0_wp                   !! 0: increments as they are given
  end type umat_path_type

  !> A child and its run.
  type, public :: umat_run_type
    type(worker_type) :: worker
    type(run_type) :: run                            !! at the end: of its increment what a caller may repeat
    character(len=:), allocatable :: failure         !! why the UMAT has failed, with its name; empty: it has not
    character(len=:), allocatable :: reason          !! why the path ends before its end, empty: it does not
    real(wp), allocatable, private :: numbers(:)     !! a row
  end type umat_run_type

contains

  !> Start of a path. Its traction is STRESS, as only the child may call the UMAT.
  pure function start_of(path) result(start)
    type(umat_path_type), intent(in) :: path   !! the path
    type(point_type) :: start
    integer :: i
    start%s = path%s
    allocate (start%state, source=path%state)
    do i = 1, 3
      if (path%law%umat%position(i) > 0) start%traction(i) = path%state(n_header + path%law%umat%position(i))
    end do
    start%work = sum(path%law%energies(path%state))
    if (path%has_work) start%work = path%work
  end function start_of

  !> Begin a run in a child.
  subroutine start_umat_run(path, run)
    type(umat_path_type), intent(in), target :: path   !! what to do
    type(umat_run_type), intent(out) :: run            !! no row yet
    call start_run(path%law, path%steps, run%run, start_of(path))
    run%run%before = run%run%point
    allocate (run%numbers(n_fixed + path%law%n_state))
    call start_worker(c_funloc(follow_path), c_loc(path), path%law%umat%limit)
  end subroutine start_umat_run

  !> Wait for the next row.
  subroutine next_umat_row(run, row, found)
    type(umat_run_type), intent(inout) :: run   !! the run
    type(row_type), intent(inout) :: row        !! the next row, if there is one
    logical, intent(out) :: found               !! false: the child has ended
    type(row_type) :: next
    do
      found = receive_row(run%numbers, size(run%numbers)) /= 0
      if (.not. found) exit
      call unpack_row(run%numbers, next, run%run%done)
      if (next%step > 0) then
        row = next
        if (.not. row%lost) run%run%before = row%point_type
        return
      end if
      run%run%before = next%point_type
    end do
    call end_umat_run(run)
  end subroutine next_umat_row

  !> End a run, also before its last row.
  subroutine end_umat_run(run)
    type(umat_run_type), intent(inout) :: run   !! the run -> why it has ended
    call end_worker(run%worker)
    associate (control => run%run%control, notes => run%worker%notes)
      run%run%given = notes(1:3)
      control%spring = notes(4:6)
      control%traction = notes(7:9) > 0.0_wp
      control%dt = notes(10)
      run%run%law%step = nint(notes(11))
      run%run%law%increment = nint(notes(12))
    end associate
    run%reason = run%worker%text
    run%failure = run%worker%failure
    select type (law => run%run%law)
    type is (foreign_law)
      if (len(run%failure) > 0) run%failure = umat_name(law) // ": " // run%failure
    end select
  end subroutine end_umat_run

  !> The work of the child: rows, and if equilibrium is lost the start of the last increment, with step 0.
  subroutine follow_path(data) bind(c, name="asperity_umat_follow_path")
    type(c_ptr), value :: data   !! path
    type(umat_path_type), pointer :: path
    type(point_type) :: start
    type(run_type) :: run
    type(row_type) :: row
    type(row_type), allocatable :: rows(:)
    character(len=:), allocatable :: text
    integer :: i, n
    logical :: found
    call c_f_pointer(data, path)
    call open_umat(path%law)
    start = new_point(path%law, path%state, path%s)
    if (path%has_work) start%work = path%work
    text = ""
    n = n_fixed + path%law%n_state
    if (path%tolerance > 0.0_wp) then
      call refine_path(path%law, path%steps, start, path%tolerance, rows, run, text)
      do i = 1, size(rows)
        row = rows(i)
        call send_row(packed(row, run%total), n)
      end do
    else
      call start_run(path%law, path%steps, run, start)
      do
        call begin_row(run, row, found)
        if (.not. found) exit
        call leave_notes(prescribed(run), 12, c_null_char)
        call end_row(run, row)
        call send_row(packed(row, run%done), n)
      end do
    end if
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
