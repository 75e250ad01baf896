!> Result of a run as JSON, for programs that call the driver: exit code, why the run has not ended as expected, snaps.
module run_report
  use asperity_kinds, only: wp
  use asperity_load_path, only: row_type
  use asperity_text, only: integer_text, to_text
  use row_file, only: close_file, create_file, write_line
  implicit none
  private
  public :: add_snap, write_report

  !> Start of every report.
  character(len=*), parameter, public :: report_start = "{""code"": "

contains

  !> Append the snap of a row to a list.
  subroutine add_snap(snaps, number, row)
    character(len=:), allocatable, intent(inout) :: snaps   !! objects, separated by commas
    integer, intent(in) :: number                           !! of the row, from 0
    type(row_type), intent(in) :: row                       !! with a snap
    if (len(snaps) > 0) snaps = snaps // "," // new_line("a")
    snaps = snaps // "{""row"": " // integer_text(number) // ", ""before"": " // list(row%report%before) // &
      ", ""after"": " // list(row%report%after) // ", ""released"": " // to_text(row%report%released) // "}"
  end subroutine add_snap

  !> Write the report.
  subroutine write_report(path, code, message, lost, snaps)
    character(len=*), intent(in) :: path      !! file, replaced if it exists; empty: no report
    integer, intent(in) :: code               !! exit code
    character(len=*), intent(in) :: message   !! one line per reason, empty: none
    logical, intent(in) :: lost               !! whether the last row is that of a lost equilibrium
    character(len=*), intent(in) :: snaps     !! of add_snap
    integer :: file
    logical :: good
    if (len(path) == 0) return
    call create_file(path, file, good)
    if (.not. good) return
    call write_line(file, path, report_start // integer_text(code) // ", ""message"": """ // escaped(message) // &
      """, ""lost"": " // trim(merge("true ", "false", lost)) // ", ""snaps"": [" // snaps // "]}", good)
    call close_file(file, path, good)
  end subroutine write_report

  !> A list of numbers.
  pure function list(values) result(text)
    real(wp), intent(in) :: values(:)   !! finite
    character(len=:), allocatable :: text
    integer :: i
    text = "["
    do i = 1, size(values)
      if (i > 1) text = text // ", "
      text = text // to_text(values(i))
    end do
    text = text // "]"
  end function list

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
