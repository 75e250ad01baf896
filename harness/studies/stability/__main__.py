"""Failure modes of solution methods: the catalogue, its table for docs/results/stability.md, and a map."""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

from asperity.options import add_options, add_workers, workers
from asperity.style import save
from tqdm import tqdm

from ..program import DIFFERS, program_of
from ..tables import refresh
from .catalogue import MODES, shown, table


def add_arguments(stability: argparse.ArgumentParser) -> None:
    """Add the arguments of the program."""
    actions = stability.add_subparsers(required=True, metavar="ACTION")
    folder = ("--folder DIR", "folder of the pictures", Path("stability"))
    single = actions.add_parser("run", help="run entries, with the methods that fail and those that succeed")
    add_options(
        single,
        ("names NAME", ", ".join(["all", *MODES]), str, {"nargs": "+", "choices": ["all", *MODES]}),
        ("--fill FILE.md", "fill the table between <!-- stability --> markers; no pictures", Path),
        folder,
    )
    single.set_defaults(action=_run)
    maps = actions.add_parser("map", help="draw the map of the convergence of tangents")
    add_options(maps, folder, ("--size N", "cells along an axis", 24))
    add_workers(maps)
    maps.set_defaults(action=_map)


def _run(options: argparse.Namespace) -> int:
    """Run entries and print each result."""
    quiet = options.fill is not None
    out = sys.stderr if quiet else sys.stdout
    results, bad = [], 0
    names = [*MODES] if "all" in options.names else options.names
    for mode in tqdm([MODES[name] for name in names], unit="entry", disable=None, delay=2.0, leave=False):
        start = time.monotonic()
        trials = mode.run()
        results.append((mode, trials))
        bad += not shown(trials)
        tqdm.write(f"{mode.name}: {mode.title} ({time.monotonic() - start:.1f} s)", file=out)
        for trial in trials:
            if not (quiet and trial.holds):
                verdict = "survives" if trial.survives else "fails"
                unexpected = "" if trial.holds else "  NOT AS EXPECTED"
                tqdm.write(f"  {verdict:<9}{trial.method}: {trial.measured}{unexpected}", file=out)
        if mode.draw is not None and not quiet:
            path = options.folder / f"stability_{mode.name}.png"
            options.folder.mkdir(parents=True, exist_ok=True)
            save(mode.draw(), path)
            tqdm.write(str(path))
    if quiet and not refresh(options.fill, False, {"stability": table(results)}):
        print(f"{options.fill}: table filled")
    return DIFFERS if bad else 0


def _map(options: argparse.Namespace) -> int:
    """Compute and draw the map."""
    from .maps import draw_map

    if options.size < 2:
        raise ValueError(f"--size {options.size}: expected at least 2 cells along an axis")
    with workers(options, os.cpu_count()) as executor:
        print(*draw_map(options.folder, options.size, executor), sep="\n")
    return 0


main = program_of(add_arguments, _run)

if __name__ == "__main__":
    sys.exit(main())
