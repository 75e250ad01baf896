!> What the suites of the point share: scales of laws that they define.
module support_point
  use asperity_kinds, only: wp
  use asperity_point_law, only: point_law
  implicit none
  private
  public :: set_unit_scales

contains

  !> Give a law one state variable, and lengths, stress and stiffnesses of 1.
  subroutine set_unit_scales(law)
    class(point_law), intent(inout) :: law   !! the law
    law%n_state = 1
    law%s_0 = 1.0_wp
    law%s_f = 1.0_wp
    law%stiffness = 1.0_wp
    law%least_stiffness = 1.0_wp
    law%largest_stiffness = 1.0_wp
    law%stress = 1.0_wp
    law%bound = 1.0e10_wp
  end subroutine set_unit_scales

end module support_point
