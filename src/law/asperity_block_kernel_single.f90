!> The loops over the points of a block in single precision, for any processor.
module asperity_block_kernel_single
  use asperity_types_single, only:   ! for fpm, which does not read include files
  include "asperity_block_kernel_single.inc"
end module asperity_block_kernel_single
