!> Report of a rejected call of a VUMAT in hosts without message routines; the folder abaqus has that for Abaqus.
module asperity_report_vumat
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  private
  public :: report_vumat

contains

  !> Write why a call was rejected to standard error.
  subroutine report_vumat(routine, message)
    character(len=*), intent(in) :: routine   !! name of the user routine
    character(len=*), intent(in) :: message   !! lines that name the values and what was expected
    write (error_unit, "(4a)") "asperity ", routine, ": ", message
    flush (error_unit)  ! the host may end at once
  end subroutine report_vumat

end module asperity_report_vumat
