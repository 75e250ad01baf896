"""What `asperity surface` prints about a scan, and remarks on doubtful properties."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np

from . import slopes
from .scan import EVEN, Scan, longest
from .slopes import Facets, Slips

ROUNDING = 1.0e-9
"""Errors and angles (degrees) below this are shown as 0."""

PLAUSIBLE = (3.0e-3, 3.0)
"""Rms slopes beyond these give a remark, because z may be in another unit than x."""

GROWTH = 1.1
"""A remark is printed if half the sampling length raises the rms slope by this factor."""

UNLIKE = 1.5
"""Ratio of the largest to the smallest spacing that gives a remark, because slopes depend on the spacing."""

PERCENT = (50, 90, 99, 100)
"""Percentiles of the inclination that are printed."""


def remarks(scan: Scan, found: Facets, direction: float) -> Iterator[str]:
    """Remarks on units and scale."""
    rms, unit = found.rms_slope, scan.unit
    if rms > slopes.FLATNESS and not PLAUSIBLE[0] <= rms <= PLAUSIBLE[1]:
        yield f"an rms slope of {rms:.2g} is unusual: are x and z in the same unit?"
    low, high = scan.steps()
    if high > UNLIKE * low:
        yield f"points are {low:g} to {high:g} {unit} apart; --sampling {high:g} gives them one scale"
    length = 2.0 * scan.spacing
    if rms > slopes.FLATNESS and length <= longest(scan):
        coarse = slopes.facets(scan.sampled(length), direction).rms_slope
        if rms > GROWTH * coarse:
            yield (
                f"the rms slope at {scan.spacing:g} {unit} is {rms / coarse - 1.0:.0%} above that at "
                f"{length:g}: there is no plateau, so the planes depend on the scale, which --sampling and "
                "--smooth set"
            )


def report(
    original: Scan,
    scan: Scan,
    found: Facets,
    slips: Slips,
    options: argparse.Namespace,
) -> list[str]:
    """Lines that describe the scan."""
    unit = scan.unit
    points = (
        f"{len(original.x)} points" if original.y is None else f"{len(original.x)} x {len(original.y)} points"
    )
    extent = f"{np.ptp(original.x):g} {unit}" if original.y is None else (
        f"{np.ptp(original.x):g} x {np.ptp(original.y):g} {unit}")  # fmt: skip
    order = np.argsort(found.slopes)
    below = np.cumsum(found.nominal[order])
    at = [
        found.slopes[order][min(np.searchsorted(below, p / 100 * below[-1]), len(order) - 1)] for p in PERCENT
    ]
    steep = ", ".join(f"{p} %: {np.degrees(np.arctan(t)):.2f}" for p, t in zip(PERCENT, at, strict=True))
    heights = scan.heights()
    tilt = found.tilt if found.tilt > ROUNDING else 0.0
    lean = lean if (lean := scan.lean()) > ROUNDING else 0.0
    low, high = slips.residual.min(), slips.residual.max()
    shown = ["locks" if np.isinf(value) else f"{value:.4f}" for value in (low, high)]
    filtered = "" if options.smooth is None else f", smoothed over {options.smooth:g}"
    return [
        f"scan        {'profile' if scan.is_profile else 'map'}, {points}, {extent}{filtered}",
        f"level       average plane inclined by {tilt:.4g} degrees, rotated to level; "
        f"{lean:.3g} degrees from the least-squares plane",
        f"facets      {len(found.gamma)} at {_apart(scan)} {unit}; true/nominal area {found.ratio:.4f}",
        f"heights     rms {heights.std():.4g} {unit}, range {np.ptp(heights):.4g} {unit}",
        f"slopes      mean {found.mean_slope:.4f}, rms {found.rms_slope:.4f} (tangent)",
        f"inclined    {steep} degrees (fraction of the nominal area)",
        f"residual    {shown[0]} to {shown[1]} |sigma_N| over {len(slips.angles)} directions, "
        f"mu = {slips.mu:g}: set by the steepest facet along the slip",
    ]


def _apart(scan: Scan) -> str:
    low, high = scan.steps()
    return f"{high:g}" if high <= low * (1.0 + 2.0 * EVEN) else f"{low:g} to {high:g}"
