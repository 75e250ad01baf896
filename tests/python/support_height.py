"""Patterns, paths and tolerances of the tests of finite asperity height and wear in the NumPy reference."""

from __future__ import annotations

import numpy as np

from tests.oracle.reference import (
    HEADER,
    PER_PLANE,
    Parameters,
    SlipHistory,
    regular_pattern,
    virgin,
)

TABLE_2 = Parameters(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
THETA = 30.0
RT = regular_pattern(2, THETA)
RP_4 = regular_pattern(4, THETA)
FLAT = regular_pattern(0, 0.0)

EPSILON = np.finfo(float).eps
ROUNDING = 1.0e-12
"""Relative: a few operations in double precision, and the tolerance of the equilibrium solve."""

PRINTED = 5.0e-7
"""Half of the last printed decimal."""

CURVED = ({"height": 0.3}, {"W0": 1.0}, {"height": 0.3, "W0": 1.0})


def along(history: SlipHistory, direction_deg: float) -> np.ndarray:
    """Return the traction along the slip."""
    angle = np.radians(direction_deg)
    return history.traction[..., 1] * np.cos(angle) + history.traction[..., 2] * np.sin(angle)


def cycle(*ends: float, step: float) -> np.ndarray:
    """Return slips from 0 to each of the ends in turn in equal increments, 0 included."""
    legs = [np.zeros(1)]
    for start, end in zip((0.0, *ends[:-1]), ends, strict=True):
        legs.append(np.linspace(start, end, round(abs(end - start) / step) + 1)[1:])
    return np.concatenate(legs)


def rows_at(slips: np.ndarray, ends: tuple[float, ...]) -> list[int]:
    """Return the rows of monotonic slips that are nearest to the ends."""
    return [int(np.argmin(np.abs(slips - end))) for end in ends]


def broken(pattern, parameters: Parameters) -> np.ndarray:
    """Return the state of a point whose planes are all fully damaged."""
    state = virgin(pattern, parameters.wears)
    state[HEADER : HEADER + PER_PLANE * len(pattern[1]) : PER_PLANE] = 1.0
    return state


def worn_share(pattern, state: np.ndarray) -> np.ndarray:
    """Return omega of every plane."""
    return state[..., HEADER + PER_PLANE * len(pattern[1]) :: 2]


def random_walk(seed: int, increments: int, points: int, size: float = 1.5 * TABLE_2.s0) -> np.ndarray:
    """Return random separations (increments, points, 3)."""
    return np.cumsum(np.random.default_rng(seed).normal(0.0, size, (increments, points, 3)), axis=0)
