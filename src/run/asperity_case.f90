!> Reader of case files: material, pattern, load path or replay, initial state and expected end, for every value of a
!> sweep. `asperity_case_format` describes the groups and their entries.
module asperity_case
  use asperity_case_expect, only: expect_type, read_expect, read_sweep
  use asperity_case_initial, only: carry_initial, initial_type, read_initial
  use asperity_case_material, only: read_props
  use asperity_case_state, only: check_state, read_state, state_type
  use asperity_case_steps, only: read_steps
  use asperity_case_text, only: group_index, listed, name_index, of_entry, of_file, of_group, read_text, text_type, &
    unknown_name
  use asperity_case_umat, only: read_umat, umat_type
  use asperity_case_values, only: get_integer, get_logical, get_real, get_string
  use asperity_checks, only: review_props
  use asperity_contract, only: status_ok
  use asperity_errors, only: errors_type, fail, fail_lines
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  use asperity_refine, only: explain_tolerance
  use asperity_rie_law, only: new_rie_law
  use asperity_steps, only: check_steps, step_type
  use asperity_text, only: integer_text
  use asperity_text_file, only: lower
  implicit none
  private
  public :: read_cases

  character(len=*), parameter :: group_names(10) = [character(len=8) :: "case", "material", "pattern", "step", &
    "expect", "sweep", "replay", "state", "initial", "umat"]

  !> Points of a block of vumat: the number of Abaqus/Explicit, and the largest admissible number.
  integer, parameter :: default_points = 136, most_points = 1000

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
    type(umat_type) :: umat                       !! UMAT of &umat, if it is given
    type(initial_type) :: initial                 !! planes and traction at the start
    type(state_type) :: state                     !! state at the start of the steps
    type(step_type), allocatable :: steps(:)      !! size 0: a replay
    type(expect_type) :: expect
    type(replay_type) :: replay
  end type case_type

  !> A case file: its sweep and a case for each value of it, or one case.
  type, public :: case_file_type
    character(len=:), allocatable :: sweep        !! name of the number that varies, empty: none
    real(wp), allocatable :: values(:)            !! of this number, size 0: none
    type(case_type), allocatable :: cases(:)
    integer :: pattern(2) = 0                     !! first and last byte of the group &pattern
  end type case_file_type

