!> Stability of a joint, from the eigenvalues of its tangent (LAPACK).
!>
!> The symmetric part of the tangent tells the work of second order, ds . D ds (Hill): where its smallest eigenvalue is
!> negative, a joint that nothing holds may go in the direction of the eigenvector. Friction makes the tangent
!> unsymmetric: eigenvalues of the tangent itself with a negative real part are a divergence, complex ones can flutter.
module asperity_stability
  use asperity_kinds, only: wp
  implicit none
  private
  public :: stability_of, falling_direction

  !> Columns: smallest eigenvalue of the symmetric part, smallest real and largest imaginary part of the eigenvalues of
  !> the tangent, all over the stiffness of the bond; unit vector of the first.
  character(len=*), parameter, public :: stability_columns(6) = [character(len=12) :: "second_order", "least_real", &
    "flutter", "mode_N", "mode_Tx", "mode_Ty"]

  integer, parameter :: room = 64   ! numbers in which LAPACK works, for three equations

  interface
    !> Eigenvalues, ascending, and vectors of a symmetric matrix (LAPACK, which is pure where its arguments are right).
    pure subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      import :: wp
      implicit none
      character(len=1), intent(in) :: jobz, uplo       !! "V": vectors; "U": of the upper triangle
      integer, intent(in) :: n, lda, lwork             !! sizes
      real(wp), intent(inout) :: a(lda, *)             !! matrix -> vectors
      real(wp), intent(out) :: w(*)                    !! eigenvalues
      real(wp), intent(inout) :: work(*)               !! room
      integer, intent(out) :: info                     !! 0: found
    end subroutine dsyev

    !> Eigenvalues and right vectors of a matrix (LAPACK, which is pure where its arguments are right).
    pure subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
      import :: wp
      implicit none
      character(len=1), intent(in) :: jobvl, jobvr     !! "N", "V": right vectors
      integer, intent(in) :: n, lda, ldvl, ldvr, lwork !! sizes
      real(wp), intent(inout) :: a(lda, *)             !! matrix, destroyed
      real(wp), intent(out) :: wr(*), wi(*)            !! real and imaginary parts
      real(wp), intent(inout) :: vl(ldvl, *)           !! not used
      real(wp), intent(inout) :: vr(ldvr, *)           !! vectors
      real(wp), intent(inout) :: work(*)               !! room
      integer, intent(out) :: info                     !! 0: found
    end subroutine dgeev
  end interface

contains

  !> Numbers of the columns for a tangent, which must be finite. The largest component of the vector is positive. What
  !> LAPACK does not find is `huge`.
  pure function stability_of(tangent, stiffness) result(numbers)
    real(wp), intent(in) :: tangent(3, 3)   !! d traction_i/d s_j, stress/length
    real(wp), intent(in) :: stiffness       !! of the bond, > 0, stress/length
    real(wp) :: numbers(size(stability_columns))
    real(wp) :: a(3, 3), imaginary(3), real_part(3), least(3), none(1, 1), no_vector(1, 1), work(room)
    integer :: info
    work = 0.0_wp
    none = 0.0_wp
    no_vector = 0.0_wp
    a = 0.5_wp*(tangent + transpose(tangent))/stiffness
    call dsyev("V", "U", 3, a, 3, least, work, room, info)
    associate (vector => a(:, 1))
      numbers(4:) = sign(1.0_wp, vector(maxloc(abs(vector), 1)))*vector
    end associate
    numbers(1) = least(1)
    if (info /= 0) numbers = huge(numbers)
    a = tangent/stiffness
    call dgeev("N", "N", 3, a, 3, real_part, imaginary, none, 1, no_vector, 1, work, room, info)
    numbers(2:3) = [minval(real_part), maxval(imaginary)]
    if (info /= 0) numbers(2:3) = huge(numbers)
  end function stability_of

  !> Unit vector in which free separations leave an equilibrium that is no longer stable, in the sense of what is not
  !> balanced: the eigenvector of the eigenvalue with the smallest real part; 0 if nothing is free.
  pure function falling_direction(tangent, free, spring, unbalanced) result(direction)
    real(wp), intent(in) :: tangent(3, 3)     !! at the last equilibrium, stress/length
    logical, intent(in) :: free(3)            !! components whose traction is prescribed
    real(wp), intent(in) :: spring(3)         !! stiffness beside the joint, stress/length
    real(wp), intent(in) :: unbalanced(3)     !! traction that is asked for beyond the last equilibrium, stress
    real(wp) :: direction(3)
    real(wp) :: a(3, 3), imaginary(3), none(1, 1), real_part(3), vectors(3, 3), work(room)
    integer :: at(3), i, info, n
    direction = 0.0_wp
    n = count(free)
    if (n == 0) return
    at(:n) = pack([1, 2, 3], free)
    a(:n, :n) = tangent(at(:n), at(:n))
    do i = 1, n
      a(i, i) = a(i, i) + spring(at(i))
    end do
    work = 0.0_wp
    none = 0.0_wp
    vectors = 0.0_wp
    call dgeev("N", "V", n, a, 3, real_part, imaginary, none, 1, vectors, 3, work, room, info)
    if (info /= 0) return
    direction(at(:n)) = vectors(:n, minloc(real_part(:n), 1))
    direction = direction/max(norm2(direction), tiny(1.0_wp))
    if (dot_product(direction, merge(unbalanced, 0.0_wp, free)) < 0.0_wp) direction = -direction
  end function falling_direction

end module asperity_stability
