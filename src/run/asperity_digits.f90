!> Numbers with 17 digits, which determine them exactly, as the format es24.16e3 writes them, ten times as fast: the
!> rows of a run are numbers, and a formatted write of each was most of the time of a run.
module asperity_digits
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_kinds, only: wp
  implicit none
  private
  public :: put_digits

  !> Largest number of characters.
  integer, parameter, public :: most_digits = 24

  !> Powers of ten that are exact in double precision.
  integer, parameter :: exact = 22
  real(wp), parameter :: tens(0:exact) = [ &
    1.0e0_wp, 1.0e1_wp, 1.0e2_wp, 1.0e3_wp, 1.0e4_wp, 1.0e5_wp, 1.0e6_wp, 1.0e7_wp, &
    1.0e8_wp, 1.0e9_wp, 1.0e10_wp, 1.0e11_wp, 1.0e12_wp, 1.0e13_wp, 1.0e14_wp, 1.0e15_wp, &
    1.0e16_wp, 1.0e17_wp, 1.0e18_wp, 1.0e19_wp, 1.0e20_wp, 1.0e21_wp, 1.0e22_wp]
  !> The 17 digits are a whole number from the first of these on, below the second; at or beyond it the format decides.
  integer(int64), parameter :: least = 10_int64**16, beyond = 10_int64**17

contains

  !> Write a number with 17 digits: sign where negative, a digit, a point, 16 digits, and an exponent of three digits.
  !>
  !> The digits are those of the number times a power of ten, which is formed as a sum of two numbers. The format
  !> writes what this cannot decide: a last digit whose rounding is close, sizes without an exact power, NaN, infinity.
  pure subroutine put_digits(value, text, length)
    real(wp), intent(in) :: value                       !! any bits
    character(len=most_digits), intent(out) :: text     !! the number, then blanks
    integer, intent(out) :: length                      !! characters of the number
    real(wp), parameter :: close = 1.0e-6_wp   ! of the last digit; the sum is wrong by less than 1e-13 of it
    real(wp) :: high, low, fraction
    integer(int64) :: digits
    integer :: exponent, first, i

    digits = 0
    exponent = 0
    if (.not. ieee_is_finite(value)) then
      digits = beyond
    else if (abs(value) > 0.0_wp) then
      exponent = floor(log10(abs(value)))
      if (16 - exponent < -exact .or. 16 - exponent > 2*exact) then
        digits = beyond
      else
        call scale_by_ten(abs(value), 16 - exponent, high, low)
        ! the first part is a whole number, as it is larger than 2**53, or the logarithm has been rounded up
        digits = int(high, int64) + floor(low, int64)
        fraction = low - floor(low)
        if (digits < least .or. abs(fraction - 0.5_wp) < close) digits = beyond
        if (fraction > 0.5_wp) digits = digits + 1
      end if
    end if
    if (digits >= beyond) then
      write (text, "(es24.16e3)") value
      text = adjustl(text)
      length = len_trim(text)
      return
    end if

    text = "-"
    first = merge(1, 0, sign(1.0_wp, value) < 0.0_wp)
    do i = 18, 3, -1
      text(first + i:first + i) = digit(int(mod(digits, 10_int64)))
      digits = digits/10
    end do
    text(first + 1:first + 2) = digit(int(digits)) // "."
    text(first + 19:first + 20) = merge("E-", "E+", exponent < 0)
    exponent = abs(exponent)
    text(first + 21:) = digit(exponent/100) // digit(mod(exponent/10, 10)) // digit(mod(exponent, 10))
    length = first + 23
  end subroutine put_digits

  !> The character of a digit.
  elemental function digit(value) result(text)
    integer, intent(in) :: value   !! from 0 to 9
    character(len=1) :: text
    text = achar(iachar("0") + value)
  end function digit

  !> A number times a power of ten, as a sum of two numbers.
  pure subroutine scale_by_ten(value, n, high, low)
    real(wp), intent(in) :: value        !! not negative
    integer, intent(in) :: n             !! the power, from -exact to 2 exact
    real(wp), intent(out) :: high, low   !! the sum, and what it has beyond the first
    if (n < 0) then
      high = value/tens(-n)
      low = ((value - high*tens(-n)) - lost(high, tens(-n)))/tens(-n)
      return
    end if
    high = value*tens(min(n, exact))
    low = lost(value, tens(min(n, exact)))
    if (n <= exact) return
    low = low*tens(n - exact) + lost(high, tens(n - exact))
    high = high*tens(n - exact)
  end subroutine scale_by_ten

  !> What the rounding of a product loses, by Dekker's products of halves (Numerische Mathematik 18, 1971, 224-242).
  pure function lost(a, b) result(error)
    real(wp), intent(in) :: a, b   !! the factors
    real(wp) :: error
    real(wp) :: upper_a, upper_b
    upper_a = upper_half(a)
    upper_b = upper_half(b)
    error = ((upper_a*upper_b - a*b) + upper_a*(b - upper_b) + (a - upper_a)*upper_b) + (a - upper_a)*(b - upper_b)
  end function lost

  !> A number with the upper half of its digits.
  pure function upper_half(a) result(upper)
    real(wp), intent(in) :: a   !! any below 1e300
    real(wp) :: upper
    real(wp), parameter :: splitter = 2.0_wp**27 + 1.0_wp
    upper = splitter*a
    upper = upper - (upper - a)
  end function upper_half

end module asperity_digits
