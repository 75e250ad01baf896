!> States of many points that slip under compression at the start of the measured increment, and the separations at its
!> end.
module start_states
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  use asperity_point, only: update_point
  implicit none
  private
  public :: start_type, new_start

  !> Points whose states differ; others repeat them.
  integer, parameter, public :: n_states = 640

  !> Points at the start and at the end of their increment.
  type :: start_type
    real(wp), allocatable :: props(:)
    type(interface_type) :: joint
    real(wp), allocatable :: s_old(:, :)   !! (3, n) at the start, length
    real(wp), allocatable :: s(:, :)       !! (3, n) at the end, length
    real(wp), allocatable :: state(:, :)   !! (nstatv, n) at the start
  end type start_type

contains

  !> Fill n points of an interface.
  subroutine new_start(props, n, start)
    real(wp), intent(in) :: props(:)         !! PROPS, admissible
    integer, intent(in) :: n                 !! points
    type(start_type), intent(out) :: start   !! the points
    real(wp), parameter :: rest(3) = 0.0_wp
    real(wp) :: slip, traction(3), tangent(3, 3), from(3, min(n, n_states))
    real(wp), allocatable :: state(:, :)
    integer :: few, p, status

    start%props = props
    call new_interface(props, start%joint, status)
    if (status /= status_ok) error stop "bench: PROPS rejected"
    allocate (start%s_old(3, n), start%s(3, n), start%state(start%joint%n_statev, n))
    few = size(from, 2)
    allocate (state(start%joint%n_statev, few))
    do p = 1, few
      ! a point of a bed joint: slip, with a dilation for which the point stays under compression
      slip = 15.0_wp*real(p, wp)/real(few, wp)
      from(:, p) = start%joint%material%s0*[0.2_wp*slip - 0.5_wp, slip*cos(real(p, wp)), slip*sin(real(p, wp))]
      state(:, p) = 0.0_wp
      call update_point(start%joint, rest, from(:, p), 0.0_wp*state(:, p), state(:, p), traction, tangent)
    end do
    do p = 1, n
      start%s_old(:, p) = from(:, 1 + modulo(p - 1, few))
      start%s(:, p) = 1.01_wp*start%s_old(:, p)
      start%state(:, p) = state(:, 1 + modulo(p - 1, few))
    end do
  end subroutine new_start

end module start_states
