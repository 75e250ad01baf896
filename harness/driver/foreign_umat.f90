!> The law of a UMAT in a shared library, as the solver sees it.
!>
!> A state consists of the energies per unit area in their places in STATEV of this project, what `u_work` and `u_time`
!> name, STRESS (NTENS) and the STATEV of the UMAT.
module foreign_umat
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_int, c_null_char, c_null_ptr, c_ptr
  use asperity_checks, only: all_bounded
  use asperity_contract, only: v_damage, v_friction, v_rupture, v_stored
  use asperity_kinds, only: wp
  use asperity_point_law, only: point_law
  use asperity_text, only: integer_text
  implicit none
  private
  public :: open_umat, fresh_umat, c_text

  !> Places in a state: work of the traction so far, time; the numbers before STRESS and STATEV.
  integer, parameter, public :: u_work = 5, u_time = 6
  integer, parameter, public :: n_header = 6
  !> Duration that a UMAT is told of a jump, which takes no time, as Abaqus has no increment without time.
  real(wp), parameter :: no_time = 1.0e-12_wp
  !> Separation at which the bond is broken, and largest separation, relative to `length`: that of a UMAT is not known.
  real(wp), parameter, public :: far = 100.0_wp
  real(wp), parameter :: farthest_length = 1.0e10_wp
  !> That the numbers between the arguments are 1.
  integer, parameter, public :: guard_one = -2

  !> Longest path or reason.
  integer, parameter :: longest = 6000

  !> A UMAT with its constants.
  type, extends(point_law), public :: foreign_law
    type(c_ptr), private :: routine = c_null_ptr     !! what umat_call.c knows of it
    logical :: given = .false.                       !! false: the law is that of this project
    character(len=:), allocatable :: library, symbol, order   !! entries of &umat; empty library: this program
    real(wp), allocatable :: props(:)                !! PROPS
    integer :: nstatv = 0                            !! its state variables
    integer :: ntens = 3                             !! its components
    integer :: position(3) = [1, 2, 3]               !! of N, Tx and Ty among them, 0: it has no such component
    real(wp) :: origin = 0.0_wp                      !! time of the UMAT at the start of the load path
    real(wp) :: h = 1.0_wp                           !! thickness by which separations are divided, length
    integer :: damage = 0                            !! its state variable that is the damage, 0: none
    real(wp), allocatable :: first(:)                !! its state variables at the start
  contains
    procedure :: update
    procedure, nopass :: energies
    procedure :: cannot_soften
    procedure :: admissible
    procedure :: magnitude
    procedure :: contact_opening
    procedure :: ask
    procedure :: state_name
    procedure :: virgin
  end type foreign_law

  ! the routines of C act on what the pointer denotes; no result of a law depends on it before `ask`
  interface
    !> Open a library.
    function c_open(library, symbol, message, length) bind(c, name="umat_open") result(routine)
      import :: c_char, c_int, c_ptr
      implicit none
      character(kind=c_char), intent(inout) :: library(*)
      character(kind=c_char), intent(in) :: symbol(*)
      character(kind=c_char), intent(inout) :: message(*)
      integer(c_int), value :: length
      type(c_ptr) :: routine
    end function c_open
    !> Copy what is known of a routine, and set how it is called.
    function c_copy(routine, fresh, checks, guard, absent, name, length) bind(c, name="umat_copy") result(copy)
      import :: c_char, c_int, c_ptr
      implicit none
      type(c_ptr), value :: routine
      integer(c_int), value :: fresh, checks, guard, absent, length
      character(kind=c_char), intent(inout) :: name(*)
      type(c_ptr) :: copy
    end function c_copy
    !> Share of the increment that the routine asks for.
    pure subroutine c_ask(routine, share, message, length) bind(c, name="umat_ask")
      import :: c_char, c_double, c_int, c_ptr
      implicit none
      type(c_ptr), value :: routine
      real(c_double), intent(out) :: share
      character(kind=c_char), intent(inout) :: message(*)
      integer(c_int), value :: length
    end subroutine c_ask
    !> Call a routine.
    pure subroutine c_call(routine, attempt, ntens, nstatv, nprops, props, stran, dstran, time, dtime, counts, stress, &
                           statev, ddsdde, energies, good) bind(c, name="umat_call")
      import :: c_double, c_int, c_ptr
      implicit none
      type(c_ptr), value :: routine
      integer(c_int), value :: attempt, ntens, nstatv, nprops
      real(c_double), intent(in) :: props(*), stran(*), dstran(*), time(2)
      real(c_double), value :: dtime
      integer(c_int), intent(in) :: counts(2)
      real(c_double), intent(inout) :: stress(*), statev(*), ddsdde(*), energies(3)
      integer(c_int), intent(out) :: good
    end subroutine c_call
  end interface

