!> C API of the library, declared in asperity.h: the law for arrays of points.
module asperity_c
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr
  use asperity_c_text, only: put_text
  use asperity_call_checks, only: explain_nstatv, explain_point, explain_time, umat_only
  use asperity_checks, only: review_props
  use asperity_contract, only: cap_statev, status_initial, status_nstatv, status_ok, status_props, status_size, &
    status_time, status_water, v_friction, v_rupture, version
  use asperity_initial, only: carry_traction, explain_initial
  use asperity_interface, only: interface_type, new_interface
  use asperity_arrays, only: update_points
  use asperity_kinds, only: wp
  use asperity_material, only: joint_constants, joint_props
  use asperity_pattern, only: plane_normal
  use asperity_text, only: append, integer_text, to_text
  use asperity_warnings, only: increment_text, measures, n_measures, text_size, warned, warning_text
  implicit none
  private
  public :: asperity_version, asperity_nstatv, asperity_initial_state, asperity_update, asperity_iterate, &
    asperity_planes, asperity_warn, asperity_slip_increment, asperity_joint

contains

  !> Text of the version; returns its length without the closing zero.
  function asperity_version(text, size) bind(C) result(length)
    type(c_ptr), value :: text        !! char[size], may be NULL
    integer(c_int), value :: size     !! bytes of the text
    integer(c_int) :: length
    call put_text(version, text, size)
    length = len(version)
  end function asperity_version

  !> Number of state variables that PROPS needs; 0 if PROPS is not admissible, with the reasons in the message.
  function asperity_nstatv(props, nprops, message, size) bind(C) result(nstatv)
    integer(c_int), value :: nprops               !! number of constants
    type(c_ptr), value :: props                   !! double[nprops] material constants
    type(c_ptr), value :: message                 !! char[size], may be NULL
    integer(c_int), value :: size                 !! bytes of the message
    integer(c_int) :: nstatv
    character(len=:), allocatable :: text
    type(interface_type) :: joint
    integer :: status
    text = ""
    call begin(props, nprops, 0_c_int, 0_c_int, 0_c_int, joint, status, text)
    nstatv = 0
    if (status == status_ok) nstatv = joint%n_statev
    call put_text(text, message, size)
  end function asperity_nstatv

  !> Set the offset of n states so that each carries a traction; returns 0, or the status of the first rejected point.
  function asperity_initial_state(props, nprops, n, traction, nstatv, state, message, size) bind(C) result(status)
    integer(c_int), value :: nprops                     !! number of constants
    integer(c_int), value :: n                          !! points
    integer(c_int), value :: nstatv                     !! state variables per point
    type(c_ptr), value :: props                         !! double[nprops] material constants
    type(c_ptr), value :: traction                      !! double[n][3] traction (N, Tx, Ty), stress
    type(c_ptr), value :: state                         !! double[n][nstatv] state of the planes -> with the offset
    type(c_ptr), value :: message                       !! char[size], may be NULL
    integer(c_int), value :: size                       !! bytes of the message
    integer(c_int) :: status
    real(wp), pointer, contiguous :: states(:, :), t(:, :)
    real(wp), parameter :: rest(3) = 0.0_wp
    logical, parameter :: all_prescribed(3) = .true.
    real(wp) :: in_proportion(3)
    logical :: endless
    character(len=:), allocatable :: text
    type(interface_type) :: joint
    integer :: i

    allocate (character(len=0) :: text)
    call begin(props, nprops, n, nstatv, size, joint, status, text)
    if (n > 0) then
      call expect_array("traction", traction, status, text)
      call expect_array("state", state, status, text)
    end if
    if (status == status_ok .and. n > 0) then
      call c_f_pointer(traction, t, [3, n])
      call c_f_pointer(state, states, [nstatv, n])
      do i = 1, n
        call carry_traction(joint, t(:, i), all_prescribed, states(:, i), status, in_proportion, endless)
        if (status /= status_ok) then
          call explain_point(joint, rest, rest, states(:, i), text)
          if (status == status_initial) call explain_initial(joint, t(:, i), all_prescribed, states(:, i), &
            in_proportion, endless, text)
          text = point_text(i, n) // text
          exit
        end if
      end do
    end if
    call put_text(text, message, size)
  end function asperity_initial_state

  !> Update n points over one increment; returns 0, or a status code with the reasons in the message only.
  function asperity_update(props, nprops, dt, n, s_old, s, aim, p, nstatv, state, traction, tangent, message, &
    size) bind(C) result(status)
    integer(c_int), value :: nprops                     !! number of constants
    real(c_double), value :: dt                         !! duration, >= 0, time; not used if tau_v = c = 0
    integer(c_int), value :: n                          !! points
    integer(c_int), value :: nstatv                     !! state variables per point
    type(c_ptr), value :: props                         !! double[nprops] material constants
    type(c_ptr), value :: s_old                         !! double[n][3] separation at the start, NULL: zero
    type(c_ptr), value :: s                             !! double[n][3] separation (N, Tx, Ty) at the end, length
    type(c_ptr), value :: aim                           !! double[n][3] separation of frozen variables, NULL: none
    type(c_ptr), value :: p                             !! double[n] water pressure at the end, NULL: 0
    type(c_ptr), value :: state                         !! double[n][nstatv] state variables, start -> end
    type(c_ptr), value :: traction                      !! double[n][3] traction at the end, stress
    type(c_ptr), value :: tangent                       !! double[n][3][3] d traction_i/d s_j, may be NULL
    type(c_ptr), value :: message                       !! char[size], may be NULL
    integer(c_int), value :: size                       !! bytes of the message
    integer(c_int) :: status
    status = increment(.true., props, nprops, dt, n, s_old, s, aim, p, nstatv, state, traction, tangent, message, size)
  end function asperity_update

  !> The same for an iterate: the dissipated energies in the states are NaN afterwards.
  function asperity_iterate(props, nprops, dt, n, s_old, s, aim, p, nstatv, state, traction, tangent, message, &
    size) bind(C) result(status)
    integer(c_int), value :: nprops                     !! number of constants
    real(c_double), value :: dt                         !! duration, >= 0, time; not used if tau_v = c = 0
    integer(c_int), value :: n                          !! points
    integer(c_int), value :: nstatv                     !! state variables per point
    type(c_ptr), value :: props                         !! double[nprops] material constants
    type(c_ptr), value :: s_old                         !! double[n][3] separation at the start, NULL: zero
    type(c_ptr), value :: s                             !! double[n][3] separation (N, Tx, Ty) at the end, length
    type(c_ptr), value :: aim                           !! double[n][3] separation of frozen variables, NULL: none
    type(c_ptr), value :: p                             !! double[n] water pressure at the end, NULL: 0
    type(c_ptr), value :: state                         !! double[n][nstatv] state variables, start -> end
    type(c_ptr), value :: traction                      !! double[n][3] traction at the end, stress
    type(c_ptr), value :: tangent                       !! double[n][3][3] d traction_i/d s_j, may be NULL
    type(c_ptr), value :: message                       !! char[size], may be NULL
    integer(c_int), value :: size                       !! bytes of the message
    integer(c_int) :: status
    status = increment(.false., props, nprops, dt, n, s_old, s, aim, p, nstatv, state, traction, tangent, message, size)
  end function asperity_iterate

  !> Normals and weights of the first n planes of PROPS; returns the number of all planes, 0 if PROPS is not admissible.
  function asperity_planes(props, nprops, n, normals, weights) bind(C) result(n_planes)
    integer(c_int), value :: nprops                           !! number of constants
    integer(c_int), value :: n                                !! planes for which there is room
    real(c_double), intent(in) :: props(nprops)               !! material constants
    real(c_double), intent(inout) :: normals(3, n)            !! double[n][3] unit normals (N, Tx, Ty)
    real(c_double), intent(inout) :: weights(n)               !! double[n] gamma
    integer(c_int) :: n_planes
    type(interface_type) :: joint
    integer :: k, status
    n_planes = 0
    call new_interface(props, joint, status)
    if (status /= status_ok) return
    n_planes = joint%pattern%n
    do k = 1, min(n, n_planes)
      normals(:, k) = plane_normal(joint%pattern, k)
      weights(k) = joint%pattern%gamma(k)
    end do
  end function asperity_planes

  !> Warnings about constants that are admissible but outside the law's range of validity; returns their number.
  function asperity_warn(props, nprops, pressure, tension, slip, message, size) bind(C) result(n)
    integer(c_int), value :: nprops                           !! number of constants
    real(c_double), intent(in) :: props(nprops)               !! admissible material constants
    real(c_double), value :: pressure                         !! largest one, >= 0, stress
    real(c_double), value :: tension                          !! largest prescribed normal traction, >= 0, stress
    real(c_double), value :: slip                             !! largest one, length; 0: not known
    type(c_ptr), value :: message                             !! char[size], a line for each; may be NULL
    integer(c_int), value :: size                             !! bytes of the message
    integer(c_int) :: n
    character(len=:), allocatable :: text
    real(wp) :: values(n_measures)
    logical :: beyond(n_measures)
    integer :: i
    allocate (character(len=0) :: text)
    values = measures(props, pressure, tension, slip)
    beyond = warned(values)
    do i = 1, n_measures
      if (beyond(i)) call append(text, trim(warning_text(i, values(i))))
    end do
    call put_text(text, message, size)
    n = count(beyond)
  end function asperity_warn

  !> Largest increment of slip of an FE code with wear, as a sentence; returns its length, 0 without wear.
  function asperity_slip_increment(props, nprops, pressure, slip, text, size) bind(C) result(length)
    integer(c_int), value :: nprops                           !! number of constants
    real(c_double), intent(in) :: props(nprops)               !! material constants
    real(c_double), value :: pressure                         !! largest one, >= 0, stress
    real(c_double), value :: slip                             !! largest one, length; 0: not known
    type(c_ptr), value :: text                                !! char[size], may be NULL
    integer(c_int), value :: size                             !! bytes of the text
    integer(c_int) :: length
    type(interface_type) :: joint
    character(len=text_size) :: sentence
    integer :: status
    sentence = ""
    call new_interface(props, joint, status)
    if (status == status_ok) sentence = increment_text(joint, pressure, slip)
    call put_text(trim(sentence), text, size)
    length = len_trim(sentence)
  end function asperity_slip_increment

  !> Set the entries of PROPS that the stiffnesses of a joint without bond give; the others do not change.
  subroutine asperity_joint(kn, ks, props, nprops) bind(C)
    real(c_double), value :: kn, ks                           !! stiffness in closing and in shear, stress/length
    integer(c_int), value :: nprops                           !! number of constants
    real(c_double), intent(inout) :: props(nprops)            !! material constants
    real(wp) :: constants(size(joint_props))
    integer :: i
    constants = joint_constants(kn, ks)
    do i = 1, size(joint_props)
      if (joint_props(i) <= nprops) props(joint_props(i)) = constants(i)
    end do
  end subroutine asperity_joint

  !> Update n points over one increment, as asperity_update does, with or without the dissipated energies: their parts
  !> of a long increment may take thirty times as long as the rest.
  function increment(energies, props, nprops, dt, n, s_old, s, aim, p, nstatv, state, traction, tangent, message, &
    size) result(status)
    logical, intent(in) :: energies                     !! whether they are wanted, else NaN
    integer(c_int), intent(in) :: nprops        !! number of constants
    real(c_double), intent(in) :: dt            !! duration, >= 0, time; not used if tau_v = c = 0
    integer(c_int), intent(in) :: n             !! points
    integer(c_int), intent(in) :: nstatv        !! state variables per point
    type(c_ptr), intent(in) :: props            !! double[nprops] material constants
    type(c_ptr), intent(in) :: s_old            !! double[n][3] separation at the start, NULL: zero
    type(c_ptr), intent(in) :: s                !! double[n][3] separation (N, Tx, Ty) at the end, length
    type(c_ptr), intent(in) :: aim              !! double[n][3] separation of frozen variables, NULL: none
    type(c_ptr), intent(in) :: p                !! double[n] water pressure at the end, NULL: 0
    type(c_ptr), intent(in) :: state            !! double[n][nstatv] state variables, start -> end
    type(c_ptr), intent(in) :: traction         !! double[n][3] traction at the end, stress
    type(c_ptr), intent(in) :: tangent          !! double[n][3][3] d traction_i/d s_j, may be NULL
    type(c_ptr), intent(in) :: message          !! char[size], may be NULL
    integer(c_int), intent(in) :: size          !! bytes of the message
    integer(c_int) :: status
    real(wp), pointer, contiguous :: from(:, :), to(:, :), goal(:, :), water(:), states(:, :), t(:, :), d(:, :, :)
    real(wp), target :: none(0)
    character(len=:), allocatable :: text
    type(interface_type) :: joint
    real(wp) :: frozen(3), start(3)
    integer :: failed

    allocate (character(len=0) :: text)
    call begin(props, nprops, n, nstatv, size, joint, status, text)
    if (n > 0) then
      call expect_array("s", s, status, text)
      call expect_array("state", state, status, text)
      call expect_array("traction", traction, status, text)
    end if
    if (.not. energies) joint%material%inv_longest_2 = 0.0_wp
    if (status == status_ok) then
      to(1:3, 1:0) => none
      states(1:max(1, nstatv), 1:0) => none
      t(1:3, 1:0) => none
      if (n > 0) then
        call c_f_pointer(s, to, [3, n])
        call c_f_pointer(state, states, [nstatv, n])
        call c_f_pointer(traction, t, [3, n])
      end if
      ! a null pointer is an absent optional argument
      nullify (from, goal, water, d)
      if (c_associated(s_old)) call c_f_pointer(s_old, from, [3, n])
      if (c_associated(aim)) call c_f_pointer(aim, goal, [3, n])
      if (c_associated(p)) call c_f_pointer(p, water, [n])
      if (c_associated(tangent)) call c_f_pointer(tangent, d, [3, 3, n])
      call update_points(joint, to, states, t, status, failed, from, d, dt, .true., goal, water)
      if (status == status_time) then
        call explain_time(joint, "dt", text, dt)
      else if (status == status_water) then
        text = point_text(failed, n) // "p = " // to_text(water(failed)) // &
          ": expected a finite water pressure >= 0"
      else if (status /= status_ok) then
        start = 0.0_wp
        if (associated(from)) start = from(:, failed)
        frozen = 0.0_wp
        if (associated(goal)) frozen = goal(:, failed)
        call explain_point(joint, start, to(:, failed), states(:, failed), text, frozen)
        text = point_text(failed, n) // text
      else if (n > 0 .and. .not. energies) then
        states([v_rupture, v_friction], :) = ieee_value(0.0_wp, ieee_quiet_nan)
        if (joint%cap%peak > 0.0_wp) states(cap_statev(joint%pattern%n, joint%material%wears) + 1, :) = &
          ieee_value(0.0_wp, ieee_quiet_nan)
      end if
    end if
    call put_text(text, message, size)
  end function increment

  !> "point i (of 0 to n - 1): " in a message; points count from 0, as in arrays of C and Python.
  pure function point_text(i, n) result(text)
    integer, intent(in) :: i            !! point, from 1
    integer, intent(in) :: n            !! points
    character(len=len(integer_text(i - 1)) + len(integer_text(n - 1)) + 19) :: text
    text = "point " // integer_text(i - 1) // " (of 0 to " // integer_text(n - 1) // "): "
  end function point_text

  !> Make the interface from PROPS and check the counts as the caller passed them, which may be negative.
  subroutine begin(props, nprops, n, nstatv, size, joint, status, text)
    type(c_ptr), intent(in) :: props                          !! double[nprops] material constants
    integer(c_int), intent(in) :: nprops                      !! number of constants
    integer(c_int), intent(in) :: n                           !! points
    integer(c_int), intent(in) :: nstatv                      !! state variables per point
    integer(c_int), intent(in) :: size                        !! bytes of the message
    type(interface_type), intent(out) :: joint                !! the interface
    integer(c_int), intent(out) :: status                     !! 0 or the status of the first error
    character(len=:), allocatable, intent(inout) :: text      !! the reasons, empty if there are none
    real(wp), pointer, contiguous :: values(:)
    real(wp), target :: none(0)
    status = status_ok
    values => none
    if (nprops > 0) call expect_array("props", props, status, text)
    if (status /= status_ok) return
    if (nprops > 0) call c_f_pointer(props, values, [nprops])
    call new_interface(values, joint, status)
    if (status /= status_ok) then
      call review_props(values, status, text, nprops)
    else if (joint%implex > 0.0_wp) then
      status = status_props
      text = umat_only(joint)
    else if (n < 0) then
      status = status_size
      text = "n = " // integer_text(n) // " points: expected 0 or more"
    else if (nstatv < 0) then
      status = status_nstatv
      call explain_nstatv(joint, "NSTATV", int(nstatv), text)
    else if (size < 0) then
      status = status_size
      text = "size = " // integer_text(size) // " bytes of a message: expected 0 or more"
    end if
  end subroutine begin

  !> Report an array that is missing.
  subroutine expect_array(name, array, status, text)
    character(len=*), intent(in) :: name                      !! of the argument
    type(c_ptr), intent(in) :: array                          !! its address
    integer(c_int), intent(inout) :: status                   !! status_size if it is NULL and no error came before
    character(len=:), allocatable, intent(inout) :: text      !! the reason is appended
    if (c_associated(array) .or. status /= status_ok) return
    status = status_size
    text = name // " is NULL: expected an array"
  end subroutine expect_array

end module asperity_c
