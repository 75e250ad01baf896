"""Fits of tests by laws that are not that of asperity: `python -m harness.studies.fits --write 20`.

The tables say how often the truth lies within the intervals, and how often nonsense is taken for a result.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas
from asperity.tools.fit import ShearTest, fit, read_tests
from asperity.tools.fit.intervals import Estimate
from asperity.tools.fit.model import AUTO
from asperity.tools.fit.strengths import fit_strengths
from asperity.tools.fit.verdict import compared, of_law
from asperity.tools.tables import markdown

from .other_laws import KINDS, Drawn
from .other_strengths import STRENGTHS, Strengths
from .program import DIFFERS, program
from .tables import refreshed

DATA = Path(__file__).parent / "validation" / "data" / "fits.csv"
PAGE = Path(__file__).parents[2] / "docs" / "validation" / "fits.md"
"""What was found in each set, and the page."""

FOLDER = "HEAD:python/asperity/tools/fit"
"""The fit in the last commit."""

GIVEN = "--joint "
"""Words of the name of a law before the form of the joint, if that is known."""

MET, WRONG = 0.05, 0.15
"""Scatter over the range of a set that the law meets, and error of a wrong prediction: peak or residual at a
pressure between those of the tests, which the fit has not seen.
"""

Row = dict[str, object]
"""Set, exit code, seconds and what was found of one constant."""


def tests_of(drawn: Drawn) -> list[ShearTest]:
    """Drawn tests as those of a fit."""
    return [
        ShearTest(f"test {i}", test.slip, test.tau, test.dilation, -test.pressure, test.k_N)
        for i, test in enumerate(drawn.tests, 1)
    ]


def read_back(tests: Sequence[ShearTest]) -> list[ShearTest]:
    """Tests through a file, which is read and checked as that of a laboratory."""
    frames = []
    for test in tests:
        columns = {
            "test": test.name,
            "slip": test.slip,
            "tau": test.tau,
            "sigma_N": -test.sigma_N,
            "k_N": test.k_N,
        }
        frames.append(pandas.DataFrame(columns | ({} if test.s_N is None else {"dilation": test.s_N})))
    return _through_file(pandas.concat(frames))  # type: ignore[return-value]


def _through_file(frame: pandas.DataFrame) -> object:
    """Tests of a table as `asperity fit` reads them."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tests.csv"
        frame.to_csv(path, index=False)
        return read_tests(path)


def judged(job: tuple[str, int, int]) -> list[Row]:
    """What a fit finds of the truth of one set: a row for each constant or number."""
    kind, seed, number = job
    rng, begin = np.random.default_rng([seed, number]), time.process_time()
    of_set: Row = {"kind": kind, "seed": seed, "set": number}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            if kind in STRENGTHS:
                summary, rows = _strengths(STRENGTHS[kind](rng))
            else:
                summary, rows = _curves(KINDS[kind](rng), kind.partition(GIVEN)[2] or AUTO)
        except ValueError:
            summary, rows = {"code": 1, "grade": "", "met": np.inf}, []
    of_set |= summary | {"cpu": time.process_time() - begin}
    return [of_set | row for row in ({"name": ""}, *rows)]


def _curves(drawn: Drawn, joint: str) -> tuple[Row, list[Row]]:
    """Summary of the fit of curves, and a row for each constant or number."""
    fitted = fit(read_back(tests_of(drawn)), joint)
    errors = fitted.errors
    summary: Row = {"code": 0 if fitted.is_result else 3, "grade": fitted.grade}
    summary |= {"met": errors["scatter"], "between": np.nan}
    if drawn.held is not None:
        held = tests_of(drawn._replace(tests=[drawn.held]))
        problem = of_law(fitted.solution, [*fitted.tests, *held])
        off = compared(problem, fitted.values, len(fitted.tests))[0].errors
        summary["between"] = max(off["peak"], off["residual"])
    rows = [
        _row(name, truth, fitted.estimates[name])
        for name, truth in drawn.truth.items()
        if name in fitted.estimates
    ]
    for test, numbers in enumerate(drawn.numbers):
        rows += [_row(name, (true, true), fitted.number(test, name)) for name, true in numbers.items()]
    return summary, rows


def _strengths(drawn: Strengths) -> tuple[Row, list[Row]]:
    """The same of the strengths of a table."""
    columns = {"sigma_N": drawn.pressure, "peak": drawn.peak}
    columns |= {} if drawn.residual is None else {"residual": drawn.residual}
    fitted = fit_strengths(_through_file(pandas.DataFrame(columns)))  # type: ignore[arg-type]
    pressure, peak = drawn.between
    summary: Row = {"code": 0 if fitted.is_result else 3, "grade": fitted.grade}
    summary["met"] = max(error for name, error in fitted.errors.items() if not name.startswith("blind"))
    summary["between"] = abs(float(fitted.peak(np.array([pressure]))[0]) / peak - 1.0)
    # tan(phi) and c are those of a straight line alone
    bond = "sigma0" in fitted.estimates
    rows = [
        _row(name, truth, fitted.estimates[name])
        for name, truth in drawn.truth.items()
        if name in fitted.estimates and (bond or drawn.residual is not None)
    ]
    rows += [
        _row("peak", (true, true), peak)
        for true, peak in zip(drawn.exact.tolist(), fitted.peaks, strict=True)
    ]
    return summary, rows


