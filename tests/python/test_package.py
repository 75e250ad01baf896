"""Tests of the package against the contract: names, shapes, errors, threads, restart, and the C API."""

from __future__ import annotations

import ctypes
import math
import os
import pickle
import re
import shutil
import subprocess
import tempfile
import threading
import time
import warnings
from collections.abc import Callable
from dataclasses import FrozenInstanceError, fields, replace
from importlib import metadata
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import asperity
import numpy as np
import pytest
from asperity import (
    EquilibriumLost,
    History,
    Interface,
    Material,
    ModelWarning,
    Pattern,
    Step,
    contract,
    installed,
)

TABLE_2 = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
RP_4 = Interface(TABLE_2, Pattern.regular(4, 30.0))
NAN, INF = float("nan"), float("inf")


def random_path(seed: int, rows: int, points: int | None = None) -> np.ndarray:
    """Return separations (rows, 3) or (rows, points, 3), mm, that reach every branch of the law at random."""
    rng = np.random.default_rng(seed)
    shape = (rows, 3) if points is None else (rows, points, 3)
    return np.cumsum(0.03 * rng.standard_normal(shape), axis=0)


# --- names of the contract ------------------------------------------------


def test_what_the_material_comes_to() -> None:
    """The derived quantities of a material are correct.

    These are s_f, s_0 and K of (12), and the residual strength up a plane, across its slope, and at locking.
    """
    assert (TABLE_2.s_f, TABLE_2.s_0, TABLE_2.K) == pytest.approx((0.2, 0.02, 150.0), rel=1e-14)
    assert RP_4.update([[0.0, 0.0, 0.0]]).tangent[0, 0, 0] == pytest.approx(TABLE_2.K, rel=1e-14)
    slope = np.tan(np.radians(30.0))
    assert TABLE_2.residual_strength(30.0) == pytest.approx((0.5 + slope) / (1.0 - 0.5 * slope), rel=1e-14)
    assert TABLE_2.residual_strength(-30.0) == pytest.approx((0.5 - slope) / (1.0 + 0.5 * slope), rel=1e-14)
    # Across the slope the strength is mu times the pressure on the plane.
    assert TABLE_2.residual_strength(30.0, 90.0) == pytest.approx(0.5 / np.cos(np.radians(30.0)), rel=1e-14)
    almost, beyond = (replace(TABLE_2, mu=share / slope) for share in (1.0 - 1e-9, 1.0 + 1e-9))
    assert almost.residual_strength(30.0) == pytest.approx((1.0 / slope + slope) * 1e9, rel=1e-6)
    assert np.array_equal(beyond.residual_strength([30.0, 29.0]) == np.inf, [True, False])


def test_results_have_their_fields() -> None:
    """The results have the fields and shapes of the contract."""
    result = RP_4.update(random_path(1, 7))
    assert RP_4.n_planes == 5 and RP_4.nstatv == 8 + 3 * 5
    assert (result.traction.shape, result.state.shape, result.tangent.shape) == ((7, 3), (7, 23), (7, 3, 3))
    for history in (RP_4.replay(random_path(1, 7)), RP_4.confined_slip(0.0, [0.1, 0.2], 0.0)):
        rows = len(history.damage)
        assert history.separation.shape == history.traction.shape == (rows, 3)
        assert history.damage.shape == (rows,)
        assert history.state.shape == (rows, 23) and history.work.shape == (rows,)
        assert all(0 <= row < rows and text for row, text in history.events)
        assert np.array_equal(history.damage, history.state[:, 0])
    for name in ("traction", "state", "tangent"):
        array = getattr(result, name)
        assert array.dtype == np.float64 and array.flags.c_contiguous


def test_everything_is_frozen() -> None:
    """No attribute of an input or a result can be set."""
    for thing in (TABLE_2, RP_4.pattern, RP_4, RP_4.update([[0, 0, 0]]), RP_4.replay([[0, 0, 0]])):
        for field in fields(thing):
            with pytest.raises(FrozenInstanceError):
                setattr(thing, field.name, None)
    with pytest.raises(ValueError):
        RP_4._props[0] = 1.0


def test_values_compare_and_hash() -> None:
    """Equal inputs are equal, in sets as well, and survive pickling."""
    listed = Pattern.planes([[1, 0, 0], [1, 1, 0]], [0.5, 0.5])
    assert listed == Pattern.planes(np.array([[1.0, 0, 0], [1, 1, 0]]), (0.5, 0.5))
    assert len({RP_4, Interface(TABLE_2, Pattern.regular(4, 30.0)), Interface(TABLE_2, listed)}) == 2
    again = pickle.loads(pickle.dumps(RP_4))
    assert again == RP_4
    assert np.array_equal(again.replay([[0.1, 0.1, 0]]).traction, RP_4.replay([[0.1, 0.1, 0]]).traction)


def test_typed_and_versioned() -> None:
    """py.typed is installed; package, library and metadata agree on the version."""
    assert (files(asperity) / "py.typed").is_file()
    assert asperity.__version__ == metadata.version("asperity") == contract.library_version()
    assert set(asperity.__all__) <= set(dir(asperity))


