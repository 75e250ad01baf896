"""Finite asperity height and wear: the library against the independent NumPy reference on random histories.

Tolerances are those of test_against_reference, times the number of operations that a facet adds.
"""

from __future__ import annotations

import itertools
import warnings
from dataclasses import replace

import numpy as np
import pytest
from asperity import Interface, Material, ModelWarning, Pattern
from asperity.contract import N_POINT_STATEV
from asperity.oracle import reference
from asperity.oracle.compare import parameters_of

SEED = 20151987

ROUNDING = 1e-12
"""Relative to K |s| for tractions, |s| for slips and K |s|^2 for energies.

The tangent is compared relative to K times its growth with |s|/s_0, |s|/H and |s|/|s_T - s_di|.
"""

POINTS, INCREMENTS = 10, 12


def random_interface(
    rng: np.random.Generator, **constants: float
) -> tuple[Material, Pattern, reference.Pattern]:
    """Return an interface whose sizes span orders of magnitude; the height is in s_f, W0 in Gc."""
    sigma0, Gc = 10 ** rng.uniform(-1, 2), 10 ** rng.uniform(-2, 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        material = Material(
            sigma0=sigma0,
            Gc=Gc,
            eta=rng.choice([rng.uniform(0.1, 0.9), 0.9, 0.99]),
            mu=rng.choice([0.0, rng.uniform(0.0, 1.5)], p=[0.1, 0.9]),
            kc=10 ** rng.uniform(-1, 2) if rng.random() < 0.5 else 1.0,
        )
        sizes = {"height": material.s_f, "W0": material.Gc}
        material = replace(material, **{name: value * sizes[name] for name, value in constants.items()})
    sides = int(rng.choice([0, 2, 3, 4, 5, 6, 8, 12, 32]))
    theta, flat = rng.uniform(0.0, 80.0), rng.choice([1 / 3, 0.0, rng.uniform(0, 1)])
    turn = rng.choice([0.0, rng.uniform(-360, 360)])
    planes = sides, theta, flat, turn
    return material, Pattern.regular(*planes), reference.regular_pattern(*planes)


def random_history(rng: np.random.Generator, length: float) -> np.ndarray:
    """Return separations (increments, points, 3): random walks with steps of about 0.03 to 5 `length`."""
    size = 10 ** rng.uniform(-1.5, 0.7, (INCREMENTS, POINTS, 1))
    steps = rng.standard_normal((INCREMENTS, POINTS, 3)) * size
    steps[..., 0] *= rng.choice([0.2, 1.0], (INCREMENTS, POINTS))
    return length * np.cumsum(steps, axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("constants", [("height",), ("W0",), ("height", "W0")], ids="-".join)
def test_random_histories(constants: tuple[str, ...]) -> None:
    """Tractions, states and tangents agree on 24,000 updates; every branch occurs 500 times."""
    rng = np.random.default_rng([SEED, len(constants), len(constants[0])])
    counts = dict.fromkeys(
        itertools.product((reference.OPEN, reference.STICK, reference.SLIP), (False, True)), 0
    )
    for _ in range(200):
        drawn = {name: 10 ** rng.uniform(-1.5, 1.5) for name in constants}
        material, pattern, planes = random_interface(rng, **drawn)
        compare(material, pattern, planes, random_history(rng, material.s_0), counts)
    assert min(counts.values()) > 500, counts


def compare(
    material: Material, pattern: Pattern, planes: reference.Pattern, S: np.ndarray, counts: dict
) -> None:
    """Assert that library and reference agree along a history; count the branches."""
    interface, p = Interface(material, pattern), parameters_of(material)
    K = p.Kn * max(1.0, p.kc)
    s_old, state, largest = np.zeros((POINTS, 3)), np.zeros((POINTS, interface.nstatv)), np.zeros(POINTS)
    for s in S:
        ours = interface.update(s, state, s_old)
        theirs = reference.update(p, planes, s, state, s_old)
        largest = np.maximum(largest, np.linalg.norm(s, axis=1))
        size = largest[:, None]
        traction = np.abs(ours.traction - theirs.traction)
        assert np.all(traction <= ROUNDING * K * size), (traction / (K * size)).max()
        scale = np.ones_like(state) * size
        facets = N_POINT_STATEV + 3 * len(planes[1])
        scale[:, [0]] = scale[:, N_POINT_STATEV:facets:3] = scale[:, facets::2] = 1.0 + size / p.s0
        scale[:, 1:4] = scale[:, facets + 1 :: 2] = K * size**2
        difference = np.abs(ours.state - theirs.state) / scale
        assert np.all(difference <= ROUNDING), difference.max(axis=0)
        sliding = theirs.branch == reference.SLIP
        margin = np.where(sliding, trial_distance(p, planes, s, state, ours.state), size).min(axis=1)
        growth = 1.0 + (largest / p.s0) ** 2 / p.eta + (largest / p.height if p.height else 0.0)
        tangent = np.abs(ours.tangent - theirs.tangent).max(axis=(1, 2)) / (K * growth * largest / margin)
        assert np.all(tangent <= ROUNDING), tangent.max()
        for branch, damaging in counts:
            counts[branch, damaging] += int(((theirs.branch == branch) & (theirs.damaging == damaging)).sum())
        state, s_old = ours.state, s


def trial_distance(
    p: reference.Parameters, planes: reference.Pattern, s: np.ndarray, state: np.ndarray, new: np.ndarray
) -> np.ndarray:
    """Return |s_T - s_di| on every facet at the start of the return mapping, (n, k).

    new: state at the end, which has the worn shares.
    """
    count = len(planes[1])
    worn = new[:, N_POINT_STATEV + 3 * count :: 2] if p.wears else np.zeros((len(s), count))
    kinematics = reference.facets(reference.frames(planes[0]), s, p.height, worn)
    slip = state[:, N_POINT_STATEV : N_POINT_STATEV + 3 * count].reshape(len(s), count, 3)[..., 1:]
    return np.linalg.norm(kinematics.local[..., 1:] - slip, axis=-1)
