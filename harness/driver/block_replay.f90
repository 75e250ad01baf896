!> Replay of recorded strains through `vumat`, called as Abaqus/Explicit calls it.
!>
!> All points of a block follow the record. Point i is delayed by mod(i - 1, stagger) increments, so that a block has
!> virgin and damaged points; point 1 gives the rows. A delayed point is compared with point 1 as many increments ago.
!> With viscous damage or an initial traction their results may differ, because the time increments are not the same and
!> a waiting point may slide by a rounding error. In these cases points of equal delay are compared.
!>
!> The first call is the packager's probe at totalTime = 0. After an increment the new arrays are copied to the old
!> ones. Before a call, outputs and arguments that a host does not define have the value `garbage`.
module block_replay
  use asperity_checks, only: bounded
  use asperity_host, only: vumat_map
  use asperity_text, only: integer_text
  use asperity_contract, only: v_friction, v_offset, v_rupture
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_load_path, only: row_type
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_control_point, only: work_between
  use asperity_case_start, only: initial_type
  use history, only: add_replayed_row, history_type
  use host_routines, only: vumat
  use progress_line, only: progress_type, show_progress
  use recorded_strains, only: strains_type
  implicit none
  private
  public :: run_block_replay

  !> Number of different delays of the points: 0 to stagger - 1 increments, repeated over the block.
  integer, parameter :: stagger = 8
  !> Value of outputs before a call, and of arguments that a host does not define.
  real(wp), parameter :: garbage = -7.7e77_wp
  !> Mass density of the host; a power of two, so that energies per mass differ by an exact factor.
  real(wp), parameter :: density = 0.5_wp**28
  !> Strain of the packager's probe.
  real(wp), parameter :: probe = 1.0e-3_wp

