!> Arrays with the values of each point one after the other: the kernels of two instruction sets.
module asperity_rows_kernel
  use asperity_checks, only: limits_type
  use asperity_instruction_set, only: instruction_set
  use asperity_kinds, only: wp
  use asperity_rows_kernel_v1, only: bounded_v1 => rows_bounded, rows_v1 => update_rows
  use asperity_rows_kernel_v3, only: bounded_v3 => rows_bounded, rows_v3 => update_rows
  use asperity_types, only: block_type
  implicit none
  private
  public :: rows_bounded, update_rows

contains

  !> Whether separations and states of points first..last are in their ranges.
  pure function rows_bounded(limits, bound, first, last, s, state, s_old) result(yes)
    type(limits_type), intent(in) :: limits                       !! ranges of the state variables
    real(wp), intent(in) :: bound                                 !! largest separation, length
    integer, intent(in) :: first, last                            !! points
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, any bits
    real(wp), intent(in), contiguous :: state(:, :)               !! (nstatv, n) STATEV at the start, any bits
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    logical :: yes
    if (instruction_set() >= 3) then
      yes = bounded_v3(limits, bound, first, last, s, state, s_old)
    else
      yes = bounded_v1(limits, bound, first, last, s, state, s_old)
    end if
  end function rows_bounded

  !> Update points first..last, at most `chunk`.
  pure subroutine update_rows(block, first, last, s, state, traction, by_rows, s_old, tangent)
    type(block_type), intent(in) :: block                         !! the interface
    integer, intent(in) :: first, last                            !! points
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(inout), contiguous :: state(:, :)            !! (nstatv, n) STATEV, start -> end
    real(wp), intent(inout), contiguous :: traction(:, :)         !! (3, n) traction at the end, stress
    logical, intent(in) :: by_rows                                !! true: tangent(j, i, :), as C and Python store it
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    real(wp), intent(inout), optional, contiguous :: tangent(:, :, :)   !! (3, 3, n) d traction_i/d s_j, stress/length
    if (instruction_set() >= 3) then
      call rows_v3(block, first, last, s, state, traction, by_rows, s_old, tangent)
    else
      call rows_v1(block, first, last, s, state, traction, by_rows, s_old, tangent)
    end if
  end subroutine update_rows

end module asperity_rows_kernel
