!> Run of the load path of a case: every increment gives a row of the file.
module path_run
  use asperity_control_point, only: new_point, point_type
  use asperity_kinds, only: wp
  use asperity_load_path, only: start_run, next_row, row_type, run_type
  use asperity_refine, only: refine_path
  use asperity_point_law, only: point_law
  use asperity_text, only: integer_text, short
  use case_file, only: case_type
  use driver_messages, only: tell
  use history, only: add_row, history_type, start_from
  use progress_line, only: progress_type, show_progress
  implicit none
  private
  public :: run_path

contains

  !> Run all steps, or up to a loss of equilibrium.
  subroutine run_path(case, law, label, table, progress, run, failure)
    type(case_type), intent(in) :: case              !! the case
    class(point_law), intent(in) :: law              !! its law
    character(len=*), intent(in) :: label            !! name of the run, for the progress line
    type(history_type), intent(inout) :: table       !! rows are added; the last one says whether equilibrium was lost
    type(progress_type), intent(inout) :: progress   !! clock
    type(run_type), intent(out) :: run               !! at its end
    character(len=:), allocatable, intent(inout) :: failure   !! a line is appended if the tolerance is not reached
    type(point_type) :: start
    type(row_type) :: row
    type(row_type), allocatable :: rows(:)
    character(len=:), allocatable :: reason
    real(wp) :: share
    integer :: i
    logical :: found
    start = new_point(law)
    if (case%state%given) start = new_point(law, case%state%statev, case%state%s)
    call law%ask(share, reason)
    if (share <= 0.0_wp) then
      failure = reason
      return
    end if
    if (case%state%has_work) start%work = case%state%work
    if (case%state%given) call start_from(table, law, start)
    if (case%refines) then
      call refine_path(law, case%steps, start, case%tolerance, rows, run, failure)
    else
      call start_run(law, case%steps, run, start)
    end if
    i = 0
    do
      if (allocated(rows)) then
        i = i + 1
        found = i <= size(rows)
        if (found) row = rows(i)
      else
        call next_row(run, row, found)
      end if
      if (.not. found) exit
      if (row%report%snaps > 0) call tell_snap(label, row, table%snaps, progress)
      call add_row(table, row)
      if (.not. table%good) exit
      call show_progress(progress, label, run%done, run%total)
    end do
  end subroutine run_path

  !> Report a snap.
  subroutine tell_snap(label, row, earlier, progress)
    character(len=*), intent(in) :: label            !! of the run
    type(row_type), intent(in) :: row                !! the increment
    integer, intent(in) :: earlier                   !! snaps before it
    type(progress_type), intent(inout) :: progress   !! clock
    !> Number of snaps that are reported one by one.
    integer, parameter :: most = 20
    if (earlier >= most) return
    associate (b => row%report%before, a => row%report%after)
      call tell(progress, label // ": step " // integer_text(row%step) // " increment " // &
        integer_text(row%increment) // ": snap from s = (" // short(b(1)) // ", " // short(b(2)) // ", " // &
        short(b(3)) // ") to (" // short(a(1)) // ", " // short(a(2)) // ", " // short(a(3)) // "), " // &
        short(row%report%released) // " released")
    end associate
  end subroutine tell_snap

end module path_run
