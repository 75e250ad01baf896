"""What tests do not exclude: intervals by groups of residuals, other assumptions, joints without a bond."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...contract import Floats
from .model import KT, PLAUSIBLE, SPRINGS, Curve, Problem, from_scale, plausible, rows_of, to_scale
from .rigid import SHAPES
from .search import (
    Solution,
    criteria,
    ends,
    independent,
    refitted,
    residuals,
    rigid_form,
    slopes_of,
    solve,
    with_shape,
    with_starts,
)
from .shear_test import ShearTest, cycles, first_slope, first_stroke
from .thresholds import (
    BY_NOISE,
    CONFIDENCE,
    GAIN,
    GOOD,
    KNOWN_TESTS,
    NORMAL,
    PARTS,
    RIDGE,
    ROOT,
    SCATTER,
    SCATTER_OF_OTHERS,
    SEARCHED,
)

STARTS, SHAPE_OF_LAW, AT_ONCE = "gauge offsets", "shape of the law", "friction at once behind a spring"
UNCRUSHED, ENDED_HERE = "the slope that the tests show", "a dilation that ends with the rows"
"""Names of starts of slip and dilation that fit best, of the law beside another shape, of a bond in closed
form, whose friction does not wait for the damage, of a slope that the pressure does not crush, and of a
height that the rows reach.
"""


class Estimate(NamedTuple):
    """Value and ends of its interval."""

    value: float
    low: float
    high: float

    @property
    def half(self) -> float:
        """Larger one of the relative distances of the ends."""
        return max(self.high - self.value, self.value - self.low) / max(abs(self.value), 1e-300)


@dataclass(frozen=True, eq=False)
class Assumption:
    """What stands in place of an assumption: its information criterion over that of the fit, and its
    constants.

    admissible: whether the tests allow it, so that it is part of the intervals; parts: constants to which it
    applies, all of them without a list.  halves: half widths of their intervals on their scales, those of the
    fit without them.  of_tests: whether these contain the differences of the tests.
    """

    name: str
    difference: float
    values: Mapping[str, float]
    admissible: bool
    parts: tuple[str, ...] = ()
    halves: Mapping[str, float] = field(default_factory=dict)
    of_tests: bool = False


def quantiles(freedom: ArrayLike) -> Floats:
    """Of Student's t with these degrees of freedom, of both ends of an interval."""
    from scipy.special import stdtrit  # scipy.stats takes longer to import than many a fit

    return np.asarray(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE))


@dataclass(frozen=True, eq=False)
class Spread:
    """Covariance (p, p) of the constants on their scales, and its degrees of freedom.

    of_tests: whether it is that of whole tests, which may be different specimens.
    """

    covariance: Floats
    freedom: float
    of_tests: bool = False

    def __post_init__(self) -> None:
        """Raises ValueError for a covariance that is not finite, which would widen no interval."""
        if not np.isfinite(self.covariance).all():
            raise ValueError(f"covariance {self.covariance.tolist()}: expected finite numbers")

    @property
    def quantile(self) -> float:
        """Of Student's t, infinite without a degree of freedom."""
        return float(quantiles(self.freedom)) if self.freedom > 0.0 else np.inf


def spreads(solution: Solution, left_out: Sequence[Solution] = ()) -> list[Spread]:
    """Covariances by kind of group: parts of the way of all tests together, of each test, and whole tests.

    And that of independent rows: a few groups may agree by chance.  left_out: fits without each of the tests,
    of which each pressure may have another specimen.
    """
    if not solution.x.size:
        return []
    slopes, results = solution.slopes, []
    for groups in _groups(solution, slopes):
        covariance, count = delete_one(slopes, solution.residuals, groups)
        results.append(Spread(covariance, count - solution.x.size))
    if len(left_out) > 1:
        results.append(of_left_out(solution, left_out))
    freedom = solution.residuals.size - solution.x.size
    if freedom >= 1:
        scale = float(solution.residuals @ solution.residuals) / freedom
        results.append(Spread(scale * _inverse(slopes), freedom))
    return results


