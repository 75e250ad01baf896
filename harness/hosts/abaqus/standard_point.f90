!> One point of a joint of unit thickness, whose user routine is called as Abaqus/Standard calls it.
!>
!> At every call STRESS and STATEV are those of the start of the increment, and PNEWDT is 1. Before a call, the outputs
!> of the user routine have the value `garbage`.
module standard_point
  use, intrinsic :: iso_fortran_env, only: real64
  use host_routines, only: umat_call => umat
  implicit none
  private
  public :: point_type, new_point, go_to

  integer, parameter, public :: wp = real64
  integer, parameter :: ntens = 3
  !> Value of the outputs before a call, and of arguments that a host does not define.
  real(wp), parameter :: garbage = -7.7e77_wp

  !> State of the point at the end of an increment.
  type :: point_type
    real(wp) :: stress(ntens) = 0.0_wp             !! STRESS
    real(wp) :: stran(ntens) = 0.0_wp              !! STRAN (N, Tx, Ty), the separation for thickness 1
    real(wp) :: energies(3) = 0.0_wp               !! SSE, SPD, SCD
    real(wp), allocatable :: statev(:)             !! STATEV
    real(wp) :: time = 0.0_wp                      !! total time
    logical :: cut = .false.                       !! whether the user routine requested a smaller increment
  end type point_type

contains

  !> Virgin point.
  pure function new_point(nstatv) result(point)
    integer, intent(in) :: nstatv   !! state variables
    type(point_type) :: point
    allocate (point%statev(nstatv), source=0.0_wp)
  end function new_point

  !> Take the point to a strain; with `abandon` the increment is given up after the call, as before a cut-back.
  subroutine go_to(point, umat, props, strain, abandon)
    type(point_type), intent(inout) :: point   !! if the increment is not accepted, only `cut` changes
    procedure(umat_call) :: umat               !! user routine
    real(wp), intent(in) :: props(:)           !! material constants
    real(wp), intent(in) :: strain(ntens)      !! at the end
    logical, intent(in) :: abandon             !! give up
    character(len=80), parameter :: name = "JOINT"
    type(point_type) :: trial
    real(wp) :: ddsdde(ntens, ntens), per_strain(ntens), no_tensor(3, 3), no_field(1), heat, heat_rate, pnewdt
    trial = point
    trial%time = point%time + 1.0_wp
    trial%stran = strain
    no_tensor = garbage
    no_field = garbage
    ddsdde = garbage
    per_strain = garbage
    heat = garbage
    heat_rate = garbage
    pnewdt = 1.0_wp
    call umat(trial%stress, trial%statev, ddsdde, trial%energies(1), trial%energies(2), trial%energies(3), heat, &
      per_strain, per_strain, heat_rate, point%stran, strain - point%stran, [point%time, point%time], 1.0_wp, &
      0.0_wp, 0.0_wp, no_field, no_field, name, 1, 2, ntens, size(trial%statev), props, size(props), &
      no_field([1, 1, 1]), no_tensor, pnewdt, 1.0_wp, no_tensor, no_tensor, 1, 1, 1, 1, 1, 1)
    point%cut = pnewdt < 1.0_wp
    if (point%cut .or. abandon) return
    trial%cut = .false.
    point = trial
  end subroutine go_to

end module standard_point