contains

  !> Replay a record. Each of its increments gives a row, whose `iterations` are the calls of vumat; in 2D s_Ty and t_Ty
  !> are 0.
  subroutine run_block_replay(joint, props, ntens, n_points, initial, record, label, table, progress, failure)
    type(interface_type), intent(in) :: joint                !! the interface
    real(wp), intent(in) :: props(:)                         !! PROPS
    integer, intent(in) :: ntens                             !! components of the host, 2 or 3
    integer, intent(in) :: n_points                          !! points of the block
    type(initial_type), intent(in) :: initial                !! planes and traction before the first call
    type(strains_type), intent(in) :: record                 !! strains in the VUMAT's order, tensor shears
    character(len=*), intent(in) :: label                    !! name of the run, for the progress line
    type(history_type), intent(inout) :: table               !! rows are added
    type(progress_type), intent(inout) :: progress           !! clock
    character(len=:), allocatable, intent(out) :: failure    !! not empty: error of vumat
    type(row_type) :: row
    type(rie_law) :: law
    character(len=80), parameter :: name = "ASPERITY"
    real(wp), dimension(n_points, ntens) :: strain, stress_old, stress
    real(wp), dimension(n_points, joint%n_statev) :: state_old, state
    real(wp), dimension(n_points) :: intern_old, intern, inelas_old, inelas, unset_point, rho
    real(wp) :: unset(n_points, 9), earlier(0:stagger - 1, ntens), dtime, largest, offset(3), start
    integer :: delay, i, n, position(3)
    logical :: viscous

    failure = ""
    law = new_rie_law(joint)
    viscous = joint%material%tau_v > 0.0_wp
    position = vumat_map(1, ntens - 1)
    rho = density
    unset = garbage
    unset_point = garbage
    stress_old = 0.0_wp
    state_old = 0.0_wp
    intern_old = 0.0_wp
    inelas_old = 0.0_wp
    strain = probe
    dtime = probe
    call call_vumat(0.0_wp)
    if (.not. all(bounded(stress, huge(1.0_wp))) .or. any(stress(:, 1) <= 0.0_wp)) then
      failure = "vumat: the packager's probe has no elastic stress"
    else if (any(abs(state) > 0.0_wp) .or. any(abs(intern) > 0.0_wp) .or. any(abs(inelas) > 0.0_wp)) then
      failure = "vumat: the packager's probe changed the state"
    end if
    if (len(failure) > 0) return

    ! initial conditions in the form in which a host passes them
    do i = 1, 3
      if (position(i) > 0) stress_old(:, position(i)) = initial%traction(i)
    end do
    state_old = spread(initial%planes, 1, n_points)
    offset = initial%carried(v_offset:v_offset + 2)
    row%step = 1
    row%report%iterations = 1
    earlier = 0.0_wp
    largest = 0.0_wp
    start = table%last%work
    do n = 1, size(record%time)
      do i = 1, n_points
        strain(i, :) = increment(record, n - mod(i - 1, stagger))
      end do
      dtime = record%time(n) - row%time
      call call_vumat(max(record%time(n), tiny(1.0_wp)))   ! only the probe has totalTime = 0
      if (.not. all(bounded(stress, huge(1.0_wp)))) then
        failure = "vumat rejected increment " // integer_text(n)
        return
      end if
      earlier(mod(n, stagger), :) = stress(1, :)
      do i = 1, n_points
        delay = mod(i - 1, stagger)
        if (n <= delay) cycle
        if (viscous .or. initial%given) then
          if (any(abs(stress(i, :) - stress(delay + 1, :)) > 0.0_wp)) failure = "points " // &
            integer_text(delay + 1) // " and " // integer_text(i) // " of the same delay differ"
        else if (any(abs(stress(i, :) - earlier(mod(n - delay, stagger), :)) > 0.0_wp)) then
          failure = "point " // integer_text(i) // " differs from point 1 " // integer_text(delay) // &
            " increments before"
        end if
      end do
      row%s = state(1, v_offset:v_offset + 2) - offset
      do i = 1, 3
        if (position(i) > 0) row%traction(i) = stress(1, position(i))
      end do
      row%work = table%last%work + work_between(table%last%s, table%last%traction, row%s, row%traction)
      ! tolerance of the work: rounding errors of the separations, which are sums of increments
      largest = max(largest, maxval(abs(state(1, v_offset:v_offset + 2)))*sum(abs(row%traction)))
      associate (mass => density*joint%h, ledger => state(1, v_rupture) + state(1, v_friction), &
                 rounding => 4.0_wp*real(n, wp)*epsilon(1.0_wp))
        if (abs(mass*inelas(1) - ledger) > rounding*ledger) failure = "enerInelasNew is not rupture and friction"
        if (abs(mass*intern(1) - (row%work - start)) > rounding*largest) failure = "enerInternNew is not the work"
      end associate
      if (len(failure) > 0) then
        failure = "vumat, increment " // integer_text(n) // ": " // failure
        return
      end if

      stress_old = stress
      state_old = state
      intern_old = intern
      inelas_old = inelas
      row%increment = n
      row%time = record%time(n)
      row%state = state(1, :)
      row%state(v_offset:v_offset + 2) = offset   ! a VUMAT adds its strains to the offset
      call add_replayed_row(table, law, row)
      if (.not. table%good) return
      call show_progress(progress, label, n, size(record%time))
    end do

  contains

    !> Call vumat once, after setting the outputs to `garbage`.
    subroutine call_vumat(total_time)
      real(wp), intent(in) :: total_time   !! totalTime
      stress = garbage
      state = garbage
      intern = garbage
      inelas = garbage
      call vumat(n_points, 1, ntens - 1, joint%n_statev, 0, size(props), 0, total_time, total_time, dtime, name, &
        unset, unset_point, props, rho, strain, unset, unset_point, unset, unset, unset, stress_old, state_old, &
        intern_old, inelas_old, unset_point, unset, unset, unset, stress, state, intern, inelas)
    end subroutine call_vumat

  end subroutine run_block_replay

  !> Strain increment n of a record; it is zero for n < 1.
  pure function increment(record, n) result(strain)
    type(strains_type), intent(in) :: record      !! strains
    integer, intent(in) :: n                      !! up to the number of records
    real(wp) :: strain(size(record%strain, 1))
    strain = 0.0_wp
    if (n > 0) strain = record%strain(:, n)
    if (n > 1) strain = strain - record%strain(:, n - 1)
  end function increment

end module block_replay
