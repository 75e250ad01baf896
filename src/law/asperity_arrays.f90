!> Checked entry to the law: every input is tested before any point is updated.
module asperity_arrays
  use asperity_aim, only: update_aimed
  use asperity_call_checks, only: point_status, time_status
  use asperity_checks, only: all_bounded, is_pressure, limits_type, set_limits
  use asperity_kinds, only: wp
  use asperity_block_double, only: block_type, chunk, new_block
  use asperity_contract, only: energy_limit, status_ok, status_props, status_water
  use asperity_interface, only: interface_type, separation_bound, slip_bound
  use asperity_point_kernel, only: update_point_in_place
  use asperity_rows_kernel, only: rows_bounded
  use asperity_yielding_rows, only: update_rows
  implicit none
  private
  public :: virgin_tangent, update_points

  !> Smallest number of points for which threads are started.
  integer, parameter :: worth_threads = 2048

contains

  !> Largest elastic tangent of the virgin interface: with kc > 1 that of the closed planes, else that of the bond.
  pure function virgin_tangent(joint) result(tangent)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: tangent(3, 3)                       !! stress/length
    real(wp), parameter :: rest(3) = 0.0_wp
    ! a small pressure: every plane is closed and undamaged
    real(wp), parameter :: closed(3) = [-1.0e-6_wp, 0.0_wp, 0.0_wp]
    real(wp) :: state(joint%n_statev), traction(3), s(3)
    state = 0.0_wp
    s = rest
    if (joint%material%k_c > joint%material%k_n) s = joint%material%s0*closed
    call update_point_in_place(joint, rest, s, state, traction, tangent)
  end function virgin_tangent

  !> Update n points over one increment; nothing is written unless every input of every point is admissible.
  !>
  !> The points are processed in blocks, by several threads if the library is built with OpenMP. The result of a point
  !> does not depend, to the last bit, on which other points are in the call or on the number of threads. With an aim,
  !> traction and tangent are those of frozen variables (asperity_aim); the state is the same. IMPL-EX belongs to the
  !> UMAT alone: with implex > 0 the status is status_props.
  subroutine update_points(joint, s, state, traction, status, failed, s_old, tangent, dt, by_rows, aim, p)
    type(interface_type), intent(in) :: joint                     !! the interface
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(inout), contiguous :: state(:, :)            !! (nstatv, n) STATEV, start -> end
    real(wp), intent(inout), contiguous :: traction(:, :)         !! (3, n) traction at the end, stress
    integer, intent(out) :: status                                !! 0, status_props, status_time, status_water,
                                                                  !! or that of the first bad point
    integer, intent(out) :: failed                                !! number of the first bad point, 0: none
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    real(wp), intent(inout), optional, contiguous :: tangent(:, :, :)   !! (3, 3, n) d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt                          !! duration, required if tau_v or c > 0, time
    logical, intent(in), optional :: by_rows                      !! true: tangent(j, i, :), as C and Python store it
    real(wp), intent(in), optional, contiguous :: aim(:, :)       !! (3, n) separation of frozen variables, absent: none
    real(wp), intent(in), optional, contiguous :: p(:)            !! (n) water pressure: tractions are total; absent: 0
    type(block_type) :: block
    type(limits_type) :: limits
    logical :: rows
    integer :: first, n

    failed = 0
    status = time_status(joint, dt)
    if (joint%implex > 0.0_wp) status = status_props
    if (status == status_ok) call new_block(joint, block, status, dt)
    if (status /= status_ok) return
    n = size(s, 2)
    failed = n + 1
    call set_limits(joint%pattern%n, joint%material%wears, joint%n_statev, energy_limit, slip_bound(joint), limits)
    rows = .false.
    if (present(by_rows)) rows = by_rows
    ! a team of one thread would cost as much as a dozen points
    if (n < worth_threads) then
      do first = 1, n, chunk
        failed = min(failed, first_bad(first))
      end do
    else
      !$omp parallel do schedule(static) reduction(min: failed)
      do first = 1, n, chunk
        failed = min(failed, first_bad(first))
      end do
      !$omp end parallel do
    end if
    if (failed <= n) then
      status = status_of(failed)
      return
    end if
    failed = 0
    if (present(p)) then
      do first = n, 1, -1
        if (.not. is_pressure(p(first))) failed = first
      end do
      if (failed > 0) status = status_water
      if (failed > 0) return
    end if
    if (present(aim)) then
      !$omp parallel do schedule(static) if (n >= worth_threads)
      do first = 1, n, chunk
        call update_aimed(joint, block, first, min(first + chunk - 1, n), aim, s, state, traction, rows, dt, s_old, &
          tangent)
      end do
      !$omp end parallel do
    else if (n < worth_threads) then
      do first = 1, n, chunk
        call update_rows(joint, block, first, min(first + chunk - 1, n), s, state, traction, rows, dt, s_old, tangent)
      end do
    else
      !$omp parallel do schedule(static)
      do first = 1, n, chunk
        call update_rows(joint, block, first, min(first + chunk - 1, n), s, state, traction, rows, dt, s_old, tangent)
      end do
      !$omp end parallel do
    end if
    if (present(p)) traction(1, :n) = traction(1, :n) - p

  contains

    !> Number of the first bad point of a chunk, n + 1 if there is none.
    function first_bad(first) result(bad)
      integer, intent(in) :: first   !! point with which the chunk begins
      integer :: bad
      integer :: i, last
      bad = n + 1
      last = min(first + chunk - 1, n)
      if (rows_bounded(limits, separation_bound(joint), first, last, s, state, s_old)) then
        if (.not. present(aim)) return
        if (all_bounded(3*(last - first + 1), aim(:, first:last), separation_bound(joint))) return
      end if
      do i = last, first, -1
        if (status_of(i) /= status_ok) bad = i
      end do
    end function first_bad

    !> Whether the input of a point is admissible.
    function status_of(i) result(point)
      integer, intent(in) :: i   !! point
      integer :: point
      real(wp) :: from(3), goal(3)
      from = 0.0_wp
      if (present(s_old)) from = s_old(:, i)
      goal = 0.0_wp
      if (present(aim)) goal = aim(:, i)
      point = point_status(joint, from, s(:, i), state(:, i), goal)
    end function status_of

  end subroutine update_points

end module asperity_arrays
