"""Shear-box tests: files of laboratories with their columns and units, and physical checks."""

from __future__ import annotations

import re
import unicodedata
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import contract
from ..contract import Floats
from ..material import ModelWarning
from ..steps import turns_of
from ..tables import Table, raise_all, read_table, size

if TYPE_CHECKING:
    from pandas import DataFrame

REQUIRED, ENVELOPE = ("slip", "tau", "sigma_N"), ("slip", "peak", "residual", "sigma_N")
OPTIONAL = ("dilation", "k_N", "test")  # the first one not in an envelope
KNOWN = tuple(dict.fromkeys(REQUIRED + ENVELOPE + OPTIONAL))
"""Columns of a file; ENVELOPE: a row for each test."""

KINDS = {"slip": "length", "dilation": "length", "k_N": "stiffness"}
KINDS |= dict.fromkeys(("tau", "sigma_N", "peak", "residual"), "stress")
DEFAULT, NONE = ("mm", "MPa"), ("length", "stress")
"""What each column measures; units to which numbers with units are converted, and labels without units."""

LEAST_ROWS, SATURATED, LEAST_PART, FAR = 5, 0.7, 4, 0.98
"""Rows of a test: fewer show no stiffness, peak or residual strength.  Ratio of two slopes of the dilation
below which it ends, and smallest number of rows of a slope.  Slip over the largest one that counts as it.
"""

LEAP, RETURN, NEAR, REVERSED = 3.0, 0.5, 0.1, -0.1
"""Where the slip jumps back to its start the next test begins: smallest jump over the usual step and over the
way so far; distance from the start over this way, and smallest way over that of the file; and smallest tau
over the largest one, because the return stroke of a cycle reverses tau.
"""

HELD, SPRING = 0.05, 0.7
"""Largest relative variation of a constant normal traction, and largest part of its change that k_N times the
dilation need not explain.
"""

LARGEST_RATIO, LARGEST_FRICTION, UNUSUAL = 1.0e3, 100.0, 3.0
"""Ratios of two lengths or stresses above which units are mixed (kPa to MPa is near 1000); of tau to
|sigma_N| without units (a friction of 0.8 on planes of 45 degrees gives 9); and one that is unusual.
"""

STEEPEST, SHALLOWEST, OFFSET, CLOSES = 20.0, 1.0e-3, 0.5, 3.0
"""Ratios of dilation to slip of planes of 87 degrees, and below which the dilation is doubted; largest first
dilation or slip over its range; ratio of closure to opening above which the sign is doubted.
"""

LONGEST_PATH, MOST_TURNS = 5.0, 1.0 / 3.0
"""Length of the slip path over its range, and fraction of rows with a reversal, of rows out of order."""

USUAL = {"length": (1e-6, 1.0), "stress": (1e3, 2e8)}
"""Usual sizes of the largest slip, in metres, and of the largest stress, in pascals."""

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


def refuse(wrong: object, text: str) -> None:
    """Raise ValueError where something is wrong."""
    if wrong:
        raise ValueError(text)


def doubt(odd: object, text: str) -> None:
    """Give a ModelWarning where something is odd."""
    if odd:
        warnings.warn(text, ModelWarning, stacklevel=2)


