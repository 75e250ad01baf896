"""Load paths: steps with the names, defaults and rules of `&step`, and the point at which a path starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import contract
from .contract import Floats

FOLLOW = ("stable", "branch")  # values of `follow`; their positions are the numbers of the library


class Entry(NamedTuple):
    """Entry of a step: whether it has one value (or a list), and its default."""

    name: str
    single: bool
    default: float


@cache
def entries() -> tuple[Entry, ...]:
    """Entries of a step, from the table of the library."""
    return tuple(Entry(**row) for row in contract.tables()["entries"])


@dataclass(frozen=True, repr=False)
class Step:
    """A step of a load path: which separation or traction of each component it prescribes.

    A step starts where the step before ended. A component that a step does not name keeps its condition, the
    prescribed separation or traction, at its last value; in the first step that is a separation of 0. Targets
    are one value or a list, reached one after the other; a shorter list repeats its last value. None is: not
    given.

    s_N, s_Tx, s_Ty: targets of the separation, length. t_N, t_Tx, t_Ty: of the traction, stress, tension
    positive. k_N, k_Tx, k_Ty: stiffness of the surroundings (CNS), stress/length, beside a prescribed
    traction, which is its target minus k (s - s at the start of the step), until k is 0 or the separation is
    prescribed. slip: targets of s_Tx and s_Ty together along a direction, degrees from Tx towards Ty, which
    remains in later steps. increments: to each target, one number or a list (100). cycles: how often the
    lists are followed (1). time: duration of the step, divided equally among its increments, or a list, the
    time to each target (1); it matters for viscous damage and a dashpot. follow, "stable" or "branch": the
    point jumps where the stable path ends, or continues along the unstable part, where the prescribed values
    turn back and forward again. arc: longest step along the branch, times s0 (0.05). fork: where another
    branch crosses first, 1 leaves to the side where the component that changes most grows, -1 to the other
    side (0: go along); a step in which this is not possible is an error. p: targets of the water pressure in
    the joint, stress, >= 0; t_N is the total traction, of which the law carries t_N + p.

    Raises ValueError if a value is no number. Everything else is checked by `Interface.run`.

    Examples
    --------
    >>> Step(t_N=-1.0, increments=20)
    Step(t_N=-1.0, increments=20.0)
    >>> Step(slip=[0.4, -0.4], direction=20.0).slip
    (0.4, -0.4)
    """

    s_N: ArrayLike | None = None
    s_Tx: ArrayLike | None = None
    s_Ty: ArrayLike | None = None
    t_N: ArrayLike | None = None
    t_Tx: ArrayLike | None = None
    t_Ty: ArrayLike | None = None
    k_N: float | None = None
    k_Tx: float | None = None
    k_Ty: float | None = None
    slip: ArrayLike | None = None
    direction: float | None = None
    increments: ArrayLike | None = None
    cycles: int | None = None
    time: ArrayLike | None = None
    follow: str | None = None
    arc: float | None = None
    p: ArrayLike | None = None
    fork: int | None = None

    def __post_init__(self) -> None:
        """Numbers become floats, lists become tuples of floats."""
        value: Any
        for name, value in self.given().items():
            if name == "follow":
                if value not in FOLLOW:
                    raise ValueError(f"follow = {contract.shown(value)}: expected 'stable' or 'branch'")
                continue
            # most steps of a long path, for which arrays would take longer
            if type(value) is float:
                continue
            if type(value) is list and all(type(number) is float for number in value):
                object.__setattr__(self, name, tuple(value))
                continue
            array = contract.array(name, value, (), ("n",))
            object.__setattr__(self, name, tuple(array.tolist()) if array.ndim else float(array))

    def given(self) -> dict[str, float | tuple[float, ...] | str]:
        """Entries that are given, by name."""
        return {name: value for name, value in vars(self).items() if value is not None}

    def __repr__(self) -> str:
        """Entries that are given."""
        return f"Step({', '.join(f'{name}={contract.shown(value)}' for name, value in self.given().items())})"

    def __len__(self) -> int:
        """Number of increments along the stable path."""
        values = vars(self)
        lists = [value for name in TARGETS if isinstance(value := values[name], tuple)]
        targets = max(1, *map(len, lists)) if lists else 1
        numbers = _DEFAULTS["increments"] if self.increments is None else self.increments
        parts = [_limited(n) for n in (numbers if isinstance(numbers, tuple) else (numbers,))]
        last = parts[-1] * (targets - len(parts)) if parts else 0.0
        return int(_limited((sum(parts) + last) * (self.cycles or 1.0)))


def _limited(number: Any) -> float:
    """Number of increments that rows may have, from 1 on; 1 for what is no number."""
    return float(min(max(1.0, number), 1e7))


TARGETS = ("s_N", "s_Tx", "s_Ty", "t_N", "t_Tx", "t_Ty", "slip", "p")  # entries with a value for each target
_DEFAULTS = {entry.name: entry.default for entry in entries()}


@dataclass(frozen=True, eq=False)
class Point:
    """Start of a load path: STATEV (nstatv,), separation (N, Tx, Ty), length, and work so far, stress*length.

    A work that is None is the sum of stored and dissipated energies.  p: water pressure, stress.  traction:
    total (N, Tx, Ty) at the end of the last increment, stress; None is that of the state at rest.  A dashpot
    (c) and the guard add to that; for other joints another traction is an error.
    """

    state: Floats
    separation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    work: float | None = None
    p: float = 0.0
    traction: tuple[float, float, float] | None = None


def numbers_of(step: Step) -> dict[str, tuple[float, ...]]:
    """Numbers of the entries of a step that are given, by name; also a single one is a tuple."""
    entries_of_step = {name: value for name, value in step.given().items() if not isinstance(value, str)}
    return {name: value if isinstance(value, tuple) else (value,) for name, value in entries_of_step.items()}


def largest_tension(path: Sequence[Step], p: float) -> float:
    """Largest normal traction of the law that a path prescribes, t_N + p, or 0; p: at its start."""
    water, t_N, largest = np.array([p]), None, 0.0
    for step in path:
        water = water[-1:] if step.p is None else np.atleast_1d(np.asarray(step.p, float))
        if step.t_N is not None:
            prescribed = np.atleast_1d(np.asarray(step.t_N, float))
            largest, t_N = max(largest, float(np.max(prescribed + water))), prescribed[-1]
        elif step.s_N is not None:
            t_N = None
        elif t_N is not None:
            largest = max(largest, float(t_N + water.max()))
    return largest


def start_text(start: Point, tolerance: float | None) -> bytes:
    """Case file of a start, whose numbers read back exactly, with a step for those that are set."""
    groups: dict[str, dict[str, Any]] = {} if tolerance is None else {"case": {"tolerance": tolerance}}
    groups["state"] = {"separation": start.separation, "traction": start.traction, "statev": start.state}
    groups["state"] |= {"work": start.work, "p": start.p}
    groups["step"] = {}
    return "\n".join(f"&{name} {_entries_text(entries)} /" for name, entries in groups.items()).encode()


def _entries_text(entries: dict[str, Any]) -> str:
    """Entries of a group in one line."""
    lists = ((name, np.atleast_1d(value).tolist()) for name, value in entries.items() if value is not None)
    return " ".join(f"{name} = {','.join(map(repr, values))}" for name, values in lists)


def step_of(values: dict[str, list[float]]) -> Step:
    """Step of the values of its entries."""
    arguments: dict[str, Any] = {e.name: values[e.name] for e in entries() if e.name in values}
    arguments |= {e.name: values[e.name][0] for e in entries() if e.single and e.name in values}
    if "follow" in arguments:
        arguments["follow"] = FOLLOW[int(values["follow"][0])]
    return Step(**arguments)


def slip_path(
    direction: float,
    slips: ArrayLike,
    sigma_N: float,
    preload: float,
    stiffness: float = 0.0,
    times: ArrayLike = 0.0,
    preload_time: float = 0.0,
    follow: str = "stable",
    arc: float | None = None,
    each: bool = True,
) -> list[Step]:
    """Steps of `Interface.confined_slip`; each: whether every slip is one increment of the stable path."""
    held = Step(t_N=sigma_N, increments=preload, time=preload_time)
    durations = np.diff(np.atleast_1d(times), prepend=0.0)
    slide = Step(
        t_N=sigma_N,
        k_N=stiffness,
        slip=slips,
        direction=direction,
        increments=1 if each and follow == "stable" else None,
        time=durations if durations.any() else 0.0,
        follow=follow,
        arc=arc,
    )
    return [held, slide]


def prescribed(steps: Sequence[Step]) -> list[tuple[bool, ...]]:
    """For each step and component (N, Tx, Ty): whether its traction is prescribed (or its separation)."""
    traction = [False, False, False]
    controls = []
    for step in steps:
        for i, axis in enumerate(("N", "Tx", "Ty")):
            if getattr(step, f"s_{axis}") is not None or (i > 0 and step.slip is not None):
                traction[i] = False
            elif getattr(step, f"t_{axis}") is not None:
                traction[i] = True
        controls.append(tuple(traction))
    return controls


def turns_of(x: Floats) -> NDArray[np.int_]:
    """Rows of the ends and of the reversals of a path of slips or openings (T,)."""
    ways = np.sign(np.diff(x))
    moving = np.flatnonzero(ways)
    reversals = moving[1:][np.diff(ways[moving]) != 0]
    return np.concatenate([[0], reversals, [len(x) - 1]])


def thinned(x: Floats, most: int) -> NDArray[np.int_]:
    """Rows of a path (T,), at most `most` at equal distances, with its ends and reversals."""
    even = np.linspace(0, len(x) - 1, min(most, len(x))).round().astype(int)
    return np.unique(np.concatenate([even, turns_of(x)]))
