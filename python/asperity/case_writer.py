"""Case files as the library writes them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from . import _core, contract
from .contract import Floats
from .pattern import Pattern

CASE_INCREMENTS = 100  # increments of a step of `slip_case`
LONGEST = 4096  # bytes of a text, which the library takes in a cell of this size; no path is longer


Group = tuple[str, Mapping[str, Any]]
"""Name and entries of a group of a case file."""


class Word(str):
    """Word that is written as it is: the name of a sweep's number, or a number as a user has typed it."""


def case_text(*groups: Group) -> str:
    """Text of a case file, written by the library.

    groups: name and entries, in their order. A value is a number, a list of numbers, a text or a `Word`. One
    that is None, or a list without numbers, is left out. `check_text` checks a text.
    """
    names: list[str] = []
    values: list[float] = []
    strings: list[bytes] = []
    kinds, counts = [], []
    for group, entries_of in groups:
        given = {name: value for name, value in entries_of.items() if value is not None}
        for name, value in [(group, None), *given.items()]:
            text = value.encode() if isinstance(value, str) else b""
            if len(text) > LONGEST or {*b"\r\n"} & {*text}:
                raise ValueError(f"{name} = {value!r:.200}: expected one line of at most {LONGEST} bytes")
            numbers = [] if value is None or text else np.atleast_1d(value).astype(float).tolist()
            if value is not None and not (text or numbers):
                continue
            names.append(name.ljust(32))
            kinds.append(0 if value is None else 1 if numbers else 3 if isinstance(value, Word) else 2)
            counts.append(len(numbers) or len(text))
            values += numbers
            strings.append(text)
    arrays = np.array(names, "S32"), kinds, counts, values or [0.0], np.array(strings, f"S{LONGEST}")
    room = np.zeros(64 + 40 * (len(names) + len(values)) + 2 * sum(map(len, strings)), "S1")
    length = _core.case_text(*arrays, room)
    return b"".join(room[:length].tolist()).decode()


def entries_of(values: Mapping[str, float], digits: int = 10) -> dict[str, float]:
    """Entries of the group &material of constants, rounded; one of 0 is left out where 0 is its default."""
    zero = {row.name for row in contract.props_table() if row.default == 0.0}
    return {name: rounded(value, digits) for name, value in values.items() if value or name not in zero}


def pattern_entries(pattern: Pattern) -> dict[str, Any]:
    """Entries of the group &pattern, rounded to nine digits."""
    if pattern.m < 0:
        return {"normals": np.round(pattern.normals, 9).ravel(), "weights": np.round(pattern.weights, 9)}
    found: dict[str, Any] = {"sides": pattern.m}
    if pattern.m > 0:
        found |= {name: rounded(getattr(pattern, name), 9) for name in ("theta", "flat", "turn")}
    return found


def pattern_text(pattern: Pattern) -> str:
    """Group &pattern of a case file, without its line end."""
    return case_text(("pattern", pattern_entries(pattern))).rstrip("\n")


def rounded(value: float, digits: int) -> float:
    """Return a number rounded to significant digits."""
    return float(f"{value:.{digits}g}")


def props_line(props: Floats, digits: int = 6) -> str:
    """Line with the vector PROPS; 17 digits are all."""
    values = [repr(rounded(value, digits)) for value in props.tolist()]
    return f"PROPS({len(values)})   {', '.join(values)}"


def slip_case(
    title: str,
    material: Mapping[str, float],
    pattern: Pattern,
    tractions: Iterable[float],
    slips: Sequence[float],
    direction: float = 0.0,
    increments: int = CASE_INCREMENTS,
) -> str:
    """Case file of a joint that slips under each of these normal tractions."""
    held = sorted({*tractions}, reverse=True)
    several, parts = len(held) > 1, [increments] * len(slips)
    slip = {"slip": [rounded(one, 6) for one in slips], "direction": direction, "increments": parts}
    return case_text(
        ("case", {"title": title}),
        ("material", material),
        ("pattern", pattern_entries(pattern)),
        *([("sweep", {"name": "sigma_N", "values": held})] if several else []),
        ("step", {"t_N": Word("sigma_N") if several else held[0], "increments": increments}),
        ("step", slip),
    )
