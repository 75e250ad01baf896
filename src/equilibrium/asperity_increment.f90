!> An increment of the given values, and the equations at a fraction of it.
module asperity_increment
  use asperity_control_point, only: balance_type, control_type, set_balance
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  implicit none
  private
  public :: path_type, set_share, values_at

  !> Definition of an increment.
  type :: path_type
    type(control_type) :: control        !! what is given
    real(wp) :: start(3), target(3)      !! given values at both ends
    real(wp) :: change(3)                !! target - start
  end type path_type

contains

  !> Equations at a fraction of an increment, from the point at another fraction.
  pure subroutine set_share(joint, path, share, reached, balance)
    type(interface_type), intent(in) :: joint      !! the interface
    type(path_type), intent(in) :: path            !! the increment
    real(wp), intent(in) :: share                  !! 0 to 1
    real(wp), intent(in) :: reached                !! fraction at which the point at the start is
    type(balance_type), intent(inout) :: balance   !! the equations, the point at their start
    call set_balance(joint, path%control, values_at(path, share), balance)
    balance%control%dt = (share - reached)*path%control%dt
  end subroutine set_share

  !> Given values at a fraction of an increment.
  pure function values_at(path, share) result(values)
    type(path_type), intent(in) :: path   !! the increment
    real(wp), intent(in) :: share         !! 0 to 1
    real(wp) :: values(3)
    values = path%start + share*path%change
    if (share >= 1.0_wp) values = path%target
  end function values_at

end module asperity_increment
