!> What the driver writes: messages on standard error, and files, one at a time (driver_output.c).
!>
!> The Fortran run-time libraries do not report a full disk. On a full tmpfs and on /dev/full, iostat of write, flush
!> and close is 0 with gfortran 12, whether a unit stays open or is opened for each line; with flang 16 flush reports
!> the error, and the close after it ends the program.
module driver_output
  use, intrinsic :: iso_c_binding, only: c_bool, c_char, c_int, c_null_char, c_size_t
  use, intrinsic :: iso_fortran_env, only: error_unit
  use asperity_text, only: integer_text
  implicit none
  private
  public :: say, finish, same_file, may_replace, create_file, write_line, close_file, without, write_report, &
    end_with_input

  integer, parameter, public :: exit_ok = 0      !! the run ended as expected
  integer, parameter, public :: exit_input = 1   !! bad input
  integer, parameter, public :: exit_solve = 2   !! equilibrium lost, or an unexpected end

  !> Start of every report.
  character(len=*), parameter, public :: report_start = "{""code"": "

  ! a file that cannot be written ends the program with a message
  interface
    !> Standard C: end the program with an exit code (`stop` would print).
    subroutine c_exit(code) bind(c, name="exit")
      import :: c_int
      implicit none
      integer(c_int), value :: code
    end subroutine c_exit
    !> Create or empty a file.
    subroutine c_create(path) bind(c, name="output_create")
      import :: c_char
      implicit none
      ! allow(C071): the interface is that of C
      character(kind=c_char), intent(in) :: path(*)
    end subroutine c_create
    !> Write all bytes or none.
    subroutine c_write(bytes, n) bind(c, name="output_write")
      import :: c_char, c_size_t
      implicit none
      ! allow(C071): the interface is that of C
      character(kind=c_char), intent(in) :: bytes(*)
      integer(c_size_t), value :: n
    end subroutine c_write
    !> End this program when standard input ends; 0, or an error.
    function end_with_input() bind(c, name="system_end_with_input") result(error)
      import :: c_int
      implicit none
      integer(c_int) :: error
    end function end_with_input
    !> Close the file.
    subroutine close_file() bind(c, name="output_close")
      implicit none
    end subroutine close_file
  end interface
  abstract interface
    !> A question about a file.
    function c_question(path, text) bind(c) result(yes)
      import :: c_bool, c_char
      implicit none
      ! allow(C071): the interface is that of C
      character(kind=c_char), intent(in) :: path(*), text(*)
      logical(c_bool) :: yes
    end function c_question
  end interface
  procedure(c_question), bind(c, name="output_same_file") :: c_same_file
  procedure(c_question), bind(c, name="output_may_replace") :: c_may_replace

contains

  !> Write one or more lines to standard error.
  subroutine say(text)
    character(len=*), intent(in) :: text   !! lines
    write (error_unit, "(2a)") "rie_driver: ", text
    flush (error_unit)
  end subroutine say

  !> End the program.
  subroutine finish(code)
    integer, intent(in) :: code   !! exit_ok, exit_input or exit_solve
    call c_exit(int(code, c_int))
  end subroutine finish

  !> Whether two names denote the same existing file, also through a symbolic or a hard link.
  function same_file(first, second) result(same)
    character(len=*), intent(in) :: first, second   !! names
    logical :: same
    same = c_same_file(first // c_null_char, second // c_null_char)
  end function same_file

  !> Whether a file is new or empty, or one that this program wrote; "-" is standard output.
  function may_replace(path, start) result(may)
    character(len=*), intent(in) :: path    !! file
    character(len=*), intent(in) :: start   !! text with which this program begins such files
    logical :: may
    may = c_may_replace(path // c_null_char, start // c_null_char)
  end function may_replace

  !> Create or empty a file for writing, which no other run writes; "-" is standard output.
  subroutine create_file(path)
    character(len=*), intent(in) :: path   !! file
    call c_create(path // c_null_char)
  end subroutine create_file

  !> Write a line to this file: a run that is ended leaves complete lines.
  subroutine write_line(line)
    character(len=*), intent(in) :: line   !! without line end
    call c_write(line // new_line("a"), int(len(line) + 1, c_size_t))
  end subroutine write_line

  !> Name without its ending.
  pure function without(name, ending) result(stem)
    character(len=*), intent(in) :: name     !! of a file
    character(len=*), intent(in) :: ending   !! ending that is removed
    character(len=:), allocatable :: stem
    stem = name
    if (len(name) <= len(ending)) return
    if (name(len(name) - len(ending) + 1:) == ending) stem = name(:len(name) - len(ending))
  end function without

  !> Write the result of a run as JSON, for programs that call the driver.
  subroutine write_report(path, code, message, lost)
    character(len=*), intent(in) :: path      !! file, replaced if it exists; empty: no report
    integer, intent(in) :: code               !! exit code
    character(len=*), intent(in) :: message   !! why the run has not ended as expected, a line per reason, or empty
    logical, intent(in) :: lost               !! whether the last row is that of a lost equilibrium
    character(len=:), allocatable :: escaped
    integer :: i, n
    if (len(path) == 0) return
    allocate (character(len=2*len(message)) :: escaped)
    n = 0
    do i = 1, len(message)
      select case (message(i:i))
      case ("""", "\")
        escaped(n + 1:n + 2) = "\" // message(i:i)
        n = n + 2
      case (achar(10))
        escaped(n + 1:n + 2) = "\n"
        n = n + 2
      case (achar(0):achar(9), achar(11):achar(31))
        escaped(n + 1:n + 1) = " "
        n = n + 1
      case default
        escaped(n + 1:n + 1) = message(i:i)
        n = n + 1
      end select
    end do
    call create_file(path)
    call write_line(report_start // integer_text(code) // ", ""message"": """ // escaped(:n) // """, ""lost"": " // &
      trim(merge("true ", "false", lost)) // "}")
    call close_file()
  end subroutine write_report

end module driver_output
