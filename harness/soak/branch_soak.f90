!> Long run of whole branches: a branch may not end where the stable path goes on.
program branch_soak
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use asperity_arc, only: arc_step, arc_type, new_arc
  use asperity_arc_equations, only: load_length
  use asperity_control_point, only: point_type
  use asperity_increment, only: path_type
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, ended_complete, ended_divided, ended_endless, report_type
  use asperity_text, only: integer_text, to_text
  use branch_scene, only: describe, draw_scene, load_names, scene_type, start_scene
  use progress_line, only: begin_progress, clear_progress, progress_type, show_progress
  use random_numbers, only: seed_of
  use soak_options, only: options_type, read_options
  implicit none
  !> Ends of a branch: complete; lost or divided where the stable path goes on; divided; lost; endless; too many rows.
  integer, parameter :: complete = 1, early = 2, divided = 3, lost = 4, endless = 5, long = 6
  character(len=*), parameter :: end_names(6) = [character(len=8) :: "complete", "early", "divided", "lost", &
    "endless", "long"]
  !> Largest share of scenes that may end early or be too long.
  real(wp), parameter :: most_failures = 0.002_wp
  integer, parameter :: most_rows = 200000
  type(scene_type) :: scene
  type(progress_type) :: progress
  integer(int64) :: seed
  integer :: counts(size(load_names), size(end_names)), failures, found, i
  logical :: good
  type(options_type) :: options

  call read_options("branch_soak", 10000, "", options)
  counts = 0
  call begin_progress(progress, "branch_soak", "scenes", options%quiet)
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
    type(arc_type) :: arc
    type(path_type) :: path
    type(point_type) :: point
    type(report_type) :: report
    integer :: rows
    found = complete
    call start_scene(scene, point, path, good)
    if (.not. good) return
    arc = new_arc(scene%joint, scene%arc)
    do rows = 1, most_rows
      call arc_step(scene%joint, path, arc, point, report)
      if (report%ended /= ended_complete .or. arc%factor >= 1.0_wp) exit
    end do
    if (rows > most_rows) then
      found = long
    else if (report%ended == ended_endless) then
      found = endless
    else if (report%ended /= ended_complete) then
      found = merge(divided, lost, report%ended == ended_divided)
      if (goes_on(path, arc, point)) found = early
    end if
  end subroutine follow

  !> Whether the stable path goes on from the end of a branch: increments of a hundredth of s0 find ten equilibria
  !> without a snap.
  function goes_on(path, arc, point) result(yes)
    type(path_type), intent(in) :: path      !! the prescribed values
    type(arc_type), intent(in) :: arc        !! progress
    type(point_type), intent(in) :: point    !! the end of the branch
    logical :: yes
    integer, parameter :: parts = 10
    real(wp), parameter :: part = 0.01_wp
    type(point_type) :: ahead
    type(report_type) :: report
    real(wp) :: factor, length, next, reached
    integer :: k, used
    yes = .not. arc%back
    if (.not. yes) return
    associate (material => scene%joint%material)
      length = load_length(scene%joint, path)
      ahead = point
      factor = arc%factor
      do k = 1, parts
        next = min(1.0_wp, factor + part*material%s0/length)
        call advance(scene%joint, path%control, path%start + factor*path%change, path%start + next*path%change, ahead, &
          used, reached, report=report)
        yes = yes .and. reached >= 1.0_wp .and. report%snaps == 0
        factor = next
      end do
      yes = yes .and. sqrt(sum((ahead%s - point%s)**2)) < material%s0
    end associate
  end function goes_on

  !> Write the results.
  subroutine write_table()
    integer :: k
    write (output_unit, "(a, i0, a)") "branch_soak: ", sum(counts), " scenes; how their branches end"
    write (output_unit, "(4x, a12, 6a10)") "", adjustr(end_names)
    do k = 1, size(load_names)
      write (output_unit, "(4x, a12, 6i10)") load_names(k), counts(k, :)
    end do
    write (output_unit, "(4x, a12, 6i10)") "all", sum(counts, dim=1)
  end subroutine write_table

end program branch_soak
