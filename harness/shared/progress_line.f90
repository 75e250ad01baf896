!> Progress of a long run as one line on standard error (only on a terminal): count, percentage and remaining time.
module progress_line
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: iso_fortran_env, only: error_unit, int64
  use asperity_text, only: integer_text
  use asperity_kinds, only: wp
  implicit none
  private
  public :: start_progress, show_progress, clear_progress

  !> Seconds before the first line and between two lines; file descriptor of standard error.
  real(wp), parameter :: patience = 2.0_wp, period = 0.5_wp
  integer(c_int), parameter :: standard_error = 2_c_int
  !> Carriage return and ANSI sequence that clears the line.
  character(len=*), parameter :: clear = achar(13) // achar(27) // "[K"

  !> Clock and names of a run.
  type, public :: progress_type
    logical :: quiet = .false.                             !! the user wants none
    logical, private :: possible = .false., shown = .false.
    integer(int64), private :: start = 0_int64, last = 0_int64
    character(len=16), private :: program = "", unit = ""
  end type progress_type

  interface
    !> POSIX: 1 if a file descriptor is a terminal.
    function c_isatty(file) bind(c, name="isatty") result(yes)
      import :: c_int
      implicit none
      integer(c_int), value :: file   !! file descriptor
      integer(c_int) :: yes
    end function c_isatty
  end interface

contains

  !> Start the clock of a run.
  subroutine start_progress(progress, program, unit, quiet)
    type(progress_type), intent(out) :: progress   !! progress
    character(len=*), intent(in) :: program        !! name of the program
    character(len=*), intent(in) :: unit           !! what is counted
    logical, intent(in) :: quiet                   !! never show a line
    progress%quiet = quiet
    if (.not. quiet) progress%possible = c_isatty(standard_error) == 1_c_int
    progress%program = program
    progress%unit = unit
    call system_clock(progress%start)
  end subroutine start_progress

  !> Show the progress if the run is long and some time has passed since the last line.
  subroutine show_progress(progress, label, done, total)
    type(progress_type), intent(inout) :: progress   !! progress
    character(len=*), intent(in) :: label            !! what is running, may be empty
    integer, intent(in) :: done, total               !! how many, of how many
    character(len=:), allocatable :: text
    integer(int64) :: now, rate
    real(wp) :: passed
    if (.not. progress%possible .or. done < 1) return
    call system_clock(now, rate)
    passed = real(now - progress%start, wp)/real(rate, wp)
    if (passed < patience) return
    if (progress%shown .and. real(now - progress%last, wp) < period*real(rate, wp)) return
    text = clear // trim(progress%program) // ": "
    if (len(label) > 0) text = text // label // ": "
    call put(text // integer_text(done) // " of " // integer_text(total) // " " // trim(progress%unit) // " (" // &
      integer_text(int((100_int64*done)/max(total, 1))) // " %), " // &
      duration(passed*real(max(total - done, 0), wp)/real(done, wp)) // " left")
    progress%last = now
    progress%shown = .true.
  end subroutine show_progress

  !> Clear the line, if there is one, before another message.
  subroutine clear_progress(progress)
    type(progress_type), intent(inout) :: progress   !! progress
    if (progress%shown) call put(clear)
    progress%shown = .false.
  end subroutine clear_progress

  !> Text of a duration in seconds or minutes.
  pure function duration(seconds) result(text)
    real(wp), intent(in) :: seconds   !! >= 0
    character(len=:), allocatable :: text
    if (seconds < 120.0_wp) then
      text = integer_text(int(seconds)) // " s"
    else
      text = integer_text(int(min(seconds/60.0_wp, 1.0e6_wp))) // " min"
    end if
  end function duration

  !> Write to standard error.
  subroutine put(text)
    character(len=*), intent(in) :: text   !! bytes
    write (error_unit, "(a)", advance="no") text
    flush (error_unit)
  end subroutine put

end module progress_line
