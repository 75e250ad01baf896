"""Failure modes of solution methods: the catalogue, its table for docs/results/stability.md, and a map."""

from __future__ import annotations

import argparse
import os
import sys
import textwrap
import time
from pathlib import Path

from asperity.options import add_options, add_workers, workers
from tqdm import tqdm

from ..program import DIFFERS, program_of
from ..tables import refresh
from .catalogue import MODES, find, shown, table


def add_arguments(stability: argparse.ArgumentParser) -> None:
    """Add the arguments of the program."""
    actions = stability.add_subparsers(required=True, metavar="ACTION")
    folder = ("--folder DIR", "folder of the pictures", Path("stability"))
    listed = actions.add_parser("list", help="show the catalogue of failure modes")
    listed.set_defaults(action=_list)
    single = actions.add_parser("run", help="run entries, with the methods that fail and those that succeed")
    add_options(
        single,
        ("names NAME", "an entry that `list` prints, or all", str, {"nargs": "+"}),
        ("--fill FILE.md", "fill the table between <!-- stability --> markers; no pictures", Path),
        folder,
    )
    single.set_defaults(action=_run)
    maps = actions.add_parser("map", help="draw the map of the convergence of tangents")
    add_options(maps, folder, ("--size N", "cells along an axis", 24))
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
            path = options.folder / f"stability_{mode.name}.png"
            options.folder.mkdir(parents=True, exist_ok=True)
            mode.draw().savefig(path, dpi=150)
            tqdm.write(str(path))
    if options.fill is not None and not refresh(options.fill, False, {"stability": table(results)}):
        print(f"{options.fill}: table filled")
    return DIFFERS if bad else 0


def _map(options: argparse.Namespace) -> int:
    """Compute and draw the map."""
    from .maps import draw_map

    if options.size < 2:
        raise ValueError(f"--size {options.size}: expected at least 2 cells along an axis")
    with workers(options, os.cpu_count()) as executor:
        for written in draw_map(options.folder, options.size, executor):
            print(written)
    return 0


main = program_of(add_arguments, _run)

if __name__ == "__main__":
    sys.exit(main())
