"""Command `asperity fit`: constants from shear-box tests."""

from __future__ import annotations

import argparse
import re
import shlex
from functools import partial
from pathlib import Path

from .. import contract
from ..options import add_options, assigned, command_line
from ..remarks import doubts, shown_warnings
from .constants import AUTO, MORTAR, ROCK
from .outcome import Fit
from .picture import draw
from .records import read_tests
from .report import accepted_text, case_of, covariance_text, props_line, report
from .search import add_search, arguments_of, check_search, searching, write
from .units import DEFAULT, NONE, check_target
from .verdict import MOVED, Arguments, outliers, propose, refusals

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
        ("--k-T K", "stiffness of the machine (stress/length): tau/k_T is subtracted from the slip", float),
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
    given = arguments_of(options)
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
    with searching(options, tests) as fitted:
        found = fitted(given)
        reasons = _print(found, units)
        if reasons and not options.accept:
            print(f"\nno result: {'; '.join(reasons)}", flush=True)
            better = propose(found, given, fitted)
            print(_next(parser, options, given, found, better))
            if options.auto and better is not None:
                (given, found), reasons = better, []
                print()
                _print(found, units)
    accepted = ""
    if given["model_error"] or (options.accept and reasons):
        accepted = accepted_text(found, reasons)
    left = [] if options.accept else reasons
    if not left:
        print(f"\n{accepted}" if accepted else "", f"{props_line(found.interface)}", sep="\n")
    if left:
        options.card = options.output = None
    case, covariance = (case_of(found), covariance_text(found, accepted)) if options.output else ("", "")
    write(options, found.interface, partial(draw, found, units), case, accepted, covariance)
    return NO_RESULT if left else 0


def _print(found: Fit, units: tuple[str, str]) -> list[str]:
    """Print the report of a fit and what is doubtful; the reasons why it is no result."""
    print(report(found, units))
    interface, tests = found.interface, found.problem.tests
    slip = max(test.slip.max() for test in tests)
    for text in doubts(interface.material, interface.pattern, *(test.pressed for test in tests), slip=slip):
        print(f"warning: {text}")
    return refusals(found)


def _next(
    parser: argparse.ArgumentParser,
    options: argparse.Namespace,
    given: Arguments,
    found: Fit,
    proposal: tuple[Arguments, Fit] | None,
) -> str:
    """Text with the command to run next, which is never that which was refused."""

    def command(changed: Arguments, **others: object) -> str:
        values = {"free": changed["free"] and ",".join(changed["free"]), "auto": False}
        values["set"] = [
            f"{name}={one}" if isinstance(one, str) else f"{name}={one:.10g}"
            for name, one in changed["fixed"].items()
        ]
        same = {name: changed[name] for name in ("sides", "model_error")}
        return shlex.join(command_line(parser, options, values | same | others))

    if proposal is not None:
        sums = f"{proposal[1].costs[0]:.4g} after {found.costs[0]:.4g}"
        return f"next: {command(proposal[0])}\n      it has a result (sum of squares {sums})"
    moving = [one.place for one in outliers(found) if one.moves > MOVED]
    if moving:
        lines = f"next: put # before these lines if they are errors of reading: {', '.join(moving)}"
        return f"{lines}\n      {command(given)}"
    flat = not found.problem.is_dilation.any() and not found.problem.values(found.x)["theta"]
    unshown = flat and given["sides"] is None
    unknown = ["theta"] if found.inseparable or unshown else []
    unknown += [name for name in found.undetermined if name not in found.at_bounds]
    if unknown and (unshown or not found.dependent):
        free = tuple(name for name in given["free"] or () if name.removeprefix("+") != unknown[0])
        one = given | {"free": free or None, "fixed": given["fixed"] | {unknown[0]: "VALUE"}}
        return (
            f"next: {command(one)}\n      with the value of {unknown[0]} from another test: these tests do "
            "not contain it"
        )
    return (
        f"next: {command(given, plot=options.plot or Path('fit.png'), accept=True)}\n      takes these "
        "constants as they are; look first where test and fit differ: units, signs, pattern (--sides), rows "
        "to leave out"
    )
