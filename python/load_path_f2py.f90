! Load paths in the shape f2py reads (see asperity_f2py.f90).

!> Rows of a load path.
subroutine path_rows(nprops, props, nstatv, n_entries, n_steps, counts, n_values, values, start, state, refines, &
                     tolerance, n_columns, room, numbers, states, events, n_rows, lost, status, message)
  use asperity_call_checks, only: explain_point, point_status
  use asperity_contract, only: status_ok, status_separation
  use asperity_equations, only: new_point, point_type
  use asperity_errors, only: error_type, errors_type, fail, put_records
  use asperity_interface, only: interface_type, new_interface
  use asperity_load_path, only: explain_loss, next_row, row_type, run_type
  use asperity_refine, only: explain_tolerance, refine_path
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_rows, only: row_numbers
  use asperity_steps, only: check_steps, complete_steps, step_type
  use asperity_text, only: integer_text, put_text
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
  integer, intent(in) :: room                               !! size of the arrays of rows
  integer, intent(in) :: n_columns                          !! columns, as table_row names them
  double precision, intent(inout) :: numbers(n_columns, room)   !! numbers of each row
  double precision, intent(inout) :: states(nstatv, room)   !! STATEV
  character(len=64), intent(inout) :: events(room)          !! names joined by +, blank: none
  integer, intent(out) :: n_rows                            !! rows; those beyond the room are counted, not kept
  integer, intent(out) :: lost                              !! 1: no equilibrium beyond the last row
  integer, intent(out) :: status                            !! 0 or status_separation
  character(len=32768), intent(out) :: message              !! errors (put_records), or why equilibrium was lost
  !f2py threadsafe
  type(interface_type) :: joint
  type(rie_law) :: law
  type(errors_type) :: errors
  type(step_type), allocatable :: steps(:)
  type(point_type) :: point
  type(run_type) :: run
  type(row_type) :: row
  character(len=:), allocatable :: text
  integer :: first, i, j
  logical :: found
  n_rows = 0
  lost = 0
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
  if (errors%n == 0 .and. refines == 1) call explain_tolerance(tolerance, steps, errors, &
    error_type())
  if (errors%n == 0) then
    if (point_status(joint, start(:3), start(:3), state) /= status_ok) call explain_point(joint, start(:3), start(:3), &
      state, text)
    call fail(errors, error_type(), text)
  end if
  if (errors%n == 0) then
    point = new_point(law, state, start(:3))
    if (abs(start(4)) <= huge(start)) point%work = start(4)
    call refine_path(law, steps, point, start(5), merge(tolerance, 0.0d0, refines == 1), run, text)
    call fail(errors, error_type(), text)
  end if
  do while (errors%n == 0)
    call next_row(run, row, found)
    if (.not. found) exit
    n_rows = n_rows + 1
    if (n_rows > room) cycle
    numbers(:, n_rows) = row_numbers(row)
    states(:, n_rows) = row%state
    events(n_rows) = row%events
  end do
  if (errors%n > 0) then
    status = status_separation
    text = ""
    call put_records(errors, text)
  else if (row%lost) then
    lost = 1
    call explain_loss(run, row, text)
  end if
  call put_text(text, message)
end subroutine path_rows
