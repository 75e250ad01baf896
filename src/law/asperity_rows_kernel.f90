!> Arrays with the values of each point one after the other, as C and Python pass them, in double precision.
module asperity_rows_kernel
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_block_kernel, only: find_long, sum_plane
  use asperity_checks, only: limits_type, points_together
  use asperity_chunk, only: begin_sums, end_sums, pad
  use asperity_contract, only: facet_statev, n_facet_statev, n_plane_statev, n_point_statev, plane_statev, v_damage, &
    v_offset, v_rupture
  use asperity_kinds, only: wp
  use asperity_types, only: block_type, chunk, chunk_type, i_traction, points_type
  implicit none
  private
  public :: rows_bounded, update_rows

contains

  !> Whether separations and states of points first..last are in their ranges. A negative zero where no negative value
  !> is admissible is not, so that the caller looks at the points one by one.
  pure function rows_bounded(limits, bound, first, last, s, state, s_old) result(yes)
    type(limits_type), intent(in) :: limits                       !! ranges of the state variables
    real(wp), intent(in) :: bound                                 !! largest separation, length
    integer, intent(in) :: first, last                            !! points
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, any bits
    real(wp), intent(in), contiguous :: state(:, :)               !! (nstatv, n) STATEV at the start, any bits
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    logical :: yes
    integer :: n
    n = last - first + 1
    yes = size(state, 1) >= limits%n
    if (yes) yes = ior(beyond_bound(3*n, s(:, first:last), bound), beyond_limits(limits, size(state, 1), n, &
      state(:, first:last))) >= 0_int64
    if (yes .and. present(s_old)) yes = beyond_bound(3*n, s_old(:, first:last), bound) >= 0_int64
  end function rows_bounded

  !> Negative if a magnitude is larger than the bound, infinite or NaN.
  pure function beyond_bound(n, x, bound) result(beyond)
    integer, intent(in) :: n        !! number of values
    real(wp), intent(in) :: x(n)    !! any bits
    real(wp), intent(in) :: bound   !! largest magnitude
    integer(int64) :: beyond, most
    integer :: i
    beyond = 0_int64
    most = transfer(bound, 0_int64)
    !$omp simd reduction(ior:beyond)
    do i = 1, n
      beyond = ior(beyond, most - iand(transfer(x(i), 0_int64), huge(0_int64)))
    end do
  end function beyond_bound

  !> Negative if a state variable is not in its range.
  pure function beyond_limits(limits, leading, n, state) result(beyond)
    type(limits_type), intent(in) :: limits       !! ranges
    integer, intent(in) :: leading                !! state variables of a point, at least as many as limits
    integer, intent(in) :: n                      !! points
    real(wp), intent(in) :: state(leading*n)      !! any bits
    integer(int64) :: beyond, bits, more
    integer :: half, i, j, together
    ! the tests of several points make loops of whole vectors; points of both halves (the middle one twice) share limits
    together = merge(points_together, 1, leading == limits%n)
    half = (n + 1)/2
    beyond = 0_int64
    do i = 0, half - 1, together
      !$omp simd reduction(ior:beyond)
      do j = 1, limits%n*min(together, half - i)
        bits = transfer(state(leading*i + j), 0_int64)
        more = transfer(state(leading*(i + n - half) + j), 0_int64)
        beyond = ior(ior(beyond, iand(ior(bits, more), limits%unsigned(j))), &
          ior(limits%most(j) - iand(bits, huge(0_int64)), limits%most(j) - iand(more, huge(0_int64))))
      end do
    end do
  end function beyond_limits

  !> Copy values at..at + 2 of n points from rows to columns.
  pure subroutine to_columns(n, leading, at, rows, columns)
    integer, intent(in) :: n                               !! points, at most chunk
    integer, intent(in) :: leading                         !! values of a point in rows
    integer, intent(in) :: at                              !! first value that is copied
    real(wp), intent(in) :: rows(leading, n)               !! point by point
    real(wp), intent(inout) :: columns(chunk, 3)           !! value by value
    integer :: i
    !$omp simd
    do i = 1, n
      columns(i, 1) = rows(at, i)
      columns(i, 2) = rows(at + 1, i)
      columns(i, 3) = rows(at + 2, i)
    end do
  end subroutine to_columns

  !> Copy columns 1, 1 + step, 1 + 2 step to values at..at + 2 of n points in rows. The values of a point are stored
  !> together: gfortran would store one after the other if it made vectors of points.
  pure subroutine to_rows(n, leading, at, step, columns, rows)
    integer, intent(in) :: n                               !! points, at most chunk
    integer, intent(in) :: leading                         !! values of a point in rows
    integer, intent(in) :: at                              !! first value that is copied
    integer, intent(in) :: step                            !! distance of the columns
    real(wp), intent(in) :: columns(chunk, *)              !! value by value
    real(wp), intent(inout) :: rows(leading, n)            !! point by point
    integer :: i
    !GCC$ novector
    !GCC$ unroll 4
    do i = 1, n
      rows(at, i) = columns(i, 1)
      rows(at + 1, i) = columns(i, step + 1)
      rows(at + 2, i) = columns(i, 2*step + 1)
    end do
  end subroutine to_rows

  !> Update points first..last, at most `chunk`. The states of one plane after the other are copied to columns and back:
  !> these and the rows stay in the first-level cache.
  pure subroutine update_rows(block, first, last, s, state, traction, by_rows, s_old, tangent)
    type(block_type), intent(in) :: block                         !! the interface
    integer, intent(in) :: first, last                            !! points
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(inout), contiguous :: state(:, :)            !! (nstatv, n) STATEV, start -> end
    real(wp), intent(inout), contiguous :: traction(:, :)         !! (3, n) traction at the end, stress
    logical, intent(in) :: by_rows                                !! true: tangent(j, i, :), as C and Python store it
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    real(wp), intent(inout), optional, contiguous :: tangent(:, :, :)   !! (3, 3, n) d traction_i/d s_j, stress/length
    type(points_type) :: points
    type(chunk_type) :: now
    real(wp) :: d(chunk, 3, 3)
    real(wp), dimension(chunk, n_point_statev) :: old, new
    real(wp), dimension(chunk, n_plane_statev) :: plane_old, plane_new
    integer :: a, b, k, leading, n

    n = last - first + 1
    points%n = n
    leading = size(state, 1)
    if (.not. present(s_old)) points%s_old(:n, :) = 0.0_wp
    call to_columns(n, 3, 1, s(:, first:last), points%s_new)
    if (present(s_old)) call to_columns(n, 3, 1, s_old(:, first:last), points%s_old)
    ! the law reads neither the damage nor the stored energy at the start
    call to_columns(n, leading, v_rupture, state(:, first:last), old(1, v_rupture))
    call to_columns(n, leading, v_offset, state(:, first:last), old(1, v_offset))
    call pad(points, old)
    plane_old(n + 1:points%n, :) = 0.0_wp
    call begin_sums(block, points, old(1, v_offset), now)
    call find_long(block, now)
    if (present(tangent)) d(:points%n, :, :) = 0.0_wp
    do k = 1, block%n_planes
      a = plane_statev(k)
      b = facet_statev(block%n_planes, k)
      call to_columns(n, leading, a, state(:, first:last), plane_old)
      if (block%material%wears) now%facets(:n, :) = transpose(state(b:b + n_facet_statev - 1, first:last))
      if (present(tangent)) then
        call sum_plane(block, k, now, plane_old, plane_new, d)
      else
        call sum_plane(block, k, now, plane_old, plane_new)
      end if
      call to_rows(n, leading, a, 1, plane_new, state(:, first:last))
      if (block%material%wears) state(b:b + n_facet_statev - 1, first:last) = transpose(now%facets(:n, :))
    end do
    call end_sums(now, old, new)
    ! all but the offset, which the law does not change
    call to_rows(n, leading, v_damage, 1, new, state(:, first:last))
    call to_rows(n, leading, v_rupture, 1, new(1, v_rupture), state(:, first:last))
    call to_rows(n, 3, 1, 1, now%sums(1, i_traction), traction(:, first:last))
    if (.not. present(tangent)) return
    do k = 1, 3
      if (by_rows) call to_rows(n, 9, 3*k - 2, 3, d(1, k, 1), tangent(:, :, first:last))
      if (.not. by_rows) call to_rows(n, 9, 3*k - 2, 1, d(1, 1, k), tangent(:, :, first:last))
    end do
  end subroutine update_rows

end module asperity_rows_kernel
