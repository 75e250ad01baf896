"""Error and time of whole structures against the number of planes.

harness/hosts/structures/structure_study.py runs the structures and writes the rows.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from asperity.interface import Interface
from asperity.material import Material
from asperity.pattern import Pattern
from asperity.selection.search import LoadCase, NoPatternError, select
from asperity.tables import markdown

from .program import run
from .tables import percent, refresh

MATERIAL = Material(sigma0=0.3, Gc=0.03, eta=0.95, mu=0.6, kc=20.0)
"""Bed joint, mm, N, MPa."""

THETA, PRESSURE, SLIP = 20.0, 0.5, 0.6

TURNS = {"Kratos triplet": (SLIP, -SLIP), "OpenGeoSys block": (SLIP,), "explicit block": (SLIP,)}
"""Slips at the reversals and at the end of each structure."""

SIDES = (0, 2, 3, 4, 6, 9, 12, 18, 32)
"""Sides of the patterns of every structure, beside those that `select` finds."""

SHOWN = (0, 4, 9, 18, 32)
"""Sides of the patterns in the table; the picture has all."""

TOLERANCES = (0.1, 0.05, 0.02, 0.01)
"""Tolerances of `select`."""

FINEST = {"OpenGeoSys block": 32}
"""Most sides that a host takes, where these are fewer than REFERENCE."""

NUMBERS = ("force", "rise", "seconds", "law")
"""Columns with numbers."""

REFERENCE = 64
"""Sides of the reference: the mean over slip up a plane and between two planes."""


@dataclass(frozen=True)
class Row:
    """A structure with a pattern, the worst and the mean of slip up a plane and between two planes.

    Errors of force and rise: L2 norm over the path, relative to that of the reference.  seconds: processor
    time of a run; law: that of the law in it.
    """

    structure: str
    sides: int
    force: float
    rise: float
    seconds: float
    law: float

    @property
    def name(self) -> str:
        """Name of the pattern."""
        return name_of(self.sides)

    @property
    def planes(self) -> int:
        """Number of planes."""
        return pattern_of(self.sides).normals.shape[0]


def name_of(sides: int) -> str:
    """Name of a regular pattern."""
    return {0: "flat", 2: "RT"}.get(sides, f"RP-{sides}")


def pattern_of(sides: int, direction: float = 0.0, between: bool = False) -> Pattern:
    """Pattern with slip along a direction (degrees) up a plane, or half-way between two planes."""
    return Pattern.regular(sides, THETA, turn=direction + (180.0 / sides if between and sides else 0.0))


def interface_of(sides: int, direction: float = 0.0, between: bool = False) -> Interface:
    """Interface of the study."""
    return Interface(MATERIAL, pattern_of(sides, direction, between))


def selected(structure: str) -> dict[float, int]:
    """Sides that `select` finds for the load case of a structure, by tolerance, as far as the host goes."""
    case = LoadCase(MATERIAL, THETA, (-PRESSURE,), TURNS[structure])
    found = {}
    for tolerance in TOLERANCES:
        try:
            answer = select(case, tolerance)
        except NoPatternError:
            continue
        sides = 0 if answer.name == "flat" else 2 if answer.name == "RT" else int(answer.name[3:])
        if sides < FINEST.get(structure, REFERENCE):
            found[tolerance] = sides
    return found


def sides_of(structure: str) -> list[int]:
    """Sides of the patterns of a structure, rising."""
    finest = FINEST.get(structure, REFERENCE)
    return sorted({n for n in (*SIDES, *selected(structure).values()) if n < finest})


def write_rows(path: Path, rows: Sequence[Row]) -> None:
    """Write rows that `read_rows` reads."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([field.name for field in fields(Row)])
        for row in rows:
            writer.writerow([f"{value:.6g}" if isinstance(value, float) else value for value in astuple(row)])


def read_rows(path: Path) -> list[Row]:
    """Rows of a file; raises ValueError for another file."""
    with path.open(encoding="utf-8", newline="") as file:
        try:
            rows = [
                Row(one["structure"], int(one["sides"]), *(float(one[name]) for name in NUMBERS))
                for one in csv.DictReader(file)
            ]
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: expected a CSV of structure_study.py ({error!r})") from error
    unknown = {row.structure for row in rows} - set(TURNS)
    if not rows or unknown:
        raise ValueError(f"{path}: structures {sorted(unknown)}: expected rows of {', '.join(TURNS)}")
    return rows


