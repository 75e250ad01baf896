!> Target ratios of the library's speed, compared with the rows of one run.
module aims
  use, intrinsic :: iso_fortran_env, only: real64
  use table, only: find
  use tasks, only: row_type
  implicit none
  private
  public :: print_aims

contains

  !> Print one line for each ratio, with its target and whether the target is met.
  subroutine print_aims(rows, n_cache, n_memory)
    type(row_type), intent(in) :: rows(:)   !! all rows
    integer, intent(in) :: n_cache          !! points of the arrays in the second-level caches
    integer, intent(in) :: n_memory         !! points of the arrays in memory
    character(len=5), parameter :: kernels(3) = [character(len=5) :: "point", "umat", "test"], &
      from_memory(2) = [character(len=5) :: "RP-4", "RP-32"]
    integer :: i

    print "(/, a60, a9, a12)", "ratio in this run", "measured", "aim"
    call line("RP-32 block, stress / roots", &
      ns("RP-32", "block", .false.)/ns("RP-32", "roots", .false.), at_most=2.8_real64)
    do i = 1, size(from_memory)
      call line(trim(from_memory(i)) // " vumat from memory / (block in the cache + streaming)", &
        ns(from_memory(i), "vumat", .false.)/ &
        (ns(from_memory(i), "block", .false.) + ns(from_memory(i), "stream", .false.)), at_most=1.25_real64)
    end do
    call line("RP-4 textbook tangent / point", &
      ns("RP-4", "textbook", .true.)/ns("RP-4", "point", .true.), at_least=3.5_real64)
    call line("RP-32 textbook tangent / point", &
      ns("RP-32", "textbook", .true.)/ns("RP-32", "point", .true.), at_least=6.0_real64)
    call line("RP-32 / RP-4, block stress", &
      ns("RP-32", "block", .false.)/ns("RP-4", "block", .false.), at_most=6.6_real64)
    call line("RP-32 / RP-4, block tangent", &
      ns("RP-32", "block", .true.)/ns("RP-4", "block", .true.), at_most=6.6_real64)
    do i = 1, size(kernels)
      call line("RP-32 / RP-4, " // kernels(i), &
        ns("RP-32", kernels(i), .true.)/ns("RP-4", kernels(i), .true.), at_most=6.6_real64)
    end do
    call line("RP-4 block, stress, with height / without", &
      ns("RP-4 H", "block", .false.)/ns("RP-4", "block", .false.), at_most=3.0_real64)
    call line("RP-4 block, tangent, with height / without", &
      ns("RP-4 H", "block", .true.)/ns("RP-4", "block", .true.), at_most=3.0_real64)
    if (maxval(rows%threads) < 2) return
    call line("RP-4 arrays in cache, 1 thread / 2 threads", &
      array_ns("points", n_cache, 1)/array_ns("points", n_cache, 2), at_least=1.9_real64)
    call line("RP-4 arrays in memory, 1 thread / 2 threads", &
      array_ns("points", n_memory, 1)/array_ns("points", n_memory, 2))
    call line("the same bytes copied, 1 thread / 2 threads", &
      array_ns("copy", n_memory, 1)/array_ns("copy", n_memory, 2))
    call line("RP-4 arrays in memory / copied, 1 thread", &
      array_ns("points", n_memory, 1)/array_ns("copy", n_memory, 1))
    call line("RP-4 arrays in memory / copied, 2 threads", &
      array_ns("points", n_memory, 2)/array_ns("copy", n_memory, 2))

  contains

    !> Time of the row with these properties, in double precision.
    function ns(pattern, kernel, tangent) result(t)
      character(len=*), intent(in) :: pattern   !! its pattern
      character(len=*), intent(in) :: kernel    !! its kernel
      logical, intent(in) :: tangent            !! whether the kernel computes the tangent
      real(real64) :: t
      type(row_type) :: row
      row = find(rows, pattern, kernel, "double", tangent, "slip")
      t = row%ns
    end function ns

    !> Time of the row of arrays with these properties.
    function array_ns(kernel, points, threads) result(t)
      character(len=*), intent(in) :: kernel   !! its kernel
      integer, intent(in) :: points            !! its number of points
      integer, intent(in) :: threads           !! its number of threads
      real(real64) :: t
      type(row_type) :: row
      row = find(rows, "RP-4", kernel, "double", .false., "slip", points, threads)
      t = row%ns
    end function array_ns

  end subroutine print_aims

  !> Print one line.
  subroutine line(text, measured, at_least, at_most)
    character(len=*), intent(in) :: text               !! what is compared
    real(real64), intent(in) :: measured               !! its ratio
    real(real64), intent(in), optional :: at_least     !! the aim, a lower bound
    real(real64), intent(in), optional :: at_most      !! the aim, an upper bound
    if (.not. (present(at_least) .or. present(at_most))) print "(a60, f9.2)", text, measured
    if (present(at_least)) print "(a60, f9.2, 3x, a, f5.2, 2x, a)", text, measured, ">=", at_least, &
      merge("met   ", "missed", measured >= at_least)
    if (present(at_most)) print "(a60, f9.2, 3x, a, f5.2, 2x, a)", text, measured, "<=", at_most, &
      merge("met   ", "missed", measured <= at_most)
  end subroutine line

end module aims
