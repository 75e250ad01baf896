!> Replay of recorded strains through `umat`, called as an FE code calls it.
!>
!> Every increment has four calls: a zero strain increment (as in a first iteration that needs the tangent), a larger
!> trial increment, the increment itself, and the same increment again (as if stress and tangent were computed
!> separately). STATEV and STRESS are committed only at the end of the increment. Arguments that the host does not
!> define have the value `garbage`. An initial state is passed as initial conditions of a host: planes in STATEV, status
!> 0, traction in STRESS.
!>
!> The strains are in a CSV file. A header line names the columns: `e_1` ... `e_<ntens>` (strains in the host's order)
!> or `s_N`, `s_Tx`, `s_Ty` (separations, as in an output file of the driver), and optionally `time`; other columns are
!> ignored. A file without a header has the NTENS strains only. Time must not decrease. Blank lines and lines that start
!> with # are skipped.
module replay
  use asperity_case, only: case_type
  use asperity_checks, only: bounded
  use asperity_contract, only: v_friction, v_rupture, v_stored
  use asperity_equations, only: work_between
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_host, only: component_map
  use asperity_interface, only: separation_bound
  use asperity_kinds, only: wp
  use asperity_load_path, only: name_events, row_type
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_text, only: integer_text, set_text, to_text
  use asperity_text_file, only: last_before, load_file, longest_field, lower, newline, printable, split, to_real
  use history, only: add_row, history_type
  use host_routines, only: umat
  use progress_line, only: progress_type, show_progress
  implicit none
  private
  public :: read_replayed, run_replay

  !> Largest number of messages about one kind of error; the number of further ones is reported.
  integer, parameter :: most_lines = 20

  !> Calls of an increment: their fractions of the strain increment.
  real(wp), parameter :: fractions(4) = [0.0_wp, 1.5_wp, 1.0_wp, 1.0_wp]
  !> Value of arguments that a host does not define.
  real(wp), parameter :: garbage = -7.7e77_wp
  !> Relative rounding error of a division by h and a multiplication.
  real(wp), parameter :: rounding = 4.0_wp*epsilon(1.0_wp)

contains

  !> Read the record that a case replays.
  subroutine read_replayed(case, errors)
    type(case_type), intent(inout) :: case       !! the case; strains and times of its record are set
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=:), allocatable :: source
    character(len=longest_field), allocatable :: list(:)
    type(error_type) :: place
    integer, allocatable :: column(:)
    real(wp), allocatable :: numbers(:)
    real(wp) :: bound, now, unit
    integer :: bad, earlier, first, i, last, n, ntens, position(3)
    logical :: good, named

    earlier = errors%n
    place%file = case%replay%file
    call set_text(source, "")
    call load_file(case%replay%file, source, errors)
    if (errors%n > earlier) return
    ntens = case%replay%ntens
    position = component_map(ntens, case%joint%map)
    n = count([(source(i:i) == newline, i=1, len(source))]) + 1
    allocate (case%replay%strain(ntens, n), case%replay%time(n))
    bound = 0.25_wp*separation_bound(case%joint)/case%joint%h
    named = .false.
    unit = 1.0_wp
    bad = 0
    n = 0
    now = 0.0_wp
    place%line = 0
    first = 1
    do while (first <= len(source))
      last = last_before(newline, source, first)
      call split(source(first:last), list)
      first = last + 2
      place%line = place%line + 1
      if (list(1)(1:1) == "#" .or. size(list) == 1 .and. len_trim(list(1)) == 0) cycle
      if (.not. allocated(column)) then
        named = scan(lower(list(1)(1:1)), "abcdefghijklmnopqrstuvwxyz""'") == 1 .and. &
          all(lower(list(1)) /= ["nan     ", "inf     ", "infinity"])
        ! those of the strains, of time, and of an s_Ty that the host does not have; 0: none
        column = [(i, i=1, ntens), 0, 0]
        if (named) call find_columns()
        if (errors%n > earlier) return
        if (named) cycle
      end if
      good = .true.
      numbers = spread(0.0_wp, 1, size(column))
      ! a field that the line does not have is no number
      list = [list, spread(repeat(" ", longest_field), 1, max(0, maxval(column) - size(list)))]
      do i = 1, size(column)
        if (column(i) == 0 .or. .not. good) cycle
        call to_real(trim(list(column(i))), numbers(i), good)
        if (.not. good) call refuse("column " // integer_text(column(i)) // " = """ // &
          printable(trim(list(column(i)))) // """: expected a number")
      end do
      if (.not. named .and. size(list) > ntens) call refuse(integer_text(size(list)) // " columns: expected " // &
        integer_text(ntens) // " (ntens), or a header")
      if (good) then
        n = n + 1
        case%replay%time(n) = merge(numbers(ntens + 1), real(n, wp)*case%replay%dtime, column(ntens + 1) > 0)
        if (.not. case%replay%time(n) >= now) call refuse("time = " // to_text(case%replay%time(n)) // &
          ": expected at least " // to_text(now) // ", the time before (0 at the start)")
        now = max(now, case%replay%time(n))
        if (abs(numbers(ntens + 2)) > 0.0_wp) call refuse("s_Ty = " // to_text(numbers(ntens + 2)) // &
          ": expected 0 with ntens = 2")
        case%replay%strain(:, n) = numbers(:ntens)/unit
        if (.not. all(bounded(case%replay%strain(:, n), bound))) call refuse( &
          "expected strains of a magnitude up to " // to_text(bound))
      end if
      if (.not. good) bad = bad + 1
    end do
    place%line = -1
    if (bad > most_lines) call fail(errors, place, "... and " // integer_text(bad - most_lines) // " more bad lines")
    if (n == 0 .and. errors%n == earlier) call fail(errors, place, "no line of numbers")
    case%replay%strain = case%replay%strain(:, :n)
    case%replay%time = case%replay%time(:n)

  contains

    !> Add an error about a line, unless there are too many bad lines.
    subroutine refuse(text)
      character(len=*), intent(in) :: text   !! what is wrong
      if (bad < most_lines) call fail(errors, place, text)
      good = .false.
    end subroutine refuse

    !> Numbers of the columns from the header.
    subroutine find_columns()
      character(len=4), parameter :: names(3) = ["s_N ", "s_Tx", "s_Ty"]
      integer :: k
      do k = 1, size(list)
        list(k) = lower(list(k))
      end do
      column = 0
      column(ntens + 1) = findloc(list, "time", dim=1)
      if (any(list == "s_n")) then
        unit = case%joint%h
        do k = 1, 3
          call find_column(merge(position(k), ntens + 2, position(k) > 0), names(k))
        end do
      else
        do k = 1, ntens
          call find_column(k, "e_" // integer_text(k))
        end do
      end if
    end subroutine find_columns

    !> The number of a column that must be there.
    subroutine find_column(i, name)
      integer, intent(in) :: i               !! what it has
      character(len=*), intent(in) :: name   !! its name
      column(i) = findloc(list, lower(name), dim=1)
      if (column(i) == 0) call fail(errors, place, "no column " // trim(name) // &
        ": expected s_N, s_Tx, s_Ty or e_1 to e_" // integer_text(ntens))
    end subroutine find_column

  end subroutine read_replayed

  !> Replay a record. Each of its increments gives a row, whose `iterations` are the calls of umat. Components that the
  !> host does not have are 0, also t_Ty with NTENS = 2.
  subroutine run_replay(case, label, table, progress, failure)
    type(case_type), intent(in) :: case                      !! the case, with its record
    character(len=*), intent(in) :: label                    !! name of the run, for the progress line
    type(history_type), intent(inout) :: table               !! rows are added
    type(progress_type), intent(inout) :: progress           !! clock
    character(len=:), allocatable, intent(out) :: failure    !! not empty: error of umat
    type(row_type) :: row
    type(rie_law) :: law
    character(len=80), parameter :: name = "ASPERITY"
    real(wp), dimension(case%replay%ntens) :: stran, dstran, stress, first_stress, committed_stress
    real(wp), dimension(case%joint%n_umat_statev) :: statev, committed
    real(wp) :: ddsdde(case%replay%ntens, case%replay%ntens), thermal(2*case%replay%ntens + 2), energies(3), &
      in_state(3), unset(9), pnewdt, dtime
    integer :: call_number, i, n, ntens, position(3)

    failure = ""
    law = new_rie_law(case%joint)
    ntens = case%replay%ntens
    position = component_map(ntens, case%joint%map)
    stran = 0.0_wp
    committed_stress = 0.0_wp
    do i = 1, 3
      if (position(i) > 0) committed_stress(position(i)) = case%initial%traction(i)
    end do
    committed = 0.0_wp
    committed(:case%joint%n_statev) = case%initial%planes
    unset = garbage
    row%step = 1
    row%report%iterations = size(fractions)
    do n = 1, size(case%replay%time)
      dstran = case%replay%strain(:, n) - stran
      dtime = case%replay%time(n) - row%time
      stress = committed_stress
      do call_number = 1, size(fractions)
        first_stress = stress
        stress = committed_stress
        statev = committed
        ddsdde = garbage
        energies = garbage
        thermal = garbage
        pnewdt = 1.0_wp
        call umat(stress, statev, ddsdde, energies(1), energies(2), energies(3), thermal(1), thermal(2:ntens + 1), &
          thermal(ntens + 2:2*ntens + 1), thermal(2*ntens + 2), stran, fractions(call_number)*dstran, &
          [row%time, row%time], dtime, unset(1), unset(1), unset, unset, name, 1, ntens - 1, ntens, size(statev), &
          case%props, size(case%props), unset, unset, pnewdt, unset(1), unset, unset, 1, 1, 1, 1, 1, n)
        if (.not. all(bounded(stress, huge(1.0_wp)))) then
          failure = "umat rejected call " // integer_text(call_number) // " of increment " // integer_text(n)
          return
        end if
      end do
      if (any(abs(stress - first_stress) > 0.0_wp)) failure = "two equal calls of umat differ"
      in_state = statev([v_stored, v_friction, v_rupture])
      ! the energy of crushing is the last state variable
      if (case%joint%cap%peak > 0.0_wp) in_state(2) = in_state(2) + statev(case%joint%n_umat_statev)
      if (any(abs(energies*case%joint%h - in_state) > rounding*abs(in_state))) then
        failure = "SSE, SPD, SCD are not the energies of STATEV"
      end if
      if (any(abs(ddsdde - garbage) <= 0.0_wp)) failure = "DDSDDE is not defined"
      if (len(failure) > 0) then
        failure = "umat, increment " // integer_text(n) // ": " // failure
        return
      end if

      stran = stran + dstran
      committed = statev
      committed_stress = stress
      row%increment = n
      row%time = case%replay%time(n)
      do i = 1, 3
        if (position(i) == 0) cycle
        row%s(i) = case%joint%h*stran(position(i))
        row%traction(i) = stress(position(i))
      end do
      row%state = statev(:case%joint%n_statev)
      row%work = table%last%work + work_between(table%last%s, table%last%traction, row%s, row%traction)
      row%report%cut = pnewdt < 1.0_wp
      call name_events(law, table%last%state, row%state, table%regime, row)
      call add_row(table, row)
      call show_progress(progress, label, n, size(case%replay%time))
    end do
  end subroutine run_replay

end module replay
