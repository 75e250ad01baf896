"""What a fit has found: parameters with intervals, and measures of its quality."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..contract import Floats
from ..interface import Interface
from .model import SCALES, STEP, Problem, Scale, material_of

DEPENDENT = 0.3
"""Correlation of neighbouring residuals above which the model differs from the tests by more than noise."""

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

ENOUGH = 0.1
"""Accepted shift of a parameter by finer increments, in standard errors.

This shift turns a 95 % interval into one of 94.8 %.
"""

LEAST_ERROR = 1.0e-3
"""Smallest relative standard error in which a shift is measured: no two boxes agree to a thousandth."""

RANK = 1.0e-10
"""Singular values below this fraction of the largest one are rounding errors."""

NEAR_BOUND = 1.0e-3
"""Distance of a transformed parameter from its bound below which it lies at the bound."""


@dataclass(frozen=True)
class Estimate:
    """Value and ends of its confidence interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Fit:
    """Identified parameters and measures of their quality.

    x (p,): transformed free parameters; residuals (n,) and jacobian (n, p) there.  confidence: of the
    intervals.  model_error: accepted scatter, as a fraction of the range.  converged: whether the least
    squares converged.  costs: sums of squares from the starts with the requested increments, the best first.
    shift: largest change of a parameter, in standard errors, if each increment is divided into REFINE.
    """

    problem: Problem
    x: Floats
    residuals: Floats
    jacobian: Floats
    confidence: float
    model_error: float
    converged: bool
    costs: tuple[float, ...]
    shift: float = np.inf

    @cached_property
    def values(self) -> dict[str, float]:
        """Parameters by name, fixed ones included."""
        return self.problem.values(self.x)

    @cached_property
    def scatter(self) -> tuple[float, float]:
        """Standard deviation of tau and of s_N about the fit, over their range (nan without dilation)."""
        # the degrees of freedom of the parameters are divided among the quantities by their number of rows
        share = 1.0 - self.x.size / self.residuals.size
        parts = [self.residuals[self.problem.is_dilation == which] for which in (False, True)]
        found = [float(np.sqrt(np.mean(part**2) / share)) if part.size else np.nan for part in parts]
        return found[0], found[1]

    @cached_property
    def _svd(self) -> tuple[Floats, Floats, Floats]:
        return np.linalg.svd(self.jacobian, full_matrices=False)

    @property
    def singular(self) -> Floats:
        """Singular values of the Jacobian (p,), in descending order."""
        return self._svd[1]

    @property
    def directions(self) -> Floats:
        """Vectors of the singular values (p, p), in rows."""
        return self._svd[2]

    @cached_property
    def inverse(self) -> Floats:
        """Changes of the transformed parameters with the residuals, (p, n)."""
        return np.linalg.pinv(self.jacobian, rcond=RANK)

    @cached_property
    def covariance(self) -> Floats:
        """Covariance (p, p) of x: tau and s_N have the scatter of their own residuals."""
        variances = np.where(self.problem.is_dilation, *(size**2 for size in self.scatter[::-1]))
        # directions without influence on the residuals have an infinite variance
        dark = self.directions[self.singular <= RANK * self.singular[0]]
        found: Floats = (self.inverse * variances) @ self.inverse.T + dark.T @ dark / RANK
        return found

    @cached_property
    def neighbours(self) -> float:
        """Correlation of the residuals of neighbouring rows."""
        parts = [self.residuals[place] for _, _, place in self.problem.parts]
        size = float(self.residuals @ self.residuals)
        return sum(float(part[:-1] @ part[1:]) for part in parts) / size if size > 0.0 else 0.0

    @property
    def quantile(self) -> float:
        """Quantile of Student's t at `confidence`; with an accepted model error it is widened."""
        from scipy.special import stdtrit

        freedom = self.residuals.size - self.x.size
        return float(stdtrit(freedom, 0.5 + 0.5 * self.confidence)) * self.widening

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
            name: Estimate(self.values[name], *SCALES[name].back([x - h, x + h]).tolist())
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
        return Estimate(*Scale().back([value, value - half, value + half]).tolist())

    def shift_by(self, change: Floats) -> float:
        """Largest change of a parameter, in standard errors, due to a change of the residuals (n,)."""
        errors = np.maximum(np.sqrt(np.diag(self.covariance)), LEAST_ERROR)
        return float(np.max(np.abs(self.inverse @ change) / errors))

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

    @cached_property
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
        return [
            name
            for name, x in zip(self.problem.free, self.x, strict=True)
            if min(abs(x - SCALES[name].to(bound)) for bound in self.problem.bounds[name]) < NEAR_BOUND
        ]


def residual_ratio(values: Mapping[str, float]) -> float:
    """|tau|/|sigma_N| of a fully damaged interface that slides up one facing plane; inf if it locks."""
    return float(material_of(values).residual_strength(values["theta"]))
