"""The package against its contract: names, arrays, threads, restart and warnings."""

from __future__ import annotations

import os
import pickle
import re
from dataclasses import FrozenInstanceError, fields, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from asperity import (
    EquilibriumLost,
    Interface,
    Material,
    Pattern,
    contract,
)
from support_calls import LIBRARY, umat

TABLE_2 = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
RP_4 = Interface(TABLE_2, Pattern.regular(4, 30.0))
FLAT = Interface(TABLE_2, Pattern.regular(0, 0.0))
NAN, INF = float("nan"), float("inf")
RESULTS = ("traction", "state", "tangent")


def random_path(seed: int, rows: int, points: int | None = None) -> np.ndarray:
    """Return separations (rows, 3) or (rows, points, 3), mm, that reach every branch of the law at random."""
    rng = np.random.default_rng(seed)
    shape = (rows, 3) if points is None else (rows, points, 3)
    return np.cumsum(0.03 * rng.standard_normal(shape), axis=0)


# --- names and numbers of the contract ------------------------------------


def test_what_the_material_comes_to() -> None:
    """The derived quantities of a material are correct.

    These are s_f, s_0 and K of (12), and the residual strength up a plane, across its slope, and at locking.
    """
    assert (TABLE_2.s_f, TABLE_2.s_0, TABLE_2.K) == pytest.approx((0.2, 0.02, 150.0), rel=1e-14)
    assert RP_4.update([[0.0, 0.0, 0.0]]).tangent[0, 0, 0] == pytest.approx(TABLE_2.K, rel=1e-14)
    slope = np.tan(np.radians(30.0))
    for theta, sign in ((30.0, 1.0), (-30.0, -1.0)):
        strength = (0.5 + sign * slope) / (1.0 - 0.5 * sign * slope)
        assert TABLE_2.residual_strength(theta) == pytest.approx(strength, rel=1e-14)
    # Across the slope the strength is mu times the pressure on the plane.
    assert TABLE_2.residual_strength(30.0, 90.0) == pytest.approx(0.5 / np.cos(np.radians(30.0)), rel=1e-14)
    almost, beyond = (replace(TABLE_2, mu=share / slope) for share in (1.0 - 1e-9, 1.0 + 1e-9))
    assert almost.residual_strength(30.0) == pytest.approx((1.0 / slope + slope) * 1e9, rel=1e-6)
    assert np.array_equal(beyond.residual_strength([30.0, 29.0]) == np.inf, [True, False])


def test_results_have_their_fields() -> None:
    """The results have the fields and shapes of the contract, also without points or rows."""
    assert RP_4.n_planes == 5 and RP_4.nstatv == 8 + 3 * 5
    for n in (0, 7):
        result = RP_4.update(random_path(1, n), np.zeros((n, 23)), np.zeros((n, 3)))
        assert [getattr(result, name).shape for name in RESULTS] == [(n, 3), (n, 23), (n, 3, 3)]
        assert RP_4.initial(np.zeros((n, 3)), damage=0.5).shape == (n, 23)
        assert all(getattr(result, name).dtype == np.float64 for name in RESULTS)
        assert all(getattr(result, name).flags.c_contiguous for name in RESULTS)
        for history in (RP_4.replay(random_path(1, n)), RP_4.confined_slip(0.0, 0.01 * np.arange(n), 0.0)):
            assert history.separation.shape == history.traction.shape == (n, 3)
            assert history.damage.shape == history.work.shape == (n,) and history.state.shape == (n, 23)
            assert all(0 <= row < n and text for row, text in history.events)
            assert np.array_equal(history.damage, history.state[:, 0])


def test_values_are_frozen_compare_and_hash() -> None:
    """No attribute can be set; equal inputs are equal, in sets and after pickling as well."""
    for value in (TABLE_2, RP_4.pattern, RP_4, RP_4.update([[0, 0, 0]]), RP_4.replay([[0, 0, 0]])):
        for field in fields(value):
            with pytest.raises(FrozenInstanceError):
                setattr(value, field.name, None)
    with pytest.raises(ValueError):
        RP_4._props[0] = 1.0
    listed = Pattern.planes([[1, 0, 0], [1, 1, 0]], [0.5, 0.5])
    assert listed == Pattern.planes(np.array([[1.0, 0, 0], [1, 1, 0]]), (0.5, 0.5))
    assert len({RP_4, Interface(TABLE_2, Pattern.regular(4, 30.0)), Interface(TABLE_2, listed)}) == 2
    again = pickle.loads(pickle.dumps(RP_4))
    assert again == RP_4
    assert np.array_equal(again.replay([[0.1, 0.1, 0]]).traction, RP_4.replay([[0.1, 0.1, 0]]).traction)


