"""Least squares of a model: residuals with penalties, derivatives, starts and solutions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...contract import Floats
from .model import Problem, rows_of, to_scale
from .shear_test import ShearTest, cycles, first_slope, first_stroke, last_slope, pressures, smooth
from .thresholds import (
    AROUND,
    FEW_TRIALS,
    FITTED,
    MOST_TRIALS,
    MOVED,
    PENALTY,
    REACH,
    REACH_OF_OTHERS,
    SEARCHED,
    STEP,
)

if TYPE_CHECKING:
    from .ladder import Model
    from .shear_test import ShearTest

Function = Callable[[Floats], Floats]
"""Residuals of a point."""


@dataclass(eq=False)
class Solution:
    """Constants x (p,) of a model on their scales, with the residuals (n,) of its problem."""

    model: Model
    problem: Problem
    x: Floats
    residuals: Floats

    @property
    def values(self) -> dict[str, float]:
        """All constants by name."""
        return self.problem.values(self.x)

    @cached_property
    def slopes(self) -> Floats:
        """Derivatives (n, p) of the residuals."""
        return jacobian(self.problem, self.x)

    @property
    def mean_squares(self) -> dict[str, float]:
        """Mean squares of tau and of the dilation, over their ranges, without weights."""
        dilation = self.problem.is_dilation
        parts = {"tau": self.residuals[~dilation], "dilation": self.residuals[dilation] / self.problem.weight}
        return {name: float(np.mean(part**2)) for name, part in parts.items() if part.size}

    @property
    def scatter(self) -> dict[str, float]:
        """Scatter of tau and of the dilation over their ranges."""
        return {name: float(np.sqrt(value)) for name, value in self.mean_squares.items()}


def residuals(problem: Problem, x: Floats) -> Floats:
    """Residuals; a trial for which the law has no result has a penalty in each row, as it is no error."""
    try:
        residuals = problem.residuals(x)
    except (ValueError, ArithmeticError):
        return np.full(len(problem.rows), PENALTY)
    return np.where(np.isfinite(residuals), residuals, PENALTY)


def jacobian(problem: Problem, x: Floats) -> Floats:
    """Derivatives (n, p) by central differences."""
    return _differences(lambda at: residuals(problem, at), x, None, STEP)


def _differences(function: Function, x: Floats, here: Floats | None, step: float) -> Floats:
    """Derivatives (n, p) by forward differences, or by central ones without the value at x."""
    columns = []
    for move in np.diag(step * np.maximum(1.0, 0.1 * np.abs(x))):
        size = move.sum()
        if here is None:
            columns.append((function(x + move) - function(x - move)) / (2.0 * size))
        else:
            columns.append((function(x + move) - here) / size)
    return np.transpose(columns)


def least(
    function: Function,
    x: Floats,
    ends: Floats,
    tolerance: float = FITTED,
    step: float = STEP,
    most: int = MOST_TRIALS,
) -> tuple[Floats, Floats]:
    """Point and residuals at the smallest sum of squares from x on, between the ends (2, p).

    tolerance: relative change at which the least squares end.  step: of forward differences.  most: trials.
    """
    from scipy.optimize import least_squares

    low, high = ends
    margin, last = 1e-6 * (high - low), (x, x)

    def value(at: Floats) -> Floats:
        nonlocal last
        last = (at.copy(), function(at))
        return last[1]

    def slopes(at: Floats) -> Floats:
        here = last[1] if np.array_equal(last[0], at) else function(at)
        return _differences(function, at, here, step)

    start = np.clip(x, low + margin, high - margin)
    tolerances = {"ftol": tolerance, "xtol": 10.0 * tolerance, "gtol": tolerance}
    solution = least_squares(value, start, slopes, (low, high), x_scale="jac", max_nfev=most, **tolerances)
    return solution.x, solution.fun


def solve(problem: Problem, x: Floats, tolerance: float = FITTED) -> tuple[Floats, Floats]:
    """Constants and residuals at the smallest sum of squares from x on, within the plausible ranges."""
    if not x.size:
        return x, residuals(problem, x)
    most = MOST_TRIALS if problem.is_closed_form else FEW_TRIALS
    return least(lambda at: residuals(problem, at), x, problem.ends, tolerance, most=most)


def searched(
    tests: Sequence[ShearTest],
    model: Model,
    guesses: Sequence[Mapping[str, float]],
    direction: float = 0.0,
    starts: int = 2,
    around: int = AROUND,
) -> Solution:
    """Solution on few rows, from the best of points around the guesses; the first of these is tried, too.

    Cycles begin with the solution of the first strokes.  The residuals of a bond are those of the law.
    """
    problem = model.problem(tests, 1.0, direction).coarse()
    if cycles(tests):
        starts, around = 1, 0
        strokes = [rows_of(test, first_stroke(test)) for test in tests]
        if model.problem(strokes, 1.0, direction).is_closed_form:
            guesses = [searched(strokes, model, guesses, direction).values, *guesses]
    rng, points = np.random.default_rng(0), []
    middle = problem.values(problem.ends.mean(axis=0)) if model.free else {}
    for guess in guesses:
        centre = {
            name: max(guess.get(name, guesses[-1].get(name, middle[name])), 1e-6) for name in model.free
        }
        points.append(problem.x(centre))
        for _ in range(around):
            moved = {
                n: v * np.exp(REACH.get(n, REACH_OF_OTHERS) * rng.uniform(-1.0, 1.0))
                for n, v in centre.items()
            }
            if "eta" in moved:
                moved["eta"] = min(moved["eta"], 0.999)
            points.append(problem.x(moved))
    points = [np.clip(x, *problem.ends) if x.size else x for x in points]
    costs = [float(r @ r) for r in (residuals(problem, x) for x in points)]
    tried = {int(i) for i in np.argsort(costs)[:starts]} | ({0} if around else set())
    solutions = (solve(problem, points[i], SEARCHED) for i in sorted(tried))
    x, misfit = min(solutions, key=lambda solution: float(solution[1] @ solution[1]))
    solution = by_law(Solution(model, problem, x, misfit), SEARCHED)
    if model.bond and solution.problem.is_closed_form:
        problem = model.problem(tests, 1.0, direction, law=True).coarse()
        solution = Solution(model, problem, x, residuals(problem, x))
    return solution


def by_law(solution: Solution, tolerance: float = FITTED) -> Solution:
    """Solution by the law from that of the closed form on, where a bond gives the law another misfit.

    The friction of the law waits for the damage, and its elastic slip is part of the softening.  A bond that
    hardly softens shows both.
    """
    closed, model = solution.problem, replace(solution.model, exact=True)
    if not closed.is_closed_form or model.shape or not model.bond:
        return solution
    law = model.problem(closed.tests, closed.weight, closed.direction)
    law = replace(law, increments=closed.increments)
    if not other_misfit(residuals(law, solution.x), solution.residuals):
        return solution
    return Solution(model, law, *solve(law, solution.x, tolerance))


def other_misfit(one: Floats, other: Floats) -> bool:
    """Whether residuals of two forms (n,) have other sums of squares, beyond what noise hides."""
    squares = [max(float(r @ r), 1e-300) for r in (one, other)]
    return one.size * abs(float(np.log(squares[0] / squares[1]))) >= MOVED


def with_crushing(law: Solution, known: Mapping[str, float]) -> Solution:
    """Solution of the law with a compressive strength, at the constants of a fit without it."""
    model, before = replace(law.model, fixed={**law.model.fixed, **known}), law.problem
    problem = model.problem(before.tests, before.weight, before.direction, law=True)
    return Solution(model, problem, law.x, residuals(problem, law.x))


def refitted(
    solution: Solution,
    tests: Sequence[ShearTest],
    model: Model | None = None,
    weight: float | None = None,
    tolerance: float = FITTED,
) -> Solution:
    """Fit of all rows of tests with a model, from a solution of it or of another one on."""
    model = model or solution.model
    problem = model.problem(
        tests, solution.problem.weight if weight is None else weight, solution.problem.direction
    )
    known = dict(solution.values)
    known["ks"] = 2.0 * known["kT"] if "kT" in known else known.get("ks", 1.0)
    if "sigma0" in known:
        # the same elastic slip, in the bond or in series
        slip = known["Gc"] / (0.5 * known["sigma0"] ** 2)
        if "kT" in known:
            known["eta"] = float(np.clip(1.0 - 1.0 / (slip * known["kT"]), 0.05, known["eta"]))
        known.setdefault("kT", 1.0 / (slip * max(1.0 - known["eta"], 1e-6)))
    known.setdefault("kT", 0.5 * known["ks"])
    low, high = problem.ends if model.free else (np.zeros(0), np.zeros(0))
    middle = dict(zip(model.free, 0.5 * (low + high), strict=True))
    start = np.array([
        float(to_scale(name, known[name])) if known.get(name) else middle[name] for name in model.free
    ])  # fmt: skip
    return Solution(model, problem, *solve(problem, start, tolerance))


def guesses(tests: Sequence[ShearTest]) -> dict[str, float]:
    """Rough values of the constants: the strength at the end less the slope there, the largest slope, its
    end.

    Any of them is only where a search begins.
    """
    mus, slopes, heights, stiffnesses, drops, ratios = [], [], [], [], [], []
    stress = max(float(np.abs(test.tau).max()) for test in tests)
    length = max(float(np.abs(test.slip).max()) for test in tests)
    for test in tests:
        rows = first_stroke(test)
        slip, tau, pressure = np.abs(test.slip[rows]), np.abs(test.tau[rows]), pressures(test)[rows]
        end = slice(-max(2, round(0.15 * slip.size)), None)
        least = 1e-9 * stress
        ratio = float(np.median(tau[end]) / max(np.median(pressure[end]), least))
        at_end = last_slope(test)
        if test.s_N is not None:
            slopes.append(max(first_slope(test), 0.02))
            heights.append(max(1.1 * float(np.mean(test.s_N[rows][end])), 0.02 * float(slip.max())))
        mus.append((ratio - at_end) / (1.0 + ratio * at_end))
        top = int(np.argmax(smooth(tau, min(3, tau.size))))
        stiffnesses.append(float(np.max(tau[: top + 2] / np.maximum(slip[: top + 2], 1e-9 * length))))
        drops.append(float(tau.max() - np.median(tau[end])))
        ratios.append(float(tau.max() / max(pressure[top], least)))
    mu, peak = float(np.clip(np.median(mus), 0.05, 1.5)), float(np.median(ratios))
    slope = float(np.median(slopes)) if slopes else max(0.05, (peak - mu) / (1.0 + peak * mu))
    bond = float(max(np.median(drops), 0.05 * stress))
    return {
        "kT": float(np.median(stiffnesses)),
        "ks": 2.0 * float(np.median(stiffnesses)),
        "mu": mu,
        "theta": float(np.clip(np.degrees(np.arctan(slope)), 1.0, 60.0)),
        "height": float(np.median(heights)) if heights else 0.25 * length * slope,
        "sigma0": bond,
        "Gc": 0.1 * bond * length,
        "crush": 3.0 * max(-test.pressed for test in tests) + 1e-3 * stress,
        "W0": stress * length,
        "eta": 0.9,
    }
