!> A point under mixed control and its equations: what is given of each component, and the residual of what is held.
module control_point
  use asperity_call_checks, only: point_status
  use asperity_checks, only: bounded
  use asperity_contract, only: plane_statev, status_ok, v_friction, v_offset, v_rupture, v_stored
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_law, only: update_point
  implicit none
  private
  public :: control_type, point_type, balance_type, new_point, new_balance, evaluate, free_matrix, solve_linear, &
    unstable, released_energy, work_between, dead_and_open, whole_separation

  !> What is held of each component (N, Tx, Ty), and how long an increment takes.
  type :: control_type
    logical :: traction(3) = .false.   !! true: traction + spring*separation is given, false: the separation is
    real(wp) :: spring(3) = 0.0_wp     !! stiffness of a surrounding spring (CNS), stress/length
    real(wp) :: dt = 0.0_wp            !! duration of the increment (viscous damage only), >= 0, time
  end type control_type

  !> A point and what it carries.
  type :: point_type
    real(wp) :: s(3) = 0.0_wp             !! separation (N, Tx, Ty), length
    real(wp) :: traction(3) = 0.0_wp      !! stress
    real(wp) :: tangent(3, 3) = 0.0_wp    !! stress/length
    real(wp), allocatable :: state(:)     !! STATEV
    real(wp) :: work = 0.0_wp             !! of the traction on the separation so far, stress*length
  end type point_type

  !> Equations of a part of an increment: the held tractions at its end, from the state at its start.
  type :: balance_type
    type(control_type) :: control
    real(wp) :: given(3) = 0.0_wp      !! separation, or traction + spring*separation, at the end
    type(point_type) :: old            !! the point at the start
    integer :: n = 0                   !! free separations
    integer :: free(3) = 0             !! which, in the first n
  end type balance_type

  !> Residual accepted, relative to K max(|s|, |s_di|) + |target|: some hundred units in the last place of the terms
  !> that are summed over the planes.
  real(wp), parameter, public :: residual_tolerance = 1.0e-13_wp

  !> What is stored and dissipated, in STATEV.
  integer, parameter :: ledger(3) = [v_stored, v_rupture, v_friction]

  interface
    !> LAPACK: solve A x = b.
    pure subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
      import :: wp
      implicit none
      integer, intent(in) :: n, nrhs, lda, ldb
      real(wp), intent(inout) :: a(lda, n), b(ldb, nrhs)
      integer, intent(out) :: ipiv(n), info
    end subroutine dgesv
  end interface

