"""Charts and table of the benchmark: time per point against the number of planes, and ratios."""

from __future__ import annotations

import csv
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..installed import bench
from ..tables import markdown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CURVES = (
    ("textbook", "double", True, "textbook, tangent", 3, "x--"),
    ("point", "double", True, "point, tangent", 1, "s-"),
    ("block", "double", True, "block, tangent", 0, "^-"),
    ("block", "double", False, "block, stress", 0, "o-"),
    ("block", "single", False, "block, stress, single", 2, "o-"),
    ("roots", "double", False, "limit: roots and divisions", 3, ":"),
    ("roots", "single", False, "limit: the same, single", 2, ":"),
    ("vumat", "double", False, "VUMAT from memory", 4, "D-"),
    ("stream", "double", False, "limit: streaming", 4, ":"),
)
"""Kernel, precision, tangent, label, colour number, marker and line style of the curves."""

BARS = (
    ("textbook / point, tangent", "textbook", "point", "double", True),
    ("textbook / block, tangent", "textbook", "block", "double", True),
    ("textbook / block, stress", "textbook", "block", "double", False),
    ("block / roots, stress", "block", "roots", "double", False),
    ("single: block / roots", "block", "roots", "single", False),
    ("VUMAT / streaming", "vumat", "stream", "double", False),
)
"""Label, kernel above, kernel below, precision and tangent of the ratios."""

BAR_PATTERNS = ("RT", "RP-4", "RP-32")


@dataclass(frozen=True)
class Timing:
    """Row of the benchmark: a kernel on a pattern, nanoseconds per point."""

    pattern: str
    planes: int
    kernel: str
    precision: str
    tangent: bool
    states: str
    ns_per_point: float


def read_timings(path: Path) -> list[Timing]:
    """Rows of a CSV of the benchmark; raises ValueError for another file."""
    with path.open(encoding="utf-8", newline="") as file:
        try:
            timings = [
                Timing(
                    row["pattern"],
                    int(row["planes"]),
                    row["kernel"],
                    row["precision"],
                    {"yes": True, "no": False}[row["tangent"]],
                    row["states"],
                    float(row["ns_per_point"]),
                )
                for row in csv.DictReader(file)
            ]
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: expected a CSV written by bench --csv ({error!r})") from error
    if not timings:
        raise ValueError(f"{path}: expected rows written by bench --csv")
    return timings


def measure(*options: str, quiet: bool = False) -> list[Timing]:
    """Run the benchmark and return its rows; the benchmark prints its table unless `quiet`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bench.csv")
        command = [bench(), "--csv", path, *options]
        done = subprocess.run(command, check=False, stdout=subprocess.DEVNULL if quiet else None)
        if done.returncode != 0:
            raise ValueError(f"{bench()}: exit code {done.returncode}: expected 0")
        return read_timings(path)


def draw_speed(timings: Sequence[Timing], path: Path) -> None:
    """Draw time per point against the number of planes, and ratios, into a file that ends in .png or .pdf."""
    from ..plots import plt

    if path.suffix not in (".png", ".pdf"):
        raise ValueError(f"{path}: expected a name that ends in .png or .pdf")
    figure, (growth, ratios) = plt.subplots(
        1, 2, figsize=(11.0, 5.5), layout="constrained", width_ratios=(3, 2)
    )
    _growth(growth, timings)
    _ratios(ratios, timings)
    figure.savefig(path, dpi=200)
    plt.close(figure)


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


def _growth(ax: Axes, timings: Sequence[Timing]) -> None:
    from ..plots import COLOURS

    for kernel, precision, tangent, label, colour, style in CURVES:
        rows = _rows(timings, kernel, precision, tangent)
        points = sorted((t.planes, t.ns_per_point) for t in rows if t.pattern not in FACETS)
        if points:
            x, y = zip(*points, strict=True)
            ax.loglog(x, y, style, color=COLOURS[colour], label=label, markersize=4, linewidth=1.3)
    planes = sorted({t.planes for t in timings})
    ax.set_xticks(planes, [str(n) for n in planes])
    ax.set_xticks([], minor=True)
    ax.set_xlabel("number of planes [-]")
    ax.set_ylabel("time per point [ns]")
    ax.grid(alpha=0.3, which="both")
    ax.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=3)


def _ratios(ax: Axes, timings: Sequence[Timing]) -> None:
    from ..plots import COLOURS

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
            ax.text(ratio, j + (i - 1) * height, f" {ratio:.1f}", va="center", fontsize="x-small")
    ax.set_yticks(range(len(BARS)), [bar[0] for bar in BARS], fontsize="small")
    ax.invert_yaxis()
    ax.axvline(1.0, color="black", linewidth=0.8)
    ax.set_xlim(0.0, 1.1 * ax.get_xlim()[1])
    ax.set_xlabel("ratio of times [-]")
    ax.legend(fontsize="small")


def _rows(timings: Sequence[Timing], kernel: str, precision: str, tangent: bool) -> Iterator[Timing]:
    """Rows of a kernel whose points all slip."""
    wanted = (kernel, precision, tangent, "slip")
    return (t for t in timings if (t.kernel, t.precision, t.tangent, t.states) == wanted)
