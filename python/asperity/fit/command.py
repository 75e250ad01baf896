"""Command `asperity fit`: constants from shear-box tests, and what all commands share that fit curves."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .. import contract
from .. import options as cli
from ..cards.blocks import HOSTS
from ..interface import Interface
from ..remarks import doubts, shown_warnings
from .fitting import STARTS_TRIED, fit
from .model import AUTO, INCREMENTS, MORTAR, ROCK, SCALES, SIDES
from .records import DEFAULT, NONE, ShearTest, check_target, read_tests
from .report import accepted_text, case_of, covariance_text, draw, file_of, props_line, report
from .result import BETTER, Fit, refusals

NO_RESULT = 3
"""Exit code where numbers must not be used: of a fit, or of too few samples."""

HEADING = "! Identified by asperity fit."
COVARIANCE = r'\{\s+"parameters"'
"""Starts of the files that a search writes."""

PATTERNS = (SIDES, 2, 0)
"""Inclined planes of the patterns that are tried where the user has given none."""

LARGEST_ERROR = 0.1
"""Largest scatter, as a fraction of the range, that is proposed to be accepted."""

AS_GOOD = 1.05
"""Ratio of two sums of squares below which another fit is preferred if it is a result."""

CUSTOMARY = {"flat": (1.0 / 3.0,), "kc": (20.0, 100.0, 1.0), "eta": (0.9,)}
CUSTOMARY |= dict.fromkeys(("height", "W0", "crush"), (0.0,))
"""Values of constants that the tests do not determine: the first one inside the interval, or 0 for none."""

SEVERAL, MOST_CHANGES = 1.2, 6
"""Ratio of two pressures at which strength over pressure is compared; largest number of changes of the
arguments that are tried one after the other.
"""

Arguments = dict[str, Any]
"""Arguments of `fit`, by name."""

Fitted = Callable[[Arguments], Fit]
"""Function that fits the same tests with other arguments."""


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
        ("--start NAME=VALUE", "additional start of the search", list),
        ("--bounds NAME=LOW,HIGH", "bounds of a free constant", list),
        ("--sides SIDES", f"{planes} (default: {SIDES}, or 0 for tests without dilation)", int),
        ("--direction DEGREES", "direction of the slip, from Tx", 0.0),
        ("--increments N", "smallest number along a test, refined until the constants converge", INCREMENTS),
        ("--starts STARTS", "number of starts of the least squares", STARTS_TRIED),
        ("--seed SEED", "seed of the random starts", 0),
        ("--plot FILE", "plot of tests and fit, .png or .pdf (default: fit.png)", Path, drawn),
        ("--card", "also print the material block of a host", str, {"choices": tuple(HOSTS)}),
    )
    cli.add_output(parser, "CASE.nml", "write a case, and the covariance for uncertainty, CASE.fit.json")
    cli.add_workers(parser)
    parser.set_defaults(confidence=0.95, model_error=0.0, accept=False, joint=AUTO)


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
    values = {what: cli.numbers(f"--{what}", getattr(options, what), 1) for what in ("set", "start")}
    bounds = cli.numbers("--bounds", options.bounds, 2)
    same = ("sides", "direction", "increments", "starts", "seed", "confidence", "model_error", "joint")
    return {
        "free": free,
        "fixed": known | {name: one for name, (one,) in values["set"].items()},
        "start": {name: one for name, (one,) in values["start"].items()},
        "bounds": {name: (low, high) for name, (low, high) in bounds.items()},
        **{name: getattr(options, name) for name in same},
    }


@contextmanager
def searching(options: argparse.Namespace, tests: Sequence[ShearTest]) -> Iterator[Fitted]:
    """Function that fits tests with arguments and shows its stages and the remaining time."""
    with cli.workers(options) as executor, cli.progress_bar(options.starts + 2, "stage") as bar:

        def tick(label: str) -> None:
            bar.set_description(label, refresh=False)
            bar.update()

        def fitted(given: Arguments) -> Fit:
            # what a proposal has set has no start and no bounds
            known = {*given["fixed"]}
            left = {
                what: {name: given[what][name] for name in given[what] if name not in known}
                for what in ("start", "bounds")
            }
            return fit(tests, **given | left, tick=tick, executor=executor)

        yield fitted


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
    cli.add_options(parser, ("--joint FORM", forms, str, {"choices": (ROCK, MORTAR, AUTO), "metavar": None}))
    add_search(parser)
    cli.add_options(
        parser,
        ("--sigma-N VALUE,...", "normal traction of each test, or of all, in files without that column", str),
        ("--k-N STIFFNESS", "normal stiffness of the box (CNS, stress/length), for all tests", float),
        ("--k-T K", "stiffness of the machine (stress/length): tau/k_T is subtracted from the slip", float),
        ("--sigma-N-path", "prescribe sigma_N of every row as it was measured"),
        ("--columns NAME=HEADER", "column of the files with another name, as slip='Weg oben'", list),
        ("--compression-positive", "sigma_N in the files is > 0 in compression"),
        ("--confidence CONFIDENCE", "confidence of the intervals", 0.95),
        ("--model-error FRACTION", accepted, 0.0),
        ("--units LENGTH,STRESS", f"{units} (default: {','.join(DEFAULT)}, or none)", str),
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
    columns = cli.assigned(options.columns, "--columns", "NAME=HEADER", ".+")
    same = {name: getattr(options, name) for name in ("k_N", "compression_positive", "k_T", "sigma_N_path")}
    with shown_warnings():
        tests = read_tests(options.records, **same, target=target, columns=columns, sigma_N=held)
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
    accepted = accepted_text(found, reasons) if given["model_error"] or (options.accept and reasons) else ""
    refused = reasons and not options.accept
    if refused:
        options.card = options.output = None
    else:
        print(f"\n{accepted}" if accepted else "", f"{props_line(found.interface)}", sep="\n")
    texts = (case_of(found), accepted, covariance_text(found, accepted)) if options.output else ("", accepted)
    write(options, found.interface, partial(draw, found, units), *texts)
    return NO_RESULT if refused else 0


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
        fixed = changed["fixed"].items()
        pairs = [f"{name}={one if isinstance(one, str) else f'{one:.10g}'}" for name, one in fixed]
        values = {"free": changed["free"] and ",".join(changed["free"]), "auto": False, "set": pairs}
        same = {name: changed[name] for name in ("sides", "model_error", "joint")}
        return "next: " + shlex.join(cli.command_line(parser, options, values | same | others))

    if proposal is not None:
        sums = f"{proposal[1].costs[0]:.4g} after {found.costs[0]:.4g}"
        return f"{command(proposal[0])}\n      it has a result (sum of squares {sums})"
    moving = ", ".join(place for place, _, moves in found.outliers if moves)
    if found.bonded:
        more = "if the joint has no bond; otherwise it needs tests beyond the peak"
        return f"{command(given | {'joint': ROCK})}\n      {more}"
    flat = not found.problem.is_dilation.any() and not found.problem.values(found.x)["theta"]
    unshown = flat and given["sides"] is None
    unknown = ["theta"] if found.inseparable or unshown else []
    unknown += [name for name in found.undetermined if name not in found.at_bounds]
    if unknown and not moving and (unshown or not found.dependent):
        one = command(setting(given, unknown[0], "VALUE"))
        return f"{one}\n      with the value of {unknown[0]} from another test: these tests do not contain it"
    one = command(given, plot=options.plot or Path("fit.png"), accept=True)
    look = "look first where test and fit differ: units, signs, pattern (--sides), rows to leave out"
    accepts = f"{one}\n      takes these constants as they are; {look}"
    reading = f"next: put # before these lines and fit again, if they are errors of reading: {moving}\n"
    return f"{reading}otherwise {accepts}" if moving else accepts


def propose(found: Fit, given: Arguments, fitted: Fitted) -> tuple[Arguments, Fit] | None:
    """Arguments with which the same tests give a result, and this fit; None if none is found.

    given: arguments of the fit that was found.  The changes add up, where they fit better: crush for tests
    at several pressures, wear in cycles whose dilation ends, another pattern, free values; then, or at once
    where nothing else is wrong, the customary values of constants that the tests do not tell; then the
    acceptance of a model error.
    """
    ways = _ways(found, given)
    for _ in range(MOST_CHANGES):
        if not refusals(found):
            return given, found
        better: list[tuple[Arguments, Fit]] = []
        loose = {*found.undetermined, *found.at_bounds}
        for change in [] if loose <= {*CUSTOMARY} and len(refusals(found)) == len(loose) else ways:
            better = [one for one in _fits(fitted, change(found, given)) if _is_better(one[1], found)]
            if better:
                break
        better = better or _fits(fitted, _value(found, given) or _acceptance(found, given))
        if not better:
            return None
        given, found = min(better, key=lambda one: one[1].costs[0])
    return None if refusals(found) else (given, found)


def _ways(found: Fit, given: Arguments) -> Iterator[Callable[[Fit, Arguments], list[Arguments]]]:
    """Functions that change the arguments of a fit, in the order in which they are tried."""
    problem, tests = found.problem, found.problem.tests
    pressures, inclined = np.abs([test.pressed for test in tests]), problem.sides > 0
    ends = inclined and any(test.saturates for test in tests)
    for wanted, more in (
        (inclined and pressures.max() > SEVERAL * pressures.min(), [("crush",), ("crush", "height")]),
        (ends, [("height",)]),
        (ends and any(len(test.turns) > 1 for test in tests), [("W0",)]),
    ):
        if wanted:
            yield lambda fit, now, more=more: [one for names in more for one in _freeing(fit, now, *names)]
    if given.get("sides") is None:
        yield lambda _, now: [now | {"sides": sides} for sides in PATTERNS if sides != problem.sides]
    if given.get("fixed"):
        yield lambda _, now: [now | {"free": None, "fixed": {}}]


def _fits(fitted: Fitted, changes: Sequence[Arguments]) -> list[tuple[Arguments, Fit]]:
    """Fits with changed arguments, without those that a fit refuses."""
    found = []
    for one in changes:
        try:
            found.append((one, fitted(one)))
        except ValueError:
            continue
    return found


def _freeing(found: Fit, given: Arguments, *names: str) -> list[Arguments]:
    """Change that adds free constants, unless one is free or has a value; no bond comes by them."""
    free = given.get("free") or ()
    if {*names} & {*found.problem.free, *given.get("fixed", {})}:
        return []
    form = {"joint": ROCK} if found.form == ROCK and not found.bonded else {}
    return [given | form | {"free": (*free, *(names if free else (f"+{name}" for name in names)))}]


def _is_better(other: Fit, found: Fit) -> bool:
    ratio = other.costs[0] / found.costs[0]
    return ratio < BETTER or (ratio < AS_GOOD and not refusals(other))


def setting(given: Arguments, name: str, value: object) -> Arguments:
    """Arguments in which a constant has a value and is not free."""
    left = tuple(free for free in given.get("free") or () if free.lstrip("+") != name)
    return given | {"free": left or None, "fixed": given.get("fixed", {}) | {name: value}}


def _value(found: Fit, given: Arguments) -> list[Arguments]:
    """Change that sets the customary value of a constant that the tests do not tell, if there is one."""
    for name in dict.fromkeys([*found.undetermined, *found.at_bounds]):
        one = found.estimates[name]
        inside = [value for value in CUSTOMARY.get(name, ()) if value == 0.0 or one.low <= value <= one.high]
        if inside:
            return [setting(given, name, inside[0])]
    return []


def _acceptance(found: Fit, given: Arguments) -> list[Arguments]:
    """Change that accepts the scatter of a model that differs from the tests by more than noise."""
    scatter = float(np.nanmax(found.scatter))
    if not found.dependent or scatter <= found.model_error or scatter > LARGEST_ERROR:
        return []
    return [given | {"model_error": float(np.ceil(100.0 * scatter) / 100.0)}]
