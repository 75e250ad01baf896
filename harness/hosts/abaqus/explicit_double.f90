!> Material points of Abaqus/Explicit in double precision.
module explicit_double
  use, intrinsic :: iso_fortran_env, only: wp => real64
  use user_library, only: vumat_routine => vumat_call
  implicit none
  private
  public :: new_domain, advance
  include "explicit_points.inc"
end module explicit_double
