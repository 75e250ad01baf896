! The law of one plane over an increment, as pure functions in real kind wp. Numbers in brackets are equations of
! Albarella, Serpieri, Alfano, Sacco (2015); the symbols are those of docs/theory.md.
!
! This file is the only source of the law. Each kernel includes it, so that the compiler inlines every function in the
! kernel's loop (over the planes of a point, or over the points of a block) and vectorises that loop. Therefore the
! functions have no branches. Stresses and stiffnesses of a plane are divided by K_t and energies by K_t/2, so that the
! tangential stress of the bond equals the separation. The sum over the planes multiplies by these factors.
!
! update_plane is the law: a kernel calls it for each plane of each point, and sums its results. The functions take the
! separations of the bond and of the contact. On a straight plane both are the same; with a finite height or wear the
! contact lies on a facet (asperity_facet.inc).

!> Kernel for a plane of this slope.
pure function kernel_of(material, slope) result(kernel)
  type(material_type), intent(in) :: material   !! constants of the law
  real(wp), intent(in) :: slope                 !! tan(theta)
  integer :: kernel
  if (material%damps) then
    kernel = kernel_damped
  else if (material%bends .or. (material%guard .and. material%curved)) then
    kernel = kernel_general
  else if (material%guard) then
    kernel = kernel_guarded
  else if (.not. (material%curved .and. slope > 0.0_wp)) then
    kernel = kernel_straight
  else if (material%wears .or. slope > mild_slope) then
    kernel = kernel_worn
  else
    kernel = kernel_facet
  end if
end function kernel_of

!> Constants with the flags of a kernel.
pure function kernel_constants(source, kernel) result(m)
  type(material_type), intent(in) :: source   !! the constants
  integer, intent(in) :: kernel               !! which one, a literal
  type(material_type) :: m
  m = source
  m%guard = kernel == kernel_guarded .or. kernel >= kernel_general
  m%general = kernel >= kernel_facet
  m%wears = kernel >= kernel_worn
  m%bends = kernel >= kernel_general
  m%damps = kernel == kernel_damped
end function kernel_constants

!> Separation of a plane in its axes (2); every plane has the separation of the interface.
pure function local_separation(plane, s) result(local)
  type(plane_type), intent(in) :: plane   !! axes
  type(vector_type), intent(in) :: s      !! separation of the interface, length
  type(local_type) :: local
  local%n = plane%n%n*s%n + (plane%n%x*s%x + plane%n%y*s%y)
  local%t = plane%t%n*s%n + (plane%t%x*s%x + plane%t%y*s%y)
  local%h = plane%h%x*s%x + plane%h%y*s%y
end function local_separation

!> Traction of a plane in the axes of the interface: its term in (3) without the weight.
pure function global_traction(plane, sigma) result(traction)
  type(plane_type), intent(in) :: plane   !! axes
  type(local_type), intent(in) :: sigma   !! traction of the plane
  type(vector_type) :: traction
  traction%n = plane%n%n*sigma%n + plane%t%n*sigma%t
  traction%x = plane%n%x*sigma%n + (plane%t%x*sigma%t + plane%h%x*sigma%h)
  traction%y = plane%n%y*sigma%n + (plane%t%y*sigma%t + plane%h%y*sigma%h)
end function global_traction

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
!> With a dashpot stress and pressure are those of spring and dashpot together (asperity_contact.inc).
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

!> Damage of the bond: (6), (7) and the history (25). With viscosity it is a weighted mean of the old damage and of (7).
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

!> The limit of the growth with the guard: 0 if growing damage would have a negative dissipation, by the trapezoidal
!> rule for Y, and growth%weight_new otherwise.
!>
!> A dissipation that is zero except for rounding is not negative. Thus the result does not depend on the direction of
!> the slip. Without the guard m%unguarded is huge.
pure function guarded_limit(m, growth, start, at, old) result(limit)
  type(material_type), intent(in) :: m             !! constants
  type(growth_type), intent(in) :: growth          !! of the damage
  type(separation_type), intent(in) :: start, at   !! separations at start and end
  type(history_type), intent(in) :: old            !! state at the start
  real(wp) :: limit
  type(growth_type) :: none
  type(response_type) :: now
  real(wp) :: released, size_of
  none = growth
  none%limit = 0.0_wp
  now = plane_response(m, none, start, at, old)
  released = driving_force(m, start, old) + driving_force(m, at, now%new)
  size_of = at%bond%t**2 + at%bond%h**2
  ! energies of the pressure of the bond and on the facet do not cancel exactly, even where these are parallel
  if (m%general) size_of = 2.0_wp*max(1.0_wp, m%kc_kt, contact_stiffness(m, start%bond), contact_stiffness(m, &
    at%bond), contact_stiffness(m, start%contact), contact_stiffness(m, at%contact))*(square(start%bond) + &
    square(at%bond))
  limit = merge(growth%weight_new, 0.0_wp, released >= -(unseen*size_of + m%unguarded))
