!> Random constants of the law: every row of PROPS that belongs to the law and has a default, in its plausible range.
module random_constants
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_case, only: case_type, write_case
  use asperity_contract, only: n_fixed_props, n_required_props, p_fc, p_gc, p_gfc, p_sigma0, prop_table
  use asperity_kinds, only: wp
  use random_numbers, only: chance, pick, uniform
  implicit none
  private
  public :: draw_constant, draw_constants, constants_text

contains

  !> Draw the constants that have a default, each with a probability; the others stay.
  subroutine draw_constants(seed, probability, props)
    integer(int64), intent(inout) :: seed         !! 1..largest_seed
    real(wp), intent(in) :: probability           !! 0..1
    real(wp), intent(inout) :: props(:)           !! (n_fixed_props) constants with sigma0 and Gc
    integer :: i
    do i = n_required_props + 1, n_fixed_props
      if (prop_table(i)%owner /= "law") cycle
      if (chance(seed, probability)) call draw_constant(seed, i, props)
    end do
    ! a compressive strength needs the energy of its softening
    if (props(p_fc) > 0.0_wp .and. .not. props(p_gfc) > 0.0_wp) call draw_constant(seed, p_gfc, props)
  end subroutine draw_constants

  !> Draw a constant in its plausible range, which is relative to sigma0, s_f and Gc. Stresses and energies lie within a
  !> factor of ten of sigma0 and Gc, as ratios beyond are not those of a joint. One in four of the constants that lie
  !> between 0 and 1 is the upper end of the admissible range.
  subroutine draw_constant(seed, i, props)
    integer(int64), intent(inout) :: seed    !! 1..largest_seed
    integer, intent(in) :: i                 !! of PROPS
    real(wp), intent(inout) :: props(:)      !! (n_fixed_props) constants with sigma0 and Gc; the constant is set
    real(wp), parameter :: factors(2) = [0.1_wp, 10.0_wp]
    real(wp) :: ends(2), fraction
    associate (row => prop_table(i), sigma0 => props(p_sigma0), gc => props(p_gc))
      fraction = uniform(seed)
      ends = row%plausible
      if (any(row%unit == [character(len=len(row%unit)) :: "stress", "stress*length"])) ends = &
        [max(ends(1), factors(1)), min(ends(2), factors(2))]
      select case (row%scale)
      case ("log")
        props(i) = ends(1)*(ends(2)/ends(1))**fraction
      case ("logit")
        props(i) = 1.0_wp/(1.0_wp + (1.0_wp/ends(1) - 1.0_wp)**(1.0_wp - fraction)*(1.0_wp/ends(2) - 1.0_wp)**fraction)
        if (chance(seed, 0.25_wp)) props(i) = row%upper
      case ("whole")
        props(i) = ends(1) + real(pick(seed, nint(ends(2) - ends(1)) + 1) - 1, wp)
      case default
        props(i) = ends(1) + fraction*(ends(2) - ends(1))
      end select
      if (row%unit == "stress") props(i) = sigma0*props(i)
      if (row%unit == "length") props(i) = 2.0_wp*gc/sigma0*props(i)
      if (row%unit == "stress*length") props(i) = gc*props(i)
    end associate
  end subroutine draw_constant

  !> Groups of a case file with the constants that differ from their defaults, in one line.
  function constants_text(props) result(text)
    real(wp), intent(in) :: props(:)   !! (n_fixed_props) constants
    character(len=:), allocatable :: text
    type(case_type) :: case
    integer :: i
    case%title = ""
    case%props = props
    allocate (case%steps(0))
    call write_case(case, text)
    do i = 1, len(text)
      if (text(i:i) == new_line("a")) text(i:i) = " "
    end do
  end function constants_text

end module random_constants
