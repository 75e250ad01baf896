!> The loops over the points of a block in double precision, for any processor.
module asperity_block_kernel_double
  include "asperity_block_kernel_double.inc"
end module asperity_block_kernel_double
