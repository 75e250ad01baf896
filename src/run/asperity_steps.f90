!> Steps of a load path: what each of them prescribes, with the rules and defaults of &step.
module asperity_steps
  use asperity_checks, only: bounded
  use asperity_equations, only: control_type
  use asperity_errors, only: error_type, errors_type, fail
  use asperity_kinds, only: wp
  use asperity_pattern, only: direction_vector
  use asperity_point_law, only: point_law
  use asperity_text, only: integer_text, set_text, to_text
  use asperity_tolerances, only: default_arc, farthest_prescribed, largest_arc, least_arc, resolved
  implicit none
  private
  public :: complete_steps, check_steps, explicit_entries

  !> Largest number of increments of a path, and of targets of a step with all cycles.
  integer, parameter, public :: most_increments = 10000000
  integer, parameter :: most_targets = 1000000

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
  type(entry_type), parameter, public :: step_table(18) = [ &
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
    entry_type("arc", .true., .false., least_arc, largest_arc, default_arc, "0.00001 to 1 (times s0)"), &
    entry_type("p", .false., .false., 0.0_wp, most, 0.0_wp, "a finite pressure >= 0"), &
    entry_type("fork", .true., .true., -1.0_wp, 1.0_wp, 0.0_wp, "-1, 0 or 1")]

  !> Positions in the table; those of the components N, Tx, Ty follow the first.
  integer, parameter, public :: e_s = 0, e_t = 3, e_k = 6
  integer, parameter, public :: e_slip = 10, e_direction = 11, e_increments = 12, e_cycles = 13, e_time = 14, &
    e_follow = 15, e_arc = 16, e_p = 17, e_fork = 18

  !> Values of an entry.
  type, public :: list_type
    real(wp), allocatable :: values(:)               !! not allocated: not given; size 0: not readable
    type(error_type) :: place                        !! of an error in it; without a name: that of the step
  end type list_type

  !> A step: what is given, and what follows from it and from the steps before.
  type, public :: step_type
    type(list_type) :: given(size(step_table))       !! as the user gives it
    type(error_type) :: place                        !! of an error in it
    type(control_type) :: control                    !! which value of each component is prescribed
    logical :: changed(3) = .false.                  !! whether the control of a component differs from the step before
    logical :: has_target(3) = .false.               !! false: the prescribed value is constant
    real(wp), allocatable :: targets(:, :)           !! (3, n) separation or total traction, with all cycles
    real(wp), allocatable :: water(:)                !! (n) water pressures; not allocated: that of the step before
    integer, allocatable :: increments(:)            !! (n) increments to each target
    real(wp), allocatable :: durations(:)            !! (n) time to each target
    real(wp), allocatable :: slip(:)                 !! (n) slips along `direction`, if they give s_Tx and s_Ty
    real(wp) :: direction = 0.0_wp                   !! of the slip, degrees
    real(wp) :: arc = 0.0_wp                         !! longest step along the branch over s0, 0: the stable path
    integer :: fork = 0                              !! side to which the branch is left at its first fork, 0: not
  end type step_type

