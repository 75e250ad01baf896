"""Independent NumPy reference of the interface law of Albarella, Serpieri, Alfano and Sacco (2015).

The tests compare the library with this module.  It uses nothing of the library: it was written from the
equations of the paper with the corrections listed in docs/theory.md.  Numbers in round brackets are equations
of the paper.  Components are (N, Tx, Ty), tension and opening are positive, angles are in degrees, units are
the user's consistent set.  Finite asperity height and wear go beyond the paper: the contact of an inclined
plane is then a curved facet (facet.py), while bond and damage are those of the straight plane.

A pattern is the pair ``(normals, weights)`` of shapes (k, 3) and (k,).  A state has 8 + 3 k entries: damage,
stored, rupture and friction (with wear) per unit area, status, the three offsets of the separation, and then
(alpha, s_dit, s_dih) of every plane.  With wear, (omega, frictional work) of every plane follow them.
Zeros are a virgin point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .facet import Facet, facets, profile, uphill_axes

Floats = NDArray[np.floating]
Pattern = tuple[Floats, Floats]

HEADER = 8
"""Entries of the state before those of the planes."""

PER_PLANE = 3
"""Entries of the state per plane: alpha, s_dit, s_dih."""

PER_FACET = 2
"""Entries of the state per plane with wear, after those of all planes: omega, frictional work."""

GUARD_ROUNDINGS = 16
"""Rounding errors of K |s|^2 within which the guard takes a release of energy for none."""

OPEN, STICK, SLIP = 0, 1, 2
"""Branch of a plane: s_n > 0, or in contact and sticking, or in contact and slipping."""

MOST_CLOSED = 0.99
"""Share of the largest closure up to which the pressure is a hyperbola, beyond which it is linear."""

PARALLEL = 1.0e-12
"""Sine of the inclination below which a plane counts as parallel to the average surface."""


@dataclass(frozen=True)
class Parameters:
    """Material parameters of one plane (Table 2); zero sigma02 or Gc2 means equal to the mode I value.

    sigma0, sigma02: stress; Gc, Gc2: stress*length; eta, mu: dimensionless; kc: closing stiffness over Kn;
    tau_v: relaxation time of the damage, 0 for none; guard: the damage of a plane does not grow where the
    rupture energy would decrease; height: asperity height H, length, 0 for unbounded dilation; W0: frictional
    work per unit area of a facet that wears the facet to 37 %, stress*length, 0 for no wear; crush: pressure
    that crushes a facet to log(2), stress, 0 for none; damage0: damage of every plane from the start;
    closure: largest closure of the hyperbolic contact, length, 0 for linear; c: dashpot on the closed
    contact, stress*time/length, 0 for none, along the plane in the ratio of the stiffnesses.
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


@dataclass(frozen=True)
class Response:
    """Result of the law: traction (..., 3), state (..., 8+3k or 8+5k), tangent (..., 3, 3).

    Per plane (..., k): the branch of its contact (OPEN, STICK or SLIP), and whether its damage grew.
    """

    traction: Floats
    state: Floats
    tangent: Floats
    branch: NDArray[np.int8]
    damaging: NDArray[np.bool_]


# --- patterns ------------------------------------------------------------


def regular_pattern(sides: int, theta_deg: float, flat: float = 1.0 / 3.0, turn_deg: float = 0.0) -> Pattern:
    """Flat plane of weight `flat` and `sides` equal planes inclined by theta_deg, turned about N, (41)-(43).

    Returns normals (k, 3) and weights (k,), flat plane first, as in Table 4.
    """
    level = np.array([[1.0, 0.0, 0.0]])
    if sides == 0 or flat == 1.0:
        return level, np.array([1.0])
    theta = np.radians(theta_deg)
    angle = 2.0 * np.pi * np.arange(int(sides)) / sides + np.radians(turn_deg)
    # Q^(k) n^(1) of (42), with n^(1) = (cos theta, -sin theta, 0) of (41) and Q^(k) of (43).
    inclined = np.stack(
        [np.full(int(sides), np.cos(theta)), -np.sin(theta) * np.cos(angle), -np.sin(theta) * np.sin(angle)],
        axis=-1,
    )
    share = np.full(int(sides), (1.0 - flat) / sides)
    if flat == 0.0:
        return inclined, share
    return np.concatenate([level, inclined]), np.concatenate([[flat], share])


