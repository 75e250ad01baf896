!> Begin and end of the sums over the planes for a chunk of points: whole groups of points, so that every point passes
!> through the same vector instructions.
module asperity_chunk
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_contract, only: v_damage, v_friction, v_rupture, v_status, v_stored
  use asperity_kinds, only: wp
  use asperity_types, only: after, before, block_type, chunk, chunk_type, i_damage, i_friction, i_rupture, i_stored, &
    points_type
  implicit none
  private
  public :: begin_sums, end_sums, group, pad

  !> Loops over points have a multiple of this length, which is a multiple of every vector length and divides chunk.
  integer, parameter :: group = 16

contains

  !> Fill the last group of points with virgin points at zero separation, so that every point passes through the same
  !> vector instructions. Thus the result of a point does not depend, to the last bit, on which other points are in the
  !> call.
  pure subroutine pad(points, state)
    type(points_type), intent(inout) :: points           !! the points -> a multiple of `group`, states of `chunk` rows
    real(wp), intent(inout), contiguous :: state(:, :)   !! (chunk, :) STATEV at the start
    integer :: n
    n = points%n
    points%n = ((n + group - 1)/group)*group
    points%n_old = chunk
    points%n_new = chunk
    points%s_old(n + 1:points%n, :) = 0.0_wp
    points%s_new(n + 1:points%n, :) = 0.0_wp
    state(n + 1:points%n, :) = 0.0_wp
  end subroutine pad

  !> Set the separations, and the sums over the planes to zero; see whether any increment may be long.
  pure subroutine begin_sums(block, points, offset, now, tangent)
    type(block_type), intent(in) :: block                     !! the interface
    type(points_type), intent(in) :: points                   !! the points
    real(wp), intent(in) :: offset(points%n_old, 3)           !! offset of the separation, length
    type(chunk_type), intent(out) :: now                      !! separations and sums
    real(wp), intent(inout), optional :: tangent(chunk, 3, 3) !! sum over the planes
    real(wp) :: count, inv_longest_2, way
    integer(int64) :: i
    now%n = points%n
    now%n_old = points%n_old
    now%n_new = points%n_new
    inv_longest_2 = block%material%inv_longest_2
    count = 0.0_wp
    !$omp simd reduction(+:count)
    do i = 1, now%n
      now%s(i, 1, before) = points%s_old(i, 1) + offset(i, 1)
      now%s(i, 2, before) = points%s_old(i, 2) + offset(i, 2)
      now%s(i, 3, before) = points%s_old(i, 3) + offset(i, 3)
      now%s(i, 1, after) = points%s_new(i, 1) + offset(i, 1)
      now%s(i, 2, after) = points%s_new(i, 2) + offset(i, 2)
      now%s(i, 3, after) = points%s_new(i, 3) + offset(i, 3)
      way = (now%s(i, 1, after) - now%s(i, 1, before))**2 + ((now%s(i, 2, after) - now%s(i, 2, before))**2 + &
        (now%s(i, 3, after) - now%s(i, 3, before))**2)
      count = count + merge(1.0_wp, 0.0_wp, way*inv_longest_2 > 1.0_wp)
    end do
    ! the number of those that may be; find_long looks at them
    now%n_long = merge(now%n, 0, count > 0.0_wp)
    now%sums(:now%n, :) = 0.0_wp
    now%facets(:now%n, :) = 0.0_wp
    if (present(tangent)) tangent(:now%n, :, :) = 0.0_wp
  end subroutine begin_sums

  !> State of the points from the sums over the planes.
  pure subroutine end_sums(now, old, new)
    type(chunk_type), intent(inout) :: now                 !! the sums
    real(wp), intent(in) :: old(now%n_old, *)              !! STATEV of the point at the start
    real(wp), intent(inout) :: new(now%n_new, *)           !! the same at the end
    integer :: i
    do i = 1, now%n_long
      now%sums(now%long(i), [i_rupture, i_friction]) = now%accounts(i, :)
    end do
    !$omp simd
    do i = 1, now%n
      new(i, v_damage) = min(now%sums(i, i_damage), 1.0_wp)
      new(i, v_stored) = 0.5_wp*now%sums(i, i_stored)
      new(i, v_rupture) = old(i, v_rupture) + 0.5_wp*now%sums(i, i_rupture)
      new(i, v_friction) = old(i, v_friction) + 0.5_wp*now%sums(i, i_friction)
      new(i, v_status) = 1.0_wp
    end do
  end subroutine end_sums

end module asperity_chunk
