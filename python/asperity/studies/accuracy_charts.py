"""Command `asperity chart accuracy`: work-precision charts and tables of docs/results/accuracy.md."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from tqdm import tqdm

from ..plots import COLOURS, LINES
from ..tables import fill, markdown
from . import accuracy
from .accuracy import Distance, Drift, PlaneError, StepError, TangentRun, pareto, residual_spread
from .gallery_draw import new_figure

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

AIMS = (1.0e-2, 1.0e-3, 1.0e-4)
"""Target errors of the tables."""

STUDIES = ("increments", "planes", "materials", "precision", "tangents")
"""Studies by the names of their markers."""


def add_arguments(chart: argparse.ArgumentParser) -> None:
    """Add the arguments of `asperity chart accuracy`."""
    chart.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path(),
        metavar="DIR",
        help="folder of the pictures (default: here)",
    )
    chart.add_argument("--pdf", action="store_true", help="write vector pictures (PDF) instead of PNG")
    chart.add_argument(
        "--page",
        type=Path,
        metavar="FILE.md",
        help="fill the numbers into a page, between markers such as <!-- accuracy-planes -->",
    )
    chart.add_argument(
        "--only", nargs="+", choices=STUDIES, metavar="STUDY", help=f"studies to run, of {', '.join(STUDIES)}"
    )
    chart.add_argument("--quick", action="store_true", help="very small sizes, for a test of the command")
    chart.set_defaults(action=_action)


def _action(options: argparse.Namespace) -> int:
    options.output.mkdir(parents=True, exist_ok=True)
    page = options.page.read_text(encoding="utf-8") if options.page else None
    if page is not None and "<!-- accuracy-" not in page:
        raise ValueError(f"{options.page}: expected markers such as <!-- accuracy-planes -->")
    bar = tqdm(unit="run", disable=None)
    for name in options.only or STUDIES:
        bar.set_description(name)
        figures, table = MAKE[name](options.quick, bar.update)
        for stem, figure in figures.items():
            path = options.output / f"accuracy_{stem}.{'pdf' if options.pdf else 'png'}"
            figure.savefig(
                path, dpi=130, metadata={"CreationDate": None} if options.pdf else {"Software": None}
            )
            bar.write(str(path))
        if page is None:
            bar.write(f"\n{table}\n")
        else:
            page = fill(page, {f"accuracy-{name}": lambda table=table: table})
    bar.close()
    if page is not None:
        options.page.write_text(page, encoding="utf-8")
    return 0


def _log(ax: Axes, x_label: str, y_label: str) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)
    ax.grid(alpha=0.3, which="major")


def _plain(axis: Axis) -> None:
    """Set the labels 0.2, 0.5, 1, ... on an axis that spans little more than a decade."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def _sigma(value: float) -> str:
    return f"{value:g}".replace("-", "−")


_table = partial(markdown, numbers=True)


# --- increments -------------------------------------------------------------------------------------

QUANTITIES = (("tau_L", r"$\tau_L$"), ("s_N", "$s_N$"), ("work", "work"))


