!> One sample of the solver's soak run: a random interface, load and increment.
module solver_sample
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_checks, only: bounded
  use asperity_text, only: integer_text, to_text
  use asperity_contract, only: n_fixed_props, p_damage0, p_eta, p_fc, p_flat, p_gc, p_gfc, p_height, p_kc, p_m, &
    p_mu, p_sigma0, p_theta, p_turn, plane_statev, prop_table, status_ok
  use asperity_initial, only: carry_traction
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  use asperity_equations, only: control_type, new_point, point_type, ramp
  use asperity_increment, only: advance, ended_limit, ended_lost, report_type
  use asperity_pattern, only: direction_vector
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_tolerances, only: smallest_fraction
  use loss_judge, only: examine_loss, loss_discontinuous, loss_elsewhere, loss_none_found
  use solver_judge, only: judge_row, verdict_type
  use random_constants, only: constants_text, draw_constant, draw_constants
  use random_numbers, only: chance, draw, pick, seed_of, uniform
  implicit none
  private
  public :: draw_sample, run_sample, describe

  !> Loads: slip under constant normal traction; the same with zero traction across the slip; slip with a normal spring
  !> (CNS); all tractions prescribed, beyond the peak; slip with springs in the normal direction and across the slip.
  integer, parameter, public :: confined = 1, free_across = 2, sprung = 3, all_tractions = 4, twice_sprung = 5
  character(len=*), parameter :: load_names(5) = [character(len=13) :: "confined", "free across", "sprung", &
    "all tractions", "twice sprung"]
  !> Cumulative percentages of the first four loads.
  integer, parameter :: shares(4) = [70, 80, 90, 100]

  !> Material of the paper's Table 2, and its s_f.
  real(wp), parameter, public :: sigma0 = 3.0_wp, gc = 0.3_wp, sf = 2.0_wp*gc/sigma0
  !> Stiffness of the springs, sigma0/s_f.
  real(wp), parameter :: rigidity = 0.5_wp

  !> Random values of a sample.
  type, public :: sample_type
    integer :: load = confined
    logical :: across = .false.         !! whether it is drawn by `turn_across`
    integer :: direction = 0            !! of the slip, degrees
    real(wp) :: props(n_fixed_props) = prop_table%default   !! constants; the duration of an increment is 1
    real(wp) :: sigma_n = 0.0_wp        !! constant normal traction, stress
    real(wp) :: step = 0.0_wp           !! increment of the slip, length; of a traction: times sigma0/s_f
    real(wp) :: spring(2) = rigidity*sigma0/sf   !! normal and across the slip, stress/length
    integer :: initial = 0              !! 0: virgin, 1: damaged, 2: damaged and loaded
    real(wp) :: traction(3) = 0.0_wp    !! initial traction, stress
    real(wp), allocatable :: state(:)   !! initial STATEV
    type(interface_type) :: joint
    type(rie_law) :: law                !! the law of the interface
  end type sample_type

  !> What is counted of a sample: paths followed to their end; losses where a scan finds no equilibrium, where the
  !> motion stops as the law is discontinuous, and without either cause; losses of any of these kinds with a stable
  !> equilibrium within s_f; increments that met the limit of updates; those
  !> of them with another equilibrium; viscous losses, which the prescribed values open without bound; rows that are not
  !> finite or no equilibrium, that jump without a reported snap, whose energies do not balance; snaps; increments
  !> solved, and of the path; updates of the law.
  integer, parameter, public :: n_counts = 15, completed = 1, none_found = 2, stopped = 3, unexplained = 4, &
    limited = 5, stuck = 6, away = 7, wrong = 8, unreported = 9, unbalanced = 10, snaps = 11, increments = 12, &
    all_increments = 13, updates = 14, near_equilibria = 15

  !> Result of a sample.
  type, public :: outcome_type
    integer(int64) :: counts(n_counts) = 0_int64
    integer :: most_updates = 0         !! of one increment
    logical :: slow = .false.           !! viscous damage, guard or wear, where the point may stick and slip in steps
                                        !! that are too short for the limit of updates
    character(len=300) :: why = ""      !! what is wrong or not explained
  end type outcome_type

