!> The law of an interface point, for those who keep the state at the start of an increment.
module asperity_point
  use asperity_crushing, only: update_crushed
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_point_kernel, only: kinematics_type, plane_kinematics, update_planes => update_point_in_place
  implicit none
  private
  public :: kinematics_type, plane_kinematics, update_point, update_point_in_place

contains

  !> As update_point, but one array holds the state at the start and then the state at the end.
  pure subroutine update_point_in_place(joint, s_old, s, state, traction, tangent, dt, wearing)
    type(interface_type), intent(in) :: joint          !! material and pattern
    real(wp), intent(in) :: s_old(3)                   !! separation (N, Tx, Ty) at the start of the increment, length
    real(wp), intent(in) :: s(3)                       !! separation at its end, length
    real(wp), intent(inout) :: state(joint%n_statev)   !! STATEV, start -> end
    real(wp), intent(out) :: traction(3)               !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)             !! d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt               !! duration, >= 0 (used only if tau_v or c > 0), time; absent: 0
    real(wp), intent(in), optional :: wearing          !! part of the wear that is done, 0 to 1; absent: 1
    if (joint%cap%peak > 0.0_wp) then
      call update_crushed(joint, s_old, s, state, traction, tangent, dt, wearing)
    else
      call update_planes(joint, s_old, s, state, traction, tangent, dt, wearing)
    end if
  end subroutine update_point_in_place

  !> Traction, state and consistent tangent of a point at separation s, from the state it had at separation s_old.
  !>
  !> This procedure does not test its input; `update_points` of asperity_arrays does.
  pure subroutine update_point(joint, s_old, s, state_old, state, traction, tangent, dt, wearing, booked)
    type(interface_type), intent(in) :: joint          !! material and pattern
    real(wp), intent(in) :: s_old(3)                   !! separation (N, Tx, Ty) at the start of the increment, length
    real(wp), intent(in) :: s(3)                       !! separation at its end, length
    real(wp), intent(in), contiguous :: state_old(:)   !! STATEV at the start, size >= n_statev(Np)
    real(wp), intent(out), contiguous :: state(:)      !! STATEV at the end, same size
    real(wp), intent(out) :: traction(3)               !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)             !! d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt               !! duration, >= 0 (used only if tau_v or c > 0), time; absent: 0
    real(wp), intent(in), optional :: wearing          !! part of the wear that is done, 0 to 1; absent: 1
    logical, intent(out), optional :: booked           !! whether the state has rupture and friction of the increment: a
                                                       !! long one may leave them out here; absent: it has them
    state = state_old
    if (present(booked) .and. .not. joint%cap%peak > 0.0_wp) then
      call update_planes(joint, s_old, s, state, traction, tangent, dt, wearing, booked)
    else
      call update_point_in_place(joint, s_old, s, state, traction, tangent, dt, wearing)
      if (present(booked)) booked = .true.
    end if
  end subroutine update_point

end module asperity_point
