!> Long run of whole branches: a branch may not end where the stable path goes on. The joints and their pressures are
!> those of solver_sample.
program branch_soak
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use asperity_branch, only: branch_step, branch_type, new_branch
  use asperity_equations, only: control_type, new_point, point_type
  use asperity_kinds, only: wp
  use asperity_increment, only: advance, ended_complete, ended_endless, report_type
  use asperity_pattern, only: direction_vector
  use asperity_text, only: integer_text, to_text
  use progress_line, only: start_progress, clear_progress, progress_type, show_progress
  use random_constants, only: constants_text
  use random_numbers, only: chance, pick, seed_of, uniform
  use soak_options, only: options_type, read_options
  use solver_sample, only: draw_sample, sample_type, sf, sigma0
  implicit none
  !> Loads: slip under constant normal traction; the same with a normal spring (CNS); tension on a spring; all tractions
  !> on springs; slip without traction across it; shear on a spring; opening under constant shear tractions; slip while
  !> the normal traction changes.
  character(len=*), parameter :: load_names(8) = [character(len=12) :: "confined", "sprung", "pulled", "all sprung", &
    "free across", "sheared", "opened", "squeezed"]
  integer, parameter :: confined = 1, sprung = 2, pulled = 3, all_sprung = 4, free_across = 5, sheared = 6, &
    opened = 7, squeezed = 8
  !> Ends of a branch: complete; lost where the stable path goes on; lost; endless; too many rows.
  integer, parameter :: complete = 1, early = 2, lost = 3, endless = 4, long = 5
  character(len=*), parameter :: end_names(5) = [character(len=8) :: "complete", "early", "lost", &
    "endless", "long"]
  !> Largest share of scenes that may end early or be too long.
  real(wp), parameter :: most_failures = 0.02_wp
  integer, parameter :: most_rows = 200000
  type(sample_type) :: sample
  type(control_type) :: control
  type(progress_type) :: progress
  type(options_type) :: options
  integer(int64) :: seed
  real(wp) :: arc, target(3)
  integer :: counts(size(load_names), size(end_names)), failures, found, i, load
  logical :: good

  call read_options("branch_soak", 10000, options)
  counts = 0
  call start_progress(progress, "branch_soak", "scenes", options%quiet)
  do i = 1, options%samples
    if (options%only > 0 .and. i /= options%only) cycle
    seed = seed_of(options%seed, int(i, int64))
    call draw_sample(seed, sample, branch=.true.)
    call draw_load(seed)
    call follow(found, good)
    if (.not. good) cycle
    counts(load, found) = counts(load, found) + 1
    if (options%only > 0 .or. found == early .or. found == long) then
      call clear_progress(progress)
      write (error_unit, "(a)") "branch_soak: scene " // integer_text(i) // ": " // trim(end_names(found)) // ": " // &
        description()
    end if
    call show_progress(progress, "", i, options%samples)
  end do
  call clear_progress(progress)
  call write_table()
  failures = sum(counts(:, early)) + sum(counts(:, long))
  good = sum(counts) > 0 .and. real(failures, wp) <= most_failures*real(sum(counts), wp)
  if (.not. good) write (error_unit, "(a)") "branch_soak: FAILED: more than " // to_text(100.0_wp*most_failures) // &
    " % end where the stable path goes on, or have too many rows, or no scene has a start"
  ! the share of failures is the test
  write (output_unit, "(a)") merge("1 passed, 0 failed", "0 passed, 1 failed", good)
  if (.not. good) stop 1

