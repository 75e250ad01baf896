"""The search: ladder of models and shapes, simplest first, starts, least squares, and the choice of one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...contract import Floats
from .model import KS, KT, MORTAR, ROCK, Model, Problem, Started, rows_of, to_scale
from .rigid import CONTRACTING, SHAPES, SLOPES, SOFTENINGS, WITHOUT
from .shear_test import (
    ShearTest,
    cycles,
    first_slope,
    first_stroke,
    independent_rows,
    last_slope,
    pressures,
    smooth,
)
from .thresholds import (
    APART,
    AROUND,
    FEW_TRIALS,
    FITTED,
    GAIN,
    MOST_TRIALS,
    MOVED,
    NOISE,
    PENALTY,
    REACH,
    REACH_OF_OTHERS,
    ROWS_EACH,
    ROWS_OF_NOISE,
    SEARCHED,
    STEP,
)

Function = Callable[[Floats], Floats]
"""Residuals of a point."""


def check_known(known: Mapping[str, float]) -> None:
    """Check values of constants that are known from elsewhere, by name.  Raises ValueError."""
    for name, value in known.items():
        if not 0.0 <= value < np.inf:
            raise ValueError(f"{name} = {value:g}: expected a finite value >= 0")
    theta, eta = known.get("theta", 0.0), known.get("eta", 0.9)
    if 0.0 < theta < 0.1:
        raise ValueError(f"theta = {theta:g}: expected degrees, 0 or at least 0.1 (a radian is 57.3)")
    if theta >= 90.0:
        raise ValueError(f"theta = {theta:g}: expected 0 <= theta < 90")
    if eta >= 1.0:
        raise ValueError(f"eta = {eta:g}: expected below 1")


def ladder(tests: Sequence[ShearTest], joint: str, known: Mapping[str, float], sides: int) -> list[Model]:
    """Models that the tests may show, simplest first; known: values that the user has given.

    Rock: friction, a slope, its height, crushed asperities at several pressures, wear in cycles.  Mortar: the
    same with a bond.  An elastic spring lies in series with the joint; in cycles a bond is itself elastic.
    """
    dilates = any(test.s_N is not None and np.ptp(test.s_N) > 0.0 for test in tests)
    levels = sorted({round(-test.pressed, 9) for test in tests})
    # a box with a stiffness raises the pressure that crushes
    reached = sorted(float(np.max(pressures(test))) for test in tests)
    several, reversed_ = len(levels) > 1 and reached[-1] > APART * reached[0], cycles(tests)
    # one curve of the strength does not show a slope beside the friction, unless it climbs and descends
    shown = sides > 0 and (dilates or len(levels) > 1)
    slope = ("theta", "height") if shown else ("theta",) if reversed_ and sides else ()
    slopes: list[tuple[str, ...]] = [(), *(slope[: i + 1] for i in range(len(slope)))]
    crushed = [("theta", "height", "crush")] if several and sides else []
    worn = [("theta", "W0"), ("theta", "height", "W0")][: 1 + dilates] if reversed_ and sides else []
    bonded = slopes if dilates else slopes[:1]
    constants = []
    if joint != MORTAR:
        constants += [(KT, "mu", *more) for more in slopes + crushed + worn]
    if joint != ROCK:
        constants += [(*(() if reversed_ else (KT,)), "sigma0", "Gc", "mu", *more) for more in bonded]
    if not reached[-1] > 0.0:
        # without a pressure a bond alone carries
        constants = [free for free in constants if "sigma0" in free]
    rows = sum(test.slip.size * (1 + (test.s_N is not None)) for test in tests)
    models: list[Model] = []
    for free in constants:
        fixed = dict(known)
        # a stiffness of the joint that the user gives stands in place of a spring in series
        kept = tuple(name for name in free if name not in known and not (name == KT and KS in known))
        inclined = "theta" in {*free, *known}
        left_out = not inclined and any(known.get(name) for name in ("height", "crush", "W0"))
        if not left_out and ROWS_EACH * len(kept) <= rows and not any(model.free == kept for model in models):
            models.append(Model(kept, sides, fixed))
    return models


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
        return np.full(problem.rows.row.size, PENALTY)
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


def independent(solution: Solution) -> dict[str, float]:
    """Number of independent data of tau and of the dilation."""
    counts = {"tau": 0.0, "dilation": 0.0}
    rows = solution.problem.rows
    for number in range(len(solution.problem.tests)):
        for name in counts:
            of_column = solution.residuals[(rows.test == number) & (rows.name == name)]
            counts[name] += independent_rows(of_column) if of_column.size else 0.0
    return counts


def is_noise(solution: Solution) -> bool:
    """Whether the residuals are noise, so that a larger model has nothing to explain."""
    least = min(test.slip.size for test in solution.problem.tests)
    return least > ROWS_OF_NOISE and sum(independent(solution).values()) > NOISE * solution.residuals.size


def criteria(solutions: Sequence[Solution]) -> list[float]:
    """Information criterion (BIC) of each model, with the independent data of the one that fits best."""
    squares = [solution.mean_squares for solution in solutions]
    floor = 1e-12
    sums = [sum(np.log(max(value, floor)) for value in square.values()) for square in squares]
    best = int(np.argmin(sums))
    counts = independent(solutions[best])
    total = np.log(max(sum(counts.values()), 2.0))
    return [
        float(sum(counts[name] * np.log(max(value, floor) / max(squares[best][name], floor))
                  for name, value in square.items() if name in squares[best]) + solution.x.size * total)
        for solution, square in zip(solutions, squares, strict=True)
    ]  # fmt: skip


def choose(solutions: Sequence[Solution]) -> tuple[int, list[float]]:
    """The smallest model that no larger one beats by GAIN for each constant it adds; and the criteria."""
    bic = criteria(solutions)
    best = int(np.argmin(bic))
    order = sorted(range(len(solutions)), key=lambda i: (solutions[i].x.size, bic[i]))
    fewer = (
        i for i in order if bic[i] <= bic[best] + GAIN * max(0, solutions[best].x.size - solutions[i].x.size)
    )
    return next(fewer, best), bic


def rigid_form(chosen: Solution, tests: Sequence[ShearTest], left_out: Sequence[str] = ()) -> Solution | None:
    """The same model with rigid sides behind a spring, which has a closed form; None without one.

    left_out: constants that the tests do not need, as wear in a first stroke.
    """
    if chosen.problem.is_closed_form:
        return chosen
    free = tuple(name for name in chosen.model.free if name not in left_out)
    model = replace(chosen.model, free=free)
    if KS in model.free:
        model = model.instead(KS, KT)
    elif KS in model.fixed and not model.series:
        fixed = {name: value for name, value in model.fixed.items() if name not in (KS, "kc")}
        model = replace(model, fixed=fixed | {KT: 0.5 * chosen.values[KS]})
    problem = model.problem(tests, chosen.problem.weight, chosen.problem.direction)
    return refitted(chosen, tests, model, tolerance=SEARCHED) if problem.is_closed_form else None


def with_shape(form: Solution, shape: str) -> Solution:
    """Fit of a closed form with another shape."""
    model = replace(form.model, shape=shape)
    return refitted(form, form.problem.tests, model, tolerance=SEARCHED) if shape else form


def with_starts(form: Solution) -> Solution:
    """Fit of a closed form from the starts of the gauges that fit best."""
    problem, shape = form.problem, form.model.shape
    rest = (problem.free, problem.fixed, problem.sides, problem.direction, problem.increments)
    other = Started(problem.tests, *rest, problem.weight, shape)
    return Solution(form.model, other, *solve(other, form.x, SEARCHED))


def in_place_of_bond(solutions: Sequence[Solution], index: int, bic: Sequence[float]) -> int:
    """Place of the joint without bond whose asperities, of another shape, explain tests better than a bond.

    A profile that the law does not have must not make a bond.
    """
    chosen = solutions[index]
    sloped = [
        i
        for i, solution in enumerate(solutions)
        if not solution.model.bond and {"theta", "height"} <= {*solution.model.free}
    ]
    if not (chosen.model.bond and sloped and not cycles(chosen.problem.tests)):
        return index
    rock = min(sloped, key=lambda i: bic[i])
    form = rigid_form(solutions[rock], chosen.problem.tests)
    if form is None:
        return index
    others = [with_shape(form, name) for name in slopes_of(chosen.problem.tests)]
    # a dilation that the bond does not meet is no reason for a joint that meets the strength less well
    as_strong = [other.mean_squares["tau"] < chosen.mean_squares["tau"] for other in others]
    own, *values = criteria([chosen, *others])
    better = (value < own - GAIN for value, strong in zip(values, as_strong, strict=True) if strong)
    return rock if any(better) else index


def shaped(
    chosen: Solution, tests: Sequence[ShearTest], known: Mapping[str, float], of_user: bool = False
) -> list[Solution]:
    """Closed form of the law, and with the shapes that it does not have, of tests without reversals.

    known: values of the user, which stay.  of_user: the model is that of the user, which has no other shape.
    Empty where there is no such form.
    """
    free, bond = {*chosen.model.free}, chosen.model.bond
    if cycles(tests) or not (bond or free & {"theta", "height"}):
        return []
    form = at_once(chosen, tests, known) if bond else rigid_form(chosen, tests)
    names = slopes_of(tests) if not bond and ends(chosen.model) else ()
    if bond:
        apart = [name for name in SHAPES if name.startswith(WITHOUT) and "theta" in free]
        names = (*SOFTENINGS, *apart)
    return [form, *(with_shape(form, name) for name in names if not of_user)] if form else []


def ends(model: Model) -> bool:
    """Whether the slope of a model ends, at a height that is fitted or known."""
    return "height" in model.free or model.fixed.get("height", 0.0) > 0.0


def slopes_of(tests: Sequence[ShearTest]) -> tuple[str, ...]:
    """Slopes that tests may show; strengths alone show no contraction."""
    opens = any(test.s_N is not None for test in tests)
    return SLOPES if opens else tuple(name for name in SLOPES if name != CONTRACTING)


def at_once(chosen: Solution, tests: Sequence[ShearTest], known: Mapping[str, float]) -> Solution | None:
    """Closed form of a bond, beside which friction acts at once, with a spring in series; None without one.

    Where few rows rise to the peak, they show neither the spring nor the damage for which friction waits.
    """
    model, values = chosen.model, chosen.values
    if chosen.problem.is_closed_form and (KT in model.free or KT in known):
        return chosen
    free = tuple(name for name in model.free if name not in ("eta", KT))
    fixed = {name: value for name, value in model.fixed.items() if name not in ("eta", KT) or name in known}
    if KT not in known:
        free = (KT, *free)
    # an eta below 1 that is known has no closed form
    rigid = Model(free, model.sides, fixed)
    problem = rigid.problem(tests, chosen.problem.weight, chosen.problem.direction)
    if KT not in model.free:
        values = values | {KT: guesses(tests)[KT]}
    if not problem.is_closed_form:
        return None
    return Solution(rigid, problem, *solve(problem, problem.x(values), SEARCHED))
