"""Random updates of the library, by its C API and its UMAT, against the independent NumPy reference.

CTest runs them with the library of each build. Tolerances are multiples of the rounding error
2.2e-16 times the size of the summed terms: K |s| for tractions, |s| for slips and K |s|^2 for energies.
"""

from __future__ import annotations

import itertools
import os
import warnings
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from asperity import Interface, Material, ModelWarning, Pattern
from asperity.contract import N_POINT_STATEV
from support_calls import LIBRARY, address, c_update, umat

from tests.oracle import plane, reference

# CTest has no markers, and pytest need not repeat it
pytestmark = pytest.mark.long
SEED = 2025
POINTS = 70
"""More than the library takes at a time."""
OVER = int(os.environ.get("ASPERITY_SAMPLES_OVER", "1"))
"""Where each instruction checks itself, this part of the samples is drawn, and branches are not counted."""

OPTIONS = {
    "paper": {},
    "height": {"height": 0.3, "kc": 20.0},
    "wear": {"W0": 0.4, "kc": 5.0},
    "height and wear": {"height": 0.06, "W0": 0.2},
    "viscosity": {"tau_v": 0.4, "kc": 2.0},
    "guard": {"guard": True, "kc": 5.0},
    "damage0": {"damage0": 0.4},
    "without bond": {"damage0": 1.0, "kc": 10.0},
    "closure": {"closure": 0.06},
    "closure and height": {"closure": 0.06, "height": 0.3},
    "closure and wear": {"closure": 0.06, "height": 0.3, "W0": 0.5},
    "closure and guard": {"closure": 0.06, "guard": True},
    "closure and viscosity": {"closure": 0.06, "tau_v": 0.3, "damage0": 0.2},
    "almost closed": {"closure": 0.02, "damage0": 0.5},
    "crush": {"crush": 200.0, "kc": 20.0},
    "crush and height": {"crush": 1.0, "height": 0.3, "damage0": 1.0, "kc": 50.0},
    "crush and wear": {"crush": 5.0, "W0": 0.4, "damage0": 0.5},
    "crush and closure": {"crush": 500.0, "closure": 0.05, "kc": 2.0, "damage0": 0.5},
    "crush and guard": {"crush": 2.0, "height": 0.5, "guard": True},
    "dashpot": {"c": 6.0, "damage0": 1.0},
    "dashpot and bond": {"c": 6.0, "kc": 5.0},
    "dashpot and closure": {"c": 2.0, "closure": 0.06, "damage0": 0.5},
    "dashpot and wear": {"c": 6.0, "height": 0.3, "W0": 0.4, "damage0": 0.7},
    "dashpot and crush": {"c": 200.0, "crush": 20.0, "kc": 20.0, "damage0": 1.0},
    "dashpot and guard": {"c": 6.0, "guard": True, "tau_v": 0.2},
    "mode II": {"closure": 0.06, "damage0": 0.3, "sigma02": 4.0, "Gc2": 0.6},
    "all": {"closure": 0.06, "damage0": 0.3, "kc": 2.0, "height": 0.3, "W0": 0.5, "crush": 3.0, "guard": True,
            "tau_v": 0.3, "sigma02": 4.0, "Gc2": 0.6},
    "all and a dashpot": {"closure": 0.06, "damage0": 0.3, "kc": 2.0, "height": 0.3, "W0": 0.5, "crush": 3.0,
                          "guard": True, "tau_v": 0.3, "sigma02": 4.0, "Gc2": 0.6, "c": 4.0},
}  # fmt: skip
BRANCHES = list(itertools.product((plane.OPEN, plane.STICK, plane.SLIP), (0, 1)))


def random_material(rng: np.random.Generator) -> Material:
    """Return constants of the paper's law that span orders of magnitude, of both modes alike or different."""
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
        normals = np.stack(normals, axis=1) * 10 ** rng.uniform(-100, 100, (k, 1))
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


