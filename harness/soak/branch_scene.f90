!> A scene of the long run of branches: a random interface under a normal traction, and the change of its given values.
module branch_scene
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_contract, only: n_fixed_props, n_required_props, p_eta, p_flat, p_gc, p_kc, p_m, p_mu, p_sigma0, &
    p_theta, p_turn, prop_table, status_ok
  use asperity_control_point, only: control_type, new_point, point_type
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, report_type
  use asperity_pattern, only: direction_vector
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_text, only: integer_text, to_text
  use random_constants, only: constants_text, draw_constant
  use random_numbers, only: chance, log_uniform, pick, uniform
  implicit none
  private
  public :: draw_scene, start_scene, describe

  !> Loads: slip under constant normal traction; the same with a normal spring (CNS); tension on a spring; all tractions
  !> on springs; slip without traction across it; shear on a spring; opening under constant shear tractions; slip while
  !> the normal traction changes.
  character(len=*), parameter, public :: load_names(8) = [character(len=12) :: "confined", "sprung", "pulled", &
    "all sprung", "free across", "sheared", "opened", "squeezed"]
  integer, parameter :: confined = 1, sprung = 2, pulled = 3, all_sprung = 4, free_across = 5, sheared = 6, &
    opened = 7, squeezed = 8
  !> Strength, fracture energy and s_f, those of the paper's Table 2.
  real(wp), parameter :: sigma0 = 3.0_wp, gc = 0.3_wp, sf = 2.0_wp*gc/sigma0

  !> A scene.
  type, public :: scene_type
    integer :: load = confined
    real(wp) :: props(n_fixed_props) = 0.0_wp   !! constants
    real(wp) :: sigma_n = 0.0_wp                !! normal traction at the start, stress
    type(control_type) :: control               !! what is given from there on
    real(wp) :: target(3) = 0.0_wp              !! given values at the end
    real(wp) :: arc = 0.05_wp                   !! longest step over s0
    type(interface_type) :: joint               !! the interface
  end type scene_type

