!> Initial states: the separation at which a point, virgin or cracked, carries a traction before its first increment.
!>
!> That separation becomes the offset of STATEV 6-8 (contract), which the law adds to what the host calls separation.
module asperity_initial
  use asperity_call_checks, only: point_status, state_status
  use asperity_checks, only: bounded
  use asperity_contract, only: n_plane_statev, n_point_statev, plane_statev, status_ok, status_initial, &
    v_offset, v_status
  use asperity_interface, only: interface_type, separation_bound
  use asperity_kinds, only: wp
  use asperity_law, only: update_point
  use asperity_pattern, only: plane_normal
  use asperity_text, only: append, integer_text, to_text
  implicit none
  private
  public :: first_traction, carry_traction, explain_initial

  !> Parts the traction is applied in, proportionally: the slips of inclined planes follow a curved path.
  integer, parameter :: parts = 32
  !> Smallest share of the traction that is tried: the place of a fold is known as well as that.
  real(wp), parameter :: smallest_share = 2.0_wp**(-17)
  !> Largest growth of the damage of a plane in a part or a step of a motion: what grows more may be on another branch.
  real(wp), parameter :: most_growth = 0.05_wp
  !> Newton iterations per part.
  integer, parameter :: most_iterations = 25
  !> Residual accepted, relative to the terms that are summed: some hundred units in their last place. Separations that
  !> run away do not make it larger: `promised` of traction and strength (the contract says 1e-10), or `rounding`
  !> of the stiffest terms at the start.
  real(wp), parameter :: residual_tolerance = 1.0e-13_wp, promised = 5.0e-11_wp, rounding = 16.0_wp*epsilon(1.0_wp)
  !> Closure of planes that just touch, of s0.
  real(wp), parameter :: touch = 1.0e-6_wp
  !> Condition of a tangent beyond which it counts as singular.
  real(wp), parameter :: worst_condition = 1.0e9_wp
  !> Damping of a motion relative to the stiffness: range, change after a step that went well and one that did not.
  real(wp), parameter :: least_damping = 1.0e-13_wp, most_damping = 1.0e13_wp, less = 0.5_wp, more = 4.0_wp
  !> Steps of a motion, at most; how far it may go, of s_f and what the traction moves an elastic contact by.
  integer, parameter :: most_steps = 2000
  real(wp), parameter :: farthest = 1000.0_wp

