!> Texts of any length that the extension hands to Python.
module text_handles
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc, c_null_ptr
  implicit none
  private
  public :: new_handle, take

  !> A text.
  type :: text_type
    character(len=:), allocatable :: text
  end type text_type

contains

  !> Keep a text until it is taken.
  subroutine new_handle(text, handle, length)
    character(len=*), intent(in) :: text   !! the text
    integer, intent(out) :: handle(2)      !! its address
    integer, intent(out) :: length         !! its bytes
    type(text_type), pointer :: kept
    allocate (kept)
    kept%text = text
    handle = transfer(c_loc(kept), handle)
    length = len(text)
  end subroutine new_handle

  !> Hand out a text and free it.
  subroutine take(handle, text)
    integer, intent(in) :: handle(2)               !! of new_handle
    character(len=1), intent(inout) :: text(:)     !! as long as the text
    type(text_type), pointer :: kept
    integer :: i
    call c_f_pointer(transfer(handle, c_null_ptr), kept)
    do i = 1, min(size(text), len(kept%text))
      text(i) = kept%text(i:i)
    end do
    deallocate (kept)
  end subroutine take

end module text_handles
