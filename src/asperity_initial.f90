!> Initial states: the separation at which a point, virgin or cracked, carries a traction before its first increment.
!>
!> That separation becomes the offset of STATEV 7-9 (contract), which the law adds to what the host calls separation.
module asperity_initial
  use asperity_checks, only: append, bounded, integer_text, to_text
  use asperity_contract, only: n_plane_statev, n_point_statev, plane_statev, status_ok, status_initial, &
    v_offset, v_status
  use asperity_interface, only: interface_type, point_status
  use asperity_kinds, only: wp
  use asperity_law, only: update_point
  implicit none
  private
  public :: first_traction, carry_traction, explain_initial

  !> Parts the traction is applied in, proportionally: the slips of inclined planes follow a curved path.
  integer, parameter :: parts = 32
  !> Smallest share of the traction that is tried: what a state can carry is told to this share.
  real(wp), parameter :: smallest_share = 2.0_wp**(-17)
  !> Newton iterations per part, and halvings of a Newton step that does not bring the residual down.
  integer, parameter :: most_iterations = 25, most_halvings = 6
  !> Residual accepted, relative to the terms that are summed: some hundred units in their last place.
  real(wp), parameter :: residual_tolerance = 1.0e-13_wp

contains

  !> Whether a point that was never called comes with a traction (contract, STATEV 6).
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
  !> that is zero, the one that fits the slips of its planes best. Damage, slips and energies follow that path.
  pure subroutine carry_traction(interface, target, held, state, status, share)
    type(interface_type), intent(in) :: interface      !! the interface
    real(wp), intent(in) :: target(3)                  !! traction (N, Tx, Ty), stress
    logical, intent(in) :: held(3)                     !! whether it is to be carried; else the separation stays
    real(wp), intent(inout), contiguous :: state(:)    !! STATEV, offset, planes and energies are replaced
    integer, intent(out) :: status                     !! 0, status_initial, or those of point_status
    real(wp), intent(out), optional :: share           !! of the traction that was carried, 1: all
    type(interface_type) :: rested
    real(wp), dimension(interface%n_statev) :: old, new
    real(wp) :: rest(3), s(3), s_new(3), start(3), traction(3), tangent(3, 3), goal(3), reached, next, step
    logical :: converged

    if (present(share)) share = 0.0_wp
    rest = 0.0_wp
    status = point_status(interface, rest, rest, state)
    if (status /= status_ok) return
    if (.not. all(bounded(target, huge(1.0_wp)))) status = status_initial
    if (status /= status_ok) return
    ! however long it took, it is over
    rested = interface
    rested%rie%material%tau_v = 0.0_wp
    old = state(:interface%n_statev)
    s = old(v_offset:v_offset + 2)
    if (.not. any(abs(s) > 0.0_wp)) s = slipped_separation(interface, old, held)
    old(v_offset:v_offset + 2) = 0.0_wp
    call update_point(rested%rie, s, s, old, new, start, tangent)
    old = new
    reached = 0.0_wp
    step = 1.0_wp/real(parts, wp)
    do while (reached < 1.0_wp .and. step >= smallest_share)
      next = min(1.0_wp, reached + step)
      goal = target
      if (next < 1.0_wp) goal = start + next*(target - start)
      s_new = s
      call solve(rested, goal, held, s, old, s_new, new, traction, tangent, converged)
      if (converged) then
        s = s_new
        old = new
        reached = next
        step = min(2.0_wp*step, 1.0_wp/real(parts, wp))
      else
        step = 0.5_wp*step
      end if
    end do
    if (present(share)) share = reached
    if (reached < 1.0_wp) then
      status = status_initial
      return
    end if
    old(v_offset:v_offset + 2) = s
    old(v_status) = state(v_status)
    state(:interface%n_statev) = old
  end subroutine carry_traction

  !> Separation whose tangential parts fit the slips of the planes best (least squares with their weights).
  pure function slipped_separation(interface, state, held) result(s)
    type(interface_type), intent(in) :: interface   !! the interface
    real(wp), intent(in) :: state(:)                !! STATEV
    logical, intent(in) :: held(3)                  !! components that may move
    real(wp) :: s(3)
    real(wp) :: a(3, 3), b(3), t(3), h(3)
    integer :: i, j, k
    logical :: good
    s = 0.0_wp
    a = 0.0_wp
    b = 0.0_wp
    associate (pattern => interface%rie%pattern)
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
    if (good) s = b
  end function slipped_separation

  !> Newton's method with the consistent tangent for one part; steps that do not bring the residual down are halved.
  pure subroutine solve(interface, goal, held, s_old, old, s, new, traction, tangent, converged)
    type(interface_type), intent(in) :: interface           !! the interface
    real(wp), intent(in) :: goal(3)                         !! traction to be carried
    logical, intent(in) :: held(3)                          !! whether it is
    real(wp), intent(in) :: s_old(3)                        !! separation at the start
    real(wp), intent(in), contiguous :: old(:)              !! STATEV at the start
    real(wp), intent(inout) :: s(3)                         !! guess -> separation at the end
    real(wp), intent(inout), contiguous :: new(:)           !! STATEV at the end
    real(wp), intent(inout) :: traction(3), tangent(3, 3)   !! at the end
    logical, intent(out) :: converged                       !! whether the residual is small enough
    real(wp) :: a(3, 3), b(3), s_trial(3), residual, last, scale
    integer :: halving, iteration
    logical :: good

    converged = .false.
    last = huge(last)
    s_trial = s
    do iteration = 1, most_iterations
      do halving = 0, most_halvings
        good = point_status(interface, s_old, s_trial, old) == status_ok
        residual = huge(residual)
        if (good) then
          call update_point(interface%rie, s_old, s_trial, old, new, traction, tangent)
          b = merge(goal - traction, 0.0_wp, held)
          residual = maxval(abs(b))
        end if
        if (residual < last .or. halving == most_halvings) exit
        s_trial = s + 0.5_wp*(s_trial - s)
      end do
      if (.not. good) return
      s = s_trial
      last = residual
      scale = max(interface%rie%material%k_n, interface%rie%material%k_t, interface%rie%material%k_c) &
              *largest_length(interface, s, new) + maxval(abs(goal))
      converged = residual <= residual_tolerance*scale
      if (converged) return
      a = tangent
      call solve_linear(a, b, held, good)
      if (.not. good) return
      s_trial = s + b
    end do
  end subroutine solve

  !> Largest separation or slip, length: what the rounding errors of the traction go with.
  pure function largest_length(interface, s, state) result(length)
    type(interface_type), intent(in) :: interface   !! the interface
    real(wp), intent(in) :: s(3)                    !! separation
    real(wp), intent(in) :: state(:)                !! STATEV
    real(wp) :: length
    integer :: i
    length = maxval(abs(s))
    do i = n_point_statev + 2, interface%n_statev, n_plane_statev
      length = max(length, abs(state(i)), abs(state(i + 1)))
    end do
  end function largest_length

  !> Solve a x = b for the components that may move, by elimination with pivots; the others become 0.
  pure subroutine solve_linear(a, b, moves, good)
    real(wp), intent(inout) :: a(3, 3)   !! destroyed
    real(wp), intent(inout) :: b(3)      !! right-hand side -> x
    logical, intent(in) :: moves(3)      !! components of x that are free
    logical, intent(out) :: good         !! false: singular to rounding
    real(wp) :: row(3), factor, largest
    integer :: i, j, p
    do i = 1, 3
      if (moves(i)) cycle
      a(i, :) = 0.0_wp
      a(:, i) = 0.0_wp
      a(i, i) = maxval(abs(a))
      b(i) = 0.0_wp
    end do
    largest = maxval(abs(a))
    good = largest > 0.0_wp
    do i = 1, 3
      if (.not. good) return
      p = i - 1 + maxloc(abs(a(i:, i)), dim=1)
      good = abs(a(p, i)) > epsilon(largest)*largest
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
  pure subroutine explain_initial(interface, target, held, state, message)
    type(interface_type), intent(in) :: interface              !! the interface
    real(wp), intent(in) :: target(3)                          !! traction (N, Tx, Ty), stress
    logical, intent(in) :: held(3)                             !! whether the traction is to be carried
    real(wp), intent(in), contiguous :: state(:)               !! STATEV
    character(len=:), allocatable, intent(inout) :: message    !! a line is appended
    character(len=4), parameter :: names(3) = ["t_N ", "t_Tx", "t_Ty"]
    character(len=:), allocatable :: reason
    real(wp), dimension(interface%n_statev) :: pressed, sheared
    real(wp) :: share
    logical :: wanted(3)
    integer :: dead, i, status

    wanted = held
    do i = 1, 3
      if (.not. held(i)) cycle
      wanted(i) = bounded(target(i), huge(1.0_wp))
      if (.not. wanted(i)) call append(message, "initial " // trim(names(i)) // " = " // to_text(target(i)) // &
        ": expected a finite traction")
    end do
    if (any(wanted .neqv. held)) return
    pressed = state(:interface%n_statev)
    call carry_traction(interface, target, held, pressed, status, share)
    if (status /= status_initial) return

    dead = 0
    do i = 1, interface%rie%pattern%n
      if (state(plane_statev(i)) >= 1.0_wp) dead = dead + 1
    end do
    allocate (character(len=0) :: reason)
    if (dead < interface%rie%pattern%n) then
      reason = "beyond the strength of the planes, of which " // integer_text(dead) // " of " // &
        integer_text(interface%rie%pattern%n) // " are fully damaged"
    else if (target(1) > 0.0_wp) then
      reason = "tension on a crack, every plane being fully damaged"
    else
      reason = "outside the friction of the pattern"
    end if
    ! the normal traction first, to tell which part of the traction it is
    pressed = state(:interface%n_statev)
    call carry_traction(interface, [target(1), 0.0_wp, 0.0_wp], held, pressed, status, share)
    if (status /= status_ok) then
      call append(message, "initial t_N = " // to_text(target(1)) // ": " // reason // "; it carries t_N = " // &
        to_text(share*target(1)))
      return
    end if
    sheared = pressed
    call carry_traction(interface, target, held, sheared, status, share)
    call append(message, "initial t_Tx, t_Ty = " // to_text(target(2)) // ", " // to_text(target(3)) // ": " // &
      reason // "; with t_N = " // to_text(target(1)) // " it carries " // to_text(share*target(2)) // ", " // &
      to_text(share*target(3)))
  end subroutine explain_initial

end module asperity_initial
