!> Checks of the arguments of a call other than PROPS, for points, the UMAT and the VUMATs, and the messages for
!> rejected values.
!>
!> Each function `..._status` is a fast test. The subroutine `explain_...` after it names every bad value and what was
!> expected.
module asperity_call_checks
  use asperity_checks, only: all_bounded, bounded, review, review_props, state_bounded, state_ranges
  use asperity_contract, only: cap_statev, energy_limit, host_ntens, i_duration, i_growth, i_jump, i_longest, &
    implex_table, statev_row, statev_table, status_nstatv, status_ntens, status_ok, status_props, &
    status_separation, status_size, status_state, status_time
  use asperity_interface, only: interface_type, new_interface, separation_bound, slip_bound
  use asperity_kinds, only: wp
  use asperity_material, only: damping_lag, largest_lag
  use asperity_text, only: append, integer_text, set_text, to_text
  implicit none
  private
  public :: point_status, state_status, time_status, host_status, vumat_status
  public :: explain_point, explain_nstatv, explain_time, explain_call, explain_vumat, explain_state, host_order, &
    umat_only

contains

  !> Whether the input of a point is admissible.
  pure function point_status(joint, s_old, s, state_old, aim) result(status)
    type(interface_type), intent(in) :: joint          !! the interface
    real(wp), intent(in) :: s_old(3)                   !! separation (N, Tx, Ty) at the start, length
    real(wp), intent(in) :: s(3)                       !! separation at the end, length
    real(wp), intent(in), contiguous :: state_old(:)   !! STATEV at the start
    real(wp), intent(in), optional :: aim(3)           !! separation of frozen variables, length
    integer :: status                                  !! 0, status_nstatv, status_state or status_separation
    real(wp) :: bound
    bound = separation_bound(joint)
    status = status_separation
    if (present(aim)) then
      if (.not. all_bounded(3, aim, bound)) return
    end if
    if (all_bounded(3, s, bound) .and. all_bounded(3, s_old, bound)) status = state_status(joint, state_old)
  end function point_status

  !> Append one line for each value of the input of a point that is not admissible.
  pure subroutine explain_point(joint, s_old, s, state_old, message, aim)
    type(interface_type), intent(in) :: joint                  !! the interface
    real(wp), intent(in) :: s_old(:)                           !! (3) separation (N, Tx, Ty) at the start, length
    real(wp), intent(in) :: s(:)                               !! (3) separation at the end, length
    real(wp), intent(in), contiguous :: state_old(:)           !! (nstatv) STATEV at the start
    character(len=:), allocatable, intent(inout) :: message    !! lines are appended
    real(wp), intent(in), optional :: aim(3)                   !! separation of frozen variables, length
    character(len=4), parameter :: names(3) = ["s_N ", "s_Tx", "s_Ty"]
    real(wp) :: bound
    integer :: i
    bound = separation_bound(joint)
    do i = 1, 3
      call review(message, trim(names(i)) // " at the start", s_old(i), bound, .true.)
      call review(message, trim(names(i)), s(i), bound, .true.)
      if (present(aim)) call review(message, trim(names(i)) // " of the aim", aim(i), bound, .true.)
    end do
    call explain_state(joint, state_old, energy_limit, slip_bound(joint), message)
  end subroutine explain_point

  !> Whether STATEV has enough values, each of them in its range.
  pure function state_status(joint, state) result(status)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in), contiguous :: state(:)    !! STATEV
    integer :: status                               !! 0, status_nstatv or status_state
    status = status_nstatv
    if (size(state) < joint%n_statev) return
    status = merge(status_ok, status_state, state_bounded(joint%pattern%n, joint%material%wears, joint%n_statev, &
      state, energy_limit, slip_bound(joint)))
  end function state_status

  !> Append a line about a number of state variables that is too small.
  pure subroutine explain_nstatv(joint, name, nstatv, message)
    type(interface_type), intent(in) :: joint                 !! the interface
    character(len=*), intent(in) :: name                      !! name of the number in the caller's interface
    integer, intent(in) :: nstatv                             !! as passed, may be negative
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended
    character(len=:), allocatable :: why
    call set_text(why, "")
    if (joint%implex > 0.0_wp) call set_text(why, " and implex")
    call append(message, name // " = " // integer_text(nstatv) // ": expected at least " // &
      integer_text(joint%n_umat_statev) // " for " // integer_text(joint%pattern%n) // " planes" // why)
  end subroutine explain_nstatv

  !> Place of state variable i of the law in STATEV of a UMAT: IMPL-EX comes before the compressive strength.
  pure function host_index(joint, i) result(place)
    type(interface_type), intent(in) :: joint       !! the interface
    integer, intent(in) :: i                        !! from 1
    integer :: place
    place = i
    if (i >= cap_statev(joint%pattern%n, joint%material%wears)) place = i + (joint%n_umat_statev - joint%n_statev)
  end function host_index

  !> Places in STATEV of a UMAT of the state variables of the law, and then those of IMPL-EX.
  pure function host_order(joint) result(places)
    type(interface_type), intent(in) :: joint       !! the interface
    integer :: places(joint%n_umat_statev)
    integer :: i
    places(:joint%n_statev) = [(host_index(joint, i), i=1, joint%n_statev)]
    places(joint%n_statev + 1:) = [(cap_statev(joint%pattern%n, joint%material%wears) - 1 + i, &
      i=1, joint%n_umat_statev - joint%n_statev)]
  end function host_order

  !> Append one line for each bad value of STATEV, or a line if STATEV is too short.
  pure subroutine explain_state(joint, state, energy, slip, message)
    type(interface_type), intent(in) :: joint                 !! the interface
    real(wp), intent(in), contiguous :: state(:)              !! STATEV
    real(wp), intent(in) :: energy                            !! largest energy, stress*length
    real(wp), intent(in) :: slip                              !! largest slip and offset, length
    character(len=:), allocatable, intent(inout) :: message   !! lines are appended
    real(wp) :: bound(joint%n_statev)
    logical :: signed(joint%n_statev)
    integer :: i
    if (size(state) < joint%n_statev) then
      call explain_nstatv(joint, "NSTATV", size(state), message)
      return
    end if
    call state_ranges(joint%pattern%n, joint%material%wears, energy, slip, bound, signed)
    do i = 1, joint%n_statev
      call review(message, "STATEV(" // integer_text(host_index(joint, i)) // ") " // trim(statev_table(statev_row(i, &
        joint%pattern%n, joint%material%wears))%name), state(i), bound(i), signed(i))
    end do
  end subroutine explain_state

  !> Whether the duration of an increment is admissible; without viscous damage and dashpot every duration is.
  pure function time_status(joint, dt) result(status)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in), optional :: dt            !! duration, any bits, time
    integer :: status                               !! 0 or status_time
    logical :: good
    good = .not. (joint%material%tau_v > 0.0_wp .or. joint%material%damps .or. joint%implex > 0.0_wp)
    if (present(dt) .and. .not. good) then
      good = bounded(dt, huge(1.0_wp))
      if (good) good = dt >= 0.0_wp
      ! without a dashpot or a duration there is no lag
      if (good) good = damping_lag(joint%material, dt) < largest_lag
    end if
    status = merge(status_ok, status_time, good)
  end function time_status

  !> Append a line about the duration that `time_status` rejected.
  pure subroutine explain_time(joint, name, message, dt)
    type(interface_type), intent(in) :: joint                  !! the interface
    character(len=*), intent(in) :: name                       !! name of the duration in the caller's interface
    character(len=:), allocatable, intent(inout) :: message    !! a line is appended
    real(wp), intent(in), optional :: dt                       !! duration, any bits, time
    character(len=:), allocatable :: wanted
    if (time_status(joint, dt) == status_ok) return
    call set_text(wanted, ": expected a finite time increment >= 0")
    if (joint%material%tau_v > 0.0_wp) call set_text(wanted, wanted // " (viscous damage, tau_v = " // &
      to_text(joint%material%tau_v) // ")")
    if (joint%material%damps) call set_text(wanted, wanted // " (dashpot, c = " // to_text(joint%material%damping) // &
      ": 0, or more than 1e-10 c/(kc Kn))")
    if (joint%implex > 0.0_wp) call set_text(wanted, wanted // " (IMPL-EX, implex = " // to_text(joint%implex) // ")")
    if (present(dt)) then
      call append(message, name // " = " // to_text(dt) // wanted)
    else
      call append(message, name // " is missing" // wanted)
    end if
  end subroutine explain_time

  !> Whether the arguments of a call of the UMAT are admissible.
  pure function host_status(joint, position, ntens, stran, dstran, nstatv, statev, dtime) result(status)
    type(interface_type), intent(in) :: joint       !! the interface
    integer, intent(in) :: position(3)              !! component_map
    integer, intent(in) :: ntens, nstatv            !! components of the host, state variables
    real(wp), intent(in) :: stran(ntens), dstran(ntens)   !! strain at the start, increment
    real(wp), intent(in) :: statev(nstatv)          !! state at the start
    real(wp), intent(in), optional :: dtime         !! time increment
    integer :: status                               !! 0, status_ntens, status_time or those of point_status
    real(wp) :: bound
    status = status_ntens
    if (position(1) == 0) return
    status = time_status(joint, dtime)
    if (status /= status_ok) return
    status = status_separation
    bound = strain_bound(joint)
    if (.not. (all_bounded(ntens, stran, bound) .and. all_bounded(ntens, dstran, bound))) return
    status = status_nstatv
    if (nstatv < joint%n_umat_statev) return
    status = state_status(joint, statev)
    if (status /= status_ok .or. .not. joint%implex > 0.0_wp) return
    if (.not. implex_bounded(joint, statev(joint%n_statev + 1:joint%n_umat_statev))) status = status_state
  end function host_status

  !> Append one line for each bad argument of a call of the UMAT.
  pure subroutine explain_call(nprops, props, ntens, stran, dstran, nstatv, statev, message, dtime)
    integer, intent(in) :: nprops, nstatv                     !! as passed: an array of a negative size has size 0
    real(wp), intent(in), contiguous :: props(:)              !! PROPS
    integer, intent(in) :: ntens                              !! components of the host
    real(wp), intent(in), contiguous :: stran(:), dstran(:)   !! (ntens) strain at the start, increment
    real(wp), intent(in), contiguous :: statev(:)             !! state at the start
    character(len=:), allocatable, intent(inout) :: message   !! lines are appended
    real(wp), intent(in), optional :: dtime                   !! time increment
    type(interface_type) :: joint
    integer :: i, status

    if (all(host_ntens /= ntens)) call append(message, "NTENS = " // integer_text(ntens) // ": expected 2, 3 or 6")
    call review_props(props, status, message, nprops)
    if (status /= status_ok) return
    call new_interface(props, joint, status)
    do i = 1, size(stran)
      call review(message, "STRAN(" // integer_text(i) // ")", stran(i), strain_bound(joint), .true.)
      call review(message, "DSTRAN(" // integer_text(i) // ")", dstran(i), strain_bound(joint), .true.)
    end do
    call explain_time(joint, "DTIME", message, dtime)
    if (nstatv < joint%n_umat_statev) then
      call explain_nstatv(joint, "NSTATV", nstatv, message)
      return
    end if
    call explain_state(joint, statev, energy_limit, slip_bound(joint), message)
    if (joint%implex > 0.0_wp) call explain_implex(joint, statev(joint%n_statev + 1:joint%n_umat_statev), message)
  end subroutine explain_call

  !> Whether the state variables of IMPL-EX are in their ranges; the errors are never read.
  pure function implex_bounded(joint, implex) result(yes)
    type(interface_type), intent(in) :: joint         !! the interface
    real(wp), intent(in), contiguous :: implex(:)     !! state variables of IMPL-EX, any bits
    logical :: yes
    yes = all_bounded(3, implex(i_jump:), slip_bound(joint)) .and. &
      all_bounded(2, implex(i_duration:), huge(1.0_wp)) .and. all_bounded(joint%pattern%n, implex(i_growth:), 1.0_wp)
    if (yes) yes = all(implex(i_duration:i_longest + joint%pattern%n) >= 0.0_wp)
  end function implex_bounded

  !> Append one line for each state variable of IMPL-EX that is not in its range.
  pure subroutine explain_implex(joint, implex, message)
    type(interface_type), intent(in) :: joint                 !! the interface
    real(wp), intent(in), contiguous :: implex(:)             !! state variables of IMPL-EX, any bits
    character(len=:), allocatable, intent(inout) :: message   !! lines are appended
    real(wp) :: bound
    integer :: first, i
    first = cap_statev(joint%pattern%n, joint%material%wears)
    do i = 1, i_longest + joint%pattern%n
      bound = merge(1.0_wp, merge(huge(bound), slip_bound(joint), i >= i_duration), i >= i_growth)
      call review(message, "STATEV(" // integer_text(first - 1 + i) // ") " // &
        trim(implex_table(min(i, i_growth))%name), implex(i), bound, i < i_duration)
    end do
  end subroutine explain_implex

  !> Line about IMPL-EX where no UMAT is called.
  pure function umat_only(joint) result(text)
    type(interface_type), intent(in) :: joint         !! the interface
    character(len=:), allocatable :: text
    call set_text(text, "PROPS(25) implex = " // to_text(joint%implex) // &
      ": expected 0, as IMPL-EX belongs to the UMAT alone")
  end function umat_only

  !> Largest admissible strain component of a UMAT: half of the separation bound over h, so that the sum of STRAN and
  !> DSTRAN stays within the bound.
  pure function strain_bound(joint) result(bound)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: bound
    bound = 0.5_wp*separation_bound(joint)/joint%h
  end function strain_bound

  !> Whether the arguments of a VUMAT that concern the whole block are admissible.
  pure function vumat_status(joint, nblock, component, nstatev, dt, smallest, largest) result(status)
    type(interface_type), intent(in) :: joint       !! the interface
    integer, intent(in) :: nblock                   !! points
    integer, intent(in) :: component(3)             !! vumat_map
    integer, intent(in) :: nstatev                  !! state variables
    real(wp), intent(in) :: dt                      !! time increment
    real(wp), intent(in) :: smallest, largest       !! positive numbers of the host's real kind
    integer :: status                               !! 0, or status_... time, ntens, nstatv, size, props
    status = time_status(joint, dt)
    if (status /= status_ok) return
    if (joint%implex > 0.0_wp) then
      status = status_props
    else if (component(1) == 0) then
      status = status_ntens
    else if (nstatev < joint%n_statev) then
      status = status_nstatv
    else if (nblock < 0) then
      status = status_size
    else if (joint%h < sqrt(smallest) .or. joint%h > sqrt(largest)) then
      status = status_props   ! products with h would leave the range of the kind
    end if
  end function vumat_status

  !> Append one line for each bad argument of a VUMAT that concerns the whole block.
  pure subroutine explain_vumat(status, nblock, nprops, props, ndir, nshr, nstatev, dt, message)
    integer, intent(in) :: status                             !! of the test that failed
    integer, intent(in) :: nblock, nprops                     !! as the host passed them
    real(wp), intent(in), contiguous :: props(:)              !! PROPS
    integer, intent(in) :: ndir, nshr, nstatev                !! as the host passed them
    real(wp), intent(in) :: dt                                !! time increment
    character(len=:), allocatable, intent(inout) :: message   !! lines are appended
    type(interface_type) :: joint
    integer :: props_status
    call review_props(props, props_status, message, nprops)
    if (props_status /= status_ok) return
    call new_interface(props, joint, props_status)
    if (joint%implex > 0.0_wp) then
      call append(message, umat_only(joint))
    else if (status == status_ntens) then
      call append(message, "ndir, nshr = " // integer_text(ndir) // ", " // integer_text(nshr) // &
        ": expected 1, 2 or (2D) 1, 1")
    else if (status == status_nstatv) then
      call explain_nstatv(joint, "nstatev", nstatev, message)
    else if (status == status_size) then
      call append(message, "nblock = " // integer_text(nblock) // " points: expected 0 or more")
    else if (status == status_time) then
      call explain_time(joint, "dt", message, dt)
    else
      call append(message, "PROPS: constants of the law leave the range of the host's real kind: expected other units")
    end if
  end subroutine explain_vumat

end module asperity_call_checks