# --- the contract's numbers ----------------------------------------------


def test_props_by_name() -> None:
    """Every named constant has its place in PROPS according to the contract."""
    material = Material(3.0, 0.3, 0.9, 0.5, sigma02=4.0, Gc2=0.5, kc=7.0)
    interface = Interface(material, Pattern.regular(6, 25.0, flat=0.4, turn=10.0))
    values = dict(
        zip((row.name for row in contract.props_table()), interface.props(2.0, 1, 0.0, 0.25), strict=True)
    )
    given = dict(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, theta=25.0, m=6.0, flat=0.4, turn=10.0, h=2.0, map=1.0)
    given |= dict(sigma02=4.0, Gc2=0.5, dalpha=0.0, r=0.25, kc=7.0)
    assert values == {row.name: row.default for row in contract.props_table()} | given
    listed = Interface(TABLE_2, Pattern.planes([[1, 0, 0], [2, 0, 1]], [0.25, 0.75])).props()
    assert listed[contract.index("m")] == -2.0
    assert listed[contract.N_FIXED_PROPS :].tolist() == [1, 0, 0, 0.25, 2, 0, 1, 0.75]


def test_tables() -> None:
    """The rows of the tables are numbered from 1; the required constants are the first ones."""
    props, statev = contract.props_table(), contract.statev_table()
    assert [row.index for row in props] == list(range(1, contract.N_FIXED_PROPS + 1))
    assert [row.name for row in props if row.default is None] == ["sigma0", "Gc", "eta", "mu"]
    assert [row.index for row in statev] == list(range(1, 14))
    assert contract.statev_names(2)[-6:] == ("alpha_1", "s_dit_1", "s_dih_1", "alpha_2", "s_dit_2", "s_dih_2")
    assert len(contract.statev_names(2)) == contract.n_statev(2) == 14
    facets = contract.statev_names(2, wears=True)[14:]
    assert facets == ("worn_1", "wear_work_1", "worn_2", "wear_work_2")
    assert contract.n_statev(2, wears=True) == 18
    with pytest.raises(ValueError, match="sigma0 has no default"):
        contract.default("sigma0")


@pytest.mark.parametrize(
    ("pattern", "n_planes"),
    [
        (Pattern.regular(0, 30.0), 1),
        (Pattern.regular(5, 30.0, flat=0.0), 5),
        (Pattern.regular(5, 30.0, flat=1.0), 1),
        (Pattern.regular(5, 30.0), 6),
        (Pattern.regular(64, 30.0), 65),
        (Pattern.planes(np.tile([1.0, 0.1, 0.0], (64, 1)), np.full(64, 1 / 64)), 64),
    ],
)
def test_planes_of_a_pattern(pattern: Pattern, n_planes: int) -> None:
    """A pattern has the Np of the contract, unit normals that point up, and weights that sum to 1."""
    assert Interface(TABLE_2, pattern).n_planes == len(pattern.weights) == len(pattern.normals) == n_planes
    assert np.allclose(np.linalg.norm(pattern.normals, axis=1), 1.0, rtol=0, atol=1e-15)
    assert np.all(pattern.normals[:, 0] > 0)
    assert abs(pattern.weights.sum() - 1.0) < 1e-14


# --- input ----------------------------------------------------------------


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
            shown = (result.traction, result.state, result.tangent)
            for ours, theirs, array in zip(
                shown, (fresh.traction, fresh.state, fresh.tangent), given, strict=True
            ):
                assert np.array_equal(ours, theirs)
                assert np.array_equal(array, theirs)
                assert array.flags.writeable
                assert not ours.flags.writeable
        kept = fresh.state


def test_state_in_place_untouched_on_error() -> None:
    """A rejected update in place leaves the state as it was."""
    state = RP_4.update(random_path(6, 6)).state.copy()
    s, before, out = random_path(5, 6), state.copy(), arrays(6)
    s[5, 1] = INF
    with pytest.raises(ValueError, match=r"point 5 \(of 0 to 5\): s_Tx = Inf: expected a finite number"):
        RP_4.update(s, state, out=(out[0], state, out[2]))
    assert np.array_equal(state, before)


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
        ((T.tolist(), V, D), "out[0] is [[0.0, 0.0, 0.0], [0.0, "),
        ((T[:3], V, D), "out[0] has shape (3, 3): expected (4, 3)"),
        ((T, V[:, :22].copy(), D), "out[1] has shape (4, 22): expected (4, 23)"),
        ((T, V, np.zeros((4, 9))), "out[2] has shape (4, 9): expected (4, 3, 3)"),
        ((T.astype(np.float32), V, D), "out[0] is a float32 array" + WANTED),
        ((T, V.astype(">f8"), D), "out[1] is a >f8 array" + WANTED),
        ((T, np.asfortranarray(V), D), "out[1] is a float64 array" + WANTED),
        ((T, V, np.zeros((8, 3, 3))[::2]), "out[2] is a float64 array" + WANTED),
        ((READ_ONLY, V, D), "out[0] is a float64 array" + WANTED),
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
    """Lists, single precision, other orders and strides give the results of contiguous doubles."""
    path = np.round(random_path(2, 6), 3).astype(np.float32)
    expected = RP_4.update(path.astype(float))
    padded = np.zeros((12, 7))
    padded[::2, 1:4] = path
    for s in (
        path,
        path.tolist(),
        np.asfortranarray(path.astype(float)),
        padded[::2, 1:4],
        padded[:, 1:4][::2],
    ):
        result = RP_4.update(s)
        for name in ("traction", "state", "tangent"):
            assert np.array_equal(getattr(result, name), getattr(expected, name))
    backwards = RP_4.update(path[::-1], s_old=np.zeros((6, 3), order="F"), state=np.zeros((6, 23))[::-1])
    assert np.array_equal(backwards.traction[::-1], expected.traction)
    assert np.array_equal(RP_4.replay(path.tolist()).traction, RP_4.replay(path.astype(float)).traction)
    slips = np.linspace(0, 0.1, 11)
    twice = RP_4.confined_slip(0, np.repeat(slips, 2)[::2], 0)
    assert np.array_equal(RP_4.confined_slip(0, slips.tolist(), 0).traction, twice.traction)


