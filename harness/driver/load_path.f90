!> Load path of a case: its groups &step in their order.
module load_path
  use asperity_adaptive, only: largest_tolerance, least_tolerance
  use asperity_arc, only: default_arc, largest_arc, least_arc
  use asperity_checks, only: bounded
  use asperity_control_point, only: prescribed_bound
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_text, only: append, integer_text, to_text
  use asperity_control_point, only: control_type
  use asperity_pattern, only: direction_vector
  use case_text, only: entry_where, group_where, name_index, text_type, unknown_name
  use case_values, only: get_integer, get_integers, get_real, get_reals, get_string
  use text_file, only: lower, most_lines
  implicit none
  private
  public :: read_steps, check_separations

  !> Largest number of increments of a run.
  integer, parameter :: most_increments = 10000000
  !> Largest number of targets of a step, with all cycles.
  integer, parameter :: most_targets = 1000000

  character(len=4), parameter, public :: component_names(3) = ["N   ", "Tx  ", "Ty  "]

  !> A step: its targets in their order, and which value of each component is prescribed (`control`).
  type, public :: step_type
    type(control_type) :: control
    logical :: changed(3) = .false.             !! whether the control of the component differs from the last step
    logical :: has_target(3) = .false.          !! false: the prescribed value is constant
    real(wp), allocatable :: targets(:, :)      !! (3, n) separation or traction
    integer :: n_given(3) = 0                   !! number of values in the list of the component
    integer, allocatable :: increments(:)       !! (n) number of increments to each target
    real(wp), allocatable :: slip(:)            !! (n) slips along `direction`, if s_Tx and s_Ty are given as slip
    real(wp) :: direction = 0.0_wp              !! of the slip, degrees
    real(wp) :: time = 1.0_wp                   !! duration of the step
    real(wp) :: tolerance = 0.0_wp              !! tolerance of adaptive increments, 0: fixed increments
    real(wp) :: arc = 0.0_wp                    !! longest step along the branch over s0, 0: the stable path is followed
  end type step_type

  !> List of values of a component or of the slip.
  type :: list_type
    real(wp), allocatable :: values(:)
  end type list_type

