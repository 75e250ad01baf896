!> What the law needs for a block of points: planes, and growth of the damage.
module asperity_block_setup
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_interface, only: interface_type
  use asperity_plane_setup, only: growth_of, plane_of
  use asperity_types, only: block_type, material_type
  implicit none
  private
  public :: set_block

contains

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

end module asperity_block_setup