def test_no_points() -> None:
    """Calls without points (n = 0) or without rows (T = 0) succeed."""
    result = RP_4.update(np.empty((0, 3)), np.empty((0, 23)), np.empty((0, 3)))
    assert (result.traction.shape, result.state.shape, result.tangent.shape) == ((0, 3), (0, 23), (0, 3, 3))
    for history in (RP_4.replay(np.empty((0, 3))), RP_4.confined_slip(0.0, [], -1.0)):
        assert (
            history.separation.shape == (0, 3)
            and history.state.shape == (0, 23)
            and history.damage.shape == (0,)
        )


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


@pytest.mark.parametrize("good", [0, 1, 4])
def test_state_untouched_on_error(good: int) -> None:
    """An update that is rejected at a late point changes neither the state nor any other argument."""
    s, state = random_path(5, 6), RP_4.update(random_path(6, 6)).state
    s[good + 1] = NAN
    copies = s.copy(), state.copy()
    with pytest.raises(
        ValueError, match=rf"point {good + 1} \(of 0 to 5\): s_N = NaN: expected a finite number"
    ):
        RP_4.update(s, state)
    assert np.array_equal(s, copies[0], equal_nan=True)
    assert np.array_equal(state, copies[1])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: RP_4.update([0.0, 0.0, 0.0]), r"s has shape \(3,\): expected \(n, 3\)"),
        (lambda: RP_4.update(1.0), r"s has shape \(\): expected \(n, 3\)"),
        (lambda: RP_4.update(np.zeros((2, 4))), r"s has shape \(2, 4\): expected \(n, 3\)"),
        (
            lambda: RP_4.update(np.zeros((2, 3)), np.zeros((2, 22))),
            r"state has shape \(2, 22\): expected \(2, 23\)",
        ),
        (
            lambda: RP_4.update(np.zeros((2, 3)), np.zeros((1, 23))),
            r"state has shape \(1, 23\): expected \(2, 23\)",
        ),
        (lambda: RP_4.update(np.zeros((2, 3)), np.zeros(48)), r"state has shape \(48,\): expected \(2, 23\)"),
        (
            lambda: RP_4.update(np.zeros((2, 3)), s_old=np.zeros((3, 2))),
            r"s_old has shape \(3, 2\): expected \(2, 3\)",
        ),
        (lambda: RP_4.replay(np.zeros((2, 2, 3))), r"S has shape \(2, 2, 3\): expected \(n, 3\)"),
        (lambda: RP_4.confined_slip(0.0, [[0.1]], 0.0), r"slips have shape \(1, 1\): expected \(T,\)"),
        (lambda: Pattern.planes([[1, 0, 0]], [0.5, 0.5]), r"normals have shape \(1, 3\): expected \(2, 3\)"),
        (lambda: Pattern.planes([1, 0, 0], 1.0), r"weights have shape \(\): expected \(k,\)"),
        (
            lambda: Pattern.planes(np.ones((65, 3)), np.full(65, 1 / 65)),
            r"\(65,\): expected \(k,\) with k = 1 to 64",
        ),
        (lambda: Pattern.planes(np.ones((0, 3)), []), r"\(0,\): expected \(k,\) with k = 1 to 64"),
    ],
)
def test_wrong_shapes(call: object, message: str) -> None:
    """The error message names a wrong shape and the expected one."""
    with pytest.raises(ValueError, match=message):
        call()


GOOD = dict(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)


def build(row: contract.Prop, value: float) -> object:
    """The object whose field a constant is."""
    if row.owner == "law":
        return Material(**(GOOD | {row.name: value}))
    if row.owner == "pattern":
        values = {"sides": 4, "theta": 30.0} | {"sides" if row.name == "m" else row.name: value}
        return Pattern.regular(**values)
    return RP_4.props(**{row.name: value})


