!> The curve of equilibria of one update: the shares of an increment from 0 to 1, each computed from the state at the
!> share that was reached before. Time and wear grow with the share. The result does not depend on the steps.
module asperity_follow
  use asperity_control_point, only: equations_type, evaluate, farthest_equilibrium, free_matrix, free_part, &
    move_point, point_type, predict, unstable, values_at
  use asperity_elimination, only: eliminate
  use asperity_kinds, only: wp
  use asperity_newton, only: newton_solve, newton_type
  use asperity_point_law, only: point_law
  use asperity_tolerances, only: closer, longest_change, most_updates, smallest_share, unexplained, unexplained_share
  implicit none
  private
  public :: follow

  !> A step along the curve.
  type :: step_type
    real(wp) :: from, to            !! shares at both ends
    real(wp) :: predicted(3)        !! change of the free separations by the tangent at the start, length
    logical :: last                 !! whether it is the smallest step
  end type step_type

contains

  !> Follow the curve to the end of the increment or to a fold.
  !>
  !> A step is accepted if Newton's method converges over stable tangents and if the free separations change by
  !> `longest_change` at most; beyond `unexplained` the change must agree with the tangents at both ends of the step.
  !> Otherwise the step is halved.
  pure subroutine follow(law, equations, here, share)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates and iterations are counted
    type(point_type), intent(inout) :: here             !! separation and tangent at `done` -> the last equilibrium
    real(wp), intent(out) :: share                      !! share reached; `done` if no step was accepted
    type(point_type) :: trial
    real(wp) :: next, step
    logical :: good
    share = equations%done
    step = 1.0_wp
    do while (share < 1.0_wp .and. step >= smallest_share .and. equations%updates < most_updates)
      next = min(1.0_wp, share + step)
      call solve_step(law, equations, step_type(share, next, 0.0_wp, next - share < 2.0_wp*smallest_share), here, &
        trial, good)
      if (good) then
        call move_point(trial, here)
        share = next
        step = 2.0_wp*step
      else
        step = 0.5_wp*min(step, 1.0_wp - share)
      end if
    end do
  end subroutine follow

  !> Take a step, by Newton's method from the separations at its start. If the result is not accepted, the method starts
  !> from the separations that the tangent at the start predicts: the first start may open or close a stiff contact
  !> under a small pressure. The smallest step is also tried from the closing side, as the tangent at a peak of the
  !> traction may be that of the side where the equilibrium is unstable.
  pure subroutine solve_step(law, equations, planned, here, trial, good)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations
    type(step_type), intent(in) :: planned              !! shares of the step
    type(point_type), intent(in) :: here                !! separation and tangent at its start
    type(point_type), intent(inout) :: trial            !! -> the point at its end
    logical, intent(out) :: good                        !! whether the step is accepted
    type(newton_type) :: result
    type(step_type) :: step
    real(wp) :: matrix(3, 3), retreat
    integer :: attempt
    step = planned
    do attempt = 1, merge(3, 2, step%last .and. equations%control%traction(1))
      trial%s = here%s
      if (attempt == 2) then
        matrix = free_matrix(equations, here)
        step%predicted = predict(equations, here, values_at(equations, step%to) - values_at(equations, step%from))
        call eliminate(equations%n, matrix, step%predicted, good)
        if (.not. good) cycle
        associate (free => equations%free(:equations%n))
          trial%s(free) = here%s(free) + step%predicted(:equations%n)
        end associate
        if (law%wears .and. equations%control%traction(1)) then
          retreat = worn_retreat(law, equations, step, trial%s)
          trial%s(1) = trial%s(1) + retreat
          step%predicted(1) = step%predicted(1) + retreat
        end if
      else if (attempt == 3) then
        trial%s(1) = trial%s(1) - closer*law%length
      end if
      call newton_solve(law, equations, step%to, huge(1.0_wp), trial, result)
      if (attempt /= 2) step%predicted = result%step
      if (attempt == 2) result%first = free_matrix(equations, here)
      good = result%converged
      if (good) call judge(law, equations, step, result, here, trial, good)
      if (good) return
    end do
    good = .false.
  end subroutine solve_step

  !> Change of the opening at which the joint is just out of contact, by the wear of a step: the contact may be so stiff
  !> that facets which retreat by more than their closure leave no residual to find them by.
  pure function worn_retreat(law, equations, step, s) result(retreat)
    class(point_law), intent(in) :: law               !! the law
    type(equations_type), intent(in) :: equations     !! the equations
    type(step_type), intent(in) :: step               !! shares of the step
    real(wp), intent(in) :: s(3)                      !! separation, length
    real(wp) :: retreat
    type(equations_type) :: local
    type(point_type) :: point
    real(wp) :: r(3), scale
    logical :: good
    retreat = 0.0_wp
    local = equations
    call evaluate(law, local, free_part(local, s), step%from, point, r, scale, good)
    if (.not. good) return
    retreat = -law%contact_opening(s, point%state)
    call evaluate(law, local, free_part(local, s), step%to, point, r, scale, good)
    retreat = retreat + law%contact_opening(s, point%state)
  end function worn_retreat

  !> Whether a converged step continues the curve.
  pure subroutine judge(law, equations, step, result, old, new, good)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates are counted
    type(step_type), intent(in) :: step                 !! the step
    type(newton_type), intent(in) :: result             !! of Newton's method
    type(point_type), intent(in) :: old, new            !! both ends of the step
    logical, intent(out) :: good                        !! whether the step is accepted
    type(point_type) :: back
    real(wp) :: change(3), ending(3), extent, matrix(3, 3), move(3), prescribed, scale
    good = .true.
    if (equations%n == 0) return
    good = .not. unstable(equations%n, result%last, law%stiffness) .and. &
      maxval(abs(new%s)) <= farthest_equilibrium(law, equations, 1.0_wp)
    move = free_part(equations, new%s - old%s)
    if (.not. good .or. maxval(abs(move)) <= unexplained*law%length) return
    good = result%stable
    if (.not. good .or. law%cannot_soften(equations%old%state)) return
    change = values_at(equations, step%to) - values_at(equations, step%from)
    prescribed = maxval(abs(change)/merge(law%stiffness, 1.0_wp, equations%control%traction))
    ! damage that takes time never breaks the bond: the joint has no length of its own once it is open
    extent = law%length
    if (law%relaxes .and. equations%control%dt > 0.0_wp) extent = max(extent, maxval(abs(old%s), &
      mask=equations%control%traction))
    ! a step that cannot be halved may be longer than this in the prescribed values themselves
    if (step%last .and. prescribed > unexplained*law%length) return
    good = maxval(abs(move)) <= longest_change*extent
    if (.not. good) good = alike(equations%n, result%first, result%last)
    if (.not. good) return
    if (law%relaxes .or. law%wears) then
      ! the step back, as the tangent does not have the effect of time and wear
      call evaluate(law, equations, free_part(equations, new%s), step%from, back, ending, scale, good)
    else
      ending = predict(equations, new, change)
    end if
    matrix = result%last
    if (good) call eliminate(equations%n, matrix, ending, good)
    if (good) good = maxval(abs(move - 0.5_wp*(step%predicted + ending))) <= &
      max(unexplained*extent, unexplained_share*prescribed)
  end subroutine judge

  !> Whether two derivatives of the residual differ by so little that the curve between them has no fold: their
  !> difference is at most half of the first one (half of Kantorovich's bound).
  pure function alike(n, first, last) result(yes)
    integer, intent(in) :: n                           !! unknowns
    real(wp), intent(in) :: first(3, 3), last(3, 3)    !! derivatives, stress/length
    logical :: yes
    real(wp), parameter :: half = 0.5_wp
    real(wp) :: matrix(3, 3), x(3)
    integer :: k
    yes = .true.
    do k = 1, n
      matrix = first
      x = last(:, k) - first(:, k)
      call eliminate(n, matrix, x, yes)
      if (yes) yes = sum(abs(x(:n))) <= half
      if (.not. yes) return
    end do
  end function alike

end module asperity_follow
