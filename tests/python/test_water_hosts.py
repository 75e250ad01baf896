"""Water pressure in a joint as hosts pass it: predefined fields of UMAT and VUMAT."""

from __future__ import annotations

import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from support_calls import LIBRARY, errors, umat, vumat

from tests.oracle import reference
from tests.oracle.water import total

# CTest has no markers, and pytest need not repeat it
pytestmark = pytest.mark.long

MATERIAL = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5, "kc": 20.0}
PLANES = 4, 30.0, 1.0 / 3.0, 10.0
ROUGH, WATER = Interface(Material(**MATERIAL), Pattern.regular(*PLANES)), 0.4
FIELDS = np.array([7.0, np.nan, 0.3])
"""Predefined fields of a host; the third is water in these tests."""


def path() -> np.ndarray:
    """Separations (T, 3) that press, slide, turn back and open, length."""
    rng = np.random.default_rng(4)
    steps = np.cumsum(0.01 * rng.standard_normal((30, 3)), axis=0)
    return steps - [0.005, 0.0, 0.0]


def test_total_tractions_of_the_reference() -> None:
    """UMAT and Python give the tractions of the reference less the water, and its states, along a path."""
    parameters, planes = reference.Parameters(**MATERIAL), reference.regular_pattern(*PLANES)
    rng, props = np.random.default_rng(12), ROUGH.props(water=3)
    known, before = np.zeros(ROUGH.nstatv), np.zeros(3)
    hosted, own = known.copy(), known[None]
    # rounding errors of K kc |s| that add up along the path
    near = 1e-12 * ROUGH.material.K * ROUGH.material.kc
    for s in path():
        p = rng.uniform(0.0, 2.0)
        law = reference.update(parameters, planes, s, known, before)
        field = np.array([np.nan, np.nan, 0.25 * p]), np.array([np.nan, np.nan, 0.75 * p])
        out = umat(LIBRARY, props, np.zeros(3), hosted, before, s - before, fields=field)
        python = ROUGH.update(s[None], own, s_old=before[None], p=[p])
        dry = ROUGH.update(s[None], own, s_old=before[None]).state[0]
        for traction, state in ((out.stress, out.state), (python.traction[0], python.state[0])):
            assert traction == pytest.approx(total(law.traction, p), rel=1e-12, abs=near)
            assert state[8:] == pytest.approx(law.state[8:], rel=1e-12, abs=1e-12)
            assert state[:2] == pytest.approx(law.state[:2], rel=1e-12, abs=1e-12)
            # rupture and friction of long increments are not those of the reference
            assert state[2:4] == pytest.approx(dry[2:4], rel=1e-12, abs=1e-12)
        known, hosted, own, before = law.state, out.state.copy(), python.state, s


def test_umat_takes_a_predefined_field() -> None:
    """STRESS is total: with PREDEF + DPRED as the water it is that of the law less the pressure."""
    props, dpred = ROUGH.props(water=3), np.array([np.nan, np.nan, 0.25])
    for order in ([0], [0, 1, 2], [2, 4, 5]):
        ntens = {1: 2, 3: 3}[len(order)] if order != [2, 4, 5] else 6
        state, before = np.zeros(ROUGH.nstatv), np.zeros(ntens)
        dry_state = state.copy()
        for s in path():
            strain = np.zeros(ntens)
            places = order if len(order) == 3 else [0, 1]
            strain[places] = s[: len(places)]
            wet, dry = (
                umat(LIBRARY, values, np.zeros(ntens), start, before, strain - before, fields=(FIELDS, dpred))
                for values, start in ((props, state), (ROUGH.props(), dry_state))
            )
            total = dry.stress.copy()
            total[places[0]] -= FIELDS[2] + dpred[2]
            assert np.array_equal(wet.stress, total) and np.array_equal(wet.tangent, dry.tangent)
            assert np.array_equal(wet.state, dry.state)
            state, dry_state, before = wet.state.copy(), dry.state.copy(), strain


def test_umat_starts_from_a_total_stress() -> None:
    """The initial STRESS and PREDEF make the state that Python makes of a total traction and p."""
    total, none = np.array([-1.0, 0.2, 0.0]), np.zeros(3)
    out = umat(LIBRARY, ROUGH.props(water=1), total, np.zeros(ROUGH.nstatv), none, none,
               fields=(np.array([WATER]), np.zeros(1)))  # fmt: skip
    expected = ROUGH.update(np.zeros((1, 3)), ROUGH.initial(total, p=WATER)[None])
    assert out.state == pytest.approx(expected.state[0], rel=1e-12, abs=1e-15)
    assert out.stress == pytest.approx(total, rel=1e-10)


@pytest.mark.parametrize(
    ("predef", "dpred", "words"),
    [
        (None, None, "PREDEF(1) = NaN"),
        ([np.nan], [0.0], "PREDEF(1) = NaN"),
        ([0.2], [np.inf], "PREDEF(1) = NaN"),
        ([0.25], [-0.375], "PREDEF(1) = -0.125"),
        ([-0.2], None, "PREDEF(1) = -0.2"),
        ([-0.2], [0.5], "PREDEF(1) = -0.2"),
    ],
)
def test_umat_refuses_bad_water(predef: list | None, dpred: list | None, words: str) -> None:
    """A host that passes no field, or one that is no pressure, gets NaN, a message and an unchanged state."""
    state = np.zeros(ROUGH.nstatv)
    fields = tuple(None if values is None else np.array(values) for values in (predef, dpred))
    with errors() as said:
        out = umat(LIBRARY, ROUGH.props(water=1), np.zeros(3), state, *np.zeros((2, 3)), fields=fields)
        text = said()
    assert np.isnan(out.stress).all() and np.array_equal(out.state, state)
    assert words in text and "expected the water pressure" in text


