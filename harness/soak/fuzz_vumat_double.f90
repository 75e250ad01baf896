!> Fuzz of the VUMAT in double precision.
module fuzz_vumat_double
  use, intrinsic :: iso_fortran_env, only: ik => int64, int64, real64, wp => real64
  use asperity_block_double, only: block_type, new_block
  use asperity_checks, only: bounded
  use asperity_contract, only: p_sigma0, p_tau_v, plane_statev, status_ok
  use asperity_interface, only: interface_type, new_interface
  use asperity_text, only: append, integer_text, to_text
  use fuzz_draw, only: any_value, chance, draw_props, log_uniform, most_props, pick, start, stream_type, uniform
  use host_routines, only: vumat
  implicit none
  private
  integer(ik), parameter :: nan_bits = int(z"7FF8000000000000", ik), infinite_bits = int(z"7FF0000000000000", ik)
  include "fuzz_vumat.inc"
end module fuzz_vumat_double
