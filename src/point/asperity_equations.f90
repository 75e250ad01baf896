!> A point under mixed control and its equations: the prescribed value of each component, and the residual of the
!> prescribed tractions at a fraction of an increment.
!>
!> The unknowns are the free separations, those of prescribed tractions. Vectors and matrices have all three components;
!> those of prescribed separations are decoupled: their residual and their change are zero.
module asperity_equations
  use asperity_checks, only: all_bounded
  use asperity_elimination, only: eliminate
  use asperity_kinds, only: wp
  use asperity_point_law, only: call_type, point_law, point_type
  use asperity_tolerances, only: coarsest_scale, farthest, finest_scale, imperfection, instability, most_updates, &
    residual_tolerance, resolved, rest, rounding_scale
  implicit none
  private
  public :: new_point, new_equations, ramp, evaluate, book, look_back, may_go_on, free_matrix, alike, predict, &
    unstable, is_unstiff, largest_move, farthest_equilibrium, work_between
  public :: point_type

  !> End of an increment: complete, no equilibrium found, limit of updates reached, start or targets out of range; of a
  !> branch (module asperity_branch): without end; the law can take no part of it.
  integer, parameter, public :: ended_complete = 0, ended_lost = 1, ended_limit = 2, ended_rejected = 3, &
    ended_endless = 4, ended_refused = 5

  !> Which value of each component (N, Tx, Ty) is prescribed, and the duration of an increment.
  type, public :: control_type
    logical :: traction(3) = .false.   !! true: traction + spring*separation is prescribed, false: the separation is
    real(wp) :: spring(3) = 0.0_wp     !! stiffness of a surrounding spring (CNS), stress/length
    real(wp) :: dt = 0.0_wp            !! duration of the increment (viscous damage, dashpot), >= 0, time
  end type control_type

  !> Report of an increment.
  type, public :: report_type
    integer :: ended = ended_complete
    integer :: iterations = 0            !! tangent solves
    integer :: updates = 0               !! of the law
    integer :: parts = 0                 !! updates that were committed, 1 where one curve suffices
    integer :: snaps = 0                 !! jumps from one branch to another
    logical :: cut = .false.             !! whether the law asked for a smaller increment
    real(wp) :: requested = 1.0_wp       !! fraction of the increment that the law can take; below 1 it has no result
    real(wp) :: before(3) = 0.0_wp       !! separation (N, Tx, Ty) before the longest of them, length
    real(wp) :: after(3) = 0.0_wp        !! separation after it, length
    real(wp) :: released = 0.0_wp        !! energy released by all of them, stress*length
    integer :: jumps = 0                 !! component whose traction jumps over its prescribed value where the motion
                                         !! of a lost increment stops; 0: none
    real(wp) :: sides(2) = 0.0_wp        !! this traction at both sides, stress
  end type report_type

  !> Equations of an increment at any fraction of it: one update of the law from the state at a fraction reached before.
  type, public :: equations_type
    type(control_type) :: control
    type(call_type) :: call            !! where in a load path the increment is
    real(wp) :: start(3) = 0.0_wp, target(3) = 0.0_wp   !! prescribed values at the fractions 0 and 1
    type(point_type) :: old            !! the point at the fraction `done`
    real(wp) :: done = 0.0_wp          !! fraction of the increment that was reached
    real(wp) :: moved = 0.0_wp         !! largest separation at the start of the increment, length
    logical :: in_balance = .false.    !! whether the energies of each step are to balance
    logical :: fell = .false.          !! whether a joint that wears has fallen in a step
    real(wp) :: displaced = imperfection   !! at the start of the next motion, relative to s0
    logical :: moving = .false.        !! whether a motion looks for an equilibrium
    real(wp) :: damping = 0.0_wp       !! resistance to the motion from the point at `done`, stress/length
    type(report_type) :: report        !! so far
  end type equations_type

