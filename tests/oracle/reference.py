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

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .facet import Facet, facets, uphill_axes

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
    closure: largest closure of the hyperbolic contact, length, 0 for linear.
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


@dataclass(frozen=True)
class SlipHistory:
    """Confined slip: separation and traction (T, [B,] 3), damage (T, [B]), state (T, [B,] 8+3k);
    work (T, [B]) of the traction on the separation, by the trapezoidal rule, the preload included.

    Rows after a lost equilibrium are NaN.
    """

    separation: Floats
    traction: Floats
    damage: Floats
    state: Floats
    work: Floats


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
    independent points.  dt is the duration of the increment, which has an effect only if tau_v > 0.  The
    guard uses the mean of the energy release Y at the start and at the end.
    """
    gamma = pattern[1]
    frame = frames(pattern[0])
    s = np.asarray(s, dtype=float)
    lead = s.shape[:-1]
    blank = virgin(pattern, parameters.wears)
    state = np.broadcast_to(blank if state is None else state, (*lead, len(blank)))
    s_old = np.broadcast_to(np.zeros(3) if s_old is None else s_old, s.shape)
    offset = state[..., 5:8]
    alpha_old, slip_old = _histories(parameters, state, len(gamma))
    omega_old, work_old = _wear_histories(state, len(gamma))

    start = _start(parameters, frame, s_old + offset, state)
    omega, pressed = _omega(parameters, frame, s + offset, start)
    kinematics = s_new, contact, facet = _kinematics(parameters, frame, s + offset, omega)

    returned = tau_d, slip, _, branch = _friction(parameters, contact, slip_old)
    release = _release_rate(parameters, start.straight, start.contact, slip_old)
    release = release + _release_rate(parameters, s_new, contact, slip)
    alpha, slope = _damage(parameters, s_new, alpha_old, dt)
    if parameters.guard:
        gives_back = release < -_rounding(parameters, start.straight, s_new)
        alpha = np.where(gives_back, alpha_old, alpha)
        slope = np.where(gives_back[..., None], 0.0, slope)
    damage = alpha, slope
    traction, tangent = _assemble(parameters, frame, gamma, kinematics, damage, returned)
    if pressed.any():
        whole = s + offset, omega, alpha, slip_old
        tangent = tangent + _crushing_tangent(parameters, frame, gamma, *whole, pressed)

    # Energies per unit area; the start of the increment is evaluated from the given state.
    strength_before = parameters.mu * alpha_old * _pressure(parameters, start.contact)
    strength = parameters.mu * alpha * _pressure(parameters, contact)
    friction = 0.5 * (strength_before + strength) * np.linalg.norm(slip - slip_old, axis=-1)
    drive = _driving_force(parameters, facet, alpha, tau_d)
    wear = 0.5 * (np.maximum(start.drive, 0.0) + np.maximum(drive, 0.0)) * (omega - omega_old)
    work = work_old + np.where(drive > 0.0, friction, 0.0)

    out = np.empty(state.shape, traction.dtype)
    out[..., 0] = (gamma * alpha).sum(-1)
    out[..., 1] = (gamma * _stored(parameters, s_new, contact, alpha, slip)).sum(-1)
    out[..., 2] = state[..., 2] + (gamma * 0.5 * release * (alpha - alpha_old)).sum(-1)
    out[..., 3] = state[..., 3] + (gamma * (friction + wear)).sum(-1)
    out[..., 4] = 1.0
    out[..., 5:8] = offset
    entries = [np.concatenate([alpha[..., None], slip], axis=-1)]
    if parameters.wears:
        entries.append(np.stack([omega, work], axis=-1))
    out[..., HEADER:] = np.concatenate([entry.reshape(*lead, -1) for entry in entries], axis=-1)
    return Response(traction, out, tangent, branch, alpha > alpha_old)


def replay(
    parameters: Parameters, pattern: Pattern, S: ArrayLike, times: ArrayLike | None = None
) -> Response:
    """The law along a history S (T, ..., 3) of separations from a virgin point; T leads every field.

    times (T,) are the ends of the increments, the first of which starts at 0; None: all durations are 0.
    """
    S = np.asarray(S, dtype=float)
    state = np.zeros((*S.shape[1:-1], len(virgin(pattern, parameters.wears))))
    s_old = np.zeros(S.shape[1:])
    steps = []
    clock = np.concatenate([[0.0], np.zeros(len(S)) if times is None else np.asarray(times, dtype=float)])
    for s, dt in zip(S, np.diff(clock), strict=True):
        steps.append(update(parameters, pattern, s, state, s_old, float(dt)))
        state, s_old = steps[-1].state, s
    names = (entry.name for entry in fields(Response))
    return Response(*(np.stack([getattr(step, name) for step in steps]) for name in names))


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


def _kinematics(
    parameters: Parameters, frame: Floats, s: Floats, omega: Floats
) -> tuple[Floats, Floats, Facet | None]:
    """Components (..., k, 3) of a separation s (..., 3) on the straight planes and on their facets.

    Bond and damage take the first, contact and friction the second.  Without height and wear the facet is the
    plane itself (None).
    """
    straight = _resolve(frame, s)
    if not parameters.curved:
        return straight, straight, None
    facet = facets(frame, s, parameters.height, omega)
    return straight, facet.local, facet


def _driving_force(parameters: Parameters, facet: Facet | None, alpha: Floats, tau_d: Floats) -> Floats:
    """Energy A released per unit of wear: alpha (p dg/domega - tau_t ds_t/domega) = -alpha dpsi_d/domega."""
    if facet is None or not parameters.wears:
        return np.zeros_like(alpha)
    p = _pressure(parameters, facet.local)
    return alpha * (p * facet.by_omega[..., 0] - tau_d[..., 0] * facet.by_omega[..., 1])


def _crushed(parameters: Parameters, p: Floats) -> Floats:
    """Share 1 - log(1 + x)/x of a facet that the pressure p = x crush crushes; 0 without crushing."""
    if parameters.crush == 0.0:
        return np.zeros_like(p)
    x = p / parameters.crush
    series = sum((-1.0) ** n * x**n / (n + 1.0) for n in range(9, 0, -1))
    return np.where(x > 1e-2, 1.0 - np.log1p(x) / np.where(x > 0.0, x, 1.0), -series)


def _omega(
    parameters: Parameters, frame: Floats, s: Floats, start: _Start
) -> tuple[Floats, NDArray[np.bool_]]:
    """Worn share (..., k) of the facets after an increment to s, and whether the pressure there sets it.

    The pressure of a facet and the share that it crushes belong together; bisection finds them.  A flank
    below its foot is not crushed.
    """
    if parameters.crush == 0.0:
        return start.omega, np.zeros(start.omega.shape, bool)

    def missing(omega: Floats) -> Floats:
        contact = _kinematics(parameters, frame, s, omega)[1]
        return _crushed(parameters, _pressure(parameters, contact)) - omega

    low, high = np.zeros_like(start.omega), np.ones_like(start.omega)
    for _ in range(60):
        middle = 0.5 * (low + high)
        more = missing(middle) > 0.0
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    axes, _ = uphill_axes(frame)
    above = np.einsum("ka,...a->...k", axes[:, 1], s) >= 0.0
    pressed = start.crushable & above & (low > start.omega)
    return np.where(pressed, low, start.omega), pressed


def _crushing_tangent(
    parameters: Parameters,
    frame: Floats,
    gamma: Floats,
    s: Floats,
    omega: Floats,
    alpha: Floats,
    slip_old: Floats,
    pressed: NDArray[np.bool_],
) -> Floats:
    """Derivative (..., 3, 3) of the traction by the separation through the shares that its pressure crushes.

    The traction is differentiated by omega with central differences, the pressure on the left of zero.
    """
    _, contact, facet = _kinematics(parameters, frame, s, omega)
    p, step = _pressure(parameters, contact), 1e-6
    by_gap = (_crushed(parameters, p * (1 + step)) - _crushed(parameters, p * (1 - step))) / np.where(
        p > 0.0, 2.0 * step * p, 1.0
    )
    by_gap = by_gap * _stiffness(parameters, contact)
    rate = np.where(pressed, -by_gap / (1.0 + by_gap * facet.by_omega[..., 0]), 0.0)

    def tractions(omega: Floats) -> Floats:
        _, contact, facet = _kinematics(parameters, frame, s, omega)
        tau_d = _friction(parameters, contact, slip_old)[0]
        sigma = np.concatenate([-_pressure(parameters, contact)[..., None], tau_d], axis=-1)
        return np.einsum("...kab,...ka->...kb", facet.gradient, alpha[..., None] * sigma)

    # a step that is small beside the gap and the elastic slip
    length = np.abs(contact[..., 0]) + np.linalg.norm(contact[..., 1:] - slip_old, axis=-1)
    size = np.abs(facet.by_omega).max(axis=-1)
    step = 1e-5 * np.where(size > 0.0, length / np.where(size > 0.0, size, 1.0), 0.0) + 1e-12
    slope = (tractions(omega + step) - tractions(omega - step)) / (2.0 * step)[..., None]
    return np.einsum("k,...ka,...k,...kb->...ab", gamma, slope, rate, facet.gradient[..., 0, :])


@dataclass(frozen=True)
class _Start:
    """Start of an increment: separations and facets there, friction traction, driving force.

    omega: of the frictional work so far; crushable: whether the pressure may crush a facet in the increment.
    """

    straight: Floats
    contact: Floats
    facet: Facet | None
    tau_d: Floats
    drive: Floats
    omega: Floats
    crushable: NDArray[np.bool_]


def _start(parameters: Parameters, frame: Floats, s_old: Floats, state: Floats) -> _Start:
    """Start of an increment at s_old (..., 3), the offset included; wear by work is known there already."""
    alpha, slip = _histories(parameters, state, len(frame))
    omega, work = _wear_histories(state, len(frame))
    straight, contact, facet = _kinematics(parameters, frame, s_old, omega)
    tau_d = parameters.Kt * (contact[..., 1:] - slip)
    drive = _driving_force(parameters, facet, alpha, tau_d)
    if parameters.W0 > 0.0:
        omega = np.where(drive > 0.0, np.maximum(omega, -np.expm1(-work / parameters.W0)), omega)
    # a damaged facet must have been climbed, and its wear must open the contact
    crushable = np.broadcast_to(frame[:, 1, 0] / frame[:, 0, 0] > PARALLEL, alpha.shape)
    if facet is not None:
        climbed = (facet.height > 0.0) & (facet.by_omega[..., 0] >= 0.0)
        crushable = crushable & (climbed | (alpha == 0.0))
    return _Start(straight, contact, facet, tau_d, drive, omega, crushable)


def _rounding(parameters: Parameters, s_before: Floats, s_new: Floats) -> Floats:
    """What rounding may leave of a trapezoid of Y (..., k) that is zero."""
    closed = np.maximum(_stiffness(parameters, s_before), _stiffness(parameters, s_new))
    normal = np.maximum(parameters.Kn, closed) * (s_before[..., 0] ** 2 + s_new[..., 0] ** 2)
    size = normal + parameters.Kt * (s_before[..., 1:] ** 2 + s_new[..., 1:] ** 2).sum(-1)
    return GUARD_ROUNDINGS * np.finfo(size.dtype).eps * size


def _resolve(frame: Floats, s: Floats) -> Floats:
    """Components (..., k, 3) along n, t, h of every plane of the one separation (..., 3), (2)."""
    return np.einsum("kab,...b->...ka", frame, s)


def _traction(
    frame: Floats, gamma: Floats, alpha: Floats, undamaged: Floats, damaged: Floats, facet: Facet | None
) -> Floats:
    """Traction (..., 3) of the interface from the local tractions of bond and contact, (3), (22)."""
    undamaged, damaged = (1.0 - alpha)[..., None] * undamaged, alpha[..., None] * damaged
    if facet is None:
        return np.einsum("k,kab,...ka->...b", gamma, frame, undamaged + damaged)
    straight = np.einsum("k,kab,...ka->...b", gamma, frame, undamaged)
    return straight + np.einsum("k,...kab,...ka->...b", gamma, facet.gradient, damaged)


def _assemble(
    parameters: Parameters,
    frame: Floats,
    gamma: Floats,
    kinematics: tuple[Floats, Floats, Facet | None],
    damage: tuple[Floats, Floats],
    friction: tuple[Floats, Floats, Floats, NDArray[np.int8]],
) -> tuple[Floats, Floats]:
    """Traction (..., 3) and tangent (..., 3, 3) from the local separations, damage and friction."""
    s, contact, facet = kinematics
    alpha, damage_slope = damage
    tau_d, _, trial, branch = friction
    undamaged, damaged = _parts(parameters, s, contact, tau_d)
    traction = _traction(frame, gamma, alpha, undamaged, damaged, facet)
    Q, Q_T = frame, frame.transpose(0, 2, 1)
    if facet is None:
        local = _tangent(parameters, s, alpha, trial, branch)
        local = local + (damaged - undamaged)[..., :, None] * damage_slope[..., None, :]
        return traction, (gamma[:, None, None] * Q_T @ local @ Q).sum(-3)
    none, all_ = np.zeros_like(alpha), np.ones_like(alpha)
    share = alpha[..., None, None]
    D_u = _tangent(parameters, s, none, trial, np.where(s[..., 0] > 0.0, OPEN, STICK))
    D_d = _tangent(parameters, contact, all_, trial, branch)
    G, G_T = facet.gradient, np.swapaxes(facet.gradient, -1, -2)
    of_geometry = np.einsum("...i,...iab->...ab", damaged[..., :2], facet.curvature)
    change = np.einsum("...ab,...a->...b", G, damaged) - np.einsum("kab,...ka->...kb", Q, undamaged)
    of_damage = change[..., :, None] * np.einsum("kab,...ka->...kb", Q, damage_slope)[..., None, :]
    plane = (1.0 - share) * (Q_T @ D_u @ Q) + share * (G_T @ D_d @ G + of_geometry) + of_damage
    return traction, (gamma[:, None, None] * plane).sum(-3)


def _damage(parameters: Parameters, s: Floats, alpha_old: Floats, dt: float = 0.0) -> tuple[Floats, Floats]:
    """Damage of every plane by (24), (25), and its derivative with respect to the local separation.

    With tau_v > 0 the damage solves tau_v (alpha - alpha_old) = dt (target - alpha), where target is the
    damage of (7) without its history; the damage is never below alpha_old.
    """
    opening = np.maximum(s[..., 0], 0.0)
    scaled = np.stack(
        [opening / parameters.s0**2, s[..., 1] / parameters.s02**2, s[..., 2] / parameters.s02**2], axis=-1
    )
    r = np.sqrt(scaled[..., 0] * opening + (scaled[..., 1:] * s[..., 1:]).sum(-1))  # 1 + beta, (6)
    beyond = np.maximum(r, 1.0)  # for beta < 0 the damage keeps its old value
    target = (beyond - 1.0) / beyond / parameters.eta
    slope = np.where(target < 1.0, 1.0 / (parameters.eta * beyond**3), 0.0)
    reached, share = np.minimum(1.0, target), 1.0
    if parameters.tau_v > 0.0:
        share = dt / (parameters.tau_v + dt)
        reached = (parameters.tau_v * alpha_old + dt * reached) / (parameters.tau_v + dt)
    # damage grows only if it was below the target by more than rounding
    growing = (np.minimum(1.0, target) > alpha_old) & (share > 0.0)
    alpha = np.where(growing, np.maximum(alpha_old, reached), alpha_old)
    slope = np.where(growing, share * slope, 0.0)
    return alpha, slope[..., None] * scaled


def _friction(
    parameters: Parameters, s: Floats, slip_old: Floats
) -> tuple[Floats, Floats, Floats, NDArray[np.int8]]:
    """Return mapping (30)-(39) of every plane: friction traction tau_d, slip s_di, trial traction, branch."""
    trial = parameters.Kt * (s[..., 1:] - slip_old)
    size = np.linalg.norm(trial, axis=-1)
    strength = parameters.mu * _pressure(parameters, s)
    sticks = size <= strength
    scale = np.where(sticks, 1.0, strength / np.where(sticks, 1.0, size))
    tau_d = scale[..., None] * trial
    slip = np.where(sticks[..., None], slip_old, s[..., 1:] - tau_d / parameters.Kt)
    branch = np.where(s[..., 0] > 0.0, OPEN, np.where(sticks, STICK, SLIP)).astype(np.int8)
    return tau_d, slip, trial, branch


def _pressure(parameters: Parameters, s: Floats) -> Floats:
    """Contact pressure p >= 0 of the damaged part, from (13): -kc Kn min(s_n, 0), or Bandis' hyperbola."""
    c = np.maximum(-s[..., 0], 0.0)
    if parameters.closure == 0.0:
        return parameters.kc * parameters.Kn * c
    Vm = parameters.closure
    bend = np.minimum(c, MOST_CLOSED * Vm)
    return parameters.kc * parameters.Kn * bend * Vm / (Vm - bend) + _stiffness(parameters, s) * (c - bend)


