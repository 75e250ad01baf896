"""Tables: CSV files and workbooks as instruments and spreadsheets write them, and Markdown."""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ..material import ModelWarning
from .cells import numbers_of
from .units import MENTIONED, UNITS, header, size
from .workbooks import sheets

if TYPE_CHECKING:
    from pandas import DataFrame

    from ..contract import Floats

__all__ = ["Table", "markdown", "raise_all", "read_table", "read_tables", "size"]

NUMBER = re.compile(r"[-+]?(\d[\d.,'\u2019\s]*|[.,]\d+)([eE][-+]?\d+)?|(?i:nan)|#\S.*")
"""A number in any notation, or an error of a spreadsheet."""

COMMENT = re.compile(r"(^|\s)#(?!\u00a1?[A-Z]+(/\w+)?[!?]?(\s|[;,|]|$)).*")
OF_HEADER = re.compile(r"(^|\s)#(?!\s*([;,|\t\"[(]|$)).*")
"""A comment, but for #DIV/0! and other errors of spreadsheets, or for # in the name of a column."""

HIDDEN = re.compile(r"\s*[#%!]+\s*(.*)")
"""A line that is a comment, as that which numpy.savetxt puts above its numbers."""

RULE = re.compile(r"[-+|:=\s]+")
"""A line below the header of a table in Markdown or of a database."""

QUOTED = re.compile(r'(?:^|(?<=[;,|\t]))"[^"]{,80}"(?=[;,|\t]|$)', re.MULTILINE)
"""A quoted cell."""

SEPARATORS = ("|", ";", "\t", ",", "")
"""Separators of cells, in the order in which they are tried; the empty one stands for blanks."""

FIRST_LINES = 400
"""Lines in which the header is searched."""

MOST_ERRORS = 10
"""Largest number of errors of a file that are listed."""

BOOKS = (".xlsx", ".xlsm")
ENDINGS = (".csv", ".txt", ".tsv", ".dat", ".asc", ".prn", ".md", *BOOKS)
"""Endings of workbooks, and of the files of a folder that are read."""


@dataclass(frozen=True)
class Table:
    """Cells (T, C) of a file as text, by its lines; line: of the header, 0 without one, with names and units.

    path: the file, for messages, with the sheet of a workbook.  separator: of the cells, empty for blanks.
    headings: the cells of the header as they stand in the file.  hidden: the header is a comment.
    remarks: lines above the rows that may say units, where the header has none.
    """

    path: Path
    line: int
    names: list[str]
    units: list[str]
    cells: DataFrame
    separator: str
    headings: list[str] = field(default_factory=list)
    hidden: bool = False
    remarks: list[str] = field(default_factory=list)

    def warn_of_remarks(self) -> None:
        """Give a ModelWarning where lines above the header may say units that the header does not have."""
        if self.remarks and not any(self.units):
            text = f"{self.path}: {self.remarks[0]}: not read as units: expected them in the header, x [mm]"
            warnings.warn(text, ModelWarning, stacklevel=3)

    @property
    def lines(self) -> list[int]:
        """Lines of the rows (T,)."""
        return [int(line) for line in self.cells.index]

    def places(self, heading: str) -> list[int]:
        """Columns with a heading, as it stands in the file, or the name in it without unit.

        Upper and lower case and the number of blanks do not matter.
        """
        wanted = _folded(heading)
        whole = [i for i, text in enumerate(self.headings) if _folded(text) == wanted]
        return whole or [i for i, name in enumerate(self.names) if _folded(name) == wanted]

    def numbers(
        self,
        columns: Sequence[int],
        names: Sequence[str],
        gaps: Sequence[str] = (),
        decimal: str | None = None,
    ) -> Floats:
        """Numbers (T, n) of columns, NaN where a cell of those named in `gaps` is empty or an error.

        decimal: the mark "." or "," of columns that do not show theirs.  Raises ValueError with every cell
        that is no finite number, and for columns in which both marks agree with all cells, such as 1,234,
        unless the other columns show that the mark is decimal.
        """
        places = self.path, gaps, decimal, self.separator
        numbers, wrong = numbers_of(self.cells, columns, names, str(places[0]), *places[1:])
        raise_all(wrong)
        return numbers


def read_tables(paths: Iterable[str | Path], expected: str) -> list[Table]:
    """Tables of files, of all files of folders, and of all sheets of workbooks, or one, as book.xlsx:Sheet.

    A ModelWarning names what is not read: folders in a folder and its files that are no tables, by their
    ending or because they have no rows of numbers; sheets that are hidden or have no rows of numbers.  Raises
    as `read_table`, with the errors of all files, and for a folder without tables.
    """
    tables, bad = [], []
    for path in map(Path, paths):
        files = [path]
        if path.is_dir():
            inside = sorted(file for file in path.iterdir() if file.name[0] not in ".~")
            files = [file for file in inside if file.is_file() and _has_rows(file, expected)]
            unread = ", ".join(file.name for file in inside if file not in files)
            if unread:
                warnings.warn(f"{path}: not read: {unread}", ModelWarning, stacklevel=2)
            if not files:
                bad.append(f"{path}: expected files that end in {', '.join(ENDINGS)}")
        for file in files:
            try:
                tables += _of_file(file, expected)
            except ValueError as error:
                bad.append(str(error))
    raise_all(bad)
    return tables


