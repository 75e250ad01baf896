"""Read and check shear-box tests: CSV files of slip, shear traction and dilation under a normal traction."""

from __future__ import annotations

import csv
import io
import re
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..contract import Floats
from ..material import ModelWarning

REQUIRED = ("slip", "tau", "sigma_N")
OPTIONAL = ("dilation", "k_N", "test")
ALIASES = {"s_N": "dilation"}
"""Columns of a file and their other accepted names, regardless of case."""

HEADER = re.compile(r"\s*([^\[(]*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")
"""Name of a column and its unit in brackets."""

SAME_UNITS = (("MPa", "N/mm2"), ("kPa", "kN/m2"), ("Pa", "N/m2"), ("MPa/mm", "N/mm3"), ("kPa/m", "kN/m3"))
"""Other accepted spellings of each unit."""

LEAST_ROWS = 5
"""Smallest number of rows of a test: fewer show no stiffness, peak or residual strength."""

LARGEST_RATIO = 1.0e3
"""Largest ratio of two stresses in a file: more indicates mixed units, such as MPa and kPa."""

STEEPEST = 20.0
"""Largest ratio of dilation to slip: that of planes of 87 degrees."""

HELD = 0.05
"""Largest relative variation of a normal traction that counts as constant."""

SPRING = 0.7
"""Largest fraction of a change of the normal traction that k_N times the dilation need not explain."""

OFFSET = 0.5
"""Largest first dilation, as a fraction of its range, that counts as measured from the start of slip."""

LONGEST_PATH, MOST_TURNS = 5.0, 1.0 / 3.0
"""Length of the slip path over its range, and fraction of rows with a reversal.

If both are exceeded, the rows are taken to be out of order.
"""


@dataclass(frozen=True, eq=False)
class ShearTest:
    """One test: slip (T,) and s_N (T,), None where not measured, length; tau (T,), stress.

    s_N counts from the start of the slip, opening positive.  sigma_N: normal traction there, stress, <= 0;
    k_N: normal stiffness of the box, stress/length, 0 where sigma_N is constant.  name: file and test.
    units: of length and stress where the file has them.  Raises ValueError for inadmissible data.
    """

    name: str
    slip: Floats
    tau: Floats
    s_N: Floats | None
    sigma_N: float
    k_N: float = 0.0
    units: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check shapes and values."""
        for name, values in (("slip", self.slip), ("tau", self.tau), ("s_N", self.s_N)):
            if values is None:
                continue
            if values.shape != (self.slip.size,) or not np.all(np.isfinite(values)):
                raise ValueError(
                    f"{self.name}: {name} has shape {values.shape}: expected finite numbers of shape "
                    f"({self.slip.size},)"
                )
            if name != "s_N" and not np.ptp(values) > 0.0:
                raise ValueError(
                    f"{self.name}: column {name} is {values[0]:g} in all rows: expected values that change"
                )
        if not -np.inf < self.sigma_N <= 0.0:
            raise ValueError(f"{self.name}: sigma_N = {self.sigma_N:g}: expected a finite compression, <= 0")
        if not 0.0 <= self.k_N < np.inf:
            raise ValueError(f"{self.name}: k_N = {self.k_N:g}: expected a finite stiffness >= 0")

    @property
    def turns(self) -> list[float]:
        """Slips at the reversals, and the last slip."""
        path = np.concatenate([[0.0], self.slip])
        path = path[np.concatenate([[True], np.diff(path) != 0.0])]
        inside = np.flatnonzero(np.diff(np.sign(np.diff(path)))) + 1
        return [*path[inside].tolist(), float(path[-1])]


@dataclass(frozen=True)
class _Row:
    """Line number and values of a row."""

    line: int
    values: dict[str, float | None]


def read_records(
    paths: Iterable[Path], k_N: float | None = None, compression_positive: bool = False
) -> list[ShearTest]:
    """Read tests from CSV files with columns slip, tau, sigma_N and optional dilation (or s_N), k_N, test.

    Units in brackets after the names must agree.  A ModelWarning names unused columns and tests whose rows
    seem to be out of order.  k_N: for files without that column.  compression_positive: sigma_N in the files
    is positive in compression.  Raises ValueError with file, line, column and value of an inadmissible entry,
    OSError for a file that cannot be read.
    """
    if k_N is not None and not 0.0 <= k_N < np.inf:
        raise ValueError(f"k_N = {k_N:g}: expected a finite stiffness >= 0")
    tests: list[ShearTest] = []
    seen: list[Path] = []
    for path in paths:
        if path.resolve() in seen:
            raise ValueError(f"{path}: given twice: expected each record once")
        seen.append(path.resolve())
        found, units = _read(path)
        for name, rows in found.items():
            where = f"{path}: test {name}" if name else str(path)
            tests.append(_test(path, where, rows, k_N, compression_positive, units))
    if not tests:
        raise ValueError("no test: expected a file")
    check_units(tests)
    return tests


def _read(path: Path) -> tuple[dict[str, list[_Row]], dict[str, str]]:
    """Rows of a file by test, in their order, and the units of the file."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: byte {error.start} is no text in UTF-8: expected a CSV file") from None
    except OSError as error:
        reason = (error.strerror or "cannot be read").lower()
        raise type(error)(f"{path}: {reason}: expected a CSV file with {', '.join(REQUIRED)}") from None
    try:
        return _rows(path, text)
    except csv.Error as error:
        raise ValueError(f"{path}: {error}: expected a CSV file") from None