def _increments(quick: bool, tick: accuracy.Tick) -> tuple[dict[str, Figure], str]:
    sizes = (30, 60) if quick else accuracy.INCREMENTS
    tolerances = (1e-2, 1e-3) if quick else accuracy.STEP_TOLERANCES
    errors = list(accuracy.step_errors(sizes, tolerances, 1 if quick else 5, tick))
    fixed = [e for e in errors if e.tolerance == 0.0]
    figure, axes = new_figure(11.0, 6.6, nrows=2, ncols=3, sharex=True)
    for ax, (path, (name, label)) in zip(
        axes, [(path, q) for path in accuracy.PATHS for q in QUANTITIES], strict=True
    ):
        _by_traction(ax, [e for e in fixed if e.path == path], "rows", name)
        _log(ax, "increments of the path", f"relative error of {label}")
        _orders(ax, sizes)
        ax.set_title(path, fontsize="small")
    axes[2].legend(title=r"$\sigma_N$ [MPa]", fontsize="x-small", title_fontsize="x-small")
    against, axes = new_figure(11.0, 6.8, nrows=2, ncols=3, sharex="col")
    for i, path in enumerate(accuracy.PATHS):
        here = [e for e in errors if e.path == path]
        for ax, (x, name, x_label, label) in zip(axes[3 * i : 3 * i + 3], COSTS, strict=True):
            _by_traction(ax, [e for e in here if e.tolerance == 0.0], x, name)
            _by_traction(ax, [e for e in here if e.tolerance > 0.0], x, name, adaptive=True)
            _log(ax, x_label, label)
            ax.set_title(path, fontsize="small")
    handles = [Line2D([], [], color=COLOURS[i], label=_sigma(s)) for i, s in enumerate(accuracy.SIGMA_N)]
    handles += [
        Line2D([], [], color="grey", marker="o", markersize=4, label="fixed"),
        Line2D([], [], color="grey", linestyle="--", marker="^", markerfacecolor="none", label="adaptive"),
    ]
    against.legend(
        handles=handles, title=r"$\sigma_N$ [MPa]", loc="outside lower center", ncols=6, fontsize="small"
    )
    return {"increments": figure, "adaptive": against}, _increment_tables(errors)


COSTS = (
    ("rows", "line", "rows", r"error of $\tau_L$, lines between rows"),
    ("seconds", "line", "time of a curve [s]", r"error of $\tau_L$, lines between rows"),
    ("seconds", "work", "time of a curve [s]", "error of the work"),
)
"""Cost, error and labels of the columns that compare fixed and adaptive increments."""


def _by_traction(ax: Axes, errors: Sequence[StepError], x: str, y: str, adaptive: bool = False) -> None:
    """Draw a line for each normal traction."""
    for i, sigma_N in enumerate(accuracy.SIGMA_N):
        chosen = [e for e in errors if e.sigma_N == sigma_N]
        ax.plot(
            [getattr(e, x) for e in chosen],
            [getattr(e, y) for e in chosen],
            "^--" if adaptive else "o-",
            color=COLOURS[i],
            markersize=4,
            markerfacecolor="none" if adaptive else COLOURS[i],
            linewidth=1.2,
            label=_sigma(sigma_N),
        )


AIMED = (("line", "curve of τ_L", 1.0e-3), ("work", "work", 1.0e-4))
"""Target errors of the table that compares fixed and adaptive increments."""


def _increment_tables(errors: Sequence[StepError]) -> str:
    """Tables: orders and increments of fixed increments; rows and times of fixed and adaptive ones."""
    orders, needs = [], []
    for path in accuracy.PATHS:
        for sigma_N in accuracy.SIGMA_N:
            here = [e for e in errors if (e.path, e.sigma_N) == (path, sigma_N)]
            fixed = [e for e in here if e.tolerance == 0.0]
            cells = [_order(fixed, name) for name, _ in QUANTITIES]
            cells += [_text(_needed(fixed, n, aim), fixed) for n, _ in QUANTITIES for aim in AIMS[1:]]
            orders.append([path, _sigma(sigma_N), *cells])
            cells = []
            for name, _, aim in AIMED:
                for chosen in (fixed, [e for e in here if e.tolerance > 0.0]):
                    found = _needed(chosen, name, aim)
                    cells += [_text(found, chosen), f"{1e3 * found.seconds:.2f}" if found else ""]
            needs.append([path, _sigma(sigma_N), *cells])
    head = ["path", "σ_N [MPa]"]
    names = ("τ_L", "s_N", "work")
    first = [f"order, {q}" for q in names] + [f"{q} to {aim:.0e}" for q in names for aim in AIMS[1:]]
    second = [
        f"{label} to {aim:.0e}, {method}" if unit else "ms"
        for _, label, aim in AIMED
        for method in ("fixed", "adaptive")
        for unit in (True, False)
    ]
    return (
        f"{_table([*head, *first], orders)}\n\nRows and times that an aim needs, fixed increments "
        "(doubled) and "
        f"adaptive ones (tolerance by half decades):\n\n{_table([*head, *second], needs)}"
    )