def bad_values(row: contract.Prop) -> list[float]:
    """Values of a constant outside its range, which stands in tests/law/test_contract.pf, and no value."""
    if row.name == "m":
        return [1.0, 65.0, 2.5, NAN]
    beside = [math.nextafter(row.lower, -INF), math.nextafter(row.upper, INF), NAN, INF]
    return beside + [0.5] * row.integral


@pytest.mark.parametrize(
    ("row", "value"),
    [(row, value) for row in contract.props_table() if row.owner != "reserved" for value in bad_values(row)],
    ids=lambda part: getattr(part, "name", str(part)),
)
def test_every_bad_constant(row: contract.Prop, value: float) -> None:
    """A constant out of range is named as the caller names it, with its value and what was expected."""
    with pytest.raises(ValueError) as error:
        build(row, value)
    lines = str(error.value).splitlines()
    assert len(lines) == 1
    name, admissible = ("sides", "0 or 2 to 64") if row.name == "m" else (row.name, row.admissible)
    assert lines[0].startswith(f"{name} = ")
    assert lines[0].endswith(f": expected {admissible}")
    printed = lines[0].removeprefix(f"{name} = ").split(":")[0]
    assert np.array_equal(float(printed), value, equal_nan=True)


def test_bounds_are_admissible() -> None:
    """Values at the closed ends of the ranges are accepted."""
    Interface(Material(3.0, 0.3, 0.9, mu=0.0, kc=0.0), Pattern.regular(64, 0.0, flat=1.0, turn=-1e4)).props(
        0, 1, 0, 1
    )
    Pattern.regular(2, np.nextafter(90.0, 0.0), flat=0.0)
    Material(3.0, 0.3, 0.9, 0.5, sigma02=1e50)


def test_all_bad_values_at_once() -> None:
    """One error names all bad values."""
    with pytest.raises(ValueError) as error:
        Material(sigma0=-3.0, Gc=NAN, eta=2.0, mu=-1.0, sigma02=-1.0, tau_v=-5.0)
    starts = [
        "sigma0",
        "Gc",
        "eta",
        "mu",
        "sigma02",
        "tau_v",
    ]
    assert [line.split(" = ")[0] for line in str(error.value).splitlines()] == starts


@pytest.mark.parametrize(
    ("normals", "weights", "message"),
    [
        ([[0, 1, 0], [1, 0, 0]], [0.5, 0.5], r"n_N of listed plane 1 = 0: expected > 0"),
        ([[1, 0, 0], [-1, 0, 0]], [0.5, 0.5], r"n_N of listed plane 2 = -1: expected > 0"),
        ([[1, NAN, 0], [1, 0, 0]], [0.5, 0.5], r"n_Tx of listed plane 1 = NaN: expected finite"),
        (
            [[1, 0, 0], [1, 0, INF]],
            [0.5, 0.5],
            r"n_Ty of listed plane 2 = Inf.*: expected finite",
        ),
        ([[1, 0, 0], [1, 0, 0]], [1.0, 0.0], r"gamma of listed plane 2 = 0: expected > 0"),
        (
            [[1, 0, 0], [1, 0, 0]],
            [0.5, 0.4],
            r"weights gamma of the listed planes sum to 0.9: expected 1 within",
        ),
    ],
)
def test_bad_planes(normals: list[list[float]], weights: list[float], message: str) -> None:
    """The message names an inadmissible listed plane."""
    with pytest.raises(ValueError, match=message):
        Pattern.planes(normals, weights)


def test_bad_patterns() -> None:
    """Patterns that are neither regular nor a list of planes are rejected."""
    with pytest.raises(ValueError, match="sides = -2: expected 0 or 2 to 64"):
        Pattern.regular(-2, 30.0)
    with pytest.raises(ValueError, match="m = -2: expected 0 for 0 listed planes"):
        Pattern(-2)


@pytest.mark.parametrize("value", [NAN, INF, -INF, 1e80])
@pytest.mark.parametrize(("component", "name"), [(0, "s_N"), (1, "s_Tx"), (2, "s_Ty")])
def test_separations_that_are_not_finite(component: int, name: str, value: float) -> None:
    """NaN, infinities and separations out of range in s, s_old and S are rejected with their names."""
    s = np.zeros((3, 3))
    s[1, component] = value
    with pytest.raises(ValueError, match=rf"^point 1 \(of 0 to 2\): {name} = .*: expected a finite number"):
        RP_4.update(s)
    with pytest.raises(ValueError, match=rf"^point 1 \(of 0 to 2\): {name} at the start = "):
        RP_4.update(np.zeros((3, 3)), s_old=s)
    with pytest.raises(ValueError, match=rf"^row 1 \(of 0 to 2\): {name} = "):
        RP_4.replay(s)


@pytest.mark.parametrize(
    ("index", "value", "name"),
    [(1, NAN, "stored"), (6, INF, "offset_Tx"), (8, -0.1, "alpha"), (11, 1.1, "alpha"), (12, NAN, "s_dit")],
)
def test_bad_states(index: int, value: float, name: str) -> None:
    """A state that no update can return is rejected with index (from 1, as in the hosts) and name."""
    state = np.zeros((2, 23))
    state[1, index] = value
    with pytest.raises(ValueError, match=rf"^point 1 \(of 0 to 1\): STATEV\({index + 1}\) {name} = "):
        RP_4.update(np.zeros((2, 3)), state)


