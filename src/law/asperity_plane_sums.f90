!> The law for blocks of points, structure of arrays: the sums over the planes. The loop over the points has no
!> branches, so that the compiler vectorises it.
module asperity_plane_sums
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_chunk, only: group
  use asperity_contract, only: n_facet_statev, n_plane_statev
  use asperity_kernels, only: exact_kernel, kernel_constants, kernel_damped, kernel_facet, kernel_general, &
    kernel_guarded, kernel_of, kernel_straight, kernel_worn
  use asperity_kinds, only: wp
  use asperity_law, only: growth_over_parts, guarded_release, start_alpha, update_plane
  use asperity_phases, only: growth_of_part, long_increment, parts_of
  use asperity_types, only: after, before, block_type, chunk, chunk_type, growth_type, history_type, i_damage, &
    i_friction, i_rupture, i_stored, i_traction, material_type, part_ends, plane_type, update_type, vector_type
  use asperity_wear, only: crushed_share
  implicit none
  private
  public :: find_long, sum_accounts, sum_plane

contains

  !> Find the points of a chunk whose increment is long, if there are any.
  pure subroutine find_long(block, now)
    type(block_type), intent(in) :: block     !! the interface
    type(chunk_type), intent(inout) :: now    !! separations -> which increments are long
    real(wp) :: long(chunk)
    integer(int64) :: i
    if (now%n_long == 0) return
    !$omp simd
    do i = 1, now%n
      long(i) = long_increment(block%material, block%growth, &
        vector_type(now%s(i, 1, before), now%s(i, 2, before), now%s(i, 3, before)), &
        vector_type(now%s(i, 1, after), now%s(i, 2, after), now%s(i, 3, after)))
    end do
    now%n_long = 0
    do i = 1, now%n
      if (.not. long(i) > 0.0_wp) cycle
      now%n_long = now%n_long + 1
      now%long(now%n_long) = int(i)
    end do
    if (now%n_long == 0) return
    ! whole groups pass through the same vector instructions
    now%n_gathered = ((now%n_long + group - 1)/group)*group
    now%long(now%n_long + 1:now%n_gathered) = now%long(now%n_long)
    now%accounts(:now%n_gathered, :) = 0.0_wp
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
    integer :: kernel
    kernel = kernel_of(block%material, block%planes(k)%slope)
    ! from the states at the start, which the loop below may replace
    if (now%n_long > 0) call sum_accounts(block, kernel, k, now, old)
    ! kernel and wish are literals, so that the compiler generates a loop without branches for each
    if (present(tangent)) then
      select case (kernel)
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
      select case (kernel)
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

  !> Find the shares of a plane that the pressure at the end crushes.
  pure subroutine find_crushed(block, kernel, k, n, s, crushed)
    type(block_type), intent(in) :: block             !! the interface
    integer, intent(in) :: kernel                     !! which one
    integer, intent(in) :: k                          !! plane
    integer, intent(in) :: n                          !! points
    real(wp), intent(in) :: s(chunk, 3)               !! their separations, length
    real(wp), intent(inout) :: crushed(chunk)         !! -> shares
    type(material_type) :: m
    type(plane_type) :: plane
    integer(int64) :: i
    m = kernel_constants(block%material, kernel, .true., .false.)
    plane = block%planes(k)
    crushed(:n) = 0.0_wp
    if (.not. (m%kt_crush > 0.0_wp .and. plane%slope > 0.0_wp)) return
    ! where no point of the chunk climbs the plane, nothing is crushed; crushed_share decides of a slip across the
    ! plane, which is zero but for rounding
    if (maxval(plane%e_x*s(:n, 2) + plane%e_y*s(:n, 3)) > -4.0_wp*epsilon(1.0_wp)*maxval(abs(s(:n, 2:3)))) then
      !$omp simd
      do i = 1, n
        crushed(i) = crushed_share(m, plane, vector_type(s(i, 1), s(i, 2), s(i, 3)))
      end do
    end if
  end subroutine find_crushed

  !> Add rupture and friction of one plane to the accounts, which hold for the points whose increment is long. Public,
  !> so that the compiler keeps it apart: within the loops of sum_plane it makes them 7 % slower.
  pure subroutine sum_accounts(block, kernel, k, now, old)
    type(block_type), intent(in) :: block                     !! the interface
    integer, intent(in) :: kernel                             !! that of the plane
    integer, intent(in) :: k                                  !! plane
    type(chunk_type), intent(inout) :: now                    !! separations; accounts, to which the plane is added
    real(wp), intent(in) :: old(now%n_old, n_plane_statev)    !! state of the plane at the start
    select case (exact_kernel(kernel))
    case (kernel_straight)
      call add_accounts(block, kernel_straight, k, now, old)
    case (kernel_general)
      call add_accounts(block, kernel_general, k, now, old)
    case default
      call add_accounts(block, kernel_damped, k, now, old)
    end select
  end subroutine sum_accounts

  !> The same with a literal kernel.
  pure subroutine add_accounts(block, kernel, k, now, old)
    type(block_type), intent(in) :: block                     !! the interface
    integer, intent(in) :: kernel                             !! which one, a literal
    integer, intent(in) :: k                                  !! plane
    type(chunk_type), intent(inout) :: now                    !! separations; accounts, to which the plane is added
    real(wp), intent(in) :: old(now%n_old, n_plane_statev)    !! state of the plane at the start
    type(growth_type) :: growth
    type(history_type) :: state
    type(material_type) :: m
    type(plane_type) :: plane
    type(update_type) :: ended
    type(vector_type) :: from, to
    real(wp), dimension(chunk, 3) :: start, finish, first, last   !! separations: of the increment, of a part of it
    real(wp) :: planes(chunk, n_plane_statev), facets(chunk, n_facet_statev), crushed(chunk)
    real(wp), dimension(chunk) :: released, whole   !! by the plane in the parts, and in the increment as a whole
    real(wp), dimension(chunk) :: alpha, parted     !! damage at the start, and after the parts
    real(wp) :: begin, counted, weight, x
    integer(int64) :: i
    integer :: j, n, part, parts, rounds
    m = kernel_constants(block%material, kernel, .true., .true.)
    plane = block%planes(k)
    weight = plane%gamma*m%k_t
    n = now%n_gathered
    do j = 1, 3
      start(:n, j) = now%s(now%long(:n), j, before)
      finish(:n, j) = now%s(now%long(:n), j, after)
    end do
    alpha(:n) = old(now%long(:n), 1)
    crushed(:n) = 0.0_wp
    parts = parts_of(block%material)
    ! the guard decides for the increment as a whole, too
    rounds = parts + merge(1, 0, m%guard .and. parts > 1)
    released(:n) = 0.0_wp
    begin = 0.0_wp
    do part = 1, rounds
      if (part == 1 .or. part > parts) then
        if (part > parts) parted(:n) = planes(:n, 1)
        begin = 0.0_wp
        first(:n, :) = start(:n, :)
        planes(:n, :) = old(now%long(:n), :)
        facets(:n, :) = now%facets(now%long(:n), :)
      end if
      x = merge(part_ends(min(part, parts)), 1.0_wp, parts > 1)
      growth = growth_of_part(m, block%growth, x - begin)
      begin = x
      counted = merge(1.0_wp, 0.0_wp, part <= parts)
      last(:n, :) = (1.0_wp - x)*start(:n, :) + x*finish(:n, :)
      if (m%wears) call find_crushed(block, kernel, k, n, last, crushed)
      !$omp simd
      do i = 1, n
        from = vector_type(first(i, 1), first(i, 2), first(i, 3))
        to = vector_type(last(i, 1), last(i, 2), last(i, 3))
        state = history_type(planes(i, 1), planes(i, 2), planes(i, 3), facets(i, 1), facets(i, 2))
        ended = update_plane(m, growth, plane, 1.0_wp, crushed(i), from, to, state)
        planes(i, 1) = ended%new%alpha
        planes(i, 2) = ended%new%s_dit
        planes(i, 3) = ended%new%s_dih
        facets(i, 1) = ended%new%omega
        facets(i, 2) = ended%new%wear_work
        whole(i) = weight*ended%spent%rupture
        released(i) = released(i) + counted*whole(i)
        now%accounts(i, 2) = now%accounts(i, 2) + (counted*weight)*ended%spent%friction
      end do
      first(:n, :) = last(:n, :)
    end do
    if (rounds > parts) then
      !$omp simd
      do i = 1, n
        now%accounts(i, 1) = now%accounts(i, 1) + guarded_release(start_alpha(m, alpha(i)), parted(i), planes(i, 1), &
          released(i), whole(i))
      end do
      return
    end if
    !$omp simd
    do i = 1, n
      to = vector_type(finish(i, 1), finish(i, 2), finish(i, 3))
      x = merge(growth_over_parts(m, block%growth, plane, to, alpha(i), planes(i, 1)), 1.0_wp, parts > 1)
      now%accounts(i, 1) = now%accounts(i, 1) + x*released(i)
    end do
  end subroutine add_accounts

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

    m = kernel_constants(block%material, kernel, .true., .false.)
    growth = block%growth
    plane = block%planes(k)
    weight = plane%gamma*m%k_t
    if (m%wears) call find_crushed(block, kernel, k, now%n, now%s(:, :, after), now%crushed)
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

end module asperity_plane_sums
