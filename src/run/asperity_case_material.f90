!> PROPS from the groups &material, &pattern and &replay of a case file.
module asperity_case_material
  use asperity_checks, only: prop_admissible, review_props
  use asperity_contract, only: max_inclined, min_inclined, n_fixed_props, n_required_props, p_damage0, &
    p_eta, p_flat, p_gc, p_gc2, p_kc, p_m, p_sigma0, p_sigma02, p_theta, p_turn, prop_table, status_ok
  use asperity_errors, only: errors_type, fail, fail_lines
  use asperity_kinds, only: wp
  use asperity_material, only: joint_constants, least_joint_stiffness
  use asperity_text, only: integer_text, to_text
  use asperity_case_text, only: of_entry, group_index, of_group, listed, text_type, unknown_name
  use asperity_case_values, only: get_integer, get_real, get_reals, get_switch
  use asperity_text_file, only: lower
  implicit none
  private
  public :: read_props, prop_entries, in_group

  !> Entries of &material for a joint without bond: stiffness in closing and in shear.
  character(len=*), parameter :: joint_entries(2) = ["kn", "ks"]

contains

  !> PROPS from &material, &pattern and &replay, every bad value reported.
  subroutine read_props(text, props, errors)
    type(text_type), intent(in) :: text                       !! the file
    real(wp), allocatable, intent(out) :: props(:)            !! PROPS, admissible if nothing was appended
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=*), parameter :: groups(3) = [character(len=8) :: "material", "pattern", "replay"]
    !> Entries of &replay that are no constants; they are read elsewhere.
    character(len=*), parameter :: of_replay(5) = [character(len=8) :: "file", "through", "ntens", "dtime", "block"]
    logical :: given(n_fixed_props)
    real(wp), allocatable :: normals(:), weights(:)
    real(wp) :: stiffness(2)
    integer :: of_joint(2)   ! entries kn and ks, 0: none
    character(len=:), allocatable :: known
    integer :: e, g, i, k, sides

    props = admissible_props()
    given = .false.
    of_joint = 0
    stiffness = 1.0_wp
    allocate (normals(0), weights(0))
    do k = 1, size(groups)
      g = group_index(text, trim(groups(k)))
      if (g == 0) cycle
      known = prop_entries(trim(groups(k)))
      if (groups(k) == "material") known = known // ", " // listed(joint_entries, "")
      if (groups(k) == "pattern") known = "sides, " // known // ", normals, weights"
      if (groups(k) == "replay") known = listed(of_replay, "") // ", " // known
      do e = text%groups(g)%first, text%groups(g)%last
        i = prop_index(text%entries(e)%name, trim(groups(k)))
        if (i > 0) then
          given(i) = .true.
          call set_prop(text, e, i, props, errors)
        else if (groups(k) == "material" .and. any(text%entries(e)%name == joint_entries)) then
          i = findloc(joint_entries, text%entries(e)%name, dim=1)
          of_joint(i) = e
          call get_real(text, e, stiffness(i), errors)
          if (.not. (stiffness(i) >= least_joint_stiffness .and. stiffness(i) <= prop_table(p_sigma0)%upper)) then
            call fail(errors, of_entry(text, e), "expected > 0 (1e-44 to 1e50)")
          end if
        else if (groups(k) == "pattern" .and. text%entries(e)%name == "sides") then
          given(p_m) = .true.
          sides = 0
          call get_integer(text, e, 0, max_inclined, sides, errors)
          if (sides > 0 .and. sides < min_inclined) call fail(errors, of_entry(text, e), &
            "expected 0 (flat) or " // integer_text(min_inclined) // " to " // integer_text(max_inclined))
          props(p_m) = real(sides, wp)
        else if (groups(k) == "pattern" .and. text%entries(e)%name == "normals") then
          call get_reals(text, e, normals, errors)
        else if (groups(k) == "pattern" .and. text%entries(e)%name == "weights") then
          call get_reals(text, e, weights, errors)
        else if (groups(k) /= "replay" .or. all(text%entries(e)%name /= of_replay)) then
          call unknown_name(text, e, known, errors)
        end if
      end do
      if (groups(k) == "material") then
        if (any(of_joint > 0)) call set_joint(text, g, of_joint, stiffness, given, props, errors)
        do i = 1, n_required_props
          if (.not. given(i)) call fail(errors, of_group(text, g), trim(prop_table(i)%name) // &
            " is missing: expected " // trim(prop_table(i)%admissible))
        end do
      else if (groups(k) == "pattern") then
        call add_planes(text, g, given, normals, weights, props, errors)
      end if
    end do
  end subroutine read_props

  !> PROPS that pass every test: defaults, and any value where there is none.
  pure function admissible_props() result(props)
    real(wp) :: props(n_fixed_props)
    props = prop_table%default
    props([p_sigma0, p_gc]) = 1.0_wp
    props(p_eta) = 0.5_wp
  end function admissible_props

  !> Whether constant i has an entry of its name in a group: constants of the law in &material, of the pattern in
  !> &pattern, of host and numerics in &replay. m has none, because `sides` or the list of planes gives it.
  pure function in_group(i, group) result(yes)
    integer, intent(in) :: i                 !! index in PROPS
    character(len=*), intent(in) :: group    !! name of the group
    logical :: yes
    select case (prop_table(i)%owner)
    case ("law")
      yes = group == "material"
    case ("pattern")
      yes = group == "pattern" .and. i /= p_m
    case ("host", "numerics")
      yes = group == "replay"
    case default
      yes = .false.
    end select
  end function in_group

  !> Names of the constants of a group, in the order of PROPS, on request with the defaults of those that have one.
  pure function prop_entries(group, with_defaults) result(text)
    character(len=*), intent(in) :: group             !! name of the group
    logical, intent(in), optional :: with_defaults    !! absent: names alone
    character(len=:), allocatable :: text
    logical :: defaults
    integer :: i
    defaults = .false.
    if (present(with_defaults)) defaults = with_defaults
    text = ""
    do i = 1, n_fixed_props
      if (.not. in_group(i, group)) cycle
      if (len(text) > 0) text = text // ", "
      text = text // trim(prop_table(i)%name)
      if (defaults .and. i > n_required_props) text = text // " = " // to_text(prop_table(i)%default)
    end do
  end function prop_entries

  !> Index in PROPS of an entry of a group; 0: none.
  pure function prop_index(name, group) result(i)
    character(len=*), intent(in) :: name    !! of the entry, lower case
    character(len=*), intent(in) :: group   !! of the group
    integer :: i
    do i = n_fixed_props, 1, -1
      if (in_group(i, group) .and. lower(prop_table(i)%name) == name) exit
    end do
  end function prop_index

  !> One value of PROPS, tested by the library; a bad one is reported and left out.
  subroutine set_prop(text, e, i, props, errors)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: e                                  !! entry
    integer, intent(in) :: i                                  !! index in PROPS
    real(wp), intent(inout) :: props(:)                       !! PROPS
    type(errors_type), intent(inout) :: errors   !! errors are added
    real(wp) :: value
    integer :: earlier
    value = props(i)
    earlier = errors%n
    if (prop_table(i)%scale == "whole") then
      call get_switch(text, e, value, errors)
    else
      call get_real(text, e, value, errors)
    end if
    if (errors%n > earlier) return
    if (prop_admissible(i, value)) then
      props(i) = value
    else
      call fail(errors, of_entry(text, e), "expected " // trim(prop_table(i)%admissible))
    end if
  end subroutine set_prop

  !> Constants of a joint without bond, which is known by kn and ks: the bond gives the stiffness alone.
  subroutine set_joint(text, g, of_joint, stiffness, given, props, errors)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: g                                  !! group &material
    integer, intent(in) :: of_joint(2)                        !! entries kn and ks, 0: none
    real(wp), intent(in) :: stiffness(2)                      !! kn and ks, stress/length
    logical, intent(inout) :: given(:)                        !! which PROPS are given
    real(wp), intent(inout) :: props(:)                       !! PROPS
    type(errors_type), intent(inout) :: errors   !! errors are added
    !> Constants that kn and ks give.
    integer, parameter :: derived(6) = [p_sigma0, p_gc, p_eta, p_sigma02, p_gc2, p_kc]
    integer :: e, i
    do i = 1, 2
      if (of_joint(i) == 0) call fail(errors, of_entry(text, of_joint(3 - i)), "expected " // &
        joint_entries(i) // " beside it")
    end do
    do e = text%groups(g)%first, text%groups(g)%last
      i = prop_index(text%entries(e)%name, "material")
      if (any(i == derived)) then
        call fail(errors, of_entry(text, e), "expected without kn and ks, which give sigma0, Gc, eta and kc")
      else if (i == p_damage0 .and. props(p_damage0) < 1.0_wp) then
        call fail(errors, of_entry(text, e), "expected 1 beside kn and ks, those of a joint without bond")
      end if
    end do
    given(derived) = .true.
    props([p_sigma0, p_gc, p_eta, p_kc]) = joint_constants(stiffness(1), stiffness(2))
    props(p_damage0) = 1.0_wp
    props([p_sigma02, p_gc2]) = 0.0_wp
    if (props(p_kc) > prop_table(p_kc)%upper) call fail(errors, of_entry(text, of_joint(1)), &
      "expected at most 1e10 ks")
  end subroutine set_joint

  !> Listed planes behind the other PROPS.
  subroutine add_planes(text, g, given, normals, weights, props, errors)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: g                                  !! group &pattern
    logical, intent(in) :: given(:)                           !! which PROPS are given
    real(wp), intent(in) :: normals(:)                        !! (3 k) or empty
    real(wp), intent(in) :: weights(:)                        !! (k) or empty
    real(wp), allocatable, intent(inout) :: props(:)          !! PROPS
    type(errors_type), intent(inout) :: errors   !! errors are added
    character(len=:), allocatable :: lines
    integer :: i, k, status

    k = size(weights)
    if (size(normals) == 0 .and. k == 0) then
      if (.not. given(p_m)) call fail(errors, of_group(text, g), &
        "expected sides (0: flat), or normals and weights")
      return
    end if
    if (any(given([p_m, p_theta, p_flat, p_turn]))) call fail(errors, of_group(text, g), &
      "sides, theta, flat, turn do not go with normals and weights: expected the ones or the others")
    if (size(normals) /= 3*k .or. k < 1 .or. k > max_inclined) then
      call fail(errors, of_group(text, g), integer_text(size(normals)) // " values of normals and " // &
        integer_text(k) // " weights: expected three components (N, Tx, Ty) a plane, 1 to " // &
        integer_text(max_inclined) // " planes")
      return
    end if
    props(p_m) = -real(k, wp)
    props = [props, (normals(3*i - 2:3*i), weights(i), i=1, k)]
    lines = ""
    call review_props(props, status, lines, by_name=.true.)
    call fail_lines(errors, of_group(text, g), lines)
  end subroutine add_planes

end module asperity_case_material
