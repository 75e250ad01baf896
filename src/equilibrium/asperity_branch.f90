!> Whether a solved step continues the branch of stable equilibria of its start: by the tangents at its ends, and by the
!> balance of its energies, which does not use the tangents.
module asperity_branch
  use asperity_control_point, only: balance_type, elastic_stiffness, energy_defect, evaluate, free_matrix, free_part, &
    move_point, point_type, unstable, whole_separation
  use asperity_elimination, only: eliminate
  use asperity_increment, only: path_type, set_share
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_newton, only: newton_solve, newton_type
  use asperity_snap_motion, only: cannot_soften, farthest_rest
  use asperity_tolerances, only: residual_tolerance, snap_resolution, smallest_share, touch, unbalanced, unexplained, &
    unexplained_share
  implicit none
  private
  public :: continue_branch, settle, balances, find_leap

contains

  !> Take a step along the branch, by Newton's method from the separations at its start. If this gives no equilibrium on
  !> the branch, the method starts from the separations that the tangent at the start of the step predicts: the first
  !> start may open or close a stiff contact under a small pressure. A last step before a fold is also tried from the
  !> closing side, as the tangent at a peak of the traction may be that of the side where the equilibrium is unstable.
  pure subroutine continue_branch(joint, balance, change, here, last, trial, good, iterations, updates)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! equations of the step
    real(wp), intent(in) :: change(3)               !! of the given values in the step
    type(point_type), intent(in) :: here            !! separation and tangent at its start
    logical, intent(in) :: last                     !! whether a fold follows if the step fails
    type(point_type), intent(inout) :: trial        !! -> the point at its end
    logical, intent(out) :: good                    !! whether there is one on the branch
    integer, intent(inout) :: iterations            !! tangent solves, increased
    integer, intent(inout) :: updates               !! of the law, increased
    type(newton_type) :: result
    real(wp) :: matrix(3, 3), predicted(3), work(3, 3)
    logical :: solved
    integer :: start
    do start = 1, merge(3, 2, last .and. balance%control%traction(1))
      trial%s = here%s
      if (start == 2) then
        matrix = free_matrix(balance, here)
        work = matrix
        predicted = free_part(balance, change - matmul(here%tangent, merge(0.0_wp, change, balance%control%traction)))
        call eliminate(balance%n, work, predicted, solved)
        if (.not. solved) predicted = 0.0_wp
        if (.not. solved) cycle
        associate (free => balance%free(:balance%n))
          trial%s(free) = here%s(free) + predicted(:balance%n)
        end associate
      else if (start == 3) then
        trial%s(1) = trial%s(1) - touch*joint%material%s0
      end if
      call newton_solve(joint, balance, .true., trial, result)
      iterations = iterations + result%iterations
      updates = updates + result%updates
      if (start > 1) then
        result%first = matrix
        result%step = predicted
      end if
      good = result%converged
      if (good) call check_branch(joint, balance, result, change, here%s, last, trial, good, updates)
      if (good) return
    end do
    good = .false.
  end subroutine continue_branch

  !> Whether a converged step continues the branch of its start.
  !>
  !> The step continues the branch if the equilibria at both ends are stable and if the step agrees with the mean of the
  !> predictions by both tangents within `unexplained`. If the tangents differ much, the tangents on the straight line
  !> between the ends must be stable, too; with one free separation, no other equilibrium may lie on that line. Steps
  !> below `snap_resolution`*s0, smallest steps that are prescribed to be longer, and steps from states that cannot
  !> soften, are accepted without this test.
  pure subroutine check_branch(joint, balance, result, change, origin, last, point, good, updates)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! equations of the step
    type(newton_type), intent(in) :: result         !! of Newton's method
    real(wp), intent(in) :: change(3)               !! of the given values in the step
    real(wp), intent(in) :: origin(3)               !! separation at the start of the step, length
    logical, intent(in) :: last                     !! whether it is the smallest step
    type(point_type), intent(in) :: point           !! at the end of the step
    logical, intent(out) :: good                    !! whether the step continues the branch
    integer, intent(inout) :: updates               !! of the law
    !> Change of the tangent, relative to the first one, below which Newton's method is certain to stay on the branch:
    !> half of Kantorovich's bound.
    real(wp), parameter :: half = 0.5_wp
    !> Test points on the line between the ends: smallest and largest number, and their distance as a fraction of s0.
    integer, parameter :: least_looks = 7, most_looks = 63
    real(wp), parameter :: distance = 1.0_wp/16.0_wp
    type(point_type) :: between
    real(wp) :: ending(3), extent, from(3), matrix(3, 3), move(3), r(3), r_first, s0, scale, stiffness, x(3)
    integer :: i, k, looks, n
    logical :: solved

    n = balance%n
    good = .true.
    if (n == 0) return
    stiffness = elastic_stiffness(joint)
    s0 = joint%material%s0
    from = free_part(balance, origin)
    move = free_part(balance, point%s) - from
    good = .not. unstable(n, result%last, stiffness) .and. maxval(abs(point%s)) <= farthest_rest(joint, balance)
    if (.not. good .or. maxval(abs(move)) <= snap_resolution*s0) return
    good = result%stable
    if (.not. good) return
    if (last .and. elastic_length(joint, balance, change) > snap_resolution*s0) return
    if (cannot_soften(joint, balance%old)) return
    ! the step that the tangent at the end predicts
    ending = free_part(balance, change - matmul(point%tangent, merge(0.0_wp, change, balance%control%traction)))
    matrix = result%last
    call eliminate(n, matrix, ending, good)
    ! with viscous damage no plane is ever fully damaged: the tolerance grows with the separation
    extent = s0
    if (joint%material%tau_v > 0.0_wp .and. balance%control%dt > 0.0_wp) extent = max(s0, &
      maxval(abs(whole_separation(origin, point%state)), mask=balance%control%traction))
    if (good) good = maxval(abs(move - 0.5_wp*(result%step + ending))) <= max(unexplained*extent, &
      unexplained_share*elastic_length(joint, balance, change))
    if (.not. good) return
    solved = .false.
    do k = 1, n
      matrix = result%first
      x = result%last(:, k) - result%first(:, k)
      call eliminate(n, matrix, x, solved)
      if (solved) solved = sum(abs(x)) <= half
      if (.not. solved) exit
    end do
    if (solved) return
    looks = max(least_looks, min(most_looks, ceiling(maxval(abs(move))/(distance*s0))))
    r_first = 0.0_wp
    do i = 0, looks
      updates = updates + 1
      x = from + (real(i, wp)/real(looks + 1, wp))*move
      call evaluate(joint, balance, x, between, r, scale, good)
      if (.not. good) return
      if (i == 0) r_first = r(1)
      good = .not. unstable(n, free_matrix(balance, between), stiffness)
      if (n == 1) good = good .and. r(1)*r_first >= 0.0_wp
      if (.not. good) return
    end do
  end subroutine check_branch

  !> Follow the wear of a sub-increment to the equilibrium of the facets as they are worn in it, under the given values
  !> at its start: the work of the increments before wears the facets at once, which moves the equilibrium before the
  !> given values change. They are approached from the values that the worn facets carry at the separation of the start.
  !> The point does not change if this branch ends before.
  pure subroutine settle(joint, balance, most, here, iterations, updates)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! equations at the start of the sub-increment
    integer, intent(in) :: most                     !! largest number of updates
    type(point_type), intent(inout) :: here         !! separation and tangent at the start -> with the wear
    integer, intent(inout) :: iterations            !! tangent solves, increased
    integer, intent(inout) :: updates               !! of the law, increased
    type(balance_type) :: between
    type(point_type) :: at, trial
    real(wp) :: carried(3), change(3), next, r(3), scale, share, step
    logical :: good
    if (balance%n == 0) return
    updates = updates + 1
    call evaluate(joint, balance, free_part(balance, here%s), at, r, scale, good)
    if (.not. good .or. maxval(abs(r)) <= residual_tolerance*scale) return
    change = 0.0_wp
    associate (free => balance%free(:balance%n))
      change(free) = -r(:balance%n)
    end associate
    carried = balance%given - change
    between = balance
    share = 0.0_wp
    step = 1.0_wp
    do while (share < 1.0_wp .and. step >= smallest_share .and. updates < most)
      next = min(1.0_wp, share + step)
      between%given = carried + next*change
      if (next >= 1.0_wp) between%given = balance%given
      call continue_branch(joint, between, (next - share)*change, at, .false., trial, good, iterations, updates)
      if (good) then
        call move_point(trial, at)
        share = next
        step = 2.0_wp*step
      else
        step = 0.5_wp*min(step, 1.0_wp - share)
      end if
    end do
    if (share >= 1.0_wp) call move_point(at, here)
  end subroutine settle

  !> Whether the energies of a sub-increment balance within `unbalanced`: the work of the traction is stored or
  !> dissipated, except for the error of the trapezoidal rule. A jump to another branch breaks the balance by the energy
  !> that it releases. A state that cannot soften has no other branch, and with viscous damage a jump takes time. An
  !> increment whose smallest step is longer than the smallest snap is too coarse to be judged.
  pure function balances(joint, path, balance, point) result(yes)
    type(interface_type), intent(in) :: joint       !! the interface
    type(path_type), intent(in) :: path             !! the increment
    type(balance_type), intent(in) :: balance       !! equations of the sub-increment, the point at its start
    type(point_type), intent(in) :: point           !! the point at its end
    logical :: yes
    yes = balance%n == 0 .or. joint%material%wears .or. &
      (joint%material%tau_v > 0.0_wp .and. balance%control%dt > 0.0_wp)
    if (.not. yes) yes = energy_defect(joint, balance%old, point) <= unbalanced
    if (.not. yes) yes = cannot_soften(joint, balance%old)
    if (.not. yes) yes = smallest_share*elastic_length(joint, balance, path%change) > &
      snap_resolution*joint%material%s0
  end function balances

  !> Largest change of the given values, as a separation of an elastic plane, length.
  pure function elastic_length(joint, balance, change) result(length)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! what is given
    real(wp), intent(in) :: change(3)               !! of the given values
    real(wp) :: length
    length = maxval(abs(change)/merge(elastic_stiffness(joint), 1.0_wp, balance%control%traction))
  end function elastic_length

  !> Find the jump to another branch in a sub-increment whose energies do not balance.
  !>
  !> The sub-increment is divided into steps whose energies balance and that continue the branch. A jump is where even
  !> the smallest one does not, or has no solution. Without a jump the error was that of the trapezoidal rule over the
  !> whole sub-increment.
  pure subroutine find_leap(joint, path, from, to, point, share, found, iterations, updates, most)
    type(interface_type), intent(in) :: joint       !! the interface
    type(path_type), intent(in) :: path             !! the increment
    real(wp), intent(in) :: from, to                !! the sub-increment, as fractions of it
    type(point_type), intent(inout) :: point        !! the point at its start -> before the jump
    real(wp), intent(out) :: share                  !! fraction of the increment before the jump
    logical, intent(out) :: found                   !! whether there is a jump
    integer, intent(inout) :: iterations            !! tangent solves, increased
    integer, intent(inout) :: updates               !! of the law, increased
    integer, intent(in) :: most                     !! largest number of updates
    type(balance_type) :: balance
    type(point_type) :: trial
    real(wp) :: next, step
    logical :: good
    balance%old = point
    share = from
    step = 0.5_wp*(to - from)
    do while (share < to .and. step >= smallest_share .and. updates < most)
      next = min(to, share + step)
      call set_share(joint, path, next, share, balance)
      call continue_branch(joint, balance, (next - share)*path%change, balance%old, step < 2.0_wp*smallest_share, &
        trial, good, iterations, updates)
      if (good) good = balances(joint, path, balance, trial)
      if (good) then
        call move_point(trial, balance%old)
        share = next
        step = 2.0_wp*step
      else
        step = 0.5_wp*min(step, to - share)
      end if
    end do
    found = share < to
    call move_point(balance%old, point)
  end subroutine find_leap

end module asperity_branch
