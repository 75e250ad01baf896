"""Synthetic shear-box tests, and how often the intervals of a fit contain the parameters of the tests."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from asperity.contract import Floats
from asperity.fit.fitting import SAME, STARTS_TRIED, Fit, fit, residual_ratio
from asperity.fit.model import SIDES, Problem, slip_curve
from asperity.fit.records import read_records
from asperity.fit.report import draw, props_line, report
from asperity.fit.shear_test import ShearTest
from asperity.fit.units import DEFAULT
from asperity.parallel import add_workers, map_in_order, progress_bar, workers
from asperity.tables import markdown

from .program import run
from .tables import refresh

TRUTH = {"sigma0": 1.5, "Gc": 0.15, "eta": 0.9, "mu": 0.5, "theta": 20.0, "flat": 1.0 / 3.0, "kc": 20.0}
"""Parameters of the synthetic tests: mm, MPa, degrees."""

FREE = ("sigma0", "Gc", "mu", "theta")
"""Free parameters of most rows of the table."""

SET = {name: value for name, value in TRUTH.items() if name not in FREE}
"""Fixed parameters of these rows."""

SIGMA_N = (-1.0, -2.0, -4.0)
"""Normal tractions, MPa."""

TURNS = (0.8,)
CYCLE = (0.5, -0.5, 0.5)
"""Slips at the reversals, mm."""

K_N = 5.0
"""Stiffness of a box, MPa/mm."""

ROWS = 60
"""Of a test."""

FINE = 4000
FINE_CYCLE = 100000
"""Increments of a synthetic test: far more than those of a fit, whose discretisation error then shows."""

CYCLIC: dict[str, object] = {"turns": CYCLE, "rows": 150, "increments": FINE_CYCLE}
"""Arguments of `synthetic`."""

DEFAULT_NOISE = 0.03
NOISES = (0.01, 0.03, 0.10)
"""Standard deviations of the noise, as a fraction of the range of tau and of s_N in each test."""


def synthetic(
    noise: float,
    seed: int,
    truth: Mapping[str, float] = TRUTH,
    sigma_N: Sequence[float] = SIGMA_N,
    turns: Sequence[float] = TURNS,
    k_N: float = 0.0,
    rows: int = ROWS,
    dilation: bool = True,
    increments: int = FINE,
    sides: int = SIDES,
) -> list[ShearTest]:
    """Tests computed with `truth` in fine increments, with Gaussian noise on tau and s_N."""
    rng = np.random.default_rng(seed)
    nodes = np.array([0.0, *turns])
    lengths = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(nodes)))])
    slip = np.interp(np.linspace(0.0, lengths[-1], rows + 1)[1:], lengths, nodes)
    tests = []
    for number, held in enumerate(sigma_N, 1):
        clean = ShearTest(f"test {number}", slip, slip, None, held, k_N)
        problem = Problem([clean], (), truth, {}, sides, 0.0, increments)
        path = problem.paths[0]
        tau, s_N, done = slip_curve(problem.interface(truth), clean, path.slips, 0.0, 200)
        if done < path.slips.size:
            raise ValueError(f"sigma_N = {held:g}: no equilibrium at slip {path.slips[done]:g}")
        measured = [_noisy(y[path.rows], noise, rng) for y in (tau, s_N)]
        tests.append(replace(clean, tau=measured[0], s_N=measured[1] if dilation else None))
    return tests


def _noisy(y: Floats, noise: float, rng: np.random.Generator) -> Floats:
    found: Floats = y + noise * float(np.ptp(y)) * rng.standard_normal(y.size)
    return found


def write_record(path: Path, tests: Sequence[ShearTest]) -> None:
    """Text of a CSV file of tests, with five digits."""
    has_dilation = all(test.s_N is not None for test in tests)
    columns = [
        "test",
        "slip [mm]",
        "tau [MPa]",
        *(["dilation [mm]"] if has_dilation else []),
        "sigma_N [MPa]",
    ]
    lines = [",".join([*columns, "k_N [MPa/mm]"])]
    for number, test in enumerate(tests, 1):
        for i in range(test.slip.size):
            numbers = [test.slip[i], test.tau[i], *([] if test.s_N is None else [test.s_N[i]])]
            numbers += [test.sigma_N, test.k_N]
            lines.append(",".join([str(number), *(f"{number:.5g}" for number in numbers)]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def holds(found: Fit, truth: Mapping[str, float] = TRUTH) -> list[bool]:
    """Whether the interval of each free parameter, then of the residual ratio, contains the true value."""
    intervals = [(truth[name], one) for name, one in found.estimates.items()]
    intervals.append((residual_ratio(truth), found.of(residual_ratio)))
    return [one.low <= value <= one.high for value, one in intervals]


def coverage(
    noise: float,
    repetitions: int,
    free: Sequence[str] = FREE,
    tick: Callable[[], object] = lambda: None,
    starts: int = STARTS_TRIED,
    start: Mapping[str, float] | None = None,
    executor: Executor | None = None,
    **record: object,
) -> tuple[np.ndarray, list[Fit]]:
    """Fraction of tests whose 95 % interval contains the true value, by parameter and of the ratio; the fits.

    The seeds are 0, 1, ...; executor: as in `map_in_order`; record: arguments of `synthetic`.
    """
    clean = synthetic(0.0, 0, **record)  # type: ignore[arg-type]
    one_fit = partial(_noisy_fit, clean, noise, free, starts, start)
    fits = map_in_order(one_fit, range(repetitions), executor, tick)
    return np.mean([holds(one) for one in fits], axis=0), fits


def _noisy_fit(
    clean: Sequence[ShearTest],
    noise: float,
    free: Sequence[str],
    starts: int,
    start: Mapping[str, float] | None,
    seed: int,
) -> Fit:
    """Fit of tests with noise."""
    told = {name: value for name, value in TRUTH.items() if name not in free}
    rng = np.random.default_rng(seed)
    tests = [
        replace(
            one, tau=_noisy(one.tau, noise, rng), s_N=None if one.s_N is None else _noisy(one.s_N, noise, rng)
        )
        for one in clean
    ]
    return fit(tests, free, told, start=start, starts=starts, seed=seed)


STUDIES: dict[str, tuple[Sequence[str], dict[str, object]]] = {
    "CNL, dilation": (FREE, {}),
    "CNL, no dilation": (FREE, {"dilation": False}),
    "CNS, dilation": (FREE, {"k_N": K_N}),
    "cycle, dilation": (FREE, CYCLIC),
    "CNL, dilation, all seven": (tuple(TRUTH), {}),
}
"""Synthetic tests and free parameters of each row of the table."""


OWN_STARTS = 10
"""Number of tests of each row that are also fitted from random starts."""


def table(repetitions: int, executor: Executor | None = None) -> str:
    """Markdown table of the fraction of 95 % intervals with the true value, and of their median half width.

    The fits start at the true values; the first OWN_STARTS of them are repeated from random starts, and the
    last column is the number of these that reach a sum of squares as small.
    """
    head = ["test data", "noise", *TRUTH, "ratio", "found"]
    lines = []
    total = len(STUDIES) * len(NOISES) * (repetitions + min(OWN_STARTS, repetitions))
    with progress_bar(total, "fit") as bar:
        for name, (free, record) in STUDIES.items():
            for noise in NOISES:
                truth = {key: TRUTH[key] for key in free}
                shares, fits = coverage(noise, repetitions, free, bar.update, 1, truth, executor, **record)  # type: ignore[arg-type]
                names = [*free, "ratio"]
                rows = [[*one.estimates.values(), one.of(residual_ratio)] for one in fits]
                widths = np.median(
                    [[(e.high - e.low) / (2.0 * e.value) for e in row] for row in rows], axis=0
                )
                cells = {
                    key: f"{share:.0%}, {width:.1%}".replace("%", " %")
                    for key, share, width in zip(names, shares, widths, strict=True)
                }
                own = min(OWN_STARTS, repetitions)
                again = coverage(noise, own, free, bar.update, executor=executor, **record)[1]  # type: ignore[arg-type]
                reached = [b.costs[0] <= SAME * a.costs[0] for a, b in zip(fits, again, strict=False)]
                cells["found"] = f"{sum(reached)} of {len(reached)}"
                texts = [cells.get(key, "") for key in head[2:]]
                lines.append([name, f"{noise:.0%}".replace("%", " %"), *texts])
    return markdown(head, lines, numbers=True)


def example(picture: Path | None) -> str:
    """Report of `asperity fit` on the default tests, with a picture, or without dilation and picture."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "record.csv"
        write_record(path, synthetic(DEFAULT_NOISE, 0, dilation=picture is not None))
        found = fit(read_records([path]), fixed=None if picture is not None else SET)
        text = report(found, DEFAULT).replace(f"{folder}{os.sep}", "")
    if picture is not None:
        draw(found, picture, DEFAULT)
        text += f"\n\n{props_line(found)}"
    else:
        start = text.index("no dilation: mu")
        text = text[start:]
    return f"```text\n{text}\n```"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the program."""
    parser.add_argument("record", nargs="?", type=Path, metavar="RECORD.csv", help="write a synthetic record")
    parser.add_argument(
        "--noise", type=float, default=DEFAULT_NOISE, help="of the range (default: %(default)s)"
    )
    parser.add_argument("--seed", type=int, default=0, help="default: %(default)s")
    parser.add_argument("--no-dilation", action="store_true")
    parser.add_argument("--cycle", action="store_true")
    parser.add_argument("--spring", action="store_true", help=f"k_N = {K_N:g}")
    parser.add_argument("--page", type=Path, metavar="FILE.md", help="fill its markers, draw its picture")
    parser.add_argument(
        "--no-study", action="store_true", help="of the page only the example and its picture"
    )
    parser.add_argument("--repetitions", type=int, default=100, help="of the study (default: %(default)s)")
    add_workers(parser, "one for each processor")
    parser.set_defaults(action=_write)


def _write(options: argparse.Namespace) -> int:
    """Write a synthetic test to a file, or fill the numbers of the study into a page."""
    if (options.record is None) == (options.page is None):
        raise ValueError("expected RECORD.csv or --page FILE.md")
    if options.record is not None:
        path = CYCLIC if options.cycle else {}
        tests = synthetic(
            options.noise,
            options.seed,
            k_N=K_N if options.spring else 0.0,
            dilation=not options.no_dilation,
            **path,  # type: ignore[arg-type]
        )
        write_record(options.record, tests)
        print(options.record)
        return 0
    images = options.page.parents[1] / "images"
    images.mkdir(exist_ok=True)
    contents = {"fit-example": lambda: example(images / "fit.png"), "fit-coupling": lambda: example(None)}
    with workers(options, os.cpu_count() or 1) as executor:
        if not options.no_study:
            contents["fit-study"] = lambda: table(options.repetitions, executor)
        refresh(options.page, False, contents)
    print(options.page)
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program."""
    return run(add_arguments, arguments)


if __name__ == "__main__":
    sys.exit(main())
