!> Tests of the input, and the messages for what they reject: all bad values at once, each with what was expected.
module asperity_checks
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_kinds, only: wp
  use asperity_contract, only: divisor_props, integral_props, min_inclined, n_fixed_props, n_listed_values, &
    n_required_props, p_gc, p_gc2, p_m, p_sigma0, p_sigma02, prop_table, smallest_divisor, status_nprops, status_ok, &
    status_props, stiffness_ratio_limit, weight_tolerance
  implicit none
  private
  public :: all_bounded, bounded, review_props, append, put_text, to_text, integer_text, piece_end

  character(len=5), parameter :: listed_names(n_listed_values) = ["n_N  ", "n_Tx ", "n_Ty ", "gamma"]

contains

  !> Length of the text of a number.
  pure function text_length(value) result(length)
    real(wp), intent(in) :: value   !! any bits
    integer :: length
    character(len=32) :: text
    call write_number(value, text, length)
  end function text_length

  !> Length of the text of an integer.
  pure function integer_length(value) result(length)
    integer, intent(in) :: value   !! any
    integer :: length
    character(len=12) :: text
    write (text, "(i0)") value
    length = len_trim(text)
  end function integer_length

  !> Copy a text to where it has a fixed length; one that is longer ends with " ...".
  pure subroutine put_text(text, buffer)
    character(len=*), intent(in) :: text      !! what to copy
    character(len=*), intent(out) :: buffer   !! padded with blanks
    character(len=*), parameter :: mark = " ..."
    buffer = text
    if (len(text) > len(buffer)) buffer(len(buffer) - len(mark) + 1:) = mark
  end subroutine put_text

  !> Shortest text of a number that reads back the same, without an exponent where that is easily read.
  pure function to_text(value) result(text)
    real(wp), intent(in) :: value   !! any bits
    character(len=text_length(value)) :: text
    integer :: length
    ! results of deferred length have their length in static memory with gfortran: two threads would share it
    call write_number(value, text, length)
  end function to_text

  !> Text of an integer.
  pure function integer_text(value) result(text)
    integer, intent(in) :: value   !! any
    character(len=integer_length(value)) :: text
    write (text, "(i0)") value
  end function integer_text

  !> Write a number as `to_text` does.
  pure subroutine write_number(value, text, length)
    real(wp), intent(in) :: value              !! any bits
    character(len=*), intent(out) :: text      !! the number, then blanks
    integer, intent(out) :: length             !! characters of the number
    character(len=26) :: buffer
    character(len=12) :: style
    character(len=17) :: digits
    character(len=1) :: sign
    real(wp) :: back
    integer(int64), parameter :: infinity_bits = int(z"7FF0000000000000", int64)
    integer :: exponent, n

    if (.not. bounded(value, huge(1.0_wp))) then
      text = "NaN"
      if (transfer(value, 0_int64) == infinity_bits) text = "Inf"
      if (transfer(-value, 0_int64) == infinity_bits) text = "-Inf"
    else if (.not. abs(value) > 0.0_wp) then
      text = "0"
    else
      ! fewer digits of the largest numbers may round up beyond the range
      do n = merge(1, 17, abs(value) < 1.0e300_wp), 17
        write (style, "(a, i0, a)") "(es26.", n - 1, "e3)"
        write (buffer, style) abs(value)
        read (buffer, "(f26.0)") back
        if (.not. abs(back - abs(value)) > 0.0_wp) exit
      end do
      n = min(n, 17)
      buffer = adjustl(buffer)
      digits = buffer(1:1) // buffer(3:)
      read (buffer(index(buffer, "E") + 1:), "(i5)") exponent
      sign = merge("-", " ", value < 0.0_wp)
      if (exponent < -5 .or. exponent > 8) then
        write (buffer, "(i0)") exponent
        if (n > 1) then
          text = trim(sign) // digits(1:1) // "." // digits(2:n) // "e" // trim(buffer)
        else
          text = trim(sign) // digits(1:1) // "e" // trim(buffer)
        end if
      else if (exponent < 0) then
        text = trim(sign) // "0." // repeat("0", -exponent - 1) // digits(:n)
      else if (n <= exponent + 1) then
        text = trim(sign) // digits(:n) // repeat("0", exponent + 1 - n)
      else
        text = trim(sign) // digits(:exponent + 1) // "." // digits(exponent + 2:n)
      end if
    end if
    length = len_trim(text)
  end subroutine write_number

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
  pure subroutine review_props(props, status, message, nprops)
    real(wp), intent(in), contiguous :: props(:)                    !! PROPS, any number of values
    integer, intent(out) :: status                                  !! 0, status_props or status_nprops
    character(len=:), allocatable, intent(inout), optional :: message   !! one line per bad value is appended
    integer, intent(in), optional :: nprops                         !! NPROPS as the caller passed it, where it may be
                                                                    !! negative: the array then has size 0
    real(wp) :: ratio, total
    integer :: given, i, j, k, m

    given = size(props)
    if (present(nprops)) given = nprops
    status = status_ok
    m = 0
    if (fixed_props_admissible(props)) then
      if (size(props) >= p_m) m = int(props(p_m))
    else
      if (size(props) < n_required_props) then
        status = status_nprops
        if (present(message)) call append(message, "NPROPS = " // integer_text(given) // &
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
    !> Entries with a rule besides their range.
    integer, parameter :: special(*) = [integral_props, divisor_props]
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
    do i = 1, size(special)
      if (yes .and. n >= special(i)) yes = prop_admissible(special(i), props(special(i)))
    end do
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
    if (yes .and. any(i == divisor_props)) yes = value >= smallest_divisor .or. .not. value > 0.0_wp
    if (yes .and. any(i == integral_props)) yes = abs(value - real(int(value), wp)) <= 0.0_wp
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

  !> Add a line to a message.
  pure subroutine append(message, line)
    character(len=:), allocatable, intent(inout) :: message   !! lines so far, or not allocated
    character(len=*), intent(in) :: line                      !! the new line
    if (.not. allocated(message)) then
      message = line
    else if (len(message) == 0) then
      message = line
    else
      message = message // new_line("a") // line
    end if
  end subroutine append

  !> Last character of the piece of a message that begins at `first`: its line, or as much of it as goes into a text.
  pure function piece_end(message, first, limit) result(last)
    character(len=*), intent(in) :: message   !! lines
    integer, intent(in) :: first              !! first character, from 1
    integer, intent(in) :: limit              !! characters that go into a text
    integer :: last
    last = index(message(first:), new_line("a"))
    last = merge(len(message), first + last - 2, last == 0)
    last = min(last, first + limit - 1)
  end function piece_end

end module asperity_checks