@dataclass(frozen=True, eq=False)
class ShearTest:
    """One test: slip (T,) and s_N (T,), None where not measured, length; tau (T,), stress.

    s_N counts from the start of the slip, opening positive.  sigma_N: normal traction there, stress, <= 0;
    k_N: normal stiffness of the box, stress/length, 0 where sigma_N is constant.  name: file and test.
    units: of length and stress where the file has them.  lines (T,): of the file, empty where there is none.
    path_N (T,): measured normal traction of each row, None where sigma_N and k_N give it.  envelope: the two
    rows are the peak, at a slip that is not known, and the residual strength.
    Raises ValueError for inadmissible data.
    """

    name: str
    slip: Floats
    tau: Floats
    s_N: Floats | None
    sigma_N: float
    k_N: float = 0.0
    units: dict[str, str] = field(default_factory=dict)
    lines: tuple[int, ...] = ()
    path_N: Floats | None = None
    envelope: bool = False

    def __post_init__(self) -> None:
        """Check shapes and values."""
        for name in ("slip", "tau", "s_N", "path_N"):
            if getattr(self, name) is None:
                continue
            values = contract.array(name, getattr(self, name))
            object.__setattr__(self, name, values)
            refuse(not values.size, f"{self.name}: {name} has no rows: expected some")
            wrong = values.shape != (self.slip.size,) or not np.isfinite(values).all()
            wanted = f"expected finite numbers of shape ({self.slip.size},)"
            refuse(wrong, f"{self.name}: {name} has shape {values.shape}: {wanted}")
            same = name in ("slip", "tau") and not np.ptp(values) > 0.0 and not self.envelope
            text = f"{self.name}: column {name} is {values[0]:g} in all rows: expected values that change"
            refuse(same, text)
        for name in ("sigma_N", "k_N"):
            object.__setattr__(self, name, contract.number(name, getattr(self, name)))
        worst = self.sigma_N if self.path_N is None else max(self.sigma_N, *self.path_N)
        pressed, stiff = -np.inf < worst <= 0.0, 0.0 <= self.k_N < np.inf
        refuse(not pressed, f"{self.name}: sigma_N = {worst:g}: expected a finite compression, <= 0")
        refuse(not stiff, f"{self.name}: k_N = {self.k_N:g}: expected a finite stiffness >= 0")

    @property
    def pressed(self) -> float:
        """Normal traction of the largest size, stress."""
        return self.sigma_N if self.path_N is None else float(self.path_N.min())

    @property
    def turns(self) -> list[float]:
        """Slips at the reversals, and the last slip."""
        path = np.append(0.0, self.slip)
        return list(path[turns_of(path)[1:]].tolist())

    @property
    def ends_far(self) -> bool:
        """Whether the test ends at its largest slip, and not within a cycle."""
        return bool(abs(self.slip[-1]) >= FAR * np.abs(self.slip).max())

    @property
    def saturates(self) -> bool:
        """Whether the dilation ends: its slope at the end of the first stroke is well below that before."""
        if self.s_N is None or self.envelope:
            return False
        end = int(np.argmax(np.abs(self.slip) >= FAR * np.abs(self.slip).max()))
        way = self.slip[: end + 1] / self.slip[end]
        parts = [np.flatnonzero((way >= low) & (way <= high)) for low, high in ((0.25, 0.5), (0.75, 1.0))]
        if min(map(len, parts)) < LEAST_PART:
            return False
        before, at_end = (np.polyfit(way[part], self.s_N[part], 1)[0] for part in parts)
        return bool(at_end < SATURATED * before)

    def place(self, row: int) -> str:
        """Name of the test, with the line of a row where it comes from a file."""
        return f"{self.name}: line {self.lines[row]}" if self.lines else self.name


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
        good = value is None or (0.0 <= value < np.inf and (value or name == "k_N"))
        refuse(not good, f"{name} = {value or 0.0:g}: expected a finite stiffness {least}")
    other = next((name for name in columns or {} if name not in KNOWN), "")
    refuse(other, f"columns: {other}: expected one of {', '.join(KNOWN)}")
    held = [] if sigma_N is None else np.atleast_1d(contract.array("sigma_N", sigma_N)).tolist()
    shown = f"sigma_N = {contract.shown(sigma_N)}"
    refuse(not np.isfinite(held).all(), f"{shown}: expected finite tractions")
    files = [Path(path) for path in ([paths] if isinstance(paths, str | Path) else paths)]
    refuse(not files, "no test: expected a file")
    for path in files:
        same = [one.resolve() for one in files].count(path.resolve()) > 1
        refuse(same, f"{path}: given twice: expected each file once")
    sign = -1.0 if compression_positive else 1.0
    found = _of_all(files, lambda path: _read(path, target, columns or {}, sign, bool(held)))
    without = [rows for rows in found if "sigma_N" not in rows]
    both = held and not without
    refuse(both, f"{shown}: expected no value beside a column sigma_N, which every file has")
    text = f"sigma_N: {len(held)} values for {len(without)} tests without that column: expected one for each"
    refuse(len(held) > 1 and len(held) != len(without), f"{text}, or one for all")
    for i, rows in enumerate(without):
        rows["sigma_N"] = -abs(held[i % len(held)])
    for rows in found:
        if "k_N" not in rows or rows.k_N.isna().all():
            rows["k_N"] = k_N or 0.0
    tests: list[ShearTest] = _of_all(found, lambda rows: _tests(rows, k_T, sigma_N_path, sign))
    _check_all(tests)
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


