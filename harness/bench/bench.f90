!> Cost of the update, compared with a textbook version of the law and with the limits of the hardware:
!> bench [--csv FILE] [--quick]
program bench
  use, intrinsic :: iso_fortran_env, only: compiler_version, error_unit, int64, output_unit, real64
  use asperity_contract, only: p_c, p_damage0, p_guard, p_turn, p_w0, p_water, prop_table
  use asperity_instruction_set, only: instruction_set
  use block_work_double, only: double_type => block_work_type, new_double => new_block_work, run_double => run
  use block_work_single, only: single_type => block_work_type, new_single => new_block_work, run_single => run
  use point_work, only: new_point_work, point_work_type, run_points => run
  use start_states, only: new_start, start_type
  implicit none
  !> A row of the table: what was measured, and its time.
  type :: row_type
    character(len=8) :: kernel            !! textbook, point, umat, block, roots, vumat, stream, points, copy
    logical :: tangent                    !! whether the kernel computes the tangent
    character(len=6) :: precision = "double"
    character(len=8) :: pattern = ""      !! name of the pattern
    integer :: planes = 0                 !! number of planes
    integer :: points = 0                 !! number of points
    real(real64) :: ns = 0.0_real64       !! nanoseconds per point
  end type row_type
  !> A pattern: name, inclined planes, whether it is measured with many points, height, W0 and dashpot. All have a flat
  !> plane with the weight 1/3 except for "2 planes".
  type :: pattern_type
    character(len=8) :: name
    real(real64) :: m
    logical :: large = .false.
    real(real64) :: height = 0.0_real64, w0 = 0.0_real64, c = 0.0_real64
  end type pattern_type
  !> A height, and a dashpot whose stress is that of the spring for the same change in an increment of the time 1.
  real(real64), parameter :: high = 0.3_real64, damping = 150.0_real64
  type(pattern_type), parameter :: patterns(17) = [ &
    pattern_type("2 planes", 2.0_real64), pattern_type("RT", 2.0_real64, .true.), &
    pattern_type("RP-3", 3.0_real64, .true.), pattern_type("RP-4", 4.0_real64, .true.), &
    pattern_type("RP-6", 6.0_real64, .true.), pattern_type("RP-8", 8.0_real64), &
    pattern_type("RP-16", 16.0_real64), pattern_type("RP-32", 32.0_real64, .true.), &
    pattern_type("RP-63", 63.0_real64), pattern_type("RP-4 HW0", 4.0_real64, height=high, w0=1.0_real64), &
    pattern_type("RT H", 2.0_real64, height=high), pattern_type("RP-4 H", 4.0_real64, height=high), &
    pattern_type("RP-8 H", 8.0_real64, height=high), pattern_type("RP-16 H", 16.0_real64, height=high), &
    pattern_type("RP-32 H", 32.0_real64, height=high), pattern_type("RP-4 c", 4.0_real64, c=damping), &
    pattern_type("RP-32 c", 32.0_real64, c=damping)]

  !> What is measured with a pattern. Rows of one group run in turn on the same points; arrays and calls
  !> have many points.
  integer, parameter :: points = 1, arrays = 2, blocks = 3, calls = 4
  logical, parameter :: yes = .true., no = .false.
  type(row_type), parameter :: tasks(12) = [row_type("textbook", yes), row_type("textbook", no), &
    row_type("point", yes), row_type("umat", yes), row_type("points", no), row_type("points", yes), &
    row_type("copy", no), row_type("block", yes), row_type("block", no), row_type("roots", no), &
    row_type("vumat", no), row_type("stream", no)]
  integer, parameter :: groups(12) = [points, points, points, points, arrays, arrays, arrays, blocks, blocks, blocks, &
    calls, calls]
  !> Kernels that know neither facets nor dashpots.
  character(len=8), parameter :: straight(2) = [character(len=8) :: "textbook", "roots"]

  !> Points with data in the first-level cache, and of a VUMAT call.
  integer, parameter :: n_small = 128
  type(row_type), allocatable :: rows(:)
  character(len=:), allocatable :: file
  real(real64) :: shortest, used
  integer :: i, n, pass, passes, sizes(calls), turns, unit
  logical :: quick

  used = 0.0_real64
  call read_arguments(file, quick)
  passes = merge(1, 5, quick)
  turns = merge(3, 5, quick)
  shortest = merge(2.0e4_real64, 1.0e5_real64, quick)
  ! arrays in the second-level cache, VUMAT calls in memory
  sizes = [n_small, 2048, n_small, n_small*merge(8, 1600, quick)]
  if (len(file) > 0) open (newunit=unit, file=file, status="replace", action="write")
  print "(2a, i0)", compiler_version(), ", asperity_isa() = ", instruction_set()
  print "(a)", "Table 2 of the paper. Times are medians of runs taken in turn."
  allocate (rows(0))
  do pass = 1, passes
    call measure_all(rows)
  end do
  n = size(rows)/passes
  do i = 1, n
    rows(i)%ns = median(rows(i::n)%ns)
  end do
  call write_rows(rows(:n), output_unit)
  if (len(file) > 0) call write_rows(rows(:n), unit)
  deallocate (rows, file)
  if (.not. abs(used) <= huge(used)) error stop "bench: results are not finite"   ! uses all results