def of_left_out(solution: Solution, without: Sequence[Solution]) -> Spread:
    """Covariance of the mean of specimens, by fits without each test and what is known of other specimens.

    Few tests may agree by chance.  The variance between them is therefore that of a scaled inverse chi-square
    distribution: of the tests, and of KNOWN_TESTS further ones that scatter as specimens of a joint do.
    """
    names, count = solution.model.free, len(without)
    moved = np.array([solution.problem.x(fit.values) for fit in without]) - solution.x
    usual = np.zeros(len(names))
    for i, name in enumerate(names):
        if name not in (*SPRINGS, "eta"):
            slope = float(to_scale(name, 1.01 * solution.values[name]) - solution.x[i]) / 0.01
            usual[i] = (SCATTER.get(name, SCATTER_OF_OTHERS) * slope) ** 2 / count
    of_tests = (count - 1) / count * moved.T @ moved
    freedom = count - 1 + KNOWN_TESTS
    return Spread(((count - 1) * of_tests + KNOWN_TESTS * np.diag(usual)) / freedom, freedom, True)


def _inverse(slopes: Floats) -> Floats:
    """Inverse of the information of rows with these derivatives."""
    return np.asarray(np.linalg.pinv(slopes.T @ slopes, rcond=1e-12), dtype=float)


def _groups(solution: Solution, slopes: Floats) -> Iterator[np.ndarray]:
    """Group of each residual.

    The parts say the same about the constants: with equal rows a fifth has all of the softening.
    """
    rows, tests = solution.problem.rows, solution.problem.tests
    column = solution.problem.is_dilation.astype(int)
    test, part = rows.test, np.zeros(rows.test.size, dtype=int)
    share = np.sum(np.linalg.qr(slopes)[0] ** 2, axis=1)
    slips = [np.append(0.0, test.slip) for test in tests]
    ways = [np.cumsum(np.abs(np.diff(slip))) for slip in slips]
    way = np.array([ways[t][r] / ways[t][-1] for t, r in zip(test, rows.row, strict=True)])
    for kind in {*column.tolist()}:
        members = np.flatnonzero(column == kind)
        members = members[np.argsort(way[members], kind="stable")]
        total = np.cumsum(share[members] + 1e-9)
        place = (total - 0.5 * share[members]) / total[-1] * PARTS
        part[members] = np.clip(place, 0, PARTS - 1).astype(int)
    each = part + PARTS * column
    yield each
    yield each + 2 * PARTS * test


def delete_one(slopes: Floats, residuals: Floats, groups: np.ndarray) -> tuple[Floats, int]:
    """Covariance of the linear problem without one group after the other (CR3), and the number of groups."""
    labels, moves = np.unique(groups), []
    information = slopes.T @ slopes
    ridge = RIDGE * np.diag(np.diag(information))
    for label in labels:
        members = groups == label
        rest = information - slopes[members].T @ slopes[members] + ridge
        moves.append(np.linalg.lstsq(rest, slopes[members].T @ residuals[members], rcond=1e-12)[0])
    moved = np.array(moves)
    return (len(labels) - 1) / len(labels) * (moved.T @ moved), len(labels)


