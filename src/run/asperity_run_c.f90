!> C API of the toolbox around the law, declared in asperity_run.h: case files, their runs and rows, tables, stability.
!> The Python package wraps the same functions.
module asperity_run_c
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, c_loc, c_null_char, &
    c_null_ptr, c_ptr
  use asperity_c_text, only: get_text, put_text
  use asperity_call_checks, only: umat_only
  use asperity_case, only: case_file_type, check_path, read_cases
  use asperity_case_groups, only: start_point
  use asperity_checks, only: all_bounded
  use asperity_contract, only: status_ok, status_size, status_state
  use asperity_errors, only: errors_type, put_words
  use asperity_interface, only: interface_type, new_interface
  use asperity_json, only: case_json, errors_json, tables_json
  use asperity_kinds, only: wp
  use asperity_load_path, only: explain_account, explain_end, next_row, row_type, run_type
  use asperity_point_law, only: event_length, point_type
  use asperity_refine, only: refine_path
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_rows, only: aperture_type, row_columns, row_numbers
  use asperity_stability, only: stability_columns, stability_of
  use asperity_steps, only: most_increments, step_table, step_type
  use asperity_text, only: integer_text
  implicit none
  private
  public :: asperity_read_cases, asperity_case_errors, asperity_case_content, asperity_free_cases, asperity_steps, &
    asperity_set, asperity_begin, asperity_next, asperity_value, asperity_lost, asperity_end, asperity_tables, &
    asperity_stability_of

  !> Messages about a handle that is NULL.
  character(len=*), parameter :: no_cases = "cases = NULL: expected a handle of asperity_read_cases"
  character(len=*), parameter :: no_run = "run = NULL: expected a handle of asperity_begin"

  !> What the handle of a case file has.
  type :: cases_type
    type(case_file_type) :: file
    type(errors_type) :: errors
    integer :: n_read = 0                   !! errors of the text, without those of steps that were set
    logical :: set = .false.                !! whether steps were set and are not checked yet
    character(len=:), allocatable :: json   !! content or errors, once it was asked for
  end type cases_type

  !> What the handle of a run has.
  type :: handle_type
    type(run_type) :: run
    type(row_type) :: row                   !! the last one
    type(aperture_type) :: aperture         !! of the joint
    integer :: n_rows = 0                   !! so far
  end type handle_type

