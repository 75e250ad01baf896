"""Command `asperity export`: what a host program needs for a start, as files in a folder."""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from ..hosts import hosts
from ..installed import case_file
from ..model_checks import shown_warnings
from ..options import add_options

if TYPE_CHECKING:
    from .element import Element


def add_arguments(export: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    export.description = (
        "Write a model of one joint element for a host program, and a README with the rows that it must "
        "show. For Abaqus: sources, decks to start from and an abaqus_v6.env, too."
    )
    add_options(
        export,
        ("host", None, str, {"choices": tuple(hosts("kit"))}),
        ("folder DIR", "a new folder, or an empty one", Path),
        (
            "--case CASE.nml",
            "your joint: t_N, then slip along Tx under it (default: a joint to try)",
            case_file,
        ),
        ("--value VALUE", "value of the sweep, for a case with a sweep", str),
        ("--force", "replace the files of the kit in a folder with files"),
    )
    export.set_defaults(action=_export)


def _export(options: argparse.Namespace) -> int:
    from .element import Element

    if options.value is not None and options.case is None:
        raise ValueError(f"--value {options.value}: expected with --case")
    element = Element.of_case(options.case, options.value)
    with shown_warnings():
        contents = files(options.host, element, options.case is None)
    write(options.folder, contents, options.force)
    for name in contents:
        print(options.folder / name)
    print("The element must show these rows:")
    print(element.table())
    return 0


def files(host: str, element: Element, examples: bool = True) -> dict[str, bytes]:
    """Contents of the kit of a host by file name; examples: whether it has other models, too."""
    from .kits import files as contents

    texts = contents(host, element, examples)
    return {name: text if isinstance(text, bytes) else text.encode() for name, text in texts.items()}


def write(folder: Path, contents: dict[str, bytes], force: bool = False) -> None:
    """Write files into a folder that does not exist or is empty; with `force` they replace others.

    All files are written beside the folder first and then take their places. Raises ValueError if the folder
    has contents (without `force`), or is not a folder.
    """
    folder = folder.resolve()
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder}: expected a folder, or a name that is not taken")
    if not folder.parent.is_dir():
        raise ValueError(f"{folder.parent}: expected a folder that exists")
    if folder.exists() and any(folder.iterdir()):
        if not force:
            raise ValueError(
                f"{folder}: expected an empty folder or a new one; --force replaces the files of the kit"
            )
        taken = [name for name in contents if (folder / name).is_dir()]
        if taken:
            raise ValueError(f"{folder / taken[0]}: expected a file, or a name that is not taken")
    unfinished = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        for name, text in contents.items():
            (unfinished / name).write_bytes(text)
        folder.mkdir(exist_ok=True)
        for name in contents:
            os.replace(unfinished / name, folder / name)
    finally:
        shutil.rmtree(unfinished)
