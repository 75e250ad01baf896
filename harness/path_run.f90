!> Run of a load path: the steps of a case in turn by the mixed solver.
module path_run
  use asperity_checks, only: integer_text
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use case_state, only: state_type
  use driver_messages, only: progress_type, short, show_progress, tell
  use failed_case, only: failed_type
  use history, only: add_row, history_type, row_type, start_from
  use load_path, only: step_type
  use mixed_control, only: advance, control_type, new_point, point_type, report_type
  implicit none
  private
  public :: run_path

contains

  !> Run all steps, or as far as there is equilibrium; every increment becomes a row.
  subroutine run_path(interface, state, steps, label, table, progress, failed)
    type(interface_type), intent(in) :: interface    !! the interface
    type(state_type), intent(in) :: state            !! where the run starts
    type(step_type), intent(in) :: steps(:)          !! the load path
    character(len=*), intent(in) :: label            !! of the run, for the progress line
    type(history_type), intent(inout) :: table       !! rows are added; the last one says whether equilibrium was lost
    type(progress_type), intent(inout) :: progress   !! clock
    type(failed_type), intent(out) :: failed         !! the increment without equilibrium, if there is one
    type(point_type) :: point
    real(wp) :: given(3), start
    integer :: i, total

    if (state%given) then
      point = new_point(interface, state%statev, state%s)
      call start_from(table, interface, point)
    else
      point = new_point(interface)
    end if
    given = point%s
    start = 0.0_wp
    total = 0
    do i = 1, size(steps)
      total = total + sum(steps(i)%increments)
    end do
    do i = 1, size(steps)
      call run_step(interface, steps(i), i, start, total, label, point, given, table, progress, failed)
      if (table%last%lost .or. .not. table%good) exit
      start = start + steps(i)%time
    end do
  end subroutine run_path

  !> Run a step: from target to target.
  subroutine run_step(interface, step, number, start, total, label, point, given, table, progress, failed)
    type(interface_type), intent(in) :: interface    !! the interface
    type(step_type), intent(in) :: step              !! the step
    integer, intent(in) :: number                    !! of the step
    real(wp), intent(in) :: start                    !! time at its start
    integer, intent(in) :: total                     !! increments of the run
    character(len=*), intent(in) :: label            !! of the run
    type(point_type), intent(inout) :: point         !! the point, start -> end
    real(wp), intent(inout) :: given(3)              !! separation, or traction + spring*separation, start -> end
    type(history_type), intent(inout) :: table       !! rows are added
    type(progress_type), intent(inout) :: progress   !! clock
    type(failed_type), intent(inout) :: failed       !! set if an increment finds no equilibrium
    type(row_type) :: row
    type(control_type) :: control
    type(point_type) :: before
    type(report_type) :: report
    real(wp) :: from(3), last(3), offset(3), reached, to(3)
    integer :: j, n

    ! the surroundings are free of force at the start of the step
    offset = merge(step%control%spring*point%s, 0.0_wp, step%control%traction)
    where (step%changed) given = merge(point%traction + offset, point%s, step%control%traction)
    control = step%control
    control%dt = step%time/real(sum(step%increments), wp)
    row%step = number
    do j = 1, size(step%increments)
      from = given
      to = merge(step%targets(:, j) + offset, given, step%has_target)
      do n = 1, step%increments(j)
        last = given
        before = point
        given = ramp(from, to, n, step%increments(j))
        call advance(interface, control, last, given, point, row%iterations, reached, report=report)
        row%increment = row%increment + 1
        row%time = start + step%time*((real(row%increment - 1, wp) + reached)/real(sum(step%increments), wp))
        row%s = point%s
        row%traction = point%traction
        row%state = point%state
        row%snaps = report%snaps
        row%released = report%released
        row%updates = report%updates
        row%substeps = report%parts > 1
        row%lost = reached < 1.0_wp
        if (row%snaps > 0) call tell_snap(label, row, report, table%snaps, progress)
        if (row%lost) then
          failed = failed_type(.true., number, row%increment, control, before, point, given, report)
        end if
        call add_row(table, interface, row)
        if (row%lost .or. .not. table%good) return
        call show_progress(progress, label, table%n_rows, total)
      end do
    end do
  end subroutine run_step

  !> Say what a snap came to.
  subroutine tell_snap(label, row, report, earlier, progress)
    character(len=*), intent(in) :: label            !! of the run
    type(row_type), intent(in) :: row                !! the increment
    type(report_type), intent(in) :: report          !! what happened in it
    integer, intent(in) :: earlier                   !! snaps before it
    type(progress_type), intent(inout) :: progress   !! clock
    !> Snaps that are told one by one.
    integer, parameter :: most = 20
    if (earlier >= most) return
    call tell(progress, label // ": step " // integer_text(row%step) // " increment " // &
      integer_text(row%increment) // ": snap from s = " // vector(report%before) // " to " // vector(report%after) // &
      ", " // short(report%released) // " set free")
  end subroutine tell_snap

  !> Components in parentheses.
  function vector(s) result(text)
    real(wp), intent(in) :: s(3)   !! (N, Tx, Ty)
    character(len=:), allocatable :: text
    text = "(" // short(s(1)) // ", " // short(s(2)) // ", " // short(s(3)) // ")"
  end function vector

  !> Value n of m between two, both ends exact.
  pure elemental function ramp(from, to, n, m) result(value)
    real(wp), intent(in) :: from, to   !! values at n = 0 and n = m
    integer, intent(in) :: n, m        !! 0 <= n <= m
    real(wp) :: value
    value = from + (real(n, wp)*(to - from))/real(m, wp)
    if (n == m) value = to
  end function ramp

end module path_run
