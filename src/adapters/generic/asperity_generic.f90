!> "Generic" behaviours of MGIS: what OpenGeoSys, MTest and other programs call through libasperity_generic.
!>
!> docs/reference/c.md describes the behaviours. The program `write_symbols` writes the symbols that MGIS reads,
!> and the functions that call the two procedures of this module.
module asperity_generic
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr
  use, intrinsic :: iso_fortran_env, only: error_unit
  use asperity_c_text, only: put_text
  use asperity_call_checks, only: explain_point, explain_time, point_status, time_status
  use asperity_checks, only: bounded, is_pressure, review, review_props
  use asperity_contract, only: cap_statev, n_cap_statev, n_fixed_props, n_statev, p_implex, p_m, p_map, p_water, &
    prop_table, status_initial, status_nstatv, status_ok, status_separation, status_size, status_water, v_friction, &
    v_offset, v_rupture, v_stored
  use asperity_crushing, only: crushing
  use asperity_host, only: quiet_nan, rejected_pnewdt, request_cut, request_slower_damage
  use asperity_initial, only: carry_traction, explain_initial, first_traction
  use asperity_interface, only: interface_type, new_interface, plane_damage
  use asperity_kinds, only: wp
  use asperity_point, only: update_point_in_place
  use asperity_arrays, only: virgin_tangent
  use asperity_text, only: append, integer_text, to_text
  implicit none
  private
  public :: asperity_generic_joint, asperity_generic_layer, behaviour_name, material_properties, point_view, state_view

  !> Largest number of planes of a behaviour: those of a regular pattern of 32 sides and a flat plane.
  integer, parameter, public :: most_planes = 33
  !> Length of the name of a behaviour.
  integer, parameter, public :: name_length = 19
  !> Name of the external state variable of wet behaviours: the water pressure in the joint.
  character(len=*), parameter, public :: water_name = "FluidPressure"

  !> Bytes of a message of MGIS.
  integer(c_int), parameter :: message_size = 512
  !> Values of the request K(1): the magnitude from which an operator is wanted, the largest of the elastic operator,
  !> and the value from which the speed of sound is wanted. A negative request is for the operator at the start alone.
  real(wp), parameter :: any_operator = 0.5_wp, elastic_operator = 1.5_wp, sound = 50.0_wp

  !> State at the start or the end of an increment (mgis_bv_StateView).
  type, bind(C) :: state_view
    type(c_ptr) :: gradients            !! strain or separation
    type(c_ptr) :: forces               !! stress or traction
    type(c_ptr) :: mass_density         !! not used
    type(c_ptr) :: properties           !! material properties
    type(c_ptr) :: variables            !! STATEV
    type(c_ptr) :: stored               !! stored energy, may be NULL
    type(c_ptr) :: dissipated           !! dissipated energy, may be NULL
    type(c_ptr) :: external_variables   !! water pressure of a wet behaviour, the others have none
  end type state_view

  !> Data of an integration point (mgis_bv_BehaviourDataView).
  type, bind(C) :: point_view
    type(c_ptr) :: message          !! char[512], may be NULL
    real(c_double) :: dt            !! duration of the increment
    type(c_ptr) :: operator         !! K: the first value is the request on entry; the operator, by rows, on return
    type(c_ptr) :: factor           !! requested factor of the time step, may be NULL
    type(c_ptr) :: speed_of_sound   !! not written
    type(state_view) :: old         !! at the start
    type(state_view) :: new         !! at the end
  end type point_view

  !> What distinguishes joints and layers of two and three dimensions.
  type :: behaviour_type
    logical :: layer         !! layer of a solid, or joint
    logical :: wet           !! with water in the joint, whose pressure is an external state variable
    integer :: n_planes      !! number of planes
    integer :: n             !! number of components
    integer :: position(3)   !! of N, Tx and Ty among the components, 0: there is no such component
    real(wp) :: weight(3)    !! of N, Tx, Ty: separation over h and component, and component over traction
  end type behaviour_type

