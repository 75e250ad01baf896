!> Checks of values, of PROPS and of STATEV, and the messages for rejected values. asperity_call_checks checks the other
!> arguments of a call.
!>
!> Values are compared by their bits, read as integers: the bits of magnitudes have the order of the numbers, and the
!> bits of NaN and infinity are larger than those of all finite numbers. Therefore no test raises a floating-point
!> exception, and the loops over values have no branches, so that the compiler vectorises them.
module asperity_checks
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_kinds, only: wp
  use asperity_contract, only: cap_statev, crushing_row, damage_row, kappa_row, length_ratio_limit, min_inclined, &
    most_statev, n_facet_statev, n_fixed_props, n_listed_values, n_plane_statev, n_point_statev, n_required_props, &
    p_fc, p_gc, p_gc2, p_gfc, p_m, p_sigma0, p_sigma02, prop_table, smallest_divisor, statev_row, status_nprops, &
    status_ok, status_props, stiffness_ratio_limit, v_offset, wear_work_row, weight_tolerance, worn_row
  use asperity_text, only: append, integer_text, set_text, to_text
  implicit none
  private
  public :: bounded, all_bounded, is_pressure, review, read_props, prop_admissible, review_props, state_bounded, &
    set_limits, state_ranges

  !> Number of points whose values are tested together.
  integer, parameter, public :: points_together = 4

  !> Ranges of the n state variables of a point, repeated for the points that are tested together: bits of the largest
  !> magnitudes, and masks with all bits set where a value must not be negative.
  type, public :: limits_type
    integer(int64), dimension(points_together*most_statev) :: most, unsigned   ! first, so that vectors are aligned
    integer :: n   !! state variables of a point
  end type limits_type

  real(wp), parameter :: defaults(n_fixed_props) = prop_table%default
  character(len=5), parameter :: listed_names(n_listed_values) = ["n_N  ", "n_Tx ", "n_Ty ", "gamma"]

