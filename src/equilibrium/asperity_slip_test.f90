!> Confined slip test: the normal traction is applied to a virgin point at zero slip. Then the point follows prescribed
!> slips along a direction in the Tx-Ty plane under constant normal traction (or stiffness); the slip across is zero.
module asperity_slip_test
  use asperity_adaptive, only: adaptive_step, walk_type
  use asperity_checks, only: bounded
  use asperity_control_point, only: control_type, new_point, point_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, full_solver, report_type
  use asperity_pattern, only: direction_vector
  implicit none
  private
  public :: confined_slip, adaptive_slip, joined

  !> Definition of a test without its slips.
  type, public :: slip_test_type
    real(wp) :: direction = 0.0_wp      !! of the slip, from Tx towards Ty, degrees
    real(wp) :: sigma_n = 0.0_wp        !! normal traction, stress
    integer :: preload = 1              !! increments of sigma_n, >= 1 (100 for energies to four digits)
    real(wp) :: preload_time = 0.0_wp   !! duration of the preload, >= 0 (viscous damage only), time
    real(wp) :: stiffness = 0.0_wp      !! normal stiffness of the surroundings (CNS), >= 0, stress/length: after the
                                        !! preload the normal traction changes by -stiffness times the change of s_N
    integer :: method = full_solver     !! of `advance`
  end type slip_test_type

