!> The law for blocks of points in double precision.
module asperity_block_double
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_contract, only: energy_limit, facet_statev, max_planes, n_facet_statev, n_plane_statev, &
    n_point_statev, n_statev, separation_limit, status_ok, status_props, v_damage, v_friction, v_offset, &
    v_rupture, v_status, v_stored
  use asperity_kinds, only: wp
  use asperity_interface, only: interface_type
  use asperity_material, only: damage_share, double_material_type => material_type, largest_share, material_type
  use asperity_pattern, only: pattern_type
  implicit none
  private
  include "asperity_block.inc"
end module asperity_block_double
