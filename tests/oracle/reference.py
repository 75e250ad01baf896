"""Independent NumPy reference of the interface law of Albarella, Serpieri, Alfano and Sacco (2015).

The tests compare the library with this module.  It uses nothing of the library: it was written from the
equations of the paper with the corrections listed in docs/theory.md.  Numbers in round brackets are equations
of the paper.  Components are (N, Tx, Ty), tension and opening are positive, angles are in degrees, units are
the user's consistent set.  Finite asperity height and wear go beyond the paper: the contact of an inclined
plane is then a curved facet (facet.py), while bond and damage are those of the straight plane (plane.py).

A pattern is the pair ``(normals, weights)`` of shapes (k, 3) and (k,).  A state has 8 + 3 k entries: damage,
stored, rupture and friction (with wear) per unit area, status, the three offsets of the separation, and then
(alpha, s_dit, s_dih) of every plane.  With wear, (omega, frictional work) of every plane follow them.
Zeros are a virgin point.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import accounts, plane
from .facet import Facet, Some, gaps
from .plane import Floats, Parameters

Pattern = tuple[Floats, Floats]

HEADER = 8
"""Entries of the state before those of the planes."""

PER_PLANE = 3
"""Entries of the state per plane: alpha, s_dit, s_dih."""

PER_FACET = 2
"""Entries of the state per plane with wear, after those of all planes: omega, frictional work."""


@dataclass(frozen=True)
class Response:
    """Result of the law: traction (..., 3), state (..., 8+3k or 8+5k), tangent (..., 3, 3).

    Per plane (..., k): the branch of its contact (OPEN, STICK or SLIP) and whether its damage grew.
    long (...): whether the library takes the accounts by the phases of the increment.
    """

    traction: Floats
    state: Floats
    tangent: Floats
    branch: NDArray[np.int8]
    damaging: NDArray[np.bool_]
    long: NDArray[np.bool_]


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
    level = sine <= plane.PARALLEL
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
    part: bool = False,
    tangent: bool = True,
) -> Response:
    """One increment of the law from (s_old, state) to the total separation s, (22)-(39).

    s and s_old are (..., 3), state is as long as ``virgin`` makes it; None means zero.  Leading axes are
    independent points.  dt is the duration of the increment, which has an effect only if tau_v or c > 0; at
    a duration of 0 the dashpot does not act.  The
    guard asks the rupture of the increment.  part: a small part of an increment.  tangent: whether it is
    asked for; without it the array is empty.
    """
    gamma = pattern[1]
    s = np.asarray(s, dtype=float)
    lead = s.shape[:-1]
    blank = virgin(pattern, parameters.wears)
    state = np.broadcast_to(blank if state is None else state, (*lead, len(blank)))
    s_old = np.broadcast_to(np.zeros(3) if s_old is None else s_old, s.shape)
    start = _start(parameters, pattern, s_old, state)
    end = _end(parameters, start, s, dt, part=part)
    step = plane.IMAGINARY * parameters.s0
    columns = np.empty((*lead, 3, 0))
    if tangent:
        shifted = (_end(parameters, start, s + 1j * step * axis, dt, end.omega) for axis in np.eye(3))
        columns = np.stack([end.traction.imag / step for end in shifted], axis=-1)

    # Energies per unit area; the start of the increment is evaluated from the given state.
    alpha, slip = end.alpha, end.slip
    strength_before = parameters.mu * start.alpha * plane.pressure(parameters, start.contact)
    strength = parameters.mu * alpha * plane.pressure(parameters, end.contact)
    way = np.linalg.norm(slip - start.slip, axis=-1)
    friction = 0.5 * (strength_before + strength) * way
    damping = np.zeros_like(friction)
    long = accounts.long(parameters, s_old, s, dt)
    if parameters.c > 0.0:
        friction, damping = _damped(parameters, start, end, dt)
    drive = plane.driving_force(parameters, end.facet, alpha, end.tau_d, end.p)
    omega_old, work_old = _wear_histories(state, len(gamma))
    springs = parameters.Kt * (end.contact[..., 1:] - slip)
    elastic = plane.driving_force(
        parameters, end.facet, alpha, springs, plane.pressure(parameters, end.contact)
    )
    wear = 0.5 * (np.maximum(start.drive, 0.0) + np.maximum(elastic, 0.0)) + (drive - elastic)
    wear = np.maximum(wear, 0.0) * (end.omega - omega_old)
    work = work_old + np.where(drive > 0.0, friction, 0.0)

    out = np.empty(state.shape)
    out[..., 0] = (gamma * alpha).sum(-1)
    out[..., 1] = (gamma * plane.stored(parameters, end.straight, end.contact, alpha, slip)).sum(-1)
    out[..., 2] = state[..., 2] + (gamma * end.rupture).sum(-1)
    out[..., 3] = state[..., 3] + (gamma * (friction + wear + damping)).sum(-1)
    out[..., 4] = 1.0
    out[..., 5:8] = start.offset
    planes = np.concatenate([alpha[..., None], slip], axis=-1)
    out[..., HEADER : HEADER + PER_PLANE * len(gamma)] = planes.reshape(*lead, PER_PLANE * len(gamma))
    if parameters.wears:
        worn = np.stack([end.omega, work], axis=-1)
        out[..., HEADER + PER_PLANE * len(gamma) :] = worn.reshape(*lead, PER_FACET * len(gamma))
    return Response(end.traction, out, columns, end.branch, alpha > start.alpha, long)


def tractions(
    parameters: Parameters, pattern: Pattern, state: Floats, s_old: Floats, dt: float = 0.0
) -> Callable[[Floats], Floats]:
    """Return the traction (..., n, 3) of one increment as a function of its end s (..., n, 3).

    The arguments are those of ``update``, with n points in rows.
    """
    start = _start(parameters, pattern, s_old, state)
    return lambda s: _end(parameters, start, s, dt).traction


def in_parts(
    parameters: Parameters,
    pattern: Pattern,
    s: Floats,
    state: Floats,
    s_old: Floats,
    dt: float = 0.0,
    parts: int = 1000,
) -> Floats:
    """State (n, :) after the straight step of an increment in parts, n points in rows.

    Half of the parts are equal, the others grow in a constant ratio from a millionth of the step.  Rupture
    and friction converge to what the law dissipates along the step.  Wear by work goes on within the step.
    """
    equal = np.linspace(0.0, 1.0, parts // 2 + 1)
    ends = np.unique(np.concatenate([equal, np.geomspace(1e-6, 1.0, parts - parts // 2)]))
    for x, y in itertools.pairwise(ends):
        first, last = (s_old + z * (s - s_old) for z in (x, y))
        state = update(parameters, pattern, last, state, first, (y - x) * dt, True, False).state
    return state


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

    p: pressure of the contact, with that of the dashpot.
    """

    straight: Floats
    contact: Floats
    facet: Facet | None
    omega: Floats
    alpha: Floats
    tau_d: Floats
    slip: Floats
    branch: NDArray[np.int8]
    rupture: Floats
    traction: Floats
    p: Floats


