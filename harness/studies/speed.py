"""Charts and table of the benchmark: time per point against the number of planes, and ratios."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from asperity.style import COLOURS, TWO, label_ends, new_figure, printed, save
from asperity.tables import markdown

from .program import run
from .timings import Timing, measure, read_timings

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CURVES = (
    ("textbook", "double", True, "textbook", 3, "x--"),
    ("point", "double", True, "point", 1, "s-"),
    ("block", "double", True, "block", 0, "^-"),
    ("vumat", "double", False, "VUMAT", 4, "D-"),
    ("stream", "double", False, "streaming", 4, ":"),
    ("block", "double", False, "block, double", 0, "o-"),
    ("roots", "double", False, "limit, double", 0, ":"),
    ("block", "single", False, "block, single", 2, "o-"),
    ("roots", "single", False, "limit, single", 2, ":"),
)
"""Kernel, precision, tangent, label, colour number, marker and line style of the curves."""

BARS = (
    ("textbook / point,\ntangent", "textbook", "point", "double", True),
    ("textbook / block,\ntangent", "textbook", "block", "double", True),
    ("textbook / block,\nstress", "textbook", "block", "double", False),
    ("block / limit,\nstress", "block", "roots", "double", False),
    ("block / limit,\nsingle", "block", "roots", "single", False),
    ("VUMAT /\nstreaming", "vumat", "stream", "double", False),
)
"""Label, kernel above, kernel below, precision and tangent of the ratios."""

BAR_PATTERNS = ("RT", "RP-4", "RP-32")


def draw_speed(timings: Sequence[Timing], path: Path) -> None:
    """Draw time per point against the number of planes, and ratios, into a file that ends in .png or .pdf."""
    with printed():
        figure, (tangent, stress, ratios) = new_figure(TWO, 3.2, ncols=3, width_ratios=(1.0, 1.0, 1.0))
        for ax, wanted, title in (
            (tangent, True, "stress and tangent"),
            (stress, False, "stress only; dotted: limits"),
        ):
            _growth(ax, timings, wanted)
            ax.set_title(title)
        _ratios(ratios, timings)
        low, high = (f(f(ax.get_ylim()) for ax in (tangent, stress)) for f in (min, max))
        for ax in (tangent, stress):
            ax.set_ylim(low, high)
            label_ends(ax)
        save(figure, path)


FACETS = ("RP-4 H", "RP-4 HW0")
"""Patterns with a finite height, and with wear, too; the curves are those of straight planes."""

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
    """Nanoseconds per point as a table in Markdown, a row per pattern."""
    rows = []
    for pattern, planes in dict.fromkeys((t.pattern, t.planes) for t in timings if t.states == "slip"):
        cells = [pattern, str(planes)]
        for _, kernel, precision, tangent in COLUMNS:
            times = {t.pattern: t.ns_per_point for t in _rows(timings, kernel, precision, tangent)}
            cells.append(f"{times[pattern]:.1f}" if pattern in times else "")
        rows.append(cells)
    return markdown(["pattern", "planes", *(column[0] for column in COLUMNS)], rows, numbers=True)


SHOWN_PLANES = (2, 4, 8, 16, 32, 64)
"""Numbers of planes with a label on the axis; the axis is logarithmic."""


def _growth(ax: Axes, timings: Sequence[Timing], with_tangent: bool) -> None:
    """Draw the time over the number of planes, of kernels with the tangent or without it."""
    for kernel, precision, tangent, label, colour, style in CURVES:
        rows = _rows(timings, kernel, precision, tangent)
        points = sorted((t.planes, t.ns_per_point) for t in rows if t.pattern not in FACETS)
        if points and tangent == with_tangent:
            x, y = zip(*points, strict=True)
            ax.loglog(x, y, style, color=COLOURS[colour], label=label, markersize=3)
    ax.set_xticks(SHOWN_PLANES, [str(n) for n in SHOWN_PLANES])
    ax.set_xticks([], minor=True)
    ax.set_xlabel("number of planes [-]")
    ax.set_ylabel("time per point [ns]" if with_tangent else "")
    ax.grid(alpha=0.3)


def _ratios(ax: Axes, timings: Sequence[Timing]) -> None:
    height = 0.8 / len(BAR_PATTERNS)
    hatches = ("", "//", "..")
    for i, pattern in enumerate(BAR_PATTERNS):
        for j, (_, above, below, precision, tangent) in enumerate(BARS):
            numerator, denominator = (
                {t.pattern: t.ns_per_point for t in _rows(timings, kernel, precision, tangent)}.get(pattern)
                for kernel in (above, below)
            )
            if numerator is None or denominator is None:
                continue
            ratio = numerator / denominator
            ax.barh(
                j + (i - 1) * height,
                ratio,
                0.9 * height,
                color=COLOURS[(4, 0, 1)[i]],
                hatch=hatches[i],
                edgecolor="white",
                label=pattern if j == 0 else None,
            )
            ax.text(ratio, j + (i - 1) * height, f" {ratio:.1f}", va="center", fontsize=6.0)
    ax.set_yticks(range(len(BARS)), [bar[0] for bar in BARS])
    ax.invert_yaxis()
    ax.axvline(1.0, color="black", linewidth=0.8)
    ax.set_xlim(0.0, 1.2 * ax.get_xlim()[1])
    ax.set_xlabel("ratio of times [-]")
    ax.legend()


def _rows(timings: Sequence[Timing], kernel: str, precision: str, tangent: bool) -> Iterator[Timing]:
    """Rows of a kernel whose points all slip."""
    wanted = (kernel, precision, tangent, "slip")
    return (t for t in timings if (t.kernel, t.precision, t.tangent, t.states) == wanted)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the program."""
    parser.add_argument(
        "csv", nargs="?", type=Path, metavar="BENCH.csv", help="written by bench --csv (default: run it now)"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("speed.png"),
        metavar="FILE",
        help="picture, .png or .pdf (default: %(default)s)",
    )
    parser.add_argument("--quick", action="store_true", help="short run with rough results")
    parser.add_argument("--table", action="store_true", help="also print a table in Markdown")
    parser.set_defaults(action=_speed)


def _speed(options: argparse.Namespace) -> int:
    """Read the CSV of the benchmark, or run the benchmark, then draw."""
    if options.csv is not None and options.quick:
        raise ValueError(f"--quick: expected without {options.csv}, which is not run again")
    quick = ["--quick"] if options.quick else []
    timings = measure(*quick) if options.csv is None else read_timings(options.csv)
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
