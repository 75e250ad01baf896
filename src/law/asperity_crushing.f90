!> A joint that is crushed: its law in series with a plastic closure kappa, which takes what its pressure exceeds
!> (docs/extensions.md).
!>
!> The law sees the separation s_N + kappa, and updates its state from that at the start of the increment, whatever
!> kappa is tried. A joint whose strength is not exceeded pays one comparison.
module asperity_crushing
  use asperity_cap, only: curve_at, curve_type, excess_of, excess_type, parameter_of, strength_at, withstands
  use asperity_contract, only: cap_statev, most_statev, v_friction, v_rupture, v_stored
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_point_kernel, only: update_point_in_place
  use asperity_types, only: most_parts, part_ends
  implicit none
  private
  public :: closed_by, crushing, crushing_place, exceeds, plastic_closure, update_crushed

  !> What a trial of a plastic closure gives.
  type :: trial_type
    real(wp) :: x                        !! parameter of the curve (asperity_cap)
    type(curve_type) :: curve            !! its point there
    type(excess_type) :: excess          !! of the traction
    real(wp) :: slope                    !! derivative of the excess by the parameter, stress
    real(wp) :: traction(3)              !! stress
    real(wp) :: tangent(3, 3)            !! of the law alone, stress/length
    real(wp) :: state(most_statev)       !! STATEV
  end type trial_type

  !> Excess over the strength that is a rounding error; width of a bracket that has no number within it.
  real(wp), parameter :: rounding = 1.0e-13_wp, narrow = 4.0_wp*epsilon(1.0_wp)
  !> Trials: each third one at least halves the bracket, and a double has 64 bits.
  integer, parameter :: most_trials = 300
  !> Halvings of a step in which a smaller closure is sought.
  integer, parameter :: most_halvings = 24
  !> First steps of which half is taken where the shear alone exceeds the strength: it may do so no more under a
  !> smaller pressure, and again without one.
  integer, parameter :: most_halves = 3
  !> Growth of the bracket while its end is sought.
  real(wp), parameter :: growth = 2.0_wp

