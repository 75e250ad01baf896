!> Output of a case as JSON, with all defaults; other programs read this instead of the case file.
!>
!> The case has `title`, `sweep` (its name, empty without one), `pattern` (the first and last byte of the group &pattern
!> in the file, from 1) and `runs`. A run has `value` (that of the sweep, null without one), `tolerance` (0: none),
!> `start` (virgin, or the group initial or state that gives another start, with its `separation`, `statev` and `work`),
!> `props` (PROPS) and `steps`, of which a replay has none.
!>
!> A step has the entries of &step that give the same path: lists with all cycles, `increments` and `time` of each
!> target, and k_N, k_Tx, k_Ty wherever the traction is prescribed.
module case_echo
  use asperity_text, only: integer_text, to_text
  use asperity_kinds, only: wp
  use asperity_steps, only: component_names, step_type
  use case_file, only: case_type
  use case_text, only: group_index, text_type
  use row_file, only: create_file, write_line
  implicit none
  private
  public :: echo_case

  !> A text to which pieces are appended.
  type :: json_type
    character(len=:), allocatable :: room   !! doubled in length if it is too short
    integer :: length = 0                   !! number of characters of the text
  end type json_type

contains

  !> Print a case and the runs of its sweep.
  subroutine echo_case(text, sweep, values, cases, good)
    type(text_type), intent(in) :: text          !! the file
    character(len=*), intent(in) :: sweep        !! name of the sweep, empty: none
    real(wp), intent(in) :: values(:)            !! of the sweep, size 0: none
    type(case_type), intent(in) :: cases(:)      !! the runs
    logical, intent(out) :: good                 !! false: it cannot be written; the reason is on standard error
    type(json_type) :: json
    character(len=:), allocatable :: start, value
    integer :: file, i, j
    json%room = repeat(" ", 4096)
    associate (pattern => text%groups(max(1, group_index(text, "pattern"))))
      call put(json, "{""title"": " // quoted(cases(1)%title) // ", ""sweep"": " // quoted(sweep) // &
        ", ""pattern"": [" // integer_text(pattern%from) // ", " // integer_text(pattern%to) // "], ""umat"": " // &
        trim(merge("true ", "false", cases(1)%umat%given)) // ", ""runs"": [")
    end associate
    do i = 1, size(cases)
      value = "null"
      if (size(values) > 0) value = to_text(values(i))
      start = "virgin"
      if (cases(i)%state%given) start = "state"
      if (cases(i)%initial%given) start = "initial"
      call put(json, new_line("a") // "{""value"": " // value // ", ""start"": " // quoted(start) // &
        ", ""tolerance"": " // to_text(cases(i)%tolerance) // ", ")
      if (cases(i)%state%given) then
        call put_list(json, "separation", cases(i)%state%s)
        call put_list(json, "statev", cases(i)%state%statev)
        value = "null"
        if (cases(i)%state%has_work) value = to_text(cases(i)%state%work)
        call put(json, """work"": " // value // ", ")
      end if
      call put_list(json, "props", cases(i)%props)
      call put(json, """steps"": [")
      do j = 1, size(cases(i)%steps)
        call put_step(json, cases(i)%steps(j))
        if (j < size(cases(i)%steps)) call put(json, ",")
      end do
      call put(json, "]}")
      if (i < size(cases)) call put(json, ",")
    end do
    call put(json, "]}")
    call create_file("-", file, good)
    if (good) call write_line(file, "standard output", json%room(:json%length), good)
  end subroutine echo_case

  !> Append a step.
  pure subroutine put_step(json, step)
    type(json_type), intent(inout) :: json   !! text so far
    type(step_type), intent(in) :: step      !! the step
    integer :: i
    call put(json, new_line("a") // "  {")
    if (allocated(step%slip)) then
      call put_list(json, "slip", step%slip)
      call put(json, """direction"": " // to_text(step%direction) // ", ")
    end if
    do i = 1, 3
      if (step%control%traction(i)) call put(json, """k_" // trim(component_names(i)) // """: " // &
        to_text(step%control%spring(i)) // ", ")
      if (.not. step%has_target(i) .or. (i > 1 .and. allocated(step%slip))) cycle
      call put_list(json, merge("t_", "s_", step%control%traction(i)) // trim(component_names(i)), step%targets(i, :))
    end do
    if (step%arc > 0.0_wp) then
      call put(json, """follow"": ""branch"", ""arc"": " // to_text(step%arc) // ", ")
    else
      call put_list(json, "increments", real(step%increments, wp))
    end if
    call put_list(json, "time", step%durations)
    json%length = len_trim(json%room(:json%length)) - 1   ! without the last comma
    call put(json, "}")
  end subroutine put_step

  !> Append a name, its numbers and a comma.
  pure subroutine put_list(json, name, values)
    type(json_type), intent(inout) :: json   !! text so far
    character(len=*), intent(in) :: name     !! of the list
    real(wp), intent(in) :: values(:)        !! finite
    integer :: i
    call put(json, """" // name // """: [")
    do i = 1, size(values)
      if (i > 1) call put(json, ", ")
      call put(json, to_text(values(i)))
    end do
    call put(json, "], ")
  end subroutine put_list

  !> Append a piece of text.
  pure subroutine put(json, piece)
    type(json_type), intent(inout) :: json   !! text so far
    character(len=*), intent(in) :: piece    !! what is added
    do while (json%length + len(piece) > len(json%room))
      json%room = json%room // json%room
    end do
    json%room(json%length + 1:json%length + len(piece)) = piece
    json%length = json%length + len(piece)
  end subroutine put

  !> A string as JSON, in quotes and with escaped characters.
  pure function quoted(string) result(json)
    character(len=*), intent(in) :: string   !! without control characters but tabs
    character(len=:), allocatable :: json
    integer :: i
    json = """"
    do i = 1, len(string)
      select case (string(i:i))
      case ("""", "\")
        json = json // "\" // string(i:i)
      case (achar(9))
        json = json // "\t"
      case default
        json = json // string(i:i)
      end select
    end do
    json = json // """"
  end function quoted

end module case_echo
