!> Runs of a scene: in adaptive increments, and in uniform ones.
module adaptive_run
  use adaptive_rows, only: add_jump, add_row, note_loose, rows_type
  use adaptive_scene, only: scene_type
  use asperity_adaptive, only: adaptive_step, new_walk, walk_type
  use asperity_control_point, only: control_type, new_point, point_type
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, report_type
  implicit none
  private
  public :: run_adaptive, run_uniform, begin_uniform, take_uniform

  !> A run in uniform increments.
  type, public :: uniform_type
    integer :: n = 0                        !! increments of a leg
    integer :: leg = 1, taken = 0           !! the leg, and the increments of it that are taken
    type(control_type) :: control           !! of an increment
    type(point_type) :: old, point          !! start and end of the last increment
    real(wp) :: at = 0.0_wp                 !! place: number of legs before + fraction of the leg
    real(wp) :: start(3) = 0.0_wp, target(3) = 0.0_wp   !! given values at both ends of the leg
    real(wp) :: given(3) = 0.0_wp           !! at the end of the last increment
    real(wp) :: offset(3) = 0.0_wp          !! force of the springs where they are undeformed
    logical :: jumped = .false.             !! whether the last increment contains a snap or a loss
    logical :: ended = .false.              !! whether the path is complete or equilibrium is lost
    logical :: lost = .false.               !! whether equilibrium is lost
    logical :: loose = .false.              !! whether no traction determines the free separations
  end type uniform_type

contains

  !> Given values at both ends of a leg, in the manner of `advance`; the spring has no force at the start of the leg in
  !> which it begins to act.
  pure subroutine ends_of(scene, leg, point, start, target, offset)
    type(scene_type), intent(in) :: scene      !! the scene
    integer, intent(in) :: leg                 !! its number
    type(point_type), intent(in) :: point      !! the point at its start
    real(wp), intent(inout) :: start(3)        !! given values at the start
    real(wp), intent(inout) :: target(3)       !! at the end of the leg before -> of this leg
    real(wp), intent(inout) :: offset(3)       !! force of the springs where they are undeformed
    associate (now => scene%leg(leg), before => scene%leg(max(1, leg - 1)))
      where (now%control%spring > 0.0_wp .and. .not. before%control%spring > 0.0_wp) offset = now%control%spring*point%s
      start = target
      where (now%control%traction .neqv. before%control%traction) start = merge(point%traction, point%s, &
        now%control%traction)
      where (now%control%spring > 0.0_wp .and. .not. before%control%spring > 0.0_wp) start = start + offset
      target = now%target + offset
    end associate
  end subroutine ends_of

  !> Take the load path in adaptive increments.
  subroutine run_adaptive(scene, rows, updates, coarse)
    type(scene_type), intent(in) :: scene           !! the scene
    type(rows_type), intent(out) :: rows            !! its rows
    integer, intent(out) :: updates                 !! updates of the law, rejected increments included
    integer, intent(out) :: coarse                  !! steps that are as small as allowed and exceed the tolerance
    type(walk_type) :: walk
    type(point_type) :: middle, point
    type(report_type) :: reports(2)
    real(wp) :: at, at_middle, offset(3), reached, start(3), target(3)
    integer :: iterations(2), leg
    logical :: loose
    walk = new_walk(scene%joint)
    walk%tolerance = scene%tolerance
    point = new_point(scene%joint)
    target = 0.0_wp
    offset = 0.0_wp
    loose = .false.
    coarse = 0
    call add_row(rows, 0.0_wp, point, loose)
    legs: do leg = 1, scene%legs
      call ends_of(scene, leg, point, start, target, offset)
      walk%size = scene%first
      at = 0.0_wp
      do while (at < 1.0_wp)
        call adaptive_step(scene%joint, scene%leg(leg)%control, start, target, walk, at, point, at_middle, middle, &
          iterations, reached, reports)
        if (.not. reached < 1.0_wp) call add_point(real(leg - 1, wp) + at_middle, middle)
        if (walk%coarse) coarse = coarse + 1
        if (any(reports%snaps > 0) .or. reached < 1.0_wp) call add_jump(real(leg - 1, wp) + at, rows)
        call add_point(real(leg - 1, wp) + at, point)
        if (reached < 1.0_wp) exit legs
      end do
    end do legs
    updates = walk%updates

  contains

    !> Add a row.
    subroutine add_point(at, point)
      real(wp), intent(in) :: at              !! place
      type(point_type), intent(in) :: point   !! the point
      call note_loose(scene%joint, scene%leg(leg)%control, point, scene%tolerance*walk%separation, loose)
      call add_row(rows, at, point, loose)
    end subroutine add_point

  end subroutine run_adaptive

  !> Begin a run in n uniform increments a leg.
  subroutine begin_uniform(scene, n, run)
    type(scene_type), intent(in) :: scene    !! the scene
    integer, intent(in) :: n                 !! increments of a leg
    type(uniform_type), intent(out) :: run   !! the run
    run%n = n
    run%point = new_point(scene%joint)
  end subroutine begin_uniform

  !> Take a uniform increment.
  subroutine take_uniform(scene, length, run)
    type(scene_type), intent(in) :: scene      !! the scene
    real(wp), intent(in) :: length             !! error of the free separations that counts
    type(uniform_type), intent(inout) :: run   !! the run
    type(report_type) :: report
    real(wp) :: last(3), reached
    integer :: used
    if (run%taken == 0) then
      call ends_of(scene, run%leg, run%point, run%start, run%target, run%offset)
      run%control = scene%leg(run%leg)%control
      run%control%dt = run%control%dt/real(run%n, wp)
      run%given = run%start
    end if
    run%taken = run%taken + 1
    last = run%given
    run%given = run%start + (real(run%taken, wp)/real(run%n, wp))*(run%target - run%start)
    if (run%taken == run%n) run%given = run%target
    run%old = run%point
    call advance(scene%joint, run%control, last, run%given, run%point, used, reached, report=report)
    run%at = real(run%leg - 1, wp) + real(run%taken, wp)/real(run%n, wp)
    run%lost = reached < 1.0_wp
    run%jumped = report%snaps > 0 .or. run%lost
    call note_loose(scene%joint, run%control, run%point, length, run%loose)
    if (run%taken == run%n) then
      run%leg = run%leg + 1
      run%taken = 0
    end if
    run%ended = run%lost .or. run%leg > scene%legs
  end subroutine take_uniform

  !> Rows of the load path in n uniform increments a leg.
  subroutine run_uniform(scene, n, length, rows)
    type(scene_type), intent(in) :: scene    !! the scene
    integer, intent(in) :: n                 !! increments of a leg
    real(wp), intent(in) :: length           !! error of the free separations that counts
    type(rows_type), intent(out) :: rows     !! the rows
    type(uniform_type) :: run
    call begin_uniform(scene, n, run)
    call add_row(rows, 0.0_wp, run%point, run%loose)
    do while (.not. run%ended)
      call take_uniform(scene, length, run)
      if (run%jumped) call add_jump(run%at, rows)
      call add_row(rows, run%at, run%point, run%loose)
    end do
  end subroutine run_uniform

end module adaptive_run