contains

  !> Plastic closure of a state, 0 without a compressive strength, length.
  pure function plastic_closure(joint, state) result(kappa)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: state(:)            !! STATEV
    real(wp) :: kappa
    kappa = 0.0_wp
    if (joint%cap%peak > 0.0_wp) kappa = state(crushing_place(joint) - 1)
  end function plastic_closure

  !> Index in STATEV of the energy that the plastic closure has dissipated, behind which there is nothing, and before it
  !> the closure; 0 without a compressive strength.
  pure function crushing_place(joint) result(place)
    type(interface_type), intent(in) :: joint   !! the interface
    integer :: place
    place = 0
    if (joint%cap%peak > 0.0_wp) place = cap_statev(joint%pattern%n, joint%material%wears) + 1
  end function crushing_place

  !> Energy that the plastic closure of a state has dissipated, 0 without a compressive strength, stress*length.
  pure function crushing(joint, state) result(energy)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: state(:)            !! STATEV
    real(wp) :: energy
    energy = 0.0_wp
    if (joint%cap%peak > 0.0_wp) energy = state(crushing_place(joint))
  end function crushing

  !> Separation that the law sees: s_N grows by the plastic closure.
  pure function closed_by(s, kappa) result(seen)
    real(wp), intent(in) :: s(3)     !! separation (N, Tx, Ty), length
    real(wp), intent(in) :: kappa    !! plastic closure, length
    real(wp) :: seen(3)
    seen = [s(1) + kappa, s(2), s(3)]
  end function closed_by

  !> Whether a traction exceeds the strength at a plastic closure.
  pure function exceeds(joint, traction, kappa) result(yes)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: traction(3)         !! (N, Tx, Ty), stress
    real(wp), intent(in) :: kappa               !! plastic closure, length
    logical :: yes
    type(excess_type) :: excess
    yes = .false.
    if (withstands(joint%cap, traction)) return
    excess = excess_of(joint%cap, strength_at(joint%cap, kappa), traction)
    yes = excess%value > rounding*joint%cap%peak
  end function exceeds

  !> As update_point_in_place, for a joint with a compressive strength.
  !>
  !> With a dashpot the accounts of a long increment in which it is crushed are those of parts of the step, each with a
  !> closure of its own; not with wear by work, as the state does not know the wear of the parts.
  pure subroutine update_crushed(joint, s_old, s, state, traction, tangent, dt, wearing)
    type(interface_type), intent(in) :: joint          !! material and pattern
    real(wp), intent(in) :: s_old(3)                   !! separation (N, Tx, Ty) at the start of the increment, length
    real(wp), intent(in) :: s(3)                       !! separation at its end, length
    real(wp), intent(inout) :: state(joint%n_statev)   !! STATEV, start -> end
    real(wp), intent(out) :: traction(3)               !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)             !! d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt               !! duration, >= 0, time
    real(wp), intent(in), optional :: wearing          !! part of the wear that is done, 0 to 1; absent: 1
    real(wp), dimension(most_statev) :: path, start
    real(wp) :: first(3), last(3), stress(3), unused(3, 3)
    integer :: at, n, part
    n = joint%n_statev
    at = cap_statev(joint%pattern%n, joint%material%wears)
    start(:n) = state
    call update_step(joint, s_old, s, state, traction, tangent, dt, wearing)
    if (joint%material%inv_w0 > 0.0_wp) return
    if (.not. (joint%material%damps .and. present(dt) .and. state(at) > start(at))) return
    if (.not. sum((s - s_old)**2)*joint%material%inv_longest_2 > 1.0_wp) return
    path(:n) = start(:n)
    first = s_old
    do part = 1, most_parts
      last = (1.0_wp - part_ends(part))*s_old + part_ends(part)*s
      call update_step(joint, first, last, path(:n), stress, unused, &
        dt*(part_ends(part) - part_ends(part - 1)), wearing)
      first = last
    end do
    state([v_rupture, v_friction, at + 1]) = path([v_rupture, v_friction, at + 1])
  end subroutine update_crushed

  !> The same, with accounts of the step as a whole.
  pure subroutine update_step(joint, s_old, s, state, traction, tangent, dt, wearing)
    type(interface_type), intent(in) :: joint          !! material and pattern
    real(wp), intent(in) :: s_old(3)                   !! separation (N, Tx, Ty) at the start of the increment, length
    real(wp), intent(in) :: s(3)                       !! separation at its end, length
    real(wp), intent(inout) :: state(joint%n_statev)   !! STATEV, start -> end
    real(wp), intent(out) :: traction(3)               !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)             !! d traction_i/d s_j, stress/length
    real(wp), intent(in), optional :: dt               !! duration, >= 0, time; absent: 0
    real(wp), intent(in), optional :: wearing          !! part of the wear that is done, 0 to 1; absent: 1
    type(trial_type) :: trial
    real(wp) :: start(most_statev), initial(3), along(3), across(3), unused(3, 3), kappa, spent
    integer :: at, n
    n = joint%n_statev
    at = cap_statev(joint%pattern%n, joint%material%wears)
    start(:n) = state
    kappa = state(at)
    call update_point_in_place(joint, closed_by(s_old, kappa), closed_by(s, kappa), state, traction, tangent, dt, &
      wearing)
    if (.not. exceeds(joint, traction, kappa)) return
    call find_closure(joint, closed_by(s_old, kappa), s, kappa, start, traction, tangent, trial, dt, wearing)
    traction = trial%traction
    tangent = trial%tangent
    ! kappa follows the separation so that the excess stays zero
    along = trial%tangent(:, 1)
    across = matmul(trial%excess%gradient, trial%tangent)
    if (trial%slope < 0.0_wp) tangent = tangent - (trial%curve%kappa_slope/trial%slope)*spread(along, 2, 3)* &
      spread(across, 1, 3)
    state = trial%state(:n)
    state(at) = max(kappa, trial%curve%kappa)
    ! the pressure at the start is that of the springs: no duration, and no wear by the work so far
    trial%state(:n) = start(:n)
    call update_point_in_place(joint, closed_by(s_old, kappa), closed_by(s_old, kappa), trial%state(:n), initial, &
      unused, wearing=0.0_wp)
    spent = 0.5_wp*(max(-initial(1), 0.0_wp) + max(-traction(1), 0.0_wp))*(state(at) - kappa)
    ! in a jump the mean of the pressures is too much, as that of the friction is: what the work leaves
    if (.not. joint%material%damps) spent = max(0.0_wp, min(spent, 0.5_wp*dot_product(initial + traction, s - s_old) - &
      (state(v_stored) - trial%state(v_stored)) - (state(v_rupture) - start(v_rupture)) - &
      (state(v_friction) - start(v_friction))))
    state(at + 1) = start(at + 1) + spent
  end subroutine update_step

  !> The smallest plastic closure that is found at which the traction does not exceed the strength: Newton's method in a
  !> bracket, of which the lower end exceeds it and the upper one does not. Where the excess jumps, as the law may at
  !> the foot of a facet, it is the upper end.
  !>
  !> Up to the peak there is one closure at most, and a step ends there. Beyond it the strength may fall faster than the
  !> pressure: where a step finds no pressure or an excess that grows, smaller closures are tried.
  pure subroutine find_closure(joint, from, s, kappa, start, traction, tangent, trial, dt, wearing)
    type(interface_type), intent(in) :: joint           !! material and pattern
    real(wp), intent(in) :: from(3)                     !! separation of the law at the start, length
    real(wp), intent(in) :: s(3)                        !! separation at the end, length
    real(wp), intent(in) :: kappa                       !! plastic closure at the start, length
    real(wp), intent(in) :: start(most_statev)          !! STATEV at the start
    real(wp), intent(in) :: traction(3), tangent(3, 3)  !! of the law with kappa
    type(trial_type), intent(out) :: trial              !! at the closure that is found
    real(wp), intent(in), optional :: dt                !! duration, >= 0, time
    real(wp), intent(in), optional :: wearing           !! part of the wear that is done
    real(wp) :: low, high, width, next
    integer :: i, since
    logical :: bracketed, falls
    low = parameter_of(joint%cap, kappa)
    trial%x = low
    trial%traction = traction
    trial%tangent = tangent
    call judge(joint, trial)
    high = huge(high)
    bracketed = .false.
    ! a closure by what the largest stiffness gives back
    width = trial%excess%value/max(joint%material%k_c, joint%material%k_n)
    width = max(parameter_of(joint%cap, kappa + width) - low, narrow*(1.0_wp + low))
    since = 0
    do i = 1, most_trials
      next = low - 1.0_wp
      if (trial%slope < 0.0_wp) next = trial%x - trial%excess%value/trial%slope
      if (.not. bracketed) then
        if (.not. (next > low .and. next <= low + width)) next = low + width
        if (i <= most_halves .and. .not. pressed(trial)) next = low + 0.5_wp*(next - low)
        if (low < joint%cap%corner) next = min(next, joint%cap%corner)
        width = growth*width
      else if (.not. (next > low .and. next < high) .or. since >= 2) then
        next = low + 0.5_wp*(high - low)
        since = 0
        width = high - low
      end if
      falls = trial%slope < 0.0_wp
      trial%x = next
      call evaluate(joint, from, s, start, trial, dt, wearing)
      if (.not. bracketed .and. ((.not. pressed(trial) .and. admissible(joint, trial)) .or. &
          (falls .and. trial%slope >= 0.0_wp))) then
        call look_back(joint, from, s, start, low, trial, dt, wearing)
        if (admissible(joint, trial)) then
          bracketed = .true.
          high = trial%x
          width = high - low
        else
          low = trial%x
        end if
        if (pressed(trial) .and. abs(trial%excess%value) <= rounding*joint%cap%peak) return
        cycle
      end if
      if (abs(trial%excess%value) <= rounding*joint%cap%peak) return
      if (trial%excess%value > 0.0_wp) then
        low = next
      else
        if (.not. bracketed) width = next - low
        bracketed = .true.
        high = next
      end if
      if (.not. bracketed) cycle
      if (high - low <= narrow*high) exit
      since = since + 1
      if (high - low <= 0.5_wp*width) then
        since = 0
        width = high - low
      end if
    end do
    if (bracketed .and. trial%x < high) then
      trial%x = high
      call evaluate(joint, from, s, start, trial, dt, wearing)
    end if
  end subroutine find_closure

  !> Look for a parameter that does not exceed the strength between a lower one, from which the excess falls, and that
  !> of a trial: where the excess is smallest, found by halving.
  pure subroutine look_back(joint, from, s, start, low, trial, dt, wearing)
    type(interface_type), intent(in) :: joint    !! material and pattern
    real(wp), intent(in) :: from(3)              !! separation of the law at the start, length
    real(wp), intent(in) :: s(3)                 !! separation at the end, length
    real(wp), intent(in) :: start(most_statev)   !! STATEV at the start
    real(wp), intent(inout) :: low               !! the lower parameter -> the last one that exceeds the strength
    type(trial_type), intent(inout) :: trial     !! -> one that does not exceed the strength, else itself
    real(wp), intent(in), optional :: dt         !! duration, >= 0, time
    real(wp), intent(in), optional :: wearing    !! part of the wear that is done
    real(wp) :: falling, last, rising, top
    integer :: k
    falling = low
    top = low
    last = trial%x
    rising = last
    do k = 1, most_halvings
      trial%x = falling + 0.5_wp*(rising - falling)
      call evaluate(joint, from, s, start, trial, dt, wearing)
      if (admissible(joint, trial)) then
        low = falling
        return
      end if
      top = max(top, trial%x)
      if (trial%slope < 0.0_wp) falling = trial%x
      if (.not. trial%slope < 0.0_wp) rising = trial%x
    end do
    low = top
    trial%x = last
    call evaluate(joint, from, s, start, trial, dt, wearing)
  end subroutine look_back

  !> Whether a trial does not exceed the strength.
  pure function admissible(joint, trial) result(yes)
    type(interface_type), intent(in) :: joint   !! with the strength
    type(trial_type), intent(in) :: trial       !! the trial
    logical :: yes
    yes = trial%excess%value <= rounding*joint%cap%peak
  end function admissible

  !> Whether a trial is one of a joint under pressure whose shear alone does not exceed the strength.
  pure function pressed(trial) result(yes)
    type(trial_type), intent(in) :: trial   !! the trial
    logical :: yes
    yes = trial%traction(1) < 0.0_wp .and. trial%excess%by_strength < 0.0_wp
  end function pressed

  !> The law at a parameter of the curve.
  pure subroutine evaluate(joint, from, s, start, trial, dt, wearing)
    type(interface_type), intent(in) :: joint    !! material and pattern
    real(wp), intent(in) :: from(3)              !! separation of the law at the start, length
    real(wp), intent(in) :: s(3)                 !! separation at the end, length
    real(wp), intent(in) :: start(most_statev)   !! STATEV at the start
    type(trial_type), intent(inout) :: trial     !! with its parameter
    real(wp), intent(in), optional :: dt         !! duration, >= 0, time
    real(wp), intent(in), optional :: wearing    !! part of the wear that is done
    trial%curve = curve_at(joint%cap, trial%x)
    trial%state(:joint%n_statev) = start(:joint%n_statev)
    call update_point_in_place(joint, from, closed_by(s, trial%curve%kappa), trial%state(:joint%n_statev), &
      trial%traction, trial%tangent, dt, wearing)
    call judge(joint, trial)
  end subroutine evaluate

  !> Excess of the traction of a trial, and its slope.
  pure subroutine judge(joint, trial)
    type(interface_type), intent(in) :: joint    !! material and pattern
    type(trial_type), intent(inout) :: trial     !! with parameter, traction and tangent
    trial%curve = curve_at(joint%cap, trial%x)
    trial%excess = excess_of(joint%cap, trial%curve%strength, trial%traction)
    trial%slope = dot_product(trial%excess%gradient, trial%tangent(:, 1))*trial%curve%kappa_slope + &
      trial%excess%by_strength*trial%curve%strength_slope
  end subroutine judge

end module asperity_crushing
