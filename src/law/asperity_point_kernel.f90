!> The loop over the planes of a point: the sum (3) over the planes of the pattern, one point at a time. The compiler
!> vectorises this loop. vector_width is the number of planes in a vector.
module asperity_point_kernel
  use asperity_axes, only: local_separation
  use asperity_contract, only: facet_statev, n_plane_statev, n_point_statev, v_damage, v_friction, v_offset, &
    v_rupture, v_status, v_stored
  use asperity_facet, only: facet_at, profile_at
  use asperity_interface, only: interface_type
  use asperity_kernels, only: exact_kernel, kernel_constants, kernel_damped, kernel_facet, kernel_general, &
    kernel_guarded, kernel_of, kernel_straight, kernel_worn
  use asperity_kinds, only: wp
  use asperity_law, only: growth_over_parts, guarded_release, start_alpha, update_plane
  use asperity_pattern, only: padded_planes
  use asperity_phases, only: growth_of_part, long_increment, parts_of
  use asperity_plane_setup, only: growth_of, plane_of
  use asperity_types, only: dissipation_type, facet_type, growth_type, history_type, local_type, material_type, &
    part_ends, plane_type, profile_type, update_type, vector_type
  use asperity_wear, only: crushed_share
  use asperity_width, only: vector_width
  implicit none
  private
  public :: kinematics_type, plane_kinematics, update_point_in_place, sum_accounts

  !> Separations of a plane, components along its axes (n, t, h).
  type :: kinematics_type
    real(wp) :: bond(3)          !! of the bond (2), length
    real(wp) :: contact(3)       !! of the contact: on a facet the gap and the climbed length, else as the bond, length
    real(wp) :: gradient(3, 3)   !! derivatives of contact (rows) with respect to (N, Tx, Ty)
    real(wp) :: touch            !! opening s_N at which the plane just touches at this tangential separation, length
  end type kinematics_type

  !> State of the planes, plane by plane and in the spare places.
  type :: planes_type
    real(wp), dimension(padded_planes) :: alpha, s_dit, s_dih, omega, wear_work   !! components of history_type
    real(wp), dimension(padded_planes) :: crushed    !! share that the pressure at the end crushes
    integer :: n                                     !! planes and spare places: whole vectors
  end type planes_type

  !> Sums (3) over the planes.
  type :: sums_type
    real(wp) :: damage, stored, rupture, friction   !! energies: stored, increments of rupture and friction
    real(wp) :: traction(3), tangent(3, 3)          !! stress, stress/length
  end type sums_type

