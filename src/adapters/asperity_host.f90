!> What the host adapters share: component orders, the test of their input, and the rejection of a call.
module asperity_host
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_checks, only: all_bounded, append, bounded, integer_text, review_props, to_text
  use asperity_contract, only: is_damage, n_plane_statev, n_point_statev, status_nstatv, &
    status_ntens, status_ok, status_separation, status_size, status_time, v_offset
  use asperity_interface, only: interface_type, new_interface, separation_bound
  use asperity_points, only: explain_point, explain_time, state_status, time_status
  use asperity_kinds, only: wp
  implicit none
  private
  public :: component_map, vumat_map, host_status, explain_call, explain_vumat, explain_block, reject, request_cut, &
    request_slower_damage

  !> Increment factor asked for when a call is rejected.
  real(wp), parameter, public :: rejected_pnewdt = 0.25_wp
  !> Increment factors asked for where damage grows too fast: the first bounds what one cut costs, the second leaves the
  !> next attempt a margin, as growth need not go with the increment.
  real(wp), parameter, public :: least_pnewdt = 0.1_wp, largest_pnewdt = 0.75_wp
  !> Set by its bits, which raises no floating-point exception.
  real(wp), parameter :: quiet_nan = transfer(int(z"7FF8000000000000", int64), 1.0_wp)