def _start(parameters: Parameters, pattern: Pattern, s_old: Floats, state: Floats) -> _Start:
    """Start of an increment at s_old (..., 3); wear by work is known there already."""
    frame, offset = frames(pattern[0]), state[..., 5:8]
    alpha, slip = _histories(parameters, state, len(frame))
    omega, work = _wear_histories(state, len(frame))
    straight, contact, facet = plane.kinematics(parameters, frame, s_old + offset, omega)
    tau_d = parameters.Kt * (contact[..., 1:] - slip)
    p = None if facet is None else plane.pressure(parameters, contact)
    drive = plane.driving_force(parameters, facet, alpha, tau_d, p)
    if parameters.W0 > 0.0:
        omega = np.where(drive > 0.0, np.maximum(omega, -np.expm1(-work / parameters.W0)), omega)
    return _Start(frame, pattern[1], offset, alpha, slip, straight, contact, drive, omega)


def _end(
    parameters: Parameters,
    start: _Start,
    s: Floats,
    dt: float,
    known: Floats | None = None,
    part: bool = False,
) -> _End:
    """End of an increment to the separation s (..., 3), (22)-(39).  known: worn shares at its real part."""
    s = s + start.offset
    omega = _omega(parameters, start, s, known)
    straight, contact, facet = plane.kinematics(parameters, start.frame, s, omega)
    p = plane.pressure(parameters, contact)
    pull, rate = np.zeros_like(contact[..., 1:]), 0.0
    if parameters.c > 0.0 and dt > 0.0:
        p, pull, rate = _viscous(parameters, start, contact, dt)
    tau_d, slip, branch = plane.friction(parameters, contact, start.slip, p, pull, rate)
    alpha = plane.damage(parameters, straight, start.alpha, dt)
    ends = ((start.straight, straight.real), (start.contact, contact.real), (start.slip, slip.real))
    rupture = accounts.rupture(parameters, *ends, (start.alpha, alpha.real), branch, part)
    if parameters.guard:
        unseen = plane.rounding(parameters, start.straight, straight.real)
        gives_back = rupture < -unseen * (alpha.real - start.alpha)
        alpha, rupture = np.where(gives_back, start.alpha, alpha), np.where(gives_back, 0.0, rupture)

    # local tractions of the undamaged part (11) and of the damaged part (13), (23), weighted by (22)
    normal = parameters.Kn * plane.positive(straight[..., 0]) - plane.pressure(parameters, straight)
    undamaged = np.concatenate([normal[..., None], parameters.Kt * straight[..., 1:]], axis=-1)
    damaged = np.concatenate([-p[..., None], tau_d], axis=-1)
    undamaged, damaged = (1.0 - alpha)[..., None] * undamaged, alpha[..., None] * damaged
    if facet is None:
        traction = np.einsum("k,kab,...ka->...b", start.gamma, start.frame, undamaged + damaged)
    else:
        traction = np.einsum("k,kab,...ka->...b", start.gamma, start.frame, undamaged)
        traction = traction + np.einsum("k,...kab,...ka->...b", start.gamma, facet.gradient, damaged)
    return _End(straight, contact, facet, omega, alpha, tau_d, slip, branch, rupture, traction, p)


