"""Sheets of .xlsx workbooks as cells of text, by openpyxl."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from ..installed import needed

Cells = dict[str, list[list[str]]]


def sheets(path: Path, wanted: str = "") -> tuple[Cells, list[str], dict[str, list[int]]]:
    """Cells of the sheets of a workbook by name, as text, without hidden ones, whose names come second.

    Third come the lines of each sheet that are hidden, as those that a filter leaves out, but have cells.

    wanted: name of the one sheet that is read, which may be hidden.

    A number has a decimal point, whatever the format of its cell.  Raises ValueError for a file that is no
    workbook, for a sheet that is not there, and for a formula whose value the file does not have.
    """
    needed("tools", "openpyxl")
    from openpyxl import load_workbook

    path.stat()
    try:
        values = load_workbook(path, data_only=True)
        formulas = load_workbook(path, data_only=False)
    except Exception as error:  # openpyxl raises those of zipfile, of XML and its own
        raise ValueError(f"{path}: {type(error).__name__}: expected a workbook, .xlsx") from None
    names = [sheet.title for sheet in values.worksheets]
    hidden = [sheet.title for sheet in values.worksheets if sheet.sheet_state != "visible"]
    if wanted and wanted not in names:
        raise ValueError(f"{path}: sheet {wanted}: expected one of {', '.join(names)}")
    texts, lines = {}, {}
    for name in [wanted] if wanted else [name for name in names if name not in hidden]:
        rows = values[name].iter_rows(values_only=True), formulas[name].iter_rows(values_only=True)
        cells: list[list[str]] = []
        for i, (line, written) in enumerate(zip(*rows, strict=True), 1):
            for j, (value, formula) in enumerate(zip(line, written, strict=True), 1):
                if value is None and formula is not None:
                    text = f"line {i}, cell {j}: {formula}: expected the value of the formula, too"
                    raise ValueError(f"{path}:{name}: {text}; open the file and save it")
            cells.append([_text(value) for value in line])
        texts[name] = cells
        shown = formulas[name].row_dimensions
        lines[name] = [i for i, row in enumerate(cells, 1) if any(row) and i in shown and shown[i].hidden]
    return texts, [] if wanted else hidden, lines


def _text(value: Any) -> str:
    """Text of a cell; a number with three decimals gets a fourth one, so that no mark is in doubt."""
    if value is None:
        return ""
    if isinstance(value, str):
        return value.strip()
    text = str(value)
    return f"{text}0" if re.fullmatch(r"-?\d+\.\d{3}", text) else text
