"""Heights that are none: values by which instruments mark missing points, spikes, holes and the outline."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...contract import Floats
from ...material import ModelWarning
from .scan import LEAST_POINTS, Scan

CODES = (-9999.0, -99999.0, 99999.0, -32768.0, -32767.0, 32767.0, 65535.0, -2147483648.0, 2147483647.0)
"""Values by which instruments and programs mark a missing height, if they lie outside the others."""

SMALL_CODES = (-999.0, 999.0, 9999.0, -99.0, 99.0, *(0.001 * code for code in CODES))
"""Such values, and the thousandths of those above, that may also be heights; they lie outside the others by
more than their range.
"""

SAME = 1.0e-6  # relative difference of two numbers in a file that are the same

HUGE = 1.0e20
"""Size from which a value marks a missing height, as 1e30 and the largest single-precision number do."""

SPIKE = 10.0
"""Least height of a spike above its neighbours, over that of 90 % of the points and the median step.

The step is that between points that follow each other: a plane has no heights above its neighbours.
"""

STEEP = 3.0
"""Least height of a spike, or gap to points apart, over the spacing: small noise of a plane is none."""

FEW = 0.2
"""Largest part of the points that may be refused as apart from all others: more may be a real step."""


def without_codes(path: Path, z: Floats, nodata: Sequence[float]) -> Floats:
    """Heights with NaN where they have a value of `nodata`, or one that marks missing points.

    A ModelWarning has the value and the number of points of each, and names a value of `nodata` that does not
    occur.
    """
    z = z.copy()
    for value in nodata:
        same = np.isclose(z, value, rtol=SAME, atol=0.0)
        z[same] = np.nan
        text = f"{path}: no height is {value:g}: expected one that --nodata names"
        if same.any():
            text = f"{path}: {same.sum()} of {z.size} heights are {value:g} (--nodata): they are holes"
        warnings.warn(text, ModelWarning, stacklevel=4)
    marks = np.array(
        [code for code in (*CODES, *SMALL_CODES) if np.isclose(z, code, rtol=SAME, atol=0.0).any()]
    )
    codes = np.full(z.shape, np.nan)
    for code in marks.tolist():
        codes[np.isclose(z, code, rtol=SAME, atol=0.0)] = code
    codes = np.where(np.abs(z) >= HUGE, z, codes)
    heights = z[np.isnan(codes) & np.isfinite(z)]
    if np.isnan(codes).all() or not heights.size:
        return z
    low, high = float(heights.min()), float(heights.max())
    for value in np.unique(codes[~np.isnan(codes)]).tolist():
        outside = max(low - value, value - high)
        if abs(value) < HUGE and outside <= (high - low if value in SMALL_CODES else 0.0):
            continue
        same = codes == value
        z[same] = np.nan
        text = f"{same.sum()} of {z.size} heights are {value:g}, which marks missing points: they are holes"
        warnings.warn(f"{path}: {text}", ModelWarning, stacklevel=4)
    return z


def _apart(z: Floats, least: float) -> np.ndarray:
    """Which heights are apart from all others, few of them, by more than their range and `least`."""
    ordered = np.sort(z, axis=None)
    gaps = np.diff(ordered)
    i = int(gaps.argmax())
    low, high = ordered[: i + 1], ordered[i + 1 :]
    few, many = (low, high) if low.size < high.size else (high, low)
    if few.size > FEW * z.size or not gaps[i] > max(least, float(np.ptp(many))):
        return np.zeros(z.shape, dtype=bool)
    return np.isin(z, few)


def refuse_spikes(path: Path, x: Floats, y: Floats | None, z: Floats) -> None:
    """Raise ValueError with number and place of heights (ny, nx) that stand far above or below others."""
    from scipy.ndimage import median_filter

    above = np.abs(z - median_filter(z, size=3 if y is not None else (1, 3), mode="nearest"))
    usual = float(np.percentile(above, 90.0, method="lower"))
    usual = max(usual, float(np.median(np.abs(np.diff(z)))))
    steep = STEEP * float(np.diff(x).mean())
    spikes = (above > max(SPIKE * usual, steep)) | _apart(z, steep)
    if spikes.any():
        row, column = (int(place[0]) for place in np.nonzero(spikes))
        at = f"x = {x[column]:g}" + ("" if y is None else f", y = {y[row]:g}")
        text = f"{spikes.sum()} of {z.size} heights are spikes, the first at {at}: z = {z[row, column]:g}"
        wanted = "expected without them; --nodata leaves out a value, --keep-spikes keeps all heights"
        raise ValueError(f"{path}: {text}: {wanted}")


def enough(path: Path, what: str, count: int, least: int = LEAST_POINTS) -> None:
    """Raise ValueError for fewer than `least` of something."""
    if count < least:
        raise ValueError(f"{path}: {count} {what}: expected at least {least}")


def without_gaps(path: Path, x: Floats, y: Floats, z: Floats, unit: str) -> Scan:
    """Map of heights (ny, nx) over x (nx,) and y (ny,) without NaN.

    Gaps that heights enclose are holes, which are filled straight between the heights around.  The other
    gaps lie at the outline: the largest rectangle without them remains.  A ModelWarning has the number of
    points of both.
    """
    from scipy.interpolate import griddata
    from scipy.ndimage import binary_dilation, label

    gaps = np.isnan(z)
    known = int((~gaps).sum())
    enough(path, "heights", known)
    if gaps.any():
        of_gap, _ = label(gaps)
        outer = np.unique(np.concatenate([of_gap[0], of_gap[-1], of_gap[:, 0], of_gap[:, -1]]))
        holes = gaps & ~np.isin(of_gap, outer)
        z = z.copy()
        if holes.any():
            around = np.nonzero(binary_dilation(holes, np.ones((3, 3))) & ~gaps)
            inside = np.nonzero(holes)
            z[holes] = griddata((x[around[1]], y[around[0]]), z[around], (x[inside[1]], y[inside[0]]))
        part = _largest_rectangle(np.isfinite(z))
        y, x = (axis[side] for axis, side in zip((y, x), part, strict=True))
        z, gaps = z[part], gaps[part]
    for name, count in zip("yx", z.shape, strict=True):
        enough(path, f"different {name} within the outline", count)
    if lost := known - int((~gaps).sum()):
        text = f"{path}: {lost} of {known} heights are cut off with the gaps at the outline"
        warnings.warn(text, ModelWarning, stacklevel=4)
    if gaps.any():
        text = f"{path}: {gaps.sum()} of {gaps.size} points are in holes: heights straight between the others"
        warnings.warn(text, ModelWarning, stacklevel=4)
    return Scan(x, y, z, unit)


def _largest_rectangle(there: np.ndarray) -> tuple[slice, slice]:
    """Rows and columns of the largest rectangle of cells between points that are there, LEAST_POINTS a side.

    For each row and column the candidate is the widest rectangle as high as the run of points above it.
    """
    columns = np.arange(there.shape[1])
    high = np.zeros_like(columns)
    begin, end = np.zeros_like(columns), np.full_like(columns, len(columns))
    best, part = (False, -1), (slice(0), slice(0))
    for i, row in enumerate(there):
        first = np.maximum.accumulate(np.where(row, 0, columns + 1))
        last = np.minimum.accumulate(np.where(row, len(columns), columns)[::-1])[::-1]
        high = np.where(row, high + 1, 0)
        begin = np.where(row, np.maximum(begin, first), 0)
        end = np.where(row, np.minimum(end, last), len(columns))
        wide = end - begin
        cells = (high - 1) * (wide - 1)
        fits = np.minimum(high, wide) >= LEAST_POINTS
        j = int(np.where(fits, cells, -1 if fits.any() else cells).argmax())
        if (size := (bool(fits[j]), int(cells[j]))) > best:
            best, part = size, (slice(i + 1 - int(high[j]), i + 1), slice(int(begin[j]), int(end[j])))
    return part
