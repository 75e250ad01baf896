"""Shaken joints: rigid blocks in closed form, an elastic block that flutters, walls that rock."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache

import numpy as np
from asperity.contract import Floats
from asperity.tools.style import TWO, new_figure
from asperity.tools.tables import markdown
from matplotlib.figure import Figure

from ..concepts_draw import BLACK, BLUE, GREEN, panel
from .common import Constants, Study
from .shaken_points import ALPHA, MASS, RADIUS, G, joint, pulse, restitution, ride, rock, shaken
from .wall_runs import printed_by

KN = 2e5
"""Stiffness of the contact of the rigid mass."""

FACETS = (0.0, 10.0, 20.0)
"""Inclination of the plane of a pulse, degrees."""

RIGID = 0.8829
"""Slip of a rigid block after a sudden pulse .9 g for .5 s, mu .5: V^2/(2 mu g) (1 - mu/A)."""


def runs() -> dict[str, Constants]:
    """Run the models in FEniCSx."""
    columns = "value", "gained"
    return {name: dict(zip(columns, values, strict=False)) for name, values in printed_by("", "shaken")}


@cache
def climbed(theta: float, damped: bool) -> tuple[float, float, float]:
    """Slip along a plane after a pulse 1.5 g for .1 s, closed and by the law, and the largest height, mm."""
    mu, A, t0 = 0.5, 1.5, 0.1
    sine, cosine = np.sin(np.radians(theta)), np.cos(np.radians(theta))
    up = A * G * cosine - G * sine - mu * G * (cosine + A * sine)
    length = 0.5 * up * t0**2 * (1.0 + up / (G * sine + mu * G * cosine))
    c = 2.0 * np.sqrt(KN * MASS) if damped else 0.0
    dt = 1e-4
    s, _ = shaken(joint(theta, mu, KN, c), pulse(A, t0, dt), 0.45, dt)
    return 1e3 * length, 1e3 * float(np.hypot(*s[-1, :2])), 1e3 * float(s[:, 0].max())


@cache
def impact(xi: float) -> float:
    """Share of the velocity that an impact leaves."""
    kn = 2e4
    none = np.zeros(3)
    law = joint(0.0, 0.3, kn, 2.0 * xi * np.sqrt(kn * MASS))
    _, v, _ = ride(law, 5e-3 / np.sqrt(kn / MASS), 1200, lambda _: none, none, np.array([-0.01, 0.0, 0.0]))
    return float(v[-1, 0]) / 0.01


def base_motion() -> Floats:
    """Newmark's pulse and Den Hartog's harmonic base: closed form and law, mm, (2, 2)."""
    mu, A, t0, dt = 0.5, 1.0, 0.1, 1e-4
    V = A * G * t0
    s, _ = shaken(joint(0.0, mu, KN), pulse(A, t0, dt), 0.35, dt)
    first = V**2 / (2.0 * mu * G) * (1.0 - mu / A), s[-1, 1]
    mu, A, w = 0.25, 0.5, 4.0 * np.pi
    s, _ = shaken(joint(0.0, mu, KN), lambda t: A * G * np.sin(w * t), 3.0, 2e-4)
    second = 2.0 * A * G / w**2 * np.sqrt(1.0 - (0.5 * np.pi * mu / A) ** 2), np.ptp(s[-2500:, 1])
    return 1e3 * np.array([first, second])


def _row(name: str, quantity: str, closed: float, law: float, digits: int) -> list[str]:
    """Row of the table of the rigid blocks."""
    away = f"{100.0 * (law / closed - 1.0):+.2f} %"
    return [name, quantity, f"{closed:.{digits}f}", f"{law:.{digits}f}", away]


def tables(results: Mapping[str, Constants]) -> dict[str, str]:
    """Closed forms and law of rigid blocks; numbers of the elastic ones."""
    rows = []
    names = "pulse 1 g, 0.1 s", "harmonic base 0.5 g, 2 Hz"
    for name, (closed, law) in zip(names, base_motion(), strict=True):
        rows.append(_row(name, "slip, mm", closed, law, 3))
    for theta in FACETS[1:]:
        closed, law, _ = climbed(theta, True)
        rows.append(_row(f"pulse 1.5 g on a plane of {theta:g}°, dashpot", "slip, mm", closed, law, 3))
        top, high = closed * np.sin(np.radians(theta)), climbed(theta, False)[2]
        rows.append(_row(f"the same without dashpot, {theta:g}°", "largest height, mm", top, high, 3))
    period = 4.0 * np.arccosh(2.0) / np.sqrt(0.75 * G / RADIUS)
    two = rock(2, 1.0, 0.5)
    many = rock(21, 1.0, 0.3)[1]
    ratio = 1.0 - 1.5 * np.sin(ALPHA) ** 2
    rows += [
        _row("rocking on two edges (Housner)", "period, s", period, two[0], 4),
        _row("", "ratio of velocities", ratio, two[1], 4),
        ["rocking on 21 points", "ratio of velocities", "0.9640 to 1", f"{many:.4f}", ""],
    ]
    value = {name: numbers["value"] for name, numbers in results.items()}
    planes = []
    for theta in FACETS:
        closed, two, space = climbed(theta, True)[0], value[f"climb2 {theta:g}"], value[f"climb3 {theta:g}"]
        away = f"{100.0 * (1e3 * space / closed - 1.0):+.2f} %"
        planes.append(
            [f"{theta:g}°", *(f"{length:.3f}" for length in (closed, 1e3 * two, 1e3 * space)), away]
        )
    return {
        "planes": markdown(["plane", "closed form", "two dimensions", "space", "error"], planes),
        "rigid": markdown(["case", "quantity", "closed form", "law", "error"], rows),
        "growth": f"The amplitude grows by {value['growth']:.1f}/s without damping, with a dashpot c = 5 "
        f"(xi 0.2) by {value['growth c']:.1f}/s,\non 12 instead of 6 cells by {value['growth fine']:.1f}/s; "
        f"with damping of the solids, beta = 1e-5 s, it changes by {value['growth beta']:.1f}/s.",
        "slip": f"The block slips {value['slip']:.4f} m, with half the step {value['slip half']:.4f} m, "
        f"on 12 cells {value['slip fine']:.4f} m.",
        "energy": f"Of their energy at the start they have at most {value['wall']:.3f} (five blocks) and "
        f"{value['edges']:.3f} (one block on two edges).",
    }


def draw(_: Mapping[str, Constants]) -> Figure:
    """Draw the restitution over the damping, and the slip after a pulse."""
    figure, (left, right) = new_figure(TWO, 2.9, ncols=2)
    xi = np.linspace(0.01, 2.0, 100)
    ratios = [restitution(damping) if abs(damping - 1.0) > 1e-6 else np.exp(-2.0) for damping in xi]
    left.plot(xi, ratios, color=BLUE, label="closed form")
    points = np.array([0.1, 0.3, 0.5, 0.7, 0.99, 1.5, 2.0])
    left.plot(
        points, [impact(float(damping)) for damping in points], "o", color=BLACK, markersize=4, label="law"
    )
    panel(left, "damping xi = c/(2 sqrt(kn m)) [-]", "velocity after over before [-]")
    dt = 1e-4
    for theta, colour in zip(FACETS, (BLUE, GREEN, BLACK), strict=True):
        s, _ = shaken(joint(theta, 0.5, KN, 2.0 * np.sqrt(KN * MASS)), pulse(1.5, 0.1, dt), 0.45, dt)
        along, time = 1e3 * np.hypot(s[:, 0], s[:, 1]), dt * np.arange(1, len(s) + 1)
        right.plot(time, along, color=colour, label=f"{theta:g}°")
    panel(right, "time [s]", "slip along the plane [mm]")
    for ax in (left, right):
        ax.legend()
    return figure


STUDY = Study("dynamics", runs, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
