!> Step control of adaptive increments: tolerance and scales, error of a step, and extrapolation of its results.
module asperity_walk
  use asperity_contract, only: plane_statev, v_damage, v_friction, v_rupture
  use asperity_control_point, only: control_type, point_type
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_mixed_control, only: advance, plain_newton
  use asperity_rates, only: line_error, rate_type
  implicit none
  private
  public :: new_walk, distance, state_difference, end_error, lines_error, extrapolate, correct_state, keep_scales

  !> Range of the tolerance. A smaller one is below the errors of rounding and of the solver; a larger one has no
  !> effect.
  real(wp), parameter, public :: least_tolerance = 1.0e-8_wp, largest_tolerance = 0.1_wp

  !> Largest step, as a fraction of the load path to a target. An event that lasts for less than a step may be missed.
  real(wp), parameter, public :: largest_size = 0.125_wp
  !> Error of the lines over the two halves, as a fraction of the distance from the middle to the line over the whole
  !> step: 1/4 on a parabola (0.3 is taken), up to 2 at a kink.
  real(wp), parameter :: smooth_share = 0.3_wp, kink_share = 2.0_wp
  !> Safety factor on the difference at the end of a step, because path errors of the slips accumulate over steps.
  real(wp), parameter :: path_share = 6.0_wp
  !> Largest number of planes for which steps end at switches. With more planes the search costs more than the rows it
  !> saves (docs/solver.md).
  integer, parameter :: most_planes = 8

  !> Step control of a load path: tolerance, scales and step size.
  type, public :: walk_type
    real(wp) :: tolerance = 1.0e-3_wp  !! relative, least_tolerance to largest_tolerance
    real(wp) :: traction               !! scale: strength, or largest traction so far, stress
    real(wp) :: separation             !! scale: s_f, or largest separation of a free component so far, length
    real(wp) :: size = largest_size    !! next step, fraction of the load path to the target
    logical :: lands = .true.          !! whether rejected steps end at switches
    logical, allocatable :: does(:, :) !! regime of the planes at the start of the next step
    real(wp), allocatable :: slid(:, :) !! slip of the planes in the increment before it, length
    type(rate_type) :: rate            !! at the start of the next step
    logical :: coarse = .false.        !! whether the last step is the smallest one and its error exceeds the tolerance
    real(wp) :: tried = 0.0_wp         !! end of the last step tried, fraction of the load path
    integer :: solves = 0              !! increments solved, rejected ones included
    integer :: updates = 0             !! of the law in them
    integer :: rejected = 0            !! steps rejected
  end type walk_type

