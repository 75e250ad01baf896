!> Semismooth Newton method for the prescribed tractions. At a kink of the law the consistent tangent is the derivative
!> of the side on which the iterate lies. A line search is optional.
module asperity_newton
  use asperity_control_point, only: balance_type, elastic_stiffness, evaluate, free_matrix, free_part, &
    point_type, unstable
  use asperity_elimination, only: eliminate
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_tolerances, only: most_iterations, residual_tolerance, worst_condition
  implicit none
  private
  public :: newton_solve

  !> Result of a solve.
  type, public :: newton_type
    logical :: converged = .false.
    integer :: iterations = 0                       !! tangent solves
    integer :: updates = 0                          !! of the law
    real(wp) :: history(most_iterations + 1) = -1.0_wp !! relative residuals from the guess on, -1: not computed
    logical :: stable = .true.                      !! no tangent of an iterate was unstable; not tested
                                                    !! without a line search
    real(wp) :: first(3, 3) = 0.0_wp                !! derivative of the residual at the guess
    real(wp) :: last(3, 3) = 0.0_wp                 !! the same at the end
    real(wp) :: step(3) = 0.0_wp                    !! first full Newton step, length
  end type newton_type

contains

  !> Solve the equations from the separations of `point` on.
  !>
  !> With a line search a step is halved until the largest residual decreases; if it never decreases, the method stops
  !> without a solution. The first step is taken in full: its tangent may be that of the other side of a kink, for
  !> example where a plane is about to slide.
  pure subroutine newton_solve(joint, balance, searches, point, result, fine)
    type(interface_type), intent(in) :: joint            !! the interface
    type(balance_type), intent(in) :: balance            !! the equations
    logical, intent(in) :: searches                      !! false: full steps
    type(point_type), intent(inout) :: point             !! guess -> the point at the end
    type(newton_type), intent(out) :: result             !! result
    real(wp), intent(in), optional :: fine               !! residual, stress, above which a solution is improved by
                                                         !! a further step; absent: it is not improved
    !> Armijo's constant; shortest step tried.
    real(wp), parameter :: decrease = 1.0e-4_wp, shortest = 2.0_wp**(-8)
    real(wp) :: error, length, next_error, r(3), scale, step(3), stiffness, trial(3), x(3)
    integer :: n
    logical :: enough, good

    n = balance%n
    stiffness = elastic_stiffness(joint)
    x = free_part(balance, point%s)
    call evaluate(joint, balance, x, point, r, scale, good)
    error = maxval(abs(r))/scale
    result%updates = 1
    if (.not. good) return
    do
      result%history(result%iterations + 1) = error
      result%last = free_matrix(balance, point)
      if (result%iterations == 0) result%first = result%last
      if (searches .and. result%stable) result%stable = .not. unstable(n, result%last, stiffness)
      enough = result%converged
      if (present(fine)) enough = enough .or. (result%iterations > 0 .and. maxval(abs(r)) <= fine)
      result%converged = error <= residual_tolerance
      if (result%converged .and. (enough .or. .not. present(fine))) return
      if (result%iterations == most_iterations) return
      call newton_step(balance, stiffness, result%last, r, step, good)
      if (.not. good) return
      if (result%iterations == 0) result%step = step
      result%iterations = result%iterations + 1
      length = 1.0_wp
      do
        trial = x + length*step
        ! a facet starts to curve at its foot, which separations of zero must meet exactly
        if (joint%material%curved) where (abs(trial) <= epsilon(1.0_wp)*maxval(abs(point%s))) trial = 0.0_wp
        call evaluate(joint, balance, trial, point, r, scale, good)
        next_error = maxval(abs(r))/scale
        result%updates = result%updates + 1
        if (.not. searches .or. (good .and. result%iterations == 1)) exit
        if (good .and. (next_error <= residual_tolerance .or. next_error <= (1.0_wp - decrease*length)*error)) exit
        length = 0.5_wp*length
        if (length < shortest) return
      end do
      if (.not. good) result%converged = .false.
      if (.not. good) return
      x = trial
      error = next_error
    end do
  end subroutine newton_solve

  !> Newton step, or a small step if the derivative is singular, for example along a single frictionless plane.
  pure subroutine newton_step(balance, stiffness, a, r, step, good)
    type(balance_type), intent(in) :: balance   !! the equations
    real(wp), intent(in) :: stiffness           !! elastic stiffness, stress/length
    real(wp), intent(in) :: a(3, 3)             !! derivative of the residual, stress/length
    real(wp), intent(in) :: r(3)                !! residual, zero beyond the unknowns, stress
    real(wp), intent(out) :: step(3)            !! length
    logical, intent(out) :: good                !! false: there is no step
    real(wp) :: b(3, 3), elastic
    integer :: i
    elastic = maxval(abs(r))/stiffness
    b = a
    step = -r
    call eliminate(balance%n, b, step, good)
    if (good .and. .not. balance%damping > 0.0_wp) good = maxval(abs(step)) <= worst_condition*elastic
    if (good) return
    b = a
    do i = 1, balance%n
      b(i, i) = b(i, i) + stiffness/worst_condition
    end do
    step = -r
    call eliminate(balance%n, b, step, good)
    if (good) good = maxval(abs(step)) <= balance%longest*elastic
  end subroutine newton_step

end module asperity_newton
