!> One sample of the solver's soak run: a drawn interface, load and increment, run by each method.
module solver_sample
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_checks, only: integer_text, to_text
  use asperity_contract, only: n_fixed_props, p_eta, p_flat, p_gc, p_m, p_mu, p_sigma0, p_theta, p_turn, prop_table, &
    status_ok
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  use control_point, only: control_type, new_point, point_type
  use equilibrium_scan, only: scan_equilibria, scan_type
  use mixed_control, only: advance, direction_vector, ended_limit, ended_lost, full_solver, report_type
  implicit none
  private
  public :: draw_sample, run_sample, describe

  !> Loads: slip under a held normal traction; the same with the traction across the slip held at 0; with a spring on
  !> the normal (CNS); all tractions given, up through the peak.
  integer, parameter, public :: confined = 1, free_across = 2, sprung = 3, all_tractions = 4
  character(len=*), parameter :: load_names(4) = [character(len=13) :: "confined", "free across", "sprung", &
    "all tractions"]
  !> Shares of the loads, of a hundred, added up.
  integer, parameter :: shares(4) = [70, 80, 90, 100]

  !> Material of the paper's Table 2, and its s_f.
  real(wp), parameter :: sigma0 = 3.0_wp, gc = 0.3_wp, sf = 2.0_wp*gc/sigma0

  !> What is drawn.
  type, public :: sample_type
    integer :: load = confined
    integer :: m = 0                    !! inclined planes
    integer :: direction = 0            !! of the slip, degrees
    real(wp) :: theta = 30.0_wp         !! inclination, degrees
    real(wp) :: eta = 0.9_wp            !! ductility
    real(wp) :: mu = 0.5_wp             !! friction
    real(wp) :: sigma_n = 0.0_wp        !! held normal traction, stress
    real(wp) :: step = 0.0_wp           !! of the slip, length; of the traction, sigma0 per s_f
    type(interface_type) :: interface
  end type sample_type

  !> What a method came to.
  type, public :: outcome_type
    logical :: completed = .false.      !! the path was followed to its end
    integer :: increments = 0           !! solved
    integer :: all_increments = 0       !! of the path
    integer(int64) :: updates = 0       !! of the law
    integer :: most_updates = 0         !! of one increment
    integer :: snaps = 0
    logical :: proven = .false.         !! not completed, and a scan finds no equilibrium
    logical :: wrong = .false.          !! a row is no equilibrium, or no number
    character(len=100) :: why = ""      !! what is not explained
  end type outcome_type

