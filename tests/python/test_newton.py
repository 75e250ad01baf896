"""Newton's method without safeguards: cost and end of each tangent, and agreement with the solver."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from asperity import Interface, Material, Pattern

from harness.studies.newton import ENDS, NewtonStudy, newton_path, newton_study

TABLE_2 = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
RP_4 = Interface(TABLE_2, Pattern.regular(4, 30.0))
K = 150.0
"""Stiffness of the bond (12), MPa/mm: sigma0^2/(2 Gc (1 - eta))."""

STEPS = 4
"""Increments that are coarse enough to need at least four iterations each."""


def pulled_by_springs(tangent: str, most: int = 200, stiffness: float = K) -> NewtonStudy:
    """Pressure, then slip by springs at 20 degrees: every component is an unknown, as in an FE code."""
    spring = np.array([0.0, stiffness, stiffness])
    angle = np.radians(20.0)
    slips = np.linspace(0.0, 0.4, STEPS + 1)
    targets = np.outer(slips, stiffness * np.array([0.0, np.cos(angle), np.sin(angle)]))
    targets[:, 0] = -1.0
    return newton_path(RP_4, targets, (True, True, True), tangent, most=most, spring=spring)


def orders(study: NewtonStudy) -> list[float]:
    """Ratios of each residual below a tenth to the square of the previous one."""
    found = []
    for row in study.residuals:
        found += [after / before**2 for before, after in pairwise(row) if before < 0.1 and after > 1e-13]
    return found


def test_consistent_tangent_converges_quadratically() -> None:
    """Convergence is quadratic with a bounded factor of the order of the curvature of the law."""
    study = pulled_by_springs("consistent")
    assert study.converged and len(orders(study)) > 5
    assert max(orders(study)) < 100.0
    assert max(study.iterations) <= 6


@pytest.mark.parametrize("tangent", ["symmetrised", "secant", "lagged"])
def test_other_tangents_need_more(tangent: str) -> None:
    """Other tangents converge to the same point at first order: the factor has no bound."""
    study, consistent = pulled_by_springs(tangent), pulled_by_springs("consistent")
    assert study.converged
    assert np.abs(study.traction - consistent.traction).max() < 1e-8 * TABLE_2.sigma0
    assert sum(study.iterations) > 2 * sum(consistent.iterations)
    assert max(orders(study)) > 1e6


def test_tangents_that_fail() -> None:
    """The elastic tangent exceeds 200 iterations; a fully damaged joint that is open has a singular one."""
    study = pulled_by_springs("elastic", stiffness=0.5 * K)
    assert study.end == ENDS[1] and study.iterations[-1] == 200
    path = [[0.0, 0.1, 0.0], [0.0, 0.4, 0.0], [0.0, 0.3, 0.0], [-1.0, 0.3, 0.0]]
    opened = newton_path(RP_4, path)
    assert opened.end == ENDS[2] and len(opened.iterations) == 4


def test_snap_stops_it() -> None:
    """RP-32 at sigma_N = 0: large steps pass the fold near 0.1737 mm, small ones end there."""
    dense = Interface(TABLE_2, Pattern.regular(32, 30.0))
    ends = {}
    for steps in (100, 1500):
        study = newton_study(dense, 0.0, np.linspace(0.0, 0.2, steps + 1)[1:], 0.0, preload=1)
        ends[steps] = study.end
        if not study.converged:
            assert study.separation[-1, 1] == pytest.approx(0.1737, abs=1e-4)
    assert ends == {100: ENDS[0], 1500: ENDS[1]}
