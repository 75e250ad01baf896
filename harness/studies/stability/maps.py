"""Map of the convergence of tangents over friction and inclination, with the closed form of locking."""

from __future__ import annotations

from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.options import progress_bar
from asperity.parallel import map_in_order
from asperity.pattern import Pattern
from asperity.style import COLOURS
from matplotlib.colors import BoundaryNorm, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from .modes import TABLE_2, K
from .solver_modes import SPRING, pulled

DIRECTION = 20.0
"""Direction of the shear in the map of tangents, degrees."""

FAILED = "0.85"
"""Grey of a cell in which a method fails."""


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
    figure = draw(rows)
    figure.savefig(picture, dpi=130)
    plt.close(figure)
    return [table, picture]


SHOWN_TANGENTS = ("consistent", "symmetrised", "secant")

MOST = 100
"""Largest number of iterations of an increment in the map of tangents."""


def cell(place: tuple[float, float]) -> dict[str, float]:
    """Iterations with three tangents, and signs of the tangent along the path, at a friction and slope."""
    mu, theta = place
    row = {"mu": mu, "theta": theta}
    for tangent in SHOWN_TANGENTS:
        study = pulled(mu, theta, tangent, most=MOST, direction=DIRECTION)
        row[tangent] = float(np.mean(study.iterations)) if study.converged else np.nan
    fine = pulled(mu, theta, "consistent", steps=100, direction=DIRECTION)
    rough = Interface(replace(TABLE_2, mu=mu, kc=20.0), Pattern.regular(4, theta))
    before = np.vstack([np.zeros((1, rough.nstatv)), fine.state[:-1]])
    matrices = rough.update(fine.separation, before).tangent / K
    system = matrices + np.diag([0.0, SPRING, SPRING])
    row["symmetric"] = float(_symmetric(matrices))
    row["system"] = float(_symmetric(system))
    row["determinant"] = float(np.linalg.det(matrices).min())
    return row


def _symmetric(matrices: Floats) -> float:
    """Smallest eigenvalue of the symmetric parts."""
    return float(np.linalg.eigvalsh(0.5 * (matrices + matrices.transpose(0, 2, 1))).min())


def draw(rows: pandas.DataFrame) -> Figure:
    """Draw the iterations per tangent, and where the symmetric part and the determinant change their sign."""
    figure, axes = plt.subplots(2, 2, figsize=(9.5, 8.2), layout="constrained", sharex=True, sharey=True)
    cells = rows.pivot(index="theta", columns="mu")
    theta, mu = cells.index.to_numpy(), np.unique(rows.mu)
    norm = BoundaryNorm([1, 2, 3, 4, 6, 10, 20, 40, 100], 256)
    image = None
    for ax, tangent in zip(axes.flat, SHOWN_TANGENTS, strict=False):
        grid = cells[tangent].to_numpy()
        image = ax.pcolormesh(mu, theta, grid, norm=norm, cmap="cividis", shading="nearest")
        ax.set_facecolor(FAILED)
        i, j = np.nonzero(np.isnan(grid))
        ax.plot(mu[j], theta[i], "x", color="0.4", markersize=3, markeredgewidth=0.7)
        share = 100.0 * np.mean(~np.isnan(grid))
        ax.set_title(f"{tangent} tangent: {share:.0f} % of the paths", fontsize="medium")
    assert image is not None
    figure.colorbar(image, ax=axes[:, 0], location="left", label="iterations per increment [-]", shrink=0.7)
    ax = axes[1, 1]
    system = cells["system"].to_numpy()
    limit = np.nanpercentile(np.abs(system), 80)
    signs = ax.pcolormesh(
        mu, theta, system, norm=TwoSlopeNorm(0.0, -limit, limit), cmap="PuOr", shading="nearest"
    )
    figure.colorbar(
        signs, ax=ax, label=r"smallest eigenvalue of the system's symmetric part [$K$]", extend="both"
    )
    ax.set_title("signs along the path", fontsize="medium")
    for name, style in (("system", "-"), ("determinant", "--")):
        grid = cells[name].to_numpy()
        if grid.min() < 0.0 < grid.max():
            ax.contour(mu, theta, grid, [0.0], colors="black", linestyles=style, linewidths=1.2)
    slopes = np.linspace(1.0, 60.0, 200)
    boundary = _locking_friction(slopes, np.radians(DIRECTION))
    for ax in axes.flat:
        ax.plot(boundary, slopes, color=COLOURS[1], linewidth=2.0)
        ax.set_xlim(mu[0], mu[-1])
        ax.set_ylim(theta[0], theta[-1])
    for ax in axes[1]:
        ax.set_xlabel(r"friction $\mu$ [-]")
    for ax in axes[:, 0]:
        ax.set_ylabel(r"inclination $\theta$ [degree]")
    handles = [
        Line2D([], [], color=COLOURS[1], linewidth=2.0, label="locking, closed form"),
        Line2D([], [], color="black", label="symmetric part of the system becomes indefinite"),
        Line2D([], [], color="black", linestyle="--", label="determinant of the tangent becomes negative"),
        Line2D([], [], color="0.4", marker="x", linestyle="", label="does not converge"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize="small")
    figure.suptitle(
        f"RP-4, 1 MPa, sheared through springs of {SPRING:g} K, 10 increments of at most {MOST} iterations",
        fontsize="medium",
    )
    return figure


def _locking_friction(theta: Floats, phi: float) -> Floats:
    """Friction at which a plane at phi, radians, locks: zero of the denominator of the residual strength."""
    slope = np.tan(np.radians(theta)) * np.cos(phi)
    result: Floats = np.cos(np.radians(theta)) * np.sqrt(1.0 + slope**2) / slope
    return result
