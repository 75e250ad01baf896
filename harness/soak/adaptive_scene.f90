!> A scene of the long run of adaptive increments: a random interface, a load path and a tolerance.
module adaptive_scene
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_contract, only: n_fixed_props, p_eta, p_flat, p_gc, p_gc2, p_guard, p_height, p_kc, p_m, p_mu, &
    p_sigma0, p_sigma02, p_tau_v, p_theta, prop_table, status_ok
  use asperity_control_point, only: control_type
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  use asperity_pattern, only: direction_vector
  use asperity_text, only: integer_text, to_text
  use random_numbers, only: chance, log_uniform, pick, uniform
  implicit none
  private
  public :: draw_scene, is_viscous, describe

  !> Loads after the preload: slip along a direction under constant normal traction; the same without traction across
  !> the slip; slip with a normal spring (CNS); shear tractions below the residual strength; slips of changing
  !> direction; slip while the normal traction changes.
  integer, parameter :: confined = 1, free_across = 2, sprung = 3, sheared = 4, turning = 5, squeezed = 6
  character(len=*), parameter :: load_names(6) = [character(len=11) :: "confined", "free across", "sprung", &
    "sheared", "turning", "squeezed"]
  !> Strength, fracture energy and s_f, those of the paper's Table 2.
  real(wp), parameter :: sigma0 = 3.0_wp, gc = 0.3_wp, sf = 2.0_wp*gc/sigma0
  !> Largest number of legs, the preload included.
  integer, parameter, public :: most_legs = 5

  !> One leg of a load path, from the end of the leg before to its target; it takes the time 1.
  type, public :: leg_type
    type(control_type) :: control      !! what is given
    real(wp) :: target(3) = 0.0_wp     !! separation or traction (without that of the spring) at its end
  end type leg_type

  !> A scene.
  type, public :: scene_type
    integer :: load = confined
    real(wp) :: tolerance = 1.0e-3_wp         !! of the adaptive increments
    real(wp) :: first = 0.01_wp               !! first increment of a leg that is tried, fraction of the leg
    real(wp) :: props(n_fixed_props) = 0.0_wp !! constants
    integer :: legs = 0                       !! number of legs
    type(leg_type) :: leg(most_legs)          !! the legs
    type(interface_type) :: joint             !! the interface
  end type scene_type

