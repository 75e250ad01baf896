!> The curve of equilibria of one update: the fractions of an increment from 0 to 1, each computed from the state at the
!> fraction that was reached before. Time and wear grow with the fraction. The result does not depend on the steps.
module asperity_equilibrium_path
  use asperity_acceptance, only: carries_nothing, judge, step_type
  use asperity_elimination, only: eliminate
  use asperity_equations, only: equations_type, evaluate, free_matrix, largest_move, look_back, may_go_on, point_type, &
    predict, ramp
  use asperity_kinds, only: wp
  use asperity_newton, only: newton_solve
  use asperity_point_law, only: point_law
  use asperity_tolerances, only: closer, least_rupture, residual_tolerance, rounding_scale, shortest_wear, &
    smallest_fraction, snap_resolution, unbalanced_wear, unprompted
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
  subroutine follow(law, equations)
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
    do while (fraction < 1.0_wp .and. step >= smallest_fraction .and. may_go_on(equations))
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
    change = law%accounts(after%state) - law%accounts(before%state)
    work = after%work - before%work
    yes = abs(work - sum(change)) > unbalanced_wear*max(law%stress*law%s_0, abs(work) + sum(abs(change)))
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
    yes = largest_move(equations, before, after) > max(snap_resolution*law%s_0, unprompted*prescribed)
    if (.not. yes) return
    change = law%accounts(after%state) - law%accounts(before%state)
    yes = change(1) < 0.0_wp .and. change(2) > unprompted*abs(after%work - before%work)
  end function falls

  !> Take a step, by Newton's method from the separations at its start. If the result is not accepted, the method starts
  !> from the separations that the tangent at the start predicts: the first start may open or close a stiff contact
  !> under a small pressure. A broken joint that carries nothing is opened instead. The smallest step is also tried
  !> from the closing side, as the tangent at a peak of the traction may be that of the side where the equilibrium is
  !> unstable.
  subroutine solve_step(law, equations, fractions, here, trial, good)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates are counted
    real(wp), intent(in) :: fractions(2)                   !! at both ends of the step
    type(point_type), intent(in) :: here                !! separation and tangent at its start
    type(point_type), intent(inout) :: trial            !! -> the point at its end
    logical, intent(out) :: good                        !! whether the step is accepted
    type(step_type) :: step
    real(wp) :: matrix(3, 3), predicted(3), retreat
    integer :: attempt
    step%fractions = fractions
    step%last = fractions(2) - fractions(1) < 2.0_wp*smallest_fraction
    step%change = (fractions(2) - fractions(1))*(equations%target - equations%start)
    do attempt = 1, merge(4, 2, equations%control%traction(1))
      trial%s = here%s
      if (attempt == 2) then
        matrix = free_matrix(law, equations, here)
        predicted = predict(equations, here, step%change)
        call eliminate(3, matrix, predicted, good)
        if (.not. good) cycle
        if (law%wears .and. equations%control%traction(1)) then
          call find_worn_retreat(law, equations, fractions, here%s + predicted, retreat)
          predicted(1) = predicted(1) + retreat
        end if
        trial%s = here%s + predicted
      else if (attempt == 3) then
        good = carries_nothing(law, equations, here)
        if (good) call open_joint(law, equations, fractions(2), trial, good)
        if (good) good = all(abs(law%accounts(trial%state) - law%accounts(equations%old%state)) <= &
          least_rupture*law%stress*law%s_0)
        if (good) return
        cycle
      else if (attempt == 4) then
        if (.not. step%last) exit
        trial%s(1) = trial%s(1) - closer*law%s_0
      end if
      call newton_solve(law, equations, fractions(2), huge(1.0_wp), trial, step%result)
      if (attempt == 2) step%result%step = predicted
      good = step%result%converged
      if (good) call judge(law, equations, step, here, trial, good)
      if (good) return
    end do
  end subroutine solve_step

  !> Change of the opening at which the joint is just out of contact, by the wear of a step: the contact may be so stiff
  !> that facets which retreat by more than they are closed leave no residual to find them by.
  subroutine find_worn_retreat(law, equations, fractions, s, retreat)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates are counted
    real(wp), intent(in) :: fractions(2)                !! at both ends of the step
    real(wp), intent(in) :: s(3)                        !! separation, length
    real(wp), intent(out) :: retreat                    !! the change, length; 0 if the law has no result
    type(point_type) :: earlier, worn
    real(wp) :: error, r(3)
    logical :: known
    retreat = 0.0_wp
    call evaluate(law, equations, s, fractions(2), worn, r, error)
    if (error >= huge(error)) return
    call look_back(law, equations, fractions(1), worn, earlier, known)
    if (known) retreat = law%contact_opening(worn%s, worn%state) - law%contact_opening(worn%s, earlier%state)
  end subroutine find_worn_retreat

  !> The smallest opening, from zero on, at which the joint carries nothing, and its free separations across stay.
  subroutine open_joint(law, equations, fraction, point, in_equilibrium)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates are counted
    real(wp), intent(in) :: fraction                       !! of the increment
    type(point_type), intent(inout) :: point            !! with its separations -> the open joint
    logical, intent(out) :: in_equilibrium              !! whether it is an equilibrium
    real(wp) :: error, r(3), step
    logical :: rounding
    in_equilibrium = .false.
    point%s = merge(point%s, ramp(equations%start, equations%target, fraction), equations%control%traction)
    point%s(1) = law%contact_opening(point%s, equations%old%state)
    step = spacing(max(abs(point%s(1)), law%s_0))
    do
      call evaluate(law, equations, point%s, fraction, point, r, error)
      if (error >= huge(error)) return
      ! prescribed tractions may be what is left of a release
      rounding = maxval(abs(r)) <= rounding_scale*residual_tolerance*law%magnitude(point%s, point%state)
      ! the comparison is exact, as every plane is fully damaged and open
      in_equilibrium = rounding .and. .not. any(abs(point%traction) > 0.0_wp)
      if (in_equilibrium .or. .not. rounding .or. step > closer*law%s_0) exit
      point%s(1) = point%s(1) + step
      step = 2.0_wp*step
    end do
  end subroutine open_joint

end module asperity_equilibrium_path
