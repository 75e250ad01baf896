"""Command `asperity export`: what a host program needs for a start, as files in a folder."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..options import add_options


def add_arguments(export: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    export.description = (
        "Write the sources for Abaqus, decks to start from, an abaqus_v6.env, and a README with the numbers "
        "that a first run must show."
    )
    add_options(
        export,
        ("host", None, str, {"choices": ("abaqus",)}),
        ("folder DIR", "a new folder, or an empty one", Path),
        ("--force", "replace the files of the kit in a folder with files"),
    )
    export.set_defaults(action=_export)


def _export(options: argparse.Namespace) -> int:
    from .kit import files, rows, write

    contents = files()
    write(options.folder, contents, options.force)
    for name in contents:
        print(options.folder / name)
    print("A first run of single_standard.inp must show:")
    print(rows())
    return 0