def check_target(units: Sequence[str]) -> tuple[str, str]:
    """Units of length and stress; raises ValueError for anything else."""
    given = f"--units {','.join(units)}"
    refuse(len(units) != len(NONE), f"{given}: expected LENGTH,STRESS, such as mm,MPa")
    for kind, unit in zip(NONE, units, strict=True):
        size(kind, unit, f"{given}: ")
    return units[0], units[1]


def _factors(where: str, given: Mapping[str, str], target: tuple[str, str]) -> list[float]:
    """Factor of every column from its unit to that of the target, 1 where no column has a unit."""
    wanted = dict(zip(NONE, target, strict=True)) | {"stiffness": "({1})/({0})".format(*target)}
    first = next((f"{name} [{unit}]" for name, unit in given.items() if unit), "")
    without = next((name for name, unit in given.items() if first and not unit), "")
    text = f"column {without} has no unit: expected one for every column, as {first} has, or none at all"
    refuse(without, f"{where}: {text}")
    kinds = ((KINDS[name], unit, f"{where}: {name} ") for name, unit in given.items() if first)
    return [size(*one) / size(one[0], wanted[one[0]]) for one in kinds] or [1.0] * len(given)


def _read(
    path: Path, target: tuple[str, str] | None, renamed: Mapping[str, str], sign: float, optional: bool
) -> list[DataFrame]:
    """Rows of each test of a file by line, in the units of the target.

    Their attributes are the name of the test, its file and the units.  optional: sigma_N may be missing.
    """
    from pandas import DataFrame

    table = read_table(path, f"a CSV file with {', '.join(REQUIRED)}")
    none = f"{path}: no rows: expected a header with slip, tau, sigma_N, then numbers"
    refuse(not table.names, none)
    names = _columns(table, renamed, optional)
    measured = {name: unit for name, unit in zip(names, table.units, strict=True) if name in KINDS}
    factors = _factors(f"{path}: line {table.line}", measured, target or DEFAULT)
    refuse(not len(table.cells), none)
    data = table.numbers([names.index(name) for name in measured], [*measured], [*measured]) * factors
    rows = DataFrame(data, index=table.lines, columns=[*measured])
    if "sigma_N" in rows:
        rows["sigma_N"] *= sign
    labels = target or (DEFAULT if any(measured.values()) else ())
    of_test = table.cells[names.index("test")] if "test" in names else [""] * len(rows)
    # only a column with this very name says that its rows are one test, also where the slip starts again
    apart = "test" not in {*map(str.lower, table.names), *renamed}
    found, left_out, returns = [], [], []
    for test, group in rows.groupby(np.array(of_test, dtype=object), sort=False):
        # a column without any number in a test is not measured in it
        unused = [name for name in ("dilation", "k_N") if name in group and group[name].isna().all()]
        kept = group.drop(columns=unused).dropna(subset=[*{*group} - {"k_N", *unused}])
        left_out += sorted({*group.index} - {*kept.index})
        starts = [0, *(_starts(kept) if apart and {"slip", "tau"} <= {*kept} else []), len(kept)]
        returns += [str(kept.index[start]) for start in starts[1:-1]]
        for number in range(1, len(starts)):
            part = kept[starts[number - 1] : starts[number]].copy()
            label = ".".join([test] * bool(test) + [str(number)] * (len(starts) > 2))
            part.attrs["name"] = f"{path}: test {label}" if label else str(path)
            part.attrs |= {"path": str(path), "units": dict(zip(NONE, labels, strict=False))}
            found.append(part)
    text = f"{path}: the slip jumps back to its start in line {', '.join(returns)}: read as the next test; a "
    doubt(returns, f"{text}column test with the same entry in all rows makes them one")
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
    text = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().strip()
    rules = {} if re.search(OTHER, text) else RULES
    return next((column for column, rule in rules.items() if re.match(rule, text)), name)


