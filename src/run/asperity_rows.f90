!> Columns of the rows of a run: the one table of their names, for CSV files and for programs.
module asperity_rows
  use asperity_contract, only: v_damage, v_friction, v_rupture, v_stored
  use asperity_digits, only: most_digits, put_digits
  use asperity_kinds, only: wp
  use asperity_load_path, only: row_type
  use asperity_stability, only: stability_columns, stability_of
  use asperity_text, only: integer_text
  implicit none
  private
  public :: aperture_type, row_numbers, csv_header, csv_line

  !> Aperture of the joint, through which water flows: the larger one of a_min and a_0 + s_N.
  type :: aperture_type
    real(wp) :: a_0 = 0.0_wp     !! where s_N = 0, length
    real(wp) :: a_min = 0.0_wp   !! least one, length
  end type aperture_type

  !> Columns in their order: numbers (of a replay, `iterations` are calls; `position` is the number of targets reached
  !> before, and the fraction of the next one; `before` and `after` are those of the longest snap; `D` is the tangent).
  !> A file has the first `n_written` of them or, for a program, all, then the names of events, on request the numbers
  !> of the stability, then those of the state.
  character(len=*), parameter, public :: row_columns(36) = [character(len=10) :: "step", "increment", "time", "s_N", &
    "s_Tx", "s_Ty", "t_N", "t_Tx", "t_Ty", "p", "aperture", "damage", "stored", "rupture", "friction", "work", &
    "iterations", "position", "updates", "snaps", "before_N", "before_Tx", "before_Ty", "after_N", "after_Tx", &
    "after_Ty", "released", "D_N_N", "D_Tx_N", "D_Ty_N", "D_N_Tx", "D_Tx_Tx", "D_Ty_Tx", "D_N_Ty", "D_Tx_Ty", "D_Ty_Ty"]
  integer, parameter :: n_written = 17
  !> Columns that are whole numbers.
  integer, parameter :: integer_columns(5) = [1, 2, 17, 19, 20]

contains

  !> Numbers of a row, in the order of the table.
  pure function row_numbers(row, aperture) result(numbers)
    type(row_type), intent(in) :: row                !! the row
    type(aperture_type), intent(in) :: aperture      !! of the joint
    real(wp) :: numbers(size(row_columns))
    associate (report => row%report)
      numbers = [real([row%step, row%increment], wp), row%time, row%s, row%traction, row%p, &
        max(aperture%a_min, aperture%a_0 + row%s(1)), &
        row%state([v_damage, v_stored, v_rupture, v_friction]), row%work, real(report%iterations, wp), row%position, &
        real([report%updates, report%snaps], wp), report%before, report%after, report%released, &
        reshape(row%tangent, [size(row%tangent)])]
    end associate
  end function row_numbers

  !> Header of a file, without the columns of the state.
  pure subroutine csv_header(header, every, stability)
    character(len=:), allocatable, intent(out) :: header   !! names separated by commas
    logical, intent(in) :: every                           !! whether the file has all numbers of a row
    logical, intent(in) :: stability                       !! whether it has those of the stability
    integer :: i
    header = ""
    do i = 1, merge(size(row_columns), n_written, every)
      header = header // trim(row_columns(i)) // ","
    end do
    header = header // "event"
    do i = 1, merge(size(stability_columns), 0, stability)
      header = header // "," // trim(stability_columns(i))
    end do
  end subroutine csv_header

  !> Line of a row: numbers, events, and the numbers of the state from one of them on.
  pure subroutine csv_line(row, aperture, every, stiffness, first, line)
    type(row_type), intent(in) :: row                    !! the row
    type(aperture_type), intent(in) :: aperture          !! of the joint
    logical, intent(in) :: every                         !! whether the file has all its numbers
    real(wp), intent(in) :: stiffness                    !! of the bond, for the stability, stress/length; 0: left out
    integer, intent(in) :: first                         !! first number of the state that has a column
    character(len=:), allocatable, intent(out) :: line   !! fields separated by commas
    integer, parameter :: widest = size(row_columns) + size(stability_columns)
    real(wp) :: numbers(size(row_columns))
    integer :: i, n
    allocate (character(len=(most_digits + 1)*(widest + size(row%state)) + len(row%events)) :: line)
    n = 0
    numbers = row_numbers(row, aperture)
    do i = 1, merge(size(row_columns), n_written, every)
      if (any(integer_columns == i)) then
        call add_text(line, n, integer_text(nint(numbers(i))) // ",")
      else
        call add_numbers(line, n, numbers(i:i))
      end if
    end do
    call add_text(line, n, trim(row%events) // ",")
    if (stiffness > 0.0_wp) call add_numbers(line, n, stability_of(row%tangent, stiffness))
    call add_numbers(line, n, row%state(first:))
    line = line(:n - 1)
  end subroutine csv_line

  !> Add numbers, each with a comma behind it.
  pure subroutine add_numbers(line, n, values)
    character(len=:), allocatable, intent(inout) :: line   !! fields, and room for more
    integer, intent(inout) :: n                            !! its characters so far
    real(wp), intent(in) :: values(:)                      !! any bits
    character(len=most_digits) :: text
    integer :: i, length
    do i = 1, size(values)
      call put_digits(values(i), text, length)
      call add_text(line, n, text(:length) // ",")
    end do
  end subroutine add_numbers

  !> Add a text.
  pure subroutine add_text(line, n, text)
    character(len=:), allocatable, intent(inout) :: line   !! fields, and room for more
    integer, intent(inout) :: n                            !! its characters so far
    character(len=*), intent(in) :: text                   !! what comes next
    line(n + 1:n + len(text)) = text
    n = n + len(text)
  end subroutine add_text

end module asperity_rows
