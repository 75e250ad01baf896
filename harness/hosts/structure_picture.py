"""Picture of a structure: its deformed mesh with the damage of the joints, and curves beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity.style import TWO, printed, save
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

STYLES = (("#0072B2", "-", 1.4), ("#D55E00", "--", 1.2), ("#000000", ":", 1.2))
"""Colour (Okabe and Ito), line and width of curves, which differ without colour as well."""


@dataclass(frozen=True)
class Mesh:
    """A plane mesh, mm.

    nodes and displacement (n, 2); faces (k, 4); joints (j, 4), the two nodes of the lower side, then those
    above them; damage of the joints at their ends (j, 2); name of the upward axis.
    """

    nodes: Floats
    displacement: Floats
    faces: Integers
    joints: Integers
    damage: Floats
    up: str = "y"


@dataclass(frozen=True)
class Curves:
    """Curves by their label, abscissa and ordinate, and points (label, x, y)."""

    x_label: str
    y_label: str
    lines: Mapping[str, tuple[Floats, Floats]]
    marks: Sequence[tuple[str, float, float]] = ()


LONG = 2.5
"""Length over height from which on a mesh stands above the curves instead of beside them."""


def draw(png: Path, title: str, mesh: Mesh, scale: float, plots: Sequence[Curves]) -> None:
    """Draw mesh, displacements times scale, and curves beside a compact mesh or below a long one."""
    png.parent.mkdir(parents=True, exist_ok=True)
    with printed():
        save(_figure(title, mesh, scale, plots), png)


def _figure(title: str, mesh: Mesh, scale: float, plots: Sequence[Curves]) -> Figure:
    columns = [f"curves {i}" for i in range(len(plots))]
    figure = Figure(layout="constrained")
    if np.ptp(mesh.nodes[:, 0]) > LONG * np.ptp(mesh.nodes[:, 1]):
        figure.set_size_inches(TWO, 4.4)
        axes = figure.subplot_mosaic([["mesh"] * len(plots), columns], height_ratios=(1.0, 1.3))
    else:
        figure.set_size_inches(TWO, 3.8)
        axes = figure.subplot_mosaic([["mesh", name] for name in columns], width_ratios=(1.5, 1.0))
    _draw_mesh(axes["mesh"], mesh, scale)
    for column, curves in zip(columns, plots, strict=True):
        for (label, (x, y)), (colour, style, width) in zip(curves.lines.items(), STYLES, strict=False):
            axes[column].plot(x, y, style, color=colour, linewidth=width, label=label)
        for label, x, y in curves.marks:
            axes[column].plot(x, y, "ko", markersize=4, label=label)
        axes[column].set_xlabel(curves.x_label)
        axes[column].set_ylabel(curves.y_label)
        axes[column].grid(alpha=0.3)
    handles, labels = axes[columns[0]].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    figure.suptitle(f"{title}; displacements times {scale:g}")
    return figure


def _draw_mesh(ax: Axes, mesh: Mesh, scale: float) -> None:
    """Draw the deformed solids and both sides of the joints, coloured by damage, with a colour bar."""
    moved = mesh.nodes + scale * mesh.displacement
    solids = PolyCollection(moved[mesh.faces], facecolors="#EEEEEE", edgecolors="#999999", linewidths=0.3)
    ax.add_collection(solids)
    lower, upper = mesh.joints[:, :2], mesh.joints[:, 2:]
    for side in (lower, upper):
        lines = LineCollection(moved[side], cmap="cividis", linewidths=2.0, clim=(0.0, 1.0))
        lines.set_array(mesh.damage.mean(axis=1))
        ax.add_collection(lines)
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.set_xlabel("x [mm]")
    ax.set_ylabel(f"{mesh.up} [mm]")
    # inside the frame of the mesh, which is smaller than its place in the picture
    bar = ax.figure.colorbar(lines, cax=ax.inset_axes([0.0, 1.03, 1.0, 0.03]), orientation="horizontal")
    bar.ax.xaxis.set_ticks_position("top")
    bar.ax.xaxis.set_label_position("top")
    bar.set_label("damage of the joint [-]")
