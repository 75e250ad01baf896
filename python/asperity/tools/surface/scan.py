"""A scanned profile or height map: spacing, sampling, filter and average plane."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid
from scipy.ndimage import gaussian_filter1d

from ... import contract
from ...contract import Floats

LEAST_POINTS = 8  # smallest number of points along a direction of a scan
EVEN = 0.05
"""Points count as evenly spaced if they deviate by at most this fraction of the spacing (rounded files)."""

DEVIATION = float(np.sqrt(0.5 * np.log(2.0)) / np.pi)
"""Of the Gaussian filter over its cut-off length, a wave of which it halves (ISO 16610-21)."""


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
    def axes(self) -> tuple[Floats, ...]:
        """Positions along x and, of a map, along y."""
        return (self.x,) if self.y is None else (self.x, self.y)

    @property
    def steps(self) -> tuple[float, float]:
        """Smallest and largest distance of neighbouring points along an axis, length."""
        apart = np.concatenate([np.diff(axis) for axis in self.axes])
        return float(apart.min()), float(apart.max())

    @property
    def extent(self) -> float:
        """Shortest side, length."""
        return float(min(map(np.ptp, self.axes)))

    @property
    def longest(self) -> float:
        """Longest sampling length with LEAST_POINTS points, up to rounding."""
        return self.extent / (LEAST_POINTS - 1) * (1.0 + 1.0e-9)

    @property
    def lengths(self) -> Floats:
        """Sampling lengths: the largest distance of points, twice that, and so on."""
        count = int(np.floor(np.log2(self.longest / self.steps[1]))) + 1
        return self.steps[1] * 2.0 ** np.arange(max(count, 1), dtype=float)

    @property
    def gradient(self) -> tuple[float, float]:
        """Slopes of the average plane along x and y; means are by the trapezoid rule, as for facets."""
        along = (self.z[:, -1] - self.z[:, 0]) / np.ptp(self.x)
        if self.y is None:
            return float(along[0]), 0.0
        across = (self.z[-1] - self.z[0]) / np.ptp(self.y)
        return trapezoid(along, self.y) / np.ptp(self.y), trapezoid(across, self.x) / np.ptp(self.x)

    @property
    def plane(self) -> Floats:
        """Heights (ny, nx) of the average plane, zero at the first point."""
        a, b = self.gradient
        y = np.zeros(1) if self.y is None else self.y - self.y[0]
        z: Floats = np.add.outer(b * y, a * (self.x - self.x[0]))
        return z

    @property
    def heights(self) -> Floats:
        """Distances (ny, nx) from the average plane, perpendicular to it; their mean is 0."""
        z = self.z - self.plane
        heights: Floats = (z - z.mean()) / np.hypot(1.0, np.hypot(*self.gradient))
        return heights

    @property
    def lean(self) -> float:
        """Angle between the average plane and that of least squares, degrees, due to the ends of the scan."""
        fitted = [np.polyfit(axis, self.z.mean(axis=k), 1)[0] for k, axis in enumerate(self.axes)]
        least, average = (1.0, *fitted, 0.0)[:3], (1.0, *self.gradient)
        return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(least, average)), np.dot(least, average))))

    def sampled(self, length: float) -> Scan:
        """Scan with points `length` apart, by straight lines between the given points.

        Raises ValueError for a length shorter than the spacing or one that leaves too few points.
        """
        least = self.steps[1]
        if not least * (1.0 - 1.0e-9) <= length <= self.longest:
            limit = f"at most {self.longest:g}, for {LEAST_POINTS} points"
            if length < least * (1.0 - 1.0e-9):
                limit = f"at least the spacing, {least:g}"
            raise ValueError(f"sampling length {length:g}: expected {limit}")

        def interpolated(x: Floats, z: Floats) -> tuple[Floats, Floats]:
            at = x[0] + length * np.arange(int(np.floor(np.ptp(x) / length + 1.0e-9)) + 1)
            return at, np.array([np.interp(at, x, row) for row in z])

        return self._along(self.z, interpolated)

    def smoothed(self, cut_off: float) -> Scan:
        """Scan after a Gaussian filter of this cut-off length, which preserves the mean plane.

        Near the ends it is the mean of the points that are there.  Raises ValueError where the points are not
        evenly spaced or the length is not above the spacing.
        """
        if not self.steps[1] < cut_off <= self.extent:
            raise ValueError(
                f"smoothing length {cut_off:g}: expected more than the spacing, {self.steps[1]:g}, "
                f"and at most {self.extent:g}"
            )

        def filtered(x: Floats, z: Floats) -> tuple[Floats, Floats]:
            steps = np.diff(x)
            if np.abs(x - even(x)).max() > EVEN * steps.mean():
                apart = f"{steps.min():g} to {steps.max():g} apart"
                raise ValueError(f"smoothing: the points are {apart}: expected even spacing")
            size = DEVIATION * cut_off / steps.mean()
            form = {"sigma": size, "mode": "constant", "truncate": 6.0}
            return x, gaussian_filter1d(z, **form) / gaussian_filter1d(np.ones(len(x)), **form)

        scan = self._along(self.z - self.plane, filtered)
        return Scan(scan.x, scan.y, scan.z + self.plane, self.unit)

    def _along(self, z: Floats, change: Callable[[Floats, Floats], tuple[Floats, Floats]]) -> Scan:
        """Scan with heights z after a change of positions and rows of heights along x, and along y."""
        x, z = change(self.x, z)
        if self.y is None:
            return Scan(x, None, z, self.unit)
        y, z = change(self.y, z.T)
        return Scan(x, y, z.T, self.unit)


def even(axis: Floats) -> Floats:
    """Evenly spaced positions from the first to the last; their number is the same."""
    return np.linspace(axis[0], axis[-1], len(axis))
