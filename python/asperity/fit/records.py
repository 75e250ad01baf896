"""Read shear-box tests: files of slip, shear traction and dilation under a normal traction."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import contract
from ..tables import Table, raise_all, read_table
from . import checks, units
from .checks import doubt, refuse
from .shear_test import ShearTest

if TYPE_CHECKING:
    from pandas import DataFrame, Series

REQUIRED = ("slip", "tau", "sigma_N")
ENVELOPE = ("slip", "peak", "residual", "sigma_N")
OPTIONAL = ("dilation", "k_N", "test")  # the first one not in an envelope
KNOWN = tuple(dict.fromkeys(REQUIRED + ENVELOPE + OPTIONAL))
"""Columns of a file; ENVELOPE: a row for each test."""

LEAST_ROWS = 5
"""Smallest number of rows of a test: fewer show no stiffness, peak or residual strength."""

LEAP, RETURN, NEAR, REVERSED = 3.0, 0.5, 0.1, -0.1
"""Where the slip jumps back to its start the next test begins: smallest jump over the usual step and over the
way so far; distance from the start over this way, and smallest way over that of the file; and smallest tau
over the largest one, because the return stroke of a cycle reverses tau.
"""

SHEAR = r"(?=.*(shear|horizontal|tangen|scher|schub|cisail|taglio|orizzontal|corte|cortant|cisalha))"
NORMAL = r"(?=.*(normal|vertical|vertikal|confin))"
PATH = r"(?=.*(disp|verschieb|weg\b|deplac|sposta|desplaza|desloca|slip))"
STRESS = r"(?=.*(stress|spannung|contrainte|tension|sforzo|esfuerzo|tensao|traction|pressure|pression))"
STRENGTH = r"(?=.*(stress|strength|spannung|festig|contrainte|resist|tension|esfuerzo|tensao))"
OTHER = r"rate|speed|veloc|geschwind|vitesse|force|kraft|forza|fuerza|forca|strain"
RULES = {
    "peak": rf"(?=.*(peak|spitze|bruch|picco|pico|\bpic\b)){STRENGTH}",
    "residual": rf"(?=.*resid){STRENGTH}",
    "slip": rf"{SHEAR}{PATH}|schlupf|glissement",
    "tau": rf"{SHEAR}{STRESS}|tau\b",
    "sigma_N": rf"{NORMAL}{STRESS}|sigma_?n?\b",
    "dilation": rf"{NORMAL}{PATH}|s_n\b|dilat",
    "k_N": rf"{NORMAL}(?=.*(stiff|steif|rigid))",
    "test": r"(test|specimen|sample|versuchs?|proben?|essai|prova|provino|ensayo|ensaio)\W*"
    r"(id|name|no|nr|number|nummer|n|code|label)?\W*$",
}
"""Names of the columns in English, German, French, Italian, Spanish and Portuguese."""


def read_tests(
    paths: Iterable[str | Path] | str | Path,
    k_N: float | None = None,
    compression_positive: bool = False,
    target: tuple[str, str] | None = None,
    k_T: float | None = None,
    sigma_N_path: bool = False,
    columns: Mapping[str, str] | None = None,
    sigma_N: float | Sequence[float] | None = None,
) -> list[ShearTest]:
    """Read tests from CSV files with columns slip, tau, sigma_N and optional dilation, k_N, test.

    Numbers with a unit are converted to the units of length and stress of the target, mm and MPa without one;
    numbers without units have those of the target, if there is one.  A row with an empty cell is left out.
    A ModelWarning has the number of these rows, unused columns, tests whose rows seem to be out of order, and
    sizes that contradict their unit.  k_N: for files without that column, in the units of the target.
    compression_positive: sigma_N in the files is > 0 in compression.  k_T: stiffness of the machine,
    stress/length; tau/k_T is taken off the slip.  sigma_N_path: sigma_N of each row is prescribed as it was
    measured.  columns: other names of columns in the files, by name.  sigma_N: compression of each test, or
    of all, with any sign, for files without that column.
    Raises ValueError with file, line, column and value of every inadmissible entry, OSError for a file that
    cannot be read.
    """
    for name, value, least in (("k_N", k_N, ">= 0"), ("k_T", k_T, "> 0")):
        if value is not None and not (0.0 <= value < np.inf and (value or name == "k_N")):
            raise ValueError(f"{name} = {value:g}: expected a finite stiffness {least}")
    for name in columns or {}:
        refuse(name not in KNOWN, f"columns: {name}: expected one of {', '.join(KNOWN)}")
    held = [] if sigma_N is None else np.atleast_1d(contract.array("sigma_N", sigma_N)).tolist()
    shown = f"sigma_N = {contract.shown(sigma_N)}"
    refuse(not np.isfinite(held).all(), f"{shown}: expected finite tractions")
    files = [Path(path) for path in ([paths] if isinstance(paths, str | Path) else paths)]
    refuse(not files, "no test: expected a file")
    sign = -1.0 if compression_positive else 1.0
    for path in files:
        same = [one.resolve() for one in files].count(path.resolve()) > 1
        refuse(same, f"{path}: given twice: expected each file once")
    found = _of_all(files, lambda path: _read(path, target, columns or {}, sign, bool(held)))
    without = [rows for rows in found if "sigma_N" not in rows]
    both = held and not without
    refuse(both, f"{shown}: expected no value beside a column sigma_N, which every file has")
    refuse(
        held and len(held) not in (1, len(without)),
        f"sigma_N: {len(held)} values for {len(without)} tests without that column: expected one for each, "
        "or one for all",
    )
    for rows, value in zip(without, held * (len(without) if len(held) == 1 else 1), strict=True):
        rows["sigma_N"] = -abs(value)
    for rows in found:
        if "k_N" not in rows or rows.k_N.isna().all():
            rows["k_N"] = k_N or 0.0
    tests: list[ShearTest] = _of_all(found, lambda rows: _tests(rows, k_T, sigma_N_path, sign))
    checks.of_all(tests)
    return tests


def _of_all(items: Sequence[Any], function: Callable[[Any], list[Any]]) -> list[Any]:
    """What a function finds for all items; raises ValueError with the errors of all."""
    found, bad = [], []
    for item in items:
        try:
            found += function(item)
        except ValueError as error:
            bad.append(str(error))
    raise_all(bad)
    return found


def _read(
    path: Path, target: tuple[str, str] | None, renamed: Mapping[str, str], sign: float, optional: bool
) -> list[DataFrame]:
    """Rows of each test of a file by line, in the units of the target.

    Their attributes are the name of the test, the place of its file, and the units.  optional: whether
    sigma_N may be missing.
    """
    from pandas import DataFrame

    table = read_table(path, f"a CSV file with {', '.join(REQUIRED)}")
    none = f"{path}: no rows: expected a header with slip, tau, sigma_N, then numbers"
    refuse(not table.names, none)
    where = f"{path}: line {table.line}"
    names = _columns(where, table, renamed, optional)
    measured = {name: unit for name, unit in zip(names, table.units, strict=True) if name in units.KINDS}
    try:
        factors = units.factors(measured, target or units.DEFAULT)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
    refuse(not len(table.cells), none)
    data = table.numbers([names.index(name) for name in measured], [*measured], [*measured]) * factors
    rows = DataFrame(data, index=table.lines, columns=[*measured])
    if "sigma_N" in rows:
        rows["sigma_N"] *= sign
    labels = target or (units.DEFAULT if any(measured.values()) else ())
    of_test = table.cells[names.index("test")] if "test" in names else [""] * len(rows)
    # only a column with this very name says that its rows are one test, also where the slip starts again
    apart = "test" not in {*map(str.lower, table.names), *renamed}
    found, left_out, returns = [], [], []
    for test, group in rows.groupby(np.array(of_test, dtype=object), sort=False):
        # a column without any number in a test is not measured in it
        unused = [name for name in ("dilation", "k_N") if name in group and group[name].isna().all()]
        group = group.drop(columns=unused)
        kept = group.dropna(subset=[name for name in group if name != "k_N"])
        left_out += sorted({*group.index} - {*kept.index})
        starts = [0, *(_starts(kept) if apart and {"slip", "tau"} <= {*kept} else [])]
        returns += [str(kept.index[start]) for start in starts[1:]]
        for number, (start, end) in enumerate(zip(starts, [*starts[1:], len(kept)], strict=True), 1):
            label = ".".join([test] * bool(test) + [str(number)] * (len(starts) > 1))
            part, name = kept[start:end].copy(), f"{path}: test {label}" if label else str(path)
            part.attrs = {
                "name": name,
                "path": str(path),
                "units": dict(zip(units.NONE, labels, strict=False)),
            }
            found.append(part)
    doubt(
        returns,
        f"{path}: the slip jumps back to its start in line {', '.join(returns)}: read as the next test; a "
        "column test with the same entry in all rows makes them one",
    )
    places = ", ".join(map(str, left_out[:10])) + ", ..." * (len(left_out) > 10)
    doubt(left_out, f"{path}: rows left out, because a cell is empty: {len(left_out)} (line {places})")
    return found


def _starts(rows: DataFrame) -> list[int]:
    """First rows of the tests below the first: the slip has jumped back there, and tau is not reversed."""
    slip, tau, starts = rows.slip.to_numpy(), rows.tau.to_numpy(), [0]
    steps = np.abs(np.diff(slip))
    usual = np.median(steps[steps > 0.0]) if steps.any() else 0.0
    for i in (np.flatnonzero(steps > LEAP * usual) + 1).tolist():
        way = slip[starts[-1] : i + 1] - slip[starts[-1]]
        reach = float(np.abs(way).max())
        # a row that is misread is followed by a jump forward
        jumps = (steps[i - 1 : i + 1] > RETURN * reach).tolist()
        back = jumps in ([True], [True, False]) and abs(way[-1]) < NEAR * reach
        upright = tau[i] * np.sign(way[-2]) > REVERSED * np.abs(tau).max()
        if back and upright and reach > NEAR * np.ptp(slip):
            starts.append(i)
    return starts[1:]


def standard(name: str) -> str:
    """Column that a name of a laboratory stands for, or the name."""
    text = name.replace("\u03c4", "tau").replace("\u03c3", "sigma").lower()
    text = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    if re.search(OTHER, text):
        return name
    return next((column for column, rule in RULES.items() if re.match(rule, text.strip())), name)


def _columns(where: str, table: Table, renamed: Mapping[str, str], optional: bool) -> list[str]:
    """Columns of the file, "" for those that are not used.

    A name of the user comes before one of this program, and this before one of a laboratory.
    """
    headers, lower = table.names, [name.lower() for name in table.names]
    there = f"{where}: columns {', '.join(headers)}: expected"
    missing = [header for header in renamed.values() if header.lower() not in lower]
    refuse(missing, f"{there} {', '.join(missing)}, too (--columns)")
    exact = {name.lower(): name for name in KNOWN if name not in renamed}
    exact |= {header.lower(): name for name, header in renamed.items()}
    taken = {*renamed, *(exact[name] for name in lower if name in exact)}
    names = [exact.get(name.lower(), name if standard(name) in taken else standard(name)) for name in headers]
    required = ENVELOPE if {"peak", "residual"} & {*names} and "tau" not in names else REQUIRED
    missing = [name for name in required if name not in names and not (optional and name == "sigma_N")]
    refuse(
        missing,
        f"{there} {', '.join(missing)}, too (needed: {', '.join(required)}; as measured: "
        f"{', '.join(OPTIONAL)}; forces over the area; "
        f"--columns {''.join(missing[:1])}=HEADER, in Python columns=, for a column "
        "with another name; --sigma-N VALUE for files without sigma_N)",
    )
    twice = next((name for name in KNOWN if names.count(name) > 1), "")
    refuse(twice, f"{where}: column {twice} is there twice: expected one, or --columns {twice}=HEADER")
    used = required + OPTIONAL[required is ENVELOPE :]
    unused = [header for header, name in zip(headers, names, strict=True) if name not in used]
    doubt(unused, f"{table.path}: columns not used: {', '.join(unused)}")
    return [name if name in used else "" for name in names]


def _tests(rows: DataFrame, k_T: float | None, sigma_N_path: bool, sign: float) -> list[ShearTest]:
    """Test from its rows, or a test for each row of an envelope, after checks of the rows."""
    name, path, stiffness = rows.attrs["name"], rows.attrs["path"], rows.k_N.dropna()
    envelope = "tau" not in rows
    several = f"{path}: column k_N: {stiffness.nunique()} values: expected one a test"
    refuse(stiffness.nunique() > 1 and not envelope, several)
    unit = f" {rows.attrs['units']['stress']}" if rows.attrs["units"] else ""
    wanted = f"expected compression, <= 0 ({'leave out' if sign < 0.0 else 'or give'} --compression-positive)"
    for line, value in rows.sigma_N[rows.sigma_N > 0.0].items():
        raise ValueError(f"{path}: line {line}, column sigma_N: {sign * value:g}{unit} is tension: {wanted}")
    for line, value in stiffness[stiffness < 0.0].items():
        raise ValueError(f"{path}: line {line}, column k_N: {value:g}: expected a stiffness >= 0")
    least = 1 if envelope else LEAST_ROWS
    refuse(len(rows) < least, f"{name}: {len(rows)} rows: expected at least {least}")
    if not envelope:
        return [_test(rows, k_T, sigma_N_path, sign)]
    refuse(k_T or sigma_N_path, f"{name}: k_T, sigma_N_path: expected columns {', '.join(REQUIRED)}")
    return [_of_envelope(rows, row, f"{path}: line {line}", line) for line, row in rows.iterrows()]


def _test(rows: DataFrame, k_T: float | None, sigma_N_path: bool, sign: float) -> ShearTest:
    """Test from its rows, after checks of the rows against each other."""
    name, path, lines = rows.attrs["name"], rows.attrs["path"], tuple(rows.index.tolist())
    slip, tau, sigma_N = (rows[column].to_numpy() for column in REQUIRED)
    s_N = rows["dilation"].to_numpy() if "dilation" in rows else None
    stiffness = float(rows.k_N.dropna().iloc[0])
    if k_T is not None:
        backward = np.flatnonzero(np.diff(np.abs(slip)) < 0.0)
        first = int(np.argmax(np.abs(tau[: backward[0] + 1 if backward.size else None])))
        refuse(
            (slip[first] - tau[first] / k_T) * slip[first] <= 0.0,
            f"{path}: line {lines[first]}: k_T = {k_T:g} takes {tau[first] / k_T:g} off the slip "
            f"{slip[first]:g}: expected more than tau/slip = {tau[first] / (slip[first] or np.nan):g}",
        )
        slip = slip - tau / k_T
    beside = f"{name}: k_N = {stiffness:g}: expected no stiffness beside a prescribed sigma_N"
    refuse(sigma_N_path and stiffness > 0.0, beside)
    held = float(sigma_N[0] if sigma_N_path else np.mean(sigma_N))
    worst = int(np.argmax(np.abs(sigma_N - held)))
    refuse(
        stiffness == 0.0 and not sigma_N_path and abs(sigma_N[worst] - held) > checks.HELD * abs(held),
        f"{path}: line {lines[worst]}, column sigma_N: {sign * sigma_N[worst]:g} is more than "
        f"{checks.HELD:.0%} off the mean {sign * held:g}: expected a constant normal traction, k_N, a "
        "column test for several tests, or --sigma-N-path",
    )
    if stiffness > 0.0 and np.ptp(sigma_N) > 0.0:
        # sigma_N at the start of the slip, extrapolated from the rows by k_N and the dilation
        held = float(sigma_N[0] if s_N is None else np.mean(sigma_N + stiffness * s_N))
    path_N = sigma_N if sigma_N_path else None
    test = ShearTest(name, slip, tau, s_N, held, stiffness, rows.attrs["units"], lines, path_N)
    checks.of_rows(test, sigma_N)
    return test


def _of_envelope(rows: DataFrame, row: Series, place: str, line: int) -> ShearTest:
    """Test of which peak and residual strength are known, and the slip of the latter."""
    for column, least in (("slip", 0.0), ("residual", 0.0), ("peak", row.residual)):
        wanted = f"at least the residual strength, {least:g}" if column == "peak" else "> 0"
        wrong = row[column] < least or row[column] == 0.0
        refuse(wrong, f"{place}, column {column}: {row[column]:g}: expected {wanted}")
    # the slip of the peak is not read
    slips, tau = np.array([0.5, 1.0]) * row.slip, np.array([row.peak, row.residual])
    given = slips, tau, None, row.sigma_N, 0.0 if np.isnan(row.k_N) else row.k_N, rows.attrs["units"]
    return ShearTest(place, *given, lines=(line, line), envelope=True)
