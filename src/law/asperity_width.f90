!> Vectors of the loop over the planes of a point. The results of different lengths differ by rounding only.
module asperity_width
  implicit none
  private
  !> Number of doubles in a vector of SSE2 or NEON, and of AVX2; longer ones would leave more places of usual patterns
  !> empty.
  integer, parameter, public :: vector_width = 2, vector_width_v1 = 2, vector_width_v3 = 4
end module asperity_width
