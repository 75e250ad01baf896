"""Shear-box records: CSV files of slip, shear traction and dilation under a normal traction, checked."""

from __future__ import annotations

import csv
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .contract import Floats
from .material import ModelWarning

REQUIRED = ("slip", "tau", "sigma_N")
OPTIONAL = ("dilation", "k_N", "test")
ALIASES = {"s_N": "dilation"}
"""Columns of a file, and other names for them."""

LEAST_ROWS = 5
"""A test of fewer rows shows neither a stiffness nor a peak nor a residual."""

LARGEST_RATIO = 1.0e3
"""Between stresses of a record: kPa for MPa is just that, Pa for MPa far more."""

STEEPEST = 20.0
"""Dilation over slip: planes of 87 degrees."""

HELD = 0.05
"""Share by which a normal traction that is said to be held may vary."""


@dataclass(frozen=True, eq=False)
class ShearTest:
    """One test: slip (T,) and s_N (T,), None where not measured, length; tau (T,), stress.

    s_N counts from the start of the slip, opening positive.  sigma_N: normal traction there, stress, <= 0;
    k_N: normal stiffness of the box, stress/length, 0 where sigma_N is held.  name: file and test.
    """

    name: str
    slip: Floats
    tau: Floats
    s_N: Floats | None
    sigma_N: float
    k_N: float = 0.0

    @property
    def turns(self) -> list[float]:
        """Slips at which the direction changes, and the last one."""
        path = np.concatenate([[0.0], self.slip])
        path = path[np.concatenate([[True], np.diff(path) != 0.0])]
        inside = np.flatnonzero(np.diff(np.sign(np.diff(path)))) + 1
        return [*path[inside].tolist(), float(path[-1])]


@dataclass(frozen=True)
class _Row:
    """Numbers of a line."""

    line: int
    values: dict[str, float | None]


def read_records(
    paths: Iterable[Path], k_N: float | None = None, compression_positive: bool = False
) -> list[ShearTest]:
    """Tests of CSV files with columns slip, tau, sigma_N and, as measured, dilation (or s_N), k_N, test.

    A unit in brackets after a name is passed over; other columns are not used, which a ModelWarning tells.
    k_N: for files without that column.  compression_positive: the sign of sigma_N is turned.  Raises
    ValueError that names file, line, column and value of what is no number or makes no sense, OSError for a
    file that cannot be read.
    """
    if k_N is not None and not 0.0 <= k_N < np.inf:
        raise ValueError(f"k_N = {k_N:g}: expected a finite stiffness >= 0")
    tests = []
    for path in paths:
        for name, rows in _read(path).items():
            where = f"{path}: test {name}" if name else str(path)
            tests.append(_test(path, where, rows, k_N, compression_positive))
    if not tests:
        raise ValueError("no test: expected a file")
    check_units(tests)
    return tests


def _read(path: Path) -> dict[str, list[_Row]]:
    """Rows of a file by test, in their order."""
    found: dict[str, list[_Row]] = {}
    columns: list[str] | None = None
    with path.open(encoding="utf-8-sig", newline="") as file:
        reader = csv.reader(file)
        for cells in reader:
            if not any(cell.strip() for cell in cells) or cells[0].lstrip().startswith("#"):
                continue
            if columns is None:
                columns = _columns(path, reader.line_num, cells)
                continue
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
    return found


def _columns(path: Path, line: int, cells: Sequence[str]) -> list[str]:
    """Names of the columns."""
    names = [cell.split("[")[0].strip() for cell in cells]
    names = [ALIASES.get(name, name) for name in names]
    missing = [name for name in REQUIRED if name not in names]
    if missing:
        raise ValueError(
            f"{path}: line {line}: columns {', '.join(names)}: expected {', '.join(missing)}, too "
            f"(needed: {', '.join(REQUIRED)}; as measured: {', '.join(OPTIONAL)})"
        )
    twice = [name for name in REQUIRED + OPTIONAL if names.count(name) > 1]
    if twice:
        raise ValueError(f"{path}: line {line}: column {twice[0]} is there twice: expected it once")
    unused = [name for name in names if name not in REQUIRED + OPTIONAL]
    if unused:
        warnings.warn(f"{path}: columns not used: {', '.join(unused)}", ModelWarning, stacklevel=4)
    return names


def _number(path: Path, line: int, column: str, text: str) -> float | None:
    """A finite number; None for an empty cell of a column that need not be measured."""
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
    path: Path, where: str, rows: list[_Row], k_N: float | None, compression_positive: bool
) -> ShearTest:
    """One test, its rows checked against each other."""
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
    held = float(sigma_N[0]) if stiffness > 0.0 else float(np.mean(sigma_N))
    if stiffness == 0.0:
        away = np.abs(sigma_N - held)
        worst = int(np.argmax(away))
        if away[worst] > HELD * abs(held):
            raise ValueError(
                f"{path}: line {rows[worst].line}, column sigma_N: {rows[worst].values['sigma_N']:g} is more "
                f"than {HELD:.0%} off the mean {sign * held:g}: expected a held normal traction, or k_N"
            )
    blank = [row for row in rows if row.values.get("dilation") is None]
    if 0 < len(blank) < len(rows):
        raise ValueError(
            f"{path}: line {blank[0].line}, column dilation: empty: expected a number, or none in the test"
        )
    s_N = None if blank else _column(rows, "dilation")
    for name, values in (("slip", slip), ("tau", tau)):
        if np.ptp(values) == 0.0:
            raise ValueError(f"{where}: column {name} is {values[0]:g} in all rows: expected it to change")
    if s_N is not None and np.ptp(s_N) > STEEPEST * np.ptp(slip):
        worst = int(np.argmax(np.abs(s_N)))
        raise ValueError(
            f"{path}: line {rows[worst].line}, column dilation: {s_N[worst]:g} over slips up to "
            f"{np.abs(slip).max():g}: expected the unit of slip (at most {STEEPEST:g} times it)"
        )
    return ShearTest(where, slip, tau, s_N, held, stiffness)


def _column(rows: list[_Row], name: str) -> Floats:
    return np.array([row.values[name] for row in rows], dtype=float)


def check_units(tests: Sequence[ShearTest]) -> None:
    """ValueError where the stresses of a record cannot have one unit."""
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
