!> A rough interface from PROPS: material, pattern of planes and the options of the host.
module asperity_interface
  use asperity_cap, only: cap_type, new_cap
  use asperity_checks, only: read_props
  use asperity_contract, only: n_fixed_props, n_implex_statev, n_statev, p_dalpha, p_flat, p_h, p_implex, p_m, p_map, &
    p_r, p_theta, p_turn, p_water, plane_statev, separation_limit, status_ok
  use asperity_kinds, only: wp
  use asperity_material, only: material_type, new_material
  use asperity_pattern, only: listed_pattern, pattern_type, regular_pattern
  implicit none
  private
  public :: interface_type, new_interface, separation_bound, slip_bound, start_damage, plane_damage

  !> Values of PROPS and what is derived from them.
  type :: interface_type
    type(material_type) :: material   !! constants of the law
    type(pattern_type) :: pattern     !! frames and weights of the planes
    type(cap_type) :: cap             !! compressive strength of the joint, in series with the law
    integer :: n_statev               !! state variables the law needs
    integer :: n_umat_statev          !! state variables a UMAT needs: with IMPL-EX more than the law
    real(wp) :: h                     !! thickness by which the host divides separations, length
    integer :: map                    !! order of the host's components, 0 or 1
    integer :: water                  !! predefined field of the host that is the water pressure, 0: none
    real(wp) :: r                     !! stiffness of the other components, as a fraction of K h
    real(wp) :: dalpha                !! largest growth of damage in an increment (PNEWDT), 0: no limit
    real(wp) :: implex                !! error of damage that IMPL-EX allows (UMAT), 0: implicit
  end type interface_type

  !> Largest slip and offset in a state, as a multiple of the separation bound. The slip of a plane may exceed the
  !> largest component of the separation by the factor sqrt(3).
  real(wp), parameter, public :: slip_factor = 4.0_wp

contains

  !> Interface from PROPS (contract; missing trailing values take their default).
  pure subroutine new_interface(props, joint, status)
    real(wp), intent(in), contiguous :: props(:)     !! PROPS, any number of values
    type(interface_type), intent(out) :: joint       !! defined if status is 0
    integer, intent(out) :: status                   !! 0, status_props or status_nprops
    real(wp) :: p(n_fixed_props)
    integer :: m

    call read_props(size(props), props, p, status)
    if (status /= status_ok) return
    call new_material(p, joint%material)
    m = int(p(p_m))
    if (m < 0) then
      call listed_pattern(-m, props(n_fixed_props + 1:), joint%pattern)
    else
      call regular_pattern(m, p(p_theta), p(p_flat), p(p_turn), joint%pattern)
    end if
    joint%cap = new_cap(p)
    joint%n_statev = n_statev(joint%pattern%n, joint%material%wears, joint%cap%peak > 0.0_wp)
    joint%h = merge(p(p_h), 1.0_wp, p(p_h) > 0.0_wp)
    joint%map = int(p(p_map))
    joint%water = int(p(p_water))
    joint%r = p(p_r)
    joint%dalpha = p(p_dalpha)
    joint%implex = p(p_implex)
    joint%n_umat_statev = joint%n_statev
    if (joint%implex > 0.0_wp) joint%n_umat_statev = joint%n_statev + n_implex_statev(joint%pattern%n)
  end subroutine new_interface

  !> Damage of a plane at the start of an update: no plane has less than damage0.
  elemental function start_damage(joint, alpha) result(start)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: alpha               !! damage in STATEV
    real(wp) :: start
    start = max(alpha, joint%material%damage0)
  end function start_damage

  !> Damage of the planes at the start of an update.
  pure function plane_damage(joint, state) result(alpha)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: state(:)            !! STATEV
    real(wp) :: alpha(joint%pattern%n)
    integer :: k
    alpha = start_damage(joint, state([(plane_statev(k), k=1, joint%pattern%n)]))
  end function plane_damage

  !> Largest admissible separation, length; the square of a larger one would leave the range of a double.
  pure function separation_bound(joint) result(bound)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: bound
    bound = separation_limit*joint%material%s0
  end function separation_bound

  !> Largest admissible slip and offset in a state, length.
  pure function slip_bound(joint) result(bound)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: bound
    bound = slip_factor*separation_bound(joint)
  end function slip_bound

end module asperity_interface
