"""Maps of convergence and cost of methods, with boundaries from closed forms."""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

import numpy as np
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.parallel import Serial, map_in_order, progress_bar
from asperity.pattern import Pattern
from asperity.plots import COLOURS, plt
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..newton import newton_study
from .law_modes import clamped_reversal, locks
from .modes import S_F, TABLE_2, K, drive
from .solver_modes import SPRING, pulled, ramp

Row = dict[str, float | str]
"""Values of one cell of a map by the columns of its CSV."""

DIRECTION = 20.0
"""Direction of the shear in the map of tangents, degrees."""

FAILED = "0.85"
"""Grey of a cell in which a method fails."""


def draw_maps(folder: Path, size: int, pdf: bool = False, executor: Executor | None = None) -> Iterator[Path]:
    """Compute and draw every map; size: cells along an axis.  Yields the names of the written files.

    executor: as in `map_in_order`; without one, one cell after the other.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, places, cell, draw in (
        ("tangents", tangent_places(size), tangent_cell, draw_tangents),
        ("steps", step_places(size), step_cell, draw_steps),
        ("law", law_places(size), law_cell, draw_law),
    ):
        with progress_bar(len(places), f"cell of map {name}") as bar:
            rows = map_in_order(cell, places, executor or Serial(), bar.update)
        path = folder / f"map_{name}.csv"
        with path.open("w", encoding="utf-8", newline="") as file:
            columns = dict.fromkeys(key for row in rows for key in row)
            writer = csv.DictWriter(file, columns)
            writer.writeheader()
            writer.writerows(rows)
        yield path
        figure = draw(rows)
        for suffix in (".png", ".pdf") if pdf else (".png",):
            path = folder / f"map_{name}{suffix}"
            figure.savefig(path, dpi=130)
            yield path
        plt.close(figure)


def cells(
    rows: Sequence[Row], x: str, y: str, value: str | Callable[[Row], float]
) -> tuple[Floats, Floats, Floats]:
    """Values of x and y, and the value of every cell (len(y), len(x)), NaN for a missing cell."""
    xs, ys = (np.array(sorted({float(row[name]) for row in rows})) for name in (x, y))
    grid = np.full((len(ys), len(xs)), np.nan)
    for row in rows:
        number = value(row) if callable(value) else float(row[value])
        grid[np.searchsorted(ys, float(row[y])), np.searchsorted(xs, float(row[x]))] = number
    return xs, ys, grid


# --- tangents over (mu, theta) ------------------------------------------------------------------------------

SHOWN_TANGENTS = ("consistent", "symmetrised", "secant")

MOST = 100
"""Largest number of iterations of an increment in the map of tangents."""


def tangent_places(size: int) -> list[tuple[float, float]]:
    """Friction and inclination of the cells."""
    slopes, frictions = np.linspace(0.0, 60.0, size), np.linspace(0.0, 1.6, size)
    return [(float(mu), float(theta)) for theta in slopes for mu in frictions]


def tangent_cell(place: tuple[float, float]) -> Row:
    """Iterations with three tangents, and signs of the tangent along the path, at a friction and slope."""
    mu, theta = place
    row: Row = {"mu": mu, "theta": theta}
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


def draw_tangents(rows: Sequence[Row]) -> Figure:
    """Draw the iterations per tangent, and where the symmetric part and the determinant change their sign."""
    figure, axes = plt.subplots(2, 2, figsize=(9.5, 8.2), layout="constrained", sharex=True, sharey=True)
    norm = BoundaryNorm([1, 2, 3, 4, 6, 10, 20, 40, 100], 256)
    image = None
    for ax, tangent in zip(axes.flat, SHOWN_TANGENTS, strict=False):
        mu, theta, grid = cells(rows, "mu", "theta", tangent)
        image = ax.pcolormesh(mu, theta, grid, norm=norm, cmap="cividis", shading="nearest")
        _failed(ax, mu, theta, np.isnan(grid))
        share = 100.0 * np.mean(~np.isnan(grid))
        ax.set_title(f"{tangent} tangent: {share:.0f} % of the paths", fontsize="medium")
    assert image is not None
    figure.colorbar(image, ax=axes[:, 0], location="left", label="iterations per increment [-]", shrink=0.7)
    ax = axes[1, 1]
    mu, theta, system = cells(rows, "mu", "theta", "system")
    limit = np.nanpercentile(np.abs(system), 80)
    signs = ax.pcolormesh(
        mu, theta, system, norm=TwoSlopeNorm(0.0, -limit, limit), cmap="PuOr", shading="nearest"
    )
    figure.colorbar(
        signs, ax=ax, label=r"smallest eigenvalue of the system's symmetric part [$K$]", extend="both"
    )
    ax.set_title("signs along the path", fontsize="medium")
    for name, style in (("system", "-"), ("determinant", "--")):
        grid = cells(rows, "mu", "theta", name)[2]
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


def _failed(ax: Axes, x: Floats, y: Floats, failed: np.ndarray) -> None:
    """Mark cells in which a method fails by grey and a cross."""
    ax.set_facecolor(FAILED)
    i, j = np.nonzero(failed)
    ax.plot(x[j], y[i], "x", color="0.4", markersize=3, markeredgewidth=0.7)


# --- steps over (sigma_N, step) -----------------------------------------------------------------------------

SIDES = 16
"""Pattern of the map of steps: RP-16, which snaps."""

OUTCOMES = ("smooth", "snap", "lost")
"""Results of the driver's solver: the last of these events on a path, or none."""


