!> The door between a law and the solver: all that the solver knows of a law at a material point.
module asperity_point_law
  use asperity_checks, only: all_bounded
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text, set_text
  implicit none
  private
  public :: name_event

  !> Length of a text that holds all names of events.
  integer, parameter, public :: event_length = 64

  !> A point: separation, traction, tangent, state.
  type, public :: point_type
    real(wp) :: s(3) = 0.0_wp             !! separation (N, Tx, Ty), length
    real(wp) :: traction(3) = 0.0_wp      !! stress
    real(wp) :: tangent(3, 3) = 0.0_wp    !! d traction_i/d s_j, stress/length
    real(wp) :: work = 0.0_wp             !! work of the traction so far, stress*length
    real(wp), allocatable :: state(:)     !! STATEV
    logical :: booked = .true.            !! whether it has the dissipated energies of the last update
  end type point_type

  !> A call of a law: its place in a load path, for routines of a host, and what passes in it.
  type, public :: call_type
    integer :: step = 0, increment = 0       !! of the load path, from 1; 0: before the first one
    integer :: attempt = 0                   !! at an increment or a part of it, counted along the path
    real(wp) :: began = 0.0_wp               !! time at which the step of the load path began
    real(wp) :: duration = 0.0_wp            !! >= 0, time
    real(wp) :: worn_fraction = 0.0_wp       !! part of the wear of the increment that is done, 0 to 1
    logical :: draft = .false.               !! whether dissipated energies may be left out, which `book` adds
  end type call_type

  !> A law that gives the traction of a point for its separation (N, Tx, Ty).
  !>
  !> The traction depends on the separation at the end of an increment, on the state at its start and on the duration.
  !> A law is constant along a load path. The solver takes its own lengths and stresses from the scales. A state begins
  !> with damage, stored energy and the energies spent on rupture and friction, at the positions of the contract.
  type, abstract, public :: point_law
    integer :: n_state = 0                 !! number of state variables
    integer :: further = 0                 !! one that is a dissipated energy beside those of `energies`, 0: none
    integer :: first_own = 5               !! the first of them behind damage and energies that has a column on request
    real(wp) :: s_0 = 0.0_wp               !! separation at which the strength is reached, length
    real(wp) :: s_f = 0.0_wp               !! separation at which the bond is broken, length
    real(wp) :: stiffness = 0.0_wp         !! largest stiffness of the bond, stress/length
    real(wp) :: least_stiffness = 0.0_wp   !! smallest stiffness of the virgin or the closed joint, stress/length
    real(wp) :: largest_stiffness = 0.0_wp !! the largest one, stress/length
    logical :: hyperbolic = .false.        !! whether a closed joint may be stiffer than that
    real(wp) :: stress = 0.0_wp            !! strength, stress
    logical :: bonded = .true.             !! whether a virgin joint has a bond; without one, strength and s_f are names
    real(wp) :: bound = 0.0_wp             !! largest admissible separation, length
    logical :: rate_dependent = .false.    !! whether the duration of an increment matters
    logical :: wears = .false.             !! whether the state at the start of an increment wears the joint in it
    logical :: discontinuous = .false.     !! whether the traction may be a discontinuous function of the separation
  contains
    procedure, non_overridable :: accounts
    procedure :: admissible
    procedure :: bond_pressure
    procedure :: book
    procedure :: cannot_soften
    procedure :: contact_opening
    procedure :: explain_branch
    procedure :: find_events
    procedure :: state_name
    procedure(update_procedure), deferred :: update
    procedure(energies_procedure), deferred, nopass :: energies
    procedure(magnitude_procedure), deferred :: magnitude
  end type point_law

  abstract interface

    !> Traction, state and consistent tangent at a separation, from the state at another one. The input is not tested.
    !>
    !> It is not pure, as it may be a routine of others; that of a joint is. Where the law cannot take the increment,
    !> the solver uses no result.
    subroutine update_procedure(law, call, old, new, requested)
      import :: call_type, point_law, point_type, wp
      implicit none
      class(point_law), intent(in) :: law         !! the law
      type(call_type), intent(in) :: call         !! what passes
      type(point_type), intent(in) :: old         !! separation and state at the start
      type(point_type), intent(inout) :: new      !! separation at the end -> traction, tangent and state, which is
                                                  !! allocated
      real(wp), intent(out) :: requested          !! fraction of the increment that the law can take, 1: all of it
    end subroutine update_procedure

    !> Energies of a state: stored, and dissipated so far, stress*length.
    pure function energies_procedure(state) result(energies)
      import :: wp
      implicit none
      real(wp), intent(in) :: state(:)      !! state
      real(wp) :: energies(2)
    end function energies_procedure

    !> Size of the terms whose sum is the traction, stress. Rounding errors are proportional to it.
    pure function magnitude_procedure(law, s, state) result(size)
      import :: point_law, wp
      implicit none
      class(point_law), intent(in) :: law   !! the law
      real(wp), intent(in) :: s(3)          !! separation (N, Tx, Ty), length
      real(wp), intent(in) :: state(:)      !! state
      real(wp) :: size
    end function magnitude_procedure

  end interface