contains

  !> Positions of (N, Tx, Ty) among the host's NTENS components; 0: the host has no such component.
  pure function component_map(ntens, map) result(position)
    integer, intent(in) :: ntens   !! 2, 3 or 6
    integer, intent(in) :: map     !! PROPS 10
    integer :: position(3)         !! all 0 if ntens is none of these
    select case (ntens)
    case (2)
      position = [1, 2, 0]
    case (3)
      position = [1, 2, 3]
    case (6)
      position = [3, merge(5, 6, map == 0), merge(6, 5, map == 0)]
    case default
      position = 0
    end select
  end function component_map

  !> Positions of (N, Tx, Ty) in Abaqus/Explicit's cohesive elements; 0: there is no such component.
  pure function vumat_map(ndir, nshr) result(position)
    integer, intent(in) :: ndir   !! direct components: 1
    integer, intent(in) :: nshr   !! shear components: 1 or 2
    integer :: position(3)        !! all 0 if it is another element
    position = 0
    if (ndir == 1 .and. nshr == 1) position = [1, 2, 0]
    if (ndir == 1 .and. nshr == 2) position = [1, 3, 2]
  end function vumat_map

  !> Whether what a host passed for a point is admissible.
  pure function host_status(joint, position, stran, dstran, statev, dtime) result(status)
    type(interface_type), intent(in) :: joint       !! the interface
    integer, intent(in) :: position(3)              !! component_map
    real(wp), intent(in), contiguous :: stran(:), dstran(:)   !! (ntens) strain at the start, increment
    real(wp), intent(in), contiguous :: statev(:)   !! state at the start
    real(wp), intent(in), optional :: dtime         !! time increment
    integer :: status                               !! 0, status_ntens, status_time or those of state_status
    real(wp) :: bound
    status = status_ntens
    if (position(1) == 0) return
    status = time_status(joint, dtime)
    if (status /= status_ok) return
    status = status_separation
    bound = strain_bound(joint)
    if (.not. all_bounded(size(stran), stran, bound)) return
    if (.not. all_bounded(size(dstran), dstran, bound)) return
    status = state_status(joint, statev)
  end function host_status

  !> Largest strain component taken: half, so that start plus increment stays within the separation bound.
  pure function strain_bound(joint) result(bound)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: bound
    bound = 0.5_wp*separation_bound(joint)/joint%h
  end function strain_bound

  !> Say what is wrong with a rejected call: every bad value, and what was expected.
  pure subroutine explain_call(nprops, props, ntens, stran, dstran, nstatv, statev, message, dtime)
    integer, intent(in) :: nprops, nstatv                     !! as passed: an array of a negative size has size 0
    real(wp), intent(in), contiguous :: props(:)              !! PROPS
    integer, intent(in) :: ntens                              !! components of the host
    real(wp), intent(in), contiguous :: stran(:), dstran(:)   !! (ntens) strain at the start, increment
    real(wp), intent(in), contiguous :: statev(:)             !! state at the start
    character(len=:), allocatable, intent(inout) :: message   !! lines are appended
    real(wp), intent(in), optional :: dtime                   !! time increment
    real(wp), parameter :: rest(3) = 0.0_wp
    type(interface_type) :: joint
    integer :: i, position(3), status

    position = component_map(ntens, 0)
    if (position(1) == 0) call append(message, "NTENS = " // integer_text(ntens) // ": expected 2, 3 or 6")
    call review_props(props, status, message, nprops)
    if (status /= status_ok) return
    call new_interface(props, joint, status)
    do i = 1, size(stran)
      call review_value("STRAN", i, stran(i), strain_bound(joint), message)
      call review_value("DSTRAN", i, dstran(i), strain_bound(joint), message)
    end do
    call explain_time(joint, "DTIME", message, dtime)
    if (nstatv < 0) then
      call append(message, "NSTATV = " // integer_text(nstatv) // ": expected at least " // &
        integer_text(joint%n_statev))
      return
    end if
    call explain_point(joint, rest, rest, statev, message)
  end subroutine explain_call

  !> Say what is wrong with a VUMAT call as a whole.
  pure subroutine explain_vumat(status, nblock, nprops, props, ndir, nshr, nstatev, dt, message)
    integer, intent(in) :: status                             !! of the test that failed
    integer, intent(in) :: nblock, nprops                     !! as the host passed them
    real(wp), intent(in), contiguous :: props(:)              !! PROPS
    integer, intent(in) :: ndir, nshr, nstatev                !! as the host passed them
    real(wp), intent(in) :: dt                                !! time increment
    character(len=:), allocatable, intent(inout) :: message   !! lines are appended
    type(interface_type) :: joint
    integer :: props_status
    call review_props(props, props_status, message, nprops)
    if (props_status /= status_ok) return
    call new_interface(props, joint, props_status)
    if (status == status_ntens) then
      call append(message, "ndir, nshr = " // integer_text(ndir) // ", " // integer_text(nshr) // &
        ": expected 1, 2 or (2D) 1, 1")
    else if (status == status_nstatv) then
      call append(message, "nstatev = " // integer_text(nstatev) // ": expected at least " // &
        integer_text(joint%n_statev))
    else if (status == status_size) then
      call append(message, "nblock = " // integer_text(nblock) // " points: expected 0 or more")
    else if (status == status_time) then
      call explain_time(joint, "dt", message, dt)
    else
      call append(message, "PROPS: constants of the law leave the range of the host's real kind: expected other units")
    end if
  end subroutine explain_vumat

  !> Say what is wrong with point i of a block; nothing is appended if nothing is.
  pure subroutine explain_block(joint, i, strain, bound, state, slip_bound, message)
    type(interface_type), intent(in) :: joint                 !! the interface
    integer, intent(in) :: i                                  !! point
    real(wp), intent(in) :: strain(:)                         !! its strain increment
    real(wp), intent(in) :: bound                             !! largest magnitude of that
    real(wp), intent(in), contiguous :: state(:)              !! STATEV
    real(wp), intent(in) :: slip_bound                        !! largest magnitude of the offsets and slips in it
    character(len=:), allocatable, intent(inout) :: message   !! lines are appended
    character(len=:), allocatable :: lines
    real(wp), parameter :: rest(3) = 0.0_wp
    integer :: j
    allocate (character(len=0) :: lines)
    do j = 1, size(strain)
      call review_value("strainInc", j, strain(j), bound, lines)
    end do
    call explain_point(joint, rest, rest, state, lines)
    if (len(lines) == 0) then
      ! the range of single precision is narrower
      do j = v_offset, joint%n_statev
        if (.not. is_damage(j)) call review_value("STATEV", j, state(j), slip_bound, lines)
      end do
    end if
    if (len(lines) > 0) call append(message, "point " // integer_text(i) // " of the block: " // lines)
  end subroutine explain_block

  !> Add a line to the message if a value is not finite or too large.
  pure subroutine review_value(name, i, value, bound, message)
    character(len=*), intent(in) :: name                      !! of the array
    integer, intent(in) :: i                                  !! component
    real(wp), intent(in) :: value                             !! any bits
    real(wp), intent(in) :: bound                             !! largest magnitude
    character(len=:), allocatable, intent(inout) :: message   !! lines so far
    if (.not. bounded(value, bound)) call append(message, name // "(" // integer_text(i) // ") = " // &
      to_text(value) // ": expected a finite number of magnitude up to " // to_text(bound))
  end subroutine review_value

  !> Ask the host for a smaller increment: PNEWDT may arrive as 1 (Abaqus), -1 (CalculiX) or absent (Kratos).
  pure subroutine request_cut(factor, pnewdt)
    real(wp), intent(in) :: factor                !! wanted, < 1
    real(wp), intent(inout), optional :: pnewdt   !! the host's suggestion
    if (.not. present(pnewdt)) return
    if (pnewdt > 0.0_wp) then
      pnewdt = min(pnewdt, factor)
    else
      pnewdt = factor
    end if
  end subroutine request_cut

  !> Ask the host for a smaller increment where the damage of a plane grew by more than PROPS 14.
  pure subroutine request_slower_damage(joint, old, new, pnewdt)
    type(interface_type), intent(in) :: joint               !! the interface
    real(wp), intent(in) :: old(:)                          !! (Np) damage of the planes at the start
    real(wp), intent(in), contiguous :: new(:)              !! STATEV at the end
    real(wp), intent(inout), optional :: pnewdt             !! the host's suggestion
    real(wp) :: growth
    growth = maxval(new(n_point_statev + 1:joint%n_statev:n_plane_statev) - old)
    if (growth > joint%dalpha) then
      call request_cut(max(least_pnewdt, min(largest_pnewdt, joint%dalpha/growth)), pnewdt)
    end if
  end subroutine request_slower_damage

  !> Fill what a rejected call returns with NaN, so that the host's solver stops.
  pure subroutine reject(stress, tangent)
    real(wp), intent(inout) :: stress(:)         !! filled with NaN
    real(wp), intent(inout) :: tangent(:, :)     !! filled with NaN
    stress = quiet_nan
    tangent = quiet_nan
  end subroutine reject

end module asperity_host
