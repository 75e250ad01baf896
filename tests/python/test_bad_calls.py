"""Calls of UMAT, VUMATs and C API with one argument that is not admissible: rejected, and named."""

from __future__ import annotations

import re
from enum import IntEnum
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.contract import N_PLANE_STATEV, N_POINT_STATEV, props_table
from support_calls import ADAPTERS, SIGNALLING, Call, Routine, call_c, call_umat, call_vumat, errors, judge

# CTest has no markers, and pytest need not repeat it
pytestmark = pytest.mark.long


def virgin(routine: Routine, kind: type, components: int, points: int = 3, W0: float = 0.0) -> Call:
    """Call of virgin points of RP-4 with a small increment."""
    interface = Interface(Material(3.0, 0.3, 0.9, 0.5, kc=2.0, W0=W0), Pattern.regular(4, 30.0, turn=10.0))
    n = 1 if routine is call_umat else points
    strain, increment, stress = np.zeros((3, n, components))
    increment[:] = 1.0e-3
    density, energies = np.full(n, 2.5e-9, dtype=kind), np.zeros((n, 2))
    state, times = np.zeros((n, interface.nstatv)), (1.0, 0.1)
    props = interface.props().astype(kind)
    return Call(props, strain, increment, stress, state, times, energies, density, 5, {})


HEADER = Path(__file__).parents[2] / "src" / "asperity.h"

CODES = re.findall(r"ASPERITY_(\w+) = (\d+)", HEADER.read_text(encoding="utf-8"))
Status = IntEnum("Status", [(name, int(code)) for name, code in CODES])
"""Status codes of asperity.h."""


def rejected(call: Call, routine: Routine, status: int, *texts: str, probe: bool = True) -> None:
    """A call is rejected as documented, with a message that has these texts; VUMAT's elastic probe, too."""
    for total in (1.0, 0.0) if routine is call_vumat and probe else (1.0,):
        call.times = (total, call.times[1])
        with errors() as said, np.errstate(all="ignore"):
            out = routine(np.random.default_rng(1), call)
            out.message = out.message or said()
        assert judge(routine, call, out, True, False)
        assert routine is not call_c or out.status == status
        for text in texts:
            assert text in out.message
        if routine is call_umat:
            assert out.pnewdt[0] == 0.25


def components(routine: Routine) -> tuple[int, ...]:
    """Numbers of components that a host may have."""
    return {call_umat: (2, 3, 6), call_vumat: (2, 3), call_c: (3,)}[routine]


@ADAPTERS
def test_bad_props(routine: Routine, kind: type) -> None:
    """Each constant below and above its range, not a number or, where it must be whole, a fraction."""
    for row in props_table():
        bad = [np.nan, SIGNALLING, np.inf]
        if row.scale == "whole":
            bad += [-np.inf, 0.5]
        if row.lower >= 0.0:
            bad.append(-0.01)
        if 0.0 < row.lower or 0.9 < row.upper < 1.0:
            bad.append(0.0 if 0.0 < row.lower else 1.0)
        if row.upper < 1.0e20:
            bad.append(max(1.0, float(np.ceil(row.upper * 1.01))))
        for value in bad:
            call = virgin(routine, kind, 3)
            call.props[row.index - 1] = value
            rejected(call, routine, Status.BAD_PROPS, f"PROPS({row.index}) {row.name} = ")
    for n in range(4):
        call = virgin(routine, kind, 3)
        call.props = call.props[:n].copy()
        rejected(call, routine, Status.FEW_PROPS, f"{n}: expected at least 4")
    call = virgin(routine, kind, 3)
    call.props = np.array([-1.0], dtype=kind)
    rejected(call, routine, Status.BAD_PROPS, "sigma0 = -1")


@ADAPTERS
def test_bad_sizes(routine: Routine, kind: type) -> None:
    """Too few state variables, and components that no host has; one more state variable stays as it is."""
    for n in (0, 22):
        call = virgin(routine, kind, 3)
        call.state = np.zeros((len(call.state), n))
        rejected(call, routine, Status.FEW_STATEV, f"{n}: expected at least 23")
    if routine is call_umat:
        for n in (1, 4, 5, 7):
            rejected(virgin(routine, kind, n), routine, Status.BAD_NTENS, f"NTENS = {n}: expected 2, 3 or 6")
    elif routine is call_vumat:
        for ndir, nshr in ((3, 3), (3, 1), (2, 1), (1, 0), (1, 3), (0, 2)):
            call = virgin(routine, kind, ndir + nshr)
            call.optional = {"ndir": ndir}
            rejected(
                call, routine, Status.BAD_NTENS, f"ndir, nshr = {ndir}, {nshr}: expected 1, 2 or (2D) 1, 1"
            )
    call = virgin(routine, kind, 3)
    call.state = np.zeros((len(call.state), 24))
    call.state[:, 23] = 0.25
    with errors():
        out = routine(np.random.default_rng(1), call)
    assert np.isfinite(out.stress).all() and (out.state == 0.25).sum() == len(call.state)


@ADAPTERS
def test_bad_strains(routine: Routine, kind: type) -> None:
    """One increment that is not finite or too large, of any component, at any point of a block."""
    for n in components(routine):
        for point in (0, 63, 64, 99) if routine is not call_umat else (0,):
            for value in (np.nan, SIGNALLING, np.inf, -np.inf, 1.0e200):
                for i in range(n):
                    call = virgin(routine, kind, n, 100)
                    call.increment[point, i] = value
                    rejected(
                        call, routine, Status.BAD_SEPARATION, "expected a finite number of magnitude up to "
                    )
                    if routine is call_umat:
                        call.increment, call.strain = call.strain, call.increment
                        rejected(call, routine, Status.BAD_SEPARATION, f"STRAN({i + 1}) = ")


