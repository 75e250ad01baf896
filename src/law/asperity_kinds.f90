!> Real kind of the library, and the number of reals in a vector register.
module asperity_kinds
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  private
  !> Working precision of the law and of the UMAT.
  integer, parameter, public :: wp = real64

  !> Vector length of the loop over the planes of a point: 2 (SSE2); the build replaces it by 4 for AVX. The results of
  !> different lengths differ only by rounding.
  integer, parameter, public :: lane_width = 2
end module asperity_kinds
