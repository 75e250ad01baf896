!> The loops over the points of a block in single precision: the kernels of two instruction sets.
module asperity_block_kernel_single
  use, intrinsic :: iso_fortran_env, only: wp => real32
  use asperity_block_kernel_single_v1, only: columns_v1 => columns_bounded, update_v1 => update_block
  use asperity_block_kernel_single_v3, only: columns_v3 => columns_bounded, update_v3 => update_block
  use asperity_instruction_set, only: instruction_set
  use asperity_types_single, only: block_type, chunk, points_type
  implicit none
  private
  public :: columns_bounded, update_block

contains

  include "dispatch_block.inc"

end module asperity_block_kernel_single
