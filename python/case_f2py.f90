! Case files in the shape f2py reads (see asperity_f2py.f90).

!> Sizes of a case file, or of a text in its form, and what its runs have in common.
subroutine case_sizes(path, has_source, source, n_runs, n_props, n_state, n_steps, n_values, pattern, title, sweep, &
                      status, message)
  use asperity_case, only: case_file_type, read_cases
  use asperity_errors, only: errors_type, put_records
  use asperity_steps, only: explicit_entries
  use asperity_text, only: put_text
  implicit none
  character(len=*), intent(in) :: path             !! file, or name of the text in errors
  integer, intent(in) :: has_source                !! 1: the text is `source`
  character(len=*), intent(in) :: source           !! a text instead of the file
  integer, intent(out) :: n_runs                   !! values of its sweep, or 1
  integer, intent(out) :: n_props                  !! most PROPS of a run, 0: the law is a UMAT
  integer, intent(out) :: n_state                  !! most numbers of a state at the start
  integer, intent(out) :: n_steps                  !! steps
  integer, intent(out) :: n_values                 !! most values of the entries of all steps
  integer, intent(out) :: pattern(2)               !! first and last byte of the group &pattern, from 1
  character(len=4096), intent(out) :: title        !! may be blank
  character(len=32), intent(out) :: sweep          !! name of the number that varies; blank: none
  integer, intent(out) :: status                   !! 0 or 1, bad input
  character(len=32768), intent(out) :: message     !! errors (put_records)
  type(case_file_type) :: file
  type(errors_type) :: errors
  character(len=:), allocatable :: text
  integer :: i, j, k, n
  n_runs = 0
  n_props = 1
  n_state = 1
  n_steps = 0
  n_values = 1
  pattern = 0
  title = ""
  sweep = ""
  message = ""
  status = 0
  if (has_source == 1) then
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
  n_runs = size(file%cases)
  pattern = file%pattern
  title = file%cases(1)%title
  sweep = file%sweep
  n_steps = size(file%cases(1)%steps)
  if (file%cases(1)%umat%given) n_props = 0
  do i = 1, n_runs
    n_props = max(n_props, size(file%cases(i)%props))
    if (file%cases(i)%state%given) n_state = max(n_state, size(file%cases(i)%state%statev))
    n = 0
    do j = 1, n_steps
      associate (given => explicit_entries(file%cases(i)%steps(j)))
        do k = 1, size(given)
          if (allocated(given(k)%values)) n = n + size(given(k)%values)
        end do
      end associate
    end do
    n_values = max(n_values, n)
  end do
end subroutine case_sizes

