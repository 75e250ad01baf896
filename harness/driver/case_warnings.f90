!> Warnings about cases that are admissible, but where the law does not do what one may expect.
module case_warnings
  use asperity_contract, only: p_gc, p_height, p_mu, p_sigma0, p_theta
  use asperity_kinds, only: wp
  use asperity_text, only: short
  use case_file, only: case_type
  use driver_messages, only: say
  implicit none
  private
  public :: s_f_over_height, warn_of_cases

  !> Inclinations (degrees) below this may have been meant in radians: a right angle is 1.57.
  real(wp), parameter :: largest_radian = 1.6_wp

contains

  !> Write a line to standard error for each doubt about the cases of a file, with its worst value.
  subroutine warn_of_cases(path, cases)
    character(len=*), intent(in) :: path     !! case file, for the messages
    type(case_type), intent(in) :: cases(:)  !! a case for each value of the sweep
    real(wp) :: locking, radian, shallow, tension
    integer :: i

    if (cases(1)%mode_2) call say(path // ": warning: sigma02 or Gc2 differ from mode I: the thermodynamic " // &
      "argument of the law holds for equal values only (paper, Remark 2)")
    locking = 0.0_wp
    radian = 0.0_wp
    shallow = 0.0_wp
    tension = 0.0_wp
    do i = 1, size(cases)
      locking = max(locking, steepest_friction(cases(i)))
      if (cases(i)%props(p_theta) < largest_radian) radian = max(radian, cases(i)%props(p_theta))
      shallow = max(shallow, s_f_over_height(cases(i)))
      tension = max(tension, largest_tension(cases(i)))
    end do
    if (locking >= 1.0_wp) call say(path // ": warning: mu tan(theta) = " // short(locking) // " of the steepest " // &
      "plane: expected < 1, the interface locks where it slides up this plane")
    if (radian > 0.0_wp) call say(path // ": warning: theta = " // short(radian) // " degrees is nearly flat: " // &
      "expected degrees, not radians")
    if (shallow > 1.0_wp) call say(path // ": warning: s_f is " // short(shallow) // " height: expected a height " // &
      "of at least s_f = 2 Gc/sigma0, within which the bond of the straight plane breaks")
    if (tension >= 1.0_wp) call say(path // ": warning: t_N reaches " // short(tension) // " times the strength " // &
      "sigma0: expected less, beyond it there is no equilibrium")
  end subroutine warn_of_cases

  !> mu tan(theta) of the steepest plane; 0 where a finite height ends the climb.
  pure function steepest_friction(case) result(product)
    type(case_type), intent(in) :: case   !! the case
    real(wp) :: product
    integer :: k
    product = 0.0_wp
    if (case%props(p_height) > 0.0_wp) return
    associate (pattern => case%joint%pattern)
      do k = 1, pattern%n
        product = max(product, case%props(p_mu)*pattern%sin_theta(k)/pattern%cos_theta(k))
      end do
    end associate
  end function steepest_friction

  !> Largest prescribed t_N over the strength sigma0.
  pure function largest_tension(case) result(tension)
    type(case_type), intent(in) :: case   !! the case
    real(wp) :: tension
    integer :: i
    tension = 0.0_wp
    do i = 1, size(case%steps)
      if (.not. (case%steps(i)%control%traction(1) .and. case%steps(i)%has_target(1))) cycle
      tension = max(tension, maxval(case%steps(i)%targets(1, :))/case%props(p_sigma0))
    end do
  end function largest_tension

  !> s_f = 2 Gc/sigma0 over the asperity height, 0 without a height or without inclined planes.
  pure function s_f_over_height(case) result(ratio)
    type(case_type), intent(in) :: case    !! the case
    real(wp) :: ratio
    ratio = 0.0_wp
    if (.not. case%props(p_height) > 0.0_wp) return
    if (.not. any(case%joint%pattern%sin_theta(:case%joint%pattern%n) > 0.0_wp)) return
    ratio = 2.0_wp*case%props(p_gc)/case%props(p_sigma0)/case%props(p_height)
  end function s_f_over_height

end module case_warnings
