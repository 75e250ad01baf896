!> Overdamped motion under constant given values after the end of a branch of equilibria, to the first stable
!> equilibrium or to the separation beyond which none is searched.
!>
!> One free separation moves in the sense of the missing traction; a step is halved if it may pass two roots. Several
!> free separations move by damped implicit Euler steps (pseudo-transient continuation). The state follows the motion.
module asperity_snap_motion
  use asperity_contract, only: plane_statev, v_offset
  use asperity_interface, only: interface_type, separation_bound
  use asperity_kinds, only: wp
  use asperity_law, only: kinematics_type, plane_kinematics
  use asperity_pattern, only: plane_normal
  use asperity_control_point, only: balance_type, control_type, elastic_stiffness, energy_defect, evaluate, &
    free_matrix, move_point, point_type, set_balance, whole_separation
  use asperity_newton, only: newton_solve, newton_type
  use asperity_tolerances, only: farthest, least_damping, less_damping, more_damping, residual_tolerance, &
    unbalanced_motion
  implicit none
  private
  public :: move_on, close_opening, cannot_soften, farthest_rest

  !> Steps of a motion, as fractions of s0. With one free separation, two roots closer than the smallest step may be
  !> missed.
  real(wp), parameter :: first_step = 0.005_wp, smallest_step = first_step*2.0_wp**(-20)
  !> Growth of the step: slow if damage may grow, fast if all planes are fully damaged, as the law is then monotone.
  real(wp), parameter :: growth = 1.02_wp, fast_growth = 2.0_wp

