"""Error against the number of planes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.paper.fracture_energy import fracture_energy
from asperity.parallel import Serial
from asperity.pattern import Pattern, unit_vector
from asperity.slip_curves import SlipCurves, slip_curves

from .common import (
    PRELOAD,
    SIGMA_N,
    Tick,
    cycle,
    material,
    monotonic,
    relative,
    timed,
)


@dataclass(frozen=True, eq=False)
class Candidate:
    """Pattern of a family; sides: order of its symmetry; planes: number of all planes."""

    family: str
    sides: int
    planes: int
    pattern: Pattern

    @property
    def directions(self) -> Floats:
        """Directions from one plane of symmetry to the next, degrees; all others are equivalent to these."""
        return np.linspace(0.0, 180.0 / self.sides, DIRECTIONS)


DIRECTIONS = 9
"""Number of slip directions of a pattern."""

FLAT = 1.0 / 3.0
"""Weight of the flat plane, as in Table 4."""

REFERENCE_SIDES = 64
"""Sides of the reference; its spread over directions is 0.09 % at 30 degrees and mu = 0.5."""

EVEN = (4, 6, 8, 10, 12, 16, 24, 32, 48, 64)
ODD = (3, 5, 7, 9, 11, 13, 17, 25, 33, 49, 63)
RINGS = (3, 4, 5, 6, 8, 12, 16)

STAGGER = (2.5, 5.0)
"""Differences of the inclinations of two rings from that of the reference, degrees; 0 gives RP-2m."""


def regular(sides: int, theta: float) -> Candidate:
    """RP-m with the inclination of the reference."""
    family = "even" if sides % 2 == 0 else "odd"
    return Candidate(family, sides, sides + 1, Pattern.regular(sides, theta, FLAT))


def two_rings(sides: int, theta: float, difference: float) -> Candidate:
    """m planes at theta + difference and m at theta - difference, rotated by 180/m; costs as RP-2m."""
    normals, weights = [(1.0, 0.0, 0.0)], [FLAT]
    for k in range(2 * sides):
        angle = np.pi * k / sides
        slope = np.tan(np.radians(theta + (difference if k % 2 == 0 else -difference)))
        normals.append((1.0, *(-slope * unit_vector(angle))))
        weights.append((1.0 - FLAT) / (2 * sides))
    return Candidate(f"rings ±{difference:g}°", sides, 2 * sides + 1, Pattern.planes(normals, weights))


def candidates(theta: float) -> list[Candidate]:
    """All families."""
    rings = [two_rings(m, theta, difference) for difference in STAGGER for m in RINGS]
    return [*(regular(m, theta) for m in sorted(EVEN + ODD)), *rings]


def residual_spread(sides: int, theta: float, mu: float) -> float:
    """Ratio of the residual strengths up a plane and between two planes, minus 1."""
    facing, between = material(mu).residual_strength(theta, [0.0, 180.0 / sides])
    return float(facing / between - 1.0)


@dataclass(frozen=True)
class PlaneError:
    """Errors of a pattern against RP-64 of the same flat weight in the worst direction, and spreads.

    tau_L, across, s_N: L2 norms over the monotonic path, relative to tau_L and s_N of the reference. work:
    spread (largest over smallest, minus 1) over the directions of the work of that path, which is G_T at
    sigma_N = 0. loop: the same for the work of a closed loop of a cycle. seconds: time for one curve.
    """

    family: str
    sides: int
    planes: int
    theta: float
    mu: float
    sigma_N: float
    seconds: float
    tau_L: float
    across: float
    s_N: float
    work: float
    loop: float


PLANE_INCREMENTS = {"monotonic": 240, "cyclic": 800}
"""Number of increments of 0.0025 mm; their error is about the same for all patterns and directions."""

ENERGY_TOLERANCE = 1.0e-5
"""G_T counts as converged if the last halving of the steps changes it by at most this fraction of Gc."""


def plane_errors(
    chosen: Iterable[Candidate],
    theta: float,
    mu: float,
    tractions: Sequence[float] = SIGMA_N,
    repeats: int = 3,
    tick: Tick = lambda: None,
) -> Iterator[PlaneError]:
    """Errors of candidates at each of the normal tractions."""
    slips = monotonic(PLANE_INCREMENTS["monotonic"])
    loops = cycle(PLANE_INCREMENTS["cyclic"])
    held = np.array(tractions)
    reference = slip_curves(
        Interface(material(mu), Pattern.regular(REFERENCE_SIDES, theta, FLAT)), 0.0, slips, held, PRELOAD
    )
    for candidate in chosen:
        interface = Interface(material(mu), candidate.pattern)
        angles = candidate.directions
        for i, sigma_N in enumerate(held):
            curves, seconds = timed(
                lambda: slip_curves(interface, angles, slips, sigma_N, PRELOAD, executor=Serial()),  # noqa: B023
                repeats,
            )
            tau, s_N = reference.tau_L[i], reference.s_N[i]
            everywhere = np.tile(tau, (len(angles), 1))
            yield PlaneError(
                candidate.family,
                candidate.sides,
                candidate.planes,
                theta,
                mu,
                float(sigma_N),
                seconds / len(angles),
                relative(curves.tau_L - tau, everywhere),
                relative(curves.tau_across, everywhere),
                relative(curves.s_N - s_N, np.tile(s_N, (len(angles), 1))),
                # at sigma_N = 0 the error of the increments exceeds the spread of fine patterns
                _spread(curves.work[:, -1])
                if sigma_N < 0.0
                else fracture_energy(material(mu), candidate.pattern, angles, ENERGY_TOLERANCE).spread,
                _spread(_loops(slip_curves(interface, angles, loops, sigma_N, PRELOAD)))
                if sigma_N < 0.0
                else np.nan,
            )
            tick()


def _spread(values: Floats) -> float:
    return float(values.max() / values.min() - 1.0)


def _loops(curves: SlipCurves) -> Floats:
    """Work of the closed loop of the last two strokes of a cycle."""
    first = curves.slips.size // 5 - 1
    tau, s = curves.tau_L[:, first:], curves.slips[first:]
    return np.sum(0.5 * (tau[:, 1:] + tau[:, :-1]) * np.diff(s), axis=1)


def pareto(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Pareto front: points (cost, error) such that no other point is smaller in both."""
    front: list[tuple[float, float]] = []
    for cost, error in sorted(points):
        if not front or error < front[-1][1]:
            front.append((cost, error))
    return front
