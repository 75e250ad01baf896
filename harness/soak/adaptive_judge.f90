!> True errors of adaptive increments: straight lines between the rows are compared with the same load path in uniform
!> increments, so many that twice as many give the same errors.
module adaptive_judge
  use adaptive_rows, only: add_jump, line_errors, n_values, rows_type, values_of
  use adaptive_run, only: begin_uniform, run_adaptive, run_uniform, take_uniform, uniform_type
  use adaptive_scene, only: scene_type
  use asperity_kinds, only: wp
  implicit none
  private
  public :: judge_scene

  !> Tractions and separations among the values.
  integer, parameter, public :: curves = 6
  !> Error of a curve, relative to the tolerance, that counts as a miss.
  real(wp), parameter, public :: promise = 1.5_wp
  !> Accuracy of the place of a steep change, as a fraction of the leg and of the tolerance: the smallest increment. The
  !> place of a snap or of a loss is accurate to the tolerance; near a fold the error of the place is that of the load.
  real(wp), parameter :: place = 0.01_wp, place_of_jump = 1.0_wp
  !> Uniform increments of a leg, at first and at most, and the change of the errors that is tolerated when the number
  !> is doubled, relative to the tolerance.
  integer, parameter :: coarsest = 500, finest = 64000
  real(wp), parameter :: same = 0.1_wp
  !> Uniform increments that are themselves judged by four times as many, and these in turn.
  integer, parameter :: trial = 4000

  !> Findings.
  type, public :: verdict_type
    real(wp) :: errors(n_values) = 0.0_wp    !! largest errors, relative to the tolerance
    real(wp) :: at(n_values) = 0.0_wp        !! their places: number of legs before + fraction of the leg
    logical :: resolved = .false.            !! whether twice as many uniform increments give the same errors
    logical :: decidable = .true.            !! whether the uniform increments converge at all, if there is a miss
    logical :: loose = .false.               !! whether there are free separations that no traction determines
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
    call run_adaptive(scene, rows, verdict%updates, verdict%coarse)
    verdict%rows = rows%n - 1
    n = coarsest
    call compare(scene, rows, n, jumps, verdict)
    do while (n < finest .and. .not. verdict%resolved)
      before = verdict%errors
      n = 2*n
      call compare(scene, rows, n, jumps, verdict)
      verdict%resolved = all(abs(verdict%errors - before) <= same*max(1.0_wp, verdict%errors))
    end do
    verdict%jumps = jumps%n_jumps
    if (any(verdict%errors(:curves) > promise)) call doubt(scene, verdict%decidable)
  end subroutine judge_scene

  !> Judge uniform increments by four times as many, and these by four times as many again: if both miss the tolerance
  !> and the second error is not even half of the first, uniform increments do not converge, and nothing can be said of
  !> adaptive ones.
  subroutine doubt(scene, decidable)
    type(scene_type), intent(in) :: scene    !! the scene
    logical, intent(out) :: decidable        !! whether they converge
    real(wp) :: errors(2)
    call judge_uniform(scene, trial, errors(1))
    call judge_uniform(scene, 4*trial, errors(2))
    decidable = any(errors <= 1.0_wp) .or. errors(2) < 0.5_wp*errors(1)
  end subroutine doubt

  !> Judge uniform increments by four times as many.
  subroutine judge_uniform(scene, n, error)
    type(scene_type), intent(in) :: scene    !! the scene
    integer, intent(in) :: n                 !! uniform increments of a leg
    real(wp), intent(out) :: error           !! largest error of a curve, relative to the tolerance
    type(rows_type) :: jumps, rows
    type(verdict_type) :: verdict
    call run_uniform(scene, n, scene%tolerance*separation_scale(scene), rows)
    call compare(scene, rows, 4*n, jumps, verdict)
    error = maxval(verdict%errors(:curves))
  end subroutine judge_uniform

  !> Smallest separation that the tolerance refers to: s_f.
  pure function separation_scale(scene) result(length)
    type(scene_type), intent(in) :: scene   !! the scene
    real(wp) :: length
    length = scene%joint%material%s0/(1.0_wp - scene%joint%material%eta)
  end function separation_scale

  !> Take the load path in n uniform increments a leg, and compare the rows with it.
  subroutine compare(scene, rows, n, jumps, verdict)
    type(scene_type), intent(in) :: scene           !! the scene
    type(rows_type), intent(in) :: rows             !! rows of the run to judge
    integer, intent(in) :: n                        !! uniform increments of a leg
    type(rows_type), intent(inout) :: jumps         !! jumps of the run in fewer increments -> of this run
    type(verdict_type), intent(inout) :: verdict    !! its errors are set
    type(rows_type) :: earlier
    type(uniform_type) :: run
    real(wp) :: errors(n_values), length, scale(n_values), window
    logical :: loose, near_jump
    integer :: next, row

    length = 0.0_wp
    verdict%errors = 0.0_wp
    row = 1
    next = 2
    associate (m => scene%joint%material)
      scale(1:3) = m%k_n/sqrt(m%inv_s01_2)
      scale(4:6) = separation_scale(scene)
      scale(7:9) = scale(1)*scale(4)
    end associate
    earlier = jumps
    jumps%n_jumps = 0
    jumps%jumps = -1.0_wp
    call begin_uniform(scene, n, run)
    do while (.not. run%ended)
      call take_uniform(scene, scene%tolerance*scale(4), run)
      if (run%jumped) call add_jump(run%at, jumps)
      if (run%lost .or. run%at > rows%at(rows%n)) exit
      associate (at => run%at, point => run%point, free => run%control%traction)
        length = length + sqrt(sum((point%s - run%old%s)**2))
        scale(1:3) = max(scale(1:3), sqrt(sum(point%traction**2)))
        scale(4:6) = max(scale(4:6), maxval(abs(point%s), mask=free))
        scale(7:9) = max(scale(7:9), scale(1)*length)
        near_jump = any(abs([rows%jumps, earlier%jumps] - at) <= 2.0_wp*place_of_jump*scene%tolerance)
        window = merge(place_of_jump, place, near_jump)*scene%tolerance
        ! the window does not reach beyond the leg
        call line_errors(rows, max(real(ceiling(at) - 1, wp), at - window), min(real(ceiling(at), wp), at + window), &
          values_of(point), row, errors, loose)
        errors = errors/(scale*scene%tolerance)
        loose = (loose .or. run%loose) .and. any(free)
        verdict%loose = verdict%loose .or. loose
        errors(4:6) = merge(errors(4:6), 0.0_wp, free .and. .not. loose)
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
      end associate
    end do

  contains

    !> Errors of the energies of a row within the last uniform increment.
    function row_errors(place_of_row, energies) result(error)
      real(wp), intent(in) :: place_of_row      !! place of the row
      real(wp), intent(in) :: energies(3)       !! rupture, friction, work there
      real(wp) :: error(3)
      real(wp) :: first(n_values), second(n_values)
      first = values_of(run%old)
      second = values_of(run%point)
      error = abs(energies - second(7:9) + (run%at - place_of_row)*real(n, wp)*(second(7:9) - first(7:9)))
    end function row_errors

  end subroutine compare

end module adaptive_judge
