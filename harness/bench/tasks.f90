!> Tasks of the benchmark and their timing: the tasks run alternately, and the median over the repetitions counts.
module tasks
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type, new_interface
  use block_work_double, only: double_block => block_work_type, double_large => large_work_type, &
    new_double_block => new_block_work, new_double_large => new_large_work, run_double_block => run_block, &
    run_double_roots => run_roots, run_double_stream => run_stream, run_double_vumat => run_vumat
  use block_work_single, only: single_block => block_work_type, single_large => large_work_type, &
    new_single_block => new_block_work, new_single_large => new_large_work, run_single_block => run_block, &
    run_single_roots => run_roots, run_single_stream => run_stream, run_single_vumat => run_vumat
  use many_points, only: many_work_type, new_many_work, run_copy, run_points
  use point_work, only: n_test_increments, new_point_work, point_work_type, run_point, run_test, run_textbook, &
    run_textbook_numerical, run_umat, textbook_error
  use timing, only: median, now
  implicit none
  private
  public :: row_type, workspace_type, new_workspace, new_large_workspace, new_array_workspace, run_often, take_turns

  !> A row of the table: what was measured, and its times.
  type :: row_type
    character(len=8) :: pattern = ""      !! name of the pattern
    integer :: planes = 0                 !! number of planes
    character(len=9) :: kernel = ""       !! numerical, textbook, point, umat, test, block, roots, vumat, stream,
                                          !! points, copy
    character(len=6) :: precision = "double"
    logical :: tangent = .false.          !! whether the kernel computes the tangent
    character(len=9) :: states = "slip"   !! states of the points at the start, from state_names
    integer :: points = 0                 !! number of points
    integer :: threads = 1                !! number of threads
    real(real64) :: ns = 0.0_real64       !! nanoseconds per point (test: per increment)
    real(real64) :: textbook = 0.0_real64   !! ns of the textbook version, 0: none
    real(real64) :: stream = 0.0_real64     !! ns of a copy of the same bytes, 0: none
    real(real64) :: roots = 0.0_real64      !! ns of the square roots and divisions alone, 0: none
  end type row_type

  !> Points of a measurement, in the form of each kernel.
  type :: workspace_type
    type(point_work_type) :: point
    type(double_block) :: double
    type(single_block) :: single
    type(double_large) :: double_large
    type(single_large) :: single_large
    type(many_work_type) :: many
    integer :: planes = 0   !! number of planes
    integer :: points = 0   !! number of points
  end type workspace_type

