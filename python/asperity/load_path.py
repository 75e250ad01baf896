"""Rows of a load path from the library."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, contract
from .contract import Floats
from .errors import input_error
from .history import History, Snap
from .steps import Point, Step, pack

FIRST_ROOM, MOST_ROOM = 2048, 1_000_000
"""Rows that are allocated where their number is not known before, and at most at first."""


@cache
def column_names() -> tuple[str, ...]:
    """Names of the numbers of a row, from the table of the library."""
    return tuple(texts[0] for texts, _ in contract.table_rows(3))


def _column(numbers: Floats, name: str) -> Floats:
    """Numbers of one name."""
    return numbers[:, column_names().index(name)].copy()


def _vector(numbers: Floats, letter: str) -> Floats:
    """Components N, Tx, Ty (T, 3) of s, t, or of the separation "before" or "after" a snap."""
    return np.stack([_column(numbers, f"{letter}_{axis}") for axis in ("N", "Tx", "Ty")], axis=1)


def rows_of(
    props: Floats,
    steps: Sequence[Step] | Step,
    start: ArrayLike | Point | None = None,
    tolerance: float | None = None,
    keep_lost: bool = False,
) -> tuple[History, str]:
    """Rows for admissible PROPS, and why the path ends before its end ("" if it does not).

    start: as in `Interface.run`.  keep_lost: the row beyond which there is no equilibrium is the last one,
    instead of an event after the last one. Raises ValueError for every value of steps, start and tolerance
    that is out of range.
    """
    sizes = contract.check(props)
    nstatv = contract.n_statev(*sizes)
    start = Point(np.zeros(nstatv)) if start is None else start
    start = start if isinstance(start, Point) else Point(start)
    steps = [steps] if isinstance(steps, Step) else list(steps)
    if not steps or not all(isinstance(step, Step) for step in steps):
        raise ValueError("steps: expected one asperity.Step or more")
    relative = 0.0 if tolerance is None else contract.number("tolerance", tolerance, "1e-8 to 0.1")
    counts, values = pack(steps)
    work = np.nan if start.work is None else contract.number("work", start.work)
    place = np.append(contract.array("separation", start.separation, (3,)), work)
    state = contract.array("state", start.state, (nstatv,))
    n = FIRST_ROOM
    if tolerance is None and not any(step.follow == "branch" for step in steps):
        n = min(sum(map(len, steps)), MOST_ROOM)
    while True:
        room = n
        numbers, states = np.zeros((room, len(column_names()))), np.empty((room, nstatv))
        names = np.zeros(room, "S64")
        n, ended, status, message = _core.path_rows(
            props, counts.T, values, place, state, tolerance is not None, relative, numbers.T, states.T, names
        )
        if status != 0:
            raise input_error(message)
        if n <= room:
            break
    lost = ""
    if ended:
        last = numbers[n - 1 : n]
        s, t = (", ".join(f"{value:.6g}" for value in _vector(last, letter)[0]) for letter in "st")
        place = "step {:g} increment {:g}".format(*(_column(last, name)[0] for name in ("step", "increment")))
        text = message.decode("ascii").rstrip()
        lost = f"equilibrium lost beyond {place}, s = ({s}), t = ({t}): {text}"
    kept = slice(n if keep_lost else n - bool(lost))
    return history_of(numbers[kept], states[kept], names[kept], sizes[0], "" if keep_lost else lost), lost


def history_of(
    numbers: Floats, states: Floats, names: NDArray[np.bytes_], n_planes: int, lost: str
) -> History:
    """History of numbers of rows in the order of `column_names`, their states and the names of events."""
    happened = enumerate(name.decode("ascii").rstrip() for name in names.tolist())
    events = tuple((row, name) for row, name in happened if name)
    if lost:
        events += ((len(numbers), lost),)
    before, after = _vector(numbers, "before"), _vector(numbers, "after")
    released = _column(numbers, "released")
    snaps = tuple(
        Snap(row, tuple(before[row].tolist()), tuple(after[row].tolist()), float(released[row]))
        for row in np.flatnonzero(_column(numbers, "snaps") > 0.0).tolist()
    )
    parts = _vector(numbers, "s"), _vector(numbers, "t"), _column(numbers, "damage"), states.copy()
    more = _column(numbers, "step").astype(int), _column(numbers, "position"), _column(numbers, "time")
    iterations = _column(numbers, "iterations").astype(int)
    return History(*parts, _column(numbers, "work"), events, snaps, n_planes, *more, iterations)
