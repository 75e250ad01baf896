!> Run of one case: rows, comparison with the expected end, summary, and warnings about what is admissible but outside
!> the law's range of validity.
module case_run
  use asperity_text, only: integer_text, short
  use asperity_control_point, only: new_point
  use asperity_kinds, only: wp
  use asperity_load_path, only: run_type
  use asperity_case, only: case_type
  use asperity_case_expect, only: explain_unexpected
  use asperity_foreign_umat, only: foreign_law
  use asperity_warnings, only: increment_text, m_tension, measures, n_measures, warned, warning_text
  use driver_messages, only: exit_input, exit_ok, exit_solve, say
  use failed_case, only: write_failed_case
  use history, only: close_history, history_type, open_history, start_from
  use asperity_mixed_control, only: ended_rejected
  use asperity_point_law, only: point_law
  use path_run, only: run_path, run_umat_path
  use progress_line, only: start_progress, clear_progress, progress_type
  use recorded_strains, only: strains_type
  use replay_run, only: run_replay
  use run_report, only: write_report
  implicit none
  private
  public :: run_case, failed_file, warn_of, measures_of_case

contains

  !> Run a case, write its rows to a CSV file and its result to standard error.
  subroutine run_case(case, law, strains, label, output, report, planes, quiet, worst, code)
    type(case_type), intent(in) :: case         !! the case
    class(point_law), intent(in) :: law         !! its law
    type(strains_type), intent(in) :: strains   !! of a replay
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
    character(len=:), allocatable :: failure, text, why
    logical :: broken

    worst = 0.0_wp
    broken = .false.
    allocate (character(len=0) :: failure)
    code = exit_input
    call open_history(table, output, law, planes .or. case%planes, len(report) > 0)
    if (table%good) then
      call start_progress(progress, "rie_driver", "increments", quiet)
      if (size(case%steps) > 0) then
        select type (law)
        type is (foreign_law)
          call run_umat_path(case, law, label, table, progress, run, failure, why)
          broken = len(failure) > 0
        class default
          call run_path(case, law, label, table, progress, run, failure, why)
        end select
      else
        if (case%initial%given) call start_from(table, law, new_point(law, case%initial%carried))
        call run_replay(case%joint, case%props, case%replay%ntens, case%initial, strains, label, table, &
          progress, failure)
      end if
      call clear_progress(progress)
      call close_history(table)
    end if
    if (.not. table%good) return
    if (.not. case%umat%given) worst = measures_of_case(case, -table%least_traction, table%largest_slip)

    code = exit_ok
    text = last_row(table)
    if (len(failure) > 0) then
      code = merge(exit_input, exit_solve, broken)
    else if (table%last%lost .neqv. case%expect%lost) then
      code = exit_solve
      failure = "the run ended at " // text // " where a loss of equilibrium was expected (&expect in line " // &
        integer_text(case%expect%line) // ")"
      if (table%last%lost) failure = trim(merge("stopped at             ", "equilibrium lost beyond", &
        table%last%report%ended == ended_rejected)) // " " // text // ": " // why
    else
      if (table%n_rows > 0) call explain_unexpected(case%expect, table%last, failure)
      if (len(failure) > 0) then
        code = exit_solve
        failure = "unlike &expect in line " // integer_text(case%expect%line) // ": " // failure
      end if
    end if
    if (len(failure) > 0) call say(label // ": " // failure)
    if (broken .and. run%law%step > 0 .or. table%last%lost .and. .not. case%expect%lost) then
      call keep_failed(case, run, label, output)
    end if
    call write_report(report, code, failure, table%last%lost)
    if (quiet) return
    call say(label // ": " // integer_text(table%n_rows) // " increments, " // integer_text(table%iterations) // &
      " iterations (at most " // integer_text(table%most_iterations) // "), " // &
      updates_and_snaps(table) // &
      trim(merge("equilibrium lost after ", "ended at               ", table%last%lost .and. &
      table%last%report%ended /= ended_rejected)) // " " // text // &
      ", written to " // output)
    if (case%umat%given) return
    text = trim(increment_text(case%joint, max(0.0_wp, -table%least_traction), table%largest_slip))
    if (len(text) > 0) call say(label // ": " // text)
  end subroutine run_case

  !> Text of the last row of a run: step, increment, separation and traction.
  function last_row(table) result(text)
    type(history_type), intent(in) :: table   !! rows
    character(len=:), allocatable :: text
    associate (row => table%last)
      text = "step " // integer_text(row%step) // " increment " // integer_text(row%increment) // ", s = (" // &
        short(row%s(1)) // ", " // short(row%s(2)) // ", " // short(row%s(3)) // "), t = (" // &
        short(row%traction(1)) // ", " // short(row%traction(2)) // ", " // short(row%traction(3)) // ")"
    end associate
  end function last_row

  !> Text of the number of updates of the law, if they were counted, and of snaps, if there were any.
  function updates_and_snaps(table) result(text)
    type(history_type), intent(in) :: table   !! rows
    character(len=:), allocatable :: text
    text = ""
    if (table%updates > 0) text = integer_text(table%updates) // " updates of the law, "
    if (table%snaps > 0) text = text // integer_text(table%snaps) // &
      trim(merge(" snap ", " snaps", table%snaps == 1)) // " that released " // short(table%released) // ", "
  end function updates_and_snaps

  !> Write the failed increment as a case of its own.
  subroutine keep_failed(case, run, label, output)
    type(case_type), intent(in) :: case        !! the case
    type(run_type), intent(in) :: run          !! the run, at its end
    character(len=*), intent(in) :: label      !! of the run
    character(len=*), intent(in) :: output     !! file with the rows
    character(len=:), allocatable :: path
    logical :: written
    path = failed_file(output)
    call write_failed_case(path, case, run, written)
    if (written) call say(label // ": the failed increment was written to " // path)
  end subroutine keep_failed

  !> Name of the case file of a failed increment.
  pure function failed_file(output) result(path)
    character(len=*), intent(in) :: output   !! file with the rows
    character(len=:), allocatable :: path
    character(len=*), parameter :: ending = ".csv"
    path = output
    if (output == "-") path = "rie_driver"
    if (len(path) > len(ending)) then
      if (path(len(path) - len(ending) + 1:) == ending) path = path(:len(path) - len(ending))
    end if
    path = path // ".failed.nml"
  end function failed_file

  !> Write a line to standard error for each measure beyond its limit.
  subroutine warn_of(path, values)
    character(len=*), intent(in) :: path             !! case file, for the messages
    real(wp), intent(in) :: values(n_measures)       !! the largest ones of all values of the sweep
    logical :: doubtful(n_measures)
    integer :: i
    doubtful = warned(values)
    do i = 1, n_measures
      if (doubtful(i)) call say(path // ": warning: " // trim(warning_text(i, values(i))))
    end do
  end subroutine warn_of

  !> Measures of a case: before the run those that the case determines, after it those of its largest pressure and slip.
  pure function measures_of_case(case, pressure, slip) result(values)
    type(case_type), intent(in) :: case              !! the case
    real(wp), intent(in), optional :: pressure       !! largest of the run, >= 0, stress
    real(wp), intent(in), optional :: slip           !! largest of the run, length
    real(wp) :: values(n_measures)
    if (present(pressure) .and. present(slip)) then
      values = measures(case%props, pressure, 0.0_wp, slip)
      values(:m_tension) = 0.0_wp
    else
      values = measures(case%props, 0.0_wp, largest_tension(case), 0.0_wp)
    end if
  end function measures_of_case

  !> Largest prescribed t_N.
  pure function largest_tension(case) result(tension)
    type(case_type), intent(in) :: case   !! the case
    real(wp) :: tension
    integer :: i
    tension = 0.0_wp
    do i = 1, size(case%steps)
      if (.not. (case%steps(i)%control%traction(1) .and. case%steps(i)%has_target(1))) cycle
      tension = max(tension, maxval(case%steps(i)%targets(1, :)))
    end do
  end function largest_tension

end module case_run
