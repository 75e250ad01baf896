!> Result of a run as JSON, for programs that call the driver: exit code, why the run has not ended as expected.
module run_report
  use asperity_text, only: integer_text
  use row_file, only: close_file, create_file, write_line
  implicit none
  private
  public :: write_report

  !> Start of every report.
  character(len=*), parameter, public :: report_start = "{""code"": "

contains

  !> Write the report.
  subroutine write_report(path, code, message, lost)
    character(len=*), intent(in) :: path      !! file, replaced if it exists; empty: no report
    integer, intent(in) :: code               !! exit code
    character(len=*), intent(in) :: message   !! one line per reason, empty: none
    logical, intent(in) :: lost               !! whether the last row is that of a lost equilibrium
    integer :: file
    logical :: good
    if (len(path) == 0) return
    call create_file(path, file, good)
    if (.not. good) return
    call write_line(file, path, report_start // integer_text(code) // ", ""message"": """ // escaped(message) // &
      """, ""lost"": " // trim(merge("true ", "false", lost)) // "}", good)
    call close_file(file, path, good)
  end subroutine write_report

  !> Characters of a JSON string.
  pure function escaped(string) result(text)
    character(len=*), intent(in) :: string   !! any
    character(len=:), allocatable :: text
    integer :: i
    text = ""
    do i = 1, len(string)
      select case (string(i:i))
      case ("""", "\")
        text = text // "\" // string(i:i)
      case (achar(10))
        text = text // "\n"
      case (achar(0):achar(9), achar(11):achar(31))
        text = text // " "
      case default
        text = text // string(i:i)
      end select
    end do
  end function escaped

end module run_report
