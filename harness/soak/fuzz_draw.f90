!> Random input of the fuzz run: any bits, awkward numbers, admissible constants; the same for the same seed and case.
module fuzz_draw
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_contract, only: n_fixed_props, n_listed_values, n_required_props, p_dalpha, p_eta, p_flat, &
    p_gc, p_gc2, p_h, p_kc, p_m, p_map, p_mu, p_r, p_sigma0, p_sigma02, p_theta, p_turn, prop_table
  use asperity_kinds, only: wp
  use random_numbers, only: chance, log_uniform, pick, random_bits, uniform
  implicit none
  private
  public :: any_value, draw_props

  !> Largest number of listed planes, and of drawn constants.
  integer, parameter :: most_listed = 8
  integer, parameter, public :: most_props = n_fixed_props + most_listed*n_listed_values

contains

  !> Any value: random bits, an awkward number, or one of a size that occurs.
  function any_value(stream) result(x)
    integer(int64), intent(inout) :: stream   !! 1..largest_seed
    real(wp) :: x
    integer(int64), parameter :: quiet = int(z"7FF8000000000000", int64), &
      signalling = int(z"7FF4000000000000", int64), infinite = int(z"7FF0000000000000", int64), denormal = 1_int64
    integer(int64), parameter :: awkward(15) = [0_int64, quiet, signalling, infinite, denormal, &
      transfer(tiny(1.0_wp), 0_int64), transfer(huge(1.0_wp), 0_int64), transfer(1.0_wp, 0_int64), &
      transfer(epsilon(1.0_wp), 0_int64), transfer(1.0e50_wp, 0_int64), transfer(1.0e-50_wp, 0_int64), &
      transfer(1.0e10_wp, 0_int64), transfer(64.0_wp, 0_int64), transfer(90.0_wp, 0_int64), &
      transfer(nearest(1.0_wp, 2.0_wp), 0_int64)]
    integer(int64) :: bits
    select case (pick(stream, 3))
    case (1)
      bits = random_bits(stream)
    case (2)
      bits = awkward(pick(stream, size(awkward)))
    case default
      x = log_uniform(stream, -20.0_wp, 20.0_wp)
      bits = transfer(x, 0_int64)
    end select
    if (pick(stream, 2) == 1) bits = ieor(bits, ishft(1_int64, 63))
    x = transfer(bits, 1.0_wp)
  end function any_value

  !> Admissible PROPS, from the usual to the ends of the ranges.
  subroutine draw_props(stream, props, n)
    integer(int64), intent(inout) :: stream   !! 1..largest_seed
    real(wp), intent(out) :: props(:)         !! (most_props) constants
    integer, intent(out) :: n                 !! how many
    integer, parameter :: sides(10) = [0, 2, 3, 4, 5, 6, 12, 32, 63, 64]
    real(wp) :: total
    logical :: far
    integer :: i, j, k

    props = 0.0_wp
    props(:n_fixed_props) = prop_table%default
    n = n_fixed_props
    far = chance(stream, 0.1_wp)
    do i = n_required_props + 1, n_fixed_props
      if (prop_table(i)%owner /= "law") cycle
      if (chance(stream, 0.3_wp)) call draw_prop(stream, i, far, props(i))
    end do
    props(p_sigma0) = log_uniform(stream, merge(-50.0_wp, -3.0_wp, far), merge(50.0_wp, 3.0_wp, far))
    props(p_gc) = log_uniform(stream, merge(-50.0_wp, -4.0_wp, far), merge(50.0_wp, 3.0_wp, far))
    props(p_eta) = 1.0_wp - log_uniform(stream, merge(-15.0_wp, -3.0_wp, far), 0.0_wp)
    props(p_eta) = min(max(props(p_eta), 0.01_wp), nearest(1.0_wp, -1.0_wp))
    props(p_mu) = uniform(stream)
    if (far) props(p_mu) = log_uniform(stream, -10.0_wp, 10.0_wp)
    props(p_theta) = 89.9_wp*uniform(stream)
    props(p_m) = real(sides(pick(stream, size(sides))), wp)
    props(p_flat) = 1.0_wp/3.0_wp
    if (chance(stream, 0.3_wp)) props(p_flat) = uniform(stream)
    props(p_turn) = 1000.0_wp*(uniform(stream) - 0.5_wp)
    props(p_h) = log_uniform(stream, merge(-50.0_wp, -6.0_wp, far), merge(50.0_wp, 3.0_wp, far))
    props(p_map) = real(pick(stream, 2) - 1, wp)
    ! the stiffnesses of a bond may not lie too far apart: those of mode II are 0, or within 1e-50 to 1e50
    props(p_sigma02) = merge(2.0_wp, 0.0_wp, chance(stream, 0.2_wp))*props(p_sigma0)
    props(p_gc2) = merge(0.3_wp, 0.0_wp, chance(stream, 0.2_wp))*props(p_gc)
    where (props([p_sigma02, p_gc2]) > 0.0_wp) props([p_sigma02, p_gc2]) = &
      min(max(props([p_sigma02, p_gc2]), 1.0e-50_wp), 1.0e50_wp)
    ! so may a length and s_f
    do i = 1, n_fixed_props
      if (prop_table(i)%measure /= "s_f" .or. .not. props(i) > 0.0_wp) cycle
      props(i) = log_uniform(stream, merge(-9.9_wp, -2.0_wp, far), merge(9.9_wp, 2.0_wp, far))* &
        (2.0_wp*props(p_gc)/props(p_sigma0))
      if (abs(log10(props(i))) > 50.0_wp) props(i) = 0.0_wp
    end do
    if (chance(stream, 0.3_wp)) props(p_dalpha) = uniform(stream)
    if (chance(stream, 0.3_wp)) props(p_r) = uniform(stream)
    props(p_kc) = log_uniform(stream, merge(-10.0_wp, -2.0_wp, far), merge(9.9_wp, 4.0_wp, far))
    if (.not. chance(stream, 0.15_wp)) return
    ! listed planes
    k = pick(stream, most_listed)
    props(p_m) = -real(k, wp)
    n = n_fixed_props + n_listed_values*k
    total = 0.0_wp
    do i = 1, k
      j = n_fixed_props + n_listed_values*(i - 1)
      props(j + 1) = log_uniform(stream, -3.0_wp, 3.0_wp)
      props(j + 2) = uniform(stream) - 0.5_wp
      props(j + 3) = uniform(stream) - 0.5_wp
      props(j + 4) = 0.1_wp + uniform(stream)
      total = total + props(j + 4)
    end do
    props(n_fixed_props + 4:n:n_listed_values) = props(n_fixed_props + 4:n:n_listed_values)/total
  end subroutine draw_props

  !> A value of a constant in its range. Integral constants and fractions may have any value, others one of usual size.
  subroutine draw_prop(stream, i, far, value)
    integer(int64), intent(inout) :: stream   !! 1..largest_seed
    integer, intent(in) :: i                  !! of PROPS
    logical, intent(in) :: far                !! whether to go to the ends of the range
    real(wp), intent(out) :: value            !! the constant
    real(wp) :: least
    associate (low => prop_table(i)%lower, high => prop_table(i)%upper)
      if (prop_table(i)%scale == "whole") then
        value = low + real(pick(stream, nint(high - low) + 1) - 1, wp)
      else if (high <= 1.0_wp) then
        value = low + (high - low)*uniform(stream)
      else
        least = -3.0_wp
        if (far) least = merge(-50.0_wp, -300.0_wp, prop_table(i)%divides)
        value = min(max(log_uniform(stream, least, merge(50.0_wp, 3.0_wp, far)), low), high)
      end if
    end associate
  end subroutine draw_prop

end module fuzz_draw
