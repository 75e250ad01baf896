!> Vectors of the loop over the planes of a point, with AVX.
module asperity_width_v3
  implicit none
  private
  !> Number of doubles in a vector of AVX2; longer ones would leave more lanes of usual patterns empty.
  integer, parameter, public :: lane_width = 4
end module asperity_width_v3
