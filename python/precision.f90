! One virgin point along a history of separations in single precision, in the shape f2py reads (see asperity_f2py.f90).

!> Take a virgin point along separations by the single-precision law for blocks, in one of three ways.
!>
!> 1: the host passes the separation, rounded, at the start and the end of each increment.
!> 2: the host hands over increments, rounded, which STATEV 6-8 add up, as VUMAT does.
!> 3: as 2, and separation and energies are added up with compensation (Kahan 1965).
subroutine interface_single_replay(nprops, props, way, n, s, stride, n_kept, traction, damage, work, status)
  use, intrinsic :: iso_fortran_env, only: real32, real64
  use asperity_block_single, only: block_type, chunk, new_block, points_type, update_block
  use asperity_contract, only: status_ok, v_damage, v_friction, v_offset, v_rupture
  use asperity_interface, only: interface_type, new_interface
  implicit none
  integer, intent(in) :: nprops                                !! number of constants
  double precision, intent(in) :: props(nprops)                !! admissible PROPS
  integer, intent(in) :: way                                   !! 1, 2 or 3
  integer, intent(in) :: n                                     !! increments
  double precision, intent(in) :: s(3, n)                      !! separation (N, Tx, Ty) at their ends, length
  integer, intent(in) :: stride                                !! increments between returned rows
  integer, intent(in) :: n_kept                                !! n/stride
  double precision, intent(inout) :: traction(3, n_kept)       !! traction, stress
  double precision, intent(inout) :: damage(n_kept)            !! damage
  double precision, intent(inout) :: work(3, n_kept)           !! rupture, friction, work, stress*length
  integer, intent(out) :: status                               !! 0, or the status of the constants
  !f2py threadsafe
  integer, parameter :: wp = real32
  integer, parameter :: ledger(2) = [v_rupture, v_friction]
  type(interface_type) :: joint
  type(block_type) :: block
  real(wp), allocatable :: state(:, :)
  real(wp), dimension(chunk, 3) :: from, to, stress
  real(wp), dimension(3) :: place, place_low, energy, energy_low, before, spent
  double precision :: last(3)
  integer :: i, k
  call new_interface(props, joint, status)
  if (status == status_ok) call new_block(joint, block, status)
  if (status /= status_ok) return
  allocate (state(1, joint%n_statev))
  state = 0.0_wp
  from = 0.0_wp
  to = 0.0_wp
  place = 0.0_wp
  place_low = 0.0_wp
  energy = 0.0_wp
  energy_low = 0.0_wp
  before = 0.0_wp
  last = 0.0d0
  do i = 1, n
    if (way == 1) then
      from(1, :) = real(last, wp)
      to(1, :) = real(s(:, i), wp)
    else
      from(1, :) = 0.0_wp
      to(1, :) = real(s(:, i) - last, wp)
    end if
    if (way == 3) state(1, ledger) = 0.0_wp
    call update_block(block, points_type(from, to, 1, 1, 1), (state), state, stress)
    spent = [state(1, ledger), 0.5_wp*sum((before + stress(1, :))*(to(1, :) - from(1, :)))]
    before = stress(1, :)
    if (way == 2) state(1, v_offset:v_offset + 2) = state(1, v_offset:v_offset + 2) + to(1, :)
    if (way == 3) then
      call add(place, place_low, to(1, :))
      state(1, v_offset:v_offset + 2) = place
      call add(energy, energy_low, spent)
    else
      energy = [spent(:2), energy(3) + spent(3)]
    end if
    last = s(:, i)
    if (modulo(i, stride) == 0 .and. i/stride <= n_kept) then
      k = i/stride
      traction(:, k) = real(stress(1, :), real64)
      damage(k) = real(state(1, v_damage), real64)
      work(:, k) = real(energy, real64)
    end if
  end do

contains

  !> Compensated sum; volatile, so that no optimisation removes the compensation.
  subroutine add(total, low, part)
    real(wp), intent(inout) :: total(3)   !! sums
    real(wp), intent(inout) :: low(3)     !! rounding error of the sums so far
    real(wp), intent(in) :: part(3)       !! terms to add
    real(wp), volatile :: corrected(3), next(3)
    corrected = part - low
    next = total + corrected
    low = (next - total) - corrected
    total = next
  end subroutine add

end subroutine interface_single_replay
