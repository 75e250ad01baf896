!> Load path of a case: its groups &step in their order.
module asperity_case_steps
  use asperity_errors, only: errors_type
  use asperity_kinds, only: wp
  use asperity_steps, only: complete_steps, e_follow, step_table, step_type
  use asperity_case_text, only: listed, name_index, of_entry, of_file, of_group, text_type, unknown_name
  use asperity_case_values, only: get_reals, get_string
  use asperity_text_file, only: lower
  implicit none
  private
  public :: read_steps

contains

  !> Read all groups &step.
  subroutine read_steps(text, steps, errors)
    type(text_type), intent(in) :: text                       !! the file
    type(step_type), allocatable, intent(out) :: steps(:)     !! the load path
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=:), allocatable :: followed
    integer :: e, g, i, n
    allocate (steps(count(text%groups(:text%n_groups)%name == "step")))
    n = 0
    do g = 1, text%n_groups
      if (text%groups(g)%name /= "step") cycle
      n = n + 1
      steps(n)%place = of_group(text, g)
      do e = text%groups(g)%first, text%groups(g)%last
        i = name_index(text%entries(e)%name, step_table%name)
        if (i == 0) then
          call unknown_name(text, e, listed(step_table%name, ""), errors)
          cycle
        end if
        steps(n)%given(i)%place = of_entry(text, e)
        if (i == e_follow) then
          followed = "stable"
          call get_string(text, e, followed, errors)
          ! another text has no number in the range of the table
          steps(n)%given(i)%values = [real(name_index(lower(followed), ["stable", "branch"]) - 1, wp)]
        else
          call get_reals(text, e, steps(n)%given(i)%values, errors)
        end if
      end do
    end do
    call complete_steps(steps, errors, of_file(text))
  end subroutine read_steps

end module asperity_case_steps
