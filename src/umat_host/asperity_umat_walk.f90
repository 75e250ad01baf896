!> Walks of a UMAT along a load path. Each is made in a child of its own, which opens the library anew and sends its
!> results.
module asperity_umat_walk
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_funloc, c_funptr, c_int, c_loc, c_ptr
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_foreign_umat, only: foreign_law, how_type, n_header, open_umat
  use asperity_kinds, only: wp
  use asperity_point_law, only: call_type, point_type
  use asperity_umat_worker, only: end_worker, n_notes, receive_row, send_row, start_worker
  implicit none
  private
  public :: add_increment, set_length, walk

  !> Steps of the differences, relative to `length`.
  real(wp), parameter, public :: difference(2) = 1.0e-5_wp*[1.0_wp, 0.01_wp]
  !> Updates of a thread, so that both work at the same time, and the time after which a slow UMAT makes no more, s.
  integer, parameter :: thread_updates = 20000
  real(wp), parameter :: thread_seconds = 2.0_wp
  !> An increment that is not divided, and one of no length at its end.
  real(wp), parameter :: whole(2) = [0.0_wp, 1.0_wp], rest(2) = [1.0_wp, 1.0_wp]
  !> Change of the traction in a rest, relative to that in the increment before, which a law with explicit terms may
  !> have, and the part of the strength that is a rounding error.
  real(wp), parameter :: explicit = 2.0_wp, rounding = 1.0e-6_wp
  !> Traction and tangent before the state in a result; numbers of the differences at an increment.
  integer, parameter, public :: n_first = 12
  integer, parameter :: n_differences = 48

  !> The path that the checks go along.
  type, public :: checked_path_type
    type(foreign_law) :: law
    real(wp), allocatable :: s(:, :)                      !! (3, 0:n) separation
    real(wp), allocatable :: dt(:)                        !! (n) durations
    integer, allocatable :: step(:), increment(:)         !! (n)
    real(wp), allocatable :: start(:)                     !! state at the start
  end type checked_path_type

  !> A walk along it, of one point or of several.
  type, public :: walk_type
    type(checked_path_type) :: path
    type(how_type) :: how
    logical :: differences = .false.         !! whether the results are differences of the traction
    real(wp), allocatable :: factors(:, :)   !! (3, points) of the components of the path
    real(wp), allocatable :: known(:, :, :)  !! (:, 0:n, points) results to compare with; else they are returned
    integer :: differs(2) = huge(1)          !! first increment with other results in two threads
  end type walk_type

  interface
    !> Two pieces of work at once.
    subroutine c_threads(work, data) bind(c, name="umat_threads")
      import :: c_funptr, c_ptr
      implicit none
      type(c_funptr), value :: work
      type(c_ptr), value :: data
    end subroutine c_threads
  end interface

