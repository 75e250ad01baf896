!> Texts of messages: numbers, lines, and pieces of a fixed length.
module asperity_text
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_kinds, only: wp
  implicit none
  private
  public :: append, set_text, put_text, to_text, short, integer_text, piece_end

contains

  !> A number rounded to six digits.
  pure function six_digits(value) result(rounded)
    real(wp), intent(in) :: value   !! finite
    real(wp) :: rounded
    character(len=16) :: buffer
    write (buffer, "(es16.5e3)") value
    read (buffer, "(f16.0)") rounded
  end function six_digits

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

  !> Copy a text into a variable of fixed length; a text that does not fit is cut and ends with " ...".
  pure subroutine put_text(text, buffer)
    character(len=*), intent(in) :: text      !! what to copy
    character(len=*), intent(out) :: buffer   !! padded with blanks
    character(len=*), parameter :: mark = " ..."
    buffer = text
    if (len(text) > len(buffer)) buffer(len(buffer) - len(mark) + 1:) = mark
  end subroutine put_text

  !> Shortest text of a number that reads back as the same number; an exponent is used only for large and small numbers.
  pure function to_text(value) result(text)
    real(wp), intent(in) :: value   !! any bits
    character(len=text_length(value)) :: text
    integer :: length
    ! not a result of deferred length: gfortran stores its length in static memory, which threads would share
    call write_number(value, text, length)
  end function to_text

  !> Text of a number with six digits, for a message.
  pure function short(value) result(text)
    real(wp), intent(in) :: value   !! finite
    character(len=text_length(six_digits(value))) :: text
    integer :: length
    call write_number(six_digits(value), text, length)
  end function short

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
    integer(int64) :: magnitude
    integer :: exponent, first, n

    magnitude = iand(transfer(value, 0_int64), huge(0_int64))
    if (magnitude >= infinity_bits) then
      ! test the bits: a comparison of NaN would raise a floating-point exception
      text = "NaN"
      if (magnitude == infinity_bits) text = merge("-Inf", "Inf ", transfer(value, 0_int64) < 0_int64)
    else if (.not. abs(value) > 0.0_wp) then
      text = "0"
    else
      ! A number of up to 15 digits is the one that 15 digits show, then zeros. Near the smallest numbers this does not
      ! hold, and with fewer than 17 digits the largest ones may round up beyond the range.
      first = merge(merge(15, 17, abs(value) < 1.0e300_wp), 1, abs(value) > 1.0e-300_wp)
      do n = first, 17
        write (style, "(a, i0, a)") "(es26.", n - 1, "e3)"
        write (buffer, style) abs(value)
        read (buffer, "(f26.0)") back
        if (.not. abs(back - abs(value)) > 0.0_wp) exit
      end do
      n = min(n, 17)
      buffer = adjustl(buffer)
      digits = buffer(1:1) // buffer(3:)
      if (n == 15) n = max(1, verify(digits(:n), "0", back=.true.))
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

  !> Add a line to a message.
  pure subroutine append(message, line)
    character(len=:), allocatable, intent(inout) :: message   !! lines so far, or not allocated
    character(len=*), intent(in) :: line                      !! the new line
    if (.not. allocated(message)) then
      call set_text(message, line)
    else if (len(message) == 0) then
      call set_text(message, line)
    else
      call set_text(message, message // new_line("a") // line)
    end if
  end subroutine append

  !> Give a text a new value and its length.
  !>
  !> It stands for an assignment, which would allocate the text anew: Intel's -nostandard-realloc-lhs switches that off,
  !> and Abaqus is run with this option where its own run-time library is older than the compiler.
  pure subroutine set_text(text, value)
    character(len=:), allocatable, intent(inout) :: text   !! any, or not allocated
    character(len=*), intent(in) :: value                  !! an expression, not the variable itself
    character(len=:), allocatable :: new
    allocate (character(len=len(value)) :: new)
    new(:) = value
    call move_alloc(new, text)
  end subroutine set_text

  !> Last character of the piece of a message that begins at `first`: the end of its line, or of what fits into `limit`.
  pure function piece_end(message, first, limit) result(last)
    character(len=*), intent(in) :: message   !! lines
    integer, intent(in) :: first              !! first character, from 1
    integer, intent(in) :: limit              !! largest number of characters of a piece
    integer :: last
    last = index(message(first:), new_line("a"))
    last = merge(len(message), first + last - 2, last == 0)
    last = min(last, first + limit - 1)
  end function piece_end

end module asperity_text
