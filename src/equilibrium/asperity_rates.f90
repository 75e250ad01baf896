!> Rates of traction and separation along the load path, and the error of the straight line between two rows by them.
module asperity_rates
  use asperity_control_point, only: balance_type, control_type, elastic_stiffness, free_matrix, free_part, point_type, &
    set_balance
  use asperity_elimination, only: eliminate
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_tolerances, only: worst_condition
  implicit none
  private
  public :: rate_of, line_error

  !> Rates at a point, per fraction of the load path.
  type, public :: rate_type
    logical :: known = .false.          !! false: the tangent does not determine them
    real(wp) :: traction(3) = 0.0_wp    !! stress
    real(wp) :: s(3) = 0.0_wp           !! length
  end type rate_type

contains

  !> Rates at the end of an increment by its tangent. The free separations need a tangent that determines them; viscous
  !> damage also grows while the given values stay constant, which the tangent does not contain.
  pure function rate_of(joint, control, change, point) result(rate)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given
    real(wp), intent(in) :: change(3)               !! of the given values over the load path
    type(point_type), intent(in) :: point           !! end of an increment
    type(rate_type) :: rate
    type(balance_type) :: balance
    real(wp) :: largest, matrix(3, 3), x(3)
    call set_balance(joint, control, change, balance)
    matrix = free_matrix(balance, point)
    rate%s = merge(0.0_wp, change, control%traction)
    x = free_part(balance, change - matmul(point%tangent, rate%s))
    largest = worst_condition*maxval(abs(x))/elastic_stiffness(joint)
    call eliminate(balance%n, matrix, x, rate%known)
    if (rate%known) rate%known = maxval(abs(x)) <= largest
    if (.not. rate%known) return
    rate%s(balance%free(:balance%n)) = x(:balance%n)
    rate%traction = matmul(point%tangent, rate%s)
  end function rate_of

  !> Error of the straight line over an increment as the distance to a curve with the given rates at its ends.
  !>
  !> A curve that bends to one side lies in the triangle of the line and the tangents at its ends. A parabola reaches
  !> half of the height of this triangle, a line with a kink all of it. If the curve bends to both sides, the largest
  !> distance is that of a cubic, or, if planes switch, the smaller of the changes that the rates do not explain: of a
  !> jump, both.
  pure elemental function line_error(change, first, last, kinked) result(error)
    real(wp), intent(in) :: change         !! over the increment
    real(wp), intent(in) :: first, last    !! changes over the increment by the rates at its ends
    logical, intent(in) :: kinked          !! whether planes switch within the increment
    real(wp) :: error
    !> Shares of the triangle and of the jump with a margin: the errors of the rows add to that of the line.
    real(wp), parameter :: smooth = 0.6_wp, kink = 2.0_wp
    !> Largest distance of a cubic, relative to the larger of the changes that the rates do not explain.
    real(wp), parameter :: cubic = 4.0_wp/27.0_wp
    real(wp) :: a, b
    a = abs(change - first)
    b = abs(change - last)
    if ((change - first)*(change - last) < 0.0_wp) then
      error = merge(kink, smooth, kinked)*a*b/(a + b)
    else
      error = cubic*max(a, b)
      if (kinked) error = max(error, kink*min(a, b))
    end if
  end function line_error

end module asperity_rates
