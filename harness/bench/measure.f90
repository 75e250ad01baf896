!> What the benchmark measures: rows of its table, points on which kernels run, and their times.
module measure
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none
  private
  public :: row_type, work_type, take_turns, median

  !> A row of the table: what was measured, and its time.
  type :: row_type
    character(len=8) :: pattern = ""      !! name of the pattern
    integer :: planes = 0                 !! number of planes
    character(len=9) :: kernel = ""       !! textbook, point, umat, test, block, roots, vumat, stream, points, copy
    character(len=6) :: precision = "double"
    logical :: tangent = .false.          !! whether the kernel computes the tangent
    character(len=9) :: states = "slip"   !! states of the points at the start
    integer :: points = 0                 !! number of points
    integer :: threads = 1                !! number of threads
    real(real64) :: ns = 0.0_real64       !! nanoseconds per point (test: per increment)
  end type row_type

  !> Points in the form of some kernels.
  type, abstract :: work_type
    integer :: planes = 0   !! number of planes
    integer :: points = 0   !! points (test: increments) of a run
  contains
    procedure(run_kernel), deferred :: run
  end type work_type

  abstract interface
    !> Run the kernel of a row once for all points.
    subroutine run_kernel(work, row, used)
      import :: real64, row_type, work_type
      implicit none
      class(work_type), intent(inout) :: work   !! the points
      type(row_type), intent(in) :: row         !! kernel, tangent, threads
      real(real64), intent(inout) :: used       !! sum of results
    end subroutine run_kernel
  end interface

contains

  !> Median time of every row. The rows run alternately, and each run repeats its kernel until it lasts `shortest`.
  subroutine take_turns(work, rows, turns, shortest, used)
    class(work_type), intent(inout) :: work     !! the points
    type(row_type), intent(inout) :: rows(:)    !! tasks -> with points, planes and times
    integer, intent(in) :: turns                !! number of repetitions
    real(real64), intent(in) :: shortest        !! time of a run, ns
    real(real64), intent(inout) :: used         !! sum of results
    real(real64) :: times(turns, size(rows)), start
    integer :: i, loop, loops(size(rows)), turn

    rows%planes = work%planes
    rows%points = work%points
    do i = 1, size(rows)
      call work%run(rows(i), used)
      start = now()
      call work%run(rows(i), used)
      loops(i) = 1 + int(shortest/max(now() - start, 1.0_real64))
    end do
    do turn = 1, turns
      do i = 1, size(rows)
        start = now()
        do loop = 1, loops(i)
          call work%run(rows(i), used)
        end do
        times(turn, i) = (now() - start)/real(loops(i)*work%points, real64)
      end do
    end do
    do i = 1, size(rows)
      rows(i)%ns = median(times(:, i))
    end do
  end subroutine take_turns

  !> Time from an arbitrary start, nanoseconds.
  function now() result(t)
    real(real64) :: t
    integer(int64) :: count, rate
    call system_clock(count, rate)
    t = 1.0e9_real64*real(count, real64)/real(rate, real64)
  end function now

  !> The lower median: at least half of the values are not larger, at least half not smaller.
  pure function median(x) result(middle)
    real(real64), intent(in) :: x(:)   !! values, at least one
    real(real64) :: middle
    integer :: i, half
    half = (size(x) + 1)/2
    middle = x(1)
    do i = 1, size(x)
      if (count(x < x(i)) < half .and. count(x <= x(i)) >= half) middle = x(i)
    end do
  end function median

end module measure
