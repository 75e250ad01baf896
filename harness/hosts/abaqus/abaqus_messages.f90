!> Record of the calls of Abaqus' utility routines. The routines of Abaqus end the analysis; these only count.
module abaqus_messages
  implicit none
  private
  public :: clear_messages, keep_message, standard, explicit

  !> Messages of one solver since `clear_messages`.
  type, public :: messages_type
    integer :: n = 0                               !! calls of the message routine
    integer :: ends = 0                            !! calls of XIT or XPLB_EXIT
    integer :: late = 0                            !! messages after the first call of XIT or XPLB_EXIT
    integer :: lop = 0                             !! kind of the last message
    integer :: length = 0                          !! length of the longest text
    logical :: formats = .false.                   !! whether a text had a percent sign, which Abaqus replaces
    character(len=:), allocatable :: text          !! all texts, a line each
  end type messages_type

  type(messages_type) :: standard, explicit

contains

  !> Forget all messages.
  subroutine clear_messages()
    standard = messages_type()
    explicit = messages_type()
    standard%text = ""
    explicit%text = ""
  end subroutine clear_messages

  !> Record one message.
  subroutine keep_message(messages, lop, text)
    type(messages_type), intent(inout) :: messages   !! of the solver
    integer, intent(in) :: lop                       !! kind
    character(len=*), intent(in) :: text             !! as passed
    messages%n = messages%n + 1
    messages%lop = lop
    messages%length = max(messages%length, len(text))
    if (messages%ends > 0) messages%late = messages%late + 1
    if (index(text, "%") > 0) messages%formats = .true.
    messages%text = messages%text // trim(text) // new_line("a")
  end subroutine keep_message

end module abaqus_messages
