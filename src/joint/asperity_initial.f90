!> Initial states: the separation at which a point, virgin or damaged, carries a traction before its first increment.
!>
!> That separation is stored as the offset (STATEV 6-8), which the law adds to the separation of the host.
module asperity_initial
  use asperity_call_checks, only: state_status
  use asperity_checks, only: bounded
  use asperity_contract, only: n_facet_statev, n_statev, status_initial, status_ok, v_friction, v_offset, v_rupture, &
    v_status
  use asperity_crushing, only: crushing_place
  use asperity_equations, only: ramp
  use asperity_interface, only: interface_type, plane_damage, start_damage
  use asperity_kinds, only: wp
  use asperity_increment, only: advance, control_type, ended_lost, new_point, point_type, report_type
  use asperity_rie_law, only: new_rie_law, rate_independent_law, rie_law, slipped_separation
  use asperity_text, only: append, integer_text, set_text, to_text
  use asperity_tolerances, only: initial_increments, most_repeats, residual_tolerance
  implicit none
  private
  public :: first_traction, carry_traction, explain_initial

contains

  !> Whether a point has an initial traction: STATEV 5 is 0 and the traction is finite and not zero.
  !>
  !> The test uses the bits: a traction that is not finite comes from an array that the host left undefined.
  pure function first_traction(traction, state) result(yes)
    real(wp), intent(in) :: traction(3)   !! (N, Tx, Ty), 0 where the host has no such component; any bits
    real(wp), intent(in) :: state(v_status)   !! STATEV up to this value
    logical :: yes
    yes = .not. abs(state(v_status)) > 0.0_wp
    if (yes) yes = all(bounded(traction, huge(1.0_wp)))
    if (yes) yes = any(abs(traction) > 0.0_wp)
  end function first_traction

  !> Set the offset of a state so that it carries a traction; the state does not change if it cannot carry it.
  !>
  !> The traction grows in equal increments from the traction that the state carries at its offset or, if the offset is
  !> zero, at the separation that fits the slips of its planes best. Damage, slips and crushed shares follow that load
  !> path, without viscous damage and wear by work. Rupture, friction and its work on the facets count from the initial
  !> state on, as nobody knows what that state has cost.
  !> The separation of the host is assumed to be zero; if it is not, the caller subtracts it from the offset.
  subroutine carry_traction(joint, target, prescribed, state, status, carried, endless)
    type(interface_type), intent(in) :: joint          !! the interface
    real(wp), intent(in) :: target(3)                  !! traction (N, Tx, Ty), stress
    logical, intent(in) :: prescribed(3)               !! true: prescribed; false: the separation is constant
    real(wp), intent(inout), contiguous :: state(:)    !! STATEV; offset, planes, damage and stored energy are
                                                       !! replaced
    integer, intent(out) :: status                     !! 0, status_initial, or those of state_status
    real(wp), intent(out), optional :: carried(3)      !! largest carried part of the traction, stress
    logical, intent(out), optional :: endless          !! whether planes open or slide without bound beyond
                                                       !! `carried`; if not, no stable equilibrium was found
    type(rie_law) :: law
    type(point_type) :: point
    type(report_type) :: report
    real(wp) :: old(joint%n_statev), first(3), last(3), reached, s(3), start(3), wanted(3)
    integer :: i, end, repeats

    if (present(carried)) carried = 0.0_wp
    if (present(endless)) endless = .false.
    law = rate_independent_law(joint)
    status = state_status(joint, state)
    if (status /= status_ok) return
    if (any(prescribed .and. .not. bounded(target, law%stiffness*law%bound))) status = status_initial
    if (status /= status_ok) return
    ! a rounding error of the host is no tension; the strength of a joint without bond is a number in name only
    wanted = target
    if (start_damage(joint, 0.0_wp) < 1.0_wp) wanted = merge(0.0_wp, target, &
      abs(target) <= residual_tolerance*law%stress)
    old = state(:joint%n_statev)
    s = old(v_offset:v_offset + 2)
    if (.not. any(abs(s) > 0.0_wp)) s = slipped_separation(joint, old, prescribed)
    old(v_offset:v_offset + 2) = 0.0_wp
    point = new_point(law, old, s)
    do repeats = 0, most_repeats
      start = point%traction
      do i = 1, initial_increments
        first = merge(ramp(start, wanted, real(i - 1, wp)/real(initial_increments, wp)), point%s, prescribed)
        last = merge(ramp(start, wanted, real(i, wp)/real(initial_increments, wp)), point%s, prescribed)
        call advance(law, control_type(prescribed), first, last, point, reached, report)
        if (reached < 1.0_wp) exit
      end do
      if (reached < 1.0_wp) exit
      ! damage that the guard prevented on the load path may grow at its end: solve once more from there
      old = point%state
      point = new_point(law, old, point%s)
      if (.not. joint%material%guard .or. all(plane_damage(joint, point%state) <= plane_damage(joint, old))) exit
    end do
    if (present(carried)) carried = merge(ramp(first, last, reached), target, prescribed)
    if (present(endless)) endless = report%ended == ended_lost
    if (reached < 1.0_wp) then
      status = status_initial
      return
    end if
    point%state(v_offset:v_offset + 2) = point%s
    point%state([v_rupture, v_friction, v_status]) = state([v_rupture, v_friction, v_status])
    ! the frictional work of the facets, which follow the planes
    i = n_statev(joint%pattern%n) + n_facet_statev
    end = joint%n_statev
    if (crushing_place(joint) > 0) then
      end = crushing_place(joint) - 2
      point%state(end + 2) = state(end + 2)
    end if
    point%state(i:end:n_facet_statev) = state(i:end:n_facet_statev)
    state(:joint%n_statev) = point%state
  end subroutine carry_traction

  !> Append why a state cannot carry a traction and what it carries, after `carry_traction` with status_initial.
  subroutine explain_initial(joint, target, prescribed, state, in_proportion, endless, message)
    type(interface_type), intent(in) :: joint                  !! the interface
    real(wp), intent(in) :: target(3)                          !! traction (N, Tx, Ty), stress
    logical, intent(in) :: prescribed(3)                       !! whether the traction is to be carried
    real(wp), intent(in), contiguous :: state(:)               !! STATEV
    real(wp), intent(in) :: in_proportion(3)                   !! `carried` of carry_traction, stress
    logical, intent(in) :: endless                             !! that of carry_traction
    character(len=:), allocatable, intent(inout) :: message    !! a line is appended
    character(len=4), parameter :: names(3) = ["t_N ", "t_Tx", "t_Ty"]
    character(len=:), allocatable :: reason
    type(rie_law) :: law
    real(wp) :: carried(3), most, pressed(joint%n_statev)
    integer :: damaged, i, status

    law = new_rie_law(joint)
    most = law%stiffness*law%bound
    do i = 1, 3
      if (prescribed(i) .and. .not. bounded(target(i), most)) call append(message, "initial " // &
        trim(names(i)) // " = " // to_text(target(i)) // ": expected a finite traction of magnitude up to " // &
        to_text(most))
    end do
    if (any(prescribed .and. .not. bounded(target, most))) return
    damaged = count(plane_damage(joint, state) >= 1.0_wp)
    if (damaged == joint%pattern%n .and. target(1) > 0.0_wp) then
      call set_text(reason, "tension on a crack, every plane being fully damaged")
    else if (.not. endless) then
      call set_text(reason, "no equilibrium was found")
    else if (damaged < joint%pattern%n) then
      call set_text(reason, "beyond the strength of the planes, of which " // integer_text(damaged) // " of " // &
        integer_text(joint%pattern%n) // " are fully damaged")
    else
      call set_text(reason, "outside the friction of the pattern")
    end if
    ! the normal traction first, to find out which component is not carried
    pressed = state(:joint%n_statev)
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
    else
      call append(message, "initial t_Tx, t_Ty = " // to_text(target(2)) // ", " // to_text(target(3)) // ": " // &
        reason // "; with t_N = " // to_text(target(1)) // " it carries " // to_text(carried(2)) // ", " // &
        to_text(carried(3)))
    end if

  contains

    !> Text of three numbers.
    pure function triple(x) result(text)
      real(wp), intent(in) :: x(3)   !! any bits
      character(len=len(to_text(x(1))) + len(to_text(x(2))) + len(to_text(x(3))) + 4) :: text
      text = to_text(x(1)) // ", " // to_text(x(2)) // ", " // to_text(x(3))
    end function triple

  end subroutine explain_initial

end module asperity_initial