def _columns(table: Table, renamed: Mapping[str, str], optional: bool) -> list[str]:
    """Columns of the file, "" for those that are not used.

    A name of the user comes before one of this program, and this before one of a laboratory.
    """
    headers, lower = table.names, [name.lower() for name in table.names]
    there = f"{table.path}: line {table.line}: columns {', '.join(headers)}: expected"
    missing = [header for header in renamed.values() if header.lower() not in lower]
    refuse(missing, f"{there} {', '.join(missing)}, too (--columns)")
    exact = {name.lower(): name for name in KNOWN if name not in renamed}
    exact |= {header.lower(): name for name, header in renamed.items()}
    taken = {*renamed, *(exact[name] for name in lower if name in exact)}
    names = [exact.get(name.lower(), name if standard(name) in taken else standard(name)) for name in headers]
    required = ENVELOPE if {"peak", "residual"} & {*names} and "tau" not in names else REQUIRED
    missing = [name for name in required if name not in names and not (optional and name == "sigma_N")]
    needed = f"needed: {', '.join(required)}; as measured: {', '.join(OPTIONAL)}; forces over the area"
    other = f"--columns {''.join(missing[:1])}=HEADER, in Python columns=, for a column with another name"
    more = "--sigma-N VALUE for files without sigma_N"
    refuse(missing, f"{there} {', '.join(missing)}, too ({needed}; {other}; {more})")
    twice = next((name for name in KNOWN if names.count(name) > 1), "")
    text = f"column {twice} is there twice: expected one, or --columns {twice}=HEADER"
    refuse(twice, f"{table.path}: line {table.line}: {text}")
    used = required + OPTIONAL[required is ENVELOPE :]
    unused = [header for header, name in zip(headers, names, strict=True) if name not in used]
    doubt(unused, f"{table.path}: columns not used: {', '.join(unused)}")
    return [name if name in used else "" for name in names]


def _tests(rows: DataFrame, k_T: float | None, sigma_N_path: bool, sign: float) -> list[ShearTest]:
    """Test from its rows, or a test for each row of an envelope, after checks of the rows."""
    name, path, unit, stiffness = *rows.attrs.values(), rows.k_N.dropna()
    envelope = "tau" not in rows

    def each(column: str, wrong: Any, text: str) -> None:
        """Refuse the first row where a column is wrong; text: with its value."""
        for line, value in rows[column][wrong].items():
            raise ValueError(f"{path}: line {line}, column {column}: " + text.format(value))

    several = f"{path}: column k_N: {stiffness.nunique()} values: expected one a test"
    refuse(stiffness.nunique() > 1 and not envelope, several)
    wanted = f"expected compression, <= 0 ({'leave out' if sign < 0.0 else 'or give'} --compression-positive)"
    shown = f"{'' if sign > 0.0 else '-'}{{:g}} {unit.get('stress', '')}".rstrip()
    each("sigma_N", rows.sigma_N > 0.0, f"{shown} is tension: {wanted}")
    each("k_N", rows.k_N < 0.0, "{:g}: expected a stiffness >= 0")
    least = 1 if envelope else LEAST_ROWS
    refuse(len(rows) < least, f"{name}: {len(rows)} rows: expected at least {least}")
    if not envelope:
        return [_test(rows, k_T, sigma_N_path, sign)]
    refuse(k_T or sigma_N_path, f"{name}: k_T, sigma_N_path: expected columns {', '.join(REQUIRED)}")
    each("slip", rows.slip <= 0.0, "{:g}: expected > 0")
    each("residual", rows.residual <= 0.0, "{:g}: expected > 0")
    weak = rows.residual[rows.peak < rows.residual]
    each("peak", weak.index, f"{{:g}}: expected at least the residual strength, {weak.iloc[:1].sum():g}")
    # the slip of the peak is not read
    return [
        ShearTest(
            f"{path}: line {line}", np.array([0.5, 1.0]) * row.slip, np.array([row.peak, row.residual]), None,
            row.sigma_N, np.nan_to_num(row.k_N), unit, (line, line), envelope=True,
        )
        for line, row in rows.iterrows()
    ]  # fmt: skip


