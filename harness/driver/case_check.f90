!> Checks of the UMAT of a case, or of that of this project for its material: the table.
module case_check
  use, intrinsic :: iso_fortran_env, only: output_unit
  use asperity_control_point, only: new_point
  use asperity_foreign_umat, only: complete_umat, umat_name
  use asperity_kinds, only: wp
  use asperity_load_path, only: explain_loss, next_row, row_type, run_type, start_run
  use asperity_point_law, only: point_law
  use asperity_text, only: integer_text
  use asperity_umat_checks, only: add_increment, check_names, check_type, check_umat, checked_path_type, &
    failed, stated
  use asperity_umat_run, only: end_umat_run, next_umat_row, start_umat_run, umat_run_type
  use case_file, only: case_type, get_law
  use driver_messages, only: exit_input, exit_ok, say
  use path_run, only: umat_path_of
  implicit none
  private
  public :: check_case

contains

  !> Make the checks and print their table.
  subroutine check_case(case, label, code)
    type(case_type), intent(in) :: case      !! the case
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
    call find_path(case, path, checks(0))
    call check_umat(path, checks(1:))
    write (output_unit, "(3a)") label, ": ", umat_name(path%law)
    do i = 0, size(check_names)
      write (output_unit, "(5a)") checks(i)%outcome, "  ", checks(i)%name, "  ", checks(i)%text
    end do
    if (all(checks%outcome /= failed)) code = exit_ok
  end subroutine check_case

  !> Take the load path, with the UMAT, or with the law of this project, whose UMAT is then checked.
  subroutine find_path(case, path, check)
    type(case_type), intent(in) :: case                 !! the case
    type(checked_path_type), intent(out) :: path        !! the path as far as it goes
    type(check_type), intent(out) :: check              !! whether it was run
    class(point_law), allocatable :: law
    type(umat_run_type) :: umat_run
    type(run_type) :: run
    type(row_type) :: row
    character(len=:), allocatable :: reason
    real(wp) :: time
    logical :: found
    call get_law(case, law)
    if (case%umat%given) then
      path%law = case%umat
      path%start = case%state%statev
      call start_umat_run(umat_path_of(case), umat_run)
    else
      path%law%library = ""
      path%law%symbol = "umat_"
      path%law%props = case%props
      path%law%nstatv = case%joint%n_statev
      path%law%first = spread(0.0_wp, 1, path%law%nstatv)
      if (case%state%given) path%law%first = case%state%statev
      call complete_umat(path%law, law%length, law%stiffness)
      path%start = path%law%virgin()
      if (case%state%given) then
        call start_run(law, case%steps, run, new_point(law, case%state%statev, case%state%s))
      else
        call start_run(law, case%steps, run, new_point(law))
      end if
    end if
    path%s = reshape(case%state%s, [3, 1])
    allocate (path%dt(0), path%step(0), path%increment(0))
    time = 0.0_wp
    do
      if (case%umat%given) then
        call next_umat_row(umat_run, row, found)
      else
        call next_row(run, row, found)
      end if
      if (.not. found .or. row%lost) exit
      ! the routine has asked for smaller increments
      call add_increment(path, row%s, row%time - time, row%step, row%increment, &
        merge(2*row%report%parts, 1, row%report%cut))
      time = row%time
    end do
    reason = ""
    if (row%lost) then
      check%outcome = stated
      if (.not. case%umat%given) call explain_loss(run, row, reason)
    end if
    if (case%umat%given) then
      if (found) call end_umat_run(umat_run)
      reason = umat_run%reason
      if (len(umat_run%failure) > 0) then
        check%outcome = failed
        reason = umat_run%worker%failure
      end if
    end if
    check%name = "path"
    check%text = integer_text(size(path%dt)) // " increments"
    if (len(reason) > 0) check%text = check%text // ", then " // reason
  end subroutine find_path

end module case_check
