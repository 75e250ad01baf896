!> The groups &sweep and &expect of a case file: a number that varies from run to run, and the end that is expected.
module asperity_case_expect
  use asperity_case_text, only: group_index, listed, name_index, name_length, of_entry, of_group, text_type, &
    token_text, unknown_name
  use asperity_case_values, only: get_real, get_reals, get_string
  use asperity_contract, only: v_damage, v_friction, v_rupture, v_stored
  use asperity_control_point, only: point_type
  use asperity_errors, only: errors_type, fail
  use asperity_kinds, only: wp
  use asperity_text, only: append, integer_text, to_text
  use asperity_text_file, only: lower
  implicit none
  private
  public :: read_sweep, read_expect, explain_unexpected

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
  subroutine read_sweep(text, name, values, errors)
    type(text_type), intent(in) :: text                       !! the file
    character(len=:), allocatable, intent(out) :: name        !! as it is written
    real(wp), allocatable, intent(out) :: values(:)           !! of the name
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=*), parameter :: letters = "abcdefghijklmnopqrstuvwxyz"
    integer :: e, earlier, g, i, j

    name = ""
    allocate (values(0))
    earlier = errors%n
    g = group_index(text, "sweep")
    if (g == 0) return
    do e = text%groups(g)%first, text%groups(g)%last
      select case (text%entries(e)%name)
      case ("name")
        call get_string(text, e, name, errors)
        if (verify(lower(name), letters // "_0123456789") > 0 .or. scan(lower(name), letters) /= 1 &
          .or. len(name) > name_length) then
          call fail(errors, of_entry(text, e), "expected a name of letters, digits and _")
        end if
      case ("values")
        call get_reals(text, e, values, errors)
        do i = 2, size(values)
          do j = 1, i - 1
            if (to_text(values(i)) == to_text(values(j))) call fail(errors, of_entry(text, e), &
              to_text(values(i)) // " is given twice")
          end do
        end do
      case default
        call unknown_name(text, e, "name, values", errors)
      end select
    end do
    if (errors%n > earlier) return
    if (len(name) == 0 .or. size(values) == 0) then
      call fail(errors, of_group(text, g), "expected name and values")
    else if (.not. any([(stands_for(text, i, name), i=1, text%n_tokens)])) then
      call fail(errors, of_group(text, g), "name = '" // name // "' stands for no number of the case: " // &
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

  !> Read the group &expect for the current value of the sweep: the group with this value of `when`, else the one
  !> without `when`.
  subroutine read_expect(text, sweep_values, expect, errors)
    type(text_type), intent(in) :: text                       !! the file
    real(wp), intent(in) :: sweep_values(:)                   !! of the variable, size 0: no sweep
    type(expect_type), intent(out) :: expect                  !! what is expected
    type(errors_type), intent(inout) :: errors   !! errors are added
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
          call get_real(text, e, found%values(i), errors)
          cycle
        end if
        select case (text%entries(e)%name)
        case ("end")
          word = ""
          call get_string(text, e, word, errors)
          found%lost = lower(word) == "lost"
          if (all(lower(word) /= ["lost    ", "complete"])) call fail(errors, of_entry(text, e), &
            "expected 'complete' or 'lost'")
        case ("tolerance")
          ! an admissible value remains if the given one is no number
          found%tolerance = 1.0_wp
          call get_real(text, e, found%tolerance, errors)
          if (found%tolerance < 0.0_wp) call fail(errors, of_entry(text, e), "expected >= 0")
        case ("when")
          is_specific = .true.
          call get_real(text, e, when, errors)
          if (all(abs(sweep_values - when) > 0.0_wp)) call fail(errors, of_entry(text, e), &
            "expected a value of &sweep")
        case default
          call unknown_name(text, e, "end, tolerance, when, " // listed(expect_names, ""), errors)
        end select
      end do
      if (any(found%given) .and. .not. found%tolerance > 0.0_wp) call fail(errors, of_group(text, g), &
        "values without a tolerance: expected tolerance > 0")
      if (is_specific .and. abs(when - text%variable_value) > 0.0_wp) cycle
      if (expect%line > 0 .and. (specific .eqv. is_specific)) then
        call fail(errors, of_group(text, g), "given twice for the same run, first in line " // &
          integer_text(expect%line))
      else if (is_specific .or. .not. specific) then
        expect = found
        specific = is_specific
      end if
    end do
  end subroutine read_expect

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
