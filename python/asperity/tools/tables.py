"""Tables: CSV files as instruments and spreadsheets write them, their units, and Markdown."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pandas import DataFrame

    from ..contract import Floats

NUMBER = r"[-+]?(\d[\d.,'\s]*|[.,]\d+)([eE][-+]?\d+)?"
EMPTY = r"(?i:|nan|n/?a|null|none|[-\u2013]+|#[^\s\d]\S*)"
"""A number in any notation, and cells without a number, such as #DIV/0!."""

WITH_MARK = {
    mark: rf"[-+]?(\d*|[1-9]\d{{0,2}}(\{other}\d{{3}})+)(\{mark}\d*)?([eE][-+]?\d+)?"
    for mark, other in (".,", ",.")
}
"""A number with a decimal mark; the other mark separates thousands."""

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
OF_HEADER = re.compile(r"(^|\s)#(?!\s*([;,\t\"[(]|$)).*")
"""A comment, but for #DIV/0! and other errors of spreadsheets, or for # in the name of a column."""

QUOTED = re.compile(r'(?:^|(?<=[;,\t]))"[^"]{,80}"(?=[;,\t]|$)', re.MULTILINE)
"""A quoted cell."""

FIRST_LINES = 400
"""Lines in which the header is searched."""

EXAMPLES = {
    "length": ("m", "m, cm, mm, um, in or ft"),
    "stress": ("Pa", "Pa, kPa, MPa, N/mm2, kN/m2, bar, psi or ksi"),
    "stiffness": ("Pa/m", "a unit of stress/length, such as MPa/mm"),
}
"""SI unit and usual units of each kind."""

MOST_ERRORS = 10
"""Largest number of errors of a file that are listed."""


@dataclass(frozen=True)
class Table:
    """Cells (T, C) of a CSV file as text, by lines of the file; line: of the header, with names and units.

    separator: of the cells, empty for blanks.
    """

    path: Path
    line: int
    names: list[str]
    units: list[str]
    cells: DataFrame
    separator: str

    @property
    def lines(self) -> list[int]:
        """Lines of the rows (T,)."""
        return [int(line) for line in self.cells.index]

    def numbers(
        self,
        columns: Sequence[int],
        names: Sequence[str],
        gaps: Sequence[str] = (),
        decimal: str | None = None,
    ) -> Floats:
        """Numbers (T, n) of columns, NaN where a cell of those named in `gaps` is empty or an error.

        decimal: the mark "." or ","; None: that with which all cells are numbers.  Raises ValueError with
        every cell that is no finite number, and for files with which both marks agree, such as 1,234.
        """
        import numpy as np
        import pandas as pd

        texts = self.cells[list(columns)].set_axis(list(names), axis=1)
        found = texts.apply(pd.to_numeric, errors="coerce").to_numpy(dtype=float)
        if np.isfinite(found).all() and decimal != "," and self.separator != ";":
            return found
        plain = texts.replace(r"(?<=\d)['\u2019\s](?=\d{3})", "", regex=True)
        empty = plain.apply(lambda one: one.str.fullmatch(EMPTY)).to_numpy(dtype=bool)
        mark = decimal or self._decimal_mark(plain.mask(empty, ""))
        good = plain.apply(lambda one: one.str.fullmatch(WITH_MARK[mark]))
        thousands = {",": ".", ".": ","}[mark]
        plain = plain.apply(lambda one: one.str.replace(thousands, "").str.replace(mark, "."))
        found = plain.where(good).apply(pd.to_numeric, errors="coerce").to_numpy(dtype=float)
        places = np.argwhere(~np.isfinite(found) & ~(empty & np.isin(list(names), list(gaps)))).tolist()
        wrong = [f"line {self.lines[i]}, column {names[j]}: {texts.iat[i, j] or 'empty'}" for i, j in places]
        wanted = "expected a finite number" + " with a decimal comma" * (mark == ",")
        raise_all([f"{self.path}: {text}: {wanted}" for text in wrong])
        return found

    def _decimal_mark(self, cells: DataFrame) -> str:
        """Decimal mark with which most cells are numbers; raises ValueError where both marks agree with all.

        The mark of 1,234 separates thousands beside whole numbers of three digits in the same column.  A
        point separates none, unless the cells are separated by semicolons, as where commas are decimal.
        """
        odd = {mark: (~cells.stack().str.fullmatch(form)).sum() for mark, form in WITH_MARK.items()}
        for mark, other in (",.", ".,") if odd[","] == odd["."] else ():
            for name, column in cells.items():
                marked = column[column.str.contains(mark, regex=False)]
                if len(marked) and column.str.fullmatch(r"[-+]?\d{3}").any():
                    return other
                if len(marked) and (mark == "," or self.separator == ";"):
                    text = f"{self.path}: line {marked.index[0]}, column {name}: {marked.iloc[0]}"
                    wanted = "expected numbers that show the decimal mark, or --decimal comma or point"
                    raise ValueError(f"{text} may be a decimal number, or have thousands: {wanted}")
        return "," if odd[","] < odd["."] else "."