contains

  !> All energies of a state: stored, and dissipated so far, stress*length.
  pure function accounts(law, state)
    class(point_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: state(:)      !! state
    real(wp) :: accounts(2)
    accounts = law%energies(state)
    if (law%further > 0) accounts(2) = accounts(2) + state(law%further)
  end function accounts

  !> Whether an update may start from a state; by default from any that is finite.
  pure function admissible(law, state) result(yes)
    class(point_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: state(:)      !! state
    logical :: yes
    yes = size(state) == law%n_state
    if (yes) yes = all_bounded(size(state), state, huge(1.0_wp))
  end function admissible

  !> Whether a state cannot soften; a law that does not know may soften in every state.
  pure function cannot_soften(law, state) result(yes)
    class(point_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: state(:)      !! state
    logical :: yes
    yes = .false.
  end function cannot_soften

  !> Smallest separation N, not below zero, at which no part of the joint is in contact, length; a law that does not
  !> know takes zero.
  pure function contact_opening(law, s, state) result(opening)
    class(point_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: s(3)          !! separation, of which Tx and Ty are used, length
    real(wp), intent(in) :: state(:)      !! state
    real(wp) :: opening
    opening = 0.0_wp
  end function contact_opening

  !> Largest pressure of bonds of which only the undamaged part acts, stress: the rounding error of a damage near 1
  !> times this pressure is an error of the traction. A law that does not know takes zero.
  pure function bond_pressure(law, s, state) result(largest)
    class(point_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: s(3)          !! separation (N, Tx, Ty), length
    real(wp), intent(in) :: state(:)      !! state
    real(wp) :: largest
    largest = 0.0_wp
  end function bond_pressure

  !> Add to a state the dissipated energies that an update has left out; by default it has left out none.
  pure subroutine book(law, call, old, new)
    class(point_law), intent(in) :: law      !! the law
    type(call_type), intent(in) :: call      !! that of the update
    type(point_type), intent(in) :: old      !! separation and state at the start
    type(point_type), intent(inout) :: new   !! the point at the end, whose state is completed
  end subroutine book

  !> Append why the unstable part of a branch cannot be followed; a law that does not know follows it.
  pure subroutine explain_branch(law, place, message)
    class(point_law), intent(in) :: law                       !! the law
    character(len=*), intent(in) :: place                     !! before each line
    character(len=:), allocatable, intent(inout) :: message   !! one line per reason is appended
  end subroutine explain_branch

  !> Names of the events since the last row; a law that does not know its regimes has none.
  pure subroutine find_events(law, s, old, new, regime, event)
    class(point_law), intent(in) :: law                  !! the law
    real(wp), intent(in) :: s(3)                         !! separation (N, Tx, Ty) of this row, length
    real(wp), intent(in) :: old(:)                       !! state of the last row
    real(wp), intent(in) :: new(:)                       !! state of this row
    logical, allocatable, intent(inout) :: regime(:, :)  !! what the law remembers of the last row -> of this row
    character(len=event_length), intent(out) :: event    !! names joined by +, blank: none
    event = ""
  end subroutine find_events

  !> Name of a number of a state, for a column.
  pure function state_name(law, i) result(name)
    class(point_law), intent(in) :: law   !! the law
    integer, intent(in) :: i              !! from 1
    character(len=:), allocatable :: name
    call set_text(name, "state_" // integer_text(i))
  end function state_name

  !> Append a name if its event happened.
  pure subroutine name_event(event, name, happened)
    character(len=event_length), intent(inout) :: event   !! names so far
    character(len=*), intent(in) :: name                  !! of the event
    logical, intent(in) :: happened                       !! false: nothing is added
    if (.not. happened) return
    if (len_trim(event) > 0) event = trim(event) // "+"
    event = trim(event) // name
  end subroutine name_event

end module asperity_point_law
