!> A branch of equilibria, followed through its unstable part by local parametrisation: of the free separations and the
!> load factor, the one that changes most is prescribed in a step.
!>
!> Every step is an update of the law from the last equilibrium. The prescribed values depend on a load factor, which
!> may decrease: at a fold they turn back, where the stable path would snap.
module asperity_branch
  use asperity_control_point, only: control_type, equations_type, evaluate, farthest_equilibrium, free_matrix, &
    free_part, is_unstiff, move_point, new_equations, point_type, predict, values_at
  use asperity_elimination, only: eliminate
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, ended_complete, ended_endless, ended_lost, ended_rejected, report_type
  use asperity_point_law, only: point_law
  use asperity_text, only: append, to_text
  use asperity_tolerances, only: backwards, endless, largest_turn, most_branch_steps, most_iterations, &
    residual_tolerance, search_steps, shortest_branch_step, straight_step, tangent_distance
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
    integer :: steps = 0                !! number of steps so far
    logical :: back = .false.           !! whether the prescribed values go back
    logical :: searched = .false.       !! whether the last step was found by a search
    logical :: turned = .false.         !! whether their sense changed in the last step
  end type branch_type

  !> A step: unknowns (free separations, then the load factor times `unit`) and directions at both ends.
  type :: step_type
    real(wp) :: unit = 1.0_wp           !! length of a unit of the load factor
    real(wp) :: from(4) = 0.0_wp        !! unknowns at the start
    real(wp) :: direction(4) = 0.0_wp   !! direction of the branch there, of length 1
    real(wp) :: length = 0.0_wp         !! of the step
    real(wp) :: to(4) = 0.0_wp          !! unknowns at the end
    real(wp) :: ending(4) = 0.0_wp      !! direction of the branch there, in the sense of the step
    type(point_type) :: point           !! the point at the end
    logical :: good = .false.           !! whether the step continues the branch
  end type step_type

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
    type(step_type) :: step
    integer :: n
    logical :: turns

    branch%turned = .false.
    call new_equations(law, control, from, to, equations)
    n = equations%n
    step%unit = load_length(law, equations)
    if (step%unit > most_branch_steps*branch%longest) then
      report%ended = ended_rejected
      return
    else if (.not. step%unit > 0.0_wp .or. n == 0 .or. is_unstiff(point) .or. law%cannot_soften(point%state)) then
      call advance_factor(law, equations, step%unit, branch, point, report)
      return
    else if (branch%steps > int(most_branch_steps) .or. branch%travelled > &
      endless*law%reach + step%unit + spring_length(equations)) then
      report%ended = ended_endless
      return
    end if
    step%from(:n) = point%s(equations%free(:n))
    step%from(n + 1) = branch%factor*step%unit
    equations%moved = maxval(abs(point%s))
    call move_point(point, equations%old)
    call find_direction(law, equations, branch%last, step)
    step%length = branch%length
    do while (step%length >= shortest_branch_step*branch%longest)
      if (any(abs(step%direction) > 0.0_wp)) call solve(law, equations, step)
      if (step%good) exit
      step%length = 0.5_wp*step%length
    end do
    if (step%good) then
      branch%searched = .false.
    else
      call search(law, equations, branch, step)
      branch%searched = .true.
    end if
    turns = .false.
    if (step%good) turns = step%direction(n + 1)*step%ending(n + 1) < 0.0_wp
    if (turns) call find_fold(law, equations, step)
    report%parts = 1
    report%updates = equations%updates
    report%iterations = equations%iterations
    if (.not. step%good) then
      call move_point(equations%old, point)
      report%ended = ended_lost
      return
    end if
    call move_point(step%point, point)
    ! the row at a fold is the one where the prescribed values turn, and after a kink the first one that goes back
    turns = (step%to(n + 1) < step%from(n + 1)) .neqv. turns
    branch%turned = turns .neqv. branch%back
    branch%back = turns
    branch%factor = step%to(n + 1)/step%unit
    if (step%to(n + 1) >= step%unit) branch%factor = 1.0_wp
    branch%last = step%to - step%from
    branch%steps = branch%steps + 1
    branch%travelled = branch%travelled + norm2(branch%last)
    branch%length = min(branch%longest, 2.0_wp*step%length)
  end subroutine branch_step

  !> Where nothing can soften, or an open joint carries nothing, the branch is the stable path: the prescribed values
  !> advance by a step in which the separations change by a few s0.
  pure subroutine advance_factor(law, equations, unit, branch, point, report)
    class(point_law), intent(in) :: law               !! the law
    type(equations_type), intent(in) :: equations     !! the prescribed values
    real(wp), intent(in) :: unit                      !! length of a unit of the load factor
    type(branch_type), intent(inout) :: branch        !! progress
    type(point_type), intent(inout) :: point          !! the point, start -> end
    type(report_type), intent(out) :: report          !! report
    integer, parameter :: most_halvings = 30
    real(wp), parameter :: longest_push = 2.0_wp
    type(point_type) :: trial
    real(wp) :: next, reached, step
    integer :: i
    step = 1.0_wp
    if (unit > 0.0_wp) step = branch%longest/unit
    do i = 1, most_halvings
      next = min(1.0_wp, branch%factor + step)
      trial = point
      call advance(law, equations%control, values_at(equations, branch%factor), values_at(equations, next), trial, &
        reached, report)
      if (sqrt(sum((trial%s - point%s)**2)) <= longest_push*law%length .or. .not. unit > 0.0_wp) exit
      step = 0.5_wp*step
    end do
    call move_point(trial, point)
    if (reached < 1.0_wp) then
      report%ended = ended_endless
      return
    end if
    branch%turned = branch%back
    branch%back = .false.
    branch%factor = next
    branch%last = 0.0_wp
  end subroutine advance_factor

  !> Length of a unit of the load factor: of the change of the prescribed separations, or of an elastic plane under the
  !> change of the prescribed tractions if no separation changes.
  pure function load_length(law, equations) result(length)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the prescribed values
    real(wp) :: length
    associate (change => equations%target - equations%start, traction => equations%control%traction)
      length = sqrt(sum(merge(0.0_wp, change, traction)**2))
      if (.not. length > 0.0_wp) length = sqrt(sum(merge(change, 0.0_wp, traction)**2))/law%stiffness
    end associate
  end function load_length

  !> Elongation of the springs without the interface, length: it belongs to the path of the separation.
  pure function spring_length(equations) result(length)
    type(equations_type), intent(in) :: equations   !! the prescribed values
    real(wp) :: length
    associate (k => equations%control%spring)
      length = maxval(merge(abs(equations%target - equations%start)/merge(k, 1.0_wp, k > 0.0_wp), 0.0_wp, &
        equations%control%traction .and. k > 0.0_wp))
    end associate
  end function spring_length

  !> Direction of the branch at the start of a step, in the sense of the last step or, before the first one, of an
  !> increasing load factor; zero if there is none. The tangent at the start of an update is that of a state that loads
  !> no further: the tangent a little farther along the last step is taken.
  pure subroutine find_direction(law, equations, last, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point
    real(wp), intent(in) :: last(4)                     !! the last step; zero: there was none
    type(step_type), intent(inout) :: step              !! its unknowns at the start; the direction is set
    type(point_type) :: ahead
    real(wp) :: r(3), scale, y(4)
    logical :: good
    y = step%from + (tangent_distance*law%length)*sense_of(equations%n, last)
    call evaluate(law, equations, y(:3), y(equations%n + 1)/step%unit, ahead, r, scale, good)
    if (good) step%direction = null_vector(equations, step%unit, ahead, sense_of(equations%n, last))
  end subroutine find_direction

  !> Direction of the last step, or that of an increasing load factor if there was none.
  pure function sense_of(n, last) result(sense)
    integer, intent(in) :: n          !! free separations
    real(wp), intent(in) :: last(4)   !! the last step; zero: there was none
    real(wp) :: sense(4)
    sense = last
    if (.not. any(abs(sense) > 0.0_wp)) sense(n + 1) = 1.0_wp
    sense = sense/sqrt(sum(sense**2))
  end function sense_of

  !> Derivative of the residual with respect to the unknowns, in the upper left n x (n + 1).
  pure function derivative(equations, unit, point) result(a)
    type(equations_type), intent(in) :: equations   !! the equations
    real(wp), intent(in) :: unit                    !! length of a unit of the load factor
    type(point_type), intent(in) :: point           !! the point, its tangent
    real(wp) :: a(3, 4)
    a = 0.0_wp
    a(:, :3) = free_matrix(equations, point)
    a(:, equations%n + 1) = -predict(equations, point, equations%target - equations%start)/unit
  end function derivative

  !> Null vector of the derivative, of length 1, in the sense of a direction; zero if there is none or more than one.
  pure function null_vector(equations, unit, point, sense) result(v)
    type(equations_type), intent(in) :: equations   !! the equations
    real(wp), intent(in) :: unit                    !! length of a unit of the load factor
    type(point_type), intent(in) :: point           !! the point, its tangent
    real(wp), intent(in) :: sense(4)                !! a direction
    real(wp) :: v(4)
    real(wp) :: a(4, 4)
    integer :: n
    logical :: good
    n = equations%n + 1
    a(:3, :) = derivative(equations, unit, point)
    a(:3, :) = a(:3, :)/max(maxval(abs(a(:3, :))), tiny(a))
    a(n, :) = sense
    v = 0.0_wp
    v(n) = 1.0_wp
    call eliminate(n, a, v, good)
    v = merge(v, 0.0_wp, good)
    if (good) v = v/sqrt(sum(v**2))
  end function null_vector

  !> Solve for the equilibrium at the length of the step along its direction: the unknown that changes most is
  !> prescribed. A step beyond the prescribed values ends at them. It is accepted if the directions at both ends explain
  !> it.
  pure subroutine solve(law, equations, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    type(step_type), intent(inout) :: step              !! start, direction and length -> end
    real(wp) :: change(4), length, mean(4)
    integer :: n
    n = equations%n
    step%to = step%from + step%length*step%direction
    call correct(law, equations, maxloc(abs(step%direction), 1), step)
    if (.not. step%good) return
    change = step%to - step%from
    length = sqrt(sum(change**2))
    step%ending = null_vector(equations, step%unit, step%point, change)
    step%good = length < 3.0_wp*step%length .and. any(abs(step%ending) > 0.0_wp)
    if (step%good .and. step%length >= straight_step*law%length) then
      mean = step%direction + step%ending
      step%good = any(abs(mean) > 0.0_wp)
      if (step%good) step%good = sqrt(sum((change/length - mean/sqrt(sum(mean**2)))**2)) < largest_turn
    end if
    if (step%good) call stop_at_end(law, equations, step)
  end subroutine solve

  !> Shorten a step beyond the prescribed values: it ends at them.
  pure subroutine stop_at_end(law, equations, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    type(step_type), intent(inout) :: step              !! the step
    integer :: n
    n = equations%n
    if (step%to(n + 1) <= step%unit) return
    step%to = step%from + (step%to - step%from)*((step%unit - step%from(n + 1))/(step%to(n + 1) - step%from(n + 1)))
    step%to(n + 1) = step%unit
    call correct(law, equations, n + 1, step)
    if (step%good) step%good = sqrt(sum((step%to - step%from)**2)) < 3.0_wp*step%length
  end subroutine stop_at_end

  !> Newton's method for the equations with one unknown prescribed.
  pure subroutine correct(law, equations, fixed, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations
    integer, intent(in) :: fixed                        !! the unknown that is prescribed
    type(step_type), intent(inout) :: step              !! unknowns at the end: guess -> solution
    real(wp) :: a(3, 4), b(3), matrix(3, 3), r(3), scale
    integer :: iteration, n, others(3)
    logical :: solved
    n = equations%n
    others = pack([1, 2, 3, 4], [1, 2, 3, 4] /= fixed)
    do iteration = 1, most_iterations
      call evaluate(law, equations, step%to(:3), step%to(n + 1)/step%unit, step%point, r, scale, step%good)
      if (.not. step%good) return
      step%good = maxval(abs(r)) <= residual_tolerance*scale
      if (step%good) return
      a = derivative(equations, step%unit, step%point)
      matrix = a(:, others)
      b = -r
      call eliminate(n, matrix, b, solved)
      if (solved) solved = maxval(abs(b(:n))) <= farthest_equilibrium(law, equations, 1.0_wp)
      if (.not. solved) return
      equations%iterations = equations%iterations + 1
      step%to(others(:n)) = step%to(others(:n)) + b(:n)
    end do
  end subroutine correct

  !> Find a short step where the directions at its ends do not explain it, at a kink of the branch: each unknown in turn
  !> is prescribed on both sides of the point. Of the equilibria that do not lead back, the one that continues the last
  !> step best is taken. The first search at a kink takes the shortest step, so that a fold there has a row; if that
  !> leads to another search, the step is long enough to leave the kink.
  pure subroutine search(law, equations, branch, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    type(branch_type), intent(in) :: branch             !! progress
    type(step_type), intent(inout) :: step              !! unknowns at the start -> the step
    type(step_type) :: trial
    real(wp) :: best, cosine, distances(size(search_steps))
    integer :: fixed, i, side
    trial = step
    best = backwards
    distances = search_steps*law%length
    if (branch%searched) distances = distances(size(distances):1:-1)
    do i = 1, size(distances)
      do fixed = 1, equations%n + 1
        do side = -1, 1, 2
          trial%to = step%from
          trial%to(fixed) = step%from(fixed) + real(side, wp)*distances(i)
          call correct(law, equations, fixed, trial)
          if (.not. trial%good) cycle
          trial%direction = trial%to - step%from
          trial%length = sqrt(sum(trial%direction**2))
          trial%direction = trial%direction/trial%length
          cosine = dot_product(trial%direction, sense_of(equations%n, branch%last))
          if (cosine <= best .or. trial%length > 3.0_wp*distances(i)) cycle
          call stop_at_end(law, equations, trial)
          if (.not. trial%good) cycle
          best = cosine
          trial%ending = trial%direction
          step = trial
        end do
      end do
      if (step%good) return
    end do
  end subroutine search

  !> Shorten a step to the first fold in it, by bisection of its length; the step is kept where that fails.
  pure subroutine find_fold(law, equations, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    type(step_type), intent(inout) :: step              !! the step -> shortened
    integer, parameter :: halvings = 20
    type(step_type) :: trial
    real(wp) :: longest
    integer :: i
    longest = step%length
    trial = step
    do i = 1, halvings
      trial%length = 0.5_wp*(merge(step%length, 0.0_wp, step%length < longest) + longest)
      call solve(law, equations, trial)
      ! a step to the other side of a kink is not explained by the directions at its ends
      if (.not. trial%good .or. trial%direction(equations%n + 1)*trial%ending(equations%n + 1) < 0.0_wp) then
        longest = trial%length
      else
        step = trial
      end if
    end do
  end subroutine find_fold

end module asperity_branch
