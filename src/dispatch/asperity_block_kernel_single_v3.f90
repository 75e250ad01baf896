!> The loops over the points of a block in single precision, for AVX2.
module asperity_block_kernel_single_v3
  include "asperity_block_kernel_single.inc"
end module asperity_block_kernel_single_v3
