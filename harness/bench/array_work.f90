!> Arrays of points as Python and C pass them, processed by one or more threads, and a copy of the same bytes as the
!> hardware limit.
module array_work
  !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type
  use asperity_points, only: update_points
  use asperity_kinds, only: wp
  use measure, only: row_type, work_type
  use start_states, only: joint_of, new_start_states, slip
  implicit none
  private
  public :: array_work_type, new_array_work, most_threads

  !> Points at the start and at the end of their increment.
  type, extends(work_type) :: array_work_type
    type(interface_type) :: joint
    real(wp), allocatable :: s_old(:, :), s(:, :), state(:, :), copied(:, :), traction(:, :), tangent(:, :, :)
  contains
    procedure :: run
  end type array_work_type

contains

  !> Number of threads of the machine; 1 if the benchmark was built without OpenMP.
  function most_threads() result(n)
    integer :: n
    n = 1
    !$ n = omp_get_max_threads()
  end function most_threads

  !> Allocate and fill n points, all slipping under compression. Each thread first writes the memory that it uses later.
  subroutine new_array_work(props, n, work)
    real(wp), intent(in) :: props(:)                !! PROPS
    integer, intent(in) :: n                        !! points
    type(array_work_type), intent(out) :: work
    integer, parameter :: few = 64
    real(wp), allocatable :: s_old(:, :), s(:, :), state(:, :)
    integer :: i, p
    work%joint = joint_of(props)
    work%planes = work%joint%pattern%n
    work%points = n
    call new_start_states(work%joint, slip, few, s_old, s, state)
    allocate (work%s_old(3, n), work%s(3, n), work%traction(3, n), work%tangent(3, 3, n))
    allocate (work%state(size(state, 1), n), work%copied(size(state, 1), n))
    !$omp parallel do schedule(static) private(p)
    do i = 1, n
      p = 1 + modulo(i, few)
      work%s_old(:, i) = s_old(:, p)
      work%s(:, i) = s(:, p)
      work%state(:, i) = state(:, p)
      work%copied(:, i) = state(:, p)
      work%traction(:, i) = 0.0_wp
      work%tangent(:, :, i) = 0.0_wp
    end do
    !$omp end parallel do
  end subroutine new_array_work

  !> Run the checked update of all points in place, or copy the bytes that it moves (reads of separation and state,
  !> writes of state and traction).
  subroutine run(work, row, used)
    class(array_work_type), intent(inout) :: work   !! the points
    type(row_type), intent(in) :: row               !! kernel, tangent, threads
    real(wp), intent(inout) :: used                 !! sum of results
    integer :: failed, i, status
    !$ call omp_set_num_threads(row%threads)
    status = status_ok
    if (row%kernel == "copy") then
      !$omp parallel do schedule(static)
      do i = 1, work%points
        work%traction(:, i) = work%s(:, i) + work%s_old(:, i)
        work%copied(:, i) = work%state(:, i)
      end do
      !$omp end parallel do
    else if (row%tangent) then
      call update_points(work%joint, work%s, work%state, work%traction, status, failed, work%s_old, work%tangent, &
        by_rows=.true.)
    else
      call update_points(work%joint, work%s, work%state, work%traction, status, failed, work%s_old)
    end if
    if (status /= status_ok) error stop "bench: a point was rejected"
    used = used + work%traction(1, 1) + work%copied(1, 1)
  end subroutine run

end module array_work
