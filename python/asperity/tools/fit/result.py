"""What a fit has found: constants with intervals, measures of its quality, and whether it is a result."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...contract import Floats
from ...interface import Interface
from .model import ENDING, KS, SCALES, TIMELESS, Problem, at_rows, from_scale, material_of, residual_ratio

if TYPE_CHECKING:
    from pandas import DataFrame

CONFIDENCE = 0.95
"""Of the intervals."""

DEPENDENT, DEVIATIONS, TOGETHER = 0.3, 2.5, 3.5
"""Correlation of neighbouring residuals above which the law differs from the tests by more than noise;
standard deviations of that of independent residuals, 1/sqrt(n), up to which it counts as none; and robust
standard deviations beyond which two neighbouring rows are not off to the same side by chance.
"""

OF_STRENGTHS, NEGLIGIBLE = 0.03, 1.0e-3
"""Scatter of strengths without their curves, over the peak, above which the law may be another one; and
scatter over the range that needs no acceptance.
"""

SAME, BETTER = 1.01, 0.9
"""Ratios of two sums of squares: largest one that counts as the same minimum, and below which another fit is
preferred.
"""

WIDE, COUPLED, LEAST_REACH = float(np.log(2.0)), 0.99, 0.2
"""A constant is not determined if an end of its interval is this far from it, a factor of two on a
logarithmic scale; two are not separable above this correlation; a rupture energy is not determined by slips
up to this part of the largest separation s_f at which the bond may be broken: all beyond is extrapolated.
"""

REFINE, ENOUGH, LEAST_ERROR = 4, 0.1, 1.0e-3
"""Sub-increments per increment of the next finer model; the shift of a constant by them that is accepted, in
standard errors, which turns a 95 % interval into one of 94.8 %; and the smallest relative standard error in
which it is measured, as no two boxes agree to a thousandth.
"""

RANK, NEAR_BOUND = 1.0e-10, 1.0e-3
"""Smallest singular value over the largest one that counts, and distance from a bound over its range."""

OUTLYING, ALONE, MOVED, ROBUST = 6.0, 0.5, 1.0, 1.4826
"""An outlier is this many robust standard deviations off the fit, and beyond the rows beside it by this part
of that; moving a constant by this many standard errors it makes the fit no result.  Standard deviation of a
normal distribution over its median absolute deviation.
"""

SHOWN_BY = {row.name: row.shown_by for row in TIMELESS if row.shown_by} | {KS: "rows before the peak"}
"""What in the test data determines a constant."""


class Estimate(NamedTuple):
    """Value and ends of its confidence interval."""

    value: float
    low: float
    high: float


@dataclass(eq=False)
class Fit:
    """Identified constants and measures of their quality.

    result: of lmfit, for the free constants on their scales.  costs: sums of squares from the starts, the
    best first.  shift: largest change of a constant, in standard errors, if each increment is divided into
    REFINE.  model_error: accepted scatter, as a fraction of the range.  criteria: information criterion of
    each form that was tried.

    Of these follow x (p,), the free constants on their scales, with covariance (p, p), correlation (p, p) and
    standard errors (p,); values, all constants by name; residuals (n,) and the correlation of neighbouring
    ones; inverse (p, n), changes of x with the residuals; scatter, the standard deviation of tau and of s_N
    over their range, nan without dilation; converged; agreeing, the number of starts with the smallest sum.
    """

    problem: Problem
    result: Any
    costs: tuple[float, ...]
    shift: float = np.inf
    model_error: float = 0.0
    criteria: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Compute what follows of the least squares."""
        self.x, self.residuals = np.asarray(self.result.x), np.asarray(self.result.residual)
        self.values, self.converged = self.problem.values(self.x), bool(self.result.success)
        self.agreeing = sum(cost <= SAME * self.costs[0] for cost in self.costs)
        # directions without influence have a large variance; where there are none, the covariance is lmfit's
        left, sizes, right = np.linalg.svd(self.result.jac, full_matrices=False)
        self.inverse: Floats = np.asarray(right.T / np.maximum(sizes, RANK * sizes[0])) @ left.T
        self.covariance: Floats = self.result.redchi * self.inverse @ self.inverse.T
        self.errors = np.sqrt(np.diag(self.covariance))
        self.correlation = self.covariance / np.outer(self.errors, self.errors)
        r, beside = self.residuals, np.diff(self.problem.rows.row) == 1
        self.neighbours = float(r[:-1] @ (r[1:] * beside)) / (float(r @ r) or 1.0)
        # the degrees of freedom of the constants are divided among the quantities by their number of rows
        share = 1.0 - self.x.size / r.size
        parts = [r[self.problem.is_dilation == which] for which in (False, True)]
        tau, s_N = (float(np.sqrt(np.mean(part**2) / share)) if part.size else np.nan for part in parts)
        self.scatter = tau, s_N / self.problem.weight

    @property
    def interface(self) -> Interface:
        """Interface with the identified constants."""
        return self.problem.interface(self.values)

    @property
    def dependent(self) -> bool:
        """Whether the residuals of neighbouring rows are correlated beyond chance, of all rows or of two."""
        r, rows = self.residuals, self.problem.rows
        beside = np.diff(rows.row) == 1
        # a record of the shear traction may be noisier than that of the dilation
        usual = rows.assign(size=np.abs(r)).groupby(["test", "name"])["size"].transform("median")
        far = np.abs(r) > TOGETHER * ROBUST * usual.to_numpy()
        two = bool((far[1:] & far[:-1] & beside & (r[1:] * r[:-1] > 0.0)).any())
        return two or self.neighbours > max(DEPENDENT, DEVIATIONS / np.sqrt(r.size))

    @property
    def misses(self) -> bool:
        """Whether the law may differ from the tests by more than noise.

        Strengths alone do not show what is noise: a scatter that is large for strengths is enough.
        """
        strengths = all(test.envelope for test in self.problem.tests)
        return self.scatter[0] > OF_STRENGTHS if strengths else self.dependent

    @property
    def widening(self) -> float:
        """Factor on the intervals if a model error is accepted and residuals are correlated, otherwise 1."""
        widens = self.dependent and self.model_error > 0.0
        return float(np.sqrt((1.0 + self.neighbours) / (1.0 - self.neighbours))) if widens else 1.0

    @property
    def quantile(self) -> float:
        """Quantile of Student's t; with an accepted model error it is widened."""
        from scipy.special import stdtrit

        return float(stdtrit(self.result.nfree, 0.5 + 0.5 * CONFIDENCE)) * self.widening

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Free constants with their intervals, which are symmetric on their scales."""
        half = self.quantile * self.errors
        return {
            name: Estimate(self.values[name], *from_scale(name, [x - h, x + h]).tolist())
            for name, x, h in zip(self.problem.free, self.x, half, strict=True)
        }

    def of(self, function: Callable[[Mapping[str, float]], float]) -> Estimate:
        """Interval of a positive function of the constants, from the gradient of its logarithm."""
        step = 1e-4 * np.eye(self.x.size)
        value, *beside = (
            float(np.log(function(self.problem.values(x)))) for x in (self.x, *self.x + step, *self.x - step)
        )
        gradient = np.subtract(*np.split(np.array(beside), 2)) / (2.0 * step.max())
        half = self.quantile * float(np.sqrt(gradient @ self.covariance @ gradient))
        return Estimate(*from_scale("", [value, value - half, value + half]).tolist())

    @property
    def derived(self) -> dict[str, Estimate]:
        """Intervals of s_f and, for asperities that do not end, of the residual ratio, if not all is set."""
        free, found = {*self.problem.free}, {}
        if {"sigma0", "Gc"} & free:
            found["s_f"] = self.of(lambda values: material_of(values).s_f)
        stays = not any(self.values.get(name) for name in ENDING)
        if stays and {"mu", "theta"} & free and np.isfinite(residual_ratio(self.values)):
            found["ratio"] = self.of(residual_ratio)
        return found

    @property
    def sizes(self) -> Floats:
        """Changes of the constants on their scales that count as large as themselves, (p,)."""
        linear = [SCALES[name] == "linear" for name in self.problem.free]
        return np.where(linear, np.abs(self.x), 1.0)

    def shift_by(self, change: Floats) -> float:
        """Largest change of a constant, in standard errors, due to a change of the residuals (n,)."""
        errors = np.maximum(self.errors, LEAST_ERROR * self.sizes)
        return float(np.max(np.abs(self.inverse @ change) / errors))

    @property
    def coupled(self) -> dict[tuple[str, str], float]:
        """Correlation of the pairs of constants that cannot be separated."""
        pairs, known = combinations(enumerate(self.problem.free), 2), self.correlation
        return {(a, b): float(known[i, j]) for (i, a), (j, b) in pairs if abs(known[i, j]) > COUPLED}

    @property
    def undetermined(self) -> list[str]:
        """Free constants with intervals that are too wide, the widest first.

        The rupture energy is one of them where the slips end long before the bond is broken.
        """
        widths = dict(zip(self.problem.free, self.quantile * self.errors / (WIDE * self.sizes), strict=True))
        curves = [np.abs(test.slip).max() for test in self.problem.tests if not test.envelope]
        if "Gc" in widths and curves and max(curves) < LEAST_REACH * self.derived["s_f"].high:
            widths["Gc"] = np.inf
        return sorted((name for name in widths if widths[name] > 1.0), key=lambda name: -widths[name])

    @property
    def loose_bond(self) -> bool:
        """Whether strength or rupture energy are free and not determined."""
        return bool({"sigma0", "Gc"} & {*self.undetermined})

    @property
    def at_bounds(self) -> list[str]:
        """Free constants that lie at a bound."""
        low, high = self.problem.ends
        near = np.minimum(self.x - low, high - self.x) < NEAR_BOUND * (high - low)
        return [name for name, one in zip(self.problem.free, near, strict=True) if one]

    @cached_property
    def curves(self) -> list[tuple[Floats, Floats, int]]:
        """tau, s_N and the number of converged rows of the model of each test."""
        return self.problem.curves(self.values)

    @property
    def lost_rows(self) -> int:
        """Number of rows of the tests that the model does not reach, because it has no equilibrium there."""
        pairs = zip(self.problem.paths, self.curves, strict=True)
        return sum(int(np.sum(rows >= done)) for (_, rows), (*_, done) in pairs)

    @cached_property
    def comparison(self) -> DataFrame:
        """Measured and fitted numbers of each test, by its number and the name of the number.

        The residual strength, of a test that ends at its largest slip, and the dilation are those at the end.
        """
        from pandas import DataFrame

        found: dict[tuple[int, str], Any] = {}
        parts = zip(self.problem.tests, self.problem.paths, self.curves, strict=True)
        for number, (test, (_, rows), curve) in enumerate(parts):
            both = np.abs([test.tau, at_rows(test, curve[0], rows)])
            found[number, "peak"] = both.max(axis=1)
            if not test.envelope:
                found[number, "slip at peak"] = np.abs(test.slip)[both.argmax(axis=1)]
            found[number, "residual" if test.ends_far else "at the end"] = both[:, -1]
            if test.s_N is not None:
                found[number, "dilation"] = [test.s_N[-1], curve[1][rows[-1]]]
        return DataFrame(found, index=["measured", "fitted"]).T

    @property
    def deviation(self) -> tuple[float, float]:
        """Relative error of the law, of tau and of s_N: 0 where it differs from the tests by noise only.

        The largest of the scatter and of the differences at peak and end, and of the dilation at the end over
        the largest one.
        """
        if not self.misses:
            return 0.0, 0.0
        table, name = self.comparison, self.comparison.index.get_level_values(1)
        off = (table.fitted - table.measured).abs()
        ends, dilation = name.isin(["peak", "residual"]), name == "dilation"
        tau = (off / table.measured)[ends].max()
        s_N = (off[dilation] / table.measured[dilation].abs().max()).max()
        return float(max(tau, self.scatter[0])), float(np.nanmax([0.0, s_N, self.scatter[1]]))

    @cached_property
    def outliers(self) -> list[tuple[str, str, bool]]:
        """Rows with residuals far beyond those of others, which are far from their neighbours, too.

        Place, sentence, and whether the row moves a constant by more than MOVED standard errors.
        """
        rows = self.problem.rows.assign(size=np.abs(self.residuals))
        groups = rows.groupby(["test", "name"], sort=False)
        rows["off"] = ROBUST * groups["size"].transform("median")
        before, after = groups.measured.shift(1, fill_value=0.0), groups.measured.shift(-1)
        low, high = np.fmin(before, after), np.fmax(before, after)
        beyond = np.maximum(rows.measured - high, low - rows.measured) / rows.scale
        beyond *= np.where(self.problem.is_dilation, self.problem.weight, 1.0)
        far = rows[(rows["size"] > OUTLYING * rows.off) & (beyond > ALONE * rows["size"])]
        noise = ROBUST * float(np.median(np.delete(rows["size"].to_numpy(), far.index)))
        errors = np.maximum(noise * np.linalg.norm(self.inverse, axis=1), np.finfo(float).tiny)
        found = []
        for i, row in far.iterrows():
            test = self.problem.tests[row.test]
            moves = float(np.max(np.abs(self.inverse[:, i]) * row["size"] / errors))
            place = test.place(row.row) if test.lines else f"{test.name}: row {row.row + 1}"
            text = (
                f"outlier: {place}, {row['name']} {row.measured:g} is "
                f"{row['size'] / (row.off or np.nan):.0f} standard deviations off the fit and moves a "
                f"constant by {moves:.1g} standard errors"
            )
            found.append((place, text, moves > MOVED))
        return found


def checks(found: Fit) -> Iterator[tuple[bool, str]]:
    """Sentences about a fit, and whether each makes it no result."""
    yield from ((moves, text) for _, text, moves in found.outliers)
    for name in found.undetermined:
        if name not in found.at_bounds:
            yield True, f"{name} is not determined" + f": {SHOWN_BY.get(name)} would" * (name in SHOWN_BY)
    for name in found.at_bounds:
        i, value = found.problem.free.index(name), found.values[name]
        low, high = from_scale(name, found.problem.ends[:, i])
        end = f"lower bound {low:.3g}" if 2.0 * value < low + high else f"upper bound {high:.3g}"
        yield True, f"{name} is at its {end}, where its interval has no meaning"
    for (a, b), one in found.coupled.items():
        # without dilation the residual ratio alone is known
        apart = {a, b} == {"mu", "theta"} and not found.problem.is_dilation.any()
        yield apart, f"{a} and {b} cannot be separated (correlation {one:.4f}): set one of them"
    if found.misses:
        scatter = float(np.nanmax(found.scatter))
        how = f"correlation {found.neighbours:.2f} of the residuals of neighbouring rows"
        wide = f", intervals widened by {found.widening:.1f}" if found.widening > 1.0 else ""
        text = f"the law differs from the tests by more than noise: scatter {scatter:.1%} of the range, {how}"
        yield scatter > max(found.model_error, NEGLIGIBLE), text + wide
    if np.ptp([test.pressed for test in found.problem.tests]) == 0.0:
        yield False, "at one pressure a different law may fit as well: test at others, too"
    if found.lost_rows:
        yield True, f"the model has no equilibrium at {found.lost_rows} rows"
    if not found.converged:
        yield True, "the least squares ended before they converged"
    if found.shift > ENOUGH:
        yield True, f"the increments are too long: finer ones move a constant by {found.shift:.2g} errors"
    if found.agreeing == 1 and len(found.costs) > 1:
        yield True, "only one start reached the smallest sum of squares: raise --starts"


def failed_checks(found: Fit) -> list[str]:
    """Reasons why the constants must not be used; none if the fit is a result."""
    return [text for bad, text in checks(found) if bad]
