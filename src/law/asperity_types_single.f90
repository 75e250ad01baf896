!> Types of the law in single precision.
module asperity_types_single
  use, intrinsic :: iso_fortran_env, only: real64, wp => real32
  use asperity_contract, only: energy_limit, max_planes, separation_limit
  implicit none
  private
  public :: numbers_type, material_type
  include "asperity_constants.inc"
  include "asperity_types.inc"
end module asperity_types_single