def test_bad_confined_slip() -> None:
    """One error names every bad argument."""
    with pytest.raises(ValueError) as error:
        RP_4.confined_slip(NAN, [0.0, INF, 0.1], -INF, preload=0)
    starts = ("sigma_N = -Inf", "preload = 0: ", "slips[1] = Inf", "direction = NaN: ")
    for line, start in zip(str(error.value).splitlines(), starts, strict=True):
        assert line.startswith(start) and ": expected " in line


HUGE = 10**400
"""Integers beyond the range of doubles, and beyond the number of digits that Python prints."""


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Material(HUGE, 0.3, 0.9, 0.5), r"sigma0 = 1000+\.\.\.0+: expected > 0"),
        (lambda: Material(3.0, 0.3, 0.9, 10**5000), r"mu = an integer of 16610 bits: expected >= 0"),
        (lambda: Material(3.0, 0.3, "much", 0.5), r"eta = 'much': expected 0 < eta < 1"),
        (lambda: Material(3.0, None, 0.9, 0.5), r"Gc = None: expected > 0"),
        (lambda: Pattern.regular(HUGE, 30.0), r"sides = 1000+\.\.\.0+: expected 0 or 2 to 64"),
        (lambda: Pattern.regular(-HUGE, 30.0), r"sides = -1000+\.\.\.0+: expected 0 or 2 to 64"),
        (lambda: Pattern.regular("4", 30.0), r"sides = '4': expected 0 or 2 to 64"),
        (lambda: Pattern.regular(4, HUGE), r"theta = 1000+\.\.\.0+: expected 0 <= theta < 90"),
        (lambda: Pattern.regular(4, 30.0, turn=-HUGE), r"turn = -1000+\.\.\.0+: expected any"),
        (lambda: Pattern(HUGE), r"m = 1000+\.\.\.0+: expected"),
        (lambda: Pattern.planes([[HUGE, 0, 0]], [1.0]), r"normals\[0, 0\] = 10+\.\.\.0+: expected a"),
        (lambda: Pattern.planes([[1, 0, 0]], [HUGE]), r"weights\[0\] = 1000+\.\.\.0+: expected a finite"),
        (lambda: RP_4.props(h=HUGE), r"h = 1000+\.\.\.0+: expected"),
        (lambda: RP_4.props(map=HUGE), r"map = 1000+\.\.\.0+: expected 0"),
        (lambda: RP_4.card("abaqus", r=HUGE), r"r = 1000+\.\.\.0+: expected 0 <= r <= 1"),
        (lambda: RP_4.update([[0, -HUGE, 0]]), r"s\[0, 1\] = -1000+\.\.\.0+: expected a finite number"),
        (lambda: RP_4.update([[0, 0, 0]], s_old=[["x", 0, 0]]), r"s_old\[0, 0\] = 'x': expected a finite"),
        (lambda: RP_4.update([[0, 0], [0, 0, 0]]), r"s.*: .*expected numbers|s\[.*expected a finite number"),
        (lambda: RP_4.replay([[0, 0, HUGE]]), r"S\[0, 2\] = 1000+\.\.\.0+: expected a finite number"),
        (lambda: RP_4.confined_slip(HUGE, [0.1], 0.0), r"direction = 10+\.\.\.0+: expected a finite"),
        (lambda: RP_4.confined_slip(0.0, [0, HUGE], 0.0), r"slips\[1\] = 10+\.\.\.0+: expected a finite"),
        (lambda: RP_4.confined_slip(0.0, [0.1], HUGE), r"sigma_N = 10+\.\.\.0+: expected a finite"),
        *(
            (
                lambda preload=preload: RP_4.confined_slip(0.0, [0.1], 0.0, preload=preload),
                r"preload = .+: expected a whole number from 1",
            )
            for preload in (2**40, 2**31, HUGE, 2.5, NAN, INF, "x", None, 0)
        ),
    ],
)  # fmt: skip
def test_values_that_are_no_numbers_of_the_library(call: Callable[[], object], message: str) -> None:
    """Too large integers, texts and None raise a ValueError with name, value and expected value."""
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_counts_of_other_types() -> None:
    """NumPy integers and floats with an integer value are accepted as counts."""
    expected = RP_4.confined_slip(0.0, [0.1], -1.0, preload=20).traction
    for preload in (np.int64(20), np.float64(20.0), 20.0):
        assert np.array_equal(RP_4.confined_slip(0.0, [0.1], -1.0, preload=preload).traction, expected)


