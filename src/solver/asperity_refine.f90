!> Load path to a tolerance: the increments of the whole path are halved until two runs agree, then rows are left out.
!>
!> The error is measured: it is the largest distance of the rows of the finer run from the curve of the coarser one. Half
!> of the tolerance is for this distance, half for the rows that are left out.
module asperity_refine
  use asperity_checks, only: bounded
  use asperity_contract, only: v_friction, v_rupture, v_stored
  use asperity_control_point, only: point_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_load_path, only: begin_run, least_parts, next_row, row_type, run_type
  use asperity_steps, only: step_type
  use asperity_text, only: append, integer_text, short, to_text
  implicit none
  private
  public :: refine_path, explain_tolerance

  !> Admissible tolerances.
  real(wp), parameter :: least_tolerance = 1.0e-8_wp, largest_tolerance = 0.1_wp
  !> Level before which no agreement is accepted, as few increments may agree by chance.
  integer, parameter :: least_level = 2
  !> Largest number of increments of a path; its rows need some 100 MB for a pattern of 65 planes.
  integer, parameter, public :: most_parts = 100000
  !> Compared numbers of a row: separation, traction, work, stored and dissipated energies.
  integer, parameter :: n_values = 10

  !> Positions of the stored and the dissipated energies in STATEV.
  integer, parameter :: ledger(3) = [v_stored, v_rupture, v_friction]

