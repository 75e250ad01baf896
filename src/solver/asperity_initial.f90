!> Initial states: the separation at which a point, virgin or damaged, carries a traction before its first increment.
!>
!> That separation is stored as the offset (STATEV 6-8), which the law adds to the separation of the host.
module asperity_initial
  use asperity_call_checks, only: state_status
  use asperity_checks, only: bounded
  use asperity_contract, only: n_statev, plane_statev, status_initial, status_ok, v_friction, v_offset, v_rupture, &
    v_status
  use asperity_control_point, only: control_type, equations_type, new_equations, new_point
  use asperity_interface, only: interface_type, start_damage
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance_equations, ended_lost, report_type
  use asperity_rie_law, only: new_rie_law, rie_law, slipped_separation, timeless_law
  use asperity_text, only: append, integer_text, set_text, to_text
  use asperity_tolerances, only: coarsest_initial_scale, finest_initial_scale, initial_increments, &
    longest_initial_step, residual_tolerance
  implicit none
  private
  public :: first_traction, carry_traction, explain_initial

contains

  !> Whether a point has an initial traction: STATEV 5 is 0 and the traction is finite and not zero.
  !>
  !> The test uses the bits: a traction that is not finite comes from an array that the host left undefined.
  pure function first_traction(traction, state) result(yes)
    real(wp), intent(in) :: traction(3)   !! (N, Tx, Ty), 0 where the host has no such component; any bits
    real(wp), intent(in) :: state(:)      !! STATEV
    logical :: yes
    yes = .not. abs(state(v_status)) > 0.0_wp
    if (yes) yes = all(bounded(traction, huge(1.0_wp)))
    if (yes) yes = any(abs(traction) > 0.0_wp)
  end function first_traction

  !> Set the offset of a state so that it carries a traction; the state does not change if it cannot carry it.
  !>
  !> The traction grows in equal increments from the traction that the state carries at its offset or, if the offset is
  !> zero, at the separation that fits the slips of its planes best. Damage and slips follow that load path, without
  !> viscous damage and wear. Rupture and friction count from the initial state on, as nobody knows what it has cost.
  !> The separation of the host is assumed to be zero; if it is not, the caller subtracts it from the offset.
  pure subroutine carry_traction(joint, target, prescribed, state, status, carried, endless)
    type(interface_type), intent(in) :: joint          !! the interface
    real(wp), intent(in) :: target(3)                  !! traction (N, Tx, Ty), stress
    logical, intent(in) :: prescribed(3)               !! true: prescribed; false: the separation is constant
    real(wp), intent(inout), contiguous :: state(:)    !! STATEV; offset, planes, damage and stored energy are
                                                       !! replaced
    integer, intent(out) :: status                     !! 0, status_initial, or those of state_status
    real(wp), intent(out), optional :: carried(3)      !! largest carried part of the traction, stress
    logical, intent(out), optional :: endless          !! whether planes open or slide without bound beyond
                                                       !! `carried`; if not, no stable equilibrium was found
    !> Largest number of times that damage which the guard prevented on the load path may grow at its end.
    integer, parameter :: most_repeats = 100
    type(rie_law) :: law
    type(control_type) :: control
    type(equations_type) :: equations
    type(report_type) :: report
    real(wp) :: old(joint%n_statev), s(3), start(3)
    integer :: i, repeats

    if (present(carried)) carried = 0.0_wp
    if (present(endless)) endless = .false.
    status = state_status(joint, state)
    if (status /= status_ok) return
    if (any(prescribed .and. .not. bounded(target, largest_traction(joint)))) status = status_initial
    if (status /= status_ok) return
    law = timeless_law(joint)
    old = state(:joint%n_statev)
    s = old(v_offset:v_offset + 2)
    if (.not. any(abs(s) > 0.0_wp)) s = slipped_separation(joint, old, prescribed)
    old(v_offset:v_offset + 2) = 0.0_wp
    control%traction = prescribed
    equations%old = new_point(law, old, s)
    repeats = 0
    load: do
      start = equations%old%traction
      do i = 1, initial_increments
        call set_increment(law, control, start, target, i, equations)
        call advance_equations(law, equations, report)
        if (equations%done < 1.0_wp) exit load
      end do
      ! damage that the guard prevented on the load path may grow at its end: solve once more from there
      old = equations%old%state
      equations%old = new_point(law, old, equations%old%s)
      repeats = repeats + 1
      if (.not. joint%material%guard .or. repeats > most_repeats) exit load
      if (.not. any(grown(joint, old, equations%old%state))) exit load
    end do load
    if (present(carried)) carried = start + (real(min(i, initial_increments) - 1, wp) + equations%done)/ &
      real(initial_increments, wp)*(target - start)
    if (present(endless)) endless = report%ended == ended_lost
    if (equations%done < 1.0_wp) then
      status = status_initial
      return
    end if
    equations%old%state(v_offset:v_offset + 2) = equations%old%s
    equations%old%state([v_rupture, v_friction, v_status]) = state([v_rupture, v_friction, v_status])
    equations%old%state(n_statev(joint%pattern%n) + 1:) = state(n_statev(joint%pattern%n) + 1:joint%n_statev)
    state(:joint%n_statev) = equations%old%state

  end subroutine carry_traction

  !> Equations of an increment of the traction; their residual is smaller than that of a load path.
  pure subroutine set_increment(law, control, start, target, number, equations)
    type(rie_law), intent(in) :: law                    !! the law
    type(control_type), intent(in) :: control           !! which tractions are prescribed
    real(wp), intent(in) :: start(3), target(3)         !! traction at both ends of the load path, stress
    integer, intent(in) :: number                       !! of the increment, 1 to initial_increments
    type(equations_type), intent(inout) :: equations    !! the point at the start; the equations are set
    real(wp) :: from(3), to(3)
    from = start + real(number - 1, wp)/real(initial_increments, wp)*(target - start)
    to = start + real(number, wp)/real(initial_increments, wp)*(target - start)
    if (number == initial_increments) to = target
    from = merge(from, equations%old%s, control%traction)
    to = merge(to, equations%old%s, control%traction)
    call new_equations(law, control, from, to, equations)
    equations%wears = .false.
    equations%finest = max(finest_initial_scale*law%stress, &
      16.0_wp*epsilon(1.0_wp)/residual_tolerance*law%magnitude(equations%old%s, equations%old%state))
    equations%coarsest = coarsest_initial_scale
    equations%longest = longest_initial_step
  end subroutine set_increment

  !> Whether the damage of a plane has grown.
  pure function grown(joint, old, new) result(yes)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: old(:), new(:)      !! STATEV before and after
    logical :: yes(joint%pattern%n)
    integer :: k
    do k = 1, joint%pattern%n
      yes(k) = new(plane_statev(k)) > start_damage(joint, old(plane_statev(k)))
    end do
  end function grown

  !> Largest admissible traction: that of an elastic plane at the largest separation, stress.
  pure function largest_traction(joint) result(largest)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: largest
    type(rie_law) :: law
    law = new_rie_law(joint)
    largest = law%stiffness*law%bound
  end function largest_traction

  !> Append why a state cannot carry a traction and what it carries; nothing is appended if it can carry the traction.
  pure subroutine explain_initial(joint, target, prescribed, state, message)
    type(interface_type), intent(in) :: joint                  !! the interface
    real(wp), intent(in) :: target(3)                          !! traction (N, Tx, Ty), stress
    logical, intent(in) :: prescribed(3)                       !! whether the traction is to be carried
    real(wp), intent(in), contiguous :: state(:)               !! STATEV
    character(len=:), allocatable, intent(inout) :: message    !! a line is appended
    character(len=4), parameter :: names(3) = ["t_N ", "t_Tx", "t_Ty"]
    character(len=:), allocatable :: reason
    real(wp), dimension(joint%n_statev) :: pressed
    real(wp) :: carried(3), in_proportion(3), most
    integer :: dead, i, status
    logical :: endless, excessive(3)

    most = largest_traction(joint)
    excessive = prescribed .and. .not. bounded(target, most)
    do i = 1, 3
      if (excessive(i)) call append(message, "initial " // trim(names(i)) // " = " // to_text(target(i)) // &
        ": expected a finite traction of magnitude up to " // to_text(most))
    end do
    if (any(excessive)) return
    pressed = state(:joint%n_statev)
    call carry_traction(joint, target, prescribed, pressed, status, in_proportion, endless)
    if (status /= status_initial) return

    dead = count([(state(plane_statev(i)) >= 1.0_wp, i=1, joint%pattern%n)])
    if (.not. endless) then
      call set_text(reason, "no equilibrium was found")
    else if (dead < joint%pattern%n) then
      call set_text(reason, "beyond the strength of the planes, of which " // integer_text(dead) // " of " // &
        integer_text(joint%pattern%n) // " are fully damaged")
    else if (target(1) > 0.0_wp) then
      call set_text(reason, "tension on a crack, every plane being fully damaged")
    else
      call set_text(reason, "outside the friction of the pattern")
    end if
    ! the normal traction first, to find out which component is not carried
    call carry_traction(joint, [target(1), 0.0_wp, 0.0_wp], prescribed, pressed, status, carried)
    if (status /= status_ok) then
      call append(message, "initial t_N = " // to_text(target(1)) // ": " // reason // "; it carries t_N = " // &
        to_text(carried(1)))
      return
    end if
    call carry_traction(joint, target, prescribed, pressed, status, carried)
    if (status == status_ok) then
      call append(message, "initial t_N, t_Tx, t_Ty = " // triple(target) // &
        ": no equilibrium where it grows in proportion; it carries " // triple(in_proportion))
      return
    end if
    call append(message, "initial t_Tx, t_Ty = " // to_text(target(2)) // ", " // to_text(target(3)) // ": " // &
      reason // "; with t_N = " // to_text(target(1)) // " it carries " // to_text(carried(2)) // ", " // &
      to_text(carried(3)))

  contains

    !> Text of three numbers.
    pure function triple(x) result(text)
      real(wp), intent(in) :: x(3)   !! any bits
      character(len=len(to_text(x(1))) + len(to_text(x(2))) + len(to_text(x(3))) + 4) :: text
      text = to_text(x(1)) // ", " // to_text(x(2)) // ", " // to_text(x(3))
    end function triple

  end subroutine explain_initial

end module asperity_initial