def _row(name: str, truth: tuple[float, float], estimate: Estimate) -> Row:
    """A constant or number: ends of what is true, value and interval."""
    ends = {"true_low": truth[0], "true_high": truth[1]}
    return {"name": name} | ends | {"value": estimate.value, "low": estimate.low, "high": estimate.high}


def table(rows: pandas.DataFrame) -> str:
    """Coverage, widths and errors of each constant by kind of truth, of the sets that end with 0."""
    lines, last = [], None
    for (kind, name), part in rows[rows.name.notna() & (rows.name != "")].groupby(
        ["kind", "name"], sort=False
    ):
        if str(kind).endswith("nonsense"):
            continue
        accepted = part[part.code == 0]
        # a law stands at its first constant
        cells = ["" if kind == last else str(kind), str(name)]
        last = kind
        for chosen in (accepted, part):
            inside = (chosen.low <= chosen.true_high) & (chosen.true_low <= chosen.high)
            cells.append(f"{inside.sum()} of {len(chosen)}")
        size = accepted.value.abs()
        half = np.maximum(accepted.high - accepted.value, accepted.value - accepted.low) / size
        nearest = accepted.value.clip(accepted.true_low, accepted.true_high)
        error = (accepted.value - nearest).abs() / nearest.abs()
        medians = [float(column.median()) for column in (half, error)]
        # a bond that is not there has no relative error
        cells += [f"{100.0 * median:.1f}" if np.isfinite(median) else "-" for median in medians]
        lines.append(cells)
    head = ["law", "constant", "inside, code 0", "inside, all", "half width, median, %", "error, median, %"]
    return markdown(head, lines)


def sets(rows: pandas.DataFrame) -> str:
    """Number of sets that end with 0, wrong predictions, and times, by kind of truth."""
    lines = []
    for kind, part in rows[rows.name.isna() | (rows.name == "")].groupby("kind", sort=False):
        met, nonsense = part[part.met <= MET], str(kind).endswith("nonsense")
        seeds = ", ".join(str(seed) for seed in sorted({*part.seed}))
        met_text = "-" if nonsense else f"{(met.code == 0).sum()} of {len(met)}"
        predicted = part[(part.code == 0) & part.between.notna()]
        wrong = (
            "-"
            if nonsense or not len(predicted)
            else f"{(predicted.between > WRONG).sum()} of {len(predicted)}"
        )
        times = f"{part.cpu.median():.1f} / {part.cpu.max():.1f}"
        codes = [str((part.code == code).sum()) for code in (0, 3, 1)]
        lines.append([str(kind), seeds, str(len(part)), *codes, met_text, wrong, times, *{*part.state}])
    head = ["law", "seed", "sets", "code 0", "code 3", "refused", "met within 5 %: with 0"]
    head += ["code 0: wrong between", "CPU, median / largest, s", "state"]
    return markdown(head, lines)


def state() -> str:
    """Hash of the folder of the fit in the last commit, which tells the state of the fit that a row is of."""
    command = ["git", "-C", str(PAGE.parent), "rev-parse", "--short=8", FOLDER]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def _write(options: argparse.Namespace) -> int:
    """Fit drawn sets, if asked for, and fill the page."""
    if options.write:
        kinds = [kind for kind in (*KINDS, *STRENGTHS) if not options.kind or kind.startswith(options.kind)]
        jobs = [(kind, options.seed, number) for kind in kinds for number in range(options.write)]
        with ProcessPoolExecutor(1, get_context("spawn")) as pool:
            judgements: Iterable[list[Row]] = pool.map(judged, jobs)
            frame = pandas.DataFrame([row for rows in judgements for row in rows]).assign(state=state())
        if DATA.exists():
            before = pandas.read_csv(DATA, dtype={"state": str})
            frame = pandas.concat([before[~before.kind.isin(kinds)], frame])
        frame.to_csv(DATA, index=False, float_format="%.5g")
    if not DATA.exists():
        print(f"{DATA}: expected a file that --write has written")
        return DIFFERS
    rows = pandas.read_csv(DATA, dtype={"state": str})
    contents = {"fits-coverage": lambda: table(rows), "fits-sets": lambda: sets(rows)}
    return refreshed(PAGE, options.check, contents)


main = program(
    _write,
    ("--write SETS", "draw and fit this many sets of each law, in place of those of it; else use these", 0),
    ("--seed SEED", "of the sets", 0),
    ("--kind LAW", "start of the name of one law", ""),
    ("--check", "write nothing; exit with 1 if the page differs"),
)

if __name__ == "__main__":
    sys.exit(main())
