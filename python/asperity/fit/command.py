"""Command `asperity fit`: constants from shear-box tests."""

from __future__ import annotations

import argparse
import re
import shlex
from dataclasses import replace
from functools import partial
from pathlib import Path

from .. import contract
from ..options import add_options, assigned, command_line
from ..remarks import doubts, shown_warnings
from .constants import AUTO, MORTAR, ROCK
from .outcome import Fit
from .records import read_tests
from .search import Search, add_search, check_search, write
from .units import DEFAULT, NONE, check_target
from .verdict import MOVED, Change, outliers, propose, refusals

NO_RESULT = 3
"""Exit code where numbers must not be used: of a fit, or of too few samples."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    columns = (
        "CSV with columns slip, tau, sigma_N and, if measured, dilation, k_N, test, or the names of a "
        "laboratory, as Shear stress [kPa]; or one row per test with slip, peak, residual, sigma_N"
    )
    add_options(parser, ("records DATA.csv", columns, Path, {"nargs": "+"}))
    forms = "without bond, with bond, or that of the two which the tests support (default: auto)"
    add_options(parser, ("--joint FORM", forms, str, {"choices": (ROCK, MORTAR, AUTO), "metavar": None}))
    add_search(parser)
    add_options(
        parser,
        ("--sigma-N VALUE,...", "normal traction of each test, or of all, in files without that column", str),
        ("--k-N STIFFNESS", "normal stiffness of the box (CNS, stress/length), for all tests", float),
        (
            "--k-T STIFFNESS",
            "stiffness of the machine (stress/length): tau/k_T is subtracted from the slip",
            float,
        ),
        ("--sigma-N-path", "prescribe sigma_N of every row as it was measured"),
        ("--columns NAME=HEADER", "column of the files with another name, as slip='Weg oben'", list),
        ("--compression-positive", "sigma_N in the files is > 0 in compression"),
        ("--confidence CONFIDENCE", "confidence of the intervals", 0.95),
        (
            "--model-error FRACTION",
            "accept a model that differs from the tests by more than noise, with a scatter of up to this "
            "fraction of the range; the intervals are widened (default: none)",
            0.0,
        ),
        (
            "--units LENGTH,STRESS",
            "units of the results, to which numbers with units are converted, and of numbers without "
            f"(default: {','.join(DEFAULT)}, or none)",
            str,
        ),
        ("--accept", "take constants that are no result: the best ones, marked as accepted"),
        ("--auto", "where the constants are no result, go on with the command that is proposed next"),
    )
    # a list that begins with a minus sign is a value, as a number is
    parser._negative_number_matcher = re.compile(r"-[\d.]")
    parser.description = (
        "Identify constants from shear-box tests. Where the tests do not give the constants, the exit code "
        "is 3 and no PROPS, case or card is written; the report says why, and which command to run next."
    )
    parser.set_defaults(action=partial(_run, parser))


def _run(parser: argparse.ArgumentParser, options: argparse.Namespace) -> int:
    check_search(options)
    searching = Search(options)
    target = None if options.units is None else check_target(options.units.split(","))
    held = options.sigma_N and [contract.number("--sigma-N", text) for text in options.sigma_N.split(",")]
    with shown_warnings():
        tests = read_tests(
            options.records,
            options.k_N,
            options.compression_positive,
            target,
            options.k_T,
            options.sigma_N_path,
            assigned(options.columns, "--columns", "NAME=HEADER", ".+"),
            held,
        )
    units = (tests[0].units["length"], tests[0].units["stress"]) if tests[0].units else NONE
    from .report import accepted_text, props_line

    with searching.shown() as fitted:
        given, found = searching.given, fitted(tests, searching.given)
        reasons = _print(found, units)
        if reasons and not options.accept:
            print(f"\nno result: {'; '.join(reasons)}", flush=True)
            better = propose(found, given, lambda change: fitted(tests, change))
            print(_next(parser, options, given, found, better))
            if options.auto and better is not None:
                (given, found), reasons = better, []
                print()
                _print(found, units)
    taken = reasons if options.accept else []
    accepted = accepted_text(found, taken) if taken or given.model_error > 0.0 else ""
    if not reasons or options.accept:
        print(f"\n{accepted}" if accepted else "", f"{props_line(found)}", sep="\n")
    write(options, found, units, reasons=[] if options.accept else reasons, accepted=accepted)
    return NO_RESULT if reasons and not options.accept else 0


def _print(found: Fit, units: tuple[str, str]) -> list[str]:
    """Print the report of a fit and what is doubtful; the reasons why it is no result."""
    from .report import report

    print(report(found, units))
    for one in outliers(found):
        print(one.text)
    interface, tests = found.interface, found.problem.tests
    slip = max(test.slip.max() for test in tests)
    for text in doubts(interface.material, interface.pattern, *(test.pressed for test in tests), slip=slip):
        print(f"warning: {text}")
    return refusals(found)


def _next(
    parser: argparse.ArgumentParser,
    options: argparse.Namespace,
    given: Change,
    found: Fit,
    proposal: tuple[Change, Fit] | None,
) -> str:
    """Text with the command to run next, which is never that which was refused."""

    def command(change: Change, *more: str, **others: object) -> str:
        changed = {
            "free": change.free and ",".join(change.free),
            "set": [*(f"{name}={value:.10g}" for name, value in change.fixed.items()), *more],
            "sides": change.sides,
            "model_error": change.model_error,
            "auto": False,
        }
        return shlex.join(command_line(parser, options, changed | others))

    if proposal is not None:
        sums = f"{proposal[1].costs[0]:.4g} after {found.costs[0]:.4g}"
        return f"next: {command(proposal[0])}\n      it has a result (sum of squares {sums})"
    moving = [one.place for one in outliers(found) if one.moves > MOVED]
    if moving:
        return (
            f"next: put # before these lines if they are errors of reading: {', '.join(moving)}\n"
            f"      {command(given)}"
        )
    unshown = (
        not found.problem.dilation and not found.problem.values(found.x)["theta"] and given.sides is None
    )
    unknown = ["theta"] if found.inseparable or unshown else []
    unknown += [name for name in found.undetermined if name not in found.at_bounds]
    if unknown and (unshown or not found.dependent):
        free = given.free and tuple(name for name in given.free if name.removeprefix("+") != unknown[0])
        return (
            f"next: {command(replace(given, free=free or None), f'{unknown[0]}=VALUE')}\n      with the "
            f"value of {unknown[0]} from another test: these tests do not contain it"
        )
    return (
        f"next: {command(given, plot=options.plot or Path('fit.png'), accept=True)}\n      takes these "
        "constants as they are; look first where test and fit differ: units, signs, pattern (--sides), rows "
        "to leave out"
    )
