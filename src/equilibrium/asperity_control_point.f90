!> A point under mixed control and its equations: the given value of each component, and the residual of the prescribed
!> tractions.
module asperity_control_point
  use asperity_checks, only: all_bounded
  use asperity_contract, only: plane_statev, v_friction, v_offset, v_rupture, v_stored
  use asperity_interface, only: interface_type, separation_bound
  use asperity_kinds, only: wp
  use asperity_law, only: update_point
  use asperity_tolerances, only: coarsest_scale, farthest_prescribed, finest_scale, instability, longest_step
  implicit none
  private
  public :: control_type, point_type, balance_type, new_point, put_point, move_point, set_balance, evaluate, &
    traction_scale, elastic_stiffness, stiffest, free_part, free_matrix, unstable, work_between, whole_separation, &
    energy_defect, prescribed_bound

  !> Which value of each component (N, Tx, Ty) is given, and the duration of an increment.
  type :: control_type
    logical :: traction(3) = .false.   !! true: traction + spring*separation is given, false: the separation is
    real(wp) :: spring(3) = 0.0_wp     !! stiffness of a surrounding spring (CNS), stress/length
    real(wp) :: dt = 0.0_wp            !! duration of the increment (viscous damage only), >= 0, time
  end type control_type

  !> A point: separation, traction, tangent, state.
  type :: point_type
    real(wp) :: s(3) = 0.0_wp             !! separation (N, Tx, Ty), length
    real(wp) :: traction(3) = 0.0_wp      !! stress
    real(wp) :: tangent(3, 3) = 0.0_wp    !! stress/length
    real(wp) :: work = 0.0_wp             !! work of the traction so far, stress*length
    real(wp), allocatable :: state(:)     !! STATEV
  end type point_type

  !> Equations of a sub-increment: the prescribed tractions at its end, from the state at its start.
  type :: balance_type
    type(control_type) :: control
    real(wp) :: given(3) = 0.0_wp      !! separation, or traction + spring*separation, at the end
    type(point_type) :: old            !! the point at the start
    integer :: n = 0                   !! number of free separations
    integer :: free(3) = 0             !! their components, in the first n
    real(wp) :: damping = 0.0_wp       !! resistance to the motion from the start, stress/length
    real(wp) :: finest = 0.0_wp        !! smallest traction scale, stress
    real(wp) :: coarsest = 0.0_wp      !! largest traction scale due to free separations, as a multiple of strength plus
                                       !! given tractions
    real(wp) :: longest = 0.0_wp       !! longest step if the derivative is singular, as a multiple of the elastic step
  end type balance_type

  !> Positions of the stored and the dissipated energies in STATEV.
  integer, parameter, public :: ledger(3) = [v_stored, v_rupture, v_friction]

