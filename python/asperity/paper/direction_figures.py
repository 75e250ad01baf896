"""Figures 7 to 13 of the paper: five planes, slip in several directions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..curve_pictures import DILATION, ENERGY, SLIP, TRACTION, curves, polar
from ..steps import turns_of
from ..style import COLOURS, ONE, TWO, label_ends, new_figure
from .fracture_energy import MATERIAL, fracture_energy
from .outcome import (
    FIVE,
    Case,
    Outcome,
    curves_csv,
    energy_range,
    family,
    listed,
    loop_work,
    numbers,
    signed,
    small,
)  # fmt: skip


def _two_panels(case_0: Case, case_45: Case, column: str, label: str, came_out: Sequence[str]) -> Outcome:
    """Draw a column of the curves of two cases over the slip: slip along 0 degrees left, 45 degrees right."""
    figure, axes = new_figure(TWO, 2.9, ncols=2, sharey=True)
    for ax, case, part in zip(axes, (case_0, case_45), ("(a) 0°", "(b) 45°"), strict=True):
        lines = [(signed(c.test.value), c.s_L, getattr(c, column), c.lost) for c in case.curves]
        curves(ax, lines, SLIP, label, r"$\sigma_N$ [MPa]" if ax is axes[-1] else "")
        ax.set_title(rf"{part[:3]} $\theta_L$ = {part[4:]}")
    return Outcome(figure, tuple(came_out), *_two_directions(case_0, case_45))


def _two_directions(case_0: Case, case_45: Case) -> tuple[str, tuple[str, ...]]:
    """Header and lines of the curves of two cases, with slip along 0 and 45 degrees."""
    parts = [((d, c.test.value), c) for d, case in ((0, case_0), (45, case_45)) for c in case.curves]
    return curves_csv(parts, f"theta_L,{case_0.name}")


def figure_7(case_0: Case, case_45: Case) -> Outcome:
    """Tractions in two directions."""
    came_out = [
        f"Along {direction}° $\\tau_L$ at 0.6 mm is "
        + listed([f"{c.tau_L[-1]:.3f}" for c in case.curves if not c.lost])
        + " MPa. Under $\\sigma_N$ = 2 MPa there is no equilibrium beyond "
        + f"$s_L$ = {case.at(2.0).s_L[-1]:.4f} mm."
        for direction, case in ((0, case_0), (45, case_45))
    ]
    zero = max(abs(case.at(0.0).tau_L[-1]) for case in (case_0, case_45))
    came_out.append(f"At $\\sigma_N$ = 0 the traction left at 0.6 mm is {small(zero)} MPa (Remark 4).")
    return _two_panels(case_0, case_45, "tau_L", TRACTION, came_out)


def figure_8(case_0: Case, case_45: Case) -> Outcome:
    """Dilation in two directions."""
    slope = np.tan(np.radians(30.0))
    came_out = []
    for direction, case, limit in ((0, case_0, slope), (45, case_45, slope * np.cos(np.pi / 4.0))):
        ends = [np.diff(c.s_N)[-1] / np.diff(c.s_L)[-1] for c in case.curves if not c.lost]
        came_out.append(
            f"Along {direction}° the slope of the dilation at 0.6 mm is {listed([f'{e:.4f}' for e in ends])} "
            f"for $\\sigma_N$ = 0 to −20 MPa. For slip up the facing planes it would be {limit:.4f}."
        )
    return _two_panels(case_0, case_45, "s_N", DILATION, came_out)


def figure_9(case_0: Case, case_45: Case) -> Outcome:
    """Cycles in two directions."""
    came_out = []
    for direction, case in ((0, case_0), (45, case_45)):
        for c in case.curves[1:]:
            ends = listed([f"{c.tau_L[i]:.3f}" for i in turns_of(c.s_L)[1:]])
            came_out.append(
                f"Along {direction}° under $\\sigma_N$ = {signed(c.test.value)} MPa, $\\tau_L$ at the ends "
                f"of the strokes is {ends} MPa, and the work of the last loop is {loop_work(c):.3f} N/mm."
            )
    return _two_panels(case_0, case_45, "tau_L", TRACTION, came_out)


def figure_10(mono_0: Case, mono_45: Case, cyclic_0: Case, cyclic_45: Case) -> Outcome:
    """Two directions in one diagram, monotonic and cyclic."""
    figure, axes = new_figure(TWO, 2.9, ncols=2)
    came_out = []
    for ax, pair, part in (
        (axes[0], (mono_0, mono_45), "(a) monotonic, η = 0.99"),
        (axes[1], (cyclic_0, cyclic_45), "(b) cyclic, η = 0.9"),
    ):
        values = [c.test.value for c in pair[0].curves if not c.lost]
        for i, value in enumerate(values):
            for case, style in zip(pair, ("-", "--"), strict=True):
                c = case.at(value)
                label = rf"{signed(value)}" if style == "-" else None
                ax.plot(c.s_L, c.tau_L, style, color=COLOURS[i], label=label)
        ax.set_xlabel(SLIP)
        ax.set_ylabel(TRACTION)
        ax.grid(alpha=0.3)
        ax.set_title(part + r"; — 0°, - - 45°")
        label_ends(ax, r"$\sigma_N$ [MPa]")
        ratios = [f"{signed(v)}: {pair[0].at(v).tau_L.max() / pair[1].at(v).tau_L.max():.3f}" for v in values]
        came_out.append(
            f"{part}: the largest $\\tau_L$ along 0°, divided by that along 45°, is for each $\\sigma_N$ in "
            f"MPa: {listed(ratios)}."
        )
    names = f"cyclic,theta_L,{mono_0.name}"
    parts = [
        ((cyclic, d, c.test.value), c)
        for cyclic, d, case in ((0, 0, mono_0), (0, 45, mono_45), (1, 0, cyclic_0), (1, 45, cyclic_45))
        for c in case.curves
    ]
    return Outcome(figure, tuple(came_out), *curves_csv(parts, names))


def figure_11(case: Case) -> Outcome:
    """Several directions."""
    figure, table = family(case, r"$\theta_L$ [°]")
    ends = {c.test.value: float(c.tau_L[-1]) for c in case.curves}
    mirrored = max(float(np.abs(case.at(a).tau_L - case.at(90.0 - a).tau_L).max()) for a in (0.0, 15.0, 30.0))
    return Outcome(
        figure,
        (
            f"$\\tau_L$ at 0.6 mm in MPa is {listed([f'{t:.3f} ({a:g}°)' for a, t in ends.items()])}. The "
            f"largest value divided by the smallest is {max(ends.values()) / min(ends.values()):.3f}.",
            "Directions that the symmetry maps to each other (0° and 90°, 15° and 75°, 30° and 60°) give "
            f"the same; the difference is {small(mirrored)} MPa.",
        ),
        *table,
    )


def figure_12(case: Case) -> Outcome:
    """Energy over the direction."""
    energies = np.array([c.energy for c in case.curves])
    angles = np.array([c.test.value for c in case.curves])
    converged = fracture_energy(MATERIAL, FIVE)
    figure, (ax,) = new_figure(ONE, 3.2, subplot_kw={"projection": "polar"})
    polar(ax, converged.directions, converged.values, (0.32, 0.35), f"{ENERGY}, radius from 0.32")
    return Outcome(
        figure,
        (
            f"With steps of 0.0025 mm, the area over all points, and 24 directions the energy is "
            f"{energies.max():.6f} to {energies.min():.6f} N/mm, a spread of "
            f"{100.0 * (energies.max() / energies.min() - 1.0):.2f} %.",
            f"Converged and in 64 directions it is {energy_range(converged)}.",
        ),
        "theta_L,G_T",
        tuple(numbers(*pair) for pair in zip(angles, energies, strict=True)),
    )


def figure_13(case_0: Case, case_45: Case) -> Outcome:
    """No normal traction, several inclinations."""
    figure, axes = new_figure(TWO, 2.9, ncols=2, sharey=True)
    came_out = []
    for ax, case, direction in zip(axes, (case_0, case_45), (0.0, 45.0), strict=True):
        lines = [(f"{c.test.value:g}, {c.energy:.4f}", c.s_L, c.tau_L, c.lost) for c in case.curves]
        curves(ax, lines, SLIP, TRACTION, r"$\theta_m$ [°], $G_T$ [N/mm]", inside=True)
        ax.set_xlim(-0.005, 0.25)
        ax.set_title(rf"$\theta_L$ = {direction:g}°")
        converged = [
            fracture_energy(c.test.material, c.test.pattern, np.array([direction])) for c in case.curves
        ]
        came_out.append(
            f"Along {direction:g}° $G_T$ is {listed([f'{c.energy:.6f}' for c in case.curves])} N/mm for "
            f"$\\theta_m$ = {listed([f'{c.test.value:g}°' for c in case.curves])} with steps of 0.0025 mm "
            f"and all points; converged it is {listed([f'{e.largest:.6f}' for e in converged])} N/mm."
        )
    if case_0.curves[0].test.material.mu == 0.0:
        worst = max(abs(c.energy - c.test.material.Gc) for case in (case_0, case_45) for c in case.curves)
        came_out.append(f"With these steps the largest difference from $G_c$ is {worst:.1e} N/mm.")
    return Outcome(figure, tuple(came_out), *_two_directions(case_0, case_45))
