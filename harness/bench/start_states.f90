!> States of many points at the start of the measured increment, and the separations at its end.
module start_states
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  use asperity_point, only: update_point
  implicit none
  private
  public :: joint_of, new_start_states

  !> Choices: all points slip under compression; or 90 % are virgin, 8 % are being damaged and 2 % are open, either in
  !> zones or scattered over the arrays.
  integer, parameter, public :: slip = 1, zones = 2, scattered = 3
  character(len=9), parameter, public :: state_names(3) = [character(len=9) :: "slip", "zones", "scattered"]

contains

  !> The interface of admissible PROPS.
  function joint_of(props) result(joint)
    real(wp), intent(in) :: props(:)   !! PROPS
    type(interface_type) :: joint
    integer :: status
    call new_interface(props, joint, status)
    if (status /= status_ok) error stop "bench: PROPS rejected"
  end function joint_of

  !> Separations and states at the start of the increment, separations at its end.
  pure subroutine new_start_states(joint, kind, n, s_old, s, state)
    type(interface_type), intent(in) :: joint       !! the interface
    integer, intent(in) :: kind                     !! slip, zones or scattered
    integer, intent(in) :: n                        !! points
    real(wp), intent(out), allocatable :: s_old(:, :)   !! (3, n) at the start, length
    real(wp), intent(out), allocatable :: s(:, :)       !! (3, n) at the end, length
    real(wp), intent(out), allocatable :: state(:, :)   !! (nstatv, n) at the start
    integer, parameter :: apart = 37                ! prime that does not divide the numbers of points
    real(wp), parameter :: rest(3) = 0.0_wp
    real(wp) :: share, virgin(joint%n_statev), traction(3), tangent(3, 3), direction(2)
    integer :: p, place

    allocate (s_old(3, n), s(3, n), state(joint%n_statev, n))
    virgin = 0.0_wp
    do p = 1, n
      place = p
      if (kind == scattered) place = 1 + modulo(p*apart, n)
      share = real(place, wp)/real(n, wp)
      direction = [cos(real(p, wp)), sin(real(p, wp))]
      if (kind == slip) then
        s_old(:, p) = compressed_slip(15.0_wp*share)
      else if (share <= 0.90_wp) then
        s_old(:, p) = joint%material%s0*[-0.1_wp, 0.2_wp*direction*share]
      else if (share <= 0.98_wp) then
        s_old(:, p) = compressed_slip(100.0_wp*(share - 0.89_wp))
      else
        s_old(:, p) = joint%material%s0*[20.0_wp, 5.0_wp*direction]
      end if
      s(:, p) = 1.01_wp*s_old(:, p)
      call update_point(joint, rest, s_old(:, p), virgin, state(:, p), traction, tangent)
    end do

  contains

    !> A point of a bed joint: slip, with a dilation for which the point stays under compression.
    pure function compressed_slip(multiple) result(x)
      real(wp), intent(in) :: multiple   !! slip as a multiple of s0
      real(wp) :: x(3)
      x = joint%material%s0*multiple*[0.0_wp, direction]
      x(1) = 0.2_wp*joint%material%s0*multiple - 0.5_wp*joint%material%s0
    end function compressed_slip

  end subroutine new_start_states

end module start_states
