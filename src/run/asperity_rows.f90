!> Columns of the rows of a run: the one table of their names, for CSV files and for programs.
module asperity_rows
  use asperity_contract, only: v_damage, v_friction, v_rupture, v_stored
  use asperity_kinds, only: wp
  use asperity_load_path, only: row_type
  use asperity_text, only: integer_text
  implicit none
  private
  public :: row_numbers, csv_header, csv_line

  !> A number of a row.
  type :: column_type
    character(len=10) :: name       !! in the header
    logical :: whole                !! whether it is a whole number
    character(len=64) :: meaning    !! one line
    character(len=14) :: unit       !! in the user's consistent set
  end type column_type

  !> Columns in their order. A file has the first `n_written` of them or, for a program, all, then the names of events,
  !> then those of the state.
  integer, parameter :: n_written = 15
  type(column_type), parameter, public :: row_columns(25) = [ &
    column_type("step", .true., "number of the step, from 1", "-"), &
    column_type("increment", .true., "number of the increment in its step, from 1", "-"), &
    column_type("time", .false., "time at its end", "time"), &
    column_type("s_N", .false., "separation N", "length"), &
    column_type("s_Tx", .false., "separation Tx", "length"), &
    column_type("s_Ty", .false., "separation Ty", "length"), &
    column_type("t_N", .false., "traction N", "stress"), &
    column_type("t_Tx", .false., "traction Tx", "stress"), &
    column_type("t_Ty", .false., "traction Ty", "stress"), &
    column_type("damage", .false., "sum of gamma*alpha over the planes", "-"), &
    column_type("stored", .false., "stored energy", "stress*length"), &
    column_type("rupture", .false., "energy spent on rupture", "stress*length"), &
    column_type("friction", .false., "energy dissipated by friction and wear", "stress*length"), &
    column_type("work", .false., "work of the traction", "stress*length"), &
    column_type("iterations", .true., "iterations of Newton's method; of a replay: calls", "-"), &
    column_type("position", .false., "targets reached before, and the fraction of the next one", "-"), &
    column_type("updates", .true., "updates of the law", "-"), &
    column_type("snaps", .true., "jumps to another branch of equilibria", "-"), &
    column_type("before_N", .false., "separation N before the longest of them", "length"), &
    column_type("before_Tx", .false., "separation Tx before it", "length"), &
    column_type("before_Ty", .false., "separation Ty before it", "length"), &
    column_type("after_N", .false., "separation N after it", "length"), &
    column_type("after_Tx", .false., "separation Tx after it", "length"), &
    column_type("after_Ty", .false., "separation Ty after it", "length"), &
    column_type("released", .false., "energy released by all of them", "stress*length")]

contains

  !> Numbers of a row, in the order of the table.
  pure function row_numbers(row) result(numbers)
    type(row_type), intent(in) :: row   !! the row
    real(wp) :: numbers(size(row_columns))
    associate (report => row%report)
      numbers = [real([row%step, row%increment], wp), row%time, row%s, row%traction, &
        row%state([v_damage, v_stored, v_rupture, v_friction]), row%work, real(report%iterations, wp), row%position, &
        real([report%updates, report%snaps], wp), report%before, report%after, report%released]
    end associate
  end function row_numbers

  !> Header of a file, without the columns of the state.
  pure subroutine csv_header(header, every)
    character(len=:), allocatable, intent(out) :: header   !! names separated by commas
    logical, intent(in) :: every                           !! whether the file has all numbers of a row
    integer :: i
    header = ""
    do i = 1, merge(size(row_columns), n_written, every)
      header = header // trim(row_columns(i)%name) // ","
    end do
    header = header // "event"
  end subroutine csv_header

  !> Line of a row: numbers, events, and the numbers of the state from one of them on.
  pure subroutine csv_line(row, every, first, line)
    type(row_type), intent(in) :: row                    !! the row
    logical, intent(in) :: every                         !! whether the file has all its numbers
    integer, intent(in) :: first                         !! first number of the state that has a column
    character(len=:), allocatable, intent(out) :: line   !! fields separated by commas
    real(wp) :: numbers(size(row_columns))
    integer :: i
    numbers = row_numbers(row)
    line = ""
    do i = 1, merge(size(row_columns), n_written, every)
      if (row_columns(i)%whole) then
        line = line // integer_text(nint(numbers(i))) // ","
      else
        call add_number(line, numbers(i))
        line = line // ","
      end if
    end do
    line = line // trim(row%events)
    do i = first, size(row%state)
      line = line // ","
      call add_number(line, row%state(i))
    end do
  end subroutine csv_line

  !> Append a number with 17 digits, which determine it exactly.
  pure subroutine add_number(line, value)
    character(len=:), allocatable, intent(inout) :: line   !! fields so far
    real(wp), intent(in) :: value                          !! finite
    character(len=26) :: buffer
    write (buffer, "(es26.16e3)") value
    line = line // trim(adjustl(buffer))
  end subroutine add_number

end module asperity_rows
