!> Rejected calls of the UMAT, in hosts without routines for messages; for Abaqus see the folder abaqus.
module asperity_report_umat
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  private
  public :: report_umat

contains

  !> Tell on standard error why a call was rejected.
  subroutine report_umat(message)
    character(len=*), intent(in) :: message   !! lines that name the values and what was expected
    write (error_unit, "(2a)") "asperity umat: ", message
  end subroutine report_umat

end module asperity_report_umat
