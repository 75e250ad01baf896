! Body of the modules asperity_block_kernel_double and asperity_block_kernel_single: the law for blocks of points in real
! kind wp, structure of arrays. The outer loop runs over the planes, the inner loop over the points. The inner loop has no
! branches, so that the compiler vectorises it.
public :: columns_bounded, sum_plane, update_block

!> Loops over points have a multiple of this length, which is a multiple of every vector length and divides chunk.
integer, parameter :: group = 16
!> Sums over the planes: damage, energies over 1/2, traction.
integer, parameter :: i_damage = 1, i_stored = 2, i_rupture = 3, i_friction = 4, i_traction = 5, n_sums = 7

!> How `exponentials` computes: two vectors of points at a time.
logical, parameter :: two_vectors = .true.

!> Start and end of the increment, as indices of arrays.
integer, parameter :: before = 1, after = 2

!> What the loops over the points of a chunk share: the separations with their offsets, the sums over the planes, and
!> the states of the facets of one plane. The arrays are the first components, so that their vectors are aligned.
type :: chunk_type
  real(wp) :: s(chunk, 3, before:after)                      !! separation at start and end, length
  real(wp) :: sums(chunk, n_sums)                            !! sums over the planes, energies over 1/2
  real(wp) :: facets(chunk, n_facet_statev)                  !! state of the facets of a plane, start -> end
  real(wp) :: crushed(chunk)                                 !! share of a plane that the pressure at the end crushes
  integer :: n                                               !! points, a multiple of group, at most chunk
  integer :: n_old, n_new                                    !! leading dimensions of the states at start and end
end type chunk_type

contains

include "asperity_contact.inc"
include "asperity_contact_energy.inc"
include "asperity_law.inc"
include "asperity_facet.inc"
include "asperity_wear.inc"

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
  call begin_sums(points, state_old(1, v_offset), now, tangent)
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

!> Fill the last group of points with virgin points at zero separation, so that every point passes through the same
!> vector instructions. Thus the result of a point does not depend, to the last bit, on which other points are in the
!> call.
pure subroutine pad(points, state)
  type(points_type), intent(inout) :: points              !! the points -> a multiple of `group`, states of `chunk` rows
  real(wp), intent(inout), contiguous :: state(:, :)      !! (chunk, :) STATEV at the start
  integer :: n
  n = points%n
  points%n = ((n + group - 1)/group)*group
  points%n_old = chunk
  points%n_new = chunk
  points%s_old(n + 1:points%n, :) = 0.0_wp
  points%s_new(n + 1:points%n, :) = 0.0_wp
  state(n + 1:points%n, :) = 0.0_wp
end subroutine pad

!> Set the separations, and the sums over the planes to zero.
pure subroutine begin_sums(points, offset, now, tangent)
  type(points_type), intent(in) :: points                   !! the points
  real(wp), intent(in) :: offset(points%n_old, 3)           !! offset of the separation, length
  type(chunk_type), intent(out) :: now                      !! separations and sums
  real(wp), intent(inout), optional :: tangent(chunk, 3, 3) !! sum over the planes
  integer :: i, k
  now%n = points%n
  now%n_old = points%n_old
  now%n_new = points%n_new
  do k = 1, 3
    !$omp simd
    do i = 1, now%n
      now%s(i, k, before) = points%s_old(i, k) + offset(i, k)
      now%s(i, k, after) = points%s_new(i, k) + offset(i, k)
    end do
  end do
  now%sums(:now%n, :) = 0.0_wp
  now%facets(:now%n, :) = 0.0_wp
  if (present(tangent)) tangent(:now%n, :, :) = 0.0_wp
end subroutine begin_sums

!> State of the points from the sums over the planes.
pure subroutine end_sums(now, old, new)
  type(chunk_type), intent(in) :: now                    !! the sums
  real(wp), intent(in) :: old(now%n_old, *)              !! STATEV of the point at the start
  real(wp), intent(inout) :: new(now%n_new, *)           !! the same at the end
  integer :: i
  !$omp simd
  do i = 1, now%n
    new(i, v_damage) = min(now%sums(i, i_damage), 1.0_wp)
    new(i, v_stored) = 0.5_wp*now%sums(i, i_stored)
    new(i, v_rupture) = old(i, v_rupture) + 0.5_wp*now%sums(i, i_rupture)
    new(i, v_friction) = old(i, v_friction) + 0.5_wp*now%sums(i, i_friction)
    new(i, v_status) = 1.0_wp
  end do
end subroutine end_sums

!> Update the state of a plane, and add its damage, energies, traction and (on request) consistent tangent to the sums
!> (3). Public, so that the compiler makes one copy of its loops.
pure subroutine sum_plane(block, k, now, old, new, tangent)
  type(block_type), intent(in) :: block                     !! the interface
  integer, intent(in) :: k                                  !! plane
  type(chunk_type), intent(inout) :: now                    !! separations; sums, to which the plane is added
  real(wp), intent(in) :: old(now%n_old, n_plane_statev)    !! state of the plane at the start
  real(wp), intent(inout) :: new(now%n_new, n_plane_statev) !! the same at the end
  real(wp), intent(inout), optional :: tangent(chunk, 3, 3) !! stress/length
  ! kernel and wish are literals, so that the compiler generates a loop without branches for each
  if (present(tangent)) then
    select case (kernel_of(block%material, block%planes(k)%slope))
    case (kernel_straight)
      call add_plane(block, kernel_straight, .true., k, now, old, new, tangent)
    case (kernel_guarded)
      call add_plane(block, kernel_guarded, .true., k, now, old, new, tangent)
    case (kernel_facet)
      call add_plane(block, kernel_facet, .true., k, now, old, new, tangent)
    case (kernel_worn)
      call add_plane(block, kernel_worn, .true., k, now, old, new, tangent)
    case (kernel_general)
      call add_plane(block, kernel_general, .true., k, now, old, new, tangent)
    case default
      call add_plane(block, kernel_damped, .true., k, now, old, new, tangent)
    end select
  else
    select case (kernel_of(block%material, block%planes(k)%slope))
    case (kernel_straight)
      call add_plane(block, kernel_straight, .false., k, now, old, new)
    case (kernel_guarded)
      call add_plane(block, kernel_guarded, .false., k, now, old, new)
    case (kernel_facet)
      call add_plane(block, kernel_facet, .false., k, now, old, new)
    case (kernel_worn)
      call add_plane(block, kernel_worn, .false., k, now, old, new)
    case (kernel_general)
      call add_plane(block, kernel_general, .false., k, now, old, new)
    case default
      call add_plane(block, kernel_damped, .false., k, now, old, new)
    end select
  end if
