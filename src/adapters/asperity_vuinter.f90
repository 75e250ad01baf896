!> VUINTER of Abaqus/Explicit in double precision: the joint between two surfaces of a contact pair, at the nodes of the
!> secondary surface; the build makes vuinter_single of it (CMakeLists.txt).
!>
!> docs/how-to/abaqus.md describes it. It is the call of the VUMAT on separations, with h (PROPS 9) as 1. Penetration
!> and pressure are positive in compression: s_N = -rdisp(1), t_N = -stress(1); slips and shears keep their signs. A
!> node begins at rdisp - drdisp of its first call. sfd, spd and scd are what friction, crushing and rupture dissipate
!> in this increment, per area, sed is what is stored. Water (PROPS 23) is refused, as its field is not passed on. Nodes
!> go by blocks: the stress of a rejected block is filled with NaN, and nothing else of its nodes changes.
subroutine vuinter(sfd, scd, spd, svd, stress, fluxSlv, fluxMst, sed, statev, kStep, kInc, nFacNod, nSlvNod, nMstNod, &
                   nSurfDir, nDir, nStateVar, nProps, nTemp, nPred, numDefTfv, jSlvUid, jMstUid, jConMstid, timStep, &
                   timGlb, dTimCur, surfInt, surfSlv, surfMst, rdisp, drdisp, drot, stiffDflt, condDflt, shape, &
                   coordSlv, coordMst, alocaldir, props, areaSlv, tempSlv, dtempSlv, preDefSlv, dpreDefSlv, tempMst, &
                   dtempMst, preDefMst, dpreDefMst)
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_block_double, only: chunk, columns_bounded
  use asperity_contract, only: p_h, status_ok, v_friction, v_offset, v_rupture, v_status, v_stored
  use asperity_crushing, only: crushing_place
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  implicit none
  integer, intent(in) :: nSlvNod                         !! nodes of the secondary surface
  integer, intent(in) :: nDir                            !! components: 2 or 3
  integer, intent(in) :: nStateVar                       !! state variables
  integer, intent(in) :: nProps                          !! material constants
  real(wp), intent(inout) :: stress(nDir, nSlvNod)       !! pressure and shears, start -> end, stress
  real(wp), intent(inout) :: statev(nStateVar, nSlvNod)  !! state, start -> end
  real(wp), intent(inout) :: sed(nSlvNod)                !! stored energy at the end, stress*length
  real(wp), intent(inout) :: sfd(nSlvNod)                !! friction of the increment, stress*length
  real(wp), intent(inout) :: spd(nSlvNod)                !! crushing of the increment, stress*length
  real(wp), intent(inout) :: scd(nSlvNod)                !! rupture of the increment, stress*length
  real(wp), intent(in) :: rdisp(nDir, nSlvNod)           !! penetration and slips at the end, length
  real(wp), intent(in) :: drdisp(nDir, nSlvNod)          !! their increments, length
  real(wp), intent(in) :: dTimCur                        !! time increment
  real(wp), intent(in) :: props(nProps)                  !! material constants
  character(len=*), intent(in) :: surfInt                !! name of the interaction
  ! the following arguments are not used
  integer, intent(in) :: kStep, kInc, nFacNod, nMstNod, nSurfDir, nTemp, nPred, numDefTfv, jSlvUid(*), jMstUid(*), &
    jConMstid(*)
  real(wp), intent(inout) :: svd(*), fluxSlv(*), fluxMst(*)
  real(wp), intent(in) :: timStep, timGlb, drot(*), stiffDflt(*), condDflt(*), shape(*), coordSlv(*), coordMst(*), &
    alocaldir(*), areaSlv(*), tempSlv(*), dtempSlv(*), preDefSlv(*), dpreDefSlv(*), tempMst(*), dtempMst(*), &
    preDefMst(*), dpreDefMst(*)
  character(len=*), intent(in) :: surfSlv, surfMst
  interface
    subroutine vumat(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, coordMp, &
                     charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, defgradOld, fieldOld, &
                     stressOld, stateOld, enerInternOld, enerInelasOld, tempNew, stretchNew, defgradNew, fieldNew, &
                     stressNew, stateNew, enerInternNew, enerInelasNew)
      import :: wp
      implicit none
      integer, intent(in) :: nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal
      real(wp), intent(in) :: stepTime, totalTime, dt
      character(len=*), intent(in) :: cmname
      real(wp), intent(in) :: coordMp(nblock, *), charLength(nblock), props(nprops), density(nblock), &
        strainInc(nblock, ndir + nshr), relSpinInc(nblock, *), tempOld(nblock), stretchOld(nblock, *), &
        defgradOld(nblock, *), fieldOld(nblock, *), stressOld(nblock, ndir + nshr), stateOld(nblock, nstatev), &
        enerInternOld(nblock), enerInelasOld(nblock), tempNew(nblock), stretchNew(nblock, *), &
        defgradNew(nblock, *), fieldNew(nblock, *)
      real(wp), intent(inout) :: stressNew(nblock, ndir + nshr), stateNew(nblock, nstatev), enerInternNew(nblock), &
        enerInelasNew(nblock)
    end subroutine vumat
  end interface
  real(wp), parameter :: far = sqrt(huge(1.0_wp))   ! no position is, and differences stay finite
  type(interface_type) :: joint
  real(wp) :: constants(nProps), factor(max(nDir, 1))
  integer :: column(max(nDir, 1)), at, first, i, status

  constants = props
  if (nProps >= p_h) constants(p_h) = 1.0_wp
  call new_interface(real(constants, real64), joint, status)
  ! the VUMAT refuses these
  if (status == status_ok .and. (nStateVar < joint%n_statev .or. nDir < 2 .or. nDir > 3)) status = -1
  at = 0   ! place of the energy of crushing
  if (status == status_ok) at = crushing_place(joint)
  factor = 1.0_wp
  factor(1) = -1.0_wp
  column = [(i, i=1, size(column))]
  if (nDir == 3) column(2:) = [3, 2]   ! the VUMAT has Ty before Tx
  do first = 1, nSlvNod, chunk
    call update(first, min(first + chunk - 1, nSlvNod))
  end do

