!> The law as in a textbook: one plane after the other, with rotation matrices and matmul.
!>
!> This version does not use the library's kernels, because their speed is compared with it. The benchmark stops if its
!> traction or tangent differs from that of the kernels.
module textbook
  use asperity_kinds, only: wp
  use asperity_interface, only: interface_type
  use asperity_pattern, only: plane_normal
  use asperity_contract, only: plane_statev
  implicit none
  private
  public :: textbook_update

contains

  !> Traction (3), state and (on request) tangent: damage (25) and return mapping (30)-(39) in the local frame of each
  !> plane, the tangent rotated by matmul; no energies.
  pure subroutine textbook_update(joint, s, state_old, state, traction, tangent)
    type(interface_type), intent(in) :: joint   !! material and pattern
    real(wp), intent(in) :: s(3)               !! separation, length
    real(wp), intent(in) :: state_old(:)       !! STATEV at the start
    real(wp), intent(inout) :: state(:)        !! STATEV at the end
    real(wp), intent(out) :: traction(3)       !! stress
    real(wp), intent(out), optional :: tangent(3, 3)   !! stress/length
    real(wp) :: q(3, 3), local(3), sigma(3), sound(3), broken(3), trial(2), m(3), gradient(3), d(3, 3), stiffness(3)
    real(wp) :: alpha, alpha_old, beta, tau, p
    integer :: i, k

    traction = 0.0_wp
    if (present(tangent)) tangent = 0.0_wp
    associate (material => joint%material, pattern => joint%pattern)
      do k = 1, pattern%n
        q(1, :) = plane_normal(pattern, k)
        q(2, :) = [pattern%sin_theta(k), pattern%cos_theta(k)*pattern%e_x(k), &
                   pattern%cos_theta(k)*pattern%e_y(k)]
        q(3, :) = [0.0_wp, pattern%e_y(k), pattern%h_y(k)]
        i = plane_statev(k)
        local = matmul(q, s)
        stiffness = [merge(material%k_c, material%k_n, local(1) < 0.0_wp), material%k_t, material%k_t]
        beta = sqrt(material%inv_s01_2*max(local(1), 0.0_wp)**2 + material%inv_s02_2*sum(local(2:3)**2)) - 1.0_wp
        alpha_old = state_old(i)
        alpha = alpha_old
        if (beta > 0.0_wp) alpha = max(alpha_old, min(1.0_wp, beta/((1.0_wp + beta)*material%eta)))
        sound = stiffness*local
        broken = 0.0_wp
        trial = material%k_t*(local(2:3) - state_old(i + 1:i + 2))
        tau = sqrt(sum(trial**2))
        p = -stiffness(1)*min(local(1), 0.0_wp)
        broken(1) = -p
        broken(2:3) = trial
        if (tau > material%mu*p) broken(2:3) = material%mu*p*trial/tau
        sigma = (1.0_wp - alpha)*sound + alpha*broken
        state(i) = alpha
        state(i + 1:i + 2) = local(2:3) - broken(2:3)/material%k_t
        traction = traction + pattern%gamma(k)*matmul(transpose(q), sigma)
        if (.not. present(tangent)) cycle
        d = 0.0_wp
        do i = 1, 3
          d(i, i) = (1.0_wp - alpha)*stiffness(i)
        end do
        if (local(1) <= 0.0_wp) d(1, 1) = stiffness(1)
        if (tau > material%mu*p) then
          if (p > 0.0_wp) then
            m = [0.0_wp, trial(1)/tau, trial(2)/tau]
            do i = 2, 3
              d(i, i) = d(i, i) + alpha*material%mu*p/tau*material%k_t
              d(i, 1) = d(i, 1) - alpha*material%mu*stiffness(1)*m(i)
              d(i, 2:3) = d(i, 2:3) - alpha*material%mu*p/tau*material%k_t*m(i)*m(2:3)
            end do
          end if
        else
          d(2, 2) = d(2, 2) + alpha*material%k_t
          d(3, 3) = d(3, 3) + alpha*material%k_t
        end if
        if (alpha > alpha_old .and. alpha < 1.0_wp) then
          gradient = [material%inv_s01_2*max(local(1), 0.0_wp), material%inv_s02_2*local(2), &
                      material%inv_s02_2*local(3)]/(material%eta*(1.0_wp + beta)**3)
          do i = 1, 3
            d(:, i) = d(:, i) + (broken - sound)*gradient(i)
          end do
        end if
        tangent = tangent + pattern%gamma(k)*matmul(transpose(q), matmul(d, q))
      end do
    end associate
  end subroutine textbook_update

end module textbook
