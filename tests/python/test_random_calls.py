"""Random calls of UMAT, VUMATs and C API, some of them with an argument that is not admissible.

No call may crash, raise a floating-point exception or write beyond an array. An accepted call has finite
results and a state that the next call accepts; a rejected call changes no state and says what was expected.
Constants are drawn from the table of PROPS. ASPERITY_CALLS is the approximate number of calls of each routine
(a million in `make soak`), ASPERITY_LIBRARY the path of another build of the library, such as that with
bounds checks and sanitizers.
"""

from __future__ import annotations

import ctypes
import os
import re
from collections.abc import Callable

import numpy as np
import pytest
from asperity.contract import (
    N_FACET_STATEV,
    N_FIXED_PROPS,
    N_LISTED_VALUES,
    N_PLANE_STATEV,
    N_POINT_STATEV,
    Prop,
    implex_table,
    props_table,
)
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from support_calls import (
    ADAPTERS,
    LIBRARY,
    SIGNALLING,
    Call,
    Routine,
    address,
    call_c,
    call_umat,
    call_vumat,
    errors,
    judge,
)

# CTest has no markers, and pytest need not repeat it
pytestmark = pytest.mark.long

CALLS = int(os.environ.get("ASPERITY_CALLS", "3000"))
BATCH = min(50, CALLS // 2)
PROP = {row.name: row.index - 1 for row in props_table()}
TIMED, REQUESTING = [PROP[k] for k in ("tau_v", "c", "implex")], [PROP[k] for k in ("dalpha", "implex")]
"""Constants that need a time increment, and those that ask for a shorter one."""
LEAST = 1.0e-50
"""Smallest constant above 0 that is drawn."""
AWKWARD = [SIGNALLING, 0.0, np.nan, np.inf, 5e-324, 2.2e-308, 1.7e308, 1.0, 2.2e-16]
AWKWARD += [1e50, 1e-50, 1e10, 64.0, 90.0]


class Draw(np.random.Generator):
    """Random numbers of a batch of calls."""

    def chance(self, probability: float) -> bool:
        """Return True with a probability."""
        return bool(self.random() < probability)

    def log(self, low: float, high: float) -> float:
        """Power of ten with an exponent in a range."""
        return float(10.0 ** self.uniform(low, high))

    def any_value(self) -> float:
        """Any bits, an awkward number, or one of a size that occurs."""
        bits = float(np.frombuffer(self.bytes(8))[0])
        value = [bits, AWKWARD[self.integers(len(AWKWARD))], self.log(-20.0, 20.0)][self.integers(3)]
        return -value if self.chance(0.5) else value

    def constant(self, row: Prop, far: bool) -> float:
        """Value of a constant by its scale, of plausible size or (far) from the whole range with its ends."""
        low, high = (row.lower, row.upper) if far else row.plausible
        if far and self.chance(0.1):
            return (low, high)[self.integers(2)]
        if row.scale == "whole":
            return float(self.integers(int(low), int(high), endpoint=True))
        u = self.random()
        if row.scale == "linear":
            return (1.0 - u) * low + u * high
        low = max(low, LEAST)
        if row.scale == "log":
            return float(np.exp((1.0 - u) * np.log(low) + u * np.log(high)))
        high = min(high, 1.0 - 2.0**-53)
        z = (1.0 - u) * np.log(low / (1.0 - low)) + u * np.log(high / (1.0 - high))
        return float(min(max(1.0 / (1.0 + np.exp(-z)), low), high))

    def props(self, far: bool) -> tuple[np.ndarray, int]:
        """Admissible PROPS, and the number of state variables."""
        values = []
        for row in props_table():
            chosen = row.default is None or (row.owner != "reserved" and self.chance(0.3))
            values.append(self.constant(row, far) if chosen else row.default)
        values[PROP["theta"]] = self.uniform(0.0, 89.9)
        values[PROP["water"]] = 0.0  # the calls pass no predefined fields
        values[PROP["implex"]] = 0.0  # of the UMAT alone
        sides = (0, 2, 3, 4, 5, 6, 12, 32, 63, 64)[self.integers(10)]
        if self.chance(0.15):
            sides = -int(self.integers(1, 9))
            planes = self.random((-sides, N_LISTED_VALUES)) - [0.0, 0.5, 0.5, -0.1]
            planes[:, 0] = 10.0 ** self.uniform(-3.0, 3.0, -sides)
            planes[:, 3] /= planes[:, 3].sum()
            values += planes.ravel().tolist()
        values[PROP["m"]] = float(sides)
        props, message = np.array(values), ctypes.create_string_buffer(2000)
        nstatv = LIBRARY.asperity_nstatv(address(props), len(props), message, 2000)
        if nstatv == 0:
            # ratios are limited, too: what a message names takes its default
            for name in {"sigma02", "Gc2", *re.findall(r"^\w+", message.value.decode(), re.MULTILINE)}:
                assert ": expected " in message.value.decode()
                if props_table()[PROP[name]].default is not None:
                    props[PROP[name]] = props_table()[PROP[name]].default
            nstatv = LIBRARY.asperity_nstatv(address(props), len(props), message, 2000)
        assert nstatv > 0, f"admissible PROPS are refused: {message.value.decode()}\n{props.tolist()}"
        return props, nstatv


def spoil(draw: Draw, call: Call, routine: Routine) -> bool:
    """Replace an argument by an arbitrary one; return whether the call must be rejected."""
    points, kind = len(call.state), call.props.dtype.type
    point, value = draw.integers(points), float(kind(draw.any_value()))
    where = draw.integers(7)
    if where in (0, 1):
        i = draw.integers(len(call.props))
        call.props[i] = value
        row = props_table()[i] if i < N_FIXED_PROPS else None
        return not np.isfinite(value) or (row is not None and not row.lower <= value <= row.upper)
    if where in (2, 3):
        array = call.increment if where == 2 else call.state
        array[point, draw.integers(array.shape[1])] = value
        return not np.isfinite(value)
    if where == 4:
        call.times = call.times[0], value
        viscous = call.props[TIMED].any() and call.times[0] > 0.0
        return bool(viscous and not 0.0 <= value < np.inf)
    if where == 5:
        size = call.state.shape[1] + int(draw.integers(-1, 2))
        call.props = np.resize(call.props, len(call.props) + int(draw.integers(-1, 2)))
        call.state = np.resize(call.state, (points, size))
        return False
    if routine is call_c:
        sizes = {"n": points, "nprops": len(call.props), "nstatv": call.state.shape[1]}
        name = list(sizes)[draw.integers(3)]
        call.optional = {name: -sizes[name]}
        return True
    if routine is call_vumat:
        ndir = int(draw.integers(4))
        call.optional = {"ndir": ndir}
        call.increment, call.stress = np.zeros((2, points, call.increment.shape[1] - 1 + ndir))
        return ndir != 1
    ntens = int(draw.integers(9))
    arrays = (call.strain, call.increment, call.stress)
    call.strain, call.increment, call.stress = (np.resize(array, (1, ntens)) for array in arrays)
    return ntens not in (2, 3, 6)


def history(draw: Draw, routine: Routine, kind: type, said: Callable[[], str]) -> bool:
    """Some increments of points, the last of which may have an arbitrary argument.

    Return whether constants of plausible size were refused because they leave the range of single precision.
    """
    far = draw.chance(0.1)
    props, nstatv = draw.props(far)
    n_planes = (nstatv - N_POINT_STATEV) // N_PLANE_STATEV
    if props[PROP["W0"]] > 0.0 or props[PROP["crush"]] > 0.0:
        n_planes = (nstatv - N_POINT_STATEV) // (N_PLANE_STATEV + N_FACET_STATEV)
    # time of the dashpot, which a duration must not be far below
    lag = props[PROP["c"]] * 2.0 * (1.0 - props[2]) * props[1] / ((props[PROP["kc"]] or 1.0) * props[0] ** 2)
    if lag > 1e20:
        props[PROP["c"]] = lag = 0.0
    if routine is call_umat and draw.chance(0.2):
        props[PROP["implex"]] = draw.random()
        nstatv += len(implex_table()) - 1 + n_planes
    n = 1 if routine is call_umat else int(draw.integers(1, 200 if draw.chance(0.2) else 5))
    columns = {call_umat: (2, 3, 6), call_vumat: (2, 3), call_c: (3,)}[routine]
    columns = columns[draw.integers(len(columns))]
    strengths, energies = (
        (props[i], props[PROP[name]] or props[i]) for i, name in ((0, "sigma02"), (1, "Gc2"))
    )
    s_0 = 2.0 * (1.0 - props[2]) * min(np.divide(energies, strengths))
    scale = draw.log(-2.0, 3.0) * s_0 / (1.0 if routine is call_c else props[PROP["h"]] or 1.0)
    extreme = routine is call_umat and draw.chance(0.02)
    call = Call(
        props.astype(kind),
        *np.zeros((3, n, columns)),
        np.zeros((n, nstatv)),
        (1.0, 0.0),
        np.zeros((n, 2)),
        np.full(n, 0.0 if draw.chance(0.1) else draw.log(-12.0, 5.0)).astype(kind),
        n_planes,
        {},
    )
    # a traction that many planes do not carry may take seconds
    most = np.inf if CALLS > 10000 else 16
    spoilt = draw.chance(0.4)
    increments = int(draw.integers(1, 5))
    initial = False
    for increment in range(1, increments + 1):
        call.increment = (1.0e46 if extreme else 1.0) * scale * (draw.random((n, columns)) - 0.5)
        if kind == np.float32 and not np.abs(call.increment).max() < 1.0e30:
            call.increment[:] = 0.0
        call.times = (float(increment), draw.log(-6.0, 6.0))
        call.times = call.times[0], max(call.times[1], 1e-6 * lag)
        if routine is call_vumat and draw.chance(0.1):
            call.times = (0.0, call.times[1])
        if increment == 1 and draw.chance(0.06) and n * n_planes <= most:
            initial = True
            call.stress = draw.log(-2.0, 2.0) * props[0] * (draw.random((n, columns)) - 0.5)
        elif routine is call_umat:
            call.stress = np.zeros((1, columns))
        if routine is call_umat:
            call.optional = {"pnewdt": [None, -1.0, 0.0, 1.0, 2.0][draw.integers(5)]}
            if draw.chance(0.1) and not call.props[TIMED].any():
                call.optional["dtime"] = None
        bad = spoilt and increment == increments
        must = bad and spoil(draw, call, routine)
        out = routine(draw, call)
        out.message = out.message or said()
        narrow = kind == np.float32 and (far or "leave the range of the host's real kind" in out.message)
        rejected = judge(routine, call, out, must, not (bad or initial or narrow))
        if routine is call_umat:
            check_pnewdt(call, float(out.pnewdt[0]), rejected)
        if rejected:
            return narrow and not far
        call.state = out.state if routine is call_vumat else out.state.T.reshape(call.state.shape)
        call.strain = call.strain + call.increment
        if routine is call_vumat:
            call.energies = out.energies
        if routine is call_vumat and call.times[0] > 0.0:
            call.stress, initial = out.stress, False
        initial = initial and routine is call_vumat
    # the state of an accepted call is that of another one
    call.strain, call.increment = np.zeros((2, *call.increment.shape))
    judge(routine, call, routine(draw, call), False, not initial)
    said()
    return False


def check_pnewdt(call: Call, pnewdt: float, rejected: bool) -> None:
    """A rejected call asks for a cut; so may an accepted one where the growth of damage is limited."""
    given = call.optional["pnewdt"]
    if given is None:
        return
    if rejected:
        assert pnewdt == (min(given, 0.25) if given > 0.0 else 0.25)
    else:
        limited = call.props[[i for i in REQUESTING if i < len(call.props)]].any()
        assert pnewdt == given or (limited and 0.1 <= pnewdt <= 0.75)


@ADAPTERS
@settings(
    max_examples=max(1, CALLS // (2 * BATCH)),
    deadline=None,
    derandomize=CALLS < 10000,
    suppress_health_check=list(HealthCheck),
    phases=(Phase.generate,),
)
@given(seed=st.integers(0, 2**64 - 1))
def test_random_calls(routine: Routine, kind: type, seed: int) -> None:
    """Calls with random arguments are accepted with finite results, or rejected without any."""
    draw = Draw(np.random.PCG64(seed))
    with errors() as said, np.errstate(all="ignore"):
        assert sum(history(draw, routine, kind, said) for _ in range(BATCH)) < BATCH // 4
