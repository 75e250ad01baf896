!> Report of a rejected call in Abaqus/Standard, by its message routine; the analysis ends. The single sources for
!> Abaqus/Explicit have it with the names of that (cmake/single_file.cmake).
module asperity_report
  use asperity_kinds, only: wp
  use asperity_text, only: piece_end
  implicit none
  private
  public :: report

  !> Abaqus/Standard: error message. The analysis continues; this module ends it after the last line.
  integer, parameter :: error_message = -2
  !> Number of characters that Abaqus prints of a message.
  integer, parameter :: text_length = 500

  interface
    !> Write a message of Abaqus/Standard; %I, %R and %S in the text stand for the values.
    subroutine stdb_abqerr(lop, string, intv, realv, charv)
      import :: wp
      implicit none
      integer, intent(in) :: lop                   !! 1 information, -1 warning, -2 error, -3 error and end
      character(len=*), intent(in) :: string       !! text
      integer, intent(in) :: intv(*)               !! integers
      real(wp), intent(in) :: realv(*)             !! reals
      character(len=8), intent(in) :: charv(*)     !! texts
    end subroutine stdb_abqerr

    !> End the analysis: close all files and stop all processes.
    subroutine xit()
      implicit none
    end subroutine xit
  end interface

contains

  !> Write why a call was rejected to the files of the analysis, one message for each line, and end the analysis.
  !>
  !> The text contains the values: the formats of Abaqus print fewer digits and only eight characters of a text. No text
  !> of the library contains a percent sign, which Abaqus would take for a format.
  subroutine report(routine, message)
    character(len=*), intent(in) :: routine   !! name of the user routine
    character(len=*), intent(in) :: message   !! lines that name the values and what was expected
    character(len=text_length) :: text
    integer, parameter :: no_integers(1) = 0
    real(wp), parameter :: no_reals(1) = 0.0_wp
    character(len=8), parameter :: no_texts(1) = " "
    character(len=len(routine) + 11) :: head
    integer :: first, last
    head = "asperity " // routine // ": "
    first = 1
    do while (first <= len(message))
      last = piece_end(message, first, text_length - len(head))
      text = head // message(first:last)
      call stdb_abqerr(error_message, text, no_integers, no_reals, no_texts)
      first = last + 1
      if (index(message(first:), new_line("a")) == 1) first = first + 1
    end do
    call xit()
  end subroutine report

end module asperity_report
