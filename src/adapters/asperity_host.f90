!> Procedures of all host adapters: component orders and requests for a smaller increment.
module asperity_host
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_checks, only: bounded
  use asperity_interface, only: interface_type, plane_damage
  use asperity_kinds, only: wp
  use asperity_text, only: append, integer_text, to_text
  implicit none
  private
  public :: component_map, vumat_map, request_cut, request_slower_damage, water_pressure, explain_water, &
    pressure_at_end

  !> Increment factor requested when a call is rejected.
  real(wp), parameter, public :: rejected_pnewdt = 0.25_wp
  !> Increment factors requested where damage grows too fast. The first is the smallest factor of one cut. The second is
  !> a safety factor, as the growth of damage need not be proportional to the increment.
  real(wp), parameter, public :: least_pnewdt = 0.1_wp, largest_pnewdt = 0.75_wp
  !> NaN from its bits, which raises no floating-point exception.
  real(wp), parameter, public :: quiet_nan = transfer(int(z"7FF8000000000000", int64), 1.0_wp)

contains

  !> Positions of (N, Tx, Ty) among the host's NTENS components; 0: the host has no such component.
  pure function component_map(ntens, map) result(position)
    integer, intent(in) :: ntens   !! 2, 3 or 6
    integer, intent(in) :: map     !! PROPS 10
    integer :: position(3)         !! all 0 if ntens is none of these
    select case (ntens)
    case (2)
      position = [1, 2, 0]
    case (3)
      position = [1, 2, 3]
    case (6)
      position = [3, merge(5, 6, map == 0), merge(6, 5, map == 0)]
    case default
      position = 0
    end select
  end function component_map

  !> Positions of (N, Tx, Ty) in Abaqus/Explicit's cohesive elements; 0: there is no such component.
  pure function vumat_map(ndir, nshr) result(position)
    integer, intent(in) :: ndir   !! direct components: 1
    integer, intent(in) :: nshr   !! shear components: 1 or 2
    integer :: position(3)        !! all 0 for any other element
    position = 0
    if (ndir == 1 .and. nshr == 1) position = [1, 2, 0]
    if (ndir == 1 .and. nshr == 2) position = [1, 3, 2]
  end function vumat_map

  !> Water pressure in a joint, from the predefined fields of a host; NaN if the host passes none.
  pure function water_pressure(joint, predef, dpred) result(p)
    type(interface_type), intent(in) :: joint      !! the interface
    real(wp), intent(in), optional :: predef(joint%water)   !! predefined fields at the start, any bits
    real(wp), intent(in), optional :: dpred(joint%water) !! their increments; absent: zero
    real(wp) :: p                                  !! stress, 0 without water
    p = 0.0_wp
    if (joint%water == 0) return
    p = quiet_nan
    if (.not. present(predef)) return
    p = predef(joint%water)
    if (.not. present(dpred)) return
    p = pressure_at_end(p, dpred(joint%water))
  end function water_pressure

  !> Water pressure at the end of an increment; NaN unless start and increment are finite.
  pure function pressure_at_end(start, increment) result(p)
    real(wp), intent(in) :: start       !! stress, any bits
    real(wp), intent(in) :: increment   !! stress, any bits
    real(wp) :: p                       !! stress
    p = quiet_nan
    if (.not. (bounded(start, huge(p)) .and. bounded(increment, huge(p)))) return
    p = start + increment
    ! a pressure that ends, but for the rounding of the sum
    if (abs(p) <= epsilon(p)*start) p = 0.0_wp
  end function pressure_at_end

  !> Append why a water pressure is not admissible.
  pure subroutine explain_water(joint, name, p, message)
    type(interface_type), intent(in) :: joint                 !! the interface
    character(len=*), intent(in) :: name                      !! of the fields, as the host calls them
    real(wp), intent(in) :: p                                 !! what the host passed; NaN: nothing finite
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended
    call append(message, name // "(" // integer_text(joint%water) // ") = " // to_text(p) // &
      ": expected the water pressure in the joint, finite and >= 0, as PROPS(23) = " // integer_text(joint%water))
  end subroutine explain_water

  !> Request a smaller increment from the host: PNEWDT may arrive as 1 (Abaqus), -1 (CalculiX) or absent (Kratos).
  pure subroutine request_cut(factor, pnewdt)
    real(wp), intent(in) :: factor                !! requested factor, < 1
    real(wp), intent(inout), optional :: pnewdt   !! the host's increment factor
    if (.not. present(pnewdt)) return
    pnewdt = merge(min(pnewdt, factor), factor, pnewdt > 0.0_wp)
  end subroutine request_cut

  !> Request a smaller increment from the host if the damage of a plane grew by more than PROPS 14.
  pure subroutine request_slower_damage(joint, old, new, pnewdt)
    type(interface_type), intent(in) :: joint               !! the interface
    real(wp), intent(in) :: old(:)                          !! (Np) damage of the planes at the start
    real(wp), intent(in), contiguous :: new(:)              !! STATEV at the end
    real(wp), intent(inout), optional :: pnewdt             !! the host's increment factor
    real(wp) :: growth
    growth = maxval(plane_damage(joint, new) - old)
    if (growth > joint%dalpha) then
      call request_cut(max(least_pnewdt, min(largest_pnewdt, joint%dalpha/growth)), pnewdt)
    end if
  end subroutine request_slower_damage

end module asperity_host
