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
from asperity.tools.style import ONE, new_figure
from asperity.tools.tables import markdown
from matplotlib.figure import Figure

from ..concepts_draw import BLACK, BLUE, GREEN, panel
from .common import LOST, Constants, Study, fitted, rms, rows

PARTS = ("loading", "unloading")
FORMS: dict[str, list[Constants]] = {
    "one stiffness": [{"kn": 60.0}],
    "hyperbola": [{"kn": 25.0, "closure": 0.2}],
}
"""Starts of the free constants of each form of the law."""

SIZE = (10.0, 0.13)
"""Largest stress, MPa, and closure, mm."""


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
    found: Floats = history.dilation[0] - history.after_step(1).dilation[-pressures.size :]
    return found


def differences(constants: Mapping[str, float]) -> dict[str, Floats]:
    """Model less measurement over loading and unloading, mm."""
    tests = np.concatenate([measured(part) for part in PARTS])
    away = closures(constants, tests[:, 0]) - tests[:, 1]
    return dict(zip(PARTS, np.split(away, [len(measured("loading"))]), strict=True))


def fits() -> dict[str, Constants]:
    """Fit both forms of the law to the loading."""
    return {
        form: fitted(lambda one: differences(one)["loading"] / SIZE[1], starts, SIZE)
        for form, starts in FORMS.items()
    }


def tables(found: Mapping[str, Constants]) -> dict[str, str]:
    """Table of the constants and of the errors of every fit."""
    body = []
    for form, constants in found.items():
        away = {part: f"{rms(one):.4f}" for part, one in differences(constants).items()}
        closure = f"{constants['closure']:g}" if "closure" in constants else ""
        body.append([form, f"{constants['kn']:g}", closure, away["loading"], f"**{away['unloading']}**"])
    head = ["contact", "kn, MPa/mm", "closure, mm", "error of loading, mm", "of unloading, mm"]
    return {"errors": markdown(head, body)}


def draw(found: Mapping[str, Constants]) -> Figure:
    """Draw the pressure over the closure."""
    figure, [ax] = new_figure(ONE, 3.0)
    pressures = np.linspace(*measured("loading")[[0, -1], 0], 60)
    for (form, constants), colour, style in zip(found.items(), (BLUE, GREEN), ("--", "-"), strict=True):
        ax.plot(closures(constants, pressures), pressures, style, color=colour, label=form)
    for part, fill in zip(PARTS, ("full", "none"), strict=True):
        sigma, closure = measured(part).T
        ax.plot(closure, sigma, "o", color=BLACK, markersize=4, fillstyle=fill, label=f"measured, {part}")
    panel(ax, "closure [mm]", "pressure [MPa]")
    ax.legend()
    return figure


STUDY = Study("closure", fits, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
