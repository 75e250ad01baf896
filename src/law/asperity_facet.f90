!> The facet of a plane: finite height of the asperities, of which a share is worn (asperity_wear), an extension of the
!> paper (docs/extensions.md).
!>
!> The module asperity_law says how these functions are used and in which units. The plane is the tangent at the foot of
!> its facet. Components along the axes (N, e, h) of the facet are (w, u, v): e is the direction in the average surface
!> in which the plane rises, u > 0 climbs. The profile is rho z_0 with z_0 = H (1 - exp(-u T/H)) for u > 0 and z_0 = u T
!> for u <= 0 or infinite H, the slope T = tan(theta) of the plane, and the share rho = 1 - omega that is not worn.
module asperity_facet
  use asperity_axes, only: global_traction, in_axes, uphill
  use asperity_contact, only: contact_stiffness, opening, pressure
  use asperity_kinds, only: wp
  use asperity_types, only: facet_type, local_type, material_type, moduli_type, plane_type, profile_type, &
    response_type, separation_type, short_artanh, tensor_type, vector_type
  implicit none
  private
  public :: exponentials, facet_at, facet_tangent, facet_traction, profile_at

contains

  !> Point of contact on the profile of a facet.
  !>
  !> The forms keep their digits for u T << H and for slopes near zero. The climbed length (H/T) (F(T) - F(z')) with
  !> F(x) = sqrt(1 + x^2) - asinh(1/x) is u + (H/T) (r_0 - r_1 - log((1 + r_0)/(1 + r_1))) with r = sqrt(1 + z'^2) at
  !> the foot (0) and at u (1). The difference of the roots is that of their squares over their sum, and the logarithm
  !> is 2 artanh((r_0 - r_1)/(2 + r_0 + r_1)).
  pure function profile_at(m, plane, rho, s) result(profile)
    type(material_type), intent(in) :: m    !! constants; without m%wears the slope is at most mild_slope
    type(plane_type), intent(in) :: plane   !! axes and slope
    real(wp), intent(in) :: rho             !! share of the profile that is not worn
    type(vector_type), intent(in) :: s      !! separation of the interface, length
    type(profile_type) :: profile
    real(wp) :: artanh, fall, inverse, r_0, r_1, ratio, rise, slope_0, total, up, y
    up = max(uphill(plane, s), m%foot) - m%foot
    call exponentials(m%by_points, up*(plane%slope*m%inv_height), profile%decay, rise)
    profile%z = m%height*rise
    slope_0 = rho*plane%slope
    r_0 = sqrt(1.0_wp + slope_0**2)
    r_1 = sqrt(1.0_wp + (slope_0*profile%decay)**2)
    total = r_0 + r_1
    ! 1/r_1, 1/total and 1/(2 + total) by one division, which costs more than the products
    inverse = 1.0_wp/((r_1*total)*(2.0_wp + total))
    profile%c = inverse*(total*(2.0_wp + total))
    ! (r_0 - r_1)/T, and the logarithm over T
    fall = ((rho*slope_0)*(rise*(1.0_wp + profile%decay)))*(inverse*(r_1*(2.0_wp + total)))
    ratio = fall*(inverse*(r_1*total))
    y = (plane%slope*ratio)**2
    artanh = 2.0_wp*ratio*(1.0_wp + y*(1.0_wp/3.0_wp + y*(1.0_wp/5.0_wp + y*(1.0_wp/7.0_wp + y*(1.0_wp/9.0_wp + &
      y*(1.0_wp/11.0_wp + y*(1.0_wp/13.0_wp)))))))
    if (m%wears) artanh = merge(artanh, plane%inv_slope*log((1.0_wp + r_0)/(1.0_wp + r_1)), y < short_artanh**2)
    profile%length = up + m%height*(fall - artanh)
  end function profile_at

  !> Kinematics of the facet of a plane: separation of the contact and its derivatives.
  pure function facet_at(m, plane, rho, profile, s) result(facet)
    type(material_type), intent(in) :: m        !! constants
    type(plane_type), intent(in) :: plane        !! axes and slope
    real(wp), intent(in) :: rho                  !! share of the profile that is not worn
    type(profile_type), intent(in) :: profile    !! point of contact
    type(vector_type), intent(in) :: s           !! separation of the interface, length
    type(facet_type) :: facet
    real(wp) :: bend_u, down, level, slope_0, slope_1, z
    associate (g => facet%s%n, c => facet%c, q => facet%q, bend => facet%bend)
      down = min(uphill(plane, s), m%foot)
      slope_0 = rho*plane%slope
      slope_1 = plane%slope*profile%decay
      c = profile%c
      q = (rho*slope_1)*c
      z = profile%z
      level = s%n - rho*z
      facet%z = rho*z + down*slope_0
      g = level*c - down*q
      facet%s%t = down*c + (profile%length + level*q)
      facet%s%h = plane%h%x*s%x + plane%h%y*s%y
      ! -d phi/d u = bend q c; bend is zero on the straight part
      bend = merge(plane%slope*m%inv_height, 0.0_wp, uphill(plane, s) > m%foot)
      facet%f = 1.0_wp - bend*(q*g)
      bend_u = bend*(q**2 + bend*(g*q)*(c**2 - q**2))
      facet%n_wu = bend*(q**2*c)
      facet%n_uu = bend*(q*c**2*facet%f) - q*bend_u
      facet%t_wu = -bend*(q*c**2)
      facet%t_uu = bend*(q**2*c*facet%f) + c*bend_u
      ! d z/d omega = -z_0, d phi/d omega = -z_0' c^2; c/(1 + r_0 c) is 1/(r_0 + r_1)
      facet%phi_omega = -slope_1*c**2
      facet%n_omega = c*(z + down*plane%slope + (g*q)*slope_1)
      facet%t_omega = z*q - (slope_0*z)*((1.0_wp + profile%decay)*(c/(1.0_wp + sqrt(1.0_wp + slope_0**2)*c))) - &
        g*(slope_1*c**2)
    end associate
  end function facet_at

  !> exp(-x) and 1 - exp(-x) for x >= 0, the latter with its digits for small x; 0 and 1 for x >= 80, where the first is
  !> nothing beside the second.
  !>
  !> x is n log(2) + r with |r| <= log(2)/2, and exp(-r) - 1 is a Taylor series. A call of exp takes three times as
  !> long.
  pure subroutine exponentials(by_points, x, decay, rise)
    logical, intent(in) :: by_points   !! whether the loop runs over points, else over planes
    real(wp), intent(in) :: x        !! >= 0
    real(wp), intent(out) :: decay   !! exp(-x)
    real(wp), intent(out) :: rise    !! 1 - exp(-x)
    integer :: count, k
    real(wp), parameter :: log_2 = log(2.0_wp), enough = 80.0_wp
    !> Factors of the series; the first omitted term is below a rounding error.
    integer, parameter :: terms = merge(13, 7, digits(1.0_wp) > 24)
    real(wp), parameter :: f(terms) = [(1.0_wp/gamma(real(k + 1, wp)), k=1, terms)]
    integer, parameter :: word = selected_int_kind(merge(18, 9, digits(1.0_wp) > 24))
    !> A number to which integers are added without rounding, and to which every other number is rounded to an integer.
    real(wp), parameter :: whole = 1.5_wp*2.0_wp**(digits(1.0_wp) - 1)
    real(wp) :: less, n, power, r
    ! 2^-n by its exponent. An integer that is shorter than a real makes gfortran take two vectors at a time, which
    ! gains in a loop over points; in a loop over few planes the integer is a part of a real.
    if (by_points) then
      count = int(min(x, enough)*(1.0_wp/log_2) + 0.5_wp)
      power = transfer(shiftl(int(maxexponent(1.0_wp) - 1 - count, word), digits(1.0_wp) - 1), 1.0_wp)
      r = real(count, wp)*log_2 - min(x, enough)
    else
      n = min(x, enough)*(1.0_wp/log_2) + whole
      power = transfer(shiftl(int(maxexponent(1.0_wp) - 1, word) - (transfer(n, 0_word) - transfer(whole, 0_word)), &
        digits(1.0_wp) - 1), 1.0_wp)
      r = (n - whole)*log_2 - min(x, enough)
    end if
    less = f(terms)
    do k = terms - 1, 2, -1
      less = f(k) + r*less
    end do
    less = r + r**2*less
    decay = merge(power + power*less, 0.0_wp, x < enough)
    rise = (1.0_wp - power) - power*less
  end subroutine exponentials

  !> Derivative of the traction alpha G^T sigma_d of the contact by the worn share at a constant separation, over k_t,
  !> along (N, e, h).
  pure function softening(moduli, at, now) result(change)
    type(moduli_type), intent(in) :: moduli    !! factors of friction
    type(separation_type), intent(in) :: at    !! separations at the end
    type(response_type), intent(in) :: now     !! response to the increment
    type(local_type) :: change
    real(wp) :: along, c_omega, f_omega, pushed, q_omega, rubbed, turn
    associate (facet => at%facet, friction => now%friction, alpha => now%new%alpha, p => now%friction%p)
      along = friction%stress*friction%m_t
      ! d c, d q and d f by omega
      turn = facet%phi_omega
      c_omega = -facet%q*turn
      q_omega = facet%c*turn
      f_omega = -facet%bend*(q_omega*at%contact%n + facet%q*facet%n_omega)
      ! alpha d sigma_d, normal and along the facet
      pushed = (alpha*friction%stiffness)*facet%n_omega
      rubbed = moduli%slip_term*(friction%m_t*facet%t_omega) + moduli%coupling*facet%n_omega
      change%h = friction%m_h*rubbed
      rubbed = (alpha*moduli%tangential)*facet%t_omega + friction%m_t*rubbed
      change%n = pushed*facet%c + rubbed*facet%q + alpha*(along*q_omega - p*c_omega)
      change%t = (rubbed*facet%c - pushed*facet%q)*facet%f + alpha*((p*facet%q + along*facet%c)*f_omega + &
        (p*q_omega + along*c_omega)*facet%f)
    end associate
  end function softening

  !> Traction of a plane whose contact lies on a facet, over k_t: (1 - alpha) Q^T sigma_u + alpha G^T sigma_d, where Q
  !> are the axes of the plane and G are the derivatives of the separation of the contact.
  pure function facet_traction(m, plane, at, now) result(traction)
    type(material_type), intent(in) :: m      !! constants
    type(plane_type), intent(in) :: plane      !! axes
    type(separation_type), intent(in) :: at     !! separations at the end
    type(response_type), intent(in) :: now     !! response to the increment
    type(vector_type) :: traction
    type(vector_type) :: bond, contact
    associate (alpha => now%new%alpha)
      bond = global_traction(plane, bond_stress(m, at))
      contact = in_axes(plane, contact_stress(at, now))
      traction = vector_type((1.0_wp - alpha)*bond%n + alpha*contact%n, (1.0_wp - alpha)*bond%x + alpha*contact%x, &
        (1.0_wp - alpha)*bond%y + alpha*contact%y)
    end associate
  end function facet_traction

  !> Stress of the undamaged bond sigma_u, over k_t, in the axes of the plane.
  pure function bond_stress(m, at) result(sigma)
    type(material_type), intent(in) :: m      !! constants
    type(separation_type), intent(in) :: at     !! separations at the end
    type(local_type) :: sigma
    sigma = local_type(m%kn_kt*opening(at%bond) - pressure(m, at%bond), at%bond%t, at%bond%h)
  end function bond_stress

  !> Traction of the contact G^T sigma_d, over k_t, along (N, e, h).
  pure function contact_stress(at, now) result(sigma)
    type(separation_type), intent(in) :: at     !! separations at the end
    type(response_type), intent(in) :: now     !! response to the increment
    type(local_type) :: sigma
    real(wp) :: along
    along = now%friction%stress*now%friction%m_t
    associate (facet => at%facet, p => now%friction%p)
      sigma = local_type(along*facet%q - p*facet%c, (p*facet%q + along*facet%c)*facet%f, &
        now%friction%stress*now%friction%m_h)
    end associate
  end function contact_stress

  !> Consistent tangent of a plane whose contact lies on a facet: (1 - alpha) Q^T D_u Q
  !> + alpha (G^T D_d G + sum of sigma_d times the second derivatives of the separation) + (t_d - t_u) (x) d alpha/d s.
  !>
  !> The bond takes its side from s_n, the contact from the gap; both take the left side at zero. Where the pressure at
  !> the end crushes the facet, the change of the worn share is added.
  pure function facet_tangent(m, plane, moduli, at, now) result(tangent)
    type(material_type), intent(in) :: m             !! constants
    type(plane_type), intent(in) :: plane            !! axes
    type(moduli_type), intent(in) :: moduli          !! factors of friction and damage
    type(separation_type), intent(in) :: at     !! separations at the end
    type(response_type), intent(in) :: now           !! response to the increment
    type(tensor_type) :: tangent
    type(local_type) :: bond, contact, direction, dragged, gradient, normal, along, released, softer
    real(wp) :: a, alpha, b, d, k, mixed, steeper
    real(wp) :: wu, wv, uw, uu, uv, vw, vu, vv
    associate (facet => at%facet, gap => at%contact%n, friction => now%friction, c => moduli%slip_term, &
               e => moduli%coupling, grows => moduli%damage, p => now%friction%p)
      alpha = now%new%alpha
      ! bond: b I + d n (x) n; contact: a along the facet, k along its normal
      b = 1.0_wp - alpha
      d = b*(merge(contact_stiffness(m, at%bond), m%kn_kt, at%bond%n < 0.0_wp) - 1.0_wp)
      a = alpha*moduli%tangential
      k = alpha*merge(friction%stiffness, merge(m%kn_kt, 0.0_wp, gap <= 0.0_wp), gap < 0.0_wp)
      ! gradients of gap and climbed length, and the direction of the friction, along (N, e, h)
      normal = local_type(facet%c, -facet%q*facet%f, 0.0_wp)
      along = local_type(facet%q, facet%c*facet%f, 0.0_wp)
      direction = local_type(friction%m_t*along%n, friction%m_t*along%t, friction%m_h)
      dragged = local_type(c*direction%n + e*normal%n, c*direction%t + e*normal%t, c*direction%h)
      mixed = alpha*((friction%stress*friction%m_t)*facet%t_wu - p*facet%n_wu)
      steeper = alpha*((friction%stress*friction%m_t)*facet%t_uu - p*facet%n_uu)
      ! (t_d - t_u)/(eta r^3), and the gradient of beta^2/2
      bond = bond_stress(m, at)
      contact = contact_stress(at, now)
      released = local_type(grows*(contact%n - (plane%n%n*bond%n + plane%t%n*bond%t)), &
        grows*(contact%t - (plane%n%n*bond%t - plane%t%n*bond%n)), grows*(contact%h - bond%h))
      gradient = local_type(m%inv_s02_2*(plane%t%n*at%bond%t), m%inv_s02_2*(plane%n%n*at%bond%t), &
        m%inv_s02_2*at%bond%h)
      gradient%n = gradient%n + plane%n%n*(m%inv_s01_2*opening(at%bond))
      gradient%t = gradient%t - plane%t%n*(m%inv_s01_2*opening(at%bond))

      tangent%nn = (b + d*plane%n%n**2) + (k*normal%n**2 + a*along%n**2) + &
        (direction%n*dragged%n + released%n*gradient%n)
      wu = (k*(normal%n*normal%t) + a*(along%n*along%t) + mixed) - d*(plane%n%n*plane%t%n)
      uw = wu + (direction%t*dragged%n + released%t*gradient%n)
      wu = wu + (direction%n*dragged%t + released%n*gradient%t)
      uu = (b + d*plane%t%n**2) + (k*normal%t**2 + a*along%t**2 + steeper) + &
        (direction%t*dragged%t + released%t*gradient%t)
      wv = direction%n*dragged%h + released%n*gradient%h
      uv = direction%t*dragged%h + released%t*gradient%h
      vw = direction%h*dragged%n + released%h*gradient%n
      vu = direction%h*dragged%t + released%h*gradient%t
      vv = (b + a) + (direction%h*dragged%h + released%h*gradient%h)
      if (m%wears) then
        softer = softening(moduli, at, now)
        tangent%nn = tangent%nn + softer%n*moduli%omega%n
        wu = wu + softer%n*moduli%omega%t
        uw = uw + softer%t*moduli%omega%n
        uu = uu + softer%t*moduli%omega%t
        vw = vw + softer%h*moduli%omega%n
        vu = vu + softer%h*moduli%omega%t
      end if
    end associate
    associate (e_x => plane%e_x, e_y => plane%e_y, h_x => plane%h%x, h_y => plane%h%y)
      tangent%nx = wu*e_x + wv*h_x
      tangent%ny = wu*e_y + wv*h_y
      tangent%xn = uw*e_x + vw*h_x
      tangent%yn = uw*e_y + vw*h_y
      tangent%xx = e_x*(uu*e_x + uv*h_x) + h_x*(vu*e_x + vv*h_x)
      tangent%xy = e_x*(uu*e_y + uv*h_y) + h_x*(vu*e_y + vv*h_y)
      tangent%yx = e_y*(uu*e_x + uv*h_x) + h_y*(vu*e_x + vv*h_x)
      tangent%yy = e_y*(uu*e_y + uv*h_y) + h_y*(vu*e_y + vv*h_y)
    end associate
  end function facet_tangent

end module asperity_facet
