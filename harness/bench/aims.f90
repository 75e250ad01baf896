!> The ratios the library aims at, from the rows of one run.
module aims
  use, intrinsic :: iso_fortran_env, only: real64
  use table, only: find
  use tasks, only: row_type
  implicit none
  private
  public :: print_aims

contains

  !> Ratio, aim and whether it is met, line by line.
  subroutine print_aims(rows, n_cache, n_memory)
    type(row_type), intent(in) :: rows(:)   !! all rows
    integer, intent(in) :: n_cache          !! points of the arrays in the second-level caches
    integer, intent(in) :: n_memory         !! points of the arrays in memory
    type(row_type) :: vumat
    character(len=5), parameter :: kernels(3) = [character(len=5) :: "point", "umat", "test"]
    integer :: i

    print "(/, a60, a9, a12)", "ratio in this run", "measured", "aim"
    vumat = find(rows, "RP-4", "vumat", "double", .false., "slip")
    call line("RP-4 block, double / roots", &
      ns("RP-4", "block", .false.)/ns("RP-4", "roots", .false.), at_most=1.5_real64)
    call line("RP-4 vumat, double, data in memory / larger limit", &
      vumat%ns/max(vumat%stream, vumat%roots), at_most=1.5_real64)
    call line("RP-4 plain stress / block stress", &
      ns("RP-4", "plain", .false.)/ns("RP-4", "block", .false.), at_least=4.5_real64)
    call line("RP-4 plain tangent / block tangent", &
      ns("RP-4", "plain", .true.)/ns("RP-4", "block", .true.), at_least=4.5_real64)
    call line("RP-4 textbook tangent / point", &
      ns("RP-4", "textbook", .true.)/ns("RP-4", "point", .true.), at_least=3.5_real64)
    call line("RP-32 textbook tangent / point", &
      ns("RP-32", "textbook", .true.)/ns("RP-32", "point", .true.), at_least=6.0_real64)
    call line("RP-4 point (tangent) / plain stress", &
      ns("RP-4", "point", .true.)/ns("RP-4", "plain", .false.), at_most=1.5_real64)
    call line("RP-32 point (tangent) / plain stress", &
      ns("RP-32", "point", .true.)/ns("RP-32", "plain", .false.), at_most=1.5_real64)
    call line("RP-32 / RP-4, block stress", &
      ns("RP-32", "block", .false.)/ns("RP-4", "block", .false.), at_most=6.6_real64)
    call line("RP-32 / RP-4, block tangent", &
      ns("RP-32", "block", .true.)/ns("RP-4", "block", .true.), at_most=6.6_real64)
    do i = 1, size(kernels)
      call line("RP-32 / RP-4, " // kernels(i), &
        ns("RP-32", kernels(i), .true.)/ns("RP-4", kernels(i), .true.), at_most=6.6_real64)
    end do
    ! what shortcuts would gain: 90 % of the chunks on the cheap path at best
    call line("RP-4 shortcut: virgin planes / block, each point", &
      scene_ns("virgin", "zones")/scene_ns("block", "zones"))
    call line("the same on 90 % of the points", &
      (0.9_real64*scene_ns("virgin", "zones") + 0.1_real64*scene_ns("block", "zones"))/scene_ns("block", "zones"))
    call line("RP-4 shortcut: mu = 0 / block", scene_ns("no mu", "zones")/scene_ns("block", "zones"))
    call line("RP-4 shortcut: planar loading, mirrored planes once / block", &
      mirrored_ns("RP-4")/ns("RP-4", "block", .false.))
    call line("RP-32 shortcut: planar loading, mirrored planes once / block", &
      mirrored_ns("RP-32")/ns("RP-32", "block", .false.))
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

    !> Time of a row in double precision.
    function ns(pattern, kernel, tangent) result(t)
      character(len=*), intent(in) :: pattern   !! its pattern
      character(len=*), intent(in) :: kernel    !! its kernel
      logical, intent(in) :: tangent            !! whether it gives the tangent
      real(real64) :: t
      type(row_type) :: row
      row = find(rows, pattern, kernel, "double", tangent, "slip")
      t = row%ns
    end function ns

    !> Time of a row of RP-4 on a mix of points, stress only.
    function scene_ns(kernel, scene) result(t)
      character(len=*), intent(in) :: kernel   !! its kernel
      character(len=*), intent(in) :: scene    !! its scene
      real(real64) :: t
      type(row_type) :: row
      row = find(rows, "RP-4", kernel, "double", .false., scene)
      t = row%ns
    end function scene_ns

    !> Time of the block kernel with one plane in place of every mirrored pair.
    function mirrored_ns(pattern) result(t)
      character(len=*), intent(in) :: pattern   !! its pattern
      real(real64) :: t
      type(row_type) :: row
      row = find(rows, pattern, "block", "double", .false., "mirrored")
      t = row%ns
    end function mirrored_ns

    !> Time of a row of arrays.
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

  !> One line.
  subroutine line(text, measured, at_least, at_most)
    character(len=*), intent(in) :: text               !! what is compared
    real(real64), intent(in) :: measured               !! its ratio
    real(real64), intent(in), optional :: at_least     !! the aim, a lower bound
    real(real64), intent(in), optional :: at_most      !! the aim, an upper bound
    if (.not. (present(at_least) .or. present(at_most))) print "(a60, f9.2)", text, measured
    if (present(at_least)) print "(a60, f9.2, 3x, a, f5.1, 2x, a)", text, measured, ">=", at_least, &
      merge("met   ", "missed", measured >= at_least)
    if (present(at_most)) print "(a60, f9.2, 3x, a, f5.1, 2x, a)", text, measured, "<=", at_most, &
      merge("met   ", "missed", measured <= at_most)
  end subroutine line

end module aims
