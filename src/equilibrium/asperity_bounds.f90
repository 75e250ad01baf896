!> Directions in which no contact carries a traction, and the proof of asperity_strength for a point.
module asperity_bounds
  use asperity_control_point, only: control_type, point_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_pattern, only: plane_normal
  use asperity_strength, only: beyond_strength, sine_of_friction
  implicit none
  private
  public :: beyond_bounds, away_from_contact

contains

  !> Whether prescribed tractions are beyond what the interface can carry from the state of a point on, in which
  !> direction, and how much it carries in this direction.
  pure subroutine beyond_bounds(joint, control, given, point, beyond, direction, most)
    type(interface_type), intent(in) :: joint      !! the interface
    type(control_type), intent(in) :: control      !! what is given
    real(wp), intent(in) :: given(3)               !! its values
    type(point_type), intent(in) :: point          !! the last point found
    logical, intent(out) :: beyond                 !! whether no equilibrium exists
    real(wp), intent(out) :: direction(3)          !! unit vector (N, Tx, Ty)
    real(wp), intent(out) :: most                  !! largest traction in this direction, stress
    call beyond_strength(joint, control%traction, control%spring, given, control%dt, point%state, direction, most)
    beyond = any(abs(direction) > 0.0_wp)
  end subroutine beyond_bounds

  !> The direction, among those in which no contact carries a traction, that is nearest to prescribed tractions; the
  !> zero vector if they have no part in such a direction.
  pure function away_from_contact(joint, control, given) result(direction)
    type(interface_type), intent(in) :: joint      !! the interface
    type(control_type), intent(in) :: control      !! what is given
    real(wp), intent(in) :: given(3)               !! its values
    real(wp) :: direction(3)
    !> Azimuths that are compared; smallest change of the azimuth.
    integer, parameter :: azimuths = 16, last = azimuths - 1
    real(wp), parameter :: turn = 2.0_wp*acos(-1.0_wp), finest = 1.0e-10_wp
    real(wp) :: best, change, middle, product
    logical :: counts(3)
    integer :: i
    direction = 0.0_wp
    counts = control%traction .and. .not. control%spring > 0.0_wp
    if (.not. counts(1)) return
    best = 0.0_wp
    product = -huge(product)
    change = turn/real(azimuths, wp)
    do i = 0, last
      call consider(joint, given, counts, real(i, wp)*change, best, direction, product)
    end do
    do while (change > finest)
      middle = best
      call consider(joint, given, counts, middle + change, best, direction, product)
      call consider(joint, given, counts, middle - change, best, direction, product)
      change = 0.5_wp*change
    end do
    if (.not. product > 0.0_wp) direction = 0.0_wp
  end function away_from_contact

  !> Take the direction nearest to prescribed tractions at an azimuth if it is nearer than another direction.
  pure subroutine consider(joint, given, counts, azimuth, best, direction, product)
    type(interface_type), intent(in) :: joint      !! the interface
    real(wp), intent(in) :: given(3)               !! prescribed tractions
    logical, intent(in) :: counts(3)               !! components that the direction may have
    real(wp), intent(in) :: azimuth                !! about N
    real(wp), intent(inout) :: best                !! azimuth of the direction
    real(wp), intent(inout) :: direction(3)        !! the other direction -> the nearer one
    real(wp), intent(inout) :: product             !! of the direction and the tractions
    real(wp) :: e(2), nearest(3)
    e = [cos(azimuth), sin(azimuth)]
    ! sines of multiples of a right angle are rounding errors; a vector that becomes shorter is farther from the
    ! tractions than those along the axes, which are considered, too
    where (abs(e) < epsilon(1.0_wp) .or. .not. counts(2:3)) e = 0.0_wp
    nearest = nearest_direction(joint, given, e)
    if (.not. dot_product(nearest, given) > product) return
    best = azimuth
    direction = nearest
    product = dot_product(nearest, given)
  end subroutine consider

  !> The direction nearest to prescribed tractions at an azimuth, among those in which no contact carries a traction;
  !> the zero vector if there is none.
  pure function nearest_direction(joint, given, e) result(d)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: given(3)            !! prescribed tractions
    real(wp), intent(in) :: e(2)                !! direction (Tx, Ty) of the azimuth
    real(wp) :: d(3)
    !> Distance from the cones of friction, so that rounding errors do not reach them.
    real(wp), parameter :: distance = 1.0e-12_wp
    real(wp) :: angle, e_n, first, half, last, norm, normal(3)
    integer :: k
    d = 0.0_wp
    ! angles from N at which no contact carries a traction
    first = 0.0_wp
    last = huge(last)
    do k = 1, joint%pattern%n
      normal = plane_normal(joint%pattern, k)
      e_n = dot_product(normal(2:3), e)
      norm = sqrt(normal(1)**2 + e_n**2)
      if (norm < sine_of_friction(joint)) return
      angle = atan2(e_n, normal(1))
      half = acos(sine_of_friction(joint)/norm) - distance
      first = max(first, angle - half)
      last = min(last, angle + half)
    end do
    if (first > last) return
    angle = atan2(dot_product(given(2:3), e), given(1))
    if (angle < first .or. angle > last) angle = merge(first, last, cos(angle - first) > cos(angle - last))
    d = [cos(angle), sin(angle)*e]
  end function nearest_direction

end module asperity_bounds
