!> Equations of a step of given length along a branch of equilibria.
!>
!> The prescribed values are start + lambda*change with the load factor lambda. The unknowns are the free separations x
!> and m = lambda*D with a length D; the equations are the residual of the prescribed tractions and the length of the
!> step. The length is that of the path of the separation: |ds| over its three components.
module asperity_arc_equations
  use asperity_control_point, only: balance_type, elastic_stiffness, evaluate, free_matrix, free_part, point_type, &
    set_balance
  use asperity_elimination, only: eliminate
  use asperity_increment, only: path_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_tolerances, only: most_iterations, residual_tolerance, rounding, worst_condition
  implicit none
  private
  public :: branch_tangent, correct, load_length, length_product, set_factor

contains

  !> Length D of a unit of the load factor: of the change of the prescribed separations, or of an elastic plane under
  !> the change of the prescribed tractions if no separation changes.
  pure function load_length(joint, path) result(length)
    type(interface_type), intent(in) :: joint   !! the interface
    type(path_type), intent(in) :: path         !! the prescribed values
    real(wp) :: length
    length = sqrt(sum(prescribed_change(path)**2))
    if (.not. length > 0.0_wp) length = sqrt(sum(path%change**2))/elastic_stiffness(joint)
  end function load_length

  !> Change of the prescribed separations, zero in the other components.
  pure function prescribed_change(path) result(change)
    type(path_type), intent(in) :: path   !! the prescribed values
    real(wp) :: change(3)
    change = merge(0.0_wp, path%change, path%control%traction)
  end function prescribed_change

  !> Scalar product of two steps (x, m), of which the length of a step is the root: m counts where it is a separation.
  pure function length_product(path, a, b) result(product)
    type(path_type), intent(in) :: path     !! the prescribed values
    real(wp), intent(in) :: a(4), b(4)      !! free separations, then m, then zeros
    real(wp) :: product
    integer :: n
    n = count(path%control%traction)
    product = sum(a(:n)*b(:n)) + weight(path)*a(n + 1)*b(n + 1)
  end function length_product

  !> Weight of m in the length of a step: 1 if a prescribed separation changes, else 0.
  pure function weight(path) result(w)
    type(path_type), intent(in) :: path     !! the prescribed values
    real(wp) :: w
    w = merge(1.0_wp, 0.0_wp, any(abs(prescribed_change(path)) > 0.0_wp))
  end function weight

  !> Set the equations at a load factor; the point at their start does not change.
  pure subroutine set_factor(joint, path, factor, balance)
    type(interface_type), intent(in) :: joint        !! the interface
    type(path_type), intent(in) :: path              !! the prescribed values
    real(wp), intent(in) :: factor                   !! load factor
    type(balance_type), intent(inout) :: balance     !! the equations
    call set_balance(joint, path%control, path%start + factor*path%change, balance)
  end subroutine set_factor

  !> Derivative of the residual over the elastic stiffness with respect to (x, m), n rows.
  pure function derivative(joint, path, balance, point) result(a)
    type(interface_type), intent(in) :: joint      !! the interface
    type(path_type), intent(in) :: path            !! the prescribed values
    type(balance_type), intent(in) :: balance      !! the equations
    type(point_type), intent(in) :: point          !! the point, its tangent
    real(wp) :: a(4, 4)
    a = 0.0_wp
    a(:3, :3) = free_matrix(balance, point)
    a(:3, balance%n + 1) = free_part(balance, matmul(point%tangent, prescribed_change(path)) - path%change)/ &
      load_length(joint, path)
    a = a/elastic_stiffness(joint)
  end function derivative

  !> Direction (x, m) of the branch at a point, of unit length; zero if it has none.
  !>
  !> It is the vector of cofactors of the row that completes the derivative of the residual to a square matrix. Of the
  !> two senses it has the one in which the load factor grows where the determinant of the free stiffness is positive.
  !> A path from an elastic state keeps this sense through folds and kinks as long as no other branch crosses it: among
  !> the equilibria at a small distance from a point, those that lie in this sense and those that lie against it are
  !> equal in number.
  pure function branch_tangent(joint, path, balance, point) result(t)
    type(interface_type), intent(in) :: joint      !! the interface
    type(path_type), intent(in) :: path            !! the prescribed values
    type(balance_type), intent(in) :: balance      !! the equations
    type(point_type), intent(in) :: point          !! the point, its tangent
    real(wp) :: t(4)
    real(wp) :: a(4, 4), length, minor(3, 3)
    integer :: j, k, n
    n = balance%n
    a = derivative(joint, path, balance, point)
    t = 0.0_wp
    do j = 1, n + 1
      do k = 1, n
        minor(:, k) = a(:3, merge(k, k + 1, k < j))
      end do
      t(j) = determinant(n, minor)
      if (modulo(n + 1 + j, 2) == 1) t(j) = -t(j)
    end do
    length = sqrt(length_product(path, t, t))
    if (length > 0.0_wp) t = t/length
  end function branch_tangent

  !> Determinant of the upper left n x n of a matrix, 1 for n = 0.
  pure function determinant(n, a) result(d)
    integer, intent(in) :: n           !! 0 to 3
    real(wp), intent(in) :: a(3, 3)    !! matrix
    real(wp) :: d
    select case (n)
    case (0)
      d = 1.0_wp
    case (1)
      d = a(1, 1)
    case (2)
      d = a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)
    case default
      d = a(1, 1)*(a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) - a(1, 2)*(a(2, 1)*a(3, 3) - a(2, 3)*a(3, 1)) + &
        a(1, 3)*(a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1))
    end select
  end function determinant

  !> Find an equilibrium at a given distance from the point at the start of the equations, by Newton's method.
  pure subroutine correct(joint, path, length, origin, balance, u, point, iterations, good)
    type(interface_type), intent(in) :: joint       !! the interface
    type(path_type), intent(in) :: path             !! the prescribed values
    real(wp), intent(in) :: length                  !! of the step, > 0
    real(wp), intent(in) :: origin(4)               !! (x, m) at the start
    type(balance_type), intent(inout) :: balance    !! the equations -> at the load factor of the result
    real(wp), intent(inout) :: u(4)                 !! (x, m), guess -> result
    type(point_type), intent(inout) :: point        !! -> the point there
    integer, intent(inout) :: iterations            !! tangent solves, increased; each needs an update of the law
    logical, intent(out) :: good                    !! whether there is a result
    !> Accuracy of the length of a step. It does not affect the equilibrium.
    real(wp), parameter :: length_tolerance = 1.0e-6_wp
    !> Largest correction, relative to the length of the step: the result is near the start.
    real(wp), parameter :: longest = 2.0_wp
    real(wp) :: a(4, 4), b(4), c(4, 4), change(4), d(4), excess, least, move, r(3), scale
    integer :: i, j, n
    n = count(path%control%traction)
    ! near zero a prescribed traction has the rounding errors of the load factor
    least = rounding*maxval(abs(path%start) + abs(path%change), mask=path%control%traction)
    do i = 0, most_iterations
      call set_factor(joint, path, u(n + 1)/load_length(joint, path), balance)
      call evaluate(joint, balance, u(:3), point, r, scale, good)
      if (.not. good) return
      change = u - origin
      excess = 0.5_wp*(length_product(path, change, change)/length - length)
      good = maxval(abs(r)) <= max(residual_tolerance*scale, least) .and. abs(excess) <= length_tolerance*length
      if (good .or. i == most_iterations) return
      a = derivative(joint, path, balance, point)
      b = 0.0_wp
      b(:n) = -r(:n)/elastic_stiffness(joint)
      a(n + 1, :n) = change(:n)/length
      a(n + 1, n + 1) = weight(path)*change(n + 1)/length
      b(n + 1) = -excess
      c = a
      d = b
      call eliminate(n + 1, c, d, good)
      if (.not. good) then
        ! open planes that are fully damaged have no stiffness
        do j = 1, n
          a(j, j) = a(j, j) + 1.0_wp/worst_condition
        end do
        d = b
        call eliminate(n + 1, a, d, good)
        if (.not. good) return
      end if
      iterations = iterations + 1
      move = sqrt(length_product(path, d, d))
      if (move > longest*length) d = d*(longest*length/move)
      u(:n + 1) = u(:n + 1) + d(:n + 1)
    end do
  end subroutine correct

end module asperity_arc_equations
