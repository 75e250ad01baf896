!> How much the solver works for drawn scenes, and what it finds: counts (updates of the law, rows, snaps, boxes of
!> proofs) and sums of the results.
!>
!> Without arguments the program prints a line for each scene. With a file of such lines (a record) and a percentage it
!> runs the scenes of the record, and fails if more of them than that percentage differ, with 0 at the first. A
!> difference tells that the solver searches in another way, not that its results are wrong: a compiler may round in
!> another way, and a better search works less. tools/record-search-work.sh makes a new record.
program search_work
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use adaptive_scene, only: adaptive_type => scene_type, draw_adaptive => draw_scene
  use asperity_adaptive, only: adaptive_step, new_walk, walk_type
  use asperity_arc, only: arc_step, arc_type, new_arc
  use asperity_arc_slip, only: branch_slip
  use asperity_contract, only: p_guard, p_height, p_tau_v, p_w0, status_ok, v_friction, v_offset, v_rupture
  use asperity_control_point, only: control_type, new_point, point_type
  use asperity_exclusion, only: exclude_equilibria, most_boxes
  use asperity_increment, only: path_type
  use asperity_initial, only: carry_traction
  use asperity_interface, only: new_interface
  use asperity_kinds, only: wp
  use asperity_loss, only: examine_loss, loss_type
  use asperity_mixed_control, only: advance, ended_complete, full_solver, most_updates, report_type
  use asperity_naive_newton, only: newton_path, tangent_names
  use asperity_slip_test, only: adaptive_slip, confined_slip, joined, slip_test_type
  use asperity_text, only: integer_text
  use branch_scene, only: branch_type => scene_type, draw_branch => draw_scene, start_scene
  use random_numbers, only: draw, log_uniform, pick, seed_of, uniform
  use solver_sample, only: draw_sample, draw_state, outcome_type, run_sample, sample_type
  implicit none
  integer, parameter :: longest = 200
  !> Kinds of scenes, and how many are drawn of each.
  character(len=15), parameter :: kinds(9) = [character(len=15) :: "adaptive", "branch", "increments", "initial", &
    "naive_newton", "slip", "slip_adaptive", "slip_branch", "solver"]
  integer, parameter :: drawn(9) = [400, 500, 400, 150, 200, 300, 200, 200, 300]
  character(len=longest) :: percentage, record
  integer :: allowed, status

  call get_command_argument(1, record)
  call get_command_argument(2, percentage)
  if (len_trim(record) == 0) then
    call print_all()
  else
    read (percentage, *, iostat=status) allowed
    if (status /= 0 .or. allowed < 0 .or. allowed > 100) call fail("'" // trim(percentage) // &
      "' is no percentage from 0 to 100; usage: search_work [RECORD PERCENTAGE]")
    call compare(trim(record), allowed)
  end if