def read_table(path: Path, expected: str) -> Table:
    """Cells of a text file, or of the one sheet of a workbook with numbers; # begins a comment.

    Its separators are semicolons, tabs, commas, bars or blanks.  The header is the line above the first long
    run of rows of numbers, also behind #, and a row of units may follow it; the lines before are left out.
    Raises ValueError with what is expected for a file that is no text, with every row of another length, and
    with rows of numbers above the header; OSError for a file that cannot be read.
    """
    tables = _of_file(path, expected)
    if len(tables) != 1:
        names = ", ".join(table.path.name for table in tables)
        raise ValueError(f"{path}: {len(tables)} sheets with numbers: expected one of {names}")
    return tables[0]


def _has_rows(path: Path, expected: str) -> bool:
    """Whether a file of a folder may be a table: by its ending, and in a text by rows of numbers."""
    if path.suffix.lower() not in ENDINGS or path.suffix.lower() in BOOKS:
        return path.suffix.lower() in ENDINGS
    lines = [COMMENT.sub("", line).strip() for line in _text(path, expected).splitlines()]
    return _first_row(lines)[0] < len(lines)


def _of_file(path: Path, expected: str) -> list[Table]:
    """Tables of the sheets of a workbook, or the one of a text file."""
    file, colon, sheet = str(path).rpartition(":")
    book = Path(file) if colon and not path.exists() else path
    if book.suffix.lower() not in BOOKS:
        raw = _text(path, expected).splitlines()
        return [_table(path, raw, [COMMENT.sub("", line).strip(" ") for line in raw])]
    tables, empty = [], []
    shown, hidden = sheets(book, sheet if book is not path else "")
    for name, rows in shown.items():
        label = Path(f"{book}:{name}")
        table = _table(label, *_as_lines(rows)) if any(map(any, rows)) else None
        if table is not None and len(table.cells):
            tables.append(table)
        else:
            empty.append(name)
    if hidden:
        text = f"{book}: hidden sheets, not read: {', '.join(hidden)}; {book.name}:{hidden[0]} reads that one"
        warnings.warn(text, ModelWarning, stacklevel=3)
    if not tables:
        raise ValueError(f"{book}: no sheet with rows of numbers: expected {expected}")
    if empty:
        text = f"{book}: sheets without rows of numbers, not read: {', '.join(empty)}"
        warnings.warn(text, ModelWarning, stacklevel=3)
    return tables


def _as_lines(rows: Sequence[Sequence[str]]) -> tuple[list[str], list[str]]:
    """Lines of a sheet with tabs between the cells, with and without comments."""
    cells = [[cell.replace("\n", " ").replace("\t", " ") for cell in row] for row in rows]
    raw = ["\t".join(row) for row in cells]
    return raw, ["" if row and row[0].startswith("#") else line for row, line in zip(cells, raw, strict=True)]


def _table(path: Path, raw: Sequence[str], lines: list[str]) -> Table:
    """Table of the lines of a file, as they are and without comments."""
    from pandas import DataFrame

    start, mark = _first_row(lines)
    if mark == "|":
        lines = ["" if RULE.fullmatch(line) else line for line in lines]
    rows = {i: _split(text, mark) for i, text in enumerate(lines[start:], start + 1) if text.strip(";,\t |")}
    first = next(iter(rows.values()), [])
    line, head, row_of_units, hidden = _header(path, raw[:start], mark, len(first))
    parts = [header(cell) for cell in head]
    below = [*row_of_units, *[""] * len(parts)]
    units = [unit or below[i] for i, (_, unit) in enumerate(parts)]
    width = len(parts) or len(first)
    for row in rows.values():
        while len(row) > width and not row[-1]:
            row.pop()
    wanted = f"expected {width}, one for each column"
    wrong = {i: len(row) for i, row in rows.items() if len(row) != width}
    raise_all([f"{path}: line {i}: {count} values: {wanted}" for i, count in wrong.items()])
    _refuse_rows_above(path, lines[:start], mark, width, line)
    cells = DataFrame([*rows.values()], index=[*rows], columns=range(width), dtype=str)
    names = [re.sub(r"\s+", " ", name) for name, _ in parts]
    remaining = [(i, text.strip()) for i, text in enumerate(raw[:start], 1) if i != line]
    remarks = [f"line {i}: {text:.80}" for i, text in remaining if MENTIONED.search(text)]
    return Table(path, line, names, units, cells, mark, head, hidden, remarks)


