!> Utility routines of Abaqus/Standard for tensors, which UMATs call: the components are NDI direct ones and NSHR shears
!> (12, 13, 23); LSTR is 1 for stresses, 2 for strains with engineering shears.
module asperity_umat_utilities
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  implicit none
  private
  public :: sinv, sprinc, sprind, rotsig

  integer, parameter :: strains = 2
  !> Rows and columns of the shears.
  integer, parameter :: row(3) = [1, 1, 2], column(3) = [2, 3, 3]
  !> Rotations of Jacobi's method; it needs fewer than ten.
  integer, parameter :: most_rotations = 50

contains

  !> A third of the trace, and the equivalent stress of von Mises.
  subroutine sinv(stress, sinv1, sinv2, ndi, nshr) bind(c, name="sinv_")
    integer(c_int), intent(in) :: ndi, nshr              !! numbers of components
    real(c_double), intent(in) :: stress(ndi + nshr)     !! stress
    real(c_double), intent(out) :: sinv1, sinv2          !! stress
    real(c_double) :: t(3, 3)
    integer :: i
    t = tensor(stress, 1, int(ndi), int(nshr))
    sinv1 = (t(1, 1) + t(2, 2) + t(3, 3))/3.0_c_double
    do i = 1, 3
      t(i, i) = t(i, i) - sinv1
    end do
    sinv2 = sqrt(1.5_c_double*sum(t**2))
  end subroutine sinv

  !> Principal values.
  subroutine sprinc(s, ps, lstr, ndi, nshr) bind(c, name="sprinc_")
    integer(c_int), intent(in) :: lstr, ndi, nshr        !! kind, numbers of components
    real(c_double), intent(in) :: s(ndi + nshr)          !! components
    real(c_double), intent(out) :: ps(3)                 !! values, in no order
    real(c_double) :: an(3, 3)
    call sprind(s, ps, an, lstr, ndi, nshr)
  end subroutine sprinc

  !> Principal values and directions, by Jacobi's rotations.
  subroutine sprind(s, ps, an, lstr, ndi, nshr) bind(c, name="sprind_")
    integer(c_int), intent(in) :: lstr, ndi, nshr        !! kind, numbers of components
    real(c_double), intent(in) :: s(ndi + nshr)          !! components
    real(c_double), intent(out) :: ps(3)                 !! values, in no order
    real(c_double), intent(out) :: an(3, 3)              !! row k: direction of value k
    real(c_double) :: angle, rotation(3, 3), t(3, 3)
    integer :: i, k
    t = tensor(s, int(lstr), int(ndi), int(nshr))
    an = 0.0_c_double
    do i = 1, 3
      an(i, i) = 1.0_c_double
    end do
    do i = 1, most_rotations
      k = maxloc(abs([t(1, 2), t(1, 3), t(2, 3)]), 1)
      associate (p => row(k), q => column(k))
        if (abs(t(p, q)) <= epsilon(t)**2*maxval(abs(t))) exit
        angle = 0.5_c_double*atan2(2.0_c_double*t(p, q), t(p, p) - t(q, q))
        rotation = 0.0_c_double
        rotation(6 - p - q, 6 - p - q) = 1.0_c_double
        rotation(p, p) = cos(angle)
        rotation(q, q) = cos(angle)
        rotation(p, q) = sin(angle)
        rotation(q, p) = -sin(angle)
      end associate
      t = turned(t, rotation)
      an = matmul(rotation, an)
    end do
    ps = [t(1, 1), t(2, 2), t(3, 3)]
  end subroutine sprind

  !> Components in rotated axes: R s R^T.
  subroutine rotsig(s, r, rotated, lstr, ndi, nshr) bind(c, name="rotsig_")
    integer(c_int), intent(in) :: lstr, ndi, nshr            !! kind, numbers of components
    real(c_double), intent(in) :: s(ndi + nshr)              !! components
    real(c_double), intent(in) :: r(3, 3)                    !! rotation
    real(c_double), intent(out) :: rotated(ndi + nshr)       !! components
    real(c_double) :: t(3, 3)
    integer :: k
    t = turned(tensor(s, int(lstr), int(ndi), int(nshr)), r)
    rotated(:ndi) = [(t(k, k), k=1, ndi)]
    rotated(ndi + 1:) = [(t(row(k), column(k))*merge(2.0_c_double, 1.0_c_double, lstr == strains), k=1, nshr)]
  end subroutine rotsig

  !> R t R^T.
  pure function turned(t, r) result(there)
    real(c_double), intent(in) :: t(3, 3)     !! tensor
    real(c_double), intent(in) :: r(3, 3)     !! rotation
    real(c_double) :: back(3, 3), there(3, 3)
    back = transpose(r)
    there = matmul(t, back)
    there = matmul(r, there)
  end function turned

  !> Symmetric tensor of the components.
  pure function tensor(s, lstr, ndi, nshr) result(t)
    integer, intent(in) :: lstr, ndi, nshr      !! kind, numbers of components
    real(c_double), intent(in) :: s(:)          !! components
    real(c_double) :: t(3, 3)
    integer :: k
    t = 0.0_c_double
    do k = 1, ndi
      t(k, k) = s(k)
    end do
    do k = 1, nshr
      t(row(k), column(k)) = s(ndi + k)*merge(0.5_c_double, 1.0_c_double, lstr == strains)
      t(column(k), row(k)) = t(row(k), column(k))
    end do
  end function tensor

end module asperity_umat_utilities
