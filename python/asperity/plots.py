"""Drawing of a driver's results."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from .contract import Floats
from .results import Rows

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#000000", "#E69F00", "#CC79A7")
"""Colours that colour-blind readers can distinguish (Okabe and Ito), for up to six curves."""

MOST_TURNS = 12
"""Largest number of reversals of a path whose branches get arrows."""

PLACE = 0.35
"""Place of an arrow on its branch, as a fraction of the slip; not the middle, where loops cross."""

LINES = ("-", "--", "-.", ":")
"""Line styles, for print in black and white."""


def slip_direction(separation: Floats) -> Floats:
    """Unit vector (Tx, Ty) of the first slip of at least half the largest size; (1, 0) without slip."""
    slip = separation[:, 1:]
    size = np.hypot(*slip.T)
    if not size.any():
        return np.array([1.0, 0.0])
    first = (size >= 0.5 * size.max()).argmax()
    e: Floats = slip[first] / size[first]
    return e


def _arrows(x: Floats, y: Floats) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Start and end of an arrow on each branch of a path with reversals; none without a reversal."""
    ways = np.sign(np.diff(x))
    moving = np.flatnonzero(ways)
    turns = moving[1:][np.diff(ways[moving]) != 0]
    if turns.size == 0 or turns.size > MOST_TURNS:
        return []
    found = []
    for first, last in pairwise([int(moving[0]), *turns.tolist(), len(x) - 1]):
        wanted = x[first] + PLACE * (x[last] - x[first])
        at = max(first + int(np.argmin(np.abs(x[first : last + 1] - wanted))), 1)
        found.append(((float(x[at - 1]), float(y[at - 1])), (float(x[at]), float(y[at]))))
    return found


def draw(
    results: Mapping[float | None, Rows], png: Path, title: str, sweep: str, length: str, stress: str
) -> None:
    """Write the picture of `figure_of` to a file."""
    figure = figure_of(results, title, sweep, length, stress)
    figure.savefig(png, dpi=200)


def figure_of(
    results: Mapping[float | None, Rows], title: str, sweep: str, length: str, stress: str
) -> Figure:
    """Figure of traction, dilation and damage of the results over the slip, or over the opening without slip.

    results: by the value of the sweep.  sweep: its name, for the legend.  length, stress: units of labels.
    A cross marks a lost equilibrium; arrows show the direction of paths with reversals.
    """
    slips = any(np.any(rows.separation[:, 1:]) for rows in results.values())
    x_label = f"slip $s_L$ [{length}]" if slips else f"opening $s_N$ [{length}]"
    labels = [rf"traction $\tau_L$ [{stress}]" if slips else rf"traction $\sigma_N$ [{stress}]"]
    labels += [f"dilation $s_N$ [{length}]"] if slips else []
    labels += ["damage [-]"]
    # not by pyplot, which would keep the figure open and choose a window for it
    figure = Figure(figsize=(4.0 * len(labels), 3.5), layout="constrained")
    axes = figure.subplots(1, len(labels))
    arrow = {"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, "mutation_scale": 14}
    for i, (value, rows) in enumerate(results.items()):
        colour = COLOURS[i] if len(results) <= len(COLOURS) else plt.cm.cividis(i / len(results))
        style = LINES[i % len(LINES)]
        e = slip_direction(rows.separation)
        opening = rows.separation[:, 0]
        x = rows.separation[:, 1:] @ e if slips else opening
        curves = (
            [rows.traction[:, 1:] @ e, opening, rows.damage] if slips else [rows.traction[:, 0], rows.damage]
        )
        for ax, y in zip(axes, curves, strict=True):
            ax.plot(x, y, style, color=colour, linewidth=1.5, label=None if value is None else f"{value:g}")
            for start, end in _arrows(x, y):
                ax.annotate(
                    "",
                    end,
                    start,
                    arrowprops=arrow | {"color": colour},
                )
            if "lost" in rows.events[-1]:
                ax.plot(x[-1], y[-1], "x", color=colour)
    for ax, label in zip(axes, labels, strict=True):
        ax.set_xlabel(x_label)
        ax.set_ylabel(label)
        ax.grid(alpha=0.3)
    axes[-1].set_ylim(-0.02, 1.05)
    if None not in results:
        handles, texts = axes[0].get_legend_handles_labels()
        figure.legend(
            handles,
            texts,
            title=sweep,
            loc="outside right upper",
            fontsize="small",
            ncols=1 + len(texts) // 14,
        )
    figure.suptitle(title, fontsize="medium")
    return figure
