"""Closure tests of joints: normal stiffness and largest closure from the loading, the unloading predicted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ... import contract
from ...contract import Floats
from ...interface import Interface
from ...material import Material
from ...pattern import Pattern
from ...steps import Step
from .closure_test import ClosureTest
from .intervals import Estimate, delete_one, quantiles
from .shear_test import independent_rows, refuse_copies
from .thresholds import (
    BOUND_DISTANCE,
    FACTOR,
    GAIN,
    GOOD,
    LARGEST_CLOSURES,
    LEAST_LOADING,
    MANY_CLOSURES,
    MISSED_BACK,
    NORMAL,
    PARTS_OF_CLOSURE,
    ROWS_OF_ONE,
    STIFFNESSES,
    TIMES_MISSED,
)
from .verdict import Comparison, grade_of

ASSUMED_MU = 0.6
"""Friction of the joint in the case, which a closure test does not show."""


def closed(pressure: Floats, kn: float, closure: float = 0.0) -> Floats:
    """Closure of a contact of the stiffness kn, hyperbolic with a largest closure, under a pressure (n,).

    Bandis et al. (1983), docs/extensions.md, section 6.
    """
    return np.asarray(pressure / kn if not closure else pressure * closure / (kn * closure + pressure))


@dataclass(eq=False)
class ClosureFit:
    """Constants of the contact from the loading of closure tests, and their judgement.

    estimates: constants with intervals.  fitted, blind: measured and predicted closure at the largest
    pressure, in the second list predicted by the other tests.  errors: root mean squares over the closure,
    the largest of the tests.  unloading: the same for the unloading of each test, which no elastic contact
    follows.  loose, peaks: as of other fits, none.
    """

    tests: Sequence[ClosureTest]
    free: tuple[str, ...]
    values: dict[str, float]
    estimates: dict[str, Estimate]
    fitted: list[Comparison]
    blind: list[Comparison]
    errors: dict[str, float]
    unloading: list[float]
    grade: str
    reasons: list[str]
    notes: list[str]
    covariance: Floats
    loose: list[str] = field(default_factory=list)
    peaks: list[Estimate] = field(default_factory=list)

    @property
    def is_result(self) -> bool:
        """Whether the constants may be used."""
        return not self.reasons

    @property
    def model_error(self) -> tuple[float, float]:
        """Relative errors of tau and of the dilation: none, and that of the largest closure."""
        return 0.0, self.errors.get("blind closure", self.errors["closure"])

    @property
    def model_text(self) -> str:
        """Form of the contact and its free constants."""
        form = "hyperbolic contact" if "closure" in self.free else "contact of one stiffness"
        return f"{form}; free: {', '.join(self.free)}"

    @property
    def interface(self) -> Interface:
        """Flat joint of this contact; its shear stiffness and friction are assumed."""
        kn = self.values["kn"]
        more = {name: value for name, value in self.values.items() if name == "closure"}
        return Interface(Material.from_joint(kn=kn, ks=kn, mu=ASSUMED_MU, **more), Pattern.regular(0, 0.0))

    def curve(self, pressure: Floats, first: float) -> Floats:
        """Closure (n,) since the first pressure."""
        return closed(pressure, **self.values) - closed(np.array([first]), **self.values)


def closure_of(joint: Interface, test: ClosureTest) -> Floats:
    """Closure (T,) of a joint since the first row, on the path of pressures of a test."""
    first = max(float(test.pressure[0]), 1e-9 * float(test.pressure.max()))
    path = np.maximum(test.pressure, 1e-9 * test.pressure.max())
    history, lost = joint.rows([Step(t_N=-first, increments=1), Step(t_N=list(-path), increments=1)])
    if lost:
        raise ValueError(f"{test.name}: the joint has no equilibrium under the pressures of the test")
    closures: Floats = history.dilation[0] - history.after_step(1).dilation[-path.size :]
    return closures


def fit_closures(tests: Sequence[ClosureTest]) -> ClosureFit:
    """Stiffness and, where the rows show it, largest closure of a contact from the loading of closure tests.

    Raises ValueError for tests that are the same and for fewer than six rows of loading.

    Examples
    --------
    >>> import numpy as np
    >>> from asperity.tools.fit.closures import ClosureTest, closed, fit_closures
    >>> pressure = np.linspace(0.0, 10.0, 11)
    >>> fit = fit_closures([ClosureTest("a", pressure, closed(pressure, 20.0, 0.2))])
    >>> {name: round(estimate.value, 3) for name, estimate in fit.estimates.items()}
    {'kn': 20.0, 'closure': 0.2}
    """
    proper = isinstance(tests, Sequence) and tests and all(isinstance(test, ClosureTest) for test in tests)
    if not proper:
        raise ValueError(f"tests = {contract.shown(tests)}: expected a list of closure tests")
    rows = sum(len(test.loading) for test in tests)
    if rows < LEAST_LOADING:
        raise ValueError(f"{rows} rows of loading: expected at least {LEAST_LOADING}")
    refuse_copies([test.name for test in tests], [[test.pressure, test.closure] for test in tests])
    fits = [_solved(tests, names) for names in (("kn",), ("kn", "closure"))]
    ends = np.cumsum([len(test.loading) for test in tests])[:-1]
    counts = sum(map(independent_rows, np.split(fits[1][1], ends)))
    bic = [counts * np.log(np.mean(left**2) + 1e-12) + x.size * np.log(max(counts, 2.0)) for x, left in fits]
    free = ("kn", "closure") if bic[1] < bic[0] - GAIN else ("kn",)
    return _judged(tests, free, *fits[len(free) - 1])


def _ends(tests: Sequence[ClosureTest], names: tuple[str, ...]) -> Floats:
    """Bounds of the logarithms of the constants, (2, p)."""
    pressure = max(float(test.pressure.max()) for test in tests)
    closure = max(test.size for test in tests)
    stiffness = [pressure / closure * factor for factor in STIFFNESSES]
    ends: Floats = np.log(
        np.transpose([stiffness, [closure * factor for factor in LARGEST_CLOSURES]][: len(names)])
    )
    return ends


def _values(x: Floats, names: tuple[str, ...]) -> dict[str, float]:
    return {name: float(np.exp(value)) for name, value in zip(names, x, strict=True)}


def _residuals(x: Floats, tests: Sequence[ClosureTest], names: tuple[str, ...]) -> Floats:
    """Law less measurement over the closure of each test, of all rows of loading."""
    values, residuals = _values(x, names), []
    for test in tests:
        rows = test.loading
        law = closed(test.pressure[rows], **values)
        residuals.append(((law - law[0]) - (test.closure[rows] - test.closure[0])) / test.size)
    return np.concatenate(residuals)


def _solved(
    tests: Sequence[ClosureTest], names: tuple[str, ...], start: Floats | None = None
) -> tuple[Floats, Floats]:
    """Logarithms of the constants with the smallest sum of squares, and the residuals."""
    from scipy.optimize import least_squares

    low, high = _ends(tests, names)
    middle = 0.5 * (low + high)
    starts = [start] if start is not None else [middle, low + 0.3 * (high - low), low + 0.1 * (high - low)]
    tries = [
        least_squares(
            _residuals,
            np.clip(point, low + 1e-6, high - 1e-6),
            bounds=(low, high),
            args=(tests, names),
            xtol=1e-10,
        )
        for point in starts
    ]
    best = min(tries, key=lambda solution: float(solution.cost))
    return np.asarray(best.x), np.asarray(best.fun)


def _judged(tests: Sequence[ClosureTest], free: tuple[str, ...], x: Floats, residuals: Floats) -> ClosureFit:
    """The fit of one model with intervals, blind predictions and its grade."""
    step = 1e-5 * np.eye(x.size)
    slopes = np.transpose(
        [(_residuals(x + h, tests, free) - _residuals(x - h, tests, free)) / 2e-5 for h in step]
    )
    which = np.concatenate([np.full(len(test.loading), i) for i, test in enumerate(tests)])
    place = np.concatenate([np.linspace(0.0, 1.0, len(test.loading)) for test in tests])
    part = np.minimum(PARTS_OF_CLOSURE - 1, (place * PARTS_OF_CLOSURE).astype(int))
    covariance, wide = np.zeros((x.size, x.size)), -1.0
    for groups in (part, part + PARTS_OF_CLOSURE * which, which)[: 3 if len(tests) > MANY_CLOSURES else 2]:
        spread, count = delete_one(slopes, residuals, groups)
        quantile = float(quantiles(max(1, count - x.size)))
        if quantile**2 * np.trace(spread) > wide:
            covariance, wide = spread * (quantile / NORMAL) ** 2, quantile**2 * float(np.trace(spread))
    halves = NORMAL * np.sqrt(np.diag(covariance))
    low, high = _ends(tests, free)
    ends = np.exp(np.clip([x - halves, x + halves], low, high))
    values = _values(x, free)
    estimates = {n: Estimate(values[n], *map(float, ends[:, i])) for i, n in enumerate(free)}
    rest = [[kept for kept in tests if kept is not test] for test in tests] if len(tests) > 1 else []
    of_rest = [_values(_solved(some, free, x)[0], free) for some in rest]
    fitted = [_compared(test, values) for test in tests]
    unseen = [_compared(test, constants) for test, constants in zip(tests, of_rest, strict=False)]
    errors = {"loading": max(_rms(test, values, test.loading) for test in tests)}
    errors["closure"] = max(row.errors["closure"] for row in fitted)
    if unseen:
        errors["blind loading"] = max(
            _rms(test, constants, test.loading) for test, constants in zip(tests, of_rest, strict=True)
        )
        errors["blind closure"] = max(row.errors["closure"] for row in unseen)
    unloading = [_rms(test, values, test.unloading) if len(test.unloading) else 0.0 for test in tests]
    grade, worst = grade_of(max(errors.values())), max(errors, key=lambda name: errors[name])
    reasons = [f"the law misses the {worst} by {errors[worst]:.0%}"] if grade == "poor" else []
    near = np.minimum(x - low, high - x) < BOUND_DISTANCE * (high - low)
    for i, name in enumerate(free):
        value, least, most = estimates[name]
        if most > FACTOR**2 * least or near[i]:
            text = f"{name} is not determined: {value:.3g} [{least:.3g}, {most:.3g}]"
            reasons.append(f"{text}; rows at smaller and larger pressures would show it")
    if len(tests) == 1 and errors["loading"] > GOOD and residuals.size < ROWS_OF_ONE:
        text = f"{residuals.size} rows of one test, which the law misses by {errors['loading']:.0%}"
        reasons.append(f"{text}: another test would help")
    notes = ["the closure counts from the first row of each test, and only the first loading is fitted"]
    later = sum(test.pressure.size - len(test.loading) - len(test.unloading) for test in tests)
    if later:
        notes.append(f"{later} rows after the first unloading are not used")
    if "closure" not in free:
        notes.append("one stiffness: the rows do not show a largest closure")
    worst_back = max(unloading)
    if worst_back > max(MISSED_BACK, TIMES_MISSED * errors["loading"]):
        notes.append(f"the unloading is missed by {worst_back:.0%}: an elastic contact keeps no closure")
    if len(tests) == 1:
        notes.append("one test: nothing was predicted that the fit had not seen")
    return ClosureFit(
        tests, free, values, estimates, fitted, unseen, errors, unloading, grade, reasons, notes, covariance
    )


def _compared(test: ClosureTest, values: Mapping[str, float]) -> Comparison:
    """Measured and predicted closure at the end of the loading."""
    first, last = closed(test.pressure[[0, test.loading[-1]]], **values)
    predicted = float(last - first)
    error = abs(predicted / test.size - 1.0)
    return Comparison(test.name, {"closure": test.size}, {"closure": predicted}, {"closure": error})


def _rms(test: ClosureTest, values: Mapping[str, float], rows: np.ndarray) -> float:
    """Root mean square of the difference of the closure in some rows over the largest closure."""
    law = closed(test.pressure, **values)
    away = (law - law[0] - (test.closure - test.closure[0]))[rows]
    return float(np.sqrt(np.mean(away**2))) / test.size