contains

  !> Set what follows from the entries of the steps. A component or a direction that a step does not name is that of the
  !> step before. Where an entry is bad, the steps remain incomplete.
  pure subroutine complete_steps(steps, errors, place)
    type(step_type), intent(inout) :: steps(:)                !! with their entries -> complete where no error is added
    type(errors_type), intent(inout) :: errors                !! errors are added
    type(error_type), intent(in) :: place                     !! of an error in the whole path
    type(control_type) :: control
    real(wp) :: direction, total
    integer :: i
    logical :: good
    good = .true.
    do i = 1, size(steps)
      call check_entries(steps(i), good, errors)
    end do
    if (.not. good) return
    direction = step_table(e_direction)%default
    total = 0.0_wp
    do i = 1, size(steps)
      call complete_step(steps(i), control, direction, errors)
      if (allocated(steps(i)%increments)) total = total + sum(real(steps(i)%increments, wp))
    end do
    if (total > real(most_increments, wp)) call fail(errors, place, to_text(total) // &
      " increments in all steps: expected at most " // integer_text(most_increments))
  end subroutine complete_steps

  !> Check number and range of the values of each entry.
  pure subroutine check_entries(step, good, errors)
    type(step_type), intent(in) :: step                       !! the step
    logical, intent(inout) :: good                            !! false if an entry is bad
    type(errors_type), intent(inout) :: errors                !! errors are added
    type(entry_type) :: limits
    integer :: bad, i
    logical :: miscounted
    do i = 1, size(step_table)
      if (.not. allocated(step%given(i)%values)) cycle
      limits = step_table(i)
      associate (values => step%given(i)%values)
        bad = first_bad(values, limits)
        miscounted = size(values) == 0 .or. (limits%single .and. size(values) > 1)
        if (bad > 0) then
          call entry_error(step, i, bad, trim(limits%expected), errors)
        else if (miscounted .and. .not. (size(values) == 0 .and. allocated(step%given(i)%place%name))) then
          call entry_error(step, i, 0, trim(merge("one number ", "one or more", limits%single)), errors)
        end if
        good = good .and. bad == 0 .and. .not. miscounted
      end associate
    end do
  end subroutine check_entries

  !> Position of the first value that is not within limits, 0 if there is none.
  pure function first_bad(values, limits) result(j)
    real(wp), intent(in) :: values(:)        !! any bits
    type(entry_type), intent(in) :: limits   !! range, and whether the values are whole numbers
    integer :: j
    logical :: good
    do j = 1, size(values)
      good = bounded(values(j), huge(1.0_wp))
      if (good) good = values(j) >= limits%lower .and. values(j) <= limits%upper
      if (good .and. limits%whole) good = .not. abs(values(j) - aint(values(j))) > 0.0_wp
      if (.not. good) return
    end do
    j = 0
  end function first_bad

  !> Append an error about an entry: its name and value, and what is expected.
  pure subroutine entry_error(step, i, j, expected, errors)
    type(step_type), intent(in) :: step                       !! the step
    integer, intent(in) :: i                                  !! entry
    integer, intent(in) :: j                                  !! its bad value, 0: all
    character(len=*), intent(in) :: expected                  !! in the message
    type(errors_type), intent(inout) :: errors                !! errors are added
    type(error_type) :: place
    associate (given => step%given(i))
      place = given%place
      ! where no file shows the values, the bad one is known by its position
      if (.not. allocated(place%name) .or. (j > 0 .and. .not. allocated(place%file) .and. i /= e_follow)) then
        place = step%place
        place%name = trim(step_table(i)%name)
        if (j == 0) then
          place%value = integer_text(size(given%values)) // " values"
        else
          if (size(given%values) > 1) place%at = j - 1
          place%value = to_text(given%values(j))
        end if
      end if
    end associate
    call fail(errors, place, "expected " // expected)
  end subroutine entry_error

  !> Set control, targets, increments and durations of a step whose entries are good.
  pure subroutine complete_step(step, control, direction, errors)
    type(step_type), intent(inout) :: step                    !! with its entries -> complete
    type(control_type), intent(inout) :: control              !! of the step before -> of this one
    real(wp), intent(inout) :: direction                      !! of the slip before -> of this one, degrees
    type(errors_type), intent(inout) :: errors                !! errors are added
    type(control_type) :: last
    type(list_type) :: given(size(step_table))
    real(wp) :: factors(3)
    character(len=:), allocatable :: name
    integer :: cycles, entries(3), i, n
    logical :: has(size(step_table))

    last = control
    given = step%given
    do i = 1, size(given)
      has(i) = allocated(given(i)%values)
      if (.not. has(i)) given(i)%values = [step_table(i)%default]
    end do
    if (given(e_follow)%values(1) > 0.0_wp) then
      step%arc = given(e_arc)%values(1)
      step%fork = nint(given(e_fork)%values(1))
      if (has(e_increments)) call fail(errors, step%place, "increments with follow = 'branch': expected arc, " // &
        "the longest step along the branch")
    else if (has(e_arc)) then
      call fail(errors, step%place, "arc without follow = 'branch'")
    else if (has(e_fork)) then
      call fail(errors, step%place, "fork without follow = 'branch'")
    end if
    if (has(e_direction)) direction = given(e_direction)%values(1)
    if (has(e_direction) .and. .not. has(e_slip)) call fail(errors, step%place, "direction without slip")
    step%direction = direction
    ! the entry that gives a component, 0 if there is none
    entries = merge([e_s + 1, e_s + 2, e_s + 3], 0, has(e_s + 1:e_s + 3))
    entries = merge([e_t + 1, e_t + 2, e_t + 3], entries, has(e_t + 1:e_t + 3))
    factors = 1.0_wp
    if (has(e_slip)) then
      if (any(entries(2:) > 0)) call fail(errors, step%place, &
        "slip sets s_Tx and s_Ty: expected no other values for Tx and Ty")
      entries(2:) = e_slip
      factors(2:) = direction_vector(direction)
    end if
    do i = 1, 3
      name = trim(component_names(i))
      if (has(e_s + i) .and. has(e_t + i) .and. entries(i) /= e_slip) call fail(errors, step%place, &
        "s_" // name // " and t_" // name // ": expected the one or the other")
      if (entries(i) > 0) control%traction(i) = entries(i) == e_t + i
      if (has(e_k + i)) control%spring(i) = given(e_k + i)%values(1)
      if (.not. control%traction(i)) control%spring(i) = 0.0_wp
      if (has(e_k + i) .and. .not. control%traction(i)) call fail(errors, step%place, "k_" // name // &
        " where the separation is given: expected t_" // name)
    end do
    step%control = control
    step%changed = (control%traction .neqv. last%traction) .or. abs(control%spring - last%spring) > 0.0_wp
    step%has_target = entries > 0
    ! targets, increments and durations from the lists
    n = 1
    do i = 1, 3
      if (entries(i) > 0) n = max(n, size(given(entries(i))%values))
    end do
    if (has(e_p)) n = max(n, size(given(e_p)%values))
    cycles = nint(given(e_cycles)%values(1))
    associate (increments => given(e_increments)%values, times => given(e_time)%values)
      if (size(increments) > n) then
        call fail(errors, step%place, integer_text(size(increments)) // " values of increments: expected 1 to " &
          // integer_text(n) // ", as many as targets")
      else if (size(times) > 1 .and. size(times) /= n) then
        call fail(errors, step%place, integer_text(size(times)) // " values of time: expected 1, of the step, " &
          // "or " // integer_text(n) // ", as many as targets")
      else if (real(n, wp)*real(cycles, wp) > real(most_targets, wp)) then
        call fail(errors, step%place, integer_text(n) // " targets in " // integer_text(cycles) // &
          " cycles: expected at most " // integer_text(most_targets) // " targets")
      else
        allocate (step%targets(3, n*cycles), source=0.0_wp)
        do i = 1, 3
          if (entries(i) > 0) step%targets(i, :) = factors(i)*run_through(given(entries(i))%values, n, cycles)
        end do
        if (entries(2) == e_slip) step%slip = run_through(given(e_slip)%values, n, cycles)
        if (has(e_p)) step%water = run_through(given(e_p)%values, n, cycles)
        step%increments = nint(run_through(increments, n, cycles))
        step%durations = run_through(times, n, cycles)
        if (size(times) == 1) step%durations = times(1)*(real(step%increments, wp)/sum(real(step%increments, wp)))
      end if
    end associate
  end subroutine complete_step

  !> Repeat a list of up to n values several times; a shorter list repeats its last value.
  pure function run_through(list, n, cycles) result(values)
    real(wp), intent(in) :: list(:)   !! 1 to n values
    integer, intent(in) :: n          !! values of a cycle
    integer, intent(in) :: cycles     !! number of repetitions
    real(wp) :: values(n*cycles)
    integer :: j
    values = [(list(min(modulo(j - 1, n) + 1, size(list))), j=1, n*cycles)]
  end function run_through

  !> Entries that give the same step whatever its defaults are: lists with all cycles, increments and time of each
  !> target, and the stiffness of the surroundings wherever the traction is prescribed.
  pure subroutine explicit_entries(step, given)
    type(step_type), intent(in) :: step                       !! complete
    type(list_type), intent(out) :: given(size(step_table))   !! no result: gfortran would leak it
    integer :: i
    do i = 1, 3
      if (step%control%traction(i)) given(e_k + i)%values = step%control%spring(i:i)
      if (.not. step%has_target(i) .or. (i > 1 .and. allocated(step%slip))) cycle
      given(merge(e_t, e_s, step%control%traction(i)) + i)%values = step%targets(i, :)
    end do
    if (allocated(step%slip)) then
      given(e_slip)%values = step%slip
      given(e_direction)%values = [step%direction]
    end if
    if (allocated(step%water)) given(e_p)%values = step%water
    if (step%arc > 0.0_wp) then
      given(e_follow)%values = [1.0_wp]
      given(e_arc)%values = [step%arc]
      if (step%fork /= 0) given(e_fork)%values = [real(step%fork, wp)]
    else
      given(e_increments)%values = real(step%increments, wp)
    end if
    given(e_time)%values = step%durations
    if (any(step%has_target) .or. allocated(step%water) .or. size(step%increments) == 1) return
    ! a step that holds all values has no list that repeats
    given(e_cycles)%values = [real(size(step%increments), wp)]
    given(e_time)%values = [step_table(e_time)%default]
    if (allocated(step%given(e_time)%values)) given(e_time)%values = step%given(e_time)%values
    if (.not. step%arc > 0.0_wp) given(e_increments)%values = real(step%increments(:1), wp)
  end subroutine explicit_entries

  !> Check complete steps against a law: separations that can be resolved, and a branch that can be followed.
  pure subroutine check_steps(law, steps, errors, place)
    class(point_law), intent(in) :: law                       !! the law
    type(step_type), intent(in) :: steps(:)                   !! the load path
    type(errors_type), intent(inout) :: errors                !! errors are added
    type(error_type), intent(in) :: place                     !! of an error in the whole path
    integer, parameter :: separations(4) = [e_s + 1, e_s + 2, e_s + 3, e_slip]
    type(entry_type) :: limits
    character(len=:), allocatable :: lines
    real(wp) :: largest
    integer :: bad, i, n
    if (any(steps%arc > 0.0_wp)) then
      call set_text(lines, "")
      call law%explain_branch("follow = 'branch' with ", lines)
      call fail(errors, place, lines)
    end if
    limits%upper = farthest_prescribed*law%s_f
    ! beside prescribed tractions rounding errors do not exceed a part of them; a joint without bond has no strength
    largest = -1.0_wp
    do n = 1, size(steps)
      largest = max(largest, maxval(abs(steps(n)%targets), mask=spread(steps(n)%control%traction, 2, &
        size(steps(n)%increments))))
      if (allocated(steps(n)%water)) largest = max(largest, maxval(steps(n)%water))
    end do
    if (law%bonded .and. largest >= 0.0_wp) largest = largest + law%stress
    if (largest > 0.0_wp) limits%upper = min(limits%upper, resolved*largest/(epsilon(largest)*law%largest_stiffness))
    limits%lower = -limits%upper
    limits%whole = .false.
    do n = 1, size(steps)
      do i = 1, size(separations)
        if (.not. allocated(steps(n)%given(separations(i))%values)) cycle
        bad = first_bad(steps(n)%given(separations(i))%values, limits)
        if (bad > 0) call entry_error(steps(n), separations(i), bad, "a magnitude up to " // to_text(limits%upper) // &
          ", beyond which rounding errors are too large", errors)
      end do
    end do
  end subroutine check_steps

end module asperity_steps
