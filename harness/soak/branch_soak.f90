!> Long run of whole branches: a branch may not end where the stable path goes on.
program branch_soak
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use asperity_branch, only: branch_step, branch_type, new_branch
  use asperity_control_point, only: point_type
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, ended_complete, ended_endless, report_type
  use asperity_rie_law, only: rie_law
  use asperity_text, only: integer_text, to_text
  use branch_scene, only: describe, draw_scene, load_names, scene_type, start_scene
  use progress_line, only: start_progress, clear_progress, progress_type, show_progress
  use random_numbers, only: seed_of
  use soak_options, only: options_type, read_options
  implicit none
  !> Ends of a branch: complete; lost where the stable path goes on; lost; endless; too many rows.
  integer, parameter :: complete = 1, early = 2, lost = 3, endless = 4, long = 5
  character(len=*), parameter :: end_names(5) = [character(len=8) :: "complete", "early", "lost", &
    "endless", "long"]
  !> Largest share of scenes that may end early or be too long.
  real(wp), parameter :: most_failures = 0.02_wp
  integer, parameter :: most_rows = 200000
  type(scene_type) :: scene
  type(progress_type) :: progress
  integer(int64) :: seed
  integer :: counts(size(load_names), size(end_names)), failures, found, i
  logical :: good
  type(options_type) :: options

  call read_options("branch_soak", 10000, "", options)
  counts = 0
  call start_progress(progress, "branch_soak", "scenes", options%quiet)
  do i = 1, options%samples
    if (options%only > 0 .and. i /= options%only) cycle
    seed = seed_of(options%seed, int(i, int64))
    call draw_scene(seed, scene)
    call follow(found, good)
    if (.not. good) cycle
    counts(scene%load, found) = counts(scene%load, found) + 1
    if (options%only > 0 .or. found == early .or. found == long) then
      call clear_progress(progress)
      write (error_unit, "(a)") "branch_soak: scene " // integer_text(i) // ": " // trim(end_names(found)) // ": " // &
        describe(scene)
    end if
    call show_progress(progress, "", i, options%samples)
  end do
  call clear_progress(progress)
  call write_table()
  failures = sum(counts(:, early)) + sum(counts(:, long))
  if (sum(counts) == 0) then
    write (error_unit, "(a)") "branch_soak: FAILED: no scene has a start"
    write (output_unit, "(a)") "0 passed, 1 failed"
    stop 1
  end if
  if (real(failures, wp) > most_failures*real(sum(counts), wp)) then
    write (error_unit, "(a)") "branch_soak: FAILED: more than " // to_text(100.0_wp*most_failures) // &
      " % end where the stable path goes on, or have too many rows"
    write (output_unit, "(a)") "0 passed, 1 failed"
    stop 1
  end if
  ! the share of failures is the test
  write (output_unit, "(a)") "1 passed, 0 failed"

contains

  !> Follow the branch of the scene to its end.
  subroutine follow(found, good)
    integer, intent(out) :: found    !! end
    logical, intent(out) :: good     !! whether the scene has a start
    type(branch_type) :: branch
    type(rie_law) :: law
    type(point_type) :: point
    type(report_type) :: report
    real(wp) :: from(3)
    integer :: rows
    found = complete
    call start_scene(scene, law, point, from, good)
    if (.not. good) return
    branch = new_branch(law, scene%control, from, scene%target, scene%arc)
    do rows = 1, most_rows
      call branch_step(law, branch, point, report)
      if (report%ended /= ended_complete .or. branch%factor >= 1.0_wp) exit
    end do
    if (rows > most_rows) then
      found = long
    else if (report%ended == ended_endless) then
      found = endless
    else if (report%ended /= ended_complete) then
      found = lost
      if (goes_on(law, from, branch, point)) found = early
    end if
  end subroutine follow

  !> Whether the stable path goes on from the end of a branch: increments of a hundredth of s0 find ten equilibria
  !> without a snap.
  function goes_on(law, from, branch, point) result(yes)
    type(rie_law), intent(in) :: law            !! the law
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
    change = scene%target - from
    unit = maxval(abs(change)/merge(law%stiffness, 1.0_wp, scene%control%traction))
    ahead = point
    factor = branch%factor
    do k = 1, parts
      next = min(1.0_wp, factor + part*law%length/unit)
      call advance(law, scene%control, from + factor*change, from + next*change, ahead, reached, report)
      yes = yes .and. reached >= 1.0_wp .and. report%snaps == 0
      factor = next
    end do
    yes = yes .and. norm2(ahead%s - point%s) < law%length
  end function goes_on

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