def _stiffness(parameters: Parameters, s: Floats) -> Floats:
    """Derivative of the contact pressure with respect to the closure; beyond MOST_CLOSED it is constant."""
    c = np.maximum(-s[..., 0], 0.0)
    closing = np.full(c.shape, parameters.kc * parameters.Kn, c.dtype)
    if parameters.closure == 0.0:
        return closing
    Vm = parameters.closure
    return closing * (Vm / (Vm - np.minimum(c, MOST_CLOSED * Vm))) ** 2


def _parts(parameters: Parameters, s: Floats, contact: Floats, tau_d: Floats) -> tuple[Floats, Floats]:
    """Local tractions of the undamaged part (11) and of the damaged part (13), (23)."""
    normal = parameters.Kn * np.maximum(s[..., 0], 0.0) - _pressure(parameters, s)
    undamaged = np.concatenate([normal[..., None], parameters.Kt * s[..., 1:]], axis=-1)
    damaged = np.concatenate([-_pressure(parameters, contact)[..., None], tau_d], axis=-1)
    return undamaged, damaged


def _tangent(
    parameters: Parameters, s: Floats, alpha: Floats, trial: Floats, branch: NDArray[np.int8]
) -> Floats:
    """Derivative (..., k, 3, 3) of the local traction (22) at constant damage, consistent with (30)-(39).

    At s_n = 0 this is the derivative for closing, except that slip there has no coupling to s_n.
    """
    closing = _stiffness(parameters, s)
    out = np.zeros((*alpha.shape, 3, 3))
    open_ = branch == OPEN
    out[..., 0, 0] = np.where(open_, (1.0 - alpha) * parameters.Kn, closing)
    eye = np.eye(2)
    size = np.linalg.norm(trial, axis=-1)
    slips = branch == SLIP
    m = trial / np.where(slips, size, 1.0)[..., None]
    sliding = parameters.mu * _pressure(parameters, s) / np.where(slips, size, 1.0)
    across = eye - m[..., :, None] * m[..., None, :]
    friction = np.where(
        slips[..., None, None],
        sliding[..., None, None] * across,
        np.where(open_, 0.0, 1.0)[..., None, None] * eye,
    )
    share = alpha[..., None, None]
    out[..., 1:, 1:] = parameters.Kt * ((1.0 - share) * eye + share * friction)
    coupled = slips & (s[..., 0] < 0.0)
    out[..., 1:, 0] = np.where(coupled, -alpha * parameters.mu * closing, 0.0)[..., None] * m
    return out


