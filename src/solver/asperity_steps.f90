!> Steps of a load path: what each of them prescribes, with the rules and defaults of &step.
module asperity_steps
  use asperity_branch, only: default_arc, largest_arc, least_arc
  use asperity_checks, only: bounded
  use asperity_control_point, only: control_type
  use asperity_interface, only: interface_type, start_damage
  use asperity_kinds, only: wp
  use asperity_pattern, only: direction_vector
  use asperity_rie_law, only: new_rie_law, rie_law
  use asperity_text, only: append, integer_text, to_text
  use asperity_tolerances, only: farthest_prescribed, resolved
  implicit none
  private
  public :: complete_steps, check_steps

  !> Largest number of increments of a path, and of targets of a step with all cycles.
  integer, parameter :: most_increments = 10000000, most_targets = 1000000
  !> Bad separations that are named one by one.
  integer, parameter :: most_named = 20

  character(len=4), parameter, public :: component_names(3) = ["N   ", "Tx  ", "Ty  "]

  !> What a step may give.
  type :: entry_type
    character(len=10) :: name        !! of the entry
    logical :: single                !! whether it has one value; else a list with a value for each target
    logical :: whole                 !! whether the values are whole numbers
    real(wp) :: lower, upper         !! range
    real(wp) :: default              !! without this entry; of no meaning for separations and tractions
    character(len=40) :: expected    !! range in messages
  end type entry_type

  real(wp), parameter :: most = huge(1.0_wp)

  !> Entries of a step; `follow` is 0 for 'stable', 1 for 'branch'.
  type(entry_type), parameter, public :: step_table(16) = [ &
    entry_type("s_N", .false., .false., -most, most, 0.0_wp, "a finite separation"), &
    entry_type("s_Tx", .false., .false., -most, most, 0.0_wp, "a finite separation"), &
    entry_type("s_Ty", .false., .false., -most, most, 0.0_wp, "a finite separation"), &
    entry_type("t_N", .false., .false., -most, most, 0.0_wp, "a finite traction"), &
    entry_type("t_Tx", .false., .false., -most, most, 0.0_wp, "a finite traction"), &
    entry_type("t_Ty", .false., .false., -most, most, 0.0_wp, "a finite traction"), &
    entry_type("k_N", .true., .false., 0.0_wp, most, 0.0_wp, ">= 0"), &
    entry_type("k_Tx", .true., .false., 0.0_wp, most, 0.0_wp, ">= 0"), &
    entry_type("k_Ty", .true., .false., 0.0_wp, most, 0.0_wp, ">= 0"), &
    entry_type("slip", .false., .false., -most, most, 0.0_wp, "a finite slip"), &
    entry_type("direction", .true., .false., -most, most, 0.0_wp, "a finite angle"), &
    entry_type("increments", .false., .true., 1.0_wp, real(most_increments, wp), 100.0_wp, &
    "a whole number from 1 to 10000000"), &
    entry_type("cycles", .true., .true., 1.0_wp, real(most_targets, wp), 1.0_wp, "a whole number from 1 to 1000000"), &
    entry_type("time", .false., .false., 0.0_wp, most, 1.0_wp, ">= 0"), &
    entry_type("follow", .true., .true., 0.0_wp, 1.0_wp, 0.0_wp, "'stable' or 'branch'"), &
    entry_type("arc", .true., .false., least_arc, largest_arc, default_arc, "0.00001 to 1 (times s0)")]

  !> Positions in the table; those of the components N, Tx, Ty follow the first.
  integer, parameter :: e_s = 0, e_t = 3, e_k = 6
  integer, parameter, public :: e_slip = 10, e_direction = 11, e_increments = 12, e_cycles = 13, e_time = 14, &
    e_follow = 15, e_arc = 16

  !> Values of an entry.
  type, public :: list_type
    real(wp), allocatable :: values(:)               !! not allocated: not given; size 0: given, not readable
    character(len=:), allocatable :: place           !! for messages, "name = values"; not allocated: made of them
  end type list_type

  !> A step: what is given, and what follows from it and from the steps before.
  type, public :: step_type
    type(list_type) :: given(size(step_table))       !! as the user gives it
    character(len=:), allocatable :: place           !! for messages, with the blank that follows it
    type(control_type) :: control                    !! which value of each component is prescribed
    logical :: changed(3) = .false.                  !! whether the control of a component differs from the step before
    logical :: has_target(3) = .false.               !! false: the prescribed value is constant
    real(wp), allocatable :: targets(:, :)           !! (3, n) separation or traction, with all cycles
    integer, allocatable :: increments(:)            !! (n) increments to each target
    real(wp), allocatable :: durations(:)            !! (n) time to each target
    real(wp), allocatable :: slip(:)                 !! (n) slips along `direction`, if they give s_Tx and s_Ty
    real(wp) :: direction = 0.0_wp                   !! of the slip, degrees
    real(wp) :: arc = 0.0_wp                         !! longest step along the branch over s0, 0: the stable path
  end type step_type

