!> The loops over the points of a block in double precision, for AVX2.
module asperity_block_kernel_double_v3
  include "asperity_block_kernel_double.inc"
end module asperity_block_kernel_double_v3
