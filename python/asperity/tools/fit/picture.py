"""Pictures of a fit: curves of tests and law, and envelopes of strengths."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from ...contract import Floats
from .rigid import law_strengths
from .shear_test import ShearTest
from .strengths import StrengthFit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Curve: TypeAlias = tuple[Floats, Floats, Floats]
"""Slips, tau and s_N of a test by the law, (P,) each."""

SYMBOLS = "osD^v"
"""Marks of the tests."""


def curves_figure(
    tests: Sequence[ShearTest], curves: Sequence[Curve], units: tuple[str, str], what: str, of_tests: str = ""
) -> Figure:
    """Tests and law over the slip: tau, and s_N where it was measured.

    curves: slips, tau and s_N of the law for each test.  what: what the law's curves are.  of_tests: what the
    tests are where they are curves, which are drawn as dashed lines.
    """
    from ..style import COLOURS, LINES, ONE, TWO, label_axes, new_figure

    length, stress = units
    columns = 1 + any(test.s_N is not None for test in tests)
    figure, axes = new_figure(TWO if columns > 1 else ONE, 3.0, ncols=columns)
    for i, (test, (slips, tau, s_N)) in enumerate(zip(tests, curves, strict=True)):
        colour, mark = COLOURS[i % len(COLOURS)], SYMBOLS[i % len(SYMBOLS)]
        label = rf"$\sigma_N$ = {test.sigma_N:.4g}".replace("-", "\u2212")
        label += f", $k_N$ = {test.k_N:g}" if test.k_N else ""
        for ax, measured, law in zip(axes, (test.tau, test.s_N), (tau, s_N), strict=False):
            if measured is not None:
                style = {} if of_tests else {"markersize": 2.0, "alpha": 0.5}
                ax.plot(test.slip, measured, "--" if of_tests else mark, color=colour, **style)
            line = "-" if of_tests else LINES[i % len(LINES)]
            # without a measured dilation that of the law is not drawn
            if measured is not None or ax is axes[0]:
                ax.plot(slips, law, line, color=colour, label=label)
    labels = (rf"traction $\tau$ [{stress}]", f"dilation $s_N$ [{length}]")
    for ax, name in zip(axes, labels, strict=False):
        label_axes(ax, f"slip [{length}]", name)
    handles, texts = axes[0].get_legend_handles_labels()
    shown = f"dashed: {of_tests}, solid" if of_tests else "points: test data, lines"
    title = f"{shown}: {what}; stresses in {stress}"
    figure.legend(handles, texts, loc="outside upper center", ncols=min(4, len(texts)), title=title)
    return figure


def envelope_figure(fit: StrengthFit, units: tuple[str, str]) -> Figure:
    """Peak and residual strengths over the pressure, and the law."""
    from ..style import COLOURS, ONE, label_axes, new_figure

    figure, (ax,) = new_figure(ONE, 3.6, ncols=1)
    pressure = np.array([-test.sigma_N for test in fit.tests])
    top = float(max(pressure.max(), 0.02 * np.abs(pressure).max()))
    fine = np.linspace(min(0.02 * top, float(pressure.min())), 1.15 * top, 200)
    ax.plot(
        pressure, [test.peak for test in fit.tests], "o", color="k", markersize=4.0, label="peak, measured"
    )
    residual = np.array([test.residual for test in fit.tests])
    slips = [test.slip for test in fit.tests if np.isfinite(test.slip)]
    peak, rest = law_strengths(fine, fit.values, max(slips) if slips else np.inf)
    ax.plot(fine, peak, color=COLOURS[0], linewidth=1.6, label="law")
    if np.isfinite(residual).any():
        ax.plot(pressure, residual, "s", color="0.5", markersize=4.0, label="residual, measured")
        ax.plot(fine, rest, "--", color=COLOURS[0], label="law, residual")
    label_axes(ax, rf"pressure $-\sigma_N$ [{units[1]}]", f"shear strength [{units[1]}]")
    ax.set_ylim(0.0, 1.1 * max(float(peak.max()), max(test.peak for test in fit.tests)))
    ax.legend(fontsize=7)
    return figure
