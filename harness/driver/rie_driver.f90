!> Driver of one interface point: runs a case file and writes its history as CSV.
program rie_driver
  use, intrinsic :: iso_fortran_env, only: output_unit
  use asperity_case, only: case_file_type, read_cases
  use asperity_contract, only: version
  use asperity_errors, only: error_type, errors_type, fail, put_words, word
  use asperity_kinds, only: wp
  use asperity_rows, only: csv_header
  use asperity_text, only: integer_text, set_text, to_text
  use asperity_text_file, only: last_separator
  use asperity_warnings, only: n_measures
  use case_law, only: check_case, get_law, law_type
  use case_run, only: failed_file, failed_title, measures_of_case, run_case, warn_of
  use driver_output, only: end_with_input, exit_input, exit_ok, finish, may_replace, report_start, same_file, say, &
    without, write_report
  use replay, only: read_replayed
  implicit none

  character(len=*), parameter :: usage(21) = [character(len=96) :: &
    "usage: rie_driver CASE.nml [-o OUT.csv] [--planes] [--quiet] [--check] [--only N]", &
    "  -o OUT.csv  output, - for standard output (default: name of the case, here;", &
    "              a case with &sweep writes one file per value, OUT_<value>.csv)", &
    "  --planes    columns alpha_k, s_dit_k, s_dih_k of every plane, worn_k with W0", &
    "  --quiet     no progress line, no summary", &
    "  --check     check the UMAT along the load path: a table instead of the file", &
    "  --only N    of the values of &sweep only the one with number N, from 1", &
    "  --report FILE  exit code and message as JSON, more columns; not with &sweep", &
    "  --force     replace files that rie_driver did not write", &
    "  --until-eof end when standard input ends: a pipe that the program which calls holds open", &
    "  --version   print the version", &
    "exit code: 0 ended as expected, 1 bad input or a UMAT of others that fails,", &
    "2 equilibrium lost or another end than expected; every row that converged is kept", &
    "case file: groups &name entry = value, ... /, comments after !; docs/reference/driver.md", &
    "explains case, material, pattern, umat, step, expect, sweep, initial, state and replay;", &
    "a wrong name of an entry is reported with those that its group has", &
    "example: slip of 0.6 along 30 degrees under a normal traction of -5", &
    "  &material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /", &
    "  &pattern sides = 4, theta = 30.0 /", &
    "  &step t_N = -5.0 /", &
    "  &step slip = 0.6, direction = 30.0, increments = 240 /"]
  character(len=:), allocatable :: path, output, report
  logical :: check = .false., force = .false., planes = .false., quiet = .false.
  integer :: only = 0   !! number of the only value of the sweep to run, 0: all

  call read_command_line()
  call run()