contains

  !> Draw what is prescribed, its values at the end, and the longest step.
  subroutine draw_load(seed)
    integer(int64), intent(inout) :: seed       !! 1..largest_seed
    !> Stiffness of the springs, stress/length: none, soft, stiff.
    real(wp), parameter :: springs(7) = [0.0_wp, 0.5_wp, 2.0_wp, 5.0_wp, 15.0_wp, 80.0_wp, 400.0_wp]
    !> Smallest and largest slip, relative to s_f; largest traction, relative to sigma0.
    real(wp), parameter :: slips(2) = [0.25_wp, 2.0_wp], tractions = 3.0_wp
    real(wp), parameter :: arcs(6) = [0.02_wp, 0.05_wp, 0.1_wp, 0.2_wp, 0.5_wp, 1.0_wp]
    real(wp) :: slip, soft
    integer :: i

    load = pick(seed, size(load_names))
    arc = arcs(pick(seed, size(arcs)))
    control = control_type()
    slip = sf*(slips(1) + (slips(2) - slips(1))*uniform(seed))
    soft = springs(pick(seed, size(springs)))
    control%traction(1) = .true.
    target = [sample%sigma_n, 0.0_wp, 0.0_wp]
    if (any(load == [confined, sprung, squeezed])) then
      target(2:3) = slip*direction_vector(360.0_wp*uniform(seed))
      if (chance(seed, 0.3_wp)) target(2:3) = [slip, 0.0_wp]
    end if
    if (any(load == [sprung, free_across, sheared, squeezed])) control%spring(1) = soft
    select case (load)
    case (pulled)
      control%spring(1) = springs(1 + pick(seed, size(springs) - 1))
      target(1) = sigma0*(0.3_wp + (tractions - 0.3_wp)*uniform(seed))
    case (all_sprung)
      control%traction = .true.
      do i = 1, 3
        control%spring(i) = springs(1 + pick(seed, size(springs) - 1))
        target(i) = 0.5_wp*tractions*sigma0*(2.0_wp*uniform(seed) - 1.0_wp)
      end do
    case (free_across)
      control%traction(3) = .true.
      target(2) = slip
    case (sheared)
      control%traction(2) = .true.
      control%spring(2) = springs(1 + pick(seed, size(springs) - 1))
      target(2) = sigma0*(0.5_wp + (tractions - 0.5_wp)*uniform(seed))
    case (opened)
      control%traction = [.false., .true., .true.]
      target(1) = slip
      do i = 2, 3
        target(i) = 0.1_wp*sigma0*uniform(seed)
      end do
    case (squeezed)
      target(1) = sigma0*(tractions*uniform(seed) - 2.0_wp)
    case default
      continue   ! confined or sprung: the normal traction stays
    end select
  end subroutine draw_load

  !> Follow the branch of the scene to its end.
  subroutine follow(found, good)
    integer, intent(out) :: found    !! end
    logical, intent(out) :: good     !! whether the scene has a start
    type(branch_type) :: branch
    type(point_type) :: point
    type(report_type) :: report
    real(wp) :: from(3)
    integer :: rows
    found = complete
    call start_scene(point, from, good)
    if (.not. good) return
    branch = new_branch(sample%law, control, from, target, arc, 0)
    do rows = 1, most_rows
      call branch_step(sample%law, branch, point, report)
      if (report%ended /= ended_complete .or. branch%factor >= 1.0_wp) exit
    end do
    if (rows > most_rows) then
      found = long
    else if (report%ended == ended_endless) then
      found = endless
    else if (report%ended /= ended_complete) then
      found = lost
      if (goes_on(from, branch, point)) found = early
    end if
  end subroutine follow

  !> Bring a virgin point under the normal traction.
  subroutine start_scene(point, from, good)
    type(point_type), intent(out) :: point     !! under the normal traction
    real(wp), intent(out) :: from(3)           !! prescribed values of the point
    logical, intent(out) :: good               !! whether it carries the traction without a snap
    integer, parameter :: parts = 20
    type(report_type) :: report
    real(wp) :: reached, start(3), to(3)
    integer :: i
    point = new_point(sample%law)
    to = 0.0_wp
    do i = 1, parts
      start = to
      to(1) = sample%sigma_n*(real(i, wp)/real(parts, wp))
      call advance(sample%law, control_type([.true., .true., .true.]), start, to, point, reached, report)
      good = reached >= 1.0_wp .and. report%snaps == 0
      if (.not. good) return
    end do
    from = merge(to + control%spring*point%s, point%s, control%traction)
  end subroutine start_scene

  !> Whether the stable path goes on from the end of a branch: increments of a hundredth of s0 find ten equilibria
  !> without a snap.
  function goes_on(from, branch, point) result(yes)
    real(wp), intent(in) :: from(3)             !! prescribed values at the start
    type(branch_type), intent(in) :: branch     !! progress
    type(point_type), intent(in) :: point       !! the end of the branch
    logical :: yes
    integer, parameter :: parts = 10
    real(wp), parameter :: part = 0.01_wp
    type(point_type) :: ahead
    type(report_type) :: report
    real(wp) :: change(3), factor, next, reached, unit
    integer :: k
    yes = .not. branch%back
    if (.not. yes) return
    change = target - from
    unit = maxval(abs(change)/merge(sample%law%stiffness, 1.0_wp, control%traction))
    ahead = point
    factor = branch%factor
    do k = 1, parts
      next = min(1.0_wp, factor + part*sample%law%s_0/unit)
      call advance(sample%law, control, from + factor*change, from + next*change, ahead, reached, &
        report)
      yes = yes .and. reached >= 1.0_wp .and. report%snaps == 0
      factor = next
    end do
    yes = yes .and. norm2(ahead%s - point%s) < sample%law%s_0
  end function goes_on

  !> The scene as groups of a case file, for messages.
  function description() result(text)
    character(len=:), allocatable :: text
    character(len=*), parameter :: names(3) = [character(len=2) :: "N", "Tx", "Ty"]
    integer :: i
    text = trim(load_names(load)) // ": " // constants_text(sample%props) // " &step t_N = " // &
      to_text(sample%sigma_n) // ", t_Tx = 0, t_Ty = 0, increments = 20 / &step"
    do i = 1, 3
      text = text // merge(" t_", " s_", control%traction(i)) // trim(names(i)) // " = " // &
        to_text(target(i)) // ","
      if (control%spring(i) > 0.0_wp) text = text // " k_" // trim(names(i)) // " = " // &
        to_text(control%spring(i)) // ","
    end do
    text = text // " follow = 'branch', arc = " // to_text(arc) // " /"
  end function description

  !> Write the results.
  subroutine write_table()
    integer :: k
    write (output_unit, "(a, i0, a)") "branch_soak: ", sum(counts), " scenes; how their branches end"
    write (output_unit, "(4x, a12, 5a10)") "", adjustr(end_names)
    do k = 1, size(load_names)
      write (output_unit, "(4x, a12, 5i10)") load_names(k), counts(k, :)
    end do
    write (output_unit, "(4x, a12, 5i10)") "all", sum(counts, dim=1)
  end subroutine write_table

end program branch_soak
