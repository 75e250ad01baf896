"""Command `asperity predict`: tests beside the curves of a joint that was identified without them."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ... import options as cli
from ...case_files import Run, read_case
from ...contract import Floats
from ...interface import Interface
from ...model_checks import shown_warnings
from ..tables import size
from .checks import of_kind
from .closure_test import ClosureTest
from .closures import closure_of
from .columns import NONE
from .command import NO_RESULT, add_reading, read
from .evidence import cycles
from .model import KT, Problem
from .picture import MARKS
from .report import compared_rows, covered, file_of
from .series import CyclicSeries, Series
from .shear_test import ShearTest
from .strength import Strength
from .verdict import Comparison, compared, grade_of
from .written import written_beside

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINTS = 400
"""Slips of a curve from which a peak is read."""


@dataclass(frozen=True, eq=False)
class OfCase(Problem):
    """Tests of a joint that is known as a whole."""

    joint: Interface = field(kw_only=True)

    def interface(self, values: Mapping[str, float]) -> Interface:
        """The joint."""
        return self.joint


class SeriesOfCase(OfCase, Series):
    """The same with a spring in series."""


class CyclesOfCase(OfCase, CyclicSeries):
    """The same with reversals of the slip."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """Tests with the curves of a joint: measured and predicted numbers, and root mean square errors.

    curves: slips (P,), rows of the test among them, tau and s_N (P,) of each test; none for strengths alone.
    rms: over the range of each test for tau and dilation, relative for numbers such as the peak.
    """

    tests: Sequence[ShearTest] | Sequence[Strength] | Sequence[ClosureTest]
    compared: list[Comparison]
    rms: dict[str, float]
    curves: list[tuple[Floats, np.ndarray, Floats, Floats]]

    @property
    def grade(self) -> str:
        """Grade of the largest root mean square, without the unloading of closure tests."""
        return grade_of(max(value for name, value in self.rms.items() if name != "unloading"))


def predict(
    joint: Interface,
    tests: Sequence[ShearTest] | Sequence[Strength] | Sequence[ClosureTest],
    spring: float = 0.0,
    direction: float = 0.0,
    slip: float = 0.0,
) -> Prediction:
    """Curves of a joint for tests, with their pressures, stiffnesses and slips.

    spring: stiffness in series with the joint, stress/length; 0: none.  direction: of the slip, degrees.
    slip: to which the peak of strengths without a slip is searched, length.
    """
    if not tests:
        raise ValueError("no test: expected one or more")
    if isinstance(tests[0], ClosureTest):
        return _closures(joint, of_kind(tests, ClosureTest))
    if isinstance(tests[0], Strength):
        rows = [_strength(joint, test, direction, slip) for test in of_kind(tests, Strength)]
        return Prediction(tests, rows, _rms(rows, {}), [])
    curved = of_kind(tests, ShearTest)
    kind = OfCase if not spring else CyclesOfCase if cycles(curved) else SeriesOfCase
    problem, values = kind(curved, (), {}, direction=direction, joint=joint), {KT: spring}
    curves = problem.curves(values)
    made, squares = [], dict[str, list[float]](tau=[], dilation=[])
    for test, (slips, rows_), (tau, s_N, done) in zip(problem.tests, problem.paths, curves, strict=True):
        reached = rows_[-1] < done
        if not reached:
            raise ValueError(f"{test.name}: the joint has no equilibrium up to the slip of the test")
        made.append((slips, rows_, tau, s_N))
        squares["tau"].append(float(np.mean(((tau[rows_] - test.tau) / np.ptp(test.tau)) ** 2)))
        if test.s_N is not None and np.ptp(test.s_N) > 0.0:
            squares["dilation"].append(float(np.mean(((s_N[rows_] - test.s_N) / np.ptp(test.s_N)) ** 2)))
    comparisons = compared(problem, values)
    return Prediction(tests, comparisons, _rms(comparisons, squares), made)


def _closures(joint: Interface, tests: Sequence[ClosureTest]) -> Prediction:
    """Closures of a joint; the unloading counts apart, as no elastic contact follows it."""
    squares, rows, curves = dict[str, list[float]](loading=[], unloading=[]), [], []
    for test in tests:
        law = closure_of(joint, test)
        away = (law - test.closure + test.closure[0]) / test.size
        for name, part in (("loading", test.loading), ("unloading", test.unloading)):
            if part.size:
                squares[name].append(float(np.mean(away[part] ** 2)))
        end = float(law[test.loading[-1]])
        error = {"closure": abs(end / test.size - 1.0)}
        rows.append(Comparison(test.name, {"closure": test.size}, {"closure": end}, error))
        curves.append((test.pressure, test.loading, law, law))
    return Prediction(tests, rows, _rms(rows, squares), curves)


def _rms(rows: Sequence[Comparison], squares: Mapping[str, list[float]]) -> dict[str, float]:
    """Root mean squares of the curves, and of the numbers of all tests."""
    rms = {name: float(np.sqrt(np.mean(parts))) for name, parts in squares.items() if parts}
    for name in ("peak", "residual", "closure"):
        errors = [row.errors[name] for row in rows if name in row.errors]
        if errors:
            rms[name] = float(np.sqrt(np.mean(np.square(errors))))
    return rms


def _strength(joint: Interface, test: Strength, direction: float, slip: float) -> Comparison:
    """Peak of a joint up to the slip of a test, and traction at its residual strength."""
    ends = [test.slip, test.peak_slip, slip]
    end = next((end for end in ends if np.isfinite(end) and end > 0.0), 0.0)
    if not end:
        raise ValueError(f"{test.name}: no slip: expected a column slip, or a case with a slip")
    path = joint.confined_slip(direction, np.linspace(0.0, end, POINTS + 1), test.sigma_N)
    if len(path.tau) <= POINTS:
        raise ValueError(f"{test.name}: the joint has no equilibrium up to the slip {end:g}")
    measured, predicted = {"peak": test.peak}, {"peak": float(path.tau.max())}
    if np.isfinite(test.residual):
        measured["residual"], predicted["residual"] = test.residual, float(path.tau[-1])
    errors = {name: abs(predicted[name] / value - 1.0) for name, value in measured.items()}
    return Comparison(test.name, measured, predicted, errors)


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


def figure_of(prediction: Prediction, units: tuple[str, str]) -> Figure:
    """Points of the tests and curves of the joint, or predicted over measured strengths."""
    from ..style import COLOURS, ONE, TWO, label_axes, new_figure

    length, stress = units
    closures = [test for test in prediction.tests if isinstance(test, ClosureTest)]
    if closures:
        figure, (ax,) = new_figure(ONE, 3.4, ncols=1)
        for i, (pressed, (pressure, rows, law, _)) in enumerate(
            zip(closures, prediction.curves, strict=True)
        ):
            colour, label = COLOURS[i % len(COLOURS)], ("measured", "predicted") if i == 0 else ("", "")
            ax.plot(pressed.closure, pressure, "o", color=colour, markersize=3.0, label=label[0])
            ax.plot(law[rows], pressure[rows], color=colour, label=label[1])
        ax.locator_params(axis="x", nbins=6)
        label_axes(ax, f"closure since the first row [{length}]", f"pressure [{stress}]")
        ax.legend()
        return figure
    if not prediction.curves:
        figure, (ax,) = new_figure(ONE, 3.2, ncols=1)
        for name, mark in (("peak", "o"), ("residual", "s")):
            pairs = [
                (row.measured[name], row.predicted[name])
                for row in prediction.compared
                if name in row.measured
            ]
            if pairs:
                ax.plot(*np.transpose(pairs), mark, label=name)
        top = max(max(row.measured["peak"], row.predicted["peak"]) for row in prediction.compared)
        ax.plot([0.0, top], [0.0, top], color="0.6", linewidth=0.8, zorder=0)
        label_axes(ax, f"measured strength [{stress}]", f"predicted strength [{stress}]")
        ax.legend()
        return figure
    tests = [test for test in prediction.tests if isinstance(test, ShearTest)]
    columns = 1 + any(test.s_N is not None for test in tests)
    figure, axes = new_figure(TWO if columns > 1 else ONE, 3.0, ncols=columns)
    for i, (test, (slips, _, tau, s_N)) in enumerate(zip(tests, prediction.curves, strict=True)):
        colour = COLOURS[i % len(COLOURS)]
        for ax, measured, curve in zip(axes, (test.tau, test.s_N), (tau, s_N), strict=False):
            if measured is not None:
                ax.plot(test.slip, measured, MARKS[i % len(MARKS)], color=colour, markersize=2.0, alpha=0.5)
                ax.plot(
                    slips,
                    curve,
                    color=colour,
                    label=rf"$\sigma_N$ = {test.sigma_N:.4g}".replace("-", "\u2212"),
                )
    for ax, name in zip(axes, (rf"traction $\tau$ [{stress}]", f"dilation $s_N$ [{length}]"), strict=False):
        label_axes(ax, f"slip [{length}]", name)
    handles, texts = axes[0].get_legend_handles_labels()
    title = f"points: test data, lines: predicted; stresses in {stress}"
    figure.legend(handles, texts, loc="outside upper center", ncols=min(4, len(texts)), title=title)
    return figure


def report_of(prediction: Prediction) -> str:
    """Measured beside predicted numbers and their errors."""
    errors = ", ".join(f"{name} {value:.1%}" for name, value in prediction.rms.items())
    lines = compared_rows(prediction.compared, [], True, "measured / predicted")
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
        prediction = predict(run.interface, tests, spring, direction, slip)
    print(report_of(prediction))
    if fit is not None:
        print(*fit.remarks(run, covered(tests)), sep="\n")
    if options.plot is not None:
        from ..style import printed, save

        with printed():
            save(figure_of(prediction, units), options.plot)
        print(options.plot)
    return NO_RESULT if prediction.grade == "poor" else 0
