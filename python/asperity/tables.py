"""Tables: CSV files as instruments and spreadsheets write them, and Markdown."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from .options import imported

if TYPE_CHECKING:
    from pandas import DataFrame, Series

    from .contract import Floats

NUMBER = re.compile(r"[-+]?(\d[\d.,'\s]*|[.,]\d+)([eE][-+]?\d+)?")
EMPTY = re.compile(r"|nan|n/?a|null|none|[-\u2013]+|#[^\s\d]\S*", re.IGNORECASE)
"""A number in any notation, and cells without a number, such as #DIV/0!."""

UNIT = (
    r"(?:[kMG]?(?:Pa|N)|psi|ksi|bar|kgf?|kp|t|[n\u00b5\u03bcumc]?m|in|ft|s|min|deg|[-%\u00b0])"
    r"(?:\s*/\s*(?:[cm]?m|in|ft)\s*(?:\^|\*\*)?[23\u00b2\u00b3]?)?"
)
HEADER = re.compile(
    rf"\s*(.*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])]|(?:\sin|/|,)\s+({UNIT})|[\s_]({UNIT}(?<=[a\u00b2\u00b32-9m])))?\s*"
)
UNITS = re.compile(rf"[\[(]?\s*({UNIT})?\s*[\])]?")
"""Units, the name of a column with its unit, and a cell of a row of units."""

COMMENT = re.compile(r"(^|\s)#(?!\u00a1?[A-Z]+(/\w+)?[!?]?(\s|[;,]|$)).*")
"""A comment, but for #DIV/0! and other errors of spreadsheets."""

FIRST_LINES = 400
"""Lines in which the header is searched."""

MOST_ERRORS = 10
"""Largest number of errors of a file that are listed."""


@dataclass(frozen=True)
class Table:
    """Cells (T, C) of a CSV file as text, by lines of the file; line: of the header, with names and units."""

    path: Path
    line: int
    names: list[str]
    units: list[str]
    cells: DataFrame

    @property
    def lines(self) -> list[int]:
        """Lines of the rows (T,)."""
        return [int(line) for line in self.cells.index]

    def numbers(self, columns: Sequence[int], names: Sequence[str], gaps: Sequence[str] = ()) -> Floats:
        """Numbers (T, n) of columns, NaN where a cell of those named in `gaps` is empty or an error.

        Raises ValueError with every cell that is no finite number, and where decimal marks and separators of
        thousands cannot be told apart.
        """
        import numpy as np
        import pandas as pd

        texts = self.cells[list(columns)].set_axis(list(names), axis=1)
        found = texts.apply(pd.to_numeric, errors="coerce").to_numpy(dtype=float)
        if np.isfinite(found).all():
            for name, column in texts.items():
                self._check_groups(str(name), column, ".")
            return found
        texts = texts.apply(lambda one: one.str.replace(r"(?<=\d)['\u2019\s](?=\d{3})", "", regex=True))
        empty = texts.apply(lambda one: one.str.fullmatch(EMPTY))
        good = texts.apply(lambda one: one.str.fullmatch(NUMBER))
        decimal = self._decimal_mark(texts.where(good, ""))
        other = {",": ".", ".": ","}[decimal]
        plain = texts.apply(lambda one: one.str.replace(other, "").str.replace(decimal, "."))
        found = plain.where(good).apply(pd.to_numeric, errors="coerce").to_numpy(dtype=float)
        allowed = empty.to_numpy(dtype=bool) & np.isin(list(names), list(gaps))
        raise_all(
            [
                f"{self.path}: line {self.lines[i]}, column {names[j]}: {texts.iat[i, j] or 'empty'}: "
                "expected a finite number"
                for i, j in np.argwhere(~np.isfinite(found) & ~allowed).tolist()
            ]
        )
        return found

    def _decimal_mark(self, texts: DataFrame) -> str:
        """Decimal mark of the columns; the other mark separates thousands.  Raises ValueError."""
        cells = [(line, text) for _, column in texts.items() for line, text in column.items()]
        both = [text for _, text in cells if "," in text and "." in text]
        have = {mark: [(line, text) for line, text in cells if mark in text] for mark in ",."}
        grouped = {mark: all(_is_grouped(text, mark) for _, text in have[mark]) for mark in ",."}
        if both:
            mark = max(",.", key=both[0].rfind)
        elif have[","] and have["."]:
            if grouped[","] == grouped["."]:
                (line, text), (_, other) = sorted([have[","][0], have["."][0]])[::-1]
                raise ValueError(
                    f"{self.path}: line {line}: {text} beside {other}: expected one decimal mark"
                )
            mark = "." if grouped[","] else ","
        else:
            mark = "," if have[","] else "."
            if any(text.count(mark) > 1 for _, text in cells):
                mark = {",": ".", ".": ","}[mark]
            for name, column in texts.items():
                self._check_groups(str(name), column, mark)
        other = {",": ".", ".": ","}[mark]
        for line, text in cells:
            if text.count(mark) > 1 or (other in text and not _is_grouped(text.split(mark)[0], other)):
                raise ValueError(
                    f"{self.path}: line {line}: {text}: expected a number with the decimal mark {mark}"
                )
        return mark

    def _check_groups(self, name: str, column: Series[str], mark: str) -> None:
        """Raise ValueError for 1,234 beside 950, where the comma may separate thousands."""
        marked = column[column.str.contains(mark, regex=False)]
        whole = column[column.str.fullmatch(r"[-+]?\d{3}")]
        if len(marked) and len(whole) and all(_is_grouped(text, mark) for text in marked):
            found = f"column {name}: {whole.iloc[0]} beside {marked.iloc[0]}"
            raise ValueError(f"{self.path}: {found}: expected no separators of thousands")


