!> State at the start of a case: separation, STATEV and the work so far. The case of a failed increment has this group.
module case_state
  use asperity_call_checks, only: explain_point, point_status
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_text, only: append, integer_text
  use case_text, only: group_index, group_where, text_type, unknown_name
  use case_values, only: get_real, get_reals
  use asperity_foreign_umat, only: foreign_law, u_time
  implicit none
  private
  public :: read_state, check_state, check_umat_state

  !> State at the start of a run.
  type, public :: state_type
    logical :: given = .false.              !! false: virgin, separation zero
    real(wp) :: s(3) = 0.0_wp               !! separation (N, Tx, Ty), length
    real(wp), allocatable :: statev(:)      !! STATEV
    logical :: has_work = .false.           !! false: the work is the sum of stored and dissipated energy
    real(wp) :: work = 0.0_wp               !! work of the traction so far, stress*length
  end type state_type

contains

  !> Read the group &state, if there is one.
  subroutine read_state(text, state, message)
    type(text_type), intent(in) :: text                       !! the file
    type(state_type), intent(out) :: state                    !! state at the start
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    real(wp), allocatable :: s(:)
    integer :: e, g

    allocate (state%statev(0), s(0))
    g = group_index(text, "state")
    if (g == 0) return
    state%given = .true.
    do e = text%groups(g)%first, text%groups(g)%last
      select case (text%entries(e)%name)
      case ("separation")
        call get_reals(text, e, s, message)
      case ("statev")
        call get_reals(text, e, state%statev, message)
      case ("work")
        state%has_work = .true.
        call get_real(text, e, state%work, message)
      case default
        call unknown_name(text, e, "separation, statev, work", message)
      end select
    end do
    if (size(s) == size(state%s)) then
      state%s = s
    else
      call append(message, group_where(text, g) // integer_text(size(s)) // &
        " values of separation: expected three (N, Tx, Ty)")
    end if
    if (group_index(text, "replay") > 0) call append(message, group_where(text, g) // &
      "a replay starts from the virgin state: expected &state with &step only")
  end subroutine read_state

  !> Check that the state is admissible for the interface.
  subroutine check_state(text, joint, state, message)
    type(text_type), intent(in) :: text                       !! the file
    type(interface_type), intent(in) :: joint                 !! the interface
    type(state_type), intent(in) :: state                     !! state at the start
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    character(len=:), allocatable :: reasons
    if (.not. state%given) return
    if (size(state%statev) /= joint%n_statev) then
      call append(message, group_where(text, group_index(text, "state")) // integer_text(size(state%statev)) // &
        " values of statev: expected " // integer_text(joint%n_statev))
    else if (point_status(joint, state%s, state%s, state%statev) /= status_ok) then
      allocate (character(len=0) :: reasons)
      call explain_point(joint, state%s, state%s, state%statev, reasons)
      call append(message, group_where(text, group_index(text, "state")) // reasons)
    end if
  end subroutine check_state

  !> Check the state of a UMAT, or set that of a virgin point.
  subroutine check_umat_state(text, law, state, message)
    type(text_type), intent(in) :: text                       !! the file
    type(foreign_law), intent(inout) :: law                   !! the UMAT, whose time goes on
    type(state_type), intent(inout) :: state                  !! state at the start
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    if (state%given) then
      if (.not. law%admissible(state%statev)) call append(message, group_where(text, group_index(text, "state")) // &
        integer_text(size(state%statev)) // " values of statev: expected " // integer_text(law%n_state) // &
        ", the energies (6), STRESS and STATEV of the UMAT")
    else
      state%given = .true.
      state%statev = law%virgin()
    end if
    if (size(state%statev) >= u_time) law%origin = state%statev(u_time)
  end subroutine check_umat_state

end module case_state
