"""Command `asperity select`: the pattern that a load case needs."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ...case_files import SlipTest, read_case, slip_tests
from ...case_writer import pattern_text, props_line
from ...installed import case_file
from ...model_checks import shown_warnings, warn_of_physics
from ...options import (
    add_options,
    add_output,
    add_workers,
    check_outputs,
    progress_bar,
    replace_file,
    workers,
)
from ...steps import turns_of
from .search import REFERENCE_SIDES, Errors, LoadCase, NoPatternError, Selection, select

FEW_PLANES = 5
"""Largest number of planes of the listed patterns that miss the tolerance; the last one is always listed."""

HEADING = "! Pattern of asperity select.\n"  # first line of the case that is written


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    add_options(
        parser,
        (
            "case CASE.nml",
            "case of the driver: t_N, then slip under it; a sweep gives the stress range",
            case_file,
        ),
        ("--tolerance ERROR", "largest error of traction, dilation and residual strength", 0.01),
        ("--planar", "the surface is a ridge and slips across it, along the direction of the case only"),
    )
    add_output(parser, "CHOSEN.nml", "write the case with the selected pattern, for run and card")
    add_workers(parser, "(default: threads on all processors)")
    parser.set_defaults(action=_run)


def read_load_case(path: Path, planar: bool = False) -> LoadCase:
    """Read the load case from a case file of the driver; a sweep may give several sigma_N or directions.

    Raises ValueError with the messages of the driver, and for a case that is not a slip under a constant t_N.
    Warnings about the joint are issued as ModelWarning.
    """
    tests = list(slip_tests(read_case(path)))
    first = tests[0]
    if any((test.material, test.pattern) != (first.material, first.pattern) for test in tests):
        raise ValueError(
            f"{path}: &sweep: expected one over sigma_N or direction, of one surface and material"
        )
    if first.pattern.m < 0:
        raise ValueError(
            f"{path}: &pattern: expected sides, theta and flat; with listed planes there is nothing to select"
        )
    turns = _turns(first)
    if len(turns) == 0 or any(_turns(test) != turns for test in tests):
        raise ValueError(f"{path}: expected &step with t_N, then with slip, the same path in every run")
    if planar and any(test.direction != first.direction for test in tests):
        raise ValueError(f"{path}: expected one direction for a planar load case")
    slip = max(abs(test.slips).max(initial=0.0) for test in tests)
    warn_of_physics(first.material, first.pattern, *(test.sigma_N for test in tests), slip=slip)
    return LoadCase(
        first.material,
        first.pattern.theta if first.pattern.m else 0.0,
        tuple(dict.fromkeys(test.sigma_N for test in tests)),
        turns,
        first.pattern.flat,
        planar,
        first.direction,
    )


def _turns(test: SlipTest) -> tuple[float, ...]:
    path = np.append(0.0, test.slips)
    return tuple(path[turns_of(path)[1:]].tolist()) if path.any() else ()


def _run(options: argparse.Namespace) -> int:
    check_outputs(options.force, [options.case], ("-o", options.output, HEADING))
    with shown_warnings():
        case = read_load_case(options.case, options.planar)
    with workers(options) as executor, progress_bar(REFERENCE_SIDES, "pattern") as bar:
        try:
            tick = lambda name: (bar.update(), bar.set_postfix_str(name))  # noqa: E731
            answer = select(case, options.tolerance, tick, executor)
        except NoPatternError as error:
            raise ValueError(f"{options.case}: {error}") from None
    print(report(answer))
    if options.output is not None:
        source = read_case(options.case)
        lines = pattern_text(answer.pattern).encode()
        replace_file(options.output, HEADING.encode() + source.before + lines + source.after)
        print(options.output)
    return 0


def report(answer: Selection) -> str:
    """Text of the load case, the candidates, the selected pattern, and its line of PROPS."""
    case = answer.case
    path = " to ".join(f"{slip:g}" for slip in (0.0, *case.turns))
    quality = "the surface itself" if case.planar else f"good to {answer.uncertainty:.1e}"
    where = f"along {case.direction:g} degrees, across a ridge" if case.planar else "in any direction"
    lines = [
        f"load case  sigma_N {', '.join(f'{value:g}' for value in case.sigma_N)}; slip {path} {where}",
        f"surface    theta {case.theta:g} degrees, flat fraction {case.flat:g}, mu {case.material.mu:g}",
        f"reference  {answer.reference}, {quality}; tolerance {answer.tolerance:g}",
        *(
            f"lost       sigma_N {sigma_N:g}: no equilibrium beyond a path of {length:.3g}; compared up to it"
            for sigma_N, length in answer.lost
        ),
        "",
        f"{'pattern':<10}{'planes':>6}" + "".join(f"{name:>12}" for name in Errors._fields),
    ]
    *missed, _ = answer.tried
    shown = [trial for trial in missed if trial.planes <= FEW_PLANES or trial is missed[-1]]
    lines += [_row(trial.name, trial.planes, trial.errors) for trial in shown]
    lines += [_row(answer.name, answer.planes, answer.errors) + "  meets it, checked", ""]
    ratio = len(case.regular(REFERENCE_SIDES).weights) / answer.planes
    lines.append(
        f"cost       {ratio:.1f} times fewer planes than RP-{REFERENCE_SIDES}; "
        "the time of an update is nearly proportional to them"
    )
    return "\n".join([*lines, props_line(answer.interface.props(), 17)])


def _row(name: str, planes: int, errors: Errors) -> str:
    texts = ("-" if np.isnan(value) else f"{value:.1e}" for value in errors)
    return f"{name:<10}{planes:>6}" + "".join(f"{text:>12}" for text in texts)
