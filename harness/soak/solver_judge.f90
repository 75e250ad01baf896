!> Judge of a row of the solver, independent of its tangents and its tolerances: the increment is divided into smaller
!> and smaller ones, until either every part moves little and its energies balance, or a part of negligible size
!> remains that does not. With wear nothing is judged: the work of an increment wears the facets in the next one, so
!> that a divided increment is another load path.
module solver_judge
  use asperity_contract, only: v_friction, v_rupture, v_stored
  use asperity_equations, only: control_type, point_type
  use asperity_kinds, only: wp
  use asperity_increment, only: advance, report_type
  use asperity_rie_law, only: rie_law
  implicit none
  private
  public :: judge_row

  !> Positions of the stored and the dissipated energies in STATEV.
  integer, parameter :: ledger(3) = [v_stored, v_rupture, v_friction]

  !> Smallest jump of a free separation that counts, relative to s0 and to the separation: where viscous damage has
  !> opened a joint far, its separation is inaccurate. Smallest energy that counts, relative to K s0^2 or, where the
  !> energies do not balance, to their terms. A snap that releases less may belong to the path of smaller increments
  !> alone, and with viscous damage every snap may; a jump that changes no energy leads from one equilibrium without
  !> traction to another.
  real(wp), parameter :: least_jump = 0.1_wp, least_share = 1.0e-3_wp, least_energy = 1.0e-3_wp
  !> Number of halvings.
  integer, parameter :: deepest = 24

  !> Findings.
  type, public :: verdict_type
    real(wp) :: jump = 0.0_wp      !! largest jump of a free separation that is not reported, relative to s0
    real(wp) :: defect = 0.0_wp    !! largest relative energy that does not balance in a part of negligible size
  end type verdict_type

contains

  !> Judge a row.
  subroutine judge_row(law, control, start, target, old, new, snaps, verdict)
    type(rie_law), intent(in) :: law               !! the law
    type(control_type), intent(in) :: control      !! what is given
    real(wp), intent(in) :: start(3), target(3)    !! given values
    type(point_type), intent(in) :: old, new       !! the point at both ends of the row
    integer, intent(in) :: snaps                   !! reported snaps
    type(verdict_type), intent(out) :: verdict     !! findings
    if (law%joint%material%wears) return
    if (moves_far(law, control, old, new, snaps) .or. energy_defect(law, old, new) > least_energy) then
      call examine(law, control, start, target, 0.0_wp, 1.0_wp, old, new, deepest, verdict)
    end if
    if (snaps > 0) verdict%jump = 0.0_wp
  end subroutine judge_row

  !> Examine a part of the increment in two halves, and each half that moves far or does not balance in the same way.
  recursive subroutine examine(law, control, start, target, from, to, old, new, depth, verdict)
    type(rie_law), intent(in) :: law                 !! the law
    type(control_type), intent(in) :: control        !! what is given in the whole increment
    real(wp), intent(in) :: start(3), target(3)      !! given values at its ends
    real(wp), intent(in) :: from, to                 !! the part, as fractions of the increment
    type(point_type), intent(in) :: old, new         !! the point at `from` and, in one increment, at `to`
    integer, intent(in) :: depth                     !! further halvings
    type(verdict_type), intent(inout) :: verdict     !! findings so far
    type(control_type) :: half
    type(point_type) :: last, point
    type(verdict_type) :: found
    type(report_type) :: report
    real(wp) :: defect, ends(3), reached
    logical :: far
    integer :: i

    half = control
    half%dt = 0.5_wp*(to - from)*control%dt
    ends = [from, 0.5_wp*(from + to), to]
    point = old
    associate (m => law%joint%material)
      do i = 1, 2
        last = point
        call advance(law, half, start + ends(i)*(target - start), start + ends(i + 1)*(target - start), point, &
          reached, report)
        ! smaller increments may lose the equilibrium of the row
        if (reached < 1.0_wp) exit
        if (report%released > least_energy*m%k_n*m%s0**2 .and. .not. (m%tau_v > 0.0_wp .or. m%damps)) then
          found%jump = max(found%jump, maxval(abs(report%after - report%before))/m%s0)
        end if
        far = moves_far(law, control, last, point, report%snaps)
        defect = energy_defect(law, last, point)
        if (depth > 0 .and. (far .or. defect > least_energy)) then
          call examine(law, control, start, target, ends(i), ends(i + 1), last, point, depth - 1, found)
        else
          far = far .and. maxval(abs(point%state(ledger) - last%state(ledger))) > least_energy*m%k_n*m%s0**2
          if (far) found%jump = max(found%jump, move_between(control, last, point)/m%s0)
          if (defect > least_energy) found%defect = max(found%defect, defect)
        end if
      end do
      ! the guard judges a whole increment: smaller ones may jump where this one, which ends elsewhere, does not
      if (m%guard .and. 2.0_wp*move_between(control, point, new) > found%jump*m%s0) found%jump = 0.0_wp
    end associate
    verdict%jump = max(verdict%jump, found%jump)
    verdict%defect = max(verdict%defect, found%defect)
  end subroutine examine

  !> Work of an increment that is neither stored nor dissipated, relative to the energy K s0^2 of a plane at its
  !> strength or to the terms of the balance, whichever is larger. It is an error of the trapezoidal rule, or the energy
  !> that a jump to another branch releases.
  pure function energy_defect(law, old, new) result(defect)
    type(rie_law), intent(in) :: law               !! the law
    type(point_type), intent(in) :: old, new       !! the point at start and end
    real(wp) :: defect
    real(wp) :: change(2), work
    work = new%work - old%work
    change = law%accounts(new%state) - law%accounts(old%state)
    defect = abs(work - sum(change))/max(law%stress*law%s_0, abs(work) + sum(abs(change)))
  end function energy_defect

  !> Whether a part without a reported snap moves far.
  pure function moves_far(law, control, old, new, snaps) result(yes)
    type(rie_law), intent(in) :: law               !! the law
    type(control_type), intent(in) :: control      !! what is given
    type(point_type), intent(in) :: old, new       !! the point at both ends
    integer, intent(in) :: snaps                   !! reported snaps
    logical :: yes
    yes = snaps == 0 .and. move_between(control, old, new) > max(least_jump*law%joint%material%s0, &
      least_share*maxval(abs(new%s), mask=control%traction))
  end function moves_far

  !> Largest change of a free separation.
  pure function move_between(control, old, new) result(move)
    type(control_type), intent(in) :: control      !! what is given
    type(point_type), intent(in) :: old, new       !! the point at both ends
    real(wp) :: move
    move = maxval(abs(new%s - old%s), mask=control%traction)
  end function move_between

end module solver_judge
