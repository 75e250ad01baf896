!> Initial states: the separation at which a point, virgin or damaged, carries a traction before its first increment.
!>
!> That separation is stored as the offset (STATEV 6-8), which the law adds to the separation of the host.
module asperity_initial
  use asperity_call_checks, only: state_status
  use asperity_checks, only: bounded
  use asperity_contract, only: n_statev, plane_statev, status_ok, status_initial, v_friction, v_offset, v_rupture, &
    v_status
  use asperity_control_point, only: balance_type, control_type, elastic_stiffness, move_point, point_type, &
    put_point, set_balance, traction_scale, unstable
  use asperity_elimination, only: eliminate
  use asperity_interface, only: interface_type, separation_bound
  use asperity_kinds, only: wp
  use asperity_law, only: kinematics_type, plane_kinematics
  use asperity_newton, only: newton_solve, newton_type
  use asperity_text, only: append, integer_text, set_text, to_text
  use asperity_tolerances, only: coarsest_initial_scale, farthest, finest_initial_scale, least_damping, less_damping, &
    longest_initial_step, more_damping, most_growth, residual_tolerance, rounding, smallest_initial_share, &
    worst_condition
  implicit none
  private
  public :: first_traction, carry_traction, explain_initial

  !> Number of equal sub-increments of the traction; several are needed, as the slips of inclined planes depend on the
  !> path.
  integer, parameter :: parts = 32
  !> Closure of planes that just touch, as a multiple of s0.
  real(wp), parameter :: touch = 1.0e-6_wp
  !> Largest number of steps of a motion.
  integer, parameter :: most_steps = 2000

