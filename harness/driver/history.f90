!> CSV file of a run, with one row per increment that is written at once, and the totals of the run: the columns of the
!> module `asperity_rows` and, on request, those of the state (docs/reference/driver.md).
module history
  use asperity_kinds, only: wp
  use asperity_equations, only: point_type
  use asperity_load_path, only: row_type, set_point
  use asperity_point_law, only: event_length, point_law
  use asperity_rows, only: aperture_type, csv_header, csv_line
  use driver_output, only: create_file, write_line
  implicit none
  private
  public :: open_history, start_from, add_row

  !> The file, its last row and totals over its rows.
  type, public :: history_type
    type(row_type) :: last                 !! the last row
    integer :: n_rows = 0
    integer :: iterations = 0              !! of all rows
    integer :: most_iterations = 0         !! of one row
    integer :: updates = 0                 !! of the law, of all rows; 0: not counted
    integer :: snaps = 0                   !! of all rows
    real(wp) :: released = 0.0_wp          !! energy released by them, stress*length
    real(wp) :: least_traction = 0.0_wp    !! smallest t_N that the law carries
    real(wp) :: largest_slip = 0.0_wp      !! largest norm of (s_Tx, s_Ty)
    type(aperture_type), private :: aperture = aperture_type()   !! of the joint
    logical, private :: every = .false.    !! whether all numbers of a row have columns
    real(wp), private :: stiffness = 0.0_wp   !! of the bond, for columns of the stability; 0: none
    integer, private :: first = huge(1)    !! first number of the state that has a column
    logical, allocatable :: regime(:, :)   !! of the law at the last row of a replay
  end type history_type

contains

  !> Open the file ("-": standard output) and write the header.
  subroutine open_history(table, path, law, aperture, planes, every, stability)
    type(history_type), intent(out) :: table        !! the file, without rows
    character(len=*), intent(in) :: path            !! file, replaced if it exists
    class(point_law), intent(in) :: law             !! the law
    type(aperture_type), intent(in) :: aperture     !! of the joint
    logical, intent(in) :: planes                   !! whether planes, or the numbers of a UMAT, have columns
    logical, intent(in) :: every                    !! whether all numbers of a row have columns
    logical, intent(in) :: stability                !! whether the eigenvalues of the tangent have columns
    character(len=:), allocatable :: header
    integer :: i

    allocate (table%last%state(law%n_state), source=0.0_wp)
    call create_file(path)
    call csv_header(header, every, stability)
    if (stability) table%stiffness = law%stiffness
    table%every = every
    table%aperture = aperture
    if (planes) table%first = law%first_own
    do i = table%first, law%n_state
      header = header // "," // law%state_name(i)
    end do
    call write_line(header)
  end subroutine open_history

  !> Set the state from which work and events are counted, for a run that does not start from a virgin point.
  subroutine start_from(table, law, point, p)
    type(history_type), intent(inout) :: table      !! the file, no row yet
    class(point_law), intent(in) :: law             !! the law
    type(point_type), intent(in) :: point           !! start of the run
    real(wp), intent(in) :: p                       !! water pressure there, stress
    character(len=event_length) :: ignored
    call law%find_events(point%s, point%state, point%state, table%regime, ignored)
    call set_point(table%last, point, p)
  end subroutine start_from

  !> Write a row by one system call, so that a run that is ended leaves complete rows.
  subroutine add_row(table, row)
    type(history_type), intent(inout) :: table      !! the file
    type(row_type), intent(in) :: row               !! the row
    character(len=:), allocatable :: line
    call csv_line(row, table%aperture, table%every, table%stiffness, table%first, line)
    call write_line(line)
    table%last = row
    table%n_rows = table%n_rows + 1
    table%iterations = table%iterations + row%report%iterations
    table%updates = table%updates + row%report%updates
    table%snaps = table%snaps + row%report%snaps
    table%released = table%released + row%report%released
    table%most_iterations = max(table%most_iterations, row%report%iterations)
    table%least_traction = min(table%least_traction, row%traction(1) + row%p)
    table%largest_slip = max(table%largest_slip, norm2(row%s(2:)))
  end subroutine add_row

end module history
