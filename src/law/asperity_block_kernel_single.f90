!> The loops over the points of a block in single precision, for any processor.
module asperity_block_kernel_single
  include "asperity_block_kernel_single.inc"
end module asperity_block_kernel_single
