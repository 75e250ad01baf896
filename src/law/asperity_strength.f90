!> What an interface can carry at most, in closed form: a proof that prescribed tractions have no equilibrium.
!>
!> The traction of a plane is that of its bond plus that of its contact. In a direction that is inclined to every
!> contact by more than the angle of friction, no contact carries anything, and the bonds carry no more than their
!> strength. If the prescribed tractions exceed the sum of these strengths in one such direction, no separation carries
!> them.
module asperity_strength
  use asperity_interface, only: interface_type, plane_damage
  use asperity_kinds, only: wp
  use asperity_pattern, only: plane_normal
  implicit none
  private
  public :: beyond_strength

contains

  !> In which direction prescribed tractions are beyond what the interface can carry from a state on, and how much it
  !> carries in this direction. The direction is the zero vector if there is none.
  !>
  !> With viscous damage over a time, and with the guard, the bond of a plane has no such strength; the contact on a
  !> curved facet has no such direction.
  pure subroutine beyond_strength(joint, traction, spring, given, dt, state, direction, most)
    type(interface_type), intent(in) :: joint      !! the interface
    logical, intent(in) :: traction(3)             !! whether traction + spring*separation is given, or the separation
    real(wp), intent(in) :: spring(3)              !! stiffness of a surrounding spring, stress/length
    real(wp), intent(in) :: given(3)               !! the given values
    real(wp), intent(in) :: dt                     !! duration, time
    real(wp), intent(in) :: state(:)               !! STATEV
    real(wp), intent(out) :: direction(3)          !! unit vector (N, Tx, Ty)
    real(wp), intent(out) :: most                  !! largest traction in this direction, stress
    !> Directions to a quarter of the circle; excess that is no rounding error, relative to the strength.
    integer, parameter :: quarter = 90, half = 2*quarter, last = 4*quarter - 1
    real(wp), parameter :: unit = acos(-1.0_wp)/real(half, wp), rounding = 1.0e-12_wp
    logical :: counts(3)
    real(wp) :: d(3), excess, largest, strength
    integer :: i, j

    direction = 0.0_wp
    most = 0.0_wp
    associate (m => joint%material)
      if (m%guard .or. m%curved .or. (m%tau_v > 0.0_wp .and. dt > 0.0_wp)) return
    end associate
    ! the force of a spring is not prescribed
    counts = traction .and. .not. spring > 0.0_wp
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
        strength = bond_strength(joint, state, d)
        excess = dot_product(d, given) - strength
        if (excess <= largest) cycle
        largest = excess
        direction = d
        most = strength
      end do
    end do
  end subroutine beyond_strength

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
  pure function bond_strength(joint, state, d) result(strength)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: state(:)            !! STATEV
    real(wp), intent(in) :: d(3)                !! unit vector (N, Tx, Ty)
    real(wp) :: strength
    real(wp) :: alpha(joint%pattern%n), normal
    integer :: k
    strength = 0.0_wp
    alpha = plane_damage(joint, state)
    associate (m => joint%material)
      do k = 1, joint%pattern%n
        normal = dot_product(d, plane_normal(joint%pattern, k))
        strength = strength + joint%pattern%gamma(k)*(1.0_wp - alpha(k))/(1.0_wp - m%eta*alpha(k))* &
          sqrt(m%k_n**2/m%inv_s01_2*normal**2 + m%k_t**2/m%inv_s02_2*max(0.0_wp, 1.0_wp - normal**2))
      end do
    end associate
  end function bond_strength

end module asperity_strength
