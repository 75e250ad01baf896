!> Whether a step to a solution of the equations continues the curve of equilibria: one formula of named tests.
module asperity_acceptance
  use asperity_elimination, only: eliminate
  use asperity_equations, only: alike, equations_type, farthest_equilibrium, free_matrix, largest_move, &
    look_back, point_type, predict, unstable
  use asperity_kinds, only: wp
  use asperity_newton, only: newton_solve, newton_type
  use asperity_point_law, only: point_law
  use asperity_tolerances, only: finest_scale, longest_change, overshoot, residual_tolerance, unexplained, &
    unexplained_fraction
  implicit none
  private
  public :: judge, carries_nothing, releases, predicted_to_move_little, slides_on_one_axis, cannot_be_smaller, &
    explained_by_both_tangents, explained_by_midpoint

  !> A step whose end Newton's method has found.
  type, public :: step_type
    real(wp) :: fractions(2) = 0.0_wp   !! of the increment, at both ends
    real(wp) :: change(3) = 0.0_wp      !! of the prescribed values
    logical :: last = .false.           !! whether the step cannot be halved
    type(newton_type) :: result         !! of Newton's method; its step is what the tangent at the start predicts
  end type step_type

contains

  !> Whether a step is accepted: it has a stable end within reach, which carries a load unless the step releases it, and
  !> its move is small or explained.
  subroutine judge(law, equations, step, old, new, accepted)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates are counted
    type(step_type), intent(in) :: step                 !! the step
    type(point_type), intent(in) :: old, new            !! both ends of the step
    logical, intent(out) :: accepted                    !! the answer
    real(wp) :: matrix(3, 3), move
    accepted = .true.
    if (.not. any(equations%control%traction)) return
    accepted = .not. unstable(step%result%last, law%stiffness) .and. &
      maxval(abs(new%s)) <= farthest_equilibrium(law, equations, 1.0_wp)
    if (accepted .and. .not. damage_takes_time(law, equations)) then
      if (carries_nothing(law, equations, new)) accepted = releases(law, equations, step, old)
    end if
    if (.not. accepted) return
    move = largest_move(equations, old, new)
    matrix = free_matrix(law, equations, old)
    if (move <= unexplained*law%s_0) then
      accepted = step%last .or. law%rate_dependent .or. law%wears .or. alike(matrix, step%result%last)
      if (.not. accepted) accepted = predicted_to_move_little(law, equations, step, old)
      return
    end if
    accepted = step%result%stable
    if (.not. accepted .or. slides_on_one_axis(law, equations) .or. cannot_be_smaller(law, equations, step)) return
    associate (own => own_length(law, equations, old))
      ! no fold is to be expected between two ends that are alike
      if (move > longest_change*own) accepted = alike(matrix, step%result%last)
      if (accepted) call explained_by_both_tangents(law, equations, step, old, new, accepted)
      ! planes may break or jam between two ends that are alike
      if (accepted .and. move > own) call explained_by_midpoint(law, equations, step, old, new, accepted)
    end associate
  end subroutine judge

  !> Whether damage takes time, so that it releases a traction without a move.
  pure function damage_takes_time(law, equations) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations, with the duration of the increment
    logical :: yes
    yes = law%rate_dependent .and. equations%control%dt > 0.0_wp
  end function damage_takes_time

  !> Whether the traction of a point is a rounding error, such as what is left of a release.
  pure function carries_nothing(law, equations, point) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(point_type), intent(in) :: point           !! the point
    logical :: yes
    yes = maxval(abs(point%traction)) <= residual_tolerance*law%magnitude(point%s, equations%old%state)
  end function carries_nothing

  !> Whether a point carries nothing, or its tangent, if it predicts anything, releases what it carries just at the end
  !> of a step. Otherwise a joint that carries nothing at this end is on another branch, even if it has not moved.
  pure function releases(law, equations, step, point) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(step_type), intent(in) :: step             !! the step; one that cannot be halved may release more
    type(point_type), intent(in) :: point           !! the point before it
    real(wp) :: ahead(3), left
    logical :: predicted, yes
    yes = carries_nothing(law, equations, point)
    if (yes) return
    call predicted_move(law, equations, step, point, ahead, predicted)
    yes = .not. predicted
    if (yes) return
    ahead = merge(ahead, step%change, equations%control%traction)
    left = dot_product(point%traction + matmul(point%tangent, ahead), point%traction)
    yes = left <= 0.0_wp
    ! what is left of an earlier release may go at once
    if (step%last .or. maxval(abs(point%traction)) <= finest_scale*law%stress) return
    if (yes) yes = left >= -overshoot*dot_product(point%traction, point%traction)
  end function releases

  !> Whether the tangent at the start of a step predicts no longer move than one that needs no explanation: a jump back
  !> may cancel the move.
  pure function predicted_to_move_little(law, equations, step, old) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(step_type), intent(in) :: step             !! the step
    type(point_type), intent(in) :: old             !! the point at its start
    real(wp) :: ahead(3)
    logical :: predicted, yes
    call predicted_move(law, equations, step, old, ahead, predicted)
    yes = .not. predicted
    if (predicted) yes = maxval(abs(ahead), mask=equations%control%traction) <= unexplained*law%s_0
  end function predicted_to_move_little

  !> Whether one separation alone is free, and the joint cannot soften: beside other free separations friction may be
  !> unstable without softening.
  pure function slides_on_one_axis(law, equations) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    logical :: yes
    yes = count(equations%control%traction) == 1
    if (yes) yes = law%cannot_soften(equations%old%state)
  end function slides_on_one_axis

  !> Whether a step that cannot be halved is longer in the prescribed values themselves than what needs no explanation.
  pure function cannot_be_smaller(law, equations, step) result(yes)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(step_type), intent(in) :: step             !! the step
    logical :: yes
    yes = step%last .and. prescribed_move(law, equations, step) > unexplained*law%s_0
  end function cannot_be_smaller

  !> Whether the move of a step is the mean of the moves that the tangents at both ends predict.
  subroutine explained_by_both_tangents(law, equations, step, old, new, yes)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates are counted
    type(step_type), intent(in) :: step                 !! the step
    type(point_type), intent(in) :: old, new            !! both ends of the step
    logical, intent(out) :: yes                         !! the answer
    type(point_type) :: earlier
    real(wp) :: ending(3), matrix(3, 3)
    call look_back(law, equations, step%fractions(1), new, earlier, yes)
    if (.not. yes) return
    ending = predict(equations, new, step%change) + merge(earlier%traction - new%traction, 0.0_wp, &
      equations%control%traction)
    matrix = step%result%last
    call eliminate(3, matrix, ending, yes)
    if (yes) yes = maxval(abs(new%s - old%s - 0.5_wp*(step%result%step + ending)), &
      mask=equations%control%traction) <= tolerated(law, equations, step, old)
  end subroutine explained_by_both_tangents

  !> Whether the middle of a step lies on the line between its ends, and is stable.
  subroutine explained_by_midpoint(law, equations, step, old, new, yes)
    class(point_law), intent(in) :: law                 !! the law
    type(equations_type), intent(inout) :: equations    !! the equations; updates are counted
    type(step_type), intent(in) :: step                 !! the step
    type(point_type), intent(in) :: old, new            !! both ends of the step
    logical, intent(out) :: yes                         !! the answer
    type(newton_type) :: halfway
    type(point_type) :: middle
    middle%s = 0.5_wp*(old%s + new%s)
    call newton_solve(law, equations, 0.5_wp*sum(step%fractions), huge(1.0_wp), middle, halfway)
    yes = halfway%converged .and. halfway%stable .and. maxval(abs(middle%s - 0.5_wp*(old%s + new%s)), &
      mask=equations%control%traction) <= tolerated(law, equations, step, old)
  end subroutine explained_by_midpoint

  !> Change of the free separations that the tangent at a point predicts for a step, length.
  pure subroutine predicted_move(law, equations, step, point, move, predicted)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(step_type), intent(in) :: step             !! the step
    type(point_type), intent(in) :: point           !! the point
    real(wp), intent(out) :: move(3)                !! 0 where the separation is prescribed
    logical, intent(out) :: predicted               !! false: the tangent predicts nothing
    real(wp) :: matrix(3, 3)
    matrix = free_matrix(law, equations, point)
    move = predict(equations, point, step%change)
    call eliminate(3, matrix, move, predicted)
  end subroutine predicted_move

  !> Length with which a move is compared: neither a joint without bond nor one that is open and whose damage takes time
  !> has one of its own.
  pure function own_length(law, equations, old) result(own)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(point_type), intent(in) :: old             !! the point at the start of a step
    real(wp) :: own
    own = law%s_0
    if (law%cannot_soften(equations%old%state) .or. damage_takes_time(law, equations)) own = max(own, &
      maxval(abs(old%s), mask=equations%control%traction))
  end function own_length

  !> Change of the prescribed values in a step, as separations, length.
  pure function prescribed_move(law, equations, step) result(move)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(step_type), intent(in) :: step             !! the step
    real(wp) :: move
    move = maxval(abs(step%change)/merge(law%stiffness, 1.0_wp, equations%control%traction))
  end function prescribed_move

  !> Tolerated difference between a move and what explains it, length.
  pure function tolerated(law, equations, step, old) result(difference)
    class(point_law), intent(in) :: law             !! the law
    type(equations_type), intent(in) :: equations   !! the equations
    type(step_type), intent(in) :: step             !! the step
    type(point_type), intent(in) :: old             !! the point at its start
    real(wp) :: difference
    difference = max(unexplained*own_length(law, equations, old), &
      unexplained_fraction*prescribed_move(law, equations, step))
  end function tolerated

end module asperity_acceptance
