!> The law for blocks of points in double precision.
module asperity_block_double
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_contract, only: facet_statev, max_planes, n_facet_statev, n_plane_statev, n_point_statev, n_statev, &
    status_ok, status_props, v_damage, v_friction, v_offset, v_rupture, v_status, v_stored
  use asperity_kinds, only: wp
  use asperity_interface, only: interface_type
  use asperity_material, only: damage_share, double_material_type => material_type, largest_share, material_type
  use asperity_pattern, only: pattern_type
  use asperity_types_double, only: block_type, chunk, damage_type, dissipation_type, facet_type, forces_type, &
    friction_type, growth_type, history_type, largest_energy, largest_separation, local_type, moduli_type, &
    plane_type, points_type, response_type, separation_type, tensor_type, unseen, vector_type, wear_type
  implicit none
  private
  include "asperity_block.inc"
end module asperity_block_double
