!> Work in a child process that sends rows of numbers (umat_worker.c).
module asperity_umat_worker
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_funptr, c_int, c_null_char, c_ptr
  use asperity_kinds, only: wp
  implicit none
  private
  public :: start_worker, receive_row, end_worker, fail_worker, send_row, leave_notes, c_text

  !> Numbers of the notes of a child.
  integer, parameter, public :: n_notes = 16
  !> Longest text, of which a child leaves at most 1000 characters.
  integer, parameter :: longest = 2000

  ! a process has one child at a time
  interface
    !> Begin a piece of work, a C function with the address of the data, in a child, which has a copy of the data, with
    !> the longest time for an increment (s).
    subroutine start_worker(work, data, limit) bind(c, name="umat_worker_start")
      import :: c_double, c_funptr, c_ptr
      implicit none
      type(c_funptr), value :: work
      type(c_ptr), value :: data
      real(c_double), value :: limit
    end subroutine start_worker
    !> Wait for the next row; 0: the child has ended.
    function receive_row(numbers, n) bind(c, name="umat_worker_receive") result(received)
      import :: c_double, c_int
      implicit none
      integer(c_int), value :: n
      real(c_double), intent(inout) :: numbers(n)
      integer(c_int) :: received
    end function receive_row
    !> End the child.
    subroutine c_end(notes, n, text, reason, length) bind(c, name="umat_worker_end")
      import :: c_char, c_double, c_int
      implicit none
      integer(c_int), value :: n, length
      real(c_double), intent(out) :: notes(n)
      character(kind=c_char), intent(inout) :: text(length), reason(length)
    end subroutine c_end
    !> Send a row from a child, of the length that the parent receives.
    subroutine send_row(numbers, n) bind(c, name="umat_worker_send")
      import :: c_double, c_int
      implicit none
      integer(c_int), value :: n
      real(c_double), intent(in) :: numbers(n)
    end subroutine send_row
    !> End this process, which is a child, with a reason, which ends with c_null_char.
    subroutine fail_worker(reason) bind(c, name="umat_worker_fail")
      import :: c_char
      implicit none
      character(kind=c_char), intent(in) :: reason(*)
    end subroutine fail_worker
    !> Leave up to n_notes numbers and a text from a child; they replace earlier ones. The text ends with c_null_char,
    !> and is cut if it is too long.
    subroutine leave_notes(numbers, n, text) bind(c, name="umat_worker_note")
      import :: c_char, c_double, c_int
      implicit none
      integer(c_int), value :: n
      real(c_double), intent(in) :: numbers(n)
      character(kind=c_char), intent(in) :: text(*)
    end subroutine leave_notes
  end interface

contains

  !> End a child that still works, and take what it left.
  subroutine end_worker(failure, text, notes)
    character(len=:), allocatable, intent(out) :: failure   !! why the work is not complete, with the increment; empty:
                                                            !! it is
    character(len=:), allocatable, intent(out) :: text      !! of its notes
    real(wp), intent(out) :: notes(n_notes)                 !! their numbers
    character(kind=c_char) :: left(longest), reason(longest)
    call c_end(notes, n_notes, left, reason, longest)
    text = c_text(left)
    failure = c_text(reason)
  end subroutine end_worker

  !> Text of C up to its end.
  pure function c_text(buffer) result(text)
    character(kind=c_char), intent(in) :: buffer(:)   !! characters
    character(len=:), allocatable :: text
    integer :: i
    text = ""
    do i = 1, size(buffer)
      if (buffer(i) == c_null_char) exit
      text = text // buffer(i)
    end do
  end function c_text

end module asperity_umat_worker
