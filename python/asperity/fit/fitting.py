"""Parameters of the law from shear-box records: least squares on the forward model."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from .. import contract
from ..contract import Floats
from ..interface import Interface
from ..parallel import map_in_order
from .checks import LARGEST_RATIO
from .model import (
    BOND,
    FINER,
    INCREMENTS,
    KS,
    SCALES,
    SIDES,
    STEP,
    TIMELESS,
    Problem,
    Scale,
    material_of,
)
from .shear_test import ShearTest

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

DEFAULT_FREE = ("sigma0", "Gc", "eta", "mu", "theta", "flat", "kc")
"""Parameters that are free unless they are set: what is not known is not assumed."""

FLAT_FREE = ("sigma0", "Gc", "eta", "mu")
"""The same for a flat joint: its closing stiffness shows in no shear-box test."""


def needed(sides: int | None, given: Container[str]) -> list[str]:
    """Parameters that are free or set in a fit in which these are given."""
    names = FLAT_FREE if sides == 0 else DEFAULT_FREE
    return [KS, *(name for name in names if name not in BOND)] if KS in given else list(names)


DEFAULT_FIXED = {"eta": 0.9} | {
    row.name: row.default for row in TIMELESS if row.default is not None and row.name != "theta"
}
"""Values of parameters that a given list of free ones leaves out."""

STARTS_TRIED = 5
"""Number of starts. About one in four ends in the local minimum of a curve that never softens (small s_f)."""

AGREEING, MORE_STARTS = 3, 3
"""Where fewer starts reach the smallest sum of squares, up to MORE_STARTS times as many starts are tried."""

SAMPLES = 48
"""Points of a Latin hypercube; the best of them are the starts."""

DEPENDENT = 0.3
"""Correlation of neighbouring residuals above which the model differs from the record by more than noise."""

DEVIATIONS = 3.0
"""Standard deviations of the correlation of independent residuals, 1/sqrt(n), that count as none."""

SAME = 1.01
"""Largest ratio of two sums of squares that count as the same minimum."""

UNDETERMINED = 2.0
"""A parameter is not determined if its value and an end of its interval differ by more than this factor."""

COUPLED = 0.99
"""Correlation above which two parameters are called not separable."""

REFINE = 4
"""Sub-increments per increment of the next finer model."""

REFINEMENTS = 3
"""Largest number of refinements, which divide an increment by at most 64."""

ENOUGH = 0.1
"""Accepted shift of a parameter by finer increments, in standard errors.

