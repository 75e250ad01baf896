!> The update point by point: textbook, the library's point kernel, UMAT and driver.
module point_work
  use asperity_control_point, only: new_point
  use asperity_errors, only: errors_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_load_path, only: next_row, path_row_type => row_type, run_type, start_run
  use asperity_point, only: update_point
  use asperity_rie_law, only: new_rie_law
  use asperity_steps, only: complete_steps, step_table, step_type
  use host_routines, only: umat
  use measure, only: row_type, work_type
  use start_states, only: joint_of, new_start_states
  use textbook, only: textbook_update
  implicit none
  private
  public :: point_work_type, new_point_work, new_test_work

  !> Increments of the confined slip test: preload, then slips.
  integer, parameter :: n_preload = 10, n_slips = 240

  !> Points at the start and at the end of their increment.
  type, extends(work_type) :: point_work_type
    type(interface_type) :: joint
    real(wp), allocatable :: props(:), s_old(:, :), s(:, :), ds(:, :), old(:, :), new(:, :)
  contains
    procedure :: run
  end type point_work_type

contains

  !> Allocate and fill n points; the textbook version and the point kernel must agree.
  subroutine new_point_work(props, kind, n, work)
    real(wp), intent(in) :: props(:)                !! PROPS
    integer, intent(in) :: kind                     !! slip, zones or scattered
    integer, intent(in) :: n                        !! points
    type(point_work_type), intent(out) :: work
    !> Largest difference of traction over K |s| and of tangent over K, far above the rounding errors of the law.
    real(wp), parameter :: rounding = 1.0e-12_wp
    real(wp) :: t(3), t_point(3), d(3, 3), d_point(3, 3), k
    integer :: p
    call new_test_work(props, work)
    work%props = props
    work%points = n
    call new_start_states(work%joint, kind, n, work%s_old, work%s, work%old)
    work%ds = work%s - work%s_old
    work%new = work%old
    if (work%joint%material%curved) return   ! the textbook version has no facets
    k = max(work%joint%material%k_n, work%joint%material%k_t, work%joint%material%k_c)
    do p = 1, n
      call textbook_update(work%joint, work%s(:, p), work%old(:, p), work%new(:, p), t, d)
      call update_point(work%joint, work%s_old(:, p), work%s(:, p), work%old(:, p), work%new(:, p), t_point, d_point)
      if (.not. (maxval(abs(t - t_point)) <= rounding*k*maxval(abs(work%s(:, p))) .and. &
                 maxval(abs(d - d_point)) <= rounding*k)) error stop "bench: textbook and point kernel disagree"
    end do
  end subroutine new_point_work

  !> The interface for the test, whose points are increments.
  subroutine new_test_work(props, work)
    real(wp), intent(in) :: props(:)                !! PROPS
    type(point_work_type), intent(out) :: work
    work%joint = joint_of(props)
    work%planes = work%joint%pattern%n
    work%points = n_preload + n_slips
  end subroutine new_test_work

  !> Run a kernel for all points.
  subroutine run(work, row, used)
    class(point_work_type), intent(inout) :: work   !! the points
    type(row_type), intent(in) :: row               !! kernel, tangent
    real(wp), intent(inout) :: used                 !! sum of results
    character(len=80), parameter :: name = "BENCH"
    real(wp) :: t(3), d(3, 3), sse, spd, scd
    integer :: p
    logical :: hosted, point
    if (row%kernel == "test") then
      call run_test(work%joint, used)
      return
    end if
    point = row%kernel == "point"
    hosted = row%kernel == "umat"
    t = 0.0_wp
    d = 0.0_wp
    sse = 0.0_wp
    spd = 0.0_wp
    scd = 0.0_wp
    do p = 1, size(work%s, 2)
      if (point) then
        call update_point(work%joint, work%s_old(:, p), work%s(:, p), work%old(:, p), work%new(:, p), t, d)
      else if (hosted) then
        work%new(:, p) = work%old(:, p)
        call umat(t, work%new(:, p), d, sse, spd, scd, stran=work%s_old(:, p), dstran=work%ds(:, p), cmname=name, &
          ndi=1, nshr=2, ntens=3, nstatv=size(work%new, 1), props=work%props, nprops=size(work%props))
      else if (row%tangent) then
        call textbook_update(work%joint, work%s(:, p), work%old(:, p), work%new(:, p), t, d)
      else
        call textbook_update(work%joint, work%s(:, p), work%old(:, p), work%new(:, p), t)
      end if
      used = used + t(1) + d(1, 1)
    end do
  end subroutine run

  !> Run a confined slip test with a reversal by the solver of the driver, with all Newton iterations.
  subroutine run_test(joint, used)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(inout) :: used             !! sum of results
    type(step_type), allocatable :: steps(:)
    type(run_type) :: path
    type(path_row_type) :: row
    type(errors_type) :: errors
    integer :: i
    logical :: found
    allocate (steps(2))
    do i = 1, size(step_table)
      select case (step_table(i)%name)
      case ("t_N")
        steps(1)%given(i)%values = [-10.0_wp]
      case ("slip")
        steps(2)%given(i)%values = 20.0_wp*joint%material%s0*[1.0_wp, 0.0_wp]
      case ("increments")
        steps(1)%given(i)%values = [real(n_preload, wp)]
        steps(2)%given(i)%values = [0.5_wp*real(n_slips, wp)]
      case default  ! the other values keep their defaults
      end select
    end do
    call complete_steps(steps, errors)
    call start_run(new_rie_law(joint), steps, path, new_point(new_rie_law(joint)))
    found = .true.
    do while (found)
      call next_row(path, row, found)
      if (found) used = used + row%traction(2)
    end do
  end subroutine run_test

end module point_work