def _test(rows: DataFrame, k_T: float | None, sigma_N_path: bool, sign: float) -> ShearTest:
    """Test from its rows, after checks of the rows against each other."""
    name, path, lines = rows.attrs["name"], rows.attrs["path"], tuple(rows.index.tolist())
    slip, tau, sigma_N = (rows[column].to_numpy() for column in REQUIRED)
    s_N = rows["dilation"].to_numpy() if "dilation" in rows else None
    stiffness = float(rows.k_N.dropna().iloc[0])
    if k_T is not None:
        backward = np.flatnonzero(np.diff(np.abs(slip)) < 0.0)
        first = int(np.argmax(np.abs(tau[: backward[0] + 1 if backward.size else None])))
        before, off = slip[first], tau / k_T
        text = f"{path}: line {lines[first]}: k_T = {k_T:g} takes {off[first]:g} off the slip {before:g}"
        least, slip = tau[first] / (before or np.nan), slip - off
        refuse(slip[first] * before <= 0.0, f"{text}: expected more than tau/slip = {least:g}")
    beside = f"{name}: k_N = {stiffness:g}: expected no stiffness beside a prescribed sigma_N"
    refuse(sigma_N_path and stiffness > 0.0, beside)
    held = float(sigma_N[0] if sigma_N_path else np.mean(sigma_N))
    worst = int(np.argmax(np.abs(sigma_N - held)))
    text = f"column sigma_N: {sign * sigma_N[worst]:g} is more than {HELD:.0%} off the mean {sign * held:g}"
    wanted = "expected a constant normal traction, k_N, a column test for several tests, or --sigma-N-path"
    varies = stiffness == 0.0 and not sigma_N_path and abs(sigma_N[worst] - held) > HELD * abs(held)
    refuse(varies, f"{path}: line {lines[worst]}, {text}: {wanted}")
    if stiffness > 0.0 and np.ptp(sigma_N) > 0.0:
        # sigma_N at the start of the slip, extrapolated from the rows by k_N and the dilation
        held = float(sigma_N[0] if s_N is None else np.mean(sigma_N + stiffness * s_N))
    path_N = sigma_N if sigma_N_path else None
    test = ShearTest(name, slip, tau, s_N, held, stiffness, rows.attrs["units"], lines, path_N)
    _check(test, sigma_N)
    return test