contains

  !> Read all groups &step.
  subroutine read_steps(text, steps, message)
    type(text_type), intent(in) :: text                       !! the file
    type(step_type), allocatable, intent(out) :: steps(:)     !! the load path
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    type(control_type) :: control
    real(wp) :: direction, total
    integer :: g, n

    total = 0.0_wp
    allocate (steps(count(text%groups(:text%n_groups)%name == "step")))
    direction = 0.0_wp
    n = 0
    do g = 1, text%n_groups
      if (text%groups(g)%name /= "step") cycle
      n = n + 1
      call read_step(text, g, control, direction, steps(n), message)
      if (allocated(steps(n)%increments)) total = total + sum(real(steps(n)%increments, wp))
    end do
    if (total > real(most_increments, wp)) call append(message, text%path // ": " // to_text(total) // &
      " increments in all &step: expected at most " // integer_text(most_increments))
  end subroutine read_steps

  !> Read one group &step.
  subroutine read_step(text, g, control, direction, step, message)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: g                                  !! group
    type(control_type), intent(inout) :: control              !! of the last step -> of this one
    real(wp), intent(inout) :: direction                      !! of slip, degrees
    type(step_type), intent(out) :: step                      !! the step
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    character(len=*), parameter :: known = &
      "s_N, s_Tx, s_Ty, t_N, t_Tx, t_Ty, k_N, k_Tx, k_Ty, slip, direction, increments, tolerance, cycles, time, " // &
      "follow, arc"
    character(len=:), allocatable :: followed
    type(list_type) :: s(3), t(3), slip
    type(control_type) :: last
    integer, allocatable :: increments(:)
    real(wp) :: e_slip(2)
    real(wp) :: arc
    logical :: spring(3), aims, counts, sets_arc
    integer :: cycles, e, i

    last = control
    spring = .false.
    aims = .false.
    counts = .false.
    sets_arc = .false.
    arc = default_arc
    followed = "stable"
    cycles = 1
    increments = [100]
    do e = text%groups(g)%first, text%groups(g)%last
      associate (name => text%entries(e)%name)
        i = 0
        if (len_trim(name) > 2 .and. scan(name(1:1), "stk") == 1 .and. name(2:2) == "_") i = name_index(name(3:), &
          component_names)
        if (i > 0) then
          select case (name(1:1))
          case ("s")
            call get_reals(text, e, s(i)%values, message)
          case ("t")
            call get_reals(text, e, t(i)%values, message)
          case default
            spring(i) = .true.
            call get_real(text, e, control%spring(i), message)
            if (control%spring(i) < 0.0_wp) call append(message, entry_where(text, e) // ": expected >= 0")
          end select
          cycle
        end if
        select case (name)
        case ("slip")
          call get_reals(text, e, slip%values, message)
        case ("direction")
          aims = .true.
          call get_real(text, e, direction, message)
        case ("increments")
          counts = .true.
          call get_integers(text, e, 1, most_increments, increments, message)
        case ("tolerance")
          ! an admissible value remains if the given one is no number
          step%tolerance = least_tolerance
          call get_real(text, e, step%tolerance, message)
          if (step%tolerance < least_tolerance .or. step%tolerance > largest_tolerance) call append(message, &
            entry_where(text, e) // ": expected " // to_text(least_tolerance) // " to " // to_text(largest_tolerance))
        case ("cycles")
          call get_integer(text, e, 1, most_targets, cycles, message)
        case ("time")
          call get_real(text, e, step%time, message)
          if (step%time < 0.0_wp) call append(message, entry_where(text, e) // ": expected >= 0")
        case ("follow")
          call get_string(text, e, followed, message)
          if (lower(followed) /= "stable" .and. lower(followed) /= "branch") call append(message, &
            entry_where(text, e) // ": expected 'stable' or 'branch'")
        case ("arc")
          sets_arc = .true.
          call get_real(text, e, arc, message)
          if (arc < least_arc .or. arc > largest_arc) call append(message, entry_where(text, e) // ": expected " // &
            to_text(least_arc) // " to " // to_text(largest_arc) // " (times s0)")
        case default
          call unknown_name(text, e, known, message)
        end select
      end associate
    end do

    if (lower(followed) == "branch") then
      step%arc = arc
      if (counts) call append(message, group_where(text, g) // "increments with follow = 'branch': expected arc, " // &
        "the longest step along the branch")
      if (step%tolerance > 0.0_wp) call append(message, group_where(text, g) // &
        "tolerance with follow = 'branch': expected arc, the longest step along the branch")
    else if (sets_arc) then
      call append(message, group_where(text, g) // "arc without follow = 'branch'")
    end if
    if (aims .and. .not. allocated(slip%values)) call append(message, group_where(text, g) // "direction without slip")
    if (allocated(slip%values)) then
      if (any([allocated(s(2)%values), allocated(s(3)%values), allocated(t(2)%values), allocated(t(3)%values)])) then
        call append(message, group_where(text, g) // "slip sets s_Tx and s_Ty: expected no other values for Tx and Ty")
      end if
      e_slip = direction_vector(direction)
      step%direction = direction
      s(2)%values = slip%values*e_slip(1)
      s(3)%values = slip%values*e_slip(2)
    end if
    do i = 1, 3
      if (allocated(s(i)%values) .and. allocated(t(i)%values)) call append(message, group_where(text, g) // "s_" // &
        trim(component_names(i)) // " and t_" // trim(component_names(i)) // ": expected the one or the other")
      if (allocated(s(i)%values)) control%traction(i) = .false.
      if (allocated(t(i)%values)) control%traction(i) = .true.
      if (.not. control%traction(i)) control%spring(i) = 0.0_wp
      if (spring(i) .and. .not. control%traction(i)) call append(message, group_where(text, g) // "k_" // &
        trim(component_names(i)) // " where the separation is given: expected t_" // trim(component_names(i)))
    end do
    step%control = control
    step%changed = (control%traction .neqv. last%traction) .or. abs(control%spring - last%spring) > 0.0_wp
    call set_targets(text, g, s, t, increments, cycles, step, message)
    if (step%has_target(2) .and. allocated(slip%values)) step%slip = run_through(slip%values, &
      size(step%increments)/cycles, cycles)
  end subroutine read_step

  !> Targets and increments of a step from its lists.
  subroutine set_targets(text, g, s, t, increments, cycles, step, message)
    type(text_type), intent(in) :: text                       !! the file
    integer, intent(in) :: g                                  !! group
    type(list_type), intent(in) :: s(3), t(3)                 !! separations and tractions; not allocated: no entry
    integer, intent(in) :: increments(:)                      !! for the first targets; the last number is repeated
    integer, intent(in) :: cycles                             !! number of times that the lists are followed
    type(step_type), intent(inout) :: step                    !! the step, with its control
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    integer :: i, n

    n = 1
    do i = 1, 3
      if (allocated(s(i)%values)) n = max(n, size(s(i)%values))
      if (allocated(t(i)%values)) n = max(n, size(t(i)%values))
    end do
    if (size(increments) < 1) return
    if (size(increments) > n) then
      call append(message, group_where(text, g) // integer_text(size(increments)) // &
        " values of increments: expected 1 to " // integer_text(n) // ", as many as targets")
      return
    end if
    if (real(n, wp)*real(cycles, wp) > real(most_targets, wp)) then
      call append(message, group_where(text, g) // integer_text(n) // " targets in " // integer_text(cycles) // &
        " cycles: expected at most " // integer_text(most_targets) // " targets")
      return
    end if
    allocate (step%targets(3, n*cycles))
    step%targets = 0.0_wp
    do i = 1, 3
      if (allocated(s(i)%values)) then
        step%n_given(i) = size(s(i)%values)
        if (step%n_given(i) > 0) step%targets(i, :) = run_through(s(i)%values, n, cycles)
      else if (allocated(t(i)%values)) then
        step%n_given(i) = size(t(i)%values)
        if (step%n_given(i) > 0) step%targets(i, :) = run_through(t(i)%values, n, cycles)
      end if
      step%has_target(i) = step%n_given(i) > 0
    end do
    step%increments = nint(run_through(real(increments, wp), n, cycles))
  end subroutine set_targets

  !> Repeat a list of up to n values several times; a shorter list repeats its last value.
  pure function run_through(list, n, cycles) result(values)
    real(wp), intent(in) :: list(:)   !! 1 to n values
    integer, intent(in) :: n          !! values of a cycle
    integer, intent(in) :: cycles     !! number of repetitions
    real(wp) :: values(n*cycles)
    integer :: j
    do j = 1, n*cycles
      values(j) = list(min(modulo(j - 1, n) + 1, size(list)))
    end do
  end function run_through

  !> Check that the prescribed separations can be resolved; every list is checked once.
  pure subroutine check_separations(text, steps, joint, message)
    type(text_type), intent(in) :: text                       !! the file
    type(step_type), intent(in) :: steps(:)                   !! the load path
    type(interface_type), intent(in) :: joint                 !! the interface
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    real(wp) :: bound
    integer :: bad, i, j, g, n
    bound = prescribed_bound(joint)
    bad = 0
    n = 0
    do g = 1, text%n_groups
      if (text%groups(g)%name /= "step") cycle
      n = n + 1
      if (.not. allocated(steps(n)%targets)) cycle
      do i = 1, 3
        if (steps(n)%control%traction(i)) cycle
        do j = 1, steps(n)%n_given(i)
          if (bounded(steps(n)%targets(i, j), bound)) cycle
          bad = bad + 1
          if (bad <= most_lines) call append(message, group_where(text, g) // "s_" // trim(component_names(i)) // &
            " = " // &
            to_text(steps(n)%targets(i, j)) // ": expected a magnitude up to " // to_text(bound) // " (1e12 s_f)")
        end do
      end do
    end do
    if (bad > most_lines) call append(message, text%path // ": ... and " // integer_text(bad - most_lines) // &
      " more separations of this kind")
  end subroutine check_separations

end module load_path