contains

  !> Joint: traction (N, Tx, Ty) of a separation; returns 1, or -1 with a message.
  function asperity_generic_joint(point, n_planes, n, wet) bind(C) result(done)
    ! not intent(in): what it points at is written, and a caller in Fortran must know that
    type(point_view), intent(inout) :: point   !! what MGIS passes
    integer(c_int), value :: n_planes       !! number of planes
    integer(c_int), value :: n              !! components: 2 or 3
    integer(c_int), value :: wet            !! 1: with water, 0: without
    integer(c_int) :: done
    done = integrate(point, behaviour_type(.false., wet == 1, n_planes, n, [1, 2, merge(3, 0, n == 3)], &
                                           [1.0_wp, 1.0_wp, 1.0_wp]))
  end function asperity_generic_joint

  !> Layer of a solid with its normal along axis 1: stress of a strain; returns 1, or -1 with a message.
  !>
  !> The components are 11, 22, 33, 12, 13, 23; those of shear are multiplied by sqrt(2) in both strain and stress. The
  !> separation along Tx is 2 h strain_12, and the stress 12 is the traction.
  function asperity_generic_layer(point, n_planes, n, wet) bind(C) result(done)
    type(point_view), intent(in) :: point   !! what MGIS passes
    integer(c_int), value :: n_planes       !! number of planes
    integer(c_int), value :: n              !! components: 4 (two dimensions) or 6
    integer(c_int), value :: wet            !! 1: with water, 0: without
    integer(c_int) :: done
    real(wp), parameter :: root = sqrt(2.0_wp)
    done = integrate(point, behaviour_type(.true., wet == 1, n_planes, n, [1, 4, merge(5, 0, n == 6)], &
                                           [1.0_wp, root, root]))
  end function asperity_generic_layer

  !> Name of a behaviour.
  pure function behaviour_name(kind, n_planes) result(name)
    character(len=*), intent(in) :: kind   !! Joint, Layer or Castem (a joint of Cast3M), with water after Wet
    integer, intent(in) :: n_planes        !! number of planes
    character(len=name_length) :: name
    name = "Asperity" // trim(kind) // integer_text(n_planes)
  end function behaviour_name

  !> Kind and number of planes of a behaviour, as in its name.
  pure function full_name(behaviour) result(name)
    type(behaviour_type), intent(in) :: behaviour   !! joint or layer
    character(len=:), allocatable :: name
    name = trim(behaviour_name(trim(merge("Wet", "   ", behaviour%wet)) // merge("Layer", "Joint", behaviour%layer), &
                               behaviour%n_planes))
  end function full_name

  !> Which entries of PROPS are material properties of a behaviour.
  !>
  !> MGIS fixes the order of the components, and an external state variable is known by its name: no `map`, no `water`.
  !> IMPL-EX (`implex`) is for the UMAT alone.
  !> The gradient of a joint is the separation, so that a joint has no constant of the host. Reserved entries are no
  !> properties.
  pure function material_properties(layer) result(yes)
    logical, intent(in) :: layer   !! layer or joint
    logical :: yes(n_fixed_props)
    yes = (layer .or. prop_table%owner /= "host") .and. prop_table%owner /= "reserved"
    yes([p_map, p_water, p_implex]) = .false.
  end function material_properties

  !> Do what K(1) requests. If that is impossible, write nothing but the message and the factor of the time step.
  function integrate(point, behaviour) result(done)
    type(point_view), intent(in) :: point               !! what MGIS passes
    type(behaviour_type), intent(in) :: behaviour       !! joint or layer
    integer(c_int) :: done                              !! 1, or -1
    real(c_double), pointer, contiguous :: start(:), strain(:), old_stress(:), stress(:), properties(:), &
      old_variables(:), variables(:), operator(:, :)
    real(c_double), pointer :: factor, energy
    type(interface_type) :: joint
    character(len=:), allocatable :: text
    real(wp) :: props(n_fixed_props), state(n_statev(behaviour%n_planes, .true., .true.))
    real(wp) :: old_damage(behaviour%n_planes)
    real(wp) :: from(3), to(3), initial(3), in_proportion(3), traction(3), tangent(3, 3), h, request, side
    real(wp) :: p(2)   ! water pressure at start and end
    logical :: endless, passed(n_fixed_props), predicting
    integer :: at, cap, i, status

    call c_f_pointer(point%operator, operator, [behaviour%n, behaviour%n])
    call c_f_pointer(point%old%gradients, start, [behaviour%n])
    call c_f_pointer(point%new%gradients, strain, [behaviour%n])
    call c_f_pointer(point%old%forces, old_stress, [behaviour%n])
    call c_f_pointer(point%old%variables, old_variables, [size(state)])
    nullify (factor)   ! a null pointer is an absent optional argument
    if (c_associated(point%factor)) call c_f_pointer(point%factor, factor)
    request = operator(1, 1)
    predicting = .false.
    if (bounded(request, sound)) predicting = request < -any_operator
    state = old_variables
    passed = material_properties(behaviour%layer)
    call c_f_pointer(point%new%properties, properties, [count(passed)])
    props = unpack(properties, passed, prop_table%default)

    p = 0.0_wp
    if (behaviour%wet) p = [first_of(point%old%external_variables), first_of(point%new%external_variables)]
    if (predicting) p(2) = p(1)

    in_proportion = 0.0_wp
    endless = .false.
    call new_interface(props, joint, status)
    ! a behaviour has the variables of facets, with or without wear, and those of the strength behind them
    cap = size(state) - n_cap_statev
    at = cap
    if (status == status_ok) then
      if (joint%cap%peak > 0.0_wp .and. joint%pattern%n == behaviour%n_planes) at = cap_statev(joint%pattern%n, &
        joint%material%wears) - 1
      state(at + 1:at + n_cap_statev) = old_variables(cap + 1:)
      h = joint%h
      from = 0.0_wp
      to = 0.0_wp
      initial = 0.0_wp
      do i = 1, 3
        if (behaviour%position(i) == 0) cycle
        from(i) = h*behaviour%weight(i)*start(behaviour%position(i))
        to(i) = h*behaviour%weight(i)*strain(behaviour%position(i))
        initial(i) = old_stress(behaviour%position(i))/behaviour%weight(i)
      end do
      if (predicting) to = from
      status = call_status(joint, behaviour, request, point%dt, from, to, strain, state)
      if (status == status_ok .and. .not. all(is_pressure(p))) status = status_water
    end if
    if (status == status_ok) then
      if (first_traction(initial, state)) then
        initial(1) = initial(1) + p(1)
        call carry_traction(joint, initial, behaviour%position > 0, state, status, in_proportion, endless)
        ! the initial traction belongs to the separation at the start
        if (status == status_ok) state(v_offset:v_offset + 2) = state(v_offset:v_offset + 2) - from
      end if
    end if
    if (status /= status_ok) then
      text = full_name(behaviour) // ": "
      call explain(status, props, joint, behaviour, request, point%dt, from, to, strain, initial, in_proportion, &
        endless, state, p, text)
      call put_text(text, point%message, message_size)
      ! OpenGeoSys does not show the message of MGIS
      write (error_unit, "(2a)") "asperity generic: ", text
      flush (error_unit)
      call request_cut(rejected_pnewdt, factor)
      done = -1
      return
    end if

    old_damage = plane_damage(joint, state)
    call update_point_in_place(joint, from, to, state, traction, tangent, point%dt)
    traction(1) = traction(1) - p(2)
    side = joint%r*joint%material%k_n*h   ! stiffness of the components of a layer that an interface does not have
    if (.not. predicting) then
      if (joint%dalpha > 0.0_wp) call request_slower_damage(joint, old_damage, state, factor)
      call c_f_pointer(point%new%forces, stress, [behaviour%n])
      call c_f_pointer(point%new%variables, variables, [size(state)])
      stress = side*strain
      do i = 1, 3
        if (behaviour%position(i) > 0) stress(behaviour%position(i)) = behaviour%weight(i)*traction(i)
      end do
      variables(:cap) = merge(old_variables(:cap), state(:cap), [(i > at, i=1, cap)])
      variables(cap + 1:) = state(at + 1:at + n_cap_statev)
      if (c_associated(point%new%stored)) then
        call c_f_pointer(point%new%stored, energy)
        ! with the components of a layer beside those of an interface
        energy = state(v_stored)/h + 0.5_wp*side*sum(strain**2, mask=[(all(behaviour%position /= i), i=1, behaviour%n)])
      end if
      if (c_associated(point%new%dissipated)) then
        call c_f_pointer(point%new%dissipated, energy)
        energy = (state(v_rupture) + state(v_friction) + crushing(joint, state))/h
      end if
    end if
    if (abs(request) > any_operator) then
      if (abs(request) < elastic_operator) tangent = virgin_tangent(joint)
      call put_operator(behaviour, h, side, tangent, operator)
    end if
    done = 1
  end function integrate

  !> First of the values that a host passes, NaN if it passes none.
  function first_of(values) result(value)
    type(c_ptr), intent(in) :: values   !! double[]
    real(wp) :: value
    real(c_double), pointer :: found
    value = quiet_nan
    if (.not. c_associated(values)) return
    call c_f_pointer(values, found)
    value = found
  end function first_of

  !> Write the operator d force_i/d gradient_j by rows.
  pure subroutine put_operator(behaviour, h, side, tangent, operator)
    type(behaviour_type), intent(in) :: behaviour   !! joint or layer
    real(wp), intent(in) :: h                       !! thickness, length
    real(wp), intent(in) :: side                    !! stiffness of the other components, stress
    real(wp), intent(in) :: tangent(3, 3)           !! d traction_i/d s_j, stress/length
    real(wp), intent(out) :: operator(:, :)         !! (n, n) its transpose in Fortran's order
    integer :: at(3), i, j
    at = behaviour%position
    operator = 0.0_wp
    do i = 1, behaviour%n
      operator(i, i) = side
    end do
    do i = 1, 3
      do j = 1, 3
        if (at(i) == 0 .or. at(j) == 0) cycle
        operator(at(j), at(i)) = h*behaviour%weight(i)*behaviour%weight(j)*tangent(i, j)
      end do
    end do
  end subroutine put_operator

  !> Whether a call with admissible properties is admissible.
  pure function call_status(joint, behaviour, request, dt, from, to, strain, state) result(status)
    type(interface_type), intent(in) :: joint         !! the interface
    type(behaviour_type), intent(in) :: behaviour     !! joint or layer
    real(wp), intent(in) :: request                   !! K(1)
    real(wp), intent(in) :: dt                        !! duration of the increment
    real(wp), intent(in) :: from(3), to(3)            !! separation at start and end, length
    real(wp), intent(in) :: strain(:)                 !! at the end
    real(wp), intent(in), contiguous :: state(:)      !! STATEV at the start
    integer :: status                                 !! 0, status_nstatv, status_size or those of the point
    status = status_nstatv
    if (joint%pattern%n /= behaviour%n_planes .or. joint%n_statev > size(state)) return
    status = status_size
    if (.not. bounded(request, sound)) return
    status = time_status(joint, dt)
    if (status /= status_ok) return
    status = status_separation
    if (all(bounded(strain, huge(1.0_wp)))) status = point_status(joint, from, to, state)
  end function call_status

  !> Append one line for each bad value of a rejected call.
  subroutine explain(status, props, joint, behaviour, request, dt, from, to, strain, initial, in_proportion, endless, &
    state, p, text)
    integer, intent(in) :: status                          !! of the test that failed
    real(wp), intent(in) :: props(:)                       !! PROPS
    type(interface_type), intent(in) :: joint              !! the interface, if its constants are admissible
    type(behaviour_type), intent(in) :: behaviour          !! joint or layer
    real(wp), intent(in) :: request                        !! K(1)
    real(wp), intent(in) :: dt                             !! duration of the increment
    real(wp), intent(in) :: from(3), to(3)                 !! separation at start and end, length
    real(wp), intent(in) :: strain(:)                      !! at the end
    real(wp), intent(in) :: initial(3)                     !! initial traction, stress
    real(wp), intent(in) :: in_proportion(3)               !! carried part, for status_initial, stress
    logical, intent(in) :: endless                         !! whether planes move without bound beyond it
    real(wp), intent(in), contiguous :: state(:)           !! STATEV at the start
    real(wp), intent(in) :: p(2)                           !! water pressure at start and end, stress
    character(len=:), allocatable, intent(inout) :: text   !! name of the behaviour; lines are appended
    character(len=:), allocatable :: lines
    type(behaviour_type) :: expected
    logical :: listed
    integer :: i, props_status

    allocate (character(len=0) :: lines)
    listed = .false.
    if (bounded(props(p_m), huge(1.0_wp))) listed = props(p_m) < 0.0_wp
    call review_props(props, props_status, lines)
    if (listed) then
      lines = "m = " // to_text(props(p_m)) // ": expected a regular pattern, not listed planes"
    else if (props_status == status_ok) then
      select case (status)
      case (status_nstatv)
        if (joint%pattern%n /= behaviour%n_planes .and. joint%pattern%n <= most_planes) then
          expected = behaviour
          expected%n_planes = joint%pattern%n
          lines = "expected " // full_name(expected) // " for the "
        else
          lines = integer_text(size(state)) // " state variables: no behaviour has those of the "
        end if
        lines = lines // integer_text(joint%pattern%n) // " planes (" // &
          integer_text(n_statev(joint%pattern%n, .true., .true.)) // " state variables) of these constants"
      case (status_size)
        lines = "K[0] = " // to_text(request) // ": expected -3 to 4 (no speed of sound)"
      case (status_initial)
        call explain_initial(joint, initial, behaviour%position > 0, state, in_proportion, endless, lines)
        if (behaviour%wet) call append(lines, "initial t_N: that of the host and " // water_name)
      case (status_water)
        do i = 1, 2
          if (is_pressure(p(i))) cycle
          call append(lines, water_name // " = " // to_text(p(i)) // " at the " // &
            trim(merge("start", "end  ", i == 1)) // ": expected the water pressure in the joint, finite and >= 0")
        end do
      case default
        call explain_time(joint, "dt", lines, dt)
        do i = 1, size(strain)
          call review(lines, "gradient " // integer_text(i), strain(i), huge(1.0_wp), .true.)
        end do
        call explain_point(joint, from, to, state, lines)
      end select
    end if
    text = text // lines
  end subroutine explain

end module asperity_generic
