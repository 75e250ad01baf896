"""Pictures and numbers of docs/extensions.md that the library computes: dilation, cycles, locking, snaps.

Units: mm, MPa, degrees; Table 2 of the paper with a stiff contact unless stated.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
from asperity.contract import Floats
from asperity.interface import History, Interface
from asperity.material import Material, ModelWarning
from asperity.pattern import Pattern
from asperity.steps import Step, turns_of
from asperity.tools.barton.joint import Joint
from asperity.tools.style import DILATION, ONE, SLIP, TRACTION, TWO, curves, new_figure
from matplotlib import colormaps
from matplotlib.figure import Figure
from scipy.optimize import least_squares

from harness.studies.paper.fracture_energy import MATERIAL as TABLE_2
from harness.studies.paper.outcome import FIVE

from .concepts_draw import BLACK, BLUE, GREEN, NOTE, ORANGE, panel
from .validation import sandstone

RT = Pattern.regular(2, 30.0)
SLOPE = float(np.tan(np.radians(30.0)))
"""RT of Table 1, and the slope of its inclined planes."""

VARIANTS = (
    ("no end", {}),
    ("H = 0.3 mm", {"height": 0.3}),
    (r"H = 0.3 mm, $W_0$ = 30 N/mm", {"height": 0.3, "W0": 30.0}),
)
"""Asperities without end, with a height, and with a height and wear."""


def path(*turns: float, step: float = 0.001) -> Floats:
    """Slips from 0 to each of the turns in increments of about a step."""
    parts = [np.linspace(a, b, round(abs(b - a) / step) + 1)[1:] for a, b in pairwise((0.0, *turns))]
    return np.concatenate([[0.0], *parts])


FIGURES = (
    (8, 0.99, path(0.6), (0.0, -2.0, -5.0, -10.0, -20.0), DILATION),
    (9, 0.9, path(0.4, -0.4, 0.4), (0.0, -5.0, -10.0), TRACTION),
)
"""Number of the figure, eta, slips, normal tractions without tension, and what is drawn."""


# --- Figures 8 and 9 of the paper ---------------------------------------------------------------------------


def paper_figures() -> Figure:
    """Draw Figures 8(a) and 9(a) of the paper without end, with a height, and with wear."""
    figure, axes = new_figure(TWO, 4.6, nrows=2, ncols=3, sharex="row", sharey="row")
    for row, (paper, eta, slips, stresses, label) in enumerate(FIGURES):
        for ax, (name, extra) in zip(axes[3 * row :], VARIANTS, strict=False):
            rough = Interface(replace(TABLE_2, eta=eta, kc=20.0, **extra), FIVE)
            lines = []
            for sigma_N in stresses:
                history = rough.confined_slip(0.0, slips, sigma_N)
                column = history.traction[:, 1] if row else history.separation[:, 0]
                lines.append((f"{sigma_N:g}", history.separation[:, 1], column, False))
            curves(ax, lines, SLIP, label, r"$\sigma_N$ [MPa]", inside=True)
            ax.set_title(f"Figure {paper}(a): {name}", **NOTE)
    return figure


# --- cycles -------------------------------------------------------------------------------------------------

WORN = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=100.0, height=0.5, W0=1.0)
"""Material of the cycles, on RT."""

AMPLITUDE, PRESSURE = 0.4, -1.0
"""Slip at the reversals, mm, and normal traction, MPa, of the cycles."""

ROUGH_LEFT = 0.05
"""Share of the slope at which asperities count as worn out."""


def plesha(
    slips: Floats, mu: float, slope: float, c: float, pressure: float
) -> tuple[Floats, Floats, Floats]:
    """Rigid joint of Plesha (1987) along a path: traction, opening and asperity angle (radians), (T,) each.

    The angle decays as exp(-c W) with the work W of the tangential traction, which is pressure tan(phi + a)
    up the asperities and pressure tan(phi - a) down them; both sides of the asperities have the same angle.
    """
    friction = np.arctan(mu)
    angle0 = np.arctan(slope)
    tau, opening, angle = np.zeros(slips.size), np.zeros(slips.size), np.full(slips.size, angle0)
    work = 0.0
    for i in range(1, slips.size):
        step = slips[i] - slips[i - 1]
        middle = 0.5 * (slips[i] + slips[i - 1])
        up = np.sign(step) == np.sign(middle)
        a = angle[i - 1] if up else -angle[i - 1]
        tau[i] = np.sign(step) * pressure * np.tan(friction + a)
        work += tau[i] * step
        opening[i] = opening[i - 1] + abs(step) * np.tan(a)
        angle[i] = angle0 * np.exp(-c * work)
    return tau, opening, angle


def wear() -> Figure:
    """Draw cycles of a worn joint, and its wear beside that of Plesha's law."""
    figure, (tau, dilation, height) = new_figure(TWO, 2.7, ncols=3)
    slips = path(*[AMPLITUDE, -AMPLITUDE] * 5)
    history = Interface(WORN, RT).confined_slip(0.0, slips, PRESSURE)
    ends = turns_of(slips)
    for i in range(0, len(ends) - 1, 2):
        part = slice(ends[i], ends[min(i + 2, len(ends) - 1)] + 1)
        shade = colormaps["viridis"](0.2 * i / 2)
        tau.plot(slips[part], history.traction[part, 1], color=shade, label=f"{i // 2 + 1}")
        dilation.plot(slips[part], history.separation[part, 0], color=shade)
    tau.legend(title="cycle", loc="upper left")
    for level in (-1.0, 1.0):
        tau.axhline(level * WORN.mu * PRESSURE, linestyle=":", color=BLACK, linewidth=0.8)
    panel(tau, SLIP, TRACTION, r"(a) RT, −1 MPa, $H$ = 0.5 mm, $W_0$ = 1 N/mm")
    panel(dilation, SLIP, DILATION, "(b) the worn joint closes again")
    for pressure, colour in zip(PRESSURES, (GREEN, BLUE, ORANGE), strict=True):
        path_, share, share_plesha = shares(pressure)
        way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(path_)))]) / (4.0 * AMPLITUDE)
        height.semilogy(way, share, color=colour, label=f"{pressure:g} MPa")
        height.semilogy(way, share_plesha, "--", color=colour)
    height.axhline(ROUGH_LEFT, color=BLACK, linewidth=0.8, linestyle=":")
    height.legend(title=r"$\sigma_N$; dashed: Plesha")
    title = rf"(c) both facets, no height, $W_0$ = {SLOW:g} N/mm"
    panel(height, "cycles", "share of the slope that is left", title, ylim=(0.01, 1.1))
    return figure


