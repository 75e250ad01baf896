!> The group &umat of a case file: a UMAT in a shared library instead of &material and &pattern.
module asperity_case_umat
  use asperity_case_text, only: group_index, of_entry, of_group, text_type, unknown_name
  use asperity_case_values, only: get_integer, get_logical, get_real, get_reals, get_string
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text
  use asperity_text_file, only: lower
  implicit none
  private
  public :: read_umat

  real(wp), parameter, public :: default_limit = 60.0_wp

  !> What a case says of its UMAT; nothing of it has been opened.
  type, public :: umat_type
    logical :: given = .false.                       !! false: the law is that of this project
    type(error_type) :: place                        !! of the group
    character(len=:), allocatable :: library         !! file, with a folder
    character(len=:), allocatable :: symbol, order   !! as given
    real(wp), allocatable :: props(:)                !! PROPS
    real(wp), allocatable :: first(:)                !! (nstatv) STATEV of a virgin point
    integer :: nstatv = 0                            !! its state variables
    integer :: ntens = 3                             !! its components
    integer :: position(3) = [1, 2, 3]               !! of N, Tx and Ty among them, 0: it has no such component
    integer :: damage = 0                            !! its state variable that is the damage, 0: none
    real(wp) :: length = 0.0_wp                      !! separation at which the strength is reached, length
    real(wp) :: stiffness = 0.0_wp                   !! elastic stiffness of the bond, stress/length
    real(wp) :: thickness = 1.0_wp                   !! by which separations are divided, length
    real(wp) :: limit = default_limit                !! longest time without a new increment, s
    integer :: declared(3) = [2, 3, 6]               !! numbers of components that it can have
    logical :: has_energies = .true.                 !! whether it gives SSE, SPD and SCD
  end type umat_type

  !> Smallest and largest strength and energy that length and stiffness may give: no product leaves the range of a
  !> double.
  real(wp), parameter :: smallest = 1.0e-50_wp, largest = 1.0e50_wp