def test_props_by_name() -> None:
    """Every named constant has its place in PROPS according to the contract."""
    material = Material(3.0, 0.3, 0.9, 0.5, sigma02=4.0, Gc2=0.5, kc=7.0)
    interface = Interface(material, Pattern.regular(6, 25.0, flat=0.4, turn=10.0))
    names = (row.name for row in contract.props_table())
    values = dict(zip(names, interface.props(h=2.0, map=1, dalpha=0.0, r=0.25), strict=True))
    given = dict(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, theta=25.0, m=6.0, flat=0.4, turn=10.0, h=2.0, map=1.0)
    given |= dict(sigma02=4.0, Gc2=0.5, dalpha=0.0, r=0.25, kc=7.0)
    assert values == {row.name: row.default for row in contract.props_table()} | given
    listed = Interface(TABLE_2, Pattern.planes([[1, 0, 0], [2, 0, 1]], [0.25, 0.75])).props()
    assert listed[contract.index("m")] == -2.0
    assert listed[contract.N_FIXED_PROPS :].tolist() == [1, 0, 0, 0.25, 2, 0, 1, 0.75]


# --- arrays ---------------------------------------------------------------


def arrays(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Arrays for the results of n points, full of what a user may have left in them."""
    return np.full((n, 3), NAN), np.full((n, 23), 1e300), np.full((n, 3, 3), -INF)


@pytest.mark.parametrize("n", [0, 1, 63, 64, 65, 300])
def test_arrays_of_the_caller(n: int) -> None:
    """Results in given arrays, also with the state in place, are those in new arrays to the last bit."""
    path = 0.02 * np.random.default_rng(8).standard_normal((4, n, 3))
    out, state, kept = arrays(n), np.zeros((n, 23)), None
    traction, tangent = arrays(n)[::2]
    for s_old, s in pairwise(path):
        fresh = RP_4.update(s, kept, s_old)
        apart = RP_4.update(s, kept, s_old, out=out)
        in_place = RP_4.update(s, state, s_old, out=(traction, state, tangent))
        for result, given in ((apart, out), (in_place, (traction, state, tangent))):
            for name, array in zip(RESULTS, given, strict=True):
                assert np.array_equal(getattr(result, name), getattr(fresh, name))
                assert np.array_equal(array, getattr(fresh, name))
                assert array.flags.writeable and not getattr(result, name).flags.writeable
        kept = fresh.state


@pytest.mark.parametrize("point", [1, 5])
@pytest.mark.parametrize("in_place", [False, True])
def test_state_untouched_on_error(point: int, in_place: bool) -> None:
    """An update that is rejected at a late point changes neither the state nor any other argument."""
    s, state = random_path(5, 6), RP_4.update(random_path(6, 6)).state.copy()
    s[point, 1] = INF
    copies, given = (s.copy(), state.copy()), arrays(6)
    out = (given[0], state, given[2]) if in_place else None
    message = rf"point {point} \(of 0 to 5\): s_Tx = Inf: expected a finite number"
    with pytest.raises(ValueError, match=message):
        RP_4.update(s, state, out=out)
    assert np.array_equal(s, copies[0]) and np.array_equal(state, copies[1])


S, STATE = np.zeros((4, 3)), np.zeros((4, 23))
T, V, D = np.zeros((4, 3)), np.zeros((4, 23)), np.zeros((4, 3, 3))
READ_ONLY = np.zeros((4, 3))
READ_ONLY.flags.writeable = False
WANTED = ": expected writable float64, contiguous in C order"


@pytest.mark.parametrize(
    ("out", "message"),
    [
        (5, "out = 5: expected traction, state and tangent"),
        ((T, V), "out has 2 entries: expected traction, state and tangent"),
        ((None, V, D), "out[0] is None" + WANTED),
        ((T[:3], V, D), "out[0] has shape (3, 3): expected (4, 3)"),
        ((T, V[:, :22].copy(), D), "out[1] has shape (4, 22): expected (4, 23)"),
        ((T.astype(np.float32), V, D), "out[0] is a float32 array" + WANTED),
        ((T, np.asfortranarray(V), D), "out[1] is a float64 array" + WANTED),
        ((T, V, np.zeros((8, 3, 3))[::2]), "out[2] is a float64 array" + WANTED),
        ((S, V, D), "out[0] overlaps s: expected memory of its own"),
        ((T, STATE[:], D), "out[1] overlaps state: expected memory of its own"),
        ((D.reshape(12, 3)[:4], V, D), "out[2] overlaps out[0]: expected memory of its own"),
    ],
)
def test_unfit_arrays_of_the_caller(out: tuple, message: str) -> None:
    """The error names the array that cannot take a result, and nothing is written."""
    with pytest.raises(ValueError, match=re.escape(message)):
        RP_4.update(S, STATE, out=out)
    assert not any(np.any(array) for array in (S, STATE, T, V, D))


def test_input_of_any_kind() -> None:
    """Lists, single precision, other orders, strides and types of counts give the same results."""
    path = np.round(random_path(2, 6), 3).astype(np.float32)
    expected = RP_4.update(path.astype(float))
    padded = np.zeros((12, 7))
    padded[::2, 1:4] = path
    for s in (path, path.tolist(), np.asfortranarray(path.astype(float)), padded[::2, 1:4]):
        result = RP_4.update(s)
        assert all(np.array_equal(getattr(result, name), getattr(expected, name)) for name in RESULTS)
    backwards = RP_4.update(path[::-1], s_old=np.zeros((6, 3), order="F"), state=np.zeros((6, 23))[::-1])
    assert np.array_equal(backwards.traction[::-1], expected.traction)
    assert np.array_equal(RP_4.replay(path.tolist()).traction, RP_4.replay(path.astype(float)).traction)
    slips = np.linspace(0, 0.1, 11)
    expected = RP_4.confined_slip(0.0, slips, -0.1, preload=20).traction
    for given, preload in ((slips.tolist(), np.int64(20)), (np.repeat(slips, 2)[::2], np.float64(20.0))):
        assert np.array_equal(RP_4.confined_slip(0, given, -0.1, preload=preload).traction, expected)


def test_inputs_are_not_modified() -> None:
    """Input arrays are not changed and do not share memory with results."""
    s, s_old = random_path(3, 5), random_path(4, 5)
    state = RP_4.update(s_old).state
    copies = s.copy(), state.copy(), s_old.copy()
    for array in (s, state, s_old):
        array.flags.writeable = False
    result, history = RP_4.update(s, state, s_old), RP_4.replay(s)
    for array, copy in zip((s, state, s_old), copies, strict=True):
        assert np.array_equal(array, copy)
        outputs = (result.traction, result.state, result.tangent, history.separation, history.state)
        assert not any(np.shares_memory(array, out) for out in outputs)


# --- behaviour ------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_lost_equilibrium() -> None:
    """Equilibrium of the flat plane at sigma_N = +2 ends at s_L = 0.031 mm; the exception has the rows."""
    slips = np.linspace(0.001, 0.05, 50)
    text = "no equilibrium at slip 0.032, sigma_N = 2"
    with pytest.raises(EquilibriumLost, match=rf"row 31 \(of 0 to 49\): {text}") as error:
        FLAT.confined_slip(0.0, slips, 2.0)
    lost = error.value
    assert isinstance(lost, RuntimeError) and lost.row == len(lost.history.damage) == 31
    assert lost.history.events[-1] == (31, text)
    assert np.array_equal(lost.history.separation[:, 1], slips[:31])
    assert np.allclose(lost.history.traction[:, 0], 2.0, rtol=0, atol=1e-12)
    again = pickle.loads(pickle.dumps(lost))
    assert (str(again), again.row) == (str(lost), 31)
    preload = "^no equilibrium in the preload to sigma_N = 4: none found: "
    with pytest.raises(EquilibriumLost, match=preload) as error:
        FLAT.confined_slip(0.0, slips, 4.0)
    assert error.value.row == 0 and error.value.history.traction.shape == (0, 3)


def test_replay_is_a_chain_of_updates() -> None:
    """A replay equals a chain of updates, with the energies, up to the order of the sums over the planes."""
    path = random_path(7, 50)
    history, state, s_old = RP_4.replay(path), None, None
    for row, s in enumerate(path):
        result = RP_4.update(s[None], state, s_old)
        state, s_old = result.state, s[None]
        assert np.allclose(result.traction[0], history.traction[row], rtol=0, atol=1e-12)
        assert np.allclose(result.state[0], history.state[row], rtol=0, atol=1e-12)


def resident_bytes() -> int:
    """Return the memory that this process uses, in bytes."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.long
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs /proc")
def test_memory_does_not_grow() -> None:
    """Many calls do not increase the memory in use; UMAT, rejected calls and short histories are among them.

    ASPERITY_CALLS is the number of calls: 100,000 by default and a million in `make soak`.
    """
    s, state, bad = np.full((1, 3), 0.01), np.zeros((1, RP_4.nstatv)), np.full((1, 3), NAN)
    props = RP_4.props()

    def calls(n: int) -> None:
        for i in range(n):
            RP_4.update(s, state, s)
            if i % 10 == 0:
                umat(LIBRARY, props, s[0], state[0], s[0], s[0])
            if i % 50 == 0:
                RP_4.replay(s)
                RP_4.confined_slip(0.0, [0.001], 0.0, preload=1)
                with pytest.raises(ValueError):
                    RP_4.update(bad)

    calls(50_000)  # until the garbage of rejected calls is collected at times
    before = resident_bytes()
    calls(int(os.environ.get("ASPERITY_CALLS", "100000")))
    # a leak of one double per call would be 0.8 MB or more, one of 128 bytes per rejected call 256 kB
    assert resident_bytes() - before < 256_000
