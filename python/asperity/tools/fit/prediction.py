"""Tests beside the curves of a joint that was identified without them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ...contract import Floats
from ...interface import Interface
from ...load_path import columns_of
from ...pattern import direction_vector
from ...steps import slip_path
from .closure_test import ClosureTest
from .closures import closure_of
from .model import KT, PRELOAD, CyclicSeries, Problem, Series
from .picture import curves_figure
from .shear_test import ShearTest, cycles
from .strength import Strength
from .thresholds import FLOOR, NORMAL
from .verdict import AnyTest, Comparison, compared, grade_of
from .written import Written

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINTS, PART_OF_DEVIATION = 400, 0.1
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

    tests: Sequence[AnyTest]
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


@dataclass(frozen=True, eq=False)
class Asked:
    """Joint whose curves are asked for.

    spring: stiffness in series with the joint, stress/length; 0: none.  direction: of the slip, degrees.
    slip: to which the peak of strengths without a slip is searched, length.  fit: that of the joint, whose
    covariance and model error give the intervals of the numbers.
    """

    joint: Interface
    spring: float = 0.0
    direction: float = 0.0
    slip: float = 0.0
    fit: Written | None = None


def predicted_curves(asked: Asked, tests: Sequence[ShearTest]) -> Prediction:
    """Curves of a joint at the slips of the tests."""
    kind = OfCase if not asked.spring else CyclesOfCase if cycles(tests) else SeriesOfCase

    def problem_of(props: Floats) -> OfCase:
        return kind(tests, (), {}, direction=asked.direction, of_case=props)

    problem, values = problem_of(asked.joint.props()), {KT: asked.spring}
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
    intervals = _intervals(comparisons, lambda props: compared(problem_of(props), values), asked)
    return Prediction(tests, comparisons, _rms(comparisons, squares), curves_of_tests, intervals)


def predicted_strengths(asked: Asked, tests: Sequence[Strength]) -> Prediction:
    """Strengths of a joint, which a spring does not change."""

    def numbers(props: Floats) -> list[Comparison]:
        return [_strength(props, test, asked.direction, asked.slip) for test in tests]

    rows = numbers(asked.joint.props())
    return Prediction(tests, rows, _rms(rows, {}), [], _intervals(rows, numbers, asked))


def _intervals(
    rows: Sequence[Comparison],
    numbers: Callable[[Floats], list[Comparison]],
    asked: Asked,
) -> list[dict[str, tuple[float, float]]]:
    """Intervals of the predicted numbers, by the covariance of a fit and twice its model errors."""
    fit = asked.fit
    # a fit of the closure alone has kn, which is no constant of PROPS
    if fit is None or "kn" in fit.names:
        return []
    squares = [dict.fromkeys(set(row.errors), 0.0) for row in rows]
    for factor, *ends in fit.moved(asked.joint.props(), PART_OF_DEVIATION):
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


def predicted_closures(asked: Asked, tests: Sequence[ClosureTest]) -> Prediction:
    """Closures of a joint; the unloading counts apart, as no elastic contact follows it."""
    squares, rows, curves = dict[str, list[float]](loading=[], unloading=[]), [], []
    for test in tests:
        law = closure_of(asked.joint, test)
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


def figure_of_curves(prediction: Prediction, tests: Sequence[ShearTest], units: tuple[str, str]) -> Figure:
    """Points of the tests and curves of the joint."""
    curves = [(slips, tau, s_N) for slips, _, tau, s_N in prediction.curves]
    return curves_figure(tests, curves, units, "predicted")


def figure_of_strengths(prediction: Prediction, _: Sequence[Strength], units: tuple[str, str]) -> Figure:
    """Predicted over measured strengths."""
    from ..style import ONE, label_axes, new_figure

    figure, (ax,) = new_figure(ONE, 3.2, ncols=1)
    for name, mark in (("peak", "o"), ("residual", "s")):
        pairs = [
            (row.measured[name], row.predicted[name]) for row in prediction.compared if name in row.measured
        ]
        if pairs:
            ax.plot(*np.transpose(pairs), mark, label=name)
    top = max(max(row.measured["peak"], row.predicted["peak"]) for row in prediction.compared)
    ax.plot([0.0, top], [0.0, top], color="0.6", linewidth=0.8, zorder=0)
    label_axes(ax, f"measured strength [{units[1]}]", f"predicted strength [{units[1]}]")
    ax.legend()
    return figure


def figure_of_closures(
    prediction: Prediction, tests: Sequence[ClosureTest], units: tuple[str, str]
) -> Figure:
    """Pressure over measured and predicted closures."""
    from ..style import COLOURS, ONE, label_axes, new_figure

    figure, (ax,) = new_figure(ONE, 3.4, ncols=1)
    for i, (pressed, (pressure, rows, law, _)) in enumerate(zip(tests, prediction.curves, strict=True)):
        colour, label = COLOURS[i % len(COLOURS)], ("measured", "predicted") if i == 0 else ("", "")
        ax.plot(pressed.closure, pressure, "o", color=colour, markersize=3.0, label=label[0])
        ax.plot(law[rows], pressure[rows], color=colour, label=label[1])
    ax.locator_params(axis="x", nbins=6)
    label_axes(ax, f"closure since the first row [{units[0]}]", f"pressure [{units[1]}]")
    ax.legend()
    return figure
