!> Procedures shared by the suites: Table 2 of the paper; interfaces, paths and random histories with it; special
!> values.
module support_law
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_contract, only: n_fixed_props, n_plane_statev, n_point_statev, p_c, p_closure, p_crush, p_damage0, &
    p_eta, p_flat, p_gc, p_gc2, p_guard, p_height, p_kc, p_m, p_mu, p_sigma0, p_sigma02, p_tau_v, p_theta, p_turn, &
    p_w0, prop_table, status_ok
  use asperity_interface, only: interface_type, new_interface
  use asperity_errors, only: error_type, errors_type
  use asperity_kinds, only: wp
  use asperity_point, only: update_point
  use random_numbers, only: draw
  use asperity_steps, only: complete_steps, step_table, step_type
  implicit none
  private
  public :: table2_with, interface_of, regular_interface, listed_interface, kind_of, entry_of, give, complete, &
    tangent_by_differences, plane_axes, length, draw, random_history, random_walk, samples, same_bits, is_nan

  !> Strength, rupture energy, ductility and friction coefficient of Table 2 (MPa, mm).
  real(wp), parameter, public :: sigma0 = 3.0_wp, gc = 0.3_wp, eta = 0.9_wp, mu = 0.5_wp
  !> Separations of complete rupture and of onset, and stiffness (5), (12).
  real(wp), parameter, public :: sf = 2.0_wp*gc/sigma0, s0 = (1.0_wp - eta)*sf, stiffness = sigma0/s0
  !> Inclination in Sections 4.2 to 4.4 of the paper, degrees, and one degree in radians.
  real(wp), parameter, public :: theta = 30.0_wp, degree = acos(-1.0_wp)/180.0_wp

  !> Numbers of state variables of one plane, and of RP-4 with its flat plane. Index of the damage of the first plane.
  integer, parameter, public :: flat_nstatv = n_point_statev + n_plane_statev, &
    pyramid_nstatv = n_point_statev + 5*n_plane_statev, i_alpha = n_point_statev + 1

  ! The values are defined by their bits, so that no floating-point exception is raised.
  real(wp), parameter, public :: nan = transfer(int(z"7FF8000000000000", int64), 1.0_wp)
  real(wp), parameter, public :: signalling_nan = transfer(int(z"7FF4000000000000", int64), 1.0_wp)
  real(wp), parameter, public :: infinity = transfer(int(z"7FF0000000000000", int64), 1.0_wp)

  !> Kinds of interfaces: those of the paper, then those with further constants. Time of an increment of all kinds.
  integer, parameter, public :: n_plain = 14, n_kinds = 28
  real(wp), parameter, public :: kind_dt = 0.1_wp

