! Case files in the shape f2py reads (see asperity_f2py.f90).

!> Content of a case file, or of a text in its form: the number of runs, then for each run the value of the sweep (0
!> without one), 1 if a loss of equilibrium is expected, the tolerance (0: none), the start (0 virgin, 1 &state, 2
!> &initial), separation, work there (huge: that of the energies) and water pressure, then lists with their lengths before them: the
!> state, PROPS (none: the law is a UMAT), and for each step, whose number comes first, the values of each entry (-1:
!> not given).
subroutine case_numbers(path, source, room, numbers, length, pattern, title, sweep, status, message)
  use asperity_case, only: case_file_type, read_cases
  use asperity_errors, only: errors_type, put_records
  use asperity_steps, only: explicit_entries
  use asperity_text, only: put_text
  implicit none
  character(len=*), intent(in) :: path               !! file; empty: the text is `source`
  character(len=*), intent(in) :: source             !! a text instead of the file
  integer, intent(in) :: room                        !! size of the array for the numbers
  double precision, intent(inout) :: numbers(room)   !! the content, as far as there is room for it
  integer, intent(out) :: length                     !! numbers of the content
  integer, intent(out) :: pattern(2)                 !! first and last byte of the group &pattern, from 1
  character(len=4096), intent(out) :: title          !! may be blank
  character(len=32), intent(out) :: sweep            !! name of the number that varies; blank: none
  integer, intent(out) :: status                     !! 0 or 1, bad input
  character(len=32768), intent(out) :: message       !! errors (put_records)
  type(case_file_type) :: file
  type(errors_type) :: errors
  character(len=:), allocatable :: text
  double precision :: start(5)
  integer :: i, j, k
  length = 0
  pattern = 0
  title = ""
  sweep = ""
  message = ""
  status = 0
  if (len(path) == 0) then
    call read_cases(path, file, errors, source)
  else
    call read_cases(path, file, errors)
  end if
  if (errors%n > 0) then
    status = 1
    text = ""
    call put_records(errors, text)
    call put_text(text, message)
    return
  end if
  pattern = file%pattern
  title = file%cases(1)%title
  sweep = file%sweep
  call put([dble(size(file%cases))])
  do i = 1, size(file%cases)
    associate (case => file%cases(i))
      start(1) = 0.0d0
      if (size(file%values) > 0) start(1) = file%values(i)
      call put([start(1), dble(merge(1, 0, case%expect%lost)), case%tolerance, &
        dble(merge(merge(2, 1, case%initial%given), 0, case%state%given))])
      start = [case%state%s, case%state%work, case%state%p]
      if (.not. case%state%has_work) start(4) = huge(start)
      call put(start)
      call put_list(case%state%statev)
      call put_list(case%props)
      call put([dble(size(case%steps))])
      do j = 1, size(case%steps)
        associate (given => explicit_entries(case%steps(j)))
          do k = 1, size(given)
            if (allocated(given(k)%values)) then
              call put_list(given(k)%values)
            else
              call put([-1.0d0])
            end if
          end do
        end associate
      end do
    end associate
  end do

contains

  !> Append a list with its length.
  subroutine put_list(list)
    double precision, intent(in) :: list(:)   !! its numbers
    call put([dble(size(list))])
    call put(list)
  end subroutine put_list

  !> Append numbers.
  subroutine put(list)
    double precision, intent(in) :: list(:)   !! these
    integer :: n
    n = max(0, min(size(list), room - length))
    numbers(length + 1:length + n) = list(:n)
    length = length + size(list)
  end subroutine put

end subroutine case_numbers

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