def step_places(size: int) -> list[tuple[int, float]]:
    """Number of steps and pressure over sigma0 of the cells."""
    numbers = np.unique(np.geomspace(2, 2000, size).round().astype(int))
    return [(int(steps), share) for steps in numbers for share in _pressures(size)]


def step_cell(place: tuple[int, float]) -> Row:
    """Plain Newton and the driver's solver at a pressure and step."""
    steps, share = place
    rough = Interface(TABLE_2, Pattern.regular(SIDES, 30.0))
    sigma_N = share * TABLE_2.sigma0
    study = newton_study(rough, 0.0, ramp(0.0, S_F, steps=steps), sigma_N, preload=20)
    row: Row = {"sigma_N/sigma0": share, "step/s_f": 1.0 / steps, "plain": study.end}
    row["plain_iterations"] = float(np.mean(study.iterations)) if study.converged else np.nan
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder, "case.nml")
        case.write_text(
            "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /\n"
            f"&pattern sides = {SIDES}, theta = 30.0 /\n"
            f"&step t_N = {sigma_N!r}, increments = 20 /\n"
            f"&step slip = {S_F!r}, increments = {steps} /\n",
            encoding="utf-8",
        )
        run = drive(case)
    happened = [event for event in OUTCOMES if run.rows_with(event)]
    row["solver"] = happened[-1] if happened else OUTCOMES[0]
    row["solver_iterations"] = float(run.columns["iterations"].mean())
    return row


