!> Cost of the update, compared with a textbook version of the law and with the limits of the hardware:
!> bench [--csv FILE] [--quick], or bench --profile PATTERN KERNEL yes|no for one kernel with or without
!> tangent.
program bench
  use, intrinsic :: iso_fortran_env, only: compiler_version, error_unit, real64
  use array_work, only: array_work_type, most_threads, new_array_work
  use asperity_contract, only: p_guard, p_turn, p_w0, prop_table
  use asperity_instruction_set, only: instruction_set
  use block_work_double, only: double_type => block_work_type, double_large_type => large_work_type, &
    new_double => new_block_work, new_double_large => new_large_work
  use block_work_single, only: single_type => block_work_type, single_large_type => large_work_type, &
    new_single => new_block_work, new_single_large => new_large_work
  use measure, only: median, row_type, take_turns, work_type
  use point_work, only: new_point_work, new_test_work, point_work_type
  use start_states, only: slip, state_names
  implicit none
  !> A pattern: name, inclined planes, weight of the flat plane, height and W0, whether it is measured with many points.
  type :: pattern_type
    character(len=8) :: name
    real(real64) :: m, flat, height, w0
    logical :: large
  end type pattern_type
  real(real64), parameter :: third = 1.0_real64/3.0_real64, none = 0.0_real64, high = 0.3_real64
  type(pattern_type), parameter :: patterns(15) = [ &
    pattern_type("2 planes", 2.0_real64, none, none, none, .false.), &
    pattern_type("RT", 2.0_real64, third, none, none, .true.), &
    pattern_type("RP-3", 3.0_real64, third, none, none, .true.), &
    pattern_type("RP-4", 4.0_real64, third, none, none, .true.), &
    pattern_type("RP-6", 6.0_real64, third, none, none, .true.), &
    pattern_type("RP-8", 8.0_real64, third, none, none, .false.), &
    pattern_type("RP-16", 16.0_real64, third, none, none, .false.), &
    pattern_type("RP-32", 32.0_real64, third, none, none, .true.), &
    pattern_type("RP-63", 63.0_real64, third, none, none, .false.), &
    pattern_type("RP-4 HW0", 4.0_real64, third, high, 1.0_real64, .false.), &
    pattern_type("RT H", 2.0_real64, third, high, none, .false.), &
    pattern_type("RP-4 H", 4.0_real64, third, high, none, .false.), &
    pattern_type("RP-8 H", 8.0_real64, third, high, none, .false.), &
    pattern_type("RP-16 H", 16.0_real64, third, high, none, .false.), &
    pattern_type("RP-32 H", 32.0_real64, third, high, none, .false.)]
  !> Material of Table 2 of the paper.
  real(real64), parameter :: table_2(5) = [3.0_real64, 0.3_real64, 0.9_real64, 0.5_real64, 30.0_real64]
  !> Points with data in the first-level cache, points with mixed states, and points of a VUMAT call.
  integer, parameter :: n_small = 128, n_states = 640, width = 128
  type(row_type), allocatable :: rows(:)
  type(row_type) :: profiled
  real(real64), allocatable :: times(:, :)
  character(len=:), allocatable :: file
  real(real64) :: shortest, used
  integer :: arrays(2), calls, i, pass, passes, turns, unit
  logical :: quick

  used = 0.0_real64
  call read_arguments(file, quick, profiled)
  passes = merge(1, 5, quick)
  turns = merge(3, 5, quick)
  shortest = merge(2.0e4_real64, 1.0e5_real64, quick)
  ! calls with data in memory; points of arrays in the second-level cache and in memory
  calls = merge(8, 1600, quick)
  arrays = [2048, merge(20000, 1000000, quick)]
  if (profiled%kernel /= "") then
    call profile(profiled)
    stop
  end if
  if (len(file) > 0) open (newunit=unit, file=file, status="replace", action="write")
  print "(2a, i0)", compiler_version(), ", asperity_isa() = ", instruction_set()
  print "(2a)", "Table 2. Times are medians of runs taken in turn. ", &
    "Kernel test: time of an increment of confined slip, with iterations."
  allocate (times(passes, 0))
  do pass = 1, passes
    call measure_all(rows)
    if (pass == 1) times = spread(rows%ns, 1, passes)
    times(pass, :) = rows%ns
  end do
  do i = 1, size(rows)
    rows(i)%ns = median(times(:, i))
  end do
  call print_table(rows)
  if (len(file) > 0) call write_csv(unit, rows)
  if (.not. abs(used) <= huge(used)) error stop "bench: results are not finite"   ! uses all results

