"""What a fit has found: constants with intervals, and measures of its quality."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ..contract import Floats
from ..interface import Interface
from .constants import SCALES, from_scale, material_of, to_scale
from .model import Problem, at_rows

DEPENDENT = 0.3
"""Correlation of neighbouring residuals above which the model differs from the tests by more than noise."""

DEVIATIONS = 3.0
"""Standard deviations of the correlation of independent residuals, 1/sqrt(n), that count as none."""

SAME = 1.01
"""Largest ratio of two sums of squares that count as the same minimum."""

UNDETERMINED = 2.0
"""A constant is not determined if its value and an end of its interval differ by more than this factor."""

COUPLED = 0.99
"""Correlation above which two constants are called not separable."""

REFINE = 4
"""Sub-increments per increment of the next finer model."""

ENOUGH = 0.1
"""Accepted shift of a constant by finer increments, in standard errors.

This shift turns a 95 % interval into one of 94.8 %.
"""

LEAST_ERROR = 1.0e-3
"""Smallest relative standard error in which a shift is measured: no two boxes agree to a thousandth."""

RANK = 1.0e-10
"""Singular values below this fraction of the largest one are rounding errors."""

NEAR_BOUND = 1.0e-3
"""Distance of a constant from its bound, over that of its bounds on its scale, that counts as none."""

NAMES = ("peak", "slip at peak", "residual", "dilation")
"""Numbers of a test that are compared: the residual and the dilation are those at the end."""


@dataclass(frozen=True)
class Estimate:
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

    @property
    def jacobian(self) -> Floats:
        """Derivatives (n, p) of the residuals with the constants on their scales."""
        return np.asarray(self.result.jac)

    @cached_property
    def converged(self) -> bool:
        """Whether the least squares converged."""
        return bool(self.result.success)

    @cached_property
    def values(self) -> dict[str, float]:
        """Constants by name, fixed ones included."""
        return self.problem.values(self.x)

    @cached_property
    def scatter(self) -> tuple[float, float]:
        """Standard deviation of tau and of s_N about the fit, over their range (nan without dilation)."""
        # the degrees of freedom of the constants are divided among the quantities by their number of rows
        share = 1.0 - self.x.size / self.residuals.size
        parts = [self.residuals[self.problem.is_dilation == which] for which in (False, True)]
        found = [float(np.sqrt(np.mean(part**2) / share)) if part.size else np.nan for part in parts]
        return found[0], found[1] / self.problem.weight

    @cached_property
    def inverse(self) -> Floats:
        """Changes of the constants on their scales with the residuals, (p, n)."""
        return np.linalg.pinv(self.jacobian, rcond=RANK)

    @cached_property
    def covariance(self) -> Floats:
        """Covariance (p, p) of x, of lmfit; directions without influence have a large variance."""
        found = self.result.covar if self.result.errorbars else None
        if found is not None and (np.diag(found) > 0.0).all():
            return np.asarray(found)
        _, sizes, directions = np.linalg.svd(self.jacobian, full_matrices=False)
        dark = directions[sizes <= RANK * sizes[0]]
        variance: Floats = self.result.redchi * self.inverse @ self.inverse.T + dark.T @ dark / RANK
        return variance

    @property
    def errors(self) -> Floats:
        """Standard errors (p,) of x."""
        return np.sqrt(np.diag(self.covariance))

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

        return float(stdtrit(self.result.nfree, 0.5 + 0.5 * self.confidence)) * self.widening

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
        """Correlation matrix of the free constants on their scales, (p, p)."""
        matrix: Floats = self.covariance / np.outer(self.errors, self.errors)
        return matrix

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Free constants with their intervals, which are symmetric on their scales."""
        half = self.quantile * self.errors
        return {
            name: Estimate(self.values[name], *from_scale(name, [x - h, x + h]).tolist())
            for name, x, h in zip(self.problem.free, self.x, half, strict=True)
        }

    @property
    def interface(self) -> Interface:
        """Interface with the identified constants."""
        return self.problem.interface(self.values)

    def of(self, function: Callable[[Mapping[str, float]], float]) -> Estimate:
        """Interval of a positive function of the constants, from the gradient of its logarithm."""

        def log(x: Floats) -> float:
            return float(np.log(function(self.problem.values(x))))

        step = 1e-4
        gradient = np.array(
            [(log(self.x + d) - log(self.x - d)) / (2.0 * step) for d in step * np.eye(self.x.size)]
        )
        half = self.quantile * float(np.sqrt(gradient @ self.covariance @ gradient))
        value = log(self.x)
        return Estimate(*np.exp(np.clip([value, value - half, value + half], -700.0, 700.0)).tolist())

    def shift_by(self, change: Floats) -> float:
        """Largest change of a constant, in standard errors, due to a change of the residuals (n,)."""
        sizes = [
            abs(x) if SCALES[name] == "linear" else 1.0
            for name, x in zip(self.problem.free, self.x, strict=True)
        ]
        errors = np.maximum(self.errors, LEAST_ERROR * np.array(sizes))
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
        """Measured and fitted numbers of each test, by NAMES."""
        found = []
        for test, path, (tau, s_N, _) in zip(
            self.problem.tests, self.problem.paths, self.curves, strict=True
        ):
            model, way = at_rows(test, tau, path.rows), test.slip
            if test.envelope:
                pairs = {"peak": (test.tau[0], model[0]), "residual": (test.tau[1], model[1])}
            else:
                peaks = [int(np.argmax(np.abs(one))) for one in (test.tau, model)]
                pairs = {
                    "peak": (abs(test.tau[peaks[0]]), abs(model[peaks[1]])),
                    "slip at peak": (abs(way[peaks[0]]), abs(way[peaks[1]])),
                    "residual": (abs(test.tau[-1]), abs(model[-1])),
                }
                if test.s_N is not None:
                    pairs["dilation"] = (test.s_N[-1], s_N[path.rows[-1]])
            found.append({name: (float(a), float(b)) for name, (a, b) in pairs.items()})
        return found

    @cached_property
    def deviation(self) -> tuple[float, float]:
        """Relative error of the law, of tau and of s_N: 0 where it differs from the tests by noise only.

        The largest of the scatter over the peak and of the differences at peak, end and of the dilation.
        """
        if not self.dependent:
            return 0.0, 0.0
        sizes = {"tau": [0.0], "dilation": [0.0]}
        for test, name, place in self.problem.parts:
            values = test.tau if name == "tau" else test.s_N
            scale = self.problem.spreads[self.problem.tests.index(test)][name != "tau"]
            part = self.residuals[place] / (1.0 if name == "tau" else self.problem.weight)
            sizes[name].append(float(np.sqrt(np.mean(part**2))) * scale / float(np.abs(values).max()))
        for test, one in zip(self.problem.tests, self.comparison, strict=True):
            for name, (measured, fitted) in one.items():
                kind = {"peak": "tau", "residual": "tau", "dilation": "dilation"}.get(name)
                scale = abs(fitted) if kind != "dilation" else max(abs(fitted), float(np.ptp(test.s_N)))
                if kind and scale > 0.0:
                    sizes[kind].append(abs(measured - fitted) / scale)
        return max(sizes["tau"]), max(sizes["dilation"])

    @property
    def undetermined(self) -> list[str]:
        """Free constants whose intervals are wider than UNDETERMINED to either side, the widest first."""
        widths = {}
        for name, x, error in zip(self.problem.free, self.x, self.errors, strict=True):
            most = abs(x) / UNDETERMINED if SCALES[name] == "linear" else np.log(UNDETERMINED)
            widths[name] = float(self.quantile * error / most)
        return sorted((name for name, width in widths.items() if width > 1.0), key=lambda name: -widths[name])

    @property
    def at_bounds(self) -> list[str]:
        """Free constants that lie at a bound."""
        found = []
        for name, x in zip(self.problem.free, self.x, strict=True):
            low, high = to_scale(name, self.problem.bounds[name])
            if min(x - low, high - x) < NEAR_BOUND * (high - low):
                found.append(name)
        return found


def residual_ratio(values: Mapping[str, float]) -> float:
    """|tau|/|sigma_N| of a fully damaged interface that slides up one facing plane; inf if it locks."""
    return float(material_of(values).residual_strength(values["theta"]))
