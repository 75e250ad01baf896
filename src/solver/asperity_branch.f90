!> A branch of equilibria, followed through its unstable part by local parametrisation: of the free separations and the
!> load factor, the one that changes most is prescribed in a step.
!>
!> Every step is an update of the law from the last equilibrium. The prescribed values depend on a load factor, which
!> may decrease: at a fold they turn back, where the stable path would snap.
module asperity_branch
  use asperity_control_point, only: control_type, equations_type, evaluate, farthest_equilibrium, free_matrix, &
    free_part, move_point, new_equations, point_type, predict, values_at
  use asperity_elimination, only: eliminate
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, ended_complete, ended_endless, ended_lost, ended_rejected, report_type
  use asperity_point_law, only: point_law
  use asperity_text, only: append, to_text
  use asperity_tolerances, only: backwards, endless, largest_turn, most_branch_steps, most_iterations, &
    residual_tolerance, search_steps, shortest_branch_step, straight_step
  implicit none
  private
  public :: new_branch, branch_step, explain_end

  !> Longest step of a branch, relative to s0: default, smallest and largest admissible value.
  real(wp), parameter, public :: default_arc = 0.05_wp, least_arc = 1.0e-5_wp, largest_arc = 1.0_wp

  !> Progress along the branch of one change of the prescribed values.
  type, public :: branch_type
    real(wp) :: longest = 0.0_wp        !! longest step, length
    real(wp) :: length = 0.0_wp         !! of the next step, length
    real(wp) :: travelled = 0.0_wp      !! length of all steps
    real(wp) :: factor = 0.0_wp         !! load factor, 1: the prescribed values are reached
    real(wp) :: last(4) = 0.0_wp        !! direction of the last step; zero: there was none
    logical :: back = .false.           !! whether the prescribed values go back
    logical :: turned = .false.         !! whether their sense changed in the last step
  end type branch_type

