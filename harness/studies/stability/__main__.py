"""Failure modes of solution methods: the catalogue, its table for docs/results/stability.md, and a map."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from asperity.options import add_options, add_workers, workers
from asperity.style import save
from tqdm import tqdm

from ..program import DIFFERS, program_of
from ..tables import refresh
from .catalogue import as_expected
from .entries import MODES


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
    """Run entries and print each section, or fill the page."""
    sections, bad = [], 0
    names = [*MODES] if "all" in options.names else options.names
    for mode in tqdm([MODES[name] for name in names], unit="entry", disable=None, delay=2.0, leave=False):
        trials = mode.run()
        sections.append(mode.section(trials))
        if not as_expected(trials):
            bad += 1
            tqdm.write(f"{mode.name}: expected a failure and a success", file=sys.stderr)
        if options.fill is None:
            tqdm.write(sections[-1] + "\n")
        if mode.draw is not None and options.fill is None:
            path = options.folder / f"stability_{mode.name}.png"
            options.folder.mkdir(parents=True, exist_ok=True)
            save(mode.draw(), path)
            tqdm.write(str(path))
    if options.fill and not refresh(options.fill, False, {"stability": "\n\n".join(sections)}):
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
