!> Warnings about an interface whose constants are admissible but outside the law's range of validity: measures, the
!> limits above which a user is warned, and the sentences. Driver and Python take all three from here.
module asperity_warnings
  use asperity_contract, only: n_fixed_props, p_eta, p_gc, p_gc2, p_sigma0, p_sigma02, p_theta, status_ok
  use asperity_interface, only: interface_type, new_interface, start_damage
  use asperity_kinds, only: wp
  use asperity_material, only: largest_closure_share, material_type
  use asperity_text, only: short
  implicit none
  private
  public :: measures, warned, warning_text, increment_text, largest_slip_increment, climbed_height

  !> The measures. Those of the contact assume that the inclined plane of the smallest weight carries the whole
  !> pressure. Those up to m_tension are known before a run.
  integer, parameter, public :: m_modes = 1, &   !! 1 if strength or energy of mode II differ from those of mode I
    m_locking = 2, &       !! mu tan(theta) of the steepest plane; 0 where a finite height ends the climb, or with crush
    m_radians = 3, &       !! inclination of a regular pattern, degrees, where it may have been meant in radians
    m_low = 4, &           !! s_f over the asperity height
    m_tension = 5, &       !! largest normal traction over the strength
    m_soft = 6, &          !! closure over s_f
    m_deep = 7, &          !! closure over the asperity height
    m_runaway = 8, &       !! elastic energy of the friction over W0
    m_let_go = 9, &        !! this energy over W0, times the climbed height over the closure, where planes share it
    m_steep = 10, &        !! closure over the largest closure Vm
    m_lasting = 11, &      !! with crush, mu tan(theta) of the steepest plane
    m_late = 12, &         !! with crush, K_t over the secant stiffness of the contact
    m_brittle = 13, &      !! with fc, fc^2/Gfc over the stiffness of the closed joint
    n_measures = 13

  !> Limits: a larger measure gives a warning.
  real(wp), parameter, public :: limits(n_measures) = [0.0_wp, nearest(1.0_wp, -1.0_wp), 0.0_wp, 1.0_wp, &
    nearest(1.0_wp, -1.0_wp), 0.1_wp, 0.1_wp, 0.01_wp, 1.0_wp, largest_closure_share, nearest(1.0_wp, -1.0_wp), &
    0.1_wp + epsilon(1.0_wp), nearest(1.0_wp, -1.0_wp)]
  !> Length of a text that holds each sentence.
  integer, parameter, public :: text_size = 240
  !> Inclinations (degrees) below this may have been meant in radians: a right angle is 1.57.
  real(wp), parameter :: largest_radian = 1.6_wp

