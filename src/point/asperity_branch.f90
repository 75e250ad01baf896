!> A branch of equilibria, followed through its unstable part by local parametrisation: of the free separations and the
!> load factor, the one that changes most is prescribed in a step.
!>
!> Every step is an update of the law from the last equilibrium. The prescribed values depend on a load factor, which
!> may decrease: at a fold they turn back, where the stable path would snap. Where another branch crosses, at a fork,
!> either may be followed.
module asperity_branch
  use asperity_branch_step, only: find_fold, find_fork, leave, null_vector, search, solve, step_type
  use asperity_equations, only: equations_type, evaluate, is_unstiff, new_equations, ramp
  use asperity_kinds, only: wp
  use asperity_null_space, only: null_space_type
  use asperity_increment, only: advance, call_type, control_type, ended_complete, ended_endless, ended_lost, &
    ended_refused, ended_rejected, point_type, report_type
  use asperity_point_law, only: point_law
  use asperity_tolerances, only: endless, longest_push, most_branch_steps, most_halvings, shortest_branch_step, &
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
    logical :: left = .false.           !! whether the branch was left at a fork
    real(wp) :: orientation = 0.0_wp    !! sign of the equations at the last point, which a fork changes; 0: not known
    real(wp) :: aside(4) = 0.0_wp       !! direction in which the next step leaves the branch; zero: it stays
  end type branch_type

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
    branch%longest = arc*law%s_0
    branch%length = branch%longest
    branch%remaining = endless*law%s_f + branch%unit + springs
    branch%sense(4) = 1.0_wp
    branch%fork = fork
  end function new_branch

  !> Take a step along the branch. The last step ends at the prescribed values, where the load factor is 1.
  !>
  !> A step ends at the first fold in it, so that the rows have the extreme values of the load factor. If the branch
  !> does not continue, the point stays, and the report says why: `ended_endless` if the separation grows without end,
  !> `ended_rejected` if the prescribed values are too far for the length of the steps, `ended_refused` if the law asks
  !> for less than a step, else `ended_lost`.
  subroutine branch_step(law, branch, point, report, calls)
    class(point_law), intent(in) :: law               !! the law
    type(branch_type), intent(inout) :: branch        !! progress
    type(point_type), intent(inout) :: point          !! the point, start -> end
    type(report_type), intent(out) :: report          !! work, and why the branch ended
    type(call_type), intent(inout), optional :: calls   !! place in a load path; attempts are counted; absent: in none
    type(call_type) :: place
    type(equations_type) :: equations
    type(step_type) :: step
    type(null_space_type) :: null
    real(wp) :: ahead(4), change(4), error, r(3)
    logical :: along_tangent, turns

    branch%turned = .false.
    branch%forked = .false.
    if (branch%unit > most_branch_steps*branch%longest .or. branch%steps > int(most_branch_steps)) then
      report%ended = ended_rejected
      return
    else if (.not. branch%unit > 0.0_wp .or. .not. any(branch%control%traction) .or. is_unstiff(point) .or. &
      law%cannot_soften(point%state)) then
      call advance_factor(law, branch, point, report, calls)
      return
    else if (branch%remaining < 0.0_wp) then
      report%ended = ended_endless
      return
    end if
    step%unit = branch%unit
    step%from = [merge(point%s, 0.0_wp, branch%control%traction), branch%factor*branch%unit]
    if (present(calls)) then
      calls%attempt = calls%attempt + 1
      place = calls
    end if
    call new_equations(branch%control, branch%from, branch%to, point, equations, place)
    ! The tangent at the start of an update is that of a state that loads no further: it is taken a little farther.
    ahead = step%from + tangent_distance*law%s_0*branch%sense
    call evaluate(law, equations, ahead(:3), ahead(4)/step%unit, step%point, r, error)
    if (error < huge(error)) then
      null = null_vector(law, equations, step, branch%sense)
      step%direction = null%direction
      if (.not. abs(branch%orientation) > 0.0_wp) branch%orientation = null%sense
    end if
    step%length = branch%length
    if (any(abs(branch%aside) > 0.0_wp)) call leave(law, equations, branch%longest, branch%aside, step)
    branch%left = branch%left .or. step%good
    if (step%good) branch%orientation = step%orientation
    do while (step%length >= shortest_branch_step*branch%longest .and. .not. step%good)
      if (any(abs(step%direction) > 0.0_wp)) call solve(law, equations, step)
      if (step%good) exit
      step%length = 0.5_wp*step%length
    end do
    along_tangent = step%good
    if (.not. along_tangent) call search(law, equations, branch%searched, branch%sense, step)
    branch%searched = .not. along_tangent
    turns = step%good .and. step%direction(4)*step%ending(4) < 0.0_wp
    if (turns) call find_fold(law, equations, step)
    branch%forked = step%good .and. step%orientation*branch%orientation < 0.0_wp
    if (branch%forked .and. along_tangent) call find_fork(law, equations, branch%orientation, step)
    report = equations%report
    report%parts = 1
    if (report%requested < 1.0_wp .or. .not. step%good) then
      report%ended = merge(ended_refused, ended_lost, report%requested < 1.0_wp)
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
    if (branch%forked) branch%forked = is_crossed(law, branch, point, step%second, place)
    if (branch%forked .and. branch%fork /= 0) then
      branch%aside = real(branch%fork, wp)*step%second
      branch%fork = 0
    end if
    if (abs(step%orientation) > 0.0_wp) branch%orientation = step%orientation
    branch%steps = branch%steps + 1
    branch%remaining = branch%remaining - norm2(change)
    branch%length = min(branch%longest, 2.0_wp*step%length)
  end subroutine branch_step

  !> Whether another branch crosses at a point where the sign of the equations has changed: at a kink it may change
  !> although none does.
  function is_crossed(law, branch, point, aside, place) result(yes)
    class(point_law), intent(in) :: law         !! the law
    type(branch_type), intent(in) :: branch     !! progress
    type(point_type), intent(in) :: point       !! the point
    real(wp), intent(in) :: aside(4)            !! direction of the other branch
    type(call_type), intent(in) :: place        !! in a load path
    logical :: yes
    type(equations_type) :: equations
    type(step_type) :: step
    call new_equations(branch%control, branch%from, branch%to, point, equations, place)
    step%unit = branch%unit
    step%from = [merge(point%s, 0.0_wp, branch%control%traction), branch%factor*branch%unit]
    call leave(law, equations, branch%longest, aside, step)
    yes = step%good
    if (yes) return
    call leave(law, equations, branch%longest, -aside, step)
    yes = step%good
  end function is_crossed

  !> Where nothing can soften, or an open joint carries nothing, the branch is the stable path: the prescribed values
  !> advance by a step in which the separations change by a few s0.
  subroutine advance_factor(law, branch, point, report, calls)
    class(point_law), intent(in) :: law               !! the law
    type(branch_type), intent(inout) :: branch        !! progress
    type(point_type), intent(inout) :: point          !! the point, start -> end
    type(report_type), intent(out) :: report          !! report
    type(call_type), intent(inout), optional :: calls   !! place in a load path; attempts are counted
    type(point_type) :: trial
    real(wp) :: next, reached, step
    integer :: i
    step = 1.0_wp
    if (branch%unit > 0.0_wp) step = branch%longest/branch%unit
    do i = 1, most_halvings
      next = min(1.0_wp, branch%factor + step)
      trial = point
      call advance(law, branch%control, ramp(branch%from, branch%to, branch%factor), ramp(branch%from, branch%to, &
        next), trial, reached, report, calls)
      if (report%ended == ended_refused) return
      if (norm2(trial%s - point%s) <= longest_push*law%s_0) exit
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

end module asperity_branch
