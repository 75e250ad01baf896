"""Strengths of tests without their curves: lines and powers of friction beside the law, and their choice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ... import contract
from ...contract import Floats
from .intervals import Estimate, quantiles
from .model import AUTO, MORTAR, ROCK, from_scale, plausible, to_scale
from .rigid import law_peak, law_strengths
from .search import check_known, least
from .strength import Strength
from .thresholds import (
    BOUND_DISTANCE,
    FACTOR,
    FITTED,
    FLOOR,
    GAIN_OF_STRENGTHS,
    GOOD,
    LEAST_REPLICATES,
    LEAST_TESTS,
    NO_WIDTH,
    NORMAL,
    STEP,
)
from .verdict import Comparison, grade_of, without_spread


def levels_of(pressure: Floats) -> int:
    """Number of different pressures."""
    return int(np.unique(np.round(pressure / max(float(np.abs(pressure).max()), 1e-300), 6)).size)


MODELS = {
    ("mu",): ROCK,
    ("mu", "theta"): ROCK,
    ("mu", "theta", "crush"): ROCK,
    ("mu", "theta", "crush", "height"): ROCK,
    ("mu", "sigma0"): MORTAR,
    ("mu", "sigma0", "sigma02"): MORTAR,
    ("mu", "theta", "sigma0"): MORTAR,
    ("sigma0",): MORTAR,
    ("sigma0", "sigma02"): MORTAR,
}
"""Free constants of the models, and the form of the joint."""

OF_STRENGTHS = ("mu", "theta", "crush", "height", "sigma0", "sigma02")
"""Constants that the closed form has."""


@dataclass(eq=False)
class StrengthFit:
    """Constants of the law from strengths, and their judgement.

    estimates: constants with intervals.  peaks: intervals of the peak at each test.  fitted, blind: measured
    and predicted strengths, in the second list predicted by the other tests.  errors: root mean square error
    of each kind, as each strength is a single number.  loose: constants that are not determined, while the
    strengths between the pressures of the tests are.
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
    covariance: Floats
    loose: list[str]

    @property
    def is_result(self) -> bool:
        """Whether the constants may be used."""
        return not self.reasons

    @property
    def model_error(self) -> tuple[float, float]:
        """Relative errors of tau and of the dilation: root mean square of the blind ones, and none."""
        errors = [error for row in self.blind for error in row.errors.values()]
        return float(np.sqrt(np.mean(np.square(errors)))), 0.0

    @property
    def model_text(self) -> str:
        """Form of the joint and its free constants."""
        form = "with bond" if "sigma0" in self.free else "without bond"
        return f"joint {form}, closed form of the strengths; free: {', '.join(self.free)}"

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
    different = _once(tests)
    times = len(tests) // max(1, len(different))
    text = f"{len(different)} tests" + (f", each {times} times" if times > 1 else "")
    if len(different) < LEAST_TESTS:
        raise ValueError(f"{text}: expected at least {LEAST_TESTS} tests")
    known = {name: contract.number(name, value) for name, value in (fixed or {}).items()}
    unknown = next((name for name in known if name not in OF_STRENGTHS), "")
    if unknown:
        raise ValueError(f"fixed: {unknown}: strengths alone have only {', '.join(OF_STRENGTHS)}")
    check_known(known)
    data = _Data(different, known)
    if not (data.pressure > 0.0).any():
        # without a pressure no row shows the friction
        data.known.setdefault("mu", 0.0)
    # a model without a constant that is known would contradict it; a slope may be crushed and end
    has = {free: {*free, "crush", "height"} if "theta" in free else {*free} for free in MODELS}
    models = [free for free, form in MODELS.items() if joint in (AUTO, form) and {*known} <= has[free]]
    models = [tuple(name for name in free if name not in known) for free in models]
    models = [free for free in dict.fromkeys(models) if free and data.shows(free)]
    if not models:
        raise ValueError("the strengths show nothing beside what is known, or no model has all of that")
    solutions = [data.solve(free) for free in models]
    bic = [data.criterion(x, free) for x, free in zip(solutions, models, strict=True)]
    # a slope beside a bond is that of a joint which shows its bond without one
    sloped = [i for i, free in enumerate(models) if {"theta", "sigma0"} <= {*free, *known}]
    best = _smallest(models, bic, [i for i in range(len(models)) if i not in sloped] or sloped)
    if "sigma0" in models[best]:
        best = _smallest(models, bic, [best, *sloped])
    fit = _judged(data, models[best], solutions[best])
    if times > 1:
        fit.notes.append(f"every row of the table stands there {times} times: each counts once")
    return fit


