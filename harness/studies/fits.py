"""How often the intervals of a fit contain the parameters of synthetic tests, for docs/results/fit.md."""

from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from asperity.fit.fitting import STARTS_TRIED, fit
from asperity.fit.outcome import SAME, Fit, residual_ratio
from asperity.fit.picture import draw
from asperity.fit.records import read_tests
from asperity.fit.report import props_line, report
from asperity.fit.shear_test import ShearTest
from asperity.fit.units import DEFAULT
from asperity.options import add_workers, progress_bar, workers
from asperity.parallel import map_in_order
from asperity.tables import markdown

from .program import run
from .synthetic import (
    CYCLIC,
    DEFAULT_NOISE,
    FREE,
    K_N,
    TRUTH,
    noisy,
    synthetic,
    write_record,
)
from .tables import refresh

NOISES = (0.01, 0.03, 0.10)
"""Standard deviations of the noise, as a fraction of the range of tau and of s_N in each test."""


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
            one, tau=noisy(one.tau, noise, rng), s_N=None if one.s_N is None else noisy(one.s_N, noise, rng)
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
    head = ["test data, all in %", "noise", *TRUTH, "ratio", "found"]
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
                    key: f"{100.0 * share:.0f}, {100.0 * width:.1f}"
                    for key, share, width in zip(names, shares, widths, strict=True)
                }
                own = min(OWN_STARTS, repetitions)
                again = coverage(noise, own, free, bar.update, executor=executor, **record)[1]  # type: ignore[arg-type]
                reached = [b.costs[0] <= SAME * a.costs[0] for a, b in zip(fits, again, strict=False)]
                cells["found"] = f"{sum(reached)}/{len(reached)}"
                texts = [cells.get(key, "") for key in head[2:]]
                lines.append([name, f"{100.0 * noise:g}", *texts])
    return markdown(head, lines, numbers=True)


def example(picture: Path) -> str:
    """Report of `asperity fit` on the default tests, but for correlations, and its picture."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "record.csv"
        write_record(path, synthetic(DEFAULT_NOISE, 0))
        found = fit(read_tests([path]))
        text = report(found, DEFAULT).replace(f"{folder}{os.sep}", "")
    draw(found, picture, DEFAULT)
    text = re.sub(r"correlation .*?\n\n", "", text, flags=re.DOTALL)
    return f"```text\n{text}\n\n{props_line(found)}\n```"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the program."""
    parser.add_argument("page", type=Path, metavar="FILE.md", help="fill its markers, draw its picture")
    parser.add_argument(
        "--no-study", action="store_true", help="of the page only the example and its picture"
    )
    parser.add_argument("--repetitions", type=int, default=100, help="of the study (default: %(default)s)")
    add_workers(parser)
    parser.set_defaults(action=_write)


def _write(options: argparse.Namespace) -> int:
    """Fill the numbers of the study into a page."""
    images = options.page.parents[1] / "images"
    images.mkdir(exist_ok=True)
    contents = {"fit-example": lambda: example(images / "fit.png")}
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
