!> Rows of a run, and the distance of values from the straight lines between them.
module adaptive_rows
  use asperity_contract, only: v_friction, v_rupture
  use asperity_control_point, only: balance_type, control_type, free_matrix, point_type, set_balance, traction_scale
  use asperity_elimination, only: eliminate
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_tolerances, only: residual_tolerance
  implicit none
  private
  public :: add_row, add_jump, line_errors, values_of, note_loose

  !> Values that are compared: tractions and separations along the lines; rupture, friction and work at the rows.
  integer, parameter, public :: n_values = 9
  !> Largest number of snaps that are noted of each run.
  integer, parameter :: most_jumps = 20

  !> Rows of a run.
  type, public :: rows_type
    integer :: n = 0
    real(wp), allocatable :: at(:)           !! place of the row: number of legs before + fraction of the leg
    real(wp), allocatable :: values(:, :)    !! (n_values, n)
    logical, allocatable :: loose(:)         !! whether no traction determines the free separations of the row
    integer :: n_jumps = 0
    real(wp) :: jumps(most_jumps) = -1.0_wp  !! places of snaps, and of a loss
  end type rows_type

contains

  !> Values of a point that are compared.
  pure function values_of(point) result(values)
    type(point_type), intent(in) :: point   !! the point
    real(wp) :: values(n_values)
    values = [point%traction, point%s, point%state(v_rupture), point%state(v_friction), point%work]
  end function values_of

  !> Note whether no traction determines the free separations of a point: a residual that the solver accepts moves them
  !> by more than the given length. Bonds of viscous damage that have nearly vanished have such a stiffness. Without any
  !> stiffness the separations stay where they are.
  pure subroutine note_loose(joint, control, point, length, loose)
    type(interface_type), intent(in) :: joint    !! the interface
    type(control_type), intent(in) :: control    !! what is given
    type(point_type), intent(in) :: point        !! the point
    real(wp), intent(in) :: length               !! length
    logical, intent(inout) :: loose              !! at the point before -> at this point
    type(balance_type) :: balance
    real(wp) :: matrix(3, 3), move(3), residual
    integer :: i
    logical :: solved, stiff
    call set_balance(joint, control, point%s, balance)
    residual = residual_tolerance*traction_scale(joint, point%s, point%state)
    stiff = .true.
    do i = 1, balance%n
      matrix = free_matrix(balance, point)
      move = 0.0_wp
      move(i) = residual
      call eliminate(balance%n, matrix, move, solved)
      if (.not. solved) return
      stiff = stiff .and. maxval(abs(move(:balance%n))) <= length
    end do
    loose = .not. stiff
  end subroutine note_loose

  !> Add a row.
  subroutine add_row(rows, at, point, loose)
    type(rows_type), intent(inout) :: rows       !! rows so far
    real(wp), intent(in) :: at                   !! place
    type(point_type), intent(in) :: point        !! the point
    logical, intent(in) :: loose                 !! whether no traction determines its free separations
    type(rows_type) :: longer
    integer, parameter :: first = 256
    if (.not. allocated(rows%at)) allocate (rows%at(first), rows%values(n_values, first), rows%loose(first))
    if (rows%n == size(rows%at)) then
      allocate (longer%at(2*rows%n), longer%values(n_values, 2*rows%n), longer%loose(2*rows%n))
      longer%at(:rows%n) = rows%at
      longer%values(:, :rows%n) = rows%values
      longer%loose(:rows%n) = rows%loose
      call move_alloc(longer%at, rows%at)
      call move_alloc(longer%values, rows%values)
      call move_alloc(longer%loose, rows%loose)
    end if
    rows%n = rows%n + 1
    rows%at(rows%n) = at
    rows%values(:, rows%n) = values_of(point)
    rows%loose(rows%n) = loose
  end subroutine add_row

  !> Note the place of a snap or of a loss.
  subroutine add_jump(at, rows)
    real(wp), intent(in) :: at                   !! place
    type(rows_type), intent(inout) :: rows       !! of the run
    rows%n_jumps = min(most_jumps, rows%n_jumps + 1)
    rows%jumps(rows%n_jumps) = at
  end subroutine add_jump

  !> Distances of values from the range of the lines between two places.
  subroutine line_errors(rows, from, to, values, row, errors, loose)
    type(rows_type), intent(in) :: rows        !! the rows
    real(wp), intent(in) :: from, to           !! places
    real(wp), intent(in) :: values(n_values)   !! values to compare
    integer, intent(inout) :: row              !! row before the last place that was asked for, 1 to n - 1
    real(wp), intent(out) :: errors(n_values)  !! distances
    logical, intent(out) :: loose              !! whether no traction determines the free separations there
    real(wp), dimension(n_values) :: ends, high, low
    integer :: k
    do while (row > 1 .and. rows%at(row) > from)
      row = row - 1
    end do
    do while (row < rows%n - 1 .and. rows%at(row + 1) <= from)
      row = row + 1
    end do
    low = line(rows, row, from)
    high = low
    do k = row + 1, rows%n - 1
      if (rows%at(k) >= to) exit
      low = min(low, rows%values(:, k))
      high = max(high, rows%values(:, k))
    end do
    ends = line(rows, k - 1, to)
    low = min(low, ends)
    high = max(high, ends)
    errors = max(low - values, values - high, 0.0_wp)
    loose = any(rows%loose(row:k))
  end subroutine line_errors

  !> Value of the line after a row at a place.
  pure function line(rows, row, at) result(values)
    type(rows_type), intent(in) :: rows   !! the rows
    integer, intent(in) :: row            !! 1 to n - 1
    real(wp), intent(in) :: at            !! place
    real(wp) :: values(n_values)
    real(wp) :: share
    share = (at - rows%at(row))/max(tiny(share), rows%at(row + 1) - rows%at(row))
    share = max(0.0_wp, min(1.0_wp, share))
    values = rows%values(:, row) + share*(rows%values(:, row + 1) - rows%values(:, row))
  end function line

end module adaptive_rows