def draw(rows: Sequence[Row], path: Path) -> None:
    """Draw error and time over the number of planes, a column for each structure."""
    import matplotlib.pyplot as plt
    from asperity.style import COLOURS

    names = list(dict.fromkeys(row.structure for row in rows))
    figure, axes = plt.subplots(
        2, len(names), figsize=(3.7 * len(names), 6.4), layout="constrained", sharex=True, squeeze=False
    )
    for (error, cost), name in zip(axes.T, names, strict=True):
        here = [row for row in rows if row.structure == name]
        planes = [row.planes for row in here]
        error.plot(planes, [row.force for row in here], "o-", color=COLOURS[0], label="force")
        error.plot(planes, [row.rise for row in here], "s--", color=COLOURS[1], label="rise")
        error.set(xscale="log", yscale="log", title=name)
        law = [row.law for row in here]
        total = [row.seconds for row in here]
        cost.fill_between(planes, law, color=COLOURS[2], alpha=0.6, linewidth=0.0, label="law")
        cost.plot(planes, total, "o-", color="black", markersize=4, label="whole run")
        cost.set(xlabel="planes [-]", ylim=(0.0, 1.15 * max(total)))
        cost.set_xticks([1, 3, 5, 10, 20, 40], ["1", "3", "5", "10", "20", "40"])
        cost.minorticks_off()
        for ax in (error, cost):
            ax.grid(alpha=0.3)
    axes[0, 0].set_ylabel("error over the path [-]")
    axes[1, 0].set_ylabel("processor time [s]")
    for row in axes:
        row[0].legend(fontsize="small")
    figure.savefig(path, dpi=150)
    plt.close(figure)


def table(rows: Sequence[Row]) -> str:
    """Errors, time and share of the law in Markdown."""
    head = ["structure", "pattern", "planes", "force, %", "rise, %", "time, s", "law in it, %"]
    cells = [
        [
            row.structure, row.name, str(row.planes), percent(row.force), percent(row.rise),
            f"{row.seconds:.2f}", percent(row.law / row.seconds),
        ]
        for row in rows
        if row.sides in SHOWN
    ]  # fmt: skip
    return markdown(head, cells, numbers=True)


def check_of_select(rows: Sequence[Row]) -> str:
    """What `select` finds for every structure and tolerance, and the errors there, in Markdown."""
    by = {(row.structure, row.sides): row for row in rows}
    cells = []
    for name in dict.fromkeys(row.structure for row in rows):
        for tolerance, sides in selected(name).items():
            row = by.get((name, sides))
            if row is None:
                raise ValueError(f"{name}: no row with {sides} sides: expected a CSV of structure_study.py")
            worst = max(row.force, row.rise)
            verdict = "yes" if worst <= tolerance else "no"
            cells.append(
                [name, f"{100.0 * tolerance:g}", row.name, percent(row.force), percent(row.rise), verdict]
            )
    head = ["structure", "tolerance, %", "select", "force, %", "rise, %", "holds"]
    return markdown(head, cells, numbers=True)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the program."""
    parser.add_argument("csv", type=Path, metavar="STRUCTURES.csv", help="written by structure_study.py")
    parser.add_argument("-o", "--output", type=Path, default=Path("structures.png"), metavar="FILE",
                        help="picture, .png or .pdf (default: %(default)s)")  # fmt: skip
    parser.add_argument("--page", type=Path, metavar="PAGE.md", help="fill the tables into a page")
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    """Draw, and print or fill the tables."""
    if options.output.suffix not in (".png", ".pdf"):
        raise ValueError(f"{options.output}: expected a name that ends in .png or .pdf")
    rows = read_rows(options.csv)
    contents = {"structures": lambda: table(rows), "structures-select": lambda: check_of_select(rows)}
    draw(rows, options.output)
    print(options.output)
    if options.page is None:
        print("\n\n".join(text() for text in contents.values()))
    else:
        refresh(options.page, False, contents)
        print(options.page)
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program."""
    return run(add_arguments, arguments)


if __name__ == "__main__":
    sys.exit(main())
