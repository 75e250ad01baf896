!> The law of a rough interface (material and pattern) as the solver sees it.
module asperity_rie_law
  use asperity_aim, only: closing_pressure
  use asperity_call_checks, only: state_status
  use asperity_contract, only: cap_statev, n_facet_statev, n_plane_statev, n_point_statev, n_statev, plane_statev, &
    statev_row, statev_table, status_ok, v_friction, v_offset, v_rupture, v_stored
  use asperity_crushing, only: closed_by, crushing_place, plastic_closure
  use asperity_elimination, only: eliminate
  use asperity_interface, only: interface_type, plane_damage, separation_bound, start_damage
  use asperity_kinds, only: wp
  use asperity_point, only: kinematics_type, plane_kinematics, update_point
  use asperity_pattern, only: plane_normal
  use asperity_point_law, only: call_type, event_length, name_event, point_law, point_type
  use asperity_text, only: append, integer_text, set_text, to_text
  implicit none
  private
  public :: new_rie_law, rate_independent_law, slipped_separation, statev_name

  !> The law of an interface.
  type, extends(point_law), public :: rie_law
    type(interface_type) :: joint   !! material and pattern
  contains
    procedure :: update
    procedure, nopass :: energies
    procedure :: cannot_soften
    procedure :: admissible
    procedure :: bond_pressure
    procedure :: book
    procedure :: magnitude
    procedure :: contact_opening
    procedure :: explain_branch
    procedure :: find_events
    procedure :: state_name
  end type rie_law

  !> Columns of the regime of the planes at a row.
  integer, parameter :: in_contact = 1, is_open = 2, slides_now = 3

