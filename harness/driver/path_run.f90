!> Run of the load path of a case: every increment gives a row of the file.
module path_run
  use asperity_control_point, only: new_point, point_type
  use asperity_kinds, only: wp
  use asperity_load_path, only: explain_loss, start_run, next_row, row_type, run_type
  use asperity_refine, only: refine_path
  use asperity_point_law, only: point_law
  use asperity_text, only: integer_text, short
  use asperity_umat_run, only: end_umat_run, next_umat_row, start_umat_run, umat_path_type, umat_run_type
  use asperity_case, only: case_type
  use asperity_foreign_umat, only: foreign_law
  use driver_messages, only: tell
  use history, only: add_row, history_type, start_from
  use progress_line, only: progress_type, show_progress
  implicit none
  private
  public :: run_path, run_umat_path, get_umat_path

contains

  !> Run all steps, or up to a loss of equilibrium.
  subroutine run_path(case, law, label, table, progress, run, failure, why)
    type(case_type), intent(in) :: case              !! the case
    class(point_law), intent(in) :: law              !! its law
    character(len=*), intent(in) :: label            !! name of the run, for the progress line
    type(history_type), intent(inout) :: table       !! rows are added; the last one says whether equilibrium was lost
    type(progress_type), intent(inout) :: progress   !! clock
    type(run_type), intent(out) :: run               !! at its end
    character(len=:), allocatable, intent(inout) :: failure   !! a line is appended if the tolerance is not reached
    character(len=:), allocatable, intent(out) :: why         !! why equilibrium was lost, or the UMAT has failed
    type(point_type) :: start
    type(row_type) :: row
    type(row_type), allocatable :: rows(:)
    integer :: i
    logical :: found
    start = new_point(law)
    if (case%state%given) start = new_point(law, case%state%statev, case%state%s)
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
      call take_row(row, label, run, table, progress)
      if (.not. table%good) exit
    end do
    why = ""
    if (row%lost) call explain_loss(run, row, why)
  end subroutine run_path

  !> Run all steps with a UMAT of others in a process of its own, or up to a loss of equilibrium or a failure.
  subroutine run_umat_path(case, law, label, table, progress, run, failure, why)
    type(case_type), intent(in) :: case              !! the case
    type(foreign_law), intent(in) :: law             !! its law
    character(len=*), intent(in) :: label            !! name of the run, for the progress line
    type(history_type), intent(inout) :: table       !! rows are added; the last one says whether equilibrium was lost
    type(progress_type), intent(inout) :: progress   !! clock
    type(run_type), intent(out) :: run               !! at its end
    character(len=:), allocatable, intent(inout) :: failure   !! why the UMAT has failed; empty: it has not
    character(len=:), allocatable, intent(out) :: why         !! why the path ends before its end; empty: it does not
    type(umat_path_type) :: path
    type(umat_run_type) :: umat_run
    type(row_type) :: row
    logical :: found
    call get_umat_path(case, law, path)
    do
      call start_umat_run(path, umat_run)
      if (table%n_rows == 0) call start_from(table, law, umat_run%run%before)
      do
        call next_umat_row(umat_run, row, found)
        if (.not. found) exit
        call take_row(row, label, umat_run%run, table, progress)
        if (.not. table%good) exit
      end do
      if (found) call end_umat_run(umat_run)
      if (len(failure) == 0) failure = umat_run%failure
      ! a path with a tolerance has its rows at its end only: it is taken again as far as it goes
      if (len(failure) == 0 .or. .not. path%tolerance > 0.0_wp) exit
      path%tolerance = 0.0_wp
    end do
    run = umat_run%run
    why = umat_run%reason
  end subroutine run_umat_path

  !> What the UMAT of a case is to do.
  subroutine get_umat_path(case, law, path)
    type(case_type), intent(in) :: case               !! the case
    class(point_law), intent(in) :: law               !! its law
    type(umat_path_type), intent(out) :: path         !! of its UMAT, if it is given
    select type (law)
    type is (foreign_law)
      path%law = law
    end select
    path%steps = case%steps
    path%s = case%state%s
    if (case%state%given) path%state = case%state%statev
    path%has_work = case%state%has_work
    path%work = case%state%work
    if (case%refines) path%tolerance = case%tolerance
  end subroutine get_umat_path

  !> Report and write a row.
  subroutine take_row(row, label, run, table, progress)
    type(row_type), intent(in) :: row                !! the row
    character(len=*), intent(in) :: label            !! name of the run
    type(run_type), intent(in) :: run                !! the run
    type(history_type), intent(inout) :: table       !! the row is added
    type(progress_type), intent(inout) :: progress   !! clock
    if (row%report%snaps > 0) call tell_snap(label, row, table%snaps, progress)
    call add_row(table, row)
    if (table%good) call show_progress(progress, label, run%done, run%total)
  end subroutine take_row

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
