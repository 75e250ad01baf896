!> Checks of the UMAT of a case, or of that of this project for its material: the table.
module case_check
  use, intrinsic :: iso_fortran_env, only: output_unit
  use asperity_foreign_umat, only: complete_umat, umat_name
  use asperity_kinds, only: wp
  use asperity_load_path, only: row_type
  use asperity_point_law, only: point_law
  use asperity_text, only: integer_text
  use asperity_umat_checks, only: add_increment, check_names, check_type, check_umat, checked_path_type, &
    failed, stated
  use asperity_umat_run, only: next_umat_row, start_umat_run, umat_path_type, umat_run_type
  use asperity_case, only: case_type
  use driver_messages, only: exit_input, exit_ok, say
  use path_run, only: get_umat_path
  implicit none
  private
  public :: check_case

contains

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
    type(umat_path_type) :: what
    type(umat_run_type) :: run
    type(row_type) :: row
    real(wp) :: time
    logical :: found
    call get_umat_path(case, law, what)
    if (.not. case%umat%given) then
      what%law%umat%library = ""
      what%law%umat%symbol = "umat_"
      what%law%umat%props = case%props
      what%law%umat%nstatv = case%joint%n_statev
      what%law%umat%first = spread(0.0_wp, 1, what%law%umat%nstatv)
      if (case%state%given) what%law%umat%first = case%state%statev
      what%law%umat%length = law%length
      what%law%umat%stiffness = law%stiffness
      call complete_umat(what%law)
      what%state = what%law%virgin()
    end if
    path%law = what%law
    path%start = what%state
    path%s = reshape(what%s, [3, 1])
    allocate (path%dt(0), path%step(0), path%increment(0))
    time = 0.0_wp
    call start_umat_run(what, run)
    do
      call next_umat_row(run, row, found)
      if (.not. found) exit
      if (row%lost) cycle
      ! the routine has asked for smaller increments
      call add_increment(path, row%s, row%time - time, row%step, row%increment, &
        merge(2*row%report%parts, 1, row%report%cut))
      time = row%time
    end do
    check%name = "path"
    check%text = integer_text(size(path%dt)) // " increments"
    if (row%lost) check%outcome = stated
    if (len(run%failure) > 0) check%outcome = failed
    if (len(run%reason // run%failure) > 0) check%text = check%text // ", then " // run%reason // run%worker%failure
  end subroutine find_path

end module case_check
