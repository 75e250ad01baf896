!> Errors of input as records: where they are, the value, and what was expected. One procedure words them.
module asperity_errors
  use asperity_text, only: append, integer_text, set_text
  implicit none
  private
  public :: fail, sort_lines, word, put_words

  !> An error, or the place of one. What is not allocated, or is negative, is not known.
  type, public :: error_type
    character(len=:), allocatable :: file     !! in which it is
    integer :: line = -1                      !! of the file, from 1
    character(len=:), allocatable :: group    !! of a case file, or the argument that stands for it
    integer :: step = -1                      !! of the load path, from 0
    character(len=:), allocatable :: name     !! of the value
    integer :: at = -1                        !! position of the bad value in a list, from 0
    character(len=:), allocatable :: value    !! the value, or the values, as given
    character(len=:), allocatable :: text     !! what is wrong or what was expected
  end type error_type

  !> Errors in the order in which they were found.
  type, public :: errors_type
    integer :: n = 0                              !! their number
    type(error_type), allocatable :: list(:)      !! at least n
  end type errors_type

contains

  !> Add an error for each line of a text.
  pure subroutine fail(errors, place, text)
    type(errors_type), intent(inout) :: errors   !! the errors so far
    type(error_type), intent(in) :: place        !! where they are
    character(len=*), intent(in) :: text         !! what is wrong or what was expected, separated by line ends
    type(error_type), allocatable :: longer(:)
    integer :: first, i, length
    first = 1
    do while (first <= len(text))
      length = index(text(first:) // new_line("a"), new_line("a")) - 1
      if (.not. allocated(errors%list)) allocate (errors%list(8))
      if (errors%n == size(errors%list)) then
        allocate (longer(2*errors%n))
        do i = 1, errors%n
          longer(i) = errors%list(i)
        end do
        call move_alloc(longer, errors%list)
      end if
      errors%n = errors%n + 1
      errors%list(errors%n) = place
      call set_text(errors%list(errors%n)%text, text(first:first + length - 1))
      first = first + length + 1
    end do
  end subroutine fail

  !> Sort errors by the lines where they are; those of one line keep their order.
  pure subroutine sort_lines(errors)
    type(errors_type), intent(inout) :: errors   !! the errors
    type(error_type), allocatable :: sorted(:)
    integer :: order(errors%n), i
    if (errors%n < 2) return
    order = [(i, i=1, errors%n)]
    call merge_sort(errors%list(:errors%n)%line, order)
    allocate (sorted(errors%n))
    do i = 1, errors%n
      sorted(i) = errors%list(order(i))
    end do
    call move_alloc(sorted, errors%list)
  end subroutine sort_lines

  !> Order in which numbers ascend; equal ones keep their order (stable merge sort, from pairs upwards).
  pure subroutine merge_sort(numbers, order)
    integer, intent(in) :: numbers(:)    !! what is sorted
    integer, intent(inout) :: order(:)   !! positions in their order -> sorted
    integer :: before(size(order))
    integer :: first, i, j, k, last, middle, width
    width = 1
    do while (width < size(order))
      before = order
      do first = 1, size(order), 2*width
        middle = min(first + width, size(order) + 1)
        last = min(first + 2*width - 1, size(order))
        i = first
        j = middle
        do k = first, last
          if (i < middle) then
            if (j > last) then
              order(k) = before(i)
              i = i + 1
              cycle
            else if (numbers(before(i)) <= numbers(before(j))) then
              order(k) = before(i)
              i = i + 1
              cycle
            end if
          end if
          order(k) = before(j)
          j = j + 1
        end do
      end do
      width = 2*width
    end do
  end subroutine merge_sort

  !> Words of an error: file:line: group: name = value: text.
  pure subroutine word(error, text)
    type(error_type), intent(in) :: error                  !! the error
    character(len=:), allocatable, intent(inout) :: text   !! its words
    call set_text(text, "")
    if (allocated(error%file)) call set_text(text, error%file)
    if (error%line >= 0) call set_text(text, text // ":" // integer_text(error%line))
    if (len(text) > 0) call set_text(text, text // ": ")
    if (allocated(error%group)) call set_text(text, text // error%group // ": ")
    if (allocated(error%name)) then
      call set_text(text, text // error%name)
      if (error%at >= 0) call set_text(text, text // "[" // integer_text(error%at) // "]")
      if (allocated(error%value)) call set_text(text, text // " = " // error%value)
      call set_text(text, text // ": ")
    end if
    if (allocated(error%text)) call set_text(text, text // error%text)
  end subroutine word

  !> Append the words of all errors, a line for each.
  pure subroutine put_words(errors, text)
    type(errors_type), intent(in) :: errors                !! the errors
    character(len=:), allocatable, intent(inout) :: text   !! lines are appended
    character(len=:), allocatable :: line, lines
    integer :: i, n
    ! the room doubles: lines that are appended one by one would copy the whole text each time
    allocate (character(len=256) :: lines)
    n = 0
    do i = 1, errors%n
      call word(errors%list(i), line)
      if (n + len(line) + 1 > len(lines)) call set_text(lines, lines // repeat(" ", n + len(line) + 1))
      lines(n + 1:n + len(line) + 1) = line // new_line("a")
      n = n + len(line) + 1
    end do
    if (n > 0) call append(text, lines(:n - 1))
  end subroutine put_words

end module asperity_errors
