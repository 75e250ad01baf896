"""Comparison of the library with the independent NumPy reference.

The tolerances are multiples of the rounding error 2.2e-16 times the size of the summed terms.  This size is
K |s| for tractions, |s| for slips and K |s|^2 for energies, with the largest |s| of the history.
"""

from __future__ import annotations

import itertools
import warnings
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, ModelWarning, Pattern, contract
from asperity.case_files import drive, read_case, slip_tests
from asperity.contract import N_POINT_STATEV
from asperity.history import ENERGIES
from asperity.installed import named_case

from harness.studies.newton import work_along
from tests.oracle import reference

TRACTION = 1e-12
"""Of K |s|: 4500 rounding errors, for sums over up to 65 planes after up to 20 increments."""

STATE = 1e-13
"""Of |s| for slips, K |s|^2 for energies, |s|/(s0 eta) for damage: 450 rounding errors."""

TANGENT = 1e-13
"""Of K (1 + (|s|/s0)^2/eta) |s|/|s_T - s_di|: growing damage, and the direction of a small trial stress."""

ALONG, FOLLOWED = 1e-12, 1e-10
"""Of slip tests: along given separations, and where each implementation solves for s_N by itself."""

SEED = 20150131
TABLE_2 = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
BRANCHES = list(itertools.product((reference.OPEN, reference.STICK, reference.SLIP), (False, True)))


def random_material(rng: np.random.Generator) -> Material:
    """Return admissible parameters that span orders of magnitude.

    The parameters of mode II and the closing stiffness equal those of mode I or differ from them.
    """
    sigma0, Gc = 10 ** rng.uniform(-1, 2), 10 ** rng.uniform(-2, 1)
    mixed = rng.random() < 0.3
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        return Material(
            sigma0=sigma0,
            Gc=Gc,
            eta=rng.choice([rng.uniform(0.1, 0.9), 0.9, 0.99]),
            mu=rng.choice([0.0, rng.uniform(0.0, 1.5)], p=[0.1, 0.9]),
            sigma02=sigma0 * rng.uniform(0.5, 2.0) if mixed else 0.0,
            Gc2=Gc * rng.uniform(0.5, 2.0) if mixed else 0.0,
            kc=10 ** rng.uniform(-1, 2) if rng.random() < 0.3 else 1.0,
        )


def random_pattern(rng: np.random.Generator) -> tuple[Pattern, reference.Pattern]:
    """Return one pattern, regular or a list of planes, for the library and for the reference."""
    if rng.random() < 0.3:
        k = int(rng.integers(1, 9))
        tilt, azimuth = np.radians(rng.uniform(0, 80, k)), rng.uniform(0, 2 * np.pi, k)
        tilt[rng.random(k) < 0.2] = 0.0
        normals = [np.cos(tilt), np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth)]
        normals = np.stack(normals, axis=1) * 10 ** rng.uniform(-2, 2, (k, 1))
        weights = rng.dirichlet(np.ones(k))
        return Pattern.planes(normals, weights), reference.listed_pattern(normals, weights)
    sides = int(rng.choice([0, 2, 3, 4, 5, 6, 7, 8, 12, 32, 64]))
    theta = rng.choice([0.0, 30.0, rng.uniform(0.0, 80.0)], p=[0.1, 0.2, 0.7])
    flat = rng.choice([1 / 3, 0.0, 1.0, rng.uniform(0, 1)], p=[0.5, 0.1, 0.05, 0.35])
    turn = rng.choice([0.0, rng.uniform(-360, 360)])
    return Pattern.regular(sides, theta, flat, turn), reference.regular_pattern(sides, theta, flat, turn)


def random_history(rng: np.random.Generator, length: float, points: int, increments: int) -> np.ndarray:
    """Return separations (increments, points, 3): random walks with steps of about 0.03 to 5 `length`.

    Some increments leave s_N unchanged.  No separation has s_N = 0, where the tangent is not unique.
    """
    sizes = 10 ** rng.uniform(-1.5, 0.7, (increments, points, 1))
    steps = rng.standard_normal((increments, points, 3)) * sizes
    steps[..., 0] *= rng.choice([0.2, 1.0], (increments, points))
    steps[1:, :, 0] *= rng.random((increments - 1, points)) > 0.1
    return length * np.cumsum(steps, axis=0)


def assert_within(name: str, actual: np.ndarray, expected: np.ndarray, tolerance: np.ndarray | float) -> None:
    """Assert that every difference is within the tolerance."""
    excess = np.abs(actual - expected) - tolerance
    worst = np.unravel_index(np.argmax(excess), excess.shape)
    assert np.all(excess <= 0.0), f"{name}{list(worst)}: {actual[worst]!r} instead of {expected[worst]!r}"


