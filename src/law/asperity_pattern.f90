!> Patterns of planes (RIE): normals, frames (1) and weights of the regular family (41)-(43) and of listed planes.
module asperity_pattern
  use asperity_kinds, only: wp
  use asperity_contract, only: max_inclined, max_planes, min_inclined, n_listed_values
  implicit none
  private
  public :: pattern_type, regular_pattern, listed_pattern, plane_axes, plane_normal, direction_vector

  !> Multiple of the vectors of every instruction set, doubles.
  integer, parameter :: vector_width = 4
  !> Length of the arrays over the planes: a whole number of vectors. Spare places hold planes with weight zero.
  integer, parameter, public :: padded_planes = ((max_planes + vector_width - 1)/vector_width)*vector_width

  !> Frames and weights of the planes: with the up-slope direction (e_x, e_y) in the average surface,
  !> n = (cos, -sin e_x, -sin e_y), t = (sin, cos e_x, cos e_y), h = (0, e_y, h_y), components (N, Tx, Ty).
  type :: pattern_type
    integer :: n                          !! number of planes Np
    real(wp) :: cos_theta(padded_planes)      !! n_N
    real(wp) :: sin_theta(padded_planes)      !! t_N
    real(wp) :: e_x(padded_planes)            !! up-slope direction
    real(wp) :: e_y(padded_planes)            !! up-slope direction
    real(wp) :: h_y(padded_planes)            !! h: -e_x, or 1 in the average surface
    real(wp) :: gamma(padded_planes)          !! weights, sum 1, zero in the spare places
    real(wp) :: slope(padded_planes)          !! tan(theta), at most `vertical`
    real(wp) :: steepest                  !! largest slope
  end type pattern_type

  real(wp), parameter :: pi = acos(-1.0_wp), degree = pi/180.0_wp
  !> Largest slope of a facet, so that its powers stay in the range of a double. A steeper listed plane is vertical
  !> except for rounding.
  real(wp), parameter :: vertical = 1.0e12_wp