contains

  !> Measures of an interface under a pressure, a normal traction and a slip; 0 where a measure has no meaning.
  pure function measures(props, pressure, tension, slip) result(values)
    real(wp), intent(in), contiguous :: props(:)   !! PROPS, admissible
    real(wp), intent(in) :: pressure               !! largest pressure, >= 0, stress
    real(wp), intent(in) :: tension                !! largest prescribed normal traction, stress
    real(wp), intent(in) :: slip                   !! largest slip, >= 0, length
    real(wp) :: values(n_measures)
    type(interface_type) :: joint
    real(wp) :: closure, s_f, stress
    integer :: status

    values = 0.0_wp
    call new_interface(props, joint, status)
    if (status /= status_ok) return
    if (joint%cap%peak > 0.0_wp) values(m_brittle) = joint%cap%peak/joint%cap%length* &
      (joint%cap%peak/(joint%cap%peak - joint%cap%residual))/ &
      (joint%material%k_c*stiffening(joint%material, closure_under(joint%material, joint%cap%peak)))
    associate (material => joint%material, n => joint%pattern%n, damage => start_damage(joint, 0.0_wp))
      stress = stress_alone(joint, pressure)
      closure = closure_under(material, stress)
      values(m_steep) = closure*material%inv_largest_closure
      s_f = 0.0_wp
      ! without a bond there is no strength, and s_f is no length of the joint
      if (damage < 1.0_wp) then
        s_f = 2.0_wp*props(p_gc)/props(p_sigma0)
        if (differs(props, p_sigma02, p_sigma0) .or. differs(props, p_gc2, p_gc)) values(m_modes) = 1.0_wp
        values(m_tension) = max(0.0_wp, tension)/props(p_sigma0)* &
          ((1.0_wp - props(p_eta)*damage)/(1.0_wp - damage))
      end if
      if (.not. any(joint%pattern%sin_theta(:n) > 0.0_wp)) return
      if (size(props) <= n_fixed_props) then
        if (props(p_theta) < largest_radian) values(m_radians) = props(p_theta)
      end if
      if (material%kt_crush > 0.0_wp) then
        values(m_lasting) = material%mu*joint%pattern%steepest
        values(m_late) = material%k_t/(material%k_c + stress*material%inv_largest_closure)
      else if (.not. material%height > 0.0_wp) then
        values(m_locking) = material%mu*joint%pattern%steepest
      end if
      values(m_low) = s_f*material%inv_height
      if (s_f > 0.0_wp) values(m_soft) = closure/s_f
      values(m_deep) = closure*material%inv_height
      values(m_runaway) = (material%mu*stress)**2/(2.0_wp*material%k_t)*material%inv_w0
      if (.not. (closure > 0.0_wp .and. shares_pressure(joint))) return
      values(m_let_go) = values(m_runaway)*(climbed_height(joint, slip)/closure)
    end associate
  end function measures

  !> Pressure of the inclined plane of the smallest weight if it carries the whole pressure.
  pure function stress_alone(joint, pressure) result(stress)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: pressure            !! of the joint, >= 0, stress
    real(wp) :: stress
    logical :: inclined(joint%pattern%n)
    associate (n => joint%pattern%n)
      ! the frames beyond the planes are not defined
      inclined = joint%pattern%sin_theta(:n) > 0.0_wp
      if (.not. any(inclined)) inclined = .true.
      stress = pressure/minval(joint%pattern%gamma(:n), mask=inclined)
    end associate
  end function stress_alone

  !> Whether a slip climbs two planes at once, whose worn facets can pass pressure to each other: all but a single
  !> inclined plane and two opposite ones.
  pure function shares_pressure(joint) result(yes)
    type(interface_type), intent(in) :: joint   !! the interface
    logical :: yes
    !> Cosine of opposite directions, but for rounding.
    real(wp), parameter :: opposite = -1.0_wp + sqrt(epsilon(1.0_wp))
    integer :: k, l
    yes = .false.
    associate (p => joint%pattern)
      do k = 1, p%n
        do l = k + 1, p%n
          if (.not. min(p%sin_theta(k), p%sin_theta(l)) > 0.0_wp) cycle
          if (p%e_x(k)*p%e_x(l) + p%e_y(k)*p%e_y(l) > opposite) yes = .true.
        end do
      end do
    end associate
  end function shares_pressure

  !> Whether the user should be warned of each measure.
  pure function warned(values) result(yes)
    real(wp), intent(in) :: values(n_measures)   !! measures
    logical :: yes(n_measures)
    yes = values > limits
  end function warned

  !> Sentence about a measure that is beyond its limit.
  pure function warning_text(which, value) result(text)
    integer, intent(in) :: which    !! m_modes..m_brittle
    real(wp), intent(in) :: value   !! of the measure
    character(len=text_size) :: text
    character(len=*), parameter :: alone = "a plane that carries the largest pressure alone"
    character(len=40) :: limit
    limit = "expected at most " // short(limits(which))
    select case (which)
    case (m_modes)
      text = "sigma02 or Gc2 differ from mode I: the energy balance still holds, but the energy booked as rupture " // &
        "may exceed Gc, and the thermodynamic argument of the paper (Remark 2) is lost; see theory.md, section 3"
    case (m_locking)
      text = "mu tan(theta) = " // short(value) // " of the steepest plane: expected < 1, because " // &
        "from 1 on the interface locks where it slides up this plane"
    case (m_radians)
      text = "theta = " // short(value) // " degrees is nearly flat: expected degrees, not radians"
    case (m_low)
      text = "s_f = 2 Gc/sigma0 is " // short(value) // " height: expected a height of at least s_f, " // &
        "because the bond of the straight plane breaks within s_f"
    case (m_tension)
      text = "the normal traction reaches " // short(value) // " times the strength: " // &
        "expected less, because beyond it there is no equilibrium"
    case (m_soft)
      text = alone // " closes by " // short(value) // " s_f, " // trim(limit) // &
        ": the contact is soft, a larger kc or a largest closure makes it stiffer"
    case (m_deep)
      text = alone // " closes by " // short(value) // " height, " // trim(limit) // &
        ": a larger kc or a largest closure makes the contact stiffer"
    case (m_runaway)
      text = "the friction on " // alone // " stores " // short(value) // " W0, " // trim(limit) // &
        ": beyond it a facet may wear off in a jump"
    case (m_steep)
      text = alone // " closes by " // short(value) // " of the largest closure Vm, " // trim(limit) // &
        ": beyond it the contact follows the tangent of the hyperbola"
    case (m_lasting)
      text = "mu tan(theta) = " // short(value) // " of the steepest plane: expected < 1 with crush, because no " // &
        "pressure crushes a slope below tan(theta) - 1/mu"
    case (m_late)
      text = "the bond is " // short(value) // " times as stiff as " // alone // ", " // trim(limit) // &
        " with crush: on a softer contact asperities are crushed after the peak"
    case (m_brittle)
      text = "fc^2/Gfc is " // short(value) // " times the stiffness of the closed joint: expected < 1, because " // &
        "a joint that softens faster than it springs back falls in a jump: a larger Gfc or kc"
    case default
      text = "the elastic slip of " // alone // " wears " // short(value) // " times its closure off, " // &
        trim(limit) // ": planes that share the pressure may then wear off in jumps"
    end select
  end function warning_text

  !> Sentence with the largest increment of slip of an FE code; empty without wear. Where the slip is 0,
  !> because it is not known, the climbed height is that of the asperities, or 1 where they are infinitely high.
  pure function increment_text(joint, pressure, slip) result(text)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: pressure            !! largest pressure, >= 0, stress
    real(wp), intent(in) :: slip                !! largest slip, >= 0, length
    character(len=text_size) :: text
    character(len=:), allocatable :: stiffness
    real(wp) :: z
    text = ""
    if (.not. joint%pattern%steepest > 0.0_wp) return
    if (.not. joint%material%inv_w0 > 0.0_wp) return
    z = climbed_height(joint, slip)
    if (.not. z > 0.0_wp) z = merge(joint%material%height, 1.0_wp, joint%material%height > 0.0_wp)
    stiffness = "kc Kn"
    if (joint%material%hyperbolic) stiffness = "dp/dc"
    text = "increment of slip in an FE code: expected at most W0/(mu z " // stiffness // ") = " // &
      short(largest_slip_increment(joint, pressure, z)) // " at the climbed height z = " // short(z) // &
      ", because a facet loses its contact in longer ones"
  end function increment_text

  !> Largest increment of slip whose wear takes no more than the closure of a facet: W0/(mu z dp/dc) at the climbed
  !> height z; huge without wear. In longer increments of an FE code a facet loses its contact. The stiffness dp/dc is
  !> kc Kn, or kc Kn/(1 - c/Vm)^2 with 1/(1 - c/Vm) = 1 + p/(kc Kn Vm) for a plane that carries the pressure alone.
  pure function largest_slip_increment(joint, pressure, z) result(slip)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: pressure            !! largest pressure, >= 0, stress
    real(wp), intent(in) :: z                   !! climbed height, >= 0, length
    real(wp) :: slip
    real(wp) :: per_slip
    associate (m => joint%material)
      per_slip = m%mu*z*(m%k_c*stiffening(m, closure_under(m, stress_alone(joint, pressure))))*m%inv_w0
    end associate
    slip = huge(slip)
    if (per_slip > 1.0_wp/huge(slip)) slip = 1.0_wp/per_slip
  end function largest_slip_increment

  !> Height of the steepest facet, without wear, that a slip climbs.
  pure function climbed_height(joint, slip) result(z)
    type(interface_type), intent(in) :: joint   !! the interface
    real(wp), intent(in) :: slip                !! >= 0, length
    real(wp) :: z
    z = slip*joint%pattern%steepest
    if (joint%material%height > 0.0_wp) z = joint%material%height*(1.0_wp - exp(-z*joint%material%inv_height))
  end function climbed_height

  !> Whether a value of mode II is given (not 0) and is not that of mode I.
  pure function differs(props, second, first) result(yes)
    real(wp), intent(in) :: props(:)         !! PROPS, at least those without a default
    integer, intent(in) :: second, first     !! indices of the values of modes II and I
    logical :: yes
    yes = .false.
    if (size(props) < second) return
    yes = props(second) > 0.0_wp .and. abs(props(second) - props(first)) > 0.0_wp
  end function differs

  !> Closure at which a plane has a pressure, length; beyond m%linear_from it is that of the hyperbola.
  pure function closure_under(m, p) result(c)
    type(material_type), intent(in) :: m    !! constants
    real(wp), intent(in) :: p               !! pressure, >= 0, stress
    real(wp) :: c
    c = p/(m%k_c + p*m%inv_largest_closure)
  end function closure_under

  !> Derivative of the pressure by the closure at a closure, over k_c.
  pure function stiffening(m, c) result(ratio)
    type(material_type), intent(in) :: m    !! constants
    real(wp), intent(in) :: c               !! closure, >= 0, length
    real(wp) :: ratio
    ratio = 1.0_wp/(1.0_wp - min(c, m%linear_from)*m%inv_largest_closure)**2
  end function stiffening

end module asperity_warnings
