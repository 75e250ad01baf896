"""The 2D law of the plane-symmetric RIE in plain scalars, for comparison with the 3D law (Section 4.1).

Serpieri and Alfano (2011) write the law for separations (s_N, s_T) and planes inclined by signed angles.
The tests compare the 3D codes with this module.  It is independent of library and 3D reference: it computes
with Python floats, without frames and vectors, and uses only the material parameters of the 3D reference.
Numbers in round brackets are equations of Albarella et al. (2015).  Angles are in degrees, tension and
opening are positive.  A plane at angle phi has normal (cos phi, sin phi), tangent
(-sin phi, cos phi).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from .reference import Parameters

Planes = Sequence[tuple[float, float]]
"""Signed inclination in degrees and weight of every plane."""

HALF_TURN = 180.0
"""Rotation about N, degrees, that maps the two inclined planes on each other."""


@dataclass(frozen=True)
class History:
    """History of an interface: (alpha, signed slip s_di) of every plane, separation (s_N, s_T), damage, and
    energies per unit area (stored, rupture, friction, work)."""

    planes: tuple[tuple[float, float], ...]
    separation: tuple[float, float] = (0.0, 0.0)
    damage: float = 0.0
    energies: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class PlanarResponse:
    """Traction (t_N, t_T), the history after the increment and the tangent ((NN, NT), (TN, TT))."""

    traction: tuple[float, float]
    history: History
    tangent: tuple[tuple[float, float], tuple[float, float]]


def virgin(planes: Planes) -> History:
    """History of virgin planes."""
    return History(((0.0, 0.0),) * len(planes))


def trapezoid(theta_deg: float, flat: float = 1.0 / 3.0, turn_deg: float = 0.0) -> Planes:
    """Flat plane of weight `flat` and two planes inclined by theta_deg and -theta_deg; Table 1 by default.

    Raises ValueError for a weight outside 0 to 1 and for a rotation about N that leaves the 2D plane.
    """
    if not 0.0 <= flat <= 1.0:
        raise ValueError(f"flat = {flat!r}: expected 0 <= flat <= 1")
    if turn_deg % HALF_TURN != 0.0:
        raise ValueError(
            f"turn_deg = {turn_deg!r}: expected a multiple of {HALF_TURN:g} degrees, "
            "the 2D law has no slope out of its plane"
        )
    inclined = 0.5 * (1.0 - flat)
    planes = [(0.0, flat), (theta_deg, inclined), (-theta_deg, inclined)]
    return [(angle, weight) for angle, weight in planes if weight > 0.0]


def update(
    parameters: Parameters, planes: Planes, s_N: float, s_T: float, history: History | None = None
) -> PlanarResponse:
    """One increment of the 2D law to the total separation (s_N, s_T); history None means virgin planes."""
    history = virgin(planes) if history is None else history
    old_N, old_T = history.separation
    t_N = t_T = k_NN = k_NT = k_TN = k_TT = 0.0
    damage = stored = rupture = friction = work = 0.0
    after = []
    for (angle, weight), (alpha_old, slip_old) in zip(planes, history.planes, strict=True):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        s_n, s_t = c * s_N + s * s_T, -s * s_N + c * s_T
        was_n, was_t = c * old_N + s * old_T, -s * old_N + c * old_T
        normal, tangential, alpha, slip, (nn, nt, tn, tt) = _plane(parameters, s_n, s_t, alpha_old, slip_old)
        after.append((alpha, slip))
        damage += weight * alpha
        stored += weight * _stored(parameters, s_n, s_t, alpha, slip)
        released = _release_rate(parameters, was_n, was_t, slip_old)
        released += _release_rate(parameters, s_n, s_t, slip)
        rupture += weight * 0.5 * released * (alpha - alpha_old)
        pressures = alpha_old * max(-was_n, 0.0) + alpha * max(-s_n, 0.0)
        strengths = parameters.mu * parameters.kc * parameters.Kn * pressures
        friction += weight * 0.5 * strengths * abs(slip - slip_old)
        # the traction at the start, from the planes as they were then
        was_normal, was_tangential = _start(parameters, was_n, was_t, alpha_old, slip_old)
        work += weight * 0.5 * (normal + was_normal) * (s_n - was_n)
        work += weight * 0.5 * (tangential + was_tangential) * (s_t - was_t)
        t_N += weight * (c * normal - s * tangential)
        t_T += weight * (s * normal + c * tangential)
        k_NN += weight * (c * c * nn - c * s * (nt + tn) + s * s * tt)
        k_NT += weight * (c * s * nn + c * c * nt - s * s * tn - c * s * tt)
        k_TN += weight * (c * s * nn - s * s * nt + c * c * tn - c * s * tt)
        k_TT += weight * (s * s * nn + c * s * (nt + tn) + c * c * tt)
    before = history.energies
    energies = (stored, before[1] + rupture, before[2] + friction, before[3] + work)
    now = History(tuple(after), (s_N, s_T), damage, energies)
    return PlanarResponse((t_N, t_T), now, ((k_NN, k_NT), (k_TN, k_TT)))


def _plane(
    parameters: Parameters, s_n: float, s_t: float, alpha_old: float, slip_old: float
) -> tuple[float, float, float, float, tuple[float, float, float, float]]:
    """Result of one plane: sigma_n, tau, alpha, s_di and the local tangent (nn, nt, tn, tt)."""
    eta, mu, s0, s02 = parameters.eta, parameters.mu, parameters.s0, parameters.s02
    K_n, K_t = parameters.Kn, parameters.Kt
    closing = parameters.kc * K_n

    ratio = math.hypot(max(s_n, 0.0) / s0, s_t / s02)  # 1 + beta, (6)
    wanted = (1.0 - 1.0 / ratio) / eta if ratio > 1.0 else 0.0  # (7)
    alpha = max(alpha_old, min(1.0, wanted))
    growing = alpha_old < wanted < 1.0

    if s_n > 0.0:
        stiff_u, sigma_u, sigma_d = K_n, K_n * s_n, 0.0
        stiff_d = 0.0
    else:
        stiff_u, sigma_u, sigma_d = closing, closing * s_n, closing * s_n
        stiff_d = closing
    tau_u = K_t * s_t

    tau_d = K_t * (s_t - slip_old)  # (30)
    limit = -mu * sigma_d
    slip, d_tn, d_tt = slip_old, 0.0, K_t
    if s_n > 0.0 or abs(tau_d) > limit:  # (36)-(39) in one dimension
        sense = math.copysign(1.0, tau_d)
        tau_d = sense * limit
        slip = s_t - tau_d / K_t
        d_tn, d_tt = (-sense * mu * closing if s_n < 0.0 else 0.0), 0.0

    nn = (1.0 - alpha) * stiff_u + alpha * stiff_d
    tn = alpha * d_tn
    tt = (1.0 - alpha) * K_t + alpha * d_tt
    nt = 0.0
    if growing:
        slope = 1.0 / (eta * ratio**3)
        by_n, by_t = slope * max(s_n, 0.0) / s0**2, slope * s_t / s02**2
        nn += (sigma_d - sigma_u) * by_n
        nt += (sigma_d - sigma_u) * by_t
        tn += (tau_d - tau_u) * by_n
        tt += (tau_d - tau_u) * by_t
    sigma_n = (1.0 - alpha) * sigma_u + alpha * sigma_d  # (22)
    tau = (1.0 - alpha) * tau_u + alpha * tau_d
    return sigma_n, tau, alpha, slip, (nn, nt, tn, tt)


def _start(parameters: Parameters, s_n: float, s_t: float, alpha: float, slip: float) -> tuple[float, float]:
    """Traction (sigma_n, tau) of a plane whose damage and slip are known, (22)."""
    closing = parameters.kc * parameters.Kn * min(s_n, 0.0)
    normal = (1.0 - alpha) * parameters.Kn * max(s_n, 0.0) + closing
    return normal, parameters.Kt * ((1.0 - alpha) * s_t + alpha * (s_t - slip))


def _stored(parameters: Parameters, s_n: float, s_t: float, alpha: float, slip: float) -> float:
    """Stored energy of a plane, per unit area of it."""
    opening, closing = max(s_n, 0.0), min(s_n, 0.0)
    undamaged = parameters.Kn * opening**2 + parameters.Kt * s_t**2
    both = parameters.kc * parameters.Kn * closing**2
    return 0.5 * ((1.0 - alpha) * undamaged + both + alpha * parameters.Kt * (s_t - slip) ** 2)


def _release_rate(parameters: Parameters, s_n: float, s_t: float, slip: float) -> float:
    """Energy Y that a plane releases per unit growth of its damage."""
    return 0.5 * (parameters.Kn * max(s_n, 0.0) ** 2 + parameters.Kt * (s_t**2 - (s_t - slip) ** 2))


def replay(
    parameters: Parameters, planes: Planes, path: Sequence[tuple[float, float]]
) -> list[PlanarResponse]:
    """Responses along a path of separations (s_N, s_T) from virgin planes."""
    history = virgin(planes)
    responses = []
    for s_N, s_T in path:
        responses.append(update(parameters, planes, s_N, s_T, history))
        history = responses[-1].history
    return responses


def confined_slip(
    parameters: Parameters,
    planes: Planes,
    slips: Sequence[float],
    sigma_N: float,
    preload_increments: int = 20,
) -> list[PlanarResponse]:
    """Responses for prescribed slips under a constant sigma_N, which is applied first at zero slip.

    s_N is the first root from the last one in the sign of (sigma_N - t_N), by steps and bisection; it does
    not change if fully damaged and open states are all equilibria.  Raises ValueError where there is no
    equilibrium.
    """
    history = virgin(planes)
    s_N, rows = 0.0, []
    programme = [(0.0, sigma_N * part / preload_increments) for part in range(1, preload_increments + 1)]
    programme += [(s_T, sigma_N) for s_T in slips]
    for row, (s_T, held) in enumerate(programme):
        s_N = _hold(parameters, planes, s_N, s_T, held, history)
        response = update(parameters, planes, s_N, s_T, history)
        history = response.history
        if row >= preload_increments:
            rows.append(response)
    return rows


def _hold(
    parameters: Parameters, planes: Planes, s_N: float, s_T: float, sigma_N: float, history: History
) -> float:
    """First s_N with t_N = sigma_N from the given s_N on, in the direction of (sigma_N - t_N)."""

    def residual(x: float) -> float:
        return sigma_N - update(parameters, planes, x, s_T, history).traction[0]

    last = residual(s_N)
    if last == 0.0:
        return s_N
    step = math.copysign(parameters.s0 / 100.0, last)
    lower, reach = s_N, 10.0 * (parameters.sf + abs(s_T) + abs(s_N))
    while residual(lower + step) * last > 0.0:
        lower += step
        step *= 1.1
        if step > 0.0 and lower > reach:
            raise ValueError(f"no equilibrium at s_T = {s_T!r}, sigma_N = {sigma_N!r}")
    upper = lower + step
    middle = 0.5 * (lower + upper)
    while middle not in (lower, upper):
        if residual(middle) * last > 0.0:
            lower = middle
        else:
            upper = middle
        middle = 0.5 * (lower + upper)
    return upper
