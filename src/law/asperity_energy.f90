!> Energies of a plane: stored, released by damage, and dissipated in an increment.
!>
!> The module asperity_law says how these functions are used and in which units.
module asperity_energy
  use asperity_contact, only: closure, opening, pressure, pressure_energy
  use asperity_kinds, only: wp
  use asperity_types, only: dissipation_type, forces_type, growth_type, history_type, local_type, material_type, &
    response_type, separation_type
  implicit none
  private
  public :: bond_energy, dashpot_dissipation, driving_force, mode_square, plane_dissipation, plane_forces, stored_energy

contains

  !> Energy of the bond except for that of a pressure, over k_t/2.
  pure function bond_energy(m, bond) result(energy)
    type(material_type), intent(in) :: m    !! constants
    type(local_type), intent(in) :: bond    !! separation
    real(wp) :: energy
    energy = m%kn_kt*opening(bond)**2 + (bond%t**2 + bond%h**2)
  end function bond_energy

  !> Driving force of damage Y, over k_t/2: the energy stored in the bond minus the energy stored in the contact.
  !>
  !> On a straight plane the energy of the pressure is the same in both and cancels. Y is exactly zero if a closed
  !> straight plane has never slipped.
  pure function driving_force(m, at, state) result(y)
    type(material_type), intent(in) :: m      !! constants
    type(separation_type), intent(in) :: at   !! separations
    type(history_type), intent(in) :: state   !! state of the plane
    real(wp) :: y
    associate (bond => at%bond, contact => at%contact)
      y = m%kn_kt*opening(bond)**2 + ((bond%t**2 + bond%h**2) - ((contact%t - state%s_dit)**2 + &
        (contact%h - state%s_dih)**2))
      if (m%general) y = y + (pressure_energy(m, bond) - pressure_energy(m, contact))
    end associate
  end function driving_force

  !> The square of 1 + beta, beta of (6).
  pure function mode_square(m, bond) result(r_2)
    type(material_type), intent(in) :: m    !! constants
    type(local_type), intent(in) :: bond    !! separation
    real(wp) :: r_2
    r_2 = m%inv_s01_2*opening(bond)**2 + m%inv_s02_2*(bond%t**2 + bond%h**2)
  end function mode_square

  !> Driving force of damage and friction strength of a plane in the given state.
  pure function plane_forces(m, at, state) result(forces)
    type(material_type), intent(in) :: m       !! constants
    type(separation_type), intent(in) :: at    !! separations
    type(history_type), intent(in) :: state    !! state of the plane
    type(forces_type) :: forces
    forces%y = driving_force(m, at, state)
    forces%strength = state%alpha*pressure(m, at%contact)
  end function plane_forces

  !> Energies that a plane dissipates in an increment, over k_t/2, by the trapezoidal rule: Y d alpha for rupture, and
  !> the friction strength alpha mu p times the slip for friction.
  pure function plane_dissipation(m, start, now, growth, slip) result(spent)
    type(material_type), intent(in) :: m         !! constants
    type(forces_type), intent(in) :: start, now   !! at the start and at the end
    real(wp), intent(in) :: growth                !! of the damage
    real(wp), intent(in) :: slip                  !! increment of the inelastic slip, length
    type(dissipation_type) :: spent
    spent%rupture = 0.5_wp*((start%y + now%y)*growth)
    spent%friction = m%mu*((start%strength + now%strength)*slip)
  end function plane_dissipation

  !> Energy stored in the bond and the contact of a plane, over k_t/2.
  pure function stored_energy(m, at, now) result(energy)
    type(material_type), intent(in) :: m      !! constants
    type(separation_type), intent(in) :: at   !! separations at the end
    type(response_type), intent(in) :: now    !! response to the increment
    real(wp) :: energy, pressed, sheared
    associate (bond => at%bond, alpha => now%new%alpha)
      pressed = pressure_energy(m, bond)
      if (m%general) pressed = (1.0_wp - alpha)*pressed + alpha*pressure_energy(m, at%contact)
      sheared = now%friction%stress**2
      if (m%damps) sheared = (at%contact%t - now%new%s_dit)**2 + (at%contact%h - now%new%s_dih)**2
      energy = (1.0_wp - alpha)*bond_energy(m, bond) + (alpha*sheared + pressed)
    end associate
  end function stored_energy

  !> Energy that the dashpots of a plane dissipate in an increment, over k_t/2.
  !>
  !> The stress of a dashpot is the one at the end. A contact that opens faster than its spring pushes carries no
  !> tension: no more is lost than the spring had stored.
  pure function dashpot_dissipation(m, growth, start, at, old, new) result(lost)
    type(material_type), intent(in) :: m             !! constants
    type(growth_type), intent(in) :: growth          !! effect of the duration
    type(separation_type), intent(in) :: start, at   !! separations at start and end
    type(history_type), intent(in) :: old, new       !! state at start and end
    real(wp) :: lost
    real(wp) :: across, along, freed
    across = closure(at%contact) - closure(start%contact)
    freed = pressure_energy(m, start%contact) - pressure_energy(m, at%contact)
    freed = merge(max(freed, 0.0_wp), huge(1.0_wp), across < 0.0_wp)
    across = min((2.0_wp*growth%lag*m%kc_kt)*across**2, freed)
    along = ((at%contact%t - start%contact%t) - (new%s_dit - old%s_dit))**2 + &
      ((at%contact%h - start%contact%h) - (new%s_dih - old%s_dih))**2
    lost = new%alpha*(across + (2.0_wp*growth%lag)*along)
  end function dashpot_dissipation

end module asperity_energy
