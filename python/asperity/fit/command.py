"""Command `asperity fit`: parameters from shear-box tests."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from ..options import add_options, assigned
from ..remarks import doubts, shown_warnings
from .outcome import Fit
from .records import read_records
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
    parser.description = (
        "Identify parameters from shear-box tests. Where the tests do not give the parameters, the exit code "
        "is 3 and no PROPS, case or card is written; the report says why, and which command to run next."
    )
    parser.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> int:
    """Read the tests, fit the parameters, report them."""
    check_search(options)
    searching = Search(options, strict=True)
    target = DEFAULT if options.units is None else check_target(options.units.split(","))
    with shown_warnings():
        tests = read_records(
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
    with searching.shown() as fitted:
        found = fitted(tests, searching.given)
        reasons = refusals(found)
        given = options.sides is not None, bool(searching.fixed)
        proposal = propose(found, lambda change: fitted(tests, change), *given) if reasons else None
    from .report import props_line, report

    print(report(found, units))
    for one in outliers(found):
        print(one.text)
    interface = found.interface
    slip = max(test.slip.max() for test in tests)
    for text in doubts(interface.material, interface.pattern, *(test.pressed for test in tests), slip=slip):
        print(f"warning: {text}")
    if reasons:
        print(f"\nno result: {'; '.join(reasons)}")
        print(_next(options, found, proposal))
    else:
        print(f"\n{props_line(found)}")
    write(options, found, units, drawing_only=bool(reasons))
    return NO_RESULT if reasons else 0


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
