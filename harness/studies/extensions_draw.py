"""Sketches of docs/extensions.md: the facet of an inclined plane, and dilatancy laws beside each other."""

from __future__ import annotations

import numpy as np
from asperity.barton.joint import MOBILISED
from asperity.contract import Floats
from asperity.style import TWO, new_figure
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .concepts_draw import BLACK, BLUE, GREEN, NOTE, ORANGE, STONE, arrow, panel

SLOPE = float(np.tan(np.radians(35.0)))
HEIGHT = 0.6
"""Slope T at the foot and height H of the sketch."""

POINT, LIFT = 0.75, 0.62
"""Slip u and lift w - z of the sketch; the lift is an opening, to show the gap."""


def profile(u: Floats, height: float = HEIGHT) -> Floats:
    """Profile z of a facet at the slip u."""
    risen = -height * np.expm1(-np.maximum(u, 0.0) * SLOPE / height)
    return np.where(u > 0.0, risen, u * SLOPE)


def facet() -> Figure:
    """Draw the profile of a facet with the local separation, profiles, and the mobilised slope."""
    figure, (sketch, shapes, laws) = new_figure(TWO, 2.6, ncols=3)
    _profile_with_gap(sketch)
    u = np.linspace(-0.6, 2.4, 301)
    for height, omega, style, colour in (
        (1.2, 0.0, "-.", BLUE),
        (0.6, 0.0, "-", BLACK),
        (0.6, 0.5, "--", ORANGE),
        (0.6, 0.9, ":", ORANGE),
    ):
        label = f"H = {height:g}" + (rf", $\omega$ = {omega:g}" if omega else "")
        shapes.plot(u, (1.0 - omega) * profile(u, height), style, color=colour, label=label)
        shapes.axhline(height, color=BLACK, linewidth=0.4, linestyle=":")
    shapes.plot(u[u < 1.75], u[u < 1.75] * SLOPE, color=BLACK, linewidth=0.8, linestyle=(0, (1, 3)))
    shapes.text(0.95, 1.28, "plane of the paper", fontsize="x-small")
    shapes.legend(loc="lower right")
    title = r"(b) one slope at the foot; worn by $\omega$"
    panel(shapes, "slip $u$ up the plane", "profile $z$", title, ylim=(-1.3, 1.4))
    _laws(laws)
    return figure


def _profile_with_gap(ax: Axes) -> None:
    """Draw the profile as the lower side, a separation (u, w) and its gap and arc."""
    u = np.linspace(-0.6, 2.0, 261)
    z = profile(u)
    ax.fill_between(u, z, -0.6, color=STONE[0])
    ax.plot(u, z, color=BLACK, linewidth=1.4)
    ax.plot(u[u < 1.25], u[u < 1.25] * SLOPE, color=BLACK, linewidth=0.8, linestyle=(0, (1, 3)))
    foot = np.array([POINT, float(profile(np.array(POINT)))])
    slope = SLOPE * np.exp(-POINT * SLOPE / HEIGHT)
    along = np.array([1.0, slope]) / np.hypot(1.0, slope)
    normal = np.array([-along[1], along[0]])
    point = np.add(foot, (0.0, LIFT))
    arc = (u >= 0.0) & (u <= POINT)
    ax.plot(u[arc], z[arc], color=BLUE, linewidth=3.5, solid_capstyle="butt")
    ax.plot(*np.transpose([foot - 0.45 * along, foot + 0.75 * along]), color=BLACK, linewidth=0.8)
    gap = LIFT * normal[1]
    arrow(ax, foot, gap * normal, ORANGE)
    ax.plot(*np.transpose([foot + gap * normal, point]), ":", color=BLUE, linewidth=1.6)
    ax.plot(*np.transpose([foot, point]), ":", color=BLACK, linewidth=0.8)
    ax.plot(*point, "o", color=BLACK, markersize=4)
    ax.text(point[0] + 0.05, point[1], "$(u, w)$", va="center")
    ax.text(foot[0] + 0.03, foot[1] + 0.43, "$w - z$", fontsize="small")
    ax.text(*np.add(foot + 0.55 * gap * normal, (-0.07, -0.02)), "$g$", color=ORANGE, ha="right")
    ax.text(0.3, 0.0, "arc $A$", color=BLUE, fontsize="small")
    ax.text(
        foot[0] - 0.02, point[1] + 0.08, "$(w - z)\\,\\sin\\phi$", color=BLUE, ha="right", fontsize="small"
    )
    ax.annotate(r"$\phi$", np.add(foot, (0.8, 0.04)))
    ax.plot([foot[0], foot[0] + 0.75], [foot[1]] * 2, ":", color=BLACK, linewidth=0.8)
    ax.text(1.3, 1.0, "plane of the bond,\nslope $T$", va="center", fontsize="x-small")
    arrow(ax, (1.35, -0.4), (0.35, 0.0), BLACK)
    ax.text(1.72, -0.43, r"$\mathbf{e}$")
    arrow(ax, (1.35, -0.4), (0.0, 0.3), BLACK)
    ax.text(1.28, -0.08, "$N$", ha="right")
    ax.set_xlim(-0.6, 2.0)
    ax.set_ylim(-0.6, 1.35)
    ax.set_aspect("equal")
    ax.set_axis_off()
    ax.set_title(r"(a) gap $g$, $s_t = A + (w - z)\,\sin\phi$", **NOTE)


def _laws(ax: Axes) -> None:
    """Draw the mobilised slope of the facet beside the mobilised JRC of Barton, over the slip."""
    x = np.linspace(1.0, 100.0, 991)
    for ratio, style, colour in ((5.0, "--", ORANGE), (20.0, "-.", BLUE)):
        slope = np.exp(-(x - 1.0) / ratio)
        ax.semilogx(x, slope, style, color=colour, label=rf"$H/\tan\theta$ = {ratio:g} $\delta_p$")
    table = np.array([(1e-9, 0.0), *MOBILISED])
    ax.semilogx(*table.T, "o-", color=GREEN, markersize=3, label="Barton (1982)")
    ax.legend(loc="upper right", fontsize="x-small")
    x_label = r"slip over the slip at the peak, $\delta/\delta_p$"
    title = r"(c) $\tan\phi/\tan\theta$, and mobilised JRC"
    panel(ax, x_label, "dilation: share of its largest value", title, xlim=(0.2, 100.0), ylim=(-0.02, 1.4))
