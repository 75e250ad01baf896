!> Semismooth Newton's method for the held tractions: consistent tangent of the side the iterate is on, LAPACK, line
!> search.
module newton
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use control_point, only: balance_type, evaluate, free_matrix, point_type, residual_tolerance, solve_linear, unstable
  implicit none
  private
  public :: newton_solve, stiffness_scale

  !> Newton iterations before an increment is cut: quadratic convergence needs fewer than 10, switches add a few.
  integer, parameter, public :: max_iterations = 25

  !> What came out.
  type, public :: newton_type
    logical :: converged = .false.
    integer :: iterations = 0                       !! tangent solves
    integer :: updates = 0                          !! of the law
    real(wp) :: history(max_iterations + 1) = -1.0_wp !! relative residuals from the guess on, -1: none was needed
    logical :: stable = .true.                      !! no tangent on the way was that of an unstable equilibrium
    real(wp) :: first(3, 3) = 0.0_wp                !! derivative of the residual at the guess
    real(wp) :: last(3, 3) = 0.0_wp                 !! and at the end
    real(wp) :: step(3) = 0.0_wp                    !! first step that Newton's method asked for, length
  end type newton_type

contains

  !> Elastic stiffness of a plane, stress/length.
  pure function stiffness_scale(joint) result(scale)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: scale
    scale = max(joint%material%k_n, joint%material%k_t)
  end function stiffness_scale

  !> Solve the equations from the separations of `point` on.
  !>
  !> With a line search a step is halved until the largest residual falls; the method gives up where it does not. The
  !> first step is free: its tangent may be that of the other side of a switch, as where a plane is about to slide.
  pure subroutine newton_solve(joint, balance, searches, point, result, damping)
    type(interface_type), intent(in) :: joint            !! the interface
    type(balance_type), intent(in) :: balance            !! the equations
    logical, intent(in) :: searches                      !! false: plain Newton, full steps
    type(point_type), intent(inout) :: point             !! guess -> the point at the end
    type(newton_type), intent(out) :: result             !! what came out
    real(wp), intent(in), optional :: damping            !! kappa: solve residual + kappa (s - s at the start) = 0,
                                                         !! stress/length
    !> Armijo's constant; shortest step tried.
    real(wp), parameter :: decrease = 1.0e-4_wp, shortest = 2.0_wp**(-8)
    !> Condition of the derivative beyond which it counts as singular.
    real(wp), parameter :: worst = 1.0e9_wp
    real(wp) :: a(3, 3), error, kappa, length, next_error, r(3), start(3), step(3), trial(3), x(3)
    integer :: i, n
    logical :: good

    n = balance%n
    kappa = 0.0_wp
    if (present(damping)) kappa = damping
    start = 0.0_wp
    x = 0.0_wp
    start(:n) = balance%old%s(balance%free(:n))
    x(:n) = point%s(balance%free(:n))
    call damped(joint, balance, kappa, start, x, point, r, error, good)
    result%updates = 1
    if (.not. good) return
    do
      result%history(result%iterations + 1) = error
      a = free_matrix(balance, point)
      do i = 1, n
        a(i, i) = a(i, i) + kappa
      end do
      if (result%iterations == 0) result%first = a
      result%last = a
      if (unstable(n, a, stiffness_scale(joint))) result%stable = .false.
      result%converged = error <= residual_tolerance
      if (result%converged .or. result%iterations == max_iterations) return
      call solve_linear(n, a, -r(:n), step, good)
      if (good .and. .not. kappa > 0.0_wp) then
        good = maxval(abs(step(:n)))*stiffness_scale(joint) <= worst*maxval(abs(r(:n)))
      end if
      if (.not. good) then
        ! no stiffness in a direction, as along a single frictionless plane: no step in it
        do i = 1, n
          a(i, i) = a(i, i) + stiffness_scale(joint)/worst
        end do
        call solve_linear(n, a, -r(:n), step, good)
        if (good) good = maxval(abs(step(:n)))*stiffness_scale(joint) <= sqrt(worst)*maxval(abs(r(:n)))
      end if
      if (.not. good) return
      if (result%iterations == 0) result%step(:n) = step(:n)
      result%iterations = result%iterations + 1
      length = 1.0_wp
      do
        trial(:n) = x(:n) + length*step(:n)
        call damped(joint, balance, kappa, start, trial, point, r, next_error, good)
        result%updates = result%updates + 1
        if (.not. searches .or. (good .and. result%iterations == 1)) exit
        if (good .and. (next_error <= residual_tolerance .or. next_error <= (1.0_wp - decrease*length)*error)) exit
        length = 0.5_wp*length
        if (length < shortest) return
      end do
      if (.not. good) return
      x(:n) = trial(:n)
      error = next_error
    end do
  end subroutine newton_solve

  !> The point at free separations x, and the residual with the damping.
  pure subroutine damped(joint, balance, kappa, start, x, point, r, error, good)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! the equations
    real(wp), intent(in) :: kappa                   !! damping, stress/length
    real(wp), intent(in) :: start(3), x(3)          !! free separations at the start and now, length
    type(point_type), intent(inout) :: point        !! the point with the separations x
    real(wp), intent(out) :: r(3)                   !! residual
    real(wp), intent(out) :: error                  !! its largest component, relative
    logical, intent(out) :: good                    !! false: the law does not take the separations
    !> Smallest scale, of the strength: what is a rest at no load stays one, whatever rounding has left of its traction.
    real(wp), parameter :: finest = 1.0e-6_wp
    real(wp) :: scale
    associate (n => balance%n)
      call evaluate(joint, balance, x(:n), point, r(:n), scale, good)
      scale = max(scale, finest*joint%material%k_n*joint%material%s0)
      r(:n) = r(:n) + kappa*(x(:n) - start(:n))
      r(n + 1:) = 0.0_wp
      error = maxval(abs(r))/scale
    end associate
  end subroutine damped

end module newton
