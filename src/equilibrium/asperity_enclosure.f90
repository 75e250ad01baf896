!> Arithmetic with numbers that depend on the place in a box, of which only enclosures are known.
!>
!> A place in the box has three coordinates from -1 to 1. A number differs from a linear function of them by at most an
!> error, and it lies between two bounds. Every operation keeps both true for every place in the box, rounding errors
!> included. Where a function is smooth, the error falls with the square of the size of the box; the bounds hold also
!> where boxes are too large for this.
module asperity_enclosure
  use asperity_kinds, only: wp
  implicit none
  private
  public :: enclosure_type, constant, coordinate, unknown, sum_of, difference_of, multiple, combination, product_of, &
    limited, secant, positive_part, reciprocal, norm_of, size_of

  !> Enclosure of a number.
  type :: enclosure_type
    real(wp) :: centre = 0.0_wp               !! linear function in the middle of the box
    real(wp) :: slope(3) = 0.0_wp             !! its derivatives with respect to the coordinates
    real(wp) :: error = 0.0_wp                !! largest distance from the linear function
    real(wp) :: low = 0.0_wp, high = 0.0_wp   !! bounds
  end type enclosure_type

  !> Rounding errors of an operation, relative to the magnitudes of its terms.
  real(wp), parameter, public :: ulp = 8.0_wp*epsilon(1.0_wp)

