!> One point under mixed control: some components of the separation given, for the others the traction.
!>
!> Newton's method with the consistent tangent on the free separations; an increment that does not converge is halved.
!> Which root is taken where t_N alone is held: docs/theory.md, "Root".
module mixed_control
  use asperity_checks, only: bounded
  use asperity_contract, only: plane_statev, status_ok
  use asperity_interface, only: interface_type, point_status
  use asperity_kinds, only: wp
  use asperity_law, only: update_point
  implicit none
  private
  public :: control_type, point_type, new_point, advance, snapped, direction_vector, confined_slip

  !> What is held of each component (N, Tx, Ty), and how long an increment takes.
  type :: control_type
    logical :: traction(3) = .false.   !! true: traction + spring*separation is given, false: the separation is
    real(wp) :: spring(3) = 0.0_wp     !! stiffness of a surrounding spring (CNS), stress/length
    real(wp) :: dt = 0.0_wp            !! duration of the increment (viscous damage only), >= 0, time
  end type control_type

  !> A point and what it carries.
  type :: point_type
    real(wp) :: s(3) = 0.0_wp             !! separation (N, Tx, Ty), length
    real(wp) :: traction(3) = 0.0_wp      !! stress
    real(wp) :: tangent(3, 3) = 0.0_wp    !! stress/length
    real(wp), allocatable :: state(:)     !! STATEV
  end type point_type

  !> Newton iterations before an increment is halved: quadratic convergence needs fewer than 10, switches add a few.
  integer, parameter, public :: max_iterations = 25
  !> Smallest part of an increment that is tried.
  real(wp), parameter :: min_fraction = 2.0_wp**(-20)
  !> Residual accepted, relative to K max(|s|, |s_di|) + |target|: some hundred units in the last place of the terms
  !> that are summed over the planes.
  real(wp), parameter, public :: residual_tolerance = 1.0e-13_wp
  !> Largest given value that is tried: differences of two stay finite.
  real(wp), parameter :: largest_target = 0.25_wp*huge(1.0_wp)

  interface
    !> LAPACK: solve A x = b.
    pure subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
      import :: wp
      implicit none
      integer, intent(in) :: n, nrhs, lda, ldb
      real(wp), intent(inout) :: a(lda, n), b(ldb, nrhs)
      integer, intent(out) :: ipiv(n), info
    end subroutine dgesv
  end interface

