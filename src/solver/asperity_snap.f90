!> Motion from the end of a curve of equilibria to the next stable equilibrium, under constant prescribed values:
!> pseudo-transient continuation, implicit Euler steps of an overdamped motion, which the state follows. It takes no
!> time and wears nothing.
module asperity_snap
  use asperity_control_point, only: equations_type, evaluate, farthest_equilibrium, free_part, is_unstiff, &
    move_point, point_type
  use asperity_kinds, only: wp
  use asperity_newton, only: newton_solve, newton_type
  use asperity_point_law, only: point_law
  use asperity_tolerances, only: fast_growth, first_motion, least_damping, less_damping, more_damping, most_tries, &
    most_updates, shortest_motion, slow_growth, unbalanced
  implicit none
  private
  public :: snap

contains

  !> Move to the first stable equilibrium; the steps are at most s0/200, and grow. A motion that stops without an
  !> equilibrium has met a discontinuity of the law.
  pure subroutine snap(law, equations, found)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! prescribed values at the share `done`, the point at the end
                                                        !! of the curve -> at the equilibrium, or where the motion ended
    logical, intent(out) :: found                       !! whether there is an equilibrium
    type(newton_type) :: result
    type(point_type) :: trial
    real(wp) :: anchor(3), damping, drift(3), far, limit, move, residual(3), scale
    integer :: tries
    logical :: good

    limit = first_motion*law%length
    damping = law%stiffness
    drift = 0.0_wp
    ! with viscous damage there are equilibria at every separation, as no time passes
    far = farthest_equilibrium(law, equations, 0.5_wp)
    ! the motion has constant prescribed values from the start on: the energies of their last change are not its own
    call evaluate(law, equations, free_part(equations, equations%old%s), equations%done, trial, residual, scale, found)
    if (found) call move_point(trial, equations%old)
    found = .false.
    anchor = equations%old%s
    tries = 0
    do while (tries < most_tries .and. equations%updates < most_updates)
      ! is there an equilibrium near the point?
      equations%damping = 0.0_wp
      trial%s = equations%old%s
      call newton_solve(law, equations, equations%done, limit, trial, result)
      move = maxval(abs(trial%s - equations%old%s), mask=equations%control%traction)
      found = result%converged .and. result%stable .and. move <= limit .and. maxval(abs(trial%s)) <= far
      if (found) then
        found = balances(law, equations%old, trial, move)
        if (.not. found) limit = 0.5_wp*move
      end if
      if (found) then
        call move_point(trial, equations%old)
        exit
      end if
      ! start in the direction of the last step, so that the tangent of a sliding plane is that of sliding
      equations%damping = damping
      trial%s = equations%old%s + drift
      call newton_solve(law, equations, equations%done, limit, trial, result)
      move = maxval(abs(trial%s - equations%old%s), mask=equations%control%traction)
      tries = tries + 1
      good = result%converged .and. result%stable .and. move <= limit
      if (good) good = balances(law, equations%old, trial, move)
      if (.not. good) then
        damping = more_damping*damping
        drift = 0.0_wp
        cycle
      end if
      drift = trial%s - equations%old%s
      call move_point(trial, equations%old)
      if (maxval(abs(equations%old%s - anchor)) > shortest_motion*law%length) then
        anchor = equations%old%s
        tries = 0
      end if
      damping = max(less_damping*damping, least_damping*law%stiffness)
      limit = min(law%bound, limit*merge(fast_growth, slow_growth, law%cannot_soften(equations%old%state) .or. &
        is_unstiff(equations%old)))
      if (maxval(abs(equations%old%s)) > far) exit
    end do
    equations%damping = 0.0_wp
  end subroutine snap

  !> Whether the work of a step equals the energy that it stores and dissipates within `unbalanced`, so that the
  !> energies of a row that contains a snap balance, or the step is very short. The error is that of the trapezoidal
  !> rule.
  pure function balances(law, old, new, length) result(yes)
    class(point_law), intent(in) :: law        !! the law
    type(point_type), intent(in) :: old, new   !! the point before and after the step
    real(wp), intent(in) :: length             !! of the step
    logical :: yes
    real(wp) :: change(2), unit, work
    change = law%energies(new%state) - law%energies(old%state)
    work = new%work - old%work
    unit = max(law%stress*law%length, abs(work) + sum(abs(change)))
    yes = abs(work - sum(change)) <= unbalanced*min(1.0_wp, length/law%length)*unit .or. &
      length <= shortest_motion*law%length
  end function balances

end module asperity_snap
