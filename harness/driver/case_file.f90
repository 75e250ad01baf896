!> Meaning of a case file: material, pattern, load path or replay, and the expected end. `print_format`, which
!> `rie_driver --help` calls, describes the groups and their entries.
module case_file
  use, intrinsic :: iso_fortran_env, only: output_unit
  use asperity_checks, only: review_props
  use asperity_contract, only: status_ok
  use asperity_host, only: component_map, vumat_map
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  use asperity_refine, only: explain_tolerance
  use asperity_steps, only: check_steps, step_type
  use asperity_text, only: append, integer_text, to_text
  use case_initial, only: carry_initial, initial_type, read_initial
  use case_material, only: prop_entries, read_props
  use case_state, only: check_state, check_umat_state, read_state, state_type
  use case_steps, only: read_steps
  use case_text, only: entry_where, group_index, group_where, listed, name_index, name_length, text_type, &
    token_text, unknown_name
  use case_umat, only: read_umat
  use case_values, only: get_integer, get_logical, get_real, get_reals, get_string
  use asperity_point_law, only: point_law
  use asperity_rie_law, only: new_rie_law
  use asperity_foreign_umat, only: foreign_law
  use recorded_strains, only: read_strains, strains_type
  use text_file, only: lower
  implicit none
  private
  public :: interpret_case, get_law, print_format, read_sweep

  character(len=*), parameter :: group_names(10) = [character(len=8) :: "case", "material", "pattern", "step", &
    "expect", "sweep", "replay", "state", "initial", "umat"]

  !> {group} is replaced by the constants of a group with their defaults.
  character(len=*), parameter :: case_format(48) = [character(len=104) :: &
    "case file: groups &name entry = value, ... /; comments after !; names in any case", &
    "  &case      title = '...', planes = .false.                                     ! optional", &
    "             tolerance   relative, 1e-8 to 0.1: increments are halved until two runs of the whole path", &
    "               agree; rows are left out where straight lines stay within it", &
    "  &material  {material}", &
    "             kn, ks instead of sigma0, Gc, eta and kc: a joint without bond", &
    "  &pattern   sides, {pattern}", &
    "             or normals = n_N, n_Tx, n_Ty, ..., weights = gamma, ...", &
    "  &umat      instead of both: library = 'file', symbol = 'umat_', props = ..., nstatv = 0,", &
    "             length, stiffness (separation at the strength, elastic stiffness), order = 'N,Tx,Ty',", &
    "             thickness = 1, state = ... (STATEV at the start), damage = 0 (STATEV for this column),", &
    "             limit = 60 (s for an increment); for checks ntens = 2, 3, 6 (numbers of components that it", &
    "             can have), energies = .true.", &
    "  &step      one or more; each starts from the end of the last one", &
    "    s_N | t_N, s_Tx | t_Tx, s_Ty | t_Ty   target separation or traction: one value or a list", &
    "               (a shorter list repeats its last value); without an entry a component keeps its last", &
    "               prescribed value, in the first step s = 0", &
    "    slip, direction = 0   s_Tx and s_Ty together, along a direction (degrees from Tx to Ty)", &
    "    k_N, k_Tx, k_Ty       stiffness of the surroundings (CNS): the traction is its target minus", &
    "               k (s - s at the start of the step), until k is set again or s is prescribed", &
    "    increments = 100      to each target, one number or a list", &
    "    follow = 'stable'     jumps where the stable path ends; 'branch': continues along the unstable", &
    "               part, where the prescribed values turn back and forward again; every step is a row", &
    "    arc = 0.05            longest step along the branch over s0, instead of increments", &
    "    cycles = 1            number of times that the lists are followed", &
    "    time = 1.0            duration of the step, or a list: to each target", &
    "  &expect    end = 'complete' | 'lost', and values of the last row (columns, or slip = |s_T|) within", &
    "             tolerance; when = value of the sweep: for that run only             ! optional", &
    "  &sweep     name = 'x', values = ...: a run for every value; x stands for a number  ! optional", &
    "  &initial   traction = t_N, t_Tx, t_Ty, damage = alpha, slip = s_dit, s_dih: state of the planes at", &
    "             the start (for all planes, or for each), and the traction that they carry at separation", &
    "             zero                                                                ! optional", &
    "  &state     separation = s_N, s_Tx, s_Ty, statev = ..., work: start of the run (else virgin, s = 0);", &
    "             a run that loses equilibrium writes OUT.failed.nml with this group  ! optional", &
    "  &replay    instead of &step: file = '...' (CSV beside the case), through = 'umat', ntens = 3,", &
    "             {replay}, dtime = 1; columns s_N, s_Tx, s_Ty or", &
    "             e_1 ... e_<ntens>, time; through = 'vumat': ntens = 2 or 3, in blocks of block = 136", &
    "             points, tensor shears", &
    "example: slip of 0.6 along 30 degrees under a normal traction of -5", &
    "  &material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /", &
    "  &pattern sides = 4, theta = 30.0 /", &
    "  &step t_N = -5.0 /", &
    "  &step slip = 0.6, direction = 30.0, increments = 240 /", &
    "rows: step, increment, time, separation, traction, damage, energies, Newton iterations (of a replay:", &
    "  calls), event: onset, damaged, open, close, slip, snap, turn, substeps, cut, lost; joined by +", &
    "  onset, damaged: damage begins, is complete; open, close, slip: of a plane; snap: to another branch;", &
    "  turn: the prescribed values turn; substeps: sub-increments; cut: umat requested a smaller one;", &
    "  lost: no equilibrium beyond it"]

  !> Points of a block of vumat: the number of Abaqus/Explicit, and the largest admissible number.
  integer, parameter :: default_points = 136, most_points = 1000

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

  !> Replay of recorded strains through a host adapter.
  type, public :: replay_type
    character(len=:), allocatable :: file   !! CSV
    integer :: ntens = 3                    !! components of the host
    integer :: block = 0                    !! points of a block of vumat, 0: umat
    real(wp) :: dtime = 1.0_wp              !! time increment where the file has no time
  end type replay_type

  !> A case that has been checked.
  type, public :: case_type
    character(len=:), allocatable :: title
    logical :: planes = .false.                   !! whether each plane has columns
    logical :: refines = .false.                  !! whether the increments are refined to a tolerance
    real(wp) :: tolerance = 0.0_wp                !! of the load path, relative
    real(wp), allocatable :: props(:)             !! PROPS
    type(interface_type) :: joint                 !! not with &umat
    type(foreign_law) :: umat                     !! law of &umat, if it is given
    type(initial_type) :: initial                 !! planes and traction at the start
    type(state_type) :: state                     !! state at the start of the steps
    type(step_type), allocatable :: steps(:)      !! size 0: a replay
    type(expect_type) :: expect
    type(replay_type) :: replay
    type(strains_type) :: strains                 !! strains of the replay
  end type case_type

