!> An increment in the parts that the law asks for, as hosts divide increments for PNEWDT.
module asperity_asked_increment
  use asperity_control_point, only: control_type, point_type, ramp
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, ended_rejected, report_type
  use asperity_point_law, only: point_law
  use asperity_text, only: to_text
  use asperity_tolerances, only: least_cut, most_cut, smallest_part
  implicit none
  private
  public :: advance_as_asked

contains

  !> Take an increment as `advance`, from its start again in parts where the law is not content. A law that has failed,
  !> or asks for less than the smallest part, ends it.
  pure subroutine advance_as_asked(law, control, ends, before, point, reached, report, reason)
    class(point_law), intent(inout) :: law          !! the law; attempts are counted
    type(control_type), intent(in) :: control       !! what is prescribed
    real(wp), intent(in) :: ends(3, 2)              !! prescribed values at its start and its end
    type(point_type), intent(in) :: before          !! the point at the start
    type(point_type), intent(inout) :: point        !! the same -> at the end
    real(wp), intent(out) :: reached                !! fraction of the increment that converged
    type(report_type), intent(out) :: report        !! of all parts
    character(len=:), allocatable, intent(inout) :: reason   !! set if the law ends the increment
    type(control_type) :: of_part
    type(point_type) :: here
    type(report_type) :: last
    real(wp) :: asked, from(3), part, converged, to(3)
    law%attempt = law%attempt + 1
    call advance(law, control, ends(:, 1), ends(:, 2), point, reached, report)
    call law%ask(asked, reason)
    if (asked >= 1.0_wp) return
    report = report_type(iterations=report%iterations, updates=report%updates, cut=asked > 0.0_wp)
    point = before
    reached = 0.0_wp
    part = 1.0_wp
    from = ends(:, 1)
    of_part = control
    do while (reached < 1.0_wp .and. asked > 0.0_wp)
      if (asked < 1.0_wp) part = min(max(least_cut, asked), most_cut)*part
      if (part < smallest_part) then
        reason = "the law asks for less than " // to_text(smallest_part) // " of the increment"
        exit
      end if
      part = min(part, 1.0_wp - reached)
      to = ramp(ends(:, 1), ends(:, 2), reached + part)
      of_part%dt = part*control%dt
      here = point
      law%attempt = law%attempt + 1
      call advance(law, of_part, from, to, point, converged, last)
      report%iterations = report%iterations + last%iterations
      report%updates = report%updates + last%updates
      call law%ask(asked, reason)
      if (asked < 1.0_wp) then
        point = here
        cycle
      end if
      if (maxval(abs(last%after - last%before)) > maxval(abs(report%after - report%before))) then
        report%before = last%before
        report%after = last%after
      end if
      report%parts = report%parts + last%parts
      report%snaps = report%snaps + last%snaps
      report%released = report%released + last%released
      report%ended = last%ended
      if (converged >= 1.0_wp .and. reached + part >= 1.0_wp) then
        reached = 1.0_wp
      else
        reached = reached + converged*part
      end if
      if (converged < 1.0_wp) exit
      from = to
    end do
    if (allocated(reason)) report%ended = ended_rejected
  end subroutine advance_as_asked

end module asperity_asked_increment
