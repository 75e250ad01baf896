"""Pictures of docs/concepts.md, docs/solver.md and docs/extensions.md.

Sketches are drawn from the planes of a pattern, curves are computed by the library.  Units: mm, MPa, degrees;
the material is that of Table 2 of the paper (sigma0 = 3 MPa, Gc = 0.3 N/mm, eta = 0.9, mu = 0.5).
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
from asperity.contract import Floats
from asperity.interface import History, Interface
from asperity.material import Material, ModelWarning
from asperity.pattern import Pattern
from asperity.tools import joint as bonded
from asperity.tools.style import DILATION, SLIP, TRACTION, TWO, new_figure, printed, save
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from tqdm import tqdm

from . import extensions
from .concepts_draw import BLACK, BLUE, GREEN, NOTE, ORANGE, arrow, facet, joint, panel, patterns
from .program import program

MATERIAL = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0)
"""Table 2, with a contact 20 times as stiff as the bond."""

S_F = MATERIAL.s_f

PAPER = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5}
"""Background of a text on curves."""

PRESSURE = -1.0
"""Normal traction of the slip tests."""


# --- curves -------------------------------------------------------------------------------------------------


def ramp(*corners: float, steps: int = 200) -> Floats:
    """Values along straight lines between corners, the first corner included."""
    parts = [np.linspace(a, b, steps, endpoint=False) for a, b in pairwise(corners)]
    return np.append(np.concatenate(parts), corners[-1])


def parts(history: History, stiffness: float = MATERIAL.K) -> tuple[Floats, Floats]:
    """Shear traction along Tx of bond and contact of a flat interface, (22); stiffness: in shear."""
    alpha, slipped, slip = history.alpha(1), history.slip(1)[:, 0], history.separation[:, 1]
    return (1.0 - alpha) * stiffness * slip, alpha * stiffness * (slip - slipped)


def point_out(ax: Axes, text: str, at: tuple[float, float], place: tuple[float, float], **style: str) -> None:
    """Write a text at a place, with a line to a point of a curve."""
    ax.annotate(text, at, place, arrowprops={"arrowstyle": "-"}, **style)


def plane() -> Figure:
    """Draw bond and contact of one plane: opening and closing, damage, cyclic shear under pressure."""
    figure, (normal, damage, shear) = new_figure(TWO, 2.7, ncols=3)
    opening = ramp(0.0, 0.07, 0.0, 1.15 * S_F, steps=400)
    flat = Interface(replace(MATERIAL, kc=1.0), Pattern.regular(0, 0.0))
    pulled = flat.replay(np.column_stack([opening, 0.0 * opening, 0.0 * opening]))
    normal.plot(opening, pulled.traction[:, 0], color=BLUE)
    normal.fill_between(opening[800:], pulled.traction[800:, 0], color=BLUE, alpha=0.12)
    closing = ramp(0.0, -0.02)
    for kc, style in ((1.0, "-"), (5.0, "--")):
        stiff = Interface(replace(MATERIAL, kc=kc), Pattern.regular(0, 0.0))
        pressed = stiff.replay(np.column_stack([closing, 0.0 * closing, 0.0 * closing])).traction[:, 0]
        inside = pressed > -3.2
        normal.plot(closing[inside], pressed[inside], style, color=ORANGE, label=f"contact, kc = {kc:g}")
    point_out(normal, r"$\sigma_0$ at $s_0$", (MATERIAL.s_0, 3.0), (0.06, 3.0), va="center")
    point_out(normal, "$s_f$", (S_F, 0.0), (S_F, 0.9), ha="center")
    point_out(normal, "unloading\nto the origin", (0.045, 1.39), (0.12, 1.9), **NOTE)
    normal.text(0.085, 0.35, "area $G_c$", color=BLUE)
    normal.text(-0.005, 1.3, "slope $K$", color=BLUE, ha="right")
    normal.legend(loc="lower right")

    size = ramp(0.0, 1.15 * S_F)
    places = (0.146, 0.5), (0.05, 0.6), (0.022, 0.91)
    for eta, style, place in zip((0.5, 0.9, 0.99), ("-", "--", "-."), places, strict=True):
        joint = Interface(replace(MATERIAL, eta=eta), Pattern.regular(0, 0.0))
        history = joint.replay(np.column_stack([size, 0.0 * size, 0.0 * size]))
        damage.plot(size, history.damage, style, color=BLACK)
        damage.text(*place, rf"$\eta$ = {eta:g}", va="top", fontsize="small")
    damage.axvline(S_F, linestyle=":", color=BLACK)
    damage.text(S_F, 0.1, " $s_f$")

    flat = Interface(MATERIAL, Pattern.regular(0, 0.0))
    slips = ramp(0.0, 0.26, 0.12, steps=400)
    history = flat.confined_slip(0.0, slips, PRESSURE)
    bond, contact = parts(history)
    forth = slips.argmax() + 1
    shear.stackplot(slips[:forth], contact[:forth], bond[:forth], colors=(ORANGE, BLUE), alpha=0.25)
    shear.plot(slips, history.traction[:, 1], color=BLACK)
    residual = -MATERIAL.mu * PRESSURE
    shear.text(0.1, 0.18, "contact", color=ORANGE)
    shear.text(0.045, 1.0, "bond", color=BLUE)
    point_out(shear, r"$\mu\,|\sigma_N|$", (0.23, residual), (0.2, 1.3))
    point_out(shear, "reversal:\nstick, then slip", (slips[forth + 20], 0.0), (0.13, -1.2), **NOTE)
    reach = (-0.055, 0.235)
    title = "(a) opening and closing"
    panel(normal, "normal separation $s_n$ [mm]", "normal traction [MPa]", title, xlim=reach)
    title = r"(b) damage from $s_0 = (1 - \eta)\,s_f$ to $s_f$"
    panel(damage, "separation [mm]", r"damage $\alpha$ [-]", title)
    title = rf"(c) flat joint, $\sigma_N$ = {PRESSURE:g} MPa"
    panel(shear, "slip $s_{Tx}$ [mm]", "shear traction $t_{Tx}$ [MPa]", title, ylim=(-1.5, 3.6))
    for ax in (normal, damage, shear):
        ax.axhline(0.0, color=BLACK, linewidth=0.6)
    return figure


def slip_test_with_names() -> Figure:
    """Draw a slip test of a rough joint with a reversal, and label its stages."""
    figure, (tau, dilation, energy) = new_figure(TWO, 2.7, ncols=3)
    rough = Interface(MATERIAL, Pattern.regular(2, 30.0))
    slips = ramp(0.0, 0.4, 0.22, steps=800)
    history = rough.confined_slip(0.0, slips, PRESSURE)
    mu, slope = MATERIAL.mu, np.tan(np.radians(30.0))
    up, down = -PRESSURE * (mu + slope) / (1.0 - mu * slope), -PRESSURE * (slope - mu) / (1.0 + mu * slope)
    turn, peak = slips.argmax(), history.traction[:, 1].argmax()
    for ax, values in ((tau, history.traction[:, 1]), (dilation, history.separation[:, 0])):
        ax.plot(slips[: turn + 1], values[: turn + 1], color=BLUE)
        ax.plot(slips[turn:], values[turn:], "--", color=BLUE)
    point_out(tau, "damage\nbegins", (0.0188, 4.0), (0.035, 2.4), **NOTE)
    point_out(tau, "peak", (slips[peak], history.traction[peak, 1]), (0.11, 4.9), **NOTE)
    point_out(tau, "fully damaged", (0.174, up), (0.2, 3.0), **NOTE)
    for level, place, colour, text in (
        (up, up - 0.33, ORANGE, r"up: $|\sigma_N|\,(\mu + \tan\theta)/(1 - \mu\tan\theta)$"),
        (down, down + 0.1, GREEN, r"down: $|\sigma_N|\,(\tan\theta - \mu)/(1 + \mu\tan\theta)$"),
    ):
        tau.axhline(level, linestyle=":", color=colour)
        tau.text(0.37, place, text, color=colour, ha="right", fontsize=6.0, bbox=PAPER)
    tau.text(0.375, 0.75, "reversal", ha="right", fontsize="small")
    tau.set_ylim(-0.2, 5.3)
    dilation.plot([0.22, 0.34], [0.05, 0.05 + 0.12 * slope], color=ORANGE)
    dilation.text(0.29, 0.06, r"slope $\tan\theta$", color=ORANGE, fontsize="small")
    names, there = ("stored", "rupture", "friction"), slice(0, turn + 1)
    parts_of_work = [getattr(history, name)[there] for name in names]
    energy.stackplot(slips[there], *parts_of_work, colors=(GREEN, BLUE, ORANGE), alpha=0.35, labels=names)
    energy.legend(loc="upper left")
    for ax, label, title in (
        (tau, TRACTION, "(a) shear traction"),
        (dilation, DILATION, "(b) dilation"),
        (energy, "energy [N/mm]", "(c) energies, their sum: work"),
    ):
        panel(ax, SLIP, label, title)
    return figure


CONSTANTS: tuple[tuple[str, str, tuple[float, ...]], ...] = (
    ("sigma0", r"strength $\sigma_0$ [MPa]", (2.0, 3.0, 4.0)),
    ("Gc", r"rupture energy $G_c$ [N/mm]", (0.15, 0.3, 0.6)),
    ("eta", r"ductility $\eta$ [-]", (0.6, 0.9, 0.99)),
    ("tau_v", r"relaxation time $\tau_v$ [time to slip $s_f$]", (0.0, 0.1, 0.3)),
    ("mu", r"friction $\mu$ [-]", (0.25, 0.5, 0.75)),
    ("theta", r"inclination $\theta$ [degrees]", (0.0, 15.0, 30.0)),
    ("kc", "contact stiffness kc [-]", (1.0, 5.0, 100.0)),
    ("sigma_N", r"normal traction $\sigma_N$ [MPa]", (0.0, -1.0, -2.0)),
    ("sides", "inclined planes m [-]", (4, 6, 32)),
    ("flat", "weight of the flat plane [-]", (0.0, 1.0 / 3.0, 0.8)),
    ("turn", "rotation of RP-4 [degrees]", (0.0, 22.5, 45.0)),
    ("sigma02", r"tangential strength $\sigma_{02}$ [MPa]", (2.0, 3.0, 4.0)),
    ("Gc2", r"tangential rupture energy $G_{c2}$ [N/mm]", (0.15, 0.3, 0.6)),
    ("height", "asperity height H [mm], 0: no end", (0.0, 0.5, 0.2)),
    ("W0", r"wear $W_0$ [N/mm], 0: none", (0.0, 10.0, 3.0)),
)
"""Name, title and values of the constant that a panel varies; the others are those of MATERIAL and RP-4."""


def slip_test(name: str, value: float) -> History:
    """Slip test of RP-4 under PRESSURE with one constant changed; the slip is the time."""
    pattern = {"sides": 4, "theta": 30.0, "flat": 1.0 / 3.0, "turn": 0.0}
    if name in pattern:
        pattern[name] = value
    scale = S_F if name == "tau_v" else 1.0
    material = replace(MATERIAL, **{name: scale * value}) if hasattr(MATERIAL, name) else MATERIAL
    rough = Interface(material, Pattern.regular(int(pattern.pop("sides")), **pattern))
    slips = np.linspace(0.0, 0.5, 501)
    pressure = value if name == "sigma_N" else PRESSURE
    return rough.confined_slip(0.0, slips, pressure, times=slips, preload_time=1.0)


DILATING = ("theta", "turn", "kc", "sigma_N", "height", "W0")
"""Constants that change the dilation."""


def constants(dilation: bool = False) -> Figure:
    """Draw the effect of each constant on shear traction or dilation of a slip test."""
    shown = [entry for entry in CONSTANTS if not dilation or entry[0] in DILATING]
    rows = len(shown) // 3
    figure, axes = new_figure(TWO, 3.8 if dilation else 8.2, nrows=rows, ncols=3, sharex=True)
    for k, (ax, (name, title, values)) in enumerate(zip(axes, shown, strict=True)):
        for value, colour, style in zip(values, (GREEN, BLACK, ORANGE), ("--", "-", "-."), strict=True):
            history = slip_test(name, value)
            column = history.separation[:, 0] if dilation else history.traction[:, 1]
            ax.plot(history.separation[:, 1], column, style, color=colour, label=f"{value:.3g}")
        ax.legend()
        y = DILATION if dilation else TRACTION
        panel(ax, SLIP if k >= len(shown) - 3 else "", "" if k % 3 else y, title)
    return figure


def snap() -> Figure:
    """Draw the fold of a fine pattern without pressure: path, and traction over the opening."""
    figure, (path, traction) = new_figure(TWO, 2.7, ncols=2)
    rough = Interface(replace(MATERIAL, kc=1.0), Pattern.regular(16, 30.0))
    slips = np.linspace(0.0, 0.2, 2001)
    history = rough.confined_slip(0.0, slips, 0.0)
    [jump] = history.snaps
    row = jump.row
    path.plot(slips[:row], history.separation[:row, 0], color=BLUE)
    path.plot(slips[row:], history.separation[row:, 0], color=BLUE)
    arrow(path, (jump.before[1], jump.before[0]), (0.0, jump.after[0] - jump.before[0]), ORANGE)
    path.text(
        jump.before[1] - 0.0004, 0.5 * (jump.before[0] + jump.after[0]), "snap", color=ORANGE, ha="right"
    )
    title = "(a) equilibrium path of RP-16, $\\sigma_N$ = 0"
    panel(path, SLIP, DILATION, title, xlim=(0.165, 0.18), ylim=(0.078, 0.106))

    before = history.state[row - 1]
    openings = np.linspace(0.085, 0.104, 400)
    for slip, style, colour in zip(
        (0.1725, jump.before[1], 0.1745), ("--", "-", "-."), (GREEN, BLACK, ORANGE), strict=True
    ):
        s = np.column_stack([openings, np.full_like(openings, slip), np.zeros_like(openings)])
        tractions = rough.update(s, np.repeat(before[None], len(s), axis=0)).traction[:, 0]
        traction.plot(openings, 1000.0 * tractions, style, color=colour, label=f"$s_L$ = {slip:.4f} mm")
    traction.axhline(0.0, color=BLACK, linewidth=0.6)
    traction.set_xticks(np.arange(0.085, 0.106, 0.005))
    traction.legend()
    title = "(b) normal traction over the opening at three slips"
    panel(traction, "opening $s_N$ [mm]", "normal traction $t_N$ [kPa]", title, ylim=(-1.5, 0.8))
    return figure


MORTAR = Material.from_masonry(kn=82.0, ks=36.0, ft=0.25, GfI=0.018, c=0.35, GfII=0.125, tan_phi=0.75)
"""A mortar joint of docs/reference/typical-values.md."""

MET = -0.3
"""Normal traction at which another sigma02 meets c + mu p."""


def envelope() -> Figure:
    """Draw the peak of a flat joint over the pressure beside c + mu p, and the parts of the traction."""
    figure, (peaks, shares) = new_figure(TWO, 2.7, ncols=2)
    flat, c, mu = Pattern.regular(0, 0.0), MORTAR.sigma02, MORTAR.mu
    pressures = np.linspace(0.0, 2.2, 23)
    better = bonded.strength_for_peak(MORTAR, flat, MET, c - mu * MET)
    for sigma02, colour, style in ((c, BLUE, "-"), (better, GREEN, "-.")):
        joint = replace(MORTAR, sigma02=sigma02)
        strengths = [bonded.peak(joint, flat, -p) for p in pressures]
        peaks.plot(
            pressures, strengths, style, color=colour, label=rf"peak, $\sigma_{{02}}$ = {sigma02:.3g} MPa"
        )
    peaks.plot(pressures, c + mu * pressures, "--", color=BLACK, label=r"$c + \mu p$")
    peaks.plot(pressures, mu * pressures, ":", color=BLACK, label=r"$\mu p$, residual strength")
    peaks.legend()
    panel(peaks, "pressure p [MPa]", "shear strength [MPa]", "(a) peak over pressure")

    joint = Interface(MORTAR, flat)
    slips = np.linspace(0.0, 0.6, 1201)
    history = joint.confined_slip(0.0, slips, MET)
    bond, contact = parts(history, c**2 / (2.0 * MORTAR.Gc2 * (1.0 - MORTAR.eta)))
    shares.stackplot(slips, contact, bond, colors=(ORANGE, BLUE), alpha=0.25)
    shares.plot(slips, history.traction[:, 1], color=BLACK)
    shares.axhline(c - mu * MET, linestyle="--", color=BLACK)
    shares.text(0.6, c - mu * MET - 0.01, r"$c + \mu p$", ha="right", va="top")
    shares.text(0.3, 0.08, "contact", color=ORANGE)
    shares.text(0.06, 0.22, "bond", color=BLUE)
    panel(shares, SLIP, TRACTION, rf"(b) slip test, $\sigma_N$ = {MET:g} MPa", ylim=(0.0, 0.65))
    return figure


PICTURES: Mapping[str, Callable[[], Figure]] = {
    "concepts_joint": joint,
    "concepts_patterns": patterns,
    "concepts_plane": plane,
    "concepts_test": slip_test_with_names,
    "concepts_envelope": envelope,
    "concepts_constants": constants,
    "concepts_dilation": partial(constants, dilation=True),
    "solver_snap": snap,
    "extensions_facet": facet,
    **extensions.PICTURES,
}
"""Pictures by the name of their file."""


def _action(options: argparse.Namespace) -> int:
    """Draw all pictures and print their names."""
    options.folder.mkdir(parents=True, exist_ok=True)
    for name, draw in tqdm(PICTURES.items(), unit="picture", disable=None, delay=2.0, leave=False):
        path = options.folder / f"{name}.png"
        with warnings.catch_warnings(), printed():
            warnings.simplefilter("ignore", ModelWarning)  # both boundaries are shown
            save(draw(), path)
        tqdm.write(str(path))
    return 0


main = program(_action, ("--folder DIR", "folder of the pictures", Path("concepts")))

if __name__ == "__main__":
    sys.exit(main())