contains

  !> Draw a sample.
  subroutine draw_sample(seed, sample)
    integer(int64), intent(inout) :: seed       !! 1..2147483646
    type(sample_type), intent(out) :: sample    !! the sample
    real(wp), parameter :: thetas(6) = [0.0_wp, 15.0_wp, 25.0_wp, 30.0_wp, 35.0_wp, 45.0_wp]
    real(wp), parameter :: mus(4) = [0.0_wp, 0.5_wp, 0.5_wp, 1.2_wp], etas(3) = [0.9_wp, 0.9_wp, 0.99_wp]
    !> Smallest and largest pressure and step of those that are drawn on a logarithmic scale, of sigma0 and s_f.
    real(wp), parameter :: pressures(2) = [0.01_wp, 100.0_wp], steps(2) = [1.0_wp/2000.0_wp, 0.5_wp]
    !> One in six at no normal traction, one in six in tension up to half the strength.
    integer, parameter :: kinds = 6, fine_shapes = 2
    real(wp), parameter :: tension = 0.5_wp
    real(wp) :: props(n_fixed_props)
    integer :: i, status

    i = whole(seed, 100)
    sample%load = count(i >= shares) + 1
    ! no inclined plane, or 2 to 64 of them
    sample%m = whole(seed, 64)
    if (sample%m > 0) sample%m = sample%m + 1
    sample%direction = whole(seed, 360)
    if (whole(seed, fine_shapes) == 0) then
      sample%theta = thetas(whole(seed, size(thetas)) + 1)
      sample%mu = mus(whole(seed, size(mus)) + 1)
      sample%eta = etas(whole(seed, size(etas)) + 1)
    end if
    select case (whole(seed, kinds))
    case (0)
      sample%sigma_n = 0.0_wp
    case (1)
      sample%sigma_n = tension*sigma0*draw(seed)
    case default
      sample%sigma_n = -sigma0*pressures(1)*(pressures(2)/pressures(1))**draw(seed)
    end select
    sample%step = sf*steps(1)*(steps(2)/steps(1))**draw(seed)
    props = prop_table%default
    props([p_sigma0, p_gc, p_eta, p_mu]) = [sigma0, gc, sample%eta, sample%mu]
    props([p_m, p_theta, p_flat]) = [real(sample%m, wp), sample%theta, 1.0_wp/3.0_wp]
    ! slip along Tx in a pattern that is turned: a direction against the planes
    if (sample%load /= confined) props(p_turn) = -real(sample%direction, wp)
    call new_interface(props, sample%interface, status)
    if (status /= status_ok) error stop "solver_sample: PROPS that are drawn are admissible"
  end subroutine draw_sample

  !> A number from 0 to below 1 (Park and Miller).
  function draw(seed) result(x)
    integer(int64), intent(inout) :: seed   !! 1..2147483646
    real(wp) :: x
    integer(int64), parameter :: factor = 16807_int64, modulus = 2147483647_int64
    seed = mod(factor*seed, modulus)
    x = real(seed - 1_int64, wp)/real(modulus - 1_int64, wp)
  end function draw

  !> A whole number from 0 to n - 1.
  function whole(seed, n) result(i)
    integer(int64), intent(inout) :: seed   !! 1..2147483646
    integer, intent(in) :: n                !! > 0
    integer :: i
    i = min(n - 1, int(real(n, wp)*draw(seed)))
  end function whole

  !> Preload, then a slip of 1.5 s_f and back; or a tangential traction of twice the strength of all planes.
  subroutine run_sample(sample, method, outcome)
    type(sample_type), intent(in) :: sample       !! the sample
    integer, intent(in) :: method                 !! of `advance`
    type(outcome_type), intent(out) :: outcome    !! what it came to
    integer, parameter :: preload = 10
    real(wp), parameter :: farthest = 1.5_wp*sf, rigidity = 0.5_wp, strength = 2.0_wp
    type(control_type) :: control
    type(point_type) :: point
    real(wp) :: e(2), start(3), target(3)
    integer :: i, n

    control%traction = [.true., sample%load == all_tractions, any(sample%load == [free_across, all_tractions])]
    if (sample%load == sprung) control%spring(1) = rigidity*sigma0/sf
    e = [1.0_wp, 0.0_wp]
    if (sample%load == confined) e = direction_vector(real(sample%direction, wp))
    n = ceiling(farthest/sample%step)
    outcome%all_increments = preload + 2*n
    if (sample%load == all_tractions) outcome%all_increments = preload + n
    point = new_point(sample%interface)
    target = 0.0_wp
    do i = 1, outcome%all_increments
      start = target
      if (i <= preload) then
        target(1) = sample%sigma_n*real(i, wp)/real(preload, wp)
      else if (sample%load == all_tractions) then
        target(2) = real(i - preload, wp)/real(n, wp)*(strength*sigma0 + 2.0_wp*abs(sample%sigma_n))
      else
        target(2:3) = e*farthest*(1.0_wp - abs(real(i - preload - n, wp))/real(n, wp))
      end if
      call take(sample, control, start, target, method, point, outcome)
      if (outcome%wrong .or. outcome%increments < i) return
    end do
    outcome%completed = .true.
  end subroutine run_sample

  !> One increment, and a look at what it left.
  subroutine take(sample, control, start, target, method, point, outcome)
    type(sample_type), intent(in) :: sample           !! the sample
    type(control_type), intent(in) :: control         !! what is held
    real(wp), intent(in) :: start(3), target(3)       !! given values
    integer, intent(in) :: method                     !! of `advance`
    type(point_type), intent(inout) :: point          !! the point
    type(outcome_type), intent(inout) :: outcome      !! counted on
    !> Of the strength and of K times the largest separation: an equilibrium to this share.
    real(wp), parameter :: tolerance = 1.0e-7_wp, rounding = 1.0e-12_wp
    type(report_type) :: report
    type(scan_type) :: scan
    real(wp) :: gap(3), reached, values(3)
    integer :: iterations

    call advance(sample%interface, control, start, target, point, iterations, reached, report=report, method=method)
    outcome%updates = outcome%updates + report%updates
    outcome%most_updates = max(outcome%most_updates, report%updates)
    outcome%snaps = outcome%snaps + report%snaps
    ! what is left is an equilibrium, lost or not
    values = start + reached*(target - start)
    gap = merge(point%traction + control%spring*point%s - values, &
      sample%interface%rie%material%k_n*(point%s - values), control%traction)
    if (.not. maxval(abs(gap)) <= tolerance*(sigma0 + maxval(abs(values), mask=control%traction)) + &
      rounding*sample%interface%rie%material%k_n*maxval(abs(point%s))) then
      outcome%wrong = .true.
      outcome%why = "no equilibrium in a row: gap " // to_text(maxval(abs(gap)))
      return
    end if
    if (reached >= 1.0_wp) then
      outcome%increments = outcome%increments + 1
      return
    end if
    if (method /= full_solver) return
    if (all(report%ended /= [ended_lost, ended_limit])) then
      outcome%why = "ended with " // integer_text(report%ended) // " after " // integer_text(report%updates) // &
        " updates of the law"
      return
    end if
    call scan_equilibria(sample%interface, control, report%beyond, point, scan)
    outcome%proven = .not. scan%found   ! also where the work limit came first
    if (scan%found) outcome%why = "there is an equilibrium at s = " // to_text(scan%place(1)) // ", " // &
      to_text(scan%place(2)) // ", " // to_text(scan%place(3))
  end subroutine take

  !> A sample in words.
  function describe(sample) result(text)
    type(sample_type), intent(in) :: sample   !! the sample
    character(len=:), allocatable :: text
    text = trim(load_names(sample%load)) // ", m = " // integer_text(sample%m) // ", theta = " // &
      to_text(sample%theta) // ", eta = " // to_text(sample%eta) // ", mu = " // to_text(sample%mu) // &
      ", direction " // integer_text(sample%direction) // ", sigma_N = " // to_text(sample%sigma_n) // &
      ", step " // to_text(sample%step)
  end function describe

end module solver_sample
