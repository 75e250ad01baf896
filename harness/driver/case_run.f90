!> Run of one case: rows, comparison with the expected end, summary, case of a failed increment, and warnings about what
!> is admissible but outside the law's range of validity.
module case_run
  use asperity_case, only: case_type, write_case
  use asperity_case_groups, only: explain_unexpected, start_point
  use asperity_contract, only: p_c, p_tau_v
  use asperity_equations, only: new_point, point_type
  use asperity_foreign_umat, only: foreign_law, umat_name
  use asperity_kinds, only: wp
  use asperity_load_path, only: explain_account, explain_end, next_row, row_type, run_type
  use asperity_increment, only: ended_refused, ended_rejected
  use asperity_point_law, only: point_law
  use asperity_refine, only: refine_path
  use asperity_steps, only: e_arc, e_follow, e_increments, e_k, e_s, e_t, e_time
  use asperity_text, only: integer_text, set_text, short
  use asperity_umat_run, only: next_umat_row, start_umat_run, umat_run_type
  use asperity_warnings, only: increment_text, m_tension, measures, n_measures, warned, warning_text
  use driver_output, only: close_file, create_file, exit_input, exit_ok, exit_solve, say, without, write_line, &
    write_report
  use history, only: add_row, history_type, open_history, start_from
  use progress_line, only: clear_progress, progress_type, show_progress, start_progress
  use replay, only: run_replay
  implicit none
  private
  public :: run_case, failed_file, warn_of, measures_of_case

  !> Start of every case of a failed increment.
  character(len=*), parameter, public :: failed_title = "&case title = 'failed increment "