contains

  !> Print the lines of all scenes.
  subroutine print_all()
    character(len=longest) :: line
    integer :: kind, number
    do kind = 1, size(kinds)
      do number = 1, drawn(kind)
        line = work_of(kind, number)
        if (len_trim(line) > 0) write (output_unit, "(a)") trim(line)
      end do
    end do
  end subroutine print_all

  !> Run the scenes of a record and compare.
  subroutine compare(record, allowed)
    character(len=*), intent(in) :: record   !! name of its file
    integer, intent(in) :: allowed           !! largest percentage of scenes that may differ
    character(len=longest) :: line, name, reason, recorded
    integer :: changed, kind, number, ran, status, unit
    open (newunit=unit, file=record, status="old", action="read", iostat=status, iomsg=reason)
    if (status /= 0) call fail(record // ": " // trim(reason))
    changed = 0
    ran = 0
    do
      read (unit, "(a)", iostat=status) recorded
      if (status /= 0) exit
      read (recorded, *, iostat=status) name, number
      kind = 0
      if (status == 0) kind = findloc(kinds == name, .true., dim=1)
      if (kind == 0) call fail(record // ": '" // trim(recorded) // "' is no line of a record")
      ran = ran + 1
      line = work_of(kind, number)
      if (line == recorded) cycle
      changed = changed + 1
      write (output_unit, "(a)") "recorded: " // trim(recorded), "     now: " // trim(line)
      if (allowed == 0) exit
    end do
    close (unit)
    if (ran == 0) call fail(record // " has no scene")
    if (100*changed > allowed*ran) call fail(integer_text(changed) // " of " // integer_text(ran) // &
      " scenes that were run differ from " // record // &
      "; if that is meant, tools/record-search-work.sh makes a new record")
    write (output_unit, "(a)") integer_text(changed) // " of " // integer_text(ran) // " scenes differ", &
      "1 passed, 0 failed"
  end subroutine compare

  !> Stop with a message.
  subroutine fail(why)
    character(len=*), intent(in) :: why   !! the reason
    write (error_unit, "(a)") "search_work: FAILED: " // why
    write (output_unit, "(a)") "0 passed, 1 failed"
    stop 1
  end subroutine fail

  !> Line of a scene, blank if it cannot be run.
  function work_of(kind, number) result(line)
    integer, intent(in) :: kind, number   !! the scene
    character(len=longest) :: line
    integer(int64) :: seed
    line = ""
    seed = seed_of(int(kind, int64), int(number, int64))
    select case (kinds(kind))
    case ("adaptive")
      call adapt(seed, line)
    case ("branch")
      call follow(seed, line)
    case ("increments")
      call advance_or_lose(seed, line)
    case ("initial")
      call start(seed, line)
    case ("naive_newton")
      call iterate(seed, line)
    case ("slip", "slip_adaptive", "slip_branch")
      call slip(seed, kinds(kind), line)
    case default
      call solve(seed, number, line)
    end select
    if (len_trim(line) > 0) line = trim(kinds(kind)) // " " // integer_text(number) // trim(line)
  end function work_of

  !> A weighted sum of results as an integer of about six digits, so that rounding errors do not change it.
  pure function sum_of(values) result(total)
    real(wp), intent(in) :: values(:)   !! results
    integer(int64) :: total
    integer, parameter :: weights = 7, bits = 20
    real(wp) :: terms(size(values))
    integer :: i
    terms = [(real(modulo(i, weights) + 1, wp)*values(i), i=1, size(values))]
    ! the largest terms have `bits` binary digits before the point
    total = nint(scale(sum(terms), bits - exponent(sum(abs(terms)))), int64)
  end function sum_of

  !> Results of a point.
  pure function results_of(point) result(values)
    type(point_type), intent(in) :: point   !! the point
    real(wp) :: values(9)
    values = [point%s, point%traction, point%state([v_rupture, v_friction]), point%work]
  end function results_of

  !> Counts of a report.
  pure function counts_of(report) result(counts)
    type(report_type), intent(in) :: report   !! what happened
    integer :: counts(5)
    counts = [report%ended, report%iterations, report%updates, report%parts, report%snaps]
  end function counts_of

  !> Adaptive increments.
  subroutine adapt(seed, line)
    integer(int64), intent(inout) :: seed             !! of the scene
    character(len=longest), intent(inout) :: line     !! result
    type(adaptive_type) :: scene
    type(walk_type) :: walk
    type(point_type) :: middle, point
    type(report_type) :: reports(2)
    real(wp) :: at, at_middle, reached, start(3), target(3), total(9)
    integer :: coarse, iterations(2), leg, rows, snaps
    call draw_adaptive(seed, scene)
    walk = new_walk(scene%joint)
    walk%tolerance = scene%tolerance
    point = new_point(scene%joint)
    target = 0.0_wp
    total = 0.0_wp
    coarse = 0
    rows = 0
    snaps = 0
    legs: do leg = 1, scene%legs
      associate (control => scene%leg(leg)%control)
        start = merge(point%traction + control%spring*point%s, point%s, control%traction)
        target = scene%leg(leg)%target
        walk%size = scene%first
        at = 0.0_wp
        do while (at < 1.0_wp)
          call adaptive_step(scene%joint, control, start, target, walk, at, point, at_middle, middle, iterations, &
            reached, reports)
          rows = rows + sum(iterations)
          total = total + results_of(middle) + results_of(point)
          if (walk%coarse) coarse = coarse + 1
          snaps = snaps + sum(reports%snaps)
          if (reached < 1.0_wp) exit legs
        end do
      end associate
    end do legs
    write (line, "(*(1x, i0))") rows, walk%updates, walk%solves, walk%rejected, coarse, snaps, sum_of(total)
  end subroutine adapt

  !> A whole branch.
  subroutine follow(seed, line)
    integer(int64), intent(inout) :: seed             !! of the scene
    character(len=longest), intent(inout) :: line     !! result
    !> Longer branches end here.
    integer, parameter :: most_rows = 1000
    type(branch_type) :: scene
    type(arc_type) :: arc
    type(path_type) :: path
    type(point_type) :: point
    type(report_type) :: report
    real(wp) :: total(9)
    integer :: back, counts(5), most(2), rows
    logical :: good
    call draw_branch(seed, scene)
    call start_scene(scene, point, path, good)
    if (.not. good) return
    arc = new_arc(scene%joint, scene%arc)
    back = 0
    most = 0
    counts = 0
    total = 0.0_wp
    do rows = 1, most_rows
      call arc_step(scene%joint, path, arc, point, report)
      counts = counts + counts_of(report)
      total = total + results_of(point)
      if (arc%back) back = back + 1
      most = max(most, [arc%short, arc%unstable])
      if (report%ended /= ended_complete .or. arc%factor >= 1.0_wp) exit
    end do
    write (line, "(*(1x, i0))") rows, back, arc%returns, most, counts, sum_of(total), &
      sum_of([arc%travelled, arc%factor])
  end subroutine follow

  !> Increments of the full solver; if the equilibrium is lost, what the examination of the loss finds, and its proof.
  subroutine advance_or_lose(seed, line)
    integer(int64), intent(inout) :: seed             !! of the scene
    character(len=longest), intent(inout) :: line     !! result
    integer, parameter :: parts = 12
    type(branch_type) :: scene
    type(loss_type) :: loss
    type(path_type) :: path
    type(point_type) :: point
    type(report_type) :: report, sum_of_reports
    real(wp) :: reached, shares(2), total(9)
    integer :: boxes, i, used
    logical :: good, proven
    call draw_branch(seed, scene)
    call extend(seed, scene)
    call start_scene(scene, point, path, good)
    if (.not. good) return
    total = 0.0_wp
    boxes = 0
    path%control%dt = 1.0_wp
    do i = 1, parts
      shares = real([i - 1, i], wp)/real(parts, wp)
      call advance(scene%joint, path%control, path%start + shares(1)*path%change, path%start + shares(2)*path%change, &
        point, used, reached, report=report)
      sum_of_reports = joined(sum_of_reports, report)
      total = total + results_of(point)
      if (reached < 1.0_wp) exit
    end do
    if (reached < 1.0_wp) then
      call examine_loss(scene%joint, path%control, report%beyond, point, most_updates, loss)
      call exclude_equilibria(scene%joint, path%control, report%beyond, point, most_boxes, proven, boxes)
      boxes = merge(boxes, -boxes, proven)
    end if
    associate (scan => loss%scan)
      write (line, "(*(1x, i0))") i, counts_of(sum_of_reports), sum_of(total), sum_of([sum_of_reports%before, &
        sum_of_reports%after, sum_of_reports%released]), loss%kind, scan%samples, &
        merge(1, 0, [scan%found, scan%short]), sum_of([scan%place, scan%lower, scan%upper, scan%extreme]), &
        sum_of([loss%place, loss%leap]), boxes
    end associate
  end subroutine advance_or_lose

  !> Give the joint of a scene viscous damage, guard, height and wear, each by chance.
  subroutine extend(seed, scene)
    integer(int64), intent(inout) :: seed        !! of the scene
    type(branch_type), intent(inout) :: scene    !! the scene
    integer, parameter :: one_in = 5
    !> Exponents of the relaxation time, which is 1 for each increment; of the height, length; of W0, stress*length.
    real(wp), parameter :: times(2) = [-2.0_wp, 2.0_wp], heights(2) = [-2.0_wp, 0.5_wp], works(2) = [-1.5_wp, 1.0_wp]
    integer :: status
    if (pick(seed, one_in) == 1) scene%props(p_tau_v) = log_uniform(seed, times(1), times(2))
    if (pick(seed, one_in) == 1) scene%props(p_guard) = 1.0_wp
    if (pick(seed, one_in) == 1) scene%props(p_height) = log_uniform(seed, heights(1), heights(2))
    if (pick(seed, one_in) == 1) scene%props(p_w0) = log_uniform(seed, works(1), works(2))
    call new_interface(scene%props, scene%joint, status)
    if (status /= status_ok) error stop "search_work: PROPS that are drawn are admissible"
  end subroutine extend

  !> An initial state that carries a traction, and another traction of which some components are given.
  subroutine start(seed, line)
    integer(int64), intent(inout) :: seed             !! of the scene
    character(len=longest), intent(inout) :: line     !! result
    !> Largest component, stress.
    real(wp), parameter :: largest = 6.0_wp
    type(sample_type) :: sample
    real(wp) :: carried(3), target(3)
    real(wp), allocatable :: state(:)
    integer :: i, status
    logical :: endless, held(3)
    call draw_state(seed, sample)
    call draw(seed, target)
    target = largest*target**3
    do i = 1, 3
      held(i) = pick(seed, 3) > 1
    end do
    state = sample%state
    if (pick(seed, 2) == 1) state(v_offset:v_offset + 2) = 0.0_wp
    call carry_traction(sample%joint, target, held, state, status, carried, endless)
    write (line, "(*(1x, i0))") sum_of(sample%state), sum_of(sample%traction), status, merge(1, 0, endless), &
      sum_of(carried), sum_of(state)
  end subroutine start

  !> Newton's method without safeguards.
  subroutine iterate(seed, line)
    integer(int64), intent(inout) :: seed             !! of the scene
    character(len=longest), intent(inout) :: line     !! result
    integer, parameter :: increments = 10, most = 20
    real(wp), parameter :: tolerance = 1.0e-8_wp
    type(branch_type) :: scene
    real(wp), dimension(3, increments) :: separation, targets, traction
    real(wp) :: durations(increments), residuals(0:most, increments)
    real(wp), allocatable :: state(:, :)
    integer :: ended, i, iterations(increments), kind, n_done, updates(increments)
    call draw_branch(seed, scene)
    kind = pick(seed, size(tangent_names))
    do i = 1, increments
      targets(:, i) = scene%target*(real(i, wp)/real(increments, wp))
      durations(i) = uniform(seed)
    end do
    allocate (state(scene%joint%n_statev, increments))
    call newton_path(scene%joint, scene%control, targets, durations, kind, tolerance, separation, traction, state, &
      iterations, updates, residuals, n_done, ended)
    write (line, "(*(1x, i0))") kind, n_done, ended, sum(iterations), sum(updates), sum_of([separation, traction]), &
      sum_of([residuals])
  end subroutine iterate

  !> A slip test and its reversal, in given increments, in adaptive ones or along the branch.
  subroutine slip(seed, kind, line)
    integer(int64), intent(inout) :: seed             !! of the scene
    character(len=*), intent(in) :: kind              !! slip, slip_adaptive or slip_branch
    character(len=longest), intent(inout) :: line     !! result
    integer, parameter :: half = 8, room = 60
    !> Largest slip, length; exponents of the pressure, stress; of the longest step of a branch, over s0.
    real(wp), parameter :: farthest = 0.3_wp, pressures(2) = [-1.5_wp, 1.5_wp], lengths(2) = [-1.0_wp, 0.0_wp]
    type(adaptive_type) :: scene
    type(slip_test_type) :: test
    type(walk_type) :: walk
    type(report_type) :: reports(0:room), both
    real(wp), dimension(3, room) :: separation, traction
    real(wp) :: slips(2*half), times(2*half), work(room)
    real(wp), allocatable :: state(:, :)
    logical :: turned(room)
    integer :: ended, i, n_done, n_rows
    call draw_adaptive(seed, scene)
    test%direction = 360.0_wp*uniform(seed)
    test%sigma_n = -log_uniform(seed, pressures(1), pressures(2))
    if (pick(seed, 4) == 1) test%sigma_n = 0.0_wp
    test%preload = pick(seed, 4)
    test%preload_time = uniform(seed)
    if (pick(seed, 3) == 1) test%stiffness = 30.0_wp*uniform(seed)
    test%method = pick(seed, full_solver)
    slips = farthest*[(real(i, wp)/real(half, wp), i=1, half), (1.0_wp - real(i, wp)/real(half, wp), i=1, half)]
    times = [(real(i, wp), i=1, 2*half)]
    allocate (state(scene%joint%n_statev, room))
    n_rows = 2*half
    ended = 0
    select case (kind)
    case ("slip")
      call confined_slip(scene%joint, test, slips, separation, traction, state, n_done, reports, times, work)
    case ("slip_adaptive")
      walk = new_walk(scene%joint)
      walk%tolerance = scene%tolerance
      call adaptive_slip(scene%joint, test, slips(half:2*half:half), walk, separation, traction, state, work, n_rows, &
        n_done, times(half:2*half:half))
      reports(0)%updates = walk%updates
    case default
      if (scene%joint%material%guard .or. scene%joint%material%tau_v > 0.0_wp) return
      call branch_slip(scene%joint, test, slips(half:2*half:half), 10.0_wp**(lengths(1) + (lengths(2) - &
        lengths(1))*uniform(seed)), separation, traction, state, work, reports, turned, n_rows, n_done, ended)
      if (n_done < 0) return
      n_rows = n_rows + room*count(turned(:min(room, n_rows)))
    end select
    do i = 0, room
      both = joined(both, reports(i))
    end do
    write (line, "(*(1x, i0))") n_done, n_rows, ended, counts_of(both), sum_of([separation]), sum_of([traction]), &
      sum_of([state]), sum_of(work), sum_of([both%before, both%after, both%released])
  end subroutine slip

  !> Newton's method alone, halved increments and the full solver; the full solver's judgement of losses.
  subroutine solve(seed, number, line)
    integer(int64), intent(inout) :: seed             !! of the scene
    integer, intent(in) :: number                     !! of the scene
    character(len=longest), intent(inout) :: line     !! result
    !> Scenes in smaller increments take too long, length.
    real(wp), parameter :: least_step = 0.02_wp
    type(sample_type) :: sample
    type(outcome_type) :: outcome(full_solver)
    integer :: m
    call draw_sample(seed, modulo(number, 3) > 0, modulo(number, 5) == 0, sample)
    if (sample%step < least_step) return
    do m = 1, full_solver
      call run_sample(sample, m, outcome(m))
    end do
    associate (full => outcome(full_solver))
      write (line, "(*(1x, i0))") (outcome(m)%increments, outcome(m)%updates, outcome(m)%most_updates, &
        outcome(m)%snaps, m=1, full_solver), full%boxes, full%unreported, full%unbalanced, &
        merge(1, 0, [full%none_found, full%proven, full%stopped, full%worn, full%away])
    end associate
  end subroutine solve

end program search_work
