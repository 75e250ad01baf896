!> Points whose values stand together: the textbook version, the library's point kernel and UMAT one point after the
!> other, and the arrays of C and Python, by one thread.
module point_work
  !$ use omp_lib, only: omp_set_num_threads
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_point, only: update_point
  use asperity_arrays, only: update_points
  use host_routines, only: umat
  use start_states, only: n_states, start_type
  use textbook, only: textbook_update
  implicit none
  private
  public :: point_work_type, new_point_work, run

  !> Points with their results.
  type :: point_work_type
    type(start_type) :: start
    real(wp), allocatable :: ds(:, :), new(:, :), traction(:, :), tangent(:, :, :)
  end type point_work_type

contains

  !> Make the work for points; the textbook version and the point kernel must agree.
  subroutine new_point_work(start, work)
    type(start_type), intent(in) :: start            !! the points
    type(point_work_type), intent(out) :: work
    !> Largest difference of traction over K |s| and of tangent over K, far above the rounding errors of the law.
    real(wp), parameter :: rounding = 1.0e-12_wp
    real(wp) :: t(3), t_point(3), d(3, 3), d_point(3, 3), k
    integer :: n, p
    work%start = start
    work%ds = start%s - start%s_old
    n = size(start%s, 2)
    allocate (work%traction(3, n), work%tangent(3, 3, n))
    work%new = start%state
    work%traction = 0.0_wp
    work%tangent = 0.0_wp
    if (start%joint%material%curved .or. start%joint%material%damps) return   ! the textbook version knows none of both
    k = max(start%joint%material%k_n, start%joint%material%k_t, start%joint%material%k_c)
    do p = 1, min(n_states, n)
      call textbook_update(start%joint, start%s(:, p), start%state(:, p), work%new(:, p), t, d)
      call update_point(start%joint, start%s_old(:, p), start%s(:, p), start%state(:, p), work%new(:, p), t_point, &
        d_point)
      if (.not. (maxval(abs(t - t_point)) <= rounding*k*maxval(abs(start%s(:, p))) .and. &
                 maxval(abs(d - d_point)) <= rounding*k)) error stop "bench: textbook and point kernel disagree"
    end do
  end subroutine new_point_work

  !> Run a kernel once for all points. Arrays are updated in place; a copy moves the bytes of their update (reads of
  !> separation and state, writes of state and traction) as the hardware limit.
  subroutine run(work, kernel, with_tangent, used)
    type(point_work_type), intent(inout) :: work   !! the points
    character(len=*), intent(in) :: kernel         !! which one
    logical, intent(in) :: with_tangent            !! whether arrays and the textbook version compute the tangent
    real(wp), intent(inout) :: used                !! sum of results
    character(len=80), parameter :: name = "BENCH"
    real(wp), parameter :: duration = 1.0_wp
    real(wp) :: t(3), d(3, 3), e(3)
    integer :: failed, p, status
    !$ call omp_set_num_threads(1)
    status = status_ok
    t = 0.0_wp
    d = 0.0_wp
    e = 0.0_wp
    associate (start => work%start, new => work%new)
      select case (kernel)
      case ("copy")
        do p = 1, size(new, 2)
          work%traction(:, p) = start%s(:, p) + start%s_old(:, p)
          new(:, p) = start%state(:, p)
        end do
      case ("points")
        if (with_tangent) then
          call update_points(start%joint, start%s, new, work%traction, status, failed, start%s_old, work%tangent, &
            duration, by_rows=.true.)
        else
          call update_points(start%joint, start%s, new, work%traction, status, failed, start%s_old, dt=duration)
        end if
      case ("point")
        do p = 1, size(new, 2)
          call update_point(start%joint, start%s_old(:, p), start%s(:, p), start%state(:, p), new(:, p), t, d, duration)
          used = used + t(1) + d(1, 1)
        end do
      case ("umat")
        do p = 1, size(new, 2)
          new(:, p) = start%state(:, p)
          call umat(t, new(:, p), d, e(1), e(2), e(3), stran=start%s_old(:, p), dstran=work%ds(:, p), cmname=name, &
            ndi=1, nshr=2, ntens=3, nstatv=size(new, 1), props=start%props, nprops=size(start%props), &
            dtime=duration)
          used = used + t(1) + d(1, 1)
        end do
      case default
        do p = 1, size(new, 2)
          if (with_tangent) call textbook_update(start%joint, start%s(:, p), start%state(:, p), new(:, p), t, d)
          if (.not. with_tangent) call textbook_update(start%joint, start%s(:, p), start%state(:, p), new(:, p), t)
          used = used + t(1) + d(1, 1)
        end do
      end select
    end associate
    if (status /= status_ok) error stop "bench: a point was rejected"
    used = used + work%traction(1, 1) + work%new(1, 1)
  end subroutine run

end module point_work
