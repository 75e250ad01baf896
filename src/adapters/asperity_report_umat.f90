!> Report of a rejected call of the UMAT in hosts without message routines; the folder abaqus has that for Abaqus.
module asperity_report_umat
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  private
  public :: report_umat

contains

  !> Write why a call was rejected to standard error.
  subroutine report_umat(message)
    character(len=*), intent(in) :: message   !! lines that name the values and what was expected
    write (error_unit, "(2a)") "asperity umat: ", message
    flush (error_unit)  ! the host may end at once
  end subroutine report_umat

end module asperity_report_umat
