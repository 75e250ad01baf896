!> The library's arithmetic on scalars, one plane after the other: what vectors gain is measured against it.
module plain
  use asperity_contract, only: n_plane_statev, n_point_statev, v_damage, v_friction, v_offset, v_rupture, v_status, &
    v_stored
  use asperity_kinds, only: wp
  use asperity_interface, only: interface_type
  use asperity_material, only: material_type
  implicit none
  private
  public :: plain_update

contains

  !> Traction, state and (on request) consistent tangent of one point.
  pure subroutine plain_update(joint, s_old, s_new, state_old, state, traction, tangent)
    type(interface_type), intent(in) :: joint          !! material and pattern
    real(wp), intent(in) :: s_old(3)                   !! separation at the start of the increment, length
    real(wp), intent(in) :: s_new(3)                   !! separation at its end, length
    real(wp), intent(in), contiguous :: state_old(:)   !! STATEV at the start
    real(wp), intent(inout), contiguous :: state(:)    !! STATEV at the end
    real(wp), intent(out) :: traction(3)               !! stress
    real(wp), intent(out), optional :: tangent(3, 3)   !! stress/length
    include "asperity_plane_names.inc"
    type(material_type) :: m
    integer :: i, k

    m = joint%material
    from_1 = s_old(1) + state_old(v_offset)
    from_2 = s_old(2) + state_old(v_offset + 1)
    from_3 = s_old(3) + state_old(v_offset + 2)
    to_1 = s_new(1) + state_old(v_offset)
    to_2 = s_new(2) + state_old(v_offset + 1)
    to_3 = s_new(3) + state_old(v_offset + 2)
    state = state_old
    damage = 0.0_wp
    stored = 0.0_wp
    rupture = 0.0_wp
    friction = 0.0_wp
    sigma_1 = 0.0_wp
    sigma_2 = 0.0_wp
    sigma_3 = 0.0_wp
    if (present(tangent)) then
      d11 = 0.0_wp
      d21 = 0.0_wp
      d31 = 0.0_wp
      d12 = 0.0_wp
      d22 = 0.0_wp
      d32 = 0.0_wp
      d13 = 0.0_wp
      d23 = 0.0_wp
      d33 = 0.0_wp
      do k = 1, joint%pattern%n
        include "plain_load.inc"
        include "asperity_plane.inc"
        include "plain_store.inc"
      end do
      tangent(:, 1) = [d11, d21, d31]
      tangent(:, 2) = [d12, d22, d32]
      tangent(:, 3) = [d13, d23, d33]
    else
      do k = 1, joint%pattern%n
        include "plain_load.inc"
        include "asperity_plane.inc"
        include "plain_store.inc"
      end do
    end if
    state(v_damage) = damage
    state(v_stored) = stored
    state(v_rupture) = state(v_rupture) + rupture
    state(v_friction) = state(v_friction) + friction
    traction = [sigma_1, sigma_2, sigma_3]
    state(v_status) = 1.0_wp
  end subroutine plain_update

end module plain
