"""Pictures and numbers of docs/extensions.md that the library computes: dilation, cycles, locking, snaps.

Units: mm, MPa, degrees; Table 2 of the paper with a stiff contact unless stated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure

from ..contract import Floats
from ..interface import History, Interface
from ..material import Material
from ..pattern import Pattern
from .concepts_draw import BLACK, BLUE, NOTE, ORANGE
from .gallery_draw import DILATION, SLIP, TRACTION, curves, new_figure

TABLE_2 = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)

FIVE = Pattern.regular(4, 30.0, flat=0.2)
"""The five planes of Table 3."""

SLOPE = float(np.tan(np.radians(30.0)))
"""Slope of its inclined planes."""

VARIANTS = (
    ("no end", {}),
    ("H = 0.3 mm", {"height": 0.3}),
)
"""Asperities without end, and with a height."""

STRESSES = (0.0, -2.0, -5.0, -10.0, -20.0)
"""Normal tractions of Figure 8 without tension."""

CYCLE = (0.4, -0.4, 0.4)
"""Turns of Figure 9."""


def path(*turns: float, step: float = 0.001) -> Floats:
    """Slips from 0 to each of the turns in increments of about a step."""
    parts = [np.zeros(1)]
    for a, b in pairwise((0.0, *turns)):
        parts.append(np.linspace(a, b, round(abs(b - a) / step) + 1)[1:])
    return np.concatenate(parts)


# --- Figures 8 and 9 of the paper ---------------------------------------------------------------------------


def paper_figures() -> Figure:
    """Draw Figures 8(a) and 9(a) of the paper without end and with a height."""
    figure, axes = new_figure(8.8, 6.6, nrows=2, ncols=2, sharex="row", sharey="row")
    for ax, (name, extra) in zip(axes[:2], VARIANTS, strict=True):
        rough = Interface(replace(TABLE_2, eta=0.99, kc=20.0, **extra), FIVE)
        lines = []
        for sigma_N in STRESSES:
            history = rough.confined_slip(0.0, path(0.6), sigma_N)
            lines.append((f"{sigma_N:g}", history.separation[:, 1], history.separation[:, 0], False))
        curves(ax, lines, SLIP, DILATION, r"$\sigma_N$ [MPa]", inside=True)
        ax.set_title(f"Figure 8(a): {name}", **NOTE)
    for ax, (name, extra) in zip(axes[2:], VARIANTS, strict=True):
        rough = Interface(replace(TABLE_2, kc=20.0, **extra), FIVE)
        lines = []
        for sigma_N in STRESSES[:1] + STRESSES[2:4]:
            history = rough.confined_slip(0.0, path(*CYCLE), sigma_N)
            lines.append((f"{sigma_N:g}", history.separation[:, 1], history.traction[:, 1], False))
        curves(ax, lines, SLIP, TRACTION, r"$\sigma_N$ [MPa]", inside=True)
        ax.set_title(f"Figure 9(a): {name}", **NOTE)
    return figure


PRESSURE = -1.0
"""Normal traction of the tests below, MPa."""


# --- locking and snaps --------------------------------------------------------------------------------------

LOCKING = Material(sigma0=0.06, Gc=1.2e-4, eta=0.9, mu=0.8, kc=100.0)
"""A bond of a fiftieth of the strength of Table 2 with the same stiffness, which is soon broken.

On RT of 60 degrees mu tan(theta) = 1.39: it locks.
"""

STEEP_RT = Pattern.regular(2, 60.0)


def locked(height: float) -> History:
    """Slip test under PRESSURE of the steep RT, which slides as soon as its slope has fallen to 1/mu."""
    joint = Interface(replace(LOCKING, height=height), STEEP_RT)
    return joint.confined_slip(0.0, path(1.0), PRESSURE)


def unlocking_slip(height: float) -> float:
    """Slip (H/T) log(mu T) at which mu tan(phi) = 1 on the steep RT."""
    slope = np.tan(np.radians(60.0))
    return float(height / slope * np.log(LOCKING.mu * slope))


def snap(height: float) -> History:
    """Slip of RP-16 without pressure, in increments that are small enough to stop at its fold."""
    fine = Interface(replace(TABLE_2, height=height), Pattern.regular(16, 30.0))
    return fine.confined_slip(0.0, path(0.2, step=1e-4), 0.0)


def ends() -> Figure:
    """Draw how a height ends locking, and what it does to the snap of a fine pattern."""
    figure, (tau, fold) = new_figure(10.0, 3.9, ncols=2)
    for height, colour, style in ((0.0, BLACK, "-"), (0.5, BLUE, "-."), (0.2, ORANGE, "--")):
        history = locked(height)
        slips = history.separation[:, 1]
        label = f"H = {height:g} mm" if height else "no end"
        tau.semilogy(slips, history.traction[:, 1], style, color=colour, label=label)
        if height:
            slope = np.tan(np.radians(60.0))
            phi = slope * np.exp(-slips * slope / height)
            free = LOCKING.mu * phi < 0.95
            rigid = -PRESSURE * (LOCKING.mu + phi[free]) / (1.0 - LOCKING.mu * phi[free])
            tau.semilogy(slips[free], rigid, ":", color=colour)
            tau.axvline(unlocking_slip(height), color=colour, linewidth=0.6)
    tau.axhline(-LOCKING.mu * PRESSURE, color=BLACK, linewidth=0.6, linestyle=":")
    tau.set_xlabel(SLIP)
    tau.set_ylabel(TRACTION)
    tau.legend(fontsize="x-small")
    tau.set_title(r"(a) RT of 60°, $\mu$ = 0.8: locks up to the thin lines", **NOTE)
    for height, colour, style in ((0.0, BLACK, "-"), (0.5, BLUE, "-."), (0.2, ORANGE, "--")):
        history = snap(height)
        label = f"H = {height:g} mm" if height else "no end"
        fold.plot(history.separation[:, 1], history.separation[:, 0], style, color=colour, label=label)
    fold.set_xlim(0.14, 0.2)
    fold.set_ylim(0.05, 0.12)
    fold.set_xlabel(SLIP)
    fold.set_ylabel(DILATION)
    fold.legend(fontsize="x-small")
    fold.set_title(r"(b) RP-16 without pressure: the jump", **NOTE)
    for ax in (tau, fold):
        ax.grid(alpha=0.3)
    return figure


PICTURES: dict[str, Callable[[], Figure]] = {
    "extensions_paper": paper_figures,
    "extensions_ends": ends,
}
