!> The loops over the points of a block in double precision.
module asperity_block_kernel_double
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_contract, only: facet_statev, most_statev, n_facet_statev, n_plane_statev, n_point_statev, n_statev, &
    v_damage, v_friction, v_offset, v_rupture, v_status, v_stored
  use asperity_kinds, only: wp
  use asperity_material, only: material_type
  use asperity_types_double, only: block_type, chunk, damage_type, dissipation_type, facet_type, forces_type, &
    friction_type, growth_type, history_type, kernel_facet, kernel_general, kernel_guarded, kernel_straight, &
    kernel_worn, local_type, mild_slope, moduli_type, plane_type, points_type, profile_type, &
    response_type, separation_type, short_artanh, tensor_type, unseen, update_type, vector_type
  implicit none
  private
  include "asperity_block_kernel.inc"
end module asperity_block_kernel_double
