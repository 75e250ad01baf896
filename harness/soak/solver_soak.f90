!> Soak run of the mixed solver: random interfaces, loads and increments. The run reports the solved fraction and its
!> cost, judges every row, and checks by a scan that no equilibrium exists where the solver finds none.
program solver_soak
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text, to_text
  use progress_line, only: start_progress, clear_progress, progress_type, show_progress
  use soak_options, only: options_type, read_options
  use solver_judge, only: judge_start
  use solver_sample, only: any_kind, closed, describe, draw_sample, draw_state, folds, outcome_type, run_sample, &
    sample_type
  implicit none

  !> Largest number of printed failures.
  integer, parameter :: most_complaints = 50
  !> Sums over the samples, by method.
  type :: sum_type
    integer(int64) :: completed = 0, none_found = 0, increments = 0, all_increments = 0, updates = 0, snaps = 0, &
      wrong = 0, unexplained = 0, limited = 0, away = 0, stuck = 0, stopped = 0, &
      unreported = 0, unbalanced = 0, failed = 0
    integer :: most_updates = 0
  end type sum_type
  type(sum_type) :: total
  type(sample_type) :: sample
  type(outcome_type) :: outcome
  type(progress_type) :: progress
  integer(int64) :: seed
  integer(int64) :: unbalanced_states
  real(wp) :: worst_state
  integer :: complaints, failed, i, ran
  type(options_type) :: options

  call read_options("solver_soak", 10000, "[--folds] [--closed] [--csv FILE] ", options)
  call start_progress(progress, "solver_soak", "samples", options%quiet)
  complaints = 0
  unbalanced_states = 0_int64
  worst_state = 0.0_wp
  ran = 0
  seed = options%seed
  do i = 1, options%samples
    call draw_sample(seed, merge(folds, merge(closed, any_kind, options%closed), options%folds), sample)
    if (options%only > 0 .and. i /= options%only) cycle
    ran = ran + 1
    call run_sample(sample, outcome)
    call add(total, outcome)
    if (outcome%wrong .or. len_trim(outcome%why) > 0 .or. options%only > 0) then
      complaints = complaints + 1
      if (complaints <= most_complaints) then
        call clear_progress(progress)
        write (error_unit, "(a)") "solver_soak: sample " // integer_text(i) // ": " // describe(sample) // ": " // &
          trim(outcome%why)
      end if
    end if
    call show_progress(progress, "", i, options%samples)
  end do
  call clear_progress(progress)
  if (options%only == 0) call run_states()
  call write_table(output_unit, "    ")
  if (len_trim(options%csv) > 0) call write_csv()
  failed = int(min(int(ran, int64), total%failed + unbalanced_states))
  if (failed > 0) write (error_unit, "(a)") "solver_soak: FAILED: rows that are no equilibrium, jump without a " // &
    "report or do not balance, or losses that are not explained"
  ! every sample counts as a test
  write (output_unit, "(i0, a, i0, a)") ran - failed, " passed, ", failed, " failed"
  if (failed > 0) stop 1

