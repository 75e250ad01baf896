!> Load path to a tolerance: all increments are halved until the rows of successive runs agree, then rows are left out.
module asperity_refine
  use asperity_checks, only: bounded
  use asperity_contract, only: v_friction, v_rupture, v_stored
  use asperity_control_point, only: point_type
  use asperity_interface, only: interface_type, start_damage
  use asperity_kinds, only: wp
  use asperity_load_path, only: start_run, next_row, row_type, run_type
  use asperity_point_law, only: point_law
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_steps, only: step_type
  use asperity_text, only: append, integer_text, short, to_text
  implicit none
  private
  public :: refine_path, explain_tolerance

  !> Admissible tolerances.
  real(wp), parameter :: least_tolerance = 1.0e-8_wp, largest_tolerance = 0.1_wp
  !> Smallest number of increments to a target in the first run: fewer may agree by chance.
  integer, parameter :: least_parts = 8
  !> Parts of the tolerance for the distance between two runs and for the rows that are left out; the rest is for what
  !> both runs have in common.
  real(wp), parameter :: measured_part = 0.4_wp, thinned_part = 0.4_wp
  !> Largest number of increments of a path; its rows need some 100 MB for a pattern of 65 planes.
  integer, parameter, public :: most_parts = 100000
  !> Positions of the stored and the dissipated energies in STATEV.
  integer, parameter :: ledger(3) = [v_stored, v_rupture, v_friction]
  !> Compared numbers of a row: separation, traction, work, stored and dissipated energies.
  integer, parameter :: n_values = 10

