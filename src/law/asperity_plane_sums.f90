!> The law for blocks of points, structure of arrays: the sums over the planes. The loop over the points has no
!> branches, so that the compiler vectorises it.
module asperity_plane_sums
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_contract, only: n_plane_statev
  use asperity_kernels, only: exact_kernel, kernel_constants, kernel_damped, kernel_facet, kernel_general, &
    kernel_guarded, kernel_of, kernel_straight, kernel_worn
  use asperity_kinds, only: wp
  use asperity_law, only: update_plane
  use asperity_phases, only: long_increment
  use asperity_types, only: after, before, block_type, chunk, chunk_type, growth_type, history_type, i_damage, &
    i_friction, i_rupture, i_stored, i_traction, material_type, plane_type, update_type, vector_type
  use asperity_wear, only: crushed_share
  implicit none
  private
  public :: find_long, sum_plane

contains

  !> Find the points of a chunk whose increment is long.
  pure subroutine find_long(block, now)
    type(block_type), intent(in) :: block     !! the interface
    type(chunk_type), intent(inout) :: now    !! separations -> which increments are long
    integer(int64) :: i
    !$omp simd
    do i = 1, now%n
      now%long(i) = long_increment(block%material, block%growth, &
        vector_type(now%s(i, 1, before), now%s(i, 2, before), now%s(i, 3, before)), &
        vector_type(now%s(i, 1, after), now%s(i, 2, after), now%s(i, 3, after)))
    end do
    now%any_long = maxval(now%long(:now%n)) > 0.0_wp
  end subroutine find_long

  !> Update the state of a plane, and add its damage, energies, traction and (on request) consistent tangent to the sums
  !> (3). Public, so that the compiler makes one copy of its loops.
  pure subroutine sum_plane(block, k, now, old, new, tangent)
    type(block_type), intent(in) :: block                     !! the interface
    integer, intent(in) :: k                                  !! plane
    type(chunk_type), intent(inout) :: now                    !! separations; sums, to which the plane is added
    real(wp), intent(in) :: old(now%n_old, n_plane_statev)    !! state of the plane at the start
    real(wp), intent(inout) :: new(now%n_new, n_plane_statev) !! the same at the end
    real(wp), intent(inout), optional :: tangent(chunk, 3, 3) !! stress/length
    real(wp) :: unused(chunk, 3, 3)
    integer :: kernel
    kernel = kernel_of(block%material, block%planes(k)%slope)
    ! kernel and wishes are literals, so that the compiler generates a loop without branches for each
    if (present(tangent)) then
      select case (kernel)
      case (kernel_straight)
        call add_plane(block, kernel_straight, .true., .false., .false., k, now, old, new, tangent)
      case (kernel_guarded)
        call add_plane(block, kernel_guarded, .true., .false., .true., k, now, old, new, tangent)
      case (kernel_facet)
        call add_plane(block, kernel_facet, .true., .false., .false., k, now, old, new, tangent)
      case (kernel_worn)
        call add_plane(block, kernel_worn, .true., .false., .false., k, now, old, new, tangent)
      case (kernel_general)
        call add_plane(block, kernel_general, .true., .false., .true., k, now, old, new, tangent)
      case default
        call add_plane(block, kernel_damped, .true., .false., .true., k, now, old, new, tangent)
      end select
    else
      select case (kernel)
      case (kernel_straight)
        call add_plane(block, kernel_straight, .false., .false., .false., k, now, old, new)
      case (kernel_guarded)
        call add_plane(block, kernel_guarded, .false., .false., .true., k, now, old, new)
      case (kernel_facet)
        call add_plane(block, kernel_facet, .false., .false., .false., k, now, old, new)
      case (kernel_worn)
        call add_plane(block, kernel_worn, .false., .false., .false., k, now, old, new)
      case (kernel_general)
        call add_plane(block, kernel_general, .false., .false., .true., k, now, old, new)
      case default
        call add_plane(block, kernel_damped, .false., .false., .true., k, now, old, new)
      end select
    end if
    ! what that has left out
    if (.not. now%any_long) return
    if (present(tangent)) then
      call sum_exactly(block, kernel, k, now, old, new, tangent)
    else
      unused(:now%n, :, :) = 0.0_wp
      call sum_exactly(block, kernel, k, now, old, new, unused)
    end if
  end subroutine sum_plane

  !> The same for the points whose increment is long, which sum_plane leaves out.
  pure subroutine sum_exactly(block, kernel, k, now, old, new, tangent)
    type(block_type), intent(in) :: block                     !! the interface
    integer, intent(in) :: kernel                             !! that of the first loop
    integer, intent(in) :: k                                  !! plane
    type(chunk_type), intent(inout) :: now                    !! separations; sums, to which the plane is added
    real(wp), intent(in) :: old(now%n_old, n_plane_statev)    !! state of the plane at the start
    real(wp), intent(inout) :: new(now%n_new, n_plane_statev) !! the same at the end
    real(wp), intent(inout) :: tangent(chunk, 3, 3)           !! stress/length
    logical :: gated
    gated = kernel == kernel_guarded .or. kernel >= kernel_general
    if (exact_kernel(kernel) == kernel_guarded) then
      call add_plane(block, kernel_guarded, .true., .true., gated, k, now, old, new, tangent)
    else
      call add_plane(block, kernel_general, .true., .true., gated, k, now, old, new, tangent)
    end if
  end subroutine sum_exactly


  !> Add damage, energies, traction and (on request) tangent of one plane to the sums, and set its states: those of the
  !> points whose increment is long, or of the others. Without the guard, whose decision may differ, the first loop adds
  !> to all sums but those of the accounts also for the points that it leaves to the second one.
  pure subroutine add_plane(block, kernel, with_tangent, exact, gated, k, now, old, new, tangent)
    type(block_type), intent(in) :: block                  !! the interface
    integer, intent(in) :: kernel                          !! which one, a literal
    logical, intent(in) :: with_tangent                    !! whether the tangent is wanted, a literal
    logical, intent(in) :: exact                           !! whether long increments are, a literal
    logical, intent(in) :: gated                           !! whether all sums are parted; a literal if not exact
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
    real(wp) :: gamma, most, share, weight
    ! as wide as a double: with a shorter index gfortran takes two vectors at a time, and the registers do not suffice
    integer(int64) :: i

    m = kernel_constants(block%material, kernel)
    m%by_points = .true.
    m%exact = exact
    growth = block%growth
    plane = block%planes(k)
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
    most = plane%gamma*m%k_t
    !$omp simd
    do i = 1, now%n
      from = vector_type(now%s(i, 1, before), now%s(i, 2, before), now%s(i, 3, before))
      to = vector_type(now%s(i, 1, after), now%s(i, 2, after), now%s(i, 3, after))
      state = history_type(old(i, 1), old(i, 2), old(i, 3), now%facets(i, 1), now%facets(i, 2))
      ended = update_plane(m, growth, plane, 1.0_wp, now%crushed(i), now%long(i), from, to, state)
      if (exact) then
        share = now%long(i)
        weight = most*merge(share, 0.0_wp, gated)
        gamma = plane%gamma*merge(share, 0.0_wp, gated)
        new(i, 1) = merge(ended%new%alpha, new(i, 1), share > 0.5_wp)
        new(i, 2) = merge(ended%new%s_dit, new(i, 2), share > 0.5_wp)
        new(i, 3) = merge(ended%new%s_dih, new(i, 3), share > 0.5_wp)
      else
        share = 1.0_wp - now%long(i)
        weight = most
        gamma = plane%gamma
        if (gated) then
          weight = most*share
          gamma = plane%gamma*share
        end if
        new(i, 1) = ended%new%alpha
        new(i, 2) = ended%new%s_dit
        new(i, 3) = ended%new%s_dih
      end if
      if (m%wears) then
        now%facets(i, 1) = merge(ended%new%omega, now%facets(i, 1), share > 0.5_wp)
        now%facets(i, 2) = merge(ended%new%wear_work, now%facets(i, 2), share > 0.5_wp)
      end if
      now%sums(i, i_damage) = now%sums(i, i_damage) + gamma*ended%new%alpha
      now%sums(i, i_stored) = now%sums(i, i_stored) + weight*ended%stored
      now%sums(i, i_rupture) = now%sums(i, i_rupture) + (share*most)*ended%spent%rupture
      now%sums(i, i_friction) = now%sums(i, i_friction) + (share*most)*ended%spent%friction
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

end module asperity_plane_sums
