!> Run of a load path: the steps of a case are solved one after the other under mixed control.
module path_run
  use asperity_adaptive, only: adaptive_step, new_walk, walk_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text
  use branch_run, only: run_branch
  use case_state, only: state_type
  use driver_messages, only: short, tell
  use failed_case, only: failed_type
  use history, only: add_row, history_type, next_row, row_type, start_from
  use load_path, only: step_type
  use asperity_mixed_control, only: advance, control_type, new_point, point_type, report_type
  use progress_line, only: progress_type, show_progress
  implicit none
  private
  public :: run_path

contains

  !> Run all steps, or up to a loss of equilibrium; every increment gives a row.
  subroutine run_path(joint, state, steps, label, table, progress, failed)
    type(interface_type), intent(in) :: joint        !! the interface
    type(state_type), intent(in) :: state            !! state at the start
    type(step_type), intent(in) :: steps(:)          !! the load path
    character(len=*), intent(in) :: label            !! name of the run, for the progress line
    type(history_type), intent(inout) :: table       !! rows are added; the last one says whether equilibrium was lost
    type(progress_type), intent(inout) :: progress   !! clock
    type(failed_type), intent(out) :: failed         !! the increment without equilibrium, if there is one
    type(point_type) :: point
    type(walk_type) :: walk
    real(wp) :: given(3), start
    integer :: done, i, total

    if (state%given) then
      point = new_point(joint, state%statev, state%s)
      if (state%has_work) point%work = state%work
      call start_from(table, joint, point)
    else
      point = new_point(joint)
    end if
    walk = new_walk(joint)
    given = point%s
    start = 0.0_wp
    total = 0
    done = 0
    do i = 1, size(steps)
      total = total + sum(steps(i)%increments)
    end do
    do i = 1, size(steps)
      call run_step(joint, steps(i), i, start, done, total, label, point, walk, given, table, progress, &
        failed)
      done = done + sum(steps(i)%increments)
      if (table%last%lost .or. .not. table%good) exit
      start = start + steps(i)%time
    end do
  end subroutine run_path

  !> Run a step: from target to target.
  subroutine run_step(joint, step, number, start, done, total, label, point, walk, given, table, &
                      progress, failed)
    type(interface_type), intent(in) :: joint        !! the interface
    type(step_type), intent(in) :: step              !! the step
    integer, intent(in) :: number                    !! of the step
    real(wp), intent(in) :: start                    !! time at its start
    integer, intent(in) :: done, total               !! increments of earlier steps, of the run
    character(len=*), intent(in) :: label            !! of the run
    type(point_type), intent(inout) :: point         !! the point, start -> end
    type(walk_type), intent(inout) :: walk           !! control of adaptive increments
    real(wp), intent(inout) :: given(3)              !! separation, or traction + spring*separation, start -> end
    type(history_type), intent(inout) :: table       !! rows are added
    type(progress_type), intent(inout) :: progress   !! clock
    type(failed_type), intent(inout) :: failed       !! set if an increment finds no equilibrium
    type(row_type) :: row
    type(control_type) :: control
    type(point_type) :: before
    type(report_type) :: report
    real(wp) :: earlier, from(3), last(3), offset(3), reached, to(3)
    integer :: iterations, j, n

    ! the force of the spring is zero at the start of the step
    offset = merge(step%control%spring*point%s, 0.0_wp, step%control%traction)
    where (step%changed) given = merge(point%traction + offset, point%s, step%control%traction)
    control = step%control
    control%dt = step%time/real(sum(step%increments), wp)
    row%step = number
    do j = 1, size(step%increments)
      from = given
      to = merge(step%targets(:, j) + offset, given, step%has_target)
      if (step%tolerance > 0.0_wp) then
        earlier = real(sum(step%increments(:j - 1)), wp)
        call run_adaptive(joint, step, from, to, start, earlier, real(step%increments(j), wp), done, total, label, &
          point, walk, row, table, progress, failed)
        given = to
        if (row%lost .or. .not. table%good) return
        cycle
      end if
      if (step%arc > 0.0_wp) then
        earlier = real(sum(step%increments(:j - 1)), wp)
        call run_branch(joint, step, from, to, start, earlier, real(step%increments(j), wp), done, total, label, &
          point, row, table, progress, failed)
        given = to
        if (row%lost .or. .not. table%good) return
        cycle
      end if
      do n = 1, step%increments(j)
        last = given
        before = point
        given = ramp(from, to, n, step%increments(j))
        call advance(joint, control, last, given, point, iterations, reached, report=report)
        call next_row(row, point, report)
        row%time = start + step%time*((real(row%increment - 1, wp) + reached)/real(sum(step%increments), wp))
        row%lost = reached < 1.0_wp
        if (row%snaps > 0) call tell_snap(label, row, report, table%snaps, progress)
        if (row%lost) then
          failed = failed_type(.true., number, row%increment, control, before, point, given, report)
        end if
        call add_row(table, joint, row)
        if (row%lost .or. .not. table%good) return
        call show_progress(progress, label, done + row%increment, total)
      end do
    end do
  end subroutine run_step

  !> Report a snap.
  subroutine tell_snap(label, row, report, earlier, progress)
    character(len=*), intent(in) :: label            !! of the run
    type(row_type), intent(in) :: row                !! the increment
    type(report_type), intent(in) :: report          !! report of the increment
    integer, intent(in) :: earlier                   !! snaps before it
    type(progress_type), intent(inout) :: progress   !! clock
    !> Number of snaps that are reported one by one.
    integer, parameter :: most = 20
    if (earlier >= most) return
    call tell(progress, label // ": step " // integer_text(row%step) // " increment " // &
      integer_text(row%increment) // ": snap from s = " // vector(report%before) // " to " // vector(report%after) // &
      ", " // short(report%released) // " released")
  end subroutine tell_snap

  !> Components in parentheses.
  function vector(s) result(text)
    real(wp), intent(in) :: s(3)   !! (N, Tx, Ty)
    character(len=:), allocatable :: text
    text = "(" // short(s(1)) // ", " // short(s(2)) // ", " // short(s(3)) // ")"
  end function vector

  !> Run to one target by adaptive increments: two rows for every step, or one where equilibrium is lost.
  subroutine run_adaptive(joint, step, from, to, start, before, increments, done, total, label, point, walk, row, &
                          table, progress, failed)
    type(interface_type), intent(in) :: joint        !! the interface
    type(step_type), intent(in) :: step              !! the step
    real(wp), intent(in) :: from(3), to(3)           !! given values at both ends
    real(wp), intent(in) :: start                    !! time at the start of the step
    real(wp), intent(in) :: before, increments       !! increments of the step before this load path, and on it
    integer, intent(in) :: done, total               !! increments of earlier steps, of the run
    character(len=*), intent(in) :: label            !! of the run
    type(point_type), intent(inout) :: point         !! the point, start -> end
    type(walk_type), intent(inout) :: walk           !! step size and scales
    type(row_type), intent(inout) :: row             !! last row of the step
    type(history_type), intent(inout) :: table       !! rows are added
    type(progress_type), intent(inout) :: progress   !! clock
    type(failed_type), intent(inout) :: failed       !! set if a step finds no equilibrium
    type(point_type) :: earlier, middle
    type(control_type) :: control, tried
    type(report_type) :: reports(2)
    real(wp) :: at, at_middle, from_at, reached
    integer :: iterations(2)

    walk%tolerance = step%tolerance
    walk%size = 1.0_wp/increments
    control = step%control
    control%dt = step%time*(increments/real(sum(step%increments), wp))
    at = 0.0_wp
    do while (at < 1.0_wp)
      earlier = point
      from_at = at
      call adaptive_step(joint, control, from, to, walk, at, point, at_middle, middle, iterations, reached, reports)
      row%lost = reached < 1.0_wp
      if (.not. row%lost) then
        call add(at_middle, middle, iterations(1), reports(1))
        if (.not. table%good) return
        call add(at, point, iterations(2), reports(2))
      else
        tried = control
        tried%dt = (walk%tried - from_at)*control%dt
        failed = failed_type(.true., row%step, row%increment + 1, tried, earlier, point, &
          merge(to, from + walk%tried*(to - from), walk%tried >= 1.0_wp), reports(1))
        call add(at, point, iterations(1), reports(1))
      end if
      if (row%lost .or. .not. table%good) return
      call show_progress(progress, label, done + int(before + at*increments), total)
    end do

  contains

    !> Add the row at a fraction of the load path.
    subroutine add(now, new, iterations, report)
      real(wp), intent(in) :: now               !! fraction of the load path
      type(point_type), intent(in) :: new       !! the point
      integer, intent(in) :: iterations         !! of Newton's method
      type(report_type), intent(in) :: report   !! report
      call next_row(row, new, report)
      row%time = start + step%time*((before + now*increments)/real(sum(step%increments), wp))
      row%iterations = iterations
      row%coarse = walk%coarse .and. .not. row%lost
      if (row%snaps > 0) call tell_snap(label, row, report, table%snaps, progress)
      call add_row(table, joint, row)
    end subroutine add

  end subroutine run_adaptive

  !> Linear interpolation, exact at both ends.
  pure elemental function ramp(from, to, n, m) result(value)
    real(wp), intent(in) :: from, to   !! values at n = 0 and n = m
    integer, intent(in) :: n, m        !! 0 <= n <= m
    real(wp) :: value
    value = from + (real(n, wp)*(to - from))/real(m, wp)
    if (n == m) value = to
  end function ramp

end module path_run
