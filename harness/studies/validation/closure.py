"""Closure of a granite fracture under pressure (Vogler et al. 2018): loading fitted, unloading predicted."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache

import numpy as np
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.material import Material
from asperity.pattern import Pattern
from asperity.steps import Step
from asperity.tools.fit.closure_test import ClosureTest
from asperity.tools.fit.closures import fit_closures
from asperity.tools.style import ONE, new_figure
from asperity.tools.tables import markdown
from matplotlib.figure import Figure

from ..concepts_draw import BLACK, BLUE, GREEN, panel
from .common import LOST, Constants, Study, by_product, fitted, rms, rows

PARTS = ("loading", "unloading")
FITTED = "hyperbola, asperity fit"
"""What `asperity fit` chooses; its constants are those of the picture."""

START, SIZE = {"kn": 60.0}, (10.0, 0.13)
"""Start of one stiffness; largest stress, MPa, and closure, mm."""


@cache
def measured(part: str) -> Floats:
    """Pressure, MPa, and closure since the first reading, mm, of loading or unloading, (n, 2)."""
    return rows("closure").query("part == @part")[["sigma", "closure"]].to_numpy()


def closures(constants: Mapping[str, float], pressures: Floats) -> Floats:
    """Closure of the model since the first reading on a path of pressures."""
    flat = Interface(Material.from_joint(mu=0.6, ks=constants["kn"], **constants), Pattern.regular(0, 0.0))
    first = measured("loading")[0, 0]
    history, lost = flat.rows([Step(t_N=-first, increments=1), Step(t_N=list(-pressures), increments=1)])
    if lost:
        return np.full(pressures.size, LOST)
    openings: Floats = history.dilation[0] - history.after_step(1).dilation[-pressures.size :]
    return openings


def differences(constants: Mapping[str, float]) -> dict[str, Floats]:
    """Model less measurement over loading and unloading, mm."""
    tests = np.concatenate([measured(part) for part in PARTS])
    away = closures(constants, tests[:, 0]) - tests[:, 1]
    return dict(zip(PARTS, np.split(away, [len(measured("loading"))]), strict=True))


def fits() -> dict[str, Constants]:
    """Fit one stiffness to the loading, and what `asperity fit` finds of both."""
    one_stiffness = fitted(lambda constants: differences(constants)["loading"] / SIZE[1], [START], SIZE)
    pressure, closure = np.concatenate([measured(part) for part in PARTS]).T
    return {
        "one stiffness": one_stiffness,
        FITTED: by_product(fit_closures([ClosureTest("vd1", pressure, closure)])),
    }


def contact(constants: Mapping[str, float]) -> Constants:
    """Constants of the contact among what a fit has found."""
    return {name: constants[name] for name in ("kn", "closure") if name in constants}


def tables(results: Mapping[str, Constants]) -> dict[str, str]:
    """Table of the constants and of the errors of every fit."""
    body = []
    for form, constants in results.items():
        away = {part: f"{rms(part_of):.4f}" for part, part_of in differences(contact(constants)).items()}
        cells = []
        for name in ("kn", "closure"):
            ends = (
                f" [{constants[f'{name}_low']:.4g}, {constants[f'{name}_high']:.4g}]"
                if f"{name}_low" in constants
                else ""
            )
            cells.append(f"{constants[name]:.4g}{ends}" if name in constants else "")
        body.append([form, *cells, away["loading"], f"**{away['unloading']}**"])
    head = ["contact", "kn, MPa/mm", "closure, mm", "error of loading, mm", "of unloading, mm"]
    return {"errors": markdown(head, body)}


def draw(results: Mapping[str, Constants]) -> Figure:
    """Draw the pressure over the closure."""
    figure, [ax] = new_figure(ONE, 3.0)
    pressures = np.linspace(*measured("loading")[[0, -1], 0], 60)
    for (form, constants), colour, style in zip(results.items(), (BLUE, GREEN), ("--", "-"), strict=True):
        ax.plot(closures(contact(constants), pressures), pressures, style, color=colour, label=form)
    for part, fill in zip(PARTS, ("full", "none"), strict=True):
        sigma, closure = measured(part).T
        ax.plot(closure, sigma, "o", color=BLACK, markersize=4, fillstyle=fill, label=f"measured, {part}")
    panel(ax, "closure [mm]", "pressure [MPa]")
    ax.legend()
    return figure


STUDY = Study("closure", fits, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
