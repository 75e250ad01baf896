!> The consistent tangent of a plane.
!>
!> The module asperity_law says how these functions are used and in which units.
module asperity_tangent
  use asperity_axes, only: global_traction
  use asperity_contact, only: opening
  use asperity_facet, only: facet_tangent
  use asperity_kinds, only: wp
  use asperity_types, only: growth_type, history_type, local_type, material_type, moduli_type, plane_type, &
    response_type, separation_type, tensor_type, vector_type
  use asperity_wear, only: crush_gradient
  implicit none
  private
  public :: plane_tangent

contains

  !> Factors of friction and of growing damage in the tangent of a plane. At a kink of the law (onset of slip, contact
  !> or damage) they are those of one side.
  pure function plane_moduli(m, growth, at, old, now) result(moduli)
    type(material_type), intent(in) :: m             !! constants
    type(growth_type), intent(in) :: growth          !! of the damage
    type(separation_type), intent(in) :: at          !! separations at the end
    type(history_type), intent(in) :: old            !! state at the start
    type(response_type), intent(in) :: now           !! response to the increment
    type(moduli_type) :: moduli
    real(wp) :: chi, grows, slips, stuck
    associate (alpha => now%new%alpha, friction => now%friction, gap => at%contact%n, inv_r => now%damage%inv_r)
      ! conditions are reals: gfortran does not vectorise a logical expression of two comparisons
      stuck = merge(merge(1.0_wp, 0.0_wp, gap <= 0.0_wp), 0.0_wp, friction%trial <= friction%strength)
      ! without friction a trial stress that is exactly zero sticks nowhere
      stuck = merge(stuck, 0.0_wp, m%mu > 0.0_wp)
      slips = (1.0_wp - stuck)*merge(1.0_wp, 0.0_wp, gap < 0.0_wp)
      grows = merge(merge(1.0_wp, 0.0_wp, now%damage%free < growth%limit), 0.0_wp, alpha > old%alpha)
      chi = friction%stress*friction%inv_trial
      moduli%tangential = merge(1.0_wp, chi, stuck > 0.0_wp)
      moduli%slip_term = -((slips*alpha)*chi)
      if (m%damps) then
        ! the trial stress changes with that of the dashpot, too
        moduli%tangential = (1.0_wp + growth%lag)*moduli%tangential
        moduli%slip_term = (1.0_wp + growth%lag)*moduli%slip_term
      end if
      moduli%coupling = -((slips*alpha)*(m%mu*friction%stiffness))
      moduli%damage = (grows*growth%weight_eta)*(inv_r*inv_r*inv_r)
      moduli%omega = local_type(0.0_wp, 0.0_wp, 0.0_wp)
    end associate
  end function plane_moduli

  !> Consistent tangent of a plane.
  pure function plane_tangent(m, growth, plane, at, s, old, crushes, now) result(tangent)
    type(material_type), intent(in) :: m             !! constants
    type(growth_type), intent(in) :: growth          !! of the damage
    type(plane_type), intent(in) :: plane            !! axes
    type(separation_type), intent(in) :: at          !! separations at the end
    type(vector_type), intent(in) :: s               !! separation of the interface at the end
    type(history_type), intent(in) :: old            !! state at the start
    real(wp), intent(in) :: crushes                  !! worn share if the pressure at the end crushes the facet, else 0
    type(response_type), intent(in) :: now           !! response to the increment
    type(tensor_type) :: tangent
    type(moduli_type) :: moduli
    moduli = plane_moduli(m, growth, at, old, now)
    if (m%wears) moduli%omega = crush_gradient(m, at, s%n, crushes)
    if (m%general) then
      tangent = facet_tangent(m, plane, moduli, at, now)
    else
      tangent = straight_tangent(m, plane, moduli, at, s, now)
    end if
  end function plane_tangent

  !> Consistent tangent of a straight plane: a I + b n (x) n + m (x) (c m + d n) + w (x) g (docs/theory.md, section 5).
  !>
  !> It is unsymmetric where the plane slips in contact or its damage grows with slip.
  pure function straight_tangent(m, plane, moduli, at, s, now) result(tangent)
    type(material_type), intent(in) :: m             !! constants
    type(plane_type), intent(in) :: plane            !! axes
    type(moduli_type), intent(in) :: moduli          !! factors of friction and damage
    type(separation_type), intent(in) :: at          !! separations at the end
    type(vector_type), intent(in) :: s               !! separation of the interface at the end
    type(response_type), intent(in) :: now           !! response to the increment
    type(tensor_type) :: tangent
    type(vector_type) :: direction, dragged, released, gradient
    real(wp) :: a, b, normal
    associate (n => plane%n, t => plane%t, h => plane%h, local => at%bond, friction => now%friction, &
               alpha => now%new%alpha, new => now%new, c => moduli%slip_term, d => moduli%coupling)
      a = (1.0_wp - alpha) + alpha*moduli%tangential
      b = merge(m%kc_kt, merge(1.0_wp, 1.0_wp - alpha, local%n <= 0.0_wp)*m%kn_kt, local%n < 0.0_wp) - a
      direction = vector_type(t%n*friction%m_t, t%x*friction%m_t + h%x*friction%m_h, &
        t%y*friction%m_t + h%y*friction%m_h)
      dragged = vector_type(c*direction%n + d*n%n, c*direction%x + d*n%x, c*direction%y + d*n%y)
      ! w = sigma_d - sigma_u = -(K_n <s_n>_+, K_t s_di), and its factor in d alpha/d s
      released = global_traction(plane, local_type(-moduli%damage*(m%kn_kt*opening(local)), -moduli%damage*new%s_dit, &
        -moduli%damage*new%s_dih))
      ! s_t t + s_h h = s - s_n n: the gradient needs only n
      normal = m%s02_s01_2*opening(local) - local%n
      gradient = vector_type(m%inv_s02_2*(s%n + n%n*normal), m%inv_s02_2*(s%x + n%x*normal), &
        m%inv_s02_2*(s%y + n%y*normal))
      tangent%nn = (a + b*(n%n*n%n)) + (direction%n*dragged%n + released%n*gradient%n)
      tangent%xn = b*(n%x*n%n) + (direction%x*dragged%n + released%x*gradient%n)
      tangent%yn = b*(n%y*n%n) + (direction%y*dragged%n + released%y*gradient%n)
      tangent%nx = b*(n%x*n%n) + (direction%n*dragged%x + released%n*gradient%x)
      tangent%xx = (a + b*(n%x*n%x)) + (direction%x*dragged%x + released%x*gradient%x)
      tangent%yx = b*(n%y*n%x) + (direction%y*dragged%x + released%y*gradient%x)
      tangent%ny = b*(n%y*n%n) + (direction%n*dragged%y + released%n*gradient%y)
      tangent%xy = b*(n%y*n%x) + (direction%x*dragged%y + released%x*gradient%y)
      tangent%yy = (a + b*(n%y*n%y)) + (direction%y*dragged%y + released%y*gradient%y)
    end associate
  end function straight_tangent

end module asperity_tangent