def _smallest(models: Sequence[tuple[str, ...]], bic: Sequence[float], places: Sequence[int]) -> int:
    """Place of the model, of some, that no larger one of them beats by enough for each constant it adds."""
    best = min(places, key=lambda i: bic[i])
    order = sorted(places, key=lambda i: (len(models[i]), bic[i]))
    return next(
        i for i in order if bic[i] <= bic[best] + GAIN_OF_STRENGTHS * (len(models[best]) - len(models[i]))
    )


def _once(tests: Sequence[Strength]) -> list[Strength]:
    """The tests, each once where all of them are there equally often: the table was read twice.

    Replicates with the same rounded numbers are specimens, and all count.
    """
    first: dict[tuple[float, str, str], Strength] = {}
    times: dict[tuple[float, str, str], int] = {}
    for test in tests:
        key = (test.sigma_N, str(test.peak), str(test.residual))
        first.setdefault(key, test)
        times[key] = times.get(key, 0) + 1
    copied = len({*times.values()}) == 1 and len(first) >= LEAST_TESTS
    return list(first.values()) if copied else list(tests)


class _Data:
    """Strengths as arrays, and least squares of relative errors."""

    def __init__(self, tests: Sequence[Strength], known: Mapping[str, float]) -> None:
        self.tests, self.known = list(tests), dict(known)
        self.pressure = np.array([-test.sigma_N for test in tests])
        self.shear = np.array([test.peak for test in tests])
        self.tension = np.maximum(0.0, -self.pressure)
        # a tensile test has no shear strength: its number is the traction itself
        self.peak = np.where(self.shear > 0.0, self.shear, self.tension)
        self.residual = np.array([test.residual for test in tests])
        self.seen = np.isfinite(self.residual) & (self.pressure >= 0.0)
        self.slip = np.array([test.slip for test in tests])

    def shows(self, free: tuple[str, ...]) -> bool:
        """Whether there are data enough: more than the constants, and those that show each of them."""
        several = self.levels > 1 or not ({"crush"} & {*free} or {"mu", "sigma0"} <= {*free})
        slope = "theta" not in free or "crush" in free or bool(self.seen.any())
        # the slope that is left at the residual strength shows the height
        ends = "height" not in free or bool(self.seen.any() and np.isfinite(self.slip[self.seen]).all())
        # only tension tells the tensile strength of a bond from its cohesion
        pulled, pressed = bool((self.pressure < 0.0).any()), bool((self.pressure > 0.0).any())
        bond = "sigma02" not in free or (pulled and bool((self.shear > 0.0).any()))
        friction = pressed if "mu" in free else "mu" in self.known
        # a bond on a slope has no closed form in tension
        flat = not {"theta", "sigma0"} <= {*free} or not pulled
        count = self.peak.size + int(self.seen.sum())
        enough = len(free) < count if {*free} <= {"mu", "sigma0"} else len(free) + 1 < count
        return several and slope and ends and bond and friction and flat and enough

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

    def predicted(self, values: Mapping[str, float]) -> tuple[Floats, Floats]:
        """Predicted peak, or traction of a tensile test, and residual strength of each test, (n,) each.

        In tension the ratio of shear to tension is that of the test.
        """
        peak, residual = law_strengths(np.maximum(self.pressure, 0.0), values, self.slip)
        bond = values.get("sigma0", 0.0)
        along = values.get("sigma02", 0.0) or bond
        used = np.hypot(self.tension / max(bond, 1e-300), self.shear / max(along, 1e-300))
        pulled = self.tension > 0.0
        return np.where(pulled, self.peak / np.where(pulled, used, 1.0), peak), residual

    def errors(self, x: Floats, free: tuple[str, ...]) -> Floats:
        """Relative errors of peaks and residuals, without those that were not measured."""
        return np.clip(np.concatenate(self.missed(self.values(x, free))), -10.0, 10.0)

    def missed(self, values: Mapping[str, float]) -> tuple[Floats, Floats]:
        """Relative errors of peaks (n,) and of the residual strengths that were measured."""
        peak, residual = self.predicted(values)
        sizes = np.maximum(self.residual, FLOOR * self.peak)
        return peak / self.peak - 1.0, ((residual - self.residual) / sizes)[self.seen]

    def solve(self, free: tuple[str, ...], start: Floats | None = None) -> Floats:
        """Constants on their scales with the smallest sum of squares."""
        low, high = self.ends(free)
        pressed = self.pressure > 0.0
        ratio = (
            float(np.median((self.peak / np.where(pressed, self.pressure, 1.0))[pressed]))
            if pressed.any()
            else 1.0
        )
        of_residual = self.seen & pressed & (self.residual > 0.0)
        mu = (
            float(np.median((self.residual / np.where(pressed, self.pressure, 1.0))[of_residual]))
            if of_residual.any()
            else 0.7 * ratio
        )
        guess = {"mu": mu, "sigma0": 0.2 * float(self.peak.min())}
        pulled = self.pressure < 0.0
        if pulled.any():
            guess["sigma0"] = float(self.tension.max())
        guess["sigma02"] = float(self.shear.max())
        length = float(np.nanmax(self.slip)) if np.isfinite(self.slip).any() else 1.0
        starts = [start] if start is not None else []
        for part in ((0.0, 5.0),) if "theta" not in free else ((10.0, 5.0), (25.0, 1.0)):
            theta, crush = part
            constants = guess | {
                "theta": theta,
                "crush": crush * float(self.pressure.max()),
                "height": 0.3 * length,
            }
            if start is None:
                starts.append(np.array([float(to_scale(name, constants[name])) for name in free]))
        tries = (
            least(
                lambda at: self.errors(at, free),
                x,
                np.array([low, high]),
                FITTED,
                STEP,
            )
            for x in starts
        )
        return min(tries, key=lambda tried: float(tried[1] @ tried[1]))[0]

    def criterion(self, x: Floats, free: tuple[str, ...]) -> float:
        """Information criterion (BIC); differences below a thousandth are none."""
        errors = self.errors(x, free)
        return float(errors.size * np.log(np.mean(errors**2) + 1e-6) + len(free) * np.log(errors.size))

    def covariance(self, x: Floats, free: tuple[str, ...]) -> Floats:
        """Covariance (p, p) of the constants by the misfit, as if it were noise."""
        errors = self.errors(x, free)
        moves = STEP * np.maximum(1.0, np.abs(x))
        columns = [
            (self.errors(x + move, free) - self.errors(x - move, free)) / (2.0 * size)
            for move, size in zip(np.diag(moves), moves, strict=True)
        ]
        slopes = np.transpose(columns)
        inverse = np.linalg.pinv(slopes.T @ slopes, rcond=1e-12).astype(float)
        return np.asarray(float(errors @ errors) / max(1, errors.size - x.size) * inverse)

    def spread(self) -> float:
        """Relative standard deviation of the peaks of replicates about their means, 0 without any."""
        names, logs = (
            np.round(self.pressure / max(float(np.abs(self.pressure).max()), 1e-300), 6),
            np.log(self.peak),
        )
        groups = [logs[names == name] for name in {*names.tolist()}]
        freedom = logs.size - len(groups)
        if freedom < LEAST_REPLICATES:
            return 0.0
        return float(np.sqrt(sum(float(np.sum((g - g.mean()) ** 2)) for g in groups) / freedom))

    def grows(self) -> bool:
        """Whether the peaks grow with the pressure along a line, beyond their relative scatter about it.

        With one degree of freedom they show no scatter, and the widths of the strengths decide.
        """
        sheared = (self.shear > 0.0) & (self.pressure >= 0.0)
        pressure, peak = self.pressure[sheared], self.peak[sheared]
        freedom = peak.size - 2
        if freedom < 0 or levels_of(pressure) < 2:
            return False
        columns = np.column_stack([np.ones_like(pressure), pressure]) / peak[:, None]
        line = np.linalg.lstsq(columns, np.ones_like(peak))[0]
        missed = columns @ line - 1.0
        variance = float(missed @ missed) / max(1, freedom) * np.linalg.inv(columns.T @ columns)[1, 1]
        beyond = float(quantiles([freedom])[0]) if freedom > 1 else 0.0
        return bool(line[1] > beyond * np.sqrt(variance))

    def without(self, number: int) -> _Data:
        """The other tests."""
        return _Data([test for i, test in enumerate(self.tests) if i != number], self.known)

    def compared(self, values: Mapping[str, float], only: int | None = None) -> list[Comparison]:
        """Measured and predicted strengths."""
        comparisons = []
        peak, residual = self.predicted(values)
        for i, test in enumerate(self.tests):
            if only is not None and i != only:
                continue
            main = "peak" if test.peak > 0.0 else "tension"
            measured = {main: float(self.peak[i])} | ({"residual": test.residual} if self.seen[i] else {})
            predicted = {main: float(peak[i]), "residual": float(residual[i])}
            sizes = {main: float(self.peak[i]), "residual": max(test.residual, FLOOR * test.peak)}
            errors = {name: abs(predicted[name] - value) / sizes[name] for name, value in measured.items()}
            comparisons.append(
                Comparison(test.name, measured, {name: predicted[name] for name in measured}, errors)
            )
        return comparisons


