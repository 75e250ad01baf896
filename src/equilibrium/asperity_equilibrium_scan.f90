!> Search for an equilibrium in a wide range of the free separations around a point where the solver found none.
!>
!> One free separation: its traction is computed at many values, and the extreme is refined. Several free separations:
!> the residual is computed on a grid, and Newton's method starts from the best grid points. Every trial is one
!> increment from the state of the point.
module asperity_equilibrium_scan
  use asperity_control_point, only: balance_type, control_type, evaluate, free_part, point_type, set_balance, &
    whole_separation
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_newton, only: newton_solve, newton_type
  use asperity_snap_motion, only: farthest_rest
  implicit none
  private
  public :: scan_equilibria

  !> Result of a scan.
  type, public :: scan_type
    integer :: n = 0                       !! free separations
    integer :: free = 0                    !! component of the first of them, 1 to 3
    integer :: samples = 0                 !! updates of the law
    logical :: found = .false.             !! whether there is an equilibrium
    real(wp) :: place(3) = 0.0_wp          !! separation of the equilibrium or of the extreme, length
    real(wp) :: lower = 0.0_wp, upper = 0.0_wp   !! range of every free separation, length
    logical :: short = .true.              !! one free: the traction is too small everywhere (false: too large)
    real(wp) :: extreme = 0.0_wp           !! one free: largest (smallest) traction + spring*separation; several:
                                           !! smallest residual; stress
  end type scan_type

contains

  !> Search for equilibria under given values around a point.
  pure subroutine scan_equilibria(joint, control, given, point, scan)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given, at least one traction
    real(wp), intent(in) :: given(3)                !! its values
    type(point_type), intent(in) :: point           !! the last point found
    type(scan_type), intent(out) :: scan            !! result
    !> Range to each side, as multiples of s_f, of the largest separation and slip so far, and of the closure under the
    !> given tractions.
    real(wp), parameter :: around = 5.0_wp
    !> Largest range, as a fraction of the separation beyond which the solver stops a motion as endless.
    real(wp), parameter :: share = 0.5_wp
    type(balance_type) :: balance
    real(wp) :: reach
    call set_balance(joint, control, given, balance)
    balance%old = point
    scan%n = balance%n
    scan%free = balance%free(1)
    if (scan%n == 0) return
    associate (material => joint%material)
      reach = around*(material%s0/(1.0_wp - material%eta) + maxval(abs(whole_separation(point%s, point%state))) + &
        maxval(merge(abs(given)/min(material%k_n, material%k_t), abs(given), control%traction)))
    end associate
    reach = min(reach, share*farthest_rest(joint, balance))
    scan%upper = reach
    scan%lower = -reach
    if (scan%n == 1) then
      call scan_line(joint, balance, point, scan)
    else
      call scan_grid(joint, balance, point, scan)
    end if
  end subroutine scan_equilibria

  !> One free separation.
  pure subroutine scan_line(joint, balance, point, scan)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! the equation
    type(point_type), intent(in) :: point           !! where the search ended
    type(scan_type), intent(inout) :: scan          !! range -> findings
    integer, parameter :: steps = 20000, refinements = 60
    real(wp), parameter :: golden = 0.5_wp*(sqrt(5.0_wp) - 1.0_wp)
    type(point_type) :: at
    real(wp) :: a, b, best, f(2), here, sense, width, x(2)
    integer :: i

    sense = 1.0_wp
    ! at the point, or at the end of the range if the point is beyond it
    x(2) = min(max(point%s(scan%free), scan%lower), scan%upper)
    call look(x(2), at, here)
    scan%short = here < 0.0_wp
    sense = merge(1.0_wp, -1.0_wp, scan%short)
    best = sense*here
    a = x(2)
    width = (scan%upper - scan%lower)/real(steps, wp)
    do i = 0, steps
      x(1) = scan%lower + width*real(i, wp)
      call look(x(1), at, f(1))
      if (f(1) > best) then
        best = f(1)
        a = x(1)
      end if
    end do
    scan%samples = steps + 2 + 2*refinements
    b = min(a + width, scan%upper)
    a = max(a - width, scan%lower)
    ! refine the extreme between the neighbours of the best sample
    do i = 1, refinements
      x = [b - golden*(b - a), a + golden*(b - a)]
      call look(x(1), at, f(1))
      call look(x(2), at, f(2))
      if (f(1) > f(2)) then
        b = x(2)
      else
        a = x(1)
      end if
    end do
    best = max(best, maxval(f))
    scan%place = point%s
    scan%place(scan%free) = 0.5_wp*(a + b)
    scan%extreme = balance%given(scan%free) + sense*best
    scan%found = best >= 0.0_wp

  contains

    !> Excess of the traction over the given one, in the sense of the missing traction; a large negative number if the
    !> separation is out of range.
    pure subroutine look(s, at, surplus)
      real(wp), intent(in) :: s               !! free separation, length
      type(point_type), intent(inout) :: at   !! -> the point there
      real(wp), intent(out) :: surplus        !! stress
      real(wp) :: r(3), scale
      logical :: good
      call evaluate(joint, balance, [s, 0.0_wp, 0.0_wp], at, r, scale, good)
      surplus = -huge(surplus)
      if (good) surplus = sense*r(1)
    end subroutine look

  end subroutine scan_line

  !> Several free separations.
  pure subroutine scan_grid(joint, balance, point, scan)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! the equations
    type(point_type), intent(in) :: point           !! where the search ended
    type(scan_type), intent(inout) :: scan          !! range -> findings
    !> Grid points for each of two and of three separations; number of best points from which Newton's method starts.
    integer, parameter :: points(3) = [1, 201, 41], starts = 20
    type(point_type) :: at
    type(newton_type) :: result
    !> A candidate counts only if its residual is below this fraction of the residual at the last point.
    real(wp), parameter :: closer = 0.1_wp
    real(wp) :: best(starts), here, r(3), scale, seeds(3, starts), size_of, x(3)
    integer :: i, j, k, n
    logical :: good

    n = balance%n
    best = huge(best)
    seeds = 0.0_wp
    x = free_part(balance, point%s)
    call evaluate(joint, balance, x, at, r, scale, good)
    here = maxval(abs(r))
    do i = 0, points(n)**n - 1
      k = i
      do j = 1, n
        x(j) = scan%lower + (scan%upper - scan%lower)*real(modulo(k, points(n)), wp)/real(points(n) - 1, wp)
        k = k/points(n)
      end do
      call evaluate(joint, balance, x, at, r, scale, good)
      if (.not. good) cycle
      size_of = maxval(abs(r))
      k = maxloc(best, 1)
      if (size_of < best(k)) then
        best(k) = size_of
        seeds(:, k) = x
      end if
    end do
    scan%samples = points(n)**n
    scan%extreme = minval(best)
    scan%place = balance%given
    scan%place(balance%free(:n)) = seeds(:n, minloc(best, 1))
    do i = 1, starts
      if (.not. best(i) < huge(best)) cycle
      at%s = balance%given
      at%s(balance%free(:n)) = seeds(:n, i)
      call newton_solve(joint, balance, .true., at, result)
      scan%samples = scan%samples + result%updates
      x = free_part(balance, at%s)
      if (.not. result%converged .or. maxval(abs(x)) > scan%upper) cycle
      call evaluate(joint, balance, x, at, r, scale, good)
      if (maxval(abs(r)) > closer*here) cycle
      scan%found = .true.
      scan%place = at%s
      exit
    end do
  end subroutine scan_grid

end module asperity_equilibrium_scan
