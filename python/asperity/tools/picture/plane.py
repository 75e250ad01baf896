"""Picture of a plane structure, with curves below it."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...contract import Floats
from ..style import COLOURS, TWO, printed
from .results import Results

CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}


@printed()
def draw_plane(
    step: Results,
    field: str,
    scale: float,
    label: str,
    title: str,
    curves: dict[str, Floats] | None = None,
    length: str = "",
) -> Figure:
    """Draw the deformed solids, and the joints in the colours of a field, or of their names (field "name").

    curves: columns by name, drawn below over the first one, NAME_point beside NAME.  length: unit of x and y.
    """
    wide = [name for name in (curves or {}) if not name.endswith("_point")][1:]
    places = np.concatenate([(x + scale * u)[:, :2] for x, u, *_ in step.solids])
    tall = float(np.ptp(places[:, 1]) / max(np.ptp(places[:, 0]), 1e-300))
    heights = [TWO * min(max(0.75 * tall, 0.3), 1.1)]
    if wide:
        heights.append(2.2)
    figure = Figure(figsize=(TWO, sum(heights)), layout="constrained")
    rows = figure.subfigures(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
    axes = rows[0].subplots()
    for x, u, kind, cells in step.solids:
        moved = (x + scale * u)[:, :2]
        outlines = list(moved[cells[:, : CORNERS[kind]]])
        grey = PolyCollection(outlines, facecolors="#E8E4DC", edgecolors="#A8A49C", linewidths=0.3)
        axes.add_collection(grey)
    lines = np.concatenate([(x + scale * u)[:, :, :2] for x, u in zip(step.x, step.u, strict=True)])
    if field == "name":
        numbers = np.concatenate(step.part)
        colours = ListedColormap([COLOURS[k % len(COLOURS)] for k in range(len(step.names))])
        drawn = LineCollection(list(lines), cmap=colours, linewidths=2.5, capstyle="round")
        drawn.set_array(numbers)
        drawn.set_clim(-0.5, len(step.names) - 0.5)
        marks = [Line2D([], [], color=colours(k), lw=2.5, label=name) for k, name in enumerate(step.names)]
        axes.legend(handles=marks, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    else:
        values = np.concatenate(step.fields[field])
        drawn = LineCollection(list(lines), cmap="viridis_r", linewidths=2.5, capstyle="round")
        drawn.set_array(values)
        drawn.set_clim(*limits(field, values))
        rows[0].colorbar(drawn, ax=axes, label=label, shrink=0.8)
    axes.add_collection(drawn)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set(xlabel=f"x{length}", ylabel=f"y{length}", title=title)
    if wide and curves:
        x_name, at = next(iter(curves.items()))
        for ax, name in zip(rows[1].subplots(1, len(wide), squeeze=False)[0], wide, strict=True):
            ax.plot(at, curves[name], color=COLOURS[0], label="structure")
            if f"{name}_point" in curves:
                ax.plot(at, curves[f"{name}_point"], "--", color=COLOURS[1], label="material point")
                ax.legend()
            ax.set(xlabel=x_name, ylabel=name)
    return figure


def limits(field: str, values: Floats) -> tuple[float, float]:
    """Ends of the scale of colours: 0 to 1 for the damage, from 0 for lengths of vectors."""
    if field == "damage":
        return 0.0, 1.0
    low = float(values.min()) if field in ("opening", "normal") else 0.0
    high = float(values.max())
    return (low, high) if high > low else (low - 0.5, low + 0.5)
