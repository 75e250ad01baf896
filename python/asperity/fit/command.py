"""Command `asperity fit`: parameters from shear-box tests."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from tqdm import tqdm

from ..remarks import shown_warnings
from .fitting import DEFAULT_FIXED, DEFAULT_FREE, STARTS_TRIED, Fit, NoScipyError, fit
from .model import INCREMENTS, SCALES, SIDES
from .records import ShearTest, read_records, unit_name

PATIENCE = 2.0
"""Seconds before progress is shown."""

BAD_INPUT = 1

HOSTS = ("abaqus", "calculix", "kratos")

DEFAULT_UNITS = {"length": "mm", "stress": "MPa"}
"""Units where neither the files nor the user give any."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    parser.add_argument(
        "records",
        nargs="+",
        type=Path,
        metavar="DATA.csv",
        help="CSV with columns slip, tau, sigma_N and, if measured, dilation, k_N, test",
    )
    add_search(parser, DEFAULT_FREE, DEFAULT_FIXED)
    parser.add_argument(
        "--k-N",
        type=float,
        dest="k_N",
        metavar="STIFFNESS",
        help="normal stiffness of the box (CNS), for all tests",
    )
    parser.add_argument(
        "--compression-positive", action="store_true", help="sigma_N in the files is > 0 in compression"
    )
    parser.add_argument(
        "--confidence", type=float, default=0.95, help="confidence of the intervals (default: %(default)s)"
    )
    parser.add_argument(
        "--units",
        metavar="LENGTH,STRESS",
        help=f"for labels (default: those of the record, or {','.join(DEFAULT_UNITS.values())})",
    )
    parser.set_defaults(action=_run)


def add_search(parser: argparse.ArgumentParser, free: Iterable[str], fixed: Mapping[str, float]) -> None:
    """Add the options of the search and of its results; free and fixed are the defaults that help names."""
    known = ", ".join(f"{name}={value:.4g}" for name, value in fixed.items())
    parser.add_argument(
        "--free",
        default=",".join(free),
        metavar="NAMES",
        help=f"parameters to identify, of {','.join(SCALES)} (default: %(default)s)",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help=f"fixed parameters (default: {known})",
    )
    parser.add_argument(
        "--start", action="append", default=[], metavar="NAME=VALUE", help="additional start of the search"
    )
    parser.add_argument(
        "--bounds", action="append", default=[], metavar="NAME=LOW,HIGH", help="bounds of a free parameter"
    )
    parser.add_argument(
        "--sides",
        type=int,
        default=SIDES,
        help="inclined planes: 2 for a ridge across the slip (RT), 0 for a flat joint (default: %(default)s)",
    )
    parser.add_argument(
        "--direction", type=float, default=0.0, metavar="DEGREES", help="direction of the slip, from Tx"
    )
    parser.add_argument(
        "--increments",
        type=int,
        default=INCREMENTS,
        help="smallest number along a test, refined until the parameters converge (default: %(default)s)",
    )
    parser.add_argument(
        "--starts",
        type=int,
        default=STARTS_TRIED,
        help="number of starts of the least squares (default: %(default)s)",
    )
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of the random starts (default: %(default)s)"
    )
    parser.add_argument("--plot", type=Path, metavar="FILE", help="plot of tests and fit, .png or .pdf")
    parser.add_argument(
        "--case", type=Path, metavar="CASE.nml", help="write a case file for run, card and select"
    )
    parser.add_argument("--card", choices=HOSTS, help="also print the material block of a host")


def _run(options: argparse.Namespace) -> int:
    """Read the tests, fit the parameters, report them."""
    check_search(options)
    with shown_warnings():
        tests = read_records(options.records, options.k_N, options.compression_positive)
    units = _units(options.units, {kind: unit for test in tests for kind, unit in test.units.items()})
    try:
        found = search(options, tests, {}, options.confidence)
    except NoScipyError as error:
        print(f"asperity: {error}", file=sys.stderr)
        return BAD_INPUT
    from .report import draw, report

    print(report(found, units))
    write(options, found, lambda path: draw(found, path, units))
    return 0