contains

  !> Measure all patterns and arrays once.
  subroutine measure_all(rows)
    type(row_type), allocatable, intent(inout) :: rows(:)   !! those of the passes so far
    character(len=6), parameter :: precisions(2) = ["double", "single"]
    type(row_type), allocatable :: some(:)
    integer :: group, i, j, k

    do i = 1, size(patterns)
      do k = 1, size(precisions)
        do group = points, calls
          ! points have no single precision
          if (group < blocks .and. k > 1) cycle
          if (any(group == [arrays, calls]) .and. .not. patterns(i)%large) cycle
          some = pack(tasks, groups == group .and. [(.not. ((patterns(i)%height > 0.0_real64 .or. &
            patterns(i)%c > 0.0_real64) .and. any(straight == tasks(j)%kernel)), j=1, size(tasks))])
          some%precision = precisions(k)
          if (size(some) > 0) call add(rows, patterns(i), some, sizes(group))
        end do
      end do
    end do
    ! arrays in memory
    call add(rows, patterns(4), pack(tasks, groups == arrays), merge(20000, 1000000, quick))
  end subroutine measure_all

  !> Measure rows that share their points, and append them with their median times. The rows run alternately, and each
  !> run repeats its kernel until it lasts `shortest`.
  subroutine add(rows, pattern, some, n)
    type(row_type), allocatable, intent(inout) :: rows(:)   !! all rows so far
    type(pattern_type), intent(in) :: pattern               !! their pattern
    type(row_type), intent(in) :: some(:)                   !! what to measure
    integer, intent(in) :: n                                !! points
    !> Material of Table 2 of the paper, with the inclination of the planes.
    real(real64), parameter :: table_2(5) = [3.0_real64, 0.3_real64, 0.9_real64, 0.5_real64, 30.0_real64]
    type(row_type) :: timed(size(some))
    type(start_type) :: start
    type(double_type) :: double
    type(point_work_type) :: point
    type(single_type) :: single
    real(real64) :: flat, ns(0:turns, size(some)), since
    integer :: given, i, loop, loops(size(some)), turn, width
    logical :: by_points

    flat = merge(0.0_real64, 1.0_real64/3.0_real64, pattern%name == "2 planes")
    ! a UMAT of straight planes gets PROPS up to turn
    given = merge(p_w0, p_turn, pattern%height > 0.0_real64)
    if (pattern%c > 0.0_real64) given = p_c
    associate (props => [table_2, pattern%m, flat, prop_table(p_turn:p_guard)%default, pattern%height, pattern%w0, &
                         prop_table(p_damage0:p_water)%default, pattern%c])
      call new_start(props(:given), n, start)
    end associate
    by_points = all(some(1)%kernel /= ["block", "vumat"])
    width = merge(n_small, n, some(1)%kernel == "vumat")
    if (by_points) then
      call new_point_work(start, point)
    else if (some(1)%precision == "double") then
      call new_double(start, width, double)
    else
      call new_single(start, width, single)
    end if
    timed = some
    timed%pattern = pattern%name
    timed%planes = start%joint%pattern%n
    timed%points = n
    loops = 1
    ! the first turn warms up, the next one finds the number of loops
    do turn = -1, turns
      do i = 1, size(timed)
        since = now()
        do loop = 1, loops(i)
          if (by_points) then
            call run_points(point, timed(i)%kernel, timed(i)%tangent, used)
          else if (timed(i)%precision == "double") then
            call run_double(double, timed(i)%kernel, timed(i)%tangent, used)
          else
            call run_single(single, timed(i)%kernel, timed(i)%tangent, used)
          end if
        end do
        ns(max(turn, 0), i) = (now() - since)/real(loops(i), real64)
        if (turn == 0) loops(i) = 1 + int(shortest/max(ns(0, i), 1.0_real64))
      end do
    end do
    do i = 1, size(timed)
      timed(i)%ns = median(ns(1:, i))/real(timed(i)%points, real64)
    end do
    rows = [rows, timed]
  end subroutine add

  !> Time from an arbitrary start, nanoseconds.
  function now() result(t)
    real(real64) :: t
    integer(int64) :: count, rate
    call system_clock(count, rate)
    t = 1.0e9_real64*real(count, real64)/real(rate, real64)
  end function now

  !> The lower median: at least half of the values are not larger, at least half not smaller.
  pure function median(x) result(middle)
    real(real64), intent(in) :: x(:)   !! values, at least one
    real(real64) :: middle
    integer :: i, half
    half = (size(x) + 1)/2
    middle = x(1)
    do i = 1, size(x)
      if (count(x < x(i)) < half .and. count(x <= x(i)) >= half) middle = x(i)
    end do
  end function median

  !> Read the arguments; the program stops with a message if one is unknown.
  subroutine read_arguments(file, quick)
    character(len=:), allocatable, intent(out) :: file   !! name of the CSV, empty: none
    logical, intent(out) :: quick                        !! few repetitions and points, to test the program
    character(len=4096) :: text
    integer :: k
    file = ""
    quick = .false.
    k = 1
    do while (k <= command_argument_count())
      call get_command_argument(k, text)
      if (text == "--quick") then
        quick = .true.
      else if (text == "--csv" .and. k < command_argument_count()) then
        k = k + 1
        call get_command_argument(k, text)
        file = trim(text)
      else
        write (error_unit, "(3a)") "bench: ", trim(text), ": expected --csv FILE or --quick"
        stop 1
      end if
      k = k + 1
    end do
  end subroutine read_arguments

  !> Write the rows as CSV with columns of equal width: with each time that of the textbook version over it, and it over
  !> that of what it consists of; 0 where there is none.
  subroutine write_rows(rows, unit)
    type(row_type), intent(in) :: rows(:)   !! what to write
    integer, intent(in) :: unit             !! open for writing
    real(real64) :: parts
    integer :: i
    write (unit, "(2a)") " pattern,planes,  kernel,precision,tangent, points,ns_per_point,isa,", &
      "textbook/ns,ns/parts"
    do i = 1, size(rows)
      associate (row => rows(i))
        parts = 0.0_real64
        if (row%kernel == "umat") parts = time_of("point", row)
        if (row%kernel == "block") parts = time_of("roots", row)
        if (row%kernel == "vumat") parts = time_of("block", row) + time_of("stream", row)
        if (row%kernel == "points") parts = time_of("block", row) + time_of("copy", row)
        if (parts > 0.0_real64) parts = row%ns/parts
        write (unit, "(a8, ',', i6, ',', a8, ',', a9, ',', a7, ',', i7, ',', f12.3, ',', i3, ',', &
          &f11.3, ',', f8.3)") adjustr(row%pattern), row%planes, adjustr(row%kernel), adjustr(row%precision // "   "), &
          adjustr(merge("yes", "no ", row%tangent) // "    "), row%points, row%ns, &
          instruction_set(), time_of("textbook", row)/row%ns, parts
      end associate
    end do
  end subroutine write_rows

  !> Time of another kernel with the pattern, precision and tangent of a row, 0: none. Limits have no tangent, copies
  !> have the points of the row, and the textbook version is in double precision.
  function time_of(kernel, row) result(ns)
    character(len=*), intent(in) :: kernel   !! which one
    type(row_type), intent(in) :: row        !! what it is compared with
    real(real64) :: ns
    logical :: limit
    integer :: j
    ns = 0.0_real64
    limit = any(kernel == ["copy  ", "roots ", "stream"])
    j = findloc(rows%pattern == row%pattern .and. rows%kernel == kernel .and. &
      (rows%precision == row%precision .or. kernel == "textbook") .and. &
      (rows%points == row%points .or. kernel /= "copy") .and. (limit .or. (rows%tangent .eqv. row%tangent)), .true., 1)
    if (j > 0) ns = rows(j)%ns
  end function time_of

end program bench
