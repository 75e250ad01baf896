"""Rows of a load path from the library."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, calls, contract
from .contract import Floats
from .errors import InputError, Record
from .history import History, Snap
from .material import ModelWarning
from .steps import FOLLOW, Point, Step, start_text

MOST_ROOM = 100_000
"""Rows that are allocated at once, at most."""

UNFORKED = 2
"""Answer of `asperity_lost` where a step has not left its branch at a fork."""

EVENTS: int = contract.tables()["sizes"]["events"]
"""Bytes of the names of the events of a row."""


@cache
def column_names() -> tuple[str, ...]:
    """Names of the numbers of a row, from the table of the library."""
    return tuple(contract.tables()["columns"])


def rows_of(
    props: Floats,
    steps: Sequence[Step] | Step,
    start: ArrayLike | Point | None = None,
    tolerance: float | None = None,
    keep_lost: bool = False,
    warns: bool = False,
) -> tuple[History, str]:
    """Rows for admissible PROPS, and why the path ends before its end ("" if it does not).

    start: as in `Interface.run`.  keep_lost: the row beyond which there is no equilibrium is the last one,
    instead of an event after the last one.  warns: whether work that differs from energies gives a
    ModelWarning at the call of the caller.  Raises ValueError for every value of steps, start and tolerance
    that is out of range, and for a `fork` at which no branch could be left.
    """
    numbers, states, names, loss, account = _run(props, steps, start, tolerance)
    if warns and account:
        warnings.warn(account, ModelWarning, stacklevel=3)
    n = len(numbers)
    lost = ""
    if loss is not None:
        last = dict(zip(column_names(), numbers[n - 1], strict=True))
        s, t = (", ".join(f"{last[f'{symbol}_{axis}']:.6g}" for axis in ("N", "Tx", "Ty")) for symbol in "st")
        row = f"step {last['step']:g} increment {last['increment']:g}, s = ({s}), t = ({t})"
        lost = f"equilibrium lost beyond {row}: {loss}"
    kept = slice(n if keep_lost else n - bool(lost))
    planes, yields = contract.check(props)[0], contract.yields(props)
    shown = "" if keep_lost else lost
    return history_of(numbers[kept], states[kept], names[kept], planes, shown, yields), lost


def columns_of(props: Floats, steps: Sequence[Step], names: Sequence[str]) -> list[Floats]:
    """Columns (n,) by name of the rows with equilibrium alone, for many runs; as `rows_of`."""
    numbers, _, _, loss, _ = _run(props, steps, None, None)
    kept = numbers if loss is None else numbers[:-1]
    return [kept[:, column_names().index(name)] for name in names]


def _run(
    props: Floats, steps: Sequence[Step] | Step, start: ArrayLike | Point | None, tolerance: float | None
) -> tuple[Floats, Floats, NDArray[np.bytes_], str | None, str]:
    """Numbers, states and events of all rows, why equilibrium was lost beyond them, if it was, and the
    warning of a path whose work and energies differ.
    """
    nstatv = contract.n_statev(*contract.check(props), contract.yields(props))
    if start is None:
        start = np.zeros(nstatv)
    if not isinstance(start, Point):
        start = Point(contract.array("state", start, (nstatv,)))
    steps = [steps] if isinstance(steps, Step) else list(steps) if isinstance(steps, Iterable) else []
    if not steps or not all(isinstance(step, Step) for step in steps):
        raise ValueError("steps: expected one asperity.Step or more")
    work = np.nan if start.work is None else contract.number("work", start.work)
    point = replace(
        start,
        state=contract.array("state", start.state, (nstatv,)),
        separation=tuple(contract.array("separation", start.separation, (3,)).tolist()),
        work=work if np.isfinite(work) else None,
        p=contract.number("p", start.p),
        traction=None
        if start.traction is None
        else tuple(contract.array("traction", start.traction, (3,)).tolist()),
    )
    if point.p < 0.0:
        raise ValueError(f"p = {contract.shown(start.p)}: expected >= 0")
    relative = None if tolerance is None else contract.number("tolerance", tolerance, "1e-8 to 0.1")
    if relative is not None and not np.isfinite(relative):
        raise ValueError(f"tolerance = {relative}: expected 1e-8 to 0.1")
    try:
        with calls.cases(start_text(point, relative), props, take=partial(_take, steps)) as handle:
            message = calls.message_room()
            run = _core.asperity_begin(handle, 0, message)
    except InputError as error:
        raise InputError(list(map(_of_argument, error.records))) from None
    if run == 0:
        raise InputError([Record(line, text=line) for line in calls.text_of(message).splitlines()])
    try:
        rows = _all_rows(run, nstatv, min(sum(map(len, steps)) + 1, MOST_ROOM))
        early = _core.asperity_lost(run, message)
    finally:
        _core.asperity_end(run)
    if early == UNFORKED:
        raise ValueError(calls.text_of(message))
    text = calls.text_of(message)
    return *rows, text if early else None, "" if early else text


def _take(steps: Sequence[Step], cases: int) -> None:
    """Give the steps of a path to the handle of a case file."""
    if _core.asperity_steps(cases, len(steps)) != 0:
        return  # the case file has errors, which are raised
    for i, step in enumerate(steps):
        for name, value in vars(step).items():
            if value is None:
                continue
            number = FOLLOW.index(value) if name == "follow" else value
            values = number if type(number) is tuple else (number,)
            if _core.asperity_set(cases, i, name, len(values), values or (0.0,)) != 0:
                raise RuntimeError(f"steps[{i}]: {name}: the library has no such entry")


def _of_argument(error: Record) -> Record:
    """Error of a load path as one of the arguments of `Interface.run`."""
    group = f"steps[{error.step}]" if error.step >= 0 else ""
    at = f"[{error.at}]" if error.at >= 0 else ""
    value = f"{error.name}{at}" + (f" = {error.value}" if error.value else "")
    return error._replace(group=group, words=": ".join(filter(None, (group, value, error.text))))


def _all_rows(run: int, nstatv: int, room: int) -> tuple[Floats, Floats, NDArray[np.bytes_]]:
    """Numbers, states and events of all rows of a run."""
    parts, n = [], room
    while n == room:
        numbers, states = np.zeros((room, len(column_names()))), np.empty((room, nstatv))
        names = np.zeros((room, EVENTS), np.int8)
        n = _core.asperity_next(run, numbers, states, names)
        parts.append((numbers[:n], states[:n], names.view(f"S{EVENTS}")[:n, 0]))
    numbers, states, events = (np.concatenate(kind) for kind in zip(*parts, strict=True))
    return numbers, states, events


def history_of(
    numbers: Floats,
    states: Floats,
    names: NDArray[np.bytes_],
    n_planes: int,
    lost: str,
    yields: bool = False,
) -> History:
    """History of numbers of rows in the order of `column_names`, their states and the names of events."""
    happened = enumerate(name.decode("ascii").rstrip() for name in names.tolist())
    events = tuple((row, name) for row, name in happened if name)
    if lost:
        events += ((len(numbers), lost),)
    column = dict(zip(column_names(), numbers.T.copy(), strict=True))
    s, t, before, after = (
        np.stack([column[f"{kind}_{axis}"] for axis in ("N", "Tx", "Ty")], axis=1)
        for kind in ("s", "t", "before", "after")
    )
    snaps = tuple(
        Snap(row, tuple(before[row].tolist()), tuple(after[row].tolist()), float(column["released"][row]))
        for row in np.flatnonzero(column["snaps"] > 0.0).tolist()
    )
    more = {name: column[name].astype(int) for name in ("step", "iterations")}
    more |= {name: column[name] for name in ("damage", "work", "position", "time", "p", "aperture")}
    axes = "N", "Tx", "Ty"
    entries = np.array([[column[f"D_{i}_{j}"] for j in axes] for i in axes])
    more["tangent"] = np.ascontiguousarray(entries.transpose(2, 0, 1))
    rows = History(s, t, state=states.copy(), events=events, snaps=snaps, n_planes=n_planes, **more)
    return replace(rows, yields=yields)