contains

  !> A virgin point at rest, or one that starts from a state, at separation zero or a given one. The work that led to it
  !> is taken to be what it has stored and dissipated.
  pure function new_point(joint, state, separation) result(point)
    type(interface_type), intent(in) :: joint               !! the interface
    real(wp), intent(in), optional :: state(:)              !! STATEV to start from
    real(wp), intent(in), optional :: separation(3)         !! (N, Tx, Ty) to start from, length
    type(point_type) :: point
    real(wp) :: old(joint%n_statev)
    old = 0.0_wp
    if (present(state)) old = state(:joint%n_statev)
    if (present(separation)) point%s = separation
    allocate (point%state(joint%n_statev))
    call update_point(joint, point%s, point%s, old, point%state, point%traction, point%tangent)
    point%work = sum(point%state(ledger))
  end function new_point

  !> Separation that the planes see: with the offset of an initial traction (STATEV 6-8), length.
  pure function whole_separation(s, state) result(whole)
    real(wp), intent(in) :: s(3)       !! separation (N, Tx, Ty), length
    real(wp), intent(in) :: state(:)   !! STATEV
    real(wp) :: whole(3)
    whole = s + state(v_offset:v_offset + 2)
  end function whole_separation

  !> Equations of a part of an increment.
  pure function new_balance(control, given, old) result(balance)
    type(control_type), intent(in) :: control   !! what is held
    real(wp), intent(in) :: given(3)            !! its values at the end
    type(point_type), intent(in) :: old         !! the point at the start
    type(balance_type) :: balance
    integer :: i
    balance%control = control
    balance%given = given
    balance%old = old
    do i = 1, 3
      if (.not. control%traction(i)) cycle
      balance%n = balance%n + 1
      balance%free(balance%n) = i
    end do
  end function new_balance

  !> The point at free separations x, the others being as given, and the residual of what is held.
  pure subroutine evaluate(joint, balance, x, point, residual, scale, good)
    type(interface_type), intent(in) :: joint        !! the interface
    type(balance_type), intent(in) :: balance        !! the equations
    real(wp), intent(in) :: x(:)                     !! (n) free separations, length
    type(point_type), intent(inout) :: point         !! state allocated -> the point with these separations
    real(wp), intent(out) :: residual(:)             !! (n) traction + spring*separation - given, stress
    real(wp), intent(out) :: scale                   !! stress that `residual_tolerance` refers to, > 0
    logical, intent(out) :: good                     !! false: the law does not take the separation, nothing is known
    !> Largest scale by free separations, of strength and given tractions: 1e-7 of these is the largest residual.
    real(wp), parameter :: coarsest = 1.0e6_wp
    real(wp) :: given, held(3)
    residual = 0.0_wp
    scale = 1.0_wp
    associate (n => balance%n)
      point%s = balance%given
      point%s(balance%free(:n)) = x(:n)
      good = point_status(joint, balance%old%s, point%s, balance%old%state) == status_ok
      if (.not. good) return
      call update_point(joint, balance%old%s, point%s, balance%old%state, point%state, point%traction, &
        point%tangent, balance%control%dt)
      point%work = balance%old%work + work_between(balance%old%s, balance%old%traction, point%s, point%traction)
      associate (free => balance%free(:n))
        residual(:n) = point%traction(free) + balance%control%spring(free)*x(:n) - balance%given(free)
        given = maxval([0.0_wp, abs(balance%given(free))])
        scale = traction_scale(joint, point%s, point%state) + given
        ! separations that run away do not make their residuals small, neither in an increment nor over many
        held = whole_separation(balance%given, balance%old%state)
        where (balance%control%traction) held = 0.0_wp
        associate (m => joint%material)
          scale = max(tiny(scale), min(scale, coarsest*(m%k_n*m%s0 + given) + stiffest(joint)*maxval(abs(held))))
        end associate
      end associate
    end associate
  end subroutine evaluate

  !> Size of the terms that are summed to the traction of a point, stress: what their rounding errors go with.
  pure function traction_scale(joint, s, state) result(scale)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in) :: s(3)                    !! separation (N, Tx, Ty), length
    real(wp), intent(in) :: state(:)                !! STATEV
    real(wp) :: scale
    real(wp) :: largest
    integer :: i, k
    largest = maxval(abs(whole_separation(s, state)))
    do k = 1, joint%pattern%n
      i = plane_statev(k)
      largest = max(largest, abs(state(i + 1)), abs(state(i + 2)))
    end do
    scale = stiffest(joint)*largest
  end function traction_scale

  !> Largest stiffness of a plane, stress/length.
  pure function stiffest(joint) result(stiffness)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: stiffness
    associate (m => joint%material)
      stiffness = max(m%k_n, m%k_t, m%k_c)
    end associate
  end function stiffest

  !> Derivative of the residual by the free separations, in the upper left n x n, stress/length.
  pure function free_matrix(balance, point) result(a)
    type(balance_type), intent(in) :: balance   !! the equations
    type(point_type), intent(in) :: point       !! the point, its tangent
    real(wp) :: a(3, 3)
    integer :: i
    a = 0.0_wp
    associate (n => balance%n)
      a(:n, :n) = point%tangent(balance%free(:n), balance%free(:n))
      do i = 1, n
        a(i, i) = a(i, i) + balance%control%spring(balance%free(i))
      end do
    end associate
  end function free_matrix

  !> Solve A x = b by LU with row interchanges.
  pure subroutine solve_linear(n, matrix, b, x, good)
    integer, intent(in) :: n                 !! unknowns
    real(wp), intent(in) :: matrix(:, :)     !! (n, n) or larger
    real(wp), intent(in) :: b(:)             !! (n)
    real(wp), intent(out) :: x(:)            !! (n)
    logical, intent(out) :: good             !! false: A is singular
    real(wp) :: a(n, n), right(n, 1)
    integer :: info, pivots(n)
    a = matrix(:n, :n)
    right(:, 1) = b(:n)
    call dgesv(n, 1, a, n, pivots, right, n, info)
    x(:n) = right(:, 1)
    good = info == 0
    if (good) good = all(bounded(x(:n), huge(1.0_wp)))
  end subroutine solve_linear

  !> Whether an overdamped motion leaves an equilibrium with this derivative: an eigenvalue with a negative real part
  !> (Routh and Hurwitz). Zero is not negative: a dead interface floats.
  pure function unstable(n, a, scale) result(yes)
    integer, intent(in) :: n               !! 0 to 3
    real(wp), intent(in) :: a(3, 3)        !! derivative of the residual
    real(wp), intent(in) :: scale          !! elastic stiffness, stress/length
    logical :: yes
    !> Rounding of a sum over the planes and of products of three.
    real(wp), parameter :: rounding = 1.0e-12_wp
    real(wp) :: b(3, 3), first, second, third
    b = a/scale
    select case (n)
    case (0)
      yes = .false.
    case (1)
      yes = b(1, 1) < -rounding
    case (2)
      yes = b(1, 1) + b(2, 2) < -rounding .or. b(1, 1)*b(2, 2) - b(1, 2)*b(2, 1) < -rounding
    case default
      first = b(1, 1) + b(2, 2) + b(3, 3)
      second = b(1, 1)*b(2, 2) - b(1, 2)*b(2, 1) + b(1, 1)*b(3, 3) - b(1, 3)*b(3, 1) + b(2, 2)*b(3, 3) - &
        b(2, 3)*b(3, 2)
      third = b(1, 1)*(b(2, 2)*b(3, 3) - b(2, 3)*b(3, 2)) - b(1, 2)*(b(2, 1)*b(3, 3) - b(2, 3)*b(3, 1)) + &
        b(1, 3)*(b(2, 1)*b(3, 2) - b(2, 2)*b(3, 1))
      yes = first < -rounding .or. third < -rounding .or. first*second - third < -rounding
    end select
  end function unstable

  !> Work of the traction on the separation over an increment, by the trapezoidal rule, stress*length.
  pure function work_between(s_old, traction_old, s, traction) result(work)
    real(wp), intent(in) :: s_old(3), s(3)                 !! separation at the start and at the end, length
    real(wp), intent(in) :: traction_old(3), traction(3)   !! traction there, stress
    real(wp) :: work
    work = 0.5_wp*sum((traction_old + traction)*(s - s_old))
  end function work_between

  !> Energy that a motion under held tractions sets free, per unit area: the work of what is held, less that of the
  !> springs, less what the interface stores and dissipates (docs/solver.md, "Snap").
  pure function released_energy(balance, old, new) result(energy)
    type(balance_type), intent(in) :: balance   !! what is held
    type(point_type), intent(in) :: old, new    !! before and after
    real(wp) :: energy
    real(wp) :: work(3)
    work = (balance%given - 0.5_wp*balance%control%spring*(old%s + new%s))*(new%s - old%s)
    energy = sum(work, mask=balance%control%traction) - sum(new%state(ledger) - old%state(ledger))
  end function released_energy

  !> Whether every plane is broken and apart, so that nothing is carried: exact, the sums are then zero.
  pure function dead_and_open(point) result(yes)
    type(point_type), intent(in) :: point   !! the point
    logical :: yes
    yes = .not. (any(abs(point%traction) > 0.0_wp) .or. any(abs(point%tangent) > 0.0_wp))
  end function dead_and_open

end module control_point
