"""Read and check shear-box tests: CSV files of slip, shear traction and dilation under a normal traction."""

from __future__ import annotations

import csv
import io
import re
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..contract import Floats
from ..material import ModelWarning
from . import checks, units
from .shear_test import ShearTest

REQUIRED = ("slip", "tau", "sigma_N")
ENVELOPE = ("slip", "peak", "residual", "sigma_N")
OPTIONAL = ("dilation", "k_N", "test")  # the first one not in an envelope
KNOWN = tuple(dict.fromkeys(REQUIRED + ENVELOPE + OPTIONAL))
ALIASES = {"s_N": "dilation"}
"""Columns of a file and their other accepted names, regardless of case; ENVELOPE: a row for each test."""

HEADER = re.compile(r"\s*([^\[(]*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")
"""Name of a column and its unit in brackets."""

LEAST_ROWS = 5
"""Smallest number of rows of a test: fewer show no stiffness, peak or residual strength."""


@dataclass(frozen=True)
class _Row:
    """Line number and values of a row as the file has them; factors: to the units of the test."""

    line: int
    values: dict[str, float | None]
    factors: Mapping[str, float]

    def get(self, column: str) -> float | None:
        """Value in the units of the test, None where there is none."""
        value = self.values.get(column)
        return None if value is None else value * self.factors.get(column, 1.0)


def read_records(
    paths: Iterable[Path],
    k_N: float | None = None,
    compression_positive: bool = False,
    target: tuple[str, str] = units.DEFAULT,
    k_T: float | None = None,
    sigma_N_path: bool = False,
) -> list[ShearTest]:
    """Read tests from CSV files with columns slip, tau, sigma_N and optional dilation (or s_N), k_N, test.

    Numbers with a unit in brackets after the name of their column are converted to the units of length and
    stress of the target; numbers without units stay as they are.  A ModelWarning names unused columns, tests
    whose rows seem to be out of order, and sizes that contradict their unit.  k_N: for files without that
    column, in the units of the target.  compression_positive: sigma_N in the files is > 0 in compression.
    k_T: stiffness of the machine, stress/length; tau/k_T is taken off the slip.  sigma_N_path: sigma_N of
    each row is prescribed as it was measured.
    Raises ValueError with file, line, column and value of an inadmissible entry, OSError for a file that
    cannot be read.
    """
    if k_N is not None and not 0.0 <= k_N < np.inf:
        raise ValueError(f"k_N = {k_N:g}: expected a finite stiffness >= 0")
    if k_T is not None and not 0.0 < k_T < np.inf:
        raise ValueError(f"k_T = {k_T:g}: expected a finite stiffness > 0")
    tests: list[ShearTest] = []
    seen: list[Path] = []
    for path in paths:
        if path.resolve() in seen:
            raise ValueError(f"{path}: given twice: expected each record once")
        seen.append(path.resolve())
        found, of_file = _read(path, target)
        for name, rows in found.items():
            where = f"{path}: test {name}" if name else str(path)
            if "tau" not in rows[0].values:
                if k_T is not None or sigma_N_path:
                    raise ValueError(f"{where}: k_T, sigma_N_path: expected columns {', '.join(REQUIRED)}")
                tests += [_envelope(path, row, k_N, compression_positive, of_file) for row in rows]
            else:
                tests.append(_test(path, where, rows, k_N, compression_positive, of_file, k_T, sigma_N_path))
    if not tests:
        raise ValueError("no test: expected a file")
    checks.of_all(tests)
    return tests