def listed_pattern(normals: ArrayLike, weights: ArrayLike) -> Pattern:
    """Planes given one by one: normals (k, 3), normalised here, and weights (k,); the order is preserved."""
    normals, weights = np.array(normals, dtype=float, ndmin=2), np.array(weights, dtype=float, ndmin=1)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True), weights


def frames(normals: Floats) -> Floats:
    """Rows n, t, h of the local frame of every plane, (k, 3, 3), by (1) and the flat case that follows it."""
    n_N, n_x, n_y = normals.T
    sine = np.hypot(n_x, n_y)  # |N x n|
    level = sine <= PARALLEL
    divisor = np.where(level, 1.0, sine)
    zero = np.zeros_like(sine)
    h = np.stack([zero, -n_y / divisor, n_x / divisor], axis=-1)
    t = np.stack([sine, -n_N * n_x / divisor, -n_N * n_y / divisor], axis=-1)  # n x h
    t = np.where(level[:, None], [0.0, 1.0, 0.0], t)
    h = np.where(level[:, None], [0.0, 0.0, 1.0], h)
    return np.stack([normals, t, h], axis=1)


# --- the law -------------------------------------------------------------


def virgin(pattern: Pattern, wears: bool = False) -> Floats:
    """State of a virgin point, (8 + 3 k,) or with wear (8 + 5 k,) zeros."""
    return np.zeros(HEADER + (PER_PLANE + PER_FACET * wears) * len(pattern[1]))


def update(
    parameters: Parameters,
    pattern: Pattern,
    s: ArrayLike,
    state: ArrayLike | None = None,
    s_old: ArrayLike | None = None,
    dt: float = 0.0,
) -> Response:
    """One increment of the law from (s_old, state) to the total separation s, (22)-(39).

    s and s_old are (..., 3), state is as long as ``virgin`` makes it; None means zero.  Leading axes are
    independent points.  dt is the duration of the increment, which has an effect only if tau_v or c > 0; at
    a duration of 0 the dashpot does not act.  The
    guard uses the mean of the energy release Y at the start and at the end.
    """
    gamma = pattern[1]
    s = np.asarray(s, dtype=float)
    lead = s.shape[:-1]
    blank = virgin(pattern, parameters.wears)
    state = np.broadcast_to(blank if state is None else state, (*lead, len(blank)))
    s_old = np.broadcast_to(np.zeros(3) if s_old is None else s_old, s.shape)
    start = _start(parameters, pattern, s_old, state)
    end = _end(parameters, start, s, dt)
    step = IMAGINARY * parameters.s0
    shifted = (_end(parameters, start, s + 1j * step * axis, dt, end.omega) for axis in np.eye(3))
    tangent = np.stack([one.traction.imag / step for one in shifted], axis=-1)

    # Energies per unit area; the start of the increment is evaluated from the given state.
    alpha, slip = end.alpha, end.slip
    strength_before = parameters.mu * start.alpha * _pressure(parameters, start.contact)
    strength = parameters.mu * alpha * _pressure(parameters, end.contact)
    friction = 0.5 * (strength_before + strength) * np.linalg.norm(slip - start.slip, axis=-1)
    damping = np.zeros_like(friction)
    if parameters.c > 0.0:
        friction, damping = _damped(parameters, start, end, dt)
    drive = _driving_force(parameters, end.facet, alpha, end.tau_d, end.p)
    omega_old, work_old = _wear_histories(state, len(gamma))
    springs = parameters.Kt * (end.contact[..., 1:] - slip)
    elastic = _driving_force(parameters, end.facet, alpha, springs, _pressure(parameters, end.contact))
    wear = 0.5 * (np.maximum(start.drive, 0.0) + np.maximum(elastic, 0.0)) + (drive - elastic)
    wear = np.maximum(wear, 0.0) * (end.omega - omega_old)
    work = work_old + np.where(drive > 0.0, friction, 0.0)

    out = np.empty(state.shape)
    out[..., 0] = (gamma * alpha).sum(-1)
    out[..., 1] = (gamma * _stored(parameters, end.straight, end.contact, alpha, slip)).sum(-1)
    out[..., 2] = state[..., 2] + (gamma * 0.5 * end.release * (alpha - start.alpha)).sum(-1)
    out[..., 3] = state[..., 3] + (gamma * (friction + wear + damping)).sum(-1)
    out[..., 4] = 1.0
    out[..., 5:8] = start.offset
    planes = np.concatenate([alpha[..., None], slip], axis=-1)
    out[..., HEADER : HEADER + PER_PLANE * len(gamma)] = planes.reshape(*lead, PER_PLANE * len(gamma))
    if parameters.wears:
        worn = np.stack([end.omega, work], axis=-1)
        out[..., HEADER + PER_PLANE * len(gamma) :] = worn.reshape(*lead, PER_FACET * len(gamma))
    return Response(end.traction, out, tangent, end.branch, alpha > start.alpha)


