!> Load paths of the suites: steps as a user gives them, and their rows.
module support_path
  use asperity_control_point, only: point_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_load_path, only: begin_run, next_row, row_type, run_type
  use asperity_steps, only: complete_steps, step_table, step_type
  implicit none
  private
  public :: give, complete, run_rows

contains

  !> Give an entry of a step its values.
  subroutine give(step, name, values)
    type(step_type), intent(inout) :: step      !! the step
    character(len=*), intent(in) :: name        !! of the entry
    real(wp), intent(in) :: values(:)           !! its values
    integer :: i
    do i = 1, size(step_table)
      if (step_table(i)%name == name) exit
    end do
    if (i > size(step_table)) error stop "support_path: a test gives an entry that no step has"
    step%given(i)%values = values
  end subroutine give

  !> Complete steps; the lines of the errors.
  function complete(steps) result(message)
    type(step_type), intent(inout) :: steps(:)      !! with their entries -> complete where there is no error
    character(len=:), allocatable :: message
    integer :: i
    do i = 1, size(steps)
      steps(i)%place = "step: "
    end do
    message = ""
    call complete_steps(steps, "path: ", message)
  end function complete

  !> Rows of a path whose steps are admissible.
  subroutine run_rows(joint, steps, rows, run, start)
    type(interface_type), intent(in) :: joint                 !! the interface
    type(step_type), intent(inout) :: steps(:)                !! with their entries
    type(row_type), allocatable, intent(out) :: rows(:)       !! the rows
    type(run_type), intent(out) :: run                        !! the run at its end
    type(point_type), intent(in), optional :: start           !! absent: virgin
    type(row_type), allocatable :: more(:)
    type(row_type) :: row
    integer :: n
    logical :: found
    if (len(complete(steps)) > 0) error stop "support_path: a test runs inadmissible steps"
    call begin_run(joint, steps, run, start)
    allocate (rows(64))
    n = 0
    do
      call next_row(run, row, found)
      if (.not. found) exit
      if (n == size(rows)) then
        allocate (more(2*n))
        more(:n) = rows
        call move_alloc(more, rows)
      end if
      n = n + 1
      rows(n) = row
    end do
    rows = rows(:n)
  end subroutine run_rows

end module support_path