contains

  !> Draw as many initial states as samples, and check that their energies balance from the start on.
  subroutine run_states()
    !> Largest admissible imbalance, relative to K s0^2 or to the terms of the balance.
    real(wp), parameter :: largest = 1.0e-6_wp
    real(wp) :: defect
    integer :: k
    do k = 1, options%samples
      call draw_state(seed, sample)
      call judge_start(sample%law, sample%state, largest, seed, defect)
      worst_state = max(worst_state, defect)
      if (defect <= largest) cycle
      unbalanced_states = unbalanced_states + 1
      if (unbalanced_states <= most_complaints) write (error_unit, "(a)") "solver_soak: state " // integer_text(k) // &
        ": " // describe(sample) // ": energy not balanced " // to_text(defect)
    end do
  end subroutine run_states

  !> Add an outcome to the sums.
  subroutine add(sums, one)
    type(sum_type), intent(inout) :: sums      !! sums so far
    type(outcome_type), intent(in) :: one      !! of a sample
    sums%completed = sums%completed + merge(1, 0, one%completed)
    sums%none_found = sums%none_found + merge(1, 0, one%none_found)
    sums%increments = sums%increments + one%increments
    sums%all_increments = sums%all_increments + one%all_increments
    sums%updates = sums%updates + one%updates
    sums%snaps = sums%snaps + one%snaps
    sums%wrong = sums%wrong + merge(1, 0, one%wrong)
    sums%unexplained = sums%unexplained + merge(1, 0, .not. one%explained)
    sums%stopped = sums%stopped + merge(1, 0, one%stopped)
    sums%limited = sums%limited + merge(1, 0, one%limited)
    sums%stuck = sums%stuck + merge(1, 0, one%limited .and. .not. one%explained)
    sums%unreported = sums%unreported + one%unreported
    sums%unbalanced = sums%unbalanced + one%unbalanced
    sums%away = sums%away + merge(1, 0, one%away)
    ! with viscous damage, guard or wear the limit of updates is no failure: the driver reports it
    sums%failed = sums%failed + merge(1, 0, (one%wrong .or. one%unreported > 0 .or. &
      one%unbalanced > 0 .or. .not. (one%explained .or. (one%limited .and. one%slow))))
    sums%most_updates = max(sums%most_updates, one%most_updates)
  end subroutine add

  !> Write the results as a table.
  subroutine write_table(unit, indent)
    integer, intent(in) :: unit                !! connected
    character(len=*), intent(in) :: indent     !! before the lines
    write (unit, "(a, i0, a)") "solver_soak: ", ran, " samples"
    write (unit, "(a, 6a14)") indent, "paths done", "none found", "increments", "updates/incr", "most updates", "snaps"
    associate (s => total)
      write (unit, "(a, 4(f13.3, 1x), 2i14)") indent, percent(s%completed), percent(s%none_found), &
        100.0_wp*real(s%increments, wp)/real(s%all_increments, wp), &
        real(s%updates, wp)/real(max(s%increments, 1_int64), wp), s%most_updates, s%snaps
    end associate
    write (unit, "(2a, 6(a, i0))") indent, "(per cent of the samples, of the increments); ", &
      "rows that are no equilibrium ", total%wrong, ", losses not explained ", total%unexplained, &
      ", limit of updates reached ", total%limited, " (there is an equilibrium: ", total%stuck, &
      "), viscous ones opened without bound ", total%away, ", stopped where the law is discontinuous ", total%stopped
    write (unit, "(2a, 2(i0, a))") indent, "rows that jump without a report ", total%unreported, &
      ", whose energies do not balance ", total%unbalanced
    if (options%only == 0) write (unit, "(a, 2(i0, a), es8.1)") indent, ran, &
      " initial states, of which do not balance ", unbalanced_states, ", largest imbalance ", worst_state
  end subroutine write_table

  !> Percentage of the samples.
  pure function percent(n) result(share)
    integer(int64), intent(in) :: n   !! samples
    real(wp) :: share
    share = 100.0_wp*real(n, wp)/real(max(ran, 1), wp)
  end function percent

  !> Write the results as CSV.
  subroutine write_csv()
    integer, parameter :: longest = 200
    character(len=longest) :: reason
    integer :: status, unit
    open (newunit=unit, file=trim(options%csv), status="replace", action="write", iostat=status, iomsg=reason)
    if (status /= 0) then
      write (error_unit, "(a)") "solver_soak: " // trim(options%csv) // ": " // trim(reason)
      stop 1
    end if
    write (unit, "(a)") "samples,completed,none_found,unexplained,wrong,increments,all_increments,updates," // &
      "most_updates_of_an_increment,snaps,limit_met,limit_met_but_equilibrium,driven_apart," // &
      "jumps_not_reported,rows_not_balanced,stopped"
    associate (s => total)
      write (unit, "(i0, 15(',', i0))") ran, s%completed, s%none_found, s%unexplained, s%wrong, s%increments, &
        s%all_increments, s%updates, s%most_updates, s%snaps, s%limited, s%stuck, s%away, s%unreported, s%unbalanced, &
        s%stopped
    end associate
    close (unit)
  end subroutine write_csv

end program solver_soak
