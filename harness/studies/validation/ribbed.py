"""A ribbed bar in concrete: slip under constant confinement (Malvar 1992), an anchored bar with its cover."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Mapping
from functools import cache

import numpy as np
import pandas
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.material import ModelWarning
from asperity.steps import Step
from asperity.tools.style import TWO, new_figure
from asperity.tools.tables import markdown
from matplotlib.figure import Figure
from scipy.optimize import brentq

from harness.hosts.fenicsx.anchored_constants import (
    COVER,
    DIAMETER,
    E_CONCRETE,
    E_STEEL,
    EMBEDDED,
    NU,
    SOFT_BOND,
    TENSION,
)

from ..concepts_draw import BLACK, BLUE, GREEN, ORANGE, panel
from .common import DATA, Constants, Study, joint
from .common import rows as rows_of
from .wall_runs import Run, printed_by, start

PRESSURES = (3.45, 10.3, 17.2, 24.1, 31.0)
"""Confining stress at the bar, MPa."""

FACTOR = 3.0
"""Strength at the largest over that at the smallest pressure, as the abstract says ("almost threefold")."""

THETA = float(np.degrees(np.arctan(0.8)))
RIBS: Constants = {"mu": 0.5, "theta": THETA, "height": 1.0}
"""Friction, flank and height of the ribs, assumed."""

BOND: Constants = {"sigma0": 5.0, "Gc": 3.0}
CRUSH = 3.0
"""Bond and crushing stress, assumed; the bond of the fit replaces sigma0."""

MODELS = "friction", "crush", "bond", "bond and crush"
"""Sets of constants; the last one is that of the anchored bar."""

SLIP = 4.0


def model(constants: Mapping[str, float]) -> Interface:
    """Joint of two flanks; a joint without bond has the stiffness of the others."""
    values = dict(constants)
    if "sigma0" not in values:
        values |= {"kn": 5e4, "ks": 500.0}
    return joint(values)


@cache
def _curve(constants: tuple[tuple[str, float], ...], pressure: float) -> tuple[Floats, Floats, Floats]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        rows = model(dict(constants)).run(
            [Step(t_N=-pressure, increments=20), Step(slip=SLIP, increments=400)]
        )
    test = rows.after_step(1)
    return test.separation[:, 1], test.traction[:, 1], test.separation[:, 0]


def curve(constants: Mapping[str, float], pressure: float) -> tuple[Floats, Floats, Floats]:
    """Slip, bond stress and radial opening under a constant pressure, mm, MPa."""
    return _curve(tuple(constants.items()), pressure)


def strengths(constants: Mapping[str, float]) -> Floats:
    """Largest bond stress at each pressure."""
    return np.array([curve(constants, pressure)[1].max() for pressure in PRESSURES])


def fits() -> dict[str, Constants]:
    """Bond and crush by the one number of the abstract; the others for comparison."""

    def excess(sigma0: float) -> float:
        strongest = strengths(RIBS | BOND | {"crush": CRUSH, "sigma0": sigma0})
        return float(strongest[-1] / strongest[0] - FACTOR)

    sigma0 = float(f"{brentq(excess, 0.5, 30.0, xtol=1e-3):.4g}")
    bonded = RIBS | BOND | {"crush": CRUSH, "sigma0": sigma0}
    return {
        "friction": RIBS,
        "crush": RIBS | {"crush": CRUSH},
        "bond": RIBS | BOND,
        "bond and crush": bonded,
        **run_bars(bonded),
    }


def model_code(slip: Floats) -> Floats:
    """Bond stress over its largest, Model Code 2010, pull-out, confined, clear rib spacing 12 mm."""
    rising, falling = (slip / 1.0) ** 0.4, 1.0 - 0.6 * (slip - 2.0) / (12.0 - 2.0)
    return np.where(slip < 1.0, rising, np.where(slip < 2.0, 1.0, np.maximum(falling, 0.4)))


# --- an anchored bar ----------------------------------------------------------------------------------------

BAR = {
    "linear": ("--end 0.001", "--end 0.001 --grid 6 4 12 48"),
    "friction": ("--pressure 2 --end 0.3",),
    "ring": ("", "--grid 6 4 12 24"),
}
"""Options of the models with closed forms, the second ones on a finer mesh."""

CASES = {
    "constant confinement 10.3 MPa": "pressure",
    "cover, elastic": "cover",
    "cover, splits": "split",
    "cover, splits, finer mesh": "split --grid 4 2 8 32",
}
"""Options of the models of a ribbed bar by their name."""

LINEAR_CASE = "linear bond"


def cover_stiffness() -> float:
    """Pressure over radial displacement of a thick ring, MPa/mm."""
    inner, outer = 0.5 * DIAMETER, 0.5 * COVER
    return E_CONCRETE / (inner * ((outer**2 + inner**2) / (outer**2 - inner**2) + NU))


def tepfers() -> tuple[float, float]:
    """Pressures at which a brittle and a plastic cover split (Tepfers 1979), MPa."""
    inner, outer = 0.5 * DIAMETER, 0.5 * COVER
    e = np.linspace(inner, outer, 10001)
    brittle = TENSION * e / inner * (outer**2 - e**2) / (outer**2 + e**2)
    return float(brittle.max()), TENSION * (outer - inner) / inner


BETA = float(np.sqrt(4.0 * SOFT_BOND / (DIAMETER * E_STEEL)))
"""Inverse of the length over which a linear bond along a bar in rigid concrete fades, 1/mm."""


def linear_force(slip: float) -> float:
    """Force of a linear bond at a slip of the loaded end, N."""
    return float(0.25 * np.pi * DIAMETER**2 * E_STEEL * BETA * slip * np.tanh(BETA * EMBEDDED))


def cosh(force: float, x: Floats) -> Floats:
    """Stress of a linear bond along the bar, MPa."""
    return np.asarray(force * BETA / (np.pi * DIAMETER) * np.cosh(BETA * x) / np.sinh(BETA * EMBEDDED))


def solids(words: str, ranks: int = 1, run: Run = start) -> tuple[list[list[float]], list[list[float]]]:
    """Rows of displacement, force, pressure, crack, and of place, bond stress, of a model in FEniCSx."""
    lines = printed_by(words, "anchored", ranks, run)
    rows, bond = ([values for name, values in lines if name == kind] for kind in ("row", "bond"))
    return rows, bond


def run_bars(constants: Mapping[str, float]) -> dict[str, Constants]:
    """Run the models in FEniCSx; what those with a closed form find, and files of the others."""
    results: dict[str, Constants] = {}
    curves: list[list[object]] = []
    along: list[list[object]] = []
    for case, several in BAR.items():
        for name, words in zip((f"bar {case}", f"bar {case}, fine"), several, strict=False):
            if case == "ring":
                [(_, [stiffness])] = printed_by(f"ring {words}", "anchored")
                results[name] = {"value": stiffness}
                continue
            lines, bond = solids(f"{case} {words}")
            x, tau = np.transpose(bond)
            if name == "bar linear":
                along += [[LINEAR_CASE, *line] for line in bond]
            away = tau / cosh(lines[-1][1], x) - 1.0 if case == "linear" else np.zeros(1)
            results[name] = {"value": lines[-1][1], "away": float(np.abs(away).max())}
    arguments = " ".join(f"{name}={value:g}" for name, value in constants.items())
    for name, words in CASES.items():
        case, _, more = words.partition(" ")
        lines, bond = solids(f"{case} {arguments} --end {SLIP - 1.0:g} {more}")
        curves += [[name, *line] for line in lines]
        along += [[name, *line] for line in bond]
    for stem, columns, table in (
        ("curves", ["case", "displacement", "force", "pressure", "crack"], curves),
        ("bond", ["case", "place", "stress"], along),
    ):
        text = pandas.DataFrame(table, columns=columns).to_csv(index=False, float_format="%.5g")
        heading = "# Made by python -m harness.studies.validation.ribbed --fit\n"
        (DATA / f"ribbed_{stem}.csv").write_text(heading + text, encoding="utf-8")
    return results


def anchored(case: str) -> pandas.DataFrame:
    """Rows of a ribbed bar: displacement, force, pressure and opening of the crack, mm, N, MPa."""
    return rows_of("ribbed_curves").query("case == @case")


def tables(results: Mapping[str, Constants]) -> dict[str, str]:
    """Strengths and openings of the fits, the curve beside the Model Code, the anchored bar."""
    body = []
    for fit in MODELS:
        constants = results[fit]
        strong = strengths(constants)
        opened = [curve(constants, pressure)[2].max() for pressure in (PRESSURES[0], PRESSURES[-1])]
        body.append([fit, *(f"{strength:.1f}" for strength in strong), f"{strong[-1] / strong[0]:.2f}",
                     *(f"**{opening:.2f}**" for opening in opened)])  # fmt: skip
    head = [
        "model",
        *(f"{pressure:g} MPa" for pressure in PRESSURES),
        "factor",
        "opening at 3.45 MPa, mm",
        "at 31 MPa, mm",
    ]
    slip, tau, _ = curve(results["bond and crush"], PRESSURES[2])
    rows = []
    for at in (0.1, 0.25, 0.5, 1.0, 2.0, 4.0):
        ours = float(np.interp(at, slip, tau) / tau.max())
        rows.append([f"{at:g}", f"{ours:.2f}", f"{float(model_code(np.array(at))):.2f}"])
    bars = []
    for case in CASES:
        path = anchored(case)
        top = path.loc[path.force.idxmax()]
        numbers = top.force / 1e3, top.force / (np.pi * DIAMETER * EMBEDDED), top.displacement
        cells = [f"{number:.{2 if i == 2 else 1}f}" for i, number in enumerate(numbers)]
        last = path.iloc[-1]
        cells.append(f"{last.force / 1e3:.1f}" if last.displacement > 0.99 * (SLIP - 1.0) else "off")
        bars.append([case, *cells, f"{path.pressure.max():.1f}"])
    bar_head = [
        "restraint", "largest force, kN", "mean bond stress, MPa", "at the displacement, mm",
        "force at 3 mm, kN", "largest mean pressure, MPa",
    ]  # fmt: skip
    low, high = tepfers()
    most = anchored("cover, splits").pressure.max()
    return {
        "strengths": markdown(head, body),
        "curve": markdown(["slip, mm", "law at 17.2 MPa", "Model Code 2010"], rows),
        "closed": markdown(["case", "quantity", "closed form", "FE", "error", "finer mesh"], closed(results)),
        "bar": markdown(bar_head, bars),
        "tepfers": f"After Tepfers (1979) a brittle ring splits at {low:.1f} MPa, a plastic one at "
        f"{high:.1f} MPa;\nthe largest mean pressure here is {most:.1f} MPa.",
    }


def closed(results: Mapping[str, Constants]) -> list[list[str]]:
    """Rows of the models with closed forms."""

    def away(closed: float, name: str) -> str:
        return f"{100.0 * (results[name]['value'] / closed - 1.0):+.2f} %" if name in results else ""

    rows = []
    plastic, stiffness = np.pi * DIAMETER * EMBEDDED * 0.4 * 2.0, cover_stiffness()
    for case, name, quantity, value in (
        ("linear bond, rigid concrete", "bar linear", "force at 1 µm, N", linear_force(1e-3)),
        ("friction 0.4 under 2 MPa", "bar friction", "largest force, N", plastic),
        ("cover alone", "bar ring", "pressure over radial displacement, MPa/mm", stiffness),
    ):
        ours = results[name]["value"]
        rows.append(
            [case, quantity, f"{value:.1f}", f"{ours:.1f}", away(value, name), away(value, f"{name}, fine")]
        )
    shape = [f"{100.0 * results[name]['away']:.2f} %" for name in ("bar linear", "bar linear, fine")]
    rows.insert(1, ["", "largest error of the stress along the bar", "cosh", "", *shape])
    return rows


def draw(results: Mapping[str, Constants]) -> Figure:
    """Draw bond stress over slip at five pressures; force, bond stress along the bar and pressure."""
    figure, (point, force, along, pressure) = new_figure(TWO, 5.4, nrows=2, ncols=2)
    for p in PRESSURES:
        slip, tau, _ = curve(results["bond and crush"], p)
        point.plot(slip, tau, color=BLUE)
        point.annotate(f"{p:g} MPa", (slip[-1], tau[-1]), ha="right", va="bottom", fontsize=7)
    slip, tau, _ = curve(results["bond and crush"], PRESSURES[2])
    point.plot(slip, tau.max() * model_code(slip), "--", color=BLACK, label="Model Code, scaled")
    panel(point, "slip [mm]", "bond stress [MPa]")
    bond = rows_of("ribbed_bond").set_index("case")
    for case, colour in zip(CASES, (BLUE, GREEN, BLACK), strict=False):
        path, values = anchored(case), bond.loc[case]
        force.plot(path.displacement, path.force / 1e3, color=colour, label=case)
        pressure.plot(path.displacement, path.pressure, color=colour, label=case)
        along.plot(values.place, values.stress / values.stress.mean(), color=colour, label=case)
    values = bond.loc[LINEAR_CASE]
    along.plot(values.place, values.stress / values.stress.mean(), color=ORANGE, label=LINEAR_CASE)
    closed_form = cosh(results["bar linear"]["value"], np.asarray(values.place))
    along.plot(values.place[::3], closed_form[::3] / values.stress.mean(), "o", color=ORANGE, markersize=3)
    for level in tepfers():
        pressure.axhline(level, color=BLACK, linestyle=":", linewidth=0.8)
    panel(force, "displacement of the loaded end [mm]", "force [kN]")
    panel(along, "place along the bar [mm]", "bond stress over its mean [-]")
    panel(pressure, "displacement of the loaded end [mm]", "mean pressure on the bar [MPa]")
    for ax in (force, pressure):
        ax.set_yscale("log")
    force.set_ylim(1.0, 600.0)
    pressure.set_ylim(0.1, 200.0)
    for ax in (point, force, along):
        ax.legend(fontsize=7)
    return figure


STUDY = Study("ribbed", fits, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