contains

  !> A number that is the same everywhere.
  pure function constant(value) result(c)
    real(wp), intent(in) :: value   !! any
    type(enclosure_type) :: c
    c = enclosure_type(centre=value, low=value, high=value)
  end function constant

  !> A quantity that is proportional to one of the coordinates of the box.
  pure function coordinate(i, low, high) result(c)
    integer, intent(in) :: i              !! the coordinate
    real(wp), intent(in) :: low, high     !! at -1 and 1
    type(enclosure_type) :: c
    c = constant(low)
    if (.not. high > low) return
    c%high = high
    c%slope(i) = 0.5_wp*(high - low)
    c%centre = low + c%slope(i)
    c%error = ulp*max(-low, high)
  end function coordinate

  !> A number of which only bounds are known.
  pure function unknown(low, high) result(c)
    real(wp), intent(in) :: low, high     !! bounds
    type(enclosure_type) :: c
    c%low = low
    c%high = high
    c%error = 0.5_wp*(high - low)
    c%centre = low + c%error
    c%error = c%error + ulp*max(-low, high)
  end function unknown

  !> Sum of two numbers.
  pure function sum_of(a, b) result(c)
    type(enclosure_type), intent(in) :: a, b   !! its terms
    type(enclosure_type) :: c
    c = enclosure_type(a%centre + b%centre, a%slope + b%slope, a%error + b%error, a%low + b%low, a%high + b%high)
    call settle(c)
  end function sum_of

  !> Difference of two numbers.
  pure function difference_of(a, b) result(c)
    type(enclosure_type), intent(in) :: a, b   !! its terms
    type(enclosure_type) :: c
    c = sum_of(a, enclosure_type(-b%centre, -b%slope, b%error, -b%high, -b%low))
  end function difference_of

  !> A multiple of a number.
  pure function multiple(factor, a) result(c)
    real(wp), intent(in) :: factor             !! any
    type(enclosure_type), intent(in) :: a      !! the number
    type(enclosure_type) :: c
    c = enclosure_type(factor*a%centre, factor*a%slope, abs(factor)*a%error, min(factor*a%low, factor*a%high), &
      max(factor*a%low, factor*a%high))
    call settle(c)
  end function multiple

  !> A sum of multiples of three numbers.
  pure function combination(factors, a) result(c)
    real(wp), intent(in) :: factors(3)         !! any
    type(enclosure_type), intent(in) :: a(3)   !! the numbers
    type(enclosure_type) :: c
    real(wp) :: rounding
    integer :: i
    rounding = 0.0_wp
    do i = 1, 3
      c%centre = c%centre + factors(i)*a(i)%centre
      c%slope = c%slope + factors(i)*a(i)%slope
      c%error = c%error + abs(factors(i))*a(i)%error
      c%low = c%low + min(factors(i)*a(i)%low, factors(i)*a(i)%high)
      c%high = c%high + max(factors(i)*a(i)%low, factors(i)*a(i)%high)
      rounding = rounding + ulp*abs(factors(i))*size_of(a(i))
    end do
    c%error = c%error + rounding
    c%low = c%low - rounding
    c%high = c%high + rounding
    call settle(c)
  end function combination

  !> Product of two numbers.
  pure function product_of(a, b) result(c)
    type(enclosure_type), intent(in) :: a, b   !! its factors
    type(enclosure_type) :: c
    real(wp) :: corners(4), of_a, of_b
    corners = [a%low*b%low, a%low*b%high, a%high*b%low, a%high*b%high]
    c%low = min(corners(1), corners(2), corners(3), corners(4))
    c%high = max(corners(1), corners(2), corners(3), corners(4))
    of_a = radius(a)
    of_b = radius(b)
    c%centre = a%centre*b%centre
    c%slope = a%centre*b%slope + b%centre*a%slope
    c%error = abs(a%centre)*b%error + abs(b%centre)*a%error + of_a*of_b
    ! what `settle` adds is more than the rounding errors of a slope whose terms cancel: with x = of_a/|a%centre| and y
    ! alike, x + y <= |x - y| + 1 + x y
    call settle(c)
  end function product_of

  !> A number that is known to lie between further bounds.
  pure function limited(a, low, high) result(c)
    type(enclosure_type), intent(in) :: a      !! the number
    real(wp), intent(in) :: low, high          !! bounds
    type(enclosure_type) :: c
    c = a
    c%low = max(a%low, low)
    c%high = min(a%high, high)
    call settle(c)
  end function limited

  !> A function f of a number, from a straight line near it: f lies between value + slope (a - from) + below and the
  !> same + above.
  pure function secant(a, from, value, slope, below, above, low, high) result(c)
    type(enclosure_type), intent(in) :: a              !! the number
    real(wp), intent(in) :: from, value, slope         !! the line
    real(wp), intent(in) :: below, above               !! smallest and largest distance of f from it
    real(wp), intent(in) :: low, high                  !! bounds of f
    type(enclosure_type) :: c
    c%centre = value + slope*(a%centre - from) + 0.5_wp*(below + above)
    c%slope = slope*a%slope
    c%error = abs(slope)*a%error + 0.5_wp*(above - below)
    ! terms that cancel, one of which is one of these
    c%error = c%error + ulp*max(abs(value), abs(slope*(a%centre - from)))
    c%low = low
    c%high = high
    call settle(c)
  end function secant

  !> Positive part of a number: it is convex, so that it lies between the chord and the chord less the distance at 0.
  pure function positive_part(a) result(c)
    type(enclosure_type), intent(in) :: a      !! the number
    type(enclosure_type) :: c
    real(wp) :: slope
    c = constant(0.0_wp)
    if (a%low >= 0.0_wp) then
      c = a
    else if (a%high > 0.0_wp) then
      slope = a%high/(a%high - a%low)
      c = secant(a, 0.0_wp, 0.0_wp, slope, 0.0_wp, -slope*a%low, 0.0_wp, a%high)
    end if
  end function positive_part

  !> Reciprocal of a positive number: it is convex, and farthest from the chord at the geometric mean of the bounds.
  pure function reciprocal(a) result(c)
    type(enclosure_type), intent(in) :: a      !! the number, bounds > 0
    type(enclosure_type) :: c
    real(wp) :: slope
    slope = -1.0_wp/a%low/a%high
    c = secant(a, 0.0_wp, 0.0_wp, slope, 2.0_wp*sqrt(-slope), 1.0_wp/a%low + 1.0_wp/a%high, 1.0_wp/a%high, 1.0_wp/a%low)
  end function reciprocal

  !> Norm of a vector: at least its component y in the direction of the middle of the box, and at most y + z**2/(2 y)
  !> with the component z across it.
  pure function norm_of(a) result(c)
    type(enclosure_type), intent(in) :: a(3)   !! the vector
    type(enclosure_type) :: c
    type(enclosure_type) :: along
    real(wp) :: above, direction(3), far(3), low, near(3), norm
    integer :: i
    do i = 1, 3
      near(i) = max(0.0_wp, a(i)%low, -a(i)%high)
      far(i) = max(-a(i)%low, a(i)%high)
      direction(i) = a(i)%centre
    end do
    low = sqrt(near(1)**2 + near(2)**2 + near(3)**2)*(1.0_wp - ulp)
    c = unknown(low, sqrt(far(1)**2 + far(2)**2 + far(3)**2)*(1.0_wp + ulp))
    norm = sqrt(direction(1)**2 + direction(2)**2 + direction(3)**2)
    if (.not. norm > 0.0_wp) return
    along = combination(direction/norm, a)
    if (.not. along%low > 0.0_wp) return
    above = 0.5_wp*(radius(a(1))**2 + radius(a(2))**2 + radius(a(3))**2)/along%low
    c = secant(along, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, above, low, c%high)
  end function norm_of

  !> Largest magnitude of the terms that describe a number. Rounding errors of sums are proportional to it.
  pure function size_of(a) result(largest)
    type(enclosure_type), intent(in) :: a      !! the number
    real(wp) :: largest
    largest = abs(a%centre) + radius(a)
  end function size_of

  !> Largest distance of a number from its value in the middle of the box, by the linear function.
  pure function radius(a) result(distance)
    type(enclosure_type), intent(in) :: a      !! the number
    real(wp) :: distance
    distance = abs(a%slope(1)) + abs(a%slope(2)) + abs(a%slope(3)) + a%error
  end function radius

  !> Add the rounding errors of the operation that made a number, and let linear function and bounds improve each other.
  pure subroutine settle(a)
    type(enclosure_type), intent(inout) :: a   !! the number
    real(wp) :: rounding, reach
    reach = radius(a)
    rounding = ulp*(abs(a%centre) + reach)
    a%error = a%error + rounding
    reach = reach + 2.0_wp*rounding
    a%low = max(a%low - ulp*abs(a%low), a%centre - reach)
    a%high = min(a%high + ulp*abs(a%high), a%centre + reach)
    if (a%high - a%low < 2.0_wp*a%error) a = unknown(a%low, a%high)
  end subroutine settle

end module asperity_enclosure