@dataclass(frozen=True, eq=False)
class Intervals:
    """Intervals of constants and of any function of them: groups of residuals, then other assumptions."""

    solution: Solution
    spreads: list[Spread]
    assumptions: list[Assumption]

    def of(self, name: str, function: Callable[[Mapping[str, float]], float] | None = None) -> Estimate:
        """Value and interval of a constant, or of a function on the scale of a constant or "" (logarithm)."""
        problem, x = self.solution.problem, self.solution.x

        def place(values: Mapping[str, float]) -> float:
            return float(to_scale(name, function(values) if function else values[name]))

        here, steps = place(problem.values(x)), 1e-4 * np.eye(x.size)
        pairs = ((place(problem.values(x + h)), place(problem.values(x - h))) for h in steps)
        slope = np.array([(above - below) / 2e-4 for above, below in pairs])
        of_rows, of_tests = self._halves(slope)
        half = max(of_rows, of_tests)

        def half_of(assumption: Assumption) -> float:
            """Half of the interval of an assumption; the tests differ by as much as beside the law."""
            own = float(assumption.halves.get(name, half))
            return own if assumption.of_tests else max(of_tests, own)

        low, high = -half, half
        for assumption in self.assumptions:
            applies = (
                name in assumption.parts
                if assumption.parts
                else function is not None or name in assumption.values
            )
            if (
                assumption.admissible
                and applies
                and (function is not None or assumption.values.get(name, 0.0) > 0.0)
            ):
                shift = place(assumption.values) - here
                own = half_of(assumption)
                low, high = min(low, shift - own), max(high, shift + own)
        ends = [here, here + low, here + high]
        value, *bounds = (float(value) for value in from_scale(name, ends))
        if function is None and name in PLAUSIBLE:
            bounds = list(np.clip(bounds, *plausible(name, *problem.size)))
        return Estimate(value, min(bounds[0], value), max(bounds[1], value))

    def _halves(self, slope: Floats) -> tuple[float, float]:
        """Half widths of a function with this slope (p,): by the rows, and by the tests."""
        halves = {False: [0.0], True: [0.0]}
        for spread in self.spreads:
            variance = float(slope @ spread.covariance @ slope)
            if variance > 0.0:
                halves[spread.of_tests].append(spread.quantile * float(np.sqrt(variance)))
        return max(halves[False]), max(halves[True])

    def by_tests(self, name: str) -> bool:
        """Whether the interval of a constant is that of tests which differ, and not of their rows."""
        free = self.solution.model.free
        of_rows, of_tests = self._halves(np.eye(len(free))[free.index(name)])
        return of_tests > of_rows

    @property
    def covariance(self) -> Floats:
        """Covariance (p, p) on the scales whose 0.95 ellipse has the intervals, for samples."""
        size = self.solution.x.size
        if not size:
            return np.zeros((0, 0))
        kept = [spread for spread in self.spreads if np.isfinite(spread.quantile)]
        matrix = np.zeros((size, size))
        if kept:
            widest = max(
                kept, key=lambda spread: float(np.sum(np.diag(spread.covariance)) * spread.quantile**2)
            )
            matrix = widest.covariance * (widest.quantile / NORMAL) ** 2
        names = self.solution.model.free
        halves = []
        for name in names:
            low, high = (float(to_scale(name, end)) for end in self.of(name)[1:])
            halves.append(0.5 * (high - low) / NORMAL)
        # correlations of the groups, standard deviations of the intervals
        sizes = np.sqrt(np.diag(matrix))
        factors = np.divide(halves, sizes, out=np.ones(size), where=sizes > 0.0)
        scaled: Floats = matrix * np.outer(factors, factors)
        np.fill_diagonal(scaled, np.square(halves))
        return scaled


def assumed(
    chosen: Solution, law: Solution, tests: Sequence[ShearTest], forms: Sequence[Solution]
) -> Iterator[Assumption]:
    """Constants by other shapes than that of the choice, and by other starts of slip and dilation.

    A first slope is that of a profile, and the tests may not show which one it is.  Nor do they show where a
    gauge was set to zero, which moves the slope along the profile.  Of cycles the first strokes are compared.
    law: fit of the law.  forms: those of `shaped`.
    """
    own, alone, bond = chosen, not cycles(tests), chosen.model.bond
    if not (alone or bond) and "theta" in chosen.model.free:
        strokes = [rows_of(test, first_stroke(test)) for test in tests]
        first = rigid_form(law, strokes, ("W0",))
        names = slopes_of(tests) if first and ends(first.model) else ()
        forms = [first, *(with_shape(first, name) for name in names)] if first else []
        own = forms[0] if forms else chosen
    if not forms:
        return
    form, alternatives = forms[0], []
    if alone:
        differs = law.problem.is_closed_form or "mu" in law.model.free or law.values.get("mu", 0.0) > 0.0
        alternatives = [(form, AT_ONCE)] if bond and form is not law and differs else []
        alternatives += [] if bond else [(with_starts(form), STARTS)]
    for solution in forms[1:]:
        name = solution.model.shape
        alternatives += [(solution, name)] if solution is not chosen else [(law, SHAPE_OF_LAW)]
        alternatives += [(with_starts(solution), f"{name}, {STARTS}")] if alone and not bond else []
    # crush belongs to the profile, too, and a spring goes with the start of the slip
    parts = tuple(part for part in chosen.model.free if part not in ("crush", "W0", *SPRINGS))
    values = criteria([own, *(solution for solution, _ in alternatives)])
    apart: dict[str, Mapping[str, float]] = {}
    for (solution, name), value in zip(alternatives, values[1:], strict=True):
        # a shape that explains the tests better than the law excludes others, too
        allowed, shape = value < min(values) + GAIN, solution.model.shape
        # the closed form of a bond moves the constants, and has their width
        halves = halves_of(solution) if allowed and name != AT_ONCE else {}
        if allowed and shape:
            if shape not in apart:
                whole = next(other for other in forms if other.model.shape == shape)
                apart[shape] = halves_of(whole, left_out(whole))
            halves = {part: max(half, apart[shape].get(part, 0.0)) for part, half in halves.items()}
        shown = tuple(part for part in parts if part in solution.model.free)
        yield Assumption(name, value - values[0], solution.values, allowed, shown, halves, shape in apart)


