!> Cost of the update, compared with a textbook version of the law and with the limits of the hardware:
!> bench [--csv FILE] [--quick], or bench --profile PATTERN KERNEL yes|no for one kernel with or without
!> tangent.
program bench
  use, intrinsic :: iso_fortran_env, only: error_unit, real64
  use aims, only: print_aims
  use build_facts, only: build
  use many_points, only: most_threads
  use asperity_instruction_set, only: instruction_set
  use asperity_contract, only: p_guard, p_turn, prop_table
  use start_states, only: state_names, slip
  use table, only: add_limits, print_table, write_csv
  use tasks, only: new_array_workspace, new_large_workspace, new_workspace, row_type, run_often, take_turns, &
    workspace_type
  use timing, only: median
  implicit none
  !> A pattern: name, number of inclined planes, weight of the flat plane, whether it is measured with many points, too.
  type :: pattern_type
    character(len=8) :: name
    real(real64) :: m, flat
    logical :: large
  end type pattern_type
  real(real64), parameter :: third = 1.0_real64/3.0_real64
  type(pattern_type), parameter :: patterns(9) = [ &
    pattern_type("2 planes", 2.0_real64, 0.0_real64, .false.), pattern_type("RT", 2.0_real64, third, .true.), &
    pattern_type("RP-3", 3.0_real64, third, .true.), pattern_type("RP-4", 4.0_real64, third, .true.), &
    pattern_type("RP-6", 6.0_real64, third, .true.), pattern_type("RP-8", 8.0_real64, third, .false.), &
    pattern_type("RP-16", 16.0_real64, third, .false.), pattern_type("RP-32", 32.0_real64, third, .true.), &
    pattern_type("RP-63", 63.0_real64, third, .false.)]
  !> Patterns with facets of a finite height; the first has wear, too.
  character(len=8), parameter :: facet_names(6) = [character(len=8) :: "RP-4 HW0", "RT H", "RP-4 H", "RP-8 H", &
    "RP-16 H", "RP-32 H"]
  real(real64), parameter :: facet_m(6) = [4.0_real64, 2.0_real64, 4.0_real64, 8.0_real64, 16.0_real64, 32.0_real64]
  real(real64), parameter :: height = 0.3_real64, w0(6) = [1.0_real64, 0.0_real64, 0.0_real64, 0.0_real64, 0.0_real64, &
    0.0_real64]
  !> Material of Table 2 of the paper.
  real(real64), parameter :: table_2(5) = [3.0_real64, 0.3_real64, 0.9_real64, 0.5_real64, 30.0_real64]
  !> Points with data in the first-level cache, points with mixed states, points of a VUMAT call, and number of calls
  !> with data in memory.
  integer, parameter :: n_small = 128, n_states = 640, width = 128, n_calls = 1600
  !> Points of arrays in the second-level cache, and in memory (fewer with --quick).
  integer, parameter :: n_cache = 2048, n_memory = 1000000, n_memory_quick = 20000
  character(len=6), parameter :: precisions(2) = ["double", "single"]
  type(row_type), allocatable :: rows(:)
  type(row_type) :: profiled
  real(real64), allocatable :: times(:, :)
  character(len=:), allocatable :: file
  real(real64) :: shortest, used
  integer :: array_points(2), calls, i, pass, passes, turns, unit
  logical :: quick

  used = 0.0_real64
  call read_arguments(file, quick, profiled)
  if (profiled%kernel /= "") then
    call profile(profiled)
    stop
  end if
  passes = merge(1, 5, quick)
  turns = merge(3, 5, quick)
  shortest = merge(2.0e4_real64, 1.0e5_real64, quick)
  calls = merge(8, n_calls, quick)
  array_points = [n_cache, merge(n_memory_quick, n_memory, quick)]
  if (len(file) > 0) open (newunit=unit, file=file, status="replace", action="write")
  print "(2a, i0)", build, "asperity_isa() = ", instruction_set()
  print "(2a)", "Table 2. Times are medians of runs taken in turn. ", &
    "Kernel test: time of an increment of confined slip, with iterations."
  allocate (times(0, 0))
  do pass = 1, passes
    call measure_all(rows)
    if (pass == 1) then
      deallocate (times)
      allocate (times(passes, size(rows)))
    end if
    times(pass, :) = rows%ns
  end do
  do i = 1, size(rows)
    rows(i)%ns = median(times(:, i))
  end do
  call add_limits(rows)
  call print_table(rows)
  call print_aims(rows, array_points(1), array_points(2))
  if (len(file) > 0) then
    call write_csv(unit, rows)
    close (unit)
  end if
  if (.not. abs(used) <= huge(used)) error stop "bench: results are not finite"   ! uses all results

