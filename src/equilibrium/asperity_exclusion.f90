!> Proof that no separation carries prescribed tractions: branch and bound over all separations.
!>
!> Over a box of separations the traction lies between bounds that follow from the bounds of the separations of every
!> plane. If a prescribed traction lies outside, the box has no equilibrium; otherwise the box is halved. If no box is
!> left, no equilibrium exists, up to the largest separation that a load path may have.
module asperity_exclusion
  use asperity_contract, only: plane_statev, v_offset
  use asperity_control_point, only: balance_type, control_type, point_type, prescribed_bound, set_balance
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_material, only: material_type, over_time
  use asperity_pattern, only: plane_normal
  implicit none
  private
  public :: exclude_equilibria

  !> Number of boxes that take about a tenth of a second.
  integer, parameter, public :: most_boxes = 20000

  !> Bounds of a number.
  type :: range_type
    real(wp) :: low, high
  end type range_type

contains

  !> Prove that no separation carries given values in one increment from the state of a point on.
  !>
  !> With the guard, and on facets, nothing is proved: the guard depends on the path, and the traction of a facet has no
  !> such simple bounds.
  pure subroutine exclude_equilibria(joint, control, given, point, most, proven, boxes)
    type(interface_type), intent(in) :: joint      !! the interface
    type(control_type), intent(in) :: control      !! what is given, at least one traction
    real(wp), intent(in) :: given(3)               !! its values
    type(point_type), intent(in) :: point          !! the last point found
    integer, intent(in) :: most                    !! largest number of boxes
    logical, intent(out) :: proven                 !! whether no equilibrium exists
    integer, intent(out) :: boxes                  !! boxes that were examined
    !> A box has at most 3 x 200 halves of a finite length.
    integer, parameter :: deepest = 700
    type(balance_type) :: balance
    type(range_type) :: box(3), pending(3, deepest)
    logical :: divided, outside
    integer :: i, left

    proven = .false.
    boxes = 0
    if (joint%material%guard .or. joint%material%curved) return
    call set_balance(joint, control, given, balance)
    if (balance%n == 0) return
    do i = 1, 3
      pending(i, 1) = range_type(given(i), given(i))
      if (control%traction(i)) pending(i, 1) = range_type(-prescribed_bound(joint), prescribed_bound(joint))
    end do
    left = 1
    do while (left > 0 .and. boxes < most .and. left < deepest)
      box = pending(:, left)
      left = left - 1
      boxes = boxes + 1
      call examine_box(joint, balance, over_time(joint%material, control%dt), point, box, outside)
      if (outside) cycle
      call halve_box(joint, balance, box, pending(:, left + 1), pending(:, left + 2), divided)
      if (.not. divided) return
      left = left + 2
    end do
    proven = left == 0
  end subroutine exclude_equilibria

  !> Divide a box across its longest side. Sides that reach over several orders of magnitude are divided at zero or at
  !> the geometric mean of their ends.
  pure subroutine halve_box(joint, balance, box, first, last, divided)
    type(interface_type), intent(in) :: joint              !! the interface
    type(balance_type), intent(in) :: balance              !! free components
    type(range_type), intent(in) :: box(3)                 !! the box
    type(range_type), intent(out) :: first(3), last(3)     !! its halves
    logical, intent(out) :: divided                        !! false: its sides are too short to be divided
    real(wp), parameter :: orders = 16.0_wp
    real(wp) :: least, middle, near, far
    integer :: i
    first = box
    last = box
    i = balance%free(maxloc(box(balance%free(:balance%n))%high - box(balance%free(:balance%n))%low, 1))
    least = epsilon(1.0_wp)*joint%material%s0
    near = min(abs(box(i)%low), abs(box(i)%high))
    far = max(abs(box(i)%low), abs(box(i)%high))
    if (box(i)%low < 0.0_wp .and. box(i)%high > 0.0_wp) then
      middle = 0.0_wp
    else if (far > orders*max(near, joint%material%s0)) then
      middle = sign(sqrt(far)*sqrt(max(near, joint%material%s0)), box(i)%low + box(i)%high)
    else
      middle = box(i)%low + 0.5_wp*(box(i)%high - box(i)%low)
    end if
    divided = box(i)%high - box(i)%low > max(least, 4.0_wp*spacing(far))
    first(i)%high = middle
    last(i)%low = middle
  end subroutine halve_box

  !> Whether a box has no equilibrium.
  pure subroutine examine_box(joint, balance, material, point, box, outside)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! the equations
    type(material_type), intent(in) :: material     !! constants of the law over the increment
    type(point_type), intent(in) :: point           !! the state
    type(range_type), intent(in) :: box(3)          !! separations
    logical, intent(out) :: outside                 !! whether a given traction is outside its bounds
    !> Rounding errors of the sums, relative to the sum of the magnitudes of their terms.
    real(wp), parameter :: rounding = 256.0_wp*epsilon(1.0_wp)
    type(range_type) :: residual(3), whole(3)
    real(wp) :: error, size_of(3)
    integer :: i, k
    do i = 1, 3
      whole(i) = range_type(box(i)%low + point%state(v_offset + i - 1), box(i)%high + point%state(v_offset + i - 1))
      residual(i) = scaled(balance%control%spring(i), box(i))
      size_of(i) = largest(residual(i))
    end do
    do k = 1, joint%pattern%n
      call add_plane(joint, material, k, point%state(plane_statev(k):plane_statev(k) + 2), whole, residual, size_of)
    end do
    outside = .false.
    do i = 1, balance%n
      k = balance%free(i)
      error = rounding*(size_of(k) + abs(balance%given(k)))
      outside = outside .or. residual(k)%low - error > balance%given(k) .or. residual(k)%high + error < balance%given(k)
    end do
  end subroutine examine_box

  !> Add the bounds of the traction of a plane, with its weight.
  !>
  !> In the axes of the plane the traction is that of the bond, (1 - alpha) K s, the pressure, and alpha times the
  !> friction, which is the trial separation times a factor from 0 to 1 and at most mu p. The damage grows with the norm
  !> of (6).
  pure subroutine add_plane(joint, m, k, state, s, traction, size_of)
    type(interface_type), intent(in) :: joint              !! the interface
    type(material_type), intent(in) :: m                   !! constants of the law over the increment
    integer, intent(in) :: k                               !! plane
    real(wp), intent(in) :: state(3)                       !! its damage and inelastic slip
    type(range_type), intent(in) :: s(3)                   !! separation
    type(range_type), intent(inout) :: traction(3)         !! sum so far -> with this plane
    real(wp), intent(inout) :: size_of(3)                  !! sum of the magnitudes of its terms so far, stress
    !> Rounding error of a separation in the axes of the plane, relative to its largest component.
    real(wp), parameter :: rounding = 4.0_wp*epsilon(1.0_wp)
    real(wp) :: axes(3, 3), error
    type(range_type) :: bond, damage, friction, kept, local(3), opening, pressure, sigma(3), &
      term, trial(2), whole_trial
    integer :: i, j
    axes(1, :) = plane_normal(joint%pattern, k)
    axes(2, :) = [joint%pattern%sin_theta(k), joint%pattern%cos_theta(k)*joint%pattern%e_x(k), &
      joint%pattern%cos_theta(k)*joint%pattern%e_y(k)]
    axes(3, :) = [0.0_wp, joint%pattern%h_x(k), joint%pattern%h_y(k)]
    error = rounding*max(largest(s(1)), largest(s(2)), largest(s(3)))
    do i = 1, 3
      local(i) = range_type(-error, error)
      do j = 1, 3
        local(i) = sum_of(local(i), scaled(axes(i, j), s(j)))
      end do
    end do
    opening = range_type(max(0.0_wp, local(1)%low), max(0.0_wp, local(1)%high))
    pressure = range_type(m%k_t*m%kc_kt*max(0.0_wp, -local(1)%high), m%k_t*m%kc_kt*max(0.0_wp, -local(1)%low))
    trial = [sum_of(local(2), range_type(-state(2), -state(2))), sum_of(local(3), range_type(-state(3), -state(3)))]
    ! damage and bond
    damage = norm_of([scaled(sqrt(m%inv_s01_2), opening), scaled(sqrt(m%inv_s02_2), local(2)), &
      scaled(sqrt(m%inv_s02_2), local(3))])
    damage = range_type(damage_at(m, state(1), damage%low), damage_at(m, state(1), damage%high))
    bond = range_type(1.0_wp - damage%high, 1.0_wp - damage%low)
    ! friction: the factor of the trial separation
    whole_trial = norm_of([range_type(0.0_wp, 0.0_wp), trial(1), trial(2)])
    kept = range_type(1.0_wp, 1.0_wp)
    if (m%k_t*whole_trial%high > m%mu*pressure%low) kept%low = m%mu*pressure%low/(m%k_t*whole_trial%high)
    if (m%k_t*whole_trial%low > m%mu*pressure%high) kept%high = m%mu*pressure%high/(m%k_t*whole_trial%low)
    sigma(1) = sum_of(product_of(bond, scaled(m%k_t*m%kn_kt, opening)), range_type(-pressure%high, -pressure%low))
    do i = 2, 3
      friction = product_of(kept, scaled(m%k_t, trial(i - 1)))
      friction = range_type(max(friction%low, -m%mu*pressure%high), min(friction%high, m%mu*pressure%high))
      sigma(i) = sum_of(product_of(bond, scaled(m%k_t, local(i))), product_of(damage, friction))
    end do
    do j = 1, 3
      do i = 1, 3
        term = scaled(joint%pattern%gamma(k)*axes(i, j), sigma(i))
        traction(j) = sum_of(traction(j), term)
        size_of(j) = size_of(j) + largest(term)
      end do
    end do
  end subroutine add_plane

  !> Damage (7) with its history (25) where the norm 1 + beta of (6) has a value; it grows with this value.
  pure function damage_at(m, old, norm) result(alpha)
    type(material_type), intent(in) :: m   !! constants of the law over the increment
    real(wp), intent(in) :: old            !! damage at the start
    real(wp), intent(in) :: norm           !! 1 + beta
    real(wp) :: alpha
    alpha = max(old, merge(1.0_wp - m%take, 0.0_wp, m%keep > 0.0_wp)*old + min(m%take, &
      m%take_eta*(1.0_wp - 1.0_wp/max(1.0_wp, norm))))
  end function damage_at

  !> Largest magnitude of a number.
  pure function largest(a) result(size_of)
    type(range_type), intent(in) :: a      !! its bounds
    real(wp) :: size_of
    size_of = max(abs(a%low), abs(a%high))
  end function largest

  !> Bounds of a sum.
  pure function sum_of(a, b) result(c)
    type(range_type), intent(in) :: a, b   !! bounds of its terms
    type(range_type) :: c
    c = range_type(a%low + b%low, a%high + b%high)
  end function sum_of

  !> Bounds of a multiple.
  pure function scaled(factor, a) result(c)
    real(wp), intent(in) :: factor         !! any
    type(range_type), intent(in) :: a      !! bounds of the number
    type(range_type) :: c
    c = range_type(min(factor*a%low, factor*a%high), max(factor*a%low, factor*a%high))
  end function scaled

  !> Bounds of a product.
  pure function product_of(a, b) result(c)
    type(range_type), intent(in) :: a, b   !! bounds of its factors
    type(range_type) :: c
    real(wp) :: corners(4)
    corners = [a%low*b%low, a%low*b%high, a%high*b%low, a%high*b%high]
    c = range_type(minval(corners), maxval(corners))
  end function product_of

  !> Bounds of the norm of a vector.
  pure function norm_of(a) result(c)
    type(range_type), intent(in) :: a(3)   !! bounds of its components
    type(range_type) :: c
    real(wp) :: near(3)
    near = merge(0.0_wp, min(abs(a%low), abs(a%high)), a%low <= 0.0_wp .and. a%high >= 0.0_wp)
    c = range_type(sqrt(sum(near**2)), sqrt(sum(max(abs(a%low), abs(a%high))**2)))
  end function norm_of

end module asperity_exclusion
