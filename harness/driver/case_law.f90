!> Law of a case: that of its interface, or a UMAT of others, and the checks of a UMAT as a table.
module case_law
  use, intrinsic :: iso_fortran_env, only: output_unit
  use asperity_case, only: case_type
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_foreign_umat, only: complete_umat, foreign_law, u_time, umat_name
  use asperity_increment, only: ended_refused
  use asperity_kinds, only: wp
  use asperity_load_path, only: row_type
  use asperity_point_law, only: point_law
  use asperity_rie_law, only: new_rie_law
  use asperity_steps, only: check_steps
  use asperity_text, only: integer_text
  use asperity_umat_checks, only: check_names, check_type, check_umat, failed, stated
  use asperity_umat_walk, only: add_increment, checked_path_type, set_length, walk, walk_type
  use asperity_umat_run, only: next_umat_row, start_umat_run, umat_run_type
  use driver_output, only: exit_input, exit_ok, say
  implicit none
  private
  public :: check_case, get_law

  !> A law, as an element of an array.
  type, public :: law_type
    class(point_law), allocatable :: law
  end type law_type

contains

  !> Law of a case. With a UMAT, state and steps of the case are checked, and a virgin point has its state.
  subroutine get_law(case, path, law, errors)
    type(case_type), intent(inout) :: case                !! the case
    character(len=*), intent(in) :: path                  !! its file
    class(point_law), allocatable, intent(out) :: law     !! the law
    type(errors_type), intent(inout) :: errors            !! errors are added
    type(foreign_law) :: umat
    if (case%umat%given) then
      call set_umat(case, path, umat, errors)
      allocate (law, source=umat)
    else
      allocate (law, source=new_rie_law(case%joint))
    end if
  end subroutine get_law

  !> Set the law of a UMAT, try by a walk without increments whether it opens, and check what depends on it.
  subroutine set_umat(case, path, law, errors)
    type(case_type), intent(inout) :: case         !! the case; the state is that of a virgin point, if it has none
    character(len=*), intent(in) :: path           !! its file
    type(foreign_law), intent(out) :: law          !! the law
    type(errors_type), intent(inout) :: errors     !! errors are added
    !> That of the direction of a slip.
    real(wp), parameter :: rounding = 1.0e-12_wp
    type(walk_type) :: plan
    real(wp), allocatable :: nothing(:, :)
    character(len=:), allocatable :: reason
    integer :: earlier, i
    earlier = errors%n
    law%umat = case%umat
    call complete_umat(law)
    case%umat%library = law%umat%library
    ! before a file of results is replaced
    plan%path%law = law
    plan%path%start = law%virgin()
    allocate (plan%path%dt(0), plan%factors(3, 1))
    call walk(plan, nothing, reason)
    if (len(reason) > 0) call fail(errors, law%umat%place, reason)
    if (errors%n > earlier) return
    if (.not. case%state%given) then
      case%state%given = .true.
      case%state%statev = law%virgin()
    else if (.not. law%admissible(case%state%statev)) then
      call fail(errors, case%state%place, integer_text(size(case%state%statev)) // " values of statev: expected " // &
        integer_text(law%n_state) // ", the energies (6), STRESS and STATEV of the UMAT")
    end if
    if (size(case%state%statev) >= u_time) law%origin = case%state%statev(u_time)
    call check_steps(law, case%steps, errors, error_type(path))
    do i = 1, merge(size(case%steps), 0, law%umat%position(3) == 0)
      if (maxval(abs(case%steps(i)%targets(3, :))) > rounding*maxval(abs(case%steps(i)%targets))) call fail(errors, &
        case%steps(i)%place, "Ty is not zero: expected an order with Ty, as order = '" // law%umat%order // &
        "' has none")
    end do
  end subroutine set_umat

  !> Make the checks and print their table.
  subroutine check_case(case, law, label, code)
    type(case_type), intent(in) :: case      !! the case
    class(point_law), intent(in) :: law      !! its law
    character(len=*), intent(in) :: label    !! name of the run in messages
    integer, intent(out) :: code             !! exit code: 0 none has failed, 1 one has
    type(checked_path_type) :: path
    type(check_type) :: checks(0:size(check_names))
    integer :: i
    code = exit_input
    if (size(case%steps) == 0) then
      call say(label // ": a replay has no load path: expected &step")
      return
    end if
    call find_path(case, law, path, checks(0))
    call check_umat(path, checks(1:))
    write (output_unit, "(3a)") label, ": ", umat_name(path%law)
    do i = 0, size(check_names)
      write (output_unit, "(5a)") checks(i)%outcome, "  ", checks(i)%name, "  ", checks(i)%text
    end do
    if (all(checks%outcome /= failed)) code = exit_ok
  end subroutine check_case

  !> Take the load path with the UMAT.
  subroutine find_path(case, law, path, check)
    type(case_type), intent(in) :: case                 !! the case
    class(point_law), intent(in) :: law                 !! its law
    type(checked_path_type), intent(out) :: path        !! the path as far as it goes
    type(check_type), intent(out) :: check              !! whether it was run
    type(case_type) :: own
    type(umat_run_type) :: run
    type(row_type) :: row
    real(wp) :: time
    integer :: n
    logical :: found
    own = case
    select type (law)
    type is (foreign_law)
      path%law = law
    class default
      path%law%umat%library = ""
      path%law%umat%symbol = "umat_"
      path%law%umat%props = case%props
      path%law%umat%nstatv = case%joint%n_umat_statev
      path%law%umat%first = spread(0.0_wp, 1, path%law%umat%nstatv)
      if (case%state%given) path%law%umat%first = case%state%statev
      path%law%umat%length = law%s_0
      path%law%umat%stiffness = law%stiffness
      call complete_umat(path%law)
      own%state%statev = path%law%virgin()
    end select
    path%start = own%state%statev
    path%s = reshape(own%state%s, [3, 1])
    allocate (path%dt(0), path%step(0), path%increment(0))
    time = 0.0_wp
    n = 0
    call start_umat_run(path%law, own, run)
    do
      call next_umat_row(run, row, found)
      if (.not. found) exit
      if (row%lost) cycle
      ! the routine has asked for smaller increments
      call add_increment(path, n, row%s, row%time - time, row%step, row%increment, &
        merge(2*row%report%parts, 1, row%report%cut))
      time = row%time
    end do
    call set_length(path, n)
    check%name = "path"
    check%text = integer_text(size(path%dt)) // " increments"
    if (len(run%reason) > 0) check%outcome = stated
    ! a path without increments, or one that the UMAT ends by its requests, is no success
    if (len(run%failure) > 0 .or. size(path%dt) == 0 .or. row%report%ended == ended_refused) check%outcome = failed
    if (len(run%reason // run%failure) > 0) check%text = check%text // ", then " // run%reason // run%failure
  end subroutine find_path

end module case_law
