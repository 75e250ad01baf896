"""The 2D law of the plane-symmetric RIE in plain scalars, for comparison with the 3D law (Section 4.1).

Serpieri and Alfano (2011) write the law for separations (s_N, s_T) and planes inclined by signed angles.
This module does the same in Python floats: no frames, no vectors and nothing of the 3D code but the material
parameters.  Numbers in round brackets are equations of Albarella et al. (2015).  Angles are in degrees,
tension and opening are positive.  A plane at angle phi has normal (cos phi, sin phi), tangent
(-sin phi, cos phi).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from .reference import Parameters

Planes = Sequence[tuple[float, float]]
"""Signed inclination in degrees and weight of every plane."""

History = list[tuple[float, float]]
"""Damage alpha and signed slip s_di of every plane."""


@dataclass(frozen=True)
class PlanarResponse:
    """Traction (t_N, t_T), the histories after the increment and the tangent ((NN, NT), (TN, TT))."""

    traction: tuple[float, float]
    history: History
    tangent: tuple[tuple[float, float], tuple[float, float]]


def trapezoid(theta_deg: float) -> Planes:
    """The three planes of Table 1: one flat, two inclined by theta_deg either way, equal weights."""
    return [(0.0, 1.0 / 3.0), (theta_deg, 1.0 / 3.0), (-theta_deg, 1.0 / 3.0)]


def update(
    parameters: Parameters, planes: Planes, s_N: float, s_T: float, history: History | None = None
) -> PlanarResponse:
    """One increment of the 2D law to the total separation (s_N, s_T); history None means virgin planes."""
    history = [(0.0, 0.0)] * len(planes) if history is None else history
    t_N = t_T = k_NN = k_NT = k_TN = k_TT = 0.0
    after: History = []
    for (angle, weight), (alpha_old, slip_old) in zip(planes, history, strict=True):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        normal, tangential, alpha, slip, (nn, nt, tn, tt) = _plane(
            parameters, c * s_N + s * s_T, -s * s_N + c * s_T, alpha_old, slip_old
        )
        after.append((alpha, slip))
        t_N += weight * (c * normal - s * tangential)
        t_T += weight * (s * normal + c * tangential)
        k_NN += weight * (c * c * nn - c * s * (nt + tn) + s * s * tt)
        k_NT += weight * (c * s * nn + c * c * nt - s * s * tn - c * s * tt)
        k_TN += weight * (c * s * nn - s * s * nt + c * c * tn - c * s * tt)
        k_TT += weight * (s * s * nn + c * s * (nt + tn) + c * c * tt)
    return PlanarResponse((t_N, t_T), after, ((k_NN, k_NT), (k_TN, k_TT)))


def _plane(
    parameters: Parameters, s_n: float, s_t: float, alpha_old: float, slip_old: float
) -> tuple[float, float, float, float, tuple[float, float, float, float]]:
    """One plane: sigma_n, tau, alpha, s_di and the local tangent (nn, nt, tn, tt)."""
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


def replay(
    parameters: Parameters, planes: Planes, path: Sequence[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Tractions (t_N, t_T) along a path of separations (s_N, s_T) from virgin planes."""
    history: History | None = None
    tractions = []
    for s_N, s_T in path:
        response = update(parameters, planes, s_N, s_T, history)
        history = response.history
        tractions.append(response.traction)
    return tractions


def confined_slip(
    parameters: Parameters,
    planes: Planes,
    slips: Sequence[float],
    sigma_N: float,
    preload_increments: int = 20,
) -> list[tuple[float, float, float, float]]:
    """Rows (s_N, s_T, t_N, t_T) for prescribed slips while sigma_N, applied first at zero slip, is held.

    s_N is the first root from the last one in the sign of (sigma_N - t_N), by a march and bisection; it stays
    where it is in a continuum of dead states.  Raises ValueError where there is no equilibrium.
    """
    history: History = [(0.0, 0.0)] * len(planes)
    s_N, rows = 0.0, []
    programme = [(0.0, sigma_N * part / preload_increments) for part in range(1, preload_increments + 1)]
    programme += [(s_T, sigma_N) for s_T in slips]
    for row, (s_T, held) in enumerate(programme):
        s_N = _hold(parameters, planes, s_N, s_T, held, history)
        response = update(parameters, planes, s_N, s_T, history)
        history = response.history
        if row >= preload_increments:
            rows.append((s_N, s_T, *response.traction))
    return rows


def _hold(
    parameters: Parameters, planes: Planes, s_N: float, s_T: float, sigma_N: float, history: History
) -> float:
    """s_N at which t_N = sigma_N, the first from the s_N given in the sign of (sigma_N - t_N)."""

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
