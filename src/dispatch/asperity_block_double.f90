!> The law for blocks of points in double precision: the kernels of two instruction sets.
module asperity_block_double
  use asperity_block_double_v1, only: block_type, chunk, largest_energy, largest_separation, new_block, points_type, &
    update_v1 => update_block
  use asperity_block_double_v3, only: update_v3 => update_block
  use asperity_instruction_set, only: instruction_set
  use asperity_kinds, only: wp
  implicit none
  private
  include "dispatch_block.inc"
end module asperity_block_double
