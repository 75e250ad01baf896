!> Options of a long run of drawn scenes: how many, from which seed, or one of them alone.
module soak_options
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use asperity_text, only: integer_text
  use random_numbers, only: largest_seed
  implicit none
  private
  public :: read_options

  integer, parameter :: longest = 1000

  !> Values of the options.
  type, public :: options_type
    integer :: samples = 0               !! number of scenes
    integer :: only = 0                  !! the only scene to run, 0: all
    integer(int64) :: seed = 1_int64     !! 1..largest_seed
    logical :: quiet = .false.           !! without progress
    logical :: folds = .false.           !! further switches of solver_soak
    logical :: closed = .false.
    character(len=longest) :: csv = ""   !! file of the results, blank: none
  end type options_type

contains

  !> Read the options of the command; the program stops with a message if one is not admissible.
  subroutine read_options(program, samples, further, options)
    character(len=*), intent(in) :: program        !! its name
    integer, intent(in) :: samples                 !! default number of scenes
    character(len=*), intent(in) :: further        !! options that this program has, too, as its usage writes them
    type(options_type), intent(out) :: options     !! values
    character(len=longest) :: argument, option
    integer :: a, status
    options%samples = samples
    a = 0
    do while (a < command_argument_count())
      call next(option)
      argument = ""
      status = 0
      select case (option)
      case ("--help")
        write (output_unit, "(a)") usage()
        stop
      case ("--quiet")
        options%quiet = .true.
      case ("--samples")
        call next(argument)
        read (argument, *, iostat=status) options%samples
      case ("--only")
        call next(argument)
        read (argument, *, iostat=status) options%only
      case ("--seed")
        call next(argument)
        read (argument, *, iostat=status) options%seed
      case ("--folds")
        options%folds = .true.
        status = unless_further("[--folds]")
      case ("--closed")
        options%closed = .true.
        status = unless_further("[--closed]")
      case ("--csv")
        call next(options%csv)
        status = unless_further("[--csv FILE]")
        if (len_trim(options%csv) == 0) status = 1
      case default
        status = 1
      end select
      if (status /= 0 .or. options%samples < 1 .or. options%only < 0 .or. options%seed < 1_int64 .or. &
        options%seed > largest_seed) call reject(trim(option) // " " // argument)
    end do
    if (options%only > options%samples) call reject("--only " // integer_text(options%only))

  contains

    !> Take the next argument of the command, blank if there is none.
    subroutine next(text)
      character(len=longest), intent(out) :: text   !! it
      a = a + 1
      text = ""
      if (a <= command_argument_count()) call get_command_argument(a, text)
    end subroutine next

    !> Zero if the program has an option.
    function unless_further(option) result(status)
      character(len=*), intent(in) :: option   !! as the usage writes it
      integer :: status
      status = merge(0, 1, index(further, option) > 0)
    end function unless_further

    !> How the program is called.
    function usage() result(text)
      character(len=:), allocatable :: text
      text = "usage: " // program // " [--samples N] [--only I] [--seed S] " // further // "[--quiet]"
    end function usage

    !> Stop with a message.
    subroutine reject(what)
      character(len=*), intent(in) :: what   !! the argument
      write (error_unit, "(a)") program // ": " // trim(what) // ": " // usage() // ", N >= 1 (" // &
        integer_text(samples) // "), S from 1 to " // integer_text(int(largest_seed)) // &
        " (1), I from 1 to N: that one alone"
      stop 1
    end subroutine reject

  end subroutine read_options

end module soak_options
