!> Fuzz run over the UMAT, the VUMATs and the C API: fuzz [SEED [CALLS]], or fuzz SEED 1 TARGET CASE for one case alone.
!>
!> The run checks that no call crashes, that finite input gives finite results, that nothing is written beyond the
!> caller's arrays, and that every rejection has a message. After a failure it prints seed, case and input, and the exit
!> code is 1.
program fuzz
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use asperity_text, only: integer_text
  use fuzz_c, only: try_c
  use fuzz_umat, only: try_umat
  use fuzz_vumat_double, only: try_double => try_vumat
  use fuzz_vumat_single, only: try_single => try_vumat
  use progress_line, only: start_progress, clear_progress, progress_type, show_progress
  implicit none

  character(len=6), parameter :: targets(4) = ["umat  ", "vumat ", "single", "c     "]
  !> Number of calls of the UMAT in the long run, and its divisors for the other targets, whose calls take blocks of
  !> points.
  integer(int64), parameter :: long_run = 10000000_int64
  integer(int64), parameter :: shares(4) = [1_int64, 20_int64, 20_int64, 10_int64]
  !> Number of failures after which the run ends.
  integer, parameter :: most_shown = 5
  integer(int64) :: number, seed, wanted
  integer :: failed, passed, target
  type(progress_type) :: progress

  if (all(command_argument_count() /= [0, 1, 2, 4])) call reject("expected none, one, two or four arguments")
  seed = argument(1, 1_int64)
  wanted = argument(2, long_run)
  ! rejected calls write their reason to standard error, which would be millions of lines
  if (command_argument_count() < 4) open (unit=error_unit, file="/dev/null", action="write")
  failed = 0
  passed = 0
  if (command_argument_count() == 4) then
    number = argument(4, 0_int64)
    target = int(argument(3, 1_int64))
    call one_case(target, number, .true.)
    passed = 1 - failed
  else
    do target = 1, size(targets)
      call run(target, max(1_int64, wanted/shares(target)))
    end do
  end if
  print "(i0, a, i0, a)", passed, " passed, ", failed, " failed"
  if (failed > 0) stop 1

contains

  !> Integer argument of the command; the program stops with a message if it is not admissible.
  function argument(i, default) result(value)
    integer, intent(in) :: i                 !! which
    integer(int64), intent(in) :: default    !! value of a missing argument
    integer(int64) :: value
    character(len=8), parameter :: names(4) = [character(len=8) :: "SEED", "CALLS", "TARGET", "CASE"]
    integer, parameter :: least(4) = [0, 0, 1, 0], most(4) = [huge(0), huge(0), size(targets), huge(0)]
    character(len=32) :: text
    integer :: status
    value = default
    if (command_argument_count() < i) return
    call get_command_argument(i, text)
    read (text, *, iostat=status) value
    if (status == 0 .and. value >= least(i) .and. value <= most(i)) return
    call reject(trim(names(i)) // " = " // trim(text) // ": expected a whole number from " // &
      integer_text(least(i)) // " to " // integer_text(most(i)))
  end function argument

  !> Stop with a message about the arguments, and exit code 1.
  subroutine reject(reason)
    character(len=*), intent(in) :: reason   !! what is wrong, and what was expected
    write (error_unit, "(a)") "fuzz: " // reason // ". Usage: fuzz [SEED [CALLS]] or fuzz SEED 1 TARGET CASE"
    stop 1
  end subroutine reject

  !> Run all cases of a target.
  subroutine run(target, wanted)
    integer, intent(in) :: target            !! index of targets
    integer(int64), intent(in) :: wanted     !! calls
    integer(int64) :: done, rejections
    integer :: earlier
    call start_progress(progress, "fuzz", "calls", .false.)
    done = 0_int64
    rejections = 0_int64
    number = 0_int64
    earlier = failed
    do while (done < wanted .and. failed - earlier < most_shown)
      call one_case(target, number, .false., done, rejections)
      number = number + 1_int64
      call show_progress(progress, trim(targets(target)), int(done), int(wanted))
    end do
    call clear_progress(progress)
    print "(a, i0, a, i0, a, i0, a, i0)", "fuzz " // trim(targets(target)) // ", seed ", seed, ": ", number, &
      " cases, ", done, " calls, rejected: ", rejections
    if (failed == earlier) passed = passed + 1
  end subroutine run

  !> Run one case; the report of a failure has the command that repeats it.
  subroutine one_case(target, number, verbose, done, rejections)
    integer, intent(in) :: target                             !! index of targets
    integer(int64), intent(in) :: number                      !! case
    logical, intent(in) :: verbose                            !! print the input also without a failure
    integer(int64), intent(inout), optional :: done           !! calls so far
    integer(int64), intent(inout), optional :: rejections     !! rejected calls so far
    character(len=:), allocatable :: complaint, inputs
    logical :: rejected
    integer :: n
    select case (target)
    case (1)
      call try_umat(seed, number, n, rejected, complaint, inputs)
    case (2)
      call try_double(seed, number, n, rejected, complaint, inputs)
    case (3)
      call try_single(seed, number, n, rejected, complaint, inputs)
    case default
      call try_c(seed, number, n, rejected, complaint, inputs)
    end select
    if (present(done)) done = done + int(n, int64)
    if (present(rejections) .and. rejected) rejections = rejections + 1_int64
    if (len(complaint) == 0 .and. .not. verbose) return
    if (len(complaint) > 0) failed = failed + 1
    call clear_progress(progress)
    print "(3a)", "fuzz " // trim(targets(target)), ": ", complaint
    print "(a, i0, a, i0, a, i0)", "  again: fuzz ", seed, " 1 ", target, " ", number
    print "(a)", inputs
    flush (output_unit)
  end subroutine one_case

end program fuzz
