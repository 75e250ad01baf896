! Of the modules asperity_block_double and asperity_block_single: planes and growth of the damage of a block.

include "asperity_plane_setup.inc"

!> Set a block from the interface and from the constants in its kind.
pure subroutine set_block(joint, material, block, dt)
  type(interface_type), intent(in) :: joint     !! material and pattern in double precision
  type(material_type), intent(in) :: material   !! constants of the law in kind wp
  type(block_type), intent(out) :: block        !! the interface in kind wp
  real(real64), intent(in), optional :: dt      !! duration, >= 0 (used only if tau_v or c > 0), time; absent: 0
  integer :: k
  block%n_planes = joint%pattern%n
  block%material = material
  block%growth = growth_of(joint%material, dt)
  do k = 1, joint%pattern%n
    block%planes(k) = plane_of(joint%pattern, k)
  end do
end subroutine set_block