contains

  !> Add an increment to a path, in equal parts. Its arrays grow ahead: `set_length` gives them their size at last.
  pure subroutine add_increment(path, n, s, dt, step, increment, parts)
    type(checked_path_type), intent(inout) :: path   !! the path, with its first separation
    integer, intent(inout) :: n                      !! its increments so far -> with these
    real(wp), intent(in) :: s(3)                     !! separation at the end
    real(wp), intent(in) :: dt                       !! duration
    integer, intent(in) :: step, increment           !! numbers of the case
    integer, intent(in) :: parts                     !! from 1
    real(wp) :: from(3)
    integer :: i
    if (n + parts > size(path%dt)) call set_length(path, 2*(n + parts))
    from = path%s(:, n + 1)
    do i = 1, parts
      path%s(:, n + i + 1) = from + real(i, wp)/real(parts, wp)*(s - from)
    end do
    path%dt(n + 1:n + parts) = dt/real(parts, wp)
    path%step(n + 1:n + parts) = step
    path%increment(n + 1:n + parts) = increment
    n = n + parts
  end subroutine add_increment

  !> Give a path room for a number of increments; those that are there, up to this number, stay.
  pure subroutine set_length(path, n)
    type(checked_path_type), intent(inout) :: path   !! the path, with its first separation
    integer, intent(in) :: n                         !! increments
    type(checked_path_type) :: other
    integer :: kept
    kept = min(n, size(path%dt))
    allocate (other%s(3, n + 1), other%dt(n), source=0.0_wp)
    allocate (other%step(n), other%increment(n), source=0)
    other%s(:, :kept + 1) = path%s(:, :kept + 1)
    other%dt(:kept) = path%dt(:kept)
    other%step(:kept) = path%step(:kept)
    other%increment(:kept) = path%increment(:kept)
    call move_alloc(other%s, path%s)
    call move_alloc(other%dt, path%dt)
    call move_alloc(other%step, path%step)
    call move_alloc(other%increment, path%increment)
  end subroutine set_length

  !> Walk along a path in a child.
  subroutine walk(plan, results, failure)
    type(walk_type), intent(in), target :: plan                 !! how
    real(wp), allocatable, intent(out) :: results(:, :)         !! (:, 0:n) results, 1 where they are not known, or
                                                                !! differences after each increment
    character(len=:), allocatable, intent(out) :: failure       !! why the UMAT has failed, empty: it has not
    character(len=:), allocatable :: text
    real(wp) :: notes(n_notes)
    integer :: i, n
    n = n_first + plan%path%law%n_state
    if (allocated(plan%known)) n = 1
    if (plan%differences) n = n_differences
    allocate (results(n, 0:size(plan%path%dt)), source=0.0_wp)
    if (n > n_first .and. .not. plan%differences) results(n_first + 1:, 0) = plan%path%start
    call start_worker(c_funloc(walk_there), c_loc(plan), plan%path%law%umat%limit)
    i = 0
    do while (receive_row(results(:, min(i + 1, size(plan%path%dt))), n) /= 0)
      i = i + 1
    end do
    call end_worker(failure, text, notes)
  end subroutine walk

  !> The work of the child.
  subroutine walk_there(data) bind(c, name="asperity_umat_walk_there")
    type(c_ptr), value :: data   !! walk
    type(walk_type), pointer :: plan
    type(foreign_law) :: law
    type(checked_path_type) :: path
    real(wp), allocatable :: before(:, :), points(:, :), tried(:)
    integer :: attempt, first, i, k, p
    logical :: differs
    call c_f_pointer(data, plan)
    law = plan%path%law
    path = plan%path
    call open_umat(law, plan%how)
    points = spread([spread(0.0_wp, 1, n_first), plan%path%start], 2, size(plan%factors, 2))
    if (plan%how%threads) call c_threads(c_funloc(walk_often), data)
    attempt = 0
    first = 1
    if (plan%how%late) then
      first = most_unloaded(path)
      points = plan%known(:, first, :)
      path%step(first:) = path%step(first:) + 1
      path%increment(first:) = [(i, i=1, size(path%dt) - first + 1)]
    end if
    do i = 1, size(path%dt)
      if (i < first) then
        call send_row([0.0_wp], 1)
        cycle
      else if (plan%how%threads) then
        call send_row(merge([1.0_wp], [0.0_wp], any(i >= plan%differs)), 1)
        cycle
      else if (plan%differences) then
        call send_row(differences_at(law, plan, i, attempt), n_differences)
        cycle
      end if
      before = points(:3, :)
      do p = 1, size(points, 2)
        associate (point => points(:, p), factors => plan%factors(:, p), parts => plan%how%parts)
          if (plan%how%tries) tried = after(law, path, i, factors, whole, point(n_first + 1:), attempt)
          do k = 1, parts
            point = after(law, path, i, factors, real([k - 1, k], wp)/real(parts, wp), point(n_first + 1:), attempt)
          end do
        end associate
      end do
      if (allocated(plan%known)) then
        ! in a new step, a UMAT may store other numbers of the increment
        k = merge(n_first, size(points, 1), plan%how%late)
        differs = any(abs(points(:k, :) - plan%known(:k, i + 1, :)) > 0.0_wp)
        if (plan%how%rests) then
          tried = after(law, path, i, plan%factors(:, 1), rest, points(n_first + 1:, 1), attempt)
          differs = maxval(abs(tried(:3) - points(:3, 1))) > rounding*law%stress + &
            explicit*maxval(abs(points(:3, 1) - before(:, 1)))
        end if
        call send_row(merge([1.0_wp], [0.0_wp], differs), 1)
      else
        call send_row(points(:, 1), size(points, 1))
      end if
    end do
  end subroutine walk_there

  !> The increment that follows the largest unloading within a step, where results depend most on the history; a UMAT
  !> may lose the history at the start of each step.
  pure function most_unloaded(path) result(first)
    type(checked_path_type), intent(in) :: path   !! the path
    integer :: first
    real(wp) :: largest, most, now
    integer :: i
    first = size(path%dt)/2 + 1
    largest = 0.0_wp
    most = 0.0_wp
    do i = 1, size(path%dt) - 1
      now = norm2(path%s(:, i + 1))
      if (path%increment(i) == 1) largest = norm2(path%s(:, i))
      largest = max(largest, now)
      if (largest - now <= most .or. path%increment(i + 1) == 1) cycle
      most = largest - now
      first = i + 1
    end do
  end function most_unloaded

  !> Traction, and whether STATEV changes, with each component at the end of an increment larger and smaller, by two
  !> steps.
  function differences_at(law, plan, i, attempt) result(differences)
    type(foreign_law), intent(in) :: law      !! the law
    type(walk_type), intent(in) :: plan       !! the walk
    integer, intent(in) :: i                  !! increment
    integer, intent(inout) :: attempt         !! number of calls so far
    real(wp) :: beside(4, 2, 2, 3), differences(n_differences), move(3), there(n_first + law%n_state)
    integer :: j, k, side, statev
    statev = n_header + law%umat%ntens
    beside = 0.0_wp
    do j = 1, 3
      if (law%umat%position(j) == 0) cycle
      do k = 1, 2
        do side = 1, 2
          move = 0.0_wp
          move(j) = merge(1.0_wp, -1.0_wp, side == 1)*difference(k)*law%s_0
          associate (old => plan%known(n_first + 1:, i, 1))
            there = after(law, plan%path, i, plan%factors(:, 1), whole, old, attempt, move)
            beside(:3, side, k, j) = there(:3)
            if (any(abs(there(n_first + statev + 1:) - old(statev + 1:)) > 0.0_wp)) beside(4, side, k, j) = 1.0_wp
          end associate
        end do
      end do
    end do
    differences = reshape(beside, shape(differences))
  end function differences_at

  !> Results after a part of an increment.
  function after(law, path, i, factors, part, old, attempt, move) result(results)
    type(foreign_law), intent(in) :: law                  !! the law
    type(checked_path_type), intent(in) :: path           !! the path
    integer, intent(in) :: i                              !! increment
    real(wp), intent(in) :: factors(3)                    !! of the components of the path
    real(wp), intent(in) :: part(2)                       !! start and end, 0 to 1
    real(wp), intent(in) :: old(:)                        !! state at the start
    integer, intent(inout) :: attempt                     !! number of calls so far
    real(wp), intent(in), optional :: move(3)             !! added to the separation at the end
    real(wp) :: results(n_first + size(old))
    type(point_type) :: ends(2)
    real(wp) :: not_obeyed
    integer :: k
    do k = 1, 2
      ends(k)%s = factors*(path%s(:, i) + part(k)*(path%s(:, i + 1) - path%s(:, i)))
      if (part(k) >= 1.0_wp) ends(k)%s = factors*path%s(:, i + 1)
      ends(k)%state = old
    end do
    if (present(move)) ends(2)%s = ends(2)%s + move
    attempt = attempt + 1
    call law%update(call_type(path%step(i), path%increment(i), attempt, duration=(part(2) - part(1))*path%dt(i)), &
      ends(1), ends(2), not_obeyed)
    results = [ends(2)%traction, reshape(ends(2)%tangent, [9]), ends(2)%state]
  end function after

  !> Go along the path of a thread many times, and compare.
  subroutine walk_often(which, data) bind(c, name="asperity_umat_walk_often")
    integer(c_int), value :: which   !! thread, 1 or 2
    type(c_ptr), value :: data       !! walk
    type(walk_type), pointer :: plan
    type(foreign_law) :: law
    real(wp), allocatable :: results(:)
    integer :: attempt, i, k
    integer(int64) :: began, now, rate
    call c_f_pointer(data, plan)
    law = plan%path%law
    attempt = 0
    call system_clock(began, rate)
    do i = 1, 1 + thread_updates/size(plan%path%dt)
      results = [spread(0.0_wp, 1, n_first), plan%path%start]
      do k = 1, size(plan%path%dt)
        results = after(law, plan%path, k, plan%factors(:, which), whole, results(n_first + 1:), attempt)
        if (any(abs(results - plan%known(:, k + 1, which)) > 0.0_wp)) plan%differs(which) = min(plan%differs(which), k)
      end do
      call system_clock(now)
      if (real(now - began, wp) > thread_seconds*real(rate, wp)) exit
    end do
  end subroutine walk_often

end module asperity_umat_walk