def _omega(parameters: Parameters, start: _Start, s: Floats, known: Floats | None) -> Floats:
    """Worn share (..., k) of the facets after an increment to s, the offset included.

    The pressure of a facet and the share that it crushes belong together; a step of Newton's method has their
    derivative.
    """
    if parameters.crush == 0.0:
        return start.omega

    def missing_at(s: Floats) -> Callable[..., Floats]:
        factor, gap = (
            plane.pressure_factor(parameters, start.frame, s),
            gaps(start.frame, s, parameters.height),
        )

        def missing(omega: Floats, some: Some = ...) -> Floats:
            p = plane.pressure(parameters, gap(omega, some)[..., None])
            return plane.crushed(parameters, factor[some] * p) - omega

        return missing

    missing = missing_at(s.real)
    if known is None:
        known = _root(missing, np.broadcast_to(start.omega, (*s.shape[:-1], len(start.gamma))))
    if not np.iscomplexobj(s):
        return known
    slope = missing(known + 1j * plane.IMAGINARY).imag / plane.IMAGINARY
    return known - np.where(known > start.omega, 1j * missing_at(s)(known).imag / slope, 0.0)


def _root(missing: Callable[..., Floats], least: Floats) -> Floats:
    """Where falling functions of shares vanish between `least` and 1, or `least` where they are not above 0.

    Newton's method from `least` on. A step is half of what encloses the root where Newton's leaves it, or
    where the last one did not halve the value: at a kink this goes on to the last bit.
    """
    shares, left = least.copy(), missing(least) > 0.0
    low, root = least[left], least[left]
    high, before = np.ones(low.shape), np.full(low.shape, np.inf)
    for _ in range(200):
        if not left.any():
            break
        value = missing(root + 1j * plane.IMAGINARY, left)
        size = np.abs(value.real)
        low, high = np.where(value.real > 0.0, root, low), np.where(value.real > 0.0, high, root)
        newton = root - value.real * plane.IMAGINARY / value.imag
        inside = (newton >= low) & (newton <= high)
        found = inside & (np.abs(newton - root) <= 16.0 * np.finfo(float).eps)
        shares[left] = np.where(found, newton, low)
        root = np.where(inside & (size < 0.5 * before), newton, 0.5 * (low + high))
        left[left], (low, high, root, before) = ~found, (x[~found] for x in (low, high, root, size))
    assert np.isfinite(shares).all() and (high - low <= 4.0 * np.finfo(float).eps).all()
    return shares


def _viscous(
    parameters: Parameters, start: _Start, contact: Floats, dt: float
) -> tuple[Floats, Floats, float]:
    """Pressure with that of the dashpot, and what the dashpot along the plane adds to the stress of a spring.

    The pressure is c times the rate of the closure beside the elastic one, never negative, and 0 where the
    plane is open.  Along the plane the stress of a spring Kt with the elongation e is Kt e + ct e', with
    ct = c Kt/(kc Kn): in the increment it is (Kt + rate) e - pull, with the rate ct/dt.
    """
    closing = plane.closure(parameters, contact)[0] - plane.closure(parameters, start.contact)[0]
    p = plane.positive(plane.pressure(parameters, contact) + parameters.c / dt * closing)
    rate = parameters.c * parameters.Kt / (parameters.kc * parameters.Kn * dt)
    pull = rate * (start.contact[..., 1:] - start.slip)
    return np.where(contact[..., 0].real <= 0.0, p, 0.0), pull, rate


def _damped(parameters: Parameters, start: _Start, end: _End, dt: float) -> tuple[Floats, Floats]:
    """Losses (..., k) of friction, and of the dashpots across and along the planes.

    Friction: the trapezoid of the elastic strength and, in addition, the viscous part at the end.  Dashpot:
    viscous stress times change; where no tension lets it pull, the energy that the contact sets free.
    """
    elastic, before = plane.pressure(parameters, end.contact), plane.pressure(parameters, start.contact)
    strength = 0.5 * (start.alpha * before + end.alpha * elastic) + end.alpha * (end.p - elastic)
    slipped = np.linalg.norm(end.slip - start.slip, axis=-1)
    friction = parameters.mu * np.maximum(strength, 0.0) * slipped
    rate = parameters.c / dt if dt > 0.0 else 0.0
    closing = plane.closure(parameters, end.contact)[0] - plane.closure(parameters, start.contact)[0]
    freed = plane.closing(parameters, start.contact) - plane.closing(parameters, end.contact)
    across = rate * closing**2
    across = np.where(closing < 0.0, np.minimum(across, freed), across)
    stretch = (end.contact[..., 1:] - end.slip) - (start.contact[..., 1:] - start.slip)
    along = rate * parameters.Kt / (parameters.kc * parameters.Kn) * (stretch**2).sum(-1)
    return friction, end.alpha * (across + along)
