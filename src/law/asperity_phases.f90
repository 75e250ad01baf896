!> Rupture and friction of a long increment of a plane, by its phases along the straight step (docs/theory.md, section
!> 6): the damage grows on a part of the step, the contact is closed on a part, and slips on a part of this.
!>
!> Where the contact lies on a facet or closes by a hyperbola, the step is taken in parts.
!>
!> The module asperity_law says how these functions are used and in which units. x is the position on the step, 0 to 1;
!> the contact is taken to move along a straight line, in which the pressure changes linearly. r = 1/(1 - eta alpha) is
!> 1 + beta (6) on the damage surface. Integrals over r take log(r_2/r_1) = 6 (r_2 - r_1)/(r_1 + r_2 + 4 sqrt(r_1 r_2)).
module asperity_phases
  use asperity_contact, only: closure, closure_under, opening, pressure, pressure_energy
  use asperity_energy, only: bond_energy, driving_force, mode_square
  use asperity_facet, only: exponentials
  use asperity_kinds, only: wp
  use asperity_types, only: growth_type, history_type, local_type, material_type, most_parts, response_type, &
    separation_type, vector_type
  implicit none
  private
  public :: friction_of_phases, growth_of_part, long_increment, lost_of_phases, parts_of, phases_of, phases_type, &
    rupture_of_phases, touch_in

  !> Range of positions on the step, or of r.
  type :: range_type
    real(wp) :: from, to
  end type range_type

  !> Contact along the step.
  type :: touch_type
    type(range_type) :: closed      !! where it is closed
    real(wp) :: e_t, e_h            !! elastic slip on its line at x = 0, length
    real(wp) :: d_t, d_h            !! its change in the step if the contact sticks, length
    real(wp) :: strength, rate      !! mu p where it begins to be closed, and its derivative by x, over k_t
    real(wp) :: ahead               !! how far ahead on that line the stress is, over k_t: what a dashpot adds
    real(wp) :: slips, ends         !! where it begins and ceases to slip
    real(wp) :: last                !! elastic slip where it ceases to be closed, length
    real(wp) :: slip                !! inelastic slip until then without turns, length
    real(wp) :: lost                !! energy that the dashpot along the plane dissipates while it slips, over k_t/2
  end type touch_type

  !> Phases of an increment.
  type :: phases_type
    type(touch_type) :: touch       !! the contact
    type(range_type) :: grows       !! where the damage grows
    type(range_type) :: r           !! 1/(1 - eta alpha) at start and end
    real(wp) :: x_1, x_2, x_3       !! while it grows the contact sticks from x_1 to x_2 and slips to x_3
    real(wp) :: q_1, q_2, q_3       !! sqrt(r) there
    real(wp) :: centre              !! mean position of the growth without viscosity
    real(wp) :: first, second       !! with viscosity it is later: mean delay and half its mean square over what follows
    real(wp) :: followed            !! and its mean after the centre over that without viscosity
  end type phases_type