contains

  !> Set what follows from the entries of the steps. A component or a direction that a step does not name is that of the
  !> step before.
  pure subroutine complete_steps(steps, place, message)
    type(step_type), intent(inout) :: steps(:)                !! with their entries -> complete where no error is added
    character(len=*), intent(in) :: place                     !! of the whole path in messages
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    type(control_type) :: control
    real(wp) :: direction, total
    integer :: i
    direction = step_table(e_direction)%default
    total = 0.0_wp
    do i = 1, size(steps)
      call check_entries(steps(i), message)
      call complete_step(steps(i), control, direction, message)
      if (allocated(steps(i)%increments)) total = total + sum(real(steps(i)%increments, wp))
    end do
    if (total > real(most_increments, wp)) call append(message, place // to_text(total) // &
      " increments in all steps: expected at most " // integer_text(most_increments))
  end subroutine complete_steps

  !> Check number and range of the values of each entry; bad ones are removed.
  pure subroutine check_entries(step, message)
    type(step_type), intent(inout) :: step                    !! the step
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    type(entry_type) :: limits
    logical :: good
    integer :: i, j
    do i = 1, size(step_table)
      if (.not. allocated(step%given(i)%values)) cycle
      limits = step_table(i)
      associate (values => step%given(i)%values)
        good = .true.
        do j = 1, size(values)
          good = bounded(values(j), huge(1.0_wp))
          if (good) good = values(j) >= limits%lower .and. values(j) <= limits%upper
          if (good .and. limits%whole) good = .not. abs(values(j) - aint(values(j))) > 0.0_wp
          if (.not. good) exit
        end do
        if (.not. good) then
          call complain(step, i, j, trim(limits%expected), message)
        else if (limits%single .and. size(values) > 1) then
          good = .false.
          call complain(step, i, 0, "one number", message)
        end if
      end associate
      if (.not. good) step%given(i)%values = [real(wp) ::]
    end do
  end subroutine check_entries

  !> Append an error about an entry: its name and value, and what is expected.
  pure subroutine complain(step, i, j, expected, message)
    type(step_type), intent(in) :: step                       !! the step
    integer, intent(in) :: i                                  !! entry
    integer, intent(in) :: j                                  !! its bad value, 0: all
    character(len=*), intent(in) :: expected                  !! in the message
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended
    character(len=:), allocatable :: text
    associate (values => step%given(i)%values)
      if (allocated(step%given(i)%place)) then
        text = step%given(i)%place
      else if (j == 0) then
        text = step%place // trim(step_table(i)%name) // " has " // integer_text(size(values)) // " values"
      else if (size(values) > 1) then
        text = step%place // trim(step_table(i)%name) // "[" // integer_text(j - 1) // "] = " // to_text(values(j))
      else
        text = step%place // trim(step_table(i)%name) // " = " // to_text(values(j))
      end if
    end associate
    call append(message, text // ": expected " // expected)
  end subroutine complain

  !> The only value of an entry, or its default.
  pure function single(step, i) result(value)
    type(step_type), intent(in) :: step   !! the step
    integer, intent(in) :: i              !! entry
    real(wp) :: value
    value = step_table(i)%default
    if (.not. allocated(step%given(i)%values)) return
    if (size(step%given(i)%values) > 0) value = step%given(i)%values(1)
  end function single

  !> The values of an entry, or its default.
  pure subroutine get_list(step, i, values)
    type(step_type), intent(in) :: step                   !! the step
    integer, intent(in) :: i                              !! entry
    real(wp), allocatable, intent(out) :: values(:)       !! size 0: not readable
    if (allocated(step%given(i)%values)) then
      allocate (values, source=step%given(i)%values)
    else
      allocate (values(1))
      values(1) = step_table(i)%default
    end if
  end subroutine get_list

  !> Set control, targets, increments and durations of a step.
  pure subroutine complete_step(step, control, direction, message)
    type(step_type), intent(inout) :: step                    !! with its entries -> complete
    type(control_type), intent(inout) :: control              !! of the step before -> of this one
    real(wp), intent(inout) :: direction                      !! of the slip before -> of this one, degrees
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    type(control_type) :: last
    type(list_type) :: lists(3)
    real(wp) :: e(2)
    character(len=4) :: name
    logical :: has(size(step_table))
    integer :: i

    last = control
    do i = 1, size(step_table)
      has(i) = allocated(step%given(i)%values)
    end do
    if (single(step, e_follow) > 0.0_wp) then
      step%arc = single(step, e_arc)
      if (has(e_increments)) call append(message, step%place // "increments with follow = 'branch': expected arc, " // &
        "the longest step along the branch")
    else if (has(e_arc)) then
      call append(message, step%place // "arc without follow = 'branch'")
    end if
    if (has(e_direction)) direction = single(step, e_direction)
    if (has(e_direction) .and. .not. has(e_slip)) call append(message, step%place // "direction without slip")
    step%direction = direction
    do i = 1, 3
      if (has(e_s + i)) lists(i)%values = step%given(e_s + i)%values
      if (has(e_t + i)) lists(i)%values = step%given(e_t + i)%values
    end do
    if (has(e_slip)) then
      if (any([has(e_s + 2:e_s + 3), has(e_t + 2:e_t + 3)])) call append(message, step%place // &
        "slip sets s_Tx and s_Ty: expected no other values for Tx and Ty")
      e = direction_vector(direction)
      lists(2)%values = step%given(e_slip)%values*e(1)
      lists(3)%values = step%given(e_slip)%values*e(2)
      has(e_s + 2:e_s + 3) = .true.
    end if
    do i = 1, 3
      name = component_names(i)
      if (has(e_s + i) .and. has(e_t + i) .and. .not. (has(e_slip) .and. i > 1)) call append(message, step%place // &
        "s_" // trim(name) // " and t_" // trim(name) // ": expected the one or the other")
      if (has(e_s + i)) control%traction(i) = .false.
      if (has(e_t + i)) control%traction(i) = .true.
      if (has(e_k + i)) control%spring(i) = single(step, e_k + i)
      if (.not. control%traction(i)) control%spring(i) = 0.0_wp
      if (has(e_k + i) .and. .not. control%traction(i)) call append(message, step%place // "k_" // trim(name) // &
        " where the separation is given: expected t_" // trim(name))
    end do
    step%control = control
    step%changed = (control%traction .neqv. last%traction) .or. abs(control%spring - last%spring) > 0.0_wp
    call set_targets(step, lists, message)
  end subroutine complete_step

  !> Set targets, increments and durations of a step from its lists.
  pure subroutine set_targets(step, lists, message)
    type(step_type), intent(inout) :: step                    !! the step, with its control
    type(list_type), intent(in) :: lists(3)                   !! separations or tractions; not allocated: constant
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    real(wp), allocatable :: increments(:), times(:)
    real(wp) :: cycles
    integer :: i, n

    n = 1
    do i = 1, 3
      if (allocated(lists(i)%values)) n = max(n, size(lists(i)%values))
    end do
    cycles = single(step, e_cycles)
    call get_list(step, e_increments, increments)
    call get_list(step, e_time, times)
    if (min(size(increments), size(times)) == 0) return
    if (size(increments) > n) then
      call append(message, step%place // integer_text(size(increments)) // " values of increments: expected 1 to " // &
        integer_text(n) // ", as many as targets")
      return
    end if
    if (size(times) > 1 .and. size(times) /= n) then
      call append(message, step%place // integer_text(size(times)) // " values of time: expected 1, of the step, or " &
        // integer_text(n) // ", as many as targets")
      return
    end if
    if (real(n, wp)*cycles > real(most_targets, wp)) then
      call append(message, step%place // integer_text(n) // " targets in " // to_text(cycles) // &
        " cycles: expected at most " // integer_text(most_targets) // " targets")
      return
    end if
    allocate (step%targets(3, n*nint(cycles)))
    step%targets = 0.0_wp
    do i = 1, 3
      if (.not. allocated(lists(i)%values)) cycle
      step%has_target(i) = size(lists(i)%values) > 0
      if (step%has_target(i)) step%targets(i, :) = run_through(lists(i)%values, n, nint(cycles))
    end do
    if (allocated(step%given(e_slip)%values) .and. step%has_target(2)) step%slip = &
      run_through(step%given(e_slip)%values, n, nint(cycles))
    step%increments = nint(run_through(increments, n, nint(cycles)))
    if (size(times) > 1) then
      step%durations = run_through(times, n, nint(cycles))
    else
      step%durations = times(1)*(real(step%increments, wp)/sum(real(step%increments, wp)))
    end if
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

  !> Check complete steps against an interface: separations that can be resolved, and a branch that can be followed.
  pure subroutine check_steps(joint, steps, place, message)
    type(interface_type), intent(in) :: joint                 !! the interface
    type(step_type), intent(in) :: steps(:)                   !! the load path
    character(len=*), intent(in) :: place                     !! of the whole path in messages
    character(len=:), allocatable, intent(inout) :: message   !! one line per error is appended
    integer, parameter :: separations(4) = [e_s + 1, e_s + 2, e_s + 3, e_slip]
    character(len=:), allocatable :: reason
    character(len=16) :: name
    type(rie_law) :: law
    real(wp) :: bound
    integer :: bad, i, j, n
    if (any(steps%arc > 0.0_wp)) then
      call explain_no_branch(joint, reason)
      if (allocated(reason)) call append(message, place // "follow = 'branch' with " // reason)
    end if
    law = new_rie_law(joint)
    bound = min(farthest_prescribed*law%reach, largest_resolved(law, steps))
    bad = 0
    do n = 1, size(steps)
      do i = 1, size(separations)
        associate (given => steps(n)%given(separations(i)))
          if (.not. allocated(given%values)) cycle
          do j = 1, size(given%values)
            if (bounded(given%values(j), bound)) cycle
            bad = bad + 1
            if (bad > most_named) cycle
            name = step_table(separations(i))%name
            ! the line of a file names all values
            if (size(given%values) > 1 .and. .not. allocated(given%place)) name = trim(name) // "[" // &
              integer_text(j - 1) // "]"
            call append(message, steps(n)%place // trim(name) // " = " // to_text(given%values(j)) // &
              ": expected a magnitude up to " // to_text(bound) // ", beyond which rounding errors are too large")
          end do
        end associate
      end do
    end do
    if (bad > most_named) call append(message, place // "... and " // integer_text(bad - most_named) // &
      " more separations of this kind")
  end subroutine check_steps

  !> Largest separation at which rounding errors do not exceed the prescribed tractions, length. A joint without bond
  !> has no strength; where nothing is prescribed, there is no such limit.
  pure function largest_resolved(law, steps) result(bound)
    type(rie_law), intent(in) :: law          !! the law
    type(step_type), intent(in) :: steps(:)   !! the load path
    real(wp) :: bound
    real(wp) :: traction
    integer :: i, n
    traction = -1.0_wp
    do n = 1, size(steps)
      if (.not. allocated(steps(n)%targets)) cycle
      do i = 1, 3
        if (steps(n)%control%traction(i)) traction = max(traction, maxval(abs(steps(n)%targets(i, :))))
      end do
    end do
    bound = huge(bound)
    if (traction < 0.0_wp) return
    if (start_damage(law%joint, 0.0_wp) < 1.0_wp) traction = traction + law%stress
    if (traction > 0.0_wp) bound = resolved*traction/(epsilon(bound)*law%stiffest)
  end function largest_resolved

  !> Append why an interface has no branch that can be followed; nothing if it has one. The state at a point of the
  !> branch must not depend on time or on the length of the steps, and must be continuous.
  pure subroutine explain_no_branch(joint, message)
    type(interface_type), intent(in) :: joint                 !! the interface
    character(len=:), allocatable, intent(inout) :: message   !! a line is appended
    if (joint%material%tau_v > 0.0_wp) then
      call append(message, "tau_v = " // to_text(joint%material%tau_v) // ": expected 0, as no time passes on a branch")
    else if (joint%material%wears) then
      call append(message, "W0 = " // to_text(1.0_wp/joint%material%inv_w0) // &
        ": expected 0, as wear depends on the increments")
    else if (joint%material%guard) then
      call append(message, "guard = 1: expected 0, as damage that the guard prevents may grow at once later")
    end if
  end subroutine explain_no_branch

end module asperity_steps
