!> Cost of the update of one point: UMAT and core against the textbook version, medians of runs taken in turn.
program bench
  use, intrinsic :: iso_fortran_env, only: int64, output_unit
  use asperity_checks, only: to_text
  use asperity_interface, only: interface_type, new_interface
  use asperity_kinds, only: wp
  use asperity_law, only: update_point
  use host_routines, only: umat
  use textbook, only: textbook_numerical_tangent, textbook_tangent, textbook_traction
  implicit none
  integer, parameter :: n_points = 256, repeats = 41, n_kinds = 5
  integer, parameter :: umat_call = 1, core = 2, numerical = 3, analytic = 4
  character(len=24), parameter :: kinds(n_kinds) = [character(len=24) :: "umat, tangent", "core, tangent", &
    "textbook, numerical", "textbook, analytic", "textbook, stress only"]
  integer, parameter :: patterns(5) = [2, 3, 4, 6, 32]
  character(len=6), parameter :: names(5) = ["RT   ", "RP-3 ", "RP-4 ", "RP-6 ", "RP-32"]
  real(wp), parameter :: table_2(5) = [3.0_wp, 0.3_wp, 0.9_wp, 0.5_wp, 30.0_wp]
  real(wp) :: nanoseconds(n_kinds)
  integer :: i, j

  print "(a)", "nanoseconds per update of one point, median of runs taken in turn (Table 2, slip under compression)"
  print "(a8, *(a24))", "pattern", (adjustr(kinds(j)), j=1, n_kinds), "numerical/umat", "analytic/core"
  do i = 1, size(patterns)
    call measure([table_2, real(patterns(i), wp)], nanoseconds)
    print "(a8, *(f24.1))", adjustr(names(i)), nanoseconds, nanoseconds(numerical)/nanoseconds(umat_call), &
      nanoseconds(analytic)/nanoseconds(core)
    flush (output_unit)
  end do

contains

  !> Median time of every kind for one pattern.
  subroutine measure(props, nanoseconds)
    real(wp), intent(in) :: props(:)           !! PROPS
    real(wp), intent(out) :: nanoseconds(:)    !! per point, by kind
    type(interface_type) :: interface
    real(wp), allocatable :: old(:, :), new(:, :), s_old(:, :), s(:, :), ds(:, :)
    real(wp) :: t(3), d(3, 3), sse, spd, scd, total, times(repeats, n_kinds)
    integer(int64) :: start, finish, rate
    integer :: kind, p, r, status
    character(len=80) :: name

    name = "BENCH"
    call new_interface(props, interface, status)
    allocate (old(interface%n_statev, n_points), new(interface%n_statev, n_points))
    allocate (s_old(3, n_points), s(3, n_points), ds(3, n_points))
    ! a bed joint under shear: every point compressed, slip from none to 1.5 s_f along a direction of its own
    old = 0.0_wp
    do p = 1, n_points
      s_old(:, p) = 0.3_wp*real(p, wp)/real(n_points, wp)*[0.0_wp, cos(real(p, wp)), sin(real(p, wp))]
      s_old(1, p) = 0.2_wp*norm2(s_old(2:3, p)) - 0.01_wp
      s(:, p) = s_old(:, p)*1.01_wp
      call update_point(interface%rie, [0.0_wp, 0.0_wp, 0.0_wp], s_old(:, p), old(:, p), new(:, p), t, d)
    end do
    old = new
    ds = s - s_old
    total = 0.0_wp
    do r = 1, repeats
      do kind = 1, n_kinds
        call system_clock(start, rate)
        do p = 1, n_points
          select case (kind)
          case (umat_call)
            new(:, p) = old(:, p)
            call umat(t, new(:, p), d, sse, spd, scd, stran=s_old(:, p), dstran=ds(:, p), cmname=name, &
              ndi=1, nshr=2, ntens=3, nstatv=interface%n_statev, props=props, nprops=size(props))
          case (core)
            call update_point(interface%rie, s_old(:, p), s(:, p), old(:, p), new(:, p), t, d)
          case (numerical)
            call textbook_numerical_tangent(interface%rie, s(:, p), old(:, p), new(:, p), t, d)
          case (analytic)
            call textbook_tangent(interface%rie, s(:, p), old(:, p), new(:, p), t, d)
          case default
            call textbook_traction(interface%rie, s(:, p), old(:, p), new(:, p), t)
          end select
          total = total + t(2)
        end do
        call system_clock(finish)
        times(r, kind) = 1.0e9_wp*real(finish - start, wp)/real(rate, wp)/real(n_points, wp)
      end do
    end do
    if (total > huge(1.0_wp)) print "(2a)", "unexpected sum ", to_text(total)   ! uses the results
    do kind = 1, n_kinds
      nanoseconds(kind) = median(times(:, kind))
    end do
  end subroutine measure

  !> Median by counting, for an odd number of values.
  pure function median(x) result(middle)
    real(wp), intent(in) :: x(:)   !! values
    real(wp) :: middle
    integer :: i
    middle = x(1)
    do i = 1, size(x)
      if (count(x < x(i)) <= size(x)/2 .and. count(x <= x(i)) > size(x)/2) middle = x(i)
    end do
  end function median

end program bench