contains

  !> Whether a point has an initial traction: STATEV 5 is 0 and the traction is finite and not zero.
  !>
  !> The test uses the bits: a traction that is not finite comes from an array that the host left undefined.
  pure function first_traction(traction, state) result(yes)
    real(wp), intent(in) :: traction(3)   !! (N, Tx, Ty), 0 where the host has no such component; any bits
    real(wp), intent(in) :: state(:)      !! STATEV
    logical :: yes
    yes = .not. abs(state(v_status)) > 0.0_wp
    if (yes) yes = all(bounded(traction, huge(1.0_wp)))
    if (yes) yes = any(abs(traction) > 0.0_wp)
  end function first_traction

  !> Set the offset of a state so that it carries a traction; the state does not change if it cannot carry it.
  !>
  !> The traction grows proportionally from the traction that the state carries at its offset or, if the offset is zero,
  !> at the separation that fits the slips of its planes best. Damage and slips follow that load path. Where the branch
  !> of equilibria ends, the point moves under constant traction to the next stable equilibrium, if there is one
  !> (docs/solver.md, "Snap"). Rupture and friction count from the initial state on, as nobody knows what it has cost.
  !> The separation of the host is assumed to be zero; if it is not, the caller subtracts it from the offset.
  pure subroutine carry_traction(joint, target, held, state, status, carried, endless)
    type(interface_type), intent(in) :: joint          !! the interface
    real(wp), intent(in) :: target(3)                  !! traction (N, Tx, Ty), stress
    logical, intent(in) :: held(3)                     !! true: prescribed; false: the separation is constant
    real(wp), intent(inout), contiguous :: state(:)    !! STATEV; offset, planes, damage and stored energy are
                                                       !! replaced
    integer, intent(out) :: status                     !! 0, status_initial, or those of state_status
    real(wp), intent(out), optional :: carried(3)      !! largest carried part of the traction, stress
    logical, intent(out), optional :: endless          !! whether planes open or slide without bound beyond
                                                       !! `carried`; if not, no stable equilibrium was found
    type(interface_type) :: rested
    type(control_type) :: control
    type(balance_type) :: balance
    type(point_type) :: trial
    real(wp) :: old(joint%n_statev), s(3), start(3), goal(3), reached, next, step
    integer :: left
    logical :: good

    if (present(carried)) carried = 0.0_wp
    if (present(endless)) endless = .false.
    status = state_status(joint, state)
    if (status /= status_ok) return
    if (any(held .and. .not. bounded(target, largest_traction(joint)))) status = status_initial
    if (status /= status_ok) return
    ! an initial state is in viscous equilibrium: no relaxation
    rested = joint
    rested%material%tau_v = 0.0_wp
    ! nor does the way to it wear the facets
    rested%material%inv_w0 = 0.0_wp
    old = state(:joint%n_statev)
    s = old(v_offset:v_offset + 2)
    if (.not. any(abs(s) > 0.0_wp)) s = slipped_separation(joint, old, held)
    old(v_offset:v_offset + 2) = 0.0_wp
    call put_point(rested, s, old, trial)
    start = trial%traction
    control%traction = held
    call set_balance(rested, control, s, balance)
    balance%finest = max(finest_initial_scale*joint%material%k_n*joint%material%s0, &
      rounding/residual_tolerance*traction_scale(rested, s, trial%state))
    balance%coarsest = coarsest_initial_scale
    balance%longest = longest_initial_step
    call move_point(trial, balance%old)
    reached = 0.0_wp
    step = 1.0_wp/real(parts, wp)
    left = most_steps
    do while (left > 0)
      next = min(1.0_wp, reached + step)
      goal = target
      if (next < 1.0_wp) goal = start + next*(target - start)
      balance%given = merge(goal, balance%old%s, held)
      left = left - 1
      call take_step(rested, 0.0_wp, balance, trial, good)
      if (.not. good .and. step <= smallest_initial_share) call move_on(rested, left, balance, trial, good)
      if (good) then
        reached = next
        step = min(2.0_wp*step, 1.0_wp/real(parts, wp))
        if (reached < 1.0_wp) cycle
        ! damage that the guard prevented on the load path may grow at its end: solve once more from there
        call put_point(rested, balance%old%s, balance%old%state, trial)
        if (.not. most_growth_of(joint, balance%old%state, trial%state) > 0.0_wp) exit
        start = trial%traction
        call move_point(trial, balance%old)
        reached = 0.0_wp
      else
        if (step <= smallest_initial_share) exit
        step = max(smallest_initial_share, 0.5_wp*step)
      end if
    end do
    if (present(carried)) carried = start + reached*(target - start)
    if (present(endless)) endless = left > 0
    if (reached < 1.0_wp) then
      status = status_initial
      return
    end if
    balance%old%state(v_offset:v_offset + 2) = balance%old%s
    balance%old%state([v_rupture, v_friction, v_status]) = state([v_rupture, v_friction, v_status])
    balance%old%state(n_statev(joint%pattern%n) + 1:) = state(n_statev(joint%pattern%n) + 1:joint%n_statev)
    state(:joint%n_statev) = balance%old%state
  end subroutine carry_traction

  !> Largest growth of the damage of a plane.
  pure function most_growth_of(joint, old, new) result(growth)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: old(:), new(:)   !! STATEV before and after
    real(wp) :: growth
    integer :: k
    growth = 0.0_wp
    do k = 1, joint%pattern%n
      growth = max(growth, new(plane_statev(k)) - max(old(plane_statev(k)), joint%material%damage0))
    end do
  end function most_growth_of

  !> Overdamped motion to the first stable equilibrium under the given traction, by implicit Euler steps, if no
  !> neighbouring separation carries that traction.
  pure subroutine move_on(joint, left, balance, trial, found)
    type(interface_type), intent(in) :: joint          !! the interface
    integer, intent(inout) :: left                     !! remaining steps; 0 if the motion cannot continue
    type(balance_type), intent(inout) :: balance       !! what is given; the point at the start -> in equilibrium
    type(point_type), intent(inout) :: trial           !! work space
    logical, intent(out) :: found                      !! whether there is an equilibrium
    real(wp) :: damping, far, softest
    logical :: good
    found = .false.
    associate (m => joint%material)
      softest = max(tiny(softest), min(m%k_n, m%k_t, m%k_c))
      far = min(maxval(abs(balance%given), mask=balance%control%traction), softest*separation_bound(joint))/softest
      far = maxval(abs(balance%old%s)) + farthest*(m%s0/(1.0_wp - m%eta) + far)
    end associate
    damping = 1.0_wp
    do while (left > 0 .and. maxval(abs(balance%old%s)) < far .and. damping < 1.0_wp/least_damping)
      left = left - 1
      call take_step(joint, 0.0_wp, balance, trial, found)
      if (found) return
      call take_step(joint, damping*elastic_stiffness(joint), balance, trial, good)
      damping = max(least_damping, merge(less_damping, more_damping, good)*damping)
    end do
    if (maxval(abs(balance%old%s)) < far) left = 0
  end subroutine move_on

  !> Separation at which the contacts of the planes fit the slips of the planes best (weighted least squares), with the
  !> smallest opening for which no plane is in contact. Gauss-Newton steps; one is enough where the planes are straight.
  pure function slipped_separation(joint, state, held) result(s)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in) :: state(:)                !! STATEV
    logical, intent(in) :: held(3)                  !! components that may move
    real(wp) :: s(3)
    integer, parameter :: most_fits = 20
    real(wp), parameter :: fitted = 1.0e-12_wp
    real(wp) :: a(3, 3), b(3), largest, opening
    type(kinematics_type) :: kinematics
    integer :: fits, i, j, k
    logical :: solved
    s = 0.0_wp
    do fits = 1, merge(most_fits, 1, joint%material%curved)
      a = 0.0_wp
      b = 0.0_wp
      do k = 1, joint%pattern%n
        i = plane_statev(k)
        kinematics = plane_kinematics(joint, k, s, state)
        associate (t => kinematics%gradient(2, :), h => kinematics%gradient(3, :), gamma => joint%pattern%gamma(k))
          b = b + gamma*((state(i + 1) - kinematics%contact(2))*t + (state(i + 2) - kinematics%contact(3))*h)
          do j = 1, 3
            a(:, j) = a(:, j) + gamma*(t*t(j) + h*h(j))
          end do
        end associate
      end do
      if (.not. any(abs(b) > 0.0_wp)) return
      ! a small stiffness in the normal direction, as flat planes do not determine the opening
      a(1, 1) = a(1, 1) + sqrt(epsilon(1.0_wp))
      do i = 1, 3
        if (held(i)) cycle
        a(i, :) = 0.0_wp
        a(:, i) = 0.0_wp
        a(i, i) = 1.0_wp
        b(i) = 0.0_wp
      end do
      largest = maxval(abs(b))
      call eliminate(3, a, b, solved)
      if (solved) solved = maxval(abs(b)) <= worst_condition*largest
      if (.not. solved) return
      s = s + b
      if (maxval(abs(b)) <= fitted*maxval(abs(s))) exit
    end do
    opening = 0.0_wp
    do k = 1, joint%pattern%n
      kinematics = plane_kinematics(joint, k, s, state)
      opening = max(opening, min(s(1), kinematics%touch))
    end do
    s(1) = opening
  end function slipped_separation

  !> One step to the separation at which the traction plus the damping of the motion equals the given traction. The
  !> point does not change if no stable solution is found near it.
  pure subroutine take_step(joint, damping, balance, trial, good)
    type(interface_type), intent(in) :: joint               !! the interface
    real(wp), intent(in) :: damping                         !! resistance to the motion, stress/length
    type(balance_type), intent(inout) :: balance            !! what is given; the point at the start -> at the end
    type(point_type), intent(inout) :: trial                !! work space
    logical, intent(out) :: good                            !! whether there is one
    type(newton_type) :: result
    real(wp) :: fine
    ! residual at which a further Newton step is omitted
    fine = rounding*(joint%material%k_n*joint%material%s0 + maxval(abs(balance%given), mask=balance%control%traction))
    balance%damping = damping
    trial%s = balance%old%s
    call newton_solve(joint, balance, .false., trial, result, fine)
    if (.not. result%converged .and. abs(joint%material%k_c - joint%material%k_n) > 0.0_wp) then
      ! planes that just touch have the tangent of the bond: start again from a small closure
      trial%s = balance%old%s
      trial%s(1) = trial%s(1) - touch*joint%material%s0
      call newton_solve(joint, balance, .false., trial, result, fine)
    end if
    good = result%converged .and. .not. unstable(balance%n, result%last, elastic_stiffness(joint))
    ! with the guard, damage that was prevented earlier may grow by any amount in one step
    if (good) good = joint%material%guard .or. &
      most_growth_of(joint, balance%old%state, trial%state) <= most_growth
    if (good) call move_point(trial, balance%old)
  end subroutine take_step

  !> Largest admissible traction: that of an elastic plane at the largest separation, stress.
  pure function largest_traction(joint) result(largest)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: largest
    largest = elastic_stiffness(joint)*separation_bound(joint)
  end function largest_traction

  !> Append why a state cannot carry a traction and what it carries; nothing is appended if it can carry the traction.
  pure subroutine explain_initial(joint, target, held, state, message)
    type(interface_type), intent(in) :: joint                  !! the interface
    real(wp), intent(in) :: target(3)                          !! traction (N, Tx, Ty), stress
    logical, intent(in) :: held(3)                             !! whether the traction is to be carried
    real(wp), intent(in), contiguous :: state(:)               !! STATEV
    character(len=:), allocatable, intent(inout) :: message    !! a line is appended
    character(len=4), parameter :: names(3) = ["t_N ", "t_Tx", "t_Ty"]
    character(len=:), allocatable :: reason
    real(wp), dimension(joint%n_statev) :: pressed
    real(wp) :: carried(3), in_proportion(3), most
    integer :: dead, i, status
    logical :: endless, excessive(3)

    most = largest_traction(joint)
    excessive = held .and. .not. bounded(target, most)
    do i = 1, 3
      if (excessive(i)) call append(message, "initial " // trim(names(i)) // " = " // to_text(target(i)) // &
        ": expected a finite traction of magnitude up to " // to_text(most))
    end do
    if (any(excessive)) return
    pressed = state(:joint%n_statev)
    call carry_traction(joint, target, held, pressed, status, in_proportion, endless)
    if (status /= status_initial) return

    dead = count([(state(plane_statev(i)) >= 1.0_wp, i=1, joint%pattern%n)])
    if (.not. endless) then
      call set_text(reason, "no equilibrium was found")
    else if (dead < joint%pattern%n) then
      call set_text(reason, "beyond the strength of the planes, of which " // integer_text(dead) // " of " // &
        integer_text(joint%pattern%n) // " are fully damaged")
    else if (target(1) > 0.0_wp) then
      call set_text(reason, "tension on a crack, every plane being fully damaged")
    else
      call set_text(reason, "outside the friction of the pattern")
    end if
    ! the normal traction first, to find out which component is not carried
    call carry_traction(joint, [target(1), 0.0_wp, 0.0_wp], held, pressed, status, carried)
    if (status /= status_ok) then
      call append(message, "initial t_N = " // to_text(target(1)) // ": " // reason // "; it carries t_N = " // &
        to_text(carried(1)))
      return
    end if
    call carry_traction(joint, target, held, pressed, status, carried)
    if (status == status_ok) then
      call append(message, "initial t_N, t_Tx, t_Ty = " // triple(target) // &
        ": no equilibrium where it grows in proportion; it carries " // triple(in_proportion))
      return
    end if
    call append(message, "initial t_Tx, t_Ty = " // to_text(target(2)) // ", " // to_text(target(3)) // ": " // &
      reason // "; with t_N = " // to_text(target(1)) // " it carries " // to_text(carried(2)) // ", " // &
      to_text(carried(3)))

  contains

    !> Text of three numbers.
    pure function triple(x) result(text)
      real(wp), intent(in) :: x(3)   !! any bits
      character(len=len(to_text(x(1))) + len(to_text(x(2))) + len(to_text(x(3))) + 4) :: text
      text = to_text(x(1)) // ", " // to_text(x(2)) // ", " // to_text(x(3))
    end function triple

  end subroutine explain_initial

end module asperity_initial
