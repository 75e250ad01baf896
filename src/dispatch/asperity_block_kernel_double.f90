!> The loops over the points of a block in double precision: the kernels of two instruction sets.
module asperity_block_kernel_double
  use asperity_block_kernel_double_v1, only: update_v1 => update_block
  use asperity_block_kernel_double_v3, only: update_v3 => update_block
  use asperity_instruction_set, only: instruction_set
  use asperity_kinds, only: wp
  use asperity_types_double, only: block_type, chunk, points_type
  implicit none
  private
  include "dispatch_block.inc"
end module asperity_block_kernel_double