contains

  !> Append an error if a tolerance is out of range, or if a path has none.
  pure subroutine explain_tolerance(tolerance, steps, place, message)
    real(wp), intent(in) :: tolerance                         !! relative
    type(step_type), intent(in) :: steps(:)                   !! the load path
    character(len=*), intent(in) :: place                     !! of the tolerance in messages
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    logical :: good
    good = bounded(tolerance, largest_tolerance)
    if (good) good = tolerance >= least_tolerance
    if (.not. good) call append(message, place // "tolerance = " // to_text(tolerance) // ": expected " // &
      to_text(least_tolerance) // " to " // to_text(largest_tolerance))
    if (any(steps%arc > 0.0_wp)) call append(message, place // "tolerance with follow = 'branch': expected arc, the " // &
      "longest step along the branch")
  end subroutine explain_tolerance

  !> Run a path to a tolerance.
  !>
  !> The tolerance is relative to the largest traction (at least the strength), separation (at least s_f) and work (at
  !> least that of the bond). The distance is that between the curves, so that a jump may move by a small part of the
  !> path.
  pure subroutine refine_path(joint, steps, start, tolerance, rows, run, message)
    type(interface_type), intent(in) :: joint                 !! the interface
    type(step_type), intent(in) :: steps(:)                   !! the load path, checked
    type(point_type), intent(in) :: start                     !! the point at its start
    real(wp), intent(in) :: tolerance                         !! admissible
    type(row_type), allocatable, intent(out) :: rows(:)       !! the rows
    type(run_type), intent(out) :: run                        !! the finest run, at its end
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended if the tolerance is not reached
    type(row_type), allocatable :: coarse(:), fine(:)
    real(wp) :: error, scales(n_values)
    integer :: factor, level
    factor = 1
    call run_all(joint, steps, start, factor, run, fine)
    level = 0
    do
      level = level + 1
      factor = 2*factor
      call move_alloc(fine, coarse)
      call run_all(joint, steps, start, factor, run, fine)
      scales = scales_of(joint, start, fine)
      error = largest_distance(start, coarse, fine, scales)
      if (error <= 0.5_wp*tolerance .and. level >= least_level) exit
      if (2*size(fine) <= most_parts) cycle
      call append(message, "tolerance = " // to_text(tolerance) // ": the rows of " // integer_text(size(coarse)) // &
        " and of " // integer_text(size(fine)) // " increments differ by " // short(error) // &
        " of the largest values: expected a larger tolerance")
      exit
    end do
    call thin(start, fine, scales, 0.5_wp*tolerance, rows)
  end subroutine refine_path

  !> Rows of a path with all of its increments divided.
  pure subroutine run_all(joint, steps, start, factor, run, rows)
    type(interface_type), intent(in) :: joint               !! the interface
    type(step_type), intent(in) :: steps(:)                 !! the load path
    type(point_type), intent(in) :: start                   !! the point at its start
    integer, intent(in) :: factor                           !! parts of every increment
    type(run_type), intent(out) :: run                      !! the run, at its end
    type(row_type), allocatable, intent(out) :: rows(:)     !! the last one is lost if equilibrium is
    type(row_type), allocatable :: all_rows(:)
    type(row_type) :: row
    integer :: i, n
    logical :: found
    call begin_run(joint, steps, run, start)
    run%factor = factor
    n = 0
    do i = 1, size(steps)
      n = n + factor*sum(max(least_parts, steps(i)%increments))
    end do
    allocate (all_rows(n))
    n = 0
    do
      call next_row(run, row, found)
      if (.not. found) exit
      n = n + 1
      all_rows(n) = row
    end do
    rows = all_rows(:n)
  end subroutine run_all

  !> What the distance of rows is relative to.
  pure function scales_of(joint, start, rows) result(scales)
    type(interface_type), intent(in) :: joint     !! the interface
    type(point_type), intent(in) :: start         !! the point at the start
    type(row_type), intent(in) :: rows(:)         !! rows
    real(wp) :: scales(n_values)
    real(wp) :: largest(3), values(n_values)
    integer :: i
    associate (m => joint%material)
      largest = [m%s0/(1.0_wp - m%eta), m%k_n*m%s0, 0.0_wp]
    end associate
    largest(3) = 0.5_wp*largest(1)*largest(2)
    values = values_of_point(start)
    do i = 0, size(rows)
      if (i > 0) values = values_of(rows(i))
      largest = max(largest, [maxval(abs(values(1:3))), maxval(abs(values(4:6))), maxval(abs(values(7:)))])
    end do
    scales(1:3) = largest(1)
    scales(4:6) = largest(2)
    scales(7:) = largest(3)
  end function scales_of

  !> Compared numbers of a row.
  pure function values_of(row) result(values)
    type(row_type), intent(in) :: row   !! the row
    real(wp) :: values(n_values)
    values = [row%s, row%traction, row%work, row%state(ledger)]
  end function values_of

  !> Compared numbers of a point.
  pure function values_of_point(point) result(values)
    type(point_type), intent(in) :: point   !! the point
    real(wp) :: values(n_values)
    values = [point%s, point%traction, point%work, point%state(ledger)]
  end function values_of_point

  !> Largest distance of the rows of the finer run from the curve of the coarser one, relative to the scales; a huge number
  !> if equilibrium is lost in one of them alone.
  pure function largest_distance(start, coarse, fine, scales) result(largest)
    type(point_type), intent(in) :: start                     !! the point at the start
    type(row_type), intent(in) :: coarse(:), fine(:)          !! rows, two of the finer run for one of the coarser run
    real(wp), intent(in) :: scales(n_values)                  !! of the distance
    real(wp) :: largest
    real(wp), allocatable :: ends(:, :)
    real(wp) :: distance, values(n_values)
    integer :: i, j, k
    largest = huge(largest)
    if (coarse(size(coarse))%lost .neqv. fine(size(fine))%lost) return
    largest = 0.0_wp
    ! not an automatic array: the stack of a thread may be short
    allocate (ends(n_values, 0:size(coarse)))
    values = values_of_point(start)/scales
    ends(:, 0) = values
    do j = 1, size(coarse)
      ends(:, j) = values_of(coarse(j))/scales
    end do
    do i = 1, size(fine)
      values = values_of(fine(i))/scales
      j = min((i + 1)/2, size(coarse))
      distance = huge(distance)
      do k = max(1, j - 1), min(size(coarse), j + 1)
        distance = min(distance, from_line(ends(:, k - 1), ends(:, k), values))
      end do
      largest = max(largest, distance)
    end do
    ! both end at the same place
    largest = max(largest, maxval(abs(ends(:, size(coarse)) - values)))
  end function largest_distance

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

  !> Leave out rows as long as straight lines between the others stay within a distance (Douglas and Peucker). Rows with
  !> events, those before a snap, and those at targets stay.
  pure subroutine thin(start, fine, scales, tolerance, rows)
    type(point_type), intent(in) :: start                   !! the point at the start
    type(row_type), intent(in) :: fine(:)                   !! all rows
    real(wp), intent(in) :: scales(n_values)                !! of the distance
    real(wp), intent(in) :: tolerance                       !! largest distance, relative
    type(row_type), allocatable, intent(out) :: rows(:)     !! those that stay, with new numbers of their increments
    real(wp), allocatable :: places(:), values(:, :)
    logical, allocatable :: stays(:)
    integer, allocatable :: stack(:)
    integer :: i, last, n, place
    real(wp) :: worst
    allocate (places(0:size(fine)), values(n_values, 0:size(fine)), stays(0:size(fine)), stack(size(fine) + 1))
    values(:, 0) = values_of_point(start)/scales
    places(0) = 0.0_wp
    stays = .false.
    stays([0, size(fine)]) = .true.
    do i = 1, size(fine)
      values(:, i) = values_of(fine(i))/scales
      places(i) = fine(i)%position
      if (len_trim(fine(i)%events) > 0 .or. .not. abs(places(i) - anint(places(i))) > 0.0_wp) stays(i) = .true.
      if (fine(i)%report%snaps > 0) stays(i - 1) = .true.
    end do
    last = 0
    do i = 1, size(fine)
      if (.not. stays(i)) cycle
      ! divide the stretch from the last row that stays up to this one
      n = 1
      stack(1) = i
      do while (n > 0)
        call farthest_row(values, places, last, stack(n), place, worst)
        if (worst > tolerance) then
          n = n + 1
          stack(n) = place
          stays(place) = .true.
        else
          last = stack(n)
          n = n - 1
        end if
      end do
    end do
    allocate (rows(count(stays(1:))))
    n = 0
    do i = 1, size(fine)
      if (.not. stays(i)) cycle
      n = n + 1
      rows(n) = fine(i)
    end do
    do i = 1, size(rows)
      rows(i)%increment = 1
      if (i == 1) cycle
      if (rows(i)%step == rows(i - 1)%step) rows(i)%increment = rows(i - 1)%increment + 1
    end do
  end subroutine thin

  !> The row between two others that is farthest from the straight line between them.
  pure subroutine farthest_row(values, places, from, to, place, worst)
    real(wp), intent(in) :: values(:, 0:)    !! compared numbers of the rows
    real(wp), intent(in) :: places(0:)       !! positions of the rows
    integer, intent(in) :: from, to          !! the two
    integer, intent(out) :: place            !! the row
    real(wp), intent(out) :: worst           !! its distance, 0: none between
    real(wp) :: distance, share
    integer :: i
    worst = 0.0_wp
    place = to
    do i = from + 1, to - 1
      share = 1.0_wp
      if (places(to) > places(from)) share = (places(i) - places(from))/(places(to) - places(from))
      distance = maxval(abs(values(:, from) + share*(values(:, to) - values(:, from)) - values(:, i)))
      if (.not. distance > worst) cycle
      worst = distance
      place = i
    end do
  end subroutine farthest_row

end module asperity_refine
