"""Map of the convergence of tangents over friction and inclination, with the closed form of locking."""

from __future__ import annotations

from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas
from asperity.contract import Floats
from asperity.options import progress_bar
from asperity.parallel import map_in_order
from asperity.style import COLOURS, TWO, new_figure, printed, save
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure

from .entries import pulled

DIRECTION = 20.0
"""Direction of the shear, degrees."""

FAILED = "0.85"
"""Grey of a cell in which a method fails."""

TANGENTS = ("consistent", "symmetrised", "secant")

MOST = 100
"""Largest number of iterations of an increment."""


def draw_map(folder: Path, size: int, executor: Executor | None = None) -> list[Path]:
    """Compute and draw the map, and return the written files; size: cells along an axis.

    executor: as in `map_in_order`; without one, one cell after the other.
    """
    folder.mkdir(parents=True, exist_ok=True)
    slopes, frictions = np.linspace(0.0, 60.0, size), np.linspace(0.0, 1.6, size)
    places = [(float(mu), float(theta)) for theta in slopes for mu in frictions]
    with progress_bar(len(places), "cell of the map") as bar:
        rows = pandas.DataFrame(map_in_order(cell, places, executor or ThreadPoolExecutor(1), bar.update))
    table, picture = folder / "map_tangents.csv", folder / "map_tangents.png"
    rows.to_csv(table, index=False, na_rep="nan")
    save(draw(rows), picture)
    return [table, picture]


def cell(place: tuple[float, float]) -> dict[str, float]:
    """Iterations of an increment with three tangents at a friction and slope; NaN where a path fails."""
    mu, theta = place
    row = {"mu": mu, "theta": theta}
    for tangent in TANGENTS:
        study = pulled(mu, theta, tangent, most=MOST, direction=DIRECTION)
        row[tangent] = float(np.mean(study.iterations)) if study.converged else np.nan
    return row


@printed()
def draw(rows: pandas.DataFrame) -> Figure:
    """Draw the iterations with each tangent, and where the slip locks."""
    figure, axes = new_figure(TWO, 2.9, ncols=3, sharey=True)
    cells = rows.pivot(index="theta", columns="mu")
    theta, mu = cells.index.to_numpy(), np.unique(rows.mu)
    norm, slopes = BoundaryNorm([1, 2, 3, 4, 6, 10, 20, 40, 100], 256), np.linspace(1.0, 60.0, 200)
    for ax, tangent in zip(axes, TANGENTS, strict=True):
        grid = cells[tangent].to_numpy()
        image = ax.pcolormesh(mu, theta, grid, norm=norm, cmap="cividis", shading="nearest")
        ax.set_facecolor(FAILED)
        i, j = np.nonzero(np.isnan(grid))
        ax.plot(mu[j], theta[i], "x", color="0.4", markersize=2, markeredgewidth=0.5, label="fails")
        locking = locking_friction(slopes, np.radians(DIRECTION))
        ax.plot(locking, slopes, color=COLOURS[1], linewidth=1.6, label="locking, closed form")
        ax.set(xlim=mu[[0, -1]], ylim=theta[[0, -1]], xlabel=r"friction $\mu$ [-]")
        ax.set_title(f"{tangent}: {100.0 * np.mean(~np.isnan(grid)):.0f} % of the paths")
    axes[0].set_ylabel(r"inclination $\theta$ [°]")
    figure.colorbar(image, ax=axes, label="iterations per increment [-]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def locking_friction(theta: Floats, phi: float) -> Floats:
    """Friction at which a plane at phi, radians, locks: zero of the denominator of the residual strength."""
    slope = np.tan(np.radians(theta)) * np.cos(phi)
    return np.cos(np.radians(theta)) * np.sqrt(1.0 + slope**2) / slope
