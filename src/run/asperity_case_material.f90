!> PROPS in the groups &material, &pattern and &replay of a case file.
module asperity_case_material
  use asperity_case_entries, only: case_io, close_group, find_entry, integer_entry, open_group, real_entry, &
    reals_entry, require, switch_entry
  use asperity_case_text, only: of_group
  use asperity_checks, only: prop_admissible, review_props
  use asperity_contract, only: max_inclined, min_inclined, n_fixed_props, n_listed_values, n_required_props, &
    p_eta, p_flat, p_gc, p_kc, p_m, p_sigma0, p_theta, p_turn, prop_table
  use asperity_errors, only: error_type, fail
  use asperity_kinds, only: wp
  use asperity_material, only: joint_constants, joint_props, least_joint_stiffness
  use asperity_text, only: integer_text, set_text
  implicit none
  private
  public :: props_groups, prop_entries

contains

  !> PROPS in the groups &material and &pattern; in reading every bad value is reported.
  subroutine props_groups(io, props, stiffness)
    type(case_io), intent(inout) :: io                        !! the file
    real(wp), allocatable, intent(inout) :: props(:)          !! PROPS; read: admissible if no error was added
    real(wp), intent(inout) :: stiffness(2)                   !! kn and ks of a joint without bond, 0: none
    real(wp), allocatable :: normals(:), weights(:)
    logical :: given(n_fixed_props), is_there
    integer :: i, sides

    if (.not. io%writes) props = admissible_props()
    given = .false.
    is_there = .true.
    call open_group(io, "material", is_there)
    if (is_there) then
      call joint_entries(io, stiffness, props, given)
      call close_group(io)
      do i = 1, n_required_props
        if (.not. (given(i) .or. io%writes)) call fail(io%errors, of_group(io%text, io%group), &
          trim(prop_table(i)%name) // " is missing: expected " // trim(prop_table(i)%admissible))
      end do
    end if
    is_there = .true.
    call open_group(io, "pattern", is_there)
    if (.not. is_there) return
    allocate (normals(0), weights(0))
    sides = 0
    if (io%writes) sides = nint(props(p_m))
    if (sides >= 0) then
      call integer_entry(io, "sides", sides, 0, max_inclined, -1)
      given(p_m) = io%is_given
      call require(io, sides == 0 .or. sides >= min_inclined, "expected 0 (flat) or " // integer_text(min_inclined) // &
        " to " // integer_text(max_inclined))
      call prop_entries(io, "pattern", props, given)
    else
      associate (planes => reshape(props(n_fixed_props + 1:), [n_listed_values, -sides]))
        normals = [planes(:3, :)]
        weights = planes(4, :)
      end associate
    end if
    if (.not. io%writes) props(p_m) = real(sides, wp)
    call reals_entry(io, "normals", normals)
    call reals_entry(io, "weights", weights)
    call close_group(io)
    if (.not. io%writes) call add_planes(io, given, normals, weights, props)
  end subroutine props_groups

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
    character(len=8), parameter :: owners(4) = ["law     ", "pattern ", "host    ", "numerics"]
    character(len=8), parameter :: groups(4) = ["material", "pattern ", "replay  ", "replay  "]
    yes = any(owners == prop_table(i)%owner .and. groups == group) .and. i /= p_m
  end function in_group

  !> The constants of a group, tested by the library; a bad value is left out. Defaults are not written.
  subroutine prop_entries(io, group, props, given)
    type(case_io), intent(inout) :: io           !! the file
    character(len=*), intent(in) :: group        !! name of the group
    real(wp), intent(inout) :: props(:)          !! PROPS
    logical, intent(inout) :: given(:)           !! which PROPS are given
    real(wp) :: value
    integer :: i
    do i = 1, n_fixed_props
      if (.not. in_group(i, group)) cycle
      if (io%writes .and. given(i)) cycle
      value = props(i)
      if (prop_table(i)%scale == "whole") then
        call switch_entry(io, trim(prop_table(i)%name), value, prop_table(i)%default)
      else if (i <= n_required_props) then
        call real_entry(io, trim(prop_table(i)%name), value)
      else
        call real_entry(io, trim(prop_table(i)%name), value, prop_table(i)%default)
      end if
      given(i) = io%is_given
      if (prop_admissible(i, value)) props(i) = value
      call require(io, prop_admissible(i, value), "expected " // trim(prop_table(i)%admissible))
    end do
  end subroutine prop_entries

  !> The entries of &material. A joint without bond is known by kn and ks: the bond gives the stiffness alone.
  subroutine joint_entries(io, stiffness, props, given)
    type(case_io), intent(inout) :: io                        !! the file
    real(wp), intent(inout) :: stiffness(2)                   !! kn and ks, stress/length, 0: none
    real(wp), intent(inout) :: props(:)                       !! PROPS
    logical, intent(inout) :: given(:)                        !! which PROPS are given
    integer, parameter :: damage = size(joint_props)
    character(len=*), parameter :: names(2) = ["kn", "ks"]
    type(error_type) :: places(2)
    logical :: are_there(2)
    integer :: i
    are_there = stiffness > 0.0_wp
    if (io%writes) then
      given(joint_props) = all(are_there)
    else
      stiffness = 1.0_wp
    end if
    call prop_entries(io, "material", props, given)
    do i = 1, 2
      call real_entry(io, names(i), stiffness(i), given=are_there(i))
      places(i) = io%place
      call require(io, stiffness(i) >= least_joint_stiffness .and. stiffness(i) <= prop_table(p_sigma0)%upper, &
        "expected > 0 (1e-44 to 1e50)")
    end do
    if (io%writes) return
    where (.not. are_there) stiffness = 0.0_wp
    if (.not. any(are_there)) return
    do i = 1, 2
      if (.not. are_there(i)) call fail(io%errors, places(3 - i), "expected " // names(i) // " beside it")
    end do
    do i = 1, damage
      call find_entry(io, trim(prop_table(joint_props(i))%name))
      if (i < damage) call require(io, .false., "expected without kn and ks, which give sigma0, Gc, eta and kc")
    end do
    call require(io, props(joint_props(damage)) >= 1.0_wp, "expected 1 beside kn and ks, those of a joint without bond")
    given(joint_props) = .true.
    if (.not. all(stiffness > 0.0_wp)) return
    props(joint_props) = joint_constants(stiffness(1), stiffness(2))
    if (props(p_kc) > prop_table(p_kc)%upper) call fail(io%errors, places(1), "expected at most 1e10 ks")
  end subroutine joint_entries

  !> Listed planes behind the other PROPS.
  subroutine add_planes(io, given, normals, weights, props)
    type(case_io), intent(inout) :: io                        !! the file, its group &pattern
    logical, intent(in) :: given(:)                           !! which PROPS are given
    real(wp), intent(in) :: normals(:)                        !! (3 k) or empty
    real(wp), intent(in) :: weights(:)                        !! (k) or empty
    real(wp), allocatable, intent(inout) :: props(:)          !! PROPS
    character(len=:), allocatable :: lines
    integer :: i, k, status

    k = size(weights)
    call set_text(lines, "")
    if (size(normals) == 0 .and. k == 0) then
      if (.not. given(p_m)) call set_text(lines, "expected sides (0: flat), or normals and weights")
    else if (any(given([p_m, p_theta, p_flat, p_turn]))) then
      call set_text(lines, "sides, theta, flat, turn do not go with normals and weights: expected the ones or " // &
        "the others")
    else if (size(normals) /= 3*k .or. k < 1 .or. k > max_inclined) then
      call set_text(lines, integer_text(size(normals)) // " values of normals and " // integer_text(k) // &
        " weights: expected three components (N, Tx, Ty) a plane, 1 to " // integer_text(max_inclined) // " planes")
    else
      props(p_m) = -real(k, wp)
      props = [props, (normals(3*i - 2:3*i), weights(i), i=1, k)]
      call review_props(props, status, lines, by_name=.true.)
    end if
    call fail(io%errors, of_group(io%text, io%group), lines)
  end subroutine add_planes

end module asperity_case_material