contains

  !> A small workspace, with data in the first-level cache.
  subroutine new_workspace(props, kind, n, work)
    real(real64), intent(in) :: props(:)        !! PROPS
    integer, intent(in) :: kind                 !! slip, zones or scattered
    integer, intent(in) :: n                    !! points
    type(workspace_type), intent(out) :: work
    !> Largest difference between textbook version and point kernel, far above the rounding errors of the law.
    real(real64), parameter :: rounding = 1.0e-12_real64
    type(interface_type) :: joint
    integer :: status
    call begin(props, n, work, joint)
    call new_point_work(props, joint, kind, n, work%point)
    ! the textbook version has no facets
    if (.not. joint%material%curved) then
      if (.not. textbook_error(work%point) <= rounding) error stop "bench: textbook and point kernel disagree"
    end if
    call new_double_block(joint, kind, n, work%double, status)
    if (status /= status_ok) error stop "bench: PROPS rejected in double precision"
    call new_single_block(joint, kind, n, work%single, status)
    if (status /= status_ok) error stop "bench: PROPS rejected in single precision"
  end subroutine new_workspace

  !> A large workspace in one precision, with data in memory.
  subroutine new_large_workspace(props, precision, width, calls, work)
    real(real64), intent(in) :: props(:)        !! PROPS
    character(len=*), intent(in) :: precision   !! double or single
    integer, intent(in) :: width                !! points of a VUMAT call
    integer, intent(in) :: calls                !! number of calls
    type(workspace_type), intent(out) :: work
    type(interface_type) :: joint
    call begin(props, width*calls, work, joint)
    if (precision == "double") then
      call new_double_large(props, joint, width, calls, work%double_large)
    else
      call new_single_large(props, joint, width, calls, work%single_large)
    end if
  end subroutine new_large_workspace

  !> A workspace of arrays as Python and C pass them.
  subroutine new_array_workspace(props, n, work)
    real(real64), intent(in) :: props(:)        !! PROPS
    integer, intent(in) :: n                    !! points
    type(workspace_type), intent(out) :: work
    type(interface_type) :: joint
    call begin(props, n, work, joint)
    call new_many_work(joint, n, work%many)
  end subroutine new_array_workspace

  !> Make the interface of a workspace and set its numbers of planes and points.
  subroutine begin(props, n, work, joint)
    real(real64), intent(in) :: props(:)            !! PROPS
    integer, intent(in) :: n                        !! points
    type(workspace_type), intent(inout) :: work     !! its numbers are set
    type(interface_type), intent(out) :: joint      !! made of PROPS
    integer :: status
    call new_interface(props, joint, status)
    if (status /= status_ok) error stop "bench: PROPS rejected"
    work%planes = joint%pattern%n
    work%points = n
  end subroutine begin

  !> Run the kernel of a row once for all points.
  subroutine run(work, row, used)
    type(workspace_type), intent(inout) :: work   !! the points
    type(row_type), intent(in) :: row             !! kernel, precision, tangent
    real(real64), intent(inout) :: used           !! sum of results
    select case (trim(row%kernel) // " " // row%precision)
    case ("numerical double")
      call run_textbook_numerical(work%point, used)
    case ("textbook double")
      call run_textbook(work%point, row%tangent, used)
    case ("point double")
      call run_point(work%point, used)
    case ("umat double")
      call run_umat(work%point, used)
    case ("test double")
      call run_test(work%point, used)
    case ("block double")
      call run_double_block(work%double, row%tangent, used)
    case ("block single")
      call run_single_block(work%single, row%tangent, used)
    case ("roots double")
      call run_double_roots(work%double, used)
    case ("roots single")
      call run_single_roots(work%single, used)
    case ("vumat double")
      call run_double_vumat(work%double_large, used)
    case ("vumat single")
      call run_single_vumat(work%single_large, used)
    case ("points double")
      call run_points(work%many, row%threads, used)
    case ("copy double")
      call run_copy(work%many, row%threads, used)
    case ("stream double")
      call run_double_stream(work%double_large, used)
    case ("stream single")
      call run_single_stream(work%single_large, used)
    case default
      error stop "bench: no such kernel"
    end select
  end subroutine run

  !> Run the kernel of a row many times.
  subroutine run_often(work, row, runs, used)
    type(workspace_type), intent(inout) :: work   !! the points
    type(row_type), intent(in) :: row             !! kernel, precision, tangent
    integer, intent(in) :: runs                   !! number of runs
    real(real64), intent(inout) :: used           !! sum of results
    integer :: i
    do i = 1, runs
      call run(work, row, used)
    end do
  end subroutine run_often

  !> Median time of every row. The rows run alternately, and each run repeats its kernel until it lasts `shortest`.
  subroutine take_turns(work, rows, turns, shortest, used)
    type(workspace_type), intent(inout) :: work     !! the points
    type(row_type), intent(inout) :: rows(:)        !! tasks -> with points, planes and times
    integer, intent(in) :: turns                    !! number of repetitions
    real(real64), intent(in) :: shortest            !! time of a run, ns
    real(real64), intent(inout) :: used             !! sum of results
    real(real64) :: times(turns, size(rows)), start
    integer :: i, loops(size(rows)), units, turn

    do i = 1, size(rows)
      call run(work, rows(i), used)
      start = now()
      call run(work, rows(i), used)
      loops(i) = 1 + int(shortest/max(now() - start, 1.0_real64))
    end do
    do turn = 1, turns
      do i = 1, size(rows)
        start = now()
        call run_often(work, rows(i), loops(i), used)
        times(turn, i) = (now() - start)/real(loops(i), real64)
      end do
    end do
    do i = 1, size(rows)
      units = merge(n_test_increments, work%points, rows(i)%kernel == "test")
      rows(i)%planes = work%planes
      rows(i)%points = merge(1, work%points, rows(i)%kernel == "test")
      rows(i)%ns = median(times(:, i))/real(units, real64)
    end do
  end subroutine take_turns

end module tasks