contains

  !> Run a case, write its rows to a CSV file and its result to standard error.
  subroutine run_case(case, law, label, output, report, planes, quiet, worst, code)
    type(case_type), intent(in) :: case         !! the case
    class(point_law), intent(in) :: law         !! its law
    character(len=*), intent(in) :: label       !! name of the run in messages
    character(len=*), intent(in) :: output      !! file, "-": standard output
    character(len=*), intent(in) :: report      !! file of the report, empty: none
    logical, intent(in) :: planes               !! whether each plane has columns
    logical, intent(in) :: quiet                !! no progress line, no summary
    real(wp), intent(out) :: worst(n_measures)  !! measures of warnings at the largest pressure and slip
    integer, intent(out) :: code                !! exit code
    type(history_type) :: table
    type(progress_type) :: progress
    type(run_type) :: run
    character(len=:), allocatable :: account, counts, failure, text, why
    logical :: broken, ends_early, keeps

    worst = 0.0_wp
    broken = .false.
    allocate (character(len=0) :: failure, account)
    call open_history(table, output, law, case%aperture, planes .or. case%planes, len(report) > 0, &
      case%stability)
    call start_progress(progress, "rie_driver", "increments", quiet)
    if (size(case%steps) > 0) then
      call run_path(case, law, label, table, progress, run, failure, broken, why)
      if (.not. case%umat%given) call explain_account(run, account)
    else
      if (case%initial%given) call start_from(table, law, new_point(law, case%state%statev), 0.0_wp)
      call run_replay(case, label, table, progress, failure)
    end if
    call clear_progress(progress)
    call close_file()
    if (.not. case%umat%given) worst = measures(case%props, -table%least_traction, 0.0_wp, table%largest_slip)
    ! as before the run
    worst(:m_tension) = 0.0_wp

    code = exit_ok
    ends_early = any(table%last%report%ended == [ended_refused, ended_rejected])
    associate (row => table%last)
      text = "step " // integer_text(row%step) // " increment " // integer_text(row%increment) // ", s = " // &
        vector_text(row%s) // ", t = " // vector_text(row%traction)
    end associate
    if (len(failure) > 0) then
      code = merge(exit_input, exit_solve, broken)
    else if (table%last%lost .neqv. case%expect%lost) then
      code = exit_solve
      failure = "the run ended at " // text // " where a loss of equilibrium was expected (&expect in line " // &
        integer_text(case%expect%line) // ")"
      if (table%last%lost) failure = trim(merge("stopped at             ", "equilibrium lost beyond", ends_early)) // &
        " " // text // ": " // why
    else
      if (table%n_rows > 0) call explain_unexpected(case%expect, table%last, failure)
      if (len(failure) > 0) then
        code = exit_solve
        failure = "unlike &expect in line " // integer_text(case%expect%line) // ": " // failure
      end if
    end if
    if (len(failure) > 0) call say(label // ": " // failure)
    if (len(account) > 0) call say(label // ": warning: " // account)
    keeps = (table%last%lost .and. .not. case%expect%lost) .or. (broken .and. run%number(1) > 0)
    if (keeps) call keep_failed(case, run, label, output)
    call write_report(report, code, failure, table%last%lost)
    if (quiet) return
    counts = ""
    if (table%updates > 0) counts = integer_text(table%updates) // " updates of the law, "
    if (table%snaps > 0) counts = counts // integer_text(table%snaps) // &
      trim(merge(" snap ", " snaps", table%snaps == 1)) // " that released " // short(table%released) // ", "
    why = trim(merge("stopped at", "ended at  ", broken .or. table%last%lost))
    if (table%last%lost .and. .not. ends_early) why = "equilibrium lost after"
    call say(label // ": " // integer_text(table%n_rows) // " increments, " // integer_text(table%iterations) // &
      " iterations (at most " // integer_text(table%most_iterations) // "), " // counts // why // " " // text // &
      ", written to " // output)
    if (case%umat%given) return
    text = trim(increment_text(case%joint, max(0.0_wp, -table%least_traction), table%largest_slip))
    if (len(text) > 0) call say(label // ": " // text)
  end subroutine run_case

  !> Run all steps, or up to a loss of equilibrium or the failure of a UMAT of others, which has a process of its own.
  subroutine run_path(case, law, label, table, progress, run, failure, broken, why)
    type(case_type), intent(in) :: case              !! the case
    class(point_law), intent(in) :: law              !! its law
    character(len=*), intent(in) :: label            !! name of the run, for the progress line
    type(history_type), intent(inout) :: table       !! rows are added; the last one says whether equilibrium was lost
    type(progress_type), intent(inout) :: progress   !! clock
    type(run_type), intent(out) :: run               !! at its end
    character(len=:), allocatable, intent(inout) :: failure   !! set by a UMAT, tolerance or fork that fails
    logical, intent(out) :: broken                            !! whether the UMAT has failed
    character(len=:), allocatable, intent(out) :: why         !! why equilibrium was lost
    type(point_type) :: start
    type(row_type) :: row
    type(umat_run_type) :: child
    character(len=:), allocatable :: name
    logical :: found
    call set_text(why, "")
    call set_text(name, "")
    broken = .false.
    select type (law)
    type is (foreign_law)
      call start_umat_run(law, case, child)
      run = child%run
      start = run%before
      call set_text(name, umat_name(law))
    class default
      start = start_point(law, case%state)
      call refine_path(law, case%steps, start, case%state%p, case%tolerance, run, failure)
    end select
    if (case%state%given) call start_from(table, law, start, case%state%p)
    do
      if (case%umat%given) then
        call next_umat_row(child, row, found)
      else
        call next_row(run, row, found)
      end if
      if (.not. found) exit
      if (row%report%snaps > 0 .and. .not. progress%quiet) call report_snap(label, row, table%snaps, progress)
      call add_row(table, row)
      call show_progress(progress, label, row%done, run%total)
    end do
    if (case%umat%given) then
      run = child%run
      why = child%reason
      broken = len(child%failure) > 0
      if (broken) failure = name // ": " // child%failure
    else
      call explain_end(run, row, why)
    end if
    if (len(failure) == 0 .and. .not. row%lost) failure = why
  end subroutine run_path

  !> Report a snap on standard error.
  subroutine report_snap(label, row, earlier, progress)
    character(len=*), intent(in) :: label            !! of the run
    type(row_type), intent(in) :: row                !! the increment
    integer, intent(in) :: earlier                   !! snaps before it
    type(progress_type), intent(inout) :: progress   !! clock
    !> Number of snaps that are reported one by one.
    integer, parameter :: most = 20
    if (earlier >= most) return
    call clear_progress(progress)
    call say(label // ": step " // integer_text(row%step) // " increment " // integer_text(row%increment) // &
      ": snap from s = " // vector_text(row%report%before) // " to " // vector_text(row%report%after) // ", " // &
      short(row%report%released) // " released")
  end subroutine report_snap

  !> Text of a vector.
  pure function vector_text(vector) result(text)
    real(wp), intent(in) :: vector(3)   !! components N, Tx, Ty
    character(len=:), allocatable :: text
    text = "(" // short(vector(1)) // ", " // short(vector(2)) // ", " // short(vector(3)) // ")"
  end function vector_text

  !> Write the failed increment as a case of its own: the law, the state at its start, and the prescribed values at its
  !> end. Numbers read back exactly.
  subroutine keep_failed(case, run, label, output)
    type(case_type), intent(in) :: case        !! the case
    type(run_type), intent(in) :: run          !! the run, at its end
    character(len=*), intent(in) :: label      !! of the run
    character(len=*), intent(in) :: output     !! file with the rows
    type(case_type) :: failed
    character(len=:), allocatable :: text
    integer :: i
    logical :: timed
    failed%title = "failed increment " // integer_text(run%number(2)) // " of step " // integer_text(run%number(1))
    failed%props = case%props
    failed%stiffness = case%stiffness
    failed%umat = case%umat
    failed%state%given = .true.
    failed%state%s = run%before%s
    failed%state%statev = run%before%state
    failed%state%has_work = .true.
    failed%state%work = run%before%work
    failed%state%has_traction = .not. case%umat%given
    failed%state%traction = run%before%traction
    timed = case%umat%given
    if (.not. timed) timed = case%props(p_tau_v) > 0.0_wp .or. case%props(p_c) > 0.0_wp
    allocate (failed%steps(1))
    associate (given => failed%steps(1)%given, control => run%control, arc => run%steps(run%number(1))%arc)
      do i = 1, 3
        if (control%traction(i)) then
          ! the force of a spring is zero at the start of the step
          given(e_t + i)%values = [run%given(i) - control%spring(i)*run%before%s(i)]
          if (control%spring(i) > 0.0_wp) given(e_k + i)%values = control%spring(i:i)
        else
          given(e_s + i)%values = run%given(i:i)
        end if
      end do
      if (timed) given(e_time)%values = [control%dt]
      if (arc > 0.0_wp) then
        given(e_follow)%values = [1.0_wp]
        given(e_arc)%values = [arc]
      else
        given(e_increments)%values = [1.0_wp]
      end if
    end associate
    call write_case(failed, text)
    call create_file(failed_file(output))
    call write_line(text(:len(text) - 1))
    call close_file()
    call say(label // ": the failed increment was written to " // failed_file(output))
  end subroutine keep_failed

  !> Name of the case file of a failed increment.
  pure function failed_file(output) result(path)
    character(len=*), intent(in) :: output   !! file with the rows
    character(len=:), allocatable :: path
    path = without(output, ".csv")
    if (output == "-") path = "rie_driver"
    path = path // ".failed.nml"
  end function failed_file

  !> Write a line to standard error for each measure beyond its limit.
  subroutine warn_of(path, values)
    character(len=*), intent(in) :: path             !! case file, for the messages
    real(wp), intent(in) :: values(n_measures)       !! the largest ones of all values of the sweep
    logical :: beyond(n_measures)
    integer :: i
    beyond = warned(values)
    do i = 1, n_measures
      if (beyond(i)) call say(path // ": warning: " // trim(warning_text(i, values(i))))
    end do
  end subroutine warn_of

  !> Measures of warnings that a case determines before its run.
  pure function measures_of_case(case) result(values)
    type(case_type), intent(in) :: case              !! the case
    real(wp) :: p, tension, total, values(n_measures)
    real(wp), allocatable :: pressures(:)
    integer :: i
    tension = 0.0_wp
    p = case%state%p
    total = -huge(total)   ! not known, as t_N is not prescribed
    do i = 1, size(case%steps)
      associate (step => case%steps(i))
        pressures = spread(p, 1, size(step%increments))
        if (allocated(step%water)) pressures = step%water
        p = pressures(size(pressures))
        if (step%changed(1)) total = -huge(total)
        if (step%control%traction(1) .and. step%has_target(1)) then
          tension = max(tension, maxval(step%targets(1, :) + pressures))
          total = step%targets(1, size(pressures))
        else if (step%control%traction(1)) then
          tension = max(tension, total + maxval(pressures))
        end if
      end associate
    end do
    values = measures(case%props, 0.0_wp, tension, 0.0_wp)
  end function measures_of_case

end module case_run
