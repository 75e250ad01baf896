!> Material of one plane: the constants of the law derived from sigma0, Gc, eta, mu (paper, Section 2.2).
module asperity_material
  use asperity_contract, only: n_fixed_props, p_c, p_closure, p_crush, p_damage0, p_eta, p_gc, p_gc2, p_guard, &
    p_height, p_kc, p_mu, p_sigma0, p_sigma02, p_tau_v, p_w0
  use asperity_kinds, only: wp
  use asperity_types, only: material_type
  implicit none
  private
  public :: material_type, new_material, damage_weight, damping_lag, joint_constants, representable

  !> Share of the largest closure up to which the pressure is a hyperbola; beyond it goes on along its tangent.
  real(wp), parameter, public :: largest_closure_share = 0.99_wp

  !> Largest stress of the dashpot over that of the spring, for the same change in an increment: with more the closure
  !> would lose its digits.
  real(wp), parameter, public :: largest_lag = 1.0e10_wp

  !> Longest increment for the trapezoidal rule over the root of s_0 s_f.
  real(wp), parameter :: longest = 0.05_wp
  !> Separation at the onset of damage below which, and inverse of that above which no increment is long.
  real(wp), parameter :: least_onset = 1.0e-60_wp

  !> PROPS of a joint without bond, which kn and ks give. The values of mode II are those of mode I.
  integer, parameter, public :: joint_props(7) = [p_sigma0, p_gc, p_eta, p_kc, p_sigma02, p_gc2, p_damage0]
  !> Smallest stiffness of a joint without bond: its sigma0 and Gc are in their ranges.
  real(wp), parameter, public :: least_joint_stiffness = 1.0e-44_wp

