!> Traction and tangent with the damage, the friction bound and the facets of another separation, the aim.
!>
!> The state is that of the law at s. The traction is the gradient of a convex function of s, so that the tangent is
!> symmetric and has no negative eigenvalue (docs/theory.md, section 10).
module asperity_aim
  use asperity_block_double, only: block_type, chunk
  use asperity_cap, only: largest_pressure, strength_at
  use asperity_contact, only: add_dashpot, contact_stiffness, opening, pressure
  use asperity_contract, only: plane_statev, v_offset
  use asperity_crushing, only: closed_by, plastic_closure
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_material, only: material_type
  use asperity_pattern, only: plane_axes
  use asperity_point, only: kinematics_type, plane_kinematics
  use asperity_types, only: local_type
  use asperity_yielding_rows, only: update_rows
  implicit none
  private
  public :: closing_pressure, frozen_response, update_aimed

  !> Excess over the largest pressure, relative to the compressive strength, that is a rounding error; steps of the
  !> search for the plastic closure, and growth of the bracket while its end is sought.
  real(wp), parameter :: rounding = 1.0e-13_wp, growth = 2.0_wp
  integer, parameter :: most_trials = 250

contains

  !> Update points first..last, at most `chunk`, with the traction and the tangent of frozen variables.
  pure subroutine update_aimed(joint, block, first, last, aim, s, state, traction, by_rows, dt, s_old, tangent)
    type(interface_type), intent(in) :: joint                     !! the interface
    type(block_type), intent(in) :: block                         !! the same for blocks
    integer, intent(in) :: first, last                            !! points
    real(wp), intent(in), contiguous :: aim(:, :)                 !! (3, n) separation of the frozen variables, length
    real(wp), intent(in), contiguous :: s(:, :)                   !! (3, n) separation (N, Tx, Ty) at the end, length
    real(wp), intent(inout), contiguous :: state(:, :)            !! (nstatv, n) STATEV, start -> end
    real(wp), intent(inout), contiguous :: traction(:, :)         !! (3, n) traction at the end, stress
    logical, intent(in) :: by_rows                                !! of update_rows; the tangent is symmetric
    real(wp), intent(in), optional :: dt                          !! duration, >= 0, time
    real(wp), intent(in), optional, contiguous :: s_old(:, :)     !! (3, n) separation at the start, absent: zero
    real(wp), intent(inout), optional, contiguous :: tangent(:, :, :)   !! (3, 3, n) d traction_i/d s_j, stress/length
    real(wp), dimension(joint%n_statev, chunk) :: start, frozen
    real(wp), dimension(3, chunk) :: from, to, at_aim
    real(wp) :: d(3, 3), strength
    integer :: i, k, n
    n = last - first + 1
    start(:, :n) = state(:joint%n_statev, first:last)
    ! the state has the bits of a call without aim
    call update_rows(joint, block, first, last, s, state, traction, by_rows, dt, s_old, tangent)
    frozen(:, :n) = start(:, :n)
    to(:, :n) = aim(:, first:last)
    from(:, :n) = 0.0_wp
    if (present(s_old)) from(:, :n) = s_old(:, first:last)
    call update_rows(joint, block, 1, n, to(:, :n), frozen(:, :n), at_aim(:, :n), by_rows, dt, from(:, :n))
    do i = 1, n
      k = first + i - 1
      call frozen_response(joint, block%growth%lag, from(:, i), to(:, i), s(:, k), start(:, i), frozen(:, i), &
        at_aim(:, i), traction(:, k), d, strength)
      if (present(tangent)) tangent(:, :, k) = d
    end do
  end subroutine update_aimed

  !> Traction and tangent of a point at s with the variables of the aim, among them the largest pressure of a joint with
  !> a compressive strength.
  !>
  !> A plastic closure that is not below that at the start takes what exceeds this pressure: its energy is linear, so
  !> that the sum is convex.
  pure subroutine frozen_response(joint, lag, s_old, aim, s, start, frozen, at_aim, traction, tangent, strength, secant)
    type(interface_type), intent(in) :: joint             !! material and pattern
    real(wp), intent(in) :: lag                           !! c/(K_c dt) of the dashpot
    real(wp), intent(in) :: s_old(3)                      !! separation at the start, length
    real(wp), intent(in) :: aim(3)                        !! separation (N, Tx, Ty) of the frozen variables, length
    real(wp), intent(in) :: s(3)                          !! separation at the end, length
    real(wp), intent(in) :: start(joint%n_statev)         !! STATEV at the start of the increment
    real(wp), intent(in) :: frozen(joint%n_statev)        !! STATEV that the law gives at the aim
    real(wp), intent(in) :: at_aim(3)                     !! traction that it gives there, stress
    real(wp), intent(out) :: traction(3)                  !! traction (N, Tx, Ty), stress
    real(wp), intent(out) :: tangent(3, 3)                !! d traction_i/d s_j, stress/length
    real(wp), intent(out) :: strength                     !! largest bound mu p of a plane, stress
    logical, intent(in), optional :: secant               !! absent: false
    real(wp) :: along(3), from(3), goal(3), high, kappa, low, most, next, width
    integer :: i
    logical :: bracketed
    low = plastic_closure(joint, start)
    from = closed_by(s_old, low)
    kappa = plastic_closure(joint, frozen)
    goal = closed_by(aim, kappa)
    call frozen_planes(joint, lag, from, goal, closed_by(s, low), start, frozen, traction, tangent, strength, secant)
    if (.not. joint%cap%peak > 0.0_wp) return
    most = largest_pressure(joint%cap, strength_at(joint%cap, kappa), at_aim)
    if (-traction(1) - most <= rounding*joint%cap%peak) return
    kappa = low
    high = huge(high)
    bracketed = .false.
    width = max((-traction(1) - most)/max(joint%material%k_c, joint%material%k_n), growth*spacing(kappa))
    do i = 1, most_trials
      next = low - 1.0_wp
      ! the pressure falls with the plastic closure
      if (tangent(1, 1) > 0.0_wp) next = kappa + (-traction(1) - most)/tangent(1, 1)
      if (.not. bracketed) then
        if (.not. (next > low .and. next <= low + width)) next = low + width
        width = growth*width
      else if (.not. (next > low .and. next < high) .or. modulo(i, 3) == 0) then
        next = low + 0.5_wp*(high - low)
      end if
      kappa = next
      call frozen_planes(joint, lag, from, goal, closed_by(s, kappa), start, frozen, traction, tangent, strength, &
        secant)
      if (abs(-traction(1) - most) <= rounding*joint%cap%peak) exit
      if (-traction(1) > most) then
        low = kappa
      else
        high = kappa
        bracketed = .true.
        if (high - low <= 2.0_wp*spacing(high)) exit
      end if
    end do
    if (.not. tangent(1, 1) > 0.0_wp) return
    along = tangent(:, 1)
    tangent = tangent - spread(along, 2, 3)*spread(along/along(1), 1, 3)
    tangent(1, :) = 0.0_wp
    tangent(:, 1) = 0.0_wp
    tangent(3, 2) = tangent(2, 3)
  end subroutine frozen_response

  !> Traction and tangent of a point at s, with the damage alpha, the friction bound mu p, and the facets of the aim.
  !>
  !> The separation of the contact is linear in s about the aim. The trial stress beyond the bound is projected on the
  !> circle with the radius mu p: the friction of Tresca. With `secant` friction is linear in s, instead: the ratio of
  !> friction and trial stress is that of the aim. Contact is unilateral, its pressure that of s.
  !> With a dashpot, pressure and friction are those of spring and dashpot together.
  pure subroutine frozen_planes(joint, lag, s_old, aim, s, start, frozen, traction, tangent, strength, secant)
    type(interface_type), intent(in) :: joint             !! material and pattern
    real(wp), intent(in) :: lag                           !! c/(K_c dt) of the dashpot
    real(wp), intent(in) :: s_old(3)                      !! separation at the start, length
    real(wp), intent(in) :: aim(3)                        !! separation (N, Tx, Ty) of the frozen variables, length
    real(wp), intent(in) :: s(3)                          !! separation at the end, length
    real(wp), intent(in) :: start(joint%n_statev)         !! STATEV at the start of the increment
    real(wp), intent(in) :: frozen(joint%n_statev)        !! STATEV that the law gives at the aim
    real(wp), intent(out) :: traction(3)                  !! traction (N, Tx, Ty), stress
    real(wp), intent(out) :: tangent(3, 3)                !! d traction_i/d s_j, stress/length
    real(wp), intent(out) :: strength                     !! largest bound mu p of a plane, stress
    logical, intent(in), optional :: secant               !! absent: false
    type(kinematics_type) :: at, before
    real(wp), dimension(3) :: bond, contact, damaged, offset, undamaged
    real(wp) :: across(3), axes(3, 3), along(3), part(3, 3)
    real(wp) :: alpha, bound, direction(2), elastic(2), factor, p, share, stiffness, trial, weight
    integer :: i, j, k
    logical :: linear, sticks
    linear = .false.
    if (present(secant)) linear = secant
    strength = 0.0_wp
    traction = 0.0_wp
    tangent = 0.0_wp
    offset = start(v_offset:v_offset + 2)
    do k = 1, joint%pattern%n
      i = plane_statev(k)
      alpha = frozen(i)
      at = plane_kinematics(joint, k, aim + offset, frozen)
      before = plane_kinematics(joint, k, s_old + offset, start)
      axes = plane_axes(joint%pattern, k)
      bond = matmul(axes, s + offset)
      contact = at%contact + matmul(at%gradient, s - aim)
      elastic = at%contact(2:3)
      if (.not. linear) elastic = contact(2:3)
      elastic = elastic - start(i + 1:i + 2) + lag*(elastic - before%contact(2:3))
      trial = hypot(elastic(1), elastic(2))
      direction = elastic/(trial + tiny(trial))
      call contact_response(joint%material, lag, before%contact, at%contact, p, stiffness)
      bound = joint%material%mu*p
      strength = max(strength, joint%material%k_t*bound)
      ! a contact that is open at the aim, or smooth, has no friction
      share = min(trial, bound)/(trial + tiny(trial))
      sticks = trial <= bound .and. at%contact(1) <= 0.0_wp .and. joint%material%mu > 0.0_wp
      if (sticks) share = 1.0_wp
      if (linear) then
        factor = (1.0_wp + lag)*share
        elastic = share*(contact(2:3) - start(i + 1:i + 2) + lag*(contact(2:3) - before%contact(2:3)))
        along = at%gradient(2, :)
        across = at%gradient(3, :)
      else if (sticks) then
        factor = 1.0_wp + lag
        along = at%gradient(2, :)
        across = at%gradient(3, :)
      else
        elastic = min(trial, bound)*direction
        factor = (1.0_wp + lag)*share
        along = 0.0_wp
        across = direction(1)*at%gradient(3, :) - direction(2)*at%gradient(2, :)
      end if
      associate (m => joint%material, g => at%gradient)
        weight = joint%pattern%gamma(k)*m%k_t
        undamaged = [m%kn_kt*opening(local_of(bond)) - pressure(m, local_of(bond)), bond(2:3)]
        call contact_response(m, lag, before%contact, contact, p, stiffness)
        damaged = [-p, elastic]
        ! in steps, as gfortran takes a sum with a product of matrices for a reallocation
        undamaged = matmul(undamaged, axes)
        damaged = matmul(damaged, g)
        do j = 1, 3
          part(:, j) = (1.0_wp - alpha)*(normal_stiffness(m, bond(1), m%kn_kt)*axes(1, :)*axes(1, j) + &
            axes(2, :)*axes(2, j) + axes(3, :)*axes(3, j)) + alpha*(stiffness*g(1, :)*g(1, j) + &
            factor*(along*along(j) + across*across(j)))
        end do
      end associate
      traction = traction + weight*((1.0_wp - alpha)*undamaged + alpha*damaged)
      tangent = tangent + weight*part
    end do
    ! the products of different order are rounded differently
    do j = 1, 2
      tangent(j + 1:, j) = tangent(j, j + 1:)
    end do
  end subroutine frozen_planes

  !> Pressure of a contact, with that of a dashpot, and its normal stiffness, over k_t.
  pure subroutine contact_response(m, lag, start, contact, p, stiffness)
    type(material_type), intent(in) :: m             !! constants
    real(wp), intent(in) :: lag                      !! c/(K_c dt) of the dashpot
    real(wp), intent(in) :: start(3), contact(3)     !! separation of the contact at start and end, length
    real(wp), intent(out) :: p, stiffness            !! over k_t
    p = pressure(m, local_of(contact))
    stiffness = normal_stiffness(m, contact(1), 0.0_wp)
    if (lag > 0.0_wp) call add_dashpot(m, lag, local_of(start), local_of(contact), p, stiffness)
  end subroutine contact_response

  !> Normal stiffness of bond or contact, over k_t; where it just touches, that of the bond (as straight_tangent).
  pure function normal_stiffness(m, normal, open) result(stiffness)
    type(material_type), intent(in) :: m   !! constants
    real(wp), intent(in) :: normal         !! normal separation, length
    real(wp), intent(in) :: open           !! stiffness of an opening, over k_t
    real(wp) :: stiffness
    stiffness = m%kn_kt
    if (normal < 0.0_wp) stiffness = contact_stiffness(m, local_type(normal, 0.0_wp, 0.0_wp))
    if (normal > 0.0_wp) stiffness = open
  end function normal_stiffness

  !> Pressure of a whole bond, or of a contact, with a normal separation; 0 if it is open.
  pure function closing_pressure(joint, normal) result(p)
    type(interface_type), intent(in) :: joint   !! material and pattern
    real(wp), intent(in) :: normal              !! normal separation of the plane, length
    real(wp) :: p
    p = joint%material%k_t*pressure(joint%material, local_of([normal, 0.0_wp, 0.0_wp]))
  end function closing_pressure

  !> Separation of a plane in its axes, as the functions of the contact take it.
  pure function local_of(x) result(local)
    real(wp), intent(in) :: x(3)   !! n, t, h, length
    type(local_type) :: local
    local = local_type(x(1), x(2), x(3))
  end function local_of

end module asperity_aim