contains

  !> Read the arguments of the command.
  subroutine read_command_line()
    character(len=:), allocatable :: argument
    integer :: i
    logical :: good
    path = ""
    output = ""
    report = ""
    i = 1
    if (command_argument_count() == 0) call reject("no case file")
    do while (i <= command_argument_count())
      argument = argument_text(i)
      select case (argument)
      case ("-h", "--help")
        write (output_unit, "(a)") (trim(usage(i)), i=1, size(usage))
        call finish(exit_ok)
      case ("--version")
        write (output_unit, "(2a)") "rie_driver ", version
        call finish(exit_ok)
      case ("--planes")
        planes = .true.
      case ("--quiet")
        quiet = .true.
      case ("--check")
        check = .true.
      case ("--force")
        force = .true.
      case ("--until-eof")
        if (end_with_input() /= 0) call reject("--until-eof: no thread could be started")
      case ("--only")
        i = i + 1
        argument = argument_text(i)
        if (len(argument) > 0 .and. len(argument) < 10 .and. verify(argument, "0123456789") == 0) then
          read (argument, *) only
        end if
        if (only < 1) call reject("--only " // argument // ": expected a number from 1")
      case ("-o", "--report")
        i = i + 1
        if (len(argument_text(i)) == 0) call reject(argument // " without a file name")
        if (argument == "-o") output = argument_text(i)
        if (argument == "--report") report = argument_text(i)
      case default
        if (index(argument, "-") == 1) call reject(argument // ": unknown option")
        if (len(path) > 0) call reject(argument // ": one case file at a time")
        if (len(argument) == 0) call reject("empty name of a case file")
        path = argument
      end select
      i = i + 1
    end do
    if (len(path) == 0) call reject("no case file")
    if (len(report) > 0) then
      good = may_replace(report, report_start)
      if (same_file(report, path) .or. report == output .or. .not. (force .or. good)) then
        call reject("--report " // report // " would replace a file that is no report: expected another name")
      end if
    end if
  end subroutine read_command_line

  !> Argument i; empty beyond the last one.
  function argument_text(i) result(text)
    integer, intent(in) :: i   !! from 1
    character(len=:), allocatable :: text
    integer :: length
    length = 0
    if (i <= command_argument_count()) call get_command_argument(i, length=length)
    allocate (character(len=length) :: text)
    if (length > 0) call get_command_argument(i, text)
  end function argument_text

  !> Report an error in the command and end.
  subroutine reject(reason)
    character(len=*), intent(in) :: reason   !! what is wrong
    call say(reason // "; rie_driver --help shows the usage")
    call finish(exit_input)
  end subroutine reject

  !> Read and check everything, then run the case, once for every value of its sweep.
  subroutine run()
    type(case_file_type) :: file
    type(errors_type) :: errors
    type(law_type), allocatable :: laws(:)
    character(len=:), allocatable :: header, label
    real(wp) :: largest(n_measures), measures(n_measures)
    integer :: code, first, i, last, worst

    call read_cases(path, file, errors)
    call end_on_errors(errors)
    call csv_header(header, .false., .false.)
    allocate (laws(size(file%cases)))
    do i = 1, size(file%cases)
      call get_law(file%cases(i), path, laws(i)%law, errors)
      if (errors%n == 0 .and. size(file%cases(i)%steps) == 0) call read_replayed(file%cases(i), errors)
      if (errors%n > 0) exit
    end do
    associate (cases => file%cases, values => file%values)
      if (size(values) > 0 .and. len(report) > 0) call fail(errors, error_type(path), &
        "--report of a case with &sweep: expected no &sweep")
      if (size(values) > 0 .and. output == "-") call fail(errors, error_type(path), &
        "a case with &sweep writes a file per value, not standard output")
      do i = 1, merge(0, size(cases), check)
        call check_replaced(result_file(values, i), path, "the case file", header, errors)
        call check_replaced(failed_file(result_file(values, i)), path, "the case file", failed_title, errors)
        if (cases(i)%umat%given) call check_replaced(result_file(values, i), cases(i)%umat%library, &
          "the library of the UMAT", "", errors)
        if (allocated(cases(i)%replay%file)) call check_replaced(result_file(values, i), cases(i)%replay%file, &
          "the recorded strains", "", errors)
      end do
      if (only > size(cases)) call fail(errors, error_type(path), "--only " // integer_text(only) // &
        ": expected 1 to " // integer_text(size(cases)) // ", the number of values of &sweep")
      call end_on_errors(errors)
      first = merge(only, 1, only > 0)
      last = merge(only, size(cases), only > 0)
      largest = 0.0_wp
      do i = first, last
        if (.not. cases(i)%umat%given) largest = max(largest, measures_of_case(cases(i)))
      end do
      call warn_of(path, largest)

      if (len(cases(1)%title) > 0 .and. .not. quiet) call say(path // ": " // cases(1)%title)
      worst = exit_ok
      largest = 0.0_wp
      do i = first, last
        measures = 0.0_wp
        label = path
        if (size(values) > 0) label = path // " (" // file%sweep // " = " // to_text(values(i)) // ")"
        if (check) then
          call check_case(cases(i), laws(i)%law, label, code)
        else
          call run_case(cases(i), laws(i)%law, label, result_file(values, i), report, planes, quiet, &
            measures, code)
        end if
        worst = max(worst, code)
        largest = max(largest, measures)
        if (code == exit_input .and. .not. check) exit
      end do
    end associate
    call warn_of(path, largest)
    call finish(worst)
  end subroutine run

  !> Report an output that would replace a file of the input or, without --force, one that this program did not write.
  subroutine check_replaced(name, read, kind, start, errors)
    character(len=*), intent(in) :: name              !! output
    character(len=*), intent(in) :: read              !! file of the input
    character(len=*), intent(in) :: kind              !! what this file is
    character(len=*), intent(in) :: start             !! text with which this program begins such outputs; empty: any
    type(errors_type), intent(inout) :: errors        !! errors are added
    if (same_file(name, read)) then
      call fail(errors, error_type(path), "the output " // name // " would replace " // kind // ": expected another -o")
    else if (.not. force) then
      if (.not. may_replace(name, start)) call fail(errors, error_type(path), "the output " // name // &
        " would replace a file that rie_driver did not write: expected another -o, or --force")
    end if
  end subroutine check_replaced

  !> File with the rows of a case, of a value of its sweep if it has one.
  pure function result_file(values, i) result(name)
    real(wp), intent(in) :: values(:)      !! values of the sweep, size 0: none
    integer, intent(in) :: i               !! number of the value
    character(len=:), allocatable :: name
    name = output
    if (len(output) == 0) name = without(path(last_separator(path) + 1:), ".nml") // ".csv"
    if (size(values) > 0) name = without(name, ".csv") // "_" // to_text(values(i)) // ".csv"
  end function result_file

  !> End if the input has an error. A report does not name the file.
  subroutine end_on_errors(errors)
    type(errors_type), intent(inout) :: errors   !! of the input; their places in the file are removed
    character(len=:), allocatable :: line
    integer :: i
    if (errors%n == 0) return
    do i = 1, errors%n
      call word(errors%list(i), line)
      call say(line)
      if (allocated(errors%list(i)%file)) deallocate (errors%list(i)%file)
      errors%list(i)%line = -1
    end do
    call set_text(line, "")
    call put_words(errors, line)
    call write_report(report, exit_input, line, .false.)
    call finish(exit_input)
  end subroutine end_on_errors

end program rie_driver