def _rows(path: Path, text: str) -> tuple[dict[str, list[_Row]], dict[str, str]]:
    """Rows of a text by test, and the units of the text."""
    found: dict[str, list[_Row]] = {}
    columns: list[str] | None = None
    units: dict[str, str] = {}
    reader = csv.reader(io.StringIO(text))
    for cells in reader:
        if not any(cell.strip() for cell in cells) or cells[0].lstrip().startswith("#"):
            continue
        if columns is None:
            columns, units = _columns(path, reader.line_num, cells)
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
            if column in REQUIRED + OPTIONAL
        }
        found.setdefault(name, []).append(_Row(reader.line_num, values))
    if columns is None or not found:
        raise ValueError(f"{path}: no rows: expected a header with {', '.join(REQUIRED)}, then numbers")
    return found, units


def _columns(path: Path, line: int, cells: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Names of the columns, and the units of length and stress in the header."""
    while len(cells) > 1 and not cells[-1].strip():
        cells = cells[:-1]
    parts = [HEADER.fullmatch(cell) for cell in cells]
    names = [part[1] if part else cell.strip() for part, cell in zip(parts, cells, strict=True)]
    known = {name.lower(): name for name in (*REQUIRED, *OPTIONAL, *ALIASES)}
    names = [known.get(name.lower(), name) for name in names]
    names = [ALIASES.get(name, name) for name in names]
    missing = [name for name in REQUIRED if name not in names]
    if missing and len(cells) == 1 and re.search(r"[;\t]", cells[0]):
        raise ValueError(
            f"{path}: line {line}: {cells[0].strip()!r}: expected commas between the columns, and points in "
            "numbers"
        )
    if missing:
        raise ValueError(
            f"{path}: line {line}: columns {', '.join(names)}: expected {', '.join(missing)}, too "
            f"(needed: {', '.join(REQUIRED)}; as measured: {', '.join(OPTIONAL)})"
        )
    twice = [name for name in REQUIRED + OPTIONAL if names.count(name) > 1]
    if twice:
        raise ValueError(f"{path}: line {line}: column {twice[0]} is there twice: expected one column")
    unused = [name for name in names if name not in REQUIRED + OPTIONAL]
    if unused:
        warnings.warn(f"{path}: columns not used: {', '.join(unused)}", ModelWarning, stacklevel=6)
    given = {name: unit_name(part[2]) for name, part in zip(names, parts, strict=True) if part and part[2]}
    return names, _units(f"{path}: line {line}", given)


def unit_name(text: str) -> str:
    """Standard spelling of a unit: MPa for N/mm^2."""
    plain = text.replace("\N{SUPERSCRIPT TWO}", "2").replace("\N{SUPERSCRIPT THREE}", "3").replace("^", "")
    plain = plain.replace(" ", "")
    return next((first for first, *others in SAME_UNITS if plain in others), plain)


def _units(where: str, given: dict[str, str]) -> dict[str, str]:
    """Units of length and stress in the header; ValueError where they disagree."""
    units = {}
    for kind, names in (("length", ("slip", "dilation")), ("stress", ("tau", "sigma_N"))):
        told = [name for name in names if name in given]
        if len({given[name] for name in told}) > 1:
            first, second = told
            raise ValueError(
                f"{where}: {first} [{given[first]}], {second} [{given[second]}]: expected one unit of {kind}"
            )
        if told:
            units[kind] = given[told[0]]
    if len(units) == 2 and given.get("k_N", expected := f"{units['stress']}/{units['length']}") != expected:
        raise ValueError(f"{where}: k_N [{given['k_N']}]: expected [{expected}], stress/length")
    return units


def _number(path: Path, line: int, column: str, text: str) -> float | None:
    """Finite number of a cell; None for an empty cell of an optional column."""
    if not text and column not in REQUIRED:
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
    units: dict[str, str],
) -> ShearTest:
    """Test from its rows, after checks of the rows against each other."""
    if len(rows) < LEAST_ROWS:
        raise ValueError(f"{where}: {len(rows)} rows: expected at least {LEAST_ROWS}")
    sign = -1.0 if compression_positive else 1.0
    slip, tau, sigma_N = (_column(rows, name) for name in REQUIRED)
    sigma_N = sign * sigma_N
    pulled = np.flatnonzero(sigma_N > 0.0)
    if pulled.size > 0:
        row = rows[pulled[0]]
        hint = (
            "leave out --compression-positive" if compression_positive else "or give --compression-positive"
        )
        raise ValueError(
            f"{path}: line {row.line}, column sigma_N: {row.values['sigma_N']:g} is tension: expected "
            f"compression, <= 0 ({hint})"
        )
    stiffnesses = {row.values.get("k_N") for row in rows}
    if len(stiffnesses) > 1:
        raise ValueError(f"{where}: column k_N: {len(stiffnesses)} values: expected one a test")
    stiffness = stiffnesses.pop()
    stiffness = (k_N or 0.0) if stiffness is None else stiffness
    if stiffness < 0.0:
        raise ValueError(f"{path}: line {rows[0].line}, column k_N: {stiffness:g}: expected a stiffness >= 0")
    held = float(np.mean(sigma_N))
    if stiffness == 0.0:
        away = np.abs(sigma_N - held)
        worst = int(np.argmax(away))
        if away[worst] > HELD * abs(held):
            raise ValueError(
                f"{path}: line {rows[worst].line}, column sigma_N: {rows[worst].values['sigma_N']:g} is more "
                f"than {HELD:.0%} off the mean {sign * held:g}: expected a constant normal traction, or k_N"
            )
    blank = [row for row in rows if row.values.get("dilation") is None]
    if 0 < len(blank) < len(rows):
        raise ValueError(
            f"{path}: line {blank[0].line}, column dilation: empty: expected a number, or none in the test"
        )
    s_N = None if blank else _column(rows, "dilation")
    if s_N is not None and np.ptp(s_N) > STEEPEST * np.ptp(slip):
        worst = int(np.argmax(np.abs(s_N)))
        raise ValueError(
            f"{path}: line {rows[worst].line}, column dilation: {s_N[worst]:g} over slips up to "
            f"{np.abs(slip).max():g}: expected the unit of slip (at most {STEEPEST:g} times it)"
        )
    if stiffness > 0.0 and np.ptp(sigma_N) > 0.0:
        # sigma_N at the start of the slip, extrapolated from the rows by k_N and the dilation
        held = float(sigma_N[0] if s_N is None else np.mean(sigma_N + stiffness * s_N))
    if not held <= 0.0:
        raise ValueError(f"{where}: sigma_N = {held:g} at the start of the slip: expected compression, <= 0")
    test = ShearTest(where, slip, tau, s_N, held, stiffness, units)
    _check_start(path, rows, test)
    if stiffness > 0.0:
        _check_spring(test, sigma_N)
    _warn_of_order(test)
    return test


def _check_start(path: Path, rows: list[_Row], test: ShearTest) -> None:
    """Raise ValueError where the dilation is not measured from the start of the slip."""
    if test.s_N is None:
        return
    first, reached = float(test.s_N[0]), STEEPEST * abs(float(test.slip[0]))
    if abs(first) > reached + OFFSET * float(np.ptp(test.s_N)):
        raise ValueError(
            f"{path}: line {rows[0].line}, column dilation: {first:g} at slip {test.slip[0]:g}: expected the "
            "change since the start of the slip"
        )


def _check_spring(test: ShearTest, sigma_N: Floats) -> None:
    """Raise ValueError where the change of the measured sigma_N differs from -k_N times the dilation."""
    if test.s_N is None or np.ptp(sigma_N) <= HELD * float(np.abs(sigma_N).max()):
        return
    expected = -test.k_N * (test.s_N - test.s_N[0])
    left = float(np.abs(sigma_N - sigma_N[0] - expected).max())
    if left > SPRING * max(float(np.ptp(sigma_N)), float(np.ptp(expected))):
        raise ValueError(
            f"{test.name}: column k_N: {test.k_N:g} times the dilation changes sigma_N by up to "
            f"{np.ptp(expected):g}, the column by {np.ptp(sigma_N):g}: expected stress/length in the units "
            "of tau and slip, and dilation > 0 where it opens"
        )


def _warn_of_order(test: ShearTest) -> None:
    """Issue a ModelWarning where the slip reverses so often that the rows seem to be out of order."""
    way = float(np.abs(np.diff([0.0, *test.slip])).sum() / np.ptp([0.0, *test.slip]))
    turns = len(test.turns) - 1
    if way > LONGEST_PATH and turns > MOST_TURNS * test.slip.size:
        text = (
            f"{test.name}: the slip reverses at {turns} of {test.slip.size} rows and covers {way:.0f} "
            "times its range: expected the rows in the order of the test"
        )
        warnings.warn(text, ModelWarning, stacklevel=5)


def _column(rows: list[_Row], name: str) -> Floats:
    return np.array([row.values[name] for row in rows], dtype=float)


def check_units(tests: Sequence[ShearTest]) -> None:
    """Raise ValueError where the stresses differ too much in size, or the units of the files differ."""
    for kind in ("length", "stress"):
        told = {test.units[kind]: test.name for test in tests if kind in test.units}
        if len(told) > 1:
            texts = ", ".join(f"{unit} in {name}" for unit, name in told.items())
            raise ValueError(f"units of {kind}: {texts}: expected one unit")
    pressed = max(abs(test.sigma_N) for test in tests)
    highest = max(tests, key=lambda test: np.abs(test.tau).max())
    tau = float(np.abs(highest.tau).max())
    if pressed > 0.0 and not 1.0 / LARGEST_RATIO <= tau / pressed <= LARGEST_RATIO:
        raise ValueError(
            f"{highest.name}: column tau: {tau:g} where |sigma_N| is up to {pressed:g}: expected the same "
            f"unit (a ratio from {1.0 / LARGEST_RATIO:g} to {LARGEST_RATIO:g})"
        )
    for test in tests:
        if test.k_N == 0.0 or test.s_N is None:
            continue
        change, most = test.k_N * float(np.ptp(test.s_N)), LARGEST_RATIO * max(tau, pressed)
        if change > most:
            raise ValueError(
                f"{test.name}: column k_N: {test.k_N:g} changes sigma_N by {change:g}: expected stress/"
                f"length in the units of tau and slip (a change up to {most:g})"
            )
