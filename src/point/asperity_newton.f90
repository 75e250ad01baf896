!> Semismooth Newton method with a line search for the prescribed tractions. At a kink of the law the consistent tangent
!> is the derivative of the side on which the iterate lies.
module asperity_newton
  use asperity_equations, only: book, equations_type, evaluate, free_matrix, point_type, unstable
  use asperity_elimination, only: eliminate
  use asperity_kinds, only: wp
  use asperity_point_law, only: point_law
  use asperity_tolerances, only: decrease, most_iterations, residual_tolerance, shortest_step, worst_condition
  implicit none
  private
  public :: newton_solve

  !> Result of a solve.
  type, public :: newton_type
    logical :: converged = .false.
    logical :: stable = .true.          !! no tangent of an iterate was unstable
    real(wp) :: step(3) = 0.0_wp        !! first full Newton step, length
    real(wp) :: last(3, 3) = 0.0_wp     !! derivative of the residual at the end
  end type newton_type

contains

  !> Solve the equations at a fraction of the increment from the separations of `point` on.
  !>
  !> A step is halved until the largest residual decreases; if it never decreases, the method stops without a solution.
  !> The first step is made in full: its tangent may be that of the other side of a kink, for example where a plane is
  !> about to slide. A step of a motion has at least one iteration: what drives it from an equilibrium that is weakly
  !> unstable may be less than the tolerance.
  subroutine newton_solve(law, equations, fraction, reach, point, result)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates and iterations are counted
    real(wp), intent(in) :: fraction                       !! of the increment
    real(wp), intent(in) :: reach                       !! length from the guess beyond which no solution is wanted
    type(point_type), intent(inout) :: point            !! guess -> the point at the end
    type(newton_type), intent(out) :: result            !! result
    real(wp) :: error, length, next_error, r(3), step(3), trial(3), x(3), x_0(3)
    integer :: i
    logical :: draft, good

    ! without free separations the first point is the last one
    draft = any(equations%control%traction)
    x_0 = point%s
    x = x_0
    call evaluate(law, equations, x, fraction, point, r, error, draft)
    if (error >= huge(error)) return
    do i = 0, most_iterations
      result%last = free_matrix(law, equations, point)
      if (result%stable) result%stable = .not. unstable(result%last, law%stiffness)
      result%converged = error <= residual_tolerance .and. (i > 0 .or. .not. equations%damping > 0.0_wp)
      if (result%converged) call book(law, equations, fraction, point)
      if (result%converged .or. i == most_iterations) return
      call newton_step(equations, law%stiffness, result%last, r, step, good)
      if (.not. good) return
      if (i == 0) result%step = step
      if (0.25_wp*maxval(abs(x + step - x_0), mask=equations%control%traction) > reach) return
      equations%report%iterations = equations%report%iterations + 1
      length = 1.0_wp
      do
        trial = x + length*step
        ! a facet starts to curve at its foot, which separations of zero must meet exactly
        where (abs(trial(2:3)) <= residual_tolerance*abs(point%s(1))) trial(2:3) = 0.0_wp
        call evaluate(law, equations, trial, fraction, point, r, next_error, draft)
        if (next_error <= max(residual_tolerance, (1.0_wp - decrease*length)*error)) exit
        if (i == 0 .and. next_error < huge(next_error)) exit
        length = 0.5_wp*length
        if (length < shortest_step) return
      end do
      x = trial
      error = next_error
    end do
  end subroutine newton_solve

  !> Newton step, or a small step if the derivative is singular, for example along a single frictionless plane.
  pure subroutine newton_step(equations, stiffness, a, r, step, good)
    type(equations_type), intent(in) :: equations   !! the equations
    real(wp), intent(in) :: stiffness               !! elastic stiffness, stress/length
    real(wp), intent(in) :: a(3, 3)                 !! derivative of the residual, stress/length
    real(wp), intent(in) :: r(3)                    !! residual, stress
    real(wp), intent(out) :: step(3)                !! length
    logical, intent(out) :: good                    !! false: there is no step
    real(wp) :: b(3, 3), longest
    integer :: attempt, i
    longest = worst_condition*(maxval(abs(r))/stiffness)
    b = a
    do attempt = 1, 2
      step = -r
      call eliminate(3, b, step, good)
      if (good) good = maxval(abs(step)) <= longest .or. (attempt == 1 .and. equations%damping > 0.0_wp)
      if (good) return
      b = a
      do i = 1, 3
        b(i, i) = b(i, i) + stiffness/worst_condition
      end do
    end do
  end subroutine newton_step

end module asperity_newton
