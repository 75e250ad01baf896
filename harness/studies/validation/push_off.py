"""Push-off of cracked concrete under a known restraint (Walraven, Reinhardt 1981): fits, predictions."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from asperity.contract import Floats
from asperity.steps import slip_path
from asperity.tools import fit as product
from asperity.tools.fit import ShearTest
from asperity.tools.style import TWO, new_figure
from asperity.tools.tables import markdown
from matplotlib.figure import Figure

from ..concepts_draw import BLACK, BLUE, GREEN, ORANGE, panel
from .common import LOST, Constants, Study, by_product, fitted, joint, of_product, rms, rows

STRONG, WEAK = "1/.0/6.8", "1/.0/3.6"
"""Specimens: mix, width of the crack before the test, pressure of the bars at an opening of 0.6 mm."""

SLIPS = np.concatenate(
    [np.linspace(a, b, n)[1:] for a, b, n in ((0.0, 0.02, 21), (0.02, 0.3, 57), (0.3, 2.24, 98))]
)
"""Slips of the model, mm: at first short beside the elastic slip, 0.005 mm."""

PRELOAD = 20
"""Increments of the pressure before the slip."""

RANGE = (0.8, 10.0)
"""Opening, mm, and shear stress, MPa, by which the residuals of the fits are divided."""

RIGID = {"kn": 2e4, "ks": 1e3}
"""Stiffness of the contact, MPa/mm: so large that it has no effect."""

START = {"mu": 0.87, "theta": 35.4, "height": 1.0}
VARIANTS: dict[str, tuple[list[Constants], Constants]] = {
    "friction": ([START], RIGID),
    "wear": ([START | {"W0": 100.0}], RIGID),
    "crush": (
        [START | {"theta": theta, "crush": crush} for theta, crush in ((40.0, 30.0), (50.0, 5.0))],
        RIGID,
    ),
    "bond": (
        [
            START | {"sigma0": sigma0, "Gc": Gc, "flat": flat}
            for sigma0, Gc in ((2.0, 0.2), (4.0, 2.0), (10.0, 0.7))
            for flat in (0.02, 0.3, 0.6)
        ],
        {},
    ),
}
"""Starts of the free constants, and the fixed ones, of each form of the law."""

STRENGTH = {"sigma0": (0.3, 12.0)}
"""Ends of the strength, MPa: a crack is not stronger than the concrete."""

PRODUCT, KINDS = "asperity fit", ("rock", "mortar")
NAMES = ("sigma0", "Gc", "mu", "theta", "height", "crush")
"""Fits of the product, by the form of the joint, and the constants that their table has."""

FITS = {"6.8": (STRONG,), "3.6": (WEAK,), "both": (STRONG, WEAK)}
"""Specimens that are fitted, by the ending of the name of a fit."""


@dataclass(frozen=True, eq=False)
class Specimen:
    """Measured opening (n, 2) and shear stress (m, 2) over the slip; cube strength; p0, k_N of the bars."""

    opening: Floats
    shear: Floats
    cube: float
    p0: float
    k_N: float


@cache
def specimen(name: str) -> Specimen:
    """Read a specimen."""
    parts = rows("push-off").query("specimen == @name").groupby("quantity")[["slip", "value"]]
    by_quantity = {quantity: part.to_numpy() for quantity, part in parts}
    single = {key: float(by_quantity[key][0, 1]) for key in ("cube", "p0", "k_N")}
    return Specimen(by_quantity["opening"], by_quantity["shear"], **single)


def curves(constants: Mapping[str, float], name: str) -> tuple[Floats, Floats]:
    """Opening and shear stress of the model over SLIPS; the bars are a normal spring."""
    tested = specimen(name)
    first = float(tested.opening[0, 1])
    pressed = slip_path(0.0, SLIPS, -(tested.p0 + tested.k_N * first), PRELOAD, tested.k_N)
    history, lost = joint(constants).rows(pressed)
    if lost:
        return np.full(SLIPS.size, LOST), np.full(SLIPS.size, LOST)
    start = history.separation[PRELOAD - 1, 0]
    history = history.after_step(1)
    return first + history.separation[:, 0] - start, history.traction[:, 1]


def differences(constants: Mapping[str, float], name: str) -> tuple[Floats, Floats]:
    """Model less measurement of the opening, mm, and of the shear stress, MPa."""
    tested = specimen(name)
    opening, shear = curves(constants, name)
    # the first opening is the start of the model
    measured = tested.opening[1:], tested.shear
    away = [np.interp(m[:, 0], SLIPS, y) - m[:, 1] for m, y in zip(measured, (opening, shear), strict=True)]
    return away[0], away[1]


def formula(name: str) -> Floats:
    """Shear stress by the formula of Walraven and Reinhardt at the measured slips and openings."""
    tested = specimen(name)
    slip = tested.shear[:, 0]
    w = np.interp(slip, *tested.opening.T)
    return -tested.cube / 30.0 + (1.8 * w**-0.80 + (0.234 * w**-0.707 - 0.20) * tested.cube) * slip


def residuals(constants: Mapping[str, float], names: tuple[str, ...]) -> Floats:
    """Residuals of a fit: each curve has the same weight."""
    parts = []
    for name in names:
        for part, scale in zip(differences(constants, name), RANGE, strict=True):
            parts.append(part / scale / np.sqrt(part.size))
    return np.concatenate(parts)


def tests() -> list[ShearTest]:
    """Both specimens as tests of a fit, with the opening at the slips of the shear stress."""
    shear_tests = []
    for name in (STRONG, WEAK):
        tested = specimen(name)
        (slip, shear), first = tested.shear.T, float(tested.opening[0, 1])
        opening = np.interp(slip, *tested.opening.T) - first
        shear_tests.append(
            ShearTest(name, slip, shear, opening, -(tested.p0 + tested.k_N * first), tested.k_N)
        )
    return shear_tests


def fits() -> dict[str, Constants]:
    """Fit every form of the law to each specimen and to both; then `asperity fit` with the usual options."""
    results: dict[str, Constants] = {}
    for kind in KINDS:
        results[f"{PRODUCT} {kind}"] = by_product(product.fit(tests(), joint=kind))
    size = RANGE[1], float(SLIPS[-1])
    for form, (starts, fixed) in VARIANTS.items():
        ends = STRENGTH if "sigma0" in starts[0] else None
        for ending, names in FITS.items():
            residual = partial(residuals, names=names)
            results[f"{form} {ending}"] = fitted(residual, starts, size, fixed, ends=ends)
    return results


def tables(results: Mapping[str, Constants]) -> dict[str, str]:
    """Table of the errors of every fit."""
    body = []
    for fit, constants in results.items():
        if fit.startswith(PRODUCT):
            continue
        form, ending = fit.split()
        cells = [form, " and ".join(FITS[ending])]
        for name in (STRONG, WEAK):
            opening, shear = differences(constants, name)
            mark = "" if name in FITS[ending] else "**"
            cells += [f"{mark}{rms(opening):.3f}{mark}", f"{mark}{rms(shear):.2f}{mark}"]
        body.append(cells)
    shear = [f"{rms(formula(name) - specimen(name).shear[:, 1]):.2f}" for name in (STRONG, WEAK)]
    body.append(["formula of 1981", "other tests", "given", shear[0], "given", shear[1]])
    head = ["form", "fitted to"]
    head += [f"{name}: {quantity}" for name in (STRONG, WEAK) for quantity in ("opening, mm", "shear, MPa")]
    errors = ["scatter", "peak", "residual", "dilation", "blind peak", "blind residual", "blind dilation"]
    lines = [
        [f"`{PRODUCT} --joint {kind}`", *of_product(results[f"{PRODUCT} {kind}"], NAMES, errors)]
        for kind in KINDS
    ]
    titles = ["command", "constants", *(f"{kind}, %" for kind in errors), "exit code"]
    return {"errors": markdown(head, body), "fit": markdown(titles, lines)}


def draw(results: Mapping[str, Constants]) -> Figure:
    """Draw opening and shear stress of both specimens: measured, fitted, predicted, and the formula."""
    figure, axes = new_figure(TWO, 4.6, nrows=2, ncols=2, sharex=True, sharey="row")
    lines = (
        ("friction 3.6", BLUE, "friction, fitted to 3.6"),
        ("crush 3.6", ORANGE, "crush, fitted to 3.6"),
        ("crush both", GREEN, "crush, fitted to both"),
    )
    for (above, below), name in zip(axes.reshape(2, 2).T, (STRONG, WEAK), strict=True):
        tested = specimen(name)
        for fit, colour, label in lines:
            style = "-" if name in FITS[fit.split()[1]] else "--"
            opening, shear = curves(results[fit], name)
            label += "" if style == "-" else " (predicted)"
            above.plot(SLIPS, opening, style, color=colour, label=label)
            below.plot(SLIPS, shear, style, color=colour)
        label = "formula of 1981, measured opening"
        below.plot(tested.shear[:, 0], formula(name), ":", color=BLACK, label=label)
        above.plot(*tested.opening.T, "o", color=BLACK, markersize=3.5, label="measured")
        below.plot(*tested.shear.T, "o", color=BLACK, markersize=3.5)
        first = name == STRONG
        panel(above, y="opening [mm]" if first else "", title=name)
        panel(below, "slip [mm]", "shear stress [MPa]" if first else "")
        above.legend(loc="lower right")
        below.legend(loc="lower right")
    return figure


STUDY = Study("push-off", fits, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
