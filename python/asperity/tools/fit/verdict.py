"""Measured beside predicted numbers, the grade of a fit, and reasons why its constants are no result."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from .evidence import cycles, first_slope, first_stroke, last_slope, noises, numbers, pressures, smooth
from .intervals import Estimate
from .ladder import NOISE, ROWS_EACH, independent
from .model import KS, KT, SPRINGS, Problem
from .shear_test import ShearTest
from .squares import SEARCHED, Solution, refitted

GOOD, FAIR = 0.05, 0.15
"""Largest error of a good and of a fair fit."""

FACTOR, LOOSE, FACTOR_LOOSE = 2.0, ("Gc", "W0"), 5.6
"""Factor from the middle of an interval to its ends beyond which a constant is not determined; for some."""

LEAST_ROWS, SLIDING, SHARE_SLIDING, SLIDING_ROWS = 10, 0.05, 0.1, 3
"""Rows with which a law can be judged; slip beyond the spring, over the largest slip, of a row that slides;
and fraction and number of such rows.
"""

ROWS_OF_ONE = 20
"""Rows of a single curve beside whose noise a misfit is seen."""

SHARE_PLATEAU, PLATEAU_ROWS = 0.2, 8
"""Fraction and number of rows after the softening of a bond, at the residual strength."""

ENDED, SAME_CURVE = 0.3, 2
"""Slope of the dilation at the end over the largest one above which it has not ended; and constants that one
curve of the strength shows.
"""


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
    parts, comparisons = zip(problem.tests, problem.paths, problem.curves(values), strict=True), []
    for number, (test, (_, rows), (tau, s_N, _)) in enumerate(parts):
        if only is not None and number != only:
            continue
        measured = numbers(test, test.tau, test.s_N)
        predicted = numbers(test, tau[rows], None if test.s_N is None else s_N[rows])
        off = {name: abs(predicted[name] - value) for name, value in measured.items()}
        sizes = {name: abs(value) for name, value in measured.items()} | {"dilation": top}
        errors: dict[str, float] = {
            name: off[name] / max(sizes[name], 1e-300)
            for name in ("peak", "residual", "dilation")
            if name in off and sizes[name] > 0.0
        }
        of_noise = {name: value / sizes[name] for name, value in noises(test).items() if name in errors}
        comparisons.append(Comparison(test.name, measured, predicted, errors, of_noise))
    return comparisons


def blind(solution: Solution, tests: Sequence[ShearTest]) -> list[Comparison]:
    """Each test predicted by the others, with the same model."""
    made: list[Comparison] = []
    for number in range(len(tests)) if len(tests) > 1 else ():
        rest = [test for i, test in enumerate(tests) if i != number]
        model = solution.model
        if "crush" in model.free and len({round(test.pressed, 9) for test in rest}) < 2:
            model = model.without("crush", crush=solution.values["crush"])
        if not model.free:
            continue
        without = refitted(solution, rest, model, tolerance=SEARCHED)
        problem, values = solution.model.problem(tests, 1.0, solution.problem.direction), dict(without.values)
        made += compared(problem, values, number)
    return made


def worst_errors(
    scatter: Mapping[str, float],
    fitted: Sequence[Comparison],
    unseen: Sequence[Comparison],
    deviations: float = 0.0,
) -> dict[str, float]:
    """Largest error by name: scatter over the range, of the fitted tests and of blind ones.

    deviations: times the noise of a measured number, which is no error of the law, to leave out.
    """
    errors = {"scatter": max(scatter.values())}
    for label, rows in (("", fitted), ("blind ", unseen)):
        for row in rows:
            for name, error in row.errors.items():
                beyond = max(0.0, error - deviations * row.noise.get(name, 0.0))
                errors[label + name] = max(errors.get(label + name, 0.0), beyond)
    return errors


def undetermined(estimates: Mapping[str, Estimate], at_bounds: Sequence[str]) -> list[str]:
    """Constants whose interval is wider than a factor or that lie at a bound."""
    loose = []
    for name, (_, low, high) in estimates.items():
        factor = FACTOR_LOOSE if name in (*LOOSE, *SPRINGS) else FACTOR
        # with other assumptions on one side of the value the whole width counts
        wide = high > factor**2 * max(low, 1e-300)
        if wide or name in at_bounds:
            loose.append(name)
    return loose


def too_little(solution: Solution, tests: Sequence[ShearTest]) -> Iterator[str]:
    """Reasons why the tests cannot show what is free, whatever the intervals."""
    own = [name for name in solution.model.free if name not in SPRINGS]
    rows, data = sum(test.slip.size for test in tests), sum(independent(solution).values())
    if rows < LEAST_ROWS:
        yield f"{rows} rows: at least {LEAST_ROWS} are needed to judge the law by"
    if data < ROWS_EACH * len(own):
        yield f"{data:.0f} independent data for {len(own)} constants: longer tests or further ones are needed"
    if {*SPRINGS} & {*solution.model.free} and not _slides(solution):
        yield "the tests end before the joint slides: mu is not shown; longer tests are needed"
    dilates, levels = any(test.s_N is not None for test in tests), {round(test.pressed, 9) for test in tests}
    scatter = solution.scatter["tau"]
    if len(tests) == 1 and not dilates and scatter > GOOD and (rows < ROWS_OF_ONE or data < NOISE * rows):
        yield f"one curve, which the law misses by {scatter:.0%}, not by noise alone: another test would help"
    if not dilates and len(levels) < 2 and not cycles(tests):
        if len(own) > SAME_CURVE:
            if not (solution.model.bond and _softened(solution)):
                yield f"one curve of the strength does not show {', '.join(own)}: a second pressure would"
        if "theta" in own:
            yield "one curve without dilation does not show theta: measure the dilation, or a second pressure"


def _slides(solution: Solution) -> bool:
    """Whether in some test enough rows lie beyond the slip of the spring."""
    problem, values = solution.problem, solution.values
    stiffness = values[KT] if KT in values else values[KS]
    for test, (_, rows), (tau, *_) in zip(
        problem.tests, problem.paths, problem.curves(solution.values), strict=True
    ):
        beyond = np.abs(test.slip) - np.abs(tau[rows]) / stiffness > SLIDING * np.abs(test.slip).max()
        if np.sum(beyond) >= max(SLIDING_ROWS, SHARE_SLIDING * test.slip.size):
            return True
    return False


def _softened(solution: Solution) -> bool:
    """Whether a curve shows bond and friction apart: rows of the softening, and of the friction after it."""
    values = solution.values
    for test in solution.problem.tests:
        if test.k_N or test.path_N is not None:  # the strength may follow the pressure
            continue
        rows = first_stroke(test)
        tau, slip = np.abs(test.tau[rows]), np.abs(test.slip[rows])
        own = slip - tau / values[KT] if KT in values else slip
        after, top = own > 2.0 * values["Gc"] / values["sigma0"], int(np.argmax(smooth(tau, 3)))
        enough = max(PLATEAU_ROWS, SHARE_PLATEAU * tau.size)
        if np.sum(after) >= enough and np.sum(~after[top:]) >= SLIDING_ROWS:
            return True
    return False


def remarks(solution: Solution, tests: Sequence[ShearTest]) -> Iterator[str]:
    """Notes that a reader needs to use the constants."""
    ratios = [last_slope(test) / first_slope(test) for test in tests if first_slope(test) > 0.0]
    if "theta" in solution.model.free and ratios and max(ratios) > ENDED:
        yield (
            f"the dilation has not ended (its slope at the end is {max(ratios):.0%} of the first one): mu is "
            "the friction beside this dilation, not tan(phi_r)"
        )
    if solution.model.bond and "theta" in solution.model.free:
        yield "sigma0 is the bond beside the friction of the slope; 'a slope without friction' is it alone"
    levels = {round(test.pressed, 9) for test in tests}
    if solution.model.bond and len(levels) == 1:
        yield (
            "one pressure: sigma0 is what the peak adds to the friction there; asperities would look the same"
        )
    if len(tests) > 1 and len(levels) == 1:
        yield "one pressure: the blind errors say nothing about others"
    if len(tests) == 1:
        yield (
            "one test: nothing was predicted that the fit had not seen; a second test at another "
            "pressure shows it"
        )


def coverage(tests: Sequence[ShearTest]) -> tuple[float, float, float]:
    """Smallest and largest pressure, and largest slip of the tests: where the constants have been seen."""
    levels = [float(np.max(pressures(test)[first_stroke(test)])) for test in tests]
    return (
        min(-test.pressed for test in tests),
        max(levels),
        max(float(np.abs(test.slip).max()) for test in tests),
    )
