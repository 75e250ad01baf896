!> A case file entry by entry. Each procedure here reads an entry of the open group or, if the file is written, writes
!> it: the list of the entries of a group is therefore the same for both, and for the message about an unknown name. An
!> error has file, line, group, name and value of a bad entry.
module asperity_case_entries
  use, intrinsic :: ieee_arithmetic, only: ieee_negative_inf, ieee_positive_inf, ieee_quiet_nan, ieee_value
  use asperity_case_text, only: group_index, of_entry, of_group, text_type, token_text, value_text
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text, set_text, to_text
  use asperity_text_file, only: lower, newline, printable, to_real
  implicit none
  private
  public :: open_group, close_group, real_entry, reals_entry, integer_entry, logical_entry, string_entry, switch_entry
  public :: find_entry, put, require, written_text

  !> Characters of a line that is written, and numbers of a long list in it: two normals.
  integer, parameter :: width = 100, columns = 6

  !> A case file that is read or written.
  type, public :: case_io
    logical :: writes = .false.
    type(text_type) :: text                                   !! the file that is read
    type(errors_type) :: errors                               !! of the file
    integer :: group = 0                                      !! the open group
    logical :: is_given = .false.                             !! whether the last entry is given, in reading
    type(error_type) :: place                                 !! of the last entry; of the group, if it is not given
    integer, private :: entry = 0                             !! the last entry, 0: it is not given
    logical, allocatable, private :: asked(:)                 !! entries of the file that have been asked for
    character(len=:), allocatable, private :: known           !! names of the entries of the group
    character(len=:), allocatable, private :: written         !! the text that is written
    integer, private :: length = 0, column = 0                !! of this text, and of its last line
    logical, private :: first = .true.                        !! whether nothing of the group is written
  end type case_io