contains

  !> Read the group; the UMAT is not `given` without it.
  subroutine read_umat(text, umat, errors)
    type(text_type), intent(in) :: text          !! the file
    type(umat_type), intent(out) :: umat         !! its UMAT
    type(errors_type), intent(inout) :: errors   !! errors are added
    real(wp), allocatable :: declared(:)
    real(wp) :: sizes(2)
    integer :: e, earlier, g, i

    g = group_index(text, "umat")
    if (g == 0) return
    umat%given = .true.
    umat%place = of_group(text, g)
    umat%library = ""
    umat%symbol = "umat_"
    umat%order = "N,Tx,Ty"
    earlier = errors%n
    allocate (umat%props(0), umat%first(0), declared(0))
    do e = text%groups(g)%first, text%groups(g)%last
      select case (text%entries(e)%name)
      case ("library")
        call get_string(text, e, umat%library, errors)
      case ("symbol")
        call get_string(text, e, umat%symbol, errors)
      case ("order")
        call get_string(text, e, umat%order, errors)
      case ("props")
        call get_reals(text, e, umat%props, errors)
      case ("state")
        call get_reals(text, e, umat%first, errors)
      case ("nstatv")
        call get_integer(text, e, 0, 1000000, umat%nstatv, errors)
      case ("damage")
        call get_integer(text, e, 1, 1000000, umat%damage, errors)
      case ("length")
        call get_positive(umat%length)
      case ("stiffness")
        call get_positive(umat%stiffness)
      case ("thickness")
        call get_positive(umat%thickness)
      case ("limit")
        call get_positive(umat%limit)
      case ("ntens")
        call get_reals(text, e, declared, errors)
        do i = 1, size(declared)
          if (any(abs(declared(i) - [2.0_wp, 3.0_wp, 6.0_wp]) <= 0.0_wp)) cycle
          call fail(errors, of_entry(text, e), "expected 2, 3 or 6, one or more of them")
        end do
      case ("energies")
        call get_logical(text, e, umat%has_energies, errors)
      case default
        call unknown_name(text, e, "library, symbol, props, nstatv, length, stiffness, order, thickness, state, " // &
          "damage, limit, ntens, energies", errors)
      end select
    end do
    if (errors%n > earlier) return
    if (len(umat%library) == 0 .or. .not. (umat%length > 0.0_wp .and. umat%stiffness > 0.0_wp)) then
      call fail(errors, of_group(text, g), "expected library, length (separation at which the strength is " // &
        "reached) and stiffness (of the elastic bond)")
    else
      sizes = umat%length*umat%stiffness*[1.0_wp, umat%length]
      if (any(sizes < smallest .or. sizes > largest)) call fail(errors, of_group(text, g), &
        "length and stiffness are out of range: expected other units")
    end if
    if (size(umat%first) == 0) umat%first = [(0.0_wp, e=1, umat%nstatv)]
    if (size(umat%first) /= umat%nstatv) call fail(errors, of_group(text, g), integer_text(size(umat%first)) // &
      " values of state: expected nstatv = " // integer_text(umat%nstatv))
    if (umat%damage > umat%nstatv) call fail(errors, of_group(text, g), "damage = " // &
      integer_text(umat%damage) // ": expected at most nstatv = " // integer_text(umat%nstatv))
    call set_order(lower(umat%order), umat)
    if (umat%ntens == 0) call fail(errors, of_group(text, g), "order = '" // umat%order // &
      "': expected the names N, Tx, Ty (or N, Tx) in the order of the UMAT, '-' for another component; 2, 3 or 6 " // &
      "in all")
    if (umat%ntens > 0 .and. size(declared) > 0) then
      umat%declared = nint(declared(1))
      umat%declared(:min(3, size(declared))) = nint(declared(:min(3, size(declared))))
      if (all(umat%declared /= umat%ntens)) call fail(errors, of_group(text, g), "ntens without " // &
        integer_text(umat%ntens) // ", the number of components of order = '" // umat%order // "'")
    end if
    if (index(umat%library, "/") /= 1) umat%library = folder_of(text%path) // umat%library

  contains

    !> A number above zero.
    subroutine get_positive(value)
      real(wp), intent(inout) :: value   !! unchanged on error
      integer :: before
      before = errors%n
      call get_real(text, e, value, errors)
      if (errors%n == before .and. .not. value > 0.0_wp) call fail(errors, of_entry(text, e), "expected > 0")
    end subroutine get_positive

  end subroutine read_umat

  !> Folder of a file, with the slash that a library needs in its name.
  pure function folder_of(path) result(folder)
    character(len=*), intent(in) :: path   !! of the file
    character(len=:), allocatable :: folder
    folder = path(:index(path, "/", back=.true.))
    if (len(folder) == 0) folder = "./"
  end function folder_of

  !> Positions of the components; NTENS is 0 for an order that is not admissible.
  pure subroutine set_order(order, umat)
    character(len=*), intent(in) :: order    !! lower case
    type(umat_type), intent(inout) :: umat   !! ntens and position are set
    character(len=2), parameter :: names(3) = ["n ", "tx", "ty"]
    character(len=:), allocatable :: rest, word
    integer :: comma, i
    logical :: good
    umat%ntens = 0
    umat%position = 0
    rest = order // ","
    good = .true.
    do while (len(rest) > 0)
      comma = index(rest, ",")
      word = trim(adjustl(rest(:comma - 1)))
      rest = rest(comma + 1:)
      umat%ntens = umat%ntens + 1
      i = findloc(names == word, .true., dim=1)
      if (i == 0) good = good .and. word == "-"
      if (i == 0) cycle
      good = good .and. umat%position(i) == 0
      umat%position(i) = umat%ntens
    end do
    good = good .and. any(umat%ntens == [2, 3, 6]) .and. all(umat%position(:2) > 0)
    if (.not. good) umat%ntens = 0
  end subroutine set_order

end module asperity_case_umat
