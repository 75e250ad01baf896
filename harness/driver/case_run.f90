!> Run of one case: rows, comparison with the expected end, and summary.
module case_run
  use asperity_text, only: integer_text, to_text
  use asperity_contract, only: p_eta, p_kc, p_sigma0, p_w0, v_damage, v_friction, v_rupture, v_stored
  use asperity_kinds, only: wp
  use block_replay, only: run_block_replay
  use case_file, only: case_type, expect_names
  use case_warnings, only: s_f_over_height
  use driver_messages, only: exit_input, exit_ok, exit_solve, say, short
  use asperity_arc, only: explain_end
  use asperity_bounds, only: beyond_bounds
  use asperity_equilibrium_scan, only: scan_equilibria, scan_type
  use asperity_exclusion, only: exclude_equilibria, most_boxes
  use asperity_loss, only: examine_loss, loss_discontinuous, loss_type, loss_worn
  use failed_case, only: failed_type, write_failed_case
  use history, only: close_history, history_type, open_history, start_from
  use load_path, only: component_names
  use asperity_mixed_control, only: ended_limit, ended_rejected, most_updates, new_point
  use path_run, only: run_path
  use progress_line, only: begin_progress, clear_progress, progress_type
  use replay_run, only: run_replay
  implicit none
  private
  public :: run_case, failed_file

