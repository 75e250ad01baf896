! Case files and tables of the library in the shape f2py reads (see asperity_f2py.f90). A text that the library makes has
! a handle, its address, until `text_take` hands it out and frees it.

!> Content of a case file, or of a text in its form, as JSON (case_json); where it has errors those (errors_json).
subroutine case_content(path, source, handle, length, good)
  use asperity_case, only: case_file_type, read_cases
  use asperity_errors, only: errors_type
  use asperity_json, only: case_json, errors_json
  use text_handles, only: new_handle
  implicit none
  character(len=*), intent(in) :: path      !! file; empty: the text is `source`
  character(len=*), intent(in) :: source    !! a text instead of the file
  integer, intent(out) :: handle(2)         !! of the JSON
  integer, intent(out) :: length            !! its bytes
  integer, intent(out) :: good              !! 1: the content; 0: errors
  type(case_file_type) :: file
  type(errors_type) :: errors
  character(len=:), allocatable :: text
  if (len(path) == 0) then
    call read_cases(path, file, errors, source)
  else
    call read_cases(path, file, errors)
  end if
  good = merge(1, 0, errors%n == 0)
  if (errors%n == 0) then
    call case_json(file, text)
  else
    call errors_json(errors, text)
  end if
  call new_handle(text, handle, length)
end subroutine case_content

!> Tables of the library as JSON (tables_json).
subroutine library_tables(handle, length)
  use asperity_json, only: tables_json
  use text_handles, only: new_handle
  implicit none
  integer, intent(out) :: handle(2)   !! of the JSON
  integer, intent(out) :: length      !! its bytes
  character(len=:), allocatable :: text
  call tables_json(text)
  call new_handle(text, handle, length)
end subroutine library_tables

!> Hand out a text and free it.
subroutine text_take(handle, n, text)
  use text_handles, only: take
  implicit none
  integer, intent(in) :: handle(2)                !! of the text
  integer, intent(in) :: n                        !! its bytes
  character(len=1), intent(inout) :: text(n)      !! the text
  call take(handle, text)
end subroutine text_take

!> Text of a case file with groups and entries as they are given.
subroutine case_text(n, names, kinds, counts, n_values, values, strings, room, text, length)
  use asperity_case_entries, only: case_io, close_group, open_group, put, reals_entry, string_entry, written_text
  implicit none
  integer, intent(in) :: n                           !! groups and entries
  character(len=32), intent(in) :: names(n)          !! of groups and entries
  integer, intent(in) :: kinds(n)                    !! 0 a group, 1 numbers, 2 a string, 3 the name of a sweep's number
  integer, intent(in) :: counts(n)                   !! numbers of an entry, characters of a string or name
  integer, intent(in) :: n_values                    !! all numbers, at least 1
  double precision, intent(in) :: values(n_values)   !! numbers, entry by entry
  character(len=4096), intent(in) :: strings(n)      !! strings and names
  integer, intent(in) :: room                        !! size of the array for the text
  character(len=1), intent(inout) :: text(room)      !! the text, as far as there is room for it
  integer, intent(out) :: length                     !! of the text
  type(case_io) :: io
  double precision, allocatable :: list(:)
  character(len=:), allocatable :: string
  integer :: first, i
  logical :: given
  io%writes = .true.
  given = .false.
  first = 1
  do i = 1, n
    select case (kinds(i))
    case (0)
      if (given) call close_group(io)
      given = .true.
      call open_group(io, trim(names(i)), given)
    case (1)
      list = values(first:first + counts(i) - 1)
      first = first + counts(i)
      call reals_entry(io, trim(names(i)), list)
    case (2)
      string = strings(i)(:counts(i))
      call string_entry(io, trim(names(i)), string)
    case default
      call put(io, trim(names(i)) // " = " // strings(i)(:counts(i)), .false.)
    end select
  end do
  if (given) call close_group(io)
  call written_text(io, string)
  length = len(string)
  do i = 1, min(room, length)
    text(i) = string(i:i)
  end do
end subroutine case_text
