!> Why a point found no equilibrium: what a scan around it and the end of its motion show.
!>
!> The scan computes every trial as one increment from the state of the point, but the motion may stop where the law is
!> discontinuous, and with wear it changes the facets on its way. An equilibrium that a scan finds is therefore not one
!> that the point can reach.
module asperity_loss
  use asperity_control_point, only: balance_type, control_type, evaluate, free_part, point_type, set_balance, stiffest
  use asperity_equilibrium_scan, only: scan_equilibria, scan_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_snap_motion, only: move_on
  implicit none
  private
  public :: examine_loss

  !> No equilibrium was found; there is one that the motion does not reach; the motion stops where the law is
  !> discontinuous; there is one for the facets at the start of the motion, but none for those it has worn.
  integer, parameter, public :: loss_none_found = 1, loss_elsewhere = 2, loss_discontinuous = 3, loss_worn = 4

  !> Findings.
  type, public :: loss_type
    integer :: kind = loss_none_found
    type(scan_type) :: scan                     !! around the last point found; if worn, around the end of the motion
    real(wp) :: place(3) = 0.0_wp               !! separation where the motion ends, length
    real(wp) :: leap = 0.0_wp                   !! change of the traction there, if the law is discontinuous, stress
  end type loss_type

contains

  !> Examine the loss of a point under given values.
  pure subroutine examine_loss(joint, control, given, point, most, loss)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given, at least one traction
    real(wp), intent(in) :: given(3)                !! its values
    type(point_type), intent(in) :: point           !! the last point found
    integer, intent(in) :: most                     !! largest number of updates of the motion
    type(loss_type), intent(out) :: loss            !! findings
    type(control_type) :: at_once
    type(scan_type) :: scan
    type(point_type) :: last
    integer :: iterations, updates
    logical :: found
    ! without a duration no viscous damage grows
    at_once = control
    at_once%dt = 0.0_wp
    call scan_equilibria(joint, at_once, given, point, loss%scan)
    if (loss%scan%found) loss%kind = loss_elsewhere
    last = point
    call move_on(joint, at_once, given, most, last, updates, iterations, found)
    loss%place = last%s
    if (found) return
    loss%leap = discontinuity(joint, at_once, given, last)
    if (loss%leap > 0.0_wp) then
      loss%kind = loss_discontinuous
    else if (joint%material%wears .and. loss%scan%found) then
      call scan_equilibria(joint, at_once, given, last, scan)
      if (scan%found) return
      loss%kind = loss_worn
      loss%scan = scan
    end if
  end subroutine examine_loss

  !> Largest change of a free traction over a distance that is too short for any stiffness of the law, stress; 0 if it
  !> is continuous there. A closed facet of finite height is discontinuous at its foot, where its curvature sets in, and
  !> so is the guard where it admits damage that it had prevented, also at a constant separation.
  pure function discontinuity(joint, control, given, point) result(leap)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! what is given, at least one traction
    real(wp), intent(in) :: given(3)                !! its values
    type(point_type), intent(in) :: point           !! the point
    real(wp) :: leap
    !> Distances, relative to s0, the motion stops about there before the discontinuity; stiffness of a continuous law,
    !> relative to that of the stiffest plane.
    real(wp), parameter :: distances(2) = [1.0e-9_wp, 1.0e-7_wp], steepest = 100.0_wp
    type(balance_type) :: balance
    type(point_type) :: at
    real(wp) :: ahead(3), back(3), scale, step(3)
    integer :: i, j
    logical :: good
    leap = 0.0_wp
    call set_balance(joint, control, given, balance)
    balance%old = point
    if (joint%material%guard) then
      call evaluate(joint, balance, free_part(balance, point%s), at, ahead, scale, good)
      if (good) leap = maxval(abs(at%traction - point%traction), mask=control%traction)
    end if
    if (leap <= least(distances(1))) leap = 0.0_wp
    do j = 1, size(distances)
      if (leap > 0.0_wp) exit
      do i = 1, balance%n
        step = 0.0_wp
        step(i) = distances(j)*joint%material%s0
        call evaluate(joint, balance, free_part(balance, point%s) + step, at, ahead, scale, good)
        if (good) call evaluate(joint, balance, free_part(balance, point%s) - step, at, back, scale, good)
        if (good) leap = max(leap, maxval(abs(ahead - back)))
      end do
      if (leap <= least(distances(j))) leap = 0.0_wp
    end do

  contains

    !> Smallest change over a distance that no stiffness explains.
    pure function least(distance) result(change)
      real(wp), intent(in) :: distance   !! relative to s0
      real(wp) :: change
      change = steepest*stiffest(joint)*distance*joint%material%s0
    end function least

  end function discontinuity

end module asperity_loss
