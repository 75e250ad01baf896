"""Case files as text, in the form in which the library reads them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from . import contract
from .contract import Floats
from .pattern import Pattern

CASE_INCREMENTS = 100  # increments of a step of `slip_case`
WIDTH, COLUMNS = 100, 6  # characters of a line, and numbers of a long list in it: two normals
SMALL, LARGE = 1e-5, 1e9  # numbers from the one to the other are written without an exponent


Group = tuple[str, Mapping[str, Any]]
"""Name and entries of a group of a case file."""


class Word(str):
    """Word that is written as it is: the name of a sweep's number, or a number as a user has typed it."""


def case_text(*groups: Group) -> str:
    """Text of a case file.

    groups: name and entries, in their order. A value is a number, a list of numbers, a text or a `Word`. One
    that is None, or a list without numbers, is left out. `check_text` checks a text.
    """
    return "".join(_group_text(name, entries) for name, entries in groups)


def _group_text(group: str, entries: Mapping[str, Any]) -> str:
    """Text of a group; it breaks where a line is full, and within a long list after each two normals."""
    pieces: list[tuple[str, bool]] = []
    for name, value in entries.items():
        if isinstance(value, str):
            if {*value} & {*"\r\n\0"}:
                raise ValueError(f"{name} = {value!r:.200}: expected one line")
            quoted = value if isinstance(value, Word) else "'" + value.replace("'", "''") + "'"
            pieces.append((f"{name} = {quoted}", False))
        elif value is not None:
            numbers = [number_text(number) for number in np.atleast_1d(value).astype(float).tolist()]
            breaks = len(numbers) > COLUMNS
            numbers[:1] = [f"{name} = {number}" for number in numbers[:1]]
            pieces += [(number, breaks and i % COLUMNS == 0) for i, number in enumerate(numbers)]
    lines = [f"&{group}"]
    for i, (piece, breaks) in enumerate(pieces):
        comma = "," if i else ""
        if breaks or len(lines[-1] + comma) + len(piece) + 2 > WIDTH:
            lines[-1] += comma
            lines.append(f"  {piece}")
        else:
            lines[-1] += f"{comma} {piece}"
    return "\n".join(lines) + " /\n"


def number_text(value: float) -> str:
    """Shortest text of a number that reads back exactly; large and small ones have an exponent."""
    if value == 0.0 or SMALL <= abs(value) < LARGE:
        return np.format_float_positional(value, trim="-")
    return np.format_float_scientific(value, trim="-", exp_digits=1).replace("e+", "e")


def entries_of(values: Mapping[str, float], digits: int = 10) -> dict[str, float]:
    """Entries of the group &material of constants, rounded; one of 0 is left out where 0 is its default."""
    zero = {row.name for row in contract.props_table() if row.default == 0.0}
    return {
        name: rounded(value, digits + _more(name, value))
        for name, value in values.items()
        if value or name not in zero
    }


def _more(name: str, value: float) -> int:
    """Digits that eta needs beside those of 1 - eta, from which the stiffness follows."""
    return -int(np.floor(np.log10(1.0 - value))) - 1 if name == "eta" and 0.0 < value < 1.0 else 0


def pattern_entries(pattern: Pattern) -> dict[str, Any]:
    """Entries of the group &pattern, rounded to nine digits."""
    if pattern.m < 0:
        # 0.0 takes the sign from a zero
        normals = np.round(pattern.normals, 9).ravel() + 0.0
        return {"normals": normals, "weights": np.round(pattern.weights, 9)}
    entries: dict[str, Any] = {"sides": pattern.m}
    if pattern.m > 0:
        entries |= {name: rounded(getattr(pattern, name), 9) for name in ("theta", "flat", "turn")}
    return entries


def pattern_text(pattern: Pattern) -> str:
    """Group &pattern of a case file, without its line end."""
    return case_text(("pattern", pattern_entries(pattern))).rstrip("\n")


def rounded(value: float, digits: int) -> float:
    """Return a number rounded to significant digits."""
    return float(f"{value:.{digits}g}")


def props_line(props: Floats, digits: int = 6) -> str:
    """Line with the vector PROPS; 17 digits are all."""
    names = [row.name for row in contract.props_table()]
    of_all = {**dict(enumerate(names)), **dict.fromkeys(range(len(names), len(props)), "")}
    values = [
        repr(rounded(value, digits + _more(of_all[i], value))) for i, value in enumerate(props.tolist())
    ]
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
    slip = {"slip": [rounded(target, 6) for target in slips], "direction": direction, "increments": parts}
    return case_text(
        ("case", {"title": title}),
        ("material", material),
        ("pattern", pattern_entries(pattern)),
        *([("sweep", {"name": "sigma_N", "values": held})] if several else []),
        ("step", {"t_N": Word("sigma_N") if several else held[0], "increments": increments}),
        ("step", slip),
    )
