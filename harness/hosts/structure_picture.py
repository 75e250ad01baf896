"""Picture of a structure: its deformed mesh with the damage of the joints, and curves beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

STYLES = (("#0072B2", "-", 1.6), ("#D55E00", "--", 1.3), ("#000000", ":", 1.3))
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


def draw(png: Path, title: str, mesh: Mesh, scale: float, plots: Sequence[Curves]) -> None:
    """Draw mesh, displacements times scale, and curves below it."""
    columns = [f"curves {i}" for i in range(len(plots))]
    figure, axes = plt.subplot_mosaic(
        [["mesh"] * len(plots), columns],
        figsize=(4.6 * len(plots), 6.4),
        height_ratios=(1.0, 1.1),
        layout="constrained",
    )
    ax = axes["mesh"]
    moved = mesh.nodes + scale * mesh.displacement
    solids = PolyCollection(moved[mesh.faces], facecolors="#EEEEEE", edgecolors="#999999", linewidths=0.4)
    ax.add_collection(solids)
    lower, upper = mesh.joints[:, :2], mesh.joints[:, 2:]
    for side in (lower, upper):
        lines = LineCollection(moved[side], cmap="cividis", linewidths=3.0, clim=(0.0, 1.0))
        lines.set_array(mesh.damage.mean(axis=1))
        ax.add_collection(lines)
    bar = figure.colorbar(lines, ax=ax, shrink=0.8, panchor=False, pad=0.01, aspect=12)
    bar.set_label("damage of the joint [-]")
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.set_title(f"{title}\ndeformed mesh, displacements times {scale:g}", fontsize="medium")
    ax.set_xlabel("x [mm]")
    ax.set_ylabel(f"{mesh.up} [mm]")
    for column, curves in zip(columns, plots, strict=True):
        for (label, (x, y)), (colour, style, width) in zip(curves.lines.items(), STYLES, strict=False):
            axes[column].plot(x, y, style, color=colour, linewidth=width, label=label)
        for label, x, y in curves.marks:
            axes[column].plot(x, y, "ko", markersize=5, label=label)
        axes[column].set_xlabel(curves.x_label)
        axes[column].set_ylabel(curves.y_label)
        axes[column].grid(alpha=0.3)
    handles, labels = axes[columns[0]].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize="small")
    png.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(png, dpi=200)
    plt.close(figure)