def read_table(path: Path, expected: str) -> Table:
    """Cells of a CSV file; its separators are semicolons, tabs, commas or blanks, and # begins a comment.

    The header is the line above the first long run of rows of numbers, and a row of units may follow it; the
    lines before are left out.  Raises ValueError with what is expected for a file that is no text, and with
    every row of another length; OSError for a file that cannot be read.
    """
    from pandas import DataFrame

    raw = _text(path, expected).splitlines()
    lines = [COMMENT.sub("", line).strip(" ") for line in raw]
    start, mark = _first_row(lines)
    above = [i for i in range(start) if lines[i].strip(' ;,\t"')]
    head = _split(OF_HEADER.sub("", raw[above[-1]]), mark) if above else []
    row_of_units: list[str] = []
    if len(above) > 1 and sum(map(bool, head)) > 1 and all(map(UNITS.fullmatch, head)):
        row_of_units = [cell.strip("[]() ") for cell in head]
        head = _split(raw[above[-2]], mark)
    while len(head) > 1 and not head[-1]:
        head.pop()
    names = above[-1 - bool(row_of_units)] if len(head) > 1 else -1
    groups = _split(raw[names - 1], mark) if mark and names - 1 in above and len({*head}) < len(head) else []
    for i, group in enumerate(groups[: len(head)] if len(groups) > 1 else []):
        groups[i] = group or groups[i - 1]
        head[i] = f"{groups[i]} {head[i]}"
    parts = [part for part in map(HEADER.fullmatch, head if names >= 0 else ()) if part]
    units = [part[2] or part[3] or part[4] or "" for part in parts]
    units = [one or more for one, more in zip_longest(units, row_of_units[: len(units)], fillvalue="")]
    rows = {i: _split(text, mark) for i, text in enumerate(lines[start:], start + 1) if text.strip(";,\t ")}
    width = len(parts) or len(next(iter(rows.values()), []))
    for row in rows.values():
        while len(row) > width and not row[-1]:
            row.pop()
    raise_all(
        [
            f"{path}: line {i}: {len(row)} values: expected {width}, one for each column"
            for i, row in rows.items()
            if len(row) != width
        ]
    )
    cells = DataFrame([*rows.values()], index=[*rows], columns=range(width), dtype=str)
    return Table(path, names + 1, [part[1] for part in parts], units, cells, mark)


def _text(path: Path, expected: str) -> str:
    """Text of a file in UTF-8, UTF-16 or the code page of spreadsheets; raises ValueError or OSError."""
    data = path.read_bytes()
    for encoding in ("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig", "cp1252"):
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            # a line break within a quoted cell; the other lines keep their numbers
            whole = QUOTED.sub(lambda cell: cell[0].replace("\n", " "), text.replace("\r\n", "\n"))
            whole = whole.replace("\N{MINUS SIGN}", "-")
            return "\n" * (text.count("\n") - whole.count("\n")) + whole
    raise ValueError(f"{path} is no text: expected {expected}")


def _split(line: str, mark: str) -> list[str]:
    """Cells of a line; blanks separate names with units in brackets, too."""
    if not mark:
        return re.findall(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?", line)
    return [cell.strip() for cell in next(csv.reader([line], delimiter=mark, skipinitialspace=True), [])]


def _first_row(lines: Sequence[str]) -> tuple[int, str]:
    """First line of the longest run of lines with numbers, and the separator of its cells."""
    number = re.compile(rf"{NUMBER}|(?i:nan)|#\S.*")
    best = (0, len(lines), next((mark for line in reversed(lines) for mark in ";\t," if mark in line), ""))
    for mark in (";", "\t", ",", ""):
        first, length = 0, 0
        for i, line in enumerate([*lines[:FIRST_LINES], "end"]):
            cells = [cell for cell in (_split(line, mark) if line else []) if cell]
            numbers = sum(bool(number.fullmatch(cell)) for cell in cells)
            # 0,1 0,2 has decimal commas
            commas = mark == "," and any(re.fullmatch(r"[-+.\d]+(\s+[-+.\d]+)+", cell) for cell in cells)
            if len(cells) > 1 and 2 * numbers >= len(cells) and not commas:
                first, length = (first if length else i), length + 1
            elif cells:
                best = max(best, (length, first, mark), key=lambda one: one[0])
                length = 0
    return best[1:]


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(cache_folder=None)


@cache
def size(kind: str, text: str, where: str = "") -> float:
    """Unit of a kind (length, stress, stiffness) in SI units; raises ValueError for anything else.

    where: begins the message.
    """
    plain = re.sub(r"(?<=[A-Za-z])\^?([23])", r"**\1", text.replace("kp", "kgf").strip())
    plain = plain.replace("\N{SUPERSCRIPT TWO}", "**2").replace("\N{SUPERSCRIPT THREE}", "**3")
    unit, examples = EXAMPLES[kind]
    try:
        return float(_registry().Quantity(1.0, _registry().parse_units(plain)).to(unit).magnitude)
    except Exception:  # pint raises errors of its own, of Python's tokenizer and of the arithmetic of units
        raise ValueError(f"{where}[{text}]: expected {examples}") from None


def raise_all(errors: Sequence[str]) -> None:
    """Raise ValueError with a line for each error, up to MOST_ERRORS of them, if there is one."""
    if errors:
        more = [f"and {len(errors) - MOST_ERRORS} more"] if len(errors) > MOST_ERRORS else []
        raise ValueError("\n".join([*errors[:MOST_ERRORS], *more]))


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]], numbers: bool = False) -> str:
    """Table in Markdown; with `numbers` the columns after the first are aligned to the right."""
    lines = [head, ["---", *["--:" if numbers else "---"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", r"\|") for cell in line) + " |" for line in lines)
