!> Fuzz test of the VUMAT in single precision.
module fuzz_vumat_single
  use, intrinsic :: iso_fortran_env, only: ik => int32, int64, real64, wp => real32
  use asperity_block_single, only: block_type, new_block
  use asperity_checks, only: bounded
  use asperity_text, only: append, integer_text, to_text
  use asperity_contract, only: p_sigma0, p_tau_v, plane_statev, status_ok
  use asperity_interface, only: interface_type, new_interface
  use fuzz_draw, only: any_value, draw_props, most_props
  use host_routines, only: vumat => vumat_single
  use random_numbers, only: chance, log_uniform, pick, seed_of, uniform
  implicit none
  private
  integer(ik), parameter :: nan_bits = int(z"7FC00000", ik), infinite_bits = int(z"7F800000", ik)
  include "fuzz_vumat.inc"
end module fuzz_vumat_single
