!> Names of the events between two states of a point, joined by +:
!>   onset     damage begins
!>   damaged   every plane is fully damaged
!>   open      a plane in contact opens
!>   close     a plane that was open comes into contact
!>   slip      a damaged plane in contact begins to slide
module asperity_events
  use asperity_contract, only: plane_statev, v_offset
  use asperity_interface, only: interface_type, plane_damage, start_damage
  use asperity_kinds, only: wp
  use asperity_point, only: kinematics_type, plane_kinematics
  use asperity_point_law, only: event_length
  implicit none
  private
  public :: find_events, name_event

  !> Columns of the regime of the planes at a row.
  integer, parameter :: in_contact = 1, is_open = 2, slides_now = 3

contains

  !> Find the events since the last row. The planes of a virgin point are neither in contact nor open.
  pure subroutine find_events(joint, s, old, new, regime, event)
    type(interface_type), intent(in) :: joint           !! the interface
    real(wp), intent(in) :: s(3)                        !! separation (N, Tx, Ty) of this row, length
    real(wp), intent(in) :: old(:)                      !! STATEV of the last row
    real(wp), intent(in) :: new(:)                      !! STATEV of this row
    logical, allocatable, intent(inout) :: regime(:, :) !! of each plane at the last row, not allocated: virgin -> here
    character(len=event_length), intent(out) :: event   !! names joined by +, blank: none
    logical, dimension(joint%pattern%n) :: contact, apart, slides
    real(wp), dimension(joint%pattern%n) :: damage, was_damage
    logical :: begins
    type(kinematics_type) :: kinematics
    real(wp) :: s_n
    integer :: i, k

    if (.not. allocated(regime)) allocate (regime(joint%pattern%n, 3), source=.false.)
    do k = 1, joint%pattern%n
      i = plane_statev(k)
      kinematics = plane_kinematics(joint, k, s + new(v_offset:v_offset + 2), new)
      s_n = kinematics%contact(1)
      ! a plane that just touches keeps its values
      contact(k) = s_n < 0.0_wp .or. (regime(k, in_contact) .and. .not. s_n > 0.0_wp)
      apart(k) = s_n > 0.0_wp .or. (regime(k, is_open) .and. .not. s_n < 0.0_wp)
      slides(k) = contact(k) .and. new(i) > 0.0_wp .and. any(abs(new(i + 1:i + 2) - old(i + 1:i + 2)) > 0.0_wp)
    end do
    damage = plane_damage(joint, new)
    was_damage = plane_damage(joint, old)
    event = ""
    begins = any(damage > start_damage(joint, 0.0_wp)) .and. .not. any(was_damage > start_damage(joint, 0.0_wp))
    call name_event(event, "onset", begins)
    call name_event(event, "damaged", all(damage >= 1.0_wp) .and. .not. all(was_damage >= 1.0_wp))
    call name_event(event, "open", any(regime(:, in_contact) .and. .not. contact))
    call name_event(event, "close", any(regime(:, is_open) .and. contact))
    call name_event(event, "slip", any(slides .and. .not. regime(:, slides_now)))
    regime(:, in_contact) = contact
    regime(:, is_open) = apart
    regime(:, slides_now) = slides
  end subroutine find_events

  !> Append a name if its event happened.
  pure subroutine name_event(event, name, happened)
    character(len=event_length), intent(inout) :: event   !! names so far
    character(len=*), intent(in) :: name                  !! of the event
    logical, intent(in) :: happened                       !! false: nothing is added
    if (.not. happened) return
    if (len_trim(event) > 0) event = trim(event) // "+"
    event = trim(event) // name
  end subroutine name_event

end module asperity_events
