"""Tables: CSV files as instruments and spreadsheets write them, and Markdown."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .contract import Floats

HEADER = re.compile(r"\s*([^\[(]*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")
"""Name of a column and its unit in brackets."""

MOST_ERRORS = 10
"""Largest number of errors of a file that are listed."""


@dataclass(frozen=True)
class Table:
    """Cells (T, C) of a CSV file and their lines (T,); header: its line, names and units, if it has one."""

    path: Path
    line: int
    names: list[str]
    units: list[str]
    lines: list[int]
    cells: list[list[str]]

    def numbers(self, columns: Sequence[int], names: Sequence[str], gaps: Sequence[str] = ()) -> Floats:
        """Numbers (T, n) of columns, NaN where a cell of those named in `gaps` is empty.

        A comma in a cell is a decimal comma.  Raises ValueError with every cell that is no finite number, and
        for a file with decimal commas and decimal points.
        """
        import numpy as np

        found, bad, marks = np.full((len(self.lines), len(columns)), np.nan), [], {}
        for i, (line, cells) in enumerate(zip(self.lines, self.cells, strict=True)):
            for j, name in enumerate(names):
                text = cells[columns[j]]
                for mark in ",.":
                    if mark in text:
                        marks.setdefault(mark, (line, text))
                try:
                    # Python alone reads 1_0 as 10
                    found[i, j] = float(text.replace(",", ".").replace("_", "?"))
                except ValueError:
                    if text or name not in gaps:
                        found[i, j] = np.inf
                if np.isinf(found[i, j]) or (text and np.isnan(found[i, j])):
                    what = text or "empty"
                    bad.append(f"{self.path}: line {line}, column {name}: {what}: expected a finite number")
        if not bad and len(marks) > 1:
            (line, text), (_, other) = sorted(marks.values())[::-1]
            bad.append(f"{self.path}: line {line}: {text} beside {other}: expected one decimal mark")
        for j, name in enumerate(names):
            texts = [cells[columns[j]] for cells in self.cells]
            commas = [text for text in texts if "," in text]
            large = [text for text in texts if re.fullmatch(r"[-+]?\d{3}", text)]
            if commas and large and all(re.fullmatch(r"[-+]?[1-9]\d{0,2},\d{3}", text) for text in commas):
                found_here = f"column {name}: {large[0]} beside {commas[0]}"
                bad.append(f"{self.path}: {found_here}: expected no separators of thousands")
        raise_all(bad)
        return found


def read_table(path: Path, expected: str) -> Table:
    """Cells of a CSV file; its separators are semicolons, tabs, commas or blanks, and # begins a comment.

    The first row without a number is the header.  Raises ValueError with what is expected for a file that is
    no text, and with every row of another length; OSError for a file that cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: byte {error.start} is no text in UTF-8: expected {expected}") from None
    except OSError as error:
        reason = (error.strerror or "cannot be read").lower()
        raise type(error)(f"{path}: {reason}: expected {expected}") from None
    lines = text.splitlines()
    stripped = (re.sub(r"(^|\s)#.*", "", line).strip(" ") for line in lines)
    rows = [(number, line) for number, line in enumerate(stripped, 1) if line.strip(' ;,\t"')]
    if rows and not re.match(r'[\s"]*[-+]?[.,]?\d', rows[0][1]):
        # in a header, # may end a name
        rows[0] = rows[0][0], re.sub(r"(^|\s)#(?!\s*([;,\t\"[(]|$)).*", "", lines[rows[0][0] - 1]).strip(" ")
    mark = next((mark for mark in ";\t," if rows and mark in rows[0][1]), None)
    try:
        cells = [next(csv.reader([line], delimiter=mark, skipinitialspace=True)) if mark else line.split()
                 for _, line in rows]  # fmt: skip
    except csv.Error as error:
        raise ValueError(f"{path}: {error}: expected {expected}") from None
    cells = [[cell.strip() for cell in row] for row in cells]
    lines = [line for line, _ in rows]
    names, units, first = [], [], 0
    if cells and not any(re.match(r"(?i)[-+]?([.,]?\d|nan$|inf)", cell) for cell in cells[0]):
        head = (
            cells.pop(0)
            if mark
            else re.findall(r"\w+\s*(?:[\[(][^\])]*[\])])?", rows[0][1]) * bool(cells.pop(0))
        )
        first = lines.pop(0)
        while len(head) > 1 and not head[-1]:
            head.pop()
        parts = [HEADER.fullmatch(cell) for cell in head]
        names = [part[1] if part else cell for part, cell in zip(parts, head, strict=True)]
        units = [part[2] or "" if part else "" for part in parts]
    width = len(names) or (len(cells[0]) if cells else 0)
    bad = []
    for line, row in zip(lines, cells, strict=True):
        while len(row) > width and not row[-1]:
            row.pop()
        if len(row) != width:
            bad.append(f"{path}: line {line}: {len(row)} values: expected {width}, one for each column")
    raise_all(bad)
    return Table(path, first, names, units, lines, cells)


def raise_all(errors: Sequence[str]) -> None:
    """Raise ValueError with a line for each error, up to MOST_ERRORS of them, if there is one."""
    if errors:
        more = [f"and {len(errors) - MOST_ERRORS} more"] if len(errors) > MOST_ERRORS else []
        raise ValueError("\n".join([*errors[:MOST_ERRORS], *more]))


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]], numbers: bool = False) -> str:
    """Table in Markdown; with `numbers` the columns after the first are aligned to the right."""
    lines = [head, ["---", *["--:" if numbers else "---"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", r"\|") for cell in line) + " |" for line in lines)
