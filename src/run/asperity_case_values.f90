!> Values of the entries of a case file; an error has file, line, group, name and value of a bad one.
module asperity_case_values
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text
  use asperity_case_text, only: of_entry, text_type, token_text, value_text
  use asperity_text_file, only: lower, printable, to_real
  implicit none
  private
  public :: get_real, get_reals, get_integer, get_integers, get_logical, get_switch, get_string

contains

  !> All numbers of an entry.
  pure subroutine get_reals(text, entry, values, errors)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: entry                              !! which
    real(wp), allocatable, intent(out) :: values(:)           !! size 0 if one is bad
    type(errors_type), intent(inout) :: errors   !! errors are added
    integer, parameter :: most_repeats = 100000
    character(len=:), allocatable :: word
    type(error_type) :: place
    real(wp) :: repeats, value
    integer :: i, star
    logical :: good, good_count

    allocate (values(0))
    associate (e => text%entries(entry))
      if (e%last < e%first) call fail(errors, of_entry(text, entry), "no value")
      do i = e%first, e%last
        word = token_text(text, i)
        star = index(word, "*")
        repeats = 1.0_wp
        good_count = .true.
        if (star > 0) then
          call to_real(word(:star - 1), repeats, good_count)
          if (good_count) good_count = abs(repeats - anint(repeats)) <= 0.0_wp .and. repeats >= 1.0_wp .and. &
            repeats <= real(most_repeats, wp)
          word = word(star + 1:)
        end if
        call to_real(word, value, good)
        if (len_trim(text%variable) > 0 .and. lower(word) == text%variable) then
          value = text%variable_value
          good = .true.
        end if
        if (text%tokens(i)%is_string .or. .not. (good .and. good_count)) then
          place = of_entry(text, entry)
          if (place%line > 0) place%line = text%tokens(i)%line
          place%value = """" // printable(token_text(text, i)) // """"
          call fail(errors, place, "expected a number")
          values = [real(wp) ::]
          return
        end if
        values = [values, spread(value, 1, nint(repeats))]
      end do
    end associate
  end subroutine get_reals

  !> The only number of an entry.
  pure subroutine get_real(text, entry, value, errors)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: entry                              !! which
    real(wp), intent(inout) :: value                          !! unchanged on error
    type(errors_type), intent(inout) :: errors   !! errors are added
    real(wp), allocatable :: values(:)
    call get_reals(text, entry, values, errors)
    if (size(values) == 1) value = values(1)
    if (size(values) > 1) call fail(errors, of_entry(text, entry), "expected one number")
  end subroutine get_real

  !> All whole numbers of an entry.
  pure subroutine get_integers(text, entry, least, most, values, errors)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: entry                              !! which
    integer, intent(in) :: least, most                        !! admissible range
    integer, allocatable, intent(out) :: values(:)            !! size 0 if one is bad
    type(errors_type), intent(inout) :: errors   !! errors are added
    real(wp), allocatable :: reals(:)
    call get_reals(text, entry, reals, errors)
    if (any(reals < real(least, wp)) .or. any(reals > real(most, wp)) .or. any(abs(reals - aint(reals)) > 0.0_wp)) then
      call fail(errors, of_entry(text, entry), "expected a whole number from " // integer_text(least) // &
        " to " // integer_text(most))
      deallocate (reals)
      allocate (reals(0))
    end if
    values = nint(reals)
  end subroutine get_integers

  !> The only whole number of an entry.
  pure subroutine get_integer(text, entry, least, most, value, errors)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: entry                              !! which
    integer, intent(in) :: least, most                        !! admissible range
    integer, intent(inout) :: value                           !! unchanged on error
    type(errors_type), intent(inout) :: errors   !! errors are added
    integer, allocatable :: values(:)
    call get_integers(text, entry, least, most, values, errors)
    if (size(values) == 1) value = values(1)
    if (size(values) > 1) call fail(errors, of_entry(text, entry), "expected one number")
  end subroutine get_integer

  !> The only logical value of an entry.
  pure subroutine get_logical(text, entry, value, errors)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: entry                              !! which
    logical, intent(inout) :: value                           !! unchanged on error
    type(errors_type), intent(inout) :: errors   !! errors are added
    select case (lower(value_text(text, entry)))
    case (".true.", ".t.", "true", "t")
      value = .true.
    case (".false.", ".f.", "false", "f")
      value = .false.
    case default
      call fail(errors, of_entry(text, entry), "expected .true. or .false.")
    end select
  end subroutine get_logical

  !> The only number of an entry, or its only logical value as 1 or 0.
  pure subroutine get_switch(text, entry, value, errors)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: entry                              !! which
    real(wp), intent(inout) :: value                          !! unchanged on error
    type(errors_type), intent(inout) :: errors   !! errors are added
    type(errors_type) :: no_number, no_logical
    logical :: yes
    call get_real(text, entry, value, no_number)
    if (no_number%n == 0) return
    yes = .false.
    call get_logical(text, entry, yes, no_logical)
    if (no_logical%n == 0) then
      value = merge(1.0_wp, 0.0_wp, yes)
    else
      call fail(errors, of_entry(text, entry), "expected 0, 1, .true. or .false.")
    end if
  end subroutine get_switch

  !> The only string of an entry.
  pure subroutine get_string(text, entry, value, errors)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: entry                              !! which
    character(len=:), allocatable, intent(inout) :: value     !! unchanged on error
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=1) :: quote
    integer :: i
    logical :: good
    associate (e => text%entries(entry))
      good = e%last == e%first
      if (good) good = text%tokens(e%first)%is_string
      if (.not. good) then
        call fail(errors, of_entry(text, entry), "expected one string in quotes")
        return
      end if
      value = token_text(text, e%first)
      quote = text%source(text%tokens(e%first)%first - 1:text%tokens(e%first)%first - 1)
    end associate
    ! a doubled quote stands for one
    i = index(value, quote // quote)
    do while (i > 0)
      value = value(:i) // value(i + 2:)
      if (index(value(i + 1:), quote // quote) == 0) exit
      i = i + index(value(i + 1:), quote // quote)
    end do
  end subroutine get_string

end module asperity_case_values