def unseen(chosen: Solution, tests: Sequence[ShearTest], intervals: Intervals) -> Iterator[Assumption]:
    """The slope and the height that the rows show, where those of the fit are larger.

    Both are extrapolations.  A slope without pressure, by crush: one that wears ends sooner under pressure,
    too, and is no smaller at first.  And a height beyond the rows: their dilation may end with them.
    intervals: those without these assumptions.
    """
    shown = float(np.degrees(np.arctan(max(map(first_slope, tests)))))
    if {"theta", "crush"} <= {*chosen.model.free} and 0.0 < shown < chosen.values["theta"]:
        yield Assumption(UNCRUSHED, 0.0, {"theta": shown}, True, ("theta",), {"theta": 0.0}, True)
    if "height" in chosen.model.free and chosen.values["theta"] > 0.0:
        values, slope = chosen.values, float(np.tan(np.radians(chosen.values["theta"])))
        compliance = sum(1.0 / values[name] for name in SPRINGS if name in values)
        way = max(float(np.max(np.abs(test.slip) - compliance * np.abs(test.tau))) for test in tests)
        reached = SHAPES[chosen.model.shape].profile(np.array([max(0.0, way)]), slope, values["height"])[1]
        if 0.0 < float(reached[0]) < intervals.of("height").low:
            height = {"height": float(reached[0])}
            yield Assumption(ENDED_HERE, 0.0, height, True, ("height",), {"height": 0.0}, True)


def left_out(form: Solution) -> list[Solution]:
    """Fits of a closed form without each of its tests."""
    tests = list(form.problem.tests)
    rest = [tests[:i] + tests[i + 1 :] for i in range(len(tests))] if len(tests) > 1 else []
    return [refitted(form, some, tolerance=SEARCHED) for some in rest]


def halves_of(solution: Solution, left_out: Sequence[Solution] = ()) -> dict[str, float]:
    """Half widths of the intervals of a solution, on the scales of its constants.

    left_out: fits without each of the tests.
    """
    intervals, halves = Intervals(solution, spreads(solution, left_out), []), {}
    for name in solution.model.free:
        low, high = (float(to_scale(name, end)) for end in intervals.of(name)[1:])
        halves[name] = 0.5 * (high - low)
    return halves


def guessed(
    chosen: Solution,
    solutions: Sequence[Solution],
    bic: Sequence[float],
    measured: bool,
) -> Iterator[str]:
    """Reason why a bond is a guess: a joint without bond explains the tests as well.

    measured: whether the tests have a dilation.  Without one the softening of asperities may be that of a
    bond, and only its dependence on the pressure tells them apart.
    """
    rock, bond = _best(solutions, bic)
    if rock < bond + GAIN or not (measured or _constant(chosen)):
        what = "ladder of models" if measured else "strength alone"
        help_ = "" if measured else "a measured dilation, "
        yield (
            f"the {what} does not tell a bond from asperities that end: --joint mortar or rock, {help_}"
            "or pressures further apart"
        )


def is_near_bond(solutions: Sequence[Solution], bic: Sequence[float]) -> bool:
    """Whether a joint with a bond explains the tests nearly as well as the best one without.

    That is no reason against the latter: a bond needs a proof, and one that the tests hardly show leaves the
    friction and the asperities as they are.
    """
    rock, bond = _best(solutions, bic)
    return bond < rock + GAIN


def _best(solutions: Sequence[Solution], bic: Sequence[float]) -> tuple[float, float]:
    """Smallest criterion of the joints without and with a bond."""
    rock, bond = (
        min(
            (value for solution, value in zip(solutions, bic, strict=True) if solution.model.bond == kind),
            default=np.inf,
        )
        for kind in (False, True)
    )
    return rock, bond


