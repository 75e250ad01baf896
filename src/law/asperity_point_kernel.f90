!> The loop over the planes of a point, for any processor.
module asperity_point_kernel
  use asperity_width, only: lane_width
  include "asperity_point_kernel.inc"
end module asperity_point_kernel