contains

  !> Draw a sample.
  subroutine draw_sample(seed, sample, branch, across)
    integer(int64), intent(inout) :: seed       !! 1..largest_seed
    type(sample_type), intent(out) :: sample    !! the sample
    logical, intent(in), optional :: branch     !! with constants that a branch admits, and virgin; absent: any
    logical, intent(in), optional :: across     !! a slip free across (`turn_across`); absent: any
    real(wp), parameter :: thetas(6) = [0.0_wp, 15.0_wp, 25.0_wp, 30.0_wp, 35.0_wp, 45.0_wp]
    real(wp), parameter :: mus(4) = [0.0_wp, 0.5_wp, 0.5_wp, 1.2_wp], etas(3) = [0.9_wp, 0.9_wp, 0.99_wp]
    !> Smallest and largest pressure, relative to sigma0, and step, relative to s_f, of the logarithmic distributions.
    real(wp), parameter :: pressures(2) = [0.01_wp, 100.0_wp], steps(2) = [1.0_wp/2000.0_wp, 0.5_wp]
    !> One sample in six has no normal traction, one in six a tension up to half of the strength.
    integer, parameter :: kinds = 6, fine_shapes = 2
    real(wp), parameter :: tension = 0.5_wp
    integer(int64) :: other
    integer :: i, status

    other = seed_of(seed, 0_int64)
    i = pick(seed, 100)
    sample%load = count(i > shares) + 1
    associate (props => sample%props)
      props([p_sigma0, p_gc, p_eta, p_mu, p_theta]) = [sigma0, gc, 0.9_wp, 0.5_wp, 30.0_wp]
      ! no inclined plane, or 2 to 64 of them
      i = pick(seed, 64) - 1
      if (i > 0) i = i + 1
      props(p_m) = real(i, wp)
      sample%direction = pick(seed, 360) - 1
      if (pick(seed, fine_shapes) == 1) then
        props(p_theta) = thetas(pick(seed, size(thetas)))
        props(p_mu) = mus(pick(seed, size(mus)))
        props(p_eta) = etas(pick(seed, size(etas)))
      end if
      select case (pick(seed, kinds))
      case (1)
        sample%sigma_n = 0.0_wp
      case (2)
        sample%sigma_n = tension*sigma0*uniform(seed)
      case default
        sample%sigma_n = -sigma0*pressures(1)*(pressures(2)/pressures(1))**uniform(seed)
      end select
      sample%step = sf*steps(1)*(steps(2)/steps(1))**uniform(seed)
      call vary(other, sample)
      if (present(branch)) then
        where (.not. prop_table%on_branch) props = 0.0_wp
        sample%initial = 0
      end if
      if (present(across)) then
        if (across) call turn_across(other, sample)
      end if
      ! the slip is along Tx, and the pattern is rotated instead
      if (sample%load /= confined) props(p_turn) = -real(sample%direction, wp)
    end associate
    call new_interface(sample%props, sample%joint, status)
    if (status /= status_ok) error stop "solver_sample: PROPS that are drawn are admissible"
    sample%law = new_rie_law(sample%joint)
    call crack(other, sample)
  end subroutine draw_sample

  !> Draw constants, springs and an initial state that make a sample more difficult, each for a fraction of the samples.
  subroutine vary(seed, sample)
    integer(int64), intent(inout) :: seed           !! 1..largest_seed
    type(sample_type), intent(inout) :: sample      !! the sample, its interface not set
    !> Smallest and largest stiffness of the springs, relative to the usual one.
    real(wp), parameter :: springs(2) = [0.01_wp, 100.0_wp]
    integer, parameter :: one_in = 3
    integer :: i
    call draw_constants(seed, 1.0_wp/real(one_in, wp), sample%props)
    if (pick(seed, one_in) == 1) sample%initial = pick(seed, 2)
    i = pick(seed, 2)
    if (i == 1 .and. any(sample%load == [free_across, sprung])) sample%load = twice_sprung
    do i = 1, 2
      sample%spring(i) = sample%spring(i)*springs(1)*(springs(2)/springs(1))**uniform(seed)
    end do
    if (pick(seed, one_in) == 1) call steepen(seed, sample)
  end subroutine vary

  !> Make a sample a slip free across of a virgin joint with a height, without fc. Half of them have no friction, half
  !> no constants with a default beside height, kc and damage0.
  subroutine turn_across(seed, sample)
    integer(int64), intent(inout) :: seed           !! 1..largest_seed
    type(sample_type), intent(inout) :: sample      !! the sample, its interface not set
    !> Smallest and largest step, relative to s_f; largest number of inclined planes.
    real(wp), parameter :: steps(2) = [0.02_wp, 0.1_wp]
    integer, parameter :: most_planes = 8
    logical :: kept(n_fixed_props)
    sample%load = free_across
    sample%across = .true.
    sample%initial = 0
    sample%step = sf*steps(1)*(steps(2)/steps(1))**uniform(seed)
    associate (props => sample%props)
      props(p_m) = real(1 + pick(seed, most_planes - 1), wp)
      if (chance(seed, 0.5_wp)) then
        kept = .false.
        kept([p_sigma0, p_gc, p_eta, p_mu, p_theta, p_m, p_flat, p_kc, p_damage0]) = .true.
        where (.not. kept) props = prop_table%default
      end if
      props([p_fc, p_gfc]) = 0.0_wp
      call draw_constant(seed, p_height, props)
      if (chance(seed, 0.5_wp)) props(p_mu) = 0.0_wp
    end associate
  end subroutine turn_across

  !> Draw a sample that tends to end in a fold: steep planes, a small flat plane or none, little normal traction.
  subroutine steepen(seed, sample)
    integer(int64), intent(inout) :: seed           !! 1..largest_seed
    type(sample_type), intent(inout) :: sample      !! the sample, its interface not set
    !> Range of the inclinations, degrees; largest weight of the flat plane; normal traction, relative to sigma0.
    real(wp), parameter :: thetas(2) = [30.0_wp, 75.0_wp], most_flat = 0.2_wp, tractions(2) = [1.0e-5_wp, 0.1_wp]
    integer :: i
    associate (props => sample%props)
      props(p_m) = max(2.0_wp, props(p_m))
      props(p_theta) = thetas(1) + (thetas(2) - thetas(1))*uniform(seed)
      props(p_flat) = 0.0_wp
      if (pick(seed, 3) == 1) props(p_flat) = most_flat*uniform(seed)
    end associate
    sample%sigma_n = sigma0*tractions(1)*(tractions(2)/tractions(1))**uniform(seed)
    i = pick(seed, 4)
    if (i == 1) sample%sigma_n = -sample%sigma_n
    if (i > 2) sample%sigma_n = 0.0_wp
  end subroutine steepen

  !> Draw the initial state; a state that cannot carry its traction gets none.
  subroutine crack(seed, sample)
    integer(int64), intent(inout) :: seed           !! 1..largest_seed
    type(sample_type), intent(inout) :: sample      !! its initial state is set
    !> Largest slip, relative to s_f; largest tangential traction, relative to pressure and strength.
    real(wp), parameter :: slip = 1.5_wp, shear = 0.5_wp
    logical, parameter :: all_prescribed(3) = .true.
    real(wp) :: damage, planes(sample%joint%n_statev)
    integer :: i, k, kind, status

    if (sample%initial == 0) return
    planes = 0.0_wp
    ! equal damage of all planes, different damage, or all fully damaged
    kind = pick(seed, 3)
    damage = uniform(seed)
    do k = 1, sample%joint%pattern%n
      i = plane_statev(k)
      if (kind == 2) damage = min(1.0_wp, 2.0_wp*uniform(seed))
      if (kind == 3) damage = 1.0_wp
      planes(i) = damage
      call draw(seed, planes(i + 1:i + 2))
      planes(i + 1:i + 2) = slip*sf*planes(i + 1:i + 2)
    end do
    ! or without slip
    if (pick(seed, 2) == 1) then
      do k = 1, sample%joint%pattern%n
        planes(plane_statev(k) + 1:plane_statev(k) + 2) = 0.0_wp
      end do
    end if
    if (sample%initial == 2) then
      call draw(seed, sample%traction(2:3))
      sample%traction(1) = sample%sigma_n
      sample%traction(2:3) = (abs(sample%sigma_n) + sigma0)*shear*sample%traction(2:3)
    end if
    do i = 1, 3
      sample%state = planes
      call carry_traction(sample%joint, sample%traction, all_prescribed, sample%state, status)
      if (status == status_ok) return
      ! try without the shear, then without traction
      sample%traction(2:3) = 0.0_wp
      if (i == 2) sample%traction(1) = 0.0_wp
    end do
    deallocate (sample%state)
    sample%initial = 0
  end subroutine crack

  !> Apply the preload, then a slip of 1.5 s_f and its reversal, or a tangential traction of twice the strength of all
  !> planes.
  subroutine run_sample(sample, outcome)
    type(sample_type), intent(in) :: sample       !! the sample
    type(outcome_type), intent(out) :: outcome    !! result
    integer, parameter :: preload = 10
    real(wp), parameter :: farthest = 1.5_wp*sf, strength = 2.0_wp
    type(control_type) :: control
    type(point_type) :: point
    real(wp) :: e(2), start(3), load_fraction, target(3)
    integer :: i, n, n_all

    control%traction = [.true., sample%load == all_tractions, &
      any(sample%load == [free_across, all_tractions, twice_sprung])]
    if (any(sample%load == [sprung, twice_sprung])) control%spring(1) = sample%spring(1)
    if (sample%load == twice_sprung) control%spring(3) = sample%spring(2)
    control%dt = 1.0_wp
    e = [1.0_wp, 0.0_wp]
    if (sample%load == confined) e = direction_vector(real(sample%direction, wp))
    n = ceiling(farthest/sample%step)
    n_all = preload + merge(1, 2, sample%load == all_tractions)*n
    outcome%counts(all_increments) = n_all
    outcome%counts(unexplained) = 1
    if (allocated(sample%state)) then
      point = new_point(sample%law, sample%state)
    else
      point = new_point(sample%law)
    end if
    target = merge(sample%traction, 0.0_wp, control%traction)
    do i = 1, n_all
      start = target
      if (i <= preload) then
        load_fraction = real(i, wp)/real(preload, wp)
        target(1) = (1.0_wp - load_fraction)*sample%traction(1) + load_fraction*sample%sigma_n
      else if (sample%load == all_tractions) then
        load_fraction = real(i - preload, wp)/real(n, wp)
        target(2) = (1.0_wp - load_fraction)*sample%traction(2) + &
          load_fraction*(strength*sigma0 + 2.0_wp*abs(sample%sigma_n))
      else
        target(2:3) = e*farthest*(1.0_wp - abs(real(i - preload - n, wp))/real(n, wp))
      end if
      call take(sample, control, start, target, point, outcome)
      if (outcome%counts(wrong) > 0 .or. outcome%counts(increments) < i) return
    end do
    outcome%counts([completed, unexplained]) = [1, 0]
  end subroutine run_sample

  !> Solve one increment and check its result.
  subroutine take(sample, control, start, target, point, outcome)
    type(sample_type), intent(in) :: sample           !! the sample
    type(control_type), intent(in) :: control         !! what is given
    real(wp), intent(in) :: start(3), target(3)       !! given values
    type(point_type), intent(inout) :: point          !! the point
    type(outcome_type), intent(inout) :: outcome      !! increased counts
    type(report_type) :: report
    type(verdict_type) :: verdict
    type(point_type) :: old
    character(len=len(outcome%why)) :: why
    !> Part of what is left of an increment at which a loss is examined.
    real(wp), parameter :: beyond = 1.0e-4_wp
    real(wp) :: place(3), reached, values(3)
    integer :: kind
    logical :: nearby

    old = point
    call advance(sample%law, control, start, target, point, reached, report)
    associate (counts => outcome%counts)
      counts([updates, snaps]) = counts([updates, snaps]) + [report%updates, report%snaps]
      outcome%most_updates = max(outcome%most_updates, report%updates)
      ! the last point is an equilibrium, also if the next one is lost; with the guard an initial state may not be one
      ! before the first increment
      values = start + reached*(target - start)
      if (reached > 0.0_wp .or. counts(increments) > 0) call judge(sample, control, values, old, point, outcome)
      if (counts(wrong) > 0) return
      if (reached >= 1.0_wp) then
        counts(increments) = counts(increments) + 1
        call judge_row(sample%law, control, start, target, old, point, report%snaps, verdict)
        counts([unreported, unbalanced]) = counts([unreported, unbalanced]) + &
          merge(1, 0, [verdict%jump, verdict%defect] > 0.0_wp)
        if (verdict%jump > 0.0_wp .or. verdict%defect > 0.0_wp) outcome%why = "increment " // &
          integer_text(int(counts(increments))) // ": jump without a report " // &
          to_text(verdict%jump) // " s0, energy not balanced " // to_text(verdict%defect)
        return
      end if
      outcome%slow = sample%law%rate_dependent .or. sample%joint%material%guard .or. sample%law%wears
      counts([limited, away]) = merge(1, 0, [report%ended == ended_limit, sample%law%rate_dependent .and. &
        report%ended == ended_lost])
    end associate
    if (all(report%ended /= [ended_lost, ended_limit])) then
      outcome%why = "ended with " // integer_text(report%ended) // " after " // integer_text(report%updates) // &
        " updates of the law"
      return
    end if
    ! beyond the fold, where it is no longer an equilibrium within the tolerance
    values = ramp(start, target, reached + max(2.0_wp*smallest_fraction, beyond*(1.0_wp - reached)))
    call examine_loss(sample%law, control, values, point, kind, place, nearby, &
      wide=.not. sample%across)
    outcome%counts(near_equilibria) = merge(1, 0, nearby)
    outcome%counts([none_found, stopped, unexplained]) = merge(1, 0, kind == [loss_none_found, loss_discontinuous, &
      loss_elsewhere])
    outcome%counts(stuck) = outcome%counts(limited)*outcome%counts(unexplained)
    why = ""
    if (report%ended == ended_limit) why = " limit of updates reached;"
    if (report%jumps > 0) why = " the law jumps from " // to_text(report%sides(1)) // " to " // &
      to_text(report%sides(2)) // ";"
    if (nearby .or. kind == loss_elsewhere) why = trim(why) // " there is an equilibrium at s = " // &
      to_text(place(1)) // ", " // to_text(place(2)) // ", " // to_text(place(3))
    if (len_trim(why) == 0) return
    ! rows before it may have a complaint, too
    if (len_trim(outcome%why) > 0) outcome%why = trim(outcome%why) // "; "
    outcome%why = trim(outcome%why) // "increment " // integer_text(int(outcome%counts(increments)) + 1) // ":" // why
  end subroutine take

  !> Check that the point has the given values and that its state is admissible.
  subroutine judge(sample, control, values, old, point, outcome)
    type(sample_type), intent(in) :: sample           !! the sample
    type(control_type), intent(in) :: control         !! what is given
    real(wp), intent(in) :: values(3)                 !! given values
    type(point_type), intent(in) :: old               !! the point before
    type(point_type), intent(in) :: point             !! the point
    type(outcome_type), intent(inout) :: outcome      !! increased counts
    !> Largest residual, relative to strength and given tractions, for separations of any size; rounding error of K
    !> times the given separations.
    real(wp), parameter :: tolerance = 1.0e-6_wp, rounding = 1.0e-12_wp
    type(point_type) :: again
    type(rie_law) :: still
    real(wp) :: alpha(sample%joint%pattern%n), gap(3), most
    logical :: bad
    integer :: k

    outcome%counts(wrong) = 1
    if (.not. all(bounded([point%s, point%traction, point%state, point%tangent], huge(most)))) then
      outcome%why = "not finite"
      return
    end if
    alpha = [(point%state(plane_statev(k)), k = 1, size(alpha))]
    if (any(alpha < [(old%state(plane_statev(k)), k = 1, size(alpha))]) .or. any(alpha > 1.0_wp)) then
      outcome%why = "damage decreases or is above 1"
      return
    end if
    most = tolerance*(sigma0 + maxval([0.0_wp, pack(abs(values), control%traction)]))
    gap = merge(point%traction + control%spring*point%s - values, &
      sample%joint%material%k_n*(point%s - values), control%traction)
    bad = any(abs(gap) > most .and. (control%traction .or. &
      abs(gap) > rounding*sample%joint%material%k_n*abs(values)))
    if (.not. bad .and. .not. (sample%joint%material%guard .or. sample%joint%material%damps)) then
      ! a zero increment from this state gives the same traction, as nothing slides or is damaged (not so with the
      ! guard), nor do the facets wear further; a dashpot carries nothing in it
      still = sample%law
      still%joint%material%inv_w0 = 0.0_wp
      again = new_point(still, point%state, point%s)
      gap = again%traction - point%traction
      bad = any(abs(gap) > most .and. control%traction)
    end if
    if (.not. bad) outcome%counts(wrong) = 0
    if (bad) outcome%why = "no equilibrium in a row: gap " // to_text(maxval(abs(gap))) // " at s = " // &
      to_text(point%s(1)) // ", " // to_text(point%s(2)) // ", " // to_text(point%s(3))
  end subroutine judge

  !> Text of a sample.
  function describe(sample) result(text)
    type(sample_type), intent(in) :: sample   !! the sample
    character(len=:), allocatable :: text
    text = trim(load_names(sample%load)) // ": " // constants_text(sample%props) // " direction " // &
      integer_text(sample%direction) // ", sigma_N = " // to_text(sample%sigma_n) // ", step " // &
      to_text(sample%step) // ", initial " // integer_text(sample%initial)
    if (any(sample%load == [sprung, twice_sprung])) text = text // ", springs " // to_text(sample%spring(1)) // &
      ", " // to_text(sample%spring(2))
    if (allocated(sample%state)) text = text // ", t = " // to_text(sample%traction(1)) // ", " // &
      to_text(sample%traction(2)) // ", " // to_text(sample%traction(3))
  end function describe

end module solver_sample
