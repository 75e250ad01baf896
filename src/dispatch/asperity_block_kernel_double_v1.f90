!> The loops over the points of a block in double precision, for any processor of x86-64.
module asperity_block_kernel_double_v1
  include "asperity_block_kernel_double.inc"
end module asperity_block_kernel_double_v1
