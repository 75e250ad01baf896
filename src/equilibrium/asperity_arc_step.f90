!> A step of given length along a branch of equilibria: candidates, and the choice of the one that continues the branch.
module asperity_arc_step
  use asperity_arc_equations, only: branch_tangent, correct, length_product, load_length, set_factor
  use asperity_contract, only: plane_statev
  use asperity_control_point, only: balance_type, energy_defect, free_part, move_point, point_type
  use asperity_increment, only: path_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: ended_complete, ended_divided, report_type
  use asperity_snap_motion, only: cannot_soften
  use asperity_tolerances, only: snap_resolution, unbalanced_motion
  implicit none
  private
  public :: begin_step, try, solve, search, look, has_no_folds, goes_back

  !> A step that is tried: equations with the point at its start, and the point at its end.
  type, public :: step_type
    type(balance_type) :: balance
    type(point_type) :: point
    real(wp) :: from(4) = 0.0_wp        !! (x, m) at its start
    real(wp) :: to(4) = 0.0_wp          !! at its end
    real(wp) :: last(4) = 0.0_wp        !! direction of the last step, zero: none
    real(wp) :: before(4) = 0.0_wp      !! direction of the branch at its start
    real(wp) :: after(4) = 0.0_wp       !! at its end
    logical :: good = .false.           !! whether the end continues the branch
  end type step_type