contains

  !> Step control of a virgin point with zero traction.
  pure function new_walk(joint) result(walk)
    type(interface_type), intent(in) :: joint       !! the interface
    type(walk_type) :: walk
    associate (material => joint%material)
      walk%traction = material%k_n/sqrt(material%inv_s01_2)
      walk%separation = material%s0/(1.0_wp - material%eta)
    end associate
    walk%lands = joint%pattern%n <= most_planes
  end function new_walk

  !> Distance of two results, relative to the tolerance.
  pure function distance(control, walk, traction, s, other) result(d)
    type(control_type), intent(in) :: control       !! what is given
    type(walk_type), intent(in) :: walk             !! tolerance and scales
    real(wp), intent(in) :: traction(3), s(3)       !! one result
    type(point_type), intent(in) :: other           !! the other result
    real(wp) :: d
    d = maxval(abs(traction - other%traction))/max(walk%traction, size_of(other%traction))
    d = max(d, maxval(merge(abs(s - other%s), 0.0_wp, control%traction))/max(walk%separation, maxval(abs(other%s), &
      mask=control%traction)))
    d = d/walk%tolerance
  end function distance

  !> Largest difference of the states of the planes between two results: of the damage, and of the traction that the
  !> slip of a fully damaged plane gives, relative to the scale of the tractions. The tractions need not show it: before
  !> a plane is damaged its slip has no effect, and before it slips its damage has none.
  pure function state_difference(joint, walk, first, second) result(difference)
    type(interface_type), intent(in) :: joint       !! the interface
    type(walk_type), intent(in) :: walk             !! scales
    type(point_type), intent(in) :: first, second   !! the results
    real(wp) :: difference
    real(wp) :: slip
    integer :: i, k
    difference = 0.0_wp
    do k = 1, joint%pattern%n
      i = plane_statev(k)
      slip = maxval(abs(first%state(i + 1:i + 2) - second%state(i + 1:i + 2)))
      difference = max(difference, abs(first%state(i) - second%state(i)), &
        joint%pattern%gamma(k)*joint%material%k_t*slip/walk%traction)
    end do
  end function state_difference

  !> Increase the scales to the values of a point.
  pure subroutine keep_scales(control, point, walk)
    type(control_type), intent(in) :: control       !! what is given
    type(point_type), intent(in) :: point           !! the point
    type(walk_type), intent(inout) :: walk          !! scales
    walk%traction = max(walk%traction, size_of(point%traction))
    walk%separation = max(walk%separation, maxval(abs(point%s), mask=control%traction))
  end subroutine keep_scales

  !> Length of a vector.
  pure function size_of(v) result(length)
    real(wp), intent(in) :: v(3)   !! any
    real(wp) :: length
    length = sqrt(sum(v**2))
  end function size_of

  !> Weight of the difference at the end of a step whose results are not extrapolated. With viscous damage errors
  !> accumulate over the relaxation time, else only over a few steps of friction.
  pure function path_weight(joint, control, size) result(weight)
    type(interface_type), intent(in) :: joint       !! the interface
    type(control_type), intent(in) :: control       !! dt is the duration of the whole load path
    real(wp), intent(in) :: size                    !! step, fraction of the load path
    real(wp) :: weight
    weight = path_share
    associate (tau_v => joint%material%tau_v)
      if (tau_v > 0.0_wp .and. control%dt > 0.0_wp) weight = max(weight, min(1.0_wp, tau_v/control%dt)/size)
    end associate
  end function path_weight

  !> Error of the results at the end of a step, relative to the tolerance.
  pure function end_error(joint, control, walk, size, old, whole, middle, ending, single, switched) result(error)
    type(interface_type), intent(in) :: joint                   !! the interface
    type(control_type), intent(in) :: control                   !! what is given
    type(walk_type), intent(in) :: walk                         !! tolerance and scales
    real(wp), intent(in) :: size                                !! of the step, fraction of the load path
    type(point_type), intent(in) :: old, whole, middle, ending  !! start, end in one increment, middle and end in two
    logical, intent(in) :: single                               !! whether no increment needed sub-increments
    logical, intent(in) :: switched                             !! whether a plane switches within the step
    real(wp) :: error
    real(wp) :: energy, length, separation, state, stress, traction, weight
    weight = path_share
    if (switched .or. .not. single) weight = path_weight(joint, control, size)
    stress = max(walk%traction, size_of(ending%traction))
    length = max(walk%separation, maxval(abs(ending%s), mask=control%traction))
    traction = weight*size_of(whole%traction - ending%traction)/stress
    separation = weight*maxval(merge(abs(whole%s - ending%s), 0.0_wp, control%traction))/length
    state = state_difference(joint, walk, whole, ending)
    energy = maxval(abs(spent(whole) - spent(ending)))/max(tiny(1.0_wp), stress*(size_of(middle%s - old%s) + &
      size_of(ending%s - middle%s)))
    if (single) energy = energy/3.0_wp
    if (single .and. .not. switched) then
      ! the errors after extrapolation are two orders smaller
      energy = energy**2
      state = state**2
    end if
    error = max(traction, separation, energy, state)/walk%tolerance
  end function end_error

  !> Error of the straight lines over the halves of a step, relative to the tolerance: by the rates at its start, middle
  !> and end, or, where these are not known, by the distance from the middle to the line over both halves.
  pure function lines_error(control, walk, size, old, middle, ending, switches, rates) result(error)
    type(control_type), intent(in) :: control            !! what is given
    type(walk_type), intent(in) :: walk                  !! tolerance and scales
    real(wp), intent(in) :: size                         !! of the step, fraction of the load path
    type(point_type), intent(in) :: old, middle, ending  !! its start, middle and end
    logical, intent(in) :: switches(2)                   !! whether planes switch within its halves
    type(rate_type), intent(in) :: rates(3)              !! at start, middle and end
    real(wp) :: error
    real(wp) :: half, s(3), share, traction(3)
    half = 0.5_wp*size
    if (all(rates%known)) then
      traction = max( &
        line_error(middle%traction - old%traction, half*rates(1)%traction, half*rates(2)%traction, switches(1)), &
        line_error(ending%traction - middle%traction, half*rates(2)%traction, half*rates(3)%traction, switches(2)))
      s = max(line_error(middle%s - old%s, half*rates(1)%s, half*rates(2)%s, switches(1)), &
              line_error(ending%s - middle%s, half*rates(2)%s, half*rates(3)%s, switches(2)))
    else
      share = merge(kink_share, smooth_share, any(switches))
      traction = share*(middle%traction - 0.5_wp*(old%traction + ending%traction))
      s = share*abs(middle%s - 0.5_wp*(old%s + ending%s))
    end if
    error = size_of(traction)/max(walk%traction, size_of(ending%traction))
    error = max(error, maxval(merge(s, 0.0_wp, control%traction))/max(walk%separation, maxval(abs(ending%s), &
      mask=control%traction)))
    error = error/walk%tolerance
  end function lines_error

  !> Remove the leading error from the energies of the two halves (Richardson extrapolation). That of the whole
  !> increment is four times as large if it is the error of the trapezoidal rule, and twice as large if viscous damage
  !> grows. The friction energy must not decrease.
  pure subroutine extrapolate(viscous, old, whole, middle, ending)
    logical, intent(in) :: viscous                        !! whether viscous damage may have grown
    type(point_type), intent(in) :: old, whole            !! start, end in one increment
    type(point_type), intent(inout) :: middle, ending     !! middle and end in two increments
    integer, parameter :: energies(2) = [v_rupture, v_friction]
    real(wp) :: correction(3)
    correction = spent(ending) - spent(whole)
    if (.not. (viscous .and. ending%state(v_damage) > old%state(v_damage))) correction = correction/3.0_wp
    middle%state(energies) = middle%state(energies) + 0.5_wp*correction(:2)
    middle%work = middle%work + 0.5_wp*correction(3)
    ending%state(energies) = ending%state(energies) + correction(:2)
    ending%work = ending%work + correction(3)
    middle%state(v_friction) = max(middle%state(v_friction), old%state(v_friction))
    ending%state(v_friction) = max(ending%state(v_friction), middle%state(v_friction))
  end subroutine extrapolate

  !> Remove the leading error of slips and viscous damage, which are of first order in the increment, from a point, and
  !> find the equilibrium with the corrected state. If there is none, the point does not change.
  pure subroutine correct_state(joint, control, given, old, whole, ending, share, point)
    type(interface_type), intent(in) :: joint              !! the interface
    type(control_type), intent(in) :: control              !! what is given
    real(wp), intent(in) :: given(3)                       !! given values at the point
    type(point_type), intent(in) :: old, whole, ending     !! start, end in one increment and in two
    real(wp), intent(in) :: share                          !! of the error at the end that the point has
    type(point_type), intent(inout) :: point               !! the point
    type(control_type) :: still
    type(point_type) :: trial
    real(wp) :: reached
    integer :: i, k, used
    trial = point
    do k = 1, joint%pattern%n
      i = plane_statev(k)
      trial%state(i:i + 2) = point%state(i:i + 2) + share*(ending%state(i:i + 2) - whole%state(i:i + 2))
      trial%state(i) = max(old%state(i), min(1.0_wp, trial%state(i)))
    end do
    still = control
    still%dt = 0.0_wp
    call advance(joint, still, given, given, trial, used, reached, method=plain_newton)
    if (.not. reached < 1.0_wp) point = trial
  end subroutine correct_state

  !> Energies that are sums by the trapezoidal rule: rupture, friction, work, stress*length.
  pure function spent(point) result(energies)
    type(point_type), intent(in) :: point   !! the point
    real(wp) :: energies(3)
    energies = [point%state(v_rupture), point%state(v_friction), point%work]
  end function spent

end module asperity_walk
