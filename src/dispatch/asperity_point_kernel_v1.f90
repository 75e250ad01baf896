!> The loop over the planes of a point, for any processor of x86-64.
module asperity_point_kernel_v1
  use asperity_width, only: vector_width
  include "asperity_point_kernel.inc"
end module asperity_point_kernel_v1