contains

  !> A virgin point with zero separation, or a point with the given state and separation. Its work so far is set to the
  !> sum of its stored and dissipated energies.
  pure function new_point(joint, state, separation) result(point)
    type(interface_type), intent(in) :: joint               !! the interface
    real(wp), intent(in), optional :: state(:)              !! STATEV to start from
    real(wp), intent(in), optional :: separation(3)         !! (N, Tx, Ty) to start from, length
    type(point_type) :: point
    real(wp) :: old(joint%n_statev)
    old = 0.0_wp
    if (present(state)) old = state(:joint%n_statev)
    if (present(separation)) point%s = separation
    call put_point(joint, point%s, old, point)
    point%work = sum(point%state(ledger))
  end function new_point

  !> Set the separation and the state of a point, and compute traction and tangent by an update without increment.
  pure subroutine put_point(joint, s, state, point)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in) :: s(3)                    !! separation (N, Tx, Ty), length
    real(wp), intent(in), contiguous :: state(:)    !! STATEV
    type(point_type), intent(inout) :: point        !! -> the point; damage that was delayed may grow in it
    point%s = s
    if (.not. allocated(point%state)) allocate (point%state(joint%n_statev))
    call update_point(joint, s, s, state, point%state, point%traction, point%tangent)
  end subroutine put_point

  !> Separation of the planes: that of the point plus the offset of an initial traction (STATEV 6-8), length.
  pure function whole_separation(s, state) result(whole)
    real(wp), intent(in) :: s(3)       !! separation (N, Tx, Ty), length
    real(wp), intent(in) :: state(:)   !! STATEV
    real(wp) :: whole(3)
    whole = s + state(v_offset:v_offset + 2)
  end function whole_separation

  !> Move a point to another by exchanging their arrays of state variables: no array is copied.
  pure subroutine move_point(from, to)
    type(point_type), intent(inout) :: from   !! the point -> undefined
    type(point_type), intent(inout) :: to     !! any -> the point
    real(wp), allocatable :: room(:), state(:)
    call move_alloc(to%state, room)
    call move_alloc(from%state, state)
    to = from
    call move_alloc(state, to%state)
    call move_alloc(room, from%state)
  end subroutine move_point

  !> Set the equations of a sub-increment; the point at its start does not change.
  pure subroutine set_balance(joint, control, given, balance)
    type(interface_type), intent(in) :: joint        !! the interface
    type(control_type), intent(in) :: control        !! which components are given as tractions
    real(wp), intent(in) :: given(3)                 !! values at the end
    type(balance_type), intent(inout) :: balance     !! the equations
    integer :: i
    balance%control = control
    balance%given = given
    balance%n = 0
    do i = 1, 3
      if (.not. control%traction(i)) cycle
      balance%n = balance%n + 1
      balance%free(balance%n) = i
    end do
    balance%damping = 0.0_wp
    balance%finest = finest_scale*joint%material%k_n*joint%material%s0
    balance%coarsest = coarsest_scale
    balance%longest = longest_step
  end subroutine set_balance

  !> Update the point for free separations x and given other separations, and compute the residual of the prescribed
  !> tractions.
  !>
  !> The state of the point at the start is not tested; it must be admissible (`state_status`).
  pure subroutine evaluate(joint, balance, x, point, residual, scale, good)
    type(interface_type), intent(in) :: joint        !! the interface
    type(balance_type), intent(in) :: balance        !! the equations
    real(wp), intent(in) :: x(3)                     !! free separations in the first n, length
    type(point_type), intent(inout) :: point         !! -> the point with these separations
    real(wp), intent(out) :: residual(3)             !! traction + spring*separation + damping*move - given, stress
    real(wp), intent(out) :: scale                   !! traction scale that `residual_tolerance` refers to, > 0, stress
    logical, intent(out) :: good                     !! false: the separation is out of range, no result
    real(wp) :: given, largest
    integer :: i, k

    residual = 0.0_wp
    scale = 1.0_wp
    point%s = balance%given
    do i = 1, balance%n
      point%s(balance%free(i)) = x(i)
    end do
    good = all_bounded(size(point%s), point%s, separation_bound(joint))
    if (.not. good) return
    if (.not. allocated(point%state)) allocate (point%state(joint%n_statev))
    call update_point(joint, balance%old%s, point%s, balance%old%state, point%state, point%traction, point%tangent, &
      balance%control%dt)
    point%work = balance%old%work + work_between(balance%old%s, balance%old%traction, point%s, point%traction)
    given = 0.0_wp
    do i = 1, balance%n
      k = balance%free(i)
      residual(i) = point%traction(k) + balance%control%spring(k)*x(i) - balance%given(k)
      residual(i) = residual(i) + balance%damping*(x(i) - balance%old%s(k))
      given = max(given, abs(balance%given(k)))
    end do
    ! The scale is bounded: otherwise a residual would count as small if separations grow without bound, in one
    ! increment or over many.
    largest = 0.0_wp
    do i = 1, 3
      if (.not. balance%control%traction(i)) largest = max(largest, abs(point%s(i) + point%state(v_offset + i - 1)))
    end do
    associate (m => joint%material)
      largest = balance%coarsest*(m%k_n*m%s0 + given) + stiffest(joint)*largest
    end associate
    scale = max(tiny(scale), balance%finest, min(traction_scale(joint, point%s, point%state) + given, largest))
  end subroutine evaluate

  !> Size of the terms whose sum is the traction of a point, stress. Rounding errors are proportional to it.
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
      largest = max(largest, max(abs(state(i + 1)), abs(state(i + 2))))
    end do
    scale = stiffest(joint)*largest
  end function traction_scale

  !> Largest stiffness of a plane, stress/length.
  pure function stiffest(joint) result(stiffness)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: stiffness
    stiffness = max(elastic_stiffness(joint), joint%material%k_c)
  end function stiffest

  !> Elastic stiffness of a plane, stress/length.
  pure function elastic_stiffness(joint) result(stiffness)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: stiffness
    stiffness = max(joint%material%k_n, joint%material%k_t)
  end function elastic_stiffness

  !> The free components of a vector in the first n, the others zero.
  pure function free_part(balance, v) result(x)
    type(balance_type), intent(in) :: balance   !! the equations
    real(wp), intent(in) :: v(3)                !! (N, Tx, Ty)
    real(wp) :: x(3)
    integer :: i
    x = 0.0_wp
    do i = 1, balance%n
      x(i) = v(balance%free(i))
    end do
  end function free_part

  !> Derivative of the residual with respect to the free separations, in the upper left n x n, zero elsewhere,
  !> stress/length.
  pure function free_matrix(balance, point) result(a)
    type(balance_type), intent(in) :: balance   !! the equations
    type(point_type), intent(in) :: point       !! the point, its tangent
    real(wp) :: a(3, 3)
    integer :: i, j
    a = 0.0_wp
    do j = 1, balance%n
      do i = 1, balance%n
        a(i, j) = point%tangent(balance%free(i), balance%free(j))
      end do
      a(j, j) = a(j, j) + balance%control%spring(balance%free(j)) + balance%damping
    end do
  end function free_matrix

  !> Whether an equilibrium with this derivative of the residual is unstable: an eigenvalue has a negative real part
  !> (criterion of Routh and Hurwitz). A zero eigenvalue is admitted: an open interface that is fully damaged has no
  !> stiffness.
  pure function unstable(n, a, scale) result(yes)
    integer, intent(in) :: n               !! 0 to 3
    real(wp), intent(in) :: a(3, 3)        !! derivative of the residual
    real(wp), intent(in) :: scale          !! elastic stiffness, stress/length
    logical :: yes
    real(wp) :: b(3, 3), first, second, third
    if (n < 2) then
      yes = n == 1 .and. a(1, 1)/scale < -instability
      return
    end if
    b = a/scale
    select case (n)
    case (2)
      yes = b(1, 1) + b(2, 2) < -instability .or. b(1, 1)*b(2, 2) - b(1, 2)*b(2, 1) < -instability
    case default
      first = b(1, 1) + b(2, 2) + b(3, 3)
      second = b(1, 1)*b(2, 2) - b(1, 2)*b(2, 1) + b(1, 1)*b(3, 3) - b(1, 3)*b(3, 1) + b(2, 2)*b(3, 3) - &
        b(2, 3)*b(3, 2)
      third = b(1, 1)*(b(2, 2)*b(3, 3) - b(2, 3)*b(3, 2)) - b(1, 2)*(b(2, 1)*b(3, 3) - b(2, 3)*b(3, 1)) + &
        b(1, 3)*(b(2, 1)*b(3, 2) - b(2, 2)*b(3, 1))
      yes = first < -instability .or. third < -instability .or. first*second - third < -instability
    end select
  end function unstable

  !> Largest prescribed separation of a load path, length. It is smaller than `separation_bound`, as 1 - eta is a
  !> rounding error at least.
  pure function prescribed_bound(joint) result(bound)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp) :: bound
    bound = farthest_prescribed*joint%material%s0/(1.0_wp - joint%material%eta)
  end function prescribed_bound

  !> Work of the traction on the separation over an increment, by the trapezoidal rule, stress*length.
  pure function work_between(s_old, traction_old, s, traction) result(work)
    real(wp), intent(in) :: s_old(3), s(3)                 !! separation at the start and at the end, length
    real(wp), intent(in) :: traction_old(3), traction(3)   !! traction there, stress
    real(wp) :: work
    work = 0.5_wp*sum((traction_old + traction)*(s - s_old))
  end function work_between

  !> Work of an increment that is neither stored nor dissipated, relative to the energy K s0^2 of a plane at its
  !> strength or to the terms of the balance, whichever is larger. It is an error of the trapezoidal rule, or the energy
  !> that a jump to another branch releases.
  pure function energy_defect(joint, old, new) result(defect)
    type(interface_type), intent(in) :: joint       !! the interface
    type(point_type), intent(in) :: old, new        !! the point at start and end
    real(wp) :: defect
    real(wp) :: change(size(ledger)), work
    work = new%work - old%work
    change = new%state(ledger) - old%state(ledger)
    defect = abs(work - sum(change))/max(joint%material%k_n*joint%material%s0**2, abs(work) + sum(abs(change)))
  end function energy_defect

end module asperity_control_point
