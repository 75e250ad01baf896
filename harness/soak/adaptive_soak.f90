!> Long run of adaptive increments: random scenes are compared with the same load path in fine uniform increments.
program adaptive_soak
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use adaptive_judge, only: curves, judge_scene, promise, verdict_type
  use adaptive_rows, only: n_values
  use adaptive_scene, only: describe, draw_scene, is_viscous, scene_type
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text, to_text
  use progress_line, only: begin_progress, clear_progress, progress_type, show_progress
  use random_numbers, only: seed_of
  use soak_options, only: options_type, read_options
  implicit none
  !> Largest share of scenes that may miss (docs/solver.md), at least one.
  real(wp), parameter :: most_misses = 0.02_wp
  character(len=*), parameter :: names(n_values) = [character(len=8) :: "t_N", "t_Tx", "t_Ty", "s_N", "s_Tx", "s_Ty", &
    "rupture", "friction", "work"]
  type(scene_type) :: scene
  type(verdict_type) :: verdict
  type(progress_type) :: progress
  integer(int64) :: seed
  integer :: i, loose, misses, undecidable, unresolved, viscous, with_coarse, with_jump
  integer, allocatable :: rows(:), updates(:)
  real(wp), allocatable :: worst(:), worst_energy(:)
  logical :: few
  type(options_type) :: options

  call read_options("adaptive_soak", 1000, "", options)
  allocate (rows(0), updates(0), worst(0), worst_energy(0))
  misses = 0
  loose = 0
  undecidable = 0
  unresolved = 0
  viscous = 0
  with_coarse = 0
  with_jump = 0
  call begin_progress(progress, "adaptive_soak", "scenes", options%quiet)
  do i = 1, options%samples
    if (options%only > 0 .and. i /= options%only) cycle
    seed = seed_of(options%seed, int(i, int64))
    call draw_scene(seed, scene)
    call judge_scene(scene, verdict)
    rows = [rows, verdict%rows]
    updates = [updates, verdict%updates]
    if (verdict%loose) loose = loose + 1
    if (verdict%decidable) then
      worst = [worst, maxval(verdict%errors(:curves))]
      worst_energy = [worst_energy, maxval(verdict%errors(curves + 1:))]
    else
      undecidable = undecidable + 1
    end if
    if (maxval(verdict%errors(:curves)) > promise .or. options%only > 0) call tell()
    call show_progress(progress, "", i, options%samples)
  end do
  call clear_progress(progress)
  call write_table()
  few = real(misses, wp) <= max(1.0_wp, most_misses*real(size(rows), wp))
  ! the sanitizer takes what a program leaves allocated for lost
  deallocate (rows, updates, worst, worst_energy)
  if (.not. few) then
    write (error_unit, "(a)") "adaptive_soak: FAILED: more misses than " // to_text(100.0_wp*most_misses) // " %"
    write (output_unit, "(a)") "0 passed, 1 failed"
    stop 1
  end if
  ! the share of misses is the test
  write (output_unit, "(a)") "1 passed, 0 failed"

contains

  !> Describe a scene whose error is too large, and count it.
  subroutine tell()
    character(len=:), allocatable :: about
    integer :: k
    k = maxloc(verdict%errors(:curves), dim=1)
    about = ""
    if (.not. verdict%decidable) then
      about = " (undecidable)"
    else if (verdict%errors(k) > promise) then
      misses = misses + 1
      if (verdict%coarse > 0) then
        with_coarse = with_coarse + 1
        about = " (coarse)"
      else
        if (is_viscous(scene)) viscous = viscous + 1
        if (verdict%jumps > 0) with_jump = with_jump + 1
        if (.not. verdict%resolved) unresolved = unresolved + 1
      end if
    end if
    call clear_progress(progress)
    write (error_unit, "(a)") "adaptive_soak: scene " // integer_text(i) // about // ": error " // &
      to_text(verdict%errors(k)) // " of " // trim(names(k)) // " at " // to_text(verdict%at(k)) // &
      " (leg, fraction): " // describe(scene)
  end subroutine tell

  !> Write the results.
  subroutine write_table()
    real(wp), parameter :: limits(5) = [1.0_wp, promise, 2.0_wp, 5.0_wp, 10.0_wp]
    integer :: k
    write (output_unit, "(a, i0, a)") "adaptive_soak: ", size(rows), " scenes; errors relative to the tolerance"
    if (size(worst) > 0) write (output_unit, "(4x, a, 2f10.2)") "curves: median, largest          ", middle(worst), &
      maxval(worst)
    do k = 1, size(limits)
      write (output_unit, "(4x, a, f4.1, a, i0, a, i0)") "scenes above ", limits(k), ": curves ", &
        count(worst > limits(k)), ", energies at the rows ", count(worst_energy > limits(k))
    end do
    write (output_unit, "(4x, a, f3.1, 5(a, i0), a)") "above ", promise, ": with the event coarse ", with_coarse, &
      ", without ", misses - with_coarse, " (viscous ", viscous, ", with a snap or a loss ", with_jump, &
      ", comparison not converged ", unresolved, ")"
    write (output_unit, "(4x, 2(a, i0))") "not judged: scenes in which uniform increments do not converge ", &
      undecidable, ", scenes with free separations that no traction determines ", loose
    write (output_unit, "(4x, a, f0.1, a, f0.1)") "cost, medians: rows ", middle(real(rows, wp)), &
      ", updates of the law ", middle(real(updates, wp))
  end subroutine write_table

  !> Median.
  pure function middle(values) result(m)
    real(wp), intent(in) :: values(:)   !! at least one
    real(wp) :: m
    integer :: k
    m = values(1)
    do k = 1, size(values)
      m = values(k)
      if (2*count(values < m) <= size(values) .and. 2*count(values <= m) >= size(values)) return
    end do
  end function middle

end program adaptive_soak
