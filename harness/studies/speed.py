"""Timings and chart of the benchmark: error of the patterns against the time per point."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path

import pandas
from asperity.tools.style import COLOURS, TWO, new_figure, printed, save
from matplotlib.axes import Axes

from harness.studies.paper.fracture_energy import MATERIAL

from .accuracy import log_axes, plane_errors
from .program import program

BUILDS = [Path(__file__).parents[2] / "build" / name / "bin" / "bench" for name in ("release", "suites")]
BENCH = next((path for path in BUILDS if path.exists()), BUILDS[0])
"""The benchmark, built by `make build` or with the Python package."""

COLUMNS = {
    "pattern": str, "planes": int, "kernel": str, "precision": str, "tangent": bool,
    "ns_per_point": float, "isa": int,
}  # fmt: skip
"""Columns of the benchmark, a row for a kernel on a pattern.

isa: level of x86-64 of the kernels, 3 or 1; 0: the library has one set of kernels.
"""


def read_timings(path: Path) -> pandas.DataFrame:
    """Rows of a CSV of the benchmark; raises ValueError for another file."""
    try:
        timings = pandas.read_csv(
            path,
            usecols=[*COLUMNS],
            dtype=COLUMNS,
            true_values=["yes"],
            false_values=["no"],
            skipinitialspace=True,
        )
        if timings.empty:
            raise ValueError("no rows")
    except ValueError as error:
        raise ValueError(f"{path}: expected a CSV written by bench --csv ({error})") from error
    return timings


def measure(level: str) -> pandas.DataFrame:
    """Run the benchmark, which prints its table, and return its rows; level: the kernels, "v3" or "v1"."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bench.csv")
        environment = os.environ | {"ASPERITY_ISA": level}
        done = subprocess.run([BENCH, "--csv", path], check=False, env=environment)
        if done.returncode != 0:
            raise ValueError(f"{BENCH}: exit code {done.returncode}: expected 0")
        return read_timings(path)


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


def draw_speed(timings: pandas.DataFrame, path: Path) -> None:
    """Draw the error against the time per point into a file that ends in .png or .pdf."""
    blocks = timings[timings.kernel == "block"]
    times = blocks.groupby(["isa", "precision", "tangent", "pattern"]).ns_per_point.median()
    kernels = [*product(sorted(set(timings.isa)), ("double", "single"), FACETS)]
    errors = {name: pattern_errors(height) for name, (_, height) in FACETS.items()}
    with printed():
        figure, axes = new_figure(TWO, 3.2, ncols=2, sharey=True, sharex=True)
        for ax, tangent, title in zip(
            axes, (True, False), ("stress and tangent", "stress only"), strict=True
        ):
            for isa, precision, name in kernels:
                _curve(ax, times.get((isa, precision, tangent), {}), errors[name], isa, precision, name)
            log_axes(ax, "time per point [ns]", r"relative error of $\tau_L$" if tangent else "")
            ax.set_title(title)
            ax.margins(x=0.15)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
        save(figure, path)


def pattern_errors(height: float) -> dict[str, float]:
    """Errors of the patterns in tau_L against RP-64: L2 norm over a monotonic path, the worst direction."""
    errors = plane_errors(SIDES.values(), (SIGMA_N,), replace(MATERIAL, height=height))
    return dict(zip(SIDES, errors.tau_L, strict=True))


def _curve(
    ax: Axes, times: Mapping[str, float], errors: Mapping[str, float], isa: int, precision: str, name: str
) -> None:
    """Draw the curve of one kernel; the names of the patterns stand at that of AVX2 in single precision."""
    end, _ = FACETS[name]
    points = [(times[p + end], error, p) for p, error in errors.items() if p + end in times]
    colour, double = COLOURS[{1: 1, 3: 0, 0: 3}[isa]], precision == "double"
    style = {"markersize": 3.5, "linewidth": 1.0, "markerfacecolor": colour if double else "white"}
    if points:
        line = ("o" if double else "s") + (":" if end else "-")
        x, y, _ = zip(*points, strict=True)
        ax.plot(x, y, line, color=colour, label=f"{KINDS[isa]}, {precision}{name}", **style)
    for x, y, pattern in points if not (double or end or isa == 1) else ():
        place = {"textcoords": "offset points", "ha": "right", "va": "top"}
        ax.annotate(pattern, (x, y), (-4, -2), fontsize=6, **place)


def _speed(options: argparse.Namespace) -> int:
    """Read CSVs of the benchmark, or run the benchmark, then draw."""
    parts = [read_timings(path) for path in options.csv]
    parts = parts or [measure(level) for _ in range(RUNS) for level in ("v1", "v3")]
    draw_speed(pandas.concat(parts), options.output)
    print(options.output)
    return 0


main = program(
    _speed,
    (
        "csv BENCH.csv",
        f"written by bench --csv, with any kernels (default: run it {RUNS} times with each)",
        Path,
        {"nargs": "*"},
    ),
    ("-o --output FILE", "picture, .png or .pdf", Path("speed.png")),
)

if __name__ == "__main__":
    sys.exit(main())
