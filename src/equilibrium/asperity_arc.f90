!> A branch of equilibria, followed through its unstable part by steps of given length (arc length method, Riks).
!>
!> Every step is an update of the law from the last equilibrium. The prescribed values depend on a load factor, which
!> may decrease: at a fold they turn back, where the stable path would jump.
module asperity_arc
  use asperity_arc_equations, only: branch_tangent, length_product, load_length
  use asperity_arc_step, only: begin_step, goes_back, has_no_folds, look, search, solve, step_type, try
  use asperity_control_point, only: elastic_stiffness, free_matrix, free_part, move_point, point_type, unstable
  use asperity_increment, only: path_type, set_share
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, ended_complete, ended_divided, ended_endless, ended_lost, &
    ended_rejected, report_type
  use asperity_newton, only: newton_solve, newton_type
  use asperity_text, only: append, to_text
  implicit none
  private
  public :: new_arc, arc_step, explain_no_branch, explain_end

  !> Longest step of a branch, relative to s0: default, smallest and largest admissible value.
  real(wp), parameter, public :: default_arc = 0.05_wp, least_arc = 1.0e-5_wp, largest_arc = 1.0_wp
  !> Length of a branch that counts as endless, relative to s_f, in addition to the change of the prescribed separations
  !> and to that of the springs without the interface.
  real(wp), parameter, public :: endless = 20.0_wp
  !> Largest number of steps to the prescribed values on a straight line, without springs.
  real(wp), parameter :: most_steps = 2.0e5_wp

  !> Progress along the branch of one change of the prescribed values.
  type, public :: arc_type
    real(wp) :: longest = 0.0_wp        !! longest step, length
    real(wp) :: length = 0.0_wp         !! of the next step, length
    real(wp) :: travelled = 0.0_wp      !! length of all steps
    real(wp) :: factor = 0.0_wp         !! load factor, 1: the prescribed values are reached
    real(wp) :: last(4) = 0.0_wp        !! direction of the last step
    integer :: short = 0                !! short steps in succession
    integer :: returns = 0              !! steps that go back on the step before
    integer :: unstable = 0             !! unstable equilibria in succession while the prescribed values advance
    logical :: back = .false.           !! whether the prescribed values go back
    logical :: turned = .false.         !! whether their sense changed in the last step
  end type arc_type

