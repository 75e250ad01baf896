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
    """Traction (t_N, t_T) and the history after the increment."""

    traction: tuple[float, float]
    history: History


def virgin(planes: Planes) -> History:
    """History of virgin planes."""
    return History(((0.0, 0.0),) * len(planes))


def trapezoid(theta_deg: float, flat: float = 1.0 / 3.0) -> Planes:
    """Flat plane of weight `flat` and two planes inclined by theta_deg and -theta_deg; Table 1 by default."""
    inclined = 0.5 * (1.0 - flat)
    planes = [(0.0, flat), (theta_deg, inclined), (-theta_deg, inclined)]
    return [(angle, weight) for angle, weight in planes if weight > 0.0]


def update(
    parameters: Parameters, planes: Planes, s_N: float, s_T: float, history: History | None = None
) -> PlanarResponse:
    """One increment of the 2D law to the total separation (s_N, s_T); history None means virgin planes."""
    history = virgin(planes) if history is None else history
    old_N, old_T = history.separation
    t_N = t_T = 0.0
    damage = stored = rupture = friction = work = 0.0
    after = []
    for (angle, weight), (alpha_old, slip_old) in zip(planes, history.planes, strict=True):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        s_n, s_t = c * s_N + s * s_T, -s * s_N + c * s_T
        was_n, was_t = c * old_N + s * old_T, -s * old_N + c * old_T
        normal, tangential, alpha, slip = _plane(parameters, s_n, s_t, alpha_old, slip_old)
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
    before = history.energies
    energies = (stored, before[1] + rupture, before[2] + friction, before[3] + work)
    now = History(tuple(after), (s_N, s_T), damage, energies)
    return PlanarResponse((t_N, t_T), now)


def _plane(
    parameters: Parameters, s_n: float, s_t: float, alpha_old: float, slip_old: float
) -> tuple[float, float, float, float]:
    """Result of one plane: sigma_n, tau, alpha, s_di."""
    eta, mu, s0, s02 = parameters.eta, parameters.mu, parameters.s0, parameters.s02
    K_n, K_t = parameters.Kn, parameters.Kt
    ratio = math.hypot(max(s_n, 0.0) / s0, s_t / s02)  # 1 + beta, (6)
    wanted = (1.0 - 1.0 / ratio) / eta if ratio > 1.0 else 0.0  # (7)
    alpha = max(alpha_old, min(1.0, wanted))
    sigma_d = parameters.kc * K_n * min(s_n, 0.0)
    sigma_u = K_n * s_n if s_n > 0.0 else sigma_d
    tau_d = K_t * (s_t - slip_old)  # (30)
    limit, slip = -mu * sigma_d, slip_old
    if s_n > 0.0 or abs(tau_d) > limit:  # (36)-(39) in one dimension
        tau_d = math.copysign(limit, tau_d)
        slip = s_t - tau_d / K_t
    return (1.0 - alpha) * sigma_u + alpha * sigma_d, (1.0 - alpha) * K_t * s_t + alpha * tau_d, alpha, slip


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
