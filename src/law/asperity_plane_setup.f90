!> What the law of a plane needs from material and pattern.
module asperity_plane_setup
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_kinds, only: wp
  use asperity_material, only: damage_weight, damping_lag, double_material_type => material_type
  use asperity_pattern, only: pattern_type
  use asperity_types, only: growth_type, plane_type, vector_type
  implicit none
  private
  public :: growth_of, plane_of

contains

  !> Growth of the damage in an increment of duration dt (absent: 0) that no guard limits, and what the dashpot adds to
  !> the stiffness. An increment without duration has no rate, and the dashpot does not act.
  pure function growth_of(material, dt) result(growth)
    type(double_material_type), intent(in) :: material   !! constants of the law
    real(real64), intent(in), optional :: dt             !! duration, >= 0, time
    type(growth_type) :: growth
    real(real64) :: weight
    weight = damage_weight(material, dt)
    growth%weight_new = real(weight, wp)
    growth%weight_old = merge(1.0_wp - growth%weight_new, 0.0_wp, material%tau_v > 0.0_real64)
    growth%weight_eta = real(weight*material%inv_eta, wp)
    growth%limit = growth%weight_new
    growth%lag = real(damping_lag(material, dt), wp)
  end function growth_of

  !> Axes (1) and weight of plane k of a pattern.
  pure function plane_of(pattern, k) result(plane)
    type(pattern_type), intent(in) :: pattern   !! frames and weights
    integer, value :: k                         !! plane
    type(plane_type) :: plane
    plane%n = vector_type(real(pattern%cos_theta(k), wp), real(-(pattern%sin_theta(k)*pattern%e_x(k)), wp), &
      real(-(pattern%sin_theta(k)*pattern%e_y(k)), wp))
    plane%t = vector_type(real(pattern%sin_theta(k), wp), real(pattern%cos_theta(k)*pattern%e_x(k), wp), &
      real(pattern%cos_theta(k)*pattern%e_y(k), wp))
    plane%h = vector_type(0.0_wp, real(pattern%e_y(k), wp), real(pattern%h_y(k), wp))
    plane%gamma = real(pattern%gamma(k), wp)
    plane%e_x = real(pattern%e_x(k), wp)
    plane%e_y = real(pattern%e_y(k), wp)
    plane%slope = real(pattern%slope(k), wp)
    plane%inv_slope = 1.0_wp/max(plane%slope, tiny(1.0_wp))
  end function plane_of

end module asperity_plane_setup
