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
from .cells import half_width, numbers_of
from .units import MENTIONED, UNITS, header, size
from .workbooks import sheets

if TYPE_CHECKING:
    from pandas import DataFrame

    from ..contract import Floats

__all__ = ["Table", "markdown", "raise_all", "read_table", "read_tables", "size", "warn_if"]

MISSING = r"\*+|(?i:nan|n/a|null|bad|no[ _]?data|missing|masked|invalid)"
"""Words in place of a missing number."""

NUMBER = re.compile(rf"[-+]?(\d[\d.,'\u2019\s]*|[.,]\d+)([eE][-+]?\d+)?|#\S.*|{MISSING}")
"""A number in any notation, an error of a spreadsheet, or a word in place of a number."""

COMMENT = re.compile(r"^\s*//.*|(^|\s)#(?!\u00a1?[A-Z]+(/\w+)?[!?]?(\s|[;,|]|$)).*")
OF_HEADER = re.compile(r"(^|\s)#(?!\s*([;,|\t\"[(]|$)).*")
"""A comment, but for #DIV/0! and other errors of spreadsheets, or for # in the name of a column."""

HIDDEN = re.compile(r"\s*(?:[#%!]+|//)\s*(.*)")
"""A line that is a comment, as that which numpy.savetxt and CloudCompare put above their numbers."""

RULE = re.compile(r"[-+|:=\s]+")
"""A line below the header of a table in Markdown or of a database."""

QUOTED = re.compile(r'(?:^|(?<=[;,|\t]))"[^"]{,80}"(?=[;,|\t]|$)', re.MULTILINE)
"""A quoted cell."""

SEPARATORS = ("|", ";", "\t", ",", "")
"""Separators of cells, in the order in which they are tried; the empty one stands for blanks."""

FIRST_LINES = 400
"""Lines in which the header is searched."""

OF_EXCEL_97 = b"\xd0\xcf\x11\xe0"
"""Start of a workbook that is no .xlsx."""

CHINESE = re.compile(rb"(?<![\x80-\xff])[\xa1-\xd7][\xa1-\xfe]")
"""Start of a word of GB 18030; words of other languages in a code page begin with a letter from D8 on."""

SECTION = re.compile(r"\s*\[([^\]]+)\]\s*")
ENTRY = re.compile(r"\s*([^=]+?)\s*=\s*(.*)")
"""Lines of a file of sections with entries, such as .ini."""

LEAST_VALUES = 3
"""Smallest number of values of a row that is a column."""

MOST_ERRORS = 10
"""Largest number of errors of a file that are listed."""

BOOKS = (".xlsx", ".xlsm")
ENDINGS = (".csv", ".txt", ".tsv", ".dat", ".asc", ".prn", ".md", ".ini", *BOOKS)
"""Endings of workbooks, and of the files of a folder that are read."""


