!> Real kinds of the library.
module asperity_kinds
  use, intrinsic :: iso_fortran_env, only: real32, real64
  implicit none
  private
  !> Working precision of the law and of the UMAT.
  integer, parameter, public :: wp = real64
  !> That of the VUMAT in single precision, whose modules of the law the build makes (cmake/FortranUnit.cmake).
  integer, parameter, public :: sp = real32
end module asperity_kinds
