!> The curve of equilibria of one update: the fractions of an increment from 0 to 1, each computed from the state at the
!> fraction that was reached before. Time and wear grow with the fraction. The result does not depend on the steps.
module asperity_equilibrium_path
  use asperity_equations, only: equations_type, evaluate, farthest_equilibrium, free_matrix, &
    largest_move, point_type, predict, ramp, unstable
  use asperity_elimination, only: eliminate
  use asperity_kinds, only: wp
  use asperity_newton, only: newton_solve, newton_type
  use asperity_point_law, only: point_law
  use asperity_tolerances, only: closer, finest_scale, least_rupture, longest_change, most_updates, &
    overshoot, residual_tolerance, rounding_scale, shortest_wear, smallest_fraction, snap_resolution, &
    unbalanced_wear, unexplained, unexplained_fraction, unprompted
  implicit none
  private
  public :: falls, follow, open_joint

contains

  !> Follow the curve to the end of the increment or to a fold; the equations then start at the last equilibrium.
  !>
  !> A step is accepted if Newton's method converges over stable tangents and if the free separations change by
  !> `longest_change` at most; beyond `unexplained` the change must agree with the tangents at both ends of the step.
  !> Otherwise the step is halved.
  !>
  !> If the energies are to balance, the equations start anew where those of a step do not: the energy of a step is that
  !> of the mean of both ends.
  pure subroutine follow(law, equations)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations, the point at `done` -> at the new `done`
    type(point_type) :: here, trial
    real(wp) :: next, fraction, step
    logical :: good
    here%s = equations%old%s
    here%traction = equations%old%traction
    here%tangent = equations%old%tangent
    fraction = equations%done
    step = 1.0_wp
    do while (fraction < 1.0_wp .and. step >= smallest_fraction .and. equations%report%updates < most_updates)
      next = min(1.0_wp, fraction + step)
      call solve_step(law, equations, [fraction, next], here, trial, good)
      if (good) then
        equations%fell = equations%fell .or. falls(law, equations, equations%old, trial, next - equations%done)
        if (equations%in_balance .and. unbalanced(law, equations%old, trial)) then
          if (fraction > equations%done) then
            call commit(equations, here, fraction)
            cycle
          else if (next - fraction > shortest_wear) then
            step = 0.5_wp*min(step, 1.0_wp - fraction)
            cycle
          end if
        end if
        here = trial
        fraction = next
        step = 2.0_wp*step
      else
        step = 0.5_wp*min(step, 1.0_wp - fraction)
      end if
    end do
    if (fraction > equations%done) call commit(equations, here, fraction)
  end subroutine follow

  !> Let the equations start at a point of the curve.
  pure subroutine commit(equations, point, fraction)
    type(equations_type), intent(inout) :: equations    !! the equations, at `done` -> at this fraction
    type(point_type), intent(in) :: point               !! the point
    real(wp), intent(in) :: fraction                    !! of the increment
    equations%old = point
    equations%done = fraction
    equations%report%parts = equations%report%parts + 1
  end subroutine commit

  !> Whether the energies between two points do not balance.
  pure function unbalanced(law, before, after) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(point_type), intent(in) :: before, after   !! the points
    logical :: yes
    real(wp) :: change(2), work
    change = law%energies(after%state) - law%energies(before%state)
    work = after%work - before%work
    yes = abs(work - sum(change)) > unbalanced_wear*max(law%stress*law%length, abs(work) + sum(abs(change)))
  end function unbalanced

  !> Whether a joint falls by wear between two points: its free separations move far more than the prescribed values,
  !> and it spends the energy that it had stored. The curve has no fold there, as the wear of the increment grows along
  !> it.
  pure function falls(law, equations, before, after, fraction) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(point_type), intent(in) :: before, after   !! the points
    real(wp), intent(in) :: fraction                !! of the increment between them
    logical :: yes
    real(wp) :: change(2), prescribed
    yes = law%wears
    if (.not. yes) return
    prescribed = fraction*maxval(abs(equations%target - equations%start)/merge(law%stiffness, 1.0_wp, &
      equations%control%traction))
    yes = largest_move(equations, before, after) > max(snap_resolution*law%length, unprompted*prescribed)
    if (.not. yes) return
    change = law%energies(after%state) - law%energies(before%state)
    yes = change(1) < 0.0_wp .and. change(2) > unprompted*abs(after%work - before%work)
  end function falls

  !> Take a step, by Newton's method from the separations at its start. If the result is not accepted, the method starts
  !> from the separations that the tangent at the start predicts: the first start may open or close a stiff contact
  !> under a small pressure. A broken joint that carries nothing is opened instead. The smallest step is also tried
  !> from the closing side, as the tangent at a peak of the traction may be that of the side where the equilibrium is
  !> unstable.
  pure subroutine solve_step(law, equations, fractions, here, trial, good)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates are counted
    real(wp), intent(in) :: fractions(2)                   !! at both ends of the step
    type(point_type), intent(in) :: here                !! separation and tangent at its start
    type(point_type), intent(inout) :: trial            !! -> the point at its end
    logical, intent(out) :: good                        !! whether the step is accepted
    type(newton_type) :: result
    real(wp) :: change(3), matrix(3, 3), predicted(3)
    integer :: attempt
    logical :: last
    last = fractions(2) - fractions(1) < 2.0_wp*smallest_fraction
    change = (fractions(2) - fractions(1))*(equations%target - equations%start)
    do attempt = 1, merge(4, 2, equations%control%traction(1))
      trial%s = here%s
      if (attempt == 2) then
        matrix = free_matrix(law, equations, here)
        predicted = predict(equations, here, change)
        call eliminate(3, matrix, predicted, good)
        if (.not. good) cycle
        if (law%wears .and. equations%control%traction(1)) predicted(1) = predicted(1) + &
          worn_retreat(law, equations, fractions, here%s + predicted)
        trial%s = here%s + predicted
      else if (attempt == 3) then
        good = carries_nothing(law, equations, here)
        if (good) call open_joint(law, equations, fractions(2), trial, good)
        if (good) good = all(abs(law%energies(trial%state) - law%energies(equations%old%state)) <= &
          least_rupture*law%stress*law%length)
        if (good) return
        cycle
      else if (attempt == 4) then
        if (.not. last) exit
        trial%s(1) = trial%s(1) - closer*law%length
      end if
      call newton_solve(law, equations, fractions(2), huge(1.0_wp), trial, result)
      if (attempt == 2) result%step = predicted
      good = result%converged
      if (good) call judge(law, equations, fractions, last, result, here, trial, good)
      if (good) return
    end do
  end subroutine solve_step

  !> Change of the opening at which the joint is just out of contact, by the wear of a step: the contact may be so stiff
  !> that facets which retreat by more than they are closed leave no residual to find them by.
  pure function worn_retreat(law, equations, fractions, s) result(retreat)
    class(point_law), intent(in) :: law               !! the law
    type(equations_type), intent(in) :: equations     !! the equations
    real(wp), intent(in) :: fractions(2)                 !! at both ends of the step
    real(wp), intent(in) :: s(3)                      !! separation, length
    type(equations_type) :: local
    type(point_type) :: ends(2)
    real(wp) :: error, r(3), retreat
    local = equations
    call evaluate(law, local, s, fractions(1), ends(1), r, error)
    call evaluate(law, local, s, fractions(2), ends(2), r, error)
    retreat = law%contact_opening(s, ends(2)%state) - law%contact_opening(s, ends(1)%state)
  end function worn_retreat

  !> Whether a converged step continues the curve.
  pure subroutine judge(law, equations, fractions, last, result, old, new, good)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates are counted
    real(wp), intent(in) :: fractions(2)                   !! at both ends of the step
    logical, intent(in) :: last                         !! whether the step cannot be halved
    type(newton_type), intent(in) :: result             !! of Newton's method; its step is the predicted one
    type(point_type), intent(in) :: old, new            !! both ends of the step
    logical, intent(out) :: good                        !! whether the step is accepted
    type(newton_type) :: halfway
    type(point_type) :: back, middle
    real(wp) :: change(3), ending(3), error, extent, matrix(3, 3), move, prescribed, tolerated
    logical :: broken, predicted
    good = .true.
    associate (traction => equations%control%traction)
      if (.not. any(traction)) return
      good = .not. unstable(result%last, law%stiffness) .and. &
        maxval(abs(new%s)) <= farthest_equilibrium(law, equations, 1.0_wp)
      change = (fractions(2) - fractions(1))*(equations%target - equations%start)
      ! damage that takes time releases a traction without a move
      if (good .and. .not. (law%rate_dependent .and. equations%control%dt > 0.0_wp)) then
        if (carries_nothing(law, equations, new)) good = releases(law, equations, change, old, last)
      end if
      if (.not. good) return
      move = largest_move(equations, old, new)
      matrix = free_matrix(law, equations, old)
      if (move <= unexplained*law%length) then
        if (last .or. law%rate_dependent .or. law%wears .or. alike(matrix, result%last)) return
        ! a jump back may cancel the move
        ending = predict(equations, old, change)
        call eliminate(3, matrix, ending, predicted)
        good = .not. predicted .or. maxval(abs(ending), mask=traction) <= unexplained*law%length
        return
      end if
      good = result%stable
      broken = law%cannot_soften(equations%old%state)
      ! beside other free separations friction may be unstable without softening
      if (.not. good .or. (broken .and. count(traction) == 1)) return
      prescribed = maxval(abs(change)/merge(law%stiffness, 1.0_wp, traction))
      ! neither a joint without bond nor one that is open and whose damage takes time has a length of its own
      extent = law%length
      if (broken .or. (law%rate_dependent .and. equations%control%dt > 0.0_wp)) extent = max(extent, &
        maxval(abs(old%s), mask=traction))
      ! a step that cannot be halved may be longer than this in the prescribed values themselves
      if (last .and. prescribed > unexplained*law%length) return
      if (move > longest_change*extent) good = alike(matrix, result%last)
      if (.not. good) return
      if (law%rate_dependent .or. law%wears) then
        ! the step back, as the tangent does not have the effect of time and wear
        call evaluate(law, equations, new%s, fractions(1), back, ending, error)
      else
        ending = predict(equations, new, change)
      end if
      matrix = result%last
      call eliminate(3, matrix, ending, good)
      tolerated = max(unexplained*extent, unexplained_fraction*prescribed)
      if (good) good = maxval(abs(new%s - old%s - 0.5_wp*(result%step + ending)), mask=traction) <= tolerated
      if (.not. good .or. move <= extent) return
      ! planes may break or jam between two ends that are alike
      middle%s = 0.5_wp*(old%s + new%s)
      call newton_solve(law, equations, 0.5_wp*sum(fractions), huge(1.0_wp), middle, halfway)
      good = halfway%converged .and. halfway%stable .and. &
        maxval(abs(middle%s - 0.5_wp*(old%s + new%s)), mask=traction) <= tolerated
    end associate
  end subroutine judge

  !> The smallest opening, from zero on, at which the joint carries nothing, and its free separations across stay.
  pure subroutine open_joint(law, equations, fraction, point, found)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates are counted
    real(wp), intent(in) :: fraction                       !! of the increment
    type(point_type), intent(inout) :: point            !! with its separations -> the open joint
    logical, intent(out) :: found                       !! whether it is an equilibrium
    real(wp) :: error, r(3), step
    logical :: rounding
    found = .false.
    point%s = merge(point%s, ramp(equations%start, equations%target, fraction), equations%control%traction)
    point%s(1) = law%contact_opening(point%s, equations%old%state)
    step = spacing(max(abs(point%s(1)), law%length))
    do
      call evaluate(law, equations, point%s, fraction, point, r, error)
      if (error >= huge(error)) return
      ! prescribed tractions may be what is left of a release
      rounding = maxval(abs(r)) <= rounding_scale*residual_tolerance*law%magnitude(point%s, point%state)
      ! the comparison is exact, as every plane is fully damaged and open
      found = rounding .and. .not. any(abs(point%traction) > 0.0_wp)
      if (found .or. .not. rounding .or. step > closer*law%length) exit
      point%s(1) = point%s(1) + step
      step = 2.0_wp*step
    end do
  end subroutine open_joint

  !> Whether a point carries nothing, or its tangent, if it predicts anything, releases what it carries just at the end
  !> of a step. Otherwise a joint that carries nothing at this end is on another branch, even if it has not moved.
  pure function releases(law, equations, change, point, last) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    real(wp), intent(in) :: change(3)               !! of the prescribed values in the step
    type(point_type), intent(in) :: point           !! the point before it
    logical, intent(in) :: last                     !! whether the step cannot be halved, and may release more
    real(wp) :: ahead(3), left, matrix(3, 3)
    logical :: predicted, yes
    yes = carries_nothing(law, equations, point)
    if (yes) return
    matrix = free_matrix(law, equations, point)
    ahead = predict(equations, point, change)
    call eliminate(3, matrix, ahead, predicted)
    yes = .not. predicted
    if (yes) return
    ahead = merge(ahead, change, equations%control%traction)
    left = dot_product(point%traction + matmul(point%tangent, ahead), point%traction)
    yes = left <= 0.0_wp
    ! what is left of an earlier release may go at once
    if (last .or. maxval(abs(point%traction)) <= finest_scale*law%stress) return
    if (yes) yes = left >= -overshoot*dot_product(point%traction, point%traction)
  end function releases

  !> Whether the traction of a point is a rounding error, such as what is left of a release.
  pure function carries_nothing(law, equations, point) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(point_type), intent(in) :: point           !! the point
    logical :: yes
    yes = maxval(abs(point%traction)) <= residual_tolerance*law%magnitude(point%s, equations%old%state)
  end function carries_nothing

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

end module asperity_equilibrium_path
