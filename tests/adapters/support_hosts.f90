!> UMAT and VUMATs as their hosts call them, for the suites of the adapters: points, increments and results.
module support_hosts
  use, intrinsic :: iso_fortran_env, only: int32, int64, real32
  use asperity_contract, only: p_h, p_m, p_map, p_theta, p_turn
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use host_routines, only: umat, vumat, vumat_single
  use support_law, only: draw, interface_of, is_nan, same_bits, sf, signalling_nan, table2_with, theta
  implicit none
  private
  public :: accept, call_host, components, density, go_on, host_type, n_routines, part, places, &
    random_increment, same_answer, set_increment, single_3d, thick, umat_3, virgin, vumat_3d

  !> Routines: UMAT with 2, 3 and 6 components and both maps of 6; VUMAT in 2D and 3D, in double and single precision.
  integer, parameter :: n_routines = 8, umat_3 = 2, vumat_3d = 6, single_3d = 8
  integer, parameter :: components(n_routines) = [2, 3, 6, 6, 2, 3, 2, 3]
  integer, parameter :: places(3, n_routines) = reshape([1, 2, 0, 1, 2, 3, 3, 5, 6, 3, 6, 5, 1, 2, 0, 1, 3, 2, &
    1, 2, 0, 1, 3, 2], [3, n_routines])
  real(wp), parameter :: marker = -7.25_wp, density = 2.5e-9_wp, thick = 0.02_wp

  !> Points of a host. Output arguments contain arbitrary values before the call.
  type :: host_type
    integer :: routine = vumat_3d
    real(wp) :: total_time = 1.0_wp, dt = 1.0e-7_wp
    real(wp), allocatable :: props(:)                                 !! PROPS
    real(wp), allocatable :: density(:), stran(:, :), strain(:, :)    !! total strain of the UMAT; increment
    real(wp), dimension(:, :), allocatable :: stress_old, state_old, stress, state
    real(wp), allocatable :: energies_old(:, :), energies(:, :)       !! internal, inelastic; SSE, SPD, SCD
    real(wp), allocatable :: ddsdde(:, :, :)                          !! of the UMAT
  end type host_type

