!> Random numbers that are the same for the same seed with every compiler: the generator of Park and Miller (1988).
!>
!> The seed is the state of the generator; every draw changes it. Each statement draws only once, so that the order of
!> the draws does not depend on the compiler.
module random_numbers
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_kinds, only: wp
  implicit none
  private
  public :: seed_of, uniform, draw, pick, chance

  !> Largest seed; the product of a seed and the factor is within 64 bits.
  integer(int64), parameter :: modulus = 2147483647_int64
  integer(int64), parameter, public :: largest_seed = modulus - 1_int64

contains

  !> Seed of sequence `number` of a run; different numbers give different sequences.
  pure function seed_of(run, number) result(seed)
    integer(int64), intent(in) :: run      !! seed of the run, any
    integer(int64), intent(in) :: number   !! of the sequence, any
    integer(int64) :: seed
    integer(int64), parameter :: factors(2) = [48271_int64, 69621_int64]
    seed = modulo(factors(1)*modulo(run, modulus) + factors(2)*modulo(number, modulus), modulus)
    if (seed == 0_int64) seed = 1_int64
  end function seed_of

  !> A number from 0 to 1, 1 excluded.
  function uniform(seed) result(x)
    integer(int64), intent(inout) :: seed   !! 1..largest_seed
    real(wp) :: x
    call advance(seed)
    x = real(seed - 1_int64, wp)/real(modulus - 1_int64, wp)
  end function uniform

  !> Fill x with numbers from -1 to 1.
  subroutine draw(seed, x)
    integer(int64), intent(inout) :: seed   !! 1..largest_seed
    real(wp), intent(out) :: x(:)           !! random numbers
    integer :: i
    do i = 1, size(x)
      x(i) = 2.0_wp*uniform(seed) - 1.0_wp
    end do
  end subroutine draw

  !> An integer from 1 to n.
  function pick(seed, n) result(i)
    integer(int64), intent(inout) :: seed   !! 1..largest_seed
    integer, intent(in) :: n                !! >= 1
    integer :: i
    i = min(n, 1 + int(real(n, wp)*uniform(seed)))
  end function pick

  !> True with a given probability.
  function chance(seed, probability) result(yes)
    integer(int64), intent(inout) :: seed   !! 1..largest_seed
    real(wp), intent(in) :: probability     !! 0..1
    logical :: yes
    yes = uniform(seed) < probability
  end function chance

  !> The next seed.
  subroutine advance(seed)
    integer(int64), intent(inout) :: seed   !! 1..largest_seed
    seed = modulo(16807_int64*seed, modulus)
  end subroutine advance

end module random_numbers