contains

  !> Measure all patterns and all choices of start states once.
  subroutine measure_all(rows)
    type(row_type), allocatable, intent(out) :: rows(:)   !! with the medians of this pass
    type(workspace_type) :: work
    type(row_type), allocatable :: some(:)
    real(real64) :: props(8)
    integer :: i, j

    allocate (rows(0), some(0))
    do i = 1, size(patterns)
      props = [table_2, patterns(i)%m, patterns(i)%flat, 0.0_real64]
      call new_workspace(props, slip, n_small, work)
      some = small_rows()
      call take_turns(work, some, turns, shortest, used)
      if (patterns(i)%large) then
        do j = 1, size(precisions)
          call new_large_workspace(props, precisions(j), width, calls, work)
          some = [some, row_type(kernel="vumat", precision=precisions(j)), &
                  row_type(kernel="stream", precision=precisions(j))]
          call take_turns(work, some(size(some) - 1:), turns, 0.0_real64, used)
        end do
      end if
      some%pattern = patterns(i)%name
      rows = [rows, some]
    end do
    do i = 1, size(facet_names)
      call new_workspace(facet_props(i), slip, n_small, work)
      some = small_rows()
      some = pack(some, some%kernel == "point" .or. some%kernel == "umat" .or. some%kernel == "block")
      call take_turns(work, some, turns, shortest, used)
      some%pattern = facet_names(i)
      rows = [rows, some]
    end do
    props = [table_2, 4.0_real64, third, 0.0_real64]
    do i = 1, size(array_points)
      call new_array_workspace(props, array_points(i), work)
      some = [(row_type(kernel="points", threads=j), row_type(kernel="copy", threads=j), j=1, min(2, most_threads()))]
      call take_turns(work, some, turns, shortest, used)
      some%pattern = "RP-4"
      rows = [rows, some]
    end do
    do i = 1, size(state_names)
      call new_workspace(props, i, n_states, work)
      some = [row_type(kernel="block"), row_type(kernel="block", tangent=.true.)]
      call take_turns(work, some, turns, shortest, used)
      some%pattern = "RP-4"
      some%states = merge("all slip ", state_names(i), i == slip)   ! other points than those of the pattern
      rows = [rows, some]
    end do
  end subroutine measure_all

  !> PROPS of a pattern with facets.
  pure function facet_props(i) result(props)
    integer, intent(in) :: i   !! number of its name in facet_names
    real(real64) :: props(size(table_2) + 2 + (p_guard - p_turn + 1) + 2)
    props = [table_2, facet_m(i), third, prop_table(p_turn:p_guard)%default, height, w0(i)]
  end function facet_props

  !> Rows to measure with data in the cache.
  pure function small_rows() result(list)
    type(row_type), allocatable :: list(:)
    integer :: k
    list = [row_type(kernel="numerical", tangent=.true.), row_type(kernel="textbook", tangent=.true.), &
            row_type(kernel="point", tangent=.true.), row_type(kernel="umat", tangent=.true.), &
            row_type(kernel="test", tangent=.true.), row_type(kernel="textbook")]
    do k = 1, size(precisions)
      list = [list, row_type(kernel="block", precision=precisions(k), tangent=.true.), &
              row_type(kernel="block", precision=precisions(k)), row_type(kernel="roots", precision=precisions(k))]
    end do
  end function small_rows

  !> Read the arguments; the program stops with a message if one is unknown.
  subroutine read_arguments(file, quick, profiled)
    character(len=:), allocatable, intent(out) :: file   !! name of the CSV, empty: none
    logical, intent(out) :: quick                        !! few repetitions and points, to test the program
    type(row_type), intent(out) :: profiled              !! the kernel of --profile; no kernel: all
    character(len=4096) :: text
    integer :: k
    file = ""
    quick = .false.
    k = 0
    do while (k < command_argument_count())
      k = k + 1
      call get_command_argument(k, text)
      if (text == "--quick") then
        quick = .true.
      else if (text == "--csv" .and. k < command_argument_count()) then
        k = k + 1
        call get_command_argument(k, text)
        file = trim(text)
      else if (text == "--profile" .and. k + 3 <= command_argument_count()) then
        call get_command_argument(k + 1, profiled%pattern)
        call get_command_argument(k + 2, profiled%kernel)
        call get_command_argument(k + 3, text)
        if (text /= "yes" .and. text /= "no") then
          write (error_unit, "(3a)") "bench: ", trim(text), ": expected yes or no after PATTERN and KERNEL"
          stop 1
        end if
        profiled%tangent = text == "yes"
        k = k + 3
      else
        write (error_unit, "(3a)") "bench: ", trim(text), &
          ": expected --csv FILE, --quick or --profile PATTERN KERNEL yes|no"
        stop 1
      end if
    end do
  end subroutine read_arguments

  !> Run one kernel often enough for a profiler that counts instructions.
  subroutine profile(row)
    type(row_type), intent(in) :: row   !! pattern, kernel, tangent
    integer, parameter :: runs = 1000
    type(workspace_type) :: work
    real(real64), allocatable :: props(:)
    integer :: i
    if (all([patterns%name, facet_names] /= row%pattern)) then
      write (error_unit, "(99a)") "bench: --profile ", trim(row%pattern), ": expected one of", &
        (" """ // trim(patterns(i)%name) // """", i=1, size(patterns)), &
        (" """ // trim(facet_names(i)) // """", i=1, size(facet_names))
      stop 1
    end if
    do i = 1, size(patterns)
      if (patterns(i)%name == row%pattern) props = [table_2, patterns(i)%m, patterns(i)%flat, 0.0_real64]
    end do
    do i = 1, size(facet_names)
      if (facet_names(i) == row%pattern) props = facet_props(i)
    end do
    if (row%kernel == "vumat" .or. row%kernel == "stream") then
      call new_large_workspace(props, row%precision, n_small, 1, work)
    else
      call new_workspace(props, slip, n_small, work)
    end if
    call run_often(work, row, runs, used)
    print "(i0, a)", runs*n_small, " points"
  end subroutine profile

end program bench
