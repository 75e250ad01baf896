!> Load path to a tolerance: increments are halved until the rows of two runs agree, then rows are left out.
!>
!> Every level runs the whole path twice, with a mesh and with all of its increments halved, and measures the largest
!> distance of the second run from straight lines between the rows of the first. Then the increments are halved where
!> that distance is too large. Half of the tolerance is for this distance, half for the rows that are left out.
module asperity_refine
  use asperity_checks, only: bounded
  use asperity_contract, only: v_friction, v_rupture, v_stored
  use asperity_control_point, only: point_type
  use asperity_interface, only: interface_type, start_damage
  use asperity_kinds, only: wp
  use asperity_load_path, only: begin_run, next_row, row_type, run_type
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_steps, only: step_type
  use asperity_text, only: append, integer_text, short, to_text
  implicit none
  private
  public :: refine_path, explain_tolerance

  !> Admissible tolerances.
  real(wp), parameter :: least_tolerance = 1.0e-8_wp, largest_tolerance = 0.1_wp
  !> Smallest number of increments to a target at the first level: fewer may agree by chance.
  integer, parameter :: least_parts = 8
  !> Level before which no agreement is accepted, for the same reason.
  integer, parameter :: least_level = 2
  !> Largest number of increments of a path; its rows need some 100 MB for a pattern of 65 planes.
  integer, parameter, public :: most_parts = 100000
  !> Smallest source of the distance, relative to the largest one, for which an increment is halved.
  real(wp), parameter :: least_source = 0.1_wp
  !> Smallest reduction of the distance over two levels; with less, all increments are halved. (Over one level the
  !> distance at a kink may stay as it is, since it depends on where the kink is between two rows.)
  real(wp), parameter :: slowest = 0.75_wp
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
    if (any(steps%arc > 0.0_wp)) call append(message, place // "tolerance with follow = 'branch': expected arc, " // &
      "the longest step along the branch")
  end subroutine explain_tolerance

  !> Run a path to a tolerance.
  !>
  !> The tolerance is relative to the largest traction (at least the strength), separation (at least s_f) and work (at
  !> least that of the bond). Where the path jumps, the distance is that between the curves, so that a jump may move by
  !> a small part of the path.
  pure subroutine refine_path(joint, steps, start, tolerance, rows, run, message)
    type(interface_type), intent(in) :: joint                 !! the interface
    type(step_type), intent(in) :: steps(:)                   !! the load path, checked
    type(point_type), intent(in) :: start                     !! the point at its start
    real(wp), intent(in) :: tolerance                         !! admissible
    type(row_type), allocatable, intent(out) :: rows(:)       !! the rows
    type(run_type), intent(out) :: run                        !! the finest run, at its end
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended if the tolerance is not reached
    type(row_type), allocatable :: coarse(:), fine(:)
    real(wp), allocatable :: distances(:), halved(:), mesh(:), sources(:)
    logical, allocatable :: marks(:)
    real(wp) :: earlier(2), error, scales(n_values)
    integer :: level
    call first_mesh(steps, mesh)
    call run_mesh(joint, steps, start, mesh, run, coarse)
    earlier = huge(earlier)
    level = 0
    do
      level = level + 1
      if (allocated(marks)) deallocate (marks)
      allocate (marks(size(mesh)), source=.true.)
      call halve(mesh, marks, halved)
      call run_mesh(joint, steps, start, halved, run, fine)
      scales = scales_of(joint, start, fine)
      call compare(start, coarse, fine, mesh, scales, distances, sources)
      error = maxval(distances)
      if (error <= 0.5_wp*tolerance .and. level >= least_level) exit
      if (2*size(halved) > most_parts) then
        call append(message, "tolerance = " // to_text(tolerance) // ": the rows of " // integer_text(size(mesh)) // &
          " and of " // integer_text(size(halved)) // " increments differ by " // short(error) // &
          " of the largest values: expected a larger tolerance")
        exit
      end if
      marks = sources > min(0.5_wp*tolerance, least_source*maxval(sources))
      if (error > slowest*earlier(2) .or. level < least_level) marks = .true.
      marks = marks .or. eoshift(marks, 1) .or. eoshift(marks, -1)
      earlier = [error, earlier(1)]
      call halve(mesh, marks, halved)
      call move_alloc(halved, mesh)
      if (all(marks)) then
        call move_alloc(fine, coarse)
      else
        call run_mesh(joint, steps, start, mesh, run, coarse)
      end if
    end do
    call thin(start, fine, scales, 0.5_wp*tolerance, rows)
  end subroutine refine_path

  !> Positions of the rows of the first level.
  pure subroutine first_mesh(steps, mesh)
    type(step_type), intent(in) :: steps(:)            !! the load path
    real(wp), allocatable, intent(out) :: mesh(:)      !! ends of the increments: targets before, and share of the next
    integer :: i, j, k, n, parts, passed
    n = 0
    do i = 1, size(steps)
      n = n + sum(max(least_parts, steps(i)%increments))
    end do
    allocate (mesh(n))
    n = 0
    passed = 0
    do i = 1, size(steps)
      do j = 1, size(steps(i)%increments)
        parts = max(least_parts, steps(i)%increments(j))
        mesh(n + 1:n + parts) = [(real(passed, wp) + real(k, wp)/real(parts, wp), k=1, parts)]
        n = n + parts
        passed = passed + 1
      end do
    end do
  end subroutine first_mesh

  !> Halve the marked increments of a mesh.
  pure subroutine halve(mesh, marks, halved)
    real(wp), intent(in) :: mesh(:)                      !! ends of the increments
    logical, intent(in) :: marks(:)                      !! of each
    real(wp), allocatable, intent(out) :: halved(:)      !! ends of the new increments
    real(wp) :: before
    integer :: i, n
    allocate (halved(size(mesh) + count(marks)))
    n = 0
    before = 0.0_wp
    do i = 1, size(mesh)
      if (marks(i)) then
        n = n + 1
        halved(n) = before + 0.5_wp*(mesh(i) - before)
      end if
      n = n + 1
      halved(n) = mesh(i)
      before = mesh(i)
    end do
  end subroutine halve

  !> Rows of a path on a mesh.
  pure subroutine run_mesh(joint, steps, start, mesh, run, rows)
    type(interface_type), intent(in) :: joint               !! the interface
    type(step_type), intent(in) :: steps(:)                 !! the load path
    type(point_type), intent(in) :: start                   !! the point at its start
    real(wp), intent(in) :: mesh(:)                         !! ends of the increments
    type(run_type), intent(out) :: run                      !! the run, at its end
    type(row_type), allocatable, intent(out) :: rows(:)     !! fewer than the mesh has: the last one is lost
    type(row_type), allocatable :: all_rows(:)
    type(row_type) :: row
    integer :: n
    logical :: found
    call begin_run(joint, steps, run, start)
    run%mesh = mesh
    allocate (all_rows(size(mesh)))
    n = 0
    do
      call next_row(run, row, found)
      if (.not. found) exit
      n = n + 1
      all_rows(n) = row
    end do
    if (n == size(mesh)) then
      call move_alloc(all_rows, rows)
    else
      allocate (rows, source=all_rows(:n))
    end if
  end subroutine run_mesh

  !> What the distance of rows is relative to.
  pure function scales_of(joint, start, rows) result(scales)
    type(interface_type), intent(in) :: joint     !! the interface
    type(point_type), intent(in) :: start         !! the point at the start
    type(row_type), intent(in) :: rows(:)         !! rows
    real(wp) :: scales(n_values)
    !> A joint without bond has neither s_f nor strength: this part of them only keeps the scales above zero.
    real(wp), parameter :: unbonded = 1.0e-9_wp
    real(wp) :: largest(3), values(n_values)
    type(rie_law) :: law
    integer :: i
    law = new_rie_law(joint)
    values = values_of_point(start)
    largest = [law%reach, law%stress, 0.5_wp*law%reach*law%stress]
    if (start_damage(joint, 0.0_wp) >= 1.0_wp) largest = unbonded*largest
    largest = max(largest, [maxval(abs(values(1:3))), maxval(abs(values(4:6))), maxval(abs(values(7:)))])
    do i = 1, size(rows)
      values = values_of(rows(i))
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

  !> Distance of the rows of the halved increments from the straight lines between the rows of a mesh.
  pure subroutine compare(start, coarse, fine, mesh, scales, distances, sources)
    type(point_type), intent(in) :: start                     !! the point at the start
    type(row_type), intent(in) :: coarse(:), fine(:)          !! rows of the mesh and of the halved increments
    real(wp), intent(in) :: mesh(:)                           !! ends of the increments
    real(wp), intent(in) :: scales(n_values)                  !! of the distance
    real(wp), allocatable, intent(out) :: distances(:)        !! of every increment of the mesh, relative
    real(wp), allocatable, intent(out) :: sources(:)          !! what each increment adds to the distance of its own
                                                              !! rows, or to that of all rows after it
    real(wp), allocatable :: ends(:, :), places(:)
    logical, allocatable :: jumps(:)
    real(wp), dimension(n_values) :: before, delta, line, values
    real(wp) :: distance, share
    integer :: i, j, k
    ! not automatic arrays: the stack of a thread may be short
    allocate (distances(size(mesh)), sources(size(mesh)))
    allocate (ends(n_values, 0:size(coarse)), places(0:size(coarse)), jumps(0:size(coarse) + 1))
    distances = 0.0_wp
    sources = 0.0_wp
    before = 0.0_wp
    ends(:, 0) = values_of_point(start)/scales
    places(0) = 0.0_wp
    jumps = .false.
    do j = 1, size(coarse)
      ends(:, j) = values_of(coarse(j))/scales
      places(j) = coarse(j)%position
      jumps(j) = coarse(j)%report%snaps > 0
    end do
    do i = 1, size(fine)
      if (fine(i)%report%snaps > 0) jumps(min((i + 1)/2, size(coarse))) = .true.
    end do
    do i = 1, size(fine)
      j = min((i + 1)/2, size(coarse))
      values = values_of(fine(i))/scales
      share = 1.0_wp
      if (places(j) > places(j - 1)) share = min(1.0_wp, (fine(i)%position - places(j - 1))/(places(j) - places(j - 1)))
      line = ends(:, j - 1) + share*(ends(:, j) - ends(:, j - 1))
      distance = maxval(abs(line - values))
      if (any(jumps(j - 1:j + 1))) then
        do k = max(1, j - 1), min(size(coarse), j + 1)
          distance = min(distance, from_line(ends(:, k - 1), ends(:, k), values))
        end do
        sources(j) = max(sources(j), distance)
      else if (modulo(i, 2) == 0) then
        delta = values - line
        sources(j) = max(sources(j), maxval(abs(delta - before)))
        before = delta
      else if (i < size(fine)) then
        delta = values_of(fine(i + 1))/scales - ends(:, j)
        sources(j) = max(sources(j), maxval(abs(values - line - 0.5_wp*(before + delta))))
      end if
      distances(j) = max(distances(j), distance)
    end do
    ! both end where equilibrium is lost, or none does
    j = size(coarse)
    if (coarse(j)%lost .neqv. fine(size(fine))%lost) distances(j) = huge(distance)
    if (coarse(j)%lost) distances(j) = max(distances(j), maxval(abs(ends(:, j) - values)))
    sources(j) = max(sources(j), distances(j))
  end subroutine compare

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
