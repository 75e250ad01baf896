"""Picture of docs/extensions.md, section 7: strength over pressure, and increments."""

from __future__ import annotations

import numpy as np
from asperity import Interface, Material, Pattern, Step
from asperity.barton.envelope import strength
from asperity.barton.joint import Joint
from asperity.contract import Floats
from asperity.style import TWO, new_figure
from matplotlib.figure import Figure
from scipy.optimize import least_squares

from .concepts_draw import BLACK, BLUE, GREEN, ORANGE, panel
from .validation import sandstone

JOINTS = (
    (Joint(jrc=6.0, jcs=60.0, phi_r=28.0, length=0.1), 0.2, 10.0),
    (Joint(jrc=10.0, jcs=100.0, phi_r=30.0, length=0.1), 0.5, 5.0),
    (Joint(jrc=12.0, jcs=150.0, phi_r=31.0, length=0.1), 1.0, 20.0),
    (Joint(jrc=16.0, jcs=100.0, phi_r=30.0, length=0.1), 0.5, 5.0),
)
"""Joints of Barton, and their lowest and highest normal stress, MPa."""


def envelope(joint: Joint, low: float, high: float, crushed: bool) -> tuple[Floats, Floats, Floats]:
    """Stresses, strengths of Barton and closest strengths of one plane with mu = tan(phi_r), (25,) each."""
    stresses = np.geomspace(low, high, 25)
    peaks = np.array([joint.peak_strength(one) for one in stresses])
    mu = np.tan(np.radians(joint.phi_r))

    def law(x: Floats) -> Floats:
        slope, crush = np.exp(x[0]), np.exp(x[1]) if crushed else np.inf
        return np.array([strength(one, slope, mu, crush) for one in stresses])

    start = np.log([0.5, low])[: 1 + crushed]
    return stresses, peaks, law(least_squares(lambda x: np.log(law(x) / peaks), start).x)


MU, THETA, CRUSH = 0.6, 30.0, 2.0


PHASES = np.linspace(0.75, 1.25, 7)
"""Multiples of an increment: where the sliding begins within one makes a difference."""


def too_low(pressure: float, ratio: float) -> float:
    """Largest share by which a strength is too low in increments of about ratio elastic slips."""
    material = Material(3.0, 0.3, 0.99, MU, kc=100.0, damage0=1.0, crush=CRUSH)
    joint = Interface(material, Pattern.regular(2, THETA, flat=0.0))
    exact = strength(pressure, np.tan(np.radians(THETA)), MU, CRUSH, 0.5)
    found = []
    for one in ratio * PHASES:
        count = int(60.0 / one) + 1
        slide = Step(slip=count * one * MU * pressure / material.K, increments=count)
        history = joint.run([Step(t_N=-pressure, increments=20), slide])
        found.append(1.0 - history.traction[-1, 1] / exact)
    return max(found)


def crushed() -> Figure:
    """Draw Barton's formula, sandstone and the law with and without crush, and the effect of increments."""
    figure, (barton, rock, increments) = new_figure(TWO, 2.9, ncols=3)
    joint, low, high = JOINTS[1]
    for crush, style in ((False, "--"), (True, "-")):
        stresses, peaks, law = envelope(joint, low, high, crush)
        label = "with crush" if crush else "without crush"
        barton.semilogx(stresses, law / stresses, style, color=BLUE, label=label)
    barton.semilogx(stresses[::3], (peaks / stresses)[::3], "o", color=BLACK, markersize=3.5, label="Barton")
    barton.set_xticks([0.5, 1.0, 2.0, 5.0], ["0.5", "1", "2", "5"], minor=False)
    barton.set_xticks([], minor=True)
    barton.legend(loc="upper right")
    ratio = "peak strength over pressure"
    panel(barton, "pressure [MPa]", ratio, "(a) Barton: JRC 10, JCS 100 MPa, 30°")
    pressures = np.linspace(1.0, 5.0, 33)
    for name, mark, colour in zip(sandstone.JOINTS, "os^", (BLUE, ORANGE, GREEN), strict=True):
        tests = sandstone.measured(name)
        for crush, style in ((False, "--"), (True, "-")):
            law = sandstone.envelope(tests[[0, 4]], crush)
            rock.plot(pressures, [law(one) / one for one in pressures], style, color=colour)
        rock.plot(tests[:, 0], tests[:, 1] / tests[:, 0], mark, color=colour, markersize=4, label=name)
    rock.legend()
    panel(rock, "pressure [MPa]", ratio, "(b) sandstone, fitted to 1 and 5 MPa")
    ratios = 2.0 ** np.arange(-4, 4)
    for pressure, colour in ((0.05, GREEN), (0.5, BLUE), (5.0, ORANGE)):
        off = [100.0 * too_low(pressure * CRUSH, one) for one in ratios]
        increments.loglog(ratios, off, "o-", color=colour, markersize=3.5, label=f"{pressure:g} crush")
    increments.axvline(0.1, color=BLACK, linewidth=0.8, linestyle=":")
    increments.legend(loc="lower right", title=r"$|\sigma_N|$")
    off = "strength too low by [%]"
    panel(increments, "increment over elastic slip", off, "(c) long increments crush more", ylim=(1e-4, None))
    return figure
