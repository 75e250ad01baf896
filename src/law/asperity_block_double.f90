!> The law for blocks of points in double precision.
module asperity_block_double
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_block_kernel, only: columns_bounded, update_block
  use asperity_block_setup, only: set_block
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type
  use asperity_types, only: block_type, chunk, largest_energy, largest_separation, points_type
  implicit none
  private
  public :: block_type, chunk, columns_bounded, largest_energy, largest_separation, new_block, points_type, update_block

contains

  !> The interface for blocks; the status is that of the single precision, where constants may be out of range.
  pure subroutine new_block(joint, block, status, dt)
    type(interface_type), intent(in) :: joint   !! material and pattern in double precision
    type(block_type), intent(out) :: block      !! the same in kind wp, defined if status is 0
    integer, intent(out) :: status              !! 0 or status_props
    real(real64), intent(in), optional :: dt    !! duration, >= 0 (used only if tau_v or c > 0), time; absent: 0
    status = status_ok
    call set_block(joint, joint%material, block, dt)
  end subroutine new_block

end module asperity_block_double
