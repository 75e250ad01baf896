"""Pictures and tables of the error against the number of planes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from asperity.style import COLOURS, LINES, TWO, new_figure
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..tables import percent
from .chart_axes import AIMS, log_axes, signed, table
from .common import (
    SIGMA_N,
    Tick,
)
from .planes import PlaneError, candidates, pareto, plane_errors, regular, residual_spread

STYLE = {
    "even": (COLOURS[0], "o", True),
    "odd": (COLOURS[1], "s", False),
    "rings ±2.5°": (COLOURS[2], "^", False),
    "rings ±5°": (COLOURS[5], "v", False),
}
"""Colour, marker and whether the marker is filled, by family of patterns."""


MATERIALS = [(theta, mu) for mu in (0.25, 0.5, 0.75) for theta in (15.0, 30.0, 45.0)]
"""Pairs of inclination, degrees, and friction of the chart of materials."""

MATERIALS_SIGMA_N = -5.0
"""Normal traction of the chart of materials, MPa."""


CURVES = (("tau_L", r"$\tau_L$"), ("across", "traction across"), ("s_N", "$s_N$"))


def draw_planes(quick: bool, tick: Tick) -> tuple[dict[str, Figure], str]:
    """Run the study of planes; return its pictures by name and its tables."""
    theta, mu = 30.0, 0.5
    chosen = candidates(theta)
    tractions = SIGMA_N
    if quick:
        chosen, tractions = [c for c in chosen if c.sides < 6], (0.0, -5.0)
    errors = list(plane_errors(chosen, theta, mu, tractions, 1 if quick else 5, tick))
    columns = len(tractions)
    figure, axes = new_figure(TWO, 5.6, nrows=3, ncols=columns, sharey="row", sharex=True)
    grid = axes.reshape(3, columns)
    for i, (name, label) in enumerate(CURVES):
        for ax, sigma_N in zip(grid[i], tractions, strict=True):
            _families(ax, [e for e in errors if e.sigma_N == sigma_N], name)
            _plane_axes(ax, f"error, {label} [-]" if sigma_N == tractions[0] else "", i == len(CURVES) - 1)
            if i == 0:
                ax.set_title(rf"$\sigma_N$ = {signed(sigma_N)} MPa")
    figure.legend(handles=_handles(), loc="outside lower center", ncols=6)
    spread, axes = new_figure(TWO, 4.4, nrows=2, ncols=columns, sharey="row", sharex=True)
    grid = axes.reshape(2, columns)
    y_label = "spread over directions [-]"
    for ax, sigma_N in zip(grid[0], tractions, strict=True):
        _families(ax, [e for e in errors if e.sigma_N == sigma_N], "work")
        what = "$G_T$" if sigma_N == 0.0 else "work to 0.6 mm"
        ax.set_title(rf"{what}, {signed(sigma_N)} MPa")
        _plane_axes(ax, y_label if ax is grid[0][0] else "", last=False)
    for ax, sigma_N in zip(grid[1], tractions, strict=True):
        if sigma_N == 0.0:
            confined = [e for e in errors if e.sigma_N == tractions[1]]
            _families(ax, confined, "residual", lambda e: residual_spread(e.sides, e.theta, e.mu))
            ax.set_title("residual strength")
        else:
            _families(ax, [e for e in errors if e.sigma_N == sigma_N], "loop")
            ax.set_title(rf"loop, {signed(sigma_N)} MPa")
        _plane_axes(ax, y_label if ax is grid[1][0] else "", last=True)
    spread.legend(handles=_handles(), loc="outside lower center", ncols=6)
    return {"planes": figure, "spread": spread}, _plane_tables(errors, tractions)


PLANE_TICKS = (4, 8, 16, 32, 64)
"""Numbers of planes with a label; the axis is logarithmic."""


def _plane_axes(ax: Axes, y_label: str, last: bool) -> None:
    """Set logarithmic axes with the number of planes, which determines the time of a curve."""
    log_axes(ax, "number of planes" if last else "", y_label)
    ax.set_xticks(PLANE_TICKS, [str(n) for n in PLANE_TICKS])
    ax.set_xticks([], minor=True)


def _handles() -> list[Line2D]:
    return [
        *(
            Line2D(
                [], [], color=c, marker=m, linestyle="", markerfacecolor=c if filled else "none", label=family
            )
            for family, (c, m, filled) in STYLE.items()
        ),
        Line2D([], [], color="black", linewidth=0.8, label="Pareto front"),
    ]


def _families(
    ax: Axes,
    errors: Sequence[PlaneError],
    name: str,
    value: Callable[[PlaneError], float] | None = None,
) -> None:
    """Draw markers by family over the number of planes, and the Pareto front."""
    of = value or (lambda e: getattr(e, name))
    usable = [e for e in errors if value is None or not e.family.startswith("rings")]
    for family, (shade, marker, filled) in STYLE.items():
        here = [e for e in usable if e.family == family]
        ax.plot(
            [e.planes for e in here],
            [of(e) for e in here],
            marker,
            color=shade,
            markersize=3.5,
            markerfacecolor=shade if filled else "none",
            markeredgewidth=0.8,
        )
    front = pareto((e.planes, of(e)) for e in usable)
    ax.plot(*zip(*front, strict=True), color="black", linewidth=0.8, zorder=0)


def _fewest(tried: Sequence[PlaneError], good: Sequence[PlaneError]) -> str:
    """Smallest number of sides that meets the target."""
    return str(min(e.sides for e in good)) if good else f"> {max(e.sides for e in tried)}"


MEASURES = (
    ("tau_L", "τ_L"),
    ("across", "across"),
    ("s_N", "s_N"),
    ("work", "spread of work"),
    ("loop", "spread of loops"),
)
"""Fields of a PlaneError and their names in the tables."""

SHOWN = (3, 4, 5, 6, 7, 8, 12, 16, 32)
"""Sides of the table of errors."""


def _measures(sigma_N: float) -> list[str]:
    """Fields with a value at a normal traction; at 0 a cycle has no loop."""
    return [name for name, _ in MEASURES if not (name == "loop" and sigma_N == 0.0)]


def _plane_tables(errors: Sequence[PlaneError], tractions: Sequence[float]) -> str:
    """Tables: errors, sides needed for each target, gain of odd numbers of sides, errors of two rings."""
    regular = {(e.sides, e.sigma_N): e for e in errors if e.family in ("even", "odd")}
    names = [label for _, label in MEASURES]
    shown, needs, gains, rings = [], [], [], []
    for sigma_N in tractions:
        here = [e for (_, s), e in sorted(regular.items()) if s == sigma_N]
        for e in here:
            if e.sides in SHOWN:
                numbers = [percent(getattr(e, name)) for name in _measures(sigma_N)]
                shown.append(_filled([signed(sigma_N), str(e.sides), *numbers], len(names) + 2))
        for aim in AIMS[:2]:
            cells = [_fewest(here, [e for e in here if getattr(e, n) <= aim]) for n in _measures(sigma_N)]
            needs.append(_filled([signed(sigma_N), f"{100 * aim:g} %", *cells], len(names) + 2))
        odd = [
            m for m in (5, 7, 9, 11) if {(m - 1, sigma_N), (m, sigma_N), (m + 1, sigma_N)} <= regular.keys()
        ]
        for m in odd:
            gains.append(
                [signed(sigma_N), str(m), *(_gain(regular, m, sigma_N, n) for n in _measures(sigma_N))]
            )
        for family in (f for f in STYLE if f.startswith("rings")):
            cells = []
            for name in _measures(sigma_N):
                ratios = [
                    getattr(e, name) / getattr(regular[2 * e.sides, sigma_N], name)
                    for e in errors
                    if (e.family, e.sigma_N) == (family, sigma_N) and (2 * e.sides, sigma_N) in regular
                ]
                if ratios:
                    cells.append(f"{np.exp(np.mean(np.log(ratios))):.2g} ({min(ratios):.2g})")
            if cells:
                rings.append(_filled([signed(sigma_N), family[6:], *cells], len(names) + 2))
    for aim in AIMS[:2]:
        enough = next(m for m in range(3, 1000) if residual_spread(m, 30.0, 0.5) <= aim)
        needs.append(_filled(["< 0, residual strength", f"{100 * aim:g} %", str(enough)], len(names) + 2))
    head = ["σ_N [MPa]"]
    parts = ["Errors of RP-m, %:", table([*head, "m", *names], shown)]
    parts += ["Fewest sides m that meet an aim:", table([*head, "aim", *names], needs)]
    if gains:
        parts += [
            "What odd m gains: geometric mean of the errors of RP-(m−1) and RP-(m+1) over that of RP-m. 1: "
            "nothing.",
            table([*head, "m", *names], [_filled(row, len(names) + 2) for row in gains]),
        ]
    parts += [
        "Errors of two staggered rings over those of RP-2m, which has as many planes: geometric mean over "
        "m (smallest).",
        table([*head, "30°", *names], rings),
    ]
    return "\n\n".join(parts)


def _gain(regular: Mapping[tuple[int, float], PlaneError], m: int, sigma_N: float, name: str) -> str:
    before, here, after = (getattr(regular[k, sigma_N], name) for k in (m - 1, m, m + 1))
    return f"{np.sqrt(before * after) / here:.2g}"


def _filled(row: Sequence[str], length: int) -> list[str]:
    """Extend a row by empty cells."""
    return [*row, *[""] * (length - len(row))]


def draw_materials(quick: bool, tick: Tick) -> tuple[dict[str, Figure], str]:
    """Run the study of inclinations and frictions; return its picture by name and its table."""
    pairs = MATERIALS[:1] if quick else MATERIALS
    frictions = list(dict.fromkeys(mu for _, mu in pairs))
    figure, axes = new_figure(TWO, 4.6, nrows=2, ncols=len(frictions), sharex=True, sharey="row")
    grid = axes.reshape(2, len(frictions))
    rows = []
    sides = (3, 4, 5) if quick else (3, 4, 5, 6, 7, 8, 9, 10, 12, 16, 24, 32, 48)
    for theta, mu in pairs:
        chosen = [regular(m, theta) for m in sides]
        errors = list(plane_errors(chosen, theta, mu, (MATERIALS_SIGMA_N,), 1 if quick else 3, tick))
        column = frictions.index(mu)
        i = sorted({t for t, _ in pairs}).index(theta)
        for ax, name in zip(grid[:, column], ("tau_L", "loop"), strict=True):
            for odd in (False, True):
                here = [e for e in errors if (e.sides % 2 == 1) == odd]
                ax.plot(
                    [e.planes for e in here],
                    [getattr(e, name) for e in here],
                    ("s" if odd else "o") + LINES[i],
                    color=COLOURS[i],
                    markersize=3.5,
                    markerfacecolor="none" if odd else COLOURS[i],
                    linewidth=1.0 if not odd else 0.0,
                    label=f"{theta:g}°, {'odd' if odd else 'even'}",
                )
        cells = []
        for name in ("tau_L", "across", "s_N", "loop"):
            for aim in AIMS[:2]:
                good = [e for e in errors if getattr(e, name) <= aim]
                cells.append(_fewest(errors, good))
        rows.append([f"{mu:g}", f"{theta:g}°", *cells])
    for column, mu in enumerate(frictions):
        grid[0, column].set_title(rf"$\mu$ = {mu:g}, $\sigma_N$ = {signed(MATERIALS_SIGMA_N)} MPa")
        first = column == 0
        _plane_axes(grid[0, column], r"error, $\tau_L$ [-]" if first else "", last=False)
        _plane_axes(grid[1, column], "spread of the loops [-]" if first else "", last=True)
    handles, texts = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside lower center", ncols=6)
    head = [
        "µ",
        "θ",
        *(f"{q}, {100 * aim:g} %" for q in ("τ_L", "across", "s_N", "loops") for aim in AIMS[:2]),
    ]
    return {"materials": figure}, table(head, rows)