contains

  !> A virgin point, or a point with the given state and separation; its traction and tangent are those of an update
  !> without increment, in which delayed damage may grow. Its work so far is the sum of its energies.
  function new_point(law, state, separation) result(point)
    class(point_law), intent(in) :: law                  !! the law
    real(wp), intent(in), optional :: state(:)           !! STATEV to start from; absent: virgin
    real(wp), intent(in), optional :: separation(3)      !! (N, Tx, Ty) to start from, length; absent: 0
    type(point_type) :: point
    type(point_type) :: old
    real(wp) :: requested
    allocate (old%state(law%n_state), source=0.0_wp)
    if (present(state)) old%state(:) = state(:law%n_state)
    if (present(separation)) old%s = separation
    point = old
    ! there is nothing to divide
    call law%update(call_type(), old, point, requested)
    point%work = sum(law%accounts(point%state))
  end function new_point

  !> Equations of an increment.
  pure subroutine new_equations(control, start, target, point, equations, call)
    type(control_type), intent(in) :: control         !! what is prescribed
    real(wp), intent(in) :: start(3), target(3)       !! values at both ends
    type(point_type), intent(in) :: point             !! the point at the start
    type(equations_type), intent(out) :: equations    !! the equations
    type(call_type), intent(in), optional :: call     !! its place in a load path; absent: in none
    if (present(call)) equations%call = call
    equations%control = control
    equations%start = start
    equations%target = target
    equations%moved = maxval(abs(point%s))
    equations%old = point
  end subroutine new_equations

  !> Linear interpolation, exact at both ends.
  pure elemental function ramp(from, to, fraction) result(value)
    real(wp), intent(in) :: from, to   !! values at the fractions 0 and 1
    real(wp), intent(in) :: fraction      !! 0 to 1
    real(wp) :: value
    value = from + fraction*(to - from)
    if (fraction >= 1.0_wp) value = to
  end function ramp

  !> Update the point for free separations x at a fraction of the increment, and compute the residual of the prescribed
  !> tractions. Time and wear grow with the fraction. Once the law has asked for a part of the increment, nothing has a
  !> result.
  subroutine evaluate(law, equations, x, fraction, point, residual, error, draft)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; the update is counted
    real(wp), intent(in) :: x(3)                        !! separations, of which the free ones are used, length
    real(wp), intent(in) :: fraction                       !! of the increment, from `done` to 1
    type(point_type), intent(inout) :: point            !! -> the point with these separations
    real(wp), intent(out) :: residual(3)                !! traction + spring*separation + damping*move - value, stress
    real(wp), intent(out) :: error                      !! largest residual relative to the traction scale of
                                                        !! `residual_tolerance`; huge: no result, as x is out of
                                                        !! range, or the law cannot take the increment
    logical, intent(in), optional :: draft              !! whether dissipated energies are left to `book`; absent: no
    type(call_type) :: call
    real(wp) :: coarsest, requested, scales(3), values(3)

    residual = 0.0_wp
    error = huge(error)
    if (equations%report%requested < 1.0_wp) return
    values = ramp(equations%start, equations%target, fraction)
    associate (control => equations%control, old => equations%old)
      point%s = merge(x, values, control%traction)
      if (.not. all_bounded(size(point%s), point%s, law%bound)) return
      if (.not. allocated(point%state)) allocate (point%state(law%n_state))
      equations%report%updates = equations%report%updates + 1
      call = part_call(equations, fraction)
      if (present(draft)) call%draft = draft
      call law%update(call, old, point, requested)
      equations%report%requested = requested
      if (requested < 1.0_wp) return
      point%work = old%work + work_between(old%s, old%traction, point%s, point%traction)
      residual = merge(point%traction + control%spring*x - values + equations%damping*(x - old%s), 0.0_wp, &
        control%traction)
    end associate
    scales = residual_scale(law, equations, x, values, point)
    ! what stays does not reduce its residual; a joint without bond has a strength in name only
    coarsest = coarsest_scale*(merge(law%stress, 0.0_wp, law%bonded) + max(0.0_wp, maxval(abs(values), &
      mask=equations%control%traction)))
    where (stays(law, equations, point)) scales = max(scales, coarsest)
    error = maxval(abs(residual)/scales)
  end subroutine evaluate

  !> Add the dissipated energies that the drafts of Newton's method leave out to the point at its end.
  subroutine book(law, equations, fraction, point)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(in) :: equations       !! the equations
    real(wp), intent(in) :: fraction                    !! of the increment
    type(point_type), intent(inout) :: point            !! of `evaluate` at this fraction
    call law%book(part_call(equations, fraction), equations%old, point)
  end subroutine book

  !> What passes from `done` to a fraction of the increment: time and wear.
  pure function part_call(equations, fraction) result(call)
    type(equations_type), intent(in) :: equations   !! the equations
    real(wp), intent(in) :: fraction                !! of the increment
    type(call_type) :: call
    real(wp) :: part
    part = fraction - equations%done
    call = equations%call
    call%duration = part*equations%control%dt
    call%worn_fraction = part/max(1.0_wp - equations%done, tiny(part))
  end function part_call

  !> The point at the same separations with the time and wear of an earlier fraction of the increment: the difference is
  !> what time and wear do, which the tangent does not have.
  subroutine look_back(law, equations, fraction, point, earlier, known)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; the update is counted
    real(wp), intent(in) :: fraction                    !! of the increment, from `done` on
    type(point_type), intent(in) :: point               !! the point at a later one
    type(point_type), intent(out) :: earlier            !! the same point, unless the law has a history
    logical, intent(out) :: known                       !! false: the law has asked for a part of the increment
    real(wp) :: requested
    earlier = point
    known = .not. equations%report%requested < 1.0_wp
    if (.not. (known .and. (law%rate_dependent .or. law%wears))) return
    equations%report%updates = equations%report%updates + 1
    call law%update(part_call(equations, fraction), equations%old, earlier, requested)
    equations%report%requested = requested
    known = .not. requested < 1.0_wp
  end subroutine look_back

  !> Whether the increment may go on: within the limit of updates, and as long as the law can take it.
  pure function may_go_on(equations) result(yes)
    type(equations_type), intent(in) :: equations   !! the equations
    logical :: yes
    yes = equations%report%updates < most_updates .and. .not. equations%report%requested < 1.0_wp
  end function may_go_on

  !> Traction scale with which a residual is compared, stress: the size of the terms of the traction, within bounds.
  pure function residual_scale(law, equations, x, values, point) result(scale)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(in) :: equations       !! the equations
    real(wp), intent(in) :: x(3)                        !! separations, of which the free ones are used, length
    real(wp), intent(in) :: values(3)                   !! prescribed values
    type(point_type), intent(in) :: point               !! the point with these separations
    real(wp) :: scale
    real(wp) :: finest, given, hidden, known, steep
    associate (control => equations%control)
      given = max(0.0_wp, maxval(abs(values), mask=control%traction))
      steep = 1.0_wp
      if (law%hyperbolic) steep = max(1.0_wp, maxval(abs(point%tangent))/law%largest_stiffness)
      hidden = law%bond_pressure(point%s, point%state)
      scale = steep*law%magnitude(point%s, point%state) + hidden + given
      ! an open joint that is fully damaged carries nothing, without rounding errors
      if (is_unstiff(point) .and. .not. equations%damping > 0.0_wp) scale = given
      ! The scale is bounded: otherwise a residual would count as small if free separations grow without bound.
      known = max(equations%moved, maxval(abs(values), mask=.not. control%traction))
      scale = min(scale, max(coarsest_scale*(law%stress + given), rounding_scale*(steep*law%largest_stiffness)*known, &
        min(rounding_scale*hidden, resolved/residual_tolerance*(law%stress + given))))
      ! the strength of a joint without bond is a number in name only
      finest = finest_scale*law%stress
      given = maxval(max(abs(equations%start), abs(equations%target)), mask=control%traction)
      if (given > 0.0_wp) finest = min(finest, given)
      ! rounding errors of the separation in the damping force
      scale = max(tiny(scale), finest, scale) + equations%damping*maxval(abs(x), mask=control%traction)
    end associate
  end function residual_scale

  !> Derivative of the residual with respect to the separations, stress/length.
  !>
  !> A prescribed separation has a diagonal entry alone, so that elimination gives the free ones the solution of their
  !> own block to the last bit, and the criterion of stability has all three eigenvalues at hand. So has a free one that
  !> nothing holds, as that across the slip of two inclined planes without friction. Rows of unequal length
  !> would gain nothing: in 84,000 blocks of drawn paths with K_n/K_t from 1e-6 to 1e6 no solution differs.
  pure function free_matrix(law, equations, point) result(a)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(point_type), intent(in) :: point           !! the point, its tangent
    real(wp) :: a(3, 3)
    logical :: held(3)
    integer :: i
    a = point%tangent
    do i = 1, 3
      if (equations%control%traction(i)) then
        a(i, i) = a(i, i) + equations%control%spring(i) + equations%damping
      else
        a(i, :) = 0.0_wp
        a(:, i) = 0.0_wp
        ! an eigenvalue that is no ratio of stiffnesses
        a(i, i) = acos(-1.0_wp)*law%stiffness
      end if
    end do
    held = stays(law, equations, point)
    do i = 1, 3
      if (held(i)) a(i, i) = law%stiffness
    end do
  end function free_matrix

  !> Whether a free separation stays where it is: nothing pushes it, or holds it by more over s0 than the coarsest
  !> residual, and it changes no traction of the joint.
  pure function stays(law, equations, point) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(point_type), intent(in) :: point           !! the point, its tangent
    logical :: yes(3)
    real(wp) :: largest, negligible, others(3, 3)
    integer :: i
    yes = equations%control%traction .and. .not. max(abs(equations%start), abs(equations%target), &
      equations%control%spring) > 0.0_wp
    if (is_unstiff(point) .or. equations%damping > 0.0_wp) yes = .false.
    if (.not. any(yes)) return
    negligible = coarsest_scale*residual_tolerance
    if (equations%moving) negligible = rest*negligible
    largest = maxval(abs(point%tangent))
    others = abs(point%tangent)
    do i = 1, 3
      if (.not. yes(i)) cycle
      yes(i) = others(i, i) <= negligible*min(law%stiffness, largest)
      others(i, i) = 0.0_wp
      ! the stiffest direction takes what couples with it
      if (yes(i)) yes(i) = max(maxval(others(i, :)), maxval(others(:, i))) <= negligible*max(law%stiffness, largest)
    end do
  end function stays

  !> Right-hand side of the change of the free separations that a tangent predicts for a change of the prescribed
  !> values: the solution of free_matrix*x = predict, stress.
  pure function predict(equations, point, change) result(b)
    type(equations_type), intent(in) :: equations   !! the equations
    type(point_type), intent(in) :: point           !! the point, its tangent
    real(wp), intent(in) :: change(3)               !! of the prescribed values
    real(wp) :: b(3)
    b = change - matmul(point%tangent, merge(0.0_wp, change, equations%control%traction))
    b = merge(b, 0.0_wp, equations%control%traction)
  end function predict

  !> Largest change of a free separation between two points, length.
  pure function largest_move(equations, from, to) result(move)
    type(equations_type), intent(in) :: equations   !! the equations
    type(point_type), intent(in) :: from, to        !! the points
    real(wp) :: move
    move = max(0.0_wp, maxval(abs(to%s - from%s), mask=equations%control%traction))
  end function largest_move

  !> Whether an equilibrium with this derivative of the residual is unstable: an eigenvalue has a negative real part
  !> (criterion of Routh and Hurwitz). A zero eigenvalue is admitted: an open interface that is fully damaged has no
  !> stiffness.
  pure function unstable(a, scale) result(yes)
    real(wp), intent(in) :: a(3, 3)        !! derivative of the residual
    real(wp), intent(in) :: scale          !! elastic stiffness, stress/length
    logical :: yes
    real(wp) :: b(3, 3), first, second, third
    b = a/scale
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
  pure function farthest_equilibrium(law, equations, fraction) result(far)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    real(wp), intent(in) :: fraction                   !! of `farthest`
    real(wp) :: far
    real(wp) :: elastic, values(3)
    values = max(abs(equations%start), abs(equations%target))
    elastic = maxval(merge(min(values, law%least_stiffness*law%bound)/law%least_stiffness, values, &
      equations%control%traction))
    far = merge(fraction*equations%moved, equations%moved + 2.0_wp*elastic, law%rate_dependent)
    far = min(max(far, fraction*farthest*(law%s_f + elastic)), 0.5_wp*law%bound)
  end function farthest_equilibrium

  !> Work of the traction on the separation between two points, by the trapezoidal rule, stress*length.
  pure function work_between(s_old, traction_old, s, traction) result(work)
    real(wp), intent(in) :: s_old(3), s(3)                 !! separation of both points, length
    real(wp), intent(in) :: traction_old(3), traction(3)   !! traction there, stress
    real(wp) :: work
    work = 0.5_wp*sum((traction_old + traction)*(s - s_old))
  end function work_between

  !> Whether two derivatives of the residual differ by so little that the curve between them has no fold: their
  !> difference is at most half of the first one (half of Kantorovich's bound).
  pure function alike(first, last) result(yes)
    real(wp), intent(in) :: first(3, 3), last(3, 3)    !! derivatives, stress/length
    logical :: yes
    real(wp) :: matrix(3, 3), x(3)
    integer :: k
    yes = .true.
    do k = 1, 3
      matrix = first
      x = last(:, k) - first(:, k)
      if (yes) call eliminate(3, matrix, x, yes)
      if (yes) yes = sum(abs(x)) <= 0.5_wp
    end do
  end function alike

end module asperity_equations
