"""Command `asperity paper`: pictures, numbers and one page of the figures and tables of the paper."""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path

from ..parallel import Serial, add_workers, map_in_order, progress_bar, workers
from ..style import encoded, printed
from .entries import ENTRIES, Entry

PAGE = "README.md"

HEAD = """# The paper, recomputed

Albarella, Serpieri, Alfano, Sacco, *A 3D multiscale cohesive zone model for quasi-brittle materials
accounting for friction, damage and interlocking* (2015). This page is written by
`asperity paper --folder docs/gallery`. The command computes every number on the page with the library,
through the driver (case files in [`harness/cases`](../../harness/cases)) and the Python package. The
constants are those of Table 2 unless an entry gives others: $\\sigma_0$ = 3 MPa, $G_c$ = 0.3 N/mm,
$\\eta$ = 0.9, $\\mu$ = 0.5. [Theory, section 7](../theory.md#7-corrections-to-the-printed-text) lists
corrections to the printed text. [Concepts](../concepts.md) defines the words.

The text of the paper leaves some load paths open; each entry says what is assumed. Only the text of the paper
was at hand, not its pictures, so "the paper says" refers to text, captions and tables. "Converged" values are
those for steps so small that the result no longer changes; the entry of Table 5 has the details. A CSV holds
about 100 rows of each curve. A cross in a picture marks the end of equilibrium.
"""


def add_arguments(paper: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    paper.add_argument(
        "--folder",
        type=Path,
        default=Path("gallery"),
        metavar="DIR",
        help="folder of the pictures, the numbers and the page (default: %(default)s)",
    )
    paper.add_argument("--pdf", action="store_true", help="also write vector pictures (PDF)")
    paper.add_argument(
        "--figure",
        nargs="+",
        metavar="NUMBER",
        help="only these, such as 4a, 4 or table5, without the page (default: all, and the page)",
    )
    add_workers(paper, "one for each processor")
    paper.set_defaults(action=_action)


def _action(options: argparse.Namespace) -> int:
    wanted = select(options.figure) if options.figure else ENTRIES
    with workers(options, os.cpu_count()) as executor:
        texts = write(wanted, options.folder, options.pdf, executor)
    if not options.figure:
        (options.folder / PAGE).write_text(HEAD + "".join(texts), encoding="utf-8")
    print(options.folder)
    return 0


def select(numbers: Sequence[str]) -> tuple[Entry, ...]:
    """Return entries by their numbers; "4" means 4a and 4b. Raises ValueError for an unknown number."""
    wanted = [number.lower().replace(" ", "") for number in numbers]
    known = {entry: _names(entry) for entry in ENTRIES}
    for number, name in zip(numbers, wanted, strict=True):
        if not any(name in names for names in known.values()):
            expected = ", ".join(entry.number for entry in ENTRIES)
            raise ValueError(f"--figure {number}: expected one of {expected}")
    return tuple(entry for entry, names in known.items() if names.intersection(wanted))


def _names(entry: Entry) -> set[str]:
    name = entry.number.lower().replace(" ", "")
    return {name, re.sub(r"(?<=\d)[ab]$", "", name)}


def write(
    entries: Sequence[Entry], folder: Path, pdf: bool = False, executor: Executor | None = None
) -> list[str]:
    """Write pictures and numbers of entries into a folder; return their page sections.

    executor: as in `map_in_order`; without one, one entry after the other.
    """
    folder.mkdir(parents=True, exist_ok=True)
    # The last entries take longest, so they start first.
    numbers = [ENTRIES.index(entry) for entry in reversed(entries)]
    with progress_bar(len(entries), "figure") as bar:
        made = map_in_order(partial(_make_one, pdf), numbers, executor or Serial(), bar.update)[::-1]
    for files, _ in made:
        for name, content in files.items():
            (folder / name).write_bytes(content)
    return [text for _, text in made]


def _make_one(pdf: bool, number: int) -> tuple[dict[str, bytes], str]:
    """Files of one entry by name, picture and numbers, and its section of the page."""
    entry = ENTRIES[number]
    png, csv = Path(f"{entry.stem}.png"), Path(f"{entry.stem}.csv")
    with printed():
        outcome = entry.run()
        endings = (".png", ".pdf") if pdf else (".png",)
        files = {entry.stem + ending: encoded(outcome.figure, ending) for ending in endings}
    files[csv.name] = "\n".join([outcome.header, *outcome.lines, ""]).encode()
    name = entry.number if entry.number.startswith("Table") else f"Figure {entry.number}"
    parts = [f"\n## {name}: {entry.title}\n", f"![{name}]({png.name})\n"]
    parts.append(f"**The paper says:** {entry.says}")
    parts.append("\n**What came out:**" + "".join(_item(text) for text in outcome.came_out))
    parts.append(f"\n**Difference:** {outcome.differs}")
    if entry.assumed:
        parts.append(f"\n**Assumed:** {entry.assumed}")
    cases = ", ".join(f"[`{stem}.nml`](../../harness/cases/{stem}.nml)" for stem in entry.cases)
    parts.append(f"\nNumbers: [{csv.name}]({csv.name})." + (f" Cases: {cases}." if cases else ""))
    return files, "\n".join(parts) + "\n"


def _item(text: str) -> str:
    return f"\n{text}" if text.startswith("\n") else f"\n- {text}"
