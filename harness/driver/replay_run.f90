!> Replay of recorded strains through `umat`, called as an FE code calls it.
!>
!> Every increment has four calls: a zero strain increment (as in a first iteration that needs the tangent), a larger
!> trial increment, the increment itself, and the same increment again (as if stress and tangent were computed
!> separately). STATEV and STRESS are committed only at the end of the increment. Arguments that the host does not
!> define have the value `garbage`. An initial state is passed as initial conditions of a host: planes in STATEV, status
!> 0, traction in STRESS.
module replay_run
  use asperity_checks, only: bounded
  use asperity_host, only: component_map
  use asperity_text, only: integer_text
  use asperity_contract, only: v_friction, v_rupture, v_stored
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_load_path, only: row_type
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_control_point, only: work_between
  use asperity_case_start, only: initial_type
  use history, only: add_replayed_row, history_type
  use host_routines, only: umat
  use progress_line, only: progress_type, show_progress
  use recorded_strains, only: strains_type
  implicit none
  private
  public :: run_replay

  !> Calls of an increment: their fractions of the strain increment.
  real(wp), parameter :: shares(4) = [0.0_wp, 1.5_wp, 1.0_wp, 1.0_wp]
  !> Value of arguments that a host does not define.
  real(wp), parameter :: garbage = -7.7e77_wp
  !> Relative rounding error of a division by h and a multiplication.
  real(wp), parameter :: rounding = 4.0_wp*epsilon(1.0_wp)

contains

  !> Replay a record. Each of its increments gives a row, whose `iterations` are the calls of umat. Components that the
  !> host does not have are 0, also t_Ty with NTENS = 2.
  subroutine run_replay(joint, props, ntens, initial, record, label, table, progress, failure)
    type(interface_type), intent(in) :: joint                !! the interface
    real(wp), intent(in) :: props(:)                         !! PROPS
    integer, intent(in) :: ntens                             !! components of the host
    type(initial_type), intent(in) :: initial                !! planes and traction before the first call
    type(strains_type), intent(in) :: record                 !! strains
    character(len=*), intent(in) :: label                    !! name of the run, for the progress line
    type(history_type), intent(inout) :: table               !! rows are added
    type(progress_type), intent(inout) :: progress           !! clock
    character(len=:), allocatable, intent(out) :: failure    !! not empty: error of umat
    type(row_type) :: row
    type(rie_law) :: law
    character(len=80), parameter :: name = "ASPERITY"
    real(wp), dimension(ntens) :: stran, dstran, stress, first_stress, committed_stress
    real(wp) :: statev(joint%n_statev), committed(joint%n_statev), ddsdde(ntens, ntens), energies(3), &
      in_state(3), thermal(2*ntens + 2), unset(9), pnewdt, dtime
    integer :: call_number, i, n, position(3)

    failure = ""
    law = new_rie_law(joint)
    position = component_map(ntens, joint%map)
    stran = 0.0_wp
    committed_stress = 0.0_wp
    do i = 1, 3
      if (position(i) > 0) committed_stress(position(i)) = initial%traction(i)
    end do
    committed = initial%planes
    unset = garbage
    row%step = 1
    row%report%iterations = size(shares)
    do n = 1, size(record%time)
      dstran = record%strain(:, n) - stran
      dtime = record%time(n) - row%time
      stress = committed_stress
      do call_number = 1, size(shares)
        first_stress = stress
        stress = committed_stress
        statev = committed
        ddsdde = garbage
        energies = garbage
        thermal = garbage
        pnewdt = 1.0_wp
        call umat(stress, statev, ddsdde, energies(1), energies(2), energies(3), thermal(1), thermal(2:ntens + 1), &
          thermal(ntens + 2:2*ntens + 1), thermal(2*ntens + 2), stran, shares(call_number)*dstran, &
          [row%time, row%time], dtime, unset(1), unset(1), unset, unset, name, 1, ntens - 1, ntens, size(statev), &
          props, size(props), unset, unset, pnewdt, unset(1), unset, unset, 1, 1, 1, 1, 1, n)
        if (.not. all(bounded(stress, huge(1.0_wp)))) then
          failure = "umat rejected call " // integer_text(call_number) // " of increment " // integer_text(n)
          return
        end if
      end do
      if (any(abs(stress - first_stress) > 0.0_wp)) failure = "two equal calls of umat differ"
      in_state = statev([v_stored, v_friction, v_rupture])
      if (any(abs(energies*joint%h - in_state) > rounding*abs(in_state))) then
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
      row%time = record%time(n)
      do i = 1, 3
        if (position(i) == 0) cycle
        row%s(i) = joint%h*stran(position(i))
        row%traction(i) = stress(position(i))
      end do
      row%state = statev
      row%work = table%last%work + work_between(table%last%s, table%last%traction, row%s, row%traction)
      row%report%cut = pnewdt < 1.0_wp
      call add_replayed_row(table, law, row)
      if (.not. table%good) return
      call show_progress(progress, label, n, size(record%time))
    end do
  end subroutine run_replay

end module replay_run
