!> Program of docs/reference/c.md.
program example
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp   ! real64 of iso_fortran_env
  use asperity_arrays, only: update_points
  implicit none
  type(interface_type) :: joint
  real(wp), allocatable :: state(:, :)
  real(wp) :: s(3, 1), traction(3, 1)   ! a column for each point
  integer :: status, failed

  call new_interface([3.0_wp, 0.3_wp, 0.9_wp, 0.5_wp], joint, status)   ! sigma0, Gc, eta, mu: a flat joint
  if (status /= 0) error stop "new_interface: PROPS are not admissible"
  allocate (state(joint%n_statev, 1))
  state = 0.0_wp   ! virgin
  s(:, 1) = [0.0_wp, 0.05_wp, 0.0_wp]
  call update_points(joint, s, state, traction, status, failed)
  if (status /= 0) error stop "update_points"
  print "(3f8.4)", traction
end program example
