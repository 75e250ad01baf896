"""Picture of the quantiles of uncertain curves."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from ...steps import turns_of
from ..style import COLOURS, label_axes, labels_of, literal, new_figure, printed, save
from .spread import Spread


@printed()
def draw(path: Path, title: str, sweep: str, spreads: Sequence[Spread], units: tuple[str, str]) -> None:
    """Draw bands between the quantiles, the median and the curves of the case, a colour for each run."""
    slips = spreads[0].path.slips
    x_label, *labels = labels_of(slips, *units)
    shown = (0, 1, 2) if slips else (0, 2)
    figure, axes = new_figure(2.6 * len(labels), 2.8, ncols=len(labels))
    for number, spread in enumerate(spreads):
        colour = COLOURS[number % len(COLOURS)]
        x = spread.path.x[spread.points]
        branches = [slice(a, b + 1) for a, b in pairwise(turns_of(x))]
        for ax, i in zip(axes, shown, strict=True):
            for branch in branches:
                # pairs of levels, from the outside to the middle
                for k in range(len(spread.levels) // 2):
                    low, high = spread.curves[k, branch, i], spread.curves[-1 - k, branch, i]
                    ax.fill_between(x[branch], low, high, color=colour, alpha=0.25, linewidth=0.0)
            for median in np.flatnonzero(spread.levels == 0.5):
                ax.plot(x, spread.curves[median, :, i], color=colour, linewidth=1.5)
            ax.plot(spread.path.x, spread.case[0][:, i], "--", color=colour, linewidth=0.9)
        if spread.path.run.value is not None:
            axes[0].plot([], [], color=colour, label=f"{spread.path.run.value:g}")
    for ax, label in zip(axes, labels, strict=True):
        label_axes(ax, x_label, label)
    levels = spreads[0].levels
    text = " to ".join(f"{100.0 * level:g} %" for level in (levels[0], levels[-1]))
    parts = [f"band: quantiles {text}" if len(levels) > 1 else "", "line: median" if 0.5 in levels else ""]
    parts.append("dashed: the case")
    caption = ", ".join(part for part in parts if part)
    figure.suptitle(f"{literal(title)}\n{caption}" if title else caption)
    if sweep:
        figure.legend(title=literal(sweep), loc="outside right upper")
    save(figure, path)
