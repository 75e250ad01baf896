!> A branch of equilibria, followed through its unstable part by local parametrisation: of the free separations and the
!> load factor, the one that changes most is prescribed in a step.
!>
!> Every step is an update of the law from the last equilibrium. The prescribed values depend on a load factor, which
!> may decrease: at a fold they turn back, where the stable path would snap. Where another branch crosses, at a fork,
!> either may be followed.
module asperity_branch
  use asperity_equations, only: equations_type, evaluate, farthest_equilibrium, free_matrix, is_unstiff, &
    new_equations, predict, ramp
  use asperity_elimination, only: eliminate
  use asperity_kinds, only: wp
  use asperity_null_space, only: null_space, null_space_type
  use asperity_increment, only: advance, control_type, ended_complete, ended_endless, ended_lost, ended_rejected, &
    point_type, report_type
  use asperity_point_law, only: point_law
  use asperity_tolerances, only: backwards, endless, fold_halvings, largest_turn, longest_push, most_branch_steps, &
    most_halvings, most_iterations, residual_tolerance, search_steps, shortest_branch_step, straight_step, &
    tangent_distance
  implicit none
  private
  public :: new_branch, branch_step

  !> One change of the prescribed values, and the progress along its branch.
  type, public :: branch_type
    type(control_type) :: control       !! what is prescribed
    real(wp) :: from(3) = 0.0_wp, to(3) = 0.0_wp   !! prescribed values at the factors 0 and 1
    real(wp) :: unit = 0.0_wp           !! length of a unit of the load factor
    real(wp) :: longest = 0.0_wp        !! longest step, length
    real(wp) :: remaining = 0.0_wp      !! length of further steps until the branch counts as endless
    real(wp) :: length = 0.0_wp         !! of the next step, length
    real(wp) :: factor = 0.0_wp         !! load factor, 1: the prescribed values are reached
    real(wp) :: sense(4) = 0.0_wp       !! direction of the last step, of length 1; at first an increasing load factor
    integer :: steps = 0                !! number of steps so far
    logical :: back = .false.           !! whether the prescribed values go back
    logical :: searched = .false.       !! whether the last step was found by a search
    logical :: turned = .false.         !! whether their sense changed in the last step
    integer :: fork = 0                 !! at the next fork: 0 go along, 1 or -1 leave to one side or the other
    logical :: forked = .false.         !! whether another branch crosses in the last step
    real(wp) :: orientation = 0.0_wp    !! sign of the equations at the last point, which a fork changes; 0: not known
    real(wp) :: aside(4) = 0.0_wp       !! direction in which the next step leaves the branch; zero: it stays
  end type branch_type

  !> A step: unknowns (separations, zero where they are prescribed, then the load factor times `unit`) and directions at
  !> both ends.
  type :: step_type
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

  !> A branch before its first step; its steps are at most `arc` s0 long.
  !>
  !> The length of a unit of the load factor is that of the change of the prescribed separations, or of an elastic plane
  !> under the change of the prescribed tractions if no separation changes. The elongation of the springs without the
  !> interface belongs to the path of the separation.
  pure function new_branch(law, control, from, to, arc, fork) result(branch)
    class(point_law), intent(in) :: law         !! the law
    type(control_type), intent(in) :: control   !! what is prescribed
    real(wp), intent(in) :: from(3), to(3)      !! prescribed values at the factors 0 and 1
    real(wp), intent(in) :: arc                 !! longest step, relative to s0
    integer, intent(in) :: fork                 !! at the first fork: 0 go along, 1 or -1 leave to a side
    type(branch_type) :: branch
    real(wp) :: springs
    associate (change => to - from, k => control%spring, traction => control%traction)
      branch%unit = norm2(merge(0.0_wp, change, traction))
      if (.not. branch%unit > 0.0_wp) branch%unit = norm2(merge(change, 0.0_wp, traction))/law%stiffness
      springs = maxval(merge(abs(change)/merge(k, 1.0_wp, k > 0.0_wp), 0.0_wp, traction .and. k > 0.0_wp))
    end associate
    branch%control = control
    branch%from = from
    branch%to = to
    branch%longest = arc*law%length
    branch%length = branch%longest
    branch%remaining = endless*law%reach + branch%unit + springs
    branch%sense(4) = 1.0_wp
    branch%fork = fork
  end function new_branch

  !> Take a step along the branch. The last step ends at the prescribed values, where the load factor is 1.
  !>
  !> A step ends at the first fold in it, so that the rows have the extreme values of the load factor. If the branch
  !> does not continue, the point stays, and the report says why: `ended_endless` if the separation grows without end,
  !> `ended_rejected` if the prescribed values are too far for the length of the steps, else `ended_lost`.
  pure subroutine branch_step(law, branch, point, report)
    class(point_law), intent(in) :: law               !! the law
    type(branch_type), intent(inout) :: branch        !! progress
    type(point_type), intent(inout) :: point          !! the point, start -> end
    type(report_type), intent(out) :: report          !! work, and why the branch ended
    type(equations_type) :: equations
    type(step_type) :: step
    type(null_space_type) :: null
    real(wp) :: ahead(4), change(4), error, r(3)
    logical :: found, turns

    branch%turned = .false.
    branch%forked = .false.
    if (branch%unit > most_branch_steps*branch%longest .or. branch%steps > int(most_branch_steps)) then
      report%ended = ended_rejected
      return
    else if (.not. branch%unit > 0.0_wp .or. .not. any(branch%control%traction) .or. is_unstiff(point) .or. &
      law%cannot_soften(point%state)) then
      call advance_factor(law, branch, point, report)
      return
    else if (branch%remaining < 0.0_wp) then
      report%ended = ended_endless
      return
    end if
    step%unit = branch%unit
    step%from = [merge(point%s, 0.0_wp, branch%control%traction), branch%factor*branch%unit]
    call new_equations(branch%control, branch%from, branch%to, point, equations)
    ! The tangent at the start of an update is that of a state that loads no further: it is taken a little farther.
    ahead = step%from + tangent_distance*law%length*branch%sense
    call evaluate(law, equations, ahead(:3), ahead(4)/step%unit, step%point, r, error)
    if (error < huge(error)) then
      null = null_vector(law, equations, step, branch%sense)
      step%direction = null%direction
      if (.not. abs(branch%orientation) > 0.0_wp) branch%orientation = null%sense
    end if
    step%length = branch%length
    if (any(abs(branch%aside) > 0.0_wp)) call leave(law, equations, branch, step)
    if (step%good) branch%orientation = step%orientation
    do while (step%length >= shortest_branch_step*branch%longest .and. .not. step%good)
      if (any(abs(step%direction) > 0.0_wp)) call solve(law, equations, step)
      if (step%good) exit
      step%length = 0.5_wp*step%length
    end do
    found = step%good
    if (.not. found) call search(law, equations, branch, step)
    branch%searched = .not. found
    turns = step%good .and. step%direction(4)*step%ending(4) < 0.0_wp
    if (turns) call find_fold(law, equations, step)
    branch%forked = step%good .and. step%orientation*branch%orientation < 0.0_wp
    if (branch%forked .and. found) call find_fork(law, equations, branch%orientation, step)
    report = equations%report
    report%parts = 1
    if (.not. step%good) then
      report%ended = ended_lost
      return
    end if
    point = step%point
    ! the row at a fold is the one where the prescribed values turn, and after a kink the first one that goes back
    change = step%to - step%from
    turns = (change(4) < 0.0_wp) .neqv. turns
    branch%turned = turns .neqv. branch%back
    branch%back = turns
    branch%factor = step%to(4)/step%unit
    branch%sense = change/norm2(change)
    branch%aside = 0.0_wp
    if (branch%forked .and. branch%fork /= 0) then
      branch%aside = real(branch%fork, wp)*step%second
      branch%fork = 0
    end if
    if (abs(step%orientation) > 0.0_wp) branch%orientation = step%orientation
    branch%steps = branch%steps + 1
    branch%remaining = branch%remaining - norm2(change)
    branch%length = min(branch%longest, 2.0_wp*step%length)
  end subroutine branch_step

  !> Where nothing can soften, or an open joint carries nothing, the branch is the stable path: the prescribed values
  !> advance by a step in which the separations change by a few s0.
  pure subroutine advance_factor(law, branch, point, report)
    class(point_law), intent(in) :: law               !! the law
    type(branch_type), intent(inout) :: branch        !! progress
    type(point_type), intent(inout) :: point          !! the point, start -> end
    type(report_type), intent(out) :: report          !! report
    type(point_type) :: trial
    real(wp) :: next, reached, step
    integer :: i
    step = 1.0_wp
    if (branch%unit > 0.0_wp) step = branch%longest/branch%unit
    do i = 1, most_halvings
      next = min(1.0_wp, branch%factor + step)
      trial = point
      call advance(law, branch%control, ramp(branch%from, branch%to, branch%factor), ramp(branch%from, branch%to, &
        next), trial, reached, report)
      if (norm2(trial%s - point%s) <= longest_push*law%length) exit
      step = 0.5_wp*step
    end do
    point = trial
    if (reached < 1.0_wp) then
      report%ended = ended_endless
      return
    end if
    branch%turned = branch%back
    branch%back = .false.
    branch%steps = branch%steps + 1
    branch%factor = next
    branch%sense = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp]
  end subroutine advance_factor

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
    a(:3, :) = matrix_of(law, equations, step)
    a(4, :) = row
    b(:3) = b(:3)/law%stiffness
    call eliminate(4, a, b, solved)
  end subroutine solve_bordered

  !> Direction of the branch, of length 1, in a sense, and what else the equations hardly see.
  pure function null_vector(law, equations, step, sense) result(null)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(step_type), intent(in) :: step             !! its point, with the tangent
    real(wp), intent(in) :: sense(4)                !! a direction
    type(null_space_type) :: null
    null = null_space(matrix_of(law, equations, step), sense)
  end function null_vector

  !> Solve for the equilibrium at the length of the step along its direction: the unknown that changes most is
  !> prescribed. The step is accepted if the directions at both ends explain it.
  pure subroutine solve(law, equations, step)
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
    if (step%good .and. step%length >= straight_step*law%length) then
      mean = step%direction + step%ending
      step%good = norm2(norm2(mean)*change/length - mean) < largest_turn*norm2(mean)
    end if
  end subroutine solve

  !> Newton's method for the equations with one unknown prescribed. A step beyond the prescribed values is shortened to
  !> them. An equilibrium that is much farther than the length of the step is not accepted.
  pure subroutine correct(law, equations, fixed, step)
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
  pure subroutine search(law, equations, branch, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    type(branch_type), intent(in) :: branch             !! progress
    type(step_type), intent(inout) :: step              !! unknowns at the start -> the step
    type(step_type) :: trial
    type(null_space_type) :: null
    real(wp) :: best, cosine, distances(size(search_steps))
    integer :: fixed, i, side
    trial = step
    best = backwards
    distances = search_steps*law%length
    if (branch%searched) distances = distances(size(distances):1:-1)
    do i = 1, size(distances)
      do fixed = 1, 4
        if (.not. any([pack([1, 2, 3], branch%control%traction), 4] == fixed)) cycle
        do side = -1, 1, 2
          trial%length = distances(i)
          trial%to = step%from
          trial%to(fixed) = step%from(fixed) + real(side, wp)*distances(i)
          call correct(law, equations, fixed, trial)
          if (.not. trial%good) cycle
          trial%length = norm2(trial%to - step%from)
          trial%direction = (trial%to - step%from)/trial%length
          cosine = dot_product(trial%direction, branch%sense)
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
  pure subroutine leave(law, equations, branch, step)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations and the point at the start
    type(branch_type), intent(in) :: branch             !! with the direction in which it is left
    type(step_type), intent(inout) :: step              !! unknowns at the start -> the step, if it is good
    !> Halvings of the longest step for the first trial: at a fork itself both branches are alike.
    integer, parameter :: first_halvings = 8
    type(step_type) :: trial
    type(null_space_type) :: null
    integer :: i
    do i = first_halvings, 0, -1
      trial = step
      trial%length = branch%longest*0.5_wp**i
      trial%to = step%from + trial%length*branch%aside
      call correct(law, equations, maxloc(abs(branch%aside), 1), trial)
      if (.not. trial%good) cycle
      trial%length = norm2(trial%to - step%from)
      trial%direction = (trial%to - step%from)/trial%length
      if (dot_product(trial%direction, branch%aside) < 0.5_wp) cycle
      null = null_vector(law, equations, trial, trial%direction)
      call set_end(trial, null)
      step = trial
      ! the sense in which the other branch is taken is free
      step%direction = step%ending
      return
    end do
  end subroutine leave

  !> Shorten a step to just beyond the fork in it, by bisection of its length; the step is kept where that fails.
  pure subroutine find_fork(law, equations, before, step)
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
  pure subroutine find_fold(law, equations, step)
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

end module asperity_branch
