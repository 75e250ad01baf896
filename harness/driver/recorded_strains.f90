!> CSV file of recorded strains, as an FE code would pass them to a material routine.
!>
!> A header line names the columns: `e_1` ... `e_<ntens>` (strains in the host's order) or `s_N`, `s_Tx`, `s_Ty`
!> (separations, as in an output file of the driver), and optionally `time`; other columns are ignored. A file without a
!> header has the NTENS strains only. Time must not decrease. Blank lines and lines that start with # are skipped.
module recorded_strains
  use asperity_case, only: case_type
  use asperity_checks, only: bounded
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_host, only: component_map
  use asperity_interface, only: separation_bound
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text, to_text
  use asperity_text_file, only: blanks, line_end, load_file, lower, most_lines, newline, printable, to_real
  implicit none
  private
  public :: read_replayed

  !> A record of one point.
  type, public :: strains_type
    real(wp), allocatable :: strain(:, :)   !! (ntens, n) total strains
    real(wp), allocatable :: time(:)        !! (n) times
  end type strains_type

  character(len=4), parameter :: separation_names(3) = ["s_n ", "s_tx", "s_ty"]

contains

  !> Read the record that a case replays.
  subroutine read_replayed(case, record, errors)
    type(case_type), intent(in) :: case          !! the case
    type(strains_type), intent(out) :: record    !! the record
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=:), allocatable :: source, line
    type(error_type) :: place
    integer, allocatable :: column(:)
    real(wp), allocatable :: numbers(:)
    real(wp) :: bound, now
    integer :: bad, earlier, first, i, last, n, ntens, number, position(3)
    logical :: good, named, separations

    earlier = errors%n
    place%file = case%replay%file
    source = ""
    call load_file(case%replay%file, source, errors)
    if (errors%n > earlier) return
    ntens = case%replay%ntens
    position = component_map(ntens, case%joint%map)
    n = count([(source(i:i) == newline, i=1, len(source))]) + 1
    allocate (record%strain(ntens, n), record%time(n))
    record%strain = 0.0_wp
    bound = 0.25_wp*separation_bound(case%joint)/case%joint%h
    separations = .false.
    named = .false.
    bad = 0
    n = 0
    number = 0
    now = 0.0_wp
    first = 1
    do while (first <= len(source))
      last = line_end(source, first)
      line = strip(source(first:last))
      first = last + 2
      number = number + 1
      place%line = number
      if (len(line) == 0) cycle
      if (line(1:1) == "#") cycle
      if (.not. allocated(column)) then
        named = verify(line(1:1), "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ""'") == 0 .and. &
          all(lower(field(line, 1)) /= ["nan     ", "inf     ", "infinity"])
        column = [(i, i=1, ntens), 0]
        if (named) call find_columns(lower(line), place, ntens, column, separations, errors)
        if (errors%n > earlier) return
        if (named) cycle
      end if
      good = .true.
      allocate (numbers(size(column)), source=0.0_wp)
      do i = 1, size(column)
        if (column(i) == 0 .or. .not. good) cycle
        call to_real(field(line, column(i)), numbers(i), good)
        call require(good, "column " // integer_text(column(i)) // " = """ // printable(field(line, column(i))) // &
          """: expected a number")
      end do
      if (.not. named) call require(n_fields(line) <= ntens, integer_text(n_fields(line)) // " columns: expected " // &
        integer_text(ntens) // " (ntens), or a header")
      if (good) then
        n = n + 1
        record%time(n) = merge(numbers(size(numbers)), real(n, wp)*case%replay%dtime, column(size(column)) > 0)
        call require(record%time(n) >= now, "time = " // to_text(record%time(n)) // ": expected at least " // &
          to_text(now) // ", the time before (0 at the start)")
        now = max(now, record%time(n))
        if (separations) then
          if (position(3) == 0) call require(.not. abs(numbers(3)) > 0.0_wp, "s_Ty = " // to_text(numbers(3)) // &
            ": expected 0 with ntens = 2")
          do i = 1, 3
            if (position(i) > 0) record%strain(position(i), n) = numbers(i)/case%joint%h
          end do
        else
          record%strain(:, n) = numbers(:ntens)
        end if
        call require(all(bounded(record%strain(:, n), bound)), "expected strains of a magnitude up to " // &
          to_text(bound))
      end if
      deallocate (numbers)
      if (.not. good) bad = bad + 1
    end do
    place%line = -1
    if (bad > most_lines) call fail(errors, place, "... and " // integer_text(bad - most_lines) // " more bad lines")
    if (n == 0 .and. errors%n == earlier) call fail(errors, place, "no line of numbers")
    record%strain = record%strain(:, :n)
    record%time = record%time(:n)

  contains

    !> Add an error about a line, unless there are too many bad lines.
    subroutine require(yes, text)
      logical, intent(in) :: yes             !! whether there is none
      character(len=*), intent(in) :: text   !! what is wrong
      if (.not. yes .and. bad < most_lines) call fail(errors, place, text)
      good = good .and. yes
    end subroutine require

  end subroutine read_replayed

  !> A text without blanks at both ends.
  pure function strip(line) result(core)
    character(len=*), intent(in) :: line   !! text
    character(len=:), allocatable :: core
    integer :: first
    first = verify(line, blanks)
    if (first == 0) then
      core = ""
    else
      core = line(first:verify(line, blanks, back=.true.))
    end if
  end function strip

  !> Field i of a line; empty beyond the last one.
  pure function field(line, i) result(text)
    character(len=*), intent(in) :: line   !! fields separated by commas
    integer, intent(in) :: i               !! number of the field, from 1
    character(len=:), allocatable :: text
    integer :: comma, first, k
    first = 1
    do k = 1, i - 1
      comma = index(line(first:), ",")
      first = merge(first + comma, len(line) + 1, comma > 0)
    end do
    text = strip(line(first:first + index(line(first:) // ",", ",") - 2))
  end function field

  !> Number of fields of a line.
  pure function n_fields(line) result(n)
    character(len=*), intent(in) :: line   !! fields separated by commas
    integer :: i, n
    n = count([(line(i:i) == ",", i=1, len(line))]) + 1
  end function n_fields

  !> Numbers of the columns from the header; the last one is that of time (0: none).
  pure subroutine find_columns(header, place, ntens, column, separations, errors)
    character(len=*), intent(in) :: header                    !! lower case
    type(error_type), intent(in) :: place                     !! file and line
    integer, intent(in) :: ntens                              !! components of the host
    integer, allocatable, intent(inout) :: column(:)          !! numbers of the columns
    logical, intent(out) :: separations                       !! true: s_N, s_Tx, s_Ty; false: strains
    type(errors_type), intent(inout) :: errors                !! errors are added
    character(len=:), allocatable :: name
    integer :: i, k, n

    n = n_fields(header)
    separations = any([(field(header, i) == separation_names(1), i=1, n)])
    column = spread(0, 1, merge(3, ntens, separations) + 1)
    do k = 1, size(column)
      if (k == size(column)) then
        name = "time"
      else if (separations) then
        name = trim(separation_names(k))
      else
        name = "e_" // integer_text(k)
      end if
      do i = n, 1, -1
        if (field(header, i) == name) column(k) = i
      end do
      if (column(k) == 0 .and. k < size(column)) call fail(errors, place, &
        "no column " // name // ": expected s_N, s_Tx, s_Ty or e_1 to e_" // integer_text(ntens))
    end do
  end subroutine find_columns

end module recorded_strains
