!> Messages of the driver on standard error, and its exit codes.
module driver_messages
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: iso_fortran_env, only: error_unit
  use progress_line, only: clear_progress, progress_type
  implicit none
  private
  public :: say, tell, finish

  integer, parameter, public :: exit_ok = 0      !! the run ended as expected
  integer, parameter, public :: exit_input = 1   !! bad input
  integer, parameter, public :: exit_solve = 2   !! equilibrium lost, or an unexpected end

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

  !> Write a message during a run, unless the run is quiet.
  subroutine tell(progress, text)
    type(progress_type), intent(inout) :: progress   !! of the run
    character(len=*), intent(in) :: text             !! lines
    if (progress%quiet) return
    call clear_progress(progress)
    call say(text)
  end subroutine tell

  !> End the program.
  subroutine finish(code)
    integer, intent(in) :: code   !! exit_ok, exit_input or exit_solve
    call c_exit(int(code, c_int))
  end subroutine finish

end module driver_messages