contains

  !> Draw a scene.
  subroutine draw_scene(seed, scene)
    integer(int64), intent(inout) :: seed       !! 1..largest_seed
    type(scene_type), intent(out) :: scene      !! the scene
    integer, parameter :: sides(9) = [0, 2, 3, 4, 5, 6, 8, 12, 16]
    real(wp), parameter :: kcs(6) = [1.0_wp, 1.0_wp, 5.0_wp, 20.0_wp, 100.0_wp, 1000.0_wp]
    integer, parameter :: loads(10) = [confined, confined, confined, confined, free_across, free_across, sprung, &
      sheared, turning, squeezed]
    real(wp), parameter :: first_exponents(2) = [-3.0_wp, -0.5_wp], tolerances(2) = [-3.0_wp, -1.5_wp]
    integer :: i, status

    scene%load = loads(pick(seed, size(loads)))
    scene%tolerance = log_uniform(seed, tolerances(1), tolerances(2))
    scene%first = log_uniform(seed, first_exponents(1), first_exponents(2))
    scene%props = prop_table%default
    scene%props([p_sigma0, p_gc]) = [sigma0, gc]
    scene%props(p_eta) = between(seed, 0.5_wp, 0.99_wp)
    scene%props(p_mu) = between(seed, 0.0_wp, 1.2_wp)
    scene%props(p_m) = real(sides(pick(seed, size(sides))), wp)
    scene%props(p_theta) = between(seed, 5.0_wp, 60.0_wp)
    scene%props(p_flat) = between(seed, 0.0_wp, 0.6_wp)
    scene%props(p_kc) = kcs(pick(seed, size(kcs)))
    if (chance(seed, 0.25_wp)) scene%props(p_tau_v) = log_uniform(seed, -2.5_wp, 0.5_wp)
    if (chance(seed, 0.25_wp)) scene%props(p_height) = sf*log_uniform(seed, -1.0_wp, 1.0_wp)
    if (chance(seed, 0.125_wp)) scene%props(p_guard) = 1.0_wp
    if (chance(seed, 0.125_wp)) then
      scene%props(p_sigma02) = sigma0*log_uniform(seed, -0.3_wp, 0.5_wp)
      scene%props(p_gc2) = gc*log_uniform(seed, -0.3_wp, 0.5_wp)
    end if
    call new_interface(scene%props, scene%joint, status)
    if (status /= status_ok) error stop "adaptive_scene: PROPS that are drawn are admissible"
    call draw_legs(seed, scene)
    do i = 1, scene%legs
      scene%leg(i)%control%dt = 1.0_wp
    end do
  end subroutine draw_scene

  !> Draw the load path: a preload and one to four legs.
  subroutine draw_legs(seed, scene)
    integer(int64), intent(inout) :: seed           !! 1..largest_seed
    type(scene_type), intent(inout) :: scene        !! its legs are set
    real(wp) :: angle, e(2), length, pressure, side, spring
    integer :: i, kind

    kind = pick(seed, 10)
    pressure = sigma0*log_uniform(seed, -1.5_wp, 1.0_wp)
    if (kind == 1) pressure = 0.0_wp
    if (kind == 2) pressure = -between(seed, 0.0_wp, 0.3_wp)*sigma0
    if (scene%load == sheared) pressure = max(pressure, 0.1_wp*sigma0)
    scene%legs = 2 + pick(seed, most_legs - 1) - 1
    scene%leg(1)%control%traction(1) = .true.
    scene%leg(1)%target(1) = -pressure
    angle = between(seed, 0.0_wp, 360.0_wp)
    if (chance(seed, 0.25_wp)) angle = 15.0_wp*real(pick(seed, 24), wp)
    spring = sigma0/sf*log_uniform(seed, -1.0_wp, 1.0_wp)
    side = 1.0_wp
    do i = 2, scene%legs
      length = sf*log_uniform(seed, -0.7_wp, 0.5_wp)
      if (scene%load == turning) angle = between(seed, 0.0_wp, 360.0_wp)
      e = direction_vector(angle)
      associate (leg => scene%leg(i))
        leg = scene%leg(i - 1)
        select case (scene%load)
        case (free_across)
          leg%control%traction(3) = .true.
          leg%target(2) = side*length
        case (sheared)
          leg%control%traction(2:3) = .true.
          leg%target(2:3) = side*between(seed, 0.2_wp, 0.95_wp)*scene%props(p_mu)*pressure*e
        case (turning)
          leg%target(2:3) = length*e
        case default
          leg%target(2:3) = side*length*e
          if (scene%load == sprung) leg%control%spring(1) = spring
          if (scene%load == squeezed) leg%target(1) = -pressure*between(seed, 0.2_wp, 2.0_wp)
        end select
      end associate
      side = -side
    end do
  end subroutine draw_legs

  !> A number between two.
  function between(seed, low, high) result(x)
    integer(int64), intent(inout) :: seed   !! 1..largest_seed
    real(wp), intent(in) :: low, high       !! bounds
    real(wp) :: x
    x = low + (high - low)*uniform(seed)
  end function between

  !> Whether the damage is viscous.
  pure function is_viscous(scene) result(yes)
    type(scene_type), intent(in) :: scene   !! the scene
    logical :: yes
    yes = scene%props(p_tau_v) > 0.0_wp
  end function is_viscous

  !> Text of a scene.
  function describe(scene) result(text)
    type(scene_type), intent(in) :: scene   !! the scene
    character(len=:), allocatable :: text
    integer, parameter :: shown(11) = [p_eta, p_mu, p_m, p_theta, p_flat, p_kc, p_tau_v, p_height, p_guard, &
      p_sigma02, p_gc2]
    integer :: i, k
    text = trim(load_names(scene%load)) // ", tolerance " // to_text(scene%tolerance)
    do i = 1, size(shown)
      if (abs(scene%props(shown(i)) - prop_table(shown(i))%default) > 0.0_wp) text = text // ", " // &
        trim(prop_table(shown(i))%name) // " = " // to_text(scene%props(shown(i)))
    end do
    text = text // ", first " // to_text(scene%first)
    do i = 1, scene%legs
      text = text // "; " // integer_text(i) // ":"
      do k = 1, 3
        text = text // " " // merge("t", "s", scene%leg(i)%control%traction(k)) // "=" // &
          to_text(scene%leg(i)%target(k))
      end do
    end do
    if (scene%load == sprung) text = text // "; spring " // to_text(scene%leg(2)%control%spring(1))
  end function describe

end module adaptive_scene
