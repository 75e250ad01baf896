"""Reading of scanned profiles and height maps from CSV files."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..contract import Floats
from ..options import progress_bar
from .scan import EVEN, LEAST_POINTS, Scan, even

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "in": 0.0254}
"""Units of length that a header may name, in metres."""

EXPECTED = (
    "expected columns x, z (profile) or x, y, z (map), as x [mm],z [um]; --spacing for a matrix of heights"
)

_COMMA = re.compile(r"^[-+]?\d*,\d+$")
"""A number with a decimal comma."""

_CELL = re.compile(r"^\W*([A-Za-z]\w*)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\W*$")
"""Name of a column and its unit in brackets."""


def read_scan(path: Path, spacing: Sequence[float] | None = None, unit: str = "mm") -> Scan:
    """Read the profile or height map of a CSV; with a spacing (dx, dy) it is a matrix of heights.

    Separators are commas, semicolons or blanks; lines from # on are left out. Lengths are converted to the
    unit of x; `unit` is that of a file that names none. Raises ValueError with line and value.
    """
    header, rows = _cells(path)
    if spacing is not None:
        if header:
            raise ValueError(f"{path}: {', '.join(header)}: expected a matrix of numbers, as --spacing says")
        z = _table(path, rows)
        dx, dy = spacing[0], spacing[-1]
        _enough(path, "columns", z.shape[1])
        _enough(path, "rows", z.shape[0])
        return Scan(dx * np.arange(z.shape[1]), dy * np.arange(z.shape[0]), z, unit)
    names, units = _columns(path, header, len(rows[0][1]) if rows else 0)
    table = _table(path, rows)
    unit = units[names.index("x")] or unit
    data = {n: table[:, i] * (_metres(path, u) / _metres(path, unit) if u else 1.0)
            for i, (n, u) in enumerate(zip(names, units, strict=True))}  # fmt: skip
    lines = [line for line, _ in rows]
    return _profile(path, data, lines, unit) if len(names) == 2 else _map(path, data, lines, unit)


def _cells(path: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Header (empty without one) and the rows with their line numbers."""
    header: list[str] = []
    rows: list[tuple[int, list[str]]] = []
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}: expected a CSV with a profile or a height map") from None
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{path}: byte {error.start} is no text in UTF-8: expected a CSV with a profile or a height map"
        ) from None
    bar = progress_bar(len(lines), "line")
    for line, text in enumerate(lines, start=1):
        bar.update()
        text = text.split("#")[0].strip()
        if not text:
            continue
        mark = next((mark for mark in ";,\t" if mark in text), None)
        cells = [cell.strip().strip('"') for cell in text.split(mark)]
        if not rows and not header and not any(_is_number(cell) or _COMMA.match(cell) for cell in cells):
            header = cells if mark else re.findall(r"\w+\s*(?:[\[(][^\])]*[\])])?", text)
        else:
            rows.append((line, cells))
    bar.close()
    return header, rows


def _columns(path: Path, header: list[str], count: int) -> tuple[list[str], list[str]]:
    """Read the names and units of the columns."""
    if not header:
        if count not in (2, 3):
            raise ValueError(f"{path}: {count} columns without names: {EXPECTED}")
        return ["x", "z"] if count == 2 else ["x", "y", "z"], [""] * count
    found = [_CELL.match(cell) for cell in header]
    names = ["" if m is None else m[1].lower() for m in found]
    if sorted(names) not in (["x", "z"], ["x", "y", "z"]):
        raise ValueError(f"{path}: columns {', '.join(header)}: {EXPECTED}")
    units = ["" if m is None else m[2] or "" for m in found]
    if any(units) and not all(units):
        raise ValueError(f"{path}: columns {', '.join(header)}: expected a unit for all or none, as x [mm]")
    return names, units