@ADAPTERS
def test_bad_states(routine: Routine, kind: type) -> None:
    """A state variable that is not finite, a slip that is too large, a damage or a wear outside 0 to 1."""
    points = [0] if routine is call_umat else range(64, 70)  # several are tested together
    for i, bad in ((23, (-1.0e-3, 1.5, np.inf)), (32, (-1.0e-3, np.nan))):
        for value in bad:
            call = virgin(routine, kind, 3, 70, W0=0.2)
            call.state[points[i % len(points)], i] = value
            rejected(call, routine, Status.BAD_STATE, f"STATEV({i + 1}) ")
    for i in range(23):
        damage = i >= N_POINT_STATEV and (i - N_POINT_STATEV) % N_PLANE_STATEV == 0
        bad = (-1.0e-3, 1.001, float(np.nextafter(kind(0.0), kind(-1.0)))) if damage else ()
        if i >= 5 and not damage:
            bad = (-1.0e200,)
        for value in (np.nan, SIGNALLING, np.inf, *bad):
            call = virgin(routine, kind, 3, 70)
            call.state[points[i % len(points)], i] = value
            rejected(call, routine, Status.BAD_STATE, f"STATEV({i + 1}) ", ": expected a finite number")


@ADAPTERS
def test_bad_times(routine: Routine, kind: type) -> None:
    """With viscous damage a time increment has to be finite and not negative; without it changes no bit."""
    for value in (np.nan, SIGNALLING, np.inf, -1.0):
        call = virgin(routine, kind, 3)
        expected = routine(np.random.default_rng(1), call)
        call.times = (1.0, value)
        result = routine(np.random.default_rng(1), call)
        assert np.isfinite(result.stress).all() and result.stress.tobytes() == expected.stress.tobytes()
        assert result.state.tobytes() == expected.state.tobytes()
        call.props[12], call.times = 0.5, (1.0, value)
        rejected(call, routine, Status.BAD_TIME, "expected a finite time increment", probe=False)
    if routine is call_umat:
        call.optional["dtime"] = None
        rejected(call, routine, Status.BAD_TIME, "DTIME is missing: expected a finite time increment")


@ADAPTERS
def test_negative_sizes(routine: Routine, kind: type) -> None:
    """A negative size is named as it was passed; an array of that size is empty."""
    state = {call_umat: "NSTATV", call_vumat: "nstatev", call_c: "NSTATV"}[routine]
    for name, size, text, status in (
        ("nprops", -2, "NPROPS = -2: expected at least 4", Status.FEW_PROPS),
        ("nstatv", -5, f"{state} = -5: expected at least 23", Status.FEW_STATEV),
        ("n", -7, "n = -7" if routine is call_c else " = -7 points: expected 0 or more", Status.BAD_SIZE),
    ):
        if (routine, name) != (call_umat, "n"):
            call = virgin(routine, kind, 3)
            call.optional = {name: size}
            with errors() as said:
                out = routine(np.random.default_rng(1), call)
                assert text in (out.message or said())
            assert routine is not call_c or (out.status == status and out.whole)


@pytest.mark.parametrize("routine", [call_umat, call_vumat])
def test_every_bad_value_is_named(routine: Routine) -> None:
    """All bad values are named, with the point of a block; good ones are not."""
    call = virgin(routine, float, 3, 70)
    call.increment[-1, 1:] = np.nan, -np.inf
    name = "DSTRAN" if routine is call_umat else "point 70 of the block: strainInc"
    rejected(call, routine, Status.BAD_SEPARATION, f"{name}(2) = NaN: expected a finite number", "(3) = -Inf")
    with errors() as said:
        routine(np.random.default_rng(1), call)
        words = said()
        assert "(1)" not in words and "NTENS" not in words
    call = virgin(routine, float, 3)
    call.props[12:14] = -0.5, 1.25
    rejected(call, routine, Status.BAD_PROPS, "PROPS(13) tau_v = -0.5", "PROPS(14) dalpha = 1.25")


def test_negative_separations_are_not_named() -> None:
    """Of a point with a bad separation only that is named, whatever the signs of the others."""
    call = virgin(call_c, float, 3)
    call.strain[:] = -2.0e-3
    call.increment[1, 1] = np.nan
    message = call_c(np.random.default_rng(1), call).message
    assert message.startswith("point 1 (of 0 to 2): s_Tx = NaN: expected") and message.count("expected") == 1


@pytest.mark.parametrize(
    "values",
    [{1: 1.0e25}, {1: 1.0e-25, 16: 1.0e10}, {2: 1.0e25, 16: 1.0e10}, {2: 1.0e-25, 16: 1.0e10},
     {1: 1.0e26, 2: 1.0e34}, {3: 1.0e-39}, {4: 1.0e10, 16: 1.0e10}, {9: 1.0e-40}, {9: 1.0e-25}, {9: 1.0e25},
     {9: 1.0e38},
     {1: 1.0e-20, 2: 1.0e-19, 11: 1.0e-15, 12: 1.0e-19, 16: 1.0e5}],
)  # fmt: skip
def test_range_of_single_precision(values: dict[int, float]) -> None:
    """Constants, strains and separations that only double precision represents are rejected."""
    call = virgin(call_vumat, np.float32, 3)
    for index, value in values.items():
        call.props[index - 1] = value
    rejected(call, call_vumat, Status.BAD_PROPS, "expected other units")
    for array in ("increment", "state"):
        call = virgin(call_vumat, np.float32, 3)
        getattr(call, array)[2, 0 if array == "increment" else 5] = 1.0e20
        rejected(call, call_vumat, Status.BAD_SEPARATION, "expected a finite number of magnitude up to ")