contains

  !> Regular pattern: flat plane first, then m planes inclined by theta (41)-(43); the pattern is rotated about N.
  pure subroutine regular_pattern(m, theta, flat, turn, pattern)
    integer, intent(in) :: m                      !! inclined planes, 0 or 2..64
    real(wp), intent(in) :: theta                 !! inclination, degrees, 0 <= theta < 90
    real(wp), intent(in) :: flat                  !! weight of the flat plane, 0..1
    real(wp), intent(in) :: turn                  !! rotation about N, degrees
    type(pattern_type), intent(out) :: pattern    !! frames and weights
    ! Tables of cos and sin of the azimuths 2 pi j/i of i inclined planes, for i = 2..64 one after the other. Each set
    ! begins with the direction (1, 0) of the flat plane; spare places follow the last set. The compiler computes the
    ! tables, so that a call evaluates no sine per plane. Angles are reduced to a quarter of the circle in units of
    ! 2 pi/(4 i), so that mirrored planes are mirror images to the last bit and planes along the axes are exact.
    integer :: i, j
    integer, parameter :: n_azimuths = (max_inclined + 1)*(max_inclined + 2)/2 - 3
    real(wp), parameter :: azimuth_cos(n_azimuths + vector_width) = [((sin(pi*real(i - 4*min(max(j, 0), &
      i - max(j, 0)), wp)/real(2*i, wp)), j=-1, i - 1), i=min_inclined, max_inclined), (1.0_wp, j=1, vector_width)]
    real(wp), parameter :: azimuth_sin(n_azimuths + vector_width) = [((sin(pi*real(merge(min(4*max(j, 0), &
      2*i - 4*max(j, 0)), -min(4*max(j, 0) - 2*i, 4*i - 4*max(j, 0)), 4*j <= 2*i), wp)/real(2*i, wp)), &
      j=-1, i - 1), i=min_inclined, max_inclined), (0.0_wp, j=1, vector_width)]
    real(wp) :: c, s, rotation(2), slope, weight
    integer :: first, k, padded, start

    c = cos(theta*degree)
    s = sin(theta*degree)
    first = merge(1, 0, m == 0 .or. flat > 0.0_wp)
    pattern%n = first + merge(0, m, flat >= 1.0_wp)
    padded = ((pattern%n + vector_width - 1)/vector_width)*vector_width
    slope = merge(min(s/c, vertical), 0.0_wp, pattern%n > first)
    pattern%steepest = slope
    weight = (1.0_wp - flat)/real(max(m, 1), wp)
    rotation = [1.0_wp, 0.0_wp]
    if (abs(turn) > 0.0_wp) rotation = direction_vector(turn)
    start = m*(m + 1)/2 - 3 + 1 - first   ! offset of the set of m, with or without its flat plane
    if (m == 0) start = 0
    ! one vector loop without conditions; the planes that are not inclined take their values after it
    !$omp simd
    do k = 1, padded
      pattern%cos_theta(k) = c
      pattern%sin_theta(k) = s
      pattern%slope(k) = slope
      pattern%e_x(k) = azimuth_cos(start + k)*rotation(1) - azimuth_sin(start + k)*rotation(2)
      pattern%e_y(k) = azimuth_cos(start + k)*rotation(2) + azimuth_sin(start + k)*rotation(1)
      pattern%h_y(k) = azimuth_sin(start + k)*rotation(2) - azimuth_cos(start + k)*rotation(1)
      pattern%gamma(k) = weight
    end do
    ! without a turn the products are exact
    if (abs(turn) > 0.0_wp) then
      pattern%e_x(:padded) = axial(pattern%e_x(:padded))
      pattern%e_y(:padded) = axial(pattern%e_y(:padded))
      pattern%h_y(:padded) = axial(pattern%h_y(:padded))
    end if
    do k = 1, vector_width - 1
      pattern%gamma(pattern%n + k) = 0.0_wp
    end do
    if (first == 1) then
      call set_flat(pattern, 1)
      pattern%gamma(1) = merge(flat, 1.0_wp, m > 0)
    end if
    if (slope > 0.0_wp) return
    do k = 1, padded
      call set_flat(pattern, k)
    end do
  end subroutine regular_pattern

  !> Pattern of listed planes in the order given.
  pure subroutine listed_pattern(n_listed, values, pattern)
    integer, intent(in) :: n_listed               !! number of planes, 1..64
    real(wp), intent(in) :: values(:)             !! n_N > 0, n_Tx, n_Ty (of any length) and weight, plane by plane
    type(pattern_type), intent(out) :: pattern    !! frames and weights
    real(wp) :: n(3), s
    integer :: i, k

    pattern%n = n_listed
    do k = 1, n_listed
      i = n_listed_values*(k - 1)
      n = values(i + 1:i + 3)
      n = n/maxval(abs(n))
      n = n/sqrt(sum(n**2))
      s = sqrt(n(2)**2 + n(3)**2)
      call set_flat(pattern, k)
      pattern%gamma(k) = values(i + 4)
      if (s > 0.0_wp) then
        pattern%cos_theta(k) = n(1)
        pattern%sin_theta(k) = s
        pattern%slope(k) = min(s/max(n(1), s/vertical), vertical)
        pattern%e_x(k) = -n(2)/s
        pattern%e_y(k) = -n(3)/s
        pattern%h_y(k) = -pattern%e_x(k)
      end if
    end do
    pattern%steepest = maxval(pattern%slope(:n_listed))
    do k = n_listed + 1, ((n_listed + vector_width - 1)/vector_width)*vector_width
      call set_flat(pattern, k)
      pattern%gamma(k) = 0.0_wp
    end do
  end subroutine listed_pattern

  !> Plane parallel to the average surface: n = N, t = Tx, h = Ty.
  pure subroutine set_flat(pattern, k)
    type(pattern_type), intent(inout) :: pattern  !! frames and weights
    integer, intent(in) :: k                      !! plane
    pattern%cos_theta(k) = 1.0_wp
    pattern%sin_theta(k) = 0.0_wp
    pattern%e_x(k) = 1.0_wp
    pattern%e_y(k) = 0.0_wp
    pattern%h_y(k) = 1.0_wp
    pattern%slope(k) = 0.0_wp
  end subroutine set_flat

  !> Unit normal (N, Tx, Ty) of plane k.
  pure function plane_normal(pattern, k) result(n)
    type(pattern_type), intent(in) :: pattern     !! frames and weights
    integer, intent(in) :: k                      !! plane, 1..Np
    real(wp) :: n(3)
    n = [pattern%cos_theta(k), -pattern%sin_theta(k)*pattern%e_x(k), -pattern%sin_theta(k)*pattern%e_y(k)]
  end function plane_normal

  !> Axes (1) of plane k: rows n, t and h.
  pure function plane_axes(pattern, k) result(axes)
    type(pattern_type), intent(in) :: pattern     !! frames and weights
    integer, intent(in) :: k                      !! plane, 1..Np
    real(wp) :: axes(3, 3)
    axes(1, :) = plane_normal(pattern, k)
    axes(2, :) = [pattern%sin_theta(k), pattern%cos_theta(k)*pattern%e_x(k), pattern%cos_theta(k)*pattern%e_y(k)]
    axes(3, :) = [0.0_wp, pattern%e_y(k), pattern%h_y(k)]
  end function plane_axes

  !> Component of a unit vector; what is a rounding error is zero, so that the feet of facets across an axis of symmetry
  !> meet on it.
  pure elemental function axial(component) result(exact)
    real(wp), intent(in) :: component   !! -1 to 1
    real(wp) :: exact
    exact = merge(0.0_wp, component, abs(component) < 4.0_wp*epsilon(component))
  end function axial

  !> Unit vector (Tx, Ty) at an angle from Tx towards Ty; exact along the axes.
  pure function direction_vector(direction) result(e)
    real(wp), intent(in) :: direction   !! degrees
    real(wp) :: e(2)
    real(wp) :: angle
    integer :: i, quarter
    angle = modulo(direction, 360.0_wp)
    quarter = nint(angle/90.0_wp)
    angle = (angle - 90.0_wp*real(quarter, wp))*degree
    e = [cos(angle), sin(angle)]
    do i = 1, modulo(quarter, 4)
      e = [0.0_wp - e(2), e(1)]
    end do
  end function direction_vector

end module asperity_pattern
