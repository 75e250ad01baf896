"""What a fit has found: constants with intervals, measures of its quality, and whether it is a result."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..contract import Floats
from ..interface import Interface
from .model import SCALES, Problem, at_rows, from_scale, material_of, residual_ratio

if TYPE_CHECKING:
    from pandas import DataFrame

DEPENDENT, DEVIATIONS = 0.3, 3.0
"""Correlation of neighbouring residuals above which the model differs from the tests by more than noise, and
standard deviations of that of independent residuals, 1/sqrt(n), up to which it counts as none.
"""

SAME, BETTER = 1.01, 0.9
"""Ratios of two sums of squares: largest one that counts as the same minimum, and below which another fit is
preferred.
"""

UNDETERMINED, COUPLED = 2.0, 0.99
"""A constant is not determined if its value and an end of its interval differ by more than this factor; two
are not separable above this correlation.
"""

REFINE, ENOUGH, LEAST_ERROR = 4, 0.1, 1.0e-3
"""Sub-increments per increment of the next finer model; the shift of a constant by them that is accepted, in
standard errors, which turns a 95 % interval into one of 94.8 %; and the smallest relative standard error in
which it is measured, as no two boxes agree to a thousandth.
"""

RANK, NEAR_BOUND = 1.0e-10, 1.0e-3
"""Singular values below this fraction of the largest one are rounding errors; distance of a constant from its
bound, over that of its bounds on its scale, that counts as none.
"""

POOR = 0.2
"""Scatter, as a fraction of the range of a test, above which correlated residuals are called a poor fit."""

OUTLYING, ALONE, MOVED = 6.0, 0.5, 1.0
"""Residual of an outlier in robust standard deviations; the part of it by which the row is above or below
both neighbours, as a row of a steep rise that the model misses is not; and change of a constant, in standard
errors, above which an outlier makes the fit no result.
"""

ROBUST = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""


class Estimate(NamedTuple):
    """Value and ends of its confidence interval."""

    value: float
    low: float
    high: float


@dataclass(eq=False)
class Fit:
    """Identified constants and measures of their quality.

    result: of lmfit, for the free constants on their scales.  confidence: of the intervals.  model_error:
    accepted scatter, as a fraction of the range.  costs: sums of squares from the starts, the best first.
    shift: largest change of a constant, in standard errors, if each increment is divided into REFINE.
    form: of the joint; criteria: information criterion of each form that was tried.  bonded: whether a bond
    that the tests do not determine fits better.

    Of these follow x (p,), the free constants on their scales, with covariance (p, p), correlation (p, p) and
    standard errors (p,); values, all constants by name; residuals (n,) and the correlation of neighbouring
    ones; inverse (p, n), changes of x with the residuals; scatter, the standard deviation of tau and of s_N
    over their range, nan without dilation; converged; agreeing, the number of starts with the smallest sum.
    """

    problem: Problem
    result: Any
    confidence: float
    model_error: float
    costs: tuple[float, ...]
    shift: float = np.inf
    form: str = ""
    criteria: Mapping[str, float] = field(default_factory=dict)
    bonded: bool = False

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
        """Whether the residuals of neighbouring rows are correlated beyond chance."""
        return self.neighbours > max(DEPENDENT, DEVIATIONS / np.sqrt(self.residuals.size))

    @property
    def dependence_factor(self) -> float:
        """Factor by which correlated residuals widen an interval (autoregressive of first order)."""
        return float(np.sqrt((1.0 + self.neighbours) / (1.0 - self.neighbours)))

    @property
    def widening(self) -> float:
        """Factor on the intervals: `dependence_factor` where a model error is accepted, otherwise 1."""
        return self.dependence_factor if self.dependent and self.model_error > 0.0 else 1.0

    @property
    def quantile(self) -> float:
        """Quantile of Student's t at `confidence`; with an accepted model error it is widened."""
        from scipy.special import stdtrit

        return float(stdtrit(self.result.nfree, 0.5 + 0.5 * self.confidence)) * self.widening

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
        """Intervals of s_f, s0, K and of the residual ratio, where they depend on free constants."""
        free, found = {*self.problem.free}, {}
        for name, entry in (("s_f", "s_f"), ("s0", "s_0"), ("K", "K")):
            if ({"sigma0", "Gc"} | ({"eta"} if name != "s_f" else set())) & free:
                found[name] = self.of(lambda values, entry=entry: getattr(material_of(values), entry))  # type: ignore[misc]
        if {"mu", "theta"} & free and np.isfinite(residual_ratio(self.values)):
            found["ratio"] = self.of(residual_ratio)
        return found

    @property
    def _linear(self) -> list[bool]:
        return [SCALES[name] == "linear" for name in self.problem.free]

    def shift_by(self, change: Floats) -> float:
        """Largest change of a constant, in standard errors, due to a change of the residuals (n,)."""
        errors = np.maximum(self.errors, LEAST_ERROR * np.where(self._linear, np.abs(self.x), 1.0))
        return float(np.max(np.abs(self.inverse @ change) / errors))

    @property
    def inseparable(self) -> bool:
        """Whether mu and theta are to be identified from tests that show the residual ratio only."""
        return {"mu", "theta"} in map(set, self.coupled) and not self.problem.is_dilation.any()

    @property
    def coupled(self) -> dict[tuple[str, str], float]:
        """Correlation of the pairs of constants that cannot be separated."""
        free, correlation = self.problem.free, self.correlation
        pairs = np.argwhere(np.triu(np.abs(correlation) > COUPLED, 1)).tolist()
        return {(free[i], free[j]): float(correlation[i, j]) for i, j in pairs}

    @property
    def undetermined(self) -> list[str]:
        """Free constants whose intervals are wider than UNDETERMINED to either side, the widest first."""
        most = np.where(self._linear, np.abs(self.x) / UNDETERMINED, np.log(UNDETERMINED))
        widths = dict(zip(self.problem.free, self.quantile * self.errors / most, strict=True))
        return sorted((name for name in widths if widths[name] > 1.0), key=lambda name: -widths[name])

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

    @cached_property
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

    @cached_property
    def deviation(self) -> tuple[float, float]:
        """Relative error of the law, of tau and of s_N: 0 where it differs from the tests by noise only.

        The largest of the scatter over the peak and of the differences at peak, end and of the dilation.
        """
        largest, rows = {"tau": 0.0, "dilation": 0.0}, self.problem.rows
        left = self.residuals / self.problem.weights * rows.scale
        for (number, name), places in rows.groupby(["test", "name"]).groups.items() if self.dependent else ():
            measured, table = rows.measured[places], self.comparison.loc[number]
            keys = ["peak", "residual"] if name == "tau" else ["dilation"]
            a, b = table.loc[[key for key in keys if key in table.index]].to_numpy().T
            size = np.maximum(np.abs(b), 0.0 if name == "tau" else np.ptp(measured))
            scatter = np.sqrt(np.mean(left[places] ** 2)) / np.abs(measured).max()
            largest[name] = max(largest[name], scatter, *(np.abs(a - b) / np.where(size > 0.0, size, np.inf)))
        return float(largest["tau"]), float(largest["dilation"])

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
        beyond *= self.problem.weights
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


