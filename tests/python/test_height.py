"""Finite asperity height and wear: the library against the independent NumPy reference on random histories.

Tolerances are those of test_against_reference, times the number of operations that a facet adds.
"""

from __future__ import annotations

import itertools
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, ModelWarning, Pattern
from asperity.contract import N_POINT_STATEV
from asperity.remarks import doubts

from harness.studies.compare import parameters_of
from tests.oracle import reference

SEED = 20151987

ROUNDING = 1e-12
"""Relative to K |s| for tractions, |s| for slips and K |s|^2 for energies.

The tangent is compared relative to K times its growth with |s|/s_0, |s|/H and |s|/|s_T - s_di|.
"""

POINTS, INCREMENTS = 20, 6

CONSTANTS = [("height",), ("W0",), ("height", "W0"), ("crush",), ("height", "crush")]


def random_interface(
    rng: np.random.Generator, **constants: float
) -> tuple[Material, Pattern, reference.Pattern]:
    """Return an interface whose sizes span orders of magnitude; height in s_f, W0 in Gc, crush in sigma0."""
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
        sizes = {"height": material.s_f, "W0": material.Gc, "crush": material.sigma0}
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
@pytest.mark.parametrize("constants", CONSTANTS, ids="-".join)
def test_random_histories(constants: tuple[str, ...]) -> None:
    """Tractions, states and tangents agree on 7,200 updates; every branch occurs 150 times."""
    rng = np.random.default_rng([SEED, len(constants), len(constants[0])])
    counts = dict.fromkeys(
        itertools.product((reference.OPEN, reference.STICK, reference.SLIP), (False, True)), 0
    )
    for _ in range(60):
        drawn = {name: 10 ** rng.uniform(-1.5, 1.5) for name in constants}
        material, pattern, planes = random_interface(rng, **drawn)
        compare(material, pattern, planes, random_history(rng, material.s_0), counts)
    assert min(counts.values()) > 150, counts


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


@pytest.mark.parametrize("through", ["umat", "vumat"])
def test_hosts_take_facets(run, tmp_path: Path, through: str) -> None:
    """A path with height and wear, replayed through UMAT and VUMAT, gives the rows of the driver."""
    head = "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 20.0, height = 0.3, W0 = 2.0 /\n"
    head += "&pattern sides = 4, theta = 30.0 /\n"
    path = (
        "&step s_N = -0.005, increments = 10 /\n"
        "&step s_N = 0.03, s_Tx = 0.2, -0.1, s_Ty = 0.05, increments = 60 /\n"
    )
    direct = run(head + path, "--planes")
    (tmp_path / "case.csv").rename(tmp_path / "record.csv")
    replay = run(head + f"&replay file = 'record.csv', through = '{through}' /\n", "--planes")
    assert direct.header == replay.header and direct.header[-2:] == ["worn_5", "wear_work_5"]
    assert max(direct[f"worn_{k}"][-1] for k in range(1, 6)) > 0.01
    for name in direct.header:
        if name not in ("step", "increment", "iterations", "event"):
            np.testing.assert_allclose(replay[name], direct[name], rtol=1e-11, atol=1e-11, err_msg=name)


@pytest.mark.parametrize("height", [0.0, 0.1, 0.5])
def test_initial_state_of_a_climbed_joint(height: float) -> None:
    """The slips of a joint that has climbed its facets lead to the separation at which it stands."""
    joint = Interface(Material(3.0, 0.3, 0.9, 0.5, kc=100.0, height=height), Pattern.regular(4, 30.0))
    test = joint.confined_slip(20.0, np.linspace(0.0, 0.4, 401)[1:], -1.0)
    planes = test.state[-1, N_POINT_STATEV:].reshape(-1, 3)
    state = joint.initial(test.traction[-1], damage=planes[:, 0], slip=planes[:, 1:])
    # the elastic part of the slips is not given
    compliance = np.abs(test.traction[-1]).max() / joint.material.K
    np.testing.assert_allclose(state[5:8], test.separation[-1], rtol=0, atol=compliance)
    at_rest = joint.update(np.zeros((1, 3)), state[None])
    np.testing.assert_allclose(at_rest.traction[0], test.traction[-1], rtol=0, atol=1e-9)


def test_height_is_compared_with_the_constants_of_the_case(run) -> None:
    """The ratio of height and s_f is that of the case, and an error names it."""
    case = "&material sigma0 = {}, Gc = {}, eta = 0.9, mu = 0.5, height = {} /\n"
    rest = "&pattern sides = 2, theta = 30.0 /\n&step s_N = {}, increments = 1 /\n"
    assert len(run(case.format("3.0e3", "0.3e15", "1e12") + rest.format("1e3")).rows) == 1
    messages = run(case.format("3.0e6", "1e-9", "1.0") + rest.format("1e-20"), code=1).messages
    assert "height sigma0/(2 Gc) = 1.5" in messages and ": expected 1e-10 to 1e10" in messages


def test_wear_of_a_huge_pressure_is_told() -> None:
    """A pressure whose square is beyond the range of a double gives the warning and no error of its own."""
    material = Material(3.0, 0.3, 0.9, 0.5, height=0.5, W0=1.0)
    assert any("Inf W0" in text for text in doubts(material, Pattern.regular(2, 30.0), -1e160))


def test_facet_beyond_its_end_is_flat() -> None:
    """Where nothing of the slope is left, the tangent is that of a flat contact, for the lowest height."""
    joint = Interface(Material(3.0, 0.3, 0.9, 0.5, height=1e-10 * 0.2), Pattern.regular(3, 89.9999, flat=0.0))
    state = np.zeros((1, joint.nstatv))
    state[0, N_POINT_STATEV::3] = 1.0
    s = np.array([[-46.0, -17.0, 1.6]])
    tangent = joint.update(s, state, s).tangent[0]
    assert np.abs(tangent).max() < 10.0 * joint.material.K
