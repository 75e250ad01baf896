"""Least squares of a model: residuals with penalties, derivatives, starts and solutions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...contract import Floats
from .evidence import cycles, first_stroke
from .model import PENALTY, Problem, rows_of, to_scale

if TYPE_CHECKING:
    from .ladder import Model
    from .shear_test import ShearTest

Function = Callable[[Floats], Floats]
"""Residuals of a point."""

AROUND, REACH = 6, {"ks": 1.2, "kT": 1.2, "mu": 0.15, "sigma0": 0.5, "Gc": 1.2, "crush": 1.2, "W0": 1.2}
REACH |= {"height": 0.4, "eta": 0.0}
"""Points around a start, and their distance from it, on a logarithm; of others OTHERS."""

OTHERS, STEP, RENEWED, FEW = 0.3, 1.0e-3, 5, 2
"""Distance of a point from a start, and step of the differences; largest number of times that derivatives are
renewed; and number of steps which they are near enough to serve.
"""

SEARCHED, FITTED, MOST = 1.0e-4, 1.0e-7, 40
"""Relative change of the sum of squares at which a search and fits beside the chosen one end, and the fit of
all rows; and largest number of evaluations.
"""


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


@dataclass(eq=False)
class _Corrected:
    """Residuals of a function, and derivatives from differences, which steps correct (Broyden 1965)."""

    function: Function
    step: float
    renewed: bool
    steps: int = -1

    def __post_init__(self) -> None:
        """No point yet."""
        self.last = self.base = (np.zeros(0), np.zeros(0))

    def value(self, at: Floats) -> Floats:
        """Residuals (n,)."""
        self.last = (at.copy(), self.function(at))
        return self.last[1]

    def slopes(self, at: Floats) -> Floats:
        """Derivatives (n, p), at the last point of `value`."""
        here = self.last[1] if np.array_equal(self.last[0], at) else self.function(at)
        if self.renewed or self.steps < 0:
            self.matrix = _differences(self.function, at, here, self.step)
        else:
            move, change = at - self.base[0], here - self.base[1]
            weighted = np.sum(self.matrix**2, axis=0) * move
            size = float(move @ weighted)
            if size > 0.0:
                self.matrix = self.matrix + np.outer(change - self.matrix @ move, weighted / size)
        self.steps, self.base = self.steps + 1, (at.copy(), here)
        return self.matrix


def least(
    function: Function,
    x: Floats,
    ends: Floats,
    tolerance: float = FITTED,
    step: float = STEP,
    renewed: bool = True,
) -> tuple[Floats, Floats]:
    """Point and residuals at the smallest sum of squares from x on, between the ends (2, p).

    tolerance: relative change at which the least squares end.  step: of forward differences.  renewed:
    whether every step has its own derivatives; else steps correct them, until new ones change little.
    """
    from scipy.optimize import least_squares

    low, high = ends
    margin = 1e-6 * (high - low)
    tolerances = {"ftol": tolerance, "xtol": 10.0 * tolerance, "gtol": tolerance}
    for _ in range(RENEWED):
        corrected = _Corrected(function, step, renewed)
        start = np.clip(x, low + margin, high - margin)
        solution = least_squares(
            corrected.value, start, corrected.slopes, (low, high), x_scale="jac", max_nfev=MOST, **tolerances
        )
        x = solution.x
        if renewed or corrected.steps <= FEW:
            break
    return solution.x, solution.fun


def solve(problem: Problem, x: Floats, tolerance: float = FITTED) -> tuple[Floats, Floats]:
    """Constants and residuals at the smallest sum of squares from x on, within the plausible ranges."""
    if not x.size:
        return x, residuals(problem, x)
    ends, in_closed_form = problem.ends, problem.is_closed_form
    return least(lambda at: residuals(problem, at), x, ends, tolerance, renewed=in_closed_form)


def searched(
    tests: Sequence[ShearTest],
    model: Model,
    guesses: Sequence[Mapping[str, float]],
    direction: float = 0.0,
    starts: int = 2,
    around: int = AROUND,
) -> Solution:
    """Solution on few rows, from the best of points around the guesses; the first of these is tried, too.

    The search uses the closed form of the model where there is one.  With a bond the closed form is an
    approximation, so that the law then improves the solution.  Cycles begin with that of the first strokes.
    """
    problem = model.problem(tests, 1.0, direction).coarse()
    exact, problem = problem, problem.closed_form()
    if cycles(tests):
        starts = 1
        strokes = [rows_of(test, first_stroke(test)) for test in tests]
        if model.series and model.problem(strokes, 1.0, direction).closed_form().is_closed_form:
            guesses = [searched(strokes, model, guesses, direction).values, *guesses]
            around = 0
    rng, points = np.random.default_rng(0), []
    middle = problem.values(problem.ends.mean(axis=0)) if model.free else {}
    for guess in guesses:
        centre = {
            name: max(guess.get(name, guesses[-1].get(name, middle[name])), 1e-6) for name in model.free
        }
        points.append(problem.x(centre))
        for _ in range(around):
            moved = {n: v * np.exp(REACH.get(n, OTHERS) * rng.uniform(-1.0, 1.0)) for n, v in centre.items()}
            if "eta" in moved:
                moved["eta"] = min(moved["eta"], 0.999)
            points.append(problem.x(moved))
    points = [np.clip(x, *problem.ends) if x.size else x for x in points]
    costs = [float(r @ r) for r in (residuals(problem, x) for x in points)]
    tried = {int(i) for i in np.argsort(costs)[:starts]} | ({0} if around else set())
    solutions = (solve(problem, points[i], SEARCHED) for i in sorted(tried))
    x, misfit = min(solutions, key=lambda solution: float(solution[1] @ solution[1]))
    if exact is not problem:
        problem = exact
        x, misfit = solve(exact, x, SEARCHED)
    return Solution(model, problem, x, misfit)


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
