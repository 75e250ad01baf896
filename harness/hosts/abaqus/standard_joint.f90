!> One cohesive element with eight nodes and four integration points; Newton's method finds its equilibrium, as in
!> Abaqus/Standard.
!>
!> The lower nodes are fixed. The upper nodes carry a constant normal force and are pulled along Tx and Ty by springs,
!> whose far ends have prescribed displacements. At every call STRESS and STATEV are those of the start of the
!> increment, and PNEWDT is 1. Before a call, the outputs of the user routine have the value `garbage`.
module standard_joint
  use, intrinsic :: iso_fortran_env, only: real64
  use host_routines, only: umat_call => umat
  implicit none
  private
  public :: joint_type, new_joint, load_type, run_type, go_to, total_force

  integer, parameter, public :: wp = real64
  integer, parameter :: n_nodes = 4, n_points = 4, ntens = 3, n_unknowns = ntens*n_nodes
  !> Largest residual of a converged increment, relative to the applied forces, and largest number of iterations.
  real(wp), parameter :: tolerance = 1.0e-11_wp
  integer, parameter, public :: max_iterations = 20
  !> Area of the element, and stiffness of a spring.
  real(wp), parameter, public :: area = 1.0_wp, spring = 50.0_wp
  !> Value of the outputs before a call, and of arguments that a host does not define.
  real(wp), parameter :: garbage = -7.7e77_wp
  !> Natural coordinates of nodes; the points are Gauss's.
  real(wp), parameter :: corner(2, n_nodes) = reshape([-1, -1, 1, -1, 1, 1, -1, 1]*1.0_wp, [2, n_nodes])
  real(wp), parameter :: gauss = 1.0_wp/sqrt(3.0_wp)

  !> Loads.
  type :: load_type
    real(wp) :: pressure = 0.0_wp                  !! on the upper face
    real(wp) :: driven(2) = 0.0_wp                 !! Tx, Ty of the far ends of the springs
    real(wp) :: spread = 0.1_wp                    !! fraction by which node 3 is ahead of node 1
  end type load_type

  !> State of the element at the end of an increment.
  type :: joint_type
    real(wp) :: u(ntens, n_nodes) = 0.0_wp             !! displacement (N, Tx, Ty) of the upper nodes
    real(wp) :: stress(ntens, n_points) = 0.0_wp       !! STRESS
    real(wp) :: stran(ntens, n_points) = 0.0_wp        !! STRAN
    real(wp) :: energies(3, n_points) = 0.0_wp         !! SSE, SPD, SCD
    real(wp), allocatable :: statev(:, :)              !! (nstatv, points) STATEV
    real(wp) :: time = 0.0_wp                          !! total time
    integer :: increment = 0                           !! of the step
    type(load_type) :: load                            !! at this time
  end type joint_type

  !> Options and counts of a run.
  type :: run_type
    logical :: unsymmetric = .true.                !! false: DDSDDE is symmetrised
    integer :: calls = 0                           !! of the user routine
    integer :: iterations = 0                      !! over all increments
    logical :: failed = .false.                    !! no convergence, or the user routine requested a cut
    real(wp) :: residual(max_iterations) = 0.0_wp  !! of the last increment, over the applied forces
    integer :: n = 0                               !! iterations of the last increment
  end type run_type

