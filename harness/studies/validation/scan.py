"""A profile of a fracture in granite and a map of a joint: slopes by sampling length and direction."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from asperity.contract import Floats
from asperity.pattern import direction_vector
from asperity.tools.style import TWO, new_figure
from asperity.tools.surface.scan import Scan
from asperity.tools.surface.scan_files import read_scan
from asperity.tools.surface.slopes import Facets, facets, nearest_regular
from asperity.tools.tables import markdown
from matplotlib.figure import Figure
from scipy.optimize import curve_fit

from ..concepts_draw import BLACK, BLUE, ORANGE, panel
from . import granite
from .common import DATA, Constants, Study

FILE = DATA / "inada.csv"
SAMPLE = "example_surface.stl"
MEASURE = "θ*max/(C + 1) [°]"
STEPS = (1, 21, 214)
"""Sampling lengths as multiples of the spacing of the profile, 0.0234 mm."""

DIRECTIONS = {"+x": 0.0, "-x": np.pi}
LIMITS = np.linspace(0.0, 0.98, 50)
"""Angles at which the facing length is compared with its fit, as fractions of the largest one."""


def sampled(scan: Scan, step: int) -> Facets:
    """Facets of the profile at a sampling length."""
    return facets(scan.sampled(step * scan.steps[1]))


def facing(surface: Facets, direction: float) -> tuple[Floats, Floats]:
    """Angles, degrees, at which the facets face a slip, and their fractions of the nominal length."""
    angles = np.degrees(np.arctan(surface.gradients @ [np.cos(direction), np.sin(direction)]))
    return angles[angles > 0.0], surface.nominal[angles > 0.0]


def grasselli(angles: Floats, shares: Floats) -> tuple[float, float]:
    """Largest angle and C of L(angle) = L0 (1 - angle/largest)^C, by least squares."""
    largest = float(angles.max())
    shares_above = np.array([shares[angles >= limit * largest].sum() for limit in LIMITS]) / shares.sum()
    C = curve_fit(lambda x, C: x**C, 1.0 - LIMITS, shares_above, 2.0)[0]
    return largest, float(C[0])


def by_direction(surface: Facets, direction: float) -> Constants:
    """Grasselli's measure in degrees, and the rms slope that faces a slip."""
    largest, C = grasselli(*facing(surface, direction))
    uphill = surface.slips(np.array([direction]), 0.0).uphill
    return {MEASURE: largest / (C + 1.0), "rms uphill": float(uphill[1, 0])}


def by_length(scan: Scan, step: int) -> Constants:
    """Measures of a profile at a sampling length."""
    profile = sampled(scan, step)
    row = {"sampling [mm]": step * scan.steps[1], "rms slope": profile.rms_slope}
    uphill = profile.slips(np.array([*DIRECTIONS.values()]), 0.0).uphill[1]
    row |= {f"{name}: rms uphill": float(slope) for name, slope in zip(DIRECTIONS, uphill, strict=True)}
    return row | {"theta of RT [°]": nearest_regular(profile, None, 2).theta}


def measured() -> dict[str, Constants]:
    """Measures of the surface that is no part of the project: the current folder has its file."""
    try:
        from surface_roughness import Surface
    except ImportError:
        raise ValueError("--fit: expected surface-roughness: pip install surface-roughness") from None
    rows = {}
    peer = np.ravel(Surface(SAMPLE, verbose=False).thetamax_cp1("thetamax_cp1"))
    surface = facets(read_scan(Path(SAMPLE)))
    for angle in range(0, 360, 30):
        e = direction_vector(angle)
        row = {"slip along [°]": float(angle), f"surface-roughness: {MEASURE}": peer[angle // 5]}
        row |= by_direction(surface, np.radians(angle))
        rows[f"sample {angle}"] = row | {"rms slope along": float(np.sqrt(e @ surface.fabric @ e))}
    return rows


def tables(results: Mapping[str, Constants]) -> dict[str, str]:
    """Tables of the measures by sampling length and direction."""
    scan = read_scan(FILE)
    rough = [by_length(scan, step) for step in STEPS]
    return {"scan": _table(rough), "sample": _table([*results.values()][::2])}


def _table(rows: Sequence[Constants]) -> str:
    """Table of rows that have the same names."""
    digits = {"[mm]": ".2g", "[°]": ".1f"}
    forms = [digits.get(name.rpartition(" ")[2], ".3f") for name in rows[0]]
    body = [[f"{v:{form}}" for v, form in zip(row.values(), forms, strict=True)] for row in rows]
    return markdown([*rows[0]], body)


def draw(_: Mapping[str, Constants]) -> Figure:
    """Draw the profile, and theta of the nearest RT over the sampling length beside those of slip tests."""
    figure, (profile, angle) = new_figure(TWO, 2.7, ncols=2)
    scan = read_scan(FILE)
    profile.plot(scan.x, scan.z[0], color=BLACK, linewidth=0.7)
    panel(profile, "x [mm]", "height [mm]", "(a) Inada granite, tensile fracture")
    steps = np.unique(np.geomspace(1, 300, 16).round().astype(int))
    thetas = [nearest_regular(sampled(scan, int(step)), None, 2).theta for step in steps]
    label = "nearest RT of the profile"
    angle.semilogx(steps * scan.steps[1], thetas, "o-", color=BLUE, markersize=3, label=label)
    for name, style in zip(granite.SPECIMENS, ("--", ":"), strict=True):
        theta = granite.closed_form(name)["theta"]
        angle.axhline(theta, linestyle=style, color=ORANGE, label=f"{name}, stages 5 and 6")
    angle.legend()
    panel(angle, "sampling length [mm]", "theta [degrees]", "(b) inclination of the planes")
    return figure


STUDY = Study("scan", measured, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
