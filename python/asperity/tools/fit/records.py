"""Files of laboratories as tests: which rows are a test, where it begins and ends, forces over an area."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ... import contract
from ...contract import Floats
from ..tables import Table, raise_all, read_tables, size, warn_if
from ..units import area_of
from .closure_test import ClosureTest
from .columns import (
    BESIDE,
    DEFAULT,
    FORCES,
    KNOWN,
    MEASURES,
    NONE,
    REQUIRED,
    STRENGTHS,
    columns_of,
    factors_of,
    is_statistic,
    standard,
    with_names,
)
from .shear_test import ShearTest, check_rows, check_sizes, check_stiffness
from .strength import Strength
from .thresholds import (
    BACK,
    BEYOND_NOISE,
    CLEARLY,
    ELASTIC,
    FIRST_ROWS,
    LARGEST_FRICTION,
    LATE,
    LEAP,
    LEAST_FRICTION,
    LEAST_NOISE,
    LEAST_WAY,
    MARK,
    OF_CYCLE,
    PART,
    RESTING,
    RETURN,
    REVERSED,
    ROWS_OF_CURVE,
    ROWS_OF_TEST,
    SURELY,
    UNLOADED,
    USUAL,
)

if TYPE_CHECKING:
    from pandas import DataFrame

Area = Callable[[Floats], Floats]
"""Area over the slip, as `area_of` makes it."""


def read_tests(
    paths: Iterable[str | Path] | str | Path,
    k_N: float | None = None,
    target: tuple[str, str] | None = None,
    k_T: float | None = None,
    sigma_N_path: bool = False,
    columns: Mapping[str, str] | None = None,
    sigma_N: float | Sequence[float] | None = None,
    decimal: str | None = None,
    area: str | None = None,
) -> list[ShearTest] | list[Strength] | list[ClosureTest]:
    """Read tests from CSV files with columns slip, tau, sigma_N and optional dilation, k_N, test.

    Files with a column peak in place of tau have the strengths of a test in each row: sigma_N, peak and,
    where they were measured, residual, peak_slip, and slip at the residual strength.  Files with a column
    closure in place of slip and tau are closure tests.

    Numbers with a unit are converted to the units of length and stress of the target, mm and MPa without one;
    numbers without units have those of the target, if there is one.  A row with an empty cell is left out.
    A ModelWarning has the number of these rows, unused columns, tests that begin where the slip jumps back,
    and sizes that contradict their unit.  sigma_N of a test is compression, with either sign.  k_N: for files
    without that column, in the units of the target.  k_T: stiffness of the machine, stress/length; tau/k_T is
    taken off the slip.  sigma_N_path: sigma_N of each row is prescribed as it was measured.  columns: other
    names of columns in the files, by name.  sigma_N: of each test, or of all, for files without that column.
    decimal: the mark "." or "," where a file does not show it.  area: of the contact, "A", or "L,B" for one
    that shrinks as the box slips along L, in squares of the unit of length of the results; columns
    shear_force and normal_force, of a table peak_force and residual_force, are then divided by it.  Under a
    normal force the traction of a shrinking area is prescribed row by row.
    Raises ValueError with file, line, column and value of every inadmissible entry, OSError for a file that
    cannot be read.
    """
    for name, value in (("k_N", k_N), ("k_T", k_T)):
        good = value is None or 0.0 < value < np.inf
        if not good:
            raise ValueError(f"{name} = {value or 0.0:g}: expected a finite stiffness > 0")
    unknown = next((name for name in columns or {} if name not in KNOWN), "")
    if unknown:
        raise ValueError(f"columns: {unknown}: expected one of {', '.join(KNOWN)}")
    held = [] if sigma_N is None else np.atleast_1d(contract.array("sigma_N", sigma_N)).tolist()
    if not np.isfinite(held).all():
        raise ValueError(f"sigma_N = {contract.shown(sigma_N)}: expected finite tractions")
    files = [Path(path) for path in ([paths] if isinstance(paths, str | Path) else paths)]
    if not files:
        raise ValueError("no test: expected a file")
    twice = next((path for path in files if [*map(Path.resolve, files)].count(path.resolve()) > 1), None)
    if twice:
        raise ValueError(f"{twice}: given twice: expected each file once")
    expected = f"a CSV file with {', '.join(REQUIRED)}"
    of_area = area_of(area) if area is not None else None

    def of_file(path: Path) -> list[DataFrame]:
        tables = []
        for table in read_tables([path], expected):
            tables += _read(table, target, columns or {}, bool(held), decimal, of_area)
        return tables

    tables = _of_all(files, of_file)
    without = [rows for rows in tables if "sigma_N" not in rows]
    if held and (not without or len(held) not in (1, len(without))):
        text = (
            f"sigma_N: {len(held)} values for {len(without)} tests without that column: expected one for each"
        )
        raise ValueError(f"{text}, or one for all")
    for i, rows in enumerate(without):
        rows["sigma_N"] = held[i % len(held)] * shrinking(of_area, rows)
        rows.attrs["shrinks"] = bool(np.ptp(rows["sigma_N"]) > 0.0)
    for rows in tables:
        if "k_N" not in rows or rows.k_N.isna().all():
            rows["k_N"] = k_N or 0.0
    column = _column_of_kind(tables)
    if column != "slip" and (k_N or k_T or sigma_N_path):
        raise ValueError("k_N, k_T, sigma_N_path: expected curves, not strengths alone or closures")
    if column == "closure":
        closures: list[ClosureTest] = _of_all(tables, _closures)
        return closures
    if column == "peak":
        strengths: list[Strength] = _of_all(tables, _strengths)
        _check_units(strengths)
        return strengths
    tests: list[ShearTest] = _of_all(tables, lambda rows: _tests(rows, k_T, sigma_N_path))
    check_sizes(tests)
    return tests


def _column_of_kind(tables: Sequence[DataFrame]) -> str:
    """Column by which tests are curves, strengths or closure tests; raises ValueError for several of them."""
    first: dict[str, str] = {}
    for rows in tables:
        column = next((name for name in ("peak", "closure") if name in rows), "slip")
        first.setdefault(column, rows.attrs["name"])
    if len(first) > 1:
        whats = {"slip": ShearTest.WHAT, "peak": Strength.WHAT, "closure": ClosureTest.WHAT}
        text = ", ".join(f"{name} has {whats[column]}" for column, name in first.items())
        raise ValueError(f"{text}: expected one kind at a time; book.xlsx:SHEET reads one sheet")
    return next(iter(first), "slip")


def _of_all(items: Sequence[Any], function: Callable[[Any], list[Any]]) -> list[Any]:
    """What a function finds for all items; raises ValueError with the errors of all."""
    results, bad = [], []
    for item in items:
        try:
            results += function(item)
        except ValueError as error:
            bad.append(str(error))
    raise_all(bad)
    return results


def _read(
    table: Table,
    target: tuple[str, str] | None,
    renamed: Mapping[str, str],
    optional: bool,
    decimal: str | None,
    area: Area | None,
) -> list[DataFrame]:
    """Rows of each test of a file by line, in the units of the target.

    Their attributes are the name of the test, its file and the units.  optional: sigma_N may be missing.
    """
    from pandas import DataFrame

    path = table.path
    table.warn_of_remarks()
    none = f"{path}: no rows: expected a header with slip, tau, sigma_N, then numbers"
    if not table.names:
        if not len(table.cells):
            raise ValueError(none)
        table = with_names(table, renamed, decimal)
    names = columns_of(table, renamed, optional, area is not None)
    table = specimens(table) if {"peak", "peak_force"} & {*names} else table
    measured = {name: unit for name, unit in zip(names, table.units, strict=True) if name in MEASURES}
    factors = factors_of(f"{path}: line {table.line}", measured, target or DEFAULT)
    if not len(table.cells):
        raise ValueError(none)
    places = [names.index(name) for name in measured]
    numbers = table.numbers(places, [*measured], [*measured], decimal)
    rows = DataFrame(numbers, index=table.lines, columns=[*measured])
    refuse_marks(path, rows)
    rows *= factors
    rows, shrinks = (rows, False) if area is None else over_area(rows, area, FORCES)
    measured = {name: "" for name in rows} | {name: unit for name, unit in measured.items() if name in rows}
    labels = target or (DEFAULT if any(measured.values()) else ())
    of_file = {"path": str(path), "units": dict(zip(NONE, labels, strict=False)), "shrinks": shrinks}
    of_test = names_of_tests(table, names)
    # only a column with this very name says that its rows are one test, also where the slip starts again
    named = any(of_test) and "test" in {*map(str.lower, table.names), *renamed}
    apart = not named and {"slip", "tau"} <= {*measured}
    tests, left_out, returns = [], [], []
    for test, group in rows.groupby(np.array(of_test, dtype=object), sort=False):
        # a column without any number in a test is not measured in it
        # and a strength that one test of a table does not have is left open
        unused = [name for name in ("dilation", "k_N") if name in group and group[name].isna().all()]
        open_ = {*BESIDE} if "peak" in group else set()
        kept = group.drop(columns=unused).dropna(subset=[*{*group} - {"k_N", *unused} - open_])
        left_out += sorted({*group.index} - {*kept.index})
        starts = [0, *(starts_of(kept) if apart else []), len(kept)]
        returns += [str(kept.index[start]) for start in starts[1:-1]]
        for number in range(1, len(starts)):
            part = kept[starts[number - 1] : starts[number]].copy()
            label = ".".join(filter(None, (test, str(number) if len(starts) > 2 else "")))
            part.attrs = {"name": f"{path}: test {label}" if label else str(path)} | of_file
            tests.append(part)
    text = f"{path}: the slip jumps back in line {', '.join(returns)}: read as the next test; a column test"
    warn_if(returns, f"{text} with the same entry in all rows makes them one")
    lines = ", ".join([*map(str, left_out[:10]), *(["..."] if len(left_out) > 10 else [])])
    warn_if(left_out, f"{path}: rows left out, because a cell is empty: {len(left_out)} (line {lines})")
    return tests


def specimens(table: Table) -> Table:
    """Table of strengths without the rows of means and other statistics, which a ModelWarning names.

    Their word stands where the specimens have their names, or in the first cell, as a roughness may be mean.
    """
    named = [place for place, name in enumerate(table.names) if standard(name) == "test"]
    found: dict[int, str] = {}
    for line, cells in zip(table.lines, table.cells.to_numpy().tolist(), strict=True):
        names = [cells[place] for place in named if cells[place]] or [*filter(None, cells)][:1]
        if any(map(is_statistic, names)):
            found[line] = " ".join(names)
    shown = ", ".join(f"line {line}: {cell}" for line, cell in found.items())
    if found and len(found) == len(table.cells):
        raise ValueError(f"{table.path}: {shown}: expected rows of specimens, not of statistics alone")
    warn_if(found, f"{table.path}: rows of statistics left out, which are no specimens: {shown}")
    return replace(table, cells=table.cells.drop(index=[*found]))


def names_of_tests(table: Table, columns: Sequence[str]) -> list[str]:
    """Name of the test of each row, that above where a cell is empty; none where the column counts rows."""
    none = [""] * len(table.cells)
    if "test" not in columns:
        return none
    place = columns.index("test")
    cells = table.cells[place]
    names = cells.where(cells != "").ffill().fillna("")
    counts = names.value_counts().max() < ROWS_OF_TEST and bool((names != names.shift()).all())
    text = f"{table.path}: column {table.headings[place]}: another entry in each row"
    warn_if(counts, f"{text}: read as a counter of the rows, not as names of tests")
    return none if counts else [*names]


def refuse_marks(path: Path, rows: DataFrame) -> None:
    """Raise ValueError for -99, 9999 and other marks of missing values, far from the numbers of a column."""
    wrong = []
    for name, column in rows.items():
        large = column[column.abs() >= 99.0]
        marks = large[[bool(re.fullmatch(r"-9{2,}(\.9+)?|9{3,}(\.9+)?", f"{value:.10g}")) for value in large]]
        others = column.drop(index=marks.index).dropna()
        low, high = min(0.0, others.min()), max(0.0, others.max())
        # tests without a pressure or a stiffness say nothing about the size of that of the others
        compared = len(others) > 0 and (high > low or name not in ("sigma_N", "k_N"))
        for line, value in marks.items() if compared else ():
            # among numbers of one sign the mark of the other one is none of them
            if abs(value) > MARK * (high - low) or (value < 0.0 == low) or (value > 0.0 == high):
                wanted = "expected a number, or an empty cell"
                wrong.append(
                    f"{path}: line {line}, column {name}: {value:.10g} marks a missing value: {wanted}"
                )
    raise_all(wrong)


def _check_units(strengths: Sequence[Strength]) -> None:
    """Check units and sizes of strengths, as those of curves.  Raises ValueError or gives a ModelWarning."""
    units = {bool(one.units): one for one in strengths[::-1]}
    if len(units) > 1:
        text = f"expected units in every file, as in {units[True].name}, or in none"
        raise ValueError(f"{units[False].name}: no units in the header: {text}")
    one = max(strengths, key=lambda one: max(abs(one.sigma_N), one.peak))
    largest, (low, high) = max(abs(one.sigma_N), one.peak), USUAL["stress"]
    text = f"{one.name}: the largest stress, {largest:.3g}, is unusual for a shear box"
    odd = bool(one.units) and not low <= largest * size("stress", one.units["stress"]) <= high
    warn_if(odd, f"{text}: check the units of the header")
    ratios = [abs(one.peak / one.sigma_N) for one in strengths if one.sigma_N < 0.0]
    median = float(np.median(ratios or [1.0]))
    text = f"{strengths[0].name}: the median ratio of peak to pressure is {median:.3g}, which is unusual"
    warn_if(
        not LEAST_FRICTION <= median <= LARGEST_FRICTION,
        f"{text}: check that both are stresses of one unit, and no forces",
    )


def _strengths(rows: DataFrame) -> list[Strength]:
    """Strengths of the tests of a table, a row for each."""
    path, units = rows.attrs["path"], rows.attrs["units"]
    if rows.attrs["shrinks"]:
        raise ValueError(f"{path}: strengths of a table: expected one area, --area A")
    columns = [name for name in STRENGTHS + BESIDE if name in rows]
    curve = "slip" in rows and len(rows) >= ROWS_OF_CURVE and rows.sigma_N.nunique() == 1
    if curve and bool((np.diff(rows.slip) > 0.0).all()):
        text = f"{len(rows)} rows at one pressure with growing slips are a curve"
        raise ValueError(f"{path}: column peak: {text}: expected tau, as --columns tau=HEADER")
    # compression has either sign; in a table with both signs the larger tractions are compression
    above, below = (max(0.0, float(end)) for end in (rows.sigma_N.max(), -rows.sigma_N.min()))
    small, large = sorted((above, below))
    if small * CLEARLY > large:
        raise ValueError(
            f"{path}: column sigma_N: {-below:g} to {above:g}: expected compression in all rows, with the "
            f"same sign, and tension, if any, of at most 1/{CLEARLY:g} of it"
        )
    sign = 1.0 if below > above else -1.0
    pulled = ", ".join(str(line) for line in rows.index[sign * rows.sigma_N > 0.0])
    warn_if(pulled, f"{path}: column sigma_N: both signs: line {pulled} is read as tension")
    strengths: list[Strength] = _of_all(
        [*rows.iterrows()],
        lambda row: [
            Strength(
                f"{path}: line {row[0]}",
                **{name: float(row[1][name]) for name in columns}
                | {"sigma_N": sign * float(row[1].sigma_N) + 0.0},
                units=units,
            )
        ],
    )
    return strengths


def _closures(rows: DataFrame) -> list[ClosureTest]:
    """Closure test from its rows: pressure of either sign, and closure that grows with it."""
    name, path = rows.attrs["name"], rows.attrs["path"]
    pressure, closure = (rows[column].to_numpy() for column in ("sigma_N", "closure"))
    mixed = pressure.min() < 0.0 < pressure.max()
    if mixed:
        raise ValueError(f"{path}: column sigma_N: expected compression in all rows, with the same sign")
    pressure = np.abs(pressure)
    first, last = closure[0], closure[np.argmax(pressure)]
    # closing has either sign, and falling closures are those of a column that counts opening positive
    opens = last < first and abs(last) <= abs(first)
    if opens:
        raise ValueError(
            f"{path}: column closure: falls from {first:g} to {last:g} as the pressure grows: expected "
            "closures that grow from the first row, or fall below 0 where opening counts positive"
        )
    warn_if(
        last < first,
        f"{path}: column closure: falls from {first:g} to {last:g} as the pressure grows: read as opening "
        "positive",
    )
    sign = np.sign(last - first) or 1.0
    return [ClosureTest(name, pressure, sign * (closure - closure[0]), rows.attrs["units"])]


def _tests(rows: DataFrame, k_T: float | None, sigma_N_path: bool) -> list[ShearTest]:
    """Test from its rows, after checks of the rows."""
    name, path, units, shrinks = (rows.attrs[key] for key in ("name", "path", "units", "shrinks"))
    sigma_N_path = sigma_N_path or shrinks
    stiffness = rows.k_N.dropna()

    def each(column: str, wrong: Any, text: str) -> None:
        """Refuse the first row where a column is wrong; text: what is wrong with its value."""
        for line, value in rows[column][wrong].items():
            raise ValueError(f"{path}: line {line}, column {column}: {value:g}{text}")

    if stiffness.nunique() > 1:
        raise ValueError(f"{path}: column k_N: {stiffness.nunique()} values: expected one a test")
    if (rows.sigma_N >= 0.0).all():
        rows = rows.assign(sigma_N=0.0 - rows.sigma_N)
    each("sigma_N", rows.sigma_N > 0.0, ": expected compression in all rows, with the same sign")
    each("k_N", rows.k_N < 0.0, ": expected a stiffness >= 0")
    loaded = np.full(len(rows), True)
    for part in unloadings(rows.slip.to_numpy(), rows.tau.to_numpy()):
        loaded[part], lines = False, rows.index[part]
        at_end = part.stop == len(rows)
        text = "the unloading at the end" if at_end else "an unloading and reloading"
        where = f"from line {lines[0]} on" if at_end else f"line {lines[0]} to {lines[-1]}"
        warn_if(True, f"{path}: rows of {text} left out: {len(lines)} ({where})")
    rows = rows[loaded]
    if len(rows) < ROWS_OF_TEST:
        raise ValueError(f"{name}: {len(rows)} rows: expected at least {ROWS_OF_TEST}")
    slip, tau, sigma_N = (rows[column].to_numpy() for column in REQUIRED)
    lines, s_N = tuple(rows.index.tolist()), rows["dilation"].to_numpy() if "dilation" in rows else None
    slip, s_N = from_start(slip, tau, s_N, sigma_N, [f"{path}: line {line}" for line in lines])
    if k_T is not None:
        first = int(np.argmax(np.abs(tau)))
        text = f"{path}: line {lines[first]}: k_T = {k_T:g} takes {tau[first] / k_T:g} off the slip"
        wanted = f"expected more than tau/slip = {tau[first] / (slip[first] or np.nan):g}"
        wrong, slip = slip[first] * (slip[first] - tau[first] / k_T) <= 0.0, slip - tau / k_T
        if wrong:
            raise ValueError(f"{text} {rows.slip.iloc[first]:g}: {wanted}")
    k_N = float(stiffness.iloc[0])
    if sigma_N_path and k_N > 0.0:
        raise ValueError(f"{name}: k_N = {k_N:g}: expected no stiffness beside a prescribed sigma_N")
    # under a stiffness sigma_N at the start of the slip is extrapolated from the rows by the dilation
    springs = k_N > 0.0 and np.ptp(sigma_N) > 0.0
    if springs and s_N is not None:
        check_stiffness(name, k_N, s_N, sigma_N)
    first_only = sigma_N_path or (springs and s_N is None)
    free = sigma_N + k_N * s_N if springs and s_N is not None else sigma_N
    held = sigma_N[0] if first_only else np.mean(free)
    path_N = sigma_N if sigma_N_path else None
    test = ShearTest(name, slip, tau, s_N, float(held), k_N, units, lines, path_N)
    check_rows(test, sigma_N)
    return [test]


def starts_of(rows: DataFrame) -> list[int]:
    """First rows of the tests below the first: the slip has jumped back there, and tau is not reversed."""
    slip, tau, starts = rows.slip.to_numpy(), rows.tau.to_numpy(), [0]
    steps = np.abs(np.diff(slip))
    usual = np.median(steps[steps > 0.0]) if steps.any() else 0.0
    for i in (np.flatnonzero(steps > LEAP * usual) + 1).tolist():
        way = slip[starts[-1] : i + 1] - slip[starts[-1]]
        reach, side = float(np.abs(way).max()), float(np.sign(way[-2]))
        # a row that is misread is followed by a jump forward
        jumps = (steps[i - 1 : i + 1] > RETURN * reach).tolist()
        beyond = max(side * slip[i], side * way[-1]) < -RETURN * reach
        back = jumps in ([True], [True, False]) and side * (way[-1] - way[-2]) < 0.0 and not beyond
        upright = tau[i] * side > REVERSED * np.abs(tau).max()
        if back and upright and reach > LEAST_WAY * np.ptp(slip):
            starts.append(i)
    return starts[1:]


def from_start(
    slip: Floats, tau: Floats, s_N: Floats | None, sigma_N: Floats, places: Sequence[str]
) -> tuple[Floats, Floats | None]:
    """Slip and dilation (T,) counted from the start of the slip, where the first row shows another start.

    Where the joint still rests in the first row, a slip or dilation there is that of a gauge which was not
    set to zero: it is taken off, and a ModelWarning says so.  sigma_N (T,): as measured.  places: of rows.
    Raises ValueError where the joint slides in the first row already, so that the start is not known.
    """
    ratio = tau / np.abs(sigma_N) if (sigma_N != 0.0).all() else tau
    top, steps = float(np.abs(ratio).max()), np.abs(np.diff(slip))
    share = float(np.abs(ratio[0])) / max(top, 1e-300)
    usual = float(np.median(steps[steps > 0.0])) if steps.any() else 0.0
    way = max((LATE if share >= SURELY else 0.5 * LATE) * usual, PART * float(np.ptp(slip)))
    state = f"where {share:.0%} of the largest traction acts"
    strong = int(np.argmax(np.abs(ratio) >= RESTING * top))
    zero = float(slip[0])
    if share < RESTING and slip[strong] != slip[0]:
        zero -= float(ratio[0] * (slip[strong] - slip[0]) / (ratio[strong] - ratio[0]))
    late = min(abs(zero), abs(float(slip[0]))) > way
    text = f"{places[0]}, column slip: {slip[0]:g}"
    if late and share >= RESTING:
        raise ValueError(f"{text} in the first row, {state}: expected slips from 0 on, as those of the model")
    warn_if(late, f"{text} {state}: the slip is counted from {zero:.4g} on")
    slip = slip - zero if late else slip
    if s_N is None:
        return slip, s_N
    noise = float(np.std(np.diff(s_N, 2))) / np.sqrt(6.0) if s_N.size > LEAST_NOISE else 0.0
    least = max(PART * float(np.ptp(s_N)), BEYOND_NOISE * noise)
    text, first = f"{places[0]}, column dilation: {s_N[0]:g}", slice(0, FIRST_ROWS)
    if share < SURELY:
        away = float(np.mean(slip[first] - slip[0]))
        rise = float(np.mean(s_N[first] - s_N[0])) / away if away else 0.0
        # what grows in proportion to the slip is no offset
        proportional = float(np.clip(rise * slip[0] / s_N[0], 0.0, 1.0)) if s_N[0] else 0.0
        start = float(s_N[0]) * (1.0 - proportional)
        offset = abs(start) > least
        warn_if(offset, f"{text} {state}: it is counted from {start:.4g} on")
        return slip, s_N - start if offset else s_N
    grows = s_N.size > FIRST_ROWS and (np.diff(slip[first]) * np.sign(slip[-1]) > 0.0).all()
    # rows in which most of the dilation happens are too far apart
    if grows and np.ptp(s_N[first]) < RESTING * np.ptp(s_N):
        start = float(np.polynomial.Polynomial.fit(slip[first], s_N[first], 2)(0.0))
        if start > 2.0 * least:
            wanted = "expected the change since the start of the slip"
            raise ValueError(
                f"{text} in the first row, where the rows lead to {start:.3g} at slip 0: {wanted}"
            )
    return slip, s_N


def unloadings(slip: Floats, tau: Floats) -> Iterator[slice]:
    """Rows of each unloading of a test, with its reloading up to the slip from which it began.

    The slip returns and tau falls without being reversed, as in a loop that shows a stiffness, or at the end
    of a test, where the slip returns by little.  A reversed tau is that of a cycle.
    """
    top = int(np.argmax(np.abs(slip)))
    side, reach, most = float(np.sign(slip[top])), float(np.ptp(slip)), float(np.abs(tau).max())
    way, tau = side * slip, side * tau
    highest = np.maximum.accumulate(way)
    further = np.append(np.flatnonzero(np.append(True, way[1:] > highest[:-1])), slip.size)
    for before, after in zip(further[:-1].tolist(), further[1:].tolist(), strict=True):
        rows, start = slice(before + 1, after), tau[before]
        if after == before + 1 or start <= 0.0:
            continue
        least, back = float(tau[rows].min()), way[before] - way[rows].min()
        if after < slip.size:
            unloads = start - least > OF_CYCLE * most and (back > BACK * reach or least < UNLOADED * start)
        else:
            unloads = back < ELASTIC * reach and tau[-1] < UNLOADED * start
        if unloads and least > -OF_CYCLE * start:
            yield rows


def over_area(rows: DataFrame, area: Area, forces: Mapping[str, str]) -> tuple[DataFrame, bool]:
    """Rows with tractions in place of forces, and whether the area shrinks in a way that a test must follow.

    forces: names of the tractions by those of the forces.
    """
    columns = [name for name in forces if name in rows]
    slip = rows["slip"].fillna(0.0).to_numpy() if "slip" in rows else np.zeros(len(rows))
    over = area(slip)
    tractions = {forces[name]: rows[name] / over for name in columns}
    changed = rows.drop(columns=columns).assign(**tractions)
    if {"peak", "residual"} & {*tractions}:
        return changed, bool(np.ptp(area(np.array([0.0, 1e-6]))) > 0.0)
    return changed, "normal_force" in columns and bool(np.ptp(over) > 0.0)


def shrinking(area: Area | None, rows: DataFrame) -> Floats | float:
    """Factor on the normal traction of a constant normal force at each row, 1 at the start of the slip."""
    if area is None or "slip" not in rows or "peak" in rows:
        return 1.0
    return np.asarray(area(np.zeros(1)) / area(rows["slip"].to_numpy()))
