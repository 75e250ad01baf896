"""Command `asperity fit`: parameters from shear-box tests."""

from __future__ import annotations

import argparse
import shlex
from dataclasses import replace
from functools import partial
from pathlib import Path

from ..options import add_options, assigned, command_line
from ..remarks import doubts, shown_warnings
from .model import SIDES
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
        "CSV with columns slip, tau, sigma_N and, if measured, dilation, k_N, test; or one row per test with "
        "slip, peak, residual, sigma_N"
    )
    add_options(parser, ("records DATA.csv", columns, Path, {"nargs": "+"}))
    add_search(parser)
    add_options(
        parser,
        ("--k-N STIFFNESS", "normal stiffness of the box (CNS, stress/length), for all tests", float),
        (
            "--k-T STIFFNESS",
            "stiffness of the machine (stress/length): tau/k_T is subtracted from the slip",
            float,
        ),
        ("--sigma-N-path", "prescribe sigma_N of every row as it was measured"),
        (
            "--columns NAME=HEADER",
            "column of the files with another name, as slip='Shear displacement'",
            list,
        ),
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
            "units of the results; numbers whose header has units are converted to them (default: "
            f"{','.join(DEFAULT)}, without units in the header none)",
            str,
        ),
    )
    add_options(parser, ("--accept", "take constants that are no result: the best ones, marked as poor"))
    parser.description = (
        "Identify parameters from shear-box tests. Where the tests do not give the parameters, the exit code "
        "is 3 and no PROPS, case or card is written; the report says why, and which command to run next."
    )
    parser.set_defaults(action=partial(_run, parser))


def _run(parser: argparse.ArgumentParser, options: argparse.Namespace) -> int:
    check_search(options)
    searching = Search(options, strict=True)
    target = DEFAULT if options.units is None else check_target(options.units.split(","))
    with shown_warnings():
        tests = read_tests(
            options.records,
            options.k_N,
            options.compression_positive,
            target,
            options.k_T,
            options.sigma_N_path,
            assigned(options.columns, "--columns", "NAME=HEADER", ".+"),
        )
    if options.units is not None and not tests[0].units:
        raise ValueError(
            f"--units {options.units}: expected units in the header of {options.records[0]}, such as slip "
            "[mm], tau [MPa], from which the numbers are converted"
        )
    units = (tests[0].units["length"], tests[0].units["stress"]) if tests[0].units else NONE
    from .report import props_line, report

    with searching.shown() as fitted:
        found = fitted(tests, searching.given)
        reasons = refusals(found)
        print(report(found, units))
        for one in outliers(found):
            print(one.text)
        interface = found.interface
        slip = max(test.slip.max() for test in tests)
        pressed = (test.pressed for test in tests)
        for text in doubts(interface.material, interface.pattern, *pressed, slip=slip):
            print(f"warning: {text}")
        if reasons and not options.accept:
            print(f"\nno result: {'; '.join(reasons)}", flush=True)
            better = propose(
                found, searching.given, lambda change: fitted(tests, change), options.sides is not None
            )
            print(_next(parser, options, searching.given, found, better))
        else:
            print(f"\npoor: {'; '.join(reasons)}" if reasons else "", f"{props_line(found)}", sep="\n")
    write(options, found, units, reasons=reasons)
    return NO_RESULT if reasons and not options.accept else 0


def _next(
    parser: argparse.ArgumentParser,
    options: argparse.Namespace,
    given: Change,
    found: Fit,
    proposal: tuple[Change, Fit] | None,
) -> str:
    def command(change: Change, *more: str, **others: object) -> str:
        changed = {
            "free": change.free and ",".join(change.free),
            "set": [*(f"{name}={value:.10g}" for name, value in change.fixed.items()), *more],
            "sides": None if change.sides == SIDES and options.sides is None else change.sides,
            "model_error": change.model_error,
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
    unknown = ["theta"] if found.inseparable else []
    unknown += [name for name in found.undetermined if name not in found.at_bounds]
    if unknown and not found.dependent:
        free = given.free and tuple(name for name in given.free if name != unknown[0])
        return (
            f"next: {command(replace(given, free=free), f'{unknown[0]}=VALUE')}\n      with the value of "
            f"{unknown[0]} from another test: these tests do not contain it"
        )
    return (
        f"next: {command(given, plot=options.plot or Path('fit.png'))}\n      and look where test and fit "
        "differ: units, signs, pattern (--sides), rows to leave out; --accept takes these constants"
    )
