!> The group &umat of a case file: a UMAT in a shared library instead of &material and &pattern.
module case_umat
  use asperity_contract, only: p_eta, p_gc, p_mu, p_sigma0, prop_table
  use asperity_kinds, only: wp
  use asperity_text, only: append, integer_text
  use case_text, only: entry_where, group_index, group_where, text_type, unknown_name
  use case_values, only: get_integer, get_logical, get_real, get_reals, get_string
  use asperity_foreign_umat, only: complete_umat, far, foreign_law, try_umat
  use text_file, only: lower
  implicit none
  private
  public :: read_umat

contains

  !> Read the group and open the library; the law is not `given` without the group.
  subroutine read_umat(text, law, props, message)
    type(text_type), intent(in) :: text                       !! the file
    type(foreign_law), intent(out) :: law                     !! its UMAT
    real(wp), allocatable, intent(out) :: props(:)            !! PROPS of an interface with its scales
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    character(len=:), allocatable :: order, reason
    real(wp) :: length, stiffness
    real(wp), allocatable :: declared(:)
    integer :: e, earlier, g, i

    g = group_index(text, "umat")
    if (g == 0) return
    law%given = .true.
    law%library = ""
    law%symbol = "umat_"
    order = "N,Tx,Ty"
    length = 0.0_wp
    stiffness = 0.0_wp
    earlier = len(message)
    allocate (law%props(0), law%first(0), declared(0))
    do e = text%groups(g)%first, text%groups(g)%last
      select case (text%entries(e)%name)
      case ("library")
        call get_string(text, e, law%library, message)
      case ("symbol")
        call get_string(text, e, law%symbol, message)
      case ("props")
        call get_reals(text, e, law%props, message)
      case ("nstatv")
        call get_integer(text, e, 0, 1000000, law%nstatv, message)
      case ("length")
        call get_real(text, e, length, message)
        if (.not. length > 0.0_wp) call append(message, entry_where(text, e) // ": expected > 0")
      case ("stiffness")
        call get_real(text, e, stiffness, message)
        if (.not. stiffness > 0.0_wp) call append(message, entry_where(text, e) // ": expected > 0")
      case ("order")
        call get_string(text, e, order, message)
      case ("thickness")
        call get_real(text, e, law%h, message)
        if (.not. law%h > 0.0_wp) call append(message, entry_where(text, e) // ": expected > 0")
      case ("state")
        call get_reals(text, e, law%first, message)
      case ("damage")
        call get_integer(text, e, 1, 1000000, law%damage, message)
      case ("limit")
        call get_real(text, e, law%limit, message)
        if (.not. law%limit > 0.0_wp) call append(message, entry_where(text, e) // ": expected > 0")
      case ("ntens")
        call get_reals(text, e, declared, message)
        do i = 1, size(declared)
          if (any(abs(declared(i) - [2.0_wp, 3.0_wp, 6.0_wp]) <= 0.0_wp)) cycle
          call append(message, entry_where(text, e) // ": expected 2, 3 or 6, one or more of them")
        end do
      case ("energies")
        call get_logical(text, e, law%has_energies, message)
      case default
        call unknown_name(text, e, "library, symbol, props, nstatv, length, stiffness, order, thickness, state, " // &
          "damage, limit, ntens, energies", message)
      end select
    end do
    if (len(message) > earlier) return
    if (len(law%library) == 0 .or. .not. (length > 0.0_wp .and. stiffness > 0.0_wp)) call append(message, &
      group_where(text, g) // "expected library, length (separation at which the strength is reached) and " // &
      "stiffness (of the elastic bond)")
    if (size(law%first) == 0) law%first = [(0.0_wp, e=1, law%nstatv)]
    if (size(law%first) /= law%nstatv) call append(message, group_where(text, g) // integer_text(size(law%first)) // &
      " values of state: expected nstatv = " // integer_text(law%nstatv))
    if (law%damage > law%nstatv) call append(message, group_where(text, g) // "damage = " // &
      integer_text(law%damage) // ": expected at most nstatv = " // integer_text(law%nstatv))
    law%order = order
    call set_order(lower(order), law)
    if (law%ntens == 0) call append(message, group_where(text, g) // "order = '" // order // &
      "': expected the names N, Tx, Ty (or N, Tx) in the order of the UMAT, '-' for another component; 2, 3 or 6 " // &
      "in all")
    if (law%ntens > 0 .and. size(declared) > 0) then
      law%declared = nint(declared(1))
      law%declared(:min(3, size(declared))) = nint(declared(:min(3, size(declared))))
      if (all(law%declared /= law%ntens)) call append(message, group_where(text, g) // "ntens without " // &
        integer_text(law%ntens) // ", the number of components of order = '" // order // "'")
    end if
    if (len(message) > earlier) return
    if (index(law%library, "/") /= 1) law%library = folder_of(text%path) // law%library
    call complete_umat(law, length, stiffness)
    call try_umat(law, reason)
    if (len(reason) > 0) call append(message, group_where(text, g) // reason)
    if (len(message) > earlier) return

    props = prop_table%default
    props([p_sigma0, p_gc, p_eta, p_mu]) = [law%stress, 0.5_wp*law%stress*law%reach, 1.0_wp - 1.0_wp/far, 0.0_wp]
    if (any(props([p_sigma0, p_gc]) < prop_table([p_sigma0, p_gc])%lower) .or. &
      any(props([p_sigma0, p_gc]) > prop_table([p_sigma0, p_gc])%upper)) call append(message, group_where(text, g) // &
      "length and stiffness are out of range: expected other units")
  end subroutine read_umat

  !> Folder of a file, with the slash that a library needs in its name.
  pure function folder_of(path) result(folder)
    character(len=*), intent(in) :: path   !! of the file
    character(len=:), allocatable :: folder
    folder = path(:index(path, "/", back=.true.))
    if (len(folder) == 0) folder = "./"
  end function folder_of

  !> Positions of the components; NTENS is 0 for an order that is not admissible.
  pure subroutine set_order(order, law)
    character(len=*), intent(in) :: order      !! lower case
    type(foreign_law), intent(inout) :: law    !! ntens and position are set
    character(len=2), parameter :: names(3) = ["n ", "tx", "ty"]
    character(len=:), allocatable :: rest, word
    integer :: comma, i
    logical :: good
    law%ntens = 0
    law%position = 0
    rest = order // ","
    good = .true.
    do while (len(rest) > 0)
      comma = index(rest, ",")
      word = trim(adjustl(rest(:comma - 1)))
      rest = rest(comma + 1:)
      law%ntens = law%ntens + 1
      i = findloc(names == word, .true., dim=1)
      if (i == 0) good = good .and. word == "-"
      if (i == 0) cycle
      good = good .and. law%position(i) == 0
      law%position(i) = law%ntens
    end do
    good = good .and. any(law%ntens == [2, 3, 6]) .and. all(law%position(:2) > 0)
    if (.not. good) law%ntens = 0
  end subroutine set_order

end module case_umat