PRESSURES = (-0.5, -1.0, -2.0)
SLOW = 4.0
"""Normal tractions, MPa, and W0, N/mm, of the comparison with Plesha's law."""


def shares(sigma_N: float) -> tuple[Floats, Floats, Floats]:
    """Slips of 20 cycles under sigma_N, and the share of the slope that is left: mean of the facets, Plesha.

    Plesha's work is that of the joint, ours that of a facet per unit of its area, on which the whole normal
    traction acts in every other half of a cycle: c = 1/(2 gamma W0) with the weight gamma of the facet.
    """
    material = replace(WORN, height=0.0, W0=SLOW)
    slips = path(*([AMPLITUDE, -AMPLITUDE] * 20))
    history = Interface(material, RT).confined_slip(0.0, slips, sigma_N)
    share = 1.0 - 0.5 * (history.worn(2) + history.worn(3))
    c = 0.5 / (RT.weights[1] * material.W0)
    _, _, angle = plesha(slips, material.mu, SLOPE, c, -sigma_N)
    return slips, share, angle / np.arctan(SLOPE)


# --- locking and snaps --------------------------------------------------------------------------------------

LOCKING = Material(sigma0=0.06, Gc=1.2e-4, eta=0.9, mu=0.8, kc=100.0)
"""A bond of a fiftieth of the strength of Table 2 with the same stiffness, which is soon broken.

On RT of 60 degrees mu tan(theta) = 1.39: it locks.
"""

STEEP_RT = Pattern.regular(2, 60.0)


def locked(height: float) -> History:
    """Slip test under PRESSURE of the steep RT, which slides as soon as its slope has fallen to 1/mu."""
    joint = Interface(replace(LOCKING, height=height), STEEP_RT)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)  # without a height it locks, as it is to show
        return joint.confined_slip(0.0, path(1.0), PRESSURE)


def snap(height: float) -> History:
    """Slip of RP-16 without pressure, in increments that are small enough to stop at its fold."""
    fine = Interface(replace(TABLE_2, height=height), Pattern.regular(16, 30.0))
    return fine.confined_slip(0.0, path(0.2, step=1e-4), 0.0)


