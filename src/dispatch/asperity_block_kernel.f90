!> The loops over the points of a block: the kernels of two instruction sets.
module asperity_block_kernel
  use asperity_block_kernel_v1, only: columns_v1 => columns_bounded, update_v1 => update_block
  use asperity_block_kernel_v3, only: columns_v3 => columns_bounded, update_v3 => update_block
  use asperity_instruction_set, only: instruction_set
  use asperity_kinds, only: wp
  use asperity_types, only: block_type, chunk, points_type
  implicit none
  private
  public :: columns_bounded, update_block

contains

  !> Traction, state and (on request) consistent tangent of up to `chunk` points.
  pure subroutine update_block(block, points, state_old, state, traction, tangent)
    type(block_type), intent(in) :: block                     !! the interface
    type(points_type), intent(in) :: points                   !! the points
    real(wp), intent(in) :: state_old(points%n_old, *)        !! STATEV at the start
    real(wp), intent(inout) :: state(points%n_new, *)         !! STATEV at the end, another array
    real(wp), intent(out) :: traction(chunk, 3)               !! traction at the end, stress
    real(wp), intent(out), optional :: tangent(chunk, 3, 3)   !! d traction_i/d s_j of the n points, stress/length
    if (instruction_set() >= 3) then
      call update_v3(block, points, state_old, state, traction, tangent)
    else
      call update_v1(block, points, state_old, state, traction, tangent)
    end if
  end subroutine update_block

  !> Whether the values of n points, column by column, are in their ranges.
  pure function columns_bounded(n, leading, columns, bound, signed) result(yes)
    integer, intent(in) :: n                            !! points
    integer, intent(in) :: leading                      !! leading dimension of columns
    real(wp), intent(in) :: columns(leading, *)         !! any bits
    real(wp), intent(in), contiguous :: bound(:)        !! largest magnitude of each column, finite, >= 0
    logical, intent(in), contiguous :: signed(:)        !! whether its values may be negative (-0 may always be)
    logical :: yes
    if (instruction_set() >= 3) then
      yes = columns_v3(n, leading, columns, bound, signed)
    else
      yes = columns_v1(n, leading, columns, bound, signed)
    end if
  end function columns_bounded

end module asperity_block_kernel