def _check(test: ShearTest, sigma_N: Floats) -> None:
    """Check signs, start and order of the rows of a test; sigma_N (T,): as measured."""
    name, slip, slips, first = test.name, test.slip, float(np.ptp(test.slip)), test.place(0)
    work = float(0.5 * (test.tau + np.append(0.0, test.tau[:-1])) @ np.diff(slip, prepend=0.0))
    text = f"{name}: columns slip, tau: the work of tau along the slip is {work:.3g} < 0: expected tau > 0"
    refuse(work < 0.0, f"{text} where the slip grows; change the sign of one of the columns")
    late = f"{slip[0]:g} in the first row: expected slips from 0 on, as those of the model"
    refuse(abs(float(slip[0])) > OFFSET * slips, f"{first}, column slip: {late}")
    way, turns = float(np.abs(np.diff(slip)).sum()) / slips, len(test.turns) - 1
    text = f"{name}: the slip reverses at {turns} of {slip.size} rows and covers {way:.0f} times its range: "
    shuffled = way > LONGEST_PATH and turns > MOST_TURNS * slip.size
    doubt(shuffled, f"{text}expected the rows in the order of the test")
    if test.s_N is None:
        return
    s_N, change, worst = test.s_N, float(np.ptp(test.s_N)), int(np.argmax(np.abs(test.s_N)))
    column, last = f"{name}: column dilation", float(s_N[-1])
    text = f"column dilation: {s_N[worst]:g} over slips up to {np.abs(slip).max():g}: expected the unit of"
    refuse(change > STEEPEST * slips, f"{test.place(worst)}, {text} slip (at most {STEEPEST:g} times it)")
    text = f"{column} changes by {change:.3g} over slips of {slips:.3g}: expected the unit of slip, or no"
    doubt(0.0 < change < SHALLOWEST * slips, f"{text} such column for a joint that does not dilate")
    offset = abs(float(s_N[0])) > STEEPEST * abs(float(slip[0])) + OFFSET * change
    text = f"column dilation: {s_N[0]:g} at slip {slip[0]:g}: expected the change since the start"
    refuse(offset, f"{first}, {text} of the slip")
    closes = -float(s_N.min()) > CLOSES * max(float(s_N.max()), 0.0) and -last > OFFSET * change
    text = f"{column}: {last:g} at the end, the joint closes as it slips: expected dilation > 0"
    doubt(closes, f"{text} where the joint opens")
    opening, change = test.k_N * (s_N - s_N[0]), float(np.ptp(sigma_N))
    left = float(np.abs(sigma_N - sigma_N[0] + opening).max()) > SPRING * max(change, float(np.ptp(opening)))
    refuse(
        test.k_N > 0.0 and change > HELD * np.abs(sigma_N).max() and left,
        f"{name}: column k_N: {test.k_N:g} times the dilation changes sigma_N by up to {np.ptp(opening):g}, "
        f"the column by {change:g}: expected stress/length in the units of tau and slip, and dilation > 0 "
        "where it opens",
    )


def _check_all(tests: Sequence[ShearTest]) -> None:
    """Check units of the tests against each other.  Raises ValueError or gives a ModelWarning."""
    with_units, without = ([one.name for one in tests if bool(one.units) == which] for which in (True, False))
    text = f"expected units in every file, as in {''.join(with_units[:1])}, or in none"
    refuse(with_units and without, f"{''.join(without[:1])}: no units in the header: {text}")
    stress = max(max(abs(test.pressed), float(np.abs(test.tau).max())) for test in tests)
    for test in tests:
        ends = (0.0, 0.0) if test.s_N is None else (float(np.ptp(test.s_N)), float(test.s_N[-1]))
        change, last = (test.k_N * one for one in ends)
        text = f"{test.name}: column k_N: {test.k_N:g} changes sigma_N by {change:g}: expected at most"
        huge = change > LARGEST_RATIO * stress
        refuse(huge, f"{text} {LARGEST_RATIO * stress:g}, as stress/length in the units of tau and slip")
        most = LARGEST_RATIO if test.units else LARGEST_FRICTION
        held = abs(test.sigma_N - last if test.path_N is None else float(test.path_N[-1]))
        tau = float(np.mean(np.abs(test.tau[-max(1, test.slip.size // 10) :])))
        text = f"{test.name}: column tau: {tau:.3g} at the end where |sigma_N| is {held:.3g}: expected the"
        text += f" same unit (a ratio of {1.0 / most:g} to {most:g}), or units in the header, as tau [kPa]"
        refuse(held > 0.0 and not 1.0 / most <= tau / held <= most, text)
        text = f"{test.name}: tau is {tau / (held or 1.0):.3g} times |sigma_N| at the end, which is unusual"
        doubt(held > 0.0 and tau > UNUSUAL * held, f"{text}: check the units")
    slip = max(float(np.abs(test.slip).max()) for test in tests)
    for kind, largest in (("length", slip), ("stress", stress)) if with_units else ():
        unit, (low, high) = tests[0].units[kind], USUAL[kind]
        text = f"the largest {kind} is {largest:.3g} {unit}, which is unusual for a shear box: check the"
        doubt(not low <= largest * size(kind, unit) <= high, f"{text} units of the header")
