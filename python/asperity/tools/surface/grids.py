"""Grids of ESRI: an ASCII file with a head of names and numbers, then rows of heights from north to south."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ...contract import Floats

NAMES = tuple("ncols nrows xllcorner xllcenter yllcorner yllcenter cellsize dx dy nodata_value".split())
REQUIRED = "ncols, nrows, xllcorner, yllcorner, cellsize"


def is_grid(path: Path) -> bool:
    """Whether a file begins as a grid of ESRI does."""
    with path.open("rb") as file:
        return bool(re.match(rb"(\xef\xbb\xbf)?\s*ncols\s", file.read(64), re.IGNORECASE))


def read_grid(path: Path) -> tuple[Floats, Floats, Floats, list[float]]:
    """Positions x (nx,) and y (ny,), heights (ny, nx) with y upwards, and the values of missing points.

    Raises ValueError for a head that lacks a number, and where there are more or fewer heights than it says.
    """
    lines = path.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    head: dict[str, float] = {}
    first = 0
    for i, line in enumerate(lines, 1):
        words = line.split()
        if words and not re.match(r"[A-Za-z_]", words[0]):
            break
        first = i
        if not words:
            continue
        name = words[0].lower()
        good = name in NAMES and len(words) == 2 and name not in head
        if not good:
            wanted = f"expected one of {', '.join(NAMES)} with a number"
            raise ValueError(f"{path}: line {i}: {line.strip():.60}: {wanted}")
        head[name] = _number(path, i, words[1])
    steps = [head.get("dx", head.get("cellsize", 0.0)), head.get("dy", head.get("cellsize", 0.0))]
    counts = [head.get("ncols", 0.0), head.get("nrows", 0.0)]
    if not all(n >= 1.0 and n % 1.0 == 0.0 for n in counts):
        raise ValueError(f"{path}: ncols, nrows = {counts}: expected whole numbers; a grid has {REQUIRED}")
    if not all(0.0 < step < np.inf for step in steps):
        raise ValueError(f"{path}: expected a cellsize > 0")
    values = [(i, word) for i, line in enumerate(lines[first:], first + 1) for word in line.split()]
    nx, ny = map(int, counts)
    if len(values) != nx * ny:
        raise ValueError(f"{path}: {len(values)} heights: expected {ny} rows of {nx}")
    z = np.array([_number(path, *value) for value in values]).reshape(ny, nx)[::-1]
    starts = [head.get(f"{axis}llcenter", head.get(f"{axis}llcorner", 0.0) + 0.5 * step)
              for axis, step in zip("xy", steps, strict=True)]  # fmt: skip
    x, y = (
        start + step * np.arange(n, dtype=float)
        for start, step, n in zip(starts, steps, (nx, ny), strict=True)
    )
    return x, y, z, [head["nodata_value"]] if "nodata_value" in head else []


def _number(path: Path, line: int, text: str) -> float:
    """Number of a word, which may have a decimal comma."""
    try:
        value = float(text.replace(",", ".", 1))
    except ValueError:
        value = np.nan
    good = (np.isfinite(value) or text.lower() in ("nan", "-nan")) and "_" not in text
    if not good:
        raise ValueError(f"{path}: line {line}: {text:.40}: expected a number")
    return value
