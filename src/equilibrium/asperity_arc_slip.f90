!> Confined slip test along the branch of equilibria, through its unstable part.
module asperity_arc_slip
  use asperity_arc, only: arc_step, arc_type, new_arc
  use asperity_control_point, only: control_type, new_point, point_type
  use asperity_increment, only: path_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, ended_complete, ended_lost, report_type
  use asperity_pattern, only: direction_vector
  use asperity_slip_test, only: joined, slip_test_type
  implicit none
  private
  public :: branch_slip

contains

  !> Follow the slip to its targets, one after the other; every step along the branch is a row. The normal traction is
  !> applied before in increments, as in `confined_slip`. Rows beyond the size of the arrays are counted, not stored.
  pure subroutine branch_slip(joint, test, targets, longest, separation, traction, state, work, reports, turned, &
                              n_rows, n_done, ended)
    type(interface_type), intent(in) :: joint           !! the interface
    type(slip_test_type), intent(in) :: test            !! the test; times and method are not used
    real(wp), intent(in) :: targets(:)                  !! (T) slips that are reached in their order, length
    real(wp), intent(in) :: longest                     !! longest step over s0
    real(wp), intent(out) :: separation(:, :)           !! (3, room) separation (N, Tx, Ty), length
    real(wp), intent(out) :: traction(:, :)             !! (3, room) traction (N, Tx, Ty), stress
    real(wp), intent(out) :: state(:, :)                !! (nstatv, room) STATEV
    real(wp), intent(out) :: work(:)                    !! (room) of the traction on the separation, stress*length
    type(report_type), intent(inout) :: reports(0:)     !! (0:room) of the preload and of the rows
    logical, intent(out) :: turned(:)                   !! (room) whether the slip turns back, or forward again
    integer, intent(out) :: n_rows                      !! number of rows
    integer, intent(out) :: n_done                      !! targets reached, fewer than T: the branch ended; -1:
                                                        !! equilibrium was lost in the preload
    integer, intent(out) :: ended                       !! end of the last step, of report_type
    type(arc_type) :: arc
    type(control_type) :: control
    type(path_type) :: path
    type(point_type) :: point
    type(report_type) :: report
    real(wp) :: given(3), reached, start(3)
    integer :: i, used

    separation = 0.0_wp
    traction = 0.0_wp
    state = 0.0_wp
    work = 0.0_wp
    turned = .false.
    n_rows = 0
    n_done = -1
    ended = ended_lost
    control%traction(1) = .true.
    point = new_point(joint)
    given = 0.0_wp
    do i = 1, test%preload
      start = given
      given(1) = test%sigma_n*(real(i, wp)/real(test%preload, wp))
      call advance(joint, control, start, given, point, used, reached, report=report)
      reports(0) = joined(reports(0), report)
      if (reached < 1.0_wp) return
    end do
    ended = ended_complete
    control%spring(1) = test%stiffness
    ! the force of the spring is zero at the start of the slip
    given(1) = given(1) + control%spring(1)*point%s(1)
    do i = 1, size(targets)
      n_done = i - 1
      start = given
      given(2:3) = targets(i)*direction_vector(test%direction)
      path = path_type(control, start, given, given - start)
      arc = new_arc(joint, longest)
      do while (arc%factor < 1.0_wp)
        call arc_step(joint, path, arc, point, report)
        ended = report%ended
        if (ended /= ended_complete) return
        n_rows = n_rows + 1
        if (n_rows > size(work)) cycle
        separation(:, n_rows) = point%s
        traction(:, n_rows) = point%traction
        state(:joint%n_statev, n_rows) = point%state
        work(n_rows) = point%work
        reports(n_rows) = report
        turned(n_rows) = arc%turned
      end do
    end do
    n_done = size(targets)
  end subroutine branch_slip

end module asperity_arc_slip
