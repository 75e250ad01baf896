!> Text of a case file: namelist groups, their entries and values, each with its line; words and numbers of text files.
!>
!> This module reads the namelist instead of the compiler's run-time library, so that the messages name file, line,
!> group, name and value of an error, and are the same with every compiler. Admissible syntax: `&group name = value,
!> value, ... /`, `!` comments, quoted strings, repeat counts `3*0.0`, names in any case. Subscripts, empty values and
!> text between groups are errors.
module asperity_case_text
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text
  implicit none
  private
  public :: check_bytes, load_file, line_end, lower, printable, to_real, read_text, group_index, name_index, of_file
  public :: of_group, of_entry, beside, token_text, value_text

  character(len=*), parameter, public :: newline = achar(10)
  character(len=*), parameter, public :: blanks = " " // achar(9) // newline // achar(13)
  !> Largest number of messages about one kind of error; the number of further ones is reported.
  integer, parameter, public :: most_lines = 20
  !> Largest file that is read, bytes.
  integer, parameter :: largest_file = 100000000

  integer, parameter, public :: name_length = 32
  !> A value: its position in the source.
  type :: token_type
    integer :: first, last, line
    logical :: is_string
  end type token_type

  !> An entry `name = values`.
  type :: entry_type
    character(len=name_length) :: name     !! lower case
    character(len=name_length) :: shown    !! as it is written
    integer :: line
    integer :: first, last                 !! its tokens
    integer :: group                       !! in which it is
  end type entry_type

  !> A group `&name entries /`.
  type :: group_type
    character(len=name_length) :: name     !! lower case
    integer :: line
    integer :: first, last                 !! its entries
    integer :: from, to                    !! in the source, from & to /
  end type group_type

  !> Contents of a file, split into groups, entries and values.
  type, public :: text_type
    character(len=:), allocatable :: path
    character(len=:), allocatable :: source
    type(token_type), allocatable :: tokens(:)
    type(entry_type), allocatable :: entries(:)
    type(group_type), allocatable :: groups(:)
    integer :: n_tokens = 0, n_entries = 0, n_groups = 0
    ! name of the variable of &sweep, which is replaced by a number
    character(len=name_length) :: variable = ""
    real(wp) :: variable_value = 0.0_wp
  end type text_type

  character(len=*), parameter :: word_end = blanks // ",=/!'""&"

