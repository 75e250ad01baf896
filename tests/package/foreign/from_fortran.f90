!> One elastic update through the installed modules, and the same update through the UMAT.
program from_fortran
  use, intrinsic :: iso_fortran_env, only: error_unit, wp => real64
  use asperity_interface, only: interface_type, new_interface
  use asperity_points, only: update_points
  implicit none
  real(wp), parameter :: sigma0 = 3.0_wp, gc = 0.3_wp, eta = 0.9_wp, mu = 0.5_wp
  real(wp), parameter :: s0 = (1 - eta)*2*gc/sigma0, tolerance = 1.0e-14_wp*sigma0
  real(wp), parameter :: props(4) = [sigma0, gc, eta, mu], s(3) = [s0/2, 0.0_wp, 0.0_wp]
  type(interface_type) :: joint
  real(wp), allocatable :: state(:, :), statev(:)
  real(wp) :: traction(3, 1), stress(3), ddsdde(3, 3), sse, spd, scd, pnewdt, ignored(9)
  integer :: status, failed
  external :: umat

  call new_interface(props, joint, status)
  if (status /= 0) error stop "new_interface"
  allocate (state(joint%n_statev, 1), statev(joint%n_statev))
  state = 0
  statev = 0
  call update_points(joint, reshape(s, [3, 1]), state, traction, status, failed)
  if (status /= 0) error stop "update_points"
  call expect(traction(1, 1), sigma0/2)

  ignored = 0
  stress = 0
  pnewdt = 1
  call umat(stress, statev, ddsdde, sse, spd, scd, ignored, ignored, ignored, ignored, [0.0_wp, 0.0_wp, 0.0_wp], s, &
            ignored, ignored, ignored, ignored, ignored, ignored, repeat("x", 80), 1, 2, 3, size(statev), props, &
            size(props), ignored, ignored, pnewdt, ignored, ignored, ignored, 1, 1, 1, 1, 1, 1)
  call expect(stress(1), sigma0/2)

contains

  subroutine expect(value, expected)
    real(wp), intent(in) :: value      !! computed value
    real(wp), intent(in) :: expected   !! value of the formula
    if (abs(value - expected) <= tolerance) return
    write (error_unit, *) "traction", value, "expected", expected
    error stop
  end subroutine expect

end program from_fortran
