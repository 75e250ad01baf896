"""The recomputed figures and tables of the paper: statement of the paper, our result, difference."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from ..case_files import SlipTest, read_case, slip_tests
from ..contract import Floats
from ..installed import cases
from ..oracle import planar
from ..oracle.compare import parameters_of
from ..pattern import Pattern, direction_vector, unit_vector
from ..plots import COLOURS
from ..results import Rows, drive
from ..tables import markdown
from .fracture_energy import (
    MATERIAL,
    PATTERNS,
    SAMPLING,
    TABLE_5,
    Energies,
    fracture_energy,
    pattern,
    printed,
    sampled,
    spreads,
    table_5_curves,
)
from .gallery_draw import DILATION, ENERGY, SLIP, TRACTION, beside, curves, new_figure, plan, polar, space

FIVE = Pattern.regular(4, 30.0, flat=0.2)
"""The five planes of Table 3."""

MOST_ROWS = 101
"""Approximate number of rows of a curve in a CSV."""

ASSUMED_SLIP = "slip from 0 to 0.6 mm"
ASSUMED_STRESS = r"$\sigma_N$ = 2, 0, −2, −5, −10, −20 MPa"
ASSUMED_CYCLE = "slip 0, +0.4, −0.4, +0.4 mm"


@dataclass(frozen=True, eq=False)
class Curve:
    """Computed slip test from s_L = 0 under the normal traction; lost: whether it ends without equilibrium.

    s_L, s_N (T,), mm; tau_L along and tau_across left of the direction, MPa; damage (T,).
    """

    test: SlipTest
    separation: Floats
    traction: Floats
    s_L: Floats
    s_N: Floats
    tau_L: Floats
    tau_across: Floats
    damage: Floats
    lost: bool

    @property
    def energy(self) -> float:
        """Area under the curve (40) by the trapezoid rule over its rows, N/mm."""
        return float(np.sum(0.5 * (self.tau_L[1:] + self.tau_L[:-1]) * np.diff(self.s_L)))


@dataclass(frozen=True)
class Case:
    """Results of a case file; name: of its sweep."""

    title: str
    name: str
    curves: tuple[Curve, ...]

    def at(self, value: float) -> Curve:
        """Curve for a value of the sweep."""
        return next(curve for curve in self.curves if curve.test.value == value)


@dataclass(frozen=True, eq=False)
class Outcome:
    """Result of a figure: picture, findings, differences from the paper, and numbers as lines of a CSV."""

    figure: Figure
    came_out: tuple[str, ...]
    differs: str
    header: str
    lines: tuple[str, ...]


@dataclass(frozen=True)
class Entry:
    """A figure or table of the paper; cases: stems of its case files; make: computes and draws it."""

    number: str
    title: str
    cases: tuple[str, ...]
    says: str
    assumed: str
    make: Callable[..., Outcome]

    @property
    def stem(self) -> str:
        """Name of the files in the gallery."""
        if self.number.startswith("Table"):
            return self.number.lower().replace(" ", "")
        digits = self.number.rstrip("ab")
        return f"figure{int(digits):02d}{self.number[len(digits) :]}"

    def run(self) -> Outcome:
        """Run the cases by the driver, compute and draw."""
        return self.make(*(run_case(stem) for stem in self.cases))


def run_case(stem: str) -> Case:
    """Run a case of the paper by the driver; raises ValueError with its message if that fails."""
    path = next(path for path in cases() if path.stem == stem)
    results = drive(path)
    case = read_case(path)
    return Case(case.title, case.sweep, tuple(_curve(test, results[test.value]) for test in slip_tests(case)))


def _curve(test: SlipTest, rows: Rows) -> Curve:
    """Rows of a test from the end of its preload on; without preload the first row is the virgin point."""
    first = test.preload - 1
    s, t, damage = (
        rows.separation[max(first, 0) :],
        rows.traction[max(first, 0) :],
        rows.damage[max(first, 0) :],
    )
    if first < 0:
        s, t, damage = np.pad(s, ((1, 0), (0, 0))), np.pad(t, ((1, 0), (0, 0))), np.pad(damage, (1, 0))
    e = direction_vector(test.direction)
    across = np.array([-e[1], e[0]])
    lost = "lost" in rows.events[-1]
    return Curve(test, s, t, s[:, 1:] @ e, s[:, 0], t[:, 1:] @ e, t[:, 1:] @ across, damage, lost)


# --- tables --------------------------------------------------------------------------------------------


ROUNDING = 1.0e-12
"""Differences below this are rounding errors, which change from machine to machine."""


def _numbers(*values: float) -> str:
    """Cells of a CSV with six digits; values within ROUNDING are zero."""
    return ",".join(f"{value if abs(value) > ROUNDING else 0.0:.6g}" for value in values)


def _small(difference: float) -> str:
    return f"{difference:.0e}" if difference > ROUNDING else f"below {ROUNDING:.0e}"


def _thinned(curve: Curve) -> range:
    """Indices of the rows of a curve in the CSV, the last row included."""
    count = len(curve.s_L)
    stride = max(1, (count - 1) // (MOST_ROWS - 1) + ((count - 1) % (MOST_ROWS - 1) > 0))
    rows = list(range(0, count, stride))
    return rows if rows[-1] == count - 1 else [*rows, count - 1]


def _csv(parts: Sequence[tuple[Sequence[float], Curve]], names: str) -> tuple[str, tuple[str, ...]]:
    """Header and lines of curves, each with the values that identify the curve."""
    lines = [
        _numbers(*values, *(column[i] for column in (c.s_L, c.tau_L, c.tau_across, c.s_N, c.damage)))
        for values, c in parts
        for i in _thinned(c)
    ]
    return f"{names},s_L,tau_L,tau_across,s_N,damage", tuple(lines)


def _pattern_csv(parts: Sequence[tuple[str, Pattern]]) -> tuple[str, tuple[str, ...]]:
    lines = [
        f"{name},{k + 1},{_numbers(*normal, weight)}"
        for name, p in parts
        for k, (normal, weight) in enumerate(zip(p.normals, p.weights, strict=True))
    ]
    return "pattern,k,n_N,n_Tx,n_Ty,gamma", tuple(lines)


def _list(texts: Sequence[str]) -> str:
    return ", ".join(texts)


def _sigma(value: float) -> str:
    return f"{value:g}".replace("-", "−")


# --- patterns ------------------------------------------------------------------------------------------


def _same_planes(ours: Pattern, table: Sequence[tuple[float, float, float]], theta: float) -> float:
    """Largest difference of the normals of a pattern and those of a table, in any order of the planes."""
    c, s = np.cos(np.radians(theta)), np.sin(np.radians(theta))
    wanted = np.array([(1.0, 0.0, 0.0) if not (x or y) else (c, s * x, s * y) for _, x, y in table])
    distance = np.abs(ours.normals[:, None] - wanted[None]).max(axis=2)
    return float(max(distance.min(axis=0).max(), distance.min(axis=1).max()))


def figure_1() -> Outcome:
    """Five planes in space."""
    figure, (ax,) = new_figure(4.2, 3.0, subplot_kw={"projection": "3d"})
    space(ax, FIVE, "five planes, 30°")
    table = [(1, 0, 0), (1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1)]
    return Outcome(
        figure,
        (
            f"Normals of Table 3, difference {_small(_same_planes(FIVE, table, 30.0))}; weights "
            f"{FIVE.weights[0]:g}: "
            "`Pattern.regular(4, 30, flat=0.2)`.",
        ),
        "The order of the inclined planes: Table 3 lists them in pairs, (41)–(43) go round the axis.",
        *_pattern_csv([("five planes", FIVE)]),
    )


def figure_3() -> Outcome:
    """Trapezoid in space."""
    figure, (ax,) = new_figure(4.2, 3.0, subplot_kw={"projection": "3d"})
    trapezoid = pattern("RT")
    space(ax, trapezoid, "trapezoid, RT, 30°")
    table = [(1, 0, 0), (1, 1, 0), (1, -1, 0)]
    return Outcome(
        figure,
        (
            f"Normals of Table 1, difference {_small(_same_planes(trapezoid, table, 30.0))}; weights "
            f"{trapezoid.weights[0]:.4f}: `Pattern.regular(2, 30)`.",
        ),
        "Nothing but the order of the two inclined planes.",
        *_pattern_csv([("RT", trapezoid)]),
    )


def figure_6() -> Outcome:
    """Five planes in plan with the direction of slip."""
    figure, (ax,) = new_figure(3.4, 3.2)
    plan(ax, FIVE, "five planes, direction of slip", numbers=False)
    for vector, label in (((0.75, 0.0), "$T_x$"), ((0.0, 0.75), "$T_y$")):
        ax.annotate("", vector, (0, 0), arrowprops={"arrowstyle": "->", "color": "black"})
        ax.text(*(1.08 * np.array(vector)), label, ha="center", va="center")
    angle = np.radians(30.0)
    ax.annotate(
        "", 0.72 * unit_vector(angle), (0, 0),
        arrowprops={"arrowstyle": "->", "color": COLOURS[1], "linewidth": 1.6},
    )  # fmt: skip
    ax.text(0.78 * np.cos(angle), 0.8 * np.sin(angle), r"$\mathbf{s}_L$", color=COLOURS[1])
    arc = np.linspace(0.0, angle, 20)
    ax.plot(0.58 * np.cos(arc), 0.58 * np.sin(arc), color=COLOURS[1], linewidth=1.0)
    ax.text(0.62 * np.cos(angle / 2), 0.62 * np.sin(angle / 2), r"$\theta_L$", color=COLOURS[1], va="center")
    ax.set_xlim(-0.6, 0.95)
    ax.set_ylim(-0.6, 0.9)
    lines = _pattern_csv([("five planes", FIVE)])
    return Outcome(figure, ("The angle goes from $T_x$ towards $T_y$.",), "Nothing.", *lines)


def figure_14() -> Outcome:
    """Patterns in plan."""
    figure, axes = new_figure(8.4, 2.9, ncols=3)
    for ax, name in zip(axes, ("RP-3", "RP-4", "RP-6"), strict=True):
        plan(ax, pattern(name), name)
    weights = {name: f"{pattern(name).weights[-1]:.5f}" for name in PATTERNS}
    table_4 = dict(zip(PATTERNS, ("0.33333", "0.22222", "0.16667", "0.11111", "0.02083"), strict=True))
    verdict = "those of Table 4" if weights == table_4 else "not those of Table 4"
    return Outcome(
        figure,
        (
            f"Weights of an inclined plane {_list([f'{n} {w}' for n, w in weights.items()])}: {verdict}.",
            "Areas in plan are drawn in the ratio of the weights.",
        ),
        "Nothing.",
        *_pattern_csv([(name, pattern(name)) for name in PATTERNS]),
    )


# --- Section 2 -----------------------------------------------------------------------------------------


def figure_2(case: Case) -> Outcome:
    """Opening in mode I."""
    (curve,) = case.curves
    m = curve.test.material
    s_f, s_0 = m.s_f, m.s_0
    s, t = curve.s_N, curve.traction[:, 0]
    triangle = np.interp(s, [0.0, s_0, s_f, s[-1]], [0.0, m.sigma0, 0.0, 0.0])
    area = float(np.sum(0.5 * (t[1:] + t[:-1]) * np.diff(s)))
    figure, (ax,) = new_figure(5.0, 3.2)
    curves(ax, [("", s, t, False)], "opening $s_N$ [mm]", r"traction $\sigma_N$ [MPa]")
    ax.plot([s_0, s_f], [m.sigma0, 0.0], "o", color=COLOURS[1], markersize=5)
    ax.text(s_0 + 0.006, m.sigma0, r"$(s_0, \sigma_0)$")
    ax.text(s_f, 0.12, "$s_f$", ha="center")
    ax.text(0.075, 0.6, "area $G_c$")
    return Outcome(
        figure,
        (
            f"Largest traction {t.max():.6g} MPa, area {area:.6g} N/mm; largest difference from the triangle "
            f"{_small(float(np.abs(t - triangle).max()))} MPa.",
        ),
        "Nothing. The paper draws symbols; the numbers here are those of Table 2.",
        "s_N,t_N",
        tuple(_numbers(*pair) for pair in zip(s, t, strict=True)),
    )


# --- Section 4.1 ---------------------------------------------------------------------------------------


def _planar_difference(case: Case) -> str:
    """Largest difference from the 2D law along the same separations."""
    worst = 0.0
    for curve in case.curves:
        m, p = curve.test.material, curve.test.pattern
        planes = [(0.0, 1.0)] if p.m == 0 else planar.trapezoid(p.theta)
        # one increment of preload is exact: each plane slides in proportion to the load
        path = [tuple(row) for row in curve.separation[: len(curve.s_L) - curve.lost, :2]]
        theirs = np.array([response.traction for response in planar.replay(parameters_of(m), planes, path)])
        worst = max(worst, float(np.abs(theirs - curve.traction[: len(theirs), :2]).max()))
    return _small(worst)


def _family(case: Case, legend: str, **size: float) -> tuple[Figure, tuple[str, tuple[str, ...]]]:
    """Figure of tau_L over s_L for the curves of a sweep, and their CSV."""
    figure, (ax,) = new_figure(size.get("width", 5.6), size.get("height", 3.8))
    lines = [(_sigma(c.test.value), c.s_L, c.tau_L, c.lost) for c in case.curves]
    curves(ax, lines, SLIP, TRACTION, legend)
    return figure, _csv([((c.test.value,), c) for c in case.curves], case.name)


def figure_4a(case: Case) -> Outcome:
    """Flat interface."""
    figure, table = _family(case, r"$\sigma_N$ [MPa]")
    m = case.curves[0].test.material
    slopes = [c.tau_L[1] / c.s_L[1] / m.K for c in case.curves]
    whole = [c for c in case.curves if not c.lost]
    residual = [abs(c.tau_L[-1] - m.mu * abs(c.test.sigma_N)) for c in whole]
    ends = _list([f"{c.tau_L[-1]:.4g}" for c in whole])
    (lost,) = [c for c in case.curves if c.lost]
    return Outcome(
        figure,
        (
            "Slope of the first increment over $K$: 1, difference "
            f"{_small(max(abs(s - 1.0) for s in slopes))}.",
            f"Ends at $\\tau_L$ = {ends} MPa: $\\mu |\\sigma_N|$, difference {_small(max(residual))} MPa.",
            f"$\\sigma_N$ = {_sigma(lost.test.sigma_N)} MPa has no equilibrium beyond $s_L$ = "
            f"{lost.s_L[-1]:.4f} mm (cross).",
            f"Largest difference from the 2D law along the same path {_planar_difference(case)} MPa.",
        ),
        "The text does not say that the curve in tension ends; nothing else differs.",
        *table,
    )


def figure_4b(case: Case) -> Outcome:
    """Inclination of the planes."""
    figure, table = _family(case, r"$\theta_m$ [°]")
    m = case.curves[0].test.material
    shares = [
        f"{c.test.value:g}° {c.tau_L[-1]:.2f} of {10.0 * m.residual_strength(c.test.value):.2f}"
        for c in case.curves
    ]
    return Outcome(
        figure,
        (
            f"$\\tau_L$ at 0.6 mm, of the residual strength that is approached, MPa: {_list(shares)}.",
            f"Largest difference from the 2D law along the same path {_planar_difference(case)} MPa.",
        ),
        "Nothing in the text. The steep planes are far from their residual at 0.6 mm: the contact is as "
        "soft as "
        "the bond.",
        *table,
    )


def figure_5a(case: Case) -> Outcome:
    """Small pressures."""
    figure, table = _family(case, r"$\sigma_N$ [MPa]")
    m = case.curves[0].test.material
    ratio = m.residual_strength(35.0)
    shares = [
        f"{_sigma(c.test.value)}: {c.tau_L[-1]:.3f} of {abs(c.test.value) * ratio:.3f}"
        for c in case.curves
        if c.test.value != 0.0
    ]
    peaks = _list([f"{c.tau_L.max():.3f}" for c in case.curves])
    return Outcome(
        figure,
        (
            f"Largest tractions {peaks} MPa.",
            f"$\\tau_L$ at 0.6 mm of the residual strength, MPa: {_list(shares)}.",
            f"Largest difference from the 2D law along the same path {_planar_difference(case)} MPa.",
        ),
        "Nothing in the text.",
        *table,
    )


def figure_5b(case: Case) -> Outcome:
    """Cyclic slip."""
    (curve,) = case.curves
    figure, axes = new_figure(8.4, 3.4, ncols=2)
    curves(axes[0], [("", curve.s_L, curve.tau_L, False)], SLIP, TRACTION)
    curves(axes[1], [("", curve.s_L, curve.s_N, False)], SLIP, DILATION)
    turns = _turns(curve)
    return Outcome(
        figure,
        (
            f"$\\tau_L$ at the ends of the three strokes {_list([f'{curve.tau_L[i]:.3f}' for i in turns])} "
            "MPa, "
            f"dilation {_list([f'{curve.s_N[i]:.4f}' for i in turns])} mm.",
            f"Work of the last stroke and the one before {_loop(curve):.3f} N/mm.",
            f"Largest difference from the 2D law along the same path {_planar_difference(case)} MPa.",
        ),
        "Nothing in the text. The right picture, dilation, is ours.",
        *_csv([((curve.test.sigma_N,), curve)], "sigma_N"),
    )


def _turns(curve: Curve) -> list[int]:
    """Rows at which the strokes of a cycle end."""
    steps = np.sign(np.diff(curve.s_L))
    return [*(np.flatnonzero(np.diff(steps)) + 1), len(curve.s_L) - 1]


def _loop(curve: Curve) -> float:
    """Area of the closed loop that the last two strokes make, stress*length."""
    first = _turns(curve)[-3]
    tau, s = curve.tau_L[first:], curve.s_L[first:]
    return float(np.sum(0.5 * (tau[1:] + tau[:-1]) * np.diff(s)))


# --- Section 4.2 ---------------------------------------------------------------------------------------


def figure_7(case_0: Case, case_45: Case) -> Outcome:
    """Tractions in two directions."""
    figure, axes = new_figure(8.8, 3.8, ncols=2, sharey=True)
    for ax, case, part in zip(axes, (case_0, case_45), ("(a) 0°", "(b) 45°"), strict=True):
        lines = [(_sigma(c.test.value), c.s_L, c.tau_L, c.lost) for c in case.curves]
        curves(ax, lines, SLIP, TRACTION, r"$\sigma_N$ [MPa]" if ax is axes[-1] else "")
        ax.set_title(rf"{part[:3]} $\theta_L$ = {part[4:]}", fontsize="small")
    came_out = [
        f"{direction}°: $\\tau_L$ at 0.6 mm "
        + _list([f"{c.tau_L[-1]:.3f}" for c in case.curves if not c.lost])
        + " MPa; $\\sigma_N$ = 2 MPa has no equilibrium beyond "
        + f"$s_L$ = {case.at(2.0).s_L[-1]:.4f} mm."
        for direction, case in ((0, case_0), (45, case_45))
    ]
    zero = max(abs(case.at(0.0).tau_L[-1]) for case in (case_0, case_45))
    return Outcome(
        figure,
        (*came_out, f"At $\\sigma_N$ = 0 what is left at 0.6 mm is {_small(zero)} MPa (Remark 4)."),
        "Nothing in the text. Remark 4 says Figure 9(a) and means this one.",
        *_two_directions(case_0, case_45),
    )


def _two_directions(case_0: Case, case_45: Case) -> tuple[str, tuple[str, ...]]:
    parts = [((d, c.test.value), c) for d, case in ((0, case_0), (45, case_45)) for c in case.curves]
    return _csv(parts, f"theta_L,{case_0.name}")


def figure_8(case_0: Case, case_45: Case) -> Outcome:
    """Dilation in two directions."""
    figure, axes = new_figure(8.8, 3.8, ncols=2, sharey=True)
    for ax, case, part in zip(axes, (case_0, case_45), ("(a) 0°", "(b) 45°"), strict=True):
        lines = [(_sigma(c.test.value), c.s_L, c.s_N, c.lost) for c in case.curves]
        curves(ax, lines, SLIP, DILATION, r"$\sigma_N$ [MPa]" if ax is axes[-1] else "")
        ax.set_title(rf"{part[:3]} $\theta_L$ = {part[4:]}", fontsize="small")
    slope = np.tan(np.radians(30.0))
    came_out = []
    for direction, case, limit in ((0, case_0, slope), (45, case_45, slope * np.cos(np.pi / 4.0))):
        ends = [np.diff(c.s_N)[-1] / np.diff(c.s_L)[-1] for c in case.curves if not c.lost]
        came_out.append(
            f"{direction}°: slope of the dilation at 0.6 mm {_list([f'{e:.4f}' for e in ends])} "
            f"for $\\sigma_N$ = 0 to −20 MPa; up the facing planes it is {limit:.4f}."
        )
    return Outcome(
        figure,
        tuple(came_out),
        "Nothing: every curve still rises at the end, the dilation is unbounded, as the paper says. "
        "[A finite asperity height](../extensions.md#3-what-the-height-changes) bounds it.",
        *_two_directions(case_0, case_45),
    )


def figure_9(case_0: Case, case_45: Case) -> Outcome:
    """Cycles in two directions."""
    figure, axes = new_figure(8.8, 3.8, ncols=2, sharey=True)
    came_out = []
    for ax, case, part in zip(axes, (case_0, case_45), ("(a) 0°", "(b) 45°"), strict=True):
        lines = [(_sigma(c.test.value), c.s_L, c.tau_L, c.lost) for c in case.curves]
        curves(ax, lines, SLIP, TRACTION, r"$\sigma_N$ [MPa]" if ax is axes[-1] else "")
        ax.set_title(rf"{part[:3]} $\theta_L$ = {part[4:]}", fontsize="small")
        for c in case.curves[1:]:
            ends = _list([f"{c.tau_L[i]:.3f}" for i in _turns(c)])
            came_out.append(
                f"{part[4:]}, $\\sigma_N$ = {_sigma(c.test.value)}: {ends} MPa at the ends of the strokes, "
                f"{_loop(c):.3f} N/mm in the last loop."
            )
    return Outcome(
        figure,
        tuple(came_out),
        "Nothing in the text, which gives one fixed $\\sigma_N$ and the caption none; the values are "
        "assumed. [The same cycles with asperities that end and wear]"
        "(../extensions.md#3-what-the-height-changes).",
        *_two_directions(case_0, case_45),
    )


def figure_10(mono_0: Case, mono_45: Case, cyclic_0: Case, cyclic_45: Case) -> Outcome:
    """Both directions on top of each other."""
    figure, axes = new_figure(8.8, 3.8, ncols=2)
    came_out = []
    for ax, pair, part in (
        (axes[0], (mono_0, mono_45), "(a) monotonic, η = 0.99"),
        (axes[1], (cyclic_0, cyclic_45), "(b) cyclic, η = 0.9"),
    ):
        values = [c.test.value for c in pair[0].curves if not c.lost]
        for i, value in enumerate(values):
            for case, style in zip(pair, ("-", "--"), strict=True):
                c = case.at(value)
                label = rf"{_sigma(value)}" if style == "-" else None
                ax.plot(c.s_L, c.tau_L, style, color=COLOURS[i], linewidth=1.4, label=label)
        ax.set_xlabel(SLIP)
        ax.set_ylabel(TRACTION)
        ax.grid(alpha=0.3)
        beside(ax, r"$\sigma_N$ [MPa]")
        ax.set_title(part + r"; — 0°, - - 45°", fontsize="small")
        ratios = [f"{_sigma(v)}: {pair[0].at(v).tau_L.max() / pair[1].at(v).tau_L.max():.3f}" for v in values]
        came_out.append(
            f"{part}: largest $\\tau_L$ along 0° over that along 45°, by $\\sigma_N$: {_list(ratios)}."
        )
    names = f"cyclic,theta_L,{mono_0.name}"
    parts = [
        ((cyclic, d, c.test.value), c)
        for cyclic, d, case in ((0, 0, mono_0), (0, 45, mono_45), (1, 0, cyclic_0), (1, 45, cyclic_45))
        for c in case.curves
    ]
    return Outcome(
        figure,
        tuple(came_out),
        "In (a) the two directions part more and more as the confinement grows, as the paper says. In (b) "
        "they part "
        "more than without confinement, but at −10 MPa the order is turned round and the ratio nearer to 1 "
        "than at "
        "−5: 0.4 mm is too short for the soft contact, η = 0.9, to reach the residual strength.",
        *_csv(parts, names),
    )


def figure_11(case: Case) -> Outcome:
    """Several directions."""
    figure, table = _family(case, r"$\theta_L$ [°]")
    ends = {c.test.value: float(c.tau_L[-1]) for c in case.curves}
    mirrored = max(float(np.abs(case.at(a).tau_L - case.at(90.0 - a).tau_L).max()) for a in (0.0, 15.0, 30.0))
    return Outcome(
        figure,
        (
            f"$\\tau_L$ at 0.6 mm {_list([f'{a:g}° {t:.3f}' for a, t in ends.items()])} MPa: largest over "
            "smallest "
            f"{max(ends.values()) / min(ends.values()):.3f}.",
            "Directions that the symmetry maps on each other (0° and 90°, 15° and 75°, 30° and 60°): "
            f"difference {_small(mirrored)} MPa.",
        ),
        "Nothing in the text.",
        *table,
    )


def figure_12(case: Case) -> Outcome:
    """Energy over the direction."""
    energies = np.array([c.energy for c in case.curves])
    angles = np.array([c.test.value for c in case.curves])
    converged = fracture_energy(MATERIAL, FIVE)
    figure, (ax,) = new_figure(4.0, 3.8, subplot_kw={"projection": "polar"})
    polar(ax, converged.directions, converged.values, (0.32, 0.35), f"{ENERGY}, radius from 0.32")
    return Outcome(
        figure,
        (
            f"Steps of 0.0025 mm, area over all points, 24 directions: {energies.max():.6f} to "
            f"{energies.min():.6f} N/mm, spread {100.0 * (energies.max() / energies.min() - 1.0):.2f} %.",
            f"Converged, 64 directions: {_range(converged)}.",
        ),
        "The paper gives no number. Its sampling is that of Table 5 in all likelihood, and then coarse.",
        "theta_L,G_T",
        tuple(_numbers(*pair) for pair in zip(angles, energies, strict=True)),
    )


SURE = 2.0e-6
"""Spread that the last change of the steps (1e-6 of Gc, largest and smallest energy) cannot make up."""


def _range(energies: Energies) -> str:
    spread = f"spread {100.0 * energies.spread:.2g} %"
    if energies.spread < SURE:
        spread = f"spread below {100.0 * SURE:g} %"
    error = f"error estimate {energies.error.max():.0e}"
    return f"{energies.largest:.6f} to {energies.smallest:.6f} N/mm ({error}), {spread}"


# --- Section 4.3 ---------------------------------------------------------------------------------------


def figure_13(case_0: Case, case_45: Case) -> Outcome:
    """Zero normal traction, several inclinations."""
    figure, axes = new_figure(8.8, 3.8, ncols=2, sharey=True)
    came_out = []
    for ax, case, direction in zip(axes, (case_0, case_45), (0.0, 45.0), strict=True):
        lines = []
        for c in case.curves:
            lines.append((f"{c.test.value:g}, {c.energy:.4f}", c.s_L, c.tau_L, c.lost))
        curves(ax, lines, SLIP, TRACTION, r"$\theta_m$ [°], $G_T$ [N/mm]", inside=True)
        ax.set_xlim(-0.005, 0.25)
        ax.set_title(rf"$\theta_L$ = {direction:g}°", fontsize="small")
        converged = [
            fracture_energy(c.test.material, c.test.pattern, np.array([direction])) for c in case.curves
        ]
        came_out.append(
            f"{direction:g}°: $G_T$ = {_list([f'{c.energy:.6f}' for c in case.curves])} N/mm for "
            f"{_list([f'{c.test.value:g}°' for c in case.curves])} in steps of 0.0025 mm, all points; "
            "converged "
            f"{_list([f'{e.largest:.6f}' for e in converged])}."
        )
    without = case_0.curves[0].test.material.mu == 0.0
    worst = max(abs(c.energy - c.test.material.Gc) for case in (case_0, case_45) for c in case.curves)
    if without:
        came_out.append(f"Largest difference from $G_c$ in these steps {worst:.1e} N/mm.")
        differs = "Nothing: the energy is $G_c$ in every case, the curves differ."
    else:
        differs = (
            "The numbers in the paper's legend are lost with the picture. The growth with the inclination "
            "and the "
            "dependence on the direction come out."
        )
    parts = [((d, c.test.value), c) for d, case in ((0, case_0), (45, case_45)) for c in case.curves]
    return Outcome(figure, tuple(came_out), differs, *_csv(parts, f"theta_L,{case_0.name}"))


# --- Section 4.4 ---------------------------------------------------------------------------------------


def _isotropy(names: Sequence[str], found: Sequence[Case]) -> Outcome:
    """Curves over the direction on the left, energy on the right, a row for each pattern."""
    figure = Figure(figsize=(8.4, 3.2 * len(names)), layout="constrained")
    came_out, found_energies = [], []
    for i, (name, case) in enumerate(zip(names, found, strict=True)):
        left = figure.add_subplot(len(names), 2, 2 * i + 1)
        right = figure.add_subplot(len(names), 2, 2 * i + 2, projection="polar")
        lines = [(f"{c.test.value:g}", c.s_L, c.tau_L, c.lost) for c in case.curves]
        curves(left, lines, SLIP, TRACTION, r"$\theta_L$ [°]")
        left.set_title(rf"{name}, $\sigma_N$ = −5 MPa", fontsize="small")
        energies = fracture_energy(MATERIAL, pattern(name))
        found_energies.append(energies)
        title = rf"{name}, {ENERGY} at $\sigma_N$ = 0, radius from 0.28"
        polar(right, energies.directions, energies.values, (0.28, 0.37), title)
        ends = np.array([c.tau_L[-1] for c in case.curves])
        came_out.append(
            f"{name}: $\\tau_L$ at 0.6 mm {ends.min():.3f} to {ends.max():.3f} MPa, spread "
            f"{100.0 * (ends.max() / ends.min() - 1.0):.2f} %; $G_T$ converged {_range(energies)}."
        )
    larger = max(e.largest / float(TABLE_5[n][0]) - 1.0 for n, e in zip(names, found_energies, strict=True))
    parts = [
        ((PATTERNS[n], c.test.value), c) for n, case in zip(names, found, strict=True) for c in case.curves
    ]
    return Outcome(
        figure,
        tuple(came_out),
        "The curves coincide at small slip and part later, less with more planes, as the paper says. The "
        "energies are "
        f"larger than those of Table 5, by up to {100.0 * larger:.1f} %, because of its quadrature.",
        *_csv(parts, "m,theta_L"),
    )


def figure_15(rt: Case, rp_3: Case, rp_4: Case) -> Outcome:
    """RT, RP-3, RP-4."""
    return _isotropy(("RT", "RP-3", "RP-4"), (rt, rp_3, rp_4))


def figure_16(rp_6: Case, rp_32: Case) -> Outcome:
    """RP-6, RP-32."""
    return _isotropy(("RP-6", "RP-32"), (rp_6, rp_32))


INTERVALS = (1, 2, 5, 10, 20)
"""Sampling intervals of the chart, in steps."""


def table_5() -> Outcome:
    """Energies three ways, and what the sampling does to the order of RP-4 and RP-6."""
    lines, came_out, equal = [], [], 0
    rows: list[Sequence[str]] = []
    found = {name: fracture_energy(MATERIAL, pattern(name)) for name in PATTERNS}
    coarse = {name: table_5_curves(name) for name in PATTERNS}
    inferred = {name: sampled(coarse[name], *SAMPLING) for name in PATTERNS}
    for i, what in enumerate(("max", "min", "ratio")):
        rows.append([f"paper, {what}", *(TABLE_5[name][i] for name in PATTERNS)])
        ours = {name: printed(*inferred[name])[i] for name in PATTERNS}
        equal += sum(ours[name] == TABLE_5[name][i] for name in PATTERNS)
        rows.append([f"inferred sampling, {what}", *ours.values()])
        values = [(e.largest, e.smallest, e.spread + 1.0)[i] for e in found.values()]
        rows.append([f"converged, {what}", *(f"{v:.6f}" for v in values)])
    rows.append(["error estimate", *(f"{e.error.max():.0e}" for e in found.values())])
    rows.append(["increments", *(str(e.increments) for e in found.values())])
    for name in PATTERNS:
        e = found[name]
        lines.append(",".join([name, *TABLE_5[name], *printed(*inferred[name]),
                               _numbers(e.largest, e.smallest, e.spread + 1.0, e.error.max())]))  # fmt: skip
    spread = {name: spreads(coarse[name], INTERVALS) for name in ("RP-4", "RP-6")}
    figure, axes = new_figure(8.8, 3.8, ncols=2, sharey=True)
    offsets = np.arange(1, SAMPLING[1] + 1)
    for name, shade, marker in (("RP-4", COLOURS[0], "o"), ("RP-6", COLOURS[1], "s")):
        bands = spread[name]
        share = 100.0 * bands[SAMPLING[1]]
        axes[0].plot(offsets, share, marker + "-", color=shade, label=f"{name}, every tenth point")
        axes[0].axhline(100.0 * found[name].spread, color=shade, linestyle="--", label=f"{name}, converged")
        low, high = (100.0 * np.array([f(bands[k]) for k in INTERVALS]) for f in (np.min, np.max))
        axes[1].fill_between(INTERVALS, low, high, color=shade, alpha=0.3, label=f"{name}, over all offsets")
        axes[1].plot(INTERVALS, low, color=shade, linewidth=0.8)
        axes[1].plot(INTERVALS, high, color=shade, linewidth=0.8)
        axes[1].axhline(100.0 * found[name].spread, color=shade, linestyle="--", label=f"{name}, converged")
    axes[0].axvline(SAMPLING[0], color="black", linewidth=0.8, linestyle=":")
    axes[0].annotate("Table 5", (SAMPLING[0], 1.45), (SAMPLING[0] - 0.2, 1.45), ha="right", fontsize="small")
    axes[0].set_xticks(offsets)
    axes[0].set_xlabel("first point after $s_L$ = 0 [steps of 0.0025 mm]")
    axes[0].set_ylabel("spread of $G_T$ over 64 directions [%]")
    axes[1].set_xscale("log")
    axes[1].set_xticks(INTERVALS, [str(k) for k in INTERVALS])
    axes[1].set_xticks([], minor=True)
    axes[1].set_xlabel("sampling interval [steps of 0.0025 mm]")
    for ax in axes:
        ax.grid(alpha=0.3)
        ax.legend(fontsize="x-small")
        ax.set_ylim(0.0, None)
    wrong = [
        int(k) for k in offsets if spread["RP-4"][SAMPLING[1]][k - 1] < spread["RP-6"][SAMPLING[1]][k - 1]
    ]
    safe = [k for k in INTERVALS if spread["RP-4"][k].min() > spread["RP-6"][k].max()]
    came_out += [
        f"\n{markdown(['', *PATTERNS], rows, numbers=True)}\n",
        f"By the inferred sampling {equal} of 15 printed numbers come out to the last digit: steps of "
        "0.0025 mm, 64 "
        "directions, the trapezoid rule over $s_L$ = 0 and every tenth point from 0.0225 mm on.",
        "Converged: the steps are halved until no energy changes by more than 3e-7 N/mm (1e-6 of $G_c$); "
        "the error "
        "estimate is the last change.",
        "Every tenth point leaves ten choices of the first one. RP-4 comes out below RP-6 for "
        f"{len(wrong)} of them "
        f"(first point {_list([str(k) for k in wrong])}), Table 5's among them. For the others, for any "
        "first point at "
        f"intervals of {_list([str(k) for k in safe])} steps, and converged, RP-6 is the more isotropic one.",
    ]
    return Outcome(
        figure,
        tuple(came_out),
        f"The order of RP-4 and RP-6: printed {TABLE_5['RP-4'][2]} and {TABLE_5['RP-6'][2]}, converged "
        f"{found['RP-4'].spread + 1.0:.4f} and {found['RP-6'].spread + 1.0:.4f}. That RP-4 spreads less "
        "than 0.2 % is "
        "an artefact of the quadrature. The sampling is inferred: the paper says Simpson with 0.0025 mm.",
        "pattern,paper_max,paper_min,paper_ratio,sampled_max,sampled_min,sampled_ratio,G_T_max,G_T_min,ratio,error",
        tuple(lines),
    )


ENTRIES = (
    Entry(
        "1",
        "Example of a RIE with five planes",
        (),
        "A flat plane and four inclined ones.",
        "θ = 30°.",
        figure_1,
    ),
    Entry(
        "2",
        "Mode I law of one plane",
        ("figure02",),
        "Bilinear: linear up to $\\sigma_0$ at $s_0$, then down to zero at $s_f$; the area is $G_c$.",
        "",
        figure_2,
    ),
    Entry("3", "RIE of three planes of Section 4.1", (), "Trapezoid, Table 1.", "θ = 30°.", figure_3),
    Entry(
        "4a",
        "Flat interface, monotonic slip",
        ("figure04a",),
        "The 2D results are recovered. Linear at first, horizontal at the end, where friction alone is left "
        "(Remark 3); $\\sigma_N$ from −20 to 2 MPa.",
        f"{ASSUMED_SLIP}; {ASSUMED_STRESS}.",
        figure_4a,
    ),
    Entry(
        "4b",
        "Inclination of the planes, σ_N = −10 MPa",
        ("figure04b",),
        "The 2D results are recovered; $\\theta_m$ from 0 to 45°.",
        f"{ASSUMED_SLIP}; $\\theta_m$ = 0, 15, 25, 30, 35, 45°.",
        figure_4b,
    ),
    Entry(
        "5a",
        "Small pressures, 35°",
        ("figure05a",),
        "The 2D results are recovered; $\\sigma_N$ from −2 to 0 MPa.",
        f"{ASSUMED_SLIP}; $\\sigma_N$ = 0, −0.5, −1, −1.5, −2 MPa.",
        figure_5a,
    ),
    Entry(
        "5b",
        "Cyclic slip, 30°, σ_N = −10 MPa",
        ("figure05b",),
        "The 2D results are recovered.",
        f"{ASSUMED_CYCLE}.",
        figure_5b,
    ),
    Entry(
        "6", "The five planes in plan", (), "$\\theta_L$ is the direction of slip from $T_x$.", "", figure_6
    ),
    Entry(
        "7",
        "Five planes, monotonic slip along 0° and 45°",
        ("figure07a_08a_10a", "figure07b_08b_10a"),
        "The response depends on the direction; $\\eta$ = 0.99. At $\\sigma_N$ = 0 the traction drops to "
        "zero.",
        f"{ASSUMED_SLIP}; {ASSUMED_STRESS}.",
        figure_7,
    ),
    Entry(
        "8",
        "Five planes, dilation along 0° and 45°",
        ("figure07a_08a_10a", "figure07b_08b_10a"),
        "The dilation is unbounded; the asperities do not wear.",
        f"{ASSUMED_SLIP}; {ASSUMED_STRESS}.",
        figure_8,
    ),
    Entry(
        "9",
        "Five planes, cyclic slip along 0° and 45°",
        ("figure09a_10b", "figure09b_10b"),
        "The response depends on the direction; $\\eta$ = 0.9.",
        f"{ASSUMED_CYCLE}; $\\sigma_N$ = 0, −5, −10 MPa.",
        figure_9,
    ),
    Entry(
        "10",
        "Five planes, 0° against 45°",
        ("figure07a_08a_10a", "figure07b_08b_10a", "figure09a_10b", "figure09b_10b"),
        "The anisotropy is more pronounced under confinement.",
        "as in Figures 7 and 9; $\\eta$ = 0.99 in (a), 0.9 in (b).",
        figure_10,
    ),
    Entry(
        "11",
        "Five planes, several directions, σ_N = −5 MPa",
        ("figure11",),
        "The response depends on the direction, from 0 to 90°.",
        f"{ASSUMED_SLIP}; $\\theta_L$ every 15°.",
        figure_11,
    ),
    Entry(
        "12",
        "Five planes, fracture energy over the direction, σ_N = 0",
        ("figure12",),
        "The energy depends on the direction.",
        f"{ASSUMED_SLIP}; the case file has $\\theta_L$ every 15°, the picture every 5.625°.",
        figure_12,
    ),
    Entry(
        "13a",
        "Zero normal traction, several inclinations",
        ("figure13a_00", "figure13a_45"),
        "The elastic part depends neither on the inclination nor on the direction; the traction and the "
        "energy grow "
        "with the inclination and depend on the direction.",
        f"{ASSUMED_SLIP}; $\\theta_m$ = 0, 15, 30, 45°; the five planes of Table 3.",
        figure_13,
    ),
    Entry(
        "13b",
        "The same without friction",
        ("figure13b_00", "figure13b_45"),
        "The curves differ, the energy is the same for all.",
        f"{ASSUMED_SLIP}; $\\theta_m$ = 0, 15, 30, 45°; the five planes of Table 3.",
        figure_13,
    ),
    Entry(
        "14",
        "RP-3, RP-4, RP-6 in plan",
        (),
        "Truncated pyramids; Table 4 has their weights.",
        "θ = 30°.",
        figure_14,
    ),
    Entry(
        "15",
        "Sensitivity to the direction: RT, RP-3, RP-4",
        ("figure15a", "figure15b", "figure15c"),
        "The curves are coincident for small slip and increasingly different later; more sides make them "
        "overlap and "
        "the polar graph a circle.",
        f"{ASSUMED_SLIP}; $\\theta_L$ every 15°.",
        figure_15,
    ),
    Entry(
        "16",
        "Sensitivity to the direction: RP-6, RP-32",
        ("figure16a", "figure16b"),
        "As Figure 15.",
        f"{ASSUMED_SLIP}; $\\theta_L$ every 15°.",
        figure_16,
    ),
    Entry(
        "Table 5",
        "Largest and smallest fracture energy",
        (),
        "RP-3 spreads less than 5 %, RP-4 less than 0.2 %, “negligible for the vast majority of "
        "applications”; "
        "RP-6 is printed with 1.2 %.",
        "the sampling, see above.",
        table_5,
    ),
)
"""Figures and tables in the order of the paper."""
