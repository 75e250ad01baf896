!> Messages of the driver on standard error, and its exit codes.
module driver_messages
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: iso_fortran_env, only: error_unit, int64
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text, to_text
  implicit none
  private
  public :: say, tell, short, finish, begin_progress, show_progress, clear_progress

  integer, parameter, public :: exit_ok = 0      !! the run ended as expected
  integer, parameter, public :: exit_input = 1   !! bad input
  integer, parameter, public :: exit_solve = 2   !! a solve that cannot go on, or another end than expected

  !> Seconds before the first progress line, and between two.
  real(wp), parameter :: patience = 2.0_wp, period = 0.5_wp

  !> A progress line that shows up on long runs only.
  type, public :: progress_type
    private
    logical :: quiet = .false.
    logical :: shown = .false.
    integer(int64) :: start = -1_int64, last = 0_int64
  end type progress_type

  interface
    !> Standard C: end the program with an exit code (`stop` would print).
    subroutine c_exit(code) bind(c, name="exit")
      import :: c_int
      implicit none
      integer(c_int), value :: code
    end subroutine c_exit
  end interface

contains

  !> Write one or more lines, separated by new_line, to standard error.
  subroutine say(text)
    character(len=*), intent(in) :: text   !! lines
    write (error_unit, "(2a)") "rie_driver: ", text
    flush (error_unit)
  end subroutine say

  !> Say something during a run, unless it is a quiet one.
  subroutine tell(progress, text)
    type(progress_type), intent(inout) :: progress   !! of the run
    character(len=*), intent(in) :: text             !! lines
    if (progress%quiet) return
    call clear_progress(progress)
    call say(text)
  end subroutine tell

  !> Number for a message, six digits.
  pure function short(value) result(text)
    real(wp), intent(in) :: value   !! finite
    character(len=:), allocatable :: text
    character(len=16) :: buffer
    real(wp) :: rounded
    write (buffer, "(es16.5e3)") value
    read (buffer, "(f16.0)") rounded
    text = to_text(rounded)
  end function short

  !> End the program.
  subroutine finish(code)
    integer, intent(in) :: code   !! exit_ok, exit_input or exit_solve
    call c_exit(int(code, c_int))
  end subroutine finish

  !> Start the clock.
  subroutine begin_progress(progress, quiet)
    type(progress_type), intent(out) :: progress   !! progress
    logical, intent(in) :: quiet                !! never show
    progress%quiet = quiet
    call system_clock(progress%start)
    progress%last = progress%start
  end subroutine begin_progress

  !> Show how much is done, if the run is a long one and the last line is not too recent.
  subroutine show_progress(progress, label, done, total)
    type(progress_type), intent(inout) :: progress   !! progress
    character(len=*), intent(in) :: label         !! what is running
    integer, intent(in) :: done, total            !! increments
    integer(int64) :: now, rate
    if (progress%quiet) return
    call system_clock(now, rate)
    if (real(now - progress%start, wp) < patience*real(rate, wp)) return
    if (progress%shown .and. real(now - progress%last, wp) < period*real(rate, wp)) return
    write (error_unit, "(a)", advance="no") achar(13) // "rie_driver: " // label // ": " // integer_text(done) // &
      " of " // integer_text(total) // " increments (" // integer_text(int((100_int64*done)/total)) // " %)"
    flush (error_unit)
    progress%last = now
    progress%shown = .true.
  end subroutine show_progress

  !> End the progress line, if there is one, before another message.
  subroutine clear_progress(progress)
    type(progress_type), intent(inout) :: progress   !! progress
    if (progress%shown) write (error_unit, "(a)") ""
    progress%shown = .false.
  end subroutine clear_progress

end module driver_messages
