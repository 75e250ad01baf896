!> Regimes of the planes in an increment (in contact, sliding, damage growing and so on) and the places at which they
!> switch. A switch is a kink of the curves of traction and separation.
module asperity_regime
  use asperity_contract, only: plane_statev
  use asperity_control_point, only: point_type, whole_separation
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_law, only: kinematics_type, plane_kinematics
  implicit none
  private
  public :: regime, criteria, slips, slips_back, switch_shares

  !> Number of criteria of a plane.
  integer, parameter, public :: n_regimes = 6

contains

  !> Regime of every plane in an increment: in contact, sliding in contact, damage growing, fully damaged, on the
  !> climbing side of its facet, bond closed.
  pure function regime(joint, old, new) result(does)
    type(interface_type), intent(in) :: joint       !! the interface
    type(point_type), intent(in) :: old, new        !! start and end of the increment
    logical :: does(n_regimes, joint%pattern%n)
    does = criteria(joint, old, new) > 0.0_wp
  end function regime

  !> Margins of the regime of every plane; a margin is positive if the plane is in contact, slides in contact, has
  !> growing damage, is fully damaged, is in contact on the climbing side of its facet, or has a closed bond, in this
  !> order. Separations are relative to s0; damage (6), (7) and slip (38) are those of the law.
  pure function criteria(joint, old, new) result(margin)
    type(interface_type), intent(in) :: joint       !! the interface
    type(point_type), intent(in) :: old, new        !! start and end of the increment
    real(wp) :: margin(n_regimes, joint%pattern%n)
    !> Openings below this are rounding errors: a fully damaged plane without traction just touches.
    real(wp), parameter :: touching = 1.0e-10_wp
    type(kinematics_type) :: kinematics
    real(wp) :: alpha, r, reach, s(3)
    integer :: i, k
    s = whole_separation(new%s, new%state)
    associate (m => joint%material)
      do k = 1, joint%pattern%n
        i = plane_statev(k)
        alpha = old%state(i)
        kinematics = plane_kinematics(joint, k, s, new%state)
        associate (bond => kinematics%bond, contact => kinematics%contact)
          r = bond_reach(joint, bond)
          reach = sqrt((contact(2) - old%state(i + 1))**2 + (contact(3) - old%state(i + 2))**2) + &
            m%mu*m%kc_kt*contact(1)
          margin(1, k) = touching - contact(1)/m%s0
        end associate
        margin(2, k) = min(reach/m%s0, margin(1, k))
        margin(3, k) = r*(1.0_wp - m%eta*alpha) - 1.0_wp
        margin(4, k) = r*(1.0_wp - m%eta) - 1.0_wp
        ! the slope of a facet has a kink at its foot; if it closes there, its traction jumps
        margin(5, k) = merge(kinematics%touch/m%s0, -1.0_wp, m%curved .and. margin(1, k) > 0.0_wp)
        ! the bond of a facet is that of the straight plane and closes by itself
        margin(6, k) = merge(touching - kinematics%bond(1)/m%s0, -1.0_wp, m%curved .and. alpha < 1.0_wp)
        ! the damage of a fully damaged plane does not grow
        if (alpha >= 1.0_wp) margin(3:4, k) = 1.0_wp
      end do
    end associate
  end function criteria

  !> Slip of every plane in an increment, length.
  pure function slips(joint, old, new) result(slip)
    type(interface_type), intent(in) :: joint       !! the interface
    type(point_type), intent(in) :: old, new        !! start and end of the increment
    real(wp) :: slip(2, joint%pattern%n)
    integer :: i, k
    do k = 1, joint%pattern%n
      i = plane_statev(k)
      slip(:, k) = new%state(i + 1:i + 2) - old%state(i + 1:i + 2)
    end do
  end function slips

  !> Whether a damaged plane slips back in the second of two increments. It sticks between them, although it slides in
  !> both.
  pure function slips_back(joint, first, second, point) result(yes)
    type(interface_type), intent(in) :: joint                !! the interface
    real(wp), intent(in) :: first(:, :), second(:, :)        !! slips of the planes in both increments, length
    type(point_type), intent(in) :: point                    !! end of the second increment
    logical :: yes
    integer :: k
    yes = .false.
    do k = 1, joint%pattern%n
      if (point%state(plane_statev(k)) > 0.0_wp) yes = yes .or. sum(first(:, k)*second(:, k)) < 0.0_wp
    end do
  end function slips_back

  !> Shares of an increment at which the first and the last of its switches are expected, if the separations change in
  !> proportion; its middle if no switch is expected.
  pure function switch_shares(joint, old, new) result(shares)
    type(interface_type), intent(in) :: joint       !! the interface
    type(point_type), intent(in) :: old, new        !! start and end of the increment
    real(wp) :: shares(2)
    type(kinematics_type) :: first, last
    real(wp) :: a, b, c, change(2), elastic(2), limit, rise, s(3), s_old(3)
    integer :: i, k
    s_old = whole_separation(old%s, old%state)
    s = whole_separation(new%s, new%state)
    shares = [1.0_wp, 0.0_wp]
    associate (m => joint%material)
      do k = 1, joint%pattern%n
        i = plane_statev(k)
        first = plane_kinematics(joint, k, s_old, old%state)
        last = plane_kinematics(joint, k, s, new%state)
        call include_zero(first%contact(1), last%contact(1), shares)
        if (m%curved) call include_zero(first%touch, last%touch, shares)
        if (m%curved) call include_zero(first%bond(1), last%bond(1), shares)
        ! damage begins or stops to grow, and ends
        a = bond_reach(joint, first%bond)
        b = bond_reach(joint, last%bond)
        c = 1.0_wp/(1.0_wp - m%eta*old%state(i))
        call include_zero(a - c, b - c, shares)
        c = 1.0_wp/(1.0_wp - m%eta)
        call include_zero(a - c, b - c, shares)
        ! the elastic part of the slip reaches or leaves the limit of friction: |elastic|^2 = limit^2
        if (.not. new%state(i) > 0.0_wp) cycle
        elastic = first%contact(2:3) - old%state(i + 1:i + 2)
        change = last%contact(2:3) - first%contact(2:3)
        limit = -m%mu*m%kc_kt*first%contact(1)
        rise = -m%mu*m%kc_kt*(last%contact(1) - first%contact(1))
        a = sum(change**2) - rise**2
        b = sum(elastic*change) - limit*rise
        c = b**2 - a*(sum(elastic**2) - limit**2)
        if (c < 0.0_wp) cycle
        call include_zero(b - sqrt(c), a + b - sqrt(c), shares)
        call include_zero(b + sqrt(c), a + b + sqrt(c), shares)
      end do
    end associate
    if (shares(1) > shares(2)) shares = 0.5_wp
  end function switch_shares

  !> Extend the range of shares by the zero of a linear function with the given values at both ends, if there is one
  !> within the increment.
  pure subroutine include_zero(first, last, shares)
    real(wp), intent(in) :: first, last        !! values at both ends
    real(wp), intent(inout) :: shares(2)       !! smallest and largest share so far
    !> Nearer to an end a switch belongs to the end.
    real(wp), parameter :: edge = 1.0e-3_wp
    real(wp) :: share
    if (first > 0.0_wp .eqv. last > 0.0_wp) return
    share = first/(first - last)
    if (share <= edge .or. share >= 1.0_wp - edge) return
    shares = [min(shares(1), share), max(shares(2), share)]
  end subroutine include_zero

  !> Separation of a bond relative to that at which its damage begins, (6).
  pure function bond_reach(joint, bond) result(r)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in) :: bond(3)                 !! separation of the bond, length
    real(wp) :: r
    associate (m => joint%material)
      r = sqrt(m%inv_s01_2*max(bond(1), 0.0_wp)**2 + m%inv_s02_2*(bond(2)**2 + bond(3)**2))
    end associate
  end function bond_reach

end module asperity_regime
