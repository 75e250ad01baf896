!> Fuzz test of the VUMAT in double precision.
module fuzz_vumat_double
  use, intrinsic :: iso_fortran_env, only: ik => int64, int64, real64, wp => real64
  use asperity_block_double, only: block_type, new_block
  use asperity_checks, only: bounded
  use asperity_text, only: append, integer_text, to_text
  use asperity_contract, only: p_sigma0, p_tau_v, plane_statev, status_ok
  use asperity_interface, only: interface_type, new_interface
  use fuzz_draw, only: any_value, draw_props, most_props
  use host_routines, only: vumat
  use random_numbers, only: chance, log_uniform, pick, seed_of, uniform
  implicit none
  private
  integer(ik), parameter :: nan_bits = int(z"7FF8000000000000", ik), infinite_bits = int(z"7FF0000000000000", ik)
  include "fuzz_vumat.inc"
end module fuzz_vumat_double
