!> VUMAT of Abaqus/Explicit in double precision; the build makes vumat_single of it (CMakeLists.txt).
!>
!> docs/reference/contract.md describes PROPS and STATEV. If a block is rejected, stressNew is filled with NaN and the
!> state does not change.
!>
!> Components: normal, 23 shear, 13 shear = N, Ty, Tx; in 2D: N, Tx. The host passes no total strain, so STATEV 6-8
!> hold the whole separation. PROPS 10 (map), 14 (dalpha) and 15 (r) have no effect. dt is read only for viscous damage
!> (PROPS 13) and the dashpot (PROPS 24). A call with totalTime = 0 is the elastic probe of the packager, which reads
!> stressOld. The first call of a point (STATEV 5 is 0) takes stressOld as the initial traction; every call reads it for
!> the internal energy. Stresses are total: with PROPS 23 the law carries the normal one and the water pressure, which
!> is that column of fieldNew.
!> Old and new arrays are distinct, as in Abaqus/Explicit: the state at the start is read again after the state at the
!> end was written.
subroutine vumat(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, coordMp, &
                 charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, defgradOld, fieldOld, &
                 stressOld, stateOld, enerInternOld, enerInelasOld, tempNew, stretchNew, defgradNew, fieldNew, &
                 stressNew, stateNew, enerInternNew, enerInelasNew)
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64
  use asperity_arrays, only: virgin_tangent
  use asperity_block_double, only: block_type, chunk, columns_bounded, largest_energy, &
    largest_separation, new_block, points_type, update_block
  use asperity_call_checks, only: explain_state, explain_vumat, vumat_status
  use asperity_checks, only: review, state_ranges
  use asperity_contract, only: cap_statev, most_statev, status_initial, status_ok, status_state, status_water, &
    v_friction, v_offset, v_rupture, v_status
  use asperity_crushing, only: exceeds
  use asperity_host, only: explain_water, vumat_map
  use asperity_initial, only: carry_traction, explain_initial, first_traction
  use asperity_interface, only: interface_type, new_interface, slip_factor
  use asperity_kinds, only: wp
  use asperity_point, only: update_point_in_place
  use asperity_report, only: report
  use asperity_text, only: append, integer_text, set_text, to_text
  implicit none
  character(len=*), parameter :: routine = "vumat"
  integer, parameter :: ik = merge(int32, int64, storage_size(1.0_wp) == 32)   ! integers of the size of reals
  integer, intent(in) :: nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal
  real(wp), intent(in) :: stepTime, totalTime, dt
  character(len=*), intent(in) :: cmname
  real(wp), intent(in) :: coordMp(nblock, *), charLength(nblock), props(nprops), density(nblock)
  real(wp), intent(in) :: strainInc(nblock, ndir + nshr)   ! increment of separation/h, tensor shears
  real(wp), intent(in) :: relSpinInc(nblock, *), tempOld(nblock), stretchOld(nblock, *), defgradOld(nblock, *)
  real(wp), intent(in) :: fieldOld(nblock, *), tempNew(nblock), stretchNew(nblock, *), defgradNew(nblock, *)
  real(wp), intent(in) :: fieldNew(nblock, *)
  real(wp), intent(in) :: stressOld(nblock, ndir + nshr), stateOld(nblock, nstatev)
  real(wp), intent(in) :: enerInternOld(nblock), enerInelasOld(nblock)   ! energies per unit mass
  real(wp), intent(inout) :: stressNew(nblock, ndir + nshr), stateNew(nblock, nstatev)
  real(wp), intent(inout) :: enerInternNew(nblock), enerInelasNew(nblock)
  real(wp), parameter :: factor(3) = [1.0_wp, 2.0_wp, 2.0_wp]   ! tensor shears are half the engineering ones
  logical, parameter :: any_sign(3) = .true.   ! strains may be negative
  real(wp), parameter :: least_density = 1.0e3_wp/huge(1.0_wp)
  real(wp), parameter :: quiet_nan = transfer(huge(0_ik), 1.0_wp)   ! from its bits, without an exception
  type(interface_type) :: joint
  type(block_type) :: block
  type(points_type) :: points, seen
  real(wp) :: traction(chunk, 3), elastic(3, 3), h, bound, slip_bound, strain_bounds(3)
  real(wp) :: largest(most_statev), work(chunk), inv_h, inv_mass, least, lost, water
  real(wp), allocatable :: start(:, :)
  real(real64) :: duration, ranges(most_statev)
  character(len=:), allocatable :: message
  integer(ik) :: begun
  integer :: at, component(3), first, i, j, last, n, p, status
  logical :: good, signed(most_statev)

  allocate (character(len=0) :: message)
  component = vumat_map(ndir, nshr)
  duration = 0.0_real64
  call new_interface(real(props, real64), joint, status)
  if (status == status_ok) then
    if ((joint%material%tau_v > 0.0_wp .or. joint%material%damps) .and. totalTime > 0.0_wp) duration = real(dt, real64)
    status = vumat_status(joint, nblock, component, nstatev, duration, real(tiny(1.0_wp), real64), &
      real(huge(1.0_wp), real64))
  end if
  if (status == status_ok) call new_block(joint, block, status, duration)
  if (status == status_ok .and. joint%water > nfieldv) status = status_water
  h = 1.0_wp
  inv_h = 1.0_wp
  bound = 0.0_wp
  elastic = 0.0_wp
  if (status == status_ok) then
    h = real(joint%h, wp)
    inv_h = 1.0_wp/h
    bound = largest_separation*real(joint%material%s0, wp)
    if (.not. totalTime > 0.0_wp) elastic = real(virgin_tangent(joint), wp)
  end if
  at = 0   ! place of the plastic closure, if there is one
  if (status == status_ok .and. joint%cap%peak > 0.0_wp) at = cap_statev(joint%pattern%n, joint%material%wears)
  slip_bound = real(slip_factor, wp)*bound
  strain_bounds = real(min(bound/real(h, real64), real(huge(1.0_wp), real64)), wp)
  if (status == status_ok) then
    call state_ranges(joint%pattern%n, joint%material%wears, real(largest_energy, real64), real(slip_bound, real64), &
      ranges(:joint%n_statev), signed(:joint%n_statev))
    largest(:joint%n_statev) = real(ranges(:joint%n_statev), wp)
  end if

  points%s_old = 0.0_wp
  points%s_new = 0.0_wp
  do first = 1, nblock, chunk
    if (status /= status_ok) exit
    last = min(first + chunk - 1, nblock)
    n = last - first + 1
    good = columns_bounded(n, nblock, strainInc(first, 1), strain_bounds(:ndir + nshr), any_sign(:ndir + nshr))
    if (good) good = columns_bounded(n, nblock, stateOld(first, 1), largest(:joint%n_statev), signed(:joint%n_statev))
    if (.not. good) then
      status = status_state
      exit
    end if
    do j = 1, 3
      if (component(j) > 0) points%s_new(:n, j) = factor(j)*h*strainInc(first:last, component(j))
    end do

    work(:n) = 0.0_wp
    if (joint%water > 0 .and. totalTime > 0.0_wp) then
      if (.not. (waters(fieldOld(first:last, joint%water)) .and. waters(fieldNew(first:last, joint%water)))) then
        status = status_water
        exit
      end if
    end if
    if (totalTime > 0.0_wp) then
      stateNew(first:last, joint%n_statev + 1:) = stateOld(first:last, joint%n_statev + 1:)
      begun = 0_ik   ! negative if it is the first call of a point
      !$omp simd reduction(ior: begun)
      do i = first, last
        begun = ior(begun, iand(transfer(stateOld(i, v_status), 0_ik), huge(0_ik)) - 1_ik)
      end do
      points%n = n
      points%n_new = nblock
      if (begun < 0_ik) then
        if (.not. allocated(start)) allocate (start(chunk, joint%n_statev))
        start(:n, :joint%n_statev) = stateOld(first:last, :joint%n_statev)
        do i = first, last
          if (abs(stateOld(i, v_status)) > 0.0_wp) cycle
          water = 0.0_wp
          if (joint%water > 0) water = fieldOld(i, joint%water)
          call start_point(joint, component, stressOld(i, :), water, bound, start(i - first + 1, :joint%n_statev), &
            status, message)
          if (status /= status_ok) exit
        end do
        if (status /= status_ok) exit
        points%n_old = chunk
        if (at > 0) then
          call shift(points, start(:n, at), seen)
          call update_block(block, seen, start, stateNew(first, 1), traction)
          call crush_points(joint, duration, at, points, start(:n, :joint%n_statev), traction, &
            stateNew(first:last, :joint%n_statev))
        else
          call update_block(block, points, start, stateNew(first, 1), traction)
        end if
      else
        points%n_old = nblock
        if (at > 0) then
          call shift(points, stateOld(first:last, at), seen)
          call update_block(block, seen, stateOld(first, 1), stateNew(first, 1), traction)
          call crush_points(joint, duration, at, points, stateOld(first:last, :joint%n_statev), traction, &
            stateNew(first:last, :joint%n_statev))
        else
          call update_block(block, points, stateOld(first, 1), stateNew(first, 1), traction)
        end if
      end if
      if (joint%water > 0) traction(:n, 1) = traction(:n, 1) - fieldNew(first:last, joint%water)
      do j = 1, 3
        if (component(j) == 0) cycle
        ! trapezoidal rule for the work; as at the first call, a stress that is not finite counts as zero
        !$omp simd
        do p = 1, n
          i = first + p - 1
          stateNew(i, v_offset + j - 1) = stateNew(i, v_offset + j - 1) + points%s_new(p, j)
          work(p) = work(p) + (0.5_wp*factor(j))*(traction(p, j) + finite_part(stressOld(i, component(j))))* &
            strainInc(i, component(j))
          stressNew(i, component(j)) = traction(p, j)
        end do
      end do
    else
      ! the packager's probe: an elastic response; the state does not change
      stateNew(first:last, :) = stateOld(first:last, :)
      do j = 1, 3
        if (component(j) > 0) stressNew(first:last, component(j)) = matmul(points%s_new(:n, :), elastic(j, :)) + &
          stressOld(first:last, component(j))
      end do
    end if

    ! energies per unit mass; zero where the density is zero or so small that they would leave the range of the kind
    !$omp simd
    do p = 1, n
      i = first + p - 1
      lost = ((stateNew(i, v_rupture) - stateOld(i, v_rupture)) + &
              (stateNew(i, v_friction) - stateOld(i, v_friction)))*inv_h
      if (at > 0) lost = lost + (stateNew(i, at + 1) - stateOld(i, at + 1))*inv_h
      least = least_density*max(1.0_wp, abs(work(p)), abs(lost))
      ! one division, which costs more than the products; never by zero, not even in the part that is not used
      inv_mass = 1.0_wp/max(density(i), least)
      enerInternNew(i) = enerInternOld(i) + merge(work(p)*inv_mass, 0.0_wp, density(i) > least)
      enerInelasNew(i) = enerInelasOld(i) + merge(lost*inv_mass, 0.0_wp, density(i) > least)
    end do
  end do
  if (status == status_ok) return

  if (status == status_state) then
    do i = first, last
      do j = 1, ndir + nshr
        call review(message, "strainInc(" // integer_text(j) // ")", real(strainInc(i, j), real64), &
          real(strain_bounds(1), real64), .true.)
      end do
      call explain_state(joint, real(stateOld(i, :), real64), real(largest_energy, real64), real(slip_bound, real64), &
        message)
      if (len(message) > 0) exit
    end do
  end if
  if (status == status_water .and. joint%water > nfieldv) then
    call append(message, "nfieldv = " // integer_text(nfieldv) // " field variables: expected at least " // &
      integer_text(joint%water) // ", as PROPS(23) = " // integer_text(joint%water) // &
      " is the number of the water pressure")
  else if (status == status_water) then
    water = 0.0_wp
    do i = first, last
      water = fieldOld(i, joint%water)
      if (waters([water])) water = fieldNew(i, joint%water)
      if (.not. waters([water])) exit
    end do
    call explain_water(joint, "field", real(water, real64), message)
  end if
  if (status == status_state .or. status == status_initial .or. &
    (status == status_water .and. joint%water <= nfieldv)) then
    call set_text(message, "point " // integer_text(i) // " of the block: " // message)
  else if (status /= status_water) then
    call explain_vumat(status, nblock, nprops, real(props, real64), ndir, nshr, nstatev, duration, message)
  end if
  ! report before writing: the report may end the analysis, and if the host has the other precision, its output arrays
  ! may be too short for what follows
  call report(routine, message)
  stateNew = stateOld
  enerInternNew = enerInternOld
  enerInelasNew = enerInelasOld
  stressNew = quiet_nan

  contains

  !> Whether all values are finite and not negative, by their bits, which raises no floating-point exception.
  pure function waters(p) result(good)
    real(wp), intent(in) :: p(:)   !! any bits
    logical :: good
    integer(ik), parameter :: largest = transfer(huge(1.0_wp), 0_ik)
    integer(ik) :: bits(size(p))
    bits = transfer(p, bits)
    good = all(bits <= largest .and. (bits >= 0_ik .or. iand(bits, huge(0_ik)) == 0_ik))
  end function waters

  !> A number if it is finite, else zero, by its bits, which raises no floating-point exception.
  elemental function finite_part(x) result(y)
    real(wp), intent(in) :: x   !! any bits
    real(wp) :: y
    integer(ik) :: beyond
    beyond = transfer(huge(1.0_wp), 0_ik) - iand(transfer(x, 0_ik), huge(0_ik))
    y = transfer(iand(transfer(x, 0_ik), not(shifta(beyond, bit_size(0_ik) - 1))), 1.0_wp)
  end function finite_part

  !> Separations that the law sees: the plastic closure is added to those of the points. Here and below variables of the
  !> host would be kept in memory, which its loops must not wait for.
  pure subroutine shift(points, kappa, seen)
    type(points_type), intent(in) :: points    !! the points
    real(wp), intent(in) :: kappa(points%n)    !! plastic closure at the start, length
    type(points_type), intent(out) :: seen     !! what the law sees
    seen = points
    seen%s_old(:points%n, 1) = points%s_old(:points%n, 1) + kappa
    seen%s_new(:points%n, 1) = points%s_new(:points%n, 1) + kappa
  end subroutine shift

  !> Take the points of the chunk that the law finds beyond the compressive strength again, in double precision.
  pure subroutine crush_points(joint, duration, at, points, old, traction, new)
    type(interface_type), intent(in) :: joint                   !! the interface
    real(real64), intent(in) :: duration                        !! of the increment, time
    integer, intent(in) :: at                                   !! place of the plastic closure in STATEV
    type(points_type), intent(in) :: points                     !! the points
    real(wp), intent(in) :: old(points%n, joint%n_statev)       !! STATEV of the law at the start
    real(wp), intent(inout) :: traction(chunk, 3)               !! traction at the end, stress
    real(wp), intent(inout) :: new(points%n, joint%n_statev)    !! STATEV at the end
    real(real64) :: state(joint%n_statev), t(3), d(3, 3)
    integer :: k
    do k = 1, points%n
      new(k, at:at + 1) = old(k, at:at + 1)
      if (.not. exceeds(joint, real(traction(k, :), real64), real(old(k, at), real64))) cycle
      state = real(old(k, :), real64)
      call update_point_in_place(joint, real(points%s_old(k, :), real64), real(points%s_new(k, :), real64), state, &
        t, d, duration)
      traction(k, :) = real(t, wp)
      new(k, :) = real(state, wp)
      ! rounded to this kind a closure does not fall
      new(k, at:at + 1) = max(old(k, at:at + 1), new(k, at:at + 1))
    end do
  end subroutine crush_points

  !> First call of a point: set the state so that it carries the initial traction, if there is one, or explain why it
  !> cannot.
  subroutine start_point(joint, component, stress, water, bound, state, status, message)
    type(interface_type), intent(in) :: joint                 !! the interface
    integer, intent(in) :: component(3)                       !! vumat_map
    real(wp), intent(in) :: stress(:)                         !! the host's components, any bits, stress
    real(wp), intent(in) :: water                             !! water pressure at the start, stress
    real(wp), intent(in) :: bound                             !! largest separation, length
    real(wp), intent(inout) :: state(:)                       !! STATEV of the law, planes -> with the initial traction
    integer, intent(out) :: status                            !! 0 or status_initial
    character(len=:), allocatable, intent(inout) :: message   !! lines are appended
    real(real64) :: traction(3), carried(size(state)), in_proportion(3)
    integer :: j
    logical :: endless
    status = status_ok
    traction = 0.0_real64
    do j = 1, 3
      if (component(j) == 0) cycle
      ! a stress that is not finite is not an initial traction: the host left the array undefined
      if (transfer(finite_part(stress(component(j))), 0_ik) /= transfer(stress(component(j)), 0_ik)) return
      traction(j) = real(stress(component(j)), real64)
    end do
    carried = real(state, real64)
    if (.not. first_traction(traction, carried)) return
    traction(1) = traction(1) + real(water, real64)
    call carry_traction(joint, traction, component > 0, carried, status, in_proportion, endless)
    if (status == status_initial) then
      call explain_initial(joint, traction, component > 0, carried, in_proportion, endless, message)
    else if (status == status_ok .and. any(abs(carried(v_offset:v_offset + 2)) > bound)) then
      status = status_initial
      call append(message, "initial traction: expected one that moves the planes by no more than " // &
        to_text(real(bound, real64)))
    end if
    if (status == status_ok) then
      state = real(carried, wp)
    else if (status == status_initial .and. joint%water > 0) then
      call append(message, "initial t_N: that of stressOld and the water pressure")
    end if
  end subroutine start_point
end subroutine vumat
