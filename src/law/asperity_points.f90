!> Checked entry to the law: every input is tested before any point is updated.
module asperity_points
  use asperity_call_checks, only: point_status, time_status
  use asperity_checks, only: all_bounded, states_bounded
  use asperity_kinds, only: wp
  use asperity_block_double, only: block_type, chunk, new_block, points_type, update_block
  use asperity_contract, only: energy_limit, most_statev, status_ok
  use asperity_interface, only: interface_type, separation_bound, slip_bound
  use asperity_point, only: update_point_in_place
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
    ! a small closure: every plane is closed and undamaged
    real(wp), parameter :: closure(3) = [-1.0e-6_wp, 0.0_wp, 0.0_wp]
    real(wp) :: state(joint%n_statev), traction(3), s(3)
    state = 0.0_wp
    s = rest
    if (joint%material%k_c > joint%material%k_n) s = joint%material%s0*closure
    call update_point_in_place(joint, rest, s, state, traction, tangent)
  end function virgin_tangent

  !> Update n points over one increment; nothing is written unless every input of every point is admissible.
  !>
  !> The points are processed in blocks, by several threads if the library is built with OpenMP. The result of a point
  !> does not depend, to the last bit, on which other points are in the call or on the number of threads.
  subroutine update_points(joint, s, state, traction, status, failed, s_old, tangent, dt, by_rows)
    type(interface_type), intent(in) :: joint                     !! the interface
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(inout), contiguous :: state(:, :)            !! (nstatv, n) STATEV, start -> end
    real(wp), intent(inout), contiguous :: traction(:, :)         !! (3, n) traction at the end, stress
    integer, intent(out) :: status                                !! 0, status_time or that of the first bad point
    integer, intent(out) :: failed                                !! number of the first bad point, 0: none
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    real(wp), intent(inout), optional, contiguous :: tangent(:, :, :)   !! (3, 3, n) d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt                          !! duration, required if tau_v > 0, time
    logical, intent(in), optional :: by_rows                      !! true: tangent(j, i, :), as C and Python store it
    type(block_type) :: block
    real(wp) :: from(3)
    logical :: rows
    integer :: first, i, n

    failed = 0
    status = time_status(joint, dt)
    if (status /= status_ok) return
    n = size(s, 2)
    failed = n + 1
    from = 0.0_wp
    !$omp parallel do if(n >= worth_threads) schedule(static) private(i) firstprivate(from) reduction(min: failed)
    do first = 1, n, chunk
      if (admissible(joint, first, min(first + chunk - 1, n), s, state, s_old)) cycle
      do i = min(first + chunk - 1, n), first, -1
        if (present(s_old)) from = s_old(:, i)
        if (point_status(joint, from, s(:, i), state(:, i)) /= status_ok) failed = min(failed, i)
      end do
    end do
    !$omp end parallel do
    if (failed <= n) then
      if (present(s_old)) from = s_old(:, failed)
      status = point_status(joint, from, s(:, failed), state(:, failed))
      return
    end if
    failed = 0
    call new_block(joint, block, status, dt)
    if (status /= status_ok) return
    rows = .false.
    if (present(by_rows)) rows = by_rows
    !$omp parallel do if(n >= worth_threads) schedule(static)
    do first = 1, n, chunk
      call update_range(joint, block, first, min(first + chunk - 1, n), s, state, traction, rows, s_old, tangent)
    end do
    !$omp end parallel do
  end subroutine update_points

  !> Whether points first..last, at most `chunk`, are admissible.
  pure function admissible(joint, first, last, s, state, s_old) result(yes)
    type(interface_type), intent(in) :: joint                   !! the interface
    integer, intent(in) :: first, last                          !! points
    real(wp), intent(in), contiguous :: s(:, :)                 !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(in), contiguous :: state(:, :)             !! (nstatv, n) STATEV at the start
    real(wp), intent(in), optional, contiguous :: s_old(:, :)   !! (3, n) separation at the start, absent: zero
    logical :: yes
    integer :: n
    n = 3*(last - first + 1)
    yes = size(state, 1) >= joint%n_statev
    if (yes) yes = all_bounded(n, s(:, first:last), separation_bound(joint))
    if (yes .and. present(s_old)) yes = all_bounded(n, s_old(:, first:last), separation_bound(joint))
    if (yes) yes = states_bounded(joint%pattern%n, joint%n_statev, state(:, first:last), energy_limit, &
      slip_bound(joint))
  end function admissible

  !> Update points first..last, at most `chunk`: copy them to structure of arrays, apply the law, copy the results back.
  pure subroutine update_range(joint, block, first, last, s, state, traction, by_rows, s_old, tangent)
    type(interface_type), intent(in) :: joint                     !! the interface
    type(block_type), intent(in) :: block                         !! the interface, for blocks of points
    integer, intent(in) :: first, last                            !! points
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(inout), contiguous :: state(:, :)            !! (nstatv, n) STATEV, start -> end
    real(wp), intent(inout), contiguous :: traction(:, :)         !! (3, n) traction at the end, stress
    logical, intent(in) :: by_rows                                !! as in update_points
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    real(wp), intent(inout), optional, contiguous :: tangent(:, :, :)   !! (3, 3, n) d traction_i/d s_j, stress/length
    type(points_type) :: points
    real(wp) :: t(chunk, 3), d(chunk, 3, 3)
    real(wp), dimension(chunk, most_statev) :: v_old, v
    integer :: i, j, n

    n = last - first + 1
    points%n = n
    points%n_old = chunk
    points%n_new = chunk
    do j = 1, 3
      points%s_new(:n, j) = s(j, first:last)
      points%s_old(:n, j) = 0.0_wp
      if (present(s_old)) points%s_old(:n, j) = s_old(j, first:last)
    end do
    do j = 1, joint%n_statev
      v_old(:n, j) = state(j, first:last)
    end do
    if (present(tangent)) then
      call update_block(block, points, v_old, v, t, d)
    else
      call update_block(block, points, v_old, v, t)
    end if
    do j = 1, joint%n_statev
      state(j, first:last) = v(:n, j)
    end do
    do j = 1, 3
      traction(j, first:last) = t(:n, j)
      if (.not. present(tangent)) cycle
      do i = 1, 3
        if (by_rows) then
          tangent(j, i, first:last) = d(:n, i, j)
        else
          tangent(i, j, first:last) = d(:n, i, j)
        end if
      end do
    end do
  end subroutine update_range

end module asperity_points
