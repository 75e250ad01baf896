!> Texts of C: strings that a zero ends.
module asperity_c_text
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_null_char, c_ptr, c_size_t
  implicit none
  private
  public :: get_text, put_text

  interface
    !> Characters of a C string.
    function strlen(string) bind(C) result(length)
      import :: c_ptr, c_size_t
      implicit none
      type(c_ptr), value :: string   !! not NULL
      integer(c_size_t) :: length
    end function strlen
  end interface

contains

  !> Copy a C string.
  subroutine get_text(string, text)
    type(c_ptr), intent(in) :: string                         !! ended by a zero; NULL: ""
    character(len=:), allocatable, intent(inout) :: text      !! its characters
    character(kind=c_char), pointer, contiguous :: chars(:)
    integer :: i, length
    length = 0
    if (c_associated(string)) length = int(strlen(string))
    if (allocated(text)) deallocate (text)
    allocate (character(len=length) :: text)
    if (length == 0) return
    call c_f_pointer(string, chars, [length])
    do i = 1, length
      text(i:i) = chars(i)
    end do
  end subroutine get_text

  !> Copy a text into a C buffer; a text that does not fit is cut, and a zero ends it always.
  subroutine put_text(text, buffer, size)
    character(len=*), intent(in) :: text   !! what to copy
    type(c_ptr), intent(in) :: buffer      !! char[size], may be NULL
    integer(c_int), intent(in) :: size     !! bytes of the buffer
    character(kind=c_char), pointer :: chars(:)
    integer :: i, last
    if (.not. c_associated(buffer) .or. size < 1) return
    call c_f_pointer(buffer, chars, [size])
    last = min(len(text), size - 1)
    do i = 1, last
      chars(i) = text(i:i)
    end do
    chars(last + 1) = c_null_char
  end subroutine put_text

end module asperity_c_text
