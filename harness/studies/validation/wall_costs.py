"""What methods and patterns of the walls cost: tables and pictures of docs/validation/walls.md."""

from __future__ import annotations

import pandas
from asperity.tools.style import COLOURS, TWO, new_figure
from asperity.tools.tables import markdown
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import wall_runs
from .common import DOCS

COSTS, PLANES = (DOCS / "images" / f"validation_walls_{name}.png" for name in ("costs", "planes"))

WALLS = {
    "flat": ("J4D, flat", 4.0),
    "rough": ("J4D, RP-4", 4.0),
    "dry": ("SW30, dry", 9.0),
    "3D": ("J4D in 3D, RP-4", 3.5),
}
"""Walls of the chart, with their last displacement in mm."""

METHODS = {
    "tau 0.05": "tau_v 0.05 mm",
    "tau 0.02": "tau_v 0.02 mm",
    "tau 0.005": "tau_v 0.005 mm",
    "tau 0.002": "tau_v 0.002 mm",
    "tau 0.0005": "tau_v 0.0005 mm",
    "passes": "neither viscosity nor drag",
    "newton": "the same without passes",
    "newton 0.005": "tau_v 0.005 mm without passes",
    "drag 1e-5": "drag 1e-5 N/mm³ without passes",
    "drag 1e-6": "drag 1e-6 N/mm³ without passes",
    "always": "passes in every step, tau_v 0.002 mm",
    **{f"implex {limits}": f"IMPL-EX, errors {limits.replace(' ', ', ')}" for limits in wall_runs.IMPLEX},
}
"""Methods by the second part of the names of their runs."""

SAME = {"flat tau 0.002": "J4D", "rough tau 0.002": "J4D 10 0.1"}
"""Runs that other tables have, too."""

SERIES = {
    "viscosity, passes where Newton stops": ("tau ", "passes"),
    "Newton alone": ("newton",),
    "drag, Newton alone": ("drag",),
    "passes in every step": ("always",),
    "IMPL-EX": ("implex",),
}
"""Methods of each colour of the chart, by the beginnings of their names."""

PATTERNS = {
    "planes 2 0": ("RT", 0.0),
    "J4D 10 0.1": ("RP-4", 0.0),
    "planes 4 45": ("RP-4", 45.0),
    "planes 6 0": ("RP-6", 0.0),
    "planes 6 30": ("RP-6", 30.0),
    "planes 8 0": ("RP-8", 0.0),
    "planes 8 22.5": ("RP-8", 22.5),
    "planes 16 0": ("RP-16", 0.0),
    "planes 16 11.25": ("RP-16", 11.25),
    "planes 64 0": ("RP-64", 0.0),
}
"""Patterns of J4D with planes of 10 degrees and 0.1 mm, and their turns in degrees."""

FINE, LEAST = "planes 64 0", 0.01
"""Pattern with which the others are compared, and the least error in percent that its chart shows."""


def of(summaries: pandas.DataFrame, wall: str, method: str) -> pandas.Series | None:
    """Summary of the run of a wall by a method, if there is one."""
    name = f"{wall} {method}"
    name = SAME.get(name, name)
    return summaries.loc[name] if name in summaries.index else None


def percent(value: float, reference: float) -> float:
    """Error in percent."""
    return 100.0 * (value / reference - 1.0)


def two_digits(value: float) -> str:
    """Number of two digits, without a power of ten."""
    return f"{float(f'{value:.2g}'):g}"


def signed(error: float) -> str:
    """Error with its sign, of one decimal."""
    return f"{round(error, 1) + 0.0:+.1f}"


def left_by_passes(summary: pandas.Series) -> str:
    """Largest error of forces of the steps by passes, and where there are snaps that of their steps."""
    if summary.snaps > 0 and "implex" not in str(summary.name):
        return f"{two_digits(summary.calm)}, snaps {two_digits(summary.e_t)}"
    return two_digits(summary.e_t)


AIMS = {
    "SW30": (9, 606, "dry drag 1e-6", "dry newton"),
    "SW100": (9, 427, "aim SW100", "own SW100"),
    "SW200": (9, 571, "aim SW200", "own SW200"),
    "WS100": (12, 665, "aim WS100", "own WS100"),
    "J6D": (4, 1115, "aim J6D", "J6D"),
    "J7D": (4, 774, "aim J7D", "J7D"),
}
"""Displacement, factorizations of the prototype, and runs with its settings and as the kit does by itself."""


def aims(summaries: pandas.DataFrame) -> str:
    """Table of the factorizations beside those of a prototype."""
    body = []
    for wall, (end, most, *names) in AIMS.items():
        runs = [summaries.loc[name] for name in names]
        if any(summary.end < end for summary in runs):
            raise ValueError(f"{wall}: {', '.join(names)}: expected runs to {end} mm")
        counts = [int(summary.iterations) for summary in runs]
        cells = [f"{count}" if count <= most else f"{count}, **missed**" for count in counts]
        body.append([wall, f"{end}", f"{most}", *cells, f"{runs[1].by_passes:.0f}"])
    head = ["wall", "to, mm", "prototype", "with its settings", "without drag, with passes"]
    return markdown([*head, "steps by passes"], body)


