"""Drawing helpers of the gallery: curves of a figure, polar plots, patterns in plan and in space."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..contract import Floats
from ..pattern import Pattern
from ..plots import COLOURS, LINES, plt

SLIP = r"slip $s_L$ [mm]"
TRACTION = r"traction $\tau_L$ [MPa]"
DILATION = r"dilation $s_N$ [mm]"
ENERGY = r"$G_T$ [N/mm]"

GREYS = ("#FFFFFF", "#D9E6F2", "#B3C6D9")
"""Fill colours of the flat plane and of inclined planes."""


def colour(i: int, count: int) -> object:
    """Colour of curve i, from the palette or, for many curves, from a scale without its lightest colours."""
    return COLOURS[i % len(COLOURS)] if count <= len(COLOURS) else plt.cm.viridis(0.9 * i / (count - 1))


def new_figure(width: float, height: float, **subplots: object) -> tuple[Figure, np.ndarray]:
    """Figure of a size in inches and the array of its axes."""
    figure, axes = plt.subplots(figsize=(width, height), layout="constrained", squeeze=False, **subplots)
    return figure, axes.ravel()


def curves(
    ax: Axes,
    lines: Iterable[tuple[str, Floats, Floats, bool]],
    x_label: str,
    y_label: str,
    legend: str = "",
    inside: bool = False,
) -> None:
    """Draw curves (label, x, y, whether equilibrium is lost at the end); a cross marks a lost equilibrium.

    legend: title of the legend, which is left out without a title.  inside: whether the legend stands inside
    the axes instead of on their right.
    """
    lines = list(lines)
    for i, (label, x, y, lost) in enumerate(lines):
        shade = colour(i, len(lines))
        ax.plot(x, y, LINES[i % len(LINES)], color=shade, linewidth=1.4, label=label)
        if lost:
            ax.plot(x[-1], y[-1], "x", color=shade, markersize=6)
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)
    ax.grid(alpha=0.3)
    if legend:
        beside(ax, legend) if not inside else ax.legend(
            title=legend, fontsize="x-small", title_fontsize="x-small"
        )


def beside(ax: Axes, title: str) -> None:
    """Legend on the right of the axes."""
    ax.legend(
        title=title,
        fontsize="x-small",
        title_fontsize="x-small",
        loc="upper left",
        bbox_to_anchor=(1.01, 1.02),
    )


def polar(ax: Axes, directions: Floats, values: Floats, limits: tuple[float, float], title: str = "") -> None:
    """Draw G_T over the direction of slip; the radius starts at the first of the limits."""
    angles = np.radians(np.append(directions, directions[0]))
    ax.plot(angles, np.append(values, values[0]), color=COLOURS[0], linewidth=1.4)
    ax.set_rlim(*limits)
    ticks = np.linspace(*limits, 4)[1:]
    ax.set_rticks(ticks, [f"{tick:.2f}" for tick in ticks], fontsize="x-small")
    ax.set_rlabel_position(67.5)
    ax.tick_params(axis="x", labelsize="x-small", pad=0)
    ax.grid(alpha=0.4)
    if title:
        ax.set_title(title, fontsize="small")


def _outlines(pattern: Pattern, size: float = 1.0) -> tuple[Floats, list[Floats]]:
    """Plan of one element: corners (., 2) of the flat plane on top and of each inclined plane.

    The areas in plan are the weights of the pattern.
    """
    if pattern.m == 2:
        half = 0.5 * size
        inner = half * pattern.flat
        x = [(-inner, inner), (-half, -inner), (inner, half)]
        boxes = [np.array([(a, -half), (b, -half), (b, half), (a, half)]) for a, b in x]
        return boxes[0], boxes[1:]
    # the sides are normal to the directions of the planes, so the corners lie between these directions
    corners = np.radians(pattern.turn + 180.0 / pattern.m * (2 * np.arange(pattern.m + 1) - 1) + 180.0)
    outer = size * np.column_stack([np.cos(corners), np.sin(corners)]) / np.sqrt(2.0)
    inner = np.sqrt(pattern.flat) * outer
    sides = [np.array([outer[k], outer[k + 1], inner[k + 1], inner[k]]) for k in range(pattern.m)]
    return inner[:-1], sides


def plan(ax: Axes, pattern: Pattern, title: str, numbers: bool = True) -> None:
    """Draw the plan view of a regular pattern, with an arrow up the slope of each inclined plane."""
    top, sides = _outlines(pattern)
    ax.fill(*top.T, facecolor=GREYS[0], edgecolor="black", linewidth=1.0)
    for k, side in enumerate(sides):
        ax.fill(*side.T, facecolor=GREYS[1 + k % 2], edgecolor="black", linewidth=1.0)
    if numbers:
        ax.text(0.0, 0.0, "1", ha="center", va="center", fontsize="small")
        for k, e in enumerate(_uphill(pattern)):
            middle = sides[_side_of(sides, e)].mean(axis=0)
            ax.text(*middle, str(k + 2), ha="center", va="center", fontsize="small")
    ax.set_title(title, fontsize="small")
    ax.set_aspect("equal")
    ax.set_axis_off()


def _uphill(pattern: Pattern) -> Floats:
    """Horizontal unit vectors up the slope of the inclined planes, in their order."""
    e = -pattern.normals[-pattern.m :, 1:]
    return e / np.linalg.norm(e, axis=1)[:, None]


def _side_of(sides: Sequence[Floats], e: Floats) -> int:
    """Index of the side of the element that rises along e; this side lies opposite to e."""
    return int(np.argmin([side.mean(axis=0) @ e for side in sides]))


def space(ax: Axes, pattern: Pattern, title: str) -> None:
    """Draw an oblique view of a regular pattern, with the average normal and the tangential axes."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    top, sides = _outlines(pattern)
    e = _uphill(pattern)
    slope = np.tan(np.radians(pattern.theta))
    rise = slope * ((top @ e[0]).min() - (np.concatenate(sides) @ e[0]).min())
    faces = [np.column_stack([top, np.full(len(top), rise)])]
    for side in sides:
        up = [_inside(corner, top) for corner in side]
        faces.append(np.column_stack([side, rise * np.array(up, dtype=float)]))
    ax.add_collection3d(
        Poly3DCollection(
            faces, facecolors=[GREYS[0], *(GREYS[1 + k % 2] for k in range(len(sides)))], edgecolors="black"
        )
    )
    ax.set_xlim(-0.6, 0.6)
    ax.set_ylim(-0.6, 0.6)
    ax.set_zlim(0.0, 0.6)
    ax.set_box_aspect((2, 2, 1), zoom=1.15)
    ax.computed_zorder = False  # draw the axes in front of the planes
    for vector, label in (((0.5, 0, 0), "$T_x$"), ((0, 0.5, 0), "$T_y$"), ((0, 0, 0.35), "$N$")):
        ax.quiver(0, 0, rise, *vector, color=COLOURS[1], arrow_length_ratio=0.15, linewidth=1.4, zorder=10)
        ax.text(*(1.3 * np.array(vector) + (0, 0, rise)), label, color=COLOURS[1], zorder=11)
    ax.view_init(elev=38, azim=-60)
    ax.set_axis_off()
    ax.set_title(title, fontsize="small")


def _inside(corner: Floats, top: Floats) -> bool:
    """Whether a corner of an inclined plane is also a corner of the flat plane."""
    return bool(np.any(np.all(np.isclose(top, corner), axis=1)))
