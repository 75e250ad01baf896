!> A point under mixed control and its equations: the prescribed value of each component, and the residual of the
!> prescribed tractions at a share of an increment.
module asperity_control_point
  use asperity_checks, only: all_bounded
  use asperity_kinds, only: wp
  use asperity_point_law, only: point_law
  use asperity_tolerances, only: coarsest_scale, farthest, finest_scale, instability, longest_step
  implicit none
  private
  public :: control_type, point_type, equations_type, new_point, move_point, new_equations, values_at, evaluate, &
    free_part, free_matrix, predict, unstable, is_unstiff, farthest_equilibrium, work_between

  !> Which value of each component (N, Tx, Ty) is prescribed, and the duration of an increment.
  type :: control_type
    logical :: traction(3) = .false.   !! true: traction + spring*separation is prescribed, false: the separation is
    real(wp) :: spring(3) = 0.0_wp     !! stiffness of a surrounding spring (CNS), stress/length
    real(wp) :: dt = 0.0_wp            !! duration of the increment (viscous damage only), >= 0, time
  end type control_type

  !> A point: separation, traction, tangent, state.
  type :: point_type
    real(wp) :: s(3) = 0.0_wp             !! separation (N, Tx, Ty), length
    real(wp) :: traction(3) = 0.0_wp      !! stress
    real(wp) :: tangent(3, 3) = 0.0_wp    !! stress/length
    real(wp) :: work = 0.0_wp             !! work of the traction so far, stress*length
    real(wp), allocatable :: state(:)     !! STATEV
  end type point_type

  !> Equations of an increment at any share of it: one update of the law from the state at a share that was reached.
  type :: equations_type
    type(control_type) :: control
    real(wp) :: start(3) = 0.0_wp, target(3) = 0.0_wp   !! prescribed values at the shares 0 and 1
    type(point_type) :: old            !! the point at the share `done`
    real(wp) :: done = 0.0_wp          !! share of the increment that was reached
    real(wp) :: moved = 0.0_wp         !! largest separation at the start of the increment, length
    integer :: n = 0                   !! number of free separations
    integer :: free(3) = 0             !! their components, in the first n
    real(wp) :: damping = 0.0_wp       !! resistance to the motion from the point at `done`, stress/length
    logical :: wears = .true.          !! whether the wear of the increment grows with the share
    real(wp) :: finest = 0.0_wp        !! smallest traction scale, stress
    real(wp) :: coarsest = 0.0_wp      !! largest traction scale due to free separations, as a multiple of strength plus
                                       !! prescribed tractions
    real(wp) :: longest = 0.0_wp       !! longest step if the derivative is singular, as a multiple of the elastic step
    integer :: updates = 0             !! of the law so far
    integer :: iterations = 0          !! tangent solves so far
  end type equations_type