contains

  !> Append an error if a tolerance is out of range, or if a path has none.
  pure subroutine explain_tolerance(tolerance, steps, place, message)
    real(wp), intent(in) :: tolerance                         !! relative
    type(step_type), intent(in) :: steps(:)                   !! the load path
    character(len=*), intent(in) :: place                     !! of the tolerance in messages
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    real(wp) :: parts
    integer :: i
    logical :: good
    good = bounded(tolerance, largest_tolerance)
    if (good) good = tolerance >= least_tolerance
    if (.not. good) call append(message, place // "tolerance = " // to_text(tolerance) // ": expected " // &
      to_text(least_tolerance) // " to " // to_text(largest_tolerance))
    parts = 0.0_wp
    do i = 1, size(steps)
      if (allocated(steps(i)%increments)) parts = parts + sum(real(max(least_parts, steps(i)%increments), wp))
    end do
    if (4.0_wp*parts > real(most_parts, wp)) call append(message, place // "tolerance with " // to_text(parts) // &
      " increments: expected at most " // integer_text(most_parts/4) // ", which are halved twice or more")
    if (any(steps%arc > 0.0_wp)) call append(message, place // "tolerance with follow = 'branch': expected arc, " // &
      "the longest step along the branch")
  end subroutine explain_tolerance

  !> Run a path to a tolerance: the largest distance of the rows of a run from straight lines between those of a run
  !> with half as many increments is small, and was at most twice as large in the run before.
  !>
  !> The tolerance is relative to the largest traction (at least the strength), separation (at least s_f) and work (at
  !> least that of the bond). The distance is that between the curves, so that a jump may move by a small part of the
  !> path.
  subroutine refine_path(joint, steps, start, tolerance, rows, run, message, other)
    type(interface_type), intent(in) :: joint                 !! the interface
    type(step_type), intent(in) :: steps(:)                   !! the load path, checked
    type(point_type), intent(in) :: start                     !! the point at its start
    real(wp), intent(in) :: tolerance                         !! admissible
    type(row_type), allocatable, intent(out) :: rows(:)       !! the rows
    type(run_type), intent(out) :: run                        !! the finest run, at its end
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended if the tolerance is not reached
    class(point_law), intent(in), optional :: other           !! law instead of that of the interface
    type(step_type) :: finer(size(steps))
    type(row_type), allocatable :: coarse(:), fine(:)
    real(wp), allocatable :: lines(:, :), scales(:), values(:, :)
    real(wp) :: earlier, error
    integer :: i
    finer = steps
    do i = 1, size(steps)
      finer(i)%increments = max(least_parts, steps(i)%increments)
    end do
    call run_rows(joint, finer, start, run, coarse, other)
    error = huge(error)
    do
      do i = 1, size(steps)
        finer(i)%increments = 2*finer(i)%increments
      end do
      call run_rows(joint, finer, start, run, fine, other)
      values = table_of(start, fine)
      scales = scales_of(joint, values)
      values = values/spread(scales, 2, size(fine) + 1)
      lines = table_of(start, coarse)/spread(scales, 2, size(coarse) + 1)
      earlier = error
      error = distance_of(coarse, fine, lines, values)
      if (max(error, 0.5_wp*earlier) <= measured_part*tolerance) exit
      if (2*run%total > most_parts) then
        call append(message, "tolerance = " // to_text(tolerance) // ": the rows of " // &
          integer_text(run%total/2) // " and of " // integer_text(run%total) // " increments differ by " // &
          short(max(error, 0.5_wp*earlier)) // " of the largest values: expected a larger tolerance, of which this " &
          // "may be " // short(measured_part))
        exit
      end if
      call move_alloc(fine, coarse)
    end do
    call thin(fine, values, thinned_part*tolerance, rows)
  end subroutine refine_path

  !> Rows of a path.
  subroutine run_rows(joint, steps, start, run, rows, other)
    type(interface_type), intent(in) :: joint               !! the interface
    type(step_type), intent(in) :: steps(:)                 !! the load path
    type(point_type), intent(in) :: start                   !! the point at its start
    type(run_type), intent(out) :: run                      !! the run, at its end
    type(row_type), allocatable, intent(out) :: rows(:)     !! the last one may be lost
    class(point_law), intent(in), optional :: other         !! law instead of that of the interface
    type(row_type), allocatable :: room(:)
    type(row_type) :: row
    integer :: n
    logical :: found
    call start_run(joint, steps, run, start, other)
    allocate (room(run%total))
    n = 0
    do
      call next_row(run, row, found)
      if (.not. found) exit
      n = n + 1
      room(n) = row
    end do
    if (n == size(room)) then
      call move_alloc(room, rows)
    else
      allocate (rows, source=room(:n))
    end if
  end subroutine run_rows

  !> Compared numbers of the start (column 0) and of the rows.
  pure function table_of(start, rows) result(values)
    type(point_type), intent(in) :: start         !! the point at the start
    type(row_type), intent(in) :: rows(:)         !! rows
    real(wp), allocatable :: values(:, :)
    integer :: i
    allocate (values(n_values, 0:size(rows)))
    values(:, 0) = [start%s, start%traction, start%work, start%state(ledger)]
    do i = 1, size(rows)
      values(:, i) = [rows(i)%s, rows(i)%traction, rows(i)%work, rows(i)%state(ledger)]
    end do
  end function table_of

  !> What the distance of rows is relative to.
  pure function scales_of(joint, values) result(scales)
    type(interface_type), intent(in) :: joint     !! the interface
    real(wp), intent(in) :: values(:, :)          !! compared numbers
    real(wp) :: scales(n_values)
    !> A joint without bond has neither s_f nor strength: this part of them only keeps the scales above zero.
    real(wp), parameter :: unbonded = 1.0e-9_wp
    real(wp) :: least
    type(rie_law) :: law
    law = new_rie_law(joint)
    least = merge(unbonded, 1.0_wp, start_damage(joint, 0.0_wp) >= 1.0_wp)
    scales(1:3) = max(least*law%reach, maxval(abs(values(1:3, :))))
    scales(4:6) = max(least*law%stress, maxval(abs(values(4:6, :))))
    scales(7:) = max(least*0.5_wp*law%reach*law%stress, maxval(abs(values(7:, :))))
  end function scales_of

  !> Largest distance of the rows of a run from the straight lines between those of a run with half as many increments.
  pure function distance_of(coarse, fine, lines, values) result(largest)
    type(row_type), intent(in) :: coarse(:), fine(:)                 !! rows of both runs
    real(wp), intent(in) :: lines(:, 0:), values(:, 0:)              !! their compared numbers
    real(wp) :: largest
    real(wp) :: distance
    integer :: i, j, k, n
    n = size(coarse)
    ! both end where equilibrium is lost, or none does
    largest = merge(huge(largest), 0.0_wp, coarse(n)%lost .neqv. fine(size(fine))%lost)
    if (coarse(n)%lost) largest = max(largest, maxval(abs(lines(:, n) - values(:, size(fine)))))
    do i = 1, size(fine)
      j = min((i + 1)/2, n)
      distance = huge(distance)
      do k = max(1, j - 1), min(n, j + 1)
        distance = min(distance, from_line(lines(:, k - 1), lines(:, k), values(:, i)))
      end do
      largest = max(largest, distance)
    end do
  end function distance_of

  !> Distance of a point from the line between two others, in the largest component of the shortest way.
  pure function from_line(a, b, x) result(distance)
    real(wp), intent(in) :: a(:), b(:)   !! ends of the line
    real(wp), intent(in) :: x(:)         !! the point
    real(wp) :: distance
    real(wp) :: length, share
    length = sum((b - a)**2)
    share = 0.0_wp
    if (length > 0.0_wp) share = min(1.0_wp, max(0.0_wp, dot_product(x - a, b - a)/length))
    distance = maxval(abs(a + share*(b - a) - x))
  end function from_line

  !> Leave out rows as long as straight lines between the others stay within a distance: the slopes of the lines from
  !> the last row that stays are confined by each row that is passed. Rows with events, those before a snap, and those
  !> at targets stay.
  pure subroutine thin(fine, values, tolerance, rows)
    type(row_type), intent(in) :: fine(:)                   !! all rows
    real(wp), intent(in) :: values(:, 0:)                   !! their compared numbers
    real(wp), intent(in) :: tolerance                       !! largest distance
    type(row_type), allocatable, intent(out) :: rows(:)     !! those that stay, with new numbers of their increments
    logical, allocatable :: stays(:)
    real(wp), dimension(size(values, 1)) :: highest, lowest, slope
    real(wp) :: from, length
    integer :: i, last
    logical :: fixed
    allocate (stays(0:size(fine)))
    stays = .false.
    i = 1
    last = 0
    from = 0.0_wp
    lowest = -huge(lowest)
    highest = huge(highest)
    do while (i <= size(fine))
      length = fine(i)%position - from
      slope = (values(:, i) - values(:, last))/max(length, epsilon(length))
      fixed = len_trim(fine(i)%events) > 0 .or. i == size(fine) .or. &
        .not. abs(fine(i)%position - anint(fine(i)%position)) > 0.0_wp
      if (i < size(fine)) fixed = fixed .or. fine(i + 1)%report%snaps > 0
      if (last < i - 1 .and. any(slope < lowest .or. slope > highest)) then
        ! the row before is the last one that a straight line reaches
        i = i - 1
        fixed = .true.
      else if (.not. fixed) then
        lowest = max(lowest, slope - tolerance/length)
        highest = min(highest, slope + tolerance/length)
      end if
      if (fixed) then
        stays(i) = .true.
        last = i
        from = fine(i)%position
        lowest = -huge(lowest)
        highest = huge(highest)
      end if
      i = i + 1
    end do
    rows = pack(fine, stays(1:))
    do i = 1, size(rows)
      rows(i)%increment = 1
      if (i == 1) cycle
      if (rows(i)%step == rows(i - 1)%step) rows(i)%increment = rows(i - 1)%increment + 1
    end do
  end subroutine thin

end module asperity_refine
