!> Linear equations whose coefficients are known and whose constants are known to bounded errors.
module asperity_bounded_equations
  use asperity_kinds, only: wp
  implicit none
  private
  public :: bound_solutions, equations_type

  !> One to three equations 0 = centre + slope . xi + error for as many coordinates xi from -1 to 1.
  type :: equations_type
    integer :: n = 0                                    !! number of equations and of coordinates
    real(wp) :: centre(3) = 0.0_wp                      !! constants
    real(wp) :: generators(3, 6) = 0.0_wp               !! n columns of slopes, n of the errors of the equations
    real(wp) :: low(3) = -1.0_wp, high(3) = 1.0_wp      !! bounds of the coordinates of solutions
    logical :: solvable = .true.                        !! whether there may be a solution
  end type equations_type

contains

  !> Find bounds of the coordinates in linear equations, or that there is no solution.
  !>
  !> The values that centre + slope . xi + error may have form a polyhedron, every face of which contains the directions
  !> of two generators (of one, if there are two equations). The equations have no solution if zero is outside a face.
  pure subroutine bound_solutions(equations)
    type(equations_type), intent(inout) :: equations   !! bounds of the coordinates are set
    integer :: i, j
    associate (g => equations%generators)
      select case (equations%n)
      case (1)
        call cut(equations, [1.0_wp, 0.0_wp, 0.0_wp])
      case (2)
        do i = 1, size(g, 2)
          call cut(equations, [-g(2, i), g(1, i), 0.0_wp])
        end do
      case default
        do i = 1, size(g, 2)
          do j = i + 1, size(g, 2)
            call cut(equations, [g(2, i)*g(3, j) - g(3, i)*g(2, j), g(3, i)*g(1, j) - g(1, i)*g(3, j), &
              g(1, i)*g(2, j) - g(2, i)*g(1, j)])
          end do
        end do
      end select
    end associate
  end subroutine bound_solutions

  !> Find bounds of the coordinates from a linear combination of the equations.
  pure subroutine cut(equations, weights)
    type(equations_type), intent(inout) :: equations   !! bounds of the coordinates are improved
    real(wp), intent(in) :: weights(3)                 !! of the equations
    !> Rounding errors of the sums, and the smallest coefficient of a coordinate that is divided by, relative to the
    !> magnitudes of the terms.
    real(wp), parameter :: rounding = 32.0_wp*epsilon(1.0_wp), smallest = 1.0e-6_wp
    real(wp) :: centre, coefficients(6), ends(2), most, rest, terms
    integer :: j
    if (.not. equations%solvable) return
    centre = sum(weights*equations%centre)
    terms = sum(abs(weights*equations%centre))
    do j = 1, size(coefficients)
      coefficients(j) = sum(weights*equations%generators(:, j))
      terms = terms + sum(abs(weights*equations%generators(:, j)))
    end do
    most = sum(abs(coefficients)) + rounding*terms
    equations%solvable = .not. abs(centre) > most
    do j = 1, equations%n
      if (.not. abs(coefficients(j)) > smallest*terms) cycle
      rest = most - abs(coefficients(j))
      ends = [-centre - rest, -centre + rest]/coefficients(j)
      equations%low(j) = max(equations%low(j), minval(ends))
      equations%high(j) = min(equations%high(j), maxval(ends))
    end do
  end subroutine cut

end module asperity_bounded_equations
