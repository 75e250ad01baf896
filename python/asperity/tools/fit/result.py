"""What a fit has found: constants with intervals, predictions, grade, and whether it is a result."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...contract import Floats
from ...interface import Interface
from .intervals import Assumption, Estimate, Intervals
from .model import KT
from .search import Solution
from .shear_test import ShearTest
from .verdict import Comparison, compared


@dataclass(eq=False)
class Fit:
    """Identified constants, their intervals, and the judgement of both.

    tests: that were fitted.  solution: constants and residuals.  estimates: free constants with their
    intervals, which contain noise, misfit of the law and other assumptions.  fitted, blind: measured and
    predicted numbers of each test, in the second list predicted by the other tests.  errors: largest error
    of each kind.  grade: good (at most 5 %), fair (15 %) or poor.  reasons: why the constants are no result;
    none if they are one.  notes: what else a user should know.  assumptions: fits with other assumptions.
    models: free constants of the models of the ladder, with their information criterion over that of the
    chosen one.  loose: free constants that are not determined and on which the others do not depend.
    """

    tests: Sequence[ShearTest]
    solution: Solution
    intervals: Intervals
    estimates: dict[str, Estimate]
    fitted: list[Comparison]
    blind: list[Comparison]
    errors: dict[str, float]
    grade: str
    reasons: list[str]
    notes: list[str] = field(default_factory=list)
    assumptions: list[Assumption] = field(default_factory=list)
    models: list[tuple[tuple[str, ...], float]] = field(default_factory=list)
    loose: list[str] = field(default_factory=list)
    _known: dict[tuple[object, ...], Mapping[str, float]] = field(default_factory=dict, repr=False)

    @property
    def is_result(self) -> bool:
        """Whether the constants may be used: no reason speaks against them."""
        return not self.reasons

    @property
    def values(self) -> dict[str, float]:
        """All constants by name."""
        return self.solution.values

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free constants."""
        return self.solution.model.free

    @property
    def interface(self) -> Interface:
        """Interface with the identified constants."""
        return self.solution.problem.interface(self.values)

    @property
    def spring(self) -> float:
        """Stiffness of the spring in series with the joint, 0 without one."""
        return self.values.get(KT, 0.0)

    @property
    def scatter(self) -> dict[str, float]:
        """Scatter of tau and of the dilation over their ranges."""
        return self.solution.scatter

    @property
    def peaks(self) -> list[Estimate]:
        """Peaks of the tests by the law, with intervals."""
        return [self.number(test, "peak") for test in range(len(self.fitted))]

    @property
    def model_text(self) -> str:
        """Form of the joint, its free constants, and values that were fixed."""
        model, hidden = self.solution.model, ("theta", "flat", "height", "crush", "W0", "closure")
        form = "with bond" if model.bond else "without bond"
        pattern = f"{model.sides} sides" if "theta" in {*model.free, *model.fixed} else "flat"
        fixed = [f"{n} = {value:.4g}" for n, value in model.fixed.items() if value or n not in hidden]
        known = f"; fixed: {', '.join(fixed)}" if fixed else ""
        return f"joint {form}, {pattern}; free: {', '.join(self.free)}{known}"

    @property
    def covariance(self) -> Floats:
        """Covariance (p, p) of the free constants on their scales, with the size of the intervals."""
        return self.intervals.covariance

    @property
    def residuals(self) -> Floats:
        """Residuals (n,) over the range of each test and quantity, of tau then of the dilation."""
        weights = self.solution.problem.weight * self.solution.problem.is_dilation
        weights[~self.solution.problem.is_dilation] = 1.0
        return self.solution.residuals / weights

    def of(self, function: Callable[[Mapping[str, float]], float]) -> Estimate:
        """Value and interval of a positive function of the constants."""
        return self.intervals.of("", function)

    def number(self, test: int, name: str) -> Estimate:
        """Number of a test by the law, with an interval that contains the misfit of such numbers.

        name: peak, slip at peak, residual or dilation.  The misfit is that of the blind predictions where
        there are any.
        """

        def of(values: Mapping[str, float]) -> float:
            return max(abs(self._numbers(test, values).get(name, 0.0)), 1e-12)

        exact, (value, low, high) = abs(self.fitted[test].predicted[name]), self.of(of)
        missed = [row.errors[name] for row in self.blind or self.fitted if name in row.errors]
        off = 2.0 * float(np.sqrt(np.mean(np.square(missed)))) if missed else 0.0
        below, above = (float(np.hypot(half / value, off)) for half in (value - low, high - value))
        return Estimate(exact, exact * (1.0 - below), exact * (1.0 + above))

    def _numbers(self, test: int, values: Mapping[str, float]) -> Mapping[str, float]:
        """Numbers of a test by the closed form, if there is one, each set of which runs once."""
        key = (test, *values.items())
        if key not in self._known:
            alone = self.solution.model.problem([self.tests[test]], 1.0, self.solution.problem.direction)
            self._known[key] = compared(alone, values)[0].predicted
        return self._known[key]

    @property
    def model_error(self) -> tuple[float, float]:
        """Relative errors of tau and of the dilation, blind ones where there are any: root mean squares."""
        rows = self.blind or self.fitted
        means = []
        for names in (("peak", "residual"), ("dilation",)):
            errors = [row.errors[name] for row in rows for name in names if name in row.errors]
            means.append((sum(error**2 for error in errors) / max(1, len(errors))) ** 0.5)
        return means[0], means[1]