def _histories(parameters: Parameters, state: Floats, count: int) -> tuple[Floats, Floats]:
    """Damage (..., k), which is at least damage0, and slip (..., k, 2) of the planes in a state."""
    planes = state[..., HEADER : HEADER + PER_PLANE * count].reshape(*state.shape[:-1], count, PER_PLANE)
    return np.maximum(planes[..., 0], parameters.damage0), planes[..., 1:]


def _wear_histories(state: Floats, count: int) -> tuple[Floats, Floats]:
    """omega and frictional work (..., k) of the facets in a state; zeros in a state without them."""
    entries = state[..., HEADER + PER_PLANE * count :]
    if entries.shape[-1] == 0:
        entries = np.zeros((*state.shape[:-1], PER_FACET * count))
    worn = entries.reshape(*state.shape[:-1], count, PER_FACET)
    return worn[..., 0], worn[..., 1]


# What follows takes complex separations, too: an imaginary part that is too small for its square leads to the
# derivative of every result, exact but for rounding.  Real parts decide between branches.

IMAGINARY = 1.0e-30
"""Imaginary part, relative to s0 or to 1."""


def _positive(x: Floats) -> Floats:
    """The larger one of x and zero."""
    return np.where(x.real > 0.0, x, 0.0)


def _size(x: Floats) -> Floats:
    """Length of vectors (..., n)."""
    return np.sqrt((x * x).sum(-1))


@dataclass(frozen=True)
class _Start:
    """Start of an increment: the planes, their histories, separations, friction traction and driving force.

    omega: of the frictional work so far.
    """

    frame: Floats
    gamma: Floats
    offset: Floats
    alpha: Floats
    slip: Floats
    straight: Floats
    contact: Floats
    drive: Floats
    omega: Floats


@dataclass(frozen=True)
class _End:
    """End of an increment: what the law makes of a separation.

    release: the sum of Y at both ends; p: pressure of the contact, with that of the dashpot.
    """

    straight: Floats
    contact: Floats
    facet: Facet | None
    omega: Floats
    alpha: Floats
    tau_d: Floats
    slip: Floats
    branch: NDArray[np.int8]
    release: Floats
    traction: Floats
    p: Floats


def _start(parameters: Parameters, pattern: Pattern, s_old: Floats, state: Floats) -> _Start:
    """Start of an increment at s_old (..., 3); wear by work is known there already."""
    frame, offset = frames(pattern[0]), state[..., 5:8]
    alpha, slip = _histories(parameters, state, len(frame))
    omega, work = _wear_histories(state, len(frame))
    straight, contact, facet = _kinematics(parameters, frame, s_old + offset, omega)
    tau_d = parameters.Kt * (contact[..., 1:] - slip)
    p = None if facet is None else _pressure(parameters, contact)
    drive = _driving_force(parameters, facet, alpha, tau_d, p)
    if parameters.W0 > 0.0:
        omega = np.where(drive > 0.0, np.maximum(omega, -np.expm1(-work / parameters.W0)), omega)
    return _Start(frame, pattern[1], offset, alpha, slip, straight, contact, drive, omega)


