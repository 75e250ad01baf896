!> Run of a UMAT along a load path in a child: every call gives the next row that the child has sent.
module asperity_umat_run
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_funloc, c_loc, c_null_char, c_ptr
  use asperity_case, only: case_type
  use asperity_case_groups, only: start_point
  use asperity_foreign_umat, only: foreign_law, n_header, open_umat
  use asperity_kinds, only: wp
  use asperity_load_path, only: begin_row, end_row, explain_end, increment_type, row_head, row_type, &
    run_type, set_point, start_run
  use asperity_point_law, only: event_length, point_type
  use asperity_refine, only: refine_path
  use asperity_text, only: set_text
  use asperity_umat_stiffness, only: stiffness_fault
  use asperity_umat_worker, only: end_worker, fail_worker, leave_notes, n_notes, receive_row, send_row, start_worker
  implicit none
  private
  public :: start_umat_run, next_umat_row

  !> Numbers of a row that a child sends, before those of its state, and of an increment, which it leaves as notes.
  integer, parameter :: n_numbers = 42, n_head = n_numbers + event_length, n_increment = 12

  !> A child and its run.
  type, public :: umat_run_type
    type(run_type) :: run                            !! at the end: of its increment what a caller may repeat
    character(len=:), allocatable :: failure         !! why the UMAT has failed; empty: it has not
    character(len=:), allocatable :: reason          !! why the path ends before its end, empty: it does not
    type(foreign_law), private :: law
    type(case_type), private :: case                 !! load path and start
    real(wp), allocatable, private :: numbers(:)     !! a row
    logical, private :: has_rows = .false.           !! whether the child has sent one
  end type umat_run_type

