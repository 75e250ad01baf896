"""Rows of a load path from the library."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from . import _core, contract
from .contract import Floats
from .errors import input_error
from .history import History, Snap
from .steps import Point, Step, pack

FIRST_ROOM, MOST_ROOM = 2048, 1_000_000
"""Rows that are allocated where their number is not known before, and at most at first."""

NUMBERS = 21
"""Numbers of a row: step, increment, position, time; separation; traction; work; Newton iterations, updates,
snaps; separation before and after the longest snap, released energy."""


def rows_of(
    props: Floats, n_planes: int, steps: Sequence[Step], start: Point, tolerance: float | None = None
) -> tuple[History, str]:
    """Rows in equilibrium for admissible PROPS, and why the path ends before its end ("" if it does not).

    Raises ValueError for every value of the steps, the start and the tolerance that is out of range.
    """
    numbers, states, names, lost = _rows(props, steps, start, tolerance)
    n = len(numbers) - bool(lost)
    return _history(numbers[:n], states[:n], names[:n], n_planes, lost), lost


def all_rows_of(
    props: Floats, n_planes: int, steps: Sequence[Step], start: Point, tolerance: float | None = None
) -> tuple[History, str]:
    """As `rows_of`, with the row beyond which there is no equilibrium as the last one."""
    numbers, states, names, lost = _rows(props, steps, start, tolerance)
    return _history(numbers, states, names, n_planes, ""), lost


def _rows(
    props: Floats, steps: Sequence[Step], start: Point, tolerance: float | None
) -> tuple[Floats, Floats, NDArray[np.bytes_], str]:
    """Numbers, states and events of all rows, and what is said of an equilibrium that is lost."""
    steps = list(steps)
    if not steps or not all(isinstance(step, Step) for step in steps):
        raise ValueError("steps: expected one asperity.Step or more")
    relative = 0.0 if tolerance is None else contract.number("tolerance", tolerance, "1e-8 to 0.1")
    counts, values = pack(steps)
    work = np.nan if start.work is None else contract.number("work", start.work)
    place = np.append(contract.array("separation", start.separation), work)
    state = contract.array("state", start.state)
    n = FIRST_ROOM
    if tolerance is None and not any(step.follow == "branch" for step in steps):
        n = min(sum(map(len, steps)), MOST_ROOM)
    while True:
        room = n
        numbers, states, names = (
            np.zeros((room, NUMBERS)),
            np.empty((room, state.size)),
            np.zeros(room, "S64"),
        )
        n, ended, status, message = _core.path_rows(
            props, counts.T, values, place, state, tolerance is not None, relative, numbers.T, states.T, names
        )
        if status != 0:
            raise input_error(message)
        if n <= room:
            break
    lost = ""
    if ended:
        s, t = (", ".join(f"{value:.6g}" for value in numbers[n - 1, k : k + 3]) for k in (4, 7))
        place = "step {:g} increment {:g}".format(*numbers[n - 1, :2])
        text = message.decode("ascii").rstrip()
        lost = f"equilibrium lost beyond {place}, s = ({s}), t = ({t}): {text}"
    return numbers[:n], states[:n], names[:n], lost


def no_rows(nstatv: int, n_planes: int) -> History:
    """History without rows."""
    return _history(np.zeros((0, NUMBERS)), np.zeros((0, nstatv)), np.zeros(0, "S64"), n_planes, "")


def _history(numbers: Floats, states: Floats, names: NDArray[np.bytes_], n_planes: int, lost: str) -> History:
    happened = enumerate(name.decode("ascii").rstrip() for name in names.tolist())
    events = tuple((row, name) for row, name in happened if name)
    if lost:
        events += ((len(numbers), lost),)
    snaps = []
    for row in np.flatnonzero(numbers[:, 13] > 0.0).tolist():
        before, after = (tuple(numbers[row, k : k + 3].tolist()) for k in (14, 17))
        snaps.append(Snap(row, before, after, float(numbers[row, 20])))
    damage = states[:, contract.statev_index("damage")].copy()
    parts = numbers[:, 4:7].copy(), numbers[:, 7:10].copy(), damage, states.copy(), numbers[:, 10].copy()
    more = numbers[:, 0].astype(int), numbers[:, 2].copy(), numbers[:, 3].copy(), numbers[:, 11].astype(int)
    return History(*parts, events, tuple(snaps), n_planes, *more)