@dataclass(frozen=True, eq=False)
class Scaled(Problem):
    """Problem whose bond grows with the root of the pressure of the test, as asperities do; kind: of it."""

    kind: type[Problem] = Problem

    @cached_property
    def each(self) -> list[tuple[float, Problem]]:
        """Factor of the bond and problem of each test."""
        pressed = np.array([max(abs(test.pressed), 1e-300) for test in self.tests])
        factors = (pressed / np.exp(np.mean(np.log(pressed)))) ** ROOT
        rest = (self.free, self.fixed, self.sides, self.direction, self.increments, self.weight)
        return [
            (float(factor), self.kind([test], *rest))
            for factor, test in zip(factors, self.tests, strict=True)
        ]

    @cached_property
    def paths(self) -> list[tuple[Floats, np.ndarray]]:
        """Slips and rows of each test."""
        return [problem.paths[0] for _, problem in self.each]

    def curve(self, values: Mapping[str, float], number: int) -> Curve:
        """Curve of a test."""
        factor, problem = self.each[number]
        return problem.curves({**values, **{name: factor * values[name] for name in ("sigma0", "Gc")}})[0]


def _scaled(problem: Problem) -> Scaled:
    rest = (problem.sides, problem.direction, problem.increments, problem.weight)
    return Scaled(problem.tests, problem.free, problem.fixed, *rest, kind=type(problem))


def _constant(chosen: Solution) -> bool:
    """Whether the tests exclude asperities with the softening of the bond and a strength that grows."""
    if np.ptp([abs(test.pressed) for test in chosen.problem.tests]) == 0.0:
        return False
    scaled, ratio = _scaled(chosen.problem), np.inf
    coarse, mean_square = _scaled(chosen.problem.coarse()), max(chosen.mean_squares["tau"], 1e-12)
    for x in (chosen.x, solve(coarse, chosen.x, SEARCHED)[0]):
        ratio = min(ratio, float(np.mean(residuals(scaled, x) ** 2)) / mean_square)
    return independent(chosen)["tau"] * float(np.log(max(ratio, 1e-12))) >= GAIN


def share_of_bond(solution: Solution) -> float:
    """Largest part that the bond carries in a row, over the largest tau of its test.

    It is the part which the same joint with a broken bond lacks.
    """
    problem, share = solution.problem, 0.0
    broken = problem.curves(solution.values | {"damage0": 1.0})
    for test, (_, rows), (tau, _, _), (rest, _, _) in zip(
        problem.tests, problem.paths, problem.curves(solution.values), broken, strict=True
    ):
        share = max(share, float(np.abs(tau - rest)[rows].max() / np.abs(test.tau).max()))
    return share


def softens(solution: Solution) -> bool:
    """Whether the bond falls below its strength, beyond the misfit, in the rows of a test.

    Where it does not, its energy is that of its own elastic slip, by which it meets the first rows.
    """
    values, shape = solution.values, SHAPES[solution.model.shape]
    strength, spring = values["sigma0"], values.get(KT, np.inf)
    at_peak = strength**2 / (values["Gc"] * spring) if shape.rises else 0.0
    for test in solution.problem.tests:
        slip = np.abs(test.slip) - (0.0 if shape.rises else np.abs(test.tau) / spring)
        pull = strength * shape.softening(np.maximum(0.0, slip) * strength / values["Gc"], at_peak)
        fall = float(np.max(np.maximum.accumulate(pull) - pull))
        if fall > BY_NOISE * solution.scatter["tau"] * float(np.ptp(test.tau)):
            return True
    return False


def unseen_bond(chosen: Solution, auto: bool, of_user: Mapping[str, float]) -> tuple[str, str]:
    """Reason and note, empty where there is none, of a bond that no row shows.

    auto: whether the ladder chose it; of_user: values of the user, which are accepted.
    """
    share = share_of_bond(chosen)
    if share >= GOOD:
        return "", ""
    text = f"the rows do not show the bond, which carries at most {share:.1%} of the largest traction"
    if {"sigma0", "Gc"} <= {*of_user}:
        return "", f"{text}: its constants are assumed"
    help_ = "--joint rock" if auto else "--set sigma0= and Gc="
    return f"{text}: {help_}, or rows at smaller slips", ""
