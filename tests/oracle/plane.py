"""Equations of one plane of the reference: bond, damage, contact, friction and wear, from (4) to (39).

Numbers in round brackets are equations of the paper, arrays are those of reference.py.  Separations may be
complex: an imaginary part that is too small for its square leads to the derivative of every result, exact but
for rounding.  Real parts decide between branches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .facet import Facet, facets, profile, uphill_axes

Floats = NDArray[np.floating]

GUARD_ROUNDINGS = 16
"""Rounding errors of K |s|^2 within which the guard takes a release of energy for none."""

OPEN, STICK, SLIP = 0, 1, 2
"""Branch of a plane: s_n > 0, or in contact and sticking, or in contact and slipping."""

MOST_CLOSED = 0.99
"""Share of the largest closure up to which the pressure is a hyperbola, beyond which it is linear."""

PARALLEL = 1.0e-12
"""Sine of the inclination below which a plane counts as parallel to the average surface."""


OF_CRUSHED = [*((-1.0) ** n / (n + 1.0) for n in range(9, 0, -1)), 0.0]
"""Coefficients of the series of log(1 + x)/x - 1, highest power first."""

OF_LOGARITHM = [*(1.0 / n for n in range(39, 1, -1)), 0.0, 0.0]
"""Coefficients of the series of -x - log(1 - x), highest power first."""


@dataclass(frozen=True)
class Parameters:
    """Material parameters of one plane (Table 2); zero sigma02 or Gc2 means equal to the mode I value.

    sigma0, sigma02: stress; Gc, Gc2: stress*length; eta, mu: dimensionless; kc: closing stiffness over Kn;
    tau_v: relaxation time of the damage, 0 for none; guard: the damage of a plane does not grow where the
    rupture energy would decrease; height: asperity height H, length, 0 for unbounded dilation; W0: frictional
    work per unit area of a facet that wears the facet to 37 %, stress*length, 0 for no wear; crush: pressure
    that crushes a facet to log(2), stress, 0 for none; damage0: damage of every plane from the start;
    closure: largest closure of the hyperbolic contact, length, 0 for linear; c: dashpot on the closed
    contact, stress*time/length, 0 for none, along the plane in the ratio of the stiffnesses; fc, Gfc, Css,
    kp, fcr: compressive strength of the joint, which is not one of a plane (cap.py).
    """

    sigma0: float
    Gc: float
    eta: float
    mu: float
    sigma02: float = 0.0
    Gc2: float = 0.0
    kc: float = 1.0
    tau_v: float = 0.0
    guard: bool = False
    height: float = 0.0
    W0: float = 0.0
    crush: float = 0.0
    damage0: float = 0.0
    closure: float = 0.0
    c: float = 0.0
    fc: float = 0.0
    Gfc: float = 0.0
    Css: float = 9.0
    kp: float = 0.0
    fcr: float = 0.1

    @property
    def sf(self) -> float:
        """Normal separation at complete rupture, length: the triangle of Figure 2 has the area Gc."""
        return 2.0 * self.Gc / self.sigma0

    @property
    def s0(self) -> float:
        """Normal separation at the onset of damage, length (5)."""
        return (1.0 - self.eta) * self.sf

    @property
    def s02(self) -> float:
        """Tangential separation at the onset of damage, length (5), with the mode II values."""
        return (1.0 - self.eta) * 2.0 * (self.Gc2 or self.Gc) / (self.sigma02 or self.sigma0)

    @property
    def Kn(self) -> float:
        """Normal stiffness, stress/length (12)."""
        return self.sigma0 / self.s0

    @property
    def Kt(self) -> float:
        """Tangential stiffness, stress/length (12)."""
        return (self.sigma02 or self.sigma0) / self.s02

    @property
    def wears(self) -> bool:
        """Whether the state holds the wear of the facets."""
        return self.W0 > 0.0 or self.crush > 0.0

    @property
    def curved(self) -> bool:
        """Whether the damaged part of a plane lives on a facet of its own."""
        return self.height > 0.0 or self.wears


IMAGINARY = 1.0e-30
"""Imaginary part, relative to s0 or to 1."""


def positive(x: Floats) -> Floats:
    """The larger one of x and zero."""
    return np.where(x.real > 0.0, x, 0.0)


def length(x: Floats) -> Floats:
    """Length of vectors (..., n)."""
    return np.sqrt((x * x).sum(-1))


def kinematics(
    parameters: Parameters, frame: Floats, s: Floats, omega: Floats
) -> tuple[Floats, Floats, Facet | None]:
    """Components (..., k, 3) of a separation s (..., 3) on the straight planes, (2), and on their facets.

    Bond and damage take the first, contact and friction the second.  Without height and wear the facet is the
    plane itself (None).
    """
    straight = np.einsum("kab,...b->...ka", frame, s)
    if not parameters.curved:
        return straight, straight, None
    facet = facets(frame, s, parameters.height, omega)
    return straight, facet.local, facet


def driving_force(
    parameters: Parameters, facet: Facet | None, alpha: Floats, tau_d: Floats, p: Floats | None
) -> Floats:
    """Energy A released per unit of wear: alpha (p dg/domega - tau_t ds_t/domega) = -alpha dpsi_d/domega."""
    if facet is None or not parameters.wears:
        return np.zeros_like(alpha)
    return alpha * (p * facet.by_omega[..., 0] - tau_d[..., 0] * facet.by_omega[..., 1])


def crushed(parameters: Parameters, p: Floats) -> Floats:
    """Share 1 - log(1 + x)/x of a facet that the pressure p = x crush crushes."""
    x = p / parameters.crush
    small = x.real <= 1e-2
    share = 1.0 - np.log1p(x) / np.where(small, 1.0, x)
    share[small] = -np.polyval(OF_CRUSHED, x[small])
    return share


def pressure_factor(parameters: Parameters, frame: Floats, s: Floats) -> Floats:
    """Part (..., k) of the pressure that crushes the facets at a separation s (..., 3), 0 to 1.

    At a constant separation a facet releases p c^3 (z + rho w z'^2 - (tau/p) (rho z - w) z') per unit of rho
    that it loses, with the unworn z and z'.  The factor is the bracket over z for tau = mu p, each term at
    the rho of 0 to 1 that makes it smallest; where this is negative, and at and below the foot, it is 0.
    """
    axes, slope = uphill_axes(frame)
    w, u, _ = np.moveaxis(np.einsum("kab,...b->...ka", axes, s), -1, 0)
    climbs = (u.real > 0.0) & (slope > PARALLEL)
    z, dz, _ = profile(np.where(climbs, u, 1.0), np.where(climbs, slope, 1.0), parameters.height)
    rub = parameters.mu * positive(z - w) * dz
    return np.where(climbs, positive(1.0 - (rub - np.where(w.real < 0.0, w, 0.0) * dz**2) / z), 0.0)


def rounding(parameters: Parameters, s_before: Floats, s_new: Floats) -> Floats:
    """What rounding may leave of a trapezoid of Y (..., k) that is zero."""
    closed = np.maximum(stiffness(parameters, s_before), stiffness(parameters, s_new))
    normal = np.maximum(parameters.Kn, closed) * (s_before[..., 0] ** 2 + s_new[..., 0] ** 2)
    size = normal + parameters.Kt * (s_before[..., 1:] ** 2 + s_new[..., 1:] ** 2).sum(-1)
    return GUARD_ROUNDINGS * np.finfo(float).eps * size


def damage(parameters: Parameters, s: Floats, alpha_old: Floats, dt: float) -> Floats:
    """Damage of every plane by (24), (25).

    With tau_v > 0 the damage solves tau_v (alpha - alpha_old) = dt (target - alpha), where target is the
    damage of (7) without its history; the damage is never below alpha_old.
    """
    opening = positive(s[..., 0]) / parameters.s0
    r = length(np.concatenate([opening[..., None], s[..., 1:] / parameters.s02], axis=-1))  # 1 + beta, (6)
    beyond = np.where(r.real > 1.0, r, 1.0)  # for beta < 0 the damage keeps its old value
    target = (beyond - 1.0) / beyond / parameters.eta
    target = reached = np.where(target.real < 1.0, target, 1.0)
    if parameters.tau_v > 0.0:
        reached = (parameters.tau_v * alpha_old + dt * target) / (parameters.tau_v + dt)
    # damage grows only if it was below the target by more than rounding
    growing = (target.real > alpha_old) & (reached.real > alpha_old)
    return np.where(growing, reached, alpha_old)


def friction(
    parameters: Parameters, s: Floats, slip_old: Floats, p: Floats, pull: Floats, rate: float
) -> tuple[Floats, Floats, NDArray[np.int8]]:
    """Return mapping (30)-(39) of every plane: friction traction tau_d, slip s_di, branch."""
    trial = (parameters.Kt + rate) * (s[..., 1:] - slip_old) - pull
    size = length(trial)
    strength = parameters.mu * p
    # a smooth contact never sticks, not even where its trial stress is exactly zero
    sticks = (size.real <= strength.real) & (parameters.mu > 0.0)
    scale = np.where(sticks, 1.0, strength / np.where(sticks | (size.real == 0.0), 1.0, size))
    tau_d = scale[..., None] * trial
    slip = np.where(sticks[..., None], slip_old, s[..., 1:] - (tau_d + pull) / (parameters.Kt + rate))
    branch = np.where(s[..., 0].real > 0.0, OPEN, np.where(sticks, STICK, SLIP)).astype(np.int8)
    return tau_d, slip, branch


def closure(parameters: Parameters, s: Floats) -> tuple[Floats, Floats]:
    """Closure (..., k) of contacts, and its part up to MOST_CLOSED of the largest one."""
    c = positive(-s[..., 0])
    most = MOST_CLOSED * parameters.closure
    return c, np.where(c.real < most, c, most)


def pressure(parameters: Parameters, s: Floats) -> Floats:
    """Contact pressure p >= 0 of the damaged part, from (13): -kc Kn min(s_n, 0), or Bandis' hyperbola."""
    c, bend = closure(parameters, s)
    if parameters.closure == 0.0:
        return parameters.kc * parameters.Kn * c
    Vm = parameters.closure
    return parameters.kc * parameters.Kn * bend * Vm / (Vm - bend) + stiffness(parameters, s) * (c - bend)


