!> Wall clock and median.
module timing
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none
  private
  public :: now, median

contains

  !> Time from an arbitrary start, nanoseconds.
  function now() result(t)
    real(real64) :: t
    integer(int64) :: count, rate
    call system_clock(count, rate)
    t = 1.0e9_real64*real(count, real64)/real(rate, real64)
  end function now

  !> The lower median: at least half of the values are not larger, at least half not smaller.
  pure function median(x) result(middle)
    real(real64), intent(in) :: x(:)   !! values, at least one
    real(real64) :: middle
    integer :: i, half
    half = (size(x) + 1)/2
    middle = x(1)
    do i = 1, size(x)
      if (count(x < x(i)) < half .and. count(x <= x(i)) >= half) middle = x(i)
    end do
  end function median

end module timing