def costs(summaries: pandas.DataFrame) -> str:
    """Table of the costs: factorizations, errors of peak and work, and what the passes left."""
    body = []
    for method, label in METHODS.items():
        cells = []
        for wall, (_, end) in WALLS.items():
            summary, best = (of(summaries, wall, name) for name in (method, "passes"))
            if summary is None:
                cells.append("")
            elif summary.end < end:
                cells.append(f"{summary.iterations:.0f}, stops at {summary.end:.2f} mm")
            else:
                errors = [signed(percent(summary[kind], best[kind])) for kind in ("peak", "work")]
                cases = [left_by_passes(summary)] if summary.by_passes else []
                cells.append("; ".join([f"{summary.iterations:.0f}", *errors, *cases]))
        body.append([label, *cells])
    return markdown(["method", *(label for label, _ in WALLS.values())], body)


def draw_costs() -> Figure:
    """Draw errors of peak and work over the factorizations; crosses are runs that stop."""
    summaries = wall_runs.summaries()
    figure, axes = new_figure(TWO, 4.2, nrows=2, ncols=len(WALLS), sharex=True, sharey=True)
    lines = {}
    for k, (wall, (title, end)) in enumerate(WALLS.items()):
        best = of(summaries, wall, "passes")
        for (label, starts), colour in zip(SERIES.items(), COLOURS, strict=False):
            runs = {method: of(summaries, wall, method) for method in METHODS if method.startswith(starts)}
            runs = {method: summary for method, summary in runs.items() if summary is not None}
            for ax, kind in ((axes[k], "peak"), (axes[k + len(WALLS)], "work")):
                points = [
                    (summary.iterations, percent(summary[kind], best[kind]), method)
                    for method, summary in runs.items()
                    if summary.end >= end
                ]
                if points:
                    x, y, methods = zip(*points, strict=True)
                    (lines[label],) = ax.plot(x, y, "o-", color=colour, linewidth=0.8, markersize=3.5)
                    for at in zip(x, y, methods, strict=True):
                        name(ax, *at, colour)
                for summary in runs.values():
                    if summary.end < end and kind == "peak":
                        error = percent(summary[kind], best[kind])
                        (lines[label],) = ax.plot(summary.iterations, error, "x", color=colour, markersize=5)
        axes[k].set_title(title)
    for ax in axes:
        ax.grid(alpha=0.3)
    axes[0].set_xscale("log")
    axes[0].set_xlim(100.0, 3000.0)
    axes[0].set_xticks([100, 300, 1000, 3000], ["100", "300", "1000", "3000"])
    axes[0].minorticks_off()
    axes[0].set_yscale("symlog", linthresh=1.0)
    axes[0].set_ylim(-4.0, 80.0)
    axes[0].set_yticks([-1, 0, 1, 10], ["-1", "0", "1", "10"])
    for ax in axes[len(WALLS) :]:
        ax.set_xlabel("factorizations")
    axes[0].set_ylabel("error of the peak [%]")
    axes[len(WALLS)].set_ylabel("error of the work [%]")
    shown = {label: lines[label] for label in SERIES if label in lines}
    figure.legend(shown.values(), shown.keys(), loc="outside lower center", ncols=3)
    return figure


def name(ax: Axes, x: float, y: float, method: str, colour: str) -> None:
    """Write the viscosity, or the error of forces, of a point beside it."""
    named = method.startswith(("tau", "implex", "drag"))
    text = method.split()[-1] if named else "0" if method == "passes" else ""
    below = method.startswith("implex")  # its points are near those of a drag
    at = (0.0, -7.5) if below else (2.0, 2.5)
    ax.annotate(text, (x, y), at, textcoords="offset points", fontsize=5.0, color=colour)


def planes(summaries: pandas.DataFrame) -> str:
    """Table of the patterns of J4D."""
    body = []
    for run, (label, turn) in PATTERNS.items():
        summary, fine = summaries.loc[run], summaries.loc[FINE]
        errors = [signed(percent(summary[kind], fine[kind])) for kind in ("peak", "work")]
        cost = [
            f"{summary.iterations:.0f}",
            f"{summary.seconds:.1f}",
            f"{1e3 * summary.law / summary.iterations:.1f}",
        ]
        body.append([label, f"{turn:g}", f"{summary.peak:.1f}", *errors, *cost])
    head = ["pattern", "turn, °", "peak, kN", "error, %", "of the work, %", "factorizations", "seconds"]
    return markdown([*head, "law, ms of one"], body)


def draw_planes() -> Figure:
    """Draw errors of peak and work, without their signs, over the processor time of the patterns."""
    summaries = wall_runs.summaries()
    figure, axes = new_figure(TWO, 2.3, ncols=2, sharey=True)
    fine = summaries.loc[FINE]
    for ax, kind in zip(axes, ("peak", "work"), strict=True):
        for run, (label, turn) in PATTERNS.items():
            if run != FINE:
                summary, turned = summaries.loc[run], turn > 0.0
                at = summary.seconds, max(abs(percent(summary[kind], fine[kind])), LEAST)
                ax.plot(*at, "os"[turned], color=COLOURS[turned])
                place = (4.0, -6.0) if turned else (4.0, 2.0)
                ax.annotate(label, at, place, textcoords="offset points", fontsize=6.0, color=COLOURS[turned])
        ax.set_yscale("log")
        ax.set_yticks([0.01, 0.1, 1, 10], ["0.01", "0.1", "1", "10"])
        ax.set(xlabel="processor time [s]", ylabel=f"error of the {kind} [%]")
        ax.grid(alpha=0.3)
        ax.margins(0.1, 0.12)
    for turned, label in enumerate(("turn 0", "turned by half of an angle")):
        axes[1].plot([], [], "os"[turned], color=COLOURS[turned], label=label)
    axes[1].legend(loc="upper center")
    return figure
