"""Read and check shear-box tests: CSV files of slip, shear traction and dilation under a normal traction."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..contract import Floats
from ..material import ModelWarning
from ..tables import Table, raise_all, read_table
from . import checks, units
from .shear_test import ShearTest

REQUIRED = ("slip", "tau", "sigma_N")
ENVELOPE = ("slip", "peak", "residual", "sigma_N")
OPTIONAL = ("dilation", "k_N", "test")  # the first one not in an envelope
KNOWN = tuple(dict.fromkeys(REQUIRED + ENVELOPE + OPTIONAL))
ALIASES = {"s_N": "dilation"}
"""Columns of a file and their other accepted names, regardless of case; ENVELOPE: a row for each test."""

LEAST_ROWS = 5
"""Smallest number of rows of a test: fewer show no stiffness, peak or residual strength."""


@dataclass(frozen=True)
class _Rows:
    """Rows of a test: lines, columns as the file has them, factors to the units of the test.

    sign: -1 where compression is positive in the file.
    """

    path: Path
    name: str
    lines: tuple[int, ...]
    values: Mapping[str, Floats]
    factors: Mapping[str, float]
    units: dict[str, str]
    sign: float

    def column(self, name: str) -> Floats:
        """Column in the units and with the sign of the test; NaN where there is none."""
        scale = self.factors.get(name, 1.0) * (self.sign if name == "sigma_N" else 1.0)
        return scale * self.values.get(name, np.full(len(self.lines), np.nan))

    def place(self, row: int) -> str:
        """File and line of a row."""
        return f"{self.path}: line {self.lines[row]}"

    def stiffness(self, k_N: float | None) -> float:
        """k_N of the test, that of the option where the file has none."""
        found = np.unique(self.column("k_N")[~np.isnan(self.column("k_N"))])
        if found.size > 1:
            raise ValueError(f"{self.name}: column k_N: {found.size} values: expected one a test")
        stiffness = float(found[0]) if found.size else k_N or 0.0
        if stiffness < 0.0:
            raise ValueError(f"{self.place(0)}, column k_N: {stiffness:g}: expected a stiffness >= 0")
        return stiffness

    def check_compression(self) -> None:
        """Raise ValueError where sigma_N is tension."""
        wrong = np.flatnonzero(self.column("sigma_N") > 0.0)
        if wrong.size:
            hint = "leave out --compression-positive" if self.sign < 0.0 else "or give --compression-positive"
            raise ValueError(
                f"{self.place(wrong[0])}, column sigma_N: {self.values['sigma_N'][wrong[0]]:g} is tension: "
                f"expected compression, <= 0 ({hint})"
            )


def read_tests(
    paths: Iterable[str | Path] | str | Path,
    k_N: float | None = None,
    compression_positive: bool = False,
    target: tuple[str, str] = units.DEFAULT,
    k_T: float | None = None,
    sigma_N_path: bool = False,
    columns: Mapping[str, str] | None = None,
) -> list[ShearTest]:
    """Read tests from CSV files with columns slip, tau, sigma_N and optional dilation (or s_N), k_N, test.

    Numbers with a unit in brackets after the name of their column are converted to the units of length and
    stress of the target; numbers without units stay as they are.  A row with an empty cell is left out.  A
    ModelWarning has the number of these rows, unused columns, tests whose rows seem to be out of order, and
    sizes that contradict their unit.  k_N: for files without that column, in the units of the target.
    compression_positive: sigma_N in the files is > 0 in compression.  k_T: stiffness of the machine,
    stress/length; tau/k_T is taken off the slip.  sigma_N_path: sigma_N of each row is prescribed as it was
    measured.  columns: other names of columns in the files, by name.
    Raises ValueError with file, line, column and value of every inadmissible entry, OSError for a file that
    cannot be read.
    """
    if k_N is not None and not 0.0 <= k_N < np.inf:
        raise ValueError(f"k_N = {k_N:g}: expected a finite stiffness >= 0")
    if k_T is not None and not 0.0 < k_T < np.inf:
        raise ValueError(f"k_T = {k_T:g}: expected a finite stiffness > 0")
    for name in columns or {}:
        if name not in KNOWN:
            raise ValueError(f"columns: {name}: expected one of {', '.join(KNOWN)}")
    tests: list[ShearTest] = []
    bad: list[str] = []
    seen: list[Path] = []
    for path in map(Path, [paths] if isinstance(paths, str | Path) else paths):
        if path.resolve() in seen:
            raise ValueError(f"{path}: given twice: expected each file once")
        seen.append(path.resolve())
        try:
            found = _read(path, target, columns or {}, -1.0 if compression_positive else 1.0)
        except ValueError as error:
            bad.append(str(error))
            continue
        for rows in found:
            try:
                if "tau" in rows.values:
                    tests.append(_test(rows, k_N, k_T, sigma_N_path))
                    continue
                if k_T is not None or sigma_N_path:
                    wanted = f"expected columns {', '.join(REQUIRED)}"
                    raise ValueError(f"{rows.name}: k_T, sigma_N_path: {wanted}")
                tests += _envelope(rows, k_N)
            except ValueError as error:
                bad.append(str(error))
    raise_all(bad)
    if not tests:
        raise ValueError("no test: expected a file")
    checks.of_all(tests)
    return tests


def _read(path: Path, target: tuple[str, str], renamed: Mapping[str, str], sign: float) -> list[_Rows]:
    """Rows of a file by test, in their order."""
    table = read_table(path, f"a CSV file with {', '.join(REQUIRED)}")
    names = _columns(table, renamed) if table.names else []
    measured = [name for name in names if name in units.KINDS]
    given = {
        name: unit for name, unit in zip(names, table.units, strict=True) if unit and name in units.KINDS
    }
    factors = units.factors(f"{path}: line {table.line}", measured, given, target)
    if not table.names or not table.cells:
        raise ValueError(f"{path}: no rows: expected a header with {', '.join(REQUIRED)}, then numbers")
    gaps = measured if "tau" in names else OPTIONAL
    data = table.numbers([names.index(name) for name in measured], measured, gaps)
    of_test = [row[names.index("test")] if "test" in names else "" for row in table.cells]
    found, left_out = [], []
    for test in dict.fromkeys(of_test):
        rows = np.array([name == test for name in of_test])
        # a column without any number in a test is not measured in it
        needed = [name in REQUIRED + ENVELOPE for name in measured]
        needed |= (np.array(measured) == "dilation") & ~np.isnan(data[rows]).all(axis=0)
        gap = np.isnan(data[:, needed]).any(axis=1) & rows
        left_out += np.flatnonzero(gap).tolist()
        rows &= ~gap
        lines = tuple(table.lines[i] for i in np.flatnonzero(rows))
        values = dict(zip(measured, data[rows].T, strict=True))
        name = f"{path}: test {test}" if test else str(path)
        of_file = dict(zip(("length", "stress"), target, strict=True)) if factors else {}
        found.append(_Rows(path, name, lines, values, factors, of_file, sign))
    if left_out:
        places = ", ".join(str(table.lines[i]) for i in sorted(left_out)[:10])
        more = ", ..." if len(left_out) > 10 else ""
        text = f"{path}: rows left out, because a cell is empty: {len(left_out)} (line {places}{more})"
        warnings.warn(text, ModelWarning, stacklevel=4)
    return found


def _columns(table: Table, renamed: Mapping[str, str]) -> list[str]:
    """Names of the columns, those of this program where it knows them."""
    where, missing = f"{table.path}: line {table.line}", []
    known = {name.lower(): name for name in KNOWN} | {name.lower(): one for name, one in ALIASES.items()}
    for name, header in renamed.items():
        if header.lower() not in map(str.lower, table.names):
            missing.append(header)
        known[header.lower()] = name
    if missing:
        raise ValueError(f"{where}: columns {', '.join(table.names)}: expected {missing[0]}, too (--columns)")
    names = [known.get(name.lower(), name) for name in table.names]
    required = ENVELOPE if {"peak", "residual"} & {*names} and "tau" not in names else REQUIRED
    missing = [name for name in required if name not in names]
    if missing:
        raise ValueError(
            f"{where}: columns {', '.join(names)}: expected {', '.join(missing)}, too (needed: "
            f"{', '.join(required)}; as measured: {', '.join(OPTIONAL)}; --columns {missing[0]}=HEADER for a "
            "column with another name)"
        )
    twice = [name for name in KNOWN if names.count(name) > 1]
    if twice:
        raise ValueError(f"{where}: column {twice[0]} is there twice: expected one column")
    used = required + OPTIONAL[required is ENVELOPE :]
    unused = [name for name in names if name not in used]
    if unused:
        warnings.warn(f"{table.path}: columns not used: {', '.join(unused)}", ModelWarning, stacklevel=5)
    return [name if name in used else "" for name in names]


def _test(rows: _Rows, k_N: float | None, k_T: float | None, sigma_N_path: bool) -> ShearTest:
    """Test from its rows, after checks of the rows against each other."""
    where, count = rows.name, len(rows.lines)
    if count < LEAST_ROWS:
        raise ValueError(f"{where}: {count} rows: expected at least {LEAST_ROWS}")
    rows.check_compression()
    slip, tau, sigma_N = (rows.column(name) for name in REQUIRED)
    s_N = rows.column("dilation")
    s_N = None if np.isnan(s_N).all() else s_N
    if k_T is not None:
        slip = _slip_of_the_joint(rows, slip, tau, k_T)
    stiffness = rows.stiffness(k_N)
    held = float(sigma_N[0] if sigma_N_path else np.mean(sigma_N))
    if sigma_N_path and stiffness > 0.0:
        raise ValueError(f"{where}: k_N = {stiffness:g}: expected no stiffness beside a prescribed sigma_N")
    if stiffness == 0.0 and not sigma_N_path:
        away = np.abs(sigma_N - held)
        worst = int(np.argmax(away))
        if away[worst] > checks.HELD * abs(held):
            raise ValueError(
                f"{rows.place(worst)}, column sigma_N: {rows.sign * sigma_N[worst]:g} is more than "
                f"{checks.HELD:.0%} off the mean {rows.sign * held:g}: expected a constant normal "
                "traction, k_N, or --sigma-N-path"
            )
    if stiffness > 0.0 and np.ptp(sigma_N) > 0.0:
        # sigma_N at the start of the slip, extrapolated from the rows by k_N and the dilation
        held = float(sigma_N[0] if s_N is None else np.mean(sigma_N + stiffness * s_N))
    if not held <= 0.0:
        raise ValueError(f"{where}: sigma_N = {held:g} at the start of the slip: expected compression, <= 0")
    path_N = sigma_N if sigma_N_path else None
    test = ShearTest(where, slip, tau, s_N, held, stiffness, rows.units, rows.lines, path_N)
    checks.of_rows(test, sigma_N)
    return test


def _envelope(rows: _Rows, k_N: float | None) -> list[ShearTest]:
    """Tests of which peak and residual strength are known, and the slip of the latter: one for each row."""
    rows.check_compression()
    tests = []
    columns = np.column_stack([rows.column(name) for name in (*ENVELOPE, "k_N")])
    for i, (slip, peak, residual, sigma_N, own) in enumerate(columns.tolist()):
        stiffness = (k_N or 0.0) if np.isnan(own) else own
        for name, value, least in (
            ("slip", slip, 0.0),
            ("residual", residual, 0.0),
            ("peak", peak, residual),
        ):
            if value < least or value == 0.0:
                wanted = f"at least the residual strength, {least:g}" if name == "peak" else "> 0"
                raise ValueError(f"{rows.place(i)}, column {name}: {value:g}: expected {wanted}")
        # the slip of the peak is not read
        slips, tau, lines = np.array([0.5 * slip, slip]), np.array([peak, residual]), (rows.lines[i],) * 2
        made = ShearTest(
            rows.place(i), slips, tau, None, sigma_N, stiffness, rows.units, lines, envelope=True
        )
        tests.append(made)
    return tests


def _slip_of_the_joint(rows: _Rows, slip: Floats, tau: Floats, k_T: float) -> Floats:
    """Slip without that of the machine; raises ValueError where this is more than the whole slip."""
    backward = np.flatnonzero(np.diff(np.abs(slip)) < 0.0)
    first = int(np.argmax(np.abs(tau[: backward[0] + 1 if backward.size else None])))
    left: Floats = slip - tau / k_T
    if left[first] * slip[first] <= 0.0:
        raise ValueError(
            f"{rows.place(first)}: k_T = {k_T:g} takes {tau[first] / k_T:g} off the slip "
            f"{slip[first]:g}: expected more than tau/slip = {tau[first] / slip[first]:g}"
        )
    return left
