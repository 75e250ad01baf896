!> Content of case files, errors and tables of the library as JSON, for programs.
module asperity_json
  use asperity_case, only: case_file_type, case_type
  use asperity_contract, only: implex_table, max_inclined, n_cap_statev, n_facet_statev, n_fixed_props, &
    n_listed_values, n_plane_statev, n_point_statev, n_required_props, prop_table, statev_table, statev_type, version
  use asperity_digits, only: most_digits, put_digits
  use asperity_errors, only: errors_type, word
  use asperity_kinds, only: wp
  use asperity_point_law, only: event_length
  use asperity_rows, only: row_columns
  use asperity_stability, only: stability_columns
  use asperity_steps, only: explicit_entries, list_type, step_table
  use asperity_text, only: integer_text
  implicit none
  private
  public :: case_json, errors_json, tables_json

  !> Text that grows by doubling its room.
  type :: writer
    character(len=:), allocatable :: text
    integer :: n = 0                        !! characters
    logical :: first = .true.               !! whether nothing precedes the next value
  contains
    procedure :: put
    procedure :: open
    procedure :: close
    procedure :: string
    procedure :: number
    procedure :: numbers
    procedure :: flag
  end type writer

contains

  !> A case file: `title`, `sweep` (name, "" without one), `pattern` (first and last byte of the group) and `runs`.
  !>
  !> A run has `value` (of the sweep), `lost` (whether a loss of equilibrium is expected), `tolerance` (null: none),
  !> `start` ("virgin", "state" or "initial"), `s`, `work` (null: that of the energies), `traction` (null: that at
  !> rest), `p` and `statev` there, `props` (empty: the law is a UMAT) and `steps`, of which each has the entries that
  !> it gives.
  pure subroutine case_json(file, text)
    type(case_file_type), intent(in) :: file                !! read without errors
    character(len=:), allocatable, intent(out) :: text      !! JSON
    type(writer) :: out
    integer :: i
    call out%open("", "{")
    call out%string("title", file%cases(1)%title)
    call out%string("sweep", file%sweep)
    call out%open("pattern", "[")
    call out%put("", integer_text(file%pattern(1)))
    call out%put("", integer_text(file%pattern(2)))
    call out%close("]")
    call out%open("runs", "[")
    do i = 1, size(file%cases)
      call out%open("", "{")
      if (size(file%values) > 0) call out%number("value", file%values(i))
      call put_run(out, file%cases(i))
      call out%close("}")
    end do
    call out%close("]")
    call out%close("}")
    text = out%text(:out%n)
  end subroutine case_json

  !> Members of a run.
  pure subroutine put_run(out, case)
    type(writer), intent(inout) :: out     !! the text
    type(case_type), intent(in) :: case    !! the case of the run
    type(list_type) :: given(size(step_table))
    character(len=7) :: start
    integer :: i, j
    call out%flag("lost", case%expect%lost)
    if (case%refines) call out%number("tolerance", case%tolerance)
    start = "virgin"
    if (case%state%given) start = merge("initial", "state  ", case%initial%given)
    call out%string("start", trim(start))
    call out%numbers("s", case%state%s)
    if (case%state%has_work) call out%number("work", case%state%work)
    if (case%state%has_traction) call out%numbers("traction", case%state%traction)
    call out%number("p", case%state%p)
    call out%number("a_0", case%aperture%a_0)
    call out%number("a_min", case%aperture%a_min)
    call out%numbers("statev", case%state%statev)
    call out%numbers("props", case%props)
    call out%open("steps", "[")
    do i = 1, size(case%steps)
      call out%open("", "{")
      call explicit_entries(case%steps(i), given)
      do j = 1, size(given)
        if (allocated(given(j)%values)) call out%numbers(trim(step_table(j)%name), given(j)%values)
      end do
      call out%close("}")
    end do
    call out%close("]")
  end subroutine put_run

  !> A list of errors, each with `words`, and with what is known of `file`, `line`, `group`, `step`, `name`, `at`,
  !> `value` and `text`.
  pure subroutine errors_json(errors, text)
    type(errors_type), intent(in) :: errors                 !! the errors
    character(len=:), allocatable, intent(out) :: text      !! JSON
    type(writer) :: out
    character(len=:), allocatable :: line
    integer :: i
    call out%open("", "[")
    do i = 1, errors%n
      call word(errors%list(i), line)
      call out%open("", "{")
      call out%string("words", line)
      associate (e => errors%list(i))
        if (allocated(e%file)) call out%string("file", e%file)
        if (e%line >= 0) call out%put("line", integer_text(e%line))
        if (allocated(e%group)) call out%string("group", e%group)
        if (e%step >= 0) call out%put("step", integer_text(e%step))
        if (allocated(e%name)) call out%string("name", e%name)
        if (e%at >= 0) call out%put("at", integer_text(e%at))
        if (allocated(e%value)) call out%string("value", e%value)
        if (allocated(e%text)) call out%string("text", e%text)
      end associate
      call out%close("}")
    end do
    call out%close("]")
    text = out%text(:out%n)
  end subroutine errors_json

  !> Tables of the library: `version`, `sizes`, `props`, `statev`, `implex`, `columns` (of rows), `stability` and
  !> `entries` (of a step).
  pure subroutine tables_json(text)
    character(len=:), allocatable, intent(out) :: text      !! JSON
    type(writer) :: out
    integer :: i
    call out%open("", "{")
    call out%string("version", version)
    call out%open("sizes", "{")
    call out%put("fixed_props", integer_text(n_fixed_props))
    call out%put("required_props", integer_text(n_required_props))
    call out%put("listed_values", integer_text(n_listed_values))
    call out%put("point_statev", integer_text(n_point_statev))
    call out%put("plane_statev", integer_text(n_plane_statev))
    call out%put("facet_statev", integer_text(n_facet_statev))
    call out%put("cap_statev", integer_text(n_cap_statev))
    call out%put("max_inclined", integer_text(max_inclined))
    call out%put("events", integer_text(event_length))
    call out%close("}")
    call out%open("props", "[")
    do i = 1, size(prop_table)
      associate (row => prop_table(i))
        call out%open("", "{")
        call out%string("name", trim(row%name))
        call out%string("owner", trim(row%owner))
        call out%string("meaning", trim(row%meaning))
        call out%string("unit", trim(row%unit))
        call out%string("admissible", trim(row%admissible))
        call out%string("scale", trim(row%scale))
        call out%string("shown_by", trim(row%shown_by))
        call out%number("lower", row%lower)
        call out%number("upper", row%upper)
        call out%number("default", row%default)
        call out%numbers("plausible", row%plausible)
        call out%flag("inclined", row%inclined)
        call out%close("}")
      end associate
    end do
    call out%close("]")
    call put_variables(out, "statev", statev_table)
    call put_variables(out, "implex", implex_table)
    call put_names(out, "columns", row_columns)
    call put_names(out, "stability", stability_columns)
    call out%open("entries", "[")
    do i = 1, size(step_table)
      call out%open("", "{")
      call out%string("name", trim(step_table(i)%name))
      call out%flag("single", step_table(i)%single)
      call out%number("default", step_table(i)%default)
      call out%close("}")
    end do
    call out%close("]")
    call out%close("}")
    text = out%text(:out%n)
  end subroutine tables_json

  !> A list of state variables.
  pure subroutine put_variables(out, name, rows)
    type(writer), intent(inout) :: out            !! the text
    character(len=*), intent(in) :: name          !! of the list
    type(statev_type), intent(in) :: rows(:)      !! its members
    integer :: i
    call out%open(name, "[")
    do i = 1, size(rows)
      call out%open("", "{")
      call out%string("name", trim(rows(i)%name))
      call out%string("meaning", trim(rows(i)%meaning))
      call out%string("unit", trim(rows(i)%unit))
      call out%close("}")
    end do
    call out%close("]")
  end subroutine put_variables

  !> A list of names.
  pure subroutine put_names(out, name, names)
    type(writer), intent(inout) :: out            !! the text
    character(len=*), intent(in) :: name          !! of the list
    character(len=*), intent(in) :: names(:)      !! its members
    integer :: i
    call out%open(name, "[")
    do i = 1, size(names)
      call out%string("", trim(names(i)))
    end do
    call out%close("]")
  end subroutine put_names

  !> Append a value, with its name within an object, as it is written.
  pure subroutine put(out, name, value)
    class(writer), intent(inout) :: out     !! the text
    character(len=*), intent(in) :: name    !! of the member; empty: a member of a list
    character(len=*), intent(in) :: value   !! JSON
    if (.not. out%first) call add(out, ",")
    if (len(name) > 0) call add(out, '"' // name // '":')
    call add(out, value)
    out%first = .false.
  end subroutine put

  !> Begin an object or a list.
  pure subroutine open(out, name, bracket)
    class(writer), intent(inout) :: out       !! the text
    character(len=*), intent(in) :: name      !! of the member; empty: a member of a list
    character(len=1), intent(in) :: bracket   !! { or [
    call out%put(name, bracket)
    out%first = .true.
  end subroutine open

  !> End an object or a list.
  pure subroutine close(out, bracket)
    class(writer), intent(inout) :: out       !! the text
    character(len=1), intent(in) :: bracket   !! } or ]
    call add(out, bracket)
    out%first = .false.
  end subroutine close

  !> Append a string; quotes, backslashes and control characters are escaped.
  pure subroutine string(out, name, value)
    class(writer), intent(inout) :: out     !! the text
    character(len=*), intent(in) :: name    !! of the member; empty: a member of a list
    character(len=*), intent(in) :: value   !! UTF-8
    character(len=*), parameter :: digits = "0123456789abcdef"
    integer :: code, i
    call out%put(name, '"')
    do i = 1, len(value)
      code = iachar(value(i:i))
      if (value(i:i) == '"' .or. value(i:i) == achar(92)) then
        call add(out, achar(92) // value(i:i))
      else if (code < 32) then
        associate (high => code/16 + 1, low => mod(code, 16) + 1)
          call add(out, achar(92) // "u00" // digits(high:high) // digits(low:low))
        end associate
      else
        call add(out, value(i:i))
      end if
    end do
    call add(out, '"')
  end subroutine string

  !> Append a number, which reads back exactly. A path has many of them: 17 digits are written at once, while the
  !> shortest text is found by trial.
  pure subroutine number(out, name, value)
    class(writer), intent(inout) :: out     !! the text
    character(len=*), intent(in) :: name    !! of the member; empty: a member of a list
    real(wp), intent(in) :: value           !! finite
    real(wp), parameter :: whole = 1.0e9_wp
    character(len=most_digits) :: text
    integer :: length
    if (abs(value) < whole .and. .not. abs(value - aint(value)) > 0.0_wp) then
      write (text, "(f12.1)") value
    else
      call put_digits(value, text, length)
    end if
    call out%put(name, trim(adjustl(text)))
  end subroutine number

  !> Append a list of numbers.
  pure subroutine numbers(out, name, values)
    class(writer), intent(inout) :: out     !! the text
    character(len=*), intent(in) :: name    !! of the member; empty: a member of a list
    real(wp), intent(in) :: values(:)       !! finite
    integer :: i
    call out%open(name, "[")
    do i = 1, size(values)
      call out%number("", values(i))
    end do
    call out%close("]")
  end subroutine numbers

  !> Append true or false.
  pure subroutine flag(out, name, value)
    class(writer), intent(inout) :: out     !! the text
    character(len=*), intent(in) :: name    !! of the member; empty: a member of a list
    logical, intent(in) :: value            !! which
    call out%put(name, trim(merge("true ", "false", value)))
  end subroutine flag

  !> Append characters.
  pure subroutine add(out, text)
    class(writer), intent(inout) :: out     !! the text
    character(len=*), intent(in) :: text    !! these
    character(len=:), allocatable :: longer
    if (.not. allocated(out%text)) allocate (character(len=4096) :: out%text)
    if (out%n + len(text) > len(out%text)) then
      allocate (character(len=2*(out%n + len(text))) :: longer)
      longer(:out%n) = out%text(:out%n)
      call move_alloc(longer, out%text)
    end if
    out%text(out%n + 1:out%n + len(text)) = text
    out%n = out%n + len(text)
  end subroutine add

end module asperity_json
