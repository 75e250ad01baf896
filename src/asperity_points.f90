!> Checked entry to the law: the update of points with every input tested first.
module asperity_points
  use asperity_kinds, only: wp
  use asperity_block_double, only: block_type, chunk, new_block, update_block
  use asperity_checks, only: all_bounded, append, bounded, integer_text, to_text
  use asperity_contract, only: energy_limit, max_planes, n_plane_statev, n_point_statev, n_statev, plane_statev, &
    statev_table, status_nstatv, status_ok, status_separation, status_state, status_time, v_offset
  use asperity_interface, only: interface_type, separation_bound, slip_bound
  use asperity_law, only: update_point_in_place
  implicit none
  private
  public :: virgin_tangent, point_status, state_status, time_status, update_points, explain_point, explain_points, &
    explain_time

  !> Points from which on threads are worth starting.
  integer, parameter :: worth_threads = 2048

contains

  !> The stiffest tangent of the virgin interface: that of its planes all open or at rest, or closed if kc > 1.
  pure function virgin_tangent(joint) result(tangent)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: tangent(3, 3)                       !! stress/length
    real(wp), parameter :: rest(3) = 0.0_wp
    ! closes all planes, far from damage
    real(wp), parameter :: closure(3) = [-1.0e-6_wp, 0.0_wp, 0.0_wp]
    real(wp) :: state(joint%n_statev), traction(3), s(3)
    state = 0.0_wp
    s = rest
    if (joint%material%k_c > joint%material%k_n) s = joint%material%s0*closure
    call update_point_in_place(joint, rest, s, state, traction, tangent)
  end function virgin_tangent

  !> Whether the input of a point is admissible.
  pure function point_status(joint, s_old, s, state_old) result(status)
    type(interface_type), intent(in) :: joint          !! the interface
    real(wp), intent(in) :: s_old(3)                   !! separation (N, Tx, Ty) at the start, length
    real(wp), intent(in) :: s(3)                       !! separation at the end, length
    real(wp), intent(in), contiguous :: state_old(:)   !! STATEV at the start
    integer :: status                                  !! 0, status_nstatv, status_state or status_separation
    real(wp) :: bound
    bound = separation_bound(joint)
    status = status_separation
    if (all_bounded(3, s, bound) .and. all_bounded(3, s_old, bound)) status = state_status(joint, state_old)
  end function point_status

  !> Whether STATEV can be a state of the interface.
  pure function state_status(joint, state) result(status)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in), contiguous :: state(:)    !! STATEV
    integer :: status                               !! 0, status_nstatv or status_state
    real(wp) :: least, most, slip
    integer :: i

    status = status_nstatv
    if (size(state) < joint%n_statev) return
    status = status_state
    if (.not. all_bounded(joint%n_statev, state, energy_limit)) return
    slip = max(abs(state(v_offset)), abs(state(v_offset + 1)), abs(state(v_offset + 2)))
    least = 0.0_wp
    most = 0.0_wp
    do i = n_point_statev + 1, joint%n_statev, n_plane_statev
      least = min(least, state(i))
      most = max(most, state(i))
      slip = max(slip, abs(state(i + 1)), abs(state(i + 2)))
    end do
    if (least >= 0.0_wp .and. most <= 1.0_wp .and. slip <= slip_bound(joint)) status = status_ok
  end function state_status

  !> Whether the duration of an increment is admissible: without viscous damage (tau_v = 0) it is not looked at.
  pure function time_status(joint, dt) result(status)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in), optional :: dt            !! duration, any bits, time
    integer :: status                               !! 0 or status_time
    logical :: good
    good = .not. joint%material%tau_v > 0.0_wp
    if (present(dt) .and. .not. good) then
      good = bounded(dt, huge(1.0_wp))
      if (good) good = dt >= 0.0_wp
    end if
    status = merge(status_ok, status_time, good)
  end function time_status

  !> Update n points over one increment; nothing is written unless every input of every point is admissible.
  !>
  !> Points are worked on in blocks, which are spread over threads where the library is built with OpenMP. The result of
  !> a point does not depend on the others, on their number or on the threads, to the last bit.
  subroutine update_points(joint, s, state, traction, status, failed, s_old, tangent, dt)
    type(interface_type), intent(in) :: joint                     !! the interface
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(inout), contiguous :: state(:, :)            !! (nstatv, n) STATEV, start -> end
    real(wp), intent(inout), contiguous :: traction(:, :)         !! (3, n) traction at the end, stress
    integer, intent(out) :: status                                !! 0, status_time or that of the first bad point
    integer, intent(out) :: failed                                !! that point, 0: none
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    real(wp), intent(inout), optional, contiguous :: tangent(:, :, :)   !! (3, 3, n) d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt                          !! duration, required if tau_v > 0, time
    type(block_type) :: block
    real(wp) :: from(3)
    integer :: first, i, n

    failed = 0
    status = time_status(joint, dt)
    if (status /= status_ok) return
    n = size(s, 2)
    failed = n + 1
    from = 0.0_wp
    !$omp parallel do if(n >= worth_threads) schedule(static) firstprivate(from) reduction(min: failed)
    do i = 1, n
      if (present(s_old)) from = s_old(:, i)
      if (point_status(joint, from, s(:, i), state(:, i)) /= status_ok) failed = min(failed, i)
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
    !$omp parallel do if(n >= worth_threads) schedule(static)
    do first = 1, n, chunk
      call update_some(joint, block, first, min(first + chunk - 1, n), s, state, traction, s_old, tangent)
    end do
    !$omp end parallel do
  end subroutine update_points

  !> Points first..last, at most `chunk`: to structure of arrays, the law, and back.
  pure subroutine update_some(joint, block, first, last, s, state, traction, s_old, tangent)
    type(interface_type), intent(in) :: joint                     !! the interface
    type(block_type), intent(in) :: block                         !! the same for blocks
    integer, intent(in) :: first, last                            !! points
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(inout), contiguous :: state(:, :)            !! (nstatv, n) STATEV, start -> end
    real(wp), intent(inout), contiguous :: traction(:, :)         !! (3, n) traction at the end, stress
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    real(wp), intent(inout), optional, contiguous :: tangent(:, :, :)   !! (3, 3, n) d traction_i/d s_j, stress/length
    real(wp) :: s0(chunk, 3), s1(chunk, 3), t(chunk, 3), d(chunk, 3, 3), v(chunk, n_statev(max_planes))
    integer :: i, j, n, p

    n = last - first + 1
    s0(:n, :) = 0.0_wp
    do i = 1, n
      p = first + i - 1
      do j = 1, 3
        s1(i, j) = s(j, p)
        if (present(s_old)) s0(i, j) = s_old(j, p)
      end do
      do j = 1, joint%n_statev
        v(i, j) = state(j, p)
      end do
    end do
    if (present(tangent)) then
      call update_block(block, n, s0, s1, chunk, v, t, d)
    else
      call update_block(block, n, s0, s1, chunk, v, t)
    end if
    do i = 1, n
      p = first + i - 1
      do j = 1, joint%n_statev
        state(j, p) = v(i, j)
      end do
      do j = 1, 3
        traction(j, p) = t(i, j)
        if (present(tangent)) tangent(:, j, p) = d(i, :, j)
      end do
    end do
  end subroutine update_some

  !> Say what `update_points` rejected: the point, its bad values, and what was expected.
  pure subroutine explain_points(joint, failed, s, state, message, s_old)
    type(interface_type), intent(in) :: joint                     !! the interface
    integer, intent(in) :: failed                                 !! the point
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(in), contiguous :: state(:, :)               !! (nstatv, n) STATEV at the start
    character(len=:), allocatable, intent(inout) :: message       !! lines are appended
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    character(len=:), allocatable :: lines
    real(wp) :: from(3)
    from = 0.0_wp
    if (present(s_old)) from = s_old(:, failed)
    allocate (character(len=0) :: lines)
    call explain_point(joint, from, s(:, failed), state(:, failed), lines)
    call append(message, "point " // integer_text(failed) // ": " // lines)
  end subroutine explain_points

  !> Say what `time_status` rejected.
  pure subroutine explain_time(joint, name, message, dt)
    type(interface_type), intent(in) :: joint                  !! the interface
    character(len=*), intent(in) :: name                       !! of the duration where it comes from
    character(len=:), allocatable, intent(inout) :: message    !! a line is appended
    real(wp), intent(in), optional :: dt                       !! duration, any bits, time
    character(len=:), allocatable :: wanted
    if (time_status(joint, dt) == status_ok) return
    wanted = ": expected a finite time increment >= 0 (viscous damage, tau_v = " // &
      to_text(joint%material%tau_v) // ")"
    if (present(dt)) then
      call append(message, name // " = " // to_text(dt) // wanted)
    else
      call append(message, name // " is missing" // wanted)
    end if
  end subroutine explain_time

  !> Say what is wrong with the input of a point: every bad value, and what was expected.
  pure subroutine explain_point(joint, s_old, s, state_old, message)
    type(interface_type), intent(in) :: joint                  !! the interface
    real(wp), intent(in) :: s_old(:)                           !! (3) separation (N, Tx, Ty) at the start, length
    real(wp), intent(in) :: s(:)                               !! (3) separation at the end, length
    real(wp), intent(in), contiguous :: state_old(:)           !! (nstatv) STATEV at the start
    character(len=:), allocatable, intent(inout) :: message    !! lines are appended
    character(len=4), parameter :: names(3) = ["s_N ", "s_Tx", "s_Ty"]
    real(wp) :: bound, slip, largest
    integer :: i, j, k

    bound = separation_bound(joint)
    slip = slip_bound(joint)
    do i = 1, 3
      call review(message, trim(names(i)) // " at the start", s_old(i), -bound, bound)
      call review(message, trim(names(i)), s(i), -bound, bound)
    end do
    if (size(state_old) < joint%n_statev) then
      call append(message, "NSTATV = " // integer_text(size(state_old)) // ": expected at least " // &
        integer_text(joint%n_statev) // " for " // integer_text(joint%pattern%n) // " planes")
      return
    end if
    do i = 1, n_point_statev
      largest = merge(slip, energy_limit, i >= v_offset)
      call review_statev(message, i, i, state_old(i), -largest, largest)
    end do
    do k = 1, joint%pattern%n
      i = plane_statev(k)
      call review_statev(message, i, n_point_statev + 1, state_old(i), 0.0_wp, 1.0_wp)
      do j = 1, n_plane_statev - 1
        call review_statev(message, i + j, n_point_statev + 1 + j, state_old(i + j), -slip, slip)
      end do
    end do
  end subroutine explain_point

  !> Add a line to the message if a state variable is not a finite number in its range.
  pure subroutine review_statev(message, i, row, value, lower, upper)
    character(len=:), allocatable, intent(inout) :: message   !! lines so far
    integer, intent(in) :: i                                  !! index in STATEV
    integer, intent(in) :: row                                !! of statev_table
    real(wp), intent(in) :: value                             !! any bits
    real(wp), intent(in) :: lower, upper                      !! admissible range
    call review(message, "STATEV(" // integer_text(i) // ") " // trim(statev_table(row)%name), value, lower, upper)
  end subroutine review_statev

  !> Add a line to the message if a value is not a finite number in its range.
  pure subroutine review(message, name, value, lower, upper)
    character(len=:), allocatable, intent(inout) :: message   !! lines so far
    character(len=*), intent(in) :: name                      !! of the value
    real(wp), intent(in) :: value                             !! any bits
    real(wp), intent(in) :: lower, upper                      !! admissible range
    logical :: good
    good = bounded(value, huge(1.0_wp))
    if (good) good = value >= lower .and. value <= upper
    if (.not. good) call append(message, name // " = " // to_text(value) // ": expected a finite number from " // &
      to_text(lower) // " to " // to_text(upper))
  end subroutine review

end module asperity_points
