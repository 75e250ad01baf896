!> Block kernel, VUMAT and their limits in double precision.
module block_work_double
  use, intrinsic :: iso_fortran_env, only: wp => real64, real64
  use asperity_block_double, only: block_type, chunk, new_block, points_type, update_block
  use asperity_contract, only: v_offset
  use asperity_interface, only: interface_type
  use host_routines, only: vumat
  use start_states, only: new_start_states, slip
  implicit none
  private
  public :: block_work_type, new_block_work, run_block, run_roots, large_work_type, new_large_work, run_vumat, &
    run_stream
  include "block_work.inc"
end module block_work_double
