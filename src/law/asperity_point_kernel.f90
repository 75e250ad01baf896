!> The loop over the planes of a point, for any processor.
module asperity_point_kernel
  use asperity_interface, only:   ! for fpm, which does not read include files
  use asperity_types_double, only:   ! for fpm, which does not read include files
  use asperity_width, only: vector_width
  include "asperity_point_kernel.inc"
end module asperity_point_kernel
