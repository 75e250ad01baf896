"""IMPL-EX of the NumPy reference (Oliver, Huespe, Cante 2008): one point, one increment.

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
    duration: float = 0.0
    longest: float = 0.0
    e_a: float = 0.0
    e_t: float = 0.0

    @classmethod
    def virgin(cls, n_planes: int) -> Own:
        """Before the first increment."""
        return cls(np.zeros(3), np.zeros(n_planes), np.zeros(3))


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
    """Traction (3,) at s and what is kept; state: of the law at the start, with a cap also of it."""
    normals, weights = pattern
    count, rows = len(weights), state[None]
    ratio = 0.0 if first or own.duration == 0.0 or dt > LARGEST_RATIO * own.duration else dt / own.duration
    aim = s_old + ratio * own.jump
    at_start, end, wanted = s_old, s, aim
    if cap is None:
        ends, at_aim = (
            reference.update(parameters, pattern, x[None], rows, s_old[None], dt) for x in (s, aim)
        )
        implicit, new_state, aim_state = ends.traction[0], ends.state, at_aim.state
    else:
        (implicit,), new_state = strength.update(parameters, cap, pattern, s[None], rows, s_old[None], dt)
        most, aim_state = strength.update(parameters, cap, pattern, aim[None], rows, s_old[None], dt)
        most = cap.largest_pressure(most, aim_state[:, -2])[0]
        least, closed = state[-2], np.array([1.0, 0.0, 0.0])
        s_old, s, aim = s_old + least * closed, s + least * closed, aim + aim_state[0, -2] * closed
        rows, new_state, aim_state = rows[:, :-2], new_state[:, :-2], aim_state[:, :-2]
    old, new, guess = (reference._histories(parameters, x, count)[0][0] for x in (rows, new_state, aim_state))
    guess = np.maximum(guess, np.minimum(1.0, old + ratio * own.growth))
    offset, frame = state[5:8], reference.frames(normals)
    omega, _ = reference._wear_histories(aim_state, count)
    _, contact, facet = plane.kinematics(parameters, frame, (aim + offset)[None], omega)
    gradient = frame if facet is None else facet.gradient[0]
    slip = reference._histories(parameters, rows, count)[1][0]
    begin = reference._start(parameters, pattern, s_old[None], rows)
    bound, pull, rate = plane.pressure(parameters, contact), 0.0 * slip, 0.0
    if parameters.c > 0.0 and dt > 0.0:
        bound, pull, rate = reference._viscous(parameters, begin, contact, dt)
        pull = pull[0]
    bound = parameters.mu * bound[0]

    def trial(x: Floats) -> Floats:
        """Stress along the planes (k, 2) without the bound of friction."""
        return (parameters.Kt + rate) * (x[:, 1:] - slip) - pull

    def traction_at(s: Floats) -> Floats:
        """Traction (3,) at a separation of the law."""
        traction = np.zeros(3)
        for k in range(count):
            bond = frame[k] @ (s + offset)
            pressed = plane.pressure(parameters, bond[None, None])[0, 0]
            opened = parameters.Kn * max(bond[0], 0.0)
            whole = np.array([opened - pressed, *(parameters.Kt * bond[1:])])
            touch = contact[0, k] + gradient[k] @ (s - aim)
            if rate > 0.0:
                push = reference._viscous(parameters, begin, np.broadcast_to(touch, contact.shape), dt)[0][
                    0, k
                ]
            else:
                push = plane.pressure(parameters, touch[None, None])[0, 0]
            at, now = (trial(np.broadcast_to(x, contact[0].shape))[k] for x in (contact[0, k], touch))
            size = float(np.linalg.norm(at))
            share = (
                min(1.0, bound[k] / size) if size > 0.0 else float(contact[0, k, 0] <= 0.0 < parameters.mu)
            )
            traction += weights[k] * (1.0 - guess[k]) * (frame[k].T @ whole)
            traction += weights[k] * guess[k] * (gradient[k].T @ np.array([-push, *(share * now)]))
        return traction

    traction = traction_at(s)
    if cap is not None and -traction[0] > most:
        low, high = 0.0, parameters.s0
        while -traction_at(s + high * closed)[0] > most:
            high *= 2.0
        while low < (middle := 0.5 * (low + high)) < high:
            low, high = (middle, high) if -traction_at(s + middle * closed)[0] > most else (low, middle)
        traction = traction_at(s + high * closed)
    longest = dt if first else max(own.longest, dt)
    e_t = np.linalg.norm(traction - implicit) / max(parameters.sigma0, float(bound.max()))
    return traction, Own(
        end - at_start, new - old, wanted, dt, longest, float(np.abs(new - guess).max()), float(e_t)
    )