def _read(path: Path, target: tuple[str, str]) -> tuple[dict[str, list[_Row]], dict[str, str]]:
    """Rows of a file by test, in their order, and the units of the file."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: byte {error.start} is no text in UTF-8: expected a CSV file") from None
    except OSError as error:
        reason = (error.strerror or "cannot be read").lower()
        raise type(error)(f"{path}: {reason}: expected a CSV file with {', '.join(REQUIRED)}") from None
    try:
        return _rows(path, text, target)
    except csv.Error as error:
        raise ValueError(f"{path}: {error}: expected a CSV file") from None


def _rows(path: Path, text: str, target: tuple[str, str]) -> tuple[dict[str, list[_Row]], dict[str, str]]:
    """Rows of a text by test, and the units to which they are converted, none where the text has none."""
    found: dict[str, list[_Row]] = {}
    columns: list[str] | None = None
    factors: dict[str, float] = {}
    reader = csv.reader(io.StringIO(text))
    for cells in reader:
        if not any(cell.strip() for cell in cells) or cells[0].lstrip().startswith("#"):
            continue
        if columns is None:
            columns, given = _columns(path, reader.line_num, cells)
            measured = [name for name in columns if name in units.KINDS]
            factors = units.factors(f"{path}: line {reader.line_num}", measured, given, target)
            continue
        while len(cells) > len(columns) and not cells[-1].strip():
            cells.pop()
        if len(cells) != len(columns):
            raise ValueError(
                f"{path}: line {reader.line_num}: {len(cells)} values: expected {len(columns)}, "
                "one for each column"
            )
        row = dict(zip(columns, cells, strict=True))
        name = row.pop("test", "").strip()
        values = {
            column: _number(path, reader.line_num, column, text.strip())
            for column, text in row.items()
            if column in KNOWN
        }
        found.setdefault(name, []).append(_Row(reader.line_num, values, factors))
    if columns is None or not found:
        raise ValueError(f"{path}: no rows: expected a header with {', '.join(REQUIRED)}, then numbers")
    return found, dict(zip(("length", "stress"), target, strict=True)) if factors else {}


def _columns(path: Path, line: int, cells: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Names of the columns, and the units in the header by column."""
    while len(cells) > 1 and not cells[-1].strip():
        cells = cells[:-1]
    parts = [HEADER.fullmatch(cell) for cell in cells]
    names = [part[1] if part else cell.strip() for part, cell in zip(parts, cells, strict=True)]
    known = {name.lower(): name for name in (*KNOWN, *ALIASES)}
    names = [known.get(name.lower(), name) for name in names]
    names = [ALIASES.get(name, name) for name in names]
    required = ENVELOPE if {"peak", "residual"} & {*names} and "tau" not in names else REQUIRED
    missing = [name for name in required if name not in names]
    if missing and len(cells) == 1 and re.search(r"[;\t]", cells[0]):
        raise ValueError(
            f"{path}: line {line}: {cells[0].strip()!r}: expected commas between the columns, and points in "
            "numbers"
        )
    if missing:
        raise ValueError(
            f"{path}: line {line}: columns {', '.join(names)}: expected {', '.join(missing)}, too "
            f"(needed: {', '.join(required)}; as measured: {', '.join(OPTIONAL)})"
        )
    twice = [name for name in KNOWN if names.count(name) > 1]
    if twice:
        raise ValueError(f"{path}: line {line}: column {twice[0]} is there twice: expected one column")
    unused = [name for name in names if name not in required + OPTIONAL[required is ENVELOPE :]]
    if unused:
        warnings.warn(f"{path}: columns not used: {', '.join(unused)}", ModelWarning, stacklevel=6)
    given = {name: part[2] for name, part in zip(names, parts, strict=True) if part and part[2]}
    return names, {name: unit for name, unit in given.items() if name in units.KINDS}


def _number(path: Path, line: int, column: str, text: str) -> float | None:
    """Finite number of a cell; None for an empty cell of an optional column."""
    if not text and column in OPTIONAL:
        return None
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise ValueError(f"{path}: line {line}, column {column}: {text or 'empty'}: expected a finite number")
    return value