contains

  !> Read the bytes of a text file.
  subroutine load_file(path, source, errors)
    character(len=*), intent(in) :: path                      !! file
    character(len=:), allocatable, intent(inout) :: source    !! its bytes
    type(errors_type), intent(inout) :: errors                !! errors are added
    character(len=200) :: reason
    type(error_type) :: place
    integer :: unit, status, bytes

    place%file = path
    open (newunit=unit, file=path, access="stream", form="unformatted", action="read", status="old", &
      iostat=status, iomsg=reason)
    if (status /= 0) then
      call fail(errors, place, "cannot be opened: " // trim(reason))
      return
    end if
    inquire (unit=unit, size=bytes)
    if (bytes < 1 .or. bytes > largest_file) then
      call fail(errors, place, integer_text(bytes) // " bytes: expected a case file of 1 to " // &
        integer_text(largest_file) // " bytes")
      close (unit)
      return
    end if
    deallocate (source)
    allocate (character(len=bytes) :: source)
    read (unit, iostat=status, iomsg=reason) source
    close (unit)
    if (status /= 0) then
      call fail(errors, place, "cannot be read: " // trim(reason))
      return
    end if
    call check_bytes(path, source, errors)
    if (bytes >= 3) then
      if (source(1:3) == char(239) // char(187) // char(191)) source(1:3) = ""   ! byte-order mark of an editor
    end if
  end subroutine load_file

  !> Add an error for the first byte that a text file does not have.
  pure subroutine check_bytes(path, source, errors)
    character(len=*), intent(in) :: path                      !! file
    character(len=*), intent(in) :: source                    !! its bytes
    type(errors_type), intent(inout) :: errors                !! errors are added
    type(error_type) :: place
    integer :: i, line
    place%file = path
    line = 1
    do i = 1, len(source)
      if (source(i:i) == newline) line = line + 1
      if ((iachar(source(i:i)) < 32 .and. scan(source(i:i), blanks) == 0) .or. iachar(source(i:i)) == 127) then
        place%line = line
        call fail(errors, place, "byte " // integer_text(iachar(source(i:i))) // ": expected a text file")
        return
      end if
    end do
  end subroutine check_bytes

  !> Last position of the line that contains position i.
  pure function line_end(source, i) result(last)
    character(len=*), intent(in) :: source   !! text
    integer, intent(in) :: i                 !! position
    integer :: last
    last = index(source(i:), newline)
    last = merge(i + last - 2, len(source), last > 0)
  end function line_end

  !> Start of a text, with a question mark for each character that is not ASCII.
  pure function printable(piece) result(clean)
    character(len=*), intent(in) :: piece   !! text
    character(len=:), allocatable :: clean
    integer, parameter :: most = 60
    integer :: i
    clean = piece(:min(len(piece), most))
    do i = 1, len(clean)
      if (iachar(clean(i:i)) < 32 .or. iachar(clean(i:i)) > 126) clean(i:i) = "?"
    end do
    clean = trim(clean)
    if (len(piece) > most) clean = clean // "..."
  end function printable

  !> A text in lower case.
  pure function lower(name) result(low)
    character(len=*), intent(in) :: name   !! any case
    character(len=len(name)) :: low
    integer :: i
    low = name
    do i = 1, len(name)
      if (name(i:i) >= "A" .and. name(i:i) <= "Z") low(i:i) = achar(iachar(name(i:i)) + 32)
    end do
  end function lower

  !> Read a finite decimal number, with or without exponent; every other text is rejected.
  pure subroutine to_real(word, value, good)
    character(len=*), intent(in) :: word   !! without blanks
    real(wp), intent(out) :: value         !! 0 if it is no number
    logical, intent(out) :: good           !! whether it is one
    integer, parameter :: longest = 60, largest_exponent = 300
    character(len=longest + 8) :: number
    integer :: e, exponent, status

    value = 0.0_wp
    exponent = 0
    e = scan(word // "e", "eEdD")
    good = len(word) <= longest .and. is_number(word(:e - 1), 1)
    if (good .and. e <= len(word)) then
      good = len(word) - e <= 5 .and. is_number(word(e + 1:), 0)
      if (good) read (word(e + 1:), "(i8)") exponent
    end if
    ! rejected before it is read, as an overflow would raise a floating-point exception
    good = good .and. exponent + e - 1 <= largest_exponent
    if (.not. good) return
    number = word(:e - 1) // "e" // integer_text(exponent)
    read (number, "(f68.0)", iostat=status) value
    good = status == 0
  end subroutine to_real

  !> Whether a word is an optional sign, digits, and up to a number of decimal points.
  pure function is_number(word, points) result(yes)
    character(len=*), intent(in) :: word   !! text
    integer, intent(in) :: points          !! 0 or 1
    logical :: yes
    integer :: first, i
    first = 1 + min(1, scan(word(:min(1, len(word))), "+-"))
    yes = verify(word(first:), "0123456789.") == 0 .and. scan(word, "0123456789") > 0 .and. &
      count([(word(i:i) == ".", i=1, len(word))]) <= points
  end function is_number

  !> Split a file, or a text, into groups, entries and values.
  subroutine read_text(path, text, errors, source)
    character(len=*), intent(in) :: path                      !! file, or the name of the text in messages; may be empty
    type(text_type), intent(out) :: text                      !! its contents
    type(errors_type), intent(inout) :: errors                !! errors are added
    character(len=*), intent(in), optional :: source          !! the text, instead of the file
    integer :: i, last, line
    logical :: comma, inside

    text%path = path
    text%source = ""
    allocate (text%tokens(64), text%entries(32), text%groups(8))
    if (present(source)) then
      text%source = source
      call check_bytes(path, source, errors)
    else
      call load_file(path, text%source, errors)
    end if
    if (errors%n > 0) return
    i = 1
    line = 1
    inside = .false.   ! whether a group is open
    comma = .false.    ! whether a comma would mean an empty value
    do while (i <= len(text%source))
      last = i
      select case (text%source(i:i))
      case (" ", achar(9), achar(13))
      case (newline)
        line = line + 1
      case ("!")
        last = line_end(text%source, i)
      case ("&")
        last = end_of_word(text%source, i + 1)
        if (inside) call fail(errors, of_group(text, text%n_groups), "no closing / before &" // &
          text%source(i + 1:last) // " in line " // integer_text(line))
        if (text%n_groups == size(text%groups)) text%groups = [text%groups, text%groups]
        text%n_groups = text%n_groups + 1
        text%groups(text%n_groups) = group_type(lower(text%source(i + 1:last)), line, text%n_entries + 1, &
          text%n_entries, i, i)
        inside = .true.
        comma = .true.
      case default
        if (inside) then
          call take_item()
        else
          last = line_end(text%source, i)
          call fail(errors, of_file(text, line), """" // printable(text%source(i:last)) // &
            """ outside a group: expected &name, or ! before a comment")
        end if
      end select
      i = last + 1
    end do
    if (inside) call fail(errors, of_group(text, text%n_groups), "no closing / before the end of the file")

  contains

    !> Add an error in this line.
    subroutine reject(message)
      character(len=*), intent(in) :: message   !! what is wrong
      call fail(errors, of_group(text, text%n_groups, line), message)
    end subroutine reject

    !> Read one item of a group from position i: a value, a name with `=`, a comma or the closing `/`.
    subroutine take_item()
      type(error_type) :: place
      character(len=1) :: c
      integer :: k, next
      c = text%source(i:i)
      select case (c)
      case ("/")
        inside = .false.
        text%groups(text%n_groups)%to = i
      case (",")
        place = of_group(text, text%n_groups, line)
        if (text%groups(text%n_groups)%last >= text%groups(text%n_groups)%first) then
          place%name = trim(text%entries(text%n_entries)%shown)
        end if
        if (comma) call fail(errors, place, "empty value before a comma")
        comma = .true.
      case ("=")
        call reject("= without a name before it")
      case ("'", """")
        do
          next = index(text%source(last + 1:), c)
          if (next == 0 .or. index(text%source(last + 1:last + next), newline) > 0) then
            call reject("string without its closing " // c)
            last = line_end(text%source, i)
            exit
          end if
          last = last + next
          if (last == len(text%source)) exit
          if (text%source(last + 1:last + 1) /= c) exit
          last = last + 1
        end do
        call add_token(i + 1, last - 1, .true.)
      case default
        last = end_of_word(text%source, i)
        next = verify(text%source(last + 1:), blanks)
        if (next > 0) then
          if (text%source(last + next:last + next) /= "=") next = 0
        end if
        if (next > 0) then
          call add_entry(text%source(i:last))
          line = line + count([(text%source(k:k) == newline, k=last + 1, last + next)])
          last = last + next
        else
          call add_token(i, last, .false.)
        end if
      end select
    end subroutine take_item

    !> Start an entry of the open group.
    subroutine add_entry(name)
      character(len=*), intent(in) :: name   !! of the entry
      integer :: e
      if (text%n_entries == size(text%entries)) text%entries = [text%entries, text%entries]
      if (index(name, "(") > 0) call reject(name // ": subscripts are not read, expected a name and its whole list")
      do e = text%groups(text%n_groups)%first, text%n_entries
        if (text%entries(e)%name == lower(name)) call reject(name // " is given twice, first in line " // &
          integer_text(text%entries(e)%line))
      end do
      text%n_entries = text%n_entries + 1
      text%entries(text%n_entries) = entry_type(lower(name), name, line, text%n_tokens + 1, text%n_tokens, &
        text%n_groups)
      text%groups(text%n_groups)%last = text%n_entries
      comma = .true.
    end subroutine add_entry

    !> Add a value to the open entry.
    subroutine add_token(from, to, is_string)
      integer, intent(in) :: from, to      !! in the source, without quotes
      logical, intent(in) :: is_string     !! in quotes
      comma = .false.
      if (text%groups(text%n_groups)%last < text%groups(text%n_groups)%first) then
        call reject("""" // printable(text%source(from:to)) // """ without a name: expected name = value")
        return
      end if
      if (text%n_tokens == size(text%tokens)) text%tokens = [text%tokens, text%tokens]
      text%n_tokens = text%n_tokens + 1
      text%tokens(text%n_tokens) = token_type(from, to, line, is_string)
      text%entries(text%n_entries)%last = text%n_tokens
    end subroutine add_token

  end subroutine read_text

  !> Last position of the word that starts at i; i - 1 if there is none.
  pure function end_of_word(source, i) result(last)
    character(len=*), intent(in) :: source   !! text
    integer, intent(in) :: i                 !! first position
    integer :: last
    last = scan(source(i:), word_end)
    last = merge(len(source), i + last - 2, last == 0)
  end function end_of_word

  !> Place of an error in the whole file, or in a line; a text that is not in a file has no place.
  pure function of_file(text, line) result(place)
    type(text_type), intent(in) :: text             !! the file
    integer, intent(in), optional :: line           !! in it
    type(error_type) :: place
    if (len(text%path) == 0) return
    place%file = text%path
    if (present(line)) place%line = line
  end function of_file

  !> Place of an error in a group, or in a line of it.
  pure function of_group(text, g, line) result(place)
    type(text_type), intent(in) :: text             !! the file
    integer, intent(in) :: g                        !! group
    integer, intent(in), optional :: line           !! of the file; absent: that of the group
    type(error_type) :: place
    place = of_file(text, text%groups(g)%line)
    if (present(line)) place = of_file(text, line)
    place%group = "&" // trim(text%groups(g)%name)
    if (text%groups(g)%name == "step") place%step = count(text%groups(:g - 1)%name == "step")
  end function of_group

  !> Place of an error in an entry, with its values.
  pure function of_entry(text, entry) result(place)
    type(text_type), intent(in) :: text   !! the file
    integer, intent(in) :: entry          !! which
    type(error_type) :: place
    place = of_group(text, text%entries(entry)%group, text%entries(entry)%line)
    place%name = trim(text%entries(entry)%shown)
    place%value = value_text(text, entry)
  end function of_entry

  !> Values of an entry as they were written (the first few of a long list).
  pure function value_text(text, entry) result(values)
    type(text_type), intent(in) :: text   !! the file
    integer, intent(in) :: entry          !! which
    character(len=:), allocatable :: values
    integer, parameter :: most = 6
    integer :: i
    associate (e => text%entries(entry))
      values = ""
      do i = e%first, min(e%last, e%first + most - 1)
        if (i > e%first) values = values // ", "
        if (text%tokens(i)%is_string) then
          values = values // "'" // printable(token_text(text, i)) // "'"
        else
          values = values // printable(token_text(text, i))
        end if
      end do
      if (e%last >= e%first + most) values = values // ", ..."
    end associate
  end function value_text

  !> Source of a value.
  pure function token_text(text, token) result(source)
    type(text_type), intent(in) :: text   !! the file
    integer, intent(in) :: token          !! which
    character(len=:), allocatable :: source
    source = text%source(text%tokens(token)%first:text%tokens(token)%last)
  end function token_text

  !> First group of a name; 0: none.
  pure function group_index(text, name) result(g)
    type(text_type), intent(in) :: text    !! the file
    character(len=*), intent(in) :: name   !! of the group
    integer :: g
    g = findloc(text%groups(:text%n_groups)%name, name, dim=1)
  end function group_index

  !> Position of a lower-case name in a list of names; 0: none.
  pure function name_index(name, names) result(i)
    character(len=*), intent(in) :: name       !! lower case
    character(len=*), intent(in) :: names(:)   !! in any case
    integer :: i
    do i = size(names), 1, -1
      if (lower(names(i)) == name) exit
    end do
  end function name_index

  !> Name of a file that lies beside another one unless its path is whole.
  pure function beside(path, name) result(whole)
    character(len=*), intent(in) :: path   !! of the other file
    character(len=*), intent(in) :: name   !! of the file
    character(len=:), allocatable :: whole
    whole = name
    if (index(name, "/") /= 1) whole = path(:index(path, "/", back=.true.)) // name
  end function beside

end module asperity_case_text