contains

  !> Whether a point that was never called comes with a traction (contract, STATEV 5).
  !>
  !> Looked at by the bits: what is not finite is no traction, but what a host left undefined.
  pure function first_traction(traction, state) result(yes)
    real(wp), intent(in) :: traction(3)   !! (N, Tx, Ty), 0 where the host has no such component; any bits
    real(wp), intent(in) :: state(:)      !! STATEV
    logical :: yes
    yes = .not. abs(state(v_status)) > 0.0_wp
    if (yes) yes = all(bounded(traction, huge(1.0_wp)))
    if (yes) yes = any(abs(traction) > 0.0_wp)
  end function first_traction

  !> Give a state the offset at which it carries a traction; nothing is changed where it cannot.
  !>
  !> The traction grows proportionally from what the state carries at the separation it starts from: its offset, or, if
  !> that is zero, the one that fits the slips of its planes best. Damage, slips and energies follow that path; where it
  !> ends the point moves on under the traction held then, if there is a rest (docs/solver.md, "Snap"). What the host
  !> calls separation is taken as zero; where it is not, the caller takes it off the offset.
  pure subroutine carry_traction(joint, target, held, state, status, carried, endless)
    type(interface_type), intent(in) :: joint          !! the interface
    real(wp), intent(in) :: target(3)                  !! traction (N, Tx, Ty), stress
    logical, intent(in) :: held(3)                     !! whether it is to be carried; else the separation stays
    real(wp), intent(inout), contiguous :: state(:)    !! STATEV, offset, planes and energies are replaced
    integer, intent(out) :: status                     !! 0, status_initial, or those of state_status
    real(wp), intent(out), optional :: carried(3)      !! as much of the traction as was carried, stress
    logical, intent(out), optional :: endless          !! whether beyond that the planes part or slide without end; else
                                                       !! no rest was found in the steps allowed
    type(interface_type) :: rested
    real(wp), dimension(joint%n_statev) :: old, new
    real(wp) :: s(3), start(3), tangent(3, 3), goal(3), least, reached, next, step
    integer :: left
    logical :: good

    if (present(carried)) carried = 0.0_wp
    if (present(endless)) endless = .false.
    status = state_status(joint, state)
    if (status /= status_ok) return
    if (.not. all(bounded(merge(target, 0.0_wp, held), largest_traction(joint)))) status = status_initial
    if (status /= status_ok) return
    ! however long it took, it is over
    rested = joint
    rested%material%tau_v = 0.0_wp
    old = state(:joint%n_statev)
    s = old(v_offset:v_offset + 2)
    if (.not. any(abs(s) > 0.0_wp)) s = slipped_separation(joint, old, held)
    old(v_offset:v_offset + 2) = 0.0_wp
    call update_point(rested, s, s, old, new, start, tangent)
    old = new
    least = rounding*stiffest(rested)*largest_length(rested, s, old)
    reached = 0.0_wp
    step = 1.0_wp/real(parts, wp)
    left = most_steps
    do while (reached < 1.0_wp .and. left > 0)
      next = min(1.0_wp, reached + step)
      goal = target
      if (next < 1.0_wp) goal = start + next*(target - start)
      left = left - 1
      call take_step(rested, goal, held, 0.0_wp, least, s, old, good)
      if (.not. good .and. step <= smallest_share) call move_on(rested, goal, held, least, left, s, old, good)
      if (good) then
        reached = next
        step = min(2.0_wp*step, 1.0_wp/real(parts, wp))
        if (reached < 1.0_wp) cycle
        ! damage that the guard has held back on the way may grow where the point rests: from there again
        call update_point(rested, s, s, old, new, start, tangent)
        if (.not. any(new(n_point_statev + 1::n_plane_statev) > old(n_point_statev + 1::n_plane_statev))) cycle
        old = new
        reached = 0.0_wp
      else
        if (step <= smallest_share) exit
        step = max(smallest_share, 0.5_wp*step)
      end if
    end do
    if (present(carried)) carried = start + reached*(target - start)
    if (present(endless)) endless = left > 0
    if (reached < 1.0_wp) then
      status = status_initial
      return
    end if
    old(v_offset:v_offset + 2) = s
    old(v_status) = state(v_status)
    state(:joint%n_statev) = old
  end subroutine carry_traction

  !> No neighbouring separation carries the traction: the overdamped motion under it to the first rest, by implicit
  !> Euler steps.
  pure subroutine move_on(joint, goal, held, least, left, s, state, found)
    type(interface_type), intent(in) :: joint          !! the interface
    real(wp), intent(in) :: goal(3)                    !! traction that is held
    logical, intent(in) :: held(3)                     !! whether it is
    real(wp), intent(in) :: least                      !! residual that is small enough anyway, stress
    integer, intent(inout) :: left                     !! steps that may be taken; 0 if there is no way on
    real(wp), intent(inout) :: s(3)                    !! separation, start -> rest
    real(wp), intent(inout), contiguous :: state(:)    !! STATEV, start -> rest
    logical, intent(out) :: found                      !! whether there is a rest
    real(wp) :: damping, far, softest
    logical :: good
    found = .false.
    associate (m => joint%material)
      softest = max(tiny(softest), min(m%k_n, m%k_t, m%k_c))
      far = min(maxval(abs(goal), mask=held), softest*separation_bound(joint))/softest
      far = maxval(abs(s)) + farthest*(m%s0/(1.0_wp - m%eta) + far)
    end associate
    damping = 1.0_wp
    do while (left > 0 .and. maxval(abs(s)) < far .and. damping < most_damping)
      left = left - 1
      call take_step(joint, goal, held, 0.0_wp, least, s, state, found)
      if (found) return
      call take_step(joint, goal, held, damping*elastic(joint), least, s, state, good)
      damping = max(least_damping, merge(less, more, good)*damping)
    end do
    if (maxval(abs(s)) < far) left = 0
  end subroutine move_on

  !> Separation whose tangential parts fit the slips of the planes best (least squares with their weights), opened no
  !> more than the planes need to be clear of each other.
  pure function slipped_separation(joint, state, held) result(s)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in) :: state(:)                !! STATEV
    logical, intent(in) :: held(3)                  !! components that may move
    real(wp) :: s(3)
    real(wp) :: a(3, 3), b(3), n(3), t(3), h(3), opening
    integer :: i, j, k
    logical :: good
    s = 0.0_wp
    a = 0.0_wp
    b = 0.0_wp
    associate (pattern => joint%pattern)
      do k = 1, pattern%n
        i = plane_statev(k)
        t = [pattern%sin_theta(k), pattern%cos_theta(k)*pattern%e_x(k), pattern%cos_theta(k)*pattern%e_y(k)]
        h = [0.0_wp, pattern%h_x(k), pattern%h_y(k)]
        b = b + pattern%gamma(k)*(state(i + 1)*t + state(i + 2)*h)
        do j = 1, 3
          a(:, j) = a(:, j) + pattern%gamma(k)*(t*t(j) + h*h(j))
        end do
      end do
    end associate
    if (.not. any(abs(b) > 0.0_wp)) return
    ! a small stiffness against opening: planes that are all flat say nothing of it
    a(1, 1) = a(1, 1) + sqrt(epsilon(1.0_wp))
    call solve_linear(a, b, held, good)
    if (.not. good) return
    opening = 0.0_wp
    do k = 1, joint%pattern%n
      n = plane_normal(joint%pattern, k)
      ! no quotient of a plane that is nearly upright
      opening = max(opening, min(b(1)*n(1), max(0.0_wp, -dot_product(n(2:), b(2:))))/n(1))
    end do
    s = [opening, b(2:)]
  end function slipped_separation

  !> Separation at which the traction, and the resistance to the motion there, are the traction held; nothing is changed
  !> if none is found that is stable and near.
  pure subroutine take_step(joint, goal, held, damping, least, s, state, good)
    type(interface_type), intent(in) :: joint               !! the interface
    real(wp), intent(in) :: goal(3)                         !! traction that is held
    logical, intent(in) :: held(3)                          !! whether it is
    real(wp), intent(in) :: damping                         !! resistance to the motion, stress/length
    real(wp), intent(in) :: least                           !! residual that is small enough anyway, stress
    real(wp), intent(inout) :: s(3)                         !! separation, start -> end
    real(wp), intent(inout), contiguous :: state(:)         !! STATEV, start -> end
    logical, intent(out) :: good                            !! whether there is one
    real(wp), dimension(joint%n_statev) :: new
    real(wp) :: s_new(3), tangent(3, 3)
    s_new = s
    call solve(joint, goal, held, damping, least, s, state, s_new, new, tangent, good)
    if (.not. good .and. abs(joint%material%k_c - joint%material%k_n) > 0.0_wp) then
      ! where planes just touch, the tangent is that of the bond: from a little closure
      s_new = s
      if (held(1)) s_new(1) = s_new(1) - touch*joint%material%s0
      call solve(joint, goal, held, damping, least, s, state, s_new, new, tangent, good)
    end if
    if (good) good = .not. unstable(tangent, held, damping, elastic(joint))
    ! what the guard has held back comes at once
    if (good) good = joint%material%guard .or. &
      maxval(new(n_point_statev + 1::n_plane_statev) - state(n_point_statev + 1::n_plane_statev)) <= most_growth
    if (.not. good) return
    s = s_new
    state = new
  end subroutine take_step

  !> Newton's method with the consistent tangent.
  pure subroutine solve(joint, goal, held, damping, least, s_old, old, s, new, tangent, converged)
    type(interface_type), intent(in) :: joint               !! the interface
    real(wp), intent(in) :: goal(3)                         !! traction that is held
    logical, intent(in) :: held(3)                          !! whether it is
    real(wp), intent(in) :: damping                         !! resistance to the motion, stress/length
    real(wp), intent(in) :: least                           !! residual that is small enough anyway, stress
    real(wp), intent(in) :: s_old(3)                        !! separation at the start
    real(wp), intent(in), contiguous :: old(:)              !! STATEV at the start
    real(wp), intent(inout) :: s(3)                         !! guess -> separation at the end
    real(wp), intent(inout), contiguous :: new(:)           !! STATEV at the end
    real(wp), intent(out) :: tangent(3, 3)                  !! at the end
    logical, intent(out) :: converged                       !! whether the residual is small enough
    real(wp) :: b(3), s_trial(3), traction(3), residual, asked, summed
    integer :: iteration
    logical :: good, polished

    converged = .false.
    asked = maxval(abs(goal), mask=held) + joint%material%k_n*joint%material%s0
    s_trial = s
    do iteration = 1, most_iterations
      if (point_status(joint, s_old, s_trial, old) /= status_ok) return
      s = s_trial
      call update_point(joint, s_old, s, old, new, traction, tangent)
      b = merge(goal - traction - damping*(s - s_old), 0.0_wp, held)
      residual = maxval(abs(b))
      summed = asked + stiffest(joint)*largest_length(joint, s, new)
      polished = converged
      converged = residual <= max(least, min(residual_tolerance*summed, promised*asked))
      ! a step more costs little: to rounding
      if (converged .and. (polished .or. (iteration > 1 .and. residual <= rounding*asked))) return
      call newton_step(tangent, b, held, damping, elastic(joint), good)
      if (.not. good) return
      s_trial = s + b
    end do
  end subroutine solve

  !> Newton's step; where there is no stiffness in a direction, as along a frictionless plane, there is no step in it.
  pure subroutine newton_step(tangent, b, held, damping, stiffness, good)
    real(wp), intent(in) :: tangent(3, 3)   !! consistent tangent, stress/length
    real(wp), intent(inout) :: b(3)         !! residual -> step
    logical, intent(in) :: held(3)          !! components that may move
    real(wp), intent(in) :: damping         !! resistance to the motion, stress/length
    real(wp), intent(in) :: stiffness       !! of the elastic interface, stress/length
    logical, intent(out) :: good            !! false: there is none
    real(wp) :: r(3), a(3, 3), added
    integer :: i, j
    r = b
    added = damping
    do i = 1, 2
      a = tangent/stiffness
      do j = 1, 3
        a(j, j) = a(j, j) + added/stiffness
      end do
      b = r/stiffness
      call solve_linear(a, b, held, good)
      if (good) good = damping > 0.0_wp .or. maxval(abs(b))*stiffness <= worst_condition*maxval(abs(r))
      if (good) return
      added = damping + stiffness/worst_condition
    end do
  end subroutine newton_step

  !> Whether an overdamped motion leaves an equilibrium with this tangent (Routh and Hurwitz). Zero is not negative.
  pure function unstable(tangent, held, damping, stiffness) result(yes)
    real(wp), intent(in) :: tangent(3, 3)   !! consistent tangent, stress/length
    logical, intent(in) :: held(3)          !! components that may move
    real(wp), intent(in) :: damping         !! resistance to the motion, stress/length
    real(wp), intent(in) :: stiffness       !! of the elastic interface, stress/length
    logical :: yes
    !> Rounding of a sum over the planes and of products of three.
    real(wp), parameter :: least = -1.0e-12_wp
    real(wp) :: b(3, 3), first, second, third
    integer :: i
    b = tangent/stiffness
    do i = 1, 3
      b(i, i) = b(i, i) + damping/stiffness
      if (held(i)) cycle
      b(i, :) = 0.0_wp
      b(:, i) = 0.0_wp
      b(i, i) = 1.0_wp
    end do
    first = b(1, 1) + b(2, 2) + b(3, 3)
    second = b(1, 1)*b(2, 2) - b(1, 2)*b(2, 1) + b(1, 1)*b(3, 3) - b(1, 3)*b(3, 1) + b(2, 2)*b(3, 3) - b(2, 3)*b(3, 2)
    third = b(1, 1)*(b(2, 2)*b(3, 3) - b(2, 3)*b(3, 2)) - b(1, 2)*(b(2, 1)*b(3, 3) - b(2, 3)*b(3, 1)) + &
      b(1, 3)*(b(2, 1)*b(3, 2) - b(2, 2)*b(3, 1))
    yes = first < least .or. third < least .or. first*second - third < least
  end function unstable

  !> Largest traction that is tried: that of an elastic plane at the largest separation, stress.
  pure function largest_traction(joint) result(largest)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: largest
    largest = elastic(joint)*separation_bound(joint)
  end function largest_traction

  !> Elastic stiffness of a plane, stress/length.
  pure function elastic(joint) result(stiffness)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: stiffness
    stiffness = max(joint%material%k_n, joint%material%k_t)
  end function elastic

  !> The same or that of a closed plane, stress/length.
  pure function stiffest(joint) result(stiffness)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: stiffness
    stiffness = max(elastic(joint), joint%material%k_c)
  end function stiffest

  !> Largest separation or slip, length: what the rounding errors of the traction go with.
  pure function largest_length(joint, s, state) result(length)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in) :: s(3)                    !! separation
    real(wp), intent(in) :: state(:)                !! STATEV
    real(wp) :: length
    integer :: i
    length = maxval(abs(s))
    do i = n_point_statev + 2, joint%n_statev, n_plane_statev
      length = max(length, abs(state(i)), abs(state(i + 1)))
    end do
  end function largest_length

  !> Solve a x = b for the components that may move, by elimination with pivots; the others become 0. What is small
  !> counts as small beside 1.
  pure subroutine solve_linear(a, b, moves, good)
    real(wp), intent(inout) :: a(3, 3)   !! destroyed
    real(wp), intent(inout) :: b(3)      !! right-hand side -> x
    logical, intent(in) :: moves(3)      !! components of x that are free
    logical, intent(out) :: good         !! false: singular to rounding
    real(wp) :: row(3), factor, least
    integer :: i, j, p
    do i = 1, 3
      if (moves(i)) cycle
      a(i, :) = 0.0_wp
      a(:, i) = 0.0_wp
      a(i, i) = 1.0_wp
      b(i) = 0.0_wp
    end do
    least = epsilon(least)*max(1.0_wp, maxval(abs(a)))
    good = .true.
    do i = 1, 3
      if (.not. good) return
      p = i - 1 + maxloc(abs(a(i:, i)), dim=1)
      good = abs(a(p, i)) > least
      if (.not. good) return
      row = a(i, :)
      a(i, :) = a(p, :)
      a(p, :) = row
      factor = b(i)
      b(i) = b(p)
      b(p) = factor
      do j = i + 1, 3
        factor = a(j, i)/a(i, i)
        a(j, :) = a(j, :) - factor*a(i, :)
        b(j) = b(j) - factor*b(i)
      end do
    end do
    do i = 3, 1, -1
      b(i) = (b(i) - sum(a(i, i + 1:)*b(i + 1:)))/a(i, i)
    end do
  end subroutine solve_linear

  !> Say why a state cannot carry a traction, and how much of it it does; nothing is appended if it can.
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
    logical :: endless

    most = largest_traction(joint)
    do i = 1, 3
      if (.not. held(i) .or. bounded(target(i), most)) cycle
      call append(message, "initial " // trim(names(i)) // " = " // to_text(target(i)) // &
        ": expected a finite traction of magnitude up to " // to_text(most))
    end do
    if (.not. all(bounded(merge(target, 0.0_wp, held), most))) return
    pressed = state(:joint%n_statev)
    call carry_traction(joint, target, held, pressed, status, in_proportion, endless)
    if (status /= status_initial) return

    dead = count(state(n_point_statev + 1:joint%n_statev:n_plane_statev) >= 1.0_wp)
    allocate (character(len=0) :: reason)
    if (.not. endless) then
      reason = "no equilibrium was found"
    else if (dead < joint%pattern%n) then
      reason = "beyond the strength of the planes, of which " // integer_text(dead) // " of " // &
        integer_text(joint%pattern%n) // " are fully damaged"
    else if (target(1) > 0.0_wp) then
      reason = "tension on a crack, every plane being fully damaged"
    else
      reason = "outside the friction of the pattern"
    end if
    ! the normal traction first, to tell which part of the traction it is
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