contains

  !> Virgin points of RP-4, Table 2, rotated out of the axes so that no component vanishes by symmetry.
  function virgin(n, routine, index, value) result(host)
    integer, intent(in) :: n, routine                !! number of points, of the routine
    integer, intent(in), optional :: index(:)        !! indices into PROPS
    real(wp), intent(in), optional :: value(:)       !! their values
    type(host_type) :: host
    integer :: ntens, nstatv
    type(interface_type) :: joint
    host%routine = routine
    ntens = components(routine)
    allocate (host%props, source=table2_with([p_m, p_theta, p_turn], [4.0_wp, theta, 10.0_wp]))
    if (routine == 4) host%props(p_map) = 1.0_wp
    if (present(index)) host%props(index) = value
    if (routine > vumat_3d) host%props = real(real(host%props, real32), wp)
    joint = interface_of(host%props)
    nstatv = joint%n_statev
    host%density = spread(density, 1, n)
    host%strain = spread(spread(0.0_wp, 1, ntens), 1, n)
    host%stran = host%strain
    host%stress_old = host%strain
    host%state_old = spread(spread(0.0_wp, 1, nstatv), 1, n)
    host%energies_old = spread(spread(0.0_wp, 1, merge(3, 2, routine < 5)), 1, n)
    host%ddsdde = spread(spread(spread(marker, 1, ntens), 1, ntens), 3, n)
    call spoil(host)
  end function virgin

  !> Arbitrary values in the output arguments.
  subroutine spoil(host)
    type(host_type), intent(inout) :: host   !! the points
    host%stress = reshape(spread(signalling_nan, 1, size(host%strain)), shape(host%strain))
    host%state = reshape(spread(signalling_nan, 1, size(host%state_old)), shape(host%state_old))
    host%energies = reshape(spread(signalling_nan, 1, size(host%energies_old)), shape(host%energies_old))
  end subroutine spoil

  !> The new arrays become the old ones.
  subroutine accept(host)
    type(host_type), intent(inout) :: host   !! the points
    host%stran = host%stran + host%strain
    host%stress_old = host%stress
    host%state_old = host%state
    host%energies_old = host%energies
    call spoil(host)
  end subroutine accept

  !> Increment of the separation (N, Tx, Ty) of point i. A tensor shear is half of the slip over h.
  subroutine set_increment(host, i, ds)
    type(host_type), intent(inout) :: host   !! the points
    integer, intent(in) :: i                 !! index of the point
    real(wp), intent(in) :: ds(3)            !! length
    real(wp) :: h
    integer :: k
    do k = 1, 3
      if (places(k, host%routine) == 0) cycle
      h = host%props(p_h)*merge(2.0_wp, 1.0_wp, k > 1 .and. host%routine > 4)
      host%strain(i, places(k, host%routine)) = ds(k)/h
    end do
  end subroutine set_increment

  !> A separate increment for every point, of up to 0.4 s_f in every component.
  subroutine random_increment(host, seed)
    type(host_type), intent(inout) :: host   !! the points
    integer(int64), intent(inout) :: seed    !! state of the generator `draw`
    real(wp) :: ds(3)
    integer :: i
    do i = 1, size(host%strain, 1)
      call draw(seed, ds)
      call set_increment(host, i, 0.4_wp*sf*ds)
    end do
  end subroutine random_increment

  !> Increments of points that are new or go on.
  subroutine go_on(host, seed, increments)
    type(host_type), intent(inout) :: host   !! the points
    integer(int64), intent(inout) :: seed    !! state of the generator `draw`
    integer, intent(in) :: increments        !! number of increments
    integer :: i
    do i = 1, increments
      if (.not. is_nan(host%stress(1, 1))) call accept(host)
      call random_increment(host, seed)
      call call_host(host)
    end do
  end subroutine go_on

  !> Points first..last, with their results.
  function part(host, first, last) result(few)
    type(host_type), intent(in) :: host   !! the points
    integer, intent(in) :: first, last    !! points
    type(host_type) :: few
    few = host
    few%density = host%density(first:last)
    few%strain = host%strain(first:last, :)
    few%stran = host%stran(first:last, :)
    few%stress_old = host%stress_old(first:last, :)
    few%state_old = host%state_old(first:last, :)
    few%energies_old = host%energies_old(first:last, :)
    few%stress = host%stress(first:last, :)
    few%state = host%state(first:last, :)
    few%energies = host%energies(first:last, :)
    few%ddsdde = host%ddsdde(:, :, first:last)
  end function part

  !> Call the routine. Arguments that it does not use contain signalling NaN (VUMAT) or are NULL (UMAT).
  subroutine call_host(host, pnewdt)
    type(host_type), intent(inout) :: host              !! the points
    real(wp), intent(inout), optional :: pnewdt         !! PNEWDT; absent: NULL
    real(wp) :: unset(size(host%density), 9), none(size(host%density)), e(3), d(size(host%strain, 2), &
      size(host%strain, 2)), stress(size(host%strain, 2)), state(size(host%state_old, 2))
    integer :: i, n, ntens, nstatv, nprops
    n = size(host%density)
    ntens = size(host%strain, 2)
    nstatv = size(host%state_old, 2)
    nprops = size(host%props)
    unset = signalling_nan
    none = signalling_nan
    if (host%routine > vumat_3d) then
      call call_single(host)
    else if (host%routine > 4) then
      call vumat(n, 1, ntens - 1, nstatv, 1, nprops, 0, host%total_time, host%total_time, host%dt, repeat("A", 80), &
        unset, none, host%props, host%density, host%strain, unset, none, unset, unset, unset, host%stress_old, &
        host%state_old, host%energies_old(:, 1), host%energies_old(:, 2), none, unset, unset, unset, host%stress, &
        host%state, host%energies(:, 1), host%energies(:, 2))
    else
      do i = 1, n
        stress = host%stress_old(i, :)
        state = host%state_old(i, :)
        d = host%ddsdde(:, :, i)
        e = host%energies(i, :)
        call umat(stress, state, d, e(1), e(2), e(3), stran=host%stran(i, :), dstran=host%strain(i, :), dtime=host%dt, &
          cmname="x", ndi=1, nshr=ntens - 1, ntens=ntens, nstatv=nstatv, props=host%props, nprops=nprops, pnewdt=pnewdt)
        host%stress(i, :) = stress
        host%state(i, :) = state
        host%ddsdde(:, :, i) = d
        host%energies(i, :) = e
      end do
    end if
  end subroutine call_host

  !> Call the VUMAT of single precision.
  subroutine call_single(host)
    type(host_type), intent(inout) :: host   !! the points
    real(real32) :: unset(size(host%density), 9), none(size(host%density)), time(2)
    real(real32), allocatable :: stress(:, :), state(:, :), energies(:, :)
    integer :: n, ntens
    n = size(host%density)
    ntens = size(host%strain, 2)
    unset = transfer(int(z"7FA00000", int32), 1.0_real32)
    none = unset(1, 1)
    allocate (stress, source=unset(:, :ntens))
    allocate (state, source=spread(none, 2, size(host%state_old, 2)))
    allocate (energies, source=unset(:, :2))
    time = real([host%total_time, host%dt], real32)
    call vumat_single(n, 1, ntens - 1, size(state, 2), 1, size(host%props), 0, time(1), time(1), time(2), &
      repeat("A", 80), unset, none, real(host%props, real32), real(host%density, real32), real(host%strain, real32), &
      unset, none, unset, unset, unset, real(host%stress_old, real32), real(host%state_old, real32), &
      real(host%energies_old(:, 1), real32), real(host%energies_old(:, 2), real32), none, unset, unset, unset, stress, &
      state, energies(:, 1), energies(:, 2))
    host%stress = real(stress, wp)
    host%state = real(state, wp)
    host%energies = real(energies, wp)
  end subroutine call_single

  !> Whether two calls gave the same bits.
  function same_answer(a, b) result(same)
    type(host_type), intent(in) :: a, b   !! after the call
    logical :: same
    same = same_bits([a%stress], [b%stress]) .and. same_bits([a%state], [b%state]) .and. &
      same_bits([a%energies], [b%energies]) .and. same_bits([a%ddsdde], [b%ddsdde])
  end function same_answer

end module support_hosts
