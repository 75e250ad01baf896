!> What an interface can carry at most, in closed form: a proof that prescribed tractions have no equilibrium.
!>
!> The traction of a plane is that of its bond plus that of its contact. In a direction that is inclined to every
!> contact by more than the angle of friction, no contact carries anything, and the bonds carry no more than their
!> strength. If the prescribed tractions exceed the sum of these strengths in one such direction, no separation carries
!> them.
module asperity_bounds
  use asperity_contract, only: plane_statev
  use asperity_control_point, only: control_type, point_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_pattern, only: plane_normal
  implicit none
  private
  public :: beyond_bounds, away_from_contact

contains

  !> Whether prescribed tractions are beyond what the interface can carry from the state of a point on, in which
  !> direction, and how much it carries in this direction.
  !>
  !> With viscous damage over a time, and with the guard, the bond of a plane has no such strength; the contact on a
  !> curved facet has no such direction.
  pure subroutine beyond_bounds(joint, control, given, point, beyond, direction, most)
    type(interface_type), intent(in) :: joint      !! the interface
    type(control_type), intent(in) :: control      !! what is given
    real(wp), intent(in) :: given(3)               !! its values
    type(point_type), intent(in) :: point          !! the last point found
    logical, intent(out) :: beyond                 !! whether no equilibrium exists
    real(wp), intent(out) :: direction(3)          !! unit vector (N, Tx, Ty)
    real(wp), intent(out) :: most                  !! largest traction in this direction, stress
    !> Directions to a quarter of the circle; excess that is no rounding error, relative to the strength.
    integer, parameter :: quarter = 90, half = 2*quarter, last = 4*quarter - 1
    real(wp), parameter :: unit = acos(-1.0_wp)/real(half, wp), rounding = 1.0e-12_wp
    logical :: counts(3)
    real(wp) :: d(3), excess, largest, strength
    integer :: i, j

    beyond = .false.
    direction = 0.0_wp
    most = 0.0_wp
    associate (m => joint%material)
      if (m%guard .or. m%curved .or. (m%tau_v > 0.0_wp .and. control%dt > 0.0_wp)) return
    end associate
    ! the force of a spring is not prescribed
    counts = control%traction .and. .not. control%spring > 0.0_wp
    largest = rounding*joint%material%k_n*joint%material%s0
    ! angles from N and about N
    do i = 0, half
      do j = 0, last
        d = [cos(unit*real(i, wp)), sin(unit*real(i, wp))*[cos(unit*real(j, wp)), sin(unit*real(j, wp))]]
        ! sines of multiples of a right angle are rounding errors
        where (abs(d) < epsilon(1.0_wp)) d = 0.0_wp
        if (any(abs(d) > 0.0_wp .and. .not. counts)) cycle
        if (.not. dot_product(d, given) > 0.0_wp) cycle
        if (.not. free_of_contact(joint, d)) cycle
        strength = bond_strength(joint, point, d)
        excess = dot_product(d, given) - strength
        if (excess <= largest) cycle
        beyond = .true.
        largest = excess
        direction = d
        most = strength
      end do
    end do
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

  !> Whether no contact carries a traction in a direction: it is outside every cone of friction.
  pure function free_of_contact(joint, d) result(yes)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: d(3)                !! unit vector (N, Tx, Ty)
    logical :: yes
    integer :: k
    yes = .true.
    do k = 1, joint%pattern%n
      yes = yes .and. dot_product(d, plane_normal(joint%pattern, k)) >= sine_of_friction(joint)
    end do
  end function free_of_contact

  !> Sine of the angle of friction.
  pure function sine_of_friction(joint) result(sine)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp) :: sine
    sine = joint%material%mu/sqrt(1.0_wp + joint%material%mu**2)
  end function sine_of_friction

  !> Sum of the strengths of the bonds in a direction, stress. The traction of a bond is (1 - alpha) r times a vector on
  !> the ellipse of the strengths, and (1 - alpha) r is largest where the damage (7) begins to grow again.
  pure function bond_strength(joint, point, d) result(strength)
    type(interface_type), intent(in) :: joint   !! the interface
    type(point_type), intent(in) :: point       !! its state
    real(wp), intent(in) :: d(3)                !! unit vector (N, Tx, Ty)
    real(wp) :: strength
    real(wp) :: alpha, normal
    integer :: k
    strength = 0.0_wp
    associate (m => joint%material)
      do k = 1, joint%pattern%n
        alpha = point%state(plane_statev(k))
        normal = dot_product(d, plane_normal(joint%pattern, k))
        strength = strength + joint%pattern%gamma(k)*(1.0_wp - alpha)/(1.0_wp - m%eta*alpha)* &
          sqrt(m%k_n**2/m%inv_s01_2*normal**2 + m%k_t**2/m%inv_s02_2*max(0.0_wp, 1.0_wp - normal**2))
      end do
    end associate
  end function bond_strength

end module asperity_bounds
