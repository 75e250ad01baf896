!> Initial state of a case: the state of the planes and the traction that they carry at separation zero.
module asperity_case_initial
  use asperity_checks, only: bounded
  use asperity_contract, only: plane_statev, status_ok
  use asperity_initial, only: carry_traction, explain_initial
  use asperity_interface, only: interface_type, separation_bound, slip_factor
  use asperity_errors, only: errors_type, fail, fail_lines
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text, to_text
  use asperity_case_text, only: of_entry, group_index, of_group, text_type, unknown_name
  use asperity_case_values, only: get_reals
  implicit none
  private
  public :: read_initial, carry_initial

  !> State at the start of a run.
  type, public :: initial_type
    logical :: given = .false.                      !! false: virgin, without traction
    real(wp) :: traction(3) = 0.0_wp                !! (N, Tx, Ty), stress
    real(wp), allocatable :: damage(:)              !! of all planes or of each, size 0: none
    real(wp), allocatable :: slip(:)                !! s_dit, s_dih of all planes or of each, length, size 0: none
    integer :: traction_entry = 0, damage_entry = 0, slip_entry = 0   !! their entries in the file, 0: none
    real(wp), allocatable :: planes(:)              !! STATEV as of a host before the first call: planes only
    real(wp), allocatable :: carried(:)             !! STATEV with the offset at which they carry the traction
  end type initial_type

contains

  !> Read the group &initial, if there is one.
  subroutine read_initial(text, initial, errors)
    type(text_type), intent(in) :: text                       !! the file
    type(initial_type), intent(out) :: initial                !! initial state
    type(errors_type), intent(inout) :: errors   !! errors are added
    real(wp), allocatable :: traction(:)
    integer :: e, g

    allocate (initial%damage(0), initial%slip(0))
    g = group_index(text, "initial")
    if (g == 0) return
    initial%given = .true.
    do e = text%groups(g)%first, text%groups(g)%last
      select case (text%entries(e)%name)
      case ("traction")
        initial%traction_entry = e
        call get_reals(text, e, traction, errors)
        if (size(traction) == size(initial%traction)) then
          initial%traction = traction
        else if (size(traction) > 0) then
          call fail(errors, of_entry(text, e), integer_text(size(traction)) // &
            " values: expected three (t_N, t_Tx, t_Ty)")
        end if
      case ("damage")
        initial%damage_entry = e
        call get_reals(text, e, initial%damage, errors)
        if (any(initial%damage < 0.0_wp .or. initial%damage > 1.0_wp)) call fail(errors, of_entry(text, e), &
          "expected 0 to 1")
      case ("slip")
        initial%slip_entry = e
        call get_reals(text, e, initial%slip, errors)
      case default
        call unknown_name(text, e, "traction, damage, slip", errors)
      end select
    end do
    if (text%groups(g)%last < text%groups(g)%first) call fail(errors, of_group(text, g), &
      "nothing given: expected traction, damage or slip")
    if (group_index(text, "state") > 0) call fail(errors, of_group(text, g), &
      "a run starts from &initial or from &state, in line " // &
      integer_text(text%groups(group_index(text, "state"))%line) // ": expected the one or the other")
  end subroutine read_initial

  !> Compute the states of &initial, or of a virgin point without this group; the planes must be able to carry the
  !> traction.
  subroutine carry_initial(text, joint, prescribed, replays, initial, errors)
    type(text_type), intent(in) :: text                       !! the file
    type(interface_type), intent(in) :: joint                 !! the interface
    logical, intent(in) :: prescribed(3)                      !! components that the host has
    logical, intent(in) :: replays                            !! whether the host adapter computes the offset
    type(initial_type), intent(inout) :: initial              !! planes and carried are set
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=:), allocatable :: reasons
    real(wp) :: largest
    integer :: e, earlier, i, k, status
    logical :: loaded

    allocate (initial%planes(joint%n_statev))
    initial%planes = 0.0_wp
    initial%carried = initial%planes
    if (.not. initial%given) return
    earlier = errors%n
    associate (n => joint%pattern%n, damage => initial%damage, slip => initial%slip)
      if (all(size(damage) /= [0, 1, n])) call fail(errors, of_entry(text, initial%damage_entry), &
        integer_text(size(damage)) // " values: expected " // one_or(n, 1))
      if (all(size(slip) /= [0, 2, 2*n])) call fail(errors, of_entry(text, initial%slip_entry), &
        integer_text(size(slip)) // " values: expected " // one_or(n, 2) // ", in pairs s_dit, s_dih")
      if (errors%n > earlier) return
      do k = 1, n
        i = plane_statev(k)
        if (size(damage) > 0) initial%planes(i) = damage(min(k, size(damage)))
        if (size(slip) > 0) initial%planes(i + 1:i + 2) = slip(min(2*k, size(slip)) - 1:min(2*k, size(slip)))
      end do
    end associate
    largest = slip_factor*separation_bound(joint)
    if (.not. all(bounded(initial%slip, largest))) call fail(errors, of_entry(text, initial%slip_entry), &
      "expected a magnitude up to " // to_text(largest))
    loaded = any(abs(initial%traction) > 0.0_wp)
    if (any(abs(initial%traction) > 0.0_wp .and. .not. prescribed)) call fail(errors, &
        of_entry(text, initial%traction_entry), "expected t_Ty = 0 with ntens = 2")
    if (replays .and. .not. loaded .and. size(initial%slip) > 0) call fail(errors, &
        of_entry(text, initial%slip_entry), "expected a traction with it: a host's routine computes the " // &
      "offset of a slip only if the stress is not zero")
    if (errors%n > earlier) return
    initial%carried = initial%planes
    call carry_traction(joint, initial%traction, prescribed, initial%carried, status)
    allocate (character(len=0) :: reasons)
    if (status == status_ok) return
    call explain_initial(joint, initial%traction, prescribed, initial%planes, reasons)
    e = initial%traction_entry
    if (e == 0) e = initial%slip_entry
    call fail_lines(errors, of_entry(text, e), reasons)
  end subroutine carry_initial

  !> Text of the admissible numbers of values: for all planes, or for each plane.
  pure function one_or(n, each) result(text)
    integer, intent(in) :: n      !! planes
    integer, intent(in) :: each   !! values of a plane
    character(len=:), allocatable :: text
    text = integer_text(each) // " for all planes"
    if (n > 1) text = text // " or " // integer_text(each*n) // " for " // integer_text(n) // " planes"
  end function one_or

end module asperity_case_initial
