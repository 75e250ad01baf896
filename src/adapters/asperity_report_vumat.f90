!> Rejected calls of the VUMATs, in hosts without routines for messages; for Abaqus see the folder abaqus.
module asperity_report_vumat
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  private
  public :: report_vumat

contains

  !> Tell on standard error why a call was rejected.
  subroutine report_vumat(routine, message)
    character(len=*), intent(in) :: routine   !! name of the user routine
    character(len=*), intent(in) :: message   !! lines that name the values and what was expected
    write (error_unit, "(4a)") "asperity ", routine, ": ", message
  end subroutine report_vumat

end module asperity_report_vumat
