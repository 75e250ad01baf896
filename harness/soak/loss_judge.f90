!> Judge of a loss: a wide scan of the free separations for an equilibrium where the solver found none, and a test
!> whether the law is discontinuous where the motion under the prescribed tractions ends.
!>
!> One free separation: its traction is computed at many values, and the extreme is refined. Several free separations:
!> the residual is computed on two grids, near the point and over a wide range, and Newton's method starts from the best
!> places of both. Every trial is one increment from the state of the point, without time and wear.
module loss_judge
  use asperity_equations, only: control_type, equations_type, evaluate, farthest_equilibrium, new_equations, &
    point_type, unstable
  use asperity_kinds, only: wp
  use asperity_newton, only: newton_solve, newton_type
  use asperity_point_law, only: point_law
  use asperity_increment, only: snap
  implicit none
  private
  public :: examine_loss

  !> No equilibrium was found; there is one that the motion does not reach; the motion stops where the law is
  !> discontinuous.
  integer, parameter, public :: loss_none_found = 1, loss_elsewhere = 2, loss_discontinuous = 3

contains

  !> Examine the loss of a point under prescribed values: kind of the loss, and the place of an equilibrium, whatever
  !> the kind.
  subroutine examine_loss(law, control, given, point, kind, place, nearby, wide)
    class(point_law), intent(in) :: law             !! the law
    type(control_type), intent(in) :: control       !! what is prescribed, at least one traction
    real(wp), intent(in) :: given(3)                !! its values
    type(point_type), intent(in) :: point           !! the last point found
    integer, intent(out) :: kind                    !! of the loss
    real(wp), intent(out) :: place(3)               !! separation of the equilibrium, if there is one, length
    logical, intent(out) :: nearby                  !! whether it is stable and within s_f of the point
    logical, intent(in) :: wide                     !! false: several free separations are scanned near the point alone
    !> Range to each side, as multiples of s_f, of the largest separation so far, and of the closing under the
    !> prescribed tractions; largest range, as a fraction of the separation beyond which the solver stops a motion.
    real(wp), parameter :: around = 5.0_wp, of_farthest = 0.5_wp
    !> Grid points for each of two and of three separations.
    integer, parameter :: near_points(3) = [1, 81, 21], wide_points(3) = [1, 201, 41]
    type(control_type) :: at_once
    type(equations_type) :: equations
    real(wp) :: reach
    logical :: has_equilibrium
    at_once = control
    at_once%dt = 0.0_wp
    call new_equations(at_once, given, given, point, equations)
    equations%moved = 0.0_wp
    reach = around*(law%s_f + law%magnitude(point%s, point%state)/law%stiffness + &
      maxval(merge(abs(given)/law%least_stiffness, abs(given), control%traction)))
    reach = min(reach, farthest_equilibrium(law, equations, of_farthest))
    if (count(control%traction) == 1) then
      nearby = .false.
      call scan_line(law, equations, point, reach, has_equilibrium, place)
    else
      ! with viscous damage or a dashpot there are equilibria at every separation, as no time passes
      nearby = .not. law%rate_dependent
      place = point%s
      if (nearby) call scan_grid(law, equations, point, near_points, point%s, law%s_f, nearby, place)
      has_equilibrium = nearby
      if (wide .and. .not. nearby) call scan_grid(law, equations, point, wide_points, 0.0_wp*point%s, reach, &
        has_equilibrium, place)
    end if
    kind = merge(loss_elsewhere, loss_none_found, has_equilibrium)
    if (.not. law%discontinuous) return
    call new_equations(at_once, given, given, point, equations)
    equations%moved = 0.0_wp
    call snap(law, equations, has_equilibrium)
    if (has_equilibrium) return
    if (discontinuity(law, at_once, given, equations%old) > 0.0_wp) kind = loss_discontinuous
  end subroutine examine_loss

  !> One free separation.
  subroutine scan_line(law, equations, point, reach, has_equilibrium, place)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(inout) :: equations   !! the equation
    type(point_type), intent(in) :: point           !! where the search ended
    real(wp), intent(in) :: reach                   !! range of the separation to both sides, length
    logical, intent(out) :: has_equilibrium         !! whether there is an equilibrium
    real(wp), intent(out) :: place(3)               !! separation of the equilibrium or of the extreme, length
    !> Values in a scan of the range, then of that around the best value.
    integer, parameter :: steps(5) = [20000, 100, 100, 100, 100]
    type(point_type) :: at
    real(wp) :: best, ends(2), middle, sense, surplus, width, x
    integer :: free, i, k

    free = findloc(equations%control%traction, .true., 1)
    ! the sense of the missing traction at the point, or at the end of the range if the point is beyond it
    sense = 1.0_wp
    middle = min(max(point%s(free), -reach), reach)
    call look(middle, at, best)
    sense = merge(1.0_wp, -1.0_wp, best < 0.0_wp)
    best = sense*best
    ends = [-reach, reach]
    do k = 1, size(steps)
      width = (ends(2) - ends(1))/real(steps(k), wp)
      do i = 0, steps(k)
        x = ends(1) + width*real(i, wp)
        call look(x, at, surplus)
        if (surplus <= best) cycle
        best = surplus
        middle = x
      end do
      ends = [max(middle - width, -reach), min(middle + width, reach)]
    end do
    place = point%s
    place(free) = middle
    has_equilibrium = best >= 0.0_wp

  contains

    !> Excess of the traction over the given one, in the sense of the missing traction; a large negative number if the
    !> separation is out of range.
    subroutine look(s, at, surplus)
      real(wp), intent(in) :: s               !! free separation, length
      type(point_type), intent(inout) :: at   !! -> the point there
      real(wp), intent(out) :: surplus        !! stress
      real(wp) :: error, r(3)
      call evaluate(law, equations, [s, s, s], 0.0_wp, at, r, error)
      surplus = -huge(surplus)
      if (error < huge(error)) surplus = sense*r(free)
    end subroutine look

  end subroutine scan_line

  !> Several free separations.
  subroutine scan_grid(law, equations, point, points, middle, reach, has_equilibrium, place)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(inout) :: equations   !! the equations
    type(point_type), intent(in) :: point           !! where the search ended
    integer, intent(in) :: points(3)                !! of the grid for each of one, two and three separations
    real(wp), intent(in) :: middle(3)               !! of the grid, length
    real(wp), intent(in) :: reach                   !! range of the separations to both sides of it, length
    logical, intent(out) :: has_equilibrium         !! whether there is an equilibrium
    real(wp), intent(out) :: place(3)               !! separation of the equilibrium or of the best grid point, length
    !> Number of best places from which Newton's method starts.
    integer, parameter :: starts = 40
    !> A candidate counts only if its residual is below this fraction of the residual at the last point.
    real(wp), parameter :: closer = 0.1_wp
    type(point_type) :: at
    type(newton_type) :: result
    real(wp), allocatable :: sizes(:)
    logical, allocatable :: lowest(:)
    real(wp) :: error, here, r(3), x(3)
    integer :: all_points, i, j, n, stride

    n = count(equations%control%traction)
    all_points = points(n)**n
    allocate (sizes(0:all_points - 1), source=huge(1.0_wp))
    call evaluate(law, equations, point%s, 0.0_wp, at, r, error)
    here = maxval(abs(r))
    do i = 0, all_points - 1
      call evaluate(law, equations, grid_place(i), 0.0_wp, at, r, error)
      if (error < huge(error)) sizes(i) = maxval(abs(r))
    end do
    place = merge(grid_place(minloc(sizes, 1) - 1), equations%target, equations%control%traction)
    ! places that are better than those beside them
    allocate (lowest(0:all_points - 1))
    lowest = sizes < huge(1.0_wp)
    do j = 0, n - 1
      stride = points(n)**j
      lowest(stride:) = lowest(stride:) .and. sizes(stride:) <= sizes(:all_points - 1 - stride)
      lowest(:all_points - 1 - stride) = lowest(:all_points - 1 - stride) .and. &
        sizes(:all_points - 1 - stride) <= sizes(stride:)
    end do
    has_equilibrium = .false.
    do i = 1, starts
      if (.not. any(lowest)) exit
      j = minloc(sizes, 1, mask=lowest) - 1
      lowest(j) = .false.
      at%s = grid_place(j)
      call newton_solve(law, equations, 0.0_wp, huge(1.0_wp), at, result)
      x = at%s
      if (.not. result%converged .or. maxval(abs(x - middle), mask=equations%control%traction) > reach) cycle
      if (unstable(result%last, law%stiffness)) cycle
      call evaluate(law, equations, x, 0.0_wp, at, r, error)
      if (maxval(abs(r)) > closer*here) cycle
      has_equilibrium = .true.
      place = at%s
      exit
    end do

  contains

    !> Separations of a grid point.
    pure function grid_place(number) result(s)
      integer, intent(in) :: number   !! of the point, from 0
      real(wp) :: s(3)
      integer :: component, rest
      s = point%s
      rest = number
      do component = 1, size(s)
        if (.not. equations%control%traction(component)) cycle
        s(component) = middle(component) + reach*(2.0_wp*real(modulo(rest, points(n)), wp)/real(points(n) - 1, wp) - &
          1.0_wp)
        rest = rest/points(n)
      end do
    end function grid_place

  end subroutine scan_grid

  !> Largest change of a free traction over a distance that is too short for any stiffness of the law, stress; 0 if it
  !> is continuous there. A closed facet of finite height is discontinuous at its foot, where its curvature sets in, and
  !> so is the guard where it admits damage that it had prevented, also at a constant separation.
  function discontinuity(law, control, given, point) result(leap)
    class(point_law), intent(in) :: law             !! the law
    type(control_type), intent(in) :: control       !! what is given, at least one traction
    real(wp), intent(in) :: given(3)                !! its values
    type(point_type), intent(in) :: point           !! the point
    real(wp) :: leap
    !> Distances, relative to s0, the motion stops about there before the discontinuity; stiffness of a continuous law,
    !> relative to that of the stiffest plane.
    real(wp), parameter :: distances(2) = [1.0e-9_wp, 1.0e-7_wp], steepest = 100.0_wp
    type(equations_type) :: equations
    type(point_type) :: at
    real(wp) :: ahead(3), back(3), errors(2), step(3)
    integer :: i, j
    leap = 0.0_wp
    call new_equations(control, given, given, point, equations)
    call evaluate(law, equations, point%s, 0.0_wp, at, ahead, errors(1))
    if (errors(1) < huge(errors)) leap = maxval(abs(at%traction - point%traction), mask=control%traction)
    if (leap <= least(distances(1))) leap = 0.0_wp
    do j = 1, size(distances)
      if (leap > 0.0_wp) exit
      do i = 1, size(step)
        if (.not. control%traction(i)) cycle
        step = 0.0_wp
        step(i) = distances(j)*law%s_0
        call evaluate(law, equations, point%s + step, 0.0_wp, at, ahead, errors(1))
        call evaluate(law, equations, point%s - step, 0.0_wp, at, back, errors(2))
        if (all(errors < huge(errors))) leap = max(leap, maxval(abs(ahead - back)))
      end do
      if (leap <= least(distances(j))) leap = 0.0_wp
    end do

  contains

    !> Smallest change over a distance that no stiffness explains.
    pure function least(distance) result(change)
      real(wp), intent(in) :: distance   !! relative to s0
      real(wp) :: change
      change = steepest*law%magnitude([distance*law%s_0, 0.0_wp, 0.0_wp], 0.0_wp*point%state)
    end function least

  end function discontinuity

end module loss_judge
