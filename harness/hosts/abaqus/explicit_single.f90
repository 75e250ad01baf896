!> Material points of Abaqus/Explicit in single precision.
module explicit_single
  use, intrinsic :: iso_fortran_env, only: wp => real32
  use host_routines, only: vumat_routine => vumat_single
  implicit none
  private
  public :: new_domain, advance
  include "explicit_points.inc"
end module explicit_single