def _pressures(size: int) -> list[float]:
    """Values of the normal traction over sigma0 from +0.5 through 0 to -100, dense around 0."""
    below = max(2, (3 * size) // 4)
    above = max(1, size - below - 1)
    return [
        *(float(x) for x in np.geomspace(0.5, 1e-3, above)),
        0.0,
        *(float(-x) for x in np.geomspace(1e-3, 100.0, below)),
    ]


def draw_steps(rows: Sequence[Row]) -> Figure:
    """Draw plain Newton beside the solver of the driver."""
    pressures = sorted({float(row["sigma_N/sigma0"]) for row in rows}, reverse=True)
    steps = sorted({float(row["step/s_f"]) for row in rows})
    shape = (len(steps), len(pressures))
    norm = BoundaryNorm([1, 1.5, 2, 3, 4, 6, 10, 30, 100, 1000], 256)
    figure, axes = plt.subplots(1, 2, figsize=(11.0, 5.6), layout="constrained", sharey=True)
    image = None
    snapping = [pressures.index(float(row["sigma_N/sigma0"])) for row in rows if row["solver"] == "snap"]
    for ax, method in zip(axes, ("plain", "solver"), strict=True):
        grid, failed = np.full(shape, np.nan), np.zeros(shape, dtype=bool)
        marks: dict[str, list[tuple[int, int]]] = {name: [] for name in OUTCOMES}
        for row in rows:
            i, j = steps.index(float(row["step/s_f"])), pressures.index(float(row["sigma_N/sigma0"]))
            grid[i, j] = float(row[f"{method}_iterations"])
            if method == "plain":
                failed[i, j] = np.isnan(grid[i, j])
            else:
                marks[str(row["solver"])].append((j, i))
        shown = np.where(failed, np.nan, grid)
        for j, i in marks["lost"]:
            shown[i, j] = np.nan
        image = ax.pcolormesh(
            np.arange(len(pressures)),
            np.arange(len(steps)),
            shown,
            norm=norm,
            cmap="cividis",
            shading="nearest",
        )
        _failed(ax, np.arange(len(pressures)), np.arange(len(steps)), failed)
        for name, marker, colour in (("snap", "o", COLOURS[1]), ("lost", "_", "0.3")):
            if marks[name]:
                ax.plot(*zip(*marks[name], strict=True), marker, color=colour, markersize=4, linestyle="")
        if snapping:
            ax.axvline(max(snapping) + 0.5, color=COLOURS[1], linewidth=2.0)
        ticks = range(0, len(pressures), max(1, len(pressures) // 9))
        ax.set_xticks(list(ticks), [f"{pressures[j]:.2g}" for j in ticks], rotation=45)
        ticks = range(0, len(steps), max(1, len(steps) // 8))
        ax.set_yticks(list(ticks), [f"1/{round(1 / steps[i])}" for i in ticks])
        ax.set_xlabel(r"normal traction $\sigma_N/\sigma_0$ [-]")
    axes[0].set_ylabel(r"step of the slip $\Delta s_L/s_f$ [-]")
    axes[0].set_title("Newton without safeguards", fontsize="medium")
    axes[1].set_title("solver of the driver", fontsize="medium")
    assert image is not None
    figure.colorbar(image, ax=axes, label="iterations per increment [-]", format="%g")
    handles = [
        Line2D([], [], color="0.4", marker="x", linestyle="", label="does not converge"),
        Line2D([], [], color=COLOURS[1], marker="o", linestyle="", label="snaps, then converges"),
        Line2D([], [], color=COLOURS[1], linewidth=2.0, label="boundary of the snaps"),
        Line2D([], [], color="0.3", marker="_", linestyle="", label="no equilibrium (tension)"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize="small")
    figure.suptitle(
        rf"RP-{SIDES}, 30°, slip from 0 to $s_f$ along $T_x$ under a constant normal traction",
        fontsize="medium",
    )
    return figure


# --- law: locking, and the second law -----------------------------------------------------------------------

LOCK_DIRECTIONS = (0.0, 15.0, 30.0, 45.0)
"""Directions of the map of locking, degrees; by symmetry RP-4 needs no others."""

FIRST_SLIP = 0.15
"""Slip before the closure in the map of the second law, over s_f."""


def law_places(size: int) -> list[tuple[str, float, float]]:
    """Name of the map, x and y of the cells."""
    slopes, frictions = np.linspace(0.0, 60.0, size), np.linspace(0.0, 3.0, size)
    places = [("locking", float(mu), float(theta)) for theta in slopes for mu in frictions]
    backs, clamps = np.linspace(0.0, 0.5, size), np.linspace(0.0, 1.0, size)
    return places + [("second law", float(clamp), float(back)) for back in backs for clamp in clamps]


def law_cell(place: tuple[str, float, float]) -> Row:
    """Locking directions at (mu, theta), or decrease of the rupture energy at (closure, reversal)."""
    name, x, y = place
    if name == "locking":
        rough = Interface(replace(TABLE_2, mu=x), Pattern.regular(4, y))
        value = float(sum(locks(rough, direction) for direction in LOCK_DIRECTIONS))
    else:
        flat = Interface(TABLE_2, Pattern.regular(0, 0.0))
        fall = clamped_reversal(flat, np.array([x * S_F]), np.array([y * S_F]), FIRST_SLIP * S_F)
        value = float(fall[0] / TABLE_2.Gc)
    return {"map": name, "x": x, "y": y, "value": value}


def draw_law(rows: Sequence[Row]) -> Figure:
    """Draw locking beside the second law, with the closed forms."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.8), layout="constrained")
    mu, theta, grid = cells([row for row in rows if row["map"] == "locking"], "x", "y", "value")
    levels = np.arange(-0.5, len(LOCK_DIRECTIONS) + 1.0)
    image = left.pcolormesh(
        mu, theta, grid, norm=BoundaryNorm(levels, 256), cmap="cividis", shading="nearest"
    )
    bar = figure.colorbar(image, ax=left, label=f"directions that lock, of {len(LOCK_DIRECTIONS)} [-]")
    bar.set_ticks(range(len(LOCK_DIRECTIONS) + 1))
    slopes = np.linspace(1.0, 60.0, 200)
    for direction, style in zip(LOCK_DIRECTIONS, ("-", "--", "-.", ":"), strict=True):
        boundary = _locking_friction(slopes, np.radians(direction))
        left.plot(boundary, slopes, style, color=COLOURS[1], linewidth=2.0, label=f"{direction:g}°")
    left.legend(title="closed form", fontsize="small")
    left.set(
        xlim=(mu[0], mu[-1]), ylim=(theta[0], theta[-1]), xlabel=r"friction $\mu$ [-]",
        ylabel=r"inclination $\theta$ [degree]",
    )  # fmt: skip
    left.set_title("locking of RP-4", fontsize="medium")
    clamp, back, fall = cells([row for row in rows if row["map"] == "second law"], "x", "y", "value")
    top = max(float(fall.max()), 1e-12)
    image = right.pcolormesh(
        clamp, back, np.where(fall > 0.0, fall, np.nan), vmin=0.0, vmax=top, cmap="cividis"
    )
    right.set_facecolor("white")
    figure.colorbar(image, ax=right, label=r"decrease of the rupture energy [$G_c$]")
    first = FIRST_SLIP / TABLE_2.mu
    right.plot([clamp[-1], first, first], [FIRST_SLIP, FIRST_SLIP, back[-1]], color=COLOURS[1], linewidth=2.0)
    right.set(xlabel=r"closure $-s_N/s_f$ [-]", ylabel=r"slip after the reversal $-s_L/s_f$ [-]")
    right.set_title(rf"flat plane: slip to {FIRST_SLIP:g} $s_f$, closure, slip back", fontsize="medium")
    line = Line2D([], [], color=COLOURS[1], linewidth=2.0, label="closed form")
    right.legend(handles=[line], fontsize="small", loc="upper left")
    return figure