contains

  !> Draw a scene.
  subroutine draw_scene(seed, scene)
    integer(int64), intent(inout) :: seed     !! 1..largest_seed
    type(scene_type), intent(out) :: scene    !! the scene
    integer, parameter :: sides(13) = [0, 0, 0, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12]
    real(wp), parameter :: etas(5) = [0.3_wp, 0.6_wp, 0.9_wp, 0.9_wp, 0.97_wp]
    real(wp), parameter :: mus(5) = [0.0_wp, 0.2_wp, 0.5_wp, 0.5_wp, 1.2_wp]
    real(wp), parameter :: kcs(4) = [1.0_wp, 1.0_wp, 10.0_wp, 100.0_wp]
    real(wp), parameter :: arcs(6) = [0.02_wp, 0.05_wp, 0.1_wp, 0.2_wp, 0.5_wp, 1.0_wp]
    !> Largest inclination, degrees; weight of the flat plane; exponents of the pressure; largest tension, relative to
    !> sigma0.
    real(wp), parameter :: steepest = 65.0_wp, most_flat = 0.5_wp, exponents(2) = [-1.5_wp, 1.5_wp], tension = 0.4_wp
    type(rie_law) :: law
    integer :: i, status

    scene%load = pick(seed, size(load_names))
    scene%props = prop_table%default
    scene%props([p_sigma0, p_gc]) = [sigma0, gc]
    scene%props(p_eta) = etas(pick(seed, size(etas)))
    scene%props(p_mu) = mus(pick(seed, size(mus)))
    scene%props(p_kc) = kcs(pick(seed, size(kcs)))
    i = sides(pick(seed, size(sides)))
    scene%props(p_m) = real(i, wp)
    if (i > 0) then
      scene%props(p_theta) = steepest*uniform(seed)
      scene%props(p_flat) = 0.0_wp
      if (chance(seed, 0.5_wp)) scene%props(p_flat) = most_flat*uniform(seed)
      scene%props(p_turn) = 360.0_wp*uniform(seed)
    end if
    do i = n_required_props + 1, n_fixed_props
      if (prop_table(i)%owner /= "law") cycle
      if (.not. chance(seed, 0.2_wp)) cycle
      call draw_constant(seed, i, scene%props)
      call new_interface(scene%props, scene%joint, status)
      law = new_rie_law(scene%joint)
      ! what a branch does not admit
      if (law%relaxes .or. law%wears .or. scene%joint%material%guard) scene%props(i) = prop_table(i)%default
    end do
    select case (pick(seed, 10))
    case (1, 2)
      scene%sigma_n = 0.0_wp
    case (3)
      scene%sigma_n = tension*sigma0*uniform(seed)
    case default
      scene%sigma_n = -log_uniform(seed, exponents(1), exponents(2))
    end select
    scene%arc = arcs(pick(seed, size(arcs)))
    call new_interface(scene%props, scene%joint, status)
    if (status /= status_ok) error stop "branch_scene: PROPS that are drawn are admissible"
    call draw_load(seed, scene)
  end subroutine draw_scene

  !> Draw the change of the given values.
  subroutine draw_load(seed, scene)
    integer(int64), intent(inout) :: seed       !! 1..largest_seed
    type(scene_type), intent(inout) :: scene    !! the scene
    !> Stiffness of the springs, stress/length: none, soft, stiff.
    real(wp), parameter :: springs(7) = [0.0_wp, 0.5_wp, 2.0_wp, 5.0_wp, 15.0_wp, 80.0_wp, 400.0_wp]
    !> Smallest and largest slip, relative to s_f; largest traction, relative to sigma0.
    real(wp), parameter :: slips(2) = [0.25_wp, 2.0_wp], tractions = 3.0_wp
    real(wp) :: slip, soft
    integer :: i

    slip = sf*(slips(1) + (slips(2) - slips(1))*uniform(seed))
    soft = springs(pick(seed, size(springs)))
    scene%control%traction(1) = .true.
    scene%target = [scene%sigma_n, 0.0_wp, 0.0_wp]
    if (any(scene%load == [confined, sprung, squeezed])) then
      scene%target(2:3) = slip*direction_vector(360.0_wp*uniform(seed))
      if (chance(seed, 0.3_wp)) scene%target(2:3) = [slip, 0.0_wp]
    end if
    if (any(scene%load == [sprung, free_across, sheared, squeezed])) scene%control%spring(1) = soft
    select case (scene%load)
    case (pulled)
      scene%control%spring(1) = springs(1 + pick(seed, size(springs) - 1))
      scene%target(1) = sigma0*(0.3_wp + (tractions - 0.3_wp)*uniform(seed))
    case (all_sprung)
      scene%control%traction = .true.
      do i = 1, 3
        scene%control%spring(i) = springs(1 + pick(seed, size(springs) - 1))
        scene%target(i) = 0.5_wp*tractions*sigma0*(2.0_wp*uniform(seed) - 1.0_wp)
      end do
    case (free_across)
      scene%control%traction(3) = .true.
      scene%target(2) = slip
    case (sheared)
      scene%control%traction(2) = .true.
      scene%control%spring(2) = springs(1 + pick(seed, size(springs) - 1))
      scene%target(2) = sigma0*(0.5_wp + (tractions - 0.5_wp)*uniform(seed))
    case (opened)
      scene%control%traction = [.false., .true., .true.]
      scene%target(1) = slip
      do i = 2, 3
        scene%target(i) = 0.1_wp*sigma0*uniform(seed)
      end do
    case (squeezed)
      scene%target(1) = sigma0*(tractions*uniform(seed) - 2.0_wp)
    case default
      continue   ! confined or sprung: the normal traction stays
    end select
  end subroutine draw_load

  !> Bring a virgin point under the normal traction of a scene.
  subroutine start_scene(scene, law, point, from, good)
    type(scene_type), intent(in) :: scene      !! the scene
    type(rie_law), intent(out) :: law          !! its law
    type(point_type), intent(out) :: point     !! under the normal traction
    real(wp), intent(out) :: from(3)           !! prescribed values of the point
    logical, intent(out) :: good               !! whether it carries the traction without a snap
    integer, parameter :: parts = 20
    type(report_type) :: report
    real(wp) :: reached, start(3), to(3)
    integer :: i
    law = new_rie_law(scene%joint)
    point = new_point(law)
    to = 0.0_wp
    good = .true.
    do i = 1, parts
      start = to
      to(1) = scene%sigma_n*(real(i, wp)/real(parts, wp))
      call advance(law, control_type([.true., .true., .true.]), start, to, point, reached, report)
      good = good .and. reached >= 1.0_wp .and. report%snaps == 0
      if (.not. good) return
    end do
    from = merge(to + scene%control%spring*point%s, point%s, scene%control%traction)
  end subroutine start_scene

  !> The scene as groups of a case file, for messages.
  function describe(scene) result(text)
    type(scene_type), intent(in) :: scene   !! the scene
    character(len=:), allocatable :: text
    character(len=*), parameter :: names(3) = [character(len=2) :: "N", "Tx", "Ty"]
    integer :: i
    text = trim(load_names(scene%load)) // ": " // constants_text(scene%props) // " &step t_N = " // &
      to_text(scene%sigma_n) // ", t_Tx = 0, t_Ty = 0, increments = 20 / &step"
    do i = 1, 3
      text = text // merge(" t_", " s_", scene%control%traction(i)) // trim(names(i)) // " = " // &
        to_text(scene%target(i)) // ","
      if (scene%control%spring(i) > 0.0_wp) text = text // " k_" // trim(names(i)) // " = " // &
        to_text(scene%control%spring(i)) // ","
    end do
    text = text // " follow = 'branch', arc = " // to_text(scene%arc) // " /"
  end function describe

end module branch_scene
