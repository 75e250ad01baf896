!> Soak run of the mixed solver: random interfaces, loads and increments. The run reports the solved fraction and its
!> cost, judges every row, and checks by a scan that no equilibrium exists where the solver finds none.
program solver_soak
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text, to_text
  use progress_line, only: start_progress, clear_progress, progress_type, show_progress
  use soak_options, only: options_type, read_options
  use solver_judge, only: judge_start
  use solver_sample, only: all_increments, away, completed, describe, draw_sample, draw_state, increments, limited, &
    n_counts, none_found, outcome_type, run_sample, sample_type, snaps, stopped, stuck, unbalanced, unexplained, &
    unreported, updates, wrong
  implicit none

  !> Largest number of printed failures.
  integer, parameter :: most_complaints = 50
  type(sample_type) :: sample
  type(outcome_type) :: outcome
  type(progress_type) :: progress
  type(options_type) :: options
  integer(int64) :: seed, total(n_counts), unbalanced_states
  real(wp) :: worst_state
  integer :: complaints, failed, i, most_updates, ran

  call read_options("solver_soak", 10000, options)
  call start_progress(progress, "solver_soak", "samples", options%quiet)
  complaints = 0
  unbalanced_states = 0_int64
  worst_state = 0.0_wp
  ran = 0
  failed = 0
  most_updates = 0
  total = 0_int64
  seed = options%seed
  do i = 1, options%samples
    call draw_sample(seed, sample)
    if (options%only > 0 .and. i /= options%only) cycle
    ran = ran + 1
    call run_sample(sample, outcome)
    total = total + outcome%counts
    most_updates = max(most_updates, outcome%most_updates)
    ! with viscous damage, guard or wear the limit of updates is no failure: the driver reports it
    if (sum(outcome%counts([wrong, unreported, unbalanced])) > 0_int64 .or. (outcome%counts(unexplained) > 0_int64 &
      .and. .not. (outcome%counts(limited) > 0_int64 .and. outcome%slow))) failed = failed + 1
    if (outcome%counts(wrong) > 0_int64 .or. len_trim(outcome%why) > 0 .or. options%only > 0) then
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
  call write_table()
  failed = int(min(int(ran, int64), failed + unbalanced_states))
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

  !> Write the results.
  subroutine write_table()
    real(wp) :: samples_percent
    samples_percent = 100.0_wp/real(max(ran, 1), wp)
    write (output_unit, "(a, i0, a)") "solver_soak: ", ran, " samples"
    write (output_unit, "(4x, 6a14)") "paths done", "none found", "increments", "updates/incr", "most updates", "snaps"
    write (output_unit, "(4x, 4(f13.3, 1x), 2i14)") samples_percent*real(total([completed, none_found]), wp), &
      100.0_wp*real(total(increments), wp)/real(total(all_increments), wp), &
      real(total(updates), wp)/real(max(total(increments), 1_int64), wp), most_updates, total(snaps)
    write (output_unit, "(4x, 6(a, i0))") "(per cent of the samples, of the increments); rows that are no " // &
      "equilibrium ", total(wrong), ", losses not explained ", total(unexplained), ", limit of updates reached ", &
      total(limited), " (there is an equilibrium: ", total(stuck), "), viscous ones opened without bound ", &
      total(away), ", stopped where the law is discontinuous ", total(stopped)
    write (output_unit, "(4x, 2(a, i0))") "rows that jump without a report ", total(unreported), &
      ", whose energies do not balance ", total(unbalanced)
    if (options%only == 0) write (output_unit, "(4x, 2(i0, a), es8.1)") ran, &
      " initial states, of which do not balance ", unbalanced_states, ", largest imbalance ", worst_state
  end subroutine write_table

end program solver_soak
