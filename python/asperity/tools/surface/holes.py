"""Heights that are none: values by which instruments mark missing points, and spikes."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...contract import Floats
from ...material import ModelWarning

CODES = (-9999.0, -99999.0, 99999.0, -32768.0, -32767.0, 32767.0, 65535.0)
"""Values by which instruments and programs mark a missing height, if they lie outside the others."""

SMALL_CODES = (-999.0, 999.0, 9999.0, -99.0, 99.0)
"""Such values that may also be heights; they lie outside the others by more than their range."""

HUGE = 1.0e20
"""Size from which a value marks a missing height, as 1e30 and the largest single-precision number do."""

SPIKE, STEEP, FEW = 10.0, 3.0, 0.2
"""Smallest height of a spike over its neighbours: over that of 99 % of the points, and over the spacing; and
largest part of the points that may be apart from all others.
"""


def without_codes(path: Path, z: Floats, nodata: Sequence[float]) -> Floats:
    """Heights with NaN where they have a value of `nodata`, or one that marks missing points.

    A ModelWarning has the value and the number of points of each, and names a value of `nodata` that does not
    occur.
    """
    z = z.copy()
    for value in nodata:
        same = np.isclose(z, value, rtol=1e-6, atol=0.0)
        z[same] = np.nan
        text = f"{path}: no height is {value:g}: expected one that --nodata names"
        if same.any():
            text = f"{path}: {same.sum()} of {z.size} heights are {value:g} (--nodata): they are holes"
        warnings.warn(text, ModelWarning, stacklevel=4)
    known = np.isin(z, (*CODES, *SMALL_CODES)) | (np.abs(z) >= HUGE)
    heights = z[~known & np.isfinite(z)]
    if not known.any() or not heights.size:
        return z
    low, high = float(heights.min()), float(heights.max())
    for value in np.unique(z[known]).tolist():
        outside = max(low - value, value - high)
        if abs(value) < HUGE and outside <= (high - low if value in SMALL_CODES else 0.0):
            continue
        same = z == value
        z[same] = np.nan
        text = f"{same.sum()} of {z.size} heights are {value:g}, which marks missing points: they are holes"
        warnings.warn(f"{path}: {text}", ModelWarning, stacklevel=4)
    return z


def _apart(z: Floats) -> np.ndarray:
    """Which heights are apart from all others, few of them, by more than the range of the others."""
    ordered = np.sort(z, axis=None)
    gaps = np.diff(ordered)
    i = int(gaps.argmax())
    low, high = ordered[: i + 1], ordered[i + 1 :]
    few, many = (low, high) if low.size < high.size else (high, low)
    if few.size > FEW * z.size or not gaps[i] > np.ptp(many):
        return np.zeros(z.shape, dtype=bool)
    return np.isin(z, few)


def warn_of_spikes(path: Path, x: Floats, y: Floats | None, z: Floats) -> None:
    """Give a ModelWarning with number and place of heights (ny, nx) that stand far above or below others."""
    from scipy.ndimage import median_filter

    above = np.abs(z - median_filter(z, size=3 if y is not None else (1, 3), mode="nearest"))
    usual = float(np.percentile(above, 99.0, method="lower"))
    spikes = above > max(SPIKE * usual, STEEP * float(np.diff(x).mean()))
    spikes |= _apart(z)
    if spikes.any():
        row, column = (int(place[0]) for place in np.nonzero(spikes))
        at = f"x = {x[column]:g}" + ("" if y is None else f", y = {y[row]:g}")
        text = f"{spikes.sum()} of {z.size} heights are spikes, the first at {at}: z = {z[row, column]:g}"
        wanted = "expected without them; --nodata leaves out a value"
        warnings.warn(f"{path}: {text}: {wanted}", ModelWarning, stacklevel=4)
