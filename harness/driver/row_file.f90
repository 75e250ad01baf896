!> Output of lines, each by one system call: a run that is ended leaves complete lines, and errors are noticed. Only
!> SIGKILL can cut a line, at a page of the file. A line that can be written in part only is taken back.
!>
!> The Fortran run-time libraries do not report a full disk. On a full tmpfs and on /dev/full, iostat of write, flush
!> and close is 0 with gfortran 12, whether a unit stays open or is opened for each line; with flang 16 flush reports
!> the error, and the close after it ends the program.
module row_file
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_size_t
  use driver_messages, only: say
  implicit none
  private
  public :: create_file, write_line, close_file, same_file, may_replace

  integer(c_int), parameter :: standard_output = 1_c_int

  interface
    !> posix_file.c: create or empty a file, and lock it.
    function c_create(path) bind(c, name="posix_create") result(fd)
      import :: c_char, c_int
      implicit none
      ! allow(C071): the interface is that of C
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int) :: fd
    end function c_create
    !> posix_file.c: write all bytes or none.
    function c_write_line(fd, bytes, n) bind(c, name="posix_write_line") result(status)
      import :: c_char, c_int, c_size_t
      implicit none
      integer(c_int), value :: fd
      ! allow(C071): the interface is that of C
      character(kind=c_char), intent(in) :: bytes(*)
      integer(c_size_t), value :: n
      integer(c_int) :: status
    end function c_write_line
    !> POSIX: close a file.
    function c_close(fd) bind(c, name="close") result(status)
      import :: c_int
      implicit none
      integer(c_int), value :: fd
      integer(c_int) :: status
    end function c_close
    !> posix_file.c: whether two names denote the same file.
    function c_same_file(first, second) bind(c, name="posix_same_file") result(same)
      import :: c_char, c_int
      implicit none
      ! allow(C071): the interface is that of C
      character(kind=c_char), intent(in) :: first(*)
      ! allow(C071): the interface is that of C
      character(kind=c_char), intent(in) :: second(*)
      integer(c_int) :: same
    end function c_same_file
    !> posix_file.c: whether a file may be replaced.
    function c_may_replace(path, start) bind(c, name="posix_may_replace") result(may)
      import :: c_char, c_int
      implicit none
      ! allow(C071): the interface is that of C
      character(kind=c_char), intent(in) :: path(*)
      ! allow(C071): the interface is that of C
      character(kind=c_char), intent(in) :: start(*)
      integer(c_int) :: may
    end function c_may_replace
    !> Standard C: write to standard error why the last call failed.
    subroutine c_perror(prefix) bind(c, name="perror")
      import :: c_char
      implicit none
      ! allow(C071): the interface is that of C
      character(kind=c_char), intent(in) :: prefix(*)
    end subroutine c_perror
  end interface

contains

  !> Whether two names denote the same existing file, also through a symbolic or a hard link.
  function same_file(first, second) result(same)
    character(len=*), intent(in) :: first, second   !! names
    logical :: same
    same = c_same_file(first // c_null_char, second // c_null_char) /= 0
  end function same_file

  !> Whether a file is new or empty, or one that this program wrote; "-" is standard output.
  function may_replace(path, start) result(may)
    character(len=*), intent(in) :: path    !! file
    character(len=*), intent(in) :: start   !! text with which this program begins such files
    logical :: may
    may = path == "-"
    if (.not. may) may = c_may_replace(path // c_null_char, start // c_null_char) /= 0
  end function may_replace

  !> Create or empty a file for writing, which no other run writes; "-" is standard output.
  subroutine create_file(path, file, good)
    character(len=*), intent(in) :: path   !! file
    integer, intent(out) :: file           !! descriptor
    logical, intent(out) :: good           !! false: the reason is on standard error
    if (path == "-") then
      file = standard_output
    else
      file = c_create(path // c_null_char)
    end if
    good = file >= 0
    if (file == -2) then
      call say(path // ": another run writes to it: expected another -o")
    else if (.not. good) then
      call tell(path)
    end if
  end subroutine create_file

  !> Write a line.
  subroutine write_line(file, path, line, good)
    integer, intent(in) :: file            !! descriptor
    character(len=*), intent(in) :: path   !! its name, for a message
    character(len=*), intent(in) :: line   !! without line end
    logical, intent(out) :: good           !! false: the reason is on standard error
    good = c_write_line(int(file, c_int), line // new_line("a"), int(len(line) + 1, c_size_t)) == 0
    if (.not. good) call tell(path)
  end subroutine write_line

  !> Close a file.
  subroutine close_file(file, path, good)
    integer, intent(in) :: file            !! descriptor
    character(len=*), intent(in) :: path   !! its name, for a message
    logical, intent(out) :: good           !! false: the reason is on standard error
    good = .true.
    if (file /= standard_output) good = c_close(int(file, c_int)) == 0
    if (.not. good) call tell(path)
  end subroutine close_file

  !> Write to standard error why the last call failed.
  subroutine tell(path)
    character(len=*), intent(in) :: path   !! of the file
    call c_perror("rie_driver: " // path // ": cannot be written" // c_null_char)
  end subroutine tell

end module row_file
