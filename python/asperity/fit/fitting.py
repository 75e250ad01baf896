"""Parameters of the law from shear-box tests: least squares on the forward model."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..contract import Floats
from ..parallel import map_in_order
from ..steps import thinned
from .model import INCREMENTS, SCALES, SIDES, Problem
from .outcome import ENOUGH, REFINE, SAME, Fit
from .ranges import SAMPLES, checked_problem, hypercube, needed
from .shear_test import ShearTest

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

STARTS_TRIED = 5
"""Number of starts. About one in four ends in the local minimum of a curve that never softens (small s_f)."""

AGREEING, MORE_STARTS = 3, 3
"""Where fewer starts reach the smallest sum of squares, up to MORE_STARTS times as many starts are tried."""

FOUND = 1.0e-8
"""Relative change of the sum of squares at which the least squares end."""

SEARCHED, MOST_SEARCHED = 1.0e-4, 250
"""The same for a start, and the most rows of a test that it uses."""

MOST_STEPS = 4
"""Largest number of Gauss-Newton steps of a finer model with the derivatives of the coarser one."""

REFINEMENTS = 3
"""Largest number of refinements, which divide an increment by at most 64."""

MOST_INCREMENTS = 10000
"""Largest number of increments that can be requested along a test."""

MOST_ROWS = 400000
"""Largest number of increments of a test in the finest model: 150 MB of state for nine planes."""

MOST_EVALUATIONS = 60
"""Largest number of residual evaluations of one least-squares solution, without those for derivatives."""

Tick = Callable[[str], object]
"""Function that is called with the name of every part of a fit when it is done."""


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

    Parameters
    ----------
    tests
        As `read_tests` returns them from files, or made of arrays.
    free, fixed
        Names, and values by name; theta in degrees. Without `free` every parameter of a bonded joint is free
        that is not fixed. Others have their default. With ks in one of them the joint has no bond.
    start, bounds
        An additional start, and (low, high), by name.
    sides, direction
        Inclined planes of the pattern, and the direction of the slip, degrees.
    increments
        Smallest number along a test at first; they are refined until the parameters converge.
    starts, seed
        Number of starts, and seed of their Latin hypercube.
    confidence
        Of the intervals.
    tick
        Called after each start and each refinement.
    model_error
        Accepted scatter, as a fraction of the range, of a model that differs from the tests by more than
        noise; the intervals are then wider.
    executor
        As in `parallel.map_in_order`; the result is the same with any.

    Returns
    -------
    Fit
        `estimates` (value, low, high by name), `interface`, and measures of the quality. Whether it is a
        result: `asperity.fit.verdict.refusals(found)` is then empty.

    Raises
    ------
    ValueError
        For inadmissible names and values and for fewer data than the free parameters need.

    Examples
    --------
    >>> import numpy as np
    >>> from asperity import Interface, Material, Pattern
    >>> from asperity.fit import ShearTest, fit
    >>> joint = Interface(Material(1.5, 0.15, 0.9, 0.5, kc=20.0), Pattern.regular(2, 20.0))
    >>> box = joint.confined_slip(0.0, np.linspace(0.0, 0.6, 31), sigma_N=-1.0)
    >>> test = ShearTest("box", box.slip_along()[1:], box.tau[1:], (box.dilation - box.dilation[0])[1:], -1.0)
    >>> known = {"sigma0": 1.5, "Gc": 0.15, "eta": 0.9, "kc": 20.0, "flat": 1 / 3}
    >>> found = fit([test], free=["mu", "theta"], fixed=known, sides=2, starts=2)
    >>> {name: round(one.value, 3) for name, one in found.estimates.items()}
    {'mu': 0.5, 'theta': 20.0}
    """
    for name, value, most in (("starts", starts, SAMPLES), ("increments", increments, MOST_INCREMENTS)):
        if not 1 <= value <= most:
            raise ValueError(f"{name} = {value}: expected 1 to {most}")
    if free is None:
        free = [name for name in needed(sides, fixed or {}) if name not in (fixed or {})]
    if not 0.0 <= model_error < 1.0:
        raise ValueError(f"model_error = {model_error:g}: expected a fraction of the range, 0 to 1")
    problem = checked_problem(tests, free, fixed or {}, bounds or {}, sides, direction, increments)
    for name, value in (start or {}).items():
        if name not in problem.free:
            raise ValueError(f"start: {name}: expected one of the free ones, {', '.join(problem.free)}")
        if not problem.bounds[name][0] <= value <= problem.bounds[name][1]:
            ends = "{:g} to {:g}".format(*problem.bounds[name])
            unit = " in degrees" if name == "theta" else ""
            raise ValueError(f"start: {name} = {value:g}: expected {ends}, its bounds{unit}")
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence = {confidence:g}: expected between 0 and 1")
    low, high = (
        np.array([SCALES[name].to(problem.bounds[name][i]) for name in problem.free]) for i in (0, 1)
    )
    few = replace(problem, tests=[_with_fewer_rows(test) for test in problem.tests])
    points = _starts(few, start or {}, low, high, starts, seed, executor)
    tick("starts")
    solve = partial(_solve, low, high)
    solutions: list[OptimizeResult] = []
    costs: tuple[float, ...] = ()
    for i, one in enumerate(_solutions(few, solve, points, starts, executor)):
        if i >= starts and costs[min(AGREEING, starts) - 1] <= SAME * costs[0]:
            break
        solutions.append(one)
        costs = tuple(sorted(2.0 * float(one.cost) for one in solutions))
        tick(f"start {i + 1} of {starts}")
    best = solve(problem, min(solutions, key=lambda one: float(one.cost)).x, executor)
    x, residuals = best.x, best.fun
    while True:
        jacobian = problem.jacobian(x, executor=executor)
        found = Fit(problem, x, residuals, jacobian, confidence, model_error, best.status > 0, costs)
        parts = problem.refinement * REFINE
        problem = replace(problem, refinement=parts)
        fine = problem.residuals(x)
        shift = found.shift_by(fine - residuals)
        tick(f"1/{parts} of the increments")
        longest = max(path.slips.size for path in problem.paths)
        if shift <= ENOUGH or parts > REFINE**REFINEMENTS or REFINE * longest > MOST_ROWS:
            break
        residuals = fine
        for _ in range(MOST_STEPS):
            step = np.clip(x - found.inverse @ residuals, low, high)
            fine = problem.residuals(step)
            if not fine @ fine < residuals @ residuals:
                break
            x, residuals = step, fine
    return replace(found, shift=shift)


