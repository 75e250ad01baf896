!> The groups &initial, &state, &sweep and &expect of a case file: the state of the planes and the traction that they
!> carry at separation zero, or a whole state, which the case of a failed increment has; a number that varies from run
!> to run, and the expected end.
module asperity_case_groups
  use asperity_call_checks, only: explain_point, point_status
  use asperity_case_entries, only: case_io, close_group, open_group, real_entry, reals_entry, require, string_entry
  use asperity_case_text, only: group_index, name_length, text_type, token_text
  use asperity_checks, only: bounded
  use asperity_contract, only: plane_statev, status_initial, status_ok, v_damage, v_friction, v_rupture, v_stored
  use asperity_equations, only: new_point
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_initial, only: carry_traction, explain_initial
  use asperity_interface, only: interface_type, separation_bound, slip_factor
  use asperity_kinds, only: wp
  use asperity_load_path, only: row_type
  use asperity_point_law, only: point_law, point_type
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_text, only: append, integer_text, set_text, to_text
  use asperity_text_file, only: lower
  implicit none
  private
  public :: initial_group, state_group, start_point, carry_initial, check_state, sweep_group, expect_group
  public :: explain_unexpected

  !> The group &initial.
  type, public :: initial_type
    logical :: given = .false.                      !! false: virgin, without traction
    real(wp) :: traction(3) = 0.0_wp                !! total (N, Tx, Ty), stress
    real(wp) :: p = 0.0_wp                          !! water pressure, stress
    real(wp), allocatable :: damage(:)              !! of all planes or of each, size 0: none
    real(wp), allocatable :: slip(:)                !! s_dit, s_dih of all planes or of each, length, size 0: none
    type(error_type) :: of_traction, of_damage, of_slip   !! places of errors in them
    real(wp), allocatable :: planes(:)              !! STATEV as of a host before the first call: planes only
  end type initial_type

  !> The group &state.
  type, public :: state_type
    logical :: given = .false.              !! false: virgin, separation zero
    real(wp) :: s(3) = 0.0_wp               !! separation (N, Tx, Ty), length
    real(wp), allocatable :: statev(:)      !! STATEV
    real(wp) :: p = 0.0_wp                  !! water pressure, stress
    logical :: has_work = .false.           !! false: the work is the sum of stored and dissipated energy
    real(wp) :: work = 0.0_wp               !! work of the traction so far, stress*length
    logical :: has_traction = .false.       !! false: the traction is that of the state at rest
    real(wp) :: traction(3) = 0.0_wp        !! total (N, Tx, Ty) at the end of the last increment, stress
    type(error_type) :: place               !! of an error in it
  end type state_type

  !> Largest difference between a traction that is given and that of its state, relative to the terms of the latter: the
  !> rounding of six digits.
  real(wp), parameter :: least_digits = 1.0e-6_wp

  !> Values that &expect may state, in this order.
  character(len=8), parameter, public :: expect_names(12) = [character(len=8) :: "s_N", "s_Tx", "s_Ty", "t_N", "t_Tx", &
    "t_Ty", "damage", "stored", "rupture", "friction", "work", "slip"]

  !> Expected end of a case.
  type, public :: expect_type
    integer :: line = 0                            !! in the case file, 0: no such group
    logical :: lost = .false.                      !! equilibrium is lost (false: the path is completed)
    logical :: given(size(expect_names)) = .false.
    real(wp) :: values(size(expect_names)) = 0.0_wp
    real(wp) :: tolerance = 0.0_wp                 !! absolute, for all values
  end type expect_type

