"""Command `asperity predict`: tests beside the curves of a joint that was identified without them."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ... import options as cli
from ...case_files import Run, read_case
from ...interface import Interface
from ...model_checks import shown_warnings
from ..tables import size
from .columns import NONE
from .command import NO_RESULT, add_reading, read
from .kinds import kind_of
from .prediction import Asked, Prediction
from .report import COLUMNS, compared_rows, coverage, file_of, heading
from .verdict import AnyTest, short
from .written import Written, other_constant, written_beside


def predict(
    joint: Interface,
    tests: Sequence[AnyTest],
    spring: float = 0.0,
    direction: float = 0.0,
    slip: float = 0.0,
    fit: Written | None = None,
) -> Prediction:
    """Curves of a joint for tests, with their pressures, stiffnesses and slips; the others as in `Asked`."""
    if not tests:
        raise ValueError("no test: expected one or more")
    return kind_of(tests).predict(Asked(joint, spring, direction, slip, fit), tests)


def spring_of(run: Run) -> tuple[float, float, float]:
    """Spring in series, direction and largest slip of a case as `asperity fit -o` writes it."""
    spring = direction = slip = 0.0
    for step in run.steps:
        if step.k_Tx and step.k_Tx == step.k_Ty and step.t_Tx is not None:
            ends = np.atleast_1d(step.t_Tx), np.atleast_1d(step.t_Ty if step.t_Ty is not None else 0.0)
            far = np.hypot(*ends).argmax()
            spring = float(step.k_Tx)
            slip = float(np.hypot(ends[0][far], ends[1][far])) / spring
            first = np.flatnonzero(np.hypot(*ends))[:1]  # the next ones may turn back
            direction = float(np.degrees(np.arctan2(ends[1][first], ends[0][first])).sum())
        elif step.slip is not None:
            slip = max(slip, float(np.abs(step.slip).max()))
            direction = direction if step.direction is None else float(step.direction)
    return spring, direction, slip


def report_of(prediction: Prediction, units: tuple[str, str] = NONE) -> str:
    """Measured beside predicted numbers and their errors."""
    errors = ", ".join(f"{name} {value:.1%}" for name, value in prediction.rms.items())
    tests, rows = prediction.tests, prediction.compared
    lines = compared_rows(tests, rows, [], True, "measured / predicted", units=units)
    if prediction.intervals:
        names = [name for name in COLUMNS if any(name in ends for ends in prediction.intervals)]
        count = sum(map(len, prediction.intervals))
        head = "".join(f"{heading(name, units):>26}" for name in names)
        lines += ["", f"{'predicted, 0.95 interval':<28}{head}"]
        for row, ends in zip(prediction.compared, prediction.intervals, strict=True):
            cells = (f"{ends[name][0]:.4g} to {ends[name][1]:.4g}" if name in ends else "" for name in names)
            lines.append(f"{short(row.test):<28}" + "".join(f"{cell:>26}" for cell in cells))
        outside = ", ".join(f"{name} of {short(test)}" for test, name in prediction.outside)
        inside = count - len(prediction.outside)
        text = f"inside      {inside} of {count} measured numbers lie in their intervals"
        lines += ["", text + (f"; outside: {outside}" if outside else "")]
    return "\n".join([*lines, "", f"rms         {errors}", f"grade       {prediction.grade}"])


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    drawn = {"nargs": "?", "const": Path("predict.png")}
    cli.add_options(parser, ("case CASE.nml", "case of the joint, as asperity fit -o writes it", Path))
    add_reading(parser)
    force = ("--force", "replace files that this command did not write itself")
    plot = ("--plot FILE", "plot of tests and prediction, .png or .pdf (default: predict.png)", Path, drawn)
    cli.add_options(parser, plot, force)
    parser.description = (
        "Predict tests with the joint of a case, which was identified from other tests, and compare: peak, "
        "slip at the peak, residual, dilation. A spring in series of the case is that of the tests. The exit "
        f"code is {NO_RESULT} where the grade is poor: an error above 15 %."
    )
    parser.set_defaults(action=_run)


def _check_units(options: argparse.Namespace, of_case: tuple[str, str]) -> None:
    """Raise ValueError for --units that are not those of the constants of the case."""
    asked = options.units.split(",") if options.units else of_case
    same = len(asked) == len(NONE) and all(
        np.isclose(size(kind, one), size(kind, other))
        for kind, one, other in zip(NONE, asked, of_case, strict=True)
    )
    if not same:
        text = f"--units {options.units}: the constants of {options.case} are in {','.join(of_case)}"
        raise ValueError(f"{text}: expected these, and units in the header of tests that have others")


def _run(options: argparse.Namespace) -> int:
    """Print the comparison and draw it."""
    cli.check_outputs(options.force, [options.case, *options.records], ("--plot", options.plot))
    with shown_warnings():
        run = read_case(options.case).runs[0]
    fit = written_beside(file_of(options.case))
    if fit is not None and fit.units != NONE:
        _check_units(options, fit.units)
        options.units = ",".join(fit.units)
    tests, units, _ = read(options)
    spring, direction, slip = spring_of(run)
    with shown_warnings():
        of_case = None if fit is None or other_constant(run, fit.names, fit.values) else fit
        prediction = predict(run.interface, tests, spring, direction, slip, of_case)
    print(report_of(prediction, units))
    if fit is not None:
        print(*fit.remarks(run, coverage(tests)), sep="\n")
    if options.plot is not None:
        from ..style import printed, save

        with printed():
            save(kind_of(tests).predicted(prediction, tests, units), options.plot)
        print(options.plot)
    return NO_RESULT if prediction.grade == "poor" else 0
