"""Pictures of a pattern: in plan, and as a section through the joint."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ..contract import Floats
from ..pattern import Pattern, direction_vector
from .style import COLOURS

GREYS = ("#FFFFFF", "#D9E6F2", "#B3C6D9")
"""Fill colours of the flat plane and of inclined planes."""

STONE = ("#E8E4DC", "#D8DEE6")
"""Fills of the lower and of the upper side of a joint."""


def outlines(pattern: Pattern, size: float = 1.0) -> tuple[Floats, list[Floats]]:
    """Plan of one element: corners (., 2) of the flat plane on top and of each inclined plane.

    The areas in plan are the weights of the pattern.  An inclined plane rises towards the flat one.
    """
    if pattern.m == 2:
        half = 0.5 * size
        inner = half * pattern.flat
        x = [(-inner, inner), (-half, -inner), (inner, half)]
        boxes = [np.array([(a, -half), (b, -half), (b, half), (a, half)]) for a, b in x]
        return boxes[0], boxes[1:]
    # the sides are normal to the directions of the planes, so the corners lie between these directions
    corners = pattern.turn + 180.0 / pattern.m * (2 * np.arange(pattern.m + 1) - 1) + 180.0
    outer = size * direction_vector(corners) / np.sqrt(2.0)
    inner = np.sqrt(pattern.flat) * outer
    sides = [np.array([outer[k], outer[k + 1], inner[k + 1], inner[k]]) for k in range(pattern.m)]
    return inner[:-1], sides


def plan(ax: Axes, pattern: Pattern, title: str) -> None:
    """Draw the plan view of a regular pattern."""
    top, sides = outlines(pattern)
    ax.fill(*top.T, facecolor=GREYS[0], edgecolor="black", linewidth=1.0)
    for k, side in enumerate(sides):
        ax.fill(*side.T, facecolor=GREYS[1 + k % 2], edgecolor="black", linewidth=1.0)
    ax.set_title(title)
    ax.set_aspect("equal")
    ax.set_axis_off()


def section(ax: Axes, pattern: Pattern) -> None:
    """Draw the joint of a flat pattern or of a trapezoid, with the directions of pressure and slip."""
    level, slope = pattern.flat / 4.0, (1.0 - pattern.flat) / 2.0
    x = np.cumsum([0.0, level, slope, 2.0 * level, slope, level])
    climb = slope * np.tan(np.radians(pattern.theta if pattern.m else 0.0))
    period = np.column_stack([x, climb * np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0])])
    line = np.vstack([period[:-1], np.add(period, (1.0, 0.0))])
    line = line[1:-1]
    rise = float(period[:, 1].max())
    floor, roof = -0.45, rise + 0.45
    for level, fill in ((floor, STONE[0]), (roof, STONE[1])):
        outline = np.vstack([line, (line[-1, 0], level), (line[0, 0], level)])
        ax.fill(*outline.T, facecolor=fill, edgecolor="none")
    ax.plot(*line.T, color="black")
    style = {"arrowstyle": "-|>", "color": COLOURS[1], "shrinkA": 0, "shrinkB": 0, "mutation_scale": 9}
    middle = line[:, 0].mean()
    ax.annotate("", (middle, roof), (middle, roof + 0.45), arrowprops=style)
    ax.text(middle + 0.08, roof + 0.25, r"$-\sigma_N$", color=COLOURS[1])
    ax.annotate("", (middle + 0.35, roof - 0.2), (middle - 0.35, roof - 0.2), arrowprops=style)
    ax.text(middle + 0.42, roof - 0.2, "$s_L$", color=COLOURS[1], va="center")
    if rise:
        corner = line[0]
        ax.plot([corner[0], corner[0] + 0.45], [corner[1]] * 2, ":", color="black", linewidth=0.8)
        ax.annotate(
            f"{pattern.theta:g}°", (corner[0] + 0.3, corner[1] + 0.05), (corner[0] + 0.12, floor + 0.1),
            arrowprops={"arrowstyle": "-", "linewidth": 0.5},
        )  # fmt: skip
    ax.set_aspect("equal")
    ax.set_axis_off()
