!> VUMAT of Abaqus/Explicit in double precision.
!>
!> docs/reference/contract.md describes PROPS and STATEV. If a block is rejected, stressNew is filled with NaN and the
!> state does not change.
subroutine vumat(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, coordMp, &
                 charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, defgradOld, fieldOld, &
                 stressOld, stateOld, enerInternOld, enerInelasOld, tempNew, stretchNew, defgradNew, fieldNew, &
                 stressNew, stateNew, enerInternNew, enerInelasNew)
  use, intrinsic :: iso_fortran_env, only: ik => int64, real64
  use asperity_block_double, only: block_type, chunk, columns_bounded, largest_energy, &
    largest_separation, new_block, points_type, update_block
  use asperity_kinds, only: wp
  include "asperity_vumat_uses.inc"
  implicit none
  character(len=*), parameter :: routine = "vumat"
  include "asperity_vumat.inc"
end subroutine vumat