def doubts(found: Fit) -> Iterator[tuple[str, str]]:
    """What is doubtful: reason why a fit is no result, empty where it is one, and sentence of the report."""
    for _, text, _ in found.outliers:
        yield "", text
    for name in found.undetermined:
        if name not in found.at_bounds:
            yield f"{name} is not determined", ""
    for name in found.at_bounds:
        value, (low, high) = found.values[name], found.problem.bounds[name]
        end = f"lower ({low:.3g})" if 2.0 * value < low + high else f"upper ({high:.3g})"
        text = f"{name} = {value:.4g} is at one of its bounds, {low:g} to {high:g}"
        yield f"{name} is at its {end} bound", f"{text}: its interval has no meaning"
    if found.bonded:
        reason = "a joint with bond fits better, but the tests do not determine its bond"
        yield reason, f"{reason}: give --joint rock only if the joint has none"
    if found.inseparable:
        yield "mu and theta are not separated without dilation", ""
    for (a, b), one in found.coupled.items():
        yield "", f"{a} and {b} cannot be separated (correlation {one:.4f}): set one of them"
    if found.dependent:
        scatter = float(np.nanmax(found.scatter))
        if scatter > POOR:
            text = f"the fit is poor: the residuals are {scatter:.0%} of the range. Check the plot, the "
            yield "", f"{text}units and the constants that are set; the numbers are not reliable"
        reason = f"the residuals of neighbouring rows are correlated ({found.neighbours:.2f})"
        text = (
            f"{reason}: the model differs from the test data by more than noise, so the intervals are "
            f"{'widened' if found.model_error > 0.0 else 'too narrow'} by a factor of about "
            f"{found.dependence_factor:.1f}"
        )
        # the widening for correlated residuals presumes that the scatter is what the user accepts
        yield reason if scatter > max(found.model_error, LEAST_ERROR) else "", text
    if found.lost_rows:
        yield f"the model has no equilibrium at {found.lost_rows} rows", ""
    if not found.converged:
        text = "the least squares ended before they converged: give a --start, or fewer free constants"
        yield "the least squares did not converge", text
    if found.shift > ENOUGH:
        change = f"finer ones change a constant by {found.shift:.2g} standard errors"
        reason = "the increments are too long"
        yield reason, f"{reason}: {change}; raise --increments"
    if found.agreeing == 1 and len(found.costs) > 1:
        reason = "only one start reached the smallest sum of squares"
        yield reason, f"{reason}: there may be a smaller one; raise --starts"
    moving = [place for place, _, moves in found.outliers if moves]
    if moving:
        yield f"outliers move the constants ({', '.join(moving)})", ""


def refusals(found: Fit) -> list[str]:
    """Reasons why the constants must not be used; none if the fit is a result."""
    return [reason for reason, _ in doubts(found) if reason]
