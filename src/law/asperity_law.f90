!> The law of one plane over an increment, as pure functions. Numbers in brackets are equations of Albarella, Serpieri,
!> Alfano, Sacco (2015); the symbols are those of docs/theory.md.
!>
!> update_plane is the law: a kernel calls it for each plane of each point, and sums its results. The parts of the law
!> are modules of their own: contact, facet, wear, energy, tangent. The build merges them with the loop of each kernel
!> (cmake/FortranUnit.cmake), over the planes of a point or over the points of a block, so that the compiler inlines
!> every function in this loop and vectorises it. Therefore the functions have no branches.
!>
!> Stresses and stiffnesses of a plane are divided by K_t and energies by K_t/2, so that the tangential stress of the
!> bond equals the separation. The sum over the planes multiplies by these factors. The functions take the separations
!> of the bond and of the contact. On a straight plane both are the same; with a finite height or wear the contact lies
!> on a facet.
module asperity_law
  use asperity_axes, only: global_traction, local_separation, square
  use asperity_contact, only: add_dashpot, contact_stiffness, opening, pressure
  use asperity_energy, only: dashpot_dissipation, plane_dissipation, plane_forces, stored_energy
  use asperity_facet, only: facet_at, facet_traction, profile_at
  use asperity_kinds, only: wp
  use asperity_phases, only: friction_of_phases, lost_of_phases, phases_of, phases_type, rupture_of_phases, touch_in
  use asperity_tangent, only: plane_tangent
  use asperity_types, only: damage_type, forces_type, friction_type, growth_type, history_type, local_type, &
    material_type, plane_type, response_type, separation_type, unseen, update_type, vector_type
  use asperity_wear, only: wear_drive, worn_share
  implicit none
  private
  public :: growth_over_parts, guarded_release, start_alpha, update_plane