def read_table(path: Path, expected: str) -> Table:
    """Cells of a CSV file; its separators are semicolons, tabs, commas or blanks, and # begins a comment.

    The header is the line above the first long run of rows of numbers, and a row of units may follow it; the
    lines before are left out.  Raises ValueError with what is expected for a file that is no text, and with
    every row of another length; OSError for a file that cannot be read.
    """
    pandas = imported("pandas")
    raw = _text(path, expected).splitlines()
    lines = [COMMENT.sub("", line).strip(" ") for line in raw]
    start, mark = _first_row(lines)
    above = [i for i in range(start) if lines[i].strip(' ;,\t"')]
    head = _split(re.sub(r"(^|\s)#(?!\s*([;,\t\"[(]|$)).*", "", raw[above[-1]]), mark) if above else []
    row_of_units: list[str] = []
    if len(above) > 1 and sum(map(bool, head)) > 1 and all(map(UNITS.fullmatch, head)):
        row_of_units = [cell.strip("[]() ") for cell in head]
        head = _split(raw[above[-2]], mark)
    while len(head) > 1 and not head[-1]:
        head.pop()
    line = above[-1 - bool(row_of_units)] + 1 if len(head) > 1 else 0
    parts = [HEADER.fullmatch(cell) for cell in head if line]
    names = [part[1] for part in parts if part]
    units = [part[2] or part[3] or part[4] or "" for part in parts if part]
    units = [one or more for one, more in zip(units, row_of_units + [""] * len(units), strict=False)]
    width = len(names) or (len(_split(lines[start], mark)) if lines[start:] else 0)
    counts = [1 + one.count(mark) if mark else len(one.split()) for one in lines[start:]]
    kinds = {"dtype": str, "keep_default_na": False, "skip_blank_lines": False, "skipinitialspace": True}
    wide = range(max([width, *counts]))
    source = io.StringIO("\n".join([*lines[start:], ""]))
    cells = pandas.DataFrame(columns=wide, dtype=str)
    if start < len(lines):
        cells = pandas.read_csv(source, sep=mark or r"\s+", header=None, names=wide, **kinds)
    cells = cells.set_axis(range(start + 1, start + 1 + len(cells)), axis=0)
    cells = cells.fillna("").apply(lambda column: column.str.strip())
    filled = (cells != "").to_numpy()
    last = width + (filled[:, width:] * range(1, filled.shape[1] - width + 1)).max(axis=1, initial=0)
    raise_all(
        [
            f"{path}: line {start + 1 + i}: {min(counts[i], int(last[i]))} values: expected {width}, one for "
            "each column"
            for i in filled.any(axis=1).nonzero()[0].tolist()
            if counts[i] < width or last[i] > width
        ]
    )
    return Table(path, line, names, units, cells.loc[filled.any(axis=1), : width - 1])


def _text(path: Path, expected: str) -> str:
    """Text of a file in UTF-8, UTF-16 or the code page of spreadsheets; raises ValueError or OSError."""
    try:
        data = path.read_bytes()
    except OSError as error:
        reason = (error.strerror or "cannot be read").lower()
        raise type(error)(f"{path}: {reason}: expected {expected}") from None
    for encoding in ("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig", "cp1252"):
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise ValueError(f"{path} is no text: expected {expected}")


def _split(line: str, mark: str) -> list[str]:
    """Cells of a line; blanks separate names with units in brackets, too."""
    if not mark:
        return re.findall(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?", line)
    return [cell.strip() for cell in next(csv.reader([line], delimiter=mark, skipinitialspace=True), [])]


def _first_row(lines: Sequence[str]) -> tuple[int, str]:
    """First line of the longest run of lines with numbers, and the separator of its cells."""
    best = (0, 0, len(lines), ";")
    for rank, mark in enumerate((";", "\t", ",", "")):
        first, length = 0, 0
        for i, line in enumerate([*lines[:FIRST_LINES], "end"]):
            cells = [cell for cell in (_split(line, mark) if line else []) if cell]
            numbers = sum(bool(NUMBER.fullmatch(cell) or re.match(r"nan$|#\S", cell, re.I)) for cell in cells)
            # 0,1 0,2 has decimal commas
            commas = mark == "," and any(re.search(r"\d\s+[-+]?\d", cell) for cell in cells)
            if len(cells) > 1 and 2 * numbers >= len(cells) and not commas:
                first, length = (i, 1) if length == 0 else (first, length + 1)
            elif cells:
                best = max(best, (length, -rank, first, mark), key=lambda one: one[:2])
                length = 0
    if not best[0]:
        last = next((line for line in reversed(lines) if line), "")
        return len(lines), next((mark for mark in ";\t," if mark in last), "")
    return best[2], best[3]


def _is_grouped(text: str, mark: str) -> bool:
    """Whether a mark separates the digits of a number in groups of three."""
    return re.fullmatch(rf"[-+]?[1-9]\d{{0,2}}(?:\{mark}\d{{3}})+", text) is not None


def raise_all(errors: Sequence[str]) -> None:
    """Raise ValueError with a line for each error, up to MOST_ERRORS of them, if there is one."""
    if errors:
        more = [f"and {len(errors) - MOST_ERRORS} more"] if len(errors) > MOST_ERRORS else []
        raise ValueError("\n".join([*errors[:MOST_ERRORS], *more]))


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]], numbers: bool = False) -> str:
    """Table in Markdown; with `numbers` the columns after the first are aligned to the right."""
    lines = [head, ["---", *["--:" if numbers else "---"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", r"\|") for cell in line) + " |" for line in lines)
