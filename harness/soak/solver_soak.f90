!> Soak run of the mixed solver: random interfaces, loads and increments. The run reports the solved fraction and its
!> cost, judges every row, and checks by a scan that no equilibrium exists where the solver finds none. With --across
!> the samples are slips free across of joints with a height alone, where a loss is scanned within s_f.
program solver_soak
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text
  use progress_line, only: start_progress, clear_progress, progress_type, show_progress
  use soak_options, only: options_type, read_options
  use solver_sample, only: all_increments, away, completed, describe, draw_sample, increments, limited, &
    n_counts, near_equilibria, none_found, outcome_type, run_sample, sample_type, snaps, stopped, stuck, &
    unbalanced, unexplained, unreported, updates, wrong
  implicit none

  !> Largest number of printed samples beside those that fail.
  integer, parameter :: most_complaints = 50
  type(sample_type) :: sample
  type(outcome_type) :: outcome
  type(progress_type) :: progress
  type(options_type) :: options
  integer(int64) :: seed, total(n_counts)
  integer :: complaints, failed, i, most_updates, ran
  logical :: fails

  call read_options("solver_soak", 10000, options, has_across=.true.)
  call start_progress(progress, "solver_soak", "samples", options%quiet)
  complaints = 0
  ran = 0
  failed = 0
  most_updates = 0
  total = 0_int64
  seed = options%seed
  do i = 1, options%samples
    call draw_sample(seed, sample, across=options%across)
    if (options%only > 0 .and. i /= options%only) cycle
    ran = ran + 1
    call run_sample(sample, outcome)
    total = total + outcome%counts
    most_updates = max(most_updates, outcome%most_updates)
    ! with viscous damage, guard or wear the limit of updates is no failure: the driver reports it
    fails = sum(outcome%counts([wrong, unreported, unbalanced])) > 0_int64 .or. (outcome%counts(unexplained) > 0_int64 &
      .and. .not. (outcome%counts(limited) > 0_int64 .and. outcome%slow))
    if (fails) failed = failed + 1
    if (fails .or. len_trim(outcome%why) > 0 .or. options%only > 0) then
      complaints = complaints + 1
      if (fails .or. complaints <= most_complaints) then
        call clear_progress(progress)
        write (error_unit, "(a)") "solver_soak: sample " // integer_text(i) // ": " // describe(sample) // ": " // &
          trim(outcome%why)
      end if
    end if
    call show_progress(progress, "", i, options%samples)
  end do
  call clear_progress(progress)
  call write_table()
  if (failed > 0) write (error_unit, "(a)") "solver_soak: FAILED: rows that are no equilibrium, jump without a " // &
    "report or do not balance, or losses that are not explained"
  ! every sample counts as a test
  write (output_unit, "(i0, a, i0, a)") ran - failed, " passed, ", failed, " failed"
  if (failed > 0) stop 1

contains

  !> Write the results.
  subroutine write_table()
    real(wp) :: samples_percent
    samples_percent = 100.0_wp/real(max(ran, 1), wp)
    write (output_unit, "(a, i0, a)") "solver_soak: ", ran, " samples"
    write (output_unit, "(4x, 6a14)") "paths done", "none found", "increments", "updates/incr", "most updates", "snaps"
    write (output_unit, "(4x, 4(f13.3, 1x), 2i14)") samples_percent*real(total([completed, none_found]), wp), &
      100.0_wp*real(total(increments), wp)/real(total(all_increments), wp), &
      real(total(updates), wp)/real(max(total(increments), 1_int64), wp), most_updates, total(snaps)
    write (output_unit, "(4x, 7(a, i0))") "(per cent of the samples, of the increments); rows that are no " // &
      "equilibrium ", total(wrong), ", losses not explained ", total(unexplained), ", limit of updates reached ", &
      total(limited), " (there is an equilibrium: ", total(stuck), "), losses with a stable equilibrium within s_f ", &
      total(near_equilibria), ", viscous ones opened without bound ", &
      total(away), ", stopped where the law is discontinuous ", total(stopped)
    write (output_unit, "(4x, 2(a, i0))") "rows that jump without a report ", total(unreported), &
      ", whose energies do not balance ", total(unbalanced)
  end subroutine write_table

end program solver_soak
