"""Cells of tables as numbers: the decimal mark of every column, separators of thousands, empty cells."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pandas import DataFrame, Series

    from ..contract import Floats

EMPTY = r"(?i:|nan|n/?a|null|none|[-\u2013]+|#[^\s\d]\S*)"
"""Cells without a number, such as #DIV/0!."""

GROUPS = re.compile(r"(?<=\d)['\u2019\s\u00a0\u202f](?=\d{3}(?!\d))")
"""An apostrophe or a blank between the thousands of a number."""

PLAIN = r"[-+]?\d+([eE][-+]?\d+)?"
"""A number without a mark."""

WIDE = re.compile("[\u3000\u3300-\u33ff\uff00-\uffef]")
"""Brackets, commas, letters, digits and units that are as wide as a Chinese character."""

COUNTRIES = (";", "\t")
"""Separators of files of countries with decimal commas, too."""

OTHER = {".": ",", ",": "."}
WORDS = {".": "decimal points", ",": "decimal commas"}


def half_width(text: str) -> str:
    """Text with plain forms of what is as wide as a Chinese or Japanese character."""
    return WIDE.sub(lambda wide: unicodedata.normalize("NFKC", wide[0]), text)


def _decimal(mark: str) -> str:
    """A number with this mark, which is the decimal one, and nothing else."""
    return rf"[-+]?(\d+\{mark}\d*|\{mark}\d+)([eE][-+]?\d+)?"


def _thousands(mark: str) -> str:
    """A number in which this mark may separate the thousands, once, such as 30.000."""
    return rf"[-+]?[1-9]\d{{0,2}}\{mark}\d{{3}}"


def _grouped(mark: str) -> str:
    """A number in which this mark, the decimal one, comes after thousands, or the other one comes twice."""
    between = OTHER[mark]
    return rf"[-+]?[1-9]\d{{0,2}}((\{between}\d{{3}})+\{mark}\d*|(\{between}\d{{3}}){{2,}})([eE][-+]?\d+)?"


def _shown(column: Series) -> str | None:
    """Decimal mark that more cells of a column have beyond doubt than have the other one, or None."""
    points, commas = (
        (
            (column.str.fullmatch(_decimal(mark)) & ~column.str.fullmatch(_thousands(mark)))
            | column.str.fullmatch(_grouped(mark))
        ).sum()
        for mark in ".,"
    )
    return None if points == commas else "." if points > commas else ","


def numbers_of(
    cells: DataFrame,
    columns: Sequence[int],
    names: Sequence[str],
    where: str,
    gaps: Sequence[str] = (),
    decimal: str | None = None,
    separator: str = ",",
) -> tuple[Floats, list[str]]:
    """Numbers (T, n) of columns of text and, for each cell that is none, a message.

    Every column shows its decimal mark itself, or has that of all others.  30.000 is thirty beside 0.5;
    beside 1,5, or in a file that shows no mark, its message asks for `decimal`, the mark of such columns.  A
    comma or point separates thousands in a column that has 1,234.5 or 1,234,567, or as `decimal` says.
    """
    import numpy as np
    import pandas as pd

    texts = cells[list(columns)].set_axis(list(names), axis=1)
    marks = ";" if separator in COUNTRIES or decimal else ""
    if not marks and not any(cells[column].str.contains(",", regex=False).any() for column in cells):
        # points alone, in a file whose separator is that of countries with decimal points
        fine = texts.apply(lambda column: column.str.fullmatch(r"[-+.eE\d]+")).to_numpy(dtype=bool)
        numbers = texts.apply(pd.to_numeric, errors="coerce").to_numpy(dtype=float)
        if (fine & np.isfinite(numbers)).all():
            return numbers, []
    plain = cells.apply(lambda column: column.str.replace(GROUPS, "", regex=True))
    shown = {column: _shown(plain[column]) for column in plain}
    everywhere = {*shown.values()} - {None}
    if not everywhere and separator not in COUNTRIES and not _commas(plain):
        everywhere = {"."}
    numbers, wrong = np.full(texts.shape, np.nan), []
    for j, (column, name) in enumerate(zip(columns, names, strict=True)):
        text = plain[column]
        empty = text.str.fullmatch(EMPTY)
        doubtful = {mark: text.str.fullmatch(_thousands(mark)) for mark in ".,"}
        agreed = next(iter(everywhere)) if len(everywhere) == 1 else None
        mark = shown[column] or decimal or agreed or "."
        grouped = bool(text.str.fullmatch(_grouped(mark)).any()) or (decimal == mark)
        good = (
            text.str.fullmatch(PLAIN)
            | text.str.fullmatch(_decimal(mark))
            | text.str.fullmatch(_grouped(mark))
        )
        asks = pd.Series(False, index=text.index)
        if shown[column] is None and decimal is None and agreed is None:
            asks = doubtful["."] | doubtful[","]
        elif not grouped:
            asks = doubtful[OTHER[mark]]
        else:
            good |= doubtful[OTHER[mark]]
        good &= ~asks
        clean = text.str.replace(OTHER[mark], "", regex=False).str.replace(mark, ".", regex=False)
        numbers[:, j] = pd.to_numeric(clean.where(good), errors="coerce").to_numpy(dtype=float)
        bad = ~np.isfinite(numbers[:, j]) & ~(empty.to_numpy() & (name in gaps))
        wanted = "expected a finite number"
        if mark == ",":
            wanted += f" with {WORDS[mark]}"
        if shown[column]:
            reason = f"the column has {WORDS[mark]}"
        elif agreed:
            reason = f"the other columns have {WORDS[mark]}"
        else:
            reason = "the other columns differ" if everywhere else "no column shows the mark"
        asked = False
        for i in np.flatnonzero(bad).tolist():
            cell = texts.iat[i, j] or "empty"
            place = f"{where}: line {cells.index[i]}, column {name}: {cell}"
            if asks.iat[i]:
                if not asked:
                    wrong.append(
                        f"{place} may be a decimal number, or have thousands; {reason}: expected numbers "
                        "that show the decimal mark, or --decimal comma or point for such columns"
                    )
                asked = True
            else:
                wrong.append(f"{place}: {wanted}")
    return numbers, wrong


def _commas(cells: DataFrame) -> bool:
    """Whether a cell has a comma that may be decimal."""
    forms = [_thousands(","), _decimal(",")]
    return any(cells[column].str.fullmatch(form).any() for column in cells for form in forms)
