!> True errors of adaptive increments: straight lines between the rows are compared with the same load path in uniform
!> increments, so many that twice as many give the same errors.
module adaptive_judge
  use adaptive_scene, only: scene_type
  use asperity_adaptive, only: adaptive_step, new_walk, walk_type
  use asperity_contract, only: v_friction, v_rupture
  use asperity_control_point, only: control_type, new_point, point_type
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, report_type
  implicit none
  private
  public :: judge_scene

  !> Values that are compared: tractions and separations along the lines; rupture, friction and work at the rows.
  integer, parameter, public :: n_values = 9
  !> Accuracy of the place of a steep change, as a fraction of the leg and of the tolerance: the smallest increment. The
  !> place of a snap or of a loss is accurate to the tolerance; near a fold the error of the place is that of the load.
  real(wp), parameter :: place = 0.01_wp, place_of_jump = 1.0_wp
  !> Uniform increments of a leg, at first and at most, and the change of the errors that is tolerated when the number
  !> is doubled, relative to the tolerance.
  integer, parameter :: coarsest = 500, finest = 64000
  real(wp), parameter :: same = 0.1_wp
  !> Largest number of snaps that are noted of each run.
  integer, parameter :: most_jumps = 20

  !> Rows of a run.
  type :: rows_type
    integer :: n = 0
    real(wp), allocatable :: at(:)           !! place of the row: number of legs before + fraction of the leg
    real(wp), allocatable :: values(:, :)    !! (n_values, n)
    integer :: n_jumps = 0
    real(wp) :: jumps(most_jumps) = -1.0_wp  !! places of snaps, and of a loss
  end type rows_type

  !> Findings.
  type, public :: verdict_type
    real(wp) :: errors(n_values) = 0.0_wp    !! largest errors, relative to the tolerance
    real(wp) :: at(n_values) = 0.0_wp        !! their places: number of legs before + fraction of the leg
    logical :: resolved = .false.            !! whether twice as many uniform increments give the same errors
    integer :: jumps = 0                     !! snaps and losses of the uniform run
    integer :: rows = 0, updates = 0         !! rows; updates of the law, rejected increments included
    integer :: coarse = 0                    !! steps that are as small as allowed and exceed the tolerance
  end type verdict_type