def _end(parameters: Parameters, start: _Start, s: Floats, dt: float, known: Floats | None = None) -> _End:
    """End of an increment to the separation s (..., 3), (22)-(39).  known: worn shares at its real part."""
    s = s + start.offset
    omega = _omega(parameters, start, s, known)
    straight, contact, facet = _kinematics(parameters, start.frame, s, omega)
    p = _pressure(parameters, contact)
    pull, rate = np.zeros_like(contact[..., 1:]), 0.0
    if parameters.c > 0.0 and dt > 0.0:
        p, pull, rate = _viscous(parameters, start, contact, dt)
    tau_d, slip, branch = _friction(parameters, contact, start.slip, p, pull, rate)
    release = _release_rate(parameters, start.straight, start.contact, start.slip)
    release = release + _release_rate(parameters, straight, contact, slip)
    alpha = _damage(parameters, straight, start.alpha, dt)
    if parameters.guard:
        gives_back = release.real < -_rounding(parameters, start.straight, straight.real)
        alpha = np.where(gives_back, start.alpha, alpha)

    # local tractions of the undamaged part (11) and of the damaged part (13), (23), weighted by (22)
    normal = parameters.Kn * _positive(straight[..., 0]) - _pressure(parameters, straight)
    undamaged = np.concatenate([normal[..., None], parameters.Kt * straight[..., 1:]], axis=-1)
    damaged = np.concatenate([-p[..., None], tau_d], axis=-1)
    undamaged, damaged = (1.0 - alpha)[..., None] * undamaged, alpha[..., None] * damaged
    if facet is None:
        traction = np.einsum("k,kab,...ka->...b", start.gamma, start.frame, undamaged + damaged)
    else:
        traction = np.einsum("k,kab,...ka->...b", start.gamma, start.frame, undamaged)
        traction = traction + np.einsum("k,...kab,...ka->...b", start.gamma, facet.gradient, damaged)
    return _End(straight, contact, facet, omega, alpha, tau_d, slip, branch, release, traction, p)


