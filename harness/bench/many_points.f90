!> Arrays of points as Python and C pass them, processed by one or more threads, and a copy of the same bytes as the
!> hardware limit.
module many_points
  !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type
  use asperity_points, only: update_points
  use asperity_kinds, only: wp
  use start_states, only: new_start_states, slip
  implicit none
  private
  public :: many_work_type, new_many_work, run_points, run_copy, most_threads

  !> Points at the start and at the end of their increment.
  type :: many_work_type
    type(interface_type) :: joint
    real(wp), allocatable :: s_old(:, :), s(:, :), state(:, :), copied(:, :), traction(:, :)
  end type many_work_type

contains

  !> Number of threads of the machine; 1 if the benchmark was built without OpenMP.
  function most_threads() result(n)
    integer :: n
    n = 1
    !$ n = omp_get_max_threads()
  end function most_threads

  !> Allocate and fill n points, all slipping under compression. Each thread first writes the memory that it uses later.
  subroutine new_many_work(joint, n, work)
    type(interface_type), intent(in) :: joint       !! the interface
    integer, intent(in) :: n                        !! points
    type(many_work_type), intent(out) :: work
    integer, parameter :: few = 64
    real(wp) :: s_old(3, few), s(3, few), state(joint%n_statev, few)
    integer :: i, p
    work%joint = joint
    allocate (work%s_old(3, n), work%s(3, n), work%traction(3, n))
    allocate (work%state(joint%n_statev, n), work%copied(joint%n_statev, n))
    call new_start_states(joint, slip, s_old, s, state)
    !$omp parallel do schedule(static) private(p)
    do i = 1, n
      p = 1 + modulo(i, few)
      work%s_old(:, i) = s_old(:, p)
      work%s(:, i) = s(:, p)
      work%state(:, i) = state(:, p)
      work%copied(:, i) = state(:, p)
      work%traction(:, i) = 0.0_wp
    end do
    !$omp end parallel do
  end subroutine new_many_work

  !> Run the checked update of all points in place, without tangent.
  subroutine run_points(work, threads, used)
    type(many_work_type), intent(inout) :: work   !! the points
    integer, intent(in) :: threads                !! number of threads
    real(wp), intent(inout) :: used               !! sum of results
    integer :: failed, status
    call set_threads(threads)
    call update_points(work%joint, work%s, work%state, work%traction, status, failed, work%s_old)
    if (status /= status_ok) error stop "bench: a point was rejected"
    used = used + work%traction(1, 1)
  end subroutine run_points

  !> Hardware limit: a copy of the bytes that `run_points` moves (reads of separation and state, writes of state and
  !> traction).
  subroutine run_copy(work, threads, used)
    type(many_work_type), intent(inout) :: work   !! the points
    integer, intent(in) :: threads                !! number of threads
    real(wp), intent(inout) :: used               !! sum of results
    integer :: i
    call set_threads(threads)
    !$omp parallel do schedule(static)
    do i = 1, size(work%s, 2)
      work%traction(:, i) = work%s(:, i) + work%s_old(:, i)
      work%copied(:, i) = work%state(:, i)
    end do
    !$omp end parallel do
    used = used + work%traction(1, 1) + work%copied(1, 1)
  end subroutine run_copy

  !> Set the number of threads of the following parallel regions.
  subroutine set_threads(n)
    integer, intent(in) :: n   !! number of threads
    !$ call omp_set_num_threads(n)
    if (n < 1) error stop "bench: no thread"
  end subroutine set_threads

end module many_points