contains

  !> Law of a case.
  subroutine get_law(case, law)
    type(case_type), intent(in) :: case                   !! the case
    class(point_law), allocatable, intent(out) :: law     !! that of &umat, or of the interface
    if (case%umat%given) then
      allocate (law, source=case%umat)
    else
      allocate (law, source=new_rie_law(case%joint))
    end if
  end subroutine get_law

  !> Print the format of a case file on standard output.
  subroutine print_format()
    character(len=*), parameter :: groups(3) = [character(len=8) :: "material", "pattern", "replay"]
    character(len=:), allocatable :: line
    integer :: at, i, k
    do i = 1, size(case_format)
      line = trim(case_format(i))
      do k = 1, size(groups)
        at = index(line, "{" // trim(groups(k)) // "}")
        if (at > 0) line = line(:at - 1) // prop_entries(trim(groups(k)), .true.) // line(at + len_trim(groups(k)) + 2:)
      end do
      write (output_unit, "(a)") line
    end do
  end subroutine print_format

  !> Name and values of the sweep of a case; no values: the case runs once.
  subroutine read_sweep(text, name, values, message)
    type(text_type), intent(in) :: text                       !! the file
    character(len=:), allocatable, intent(out) :: name        !! as it is written
    real(wp), allocatable, intent(out) :: values(:)           !! of the name
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    character(len=*), parameter :: letters = "abcdefghijklmnopqrstuvwxyz"
    integer :: e, earlier, g, i, j

    name = ""
    allocate (values(0))
    earlier = len(message)
    g = group_index(text, "sweep")
    if (g == 0) return
    do e = text%groups(g)%first, text%groups(g)%last
      select case (text%entries(e)%name)
      case ("name")
        call get_string(text, e, name, message)
        if (verify(lower(name), letters // "_0123456789") > 0 .or. scan(lower(name), letters) /= 1 &
          .or. len(name) > name_length) then
          call append(message, entry_where(text, e) // ": expected a name of letters, digits and _")
        end if
      case ("values")
        call get_reals(text, e, values, message)
        do i = 2, size(values)
          do j = 1, i - 1
            if (to_text(values(i)) == to_text(values(j))) call append(message, entry_where(text, e) // ": " // &
              to_text(values(i)) // " is given twice")
          end do
        end do
      case default
        call unknown_name(text, e, "name, values", message)
      end select
    end do
    if (len(message) > earlier) return
    if (len(name) == 0 .or. size(values) == 0) then
      call append(message, group_where(text, g) // "expected name and values")
    else if (.not. any([(stands_for(text, i, name), i=1, text%n_tokens)])) then
      call append(message, group_where(text, g) // "name = '" // name // "' stands for no number of the case: " // &
        "expected " // name // " as a value of another group")
    end if
  end subroutine read_sweep

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

  !> Read a case from its text; text%variable has the value of the sweep.
  subroutine interpret_case(text, sweep_values, case, message)
    type(text_type), intent(in) :: text                       !! the file
    real(wp), intent(in) :: sweep_values(:)                   !! of the variable, size 0: no sweep
    type(case_type), intent(out) :: case                      !! defined if nothing was appended
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    character(len=:), allocatable :: complaint
    !> That of the direction of a slip.
    real(wp), parameter :: rounding = 1.0e-12_wp
    integer :: e, earlier, status
    logical :: prescribed(3), refines

    earlier = len(message)
    call check_groups(text, message)
    call read_case_group(text, case, message)
    call read_umat(text, case%umat, case%props, message)
    if (.not. case%umat%given) call read_props(text, case%props, message)
    call read_initial(text, case%initial, message)
    call read_state(text, case%state, message)
    call read_steps(text, case%steps, message)
    refines = case%refines .and. len(message) == earlier
    if (refines) call explain_tolerance(case%tolerance, case%steps, group_where(text, group_index(text, "case")), &
      message)
    call read_expect(text, sweep_values, case%expect, message)
    call read_replay(text, case%replay, message)
    if (len(message) > earlier) return
    if (case%umat%given) then
      call check_umat_state(text, case%umat, case%state, message)
      call check_steps(case%umat, case%steps, text%path // ": ", message)
      do e = 1, merge(size(case%steps), 0, case%umat%position(3) == 0)
        if (maxval(abs(case%steps(e)%targets(3, :))) > rounding*maxval(abs(case%steps(e)%targets))) then
          call append(message, case%steps(e)%place // "Ty is not zero: expected an order with Ty, as order = '" // &
            case%umat%order // "' has none")
        end if
      end do
      return
    end if
    call new_interface(case%props, case%joint, status)
    if (status /= status_ok) then
      allocate (character(len=0) :: complaint)
      call review_props(case%props, status, complaint)
      call append(message, text%path // ": " // complaint)
      return
    end if
    prescribed = .true.
    prescribed(3) = case%replay%ntens > 2
    call carry_initial(text, case%joint, prescribed, size(case%steps) == 0, case%initial, message)
    if (case%initial%given) then
      case%state%given = .true.
      case%state%statev = case%initial%carried
    end if
    call check_state(text, case%joint, case%state, message)
    call check_steps(new_rie_law(case%joint), case%steps, text%path // ": ", message)
    if (size(case%steps) > 0) return
    if (case%replay%block > 0) then
      call read_strains(case%replay%file, case%replay%ntens, vumat_map(1, case%replay%ntens - 1), 0.5_wp, &
        case%replay%dtime, case%joint, case%strains, message)
    else
      call read_strains(case%replay%file, case%replay%ntens, component_map(case%replay%ntens, case%joint%map), &
        1.0_wp, case%replay%dtime, case%joint, case%strains, message)
    end if
  end subroutine interpret_case

  !> Check that every group is known and not given too often.
  subroutine check_groups(text, message)
    type(text_type), intent(in) :: text                       !! the file
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    integer :: g, i, n(size(group_names))

    n = 0
    do g = 1, text%n_groups
      i = name_index(text%groups(g)%name, group_names)
      if (i == 0) then
        call append(message, group_where(text, g) // "unknown group: expected " // listed(group_names, "&"))
        cycle
      end if
      n(i) = n(i) + 1
      if (n(i) == 2 .and. all(group_names(i) /= ["step  ", "expect"])) call append(message, group_where(text, g) // &
        "given twice, first in line " // integer_text(text%groups(group_index(text, trim(group_names(i))))%line))
    end do
    if (n(name_index("umat", group_names)) > 0) then
      do i = 1, text%n_groups
        if (any(text%groups(i)%name == ["material", "pattern ", "initial ", "replay  "])) call append(message, &
          group_where(text, i) // "does not go with &umat: expected the one or the other")
      end do
    else
      do i = 2, 3
        if (n(i) == 0) call append(message, text%path // ": no group &" // trim(group_names(i)))
      end do
    end if
    i = name_index("step", group_names)
    g = name_index("replay", group_names)
    if ((n(i) > 0) .eqv. (n(g) > 0)) call append(message, text%path // ": " // integer_text(n(i)) // &
      " groups &step and " // integer_text(n(g)) // " &replay: expected one or more &step, or one &replay")
  end subroutine check_groups

  !> Read the group &case.
  subroutine read_case_group(text, case, message)
    type(text_type), intent(in) :: text                       !! the file
    type(case_type), intent(inout) :: case                    !! title and planes are set
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    integer :: e, g
    logical :: refines
    case%title = ""
    refines = .false.
    g = group_index(text, "case")
    if (g == 0) return
    do e = text%groups(g)%first, text%groups(g)%last
      select case (text%entries(e)%name)
      case ("title")
        call get_string(text, e, case%title, message)
      case ("planes")
        call get_logical(text, e, case%planes, message)
      case ("tolerance")
        refines = .true.
        call get_real(text, e, case%tolerance, message)
      case default
        call unknown_name(text, e, "title, planes, tolerance", message)
      end select
    end do
    case%refines = refines
  end subroutine read_case_group

  !> Read the group &expect for the current value of the sweep: the group with this value of `when`, else the one
  !> without `when`.
  subroutine read_expect(text, sweep_values, expect, message)
    type(text_type), intent(in) :: text                       !! the file
    real(wp), intent(in) :: sweep_values(:)                   !! of the variable, size 0: no sweep
    type(expect_type), intent(out) :: expect                  !! what is expected
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    type(expect_type) :: found
    character(len=:), allocatable :: word
    real(wp) :: when
    logical :: specific, is_specific
    integer :: e, g, i

    specific = .false.
    do g = 1, text%n_groups
      if (text%groups(g)%name /= "expect") cycle
      found = expect_type(line=text%groups(g)%line)
      is_specific = .false.
      when = 0.0_wp
      do e = text%groups(g)%first, text%groups(g)%last
        i = name_index(text%entries(e)%name, expect_names)
        if (i > 0) then
          found%given(i) = .true.
          call get_real(text, e, found%values(i), message)
          cycle
        end if
        select case (text%entries(e)%name)
        case ("end")
          word = ""
          call get_string(text, e, word, message)
          found%lost = lower(word) == "lost"
          if (all(lower(word) /= ["lost    ", "complete"])) call append(message, entry_where(text, e) // &
            ": expected 'complete' or 'lost'")
        case ("tolerance")
          ! an admissible value remains if the given one is no number
          found%tolerance = 1.0_wp
          call get_real(text, e, found%tolerance, message)
          if (found%tolerance < 0.0_wp) call append(message, entry_where(text, e) // ": expected >= 0")
        case ("when")
          is_specific = .true.
          call get_real(text, e, when, message)
          if (all(abs(sweep_values - when) > 0.0_wp)) call append(message, entry_where(text, e) // &
            ": expected a value of &sweep")
        case default
          call unknown_name(text, e, "end, tolerance, when, " // listed(expect_names, ""), message)
        end select
      end do
      if (any(found%given) .and. .not. found%tolerance > 0.0_wp) call append(message, group_where(text, g) // &
        "values without a tolerance: expected tolerance > 0")
      if (is_specific .and. abs(when - text%variable_value) > 0.0_wp) cycle
      if (expect%line > 0 .and. (specific .eqv. is_specific)) then
        call append(message, group_where(text, g) // "given twice for the same run, first in line " // &
          integer_text(expect%line))
      else if (is_specific .or. .not. specific) then
        expect = found
        specific = is_specific
      end if
    end do
  end subroutine read_expect

  !> Read the group &replay without its entries of PROPS.
  subroutine read_replay(text, replay, message)
    type(text_type), intent(in) :: text                       !! the file
    type(replay_type), intent(out) :: replay                  !! what to replay
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    character(len=:), allocatable :: through
    integer :: e, g

    g = group_index(text, "replay")
    if (g == 0) return
    through = "umat"
    replay%file = ""
    do e = text%groups(g)%first, text%groups(g)%last
      select case (text%entries(e)%name)
      case ("file")
        call get_string(text, e, replay%file, message)
        if (index(replay%file, "/") /= 1) replay%file = text%path(:index(text%path, "/", back=.true.)) // replay%file
      case ("through")
        call get_string(text, e, through, message)
        if (all(through /= ["umat ", "vumat"])) call append(message, entry_where(text, e) // &
          ": expected 'umat' or 'vumat'")
      case ("block")
        call get_integer(text, e, 1, most_points, replay%block, message)
      case ("ntens")
        call get_integer(text, e, 2, 6, replay%ntens, message)
        if (all(replay%ntens /= [2, 3, 6])) call append(message, entry_where(text, e) // ": expected 2, 3 or 6")
      case ("dtime")
        call get_real(text, e, replay%dtime, message)
        if (replay%dtime < 0.0_wp) call append(message, entry_where(text, e) // ": expected >= 0")
      case default
        continue   ! an entry of PROPS, or an unknown one that read_props reports
      end select
    end do
    if (through == "vumat") then
      if (replay%block == 0) replay%block = default_points
      if (replay%ntens == 6) call append(message, group_where(text, g) // "ntens = 6 through vumat: expected 2 or 3")
    else if (replay%block > 0) then
      call append(message, group_where(text, g) // "block without through = 'vumat'")
    end if
    if (len(replay%file) == 0) call append(message, group_where(text, g) // &
      "expected file = 'a CSV of recorded strains'")
  end subroutine read_replay

end module case_file