contains

  !> A part of the nodes as a block of the VUMAT, whose shear strains are those of a tensor.
  subroutine update(first, last)
    integer, intent(in) :: first, last   !! nodes
    real(wp), dimension(last - first + 1, max(nDir, 1)) :: start, strain, old_stress, new_stress
    real(wp), dimension(last - first + 1, nStateVar) :: old, new
    real(wp), dimension(last - first + 1) :: ones, zeros, work, lost
    real(wp) :: bounds(max(nDir, 1))
    logical :: any_sign(max(nDir, 1))
    integer :: i, k, n
    n = last - first + 1
    any_sign = .true.
    bounds = far
    ones = 1.0_wp
    zeros = 0.0_wp
    work = 0.0_wp
    lost = 0.0_wp
    start = 0.0_wp
    strain = 0.0_wp
    old_stress = 0.0_wp
    old = transpose(statev(:, first:last))
    do i = 1, nDir
      start(:, i) = factor(i)*rdisp(i, first:last)
      strain(:, column(i)) = merge(1.0_wp, 0.5_wp, i == 1)*factor(i)*drdisp(i, first:last)
      old_stress(:, column(i)) = factor(i)*stress(i, first:last)
    end do
    new_stress = old_stress
    new = old
    ! the VUMAT refuses what is not finite, here at the place of the increments
    if (status == status_ok) then
      if (.not. columns_bounded(n, n, start(1, 1), bounds(:nDir), any_sign)) then
        strain(:, column) = start
      else if (columns_bounded(n, n, strain(1, 1), bounds(:nDir), any_sign) .and. &
               columns_bounded(n, n, old(1, v_status), [far], any_sign)) then
        do k = 1, n
          if (abs(old(k, v_status)) > 0.0_wp) cycle
          old(k, v_offset:v_offset + nDir - 1) = start(k, :) - factor*drdisp(:, first + k - 1)
        end do
      end if
    end if
    call vumat(n, 1, nDir - 1, nStateVar, 0, nProps, 0, 1.0_wp, 1.0_wp, dTimCur, surfInt, strain, ones, constants, &
      ones, strain, strain, zeros, strain, strain, strain, old_stress, old, zeros, zeros, zeros, strain, strain, &
      strain, new_stress, new, work, lost)
    do i = 1, nDir
      stress(i, first:last) = factor(i)*new_stress(:, column(i))
    end do
    if (status /= status_ok) return
    bounds = huge(1.0_wp)
    if (.not. columns_bounded(n, n, new_stress(1, 1), bounds(:nDir), any_sign)) return
    statev(:, first:last) = transpose(new)
    sed(first:last) = new(:, v_stored)
    sfd(first:last) = new(:, v_friction) - old(:, v_friction)
    scd(first:last) = new(:, v_rupture) - old(:, v_rupture)
    spd(first:last) = 0.0_wp
    if (at > 0) spd(first:last) = new(:, at) - old(:, at)
  end subroutine update
end subroutine vuinter