contains

  !> Read a case file, or a text; the handle is never NULL.
  function asperity_read_cases(path, text, props, nprops) bind(C) result(cases)
    type(c_ptr), value :: path              !! file, or the name of the text in errors; NULL: ""
    type(c_ptr), value :: text              !! text in place of the file; NULL: none
    type(c_ptr), value :: props             !! double[nprops] in place of &material and &pattern; NULL: none
    integer(c_int), value :: nprops         !! number of constants
    type(c_ptr) :: cases
    type(cases_type), pointer :: handle
    real(wp), pointer, contiguous :: constants(:)
    character(len=:), allocatable :: name, source
    allocate (handle)
    nullify (constants)
    if (c_associated(props)) call c_f_pointer(props, constants, [max(0, nprops)])
    call get_text(path, name)
    if (c_associated(text)) call get_text(text, source)
    ! what is not allocated, or a null pointer, is an absent optional argument
    call read_cases(name, handle%file, handle%errors, source, constants)
    handle%n_read = handle%errors%n
    cases = c_loc(handle)
  end function asperity_read_cases

  !> Take n steps without entries in place of those of a case file; returns 0, or a status.
  function asperity_steps(cases, n) bind(C) result(status)
    type(c_ptr), value :: cases             !! of asperity_read_cases
    integer(c_int), value :: n              !! steps, from 1
    integer(c_int) :: status
    type(cases_type), pointer :: handle
    type(step_type), allocatable :: steps(:)
    integer :: i
    status = status_size
    if (.not. c_associated(cases) .or. n < 1 .or. n > most_increments) return
    call c_f_pointer(cases, handle)
    if (.not. allocated(handle%file%cases)) return
    if (size(handle%file%cases) /= 1 .or. size(handle%file%values) > 0) return
    allocate (steps(n), stat=i)
    if (i /= 0) return
    status = status_ok
    ! the errors of steps that were set before are gone with them
    handle%errors%n = handle%n_read
    if (allocated(handle%json)) deallocate (handle%json)
    handle%set = .true.
    associate (case => handle%file%cases(1))
      call move_alloc(steps, case%steps)
      do i = 1, n
        case%steps(i)%place%group = "&step"
        case%steps(i)%place%step = i - 1
      end do
    end associate
  end function asperity_steps

  !> Set an entry of a step of asperity_steps; returns 0, or a status.
  function asperity_set(cases, step, name, n, values) bind(C) result(status)
    type(c_ptr), value :: cases             !! of asperity_read_cases
    integer(c_int), value :: step           !! from 0
    type(c_ptr), value :: name              !! of the entry
    integer(c_int), value :: n              !! values
    type(c_ptr), value :: values            !! double[n], any bits
    integer(c_int) :: status
    type(cases_type), pointer :: handle
    real(wp), pointer, contiguous :: numbers(:)
    character(len=:), allocatable :: text
    integer :: i
    status = status_size
    if (.not. c_associated(cases) .or. n < 0 .or. (n > 0 .and. .not. c_associated(values))) return
    call c_f_pointer(cases, handle)
    call get_text(name, text)
    i = findloc(step_table%name == text, .true., dim=1)
    if (.not. handle%set .or. i == 0) return
    associate (steps => handle%file%cases(1)%steps)
      if (step < 0 .or. step >= size(steps)) return
      status = status_ok
      if (allocated(steps(step + 1)%given(i)%values)) deallocate (steps(step + 1)%given(i)%values)
      allocate (steps(step + 1)%given(i)%values(n))
      if (n == 0) return
      call c_f_pointer(values, numbers, [n])
      steps(step + 1)%given(i)%values = numbers
    end associate
  end function asperity_set

  !> Check the steps that were set.
  subroutine check_set(handle)
    type(cases_type), intent(inout) :: handle   !! of a case file
    if (.not. handle%set) return
    handle%set = .false.
    call check_path(handle%file%cases(1), handle%errors)
  end subroutine check_set

  !> Number of errors of a case file, which the message words.
  function asperity_case_errors(cases, message, size) bind(C) result(n)
    type(c_ptr), value :: cases             !! of asperity_read_cases
    type(c_ptr), value :: message           !! char[size], a line for each; may be NULL
    integer(c_int), value :: size           !! bytes of the message
    integer(c_int) :: n
    type(cases_type), pointer :: handle
    character(len=:), allocatable :: text
    text = no_cases
    n = 1
    if (c_associated(cases)) then
      call c_f_pointer(cases, handle)
      call check_set(handle)
      text = ""
      call put_words(handle%errors, text)
      n = handle%errors%n
    end if
    call put_text(text, message, size)
  end function asperity_case_errors

  !> Content of a case file as JSON (case_json), where it has errors those (errors_json); returns its length.
  function asperity_case_content(cases, text, size) bind(C) result(length)
    type(c_ptr), value :: cases             !! of asperity_read_cases
    type(c_ptr), value :: text              !! char[size], may be NULL
    integer(c_int), value :: size           !! bytes of the text
    integer(c_int) :: length
    type(cases_type), pointer :: handle
    length = 0
    call put_text("", text, size)
    if (.not. c_associated(cases)) return
    call c_f_pointer(cases, handle)
    call check_set(handle)
    if (.not. allocated(handle%json)) then
      if (handle%errors%n > 0) call errors_json(handle%errors, handle%json)
      if (handle%errors%n == 0) call case_json(handle%file, handle%json)
    end if
    call put_text(handle%json, text, size)
    length = len(handle%json)
  end function asperity_case_content

  !> End the use of a case file; its runs remain.
  subroutine asperity_free_cases(cases) bind(C)
    type(c_ptr), value :: cases             !! of asperity_read_cases; NULL: nothing is done
    type(cases_type), pointer :: handle
    if (.not. c_associated(cases)) return
    call c_f_pointer(cases, handle)
    deallocate (handle)
  end subroutine asperity_free_cases

  !> Begin a run of a case file; NULL, with the reason in the message, if it cannot begin.
  function asperity_begin(cases, number, message, size) bind(C) result(run)
    type(c_ptr), value :: cases             !! of asperity_read_cases
    integer(c_int), value :: number         !! of the value of the sweep, from 0
    type(c_ptr), value :: message           !! char[size], may be NULL
    integer(c_int), value :: size           !! bytes of the message
    type(c_ptr) :: run
    type(cases_type), pointer :: file
    type(handle_type), pointer :: handle
    type(point_type) :: start
    type(rie_law) :: law
    character(len=:), allocatable :: text
    run = c_null_ptr
    text = ""
    if (.not. c_associated(cases)) then
      call put_text(no_cases, message, size)
      return
    end if
    call c_f_pointer(cases, file)
    call check_set(file)
    call put_words(file%errors, text)
    if (len(text) == 0) then
      associate (last => ubound(file%file%cases, 1) - 1)
        if (number < 0 .or. number > last) text = "run " // integer_text(number) // ": expected 0 to " // &
          integer_text(last)
      end associate
    end if
    if (len(text) == 0) then
      associate (case => file%file%cases(number + 1))
        if (case%umat%given) then
          text = "&umat: expected &material and &pattern, as the driver alone runs UMATs of others"
        else if (case%replay%given) then
          text = "&replay: expected &step, as the driver alone runs replays"
        else if (case%joint%implex > 0.0_wp) then
          text = umat_only(case%joint)
        else
          allocate (handle)
          handle%aperture = case%aperture
          law = new_rie_law(case%joint)
          start = start_point(law, case%state)
          call refine_path(law, case%steps, start, case%state%p, case%tolerance, handle%run, text)
          if (len(text) == 0) run = c_loc(handle)
          if (len(text) > 0) deallocate (handle)
        end if
      end associate
    end if
    call put_text(text, message, size)
  end function asperity_begin

  !> Next rows of a run, up to n; fewer: the path is at its end, or equilibrium is lost beyond the last one.
  function asperity_next(run, n, n_columns, rows, nstatv, states, events) bind(C) result(n_rows)
    type(c_ptr), value :: run               !! of asperity_begin
    integer(c_int), value :: n              !! rows for which there is room
    integer(c_int), value :: n_columns      !! numbers of a row that are written: the first columns
    type(c_ptr), value :: rows              !! double[n][n_columns], may be NULL
    integer(c_int), value :: nstatv         !! state variables that are written: the first ones
    type(c_ptr), value :: states            !! double[n][nstatv], may be NULL
    type(c_ptr), value :: events            !! char[n][64], names joined by +, ended by zeros; may be NULL
    integer(c_int) :: n_rows
    type(handle_type), pointer :: handle
    real(wp), pointer, contiguous :: numbers(:, :), statev(:, :)
    character(kind=c_char), pointer, contiguous :: names(:, :)
    real(wp), target :: none(0, 0)
    character(kind=c_char), target :: no_name(0, 0)
    real(wp) :: values(size(row_columns))
    integer :: i, last
    logical :: found
    n_rows = 0
    if (.not. c_associated(run)) return
    call c_f_pointer(run, handle)
    numbers => none
    statev => none
    names => no_name
    if (c_associated(rows)) call c_f_pointer(rows, numbers, [max(0, n_columns), max(0, n)])
    if (c_associated(states)) call c_f_pointer(states, statev, [max(0, nstatv), max(0, n)])
    if (c_associated(events)) call c_f_pointer(events, names, [event_length, max(0, n)])
    do while (n_rows < n)
      call next_row(handle%run, handle%row, found)
      if (.not. found) exit
      n_rows = n_rows + 1
      handle%n_rows = handle%n_rows + 1
      if (c_associated(rows)) then
        values = row_numbers(handle%row, handle%aperture)
        last = min(size(numbers, 1), size(values))
        numbers(:last, n_rows) = values(:last)
      end if
      if (c_associated(states)) then
        last = min(size(statev, 1), size(handle%row%state))
        statev(:last, n_rows) = handle%row%state(:last)
      end if
      if (c_associated(events)) then
        names(:, n_rows) = c_null_char
        do i = 1, min(len_trim(handle%row%events), event_length - 1)
          names(i, n_rows) = handle%row%events(i:i)
        end do
      end if
      if (handle%row%lost) exit
    end do
  end function asperity_next

  !> Number of the last row in a column; NaN before the first row, and for a name that no column has.
  function asperity_value(run, column) bind(C) result(value)
    type(c_ptr), value :: run               !! of asperity_begin
    type(c_ptr), value :: column            !! name
    real(c_double) :: value
    type(handle_type), pointer :: handle
    character(len=:), allocatable :: name
    real(wp) :: values(size(row_columns))
    integer :: i
    value = ieee_value(value, ieee_quiet_nan)
    if (.not. c_associated(run)) return
    call c_f_pointer(run, handle)
    call get_text(column, name)
    i = findloc(row_columns == name, .true., dim=1)
    if (i == 0 .or. handle%n_rows == 0) return
    values = row_numbers(handle%row, handle%aperture)
    value = values(i)
  end function asperity_value

  !> Whether equilibrium is lost beyond the last row (1), or a step has not left its branch at a fork (2), and why. Else
  !> (0) the message is empty, or says that work and energies of the rows differ.
  function asperity_lost(run, message, size) bind(C) result(lost)
    type(c_ptr), value :: run               !! of asperity_begin
    type(c_ptr), value :: message           !! char[size], may be NULL
    integer(c_int), value :: size           !! bytes of the message
    integer(c_int) :: lost
    type(handle_type), pointer :: handle
    character(len=:), allocatable :: text
    text = no_run
    lost = 1
    if (c_associated(run)) then
      call c_f_pointer(run, handle)
      text = ""
      call explain_end(handle%run, handle%row, text)
      lost = merge(merge(1_c_int, 2_c_int, handle%row%lost), 0_c_int, len(text) > 0)
      if (lost == 0) call explain_account(handle%run, text)
    end if
    call put_text(text, message, size)
  end function asperity_lost

  !> End a run, at any row.
  subroutine asperity_end(run) bind(C)
    type(c_ptr), value :: run               !! of asperity_begin; NULL: nothing is done
    type(handle_type), pointer :: handle
    if (.not. c_associated(run)) return
    call c_f_pointer(run, handle)
    deallocate (handle)
  end subroutine asperity_end

  !> Tables of the library as JSON (tables_json); returns its length.
  function asperity_tables(text, size) bind(C) result(length)
    type(c_ptr), value :: text              !! char[size], may be NULL
    integer(c_int), value :: size           !! bytes of the text
    integer(c_int) :: length
    character(len=:), allocatable :: json
    call tables_json(json)
    call put_text(json, text, size)
    length = len(json)
  end function asperity_tables

  !> Stability of n points, from the eigenvalues of their tangents; returns 0 or the status of PROPS or of a tangent.
  function asperity_stability_of(props, nprops, n, tangent, numbers) bind(C) result(status)
    type(c_ptr), value :: props             !! double[nprops] PROPS
    integer(c_int), value :: nprops         !! number of constants
    integer(c_int), value :: n              !! points
    type(c_ptr), value :: tangent           !! double[n][3][3] d traction_i/d s_j, stress/length
    type(c_ptr), value :: numbers           !! double[n][6], as "stability" names them
    integer(c_int) :: status
    real(wp), pointer, contiguous :: columns(:, :), constants(:), tangents(:, :, :)
    real(wp), target :: none(0)
    type(interface_type) :: joint
    type(rie_law) :: law
    integer :: i
    status = status_size
    if (.not. c_associated(props) .and. nprops > 0) return
    if (n < 0 .or. (n > 0 .and. .not. (c_associated(tangent) .and. c_associated(numbers)))) return
    constants => none
    if (nprops > 0) call c_f_pointer(props, constants, [nprops])
    call new_interface(constants, joint, status)
    if (status /= status_ok .or. n == 0) return
    call c_f_pointer(tangent, tangents, [3, 3, n])
    call c_f_pointer(numbers, columns, [size(stability_columns), n])
    do i = 1, n
      if (all_bounded(9, tangents(:, :, i), huge(1.0_wp))) cycle
      status = status_state
      return
    end do
    law = new_rie_law(joint)
    do i = 1, n
      columns(:, i) = stability_of(transpose(tangents(:, :, i)), law%stiffness)
    end do
  end function asperity_stability_of

end module asperity_run_c