contains

  !> Measure all patterns and all choices of start states once.
  subroutine measure_all(rows)
    type(row_type), allocatable, intent(out) :: rows(:)   !! with the medians of this pass
    character(len=6), parameter :: precisions(2) = ["double", "single"]
    type(row_type), allocatable :: points(:), blocks(:)
    type(pattern_type) :: p
    integer :: i, j, k
    logical :: straight

    allocate (rows(0))
    do i = 1, size(patterns)
      p = patterns(i)
      straight = .not. p%height > 0.0_real64
      points = [row_type(kernel="point", tangent=.true.), row_type(kernel="umat", tangent=.true.)]
      if (straight) points = [row_type(kernel="textbook", tangent=.true.), row_type(kernel="textbook"), points]
      call add(rows, p, points)
      if (straight) call add(rows, p, [row_type(kernel="test", tangent=.true.)])
      do k = 1, size(precisions)
        blocks = [row_type(kernel="block", tangent=.true.), row_type(kernel="block"), row_type(kernel="roots")]
        blocks%precision = precisions(k)
        call add(rows, p, blocks(:merge(3, 2, straight)))
        if (.not. p%large) cycle
        blocks = [row_type(kernel="vumat"), row_type(kernel="stream")]
        blocks%precision = precisions(k)
        call add(rows, p, blocks)
      end do
    end do
    p = patterns(4)
    do i = 1, size(arrays)
      points = [(row_type(kernel="points", points=arrays(i), threads=j), row_type(kernel="points", tangent=.true., &
        points=arrays(i), threads=j), row_type(kernel="copy", points=arrays(i), threads=j), &
        j=1, min(2, most_threads()))]
      call add(rows, p, points)
    end do
    do k = 1, size(state_names)
      blocks = [row_type(kernel="block"), row_type(kernel="block", tangent=.true.)]
      blocks%states = merge("all slip ", state_names(k), k == slip)   ! other points than those of the pattern
      call add(rows, p, blocks, kind=k)
    end do
  end subroutine measure_all

  !> Measure rows that share their points, and append them.
  subroutine add(rows, pattern, some, kind)
    type(row_type), allocatable, intent(inout) :: rows(:)   !! all rows so far
    type(pattern_type), intent(in) :: pattern               !! their pattern
    type(row_type), intent(in) :: some(:)                   !! what to measure
    integer, intent(in), optional :: kind                   !! of the states of many points; absent: few, all slip
    class(work_type), allocatable :: work
    type(row_type) :: timed(size(some))
    timed = some
    timed%pattern = pattern%name
    call new_work(pattern, timed(1), work, kind)
    call take_turns(work, timed, turns, shortest, used)
    rows = [rows, timed]
  end subroutine add

  !> Points for the kernel of a row.
  subroutine new_work(pattern, row, work, kind)
    type(pattern_type), intent(in) :: pattern              !! their pattern
    type(row_type), intent(in) :: row                      !! kernel, precision, points of an array
    class(work_type), allocatable, intent(out) :: work     !! the points
    integer, intent(in), optional :: kind                  !! of the states of many points; absent: few, all slip
    type(array_work_type), allocatable :: array
    type(double_type), allocatable :: double
    type(double_large_type), allocatable :: double_large
    type(point_work_type), allocatable :: point
    type(single_type), allocatable :: single
    type(single_large_type), allocatable :: single_large
    ! a UMAT of straight planes gets PROPS up to turn
    real(real64) :: props(p_w0)
    integer :: given, n, states

    props = [table_2, pattern%m, pattern%flat, prop_table(p_turn:p_guard)%default, pattern%height, pattern%w0]
    given = merge(p_w0, p_turn, pattern%height > 0.0_real64)
    n = n_small
    states = slip
    if (present(kind)) then
      n = n_states
      states = kind
    end if
    select case (trim(row%kernel) // " " // row%precision)
    case ("block double", "roots double")
      allocate (double)
      call new_double(props(:given), states, n, double)
      call move_alloc(double, work)
    case ("block single", "roots single")
      allocate (single)
      call new_single(props(:given), states, n, single)
      call move_alloc(single, work)
    case ("vumat double", "stream double")
      allocate (double_large)
      call new_double_large(props(:given), width, calls, double_large)
      call move_alloc(double_large, work)
    case ("vumat single", "stream single")
      allocate (single_large)
      call new_single_large(props(:given), width, calls, single_large)
      call move_alloc(single_large, work)
    case ("points double", "copy double")
      allocate (array)
      call new_array_work(props(:given), row%points, array)
      call move_alloc(array, work)
    case default
      allocate (point)
      if (row%kernel == "test") call new_test_work(props(:given), point)
      if (row%kernel /= "test") call new_point_work(props(:given), slip, n, point)
      call move_alloc(point, work)
    end select
  end subroutine new_work

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
        profiled%tangent = text == "yes"
        k = k + 3
        if (any(patterns%name == profiled%pattern) .and. (text == "yes" .or. text == "no")) cycle
        write (error_unit, "(99a)") "bench: --profile: expected yes or no after PATTERN and KERNEL, and one of", &
          (" """ // trim(patterns(i)%name) // """", i=1, size(patterns))
        stop 1
      else
        write (error_unit, "(3a)") "bench: ", trim(text), &
          ": expected --csv FILE, --quick or --profile PATTERN KERNEL yes|no"
        stop 1
      end if
    end do
  end subroutine read_arguments

  !> Run one kernel often enough for a profiler that counts instructions.
  subroutine profile(row)
    type(row_type), intent(inout) :: row   !! pattern, kernel, tangent
    integer, parameter :: runs = 1000
    class(work_type), allocatable :: work
    integer :: i
    calls = 1
    row%points = n_small
    call new_work(patterns(findloc(patterns%name, row%pattern, 1)), row, work)
    do i = 1, runs
      call work%run(row, used)
    end do
    print "(i0, a)", runs*work%points, " points"
  end subroutine profile

  !> Print the table: with each time that of the textbook version over it, and it over that of what it consists of.
  subroutine print_table(rows)
    type(row_type), intent(in) :: rows(:)   !! what to print
    real(real64) :: parts
    integer :: i
    print "(2a)", "pattern  planes kernel     precision tangent states      points threads  ns/point  ns/plane", &
      "  textbook/ns  ns/parts"
    do i = 1, size(rows)
      associate (row => rows(i))
        parts = 0.0_real64
        if (row%kernel == "umat") parts = time_of("point", row)
        if (row%kernel == "block") parts = time_of("roots", row)
        if (row%kernel == "vumat") parts = time_of("block", row) + time_of("stream", row)
        if (row%kernel == "points" .and. row%threads == 1) parts = time_of("block", row) + time_of("copy", row)
        print "(a8, i7, 1x, a10, 1x, a9, 1x, a7, 1x, a9, i9, i8, f10.2, f10.3, a13, a10)", row%pattern, row%planes, &
          row%kernel, row%precision, merge("yes", "no ", row%tangent), row%states, row%points, row%threads, row%ns, &
          row%ns/real(row%planes, real64), ratio(time_of("textbook", row), row%ns), ratio(row%ns, parts)
      end associate
    end do
  end subroutine print_table

  !> Time of another kernel with the pattern, precision and tangent of a row, 0: none. Limits have no tangent, copies
  !> have the points of the row, and the textbook version is in double precision.
  function time_of(kernel, row) result(ns)
    character(len=*), intent(in) :: kernel   !! which one
    type(row_type), intent(in) :: row        !! what it is compared with
    real(real64) :: ns
    integer :: j
    logical :: limit
    ns = 0.0_real64
    limit = any(kernel == ["copy  ", "roots ", "stream"])
    do j = size(rows), 1, -1
      if (rows(j)%pattern /= row%pattern .or. rows(j)%kernel /= kernel .or. rows(j)%threads /= 1) cycle
      if (rows(j)%precision /= row%precision .and. kernel /= "textbook") cycle
      if (kernel == "copy" .and. rows(j)%points /= row%points) cycle
      if (limit .or. (rows(j)%tangent .eqv. row%tangent)) ns = rows(j)%ns
    end do
  end function time_of

  !> a/b as a text, empty where one of them is missing.
  pure function ratio(a, b) result(text)
    real(real64), intent(in) :: a, b   !! ns, 0: none
    character(len=10) :: text
    text = ""
    if (a > 0.0_real64 .and. b > 0.0_real64) write (text, "(f10.3)") a/b
  end function ratio

  !> Write the table as CSV.
  subroutine write_csv(unit, rows)
    integer, intent(in) :: unit             !! open for writing
    type(row_type), intent(in) :: rows(:)   !! all rows
    integer :: i
    write (unit, "(a)") "pattern,planes,kernel,precision,tangent,states,points,threads,ns_per_point,isa"
    do i = 1, size(rows)
      associate (row => rows(i))
        write (unit, "(a, ',', i0, 4(',', a), 2(',', i0), ',', f0.4, ',', i0)") trim(row%pattern), row%planes, &
          trim(row%kernel), trim(row%precision), trim(merge("yes", "no ", row%tangent)), trim(row%states), row%points, &
          row%threads, row%ns, instruction_set()
      end associate
    end do
    close (unit)
  end subroutine write_csv

end program bench
