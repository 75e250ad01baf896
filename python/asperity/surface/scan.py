"""A scanned profile or height map: spacing, sampling, filter and average plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid
from scipy.ndimage import correlate1d

from .. import contract
from ..contract import Floats

LEAST_POINTS = 8
"""Smallest number of points along a direction of a scan."""

EVEN = 0.05
"""Points count as evenly spaced if they deviate by at most this fraction of the spacing (rounded files)."""

GAUSS = float(np.sqrt(np.log(2.0) / np.pi))
"""Constant alpha of the Gaussian filter: a wave of the cut-off length is halved (ISO 16610-21)."""


@dataclass(frozen=True, eq=False)
class Scan:
    """Heights z (ny, nx) over x (nx,) and y (ny,) in the same unit; a profile has no y, and ny is 1.

    Raises ValueError for other shapes, for what is not finite and for positions that do not increase.
    """

    x: Floats
    y: Floats | None
    z: Floats
    unit: str = "mm"

    def __post_init__(self) -> None:
        """Check shapes and values."""
        for name in ("x", "z") if self.y is None else ("x", "y", "z"):
            numbers = contract.array(name, getattr(self, name))
            if not np.isfinite(numbers).all():
                raise ValueError(f"{name}: expected finite numbers")
            object.__setattr__(self, name, numbers)
        for name, positions in zip("xy", self.axes, strict=False):
            if positions.ndim != 1 or len(positions) < 2 or not (np.diff(positions) > 0.0).all():
                raise ValueError(f"{name}: expected two or more positions that increase")
        expected = (1 if self.y is None else len(self.y), len(self.x))
        if self.z.shape != expected:
            raise ValueError(f"z has shape {self.z.shape}: expected (ny, nx) = {expected}")

    @property
    def is_profile(self) -> bool:
        """Whether the scan is a profile."""
        return self.y is None

    @property
    def spacing(self) -> float:
        """Largest distance of neighbouring points along an axis, length."""
        return max(float(np.diff(axis).max()) for axis in self.axes)

    @property
    def extent(self) -> float:
        """Shortest side, length."""
        return min(float(axis[-1] - axis[0]) for axis in self.axes)

    def steps(self) -> tuple[float, float]:
        """Smallest and largest distance of neighbouring points along an axis, length."""
        return min(float(np.diff(axis).min()) for axis in self.axes), self.spacing

    def sampled(self, length: float) -> Scan:
        """Scan with points `length` apart, by straight lines between the given points.

        Raises ValueError for a length shorter than the spacing or one that leaves too few points.
        """
        if not length >= self.spacing * (1.0 - 1.0e-9):
            raise ValueError(f"sampling length {length:g}: expected at least the spacing, {self.spacing:g}")
        if not length <= longest(self):
            raise ValueError(
                f"sampling length {length:g}: expected at most {longest(self):g}, for {LEAST_POINTS} points"
            )
        x, z = _interpolated(self.x, self.z, length)
        if self.y is None:
            return Scan(x, None, z, self.unit)
        y, z = _interpolated(self.y, z.T, length)
        return Scan(x, y, z.T, self.unit)

    def smoothed(self, cut_off: float) -> Scan:
        """Scan after a Gaussian filter of this cut-off length, which preserves the mean plane.

        Raises ValueError where the points are not evenly spaced or the length is not above the spacing.
        """
        if not self.spacing < cut_off <= self.extent:
            raise ValueError(
                f"smoothing length {cut_off:g}: expected more than the spacing, {self.spacing:g}, "
                f"and at most {self.extent:g}"
            )
        plane = _mean_plane(self)
        z = _filtered(self.x, self.z - plane, cut_off)
        if self.y is not None:
            z = _filtered(self.y, z.T, cut_off).T
        return Scan(self.x, self.y, z + plane, self.unit)

    def heights(self) -> Floats:
        """Distances (ny, nx) from the average plane, perpendicular to it; their mean is 0."""
        z = self.z - _mean_plane(self)
        levelled: Floats = (z - z.mean()) / np.hypot(1.0, np.hypot(*_mean_gradient(self)))
        return levelled

    def lean(self) -> float:
        """Angle between the average plane and that of least squares, degrees, due to the ends of the scan."""
        a = np.polyfit(self.x - self.x.mean(), self.z.mean(axis=0), 1)[0]
        b = 0.0 if self.y is None else np.polyfit(self.y - self.y.mean(), self.z.mean(axis=1), 1)[0]
        fitted, average = np.array([[1.0, a, b], [1.0, *_mean_gradient(self)]])
        return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(fitted, average)), fitted @ average)))

    @property
    def axes(self) -> tuple[Floats, ...]:
        """Positions along x and, of a map, along y."""
        return (self.x,) if self.y is None else (self.x, self.y)


def even(axis: Floats) -> Floats:
    """Evenly spaced positions from the first to the last; their number is the same."""
    places: Floats = np.linspace(axis[0], axis[-1], len(axis))
    return places


def longest(scan: Scan) -> float:
    """Longest sampling length with LEAST_POINTS points, up to rounding."""
    return scan.extent / (LEAST_POINTS - 1) * (1.0 + 1.0e-9)


def lengths_of(scan: Scan) -> Floats:
    """Sampling lengths: the spacing, twice the spacing, and so on."""
    count = int(np.floor(np.log2(longest(scan) / scan.spacing))) + 1
    lengths: Floats = scan.spacing * 2.0 ** np.arange(max(count, 1))
    return lengths


def _mean_gradient(scan: Scan) -> tuple[float, float]:
    """Slopes of the average plane along x and y."""
    total = (scan.z[:, -1] - scan.z[:, 0]) / (scan.x[-1] - scan.x[0])
    if scan.y is None:
        return float(total[0]), 0.0
    # the mean over a side is by the trapezoid rule, as for the facets
    sides = (scan.z[-1] - scan.z[0]) / (scan.y[-1] - scan.y[0])
    a, b = trapezoid(total, scan.y), trapezoid(sides, scan.x)
    return float(a / (scan.y[-1] - scan.y[0])), float(b / (scan.x[-1] - scan.x[0]))


def _mean_plane(scan: Scan) -> Floats:
    """Heights of the average plane, zero at the first point, (ny, nx)."""
    a, b = _mean_gradient(scan)
    y = np.zeros(1) if scan.y is None else scan.y - scan.y[0]
    plane: Floats = np.add.outer(b * y, a * (scan.x - scan.x[0]))
    return plane


def _interpolated(x: Floats, z: Floats, length: float) -> tuple[Floats, Floats]:
    """Points at the distance `length` from each other, and the heights (..., n) there."""
    at = x[0] + length * np.arange(int(np.floor((x[-1] - x[0]) / length + 1.0e-9)) + 1)
    return at, np.array([np.interp(at, x, row) for row in z])


def _filtered(x: Floats, z: Floats, cut_off: float) -> Floats:
    """Gaussian mean along the rows; at the ends it is the mean of the existing points."""
    steps = np.diff(x)
    if np.abs(x - even(x)).max() > EVEN * steps.mean():
        raise ValueError(
            f"smoothing: the points are {steps.min():g} to {steps.max():g} apart: expected even spacing"
        )
    reach = min(int(np.ceil(cut_off / steps.mean())), len(x) - 1)
    kernel = np.exp(-np.pi * (np.arange(-reach, reach + 1) * steps.mean() / (GAUSS * cut_off)) ** 2)
    found: Floats = correlate1d(z, kernel, mode="constant") / correlate1d(
        np.ones(len(x)), kernel, mode="constant"
    )
    return found