contains

  !> The group &initial, if there is one.
  subroutine initial_group(io, initial)
    type(case_io), intent(inout) :: io                        !! the file
    type(initial_type), intent(inout) :: initial              !! initial state
    real(wp), allocatable :: traction(:)
    type(error_type) :: of_p

    if (.not. io%writes) allocate (initial%damage(0), initial%slip(0))
    call open_group(io, "initial", initial%given)
    if (.not. initial%given) return
    traction = initial%traction
    call reals_entry(io, "traction", traction)
    initial%of_traction = io%place
    call require(io, any(size(traction) == [0, 3]), integer_text(size(traction)) // &
      " values: expected three (t_N, t_Tx, t_Ty)")
    if (size(traction) == size(initial%traction)) initial%traction = traction
    call real_entry(io, "p", initial%p, 0.0_wp)
    call require(io, initial%p >= 0.0_wp, "expected >= 0")
    of_p = io%place
    call reals_entry(io, "damage", initial%damage)
    initial%of_damage = io%place
    call require(io, all(initial%damage >= 0.0_wp .and. initial%damage <= 1.0_wp), "expected 0 to 1")
    call reals_entry(io, "slip", initial%slip)
    initial%of_slip = io%place
    call close_group(io)
    if (io%writes) return
    if (io%text%groups(io%group)%last < io%text%groups(io%group)%first) call fail(io%errors, io%place, &
      "nothing given: expected traction, damage or slip")
    if (initial%p > 0.0_wp .and. group_index(io%text, "replay") > 0) call fail(io%errors, of_p, &
      "expected 0 with &replay, whose file has no water pressure")
    if (group_index(io%text, "state") > 0) call fail(io%errors, io%place, &
      "a run starts from &initial or from &state, in line " // &
      integer_text(io%text%groups(group_index(io%text, "state"))%line) // ": expected the one or the other")
  end subroutine initial_group

  !> The group &state, if there is one.
  subroutine state_group(io, state)
    type(case_io), intent(inout) :: io                        !! the file
    type(state_type), intent(inout) :: state                  !! state at the start
    real(wp), allocatable :: s(:), traction(:)
    type(error_type) :: of_traction

    if (.not. io%writes) allocate (state%statev(0))
    call open_group(io, "state", state%given)
    if (.not. state%given) return
    allocate (s(0))
    if (io%writes) s = state%s
    if (io%writes .and. state%has_traction) traction = state%traction
    call reals_entry(io, "separation", s, any_bits=.true.)
    call reals_entry(io, "traction", traction, any_bits=.true.)
    of_traction = io%place
    call reals_entry(io, "statev", state%statev, any_bits=.true.)
    call real_entry(io, "p", state%p, 0.0_wp)
    call require(io, state%p >= 0.0_wp, "expected >= 0")
    call real_entry(io, "work", state%work, given=state%has_work)
    call close_group(io)
    if (io%writes) return
    state%place = io%place
    if (size(s) == size(state%s)) then
      state%s = s
    else
      call fail(io%errors, state%place, integer_text(size(s)) // " values of separation: expected three (N, Tx, Ty)")
    end if
    state%has_traction = allocated(traction)
    if (state%has_traction) then
      if (size(traction) == size(state%traction)) state%traction = traction
      if (all(size(traction) /= [0, size(state%traction)])) call fail(io%errors, of_traction, &
        integer_text(size(traction)) // " values: expected three (t_N, t_Tx, t_Ty)")
      if (group_index(io%text, "umat") > 0) call fail(io%errors, of_traction, &
        "expected no traction with &umat, whose statev begins with STRESS")
      state%place = io%place
    end if
    if (group_index(io%text, "replay") > 0) call fail(io%errors, state%place, &
      "a replay starts from the virgin state: expected &state with &step only")
  end subroutine state_group

  !> The point at the start of a run. Its traction, if it is given, is that of the end of another run, as a state at
  !> rest knows neither the force of a dashpot nor the damage that the guard has prevented.
  function start_point(law, state) result(point)
    class(point_law), intent(in) :: law      !! the law
    type(state_type), intent(in) :: state    !! admissible
    type(point_type) :: point
    point = new_point(law, state%statev, state%s)
    if (state%has_work) point%work = state%work
    if (.not. state%has_traction) return
    point%state = state%statev(:law%n_state)
    point%traction = state%traction + [state%p, 0.0_wp, 0.0_wp]
  end function start_point

  !> Compute the state of &initial, or of a virgin point without this group and &state; the planes must be able to carry
  !> the traction.
  subroutine carry_initial(joint, prescribed, replays, initial, state, errors)
    type(interface_type), intent(in) :: joint                 !! the interface
    logical, intent(in) :: prescribed(3)                      !! components that the host has
    logical, intent(in) :: replays                            !! whether the host adapter computes the offset
    type(initial_type), intent(inout) :: initial              !! planes are set
    type(state_type), intent(inout) :: state                  !! state at the start, with the offset of the planes
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=:), allocatable :: reasons
    real(wp) :: carried(3), in_proportion(3), largest
    integer :: earlier, i, k, status
    logical :: endless, loaded

    allocate (initial%planes(joint%n_statev))
    initial%planes = 0.0_wp
    if (.not. state%given) state%statev = initial%planes
    if (.not. initial%given) return
    state%given = .true.
    earlier = errors%n
    associate (n => joint%pattern%n, damage => initial%damage, slip => initial%slip)
      if (all(size(damage) /= [0, 1, n])) call fail(errors, initial%of_damage, &
        integer_text(size(damage)) // " values: expected " // one_or(n, 1))
      if (all(size(slip) /= [0, 2, 2*n])) call fail(errors, initial%of_slip, &
        integer_text(size(slip)) // " values: expected " // one_or(n, 2) // ", in pairs s_dit, s_dih")
      if (errors%n > earlier) return
      do k = 1, n
        i = plane_statev(k)
        if (size(damage) > 0) initial%planes(i) = damage(min(k, size(damage)))
        if (size(slip) > 0) initial%planes(i + 1:i + 2) = slip(min(2*k, size(slip)) - 1:min(2*k, size(slip)))
      end do
    end associate
    largest = slip_factor*separation_bound(joint)
    if (.not. all(bounded(initial%slip, largest))) call fail(errors, initial%of_slip, &
      "expected a magnitude up to " // to_text(largest))
    carried = [initial%traction(1) + initial%p, initial%traction(2:)]
    state%p = initial%p
    loaded = any(abs(carried) > 0.0_wp)
    if (any(abs(initial%traction) > 0.0_wp .and. .not. prescribed)) call fail(errors, &
        initial%of_traction, "expected t_Ty = 0 with ntens = 2")
    if (replays .and. .not. loaded .and. size(initial%slip) > 0) call fail(errors, &
        initial%of_slip, "expected a traction with it: a host's routine computes the " // &
      "offset of a slip only if the stress is not zero")
    if (errors%n > earlier) return
    state%statev = initial%planes
    call carry_traction(joint, carried, prescribed, state%statev, status, in_proportion, endless)
    allocate (character(len=0) :: reasons)
    if (status == status_ok) return
    if (status == status_initial) call explain_initial(joint, carried, prescribed, initial%planes, in_proportion, &
      endless, reasons)
    if (initial%p > 0.0_wp) call set_text(reasons, reasons // "; t_N is the total one and p")
    if (allocated(initial%of_traction%name)) call fail(errors, initial%of_traction, reasons)
    if (.not. allocated(initial%of_traction%name)) call fail(errors, initial%of_slip, reasons)
  end subroutine carry_initial

  !> Text of the admissible numbers of values: for all planes, or for each plane.
  pure function one_or(n, each) result(text)
    integer, intent(in) :: n      !! planes
    integer, intent(in) :: each   !! values of a plane
    character(len=:), allocatable :: text
    text = integer_text(each) // " for all planes"
    if (n > 1) text = text // " or " // integer_text(each*n) // " for " // integer_text(n) // " planes"
  end function one_or

  !> Check that the state is admissible for the interface.
  subroutine check_state(joint, state, errors)
    type(interface_type), intent(in) :: joint                 !! the interface
    type(state_type), intent(in) :: state                     !! state at the start
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=4), parameter :: names(3) = ["t_N ", "t_Tx", "t_Ty"]
    character(len=:), allocatable :: reasons
    type(rie_law) :: law
    type(point_type) :: point
    type(error_type) :: place
    real(wp) :: known(3), most, tolerated
    integer :: i
    if (.not. state%given) return
    if (size(state%statev) /= joint%n_statev) then
      call fail(errors, state%place, integer_text(size(state%statev)) // &
        " values of statev: expected " // integer_text(joint%n_statev))
    else if (point_status(joint, state%s, state%s, state%statev) /= status_ok) then
      allocate (character(len=0) :: reasons)
      call explain_point(joint, state%s, state%s, state%statev, reasons)
      call fail(errors, state%place, reasons)
    else if (state%has_traction) then
      law = new_rie_law(joint)
      point = new_point(law, state%statev, state%s)
      known = point%traction - [state%p, 0.0_wp, 0.0_wp]
      most = law%stiffness*law%bound
      tolerated = least_digits*(state%p + law%magnitude(point%s, point%state))
      place = state%place
      do i = 1, 3
        place%name = "traction"
        place%value = trim(names(i)) // " = " // to_text(state%traction(i))
        if (.not. bounded(state%traction(i), most)) then
          call fail(errors, place, "expected a finite traction of magnitude up to " // to_text(most))
        else if (.not. (joint%material%damps .or. joint%material%guard) .and. &
          abs(state%traction(i) - known(i)) > tolerated) then
          call fail(errors, place, "expected " // to_text(known(i)) // ", the traction of this state: only a " // &
            "dashpot (c) or the guard adds to it")
        end if
      end do
    end if
  end subroutine check_state

  !> Name and values of the sweep of a case; no values: the case runs once.
  subroutine sweep_group(io, name, values)
    type(case_io), intent(inout) :: io                           !! the file
    character(len=:), allocatable, intent(inout) :: name         !! as it is written
    real(wp), allocatable, intent(inout) :: values(:)            !! of the name
    character(len=*), parameter :: letters = "abcdefghijklmnopqrstuvwxyz"
    integer :: earlier, i
    logical :: given

    call set_text(name, "")
    allocate (values(0))
    earlier = io%errors%n
    call open_group(io, "sweep", given)
    if (.not. given) return
    call string_entry(io, "name", name, "")
    call require(io, verify(lower(name), letters // "_0123456789") == 0 .and. scan(lower(name), letters) == 1 .and. &
      len(name) <= name_length, "expected a name of letters, digits and _")
    call reals_entry(io, "values", values)
    do i = 2, size(values)
      if (any(abs(values(:i - 1) - values(i)) <= 0.0_wp)) call require(io, .false., to_text(values(i)) // &
        " is given twice")
    end do
    call close_group(io)
    if (io%errors%n > earlier) return
    if (len(name) == 0 .or. size(values) == 0) then
      call fail(io%errors, io%place, "expected name and values")
    else if (.not. any([(stands_for(io%text, i, name), i=1, io%text%n_tokens)])) then
      call fail(io%errors, io%place, "name = '" // name // "' stands for no number of the case: " // &
        "expected " // name // " as a value of another group")
    end if
  end subroutine sweep_group

  !> Whether a value of a case is the name of its sweep.
  pure function stands_for(text, token, name) result(yes)
    type(text_type), intent(in) :: text     !! the file
    integer, intent(in) :: token            !! which value
    character(len=*), intent(in) :: name    !! of the sweep
    logical :: yes
    character(len=:), allocatable :: word
    word = token_text(text, token)
    yes = .not. text%tokens(token)%is_string .and. lower(word(index(word, "*") + 1:)) == lower(name)
  end function stands_for

  !> The group &expect for the current value of the sweep: the group with this value of `when`, else the one without
  !> `when`.
  subroutine expect_group(io, sweep_values, expect)
    type(case_io), intent(inout) :: io                        !! the file
    real(wp), intent(in) :: sweep_values(:)                   !! of the variable, size 0: no sweep
    type(expect_type), intent(inout) :: expect                !! what is expected
    type(expect_type) :: expected
    real(wp) :: when
    logical :: is_there, specific, is_specific
    integer :: g

    if (io%writes) then
      is_there = expect%lost .or. any(expect%given)
      call open_group(io, "expect", is_there)
      if (is_there) call expect_entries(io, expect, when)
      if (is_there) call close_group(io)
      return
    end if
    specific = .false.
    do g = 1, io%text%n_groups
      if (io%text%groups(g)%name /= "expect") cycle
      call open_group(io, "expect", is_there, g)
      expected = expect_type(line=io%text%groups(g)%line)
      call expect_entries(io, expected, when, is_specific)
      call require(io, any(abs(sweep_values - when) <= 0.0_wp), "expected a value of &sweep")
      call close_group(io)
      if (any(expected%given) .and. .not. expected%tolerance > 0.0_wp) call fail(io%errors, io%place, &
        "values without a tolerance: expected tolerance > 0")
      if (is_specific .and. abs(when - io%text%variable_value) > 0.0_wp) cycle
      if (expect%line > 0 .and. (specific .eqv. is_specific)) then
        call fail(io%errors, io%place, "given twice for the same run, first in line " // integer_text(expect%line))
      else if (is_specific .or. .not. specific) then
        expect = expected
        specific = is_specific
      end if
    end do
  end subroutine expect_group

  !> Entries of &expect; the last one is `when`.
  subroutine expect_entries(io, expect, when, specific)
    type(case_io), intent(inout) :: io                        !! the file
    type(expect_type), intent(inout) :: expect                !! what is expected
    real(wp), intent(out) :: when                             !! value of the sweep, 0: none
    logical, intent(out), optional :: specific                !! whether it is given; absent: it is not written
    character(len=:), allocatable :: word
    integer :: earlier, i
    call set_text(word, "")
    if (io%writes) call set_text(word, trim(merge("lost    ", "complete", expect%lost)))
    call string_entry(io, "end", word, "complete")
    expect%lost = lower(word) == "lost"
    call require(io, any(lower(word) == ["lost    ", "complete"]), "expected 'complete' or 'lost'")
    earlier = io%errors%n
    call real_entry(io, "tolerance", expect%tolerance, 0.0_wp)
    call require(io, expect%tolerance >= 0.0_wp, "expected >= 0")
    ! an admissible value remains if the given one is no number
    if (io%errors%n > earlier) expect%tolerance = 1.0_wp
    do i = 1, size(expect_names)
      call real_entry(io, trim(expect_names(i)), expect%values(i), given=expect%given(i))
    end do
    when = 0.0_wp
    if (present(specific)) call real_entry(io, "when", when, given=specific)
  end subroutine expect_entries

  !> Append the values of the last row of a run that are not as expected, in one line.
  pure subroutine explain_unexpected(expect, last, message)
    type(expect_type), intent(in) :: expect                   !! what is expected
    type(row_type), intent(in) :: last                        !! the last row
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended where values differ
    character(len=:), allocatable :: line
    real(wp) :: values(size(expect_names))
    integer :: i
    values = [last%s, last%traction, last%state([v_damage, v_stored, v_rupture, v_friction]), last%work, &
              sqrt(last%s(2)**2 + last%s(3)**2)]
    line = ""
    do i = 1, size(values)
      if (.not. expect%given(i)) cycle
      if (abs(values(i) - expect%values(i)) <= expect%tolerance) cycle
      if (len(line) > 0) line = line // ", "
      line = line // trim(expect_names(i)) // " = " // to_text(values(i)) // ", expected " // &
        to_text(expect%values(i)) // " within " // to_text(expect%tolerance)
    end do
    if (len(line) > 0) call append(message, line)
  end subroutine explain_unexpected

end module asperity_case_groups
