!> Text of a case file: namelist groups, their entries and values, each with its line.
!>
!> This module reads the namelist instead of the compiler's run-time library, so that the messages name file, line,
!> group, name and value of an error, and are the same with every compiler. Admissible syntax: `&group name = value,
!> value, ... /`, `!` comments, quoted strings, repeat counts `3*0.0`, names in any case. Subscripts, empty values and
!> text between groups are errors.
module asperity_case_text
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text
  use asperity_text_file, only: accept_bytes, blanks, last_before, load_file, lower, newline, printable
  implicit none
  private
  public :: read_text, group_index, of_file, of_group, of_entry, token_text, value_text

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
    integer :: step                        !! of the load path, from 0; -1: another group
  end type group_type

  !> Contents of a file, split into groups, entries and values.
  type, public :: text_type
    character(len=:), allocatable :: path
    character(len=:), allocatable :: source
    type(token_type), allocatable :: tokens(:)
    type(entry_type), allocatable :: entries(:)
    type(group_type), allocatable :: groups(:)
    integer :: n_tokens = 0, n_entries = 0, n_groups = 0, n_steps = 0
    ! name of the variable of &sweep, which is replaced by a number
    character(len=name_length) :: variable = ""
    real(wp) :: variable_value = 0.0_wp
  end type text_type

contains

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
      call accept_bytes(path, text%source, errors)
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
        last = last_before(newline, text%source, i)
      case ("&")
        last = word_end(text%source, i + 1)
        if (inside) call fail(errors, of_group(text, text%n_groups), "no closing / before &" // &
          text%source(i + 1:last) // " in line " // integer_text(line))
        if (text%n_groups == size(text%groups)) text%groups = [text%groups, text%groups]
        text%n_groups = text%n_groups + 1
        text%groups(text%n_groups) = group_type(lower(text%source(i + 1:last)), line, text%n_entries + 1, &
          text%n_entries, i, i, -1)
        if (text%groups(text%n_groups)%name == "step") then
          text%groups(text%n_groups)%step = text%n_steps
          text%n_steps = text%n_steps + 1
        end if
        inside = .true.
        comma = .true.
      case default
        if (inside) then
          call take_item()
        else
          last = last_before(newline, text%source, i)
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
          next = scan(text%source(last + 1:), c // newline)
          if (next > 0) then
            if (text%source(last + next:last + next) == newline) next = 0
          end if
          if (next == 0) then
            call reject("string without its closing " // c)
            last = last_before(newline, text%source, i)
            exit
          end if
          last = last + next
          if (last == len(text%source)) exit
          if (text%source(last + 1:last + 1) /= c) exit
          last = last + 1
        end do
        call add_token(i + 1, last - 1, .true.)
      case default
        last = word_end(text%source, i)
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
      character(len=name_length) :: low
      integer :: e
      if (text%n_entries == size(text%entries)) text%entries = [text%entries, text%entries]
      if (index(name, "(") > 0) call reject(name // ": subscripts are not read, expected a name and its whole list")
      low = lower(name)
      do e = text%groups(text%n_groups)%first, text%n_entries
        if (text%entries(e)%name /= low) cycle
        call reject(name // " is given twice, first in line " // integer_text(text%entries(e)%line))
        exit
      end do
      text%n_entries = text%n_entries + 1
      text%entries(text%n_entries) = entry_type(low, name, line, text%n_tokens + 1, text%n_tokens, &
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

  !> Last character of a name or a value; i - 1 if there is none at i.
  pure function word_end(source, i) result(last)
    character(len=*), intent(in) :: source   !! text
    integer, intent(in) :: i                 !! first position
    integer :: last
    ! a text of a program has many numbers, for which the intrinsic function takes longer
    do last = i, len(source)
      select case (source(last:last))
      case (" ", achar(9), newline, achar(13), ",", "=", "/", "!", "'", """", "&")
        exit
      case default
        cycle
      end select
    end do
    last = last - 1
  end function word_end

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
    place%step = text%groups(g)%step
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

end module asperity_case_text
