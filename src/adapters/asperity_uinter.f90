!> UINTER of Abaqus/Standard: the joint between two surfaces of a contact pair, at each node of the secondary surface.
!>
!> docs/how-to/abaqus.md describes it. It is the call of the UMAT on separations, with h (PROPS 9) as 1. Penetration and
!> pressure are positive in compression: s_N = -RDISP(1), t_N = -STRESS(1); slips and shears keep their signs. RDISP is
!> the relative position at the end of the increment. SFD, SPD and SCD are what friction, crushing and rupture dissipate
!> in this increment, per area, SED is what is stored. Water (PROPS 23) is refused, as its field is not passed on.
subroutine uinter(stress, ddsddr, dviscous, dstructural, flux, ddfddt, ddsddt, ddfddr, statev, sed, sfd, spd, svd, &
                  scd, pnewdt, rdisp, drdisp, temp, dtemp, predef, dpred, time, dtime, freqr, ciname, secname, &
                  mainname, props, coords, alocaldir, drot, area, chrlngth, node, ndir, nstatv, npred, nprops, mcrd, &
                  kstep, kinc, kit, linper, lopenclose, lstate, lsdi, lprint)
  use asperity_call_checks, only: host_order
  use asperity_checks, only: all_bounded
  use asperity_contract, only: max_ntens, p_h, v_friction, v_rupture
  use asperity_crushing, only: crushing
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  implicit none
  integer, intent(in) :: ndir                        !! components: 2 or 3
  integer, intent(in) :: nstatv                      !! state variables
  integer, intent(in) :: nprops                      !! material constants
  integer, intent(in) :: npred, mcrd                 !! sizes of arrays that are not used
  real(wp), intent(inout) :: stress(ndir)            !! pressure and shears, start -> end, stress
  real(wp), intent(inout) :: ddsddr(ndir, ndir)      !! d stress_i/d rdisp_j, stress/length
  real(wp), intent(inout) :: statev(nstatv)          !! state, start -> end
  real(wp), intent(inout) :: sed                     !! stored energy at the end, stress*length
  real(wp), intent(inout) :: sfd, spd, scd           !! dissipation of the increment, stress*length
  real(wp), intent(inout) :: pnewdt                  !! increment factor, written only to request a cut
  real(wp), intent(in) :: rdisp(ndir)                !! penetration and slips at the end, length
  real(wp), intent(in) :: drdisp(ndir)               !! their increments, length
  real(wp), intent(in) :: dtime                      !! time increment
  real(wp), intent(in) :: props(nprops)              !! material constants
  integer, intent(in) :: kinc                        !! increment of the step, read for IMPL-EX
  integer, intent(inout) :: lopenclose               !! 1: the surfaces are in contact or hold together, 0: neither
  ! the following arguments are not used
  real(wp), intent(inout) :: dviscous(*), dstructural(*), flux(*), ddfddt(*), ddsddt(*), ddfddr(*), svd
  real(wp), intent(in) :: temp(*), dtemp(*), predef(*), dpred(*), time(*), freqr, coords(*), alocaldir(*), drot(*), &
    area, chrlngth
  character(len=*), intent(in) :: ciname, secname, mainname
  integer, intent(in) :: node, kstep, kit, linper, lprint
  integer, intent(inout) :: lstate, lsdi
  interface
    subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, &
                    temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, &
                    celent, dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
      import :: wp
      implicit none
      integer, intent(in) :: ndi, nshr, ntens, nstatv, nprops
      real(wp), intent(inout) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd
      real(wp), intent(in) :: stran(ntens), dstran(ntens), props(nprops)
      character(len=*), intent(in) :: cmname
      real(wp), intent(inout), optional :: pnewdt, rpl, ddsddt(*), drplde(*), drpldt
      real(wp), intent(in), optional :: dtime, predef(*), dpred(*), time(*), temp, dtemp, coords(*), drot(*), celent, &
        dfgrd0(*), dfgrd1(*)
      integer, intent(in), optional :: noel, npt, layer, kspt, kstep, kinc
    end subroutine umat
  end interface
  real(wp), parameter :: rejected = -huge(1.0_wp)   ! a call that is accepted writes the energies
  real(wp), parameter :: far = sqrt(huge(1.0_wp))   ! no separation is, and differences stay finite
  type(interface_type) :: joint
  real(wp) :: traction(max_ntens), tangent(max_ntens**2), s(max_ntens), ds(max_ntens), sign(max_ntens)
  real(wp) :: constants(nprops), old(nstatv), stored, dissipated, rupture
  integer :: i, n, status

  n = max(1, min(ndir, max_ntens - 1))   ! a number of components that no contact has is refused below
  sign = 1.0_wp
  sign(1) = -1.0_wp
  constants = props
  if (nprops >= p_h) constants(p_h) = 1.0_wp
  old = statev
  stored = rejected
  traction(:n) = sign(:n)*stress(:n)
  ds(:n) = sign(:n)*drdisp(:n)
  s(:n) = sign(:n)*rdisp(:n)
  if (all_bounded(n, s, far) .and. all_bounded(n, ds, far)) s(:n) = s(:n) - ds(:n)
  call umat(traction, statev, tangent, stored, dissipated, rupture, stran=s, dstran=ds, cmname=ciname, ndi=1, &
            nshr=n - 1, ntens=n, nstatv=nstatv, props=constants, nprops=nprops, pnewdt=pnewdt, dtime=dtime, kinc=kinc)
  stress(:n) = sign(:n)*traction(:n)
  do i = 1, n
    ddsddr(:n, i) = sign(:n)*sign(i)*tangent((i - 1)*n + 1:i*n)
  end do
  if (stored <= rejected) return
  lopenclose = merge(1, 0, any(abs(traction(:n)) > 0.0_wp))
  call new_interface(constants, joint, status)
  sed = stored
  sfd = statev(v_friction) - old(v_friction)
  scd = rupture - old(v_rupture)
  ! the UMAT tells friction and crushing as one
  if (joint%cap%peak > 0.0_wp .and. joint%implex > 0.0_wp) old(:joint%n_umat_statev) = old(host_order(joint))
  spd = dissipated - statev(v_friction) - crushing(joint, old)
end subroutine uinter
