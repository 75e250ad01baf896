"""Figures 1, 3, 6 and 14 of the paper: the patterns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..pattern import Pattern, unit_vector
from ..pattern_pictures import plan, space
from ..style import COLOURS, ONE, TWO, new_figure
from .fracture_energy import PATTERNS, pattern
from .outcome import FIVE, Outcome, listed, pattern_csv, small

Plane = tuple[float, float, float]


def _same_planes(ours: Pattern, table: Sequence[Plane], theta: float) -> float:
    """Largest difference of the normals of a pattern and those of a table, in any order of the planes."""
    c, s = np.cos(np.radians(theta)), np.sin(np.radians(theta))
    wanted = np.array([(1.0, 0.0, 0.0) if not (x or y) else (c, s * x, s * y) for _, x, y in table])
    distance = np.abs(ours.normals[:, None] - wanted[None]).max(axis=2)
    return float(max(distance.min(axis=0).max(), distance.min(axis=1).max()))


def _in_space(
    shown: Pattern, name: str, title: str, table: str, normals: Sequence[Plane], text: str
) -> Outcome:
    """Pattern of 30 degrees in space, compared with the normals of a table of the paper."""
    figure, (ax,) = new_figure(ONE, 2.5, subplot_kw={"projection": "3d"})
    space(ax, shown, title)
    difference = small(_same_planes(shown, normals, 30.0))
    return Outcome(
        figure,
        (f"The normals are those of {table}; the difference is {difference}. {text}",),
        *pattern_csv([(name, shown)]),
    )


def figure_1() -> Outcome:
    """Five planes in space."""
    text = (
        f"All planes have the weight {FIVE.weights[0]:g}. The pattern is `Pattern.regular(4, 30, flat=0.2)`."
    )
    normals = [(1, 0, 0), (1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1)]
    return _in_space(FIVE, "five planes", "five planes, 30°", "Table 3", normals, text)


def figure_3() -> Outcome:
    """Trapezoid in space."""
    trapezoid = pattern("RT")
    weight = f"{trapezoid.weights[0]:.4f}"
    text = f"All planes have the weight {weight}. The pattern is `Pattern.regular(2, 30)`."
    normals = [(1, 0, 0), (1, 1, 0), (1, -1, 0)]
    return _in_space(trapezoid, "RT", "trapezoid, RT, 30°", "Table 1", normals, text)


def figure_6() -> Outcome:
    """Five planes in plan with the direction of slip."""
    figure, (ax,) = new_figure(0.8 * ONE, 2.6)
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
    lines = pattern_csv([("five planes", FIVE)])
    return Outcome(figure, ("The angle is measured from $T_x$ towards $T_y$.",), *lines)


def figure_14() -> Outcome:
    """Patterns in plan."""
    figure, axes = new_figure(TWO, 2.5, ncols=3)
    for ax, name in zip(axes, ("RP-3", "RP-4", "RP-6"), strict=True):
        plan(ax, pattern(name), name)
    weights = {name: f"{pattern(name).weights[-1]:.5f}" for name in PATTERNS}
    table_4 = dict(zip(PATTERNS, ("0.33333", "0.22222", "0.16667", "0.11111", "0.02083"), strict=True))
    verdict = "Table 4 has the same" if weights == table_4 else "Table 4 has others"
    return Outcome(
        figure,
        (
            f"The weights of an inclined plane are {listed([f'{w} ({n})' for n, w in weights.items()])}; "
            f"{verdict}.",
            "The areas in the plan views are proportional to the weights.",
        ),
        *pattern_csv([(name, pattern(name)) for name in PATTERNS]),
    )
