! Entry points of the Python package, in the shape f2py reads: flat external routines, explicit shapes, plain kinds.
!
! Arrays are (3, n) here and (n, 3) in Python, the same memory; results go to arrays of the caller. What can fail hands
! back a status code of asperity_contract and, if it is not 0, the message (of 64 listed planes, all bad, it has 28 000
! characters); `threadsafe` releases the lock of the
! interpreter.

!> Constants of a joint without bond, and their numbers in PROPS.
subroutine contract_joint(kn, ks, constants, numbers)
  use asperity_material, only: joint_constants, joint_props
  implicit none
  double precision, intent(in) :: kn, ks             !! stiffness in closing and in shear, stress/length
  double precision, intent(out) :: constants(7)      !! of joint_props
  integer, intent(out) :: numbers(7)                 !! joint_props
  constants = joint_constants(kn, ks)
  numbers = joint_props
end subroutine contract_joint

!> Check PROPS.
subroutine interface_review(nprops, props, n_planes, wears, status)
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type, new_interface
  implicit none
  integer, intent(in) :: nprops                    !! number of constants
  double precision, intent(in) :: props(nprops)    !! PROPS
  integer, intent(out) :: n_planes                 !! planes of the pattern, 0 if PROPS is not admissible
  integer, intent(out) :: wears                    !! 1: the state has values of facets, too
  integer, intent(out) :: status                   !! 0, status_props or status_nprops
  type(interface_type) :: joint
  n_planes = 0
  wears = 0
  call new_interface(props, joint, status)
  if (status /= status_ok) return
  n_planes = joint%pattern%n
  wears = merge(1, 0, joint%material%wears)
end subroutine interface_review

!> Warnings about a joint, and the largest increment of slip of an FE code.
subroutine interface_warnings(nprops, props, pressure, tension, slip, warnings, increment)
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  use asperity_text, only: append, put_text
  use asperity_warnings, only: increment_text, measures, n_measures, warned, warning_text
  implicit none
  integer, intent(in) :: nprops                    !! number of constants
  double precision, intent(in) :: props(nprops)    !! admissible PROPS
  double precision, intent(in) :: pressure         !! largest one, >= 0, stress
  double precision, intent(in) :: tension          !! largest prescribed normal traction, >= 0, stress
  double precision, intent(in) :: slip             !! largest one, length; 0: not known
  character(len=4096), intent(out) :: warnings     !! a line for each
  character(len=240), intent(out) :: increment     !! a sentence; blank without wear
  type(interface_type) :: joint
  character(len=:), allocatable :: lines
  real(wp) :: values(n_measures)
  logical :: beyond(n_measures)
  integer :: i, status
  lines = ""
  increment = ""
  values = measures(props, pressure, tension, slip)
  beyond = warned(values)
  do i = 1, n_measures
    if (beyond(i)) call append(lines, trim(warning_text(i, values(i))))
  end do
  call put_text(lines, warnings)
  call new_interface(props, joint, status)
  if (status == status_ok) increment = increment_text(joint, pressure, slip)
end subroutine interface_warnings

!> Normals and weights of the planes of admissible PROPS.
subroutine interface_planes(nprops, props, n_planes, normals, weights)
  use asperity_interface, only: interface_type, new_interface
  use asperity_pattern, only: plane_normal
  implicit none
  integer, intent(in) :: nprops                          !! number of constants
  double precision, intent(in) :: props(nprops)          !! PROPS
  integer, intent(in) :: n_planes                        !! as interface_review says
  double precision, intent(out) :: normals(3, n_planes)  !! unit normals (N, Tx, Ty)
  double precision, intent(out) :: weights(n_planes)     !! gamma
  type(interface_type) :: joint
  integer :: k, status
  call new_interface(props, joint, status)
  do k = 1, n_planes
    normals(:, k) = plane_normal(joint%pattern, k)
    weights(k) = joint%pattern%gamma(k)
  end do
end subroutine interface_planes

!> Update n points over one increment.
subroutine interface_update(nprops, props, nstatv, n, s_old, s, aimed, aim, dt, state, traction, tangent, status, failed)
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type, new_interface
  use asperity_arrays, only: update_points
  implicit none
  integer, intent(in) :: nprops                          !! number of constants
  double precision, intent(in) :: props(nprops)          !! admissible PROPS
  integer, intent(in) :: nstatv                          !! state variables of a point
  integer, intent(in) :: n                               !! points
  double precision, intent(in) :: s_old(3, n)            !! separation (N, Tx, Ty) at the start, length
  double precision, intent(in) :: s(3, n)                !! separation at the end, length
  integer, intent(in) :: aimed                           !! 1: traction and tangent of frozen variables
  double precision, intent(in) :: aim(3, n)              !! separation of these; not read without
  double precision, intent(in) :: dt                     !! duration of the increment (viscous damage, dashpot), time
  double precision, intent(inout) :: state(nstatv, n)    !! STATEV, start -> end
  double precision, intent(inout) :: traction(3, n)      !! traction at the end, stress
  double precision, intent(inout) :: tangent(3, 3, n)    !! (j, i): d traction_i/d s_j, stress/length
  integer, intent(out) :: status                         !! 0 or that of the first point rejected, nothing written then
  integer, intent(out) :: failed                         !! its number; 0: none, or the duration is bad
  !f2py threadsafe
  type(interface_type) :: joint
  failed = 0
  call new_interface(props, joint, status)
  if (status /= status_ok) return
  if (aimed == 1) then
    call update_points(joint, s, state, traction, status, failed, s_old, tangent, dt, .true., aim)
  else
    call update_points(joint, s, state, traction, status, failed, s_old, tangent, dt, .true.)
  end if
