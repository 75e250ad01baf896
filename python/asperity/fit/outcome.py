"""What a fit has found: constants with intervals, and measures of its quality."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..contract import Floats
from ..interface import Interface
from .constants import SCALES, from_scale, material_of, to_scale
from .model import Problem, at_rows

DEPENDENT, DEVIATIONS = 0.3, 3.0
"""Correlation of neighbouring residuals above which the model differs from the tests by more than noise, and
standard deviations of that of independent residuals, 1/sqrt(n), up to which it counts as none.
"""

SAME = 1.01
"""Largest ratio of two sums of squares that count as the same minimum."""

UNDETERMINED, COUPLED = 2.0, 0.99
"""A constant is not determined if its value and an end of its interval differ by more than this factor; two
are not separable above this correlation.
"""

REFINE, ENOUGH, LEAST_ERROR = 4, 0.1, 1.0e-3
"""Sub-increments per increment of the next finer model; the shift of a constant by them that is accepted, in
standard errors, which turns a 95 % interval into one of 94.8 %; and the smallest relative standard error in
which it is measured, as no two boxes agree to a thousandth.
"""

RANK = 1.0e-10
"""Singular values below this fraction of the largest one are rounding errors."""

NEAR_BOUND = 1.0e-3
"""Distance of a constant from its bound, over that of its bounds on its scale, that counts as none."""


class Estimate(NamedTuple):
    """Value and ends of its confidence interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Fit:
    """Identified constants and measures of their quality.

    result: of lmfit, for the free constants on their scales.  confidence: of the intervals.  model_error:
    accepted scatter, as a fraction of the range.  costs: sums of squares from the starts, the best first.
    shift: largest change of a constant, in standard errors, if each increment is divided into REFINE.
    form: of the joint; criteria: information criterion of each form that was tried.
    """

    problem: Problem
    result: Any
    confidence: float
    model_error: float
    costs: tuple[float, ...]
    shift: float = np.inf
    form: str = ""
    criteria: Mapping[str, float] = field(default_factory=dict)

    @property
    def x(self) -> Floats:
        """Free constants on their scales, (p,)."""
        return np.asarray(self.result.x)

    @cached_property
    def residuals(self) -> Floats:
        """Residuals (n,) of the model."""
        return np.asarray(self.result.residual)

    @cached_property
    def converged(self) -> bool:
        """Whether the least squares converged."""
        return bool(self.result.success)

    @cached_property
    def values(self) -> dict[str, float]:
        """Constants by name, fixed ones included."""
        return self.problem.values(self.x)

    @property
    def interface(self) -> Interface:
        """Interface with the identified constants."""
        return self.problem.interface(self.values)

    @cached_property
    def scatter(self) -> tuple[float, float]:
        """Standard deviation of tau and of s_N about the fit, over their range (nan without dilation)."""
        # the degrees of freedom of the constants are divided among the quantities by their number of rows
        share = 1.0 - self.x.size / self.residuals.size
        parts = [self.residuals[self.problem.is_dilation == which] for which in (False, True)]
        tau, s_N = (float(np.sqrt(np.mean(part**2) / share)) if part.size else np.nan for part in parts)
        return tau, s_N / self.problem.weight

    @cached_property
    def inverse(self) -> Floats:
        """Changes of the constants on their scales with the residuals, (p, n).

        They are large in the directions without influence, which have a large variance.
        """
        left, sizes, right = np.linalg.svd(self.result.jac, full_matrices=False)
        return np.asarray(right.T / np.maximum(sizes, RANK * sizes[0])) @ left.T

    @cached_property
    def covariance(self) -> Floats:
        """Covariance (p, p) of x, as that of lmfit where every constant has an influence."""
        return np.asarray(self.result.redchi * self.inverse @ self.inverse.T)

    @property
    def errors(self) -> Floats:
        """Standard errors (p,) of x."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Floats:
        """Correlation matrix of the free constants on their scales, (p, p)."""
        return np.asarray(self.covariance / np.outer(self.errors, self.errors))

    @cached_property
    def neighbours(self) -> float:
        """Correlation of the residuals of neighbouring rows."""
        parts = [self.residuals[one.place] for one in self.problem.parts]
        size = float(self.residuals @ self.residuals)
        return sum(float(part[:-1] @ part[1:]) for part in parts) / size if size > 0.0 else 0.0

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

    def shift_by(self, change: Floats) -> float:
        """Largest change of a constant, in standard errors, due to a change of the residuals (n,)."""
        linear = [SCALES[name] == "linear" for name in self.problem.free]
        errors = np.maximum(self.errors, LEAST_ERROR * np.where(linear, np.abs(self.x), 1.0))
        return float(np.max(np.abs(self.inverse @ change) / errors))

    @property
    def agreeing(self) -> int:
        """Number of starts that reached the smallest sum of squares."""
        return sum(cost <= SAME * self.costs[0] for cost in self.costs)

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
        linear = [SCALES[name] == "linear" for name in self.problem.free]
        most = np.where(linear, np.abs(self.x) / UNDETERMINED, np.log(UNDETERMINED))
        widths = dict(zip(self.problem.free, self.quantile * self.errors / most, strict=True))
        return sorted((name for name in widths if widths[name] > 1.0), key=lambda name: -widths[name])

    @property
    def at_bounds(self) -> list[str]:
        """Free constants that lie at a bound."""
        names, bounds = self.problem.free, self.problem.bounds
        low, high = np.array([to_scale(name, bounds[name]) for name in names]).T
        near = np.minimum(self.x - low, high - self.x) < NEAR_BOUND * (high - low)
        return [name for name, one in zip(names, near, strict=True) if one]

    @cached_property
    def curves(self) -> list[tuple[Floats, Floats, int]]:
        """tau, s_N and the number of converged rows of the model of each test."""
        return self.problem.curves(self.values)

    @cached_property
    def lost_rows(self) -> int:
        """Number of rows of the tests that the model does not reach, because it has no equilibrium there."""
        pairs = zip(self.problem.paths, self.curves, strict=True)
        return sum(int(np.sum(path.rows >= done)) for path, (*_, done) in pairs)

    @cached_property
    def comparison(self) -> list[dict[str, tuple[float, float]]]:
        """Measured and fitted numbers of each test; the residual and the dilation are those at the end."""
        found = []
        for test, path, curve in zip(self.problem.tests, self.problem.paths, self.curves, strict=True):
            both = np.abs([test.tau, at_rows(test, curve[0], path.rows)])
            numbers = {"peak": both.max(axis=1), "residual": both[:, -1]}
            if not test.envelope:
                at_peak = np.abs(test.slip)[both.argmax(axis=1)]
                numbers = {"peak": numbers["peak"], "slip at peak": at_peak, "residual": both[:, -1]}
            if test.s_N is not None:
                numbers["dilation"] = np.array([test.s_N[-1], curve[1][path.rows[-1]]])
            found.append({name: (float(a), float(b)) for name, (a, b) in numbers.items()})
        return found

    @cached_property
    def deviation(self) -> tuple[float, float]:
        """Relative error of the law, of tau and of s_N: 0 where it differs from the tests by noise only.

        The largest of the scatter over the peak and of the differences at peak, end and of the dilation.
        """
        largest = {"tau": 0.0, "dilation": 0.0}
        for number, name, measured, scale, place in self.problem.parts if self.dependent else ():
            weight = 1.0 if name == "tau" else self.problem.weight
            sizes = [float(np.sqrt(np.mean(self.residuals[place] ** 2))) / weight * scale]
            sizes[0] /= float(np.abs(measured).max())
            one = self.comparison[number]
            for a, b in [one["peak"], one["residual"]] if name == "tau" else [one["dilation"]]:
                size = abs(b) if name == "tau" else max(abs(b), float(np.ptp(measured)))
                sizes.append(abs(a - b) / size if size > 0.0 else 0.0)
            largest[name] = max(largest[name], *sizes)
        return largest["tau"], largest["dilation"]


def residual_ratio(values: Mapping[str, float]) -> float:
    """|tau|/|sigma_N| of a fully damaged interface that slides up one facing plane; inf if it locks."""
    return float(material_of(values).residual_strength(values["theta"]))
