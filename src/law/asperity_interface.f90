!> A rough interface: material and pattern of planes, and what its host asks of the library, from PROPS.
module asperity_interface
  use asperity_checks, only: read_props
  use asperity_contract, only: n_fixed_props, n_statev, p_dalpha, p_flat, p_h, p_m, p_map, p_r, p_theta, p_turn, &
    separation_limit, status_ok
  use asperity_kinds, only: wp
  use asperity_material, only: material_type, new_material
  use asperity_pattern, only: listed_pattern, pattern_type, regular_pattern
  implicit none
  private
  public :: interface_type, new_interface, separation_bound, slip_bound

  !> An interface as a host describes it by PROPS.
  type :: interface_type
    type(material_type) :: material   !! constants of the law
    type(pattern_type) :: pattern     !! frames and weights of the planes
    integer :: n_statev               !! state variables the law needs
    real(wp) :: h                     !! thickness the host divides by, length
    integer :: map                    !! order of the host's components, 0 or 1
    real(wp) :: r                     !! stiffness of the layer's other components as a share of K h
    real(wp) :: dalpha                !! growth of damage of a plane in an increment that asks for a cut, 0: never
  end type interface_type

  !> Largest slip and offset in a state as a multiple of the separation bound: slips follow separations, by up to
  !> sqrt(3) times the largest component.
  real(wp), parameter, public :: slip_factor = 4.0_wp

contains

  !> Interface from PROPS (contract; missing trailing values take their default).
  pure subroutine new_interface(props, joint, status)
    real(wp), intent(in), contiguous :: props(:)     !! PROPS, any number of values
    type(interface_type), intent(out) :: joint       !! defined if status is 0
    integer, intent(out) :: status                   !! 0, status_props or status_nprops
    real(wp) :: p(n_fixed_props)
    integer :: m

    call read_props(props, p, status)
    if (status /= status_ok) return
    joint%material = new_material(p)
    m = int(p(p_m))
    if (m < 0) then
      call listed_pattern(-m, props(n_fixed_props + 1:), joint%pattern)
    else
      call regular_pattern(m, p(p_theta), p(p_flat), p(p_turn), joint%pattern)
    end if
    joint%n_statev = n_statev(joint%pattern%n)
    joint%h = merge(p(p_h), 1.0_wp, p(p_h) > 0.0_wp)
    joint%map = int(p(p_map))
    joint%r = p(p_r)
    joint%dalpha = p(p_dalpha)
  end subroutine new_interface

  !> Largest separation the law takes, length: beyond it squares would leave the range of a double.
  pure function separation_bound(joint) result(bound)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: bound
    bound = separation_limit*joint%material%s0
  end function separation_bound

  !> Largest slip and offset in a state, length.
  pure function slip_bound(joint) result(bound)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: bound
    bound = slip_factor*separation_bound(joint)
  end function slip_bound

end module asperity_interface