def _with_fewer_rows(test: ShearTest) -> ShearTest:
    """Test with the rows from which the starts search."""
    if test.slip.size <= MOST_SEARCHED:
        return test
    rows = thinned(test.slip, MOST_SEARCHED)
    columns = {name: getattr(test, name) for name in ("slip", "tau", "s_N", "path_N")}
    return replace(
        test, **{name: one if one is None else one[rows] for name, one in columns.items()}, lines=()
    )


def _solve(
    low: Floats,
    high: Floats,
    problem: Problem,
    x: Floats,
    executor: Executor | None = None,
    searching: bool = False,
) -> OptimizeResult:
    """Least squares from a start; searching: with forward differences, to the accuracy of a search."""
    from scipy.optimize import least_squares

    last: list[Floats] = []

    def residuals(x: Floats) -> Floats:
        last[:] = x, problem.residuals(x)
        return last[1]

    def jacobian(x: Floats) -> Floats:
        return problem.jacobian(x, executor, last[1] if searching and np.array_equal(x, last[0]) else None)

    tolerance = SEARCHED if searching else FOUND
    return least_squares(
        residuals,
        x,
        jacobian,
        bounds=(low, high),
        x_scale=1.0,
        ftol=tolerance,
        xtol=10.0 * tolerance,
        gtol=tolerance,
        max_nfev=MOST_EVALUATIONS,
    )


def _solutions(
    problem: Problem,
    solve: Callable[..., OptimizeResult],
    points: Sequence[Floats],
    starts: int,
    executor: Executor | None,
) -> Iterator[OptimizeResult]:
    """Solutions from the points, in their order, as far as they are asked for.

    Without an executor the derivatives are distributed over threads; with one, `starts` searches at a time.
    """
    if executor is None:
        yield from (solve(problem, x, searching=True) for x in points)
        return
    for i in range(0, len(points), starts):
        yield from map_in_order(partial(solve, problem, searching=True), points[i : i + starts], executor)


def _starts(
    problem: Problem,
    start: Mapping[str, float],
    low: Floats,
    high: Floats,
    count: int,
    seed: int,
    executor: Executor | None,
) -> list[Floats]:
    """Starts: the given one, if any, and the best points of a Latin hypercube."""
    margin = 1e-6 * (high - low)
    ranked = []
    if set(start) != set(problem.free) or count > 1:
        points = [np.clip(x, low + margin, high - margin) for x in hypercube(problem, seed)]
        costs = [float(r @ r) for r in map_in_order(problem.residuals, points, executor)]
        ranked = [points[i] for i in np.argsort(costs)]
    if start:
        given = (problem.values(ranked[0]) if ranked else {}) | dict(start)
        x = np.array([SCALES[name].to(given[name]) for name in problem.free])
        ranked.insert(0, np.clip(x, low + margin, high - margin))
    return ranked[: MORE_STARTS * count if count > 1 else 1]
