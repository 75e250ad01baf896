"""Direct shear of three sandstone joints at 1 to 5 MPa: fitted at 1 MPa, predicted at the other pressures."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from itertools import product

import numpy as np
from asperity.contract import Floats
from asperity.interface import slip_path
from asperity.style import TWO, new_figure
from asperity.tables import markdown
from matplotlib.figure import Figure

from ..concepts_draw import BLACK, BLUE, GREEN, NOTE, ORANGE
from .common import LOST, Constants, Study, fitted, joint, rows

JOINTS = ("JA", "JB", "JC")
SLIPS = np.concatenate([np.linspace(0.0, 4.0, 161)[1:], np.linspace(4.0, 10.0, 61)[1:]])
"""Slips of the model, mm."""

NUMBERS = ("peak", "peak_slip", "end")
"""Measured numbers of a test: peak, MPa, its slip, mm, and the shear stress at a slip of 10 mm, MPa."""

SLOPES = (16.7, 26.6)
FORMS: dict[str, tuple[list[Constants], Constants]] = {
    "height": (
        [{"theta": t, "height": h, "ks": k} for t, h, k in product(SLOPES, (2.0, 6.0), (0.8, 1.5))],
        {"mu": 0.6, "kn": 100.0},
    ),
    "closure": (
        [{"theta": t, "height": h, "closure": v} for t, h, v in product(SLOPES, (2.0, 6.0), (0.5, 1.5))],
        {"mu": 0.6, "kn": 0.5, "ks": 20.0},
    ),
    "wear": (
        [{"theta": t, "W0": w, "ks": k} for t, w, k in product(SLOPES, (8.0, 25.0), (0.8, 1.5))],
        {"mu": 0.6, "kn": 100.0},
    ),
}
"""Starts of the three free constants, and the fixed ones, of each form of the law."""

STEP = 2e-2
"""Relative step of the differences: the slip at the peak is one of SLIPS."""


@cache
def measured(name: str) -> Floats:
    """Pressure and the numbers of the tests of a joint, (5, 4)."""
    found = [row for row in rows("sandstone") if row["joint"] == name]
    return np.array([[float(row[key]) for key in ("sigma", *NUMBERS)] for row in found])


def numbers(constants: Mapping[str, float], pressure: float) -> Floats:
    """NUMBERS of the model under a pressure, (3,)."""
    history, lost = joint(constants).rows(slip_path(0.0, SLIPS, -pressure, 20))
    if lost:
        return np.full(3, LOST)
    tau = history.after_step(1).traction[:, 1]
    at = int(tau.argmax())
    return np.array([tau[at], SLIPS[at], tau[-1]])


def errors(constants: Mapping[str, float], name: str) -> Floats:
    """Relative errors of the numbers of a joint, (5, 3)."""
    return np.array([numbers(constants, row[0]) / row[1:] - 1.0 for row in measured(name)])


def fits() -> dict[str, Constants]:
    """Fit every form of the law to the test of each joint at 1 MPa."""
    found = {}
    for form, (starts, fixed) in FORMS.items():
        for name in JOINTS:
            first = measured(name)[0]
            found[f"{form} {name}"] = fitted(
                lambda one, first=first: numbers(one, first[0]) / first[1:] - 1.0,  # type: ignore[misc]
                starts,
                (float(first[1]), float(SLIPS[-1])),
                fixed,
                STEP,
            )
    return found


def tables(found: Mapping[str, Constants]) -> dict[str, str]:
    """Table of all errors in percent; the first of each cell is that of the fit."""
    body = []
    for fit, constants in found.items():
        form, name = fit.split()
        columns = np.round(100.0 * errors(constants, name)).T
        cells = [
            f"{column[0]:.0f}; " + ", ".join(f"**{x:.0f}**" for x in column[1:]) for column in columns + 0.0
        ]
        body.append([form, name, *cells])
    return {
        "errors": markdown(["form", "joint", "peak, %", "slip at the peak, %", "stress at 10 mm, %"], body)
    }


def draw(found: Mapping[str, Constants]) -> Figure:
    """Draw peak, slip at the peak and stress at 10 mm over the pressure."""
    figure, axes = new_figure(TWO, 5.4, nrows=3, ncols=3, sharex=True, sharey="row")
    pressures = np.linspace(0.5, 5.0, 19)
    for column, name in zip(axes.reshape(3, 3).T, JOINTS, strict=True):
        for form, colour, style in zip(FORMS, (BLUE, GREEN, ORANGE), ("-", "--", "-."), strict=True):
            model = np.array([numbers(found[f"{form} {name}"], p) for p in pressures])
            for ax, values in zip(column, model.T, strict=True):
                ax.plot(pressures, values, style, color=colour, label=form)
        for ax, values in zip(column, measured(name)[:, 1:].T, strict=True):
            ax.plot(measured(name)[1:, 0], values[1:], "o", color=BLACK, markersize=3.5, label="measured")
            ax.plot(
                1.0, values[0], "s", color=BLACK, markersize=5, fillstyle="none", label="measured, fitted"
            )
            ax.grid(alpha=0.3)
        column[0].set_title(name, **NOTE)
        column[2].set_xlabel("pressure [MPa]")
    axes[0].legend(loc="upper left")
    labels = ("peak [MPa]", "slip at the peak [mm]", "stress at 10 mm [MPa]")
    for ax, label in zip(axes[::3], labels, strict=True):
        ax.set_ylabel(label)
    return figure


STUDY = Study("sandstone", fits, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