contains

  !> Open the library of a law whose other components are set.
  subroutine open_umat(law, length, stiffness, message)
    type(foreign_law), intent(inout) :: law                       !! the law, complete if nothing is appended
    real(wp), intent(in) :: length                                !! at which the strength is reached
    real(wp), intent(in) :: stiffness                             !! elastic stiffness of the bond
    character(len=:), allocatable, intent(out) :: message         !! empty: it is open
    character(kind=c_char) :: buffer(longest), path(longest)
    integer :: i
    buffer = c_null_char
    law%given = .true.
    law%n_state = n_header + law%ntens + law%nstatv
    law%first_own = u_work
    law%length = length
    law%reach = far*length
    law%stiffness = stiffness
    law%softest = stiffness
    law%stiffest = stiffness
    law%stress = stiffness*length
    law%bound = farthest_length*length
    ! neither is known
    law%jumps = .true.
    law%relaxes = .true.
    path = c_null_char
    path(:len(law%library)) = [(law%library(i:i), i=1, len(law%library))]
    law%routine = c_open(path, law%symbol // c_null_char, buffer, longest)
    law%library = c_text(path)
    message = ""
    if (.not. c_associated(law%routine)) message = c_text(buffer)
  end subroutine open_umat

  !> The same law with a routine of its own, which does not obey PNEWDT, for a check.
  function fresh_umat(law, again, strict, guard, absent, name) result(fresh)
    type(foreign_law), intent(in) :: law            !! any
    logical, intent(in) :: again                    !! whether the library is loaded again
    logical, intent(in), optional :: strict         !! whether arguments that are the host's must not change
    integer, intent(in), optional :: guard          !! guard_one: numbers between the arguments are 1, absent: NaN
    integer, intent(in), optional :: absent         !! argument that is NULL, from 0
    character(len=:), allocatable, intent(out), optional :: name   !! its name, empty: there is none
    type(foreign_law) :: fresh
    character(kind=c_char) :: buffer(16)
    integer :: how(3)
    how = [1, -1, -1]
    if (present(strict)) how(1) = merge(2, 1, strict)
    if (present(guard)) how(2) = guard
    if (present(absent)) how(3) = absent
    buffer = c_null_char
    fresh = law
    fresh%routine = c_copy(law%routine, merge(1_c_int, 0_c_int, again), int(how(1), c_int), int(how(2), c_int), &
      int(how(3), c_int), buffer, size(buffer))
    if (present(name)) name = c_text(buffer)
  end function fresh_umat

  !> Name of a number of a state behind the energies, for a column.
  pure function state_name(law, i) result(name)
    class(foreign_law), intent(in) :: law   !! the law
    integer, intent(in) :: i                !! from u_work on
    character(len=:), allocatable :: name
    if (i <= n_header) then
      name = trim(merge("umat_work", "umat_time", i == u_work))
    else if (i <= n_header + law%ntens) then
      name = "stress_" // integer_text(i - n_header)
    else
      name = "statev_" // integer_text(i - n_header - law%ntens)
    end if
  end function state_name

  !> Text of C up to its end.
  pure function c_text(buffer) result(text)
    character(kind=c_char), intent(in) :: buffer(:)   !! characters
    character(len=:), allocatable :: text
    integer :: i
    text = ""
    do i = 1, size(buffer)
      if (buffer(i) == c_null_char) exit
      text = text // buffer(i)
    end do
  end function c_text

  !> State of a virgin point.
  pure function virgin(law) result(state)
    class(foreign_law), intent(in) :: law   !! the law
    real(wp) :: state(law%n_state)
    state = 0.0_wp
    state(n_header + law%ntens + 1:) = law%first
    if (law%damage > 0) state(v_damage) = law%first(law%damage)
  end function virgin

  !> Traction, state and tangent at separation s. Where the routine gives none, those of an elastic joint, which are not
  !> used: `ask` tells of it.
  pure subroutine update(law, s_old, s, state_old, state, traction, tangent, dt, share)
    class(foreign_law), intent(in) :: law              !! the law
    real(wp), intent(in) :: s_old(3)                   !! separation (N, Tx, Ty) at the start, length
    real(wp), intent(in) :: s(3)                       !! separation at the end, length
    real(wp), intent(in), contiguous :: state_old(:)   !! state at the start
    real(wp), intent(out), contiguous :: state(:)      !! state at the end
    real(wp), intent(out) :: traction(3)               !! traction (N, Tx, Ty) at the end, stress
    real(wp), intent(out) :: tangent(3, 3)             !! d traction_i/d s_j, stress/length
    real(wp), intent(in) :: dt                         !! duration, >= 0, time
    real(wp), intent(in) :: share                      !! not used
    integer, parameter :: ledger(3) = [v_stored, v_friction, v_rupture]
    real(wp) :: before(3), ddsdde(law%ntens, law%ntens), dstran(law%ntens), energies(3), stran(law%ntens), time(2)
    real(wp) :: stress(law%ntens), statev(law%nstatv)
    integer :: i, j
    integer(c_int) :: good
    stran = 0.0_wp
    dstran = 0.0_wp
    before = 0.0_wp
    do i = 1, 3
      if (law%position(i) == 0) cycle
      stran(law%position(i)) = s_old(i)/law%h
      dstran(law%position(i)) = (s(i) - s_old(i))/law%h
      before(i) = state_old(n_header + law%position(i))
    end do
    stress = state_old(n_header + 1:n_header + law%ntens)
    statev = state_old(n_header + law%ntens + 1:)
    energies = state_old(ledger)/law%h
    time = max(0.0_wp, state_old(u_time) - [law%origin + law%began, 0.0_wp])
    call c_call(law%routine, int(law%attempt, c_int), int(law%ntens, c_int), int(law%nstatv, c_int), &
      size(law%props, kind=c_int), law%props, stran, dstran, time, max(dt, no_time), &
      int([law%step, law%increment], c_int), stress, statev, ddsdde, energies, good)
    state = state_old
    traction = before + law%stiffness*(s - s_old)
    tangent = 0.0_wp
    do i = 1, 3
      if (good == 0) tangent(i, i) = law%stiffness
    end do
    if (good == 0) return
    traction = 0.0_wp
    do j = 1, 3
      if (law%position(j) == 0) cycle
      traction(j) = stress(law%position(j))
      do i = 1, 3
        if (law%position(i) > 0) tangent(i, j) = ddsdde(law%position(i), law%position(j))/law%h
      end do
    end do
    state(ledger) = law%h*energies
    state(u_work) = state_old(u_work) + 0.5_wp*sum((before + traction)*(s - s_old))
    state(u_time) = state_old(u_time) + dt
    state(n_header + 1:n_header + law%ntens) = stress
    state(n_header + law%ntens + 1:) = statev
    if (law%damage > 0) state(v_damage) = statev(law%damage)
  end subroutine update

  !> Energies of a state: stored, and the rest of the work. UMATs need not say what they dissipate.
  pure function energies(state)
    real(wp), intent(in) :: state(:)    !! state
    real(wp) :: energies(2)
    energies = [state(v_stored), state(u_work) - state(v_stored)]
  end function energies

  !> A UMAT may soften in every state.
  pure function cannot_soften(law, state) result(yes)
    class(foreign_law), intent(in) :: law   !! not used
    real(wp), intent(in) :: state(:)        !! not used
    logical :: yes
    yes = .false.
  end function cannot_soften

  !> Whether an update may start from a state.
  pure function admissible(law, state) result(yes)
    class(foreign_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: state(:)        !! state
    logical :: yes
    yes = size(state) == law%n_state
    if (yes) yes = all_bounded(size(state), state, huge(1.0_wp))
  end function admissible

  !> Size of the terms whose sum is the traction, stress.
  pure function magnitude(law, s, state) result(size)
    class(foreign_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: s(3)            !! separation (N, Tx, Ty), length
    real(wp), intent(in) :: state(:)        !! state
    real(wp) :: size
    size = max(law%stiffest*maxval(abs(s)), maxval(abs(state(n_header + 1:n_header + law%ntens))))
  end function magnitude

  !> Where the contact of a UMAT ends is not known; it is taken for zero.
  pure function contact_opening(law, s, state) result(opening)
    class(foreign_law), intent(in) :: law   !! not used
    real(wp), intent(in) :: s(3)            !! not used
    real(wp), intent(in) :: state(:)        !! not used
    real(wp) :: opening
    opening = 0.0_wp
  end function contact_opening

  !> Share of the increment that the UMAT asks for by PNEWDT; 0: it has failed.
  pure subroutine ask(law, share, reason)
    class(foreign_law), intent(in) :: law                    !! the law
    real(wp), intent(out) :: share                           !! 0 to 1
    character(len=:), allocatable, intent(inout) :: reason   !! set if it has failed
    character(kind=c_char) :: buffer(longest)
    buffer = c_null_char
    call c_ask(law%routine, share, buffer, size(buffer))
    if (share <= 0.0_wp) reason = c_text(buffer)
  end subroutine ask

end module foreign_umat
