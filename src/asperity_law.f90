!> The law of one plane, and of the interface point: the sum (3) over the planes of its pattern.
!>
!> The planes are worked through by one loop without branches, so that the compiler can run it on vectors.
module asperity_law
  use asperity_kinds, only: wp
  use asperity_contract, only: n_plane_statev, n_point_statev, v_damage, v_friction, v_offset, v_rupture, v_status, &
    v_stored
  use asperity_interface, only: interface_type
  use asperity_material, only: material_type, over_time
  use asperity_pattern, only: max_lanes, pattern_type
  implicit none
  private
  public :: update_point, update_point_in_place

contains

  !> Traction, state and consistent tangent of a point at separation s, from the state it had at separation s_old.
  !>
  !> Nothing is tested here: `update_points` of asperity_points does that.
  pure subroutine update_point(joint, s_old, s, state_old, state, traction, tangent, dt)
    type(interface_type), intent(in) :: joint    !! material and pattern
    real(wp), intent(in) :: s_old(3)             !! separation (N, Tx, Ty) at the start of the increment, length
    real(wp), intent(in) :: s(3)                 !! separation at its end, length
    real(wp), intent(in), contiguous :: state_old(:)   !! STATEV at the start, size >= n_statev(Np)
    real(wp), intent(out), contiguous :: state(:)      !! STATEV at the end, same size
    real(wp), intent(out) :: traction(3)         !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)       !! d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt         !! duration of the increment, >= 0 (tau_v > 0 only), time; absent: 0
    state = state_old
    call update_point_in_place(joint, s_old, s, state, traction, tangent, dt)
  end subroutine update_point

  !> The same with one array for the state at the start and at the end.
  pure subroutine update_point_in_place(joint, s_old, s, state, traction, tangent, dt)
    type(interface_type), intent(in) :: joint    !! material and pattern
    real(wp), intent(in) :: s_old(3)             !! separation (N, Tx, Ty) at the start of the increment, length
    real(wp), intent(in) :: s(3)                 !! separation at its end, length
    real(wp), intent(inout), contiguous :: state(:)   !! STATEV, start -> end, size >= n_statev(Np)
    real(wp), intent(out) :: traction(3)         !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)       !! d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt         !! duration of the increment, >= 0 (tau_v > 0 only), time; absent: 0
    real(wp) :: alpha(max_lanes), d_t(max_lanes), d_h(max_lanes), sums(4)
    integer :: i, k

    do k = 1, joint%pattern%n
      i = n_point_statev + n_plane_statev*(k - 1) + 1
      alpha(k) = state(i)
      d_t(k) = state(i + 1)
      d_h(k) = state(i + 2)
    end do
    do k = joint%pattern%n + 1, joint%pattern%lanes
      alpha(k) = 0.0_wp
      d_t(k) = 0.0_wp
      d_h(k) = 0.0_wp
    end do
    call sum_planes(over_time(joint%material, dt), joint%pattern, s_old + state(v_offset:v_offset + 2), &
      s + state(v_offset:v_offset + 2), alpha, d_t, d_h, sums, traction, tangent)
    do k = 1, joint%pattern%n
      i = n_point_statev + n_plane_statev*(k - 1) + 1
      state(i) = alpha(k)
      state(i + 1) = d_t(k)
      state(i + 2) = d_h(k)
    end do
    state(v_damage) = sums(1)
    state(v_stored) = sums(2)
    state(v_rupture) = state(v_rupture) + sums(3)
    state(v_friction) = state(v_friction) + sums(4)
    state(v_status) = 1.0_wp
  end subroutine update_point_in_place

  !> Sum (3) over the planes: damage, energies, traction and consistent tangent.
  !>
  !> Per plane: damage (25), return mapping (30)-(39), traction (22). The tangent is unsymmetric where a plane slides in
  !> contact or is damaged while it slides. Rupture by the trapezoid of Y, friction by that of the friction strength
  !> (docs/theory.md).
  pure subroutine sum_planes(material, pattern, from, to, alpha, d_t, d_h, sums, traction, tangent)
    type(material_type), intent(in) :: material   !! constants of the law
    type(pattern_type), intent(in) :: pattern     !! frames and weights
    real(wp), intent(in) :: from(3), to(3)        !! separation at start and end, length
    real(wp), intent(inout) :: alpha(max_lanes)   !! damage of the planes, start -> end
    real(wp), intent(inout) :: d_t(max_lanes)     !! inelastic slip s_dit, start -> end, length
    real(wp), intent(inout) :: d_h(max_lanes)     !! inelastic slip s_dih, start -> end, length
    real(wp), intent(out) :: sums(4)              !! damage; energy stored, increments of rupture, friction
    real(wp), intent(out) :: traction(3)          !! stress
    real(wp), intent(out) :: tangent(3, 3)        !! stress/length
    include "asperity_plane_names.inc"
    type(material_type) :: m
    integer :: k

    m = material
    from_1 = from(1)
    from_2 = from(2)
    from_3 = from(3)
    to_1 = to(1)
    to_2 = to(2)
    to_3 = to(3)
    damage = 0.0_wp
    stored = 0.0_wp
    rupture = 0.0_wp
    friction = 0.0_wp
    sigma_1 = 0.0_wp
    sigma_2 = 0.0_wp
    sigma_3 = 0.0_wp
    d11 = 0.0_wp
    d21 = 0.0_wp
    d31 = 0.0_wp
    d12 = 0.0_wp
    d22 = 0.0_wp
    d32 = 0.0_wp
    d13 = 0.0_wp
    d23 = 0.0_wp
    d33 = 0.0_wp
    !$omp simd reduction(+:damage, stored, rupture, friction, sigma_1, sigma_2, sigma_3) &
    !$omp reduction(+:d11, d21, d31, d12, d22, d32, d13, d23, d33)
    do k = 1, pattern%lanes
      c = pattern%cos_theta(k)
      s = pattern%sin_theta(k)
      e_x = pattern%e_x(k)
      e_y = pattern%e_y(k)
      h_x = pattern%h_x(k)
      h_y = pattern%h_y(k)
      gamma = pattern%gamma(k)
      alpha0 = alpha(k)
      d_t0 = d_t(k)
      d_h0 = d_h(k)
      include "asperity_plane.inc"
      alpha(k) = alpha1
      d_t(k) = d_t1
      d_h(k) = d_h1
    end do
    traction = [sigma_1, sigma_2, sigma_3]
    sums = [damage, stored, rupture, friction]
    tangent(:, 1) = [d11, d21, d31]
    tangent(:, 2) = [d12, d22, d32]
    tangent(:, 3) = [d13, d23, d33]
  end subroutine sum_planes

end module asperity_law
