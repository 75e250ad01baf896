!> Real kind of the library, and how many of that kind a vector of the processor holds.
module asperity_kinds
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  private
  !> Working precision of the law and of the UMAT.
  integer, parameter, public :: wp = real64

  !> Planes of a point are worked on in vectors of this length: 2 with SSE2; the build puts 4 where there is AVX.
  !> Results differ by rounding alone.
  integer, parameter, public :: lane_width = 2
end module asperity_kinds
