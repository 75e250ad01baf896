!> The loop over the planes of a point, for AVX2.
module asperity_point_kernel_v3
  use asperity_width, only: vector_width => vector_width_v3
  include "asperity_point_kernel.inc"
end module asperity_point_kernel_v3
