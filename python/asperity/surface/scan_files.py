"""Reading of scanned profiles and height maps from CSV files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..contract import Floats
from ..fit.units import LENGTHS, standard
from ..tables import read_table
from .scan import EVEN, LEAST_POINTS, Scan, even

EXPECTED = (
    "expected columns x, z (profile) or x, y, z (map), as x [mm],z [um]; --spacing for a matrix of heights"
)


def read_scan(path: Path, spacing: Sequence[float] | None = None, unit: str = "mm") -> Scan:
    """Read the profile or height map of a CSV; with a spacing (dx, dy) it is a matrix of heights.

    Lengths are converted to the unit of x; `unit` is that of a file that names none. Raises ValueError with
    line and value.
    """
    table = read_table(path, "a CSV with a profile or a height map")
    header = ", ".join(
        name + (f" [{unit}]" if unit else "") for name, unit in zip(table.names, table.units, strict=True)
    )
    if not table.cells:
        raise ValueError(f"{path}: expected rows of numbers")
    places = range(len(table.cells[0]))
    if spacing is not None:
        if header:
            raise ValueError(f"{path}: {header}: expected a matrix of numbers, as --spacing says")
        z = table.numbers(places, [str(i + 1) for i in places])
        dx, dy = spacing[0], spacing[-1]
        _enough(path, "columns", z.shape[1])
        _enough(path, "rows", z.shape[0])
        return Scan(dx * np.arange(z.shape[1]), dy * np.arange(z.shape[0]), z, unit)
    if not header and len(places) not in (2, 3):
        raise ValueError(f"{path}: {len(places)} columns without names: {EXPECTED}")
    names = [name.lower() for name in table.names] or list("xyz" if len(places) == 3 else "xz")
    if sorted(names) not in (["x", "z"], ["x", "y", "z"]):
        raise ValueError(f"{path}: columns {header}: {EXPECTED}")
    if any(table.units) and not all(table.units):
        raise ValueError(f"{path}: columns {header}: expected a unit for all or none, as x [mm]")
    units = [standard(given) for given in table.units if given] or [unit] * len(names)
    unknown = [given for given in units if given not in LENGTHS]
    if unknown:
        raise ValueError(f"{path}: unit {unknown[0]}: expected one of {', '.join(LENGTHS)}")
    unit = units[names.index("x")]
    factors = [LENGTHS[given] / LENGTHS[unit] for given in units]
    data = dict(zip(names, (table.numbers(places, names) * factors).T, strict=True))
    return (_profile if len(names) == 2 else _map)(path, data, table.lines, unit)


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
