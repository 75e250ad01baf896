"""Figures 2, 4 and 5 of the paper: one plane, and the results of the 2D law."""

from __future__ import annotations

import numpy as np
from scipy.integrate import trapezoid

from ..curve_pictures import DILATION, SLIP, TRACTION, curves
from ..steps import turns_of
from ..style import COLOURS, ONE, TWO, new_figure
from .outcome import (
    Case,
    Outcome,
    curves_csv,
    family,
    listed,
    loop_work,
    numbers,
    signed,
    small,
)  # fmt: skip


def figure_2(case: Case) -> Outcome:
    """Opening in mode I."""
    (curve,) = case.curves
    m = curve.test.material
    s_f, s_0 = m.s_f, m.s_0
    s, t = curve.s_N, curve.of(curve.history.traction[:, 0])
    triangle = np.interp(s, [0.0, s_0, s_f, s[-1]], [0.0, m.sigma0, 0.0, 0.0])
    area = float(trapezoid(t, s))
    figure, (ax,) = new_figure(ONE, 2.3)
    curves(ax, [("", s, t, False)], "opening $s_N$ [mm]", r"traction $\sigma_N$ [MPa]")
    ax.plot([s_0, s_f], [m.sigma0, 0.0], "o", color=COLOURS[1], markersize=5)
    ax.text(s_0 + 0.006, m.sigma0, r"$(s_0, \sigma_0)$")
    ax.text(s_f, 0.12, "$s_f$", ha="center")
    ax.text(0.075, 0.6, "area $G_c$")
    return Outcome(
        figure,
        (
            f"The largest traction is {t.max():.6g} MPa and the area {area:.6g} N/mm. The largest "
            f"difference from the triangle is {small(float(np.abs(t - triangle).max()))} MPa.",
        ),
        "s_N,t_N",
        tuple(numbers(*pair) for pair in zip(s, t, strict=True)),
    )


def figure_4a(case: Case) -> Outcome:
    """Flat interface."""
    figure, table = family(case, r"$\sigma_N$ [MPa]")
    m = case.curves[0].test.material
    slopes = [c.tau_L[1] / c.s_L[1] / m.K for c in case.curves]
    whole = [c for c in case.curves if not c.lost]
    residual = [abs(c.tau_L[-1] - m.mu * abs(c.test.sigma_N)) for c in whole]
    ends = listed([f"{c.tau_L[-1]:.4g}" for c in whole])
    (lost,) = [c for c in case.curves if c.lost]
    return Outcome(
        figure,
        (
            "The slope of the first increment is $K$; the relative difference is "
            f"{small(max(abs(s - 1.0) for s in slopes))}.",
            f"The curves end at $\\tau_L$ = {ends} MPa. These are the values $\\mu |\\sigma_N|$; the "
            f"difference is {small(max(residual))} MPa.",
            f"Under $\\sigma_N$ = {signed(lost.test.sigma_N)} MPa there is no equilibrium beyond $s_L$ = "
            f"{lost.s_L[-1]:.4f} mm (cross).",
        ),
        *table,
    )


def figure_4b(case: Case) -> Outcome:
    """Inclination of the planes."""
    figure, table = family(case, r"$\theta_m$ [°]")
    m = case.curves[0].test.material
    shares = [
        f"{c.test.value:g}° {c.tau_L[-1]:.2f} of {10.0 * m.residual_strength(c.test.value):.2f}"
        for c in case.curves
    ]
    return Outcome(
        figure,
        (f"$\\tau_L$ at 0.6 mm and the residual strength that it approaches are, in MPa: {listed(shares)}.",),
        *table,
    )


def figure_5a(case: Case) -> Outcome:
    """Small pressures."""
    figure, table = family(case, r"$\sigma_N$ [MPa]")
    m = case.curves[0].test.material
    ratio = m.residual_strength(35.0)
    shares = [
        f"{signed(c.test.value)}: {c.tau_L[-1]:.3f} of {abs(c.test.value) * ratio:.3f}"
        for c in case.curves
        if c.test.value != 0.0
    ]
    peaks = listed([f"{c.tau_L.max():.3f}" for c in case.curves])
    return Outcome(
        figure,
        (
            f"The largest tractions are {peaks} MPa.",
            f"$\\tau_L$ at 0.6 mm and the residual strength are, in MPa: {listed(shares)}.",
        ),
        *table,
    )


def figure_5b(case: Case) -> Outcome:
    """Cyclic slip."""
    (curve,) = case.curves
    figure, axes = new_figure(TWO, 2.6, ncols=2)
    curves(axes[0], [("", curve.s_L, curve.tau_L, False)], SLIP, TRACTION)
    curves(axes[1], [("", curve.s_L, curve.s_N, False)], SLIP, DILATION)
    ends = turns_of(curve.s_L)[1:]
    return Outcome(
        figure,
        (
            "At the ends of the three strokes $\\tau_L$ is "
            f"{listed([f'{curve.tau_L[i]:.3f}' for i in ends])} MPa, "
            f"the dilation {listed([f'{curve.s_N[i]:.4f}' for i in ends])} mm.",
            f"The work of the last two strokes, which make a closed loop, is {loop_work(curve):.3f} N/mm.",
        ),
        *curves_csv([((curve.test.sigma_N,), curve)], "sigma_N"),
    )