end subroutine interface_update

!> What is wrong with PROPS, else with the duration, else with a point: all bad values (a function of its own, since f2py
!> takes long to hand back a text).
subroutine input_errors(nprops, props, nstatv, s_old, s, aim, dt, state, message)
  use asperity_call_checks, only: explain_point, explain_time
  use asperity_checks, only: review_props
  use asperity_interface, only: interface_type, new_interface
  use asperity_text, only: put_text
  implicit none
  integer, intent(in) :: nprops                          !! number of constants
  double precision, intent(in) :: props(nprops)          !! PROPS
  integer, intent(in) :: nstatv                          !! state variables of the point
  double precision, intent(in) :: s_old(3), s(3)         !! separation (N, Tx, Ty) at start and end, length
  double precision, intent(in) :: aim(3)                 !! separation of frozen variables; zero without
  double precision, intent(in) :: dt                     !! duration of the increment, time
  double precision, intent(in) :: state(nstatv)          !! STATEV at the start
  character(len=32768), intent(out) :: message           !! a line for every bad value
  type(interface_type) :: joint
  character(len=:), allocatable :: text
  integer :: status
  text = ""
  call review_props(props, status, text, by_name=.true.)
  if (len(text) == 0) then
    call new_interface(props, joint, status)
    call explain_time(joint, "dt", text, dt)
    if (len(text) == 0) call explain_point(joint, s_old, s, state, text, aim)
  end if
  call put_text(text, message)
end subroutine input_errors

!> Stability of n points, from the eigenvalues of their tangents.
subroutine interface_stability(nprops, props, n, tangent, numbers)
  use asperity_interface, only: interface_type, new_interface
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_stability, only: stability_of
  implicit none
  integer, intent(in) :: nprops                     !! number of constants
  double precision, intent(in) :: props(nprops)     !! admissible PROPS
  integer, intent(in) :: n                          !! points
  double precision, intent(in) :: tangent(3, 3, n)  !! d traction_i/d s_j, finite, stress/length
  double precision, intent(inout) :: numbers(6, n)  !! stability_columns
  !f2py threadsafe
  type(interface_type) :: joint
  type(rie_law) :: law
  integer :: i, status
  call new_interface(props, joint, status)
  law = new_rie_law(joint)
  do i = 1, n
    numbers(:, i) = stability_of(tangent(:, :, i), law%stiffness)
  end do
end subroutine interface_stability

!> Give n states the offset at which they carry a traction.
subroutine interface_initial(nprops, props, nstatv, n, traction, state, status, message)
  use asperity_call_checks, only: explain_point
  use asperity_contract, only: status_ok
  use asperity_initial, only: carry_traction, explain_initial
  use asperity_interface, only: interface_type, new_interface
  use asperity_text, only: integer_text, put_text
  implicit none
  integer, intent(in) :: nprops                          !! number of constants
  double precision, intent(in) :: props(nprops)          !! admissible PROPS
  integer, intent(in) :: nstatv                          !! state variables of a point
  integer, intent(in) :: n                               !! points
  double precision, intent(in) :: traction(3, n)         !! traction (N, Tx, Ty), stress
  double precision, intent(inout) :: state(nstatv, n)    !! STATEV, planes as they are -> with the offset
  integer, intent(out) :: status                         !! 0 or that of the first point rejected
  character(len=32768), intent(out) :: message           !! its bad values; points count from 0
  !f2py threadsafe
  logical, parameter :: all_prescribed(3) = .true.
  double precision, parameter :: rest(3) = 0.0d0
  type(interface_type) :: joint
  character(len=:), allocatable :: reasons
  integer :: i
  message = ""
  call new_interface(props, joint, status)
  do i = 1, n
    if (status == status_ok) call carry_traction(joint, traction(:, i), all_prescribed, state(:, i), status)
    if (status == status_ok) cycle
    reasons = ""
    call explain_point(joint, rest, rest, state(:, i), reasons)
    if (len(reasons) == 0) call explain_initial(joint, traction(:, i), all_prescribed, state(:, i), reasons)
    call put_text("point " // integer_text(i - 1) // " (of 0 to " // integer_text(n - 1) // "): " // reasons, message)
    return
  end do
end subroutine interface_initial