contains

  !> These PROPS of a joint without bond, whose bond only gives the stiffness: K = ks, kc = kn/ks. The
  !> separation at the onset of the damage that the bond would have has no effect but on tolerances and steps.
  pure function joint_constants(kn, ks) result(constants)
    real(wp), intent(in) :: kn, ks   !! stiffness in closing and in shear, stress/length
    real(wp) :: constants(size(joint_props))
    real(wp), parameter :: onset = 1.0e-3_wp, eta = 0.5_wp
    constants = [ks*onset, ks*onset**2/(2.0_wp*(1.0_wp - eta)), eta, kn/ks, 0.0_wp, 0.0_wp, 1.0_wp]
  end function joint_constants

  !> Constants of the law from admissible PROPS: s_f = 2 Gc/sigma0, (5), (12); a mode II value of 0 is that of mode I.
  pure subroutine new_material(props, material)
    real(wp), intent(in) :: props(n_fixed_props)   !! PROPS before the listed planes, admissible
    type(material_type), intent(out) :: material   !! the constants
    real(wp) :: gc2, inv_s01, inv_s02, sigma02, slip

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
    material%inv_eta = 1.0_wp/material%eta
    material%kn_kt = material%k_n/material%k_t
    material%kc_kt = material%k_c/material%k_t
    material%s02_s01_2 = (inv_s01/inv_s02)**2
    material%s0 = 1.0_wp/max(inv_s01, inv_s02)
    material%tau_v = props(p_tau_v)
    material%guard = props(p_guard) > 0.0_wp
    material%unguarded = merge(0.0_wp, huge(1.0_wp), material%guard)
    material%height = props(p_height)
    material%inv_height = 0.0_wp
    material%foot = huge(1.0_wp)
    if (material%height > 0.0_wp) then
      material%inv_height = 1.0_wp/material%height
      material%foot = 0.0_wp
    end if
    material%wears = props(p_w0) > 0.0_wp .or. props(p_crush) > 0.0_wp
    material%inv_w0 = 0.0_wp
    if (props(p_w0) > 0.0_wp) material%inv_w0 = 1.0_wp/props(p_w0)
    material%kt_crush = 0.0_wp
    if (props(p_crush) > 0.0_wp) material%kt_crush = material%k_t/props(p_crush)
    material%curved = material%height > 0.0_wp .or. material%wears
    material%damage0 = props(p_damage0)
    material%inv_largest_closure = 0.0_wp
    material%linear_from = huge(1.0_wp)
    if (props(p_closure) > 0.0_wp) then
      material%inv_largest_closure = 1.0_wp/props(p_closure)
      material%linear_from = largest_closure_share*props(p_closure)
    end if
    material%hyperbolic = props(p_closure) > 0.0_wp
    material%damping = props(p_c)
    material%damps = material%damping > 0.0_wp
    ! an increment of this length misses the rupture by less than 0.2 % of Gc with the trapezoidal rule, as the error
    ! is (length/s_f)^2/(2 (1 - eta)); the phases take fourth powers of lengths
    material%inv_longest_2 = 0.0_wp
    slip = max(1.0_wp, material%mu)*max(1.0_wp, material%kc_kt)*material%s0/(1.0_wp - material%eta)
    if (material%s0 > least_onset .and. slip < 1.0_wp/least_onset) then
      material%inv_longest_2 = (1.0_wp - material%eta)/(longest*material%s0)**2
    end if
    material%general = material%curved .or. material%hyperbolic .or. material%damps
    material%by_points = .false.
    material%exact = .false.
  end subroutine new_material

  !> Whether a real kind represents the constants, their squares and the energies at the largest separation. The factor
  !> 1000 covers offsets, directions and the factors of the law.
  pure function representable(material, slope, largest_separation, range, dt) result(yes)
    type(material_type), intent(in) :: material   !! constants in double precision
    real(wp), intent(in) :: slope                 !! largest slope of a plane
    real(wp), intent(in) :: largest_separation    !! over s0
    real(wp), intent(in) :: range(2)              !! smallest and largest number of the kind
    real(wp), intent(in), optional :: dt          !! duration, >= 0, time; absent: 0
    logical :: yes
    real(wp), parameter :: factor = 1.0e3_wp
    real(wp) :: lag, most, reach, stiffer, values(12)
    yes = .false.
    most = sqrt(range(2))
    lag = damping_lag(material, dt)
    values = [material%mu, material%mu*material%kc_kt, damage_weight(material, dt)*material%inv_eta, lag, &
      lag*material%kc_kt, material%k_n, material%k_t, material%k_c, material%inv_s01_2, material%inv_s02_2, &
      material%kn_kt, material%kc_kt]
    reach = largest_separation*material%s0
    if (any(values > most) .or. any(values(6:) < sqrt(range(1)))) return
    stiffer = 1.0_wp + lag
    if (material%hyperbolic) then
      ! the stiffness of a contact that is almost closed, and the share of the largest closure
      stiffer = lag + 1.0_wp/(1.0_wp - largest_closure_share)**2
      if (stiffer*max(reach*material%inv_largest_closure, material%kc_kt) > most) return
    end if
    if (factor*max(1.0_wp, material%mu)*maxval([material%k_n, (1.0_wp + lag)*material%k_t, stiffer*material%k_c])* &
      reach**2 > range(2)) return
    if (material%curved) then
      if (max(material%inv_w0, material%kt_crush, material%height, slope**2) > most) return
      ! the square of the pressure over `crush`
      if (factor*stiffer*material%kc_kt*reach*material%kt_crush > most) return
      ! the curvature of the separation of a facet
      if (material%height > 0.0_wp .and. factor*slope**2*reach > range(2)*material%height**2) return
    end if
    yes = .true.
  end function representable

  !> Weight of the equilibrium damage in the new damage of an increment of duration dt: r/(1 + r) with r = dt/tau_v, by
  !> the backward Euler step of tau_v alpha' = alpha_eq - alpha; alpha_eq is the damage (7) without history.
  !>
  !> Without viscosity it is 1. With tau_v > 0 and dt = 0 no damage grows.
  pure function damage_weight(material, dt) result(weight)
    type(material_type), intent(in) :: material   !! constants
    real(wp), intent(in), optional :: dt          !! duration, >= 0, time; absent: 0
    real(wp) :: weight
    weight = merge(0.0_wp, 1.0_wp, material%tau_v > 0.0_wp)
    ! this form of r/(1 + r) cannot overflow
    if (present(dt) .and. material%tau_v > 0.0_wp) weight = dt/(material%tau_v + dt)
  end function damage_weight

  !> Stress of the dashpot of a contact over that of its spring, for the same change in an increment of duration dt:
  !> c/(K_c dt), at most largest_lag. It is 0 without a dashpot or a duration.
  pure function damping_lag(material, dt) result(lag)
    type(material_type), intent(in) :: material   !! constants
    real(wp), intent(in), optional :: dt          !! duration, >= 0, time; absent: 0
    real(wp) :: lag
    lag = 0.0_wp
    if (.not. material%damps .or. .not. present(dt)) return
    if (.not. dt > 0.0_wp) return
    ! k_c dt may leave the range of a double
    associate (stress => material%damping/max(dt, 1.0_wp), stiffness => material%k_c*min(dt, 1.0_wp))
      lag = largest_lag
      if (stress < largest_lag*stiffness) lag = stress/stiffness
    end associate
  end function damping_lag

end module asperity_material