contains

  !> A virgin point at rest, or one that starts from a state at separation zero.
  pure function new_point(interface, state) result(point)
    type(interface_type), intent(in) :: interface     !! the interface
    real(wp), intent(in), optional :: state(:)        !! STATEV to start from
    type(point_type) :: point
    real(wp), parameter :: rest(3) = 0.0_wp
    real(wp) :: old(interface%n_statev)
    old = 0.0_wp
    if (present(state)) old = state(:interface%n_statev)
    allocate (point%state(interface%n_statev))
    call update_point(interface%rie, rest, rest, old, point%state, point%traction, point%tangent)
  end function new_point

  !> Take a point from the given values `start` to `target`, in parts where that is needed.
  !>
  !> Where no neighbouring equilibrium is left and t_N alone is held, s_N moves to the first one in the sense in which
  !> the traction is missing. If there is none it stays at the last part that converged and `reached` is below 1.
  pure subroutine advance(interface, control, start, target, point, iterations, reached, parts, residuals)
    type(interface_type), intent(in) :: interface   !! the interface
    type(control_type), intent(in) :: control       !! what is given
    real(wp), intent(in) :: start(3)                !! given values now: separation, or traction + spring*separation
    real(wp), intent(in) :: target(3)               !! given values at the end
    type(point_type), intent(inout) :: point        !! the point, start -> end
    integer, intent(out) :: iterations              !! Newton iterations over all parts, failed ones included
    real(wp), intent(out) :: reached                !! share of the increment that converged, 1: all
    integer, intent(out), optional :: parts         !! parts that converged, 1: the increment was solved whole
    real(wp), intent(out), optional :: residuals(0:max_iterations)   !! of the last part tried, relative to the scale of
                                                                     !! `residual_tolerance`; -1 where none was needed
    real(wp) :: fraction, next, history(0:max_iterations)
    type(control_type) :: part   ! a part takes its share of the time
    type(point_type) :: trial
    integer :: solved, used
    logical :: converged

    iterations = 0
    solved = 0
    reached = 0.0_wp
    history = -1.0_wp
    part = control
    fraction = 1.0_wp
    if (.not. all(bounded(target, largest_target))) fraction = 0.0_wp
    do while (reached < 1.0_wp .and. fraction >= min_fraction)
      next = min(1.0_wp, reached + fraction)
      trial = point
      part%dt = (next - reached)*control%dt
      if (next < 1.0_wp) then
        call solve(interface, part, start + next*(target - start), point, trial, used, converged, history)
      else
        call solve(interface, part, target, point, trial, used, converged, history)
      end if
      iterations = iterations + used
      if (converged) then
        point = trial
        reached = next
        solved = solved + 1
        fraction = 2.0_wp*fraction
      else
        fraction = 0.5_wp*fraction
      end if
    end do
    if (reached < 1.0_wp .and. normal_alone(control) .and. all(bounded(target, largest_target))) then
      trial = point
      part%dt = (1.0_wp - reached)*control%dt
      call march(interface, part, target, point, trial, used, converged)
      iterations = iterations + used
      if (converged) then
        point = trial
        reached = 1.0_wp
        solved = solved + 1
      end if
    end if
    if (present(parts)) parts = solved
    if (present(residuals)) residuals = history
  end subroutine advance

  !> Whether the traction of N is held and the separations of Tx and Ty are given.
  pure function normal_alone(control) result(yes)
    type(control_type), intent(in) :: control   !! what is given
    logical :: yes
    yes = control%traction(1) .and. .not. any(control%traction(2:3))
  end function normal_alone

  !> Whether s_N moved farther than the change of what is given explains: a snap, a jumped fold, or a branch as steep.
  !>
  !> The limit is ten times the largest change of a given separation, or of a given traction over the elastic stiffness,
  !> and half a hundredth of s_f.
  pure function snapped(interface, control, start, target, s_n_old, s_n) result(yes)
    type(interface_type), intent(in) :: interface   !! the interface
    type(control_type), intent(in) :: control       !! what is given
    real(wp), intent(in) :: start(3), target(3)     !! given values before and now
    real(wp), intent(in) :: s_n_old, s_n            !! normal separation before and now, length
    logical :: yes
    real(wp), parameter :: factor = 10.0_wp, share = 0.005_wp
    real(wp) :: change(3)
    yes = .false.
    if (.not. control%traction(1)) return
    associate (material => interface%rie%material)
      change = abs(target - start)
      where (control%traction) change = change/min(material%k_n, material%k_t)
      yes = abs(s_n - s_n_old) > factor*maxval(change) + share*material%s0/(1.0_wp - material%eta)
    end associate
  end function snapped

  !> Residual of the held t_N, relative to the scale of `residual_tolerance`, at a separation s_N.
  pure subroutine try(interface, control, target, s_n, old, new, residual, good)
    type(interface_type), intent(in) :: interface   !! the interface
    type(control_type), intent(in) :: control       !! what is given: t_N alone is held
    real(wp), intent(in) :: target(3)               !! given values
    real(wp), intent(in) :: s_n                     !! normal separation, length
    type(point_type), intent(in) :: old             !! the point at the start
    type(point_type), intent(inout) :: new          !! the point with that separation
    real(wp), intent(out) :: residual               !! traction + spring*separation - target, relative
    logical, intent(out) :: good                    !! whether the law takes the separation
    real(wp) :: scale
    new%s = [s_n, target(2:3)]
    residual = 0.0_wp
    good = point_status(interface, old%s, new%s, old%state) == status_ok
    if (.not. good) return
    call update_point(interface%rie, old%s, new%s, old%state, new%state, new%traction, new%tangent, control%dt)
    scale = traction_scale(interface, new) + abs(target(1))
    residual = (new%traction(1) + control%spring(1)*new%s(1) - target(1))/max(scale, tiny(scale))
  end subroutine try

  !> Move s_N in the sense of the traction that is missing, to the first equilibrium.
  pure subroutine march(interface, control, target, old, new, tries, converged)
    type(interface_type), intent(in) :: interface   !! the interface
    type(control_type), intent(in) :: control       !! what is given: t_N alone is held
    real(wp), intent(in) :: target(3)               !! given values
    type(point_type), intent(in) :: old             !! the point at the start
    type(point_type), intent(inout) :: new          !! the point at the end
    integer, intent(out) :: tries                   !! updates of the point
    logical, intent(out) :: converged               !! whether there is an equilibrium
    !> From a twentieth of s0, growing: 800 steps reach ten million s0.
    integer, parameter :: most_steps = 800
    real(wp), parameter :: first_step = 0.05_wp, growth = 1.02_wp
    real(wp) :: near, far, middle, step, residual, sense
    logical :: good

    near = old%s(1)
    call try(interface, control, target, near, old, new, residual, good)
    tries = 1
    converged = good .and. abs(residual) <= residual_tolerance
    if (converged .or. .not. good) return
    sense = -sign(1.0_wp, residual)
    step = first_step*interface%rie%material%s0
    far = near
    do while (good .and. sense*residual < -residual_tolerance .and. tries < most_steps)
      near = far
      far = near + sense*step
      step = growth*step
      call try(interface, control, target, far, old, new, residual, good)
      tries = tries + 1
    end do
    if (.not. good .or. sense*residual < -residual_tolerance) return
    ! the first equilibrium lies between near (short of it) and far: where the traction is no longer missing
    do
      middle = near + 0.5_wp*(far - near)
      if (.not. (abs(middle - near) > 0.0_wp .and. abs(middle - far) > 0.0_wp)) exit
      call try(interface, control, target, middle, old, new, residual, good)
      tries = tries + 1
      if (sense*residual < -residual_tolerance) then
        near = middle
      else
        far = middle
      end if
    end do
    call try(interface, control, target, far, old, new, residual, good)
    converged = good .and. abs(residual) <= residual_tolerance
  end subroutine march

  !> Where all is open and dead, every other opening is an equilibrium, too: go to the one with the smallest |s_N|.
  pure subroutine settle(interface, control, target, old, new)
    type(interface_type), intent(in) :: interface   !! the interface
    type(control_type), intent(in) :: control       !! what is given: t_N alone is held
    real(wp), intent(in) :: target(3)               !! given values
    type(point_type), intent(in) :: old             !! the point at the start
    type(point_type), intent(inout) :: new          !! an equilibrium without traction and stiffness -> that one
    real(wp) :: closed, open, middle, residual
    logical :: good
    open = new%s(1)
    closed = 0.0_wp
    call try(interface, control, target, closed, old, new, residual, good)
    if (good .and. free()) return
    ! the edge, where contact begins
    do
      middle = closed + 0.5_wp*(open - closed)
      if (.not. (abs(middle - closed) > 0.0_wp .and. abs(middle - open) > 0.0_wp)) exit
      call try(interface, control, target, middle, old, new, residual, good)
      if (good .and. free()) then
        open = middle
      else
        closed = middle
      end if
    end do
    call try(interface, control, target, open, old, new, residual, good)

  contains

    !> Whether the point carries nothing: exact, since every plane is dead and open.
    pure function free() result(yes)
      logical :: yes
      yes = .not. abs(new%traction(1)) > 0.0_wp
    end function free

  end subroutine settle

  !> Newton's method for one part of an increment.
  pure subroutine solve(interface, control, target, old, new, iterations, converged, history)
    type(interface_type), intent(in) :: interface   !! the interface
    type(control_type), intent(in) :: control       !! what is given
    real(wp), intent(in) :: target(3)               !! given values
    type(point_type), intent(in) :: old             !! the point at the start
    type(point_type), intent(inout) :: new          !! guess -> the point at the end
    integer, intent(out) :: iterations              !! tangent solves
    logical, intent(out) :: converged               !! whether the residual is small enough
    real(wp), intent(out) :: history(0:max_iterations)   !! relative residuals, -1 where none was needed
    real(wp) :: residual(3), a(3, 3), b(3), scale
    integer :: free(3), pivots(3), i, info, n

    n = 0
    do i = 1, 3
      if (control%traction(i)) then
        n = n + 1
        free(n) = i
      else
        new%s(i) = target(i)
      end if
    end do
    converged = .false.
    history = -1.0_wp
    do iterations = 0, max_iterations
      if (point_status(interface, old%s, new%s, old%state) /= status_ok) return
      call update_point(interface%rie, old%s, new%s, old%state, new%state, new%traction, new%tangent, control%dt)
      residual = merge(new%traction + control%spring*new%s - target, 0.0_wp, control%traction)
      scale = traction_scale(interface, new) + maxval(abs(target), mask=control%traction)
      history(iterations) = maxval(abs(residual))/max(scale, tiny(scale))
      converged = history(iterations) <= residual_tolerance
      if (converged .and. normal_alone(control)) then
        if (.not. (abs(new%tangent(1, 1) + control%spring(1)) > 0.0_wp .or. abs(new%traction(1)) > 0.0_wp)) then
          call settle(interface, control, target, old, new)
        end if
      end if
      if (converged .or. iterations == max_iterations) return
      b(:n) = -residual(free(:n))
      a(:n, :n) = new%tangent(free(:n), free(:n))
      do i = 1, n
        a(i, i) = a(i, i) + control%spring(free(i))
      end do
      call dgesv(n, 1, a, 3, pivots, b, 3, info)
      if (info /= 0) return
      new%s(free(:n)) = new%s(free(:n)) + b(:n)
    end do
  end subroutine solve

  !> Size of the terms that are summed to the traction of a point, stress: what their rounding errors go with.
  pure function traction_scale(interface, point) result(scale)
    type(interface_type), intent(in) :: interface   !! the interface
    type(point_type), intent(in) :: point           !! the point
    real(wp) :: scale
    real(wp) :: largest
    integer :: i, k
    largest = maxval(abs(point%s))
    do k = 1, interface%rie%pattern%n
      i = plane_statev(k)
      largest = max(largest, abs(point%state(i + 1)), abs(point%state(i + 2)))
    end do
    scale = max(interface%rie%material%k_n, interface%rie%material%k_t, interface%rie%material%k_c)*largest
  end function traction_scale

  !> Unit vector (Tx, Ty) at an angle from Tx towards Ty; exact along the axes.
  pure function direction_vector(direction) result(e)
    real(wp), intent(in) :: direction   !! degrees
    real(wp) :: e(2)
    real(wp), parameter :: degree = acos(-1.0_wp)/180.0_wp
    real(wp) :: angle
    integer :: i, quarter
    angle = modulo(direction, 360.0_wp)
    quarter = nint(angle/90.0_wp)
    angle = (angle - 90.0_wp*real(quarter, wp))*degree
    e = [cos(angle), sin(angle)]
    do i = 1, modulo(quarter, 4)
      e = [0.0_wp - e(2), e(1)]
    end do
  end function direction_vector

  !> Confined slip test: the normal traction is applied to a virgin point at zero slip and held, then the point follows
  !> slips along a direction in the Tx-Ty plane, the slip across it being zero.
  !>
  !> Where equilibrium is lost the path ends: rows beyond n_done are zero.
  pure subroutine confined_slip(interface, direction, slips, sigma_n, preload, separation, traction, state, &
                                iterations, n_done, times, preload_time)
    type(interface_type), intent(in) :: interface   !! the interface
    real(wp), intent(in) :: direction               !! from Tx towards Ty, degrees
    real(wp), intent(in) :: slips(:)                !! (T) slips in their order, length
    real(wp), intent(in) :: sigma_n                 !! normal traction, stress
    integer, intent(in) :: preload                  !! increments of the preload, >= 1 (100 for energies to four digits)
    real(wp), intent(out) :: separation(:, :)       !! (3, T) separation (N, Tx, Ty), length
    real(wp), intent(out) :: traction(:, :)         !! (3, T) traction (N, Tx, Ty), stress
    real(wp), intent(out) :: state(:, :)            !! (nstatv, T) STATEV
    integer, intent(out) :: iterations(:)           !! (T) Newton iterations
    integer, intent(out) :: n_done                  !! slips that converged; fewer than T: equilibrium lost;
                                                    !! -1: by the preload, or a direction that is no number
    real(wp), intent(in), optional :: times(:)      !! (T) of the slips from the end of the preload on, not decreasing,
                                                    !! time; absent: no time passes
    real(wp), intent(in), optional :: preload_time  !! duration of the preload, >= 0, time; absent: 0
    type(control_type) :: control
    type(point_type) :: point
    real(wp) :: start(3), target(3), now, reached
    integer :: i, used

    separation = 0.0_wp
    traction = 0.0_wp
    state = 0.0_wp
    iterations = 0
    n_done = -1
    if (.not. bounded(direction, huge(direction))) return
    control%traction(1) = .true.
    if (present(preload_time)) control%dt = preload_time/real(preload, wp)
    point = new_point(interface)
    target = 0.0_wp
    do i = 1, preload
      start = target
      target(1) = sigma_n*(real(i, wp)/real(preload, wp))
      call advance(interface, control, start, target, point, used, reached)
      if (reached < 1.0_wp) return
    end do
    n_done = 0
    control%dt = 0.0_wp
    now = 0.0_wp
    do i = 1, size(slips)
      if (present(times)) then
        control%dt = times(i) - now
        now = times(i)
      end if
      start = target
      target(2:3) = slips(i)*direction_vector(direction)
      call advance(interface, control, start, target, point, iterations(i), reached)
      if (reached < 1.0_wp) return
      separation(:, i) = point%s
      traction(:, i) = point%traction
      state(:interface%n_statev, i) = point%state
      n_done = i
    end do
  end subroutine confined_slip

end module mixed_control
