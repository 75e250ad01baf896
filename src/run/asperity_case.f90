!> Reader and writer of case files: material, pattern, load path or replay, initial state and expected end, for every
!> value of a sweep (docs/reference/driver.md).
module asperity_case
  use asperity_case_entries, only: case_io, close_group, find_entry, integer_entry, logical_entry, open_group, &
    real_entry, reals_entry, require, string_entry, written_text
  use asperity_case_groups, only: carry_initial, check_state, expect_group, expect_type, initial_group, initial_type, &
    state_group, state_type, sweep_group
  use asperity_case_material, only: prop_entries, props_groups
  use asperity_case_text, only: group_index, of_file, of_group, read_text, text_type
  use asperity_case_umat, only: umat_group, umat_type
  use asperity_checks, only: review_props
  use asperity_contract, only: n_fixed_props, p_water, prop_table, status_ok
  use asperity_errors, only: error_type, errors_type, fail, sort_lines
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  use asperity_refine, only: explain_tolerance
  use asperity_rie_law, only: new_rie_law
  use asperity_rows, only: aperture_type
  use asperity_steps, only: check_steps, complete_steps, e_follow, step_table, step_type
  use asperity_text, only: integer_text, set_text
  use asperity_text_file, only: beside, lower
  implicit none
  private
  public :: read_cases, write_case, check_path

  character(len=*), parameter :: group_names(10) = [character(len=8) :: "case", "material", "pattern", "step", &
    "expect", "sweep", "replay", "state", "initial", "umat"]
  !> Values of the entry `follow` of a step, from 0.
  character(len=*), parameter :: followed(0:1) = ["stable", "branch"]

  !> Replay of recorded strains through the UMAT.
  type, public :: replay_type
    logical :: given = .false.
    character(len=:), allocatable :: file   !! CSV
    integer :: ntens = 3                    !! components of the host
    real(wp) :: dtime = 1.0_wp              !! time increment where the file has no time
    real(wp), allocatable :: strain(:, :)   !! (ntens, n) total strains, once the file has been read
    real(wp), allocatable :: time(:)        !! (n) their times
  end type replay_type

  !> A case; one that has been read has been checked.
  type, public :: case_type
    character(len=:), allocatable :: title
    logical :: planes = .false.                   !! whether each plane has columns
    logical :: stability = .false.                !! whether the eigenvalues of the tangent have columns
    type(aperture_type) :: aperture               !! of the joint, for the column
    logical :: refines = .false.                  !! whether the increments are refined to a tolerance
    real(wp) :: tolerance = 0.0_wp                !! of the load path, relative
    real(wp), allocatable :: props(:)             !! PROPS
    real(wp) :: stiffness(2) = 0.0_wp             !! kn and ks, if they give PROPS
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
  subroutine read_cases(path, file, errors, source, props)
    character(len=*), intent(in) :: path                   !! file, or the name of the text in errors; may be empty
    type(case_file_type), intent(out) :: file              !! defined if there is no error
    type(errors_type), intent(out) :: errors               !! in the order of the lines
    character(len=*), intent(in), optional :: source       !! the text, instead of the file
    real(wp), intent(in), optional :: props(:)             !! PROPS in place of &material and &pattern, any bits
    type(case_io) :: io
    integer :: g, i
    call set_text(file%sweep, "")
    call read_text(path, io%text, io%errors, source)
    if (io%errors%n == 0) call sweep_group(io, file%sweep, file%values)
    if (io%errors%n == 0) then
      io%text%variable = lower(file%sweep)
      g = group_index(io%text, "pattern")
      if (g > 0) file%pattern = [io%text%groups(g)%from, io%text%groups(g)%to]
      allocate (file%cases(max(1, size(file%values))))
      do i = 1, size(file%cases)
        if (size(file%values) > 0) io%text%variable_value = file%values(i)
        call read_case(io, file%values, file%cases(i), props)
        if (io%errors%n > 0) exit
      end do
    end if
    call sort_lines(io%errors)
    errors = io%errors
  end subroutine read_cases

  !> Write a case, without a sweep: reading the text gives the same case.
  subroutine write_case(case, text)
    type(case_type), intent(in) :: case                           !! the case
    character(len=:), allocatable, intent(inout) :: text          !! a case file
    type(case_type) :: copy
    type(case_io) :: io
    io%writes = .true.
    copy = case
    call all_groups(io, [real(wp) ::], copy, .false.)
    call written_text(io, text)
  end subroutine write_case

  !> All groups of a case.
  subroutine all_groups(io, sweep_values, case, has_props)
    type(case_io), intent(inout) :: io           !! the file
    real(wp), intent(in) :: sweep_values(:)      !! of the variable, size 0: no sweep
    type(case_type), intent(inout) :: case       !! read or written
    logical, intent(in) :: has_props             !! whether &material and &pattern are neither read nor written
    call case_group(io, case)
    call umat_group(io, case%umat)
    if (.not. (case%umat%given .or. has_props)) call props_groups(io, case%props, case%stiffness)
    call initial_group(io, case%initial)
    if (.not. (io%writes .and. case%initial%given)) call state_group(io, case%state)
    call step_groups(io, case%steps)
    call expect_group(io, sweep_values, case%expect)
    call replay_group(io, case%replay, case%props)
  end subroutine all_groups

  !> Read a case from its text; the variable of the sweep has its value.
  subroutine read_case(io, sweep_values, case, props)
    type(case_io), intent(inout) :: io           !! the file
    real(wp), intent(in) :: sweep_values(:)      !! of the variable, size 0: no sweep
    type(case_type), intent(out) :: case         !! defined if no error was added
    real(wp), intent(in), optional :: props(:)   !! PROPS in place of &material and &pattern, any bits
    character(len=:), allocatable :: lines
    integer :: status
    logical :: prescribed(3)

    call check_groups(io%text, present(props), io%errors)
    allocate (case%props(0))
    if (present(props)) case%props = props
    call all_groups(io, sweep_values, case, present(props))
    if (case%refines .and. case%replay%given) call fail(io%errors, of_group(io%text, group_index(io%text, "case")), &
      "tolerance with &replay, whose increments are recorded: expected tolerance with &step only")
    if (case%stability .and. case%replay%given) call fail(io%errors, of_group(io%text, group_index(io%text, "case")), &
      "stability with &replay, whose rows are those of a host: expected stability with &step only")
    if (case%refines .and. io%errors%n == 0) call explain_tolerance(case%tolerance, case%steps, io%errors, &
      of_group(io%text, group_index(io%text, "case")))
    if (io%errors%n > 0 .or. case%umat%given) return
    call new_interface(case%props, case%joint, status)
    if (status /= status_ok) then
      call set_text(lines, "")
      call review_props(case%props, status, lines, by_name=.true.)
      call fail(io%errors, of_file(io%text), lines)
      return
    end if
    prescribed = .true.
    prescribed(3) = case%replay%ntens > 2
    call carry_initial(case%joint, prescribed, case%replay%given, case%initial, case%state, io%errors)
    call check_state(case%joint, case%state, io%errors)
    call check_steps(new_rie_law(case%joint), case%steps, io%errors, of_file(io%text))
  end subroutine read_case

  !> Complete and check the steps of a case that a program has set: the rest of the case was read from a text.
  subroutine check_path(case, errors)
    type(case_type), intent(inout) :: case       !! with the entries of its steps -> complete
    type(errors_type), intent(inout) :: errors   !! of the text; those of the steps are added
    type(error_type) :: of_case, of_path
    integer :: earlier
    earlier = errors%n
    of_case%group = "&case"
    call complete_steps(case%steps, errors, of_path)
    if (errors%n == 0 .and. case%refines) call explain_tolerance(case%tolerance, case%steps, errors, of_case)
    ! what depends on a UMAT of others is not checked
    if (earlier > 0 .or. errors%n > 0 .or. case%umat%given) return
    call check_steps(new_rie_law(case%joint), case%steps, errors, of_path)
  end subroutine check_path

  !> Check that every group is known and not given too often.
  subroutine check_groups(text, has_props, errors)
    type(text_type), intent(in) :: text          !! the file
    logical, intent(in) :: has_props             !! whether PROPS stand for &material and &pattern
    type(errors_type), intent(inout) :: errors   !! errors are added
    integer :: g, i, n(size(group_names))
    character(len=:), allocatable :: names
    logical :: foreign

    n = 0
    names = ""
    do i = 1, size(group_names)
      names = names // ", &" // trim(group_names(i))
    end do
    foreign = group_index(text, "umat") > 0
    do g = 1, text%n_groups
      i = findloc(group_names, text%groups(g)%name, dim=1)
      if (i == 0) then
        call fail(errors, of_group(text, g), "unknown group: expected " // names(3:))
        cycle
      end if
      n(i) = n(i) + 1
      if (n(i) == 2 .and. all(group_names(i) /= ["step  ", "expect"])) call fail(errors, of_group(text, g), &
        "given twice, first in line " // integer_text(text%groups(group_index(text, trim(group_names(i))))%line))
      if (foreign .and. any(group_names(i) == ["material", "pattern ", "initial ", "replay  "])) call fail(errors, &
        of_group(text, g), "does not go with &umat: expected the one or the other")
      if (has_props .and. any(group_names(i) == ["material", "pattern ", "replay  ", "umat    "])) call fail(errors, &
        of_group(text, g), "does not go with PROPS, which the caller gives: expected the one or the other")
    end do
    do i = 2, 3
      if (n(i) == 0 .and. .not. (foreign .or. has_props)) call fail(errors, of_file(text), "no group &" // &
        trim(group_names(i)))
    end do
    i = findloc(group_names, "step", dim=1)
    g = findloc(group_names, "replay", dim=1)
    if ((n(i) > 0) .eqv. (n(g) > 0)) call fail(errors, of_file(text), integer_text(n(i)) // &
      " groups &step and " // integer_text(n(g)) // " &replay: expected one or more &step, or one &replay")
  end subroutine check_groups

  !> The group &case.
  subroutine case_group(io, case)
    type(case_io), intent(inout) :: io       !! the file
    type(case_type), intent(inout) :: case   !! title, columns and tolerance
    logical :: given
    if (.not. io%writes) call set_text(case%title, "")
    given = len(case%title) > 0 .or. case%planes .or. case%refines .or. case%stability &
      .or. abs(case%aperture%a_0) > 0.0_wp .or. case%aperture%a_min > 0.0_wp
    call open_group(io, "case", given)
    if (.not. given) return
    call string_entry(io, "title", case%title, "")
    call logical_entry(io, "planes", case%planes, .false.)
    call logical_entry(io, "stability", case%stability, .false.)
    call real_entry(io, "a_0", case%aperture%a_0, 0.0_wp)
    call real_entry(io, "a_min", case%aperture%a_min, 0.0_wp)
    call require(io, case%aperture%a_min >= 0.0_wp, "expected >= 0")
    call real_entry(io, "tolerance", case%tolerance, given=case%refines)
    call close_group(io)
  end subroutine case_group

  !> The groups &step.
  subroutine step_groups(io, steps)
    type(case_io), intent(inout) :: io                           !! the file
    type(step_type), allocatable, intent(inout) :: steps(:)      !! the load path
    character(len=:), allocatable :: follow
    integer :: g, i, n
    logical :: given
    if (.not. io%writes) allocate (steps(io%text%n_steps))
    g = 0
    do n = 1, size(steps)
      given = .true.
      if (.not. io%writes) then
        do g = g + 1, io%text%n_groups
          if (io%text%groups(g)%step == n - 1) exit
        end do
      end if
      call open_group(io, "step", given, g)
      steps(n)%place = io%place
      do i = 1, size(step_table)
        associate (entry => steps(n)%given(i))
          if (i == e_follow) then
            call set_text(follow, followed(0))
            if (allocated(entry%values)) call set_text(follow, followed(nint(entry%values(1))))
            call string_entry(io, trim(step_table(i)%name), follow, followed(0))
            ! another text has no number in the range of the table
            if (io%is_given) entry%values = [real(findloc(followed, lower(follow), dim=1) - 1, wp)]
          else
            call reals_entry(io, trim(step_table(i)%name), entry%values, any_bits=.true.)
          end if
          if (io%is_given) entry%place = io%place
        end associate
      end do
      call close_group(io)
    end do
    if (.not. io%writes) call complete_steps(steps, io%errors, of_file(io%text))
  end subroutine step_groups

  !> The group &replay.
  subroutine replay_group(io, replay, props)
    type(case_io), intent(inout) :: io                        !! the file
    type(replay_type), intent(inout) :: replay                !! what to replay
    real(wp), intent(inout) :: props(:)                       !! entries of PROPS of the host
    logical :: given(n_fixed_props)

    call open_group(io, "replay", replay%given)
    if (.not. replay%given) return
    if (.not. io%writes) call set_text(replay%file, "")
    call string_entry(io, "file", replay%file, "")
    call integer_entry(io, "ntens", replay%ntens, 2, 6, 3)
    call require(io, any(replay%ntens == [2, 3, 6]), "expected 2, 3 or 6")
    call real_entry(io, "dtime", replay%dtime, 1.0_wp)
    call require(io, replay%dtime >= 0.0_wp, "expected >= 0")
    given = .false.
    if (size(props) > 0) call prop_entries(io, "replay", props, given)
    if (.not. io%writes) call find_entry(io, trim(prop_table(p_water)%name))
    if (size(props) > 0) call require(io, .not. props(p_water) > 0.0_wp, "expected 0, as the file has no field")
    call close_group(io)
    if (io%writes) return
    if (len(replay%file) == 0) call fail(io%errors, io%place, "expected file = 'a CSV of recorded strains'")
    replay%file = beside(io%text%path, replay%file)
  end subroutine replay_group

end module asperity_case
