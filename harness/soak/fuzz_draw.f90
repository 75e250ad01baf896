!> Random input of the fuzz run: any bits, awkward numbers, admissible constants; the same for the same seed and case.
module fuzz_draw
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_contract, only: n_fixed_props, p_dalpha, p_eta, p_flat, p_gc, p_gc2, p_guard, p_h, p_kc, p_m, p_map, &
    p_mu, p_r, p_sigma0, p_sigma02, p_tau_v, p_theta, p_turn
  use asperity_kinds, only: wp
  implicit none
  private
  public :: stream_type, start, uniform, pick, chance, any_value, log_uniform, draw_props

  !> State of the generator.
  type :: stream_type
    private
    integer(int64) :: x = 1_int64
  end type stream_type

  !> Most constants that are drawn: 19 and eight listed planes.
  integer, parameter, public :: most_props = n_fixed_props + 8*4

contains

  !> Start the numbers of a case.
  subroutine start(stream, seed, number)
    type(stream_type), intent(out) :: stream   !! generator
    integer(int64), intent(in) :: seed         !! of the run, > 0
    integer(int64), intent(in) :: number       !! of the case, >= 0
    integer(int64) :: unused
    integer :: i
    stream%x = ieor(ieor(seed, ishft(number, 20)), int(z"2545F4914F6CDD1D", int64))
    if (stream%x == 0_int64) stream%x = seed
    do i = 1, 30
      call advance(stream, unused)
    end do
  end subroutine start

  !> Next 64 bits (xorshift, Marsaglia 2003: no product that could overflow).
  subroutine advance(stream, bits)
    type(stream_type), intent(inout) :: stream   !! generator
    integer(int64), intent(out) :: bits          !! any but 0
    stream%x = ieor(stream%x, ishft(stream%x, 13))
    stream%x = ieor(stream%x, ishft(stream%x, -7))
    stream%x = ieor(stream%x, ishft(stream%x, 17))
    bits = stream%x
  end subroutine advance

  !> A number from 0 to 1, 1 excluded.
  subroutine uniform(stream, x)
    type(stream_type), intent(inout) :: stream   !! generator
    real(wp), intent(out) :: x                   !! number
    integer(int64) :: bits
    call advance(stream, bits)
    x = real(ishft(bits, -11), wp)*0.5_wp**53
  end subroutine uniform

  !> A whole number from 1 to n.
  subroutine pick(stream, n, i)
    type(stream_type), intent(inout) :: stream   !! generator
    integer, intent(in) :: n                     !! >= 1
    integer, intent(out) :: i                    !! number
    real(wp) :: x
    call uniform(stream, x)
    i = min(n, 1 + int(real(n, wp)*x))
  end subroutine pick

  !> Yes with a probability.
  subroutine chance(stream, probability, yes)
    type(stream_type), intent(inout) :: stream   !! generator
    real(wp), intent(in) :: probability          !! 0..1
    logical, intent(out) :: yes                  !! outcome
    real(wp) :: x
    call uniform(stream, x)
    yes = x < probability
  end subroutine chance

  !> A power of ten with an exponent between two.
  subroutine log_uniform(stream, low, high, x)
    type(stream_type), intent(inout) :: stream   !! generator
    real(wp), intent(in) :: low, high            !! exponents
    real(wp), intent(out) :: x                   !! 10**low .. 10**high
    call uniform(stream, x)
    x = 10.0_wp**(low + (high - low)*x)
  end subroutine log_uniform

  !> Any value: random bits, an awkward number, or one of a size that occurs.
  subroutine any_value(stream, x)
    type(stream_type), intent(inout) :: stream   !! generator
    real(wp), intent(out) :: x                   !! any bits
    integer(int64), parameter :: quiet = int(z"7FF8000000000000", int64), &
      signalling = int(z"7FF4000000000000", int64), infinite = int(z"7FF0000000000000", int64), denormal = 1_int64
    integer(int64), parameter :: awkward(15) = [0_int64, quiet, signalling, infinite, denormal, &
      transfer(tiny(1.0_wp), 0_int64), transfer(huge(1.0_wp), 0_int64), transfer(1.0_wp, 0_int64), &
      transfer(epsilon(1.0_wp), 0_int64), transfer(1.0e50_wp, 0_int64), transfer(1.0e-50_wp, 0_int64), &
      transfer(1.0e10_wp, 0_int64), transfer(64.0_wp, 0_int64), transfer(90.0_wp, 0_int64), &
      transfer(nearest(1.0_wp, 2.0_wp), 0_int64)]
    integer(int64) :: bits
    integer :: kind, i
    call pick(stream, 3, kind)
    select case (kind)
    case (1)
      call advance(stream, bits)
    case (2)
      call pick(stream, size(awkward), i)
      bits = awkward(i)
    case default
      call log_uniform(stream, -20.0_wp, 20.0_wp, x)
      bits = transfer(x, 0_int64)
    end select
    call pick(stream, 2, i)
    if (i == 1) bits = ieor(bits, ishft(1_int64, 63))
    x = transfer(bits, 1.0_wp)
  end subroutine any_value

  !> Admissible PROPS, from the usual to the ends of the ranges.
  subroutine draw_props(stream, props, n)
    type(stream_type), intent(inout) :: stream   !! generator
    real(wp), intent(out) :: props(:)            !! (most_props) constants
    integer, intent(out) :: n                    !! how many
    integer, parameter :: sides(10) = [0, 2, 3, 4, 5, 6, 12, 32, 63, 64]
    real(wp) :: total
    logical :: far, yes
    integer :: i, j, k

    props = 0.0_wp
    n = n_fixed_props
    call chance(stream, 0.1_wp, far)
    call log_uniform(stream, merge(-50.0_wp, -3.0_wp, far), merge(50.0_wp, 3.0_wp, far), props(p_sigma0))
    call log_uniform(stream, merge(-50.0_wp, -4.0_wp, far), merge(50.0_wp, 3.0_wp, far), props(p_gc))
    call log_uniform(stream, merge(-15.0_wp, -3.0_wp, far), 0.0_wp, props(p_eta))
    props(p_eta) = min(max(1.0_wp - props(p_eta), 0.01_wp), nearest(1.0_wp, -1.0_wp))
    call uniform(stream, props(p_mu))
    if (far) call log_uniform(stream, -10.0_wp, 10.0_wp, props(p_mu))
    call uniform(stream, props(p_theta))
    props(p_theta) = 89.9_wp*props(p_theta)
    call pick(stream, size(sides), i)
    props(p_m) = real(sides(i), wp)
    props(p_flat) = 1.0_wp/3.0_wp
    call chance(stream, 0.3_wp, yes)
    if (yes) call uniform(stream, props(p_flat))
    call uniform(stream, props(p_turn))
    props(p_turn) = 1000.0_wp*(props(p_turn) - 0.5_wp)
    call log_uniform(stream, merge(-50.0_wp, -6.0_wp, far), merge(50.0_wp, 3.0_wp, far), props(p_h))
    call pick(stream, 2, i)
    props(p_map) = real(i - 1, wp)
    call chance(stream, 0.2_wp, yes)
    if (yes) props(p_sigma02) = 2.0_wp*props(p_sigma0)
    call chance(stream, 0.2_wp, yes)
    if (yes) props(p_gc2) = 0.3_wp*props(p_gc)
    ! 0, or within 1e-50 to 1e50
    where (props([p_sigma02, p_gc2]) > 0.0_wp) props([p_sigma02, p_gc2]) = &
      min(max(props([p_sigma02, p_gc2]), 1.0e-50_wp), 1.0e50_wp)
    call chance(stream, 0.3_wp, yes)
    if (yes) call log_uniform(stream, merge(-300.0_wp, -3.0_wp, far), merge(50.0_wp, 3.0_wp, far), props(p_tau_v))
    call chance(stream, 0.3_wp, yes)
    if (yes) call uniform(stream, props(p_dalpha))
    call chance(stream, 0.3_wp, yes)
    if (yes) call uniform(stream, props(p_r))
    call log_uniform(stream, merge(-10.0_wp, -2.0_wp, far), merge(9.9_wp, 4.0_wp, far), props(p_kc))
    call chance(stream, 0.5_wp, yes)
    if (yes) props(p_guard) = 1.0_wp
    call chance(stream, 0.15_wp, yes)
    if (.not. yes) return
    ! listed planes
    call pick(stream, 8, k)
    props(p_m) = -real(k, wp)
    n = n_fixed_props + 4*k
    total = 0.0_wp
    do i = 1, k
      j = n_fixed_props + 4*(i - 1)
      call log_uniform(stream, -3.0_wp, 3.0_wp, props(j + 1))
      call uniform(stream, props(j + 2))
      call uniform(stream, props(j + 3))
      props(j + 2:j + 3) = props(j + 2:j + 3) - 0.5_wp
      call uniform(stream, props(j + 4))
      props(j + 4) = 0.1_wp + props(j + 4)
      total = total + props(j + 4)
    end do
    props(n_fixed_props + 4:n:4) = props(n_fixed_props + 4:n:4)/total
  end subroutine draw_props

end module fuzz_draw