contains

  !> A virgin point, or a point with the given state and separation; its traction and tangent are those of an update
  !> without increment, in which delayed damage may grow. Its work so far is the sum of its energies.
  pure function new_point(law, state, separation) result(point)
    class(point_law), intent(in) :: law                  !! the law
    real(wp), intent(in), optional :: state(:)           !! STATEV to start from; absent: virgin
    real(wp), intent(in), optional :: separation(3)      !! (N, Tx, Ty) to start from, length; absent: 0
    type(point_type) :: point
    real(wp) :: old(law%n_state)
    old = 0.0_wp
    if (present(state)) old = state(:law%n_state)
    if (present(separation)) point%s = separation
    allocate (point%state(law%n_state))
    call law%update(point%s, point%s, old, point%state, point%traction, point%tangent, 0.0_wp, 0.0_wp)
    point%work = sum(law%energies(point%state))
  end function new_point

  !> Move a point to another by exchanging their arrays of state variables: no array is copied.
  pure subroutine move_point(from, to)
    type(point_type), intent(inout) :: from   !! the point -> undefined
    type(point_type), intent(inout) :: to     !! any -> the point
    real(wp), allocatable :: room(:), state(:)
    call move_alloc(to%state, room)
    call move_alloc(from%state, state)
    to = from
    call move_alloc(state, to%state)
    call move_alloc(room, from%state)
  end subroutine move_point

  !> Equations of an increment; their point at the start is set by the caller.
  pure subroutine new_equations(law, control, start, target, equations)
    class(point_law), intent(in) :: law               !! the law
    type(control_type), intent(in) :: control         !! what is prescribed
    real(wp), intent(in) :: start(3), target(3)       !! values at both ends
    type(equations_type), intent(inout) :: equations  !! the equations
    real(wp) :: given
    integer :: i
    equations%control = control
    equations%start = start
    equations%target = target
    equations%done = 0.0_wp
    equations%moved = 0.0_wp
    equations%n = 0
    do i = 1, 3
      if (.not. control%traction(i)) cycle
      equations%n = equations%n + 1
      equations%free(equations%n) = i
    end do
    equations%damping = 0.0_wp
    equations%wears = .true.
    equations%finest = finest_scale*law%stress
    ! the strength of a joint without bond is a number in name only
    given = maxval(max(abs(start), abs(target)), mask=control%traction)
    if (given > 0.0_wp) equations%finest = min(equations%finest, given)
    equations%coarsest = coarsest_scale
    equations%longest = longest_step
    equations%updates = 0
    equations%iterations = 0
  end subroutine new_equations

  !> Prescribed values at a share of an increment.
  pure function values_at(equations, share) result(values)
    type(equations_type), intent(in) :: equations   !! the increment
    real(wp), intent(in) :: share                   !! 0 to 1
    real(wp) :: values(3)
    values = equations%start + share*(equations%target - equations%start)
    if (share >= 1.0_wp) values = equations%target
  end function values_at

  !> Update the point for free separations x at a share of the increment, and compute the residual of the prescribed
  !> tractions. Time and wear grow with the share.
  pure subroutine evaluate(law, equations, x, share, point, residual, scale, good)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; the update is counted
    real(wp), intent(in) :: x(3)                        !! free separations in the first n, length
    real(wp), intent(in) :: share                       !! of the increment, from `done` to 1
    type(point_type), intent(inout) :: point            !! -> the point with these separations
    real(wp), intent(out) :: residual(3)                !! traction + spring*separation + damping*move - value, stress
    real(wp), intent(out) :: scale                      !! traction scale of `residual_tolerance`, > 0, stress
    logical, intent(out) :: good                        !! false: the separation is out of range, no result
    real(wp) :: given, largest, part, values(3), worn
    integer :: i, k

    residual = 0.0_wp
    scale = 1.0_wp
    values = values_at(equations, share)
    point%s = values
    do i = 1, equations%n
      point%s(equations%free(i)) = x(i)
    end do
    good = all_bounded(size(point%s), point%s, law%bound)
    if (.not. good) return
    if (.not. allocated(point%state)) allocate (point%state(law%n_state))
    equations%updates = equations%updates + 1
    part = share - equations%done
    worn = 0.0_wp
    if (equations%wears .and. equations%done < 1.0_wp) worn = part/(1.0_wp - equations%done)
    call law%update(equations%old%s, point%s, equations%old%state, point%state, point%traction, point%tangent, &
      part*equations%control%dt, worn)
    point%work = equations%old%work + work_between(equations%old%s, equations%old%traction, point%s, &
      point%traction)
    given = 0.0_wp
    do i = 1, equations%n
      k = equations%free(i)
      residual(i) = point%traction(k) + equations%control%spring(k)*x(i) - values(k) + &
        equations%damping*(x(i) - equations%old%s(k))
      given = max(given, abs(values(k)))
    end do
    scale = law%magnitude(point%s, point%state) + given
    ! an open joint that is fully damaged carries nothing, without rounding errors
    if (is_unstiff(point) .and. .not. equations%damping > 0.0_wp) scale = given
    ! The scale is bounded: otherwise a residual would count as small if free separations grow without bound.
    largest = equations%coarsest*(law%stress + given)
    if (scale > largest) scale = min(scale, largest + law%magnitude(merge(0.0_wp, point%s, &
      equations%control%traction), 0.0_wp*point%state))
    ! rounding errors of the separation in the damping force
    scale = max(tiny(scale), equations%finest, scale) + equations%damping*maxval(abs(x))
  end subroutine evaluate

  !> The free components of a vector in the first n, the others zero.
  pure function free_part(equations, v) result(x)
    type(equations_type), intent(in) :: equations   !! the equations
    real(wp), intent(in) :: v(3)                    !! (N, Tx, Ty)
    real(wp) :: x(3)
    integer :: i
    x = 0.0_wp
    do i = 1, equations%n
      x(i) = v(equations%free(i))
    end do
  end function free_part

  !> Derivative of the residual with respect to the free separations, in the upper left n x n, zero elsewhere,
  !> stress/length.
  pure function free_matrix(equations, point) result(a)
    type(equations_type), intent(in) :: equations   !! the equations
    type(point_type), intent(in) :: point           !! the point, its tangent
    real(wp) :: a(3, 3)
    integer :: i, j
    a = 0.0_wp
    do j = 1, equations%n
      do i = 1, equations%n
        a(i, j) = point%tangent(equations%free(i), equations%free(j))
      end do
      a(j, j) = a(j, j) + equations%control%spring(equations%free(j)) + equations%damping
    end do
  end function free_matrix

  !> Right-hand side of the change of the free separations that a tangent predicts for a change of the prescribed
  !> values: the solution of free_matrix*x = predict, stress.
  pure function predict(equations, point, change) result(b)
    type(equations_type), intent(in) :: equations   !! the equations
    type(point_type), intent(in) :: point           !! the point, its tangent
    real(wp), intent(in) :: change(3)               !! of the prescribed values
    real(wp) :: b(3)
    b = free_part(equations, change - matmul(point%tangent, merge(0.0_wp, change, equations%control%traction)))
  end function predict

  !> Whether an equilibrium with this derivative of the residual is unstable: an eigenvalue has a negative real part
  !> (criterion of Routh and Hurwitz). A zero eigenvalue is admitted: an open interface that is fully damaged has no
  !> stiffness.
  pure function unstable(n, a, scale) result(yes)
    integer, intent(in) :: n               !! 0 to 3
    real(wp), intent(in) :: a(3, 3)        !! derivative of the residual, zero beyond
    real(wp), intent(in) :: scale          !! elastic stiffness, stress/length
    logical :: yes
    real(wp) :: b(3, 3), first, second, third
    integer :: i
    ! missing unknowns add eigenvalues that are no ratio of stiffnesses
    b = a/scale
    do i = n + 1, 3
      b(i, i) = acos(-1.0_wp)
    end do
    first = b(1, 1) + b(2, 2) + b(3, 3)
    second = b(1, 1)*b(2, 2) - b(1, 2)*b(2, 1) + b(1, 1)*b(3, 3) - b(1, 3)*b(3, 1) + b(2, 2)*b(3, 3) - &
      b(2, 3)*b(3, 2)
    third = b(1, 1)*(b(2, 2)*b(3, 3) - b(2, 3)*b(3, 2)) - b(1, 2)*(b(2, 1)*b(3, 3) - b(2, 3)*b(3, 1)) + &
      b(1, 3)*(b(2, 1)*b(3, 2) - b(2, 2)*b(3, 1))
    yes = first < -instability .or. third < -instability .or. first*second - third < -instability
  end function unstable

  !> Whether a point has no stiffness at all: it is open and fully damaged. The comparison is exact, as every term of
  !> the sum over the planes vanishes.
  pure function is_unstiff(point) result(yes)
    type(point_type), intent(in) :: point   !! the point
    logical :: yes
    yes = .not. any(abs(point%tangent) > 0.0_wp)
  end function is_unstiff

  !> Separation beyond which an equilibrium counts as one without bound, length: a multiple of s_f plus the elastic
  !> separation of the prescribed values, or the separation at the start of the increment. With viscous damage the bond
  !> decreases with time, but never to zero; without it a joint that is far away may move elastically.
  pure function farthest_equilibrium(law, equations, share) result(far)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    real(wp), intent(in) :: share                   !! of `farthest`
    real(wp) :: far
    real(wp) :: elastic, values(3)
    far = huge(far)
    if (equations%n == 0) return
    values = max(abs(equations%start), abs(equations%target))
    elastic = maxval(merge(min(values, law%softest*law%bound)/law%softest, values, equations%control%traction))
    far = share*farthest*(law%reach + elastic)
    associate (moved => equations%moved)
      far = max(far, merge(share*moved, moved + 2.0_wp*elastic, law%relaxes))
    end associate
    far = min(far, 0.5_wp*law%bound)
  end function farthest_equilibrium

  !> Work of the traction on the separation between two points, by the trapezoidal rule, stress*length.
  pure function work_between(s_old, traction_old, s, traction) result(work)
    real(wp), intent(in) :: s_old(3), s(3)                 !! separation of both points, length
    real(wp), intent(in) :: traction_old(3), traction(3)   !! traction there, stress
    real(wp) :: work
    work = 0.5_wp*sum((traction_old + traction)*(s - s_old))
  end function work_between

end module asperity_control_point