def _table(path: Path, rows: list[tuple[int, list[str]]]) -> Floats:
    """Read the numbers of the rows."""
    if not rows:
        raise ValueError(f"{path}: expected rows of numbers")
    width = len(rows[0][1])
    for line, cells in rows:
        if len(cells) != width:
            raise ValueError(f"{path}, line {line}: {len(cells)} values: expected {width}")
        for cell in cells:
            if not _is_number(cell) or not np.isfinite(float(cell)):
                point = " with a decimal point" if _COMMA.match(cell) else ""
                raise ValueError(f"{path}, line {line}: {cell or 'nothing'}: expected a finite number{point}")
    return np.array([cells for _, cells in rows], dtype=float)


def _profile(path: Path, data: dict[str, Floats], lines: list[int], unit: str) -> Scan:
    """Profile with increasing x; a profile with decreasing x is reversed."""
    x, z = data["x"], data["z"]
    _enough(path, "points", len(x))
    steps = np.diff(x)
    if (steps < 0.0).all():
        x, z, lines, steps = x[::-1], z[::-1], lines[::-1], -steps[::-1]
    if not (steps > 0.0).all():
        i = int((steps <= 0.0).argmax())
        what = "vertical" if steps[i] == 0.0 else "overhang, or the points are not in order"
        raise ValueError(
            f"{path}, line {lines[i + 1]}: x = {x[i + 1]:g} after {x[i]:g}: expected x to increase ({what})"
        )
    return Scan(x.copy(), None, z[None, ::1].copy(), unit)


def _map(path: Path, data: dict[str, Floats], lines: list[int], unit: str) -> Scan:
    """Map on the grid of its points, whose order in the file does not matter."""
    axes, places = [], []
    for name in ("x", "y"):
        given = data[name]
        order = np.argsort(given, kind="stable")
        sizes = np.diff(given[order])
        # The values of a grid line may differ by rounding.
        new = sizes > EVEN * max(sizes.max(initial=0.0), 0.0)
        place = np.empty(len(given), dtype=int)
        place[order] = np.concatenate([[0], np.cumsum(new)])
        axis = np.bincount(place, given) / np.bincount(place)
        if len(axis) == 1:
            raise ValueError(f"{path}: {name} = {axis[0]:g} throughout: expected a map; a profile is x, z")
        _enough(path, f"different {name}", len(axis))
        steps = np.diff(axis)
        if np.abs(axis - even(axis)).max() > EVEN * steps.mean():
            i = int((np.abs(steps - np.median(steps)) > EVEN * np.median(steps)).argmax())
            raise ValueError(
                f"{path}: {name} = {axis[i]:g} and {axis[i + 1]:g}, {len(axis)} different {name}: expected a "
                f"regular grid along x and y, here of spacing {np.median(steps):g}; interpolate points that "
                "lie elsewhere onto one"
            )
        axes.append(even(axis))
        places.append(place)
    x, y = axes
    count = np.zeros((len(y), len(x)), dtype=int)
    np.add.at(count, (places[1], places[0]), 1)
    if (count > 1).any():
        j, i = np.argwhere(count > 1)[0]
        second = lines[np.flatnonzero((places[0] == i) & (places[1] == j))[1]]
        raise ValueError(
            f"{path}, line {second}: x = {x[i]:g}, y = {y[j]:g} again: expected one height a point"
        )
    if (count == 0).any():
        j, i = np.argwhere(count == 0)[0]
        raise ValueError(
            f"{path}: {np.count_nonzero(count == 0)} points of the grid are missing, the first at "
            f"x = {x[i]:g}, y = {y[j]:g}: expected a regular grid of {len(x)} x {len(y)} points"
        )
    z = np.empty((len(y), len(x)))
    z[places[1], places[0]] = data["z"]
    return Scan(x, y, z, unit)


def _enough(path: Path, what: str, count: int) -> None:
    if count < LEAST_POINTS:
        raise ValueError(f"{path}: {count} {what}: expected at least {LEAST_POINTS}")


def _metres(path: Path, unit: str) -> float:
    if unit not in UNITS:
        raise ValueError(f"{path}: unit {unit}: expected one of {', '.join(UNITS)}")
    return UNITS[unit]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
