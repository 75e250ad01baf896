!> UMAT of Abaqus/Standard, CalculiX and Kratos.
!>
!> docs/reference/contract.md describes PROPS, STATEV and the component orders. DDSDDE is the consistent tangent; it is
!> unsymmetric (Abaqus: UNSYMM) but with IMPL-EX. Hosts may pass NULL for the optional arguments. SSE, SPD and SCD are
!> written, but never read. STRESS is read only at the first call of a point (STATEV 5 is 0), as the initial traction.
!> DTIME is read only for viscous damage (PROPS 13), the dashpot (PROPS 24) and IMPL-EX (PROPS 25), KINC for IMPL-EX,
!> PREDEF and DPRED for water (PROPS 23). STRESS is the total traction: the law acts on it without the water pressure.
!> A rejected call fills STRESS and DDSDDE with NaN and does not change STATEV.
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, &
                dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, &
                dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
  use asperity_call_checks, only: explain_call, host_order, host_status
  use asperity_checks, only: is_pressure
  use asperity_contract, only: max_ntens, max_planes, status_initial, &
    status_ok, status_water, v_friction, v_offset, v_rupture, v_stored
  use asperity_host, only: component_map, explain_water, quiet_nan, rejected_pnewdt, request_cut, &
    request_slower_damage, water_pressure
  use asperity_crushing, only: crushing
  use asperity_implex, only: update_extrapolated
  use asperity_initial, only: carry_traction, explain_initial, first_traction
  use asperity_interface, only: interface_type, new_interface, plane_damage
  use asperity_kinds, only: wp
  use asperity_point, only: update_point_in_place
  use asperity_report, only: report
  use asperity_text, only: append
  implicit none
  integer, intent(in) :: ndi                     !! direct stress components, not used
  integer, intent(in) :: nshr                    !! shear stress components, not used
  integer, intent(in) :: ntens                   !! stress components: 2, 3 or 6
  integer, intent(in) :: nstatv                  !! state variables
  integer, intent(in) :: nprops                  !! material constants
  real(wp), intent(inout) :: stress(ntens)       !! traction: initial (first call) -> at the end, stress
  real(wp), intent(inout) :: statev(nstatv)      !! state, start -> end
  real(wp), intent(inout) :: ddsdde(ntens, ntens)   !! d stress_i/d strain_j, stress
  real(wp), intent(inout) :: sse, spd, scd       !! stored, friction, rupture energy, each divided by h
  real(wp), intent(in) :: stran(ntens)           !! strain at the start (separation/h, engineering shear)
  real(wp), intent(in) :: dstran(ntens)          !! strain increment
  real(wp), intent(in) :: props(nprops)          !! material constants
  character(len=*), intent(in) :: cmname         !! material name, not used (Kratos passes one character)
  real(wp), intent(inout), optional :: pnewdt    !! increment factor, written only to request a cut
  real(wp), intent(in), optional :: dtime        !! time increment, required for viscous damage, dashpot or IMPL-EX
  real(wp), intent(in), optional :: predef(*)    !! predefined fields at the start, required for water
  real(wp), intent(in), optional :: dpred(*)     !! their increments
  ! the following arguments are not used, and NULL in some hosts
  real(wp), intent(inout), optional :: rpl, ddsddt(*), drplde(*), drpldt
  real(wp), intent(in), optional :: time(*), temp, dtemp, coords(*), drot(*), celent, &
    dfgrd0(*), dfgrd1(*)
  integer, intent(in), optional :: noel, npt, layer, kspt, kstep
  integer, intent(in), optional :: kinc          !! increment of the step, read for IMPL-EX
  type(interface_type) :: joint
  real(wp) :: from(3), to(3), traction(3), tangent(3, 3), layer_stiffness, damage(max_planes), factor, &
    in_proportion(3), p
  character(len=:), allocatable :: message
  integer :: i, n, position(3), status
  logical :: endless, first, reordered

  call new_interface(props, joint, status)
  position = component_map(ntens, joint%map)
  ! the law and IMPL-EX take their state variables in one piece each
  reordered = .false.
  if (status == status_ok) reordered = joint%cap%peak > 0.0_wp .and. joint%implex > 0.0_wp .and. &
    nstatv >= joint%n_umat_statev
  if (reordered) statev(:joint%n_umat_statev) = statev(host_order(joint))
  if (status == status_ok) status = host_status(joint, position, ntens, stran, dstran, nstatv, statev, &
    dtime)
  p = 0.0_wp
  if (status == status_ok .and. joint%water > 0) then
    ! at the start and at the end
    p = water_pressure(joint, predef)
    if (is_pressure(p)) p = water_pressure(joint, predef, dpred)
    if (.not. is_pressure(p)) status = status_water
  end if
  if (status == status_ok) then
    traction = 0.0_wp
    from = 0.0_wp
    to = 0.0_wp
    do i = 1, 3
      if (position(i) == 0) cycle
      traction(i) = stress(position(i))
      from(i) = joint%h*stran(position(i))
      to(i) = joint%h*(stran(position(i)) + dstran(position(i)))
    end do
    if (first_traction(traction, statev)) then
      traction(1) = traction(1) + water_pressure(joint, predef)
      call carry_traction(joint, traction, position > 0, statev, status, in_proportion, endless)
      ! the initial traction belongs to the separation at the start, which is not zero in every host
      if (status == status_ok) statev(v_offset:v_offset + 2) = statev(v_offset:v_offset + 2) - from
    end if
  end if
  if (status /= status_ok) then
    allocate (character(len=0) :: message)
    call explain_call(nprops, props, ntens, stran, dstran, nstatv, statev, message, dtime)
    if (status == status_water) call explain_water(joint, "PREDEF", p, message)
    if (status == status_initial) then
      call explain_initial(joint, traction, position > 0, statev, in_proportion, endless, message)
      if (joint%water > 0) call append(message, "initial t_N: that of STRESS and the water pressure")
    end if
    if (reordered) statev(host_order(joint)) = statev(:joint%n_umat_statev)
    call report("umat", message)
    stress = quiet_nan
    ddsdde = quiet_nan
    call request_cut(rejected_pnewdt, pnewdt)
    return
  end if

  n = joint%pattern%n
  if (joint%dalpha > 0.0_wp) damage(:n) = plane_damage(joint, statev)
  if (joint%implex > 0.0_wp) then
    first = .false.
    if (present(kinc)) first = kinc == 1
    call update_extrapolated(joint, from, to, first, dtime, statev, traction, tangent, factor)
    if (factor < 1.0_wp) call request_cut(factor, pnewdt)
  else
    call update_point_in_place(joint, from, to, statev, traction, tangent, dtime)
  end if
  if (joint%dalpha > 0.0_wp) call request_slower_damage(joint, damage(:n), statev, pnewdt)
  if (joint%water > 0) traction(1) = traction(1) - p

  if (ntens == max_ntens) then
    ! the three components of a solid layer that an interface does not have
    layer_stiffness = joint%r*joint%material%k_n*joint%h
    stress = layer_stiffness*(stran + dstran)
    stress(position) = traction
    ddsdde = 0.0_wp
    do i = 1, ntens
      ddsdde(i, i) = layer_stiffness
    end do
    ddsdde(position, position) = joint%h*tangent
  else
    stress = traction(:ntens)
    ddsdde = joint%h*tangent(:ntens, :ntens)
  end if
  sse = statev(v_stored)/joint%h
  spd = (statev(v_friction) + crushing(joint, statev))/joint%h
  scd = statev(v_rupture)/joint%h
  if (reordered) statev(host_order(joint)) = statev(:joint%n_umat_statev)
end subroutine umat
