!> A step along a branch: its direction, Newton's method with one unknown prescribed, folds and forks in it.
module asperity_branch_step
  use asperity_equations, only: equations_type, evaluate, farthest_equilibrium, free_matrix, point_type, predict
  use asperity_elimination, only: eliminate
  use asperity_kinds, only: wp
  use asperity_null_space, only: null_space, null_space_type
  use asperity_point_law, only: point_law
  use asperity_tolerances, only: backwards, fold_halvings, largest_turn, most_halvings, most_iterations, &
    residual_tolerance, search_steps, straight_step, worst_condition
  implicit none
  private
  public :: null_vector, solve, search, leave, find_fold, find_fork

  !> A step: unknowns (separations, zero where they are prescribed, then the load factor times `unit`) and directions at
  !> both ends.
  type, public :: step_type
    real(wp) :: unit = 1.0_wp           !! length of a unit of the load factor
    real(wp) :: from(4) = 0.0_wp        !! unknowns at the start
    real(wp) :: direction(4) = 0.0_wp   !! direction of the branch there, of length 1
    real(wp) :: length = 0.0_wp         !! of the step
    real(wp) :: to(4) = 0.0_wp          !! unknowns at the end
    real(wp) :: ending(4) = 0.0_wp      !! direction of the branch there, in the sense of the step
    real(wp) :: orientation = 0.0_wp    !! sign of the equations there, 0: not known
    real(wp) :: second(4) = 0.0_wp      !! direction of a branch that crosses there, if one does
    type(point_type) :: point           !! the point at the end
    logical :: good = .false.           !! whether the step continues the branch
  end type step_type

