!> Newton's method without safeguards, as in a simple FE code: one point under mixed control with the given increments,
!> without cuts, line search or check of the branch. The solver of asperity_mixed_control is compared with it.
module asperity_naive_newton
  use asperity_contract, only: plane_statev, status_ok
  use asperity_control_point, only: control_type, new_point, point_type
  use asperity_elimination, only: eliminate
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_law, only: update_point
  use asperity_pattern, only: plane_normal
  use asperity_call_checks, only: point_status
  implicit none
  private
  public :: newton_path

  !> Matrices that replace the tangent.
  integer, parameter, public :: &
    consistent = 1, &    !! that of the law
    symmetrised = 2, &   !! its symmetric part
    transposed = 3, &    !! its transpose
    secant = 4, &        !! traction over separation at constant damage and slip, symmetric
    at_start = 5, &      !! the consistent one at the start of the increment (modified Newton)
    elastic = 6, &       !! that of the virgin interface
    numerical = 7, &     !! central differences of the traction
    zero = 8, &          !! zero, as if the user routine did not define the tangent
    reversed = 9         !! the consistent one with the wrong sign

  !> Their names, by number.
  character(len=12), parameter, public :: tangent_names(9) = [character(len=12) :: "consistent", "symmetrised", &
    "transposed", "secant", "start", "elastic", "numerical", "zero", "reversed"]

  !> How an increment ended.
  integer, parameter, public :: &
    converged = 0, &      !! the residual is small enough
    no_end = 1, &         !! too many iterations
    singular = 2, &       !! the matrix has no inverse
    out_of_range = 3      !! the separation left the range of the law

  !> Step of the differences, as a multiple of s0: truncation and rounding errors are below 1e-8 K for s up to 100 s0.
  real(wp), parameter :: difference = 1.0e-6_wp

