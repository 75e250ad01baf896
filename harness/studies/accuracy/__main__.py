"""Work-precision charts and tables of docs/results/accuracy.md."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from asperity.style import printed, save
from matplotlib.figure import Figure
from tqdm import tqdm

from ..program import run
from ..tables import fill
from .common import Tick
from .increments import draw_increments
from .plane_charts import draw_materials, draw_planes
from .precision import draw_precision
from .tangents import draw_tangents

STUDIES = ("increments", "planes", "materials", "precision", "tangents")
"""Studies by the names of their markers."""


MAKE: dict[str, Callable[[bool, Tick], tuple[dict[str, Figure], str]]] = {
    "increments": draw_increments,
    "planes": draw_planes,
    "materials": draw_materials,
    "precision": draw_precision,
    "tangents": draw_tangents,
}
"""Studies: pictures by their names, and the table."""


def add_arguments(chart: argparse.ArgumentParser) -> None:
    """Add the arguments of the program."""
    chart.add_argument(
        "--folder",
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
    options.folder.mkdir(parents=True, exist_ok=True)
    page = options.page.read_text(encoding="utf-8") if options.page else None
    if page is not None and "<!-- accuracy-" not in page:
        raise ValueError(f"{options.page}: expected markers such as <!-- accuracy-planes -->")
    bar = tqdm(unit="run", disable=None)
    for name in options.only or STUDIES:
        bar.set_description(name)
        with printed():
            figures, table = MAKE[name](options.quick, bar.update)
        for stem, figure in figures.items():
            path = options.folder / f"accuracy_{stem}.{'pdf' if options.pdf else 'png'}"
            with printed():
                save(figure, path)
            bar.write(str(path))
        if page is None:
            bar.write(f"\n{table}\n")
        else:
            page = fill(page, {f"accuracy-{name}": lambda table=table: table})
    bar.close()
    if page is not None:
        options.page.write_text(page, encoding="utf-8")
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program."""
    return run(add_arguments, arguments)


if __name__ == "__main__":
    sys.exit(main())
