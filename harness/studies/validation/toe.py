"""Slender walls whose toe crushes, beside the equilibrium of a rigid wall: tables and picture of its page."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
import pandas
from asperity.contract import Floats
from asperity.tools.style import COLOURS, TWO, new_figure
from asperity.tools.tables import markdown
from matplotlib.figure import Figure
from scipy.optimize import brentq, linprog
from scipy.sparse import hstack, identity, vstack

from harness.hosts.fenicsx.toe_constants import CSS, MU, SOFTENING, YIELDING

from .common import DATA, Constants, Study, rows
from .wall_runs import printed_by

SHOWN = 0.2
"""Share of fc L t of the wall of the picture, whose Css is 0."""

LENGTH = 1000.0
"""Length in mm of the walls in the tables; those of other lengths are the same within their meshes."""


def plain(share: float, slenderness: float) -> float:
    """Force over N of a toe that yields at fc; slenderness: height over length."""
    return (1.0 - share) / (2.0 * slenderness)


def sheared(share: float, slenderness: float, Css: float) -> float:
    """The same of a toe whose pressure is sqrt(fc^2 - Css tau^2) with an even shear traction tau."""

    def excess(ratio: float) -> float:
        return ratio - plain(share * np.sqrt(1.0 + Css * ratio**2), slenderness)

    return float(brentq(excess, 0.0, plain(share, slenderness)))


@cache
def most(share: float, slenderness: float, Css: float, mu: float, cells: int = 400, sides: int = 64) -> float:
    """Largest force over N of any distribution of pressure and shear that the strength and friction admit.

    A linear programme over cells of the joint; tangents of the ellipse are on the safe side of a bound.
    """
    x, each = (np.arange(cells) + 0.5) / cells, identity(cells)
    angles = np.linspace(0.0, 0.5 * np.pi, sides)
    bounds = [hstack([np.cos(a) * each, np.sqrt(Css) * np.sin(a) * each]) for a in angles]
    bounds.append(hstack([-mu * each, each]))
    ends = np.r_[np.ones(cells * sides), np.zeros(cells)]
    ones = np.full(cells, 1.0 / cells)
    sums = np.array([np.r_[ones, 0.0 * ones], np.r_[x / cells, slenderness * ones]])
    found = linprog(
        -np.r_[0.0 * ones, ones],
        vstack(bounds),
        ends,
        sums,
        [share, 0.5 * share],
        (0.0, None),
        method="highs",
    )
    if found.status != 0:
        raise RuntimeError(f"the linear programme: {found.message}")
    return float(-found.fun / share)


def run() -> dict[str, Constants]:
    """Run the walls, and store the points of the picture; constants: largest forces, paths of the top."""
    results: dict[str, Constants] = {}
    points = []
    for name, numbers in printed_by("", "toe"):
        kind, _, rest = name.partition(" ")
        if kind == "limit":
            results[rest] = {"force": numbers[0]}
        elif kind == "moved":
            results[rest] = dict(zip(("force", "end", "e_t", "steps", "iterations"), numbers, strict=True))
        else:
            points.append([name, *numbers])
    table = pandas.DataFrame(points, columns=["line", "x", "y"]).to_csv(index=False, float_format="%.5g")
    heading = "# Made by python -m harness.studies.validation.toe --fit\n"
    (DATA / "toe_picture.csv").write_text(heading + table, encoding="utf-8")
    return results


def limits(results: Mapping[str, Constants]) -> dict[tuple[float, ...], float]:
    """Largest forces over N by length, height, share, Css and Gfc."""
    return {
        tuple(float(word) for word in name.split()): values["force"]
        for name, values in results.items()
        if len(name.split()) == 5
    }


def away(found: float, expected: float) -> str:
    """Difference in percent."""
    return f"{100.0 * (found / expected - 1.0) + 0.0:+.2f}"


def walls_of(found: Mapping[tuple[float, ...], float]) -> list[tuple[float, float, float]]:
    """Lengths, heights and shares."""
    return list(dict.fromkeys((length, height, share) for length, height, share, *_ in found))


def shown(found: Mapping[tuple[float, ...], float]) -> list[tuple[float, float, float]]:
    """Walls of the tables."""
    return [wall for wall in walls_of(found) if wall[0] == LENGTH]


def yields(found: Mapping[tuple[float, ...], float]) -> str:
    """Table of the toes that yield."""
    body = []
    for length, height, share in shown(found):
        slenderness = height / length
        alone, both = (found[length, height, share, Css, YIELDING] for Css in (0.0, CSS))
        closed, formula = plain(share, slenderness), sheared(share, slenderness, CSS)
        bound = most(share, slenderness, CSS, MU)
        body.append([
            f"{length:g} x {height:g}", f"{share:g}", f"{closed:.4f}", f"{alone:.4f}", away(alone, closed),
            f"{formula:.4f}", f"{both:.4f}", f"**{away(both, formula)}**", f"{bound:.4f}",
        ])  # fmt: skip
    head = ["L x H, mm", "N/(fc L t)", "plain", "Css 0", "%", "with shear", "Css 9", "%", "at most"]
    return markdown(head, body)


def softens(found: Mapping[tuple[float, ...], float]) -> str:
    """Table of the toes that soften, over both formulas."""
    body = []
    for length, height, share in shown(found):
        cells = [f"{length:g} x {height:g}", f"{share:g}"]
        formula, closed = sheared(share, height / length, CSS), plain(share, height / length)
        for Gfc in SOFTENING:
            force = found[length, height, share, CSS, Gfc]
            cells += [f"{away(force, formula)}, {away(force, closed)}"]
        body.append(cells)
    head = ["L x H, mm", "N/(fc L t)", *(f"Gfc {Gfc:g} N/mm" for Gfc in SOFTENING)]
    return markdown(head, body)


def moved(results: Mapping[str, Constants]) -> str:
    """Table of the paths of the top."""
    body = []
    first = next(values for name, values in results.items() if "end" in values)
    for name, values in results.items():
        if "end" in values:
            forces = [
                f"{values[kind]:.5f} ({away(values[kind], first[kind])} %)" for kind in ("force", "end")
            ]
            counts = [f"{values[kind]:.0f}" for kind in ("steps", "iterations")]
            body.append([name, *forces, f"{values['e_t']:.1g}", *counts])
    head = ["method", "largest force over N", "at 20 mm", "largest e_t", "steps", "iterations"]
    return markdown(head, body)


def tables(results: Mapping[str, Constants]) -> dict[str, str]:
    """Tables of the page."""
    found = limits(results)
    return {"yields": yields(found), "softens": softens(found), "moved": moved(results)}


def draw(_: Mapping[str, Constants]) -> Figure:
    """Draw force over rotation of the wall, and pressure of its toe at the peak and at the end."""
    figure, (forces, pressures) = new_figure(TWO, 2.9, ncols=2)
    lines: dict[str, Floats] = {
        name: part[["x", "y"]].to_numpy(float)
        for name, part in rows("toe_picture").groupby("line", sort=False)
    }
    energies: Sequence[float] = (YIELDING, *SOFTENING)
    for colour, Gfc in zip(COLOURS, energies, strict=False):
        label = f"Gfc = {Gfc:g} N/mm"
        turned = lines[f"force {Gfc:g}"]
        forces.plot(1e3 * turned[:, 0], turned[:, 1], color=colour, label=label)
        for state, style in (("peak", "-"), ("end", "--")):
            if (name := f"pressure {Gfc:g} {state}") in lines:
                shown = label if state == "peak" else None
                pressures.plot(*lines[name].T, style, color=colour, label=shown)
    line = {"color": "black", "linewidth": 0.6, "linestyle": ":"}
    forces.axhline(plain(SHOWN, 2.5), **line, label="toe that yields")
    forces.set(xlabel="rotation [mrad]", ylabel="horizontal force over N [-]", xlim=(0, 12), ylim=(0, 0.18))
    pressures.set(xlabel="place along the joint [mm]", ylabel="pressure [MPa]", xlim=(600, 1000), ylim=(0, 7))
    for panel in (forces, pressures):
        panel.legend()
        panel.grid(alpha=0.3)
    return figure


STUDY = Study("toe", run, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
