"""Command `asperity paper`: pictures, numbers and findings of the figures and tables of the paper."""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path

from ..options import add_options, add_output, add_workers, check_outputs, progress_bar, workers
from ..parallel import map_in_order
from ..style import encoded, printed
from .figures import ENTRIES, Entry
from .outcome import ROUNDING, run_case


def add_arguments(paper: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    add_output(paper, "DIR", "folder of the pictures and the numbers", Path("gallery"))
    add_options(
        paper,
        ("--figure NUMBER", "only these, such as 4a or table5 (default: all)", str, {"nargs": "+"}),
    )
    add_workers(paper)
    paper.set_defaults(action=_action)


def _action(options: argparse.Namespace) -> int:
    wanted = select(options.figure) if options.figure else ENTRIES
    with workers(options, os.cpu_count()) as executor:
        found = write(wanted, options.output, executor, options.force)
    print("\n".join(f"{name}\n{text}" for name, text in found.items()))
    print(options.output)
    return 0


def select(numbers: Sequence[str]) -> list[Entry]:
    """Entries by their numbers, in the order of the paper; raises ValueError for an unknown number."""
    known = [entry.number for entry in ENTRIES]
    for number in numbers:
        if number not in known:
            raise ValueError(f"--figure {number}: expected one of {', '.join(known)}")
    return [entry for entry in ENTRIES if entry.number in numbers]


def write(
    entries: Sequence[Entry], folder: Path, executor: Executor | None = None, force: bool = True
) -> dict[str, str]:
    """Write pictures and numbers of entries into a folder; return their findings by the names of the files.

    executor: as in `map_in_order`; without one, one entry after the other.  force: as in `check_outputs`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    # the last entries take longest, so they start first
    numbers = [ENTRIES.index(entry) for entry in reversed(entries)]
    with progress_bar(len(entries), "figure") as bar:
        made = map_in_order(_make_one, numbers, executor or ThreadPoolExecutor(1), bar.update)[::-1]
    contents = {folder / name: content for files, _ in made for name, content in files.items()}
    for path, content in contents.items():
        header = [re.escape(content.decode().partition("\n")[0])] if path.suffix == ".csv" else []
        check_outputs(force, [], ("-o", path, *header))
    for path, content in contents.items():
        path.write_bytes(content)
    return {entry.stem: text for entry, (_, text) in zip(entries, made, strict=True)}


def _make_one(number: int) -> tuple[dict[str, bytes], str]:
    """Files of one entry by name, picture and numbers, and its findings as a list in Markdown."""
    entry, files = ENTRIES[number], {}
    with printed():
        figure, found, rows = entry.make(*map(run_case, entry.cases))
        if figure is not None:
            files[f"{entry.stem}.png"] = encoded(figure, ".png")
    numeric = rows.select_dtypes("number")
    rows[numeric.columns] = numeric.where(numeric.abs() > ROUNDING, 0)
    files[f"{entry.stem}.csv"] = rows.to_csv(index=False, float_format="%.6g", lineterminator="\n").encode()
    # a table stands by itself
    return files, "\n".join(text if text.startswith("\n") else f"- {text}" for text in found)