def _release_rate(parameters: Parameters, s: Floats, contact: Floats, slip: Floats) -> Floats:
    """Energy Y released per unit growth of damage: stored energy of the undamaged less the damaged part."""
    whole = (s[..., 1:] ** 2).sum(-1)
    elastic = ((contact[..., 1:] - slip) ** 2).sum(-1)
    opening = 0.5 * parameters.Kn * np.maximum(s[..., 0], 0.0) ** 2
    closing = _closing(parameters, s) - _closing(parameters, contact)
    return opening + 0.5 * parameters.Kt * (whole - elastic) + closing


def _stored(parameters: Parameters, s: Floats, contact: Floats, alpha: Floats, slip: Floats) -> Floats:
    """Stored energy psi of every plane, the potential of (11) and (16) weighted as in (4)."""
    opening = 0.5 * parameters.Kn * np.maximum(s[..., 0], 0.0) ** 2
    whole = 0.5 * parameters.Kt * (s[..., 1:] ** 2).sum(-1)
    elastic = 0.5 * parameters.Kt * ((contact[..., 1:] - slip) ** 2).sum(-1)
    undamaged = opening + _closing(parameters, s) + whole
    return (1.0 - alpha) * undamaged + alpha * (_closing(parameters, contact) + elastic)


def _closing(parameters: Parameters, s: Floats) -> Floats:
    """Energy stored in a closed contact: the integral of its pressure."""
    c = np.maximum(-s[..., 0], 0.0)
    if parameters.closure == 0.0:
        return 0.5 * parameters.kc * parameters.Kn * c**2
    Vm = parameters.closure
    bend = np.minimum(c, MOST_CLOSED * Vm)
    x = bend / Vm
    # -x - log(1 - x), by its series where the terms would cancel
    series = sum(x**n / n for n in range(2, 40))
    integral = np.where(x < 0.2, series, -x - np.log1p(-x))
    beyond = c - bend
    edge = np.zeros_like(s)
    edge[..., 0] = -bend
    return (
        parameters.kc * parameters.Kn * Vm**2 * integral
        + _pressure(parameters, edge) * beyond
        + 0.5 * _stiffness(parameters, s) * beyond**2
    )