def _orders(ax: Axes, sizes: Sequence[int]) -> None:
    """Draw slopes of first and second order in the lower left corner, below the curves."""
    low = ax.get_ylim()[0]
    ax.set_ylim(bottom=low / 30.0)
    x = np.array([sizes[0], sizes[min(2, len(sizes) - 1)]], dtype=float)
    for order, style in ((1, ":"), (2, "-.")):
        y = low / 20.0 * (x / x[-1]) ** -order
        ax.plot(x, y, style, color="grey", linewidth=1.0)
        align = "top" if order == 1 else "bottom"
        ax.annotate(f"order {order}", (x[0], y[0]), fontsize="x-small", color="grey", va=align)


def _order(chosen: Sequence[StepError], name: str) -> str:
    """Order of convergence by least squares."""
    x = np.log([e.rows for e in chosen])
    y = np.log([max(getattr(e, name), 1e-300) for e in chosen])
    return f"{-np.polyfit(x, y, 1)[0]:.1f}"


def _needed(chosen: Sequence[StepError], name: str, aim: float) -> StepError | None:
    """Coarsest run such that its error and those of all finer runs are below the target."""
    found = None
    for e in reversed(chosen):
        if not getattr(e, name) <= aim:
            break
        found = e
    return found


def _text(found: StepError | None, tried: Sequence[StepError]) -> str:
    return str(found.rows) if found else f"> {tried[-1].rows}"


# --- planes -----------------------------------------------------------------------------------------

CURVES = (("tau_L", r"$\tau_L$"), ("across", "traction across"), ("s_N", "$s_N$"))