contains

  !> The law of an interface.
  pure function new_rie_law(joint) result(law)
    type(interface_type), intent(in) :: joint   !! material and pattern
    type(rie_law) :: law
    law%joint = joint
    law%n_state = joint%n_statev
    law%first_own = n_point_statev + 1
    associate (m => joint%material)
      law%s_0 = m%s0
      law%s_f = m%s0/(1.0_wp - m%eta)
      law%stiffness = max(m%k_n, m%k_t)
      law%least_stiffness = max(tiny(1.0_wp), min(m%k_n, m%k_t, m%k_c))
      law%largest_stiffness = max(m%k_n, m%k_t, m%k_c)
      law%hyperbolic = m%hyperbolic
      law%stress = m%k_n*m%s0
      law%rate_dependent = m%tau_v > 0.0_wp .or. m%damps
      law%wears = m%inv_w0 > 0.0_wp
      law%discontinuous = m%curved .or. m%guard
    end associate
    law%further = crushing_place(joint)
    law%bonded = start_damage(joint, 0.0_wp) < 1.0_wp
    law%bound = separation_bound(joint)
  end function new_rie_law

  !> The law of an interface without viscous damage, dashpot and wear by work: its state does not depend on time or
  !> increments.
  pure function rate_independent_law(joint) result(law)
    type(interface_type), intent(in) :: joint   !! material and pattern
    type(rie_law) :: law
    law = new_rie_law(joint)
    law%joint%material%tau_v = 0.0_wp
    law%joint%material%damping = 0.0_wp
    law%joint%material%damps = .false.
    law%joint%material%inv_w0 = 0.0_wp
    law%rate_dependent = .false.
    law%wears = .false.
  end function rate_independent_law

  !> Separation of the planes: that of the point plus the offset of an initial traction (STATEV 6-8) and the plastic
  !> closure, length.
  pure function whole_separation(joint, s, state) result(whole)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: s(3)                !! separation (N, Tx, Ty), length
    real(wp), intent(in) :: state(:)            !! STATEV
    real(wp) :: whole(3)
    whole = closed_by(s + state(v_offset:v_offset + 2), plastic_closure(joint, state))
  end function whole_separation

  !> Traction, state and consistent tangent at a separation, from the state at another one.
  pure subroutine update(law, call, old, new, requested)
    class(rie_law), intent(in) :: law           !! the law
    type(call_type), intent(in) :: call         !! duration and wear
    type(point_type), intent(in) :: old         !! separation and STATEV at the start
    type(point_type), intent(inout) :: new      !! separation at the end -> traction, tangent and STATEV
    real(wp), intent(out) :: requested          !! 1, as it takes increments of any size
    if (call%draft) then
      call update_point(law%joint, old%s, new%s, old%state, new%state, new%traction, new%tangent, call%duration, &
        call%worn_fraction, new%booked)
    else
      call update_point(law%joint, old%s, new%s, old%state, new%state, new%traction, new%tangent, call%duration, &
        call%worn_fraction)
      new%booked = .true.
    end if
    requested = 1.0_wp
  end subroutine update

  !> Add rupture and friction of a long increment to a state, of which a draft has left them out: they take the time of
  !> several updates, and nothing else depends on them.
  pure subroutine book(law, call, old, new)
    class(rie_law), intent(in) :: law        !! the law
    type(call_type), intent(in) :: call      !! that of the update
    type(point_type), intent(in) :: old      !! separation and STATEV at the start
    type(point_type), intent(inout) :: new   !! the point at the end, whose STATEV is completed
    if (new%booked) return
    call update_point(law%joint, old%s, new%s, old%state, new%state, new%traction, new%tangent, call%duration, &
      call%worn_fraction)
    new%booked = .true.
  end subroutine book

  !> Energies of a state: stored, and dissipated by rupture, friction and wear, stress*length.
  pure function energies(state)
    real(wp), intent(in) :: state(:)    !! STATEV
    real(wp) :: energies(2)
    energies = [state(v_stored), state(v_rupture) + state(v_friction)]
  end function energies

  !> Whether the interface cannot soften: every plane is straight and fully damaged, mu tan(theta) < 1, and the joint is
  !> not crushed. The residual
  !> of a single prescribed t_N then never decreases with s_N. On curved facets the shear traction decreases with slip.
  pure function cannot_soften(law, state) result(yes)
    class(rie_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: state(:)    !! STATEV
    logical :: yes
    associate (joint => law%joint)
      yes = .not. (joint%material%curved .or. joint%cap%peak > 0.0_wp) .and. &
        joint%material%mu*joint%pattern%steepest < 1.0_wp
      if (yes) yes = all(plane_damage(joint, state) >= 1.0_wp)
    end associate
  end function cannot_soften

  !> Whether an update may start from a state.
  pure function admissible(law, state) result(yes)
    class(rie_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: state(:)    !! STATEV
    logical :: yes
    yes = state_status(law%joint, state) == status_ok
  end function admissible

  !> Largest stiffness of a plane times the largest separation or slip, stress. The separation counts with and without
  !> the offset of an initial state: where they cancel, the rounding of both is left.
  pure function magnitude(law, s, state) result(size)
    class(rie_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: s(3)        !! separation (N, Tx, Ty), length
    real(wp), intent(in) :: state(:)    !! STATEV
    real(wp) :: size
    integer :: k
    size = law%largest_stiffness*maxval(abs([s, whole_separation(law%joint, s, state), &
      (state(plane_statev(k) + 1:plane_statev(k) + 2), k=1, law%joint%pattern%n)]))
  end function magnitude

  !> Largest pressure of the bond of a plane that is not fully damaged, stress. Linear pressures are below the stiffness
  !> times the separation, so only those of a hyperbolic closure count.
  pure function bond_pressure(law, s, state) result(largest)
    class(rie_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: s(3)        !! separation (N, Tx, Ty), length
    real(wp), intent(in) :: state(:)    !! STATEV
    real(wp) :: largest
    real(wp) :: alpha(law%joint%pattern%n), normal
    integer :: k
    largest = 0.0_wp
    if (.not. law%hyperbolic) return
    alpha = plane_damage(law%joint, state)
    do k = 1, law%joint%pattern%n
      if (.not. alpha(k) < 1.0_wp) cycle
      normal = dot_product(plane_normal(law%joint%pattern, k), whole_separation(law%joint, s, state))
      largest = max(largest, closing_pressure(law%joint, normal))
    end do
  end function bond_pressure

  !> Smallest separation N, not below zero with the offset, at which no plane is in contact, length.
  pure function contact_opening(law, s, state) result(opening)
    class(rie_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: s(3)        !! separation, of which Tx and Ty are used, length
    real(wp), intent(in) :: state(:)    !! STATEV
    real(wp) :: opening
    type(kinematics_type) :: kinematics
    integer :: k
    opening = 0.0_wp
    do k = 1, law%joint%pattern%n
      kinematics = plane_kinematics(law%joint, k, whole_separation(law%joint, s, state), state)
      opening = max(opening, kinematics%touch)
    end do
    opening = opening - state(v_offset) - plastic_closure(law%joint, state)
  end function contact_opening

  !> Append why the unstable part of a branch cannot be followed: the state at a point of a branch must not depend on
  !> time or on the length of the steps, and must be continuous.
  pure subroutine explain_branch(law, place, message)
    class(rie_law), intent(in) :: law                         !! the law
    character(len=*), intent(in) :: place                     !! before each line
    character(len=:), allocatable, intent(inout) :: message   !! one line per reason is appended
    associate (m => law%joint%material)
      if (m%tau_v > 0.0_wp) call append(message, place // "tau_v = " // to_text(m%tau_v) // &
        ": expected 0, as no time passes on a branch")
      if (m%damps) call append(message, place // "c = " // to_text(m%damping) // &
        ": expected 0, as no time passes on a branch")
      if (m%inv_w0 > 0.0_wp) call append(message, place // "W0 = " // to_text(1.0_wp/m%inv_w0) // &
        ": expected 0, as wear depends on the increments")
      if (m%guard) call append(message, place // &
        "guard = 1: expected 0, as damage that the guard prevents may grow at once later")
    end associate
  end subroutine explain_branch

  !> Names of the events since the last row: damage begins (onset), every plane is fully damaged (damaged), a plane in
  !> contact opens (open), one that was open comes into contact (close), a damaged plane in contact begins to slide
  !> (slip). The planes of a virgin point are neither in contact nor open.
  pure subroutine find_events(law, s, old, new, regime, event)
    class(rie_law), intent(in) :: law                   !! the law
    real(wp), intent(in) :: s(3)                        !! separation (N, Tx, Ty) of this row, length
    real(wp), intent(in) :: old(:)                      !! STATEV of the last row
    real(wp), intent(in) :: new(:)                      !! STATEV of this row
    logical, allocatable, intent(inout) :: regime(:, :) !! of each plane at the last row, not allocated: virgin -> here
    character(len=event_length), intent(out) :: event   !! names joined by +, blank: none
    logical, dimension(law%joint%pattern%n) :: contact, apart, slides
    real(wp), dimension(law%joint%pattern%n) :: damage, was_damage
    logical :: begins
    type(kinematics_type) :: kinematics
    real(wp) :: s_n
    integer :: i, k

    if (.not. allocated(regime)) allocate (regime(law%joint%pattern%n, 3), source=.false.)
    do k = 1, law%joint%pattern%n
      i = plane_statev(k)
      kinematics = plane_kinematics(law%joint, k, whole_separation(law%joint, s, new), new)
      s_n = kinematics%contact(1)
      ! a plane that just touches keeps its values
      contact(k) = s_n < 0.0_wp .or. (regime(k, in_contact) .and. .not. s_n > 0.0_wp)
      apart(k) = s_n > 0.0_wp .or. (regime(k, is_open) .and. .not. s_n < 0.0_wp)
      slides(k) = contact(k) .and. new(i) > 0.0_wp .and. any(abs(new(i + 1:i + 2) - old(i + 1:i + 2)) > 0.0_wp)
    end do
    damage = plane_damage(law%joint, new)
    was_damage = plane_damage(law%joint, old)
    event = ""
    begins = any(damage > start_damage(law%joint, 0.0_wp)) .and. &
      .not. any(was_damage > start_damage(law%joint, 0.0_wp))
    call name_event(event, "onset", begins)
    call name_event(event, "damaged", all(damage >= 1.0_wp) .and. .not. all(was_damage >= 1.0_wp))
    call name_event(event, "open", any(regime(:, in_contact) .and. .not. contact))
    call name_event(event, "close", any(regime(:, is_open) .and. contact))
    call name_event(event, "slip", any(slides .and. .not. regime(:, slides_now)))
    regime(:, in_contact) = contact
    regime(:, is_open) = apart
    regime(:, slides_now) = slides
  end subroutine find_events

  !> Name of a state variable, with the number of its plane.
  pure function state_name(law, i) result(name)
    class(rie_law), intent(in) :: law   !! the law
    integer, intent(in) :: i            !! index in STATEV
    character(len=:), allocatable :: name
    call set_text(name, trim(statev_name(i, law%joint%pattern%n, law%joint%material%wears)))
  end function state_name

  !> The same for a pattern of n planes, padded with blanks.
  pure function statev_name(i, n, wears) result(name)
    integer, intent(in) :: i         !! index in STATEV
    integer, intent(in) :: n         !! planes
    logical, intent(in) :: wears     !! whether W0 or crush > 0
    character(len=16) :: name
    integer :: plane
    plane = (i - n_point_statev + n_plane_statev - 1)/n_plane_statev
    if (i > n_statev(n)) plane = (i - n_statev(n) + n_facet_statev - 1)/n_facet_statev
    name = statev_table(statev_row(i, n, wears))%name
    if (i > n_point_statev .and. i < cap_statev(n, wears)) name = trim(name) // "_" // integer_text(plane)
  end function statev_name

  !> Separation at which the contacts of the planes fit the slips of the planes best (weighted least squares), with the
  !> smallest opening for which no plane is in contact. Gauss-Newton steps; one is enough where the planes are straight.
  pure function slipped_separation(joint, state, free) result(s)
    type(interface_type), intent(in) :: joint       !! the interface
    real(wp), intent(in) :: state(:)                !! STATEV
    logical, intent(in) :: free(3)                  !! components that may move
    real(wp) :: s(3)
    integer, parameter :: most_fits = 20
    !> Change at which the fit ends, relative to the separation; condition number of a fit that is determined.
    real(wp), parameter :: fitted = 1.0e-12_wp, worst_condition = 1.0e9_wp
    real(wp) :: a(3, 3), b(3), largest, opening
    type(kinematics_type) :: kinematics
    integer :: fits, i, j, k
    logical :: solved
    s = 0.0_wp
    do fits = 1, merge(most_fits, 1, joint%material%curved)
      a = 0.0_wp
      b = 0.0_wp
      do k = 1, joint%pattern%n
        i = plane_statev(k)
        kinematics = plane_kinematics(joint, k, s, state)
        associate (t => kinematics%gradient(2, :), h => kinematics%gradient(3, :), gamma => joint%pattern%gamma(k))
          b = b + gamma*((state(i + 1) - kinematics%contact(2))*t + (state(i + 2) - kinematics%contact(3))*h)
          do j = 1, 3
            a(:, j) = a(:, j) + gamma*(t*t(j) + h*h(j))
          end do
        end associate
      end do
      if (.not. any(abs(b) > 0.0_wp)) return
      ! a small stiffness in the normal direction, as flat planes do not determine the opening
      a(1, 1) = a(1, 1) + sqrt(epsilon(1.0_wp))
      do i = 1, 3
        if (free(i)) cycle
        a(i, :) = 0.0_wp
        a(:, i) = 0.0_wp
        a(i, i) = 1.0_wp
        b(i) = 0.0_wp
      end do
      largest = maxval(abs(b))
      call eliminate(3, a, b, solved)
      if (solved) solved = maxval(abs(b)) <= worst_condition*largest
      if (.not. solved) return
      s = s + b
      if (maxval(abs(b)) <= fitted*maxval(abs(s))) exit
    end do
    opening = 0.0_wp
    do k = 1, joint%pattern%n
      kinematics = plane_kinematics(joint, k, s, state)
      opening = max(opening, min(s(1), kinematics%touch))
    end do
    s(1) = opening
  end function slipped_separation

end module asperity_rie_law
