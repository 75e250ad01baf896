!> Block kernel, VUMAT and their limits in double precision.
module block_work_double
  use, intrinsic :: iso_fortran_env, only: wp => real64, real64
  use asperity_block_double, only: block_type, chunk, new_block, points_type, update_block
  use asperity_contract, only: status_ok, v_offset
  use host_routines, only: vumat
  use start_states, only: start_type
  implicit none
  private
  public :: block_work_type, new_block_work, run
  include "block_work.inc"
end module block_work_double