contains

  !> 1 if an increment is long, else 0: whether the way of the separation is longer than the trapezoidal rule admits.
  !> With viscosity the damage goes a part of the way. Beyond a distance at which the fourth power of a length leaves
  !> the range of numbers none is long.
  pure function long_increment(m, growth, from, to) result(long)
    type(material_type), intent(in) :: m        !! constants
    type(growth_type), intent(in) :: growth     !! of the damage
    type(vector_type), intent(in) :: from, to   !! separation of the interface at start and end, length
    real(wp) :: long
    real(wp), parameter :: distant = 1.0e12_wp
    real(wp) :: distance, way
    way = (to%n - from%n)**2 + ((to%x - from%x)**2 + (to%y - from%y)**2)
    distance = max(to%n**2 + (to%x**2 + to%y**2), from%n**2 + (from%x**2 + from%y**2))
    way = growth%weight_new**2*way
    long = merge(1.0_wp, 0.0_wp, way*m%inv_longest_2 > 1.0_wp)*merge(1.0_wp, 0.0_wp, distance*m%inv_longest_2 < distant)
  end function long_increment

  !> Number of parts of a long increment, for all planes of a joint: if contacts are linear and straight one is enough.
  !> Facets that wear by work need one, too, as the state does not know the wear of the parts.
  pure function parts_of(material) result(parts)
    type(material_type), intent(in) :: material   !! constants with the flags of the material, not of a kernel
    integer :: parts
    parts = merge(most_parts, 1, (material%curved .or. material%hyperbolic) .and. material%inv_w0 <= 0.0_wp)
  end function parts_of

  !> What depends on the duration in a part of an increment. With viscosity the damage tends to that without it as an
  !> exponential, of which an increment takes one step of the backward Euler method.
  pure function growth_of_part(m, whole, length) result(growth)
    type(material_type), intent(in) :: m       !! constants
    type(growth_type), intent(in) :: whole     !! that of the increment
    real(wp), intent(in) :: length             !! of the part, 0 to 1
    type(growth_type) :: growth
    growth = whole
    if (length >= 1.0_wp) return
    call exponentials(m%by_points, length*(whole%weight_new/max(whole%weight_old, tiny(1.0_wp))), growth%weight_old, &
      growth%weight_new)
    growth%weight_eta = growth%weight_new*m%inv_eta
    growth%limit = growth%weight_new
    growth%lag = whole%lag/length
  end function growth_of_part

  !> Quotient within 0 to 1 of a number by one that is not negative; 0 where both are zero.
  pure function share(a, b) result(x)
    real(wp), intent(in) :: a, b   !! dividend and divisor
    real(wp) :: x
    x = max(0.0_wp, min(a, b))/max(b, tiny(1.0_wp))
  end function share

  !> The nearest number of a range.
  pure function clip(x, low, high) result(within)
    real(wp), intent(in) :: x, low, high   !! number and range
    real(wp) :: within
    within = min(max(x, low), high)
  end function clip

  !> Separation at a position of the step.
  pure function along(a, b, x) result(s)
    type(local_type), intent(in) :: a, b   !! separations at start and end
    real(wp), intent(in) :: x              !! position
    type(local_type) :: s
    s = local_type(a%n + (b%n - a%n)*x, a%t + (b%t - a%t)*x, a%h + (b%h - a%h)*x)
  end function along

  !> Elastic slip of the contact, on the line that it follows while it is closed and sticks.
  pure function elastic(touch, x) result(e)
    type(touch_type), intent(in) :: touch   !! contact along the step
    real(wp), intent(in) :: x               !! position
    type(local_type) :: e
    e = local_type(0.0_wp, touch%e_t + touch%d_t*x, touch%e_h + touch%d_h*x)
  end function elastic

  !> Friction strength mu p at a position where the contact is closed, p with the pressure of a dashpot.
  pure function strength(touch, x) result(tau)
    type(touch_type), intent(in) :: touch   !! contact along the step
    real(wp), intent(in) :: x               !! position
    real(wp) :: tau
    tau = max(touch%strength + touch%rate*(x - touch%closed%from), 0.0_wp)
  end function strength

  !> Position where the bond's (1 + beta)^2 reaches a value: a root of one quadratic while s_n > 0 and of another one
  !> while it is not.
  pure function reached(m, a, b, r_2) result(x)
    type(material_type), intent(in) :: m   !! constants
    type(local_type), intent(in) :: a, b   !! separations of the bond at start and end
    real(wp), intent(in) :: r_2            !! the value
    real(wp) :: x
    real(wp) :: c, change, cross, k, open, q, s, turn, w
    change = b%n - a%n
    q = m%inv_s02_2*(a%t**2 + a%h**2)
    k = m%inv_s02_2*(a%t*(b%t - a%t) + a%h*(b%h - a%h))
    w = m%inv_s02_2*((b%t - a%t)**2 + (b%h - a%h)**2)
    cross = share(abs(a%n), abs(change))
    turn = q + cross*(2.0_wp*k + cross*w)
    open = merge(1.0_wp, merge(1.0_wp, 0.0_wp, r_2 < turn), b%n >= 0.0_wp)
    open = merge(open, merge(merge(1.0_wp, 0.0_wp, r_2 >= turn), 0.0_wp, b%n > 0.0_wp), a%n > 0.0_wp)
    open = open*m%inv_s01_2
    c = r_2 - (q + open*a%n**2)
    k = k + open*(a%n*change)
    w = w + open*change**2
    s = sqrt(max(k**2 + w*c, 0.0_wp))
    x = share(merge(c, s - k, k > 0.0_wp), merge(k + s, w, k > 0.0_wp))
  end function reached

  !> 1 + beta of the bond at a position, within the range of the growth.
  pure function surface(m, start, at, x, r) result(within)
    type(material_type), intent(in) :: m             !! constants
    type(separation_type), intent(in) :: start, at   !! separations at start and end
    real(wp), intent(in) :: x                        !! position
    type(range_type), intent(in) :: r                !! 1/(1 - eta alpha) at start and end of the growth
    real(wp) :: within
    within = clip(sqrt(mode_square(m, along(start%bond, at%bond, x))), r%from, r%to)
  end function surface

  !> Where the contact is closed, what it carries there, and where it begins to slip.
  pure function touch_of(m, damped, lag, start, at, old) result(touch)
    type(material_type), intent(in) :: m             !! constants
    logical, intent(in) :: damped                    !! whether dashpots act beside the springs, a literal
    real(wp), intent(in) :: lag                      !! stress of the dashpot (growth_type)
    type(separation_type), intent(in) :: start, at   !! separations at start and end
    type(history_type), intent(in) :: old            !! state at the start
    type(touch_type) :: touch
    !> Largest lag by which the phases change; their fourth powers of lengths contain its square.
    real(wp), parameter :: stiff = merge(1.0e4_wp, 1.0e2_wp, digits(1.0_wp) > 24)
    real(wp) :: a, b, c, cross, excess, last, least, open, root, springs, viscous, width
    type(local_type) :: e, y
    touch%d_t = at%contact%t - start%contact%t
    touch%d_h = at%contact%h - start%contact%h
    cross = share(abs(start%contact%n), abs(at%contact%n - start%contact%n))
    open = merge(1.0_wp, 0.0_wp, start%contact%n > 0.0_wp)
    touch%closed%from = open*merge(cross, 1.0_wp, at%contact%n < 0.0_wp)
    touch%closed%to = merge(merge(cross, 0.0_wp, open < 0.5_wp), 1.0_wp, at%contact%n > 0.0_wp)
    ! a contact that closes carries no stress at first
    touch%e_t = merge(-touch%d_t*touch%closed%from, start%contact%t - old%s_dit, open > 0.5_wp)
    touch%e_h = merge(-touch%d_h*touch%closed%from, start%contact%h - old%s_dih, open > 0.5_wp)
    ! a contact that opens faster than its springs push has no stress, be there friction or not
    if (damped) touch%closed%to = merge(min(touch%closed%to, share(closure(start%contact) - closure_under(m, &
      lag*max(at%contact%n - start%contact%n, 0.0_wp)), max(at%contact%n - start%contact%n, 0.0_wp))), &
      touch%closed%to, at%contact%n > start%contact%n)
    touch%strength = m%mu*pressure(m, start%contact)
    last = m%mu*pressure(m, along(start%contact, at%contact, touch%closed%to))
    width = touch%closed%to - touch%closed%from
    ! never a division by zero, not even in a lane of a vector that is not used
    touch%rate = (last - touch%strength)/max(width, epsilon(1.0_wp))
    touch%ahead = 0.0_wp
    springs = touch%strength
    ! mu times the pressure of a dashpot over its lag: the change of the pressure of linear springs
    viscous = m%mu*m%kc_kt*(start%contact%n - at%contact%n)
    if (damped) then
      touch%ahead = min(lag, stiff)
      touch%strength = max(touch%strength + touch%ahead*viscous, 0.0_wp)
    end if
    ! the stress, |e| without a dashpot, is mu p: a x^2 + 2 b x + c = 0
    a = (touch%d_t**2 + touch%d_h**2) - touch%rate**2
    y = elastic(touch, touch%ahead)
    b = (y%t*touch%d_t + y%h*touch%d_h) - touch%strength*touch%rate
    c = (y%t**2 + y%h**2) - touch%strength**2
    ! where the stress exceeds the strength at both ends, it does in between, if the strength grows faster
    y = elastic(touch, touch%closed%to + touch%ahead)
    excess = (y%t**2 + y%h**2) - strength(touch, touch%closed%to)**2
    least = min(c, excess, -a)
    c = min(c, 0.0_wp)
    root = sqrt(max(b**2 - a*c, 0.0_wp))
    touch%slips = share(merge(-c, root - b, b > 0.0_wp), merge(b + root, a, b > 0.0_wp))
    touch%slips = merge(touch%slips, 1.0_wp, max(a, b) > 0.0_wp)
    touch%slips = merge(1.0_wp, touch%slips, b**2 - a*c < 0.0_wp)
    touch%slips = merge(0.0_wp, touch%slips, least > 0.0_wp)
    touch%slips = merge(merge(touch%closed%from, 1.0_wp, excess > 0.0_wp), touch%slips, open > 0.5_wp)
    touch%slips = max(touch%slips, touch%closed%from)
    touch%ends = max(touch%closed%to, touch%slips)
    ! the phases of a larger lag are the same, its strength is not
    if (damped) touch%strength = max(touch%strength + (lag - touch%ahead)*viscous, 0.0_wp)
    touch%last = strength(touch, touch%closed%to)
    e = elastic(touch, touch%closed%to)
    touch%slip = max(sqrt(e%t**2 + e%h**2) - touch%last, 0.0_wp)
    touch%lost = 0.0_wp
    if (damped) call relax(m, lag, springs + merge(lag*(viscous - touch%rate), 0.0_wp, m%hyperbolic), touch)
  end function touch_of

  !> With a dashpot the elastic slip of a contact that slips tends exponentially to that of the springs alone, in the
  !> direction of the stress where it begins to slip. Set its value where the contact ceases to be closed, the slip
  !> until then, and what the dashpot dissipates.
  pure subroutine relax(m, lag, springs, touch)
    type(material_type), intent(in) :: m       !! constants
    real(wp), intent(in) :: lag                !! stress of the dashpot (growth_type)
    real(wp), intent(in) :: springs            !! strength to which it tends where it begins to be closed
    type(touch_type), intent(inout) :: touch   !! contact along the step; last, slip and lost are set
    type(local_type) :: e, y
    real(wp) :: away_2, from, gone, held, left, size_of, tends, to
    to = max(touch%closed%to, touch%closed%from)
    from = min(touch%slips, to)
    e = elastic(touch, from)
    y = elastic(touch, from + touch%ahead)
    size_of = max(sqrt(y%t**2 + y%h**2), tiny(1.0_wp))
    y = local_type(0.0_wp, y%t/size_of, y%h/size_of)
    held = springs + touch%rate*(from - touch%closed%from)
    call exponentials(m%by_points, (to - from)/max(lag, epsilon(1.0_wp)), left, gone)
    tends = touch%rate*(to - from) + held*gone
    touch%slip = max(sqrt((gone*e%t + (to - from)*touch%d_t)**2 + (gone*e%h + (to - from)*touch%d_h)**2) - tends, &
      0.0_wp)
    touch%last = sqrt((left*e%t + tends*y%t)**2 + (left*e%h + tends*y%h)**2)
    away_2 = (e%t - held*y%t)**2 + (e%h - held*y%h)**2
    touch%lost = max((2.0_wp*lag*touch%rate)*(touch%rate*(to - from) - 2.0_wp*((e%t*y%t + e%h*y%h) - held)*gone) + &
      away_2*((1.0_wp + left)*gone), 0.0_wp)
  end subroutine relax

  !> Phases of an increment in which the damage grows to alpha without viscosity, with the springs of the contact alone.
  pure function phases_of(m, growth, start, at, old, alpha) result(phases)
    type(material_type), intent(in) :: m             !! constants
    type(growth_type), intent(in) :: growth          !! of the damage, without the guard
    type(separation_type), intent(in) :: start, at   !! separations at start and end
    type(history_type), intent(in) :: old            !! state at the start
    real(wp), intent(in) :: alpha                    !! damage at the end
    type(phases_type) :: phases
    real(wp) :: r_0
    associate (grows => phases%grows, r => phases%r)
      r = range_type(1.0_wp/(1.0_wp - m%eta*old%alpha), 1.0_wp/(1.0_wp - m%eta*alpha))
      grows%to = reached(m, start%bond, at%bond, r%to**2)
      grows%from = min(reached(m, start%bond, at%bond, r%from**2), grows%to)
      ! with viscosity damage may lag behind the separation of the start
      grows%from = merge(0.0_wp, grows%from, mode_square(m, start%bond) > (1.0_wp + sqrt(epsilon(1.0_wp)))*r%from**2)
      ! where it lags, it grows at the start
      r_0 = surface(m, start, at, 0.0_wp, r)
      phases%centre = grows%from + (grows%to - grows%from)*share(6.0_wp*(r_0*r%to)/(r_0 + r%to + &
        4.0_wp*sqrt(r_0*r%to)) - r_0, r%to - r_0)
      phases%centre = phases%centre*share((r%to - r_0)*r%from, (r%to - r%from)*r_0)
    end associate
    call touch_in(m, .false., growth, start, at, old, phases)
    call follow(m, growth, phases)
  end function phases_of

  !> Set the phases of the contact: during the growth it sticks from x_1 to x_2, and slips to x_3.
  pure subroutine touch_in(m, damped, growth, start, at, old, phases)
    type(material_type), intent(in) :: m             !! constants
    logical, intent(in) :: damped                    !! whether dashpots act beside the springs, a literal
    type(growth_type), intent(in) :: growth          !! with the stress of the dashpot
    type(separation_type), intent(in) :: start, at   !! separations at start and end
    type(history_type), intent(in) :: old            !! state at the start
    type(phases_type), intent(inout) :: phases       !! those of the growth -> of the contact
    associate (touch => phases%touch, grows => phases%grows, r => phases%r)
      touch = touch_of(m, damped, growth%lag, start, at, old)
      phases%x_1 = clip(touch%closed%from, grows%from, grows%to)
      phases%x_2 = clip(touch%slips, phases%x_1, clip(max(touch%closed%to, touch%closed%from), grows%from, grows%to))
      phases%x_2 = max(phases%x_2, phases%x_1)
      phases%x_3 = max(clip(touch%ends, grows%from, grows%to), phases%x_2)
      phases%q_1 = sqrt(surface(m, start, at, phases%x_1, r))
      phases%q_2 = max(phases%q_1, sqrt(surface(m, start, at, phases%x_2, r)))
      phases%q_3 = max(phases%q_2, sqrt(surface(m, start, at, phases%x_3, r)))
    end associate
  end subroutine touch_in

  !> With viscosity damage follows tau_v behind: the delay of its growth is distributed exponentially, as far as the
  !> increment lasts. Set the means of that after the centre.
  pure subroutine follow(m, growth, phases)
    type(material_type), intent(in) :: m         !! constants
    type(growth_type), intent(in) :: growth      !! of the damage, without the guard
    type(phases_type), intent(inout) :: phases   !! the phases; first, second and followed are set
    !> Times tau_v over what follows between which the means change; beyond them growth is immediate or even.
    real(wp), parameter :: short = 1.0e-3_wp, even = 30.0_wp
    real(wp) :: gone, lag, left
    lag = min((1.0_wp - growth%weight_new)/max(growth%weight_new*(1.0_wp - phases%centre), epsilon(1.0_wp)), even)
    call exponentials(m%by_points, 1.0_wp/max(lag, short), left, gone)
    phases%first = lag - left/gone
    phases%second = lag**2 - (lag + 0.5_wp)*(left/gone)
    phases%followed = growth%weight_new*(1.0_wp/gone - lag)
  end subroutine follow

  !> Integral of f^2/r^2 dr for f that is linear in r = q^2, exact for a constant f and for f ~ r.
  pure function integral(f, g, q_1, q_2) result(sum_of)
    type(local_type), intent(in) :: f, g   !! vectors at both ends
    real(wp), intent(in) :: q_1, q_2       !! roots of r at both ends
    real(wp) :: sum_of
    real(wp) :: mean, r_1, r_2, total, bent
    r_1 = q_1**2
    r_2 = q_2**2
    mean = q_1*q_2
    total = r_1 + r_2 + 4.0_wp*mean
    bent = (f%n*r_2 - g%n*r_1)*(g%n - f%n) + (f%t*r_2 - g%t*r_1)*(g%t - f%t) + (f%h*r_2 - g%h*r_1)*(g%h - f%h)
    sum_of = (f%n*q_2 + g%n*q_1)**2 + (f%t*q_2 + g%t*q_1)**2 + (f%h*q_2 + g%h*q_1)**2
    sum_of = (q_2 - q_1)*(sum_of*total - 2.0_wp*mean*bent)/(((q_1 + q_2)*mean**2)*total)
  end function integral

  !> Energy of the bond over (1 + beta)^2 at a position; at zero separation 0.
  pure function mode_energy(m, start, at, x) result(y)
    type(material_type), intent(in) :: m             !! constants
    type(separation_type), intent(in) :: start, at   !! separations at start and end
    real(wp), intent(in) :: x                        !! position
    real(wp) :: y
    type(local_type) :: s
    s = along(start%bond, at%bond, x)
    y = bond_energy(m, s)/max(mode_square(m, s), tiny(1.0_wp))
  end function mode_energy

  !> Tangential part, or the normal part alone, of a separation.
  pure function sheared(s) result(part)
    type(local_type), intent(in) :: s   !! separation
    type(local_type) :: part
    part = local_type(0.0_wp, s%t, s%h)
  end function sheared

  !> A number as a vector, for the integral.
  pure function single(x) result(vector)
    real(wp), intent(in) :: x   !! the number
    type(local_type) :: vector
    vector = local_type(x, 0.0_wp, 0.0_wp)
  end function single

  !> Energy that growing damage releases in the increment, over k_t/2.
  pure function rupture_of_phases(m, growth, start, at, old, now, phases) result(rupture)
    type(material_type), intent(in) :: m             !! constants
    type(growth_type), intent(in) :: growth          !! of the damage, without the guard
    type(separation_type), intent(in) :: start, at   !! separations at start and end
    type(history_type), intent(in) :: old            !! state at the start
    type(response_type), intent(in) :: now           !! response to the increment
    type(phases_type), intent(in) :: phases          !! its phases
    real(wp) :: rupture
    type(local_type) :: at_1, at_2
    real(wp) :: grown, lag, y, y_c, y_e, y_m
    associate (r => phases%r, touch => phases%touch, q_1 => phases%q_1, q_2 => phases%q_2, q_3 => phases%q_3)
      grown = now%new%alpha - old%alpha
      y = (mode_energy(m, start, at, phases%grows%from)*r%from + mode_energy(m, start, at, phases%grows%to)*r%to)/ &
        (r%from + r%to)
      at_1 = along(start%bond, at%bond, phases%x_1)
      at_2 = along(start%bond, at%bond, phases%x_2)
      ! outside the phase of sticking, where bond and contact cancel term by term
      rupture = y*((r%to - r%from) - (q_2**2 - q_1**2))
      rupture = rupture + (integral(sheared(at_1), sheared(at_2), q_1, q_2) - &
        integral(elastic(touch, phases%x_1), elastic(touch, phases%x_2), q_1, q_2))
      rupture = rupture - integral(single(strength(touch, phases%x_2)), single(strength(touch, phases%x_3)), q_2, q_3)
      if (m%general) rupture = rupture + m%kn_kt*integral(single(opening(at_1)), single(opening(at_2)), q_1, q_2) + &
        (pressed(m, start%bond, at%bond, phases) - pressed(m, start%contact, at%contact, phases))
      rupture = rupture*m%inv_eta
      ! with viscosity the damage may lag behind the separation of the start, and catches up with it there
      lag = max(surface(m, start, at, 0.0_wp, r) - r%from, 0.0_wp)*m%inv_eta
      rupture = rupture + lag*(driving_force(m, start, old)/(r%from*(r%from + lag*m%eta)) - &
        mode_energy(m, start, at, 0.0_wp))
      ! and then follows it: the driving force by a parabola from the centre of the growth to the end
      y_c = release_at(m, start, at, touch, phases%centre)
      y_m = release_at(m, start, at, touch, 0.5_wp*(phases%centre + 1.0_wp))
      y_e = release_at(m, start, at, touch, 1.0_wp)
      rupture = growth%weight_new*rupture + grown*((4.0_wp*y_m - 3.0_wp*y_c - y_e)*phases%first + &
        4.0_wp*(y_c - 2.0_wp*y_m + y_e)*phases%second)
      rupture = merge(rupture, 0.0_wp, grown > 0.0_wp)
    end associate
  end function rupture_of_phases

  !> Driving force of damage at a position.
  pure function release_at(m, start, at, touch, x) result(y)
    type(material_type), intent(in) :: m             !! constants
    type(separation_type), intent(in) :: start, at   !! separations at start and end
    type(touch_type), intent(in) :: touch            !! contact along the step
    real(wp), intent(in) :: x                        !! position
    real(wp) :: y
    type(local_type) :: bond, e
    bond = along(start%bond, at%bond, x)
    e = elastic(touch, x)
    y = bond_energy(m, bond) - min(e%t**2 + e%h**2, strength(touch, x)**2)
    if (m%general) y = y + (pressure_energy(m, bond) - pressure_energy(m, along(start%contact, at%contact, x)))
  end function release_at

  !> Integral of the energy of the pressure over the damage, times eta.
  pure function pressed(m, a, b, phases) result(energy)
    type(material_type), intent(in) :: m          !! constants
    type(local_type), intent(in) :: a, b          !! separations of bond or contact at start and end
    type(phases_type), intent(in) :: phases       !! phases of the increment
    real(wp) :: energy
    energy = integral(single(sqrt(pressure_energy(m, along(a, b, phases%grows%from)))), &
      single(sqrt(pressure_energy(m, along(a, b, phases%grows%to)))), sqrt(phases%r%from), sqrt(phases%r%to))
  end function pressed

  !> Integral of the damage over a range of positions; r is taken to be linear while it grows.
  pure function damaged(m, old, alpha, phases, from, to) result(sum_of)
    type(material_type), intent(in) :: m         !! constants
    type(history_type), intent(in) :: old        !! state at the start
    real(wp), intent(in) :: alpha                !! damage at the end
    type(phases_type), intent(in) :: phases      !! phases of the increment
    real(wp), intent(in) :: from, to             !! positions, from <= to
    real(wp) :: sum_of
    real(wp) :: mean, r_1, r_2, x_1, x_2
    associate (grows => phases%grows, r => phases%r)
      x_1 = clip(grows%from, from, to)
      x_2 = clip(grows%to, from, to)
      r_1 = r%from + (r%to - r%from)*share(x_1 - grows%from, grows%to - grows%from)
      r_2 = r%from + (r%to - r%from)*share(x_2 - grows%from, grows%to - grows%from)
      mean = m%inv_eta*(1.0_wp - 6.0_wp/(r_1 + r_2 + 4.0_wp*sqrt(r_1*r_2)))
      sum_of = old%alpha*(x_1 - from) + min(mean, alpha)*(x_2 - x_1) + alpha*(to - x_2)
    end associate
  end function damaged

  !> Energy dissipated by the dashpots in the increment, over k_t/2: while the contact is closed, and what its springs
  !> store where it ceases to push.
  pure function lost_of_phases(m, lag, start, at, old, alpha, phases) result(lost)
    type(material_type), intent(in) :: m             !! constants
    real(wp), intent(in) :: lag                      !! stress of the dashpot (growth_type)
    type(separation_type), intent(in) :: start, at   !! separations at start and end
    type(history_type), intent(in) :: old            !! state at the start
    real(wp), intent(in) :: alpha                    !! damage at the end
    type(phases_type), intent(in) :: phases          !! phases of the increment with the dashpot
    real(wp) :: lost
    real(wp) :: across, along_it, free, gone, left, short, to
    associate (touch => phases%touch)
      across = m%kc_kt*(at%contact%n - start%contact%n)**2
      along_it = touch%d_t**2 + touch%d_h**2
      to = max(touch%closed%to, touch%closed%from)
      lost = across*damaged(m, old, alpha, phases, touch%closed%from, to) + &
        along_it*damaged(m, old, alpha, phases, touch%closed%from, clip(touch%slips, touch%closed%from, to))
      lost = (2.0_wp*lag)*lost + touch%lost*(damaged(m, old, alpha, phases, touch%slips, touch%ends)/ &
        max(touch%ends - touch%slips, epsilon(1.0_wp)))
      free = max(pressure_energy(m, along(start%contact, at%contact, to)) - pressure_energy(m, at%contact), 0.0_wp)
      short = max(lag, epsilon(1.0_wp))
      call exponentials(m%by_points, (2.0_wp*(1.0_wp - to))/short, left, gone)
      free = merge(free + gone*touch%last**2, 0.0_wp, at%contact%n > start%contact%n)
      short = max(min(short, 1.0_wp - to), epsilon(1.0_wp))
      lost = lost + free*(damaged(m, old, alpha, phases, to, to + short)/short)
    end associate
  end function lost_of_phases

  !> Energy dissipated by the friction of springs in the increment, over k_t/2.
  !>
  !> The rate of the slip is constant while the contact slips. Where the direction of the stress turns into that of the
  !> slip, the slip is longer than that of the increment, by a fit.
  pure function friction_of_phases(m, old, alpha, phases) result(friction)
    type(material_type), intent(in) :: m         !! constants
    type(history_type), intent(in) :: old        !! state at the start
    real(wp), intent(in) :: alpha                !! damage at the end without viscosity
    type(phases_type), intent(in) :: phases      !! phases of the increment
    real(wp) :: friction
    real(wp) :: far, first, from, mean, p_0, p_1, p_2, p_3, part, slip, to, turn, way, x_1, x_2
    type(local_type) :: e
    associate (touch => phases%touch, q_2 => phases%q_2, q_3 => phases%q_3)
      from = touch%slips
      to = touch%ends
      ! as a product: of a merge that is compared below gfortran makes no vectors
      slip = touch%slip*merge(1.0_wp, 0.0_wp, touch%closed%to > touch%closed%from)
      p_0 = strength(touch, from)
      p_3 = strength(touch, to)
      way = sqrt(touch%d_t**2 + touch%d_h**2)
      e = elastic(touch, from + touch%ahead)
      turn = 1.0_wp - share(e%t*touch%d_t + e%h*touch%d_h, sqrt(e%t**2 + e%h**2)*way)
      way = way*(to - from)
      first = min(p_0, p_3)
      part = share(way, way + first)
      far = part**3/(part**3 + (1.0_wp - part)*(1.6_wp*part**2 + (1.0_wp - part)*(part + 12.0_wp*(1.0_wp - part))))
      turn = turn*(0.5_wp - turn*(0.125_wp + 0.068_wp*turn))*(first*far)
      slip = slip + merge(merge(turn, 0.0_wp, slip > 0.0_wp), 0.0_wp, p_0 > 0.0_wp)
      ! alpha is that of the start, grows, and is that of the end
      x_1 = clip(merge(phases%grows%from, 1.0_wp, alpha > old%alpha), from, to)
      x_2 = clip(merge(phases%grows%to, 1.0_wp, alpha > old%alpha), from, to)
      p_1 = strength(touch, x_1)
      p_2 = strength(touch, x_2)
      ! mean of p/r for p that is linear in r
      mean = (p_1*(5.0_wp*q_3 + q_2) + p_2*(q_3 + 5.0_wp*q_2))/((q_2**2 + q_3**2 + 4.0_wp*q_2*q_3)*(q_2 + q_3))
      friction = 0.5_wp*(old%alpha*(p_0 + p_1)*(x_1 - from) + alpha*(p_2 + p_3)*(to - x_2)) + &
        (x_2 - x_1)*m%inv_eta*(0.5_wp*(p_1 + p_2) - mean)
      ! with viscosity alpha grows less and later
      mean = 0.5_wp*(to - from)*(old%alpha*(p_0 + p_3))
      friction = merge(mean + phases%followed*(friction - mean), friction, phases%followed < 1.0_wp)
      friction = 2.0_wp*slip*(friction/max(to - from, tiny(1.0_wp)))
    end associate
  end function friction_of_phases

end module asperity_phases
