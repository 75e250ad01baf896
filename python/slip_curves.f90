! Many confined slip tests in one call, in the shape f2py reads (see asperity_f2py.f90), with the columns for charts.

!> Curves of confined slip tests, one for each set of direction, normal traction and stiffness; the slips are shared.
!>
!> The arguments are checked by the caller, finite and within the bound of the separation.
subroutine interface_slip_curves(nprops, props, n_curves, direction, sigma_n, stiffness, n, slips, preload, rows, &
                                 n_done, iterations)
  use asperity_contract, only: status_ok, v_damage
  use asperity_interface, only: interface_type, new_interface
  use asperity_mixed_control, only: report_type
  use asperity_slip_test, only: confined_slip, slip_test_type
  implicit none
  integer, intent(in) :: nprops                               !! number of constants
  double precision, intent(in) :: props(nprops)               !! admissible PROPS
  integer, intent(in) :: n_curves                             !! number of curves
  double precision, intent(in) :: direction(n_curves)         !! from Tx towards Ty, degrees
  double precision, intent(in) :: sigma_n(n_curves)           !! constant normal traction, stress
  double precision, intent(in) :: stiffness(n_curves)         !! of the surroundings along N, stress/length
  integer, intent(in) :: n                                    !! slips of a curve
  double precision, intent(in) :: slips(n)                    !! slips in their order, length
  integer, intent(in) :: preload                              !! increments of the preload, >= 1
  double precision, intent(inout) :: rows(6, n, n_curves)     !! s_N, t_N, t_Tx, t_Ty, damage, work; 0 beyond n_done
  integer, intent(out) :: n_done(n_curves)                    !! number of converged rows, -1: not even the preload
  integer, intent(out) :: iterations(n_curves)                !! Newton iterations of these rows
  !f2py threadsafe
  type(interface_type) :: joint
  double precision, allocatable :: separation(:, :), traction(:, :), state(:, :), work(:)
  type(report_type) :: reports(0:n)
  integer :: i, status
  n_done = -1
  iterations = 0
  rows = 0.0d0
  call new_interface(props, joint, status)
  if (status /= status_ok) return
  allocate (separation(3, n), traction(3, n), state(joint%n_statev, n), work(n))
  do i = 1, n_curves
    call confined_slip(joint, slip_test_type(direction(i), sigma_n(i), preload, stiffness=stiffness(i)), slips, &
      separation, traction, state, n_done(i), reports, work=work)
    rows(1, :, i) = separation(1, :)
    rows(2:4, :, i) = traction
    rows(5, :, i) = state(v_damage, :)
    rows(6, :, i) = work
    iterations(i) = sum(reports(1:)%iterations)
  end do
end subroutine interface_slip_curves
