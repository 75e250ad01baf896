!> Tests of the input, and the messages for what they reject: all bad values at once, each with what was expected.
module asperity_checks
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_kinds, only: wp
  use asperity_contract, only: min_inclined, n_fixed_props, n_listed_values, n_required_props, p_gc, p_gc2, p_h, p_m, &
    p_map, p_sigma0, p_sigma02, prop_table, smallest_divisor, status_nprops, status_ok, status_props, &
    stiffness_ratio_limit, weight_tolerance
  use asperity_text, only: append, integer_text, to_text
  implicit none
  private
  public :: all_bounded, bounded, review_props

  character(len=5), parameter :: listed_names(n_listed_values) = ["n_N  ", "n_Tx ", "n_Ty ", "gamma"]

contains

  !> Whether |x| <= bound; false for NaN and infinity, without raising a floating-point exception.
  elemental function bounded(x, bound) result(yes)
    real(wp), intent(in) :: x       !! any bits
    real(wp), intent(in) :: bound   !! finite, >= 0
    logical :: yes
    ! the bits of non-negative doubles order like the numbers, NaN and infinity above all finite ones
    yes = iand(transfer(x, 0_int64), huge(0_int64)) <= transfer(bound, 0_int64)
  end function bounded

  !> Whether all |x| <= bound, in one call.
  pure function all_bounded(n, x, bound) result(yes)
    integer, intent(in) :: n        !! number of values
    real(wp), intent(in) :: x(n)    !! any bits
    real(wp), intent(in) :: bound   !! finite, >= 0
    logical :: yes
    integer(int64) :: beyond, limit
    integer :: i
    ! a difference of bits is negative where a value lies beyond: one loop without branches
    limit = transfer(bound, 0_int64)
    beyond = 0_int64
    do i = 1, n
      beyond = ior(beyond, limit - iand(transfer(x(i), 0_int64), huge(0_int64)))
    end do
    yes = beyond >= 0_int64
  end function all_bounded

  !> Test a PROPS vector; on request say of every bad value what it is and what was expected.
  pure subroutine review_props(props, status, message)
    real(wp), intent(in), contiguous :: props(:)                    !! PROPS, any number of values
    integer, intent(out) :: status                                  !! 0, status_props or status_nprops
    character(len=:), allocatable, intent(inout), optional :: message   !! one line per bad value is appended
    real(wp) :: ratio, total
    integer :: i, j, k, m

    status = status_ok
    m = 0
    if (fixed_props_admissible(props)) then
      if (size(props) >= p_m) m = int(props(p_m))
    else
      if (size(props) < n_required_props) then
        status = status_nprops
        if (present(message)) call append(message, "NPROPS = " // integer_text(size(props)) // &
          ": expected at least " // integer_text(n_required_props) // " (sigma0, Gc, eta, mu)")
      end if
      do i = 1, min(size(props), n_fixed_props)
        if (prop_admissible(i, props(i))) then
          if (i == p_m) m = int(props(i))
        else
          status = status_props
          if (present(message)) call append(message, "PROPS(" // integer_text(i) // ") " // &
            trim(prop_table(i)%name) // " = " // to_text(props(i)) // ": expected " // trim(prop_table(i)%admissible))
        end if
      end do
      if (status == status_ok) then
        ratio = mode_ratio(props)
        if (.not. mode_ratio_admissible(ratio)) then
          status = status_props
          if (present(message)) call append(message, "sigma02^2 Gc/(sigma0^2 Gc2) = " // to_text(ratio) // &
            ": expected " // to_text(1.0_wp/stiffness_ratio_limit) // " to " // to_text(stiffness_ratio_limit))
        end if
      end if
    end if
    if (m >= 0) return

    ! listed planes
    if (size(props) < n_fixed_props - n_listed_values*m) then
      status = status_nprops
      if (present(message)) call append(message, "NPROPS = " // integer_text(size(props)) // ": expected at least " // &
        integer_text(n_fixed_props - n_listed_values*m) // " for " // integer_text(-m) // " listed planes")
      return
    end if
    total = 0.0_wp
    do k = 1, -m
      do j = 1, n_listed_values
        i = n_fixed_props + n_listed_values*(k - 1) + j
        if (listed_admissible(j, props(i))) then
          if (j == n_listed_values) total = total + props(i)
        else
          status = status_props
          if (present(message)) call append(message, "PROPS(" // integer_text(i) // ") " // trim(listed_names(j)) // &
            " of listed plane " // integer_text(k) // " = " // to_text(props(i)) // ": expected " // &
            trim(merge("> 0   ", "finite", j == 1 .or. j == n_listed_values)))
        end if
      end do
    end do
    if (status == status_ok .and. abs(total - 1.0_wp) > weight_tolerance) then
      status = status_props
      if (present(message)) call append(message, "weights gamma of the listed planes sum to " // to_text(total) // &
        ": expected 1 within " // to_text(weight_tolerance))
    end if
  end subroutine review_props

  !> Whether all PROPS before the listed planes are admissible: what every call of a host passes, in few instructions.
  pure function fixed_props_admissible(props) result(yes)
    real(wp), intent(in), contiguous :: props(:)   !! PROPS, any number of values
    logical :: yes
    integer :: bad, i, n
    n = min(size(props), n_fixed_props)
    yes = n >= n_required_props
    if (yes) yes = all_bounded(n, props, huge(1.0_wp))
    if (.not. yes) return
    bad = 0
    do i = 1, n
      bad = ior(bad, merge(0, 1, props(i) >= prop_table(i)%lower))
      bad = ior(bad, merge(0, 1, props(i) <= prop_table(i)%upper))
    end do
    yes = bad == 0
    if (yes .and. n >= p_m) yes = prop_admissible(p_m, props(p_m))
    if (yes .and. n >= p_h) yes = prop_admissible(p_h, props(p_h))
    if (yes .and. n >= p_map) yes = prop_admissible(p_map, props(p_map))
    if (yes .and. n >= p_sigma02) yes = prop_admissible(p_sigma02, props(p_sigma02))
    if (yes .and. n >= p_gc2) yes = prop_admissible(p_gc2, props(p_gc2))
    if (yes .and. n >= p_sigma02) yes = mode_ratio_admissible(mode_ratio(props))
  end function fixed_props_admissible

  !> Stiffness of mode II over that of mode I, (sigma02^2/Gc2)/(sigma0^2/Gc).
  pure function mode_ratio(props) result(ratio)
    real(wp), intent(in) :: props(:)   !! PROPS, each entry admissible
    real(wp) :: ratio
    ratio = 1.0_wp
    if (size(props) >= p_sigma02) then
      if (props(p_sigma02) > 0.0_wp) ratio = (props(p_sigma02)/props(p_sigma0))**2
    end if
    if (size(props) >= p_gc2) then
      if (props(p_gc2) > 0.0_wp) ratio = ratio*(props(p_gc)/props(p_gc2))
    end if
  end function mode_ratio

  !> Whether the stiffnesses of the two modes are near enough to each other.
  pure function mode_ratio_admissible(ratio) result(yes)
    real(wp), intent(in) :: ratio   !! of mode_ratio
    logical :: yes
    yes = ratio <= stiffness_ratio_limit .and. ratio*stiffness_ratio_limit >= 1.0_wp
  end function mode_ratio_admissible

  !> Whether entry i of PROPS may have this value.
  pure function prop_admissible(i, value) result(yes)
    integer, intent(in) :: i        !! index, 1..n_fixed_props
    real(wp), intent(in) :: value   !! any bits
    logical :: yes
    yes = bounded(value, huge(1.0_wp))
    if (yes) yes = value >= prop_table(i)%lower .and. value <= prop_table(i)%upper
    if (yes .and. (i == p_h .or. i == p_sigma02 .or. i == p_gc2)) yes = value >= smallest_divisor &
      .or. .not. value > 0.0_wp
    if (yes .and. (i == p_m .or. i == p_map)) yes = abs(value - real(int(value), wp)) <= 0.0_wp
    if (yes .and. i == p_m) yes = int(value) <= 0 .or. int(value) >= min_inclined
  end function prop_admissible

  !> Whether value j of a listed plane (n_N, n_Tx, n_Ty, gamma) may have this value.
  pure function listed_admissible(j, value) result(yes)
    integer, intent(in) :: j        !! 1..n_listed_values
    real(wp), intent(in) :: value   !! any bits
    logical :: yes
    yes = bounded(value, huge(1.0_wp))
    if (yes .and. (j == 1 .or. j == n_listed_values)) yes = value > 0.0_wp
    if (yes .and. j == n_listed_values) yes = value <= 1.0_wp + weight_tolerance
  end function listed_admissible

end module asperity_checks
