!> Material of one plane: the constants of the law derived from sigma0, Gc, eta, mu (paper, Section 2.2).
module asperity_material
  use asperity_contract, only: n_fixed_props, p_eta, p_gc, p_gc2, p_guard, p_height, p_kc, p_mu, &
    p_sigma0, p_sigma02, p_tau_v, p_w0
  use asperity_kinds, only: wp
  implicit none
  private
  public :: material_type, new_material, over_time

  !> Constants of the law, in the user's consistent units.
  type :: material_type
    real(wp) :: eta         !! ductility (5), -
    real(wp) :: mu          !! friction coefficient (18), -
    real(wp) :: k_n         !! normal stiffness (12), stress/length
    real(wp) :: k_t         !! tangential stiffness (12), stress/length
    real(wp) :: k_c         !! normal stiffness in closure, stress/length
    real(wp) :: kn_kt       !! k_n/k_t
    real(wp) :: kc_kt       !! k_c/k_t
    real(wp) :: inv_s01_2   !! 1/s01^2, s01 = separation at damage onset in mode I
    real(wp) :: inv_s02_2   !! 1/s02^2, s02 = slip at damage onset in mode II
    real(wp) :: s02_s01_2   !! (s02/s01)^2
    real(wp) :: s0          !! the smaller of s01 and s02, length
    real(wp) :: tau_v       !! relaxation time of the damage, 0: none
    real(wp) :: keep = 0.0_wp   !! weight of the old damage in the new one, set by `over_time`
    real(wp) :: take = 1.0_wp   !! weight of the equilibrium damage, (7) without history
    real(wp) :: take_eta        !! take/eta
    logical :: guard            !! whether damage grows only where its dissipation is >= 0
    real(wp) :: height          !! height of the asperities, 0: infinite, length
    logical :: curved           !! whether the contact of a plane lies on a curved facet
    logical :: wears            !! whether the facets wear
    real(wp) :: inv_w0          !! inverse of the work that wears 63 % off; 0: no wear, 1/(stress*length)
  end type material_type

contains

  !> Constants of the law from admissible PROPS: s_f = 2 Gc/sigma0, (5), (12); a mode II value of 0 is that of mode I.
  pure function new_material(props) result(material)
    real(wp), intent(in) :: props(n_fixed_props)   !! PROPS before the listed planes, admissible
    type(material_type) :: material
    real(wp) :: gc2, inv_s01, inv_s02, sigma02

    material%eta = props(p_eta)
    material%mu = props(p_mu)
    sigma02 = merge(props(p_sigma02), props(p_sigma0), props(p_sigma02) > 0.0_wp)
    gc2 = merge(props(p_gc2), props(p_gc), props(p_gc2) > 0.0_wp)
    inv_s01 = props(p_sigma0)/((1.0_wp - material%eta)*2.0_wp*props(p_gc))
    inv_s02 = sigma02/((1.0_wp - material%eta)*2.0_wp*gc2)
    material%k_n = props(p_sigma0)*inv_s01
    material%k_t = sigma02*inv_s02
    material%k_c = merge(props(p_kc), 1.0_wp, props(p_kc) > 0.0_wp)*material%k_n
    material%inv_s01_2 = inv_s01**2
    material%inv_s02_2 = inv_s02**2
    material%take_eta = 1.0_wp/material%eta
    material%kn_kt = material%k_n/material%k_t
    material%kc_kt = material%k_c/material%k_t
    material%s02_s01_2 = (inv_s01/inv_s02)**2
    material%s0 = 1.0_wp/max(inv_s01, inv_s02)
    material%tau_v = props(p_tau_v)
    material%guard = props(p_guard) > 0.0_wp
    material%height = props(p_height)
    material%wears = props(p_w0) > 0.0_wp
    material%inv_w0 = 0.0_wp
    if (material%wears) material%inv_w0 = 1.0_wp/props(p_w0)
    material%curved = material%height > 0.0_wp .or. material%wears
  end function new_material

  !> The constants for an increment of the duration dt: backward Euler step of tau_v alpha' = alpha_eq - alpha.
  !>
  !> alpha = (alpha_0 + r alpha_eq)/(1 + r) with r = dt/tau_v; alpha_eq is the damage (7) without history. If
  !> tau_v = 0 the constants do not change. With tau_v > 0 and dt = 0 no damage grows.
  pure function over_time(material, dt) result(timed)
    type(material_type), intent(in) :: material   !! constants
    real(wp), intent(in), optional :: dt          !! duration, >= 0, time; absent: 0
    type(material_type) :: timed
    timed = material
    if (.not. material%tau_v > 0.0_wp) return
    timed%take = 0.0_wp
    ! this form of r/(1 + r) cannot overflow
    if (present(dt)) timed%take = dt/(material%tau_v + dt)
    timed%keep = 1.0_wp - timed%take
    timed%take_eta = timed%take*material%take_eta
  end function over_time

end module asperity_material
