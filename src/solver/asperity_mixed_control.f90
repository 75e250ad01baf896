!> One increment of a point under mixed control: for each component either the separation or the traction is prescribed.
!>
!> The increment follows its curve of equilibria. Where the curve ends, a motion leads to the next equilibrium: a snap
!> (docs/solver.md).
module asperity_mixed_control
  use asperity_checks, only: all_bounded
  use asperity_control_point, only: control_type, equations_type, evaluate, is_unstiff, move_point, new_equations, &
    new_point, point_type, values_at
  use asperity_follow, only: follow
  use asperity_kinds, only: wp
  use asperity_point_law, only: point_law
  use asperity_snap, only: snap
  use asperity_tolerances, only: largest_target, least_rupture, most_updates, smallest_share, snap_resolution
  implicit none
  private
  public :: control_type, point_type, new_point, advance, advance_equations

  !> End of an increment: complete, no equilibrium found, limit of updates reached, start or targets out of range; of a
  !> branch (module asperity_branch): without end.
  integer, parameter, public :: ended_complete = 0, ended_lost = 1, ended_limit = 2, ended_rejected = 3, &
    ended_endless = 4

  !> Report of an increment.
  type, public :: report_type
    integer :: ended = ended_complete
    integer :: iterations = 0            !! tangent solves
    integer :: updates = 0               !! of the law
    integer :: parts = 0                 !! updates that were committed, 1 without snaps
    integer :: snaps = 0                 !! jumps from one branch to another
    real(wp) :: before(3) = 0.0_wp       !! separation (N, Tx, Ty) before the longest of them, length
    real(wp) :: after(3) = 0.0_wp        !! separation after it, length
    real(wp) :: released = 0.0_wp        !! energy released by all of them, stress*length
    real(wp) :: beyond(3) = 0.0_wp       !! prescribed values for which no equilibrium was found
  end type report_type

contains

  !> Take a point from the prescribed values `start` to `target`.
  !>
  !> As long as the curve of equilibria continues, the increment is one update from the state at its start. Where it
  !> ends, the point moves under constant values to the first stable equilibrium, from which a further curve is
  !> followed. If there is none, the point stays at the last equilibrium, and `reached` is below 1.
  pure subroutine advance(law, control, start, target, point, reached, report)
    class(point_law), intent(in) :: law             !! the law
    type(control_type), intent(in) :: control       !! what is prescribed
    real(wp), intent(in) :: start(3)                !! values at the start: separation or traction + spring*separation
    real(wp), intent(in) :: target(3)               !! values at the end
    type(point_type), intent(inout) :: point        !! the point, start -> end
    real(wp), intent(out) :: reached                !! share of the increment that converged, 1: complete
    type(report_type), intent(out) :: report        !! report
    type(equations_type) :: equations
    reached = 0.0_wp
    if (.not. (all_bounded(size(target), target, largest_target) .and. law%admissible(point%state))) then
      report%ended = ended_rejected
      return
    end if
    call new_equations(law, control, start, target, equations)
    call move_point(point, equations%old)
    call advance_equations(law, equations, report)
    reached = equations%done
    call move_point(equations%old, point)
  end subroutine advance

  !> The same for given equations; the point at `done` -> at the new `done`.
  pure subroutine advance_equations(law, equations, report)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the increment
    type(report_type), intent(inout) :: report          !! report
    type(point_type) :: before, here
    real(wp) :: share, spent(2)
    logical :: found
    equations%moved = maxval(abs(equations%old%s))
    do
      here%s = equations%old%s
      spent = law%energies(equations%old%state)
      here%tangent = equations%old%tangent
      call follow(law, equations, here, share)
      if (share > equations%done) then
        call move_point(here, equations%old)
        equations%done = share
        report%parts = report%parts + 1
        call close_opening(law, equations, spent(2), report)
      end if
      if (equations%done >= 1.0_wp) exit
      ! the fold lies within the smallest step; just beyond it two equilibria may be too close to be told apart
      before = equations%old
      equations%done = min(1.0_wp, equations%done + 2.0_wp*smallest_share)
      report%beyond = values_at(equations, equations%done)
      found = equations%n > 0 .and. equations%updates < most_updates
      if (found) call snap(law, equations, found)
      if (.not. found) then
        report%ended = merge(ended_limit, ended_lost, equations%updates >= most_updates)
        call move_point(before, equations%old)
        equations%done = share
        exit
      end if
      report%parts = report%parts + 1
      call note_snap(law, equations, before, report)
      if (equations%done >= 1.0_wp) exit
    end do
    report%iterations = report%iterations + equations%iterations
    report%updates = report%updates + equations%updates
  end subroutine advance_equations

  !> Report a motion if it was long enough to be a snap.
  pure subroutine note_snap(law, equations, before, report)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the point after the motion
    type(point_type), intent(in) :: before          !! the point before it
    type(report_type), intent(inout) :: report      !! report
    real(wp) :: length, work(3)
    associate (after => equations%old, control => equations%control)
      length = maxval(abs(after%s - before%s), mask=control%traction)
      if (length <= snap_resolution*law%length) return
      report%snaps = report%snaps + 1
      ! work of the prescribed tractions less that on the springs and the energy stored and dissipated (docs/solver.md)
      work = (values_at(equations, equations%done) - 0.5_wp*control%spring*(before%s + after%s))*(after%s - before%s)
      report%released = report%released + sum(work, mask=control%traction) - &
        sum(law%energies(after%state) - law%energies(before%state))
      if (length > maxval(abs(report%after - report%before))) then
        report%before = before%s
        report%after = after%s
      end if
    end associate
  end subroutine note_snap

  !> If every plane is open and fully damaged and t_N alone is prescribed, every larger opening is an equilibrium, too.
  !> In that case move to the equilibrium with the smallest |s_N|. That is a snap if the joint has just broken.
  pure subroutine close_opening(law, equations, spent, report)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the increment and its point
    real(wp), intent(in) :: spent                       !! energy dissipated before, stress*length
    type(report_type), intent(inout) :: report          !! report
    type(equations_type) :: still
    type(point_type) :: before, trial
    real(wp) :: edge(3), energy(2), r(3), scale, step
    logical :: good
    if (equations%n /= 1 .or. .not. equations%control%traction(1)) return
    if (equations%control%spring(1) > 0.0_wp .or. .not. is_unstiff(equations%old)) return
    call new_equations(law, equations%control, equations%start, equations%target, still)
    still%done = equations%done
    still%old = equations%old
    edge = law%contact_opening(equations%old%s, equations%old%state)
    step = spacing(max(abs(edge(1)), law%length))
    do
      call evaluate(law, still, edge, still%done, trial, r, scale, good)
      equations%updates = equations%updates + 1
      ! the comparison is exact, as every plane is fully damaged and open
      if (.not. good .or. .not. abs(trial%traction(1)) > 0.0_wp) exit
      edge(1) = edge(1) + step
      step = 2.0_wp*step
    end do
    if (.not. good) return
    energy = law%energies(trial%state)
    before = equations%old
    call move_point(trial, equations%old)
    if (energy(2) > spent + least_rupture*law%stress*law%length) call note_snap(law, equations, before, report)
  end subroutine close_opening

end module asperity_mixed_control