end subroutine sum_plane

!> Add damage, energies, traction and (on request) tangent of one plane to the sums.
pure subroutine add_plane(block, kernel, with_tangent, k, now, old, new, tangent)
  type(block_type), intent(in) :: block                  !! the interface
  integer, intent(in) :: kernel                          !! which one, a literal
  logical, intent(in) :: with_tangent                    !! whether the tangent is wanted, a literal
  integer, intent(in) :: k                               !! plane
  type(chunk_type), intent(inout) :: now                 !! separations; sums, to which the plane is added
  real(wp), intent(in) :: old(now%n_old, n_plane_statev)      !! state of the plane at the start
  real(wp), intent(inout) :: new(now%n_new, n_plane_statev)   !! at the end
  real(wp), intent(inout), optional :: tangent(chunk, 3, 3)   !! sum over the planes, stress/length
  type(growth_type) :: growth
  type(history_type) :: state
  type(material_type) :: m
  type(plane_type) :: plane
  type(update_type) :: ended
  type(vector_type) :: from, to
  real(wp) :: weight
  ! as wide as a double: with a shorter index gfortran takes two vectors at a time, and the registers do not suffice
  integer(int64) :: i

  m = kernel_constants(block%material, kernel)
  growth = block%growth
  plane = block%planes(k)
  weight = plane%gamma*m%k_t
  if (m%wears) now%crushed(:now%n) = 0.0_wp
  if (m%wears .and. m%kt_crush > 0.0_wp .and. plane%slope > 0.0_wp) then
    ! where no point of the chunk climbs the plane, nothing is crushed; crushed_share decides of a slip across the
    ! plane, which is zero but for rounding
    if (maxval(plane%e_x*now%s(:now%n, 2, after) + plane%e_y*now%s(:now%n, 3, after)) > &
        -4.0_wp*epsilon(1.0_wp)*maxval(abs(now%s(:now%n, 2:3, after)))) then
      !$omp simd
      do i = 1, now%n
        to = vector_type(now%s(i, 1, after), now%s(i, 2, after), now%s(i, 3, after))
        now%crushed(i) = crushed_share(m, plane, to)
      end do
    end if
  end if
  !$omp simd
  do i = 1, now%n
    from = vector_type(now%s(i, 1, before), now%s(i, 2, before), now%s(i, 3, before))
    to = vector_type(now%s(i, 1, after), now%s(i, 2, after), now%s(i, 3, after))
    state = history_type(old(i, 1), old(i, 2), old(i, 3), now%facets(i, 1), now%facets(i, 2))
    ended = update_plane(m, growth, plane, 1.0_wp, now%crushed(i), from, to, state)
    new(i, 1) = ended%new%alpha
    new(i, 2) = ended%new%s_dit
    new(i, 3) = ended%new%s_dih
    now%facets(i, 1) = ended%new%omega
    now%facets(i, 2) = ended%new%wear_work
    now%sums(i, i_damage) = now%sums(i, i_damage) + plane%gamma*ended%new%alpha
    now%sums(i, i_stored) = now%sums(i, i_stored) + weight*ended%stored
    now%sums(i, i_rupture) = now%sums(i, i_rupture) + weight*ended%spent%rupture
    now%sums(i, i_friction) = now%sums(i, i_friction) + weight*ended%spent%friction
    now%sums(i, i_traction) = now%sums(i, i_traction) + weight*ended%traction%n
    now%sums(i, i_traction + 1) = now%sums(i, i_traction + 1) + weight*ended%traction%x
    now%sums(i, i_traction + 2) = now%sums(i, i_traction + 2) + weight*ended%traction%y
    if (with_tangent) then
      tangent(i, 1, 1) = tangent(i, 1, 1) + weight*ended%tangent%nn
      tangent(i, 2, 1) = tangent(i, 2, 1) + weight*ended%tangent%xn
      tangent(i, 3, 1) = tangent(i, 3, 1) + weight*ended%tangent%yn
      tangent(i, 1, 2) = tangent(i, 1, 2) + weight*ended%tangent%nx
      tangent(i, 2, 2) = tangent(i, 2, 2) + weight*ended%tangent%xx
      tangent(i, 3, 2) = tangent(i, 3, 2) + weight*ended%tangent%yx
      tangent(i, 1, 3) = tangent(i, 1, 3) + weight*ended%tangent%ny
      tangent(i, 2, 3) = tangent(i, 2, 3) + weight*ended%tangent%xy
      tangent(i, 3, 3) = tangent(i, 3, 3) + weight*ended%tangent%yy
    end if
  end do
end subroutine add_plane

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
