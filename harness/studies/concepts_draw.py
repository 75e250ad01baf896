"""Sketches of a rough joint: its sides, axes, planes and facets, and dilatancy laws beside each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from asperity.contract import Floats
from asperity.pattern import Pattern
from asperity.tools.barton.joint import MOBILISED
from asperity.tools.pattern_pictures import GREYS, STONE, plan
from asperity.tools.style import COLOURS, TWO, new_figure
from matplotlib.axes import Axes
from matplotlib.figure import Figure

BLUE, ORANGE, GREEN, BLACK = COLOURS[:4]
FACING = "#F6C7A5"
"""Fill of a plane that faces the slip."""

NOTE = {"fontsize": "small"}


def panel(ax: Axes, x: str = "", y: str = "", title: str = "", **limits: object) -> None:
    """Give a panel its labels, title, limits and grid."""
    ax.set(xlabel=x, ylabel=y, **limits)
    ax.set_title(title, **NOTE)
    ax.grid(alpha=0.3)


RISE = float(np.tan(np.radians(30.0)))
CORNERS = 0.0, 0.5, 1.5, 2.0, 3.0, 3.5, 4.5, 5.0, 6.0, 6.5
PROFILE = np.column_stack([CORNERS, RISE * np.array([0, 0, 1, 1, 0, 0, 1, 1, 0, 0])])
"""Slope of 30 degrees; corners (x, z) of a trapezoidal profile, a third of whose length is flat."""


def bodies(ax: Axes, s: tuple[float, float]) -> None:
    """Section through a joint whose upper side has moved by s = (s_N, s_Tx)."""
    lower, upper = PROFILE, np.add(PROFILE, (s[1], s[0]))
    floor, roof = -0.8, 2.1
    for line, level, fill in ((lower, floor, STONE[0]), (upper, roof, STONE[1])):
        outline = np.vstack([line, (line[-1, 0], level), (line[0, 0], level)])
        ax.fill(*outline.T, facecolor=fill, edgecolor="none")
        ax.plot(*line.T, color="black", linewidth=1.2)
    ax.set_xlim(-0.1, 7.4)
    ax.set_ylim(floor, roof)
    ax.set_aspect("equal")
    ax.set_axis_off()


def arrow(ax: Axes, start: Sequence[float], step: Sequence[float], colour: str, **options: object) -> None:
    """Arrow from a point by a step."""
    end = np.add(start, step)
    style = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.5, "shrinkA": 0, "shrinkB": 0} | options
    ax.annotate("", end, start, arrowprops=style)


def joint() -> Figure:
    """The two sides, the axes and the separation; the plane that faces a slip; the planes of the RIE."""
    figure, axes = new_figure(TWO, 3.9, nrows=2, ncols=2)
    apart, climbing, traction, planes = axes
    s = (0.75, 0.55)
    bodies(apart, s)
    crest = np.add(PROFILE[2], (0.25, 0.0))
    arrow(apart, crest, (s[1], s[0]), ORANGE)
    legs = np.add(crest, [(0.0, 0.0), (s[1], 0.0), (s[1], s[0])])
    apart.plot(*legs.T, ":", color=ORANGE, linewidth=1.2)
    apart.text(crest[0] + 0.12, crest[1] + 0.3, r"$\mathbf{s}$", color=ORANGE, ha="right")
    apart.text(crest[0] + s[1] + 0.06, crest[1] + 0.3, "$s_N$", color=ORANGE)
    apart.text(crest[0] + 0.2, crest[1] - 0.25, "$s_{Tx}$", color=ORANGE)
    origin = (5.0, -0.55)
    for step, name, place in (((0.0, 0.55), "$N$", (-0.3, 0.35)), ((0.75, 0.0), "$T_x$", (0.8, -0.1))):
        arrow(apart, origin, step, BLACK)
        apart.text(*np.add(origin, place), name)
    # T_y = N x T_x points away from the reader
    apart.plot(*origin, "o", color=BLACK, markersize=8, markerfacecolor="white")
    apart.plot(*origin, "x", color=BLACK, markersize=5)
    apart.text(origin[0] - 0.42, origin[1] - 0.1, "$T_y$")
    apart.text(0.15, -0.6, "lower side", **NOTE)
    apart.text(0.75, 1.85, "upper side", **NOTE)
    title = r"(a) separation $\mathbf{s}$ = displacement of the upper side less that of the lower"
    apart.set_title(title, **NOTE)

    slip = 0.55
    bodies(climbing, (slip * RISE, slip))
    for k in (1, 5):
        climbing.plot(*PROFILE[k : k + 2].T, color=ORANGE, linewidth=4, solid_capstyle="butt")
        climbing.plot(*PROFILE[k + 2 : k + 4].T, color=BLUE, linewidth=4, solid_capstyle="butt")
    arrow(climbing, (2.3, 1.85), (1.0, 0.0), BLACK)
    climbing.text(3.4, 1.78, r"slip $s_{Tx} > 0$", **NOTE)
    climbing.text(0.35, -0.35, "faces the slip: in contact, climbed", color=ORANGE, **NOTE)
    climbing.text(2.6, -0.65, "does not face it: opens", color=BLUE, **NOTE)
    title = r"(b) fully damaged: sliding up by $s_{Tx}$ opens the joint by $s_N = s_{Tx}\,\tan\theta$"
    climbing.set_title(title, **NOTE)

    bodies(traction, (0.75, 0.0))
    for x in (1.75, 4.75):
        arrow(traction, (x, RISE), (0.0, 0.32), ORANGE)
        arrow(traction, (x, RISE + 0.75), (0.0, -0.32), ORANGE)
    traction.text(1.75, 1.6, r"$t_N > 0$: tension", color=ORANGE, ha="center", **NOTE)
    for x in (0.05, 3.05):
        arrow(traction, (x, 0.12), (0.4, 0.0), BLUE)
        arrow(traction, (x + 0.4, 0.63), (-0.4, 0.0), BLUE)
    traction.text(3.02, 0.32, r"$t_{Tx} > 0$", color=BLUE, **NOTE)
    traction.text(0.3, -0.55, "the arrows are the tractions on each side", **NOTE)
    traction.set_title(r"(c) positive tractions, per nominal area", **NOTE)

    _planes_of(planes, Pattern.regular(2, 30.0))
    planes.set_title("(d) the same surface as an RIE: three planes, one common separation", **NOTE)
    return figure


def _planes_of(ax: Axes, pattern: Pattern) -> None:
    """Planes of RT from the side, with their weights and axes n and t."""
    names = ("flat", "faces $+T_x$", r"faces $-T_x$")
    fills = (BLACK, ORANGE, BLUE)
    for k, (n, gamma) in enumerate(zip(pattern.normals, pattern.weights, strict=True)):
        middle = np.array([2.3 * k + 1.0, 0.0])
        normal = np.array([n[1], n[0]])
        along = np.array([n[0], -n[1]])
        up = along if k < 2 else -along  # t points up the slope
        ends = np.array([middle - 0.8 * along, middle + 0.8 * along])
        ax.plot(*ends.T, color=fills[k], linewidth=4, solid_capstyle="butt")
        arrow(ax, middle, 0.9 * normal, BLACK)
        if k > 0:
            arrow(ax, middle, 0.75 * up, BLACK)
            ax.text(*np.add(middle + 0.85 * up, (0.0, -0.34)), "uphill", ha="center", **NOTE)
        ax.text(*(middle + 1.0 * normal), r"$\mathbf{n}$", ha="center")
        ax.text(middle[0], -0.95, rf"{names[k]}, $\gamma$ = {gamma:.3g}", color=fills[k], ha="center", **NOTE)
    angle = np.radians(np.linspace(0.0, 30.0, 20))
    corner = np.array([2.3 + 1.0, 0.0]) - 0.8 * np.array([np.cos(angle[-1]), np.sin(angle[-1])])
    ax.plot([corner[0], corner[0] + 0.9], [corner[1]] * 2, ":", color=BLACK, linewidth=1.0)
    ax.plot(*(corner[:, None] + 0.65 * np.vstack([np.cos(angle), np.sin(angle)])), color=BLACK, linewidth=1.0)
    ax.text(*np.add(corner, (0.72, 0.07)), r"$\theta$")
    ax.set_xlim(-0.2, 6.6)
    ax.set_ylim(-1.2, 1.4)
    ax.set_aspect("equal")
    ax.set_axis_off()


def patterns() -> Figure:
    """Patterns in plan, and the planes that face a slip along Tx."""
    figure = Figure(figsize=(TWO, 1.8), layout="constrained")
    drawn = {"RT: m = 2": 2, "RP-3": 3, "RP-4": 4, "RP-6": 6, "RP-16": 16}
    for i, (name, m) in enumerate(drawn.items()):
        ax = figure.add_subplot(1, len(drawn), i + 1)
        plan(ax, Pattern.regular(m, 30.0), name)
        for patch in list(ax.patches)[1:]:  # The flat plane is left out. Every side rises towards the middle.
            faces = patch.get_xy()[:-1, 0].mean() < -1e-6
            patch.set_facecolor(FACING if faces else GREYS[1])
        arrow(ax, (-0.2, -0.8), (0.4, 0.0), BLACK)
        ax.text(0.0, -0.98, "slip along $T_x$", ha="center", fontsize=6.0)
        ax.set_xlim(-0.75, 0.75)
        ax.set_ylim(-1.0, 0.75)
    return figure


SLOPE = float(np.tan(np.radians(35.0)))
HEIGHT = 0.6
"""Slope T at the foot and height H of the sketch."""

POINT, LIFT = 0.75, 0.62
"""Slip u and lift w - z of the sketch; the lift is an opening, to show the gap."""


def facet_profile(u: Floats, height: float = HEIGHT) -> Floats:
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
        shapes.plot(u, (1.0 - omega) * facet_profile(u, height), style, color=colour, label=label)
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
    z = facet_profile(u)
    ax.fill_between(u, z, -0.6, color=STONE[0])
    ax.plot(u, z, color=BLACK, linewidth=1.4)
    ax.plot(u[u < 1.25], u[u < 1.25] * SLOPE, color=BLACK, linewidth=0.8, linestyle=(0, (1, 3)))
    contact = np.array([POINT, float(facet_profile(np.array(POINT)))])
    slope = SLOPE * np.exp(-POINT * SLOPE / HEIGHT)
    along = np.array([1.0, slope]) / np.hypot(1.0, slope)
    normal = np.array([-along[1], along[0]])
    point = np.add(contact, (0.0, LIFT))
    arc = (u >= 0.0) & (u <= POINT)
    ax.plot(u[arc], z[arc], color=BLUE, linewidth=3.5, solid_capstyle="butt")
    ax.plot(*np.transpose([contact - 0.45 * along, contact + 0.75 * along]), color=BLACK, linewidth=0.8)
    gap = LIFT * normal[1]
    arrow(ax, contact, gap * normal, ORANGE)
    ax.plot(*np.transpose([contact + gap * normal, point]), ":", color=BLUE, linewidth=1.6)
    ax.plot(*np.transpose([contact, point]), ":", color=BLACK, linewidth=0.8)
    ax.plot(*point, "o", color=BLACK, markersize=4)
    ax.text(point[0] + 0.05, point[1], "$(u, w)$", va="center")
    ax.text(contact[0] + 0.03, contact[1] + 0.43, "$w - z$", fontsize="small")
    ax.text(*np.add(contact + 0.55 * gap * normal, (-0.07, -0.02)), "$g$", color=ORANGE, ha="right")
    ax.text(0.3, 0.0, "arc $A$", color=BLUE, fontsize="small")
    ax.text(
        contact[0] - 0.02, point[1] + 0.08, "$(w - z)\\,\\sin\\phi$", color=BLUE, ha="right", fontsize="small"
    )
    ax.annotate(r"$\phi$", np.add(contact, (0.8, 0.04)))
    ax.plot([contact[0], contact[0] + 0.75], [contact[1]] * 2, ":", color=BLACK, linewidth=0.8)
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
