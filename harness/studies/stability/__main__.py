"""Failure modes of solution methods: the catalogue, its table for docs/results/stability.md, and a map."""

from __future__ import annotations

import argparse
import os
import re
import sys
import textwrap
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from asperity.options import add_workers, workers
from tqdm import tqdm

from ..program import DIFFERS, run
from ..tables import refresh
from .catalogue import MODES, agree, find, shown, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def add_arguments(stability: argparse.ArgumentParser) -> None:
    """Add the arguments of the program."""
    actions = stability.add_subparsers(required=True, metavar="ACTION")

    listed = actions.add_parser("list", help="show the catalogue of failure modes")
    listed.set_defaults(action=_list)

    single = actions.add_parser("run", help="run entries, with the methods that fail and those that succeed")
    single.add_argument("names", nargs="+", metavar="NAME", help="an entry that `list` prints, or all")
    single.add_argument(
        "--fill",
        type=Path,
        metavar="FILE.md",
        help="fill the table between <!-- stability --> markers",
    )
    single.add_argument(
        "--check", action="store_true", help="with --fill: change nothing; exit with 1 if the table differs"
    )
    single.add_argument(
        "--folder",
        type=Path,
        default=Path("stability"),
        metavar="DIR",
        help="folder for the pictures of entries, drawn without --fill (default: %(default)s)",
    )
    single.set_defaults(action=_run)

    maps = actions.add_parser("map", help="draw the map of the convergence of tangents")
    maps.add_argument(
        "--folder", type=Path, default=Path("stability"), metavar="DIR", help="folder (default: %(default)s)"
    )
    maps.add_argument(
        "--size", type=int, default=24, metavar="N", help="cells along an axis (default: %(default)s)"
    )
    maps.add_argument("--pdf", action="store_true", help="PDF beside PNG")
    add_workers(maps)
    maps.set_defaults(action=_map)


def _list(options: argparse.Namespace) -> int:
    """Print the catalogue."""
    del options
    for mode in MODES:
        print(f"{mode.name}: {mode.title}")
        print(textwrap.fill(mode.happens, 100, initial_indent="  ", subsequent_indent="  "))
    return 0


def _run(options: argparse.Namespace) -> int:
    """Run entries and print each result."""
    if options.check and options.fill is None:
        raise ValueError("--check: expected with --fill FILE.md")
    quiet = options.fill is not None
    results, bad = [], []
    for mode in tqdm(find(options.names), unit="entry", disable=None, delay=2.0, leave=False):
        start = time.monotonic()
        trials = mode.run()
        results.append((mode, trials))
        if not shown(trials):
            bad.append(mode.name)
        file = sys.stderr if quiet else sys.stdout
        tqdm.write(f"{mode.name}: {mode.title} ({time.monotonic() - start:.1f} s)", file=file)
        for trial in trials:
            if quiet and trial.holds:
                continue
            verdict = "survives" if trial.survives else "fails"
            unexpected = "" if trial.holds else "  NOT AS EXPECTED"
            tqdm.write(f"  {verdict:<9}{trial.method}: {trial.measured}{unexpected}", file=file)
        if mode.draw is not None and not quiet:
            tqdm.write(str(_draw(mode.draw, options.folder / f"stability_{mode.name}.png")))
    if options.fill is not None:
        bad += _fill(options.fill, table(results), options.check)
    return DIFFERS if bad else 0


def _draw(draw: Callable[[], Figure], path: Path) -> Path:
    """Draw the picture of an entry."""
    import matplotlib.pyplot as plt

    path.parent.mkdir(parents=True, exist_ok=True)
    figure = draw()
    figure.savefig(path, dpi=150)
    plt.close(figure)
    return path


def _fill(path: Path, text: str, check: bool) -> list[str]:
    """Fill or compare the table of a file; return what is wrong with the file."""
    if not check:
        if not refresh(path, False, {"stability": lambda: text}):
            print(f"{path}: table filled")
        return []
    found = re.search(
        r"<!-- stability -->\n(.*?)\n<!-- /stability -->", path.read_text(encoding="utf-8"), re.DOTALL
    )
    if found and agree(found[1], text):
        return []
    print(f"{path}: the table is not up to date")
    return ["table"]


def _map(options: argparse.Namespace) -> int:
    """Compute and draw the map."""
    from .maps import draw_map

    if options.size < 2:
        raise ValueError(f"--size {options.size}: expected at least 2 cells along an axis")
    with workers(options, os.cpu_count()) as executor:
        for written in draw_map(options.folder, options.size, options.pdf, executor):
            print(written)
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program."""
    return run(add_arguments, arguments)


if __name__ == "__main__":
    sys.exit(main())
