!> Run to one target along the branch of equilibria, through its unstable part: `&step follow = 'branch'`.
module branch_run
  use asperity_arc, only: arc_step, arc_type, new_arc
  use asperity_control_point, only: point_type
  use asperity_increment, only: path_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: ended_complete, report_type
  use failed_case, only: failed_type
  use history, only: add_row, history_type, next_row, row_type
  use load_path, only: step_type
  use progress_line, only: progress_type, show_progress
  implicit none
  private
  public :: run_branch

contains

  !> Run to one target; every step along the branch gives a row. The time of a row is that of the largest load factor so
  !> far, so that it does not decrease.
  subroutine run_branch(joint, step, from, to, start, before, increments, done, total, label, point, row, table, &
                        progress, failed)
    type(interface_type), intent(in) :: joint        !! the interface
    type(step_type), intent(in) :: step              !! the step
    real(wp), intent(in) :: from(3), to(3)           !! given values at both ends
    real(wp), intent(in) :: start                    !! time at the start of the step
    real(wp), intent(in) :: before, increments       !! parts of the step before this target, and of it
    integer, intent(in) :: done, total               !! increments of earlier steps, of the run
    character(len=*), intent(in) :: label            !! of the run
    type(point_type), intent(inout) :: point         !! the point, start -> end
    type(row_type), intent(inout) :: row             !! last row of the step
    type(history_type), intent(inout) :: table       !! rows are added
    type(progress_type), intent(inout) :: progress   !! clock
    type(failed_type), intent(inout) :: failed       !! set if the branch ends before the target
    type(arc_type) :: arc
    type(path_type) :: path
    type(report_type) :: report
    real(wp) :: farthest

    path = path_type(step%control, from, to, to - from)
    arc = new_arc(joint, step%arc)
    farthest = 0.0_wp
    do while (arc%factor < 1.0_wp)
      call arc_step(joint, path, arc, point, report)
      farthest = max(farthest, arc%factor)
      call next_row(row, point, report)
      row%time = start + step%time*((before + farthest*increments)/real(sum(step%increments), wp))
      row%turn = arc%turned
      row%lost = report%ended /= ended_complete
      if (row%lost) failed = failed_type(.true., row%step, row%increment, step%control, point, point, to, report, &
        step%arc)
      call add_row(table, joint, row)
      if (row%lost .or. .not. table%good) return
      call show_progress(progress, label, done + int(before + farthest*increments), total)
    end do
  end subroutine run_branch

end module branch_run
