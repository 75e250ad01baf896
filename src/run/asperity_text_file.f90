!> Text files: their bytes, lines, words and numbers.
module asperity_text_file
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_kinds, only: wp
  use asperity_separators, only: has_drives, separators
  use asperity_text, only: integer_text
  implicit none
  private
  public :: accept_bytes, beside, last_before, last_separator, load_file, lower, printable, split, to_real

  character(len=*), parameter, public :: newline = achar(10)
  character(len=*), parameter, public :: blanks = " " // achar(9) // newline // achar(13)
  !> Longest field of a line that is distinguished; no number is longer.
  integer, parameter, public :: longest_field = 80
  !> Binary digits of a double.
  integer, parameter :: digits_of_double = digits(1.0_wp)
  !> Largest file that is read, bytes.
  integer, parameter :: largest_file = 100000000

contains

  !> Read the bytes of a text file.
  subroutine load_file(path, source, errors)
    character(len=*), intent(in) :: path                      !! file
    character(len=:), allocatable, intent(inout) :: source    !! its bytes
    type(errors_type), intent(inout) :: errors                !! errors are added
    character(len=200) :: reason
    type(error_type) :: place
    integer :: unit, status, bytes

    place%file = path
    open (newunit=unit, file=path, access="stream", form="unformatted", action="read", status="old", &
      iostat=status, iomsg=reason)
    if (status /= 0) then
      call fail(errors, place, "cannot be opened: " // trim(reason))
      return
    end if
    inquire (unit=unit, size=bytes)
    if (bytes < 1 .or. bytes > largest_file) then
      call fail(errors, place, integer_text(bytes) // " bytes: expected a case file of 1 to " // &
        integer_text(largest_file) // " bytes")
      close (unit)
      return
    end if
    deallocate (source)
    allocate (character(len=bytes) :: source)
    read (unit, iostat=status, iomsg=reason) source
    close (unit)
    if (status /= 0) then
      call fail(errors, place, "cannot be read: " // trim(reason))
      return
    end if
    call accept_bytes(path, source, errors)
  end subroutine load_file

  !> Blank out the byte-order mark of an editor, end each line by a newline, also where a CR alone ends it, and add an
  !> error for the first byte that a text file does not have.
  pure subroutine accept_bytes(path, source, errors)
    character(len=*), intent(in) :: path                      !! file, or the name of the text
    character(len=:), allocatable, intent(inout) :: source    !! its bytes
    type(errors_type), intent(inout) :: errors                !! errors are added
    type(error_type) :: place
    integer :: i, line
    if (len(source) >= 3) then
      if (source(1:3) == char(239) // char(187) // char(191)) source(1:3) = ""
    end if
    place%file = path
    line = 1
    do i = 1, len(source)
      if (source(i:i) == achar(13) .and. source(i + 1:min(i + 1, len(source))) /= newline) source(i:i) = newline
      if (source(i:i) == newline) line = line + 1
      if ((iachar(source(i:i)) < 32 .and. scan(source(i:i), blanks) == 0) .or. iachar(source(i:i)) == 127) then
        place%line = line
        call fail(errors, place, "byte " // integer_text(iachar(source(i:i))) // ": expected a text file")
        return
      end if
    end do
  end subroutine accept_bytes

  !> Last position before a character of a set, or of the text; i - 1 if this character is at i.
  pure function last_before(set, source, i) result(last)
    character(len=*), intent(in) :: set      !! characters
    character(len=*), intent(in) :: source   !! text
    integer, intent(in) :: i                 !! first position
    integer :: last
    last = scan(source(i:), set)
    last = merge(i + last - 2, len(source), last > 0)
  end function last_before

  !> Fields of a line, which commas separate.
  pure subroutine split(line, list)
    character(len=*), intent(in) :: line                                  !! text
    character(len=longest_field), allocatable, intent(out) :: list(:)     !! its fields
    character(len=len(line)) :: clean
    integer :: first, i, last
    clean = line
    do i = 1, len(line)
      if (scan(line(i:i), blanks) > 0) clean(i:i) = " "
    end do
    allocate (list(count([(line(i:i) == ",", i=1, len(line))]) + 1))
    first = 1
    do i = 1, size(list)
      last = first + index(clean(first:) // ",", ",") - 2
      list(i) = adjustl(clean(first:last))
      first = last + 2
    end do
  end subroutine split

  !> Start of a text, with a question mark for each character that is not ASCII.
  pure function printable(piece) result(clean)
    character(len=*), intent(in) :: piece   !! text
    character(len=:), allocatable :: clean
    integer, parameter :: most = 60
    integer :: i
    clean = piece(:min(len(piece), most))
    do i = 1, len(clean)
      if (iachar(clean(i:i)) < 32 .or. iachar(clean(i:i)) > 126) clean(i:i) = "?"
    end do
    clean = trim(clean)
    if (len(piece) > most) clean = clean // "..."
  end function printable

  !> A text in lower case.
  pure function lower(name) result(low)
    character(len=*), intent(in) :: name   !! any case
    character(len=len(name)) :: low
    integer :: i
    low = name
    do i = 1, len(name)
      if (name(i:i) >= "A" .and. name(i:i) <= "Z") low(i:i) = achar(iachar(name(i:i)) + 32)
    end do
  end function lower

  !> Read a finite number: decimal, with or without exponent, or hexadecimal as %a and %A of C and float.hex of Python
  !> write it, which is exact and quick; every other text is rejected.
  pure subroutine to_real(word, value, good)
    character(len=*), intent(in) :: word   !! without blanks
    real(wp), intent(out) :: value         !! 0 if it is no number
    logical, intent(out) :: good           !! whether it is one
    integer, parameter :: longest = 60
    character(len=longest + 8) :: number
    integer :: e, exponent, status

    if (scan(word(:min(3, len(word))), "xX") > 0) then
      call hexadecimal(word, value, good)
      return
    end if
    value = 0.0_wp
    exponent = 0
    e = scan(word // "e", "eEdD")
    good = len(word) <= longest .and. is_number(word(:e - 1), 1)
    if (good .and. e <= len(word)) then
      good = len(word) - e <= 5 .and. is_number(word(e + 1:), 0)
      if (good) read (word(e + 1:), "(i8)") exponent
    end if
    ! rejected before it is read, as an overflow would raise a floating-point exception
    if (good) good = is_finite(word(:e - 1), exponent)
    if (.not. good) return
    number = word(:e - 1) // "e" // integer_text(exponent)
    read (number, "(f68.0)", iostat=status) value
    good = status == 0
  end subroutine to_real

  !> Read a hexadecimal number in any case: a sign, 0x, up to 14 digits with or without a point, p, and the exponent
  !> of 2. One that overflows, or that no double is exactly, is rejected from its exponent, without a floating-point
  !> exception.
  pure subroutine hexadecimal(word, value, good)
    character(len=*), intent(in) :: word   !! without blanks
    real(wp), intent(out) :: value         !! 0 if it is no number
    logical, intent(out) :: good           !! whether it is one, which a double has exactly
    integer, parameter :: most_digits = 14
    integer, parameter :: least_power = minexponent(value) - digits_of_double   ! of the least number above zero
    integer(int64) :: mantissa
    integer :: digit, exponent, first, i, n, p, power
    logical :: fraction
    value = 0.0_wp
    first = 1 + min(1, scan(word(:1), "+-"))
    p = scan(word, "pP")
    good = any(word(first:min(first + 1, len(word))) == ["0x", "0X"]) .and. p > first + 2
    if (good) good = len(word) - p <= 5 .and. is_number(word(p + 1:), 0)
    if (.not. good) return
    mantissa = 0_int64
    power = 0
    n = 0
    fraction = .false.
    do i = first + 2, p - 1
      if (word(i:i) == "." .and. .not. fraction) then
        fraction = .true.
        cycle
      end if
      n = n + 1
      select case (word(i:i))
      case ("0":"9")
        digit = iachar(word(i:i)) - iachar("0")
      case ("a":"f")
        digit = iachar(word(i:i)) - iachar("a") + 10
      case ("A":"F")
        digit = iachar(word(i:i)) - iachar("A") + 10
      case default
        good = .false.
      end select
      good = good .and. n <= most_digits
      if (.not. good) return
      mantissa = 16_int64*mantissa + int(digit, int64)
      if (fraction) power = power - 4
    end do
    exponent = 0
    do i = verify(word(p + 1:), "+-") + p, len(word)
      exponent = 10*exponent + iachar(word(i:i)) - iachar("0")
    end do
    if (word(p + 1:p + 1) == "-") exponent = -exponent
    power = power + exponent
    good = n > 0 .and. mantissa < 2_int64**digits_of_double
    if (good .and. mantissa > 0_int64) then
      good = bit_size(mantissa) - leadz(mantissa) + power <= maxexponent(value) .and. &
        trailz(mantissa) + power >= least_power
      if (good) value = scale(real(mantissa, wp), power)
    end if
    if (good .and. word(1:1) == "-") value = -value
  end subroutine hexadecimal

  !> Whether a word is an optional sign, digits, and up to a number of decimal points.
  pure function is_number(word, points) result(yes)
    character(len=*), intent(in) :: word   !! text
    integer, intent(in) :: points          !! 0 or 1
    logical :: yes
    integer :: first, i
    first = 1 + min(1, scan(word(:min(1, len(word))), "+-"))
    yes = verify(word(first:), "0123456789.") == 0 .and. scan(word, "0123456789") > 0 .and. &
      count([(word(i:i) == ".", i=1, len(word))]) <= points
  end function is_number

  !> Whether a decimal number is not above the largest double.
  pure function is_finite(mantissa, exponent) result(yes)
    character(len=*), intent(in) :: mantissa   !! digits, with or without a sign and a point
    integer, intent(in) :: exponent            !! of 10
    logical :: yes
    character(len=*), parameter :: largest = "17976931348623157"   !! its digits
    integer, parameter :: power = 308                              !! of 10, of the first one
    character(len=len(largest)) :: digits
    integer :: first, i, n, point
    first = scan(mantissa, "123456789")
    yes = first == 0
    if (yes) return
    point = index(mantissa // ".", ".")
    ! the power of 10 of the first digit that is not zero
    n = exponent + point - merge(first + 1, first, first < point)
    yes = n < power
    if (n /= power) return
    digits = repeat("0", len(digits))
    n = 0
    do i = first, len(mantissa)
      if (i == point .or. n == len(digits)) cycle
      n = n + 1
      digits(n:n) = mantissa(i:i)
    end do
    yes = digits <= largest
  end function is_finite

  !> Name of a file that lies beside another one unless its path is whole.
  pure function beside(path, name) result(whole)
    character(len=*), intent(in) :: path   !! of the other file
    character(len=*), intent(in) :: name   !! of the file
    character(len=:), allocatable :: whole
    logical :: drive
    drive = has_drives .and. index(name, ":") == 2
    whole = name
    if (scan(name, separators) /= 1 .and. .not. drive) whole = path(:last_separator(path)) // name
  end function beside

  !> Position of the last character between folders in a path; 0: it has none.
  pure function last_separator(path) result(at)
    character(len=*), intent(in) :: path   !! of a file
    integer :: at
    at = scan(path, separators, back=.true.)
  end function last_separator

end module asperity_text_file