@pytest.mark.slow
def test_random_histories() -> None:
    """Tractions, states and tangents agree for random histories, patterns and parameters.

    Every branch of the law occurs more than 500 times.
    """
    rng = np.random.default_rng(SEED)
    counts = dict.fromkeys(BRANCHES, 0)
    for _ in range(200):
        m, (pattern, planes) = random_material(rng), random_pattern(rng)
        p, interface = reference.Parameters(**m.values()), Interface(m, pattern)
        K, shortest = max(p.Kn, p.Kt, p.kc * p.Kn), min(p.s0, p.s02)
        S = random_history(rng, shortest, points=20, increments=6)
        s_old, state, largest = np.zeros((20, 3)), np.zeros((20, interface.nstatv)), np.zeros(20)
        for s in S:
            ours = interface.update(s, state, s_old)
            theirs = reference.update(p, planes, s, state, s_old)
            largest = np.maximum(largest, np.linalg.norm(s, axis=1))
            ratio, scale = (largest / shortest)[:, None], largest[:, None]
            assert_within("traction", ours.traction, theirs.traction, TRACTION * K * scale)
            tolerance = np.empty_like(state)
            tolerance[:, 1:5] = STATE * K * scale**2
            tolerance[:, 5:9] = 0.0
            tolerance[:, [0]] = tolerance[:, N_POINT_STATEV::3] = STATE * ratio / p.eta
            tolerance[:, N_POINT_STATEV + 1 :: 3] = tolerance[:, N_POINT_STATEV + 2 :: 3] = STATE * scale
            assert_within("state", ours.state, theirs.state, tolerance)
            trial = trial_distance(planes, s, state)
            margin = np.where(theirs.branch == reference.SLIP, trial, largest[:, None])
            closest = (largest / margin.min(axis=1))[:, None, None]
            growth = 1.0 + ratio[..., None] ** 2 / p.eta
            assert_within("tangent", ours.tangent, theirs.tangent, TANGENT * K * growth * closest)
            for branch, damaging in counts:
                found = (theirs.branch == branch) & (theirs.damaging == damaging)
                counts[branch, damaging] += int(found.sum())
            state, s_old = ours.state, s
    assert min(counts.values()) > 500, counts


def trial_distance(planes: reference.Pattern, s: np.ndarray, state: np.ndarray) -> np.ndarray:
    """Return |s_T - s_di| of every plane at the start of the return mapping, (n, k)."""
    local = np.einsum("kab,nb->nka", reference.frames(planes[0]), s)
    slip = state[:, N_POINT_STATEV:].reshape(len(s), -1, 3)[..., 1:]
    return np.linalg.norm(local[..., 1:] - slip, axis=-1)


LOST = """&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /
&pattern sides = 0 /
&step t_N = 2.0 /
&step slip = 0.1, increments = 100 /
&expect end = 'lost' /
"""
"""A slip under tension, whose equilibrium ends."""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["figure02", "figure05b", "lost"])
def test_slip_tests_of_the_driver(name: str, tmp_path: Path) -> None:
    """Along the separations of the driver the reference has its rows; on its own it finds the same path.

    Tractions are relative to K |s|, energies to K |s| times the length of the path.
    """
    case = tmp_path / "lost.nml" if name == "lost" else named_case(name)
    if name == "lost":
        case.write_text(LOST, encoding="utf-8")
    [test], [rows] = slip_tests(read_case(case)), drive(case).values()
    p, pattern = reference.Parameters(**test.material.values()), test.pattern
    planes = reference.regular_pattern(pattern.m, pattern.theta, pattern.flat, pattern.turn)
    # The last row of a lost equilibrium lies within an increment.
    n = len(rows) - rows.lost
    s, energies = rows.separation[:n], np.column_stack([getattr(rows, one)[:n] for one in ENERGIES])
    largest = np.maximum.accumulate(np.linalg.norm(s, axis=1))[:, None]
    length = np.cumsum(np.linalg.norm(np.diff(s, axis=0, prepend=0.0), axis=1))[:, None]
    stress = max(p.Kn, p.Kt) * max(1.0, p.kc) * largest
    assert n > 20

    def assert_rows(
        found: np.ndarray, state: np.ndarray, work: np.ndarray, part: slice, tolerance: float
    ) -> None:
        assert_within("traction", rows.traction[:n][part], found, tolerance * stress[part])
        assert_within("damage", rows.damage[:n][part], state[:, 0], tolerance)
        theirs = np.column_stack([state[:, [contract.statev_index(one) for one in ENERGIES[:-1]]], work])
        assert_within("energy", energies[part], theirs, tolerance * (stress * length)[part])

    law = reference.replay(p, planes, s)
    assert_rows(law.traction, law.state, work_along(s, law.traction), slice(None), ALONG)
    if test.slips.size:
        own = reference.confined_slip(p, planes, test.direction, test.slips, test.sigma_N, test.preload)
        part, whole = slice(test.preload, n), slice(n - test.preload)
        assert np.isfinite(own.damage).sum() == n - test.preload
        assert_rows(own.traction[whole], own.state[whole], own.work[whole], part, FOLLOWED)
        # t_N hardly depends on s_N near a loss
        assert_within("s_N", s[part, :1], own.separation[whole, :1], 10.0 * FOLLOWED * largest[part])
