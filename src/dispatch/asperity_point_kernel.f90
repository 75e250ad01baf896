!> The law of an interface point: the kernels of two instruction sets.
module asperity_point_kernel
  use asperity_instruction_set, only: instruction_set
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_point_kernel_v1, only: kinematics_type, plane_kinematics, update_v1 => update_point_in_place
  use asperity_point_kernel_v3, only: update_v3 => update_point_in_place
  implicit none
  private
  public :: kinematics_type, plane_kinematics, update_point_in_place

  !> Planes that fill no vector of AVX2 by more than half: those of the smaller instruction set take less time.
  integer, parameter :: narrow = 2

contains

  !> As update_point of asperity_point, but one array holds the state at the start and then the state at the end.
  pure subroutine update_point_in_place(joint, s_old, s, state, traction, tangent, dt, wearing, booked)
    type(interface_type), intent(in) :: joint          !! material and pattern
    real(wp), intent(in) :: s_old(3)                   !! separation (N, Tx, Ty) at the start of the increment, length
    real(wp), intent(in) :: s(3)                       !! separation at its end, length
    real(wp), intent(inout) :: state(joint%n_statev)   !! STATEV, start -> end
    real(wp), intent(out) :: traction(3)               !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)             !! d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt               !! duration, >= 0 (used only if tau_v or c > 0), time; absent: 0
    real(wp), intent(in), optional :: wearing          !! part of the wear that is done, 0 to 1; absent: 1
    logical, intent(out), optional :: booked           !! present: no rupture and friction of a long increment
    if (instruction_set() >= 3 .and. joint%pattern%n > narrow) then
      call update_v3(joint, s_old, s, state, traction, tangent, dt, wearing, booked)
    else
      call update_v1(joint, s_old, s, state, traction, tangent, dt, wearing, booked)
    end if
  end subroutine update_point_in_place

end module asperity_point_kernel