# --- slip under a constant normal traction -------------------------------

TOLERANCE = 1.0e-12
"""Accepted residual of the normal traction, as a fraction of sigma0 + |sigma_N|."""


def confined_slip(
    parameters: Parameters,
    pattern: Pattern,
    direction: ArrayLike,
    slips: ArrayLike,
    sigma_N: ArrayLike,
    preload_increments: int = 20,
) -> SlipHistory:
    """Slip (T,) prescribed along direction in the Tx-Ty plane under a constant normal traction sigma_N.

    sigma_N is first applied at zero slip in preload_increments equal increments (not rows of the result).
    direction and sigma_N may be arrays (B,): the result then has a second axis B.  No time passes.  The test
    of Sections 4.1 and 4.2; docs/solver.md says which root is followed.
    """
    direction, target = np.broadcast_arrays(
        np.radians(np.asarray(direction, float)), np.asarray(sigma_N, float)
    )
    single = direction.ndim == 0
    direction, target = np.atleast_1d(direction), np.atleast_1d(target)
    lanes = len(direction)
    along = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    point = _HeldPoint(parameters, pattern, lanes)
    for part in range(1, preload_increments + 1):
        point.advance(np.zeros((lanes, 2)), target * part / preload_increments)
    rows = []
    for slip in np.asarray(slips, float):
        point.advance(slip * along, target)
        rows.append((point.s, point.traction, point.state, point.work))
    separation, traction, state, work = (np.stack(column) for column in zip(*rows, strict=True))
    if single:
        separation, traction, state, work = separation[:, 0], traction[:, 0], state[:, 0], work[:, 0]
    return SlipHistory(separation, traction, state[..., 0], state, work)