contains

  !> Read a case file, or a text in its form. What depends on a UMAT of others, its state and steps, is not checked.
  subroutine read_cases(path, file, errors, source)
    character(len=*), intent(in) :: path                   !! file, or the name of the text in errors; may be empty
    type(case_file_type), intent(out) :: file              !! defined if no error was added
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=*), intent(in), optional :: source       !! the text, instead of the file
    type(text_type) :: text
    integer :: earlier, g, i
    earlier = errors%n
    file%sweep = ""
    call read_text(path, text, errors, source)
    if (errors%n > earlier) return
    call read_sweep(text, file%sweep, file%values, errors)
    if (errors%n > earlier) return
    text%variable = lower(file%sweep)
    g = group_index(text, "pattern")
    if (g > 0) file%pattern = [text%groups(g)%from, text%groups(g)%to]
    allocate (file%cases(max(1, size(file%values))))
    do i = 1, size(file%cases)
      if (size(file%values) > 0) text%variable_value = file%values(i)
      call interpret_case(text, file%values, file%cases(i), errors)
      if (errors%n > earlier) return
    end do
  end subroutine read_cases

  !> Read a case from its text; text%variable has the value of the sweep.
  subroutine interpret_case(text, sweep_values, case, errors)
    type(text_type), intent(in) :: text          !! the file
    real(wp), intent(in) :: sweep_values(:)      !! of the variable, size 0: no sweep
    type(case_type), intent(out) :: case         !! defined if no error was added
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=:), allocatable :: lines
    integer :: earlier, status
    logical :: prescribed(3), refines

    earlier = errors%n
    call check_groups(text, errors)
    call read_case_group(text, case, errors)
    call read_umat(text, case%umat, errors)
    allocate (case%props(0))
    if (.not. case%umat%given) call read_props(text, case%props, errors)
    call read_initial(text, case%initial, errors)
    call read_state(text, case%state, errors)
    call read_steps(text, case%steps, errors)
    refines = case%refines .and. errors%n == earlier
    if (refines) call explain_tolerance(case%tolerance, case%steps, errors, &
      of_group(text, group_index(text, "case")))
    call read_expect(text, sweep_values, case%expect, errors)
    call read_replay(text, case%replay, errors)
    if (errors%n > earlier .or. case%umat%given) return
    call new_interface(case%props, case%joint, status)
    if (status /= status_ok) then
      lines = ""
      call review_props(case%props, status, lines, by_name=.true.)
      call fail_lines(errors, of_file(text), lines)
      return
    end if
    prescribed = .true.
    prescribed(3) = case%replay%ntens > 2
    call carry_initial(text, case%joint, prescribed, size(case%steps) == 0, case%initial, errors)
    if (case%initial%given) then
      case%state%given = .true.
      case%state%statev = case%initial%carried
    end if
    call check_state(case%joint, case%state, errors)
    call check_steps(new_rie_law(case%joint), case%steps, errors, of_file(text))
  end subroutine interpret_case

  !> Check that every group is known and not given too often.
  subroutine check_groups(text, errors)
    type(text_type), intent(in) :: text                       !! the file
    type(errors_type), intent(inout) :: errors   !! errors are added
    integer :: g, i, n(size(group_names))

    n = 0
    do g = 1, text%n_groups
      i = name_index(text%groups(g)%name, group_names)
      if (i == 0) then
        call fail(errors, of_group(text, g), "unknown group: expected " // listed(group_names, "&"))
        cycle
      end if
      n(i) = n(i) + 1
      if (n(i) == 2 .and. all(group_names(i) /= ["step  ", "expect"])) call fail(errors, of_group(text, g), &
        "given twice, first in line " // integer_text(text%groups(group_index(text, trim(group_names(i))))%line))
    end do
    if (n(name_index("umat", group_names)) > 0) then
      do i = 1, text%n_groups
        if (any(text%groups(i)%name == ["material", "pattern ", "initial ", "replay  "])) call fail(errors, &
        of_group(text, i), "does not go with &umat: expected the one or the other")
      end do
    else
      do i = 2, 3
        if (n(i) == 0) call fail(errors, of_file(text), "no group &" // trim(group_names(i)))
      end do
    end if
    i = name_index("step", group_names)
    g = name_index("replay", group_names)
    if ((n(i) > 0) .eqv. (n(g) > 0)) call fail(errors, of_file(text), integer_text(n(i)) // &
      " groups &step and " // integer_text(n(g)) // " &replay: expected one or more &step, or one &replay")
  end subroutine check_groups

  !> Read the group &case.
  subroutine read_case_group(text, case, errors)
    type(text_type), intent(in) :: text                       !! the file
    type(case_type), intent(inout) :: case                    !! title and planes are set
    type(errors_type), intent(inout) :: errors   !! errors are added
    integer :: e, g
    logical :: refines
    case%title = ""
    refines = .false.
    g = group_index(text, "case")
    if (g == 0) return
    do e = text%groups(g)%first, text%groups(g)%last
      select case (text%entries(e)%name)
      case ("title")
        call get_string(text, e, case%title, errors)
      case ("planes")
        call get_logical(text, e, case%planes, errors)
      case ("tolerance")
        refines = .true.
        call get_real(text, e, case%tolerance, errors)
      case default
        call unknown_name(text, e, "title, planes, tolerance", errors)
      end select
    end do
    case%refines = refines
  end subroutine read_case_group

  !> Read the group &replay without its entries of PROPS.
  subroutine read_replay(text, replay, errors)
    type(text_type), intent(in) :: text                       !! the file
    type(replay_type), intent(out) :: replay                  !! what to replay
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=:), allocatable :: through
    integer :: e, g

    g = group_index(text, "replay")
    if (g == 0) return
    through = "umat"
    replay%file = ""
    do e = text%groups(g)%first, text%groups(g)%last
      select case (text%entries(e)%name)
      case ("file")
        call get_string(text, e, replay%file, errors)
        if (index(replay%file, "/") /= 1) replay%file = text%path(:index(text%path, "/", back=.true.)) // replay%file
      case ("through")
        call get_string(text, e, through, errors)
        if (all(through /= ["umat ", "vumat"])) call fail(errors, of_entry(text, e), &
          "expected 'umat' or 'vumat'")
      case ("block")
        call get_integer(text, e, 1, most_points, replay%block, errors)
      case ("ntens")
        call get_integer(text, e, 2, 6, replay%ntens, errors)
        if (all(replay%ntens /= [2, 3, 6])) call fail(errors, of_entry(text, e), "expected 2, 3 or 6")
      case ("dtime")
        call get_real(text, e, replay%dtime, errors)
        if (replay%dtime < 0.0_wp) call fail(errors, of_entry(text, e), "expected >= 0")
      case default
        continue   ! an entry of PROPS, or an unknown one that read_props reports
      end select
    end do
    if (through == "vumat") then
      if (replay%block == 0) replay%block = default_points
      if (replay%ntens == 6) call fail(errors, of_group(text, g), "ntens = 6 through vumat: expected 2 or 3")
    else if (replay%block > 0) then
      call fail(errors, of_group(text, g), "block without through = 'vumat'")
    end if
    if (len(replay%file) == 0) call fail(errors, of_group(text, g), &
      "expected file = 'a CSV of recorded strains'")
  end subroutine read_replay

end module asperity_case
