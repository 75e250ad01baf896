!> The law of an interface point: the sum (3) over the planes of its pattern, one point at a time.
!>
!> asperity_plane.inc holds the law of one plane. The compiler vectorises the loop over the planes.
module asperity_law
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_contract, only: n_plane_statev, n_point_statev, v_damage, v_friction, v_offset, v_rupture, v_status, &
    v_stored
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_material, only: material_type, over_time
  use asperity_pattern, only: max_lanes, pattern_type
  implicit none
  private
  public :: update_point, update_point_in_place
  include "asperity_plane_types.inc"

contains

  include "asperity_plane.inc"

  !> Traction, state and consistent tangent of a point at separation s, from the state it had at separation s_old.
  !>
  !> This procedure does not test its input; `update_points` of asperity_points does.
  pure subroutine update_point(joint, s_old, s, state_old, state, traction, tangent, dt)
    type(interface_type), intent(in) :: joint          !! material and pattern
    real(wp), intent(in) :: s_old(3)                   !! separation (N, Tx, Ty) at the start of the increment, length
    real(wp), intent(in) :: s(3)                       !! separation at its end, length
    real(wp), intent(in), contiguous :: state_old(:)   !! STATEV at the start, size >= n_statev(Np)
    real(wp), intent(out), contiguous :: state(:)      !! STATEV at the end, same size
    real(wp), intent(out) :: traction(3)               !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)             !! d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt               !! duration, >= 0 (used only if tau_v > 0), time; absent: 0
    state = state_old
    call update_point_in_place(joint, s_old, s, state, traction, tangent, dt)
  end subroutine update_point

  !> As update_point, but one array holds the state at the start and then the state at the end.
  pure subroutine update_point_in_place(joint, s_old, s, state, traction, tangent, dt)
    type(interface_type), intent(in) :: joint          !! material and pattern
    real(wp), intent(in) :: s_old(3)                   !! separation (N, Tx, Ty) at the start of the increment, length
    real(wp), intent(in) :: s(3)                       !! separation at its end, length
    real(wp), intent(inout), contiguous :: state(:)    !! STATEV, start -> end, size >= n_statev(Np)
    real(wp), intent(out) :: traction(3)               !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)             !! d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt               !! duration, >= 0 (used only if tau_v > 0), time; absent: 0
    type(vector_type) :: from, to
    real(wp) :: alpha(max_lanes), s_dit(max_lanes), s_dih(max_lanes), sums(4)
    integer :: i, k

    do k = 1, joint%pattern%n
      i = n_point_statev + n_plane_statev*(k - 1) + 1
      alpha(k) = state(i)
      s_dit(k) = state(i + 1)
      s_dih(k) = state(i + 2)
    end do
    do k = joint%pattern%n + 1, joint%pattern%lanes
      alpha(k) = 0.0_wp
      s_dit(k) = 0.0_wp
      s_dih(k) = 0.0_wp
    end do
    from = vector_type(s_old(1) + state(v_offset), s_old(2) + state(v_offset + 1), s_old(3) + state(v_offset + 2))
    to = vector_type(s(1) + state(v_offset), s(2) + state(v_offset + 1), s(3) + state(v_offset + 2))
    call sum_planes(constants_of(joint%material, dt), joint%pattern, from, to, joint%material%guard, alpha, s_dit, &
      s_dih, sums, traction, tangent)
    do k = 1, joint%pattern%n
      i = n_point_statev + n_plane_statev*(k - 1) + 1
      state(i) = alpha(k)
      state(i + 1) = s_dit(k)
      state(i + 2) = s_dih(k)
    end do
    state(v_damage) = sums(1)
    state(v_stored) = sums(2)
    state(v_rupture) = state(v_rupture) + sums(3)
    state(v_friction) = state(v_friction) + sums(4)
    state(v_status) = 1.0_wp
  end subroutine update_point_in_place

  !> Sum (3) over the planes: damage, energies, traction and consistent tangent.
  pure subroutine sum_planes(m, pattern, from, to, guard, alpha, s_dit, s_dih, sums, traction, tangent)
    type(constants_type), intent(in) :: m         !! constants of the law
    type(pattern_type), intent(in) :: pattern     !! frames and weights
    type(vector_type), intent(in) :: from, to     !! separation at start and end, length
    logical, intent(in) :: guard                  !! whether damage grows only where its dissipation is >= 0
    real(wp), intent(inout) :: alpha(max_lanes)   !! damage of the planes, start -> end
    real(wp), intent(inout) :: s_dit(max_lanes)   !! inelastic slip, start -> end, length
    real(wp), intent(inout) :: s_dih(max_lanes)   !! inelastic slip, start -> end, length
    real(wp), intent(out) :: sums(4)              !! damage; energy stored, increments of rupture and friction
    real(wp), intent(out) :: traction(3)          !! stress
    real(wp), intent(out) :: tangent(3, 3)        !! stress/length
    type(plane_type) :: plane
    type(history_type) :: old
    type(response_type) :: now
    type(dissipation_type) :: spent
    type(vector_type) :: t
    type(tensor_type) :: d
    real(wp) :: damage, stored, rupture, friction, t_n, t_x, t_y, d_nn, d_xn, d_yn, d_nx, d_xx, d_yx, d_ny, d_xy, d_yy
    real(wp) :: limit(max_lanes), weight
    integer :: k

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
    limit(:pattern%lanes) = m%take
    if (guard) then
      !$omp simd
      do k = 1, pattern%lanes
        plane = plane_of(pattern, k)
        old = history_type(alpha(k), s_dit(k), s_dih(k))
        limit(k) = guarded_limit(m, plane, from, to, old)
      end do
    end if
    !$omp simd reduction(+:damage, stored, rupture, friction, t_n, t_x, t_y) &
    !$omp reduction(+:d_nn, d_xn, d_yn, d_nx, d_xx, d_yx, d_ny, d_xy, d_yy)
    do k = 1, pattern%lanes
      plane = plane_of(pattern, k)
      weight = plane%gamma*m%k_t
      old = history_type(alpha(k), s_dit(k), s_dih(k))
      now = plane_response(m, plane, to, old, limit(k))
      alpha(k) = now%new%alpha
      s_dit(k) = now%new%s_dit
      s_dih(k) = now%new%s_dih
      spent = plane_dissipation(m, plane, from, to, old, now%new, now%friction%slip)
      damage = damage + plane%gamma*now%new%alpha
      stored = stored + weight*stored_energy(m, now)
      rupture = rupture + weight*spent%rupture
      friction = friction + weight*spent%friction
      t = global_traction(plane, now%sigma)
      t_n = t_n + weight*t%n
      t_x = t_x + weight*t%x
      t_y = t_y + weight*t%y
      d = plane_tangent(m, plane, to, old, limit(k), now)
      d_nn = d_nn + weight*d%nn
      d_xn = d_xn + weight*d%xn
      d_yn = d_yn + weight*d%yn
      d_nx = d_nx + weight*d%nx
      d_xx = d_xx + weight*d%xx
      d_yx = d_yx + weight*d%yx
      d_ny = d_ny + weight*d%ny
      d_xy = d_xy + weight*d%xy
      d_yy = d_yy + weight*d%yy
    end do
    traction = [t_n, t_x, t_y]
    sums = [damage, 0.5_wp*stored, 0.5_wp*rupture, 0.5_wp*friction]
    tangent(:, 1) = [d_nn, d_xn, d_yn]
    tangent(:, 2) = [d_nx, d_xx, d_yx]
    tangent(:, 3) = [d_ny, d_xy, d_yy]
  end subroutine sum_planes

end module asperity_law
