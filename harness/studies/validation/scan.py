"""Profile of a fracture in granite (Sawayama, Jiang, Tsuji 2020): slopes by sampling length and direction."""

from __future__ import annotations

import sys
from collections.abc import Mapping

import numpy as np
from asperity.contract import Floats
from asperity.style import TWO, new_figure
from asperity.surface.scan import Scan
from asperity.surface.scan_files import read_scan
from asperity.surface.slopes import Facets, facets, nearest_regular
from asperity.tables import markdown
from matplotlib.figure import Figure

from ..concepts_draw import BLACK, BLUE, NOTE, ORANGE
from . import granite
from .common import DATA, Constants, Study

FILE = DATA / "inada.csv"
STEPS = (1, 4, 21, 64, 214)
"""Sampling lengths as multiples of the spacing of the profile, 0.0234 mm."""

DIRECTIONS = {"+x": 0.0, "-x": np.pi}
LIMITS = np.linspace(0.0, 0.98, 50)
"""Angles at which the facing length is compared with its fit, as fractions of the largest one."""


def sampled(scan: Scan, step: int) -> Facets:
    """Facets of the profile at a sampling length."""
    return facets(scan.sampled(step * scan.spacing))


def facing(found: Facets, direction: float) -> tuple[Floats, Floats]:
    """Angles, degrees, at which the facets face a slip, and their fractions of the nominal length."""
    angles = np.degrees(np.arctan(found.gradients @ [np.cos(direction), np.sin(direction)]))
    return angles[angles > 0.0], found.nominal[angles > 0.0]


def grasselli(angles: Floats, shares: Floats) -> tuple[float, float]:
    """Largest angle and C of L(angle) = L0 (1 - angle/largest)^C, by least squares of its logarithm."""
    largest = float(angles.max())
    left = np.array([shares[angles >= limit * largest].sum() for limit in LIMITS]) / shares.sum()
    x = np.log(1.0 - LIMITS)
    return largest, float(x @ np.log(left) / (x @ x))


def tables(_: Mapping[str, Constants]) -> dict[str, str]:
    """Table of the measures by sampling length and direction."""
    scan, body = read_scan(FILE), []
    for step in STEPS:
        found = sampled(scan, step)
        theta = nearest_regular(found, None, 2).theta
        cells = []
        for direction in DIRECTIONS.values():
            largest, C = grasselli(*facing(found, direction))
            slope = float(found.uphill(np.array([direction]))[1][0])
            cells += [f"{largest / (C + 1.0):.1f}", f"{slope:.3f}"]
        body.append([f"{step * scan.spacing:.2g}", f"{found.rms_slope:.3f}", *cells, f"{theta:.1f}"])
    head = ["sampling, mm", "rms slope"]
    head += [f"{name}: {what}" for name in DIRECTIONS for what in ("θ*max/(C + 1), °", "rms uphill")]
    return {"scan": markdown([*head, "theta of RT, °"], body)}


def draw(_: Mapping[str, Constants]) -> Figure:
    """Draw the profile, and theta of the nearest RT over the sampling length beside those of slip tests."""
    figure, (profile, angle) = new_figure(TWO, 2.7, ncols=2)
    scan = read_scan(FILE)
    profile.plot(scan.x, scan.z[0], color=BLACK, linewidth=0.7)
    profile.set_xlabel("x [mm]")
    profile.set_ylabel("height [mm]")
    profile.set_title("(a) Inada granite, tensile fracture", **NOTE)
    steps = np.unique(np.geomspace(1, 300, 16).round().astype(int))
    thetas = [nearest_regular(sampled(scan, int(step)), None, 2).theta for step in steps]
    angle.semilogx(
        steps * scan.spacing, thetas, "o-", color=BLUE, markersize=3, label="nearest RT of the profile"
    )
    for name, style in zip(granite.SPECIMENS, ("--", ":"), strict=True):
        theta = granite.closed_form(name)["theta"]
        angle.axhline(theta, linestyle=style, color=ORANGE, label=f"{name}, stages 5 and 6")
    angle.set_xlabel("sampling length [mm]")
    angle.set_ylabel("theta [degrees]")
    angle.legend()
    angle.set_title("(b) inclination of the planes", **NOTE)
    for ax in (profile, angle):
        ax.grid(alpha=0.3)
    return figure


STUDY = Study("scan", dict, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
