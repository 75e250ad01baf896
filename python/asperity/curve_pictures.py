"""Curves of slip tests with labels at their ends, and energies over the direction of slip."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes

from .contract import Floats
from .style import COLOURS, LINES, direction_arrows, label_axes, label_ends

ENERGY = r"$G_T$ [N/mm]"

Line = tuple[str, Floats, Floats, bool]
"""Label, x, y of a curve, and whether equilibrium is lost at its end."""

COINCIDE = 5.0e-3
"""Curves that differ by less than this fraction of the largest value are drawn as one: a line is as thick."""


def labels_of(slips: bool, length: str, stress: str) -> list[str]:
    """Labels of the abscissa, of the traction, of the dilation (with slip only) and of the damage."""
    if not slips:
        return [f"opening $s_N$ [{length}]", rf"traction $\sigma_N$ [{stress}]", "damage [-]"]
    traction, dilation = rf"traction $\tau_L$ [{stress}]", f"dilation $s_N$ [{length}]"
    return [f"slip $s_L$ [{length}]", traction, dilation, "damage [-]"]


SLIP, TRACTION, DILATION, _ = labels_of(True, "mm", "MPa")


def colour(i: int, count: int) -> object:
    """Colour of curve i, from the palette or, for many curves, from a scale without its lightest colours."""
    return COLOURS[i % len(COLOURS)] if count <= len(COLOURS) else colormaps["viridis"](0.9 * i / (count - 1))


def merged(lines: Sequence[Line]) -> list[Line]:
    """Lines without those that coincide with another one, whose label then has all their names."""
    top = max(float(np.abs(y).max()) for _, _, y, _ in lines)
    kept: list[tuple[list[str], Line]] = []
    for line in lines:
        _, x, y, lost = line
        for names, (_, x_0, y_0, lost_0) in kept:
            same = lost == lost_0 and x.shape == x_0.shape and np.allclose(x, x_0)
            if same and np.abs(y - y_0).max() < COINCIDE * top:
                names.append(line[0])
                break
        else:
            kept.append(([line[0]], line))
    whole = len(lines) > 2 and len(kept) == 1
    return [(f"{names[0]} to {names[-1]}" if whole else ", ".join(names), *line[1:]) for names, line in kept]


def curves(
    ax: Axes, lines: Iterable[Line], x_label: str, y_label: str, labels: str = "", inside: bool = False
) -> None:
    """Draw curves with labels at their ends; a cross marks a lost equilibrium, arrows mark reversals.

    labels: what the labels are, with a unit; without it there are none.  inside: whether a legend inside the
    axes has the labels, for curves that end at one point.
    """
    lines = list(lines)
    for i, (label, x, y, lost) in enumerate(lines):
        shade = colour(i, len(lines))
        ax.plot(x, y, LINES[i % len(LINES)], color=shade, label=label)
        direction_arrows(ax, x, y, shade)
        if lost:
            ax.plot(x[-1], y[-1], "x", color=shade, markersize=5)
    label_axes(ax, x_label, y_label)
    if labels and inside:
        ax.legend(title=labels)
    elif labels:
        label_ends(ax, labels)


def polar(ax: Axes, directions: Floats, values: Floats, limits: tuple[float, float], title: str = "") -> None:
    """Draw G_T in N/mm over the direction of slip; the radius starts at the first of the limits."""
    angles = np.radians(np.append(directions, directions[0]))
    ax.plot(angles, np.append(values, values[0]), color=COLOURS[0])
    ax.set_rlim(*limits)
    ticks = np.linspace(*limits, 4)[1:]
    ax.set_rticks(ticks, [f"{tick:.2f}" for tick in ticks[:-1]] + [f"{ticks[-1]:.2f} N/mm"])
    ax.set_rlabel_position(22.5)
    ax.tick_params(axis="both", labelsize=6.0, pad=0)
    ax.grid(alpha=0.4)
    if title:
        ax.set_title(title)
