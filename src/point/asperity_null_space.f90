!> Null space of the equations of a branch, by the singular values of their matrix (LAPACK).
module asperity_null_space
  use asperity_kinds, only: wp
  implicit none
  private
  public :: null_space

  !> Three equations for four unknowns.
  type, public :: null_space_type
    real(wp) :: direction(4) = 0.0_wp   !! of length 1, which the equations do not see; on a surface the one with the
                                        !! largest load factor; zero where none has one, or nothing is held
    logical :: is_surface = .false.     !! whether they do not see others, too, but one of the free separations
    real(wp) :: second(4) = 0.0_wp      !! of length 1, which they see least otherwise; at a fork they do not see it;
                                        !! its largest component is positive
    real(wp) :: sense = 0.0_wp          !! 1 or -1: sign of the determinant of the equations with `direction` below
                                        !! them; 0: not known, as the equations nearly do not see `second`
  end type null_space_type

  !> Singular value over the largest one below which the sign of the determinant is that of rounding errors.
  real(wp), parameter :: singular = 1.0e-10_wp
  !> Components count as equally large within this part of them: their difference is that of rounding errors.
  real(wp), parameter :: alike = 1.0e-6_wp

  integer, parameter :: room = 64   ! numbers in which LAPACK works

  interface
    !> Singular values and vectors of a matrix (LAPACK, which is pure where its arguments are right).
    pure subroutine dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
      import :: wp
      implicit none
      character(len=1), intent(in) :: jobu, jobvt             !! "A": all vectors
      integer, intent(in) :: m, n, lda, ldu, ldvt, lwork      !! sizes
      real(wp), intent(inout) :: a(lda, *)                    !! matrix, destroyed
      real(wp), intent(out) :: s(*)                           !! singular values, descending
      real(wp), intent(out) :: u(ldu, *), vt(ldvt, *)         !! left vectors, rows of right vectors
      real(wp), intent(inout) :: work(*)                      !! room
      integer, intent(out) :: info                            !! 0: found
    end subroutine dgesvd
  end interface

contains

  !> Null space of a matrix, its direction in a sense.
  !>
  !> Along a branch the sign of the determinant changes where another branch crosses it, and not at a fold. A joint that
  !> nothing holds in a direction, as one without friction, has a surface of equilibria instead of a branch: the largest
  !> load factor for a move of length 1 is that without a move in this direction.
  pure function null_space(matrix, sense, n_free) result(space)
    real(wp), intent(in) :: matrix(3, 4)   !! finite, of the order of 1
    real(wp), intent(in) :: sense(4)       !! a direction
    integer, intent(in) :: n_free          !! free separations; the other equations see each a prescribed one
    type(null_space_type) :: space
    real(wp) :: a(3, 4), length, s(3), u(3, 3), vt(4, 4), work(room)
    integer :: info, largest, rank
    a = matrix
    work = 0.0_wp
    call dgesvd("A", "A", 3, 4, a, 3, s, u, 3, vt, 4, work, room, info)
    if (info /= 0) return
    rank = count(s > epsilon(s)*s(1))
    space%is_surface = rank < 3 .and. rank > 3 - n_free
    if (rank < 3 .and. .not. space%is_surface) return
    space%direction = vt(4, :)
    if (space%is_surface) space%direction = matmul(vt(rank + 1:, 4), vt(rank + 1:, :))
    length = norm2(space%direction)
    space%direction = merge(space%direction/max(length, singular), 0.0_wp, length > singular)
    if (.not. length > singular) return
    ! LAPACK leaves the sign to rounding errors, which differ from one instruction set to another
    largest = findloc(abs(vt(3, :)) >= (1.0_wp - alike)*maxval(abs(vt(3, :))), .true., 1)
    space%second = sign(1.0_wp, vt(3, largest))*vt(3, :)
    if (s(3) > singular*s(1)) space%sense = sign(1.0_wp, determinant_3(u)*determinant_4(vt))
    if (dot_product(space%direction, sense) < 0.0_wp) then
      space%direction = -space%direction
      space%sense = -space%sense
    end if
  end function null_space

  !> Determinant of a matrix of three rows.
  pure function determinant_3(a) result(d)
    real(wp), intent(in) :: a(3, 3)   !! the matrix
    real(wp) :: d
    d = a(1, 1)*(a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) - a(1, 2)*(a(2, 1)*a(3, 3) - a(2, 3)*a(3, 1)) + &
      a(1, 3)*(a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1))
  end function determinant_3

  !> Determinant of a matrix of four rows, along its first row.
  pure function determinant_4(a) result(d)
    real(wp), intent(in) :: a(4, 4)   !! the matrix
    real(wp) :: d
    d = a(1, 1)*determinant_3(a(2:, [2, 3, 4])) - a(1, 2)*determinant_3(a(2:, [1, 3, 4])) + &
      a(1, 3)*determinant_3(a(2:, [1, 2, 4])) - a(1, 4)*determinant_3(a(2:, [1, 2, 3]))
  end function determinant_4

end module asperity_null_space
