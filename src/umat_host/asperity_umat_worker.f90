!> Work in a child process that sends rows of numbers (umat_worker.c).
module asperity_umat_worker
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_funptr, c_int, c_null_char, c_null_ptr, c_ptr
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text
  implicit none
  private
  public :: start_worker, receive_row, end_worker, send_row, leave_notes, c_text

  !> Numbers of the notes of a child.
  integer, parameter, public :: n_notes = 16
  !> Longest text, of which a child leaves at most 1000 characters.
  integer, parameter, public :: longest = 2000

  !> A child, as its parent knows it.
  type, public :: worker_type
    type(c_ptr), private :: handle = c_null_ptr
    character(len=:), allocatable :: failure   !! why the work is not complete, with the increment; empty: it is
    character(len=:), allocatable :: text      !! that the child left
    real(wp) :: notes(n_notes) = 0.0_wp        !! that the child left
  end type worker_type

  interface
    !> Begin the work.
    function c_start(work, data, limit) bind(c, name="umat_worker_start") result(handle)
      import :: c_double, c_funptr, c_ptr
      implicit none
      type(c_funptr), value :: work
      type(c_ptr), value :: data
      real(c_double), value :: limit
      type(c_ptr) :: handle
    end function c_start
    !> Wait for a row.
    function c_receive(handle, numbers, n) bind(c, name="umat_worker_receive") result(found)
      import :: c_double, c_int, c_ptr
      implicit none
      type(c_ptr), value :: handle
      integer(c_int), value :: n
      real(c_double), intent(out) :: numbers(n)
      integer(c_int) :: found
    end function c_receive
    !> End the child.
    subroutine c_end(handle, n, notes, counts, text, reason, length) bind(c, name="umat_worker_end")
      import :: c_char, c_double, c_int, c_ptr
      implicit none
      type(c_ptr), value :: handle
      integer(c_int), value :: n, length
      real(c_double), intent(out) :: notes(n)
      integer(c_int), intent(out) :: counts(2)
      character(kind=c_char), intent(inout) :: text(length), reason(length)
    end subroutine c_end
    !> Send a row from a child, of the length that the parent receives.
    subroutine send_row(numbers, n) bind(c, name="umat_worker_send")
      import :: c_double, c_int
      implicit none
      integer(c_int), value :: n
      real(c_double), intent(in) :: numbers(n)
    end subroutine send_row
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

  !> Begin a piece of work in a child, which has a copy of the data.
  subroutine start_worker(work, data, limit, worker)
    type(c_funptr), value :: work                !! C function with the address of the data
    type(c_ptr), value :: data                   !! address
    real(wp), intent(in) :: limit                !! longest time without a new increment, s
    type(worker_type), intent(out) :: worker     !! the child
    worker%handle = c_start(work, data, limit)
    worker%failure = ""
    worker%text = ""
    if (.not. c_associated(worker%handle)) worker%failure = "no process could be started"
  end subroutine start_worker

  !> Wait for the next row of a child.
  subroutine receive_row(worker, numbers, found)
    type(worker_type), intent(inout) :: worker   !! the child
    real(wp), intent(inout) :: numbers(:)        !! all rows have this length
    logical, intent(out) :: found                !! false: the child has ended
    found = c_associated(worker%handle)
    if (found) found = c_receive(worker%handle, numbers, size(numbers)) /= 0
  end subroutine receive_row

  !> End a child that still works, and take what it left.
  subroutine end_worker(worker)
    type(worker_type), intent(inout) :: worker   !! the child -> its notes
    character(kind=c_char) :: text(longest), reason(longest)
    integer(c_int) :: counts(2)
    if (.not. c_associated(worker%handle)) return
    call c_end(worker%handle, n_notes, worker%notes, counts, text, reason, longest)
    worker%handle = c_null_ptr
    worker%text = c_text(text)
    worker%failure = c_text(reason)
    if (len(worker%failure) == 0 .or. counts(1) < 0) return
    if (counts(1) == 0) then
      worker%failure = "at the start of the path " // worker%failure
    else
      worker%failure = "in step " // integer_text(counts(1)) // " increment " // integer_text(counts(2)) // " " // &
        worker%failure
    end if
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
