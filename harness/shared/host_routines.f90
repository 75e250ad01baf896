!> Interfaces of the user routines as hosts declare them, for all programs and tests of this repository.
!>
!> The module uses no other module. `procedure(umat)` declares a procedure with the same arguments.
module host_routines
  use, intrinsic :: iso_fortran_env, only: real32, real64
  implicit none
  private
  public :: umat, uinter, vumat, vumat_single, vuinter, vuinter_single

  interface
    !> UMAT; hosts may pass NULL for the arguments that are optional here.
    subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, &
                    temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, &
                    celent, dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
      import :: real64
      implicit none
      integer, intent(in) :: ndi, nshr, ntens, nstatv, nprops
      real(real64), intent(inout) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd
      real(real64), intent(in) :: stran(ntens), dstran(ntens), props(nprops)
      character(len=*), intent(in) :: cmname
      real(real64), intent(inout), optional :: pnewdt, rpl, ddsddt(*), drplde(*), drpldt
      real(real64), intent(in), optional :: time(*), dtime, temp, dtemp, predef(*), dpred(*), coords(*), drot(*), &
        celent, dfgrd0(*), dfgrd1(*)
      integer, intent(in), optional :: noel, npt, layer, kspt, kstep, kinc
    end subroutine umat

    !> UINTER of Abaqus/Standard.
    subroutine uinter(stress, ddsddr, dviscous, dstructural, flux, ddfddt, ddsddt, ddfddr, statev, sed, sfd, spd, svd, &
                      scd, pnewdt, rdisp, drdisp, temp, dtemp, predef, dpred, time, dtime, freqr, ciname, secname, &
                      mainname, props, coords, alocaldir, drot, area, chrlngth, node, ndir, nstatv, npred, nprops, &
                      mcrd, kstep, kinc, kit, linper, lopenclose, lstate, lsdi, lprint)
      import :: real64
      implicit none
      integer, intent(in) :: node, ndir, nstatv, npred, nprops, mcrd, kstep, kinc, kit, linper, lprint
      real(real64), intent(inout) :: stress(ndir), ddsddr(ndir, ndir), statev(nstatv), sed, sfd, spd, scd, pnewdt, &
        dviscous(*), dstructural(*), flux(*), ddfddt(*), ddsddt(*), ddfddr(*), svd
      real(real64), intent(in) :: rdisp(ndir), drdisp(ndir), dtime, props(nprops), temp(*), dtemp(*), predef(*), &
        dpred(*), time(*), freqr, coords(*), alocaldir(*), drot(*), area, chrlngth
      character(len=*), intent(in) :: ciname, secname, mainname
      integer, intent(inout) :: lopenclose, lstate, lsdi
    end subroutine uinter

    !> VUMAT in double precision.
    subroutine vumat(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, &
                     coordMp, charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, &
                     defgradOld, fieldOld, stressOld, stateOld, enerInternOld, enerInelasOld, tempNew, &
                     stretchNew, defgradNew, fieldNew, stressNew, stateNew, enerInternNew, enerInelasNew)
      import :: real64
      implicit none
      integer, intent(in) :: nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal
      real(real64), intent(in) :: stepTime, totalTime, dt
      character(len=*), intent(in) :: cmname
      real(real64), intent(in) :: coordMp(nblock, *), charLength(nblock), props(nprops), density(nblock), &
        strainInc(nblock, ndir + nshr), relSpinInc(nblock, *), tempOld(nblock), stretchOld(nblock, *), &
        defgradOld(nblock, *), fieldOld(nblock, *), stressOld(nblock, ndir + nshr), stateOld(nblock, nstatev), &
        enerInternOld(nblock), enerInelasOld(nblock), tempNew(nblock), stretchNew(nblock, *), &
        defgradNew(nblock, *), fieldNew(nblock, *)
      real(real64), intent(inout) :: stressNew(nblock, ndir + nshr), stateNew(nblock, nstatev), &
        enerInternNew(nblock), enerInelasNew(nblock)
    end subroutine vumat

    !> VUMAT in single precision.
    subroutine vumat_single(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, &
                            coordMp, charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, &
                            defgradOld, fieldOld, stressOld, stateOld, enerInternOld, enerInelasOld, tempNew, &
                            stretchNew, defgradNew, fieldNew, stressNew, stateNew, enerInternNew, enerInelasNew)
      import :: real32
      implicit none
      integer, intent(in) :: nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal
      real(real32), intent(in) :: stepTime, totalTime, dt
      character(len=*), intent(in) :: cmname
      real(real32), intent(in) :: coordMp(nblock, *), charLength(nblock), props(nprops), density(nblock), &
        strainInc(nblock, ndir + nshr), relSpinInc(nblock, *), tempOld(nblock), stretchOld(nblock, *), &
        defgradOld(nblock, *), fieldOld(nblock, *), stressOld(nblock, ndir + nshr), stateOld(nblock, nstatev), &
        enerInternOld(nblock), enerInelasOld(nblock), tempNew(nblock), stretchNew(nblock, *), &
        defgradNew(nblock, *), fieldNew(nblock, *)
      real(real32), intent(inout) :: stressNew(nblock, ndir + nshr), stateNew(nblock, nstatev), &
        enerInternNew(nblock), enerInelasNew(nblock)
    end subroutine vumat_single

    !> VUINTER of Abaqus/Explicit in double precision.
    subroutine vuinter(sfd, scd, spd, svd, stress, fluxSlv, fluxMst, sed, statev, kStep, kInc, nFacNod, nSlvNod, &
                       nMstNod, nSurfDir, nDir, nStateVar, nProps, nTemp, nPred, numDefTfv, jSlvUid, jMstUid, &
                       jConMstid, timStep, timGlb, dTimCur, surfInt, surfSlv, surfMst, rdisp, drdisp, drot, &
                       stiffDflt, condDflt, shape, coordSlv, coordMst, alocaldir, props, areaSlv, tempSlv, dtempSlv, &
                       preDefSlv, dpreDefSlv, tempMst, dtempMst, preDefMst, dpreDefMst)
      import :: real64
      implicit none
      integer, intent(in) :: kStep, kInc, nFacNod, nSlvNod, nMstNod, nSurfDir, nDir, nStateVar, nProps, nTemp, nPred, &
        numDefTfv, jSlvUid(*), jMstUid(*), jConMstid(*)
      real(real64), intent(inout) :: sfd(nSlvNod), scd(nSlvNod), spd(nSlvNod), svd(*), stress(nDir, nSlvNod), &
        fluxSlv(*), fluxMst(*), sed(nSlvNod), statev(nStateVar, nSlvNod)
      real(real64), intent(in) :: timStep, timGlb, dTimCur, rdisp(nDir, nSlvNod), drdisp(nDir, nSlvNod), drot(*), &
        stiffDflt(*), condDflt(*), shape(*), coordSlv(*), coordMst(*), alocaldir(*), props(nProps), areaSlv(*), &
        tempSlv(*), dtempSlv(*), preDefSlv(*), dpreDefSlv(*), tempMst(*), dtempMst(*), preDefMst(*), dpreDefMst(*)
      character(len=*), intent(in) :: surfInt, surfSlv, surfMst
    end subroutine vuinter

    !> VUINTER of Abaqus/Explicit in single precision.
    subroutine vuinter_single(sfd, scd, spd, svd, stress, fluxSlv, fluxMst, sed, statev, kStep, kInc, nFacNod, &
                              nSlvNod, nMstNod, nSurfDir, nDir, nStateVar, nProps, nTemp, nPred, numDefTfv, jSlvUid, &
                              jMstUid, jConMstid, timStep, timGlb, dTimCur, surfInt, surfSlv, surfMst, rdisp, &
                              drdisp, drot, stiffDflt, condDflt, shape, coordSlv, coordMst, alocaldir, props, &
                              areaSlv, tempSlv, dtempSlv, preDefSlv, dpreDefSlv, tempMst, dtempMst, preDefMst, &
                              dpreDefMst)
      import :: real32
      implicit none
      integer, intent(in) :: kStep, kInc, nFacNod, nSlvNod, nMstNod, nSurfDir, nDir, nStateVar, nProps, nTemp, nPred, &
        numDefTfv, jSlvUid(*), jMstUid(*), jConMstid(*)
      real(real32), intent(inout) :: sfd(nSlvNod), scd(nSlvNod), spd(nSlvNod), svd(*), stress(nDir, nSlvNod), &
        fluxSlv(*), fluxMst(*), sed(nSlvNod), statev(nStateVar, nSlvNod)
      real(real32), intent(in) :: timStep, timGlb, dTimCur, rdisp(nDir, nSlvNod), drdisp(nDir, nSlvNod), drot(*), &
        stiffDflt(*), condDflt(*), shape(*), coordSlv(*), coordMst(*), alocaldir(*), props(nProps), areaSlv(*), &
        tempSlv(*), dtempSlv(*), preDefSlv(*), dpreDefSlv(*), tempMst(*), dtempMst(*), preDefMst(*), dpreDefMst(*)
      character(len=*), intent(in) :: surfInt, surfSlv, surfMst
    end subroutine vuinter_single
  end interface

end module host_routines