class _HeldPoint:
    """Points (lanes) whose tangential separation and normal traction are prescribed; unknown: s_N.

    Newton's method with the consistent tangent is accepted only near the last root and on a rising branch;
    otherwise s_N moves in steps from the last root in the sign of (sigma_N - t_N) to the first equilibrium.
    """

    def __init__(self, parameters: Parameters, pattern: Pattern, lanes: int) -> None:
        self.parameters = parameters
        self.pattern = pattern
        self.s = np.zeros((lanes, 3))
        self.traction = np.zeros((lanes, 3))
        self.work = np.zeros(lanes)
        self.state = np.tile(virgin(pattern, parameters.wears), (lanes, 1))

    def advance(self, s_T: Floats, sigma_N: Floats) -> None:
        """Move every lane to s_T (B, 2) and sigma_N (B,); a lane without equilibrium is NaN from then on."""
        alive = np.isfinite(self.s[:, 0])
        s = np.concatenate([self.s[:, :1], s_T], axis=-1)
        trusted = np.zeros(len(s), dtype=bool)
        if alive.any():
            trusted[alive] = self._newton(s, sigma_N, np.flatnonzero(alive))
        for lane in np.flatnonzero(alive & ~trusted):
            s[lane, 0] = self._march(lane, s_T[lane], sigma_N[lane])
        found = np.isfinite(s[:, 0])
        s[~found] = np.nan
        state, traction = np.full_like(self.state, np.nan), np.full_like(self.traction, np.nan)
        if found.any():
            answer = update(self.parameters, self.pattern, s[found], self.state[found], self.s[found])
            state[found], traction[found] = answer.state, answer.traction
        self.work = self.work + 0.5 * ((self.traction + traction) * (s - self.s)).sum(-1)
        self.s, self.traction, self.state = s, traction, state

    def _normal(self, s: Floats, lanes: NDArray[np.intp] | int) -> tuple[Floats, Floats]:
        """Normal traction (...) and its slope dt_N/ds_N at trial separations (..., 3) of lanes."""
        answer = update(self.parameters, self.pattern, s, self.state[lanes], self.s[lanes])
        return answer.traction[..., 0], answer.tangent[..., 0, 0]

    def _tolerance(self, sigma_N: Floats) -> Floats:
        return TOLERANCE * (self.parameters.sigma0 + np.abs(sigma_N))

    def _newton(self, s: Floats, sigma_N: Floats, lanes: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Newton iterations on the given lanes, in place on s[:, 0]; True where the root is accepted."""
        shift = np.linalg.norm(s[lanes, 1:] - self.s[lanes, 1:], axis=-1)
        change = np.abs(sigma_N[lanes] - np.nan_to_num(self.traction[lanes, 0]))
        reach = 2.0 * shift + 10.0 * change / self.parameters.Kn
        good = np.ones(len(lanes), dtype=bool)
        busy = np.ones(len(lanes), dtype=bool)
        for _ in range(15):
            i = lanes[busy]
            t_N, slope = self._normal(s[i], i)
            residual = sigma_N[i] - t_N
            good[busy] &= slope > 0.0
            moving = (np.abs(residual) > self._tolerance(sigma_N[i])) & good[busy]
            busy[busy] = moving
            if not busy.any():
                break
            s[i[moving], 0] += residual[moving] / slope[moving]
            good[busy] &= np.abs(s[i[moving], 0] - self.s[i[moving], 0]) <= reach[busy]
            busy &= good
            if not busy.any():
                break
        return good & ~busy

    def _march(self, lane: int, s_T: Floats, sigma_N: float) -> float:
        """First equilibrium from the last s_N on, in the direction of the residual; NaN if there is none."""
        tolerance = float(self._tolerance(np.asarray(sigma_N)))
        old = self.s[lane]

        def residual(x: float) -> tuple[float, float]:
            t_N, slope = self._normal(np.array([x, *s_T]), lane)
            value = sigma_N - float(t_N)
            return 0.0 if abs(value) <= tolerance else value, float(slope)

        here = float(old[0])
        r_here, slope = residual(here)
        if r_here == 0.0:
            if slope != 0.0:
                return here
            # If fully damaged and open states are all equilibria, take the one with the smallest |s_N|.
            return 0.0 if residual(0.0)[0] == 0.0 else _next_root(residual, 0.0, here)
        steepest = 1.0 / self.pattern[0][:, 0].min()
        far = 2.0 * steepest * (self.parameters.sf + float(np.linalg.norm(s_T)))  # all planes open
        step = np.sign(r_here) * self.parameters.s0 / 50.0
        while (here <= far) if step > 0.0 else (here >= -1.0e6 * far):
            there = here + step
            if residual(there)[0] * r_here <= 0.0:
                return _next_root(residual, here, there)
            here, step = there, 1.05 * step
        return float("nan")


def _next_root(residual: Callable[[float], tuple[float, float]], start: float, end: float) -> float:
    """Root nearest to start, by bisection; the residual changes its sign, or becomes zero, before end."""
    sign = np.sign(residual(start)[0])
    while (middle := 0.5 * (start + end)) not in (start, end):
        if residual(middle)[0] * sign > 0.0:
            start = middle
        else:
            end = middle
    return end
