!> PROPS from the groups &material, &pattern and &replay of a case file.
module case_material
  use asperity_checks, only: review_props
  use asperity_contract, only: max_inclined, min_inclined, n_fixed_props, n_required_props, p_dalpha, p_eta, p_flat, &
    p_gc, p_gc2, p_guard, p_h, p_kc, p_m, p_map, p_mu, p_r, p_sigma0, p_sigma02, p_tau_v, p_theta, p_turn, prop_table, &
    status_ok
  use asperity_kinds, only: wp
  use asperity_text, only: append, integer_text
  use case_text, only: entry_where, group_index, group_where, text_type, unknown_name
  use case_values, only: get_integer, get_real, get_reals, get_switch
  use text_file, only: lower
  implicit none
  private
  public :: read_props

contains

  !> PROPS from &material, &pattern and &replay, every bad value reported.
  subroutine read_props(text, props, mode_2, message)
    type(text_type), intent(in) :: text                       !! the file
    real(wp), allocatable, intent(out) :: props(:)            !! PROPS, admissible if nothing was appended
    logical, intent(out) :: mode_2                            !! tangential strength or energy differ from mode I
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    character(len=*), parameter :: known(3) = [character(len=80) :: &
      "sigma0, Gc, eta, mu, sigma02, Gc2, tau_v, kc, guard", "sides, theta, flat, turn, normals, weights", &
      "file, through, ntens, h, map, dalpha, r, dtime, block"]
    character(len=*), parameter :: owners(3) = [character(len=8) :: "material", "pattern", "replay"]
    logical :: given(n_fixed_props)
    real(wp), allocatable :: normals(:), weights(:)
    integer :: e, g, i, owner, sides

    props = admissible_props()
    given = .false.
    allocate (normals(0), weights(0))
    do owner = 1, size(owners)
      g = group_index(text, trim(owners(owner)))
      if (g == 0) cycle
      do e = text%groups(g)%first, text%groups(g)%last
        i = prop_index(text%entries(e)%name, owner)
        if (i > 0) then
          given(i) = .true.
          call set_prop(text, e, i, props, message)
        else if (owner == 2 .and. text%entries(e)%name == "sides") then
          given(p_m) = .true.
          sides = 0
          call get_integer(text, e, 0, max_inclined, sides, message)
          if (sides > 0 .and. sides < min_inclined) call append(message, entry_where(text, e) // &
            ": expected 0 (flat) or " // integer_text(min_inclined) // " to " // integer_text(max_inclined))
          props(p_m) = real(sides, wp)
        else if (owner == 2 .and. text%entries(e)%name == "normals") then
          call get_reals(text, e, normals, message)
        else if (owner == 2 .and. text%entries(e)%name == "weights") then
          call get_reals(text, e, weights, message)
        else if (owner < 3) then
          call unknown_name(text, e, trim(known(owner)), message)
        else if (all(text%entries(e)%name /= [character(len=8) :: "file", "through", "ntens", "dtime", "block"])) then
          call unknown_name(text, e, trim(known(owner)), message)
        end if
      end do
      if (owner == 1) then
        do i = 1, n_required_props
          if (.not. given(i)) call append(message, group_where(text, g) // trim(prop_table(i)%name) // &
            " is missing: expected " // trim(prop_table(i)%admissible))
        end do
      else if (owner == 2) then
        call add_planes(text, g, given, normals, weights, props, message)
      end if
    end do
    mode_2 = (given(p_sigma02) .and. differs(props(p_sigma02), props(p_sigma0))) .or. &
                  (given(p_gc2) .and. differs(props(p_gc2), props(p_gc)))
  end subroutine read_props

  !> Whether a mode II value is given (not 0) and is not that of mode I.
  pure function differs(value, mode_1) result(yes)
    real(wp), intent(in) :: value    !! of mode II, 0: equal
    real(wp), intent(in) :: mode_1   !! of mode I
    logical :: yes
    yes = value > 0.0_wp .and. abs(value - mode_1) > 0.0_wp
  end function differs

  !> PROPS that pass every test: defaults, and any value where there is none.
  pure function admissible_props() result(props)
    real(wp) :: props(n_fixed_props)
    props = prop_table%default
    props([p_sigma0, p_gc]) = 1.0_wp
    props(p_eta) = 0.5_wp
  end function admissible_props

  !> Index in PROPS of a name of &material, &pattern or &replay; 0: none.
  pure function prop_index(name, owner) result(i)
    character(len=*), intent(in) :: name   !! lower case
    integer, intent(in) :: owner           !! 1, 2 or 3
    integer :: i
    integer, parameter :: of_material(9) = [p_sigma0, p_gc, p_eta, p_mu, p_sigma02, p_gc2, p_tau_v, p_kc, &
      p_guard], of_pattern(3) = [p_theta, p_flat, p_turn], of_replay(4) = [p_h, p_map, p_dalpha, p_r]
    logical :: owned
    do i = n_fixed_props, 1, -1
      select case (owner)
      case (1)
        owned = any(i == of_material)
      case (2)
        owned = any(i == of_pattern)
      case default
        owned = any(i == of_replay)
      end select
      if (owned .and. lower(prop_table(i)%name) == name) exit
    end do
  end function prop_index

  !> One value of PROPS, tested by the library; a bad one is reported and left out.
  subroutine set_prop(text, e, i, props, message)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: e                                  !! entry
    integer, intent(in) :: i                                  !! index in PROPS
    real(wp), intent(inout) :: props(:)                       !! PROPS
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    character(len=:), allocatable :: complaint
    real(wp) :: trial(n_fixed_props)
    integer :: status
    trial = admissible_props()
    if (i == p_guard) then
      call get_switch(text, e, trial(i), message)
    else
      call get_real(text, e, trial(i), message)
    end if
    complaint = ""
    call review_props(trial, status, complaint)
    if (status == status_ok) then
      props(i) = trial(i)
    else
      call append(message, entry_where(text, e) // complaint(index(complaint, ": expected"):))
    end if
  end subroutine set_prop

  !> Listed planes behind the other PROPS.
  subroutine add_planes(text, g, given, normals, weights, props, message)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: g                                  !! group &pattern
    logical, intent(in) :: given(:)                           !! which PROPS are given
    real(wp), intent(in) :: normals(:)                        !! (3 k) or empty
    real(wp), intent(in) :: weights(:)                        !! (k) or empty
    real(wp), allocatable, intent(inout) :: props(:)          !! PROPS
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    character(len=:), allocatable :: complaints
    integer :: first, i, k, status

    k = size(weights)
    if (size(normals) == 0 .and. k == 0) then
      if (.not. given(p_m)) call append(message, group_where(text, g) // &
        "expected sides (0: flat), or normals and weights")
      return
    end if
    if (any(given([p_m, p_theta, p_flat, p_turn]))) call append(message, group_where(text, g) // &
      "sides, theta, flat, turn do not go with normals and weights: expected the ones or the others")
    if (size(normals) /= 3*k .or. k < 1 .or. k > max_inclined) then
      call append(message, group_where(text, g) // integer_text(size(normals)) // " values of normals and " // &
        integer_text(k) // " weights: expected three components (N, Tx, Ty) a plane, 1 to " // &
        integer_text(max_inclined) // " planes")
      return
    end if
    props(p_m) = -real(k, wp)
    props = [props, (normals(3*i - 2:3*i), weights(i), i=1, k)]
    complaints = ""
    call review_props(props, status, complaints)
    do while (len(complaints) > 0)
      i = index(complaints // new_line("a"), new_line("a"))
      first = 1
      if (index(complaints, "PROPS(") == 1) first = index(complaints, ") ") + 2   ! a case file has no PROPS
      call append(message, group_where(text, g) // complaints(first:i - 1))
      complaints = complaints(min(i + 1, len(complaints) + 1):)
    end do
  end subroutine add_planes

end module case_material