Answer = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Traction, state and tangent of points in rows."""


def by_c(props: np.ndarray, s: np.ndarray, state: np.ndarray, s_old: np.ndarray, dt: float) -> Answer:
    """One call of asperity_update for all points."""
    s_old, s = (np.asfortranarray(array.T) for array in (s_old, s))
    out = c_update(LIBRARY, props, dt, s_old, s, state.T)
    assert out.status == 0, out.message
    return out.stress.T, out.state.T, out.tangent.transpose(2, 1, 0)


def traction_by_c(
    props: np.ndarray, s: np.ndarray, state: np.ndarray, s_old: np.ndarray, dt: float
) -> np.ndarray:
    """Traction of points in rows by one call of asperity_iterate, without a tangent."""
    s_old, s = (np.asfortranarray(array.T) for array in (s_old, s))
    out = c_update(LIBRARY, props, dt, s_old, s, state.T, tangent=False, function="asperity_iterate")
    assert out.status == 0, out.message
    return out.stress.T


def by_umat(props: np.ndarray, s: np.ndarray, state: np.ndarray, s_old: np.ndarray, dt: float) -> Answer:
    """A call of the UMAT for each point, h = 1."""
    points = zip(state, s_old, s - s_old, strict=True)
    outs = [umat(LIBRARY, props, np.zeros(3), old, at, change, dt) for old, at, change in points]
    traction, new, tangent = (np.array([getattr(o, n) for o in outs]) for n in ("stress", "state", "tangent"))
    return traction, new, tangent


Step = tuple[np.ndarray, np.ndarray, np.ndarray, float]
"""Separation of points in rows, state and separation at the start, duration."""


def walked(
    joint: Interface, pattern: reference.Pattern, S: np.ndarray, durations: list[float], state: np.ndarray
) -> Iterator[tuple[Step, Answer, reference.Response]]:
    """Steps of a history from a state on, each by the C API and by the reference.

    Each step starts from what the library has made of the one before, so that the reference takes all of them
    at once.  Where durations have an effect, it takes one by one, and each starts from its state.
    """
    p, s_old = reference.Parameters(**joint.material.values()), np.zeros_like(S[0])
    one_by_one = p.tau_v > 0.0 or p.c > 0.0
    steps, answers, references = [], [], []
    for s, dt in zip(S, durations, strict=True):
        steps.append((s, state, s_old, dt))
        answers.append(by_c(joint.props(), *steps[-1]))
        if one_by_one:
            references.append(reference.update(p, pattern, *steps[-1]))
        state, s_old = references[-1].state if one_by_one else answers[-1][1], s
    if not one_by_one:
        whole = vars(reference.update(p, pattern, *map(np.stack, list(zip(*steps, strict=True))[:3])))
        references = [reference.Response(**{k: a[i] for k, a in whole.items()}) for i in range(len(S))]
    yield from zip(steps, answers, references, strict=True)


def assert_within(name: str, actual: np.ndarray, expected: np.ndarray, tolerance: np.ndarray | float) -> None:
    """Assert that every difference is within the tolerance."""
    excess = np.abs(actual - expected) - tolerance
    worst = np.unravel_index(np.argmax(excess), excess.shape)
    assert np.all(excess <= 0.0), f"{name}{list(worst)}: {actual[worst]!r} instead of {expected[worst]!r}"


@pytest.mark.parametrize("option", OPTIONS)
def test_options(option: str) -> None:
    """Every constant, with offsets and damage of an initial state; all branches occur, and deep closure."""
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]
    material, parameters = Material(**constants), reference.Parameters(**constants)
    rng = np.random.default_rng(SEED)
    counts = dict.fromkeys(BRANCHES, 0)
    far = 0
    # the reference finds what is crushed by bisection
    increments = max(4, (12 if material.crush else 24) // OVER)
    for sides, flat in ((0, 1.0), (2, 0.0), (5, 0.3)):
        interface = Interface(material, Pattern.regular(sides, 30.0, flat, 20.0))
        planes = reference.regular_pattern(sides, 30.0, flat, 20.0)
        S = np.cumsum(rng.standard_normal((increments, POINTS, 3)) * material.s_0, axis=0)
        start = np.zeros((POINTS, interface.nstatv))
        # the first ten points are those of an initial state
        start[:10, 4], start[:10, 5:8] = 1.0, material.s_0 * rng.standard_normal((10, 3))
        start[:10, N_POINT_STATEV : N_POINT_STATEV + 3 * interface.n_planes : 3] = 0.5 * rng.random((10, 1))
        durations = [float(rng.choice([0.0, 0.1 * 10 ** rng.uniform(-3, 3)], p=[0.1, 0.9])) for _ in S]
        for (s, state, s_old, dt), answer, theirs in walked(interface, planes, S, durations, start):
            total = np.linalg.norm(s + state[:, 5:8], axis=1)
            size = np.abs(theirs.traction).max(axis=1) + parameters.Kn * total
            stiff = np.abs(theirs.tangent).max(axis=(1, 2)) + parameters.Kn
            energy = size * (total + np.linalg.norm(s_old + state[:, 5:8], axis=1))
            scale = (1.0 + energy + np.abs(theirs.state).max(axis=1))[:, None]
            # rupture and friction of long increments are judged by test_jumps
            accounts = np.isin(np.arange(interface.nstatv), [2, 3])
            scale = np.where(theirs.long[:, None] & accounts, np.inf, scale)
            few = slice(5, 15)
            by_points = by_umat(interface.props(), s[few], state[few], s_old[few], dt)
            for (traction, new, tangent), some, most in (
                (answer, slice(None), 0.05),
                (by_points, few, 0.2),
            ):
                assert_within("traction", traction, theirs.traction[some], 1e-11 * size[some, None])
                assert_within("state", new, theirs.state[some], 1e-11 * scale[some])
                off = ~(np.abs(tangent - theirs.tangent[some]).max(axis=(1, 2)) <= 1e-6 * stiff[some])
                assert off.mean() <= most  # a trial slip of almost zero
            far += int((stiff > 20.0 * parameters.Kn * parameters.kc).sum())
            for branch, damaging in counts:
                here = (theirs.branch == branch) & (theirs.damaging == bool(damaging))
                counts[branch, damaging] += int(here.sum())
    if OVER == 1:
        broken = parameters.damage0 == 1.0
        least = min(n for (_, damaging), n in counts.items() if not (broken and damaging))
        assert least > 3 * increments, counts
        assert far > 0 or "closure" not in OPTIONS[option]


@pytest.mark.parametrize("theta", [45.0, 75.0])
def test_steep_facets(theta: float) -> None:
    """On facets steeper than those whose closed form is a series the traction is that of the reference."""
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS["height"]
    material, parameters = Material(**constants), reference.Parameters(**constants)
    pattern, planes = (make(5, theta, 0.3, 20.0) for make in (Pattern.regular, reference.regular_pattern))
    joint, rng = Interface(material, pattern), np.random.default_rng(SEED)
    sizes = material.s_0 * 10 ** rng.uniform(-1.0, 0.8, (6, POINTS, 1))
    S = np.cumsum(sizes * rng.standard_normal((6, POINTS, 3)), axis=0)
    start = np.zeros((POINTS, joint.nstatv))
    for (s, *_), (traction, *_), theirs in walked(joint, planes, S, [0.0] * len(S), start):
        size = np.abs(theirs.traction).max(axis=1) + parameters.Kn * np.linalg.norm(s, axis=1)
        assert_within("traction", traction, theirs.traction, 1e-12 * size[:, None])


@pytest.mark.parametrize("option", OPTIONS)
def test_initial_states(option: str) -> None:
    """An initial state carries its traction, and stores what the reference stores at rest."""
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]
    material, parameters = Material(**constants), reference.Parameters(**constants)
    interface, planes = Interface(material, Pattern.regular(5, 30.0)), reference.regular_pattern(5, 30.0)
    props, rng, given = interface.props(), np.random.default_rng(SEED), (0.25, 0.5)
    least, most = [0.0, -0.1, -0.1], [1.0, 0.1, 0.1]
    enough = max(1, 24 // OVER)
    # a traction that cannot be carried takes a hundred times as long as one that can, or with crush more
    carried = OVER > 1 or material.crush > 0.0
    low, high = ([-2.0, -0.1, -0.1], [-0.5, 0.1, 0.1]) if carried else ([-2.0, -0.5, -0.5], [0.3, 0.5, 0.5])
    carrying = []
    for _ in range(4 * enough):
        traction = 3.0 * rng.uniform(low, high)
        state = np.zeros(interface.nstatv)
        state[2:4] = given  # rupture and friction go on from what the caller has
        state[N_POINT_STATEV : N_POINT_STATEV + 18] = rng.uniform(least, most, (6, 3)).ravel()
        arguments = address(props), len(props), 1, address(traction), len(state), address(state), None, 0
        if LIBRARY.asperity_initial_state(*arguments) == 0:
            carrying.append((traction, state))
        if len(carrying) == enough:
            break
    assert len(carrying) == enough
    tractions, states = (np.array(rows) for rows in zip(*carrying, strict=True))
    theirs = reference.update(parameters, planes, np.zeros((enough, 3)), states, tangent=False)
    size = 3.0 + parameters.Kn * np.linalg.norm(states[:, 5:8], axis=1, keepdims=True)
    assert_within("traction", theirs.traction, tractions, 1e-9 * size)
    assert (states[:, 2:4] == given).all()
    assert_within("state", states[:, :4], theirs.state[:, :4], 1e-9 * size)
    damage = slice(N_POINT_STATEV, None, 3)
    assert_within("damage", states[:, damage], theirs.state[:, damage], 1e-9)


def test_crushed_share() -> None:
    """The share of a facet that its pressure crushes keeps its digits at small pressures."""
    material = Material(3.0, 0.3, 0.9, 0.5, kc=100.0, damage0=1.0, crush=1e3)
    interface = Interface(material, Pattern.regular(2, 30.0, 0.0))
    s, start = np.zeros((POINTS, 3)), np.zeros((POINTS, interface.nstatv))
    s[:, 1] = np.linspace(0.01, 0.2, POINTS)
    foot = np.tan(np.radians(30.0))
    s[:, 0] = 0.5 * foot * s[:, 1]
    omega = by_c(interface.props(), s, start, 0.0 * s, 0.0)[1][:, -4]
    # the pressure over `crush`, by the closure along the normal of the crushed facet, and its factor
    slope = (1.0 - omega) * foot
    x = 0.1 * material.K * s[:, 1] * (slope - 0.5 * foot) / np.hypot(1.0, slope)
    x *= 1.0 - material.mu * 0.5 * foot
    np.testing.assert_allclose(omega, 1.0 - np.log1p(x) / x, rtol=2e-14)


TRACTION = 1e-12
"""Of K |s|: 4500 rounding errors, for sums over up to 65 planes after up to 20 increments."""

STATE = 1e-13
"""Of |s| for slips, K |s|^2 for energies, |s|/(s0 eta) for damage: 450 rounding errors."""

TANGENT = 1e-13
"""Of K (1 + (|s|/s0)^2/eta) |s|/|s_T - s_di|: growing damage, and the direction of a small trial stress."""


def test_patterns_and_materials() -> None:
    """Random patterns and constants of the paper's law; every branch occurs more than 500 times."""
    rng = np.random.default_rng(20150131)
    counts = dict.fromkeys(BRANCHES, 0)
    for _ in range(max(6, 200 // OVER)):
        m, (pattern, planes) = random_material(rng), random_pattern(rng)
        p, interface = reference.Parameters(**m.values()), Interface(m, pattern)
        K, shortest = max(p.Kn, p.Kt, p.kc * p.Kn), min(p.s0, p.s02)
        S = random_history(rng, shortest, points=20, increments=6)
        start, largest = np.zeros((20, interface.nstatv)), np.zeros(20)
        for (s, state, *_), (traction, new, tangent), theirs in walked(
            interface, planes, S, [0.0] * len(S), start
        ):
            largest = np.maximum(largest, np.linalg.norm(s, axis=1))
            ratio, scale = (largest / shortest)[:, None], largest[:, None]
            assert_within("traction", traction, theirs.traction, TRACTION * K * scale)
            tolerance = np.empty_like(state)
            tolerance[:, 1:5] = STATE * K * scale**2
            tolerance[:, 5:9] = 0.0
            tolerance[:, [0]] = tolerance[:, N_POINT_STATEV::3] = STATE * ratio / p.eta
            tolerance[:, N_POINT_STATEV + 1 :: 3] = tolerance[:, N_POINT_STATEV + 2 :: 3] = STATE * scale
            tolerance[theirs.long, 2:4] = np.inf
            assert_within("state", new, theirs.state, tolerance)
            # |s_T - s_di| of every plane at the start of the return mapping
            local = np.einsum("kab,nb->nka", reference.frames(planes[0]), s)[..., 1:]
            trial = np.linalg.norm(local - state[:, N_POINT_STATEV:].reshape(20, -1, 3)[..., 1:], axis=-1)
            margin = np.where(theirs.branch == plane.SLIP, trial, largest[:, None])
            closest = (largest / margin.min(axis=1))[:, None, None]
            growth = 1.0 + ratio[..., None] ** 2 / p.eta
            assert_within("tangent", tangent, theirs.tangent, TANGENT * K * growth * closest)
            for branch, damaging in counts:
                met = (theirs.branch == branch) & (theirs.damaging == bool(damaging))
                counts[branch, damaging] += int(met.sum())
    assert OVER > 1 or min(counts.values()) > 500, counts


JUMPS = {
    "bond": {},
    "modes": {"kc": 20.0, "sigma02": 4.0, "Gc2": 0.6},
    "brittle": {"kc": 20.0, "eta": 0.99},
    "without bond": {"damage0": 1.0},
    "without bond, stiff": {"damage0": 1.0, "kc": 20.0},
}
CURVED = {
    "height": {"height": 0.3, "kc": 20.0},
    "closure": {"closure": 0.06},
    "crush": {"crush": 20.0, "kc": 20.0},
    "smooth crush": {"crush": 20.0, "kc": 20.0, "mu": 0.0},
    "all": {"closure": 0.06, "height": 0.3, "crush": 3.0, "damage0": 0.3, "kc": 2.0},
}
JUMP_POINTS, JUMP_PARTS = 50, 200


def jumps(material: Material, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return separations (points, 3) of pressed points, after a slip of half of them, and after a jump.

    The jumps of 0.2 to 20 s_f slip, open, or do both.
    """
    n, s_f = JUMP_POINTS, 2.0 * material.Gc / material.sigma0
    pressed = np.zeros((n, 3))
    pressed[:, 0] = -rng.uniform(0.0, 6.0, n) / (material.K * (material.kc or 1.0))
    slipped = pressed + (rng.random(n) < 0.5)[:, None] * s_f * rng.normal(0.0, [0.0, 0.3, 0.3], (n, 3))
    far, angle = s_f * np.exp(rng.uniform(np.log(0.2), np.log(20.0), n)), rng.uniform(0.0, 2.0 * np.pi, n)
    kind = np.arange(n) % 3
    normal = far * np.choose(kind, [0.0, 1.0, rng.uniform(-0.02, 1.0, n)])
    along = far * np.choose(kind, [1.0, 0.01, rng.random(n)])
    jump = np.stack([normal, along * np.cos(angle), along * np.sin(angle)], axis=-1)
    return pressed, slipped, slipped + jump


BOND = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5}


def errors_of_jumps(sides: int, dt: float, **constants: float) -> Iterator[np.ndarray]:
    """Errors (points, 2) of rupture and friction against fine parts, over Gc and work, for each of `jumps`.

    dt: duration of an increment.  Friction of no point is negative.
    """
    material, parameters = Material(**constants), reference.Parameters(**constants)
    props = Interface(material, Pattern.regular(sides, 30.0)).props()
    planes, rng = reference.regular_pattern(sides, 30.0), np.random.default_rng(SEED)
    state = np.zeros((JUMP_POINTS, len(reference.virgin(planes, parameters.wears))))
    s_old, steps = np.zeros((JUMP_POINTS, 3)), []
    for s in jumps(material, rng):
        new = by_c(props, s, state, s_old, dt)[1]
        steps.append((s, state, s_old, new))
        state, s_old = new, s
    s, state, s_old, new = (np.stack(rows) for rows in zip(*steps, strict=True))
    fine = reference.in_parts(parameters, planes, s, state, s_old, dt, parts=JUMP_PARTS)
    spent, sought = (x[..., 1:4] - state[..., 1:4] for x in (new, fine))
    assert spent[..., 2].min() >= 0.0
    yield from np.abs(spent - sought)[..., 1:] / (material.Gc + np.abs(sought).sum(axis=-1))[..., None]


@pytest.mark.fine_parts
@pytest.mark.parametrize("option", JUMPS)
@pytest.mark.parametrize("sides", [0, 4])
def test_jumps(option: str, sides: int) -> None:
    """A jump books what its fine parts dissipate: 90 % within 1 % of Gc and work, all within 20 %."""
    for off in errors_of_jumps(sides, 0.0, **BOND | JUMPS[option]):
        assert np.quantile(off, 0.9, axis=0).max() < 0.01, off
        assert off.max() < 0.2, off


@pytest.mark.parametrize("entry", [by_c, by_umat])
def test_jump_of_one_point(entry: Callable[..., Answer]) -> None:
    """A flat joint books the same for a jump in any direction along it, with no other point in the block."""
    joint = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0))
    pressed, booked = np.array([[-1.0 / joint.material.K, 0.0, 0.0]]), []
    start = entry(joint.props(), pressed, np.zeros((1, joint.nstatv)), 0.0 * pressed, 0.0)[1]
    for angle in (0.0, 0.5 * np.pi, 1.0, np.pi, 1.5 * np.pi):
        s = pressed + 3.0 * joint.material.s_f * np.array([0.0, np.cos(angle), np.sin(angle)])
        booked.append(entry(joint.props(), s, start, pressed, 0.0)[1][0, :4])
    np.testing.assert_allclose(booked, booked[:1] * len(booked), rtol=1e-12, atol=1e-14)


@pytest.mark.fine_parts
def test_jumps_of_an_open_joint() -> None:
    """An open joint of two modes books in a jump what 400 steps of the reference book."""
    constants, rng, n = BOND | OPTIONS["mode II"], np.random.default_rng(SEED), 200
    material, parameters = Material(**constants), reference.Parameters(**constants)
    joint, planes = Interface(material, Pattern.regular(0, 0.0)), reference.regular_pattern(0, 0.0)
    s_old, change = (
        material.s_0 * 10 ** rng.uniform(-1.0, most, (n, 1)) * np.abs(rng.standard_normal((n, 3)))
        for most in (1.0, 1.3)
    )
    start = by_c(joint.props(), s_old, np.zeros((n, joint.nstatv)), 0.0 * s_old, 0.0)[1]
    booked = by_c(joint.props(), s_old + change, start, s_old, 0.0)[1][:, 2]
    state = start
    for begin, end in itertools.pairwise(s_old + np.linspace(0.0, 1.0, 401)[:, None, None] * change):
        state = reference.update(parameters, planes, end, state, begin, 0.0, tangent=False).state
    assert np.median(state[:, 2] - start[:, 2]) > 0.1 * material.Gc
    off = np.abs(booked - state[:, 2]) / material.Gc
    assert np.quantile(off, 0.9) < 1e-3 and off.max() < 1e-2, off


@pytest.mark.parametrize("option", OPTIONS)
def test_turned_joint(option: str) -> None:
    """A joint that is turned with its separations has the same damage and energies; its tractions turn."""
    material, angle, rng = Material(**BOND | OPTIONS[option]), np.radians(70.0), np.random.default_rng(SEED)
    turn = np.eye(3)
    turn[1:, 1:] = [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]
    for sides, flat in ((0, 1.0), (5, 0.3)):
        joints = [Interface(material, Pattern.regular(sides, 30.0, flat, x)) for x in (0.0, 70.0)]
        begin, states = np.zeros((POINTS, 3)), [np.zeros((POINTS, joint.nstatv)) for joint in joints]
        for _ in range(4):
            step = material.s_0 * 10 ** rng.uniform(-1.0, 1.3, (POINTS, 1)) * rng.standard_normal((POINTS, 3))
            end, dt = begin + step, float(rng.choice([0.02, 0.3, 3.0]))
            (traction, state, _), (other, turned, _) = (
                by_c(joint.props(), end @ axes, state, begin @ axes, dt)
                for joint, axes, state in zip(joints, (np.eye(3), turn), states, strict=True)
            )
            far = np.linalg.norm(end, axis=1) + np.linalg.norm(begin, axis=1) + material.s_f
            size = np.abs(traction).max(axis=1) + material.K * max(1.0, material.kc) * far
            assert_within("traction", other, traction @ turn, 1e-10 * size[:, None])
            energy = 1.0 + size * far + np.abs(state[:, :4]).max(axis=1)
            assert_within("state", turned[:, :4], state[:, :4], 1e-10 * energy[:, None])
            begin, states = end, [state, turned]


# relaxation time over the duration: largest error, in between that of one backward Euler step for many
VISCOUS = {1e-3: 0.1, 0.1: 0.4, 1.0: 0.25, 10.0: 0.05}


@pytest.mark.fine_parts
@pytest.mark.parametrize("tau", VISCOUS)
@pytest.mark.parametrize("sides", [0, 4])
def test_viscous_jumps(sides: int, tau: float) -> None:
    """With viscosity the accounts of a jump are those of its parts, if it is long or short beside tau_v."""
    for off in errors_of_jumps(sides, 1.0, **BOND, tau_v=tau):
        assert off.max() < VISCOUS[tau], off


# c/(kc Kn) over the duration: 90 % of the errors of friction and dashpot
DAMPED = {1e-3: 0.01, 0.3: 0.1, 3.0: 0.12}


@pytest.mark.fine_parts
@pytest.mark.parametrize("lag", DAMPED)
@pytest.mark.parametrize("sides", [0, 4])
@pytest.mark.parametrize("option", ["bond", "modes"])
def test_damped_jumps(option: str, sides: int, lag: float) -> None:
    """With a dashpot a jump books the rupture of its parts; its losses are right if it lasts."""
    material = Material(**BOND | JUMPS[option])
    c = lag * material.K * (material.kc or 1.0)
    for off in errors_of_jumps(sides, 1.0, **BOND | JUMPS[option], c=c):
        assert (np.quantile(off, 0.9, axis=0) < [0.03, DAMPED[lag]]).all(), off
        assert (off.max(axis=0) < [0.05, 0.3]).all(), off


# c/(kc Kn) over the duration, 0 without a dashpot: 90 % of the errors of rupture and friction, largest error
LAGS = {0.0: (0.05, 0.02, 1.5), 0.3: (0.05, 0.06, 1.5), 237.0: (0.05, 0.2, 1.5)}


@pytest.mark.fine_parts
@pytest.mark.parametrize("lag", LAGS)
@pytest.mark.parametrize("option", CURVED)
def test_jumps_of_curved_contacts(option: str, lag: float) -> None:
    """Facets and hyperbolas book what their fine parts dissipate, with a dashpot of any stiffness, too."""
    material = Material(**BOND | CURVED[option])
    c = lag * material.K * (material.kc or 1.0)
    for off in errors_of_jumps(4, 1.0, **BOND | CURVED[option], c=c):
        assert (np.quantile(off, 0.9, axis=0) < LAGS[lag][:2]).all(), off
        assert off.max() < LAGS[lag][2], off


def test_jumps_beyond_the_compressive_strength() -> None:
    """With a dashpot the friction of a joint that is crushed in a jump is that of its parts."""
    constants = BOND | {"kc": 5.0, "fc": 14.0, "Gfc": 7.0, "Css": 1.0}
    material = Material(**constants, c=0.3 * 5.0 * Material(**BOND).K)
    joint = Interface(material, Pattern.regular(4, 30.0))
    state, s_old = np.zeros((JUMP_POINTS, joint.nstatv)), np.zeros((JUMP_POINTS, 3))
    parts = 2000 if OVER == 1 else 100  # of 2000 none is long
    for s in jumps(material, np.random.default_rng(SEED)):
        new = by_c(joint.props(), s, state, s_old, 1.0)[1]
        fine, ends = state, np.linspace(0.0, 1.0, parts + 1)
        for x, y in itertools.pairwise(ends):
            first, last = (np.asfortranarray((s_old + z * (s - s_old)).T) for z in (x, y))
            fine = c_update(LIBRARY, joint.props(), y - x, first, last, fine.T, tangent=False).state.T
        off = np.abs(new - fine)[:, 3] / (material.Gc + np.abs(fine - state)[:, 1:4].sum(axis=1))
        assert OVER > 1 or np.quantile(off, 0.9) < 0.1, off
        state, s_old = new, s
    assert (state[:, -2] > 0.1 * material.s_f).sum() > 10


@pytest.mark.parametrize(
    "option", [{"W0": 1.0, "kc": 734.0}, {"W0": 1.0}, {"fc": 10.0, "Gfc": 2.0}, {"c": 5.0}]
)
def test_slips_of_twenty_increments(option: dict[str, float]) -> None:
    """Wear by work, crushing and a dashpot: 90 % of both accounts agree with those of 4000 increments."""
    material = Material(**BOND | {"kc": 20.0, "height": 0.2} | option)
    joint, rng = Interface(material, Pattern.regular(4, 30.0)), np.random.default_rng(SEED)
    start, end = np.zeros((2, JUMP_POINTS, 3))
    start[:, 0] = end[:, 0] = -rng.uniform(0.03, 3.0, JUMP_POINTS) / (material.K * material.kc)
    angle, length = rng.uniform(0.0, 2.0 * np.pi, JUMP_POINTS), rng.uniform(0.25, 5.0, JUMP_POINTS)
    end[:, 1:] = (length * material.s_f * np.stack([np.cos(angle), np.sin(angle)])).T
    ends = []
    for increments in (20, 4000):
        state, s_old, dt = None, start, 1.0 / increments
        for x in np.linspace(0.0, 1.0, increments + 1):
            s = start + x * (end - start)
            state, s_old = joint.update(s, state, s_old, dt if material.c else None).state, s
        ends.append(state)
    off = np.abs(ends[0] - ends[1])[:, 2:4] / (material.Gc + np.abs(ends[1])[:, 1:4].sum(axis=1))[:, None]
    assert np.quantile(off, 0.9, axis=0).max() < 0.02, off


@pytest.mark.fine_parts
def test_guarded_jumps() -> None:
    """The damage of a flat joint grows where the rupture of its fine parts is positive; none is negative."""
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5, "kc": 5.0}
    material, free = Material(**constants, guard=True), reference.Parameters(**constants)
    props, planes = Interface(material, Pattern.regular(0, 0.0)).props(), reference.regular_pattern(0, 0.0)
    rng = np.random.default_rng(SEED)
    state, s_old = np.zeros((JUMP_POINTS, N_POINT_STATEV + 3)), np.zeros((JUMP_POINTS, 3))
    refused = 0
    # slip of an open joint, closure, slip back
    angle, path = rng.uniform(0.0, 2.0 * np.pi, JUMP_POINTS), np.zeros((3, JUMP_POINTS, 3))
    path[0, :, 1:] = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    path[0] *= rng.uniform(0.02, 0.05, (JUMP_POINTS, 1))
    path[1:, :, 0] = -rng.uniform(0.0, 0.1, JUMP_POINTS)
    path[1] += path[0]
    path[2, :, 1:] = -rng.uniform(0.0, 2.0, (JUMP_POINTS, 1)) * path[0, :, 1:]
    for s in path:
        new = by_c(props, s, state, s_old, 0.0)[1]
        assert (new[:, 2] - state[:, 2]).min() >= -1e-15
        grown = reference.update(free, planes, s, state, s_old, part=True, tangent=False).state
        sought = reference.in_parts(free, planes, s, state, s_old, parts=JUMP_PARTS)[:, 2] - state[:, 2]
        clearly, at = 0.02 * material.Gc, N_POINT_STATEV
        np.testing.assert_array_equal(new[sought < -clearly, at], state[sought < -clearly, at])
        np.testing.assert_allclose(new[sought > clearly, at], grown[sought > clearly, at], rtol=1e-12)
        refused += int((sought < -clearly).sum())
        state, s_old = new, s
    assert refused > 10


@pytest.mark.parametrize("entry", [by_c, by_umat])
@pytest.mark.parametrize("tau_v", [0.0, 1.0])
@pytest.mark.parametrize("option", ["height", "closure", "crush"])
def test_guarded_rupture_needs_damage(option: str, tau_v: float, entry: Callable[..., Answer]) -> None:
    """Where no plane is damaged further no rupture is booked, whatever the guard decides within a jump."""
    material = Material(**BOND | CURVED[option], tau_v=tau_v, guard=True)
    joint, rng = Interface(material, Pattern.regular(2, 30.0)), np.random.default_rng(SEED)
    n = 400 if entry is by_c else 40
    state, s_old, kept = np.zeros((n, joint.nstatv)), np.zeros((n, 3)), 0
    planes = slice(N_POINT_STATEV, N_POINT_STATEV + 3 * joint.n_planes, 3)
    for _ in range(6):
        s = material.s_f * rng.normal(0.0, [0.3, 2.0, 0.5], (n, 3))
        new = entry(joint.props(), s, state, s_old, tau_v)[1]
        grown = (new[:, planes] > state[:, planes]).any(axis=1)
        np.testing.assert_array_equal(new[~grown, 2], state[~grown, 2])
        kept += int((~grown).sum())
        state, s_old = new, s
    assert kept > n // 4
