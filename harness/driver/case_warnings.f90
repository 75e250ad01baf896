!> Warnings about cases that are admissible but outside the law's range of validity.
module case_warnings
  use asperity_kinds, only: wp
  use asperity_warnings, only: m_tension, measures, n_measures, warned, warning_text
  use asperity_case, only: case_type
  use driver_messages, only: say
  implicit none
  private
  public :: warn_of, measures_of_case

contains

  !> Write a line to standard error for each measure beyond its limit.
  subroutine warn_of(path, values)
    character(len=*), intent(in) :: path             !! case file, for the messages
    real(wp), intent(in) :: values(n_measures)       !! the largest ones of all values of the sweep
    logical :: doubtful(n_measures)
    integer :: i
    doubtful = warned(values)
    do i = 1, n_measures
      if (doubtful(i)) call say(path // ": warning: " // trim(warning_text(i, values(i))))
    end do
  end subroutine warn_of

  !> Measures of a case: before the run those that the case determines, after it those of its largest pressure and slip.
  pure function measures_of_case(case, pressure, slip) result(values)
    type(case_type), intent(in) :: case              !! the case
    real(wp), intent(in), optional :: pressure       !! largest of the run, >= 0, stress
    real(wp), intent(in), optional :: slip           !! largest of the run, length
    real(wp) :: values(n_measures)
    if (present(pressure) .and. present(slip)) then
      values = measures(case%props, pressure, 0.0_wp, slip)
      values(:m_tension) = 0.0_wp
    else
      values = measures(case%props, 0.0_wp, largest_tension(case), 0.0_wp)
    end if
  end function measures_of_case

  !> Largest prescribed t_N.
  pure function largest_tension(case) result(tension)
    type(case_type), intent(in) :: case   !! the case
    real(wp) :: tension
    integer :: i
    tension = 0.0_wp
    do i = 1, size(case%steps)
      if (.not. (case%steps(i)%control%traction(1) .and. case%steps(i)%has_target(1))) cycle
      tension = max(tension, maxval(case%steps(i)%targets(1, :)))
    end do
  end function largest_tension

end module case_warnings
