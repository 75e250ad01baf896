!> The loops over the points of a block in double precision, for any processor.
module asperity_block_kernel_double
  use asperity_checks, only:   ! for fpm, which does not read include files
  use asperity_types_double, only:   ! for fpm, which does not read include files
  include "asperity_block_kernel_double.inc"
end module asperity_block_kernel_double
