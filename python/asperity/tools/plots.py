"""Drawing of a driver's results."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..contract import shown
from ..history import History
from ..interface import Interface
from .pattern_pictures import plan, section
from .style import TWO, Line, curves, label_ends, labels_of, literal, new_figure, printed, save


def plot(
    history: History,
    path: str | Path | None = None,
    title: str = "",
    units: tuple[str, str] = ("length", "stress"),
) -> Figure:
    """Figure of traction, dilation and damage of a history over the slip, or over the opening without slip.

    The normal traction is shown, too, where it changes during the slip.  path: file to write, too, a name
    that ends in .png or .pdf.  units: of length and stress, for the labels.  No window shows the figure of
    Matplotlib.  Raises ValueError for a history without rows, and for a path with another ending.
    """
    if not isinstance(history, History):
        raise ValueError(f"plot: {shown(history)}: expected the History that run returns")
    if len(history) == 0:
        raise ValueError("plot: expected a history with rows")
    figure = figure_of({None: history}, title, "", *units)
    if path is not None:
        save(figure, Path(path))
    return figure


@printed()
def figure_of(
    results: Mapping[float | None, History],
    title: str,
    sweep: str,
    length: str,
    stress: str,
    joint: Interface | None = None,
) -> Figure:
    """Figure of traction, dilation and damage of the results over the slip, or over the opening without slip.

    results: by the value of the sweep.  sweep: its name, for the labels.  length, stress: units of labels.
    joint: interface of all results, whose pattern and constants a panel on the left shows.  A cross marks a
    lost equilibrium; arrows show the direction of paths with reversals.
    """
    slips = any(np.any(rows.separation[:, 1:]) for rows in results.values())
    x_label, *labels = labels_of(slips, length, stress)
    normal = any(map(_normal_changes, results.values()))
    if normal:
        labels.insert(-1, rf"traction $\sigma_N$ [{stress}]")
    shown = joint if joint is not None and (joint.pattern.m in (0, 2) or joint.pattern.m > 2) else None
    widths = ([0.62] if shown else []) + [1.0] * len(labels)
    figure, axes = new_figure(TWO, 2.5, ncols=len(widths), width_ratios=widths)
    if shown:
        _geometry(axes[0], shown)
        axes = axes[1:]
    panels: list[list[Line]] = [[] for _ in labels]
    for value, rows in results.items():
        name = "_" if value is None else f"{value:g}".replace("-", "−")
        x = rows.slip_along() if slips else rows.dilation
        columns = [rows.tau, rows.dilation] if slips else [rows.traction[:, 0]]
        columns += [rows.traction[:, 0]] if normal else []
        for panel, y in zip(panels, [*columns, rows.damage], strict=True):
            panel.append((name, x, y, rows.lost))
    for ax, panel, label in zip(axes, panels, labels, strict=True):
        curves(ax, panel, x_label, label)
    axes[-1].set_ylim(-0.02, 1.05)
    figure.suptitle(literal(title))
    if None not in results:
        label_ends(axes[0], literal(sweep))
    return figure


def _normal_changes(rows: History) -> bool:
    """Whether the normal traction changes while the joint slips, by a part that a picture shows."""
    normal = rows.traction[np.any(rows.separation[:, 1:] != 0.0, axis=1), 0]
    return normal.size > 0 and bool(np.ptp(normal) > 1e-2 * np.abs(rows.traction).max())


def _geometry(ax: Axes, joint: Interface) -> None:
    pattern, material = joint.pattern, joint.material
    if pattern.m in (0, 2):
        section(ax, pattern)
    else:
        plan(ax, pattern, f"RP-{pattern.m}, {pattern.theta:g}°")
    kc = f"kc = {material.kc:g}"
    ax.text(0.5, -0.08, f"$\\mu$ = {material.mu:g}\n{kc}", transform=ax.transAxes, ha="center", va="top")
