!> VUMAT of Abaqus/Explicit in single precision.
!>
!> docs/reference/contract.md describes PROPS and STATEV. If a block is rejected, stressNew is filled with NaN and the
!> state does not change.
subroutine vumat_single(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, &
                        coordMp, charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, defgradOld, &
                        fieldOld, stressOld, stateOld, enerInternOld, enerInelasOld, tempNew, stretchNew, &
                        defgradNew, fieldNew, stressNew, stateNew, enerInternNew, enerInelasNew)
  use, intrinsic :: iso_fortran_env, only: ik => int32, real64, wp => real32
  use asperity_block_single, only: block_type, chunk, largest_energy, largest_separation, new_block, &
    points_type, update_block
  use asperity_call_checks, only: explain_block, explain_vumat, vumat_status
  use asperity_checks, only: bounded, check_block
  use asperity_contract, only: most_statev, status_initial, status_ok, status_state, v_friction, v_offset, &
    v_rupture, v_status
  use asperity_host, only: vumat_map
  use asperity_initial, only: carry_traction, explain_initial, first_traction
  use asperity_interface, only: interface_type, new_interface, slip_factor
  use asperity_points, only: virgin_tangent
  use asperity_report_vumat, only: report_vumat
  use asperity_text, only: integer_text, set_text, to_text
  implicit none
  character(len=*), parameter :: routine = "vumat_single"
  integer(ik), parameter :: nan_bits = int(z"7FC00000", ik)
  include "asperity_vumat.inc"
end subroutine vumat_single
