!> Fuzz test of the UMAT: a short history of a point with admissible input; the last call may have invalid arguments.
module fuzz_umat
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_call_checks, only: explain_call, state_status
  use asperity_checks, only: all_bounded
  use asperity_host, only: component_map, largest_pnewdt, least_pnewdt, rejected_pnewdt
  use asperity_text, only: append, integer_text, to_text
  use asperity_contract, only: n_statev, p_dalpha, p_sigma0, p_tau_v, status_ok, v_status
  use asperity_initial, only: explain_initial, first_traction
  use asperity_interface, only: interface_type, new_interface, separation_bound
  use asperity_kinds, only: wp
  use fuzz_draw, only: any_value, draw_props, most_props
  use host_routines, only: umat
  use random_numbers, only: chance, log_uniform, pick, seed_of, uniform
  implicit none
  private
  public :: try_umat

  !> Array elements beyond the host's sizes, which must not change, and their value.
  integer, parameter :: margin = 4, most_ntens = 8, most_statev = 350
  real(wp), parameter :: marker = -7.7e77_wp
  integer(int64), parameter :: marker_bits = transfer(marker, 0_int64)

contains

  !> Run one case; `complaint` is set if something is wrong.
  subroutine try_umat(seed, number, calls, rejected, complaint, inputs)
    integer(int64), intent(in) :: seed, number                  !! of the run, of the case
    integer, intent(out) :: calls                               !! of the UMAT
    logical, intent(out) :: rejected                            !! whether the last call was
    character(len=:), allocatable, intent(inout) :: complaint   !! set if something is wrong
    character(len=:), allocatable, intent(inout) :: inputs      !! of the last call, if something is wrong
    integer(int64) :: stream
    type(interface_type) :: joint
    character(len=80), parameter :: name = "FUZZ"
    real(wp), dimension(most_ntens + margin) :: stran, dstran, stress, start_stress
    real(wp) :: props(most_props + margin), statev(most_statev + margin), ddsdde((most_ntens + margin)**2), &
      before(most_statev + margin), energies(3), dtime, pnewdt, wanted, scale, scale_of_traction
    character(len=:), allocatable :: message
    integer :: i, increment, increments, nprops, nstatv, ntens, status
    logical :: good, has_dtime, has_pnewdt, spoil

    stream = seed_of(seed, number)
    props = marker
    call draw_props(stream, props(:most_props), nprops)
    props(nprops + 1:) = marker
    call new_interface(props(:nprops), joint, status)
    complaint = ""
    inputs = ""
    calls = 0
    rejected = .false.
    if (status /= status_ok) then
      complaint = "admissible PROPS are refused"
      call describe()
      return
    end if
    nstatv = joint%n_statev
    i = pick(stream, 3)
    ntens = merge(6, i + 1, i == 3)
    statev = marker
    statev(:nstatv) = 0.0_wp
    stran = marker
    stran(:ntens) = 0.0_wp
    dstran = marker
    scale = log_uniform(stream, -2.0_wp, 3.0_wp)
    if (chance(stream, 0.02_wp)) scale = 1.0e49_wp
    scale = scale*separation_bound(joint)*1.0e-50_wp/joint%h
    increments = pick(stream, 4)
    spoil = chance(stream, 0.4_wp)
    do increment = 1, increments
      do i = 1, ntens
        dstran(i) = scale*(uniform(stream) - 0.5_wp)
      end do
      dtime = log_uniform(stream, -6.0_wp, 6.0_wp)
      if (chance(stream, 0.1_wp)) dtime = 0.0_wp
      has_dtime = chance(stream, 0.9_wp)
      has_dtime = has_dtime .or. props(p_tau_v) > 0.0_wp
      has_pnewdt = chance(stream, 0.8_wp)
      pnewdt = real(pick(stream, 4) - 2, wp)   ! -1, 0, 1, 2
      if (spoil .and. increment == increments) call spoil_input()
      stress = marker
      ! STRESS is read where STATEV says that the point was never called, by spoilt input too
      if (ishft(transfer(statev(v_status), 0_int64), 1) == 0_int64) call begin()
      ddsdde = marker
      energies = marker
      start_stress = stress
      before = statev
      wanted = pnewdt
      calls = calls + 1
      call call_umat()
      call judge()
      if (rejected .or. len(complaint) > 0) exit
      stran(:ntens) = stran(:ntens) + dstran(:ntens)
    end do
    if (len(complaint) > 0) call describe()

  contains

    !> Draw the initial traction of a point: none, one that the state may carry, or an arbitrary one.
    subroutine begin()
      if (ntens < 1) return
      stress(:ntens) = 0.0_wp
      if (.not. chance(stream, 0.03_wp)) return
      scale_of_traction = log_uniform(stream, -2.0_wp, 2.0_wp)
      do i = 1, ntens
        stress(i) = scale_of_traction*props(p_sigma0)*(uniform(stream) - 0.5_wp)
      end do
      if (chance(stream, 0.05_wp)) stress(ntens) = any_value(stream)
    end subroutine begin

    !> Message about the initial traction, if the state cannot carry it.
    subroutine explain_start()
      real(wp) :: traction(3)
      integer :: position(3), k
      call new_interface(props(:nprops), joint, status)
      position = component_map(ntens, joint%map)
      traction = 0.0_wp
      do k = 1, 3
        if (position(k) > 0) traction(k) = start_stress(position(k))
      end do
      if (first_traction(traction, before(:nstatv))) call explain_initial(joint, traction, position > 0, &
        before(:nstatv), message)
    end subroutine explain_start

    !> Replace one to three of the arguments by arbitrary values.
    subroutine spoil_input()
      integer :: k, n
      n = pick(stream, 3)
      do k = 1, n
        select case (pick(stream, 9))
        case (1, 2)
          i = pick(stream, nprops)
          props(i) = any_value(stream)
        case (3)
          i = pick(stream, max(ntens, 1))
          stran(i) = any_value(stream)
        case (4)
          i = pick(stream, max(ntens, 1))
          dstran(i) = any_value(stream)
        case (5, 6)
          i = pick(stream, max(nstatv, 1))
          statev(i) = any_value(stream)
        case (7)
          dtime = any_value(stream)
          has_dtime = chance(stream, 0.5_wp)
        case (8)
          nprops = min(max(nprops + pick(stream, 3) - 2, 0), most_props)
          nstatv = min(max(nstatv + pick(stream, 3) - 2, 0), most_statev)
        case default
          ntens = pick(stream, most_ntens + 1) - 1
          where (transfer(stran, [0_int64]) == marker_bits) stran = 0.0_wp
          where (transfer(dstran, [0_int64]) == marker_bits) dstran = 0.0_wp
        end select
      end do
    end subroutine spoil_input

    !> Call the UMAT with or without its optional arguments.
    subroutine call_umat()
      if (has_dtime .and. has_pnewdt) then
        call umat(stress, statev, ddsdde, energies(1), energies(2), energies(3), stran=stran, dstran=dstran, &
          dtime=dtime, cmname=name, ndi=1, nshr=2, ntens=ntens, nstatv=nstatv, props=props, nprops=nprops, &
          pnewdt=pnewdt)
      else if (has_dtime) then
        call umat(stress, statev, ddsdde, energies(1), energies(2), energies(3), stran=stran, dstran=dstran, &
          dtime=dtime, cmname=name, ndi=1, nshr=2, ntens=ntens, nstatv=nstatv, props=props, nprops=nprops)
      else if (has_pnewdt) then
        call umat(stress, statev, ddsdde, energies(1), energies(2), energies(3), stran=stran, dstran=dstran, &
          cmname=name, ndi=1, nshr=2, ntens=ntens, nstatv=nstatv, props=props, nprops=nprops, pnewdt=pnewdt)
      else
        call umat(stress, statev, ddsdde, energies(1), energies(2), energies(3), stran=stran, dstran=dstran, &
          cmname=name, ndi=1, nshr=2, ntens=ntens, nstatv=nstatv, props=props, nprops=nprops)
      end if
    end subroutine call_umat

    !> Check that the call was accepted with finite results, or rejected as documented.
    subroutine judge()
      rejected = .true.
      if (ntens > 0) rejected = any(is_nan(stress(:ntens)))
      allocate (character(len=0) :: message)
      ! the explanation takes longer than the call, so that only some accepted calls are explained
      if (rejected .or. mod(number, 16_int64) == 0_int64) then
        if (has_dtime) then
          call explain_call(nprops, props(:nprops), ntens, stran(:ntens), dstran(:ntens), nstatv, &
            before(:nstatv), message, dtime)
        else
          call explain_call(nprops, props(:nprops), ntens, stran(:ntens), dstran(:ntens), nstatv, &
            before(:nstatv), message)
        end if
        if (len(message) == 0) call explain_start()
        if (rejected .neqv. len(message) > 0) call blame("answer and explanation disagree: " // message)
      end if
      if (.not. same(stress(ntens + 1:)) .or. .not. same(ddsdde(ntens**2 + 1:)) .or. &
        .not. same(statev(max(nstatv, 0) + 1:), before(max(nstatv, 0) + 1:))) call blame("wrote beyond its arguments")
      if (rejected) then
        if (.not. same(statev, before)) call blame("a rejected call wrote STATEV")
        if (.not. all(is_nan(stress(:ntens))) .or. .not. all(is_nan(ddsdde(:ntens**2)))) call blame( &
          "a rejected call left stress or tangent")
        if (index(message, ": expected ") == 0 .and. index(message, " it carries ") == 0) then
          call blame("a message without what was expected: " // message)
        end if
        if (wanted > 0.0_wp) then
          wanted = min(wanted, rejected_pnewdt)
        else
          wanted = rejected_pnewdt
        end if
        if (has_pnewdt .and. .not. same([pnewdt], [wanted])) call blame("PNEWDT = " // to_text(pnewdt))
      else
        if (any(transfer([stress(:ntens), ddsdde(:ntens**2), energies], [0_int64]) == marker_bits)) call blame( &
          "something is left undefined")
        if (.not. all_bounded(ntens, stress, huge(1.0_wp))) call blame("a stress is not finite")
        if (.not. all_bounded(ntens**2, ddsdde, huge(1.0_wp))) call blame("a tangent is not finite")
        if (.not. all_bounded(3, energies, huge(1.0_wp))) call blame("an energy is not finite")
        call new_interface(props(:nprops), joint, status)
        if (state_status(joint, statev(:nstatv)) /= status_ok) then
          call blame("its own STATEV would be rejected")
        else if (abs(statev(v_status) - 1.0_wp) > 0.0_wp) then
          call blame("the status is not 1")
        end if
        good = .not. has_pnewdt .or. same([pnewdt], [wanted])
        if (.not. good .and. props(min(p_dalpha, nprops)) > 0.0_wp) good = pnewdt <= largest_pnewdt .and. &
          pnewdt >= least_pnewdt
        if (.not. good) call blame("PNEWDT = " // to_text(pnewdt))
      end if
      deallocate (message)
    end subroutine judge

    !> Add to the complaint.
    subroutine blame(text)
      character(len=*), intent(in) :: text   !! what is wrong
      call append(complaint, text)
    end subroutine blame

    !> Text of all arguments of the last call.
    subroutine describe()
      call append(inputs, "increment " // integer_text(increment) // ", NTENS " // integer_text(ntens) // &
        ", NPROPS " // integer_text(nprops) // ", NSTATV " // integer_text(nstatv))
      call append(inputs, "PROPS" // list(props(:nprops)))
      call append(inputs, "STRAN" // list(stran(:ntens)))
      call append(inputs, "DSTRAN" // list(dstran(:ntens)))
      call append(inputs, "STRESS" // list(start_stress(:ntens)))
      call append(inputs, "STATEV" // list(before(:nstatv)))
      if (has_dtime) call append(inputs, "DTIME" // list([dtime]))
      call append(inputs, "out: STRESS" // list(stress(:ntens)))
      call append(inputs, "out: DDSDDE" // list(ddsdde(:ntens**2)))
      call append(inputs, "out: STATEV" // list(statev(:nstatv)))
      call append(inputs, "out: SSE, SPD, SCD" // list(energies))
    end subroutine describe

  end subroutine try_umat

  !> Text of several numbers.
  function list(x) result(text)
    real(wp), intent(in) :: x(:)   !! any bits
    character(len=:), allocatable :: text
    integer :: i
    text = ""
    do i = 1, size(x)
      text = text // " " // to_text(x(i))
    end do
  end function list

  !> Whether the bits of x equal those of y, or of the marker.
  pure function same(x, y) result(yes)
    real(wp), intent(in) :: x(:)             !! any bits
    real(wp), intent(in), optional :: y(:)   !! any bits, absent: the marker
    logical :: yes
    integer :: i
    yes = .true.
    do i = 1, size(x)
      if (present(y)) then
        yes = yes .and. transfer(x(i), 0_int64) == transfer(y(i), 0_int64)
      else
        yes = yes .and. transfer(x(i), 0_int64) == marker_bits
      end if
    end do
  end function same

  !> Whether the bits are those of a NaN.
  elemental function is_nan(x) result(yes)
    real(wp), intent(in) :: x   !! any bits
    logical :: yes
    yes = iand(transfer(x, 0_int64), huge(0_int64)) > int(z"7FF0000000000000", int64)
  end function is_nan

end module fuzz_umat
