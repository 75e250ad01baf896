!> The group &umat of a case file: a UMAT in a shared library instead of &material and &pattern.
module asperity_case_umat
  use asperity_case_entries, only: case_io, close_group, integer_entry, logical_entry, open_group, real_entry, &
    reals_entry, require, string_entry
  use asperity_errors, only: error_type, fail
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text, set_text
  use asperity_text_file, only: beside, last_separator, longest_field, lower, split
  implicit none
  private
  public :: umat_group

  real(wp), parameter :: default_limit = 60.0_wp
  character(len=*), parameter :: default_symbol = "umat_", default_order = "N,Tx,Ty"
  !> Numbers of components that a UMAT can have.
  integer, parameter :: any_ntens(3) = [2, 3, 6]

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
    integer :: declared(3) = any_ntens               !! numbers of components that it can have
    logical :: has_energies = .true.                 !! whether it gives SSE, SPD and SCD
  end type umat_type

  !> Smallest and largest strength and energy that length and stiffness may give: no product leaves the range of a
  !> double.
  real(wp), parameter :: smallest = 1.0e-50_wp, largest = 1.0e50_wp

contains

  !> The group &umat; the UMAT is not `given` without it.
  subroutine umat_group(io, umat)
    type(case_io), intent(inout) :: io           !! the file
    type(umat_type), intent(inout) :: umat       !! its UMAT
    integer, parameter :: most = 1000000
    real(wp), allocatable :: declared(:)
    real(wp) :: sizes(2)
    integer :: earlier, i

    call open_group(io, "umat", umat%given)
    if (.not. umat%given) return
    if (io%writes) then
      if (any(umat%declared /= any_ntens)) declared = real(umat%declared, wp)
    else
      umat%place = io%place
      call set_text(umat%library, "")
      call set_text(umat%symbol, default_symbol)
      call set_text(umat%order, default_order)
      allocate (umat%props(0), umat%first(0), declared(0))
    end if
    earlier = io%errors%n
    call string_entry(io, "library", umat%library, "")
    call string_entry(io, "symbol", umat%symbol, default_symbol)
    call reals_entry(io, "props", umat%props)
    call integer_entry(io, "nstatv", umat%nstatv, 0, most, 0)
    call positive_entry("length", umat%length, 0.0_wp)
    call positive_entry("stiffness", umat%stiffness, 0.0_wp)
    call string_entry(io, "order", umat%order, default_order)
    call positive_entry("thickness", umat%thickness, 1.0_wp)
    call reals_entry(io, "state", umat%first)
    call integer_entry(io, "damage", umat%damage, 1, most, 0)
    call positive_entry("limit", umat%limit, default_limit)
    call reals_entry(io, "ntens", declared)
    if (io%is_given) call require(io, all([(any(abs(declared(i) - real(any_ntens, wp)) <= 0.0_wp), &
      i=1, size(declared))]), "expected 2, 3 or 6, one or more of them")
    call logical_entry(io, "energies", umat%has_energies, .true.)
    call close_group(io)
    if (io%errors%n > earlier .or. io%writes) return
    if (len(umat%library) == 0 .or. .not. (umat%length > 0.0_wp .and. umat%stiffness > 0.0_wp)) then
      call group_error("expected library, length (separation at which the strength is reached) and stiffness (of " // &
        "the elastic bond)")
    else
      sizes = umat%length*umat%stiffness*[1.0_wp, umat%length]
      if (any(sizes < smallest .or. sizes > largest)) call group_error("length and stiffness are out of range: " // &
        "expected other units")
    end if
    if (size(umat%first) == 0) umat%first = spread(0.0_wp, 1, umat%nstatv)
    if (size(umat%first) /= umat%nstatv) call group_error(integer_text(size(umat%first)) // &
      " values of state: expected nstatv = " // integer_text(umat%nstatv))
    if (umat%damage > umat%nstatv) call group_error("damage = " // integer_text(umat%damage) // &
      ": expected at most nstatv = " // integer_text(umat%nstatv))
    call set_order(lower(umat%order), umat)
    if (umat%ntens == 0) call group_error("order = '" // umat%order // "': expected the names N, Tx, Ty (or N, " // &
      "Tx) in the order of the UMAT, '-' for another component; 2, 3 or 6 in all")
    if (umat%ntens > 0 .and. size(declared) > 0) then
      umat%declared = nint(declared(1))
      umat%declared(:min(3, size(declared))) = nint(declared(:min(3, size(declared))))
      if (all(umat%declared /= umat%ntens)) call group_error("ntens without " // integer_text(umat%ntens) // &
        ", the number of components of order = '" // umat%order // "'")
    end if
    umat%library = beside(io%text%path, umat%library)
    if (last_separator(umat%library) == 0) umat%library = "./" // umat%library

  contains

    !> A number above zero.
    subroutine positive_entry(name, value, default)
      character(len=*), intent(in) :: name   !! of the entry
      real(wp), intent(inout) :: value       !! unchanged if it cannot be read
      real(wp), intent(in) :: default        !! value without the entry
      integer :: before
      before = io%errors%n
      call real_entry(io, name, value, default)
      if (io%errors%n == before) call require(io, value > 0.0_wp, "expected > 0")
    end subroutine positive_entry

    !> Add an error about the group.
    subroutine group_error(text)
      character(len=*), intent(in) :: text   !! what is wrong
      call fail(io%errors, umat%place, text)
    end subroutine group_error

  end subroutine umat_group

  !> Positions of the components; NTENS is 0 for an order that is not admissible.
  pure subroutine set_order(order, umat)
    character(len=*), intent(in) :: order    !! lower case
    type(umat_type), intent(inout) :: umat   !! ntens and position are set
    character(len=2), parameter :: names(3) = ["n ", "tx", "ty"]
    character(len=longest_field), allocatable :: list(:)
    integer :: i
    call split(order, list)
    umat%ntens = size(list)
    umat%position = [(findloc(list, names(i), dim=1), i=1, 3)]
    if (all(umat%ntens /= any_ntens) .or. any(umat%position(:2) == 0) .or. &
      count(umat%position > 0) + count(list == "-") < umat%ntens) umat%ntens = 0
  end subroutine set_order

end module asperity_case_umat