@dataclass(frozen=True)
class Table:
    """Cells (T, C) of a file as text, by its lines; line: of the header, 0 without one, with names and units.

    Of a file with rows in place of columns the lines are the places in the rows.

    path: the file, for messages, with the sheet of a workbook.  separator: of the cells, empty for blanks.
    headings: the cells of the header as they stand in the file.  hidden: the header is a comment.
    remarks: lines above the rows that may say units, where the header has none.  counted: a line above the
    rows has their number.
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
    counted: bool = False

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
        exact = [i for i, text in enumerate(self.headings) if _folded(text) == wanted]
        return exact or [i for i, name in enumerate(self.names) if _folded(name) == wanted]

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

    Sections of a file with [sections] are as sheets.  A ModelWarning names what is not read: folders in a
    folder and its files that are no tables, by their ending or because they have no rows of numbers; sheets
    that are hidden or have no rows of numbers; and the encoding of a text that is not UTF-8.  Raises
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

    Its separators are semicolons, tabs, commas, bars or blanks.  Lines with a name and then numbers alone are
    columns.  The header is the line above the first long
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
    file, colon, part = str(path).rpartition(":")
    workbook = path if path.exists() or not colon else Path(file)
    wanted = part if workbook is not path else ""
    if workbook.suffix.lower() not in BOOKS:
        raw = _text(workbook, expected).splitlines()
        if SECTION.fullmatch(next(filter(None, map(str.strip, raw)), "")):
            return _of_sections(workbook, raw, wanted)
        if wanted:
            raise ValueError(f"{path}: {part}: expected a workbook, or a file with [sections]")
        return [_table(path, raw, [COMMENT.sub("", line).strip(" ") for line in raw])]
    return _of_book(workbook, wanted, expected)


def _of_sections(path: Path, raw: Sequence[str], wanted: str) -> list[Table]:
    """Tables of the sections whose entries are lists of numbers of the same length."""
    sections: dict[str, list[tuple[str, list[str]]]] = {}
    for line in raw:
        if heading := SECTION.fullmatch(line):
            entries = sections.setdefault(heading[1].strip(), [])
        elif entry := ENTRY.fullmatch(line):
            entries.append((entry[1], [value.strip() for value in re.split("[,;]", entry[2].strip(' "'))]))
    if wanted and wanted not in sections:
        raise ValueError(f"{path}: section {wanted}: expected one of {', '.join(sections)}")
    tables, unread = [], []
    for name, entries in sections.items():
        lists = [
            entry for entry in entries if len(entry[1]) >= LEAST_VALUES and all(map(_is_number, entry[1]))
        ]
        if len(lists) > 1 and wanted in ("", name):
            tables.append(_of_rows(Path(f"{path}:{name}"), lists))
        else:
            lists = []
        used = [entry[0] for entry in lists]
        unread += [f"{name}: {entry[0]}" for entry in entries if entry[0] not in used]
    if not tables:
        raise ValueError(f"{path}: no section with lists of numbers: expected two or more in one section")
    if unread and not wanted:
        warnings.warn(f"{path}: not read: {', '.join(unread)}", ModelWarning, stacklevel=4)
    return tables


def _of_rows(path: Path, rows: Sequence[tuple[str, list[str]]]) -> Table:
    """Table whose columns are rows, each with its name and cells."""
    from pandas import DataFrame

    count = len(rows[0][1])
    wanted = f"expected {count}, as {rows[0][0]} has"
    raise_all([f"{path}: {name}: {len(row)} values: {wanted}" for name, row in rows if len(row) != count])
    parts = [header(name) for name, _ in rows]
    cells = DataFrame([row for _, row in rows], dtype=str).T
    cells.index = range(1, count + 1)
    names, units = [name for name, _ in parts], [unit for _, unit in parts]
    return Table(path, 1, names, units, cells, "", [name for name, _ in rows])


def _rows_with_names(lines: Sequence[str], mark: str) -> list[tuple[str, list[str]]]:
    """Rows with a name and at least LEAST_VALUES numbers; none where a line is no such row."""
    rows = []
    for line in filter(None, map(str.strip, lines)):
        cells = _split(line, mark)
        first = next((i for i, cell in enumerate(cells) if _is_number(cell)), 0)
        if not (0 < first <= len(cells) - LEAST_VALUES and all(map(_is_number, cells[first:]))):
            return []
        name = " ".join(cells[:first])
        if mark and first == 2 and UNITS.fullmatch(cells[1]):
            name = f"{cells[0]} [{cells[1].strip('[]() ')}]"
        rows.append((name, cells[first:]))
    return rows if len({name for name, _ in rows}) == len(rows) > 1 else []


def _of_book(book: Path, sheet: str, expected: str) -> list[Table]:
    """Tables of the sheets of a workbook, or of one."""
    tables, empty = [], []
    shown, hidden, lines = sheets(book, sheet)
    for name, rows in shown.items():
        label = Path(f"{book}:{name}")
        table = _table(label, *_as_lines(rows)) if any(map(any, rows)) else None
        if table is not None and len(table.cells):
            tables.append(table)
            within = [str(line) for line in lines[name] if line in table.cells.index]
            first = ", ".join(within[:MOST_ERRORS])
            warn_if(within, f"{label}: hidden rows are read, too: {len(within)} (line {first})")
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
    cells = [[half_width(cell).replace("\n", " ").replace("\t", " ") for cell in row] for row in rows]
    raw = ["\t".join(row) for row in cells]
    return raw, ["" if row and row[0].startswith("#") else line for row, line in zip(cells, raw, strict=True)]


def _table(path: Path, raw: Sequence[str], lines: list[str]) -> Table:
    """Table of the lines of a file, as they are and without comments."""
    from pandas import DataFrame

    start, mark = _first_row(lines)
    if mark == "|":
        lines = ["" if RULE.fullmatch(line) else line for line in lines]
    if not any(map(str.strip, lines[:start])) and (named := _rows_with_names(lines, mark)):
        return _of_rows(path, named)
    rows = {i: _split(text, mark) for i, text in enumerate(lines[start:], start + 1) if text.strip(";,\t |")}
    first = next(iter(rows.values()), [])
    above = lines[:start]
    counted = _count_above(path, above, len(rows))
    shown = [
        text if above[i].strip() or text.strip()[:1] in "#/" else "" for i, text in enumerate(raw[:start])
    ]
    line, head, row_of_units, hidden = _header(path, shown, mark, len(first))
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
    _refuse_rows_above(path, above, mark, width, line)
    cells = DataFrame([*rows.values()], index=[*rows], columns=range(width), dtype=str)
    names = [re.sub(r"\s+", " ", name) for name, _ in parts]
    remaining = [(i, text.strip()) for i, text in enumerate(raw[:start], 1) if i != line]
    remarks = [f"line {i}: {text:.80}" for i, text in remaining if MENTIONED.search(text)]
    return Table(path, line, names, units, cells, mark, head, hidden, remarks, counted)


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


def _count_above(path: Path, lines: list[str], rows: int) -> bool:
    """Whether the last line above the rows has their number alone; raises ValueError for another number."""
    last = next((i for i in reversed(range(len(lines))) if lines[i].strip()), None)
    if last is None or not re.fullmatch(r"\d+", lines[last].strip()):
        return False
    count = int(lines[last])
    if count != rows:
        wanted = f"expected {count} rows of numbers below their number, or # before it"
        raise ValueError(f"{path}: line {last + 1}: {rows} rows: {wanted}")
    lines[last] = ""
    return True


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
    return re.sub(r"\s+", " ", half_width(text).strip(' "')).casefold()


def _text(path: Path, expected: str) -> str:
    """Text of a file in UTF-8, UTF-16, GB 18030 or the code page of spreadsheets, in plain forms.

    A ModelWarning names the encoding of a file that is not UTF-8.  Raises ValueError or OSError.
    """
    data = path.read_bytes()
    names = {"utf-8-sig": "", "gb18030": "GB 18030", "cp1252": "Windows-1252"}
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        names = {"utf-16": "UTF-16"}
    elif not CHINESE.search(data):
        del names["gb18030"]
    for encoding, name in names.items():
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            if name:
                told = f"{path} is not UTF-8: read as {name}; expected UTF-8 where names or units are wrong"
                warnings.warn(told, ModelWarning, stacklevel=5)
            # a line break within a quoted cell; the other lines keep their numbers
            joined = QUOTED.sub(lambda cell: cell[0].replace("\n", " "), text.replace("\r\n", "\n"))
            joined = half_width(joined).replace("\N{MINUS SIGN}", "-")
            return "\n" * (text.count("\n") - joined.count("\n")) + joined
    book = "; it is a workbook of Excel 97: save it as .xlsx" if data.startswith(OF_EXCEL_97) else ""
    raise ValueError(f"{path} is no text: expected {expected}{book}")


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


def warn_if(odd: object, text: str) -> None:
    """Give a ModelWarning where something is odd."""
    if odd:
        warnings.warn(text, ModelWarning, stacklevel=2)


def raise_all(errors: Sequence[str]) -> None:
    """Raise ValueError with a line for each error, up to MOST_ERRORS of them, if there is one."""
    if errors:
        more = [f"and {len(errors) - MOST_ERRORS} more"] if len(errors) > MOST_ERRORS else []
        raise ValueError("\n".join([*errors[:MOST_ERRORS], *more]))


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]], numbers: bool = False) -> str:
    """Table in Markdown; with `numbers` the columns after the first are aligned to the right."""
    lines = [head, ["---", *["--:" if numbers else "---"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", r"\|") for cell in line) + " |" for line in lines)