This shift turns a 95 % interval into one of 94.8 %.
"""

MOST_INCREMENTS = 10000
"""Largest number of increments that can be requested along a test."""

MOST_ROWS = 400000
"""Largest number of increments of a test in the finest model: 150 MB of state for nine planes."""

LEAST_ERROR = 1.0e-3
"""Smallest relative standard error in which a shift is measured: no two boxes agree to a thousandth."""

MOST_EVALUATIONS = 60
"""Largest number of residual evaluations of one least-squares solution, without those for derivatives."""

RANK = 1.0e-10
"""Singular values below this fraction of the largest one are rounding errors."""

Tick = Callable[[str], object]
"""Function that is called with the name of every part of a fit when it is done."""


BOUNDS = {
    "eta": (0.05, 0.995),
    "mu": (0.01, 2.0),
    "theta": (0.5, 75.0),
    "flat": (0.005, 0.95),
    "kc": (0.1, 1e3),
    "damage0": (0.01, 0.99),
}
"""Bounds of the parameters; those with the unit of a stress or a length depend on the tests."""

DEGREES = " in degrees"
"""Remark after bounds of theta in messages."""

STARTS = {
    "eta": (0.4, 0.97),
    "mu": (0.15, 1.0),
    "theta": (5.0, 45.0),
    "flat": (0.1, 0.6),
    "kc": (0.5, 50.0),
    "damage0": (0.05, 0.95),
}
"""Ranges from which starts are drawn."""


@dataclass(frozen=True)
class Estimate:
    """Value and ends of its confidence interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Fit:
    """Identified parameters and measures of their quality.

    values: parameters by name, fixed ones included.  x: transformed free ones; covariance (p, p): of x.
    quantile: of Student's t at `confidence`, and with an accepted model error times `dependence_factor`.
    scatter: standard deviation of tau and of s_N about the fit, over their range (nan without dilation).
    neighbours: correlation of residuals of neighbouring rows.
    derivative_error: largest relative difference of a column of the Jacobian from one with a smaller step.
    shift: largest change of a parameter, in standard errors, if each increment is divided into REFINE.
    costs: sums of squares from the starts with the requested increments, the best first.  converged: whether
    the least squares converged.  singular: singular values of the Jacobian, in descending order;
    directions (p, p): their vectors, in rows.
    """

    problem: Problem
    values: dict[str, float]
    x: Floats
    covariance: Floats
    quantile: float
    confidence: float
    residuals: Floats
    scatter: tuple[float, float]
    neighbours: float
    derivative_error: float
    shift: float
    converged: bool
    costs: tuple[float, ...]
    evaluations: int
    singular: Floats
    directions: Floats
    model_error: float = 0.0

    @property
    def dependent(self) -> bool:
        """Whether the residuals of neighbouring rows are correlated beyond chance."""
        return self.neighbours > max(DEPENDENT, DEVIATIONS / np.sqrt(self.residuals.size))

    @property
    def dependence_factor(self) -> float:
        """Factor by which correlated residuals widen an interval (autoregressive of first order)."""
        return float(np.sqrt((1.0 + self.neighbours) / (1.0 - self.neighbours)))

    @property
    def widened(self) -> bool:
        """Whether the intervals are widened by `dependence_factor`."""
        return self.dependent and self.model_error > 0.0

    @property
    def correlation(self) -> Floats:
        """Correlation matrix of the transformed free parameters, (p, p)."""
        sizes = np.sqrt(np.diag(self.covariance))
        matrix: Floats = self.covariance / np.outer(sizes, sizes)
        return matrix

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Free parameters with their intervals, which are symmetric in the transformed parameters."""
        half = self.quantile * np.sqrt(np.diag(self.covariance))
        return {
            name: Estimate(self.values[name], *(SCALES[name].back(x + sign * h) for sign in (-1.0, 1.0)))
            for name, x, h in zip(self.problem.free, self.x, half, strict=True)
        }

    @property
    def interface(self) -> Interface:
        """Interface with the identified parameters."""
        return self.problem.interface(self.values)

    def of(self, function: Callable[[Mapping[str, float]], float]) -> Estimate:
        """Interval of a positive function of the parameters, from the gradient of its logarithm."""

        def log(x: Floats) -> float:
            return float(np.log(function(self.problem.values(x))))

        shifts = STEP * np.eye(self.x.size)
        gradient = np.array([(log(self.x + d) - log(self.x - d)) / (2.0 * STEP) for d in shifts])
        half = self.quantile * float(np.sqrt(gradient @ self.covariance @ gradient))
        value = log(self.x)
        return Estimate(*(Scale().back(v) for v in (value, value - half, value + half)))

    @property
    def agreeing(self) -> int:
        """Number of starts that reached the smallest sum of squares."""
        return sum(cost <= SAME * self.costs[0] for cost in self.costs)

    @property
    def inseparable(self) -> bool:
        """Whether mu and theta are to be identified from tests that show the residual ratio only."""
        free = self.problem.free
        if self.problem.dilation or not {"mu", "theta"} <= set(free):
            return False
        return abs(float(self.correlation[free.index("mu"), free.index("theta")])) > COUPLED

    @property
    def lost_rows(self) -> int:
        """Number of rows of the tests that the model does not reach, because it has no equilibrium there."""
        curves = self.problem.curves(self.values)
        pairs = zip(self.problem.paths, curves, strict=True)
        return sum(int(np.sum(path.rows >= done)) for path, (*_, done) in pairs)

    @property
    def undetermined(self) -> list[str]:
        """Free parameters whose intervals are wider than UNDETERMINED to either side, the widest first."""
        half = dict(zip(self.problem.free, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))
        wide = [name for name, size in half.items() if self.quantile * size > np.log(UNDETERMINED)]
        return sorted(wide, key=lambda name: -half[name])

    @property
    def at_bounds(self) -> list[str]:
        """Free parameters that lie at a bound."""
        near = 1.0e-3
        return [
            name
            for name, x in zip(self.problem.free, self.x, strict=True)
            if min(abs(x - SCALES[name].to(bound)) for bound in self.problem.bounds[name]) < near
        ]


def residual_ratio(values: Mapping[str, float]) -> float:
    """|tau|/|sigma_N| of a fully damaged interface that slides up one facing plane; inf if it locks."""
    return float(material_of(values).residual_strength(values["theta"]))


def derived(values: Mapping[str, float]) -> dict[str, float]:
    """s_f, s0 (length) and K (stress/length), (12)."""
    material = material_of(values)
    return {"s_f": material.s_f, "s0": material.s_0, "K": material.K}


def fit(
    tests: Sequence[ShearTest],
    free: Sequence[str] | None = None,
    fixed: Mapping[str, float] | None = None,
    start: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    sides: int = SIDES,
    direction: float = 0.0,
    increments: int = INCREMENTS,
    starts: int = STARTS_TRIED,
    seed: int = 0,
    confidence: float = 0.95,
    tick: Tick = lambda _: None,
    model_error: float = 0.0,
    executor: Executor | None = None,
) -> Fit:
    """Least-squares parameters of measured tests.

    free, fixed: names and values of SCALES, theta in degrees.  Without `free` DEFAULT_FREE are free as far as
    they are not fixed; a parameter that neither of them has takes its value in DEFAULT_FIXED.  With ks in one
    of them the joint has no bond, and neither may have a parameter of BOND.
    start: additional start besides the best points of a Latin hypercube; `starts` is the number of all
    starts, `seed` that of the hypercube; if fewer than AGREEING of them reach the smallest sum of squares,
    up to MORE_STARTS times as many are tried.  bounds: (low, high) by name.  increments: smallest number
    along a test at first; they are refined until the parameters converge.  tick: called after each start
    and each refinement.  model_error: accepted scatter, as a fraction of the range, of a model that differs
    from the record by more than noise; the intervals are then wider.  executor: as in
    `parallel.map_in_order`; it takes the starts and the columns of derivatives, and the result is the same
    with any.  Raises ValueError for inadmissible names and values and for fewer data than the free
    parameters need.
    """
    from scipy.special import stdtrit

    for name, value, most in (("starts", starts, SAMPLES), ("increments", increments, MOST_INCREMENTS)):
        if not 1 <= value <= most:
            raise ValueError(f"{name} = {value}: expected 1 to {most}")
    if free is None:
        free = [name for name in needed(sides, fixed or {}) if name not in (fixed or {})]
    if not 0.0 <= model_error < 1.0:
        raise ValueError(f"model_error = {model_error:g}: expected a fraction of the range, 0 to 1")
    problem = _problem(tests, free, fixed or {}, bounds or {}, sides, direction, increments)
    for name, value in (start or {}).items():
        if name not in problem.free:
            raise ValueError(f"start: {name}: expected one of the free ones, {', '.join(problem.free)}")
        if not problem.bounds[name][0] <= value <= problem.bounds[name][1]:
            ends = "{:g} to {:g}".format(*problem.bounds[name])
            raise ValueError(
                f"start: {name} = {value:g}: expected {ends}, its bounds{DEGREES if name == 'theta' else ''}"
            )
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence = {confidence:g}: expected between 0 and 1")
    low, high = (
        np.array([SCALES[name].to(problem.bounds[name][i]) for name in problem.free]) for i in (0, 1)
    )
    points, evaluations = _starts(problem, start or {}, low, high, starts, seed, executor)
    tick("starts")
    solve = partial(_solve, low, high)
    ends: list[OptimizeResult] = []
    costs: tuple[float, ...] = ()
    for i, end in enumerate(_ends(problem, solve, points, starts, executor)):
        if i >= starts and costs[min(AGREEING, starts) - 1] <= SAME * costs[0]:
            break
        ends.append(end)
        evaluations += end.evaluations
        costs = tuple(sorted(2.0 * float(end.cost) for end in ends))
        tick(f"start {i + 1} of {starts}")
    best = min(ends, key=lambda end: float(end.cost))
    while True:
        parts = problem.refinement * REFINE
        known = _knowledge(problem, problem.jacobian(best.x, executor=executor), best.fun)
        problem, coarse = replace(problem, refinement=parts), problem
        shift = known.shift(problem.residuals(best.x) - best.fun)
        evaluations += 2 * best.x.size + 1
        tick(f"1/{parts} of the increments")
        longest = max(path.slips.size for path in problem.paths)
        if shift <= ENOUGH or parts > REFINE**REFINEMENTS or REFINE * longest > MOST_ROWS:
            problem = coarse
            break
        best = solve(problem, best.x, executor)
        evaluations += best.evaluations
    finer = problem.jacobian(best.x, FINER * STEP, executor)
    tick("intervals")
    found = Fit(
        problem=problem,
        values=problem.values(best.x),
        x=best.x,
        covariance=known.covariance,
        quantile=float(stdtrit(best.fun.size - best.x.size, 0.5 + 0.5 * confidence)),
        confidence=confidence,
        residuals=best.fun,
        scatter=known.scatter,
        neighbours=_neighbours(problem, best.fun),
        derivative_error=known.difference(finer),
        shift=shift,
        converged=best.status > 0,
        costs=costs,
        evaluations=evaluations + 2 * best.x.size,
        singular=known.singular,
        directions=known.directions,
        model_error=model_error,
    )
    if found.widened:
        found = replace(found, quantile=found.quantile * found.dependence_factor)
    return found


def _solve(
    low: Floats, high: Floats, problem: Problem, x: Floats, executor: Executor | None = None
) -> OptimizeResult:
    """Least squares from a start; the result has its number of evaluations of the model, too."""
    from scipy.optimize import least_squares

    found = least_squares(
        problem.residuals,
        x,
        lambda x: problem.jacobian(x, executor=executor),
        bounds=(low, high),
        x_scale=1.0,
        ftol=1e-8,
        xtol=1e-7,
        gtol=1e-8,
        max_nfev=MOST_EVALUATIONS,
    )
    found.evaluations = found.nfev + 2 * x.size * found.njev
    return found


def _ends(
    problem: Problem,
    solve: Callable[..., OptimizeResult],
    points: Sequence[Floats],
    starts: int,
    executor: Executor | None,
) -> Iterator[OptimizeResult]:
    """Ends of the searches from the points, in their order, as far as they are asked for.

    Without an executor the derivatives are distributed over threads; with one, `starts` searches at a time.
    """
    if executor is None:
        yield from (solve(problem, x) for x in points)
        return
    for i in range(0, len(points), starts):
        yield from map_in_order(partial(solve, problem), points[i : i + starts], executor)


def _problem(
    tests: Sequence[ShearTest],
    free: Sequence[str],
    fixed: Mapping[str, float],
    bounds: Mapping[str, tuple[float, float]],
    sides: int,
    direction: float,
    increments: int,
) -> Problem:
    """Names, values and bounds, checked."""
    if not tests:
        raise ValueError("no tests: expected at least one")
    for what, names in (("free", free), ("set", fixed), ("bounds", bounds)):
        unknown = [name for name in names if name not in SCALES]
        if unknown:
            raise ValueError(f"{what}: {unknown[0]}: expected one of {', '.join(SCALES)}")
    if not free or len(set(free)) < len(free):
        raise ValueError(f"free: {', '.join(free) or 'none'}: expected names, each once")
    both = [name for name in free if name in fixed]
    if both:
        raise ValueError(f"{both[0]}: expected it free or set, not both")
    bound = [name for name in bounds if name not in free]
    if bound:
        raise ValueError(f"bounds: {bound[0]}: expected one of the free ones, {', '.join(free)}")
    if not np.isfinite(direction):
        raise ValueError(f"direction = {direction:g}: expected a finite angle in degrees")
    unbonded = KS in free or KS in fixed
    of_bond = [name for name in BOND if unbonded and (name in free or name in fixed)]
    if of_bond:
        raise ValueError(f"{', '.join(of_bond)}: expected without ks, which is that of a joint without bond")
    known = DEFAULT_FIXED | ({"theta": 0.0} if sides == 0 else {}) | dict(fixed)
    needed = [name for name in SCALES if name not in (BOND if unbonded else (KS,))]
    known = {name: value for name, value in known.items() if name in needed}
    missing = [name for name in needed if name not in free and name not in known]
    if missing:
        raise ValueError(f"{missing[0]}: expected it among the free ones, or a value set")
    inclined = [name for name in ("theta", "flat", "height", "W0") if name in free]
    if sides == 0 and inclined:
        raise ValueError(
            f"free: {', '.join(inclined)}: expected inclined planes, which sides = 0 does not have"
        )
    if 0.0 < known.get("theta", 0.0) < BOUNDS["theta"][0]:
        raise ValueError(
            f"set: theta = {known['theta']:g}: expected degrees, 0 or at least {BOUNDS['theta'][0]:g} "
            f"(a radian is {np.degrees(1.0):.1f})"
        )
    largest = max(float(np.abs(test.tau).max()) for test in tests)
    length = max(float(np.abs(test.slip).max()) for test in tests)
    within = dict(BOUNDS) | {
        "sigma0": (1e-3 * largest, 30.0 * largest),
        "Gc": (1e-6 * largest * length, 150.0 * largest * length),
        "height": (1e-3 * length, 1e3 * length),
        "W0": (1e-3 * largest * length, 1e3 * largest * length),
        "closure": (1e-5 * length, 1e2 * length),
        KS: (1e-2 * largest / length, 1e5 * largest / length),
    }
    within |= {"sigma02": within["sigma0"], "Gc2": within["Gc"]}
    for name, (low, high) in bounds.items():
        if not 0.0 < low < high < SCALES[name].top:
            raise ValueError(
                f"bounds: {name} = {low:g}, {high:g}: expected 0 < low < high < {SCALES[name].top:g}"
            )
        within[name] = (low, high)
    problem = Problem(
        list(tests),
        tuple(free),
        {name: contract.number(name, value) for name, value in known.items() if name not in free},
        {name: within[name] for name in free},
        sides,
        contract.number("direction", direction),
        increments,
    )
    middle = {name: float(np.sqrt(within[name][0] * within[name][1])) for name in free}
    problem.interface(dict(problem.fixed) | middle)
    _check_lengths(problem, length)
    count = problem.is_dilation.size
    if count <= 2 * len(free):
        raise ValueError(
            f"{count} values in {len(tests)} tests: expected more than {2 * len(free)}, twice "
            f"the {len(free)} free parameters"
        )
    return problem


def _check_lengths(problem: Problem, length: float) -> None:
    """Raise ValueError where the slips cannot have the unit of 2 Gc/sigma0, if that is known."""
    if KS in problem.free or KS in problem.fixed:
        return
    ends = [
        [problem.fixed[name]] * 2 if name in problem.fixed else problem.bounds[name]
        for name in ("Gc", "sigma0")
    ]
    shortest, longest = 2.0 * ends[0][0] / ends[1][1], 2.0 * ends[0][1] / ends[1][0]
    if not shortest / LARGEST_RATIO <= length <= LARGEST_RATIO * longest:
        raise ValueError(
            f"column slip: up to {length:g} where s_f = 2 Gc/sigma0 is {shortest:g} to {longest:g}: expected "
            f"the unit of Gc/sigma0 (a ratio from {1.0 / LARGEST_RATIO:g} to {LARGEST_RATIO:g})"
        )


def _starts(
    problem: Problem,
    start: Mapping[str, float],
    low: Floats,
    high: Floats,
    count: int,
    seed: int,
    executor: Executor | None,
) -> tuple[list[Floats], int]:
    """Starts (the given one, if any, and the best points of a Latin hypercube), and number of evaluations."""
    margin = 1e-6 * (high - low)
    ranked, points = [], []
    if set(start) != set(problem.free) or count > 1:
        points = [np.clip(x, low + margin, high - margin) for x in _hypercube(problem, seed)]
        costs = [float(r @ r) for r in map_in_order(problem.residuals, points, executor)]
        ranked = [points[i] for i in np.argsort(costs)]
    if start:
        given = (problem.values(ranked[0]) if ranked else {}) | dict(start)
        x = np.array([SCALES[name].to(given[name]) for name in problem.free])
        ranked.insert(0, np.clip(x, low + margin, high - margin))
    return ranked[: MORE_STARTS * count if count > 1 else 1], len(points)


def _hypercube(problem: Problem, seed: int) -> list[Floats]:
    """Transformed parameters of SAMPLES points; s_f replaces Gc because the tests show the size of s_f."""
    largest = max(float(np.abs(test.tau).max()) for test in problem.tests)
    length = max(float(np.abs(test.slip).max()) for test in problem.tests)
    ranges = dict(STARTS) | {
        "sigma0": (0.05 * largest, 2.0 * largest),
        "s_f": (0.02 * length, 1.5 * length),
        "height": (0.03 * length, 3.0 * length),
        "W0": (0.05 * largest * length, 5.0 * largest * length),
        "closure": (1e-3 * length, 0.3 * length),
        KS: (largest / length, 1e3 * largest / length),
    }
    ranges |= {"sigma02": ranges["sigma0"], "Gc2": (0.01 * largest * length, 1.5 * largest * length)}
    rng = np.random.default_rng(seed)
    strata = rng.permuted(np.tile(np.arange(SAMPLES), (len(problem.free), 1)), axis=1).T
    points = []
    for row in (strata + rng.random(strata.shape)) / SAMPLES:
        values = dict(problem.fixed)
        for name, share in zip(problem.free, row, strict=True):
            a, b = ranges["s_f" if name == "Gc" else name]
            values[name] = float(a * (b / a) ** share)
        if "Gc" in problem.free:
            values["Gc"] *= 0.5 * values["sigma0"]
        points.append(np.array([SCALES[name].to(values[name]) for name in problem.free]))
    return points


@dataclass(frozen=True, eq=False)
class _Knowledge:
    """Linear statistics of the parameters.

    jacobian (n, p) and its inverse (p, n), covariance (p, p), scatter of tau and of s_N, singular values (p,)
    and their directions (p, p), in rows.
    """

    jacobian: Floats
    inverse: Floats
    covariance: Floats
    scatter: tuple[float, float]
    singular: Floats
    directions: Floats

    def shift(self, change: Floats) -> float:
        """Largest change of a parameter, in standard errors, due to a change of the residuals (n,)."""
        errors = np.maximum(np.sqrt(np.diag(self.covariance)), LEAST_ERROR)
        return float(np.max(np.abs(self.inverse @ change) / errors))

    def difference(self, other: Floats) -> float:
        """Largest relative difference between the columns of two Jacobians."""
        sizes = np.maximum(np.linalg.norm(self.jacobian, axis=0), np.finfo(float).tiny)
        return float(np.max(np.linalg.norm(self.jacobian - other, axis=0) / sizes))


def _knowledge(problem: Problem, jacobian: Floats, residuals: Floats) -> _Knowledge:
    """(J^T J)^-1 with the scatter of tau and of s_N, each taken from its own residuals."""
    parameters = jacobian.shape[1]
    _, singular, directions = np.linalg.svd(jacobian, full_matrices=False)
    freedom = residuals.size - parameters
    # the degrees of freedom of the parameters are divided among the quantities by their number of rows
    shares = [np.flatnonzero(problem.is_dilation == which) for which in (False, True)]
    variances = np.zeros(residuals.size)
    scatter = []
    for rows in shares:
        left = rows.size * freedom / residuals.size
        scatter.append(float(np.sqrt(residuals[rows] @ residuals[rows] / left)) if rows.size else np.nan)
        variances[rows] = scatter[-1] ** 2 if rows.size else 0.0
    inverse = np.linalg.pinv(jacobian, rcond=RANK)
    covariance = (inverse * variances) @ inverse.T
    # directions without influence on the residuals have an infinite variance
    dark = directions[singular <= RANK * singular[0]]
    covariance = covariance + dark.T @ dark / RANK
    return _Knowledge(jacobian, inverse, covariance, (scatter[0], scatter[1]), singular, directions)


def _neighbours(problem: Problem, residuals: Floats) -> float:
    """Correlation of the residuals of neighbouring rows."""
    parts = [residuals[place] for _, _, place in problem.parts]
    first, second = (np.concatenate([part[rows] for part in parts]) for rows in (slice(-1), slice(1, None)))
    size = float(residuals @ residuals)
    return float(first @ second) / size if size > 0.0 else 0.0
