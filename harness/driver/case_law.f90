!> Law of a case: that of its interface, or a UMAT of others.
module case_law
  use asperity_case, only: case_type
  use asperity_foreign_umat, only: complete_umat, foreign_law, try_umat, u_time
  use asperity_errors, only: error_type, errors_type, fail, place_of
  use asperity_kinds, only: wp
  use asperity_point_law, only: point_law
  use asperity_rie_law, only: new_rie_law
  use asperity_steps, only: check_steps
  use asperity_text, only: integer_text
  implicit none
  private
  public :: get_law

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

  !> Set the law of a UMAT, try in a child whether it opens, and check what depends on it.
  subroutine set_umat(case, path, law, errors)
    type(case_type), intent(inout) :: case         !! the case; the state is that of a virgin point, if it has none
    character(len=*), intent(in) :: path           !! its file
    type(foreign_law), intent(out) :: law          !! the law
    type(errors_type), intent(inout) :: errors     !! errors are added
    !> That of the direction of a slip.
    real(wp), parameter :: rounding = 1.0e-12_wp
    type(error_type) :: place
    character(len=:), allocatable :: reason
    integer :: earlier, i
    earlier = errors%n
    place = place_of(path)
    law%umat = case%umat
    call complete_umat(law)
    case%umat%library = law%umat%library
    ! before a file of results is replaced
    call try_umat(law, reason)
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
    call check_steps(law, case%steps, errors, place)
    do i = 1, merge(size(case%steps), 0, law%umat%position(3) == 0)
      if (maxval(abs(case%steps(i)%targets(3, :))) > rounding*maxval(abs(case%steps(i)%targets))) call fail(errors, &
        case%steps(i)%place, "Ty is not zero: expected an order with Ty, as order = '" // law%umat%order // &
        "' has none")
    end do
  end subroutine set_umat

end module case_law
