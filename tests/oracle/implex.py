"""IMPL-EX of the NumPy reference (Oliver, Huespe, Cante 2008): points in rows, one increment.

The state is that of the law.  Damage, ratio of friction and trial stress, facets and, with a compressive
strength, the largest pressure are those of an extrapolated separation; the normal part of the contact stays
one-sided.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import cap as strength
from . import plane, reference

Floats = NDArray[np.floating]

LARGEST_RATIO = 10.0
"""Ratio of durations beyond which nothing is extrapolated."""


@dataclass(frozen=True)
class Own:
    """What is kept of the last increment, its errors, and the separation that was extrapolated for it."""

    jump: Floats
    growth: Floats
    aim: Floats
    e_a: Floats
    e_t: Floats
    duration: float = 0.0
    longest: float = 0.0

    @classmethod
    def virgin(cls, n_planes: int, n: int = 1) -> Own:
        """Before the first increment of n points."""
        nothing = np.zeros((n, 3))
        return cls(nothing, np.zeros((n, n_planes)), nothing, nothing[:, 0], nothing[:, 0])


def step(
    parameters: reference.Parameters,
    pattern: reference.Pattern,
    s_old: Floats,
    s: Floats,
    state: Floats,
    own: Own,
    first: bool,
    dt: float,
    cap: strength.Cap | None = None,
) -> tuple[Floats, Own]:
    """Tractions (n, 3) at s (n, 3) and what is kept; state (n, :): of the law, with a cap also of it."""
    normals, weights = pattern
    n, count, rows = len(s), len(weights), state
    ratio = 0.0 if first or own.duration == 0.0 or dt > LARGEST_RATIO * own.duration else dt / own.duration
    aim = s_old + ratio * own.jump
    at_start, end, wanted = s_old, s, aim
    # the law at s and at the aim, both at once
    both = np.concatenate([s, aim]), np.tile(rows, (2, 1)), np.tile(s_old, (2, 1)), dt
    if cap is None:
        ends = reference.update(parameters, pattern, *both, tangent=False)
        implicit, new_state, aim_state = ends.traction[:n], ends.state[:n], ends.state[n:]
    else:
        tractions, states = strength.update(parameters, cap, pattern, *both)
        implicit, new_state, aim_state = tractions[:n], states[:n], states[n:]
        most = cap.largest_pressure(tractions[n:], aim_state[:, -2])
        least, closed = state[:, -2:-1], np.array([1.0, 0.0, 0.0])
        s_old, s, aim = s_old + least * closed, s + least * closed, aim + aim_state[:, -2:-1] * closed
        rows, new_state, aim_state = rows[:, :-2], new_state[:, :-2], aim_state[:, :-2]
    old, new, guess = (reference._histories(parameters, x, count)[0] for x in (rows, new_state, aim_state))
    guess = np.maximum(guess, np.minimum(1.0, old + ratio * own.growth))
    offset, frame = rows[:, 5:8], reference.frames(normals)
    omega, _ = reference._wear_histories(aim_state, count)
    _, contact, facet = plane.kinematics(parameters, frame, aim + offset, omega)
    gradient = np.broadcast_to(frame, (n, count, 3, 3)) if facet is None else facet.gradient
    slip = reference._histories(parameters, rows, count)[1]
    begin = reference._start(parameters, pattern, s_old, rows)
    bound, pull, rate = plane.pressure(parameters, contact), 0.0, 0.0
    if parameters.c > 0.0 and dt > 0.0:
        bound, pull, rate = reference._viscous(parameters, begin, contact, dt)
    bound = parameters.mu * bound

    def trial(x: Floats) -> Floats:
        """Stress along the planes (n, k, 2) without the bound of friction."""
        return (parameters.Kt + rate) * (x[..., 1:] - slip) - pull

    size = np.linalg.norm(trial(contact), axis=-1)
    touches = (contact[..., 0] <= 0.0) & (parameters.mu > 0.0)
    share = np.where(size > 0.0, np.minimum(1.0, bound / np.where(size > 0.0, size, 1.0)), touches)

    def traction_at(s: Floats) -> Floats:
        """Traction (n, 3) at a separation of the law."""
        bond = np.einsum("kab,nb->nka", frame, s + offset)
        across = parameters.Kn * plane.positive(bond[..., 0]) - plane.pressure(parameters, bond)
        whole = np.concatenate([across[..., None], parameters.Kt * bond[..., 1:]], axis=-1)
        touch = contact + np.einsum("nkab,nb->nka", gradient, s - aim)
        viscous = rate > 0.0
        push = (
            reference._viscous(parameters, begin, touch, dt)[0]
            if viscous
            else plane.pressure(parameters, touch)
        )
        broken = np.concatenate([-push[..., None], share[..., None] * trial(touch)], axis=-1)
        of_bond = np.einsum("k,nk,kab,nka->nb", weights, 1.0 - guess, frame, whole)
        return of_bond + np.einsum("k,nk,nkab,nka->nb", weights, guess, gradient, broken)

    traction = traction_at(s)
    if cap is not None:

        def above(kappa: Floats) -> NDArray[np.bool_]:
            """Whether the pressure is above the largest one after a further closure (n,)."""
            return -traction_at(s + kappa[:, None] * closed)[:, 0] > most

        low, high = np.zeros(n), np.where(above(np.zeros(n)), parameters.s0, 0.0)
        while (more := above(high)).any():
            high = np.where(more, 2.0 * high, high)
        for _ in range(strength.BITS):
            middle = 0.5 * (low + high)
            more = above(middle)
            low, high = np.where(more, middle, low), np.where(more, high, middle)
        traction = traction_at(s + high[:, None] * closed)
    longest = dt if first else max(own.longest, dt)
    e_t = np.linalg.norm(traction - implicit, axis=1) / np.maximum(parameters.sigma0, bound.max(axis=1))
    e_a = np.abs(new - guess).max(axis=1)
    return traction, Own(end - at_start, new - old, wanted, e_a, e_t, dt, longest)
