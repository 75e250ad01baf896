!> Report of a rejected call in hosts without message routines; the folder abaqus has that for Abaqus.
module asperity_report
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  private
  public :: report

contains

  !> Write why a call was rejected to standard error.
  subroutine report(routine, message)
    character(len=*), intent(in) :: routine   !! name of the user routine
    character(len=*), intent(in) :: message   !! lines that name the values and what was expected
    write (error_unit, "(4a)") "asperity ", routine, ": ", message
    flush (error_unit)  ! the host may end at once
  end subroutine report

end module asperity_report
