"""Chart and table of the benchmark: error of the patterns against the time per point."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np
from asperity.interface import Interface
from asperity.pattern import Pattern
from asperity.slip_curves import slip_curves
from asperity.style import COLOURS, TWO, new_figure, printed, save
from asperity.tables import markdown
from matplotlib.axes import Axes

from .accuracy import (
    DIRECTIONS,
    FLAT,
    PLANE_INCREMENTS,
    PRELOAD,
    REFERENCE_SIDES,
    THETA,
    log_axes,
    material,
    monotonic,
    relative_error,
)
from .program import run
from .timings import Timing, measure, read_timings

SIDES = {"RT": 2, "RP-3": 3, "RP-4": 4, "RP-6": 6, "RP-8": 8, "RP-16": 16, "RP-32": 32}
"""Inclined planes of the patterns of the chart."""

FACETS = {"": ("", 0.0), ", height": (" H", 0.3)}
"""Texts of the legend, ends of the names of the patterns in the benchmark, and heights in mm."""

SIGMA_N = -5.0
"""Normal traction, MPa."""

RUNS = 21
"""Runs of the benchmark with each kind of kernels; the medians count."""

KINDS = {1: "portable", 3: "AVX2", 0: "one set of kernels"}
"""Names of the kinds of kernels."""


def draw_speed(timings: Sequence[Timing], path: Path) -> None:
    """Draw the error against the time per point into a file that ends in .png or .pdf."""
    times = _medians(timings)
    errors = {name: pattern_errors(height) for name, (_, height) in FACETS.items()}
    with printed():
        figure, axes = new_figure(TWO, 3.2, ncols=2, sharey=True, sharex=True)
        for ax, tangent, title in zip(
            axes, (True, False), ("stress and tangent", "stress only"), strict=True
        ):
            for isa in sorted({t.isa for t in timings}):
                for precision in ("double", "single"):
                    for name, (end, _) in FACETS.items():
                        _curve(ax, times, errors[name], (isa, precision, tangent), name, end)
            log_axes(ax, "time per point [ns]", r"relative error of $\tau_L$" if tangent else "")
            ax.set_title(title)
            ax.margins(x=0.15)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
        save(figure, path)


def pattern_errors(height: float) -> dict[str, float]:
    """Errors of the patterns in tau_L against RP-64: L2 norm over a monotonic path, the worst direction."""
    law, slips = replace(material(), height=height), monotonic(PLANE_INCREMENTS["monotonic"])
    dense = Interface(law, Pattern.regular(REFERENCE_SIDES, THETA, FLAT))
    reference = slip_curves(dense, 0.0, slips, SIGMA_N, PRELOAD).tau_L[0]
    errors = {}
    for name, sides in SIDES.items():
        angles = np.linspace(0.0, 180.0 / sides, DIRECTIONS)
        pattern = Interface(law, Pattern.regular(sides, THETA, FLAT))
        errors[name] = relative_error(
            slip_curves(pattern, angles, slips, SIGMA_N, PRELOAD).tau_L - reference, reference
        )
    return errors


def _medians(timings: Sequence[Timing]) -> dict[tuple[int, str, bool, str], float]:
    """Median times of the blocks by level, precision, tangent and pattern."""
    rows: dict[tuple[int, str, bool, str], list[float]] = {}
    for t in timings:
        if (t.kernel, t.states) == ("block", "slip"):
            rows.setdefault((t.isa, t.precision, t.tangent, t.pattern), []).append(t.ns_per_point)
    return {key: median(values) for key, values in rows.items()}


def _curve(
    ax: Axes,
    times: dict[tuple[int, str, bool, str], float],
    errors: dict[str, float],
    kernel: tuple[int, str, bool],
    name: str,
    end: str,
) -> None:
    """Draw the curve of one kernel; the names of the patterns stand at that of AVX2 in single precision."""
    isa, precision, _ = kernel
    points = [(times[key], error, p) for p, error in errors.items() if (key := (*kernel, p + end)) in times]
    if not points:
        return
    x, y, patterns = zip(*points, strict=True)
    colour = COLOURS[{1: 1, 3: 0, 0: 3}[isa]]
    ax.plot(
        x,
        y,
        ("o" if precision == "double" else "s") + ("-" if end == "" else ":"),
        color=colour,
        markersize=3.5,
        linewidth=1.0,
        markerfacecolor=colour if precision == "double" else "white",
        label=f"{KINDS[isa]}, {precision}{name}",
    )
    if (precision, end) == ("single", "") and isa != 1:
        for at, error, pattern in zip(x, y, patterns, strict=True):
            ax.annotate(
                pattern, (at, error), (-4, -2), textcoords="offset points", ha="right", va="top", fontsize=6
            )


COLUMNS = (
    ("textbook", "textbook", "double", True),
    ("point", "point", "double", True),
    ("UMAT", "umat", "double", True),
    ("block, tangent", "block", "double", True),
    ("block, stress", "block", "double", False),
    ("roots", "roots", "double", False),
    ("VUMAT", "vumat", "double", False),
    ("streaming", "stream", "double", False),
    ("block, single", "block", "single", False),
    ("roots, single", "roots", "single", False),
    ("test", "test", "double", True),
)
"""Title, kernel, precision and tangent of the columns of the table."""


def table(timings: Sequence[Timing]) -> str:
    """Nanoseconds per point as a table in Markdown, a row per pattern and kind of kernels."""
    rows = []
    for pattern, planes, isa in dict.fromkeys(
        (t.pattern, t.planes, t.isa) for t in timings if t.states == "slip"
    ):
        cells = [pattern, str(planes), KINDS[isa]]
        for _, kernel, precision, tangent in COLUMNS:
            chosen = _rows(timings, kernel, precision, tangent)
            times = [t.ns_per_point for t in chosen if (t.pattern, t.isa) == (pattern, isa)]
            cells.append(f"{median(times):.1f}" if times else "")
        rows.append(cells)
    return markdown(["pattern", "planes", "kernels", *(column[0] for column in COLUMNS)], rows, numbers=True)


def _rows(timings: Sequence[Timing], kernel: str, precision: str, tangent: bool) -> Iterator[Timing]:
    """Rows of a kernel whose points all slip."""
    wanted = (kernel, precision, tangent, "slip")
    return (t for t in timings if (t.kernel, t.precision, t.tangent, t.states) == wanted)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the program."""
    parser.add_argument(
        "csv",
        nargs="*",
        type=Path,
        metavar="BENCH.csv",
        help=f"written by bench --csv, with any kernels (default: run it {RUNS} times with each)",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("speed.png"),
        metavar="FILE",
        help="picture, .png or .pdf (default: %(default)s)",
    )
    parser.add_argument("--quick", action="store_true", help="short runs with rough results")
    parser.add_argument("--table", action="store_true", help="also print a table in Markdown")
    parser.set_defaults(action=_speed)


def _speed(options: argparse.Namespace) -> int:
    """Read CSVs of the benchmark, or run the benchmark, then draw."""
    if options.csv and options.quick:
        raise ValueError(f"--quick: expected without {options.csv[0]}, which is not run again")
    if options.csv:
        timings = [row for path in options.csv for row in read_timings(path)]
    else:
        quick = ["--quick"] if options.quick else []
        timings = [row for _ in range(RUNS) for level in ("v1", "v3") for row in measure(*quick, level=level)]
    draw_speed(timings, options.output)
    if options.table:
        print(table(timings))
    print(options.output)
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program."""
    return run(add_arguments, arguments)


if __name__ == "__main__":
    sys.exit(main())