contains

  !> Equations of the branch at a point, over the stiffness of the bond: changes of the unknowns -> of the residual.
  pure function matrix_of(law, equations, step) result(a)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(step_type), intent(in) :: step             !! its point, with the tangent
    real(wp) :: a(3, 4)
    a(:, :3) = free_matrix(law, equations, step%point)/law%stiffness
    a(:, 4) = -predict(equations, step%point, equations%target - equations%start)/(step%unit*law%stiffness)
  end function matrix_of

  !> Solve for a change of the unknowns that changes the residual by b(:3), with one more equation: row*change = b(4).
  pure subroutine solve_bordered(law, equations, step, row, b, solved)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(step_type), intent(in) :: step             !! its point, with the tangent
    real(wp), intent(in) :: row(4)                  !! of length 1
    real(wp), intent(inout) :: b(4)                 !! right-hand side -> change
    logical, intent(out) :: solved                  !! false: there is none, or more than one
    real(wp) :: a(4, 4)
    type(null_space_type) :: null
    integer :: i
    a(:3, :) = matrix_of(law, equations, step)
    a(4, :) = row
    b(:3) = b(:3)/law%stiffness
    null = null_space(a(:3, :), row, count(equations%control%traction))
    ! on a surface the border does not do: what nothing holds stays
    do i = 1, merge(3, 0, null%is_surface)
      a(i, i) = a(i, i) + 1.0_wp/worst_condition
    end do
    call eliminate(4, a, b, solved)
  end subroutine solve_bordered

  !> Direction of the branch, of length 1, in a sense, and what else the equations hardly see.
  pure function null_vector(law, equations, step, sense) result(null)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(step_type), intent(in) :: step             !! its point, with the tangent
    real(wp), intent(in) :: sense(4)                !! a direction
    type(null_space_type) :: null
    null = null_space(matrix_of(law, equations, step), sense, count(equations%control%traction))
  end function null_vector

  !> Solve for the equilibrium at the length of the step along its direction: the unknown that changes most is
  !> prescribed. The step is accepted if the directions at both ends explain it.
  subroutine solve(law, equations, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    type(step_type), intent(inout) :: step              !! start, direction and length -> end
    type(null_space_type) :: null
    real(wp) :: change(4), length, mean(4)
    step%to = step%from + step%length*step%direction
    call correct(law, equations, maxloc(abs(step%direction), 1), step)
    if (.not. step%good) return
    change = step%to - step%from
    length = norm2(change)
    null = null_vector(law, equations, step, change/length)
    call set_end(step, null)
    step%good = any(abs(step%ending) > 0.0_wp)
    if (step%good .and. step%length >= straight_step*law%s_0) then
      mean = step%direction + step%ending
      step%good = norm2(norm2(mean)*change/length - mean) < largest_turn*norm2(mean)
    end if
  end subroutine solve

  !> Newton's method for the equations with one unknown prescribed. A step beyond the prescribed values is shortened to
  !> them. An equilibrium that is much farther than the length of the step is not accepted.
  subroutine correct(law, equations, fixed, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations
    integer, intent(in) :: fixed                        !! the unknown that is prescribed
    type(step_type), intent(inout) :: step              !! unknowns at the end: guess -> solution
    real(wp) :: b(4), error, r(3), row(4)
    integer :: iteration
    logical :: solved
    row = 0.0_wp
    row(fixed) = 1.0_wp
    step%good = .false.
    do iteration = 1, most_iterations
      call evaluate(law, equations, step%to(:3), step%to(4)/step%unit, step%point, r, error)
      if (error >= huge(error)) return
      if (error <= residual_tolerance) then
        step%good = norm2(step%to - step%from) < 3.0_wp*step%length .and. step%to(4) <= step%unit
        if (step%to(4) <= step%unit) return
        row = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp]
        step%to = step%from + (step%to - step%from)*((step%unit - step%from(4))/(step%to(4) - step%from(4)))
        step%to(4) = step%unit
        cycle
      end if
      b = [-r, 0.0_wp]
      call solve_bordered(law, equations, step, row, b, solved)
      if (solved) solved = maxval(abs(b)) <= farthest_equilibrium(law, equations, 1.0_wp)
      if (.not. solved) return
      equations%report%iterations = equations%report%iterations + 1
      step%to = step%to + b
    end do
  end subroutine correct

  !> Find a short step where the directions at its ends do not explain it, at a kink of the branch: each unknown in turn
  !> is prescribed on both sides of the point. Of the equilibria that do not lead back, the one that continues the last
  !> step best is taken. The first search at a kink takes the shortest step, so that a fold there has a row; if that
  !> leads to another search, the step is long enough to leave the kink.
  subroutine search(law, equations, again, sense, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    logical, intent(in) :: again                        !! whether the last step was found by a search
    real(wp), intent(in) :: sense(4)                    !! direction of the last step, of length 1
    type(step_type), intent(inout) :: step              !! unknowns at the start -> the step
    type(step_type) :: trial
    type(null_space_type) :: null
    real(wp) :: best, cosine, distances(size(search_steps))
    integer :: fixed, i, side
    trial = step
    best = backwards
    distances = search_steps*law%s_0
    if (again) distances = distances(size(distances):1:-1)
    do i = 1, size(distances)
      do fixed = 1, 4
        if (.not. any([pack([1, 2, 3], equations%control%traction), 4] == fixed)) cycle
        do side = -1, 1, 2
          trial%length = distances(i)
          trial%to = step%from
          trial%to(fixed) = step%from(fixed) + real(side, wp)*distances(i)
          call correct(law, equations, fixed, trial)
          if (.not. trial%good) cycle
          trial%length = norm2(trial%to - step%from)
          trial%direction = (trial%to - step%from)/trial%length
          cosine = dot_product(trial%direction, sense)
          if (cosine <= best) cycle
          best = cosine
          null = null_vector(law, equations, trial, trial%direction)
          call set_end(trial, null)
          trial%ending = trial%direction
          step = trial
        end do
      end do
      if (step%good) return
    end do
  end subroutine search

  !> Set what the end of a step says of the branch.
  pure subroutine set_end(step, null)
    type(step_type), intent(inout) :: step       !! the step
    type(null_space_type), intent(in) :: null    !! null space at its end
    step%ending = null%direction
    step%orientation = null%sense
    step%second = null%second
  end subroutine set_end

  !> Leave a branch at a fork: the unknown that changes most along the other branch is prescribed, nearby first.
  subroutine leave(law, equations, longest, aside, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    real(wp), intent(in) :: longest                     !! longest step, length
    real(wp), intent(in) :: aside(4)                    !! direction in which it is left, of length 1
    type(step_type), intent(inout) :: step              !! unknowns at the start -> the step, if it is good
    !> Halvings of the longest step for the first trial: at a fork itself both branches are alike.
    integer, parameter :: first_halvings = 8
    type(step_type) :: trial
    type(null_space_type) :: null
    integer :: i
    do i = first_halvings, 0, -1
      trial = step
      trial%length = longest*0.5_wp**i
      trial%to = step%from + trial%length*aside
      call correct(law, equations, maxloc(abs(aside), 1), trial)
      if (.not. trial%good) cycle
      trial%length = norm2(trial%to - step%from)
      trial%direction = (trial%to - step%from)/trial%length
      if (dot_product(trial%direction, aside) < 0.5_wp) cycle
      null = null_vector(law, equations, trial, trial%direction)
      call set_end(trial, null)
      step = trial
      ! the sense in which the other branch is taken is free
      step%direction = step%ending
      return
    end do
  end subroutine leave

  !> Shorten a step to just beyond the fork in it, by bisection of its length; the step is kept where that fails.
  subroutine find_fork(law, equations, before, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    real(wp), intent(in) :: before                      !! sign of the equations at the start
    type(step_type), intent(inout) :: step              !! the step -> shortened
    type(step_type) :: trial
    real(wp) :: shortest
    integer :: i
    shortest = 0.0_wp
    do i = 1, fold_halvings
      trial = step
      trial%length = 0.5_wp*(shortest + step%length)
      call solve(law, equations, trial)
      if (trial%good .and. trial%orientation*before < 0.0_wp) then
        step = trial
      else
        shortest = trial%length
      end if
    end do
  end subroutine find_fork

  !> Shorten a step to the first fold in it, by bisection of its length; the step is kept where that fails.
  subroutine find_fold(law, equations, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    type(step_type), intent(inout) :: step              !! the step -> shortened
    type(step_type) :: trial
    real(wp) :: longest
    integer :: i
    longest = step%length
    trial = step
    do i = 1, fold_halvings
      trial%length = 0.5_wp*(merge(step%length, 0.0_wp, step%length < longest) + longest)
      call solve(law, equations, trial)
      ! a step to the other side of a kink is not explained by the directions at its ends
      if (.not. trial%good .or. trial%direction(4)*trial%ending(4) < 0.0_wp) then
        longest = trial%length
      else
        step = trial
      end if
    end do
  end subroutine find_fold

end module asperity_branch_step