def check_search(options: argparse.Namespace) -> None:
    """Raise ValueError for options of the search that can be refused before the work starts."""
    if options.plot is not None and options.plot.suffix not in (".png", ".pdf"):
        raise ValueError(f"--plot {options.plot}: expected a name that ends in .png or .pdf")
    for option, path in (("--plot", options.plot), ("--case", options.case)):
        _check_output(option, path)
    if options.seed < 0:
        raise ValueError(f"--seed {options.seed}: expected >= 0")


def search(
    options: argparse.Namespace,
    tests: Sequence[ShearTest],
    fixed: Mapping[str, float],
    confidence: float = 0.95,
) -> Fit:
    """Fit the tests as the options say, with progress after PATIENCE; fixed: values that --set may change."""
    free = [name.strip() for name in options.free.split(",") if name.strip()]
    known = {name: value for name, value in fixed.items() if name not in free}
    with tqdm(unit="evaluation", delay=PATIENCE, disable=None, leave=False) as bar:

        def tick(label: str) -> None:
            bar.set_description(label, refresh=False)
            bar.update()

        return fit(
            tests,
            free,
            known | {name: one for name, (one,) in _numbers("--set", options.set, 1).items()},
            {name: one for name, (one,) in _numbers("--start", options.start, 1).items()},
            {name: (low, high) for name, (low, high) in _numbers("--bounds", options.bounds, 2).items()},
            options.sides,
            options.direction,
            options.increments,
            options.starts,
            options.seed,
            confidence,
            tick,
        )


def write(options: argparse.Namespace, found: Fit, draw: Callable[[Path], None]) -> None:
    """Print the card and write picture and case file, as far as the options ask for them."""
    from .report import case_text

    if options.card is not None:
        print("\n" + found.interface.card(options.card), end="")
    if options.plot is not None:
        draw(options.plot)
        print(options.plot)
    if options.case is not None:
        options.case.write_text(case_text(found), encoding="utf-8")
        print(options.case)


def _check_output(option: str, path: Path | None) -> None:
    """Raise ValueError for a file that cannot be written, before the work starts."""
    if path is None:
        return
    if not path.parent.is_dir():
        raise ValueError(f"{option} {path}: no folder {path.parent}: expected one that is there")
    if path.is_dir() or not os.access(path if path.exists() else path.parent, os.W_OK):
        raise ValueError(f"{option} {path}: expected a file that can be written")


def _units(option: str | None, of_record: dict[str, str]) -> tuple[str, str]:
    """Units of length and stress for labels."""
    texts = [unit_name(text) for text in option.split(",")] if option is not None else []
    if option is not None and (len(texts) != len(DEFAULT_UNITS) or not all(texts)):
        raise ValueError(f"--units {option}: expected LENGTH,STRESS")
    given = dict(zip(DEFAULT_UNITS, texts, strict=False))
    for kind, unit in given.items():
        if of_record.get(kind, unit) != unit:
            raise ValueError(f"--units {option}: expected {of_record[kind]}, the {kind} of the record")
    known = DEFAULT_UNITS | of_record | given
    return known["length"], known["stress"]


def _numbers(option: str, texts: Iterable[str], count: int) -> dict[str, list[float]]:
    """Parse the NAME=VALUE or NAME=LOW,HIGH entries of an option, separated by blanks."""
    found = {}
    for text in (one for several in texts for one in several.split()):
        name, _, values = text.partition("=")
        try:
            numbers = [float(value) for value in values.split(",")]
        except ValueError:
            numbers = []
        if len(numbers) != count:
            raise ValueError(f"{option} {text}: expected {'NAME=VALUE' if count == 1 else 'NAME=LOW,HIGH'}")
        if name.strip() in found:
            raise ValueError(f"{option} {text}: {name.strip()} is given twice: expected one value")
        found[name.strip()] = numbers
    return found