end function guarded_limit

!> Square of the norm of a vector.
pure function square(s) result(norm_2)
  type(local_type), intent(in) :: s   !! the vector
  real(wp) :: norm_2
  norm_2 = s%n**2 + (s%t**2 + s%h**2)
end function square

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
    energy = (1.0_wp - alpha)*(m%kn_kt*opening(bond)**2 + (bond%t**2 + bond%h**2)) &
      + (alpha*sheared + pressed)
  end associate
end function stored_energy

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

!> Energy that the dashpots of a plane dissipate in an increment, over k_t/2.
!>
!> The stress of a dashpot is the one at the end. A contact that opens faster than its spring pushes carries no tension:
!> no more is lost than the spring had stored.
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

!> Damage of a plane at the start of an increment: no plane has less than damage0.
pure function start_alpha(m, alpha) result(start)
  type(material_type), intent(in) :: m   !! constants
  real(wp), intent(in) :: alpha          !! damage in its state
  real(wp) :: start
  start = max(alpha, m%damage0)
end function start_alpha

!> Update of a plane over an increment: the law.
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
  real(wp) :: crushes, drive, drive_old, elastic
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
  growth = whole
  if (m%guard) growth%limit = guarded_limit(m, whole, at_start, at, old)
  response = plane_response(m, growth, at_start, at, worn)
  now%new = response%new
  now%stored = stored_energy(m, at, response)
  now%spent = plane_dissipation(m, plane_forces(m, at_start, old), plane_forces(m, at, response%new), &
    response%new%alpha - old%alpha, response%friction%slip)
  ! of the viscous parts of pressure and friction only the values at the end are known
  if (m%damps) now%spent%friction = max(0.0_wp, now%spent%friction + (2.0_wp*m%mu)*((response%new%alpha* &
    (response%friction%p - pressure(m, at%contact)))*response%friction%slip))
  if (m%wears) then
    ! work of the friction, and energy that the facet releases
    drive = wear_drive(at%facet, response%new%alpha, response%friction%p, response%friction%stress*response%friction%m_t)
    now%new%wear_work = old%wear_work + merge((0.5_wp*m%k_t)*now%spent%friction, 0.0_wp, drive > 0.0_wp)
    if (m%damps) then
      elastic = wear_drive(at%facet, response%new%alpha, pressure(m, at%contact), at%contact%t - response%new%s_dit)
      now%spent%friction = now%spent%friction + max(0.0_wp, max(drive_old, 0.0_wp) + max(elastic, 0.0_wp) + &
        2.0_wp*(drive - elastic))*(worn%omega - old%omega)
    else
      now%spent%friction = now%spent%friction + (max(drive_old, 0.0_wp) + max(drive, 0.0_wp))*(worn%omega - old%omega)
    end if
  end if
  if (m%damps) now%spent%friction = now%spent%friction + dashpot_dissipation(m, growth, at_start, at, old, response%new)
  now%traction = plane_traction(m, plane, at, response)
  now%tangent = plane_tangent(m, growth, plane, at, to, old, crushes, response)
end function update_plane

!> Factors of friction and of growing damage in the tangent of a plane. At a kink of the law (onset of slip, contact or
!> damage) they are those of one side.
pure function plane_moduli(m, growth, at, old, now) result(moduli)
  type(material_type), intent(in) :: m             !! constants
  type(growth_type), intent(in) :: growth          !! of the damage
  type(separation_type), intent(in) :: at          !! separations at the end
  type(history_type), intent(in) :: old            !! state at the start
  type(response_type), intent(in) :: now           !! response to the increment
  type(moduli_type) :: moduli
  real(wp) :: chi, grows, slips, stuck
  associate (alpha => now%new%alpha, friction => now%friction, gap => at%contact%n, inv_r => now%damage%inv_r)
    ! conditions are reals: gfortran does not vectorise a logical expression of two comparisons
    stuck = merge(merge(1.0_wp, 0.0_wp, gap <= 0.0_wp), 0.0_wp, friction%trial <= friction%strength)
    slips = (1.0_wp - stuck)*merge(1.0_wp, 0.0_wp, gap < 0.0_wp)
    grows = merge(merge(1.0_wp, 0.0_wp, now%damage%free < growth%limit), 0.0_wp, alpha > old%alpha)
    chi = friction%stress*friction%inv_trial
    moduli%tangential = merge(1.0_wp, chi, stuck > 0.0_wp)
    moduli%slip_term = -((slips*alpha)*chi)
    if (m%damps) then
      ! the trial stress changes with that of the dashpot, too
      moduli%tangential = (1.0_wp + growth%lag)*moduli%tangential
      moduli%slip_term = (1.0_wp + growth%lag)*moduli%slip_term
    end if
    moduli%coupling = -((slips*alpha)*(m%mu*friction%stiffness))
    moduli%damage = (grows*growth%weight_eta)*(inv_r*inv_r*inv_r)
    moduli%omega = local_type(0.0_wp, 0.0_wp, 0.0_wp)
  end associate