contains

  !> Whether the branch has no more folds, so that `advance` follows it: the planes are fully damaged and cannot soften,
  !> or they carry nothing except for rounding errors. Every separation that opens them may then be an equilibrium, too,
  !> and the branch has no direction of its own.
  pure function has_no_folds(joint, point) result(yes)
    type(interface_type), intent(in) :: joint   !! the interface
    type(point_type), intent(in) :: point       !! the point
    logical :: yes
    !> Largest traction, relative to the strength.
    real(wp), parameter :: no_traction = 1.0e-9_wp
    integer :: k
    yes = cannot_soften(joint, point)
    if (yes) return
    yes = all(abs(point%traction) <= no_traction*joint%material%k_n*joint%material%s0)
    do k = 1, joint%pattern%n
      yes = yes .and. point%state(plane_statev(k)) >= 1.0_wp
    end do
  end function has_no_folds

  !> Set the start of a step.
  pure subroutine begin_step(joint, path, factor, point, step)
    type(interface_type), intent(in) :: joint    !! the interface
    type(path_type), intent(in) :: path          !! the prescribed values
    real(wp), intent(in) :: factor               !! load factor there
    type(point_type), intent(inout) :: point     !! the point at the start -> undefined
    type(step_type), intent(inout) :: step       !! the step
    call move_point(point, step%balance%old)
    call set_factor(joint, path, factor, step%balance)
    step%from(:3) = free_part(step%balance, step%balance%old%s)
    step%from(step%balance%n + 1) = factor*load_length(joint, path)
    step%before = branch_tangent(joint, path, step%balance, step%balance%old)
  end subroutine begin_step

  !> Try a step of a given length: in the direction of the branch at its start, in that of the last step.
  pure subroutine try(joint, path, length, step, report)
    type(interface_type), intent(in) :: joint    !! the interface
    type(path_type), intent(in) :: path          !! the prescribed values
    real(wp), intent(in) :: length               !! of the step
    type(step_type), intent(inout) :: step       !! the step
    type(report_type), intent(inout) :: report   !! work
    step%good = .false.
    if (any(abs(step%before) > 0.0_wp)) call solve(joint, path, length, step%before, .false., step, report)
    if (.not. step%good .and. any(abs(step%last) > 0.0_wp)) call solve(joint, path, length, step%last, .false., step, &
      report)
  end subroutine try

  !> Solve for a step of a given length from a guess of its direction, and judge whether it continues the branch.
  pure subroutine solve(joint, path, length, direction, turns, step, report)
    type(interface_type), intent(in) :: joint    !! the interface
    type(path_type), intent(in) :: path          !! the prescribed values
    real(wp), intent(in) :: length               !! of the step
    real(wp), intent(in) :: direction(4)         !! unit vector (x, m)
    logical, intent(in) :: turns                 !! whether the step may leave the direction of the branch
    type(step_type), intent(inout) :: step       !! the step
    type(report_type), intent(inout) :: report   !! work
    !> Largest distance of the direction of the step from the mean of those of the branch at its ends.
    real(wp), parameter :: straight = 0.1_wp
    !> Step whose energies are not judged, relative to s0: the traction of a facet may change abruptly where its
    !> curvature begins.
    real(wp), parameter :: tiny_step = 1.0e-4_wp
    real(wp) :: change(4), bend(4)
    integer :: iterations
    iterations = 0
    step%to = step%from + length*direction
    call correct(joint, path, length, step%from, step%balance, step%to, step%point, iterations, step%good)
    report%iterations = report%iterations + iterations
    report%updates = report%updates + iterations + 1
    if (.not. step%good) return
    change = (step%to - step%from)/length
    step%after = branch_tangent(joint, path, step%balance, step%point)
    step%good = has_no_folds(joint, step%point) .or. length_product(path, change, step%after) > 0.0_wp
    if (step%good .and. length > tiny_step*joint%material%s0) step%good = energy_defect(joint, step%balance%old, &
      step%point) <= unbalanced_motion*min(1.0_wp, length/joint%material%s0)
    if (.not. step%good .or. turns .or. length <= snap_resolution*joint%material%s0) return
    bend = change - 0.5_wp*(step%before + step%after)
    step%good = length_product(path, bend, bend) <= straight**2
  end subroutine solve

  !> Search all directions where the step that the tangents predict does not continue the branch: at a kink, the branch
  !> may turn sharply.
  !>
  !> The longest distance is tried first. At a distance that is not much longer than that to the kink, the irreversible
  !> law may have more equilibria, which belong to no branch. If several branches continue at every distance, none of
  !> them is taken.
  pure subroutine search(joint, path, longest, step, length, report)
    type(interface_type), intent(in) :: joint    !! the interface
    type(path_type), intent(in) :: path          !! the prescribed values
    real(wp), intent(in) :: longest              !! longest step
    type(step_type), intent(inout) :: step       !! the step
    real(wp), intent(inout) :: length            !! of the step
    type(report_type), intent(inout) :: report   !! work, and whether several branches continue
    !> Lengths that are tried, as fractions of the longest of them.
    real(wp), parameter :: lengths(4) = [1.0_wp, 2.0_wp**(-4), 2.0_wp**(-8), 2.0_wp**(-12)]
    integer :: ended, i
    ended = ended_complete
    do i = 1, size(lengths)
      length = lengths(i)*min(longest, snap_resolution*joint%material%s0)
      report%ended = ended_complete
      call look(joint, path, length, step, report)
      if (step%good) return
      if (report%ended /= ended_complete) ended = report%ended
    end do
    report%ended = ended
  end subroutine search

  !> Look for equilibria at a given distance in all directions. If exactly one continues the branch, it is the step. One
  !> that goes back on the last step is the step if there is no other.
  pure subroutine look(joint, path, length, step, report)
    type(interface_type), intent(in) :: joint    !! the interface
    type(path_type), intent(in) :: path          !! the prescribed values
    real(wp), intent(in) :: length               !! of the step
    type(step_type), intent(inout) :: step       !! the step
    type(report_type), intent(inout) :: report   !! work, and whether several branches continue
    !> Distance of two results that differ, relative to the length of the step.
    real(wp), parameter :: apart = 0.01_wp
    !> Components of the directions, with irregular shares, so that they have no symmetry of the pattern.
    real(wp), parameter :: components(0:4) = [0.0_wp, 0.5_wp, 1.0_wp, -1.0_wp, -0.5_wp]
    real(wp), parameter :: irregular(4) = [0.07_wp, -0.13_wp, 0.19_wp, 0.11_wp]
    real(wp) :: behind(4), difference(4), direction(4), first(4)
    integer :: code, j, n
    logical :: found
    n = step%balance%n
    behind = 0.0_wp
    first = 0.0_wp
    found = .false.
    do code = 0, size(components)**(n + 1) - 1
      ! the digits of the code are the indices of the components
      direction = 0.0_wp
      do j = 1, n + 1
        direction(j) = components(modulo(code/size(components)**(j - 1), size(components))) + irregular(j)
      end do
      direction = direction/sqrt(length_product(path, direction, direction))
      call solve(joint, path, length, direction, .true., step, report)
      if (.not. step%good) cycle
      if (has_no_folds(joint, step%point)) return
      direction = (step%to - step%from)/length
      if (goes_back(path, step, length)) then
        behind = direction
        cycle
      end if
      difference = direction - first
      if (found .and. length_product(path, difference, difference) > apart**2) then
        report%ended = ended_divided
        step%good = .false.
        return
      end if
      found = .true.
      first = direction
    end do
    step%good = .false.
    if (.not. found) first = behind
    if (any(abs(first) > 0.0_wp)) call solve(joint, path, length, first, .true., step, report)
  end subroutine look

  !> Whether a step goes back on the last one.
  pure function goes_back(path, step, length) result(yes)
    type(path_type), intent(in) :: path      !! the prescribed values
    type(step_type), intent(in) :: step      !! the step
    real(wp), intent(in) :: length           !! of the step
    logical :: yes
    !> Product of the directions of the two steps.
    real(wp), parameter :: opposite = -0.99_wp
    yes = length_product(path, step%to - step%from, step%last) < opposite*length
  end function goes_back

end module asperity_arc_step