contains

  !> Separations of bond and contact of a plane.
  pure function separations(m, plane, omega, s) result(at)
    type(material_type), intent(in) :: m    !! constants
    type(plane_type), intent(in) :: plane   !! axes
    real(wp), intent(in) :: omega           !! worn share of the facet
    type(vector_type), intent(in) :: s      !! separation of the interface, length
    type(separation_type) :: at
    at%bond = local_separation(plane, s)
    at%contact = at%bond
    if (m%general) then
      at%facet = facet_at(m, plane, 1.0_wp - omega, profile_at(m, plane, 1.0_wp - omega, s), s)
      at%contact = at%facet%s
    end if
  end function separations

  !> Return of the trial stress to the Coulomb cone (30)-(39): the excess over the friction strength becomes slip.
  !>
  !> With a dashpot stress and pressure are those of spring and dashpot together (asperity_contact).
  pure function return_mapping(m, growth, start, s, old) result(friction)
    type(material_type), intent(in) :: m        !! constants
    type(growth_type), intent(in) :: growth     !! effect of the duration
    type(local_type), intent(in) :: start, s    !! separation of the contact at start and end
    type(history_type), intent(in) :: old       !! state at the start
    type(friction_type) :: friction
    real(wp) :: e_t, e_h
    e_t = s%t - old%s_dit
    e_h = s%h - old%s_dih
    if (m%damps) then
      e_t = e_t + growth%lag*(s%t - start%t)
      e_h = e_h + growth%lag*(s%h - start%h)
    end if
    friction%trial = sqrt(e_t**2 + e_h**2)
    friction%inv_trial = 1.0_wp/(friction%trial + tiny(1.0_wp))
    friction%m_t = e_t*friction%inv_trial
    friction%m_h = e_h*friction%inv_trial
    friction%p = pressure(m, s)
    friction%stiffness = contact_stiffness(m, s)
    if (m%damps) call add_dashpot(m, growth%lag, start, s, friction%p, friction%stiffness)
    friction%strength = m%mu*friction%p
    friction%stress = min(friction%trial, friction%strength)
    friction%slip = friction%trial - friction%stress
    if (m%damps) friction%slip = friction%slip/(1.0_wp + growth%lag)
  end function return_mapping

  !> Damage of the bond: (6), (7) and the history (25). With viscosity it is a weighted mean of the old damage and of
  !> (7).
  !>
  !> The expressions use the separation only, not the slip: otherwise rounding would let damage grow at a point whose
  !> separation is constant.
  pure function bond_damage(m, growth, s, alpha_old) result(damage)
    type(material_type), intent(in) :: m       !! constants
    type(growth_type), intent(in) :: growth    !! of the damage
    type(local_type), intent(in) :: s          !! separation of the bond
    real(wp), intent(in) :: alpha_old          !! damage at the start
    type(damage_type) :: damage
    real(wp) :: r
    r = sqrt(max(1.0_wp, m%inv_s01_2*opening(s)**2 + m%inv_s02_2*(s%t**2 + s%h**2)))
    damage%inv_r = 1.0_wp/r
    damage%free = growth%weight_eta*((r - 1.0_wp)*damage%inv_r)
    damage%alpha = max(alpha_old, growth%weight_old*alpha_old + min(growth%limit, damage%free))
  end function bond_damage

  !> Response of a plane to an increment: friction, damage and state at its end.
  pure function plane_response(m, growth, start, at, old) result(now)
    type(material_type), intent(in) :: m             !! constants
    type(growth_type), intent(in) :: growth          !! of the damage
    type(separation_type), intent(in) :: start, at   !! separations at start and end
    type(history_type), intent(in) :: old            !! state at the start
    type(response_type) :: now
    now%friction = return_mapping(m, growth, start%contact, at%contact, old)
    now%damage = bond_damage(m, growth, at%bond, old%alpha)
    now%new = old
    now%new%alpha = now%damage%alpha
    now%new%s_dit = old%s_dit + now%friction%slip*now%friction%m_t
    now%new%s_dih = old%s_dih + now%friction%slip*now%friction%m_h
  end function plane_response

  !> The limit of the growth with the guard: 0 if the rupture of the increment by the trapezoidal rule is negative, and
  !> growth%weight_new otherwise.
  !>
  !> A dissipation that is zero except for rounding is not negative. Thus the result does not depend on the direction of
  !> the slip. Without the guard m%unguarded is huge.
  pure function guarded_limit(m, growth, start, at, grown, rupture) result(limit)
    type(material_type), intent(in) :: m             !! constants
    type(growth_type), intent(in) :: growth          !! of the damage
    type(separation_type), intent(in) :: start, at   !! separations at start and end
    real(wp), intent(in) :: grown                    !! growth of the damage without the guard
    real(wp), intent(in) :: rupture                  !! energy that it releases, over k_t/2
    real(wp) :: limit
    real(wp) :: size_of
    size_of = at%bond%t**2 + at%bond%h**2
    ! energies of the pressure of the bond and on the facet do not cancel exactly, even where these are parallel
    if (m%general) size_of = 2.0_wp*max(1.0_wp, m%kc_kt, contact_stiffness(m, start%bond), contact_stiffness(m, &
      at%bond), contact_stiffness(m, start%contact), contact_stiffness(m, at%contact))*(square(start%bond) + &
      square(at%bond))
    limit = merge(growth%weight_new, 0.0_wp, rupture >= -((0.5_wp*unseen*grown)*size_of + m%unguarded))
  end function guarded_limit

  !> Damage of a plane at the start of an increment: no plane has less than damage0.
  pure function start_alpha(m, alpha) result(start)
    type(material_type), intent(in) :: m   !! constants
    real(wp), intent(in) :: alpha          !! damage in its state
    real(wp) :: start
    start = max(alpha, m%damage0)
  end function start_alpha

  !> Growth of the damage in an increment over that of its parts, each of which takes exponentials. What the parts
  !> release counts for this share. Without viscosity both are the same.
  pure function growth_over_parts(m, whole, plane, to, old, parts) result(ratio)
    type(material_type), intent(in) :: m       !! constants
    type(growth_type), intent(in) :: whole     !! growth of the damage in the increment
    type(plane_type), intent(in) :: plane      !! axes
    type(vector_type), intent(in) :: to        !! separation of the interface at the end, length
    real(wp), intent(in) :: old, parts         !! damage in the state at the start, and after the parts
    real(wp) :: ratio
    type(damage_type) :: ended
    real(wp) :: alpha, grown
    alpha = start_alpha(m, old)
    ended = bond_damage(m, whole, local_separation(plane, to), alpha)
    grown = parts - alpha
    ratio = (ended%alpha - alpha)/merge(max(grown, tiny(1.0_wp)), 1.0_wp, grown > 0.0_wp)
    ratio = merge(ratio, 1.0_wp, merge(grown, 0.0_wp, whole%weight_new < 1.0_wp) > 0.0_wp)
  end function growth_over_parts

  !> What the parts of an increment release with the guard, which decides in each of them and, of the state, for the
  !> increment as a whole: as much as its damage grows.
  pure function guarded_release(old, parts, new, released, whole) result(rupture)
    real(wp), intent(in) :: old, parts, new   !! damage at the start, after the parts, and in the state at the end
    real(wp), intent(in) :: released          !! energy that the parts release
    real(wp), intent(in) :: whole             !! that of the increment as a whole, where no part grows
    real(wp) :: rupture
    rupture = merge(released*(new - old)/merge(max(parts - old, tiny(1.0_wp)), 1.0_wp, parts > old), whole, parts > old)
  end function guarded_release

  !> Update of a plane over an increment: the law.
  !>
  !> A loop with m%exact, which is for the accounts of a long increment alone, takes them by its phases
  !> (asperity_phases), all others by the trapezoidal rule.
  pure function update_plane(m, whole, plane, wearing, crushed, from, to, state) result(now)
    type(material_type), intent(in) :: m            !! constants, with the flags of a kernel
    type(growth_type), intent(in) :: whole          !! growth of the damage that no guard limits
    type(plane_type), intent(in) :: plane           !! axes
    real(wp), intent(in) :: wearing                 !! part of the wear of the increment that is done, 0 to 1
    real(wp), intent(in) :: crushed                 !! share that the pressure at the end crushes
    type(vector_type), intent(in) :: from, to       !! separation of the interface at start and end, length
    type(history_type), intent(in) :: state         !! state of the plane at the start
    type(update_type) :: now
    type(growth_type) :: growth
    type(history_type) :: old, worn
    type(response_type) :: response
    type(separation_type) :: at_start, at
    type(phases_type) :: phases
    type(forces_type) :: last, start
    real(wp) :: crushes, drive, drive_old, elastic, grown, target
    ! gfortran keeps a copy of the whole structure in memory
    old = history_type(start_alpha(m, state%alpha), state%s_dit, state%s_dih, state%omega, state%wear_work)
    at_start = separations(m, plane, old%omega, from)
    worn = old
    drive_old = 0.0_wp
    crushes = 0.0_wp
    if (m%wears) then
      drive_old = wear_drive(at_start%facet, old%alpha, pressure(m, at_start%contact), at_start%contact%t - old%s_dit)
      worn%omega = worn_share(m, drive_old, old, wearing)
      ! the share that the pressure crushes where it does so, else 0
      crushes = merge(crushed, 0.0_wp, crushed > worn%omega)
      worn%omega = max(worn%omega, crushes)
    end if
    at = separations(m, plane, worn%omega, to)
    ! gfortran keeps a copy of the whole structure in memory
    growth = growth_type(whole%weight_old, whole%weight_new, whole%weight_eta, whole%limit, whole%lag)
    response = plane_response(m, growth, at_start, at, worn)
    start = plane_forces(m, at_start, old)
    last = plane_forces(m, at, response%new)
    grown = response%new%alpha - old%alpha
    now%spent = plane_dissipation(m, start, last, grown, response%friction%slip)
    if (m%guard) growth%limit = guarded_limit(m, growth, at_start, at, grown, now%spent%rupture)
    target = response%new%alpha
    if (m%exact) then
      ! what viscosity delays
      target = merge(response%new%alpha, min(old%alpha + grown/growth%weight_new, 1.0_wp), growth%weight_new >= 1.0_wp)
      phases = phases_of(m, growth, at_start, at, old, target)
      now%spent%rupture = max(rupture_of_phases(m, growth, at_start, at, old, response, phases), -m%unguarded)
    end if
    if (m%guard) then
      response%new%alpha = merge(response%new%alpha, old%alpha, growth%limit > 0.0_wp)
      target = merge(target, old%alpha, growth%limit > 0.0_wp)
      now%spent%rupture = merge(now%spent%rupture, 0.0_wp, growth%limit > 0.0_wp)
      last = plane_forces(m, at, response%new)
      now%spent%friction = m%mu*((start%strength + last%strength)*response%friction%slip)
    end if
    now%new = response%new
    now%stored = stored_energy(m, at, response)
    ! of the viscous parts of pressure and friction only the values at the end are known
    if (m%damps) now%spent%friction = max(0.0_wp, now%spent%friction + (2.0_wp*m%mu)*((response%new%alpha* &
      (response%friction%p - pressure(m, at%contact)))*response%friction%slip))
    if (m%exact) then
      ! damage sees the springs of the contact alone, friction the dashpots as well
      if (m%damps) call touch_in(m, .true., growth, at_start, at, old, phases)
      ! the wear by work keeps the trapezoidal rule, which its constants know
      now%spent%friction = merge(friction_of_phases(m, old, target, phases), now%spent%friction, m%inv_w0 <= 0.0_wp)
    end if
    if (m%wears) then
      ! work of the friction, and energy that the facet releases
      drive = wear_drive(at%facet, response%new%alpha, response%friction%p, &
        response%friction%stress*response%friction%m_t)
      now%new%wear_work = old%wear_work + merge((0.5_wp*m%k_t)*now%spent%friction, 0.0_wp, drive > 0.0_wp)
      if (m%damps) then
        elastic = wear_drive(at%facet, response%new%alpha, pressure(m, at%contact), at%contact%t - response%new%s_dit)
        now%spent%friction = now%spent%friction + max(0.0_wp, max(drive_old, 0.0_wp) + max(elastic, 0.0_wp) + &
          2.0_wp*(drive - elastic))*(worn%omega - old%omega)
      else
        now%spent%friction = now%spent%friction + (max(drive_old, 0.0_wp) + max(drive, 0.0_wp))*(worn%omega - old%omega)
      end if
    end if
    if (m%damps .and. .not. m%exact) now%spent%friction = now%spent%friction + &
      dashpot_dissipation(m, growth, at_start, at, old, response%new)
    if (m%damps .and. m%exact) now%spent%friction = now%spent%friction + &
      lost_of_phases(m, growth%lag, at_start, at, old, response%new%alpha, phases)
    now%traction = plane_traction(m, plane, at, response)
    now%tangent = plane_tangent(m, growth, plane, at, to, old, crushes, response)
  end function update_plane

  !> Traction of a plane, bond and contact (11), (13), (22), over k_t, in the axes of the interface.
  pure function plane_traction(m, plane, at, now) result(traction)
    type(material_type), intent(in) :: m        !! constants
    type(plane_type), intent(in) :: plane       !! axes
    type(separation_type), intent(in) :: at     !! separations at the end
    type(response_type), intent(in) :: now      !! response to the increment
    type(vector_type) :: traction
    associate (s => at%bond, friction => now%friction, alpha => now%new%alpha)
      if (m%general) then
        traction = facet_traction(m, plane, at, now)
      else
        traction = global_traction(plane, local_type((1.0_wp - alpha)*(m%kn_kt*opening(s)) - pressure(m, s), &
          (1.0_wp - alpha)*s%t + (alpha*friction%stress)*friction%m_t, &
          (1.0_wp - alpha)*s%h + (alpha*friction%stress)*friction%m_h))
      end if
    end associate
  end function plane_traction

end module asperity_law
