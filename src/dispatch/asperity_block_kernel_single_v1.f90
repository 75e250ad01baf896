!> The loops over the points of a block in single precision, for any processor of x86-64.
module asperity_block_kernel_single_v1
  include "asperity_block_kernel_single.inc"
end module asperity_block_kernel_single_v1