contains

  !> Append why a branch ended before the values that it was to reach.
  pure subroutine explain_end(ended, message)
    integer, intent(in) :: ended                              !! end of the last step, of report_type
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended
    select case (ended)
    case (ended_endless)
      call append(message, "the branch does not reach the prescribed values within a length of " // &
        to_text(endless) // " s_f: the separation grows without end, or farther than that")
    case (ended_rejected)
      call append(message, "the prescribed values are more than " // to_text(most_branch_steps) // &
        " steps of this length away: expected a larger arc, up to " // to_text(largest_arc) // &
        ", or increments (follow = 'stable')")
    case default
      call append(message, "the branch ends: no equilibrium continues it near its last point")
    end select
  end subroutine explain_end

  !> A branch before its first step; its steps are at most `longest` s0.
  pure function new_branch(law, longest) result(branch)
    class(point_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: longest       !! relative to s0
    type(branch_type) :: branch
    branch%longest = longest*law%length
    branch%length = branch%longest
  end function new_branch

  !> Length of a unit of the load factor: of the change of the prescribed separations, or of an elastic plane under the
  !> change of the prescribed tractions if no separation changes.
  pure function load_length(law, equations) result(length)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the prescribed values
    real(wp) :: length
    associate (change => equations%target - equations%start, traction => equations%control%traction)
      length = norm2(merge(0.0_wp, change, traction))
      if (.not. length > 0.0_wp) length = norm2(merge(change, 0.0_wp, traction))/law%stiffness
    end associate
  end function load_length

  !> Take a step along the branch. The last step ends at the prescribed values, where the load factor is 1.
  !>
  !> A step ends at the first fold in it, so that the rows have the extreme values of the load factor. If the branch
  !> does not continue, the point stays, and the report says why: `ended_endless` if the separation grows without end,
  !> `ended_rejected` if the prescribed values are too far for the length of the steps, else `ended_lost`.
  pure subroutine branch_step(law, control, from, to, branch, point, report)
    class(point_law), intent(in) :: law               !! the law
    type(control_type), intent(in) :: control         !! what is prescribed
    real(wp), intent(in) :: from(3), to(3)            !! prescribed values at the factors 0 and 1
    type(branch_type), intent(inout) :: branch        !! progress
    type(point_type), intent(inout) :: point          !! the point, start -> end
    type(report_type), intent(out) :: report          !! work, and why the branch ended
    type(equations_type) :: equations
    type(point_type) :: trial
    real(wp) :: direction(4), ending(4), length, unit, y(4), y_0(4)
    integer :: n
    logical :: good

    branch%turned = .false.
    call new_equations(law, control, from, to, equations)
    n = equations%n
    unit = load_length(law, equations)
    if (unit > most_branch_steps*branch%longest) then
      report%ended = ended_rejected
    else if (.not. unit > 0.0_wp .or. n == 0 .or. law%cannot_soften(point%state)) then
      call advance_factor(law, control, from, to, unit, branch, point, report)
    else if (branch%travelled > endless*law%reach + unit + spring_length(equations)) then
      report%ended = ended_endless
    end if
    if (report%ended /= ended_complete .or. report%updates > 0) return

    y_0 = 0.0_wp
    y_0(:n) = [point%s(equations%free(:n))]
    y_0(n + 1) = branch%factor*unit
    call move_point(point, equations%old)
    call find_direction(law, equations, unit, branch%factor, branch%last, direction, good)
    length = branch%length
    do while (good)
      call solve(law, equations, unit, y_0, direction, length, trial, y, ending, good)
      if (good) exit
      length = 0.5_wp*length
      good = length >= shortest_branch_step*branch%longest
    end do
    if (.not. good) call search(law, equations, unit, y_0, branch, direction, length, trial, y, ending, good)
    if (good .and. direction(n + 1)*ending(n + 1) < 0.0_wp) call find_fold(law, equations, unit, y_0, direction, &
      length, trial, y, ending)
    if (good .and. y(n + 1) >= unit) call find_end(law, equations, unit, y_0, direction, length, trial, y, good)
    report%parts = 1
    report%updates = equations%updates
    report%iterations = equations%iterations
    if (.not. good) then
      call move_point(equations%old, point)
      report%ended = ended_lost
      return
    end if
    call move_point(trial, point)
    branch%turned = (y(n + 1) < y_0(n + 1)) .neqv. branch%back
    branch%back = y(n + 1) < y_0(n + 1)
    branch%factor = y(n + 1)/unit
    if (y(n + 1) >= unit) branch%factor = 1.0_wp
    branch%last = y - y_0
    branch%travelled = branch%travelled + norm2(y - y_0)
    branch%length = min(branch%longest, 2.0_wp*length)
  end subroutine branch_step

  !> Where nothing can soften, the branch is the stable path: the prescribed values advance by a step.
  pure subroutine advance_factor(law, control, from, to, unit, branch, point, report)
    class(point_law), intent(in) :: law               !! the law
    type(control_type), intent(in) :: control         !! what is prescribed
    real(wp), intent(in) :: from(3), to(3)            !! prescribed values at the factors 0 and 1
    real(wp), intent(in) :: unit                      !! length of a unit of the load factor
    type(branch_type), intent(inout) :: branch        !! progress
    type(point_type), intent(inout) :: point          !! the point, start -> end
    type(report_type), intent(out) :: report          !! report
    real(wp) :: next, reached
    next = 1.0_wp
    if (unit > 0.0_wp) next = min(1.0_wp, branch%factor + branch%longest/unit)
    call advance(law, control, from + branch%factor*(to - from), merge(to, from + next*(to - from), next >= 1.0_wp), &
      point, reached, report)
    branch%turned = branch%back
    branch%back = .false.
    if (reached >= 1.0_wp) branch%factor = next
  end subroutine advance_factor

  !> Elongation of the springs without the interface, length: it belongs to the path of the separation.
  pure function spring_length(equations) result(length)
    type(equations_type), intent(in) :: equations   !! the prescribed values
    real(wp) :: length
    associate (k => equations%control%spring)
      length = maxval(merge(abs(equations%target - equations%start)/merge(k, 1.0_wp, k > 0.0_wp), 0.0_wp, &
        equations%control%traction .and. k > 0.0_wp))
    end associate
  end function spring_length

  !> Direction of the branch at the point, scaled to length 1, in the sense of another direction or, if that is zero, of
  !> an increasing load factor. Where the tangent is that of another side of a kink, the change in a short step decides.
  pure subroutine find_direction(law, equations, unit, factor, last, direction, good)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point
    real(wp), intent(in) :: unit                        !! length of a unit of the load factor
    real(wp), intent(in) :: factor                      !! load factor at the point
    real(wp), intent(in) :: last(4)                     !! another direction
    real(wp), intent(out) :: direction(4)               !! free separations, then the load factor times `unit`
    logical, intent(out) :: good                        !! whether there is one
    type(point_type) :: ahead
    real(wp) :: r(3), scale, sense(4), x(3)
    sense = last
    if (.not. any(abs(sense) > 0.0_wp)) sense(equations%n + 1) = 1.0_wp
    ! the tangent at the start of an update is that of a state that loads no further: look ahead along the last step
    sense = sense/norm2(sense)
    x = free_part(equations, equations%old%s)
    x(:equations%n) = x(:equations%n) + 1.0e-6_wp*law%length*sense(:equations%n)
    call evaluate(law, equations, x, factor + 1.0e-6_wp*law%length*sense(equations%n + 1)/unit, ahead, r, scale, good)
    if (good) call null_vector(equations, unit, ahead, sense, direction, good)
  end subroutine find_direction

  !> Null vector of the derivative of the equations, scaled to length 1, in the sense of a direction.
  pure subroutine null_vector(equations, unit, point, sense, v, good)
    type(equations_type), intent(in) :: equations   !! the equations
    real(wp), intent(in) :: unit                    !! length of a unit of the load factor
    type(point_type), intent(in) :: point           !! the point, its tangent
    real(wp), intent(in) :: sense(4)                !! a direction
    real(wp), intent(out) :: v(4)                   !! free separations, then the load factor times `unit`
    logical, intent(out) :: good                    !! whether there is one
    real(wp) :: a(3, 4)
    integer :: i, n
    n = equations%n
    a = 0.0_wp
    a(:, :3) = free_matrix(equations, point)
    a(:, n + 1) = -predict(equations, point, equations%target - equations%start)/unit
    v = 0.0_wp
    good = any(abs(a) > 0.0_wp)
    if (.not. good) return
    a = a/maxval(abs(a))
    ! the minors of the matrix, with alternating signs
    do i = 1, n + 1
      v(i) = (-1.0_wp)**i*determinant(n, reshape(pack(a, spread([1, 2, 3, 4] /= i, 1, 3)), [3, 3]))
    end do
    good = norm2(v) > 0.0_wp
    if (.not. good) return
    v = v/norm2(v)
    if (dot_product(v, sense) < 0.0_wp) v = -v
  end subroutine null_vector

  !> Determinant of the upper left n x n of a matrix.
  pure function determinant(n, a) result(value)
    integer, intent(in) :: n           !! 1 to 3
    real(wp), intent(in) :: a(3, 3)    !! the matrix
    real(wp) :: value
    select case (n)
    case (1)
      value = a(1, 1)
    case (2)
      value = a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)
    case default
      value = a(1, 1)*(a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) - a(1, 2)*(a(2, 1)*a(3, 3) - a(2, 3)*a(3, 1)) + &
        a(1, 3)*(a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1))
    end select
  end function determinant

  !> Solve for the equilibrium at a distance along the direction: of the unknowns, the one that changes most is
  !> prescribed. The step is accepted if the directions at both ends explain it.
  pure subroutine solve(law, equations, unit, y_0, direction, length, point, y, ending, good)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    real(wp), intent(in) :: unit                        !! length of a unit of the load factor
    real(wp), intent(in) :: y_0(4), direction(4)        !! unknowns and direction at the start
    real(wp), intent(in) :: length                      !! of the step
    type(point_type), intent(inout) :: point            !! -> the point at its end
    real(wp), intent(out) :: y(4)                       !! unknowns there
    real(wp), intent(out) :: ending(4)                  !! direction there
    logical, intent(out) :: good                        !! whether there is an equilibrium that continues the branch
    real(wp) :: mean(4), step(4)
    y = y_0 + length*direction
    call correct(law, equations, unit, maxloc(abs(direction), 1), point, y, good)
    if (.not. good) return
    step = y - y_0
    call null_vector(equations, unit, point, step, ending, good)
    if (good) good = norm2(step) < 3.0_wp*length
    if (.not. good .or. length < straight_step*law%length) return
    mean = direction + ending
    good = norm2(mean) > 0.0_wp
    if (good) good = norm2(step/norm2(step) - mean/norm2(mean)) < largest_turn
  end subroutine solve

  !> Find a short step where the directions at its ends do not explain it, at a kink of the branch: each unknown in turn
  !> is prescribed on both sides of the point. Of the equilibria that do not lead back, the one that continues the last
  !> step best is taken.
  pure subroutine search(law, equations, unit, y_0, branch, direction, length, point, y, ending, good)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    real(wp), intent(in) :: unit                        !! length of a unit of the load factor
    real(wp), intent(in) :: y_0(4)                      !! unknowns at the start
    type(branch_type), intent(in) :: branch             !! progress
    real(wp), intent(out) :: direction(4)               !! of the step that was found
    real(wp), intent(out) :: length                     !! of this step
    type(point_type), intent(inout) :: point            !! -> the point at its end
    real(wp), intent(out) :: y(4), ending(4)            !! unknowns and direction there
    logical, intent(out) :: good                        !! whether there is one
    type(point_type) :: trial
    real(wp) :: best, last(4), z(4)
    integer :: fixed, i, side
    logical :: solved
    good = .false.
    y = y_0
    ending = 0.0_wp
    direction = 0.0_wp
    last = branch%last
    if (.not. any(abs(last) > 0.0_wp)) last(equations%n + 1) = 1.0_wp
    last = last/norm2(last)
    best = backwards
    do i = 1, size(search_steps)
      length = search_steps(i)*law%length
      do fixed = 1, equations%n + 1
        do side = -1, 1, 2
          z = y_0
          z(fixed) = y_0(fixed) + real(side, wp)*length
          call correct(law, equations, unit, fixed, trial, z, solved)
          if (solved) solved = norm2(z - y_0) < 3.0_wp*length
          if (.not. solved) cycle
          if (dot_product(z - y_0, last) <= best*norm2(z - y_0)) cycle
          best = dot_product(z - y_0, last)/norm2(z - y_0)
          good = .true.
          y = z
          call move_point(trial, point)
        end do
      end do
      if (good) exit
    end do
    if (.not. good) return
    length = norm2(y - y_0)
    direction = (y - y_0)/length
    ending = direction
  end subroutine search

  !> Newton's method for the equations with one unknown prescribed.
  pure subroutine correct(law, equations, unit, fixed, point, y, good)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations
    real(wp), intent(in) :: unit                        !! length of a unit of the load factor
    integer, intent(in) :: fixed                        !! the unknown that is prescribed
    type(point_type), intent(inout) :: point            !! -> the point
    real(wp), intent(inout) :: y(4)                     !! unknowns: guess -> solution
    logical, intent(out) :: good                        !! whether the residual is small enough
    real(wp) :: a(3, 4), b(3), matrix(3, 3), r(3), scale
    integer :: i, iteration, j, n
    n = equations%n
    do iteration = 1, most_iterations
      call evaluate(law, equations, y(:3), y(n + 1)/unit, point, r, scale, good)
      if (.not. good) return
      good = maxval(abs(r)) <= residual_tolerance*scale
      if (good .or. iteration == most_iterations) return
      a = 0.0_wp
      a(:, :3) = free_matrix(equations, point)
      a(:, n + 1) = -predict(equations, point, equations%target - equations%start)/unit
      j = 0
      do i = 1, n + 1
        if (i == fixed) cycle
        j = j + 1
        matrix(:, j) = a(:, i)
      end do
      b = -r
      call eliminate(n, matrix, b, good)
      if (good) good = maxval(abs(b(:n))) <= farthest_equilibrium(law, equations, 1.0_wp)
      if (.not. good) return
      equations%iterations = equations%iterations + 1
      j = 0
      do i = 1, n + 1
        if (i == fixed) cycle
        j = j + 1
        y(i) = y(i) + b(j)
      end do
    end do
  end subroutine correct

  !> Shorten a step to the first fold in it, by bisection of its length; the step is kept where that fails.
  pure subroutine find_fold(law, equations, unit, y_0, direction, length, point, y, ending)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    real(wp), intent(in) :: unit                        !! length of a unit of the load factor
    real(wp), intent(in) :: y_0(4), direction(4)        !! unknowns and direction at the start
    real(wp), intent(inout) :: length                   !! of the step
    type(point_type), intent(inout) :: point            !! the point at its end -> at the fold
    real(wp), intent(inout) :: y(4), ending(4)          !! unknowns and direction there
    integer, parameter :: halvings = 20
    type(point_type) :: trial
    real(wp) :: first, last, middle, v(4), z(4)
    integer :: i
    logical :: good
    first = 0.0_wp
    last = length
    do i = 1, halvings
      middle = 0.5_wp*(first + last)
      call solve(law, equations, unit, y_0, direction, middle, trial, z, v, good)
      if (.not. good) return
      if (direction(equations%n + 1)*v(equations%n + 1) < 0.0_wp) then
        last = middle
      else
        first = middle
        call move_point(trial, point)
        y = z
        ending = v
      end if
    end do
    if (first > 0.0_wp) length = first
  end subroutine find_fold

  !> Shorten the last step to the prescribed values: there the load factor is 1, and Newton's method solves for the free
  !> separations.
  pure subroutine find_end(law, equations, unit, y_0, direction, length, point, y, good)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    real(wp), intent(in) :: unit                        !! length of a unit of the load factor
    real(wp), intent(in) :: y_0(4), direction(4)        !! unknowns and direction at the start
    real(wp), intent(in) :: length                      !! of the step
    type(point_type), intent(inout) :: point            !! the point at its end -> at the prescribed values
    real(wp), intent(inout) :: y(4)                     !! unknowns there
    logical, intent(out) :: good                        !! whether there is an equilibrium
    integer, parameter :: halvings = 60
    real(wp) :: ending(4), first, last, middle, z(4)
    integer :: i, n
    n = equations%n
    z = y_0 + (y - y_0)*((unit - y_0(n + 1))/(y(n + 1) - y_0(n + 1)))
    z(n + 1) = unit
    call correct(law, equations, unit, n + 1, point, z, good)
    if (good) good = norm2(z - y_0) < 3.0_wp*length
    if (good) y = z
    if (good) return
    ! the curve is too steep there: halve the step, and end just before the prescribed values
    first = 0.0_wp
    last = length
    do i = 1, halvings
      middle = 0.5_wp*(first + last)
      call solve(law, equations, unit, y_0, direction, middle, point, z, ending, good)
      if (.not. good) return
      if (z(n + 1) >= unit) then
        last = middle
        y = z
        if (abs(z(n + 1) - unit) <= residual_tolerance*unit) return
      else
        first = middle
      end if
    end do
    call solve(law, equations, unit, y_0, direction, last, point, y, ending, good)
  end subroutine find_end

end module asperity_branch
