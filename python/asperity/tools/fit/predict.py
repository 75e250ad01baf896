"""Command `asperity predict`: tests beside the curves of a joint that was identified without them."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ... import options as cli
from ...case_files import Run, read_case
from ...contract import Floats
from ...interface import Interface
from ...load_path import columns_of
from ...model_checks import shown_warnings
from ...pattern import direction_vector
from ...steps import slip_path
from ..tables import size
from .closure_test import ClosureTest
from .closures import closure_of
from .columns import NONE
from .command import NO_RESULT, add_reading, read
from .model import KT, PRELOAD, CyclicSeries, Problem, Series
from .picture import curves_figure
from .report import COLUMNS, compared_rows, covered, file_of, heading
from .shear_test import ShearTest, cycles, of_kind
from .strength import Strength
from .thresholds import FLOOR, NORMAL
from .verdict import Comparison, compared, grade_of, short
from .written import Written, other_constant, written_beside

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINTS, STEP = 400, 0.1
"""Slips of a curve from which a peak is read; step of differences, in standard deviations of a constant."""


@dataclass(frozen=True, eq=False)
class OfCase(Problem):
    """Tests of a joint that is known as a whole."""

    of_case: Floats = field(kw_only=True)

    def props(self, values: Mapping[str, float]) -> Floats:
        """PROPS of the joint."""
        return self.of_case


class SeriesOfCase(OfCase, Series):
    """The same with a spring in series."""


class CyclesOfCase(OfCase, CyclicSeries):
    """The same with reversals of the slip."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """Tests with the curves of a joint: measured and predicted numbers, and root mean square errors.

    curves: slips (P,), rows of the test among them, tau and s_N (P,) of each test; none for strengths alone.
    rms: over the range of each test for tau and dilation, relative for numbers such as the peak.  intervals:
    of the numbers of each test by name, none without the file of a fit.
    """

    tests: Sequence[ShearTest] | Sequence[Strength] | Sequence[ClosureTest]
    compared: list[Comparison]
    rms: dict[str, float]
    curves: list[tuple[Floats, np.ndarray, Floats, Floats]]
    intervals: list[dict[str, tuple[float, float]]] = field(default_factory=list)

    @property
    def outside(self) -> list[tuple[str, str]]:
        """Test and name of the measured numbers that lie outside their intervals."""
        return [
            (row.test, name)
            for row, ends in zip(self.compared, self.intervals, strict=False)
            for name, (low, high) in ends.items()
            if not low <= row.measured[name] <= high
        ]

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
    fit: Written | None = None,
) -> Prediction:
    """Curves of a joint for tests, with their pressures, stiffnesses and slips.

    spring: stiffness in series with the joint, stress/length; 0: none.  direction: of the slip, degrees.
    slip: to which the peak of strengths without a slip is searched, length.  fit: that of the joint, whose
    covariance and model error give the intervals of the numbers.
    """
    if not tests:
        raise ValueError("no test: expected one or more")
    if isinstance(tests[0], ClosureTest):
        return _closures(joint, of_kind(tests, ClosureTest))
    if isinstance(tests[0], Strength):
        of_tests = of_kind(tests, Strength)

        def numbers(props: Floats) -> list[Comparison]:
            return [_strength(props, test, direction, slip) for test in of_tests]

        rows = numbers(joint.props())
        return Prediction(tests, rows, _rms(rows, {}), [], _intervals(rows, numbers, joint, fit))
    curved = of_kind(tests, ShearTest)
    kind = OfCase if not spring else CyclesOfCase if cycles(curved) else SeriesOfCase

    def problem_of(props: Floats) -> OfCase:
        return kind(curved, (), {}, direction=direction, of_case=props)

    problem, values = problem_of(joint.props()), {KT: spring}
    curves = problem.curves(values)
    curves_of_tests, squares = [], dict[str, list[float]](tau=[], dilation=[])
    for test, (slips, rows_), (tau, s_N, done) in zip(problem.tests, problem.paths, curves, strict=True):
        reached = rows_[-1] < done
        if not reached:
            raise ValueError(f"{test.name}: the joint has no equilibrium up to the slip of the test")
        curves_of_tests.append((slips, rows_, tau, s_N))
        squares["tau"].append(float(np.mean(((tau[rows_] - test.tau) / np.ptp(test.tau)) ** 2)))
        if test.s_N is not None and np.ptp(test.s_N) > 0.0:
            squares["dilation"].append(float(np.mean(((s_N[rows_] - test.s_N) / np.ptp(test.s_N)) ** 2)))
    comparisons = compared(problem, values)
    intervals = _intervals(comparisons, lambda props: compared(problem_of(props), values), joint, fit)
    return Prediction(tests, comparisons, _rms(comparisons, squares), curves_of_tests, intervals)


def _intervals(
    rows: Sequence[Comparison],
    numbers: Callable[[Floats], list[Comparison]],
    joint: Interface,
    fit: Written | None,
) -> list[dict[str, tuple[float, float]]]:
    """Intervals of the predicted numbers, by the covariance of a fit and twice its model errors."""
    # a fit of the closure alone has kn, which is no constant of PROPS
    if fit is None or "kn" in fit.names:
        return []
    squares = [dict.fromkeys(set(row.errors), 0.0) for row in rows]
    for factor, *ends in fit.moved(joint.props(), STEP):
        for square, below, above in zip(squares, *map(numbers, ends), strict=True):
            for name in square:
                square[name] += (factor * (above.predicted[name] - below.predicted[name])) ** 2
    top = max([0.0, *(abs(row.predicted.get("dilation", 0.0)) for row in rows)])
    intervals = []
    for row, square in zip(rows, squares, strict=True):
        halves = {}
        for name in row.measured:
            if name in square:
                value, of_dilation = row.predicted[name], name == "dilation"
                size = top if of_dilation else max(abs(value), FLOOR * abs(row.predicted.get("peak", 0.0)))
                half = float(np.hypot(NORMAL * np.sqrt(square[name]), 2.0 * fit.error[of_dilation] * size))
                halves[name] = (value - half, value + half)
        intervals.append(halves)
    return intervals


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


def _strength(props: Floats, test: Strength, direction: float, slip: float) -> Comparison:
    """Peak of a joint up to the slip of a test, and traction at its residual strength."""
    if test.peak == 0.0:
        raise ValueError(f"{test.name}: a tensile test: expected tests with a slip")
    ends = [test.slip, test.peak_slip, slip]
    end = next((end for end in ends if np.isfinite(end) and end > 0.0), 0.0)
    if not end:
        raise ValueError(f"{test.name}: no slip: expected a column slip, or a case with a slip")
    path = slip_path(direction, np.linspace(0.0, end, POINTS + 1), test.sigma_N, PRELOAD)
    step, t_x, t_y = columns_of(props, path, ("step", "t_Tx", "t_Ty"))
    along = direction_vector(direction)
    tau = (along[0] * t_x + along[1] * t_y)[step > 1.0]
    # in tension the equilibrium ends beyond the peak
    lost = tau.size < (POINTS if test.sigma_N <= 0.0 else 1)
    if lost:
        raise ValueError(f"{test.name}: the joint has no equilibrium up to the slip {end:g}")
    measured, predicted = {"peak": test.peak}, {"peak": float(tau.max())}
    if np.isfinite(test.residual) and test.sigma_N <= 0.0:
        measured["residual"], predicted["residual"] = test.residual, float(tau[-1])
    sizes = {"peak": test.peak, "residual": max(test.residual, FLOOR * test.peak)}
    errors = {name: abs(predicted[name] - value) / sizes[name] for name, value in measured.items()}
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
    from ..style import COLOURS, ONE, label_axes, new_figure

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
    curves = [(slips, tau, s_N) for slips, _, tau, s_N in prediction.curves]
    return curves_figure(of_kind(prediction.tests, ShearTest), curves, units, "predicted")


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
        print(*fit.remarks(run, covered(tests)), sep="\n")
    if options.plot is not None:
        from ..style import printed, save

        with printed():
            save(figure_of(prediction, units), options.plot)
        print(options.plot)
    return NO_RESULT if prediction.grade == "poor" else 0
