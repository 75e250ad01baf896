"""Command `asperity fit`: constants from shear tests, and what all commands share that fit curves."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TypeAlias

from ... import contract
from ... import options as cli
from ...case_writer import props_line
from ...hosts import hosts
from ...interface import Interface
from ...model_checks import shown_warnings
from ..tables import size
from .closure_test import ClosureTest
from .columns import DEFAULT, NONE
from .kinds import kind_of
from .model import AUTO, MORTAR, ROCK, SCALES, SIDES
from .records import read_tests
from .report import comment, file_of, intervals_text
from .shear_test import ShearTest
from .strength import Strength

AnyTests: TypeAlias = list[ShearTest] | list[Strength] | list[ClosureTest]
"""Tests of one kind."""

NO_RESULT = 3
"""Exit code where numbers must not be used: of a fit, or of too few samples."""

HEADING = "! Identified by asperity fit."
INTERVALS = r'\{\s+"parameters"'
RESIDUALS = "test,(row,quantity,(slip|pressure)|sigma_N,quantity,measured),"
"""Starts of the files that a fit writes."""

MARKS = {"point": ".", "comma": ","}
"""Decimal marks by their names."""


def add_results(parser: argparse.ArgumentParser) -> None:
    """Add the options of what a fit writes."""
    drawn = {"nargs": "?", "const": Path("fit.png")}
    cli.add_options(
        parser,
        ("--plot FILE", "plot of tests and fit, .png or .pdf (default: fit.png)", Path, drawn),
        ("--card", "also print the material block of a host", str, {"choices": tuple(hosts("card"))}),
    )
    cli.add_output(parser, "CASE.nml", "write a case, and the intervals for uncertainty, CASE.fit.json")


def check_results(options: argparse.Namespace) -> None:
    """Raise ValueError for outputs that can be refused before the work starts."""
    from .html import START

    beside = None if options.output is None else file_of(options.output)
    written: list[tuple[str, Path | None] | tuple[str, Path | None, str]] = [("--plot", options.plot)]
    written += [("-o", options.output, HEADING), ("-o", beside, INTERVALS)]
    written += [("--report", getattr(options, "report", None), START)]
    written += [("--residuals", getattr(options, "residuals", None), RESIDUALS)]
    cli.check_outputs(options.force, getattr(options, "records", ()), *written)


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """Function that shows the part of a fit that runs."""
    with cli.progress_bar(None, "part") as bar:

        def tick(label: str) -> None:
            bar.set_description(label, refresh=False)
            bar.update()

        yield tick


def write(
    options: argparse.Namespace,
    interface: Interface,
    draw: Callable[[Path], object],
    case: str,
    notes: str = "",
    intervals: str = "",
) -> None:
    """Print the card and write picture, case file and intervals, as far as the options ask for them.

    draw: draws the picture into a file.  case, intervals: texts.  notes: grade and intervals, for the card.
    """
    if options.card is not None:
        with shown_warnings():
            card = interface.card(options.card, notes=[notes] if notes else [])
        print("\n" + card, end="")
    if options.plot is not None:
        draw(options.plot)
        print(options.plot)
    if options.output is not None:
        files = {options.output: f"{HEADING}\n{case}", file_of(options.output): intervals}
        for path, text in files.items():
            if text:
                cli.replace_file(path, text)
                print(path)


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Add the options of how files of tests are read."""
    columns = (
        "tests as CSV with columns slip, tau, sigma_N and, if measured, dilation, k_N, test, or "
        "the names of a "
        "laboratory, as Shear stress [kPa]; or one row per test with sigma_N, peak and, if "
        "measured, residual, peak_slip, slip; or closure tests with sigma_N, closure"
    )
    units = "units of the results, to which numbers with units are converted, and of numbers without"
    held = "normal traction of each test, or of all, in files without that column; 0 without a pressure"
    marks = {"choices": tuple(MARKS), "metavar": None}
    cli.add_options(
        parser,
        ("records DATA.csv", columns, Path, {"nargs": "+"}),
        ("--sigma-N VALUE,...", held, str),
        ("--k-N STIFFNESS", "normal stiffness of the box (CNS, stress/length), for all tests", float),
        ("--k-T K", "stiffness of the machine (stress/length): tau/k_T is subtracted from the slip", float),
        ("--area A", "contact area for columns of forces, or L,B: a box that slips along L", str),
        ("--sigma-N-path", "prescribe sigma_N of every row as it was measured"),
        ("--columns NAME=HEADER", "column of the files with another name, as slip='Weg oben'", list),
        ("--decimal MARK", "decimal mark of files that do not show it, as 1,234", str, marks),
        ("--units LENGTH,STRESS", f"{units} (default: {','.join(DEFAULT)}, or none)", str),
    )


