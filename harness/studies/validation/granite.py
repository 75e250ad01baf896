"""Slip of granite fractures under injection (Ye and Ghassemi 2018): fits, predictions."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache

import numpy as np
from asperity.contract import Floats
from asperity.steps import Step
from asperity.tools.style import TWO, new_figure
from asperity.tools.tables import markdown
from matplotlib.figure import Figure

from ..concepts_draw import BLACK, BLUE, GREEN, ORANGE, panel
from .common import LOST, Constants, Study, fitted, joint, rows

SPECIMENS = ("SW-T1", "SW-T2")
QUANTITIES = {"tau": "shear stress [MPa]", "dn": "opening [mm]", "ds": "slip [mm]"}
"""What is compared, and the names of the axes."""

ONSET, ARREST = 4, 5
"""Rows of stages 5 and 6, before and after the slip."""

ANGLE = np.radians(30.0)
"""Between the fracture and the axis: by it sn follows tau and the water pressure in the table."""

STIFF = 2e5
"""Stiffness of the contact, MPa/mm, that is so large that it has no effect."""

LOADING, INCREMENTS, REPEATS = 20, 40, 4
"""Increments of the loading and of a stage, and solutions until the opening acts back on the machine."""

STAGES = {"5 and 6": None, "1 to 7": 7, "all": 11}
"""Stages of a fit: a closed form, or the number of stages in least squares."""

STARTS: dict[str, list[Constants]] = {
    "SW-T1": [
        {"mu": 0.7, "theta": 38.7, "flat": 0.8, "height": 0.25, "kn": 3e3, "ks": 3e3, "closure": 1.0},
        {"mu": 0.7, "theta": 20.0, "flat": 0.1, "height": 0.28, "kn": 500.0, "ks": 2e4, "closure": 1.0},
    ],
    "SW-T2": [
        {"mu": 0.68, "theta": 18.8, "flat": 0.1, "height": 0.28, "kn": 1700.0, "ks": 1e5, "closure": 0.035},
        {"mu": 0.7, "theta": 20.0, "flat": 0.5, "height": 0.25, "kn": 3e3, "ks": 3e3, "closure": 1.0},
    ],
}
MARKS = {"tau": 5.3, "dn": 3.5, "ds": 2.7}
"""Mean errors of another public code, in percent of the range, fitted to the table."""


@cache
def measured(name: str) -> dict[str, Floats]:
    """sn, tau, dn (opening positive) and ds of the stages, (11,) each."""
    table = rows("granite").query("specimen == @name")
    return {key: table[key].to_numpy(float) for key in ("sn", "tau", "ds")} | {
        "dn": -table.dn.to_numpy(float)
    }


def machine(name: str) -> tuple[float, float]:
    """Fall of tau by a slip and its rise by an opening, MPa/mm: the piston stands still from stage 5 to 6."""
    readings = measured(name)
    fall, slip, opening = (readings[key][ARREST] - readings[key][ONSET] for key in ("tau", "ds", "dn"))
    axial = -fall / (slip * np.cos(ANGLE) - opening * np.sin(ANGLE))
    return float(axial * np.cos(ANGLE)), float(axial * np.sin(ANGLE))


def closed_form(name: str) -> Constants:
    """mu, theta and height of a rigid joint that begins to slip at stage 5 and stops at stage 6."""
    from scipy.optimize import brentq

    readings = measured(name)
    ratios = readings["tau"][[ONSET, ARREST]] / readings["sn"][[ONSET, ARREST]]
    slip, opening = (readings[key][ARREST] - readings[key][ONSET] for key in ("ds", "dn"))

    def height(mu: float) -> tuple[float, float, float]:
        first, last = (ratios - mu) / (1.0 + ratios * mu)
        return slip * first / np.log(first / last), first, last

    def missing(mu: float) -> float:
        size, first, last = height(mu)
        return float(size * (1.0 - last / first) - opening)

    mu = float(brentq(missing, 0.01, ratios[1] - 1e-6))
    size, first, _ = height(mu)
    constants = {"mu": mu, "theta": float(np.degrees(np.arctan(first))), "height": float(size)}
    return {key: float(f"{value:.4g}") for key, value in constants.items()} | {"kn": STIFF, "ks": STIFF}


def stages(constants: Mapping[str, float], name: str) -> dict[str, Floats]:
    """tau, dn and ds of the model at the stages: sn is prescribed, the machine is a spring along the axis."""
    readings = measured(name)
    by_slip, by_opening = machine(name)
    interface = joint(constants)
    opening = np.zeros(readings["sn"].size - 1)
    for _ in range(REPEATS):
        path = [
            Step(t_N=-readings["sn"][0], increments=LOADING),
            Step(t_N=-readings["sn"][0], t_Tx=readings["tau"][0], increments=LOADING),
            Step(
                t_N=-readings["sn"][1:],
                t_Tx=readings["tau"][0] + by_opening * opening,
                k_Tx=by_slip,
                increments=INCREMENTS,
            ),
        ]
        history, lost = interface.rows(path)
        if lost:
            return {key: np.full(readings["sn"].size, LOST) for key in QUANTITIES}
        at = 2 * LOADING - 1 + INCREMENTS * np.arange(readings["sn"].size)
        separation = history.separation[at] - history.separation[at[0]]
        opening = separation[1:, 0]
    return {"tau": history.traction[at, 1], "dn": separation[:, 0], "ds": separation[:, 1]}


def differences(constants: Mapping[str, float], name: str) -> Floats:
    """Model less measurement over the range of the quantity, (3, 11)."""
    model, readings = stages(constants, name), measured(name)
    return np.array([(model[key] - readings[key]) / np.ptp(readings[key]) for key in QUANTITIES])


def fits() -> dict[str, Constants]:
    """Constants of both specimens from each choice of stages."""
    results = {}
    for name in SPECIMENS:
        size = float(measured(name)["tau"].max()), float(measured(name)["ds"].max())
        for text, count in STAGES.items():

            def residuals_of(constants: Constants, name: str = name, count: int | None = count) -> Floats:
                return differences(constants, name)[:, :count].ravel()

            results[f"{name}: {text}"] = (
                fitted(residuals_of, STARTS[name], size) if count else closed_form(name)
            )
    return results


def tables(results: Mapping[str, Constants]) -> dict[str, str]:
    """Table of the errors on stages 8 to 11 and on all stages."""
    body = []
    for fit, constants in results.items():
        name, text = fit.split(": ")
        away = differences(constants, name)
        mark = "" if text == "all" else "**"
        last, rms = (100.0 * np.sqrt(np.mean(part**2, axis=1)) for part in (away[:, 7:], away))
        body.append([name, text, *(f"{mark}{x:.1f}{mark}" for x in last), *(f"{x:.1f}" for x in rms)])
    body.append(["another code", "fitted", "", "", "", *(f"{MARKS[key]:g}" for key in QUANTITIES)])
    head = [f"{key}, {part}" for part in ("8 to 11", "all") for key in QUANTITIES]
    return {"errors": markdown(["specimen", "stages used", *head], body)}


def draw(results: Mapping[str, Constants]) -> Figure:
    """Draw tau, opening and slip over the stages."""
    figure, axes = new_figure(TWO, 4.4, nrows=2, ncols=3, sharex=True, sharey="col")
    number = np.arange(1, 12)
    models = [*zip(STAGES, (BLUE, ORANGE, GREEN), ("-", "--", ":"), strict=True)]
    for line, name in zip(axes.reshape(2, 3), SPECIMENS, strict=True):
        for ax, key in zip(line, QUANTITIES, strict=True):
            for text, colour, style in models:
                values = stages(results[f"{name}: {text}"], name)[key]
                ax.plot(number, values, style, color=colour, label=f"stages used: {text}")
            ax.plot(number, measured(name)[key], "o", color=BLACK, markersize=3.5, label="measured")
            ax.axvspan(7.5, 11.5, color=BLACK, alpha=0.06)
            last, first = name == SPECIMENS[-1], ax is line[0]
            panel(ax, "stage" if last else "", QUANTITIES[key], name if first else "")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


STUDY = Study("granite", fits, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
