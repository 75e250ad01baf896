!> VUMAT of Abaqus/Explicit in single precision.
!>
!> docs/reference/contract.md describes PROPS and STATEV. If a block is rejected, stressNew is filled with NaN and the
!> state does not change.
subroutine vumat_single(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, &
                        coordMp, charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, defgradOld, &
                        fieldOld, stressOld, stateOld, enerInternOld, enerInelasOld, tempNew, stretchNew, &
                        defgradNew, fieldNew, stressNew, stateNew, enerInternNew, enerInelasNew)
  use, intrinsic :: iso_fortran_env, only: ik => int32, real64, wp => real32
  use asperity_block_single, only: block_type, chunk, columns_bounded, largest_energy, &
    largest_separation, new_block, points_type, update_block
  include "asperity_vumat_uses.inc"
  implicit none
  character(len=*), parameter :: routine = "vumat_single"
  include "asperity_vumat.inc"
end subroutine vumat_single