def _judged(data: _Data, free: tuple[str, ...], x: Floats) -> StrengthFit:
    """The fit of one model, its grade, and intervals by misfit or tests left out, the wider."""
    count, values = len(data.tests), data.values(x, free)
    rest = [data.without(i).solve(free, x) for i in range(count)]
    moved = np.array(rest) - x
    # with one degree of freedom the others meet a curve exactly, whatever their noise is; a misfit has the
    # freedom of all data, of which a test with a residual strength has two
    freedom, data_left = max(1, count - len(free)), max(1, data.errors(x, free).size - len(free))
    of_tests, of_data = quantiles([freedom, data_left]).tolist()
    several = of_tests**2 * (count - 1) / count if freedom > 1 else 0.0
    left_out, by_misfit = several * moved.T @ moved, of_data**2 * data.covariance(x, free)
    sizes = np.sqrt(np.maximum(np.diag(left_out), np.diag(by_misfit)))
    ends = np.clip([x - sizes, x + sizes], *data.ends(free))
    estimates = {
        name: Estimate(values[name], *(float(end) for end in from_scale(name, ends[:, i])))
        for i, name in enumerate(free)
    }
    fitted, unseen = data.compared(values), []
    for i, constants in enumerate(rest):
        unseen += data.compared(data.values(constants, free), i)
    peaks = _peaks(data, free, x, several * _squares(data, free, x, rest), by_misfit, unseen)
    errors: dict[str, float] = {}
    for label, rows in (("", fitted), ("blind ", unseen)):
        for name in ("peak", "tension", "residual"):
            missed = [row.errors[name] for row in rows if name in row.errors]
            if missed:
                errors[label + name] = float(np.sqrt(np.mean(np.square(missed))))
    spread = data.spread()
    # with one degree of freedom a blind number says nothing about the law, and the widths decide
    beyond = {
        name: without_spread(error, 0.0 if "residual" in name else spread)
        for name, error in errors.items()
        if freedom > 1 or "blind" not in name
    }
    grade, worst = grade_of(max(beyond.values())), max(beyond, key=lambda name: beyond[name])
    reasons = [f"the law misses the {worst} by {errors[worst]:.0%}"] if grade == "poor" else []
    notes: list[str] = []
    if spread > GOOD:
        notes.append(
            f"specimens at one pressure differ by {spread:.0%} (standard deviation), which the grade "
            "leaves out"
        )
    flat = [name for name, size in zip(free, sizes, strict=True) if size < NO_WIDTH]
    reasons += _of_widths(flat, peaks, max(errors.values()))
    loose = []
    for name, is_reason, text in _undetermined(data, free, x, estimates, grade != "poor"):
        loose.append(name)
        (reasons if is_reason else notes).append(text)
    notes += _remarks(data, free, values)
    covariance = scaled_to(sizes, left_out, by_misfit) / NORMAL**2
    return StrengthFit(
        data.tests, free, values, estimates, peaks, fitted, unseen, errors, grade, reasons, notes,
        covariance, loose,
    )  # fmt: skip


