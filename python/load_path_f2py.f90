! Load paths in the shape f2py reads (see asperity_f2py.f90): a run is begun, gives its rows in parts, and is ended. Its
! handle has the addresses of the run and of its last row.

!> Begin a load path. The run must be ended if the length is 0.
subroutine path_begin(nprops, props, nstatv, n_entries, n_steps, counts, n_values, values, start, state, refines, &
                      tolerance, handle, length)
  use, intrinsic :: iso_c_binding, only: c_loc
  use asperity_call_checks, only: explain_point, point_status
  use asperity_contract, only: status_ok
  use asperity_equations, only: new_point, point_type
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_interface, only: interface_type, new_interface
  use asperity_json, only: errors_json
  use asperity_load_path, only: row_type, run_type
  use asperity_refine, only: explain_tolerance, refine_path
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_steps, only: check_steps, complete_steps, step_type
  use asperity_text, only: integer_text
  use text_handles, only: new_handle
  implicit none
  integer, intent(in) :: nprops                             !! number of constants
  double precision, intent(in) :: props(nprops)             !! admissible PROPS
  integer, intent(in) :: nstatv                             !! state variables of a point
  integer, intent(in) :: n_entries                          !! entries of a step
  integer, intent(in) :: n_steps                            !! steps
  integer, intent(in) :: counts(n_entries, n_steps)         !! values of each entry, -1: not given
  integer, intent(in) :: n_values                           !! values of all entries, at least 1
  double precision, intent(in) :: values(n_values)          !! values, entry by entry and step by step
  double precision, intent(in) :: start(5)                  !! separation (N, Tx, Ty), length, work so far and water
                                                            !! pressure at the start; a work that is not finite: the
                                                            !! energies of the state
  double precision, intent(in) :: state(nstatv)             !! STATEV at the start; 0: virgin
  integer, intent(in) :: refines                            !! 1: increments to a tolerance; 0: as they are given
  double precision, intent(in) :: tolerance                 !! relative
  integer, intent(out) :: handle(4)                         !! of the run; where it has errors, of their JSON
  integer, intent(out) :: length                            !! bytes of the errors (errors_json), 0: none
  !f2py threadsafe
  type(interface_type) :: joint
  type(rie_law) :: law
  type(errors_type) :: errors
  type(step_type), allocatable :: steps(:)
  type(point_type) :: point
  type(row_type), pointer :: row
  type(run_type), pointer :: run
  character(len=:), allocatable :: text
  integer :: first, i, j, status
  handle = 0
  length = 0
  text = ""
  call new_interface(props, joint, status)
  if (status /= status_ok) return
  allocate (steps(n_steps))
  first = 1
  do i = 1, n_steps
    steps(i)%place%group = "steps[" // integer_text(i - 1) // "]"
    steps(i)%place%step = i - 1
    do j = 1, n_entries
      if (counts(j, i) < 0) cycle
      steps(i)%given(j)%values = values(first:first + counts(j, i) - 1)
      first = first + counts(j, i)
    end do
  end do
  law = new_rie_law(joint)
  call complete_steps(steps, errors, error_type())
  if (errors%n == 0) call check_steps(law, steps, errors, error_type())
  if (errors%n == 0 .and. refines == 1) call explain_tolerance(tolerance, steps, errors, error_type())
  if (errors%n == 0) then
    if (point_status(joint, start(:3), start(:3), state) /= status_ok) call explain_point(joint, start(:3), start(:3), &
      state, text)
    call fail(errors, error_type(), text)
  end if
  if (errors%n == 0) then
    point = new_point(law, state, start(:3))
    if (abs(start(4)) <= huge(start)) point%work = start(4)
    allocate (run)
    call refine_path(law, steps, point, start(5), merge(tolerance, 0.0d0, refines == 1), run, text)
    call fail(errors, error_type(), text)
    if (errors%n > 0) deallocate (run)
  end if
  if (errors%n == 0) then
    allocate (row)
    handle = [transfer(c_loc(run), handle), transfer(c_loc(row), handle)]
  else
    call errors_json(errors, text)
    call new_handle(text, handle(:2), length)
  end if
end subroutine path_begin

!> Next rows of a load path, as many as there is room for. Fewer: the path is at its end.
subroutine path_next(handle, nstatv, n_columns, room, numbers, states, events, n_rows, lost, message)
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_null_ptr
  use asperity_load_path, only: explain_loss, next_row, row_type, run_type
  use asperity_rows, only: aperture_type, row_numbers
  use asperity_text, only: put_text
  implicit none
  integer, intent(in) :: handle(4)                              !! of the run
  integer, intent(in) :: nstatv                                 !! state variables of a point
  integer, intent(in) :: n_columns                              !! columns, as `columns` of the tables names them
  integer, intent(in) :: room                                   !! size of the arrays of rows
  double precision, intent(inout) :: numbers(n_columns, room)   !! numbers of each row
  double precision, intent(inout) :: states(nstatv, room)       !! STATEV
  character(len=64), intent(inout) :: events(room)              !! names joined by +, blank: none
  integer, intent(out) :: n_rows                                !! rows
  integer, intent(out) :: lost                                  !! 1: no equilibrium beyond the last row
  character(len=32768), intent(out) :: message                  !! why equilibrium was lost
  !f2py threadsafe
  type(row_type), pointer :: row
  type(run_type), pointer :: run
  character(len=:), allocatable :: text
  logical :: found
  call c_f_pointer(transfer(handle(:2), c_null_ptr), run)
  call c_f_pointer(transfer(handle(3:), c_null_ptr), row)
  message = ""
  lost = 0
  n_rows = 0
  do while (n_rows < room)
    call next_row(run, row, found)
    if (.not. found) return
    n_rows = n_rows + 1
    numbers(:, n_rows) = row_numbers(row, aperture_type())
    states(:, n_rows) = row%state
    events(n_rows) = row%events
    if (.not. row%lost) cycle
    lost = 1
    text = ""
    call explain_loss(run, row, text)
    call put_text(text, message)
    return
  end do
end subroutine path_next

!> End a load path.
subroutine path_end(handle)
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_null_ptr
  use asperity_load_path, only: row_type, run_type
  implicit none
  integer, intent(in) :: handle(4)   !! of the run
  type(row_type), pointer :: row
  type(run_type), pointer :: run
  call c_f_pointer(transfer(handle(:2), c_null_ptr), run)
  call c_f_pointer(transfer(handle(3:), c_null_ptr), row)
  deallocate (run, row)
end subroutine path_end