!> A run of a case file that `case_sizes` has read.
subroutine case_run(path, has_source, source, run, n_props, n_state, n_steps, n_entries, n_values, value, given_props, &
                    props, kind, given_state, start, state, tolerance, loses, counts, values, status)
  use asperity_case, only: case_file_type, read_cases
  use asperity_errors, only: errors_type
  use asperity_steps, only: explicit_entries
  implicit none
  character(len=*), intent(in) :: path             !! file, or name of the text in errors
  integer, intent(in) :: has_source                !! 1: the text is `source`
  character(len=*), intent(in) :: source           !! a text instead of the file
  integer, intent(in) :: run                       !! number of the run, from 1
  integer, intent(in) :: n_props, n_state          !! room for PROPS and for a state
  integer, intent(in) :: n_steps, n_entries        !! steps, and entries of a step
  integer, intent(in) :: n_values                  !! room for the values of all entries
  double precision, intent(out) :: value           !! of the sweep, 0 without one
  integer, intent(out) :: given_props              !! number of PROPS
  double precision, intent(out) :: props(n_props)  !! PROPS
  integer, intent(out) :: kind                     !! start: 0 virgin, 1 &state, 2 &initial
  integer, intent(out) :: given_state              !! numbers of the state at the start, 0: virgin
  double precision, intent(out) :: start(4)        !! separation (N, Tx, Ty) and work there; huge: that of the energies
  double precision, intent(out) :: state(n_state)  !! state at the start
  double precision, intent(out) :: tolerance       !! of the path, 0: none
  integer, intent(out) :: loses                    !! 1: a loss of equilibrium is expected at the end
  integer, intent(out) :: counts(n_entries, n_steps)   !! values of each entry, -1: not given
  double precision, intent(out) :: values(n_values)    !! values, entry by entry and step by step
  integer, intent(out) :: status                   !! 0 or 1: the file has changed
  type(case_file_type) :: file
  type(errors_type) :: errors
  integer :: first, i, j
  value = 0.0d0
  given_props = 0
  props = 0.0d0
  kind = 0
  given_state = 0
  start = 0.0d0
  state = 0.0d0
  tolerance = 0.0d0
  loses = 0
  counts = -1
  values = 0.0d0
  status = 1
  if (has_source == 1) then
    call read_cases(path, file, errors, source)
  else
    call read_cases(path, file, errors)
  end if
  if (errors%n > 0) return
  if (size(file%cases) < run) return
  if (size(file%values) > 0) value = file%values(run)
  associate (case => file%cases(run))
    given_props = size(case%props)
    if (case%state%given) given_state = size(case%state%statev)
    if (given_props > n_props .or. given_state > n_state .or. size(case%steps) /= n_steps) return
    props(:given_props) = case%props
    if (case%state%given) then
      kind = merge(2, 1, case%initial%given)
      state(:given_state) = case%state%statev
      start(:3) = case%state%s
      start(4) = case%state%work
      if (.not. case%state%has_work) start(4) = huge(start)
    end if
    tolerance = case%tolerance
    loses = merge(1, 0, case%expect%lost)
    first = 1
    do i = 1, n_steps
      associate (given => explicit_entries(case%steps(i)))
        do j = 1, n_entries
          if (.not. allocated(given(j)%values)) cycle
          counts(j, i) = size(given(j)%values)
          if (first + counts(j, i) - 1 > n_values) return
          values(first:first + counts(j, i) - 1) = given(j)%values
          first = first + counts(j, i)
        end do
      end associate
    end do
  end associate
  status = 0
end subroutine case_run

!> What is unlike the values that &expect states for the end of a run; blank: nothing.
subroutine case_end(path, run, s, traction, n_state, state, work, message)
  use asperity_case, only: case_file_type, read_cases
  use asperity_case_expect, only: explain_unexpected
  use asperity_control_point, only: point_type
  use asperity_errors, only: errors_type
  use asperity_text, only: put_text
  implicit none
  character(len=*), intent(in) :: path                           !! case file that has been read
  integer, intent(in) :: run                                     !! number of the run, from 1
  double precision, intent(in) :: s(3), traction(3)              !! separation and traction of its last row
  integer, intent(in) :: n_state                                 !! size of the state
  double precision, intent(in) :: state(n_state), work           !! state and work of this row
  character(len=4096), intent(out) :: message                    !! a line
  type(case_file_type) :: file
  type(errors_type) :: errors
  type(point_type) :: last
  character(len=:), allocatable :: text
  text = ""
  call read_cases(path, file, errors)
  if (errors%n == 0) then
    last%s = s
    last%traction = traction
    last%state = state
    last%work = work
    call explain_unexpected(file%cases(run)%expect, last, text)
  end if
  call put_text(text, message)
end subroutine case_end

!> Text of a case file with groups and entries as they are given.
subroutine case_text(n, names, kinds, counts, n_values, values, strings, room, text, length)
  use asperity_case_entries, only: case_io, close_group, open_group, reals_entry, string_entry, word_entry, written_text
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
      call word_entry(io, trim(names(i)), strings(i)(:counts(i)))
    end select
  end do
  if (given) call close_group(io)
  call written_text(io, string)
  length = len(string)
  do i = 1, min(room, length)
    text(i) = string(i:i)
  end do
end subroutine case_text