contains

  !> Take a virgin point through given values, one increment each, up to the first increment that fails.
  !>
  !> Residuals are relative to the strength of the interface plus the largest given traction, stress over stress.
  pure subroutine newton_path(joint, control, targets, durations, kind, tolerance, separation, traction, state, &
                              iterations, updates, residuals, n_done, ended)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given; its duration is not used
    real(wp), intent(in) :: targets(:, :)           !! (3, T) separation, or traction + spring*separation
    real(wp), intent(in) :: durations(:)            !! (T) of the increments (viscous damage only), time
    integer, intent(in) :: kind                     !! which tangent, 1 to 9
    real(wp), intent(in) :: tolerance               !! residual that is accepted, relative
    real(wp), intent(out) :: separation(:, :)       !! (3, T) length; that of an increment that failed is its last trial
    real(wp), intent(out) :: traction(:, :)         !! (3, T) stress
    real(wp), intent(out) :: state(:, :)            !! (nstatv, T) STATEV
    integer, intent(out) :: iterations(:)           !! (T) linear systems solved
    integer, intent(out) :: updates(:)              !! (T) updates of the law
    real(wp), intent(out) :: residuals(0:, :)       !! (0:most, T) relative, -1: not computed
    integer, intent(out) :: n_done                  !! increments that converged
    integer, intent(out) :: ended                   !! how the last one ended: converged, no_end, singular, out_of_range
    type(control_type) :: now
    type(point_type) :: point, trial
    integer :: i

    separation = 0.0_wp
    traction = 0.0_wp
    state = 0.0_wp
    iterations = 0
    updates = 0
    residuals = -1.0_wp
    n_done = 0
    ended = converged
    point = new_point(joint)
    now = control
    do i = 1, size(targets, 2)
      trial = point
      now%dt = durations(i)
      call newton(joint, now, targets(:, i), kind, tolerance, point, trial, iterations(i), updates(i), &
        residuals(:, i), ended)
      separation(:, i) = trial%s
      traction(:, i) = trial%traction
      state(:joint%n_statev, i) = trial%state
      if (ended /= converged) return
      point = trial
      n_done = i
    end do
  end subroutine newton_path

  !> Solve one increment.
  pure subroutine newton(joint, control, target, kind, tolerance, old, new, iterations, updates, residuals, ended)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given
    real(wp), intent(in) :: target(3)               !! given values
    integer, intent(in) :: kind                     !! which tangent
    real(wp), intent(in) :: tolerance               !! residual that is accepted, relative
    type(point_type), intent(in) :: old             !! the point at the start
    type(point_type), intent(inout) :: new          !! old -> the point at the end
    integer, intent(out) :: iterations              !! linear systems solved
    integer, intent(out) :: updates                 !! number of updates of the law
    real(wp), intent(out) :: residuals(0:)          !! relative, -1: not computed
    integer, intent(out) :: ended                   !! how it ended
    real(wp) :: a(3, 3), change(3), matrix(3, 3), residual(3), scale
    integer :: free(3), i, n
    logical :: good

    n = 0
    do i = 1, 3
      if (control%traction(i)) then
        n = n + 1
        free(n) = i
      else
        new%s(i) = target(i)
      end if
    end do
    associate (material => joint%material)
      scale = min(material%k_n, material%k_t)*material%s0 + sum(abs(target), mask=control%traction)
    end associate
    residuals = -1.0_wp
    updates = 0
    do iterations = 0, ubound(residuals, 1)
      ended = out_of_range
      if (point_status(joint, old%s, new%s, old%state) /= status_ok) return
      call update_point(joint, old%s, new%s, old%state, new%state, new%traction, new%tangent, &
        control%dt)
      updates = updates + 1
      residual = merge(new%traction + control%spring*new%s - target, 0.0_wp, control%traction)
      residuals(iterations) = maxval(abs(residual))/scale
      ended = converged
      if (residuals(iterations) <= tolerance) return
      ended = no_end
      if (iterations == ubound(residuals, 1)) return
      matrix = substitute(joint, control, kind, old, new)
      if (kind == numerical) updates = updates + 6
      a(:n, :n) = matrix(free(:n), free(:n))
      do i = 1, n
        a(i, i) = a(i, i) + control%spring(free(i))
      end do
      change(:n) = -residual(free(:n))
      call eliminate(n, a, change, good)
      ended = singular
      if (.not. good) return
      new%s(free(:n)) = new%s(free(:n)) + change(:n)
    end do
  end subroutine newton

  !> The matrix that replaces the tangent, stress/length.
  pure function substitute(joint, control, kind, old, new) result(matrix)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! duration of the increment
    integer, intent(in) :: kind                     !! which tangent
    type(point_type), intent(in) :: old             !! the point at the start of the increment
    type(point_type), intent(in) :: new             !! the point now
    real(wp) :: matrix(3, 3)
    type(point_type) :: rest
    select case (kind)
    case (symmetrised)
      matrix = 0.5_wp*(new%tangent + transpose(new%tangent))
    case (transposed)
      matrix = transpose(new%tangent)
    case (secant)
      matrix = secant_tangent(joint, old, new)
    case (at_start)
      matrix = old%tangent
    case (elastic)
      rest = new_point(joint)
      matrix = rest%tangent
    case (numerical)
      matrix = central_differences(joint, control, old, new)
    case (zero)
      matrix = 0.0_wp
    case (reversed)
      matrix = -new%tangent
    case default
      matrix = new%tangent
    end select
  end function substitute

  !> Secant matrix: the sum (3) over the planes of (1 - alpha) diag(K_n, K_t, K_t), plus the contact, plus alpha K_t
  !> times the ratio of the friction stress to the trial stress (30).
  pure function secant_tangent(joint, old, new) result(matrix)
    type(interface_type), intent(in) :: joint       !! the interface
    type(point_type), intent(in) :: old             !! the point at the start of the increment
    type(point_type), intent(in) :: new             !! the point now
    real(wp) :: matrix(3, 3)
    real(wp) :: alpha, s_n, s_t(2), trial, kept, along, normal, n(3), h(3), t(3)
    integer :: i, j, k
    matrix = 0.0_wp
    associate (m => joint%material, pattern => joint%pattern)
      do k = 1, pattern%n
        j = plane_statev(k)
        alpha = new%state(j)
        n = plane_normal(pattern, k)
        h = [0.0_wp, pattern%h_x(k), pattern%h_y(k)]
        t = [pattern%sin_theta(k), pattern%cos_theta(k)*pattern%e_x(k), pattern%cos_theta(k)*pattern%e_y(k)]
        s_n = dot_product(n, new%s)
        s_t = [dot_product(t, new%s), dot_product(h, new%s)]
        trial = hypot(s_t(1) - old%state(j + 1), s_t(2) - old%state(j + 2))
        kept = 0.0_wp
        if (s_n <= 0.0_wp) kept = 1.0_wp
        if (trial > 0.0_wp) kept = hypot(s_t(1) - new%state(j + 1), s_t(2) - new%state(j + 2))/trial
        along = m%k_t*(1.0_wp - alpha + alpha*kept)
        normal = merge(m%k_c, m%k_n*(1.0_wp - alpha), s_n < 0.0_wp)
        do i = 1, 3
          matrix(:, i) = matrix(:, i) + pattern%gamma(k)*((normal - along)*n*n(i))
          matrix(i, i) = matrix(i, i) + pattern%gamma(k)*along
        end do
      end do
    end associate
  end function secant_tangent

  !> Tangent by central differences of the traction.
  pure function central_differences(joint, control, old, new) result(matrix)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! duration of the increment
    type(point_type), intent(in) :: old             !! the point at the start of the increment
    type(point_type), intent(in) :: new             !! the point now
    real(wp) :: matrix(3, 3)
    real(wp) :: after(3), before(3), beside(3), step, state(joint%n_statev), tangent(3, 3)
    integer :: i
    step = difference*joint%material%s0
    do i = 1, 3
      beside = new%s
      beside(i) = new%s(i) - step
      call update_point(joint, old%s, beside, old%state, state, before, tangent, control%dt)
      beside(i) = new%s(i) + step
      call update_point(joint, old%s, beside, old%state, state, after, tangent, control%dt)
      matrix(:, i) = (after - before)/(2.0_wp*step)
    end do
  end function central_differences

end module asperity_naive_newton