def _kinematics(
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


def _driving_force(
    parameters: Parameters, facet: Facet | None, alpha: Floats, tau_d: Floats, p: Floats | None
) -> Floats:
    """Energy A released per unit of wear: alpha (p dg/domega - tau_t ds_t/domega) = -alpha dpsi_d/domega."""
    if facet is None or not parameters.wears:
        return np.zeros_like(alpha)
    return alpha * (p * facet.by_omega[..., 0] - tau_d[..., 0] * facet.by_omega[..., 1])


def _crushed(parameters: Parameters, p: Floats) -> Floats:
    """Share 1 - log(1 + x)/x of a facet that the pressure p = x crush crushes."""
    x = p / parameters.crush
    series = sum((-1.0) ** n * x**n / (n + 1.0) for n in range(9, 0, -1))
    return np.where(x.real > 1e-2, 1.0 - np.log1p(x) / np.where(x.real > 0.0, x, 1.0), -series)


def _pressure_factor(parameters: Parameters, frame: Floats, s: Floats) -> Floats:
    """Part (..., k) of the pressure that crushes the facets at a separation s (..., 3), 0 to 1.

    At a constant separation a facet releases p c^3 (z + rho w z'^2 - (tau/p) (rho z - w) z') per unit of rho
    that it loses, with the unworn z and z'.  The factor is the bracket over z for tau = mu p, each term at
    the rho of 0 to 1 that makes it smallest; where this is negative, and at and below the foot, it is 0.
    """
    axes, slope = uphill_axes(frame)
    w, u, _ = np.moveaxis(np.einsum("kab,...b->...ka", axes, s), -1, 0)
    climbs = (u.real > 0.0) & (slope > PARALLEL)
    z, dz, _ = profile(np.where(climbs, u, 1.0), np.where(climbs, slope, 1.0), parameters.height)
    rub = parameters.mu * _positive(z - w) * dz
    return np.where(climbs, _positive(1.0 - (rub - np.where(w.real < 0.0, w, 0.0) * dz**2) / z), 0.0)


def _omega(parameters: Parameters, start: _Start, s: Floats, known: Floats | None) -> Floats:
    """Worn share (..., k) of the facets after an increment to s, the offset included.

    The pressure of a facet and the share that it crushes belong together; bisection finds them, and a step of
    Newton's method their derivative.
    """
    if parameters.crush == 0.0:
        return start.omega

    def missing(s: Floats, omega: Floats) -> Floats:
        p = _pressure(parameters, _kinematics(parameters, start.frame, s, omega)[1])
        return _crushed(parameters, _pressure_factor(parameters, start.frame, s) * p) - omega

    if known is None:
        low, high = np.zeros_like(start.omega), np.ones_like(start.omega)
        for _ in range(60):
            middle = 0.5 * (low + high)
            more = missing(s.real, middle) > 0.0
            low, high = np.where(more, middle, low), np.where(more, high, middle)
        known = np.maximum(low, start.omega)
    if not np.iscomplexobj(s):
        return known
    slope = missing(s.real, known + 1j * IMAGINARY).imag / IMAGINARY
    return known - np.where(known > start.omega, 1j * missing(s, known).imag / slope, 0.0)


def _rounding(parameters: Parameters, s_before: Floats, s_new: Floats) -> Floats:
    """What rounding may leave of a trapezoid of Y (..., k) that is zero."""
    closed = np.maximum(_stiffness(parameters, s_before), _stiffness(parameters, s_new))
    normal = np.maximum(parameters.Kn, closed) * (s_before[..., 0] ** 2 + s_new[..., 0] ** 2)
    size = normal + parameters.Kt * (s_before[..., 1:] ** 2 + s_new[..., 1:] ** 2).sum(-1)
    return GUARD_ROUNDINGS * np.finfo(float).eps * size


def _damage(parameters: Parameters, s: Floats, alpha_old: Floats, dt: float) -> Floats:
    """Damage of every plane by (24), (25).

    With tau_v > 0 the damage solves tau_v (alpha - alpha_old) = dt (target - alpha), where target is the
    damage of (7) without its history; the damage is never below alpha_old.
    """
    opening = _positive(s[..., 0]) / parameters.s0
    r = _size(np.concatenate([opening[..., None], s[..., 1:] / parameters.s02], axis=-1))  # 1 + beta, (6)
    beyond = np.where(r.real > 1.0, r, 1.0)  # for beta < 0 the damage keeps its old value
    target = (beyond - 1.0) / beyond / parameters.eta
    target = reached = np.where(target.real < 1.0, target, 1.0)
    if parameters.tau_v > 0.0:
        reached = (parameters.tau_v * alpha_old + dt * target) / (parameters.tau_v + dt)
    # damage grows only if it was below the target by more than rounding
    growing = (target.real > alpha_old) & (reached.real > alpha_old)
    return np.where(growing, reached, alpha_old)


def _viscous(
    parameters: Parameters, start: _Start, contact: Floats, dt: float
) -> tuple[Floats, Floats, float]:
    """Pressure with that of the dashpot, and what the dashpot along the plane adds to the stress of a spring.

    The pressure is c times the rate of the closure beside the elastic one, never negative, and 0 where the
    plane is open.  Along the plane the stress of a spring Kt with the elongation e is Kt e + ct e', with
    ct = c Kt/(kc Kn): in the increment it is (Kt + rate) e - pull, with the rate ct/dt.
    """
    closing = _closure(parameters, contact)[0] - _closure(parameters, start.contact)[0]
    p = _positive(_pressure(parameters, contact) + parameters.c / dt * closing)
    rate = parameters.c * parameters.Kt / (parameters.kc * parameters.Kn * dt)
    pull = rate * (start.contact[..., 1:] - start.slip)
    return np.where(contact[..., 0].real <= 0.0, p, 0.0), pull, rate


def _damped(parameters: Parameters, start: _Start, end: _End, dt: float) -> tuple[Floats, Floats]:
    """Losses (..., k) of friction, and of the dashpots across and along the planes.

    Friction: the trapezoid of the elastic strength and, in addition, the viscous part at the end.  Dashpot:
    viscous stress times change; where no tension lets it pull, the energy that the contact sets free.
    """
    elastic, before = _pressure(parameters, end.contact), _pressure(parameters, start.contact)
    strength = 0.5 * (start.alpha * before + end.alpha * elastic) + end.alpha * (end.p - elastic)
    slipped = np.linalg.norm(end.slip - start.slip, axis=-1)
    friction = parameters.mu * np.maximum(strength, 0.0) * slipped
    rate = parameters.c / dt if dt > 0.0 else 0.0
    closing = _closure(parameters, end.contact)[0] - _closure(parameters, start.contact)[0]
    freed = _closing(parameters, start.contact) - _closing(parameters, end.contact)
    across = rate * closing**2
    across = np.where(closing < 0.0, np.minimum(across, freed), across)
    stretch = (end.contact[..., 1:] - end.slip) - (start.contact[..., 1:] - start.slip)
    along = rate * parameters.Kt / (parameters.kc * parameters.Kn) * (stretch**2).sum(-1)
    return friction, end.alpha * (across + along)


def _friction(
    parameters: Parameters, s: Floats, slip_old: Floats, p: Floats, pull: Floats, rate: float
) -> tuple[Floats, Floats, NDArray[np.int8]]:
    """Return mapping (30)-(39) of every plane: friction traction tau_d, slip s_di, branch."""
    trial = (parameters.Kt + rate) * (s[..., 1:] - slip_old) - pull
    size = _size(trial)
    strength = parameters.mu * p
    sticks = size.real <= strength.real
    scale = np.where(sticks, 1.0, strength / np.where(sticks, 1.0, size))
    tau_d = scale[..., None] * trial
    slip = np.where(sticks[..., None], slip_old, s[..., 1:] - (tau_d + pull) / (parameters.Kt + rate))
    branch = np.where(s[..., 0].real > 0.0, OPEN, np.where(sticks, STICK, SLIP)).astype(np.int8)
    return tau_d, slip, branch


def _closure(parameters: Parameters, s: Floats) -> tuple[Floats, Floats]:
    """Closure (..., k) of contacts, and its part up to MOST_CLOSED of the largest one."""
    c = _positive(-s[..., 0])
    most = MOST_CLOSED * parameters.closure
    return c, np.where(c.real < most, c, most)


def _pressure(parameters: Parameters, s: Floats) -> Floats:
    """Contact pressure p >= 0 of the damaged part, from (13): -kc Kn min(s_n, 0), or Bandis' hyperbola."""
    c, bend = _closure(parameters, s)
    if parameters.closure == 0.0:
        return parameters.kc * parameters.Kn * c
    Vm = parameters.closure
    return parameters.kc * parameters.Kn * bend * Vm / (Vm - bend) + _stiffness(parameters, s) * (c - bend)


def _stiffness(parameters: Parameters, s: Floats) -> Floats:
    """Derivative of the contact pressure with respect to the closure; beyond MOST_CLOSED it is constant."""
    c, bend = _closure(parameters, s)
    if parameters.closure == 0.0:
        return np.full(c.shape, parameters.kc * parameters.Kn)
    return parameters.kc * parameters.Kn * (parameters.closure / (parameters.closure - bend)) ** 2


def _release_rate(parameters: Parameters, s: Floats, contact: Floats, slip: Floats) -> Floats:
    """Energy Y released per unit growth of damage: stored energy of the undamaged less the damaged part."""
    whole = (s[..., 1:] ** 2).sum(-1)
    elastic = ((contact[..., 1:] - slip) ** 2).sum(-1)
    opening = 0.5 * parameters.Kn * _positive(s[..., 0]) ** 2
    closing = _closing(parameters, s) - _closing(parameters, contact)
    return opening + 0.5 * parameters.Kt * (whole - elastic) + closing


def _stored(parameters: Parameters, s: Floats, contact: Floats, alpha: Floats, slip: Floats) -> Floats:
    """Stored energy psi of every plane, the potential of (11) and (16) weighted as in (4)."""
    elastic = 0.5 * parameters.Kt * ((contact[..., 1:] - slip) ** 2).sum(-1)
    damaged = _closing(parameters, contact) + elastic
    undamaged = damaged + _release_rate(parameters, s, contact, slip)
    return (1.0 - alpha) * undamaged + alpha * damaged


def _closing(parameters: Parameters, s: Floats) -> Floats:
    """Energy stored in a closed contact: the integral of its pressure."""
    c, bend = _closure(parameters, s)
    if parameters.closure == 0.0:
        return 0.5 * parameters.kc * parameters.Kn * c**2
    Vm = parameters.closure
    x = bend / Vm
    # -x - log(1 - x), by its series where the terms would cancel
    series = sum(x**n / n for n in range(2, 40))
    integral = np.where(x.real < 0.2, series, -x - np.log1p(-x))
    edge = bend * Vm / (Vm - bend)
    hyperbola = parameters.kc * parameters.Kn * (Vm**2 * integral + edge * (c - bend))
    return hyperbola + 0.5 * _stiffness(parameters, s) * (c - bend) ** 2
