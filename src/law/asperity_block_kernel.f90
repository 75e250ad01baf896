!> The law for blocks of points, structure of arrays: the outer loop runs over the planes, the inner loop
!> (asperity_plane_sums) over the points.
module asperity_block_kernel
  use asperity_chunk, only: begin_sums, end_sums, group, pad
  use asperity_contract, only: facet_statev, n_facet_statev, n_statev, plane_statev, v_offset
  use asperity_kinds, only: wp
  use asperity_plane_sums, only: find_long, sum_accounts, sum_plane
  use asperity_types, only: block_type, chunk, chunk_type, i_traction, points_type
  implicit none
  private
  public :: columns_bounded, find_long, sum_accounts, sum_plane, update_block

contains

  !> Traction, state and (on request) consistent tangent of up to `chunk` points.
  pure recursive subroutine update_block(block, points, state_old, state, traction, tangent)
    type(block_type), intent(in) :: block                     !! the interface
    type(points_type), intent(in) :: points                   !! the points
    real(wp), intent(in) :: state_old(points%n_old, *)        !! STATEV at the start
    real(wp), intent(inout) :: state(points%n_new, *)         !! STATEV at the end, another array
    real(wp), intent(out) :: traction(chunk, 3)               !! traction at the end, stress
    real(wp), intent(out), optional :: tangent(chunk, 3, 3)   !! d traction_i/d s_j of the n points, stress/length
    type(chunk_type) :: now
    integer :: a, b, k, n

    n = points%n
    if (modulo(n, group) > 0) then
      call update_part(block, points, state_old, state, traction, tangent)
      return
    end if
    call begin_sums(block, points, state_old(1, v_offset), now, tangent)
    call find_long(block, now)
    state(:n, v_offset:v_offset + 2) = state_old(:n, v_offset:v_offset + 2)
    do k = 1, block%n_planes
      a = plane_statev(k)
      b = facet_statev(block%n_planes, k)
      if (block%material%wears) now%facets(:n, :) = state_old(:n, b:b + n_facet_statev - 1)
      call sum_plane(block, k, now, state_old(1, a), state(1, a), tangent)
      if (block%material%wears) state(:n, b:b + n_facet_statev - 1) = now%facets(:n, :)
    end do
    call end_sums(now, state_old, state)
    traction(:n, :) = now%sums(:n, i_traction:)
  end subroutine update_block

  !> The same for a number of points that is no multiple of `group`, with padded copies of their states.
  pure recursive subroutine update_part(block, points, state_old, state, traction, tangent)
    type(block_type), intent(in) :: block                     !! the interface
    type(points_type), intent(in) :: points                   !! the points
    real(wp), intent(in) :: state_old(points%n_old, *)        !! STATEV at the start
    real(wp), intent(inout) :: state(points%n_new, *)         !! STATEV at the end, another array
    real(wp), intent(out) :: traction(chunk, 3)               !! traction at the end, stress
    real(wp), intent(out), optional :: tangent(chunk, 3, 3)   !! d traction_i/d s_j of the n points, stress/length
    type(points_type) :: padded
    real(wp), dimension(chunk, n_statev(block%n_planes, block%material%wears)) :: old, new
    integer :: n, rows
    n = points%n
    rows = size(old, 2)
    padded%n = n
    padded%s_old(:n, :) = points%s_old(:n, :)
    padded%s_new(:n, :) = points%s_new(:n, :)
    old(:n, :rows) = state_old(:n, :rows)
    call pad(padded, old)
    call update_block(block, padded, old, new, traction, tangent)
    state(:n, :rows) = new(:n, :rows)
  end subroutine update_part

  !> Whether the values of n points, column by column, are in their ranges. They are compared by their bits, as in
  !> asperity_checks.
  pure function columns_bounded(n, leading, columns, bound, signed) result(yes)
    integer, intent(in) :: n                            !! points
    integer, intent(in) :: leading                      !! leading dimension of columns
    real(wp), intent(in) :: columns(leading, *)         !! any bits
    real(wp), intent(in), contiguous :: bound(:)        !! largest magnitude of each column, finite, >= 0
    logical, intent(in), contiguous :: signed(:)        !! whether its values may be negative (-0 may always be)
    logical :: yes
    integer, parameter :: word = selected_int_kind(merge(18, 9, digits(1.0_wp) > 24))
    integer(word) :: beyond, bits, most
    integer :: i, j
    beyond = 0_word
    do j = 1, size(bound)
      most = transfer(bound(j), most)
      if (signed(j)) then
        !$omp simd reduction(ior:beyond)
        do i = 1, n
          beyond = ior(beyond, most - iand(transfer(columns(i, j), most), huge(most)))
        end do
      else
        !$omp simd reduction(ior:beyond) private(bits)
        do i = 1, n
          bits = transfer(columns(i, j), most)
          beyond = ior(beyond, ior(most - iand(bits, huge(most)), iand(bits, -iand(bits, huge(most)))))
        end do
      end if
    end do
    yes = beyond >= 0_word
  end function columns_bounded

end module asperity_block_kernel