def _header(path: Path, raw: Sequence[str], mark: str, width: int) -> tuple[int, list[str], list[str], bool]:
    """Line of the header, 0 without one, its cells, a row of units, and whether the header is a comment."""
    above: list[tuple[int, list[str], bool]] = []
    for i, text in enumerate(raw, 1):
        comment = HIDDEN.fullmatch(text)
        hidden = bool(comment) and not (mark and re.match(r"\s*#\s*[;,|\t]", text))
        cells = _split(comment[1] if comment and hidden else OF_HEADER.sub("", text), mark)
        while len(cells) > max(width, 1) and not cells[-1]:
            cells.pop()
        if any(cells) and not RULE.fullmatch(comment[1] if comment and hidden else text):
            above.append((i, cells, hidden))
    units: list[str] = []
    if len(above) > 1 or (above and above[0][2]):
        last = above[-1][1]
        if sum(map(bool, last)) > 1 and len(last) <= max(width, 1) and all(map(UNITS.fullmatch, last)):
            units = [cell.strip("[]() ") for cell in above.pop()[1]]
    plain = [line for line in above if not line[2]]
    full = [line for line in above if line[2] and len(line[1]) == width > 1]
    full = [line for line in full if not any(map(_is_number, line[1]))]
    behind = [line for line in full if any(unit for _, unit in map(header, line[1]))] or full
    names = plain[-1] if plain else None
    if behind and (names is None or len([cell for cell in names[1] if cell]) != width):
        names = behind[-1]
    if names is None or len(names[1]) < 2:
        if plain and any(len([cell for cell in line[1] if cell]) == width > 1 for line in above):
            wanted = f"expected {width} numbers below the header, or a comment"
            raise ValueError(f"{path}: line {plain[-1][0]}: {wanted}")
        if units:
            wanted = "expected a line of names above"
            raise ValueError(f"{path}: line {len(raw)}: units {', '.join(units)}: {wanted}")
        return 0, [], [], False
    line, head, hidden = names
    odd = [cell for cell in head if _is_number(cell)]
    if odd or all(re.match(r"[-+.,]?\d", cell) for cell in head if cell):
        text = "expected names of columns above the numbers, or a row of numbers"
        raise ValueError(f"{path}: line {line}: {(odd or head)[0]}: {text}")
    while len(head) > 1 and not head[-1]:
        head.pop()
    groups = next((cells for i, cells, _ in above if i == line - 1), []) if mark and not hidden else []
    if len({*head}) < len(head) and len(groups) > 1:
        for i, group in enumerate(groups[: len(head)]):
            groups[i] = group or groups[i - 1]
            head[i] = f"{groups[i]} {head[i]}"
    return line, head, units, hidden


def _refuse_rows_above(path: Path, lines: Sequence[str], mark: str, width: int, header: int) -> None:
    """Raise ValueError for rows of numbers above the first one, whole or, below the header, cut off."""
    for i, text in enumerate(lines, 1):
        cells = [cell for cell in (_split(text, mark) if text else []) if cell]
        if cells and all(map(_is_number, cells)) and (i > header or len(cells) == width > 1):
            wanted = "expected one table, or # before the line"
            raise ValueError(f"{path}: line {i}: numbers above those of the table: {wanted}")


def _is_number(cell: str) -> bool:
    return bool(NUMBER.fullmatch(cell)) and not cell.startswith("#")


def _folded(text: str) -> str:
    return re.sub(r"\s+", " ", text.strip(' "')).casefold()


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
    if mark == "|":
        line = re.sub(r"^\s*\||\|\s*$", "", line)
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=mark, skipinitialspace=True), [])]
    except csv.Error:  # a cell of more than 131072 characters
        return line.split(mark)


def _first_row(lines: Sequence[str]) -> tuple[int, str]:
    """First line of the longest run of lines with numbers, and the separator of its cells."""
    last = next((mark for line in reversed(lines) for mark in SEPARATORS if mark and mark in line), "")
    best = (0, len(lines), last)
    for mark in SEPARATORS:
        first, length = 0, 0
        for i, line in enumerate([*lines[:FIRST_LINES], "end"]):
            cells = [cell for cell in (_split(line, mark) if line else []) if cell]
            numbers = sum(bool(NUMBER.fullmatch(cell)) for cell in cells)
            # 0,1 0,2 has decimal commas
            commas = mark == "," and any(re.fullmatch(r"[-+.\deE]+(\s+[-+.\deE]+)+", cell) for cell in cells)
            if len(cells) > 1 and 2 * numbers >= len(cells) and not commas:
                first, length = (first if length else i), length + 1
            elif cells and not (mark == "|" and RULE.fullmatch(line)):
                best = max(best, (length, first, mark), key=lambda run: run[0])
                length = 0
    return best[1:]


def raise_all(errors: Sequence[str]) -> None:
    """Raise ValueError with a line for each error, up to MOST_ERRORS of them, if there is one."""
    if errors:
        more = [f"and {len(errors) - MOST_ERRORS} more"] if len(errors) > MOST_ERRORS else []
        raise ValueError("\n".join([*errors[:MOST_ERRORS], *more]))


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]], numbers: bool = False) -> str:
    """Table in Markdown; with `numbers` the columns after the first are aligned to the right."""
    lines = [head, ["---", *["--:" if numbers else "---"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", r"\|") for cell in line) + " |" for line in lines)
