!> The groups &sweep and &expect of a case file: a number that varies from run to run, and the end that is expected.
module asperity_case_expect
  use asperity_case_entries, only: case_io, close_group, open_group, real_entry, reals_entry, require, string_entry
  use asperity_case_text, only: name_length, text_type, token_text
  use asperity_contract, only: v_damage, v_friction, v_rupture, v_stored
  use asperity_control_point, only: point_type
  use asperity_errors, only: fail
  use asperity_kinds, only: wp
  use asperity_text, only: append, integer_text, set_text, to_text
  use asperity_text_file, only: lower
  implicit none
  private
  public :: sweep_group, expect_group, explain_unexpected

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

  !> Name and values of the sweep of a case; no values: the case runs once.
  subroutine sweep_group(io, name, values)
    type(case_io), intent(inout) :: io                           !! the file
    character(len=:), allocatable, intent(inout) :: name         !! as it is written
    real(wp), allocatable, intent(inout) :: values(:)            !! of the name
    character(len=*), parameter :: letters = "abcdefghijklmnopqrstuvwxyz"
    integer :: earlier, i, j
    logical :: given

    if (.not. io%writes) call set_text(name, "")
    if (.not. io%writes) allocate (values(0))
    earlier = io%errors%n
    given = size(values) > 0
    call open_group(io, "sweep", given)
    if (.not. given) return
    call string_entry(io, "name", name, "")
    call require(io, verify(lower(name), letters // "_0123456789") == 0 .and. scan(lower(name), letters) == 1 .and. &
      len(name) <= name_length, "expected a name of letters, digits and _")
    call reals_entry(io, "values", values)
    do i = 2, size(values)
      do j = 1, i - 1
        call require(io, to_text(values(i)) /= to_text(values(j)), to_text(values(i)) // " is given twice")
      end do
    end do
    call close_group(io)
    if (io%errors%n > earlier .or. io%writes) return
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
    type(expect_type) :: found
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
      found = expect_type(line=io%text%groups(g)%line)
      call expect_entries(io, found, when, is_specific)
      call require(io, any(abs(sweep_values - when) <= 0.0_wp), "expected a value of &sweep")
      call close_group(io)
      if (any(found%given) .and. .not. found%tolerance > 0.0_wp) call fail(io%errors, io%place, &
        "values without a tolerance: expected tolerance > 0")
      if (is_specific .and. abs(when - io%text%variable_value) > 0.0_wp) cycle
      if (expect%line > 0 .and. (specific .eqv. is_specific)) then
        call fail(io%errors, io%place, "given twice for the same run, first in line " // integer_text(expect%line))
      else if (is_specific .or. .not. specific) then
        expect = found
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
    class(point_type), intent(in) :: last                     !! the last row
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

end module asperity_case_expect