contains

  !> As update_point of asperity_point, but one array holds the state at the start and then the state at the end.
  pure subroutine update_point_in_place(joint, s_old, s, state, traction, tangent, dt, wearing, booked)
    type(interface_type), intent(in) :: joint          !! material and pattern
    real(wp), intent(in) :: s_old(3)                   !! separation (N, Tx, Ty) at the start of the increment, length
    real(wp), intent(in) :: s(3)                       !! separation at its end, length
    real(wp), intent(inout) :: state(joint%n_statev)   !! STATEV, start -> end
    real(wp), intent(out) :: traction(3)               !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)             !! d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt               !! duration, >= 0 (used only if tau_v or c > 0), time; absent: 0
    real(wp), intent(in), optional :: wearing          !! part of the wear that is done, 0 to 1; absent: 1
    logical, intent(out), optional :: booked           !! whether the state has rupture and friction of the increment: a
                                                       !! long one leaves them out here; absent: it has them
    type(vector_type) :: from, to
    type(growth_type) :: growth
    type(planes_type) :: planes
    type(sums_type) :: sums
    real(wp) :: part
    type(dissipation_type) :: accounts
    logical :: long
    integer :: i, k, kernel

    part = 1.0_wp
    if (present(wearing)) part = wearing
    growth = growth_of(joint%material, dt)
    planes%n = ((joint%pattern%n + vector_width - 1)/vector_width)*vector_width
    ! spare places take the state of the last plane; their weight is zero
    do k = 1, planes%n
      i = n_point_statev + n_plane_statev*(min(k, joint%pattern%n) - 1) + 1
      planes%alpha(k) = state(i)
      planes%s_dit(k) = state(i + 1)
      planes%s_dih(k) = state(i + 2)
    end do
    if (joint%material%wears) then
      do k = 1, planes%n
        i = facet_statev(joint%pattern%n, min(k, joint%pattern%n))
        planes%omega(k) = state(i)
        planes%wear_work(k) = state(i + 1)
      end do
    else if (joint%material%general .or. joint%material%guard) then
      planes%omega(:planes%n) = 0.0_wp
      planes%wear_work(:planes%n) = 0.0_wp
    end if
    from = vector_type(s_old(1) + state(v_offset), s_old(2) + state(v_offset + 1), s_old(3) + state(v_offset + 2))
    to = vector_type(s(1) + state(v_offset), s(2) + state(v_offset + 1), s(3) + state(v_offset + 2))
    ! the kernel is a literal, so that the compiler generates a loop without branches for each
    kernel = kernel_of(joint%material, joint%pattern%steepest)
    accounts = dissipation_type(0.0_wp, 0.0_wp)
    long = long_increment(joint%material, growth, from, to) > 0.0_wp
    if (long .and. .not. present(booked)) call sum_accounts(joint, kernel, growth, part, from, to, planes, accounts)
    if (present(booked)) booked = .not. long
    select case (kernel)
    case (kernel_straight)
      call sum_planes(joint, kernel_straight, growth, part, from, to, planes, sums)
    case (kernel_guarded)
      call sum_planes(joint, kernel_guarded, growth, part, from, to, planes, sums)
    case (kernel_facet)
      call sum_planes(joint, kernel_facet, growth, part, from, to, planes, sums)
    case (kernel_worn)
      call sum_planes(joint, kernel_worn, growth, part, from, to, planes, sums)
    case (kernel_general)
      call sum_planes(joint, kernel_general, growth, part, from, to, planes, sums)
    case default
      call sum_planes(joint, kernel_damped, growth, part, from, to, planes, sums)
    end select
    if (long) then
      sums%rupture = accounts%rupture
      sums%friction = accounts%friction
    end if
    do k = 1, joint%pattern%n
      i = n_point_statev + n_plane_statev*(k - 1) + 1
      state(i) = planes%alpha(k)
      state(i + 1) = planes%s_dit(k)
      state(i + 2) = planes%s_dih(k)
    end do
    if (joint%material%wears) then
      do k = 1, joint%pattern%n
        i = facet_statev(joint%pattern%n, k)
        state(i) = planes%omega(k)
        state(i + 1) = planes%wear_work(k)
      end do
    end if
    ! weights whose sum is rounded up
    state(v_damage) = min(sums%damage, 1.0_wp)
    state(v_stored) = sums%stored
    state(v_rupture) = state(v_rupture) + sums%rupture
    state(v_friction) = state(v_friction) + sums%friction
    state(v_status) = 1.0_wp
    traction = sums%traction
    tangent = sums%tangent
  end subroutine update_point_in_place

  !> Separations of bond and contact of plane k.
  pure function plane_kinematics(joint, k, s, state) result(kinematics)
    type(interface_type), intent(in) :: joint   !! material and pattern
    integer, intent(in) :: k                    !! plane, 1..Np
    real(wp), intent(in) :: s(3)                !! separation (N, Tx, Ty), the offset included, length
    real(wp), intent(in) :: state(:)            !! STATEV
    type(kinematics_type) :: kinematics
    type(plane_type) :: plane
    type(local_type) :: bond
    type(material_type) :: m
    type(profile_type) :: profile
    type(facet_type) :: facet
    real(wp) :: rho
    plane = plane_of(joint%pattern, k)
    bond = local_separation(plane, vector_type(s(1), s(2), s(3)))
    rho = 1.0_wp
    if (joint%material%wears) rho = 1.0_wp - state(facet_statev(joint%pattern%n, k))
    if (joint%material%curved) then
      m = kernel_constants(joint%material, kernel_worn, .false., .false.)
      profile = profile_at(m, plane, rho, vector_type(s(1), s(2), s(3)))
      facet = facet_at(m, plane, rho, profile, vector_type(s(1), s(2), s(3)))
    else
      facet = facet_type(bond, plane%slope*(plane%e_x*s(2) + plane%e_y*s(3)), plane%n%n, plane%t%n, 1.0_wp, 0.0_wp, &
        0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
    end if
    kinematics%bond = [bond%n, bond%t, bond%h]
    kinematics%contact = [facet%s%n, facet%s%t, facet%s%h]
    associate (e => [0.0_wp, plane%e_x, plane%e_y], normal => [1.0_wp, 0.0_wp, 0.0_wp])
      kinematics%gradient(1, :) = facet%c*normal - (facet%q*facet%f)*e
      kinematics%gradient(2, :) = facet%q*normal + (facet%c*facet%f)*e
    end associate
    kinematics%gradient(3, :) = [0.0_wp, plane%h%x, plane%h%y]
    kinematics%touch = facet%z
  end function plane_kinematics

  !> Find the shares of the planes that the pressure at the end crushes.
  pure subroutine find_crushed(joint, kernel, to, planes)
    type(interface_type), intent(in) :: joint     !! material and pattern
    integer, intent(in) :: kernel                 !! which one
    type(vector_type), intent(in) :: to           !! separation at the end, length
    type(planes_type), intent(inout) :: planes    !! -> shares
    type(material_type) :: m
    type(plane_type) :: plane
    integer :: k
    m = kernel_constants(joint%material, kernel, .false., .false.)
    planes%crushed(:planes%n) = 0.0_wp
    if (.not. m%kt_crush > 0.0_wp) return
    !$omp simd
    do k = 1, planes%n
      plane = plane_of(joint%pattern, k)
      planes%crushed(k) = crushed_share(m, plane, to)
    end do
  end subroutine find_crushed

  !> Sum rupture and friction of a long increment over the planes. Public, so that the compiler keeps it apart.
  pure subroutine sum_accounts(joint, kernel, growth, wearing, from, to, planes, accounts)
    type(interface_type), intent(in) :: joint     !! material and pattern
    integer, intent(in) :: kernel                 !! that of the planes
    type(growth_type), intent(in) :: growth       !! of the damage
    real(wp), intent(in) :: wearing               !! part of the wear of the increment that is done, 0 to 1
    type(vector_type), intent(in) :: from, to     !! separation at start and end, length
    type(planes_type), intent(in) :: planes       !! state of the planes at the start
    type(dissipation_type), intent(out) :: accounts   !! energies
    select case (exact_kernel(kernel))
    case (kernel_straight)
      call add_accounts(joint, kernel_straight, growth, wearing, from, to, planes, accounts)
    case (kernel_general)
      call add_accounts(joint, kernel_general, growth, wearing, from, to, planes, accounts)
    case default
      call add_accounts(joint, kernel_damped, growth, wearing, from, to, planes, accounts)
    end select
  end subroutine sum_accounts

  !> The same with a literal kernel.
  pure subroutine add_accounts(joint, kernel, whole, wearing, from, to, start, accounts)
    type(interface_type), intent(in) :: joint     !! material and pattern
    integer, intent(in) :: kernel                 !! which one, a literal
    type(growth_type), intent(in) :: whole        !! of the damage in the increment
    real(wp), intent(in) :: wearing               !! part of the wear of the increment that is done, 0 to 1
    type(vector_type), intent(in) :: from, to     !! separation at start and end, length
    type(planes_type), intent(in) :: start        !! state of the planes at the start
    type(dissipation_type), intent(out) :: accounts   !! energies
    type(growth_type) :: growth
    type(history_type) :: state
    type(material_type) :: m
    type(plane_type) :: plane
    type(planes_type) :: planes
    type(update_type) :: now
    type(vector_type) :: first, last
    real(wp), dimension(padded_planes) :: released, alone   !! by each plane in the parts, in the increment as a whole
    real(wp), dimension(padded_planes) :: parted            !! damage after the parts
    real(wp) :: begin, counted, crushed, friction, rupture, x
    integer :: i, k, parts, rounds
    m = kernel_constants(joint%material, kernel, .false., .true.)
    rupture = 0.0_wp
    friction = 0.0_wp
    crushed = 0.0_wp
    released = 0.0_wp
    alone = 0.0_wp
    parted = 0.0_wp
    planes = start
    first = from
    parts = parts_of(joint%material)
    ! the guard decides for the increment as a whole, too
    rounds = parts + merge(1, 0, m%guard .and. parts > 1)
    begin = 0.0_wp
    do i = 1, rounds
      if (i > parts) then
        parted = planes%alpha
        planes = start
        first = from
        begin = 0.0_wp
      end if
      x = merge(part_ends(min(i, parts)), 1.0_wp, parts > 1)
      last = vector_type((1.0_wp - x)*from%n + x*to%n, (1.0_wp - x)*from%x + x*to%x, (1.0_wp - x)*from%y + x*to%y)
      growth = growth_of_part(m, whole, x - begin)
      begin = x
      counted = merge(1.0_wp, 0.0_wp, i <= parts)
      ! the kernel of a linear contact finds them in half the time
      if (m%wears .and. joint%material%hyperbolic) call find_crushed(joint, kernel_general, last, planes)
      if (m%wears .and. .not. joint%material%hyperbolic) call find_crushed(joint, kernel_worn, last, planes)
      !$omp simd reduction(+:friction)
      do k = 1, planes%n
        plane = plane_of(joint%pattern, k)
        state = history_type(planes%alpha(k), planes%s_dit(k), planes%s_dih(k), 0.0_wp, 0.0_wp)
        if (m%wears) state = history_type(planes%alpha(k), planes%s_dit(k), planes%s_dih(k), planes%omega(k), &
          planes%wear_work(k))
        if (m%wears) crushed = planes%crushed(k)
        now = update_plane(m, growth, plane, wearing, crushed, first, last, state)
        planes%alpha(k) = now%new%alpha
        planes%s_dit(k) = now%new%s_dit
        planes%s_dih(k) = now%new%s_dih
        if (m%wears) then
          planes%omega(k) = now%new%omega
          planes%wear_work(k) = now%new%wear_work
        end if
        alone(k) = (plane%gamma*m%k_t)*now%spent%rupture
        released(k) = released(k) + counted*alone(k)
        friction = friction + (counted*(plane%gamma*m%k_t))*now%spent%friction
      end do
      first = last
    end do
    if (rounds > parts) then
      !$omp simd reduction(+:rupture)
      do k = 1, planes%n
        rupture = rupture + guarded_release(start_alpha(m, start%alpha(k)), parted(k), planes%alpha(k), released(k), &
          alone(k))
      end do
      accounts = dissipation_type(0.5_wp*rupture, 0.5_wp*friction)
      return
    end if
    !$omp simd reduction(+:rupture)
    do k = 1, planes%n
      plane = plane_of(joint%pattern, k)
      x = merge(growth_over_parts(m, whole, plane, to, start%alpha(k), planes%alpha(k)), 1.0_wp, parts > 1)
      rupture = rupture + x*released(k)
    end do
    accounts = dissipation_type(0.5_wp*rupture, 0.5_wp*friction)
  end subroutine add_accounts

  !> Sum (3) over the planes: damage, energies, traction and consistent tangent.
  pure subroutine sum_planes(joint, kernel, growth, wearing, from, to, planes, sums)
    type(interface_type), intent(in) :: joint     !! material and pattern
    integer, intent(in) :: kernel                 !! which one, a literal
    type(growth_type), intent(in) :: growth       !! of the damage that no guard limits
    real(wp), intent(in) :: wearing               !! part of the wear of the increment that is done, 0 to 1
    type(vector_type), intent(in) :: from, to     !! separation at start and end, length
    type(planes_type), intent(inout) :: planes    !! state of the planes, start -> end
    type(sums_type), intent(out) :: sums          !! the sums
    type(history_type) :: state
    type(material_type) :: m
    type(plane_type) :: plane
    type(update_type) :: now
    real(wp) :: damage, stored, rupture, friction, t_n, t_x, t_y, d_nn, d_xn, d_yn, d_nx, d_xx, d_yx, d_ny, d_xy, d_yy
    real(wp) :: crushed, weight
    integer :: k

    m = kernel_constants(joint%material, kernel, .false., .false.)
    damage = 0.0_wp
    stored = 0.0_wp
    rupture = 0.0_wp
    friction = 0.0_wp
    t_n = 0.0_wp
    t_x = 0.0_wp
    t_y = 0.0_wp
    d_nn = 0.0_wp
    d_xn = 0.0_wp
    d_yn = 0.0_wp
    d_nx = 0.0_wp
    d_xx = 0.0_wp
    d_yx = 0.0_wp
    d_ny = 0.0_wp
    d_xy = 0.0_wp
    d_yy = 0.0_wp
    if (m%wears) call find_crushed(joint, kernel, to, planes)
    crushed = 0.0_wp
    !$omp simd reduction(+:damage, stored, rupture, friction, t_n, t_x, t_y) &
    !$omp reduction(+:d_nn, d_xn, d_yn, d_nx, d_xx, d_yx, d_ny, d_xy, d_yy)
    do k = 1, planes%n
      plane = plane_of(joint%pattern, k)
      weight = plane%gamma*m%k_t
      state = history_type(planes%alpha(k), planes%s_dit(k), planes%s_dih(k), 0.0_wp, 0.0_wp)
      if (m%wears) state = history_type(planes%alpha(k), planes%s_dit(k), planes%s_dih(k), planes%omega(k), &
        planes%wear_work(k))
      if (m%wears) crushed = planes%crushed(k)
      now = update_plane(m, growth, plane, wearing, crushed, from, to, state)
      planes%alpha(k) = now%new%alpha
      planes%s_dit(k) = now%new%s_dit
      planes%s_dih(k) = now%new%s_dih
      if (m%wears) then
        planes%omega(k) = now%new%omega
        planes%wear_work(k) = now%new%wear_work
      end if
      damage = damage + plane%gamma*now%new%alpha
      stored = stored + weight*now%stored
      rupture = rupture + weight*now%spent%rupture
      friction = friction + weight*now%spent%friction
      t_n = t_n + weight*now%traction%n
      t_x = t_x + weight*now%traction%x
      t_y = t_y + weight*now%traction%y
      d_nn = d_nn + weight*now%tangent%nn
      d_xn = d_xn + weight*now%tangent%xn
      d_yn = d_yn + weight*now%tangent%yn
      d_nx = d_nx + weight*now%tangent%nx
      d_xx = d_xx + weight*now%tangent%xx
      d_yx = d_yx + weight*now%tangent%yx
      d_ny = d_ny + weight*now%tangent%ny
      d_xy = d_xy + weight*now%tangent%xy
      d_yy = d_yy + weight*now%tangent%yy
    end do
    sums%damage = damage
    sums%stored = 0.5_wp*stored
    sums%rupture = 0.5_wp*rupture
    sums%friction = 0.5_wp*friction
    sums%traction = [t_n, t_x, t_y]
    sums%tangent(:, 1) = [d_nn, d_xn, d_yn]
    sums%tangent(:, 2) = [d_nx, d_xx, d_yx]
    sums%tangent(:, 3) = [d_ny, d_xy, d_yy]
  end subroutine sum_planes

end module asperity_point_kernel
