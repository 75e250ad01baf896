! Utility routines with the names and arguments of Abaqus/Standard and Abaqus/Explicit. The arrays of values are not
! used.

!> Message of Abaqus/Standard.
subroutine stdb_abqerr(lop, string, intv, realv, charv)
  use, intrinsic :: iso_fortran_env, only: real64
  use abaqus_messages, only: keep_message, standard
  implicit none
  integer, intent(in) :: lop, intv(*)
  character(len=*), intent(in) :: string
  real(real64), intent(in) :: realv(*)
  character(len=8), intent(in) :: charv(*)
  if (intv(1) /= 0 .or. abs(realv(1)) > 0.0_real64 .or. charv(1) /= " ") return
  call keep_message(standard, lop, string)
end subroutine stdb_abqerr

!> End of an analysis with Abaqus/Standard.
subroutine xit()
  use abaqus_messages, only: standard
  implicit none
  standard%ends = standard%ends + 1
end subroutine xit

!> Message of Abaqus/Explicit.
subroutine xplb_abqerr(lop, string, intv, realv, charv)
  use, intrinsic :: iso_fortran_env, only: real64
  use abaqus_messages, only: explicit, keep_message
  implicit none
  integer, intent(in) :: lop, intv(*)
  character(len=*), intent(in) :: string
  real(real64), intent(in) :: realv(*)
  character(len=8), intent(in) :: charv(*)
  if (intv(1) /= 0 .or. abs(realv(1)) > 0.0_real64 .or. charv(1) /= " ") return
  call keep_message(explicit, lop, string)
end subroutine xplb_abqerr

!> End of an analysis with Abaqus/Explicit.
subroutine xplb_exit()
  use abaqus_messages, only: explicit
  implicit none
  explicit%ends = explicit%ends + 1
end subroutine xplb_exit