def _planes(quick: bool, tick: accuracy.Tick) -> tuple[dict[str, Figure], str]:
    theta, mu = 30.0, 0.5
    chosen = accuracy.candidates(theta)
    tractions = accuracy.SIGMA_N
    if quick:
        chosen, tractions = [c for c in chosen if c.sides < 6], (0.0, -5.0)
    errors = list(accuracy.plane_errors(chosen, theta, mu, tractions, 1 if quick else 5, tick))
    columns = len(tractions)
    figure, axes = new_figure(3.0 * columns + 0.4, 8.4, nrows=3, ncols=columns, sharey="row", sharex=True)
    grid = axes.reshape(3, columns)
    for i, (name, label) in enumerate(CURVES):
        for ax, sigma_N in zip(grid[i], tractions, strict=True):
            here = [e for e in errors if e.sigma_N == sigma_N]
            _families(ax, here, name)
            last = i == len(CURVES) - 1
            _log(
                ax,
                "time of a curve [ms]" if last else "",
                f"error, {label} [-]" if sigma_N == tractions[0] else "",
            )
            _plain(ax.xaxis)
            if i == 0:
                ax.set_title(rf"$\sigma_N$ = {_sigma(sigma_N)} MPa", fontsize="small")
    figure.legend(handles=_handles(), loc="outside lower center", ncols=6, fontsize="small")
    spread, axes = new_figure(3.0 * columns + 0.4, 6.2, nrows=2, ncols=columns, sharey="row", sharex=True)
    grid = axes.reshape(2, columns)
    for ax, sigma_N in zip(grid[0], tractions, strict=True):
        _families(ax, [e for e in errors if e.sigma_N == sigma_N], "work")
        what = "$G_T$" if sigma_N == 0.0 else "work to 0.6 mm"
        ax.set_title(rf"{what}, $\sigma_N$ = {_sigma(sigma_N)} MPa", fontsize="small")
        _log(ax, "", "spread over directions [-]" if ax is grid[0][0] else "")
    for ax, sigma_N in zip(grid[1], tractions, strict=True):
        here = [e for e in errors if e.sigma_N == sigma_N]
        if sigma_N == 0.0:
            confined = [e for e in errors if e.sigma_N == tractions[1]]
            _families(ax, confined, "residual", lambda e: residual_spread(e.sides, e.theta, e.mu))
            ax.set_title(r"residual strength (closed form), $\sigma_N$ < 0", fontsize="small")
        else:
            _families(ax, here, "loop")
            ax.set_title(rf"loop of a cycle, $\sigma_N$ = {_sigma(sigma_N)} MPa", fontsize="small")
        _log(ax, "time of a curve [ms]", "spread over directions [-]" if ax is grid[1][0] else "")
        _plain(ax.xaxis)
    spread.legend(handles=_handles(), loc="outside lower center", ncols=6, fontsize="small")
    return {"planes": figure, "spread": spread}, _plane_tables(errors, tractions)


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
    """Draw markers by family over the time of a curve, the Pareto front, and the number of sides along it."""
    of = value or (lambda e: getattr(e, name))
    regular = value is not None
    for family, (shade, marker, filled) in STYLE.items():
        here = [e for e in errors if e.family == family and not (regular and family.startswith("rings"))]
        ax.plot(
            [1e3 * e.seconds for e in here],
            [of(e) for e in here],
            marker,
            color=shade,
            markersize=4.5,
            markerfacecolor=shade if filled else "none",
        )
    usable = [e for e in errors if not (regular and e.family.startswith("rings"))]
    front = pareto((1e3 * e.seconds, of(e)) for e in usable)
    ax.plot(*zip(*front, strict=True), color="black", linewidth=0.8, zorder=0)
    for e in usable:
        at = (1e3 * e.seconds, of(e))
        if e.sides in (3, 4, 6, 7, 16, 32) and e.family in ("even", "odd") and np.isfinite(at[1]):
            ax.annotate(
                str(e.sides),
                at,
                textcoords="offset points",
                xytext=(4, 3),
                fontsize="xx-small",
                color="black",
            )


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
                numbers = [_percent(getattr(e, name)) for name in _measures(sigma_N)]
                shown.append(_filled([_sigma(sigma_N), str(e.sides), *numbers], len(names) + 2))
        for aim in AIMS[:2]:
            cells = [_fewest(here, [e for e in here if getattr(e, n) <= aim]) for n in _measures(sigma_N)]
            needs.append(_filled([_sigma(sigma_N), f"{100 * aim:g} %", *cells], len(names) + 2))
        odd = [
            m for m in (5, 7, 9, 11) if {(m - 1, sigma_N), (m, sigma_N), (m + 1, sigma_N)} <= regular.keys()
        ]
        for m in odd:
            gains.append(
                [_sigma(sigma_N), str(m), *(_gain(regular, m, sigma_N, n) for n in _measures(sigma_N))]
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
                rings.append(_filled([_sigma(sigma_N), family[6:], *cells], len(names) + 2))
    for aim in AIMS[:2]:
        enough = next(m for m in range(3, 1000) if residual_spread(m, 30.0, 0.5) <= aim)
        needs.append(_filled(["< 0, residual strength", f"{100 * aim:g} %", str(enough)], len(names) + 2))
    head = ["σ_N [MPa]"]
    parts = ["Errors of RP-m, %:", _table([*head, "m", *names], shown)]
    parts += ["Fewest sides m that meet an aim:", _table([*head, "aim", *names], needs)]
    if gains:
        parts += [
            "What odd m gains: geometric mean of the errors of RP-(m−1) and RP-(m+1) over that of RP-m. 1: "
            "nothing.",
            _table([*head, "m", *names], [_filled(row, len(names) + 2) for row in gains]),
        ]
    parts += [
        "Errors of two staggered rings over those of RP-2m, which has as many planes: geometric mean over "
        "m (smallest).",
        _table([*head, "30°", *names], rings),
    ]
    return "\n\n".join(parts)


def _gain(regular: Mapping[tuple[int, float], PlaneError], m: int, sigma_N: float, name: str) -> str:
    before, here, after = (getattr(regular[k, sigma_N], name) for k in (m - 1, m, m + 1))
    return f"{np.sqrt(before * after) / here:.2g}"


def _percent(value: float) -> str:
    return f"{100.0 * value:.2g}"


def _filled(row: Sequence[str], length: int) -> list[str]:
    """Extend a row by empty cells."""
    return [*row, *[""] * (length - len(row))]


def _materials(quick: bool, tick: accuracy.Tick) -> tuple[dict[str, Figure], str]:
    pairs = MATERIALS[:1] if quick else MATERIALS
    frictions = list(dict.fromkeys(mu for _, mu in pairs))
    figure, axes = new_figure(
        3.6 * len(frictions) + 0.6, 6.6, nrows=2, ncols=len(frictions), sharex=True, sharey="row"
    )
    grid = axes.reshape(2, len(frictions))
    rows = []
    sides = (3, 4, 5) if quick else (3, 4, 5, 6, 7, 8, 9, 10, 12, 16, 24, 32, 48)
    for theta, mu in pairs:
        chosen = [accuracy.regular(m, theta) for m in sides]
        errors = list(accuracy.plane_errors(chosen, theta, mu, (MATERIALS_SIGMA_N,), 1 if quick else 3, tick))
        column = frictions.index(mu)
        i = sorted({t for t, _ in pairs}).index(theta)
        for ax, name in zip(grid[:, column], ("tau_L", "loop"), strict=True):
            for odd in (False, True):
                here = [e for e in errors if (e.sides % 2 == 1) == odd]
                ax.plot(
                    [1e3 * e.seconds for e in here],
                    [getattr(e, name) for e in here],
                    ("s" if odd else "o") + LINES[i],
                    color=COLOURS[i],
                    markersize=4.5,
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
        grid[0, column].set_title(
            rf"$\mu$ = {mu:g}, $\sigma_N$ = {_sigma(MATERIALS_SIGMA_N)} MPa", fontsize="small"
        )
        first = column == 0
        _log(grid[0, column], "", r"error, $\tau_L$ [-]" if first else "")
        _log(grid[1, column], "time of a curve [ms]", "spread of the loops [-]" if first else "")
        _plain(grid[1, column].xaxis)
    handles, texts = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside lower center", ncols=6, fontsize="small")
    head = [
        "µ",
        "θ",
        *(f"{q}, {100 * aim:g} %" for q in ("τ_L", "across", "s_N", "loops") for aim in AIMS[:2]),
    ]
    return {"materials": figure}, _table(head, rows)


# --- precision --------------------------------------------------------------------------------------


def _precision(quick: bool, tick: accuracy.Tick) -> tuple[dict[str, Figure], str]:
    if quick:
        drifts = list(accuracy.drifts(20000, 2000, tick=tick))
        slides = list(accuracy.distances(500, 5.0, tick=tick))
    else:
        drifts = list(accuracy.drifts(tick=tick))
        slides = list(accuracy.distances(tick=tick))
    figure, axes = new_figure(11.6, 4.4, ncols=3)
    shades = dict(zip([*accuracy.WAYS.values(), accuracy.CARRIED], COLOURS, strict=False))
    for ax, name, label in (
        (axes[0], "traction", "error of the traction [-]"),
        (axes[1], "work", "error of the work [-]"),
    ):
        for d in drifts:
            ax.plot(
                d.increments, getattr(d, name), LINES[d.pattern == "flat"], color=shades[d.way], linewidth=1.4
            )
        _log(ax, "increments [-]", label)
    axes[0].set_title("cycles of ±0.4 mm", fontsize="small")
    axes[1].set_title("cycles of ±0.4 mm", fontsize="small")
    for d in slides:
        axes[2].plot(d.slip, d.traction, color=shades[d.way], linewidth=1.4)
    _log(axes[2], "slip [mm]", "error of the traction [-]")
    axes[2].set_title("slide up a plane of RP-4, 1e5 increments" if not quick else "slide", fontsize="small")
    handles = [Line2D([], [], color=shade, label=way) for way, shade in shades.items()]
    handles += [
        Line2D([], [], color="grey", label="RP-4"),
        Line2D([], [], color="grey", linestyle="--", label="flat"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize="small")
    return {"precision": figure}, _precision_table(drifts, slides)


def _precision_table(drifts: Sequence[Drift], slides: Sequence[Distance]) -> str:
    rows = [
        [
            d.pattern,
            d.way,
            f"{d.increments[-1]:.0e}",
            f"{d.traction[-1]:.1e}",
            f"{d.friction[-1]:.1e}",
            f"{d.work[-1]:.1e}",
        ]
        for d in drifts
    ]
    first = _table(["pattern", "separation of the law", "increments", "traction", "friction", "work"], rows)
    ends = [10.0, 100.0, slides[0].slip[-1]]
    rows = []
    for d in slides:
        cells = [
            f"{d.traction[np.searchsorted(d.slip, end * (1 - 1e-9))]:.1e}"
            for end in ends
            if end <= d.slip[-1]
        ]
        rows.append([d.way, *cells])
    head = ["separation of the law", *(f"{end:g} mm" for end in ends if end <= slides[0].slip[-1])]
    second = _table(head, rows)
    return f"Relative errors after the cycles:\n\n{first}\n\nof the traction, after a slide:\n\n{second}"


# --- tangents ---------------------------------------------------------------------------------------

TANGENT_SIGMA_N = -5.0
"""Normal traction of the pictures of tangents, MPa."""

STRICT = 1.0e-10
"""Tolerance on the residual in the tables of tangents."""


def _tangents(quick: bool, tick: accuracy.Tick) -> tuple[dict[str, Figure], str]:
    n = 10 if quick else accuracy.TANGENT_INCREMENTS
    tolerances = (1e-2, STRICT) if quick else accuracy.TOLERANCES
    sizes = (5, 10) if quick else (15, 30, 60, 120, 240, 480, 960)
    repeats = 1 if quick else 20

    def run(tangent: str, sigma_N: float, increments: int, tolerance: float) -> TangentRun:
        found = accuracy.tangent_run(tangent, sigma_N, increments, tolerance, repeats)
        tick()
        return found

    figure, axes = new_figure(11.6, 4.4, ncols=3)
    for i, tangent in enumerate(accuracy.TANGENTS):
        style = {"color": COLOURS[i], "markersize": 3.5, "linewidth": 1.2, "label": tangent}
        marker = "osD^vx"[i] + LINES[i % len(LINES)]
        strict = run(tangent, TANGENT_SIGMA_N, n, STRICT)
        axes[0].semilogy(strict.residuals[:40], marker, **style)
        by_size = [run(tangent, TANGENT_SIGMA_N, size, STRICT) for size in sizes]
        whole = [r for r in by_size if r.end == "converged"]
        axes[1].plot([r.increments for r in whole], [r.mean for r in whole], marker, **style)
        by_tolerance = [run(tangent, TANGENT_SIGMA_N, n, tolerance) for tolerance in tolerances]
        whole = [r for r in by_tolerance if r.end == "converged"]
        axes[2].plot([1e3 * r.seconds for r in whole], [r.tolerance for r in whole], marker, **style)
    axes[0].set_xlabel("iteration of the increment in the middle")
    axes[0].set_ylabel("residual [-]")
    axes[0].set_ylim(1e-14, 0.1)
    axes[0].grid(alpha=0.3)
    _log(axes[1], "increments of the path", "iterations of an increment")
    _plain(axes[1].yaxis)
    _log(axes[2], "time of the path [ms]", "residual accepted [-]")
    _plain(axes[2].xaxis)
    handles, texts = axes[0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside lower center", ncols=6, fontsize="small")
    rows = []
    for sigma_N in (-1.0, -5.0, -10.0):
        runs = [run(tangent, sigma_N, n, STRICT) for tangent in accuracy.TANGENTS]
        for r in runs:
            numbers = [f"{r.mean:.1f}", str(r.most), str(r.updates), f"{1e3 * r.seconds:.2f}"]
            numbers += [f"{r.seconds / runs[0].seconds:.1f}", r.end]
            rows.append([r.tangent, _sigma(sigma_N), *numbers])
    head = ["tangent", "σ_N [MPa]", "iterations, mean", "most", "updates", "ms", "ratio of times", "end"]
    return {"tangents": figure}, _table(head, rows)


MAKE: dict[str, Callable[[bool, accuracy.Tick], tuple[dict[str, Figure], str]]] = {
    "increments": _increments,
    "planes": _planes,
    "materials": _materials,
    "precision": _precision,
    "tangents": _tangents,
}
"""Studies: pictures by their names, and the table."""