contains

  !> Move under constant given values to the first stable equilibrium.
  pure subroutine move_on(joint, control, given, budget, point, updates, iterations, found)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given, at least one traction
    real(wp), intent(in) :: given(3)                !! its values
    integer, intent(in) :: budget                   !! largest number of updates of the law
    type(point_type), intent(inout) :: point        !! start -> equilibrium, or the last point of a motion without end
    integer, intent(out) :: updates                 !! of the law
    integer, intent(out) :: iterations              !! tangent solves
    logical, intent(out) :: found                   !! whether there is an equilibrium
    iterations = 0
    updates = 0
    if (count(control%traction) == 1) then
      call move_one_free(joint, control, given, budget, point, updates, found)
    else
      call move_several_free(joint, control, given, budget, point, updates, iterations, found)
    end if
  end subroutine move_on

  !> Whether the interface cannot soften: every plane is straight and fully damaged, and mu tan(theta) < 1. The residual
  !> of a single prescribed t_N then never decreases with s_N. On curved facets the shear traction decreases with slip.
  pure function cannot_soften(joint, point) result(yes)
    type(interface_type), intent(in) :: joint       !! the interface
    type(point_type), intent(in) :: point           !! the point
    logical :: yes
    integer :: k
    yes = .not. joint%material%curved
    do k = 1, joint%pattern%n
      yes = yes .and. point%state(plane_statev(k)) >= 1.0_wp .and. &
        joint%material%mu*joint%pattern%sin_theta(k) < joint%pattern%cos_theta(k)
    end do
  end function cannot_soften

  !> Separation beyond which several free ones, or with viscous damage a single one, count as growing without bound,
  !> length: `farthest` times s_f plus the given values, or the separation at the start. With viscous damage the
  !> undamaged part of a plane decreases with time, but never to zero.
  pure function farthest_rest(joint, balance) result(far)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! the equations
    real(wp) :: far
    far = huge(far)
    if (balance%n == 0 .or. (balance%n == 1 .and. .not. joint%material%tau_v > 0.0_wp)) return
    associate (material => joint%material)
      far = maxval(merge(abs(balance%given)/min(material%k_n, material%k_t), abs(balance%given), &
        balance%control%traction))
      far = max(maxval(abs(balance%old%s)), maxval(abs(whole_separation(balance%old%s, balance%old%state))), &
        farthest*(material%s0/(1.0_wp - material%eta) + far))
      far = min(far, 0.5_wp*separation_bound(joint))
    end associate
  end function farthest_rest

  !> Motion of one free separation.
  pure subroutine move_one_free(joint, control, given, budget, point, updates, found)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given: one traction
    real(wp), intent(in) :: given(3)                !! its value, the separations
    integer, intent(in) :: budget                   !! largest number of updates of the law
    type(point_type), intent(inout) :: point        !! start -> equilibrium
    integer, intent(inout) :: updates               !! of the law
    logical, intent(out) :: found                   !! whether there is an equilibrium
    type(balance_type) :: balance
    type(point_type) :: far
    real(wp) :: r(3), r_far(3), scale, sense, step, x(3)
    logical :: good
    integer :: free

    call set_balance(joint, control, given, balance)
    free = balance%free(1)
    x = 0.0_wp
    x(1) = point%s(free)
    balance%old = point
    call evaluate(joint, balance, x, point, r, scale, good)
    updates = updates + 1
    found = good .and. abs(r(1)) <= residual_tolerance*scale
    if (found .or. .not. good) return
    sense = -sign(1.0_wp, r(1))
    step = first_step*joint%material%s0
    call move_point(point, balance%old)
    do while (updates < budget)
      call evaluate(joint, balance, x + [sense*step, 0.0_wp, 0.0_wp], far, r_far, scale, good)
      updates = updates + 1
      if (.not. good) exit
      if (.not. balanced(joint, balance%old, far, step)) then
        step = 0.5_wp*step
        cycle
      end if
      if (sense*r_far(1) >= -residual_tolerance*scale) then
        call close_in(joint, balance, sense, x(1), x(1) + sense*step, far, updates, found)
        call move_point(far, point)
        return
      end if
      if (step > smallest_step*joint%material%s0) then
        if (predicts_root(sense*r(1), derivative(balance%old), step)) then
          step = 0.5_wp*step
          cycle
        end if
      end if
      call move_point(far, balance%old)
      x(1) = balance%old%s(free)
      r = r_far
      if (joint%material%wears) then
        ! the work of the step wears the facets in the next one; this may lead beyond the equilibrium
        call evaluate(joint, balance, x, far, r, scale, good)
        updates = updates + 1
        if (sense*r(1) > 0.0_wp) sense = -sense
      end if
      associate (now => balance%old)
        if (control%spring(free) <= 0.0_wp .and. free == 1 .and. sense > 0.0_wp .and. dead_and_open(now)) exit
        step = step*merge(fast_growth, growth, step < first_step*joint%material%s0 .or. &
          (free == 1 .and. cannot_soften(joint, now)))
      end associate
    end do
    call move_point(balance%old, point)

  contains

    !> Derivative of the residual with respect to the free separation.
    pure function derivative(at) result(slope)
      type(point_type), intent(in) :: at   !! the point
      real(wp) :: slope
      slope = at%tangent(free, free) + control%spring(free)
    end function derivative

  end subroutine move_one_free

  !> Whether the energies of a step of the motion balance within `unbalanced_motion`, or the step is very short. The
  !> work before a step wears the facets in it, and shorter steps do not reduce the error of this energy: it is not
  !> judged.
  pure function balanced(joint, old, new, length) result(yes)
    type(interface_type), intent(in) :: joint       !! the interface
    type(point_type), intent(in) :: old, new        !! the point before and after the step
    real(wp), intent(in) :: length                  !! of the step
    logical :: yes
    real(wp), parameter :: shortest = 2.0_wp**(-10)
    yes = joint%material%wears .or. length <= shortest*first_step*joint%material%s0
    if (.not. yes) yes = energy_defect(joint, old, new) <= unbalanced_motion*min(1.0_wp, length/joint%material%s0)
  end function balanced

  !> Whether a step from a negative value of a function may pass two of its roots: the tangent has a root within it.
  pure function predicts_root(f, slope, step) result(yes)
    real(wp), intent(in) :: f       !! value, < 0
    real(wp), intent(in) :: slope   !! derivative
    real(wp), intent(in) :: step    !! > 0
    logical :: yes
    yes = f + slope*step >= 0.0_wp
  end function predicts_root

  !> Find the equilibrium between two separations that bracket it, by Newton's method with bisection as a safeguard.
  pure subroutine close_in(joint, balance, sense, first, last, point, updates, found)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! the equation, the point at its start
    real(wp), intent(in) :: sense                   !! of the motion, +1 or -1
    real(wp), intent(in) :: first, last             !! free separation before and beyond the equilibrium, length
    type(point_type), intent(inout) :: point        !! the point at `last` -> in equilibrium
    integer, intent(inout) :: updates               !! of the law
    logical, intent(out) :: found                   !! whether the residual is small enough
    !> Newton steps in succession before the interval is halved.
    integer, parameter :: turn = 3
    real(wp) :: a(3, 3), far, guess, near, r(3), scale, x(3)
    logical :: good
    integer :: i
    near = first
    far = last
    x = [last, 0.0_wp, 0.0_wp]
    i = 0
    do
      i = i + 1
      call evaluate(joint, balance, x, point, r, scale, good)
      updates = updates + 1
      found = good .and. abs(r(1)) <= residual_tolerance*scale
      if (found .or. .not. good) exit
      if (sense*r(1) < 0.0_wp) then
        near = x(1)
      else
        far = x(1)
      end if
      a = free_matrix(balance, point)
      x(1) = near + 0.5_wp*(far - near)
      ! the interval has no number between its ends
      if (.not. (abs(x(1) - near) > 0.0_wp .and. abs(x(1) - far) > 0.0_wp)) exit
      if (a(1, 1) > 0.0_wp .and. modulo(i, turn) > 0) then
        guess = point%s(balance%free(1)) - r(1)/a(1, 1)
        if ((guess - near)*(guess - far) < 0.0_wp) x(1) = guess
      end if
    end do
    if (found) call close_opening(joint, balance, point, updates)
  end subroutine close_in

  !> Motion of several free separations, by implicit Euler steps.
  pure subroutine move_several_free(joint, control, given, budget, point, updates, iterations, found)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given
    real(wp), intent(in) :: given(3)                !! its values
    integer, intent(in) :: budget                   !! largest number of updates of the law
    type(point_type), intent(inout) :: point        !! start -> equilibrium
    integer, intent(inout) :: updates               !! of the law
    integer, intent(inout) :: iterations            !! tangent solves
    logical, intent(out) :: found                   !! whether there is an equilibrium
    type(balance_type) :: balance
    type(newton_type) :: result
    type(point_type) :: trial
    real(wp) :: damping, drift(3), far, limit, move, stiffness
    logical :: good

    found = .false.
    stiffness = elastic_stiffness(joint)
    limit = first_step*joint%material%s0
    damping = stiffness
    drift = 0.0_wp
    call set_balance(joint, control, given, balance)
    call move_point(point, balance%old)
    far = farthest_rest(joint, balance)
    do while (updates < budget .and. damping < stiffness/least_damping)
      ! is there an equilibrium near the start of the step?
      balance%damping = 0.0_wp
      trial%s = balance%old%s
      call newton_solve(joint, balance, .true., trial, result)
      updates = updates + result%updates
      iterations = iterations + result%iterations
      move = maxval(abs(trial%s - balance%old%s), mask=control%traction)
      found = result%converged .and. result%stable .and. move <= limit .and. maxval(abs(trial%s)) <= far
      if (found .and. .not. balanced(joint, balance%old, trial, move)) then
        limit = 0.5_wp*move
        found = .false.
      end if
      if (found) then
        call move_point(trial, balance%old)
        exit
      end if
      ! start in the direction of the last step, so that the tangent of a sliding plane is that of sliding
      balance%damping = damping
      trial%s = balance%old%s + drift
      call newton_solve(joint, balance, .true., trial, result)
      updates = updates + result%updates
      iterations = iterations + result%iterations
      move = maxval(abs(trial%s - balance%old%s), mask=control%traction)
      good = result%converged .and. result%stable .and. move <= limit
      if (good) good = balanced(joint, balance%old, trial, move)
      if (.not. good) then
        damping = more_damping*damping
        cycle
      end if
      drift = trial%s - balance%old%s
      call move_point(trial, balance%old)
      associate (now => balance%old)
        if (separates_forever(joint, balance, now)) exit
        damping = max(less_damping*damping, least_damping*stiffness)
        limit = min(far, limit*merge(fast_growth, growth, cannot_soften(joint, now)))
        if (maxval(abs(now%s)) > far) exit
      end associate
    end do
    call move_point(balance%old, point)
  end subroutine move_several_free

  !> Whether every plane is open and fully damaged and the prescribed tractions open it further: no equilibrium exists.
  pure function separates_forever(joint, balance, point) result(yes)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! what is given
    type(point_type), intent(in) :: point           !! the point
    logical :: yes
    real(wp) :: force(3)
    integer :: k
    yes = dead_and_open(point) .and. .not. any(balance%control%spring > 0.0_wp)
    if (.not. yes) return
    force = merge(balance%given, 0.0_wp, balance%control%traction)
    do k = 1, joint%pattern%n
      yes = yes .and. dot_product(plane_normal(joint%pattern, k), force) >= 0.0_wp
    end do
    yes = yes .and. any(abs(force) > 0.0_wp)
  end function separates_forever

  !> Whether every plane is fully damaged and open. The comparison with zero is exact: every term of the sum vanishes.
  pure function dead_and_open(point) result(yes)
    type(point_type), intent(in) :: point   !! the point
    logical :: yes
    yes = .not. any(abs(point%tangent) > 0.0_wp)
  end function dead_and_open

  !> If every plane is open and fully damaged and t_N alone is prescribed, every larger opening is an equilibrium, too.
  !> In that case move to the equilibrium with the smallest |s_N|.
  pure subroutine close_opening(joint, balance, point, updates)
    type(interface_type), intent(in) :: joint       !! the interface
    type(balance_type), intent(in) :: balance       !! the equations, the point at their start
    type(point_type), intent(inout) :: point        !! an equilibrium -> the one with the smallest |s_N|
    integer, intent(inout) :: updates               !! of the law
    type(kinematics_type) :: kinematics
    real(wp) :: edge(3), r(3), scale, step, whole(3)
    logical :: good
    integer :: k
    if (balance%n /= 1 .or. .not. balance%control%traction(1)) return
    if (balance%control%spring(1) > 0.0_wp .or. .not. dead_and_open(point)) return
    ! opening at which the first plane comes into contact
    whole = whole_separation(balance%given, point%state)
    edge = 0.0_wp
    do k = 1, joint%pattern%n
      kinematics = plane_kinematics(joint, k, whole, point%state)
      edge(1) = max(edge(1), kinematics%touch)
    end do
    step = spacing(max(edge(1), joint%material%s0))
    edge(1) = edge(1) - point%state(v_offset)
    do
      call evaluate(joint, balance, edge, point, r, scale, good)
      updates = updates + 1
      ! the comparison is exact, as every plane is fully damaged and open
      if (.not. good .or. .not. abs(point%traction(1)) > 0.0_wp) exit
      edge(1) = edge(1) + step
      step = 2.0_wp*step
    end do
  end subroutine close_opening

end module asperity_snap_motion
