"""Strengths of tests without their curves: the law in closed form, and criteria of others beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ... import contract
from ...contract import Floats
from .checks import check_known
from .criteria import CRITERIA
from .intervals import CONFIDENCE, Estimate
from .model import AUTO, MORTAR, ROCK, from_scale, plausible, to_scale
from .strength import Strength
from .verdict import FACTOR, Comparison, grade_of

LEAST_TESTS, HALVINGS, GAIN, STEP, FOUND = 3, 32, 4.0, 1.0e-4, 1.0e-6
"""Tests that a fit needs; bisections of the share of a crushed asperity; information criterion that each
further constant must gain; step of the differences; and relative change at which the least squares end.
"""


def law_strengths(
    pressure: Floats, values: Mapping[str, float], slip: Floats | float = np.inf
) -> tuple[Floats, Floats]:
    """Peak and residual strength of the law on two rigid sides, of which the slip climbs one, (n,) each.

    pressure (n,).  slip (n,): at which the residual strength is read.  The slope T is crushed to rho T,
    rho = log(1 + x)/x with x = (p/crush)(1 - mu (1 - rho) T) and the pressure p on the plane
    (docs/extensions.md, section 7); with a height it is rho T exp(-slip T/H) at the residual strength, and
    without one it has ended there.  A bond sigma0 is added to the peak.
    """
    mu, slope = values["mu"], float(np.tan(np.radians(values.get("theta", 0.0))))
    crush, height, share = values.get("crush", 0.0), values.get("height", 0.0), np.ones_like(pressure)
    if crush > 0.0 and slope > 0.0:
        low, high = np.zeros_like(pressure), np.ones_like(pressure)
        for _ in range(HALVINGS):
            share = 0.5 * (low + high)
            t = share * slope
            free = np.maximum(1.0 - mu * t, 1e-12)
            x = 2.0 * pressure / crush * np.sqrt(1.0 + t * t) / free * np.maximum(1.0 - mu * (slope - t), 0.0)
            above = share * x > np.log1p(x)
            low, high = np.where(above, low, share), np.where(above, share, high)
    left = np.exp(-np.asarray(slip) * slope / height) if height > 0.0 else 0.0
    peak, residual = (_climbing(pressure, mu, share * slope * part) for part in (1.0, left))
    return values.get("sigma0", 0.0) + peak, residual


def levels_of(pressure: Floats) -> int:
    """Number of different pressures."""
    return int(np.unique(np.round(pressure / pressure.max(), 6)).size)


def law_peak(pressure: Floats, values: Mapping[str, float]) -> Floats:
    """Peak strength of `law_strengths`."""
    return law_strengths(pressure, values)[0]


def _climbing(pressure: Floats, mu: float, slope: Floats) -> Floats:
    """Strength of a slip that climbs a slope; a thousand times the pressure where it locks."""
    free = 1.0 - mu * slope
    return np.asarray(pressure * np.where(free > 0.0, (mu + slope) / np.maximum(free, 1e-3), 1e3))


MODELS = {
    ("mu",): ROCK,
    ("mu", "theta"): ROCK,
    ("mu", "theta", "crush"): ROCK,
    ("mu", "theta", "crush", "height"): ROCK,
    ("mu", "sigma0"): MORTAR,
}
"""Free constants of the models, and the form of the joint."""

KNOWN = ("mu", "theta", "crush", "height", "sigma0")
"""Constants that the closed form has."""


@dataclass(eq=False)
class StrengthFit:
    """Constants of the law from strengths, criteria beside it, and the judgement of all.

    estimates: constants with intervals.  peaks: intervals of the peak at each test.  fitted, blind: measured
    and predicted strengths, in the second list predicted by the other tests.  errors: root mean square error
    of each kind, as each strength is a single number.  others: name, constants, root mean square error of the
    peaks, fitted and blind, of each criterion, the law first.  loose: constants that are not determined,
    while the strengths between the pressures of the tests are.
    """

    tests: Sequence[Strength]
    free: tuple[str, ...]
    values: dict[str, float]
    estimates: dict[str, Estimate]
    peaks: list[Estimate]
    fitted: list[Comparison]
    blind: list[Comparison]
    errors: dict[str, float]
    grade: str
    reasons: list[str]
    notes: list[str]
    others: list[tuple[str, dict[str, float], float, float]]
    covariance: Floats
    loose: list[str]

    @property
    def is_result(self) -> bool:
        """Whether the constants may be used."""
        return not self.reasons

    @property
    def model_error(self) -> float:
        """Root mean square of the blind relative errors of peaks and residual strengths."""
        errors = [error for row in self.blind for error in row.errors.values()]
        return float(np.sqrt(np.mean(np.square(errors))))

    def peak(self, pressure: Floats) -> Floats:
        """Peak strength of the law over the pressure (n,)."""
        return law_peak(np.asarray(pressure, dtype=float), self.values)


def fit_strengths(
    tests: Sequence[Strength], joint: str = AUTO, fixed: Mapping[str, float] | None = None
) -> StrengthFit:
    """Constants of the law from peaks, or from peaks and residual strengths, as in `fit`.

    The residual strength is mu times the pressure: the slope has ended there.  Raises ValueError for
    inadmissible values and fewer than three tests.

    Examples
    --------
    >>> from asperity.tools.fit.strengths import Strength, fit_strengths
    >>> tests = [Strength(f"{p}", -p, 0.3 + 0.7 * p) for p in (0.2, 0.6, 1.0, 1.5)]
    >>> fit = fit_strengths(tests)
    >>> {name: round(estimate.value, 3) for name, estimate in fit.estimates.items()}
    {'mu': 0.7, 'sigma0': 0.3}
    """
    proper = isinstance(tests, Sequence) and all(isinstance(test, Strength) for test in tests)
    if not proper:
        raise ValueError(f"tests = {contract.shown(tests)}: expected a list of strengths")
    if joint not in (ROCK, MORTAR, AUTO):
        raise ValueError(f"joint = {joint!r}: expected {ROCK}, {MORTAR} or {AUTO}")
    different = list(
        {(test.sigma_N, test.peak, str(test.residual)): test for test in reversed(tests)}.values()
    )[::-1]
    copies = len(tests) - len(different)
    text = f"{len(tests)} tests" + (f", {copies} of them the same as others" if copies else "")
    if len(different) < LEAST_TESTS:
        raise ValueError(f"{text}: expected at least {LEAST_TESTS} different ones")
    known = {name: contract.number(name, value) for name, value in (fixed or {}).items()}
    unknown = next((name for name in known if name not in KNOWN), "")
    if unknown:
        raise ValueError(f"fixed: {unknown}: strengths alone have only {', '.join(KNOWN)}")
    check_known(known)
    data = _Data(different, known)
    # a model without a constant that is known would contradict it; a slope may be crushed and end
    has = {free: {*free, "crush", "height"} if "theta" in free else {*free} for free in MODELS}
    models = [free for free, form in MODELS.items() if joint in (AUTO, form) and {*known} <= has[free]]
    models = [tuple(name for name in free if name not in known) for free in models]
    models = [free for free in dict.fromkeys(models) if free and data.shows(free)]
    if not models:
        raise ValueError("the strengths show nothing beside what is known, or no model has all of that")
    solutions = [data.solve(free) for free in models]
    bic = [data.criterion(x, free) for x, free in zip(solutions, models, strict=True)]
    best = int(np.argmin(bic))
    order = sorted(range(len(models)), key=lambda i: (len(models[i]), bic[i]))
    best = next(i for i in order if bic[i] <= bic[best] + GAIN * (len(models[best]) - len(models[i])))
    fit = _judged(data, models[best], solutions[best])
    if copies:
        fit.notes.append(f"{copies} of {len(tests)} tests are the same as others: each counts once")
    return fit


class _Data:
    """Strengths as arrays, and least squares of relative errors."""

    def __init__(self, tests: Sequence[Strength], known: Mapping[str, float]) -> None:
        self.tests, self.known = list(tests), dict(known)
        self.pressure = np.array([-test.sigma_N for test in tests])
        self.peak = np.array([test.peak for test in tests])
        self.residual = np.array([test.residual for test in tests])
        self.seen = np.isfinite(self.residual)
        self.slip = np.array([test.slip for test in tests])

    def shows(self, free: tuple[str, ...]) -> bool:
        """Whether there are data enough: one more than the constants, and residuals for a slope alone."""
        several = self.levels > 1 or not {"crush", "sigma0"} & {*free}
        slope = "theta" not in free or "crush" in free or bool(self.seen.any())
        # the slope that is left at the residual strength shows the height
        ends = "height" not in free or bool(self.seen.any() and np.isfinite(self.slip[self.seen]).all())
        return several and slope and ends and len(free) + 1 < self.peak.size + int(self.seen.sum())

    @property
    def levels(self) -> int:
        """Number of different pressures."""
        return levels_of(self.pressure)

    def ends(self, free: tuple[str, ...]) -> Floats:
        """Bounds on the scales, (2, p)."""
        size = float(max(self.peak.max(), self.pressure.max()))
        length = float(np.nanmax(self.slip)) if np.isfinite(self.slip).any() else 1.0
        return np.transpose([to_scale(name, plausible(name, size, length)) for name in free])

    def values(self, x: Floats, free: tuple[str, ...]) -> dict[str, float]:
        """Constants by name."""
        return self.known | {
            name: float(from_scale(name, value)) for name, value in zip(free, x, strict=True)
        }

    def errors(self, x: Floats, free: tuple[str, ...]) -> Floats:
        """Relative errors of peaks and residuals, without those that were not measured."""
        values = self.values(x, free)
        peak, residual = law_strengths(self.pressure, values, self.slip)
        of_peak, of_residual = peak / self.peak - 1.0, (residual / self.residual - 1.0)[self.seen]
        errors: Floats = np.clip(np.concatenate([of_peak, of_residual]), -10.0, 10.0)
        return errors

    def solve(self, free: tuple[str, ...], start: Floats | None = None) -> Floats:
        """Constants on their scales with the smallest sum of squares."""
        from scipy.optimize import least_squares

        low, high = self.ends(free)
        ratio = float(np.median(self.peak / self.pressure))
        mu = float(np.median((self.residual / self.pressure)[self.seen])) if self.seen.any() else 0.7 * ratio
        guess = {"mu": mu, "sigma0": 0.2 * float(self.peak.min())}
        length = float(np.nanmax(self.slip)) if np.isfinite(self.slip).any() else 1.0
        starts = [start] if start is not None else []
        for part in ((0.0, 5.0),) if "theta" not in free else ((10.0, 5.0), (25.0, 1.0)):
            theta, crush = part
            whole = guess | {
                "theta": theta,
                "crush": crush * float(self.pressure.max()),
                "height": 0.3 * length,
            }
            if start is None:
                starts.append(np.array([float(to_scale(name, whole[name])) for name in free]))
        margin, tried = 1e-6 * (high - low), []
        for x in starts:
            settings = {"x_scale": "jac", "max_nfev": 100, "diff_step": STEP, "ftol": FOUND, "xtol": FOUND}
            inside = np.clip(x, low + margin, high - margin)
            tried.append(least_squares(self.errors, inside, bounds=(low, high), args=(free,), **settings))
        return np.asarray(min(tried, key=lambda solution: float(solution.cost)).x)

    def criterion(self, x: Floats, free: tuple[str, ...]) -> float:
        """Information criterion (BIC); differences below a thousandth are none."""
        errors = self.errors(x, free)
        return float(errors.size * np.log(np.mean(errors**2) + 1e-6) + len(free) * np.log(errors.size))

    def without(self, number: int) -> _Data:
        """The other tests."""
        return _Data([test for i, test in enumerate(self.tests) if i != number], self.known)

    def compared(self, values: Mapping[str, float], only: int | None = None) -> list[Comparison]:
        """Measured and predicted strengths."""
        made = []
        for i, test in enumerate(self.tests):
            if only is not None and i != only:
                continue
            pressure = np.array([-test.sigma_N])
            measured = {"peak": test.peak} | ({"residual": test.residual} if self.seen[i] else {})
            peak, residual = law_strengths(pressure, values, np.array([test.slip]))
            predicted = {"peak": float(peak[0]), "residual": float(residual[0])}
            errors = {name: abs(predicted[name] / value - 1.0) for name, value in measured.items()}
            made.append(Comparison(test.name, measured, {name: predicted[name] for name in measured}, errors))
        return made


def _judged(data: _Data, free: tuple[str, ...], x: Floats) -> StrengthFit:
    """The fit of one model, with intervals by leaving out one test after the other, and its grade."""
    from scipy.stats import t as student

    count = len(data.tests)
    values = data.values(x, free)
    rest = [data.without(i).solve(free, x) for i in range(count)]
    moved = np.array(rest) - x
    covariance = (count - 1) / count * moved.T @ moved
    quantile = float(student.ppf(0.5 + 0.5 * CONFIDENCE, max(1, count - len(free))))
    low, high = data.ends(free)
    estimates = {}
    for i, name in enumerate(free):
        half = quantile * float(np.sqrt(covariance[i, i]))
        ends = np.clip([x[i] - half, x[i] + half], low[i], high[i])
        estimates[name] = Estimate(values[name], *(float(end) for end in from_scale(name, ends)))
    fitted, unseen = data.compared(values), []
    curves = []
    for i, constants in enumerate(rest):
        of_rest = data.values(constants, free)
        unseen += data.compared(of_rest, i)
        curves.append(np.log(law_peak(data.pressure, of_rest)))
    here = np.log(law_peak(data.pressure, values))
    halves = quantile * np.sqrt((count - 1) / count * np.sum((np.array(curves) - here) ** 2, axis=0))
    errors: dict[str, float] = {}
    for label, rows in (("", fitted), ("blind ", unseen)):
        for name in ("peak", "residual"):
            missed = [row.errors[name] for row in rows if name in row.errors]
            if missed:
                errors[label + name] = float(np.sqrt(np.mean(np.square(missed))))
    # the misfit of the law is part of what a peak may be
    halves = np.hypot(halves, 2.0 * errors["blind peak"])
    peaks = [Estimate(*np.exp([a, a - h, a + h]).tolist()) for a, h in zip(here, halves, strict=True)]
    grade, worst = grade_of(max(errors.values())), max(errors, key=lambda name: errors[name])
    reasons = [f"the law misses the {worst} by {errors[worst]:.0%}"] if grade == "poor" else []
    notes: list[str] = []
    loose: list[str] = []
    for i, (name, estimate) in enumerate(estimates.items()):
        bound = min(x[i] - low[i], high[i] - x[i]) < 1e-3 * (high[i] - low[i])
        if estimate.high > FACTOR**2 * estimate.low or bound:
            loose.append(name)
            text = f"{name} is not determined: {estimate.value:.3g} [{estimate.low:.3g}, {estimate.high:.3g}]"
            if name == "mu" and bound:
                reasons.append(f"{text}: the strength does not grow with the pressure")
                continue
            alone = name == "mu" and data.seen.any()
            (reasons if alone else notes).append(
                f"{text}; the strengths hold between the pressures of the tests"
            )
    total = count + int(data.seen.sum())
    if total < len(free) + 2:
        reasons.append(f"{total} strengths for {len(free)} constants: further tests are needed")
    if "sigma0" in free:
        notes.append(
            "a bond sigma0 is c, and mu is tan(phi), of c + phi: such a line extrapolates worse "
            "than it interpolates"
        )
    if data.levels == 1:
        notes.append("one pressure: nothing is known about the strength at others")
    if data.known.get("mu") == 0.0:
        notes.append(
            "mu = 0 was given: a joint without friction, with the strength of its slope or bond alone"
        )
    if not data.seen.any():
        notes.append("peaks alone: mu is that of the peaks, not of the residual strength")
    return StrengthFit(
        data.tests, free, values, estimates, peaks, fitted, unseen, errors, grade, reasons, notes,
        _others(data, fitted, unseen), covariance * (quantile / 1.959964) ** 2, loose,
    )  # fmt: skip


def _others(
    data: _Data, fitted: Sequence[Comparison], unseen: Sequence[Comparison]
) -> list[tuple[str, dict[str, float], float, float]]:
    """The law, then the criteria of others with constants enough data for, with their errors of the peaks."""

    def rms(errors: Sequence[float]) -> float:
        return float(np.sqrt(np.mean(np.square(errors))))

    criteria: list[tuple[str, dict[str, float], float, float]] = [
        ("law", {}, rms([row.errors["peak"] for row in fitted]), rms([row.errors["peak"] for row in unseen]))
    ]
    line: dict[str, float] | None = None
    for criterion in CRITERIA:
        # as many constants as pressures meet any peaks
        if data.levels < len(criterion.names) or data.peak.size <= len(criterion.names):
            continue
        values = criterion.fit(data.pressure, data.peak, line=line)
        line = line or values
        left = criterion.strength(data.pressure, values) / data.peak - 1.0
        missed: list[float] = []
        for i in range(data.peak.size) if data.peak.size > len(criterion.names) + 1 else ():
            kept = np.arange(data.peak.size) != i
            if levels_of(data.pressure[kept]) < len(criterion.names):
                missed = []
                break
            constants = criterion.fit(data.pressure[kept], data.peak[kept], values)
            missed.append(float(criterion.strength(data.pressure[[i]], constants)[0] / data.peak[i] - 1.0))
        criteria.append((criterion.label, values, rms(left.tolist()), rms(missed) if missed else np.nan))
    return criteria
