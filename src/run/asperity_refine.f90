!> Load path to a tolerance: all increments are halved until the rows of successive runs agree, then rows are left out.
module asperity_refine
  use asperity_checks, only: bounded
  use asperity_contract, only: v_friction, v_rupture, v_stored
  use asperity_equations, only: point_type
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_kinds, only: wp
  use asperity_load_path, only: start_run, next_row, row_type, run_type, set_point
  use asperity_point_law, only: point_law
  use asperity_steps, only: step_type
  use asperity_text, only: append, integer_text, short, to_text
  use asperity_tolerances, only: largest_tolerance, least_increments, least_tolerance, measured_part, &
    most_increments, most_values, compressed_part, unbonded, values_of_row
  implicit none
  private
  public :: refine_path, explain_tolerance

  !> Compared numbers of a row: separation, traction, work, stored and dissipated energies, the last three in STATEV.
  integer, parameter :: n_values = 10, ledger(3) = [v_stored, v_rupture, v_friction]

contains

  !> Add an error if a tolerance is out of range, or if a path has none.
  pure subroutine explain_tolerance(tolerance, steps, errors, place)
    real(wp), intent(in) :: tolerance                         !! relative
    type(step_type), intent(in) :: steps(:)                   !! the load path
    type(errors_type), intent(inout) :: errors                !! errors are added
    type(error_type), intent(in) :: place                     !! of an error in it
    type(error_type) :: value
    real(wp) :: increments
    integer :: i
    logical :: good
    good = bounded(tolerance, largest_tolerance)
    if (good) good = tolerance >= least_tolerance
    if (.not. good) then
      value = place
      value%name = "tolerance"
      value%value = to_text(tolerance)
      call fail(errors, value, "expected " // to_text(least_tolerance) // " to " // to_text(largest_tolerance))
    end if
    increments = 0.0_wp
    do i = 1, size(steps)
      increments = increments + sum(real(max(least_increments, steps(i)%increments), wp))
    end do
    if (4.0_wp*increments > real(most_increments, wp)) call fail(errors, place, "tolerance with " // &
      to_text(increments) // " increments: expected at most " // integer_text(most_increments/4) // &
      ", which are halved twice or more")
    if (any(steps%arc > 0.0_wp)) call fail(errors, place, "tolerance with follow = 'branch': expected arc, " // &
      "the longest step along the branch")
  end subroutine explain_tolerance

  !> Begin a path or, with a tolerance, run it: the largest distance of the rows of a run from straight lines between
  !> those of a run with half as many increments is small, and was at most twice as large in the run before.
  !>
  !> The tolerance is relative to the largest traction (at least the strength), separation (at least s_f) and work (at
  !> least that of the bond). The distance is that between the curves, so that a jump may move by a small part of the
  !> path.
  subroutine refine_path(law, steps, start, p, tolerance, run, message)
    class(point_law), intent(in) :: law                       !! the law
    type(step_type), intent(in) :: steps(:)                   !! the load path, checked
    type(point_type), intent(in) :: start                     !! the point at its start
    real(wp), intent(in) :: p                                 !! water pressure there, stress
    real(wp), intent(in) :: tolerance                         !! admissible, or 0: increments as they are given
    type(run_type), intent(out) :: run                        !! no row yet; or the finest one, at its end, with rows
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended if the tolerance is not reached
    type(step_type) :: finer(size(steps))
    type(row_type), allocatable :: coarse(:), fine(:)
    real(wp), allocatable :: values(:, :)
    real(wp) :: earlier, error, least, scales(n_values)
    integer :: i
    if (.not. tolerance > 0.0_wp) then
      call start_run(law, steps, run, start, p)
      return
    end if
    least = merge(1.0_wp, unbonded, law%bonded)
    finer = steps
    do i = 1, size(steps)
      finer(i)%increments = max(least_increments, steps(i)%increments)
    end do
    call run_rows(law, finer, start, p, run, fine)
    error = huge(error)
    ! gfortran reads the bounds of what is assigned to
    allocate (values(0, 0))
    do
      call move_alloc(fine, coarse)
      do i = 1, size(steps)
        finer(i)%increments = 2*finer(i)%increments
      end do
      call run_rows(law, finer, start, p, run, fine)
      values = table_of(fine)
      scales(1:3) = max(least*law%s_f, maxval(abs(values(1:3, :))))
      scales(4:6) = max(least*law%stress, maxval(abs(values(4:6, :))))
      scales(7:) = max(least*0.5_wp*law%s_f*law%stress, maxval(abs(values(7:, :))))
      values = values/spread(scales, 2, size(fine))
      earlier = error
      error = distance_of(coarse, fine, table_of(coarse)/spread(scales, 2, size(coarse)), values)
      if (max(error, 0.5_wp*earlier) <= measured_part*tolerance) exit
      if (2.0_wp*real(run%total, wp)*(values_of_row + real(size(start%state), wp)) > most_values) then
        call append(message, "tolerance = " // to_text(tolerance) // ": the rows of " // integer_text(run%total/2) // &
          " and of " // integer_text(run%total) // " increments still differ by " // &
          short(max(error, 0.5_wp*earlier)) // " of the largest values: expected a tolerance of at least " // &
          short(max(error, 0.5_wp*earlier)/measured_part))
        exit
      end if
    end do
    call compress_rows(fine, values, compressed_part*tolerance, run%rows)
  end subroutine refine_path

  !> The start of a path and its rows.
  subroutine run_rows(law, steps, start, p, run, rows)
    class(point_law), intent(in) :: law                     !! the law
    type(step_type), intent(in) :: steps(:)                 !! the load path
    type(point_type), intent(in) :: start                   !! the point at its start
    real(wp), intent(in) :: p                               !! water pressure there, stress
    type(run_type), intent(out) :: run                      !! the run, at its end
    type(row_type), allocatable, intent(out) :: rows(:)     !! the start, then the rows; the last one may be lost
    type(row_type) :: row
    integer :: n
    logical :: has_row
    call start_run(law, steps, run, start, p)
    allocate (rows(run%total + 1))
    call set_point(rows(1), start, p)
    n = 1
    do
      call next_row(run, row, has_row)
      if (.not. has_row) exit
      n = n + 1
      rows(n) = row
    end do
    if (n < size(rows)) rows = rows(:n)
  end subroutine run_rows

  !> Compared numbers of rows.
  pure function table_of(rows) result(values)
    type(row_type), intent(in) :: rows(:)         !! rows
    real(wp) :: values(n_values, size(rows))
    integer :: i
    do i = 1, size(rows)
      values(:, i) = [rows(i)%s, rows(i)%traction, rows(i)%work, rows(i)%state(ledger)]
    end do
  end function table_of

  !> Largest distance of the rows of a run from the straight lines between those of a run with half as many increments,
  !> in the largest component of the shortest vector.
  pure function distance_of(coarse, fine, lines, values) result(largest)
    type(row_type), intent(in) :: coarse(0:), fine(0:)               !! rows of both runs, from the start on
    real(wp), intent(in) :: lines(:, 0:), values(:, 0:)              !! their compared numbers
    real(wp) :: largest
    real(wp) :: distance, fraction
    integer :: i, j, k, m, n
    m = ubound(coarse, 1)
    n = ubound(fine, 1)
    ! both end where equilibrium is lost, or none does
    largest = merge(huge(largest), 0.0_wp, coarse(m)%lost .neqv. fine(n)%lost)
    if (coarse(m)%lost) largest = max(largest, maxval(abs(lines(:, m) - values(:, n))))
    do i = 1, n
      j = min((i + 1)/2, m)
      distance = huge(distance)
      do k = max(1, j - 1), min(m, j + 1)
        associate (a => lines(:, k - 1), chord => lines(:, k) - lines(:, k - 1), x => values(:, i))
          fraction = min(1.0_wp, max(0.0_wp, dot_product(x - a, chord)/max(tiny(fraction), sum(chord**2))))
          distance = min(distance, maxval(abs(a + fraction*chord - x)))
        end associate
      end do
      largest = max(largest, distance)
    end do
  end function distance_of

  !> Swinging-door compression: leave out rows as long as straight lines between the others stay within a distance. The
  !> slopes of the lines from the last row that stays are confined by each row that is passed. Rows with events, those
  !> before a snap, and those at targets stay.
  pure subroutine compress_rows(fine, values, tolerance, rows)
    type(row_type), intent(in) :: fine(0:)                  !! the start and all rows
    real(wp), intent(in) :: values(:, 0:)                   !! their compared numbers
    real(wp), intent(in) :: tolerance                       !! largest distance
    type(row_type), allocatable, intent(out) :: rows(:)     !! those that stay, with new numbers of their increments
    logical :: stays(0:ubound(fine, 1))
    real(wp), dimension(size(values, 1)) :: highest, lowest, slope
    real(wp) :: length
    integer :: i, last, n
    n = ubound(fine, 1)
    stays = len_trim(fine%events) > 0 .or. .not. abs(fine%position - anint(fine%position)) > 0.0_wp
    stays(:n - 1) = stays(:n - 1) .or. fine(1:)%report%snaps > 0
    stays(n) = .true.
    last = 0
    do i = 1, n
      if (.not. stays(i - 1)) then
        slope = (values(:, i) - values(:, last))/max(fine(i)%position - fine(last)%position, epsilon(length))
        stays(i - 1) = any(slope < lowest .or. slope > highest)
      end if
      if (stays(i - 1)) then
        last = i - 1
        lowest = -huge(lowest)
        highest = huge(highest)
      end if
      length = max(fine(i)%position - fine(last)%position, epsilon(length))
      slope = (values(:, i) - values(:, last))/length
      lowest = max(lowest, slope - tolerance/length)
      highest = min(highest, slope + tolerance/length)
    end do
    rows = pack(fine(1:), stays(1:))
    rows%increment = 1
    do i = 2, size(rows)
      if (rows(i)%step == rows(i - 1)%step) rows(i)%increment = rows(i - 1)%increment + 1
    end do
  end subroutine compress_rows

end module asperity_refine