contains

  !> Follow the slips in one increment each; if equilibrium is lost, the test ends, and later rows are zero.
  pure subroutine confined_slip(joint, test, slips, separation, traction, state, n_done, reports, times, &
    work)
    type(interface_type), intent(in) :: joint       !! the interface
    type(slip_test_type), intent(in) :: test        !! the test
    real(wp), intent(in) :: slips(:)                !! (T) slips in their order, length
    real(wp), intent(out) :: separation(:, :)       !! (3, T) separation (N, Tx, Ty), length
    real(wp), intent(out) :: traction(:, :)         !! (3, T) traction (N, Tx, Ty), stress
    real(wp), intent(out) :: state(:, :)            !! (nstatv, T) STATEV
    integer, intent(out) :: n_done                  !! slips that converged; fewer than T: equilibrium lost;
                                                    !! -1: lost in the preload, or direction not finite
    type(report_type), intent(out), optional :: reports(0:)   !! (0:T) reports of the increments; 0: preload
    real(wp), intent(in), optional :: times(:)      !! (T) of the slips from the end of the preload on, not decreasing,
                                                    !! time; absent: no time passes
    real(wp), intent(out), optional :: work(:)      !! (T) of the traction on the separation, the preload included,
                                                    !! stress*length
    type(control_type) :: control
    type(report_type) :: report
    type(point_type) :: point
    real(wp) :: e(2), start(3), target(3), now, reached
    integer :: i, used

    separation = 0.0_wp
    traction = 0.0_wp
    state = 0.0_wp
    if (present(work)) work = 0.0_wp
    n_done = -1
    if (.not. bounded(test%direction, huge(1.0_wp))) return
    control%traction(1) = .true.
    control%dt = test%preload_time/real(test%preload, wp)
    point = new_point(joint)
    target = 0.0_wp
    do i = 1, test%preload
      start = target
      target(1) = test%sigma_n*(real(i, wp)/real(test%preload, wp))
      call advance(joint, control, start, target, point, used, reached, report=report, method=test%method)
      if (present(reports)) reports(0) = joined(reports(0), report)
      if (reached < 1.0_wp) return
    end do
    n_done = 0
    control%spring(1) = test%stiffness
    ! the force of the spring is zero at the start of the slip
    target(1) = target(1) + control%spring(1)*point%s(1)
    control%dt = 0.0_wp
    now = 0.0_wp
    e = direction_vector(test%direction)
    do i = 1, size(slips)
      if (present(times)) then
        control%dt = times(i) - now
        now = times(i)
      end if
      start = target
      target(2:3) = slips(i)*e
      call advance(joint, control, start, target, point, used, reached, report=report, method=test%method)
      if (present(reports)) reports(i) = report
      if (reached < 1.0_wp) return
      separation(:, i) = point%s
      traction(:, i) = point%traction
      state(:joint%n_statev, i) = point%state
      if (present(work)) work(i) = point%work
      n_done = i
    end do
  end subroutine confined_slip

  !> Combine the reports of two increments.
  pure function joined(first, second) result(both)
    type(report_type), intent(in) :: first, second   !! in their order
    type(report_type) :: both
    both = second
    both%iterations = first%iterations + second%iterations
    both%updates = first%updates + second%updates
    both%parts = first%parts + second%parts
    both%snaps = first%snaps + second%snaps
    both%released = first%released + second%released
    if (maxval(abs(first%after - first%before)) > maxval(abs(second%after - second%before))) then
      both%before = first%before
      both%after = first%after
    end if
  end function joined

  !> Follow the slip from reversal to reversal by adaptive increments, after an adaptive preload. Stiffness and method
  !> of the test are not used.
  !>
  !> Every step gives two rows, its middle and its end. Every reversal has a row.
  pure subroutine adaptive_slip(joint, test, turns, walk, separation, traction, state, work, n_rows, n_turns, times)
    type(interface_type), intent(in) :: joint       !! the interface
    type(slip_test_type), intent(in) :: test        !! the test
    real(wp), intent(in) :: turns(:)                !! (T) slips at the reversals, length
    type(walk_type), intent(inout) :: walk          !! new step control with a tolerance -> its counts
    real(wp), intent(out) :: separation(:, :)       !! (3, room) separation (N, Tx, Ty), length
    real(wp), intent(out) :: traction(:, :)         !! (3, room) traction (N, Tx, Ty), stress
    real(wp), intent(out) :: state(:, :)            !! (nstatv, room) STATEV
    real(wp), intent(out) :: work(:)                !! (room) of the traction on the separation, stress*length
    integer, intent(out) :: n_rows                  !! rows; those beyond `room` are counted, not stored
    integer, intent(out) :: n_turns                 !! reversals reached, fewer than T: equilibrium lost; -1: lost in
                                                    !! the preload
    real(wp), intent(in), optional :: times(:)      !! (T) of the reversals from the end of the preload on, not
                                                    !! decreasing, time; absent: no time passes
    type(control_type) :: control
    type(point_type) :: middle, point
    type(report_type) :: reports(2)
    real(wp) :: at, at_middle, now, start(3), target(3), reached
    integer :: i, iterations(2)

    separation = 0.0_wp
    traction = 0.0_wp
    state = 0.0_wp
    work = 0.0_wp
    n_rows = 0
    n_turns = -1
    control%traction(1) = .true.
    point = new_point(joint)
    target = 0.0_wp
    now = 0.0_wp
    i = 0
    do while (i <= size(turns))
      start = target
      if (i == 0) then
        target(1) = test%sigma_n
        control%dt = test%preload_time
      else
        control%dt = 0.0_wp
        if (present(times)) then
          control%dt = times(i) - now
          now = times(i)
        end if
        target(2:3) = turns(i)*direction_vector(test%direction)
      end if
      at = 0.0_wp
      do while (at < 1.0_wp)
        call adaptive_step(joint, control, start, target, walk, at, point, at_middle, middle, iterations, reached, &
          reports)
        if (i > 0 .and. .not. reached < 1.0_wp) call keep(middle, n_rows, separation, traction, state, work)
        if (reached < 1.0_wp) return
        if (i > 0) call keep(point, n_rows, separation, traction, state, work)
      end do
      n_turns = i
      i = i + 1
    end do
  end subroutine adaptive_slip

  !> Count a row, and store it if there is room.
  pure subroutine keep(row, n_rows, separation, traction, state, work)
    type(point_type), intent(in) :: row                !! the point
    integer, intent(inout) :: n_rows                   !! rows so far
    real(wp), intent(inout) :: separation(:, :)        !! (3, room) separation (N, Tx, Ty), length
    real(wp), intent(inout) :: traction(:, :)          !! (3, room) traction (N, Tx, Ty), stress
    real(wp), intent(inout) :: state(:, :)             !! (nstatv, room) STATEV
    real(wp), intent(inout) :: work(:)                 !! (room) of the traction on the separation, stress*length
    n_rows = n_rows + 1
    if (n_rows > size(separation, 2)) return
    separation(:, n_rows) = row%s
    traction(:, n_rows) = row%traction
    state(:size(row%state), n_rows) = row%state
    work(n_rows) = row%work
  end subroutine keep

end module asperity_slip_test
