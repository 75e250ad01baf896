"""Whether a fit is a result, and which fit to try next where it is not."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from .model import SIDES
from .outcome import ENOUGH, LEAST_ERROR, Fit

POOR = 0.2
"""Scatter, as a fraction of the range of a test, above which correlated residuals are called a poor fit."""

OUTLYING, ALONE = 6.0, 0.5
"""Residual of an outlier in robust standard deviations, and the most of its neighbours, as a part of it."""

MOVED = 1.0
"""Change of a constant, in standard errors, above which an outlier makes the fit no result."""

ROBUST = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""

PATTERNS = (SIDES, 2, 0)
"""Inclined planes of the patterns that are tried where the user has given none."""

LARGEST_ERROR = 0.1
"""Largest scatter, as a fraction of the range, that is proposed to be accepted."""

BETTER, AS_GOOD = 0.9, 1.05
"""Ratio of two sums of squares below which another fit is preferred; the second one if it is a result."""

CUSTOMARY = {"flat": (1.0 / 3.0,), "kc": (20.0, 100.0, 1.0), "eta": (0.9,)}
CUSTOMARY |= {"height": (0.0,), "W0": (0.0,), "crush": (0.0,)}
"""Values of constants that the tests do not determine: the first one inside the interval, or 0 for none."""

SEVERAL = 1.2
"""Ratio of two pressures at which strength over pressure is compared."""

MOST_CHANGES = 6
"""Largest number of changes of the arguments that are tried one after the other."""

Arguments = dict[str, Any]
"""Arguments of `fit`, by name."""

Fitted = Callable[[Arguments], Fit]
"""Function that fits the same tests with other arguments."""


class Outlier(NamedTuple):
    """Row that the fit misses by far more than its neighbours; moves: constants, in standard errors."""

    place: str
    text: str
    moves: float


class Doubt(NamedTuple):
    """Reason why a fit is no result, empty where it is one all the same, and sentence of the report."""

    reason: str
    text: str


def doubts(found: Fit) -> Iterator[Doubt]:
    """What is doubtful about a fit."""
    far = outliers(found)
    for one in far:
        yield Doubt("", one.text)
    for name in found.undetermined:
        if name not in found.at_bounds:
            yield Doubt(f"{name} is not determined", "")
    for name in found.at_bounds:
        value, (low, high) = found.values[name], found.problem.bounds[name]
        end = f"lower ({low:.3g})" if 2.0 * value < low + high else f"upper ({high:.3g})"
        text = f"{name} = {value:.4g} is at one of its bounds, {low:g} to {high:g}"
        yield Doubt(f"{name} is at its {end} bound", f"{text}: its interval has no meaning")
    if found.inseparable:
        yield Doubt("mu and theta are not separated without dilation", "")
    for (a, b), one in found.coupled.items():
        yield Doubt("", f"{a} and {b} cannot be separated (correlation {one:.4f}): set one of them")
    if found.dependent:
        scatter = float(np.nanmax(found.scatter))
        if scatter > POOR:
            text = f"the fit is poor: the residuals are {scatter:.0%} of the range. Check the plot, the "
            yield Doubt("", f"{text}units and the constants that are set; the numbers are not reliable")
        reason = f"the residuals of neighbouring rows are correlated ({found.neighbours:.2f})"
        text = (
            f"{reason}: the model differs from the test data by more than noise, so the intervals are "
            f"{'widened' if found.model_error > 0.0 else 'too narrow'} by a factor of about "
            f"{found.dependence_factor:.1f}"
        )
        # the widening for correlated residuals presumes that the scatter is what the user accepts
        yield Doubt(reason if scatter > max(found.model_error, LEAST_ERROR) else "", text)
    if found.lost_rows:
        yield Doubt(f"the model has no equilibrium at {found.lost_rows} rows", "")
    if not found.converged:
        text = "the least squares ended before they converged: give a --start, or fewer free constants"
        yield Doubt("the least squares did not converge", text)
    if found.shift > ENOUGH:
        change = f"finer ones change a constant by {found.shift:.2g} standard errors"
        reason = "the increments are too long"
        yield Doubt(reason, f"{reason}: {change}; raise --increments")
    if found.agreeing == 1 and len(found.costs) > 1:
        reason = "only one start reached the smallest sum of squares"
        yield Doubt(reason, f"{reason}: there may be a smaller one; raise --starts")
    moving = [one.place for one in far if one.moves > MOVED]
    if moving:
        yield Doubt(f"outliers move the constants ({', '.join(moving)})", "")


def refusals(found: Fit) -> list[str]:
    """Reasons why the constants must not be used; none if the fit is a result."""
    return [one.reason for one in doubts(found) if one.reason]


def outliers(found: Fit) -> list[Outlier]:
    """Rows with residuals far beyond those of all others and of their neighbours."""
    rows = []
    for part in found.problem.parts:
        residuals = found.residuals[part.place]
        scale = ROBUST * float(np.median(np.abs(residuals)))
        padded = np.abs(np.concatenate([residuals[1:2], residuals, residuals[-2:-1]]))
        beside = np.maximum(padded[:-2], padded[2:])
        far = (np.abs(residuals) > OUTLYING * scale) & (beside < ALONE * np.abs(residuals))
        rows += [(part, i, part.place.start + i, scale) for i in np.flatnonzero(far).tolist()]
    good = np.delete(found.residuals, [place for *_, place, _ in rows])
    noise = ROBUST * float(np.median(np.abs(good)))
    errors = np.maximum(noise * np.linalg.norm(found.inverse, axis=1), np.finfo(float).tiny)
    told = []
    for part, i, place, scale in rows:
        test, residual = found.problem.tests[part.number], found.residuals[place]
        moves = float(np.max(np.abs(found.inverse[:, place] * residual) / errors))
        line = f"{test.name}: line {test.lines[i]}" if test.lines else f"{test.name}: row {i + 1}"
        text = (
            f"outlier: {line}, {part.name} {part.measured[i]:g} is "
            f"{abs(residual) / scale if scale > 0.0 else np.inf:.0f} standard deviations off the "
            f"fit and moves a constant by {moves:.1g} standard errors"
        )
        told.append(Outlier(line, text, moves))
    return told


def propose(found: Fit, given: Arguments, fitted: Fitted) -> tuple[Arguments, Fit] | None:
    """Arguments with which the same tests give a result, and this fit; None if none is found.

    given: arguments of the fit that was found.  The changes add up, where they fit better: crush for tests
    at several pressures, wear in cycles whose dilation ends, another pattern, free values; then the customary
    values of constants that the tests do not tell, then the acceptance of a model error.
    """
    problem, tests = found.problem, found.problem.tests
    pressures, inclined = np.abs([test.pressed for test in tests]), problem.sides > 0
    several = inclined and bool(pressures.max() > SEVERAL * pressures.min())
    ends = inclined and any(test.saturates for test in tests)
    worn = ends and any(len(test.turns) > 1 for test in tests)
    steps = [[("crush",), ("crush", "height")] * several, [("height",)] * ends, [("W0",)] * worn]
    ways: list[Callable[[Arguments], list[Arguments]]] = [
        lambda now, names=names: [one for several in names for one in _freeing(found, now, *several)]
        for names in steps
    ]
    if given.get("sides") is None:
        ways.append(lambda now: [now | {"sides": sides} for sides in PATTERNS if sides != problem.sides])
    if given.get("fixed"):
        ways.append(lambda now: [now | {"free": None, "fixed": {}}])
    for _ in range(MOST_CHANGES):
        if not refusals(found):
            return given, found
        better: list[tuple[Arguments, Fit]] = []
        while ways and not better:
            better = [one for one in _fits(fitted, ways.pop(0)(given)) if _is_better(one[1], found)]
        better = better or _fits(fitted, _value(found, given) or _acceptance(found, given))
        if not better:
            return None
        given, found = min(better, key=lambda one: one[1].costs[0])
    return None if refusals(found) else (given, found)


def _fits(fitted: Fitted, changes: Sequence[Arguments]) -> list[tuple[Arguments, Fit]]:
    """Fits with changed arguments, without those that a fit refuses."""
    found = []
    for one in changes:
        try:
            found.append((one, fitted(one)))
        except ValueError:
            continue
    return found


def _freeing(found: Fit, given: Arguments, *names: str) -> list[Arguments]:
    """Change that adds free constants, unless one is free or has a value."""
    free = given.get("free") or ()
    if {*names} & {*found.problem.free, *given.get("fixed", {})}:
        return []
    return [given | {"free": (*free, *(names if free else (f"+{name}" for name in names)))}]


def _is_better(other: Fit, found: Fit) -> bool:
    ratio = other.costs[0] / found.costs[0]
    return ratio < BETTER or (ratio < AS_GOOD and not refusals(other))


def _value(found: Fit, given: Arguments) -> list[Arguments]:
    """Change that sets the customary value of a constant that the tests do not tell, if there is one."""
    for name in dict.fromkeys([*found.undetermined, *found.at_bounds]):
        one = found.estimates[name]
        inside = [value for value in CUSTOMARY.get(name, ()) if value == 0.0 or one.low <= value <= one.high]
        if inside:
            left = tuple(free for free in given.get("free") or () if free.lstrip("+") != name)
            return [given | {"free": left or None, "fixed": given.get("fixed", {}) | {name: inside[0]}}]
    return []


def _acceptance(found: Fit, given: Arguments) -> list[Arguments]:
    """Change that accepts the scatter of a model that differs from the tests by more than noise."""
    scatter = float(np.nanmax(found.scatter))
    if not found.dependent or scatter <= found.model_error or scatter > LARGEST_ERROR:
        return []
    return [given | {"model_error": float(np.ceil(100.0 * scatter) / 100.0)}]