def _logs(data: _Data, free: tuple[str, ...], x: Floats) -> Floats:
    """Logarithms of the peaks (n,) with these constants."""
    return np.asarray(np.log(np.maximum(data.predicted(data.values(x, free))[0], 1e-300)))


def _squares(data: _Data, free: tuple[str, ...], x: Floats, rest: Sequence[Floats]) -> Floats:
    """Squares (n,) by which the logarithms of the peaks move without each of the tests."""
    moved = np.array([_logs(data, free, at) for at in rest]) - _logs(data, free, x)
    return np.asarray(np.sum(moved**2, axis=0))


def _peaks(
    data: _Data,
    free: tuple[str, ...],
    x: Floats,
    by_rest: Floats,
    by_misfit: Floats,
    unseen: Sequence[Comparison],
) -> list[Estimate]:
    """Intervals of the peaks, of which the misfit of the law is a part.

    by_rest (n,): variance of their logarithms by the tests left out; by_misfit (p, p): of the constants.
    """
    here, moves = _logs(data, free, x), STEP * np.eye(x.size)
    slopes = np.array([
        (_logs(data, free, x + move) - _logs(data, free, x - move)) / (2.0 * STEP)
        for move in moves
    ])  # fmt: skip
    variance = np.maximum(by_rest, np.einsum("in,ij,jn->n", slopes, by_misfit, slopes))
    of_peaks = [row.errors[name] for row in unseen for name in ("peak", "tension") if name in row.errors]
    halves = np.hypot(np.sqrt(variance), 2.0 * float(np.sqrt(np.mean(np.square(of_peaks)))))
    return [Estimate(*np.exp([a, a - h, a + h]).tolist()) for a, h in zip(here, halves, strict=True)]


