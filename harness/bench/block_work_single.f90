!> Block kernel, VUMAT and their limits in single precision.
module block_work_single
  use, intrinsic :: iso_fortran_env, only: wp => real32, real64
  use asperity_block_single, only: block_type, chunk, new_block, points_type, update_block
  use asperity_contract, only: status_ok, v_offset
  use host_routines, only: vumat => vumat_single
  use start_states, only: start_type
  implicit none
  private
  public :: block_work_type, new_block_work, run
  include "block_work.inc"
end module block_work_single
