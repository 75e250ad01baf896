!> One point of a joint, of unit area; Newton's method finds its equilibrium, as in Abaqus/Standard.
!>
!> It carries a normal pressure and is pulled along Tx and Ty by springs, whose far ends have prescribed displacements.
!> At every call STRESS and STATEV are those of the start of the increment, and PNEWDT is 1. Before a call, the outputs
!> of the user routine have the value `garbage`.
module standard_point
  use, intrinsic :: iso_fortran_env, only: real64
  use host_routines, only: umat_call => umat
  implicit none
  private
  public :: point_type, new_point, load_type, go_to

  integer, parameter, public :: wp = real64
  integer, parameter :: ntens = 3
  !> Largest residual of a converged increment, relative to the applied forces, and largest number of iterations.
  real(wp), parameter :: tolerance = 1.0e-11_wp
  integer, parameter, public :: max_iterations = 20
  !> Stiffness of a spring.
  real(wp), parameter, public :: spring = 50.0_wp
  !> Value of the outputs before a call, and of arguments that a host does not define.
  real(wp), parameter :: garbage = -7.7e77_wp

  !> Loads.
  type :: load_type
    real(wp) :: pressure = 0.0_wp                  !! on the upper face
    real(wp) :: driven(2) = 0.0_wp                 !! Tx, Ty of the far ends of the springs
  end type load_type

  !> State of the point at the end of an increment.
  type :: point_type
    real(wp) :: stress(ntens) = 0.0_wp             !! STRESS
    real(wp) :: stran(ntens) = 0.0_wp              !! STRAN (N, Tx, Ty), the separation for thickness 1
    real(wp) :: energies(3) = 0.0_wp               !! SSE, SPD, SCD
    real(wp), allocatable :: statev(:)             !! STATEV
    real(wp) :: time = 0.0_wp                      !! total time
    integer :: increment = 0                       !! of the step
    logical :: failed = .false.                    !! no convergence, or the user routine requested a cut
  end type point_type

contains

  !> Virgin point.
  pure function new_point(nstatv) result(point)
    integer, intent(in) :: nstatv   !! state variables
    type(point_type) :: point
    allocate (point%statev(nstatv), source=0.0_wp)
  end function new_point

  !> Solve one increment to a load; with `abandon` the increment ends after one iteration, as before a cut-back.
  subroutine go_to(point, umat, props, load, abandon)
    type(point_type), intent(inout) :: point   !! if the increment is not accepted, only `failed` changes
    procedure(umat_call) :: umat               !! user routine
    real(wp), intent(in) :: props(:)           !! material constants
    type(load_type), intent(in) :: load        !! at the end
    logical, intent(in) :: abandon             !! give up
    character(len=80), parameter :: name = "JOINT"
    type(point_type) :: trial
    real(wp) :: force(ntens), ddsdde(ntens, ntens), strain(ntens), per_strain(ntens), no_tensor(3, 3), no_field(1), &
      heat, heat_rate, pnewdt
    integer :: i
    no_tensor = garbage
    no_field = garbage
    strain = point%stran
    do i = 1, max_iterations
      trial = point
      trial%increment = point%increment + 1
      trial%time = point%time + 1.0_wp
      trial%stran = strain
      ddsdde = garbage
      per_strain = garbage
      heat = garbage
      heat_rate = garbage
      pnewdt = 1.0_wp
      call umat(trial%stress, trial%statev, ddsdde, trial%energies(1), trial%energies(2), trial%energies(3), heat, &
        per_strain, per_strain, heat_rate, point%stran, strain - point%stran, [point%time, point%time], 1.0_wp, &
        0.0_wp, 0.0_wp, no_field, no_field, name, 1, 2, ntens, size(trial%statev), props, size(props), &
        no_field([1, 1, 1]), no_tensor, pnewdt, 1.0_wp, no_tensor, no_tensor, 1, 1, 1, 1, 1, trial%increment)
      if (pnewdt < 1.0_wp) point%failed = .true.
      if (point%failed .or. abandon) return
      force = trial%stress + [load%pressure, spring*(strain(2:) - load%driven)]
      if (sqrt(sum(force**2)) <= tolerance*(load%pressure + spring*sum(abs(load%driven)))) then
        point = trial
        return
      end if
      ddsdde(2, 2) = ddsdde(2, 2) + spring
      ddsdde(3, 3) = ddsdde(3, 3) + spring
      strain = strain - solution(ddsdde, force)
    end do
    point%failed = .true.
  end subroutine go_to

  !> Solution of three equations, by Cramer's rule.
  pure function solution(a, b) result(x)
    real(wp), intent(in) :: a(ntens, ntens)   !! matrix
    real(wp), intent(in) :: b(ntens)          !! right-hand side
    real(wp) :: x(ntens)
    x = [determinant(b, a(:, 2), a(:, 3)), determinant(a(:, 1), b, a(:, 3)), determinant(a(:, 1), a(:, 2), b)]/ &
        determinant(a(:, 1), a(:, 2), a(:, 3))
  end function solution

  !> Determinant of three columns.
  pure function determinant(a, b, c) result(d)
    real(wp), intent(in) :: a(ntens), b(ntens), c(ntens)   !! columns
    real(wp) :: d
    d = dot_product(a, cshift(b, 1)*cshift(c, 2) - cshift(b, 2)*cshift(c, 1))
  end function determinant

end module standard_point