def _of_widths(flat: Sequence[str], peaks: Sequence[Estimate], error: float) -> Iterator[str]:
    """Reasons why the strengths are no result; flat: constants whose interval has no width.

    error: the largest one of the law.
    """
    wide = max(peaks, key=lambda peak: peak.high / max(peak.low, 1e-300))
    if flat:
        text = "the strengths do not show it"
        if error < GOOD:
            text = "the strengths lie on the law to their last digit, as computed or copied numbers do"
        yield f"the interval of {', '.join(flat)} has no width: {text}"
    elif wide.high / max(wide.low, 1e-300) > FACTOR**2:
        text = f"{wide.value:.3g} [{wide.low:.3g}, {wide.high:.3g}]"
        yield f"the strengths are not determined, one of them {text}: further tests would show them"


def _undetermined(
    data: _Data, free: tuple[str, ...], x: Floats, estimates: Mapping[str, Estimate], met: bool
) -> Iterator[tuple[str, bool, str]]:
    """Constants that are not determined, whether that is a reason why there is no result, and a sentence.

    met: whether the law meets the strengths.
    """
    low, high = data.ends(free)
    for i, name in enumerate(free):
        estimate = estimates[name]
        bound = min(x[i] - low[i], high[i] - x[i]) < BOUND_DISTANCE * (high[i] - low[i])
        if estimate.high <= FACTOR**2 * estimate.low and not bound:
            continue
        text = f"{name} is not determined: {estimate.value:.3g} [{estimate.low:.3g}, {estimate.high:.3g}]"
        if name == "mu" and not data.grows():
            yield name, True, f"{text}: the strength does not grow with the pressure beyond its scatter"
        else:
            held = f"{text}; the strengths hold between the pressures of the tests" if met else text
            yield name, name == "mu" and bool(data.seen.any()), held


def _remarks(data: _Data, free: tuple[str, ...], values: Mapping[str, float]) -> Iterator[str]:
    """Notes that a reader needs to use the constants."""
    if "sigma02" in free:
        yield "sigma0 is the tensile strength, and sigma02 is c"
    elif "theta" in free and "sigma0" in free:
        c = float(law_peak(np.zeros(1), values)[0])
        yield (
            f"mu is the friction of the residual strengths, and c = {c:.3g} that of the peaks at no pressure"
        )
    if {"sigma0", "mu"} <= {*free} and "theta" not in free:
        bond = "sigma02" if "sigma02" in free else "sigma0"
        yield (
            f"a bond {bond} is c, and mu is tan(phi), of c + phi: such a line extrapolates worse "
            "than it interpolates"
        )
    if data.levels == 1:
        yield "one pressure: nothing is known about the strength at others"
    if not (data.pressure > 0.0).any():
        yield (
            "no pressure: nothing is known about the friction; the case assumes mu = 0"
            if not data.known.get("mu")
            else "no pressure: the given mu is assumed"
        )
    elif data.known.get("mu") == 0.0:
        yield "mu = 0 was given: a joint without friction, with the strength of its slope or bond alone"
    if not data.seen.any() and "mu" in free:
        yield "peaks alone: mu is that of the peaks, not of the residual strength"


def scaled_to(sizes: Floats, *covariances: Floats) -> Floats:
    """Covariance (p, p) with these standard deviations and the correlations of the largest of some."""
    matrix = max(covariances, key=lambda one: float(np.trace(one)))
    deviations = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    factors = np.divide(sizes, deviations, out=np.ones_like(deviations), where=deviations > 0.0)
    return np.asarray(matrix * np.outer(factors, factors))
