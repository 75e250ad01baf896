"""Error against cost, for docs/results/accuracy.md: increments of the path, planes of the pattern.

The parameters are those of Table 2, in mm and MPa, unless stated.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from itertools import product
from pathlib import Path

import numpy as np
import pandas
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.material import Material
from asperity.pattern import Pattern
from asperity.tools.slip_curves import SlipCurves, slip_curves
from asperity.tools.style import COLOURS, TWO, new_figure, printed, save
from asperity.tools.tables import markdown
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from harness.studies.paper.fracture_energy import MATERIAL, THETA, fracture_energy
from harness.studies.paper.outcome import signed

from .program import program
from .tables import refresh

SIGMA_N = (0.0, -1.0, -5.0, -10.0)
"""Normal tractions, MPa."""

DIRECTION = 20.0
"""Direction of slip, degrees, which is no plane of symmetry of RP-4."""

PRELOAD = 4
"""Increments of the preload. Each plane slides in one direction only, so a few increments are exact."""

AIMS = (1.0e-2, 1.0e-3, 1.0e-4)
"""Target errors of the tables."""


PATHS = {"monotonic": (0.6,), "cyclic": (0.4, -0.4, 0.4)}
"""Slips at the ends of the strokes of a path, mm."""


def slips_of(path: str, increments: int) -> Floats:
    """Slips of a path in equal increments, a multiple of 5 for a cycle."""
    turns = np.array([0.0, *PATHS[path]])
    ends = np.cumsum(np.abs(np.diff(turns, prepend=0.0)))
    return np.interp(ends[-1] * np.arange(1, increments + 1) / increments, ends, turns)


def log_axes(ax: Axes, x_label: str, y_label: str) -> None:
    """Set logarithmic axes with labels and a grid."""
    ax.set(xscale="log", yscale="log", xlabel=x_label, ylabel=y_label)
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.grid(alpha=0.3, which="major")


# --- increments ---------------------------------------------------------------------------------------------

INCREMENTS = tuple(30 * 2**k for k in range(9))
"""Numbers of increments, 30 to 7680."""

FINER = 8
"""Factor from the increments of the finest run to those of the reference."""

QUANTITIES = (("tau_L", r"$\tau_L$", "τ_L"), ("s_N", "$s_N$", "s_N"), ("work", "work", "work"))
"""Columns of `step_errors` and their names in pictures and tables."""


def step_errors(increments: Sequence[int] = INCREMENTS) -> pandas.DataFrame:
    """Errors of RP-4, 30 degrees, by path, sigma_N and number of increments (rows).

    Those of tau_L, s_N and work are relative to the largest value of the curve.
    """
    interface = Interface(MATERIAL, Pattern.regular(4, THETA))
    measured = []
    for path, sigma_N in product(PATHS, SIGMA_N):
        fine = slip_curves(interface, DIRECTION, slips_of(path, FINER * increments[-1]), sigma_N, PRELOAD)
        for n in increments:
            coarse = slip_curves(interface, DIRECTION, slips_of(path, n), sigma_N, PRELOAD)
            rows = slice(fine.slips.size // n - 1, None, fine.slips.size // n)
            pairs = {"tau_L": (coarse.tau_L[0], fine.tau_L[0]), "s_N": (coarse.s_N[0], fine.s_N[0])}
            errors = {key: np.abs(a - b[rows]).max() / np.abs(b).max() for key, (a, b) in pairs.items()}
            errors["work"] = abs(coarse.work[0, -1] / fine.work[0, -1] - 1.0)
            measured.append({"path": path, "sigma_N": sigma_N, "rows": n, **errors})
    return pandas.DataFrame(measured)


def draw_increments(quick: bool) -> tuple[Figure, str]:
    """Run the study of increments; return its picture and its table."""
    sizes = (30, 60) if quick else INCREMENTS
    errors = step_errors(sizes)
    worst = errors.groupby(["path", "rows"])[[name for name, _, _ in QUANTITIES]].max()
    figure, (ax,) = new_figure(0.6 * TWO, 3.2)
    for (name, label, _), colour in zip(QUANTITIES, COLOURS, strict=False):
        for path, line in zip(PATHS, ("o-", "D--"), strict=True):
            style = {"color": colour, "markersize": 3.0, "linewidth": 1.0}
            ax.plot(sizes, worst.loc[path][name], line, label=f"{label}, {path}", **style)
    log_axes(ax, "increments of the path", "largest relative error of four pressures")
    ax.set_title("twice the increments, half the error")
    ax.legend()
    lines = []
    for (path, sigma_N), here in errors.groupby(["path", "sigma_N"], sort=False):
        cells = [_needed(here, name, AIMS[1]) for name, _, _ in QUANTITIES]
        lines.append([path, signed(sigma_N), *cells])
    head = ["path", "σ_N [MPa]", *(f"{name} to {AIMS[1]:.0e}" for _, _, name in QUANTITIES)]
    return figure, markdown(head, lines, numbers=True)


def _needed(errors: pandas.DataFrame, name: str, aim: float) -> str:
    """Fewest increments such that their error and those of all finer runs are below the target."""
    good = (errors[name] <= aim)[::-1].cummin()
    return str(errors.rows[good[good].index[-1]]) if good.any() else f"> {errors.rows.max()}"


# --- planes -------------------------------------------------------------------------------------------------

FLAT = 1.0 / 3.0
"""Weight of the flat plane, as in Table 4."""

REFERENCE_SIDES = 64
"""Sides of the reference; its spread over directions is 0.09 % at 30 degrees and mu = 0.5."""

SIDES = (3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 16, 17, 24, 25, 32, 33, 48, 49, 63, 64)
"""Sides of the patterns."""

DIRECTIONS = 9
"""Number of slip directions, from one plane of symmetry to the next; all others are equivalent to these."""

PLANE_INCREMENTS = {"monotonic": 240, "cyclic": 800}
"""Number of increments of 0.0025 mm; their error is about the same for all patterns and directions."""

ENERGY_TOLERANCE = 1.0e-5
"""G_T counts as converged if the last halving of the steps changes it by at most this fraction of Gc."""

MEASURES = {
    "tau_L": "τ_L", "across": "across", "s_N": "s_N", "work": "spread of work", "loop": "spread of loops",
}  # fmt: skip
"""Columns of `plane_errors` and their names in the tables."""

PLANE_TICKS = (4, 8, 16, 32, 64)
"""Numbers of planes with a label; the axis is logarithmic."""


def residual_spread(sides: int) -> float:
    """Ratio of the residual strengths up a plane and between two planes, minus 1."""
    facing, between = MATERIAL.residual_strength(THETA, [0.0, 180.0 / sides])
    return float(facing / between - 1.0)


def plane_errors(
    sides: Iterable[int],
    tractions: Sequence[float] = SIGMA_N,
    law: Material = MATERIAL,
) -> pandas.DataFrame:
    """Errors of RP-m (sides) against RP-64 of the same flat weight in the worst direction, and spreads.

    tau_L, across, s_N: L2 norms over the monotonic path, relative to tau_L and s_N of the reference. work:
    spread (largest over smallest, minus 1) over the directions of the work of that path, which is G_T at
    sigma_N = 0. loop: the same for the work of a closed loop of a cycle, NaN at sigma_N = 0.
    """
    measured = []
    slips, loops = (slips_of(path, n) for path, n in PLANE_INCREMENTS.items())
    dense = Interface(law, Pattern.regular(REFERENCE_SIDES, THETA, FLAT))
    reference = slip_curves(dense, 0.0, slips, np.array(tractions), PRELOAD)
    for m in sides:
        interface = Interface(law, Pattern.regular(m, THETA, FLAT))
        angles = np.linspace(0.0, 180.0 / m, DIRECTIONS)
        for tau, s_N, sigma_N in zip(reference.tau_L, reference.s_N, tractions, strict=True):
            curves = slip_curves(interface, angles, slips, sigma_N, PRELOAD)
            if sigma_N < 0.0:
                work = _spread(curves.work[:, -1])
                loop = _spread(_loops(slip_curves(interface, angles, loops, sigma_N, PRELOAD)))
            else:
                # here the error of the increments exceeds the spread of fine patterns
                work = fracture_energy(law, interface.pattern, angles, ENERGY_TOLERANCE).spread
                loop = np.nan
            row = {"sides": m, "sigma_N": sigma_N, "tau_L": relative_error(curves.tau_L - tau, tau)}
            row |= {"across": relative_error(curves.tau_across, tau)}
            measured.append(row | {"s_N": relative_error(curves.s_N - s_N, s_N), "work": work, "loop": loop})
    return pandas.DataFrame(measured)


def relative_error(error: Floats, reference: Floats) -> float:
    """Largest ratio, over the curves, of the L2 norm of the error to that of the reference."""
    return float(np.max(np.linalg.norm(error, axis=-1)) / np.linalg.norm(reference))


def _spread(values: Floats) -> float:
    return float(values.max() / values.min() - 1.0)


def _loops(curves: SlipCurves) -> Floats:
    """Work of the closed loop of the last two strokes of a cycle."""
    first = curves.slips.size // 5 - 1
    return np.trapezoid(curves.tau_L[:, first:], curves.slips[first:], axis=1)


def draw_planes(quick: bool) -> tuple[Figure, str]:
    """Run the study of planes; return its picture and its tables."""
    sides, tractions = ((3, 4, 5), (0.0, -5.0)) if quick else (SIDES, SIGMA_N)
    errors = plane_errors(sides, tractions=tractions)
    worst = errors.groupby("sides").max()  # at sigma_N = 0 there is no loop
    figure, (ax,) = new_figure(0.6 * TWO, 3.2)
    for (name, label), colour in zip(MEASURES.items(), COLOURS, strict=False):
        words = f"error, {label}" if name in SHARED else label
        ax.plot(worst.index + 1, worst[name], "o-", color=colour, markersize=3.0, linewidth=1.0, label=words)
    log_axes(ax, "number of planes", "largest of all directions and four pressures")
    ax.set_xticks(PLANE_TICKS, [str(n) for n in PLANE_TICKS])
    ax.set_xticks([], minor=True)
    ax.axhline(AIMS[0], color="grey", linewidth=0.8, linestyle=":")
    ax.set_title("26 planes: everything within 1 %")
    ax.legend()
    needs = []
    for sigma_N, here in errors.groupby("sigma_N", sort=False):
        names = [name for name in MEASURES if not (name == "loop" and sigma_N == 0.0)]
        for aim in AIMS[:2]:
            good = [here.sides[here[name] <= aim] for name in names]
            fewest = [
                str(sides_that_meet.min()) if len(sides_that_meet) else f"> {here.sides.max()}"
                for sides_that_meet in good
            ]
            needs.append([signed(sigma_N), f"{100 * aim:g} %", *fewest])
    for aim in AIMS[:2]:
        enough = next(m for m in range(3, 1000) if residual_spread(m) <= aim)
        needs.append(["< 0, residual strength", f"{100 * aim:g} %", str(enough)])
    head = ["σ_N [MPa]", "aim", *MEASURES.values()]
    filled = [[*row, *[""] * (len(head) - len(row))] for row in needs]
    text = "Fewest inclined planes m that meet an aim:\n\n" + markdown(head, filled, numbers=True)
    return figure, text


SHARED = ("tau_L", "across", "s_N")
"""Measures that are errors; the others are spreads over the directions."""

# --- program ------------------------------------------------------------------------------------------------

STUDIES = {"increments": draw_increments, "planes": draw_planes}
"""Studies by the names of their pictures and markers: picture and table."""


def _write(options: argparse.Namespace) -> int:
    """Run studies, write pictures, and print the tables or fill them into a page."""
    options.folder.mkdir(parents=True, exist_ok=True)
    for name in options.only or STUDIES:
        with printed():
            figure, table = STUDIES[name](options.quick)
            save(figure, options.folder / f"accuracy_{name}.png")
        print(options.folder / f"accuracy_{name}.png")
        if options.page is None:
            print(f"\n{table}\n")
        else:
            refresh(options.page, False, {f"accuracy-{name}": table})
    return 0


main = program(
    _write,
    ("--folder DIR", "folder of the pictures", Path()),
    ("--page FILE.md", "fill the numbers into a page, between markers as <!-- accuracy-planes -->", Path),
    ("--only STUDY", "which", str, {"nargs": "+", "choices": STUDIES}),
    ("--quick", "very small sizes, for a test of the program"),
)

if __name__ == "__main__":
    sys.exit(main())
