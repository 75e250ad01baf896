!> Types of the law in double precision.
module asperity_types_double
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_contract, only: energy_limit, max_planes, separation_limit
  use asperity_kinds, only: wp
  use asperity_material, only: material_type
  implicit none
  private
  include "asperity_types.inc"
end module asperity_types_double