def stiffness(parameters: Parameters, s: Floats) -> Floats:
    """Derivative of the contact pressure with respect to the closure; beyond MOST_CLOSED it is constant."""
    c, bend = closure(parameters, s)
    if parameters.closure == 0.0:
        return np.full(c.shape, parameters.kc * parameters.Kn)
    return parameters.kc * parameters.Kn * (parameters.closure / (parameters.closure - bend)) ** 2


def release_rate(parameters: Parameters, s: Floats, contact: Floats, slip: Floats) -> Floats:
    """Energy Y released per unit growth of damage: stored energy of the undamaged less the damaged part."""
    whole = (s[..., 1:] ** 2).sum(-1)
    elastic = ((contact[..., 1:] - slip) ** 2).sum(-1)
    opening = 0.5 * parameters.Kn * positive(s[..., 0]) ** 2
    of_contact = closing(parameters, s) - closing(parameters, contact)
    return opening + 0.5 * parameters.Kt * (whole - elastic) + of_contact


def stored(parameters: Parameters, s: Floats, contact: Floats, alpha: Floats, slip: Floats) -> Floats:
    """Stored energy psi of every plane, the potential of (11) and (16) weighted as in (4)."""
    elastic = 0.5 * parameters.Kt * ((contact[..., 1:] - slip) ** 2).sum(-1)
    damaged = closing(parameters, contact) + elastic
    undamaged = damaged + release_rate(parameters, s, contact, slip)
    return (1.0 - alpha) * undamaged + alpha * damaged


def closing(parameters: Parameters, s: Floats) -> Floats:
    """Energy stored in a closed contact: the integral of its pressure."""
    c, bend = closure(parameters, s)
    if parameters.closure == 0.0:
        return 0.5 * parameters.kc * parameters.Kn * c**2
    Vm = parameters.closure
    x = bend / Vm
    # -x - log(1 - x), by its series where the terms would cancel
    series = np.polyval(OF_LOGARITHM, x)
    integral = np.where(x.real < 0.2, series, -x - np.log1p(-x))
    edge = bend * Vm / (Vm - bend)
    hyperbola = parameters.kc * parameters.Kn * (Vm**2 * integral + edge * (c - bend))
    return hyperbola + 0.5 * stiffness(parameters, s) * (c - bend) ** 2