def _test(
    path: Path,
    where: str,
    rows: list[_Row],
    k_N: float | None,
    compression_positive: bool,
    of_file: dict[str, str],
    k_T: float | None,
    sigma_N_path: bool,
) -> ShearTest:
    """Test from its rows, after checks of the rows against each other."""
    if len(rows) < LEAST_ROWS:
        raise ValueError(f"{where}: {len(rows)} rows: expected at least {LEAST_ROWS}")
    sign = -1.0 if compression_positive else 1.0
    slip, tau, sigma_N = (_column(rows, name) for name in REQUIRED)
    sigma_N = sign * sigma_N
    for row in rows:
        _check_compression(path, row, sign)
    if k_T is not None:
        slip = _slip_of_the_joint(path, rows, slip, tau, k_T)
    stiffnesses = {row.get("k_N") for row in rows}
    if len(stiffnesses) > 1:
        raise ValueError(f"{where}: column k_N: {len(stiffnesses)} values: expected one a test")
    stiffness = stiffnesses.pop()
    stiffness = (k_N or 0.0) if stiffness is None else stiffness
    if stiffness < 0.0:
        raise ValueError(f"{path}: line {rows[0].line}, column k_N: {stiffness:g}: expected a stiffness >= 0")
    held = float(sigma_N[0] if sigma_N_path else np.mean(sigma_N))
    if sigma_N_path and stiffness > 0.0:
        raise ValueError(f"{where}: k_N = {stiffness:g}: expected no stiffness beside a prescribed sigma_N")
    if stiffness == 0.0 and not sigma_N_path:
        away = np.abs(sigma_N - held)
        worst = int(np.argmax(away))
        if away[worst] > checks.HELD * abs(held):
            raise ValueError(
                f"{path}: line {rows[worst].line}, column sigma_N: {sign * sigma_N[worst]:g} is more than "
                f"{checks.HELD:.0%} off the mean {sign * held:g}: expected a constant normal "
                "traction, k_N, or --sigma-N-path"
            )
    blank = [row for row in rows if row.values.get("dilation") is None]
    if 0 < len(blank) < len(rows):
        raise ValueError(
            f"{path}: line {blank[0].line}, column dilation: empty: expected a number, or none in the test"
        )
    s_N = None if blank else _column(rows, "dilation")
    if stiffness > 0.0 and np.ptp(sigma_N) > 0.0:
        # sigma_N at the start of the slip, extrapolated from the rows by k_N and the dilation
        held = float(sigma_N[0] if s_N is None else np.mean(sigma_N + stiffness * s_N))
    if not held <= 0.0:
        raise ValueError(f"{where}: sigma_N = {held:g} at the start of the slip: expected compression, <= 0")
    lines = tuple(row.line for row in rows)
    test = ShearTest(
        where, slip, tau, s_N, held, stiffness, of_file, lines, sigma_N if sigma_N_path else None
    )
    checks.of_rows(test, sigma_N)
    return test


def _envelope(
    path: Path, row: _Row, k_N: float | None, compression_positive: bool, of_file: dict[str, str]
) -> ShearTest:
    """Test of which peak and residual strength are known, and the slip of the latter."""
    sign = -1.0 if compression_positive else 1.0
    _check_compression(path, row, sign)
    slip, peak, residual, sigma_N = (row.get(name) or 0.0 for name in ENVELOPE)
    for name, value, least in (("slip", slip, 0.0), ("residual", residual, 0.0), ("peak", peak, residual)):
        if value < least or value == 0.0:
            raise ValueError(
                f"{path}: line {row.line}, column {name}: {value:g}: expected "
                + (f"at least the residual strength, {least:g}" if name == "peak" else "> 0")
            )
    stiffness = row.get("k_N")
    return ShearTest(
        f"{path}: line {row.line}",
        np.array([0.5 * slip, slip]),  # the slip of the peak is not read
        np.array([peak, residual]),
        None,
        sign * sigma_N,
        (k_N or 0.0) if stiffness is None else stiffness,
        of_file,
        (row.line, row.line),
        envelope=True,
    )


def _check_compression(path: Path, row: _Row, sign: float) -> None:
    """Raise ValueError where sigma_N of a row is tension."""
    given = row.values["sigma_N"] or 0.0
    if sign * given > 0.0:
        hint = "leave out --compression-positive" if sign < 0.0 else "or give --compression-positive"
        raise ValueError(
            f"{path}: line {row.line}, column sigma_N: {given:g} is tension: expected compression, <= 0 "
            f"({hint})"
        )


def _slip_of_the_joint(path: Path, rows: list[_Row], slip: Floats, tau: Floats, k_T: float) -> Floats:
    """Slip without that of the machine; raises ValueError where this is more than the whole slip."""
    backward = np.flatnonzero(np.diff(np.abs(slip)) < 0.0)
    first = int(np.argmax(np.abs(tau[: backward[0] + 1 if backward.size else None])))
    left: Floats = slip - tau / k_T
    if left[first] * slip[first] <= 0.0:
        raise ValueError(
            f"{path}: line {rows[first].line}: k_T = {k_T:g} takes {tau[first] / k_T:g} off the slip "
            f"{slip[first]:g}: expected more than tau/slip = {tau[first] / slip[first]:g}"
        )
    return left


def _column(rows: list[_Row], name: str) -> Floats:
    return np.array([row.get(name) for row in rows], dtype=float)
