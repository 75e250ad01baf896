"""Options of a search for constants, and the search itself, for all commands that fit curves."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from ..cards.blocks import HOSTS
from ..interface import Interface
from ..options import add_options, add_output, add_workers, check_outputs, numbers, progress_bar, workers
from .constants import AUTO, SCALES
from .fitting import STARTS_TRIED, fit
from .model import INCREMENTS, SIDES
from .outcome import Fit
from .report import file_of
from .shear_test import ShearTest
from .verdict import Arguments, Fitted

HEADING = "! Identified by asperity fit."
COVARIANCE = r'\{\s+"parameters"'
"""Starts of the files that a search writes."""


def add_search(
    parser: argparse.ArgumentParser, free: str | None = None, fixed: Mapping[str, float] | None = None
) -> None:
    """Add the options of the search and of its results; free and fixed: the defaults, for the help."""
    known = ", ".join(f"{name}={value:.4g}" for name, value in (fixed or {}).items())
    unset = "those that the tests can show; +height adds height to them"
    of_all = f"constants to identify, of {','.join(SCALES)} (default: {unset if free is None else free})"
    planes = "inclined planes: 2 for a ridge across the slip (RT), 0 for a flat joint"
    drawn = {"nargs": "?", "const": Path("fit.png")}
    add_options(
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
    add_output(parser, "CASE.nml", "write a case, and the covariance for uncertainty, CASE.fit.json")
    add_workers(parser)
    parser.set_defaults(confidence=0.95, model_error=0.0, accept=False, joint=AUTO)


def check_search(options: argparse.Namespace) -> None:
    """Raise ValueError for options of the search that can be refused before the work starts."""
    beside = None if options.output is None else file_of(options.output)
    written = ("--plot", options.plot), ("-o", options.output, HEADING), ("-o", beside, COVARIANCE)
    check_outputs(options.force, getattr(options, "records", ()), *written)


def arguments_of(options: argparse.Namespace, assumed: Mapping[str, float] | None = None) -> Arguments:
    """Arguments of `fit` of the options; assumed: values of constants neither free nor set."""
    fixed = {name: one for name, (one,) in numbers("--set", options.set, 1).items()}
    free = options.free and tuple(name.strip() for name in options.free.split(",") if name.strip())
    names = [name.removeprefix("+") for name in free or ()]
    same = ("sides", "direction", "increments", "starts", "seed", "confidence", "model_error", "joint")
    return {
        "free": free,
        "fixed": {name: one for name, one in (assumed or {}).items() if name not in names} | fixed,
        "start": {name: one for name, (one,) in numbers("--start", options.start, 1).items()},
        "bounds": {name: (low, high) for name, (low, high) in numbers("--bounds", options.bounds, 2).items()},
        **{name: getattr(options, name) for name in same},
    }


@contextmanager
def searching(options: argparse.Namespace, tests: Sequence[ShearTest]) -> Iterator[Fitted]:
    """Function that fits tests with arguments and shows its stages and the remaining time."""
    with workers(options) as executor, progress_bar(options.starts + 2, "stage") as bar:

        def tick(label: str) -> None:
            bar.set_description(label, refresh=False)
            bar.update()

        def fitted(given: Arguments) -> Fit:
            # what a proposal has set has no start and no bounds
            free = {
                what: {name: one for name, one in given[what].items() if name not in given["fixed"]}
                for what in ("start", "bounds")
            }
            return fit(tests, **given | free, tick=tick, executor=executor)

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
