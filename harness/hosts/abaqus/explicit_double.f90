!> Material points of Abaqus/Explicit in double precision.
module explicit_double
  use, intrinsic :: iso_fortran_env, only: wp => real64
  use host_routines, only: vumat_routine => vumat
  implicit none
  private
  public :: new_domain, advance
  include "explicit_points.inc"
end module explicit_double