contains

  !> PROPS of Table 2 and a flat pattern, with other values where they are given.
  pure function table2_with(index, value) result(props)
    integer, intent(in) :: index(:)      !! indices into PROPS
    real(wp), intent(in) :: value(:)     !! their values
    real(wp) :: props(n_fixed_props)
    props = prop_table%default
    props([p_sigma0, p_gc, p_eta, p_mu]) = [sigma0, gc, eta, mu]
    props(index) = value
  end function table2_with

  !> Interface from PROPS that must be admissible.
  function interface_of(props) result(joint)
    real(wp), intent(in) :: props(:)   !! PROPS
    type(interface_type) :: joint
    integer :: status
    call new_interface(props, joint, status)
    if (status /= status_ok) error stop "support_law: a test builds an interface from inadmissible PROPS"
  end function interface_of

  !> Regular pattern of m planes inclined by 30 degrees, flat share 1/3 (Table 4), material of Table 2.
  function regular_interface(m) result(regular)
    integer, intent(in) :: m   !! number of inclined planes
    type(interface_type) :: regular
    regular = interface_of(table2_with([p_m, p_theta], [real(m, wp), theta]))
  end function regular_interface

  !> Listed planes with the material of Table 2, with other values where they are given.
  function listed_interface(planes, index, value) result(joint)
    real(wp), intent(in) :: planes(:, :)           !! (4, k) normal and weight
    integer, intent(in), optional :: index(:)      !! indices into PROPS
    real(wp), intent(in), optional :: value(:)     !! their values
    type(interface_type) :: joint
    real(wp) :: props(n_fixed_props)
    props = table2_with([p_m], [-real(size(planes, 2), wp)])
    if (present(index)) props(index) = value
    joint = interface_of([props, reshape(planes, [size(planes)])])
  end function listed_interface

  !> Interface of every kind: flat, regular, listed; stiff contact, separate mode II values, frictionless, nearly
  !> brittle; then facets that wear or are crushed, hyperbolic closure, damage from the start, guard, viscosity, all of
  !> these; then a dashpot, alone and with all.
  function kind_of(i) result(joint)
    integer, intent(in) :: i   !! 1..n_kinds
    type(interface_type) :: joint
    real(wp), parameter :: planes(4, 3) = reshape([1.0_wp, 0.2_wp, 0.7_wp, 0.5_wp, 3.0_wp, -1.0_wp, 0.0_wp, 0.3_wp, &
      0.1_wp, -0.4_wp, -0.2_wp, 0.2_wp], [4, 3])
    select case (i)
    case (1)
      joint = rp_4([p_m], [0.0_wp])
    case (2, 3)
      joint = regular_interface(i)
    case (4)
      joint = regular_interface(4)
    case (5)
      joint = rp_4([p_theta, p_turn, p_flat, p_kc, p_mu], [45.0_wp, 10.0_wp, 0.2_wp, 100.0_wp, 0.7_wp])
    case (6)
      joint = rp_4([p_m, p_theta, p_turn, p_flat, p_kc], [6.0_wp, 60.0_wp, -7.0_wp, 0.0_wp, 2.0_wp])
    case (7)
      joint = regular_interface(32)
    case (8)
      joint = rp_4([p_m, p_theta, p_turn, p_flat, p_mu], [64.0_wp, 89.0_wp, 1.0_wp, 1.0e-3_wp, 1.0_wp])
    case (9)
      joint = rp_4([p_sigma02, p_gc2], [2.0_wp*sigma0, 0.5_wp*gc])
    case (10)
      joint = rp_4([p_sigma02, p_gc2, p_kc], [0.5_wp*sigma0, 3.0_wp*gc, 20.0_wp])
    case (11)
      joint = rp_4([p_mu], [0.0_wp])
    case (12)
      joint = rp_4([p_eta], [0.01_wp])
    case (13)
      joint = listed_interface(planes)
    case (14)
      joint = listed_interface(planes, [p_sigma02, p_kc], [2.0_wp*sigma0, 10.0_wp])
    case (15)
      joint = rp_4([p_height, p_kc], [0.3_wp, 20.0_wp])
    case (16)
      joint = rp_4([p_height, p_kc, p_w0], [0.3_wp, 5.0_wp, 0.2_wp])
    case (17)
      joint = rp_4([p_kc, p_w0], [2.0_wp, 0.4_wp])
    case (18)
      joint = rp_4([p_closure, p_kc], [3.0_wp*s0, 2.0_wp])
    case (19)
      joint = rp_4([p_closure, p_kc, p_height], [3.0_wp*s0, 2.0_wp, 0.3_wp])
    case (20)
      joint = rp_4([p_damage0, p_kc], [0.3_wp, 5.0_wp])
    case (21)
      joint = rp_4([p_guard, p_sigma02], [1.0_wp, 2.0_wp*sigma0])
    case (22)
      joint = rp_4([p_guard, p_height, p_kc], [1.0_wp, 0.3_wp, 2.0_wp])
    case (23)
      joint = rp_4([p_tau_v], [0.3_wp])
    case (24)
      joint = rp_4([p_crush, p_kc], [2.0_wp, 20.0_wp])
    case (25)
      joint = rp_4([p_crush, p_kc, p_height, p_damage0], [1.0_wp, 50.0_wp, 0.3_wp, 1.0_wp])
    case (26)
      joint = rp_4([p_closure, p_damage0, p_kc, p_height, p_w0, p_crush, p_guard, p_tau_v, p_sigma02, p_gc2], &
        [3.0_wp*s0, 0.3_wp, 2.0_wp, 0.3_wp, 0.5_wp, 3.0_wp, 1.0_wp, 0.3_wp, 4.0_wp, 0.6_wp])
    case (27)
      joint = rp_4([p_c, p_kc, p_damage0], [8.0_wp, 5.0_wp, 0.5_wp])
    case (28)
      joint = rp_4([p_closure, p_damage0, p_kc, p_height, p_w0, p_crush, p_guard, p_tau_v, p_sigma02, p_gc2, p_c], &
        [3.0_wp*s0, 0.3_wp, 2.0_wp, 0.3_wp, 0.5_wp, 3.0_wp, 1.0_wp, 0.3_wp, 4.0_wp, 0.6_wp, 2.0_wp])
    case default
      error stop "support_law: no such kind of interface"
    end select
  end function kind_of

  !> RP-4 of 30 degrees with the material of Table 2, with other values where they are given.
  function rp_4(index, value) result(joint)
    integer, intent(in) :: index(:)      !! indices into PROPS
    real(wp), intent(in) :: value(:)     !! their values
    type(interface_type) :: joint
    joint = interface_of(table2_with([p_m, p_theta, index], [4.0_wp, theta, value]))
  end function rp_4

  !> Give an entry of a step its values.
  subroutine give(step, name, values)
    type(step_type), intent(inout) :: step    !! the step
    character(len=*), intent(in) :: name      !! of the entry
    real(wp), intent(in) :: values(:)         !! its values
    step%place%group = "here"
    step%given(entry_of(name))%values = values
  end subroutine give

  !> Complete steps that must be good.
  subroutine complete(steps)
    type(step_type), intent(inout) :: steps(:)   !! with their entries -> complete
    type(errors_type) :: errors
    call complete_steps(steps, errors, error_type())
    if (errors%n > 0) error stop "support_law: a test has bad steps"
  end subroutine complete

  !> Position of an entry of a step.
  pure function entry_of(name) result(i)
    character(len=*), intent(in) :: name   !! of the entry
    integer :: i
    do i = size(step_table), 1, -1
      if (step_table(i)%name == name) exit
    end do
  end function entry_of

  !> Tangent by central differences of the traction.
  pure function tangent_by_differences(joint, from, s, state, step, dt) result(tangent)
    type(interface_type), intent(in) :: joint   !! material and pattern
    real(wp), intent(in) :: from(3)             !! separation at the start of the increment
    real(wp), intent(in) :: s(3)                !! separation at its end
    real(wp), intent(in) :: state(:)            !! STATEV at the start
    real(wp), intent(in) :: step                !! difference of the separation in either direction
    real(wp), intent(in), optional :: dt        !! duration of the increment
    real(wp) :: tangent(3, 3)
    real(wp) :: new(size(state)), before(3), after(3), other(3, 3), shifted(3), old(size(state))
    integer :: j
    old = state
    do j = 1, 3
      shifted = s
      shifted(j) = s(j) - step
      call update_point(joint, from, shifted, old, new, before, other, dt)
      shifted(j) = s(j) + step
      call update_point(joint, from, shifted, old, new, after, other, dt)
      tangent(:, j) = (after - before)/(2.0_wp*step)
    end do
  end function tangent_by_differences

  !> Axes n, t, h of a plane by (1), as columns. A plane parallel to the average surface has the axes Tx and Ty.
  pure function plane_axes(normal) result(axes)
    real(wp), intent(in) :: normal(3)   !! unit normal (N, Tx, Ty)
    real(wp) :: axes(3, 3)
    real(wp), parameter :: big_n(3) = [1.0_wp, 0.0_wp, 0.0_wp]
    axes = 0.0_wp
    axes(:, 1) = normal
    axes(2, 2) = 1.0_wp
    axes(3, 3) = 1.0_wp
    if (length(normal(2:)) > 0.0_wp) then
      axes(:, 3) = cross(big_n, normal)
      axes(:, 3) = axes(:, 3)/length(axes(:, 3))
      axes(:, 2) = cross(normal, axes(:, 3))
    end if
  end function plane_axes

  !> Length of a vector. The intrinsic norm2 is not used: that of LLVM 16 is negative for some vectors with a negative
  !> zero.
  pure function length(x) result(norm)
    real(wp), intent(in) :: x(:)   !! any vector
    real(wp) :: norm
    norm = sqrt(sum(x**2))
  end function length

  !> Vector product.
  pure function cross(a, b) result(c)
    real(wp), intent(in) :: a(3), b(3)   !! vectors (N, Tx, Ty)
    real(wp) :: c(3)
    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross

  !> Number of random samples: n, or the part of them that is left where each instruction checks itself, as the suites
  !> of the optimised library draw them all (environment: ASPERITY_SAMPLES_OVER).
  function samples(n)
    integer, intent(in) :: n   !! all
    integer :: samples
    character(len=8) :: text
    integer :: divisor, status
    samples = n
    call get_environment_variable("ASPERITY_SAMPLES_OVER", text, status=status)
    if (status /= 0) return
    read (text, *) divisor
    samples = max(1, n/divisor)
  end function samples

  !> Separations of n increments that change sign at random: opening, closing and sliding, with growing size up to 1.5
  !> s_f.
  function random_history(seed, n) result(s)
    integer(int64), intent(inout) :: seed   !! state of the generator `draw`
    integer, intent(in) :: n                !! number of increments
    real(wp) :: s(3, n)
    integer :: i
    do i = 1, n
      call draw(seed, s(:, i))
      s(:, i) = s(:, i)*(0.5_wp*s0 + 1.5_wp*sf*real(i, wp)/real(n, wp))
    end do
  end function random_history

  !> Random walk that stays near the origin, in steps of about s0.
  function random_walk(seed, n) result(s)
    integer(int64), intent(inout) :: seed   !! state of the generator `draw`
    integer, intent(in) :: n                !! number of increments
    real(wp) :: s(3, n)
    real(wp) :: at(3), x(3)
    integer :: i
    at = 0.0_wp
    do i = 1, n
      call draw(seed, x)
      at = 0.98_wp*at + s0*x*[0.3_wp, 1.0_wp, 1.0_wp]
      s(:, i) = at
    end do
  end function random_walk

  !> Whether two arrays contain the same bits.
  pure function same_bits(a, b) result(same)
    real(wp), intent(in) :: a(:)   !! any bits
    real(wp), intent(in) :: b(:)   !! any bits, same size
    logical :: same
    same = all(transfer(a, [0_int64]) == transfer(b, [0_int64]))
  end function same_bits

  !> Whether the bits are those of a NaN. There is no floating-point comparison, because a NaN may trap in it.
  elemental function is_nan(x) result(yes)
    real(wp), intent(in) :: x   !! any bits
    logical :: yes
    yes = iand(transfer(x, 0_int64), huge(0_int64)) > transfer(infinity, 0_int64)
  end function is_nan

end module support_law
