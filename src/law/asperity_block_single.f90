!> The law for blocks of points in single precision.
module asperity_block_single
  use, intrinsic :: iso_fortran_env, only: real64, wp => real32
  use asperity_block_kernel_single, only: update_block
  use asperity_contact, only: stiffening
  use asperity_contract, only: status_ok, status_props
  use asperity_interface, only: interface_type
  use asperity_material, only: damage_share, double_material_type => material_type
  use asperity_pattern, only: pattern_type
  use asperity_types_single, only: block_type, chunk, growth_type, largest_energy, largest_separation, material_type, &
    plane_type, points_type, vector_type
  implicit none
  private
  public :: block_type, chunk, largest_energy, largest_separation, new_block, points_type, update_block

contains

  include "asperity_block.inc"

  !> Convert the interface to this kind; the status is status_props if a constant leaves the range of the kind.
  pure subroutine new_block(joint, block, status, dt)
    type(interface_type), intent(in) :: joint   !! material and pattern in double precision
    type(block_type), intent(out) :: block      !! the same in kind wp, defined if status is 0
    integer, intent(out) :: status              !! 0 or status_props
    real(real64), intent(in), optional :: dt    !! duration, >= 0 (used only if tau_v > 0), time; absent: 0
    status = status_props
    if (.not. in_range(joint, damage_share(joint%material, dt))) return
    status = status_ok
    call set_block(joint, material_of(joint%material), block, dt)
  end subroutine new_block

  !> Whether the constants, their squares and the energies at the largest separation stay within the range of the kind.
  !> The factor 1000 covers offsets, directions and the factors of the law.
  pure function in_range(joint, share) result(yes)
    type(interface_type), intent(in) :: joint   !! material and pattern in double precision
    real(real64), intent(in) :: share           !! damage_share
    logical :: yes
    real(real64) :: values(10), reach, stiffer
    yes = .false.
    associate (material => joint%material)
      values = [material%mu, material%mu*material%kc_kt, share*material%inv_eta, material%k_n, material%k_t, &
                material%k_c, material%inv_s01_2, material%inv_s02_2, material%kn_kt, material%kc_kt]
      reach = real(largest_separation, real64)*material%s0
      if (any(values > sqrt(real(huge(1.0_wp), real64)))) return
      if (any(values(4:) < sqrt(real(tiny(1.0_wp), real64)))) return
      stiffer = 1.0_real64
      if (material%inv_largest_closure > 0.0_real64) then
        ! the stiffness of a contact that is almost closed, and the share of the largest closure
        stiffer = stiffening(material, material%linear_from)
        if (stiffer*max(reach*material%inv_largest_closure, material%kc_kt) > sqrt(real(huge(1.0_wp), real64))) return
      end if
      if (1.0e3_real64*max(1.0_real64, material%mu)*maxval([values(4:5), stiffer*values(6)])*reach**2 > &
        real(huge(1.0_wp), real64)) return
      if (real(1.0_real64/material%inv_eta, wp) >= 1.0_wp) return
      if (material%curved) then
        if (material%inv_w0 > sqrt(real(huge(1.0_wp), real64))) return
        if (max(material%height, joint%pattern%steepest**2) > sqrt(real(huge(1.0_wp), real64))) return
        ! the curvature of the separation of a facet
        if (material%height > 0.0_real64 .and. 1.0e3_real64*joint%pattern%steepest**2*reach > &
          real(huge(1.0_wp), real64)*material%height**2) return
      end if
    end associate
    yes = .true.
  end function in_range

  !> Constants of the law in this kind. Those beyond its range are none of which a kernel makes use.
  pure function material_of(source) result(m)
    type(double_material_type), intent(in) :: source   !! the constants in double precision
    type(material_type) :: m
    real(real64), parameter :: double = 0.0_real64
    m%numbers_type = transfer(in_kind(transfer(source%numbers_type, [double])), m%numbers_type)
    m%guard = source%guard
    m%curved = source%curved
    m%bends = source%bends
    m%general = source%general
    m%wears = source%wears
  end function material_of

  !> A number >= 0 in this kind, at most its largest number.
  elemental function in_kind(x) result(y)
    real(real64), intent(in) :: x   !! the number
    real(wp) :: y
    y = real(min(x, real(huge(1.0_wp), real64)), wp)
  end function in_kind

end module asperity_block_single