end function plane_moduli

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

!> Consistent tangent of a plane.
pure function plane_tangent(m, growth, plane, at, s, old, crushes, now) result(tangent)
  type(material_type), intent(in) :: m             !! constants
  type(growth_type), intent(in) :: growth          !! of the damage
  type(plane_type), intent(in) :: plane            !! axes
  type(separation_type), intent(in) :: at          !! separations at the end
  type(vector_type), intent(in) :: s               !! separation of the interface at the end
  type(history_type), intent(in) :: old            !! state at the start
  real(wp), intent(in) :: crushes                  !! worn share if the pressure at the end crushes the facet, else 0
  type(response_type), intent(in) :: now           !! response to the increment
  type(tensor_type) :: tangent
  type(moduli_type) :: moduli
  moduli = plane_moduli(m, growth, at, old, now)
  if (m%wears) moduli%omega = crush_gradient(m, at, s%n, crushes)
  if (m%general) then
    tangent = facet_tangent(m, plane, moduli, at, now)
  else
    tangent = straight_tangent(m, plane, moduli, at, s, now)
  end if
end function plane_tangent

!> Consistent tangent of a straight plane: a I + b n (x) n + m (x) (c m + d n) + w (x) g (docs/theory.md, section 5).
!>
!> It is unsymmetric where the plane slips in contact or its damage grows with slip.
pure function straight_tangent(m, plane, moduli, at, s, now) result(tangent)
  type(material_type), intent(in) :: m             !! constants
  type(plane_type), intent(in) :: plane            !! axes
  type(moduli_type), intent(in) :: moduli          !! factors of friction and damage
  type(separation_type), intent(in) :: at          !! separations at the end
  type(vector_type), intent(in) :: s               !! separation of the interface at the end
  type(response_type), intent(in) :: now           !! response to the increment
  type(tensor_type) :: tangent
  type(vector_type) :: direction, dragged, released, gradient
  real(wp) :: a, b, normal
  associate (n => plane%n, t => plane%t, h => plane%h, local => at%bond, friction => now%friction, &
             alpha => now%new%alpha, new => now%new, c => moduli%slip_term, d => moduli%coupling)
    a = (1.0_wp - alpha) + alpha*moduli%tangential
    b = merge(m%kc_kt, merge(1.0_wp, 1.0_wp - alpha, local%n <= 0.0_wp)*m%kn_kt, local%n < 0.0_wp) - a
    direction = vector_type(t%n*friction%m_t, t%x*friction%m_t + h%x*friction%m_h, &
      t%y*friction%m_t + h%y*friction%m_h)
    dragged = vector_type(c*direction%n + d*n%n, c*direction%x + d*n%x, c*direction%y + d*n%y)
    ! w = sigma_d - sigma_u = -(K_n <s_n>_+, K_t s_di), and its factor in d alpha/d s
    released = global_traction(plane, local_type(-moduli%damage*(m%kn_kt*opening(local)), -moduli%damage*new%s_dit, &
      -moduli%damage*new%s_dih))
    ! s_t t + s_h h = s - s_n n: the gradient needs only n
    normal = m%s02_s01_2*opening(local) - local%n
    gradient = vector_type(m%inv_s02_2*(s%n + n%n*normal), m%inv_s02_2*(s%x + n%x*normal), &
      m%inv_s02_2*(s%y + n%y*normal))
    tangent%nn = (a + b*(n%n*n%n)) + (direction%n*dragged%n + released%n*gradient%n)
    tangent%xn = b*(n%x*n%n) + (direction%x*dragged%n + released%x*gradient%n)
    tangent%yn = b*(n%y*n%n) + (direction%y*dragged%n + released%y*gradient%n)
    tangent%nx = b*(n%x*n%n) + (direction%n*dragged%x + released%n*gradient%x)
    tangent%xx = (a + b*(n%x*n%x)) + (direction%x*dragged%x + released%x*gradient%x)
    tangent%yx = b*(n%y*n%x) + (direction%y*dragged%x + released%y*gradient%x)
    tangent%ny = b*(n%y*n%n) + (direction%n*dragged%y + released%n*gradient%y)
    tangent%xy = b*(n%y*n%x) + (direction%x*dragged%y + released%x*gradient%y)
    tangent%yy = (a + b*(n%y*n%y)) + (direction%y*dragged%y + released%y*gradient%y)
  end associate
end function straight_tangent
