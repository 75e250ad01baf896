!> The law for blocks of points in single precision: the build makes the modules *_single of those of src/law.
module asperity_block_single
  use, intrinsic :: iso_fortran_env, only: real64, wp => real32
  use asperity_block_kernel_single, only: columns_bounded, update_block
  use asperity_block_setup_single, only: set_block
  use asperity_contract, only: status_ok, status_props
  use asperity_interface, only: interface_type
  use asperity_material, only: double_material_type => material_type, representable
  use asperity_types_single, only: block_type, chunk, largest_energy, largest_separation, material_type, points_type
  implicit none
  private
  public :: block_type, chunk, columns_bounded, largest_energy, largest_separation, new_block, points_type, update_block

contains

  !> Convert the interface to this kind; the status is status_props if a constant leaves the range of the kind.
  pure subroutine new_block(joint, block, status, dt)
    type(interface_type), intent(in) :: joint   !! material and pattern in double precision
    type(block_type), intent(out) :: block      !! the same in kind wp, defined if status is 0
    integer, intent(out) :: status              !! 0 or status_props
    real(real64), intent(in), optional :: dt    !! duration, >= 0 (used only if tau_v or c > 0), time; absent: 0
    real(real64), parameter :: small = 1.0e-8_real64, large = 1.0e3_real64
    status = status_props
    if (.not. representable(joint%material, joint%pattern%steepest, real(largest_separation, real64), &
      [real(tiny(1.0_wp), real64), real(huge(1.0_wp), real64)], dt)) return
    status = status_ok
    call set_block(joint, material_of(joint%material), block, dt)
    ! the phases of a long increment take fourth powers of lengths, of the onset of damage, and of the elastic slip with
    ! what a dashpot adds to it
    associate (m => joint%material)
      if (m%s0 < small .or. merge(10.0_real64, 1.0_real64, m%damps)*max(1.0_real64, m%mu)*max(1.0_real64, m%kc_kt)* &
        m%s0/(1.0_real64 - m%eta) > large) then
        block%material%inv_longest_2 = 0.0_wp
      end if
    end associate
  end subroutine new_block

  !> Constants of the law in this kind. Those beyond its range are none of which a kernel makes use.
  pure function material_of(source) result(m)
    type(double_material_type), intent(in) :: source   !! the constants in double precision
    type(material_type) :: m
    real(real64), parameter :: double = 0.0_real64
    m%numbers_type = transfer(in_kind(transfer(source%numbers_type, [double])), m%numbers_type)
    m%guard = source%guard
    m%curved = source%curved
    m%hyperbolic = source%hyperbolic
    m%general = source%general
    m%wears = source%wears
    m%damps = source%damps
    m%by_points = source%by_points
  end function material_of

  !> A number >= 0 in this kind, at most its largest number.
  elemental function in_kind(x) result(y)
    real(real64), intent(in) :: x   !! the number
    real(wp) :: y
    y = real(min(x, real(huge(1.0_wp), real64)), wp)
  end function in_kind

end module asperity_block_single
