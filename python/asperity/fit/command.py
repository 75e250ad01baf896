"""Command `asperity fit`: parameters from shear-box tests."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from collections.abc import Iterable
from pathlib import Path

from tqdm import tqdm

from ..remarks import shown_warnings
from .fitting import DEFAULT_FREE, FLAT_FREE, STARTS_TRIED, Fit, NoScipyError, fit
from .model import INCREMENTS, SCALES, SIDES
from .records import ShearTest, read_records
from .units import DEFAULT, NONE, check_target
from .verdict import MOVED, Change, outliers, propose, refusals

PATIENCE = 2.0
"""Seconds before progress is shown."""

BAD_INPUT, NO_RESULT = 1, 3
"""Exit codes: wrong input, and a fit whose parameters must not be used."""

HOSTS = ("abaqus", "calculix", "kratos")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    parser.add_argument(
        "records",
        nargs="+",
        type=Path,
        metavar="DATA.csv",
        help="CSV with columns slip, tau, sigma_N and, if measured, dilation, k_N, test",
    )
    parser.add_argument(
        "--free",
        metavar="NAMES",
        help=f"parameters to identify, of {','.join(SCALES)}; the others must be set (default: all of "
        f"{','.join(DEFAULT_FREE)} that are not set)",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="parameters that are known",
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
        help=f"inclined planes: 2 for a ridge across the slip (RT), 0 for a flat joint (default: {SIDES})",
    )
    parser.add_argument(
        "--direction", type=float, default=0.0, metavar="DEGREES", help="direction of the slip, from Tx"
    )
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
    parser.add_argument(
        "--confidence", type=float, default=0.95, help="confidence of the intervals (default: %(default)s)"
    )
    parser.add_argument(
        "--model-error",
        type=float,
        default=0.0,
        metavar="FRACTION",
        help="accept a model that differs from the tests by more than noise, with a scatter of up to this "
        "fraction of the range; the intervals are widened (default: none)",
    )
    parser.add_argument(
        "--plot",
        nargs="?",
        type=Path,
        const=Path(),
        metavar="FILE",
        help="plot of tests and fit, .png or .pdf (default: the name of the first file with _fit.png, here)",
    )
    parser.add_argument(
        "-o", "--case", type=Path, metavar="CASE.nml", help="write a case file for run, card and select"
    )
    parser.add_argument("--card", choices=HOSTS, help="also print the material block of a host")
    parser.add_argument(
        "--units",
        metavar="LENGTH,STRESS",
        help="units of the results; numbers whose header has units are converted to them (default: "
        f"{','.join(DEFAULT)}, without units in the header none)",
    )
    parser.description = (
        "Identify parameters from shear-box tests. Where the tests do not give the parameters, the exit code "
        "is 3 and no PROPS, case or card is written; the report says why, and which command to run next."
    )
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    """Read the tests, fit the parameters, report them."""
    if options.plot == Path():
        options.plot = Path(f"{options.records[0].stem}_fit.png")
    if options.plot is not None and options.plot.suffix not in (".png", ".pdf"):
        raise ValueError(f"--plot {options.plot}: expected a name that ends in .png or .pdf")
    for option, path in (("--plot", options.plot), ("--case", options.case)):
        _check_output(option, path)
    if options.seed < 0:
        raise ValueError(f"--seed {options.seed}: expected >= 0")
    fitting = _Fitting(options)
    target = DEFAULT if options.units is None else check_target(options.units.split(","))
    with shown_warnings():
        tests = read_records(options.records, options.k_N, options.compression_positive, target)
    if options.units is not None and not tests[0].units:
        raise ValueError(
            f"--units {options.units}: expected units in the header of {options.records[0]}, such as slip "
            "[mm], tau [MPa], from which the numbers are converted"
        )
    units = (tests[0].units["length"], tests[0].units["stress"]) if tests[0].units else NONE
    stages = options.starts + len(("starts", "increments", "intervals"))
    with tqdm(total=stages, unit="stage", delay=PATIENCE, disable=None, leave=False) as bar:
        fitting.tests, fitting.bar = tests, bar
        try:
            found = fitting(Change(_sides(options), {}, options.model_error))
        except NoScipyError as error:
            print(f"asperity: {error}", file=sys.stderr)
            return BAD_INPUT
        reasons = refusals(found)
        given = options.sides is not None, bool(fitting.fixed)
        proposal = propose(found, fitting, *given) if reasons else None
    from .report import case_text, draw, props_line, report

    print(report(found, units))
    for one in outliers(found):
        print(one.text)
    if reasons:
        print(f"\nno result: {'; '.join(reasons)}")
        print(_next(options, found, proposal))
    else:
        print(f"\n{props_line(found)}")
    if options.card is not None and not reasons:
        print("\n" + found.interface.card(options.card), end="")
    if options.plot is not None:
        draw(found, options.plot, units)
        print(options.plot)
    if options.case is not None and not reasons:
        options.case.write_text(case_text(found), encoding="utf-8")
        print(options.case)
    return NO_RESULT if reasons else 0


def _sides(options: argparse.Namespace) -> int:
    return SIDES if options.sides is None else int(options.sides)


class _Fitting:
    """Fit of the tests with the options of the command and changed arguments."""

    tests: list[ShearTest]
    bar: tqdm
    stage: str = ""

    def __init__(self, options: argparse.Namespace) -> None:
        """Parse the options that contain numbers."""
        self.options = options
        self.fixed = {name: one for name, (one,) in _numbers("--set", options.set, 1).items()}
        self.start = {name: one for name, (one,) in _numbers("--start", options.start, 1).items()}
        bounds = _numbers("--bounds", options.bounds, 2).items()
        self.bounds = {name: (low, high) for name, (low, high) in bounds}
        self.free = None
        if options.free is not None:
            self.free = [name.strip() for name in options.free.split(",") if name.strip()]
            needed = FLAT_FREE if options.sides == 0 else DEFAULT_FREE
            missing = [name for name in needed if name not in {*self.free, *self.fixed}]
            if missing:
                raise ValueError(
                    f"--free {options.free}: {', '.join(missing)}: expected each parameter free or set, as "
                    f"by --set {missing[0]}=VALUE"
                )

    def __call__(self, change: Change) -> Fit:
        """Fit with these changes."""
        options, fixed = self.options, ({} if change.freed else self.fixed) | dict(change.fixed)
        free = self.free and [name for name in self.free if name not in change.fixed]
        free = None if change.freed else free
        return fit(
            self.tests,
            free,
            fixed,
            {name: value for name, value in self.start.items() if name not in change.fixed},
            {name: ends for name, ends in self.bounds.items() if name not in change.fixed},
            change.sides,
            options.direction,
            options.increments,
            options.starts,
            options.seed,
            options.confidence,
            self._tick,
            change.model_error,
        )

    def _tick(self, label: str) -> None:
        """Count the stages of the fit, each of which takes many evaluations."""
        if label != self.stage:
            self.stage = label
            self.bar.set_description(label, refresh=False)
            self.bar.update()


def _next(options: argparse.Namespace, found: Fit, proposal: tuple[Change, Fit] | None) -> str:
    """Text with the command to run next."""
    command = ["asperity", *options.arguments]
    if proposal is not None:
        change, better = proposal
        if change.freed:
            command = _without(command, "--set", "--free")
        if change.sides != found.problem.sides:
            command += ["--sides", str(change.sides)]
        if change.model_error > found.model_error:
            command += ["--model-error", f"{change.model_error:g}"]
        for name, value in change.fixed.items():
            command += ["--set", f"{name}={value:.4g}"]
        if options.free is not None and change.fixed and not change.freed:
            command += ["--free", ",".join(better.problem.free)]
        sums = f"{better.costs[0]:.4g} after {found.costs[0]:.4g}"
        return f"next: {shlex.join(command)}\n      it has a result (sum of squares {sums})"
    moving = [one.place for one in outliers(found) if one.moves > MOVED]
    if moving:
        return (
            f"next: put # before these lines if they are errors of reading: {', '.join(moving)}\n"
            f"      {shlex.join(command)}"
        )
    unknown = ["theta"] if found.inseparable else []
    unknown += [name for name in found.undetermined if name not in found.at_bounds]
    if unknown and not found.dependent:
        return (
            f"next: {shlex.join([*command, '--set', f'{unknown[0]}=VALUE'])}\n      with the value of "
            f"{unknown[0]} from another test: these tests do not contain it"
        )
    plot = [] if options.plot is not None else ["--plot", "fit.png"]
    return (
        f"next: {shlex.join([*command, *plot])}\n      and look where record and fit differ: units, signs, "
        "pattern (--sides), rows to leave out"
    )


def _without(command: list[str], *names: str) -> list[str]:
    """Command without these options, each of which has a value."""
    kept, skip = [], False
    for text in command:
        if not skip and text not in names and text.partition("=")[0] not in names:
            kept.append(text)
        skip = not skip and text in names
    return kept


def _check_output(option: str, path: Path | None) -> None:
    """Raise ValueError for a file that cannot be written, before the work starts."""
    if path is None:
        return
    if not path.parent.is_dir():
        raise ValueError(f"{option} {path}: no folder {path.parent}: expected one that is there")
    if path.is_dir() or not os.access(path if path.exists() else path.parent, os.W_OK):
        raise ValueError(f"{option} {path}: expected a file that can be written")


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