contains

  !> Run a case, write its rows to a CSV file and its result to standard error.
  subroutine run_case(case, label, output, planes, quiet, measures, code)
    type(case_type), intent(in) :: case         !! the case
    character(len=*), intent(in) :: label       !! name of the run in messages
    character(len=*), intent(in) :: output      !! file, "-": standard output
    logical, intent(in) :: planes               !! whether each plane has columns
    logical, intent(in) :: quiet                !! no progress line, no summary
    real(wp), intent(out) :: measures(3)        !! of the facing planes at the largest pressure, see largest_measures
    integer, intent(out) :: code                !! exit code
    type(history_type) :: table
    type(progress_type) :: progress
    type(failed_type) :: failed
    character(len=:), allocatable :: failure, text

    measures = 0.0_wp
    allocate (character(len=0) :: failure)
    code = exit_input
    call open_history(table, output, case%joint, planes .or. case%planes)
    if (table%good) then
      call begin_progress(progress, "rie_driver", "increments", quiet)
      if (size(case%steps) > 0) then
        call run_path(case%joint, case%state, case%steps, label, table, progress, failed)
      else
        if (case%initial%given) call start_from(table, case%joint, new_point(case%joint, case%initial%carried))
        if (case%replay%block > 0) then
          call run_block_replay(case%joint, case%props, case%replay%ntens, case%replay%block, case%initial, &
            case%strains, label, table, progress, failure)
        else
          call run_replay(case%joint, case%props, case%replay%ntens, case%initial, case%strains, label, table, &
            progress, failure)
        end if
      end if
      call clear_progress(progress)
      call close_history(table)
    end if
    if (.not. table%good) return
    measures = largest_measures(case, -table%least_traction)

    code = exit_ok
    text = last_row(table)
    if (len(failure) > 0) then
      code = exit_solve
      call say(label // ": " // failure)
    else if (table%last%lost .neqv. case%expect%lost) then
      code = exit_solve
      if (table%last%lost) then
        call say(label // ": " // trim(merge("stopped at             ", "equilibrium lost beyond", &
          failed%report%ended == ended_rejected)) // " " // text // ": " // why(case, failed))
        call keep_failed(case, failed, label, output)
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
      updates_and_snaps(table) // &
      trim(merge("equilibrium lost after ", "ended at               ", table%last%lost .and. &
      failed%report%ended /= ended_rejected)) // " " // text // &
      ", written to " // output)
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

  !> Text of the reason why no equilibrium was found: what the joint carries at most, in closed form, or else what a
  !> scan of the free separations has searched.
  function why(case, failed) result(text)
    type(case_type), intent(in) :: case        !! the case
    type(failed_type), intent(in) :: failed    !! the increment
    character(len=:), allocatable :: text
    type(loss_type) :: loss
    character(len=:), allocatable :: limit, name, range
    real(wp) :: direction(3), most
    logical :: beyond

    if (failed%arc > 0.0_wp) then
      allocate (character(len=0) :: text)
      call explain_end(failed%report%ended, text)
      text = text // tension(failed)
      return
    end if
    if (failed%report%ended == ended_rejected) then
      text = "the values to reach are out of range"
      return
    end if
    call beyond_bounds(case%joint, failed%control, failed%target, failed%last, beyond, direction, most)
    if (beyond) then
      text = "no equilibrium exists: " // carries_at_most(failed, direction, most)
      return
    end if
    call prove(case, failed, text)
    if (len(text) > 0) return
    allocate (character(len=0) :: limit)
    if (failed%report%ended == ended_limit) limit = "the increment needs more than the limit of " // &
      integer_text(most_updates) // " updates of the law; "
    call examine_loss(case%joint, failed%control, failed%report%beyond, failed%last, most_updates, loss)
    if (loss%scan%n == 0) then
      text = "the separation is out of range"
      return
    end if
    associate (scan => loss%scan)
      name = trim(component_names(scan%free))
      range = "from " // short(scan%lower) // " to " // short(scan%upper)
      if (loss%kind == loss_discontinuous) then
        text = "none found: the motion under the prescribed tractions stops at s = " // triple(loss%place) // &
          ", where the traction jumps by " // short(loss%leap) // " (" // cause_of_jump(case) // ")"
        if (scan%found) text = text // "; there is one elsewhere, at s = " // triple(scan%place)
      else if (scan%n == 1) then
        text = "the " // trim(merge("largest ", "smallest", scan%short)) // " t_" // name // &
          trim(merge(" + k s", "      ", failed%control%spring(scan%free) > 0.0_wp)) // " over " // &
          integer_text(scan%samples) // " values of s_" // name // " " // range // " is " // &
          but(scan%extreme, failed%report%beyond(scan%free)) // tension(failed)
        if (scan%found) then
          text = trim(merge("none in the sense of the missing traction; there is one elsewhere", &
            "there is an equilibrium                                          ", &
            len(limit) == 0)) // ", near s_" // name // " = " // short(scan%place(scan%free))
        else
          text = "none found: " // text
        end if
      else if (scan%found) then
        text = "the motion under the prescribed tractions reaches none; there is one elsewhere, at s = " // &
          triple(scan%place)
      else
        text = "none found: the motion under the prescribed tractions reaches none, the smallest residual over " // &
          integer_text(scan%samples) // " separations, each free one " // range // ", is " // short(scan%extreme) // &
          tension(failed)
      end if
    end associate
    if (loss%kind == loss_worn) text = text // &
      "; there is one for the facets before the motion, which wears them further"
    text = limit // text
  end function why

  !> Text of a separation.
  function triple(s) result(text)
    real(wp), intent(in) :: s(3)   !! (N, Tx, Ty)
    character(len=:), allocatable :: text
    text = "(" // short(s(1)) // ", " // short(s(2)) // ", " // short(s(3)) // ")"
  end function triple

  !> Text of what makes the law discontinuous.
  function cause_of_jump(case) result(text)
    type(case_type), intent(in) :: case        !! the case
    character(len=:), allocatable :: text
    text = "damage that was prevented sets in"
    if (case%joint%material%curved) text = "a closed facet of finite height passes its foot"
    if (case%joint%material%curved .and. case%joint%material%guard) text = text // &
      ", or damage that was prevented sets in"
  end function cause_of_jump

  !> Text of what the joint carries at most, where bounds over all separations prove that no equilibrium exists at the
  !> end of the increment, or just beyond the last one that was found; empty where they prove nothing.
  subroutine prove(case, failed, text)
    type(case_type), intent(in) :: case                      !! the case
    type(failed_type), intent(in) :: failed                  !! the increment
    character(len=:), allocatable, intent(out) :: text       !! the reason
    type(scan_type) :: scan
    real(wp) :: given(3)
    integer :: boxes, i
    logical :: proven
    do i = 1, 2
      given = merge(failed%target, failed%report%beyond, i == 1)
      call exclude_equilibria(case%joint, failed%control, given, failed%last, most_boxes, proven, boxes)
      if (proven) exit
    end do
    text = ""
    if (.not. proven) return
    text = "no equilibrium exists"
    ! the end of the increment may have one
    if (i == 2) text = text // " on the way to the end of the increment, just beyond the last one"
    if (count(failed%control%traction) == 1) then
      call scan_equilibria(case%joint, failed%control, given, failed%last, scan)
      text = text // ": the joint carries " // trim(merge("at most ", "at least", scan%short)) // " t_" // &
        trim(component_names(scan%free)) // &
        trim(merge(" + k s", "      ", failed%control%spring(scan%free) > 0.0_wp)) // " = " // &
        but(scan%extreme, given(scan%free)) // tension(failed)
    end if
    text = text // "; proved by bounds of the traction over all separations"
  end subroutine prove

  !> Text of what the joint carries at most in a direction, and of what the step asks for.
  function carries_at_most(failed, direction, most) result(text)
    type(failed_type), intent(in) :: failed    !! the increment
    real(wp), intent(in) :: direction(3)       !! unit vector (N, Tx, Ty)
    real(wp), intent(in) :: most               !! traction in this direction, stress
    character(len=:), allocatable :: text
    integer :: i
    i = maxloc(abs(direction), 1)
    if (count(abs(direction) > 0.0_wp) == 1) then
      text = "the joint carries at most t_" // trim(component_names(i)) // " = " // &
        but(sign(1.0_wp, direction(i))*most, failed%target(i))
    else
      text = "in the direction (" // short(direction(1)) // ", " // short(direction(2)) // ", " // &
        short(direction(3)) // ") the joint carries at most " // but(most, dot_product(direction, failed%target))
    end if
    text = text // tension(failed)
  end function carries_at_most

  !> Text of what is carried and what the step asks for; six digits, or all of them if six do not differ.
  function but(carried, asked) result(text)
    real(wp), intent(in) :: carried, asked     !! stress
    character(len=:), allocatable :: text
    if (short(carried) == short(asked)) then
      text = to_text(carried) // ", the step asks for " // to_text(asked)
    else
      text = short(carried) // ", the step asks for " // short(asked)
    end if
  end function but

  !> A reminder of the sign where a tension is prescribed.
  function tension(failed) result(text)
    type(failed_type), intent(in) :: failed    !! the increment
    character(len=:), allocatable :: text
    text = ""
    if (failed%control%traction(1) .and. failed%target(1) > 0.0_wp) text = "; tension is positive"
  end function tension

  !> Write the failed increment as a case of its own.
  subroutine keep_failed(case, failed, label, output)
    type(case_type), intent(in) :: case        !! the case
    type(failed_type), intent(in) :: failed    !! the increment
    character(len=*), intent(in) :: label      !! of the run
    character(len=*), intent(in) :: output     !! file with the rows
    character(len=:), allocatable :: path
    logical :: written
    if (.not. failed%happened) return
    path = failed_file(output)
    call write_failed_case(path, case%props, failed, written)
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

  !> Text of the values of the last row that are not as expected; empty: none.
  function unexpected(case, table) result(complaint)
    type(case_type), intent(in) :: case        !! with what is expected
    type(history_type), intent(in) :: table    !! rows
    character(len=:), allocatable :: complaint
    real(wp) :: values(size(expect_names))
    integer :: i

    complaint = ""
    if (table%n_rows == 0) return
    associate (last => table%last)
      values = [last%s, last%traction, last%state([v_damage, v_stored, v_rupture, v_friction]), last%work, &
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

  !> Of one inclined plane that carries the whole pressure: elastic closure over s_f, elastic closure over the asperity
  !> height (0 without a height), elastic energy of the friction over W0 (0 without wear).
  pure function largest_measures(case, pressure) result(measures)
    type(case_type), intent(in) :: case    !! the case
    real(wp), intent(in) :: pressure       !! >= 0, stress
    real(wp) :: measures(3)
    real(wp) :: gamma, kc
    measures = 0.0_wp
    kc = merge(case%props(p_kc), 1.0_wp, case%props(p_kc) > 0.0_wp)
    associate (pattern => case%joint%pattern, material => case%joint%material)
      if (.not. any(pattern%sin_theta(:pattern%n) > 0.0_wp)) return
      gamma = minval(pattern%gamma(:pattern%n), mask=pattern%sin_theta(:pattern%n) > 0.0_wp)
      measures(1) = pressure*(1.0_wp - case%props(p_eta))/(gamma*case%props(p_sigma0)*kc)
      measures(2) = measures(1)*s_f_over_height(case)
      if (.not. case%props(p_w0) > 0.0_wp) return
      measures(3) = (material%mu*pressure/gamma)**2/(2.0_wp*material%k_t*case%props(p_w0))
    end associate
  end function largest_measures

end module case_run
