!> Soak run of the mixed solver: random interfaces, loads and increments are solved by Newton's method alone, with
!> halved increments, and by the full solver. The run reports the solved fraction and its cost, and checks by a scan
!> that no equilibrium exists where the full solver finds none.
program solver_soak
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text, to_text
  use asperity_mixed_control, only: full_solver
  use progress_line, only: begin_progress, clear_progress, progress_type, show_progress
  use soak_options, only: options_type, read_options
  use solver_judge, only: judge_start
  use solver_sample, only: describe, draw_sample, draw_state, outcome_type, run_sample, sample_type
  implicit none

  integer, parameter :: n_methods = 3
  character(len=*), parameter :: names(n_methods) = [character(len=14) :: "plain Newton", "halved Newton", &
    "full solver"]
  !> Largest number of printed failures.
  integer, parameter :: most_complaints = 50
  !> Sums over the samples, by method.
  type :: sum_type
    integer(int64) :: completed = 0, none_found = 0, increments = 0, all_increments = 0, updates = 0, snaps = 0, &
      missed = 0, wrong = 0, unexplained = 0, limited = 0, away = 0, stuck = 0, stopped = 0, worn = 0, &
      unreported = 0, unbalanced = 0, failed = 0
    integer :: most_updates = 0
    ! by the number of free separations; without viscous damage, guard, finite height and wear, and with them
    integer(int64) :: lost(3, 2) = 0, proven(3, 2) = 0
    integer :: most_boxes = 0   ! of a proof
  end type sum_type
  type(sum_type) :: total(n_methods)
  type(sample_type) :: sample
  type(outcome_type) :: outcome(n_methods)
  type(progress_type) :: progress
  integer(int64) :: seed
  integer(int64) :: unbalanced_states
  real(wp) :: worst_state
  integer :: complaints, failed, i, method, ran
  type(options_type) :: options

  call read_options("solver_soak", 10000, "[--plain] [--folds] [--csv FILE] ", options)
  call begin_progress(progress, "solver_soak", "samples", options%quiet)
  complaints = 0
  unbalanced_states = 0_int64
  worst_state = 0.0_wp
  ran = 0
  seed = options%seed
  do i = 1, options%samples
    call draw_sample(seed, .not. options%plain, options%folds, sample)
    if (options%only > 0 .and. i /= options%only) cycle
    ran = ran + 1
    do method = 1, n_methods
      call run_sample(sample, method, outcome(method))
    end do
    do method = 1, n_methods
      call add(total(method), outcome(method), method, outcome(full_solver)%snaps)
    end do
    if (outcome(full_solver)%wrong .or. len_trim(outcome(full_solver)%why) > 0) then
      complaints = complaints + 1
      if (complaints <= most_complaints) then
        call clear_progress(progress)
        write (error_unit, "(a)") "solver_soak: sample " // integer_text(i) // ": " // describe(sample) // ": " // &
          trim(outcome(full_solver)%why)
      end if
    end if
    call show_progress(progress, "", i, options%samples)
  end do
  call clear_progress(progress)
  if (options%only == 0) call run_states()
  call write_table(output_unit, "    ")
  if (len_trim(options%csv) > 0) call write_csv()
  failed = int(min(int(ran, int64), total(full_solver)%failed + unbalanced_states))
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
      call judge_start(sample%joint, sample%state, largest, seed, defect)
      worst_state = max(worst_state, defect)
      if (defect <= largest) cycle
      unbalanced_states = unbalanced_states + 1
      if (unbalanced_states <= most_complaints) write (error_unit, "(a)") "solver_soak: state " // integer_text(k) // &
        ": " // describe(sample) // ": energy not balanced " // to_text(defect)
    end do
  end subroutine run_states

  !> Add an outcome to the sums.
  subroutine add(sums, one, by, folds)
    type(sum_type), intent(inout) :: sums      !! of a method
    type(outcome_type), intent(in) :: one      !! of a sample
    integer, intent(in) :: by                  !! the method
    integer, intent(in) :: folds               !! snaps of the full solver
    integer :: kind
    sums%completed = sums%completed + merge(1, 0, one%completed)
    sums%none_found = sums%none_found + merge(1, 0, one%none_found)
    sums%increments = sums%increments + one%increments
    sums%all_increments = sums%all_increments + one%all_increments
    sums%updates = sums%updates + one%updates
    sums%snaps = sums%snaps + one%snaps
    sums%missed = sums%missed + merge(1, 0, by /= full_solver .and. one%completed .and. folds > 0)
    sums%wrong = sums%wrong + merge(1, 0, one%wrong)
    sums%unexplained = sums%unexplained + merge(1, 0, by == full_solver .and. .not. one%explained)
    if (one%free > 0) then
      kind = merge(1, 2, one%has_bounds)
      sums%lost(one%free, kind) = sums%lost(one%free, kind) + 1
      sums%proven(one%free, kind) = sums%proven(one%free, kind) + merge(1, 0, one%proven)
      sums%most_boxes = max(sums%most_boxes, merge(one%boxes, 0, one%proven))
    end if
    sums%stopped = sums%stopped + merge(1, 0, one%stopped)
    sums%worn = sums%worn + merge(1, 0, one%worn)
    sums%limited = sums%limited + merge(1, 0, one%limited)
    sums%stuck = sums%stuck + merge(1, 0, by == full_solver .and. one%limited .and. .not. one%explained)
    sums%unreported = sums%unreported + one%unreported
    sums%unbalanced = sums%unbalanced + one%unbalanced
    sums%away = sums%away + merge(1, 0, one%away)
    ! with viscous damage, guard or wear the limit of updates is no failure: the driver reports it
    sums%failed = sums%failed + merge(1, 0, by == full_solver .and. (one%wrong .or. one%unreported > 0 .or. &
      one%unbalanced > 0 .or. .not. (one%explained .or. (one%limited .and. one%slow))))
    sums%most_updates = max(sums%most_updates, one%most_updates)
  end subroutine add

  !> Write the results as a table.
  subroutine write_table(unit, indent)
    integer, intent(in) :: unit                !! connected
    character(len=*), intent(in) :: indent     !! before the lines
    integer :: k
    write (unit, "(a, i0, a)") "solver_soak: ", ran, " samples"
    write (unit, "(a, a14, 7a14)") indent, "", "paths done", "none found", "increments", "updates/incr", &
      "most updates", "snaps", "folds missed"
    do k = 1, n_methods
      associate (s => total(k))
        write (unit, "(a, a14, 2(f13.3, 1x), f13.3, 1x, f14.3, 3i14)") indent, names(k), percent(s%completed), &
          percent(s%none_found), 100.0_wp*real(s%increments, wp)/real(s%all_increments, wp), &
          real(s%updates, wp)/real(max(s%increments, 1_int64), wp), s%most_updates, s%snaps, s%missed
      end associate
    end do
    write (unit, "(2a, 7(a, i0))") indent, "(per cent of the samples, of the increments); full solver: ", &
      "rows that are no equilibrium ", total(full_solver)%wrong, ", losses not explained ", &
      total(full_solver)%unexplained, ", limit of updates reached ", total(full_solver)%limited, &
      " (there is an equilibrium: ", total(full_solver)%stuck, &
      "), viscous ones opened without bound ", total(full_solver)%away, ", stopped where the law is discontinuous ", &
      total(full_solver)%stopped, ", worn by the motion ", total(full_solver)%worn
    associate (s => total(full_solver))
      do k = 1, 2
        write (unit, "(4a, 3(a, i0, a, i0))") indent, "losses that bounds prove, ", &
          trim(merge("without", "with   ", k == 1)), " viscous damage, guard, height or wear:", &
          " with one free separation ", s%proven(1, k), " of ", s%lost(1, k), &
          ", two ", s%proven(2, k), " of ", s%lost(2, k), ", three ", s%proven(3, k), " of ", s%lost(3, k)
      end do
      write (unit, "(2a, i0)") indent, "largest number of boxes of such a proof ", s%most_boxes
    end associate
    write (unit, "(2a, 2(i0, a))") indent, "rows that jump without a report ", total(full_solver)%unreported, &
      ", whose energies do not balance ", total(full_solver)%unbalanced
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
    integer :: k, status, unit
    open (newunit=unit, file=trim(options%csv), status="replace", action="write", iostat=status, iomsg=reason)
    if (status /= 0) then
      write (error_unit, "(a)") "solver_soak: " // trim(options%csv) // ": " // trim(reason)
      stop 1
    end if
    write (unit, "(a)") "method,samples,completed,none_found,unexplained,wrong,increments,all_increments,updates," // &
      "most_updates_of_an_increment,snaps,folds_missed,limit_met,limit_met_but_equilibrium,driven_apart," // &
      "jumps_not_reported,rows_not_balanced,stopped,worn"
    do k = 1, n_methods
      associate (s => total(k))
        write (unit, "(a, 18(',', i0))") trim(names(k)), ran, s%completed, s%none_found, s%unexplained, s%wrong, &
          s%increments, s%all_increments, s%updates, s%most_updates, s%snaps, s%missed, s%limited, &
          s%stuck, s%away, s%unreported, s%unbalanced, s%stopped, s%worn
      end associate
    end do
    close (unit)
  end subroutine write_csv

end program solver_soak
