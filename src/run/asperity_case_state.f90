!> State at the start of a case: separation, STATEV and the work so far. The case of a failed increment has this group.
module asperity_case_state
  use asperity_call_checks, only: explain_point, point_status
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type
  use asperity_errors, only: error_type, errors_type, fail, fail_lines
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text
  use asperity_case_text, only: group_index, of_group, text_type, unknown_name
  use asperity_case_values, only: get_real, get_reals
  implicit none
  private
  public :: read_state, check_state

  !> State at the start of a run.
  type, public :: state_type
    logical :: given = .false.              !! false: virgin, separation zero
    real(wp) :: s(3) = 0.0_wp               !! separation (N, Tx, Ty), length
    real(wp), allocatable :: statev(:)      !! STATEV
    logical :: has_work = .false.           !! false: the work is the sum of stored and dissipated energy
    real(wp) :: work = 0.0_wp               !! work of the traction so far, stress*length
    type(error_type) :: place               !! of an error in it
  end type state_type

contains

  !> Read the group &state, if there is one.
  subroutine read_state(text, state, errors)
    type(text_type), intent(in) :: text                       !! the file
    type(state_type), intent(out) :: state                    !! state at the start
    type(errors_type), intent(inout) :: errors   !! errors are added
    real(wp), allocatable :: s(:)
    integer :: e, g

    allocate (state%statev(0), s(0))
    g = group_index(text, "state")
    if (g == 0) return
    state%given = .true.
    state%place = of_group(text, g)
    do e = text%groups(g)%first, text%groups(g)%last
      select case (text%entries(e)%name)
      case ("separation")
        call get_reals(text, e, s, errors)
      case ("statev")
        call get_reals(text, e, state%statev, errors)
      case ("work")
        state%has_work = .true.
        call get_real(text, e, state%work, errors)
      case default
        call unknown_name(text, e, "separation, statev, work", errors)
      end select
    end do
    if (size(s) == size(state%s)) then
      state%s = s
    else
      call fail(errors, state%place, integer_text(size(s)) // &
        " values of separation: expected three (N, Tx, Ty)")
    end if
    if (group_index(text, "replay") > 0) call fail(errors, state%place, &
      "a replay starts from the virgin state: expected &state with &step only")
  end subroutine read_state

  !> Check that the state is admissible for the interface.
  subroutine check_state(joint, state, errors)
    type(interface_type), intent(in) :: joint                 !! the interface
    type(state_type), intent(in) :: state                     !! state at the start
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=:), allocatable :: reasons
    if (.not. state%given) return
    if (size(state%statev) /= joint%n_statev) then
      call fail(errors, state%place, integer_text(size(state%statev)) // &
        " values of statev: expected " // integer_text(joint%n_statev))
    else if (point_status(joint, state%s, state%s, state%statev) /= status_ok) then
      allocate (character(len=0) :: reasons)
      call explain_point(joint, state%s, state%s, state%statev, reasons)
      call fail_lines(errors, state%place, reasons)
    end if
  end subroutine check_state

end module asperity_case_state
