"""Direct shear of three sandstone joints at 1 to 5 MPa: one or two pressures fitted, others predicted."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from functools import cache
from itertools import product

import numpy as np
from asperity.contract import Floats
from asperity.steps import slip_path
from asperity.tools.fit.strength import Strength
from asperity.tools.fit.strengths import fit_strengths
from asperity.tools.style import TWO, new_figure
from asperity.tools.tables import markdown
from matplotlib.figure import Figure
from scipy.optimize import brentq, least_squares

from ..concepts_draw import BLACK, BLUE, GREEN, ORANGE, panel
from .common import LOST, Constants, Study, by_product, fitted, joint, of_product, rows

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
    "crush": (
        [
            {"theta": t, "height": 6.0, "ks": k, "crush": c}
            for t, k, c in product((30.0, 45.0), (0.8, 1.5), (2.0, 10.0))
        ],
        {"mu": 0.6, "kn": 100.0},
    ),
}
"""Starts of the free constants, and the fixed ones, of each form of the law."""

FITS = {"1": (0,), "1+5": (0, 4)}
"""Rows of the tests that are fitted, by the pressures in the name of a fit."""

DONOR = "JA"
"""Joint whose crush is given to the others, which are then fitted at 1 MPa alone."""

PRODUCT, NAMES, BELOW = "asperity fit", ("mu", "theta", "crush", "height", "sigma0"), 3
"""Fits of the product, the constants that their table has, and number of the smallest pressures from which
the other ones are predicted.
"""

STEP = 2e-2
"""Relative step of the differences: the slip at the peak is one of SLIPS."""


@cache
def measured(name: str) -> Floats:
    """Pressure and the numbers of the tests of a joint, (5, 4)."""
    return rows("sandstone").query("joint == @name")[["sigma", *NUMBERS]].to_numpy(float)


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
    return _differences(constants, measured(name))


def _differences(constants: Mapping[str, float], tests: Floats) -> Floats:
    """Relative errors of the numbers of tests, (n, 3)."""
    return np.array([numbers(constants, row[0]) / row[1:] - 1.0 for row in tests])


def fits() -> dict[str, Constants]:
    """Fit the forms of the law to the tests of each joint at 1 MPa, and at 1 and 5 MPa."""
    results: dict[str, Constants] = {}
    for (pressures, tests), (form, (starts, fixed)), name in product(
        reversed(FITS.items()), FORMS.items(), JOINTS
    ):
        of_other: Constants = {}
        if form == "crush" and pressures == "1":
            if name == DONOR:
                continue  # one pressure does not determine crush
            of_other = {"crush": results[f"crush 1+5 {DONOR}"]["crush"]}
        goal = measured(name)[list(tests)]
        results[f"{form} {pressures} {name}"] = fitted(
            lambda constants, goal=goal: _differences(constants, goal).ravel(),  # type: ignore[misc]
            [
                dict(start_values)
                for start_values in dict.fromkeys(_without(start, of_other) for start in starts)
            ],
            (float(goal[:, 1].max()), float(SLIPS[-1])),
            fixed | of_other,
            STEP,
        )
    for name in JOINTS:
        results[f"{PRODUCT} {name}"] = by_product(fit_strengths(strengths(name)))
        below = fit_strengths(strengths(name)[:BELOW])
        beyond = measured(name)[BELOW:]
        away = below.peak(beyond[:, 0]) / beyond[:, 1] - 1.0
        results[f"{PRODUCT} {name}"] |= {"error blind beyond": float(np.sqrt(np.mean(away**2)))}
    return results


def strengths(name: str) -> list[Strength]:
    """Tests of a joint as those of `asperity fit`; the stress at 10 mm is the residual strength."""
    return [
        Strength(f"{p:g} MPa", -p, peak, end, at, float(SLIPS[-1]))
        for p, peak, at, end in measured(name).tolist()
    ]


def _without(start: Constants, known: Constants) -> tuple[tuple[str, float], ...]:
    return tuple((name, value) for name, value in start.items() if name not in known)


def strength(sigma_n: float, slope: float, mu: float, crush: float) -> float:
    """Shear strength of a joint without bond that begins to climb one plane, whose pressure crushes it.

    slope: tangent of the inclination; crush: stress, inf for none.  Closed form of docs/extensions.md,
    section 7.
    """

    def forces(p: float) -> Floats:
        t = slope * kept(p / crush, slope * mu) if np.isfinite(crush) else slope
        return np.asarray(p / np.hypot(1.0, t) * np.array([1.0 - mu * t, t + mu]))

    p = brentq(lambda p: forces(p)[0] - sigma_n, 1e-6 * sigma_n, 1e6 * sigma_n, xtol=1e-12 * sigma_n)
    return float(forces(p)[1])


def kept(pressure: float, mu_slope: float) -> float:
    """Share rho of a facet that a pressure (over crush) leaves where the climb begins on a stiff contact.

    rho = log(1 + x)/x with x = pressure (1 - mu (1 - rho) tan(theta)); mu_slope is mu tan(theta).
    """

    def missing(rho: float) -> float:
        x = pressure * max(1.0 - mu_slope * (1.0 - rho), 0.0)
        return rho - (float(np.log1p(x)) / x if x > 0.0 else 1.0)

    return float(brentq(missing, 0.0, 1.0, xtol=1e-15)) if pressure > 0.0 else 1.0


def envelope(tests: Floats, crushed: bool = True) -> Callable[[float], float]:
    """Peak over the pressure of one plane in closed form that is fitted to the peaks of tests (n, 4)."""

    def law(x: Floats, pressure: float) -> float:
        return strength(pressure, np.exp(x[0]), 0.6, np.exp(x[1]) if crushed else np.inf)

    def off(x: Floats) -> list[float]:
        return [law(x, row[0]) / row[1] - 1.0 for row in tests]

    x = least_squares(off, np.zeros(1 + crushed)).x
    return lambda pressure: law(x, pressure)


def tables(results: Mapping[str, Constants]) -> dict[str, str]:
    """Table of the errors of each form and fit in percent, from the smallest to the largest."""
    body = []
    forms = [fit for fit in results if not fit.startswith(PRODUCT)]
    for form, pressures in dict.fromkeys(tuple(fit.split()[:2]) for fit in forms):
        of_other = f", crush of {DONOR}" if (form, pressures) == ("crush", "1") else ""
        cells = [form, pressures.replace("+", " and ") + of_other]
        joints = [name for name in JOINTS if f"{form} {pressures} {name}" in results]
        away = {name: 100.0 * errors(results[f"{form} {pressures} {name}"], name) for name in joints}
        used = list(FITS[pressures])
        cells.append(f"{max(np.abs(of_joint[used]).max() for of_joint in away.values()):.0f}")
        predicted = np.array([np.delete(of_joint, used, axis=0) for of_joint in away.values()])
        cells += [_ends(predicted[..., i]) for i in range(len(NUMBERS))]
        body.append(cells)
    for crushed in (False, True):
        away = []
        for name in JOINTS:
            tests = measured(name)
            law = envelope(tests[[0, 4]], crushed)
            away.append(100.0 * np.array([law(row[0]) / row[1] - 1.0 for row in tests]))
        cells = [f"closed form, {'crush' if crushed else 'without'}", "peaks at 1 and 5"]
        cells.append(f"{np.abs(np.array(away)[:, [0, 4]]).max():.0f}")
        body.append([*cells, _ends(np.array(away)[:, 1:4]), "", ""])
    head = ["form", "fitted to, MPa", "fitted: largest, %"]
    head += [f"{quantity}, %" for quantity in ("peak", "slip at the peak", "stress at 10 mm")]
    kinds = ("peak", "residual", "blind peak", "blind residual", "blind beyond")
    lines = [[name, *of_product(results[f"{PRODUCT} {name}"], NAMES, kinds)] for name in JOINTS]
    titles = ["joint", "constants", *(f"{kind}, %" for kind in kinds), "exit code"]
    return {"errors": markdown(head, body), "fit": markdown(titles, lines)}


def _ends(away: Floats) -> str:
    """Smallest and largest error."""
    least, most = (round(float(pick(away))) for pick in (np.min, np.max))
    return f"**{least} to {most}**"


def draw(results: Mapping[str, Constants]) -> Figure:
    """Draw peak, slip at the peak and stress at 10 mm over the pressure."""
    figure, axes = new_figure(TWO, 5.4, nrows=3, ncols=3, sharex=True, sharey="row")
    pressures = np.linspace(0.5, 5.0, 19)
    labels = ("peak [MPa]", "slip at the peak [mm]", "stress at 10 mm [MPa]")
    lines = (
        ("height 1", "height, fitted to 1 MPa", BLUE, "--"),
        ("crush 1+5", "crush, fitted to 1 and 5 MPa", GREEN, "-"),
        ("crush 1", f"crush of {DONOR}, fitted to 1 MPa", ORANGE, "-."),
    )
    for column, name in zip(axes.reshape(3, 3).T, JOINTS, strict=True):
        for fit, label, colour, style in lines:
            if f"{fit} {name}" not in results:
                continue
            model = np.array([numbers(results[f"{fit} {name}"], p) for p in pressures])
            for ax, values in zip(column, model.T, strict=True):
                ax.plot(pressures, values, style, color=colour, label=label)
        for ax, values in zip(column, measured(name)[:, 1:].T, strict=True):
            ax.plot(measured(name)[:, 0], values, "o", color=BLACK, markersize=3.5, label="measured")
        for ax, x, y, title in zip(column, ("", "", "pressure [MPa]"), labels, (name, "", ""), strict=True):
            panel(ax, x, y if name == JOINTS[0] else "", title)
    axes[1].legend(loc="upper left")
    return figure


STUDY = Study("sandstone", fits, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
