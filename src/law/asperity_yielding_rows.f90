!> Arrays with the values of each point one after the other, with a compressive strength: the kernel takes all points of
!> a chunk, and those that it finds beyond the strength are taken again, one by one.
module asperity_yielding_rows
  use asperity_block_double, only: block_type, chunk
  use asperity_cap, only: all_withstood, strength_at
  use asperity_contract, only: cap_statev
  use asperity_crushing, only: exceeds
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_point, only: update_point_in_place
  use asperity_rows_kernel, only: update_planes => update_rows
  implicit none
  private
  public :: update_rows

contains

  !> Update points first..last, at most `chunk`.
  pure subroutine update_rows(joint, block, first, last, s, state, traction, by_rows, dt, s_old, tangent)
    type(interface_type), intent(in) :: joint                     !! material, pattern and compressive strength
    type(block_type), intent(in) :: block                         !! the same for blocks
    integer, intent(in) :: first, last                            !! points
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(inout), contiguous :: state(:, :)            !! (nstatv, n) STATEV, start -> end
    real(wp), intent(inout), contiguous :: traction(:, :)         !! (3, n) traction at the end, stress
    logical, intent(in) :: by_rows                                !! true: tangent(j, i, :), as C and Python store it
    real(wp), intent(in), optional :: dt                          !! duration, >= 0, time
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    real(wp), intent(inout), optional, contiguous :: tangent(:, :, :)   !! (3, 3, n) d traction_i/d s_j, stress/length
    if (joint%cap%peak > 0.0_wp) then
      call update_yielding(joint, block, first, last, s, state, traction, by_rows, dt, s_old, tangent)
    else
      call update_planes(block, first, last, s, state, traction, by_rows, s_old, tangent)
    end if
  end subroutine update_rows

  !> The same with a compressive strength.
  pure subroutine update_yielding(joint, block, first, last, s, state, traction, by_rows, dt, s_old, tangent)
    type(interface_type), intent(in) :: joint                     !! material, pattern and compressive strength
    type(block_type), intent(in) :: block                         !! the same for blocks
    integer, intent(in) :: first, last                            !! points
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(inout), contiguous :: state(:, :)            !! (nstatv, n) STATEV, start -> end
    real(wp), intent(inout), contiguous :: traction(:, :)         !! (3, n) traction at the end, stress
    logical, intent(in) :: by_rows                                !! true: tangent(j, i, :), as C and Python store it
    real(wp), intent(in), optional :: dt                          !! duration, >= 0, time
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    real(wp), intent(inout), optional, contiguous :: tangent(:, :, :)   !! (3, 3, n) d traction_i/d s_j, stress/length
    real(wp), dimension(joint%n_statev, chunk) :: start
    real(wp), dimension(3, chunk) :: from, to
    real(wp) :: begin(3), d(3, 3)
    integer :: at, i, k, n
    n = last - first + 1
    at = cap_statev(joint%pattern%n, joint%material%wears)
    start(:, :n) = state(:joint%n_statev, first:last)
    if (any(start(at, :n) > 0.0_wp)) then
      from(:, :n) = 0.0_wp
      if (present(s_old)) from(:, :n) = s_old(:, first:last)
      to(:, :n) = s(:, first:last)
      from(1, :n) = from(1, :n) + start(at, :n)
      to(1, :n) = to(1, :n) + start(at, :n)
      if (present(tangent)) then
        call update_planes(block, 1, n, to(:, :n), state(:, first:last), traction(:, first:last), by_rows, &
          from(:, :n), tangent(:, :, first:last))
      else
        call update_planes(block, 1, n, to(:, :n), state(:, first:last), traction(:, first:last), by_rows, from(:, :n))
      end if
    else
      ! most chunks: none is crushed before, and then none now
      call update_planes(block, first, last, s, state, traction, by_rows, s_old, tangent)
      if (all_withstood(joint%cap, strength_at(joint%cap, 0.0_wp), n, traction(:, first:last))) return
    end if
    do i = 1, n
      k = first + i - 1
      if (.not. exceeds(joint, traction(:, k), start(at, i))) cycle
      begin = 0.0_wp
      if (present(s_old)) begin = s_old(:, k)
      state(:joint%n_statev, k) = start(:, i)
      call update_point_in_place(joint, begin, s(:, k), state(:joint%n_statev, k), traction(:, k), d, dt)
      if (.not. present(tangent)) cycle
      tangent(:, :, k) = d
      if (by_rows) tangent(:, :, k) = transpose(d)
    end do
  end subroutine update_yielding

end module asperity_yielding_rows
