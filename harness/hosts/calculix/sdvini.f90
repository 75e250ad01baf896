!> Initial state variables of CalculiX (*INITIAL CONDITIONS, TYPE=SOLUTION, USER), read from a file.
!>
!> The file initial_state.txt in the folder of the run has a row for each integration point: element, point and all
!> state variables (as many as the largest *DEPVAR). The rows are in rising order of element and point. A point without
!> a row is virgin. CalculiX calls this routine once for each point, in that order and by one thread; therefore the file
!> stays open and is read once. After the last row was used, a line is written to standard output. If this line is
!> missing, the file has rows of points that CalculiX does not have. This routine replaces the sdvini of CalculiX, which
!> sets all state variables to 1.
subroutine sdvini(statev, coords, nstatv, ncrds, noel, npt, layer, kspt)
  use, intrinsic :: iso_fortran_env, only: error_unit, iostat_end, output_unit, real64
  implicit none
  integer, intent(in) :: nstatv                    !! state variables of the model
  integer, intent(in) :: ncrds                     !! components of coords
  integer, intent(in) :: noel, npt                 !! element and integration point
  integer, intent(in) :: layer, kspt               !! not used
  real(real64), intent(in) :: coords(ncrds)        !! of the point, not used
  real(real64), intent(out) :: statev(nstatv)      !! initial values
  character(len=*), parameter :: name = "initial_state.txt"
  integer, parameter :: longest = 8192             !! of a row: 203 numbers of 25 characters and more
  character(len=longest) :: row
  real(real64) :: beyond
  integer :: element, point, status, unit
  logical :: opened, ended

  statev = 0.0_real64
  inquire (file=name, opened=opened, number=unit)
  if (.not. opened) then
    open (newunit=unit, file=name, status="old", action="read", iostat=status)
    if (status /= 0) call fail("expected a file with rows of element, point, state variables")
  end if
  call next_row()
  if (.not. ended) then
    read (row, *, iostat=status) element, point
    if (status /= 0) call fail(trim(row) // ": expected element and point, then the state variables")
    if (element < noel .or. (element == noel .and. point < npt)) then
      call fail(trim(row) // ": expected points of the model in rising order")
    end if
    if (element == noel .and. point == npt) then
      read (row, *, iostat=status) element, point, statev
      if (status /= 0) call fail(trim(row) // ": too few state variables")
      read (row, *, iostat=status) element, point, statev, beyond
      if (status == 0) call fail(trim(row) // ": too many state variables")
      call next_row()
      if (ended) write (output_unit, "(3a)") "sdvini: ", name, ": every row has found its point"
    end if
  end if
  backspace (unit)   ! the next point reads this row, or the end, again

contains

  !> Read the next row that is not empty, or the end of the file.
  subroutine next_row()
    do
      read (unit, "(a)", iostat=status) row
      ended = status == iostat_end
      if (ended) return
      if (status /= 0) call fail("cannot be read: expected rows of element, point, state variables")
      if (len_trim(row) > 0) return
    end do
  end subroutine next_row

  !> End the run, as CalculiX does for an error in its input.
  subroutine fail(message)
    character(len=*), intent(in) :: message   !! what is wrong and what was expected
    integer, parameter :: input_error = 201
    write (error_unit, "(4a)") "sdvini: ", name, ": ", message
    stop input_error
  end subroutine fail

end subroutine sdvini