def test_water_may_end_but_for_rounding() -> None:
    """A sum of PREDEF and DPRED that is negative by rounding is no water."""
    predef, dpred = np.array([0.7]), np.array([-np.nextafter(0.7, 1.0)])
    assert predef[0] + dpred[0] < 0.0
    state, none, s = np.zeros(ROUGH.nstatv), np.zeros(3), np.array([-0.001, 0.01, 0.0])
    wet, dry = (
        umat(LIBRARY, ROUGH.props(water=i), none, state, none, s, fields=(predef, dpred)) for i in (1, 0)
    )
    assert np.array_equal(wet.stress, dry.stress)


def test_vumat_starts_points_among_others() -> None:
    """Points whose first call is in the middle of a block give what they give alone, with their water."""
    n = 700
    rng = np.random.default_rng(11)
    fields = rng.uniform(0.0, 0.5, (2, n, 2))
    stress = np.column_stack([rng.uniform(-2.0, -0.6, n), np.zeros(n), rng.uniform(-0.1, 0.1, n)])
    strain, state = 0.002 * rng.standard_normal((n, 3)), np.zeros((n, ROUGH.nstatv))
    state[:, 4] = rng.random(n) < 0.9  # the others are called for the first time
    assert 0.0 < state[:, 4].mean() < 1.0
    density = np.full(n, 2.5e-9)

    def called(rows: slice) -> tuple[np.ndarray, ...]:
        out = vumat(
            LIBRARY, ROUGH.props(water=2), density[rows], (1.0, 0.1), strain[rows], stress[rows], state[rows],
            fields=(fields[0, rows], fields[1, rows]),
        )  # fmt: skip
        return out.stress, out.state, out.energies

    together, alone = called(slice(n)), [called(slice(k, k + 1)) for k in range(n)]
    for whole, parts in zip(together, zip(*alone, strict=True), strict=True):
        assert np.array_equal(whole, np.concatenate(parts))
    # the energy is the work of the total stress: trapezoids of engineering shears, per unit mass
    work = (0.5 * (stress + together[0]) * strain * [1.0, 2.0, 2.0]).sum(axis=1)
    assert together[2][:, 0] * density == pytest.approx(work, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_vumat_takes_a_field(kind: type) -> None:
    """Rows of both precisions are those without water less the pressure of their point."""
    n, rounding = 200, 4.0 * float(np.finfo(kind).eps)
    water = np.linspace(0.0, 1.5, n)
    fields = [np.column_stack([np.full(n, np.nan), value]) for value in (0.5 * water, water)]
    density, none = np.full(n, 2.5e-9, kind), np.zeros((n, 3))
    increment = np.column_stack([np.linspace(-0.002, 0.01, n), np.full(n, 0.01), np.zeros(n)])
    state = np.zeros((n, ROUGH.nstatv))
    state[:, 4] = 1.0  # called before, so that no initial stress is read
    wet, dry = (
        vumat(LIBRARY, values.astype(kind), density, (1.0, 0.1), increment, none, state, fields=fields)
        for values in (ROUGH.props(water=2), ROUGH.props())
    )
    assert np.array_equal(wet.state, dry.state)
    assert np.array_equal(wet.stress[:, 1:], dry.stress[:, 1:])
    assert wet.stress[:, 0] == pytest.approx(dry.stress[:, 0] - water, rel=rounding, abs=2.0 * rounding)
    # the first call of a point: its stress is total
    total, virgin = np.tile([-1.0, 0.0, 0.1], (n, 1)), np.zeros((n, ROUGH.nstatv))
    start = [np.column_stack([np.full(n, np.nan), np.full(n, WATER)])] * 2
    out = vumat(
        LIBRARY, ROUGH.props(water=2).astype(kind), density, (1.0, 0.1), none, total, virgin, fields=start
    )
    assert out.stress == pytest.approx(total, rel=1e3 * rounding, abs=1e3 * rounding)


@pytest.mark.parametrize("kind", [np.float64, np.float32])
@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (-0.25, "field(1) = -0.25"),
        (np.nan, "field(1) = NaN"),
        (np.inf, "field(1) = Inf"),
        (None, "nfieldv = 0"),
    ],
)
def test_vumat_refuses_bad_water(bad: float | None, words: str, kind: type) -> None:
    """A negative or missing pressure in one point of the second chunk is named, and the state stays."""
    n = 600
    water = np.zeros((n, 1))
    if bad is not None:
        water[431] = bad
    fields = None if bad is None else (np.zeros((n, 1)), water)
    density, none, state = np.full(n, 2.5e-9, kind), np.zeros((n, 3)), np.zeros((n, ROUGH.nstatv))
    with errors() as said:
        out = vumat(
            LIBRARY, ROUGH.props(water=1).astype(kind), density, (1.0, 0.1), none, none, state, fields=fields
        )
        text = said()
    assert np.isnan(out.stress).all() and np.array_equal(out.state, state)
    assert words in text and "expected" in text
    assert bad is None or "point 432 of the block" in text
