"""Command `asperity fit`: constants from shear-box tests, and what all commands share that fit curves."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from ... import contract
from ... import options as cli
from ...cards.blocks import HOSTS
from ...case_writer import props_line
from ...interface import Interface
from ...model_checks import model_warnings, shown_warnings
from ..tables import size
from .checks import refuse
from .fitting import STARTS_TRIED, fit
from .model import AUTO, MORTAR, ROCK, SCALES, SIDES
from .proposal import VALUE, Arguments, proposal
from .records import DEFAULT, NONE, read_tests
from .report import accepted_text, case_of, covariance_text, draw, file_of, report
from .result import Fit, failed_checks

NO_RESULT = 3
"""Exit code where numbers must not be used: of a fit, or of too few samples."""

HEADING = "! Identified by asperity fit."
COVARIANCE = r'\{\s+"parameters"'
"""Starts of the files that a search writes."""

MOST_STEPS = 6
"""Largest number of commands that --auto runs."""

MARKS = {"point": ".", "comma": ","}
"""Decimal marks by their names."""


def add_search(
    parser: argparse.ArgumentParser, free: str | None = None, fixed: Mapping[str, float] | None = None
) -> None:
    """Add the options of the search and of its results; free and fixed: the defaults, for the help."""
    known = ", ".join(f"{name}={value:.4g}" for name, value in (fixed or {}).items())
    unset = "those that the tests can show; +height adds height to them"
    of_all = f"constants to identify, of {','.join(SCALES)} (default: {unset if free is None else free})"
    planes = "inclined planes: 2 for a ridge across the slip (RT), 0 for a flat joint"
    drawn = {"nargs": "?", "const": Path("fit.png")}
    cli.add_options(
        parser,
        ("--free NAMES", of_all, str, {"default": free}),
        ("--set NAME=VALUE", f"constants that are known{f' (default: {known})' if known else ''}", list),
        ("--sides SIDES", f"{planes} (default: {SIDES}, or 0 for tests without dilation)", int),
        ("--direction DEGREES", "direction of the slip, from Tx", 0.0),
        ("--starts STARTS", "number of starts of the least squares", STARTS_TRIED),
        ("--plot FILE", "plot of tests and fit, .png or .pdf (default: fit.png)", Path, drawn),
        ("--card", "also print the material block of a host", str, {"choices": tuple(HOSTS)}),
    )
    cli.add_output(parser, "CASE.nml", "write a case, and the covariance for uncertainty, CASE.fit.json")
    parser.set_defaults(model_error=0.0, joint=AUTO)


def check_search(options: argparse.Namespace) -> None:
    """Raise ValueError for options of the search that can be refused before the work starts."""
    beside = None if options.output is None else file_of(options.output)
    written = ("--plot", options.plot), ("-o", options.output, HEADING), ("-o", beside, COVARIANCE)
    cli.check_outputs(options.force, getattr(options, "records", ()), *written)


def arguments_of(options: argparse.Namespace, assumed: Mapping[str, float] | None = None) -> Arguments:
    """Arguments of `fit` of the options; assumed: values of constants neither free nor set."""
    free = options.free and tuple(name.strip() for name in options.free.split(",") if name.strip())
    names = [name.removeprefix("+") for name in free or ()]
    known = {name: one for name, one in (assumed or {}).items() if name not in names}
    given = {name: one for name, (one,) in cli.numbers("--set", options.set, 1).items()}
    same = {name: getattr(options, name) for name in ("sides", "direction", "starts", "model_error", "joint")}
    return {"free": free, "fixed": known | given} | same


@contextmanager
def progress(options: argparse.Namespace) -> Iterator[Callable[[str], None]]:
    """Function that shows a stage of a fit and the remaining time."""
    with cli.progress_bar(options.starts + 2, "stage") as bar:

        def tick(label: str) -> None:
            bar.set_description(label, refresh=False)
            bar.update()

        yield tick


def write(
    options: argparse.Namespace,
    interface: Interface,
    draw: Callable[[Path], object],
    case: str,
    accepted: str = "",
    covariance: str = "",
) -> None:
    """Print the card and write picture, case file and covariance, as far as the options ask for them.

    draw: draws the picture into a file.  case, covariance: texts.  accepted: what the user has accepted.
    """
    if options.card is not None:
        print("\n" + interface.card(options.card, notes=[accepted] if accepted else []), end="")
    if options.plot is not None:
        draw(options.plot)
        print(options.plot)
    if options.output is not None:
        note = f"! {accepted[0].upper()}{accepted[1:]}.\n" if accepted else ""
        files = {options.output: f"{HEADING}\n{note}{case}", file_of(options.output): covariance}
        for path, text in files.items():
            if text:
                path.write_text(text, encoding="utf-8")
                print(path)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    columns = (
        "CSV with columns slip, tau, sigma_N and, if measured, dilation, k_N, test, or the names of a "
        "laboratory, as Shear stress [kPa]; or one row per test with slip, peak, residual, sigma_N"
    )
    cli.add_options(parser, ("records DATA.csv", columns, Path, {"nargs": "+"}))
    forms = "without bond, with bond, or that of the two which the tests support (default: auto)"
    units = "units of the results, to which numbers with units are converted, and of numbers without"
    accepted = "accept a model that misses the tests by more than noise, up to this scatter over the range"
    marks = {"choices": tuple(MARKS), "metavar": None}
    cli.add_options(parser, ("--joint FORM", forms, str, {"choices": (ROCK, MORTAR, AUTO), "metavar": None}))
    add_search(parser)
    cli.add_options(
        parser,
        ("--sigma-N VALUE,...", "normal traction of each test, or of all, in files without that column", str),
        ("--k-N STIFFNESS", "normal stiffness of the box (CNS, stress/length), for all tests", float),
        ("--k-T K", "stiffness of the machine (stress/length): tau/k_T is subtracted from the slip", float),
        ("--sigma-N-path", "prescribe sigma_N of every row as it was measured"),
        ("--columns NAME=HEADER", "column of the files with another name, as slip='Weg oben'", list),
        ("--decimal MARK", "decimal mark of files that do not show it, as 1,234", str, marks),
        ("--model-error FRACTION", accepted, 0.0),
        ("--units LENGTH,STRESS", f"{units} (default: {','.join(DEFAULT)}, or none)", str),
        ("--accept", "take constants that are no result: the best ones, marked as accepted"),
        ("--auto", "where the constants are no result, go on with the command that is proposed next"),
    )
    parser.description = (
        "Identify constants from shear-box tests. Where the tests do not give the constants, the exit code "
        "is 3 and no PROPS, case or card is written; the report says why, and which command to run next."
    )
    parser.set_defaults(action=partial(_run, parser))


def _run(parser: argparse.ArgumentParser, options: argparse.Namespace) -> int:
    check_search(options)
    given, target = arguments_of(options), options.units and tuple(options.units.split(","))
    refuse(target and len(target) != len(NONE), f"--units {options.units}: expected LENGTH,STRESS, as mm,MPa")
    for kind, unit in zip(NONE, target or (), strict=False):
        size(kind, unit, f"--units {options.units}: ")
    held = options.sigma_N and [contract.number("--sigma-N", text) for text in options.sigma_N.split(",")]
    columns = cli.assigned(options.columns, "--columns", "NAME=HEADER", ".+")
    same = {name: getattr(options, name) for name in ("k_N", "k_T", "sigma_N_path")}
    with shown_warnings():
        decimal = MARKS.get(options.decimal)
        tests = read_tests(
            options.records, **same, target=target, columns=columns, sigma_N=held, decimal=decimal
        )
    units = (tests[0].units["length"], tests[0].units["stress"]) if tests[0].units else NONE
    slip, pressed = max(test.slip.max() for test in tests), [test.pressed for test in tests]
    before: list[Arguments] = []
    for step in range(MOST_STEPS):
        with shown_warnings(), progress(options) as tick:
            found = fit(tests, **given, tick=tick)
        print(report(found, units, "accepted" if options.accept else "no result"))
        for text in model_warnings(found.interface.material, found.interface.pattern, *pressed, slip=slip):
            print(f"warning: {text}")
        reasons = failed_checks(found)
        if not reasons or options.accept:
            break
        before.append(given)
        changes, why = proposal(found, given, before)
        print(_next(parser, options, found, given | changes, why), flush=True)
        asks = "accept" in changes or VALUE in changes.get("fixed", {}).values()
        runs = not asks and changes.get("joint") in (None, found.problem.form)
        if not (options.auto and runs) or step + 1 == MOST_STEPS:
            break
        given = given | changes
        print()
    if reasons and not options.accept:
        options.card = options.output = None
        write(options, found.interface, partial(draw, found, units), "")
        return NO_RESULT
    accepted = accepted_text(found, reasons) if given["model_error"] or reasons else ""
    print(f"\n{accepted}" if accepted else "", props_line(found.interface.props()), sep="\n")
    texts = (case_of(found), accepted, covariance_text(found, accepted)) if options.output else ("", accepted)
    write(options, found.interface, partial(draw, found, units), *texts)
    return 0


def _next(
    parser: argparse.ArgumentParser, options: argparse.Namespace, found: Fit, given: Arguments, why: str
) -> str:
    """Text with the command to run next, which is never that which was refused."""
    pairs = [f"{name}={one if one == VALUE else f'{one:.10g}'}" for name, one in given["fixed"].items()]
    values = {"free": given["free"] and ",".join(given["free"]), "auto": False, "set": pairs}
    values |= {name: given[name] for name in ("sides", "model_error", "joint")}
    if given.get("accept"):
        values |= {"accept": True, "plot": options.plot or Path("fit.png")}
    moving = [place for place, _, moves in found.outliers if moves]
    reading = f"\nErrors of reading? Put # before {', '.join(moving)} and fit again. If the values are right:"
    words = shlex.join(cli.command_line(parser, options, values))
    return f"{reading * bool(moving)}\nnext: {words}\n      {why}"