contains

  !> Virgin element without displacements.
  pure function new_joint(nstatv) result(joint)
    integer, intent(in) :: nstatv   !! state variables
    type(joint_type) :: joint
    allocate (joint%statev(nstatv, n_points), source=0.0_wp)
  end function new_joint

  !> Solve one increment to a load; with `abandon` the increment ends after one iteration, as before a cut-back.
  subroutine go_to(joint, umat, props, load, run, abandon)
    type(joint_type), intent(inout) :: joint   !! unchanged if the increment is not accepted
    procedure(umat_call) :: umat               !! user routine
    real(wp), intent(in) :: props(:)           !! material constants
    type(load_type), intent(in) :: load        !! at the end
    type(run_type), intent(inout) :: run       !! options and counts
    logical, intent(in) :: abandon             !! give up
    type(joint_type) :: trial
    real(wp) :: force(n_unknowns), stiffness(n_unknowns, n_unknowns), applied
    integer :: i
    trial = joint
    trial%load = load
    trial%increment = joint%increment + 1
    trial%time = joint%time + 1.0_wp
    applied = load%pressure*area + spring*sum(abs(load%driven))
    do i = 1, max_iterations
      call assemble(joint, trial, umat, props, run, force, stiffness)
      if (run%failed .or. abandon) return
      run%iterations = run%iterations + 1
      run%n = i
      run%residual(i) = sqrt(sum(force**2))/applied
      if (run%residual(i) <= tolerance) then
        trial%stran = separation(trial%u)
        joint = trial
        return
      end if
      call solve(stiffness, force)
      trial%u = trial%u - reshape(force, [ntens, n_nodes])
    end do
    run%failed = .true.
  end subroutine go_to

  !> Out-of-balance forces and their derivative.
  subroutine assemble(old, new, umat, props, run, force, stiffness)
    type(joint_type), intent(in) :: old            !! start of the increment
    type(joint_type), intent(inout) :: new         !! end: stress and state follow u
    procedure(umat_call) :: umat                   !! user routine
    real(wp), intent(in) :: props(:)               !! material constants
    type(run_type), intent(inout) :: run           !! options and counts
    real(wp), intent(out) :: force(n_unknowns), stiffness(n_unknowns, n_unknowns)
    character(len=80), parameter :: name = "JOINT"
    real(wp) :: ddsdde(ntens, ntens), strain(ntens, n_points), per_strain(ntens), no_tensor(3, 3), no_field(1), &
      heat, heat_rate, pnewdt, shape_values(n_nodes), ahead
    integer :: a, b, i, j, p
    force = 0.0_wp
    stiffness = 0.0_wp
    no_tensor = garbage
    no_field = garbage
    strain = separation(new%u)
    do p = 1, n_points
      new%stress(:, p) = old%stress(:, p)
      new%statev(:, p) = old%statev(:, p)
      new%energies(:, p) = old%energies(:, p)
      ddsdde = garbage
      per_strain = garbage
      heat = garbage
      heat_rate = garbage
      pnewdt = 1.0_wp
      call umat(new%stress(:, p), new%statev(:, p), ddsdde, new%energies(1, p), new%energies(2, p), &
        new%energies(3, p), heat, per_strain, per_strain, heat_rate, old%stran(:, p), strain(:, p) - old%stran(:, p), &
        [old%time, old%time], 1.0_wp, 0.0_wp, 0.0_wp, no_field, no_field, name, 1, 2, ntens, size(new%statev, 1), &
        props, size(props), no_field([1, 1, 1]), no_tensor, pnewdt, 1.0_wp, no_tensor, no_tensor, 1, p, 1, 1, 1, &
        new%increment)
      run%calls = run%calls + 1
      if (pnewdt < 1.0_wp) run%failed = .true.
      if (.not. run%unsymmetric) ddsdde = 0.5_wp*(ddsdde + transpose(ddsdde))
      shape_values = shapes(gauss*corner(:, p))
      do a = 1, n_nodes
        do i = 1, ntens
          force(ntens*(a - 1) + i) = force(ntens*(a - 1) + i) + shape_values(a)*new%stress(i, p)*area/n_points
          do b = 1, n_nodes
            do j = 1, ntens
              stiffness(ntens*(a - 1) + i, ntens*(b - 1) + j) = stiffness(ntens*(a - 1) + i, ntens*(b - 1) + j) + &
                shape_values(a)*shape_values(b)*ddsdde(i, j)*area/n_points
            end do
          end do
        end do
      end do
    end do
    do a = 1, n_nodes
      ! nodes 2 and 4 are in the middle
      ahead = 1.0_wp + new%load%spread*(0.25_wp*sum(corner(:, a)))
      force(ntens*(a - 1) + 1) = force(ntens*(a - 1) + 1) + new%load%pressure*area/n_nodes
      do i = 2, ntens
        j = ntens*(a - 1) + i
        force(j) = force(j) + spring*(new%u(i, a) - ahead*new%load%driven(i - 1))
        stiffness(j, j) = stiffness(j, j) + spring
      end do
    end do
  end subroutine assemble

  !> Force of the interface on the upper face, reversed: normal, Tx, Ty.
  pure function total_force(joint) result(force)
    type(joint_type), intent(in) :: joint   !! in equilibrium
    real(wp) :: force(ntens)
    force = sum(joint%stress, 2)*area/n_points
  end function total_force

  !> Separation (N, Tx, Ty) at the points, thickness 1.
  pure function separation(u) result(s)
    real(wp), intent(in) :: u(ntens, n_nodes)   !! displacements
    real(wp) :: s(ntens, n_points)
    integer :: p
    do p = 1, n_points
      s(:, p) = matmul(u, shapes(gauss*corner(:, p)))
    end do
  end function separation

  !> Shape functions.
  pure function shapes(x) result(values)
    real(wp), intent(in) :: x(2)   !! natural coordinates
    real(wp) :: values(n_nodes)
    values = 0.25_wp*(1.0_wp + corner(1, :)*x(1))*(1.0_wp + corner(2, :)*x(2))
  end function shapes

  !> Solve A x = b by elimination with row exchanges.
  pure subroutine solve(a, b)
    real(wp), intent(inout) :: a(:, :)   !! matrix, destroyed
    real(wp), intent(inout) :: b(:)      !! right-hand side -> x
    real(wp) :: row(size(b)), value
    integer :: i, k, n
    n = size(b)
    do k = 1, n
      i = k - 1 + maxloc(abs(a(k:, k)), 1)
      row = a(k, :)
      a(k, :) = a(i, :)
      a(i, :) = row
      value = b(k)
      b(k) = b(i)
      b(i) = value
      do i = k + 1, n
        value = a(i, k)/a(k, k)
        a(i, k:) = a(i, k:) - value*a(k, k:)
        b(i) = b(i) - value*b(k)
      end do
    end do
    do k = n, 1, -1
      b(k) = (b(k) - dot_product(a(k, k + 1:), b(k + 1:)))/a(k, k)
    end do
  end subroutine solve

end module standard_joint