contains

  !> Negative if |x| > bound, if x is NaN or infinite, or if x < 0 although it must not be.
  !> `ior` combines the results of several values.
  elemental function outside(x, bound, signed) result(beyond)
    real(wp), intent(in) :: x, bound   !! any bits; finite, >= 0
    logical, intent(in) :: signed          !! whether x may be negative (-0 may always be)
    integer(int64) :: beyond, magnitude
    magnitude = iand(transfer(x, 0_int64), huge(0_int64))
    beyond = transfer(bound, 0_int64) - magnitude
    beyond = ior(beyond, merge(0_int64, iand(transfer(x, 0_int64), -magnitude), signed))
  end function outside

  !> Whether |x| <= bound; false for NaN and infinity.
  elemental function bounded(x, bound) result(yes)
    real(wp), intent(in) :: x       !! any bits
    real(wp), intent(in) :: bound   !! finite, >= 0
    logical :: yes
    yes = outside(x, bound, .true.) >= 0_int64
  end function bounded

  !> Whether a number is a water pressure: finite and >= 0, without comparisons, which NaN makes an IEEE exception.
  elemental function is_pressure(p) result(yes)
    real(wp), intent(in) :: p   !! any bits
    logical :: yes
    yes = outside(p, huge(p), .false.) >= 0_int64
  end function is_pressure

  !> Whether all |x| <= bound; false if one is NaN or infinite.
  pure function all_bounded(n, x, bound) result(yes)
    integer, intent(in) :: n        !! number of values
    real(wp), intent(in) :: x(n)    !! any bits
    real(wp), intent(in) :: bound   !! finite, >= 0
    logical :: yes
    integer(int64) :: beyond
    integer :: i
    beyond = 0_int64
    ! a vector loop would take longer for few values
    !GCC$ novector
    do i = 1, n
      beyond = ior(beyond, outside(x(i), bound, .true.))
    end do
    yes = beyond >= 0_int64
  end function all_bounded

  !> Add a line to the message if a value is not a finite number in its range.
  pure subroutine review(message, name, value, bound, signed)
    character(len=:), allocatable, intent(inout) :: message   !! lines so far
    character(len=*), intent(in) :: name                      !! of the value
    real(wp), intent(in) :: value                             !! any bits
    real(wp), intent(in) :: bound                             !! largest magnitude
    logical, intent(in) :: signed                             !! whether the value may be negative
    character(len=:), allocatable :: range
    if (outside(value, bound, signed) >= 0_int64) return
    call set_text(range, "from 0 to ")
    if (signed) call set_text(range, "of magnitude up to ")
    call append(message, name // " = " // to_text(value) // ": expected a finite number " // range // to_text(bound))
  end subroutine review

  !> Largest magnitude of a state variable.
  elemental function row_bound(row, energy, slip) result(bound)
    integer, intent(in) :: row       !! row of statev_table
    real(wp), intent(in) :: energy   !! largest energy, stress*length
    real(wp), intent(in) :: slip     !! largest slip and offset, length
    real(wp) :: bound
    bound = merge(1.0_wp, merge(energy, slip, row < v_offset .or. row == wear_work_row .or. row == crushing_row), &
      row == damage_row .or. row == worn_row)
  end function row_bound

  !> Whether a state variable may be negative.
  elemental function row_signed(row) result(yes)
    integer, intent(in) :: row   !! row of statev_table
    logical :: yes
    yes = .not. (row == damage_row .or. row >= worn_row)
  end function row_signed

  !> Whether every state variable of a point is in its range.
  pure function state_bounded(n_planes, wears, n_statev, state, energy, slip) result(yes)
    integer, intent(in) :: n_planes             !! planes
    logical, intent(in) :: wears                !! whether they wear or are crushed
    integer, intent(in) :: n_statev             !! state variables the law needs
    real(wp), intent(in) :: state(n_statev)     !! STATEV, any bits
    real(wp), intent(in) :: energy              !! largest energy, stress*length
    real(wp), intent(in) :: slip                !! largest slip and offset, length
    logical :: yes
    integer(int64) :: beyond
    integer :: i, row
    beyond = 0_int64
    do i = cap_statev(n_planes, wears), n_statev
      row = statev_row(i, n_planes, wears)
      beyond = ior(beyond, outside(state(i), row_bound(row, energy, slip), row_signed(row)))
    end do
    do row = 1, n_point_statev
      beyond = ior(beyond, outside(state(row), row_bound(row, energy, slip), .true.))
    end do
    do i = 0, n_plane_statev*(n_planes - 1), n_plane_statev
      do row = damage_row, worn_row - 1
        beyond = ior(beyond, outside(state(i + row), row_bound(row, energy, slip), row_signed(row)))
      end do
    end do
    do i = n_plane_statev*(n_planes - 1), cap_statev(n_planes, wears) - kappa_row, n_facet_statev
      do row = worn_row, wear_work_row
        beyond = ior(beyond, outside(state(i + row), row_bound(row, energy, slip), row_signed(row)))
      end do
    end do
    yes = beyond >= 0_int64
  end function state_bounded

  !> Ranges of the state variables of a point.
  pure subroutine state_ranges(n_planes, wears, energy, slip, bound, signed)
    integer, intent(in) :: n_planes       !! planes
    logical, intent(in) :: wears          !! whether they wear or are crushed
    real(wp), intent(in) :: energy        !! largest energy, stress*length
    real(wp), intent(in) :: slip          !! largest slip and offset, length
    real(wp), intent(out) :: bound(:)     !! (n_statev) largest magnitudes
    logical, intent(out) :: signed(:)     !! (n_statev) whether they may be negative
    integer :: i, row
    do i = 1, size(bound)
      row = statev_row(i, n_planes, wears)
      bound(i) = row_bound(row, energy, slip)
      signed(i) = row_signed(row)
    end do
  end subroutine state_ranges

  !> Ranges of the state variables of a point, as bits.
  pure subroutine set_limits(n_planes, wears, n_statev, energy, slip, limits)
    integer, intent(in) :: n_planes            !! planes
    logical, intent(in) :: wears               !! whether they wear or are crushed
    integer, intent(in) :: n_statev            !! state variables the law needs
    real(wp), intent(in) :: energy             !! largest energy, stress*length
    real(wp), intent(in) :: slip               !! largest slip and offset, length
    type(limits_type), intent(out) :: limits   !! the ranges
    real(wp) :: bound(n_statev)
    logical :: signed(n_statev)
    integer :: i
    call state_ranges(n_planes, wears, energy, slip, bound, signed)
    limits%n = n_statev
    do i = 0, n_statev*(points_together - 1), n_statev
      limits%most(i + 1:i + n_statev) = transfer(bound, [0_int64])
      limits%unsigned(i + 1:i + n_statev) = merge(0_int64, -1_int64, signed)
    end do
  end subroutine set_limits

  !> Read PROPS before the listed planes, with defaults for missing values; all of PROPS is tested.
  pure subroutine read_props(n, props, fixed, status)
    integer, intent(in) :: n                         !! number of values
    real(wp), intent(in) :: props(n)                 !! PROPS
    real(wp), intent(out) :: fixed(n_fixed_props)    !! admissible if status is 0
    integer, intent(out) :: status                   !! 0, status_props or status_nprops
    character(len=:), allocatable :: message
    integer(int64) :: beyond
    integer :: given, i
    ! entries that are integers
    logical, parameter :: integral(n_fixed_props) = [(prop_table(i)%scale == "whole", i=1, n_fixed_props)]
    integer, parameter :: whole(count(integral)) = pack([(i, i=1, n_fixed_props)], integral)
    given = min(n, n_fixed_props)
    fixed = defaults
    beyond = 0_int64
    !$omp simd reduction(ior:beyond)
    do i = 1, given
      fixed(i) = props(i)
      beyond = ior(beyond, outside_prop(i, props(i)))
    end do
    status = status_props
    if (beyond >= 0_int64 .and. given >= n_required_props) then
      if (all(is_whole(fixed(whole)))) status = status_ok
      call review_ratios(fixed, status, message)
    end if
    if (status /= status_ok) then
      call review_props(props, status, message)
    else if (fixed(p_m) < 0.0_wp) then
      call review_listed(props, -int(fixed(p_m)), .true., status, message)
    end if
  end subroutine read_props

  !> Test a PROPS vector and append one line for each bad value, with what was expected.
  pure subroutine review_props(props, status, message, nprops, by_name)
    real(wp), intent(in), contiguous :: props(:)              !! PROPS, any number of values
    integer, intent(out) :: status                            !! 0, status_props or status_nprops
    character(len=:), allocatable, intent(inout) :: message   !! one line per bad value is appended
    integer, intent(in), optional :: nprops                   !! NPROPS as the caller passed it; if it is negative,
                                                              !! the array has size 0
    logical, intent(in), optional :: by_name                  !! true: the user knows names, and no index
    real(wp) :: fixed(n_fixed_props)
    integer :: given, i, passed
    logical :: indices

    status = status_ok
    indices = .true.
    if (present(by_name)) indices = .not. by_name
    passed = size(props)
    if (present(nprops)) passed = nprops
    given = min(size(props), n_fixed_props)
    fixed = defaults
    fixed(:given) = props(:given)
    if (given < n_required_props) then
      status = status_nprops
      call append(message, "NPROPS = " // integer_text(passed) // ": expected at least " // &
        integer_text(n_required_props) // " (sigma0, Gc, eta, mu)")
    end if
    do i = 1, given
      if (prop_admissible(i, props(i))) cycle
      status = status_props
      call append(message, index_text(i, indices) // trim(prop_table(i)%name) // " = " // to_text(props(i)) // &
        ": expected " // trim(prop_table(i)%admissible))
    end do
    if (status == status_ok) call review_ratios(fixed, status, message)
    if (.not. prop_admissible(p_m, fixed(p_m))) return
    if (fixed(p_m) < 0.0_wp) call review_listed(props, -int(fixed(p_m)), indices, status, message)
  end subroutine review_props

  !> Whether a value is admissible for one entry of PROPS, whatever the others are.
  pure function prop_admissible(i, value) result(yes)
    integer, intent(in) :: i        !! index, 1..n_fixed_props
    real(wp), intent(in) :: value   !! any bits
    logical :: yes
    yes = outside_prop(i, value) >= 0_int64
    if (yes .and. prop_table(i)%scale == "whole") yes = is_whole(value)
  end function prop_admissible

  !> Whether an admissible value is an integer.
  elemental function is_whole(value) result(yes)
    real(wp), intent(in) :: value   !! in the range of integers
    logical :: yes
    yes = abs(value - real(int(value), wp)) <= 0.0_wp
  end function is_whole

  !> "PROPS(i) " in a message, for those who know indices.
  pure function index_text(i, indices) result(text)
    integer, intent(in) :: i         !! index
    logical, intent(in) :: indices   !! false: the text is empty
    character(len=merge(len(integer_text(i)) + 8, 0, indices)) :: text
    text = "PROPS(" // integer_text(i) // ") "
  end function index_text

  !> Test the listed planes of a PROPS vector and append one line for each bad value.
  pure subroutine review_listed(props, n, indices, status, message)
    real(wp), intent(in), contiguous :: props(:)              !! PROPS, any number of values
    integer, intent(in) :: n                                  !! number of listed planes
    logical, intent(in) :: indices                            !! whether lines have the index of a value
    integer, intent(inout) :: status                          !! of the other PROPS -> of all
    character(len=:), allocatable, intent(inout) :: message   !! one line per bad value is appended
    real(wp) :: total
    integer :: i, j, k

    if (size(props) < n_fixed_props + n_listed_values*n) then
      status = status_nprops
      call append(message, "NPROPS = " // integer_text(size(props)) // ": expected at least " // &
        integer_text(n_fixed_props + n_listed_values*n) // " for " // integer_text(n) // " listed planes")
      return
    end if
    total = 0.0_wp
    do k = 1, n
      do j = 1, n_listed_values
        i = n_fixed_props + n_listed_values*(k - 1) + j
        if (listed_admissible(j, props(i))) then
          if (j == n_listed_values) total = total + props(i)
        else
          status = status_props
          call append(message, index_text(i, indices) // trim(listed_names(j)) // " of listed plane " // &
            integer_text(k) // " = " // to_text(props(i)) // ": expected " // &
            trim(merge("> 0   ", "finite", j == 1 .or. j == n_listed_values)))
        end if
      end do
    end do
    if (status == status_ok .and. abs(total - 1.0_wp) > weight_tolerance) then
      status = status_props
      call append(message, "weights gamma of the listed planes sum to " // to_text(total) // ": expected 1 within " // &
        to_text(weight_tolerance))
    end if
  end subroutine review_listed

  !> An integer as of `outside`: negative if the value is not in the range of entry i of PROPS by prop_table.
  elemental function outside_prop(i, value) result(beyond)
    integer, intent(in) :: i        !! index, 1..n_fixed_props
    real(wp), intent(in) :: value   !! any bits
    integer(int64) :: beyond, bits, magnitude
    integer :: k
    ! bits of the largest magnitude, and of the smallest admissible value above 0
    integer(int64), parameter :: most(n_fixed_props) = transfer(prop_table%upper, [0_int64])
    integer(int64), parameter :: least(n_fixed_props) = transfer(max(prop_table%lower, [(merge(smallest_divisor, &
      merge(real(min_inclined, wp), 0.0_wp, k == p_m), prop_table(k)%divides), k=1, n_fixed_props)]), [0_int64])
    ! masks, all bits set where an entry must not be negative or must not be 0
    integer(int64), parameter :: yes = -1_int64, no = 0_int64
    integer(int64), parameter :: unsigned(n_fixed_props) = merge(no, yes, prop_table%lower < 0.0_wp)
    integer(int64), parameter :: nonzero(n_fixed_props) = merge(yes, no, prop_table%lower > 0.0_wp)
    bits = transfer(value, 0_int64)
    magnitude = iand(bits, huge(0_int64))
    ! too large, infinite or NaN
    beyond = most(i) - magnitude
    ! negative
    beyond = ior(beyond, iand(unsigned(i), iand(bits, -magnitude)))
    ! too small: positive and below the smallest value, or zero where zero is not admissible
    beyond = ior(beyond, iand(magnitude - least(i), ior(nonzero(i), iand(not(bits), -magnitude))))
  end function outside_prop

  !> Test the ratios of PROPS, each entry of which is admissible: the stiffness of mode II over that of mode I, and
  !> lengths over s_f. A compressive strength needs the energy of its softening.
  pure subroutine review_ratios(fixed, status, message)
    real(wp), intent(in) :: fixed(n_fixed_props)              !! PROPS
    integer, intent(inout) :: status                          !! -> status_props if one is not admissible
    character(len=:), allocatable, intent(inout) :: message   !! a line for each of these is appended
    integer :: i
    real(wp) :: ratio
    logical, parameter :: measured(n_fixed_props) = [(prop_table(i)%measure == "s_f", i=1, n_fixed_props)]
    integer, parameter :: lengths(count(measured)) = pack([(i, i=1, n_fixed_props)], measured)
    if (fixed(p_fc) > 0.0_wp .and. .not. fixed(p_gfc) > 0.0_wp) then
      status = status_props
      call append(message, "fc = " // to_text(fixed(p_fc)) // ": expected Gfc > 0 beside it, the energy of its " // &
        "softening")
    end if
    ratio = 1.0_wp
    if (fixed(p_sigma02) > 0.0_wp) ratio = (fixed(p_sigma02)/fixed(p_sigma0))**2
    if (fixed(p_gc2) > 0.0_wp) ratio = ratio*(fixed(p_gc)/fixed(p_gc2))
    if (.not. within(ratio, stiffness_ratio_limit)) call refuse_ratio("sigma02^2 Gc/(sigma0^2 Gc2)", ratio, &
      stiffness_ratio_limit, status, message)
    do i = 1, size(lengths)
      if (.not. fixed(lengths(i)) > 0.0_wp) cycle
      ratio = fixed(lengths(i))*(fixed(p_sigma0)/(2.0_wp*fixed(p_gc)))
      if (.not. within(ratio, length_ratio_limit)) call refuse_ratio(trim(prop_table(lengths(i))%name) // &
        " sigma0/(2 Gc)", ratio, length_ratio_limit, status, message)
    end do
  end subroutine review_ratios

  !> Whether a ratio is at most `limit` and at least 1/limit.
  elemental function within(ratio, limit) result(yes)
    real(wp), intent(in) :: ratio, limit   !! > 0
    logical :: yes
    yes = ratio <= limit .and. ratio*limit >= 1.0_wp
  end function within

  !> Append a line about a ratio of PROPS that is not admissible.
  pure subroutine refuse_ratio(name, ratio, limit, status, message)
    character(len=*), intent(in) :: name                      !! what it is the ratio of
    real(wp), intent(in) :: ratio, limit                      !! > 0
    integer, intent(out) :: status                            !! status_props
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended
    status = status_props
    call append(message, name // " = " // to_text(ratio) // ": expected " // to_text(1.0_wp/limit) // " to " // &
      to_text(limit))
  end subroutine refuse_ratio

  !> Whether a value is admissible as number j of a listed plane (n_N, n_Tx, n_Ty, gamma).
  pure function listed_admissible(j, value) result(yes)
    integer, intent(in) :: j        !! 1..n_listed_values
    real(wp), intent(in) :: value   !! any bits
    logical :: yes
    yes = bounded(value, huge(1.0_wp))
    if (yes .and. (j == 1 .or. j == n_listed_values)) yes = value > 0.0_wp
    if (yes .and. j == n_listed_values) yes = value <= 1.0_wp + weight_tolerance
  end function listed_admissible

end module asperity_checks