contains

  !> Begin a run in a child. The traction at its start is STRESS, as only the child may call the UMAT.
  subroutine start_umat_run(law, case, run)
    type(foreign_law), intent(in) :: law               !! the law
    type(case_type), intent(in) :: case                !! the case, with a state
    type(umat_run_type), intent(out), target :: run    !! no row yet
    type(point_type) :: start
    integer :: i
    run%law = law
    run%case = case
    call set_text(run%failure, "")
    start%s = case%state%s
    start%state = case%state%statev
    do i = 1, 3
      if (law%umat%position(i) > 0) start%traction(i) = start%state(n_header + law%umat%position(i))
    end do
    start%work = sum(law%accounts(start%state))
    if (case%state%has_work) start%work = case%state%work
    call start_run(law, case%steps, run%run, start, case%state%p)
    run%run%before = start
    allocate (run%numbers(n_head + law%n_state))
    call start_worker(c_funloc(follow_path), c_loc(run), law%umat%limit)
  end subroutine start_umat_run

  !> Wait for the next row.
  subroutine next_umat_row(run, row, has_row)
    type(umat_run_type), intent(inout), target :: run   !! the run
    type(row_type), intent(inout) :: row                !! the next row, if there is one
    logical, intent(out) :: has_row                     !! false: the child has ended
    type(row_head) :: head
    do
      has_row = receive_row(run%numbers, size(run%numbers)) /= 0
      if (.not. has_row) then
        call end_umat_run(run)
        if (len(run%failure) == 0 .or. run%has_rows .or. .not. run%case%tolerance > 0.0_wp) return
        ! a path with a tolerance has its rows at its end only: it is taken again as far as it goes
        run%case%tolerance = 0.0_wp
        call start_worker(c_funloc(follow_path), c_loc(run), run%law%umat%limit)
        cycle
      end if
      head = unpacked(run%numbers(:n_head))
      if (head%step == 0 .or. .not. head%lost) run%run%before = point_type(s=head%s, traction=head%traction, &
        work=head%work, state=run%numbers(n_head + 1:))
      if (head%step == 0) cycle
      run%has_rows = .true.
      row%row_head = head
      row%state = run%numbers(n_head + 1:)
      return
    end do
  end subroutine next_umat_row

  !> End a run.
  subroutine end_umat_run(run)
    type(umat_run_type), intent(inout) :: run   !! the run -> why it has ended
    character(len=:), allocatable :: failure
    real(wp) :: notes(n_notes)
    call end_worker(failure, run%reason, notes)
    associate (increment => run%run%increment_type)
      increment%control%traction = notes(1:3) > 0.0_wp
      increment%control%spring = notes(4:6)
      increment%control%dt = notes(7)
      increment%given = notes(8:10)
      increment%number = nint(notes(11:12))
    end associate
    if (len(run%failure) == 0) run%failure = failure
  end subroutine end_umat_run

  !> The work of the child: rows, and if equilibrium is lost the start of the last increment, with step 0.
  subroutine follow_path(data) bind(c, name="asperity_umat_follow_path")
    type(c_ptr), value :: data   !! the run of the parent
    type(umat_run_type), pointer :: task
    type(point_type) :: start
    type(run_type) :: run
    type(row_type) :: row
    character(len=:), allocatable :: fault, text
    integer :: n
    logical :: has_row
    call c_f_pointer(data, task)
    call open_umat(task%law)
    call set_text(text, "")
    associate (law => task%law, case => task%case)
      n = n_head + law%n_state
      start = start_point(law, case%state)
      fault = stiffness_fault(law, start)
      if (len(fault) > 0) call fail_worker(fault // c_null_char)
      call refine_path(law, case%steps, start, case%state%p, case%tolerance, run, text)
    end associate
    do
      call begin_row(run, row, has_row)
      if (.not. has_row) exit
      call leave_notes(of_increment(run%increment_type), n_increment, c_null_char)
      call end_row(run, row)
      call send_row(packed(row), n)
    end do
    if (len(text) == 0) call explain_end(run, row, text)
    row%step = 0
    call set_point(row, run%before, 0.0_wp)   ! the traction of the law
    if (row%lost) call send_row(packed(row), n)
    call leave_notes(of_increment(run%increment_type), n_increment, text // c_null_char)
  end subroutine follow_path

  !> Numbers of a row.
  pure function packed(row) result(numbers)
    type(row_type), intent(in) :: row   !! the row
    real(wp) :: numbers(n_head + size(row%state))
    integer :: i
    associate (report => row%report)
      numbers = [real([row%step, row%increment, row%done], wp), row%position, row%time, row%s, row%traction, &
        reshape(row%tangent, [9]), row%p, row%work, &
        real([report%ended, report%iterations, report%updates, report%parts, report%snaps, report%jumps], wp), &
        report%requested, report%before, report%after, report%released, report%sides, &
        merge(1.0_wp, 0.0_wp, [report%cut, row%turn, row%fork, row%lost]), &
        [(real(iachar(row%events(i:i)), wp), i=1, event_length)], row%state]
    end associate
  end function packed

  !> A row without its state from its numbers.
  pure function unpacked(numbers) result(head)
    real(wp), intent(in) :: numbers(n_head)   !! of a row
    type(row_head) :: head
    integer :: i
    associate (report => head%report)
      head%step = nint(numbers(1))
      head%increment = nint(numbers(2))
      head%done = nint(numbers(3))
      head%position = numbers(4)
      head%time = numbers(5)
      head%s = numbers(6:8)
      head%traction = numbers(9:11)
      head%tangent = reshape(numbers(12:20), [3, 3])
      head%p = numbers(21)
      head%work = numbers(22)
      report%ended = nint(numbers(23))
      report%iterations = nint(numbers(24))
      report%updates = nint(numbers(25))
      report%parts = nint(numbers(26))
      report%snaps = nint(numbers(27))
      report%jumps = nint(numbers(28))
      report%requested = numbers(29)
      report%before = numbers(30:32)
      report%after = numbers(33:35)
      report%released = numbers(36)
      report%sides = numbers(37:38)
      report%cut = numbers(39) > 0.0_wp
      head%turn = numbers(40) > 0.0_wp
      head%fork = numbers(41) > 0.0_wp
      head%lost = numbers(42) > 0.0_wp
    end associate
    do i = 1, event_length
      head%events(i:i) = achar(nint(numbers(n_numbers + i)))
    end do
  end function unpacked

  !> Numbers of an increment.
  pure function of_increment(increment) result(numbers)
    type(increment_type), intent(in) :: increment   !! what it prescribes
    real(wp) :: numbers(n_increment)
    associate (control => increment%control)
      numbers = [merge(1.0_wp, 0.0_wp, control%traction), control%spring, control%dt, increment%given, &
        real(increment%number, wp)]
    end associate
  end function of_increment

end module asperity_umat_run
