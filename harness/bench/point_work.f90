!> The update point by point: textbook, the library's point kernel, UMAT and driver.
module point_work
  use asperity_errors, only: errors_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_point, only: update_point
  use host_routines, only: umat
  use asperity_control_point, only: new_point
  use asperity_load_path, only: start_run, next_row, row_type, run_type
  use asperity_rie_law, only: new_rie_law
  use asperity_steps, only: complete_steps, step_table, step_type
  use start_states, only: new_start_states
  use textbook, only: textbook_numerical_tangent, textbook_update
  implicit none
  private
  public :: point_work_type, new_point_work, textbook_error, run_textbook_numerical, run_textbook, run_point, &
    run_umat, run_test

  !> Increments of the confined slip test: preload, then slips.
  integer, parameter :: n_preload = 10, n_slips = 240
  integer, parameter, public :: n_test_increments = n_preload + n_slips

  !> Points at the start and at the end of their increment.
  type :: point_work_type
    type(interface_type) :: joint
    real(wp), allocatable :: props(:), s_old(:, :), s(:, :), ds(:, :), old(:, :), new(:, :)
  end type point_work_type

contains

  !> Allocate and fill n points.
  pure subroutine new_point_work(props, joint, kind, n, work)
    real(wp), intent(in) :: props(:)                !! PROPS
    type(interface_type), intent(in) :: joint       !! made of them
    integer, intent(in) :: kind                     !! slip, zones or scattered
    integer, intent(in) :: n                        !! points
    type(point_work_type), intent(out) :: work
    work%joint = joint
    work%props = props
    allocate (work%s_old(3, n), work%s(3, n), work%ds(3, n))
    allocate (work%old(joint%n_statev, n), work%new(joint%n_statev, n))
    call new_start_states(joint, kind, work%s_old, work%s, work%old)
    work%ds = work%s - work%s_old
    work%new = work%old
  end subroutine new_point_work

  !> Largest difference of the textbook version from the point kernel: traction over K |s|, tangent over K.
  pure function textbook_error(work) result(worst)
    type(point_work_type), intent(in) :: work   !! the points
    real(wp) :: worst
    real(wp), dimension(size(work%old, 1)) :: state, new
    real(wp) :: t(3), t_point(3), d(3, 3), d_point(3, 3), k
    integer :: p
    k = max(work%joint%material%k_n, work%joint%material%k_t, work%joint%material%k_c)
    worst = 0.0_wp
    do p = 1, size(work%s, 2)
      call textbook_update(work%joint, work%s(:, p), work%old(:, p), state, t, d)
      call update_point(work%joint, work%s_old(:, p), work%s(:, p), work%old(:, p), new, t_point, d_point)
      worst = max(worst, maxval(abs(t - t_point))/(k*maxval(abs(work%s(:, p)))), maxval(abs(d - d_point))/k)
    end do
  end function textbook_error

  !> Run the textbook version with a tangent by central differences.
  pure subroutine run_textbook_numerical(work, used)
    type(point_work_type), intent(inout) :: work   !! the points
    real(wp), intent(inout) :: used                !! sum of results
    real(wp) :: t(3), d(3, 3)
    integer :: p
    do p = 1, size(work%s, 2)
      call textbook_numerical_tangent(work%joint, work%s(:, p), work%old(:, p), work%new(:, p), t, d)
      used = used + t(1) + d(1, 1)
    end do
  end subroutine run_textbook_numerical

  !> Run the textbook version without or with its analytical tangent.
  pure subroutine run_textbook(work, with_tangent, used)
    type(point_work_type), intent(inout) :: work   !! the points
    logical, intent(in) :: with_tangent            !! whether the tangent is wanted
    real(wp), intent(inout) :: used                !! sum of results
    real(wp) :: t(3), d(3, 3)
    integer :: p
    d = 0.0_wp
    do p = 1, size(work%s, 2)
      if (with_tangent) then
        call textbook_update(work%joint, work%s(:, p), work%old(:, p), work%new(:, p), t, d)
      else
        call textbook_update(work%joint, work%s(:, p), work%old(:, p), work%new(:, p), t)
      end if
      used = used + t(1) + d(1, 1)
    end do
  end subroutine run_textbook

  !> Run the library's point kernel.
  pure subroutine run_point(work, used)
    type(point_work_type), intent(inout) :: work   !! the points
    real(wp), intent(inout) :: used                !! sum of results
    real(wp) :: t(3), d(3, 3)
    integer :: p
    do p = 1, size(work%s, 2)
      call update_point(work%joint, work%s_old(:, p), work%s(:, p), work%old(:, p), work%new(:, p), t, d)
      used = used + t(1) + d(1, 1)
    end do
  end subroutine run_point

  !> Call the UMAT as a host does.
  subroutine run_umat(work, used)
    type(point_work_type), intent(inout) :: work   !! the points
    real(wp), intent(inout) :: used                !! sum of results
    character(len=80), parameter :: name = "BENCH"
    real(wp) :: t(3), d(3, 3), sse, spd, scd
    integer :: p
    t = 0.0_wp
    sse = 0.0_wp
    spd = 0.0_wp
    scd = 0.0_wp
    do p = 1, size(work%s, 2)
      work%new(:, p) = work%old(:, p)
      call umat(t, work%new(:, p), d, sse, spd, scd, stran=work%s_old(:, p), dstran=work%ds(:, p), cmname=name, &
        ndi=1, nshr=2, ntens=3, nstatv=size(work%new, 1), props=work%props, nprops=size(work%props))
      used = used + t(1) + d(1, 1)
    end do
  end subroutine run_umat

  !> Run a confined slip test with a reversal by the solver of the driver, with all Newton iterations.
  subroutine run_test(work, used)
    type(point_work_type), intent(in) :: work   !! the interface
    real(wp), intent(inout) :: used             !! sum of results
    type(step_type), allocatable :: steps(:)
    type(run_type) :: run
    type(row_type) :: row
    type(errors_type) :: errors
    integer :: i, n_done
    logical :: found
    allocate (steps(2))
    do i = 1, size(step_table)
      select case (step_table(i)%name)
      case ("t_N")
        steps(1)%given(i)%values = [-10.0_wp]
      case ("slip")
        steps(2)%given(i)%values = 20.0_wp*work%joint%material%s0*[1.0_wp, 0.0_wp]
      case ("increments")
        steps(1)%given(i)%values = [real(n_preload, wp)]
        steps(2)%given(i)%values = [0.5_wp*real(n_slips, wp)]
      case default  ! the other values keep their defaults
      end select
    end do
    call complete_steps(steps, errors)
    call start_run(new_rie_law(work%joint), steps, run, new_point(new_rie_law(work%joint)))
    n_done = 0
    do
      call next_row(run, row, found)
      if (.not. found) exit
      n_done = n_done + 1
    end do
    used = used + row%traction(2) + real(n_done, wp)
  end subroutine run_test

end module point_work
