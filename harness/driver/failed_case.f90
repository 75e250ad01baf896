!> Case that repeats a failed increment: the law, the state at its start, and the prescribed values at its end.
module failed_case
  use asperity_case, only: case_type, write_case
  use asperity_contract, only: p_tau_v
  use asperity_kinds, only: wp
  use asperity_load_path, only: run_type
  use asperity_steps, only: e_arc, e_follow, e_increments, e_k, e_s, e_t, e_time
  use asperity_text, only: integer_text
  use row_file, only: close_file, create_file, write_line
  implicit none
  private
  public :: write_failed_case

  !> Start of every such file.
  character(len=*), parameter, public :: failed_title = "&case title = 'failed increment "

contains

  !> Write the file; numbers read back exactly.
  subroutine write_failed_case(path, case, run, written)
    character(len=*), intent(in) :: path       !! file, replaced if it exists
    type(case_type), intent(in) :: case        !! the case
    type(run_type), intent(in) :: run          !! its run, after this increment
    logical, intent(out) :: written            !! false: the reason is on standard error
    type(case_type) :: failed
    character(len=:), allocatable :: text
    integer :: fd, i

    failed%title = "failed increment " // integer_text(run%law%increment) // " of step " // integer_text(run%law%step)
    failed%props = case%props
    failed%stiffness = case%stiffness
    failed%umat = case%umat
    failed%state%given = .true.
    failed%state%s = run%before%s
    failed%state%statev = run%before%state
    failed%state%has_work = .true.
    failed%state%work = run%before%work
    allocate (failed%steps(1))
    associate (given => failed%steps(1)%given, control => run%control, arc => run%steps(run%law%step)%arc)
      do i = 1, 3
        if (control%traction(i)) then
          ! the force of a spring is zero at the start of the step
          given(e_t + i)%values = [run%given(i) - control%spring(i)*run%before%s(i)]
          if (control%spring(i) > 0.0_wp) given(e_k + i)%values = control%spring(i:i)
        else
          given(e_s + i)%values = run%given(i:i)
        end if
      end do
      if (case%umat%given) then
        given(e_time)%values = [control%dt]
      else if (case%props(p_tau_v) > 0.0_wp) then
        given(e_time)%values = [control%dt]
      end if
      if (arc > 0.0_wp) then
        given(e_follow)%values = [1.0_wp]
        given(e_arc)%values = [arc]
      else
        given(e_increments)%values = [1.0_wp]
      end if
    end associate
    call write_case(failed, text)
    call create_file(path, fd, written)
    if (.not. written) return
    call write_line(fd, path, text(:len(text) - 1), written)
    call close_file(fd, path, written)
  end subroutine write_failed_case

end module failed_case