def ends() -> Figure:
    """Draw how a height ends locking, and what it does to the snap of a fine pattern."""
    figure, (tau, fold) = new_figure(TWO, 2.7, ncols=2)
    slope = np.tan(np.radians(60.0))
    for height, colour, style in ((0.0, BLACK, "-"), (0.5, BLUE, "-."), (0.2, ORANGE, "--")):
        label = f"H = {height:g} mm" if height else "no end"
        history = locked(height)
        slips = history.separation[:, 1]
        tau.semilogy(slips, history.traction[:, 1], style, color=colour, label=label)
        if height:
            phi = slope * np.exp(-slips * slope / height)
            free = LOCKING.mu * phi < 0.95
            rigid = -PRESSURE * (LOCKING.mu + phi[free]) / (1.0 - LOCKING.mu * phi[free])
            tau.semilogy(slips[free], rigid, ":", color=colour)
            # where mu tan(phi) = 1
            tau.axvline(height / slope * np.log(LOCKING.mu * slope), color=colour, linewidth=0.6)
        history = snap(height)
        fold.plot(history.separation[:, 1], history.separation[:, 0], style, color=colour, label=label)
    tau.axhline(-LOCKING.mu * PRESSURE, color=BLACK, linewidth=0.6, linestyle=":")
    panel(tau, SLIP, TRACTION, r"(a) RT of 60°, $\mu$ = 0.8: locks up to the thin lines")
    title = r"(b) RP-16 without pressure: the jump"
    panel(fold, SLIP, DILATION, title, xlim=(0.14, 0.2), ylim=(0.05, 0.12))
    tau.legend()
    fold.legend()
    return figure


# --- crushed asperities -------------------------------------------------------------------------------------

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
    peaks = np.array([joint.peak_strength(stress) for stress in stresses])
    mu = np.tan(np.radians(joint.phi_r))

    def law(x: Floats) -> Floats:
        slope, crush = np.exp(x[0]), np.exp(x[1]) if crushed else np.inf
        return np.array([sandstone.strength(stress, slope, mu, crush) for stress in stresses])

    start = np.log([0.5, low])[: 1 + crushed]
    return stresses, peaks, law(least_squares(lambda x: np.log(law(x) / peaks), start).x)


def crushed() -> Figure:
    """Draw Barton's formula, sandstone and the law with and without crush."""
    figure, (barton, rock) = new_figure(TWO, 2.9, ncols=2)
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
            rock.plot(pressures, [law(pressure) / pressure for pressure in pressures], style, color=colour)
        rock.plot(tests[:, 0], tests[:, 1] / tests[:, 0], mark, color=colour, markersize=4, label=name)
    rock.legend()
    panel(rock, "pressure [MPa]", ratio, "(b) sandstone, fitted to 1 and 5 MPa")
    return figure


INCREMENTS = (50, 200, 800, 3200)
"""Of each of the legs of a random walk."""


def walk(seed: int, increments: int) -> History:
    """Random joint with crush along six legs between random separations."""
    rng = np.random.default_rng(seed)
    material = Material(
        3.0, 0.3, 0.9, rng.uniform(0.2, 1.0), kc=10 ** rng.uniform(0.0, 2.0), damage0=rng.choice([0.0, 1.0]),
        crush=10 ** rng.uniform(-0.5, 1.5), height=rng.choice([0.0, 0.5]), closure=rng.choice([0.0, 0.05]),
    )  # fmt: skip
    theta, flat, turn = rng.uniform(15.0, 45.0), rng.choice([0.0, 1.0 / 3.0]), rng.uniform(0.0, 90.0)
    pattern = Pattern.regular(int(rng.choice([2, 4, 6])), theta, flat, turn)
    legs = zip(rng.uniform(-0.02, 0.1, 6), *rng.uniform(-0.3, 0.3, (2, 6)), strict=True)
    steps = [Step(s_N=n, s_Tx=x, s_Ty=y, increments=increments) for n, x, y in legs]
    return Interface(material, pattern).run(steps)


def imbalance(rows: History) -> float:
    """Largest difference of work and energies, stored and dissipated, over the largest work."""
    rest = rows.work - (rows.stored + rows.rupture + rows.friction)
    return float(np.abs(rest).max() / np.abs(rows.work).max())


def crushed_energy() -> Figure:
    """Draw how the energies of crushed joints close with the increments of random walks."""
    figure, (axes,) = new_figure(ONE, 2.6)
    for seed in range(24):
        imbalances = [imbalance(walk(seed, n)) for n in INCREMENTS]
        axes.loglog(INCREMENTS, imbalances, "-", color=BLUE, linewidth=0.6)
    ends = np.array([INCREMENTS[0], INCREMENTS[-1]])
    axes.loglog(ends, 0.05 * (ends[0] / ends) ** 2, "--", color=BLACK, label="second order")
    axes.legend()
    title = "24 random joints and walks"
    panel(axes, "increments of each of 6 legs", "work less energies, over the work", title)
    return figure


PICTURES: dict[str, Callable[[], Figure]] = {
    "extensions_paper": paper_figures,
    "extensions_wear": wear,
    "extensions_ends": ends,
    "extensions_crush": crushed,
    "extensions_crush_energy": crushed_energy,
}
