"""The figures and tables of the paper: what each draws, finds and writes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import trapezoid

from ..curve_pictures import DILATION, ENERGY, SLIP, TRACTION, curves, merged, polar
from ..pattern import Pattern, unit_vector
from ..pattern_pictures import plan, space
from ..steps import turns_of
from ..style import COLOURS, ONE, TWO, label_ends, new_figure
from ..tables import markdown
from .fracture_energy import MATERIAL, PATTERNS, TABLE_5, fracture_energy, pattern, sampled
from .outcome import (
    FIVE,
    Case,
    Entry,
    Outcome,
    curves_csv,
    energy_range,
    loop_work,
    numbers,
    pattern_csv,
    signed,
    small,
)  # fmt: skip

SIGMA_N, THETA_M, THETA_L = r"$\sigma_N$ [MPa]", r"$\theta_m$ [°]", r"$\theta_L$ [°]"
DIRECTIONS = (0.0, 45.0)


def family(labels: str, found: Callable[[Case], Iterable[str]]) -> Callable[[Case], Outcome]:
    """Traction over slip for the values of a sweep; labels: what the labels are."""

    def make(case: Case) -> Outcome:
        figure, (ax,) = new_figure(1.3 * ONE, 3.0)
        lines = [(signed(c.test.value), c.s_L, c.tau_L, c.lost) for c in case.curves]
        curves(ax, merged(lines), SLIP, TRACTION, labels)
        return Outcome(
            figure, tuple(found(case)), *curves_csv([((c.test.value,), c) for c in case.curves], case.name)
        )

    return make


def panels(
    column: str, label: str, found: Callable[..., Iterable[str]], energies: bool = False
) -> Callable[[Case, Case], Outcome]:
    """A column of two cases over the slip: along 0 degrees in the left diagram, along 45 in the right one.

    energies: whether the labels have the energy, in a legend of the part of the diagram with small slips.
    """

    def make(*pair: Case) -> Outcome:
        figure, axes = new_figure(TWO, 2.9, ncols=2, sharey=True)
        for ax, case, direction, part in zip(axes, pair, DIRECTIONS, "ab", strict=True):
            names = [
                f"{c.test.value:g}, {c.energy:.4f}" if energies else signed(c.test.value) for c in case.curves
            ]
            lines = [(n, c.s_L, getattr(c, column), c.lost) for n, c in zip(names, case.curves, strict=True)]
            if energies:
                curves(ax, lines, SLIP, label, r"$\theta_m$ [°], $G_T$ [N/mm]", inside=True)
                ax.set_xlim(-0.005, 0.25)
            else:
                curves(ax, lines, SLIP, label, SIGMA_N if part == "b" else "")
            ax.set_title(("" if energies else f"({part}) ") + rf"$\theta_L$ = {direction:g}°")
        parts = [
            ((d, c.test.value), c) for d, case in zip(DIRECTIONS, pair, strict=True) for c in case.curves
        ]
        return Outcome(figure, tuple(found(*pair)), *curves_csv(parts, f"theta_L,{pair[0].name}"))

    return make


def in_space(
    shown: Pattern, names: tuple[str, str], table: int, steps: Sequence[tuple[int, int]], call: str
) -> Callable[[], Outcome]:
    """Pattern of 30 degrees in space, compared with a table: the flat plane and those with steps."""

    def make() -> Outcome:
        figure, (ax,) = new_figure(ONE, 2.5, subplot_kw={"projection": "3d"})
        space(ax, shown, f"{names[1]}, 30°")
        c, s = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
        wanted = np.array([(1.0, 0.0, 0.0), *((c, s * x, s * y) for x, y in steps)])
        distance = np.abs(shown.normals[:, None] - wanted[None]).max(axis=2)
        difference = max(distance.min(axis=0).max(), distance.min(axis=1).max())
        text = (
            f"The normals are those of Table {table} (difference {small(difference)}). All planes have "
            f"the weight {shown.weights[0]:.4g}. The pattern is `Pattern.regular({call})`."
        )
        return Outcome(figure, (text,), *pattern_csv([(names[0], shown)]))

    return make


def isotropy(*names: str) -> Callable[..., Outcome]:
    """A row for each pattern: curves in several directions on the left, energy on the right."""

    def make(*cases: Case) -> Outcome:
        figure = Figure(figsize=(TWO, 2.7 * len(names)), layout="constrained")
        found, parts = [], []
        for i, (name, case) in enumerate(zip(names, cases, strict=True)):
            left = figure.add_subplot(len(names), 2, 2 * i + 1)
            right = figure.add_subplot(len(names), 2, 2 * i + 2, projection="polar")
            lines = [(f"{c.test.value:g}", c.s_L, c.tau_L, c.lost) for c in case.curves]
            curves(left, merged(lines), SLIP, TRACTION, THETA_L)
            left.set_title(rf"{name}, $\sigma_N$ = −5 MPa")
            energies = fracture_energy(MATERIAL, pattern(name))
            title = rf"{name}, {ENERGY} at $\sigma_N$ = 0, radius from 0.28"
            polar(right, energies.directions, energies.values, (0.28, 0.37), title)
            ends = np.array([c.tau_L[-1] for c in case.curves])
            found.append(
                f"{name}: $\\tau_L$ at 0.6 mm {ends.min():.3f} to {ends.max():.3f} MPa, spread "
                f"{100.0 * (ends.max() / ends.min() - 1.0):.2f} %."
            )
            parts += [((PATTERNS[name], c.test.value), c) for c in case.curves]
        return Outcome(figure, tuple(found), *curves_csv(parts, "m,theta_L"))

    return make


def _figure_2(case: Case) -> Outcome:
    (curve,) = case.curves
    m = curve.test.material
    s, t = curve.s_N, curve.of(curve.history.traction[:, 0])
    triangle = np.interp(s, [0.0, m.s_0, m.s_f, s[-1]], [0.0, m.sigma0, 0.0, 0.0])
    figure, (ax,) = new_figure(ONE, 2.3)
    curves(ax, [("", s, t, False)], "opening $s_N$ [mm]", r"traction $\sigma_N$ [MPa]")
    ax.plot([m.s_0, m.s_f], [m.sigma0, 0.0], "o", color=COLOURS[1], markersize=5)
    ax.text(m.s_0 + 0.006, m.sigma0, r"$(s_0, \sigma_0)$")
    ax.text(m.s_f, 0.12, "$s_f$", ha="center")
    ax.text(0.075, 0.6, "area $G_c$")
    text = (
        f"The largest traction is {t.max():.6g} MPa, the area {trapezoid(t, s):.6g} N/mm, the largest "
        f"difference from the triangle {small(float(np.abs(t - triangle).max()))} MPa."
    )
    return Outcome(figure, (text,), "s_N,t_N", tuple(numbers(*pair) for pair in zip(s, t, strict=True)))


def _found_4a(case: Case) -> Iterable[str]:
    m = case.curves[0].test.material
    slope = max(abs(c.tau_L[1] / c.s_L[1] / m.K - 1.0) for c in case.curves)
    whole = [c for c in case.curves if not c.lost]
    residual = max(abs(c.tau_L[-1] - m.mu * abs(c.test.sigma_N)) for c in whole)
    (lost,) = (c for c in case.curves if c.lost)
    yield f"The slope of the first increment is $K$; the relative difference is {small(slope)}."
    yield (
        f"The curves end at $\\mu |\\sigma_N|$ = {', '.join(f'{c.tau_L[-1]:.4g}' for c in whole)} MPa; the "
        f"difference is {small(residual)} MPa."
    )
    yield (
        f"Under $\\sigma_N$ = {signed(lost.test.sigma_N)} MPa there is no equilibrium beyond $s_L$ = "
        f"{lost.s_L[-1]:.4f} mm (cross)."
    )


def _found_4b(case: Case) -> Iterable[str]:
    strength = case.curves[0].test.material.residual_strength
    shares = (
        f"{c.test.value:g}° {c.tau_L[-1]:.2f} of {10.0 * strength(c.test.value):.2f}" for c in case.curves
    )
    yield f"$\\tau_L$ at 0.6 mm and the residual strength, MPa: {', '.join(shares)}."


def _found_5a(case: Case) -> Iterable[str]:
    ratio = case.curves[0].test.material.residual_strength(35.0)
    values = ((c.test.value, c.tau_L[-1]) for c in case.curves if c.test.value != 0.0)
    shares = ", ".join(f"{signed(v)}: {end:.3f} of {abs(v) * ratio:.3f}" for v, end in values)
    yield f"$\\tau_L$ at 0.6 mm and the residual strength, MPa: {shares}."


def _figure_5b(case: Case) -> Outcome:
    (curve,) = case.curves
    figure, axes = new_figure(TWO, 2.6, ncols=2)
    curves(axes[0], [("", curve.s_L, curve.tau_L, False)], SLIP, TRACTION)
    curves(axes[1], [("", curve.s_L, curve.s_N, False)], SLIP, DILATION)
    ends = turns_of(curve.s_L)[1:]
    found = (
        f"At the ends of the strokes $\\tau_L$ is {', '.join(f'{curve.tau_L[i]:.3f}' for i in ends)} MPa, "
        f"the dilation {', '.join(f'{curve.s_N[i]:.4f}' for i in ends)} mm. The work of the last loop is "
        f"{loop_work(curve):.3f} N/mm.",
    )
    return Outcome(figure, found, *curves_csv([((curve.test.sigma_N,), curve)], "sigma_N"))


def _figure_6() -> Outcome:
    figure, (ax,) = new_figure(0.8 * ONE, 2.6)
    plan(ax, FIVE, "five planes, direction of slip", numbers=False)
    for vector, label in (((0.75, 0.0), "$T_x$"), ((0.0, 0.75), "$T_y$")):
        ax.annotate("", vector, (0, 0), arrowprops={"arrowstyle": "->", "color": "black"})
        ax.text(*(1.08 * np.array(vector)), label, ha="center", va="center")
    angle = np.radians(30.0)
    style = {"arrowstyle": "->", "color": COLOURS[1], "linewidth": 1.6}
    ax.annotate("", 0.72 * unit_vector(angle), (0, 0), arrowprops=style)
    ax.text(0.78 * np.cos(angle), 0.8 * np.sin(angle), r"$\mathbf{s}_L$", color=COLOURS[1])
    arc = np.linspace(0.0, angle, 20)
    ax.plot(0.58 * np.cos(arc), 0.58 * np.sin(arc), color=COLOURS[1], linewidth=1.0)
    ax.text(0.62 * np.cos(angle / 2), 0.62 * np.sin(angle / 2), r"$\theta_L$", color=COLOURS[1], va="center")
    ax.set_xlim(-0.6, 0.95)
    ax.set_ylim(-0.6, 0.9)
    text = "The angle is measured from $T_x$ towards $T_y$."
    return Outcome(figure, (text,), *pattern_csv([("five planes", FIVE)]))


def _found_7(*pair: Case) -> Iterable[str]:
    for direction, case in zip(DIRECTIONS, pair, strict=True):
        yield (
            f"{direction:g}°: $\\tau_L$ at 0.6 mm "
            f"{', '.join(f'{c.tau_L[-1]:.3f}' for c in case.curves if not c.lost)} MPa; "
            f"equilibrium under 2 MPa ends at $s_L$ = {case.at(2.0).s_L[-1]:.4f} mm."
        )
    zero = max(abs(case.at(0.0).tau_L[-1]) for case in pair)
    yield f"At $\\sigma_N$ = 0 the traction left at 0.6 mm is {small(zero)} MPa (Remark 4)."


def _found_8(*pair: Case) -> Iterable[str]:
    for direction, case in zip(DIRECTIONS, pair, strict=True):
        ends = [np.diff(c.s_N)[-1] / np.diff(c.s_L)[-1] for c in case.curves if not c.lost]
        limit = np.tan(np.radians(30.0)) * np.cos(np.radians(direction))
        yield (
            f"{direction:g}°: slope of the dilation at 0.6 mm {min(ends):.4f} to {max(ends):.4f}, up the "
            f"facing planes {limit:.4f}."
        )


def _found_9(*pair: Case) -> Iterable[str]:
    for direction, case in zip(DIRECTIONS, pair, strict=True):
        for c in case.curves[1:]:
            ends = ", ".join(f"{c.tau_L[i]:.3f}" for i in turns_of(c.s_L)[1:])
            yield (
                f"{direction:g}°, {signed(c.test.value)} MPa: $\\tau_L$ at the ends {ends} MPa, work of the "
                f"last loop {loop_work(c):.3f} N/mm."
            )


def _figure_10(*cases: Case) -> Outcome:
    figure, axes = new_figure(TWO, 2.9, ncols=2)
    found, parts = [], []
    for cyclic, title in enumerate(("(a) monotonic, η = 0.99", "(b) cyclic, η = 0.9")):
        ax, pair = axes[cyclic], cases[2 * cyclic : 2 * cyclic + 2]
        values = [c.test.value for c in pair[0].curves if not c.lost]
        for shade, value in zip(COLOURS, values, strict=False):
            for case, style, label in zip(pair, ("-", "--"), (signed(value), None), strict=True):
                c = case.at(value)
                ax.plot(c.s_L, c.tau_L, style, color=shade, label=label)
        ax.set_xlabel(SLIP)
        ax.set_ylabel(TRACTION)
        ax.grid(alpha=0.3)
        ax.set_title(title + r"; — 0°, - - 45°")
        label_ends(ax, SIGMA_N)
        ratios = (f"{signed(v)}: {pair[0].at(v).tau_L.max() / pair[1].at(v).tau_L.max():.3f}" for v in values)
        found.append(
            f"{title}, largest $\\tau_L$ along 0° over that along 45°, $\\sigma_N$ in MPa: "
            f"{', '.join(ratios)}."
        )
        for d, case in zip(DIRECTIONS, pair, strict=True):
            parts += [((cyclic, d, c.test.value), c) for c in case.curves]
    return Outcome(figure, tuple(found), *curves_csv(parts, f"cyclic,theta_L,{cases[0].name}"))


def _found_11(case: Case) -> Iterable[str]:
    ends = {c.test.value: float(c.tau_L[-1]) for c in case.curves}
    mirrored = max(float(np.abs(case.at(a).tau_L - case.at(90.0 - a).tau_L).max()) for a in (0.0, 15.0, 30.0))
    yield (
        f"$\\tau_L$ at 0.6 mm in MPa is {', '.join(f'{t:.3f} ({a:g}°)' for a, t in ends.items())}, the ratio "
        f"of the largest to the smallest {max(ends.values()) / min(ends.values()):.3f}."
    )
    yield (
        f"The difference between directions that the symmetry maps to each other is {small(mirrored)} MPa."
    )


def _figure_12(case: Case) -> Outcome:
    pairs = [(c.test.value, c.energy) for c in case.curves]
    least, most = (pick(energy for _, energy in pairs) for pick in (min, max))
    converged = fracture_energy(MATERIAL, FIVE)
    figure, (ax,) = new_figure(ONE, 3.2, subplot_kw={"projection": "polar"})
    polar(ax, converged.directions, converged.values, (0.32, 0.35), f"{ENERGY}, radius from 0.32")
    found = (
        f"With steps of 0.0025 mm, in 24 directions: {most:.6f} to {least:.6f} N/mm, spread "
        f"{100.0 * (most / least - 1.0):.2f} %. Converged, in 64 directions: {energy_range(converged)}.",
    )
    return Outcome(figure, found, "theta_L,G_T", tuple(numbers(*pair) for pair in pairs))


def _found_13(*pair: Case) -> Iterable[str]:
    for direction, case in zip(DIRECTIONS, pair, strict=True):
        tests = [c.test for c in case.curves]
        converged = (fracture_energy(t.material, t.pattern, np.array([direction])).values[0] for t in tests)
        yield (
            f"{direction:g}°: converged $G_T$ for $\\theta_m$ = {', '.join(f'{t.value:g}°' for t in tests)} "
            f"{', '.join(f'{e:.6f}' for e in converged)} N/mm."
        )
    if pair[0].curves[0].test.material.mu == 0.0:
        worst = max(abs(c.energy - c.test.material.Gc) for case in pair for c in case.curves)
        yield f"With steps of 0.0025 mm the largest difference from $G_c$ is {worst:.1e} N/mm."


def _figure_14() -> Outcome:
    figure, axes = new_figure(TWO, 2.5, ncols=3)
    for ax, name in zip(axes, ("RP-3", "RP-4", "RP-6"), strict=True):
        plan(ax, pattern(name), name)
    weights = [f"{pattern(name).weights[-1]:.5f}" for name in PATTERNS]
    same = weights == ["0.33333", "0.22222", "0.16667", "0.11111", "0.02083"]
    named = ", ".join(f"{w} ({n})" for n, w in zip(PATTERNS, weights, strict=True))
    found = f"The weights of an inclined plane are {named}; Table 4 has {'the same' if same else 'others'}."
    return Outcome(figure, (found,), *pattern_csv([(name, pattern(name)) for name in PATTERNS]))


def _table_5() -> Outcome:
    found = {name: fracture_energy(MATERIAL, pattern(name)) for name in PATTERNS}
    inferred = {name: sampled(name) for name in PATTERNS}
    converged = {n: (e.values.max(), e.values.min(), e.spread + 1.0) for n, e in found.items()}
    equal = sum(inferred[n][i] == TABLE_5[n][i] for n in PATTERNS for i in range(3))
    rows: list[Sequence[str]] = []
    for i, what in enumerate(("max", "min", "ratio")):
        rows.append([f"paper, {what}", *(TABLE_5[name][i] for name in PATTERNS)])
        rows.append([f"converged, {what}", *(f"{converged[name][i]:.6f}" for name in PATTERNS)])
    lines = (
        ",".join([n, *TABLE_5[n], *inferred[n], numbers(*converged[n], found[n].error.max())])
        for n in PATTERNS
    )
    texts = (
        f"\n{markdown(['', *PATTERNS], rows, numbers=True)}\n",
        "A sampling with steps of 0.0025 mm, 64 directions, and the trapezoidal rule over $s_L$ = 0 and "
        f"every tenth point from 0.0225 mm on gives {equal} of the 15 printed numbers to the last digit.",
        "For the converged values the steps are halved until no energy changes by more than 3e-7 N/mm.",
    )
    kinds = (
        "paper_max,paper_min,paper_ratio",
        "sampled_max,sampled_min,sampled_ratio",
        "G_T_max,G_T_min,ratio",
    )
    return Outcome(None, texts, ",".join(("pattern", *kinds, "error")), tuple(lines))


MONOTONIC = ("figure07a_08a_10a", "figure07b_08b_10a")
CYCLIC = ("figure09a_10b", "figure09b_10b")
CROSS = ((1, 0), (-1, 0), (0, 1), (0, -1))

ENTRIES = (
    Entry("1", (), in_space(FIVE, ("five planes", "five planes"), 3, CROSS, "4, 30, flat=0.2")),
    Entry("2", ("figure02",), _figure_2),
    Entry("3", (), in_space(pattern("RT"), ("RT", "trapezoid, RT"), 1, CROSS[:2], "2, 30")),
    Entry("4a", ("figure04a",), family(SIGMA_N, _found_4a)),
    Entry("4b", ("figure04b",), family(THETA_M, _found_4b)),
    Entry("5a", ("figure05a",), family(SIGMA_N, _found_5a)),
    Entry("5b", ("figure05b",), _figure_5b),
    Entry("6", (), _figure_6),
    Entry("7", MONOTONIC, panels("tau_L", TRACTION, _found_7)),
    Entry("8", MONOTONIC, panels("s_N", DILATION, _found_8)),
    Entry("9", CYCLIC, panels("tau_L", TRACTION, _found_9)),
    Entry("10", (*MONOTONIC, *CYCLIC), _figure_10),
    Entry("11", ("figure11",), family(THETA_L, _found_11)),
    Entry("12", ("figure12",), _figure_12),
    Entry("13a", ("figure13a_00", "figure13a_45"), panels("tau_L", TRACTION, _found_13, energies=True)),
    Entry("13b", ("figure13b_00", "figure13b_45"), panels("tau_L", TRACTION, _found_13, energies=True)),
    Entry("14", (), _figure_14),
    Entry("15", ("figure15a", "figure15b", "figure15c"), isotropy("RT", "RP-3", "RP-4")),
    Entry("16", ("figure16a", "figure16b"), isotropy("RP-6", "RP-32")),
    Entry("Table 5", (), _table_5),
)
"""Figures and tables in the order of the paper."""
