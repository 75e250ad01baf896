!> Real kind of the library.
module asperity_kinds
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  private
  !> Working precision of the law and of the UMAT.
  integer, parameter, public :: wp = real64
end module asperity_kinds
