!> Options of a long run of drawn scenes: how many, from which seed, or one of them alone.
module soak_options
  use, intrinsic :: iso_fortran_env, only: error_unit, int64
  use asperity_text, only: integer_text
  use random_numbers, only: largest_seed
  implicit none
  private
  public :: read_options

  !> Values of the options.
  type, public :: options_type
    integer :: samples = 0               !! number of scenes
    integer :: only = 0                  !! the only scene to run, 0: all
    integer(int64) :: seed = 1_int64     !! 1..largest_seed
    logical :: across = .false.          !! slips free across alone, in a program that has this option
    logical :: quiet = .false.           !! without progress
  end type options_type

contains

  !> Read the options of the command; the program stops with a message if one is not admissible.
  subroutine read_options(program, samples, options, has_across)
    character(len=*), intent(in) :: program        !! its name
    integer, intent(in) :: samples                 !! default number of scenes
    logical, intent(in), optional :: has_across    !! true: with the option --across
    type(options_type), intent(out) :: options     !! values
    character(len=200) :: argument, option
    integer(int64) :: number
    integer :: a, status
    logical :: knows_across
    knows_across = .false.
    if (present(has_across)) knows_across = has_across
    options%samples = samples
    a = 1
    do while (a <= command_argument_count())
      call get_command_argument(a, option)
      call get_command_argument(a + 1, argument)
      a = a + 1
      number = 1_int64
      if (any(option == [character(len=9) :: "--samples", "--only", "--seed"])) then
        read (argument, *, iostat=status) number
        if (status /= 0) number = 0_int64
        a = a + 1
      end if
      select case (option)
      case ("--samples")
        options%samples = int(number)
      case ("--only")
        options%only = int(number)
      case ("--seed")
        options%seed = number
      case ("--across")
        options%across = .true.
        if (.not. knows_across) number = 0_int64
      case ("--quiet")
        options%quiet = .true.
      case default
        number = 0_int64
      end select
      if (number < 1_int64 .or. number > largest_seed .or. &
        (a > command_argument_count() .and. options%only > options%samples)) then
        write (error_unit, "(a)") program // ": " // trim(option) // " " // trim(argument) // ": usage: " // &
          program // " [--samples N] [--only I] [--seed S] " // repeat("[--across] ", merge(1, 0, &
          knows_across)) // "[--quiet], N >= 1 (" // &
          integer_text(samples) // "), S from 1 to " // integer_text(int(largest_seed)) // &
          " (1), I from 1 to N: that one alone"
        stop 1
      end if
    end do
  end subroutine read_options

end module soak_options
