!> Confined slip test along the branch of equilibria, for f2py.
subroutine interface_branch_slip(nprops, props, nstatv, room, direction, n, slips, sigma_n, preload, stiffness, arc, &
                                 separation, traction, state, work, jumps, turned, n_rows, n_done, status, message)
  use asperity_arc, only: explain_end, explain_no_branch, largest_arc, least_arc
  use asperity_arc_slip, only: branch_slip
  use asperity_checks, only: bounded
  use asperity_contract, only: status_ok, status_separation
  use asperity_control_point, only: prescribed_bound
  use asperity_interface, only: interface_type, new_interface
  use asperity_mixed_control, only: ended_complete, report_type
  use asperity_slip_test, only: slip_test_type
  use asperity_text, only: append, integer_text, put_text, to_text
  implicit none
  integer, intent(in) :: nprops                            !! number of constants
  double precision, intent(in) :: props(nprops)            !! admissible PROPS
  integer, intent(in) :: nstatv                            !! state variables of a point
  integer, intent(in) :: room                              !! size of the arrays of rows
  double precision, intent(in) :: direction                !! from Tx towards Ty, finite, degrees
  integer, intent(in) :: n                                 !! slips
  double precision, intent(in) :: slips(n)                 !! that are reached in their order, length
  double precision, intent(in) :: sigma_n                  !! constant normal traction, finite, stress
  integer, intent(in) :: preload                           !! increments of the preload
  double precision, intent(in) :: stiffness                !! of the surroundings along N while it slips, stress/length
  double precision, intent(in) :: arc                      !! longest step over s0
  double precision, intent(inout) :: separation(3, room)   !! separation (N, Tx, Ty), length
  double precision, intent(inout) :: traction(3, room)     !! traction, stress
  double precision, intent(inout) :: state(nstatv, room)   !! STATEV
  double precision, intent(inout) :: work(room)            !! of the traction on the separation, stress*length
  double precision, intent(inout) :: jumps(9, 0:room)      !! of the preload and every row, as interface_confined_slip
  integer, intent(inout) :: turned(room)                   !! not 0: the slip turns back, or forward again
  integer, intent(out) :: n_rows                           !! rows; beyond the room they are counted, not kept
  integer, intent(out) :: n_done                           !! slips reached; fewer than n: the branch ended
  integer, intent(out) :: status                           !! 0 or status_separation
  character(len=32768), intent(out) :: message             !! every bad value, or why the branch ended (status 0)
  !f2py threadsafe
  type(interface_type) :: joint
  type(report_type) :: reports(0:room)
  character(len=:), allocatable :: text
  double precision :: bound
  integer :: ended, i
  logical :: turns(room)
  n_rows = 0
  n_done = 0
  text = ""
  call new_interface(props, joint, status)
  if (status /= status_ok) return
  bound = prescribed_bound(joint)
  call explain_no_branch(joint, text)
  if (preload < 1) call append(text, "preload = " // integer_text(preload) // ": expected at least 1 increment")
  if (.not. (stiffness >= 0.0d0 .and. bounded(stiffness, huge(stiffness)))) &
    call append(text, "stiffness = " // to_text(stiffness) // ": expected a finite stiffness >= 0")
  if (.not. (arc >= least_arc .and. arc <= largest_arc)) call append(text, "arc = " // to_text(arc) // &
    ": expected " // to_text(least_arc) // " to " // to_text(largest_arc) // " (times s0)")
  do i = 1, n
    if (.not. bounded(slips(i), bound)) call append(text, "slips[" // integer_text(i - 1) // "] = " // &
      to_text(slips(i)) // ": expected a finite number of magnitude up to " // to_text(bound) // " (1e12 s_f)")
  end do
  if (len(text) > 0) then
    status = status_separation
  else
    call branch_slip(joint, slip_test_type(direction, sigma_n, preload, 0.0d0, stiffness), slips, arc, separation, &
      traction, state, work, reports, turns, n_rows, n_done, ended)
    if (n_done >= 0 .and. ended /= ended_complete) call explain_end(ended, text)
    do i = 0, min(n_rows, room)
      jumps(:, i) = [dble(reports(i)%snaps), dble(reports(i)%parts), reports(i)%before, reports(i)%after, &
                     reports(i)%released]
    end do
    turned = merge(1, 0, turns)
  end if
  call put_text(text, message)
end subroutine interface_branch_slip
