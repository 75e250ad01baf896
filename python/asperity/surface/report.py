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
    points = " x ".join(f"{len(axis)}" for axis in original.axes)
    extent = " x ".join(f"{np.ptp(axis):g}" for axis in original.axes)
    order = np.argsort(found.slopes)
    below = np.cumsum(found.nominal[order])
    at = np.searchsorted(below, np.array(PERCENT) / 100 * below[-1]).clip(max=len(order) - 1)
    angles = np.degrees(np.arctan(found.slopes[order][at]))
    steep = ", ".join(f"{p} %: {angle:.2f}" for p, angle in zip(PERCENT, angles, strict=True))
    heights = scan.heights()
    tilt = found.tilt if found.tilt > ROUNDING else 0.0
    lean = lean if (lean := scan.lean()) > ROUNDING else 0.0
    ends = slips.residual.min(), slips.residual.max()
    low, high = ("locks" if np.isinf(value) else f"{value:.4f}" for value in ends)
    filtered = "" if options.smooth is None else f", smoothed over {options.smooth:g}"
    return [
        f"scan        {'profile' if scan.is_profile else 'map'}, {points} points, {extent} {unit}{filtered}",
        f"level       average plane inclined by {tilt:.4g} degrees, rotated to level; "
        f"{lean:.3g} degrees from the least-squares plane",
        f"facets      {len(found.gamma)} at {_apart(scan)} {unit}; true/nominal area {found.ratio:.4f}",
        f"heights     rms {heights.std():.4g} {unit}, range {np.ptp(heights):.4g} {unit}",
        f"slopes      mean {found.mean_slope:.4f}, rms {found.rms_slope:.4f} (tangent)",
        f"inclined    {steep} degrees (fraction of the nominal area)",
        f"residual    {low} to {high} |sigma_N| over {len(slips.angles)} directions, "
        f"mu = {slips.mu:g}: set by the steepest facet along the slip",
    ]


def _apart(scan: Scan) -> str:
    low, high = scan.steps()
    return f"{high:g}" if high <= low * (1.0 + 2.0 * EVEN) else f"{low:g} to {high:g}"