def read(options: argparse.Namespace) -> tuple[AnyTests, tuple[str, str], list[str]]:
    """Tests of the files of the options, their units, and warnings, which are printed, too."""
    target = options.units and tuple(options.units.split(","))
    if target and len(target) != len(NONE):
        raise ValueError(f"--units {options.units}: expected LENGTH,STRESS, as mm,MPa")
    for kind, unit in zip(NONE, target or (), strict=False):
        size(kind, unit, f"--units {options.units}: ")
    held = options.sigma_N and [contract.number("--sigma-N", text) for text in options.sigma_N.split(",")]
    columns = cli.assigned(options.columns, "--columns", "NAME=HEADER", ".+")
    same = {name: getattr(options, name) for name in ("k_N", "k_T", "sigma_N_path")}
    with shown_warnings() as warned:
        tests = read_tests(
            options.records, **same, target=target, columns=columns, sigma_N=held,
            decimal=MARKS.get(options.decimal), area=options.area,
        )  # fmt: skip
    units = (tests[0].units["length"], tests[0].units["stress"]) if tests[0].units else NONE
    return tests, units, warned


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    add_reading(parser)
    forms = "without bond, with bond, or that of the two which the tests support (default: auto)"
    known = f"constants that are known from elsewhere, of {', '.join(SCALES)}"
    cli.add_options(
        parser,
        ("--joint FORM", forms, str, {"choices": (ROCK, MORTAR, AUTO), "metavar": None, "default": AUTO}),
        ("--set NAME=VALUE", known, list),
        (
            "--free NAMES",
            "identify these constants, instead of the smallest model that the tests support",
            str,
        ),
        ("--sides SIDES", "inclined planes of the pattern, along the slip", SIDES),
        ("--direction DEGREES", "direction of the slip, from Tx", 0.0),
        ("--report FILE.html", "write a report with pictures and tables in one file", Path),
        ("--residuals FILE.csv", "write measured and fitted rows and their residuals", Path),
        ("--verbose", "report all tests, the models that were compared, and correlations"),
    )
    add_results(parser)
    parser.description = (
        "Identify constants from shear tests: the smallest model that the tests support, "
        "intervals that contain noise, misfit and other assumptions, and each test predicted by the others. "
        "The exit code is 0 where the constants may be used, and 3 where they must not be used; the report "
        "says why. Files are written in both cases and say the same."
    )
    parser.set_defaults(action=partial(_run, parser))


def _run(parser: argparse.ArgumentParser, options: argparse.Namespace) -> int:
    check_results(options)
    known = {name: value for name, (value,) in cli.numbers("--set", options.set, 1).items()}
    free = options.free and tuple(name.strip() for name in options.free.split(",") if name.strip())
    tests, units, warned = read(options)
    kind = kind_of(tests)
    changed_options = {
        "--free": free is not None,
        "--sides": options.sides != SIDES,
        "--direction": options.direction != 0.0,
        "--set": bool(known),
        "--joint": options.joint != AUTO,
    }
    wrong = next((name for name in kind.refuses if changed_options[name]), "")
    if wrong:
        raise ValueError(f"{wrong}: expected {ShearTest.WHAT}, not {tests[0].WHAT}")
    with shown_warnings() as of_fit, progress() as tick:
        result = kind.fit(tests, options.joint, known, free, options.sides, options.direction, tick)
    doubts = list(kind.doubts(result))
    interface = kind.interface(result)
    lines = [kind.report(result, units, options.verbose), *(f"warning     {text}" for text in doubts)]
    print(*lines, "", props_line(interface.props()), sep="\n")
    of_result = comment(result), intervals_text(result, units)
    write(options, interface, partial(kind.draw, result, units), kind.case(result), *of_result)
    if options.residuals is not None:
        cli.replace_file(options.residuals, kind.residuals(result))
        print(options.residuals)
    if options.report is not None:
        from .html import page

        words = shlex.join(["asperity", *sys.argv[1:]])
        cli.replace_file(options.report, page(result, units, words, [*warned, *of_fit, *doubts]))
        print(options.report)
    return 0 if result.is_result else NO_RESULT
