"""Intervals that count the misfit of the law: residuals in groups that are independent of one another."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...contract import Floats
from .model import PLAUSIBLE, SPRINGS, from_scale, plausible, to_scale
from .search import Solution
from .thresholds import CONFIDENCE, KNOWN_TESTS, NORMAL, PARTS, RIDGE, SCATTER, SCATTER_OF_OTHERS


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
    test, part = rows.test.to_numpy(), np.zeros(len(rows), dtype=int)
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
