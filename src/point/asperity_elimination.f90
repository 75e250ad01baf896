!> Small systems of linear equations.
module asperity_elimination
  use asperity_kinds, only: wp
  implicit none
  private
  public :: eliminate

contains

  !> Solve a x = b in place by Gaussian elimination with partial pivoting, in the order of LAPACK's dgesv.
  !>
  !> A system is not solved if a pivot is zero, or so small that x exceeds 1e150 or a product of x and a exceeds 1e300.
  !> The caller must judge the accuracy of x.
  pure subroutine eliminate(n, a, b, solved)
    integer, intent(in) :: n                              !! number of unknowns, >= 0
    real(wp), intent(inout), contiguous :: a(:, :)        !! matrix in the upper left n x n, finite -> destroyed
    real(wp), intent(inout), contiguous :: b(:)           !! right-hand side in the first n, finite -> x; undefined
                                                          !! if not solved
    logical, intent(out) :: solved                        !! whether there is such a solution
    !> Inverse of the largest x, and of the square root of its largest product with a.
    real(wp), parameter :: small = 2.0_wp**(-500)
    real(wp) :: factor, inverse, kept
    integer :: i, j, k, pivot

    solved = .true.
    do k = 1, n
      pivot = k
      do i = k + 1, n
        if (abs(a(i, k)) > abs(a(pivot, k))) pivot = i
      end do
      solved = abs(a(pivot, k)) >= tiny(small)
      if (.not. solved) return
      if (pivot /= k) then
        do j = k, n
          kept = a(k, j)
          a(k, j) = a(pivot, j)
          a(pivot, j) = kept
        end do
        kept = b(k)
        b(k) = b(pivot)
        b(pivot) = kept
      end if
      inverse = 1.0_wp/a(k, k)
      do i = k + 1, n
        factor = a(i, k)*inverse
        do j = k + 1, n
          a(i, j) = a(i, j) - factor*a(k, j)
        end do
        b(i) = b(i) - factor*b(k)
      end do
    end do
    do k = n, 1, -1
      do j = n, k + 1, -1
        solved = small*(abs(a(k, j))*(small*abs(b(j)))) < 1.0_wp
        if (.not. solved) return
        b(k) = b(k) - a(k, j)*b(j)
      end do
      solved = small*abs(b(k)) < abs(a(k, k))
      if (.not. solved) return
      b(k) = b(k)/a(k, k)
    end do
  end subroutine eliminate

end module asperity_elimination