def test_long_messages_are_whole() -> None:
    """Every bad value of a state of 65 planes and of 64 listed planes is reported."""
    wide = Interface(TABLE_2, Pattern.regular(64, 30.0))
    state = np.full((1, wide.nstatv), NAN)
    with pytest.raises(ValueError, match=r"STATEV\(1\) damage = NaN") as caught:
        wide.update(np.zeros((1, 3)), state)
    text = str(caught.value)
    assert all(f"STATEV({i}) " in text for i in range(1, wide.nstatv + 1)) and not text.endswith("...")
    with pytest.raises(ValueError, match="n_N of listed plane 1 = NaN") as caught:
        Pattern.planes(np.full((64, 3), NAN), np.full(64, NAN))
    text = str(caught.value)
    wanted = [
        f"{name} of listed plane {k} = NaN" for name in ("n_N", "n_Tx", "n_Ty", "gamma") for k in range(1, 65)
    ]
    assert all(one in text for one in wanted) and not text.endswith("...")


# --- behaviour ------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_lost_equilibrium() -> None:
    """Equilibrium of the flat plane at sigma_N = +2 ends at s_L = 0.031 mm.

    The exception has the rows before this loss.
    """
    flat = Interface(TABLE_2, Pattern.regular(0, 0.0))
    slips = np.linspace(0.001, 0.05, 50)
    with pytest.raises(
        EquilibriumLost, match=r"row 31 \(of 0 to 49\): no equilibrium at slip 0.032, sigma_N = 2"
    ) as error:
        flat.confined_slip(0.0, slips, 2.0)
    lost = error.value
    assert isinstance(lost, RuntimeError)
    assert lost.row == len(lost.history.damage) == 31
    assert lost.history.events[-1] == (31, "no equilibrium at slip 0.032, sigma_N = 2")
    with pytest.raises(
        EquilibriumLost,
        match=r"^no equilibrium in the preload to sigma_N = 4: no equilibrium exists: the joint carries at",
    ):
        flat.confined_slip(0.0, slips, 4.0)
    assert np.array_equal(lost.history.separation[:, 1], slips[:31])
    assert np.allclose(lost.history.traction[:, 0], 2.0, rtol=0, atol=1e-12)
    again = pickle.loads(pickle.dumps(lost))
    assert (str(again), again.row) == (str(lost), 31)
    with pytest.raises(EquilibriumLost) as error:
        flat.confined_slip(0.0, slips, 3.1)
    assert error.value.row == 0 and error.value.history.traction.shape == (0, 3)


def test_warnings() -> None:
    """Different mode II values and a contact as soft as the bond give a warning, once for each run."""
    flat = Pattern.regular(0, 0.0)
    for other in ({"sigma02": 2.0}, {"Gc2": 0.4}):
        with pytest.warns(ModelWarning, match="sigma02 or Gc2 differ from mode I") as caught:
            Interface(Material(3.0, 0.3, 0.9, 0.5, **other), flat).run(Step(s_N=0.01, increments=5))
        assert len(caught) == 1
    # |sigma_N| (1 - eta)/(gamma sigma0 kc), gamma of one inclined plane
    for sides, gamma in ((2, 1 / 3), (4, 1 / 6)):
        with pytest.warns(ModelWarning, match=f"by {10 * 0.1 / (gamma * 3):g} s_f"):
            Interface(TABLE_2, Pattern.regular(sides, 30.0)).confined_slip(45.0, [0.0], -10.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Interface(Material(3.0, 0.3, 0.9, 0.5, sigma02=3.0, Gc2=0.3), flat).confined_slip(0.0, [0.0], -1.0)
        RP_4.confined_slip(0.0, [0.0], -0.4)
        RP_4.confined_slip(0.0, [0.0], 0.5)
        Interface(TABLE_2, Pattern.regular(0, 0.0)).confined_slip(0.0, [0.0], -20.0)
        Interface(Material(3.0, 0.3, 0.9, 0.5, kc=1000.0), RP_4.pattern).confined_slip(0.0, [0.0], -10.0)


def test_replay_is_a_chain_of_updates() -> None:
    """A replay equals a chain of updates, with the energies, up to the order of the sums over the planes."""
    path = random_path(7, 50)
    history, state, s_old = RP_4.replay(path), None, None
    for row, s in enumerate(path):
        result = RP_4.update(s[None], state, s_old)
        state, s_old = result.state, s[None]
        assert np.allclose(result.traction[0], history.traction[row], rtol=0, atol=1e-12)
        assert np.allclose(result.state[0], history.state[row], rtol=0, atol=1e-12)


def test_confined_slip_is_on_the_law() -> None:
    """The rows of a test at sigma_N = 0 equal a replay of its separations; each row is one increment.

    The solver sums the planes in another order than the blocks of a replay.  The results therefore differ by
    some units in the last place.
    """
    history = RP_4.confined_slip(20.0, np.linspace(0.001, 0.2, 200), 0.0, preload=1)
    replayed = RP_4.replay(history.separation)
    scale = 150.0 * np.abs(history.separation).max()  # K |s|, stress
    assert np.allclose(replayed.traction, history.traction, rtol=0, atol=1e-14 * scale)
    assert np.allclose(replayed.state, history.state, rtol=1e-13, atol=1e-14)


def test_restart(tmp_path: Path) -> None:
    """A replay from a saved state continues bit for bit."""
    path = random_path(8, 40, points=20)
    state, s_old = np.zeros((20, RP_4.nstatv)), np.zeros((20, 3))
    for s in path[:25]:
        state, s_old = RP_4.update(s, state, s_old).state, s
    np.savez(tmp_path / "saved.npz", state=state, s_old=s_old)
    straight = [state := RP_4.update(s, state, old).state for old, s in pairwise(path[24:])]
    saved = np.load(tmp_path / "saved.npz")
    state, s_old = saved["state"], saved["s_old"]
    again = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(4, 30.0))
    for s, expected in zip(path[25:], straight, strict=True):
        state, s_old = again.update(s, state, s_old).state, s
        assert np.array_equal(state, expected)


