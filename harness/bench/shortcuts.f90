!> Prototypes of shortcuts the library does not take, to measure what each would gain at best: the block kernel without
!> what vanishes for virgin planes (alpha = 0) or without friction (mu = 0), on points for which that holds or not.
module shortcuts
  use asperity_block_double, only: block_type, chunk
  use block_work_double, only: block_work_type
  use asperity_contract, only: n_plane_statev, n_point_statev
  use asperity_kinds, only: wp
  implicit none
  private
  public :: run_shortcut

contains

  !> A prototype of a shortcut in place of the block kernel; the scene is that of the block kernel.
  pure subroutine run_shortcut(work, friction, used)
    type(block_work_type), intent(inout) :: work   !! the points
    logical, intent(in) :: friction                !! virgin planes with friction, or damaged ones without
    real(wp), intent(inout) :: used            !! sum of results
    real(wp) :: sums(chunk, 7)
    integer :: first, i, j, k
    do i = 1, size(work%s1, 3)
      first = chunk*(i - 1) + 1
      do j = 1, size(work%old, 2)
        do k = first, first + chunk - 1
          work%new(k, j) = work%old(k, j)
        end do
      end do
      if (friction) then
        call update_virgin(work%block, chunk, work%s0(:, :, i), work%s1(:, :, i), work%n_points, &
          work%new(first, 1), sums)
      else
        call update_frictionless(work%block, chunk, work%s0(:, :, i), work%s1(:, :, i), work%n_points, &
          work%new(first, 1), sums)
      end if
      work%traction(:, :, i) = sums(:, 1:3)
      used = used + sums(1, 1) + sums(1, 5)
    end do
  end subroutine run_shortcut

  !> Stress, slips and energies where no plane is damaged: no damage, no energy of rupture or friction.
  pure subroutine update_virgin(block, n, from, to, n_state, state, sums)
    type(block_type), intent(in) :: block          !! the interface
    integer, intent(in) :: n                       !! points, at most chunk
    real(wp), intent(in) :: from(chunk, 3)         !! separation at the start, length
    real(wp), intent(in) :: to(chunk, 3)           !! separation at the end, length
    integer, intent(in) :: n_state                 !! leading dimension of state
    real(wp), intent(inout) :: state(n_state, *)   !! STATEV, start -> end
    real(wp), intent(out) :: sums(chunk, 6)        !! traction, stored, work of the start, largest root
    real(wp) :: c, s, h_x, h_y, n_2, n_3, t_2, t_3, gamma, weight, half, d_t0, d_h0, s_n0, s_t0, s_h0, s_n, s_t, s_h
    real(wp) :: open0, open1, closed1, push1, s_t_norm2, root, e_t, e_h, e, inv_e, slip, sigma_n, r
    integer :: a, i, k

    sums(:n, :) = 0.0_wp
    do k = 1, block%n_planes
      include "shortcuts_frame.inc"
      !$omp simd
      do i = 1, n
        d_t0 = state(i, a + 1)
        d_h0 = state(i, a + 2)
        s_n0 = c*from(i, 1) + (n_2*from(i, 2) + n_3*from(i, 3))
        s_t0 = s*from(i, 1) + (t_2*from(i, 2) + t_3*from(i, 3))
        s_h0 = h_x*from(i, 2) + h_y*from(i, 3)
        s_n = c*to(i, 1) + (n_2*to(i, 2) + n_3*to(i, 3))
        s_t = s*to(i, 1) + (t_2*to(i, 2) + t_3*to(i, 3))
        s_h = h_x*to(i, 2) + h_y*to(i, 3)
        open0 = max(s_n0, 0.0_wp)
        open1 = max(s_n, 0.0_wp)
        closed1 = s_n - open1
        push1 = block%material%kc_kt*closed1
        s_t_norm2 = s_t**2 + s_h**2
        ! the chunk would have to be done again where this exceeds 1
        root = block%material%inv_s01_2*open1**2 + block%material%inv_s02_2*s_t_norm2
        e_t = s_t - d_t0
        e_h = s_h - d_h0
        e = sqrt(e_t**2 + e_h**2)
        inv_e = 1.0_wp/(e + tiny(1.0_wp))
        slip = (e - min(e, (-block%material%mu)*push1))*inv_e
        state(i, a + 1) = d_t0 + slip*e_t
        state(i, a + 2) = d_h0 + slip*e_h
        sigma_n = block%material%kn_kt*open1 + push1
        r = block%material%kn_kt*open0 + block%material%kc_kt*(s_n0 - open0)
        sums(i, 1) = sums(i, 1) + ((weight*c)*sigma_n + (weight*s)*s_t)
        sums(i, 2) = sums(i, 2) + ((weight*n_2)*sigma_n + ((weight*t_2)*s_t + (weight*h_x)*s_h))
        sums(i, 3) = sums(i, 3) + ((weight*n_3)*sigma_n + ((weight*t_3)*s_t + (weight*h_y)*s_h))
        sums(i, 4) = sums(i, 4) + half*(sigma_n*s_n + s_t_norm2)
        sums(i, 5) = sums(i, 5) + half*(r*(s_n - s_n0) + (s_t0*(s_t - s_t0) + s_h0*(s_h - s_h0)))
        sums(i, 6) = max(sums(i, 6), root)
      end do
    end do
  end subroutine update_virgin

  !> Stress, damage, slips and energies without friction: the slips follow the separation.
  pure subroutine update_frictionless(block, n, from, to, n_state, state, sums)
    type(block_type), intent(in) :: block          !! the interface
    integer, intent(in) :: n                       !! points, at most chunk
    real(wp), intent(in) :: from(chunk, 3)         !! separation at the start, length
    real(wp), intent(in) :: to(chunk, 3)           !! separation at the end, length
    integer, intent(in) :: n_state                 !! leading dimension of state
    real(wp), intent(inout) :: state(n_state, *)   !! STATEV, start -> end
    real(wp), intent(out) :: sums(chunk, 7)        !! traction, stored, work of the start, rupture, damage
    real(wp) :: c, s, h_x, h_y, n_2, n_3, t_2, t_3, gamma, weight, half, d_t0, d_h0, s_n0, s_t0, s_h0, s_n, s_t, s_h
    real(wp) :: open0, open1, closed1, pull0, pull1, push1, s_t_norm2, root, alpha0, alpha1, sound, y0, y1, r
    real(wp) :: sigma_n, tau_t, tau_h
    integer :: a, i, k

    sums(:n, :) = 0.0_wp
    do k = 1, block%n_planes
      include "shortcuts_frame.inc"
      !$omp simd
      do i = 1, n
        alpha0 = state(i, a)
        d_t0 = state(i, a + 1)
        d_h0 = state(i, a + 2)
        s_n0 = c*from(i, 1) + (n_2*from(i, 2) + n_3*from(i, 3))
        s_t0 = s*from(i, 1) + (t_2*from(i, 2) + t_3*from(i, 3))
        s_h0 = h_x*from(i, 2) + h_y*from(i, 3)
        s_n = c*to(i, 1) + (n_2*to(i, 2) + n_3*to(i, 3))
        s_t = s*to(i, 1) + (t_2*to(i, 2) + t_3*to(i, 3))
        s_h = h_x*to(i, 2) + h_y*to(i, 3)
        open0 = max(s_n0, 0.0_wp)
        open1 = max(s_n, 0.0_wp)
        closed1 = s_n - open1
        pull0 = block%material%kn_kt*open0
        pull1 = block%material%kn_kt*open1
        push1 = block%material%kc_kt*closed1
        s_t_norm2 = s_t**2 + s_h**2
        root = sqrt(max(1.0_wp, block%material%inv_s01_2*open1**2 + block%material%inv_s02_2*s_t_norm2))
        alpha1 = max(alpha0, min(1.0_wp, block%material%take_eta*(1.0_wp - 1.0_wp/root)))
        sound = 1.0_wp - alpha1
        state(i, a) = alpha1
        state(i, a + 1) = s_t
        state(i, a + 2) = s_h
        y0 = pull0*open0 + (d_t0*(s_t0 + (s_t0 - d_t0)) + d_h0*(s_h0 + (s_h0 - d_h0)))
        y1 = pull1*open1 + s_t_norm2
        sigma_n = sound*pull1 + push1
        tau_t = sound*s_t
        tau_h = sound*s_h
        r = pull0 - alpha0*pull0 + block%material%kc_kt*(s_n0 - open0)
        sums(i, 1) = sums(i, 1) + ((weight*c)*sigma_n + (weight*s)*tau_t)
        sums(i, 2) = sums(i, 2) + ((weight*n_2)*sigma_n + ((weight*t_2)*tau_t + (weight*h_x)*tau_h))
        sums(i, 3) = sums(i, 3) + ((weight*n_3)*sigma_n + ((weight*t_3)*tau_t + (weight*h_y)*tau_h))
        sums(i, 4) = sums(i, 4) + half*(sound*y1 + push1*closed1)
        sums(i, 5) = sums(i, 5) + half*(r*(s_n - s_n0) &
          + ((s_t0 - alpha0*d_t0)*(s_t - s_t0) + (s_h0 - alpha0*d_h0)*(s_h - s_h0)))
        sums(i, 6) = sums(i, 6) + (0.5_wp*half)*((y0 + y1)*(alpha1 - alpha0))
        sums(i, 7) = sums(i, 7) + gamma*alpha1
      end do
    end do
  end subroutine update_frictionless

end module shortcuts
