"""Traction and tangent with damage, friction bound and facets of another separation, the aim."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, installed
from asperity.contract import N_POINT_STATEV
from support_calls import LIBRARY, c_update
from test_oracle import OPTIONS, OVER, Answer, assert_within

from tests.oracle import cap, frozen, reference

# CTest has no markers, and pytest need not repeat it
pytestmark = pytest.mark.long

SEED = 55
POINTS = 70
"""More than the library takes at a time."""
INCREMENTS = 6 if OVER == 1 else 2
ROUNDING = 1e-12
"""Of tractions over stress and stiffness times separations: a few thousand rounding errors."""

Call = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]
"""Separation, aim, state and separation at the start, duration."""


def constants(option: str) -> dict[str, float]:
    """Constants of a material with an option."""
    return {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]


def calls(joint: Interface, seed: int) -> list[Call]:
    """Increments of random walks; the aim is beyond s, before it, at the start or far away."""
    rng, size = np.random.default_rng(seed), joint.material.s_0
    s_old, state, made = np.zeros((POINTS, 3)), np.zeros((POINTS, joint.nstatv)), []
    # some points carry an initial traction, with damage
    state[:20, 4], state[:20, 5:8] = 1.0, 0.5 * size * rng.standard_normal((20, 3))
    state[:20, N_POINT_STATEV : N_POINT_STATEV + 3 * joint.n_planes : 3] = 0.7 * rng.random((20, 1))
    for _ in range(INCREMENTS):
        s = s_old + size * 10 ** rng.uniform(-1.5, 0.5, (POINTS, 1)) * rng.standard_normal((POINTS, 3))
        part = rng.choice([0.0, 0.5, 1.0, 1.5], (POINTS, 1))
        beside = size * rng.choice([0.0, 0.01, 1.0], (POINTS, 1)) * rng.standard_normal((POINTS, 3))
        aim = s_old + part * (s - s_old) + beside
        dt = float(rng.choice([0.0, 0.1 * 10 ** rng.uniform(-2, 2)], p=[0.1, 0.9]))
        made.append((s, aim, state, s_old, dt))
        state, s_old = joint.update(s, state, s_old, dt).state, s
    return made


def together(joint: Interface, made: list[Call]) -> list[Call]:
    """One call of all points where durations have no effect."""
    if joint.material.tau_v or joint.material.c:
        return made
    s, aim, state, s_old = (np.concatenate(rows) for rows in list(zip(*made, strict=True))[:4])
    return [(s, aim, state, s_old, 0.0)]


def sizes(joint: Interface, call: Call, stress: np.ndarray) -> np.ndarray:
    """Stress (n,) of which rounding errors are fractions: stiffness times separations, facets included."""
    s, aim, state = call[:3]
    whole = sum(np.linalg.norm(x, axis=1) for x in (s + state[:, 5:8], aim + state[:, 5:8], s - aim))
    return np.abs(stress).max(axis=1) + joint.material.K * max(1.0, joint.material.kc) * whole


def by_c(joint: Interface, call: Call, aimed: bool = True, library: ctypes.CDLL = LIBRARY) -> Answer:
    """One call of asperity_update for all points, without its aim if not `aimed`."""
    s, aim, state, s_old, dt = call
    s, aim, s_old = (np.asfortranarray(rows.T) for rows in (s, aim, s_old))
    out = c_update(library, joint.props(), dt, s_old, s, state.T, aim=aim if aimed else None)
    assert out.status == 0, out.message
    return out.stress.T, out.state.T, out.tangent.transpose(2, 1, 0)


def columns_off(
    law: Callable[[np.ndarray], np.ndarray],
    s: np.ndarray,
    tangent: np.ndarray,
    step: float,
    bound: np.ndarray | float,
) -> int:
    """Assert that tangents are symmetric and not negative; number of columns that are not derivatives.

    law: tractions (n, 3) of separations; bound: largest difference from central differences of that step.
    """
    assert np.array_equal(tangent, tangent.transpose(0, 2, 1))
    values = np.linalg.eigvalsh(tangent)
    assert (values[:, 0] >= -1e-14 * values[:, 2]).all(), values.min()
    off = 0
    for i, axis in enumerate(np.eye(3)):
        slope = (law(s + step * axis) - law(s - step * axis)) / (2.0 * step)
        off += int((np.abs(slope - tangent[:, :, i]) > bound).any(axis=1).sum())
    return off


@pytest.mark.parametrize("option", OPTIONS)
def test_reference(option: str) -> None:
    """The traction is the gradient of a convex energy, the tangent its derivative; the state is that of s."""
    parameters, off, tried = reference.Parameters(**constants(option)), 0, 0
    for sides, flat in ((0, 1.0), (2, 0.0), (5, 0.3)):
        joint = Interface(Material(**constants(option)), Pattern.regular(sides, 30.0, flat, 20.0))
        planes = reference.regular_pattern(sides, 30.0, flat, 20.0)
        for call in together(joint, calls(joint, SEED)):
            s, aim, state, s_old, dt = call
            traction, new, tangent = by_c(joint, call)
            law = frozen.law(parameters, planes, aim, state, s_old, dt)
            theirs = law(s)
            # the reference finds what is crushed by bisection
            rounding = (1e-9 if parameters.crush else 1e-11) * sizes(joint, call, theirs)
            assert_within("traction", traction, theirs, rounding[:, None])
            assert np.array_equal(new, by_c(joint, call, aimed=False)[1])
            stiff = np.abs(tangent).max(axis=(1, 2)) + joint.material.K
            off += columns_off(law, s, tangent, 1e-6 * joint.material.s_0, 1e-5 * stiff[:, None])
            tried += 3 * len(s)
    # a kink within the step: contact, onset of slip, trial slip of almost zero, end of the hyperbola
    assert off <= 0.005 * tried, (off, tried)


@pytest.mark.parametrize("option", OPTIONS)
def test_aim_at_the_end(option: str) -> None:
    """Where the aim is the separation itself, the traction is that of the law."""
    joint = Interface(Material(**constants(option)), Pattern.regular(5, 30.0, 0.3, 20.0))
    for call in calls(joint, SEED + 1):
        s, _, state, s_old, dt = call
        law, end = (joint.update(s, state, s_old, dt, aim=aim) for aim in (None, s))
        size = sizes(joint, (s, s, *call[2:]), law.traction)
        assert_within("traction", end.traction, law.traction, ROUNDING * size[:, None])


@pytest.mark.parametrize("option", OPTIONS)
def test_steps_of_any_size(option: str) -> None:
    """Between two separations with the same aim the work of the change of the traction is not negative."""
    joint = Interface(Material(**constants(option)), Pattern.regular(4, 40.0, 0.2))
    rng = np.random.default_rng(SEED + 2)
    for s, aim, state, s_old, dt in calls(joint, SEED + 2):
        away = s + joint.material.s_0 * 10 ** rng.uniform(-6, 3, (POINTS, 1)) * rng.standard_normal(
            (POINTS, 3)
        )
        ends = [joint.update(ends, state, s_old, dt, aim=aim).traction for ends in (s, away)]
        work = ((ends[1] - ends[0]) * (away - s)).sum(axis=1)
        stress = np.abs(ends).max(axis=(0, 2)) + joint.material.K * np.abs([s, aim, away]).max(axis=(0, 2))
        assert (work >= -ROUNDING * stress * np.linalg.norm(away - s, axis=1)).all()


@pytest.mark.parametrize(("sides", "flat"), [(0, 1.0), (4, 0.2)])
def test_compressive_strength(sides: int, flat: float) -> None:
    """The strength at the aim bounds the pressure, else the traction is that without a strength.

    The tangent is symmetric, not negative, and the derivative of the traction.
    """
    strength = {"fc": 3.0, "Gfc": 2.0, "kp": 0.02, "Css": 2.0, "fcr": 0.3}
    pattern, crushed, off, tried = Pattern.regular(sides, 30.0, flat, 20.0), 0, 0, 0
    joint = Interface(Material(**constants("paper"), **strength), pattern)
    free = Interface(Material(**constants("paper")), pattern)
    for call in calls(joint, SEED + 5):
        s, aim, state, s_old, dt = call
        traction, _, tangent = by_c(joint, call)
        at_aim, new, _ = by_c(joint, (aim, aim, state, s_old, dt), aimed=False)
        before, after = (rows[:, -2:-1] * [1.0, 0.0, 0.0] for rows in (state, new))
        seen = s + before, aim + after, state[:, :-2], s_old + before, dt
        without, _, elastic = by_c(free, seen)
        bound = cap.Cap(**strength).strength(new[:, -2]) ** 2 - strength["Css"] * (at_aim[:, 1:] ** 2).sum(1)
        bound = np.sqrt(np.maximum(bound, 0.0))
        size = strength["fc"] + sizes(joint, call, without)
        over, clear = -without[:, 0] > bound, np.abs(without[:, 0] + bound) > 1e-9 * size
        assert_within("pressure", traction[over, 0], -bound[over], 1e-11 * size[over])
        assert_within("traction", traction[~over], without[~over], 1e-11 * size[~over, None])
        assert_within("tangent", tangent[~over & clear], elastic[~over & clear], 1e-9 * joint.material.K)

        def law(s: np.ndarray, call: Call = call) -> np.ndarray:
            return by_c(joint, (s, *call[1:]))[0]

        off += columns_off(law, s, tangent, 1e-6 * joint.material.s_0, 1e-5 * joint.material.K)
        tried += 3 * len(s)
        crushed += int(over.sum())
    assert crushed > 10 * INCREMENTS and off <= 0.01 * tried, (crushed, off, tried)


def test_every_point_has_its_aim() -> None:
    """A point has the same bits alone, among others, and in a call that uses threads."""
    joint = Interface(Material(**constants("all")), Pattern.regular(5, 30.0, 0.3, 20.0))
    s, aim, state, s_old, dt = calls(joint, SEED + 3)[-1]
    whole = joint.update(s, state, s_old, dt, aim=aim)
    many = joint.update(
        *(np.tile(rows, (60, 1)) for rows in (s, state, s_old)), dt, aim=np.tile(aim, (60, 1))
    )
    for i in (0, 1, 17, 64, POINTS - 1):
        alone = joint.update(s[i : i + 1], state[i : i + 1], s_old[i : i + 1], dt, aim=aim[i : i + 1])
        for name in ("traction", "state", "tangent"):
            wanted = getattr(whole, name)[i]
            assert np.array_equal(getattr(alone, name)[0], wanted)
            assert np.array_equal(getattr(many, name)[POINTS * 59 + i], wanted)


def test_python_and_c() -> None:
    """Python and the C API of its library give the same bits."""
    joint = Interface(Material(**constants("all")), Pattern.regular(5, 30.0, 0.3, 20.0))
    library = ctypes.CDLL(str(installed.library()))
    for call in calls(joint, SEED + 4):
        s, aim, state, s_old, dt = call
        end = joint.update(s, state, s_old, dt, aim=aim)
        for ours, theirs in zip(
            (end.traction, end.state, end.tangent), by_c(joint, call, True, library), strict=True
        ):
            assert np.array_equal(ours, theirs)


def test_bad_aims() -> None:
    """What is wrong with an aim is said by its name, and nothing is written then."""
    joint = Interface(Material(**constants("paper")), Pattern.regular(4, 30.0))
    s, state = np.full((3, 3), 0.01), np.zeros((3, joint.nstatv))
    out = np.full((3, 3), 7.0), state, np.full((3, 3, 3), 7.0)
    aim = s.copy()
    aim[1, 2] = np.nan
    with pytest.raises(ValueError, match=r"point 1 \(of 0 to 2\): s_Ty of the aim = NaN: expected a finite"):
        joint.update(s, state, out=out, aim=aim)
    assert not state.any() and (out[0] == 7.0).all() and (out[2] == 7.0).all()
    aim[1, 2] = 1e60
    with pytest.raises(
        ValueError, match=r"s_Ty of the aim = .*: expected a finite number of magnitude up to"
    ):
        joint.update(s, state, aim=aim)
    with pytest.raises(ValueError, match="aim"):
        joint.update(s, state, aim=s[:2])
    traction = np.zeros((3, 3))
    with pytest.raises(ValueError, match=r"out\[0\] overlaps aim"):
        joint.update(s, state, out=(traction, state, out[2]), aim=traction)
    s[2, 0] = np.inf
    with pytest.raises(ValueError, match=r"point 2 \(of 0 to 2\): s_N = ") as raised:
        joint.update(s, state)
    assert "aim" not in str(raised.value)
