!> Vectors of the loop over the planes of a point. The results of different lengths differ by rounding only.
module asperity_width
  implicit none
  private
  !> Number of doubles in a vector of SSE2 or NEON.
  integer, parameter, public :: lane_width = 2
end module asperity_width