contains

  !> Append why an interface has no branch that can be followed; nothing if it has one. The state at a point of the
  !> branch must not depend on time or on the length of the steps, and must be continuous.
  pure subroutine explain_no_branch(joint, message)
    type(interface_type), intent(in) :: joint                 !! the interface
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended
    if (joint%material%tau_v > 0.0_wp) then
      call append(message, "tau_v = " // to_text(joint%material%tau_v) // ": expected 0, as no time passes on a branch")
    else if (joint%material%wears) then
      call append(message, "W0 = " // to_text(1.0_wp/joint%material%inv_w0) // &
        ": expected 0, as wear depends on the increments")
    else if (joint%material%guard) then
      call append(message, "guard = 1: expected 0, as damage that the guard prevents may grow at once later")
    end if
  end subroutine explain_no_branch

  !> Append why a branch ended before the values that it was to reach.
  pure subroutine explain_end(ended, message)
    integer, intent(in) :: ended                              !! end of the last step, of report_type
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended
    select case (ended)
    case (ended_endless)
      call append(message, "the branch does not reach the prescribed values within a length of " // &
        to_text(endless) // " s_f: the separation grows without end, or farther than that")
    case (ended_rejected)
      call append(message, "the prescribed values are more than " // to_text(most_steps) // &
        " steps of this length away: expected a larger arc, up to " // to_text(largest_arc) // &
        ", or increments (follow = 'stable')")
    case (ended_divided)
      call append(message, "the branch divides, several equilibria continue it: expected a load case without symmetry")
    case default
      call append(message, "the branch ends, no equilibrium was found near its last point in any direction")
    end select
  end subroutine explain_end

  !> Begin a branch; its steps are at most `longest` s0.
  pure function new_arc(joint, longest) result(arc)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: longest             !! relative to s0
    type(arc_type) :: arc
    arc%longest = longest*joint%material%s0
    arc%length = arc%longest
  end function new_arc

  !> Take a step along the branch. The last step ends at the prescribed values, where the load factor is 1.
  !>
  !> The step ends at the first fold in it, so that the rows have the extreme values of the load factor. If the branch
  !> does not continue, the point stays, and the report says why: `ended_divided` if several branches continue,
  !> `ended_endless` if the separation grows without end or too far, `ended_rejected` if the prescribed values are too
  !> far for the length of the steps, else `ended_lost`.
  pure subroutine arc_step(joint, path, arc, point, report)
    type(interface_type), intent(in) :: joint    !! the interface
    type(path_type), intent(in) :: path          !! the prescribed values at the factors 0 and 1
    type(arc_type), intent(inout) :: arc         !! progress
    type(point_type), intent(inout) :: point     !! the point, start -> end
    type(report_type), intent(out) :: report     !! work, and why the branch ended
    !> Shortest step that is tried and step that counts as short, relative to the longest.
    real(wp), parameter :: shortest = 2.0_wp**(-16), short = 2.0_wp**(-8)
    !> Largest number of short steps in succession, and of steps that go back on the step before: a branch with more of
    !> them stays near one point.
    integer, parameter :: most = 200
    type(step_type) :: step
    real(wp) :: length, unit

    arc%turned = .false.
    report%parts = 1
    unit = load_length(joint, path)
    if (unit > most_steps*arc%longest) then
      report%ended = ended_rejected
      return
    end if
    if (.not. unit > 0.0_wp .or. has_no_folds(joint, point)) then
      call push(joint, path, unit, arc, point, report)
      return
    end if
    if (arc%travelled > endless_length(joint, path)) then
      report%ended = ended_endless
      return
    end if
    call begin_step(joint, path, arc%factor, point, step)
    step%last = arc%last
    length = min(arc%length, arc%longest)
    do
      call try(joint, path, length, step, report)
      if (step%good .or. length < shortest*arc%longest) exit
      length = 0.5_wp*length
    end do
    if (.not. step%good) call search(joint, path, arc%longest, step, length, report)
    if (step%good .and. (step%after(step%balance%n + 1) < 0.0_wp .neqv. arc%back)) call find_fold(joint, path, arc, &
      length, step, report)
    if (step%good) call watch_stability(joint, path, length, arc, step, report)
    if (step%good .and. step%to(step%balance%n + 1) >= unit) call find_target(joint, path, arc, unit, length, step, &
      report)
    arc%short = merge(arc%short + 1, 0, length < short*arc%longest)
    if (goes_back(path, step, length)) arc%returns = arc%returns + 1
    if (.not. step%good .or. max(arc%short, arc%returns) > most) then
      if (report%ended == ended_complete) report%ended = ended_lost
      call move_point(step%balance%old, point)
      return
    end if
    arc%last = (step%to - step%from)/length
    arc%turned = step%after(step%balance%n + 1) < 0.0_wp .neqv. arc%back
    ! a fully damaged interface does not carry the tractions of the step
    if (has_no_folds(joint, step%point) .and. any(abs(path%change) > 0.0_wp .and. path%control%traction .and. &
      .not. path%control%spring > 0.0_wp)) arc%turned = .false.
    if (arc%turned) arc%back = .not. arc%back
    arc%travelled = arc%travelled + length
    arc%factor = step%to(step%balance%n + 1)/unit
    if (.not. arc%turned) arc%length = 2.0_wp*length
    call move_point(step%point, point)
  end subroutine arc_step

  !> Length of a branch that counts as endless.
  pure function endless_length(joint, path) result(length)
    type(interface_type), intent(in) :: joint   !! the interface
    type(path_type), intent(in) :: path         !! the prescribed values
    real(wp) :: length
    integer :: i
    length = endless*joint%material%s0/(1.0_wp - joint%material%eta) + load_length(joint, path)
    do i = 1, 3
      if (path%control%spring(i) > 0.0_wp) length = length + abs(path%change(i))/path%control%spring(i)
    end do
  end function endless_length

  !> Move on by `advance`. If there is no equilibrium, the prescribed tractions move the sides apart or along each other
  !> without end. Sliding planes and soft springs may move farther than an elastic interface, so the step is halved.
  pure subroutine push(joint, path, unit, arc, point, report)
    type(interface_type), intent(in) :: joint    !! the interface
    type(path_type), intent(in) :: path          !! the prescribed values
    real(wp), intent(in) :: unit                 !! length of a unit of the load factor
    type(arc_type), intent(inout) :: arc         !! progress
    type(point_type), intent(inout) :: point     !! the point, start -> end
    type(report_type), intent(out) :: report     !! work, and why the branch ended
    !> Longest motion in a step, and shortest step that is tried: only a snap moves farther in it. Both relative to the
    !> longest step.
    real(wp), parameter :: farthest = 4.0_wp, shortest = 2.0_wp**(-10)
    type(point_type) :: trial
    real(wp) :: length, next, reached
    integer :: iterations, updates, wasted
    length = min(arc%longest, unit)
    wasted = 0
    updates = 0
    do
      next = 1.0_wp
      if (unit > 0.0_wp) next = min(1.0_wp, arc%factor + length/unit)
      trial = point
      call advance(joint, path%control, path%start + arc%factor*path%change, &
        merge(path%target, path%start + next*path%change, next >= 1.0_wp), trial, iterations, reached, report)
      if (sqrt(sum((trial%s - point%s)**2)) <= farthest*arc%longest .or. .not. length > shortest*arc%longest) exit
      wasted = wasted + report%iterations
      updates = updates + report%updates
      length = 0.5_wp*length
    end do
    report%iterations = report%iterations + wasted
    report%updates = report%updates + updates
    call move_point(trial, point)
    if (reached < 1.0_wp) then
      arc%factor = arc%factor + reached*(next - arc%factor)
      report%ended = ended_endless
      return
    end if
    arc%turned = arc%back
    arc%back = .false.
    arc%factor = next
    arc%last = 0.0_wp
  end subroutine push

  !> Look for other branches where stability is lost without a fold: two eigenvalues have changed their sign at once,
  !> which the determinant does not show.
  pure subroutine watch_stability(joint, path, length, arc, step, report)
    type(interface_type), intent(in) :: joint    !! the interface
    type(path_type), intent(in) :: path          !! the prescribed values
    real(wp), intent(in) :: length               !! of the step
    type(arc_type), intent(inout) :: arc         !! progress
    type(step_type), intent(inout) :: step       !! the step
    type(report_type), intent(inout) :: report   !! work, and whether several branches continue
    !> Equilibria after the loss of stability at which other branches are looked for.
    integer, parameter :: looks = 8
    real(wp) :: matrix(3, 3)
    ! flang 16 does not compile a call with this matrix as an expression
    matrix = free_matrix(step%balance, step%point)
    if (step%after(step%balance%n + 1) >= 0.0_wp .and. unstable(step%balance%n, matrix, elastic_stiffness(joint))) then
      arc%unstable = arc%unstable + 1
      if (arc%unstable <= looks) call look(joint, path, length, step, report)
    else
      arc%unstable = 0
    end if
  end subroutine watch_stability

  !> Shorten a step to the first fold in it.
  pure subroutine find_fold(joint, path, arc, length, step, report)
    type(interface_type), intent(in) :: joint    !! the interface
    type(path_type), intent(in) :: path          !! the prescribed values
    type(arc_type), intent(in) :: arc            !! progress
    real(wp), intent(inout) :: length            !! of the step
    type(step_type), intent(inout) :: step       !! the step
    type(report_type), intent(inout) :: report   !! work
    !> Bisections of the step. The error of the load factor at a smooth fold is of the order of the square of the last
    !> length.
    integer, parameter :: halvings = 12
    real(wp) :: before, direction(4), middle
    integer :: i
    before = 0.0_wp
    direction = (step%to - step%from)/length
    do i = 1, halvings
      middle = 0.5_wp*(before + length)
      call solve(joint, path, middle, direction, .false., step, report)
      if (step%good .and. (step%after(step%balance%n + 1) < 0.0_wp .neqv. arc%back)) then
        length = middle
        direction = (step%to - step%from)/length
      else
        before = middle
      end if
    end do
    call solve(joint, path, length, direction, .false., step, report)
  end subroutine find_fold

  !> Shorten a step to the load factor 1.
  pure subroutine find_target(joint, path, arc, unit, length, step, report)
    type(interface_type), intent(in) :: joint    !! the interface
    type(path_type), intent(in) :: path          !! the prescribed values
    type(arc_type), intent(in) :: arc            !! progress
    real(wp), intent(in) :: unit                 !! length of a unit of the load factor
    real(wp), intent(inout) :: length            !! of the step
    type(step_type), intent(inout) :: step       !! the step
    type(report_type), intent(inout) :: report   !! work
    type(newton_type) :: result
    type(point_type) :: target
    real(wp) :: change(4), guess(4)
    integer :: n
    n = step%balance%n
    guess = step%from + (step%to - step%from)*((unit - step%from(n + 1))/(step%to(n + 1) - step%from(n + 1)))
    call set_share(joint, path, 1.0_wp, arc%factor, step%balance)
    associate (free => step%balance%free(:n))
      target%s(free) = guess(:n)
    end associate
    call newton_solve(joint, step%balance, .false., target, result)
    report%iterations = report%iterations + result%iterations
    report%updates = report%updates + result%updates
    change = 0.0_wp
    change(:3) = free_part(step%balance, target%s)
    change(n + 1) = unit
    step%good = result%converged .and. sqrt(sum((change - guess)**2)) <= length
    if (.not. step%good) return
    change = change - step%from
    step%after = branch_tangent(joint, path, step%balance, target)
    step%good = has_no_folds(joint, target) .or. length_product(path, change, step%after) > 0.0_wp
    if (.not. step%good) return
    length = sqrt(length_product(path, change, change))
    step%to = step%from + change
    step%to(n + 1) = unit
    call move_point(target, step%point)
  end subroutine find_target

end module asperity_arc