@pytest.mark.slow
def test_interpreter_goes_on() -> None:
    """The library releases the lock of the interpreter, so that another thread runs during a call."""
    wide = Interface(TABLE_2, Pattern.regular(64, 30.0))
    path = random_path(9, 100_000)
    times: list[float] = []
    worker = threading.Thread(
        target=lambda: times.extend([time.perf_counter(), wide.replay(path) and time.perf_counter()])
    )
    worker.start()
    ticks = []
    while worker.is_alive():
        ticks.append(time.perf_counter())
        time.sleep(0.001)
    start, end = times
    inside = [tick for tick in ticks if start < tick < end]
    assert end - start > 0.05
    assert max(np.diff([start, *inside, end])) < 0.5 * (end - start)


def resident_bytes() -> int:
    """Return the memory that this process uses, in bytes."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.long
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs /proc")
def test_memory_does_not_grow() -> None:
    """Many calls do not increase the memory in use; rejected calls and short histories are among them.

    ASPERITY_CALLS is the number of calls: 100,000 by default and a million in `make soak`.
    """
    s, state, bad = np.full((1, 3), 0.01), np.zeros((1, RP_4.nstatv)), np.full((1, 3), NAN)
    slips = [0.001]

    def calls(n: int) -> None:
        for i in range(n):
            RP_4.update(s, state, s)
            if i % 50 == 0:
                RP_4.replay(s)
                RP_4.confined_slip(0.0, slips, 0.0, preload=1)
                with pytest.raises(ValueError):
                    RP_4.update(bad)

    calls(10_000)
    before = resident_bytes()
    calls(int(os.environ.get("ASPERITY_CALLS", "100000")))
    # a leak of one double per call would be 0.8 MB or more, one of 128 bytes per rejected call 256 kB
    assert resident_bytes() - before < 256_000


# --- C API of the shared library -----------------------------------------

OK, BAD_PROPS, FEW_PROPS, FEW_STATEV, BAD_SEPARATION, BAD_STATE, BAD_SIZE = 0, 1, 2, 3, 5, 6, 7
"""Status codes of asperity.h."""


@pytest.fixture(scope="module")
def library() -> ctypes.CDLL:
    """Load the shared library that is installed with the package."""
    return ctypes.CDLL(str(asperity.library()))


def pointer(array: np.ndarray | None) -> ctypes.c_void_p:
    """Return the address of an array, or NULL for None."""
    return ctypes.c_void_p(None if array is None else array.ctypes.data)


def c_update(
    library: ctypes.CDLL,
    props: np.ndarray,
    s: np.ndarray,
    state: np.ndarray,
    size: int = 200,
    **optional: np.ndarray,
) -> tuple[int, np.ndarray, str]:
    """Return status, traction and message of asperity_update; the state is changed in place."""
    traction = np.full((len(s), 3), 77.0)
    message = ctypes.create_string_buffer(b"#" * 199, 200)
    n, s_old, tangent = optional.get("n", len(s)), optional.get("s_old"), optional.get("tangent")
    status = library.asperity_update(
        pointer(props), len(props), ctypes.c_double(0.0), n, pointer(s_old), pointer(s), state.shape[1],
        pointer(state), pointer(traction), pointer(tangent), message, size,
    )  # fmt: skip
    return status, traction, message.value.decode()


def test_library_has_the_symbols(library: ctypes.CDLL) -> None:
    """The library exports the C API and the UMAT; its version is that of the package."""
    for symbol in ("asperity_update", "asperity_nstatv", "asperity_version", "umat_"):
        assert hasattr(library, symbol)
    text = ctypes.create_string_buffer(16)
    assert library.asperity_version(text, 16) == len(asperity.__version__)
    assert text.value.decode() == asperity.__version__


def test_c_update_is_the_package(library: ctypes.CDLL) -> None:
    """The C function gives the traction, state and tangent of the package bit for bit.

    This applies with and without the optional arguments.
    """
    s_old, s = random_path(10, 30), random_path(11, 30)
    start = RP_4.update(s_old).state
    expected = RP_4.update(s, start, s_old)
    state, tangent = start.copy(), np.full((30, 3, 3), 77.0)
    status, traction, message = c_update(library, RP_4.props(), s, state, s_old=s_old, tangent=tangent)
    assert (status, message) == (OK, "")
    assert np.array_equal(traction, expected.traction)
    assert np.array_equal(state, expected.state)
    assert np.array_equal(tangent, expected.tangent)
    state = start.copy()
    status, traction, _ = c_update(library, RP_4.props(), s, state)
    assert status == OK
    assert np.array_equal(traction, expected.traction)
    assert np.array_equal(state, RP_4.update(s, start).state)


def test_history_is_a_plain_record() -> None:
    """A history can be constructed from arrays; its arrays are read-only."""
    rows = np.zeros((1, 3))
    history = History(rows, rows, rows[:, 0], rows, rows[:, 0])
    assert history.events == ()
    for array in (history.separation, history.traction, history.damage, history.state, history.work):
        with pytest.raises(ValueError):
            array[0] = 1.0


def test_snaps_are_told() -> None:
    """RP-16 without normal traction has one snap, at the same place for all steps; RP-12 has none."""
    for steps in (20, 400):
        slips = np.linspace(0.0, 0.2, steps + 1)
        for sides in (12, 16):
            rough = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(sides, 30.0))
            history = rough.confined_slip(0.0, slips, 0.0)
            rows = [row for row, text in history.events if "snap" in text]
            assert rows == [snap.row for snap in history.snaps]
            if sides == 12:
                assert not rows
                continue
            (snap,) = history.snaps
            assert slips[snap.row - 1] < snap.before[1] <= slips[snap.row]
            assert snap.before == pytest.approx((0.0926, 0.1736, 0.0), abs=2e-4)
            assert snap.after == pytest.approx((0.1002, 0.1736, 0.0), abs=1e-4)
            assert snap.released == pytest.approx(9.75e-6, rel=0.01)
            assert "substeps" in dict(history.events)[snap.row]


def test_events_are_those_of_the_driver() -> None:
    """The events of a replay equal the event column of the driver for the same separations."""
    case = "&material sigma0=3, Gc=0.3, eta=0.9, mu=0.5 /\n&pattern sides=4, theta=30 /\n"
    case += "&step t_N=-1, increments=20 /\n"
    case += "&step slip=0.3,-0.3,0.0, direction=20, increments=60 /\n"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "case.nml")
        path.write_text(case)
        output = Path(folder, "case.csv")
        assert subprocess.run([installed.driver(), path, "-o", output], capture_output=True).returncode == 0
        rows = History.from_csv(output)
    history = RP_4.replay(rows.separation)
    expected = [
        (row, "+".join(name for name in text.split("+") if name not in ("substeps", "cut")))
        for row, text in rows.events
    ]
    assert history.events == tuple((row, text) for row, text in expected if text)
    assert {"onset", "damaged", "slip", "open", "close"} <= {
        name for _, text in history.events for name in text.split("+")
    }


PROGRAM = """#include <asperity.h>
#include <stdio.h>
int main(void) {
  char text[16];
  return asperity_version(text, sizeof text) > 0 && puts(text) >= 0 ? 0 : 1;
}
"""


def test_link_against_the_library(tmp_path: Path) -> None:
    """A C program linked against asperity.library() finds it at run time by the path given to the linker."""
    compiler = shutil.which("cc")
    assert compiler is not None
    (tmp_path / "program.c").write_text(PROGRAM)
    path = asperity.library()
    command = [compiler, "program.c", f"-I{path.parent}", path, f"-Wl,-rpath,{path.parent}", "-o", "program"]
    subprocess.run(command, cwd=tmp_path, check=True)
    environment = {k: v for k, v in os.environ.items() if k != "LD_LIBRARY_PATH"}
    done = subprocess.run([tmp_path / "program"], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout == asperity.__version__ + "\n"


@pytest.mark.parametrize(
    ("mu", "theta", "sigma_N", "message"),
    [
        (0.5, 64.0, -0.001, r"mu tan\(theta\) = 1.02515 of the steepest plane: expected < 1"),
        (0.5, 0.5236, -0.001, r"theta = 0.5236 degrees is nearly flat: expected degrees, not radians"),
        (0.5, 30.0, -10.0, "a plane that carries the largest pressure alone closes by 2 s_f"),
    ],
)
def test_doubts_are_warnings(mu: float, theta: float, sigma_N: float, message: str) -> None:
    """A slip test warns of what the law does and one may not expect."""
    joint = Interface(Material(3.0, 0.3, 0.9, mu), Pattern.regular(4, theta))
    with pytest.warns(ModelWarning, match=message):
        joint.confined_slip(0.0, [0.001], sigma_N)


def test_tension_above_the_strength() -> None:
    """A tension above the strength gives a warning; a plane of finite height does not."""
    flat = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0))
    with (
        pytest.warns(ModelWarning, match="the normal traction reaches 1.03333 times the strength"),
        pytest.raises(EquilibriumLost),
    ):
        flat.confined_slip(0.0, [0.1], 3.1)
    steep = Interface(Material(3.0, 0.3, 0.9, 0.8, height=0.5, kc=100.0), Pattern.regular(4, 64.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        steep.confined_slip(0.0, [0.001], -0.001)
