!> Run of one case: rows, end as expected or not, summary.
module case_run
  use asperity_checks, only: integer_text, to_text
  use asperity_contract, only: p_eta, p_kc, p_sigma0, v_damage, v_friction, v_rupture, v_stored, v_work
  use asperity_kinds, only: wp
  use block_replay, only: run_block_replay
  use case_file, only: case_type, expect_names
  use driver_messages, only: begin_progress, clear_progress, exit_input, exit_ok, exit_solve, progress_type, say
  use history, only: close_history, history_type, open_history
  use path_run, only: run_path
  use replay_run, only: run_replay
  implicit none
  private
  public :: run_case, short

contains

  !> Run a case into a CSV and say on standard error what came out.
  subroutine run_case(case, label, output, planes, quiet, closure, code)
    type(case_type), intent(in) :: case         !! the case
    character(len=*), intent(in) :: label       !! of the run in messages
    character(len=*), intent(in) :: output      !! file, "-": standard output
    logical, intent(in) :: planes               !! columns per plane
    logical, intent(in) :: quiet                !! no progress line, no summary
    real(wp), intent(out) :: closure            !! of the facing planes at the largest pressure, as a multiple of s_f
    integer, intent(out) :: code                !! exit code
    type(history_type) :: table
    type(progress_type) :: progress
    character(len=:), allocatable :: failure, text

    closure = 0.0_wp
    failure = ""
    code = exit_input
    call open_history(table, output, case%interface, planes .or. case%planes)
    if (table%good) then
      call begin_progress(progress, quiet)
      if (size(case%steps) > 0) then
        call run_path(case%interface, case%steps, label, table, progress)
      else if (case%replay%block > 0) then
        call run_block_replay(case%interface, case%props, case%replay%ntens, case%replay%block, case%strains, label, &
          table, progress, failure)
      else
        call run_replay(case%interface, case%props, case%replay%ntens, case%strains, label, table, progress, failure)
      end if
      call clear_progress(progress)
      call close_history(table)
    end if
    if (.not. table%good) return
    closure = largest_closure(case, -table%least_traction)

    code = exit_ok
    text = last_row(table)
    if (len(failure) > 0) then
      code = exit_solve
      call say(label // ": " // failure)
    else if (table%last%lost .neqv. case%expect%lost) then
      code = exit_solve
      if (table%last%lost) then
        call say(label // ": equilibrium lost: no solution found beyond " // text)
      else
        call say(label // ": the run ended at " // text // &
          " where a loss of equilibrium was expected (&expect in line " // integer_text(case%expect%line) // ")")
      end if
    else
      failure = unexpected(case, table)
      if (len(failure) > 0) then
        code = exit_solve
        call say(label // ": unlike &expect in line " // integer_text(case%expect%line) // ": " // failure)
      end if
    end if
    if (quiet) return
    call say(label // ": " // integer_text(table%n_rows) // " increments, " // integer_text(table%iterations) // &
      " iterations (at most " // integer_text(table%most_iterations) // "), " // &
      trim(merge("equilibrium lost after ", "ended at               ", table%last%lost)) // " " // text // &
      ", written to " // output)
  end subroutine run_case

  !> Where a run ended.
  function last_row(table) result(text)
    type(history_type), intent(in) :: table   !! rows
    character(len=:), allocatable :: text
    associate (row => table%last)
      text = "step " // integer_text(row%step) // " increment " // integer_text(row%increment) // ", s = (" // &
        short(row%s(1)) // ", " // short(row%s(2)) // ", " // short(row%s(3)) // "), t = (" // &
        short(row%traction(1)) // ", " // short(row%traction(2)) // ", " // short(row%traction(3)) // ")"
    end associate
  end function last_row

  !> Number for a message, six digits.
  pure function short(value) result(text)
    real(wp), intent(in) :: value   !! finite
    character(len=:), allocatable :: text
    character(len=16) :: buffer
    real(wp) :: rounded
    write (buffer, "(es16.5e3)") value
    read (buffer, "(f16.0)") rounded
    text = to_text(rounded)
  end function short

  !> Which values of the last row are not as expected; empty: none.
  function unexpected(case, table) result(complaint)
    type(case_type), intent(in) :: case        !! with what is expected
    type(history_type), intent(in) :: table    !! rows
    character(len=:), allocatable :: complaint
    real(wp) :: values(size(expect_names))
    integer :: i

    complaint = ""
    if (table%n_rows == 0) return
    associate (last => table%last)
      values = [last%s, last%traction, last%state([v_damage, v_stored, v_rupture, v_friction, v_work]), &
                sqrt(last%s(2)**2 + last%s(3)**2)]
    end associate
    do i = 1, size(values)
      if (.not. case%expect%given(i)) cycle
      if (abs(values(i) - case%expect%values(i)) <= case%expect%tolerance) cycle
      if (len(complaint) > 0) complaint = complaint // ", "
      complaint = complaint // trim(expect_names(i)) // " = " // to_text(values(i)) // ", expected " // &
        to_text(case%expect%values(i)) // " within " // to_text(case%expect%tolerance)
    end do
  end function unexpected

  !> Elastic closure of the inclined planes that carry a pressure alone, as a multiple of s_f.
  pure function largest_closure(case, pressure) result(closure)
    type(case_type), intent(in) :: case    !! the case
    real(wp), intent(in) :: pressure       !! >= 0, stress
    real(wp) :: closure
    real(wp) :: kc
    integer :: k
    closure = 0.0_wp
    kc = merge(case%props(p_kc), 1.0_wp, case%props(p_kc) > 0.0_wp)
    associate (pattern => case%interface%rie%pattern)
      do k = 1, pattern%n
        if (pattern%sin_theta(k) > 0.0_wp) closure = max(closure, &
          pressure*(1.0_wp - case%props(p_eta))/(pattern%gamma(k)*case%props(p_sigma0)*kc))
      end do
    end associate
  end function largest_closure

end module case_run
