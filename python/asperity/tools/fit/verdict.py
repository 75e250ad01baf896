"""What a fit has found: measured beside predicted numbers, grade, reasons why constants are no result."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from ...contract import Floats
from ...interface import Interface
from .closure_test import ClosureTest
from .intervals import Assumption, Estimate, Intervals
from .model import KT, SPRINGS, Problem
from .rigid import LAW
from .search import Solution, independent, refitted
from .shear_test import ShearTest, cycles, first_slope, last_slope, noises, numbers, pressures
from .strength import Strength
from .thresholds import (
    BY_NOISE,
    ENDED,
    FACTOR,
    FAIR,
    FALLS,
    FLOOR,
    GOOD,
    LEAST_ROWS,
    LEVELS_APART,
    NOISE,
    ROWS_EACH,
    ROWS_OF_ONE,
    SEARCHED,
    SHARE_SLIDING,
    SLIDING,
    SLIDING_ROWS,
    UNSAFE,
    WEIGHT,
)

AnyTest: TypeAlias = ShearTest | Strength | ClosureTest
"""A test of any kind."""


@dataclass(frozen=True)
class Comparison:
    """Measured and predicted numbers of a test by name, relative errors, and noise of the measured ones."""

    test: str
    measured: Mapping[str, float]
    predicted: Mapping[str, float]
    errors: Mapping[str, float]
    noise: Mapping[str, float] = field(default_factory=dict)


def grade_of(error: float) -> str:
    """Grade of the largest error."""
    return "good" if error <= GOOD else "fair" if error <= FAIR else "poor"


def compared(problem: Problem, values: Mapping[str, float], only: int | None = None) -> list[Comparison]:
    """Measured and predicted numbers of the tests of a problem, or of one of them."""
    top = max([0.0, *(float(np.abs(test.s_N).max()) for test in problem.tests if test.s_N is not None)])
    comparisons = []
    for number in range(len(problem.tests)) if only is None else (only,):
        test, (_, rows) = problem.tests[number], problem.paths[number]
        tau, s_N, _ = problem.curve(values, number)
        measured = numbers(test, test.tau, test.s_N)
        predicted = numbers(test, tau[rows], None if test.s_N is None else s_N[rows])
        off = {name: abs(predicted[name] - value) for name, value in measured.items()}
        sizes = {name: abs(value) for name, value in measured.items()} | {"dilation": top}
        if "residual" in sizes:
            # without a pressure the law has none
            floor = FLOOR if test.pressed else 1.0
            sizes["residual"] = max(sizes["residual"], floor * sizes["peak"])
        errors: dict[str, float] = {
            name: off[name] / max(sizes[name], 1e-300)
            for name in ("peak", "residual", "dilation")
            if name in off and sizes[name] > 0.0
        }
        of_noise = {name: value / sizes[name] for name, value in noises(test).items() if name in errors}
        comparisons.append(Comparison(test.name, measured, predicted, errors, of_noise))
    return comparisons


def blind(solution: Solution, tests: Sequence[ShearTest]) -> tuple[list[Comparison], list[Solution]]:
    """Each test predicted by the others, with the same model; and the fit without it."""
    comparisons: list[Comparison] = []
    left_out: list[Solution] = []
    problem = of_law(solution, tests)
    for number in range(len(tests)) if len(tests) > 1 else ():
        rest = [test for i, test in enumerate(tests) if i != number]
        model = solution.model
        if "crush" in model.free and len({round(test.pressed, 9) for test in rest}) < 2:
            model = model.without("crush", crush=solution.values["crush"])
        if not model.free:
            continue
        without = refitted(solution, rest, model, tolerance=SEARCHED)
        comparisons += compared(problem, dict(without.values), number)
        left_out.append(without)
    return comparisons, left_out


def of_law(solution: Solution, tests: Sequence[ShearTest], weight: float = 1.0) -> Problem:
    """Problem of the law for constants that were fitted with any shape."""
    return replace(solution.model, shape=LAW).problem(tests, weight, solution.problem.direction, law=True)


@dataclass(frozen=True)
class Errors:
    """Root mean square errors by name, of the tests and of blind predictions, and what of them is the law's.

    all: as they are, the first of them the scatter of the rows.  of_law: without the spread of the specimens,
    which no law predicts, and without the noise of the measured numbers.  spread: standard deviation of the
    specimens.  worst: name of the test with the largest error.
    """

    all: dict[str, float]
    of_law: dict[str, float]
    spread: dict[str, float]
    worst: dict[str, str]


def errors_of(
    solution: Solution, tests: Sequence[ShearTest], fitted: Sequence[Comparison], unseen: Sequence[Comparison]
) -> Errors:
    """Errors of a fit and of its blind predictions, over the tests."""
    every, law, spread, worst = ({"scatter": max(solution.scatter.values())}, {}, {}, {})
    law["scatter"] = max(scatter_of_law(solution, tests).values())
    pressures = np.array([-test.pressed for test in tests])
    for label, rows in (("", fitted), ("blind ", unseen)):
        for name in ("peak", "residual", "dilation"):
            with_name = [i for i, row in enumerate(rows) if name in row.errors]
            if not with_name:
                continue
            off = [
                row.errors[name] * np.sign(row.predicted[name] - row.measured[name])
                for row in rows
                if name in row.errors
            ]
            noisy = [BY_NOISE * rows[i].noise.get(name, 0.0) for i in with_name]
            signed, of_noise = np.array(off), np.array(noisy)
            every[label + name] = float(np.sqrt(np.mean(signed**2)))
            beyond = np.sign(signed) * np.maximum(0.0, np.abs(signed) - of_noise)
            apart = spread_of(beyond, pressures[with_name])
            law[label + name] = without_spread(float(np.sqrt(np.mean(beyond**2))), apart)
            spread[label + name] = apart
            worst[label + name] = rows[with_name[int(np.argmax(np.abs(signed)))]].test
    return Errors(every, law, spread, worst)


def trend_of(errors: Floats, pressures: Floats) -> Floats:
    """Line (n,) over the logarithm of the pressure through errors (n,) of tests: the part of a law.

    What is left differs from specimen to specimen.  Tests at one pressure, but for its scatter, have a mean.
    """
    columns = _lines(pressures)
    return np.asarray(columns @ np.linalg.lstsq(columns, errors, rcond=None)[0])


def _lines(pressures: Floats) -> Floats:
    """Columns (n, 1 or 2) of a mean and a slope; a pressure of 0 counts as a tenth of the least other one."""
    ones, above = np.ones((pressures.size, 1)), pressures[pressures > 1e-9 * pressures.max()]
    if not above.size:
        return ones
    at = np.log(np.maximum(pressures, 0.1 * above.min()))
    return ones if np.ptp(at) < np.log(LEVELS_APART) else np.column_stack([ones, at - at.mean()])


def spread_of(errors: Floats, pressures: Floats) -> float:
    """Standard deviation of errors (n,) of tests about their trend, 0 for two tests."""
    freedom = errors.size - _lines(pressures).shape[1]
    if freedom < 1:
        return 0.0
    residuals = errors - trend_of(errors, pressures)
    return float(np.sqrt(residuals @ residuals / freedom))


def missed_peaks(
    fitted: Sequence[Comparison], tests: Sequence[ShearTest]
) -> Iterator[tuple[float, float, str]]:
    """Relative error, its limit and a sentence of the peaks that the law misses most, above and below.

    The errors are without noise and specimens, 0 where the law misses no peak on this side.
    """
    off = np.array([row.predicted["peak"] / row.measured["peak"] - 1.0 for row in fitted])
    noisy = BY_NOISE * np.array([row.noise.get("peak", 0.0) for row in fitted])
    beyond = np.sign(off) * np.maximum(0.0, np.abs(off) - noisy)
    trend = trend_of(beyond, np.array([-test.pressed for test in tests]))
    missed = np.where(beyond * trend > 0.0, np.minimum(np.abs(beyond), np.abs(trend)), 0.0)
    for sign, limit, side in ((1.0, UNSAFE, "above"), (-1.0, FAIR, "below")):
        of_side = np.where(sign * off > 0.0, missed, 0.0)
        most = int(np.argmax(of_side))
        row = fitted[most]
        numbers = f"{row.predicted['peak']:.3g} for {row.measured['peak']:.3g}"
        yield (
            float(of_side[most]),
            limit,
            (f"the peak of the law lies {abs(off[most]):.0%} {side} that of {short(row.test)} ({numbers})"),
        )


def without_spread(error: float, spread: float) -> float:
    """Error without the spread of the specimens; the whole error where it is twice that of a fair fit."""
    return error if error > 2.0 * FAIR else float(np.sqrt(max(0.0, error**2 - spread**2)))


def scatter_of_law(solution: Solution, tests: Sequence[ShearTest]) -> dict[str, float]:
    """Scatter of tau and dilation without that of specimens whose whole curves are larger or smaller."""
    problem, pressures, scatters = solution.problem, np.array([-test.pressed for test in tests]), {}
    for name, scatter in solution.scatter.items():
        factors, sizes = [], []
        for number in range(len(tests)):
            rows = (problem.rows.test == number) & (problem.rows.name == name)
            if rows.any():
                weight = problem.weight if name == "dilation" else 1.0
                measured = problem.rows.measured[rows] / problem.rows.scale[rows]
                law = measured + solution.residuals[rows] / weight
                square = max(float(law @ law), 1e-300)
                factors.append(1.0 - float(law @ measured) / square)
                sizes.append(square / measured.size)
        spread = spread_of(np.array(factors), pressures[: len(factors)])
        scatters[name] = without_spread(scatter, spread * float(np.sqrt(np.mean(sizes))))
    return scatters


def undetermined(estimates: Mapping[str, Estimate], at_bounds: Sequence[str]) -> list[str]:
    """Constants whose interval is wider than a factor or that lie at a bound."""
    loose = []
    for name, (_, low, high) in estimates.items():
        # with other assumptions on one side of the value the whole width counts
        wide = high > FACTOR**2 * max(low, 1e-300)
        if wide or name in at_bounds:
            loose.append(name)
    return loose


def too_little(solution: Solution, tests: Sequence[ShearTest]) -> Iterator[str]:
    """Reasons why the tests cannot show what is free, whatever the intervals."""
    constants = [name for name in solution.model.free if name not in SPRINGS]
    rows, data = sum(test.slip.size for test in tests), sum(independent(solution).values())
    if rows < LEAST_ROWS:
        yield f"{rows} rows: at least {LEAST_ROWS} are needed to judge the law by"
    if data < ROWS_EACH * len(constants):
        text = f"{data:.0f} independent data for {len(constants)} constants"
        yield f"{text}: longer tests or further ones are needed"
    if not _slides(solution):
        what = "the strength of the bond" if solution.model.bond else "mu"
        yield f"the tests end before the joint slides: {what} is not shown; longer tests are needed"
    dilates, levels = any(test.s_N is not None for test in tests), {round(test.pressed, 9) for test in tests}
    scatter = solution.scatter["tau"]
    if len(tests) == 1 and not dilates and scatter > GOOD and (rows < ROWS_OF_ONE or data < NOISE * rows):
        yield f"one curve, which the law misses by {scatter:.0%}, not by noise alone: another test would help"
    unshown = not dilates and len(levels) < 2 and max(levels, key=abs) and not cycles(tests)
    if unshown and "theta" in constants:
        yield "one curve without dilation does not show theta: measure the dilation, or a second pressure"


def _slides(solution: Solution) -> bool:
    """Whether in some test enough rows lie beyond the elastic slip of spring and joint."""
    problem, values = solution.problem, solution.values
    compliance = sum(1.0 / values[name] for name in SPRINGS if name in values)
    if solution.model.bond:
        compliance += 2.0 * (1.0 - values["eta"]) * values["Gc"] / values["sigma0"] ** 2
    for test, (_, rows), (tau, *_) in zip(
        problem.tests, problem.paths, problem.curves(solution.values), strict=True
    ):
        beyond = np.abs(test.slip) - np.abs(tau[rows]) * compliance > SLIDING * np.abs(test.slip).max()
        if np.sum(beyond) >= max(SLIDING_ROWS, SHARE_SLIDING * test.slip.size):
            return True
    return False


def weights(tests: Sequence[ShearTest]) -> Iterator[str]:
    """Note where the ratio of strength to pressure falls as if a weight had been left out of the pressure."""
    if any(test.k_N for test in tests):
        # without the dilation the pressure at the end is not known
        return
    numbered = [
        (float(pressures(test)[-1]), numbers(test, test.tau, None).get("residual", 0.0)) for test in tests
    ]
    at, strength = np.transpose(sorted(numbered))
    if at[0] <= 0.0 or at[-1] < LEVELS_APART * at[0] or strength.min() <= 0.0:
        return
    slope, start = np.polyfit(at, strength, 1)
    ratios = strength / at
    falls = bool((np.diff(ratios) < 0.0).all()) and ratios[-1] < FALLS * ratios[0]
    if falls and slope > 0.0 and start > WEIGHT * slope * at[0]:
        yield (
            f"residual strength over pressure falls from {ratios[0]:.3g} at {at[0]:.3g} to {ratios[-1]:.3g} "
            f"at {at[-1]:.3g}, as if a pressure of {start / slope:.2g} had not been counted: check sigma_N "
            "for the weight of the upper half and the box; or the specimens differ"
        )


def remarks(solution: Solution, tests: Sequence[ShearTest]) -> Iterator[str]:
    """Notes that a reader needs to use the constants."""
    yield from weights(tests) if not cycles(tests) else ()
    ratios = [last_slope(test) / first_slope(test) for test in tests if first_slope(test) > 0.0]
    if "theta" in solution.model.free and ratios and max(ratios) > ENDED:
        yield (
            f"the dilation has not ended (its slope at the end is {max(ratios):.0%} of the first one): mu is "
            "the friction beside this dilation, not tan(phi_r)"
        )
    if solution.model.bond and "theta" in solution.model.free:
        yield "sigma0 is the bond beside the friction of the slope; 'a slope without friction' is it alone"
    levels = {round(test.pressed, 9) for test in tests}
    if solution.model.bond and len(levels) == 1 and max(levels, key=abs):
        yield (
            "one pressure: sigma0 is what the peak adds to the friction there; asperities would look the same"
        )
    if len(tests) > 1 and len(levels) == 1 and max(levels, key=abs):
        yield "one pressure: the blind errors say nothing about others"
    if len(tests) == 1:
        yield (
            "one test: nothing was predicted that the fit had not seen; a second test"
            f"{' at another pressure' * bool(max(levels, key=abs))} shows it"
        )


def short(name: str) -> str:
    """Name of a test without the folder of its file, 27 characters at most."""
    text = name.replace("\\", "/").rsplit("/", 1)[-1]
    return text if len(text) <= 27 else f"...{text[-24:]}"


@dataclass(eq=False)
class Fit:
    """Identified constants, their intervals, and the judgement of both.

    tests: that were fitted.  solution: constants and residuals.  estimates: free constants with their
    intervals, which contain noise, misfit of the law and other assumptions.  fitted, blind: measured and
    predicted numbers of each test, in the second list predicted by the other tests.  errors: largest error
    of each kind.  grade: good (at most 5 %), fair (15 %) or poor.  reasons: why the constants are no result;
    none if they are one.  notes: what else a user should know.  assumptions: fits with other assumptions.
    models: free constants of the models of the ladder, with their information criterion over that of the
    chosen one.  loose: free constants that are not determined and on which the others do not depend.
    """

    tests: Sequence[ShearTest]
    solution: Solution
    intervals: Intervals
    estimates: dict[str, Estimate]
    fitted: list[Comparison]
    blind: list[Comparison]
    errors: dict[str, float]
    grade: str
    reasons: list[str]
    notes: list[str] = field(default_factory=list)
    assumptions: list[Assumption] = field(default_factory=list)
    models: list[tuple[tuple[str, ...], float]] = field(default_factory=list)
    loose: list[str] = field(default_factory=list)
    _known: dict[tuple[object, ...], Mapping[str, float]] = field(default_factory=dict, repr=False)

    @property
    def is_result(self) -> bool:
        """Whether the constants may be used: no reason speaks against them."""
        return not self.reasons

    @property
    def values(self) -> dict[str, float]:
        """All constants by name."""
        return self.solution.values

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free constants."""
        return self.solution.model.free

    @property
    def interface(self) -> Interface:
        """Interface with the identified constants."""
        return self.solution.problem.interface(self.values)

    @property
    def spring(self) -> float:
        """Stiffness of the spring in series with the joint, 0 without one."""
        return self.values.get(KT, 0.0)

    @property
    def scatter(self) -> dict[str, float]:
        """Scatter of tau and of the dilation over their ranges."""
        return self.solution.scatter

    @property
    def peaks(self) -> list[Estimate]:
        """Peaks of the tests by the law, with intervals."""
        return [self.number(test, "peak") for test in range(len(self.fitted))]

    @property
    def model_text(self) -> str:
        """Form of the joint, its free constants, and values that were fixed."""
        model, hidden = self.solution.model, ("theta", "flat", "height", "crush", "W0", "closure")
        form = "with bond" if model.bond else "without bond"
        pattern = f"{model.sides} sides" if "theta" in {*model.free, *model.fixed} else "flat"
        fixed = [f"{n} = {value:.4g}" for n, value in model.fixed.items() if value or n not in hidden]
        known = f"; fixed: {', '.join(fixed)}" if fixed else ""
        return f"joint {form}, {pattern}; free: {', '.join(self.free)}{known}"

    @property
    def covariance(self) -> Floats:
        """Covariance (p, p) of the free constants on their scales, with the size of the intervals."""
        return self.intervals.covariance

    @property
    def residuals(self) -> Floats:
        """Residuals (n,) over the range of each test and quantity, of tau then of the dilation."""
        weights = self.solution.problem.weight * self.solution.problem.is_dilation
        weights[~self.solution.problem.is_dilation] = 1.0
        return self.solution.residuals / weights

    def of(self, function: Callable[[Mapping[str, float]], float]) -> Estimate:
        """Value and interval of a positive function of the constants."""
        return self.intervals.of("", function)

    def number(self, test: int, name: str) -> Estimate:
        """Number of a test by the law, with an interval that contains the misfit of such numbers.

        name: peak, slip at peak, residual or dilation.  The misfit is that of the blind predictions where
        there are any.
        """

        def of(values: Mapping[str, float]) -> float:
            return max(abs(self._numbers(test, values).get(name, 0.0)), 1e-12)

        exact, (value, low, high) = abs(self.fitted[test].predicted[name]), self.of(of)
        missed = [row.errors[name] for row in self.blind or self.fitted if name in row.errors]
        off = 2.0 * float(np.sqrt(np.mean(np.square(missed)))) if missed else 0.0
        below, above = (float(np.hypot(half / value, off)) for half in (value - low, high - value))
        return Estimate(exact, exact * (1.0 - below), exact * (1.0 + above))

    def _numbers(self, test: int, values: Mapping[str, float]) -> Mapping[str, float]:
        """Numbers of a test by the closed form, if there is one, each set of which runs once."""
        key = (test, *values.items())
        if key not in self._known:
            self._known[key] = compared(self._alone[test], values)[0].predicted
        return self._known[key]

    @cached_property
    def _alone(self) -> list[Problem]:
        """Problem of each test alone."""
        model, direction = self.solution.model, self.solution.problem.direction
        return [model.problem([test], 1.0, direction) for test in self.tests]

    @property
    def model_error(self) -> tuple[float, float]:
        """Relative errors of tau and of the dilation, blind ones where there are any: root mean squares."""
        rows = self.blind or self.fitted
        means = []
        for names in (("peak", "residual"), ("dilation",)):
            errors = [row.errors[name] for row in rows for name in names if name in row.errors]
            means.append((sum(error**2 for error in errors) / max(1, len(errors))) ** 0.5)
        return means[0], means[1]