contains

  !> Judge the adaptive increments of a scene.
  subroutine judge_scene(scene, verdict)
    type(scene_type), intent(in) :: scene         !! the scene
    type(verdict_type), intent(out) :: verdict    !! findings
    type(rows_type) :: jumps, rows
    real(wp) :: before(n_values)
    integer :: n
    call run_adaptive(scene, rows, verdict)
    n = coarsest
    call compare(scene, rows, n, jumps, verdict)
    do while (n < finest .and. .not. verdict%resolved)
      before = verdict%errors
      n = 2*n
      call compare(scene, rows, n, jumps, verdict)
      verdict%resolved = all(abs(verdict%errors - before) <= same*max(1.0_wp, verdict%errors))
    end do
    verdict%jumps = jumps%n_jumps
  end subroutine judge_scene

  !> Values of a point that are compared.
  pure function values_of(point) result(values)
    type(point_type), intent(in) :: point   !! the point
    real(wp) :: values(n_values)
    values = [point%traction, point%s, point%state(v_rupture), point%state(v_friction), point%work]
  end function values_of

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
  subroutine run_adaptive(scene, rows, verdict)
    type(scene_type), intent(in) :: scene           !! the scene
    type(rows_type), intent(out) :: rows            !! its rows
    type(verdict_type), intent(inout) :: verdict    !! counts are set
    type(walk_type) :: walk
    type(point_type) :: middle, point
    type(report_type) :: reports(2)
    real(wp) :: at, at_middle, offset(3), reached, start(3), target(3)
    integer :: iterations(2), leg
    walk = new_walk(scene%joint)
    walk%tolerance = scene%tolerance
    point = new_point(scene%joint)
    target = 0.0_wp
    offset = 0.0_wp
    call add_row(rows, 0.0_wp, point)
    legs: do leg = 1, scene%legs
      call ends_of(scene, leg, point, start, target, offset)
      walk%size = scene%first
      at = 0.0_wp
      do while (at < 1.0_wp)
        call adaptive_step(scene%joint, scene%leg(leg)%control, start, target, walk, at, point, at_middle, middle, &
          iterations, reached, reports)
        if (.not. reached < 1.0_wp) call add_row(rows, real(leg - 1, wp) + at_middle, middle)
        if (walk%coarse) verdict%coarse = verdict%coarse + 1
        if (any(reports%snaps > 0) .or. reached < 1.0_wp) call add_jump(real(leg - 1, wp) + at, rows)
        call add_row(rows, real(leg - 1, wp) + at, point)
        if (reached < 1.0_wp) exit legs
      end do
    end do legs
    verdict%rows = rows%n - 1
    verdict%updates = walk%updates
  end subroutine run_adaptive

  !> Add a row.
  subroutine add_row(rows, at, point)
    type(rows_type), intent(inout) :: rows       !! rows so far
    real(wp), intent(in) :: at                   !! place
    type(point_type), intent(in) :: point        !! the point
    type(rows_type) :: longer
    integer, parameter :: first = 256
    if (.not. allocated(rows%at)) allocate (rows%at(first), rows%values(n_values, first))
    if (rows%n == size(rows%at)) then
      allocate (longer%at(2*rows%n), longer%values(n_values, 2*rows%n))
      longer%at(:rows%n) = rows%at
      longer%values(:, :rows%n) = rows%values
      call move_alloc(longer%at, rows%at)
      call move_alloc(longer%values, rows%values)
    end if
    rows%n = rows%n + 1
    rows%at(rows%n) = at
    rows%values(:, rows%n) = values_of(point)
  end subroutine add_row

  !> Note the place of a snap or of a loss.
  subroutine add_jump(at, rows)
    real(wp), intent(in) :: at                   !! place
    type(rows_type), intent(inout) :: rows       !! of the run
    rows%n_jumps = min(most_jumps, rows%n_jumps + 1)
    rows%jumps(rows%n_jumps) = at
  end subroutine add_jump

  !> Take the load path in n uniform increments a leg, and compare the rows with it.
  subroutine compare(scene, rows, n, jumps, verdict)
    type(scene_type), intent(in) :: scene           !! the scene
    type(rows_type), intent(in) :: rows             !! rows of the adaptive run
    integer, intent(in) :: n                        !! uniform increments of a leg
    type(rows_type), intent(inout) :: jumps         !! jumps of the run in fewer increments -> of this run
    type(verdict_type), intent(inout) :: verdict    !! its errors are set
    type(control_type) :: control
    type(point_type) :: old, point
    type(report_type) :: report
    type(rows_type) :: earlier
    real(wp) :: at, errors(n_values), given(3), last(3), length, offset(3), reached, scale(n_values), start(3), &
      target(3), window
    logical :: near_jump
    integer :: i, leg, next, row, used

    point = new_point(scene%joint)
    target = 0.0_wp
    offset = 0.0_wp
    length = 0.0_wp
    verdict%errors = 0.0_wp
    row = 1
    next = 2
    associate (m => scene%joint%material)
      scale(1:3) = m%k_n/sqrt(m%inv_s01_2)
      scale(4:6) = m%s0/(1.0_wp - m%eta)
      scale(7:9) = scale(1)*scale(4)
    end associate
    earlier = jumps
    jumps%n_jumps = 0
    jumps%jumps = -1.0_wp
    legs: do leg = 1, scene%legs
      call ends_of(scene, leg, point, start, target, offset)
      control = scene%leg(leg)%control
      control%dt = control%dt/real(n, wp)
      given = start
      do i = 1, n
        last = given
        given = start + (real(i, wp)/real(n, wp))*(target - start)
        if (i == n) given = target
        old = point
        call advance(scene%joint, control, last, given, point, used, reached, report=report)
        at = real(leg - 1, wp) + real(i, wp)/real(n, wp)
        if (report%snaps > 0 .or. reached < 1.0_wp) call add_jump(at, jumps)
        if (reached < 1.0_wp .or. at > rows%at(rows%n)) exit legs
        length = length + sqrt(sum((point%s - old%s)**2))
        scale(1:3) = max(scale(1:3), sqrt(sum(point%traction**2)))
        scale(4:6) = max(scale(4:6), maxval(abs(point%s), mask=control%traction))
        scale(7:9) = max(scale(7:9), scale(1)*length)
        near_jump = any(abs([rows%jumps, earlier%jumps] - at) <= 2.0_wp*place_of_jump*scene%tolerance)
        window = merge(place_of_jump, place, near_jump)*scene%tolerance
        errors = line_errors(rows, max(real(leg - 1, wp), at - window), min(real(leg, wp), at + window), &
          values_of(point), row)/(scale*scene%tolerance)
        errors(4:6) = merge(errors(4:6), 0.0_wp, control%traction)
        errors(7:9) = 0.0_wp
        do while (next <= rows%n)
          if (rows%at(next) > at) exit
          ! energies are not linear between the rows
          if (.not. near_jump) errors(7:9) = max(errors(7:9), row_errors(rows%at(next), rows%values(7:9, next))/ &
            (scale(7:9)*scene%tolerance))
          next = next + 1
        end do
        where (errors > verdict%errors) verdict%at = at
        verdict%errors = max(verdict%errors, errors)
      end do
    end do legs

  contains

    !> Errors of the energies of a row within the last uniform increment.
    function row_errors(place_of_row, energies) result(error)
      real(wp), intent(in) :: place_of_row      !! place of the row
      real(wp), intent(in) :: energies(3)       !! rupture, friction, work there
      real(wp) :: error(3)
      real(wp) :: first(n_values), second(n_values)
      first = values_of(old)
      second = values_of(point)
      error = abs(energies - second(7:9) + (at - place_of_row)*real(n, wp)*(second(7:9) - first(7:9)))
    end function row_errors

  end subroutine compare

  !> Distances of values from the range of the lines between two places.
  function line_errors(rows, from, to, values, row) result(errors)
    type(rows_type), intent(in) :: rows        !! the rows
    real(wp), intent(in) :: from, to           !! places
    real(wp), intent(in) :: values(n_values)   !! values to compare
    integer, intent(inout) :: row              !! row before the last place that was asked for, 1 to n - 1
    real(wp) :: errors(n_values)
    real(wp), dimension(n_values) :: ends, high, low
    integer :: k
    do while (row > 1 .and. rows%at(row) > from)
      row = row - 1
    end do
    do while (row < rows%n - 1 .and. rows%at(row + 1) <= from)
      row = row + 1
    end do
    low = line(rows, row, from)
    high = low
    do k = row + 1, rows%n - 1
      if (rows%at(k) >= to) exit
      low = min(low, rows%values(:, k))
      high = max(high, rows%values(:, k))
    end do
    ends = line(rows, k - 1, to)
    low = min(low, ends)
    high = max(high, ends)
    errors = max(low - values, values - high, 0.0_wp)
  end function line_errors

  !> Value of the line after a row at a place.
  pure function line(rows, row, at) result(values)
    type(rows_type), intent(in) :: rows   !! the rows
    integer, intent(in) :: row            !! 1 to n - 1
    real(wp), intent(in) :: at            !! place
    real(wp) :: values(n_values)
    real(wp) :: share
    share = (at - rows%at(row))/max(tiny(share), rows%at(row + 1) - rows%at(row))
    share = max(0.0_wp, min(1.0_wp, share))
    values = rows%values(:, row) + share*(rows%values(:, row + 1) - rows%values(:, row))
  end function line

end module adaptive_judge
