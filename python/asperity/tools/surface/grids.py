"""Grids of heights as text: those of ESRI, and the maps of pixels that interferometers write.

A grid of ESRI has a head of names and numbers, then rows of heights from north to south.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
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


PIXELS = b"Zygo XYZ Data File"
"""Start of a map of pixels: a head up to a line #, then a line for each pixel with column, row and height."""

CAMERA, WAVE = 6, 2
"""Place of the distance of pixels, m, in the line of the optics, and of the wave length, m."""


def is_of_pixels(path: Path) -> bool:
    """Whether a file begins as the maps of pixels of interferometers do."""
    with path.open("rb") as file:
        return file.read(len(PIXELS)) == PIXELS


def read_pixels(path: Path, spacing: Sequence[float] | None) -> tuple[Floats, Floats, Floats]:
    """Positions x (nx,) and y (ny,), and heights (ny, nx) in mm, NaN where a pixel has no number.

    The file has heights in um.  spacing: distance of the pixels, mm, which replaces that of the file.  Raises
    ValueError for a file without a distance, and for a line that is no pixel.
    """
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    head = next((i for i, line in enumerate(lines) if line.strip() == "#"), len(lines))
    numbers = [[_value(word) for word in line.split()] for line in lines[:head]]
    sizes = [line[CAMERA] for line in numbers if len(line) > CAMERA and 1e-8 < line[WAVE] < 1e-4]
    apart = list(spacing) if spacing is not None else [1e3 * size for size in sizes if size > 0.0]
    if not apart:
        raise ValueError(f"{path}: the head has no distance of the pixels: expected --spacing, in mm")
    pixels = {}
    for i, line in enumerate(lines[head + 1 :], head + 2):
        words = line.split()
        if not words or words == ["#"]:
            continue
        if len(words) < 3 or not all(word.isdecimal() for word in words[:2]):
            raise ValueError(
                f"{path}: line {i}: {line.strip():.40}: expected column, row and height of a pixel"
            )
        place = int(words[1]), int(words[0])
        if place in pixels:
            raise ValueError(f"{path}: line {i}: pixel {words[0]}, {words[1]} again: expected one height")
        word = " ".join(words[2:])
        pixels[place] = 1e-3 * _number(path, i, word) if re.search(r"\d", word) else np.nan
    if not pixels:
        raise ValueError(f"{path}: expected a line # and pixels below it")
    places = np.array([*pixels])
    low = places.min(axis=0)
    z = np.full(tuple(places.max(axis=0) - low + 1), np.nan)
    z[tuple((places - low).T)] = [*pixels.values()]
    y, x = (step * np.arange(n, dtype=float) for step, n in zip((apart[-1], apart[0]), z.shape, strict=True))
    return x, y, z


def _value(text: str) -> float:
    """Number of a word, which may have a decimal comma; NaN for another word."""
    try:
        return float(text.replace(",", ".", 1))
    except ValueError:
        return float("nan")


def _number(path: Path, line: int, text: str) -> float:
    """Number of a word; raises ValueError for another word."""
    value = _value(text)
    good = (np.isfinite(value) or text.lower() in ("nan", "-nan")) and "_" not in text
    if not good:
        raise ValueError(f"{path}: line {line}: {text:.40}: expected a number")
    return value
