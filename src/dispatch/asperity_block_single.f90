!> The law for blocks of points in single precision: the kernels of two instruction sets.
module asperity_block_single
  use, intrinsic :: iso_fortran_env, only: wp => real32
  use asperity_block_single_v1, only: block_type, chunk, largest_energy, largest_separation, new_block, points_type, &
    update_v1 => update_block
  use asperity_block_single_v3, only: update_v3 => update_block
  use asperity_instruction_set, only: instruction_set
  implicit none
  private
  include "dispatch_block.inc"
end module asperity_block_single