contains

  !> Open a group, if there is one.
  subroutine open_group(io, name, given, which)
    type(case_io), intent(inout) :: io            !! the file
    character(len=*), intent(in) :: name          !! of the group
    logical, intent(inout) :: given               !! read: whether there is one; else whether it is written
    integer, intent(in), optional :: which        !! number of the group in the file; absent: the first one of the name
    io%is_given = .false.
    call set_text(io%known, "")
    if (io%writes) then
      if (.not. given) return
      io%column = 0
      io%first = .true.
      call add(io, "&" // name)
      return
    end if
    if (present(which)) then
      io%group = which
    else
      io%group = group_index(io%text, name)
    end if
    given = io%group > 0
    if (.not. given) return
    io%place = of_group(io%text, io%group)
    if (.not. allocated(io%asked)) allocate (io%asked(io%text%n_entries))
    io%asked(io%text%groups(io%group)%first:io%text%groups(io%group)%last) = .false.
  end subroutine open_group

  !> Close the group. A name that no entry of the group has is an error.
  subroutine close_group(io)
    type(case_io), intent(inout) :: io   !! the file
    integer :: e
    if (io%writes) then
      call add(io, " /" // newline)
      return
    end if
    io%is_given = .false.
    io%place = of_group(io%text, io%group)
    do e = io%text%groups(io%group)%first, io%text%groups(io%group)%last
      if (.not. io%asked(e)) call fail(io%errors, of_entry(io%text, e), "unknown name, expected one of " // &
        io%known(3:))
    end do
  end subroutine close_group

  !> One number.
  subroutine real_entry(io, name, value, default, given)
    type(case_io), intent(inout) :: io             !! the file
    character(len=*), intent(in) :: name           !! of the entry
    real(wp), intent(inout) :: value               !! read: unchanged if it is not given, or on error
    real(wp), intent(in), optional :: default      !! it is not written
    logical, intent(inout), optional :: given      !! read: whether it is given; else whether it is written
    real(wp), allocatable :: values(:)
    logical :: writes
    if (io%writes) then
      writes = .true.
      if (present(default)) writes = abs(value - default) > 0.0_wp
      if (present(given)) writes = writes .and. given
      if (writes) call put_numbers(io, name, [value])
      return
    end if
    call find_entry(io, name)
    if (present(given)) given = io%is_given
    if (.not. io%is_given) return
    call get_numbers(io, values)
    if (size(values) == 1) value = values(1)
    call require(io, size(values) < 2, "expected one number")
  end subroutine real_entry

  !> A list of numbers.
  subroutine reals_entry(io, name, values, any_bits)
    type(case_io), intent(inout) :: io                    !! the file
    character(len=*), intent(in) :: name                  !! of the entry
    real(wp), allocatable, intent(inout) :: values(:)     !! read: unchanged if it is not given, size 0 on error; else
                                                          !! not written if it is empty, or not allocated
    logical, intent(in), optional :: any_bits             !! true: inf and nan are read, too, as the caller tests them
    if (io%writes) then
      if (.not. allocated(values)) return
      if (size(values) > 0) call put_numbers(io, name, values)
      return
    end if
    call find_entry(io, name)
    if (io%is_given) call get_numbers(io, values, any_bits)
  end subroutine reals_entry

  !> One whole number.
  subroutine integer_entry(io, name, value, least, most, default)
    type(case_io), intent(inout) :: io           !! the file
    character(len=*), intent(in) :: name         !! of the entry
    integer, intent(inout) :: value              !! read: unchanged if it is not given, or on error
    integer, intent(in) :: least, most           !! admissible range
    integer, intent(in) :: default               !! it is not written, and need not be in the range
    real(wp) :: number
    logical :: good
    number = real(value, wp)
    call real_entry(io, name, number, real(default, wp))
    if (.not. abs(number - real(value, wp)) > 0.0_wp) return
    good = number >= real(least, wp) .and. number <= real(most, wp) .and. .not. abs(number - aint(number)) > 0.0_wp
    if (good) value = nint(number)
    call require(io, good, "expected a whole number from " // integer_text(least) // " to " // integer_text(most))
  end subroutine integer_entry

  !> One logical value, which is written as 1 or 0.
  subroutine logical_entry(io, name, value, default)
    type(case_io), intent(inout) :: io           !! the file
    character(len=*), intent(in) :: name         !! of the entry
    logical, intent(inout) :: value              !! read: unchanged if it is not given, or on error
    logical, intent(in) :: default               !! it is not written
    real(wp) :: number
    number = merge(1.0_wp, 0.0_wp, value)
    call switch_entry(io, name, number, merge(1.0_wp, 0.0_wp, default))
    if (.not. abs(number - 0.5_wp) > 0.5_wp) value = number >= 1.0_wp
    call require(io, any(abs(number - [0.0_wp, 1.0_wp]) <= 0.0_wp), "expected .true. or .false.")
  end subroutine logical_entry

  !> One number, or one logical value as 1 or 0.
  subroutine switch_entry(io, name, value, default)
    type(case_io), intent(inout) :: io           !! the file
    character(len=*), intent(in) :: name         !! of the entry
    real(wp), intent(inout) :: value             !! read: unchanged if it is not given, or on error
    real(wp), intent(in) :: default              !! it is not written
    integer :: earlier
    earlier = io%errors%n
    call real_entry(io, name, value, default)
    if (io%errors%n == earlier) return
    io%errors%n = earlier
    select case (lower(value_text(io%text, io%entry)))
    case (".true.", ".t.", "true", "t")
      value = 1.0_wp
    case (".false.", ".f.", "false", "f")
      value = 0.0_wp
    case default
      call require(io, .false., "expected 0, 1, .true. or .false.")
    end select
  end subroutine switch_entry

  !> One string in quotes.
  subroutine string_entry(io, name, value, default)
    type(case_io), intent(inout) :: io                       !! the file
    character(len=*), intent(in) :: name                     !! of the entry
    character(len=:), allocatable, intent(inout) :: value    !! read: unchanged if it is not given, or on error
    character(len=*), intent(in), optional :: default        !! it is not written
    character(len=:), allocatable :: word
    character(len=1) :: quote
    integer :: i, n
    logical :: good
    if (io%writes) then
      good = .true.
      if (present(default)) good = value /= default
      if (good) call put(io, name // " = " // quoted(value), .false.)
      return
    end if
    call find_entry(io, name)
    if (.not. io%is_given) return
    associate (e => io%text%entries(io%entry))
      good = e%last == e%first
      if (good) good = io%text%tokens(e%first)%is_string
      if (.not. good) then
        call fail(io%errors, io%place, "expected one string in quotes")
        return
      end if
      word = token_text(io%text, e%first)
      i = io%text%tokens(e%first)%first - 1
      quote = io%text%source(i:i)
    end associate
    ! a doubled quote stands for one
    n = 0
    i = 1
    do while (i <= len(word))
      n = n + 1
      word(n:n) = word(i:i)
      i = i + merge(2, 1, word(i:i) == quote)
    end do
    call set_text(value, word(:n))
  end subroutine string_entry

  !> Add an error about the last entry, if it is given and not as it must be.
  subroutine require(io, good, text)
    type(case_io), intent(inout) :: io    !! the file
    logical, intent(in) :: good           !! whether the value is as it must be
    character(len=*), intent(in) :: text  !! what is expected
    if (io%is_given .and. .not. good) call fail(io%errors, io%place, text)
  end subroutine require

  !> The text that has been written.
  pure subroutine written_text(io, text)
    type(case_io), intent(in) :: io                             !! the file
    character(len=:), allocatable, intent(inout) :: text        !! its text
    call set_text(text, "")
    if (allocated(io%written)) call set_text(text, io%written(:io%length))
  end subroutine written_text

  !> Find an entry of the open group.
  subroutine find_entry(io, name)
    type(case_io), intent(inout) :: io       !! the file
    character(len=*), intent(in) :: name     !! of the entry
    integer :: e
    if (index(io%known // ",", ", " // name // ",") == 0) call set_text(io%known, io%known // ", " // name)
    io%entry = 0
    do e = io%text%groups(io%group)%first, io%text%groups(io%group)%last
      if (io%text%entries(e)%name /= lower(name)) cycle
      if (io%entry == 0) io%entry = e
      io%asked(e) = .true.
    end do
    io%is_given = io%entry > 0
    if (io%is_given) then
      io%place = of_entry(io%text, io%entry)
    else
      io%place = of_group(io%text, io%group)
    end if
  end subroutine find_entry

  !> All numbers of the entry that was found.
  subroutine get_numbers(io, values, any_bits)
    type(case_io), intent(inout) :: io                        !! the file
    real(wp), allocatable, intent(out) :: values(:)           !! size 0 if one is bad
    logical, intent(in), optional :: any_bits                 !! true: inf and nan are numbers
    integer, parameter :: most_repeats = 100000
    real(wp), allocatable :: longer(:)
    character(len=:), allocatable :: word
    type(error_type) :: place
    real(wp) :: repeats, value
    integer :: i, n, star
    logical :: good, good_count

    n = 0
    associate (e => io%text%entries(io%entry), tokens => io%text%tokens)
      allocate (values(e%last - e%first + 1))
      if (e%last < e%first) call fail(io%errors, io%place, "no value")
      do i = e%first, e%last
        word = token_text(io%text, i)
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
        if (present(any_bits) .and. .not. good) call not_finite(lower(word), value, good)
        if (len_trim(io%text%variable) > 0 .and. lower(word) == io%text%variable) then
          value = io%text%variable_value
          good = .true.
        end if
        if (tokens(i)%is_string .or. .not. (good .and. good_count)) then
          place = io%place
          if (place%line > 0) place%line = tokens(i)%line
          ! in a text without a name or lines a value is known by its position
          if (len(io%text%path) == 0 .and. e%last > e%first) place%at = n
          place%value = """" // printable(token_text(io%text, i)) // """"
          call fail(io%errors, place, "expected a number")
          values = [real(wp) ::]
          return
        end if
        if (n + nint(repeats) > size(values)) then
          allocate (longer(2*(n + nint(repeats))))
          longer(:n) = values(:n)
          call move_alloc(longer, values)
        end if
        values(n + 1:n + nint(repeats)) = value
        n = n + nint(repeats)
      end do
    end associate
    if (n < size(values)) values = values(:n)
  end subroutine get_numbers

  !> Read what is no finite number.
  pure subroutine not_finite(word, value, good)
    character(len=*), intent(in) :: word      !! in lower case
    real(wp), intent(inout) :: value          !! set if it is good
    logical, intent(out) :: good              !! whether the word is nan, inf or -inf
    good = .true.
    select case (word)
    case ("nan")
      value = ieee_value(value, ieee_quiet_nan)
    case ("inf")
      value = ieee_value(value, ieee_positive_inf)
    case ("-inf")
      value = ieee_value(value, ieee_negative_inf)
    case default
      good = .false.
    end select
  end subroutine not_finite

  !> Write numbers, which read back exactly.
  subroutine put_numbers(io, name, values)
    type(case_io), intent(inout) :: io           !! the file
    character(len=*), intent(in) :: name         !! of the entry
    real(wp), intent(in) :: values(:)            !! one or more
    integer :: i
    call put(io, name // " = " // to_text(values(1)), size(values) > columns)
    do i = 2, size(values)
      call put(io, to_text(values(i)), modulo(i, columns) == 1)
    end do
  end subroutine put_numbers

  !> Write a piece of the open group, behind a comma if it is not the first one, in a new line where this one is full.
  subroutine put(io, piece, breaks)
    type(case_io), intent(inout) :: io           !! the file
    character(len=*), intent(in) :: piece        !! a value, or the name of an entry with its first value
    logical, intent(in) :: breaks                !! whether it begins a line
    if (.not. io%first) call add(io, ",")
    if (breaks .or. io%column + len(piece) + 2 > width) then
      call add(io, newline // " ")
      io%column = 1
    end if
    io%first = .false.
    call add(io, " " // piece)
  end subroutine put

  !> Append to the text that is written.
  subroutine add(io, piece)
    type(case_io), intent(inout) :: io      !! the file
    character(len=*), intent(in) :: piece   !! what to append
    if (.not. allocated(io%written)) call set_text(io%written, "")
    if (io%length + len(piece) > len(io%written)) call set_text(io%written, &
      io%written // repeat(" ", io%length + 2*len(piece) + width))
    io%written(io%length + 1:io%length + len(piece)) = piece
    io%length = io%length + len(piece)
    io%column = io%column + len(piece)
  end subroutine add

  !> A string of a case file; a doubled quote stands for one.
  pure function quoted(string) result(piece)
    character(len=*), intent(in) :: string   !! any
    character(len=:), allocatable :: piece
    integer :: j, n
    allocate (character(len=2*len(string) + 2) :: piece)
    n = 0
    do j = 1, len(string)
      piece(n + 2:n + 3) = string(j:j) // "'"
      n = n + merge(2, 1, string(j:j) == "'")
    end do
    piece = "'" // piece(2:n + 1) // "'"
  end function quoted

end module asperity_case_entries
