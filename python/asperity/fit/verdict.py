"""Whether a fit is a result, and which fit to try next where it is not."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .model import SIDES
from .outcome import ENOUGH, LEAST_ERROR, Fit
from .shear_test import ShearTest

OUTLYING = 6.0
"""Residual, in robust standard deviations, above which a row that stands alone is an outlier."""

ALONE = 0.5
"""Largest residual of the neighbours of an outlier, as a fraction of its own."""

MOVED = 1.0
"""Change of a parameter, in standard errors, above which an outlier makes the fit no result."""

ROBUST = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""

PATTERNS = (SIDES, 2, 0)
"""Inclined planes of the patterns that are tried where the user has given none."""

LARGEST_ERROR = 0.1
"""Largest scatter, as a fraction of the range, that is proposed to be accepted."""

BETTER, AS_GOOD = 0.9, 1.05
"""Ratio of two sums of squares below which another pattern is preferred; the second one if it is a result."""

SATURATED, LEAST_PART = 0.7, 4
"""Ratio of two slopes of the dilation below which it ends, and smallest number of rows of a slope."""

MOST_CHANGES = 4
"""Largest number of changes of the arguments that are tried one after the other."""

CUSTOMARY = {"flat": (1.0 / 3.0,), "kc": (100.0, 20.0), "eta": (0.9,)}
"""Values proposed for parameters that the tests do not determine: the first one inside the interval."""


@dataclass(frozen=True)
class Outlier:
    """Row that the fit misses by far more than its neighbours; moves: parameters, in standard errors."""

    place: str
    text: str
    moves: float


@dataclass(frozen=True)
class Change:
    """Arguments of a fit: inclined planes, free parameters (None: the usual), values, model error."""

    sides: int
    free: tuple[str, ...] | None = None
    fixed: Mapping[str, float] = field(default_factory=dict)
    model_error: float = 0.0


Fitted = Callable[[Change], Fit]
"""Function that fits the same tests with other arguments."""


def refusals(found: Fit) -> list[str]:
    """Reasons why the parameters must not be used; none if the fit is a result."""
    reasons = [f"{name} is not determined" for name in found.undetermined if name not in found.at_bounds]
    reasons += [f"{name} is at a bound" for name in found.at_bounds]
    if found.inseparable:
        reasons.append("mu and theta are not separated without dilation")
    # the widening for correlated residuals presumes that the scatter is what the user accepts
    scatter = float(np.nanmax(found.scatter))
    if found.dependent and scatter > max(found.model_error, LEAST_ERROR):
        reasons.append(f"the residuals of neighbouring rows are correlated ({found.neighbours:.2f})")
    if found.lost_rows:
        reasons.append(f"the model has no equilibrium at {found.lost_rows} rows")
    if not found.converged:
        reasons.append("the least squares did not converge")
    if found.shift > ENOUGH:
        reasons.append("the increments are too long")
    if found.agreeing == 1 and len(found.costs) > 1:
        reasons.append("only one start reached the smallest sum of squares")
    moving = [one.place for one in outliers(found) if one.moves > MOVED]
    if moving:
        reasons.append(f"outliers move the parameters ({', '.join(moving)})")
    return reasons


def outliers(found: Fit) -> list[Outlier]:
    """Rows with residuals far beyond those of all others and of their neighbours."""
    rows = []
    for test, name, place in found.problem.parts:
        residuals = found.residuals[place]
        scale = ROBUST * float(np.median(np.abs(residuals)))
        padded = np.abs(np.concatenate([residuals[1:2], residuals, residuals[-2:-1]]))
        beside = np.maximum(padded[:-2], padded[2:])
        for i in np.flatnonzero(
            (np.abs(residuals) > OUTLYING * scale) & (beside < ALONE * np.abs(residuals))
        ):
            size = residuals[i] / scale if scale > 0.0 else np.inf
            rows.append((place.start + int(i), test, name, int(i), size))
    if not rows:
        return []
    inverse = found.inverse
    good = np.setdiff1d(np.arange(found.residuals.size), [row[0] for row in rows])
    noise = ROBUST * float(np.median(np.abs(found.residuals[good])))
    errors = np.maximum(noise * np.linalg.norm(inverse, axis=1), np.finfo(float).tiny)
    told = []
    for place, test, name, i, size in rows:
        moves = float(np.max(np.abs(inverse[:, place] * found.residuals[place]) / errors))
        value = float((test.tau if name == "tau" else test.s_N)[i])  # type: ignore[index]
        line = f"{test.name}: line {test.lines[i]}" if test.lines else f"{test.name}: row {i + 1}"
        text = (
            f"outlier: {line}, {name} {value:g} is {abs(size):.0f} standard deviations off the fit and moves "
            f"a parameter by {moves:.1g} standard errors"
        )
        told.append(Outlier(line, text, moves))
    return told


def propose(found: Fit, change: Change, fitted: Fitted, given_sides: bool) -> tuple[Change, Fit] | None:
    """Arguments with which the same tests give a result, and this fit; None if none is found.

    change: arguments of the fit that was found.  given_sides: whether the user has given the pattern.  The
    changes add up: a finite height where the dilation ends, wear in cycles, another pattern or free values
    that fit better, then customary values of parameters that the tests do not tell, then the acceptance of a
    model error.
    """
    problem = found.problem
    ways: list[Callable[[Change], list[Change]]] = []
    if problem.sides > 0 and any(map(saturates, problem.tests)):
        ways.append(lambda now: _freeing(found, now, "height"))
        if any(len(test.turns) > 1 for test in problem.tests):
            ways.append(lambda now: _freeing(found, now, "W0"))
    if not given_sides:
        ways.append(lambda now: [replace(now, sides=sides) for sides in PATTERNS if sides != now.sides])
    if change.fixed:
        ways.append(lambda now: [replace(now, free=None, fixed={})])
    for _ in range(MOST_CHANGES):
        if not refusals(found):
            return change, found
        better: list[tuple[Change, Fit]] = []
        while ways and not better:
            better = [one for one in _fits(fitted, ways.pop(0)(change)) if _is_better(one[1], found)]
        if not better:
            following = _value(found, change) or _acceptance(found, change)
            better = _fits(fitted, [following] if following else [])
        if not better:
            return None
        change, found = min(better, key=lambda one: one[1].costs[0])
    return None if refusals(found) else (change, found)


def _fits(fitted: Fitted, changes: Sequence[Change]) -> list[tuple[Change, Fit]]:
    """Fits with changed arguments, without those that a fit refuses."""
    found = []
    for one in changes:
        try:
            found.append((one, fitted(one)))
        except ValueError:
            continue
    return found


def _freeing(found: Fit, change: Change, name: str) -> list[Change]:
    """Change that adds a free parameter, unless it has a value or the pattern has no inclined planes."""
    free = change.free or tuple(one for one in found.problem.free if one not in change.fixed)
    if name in free or name in change.fixed or change.sides == 0:
        return []
    return [replace(change, free=(*free, name))]


def saturates(test: ShearTest) -> bool:
    """Whether the dilation ends: its slope at the end of the first stroke is well below that before."""
    if test.s_N is None or test.envelope:
        return False
    end = int(np.argmax(np.abs(test.slip) >= 0.98 * np.abs(test.slip).max()))
    way, stroke = test.slip / test.slip[end], np.arange(test.slip.size) <= end
    slopes = []
    for low, high in ((0.25, 0.5), (0.75, 1.0)):
        part = stroke & (way >= low) & (way <= high)
        if np.count_nonzero(part) < LEAST_PART:
            return False
        slopes.append(np.polyfit(way[part], test.s_N[part], 1)[0])
    return bool(slopes[1] < SATURATED * slopes[0])


def _is_better(other: Fit, found: Fit) -> bool:
    ratio = other.costs[0] / found.costs[0]
    return ratio < BETTER or (ratio < AS_GOOD and not refusals(other))


def _value(found: Fit, change: Change) -> Change | None:
    """Change that sets a parameter that the tests do not tell, if there is a customary value of it."""
    for name in dict.fromkeys([*found.undetermined, *found.at_bounds]):
        one = found.estimates[name]
        inside = [value for value in CUSTOMARY.get(name, ()) if one.low <= value <= one.high]
        if inside:
            free = None if change.free is None else tuple(one for one in change.free if one != name)
            return replace(change, free=free, fixed=dict(change.fixed) | {name: inside[0]})
    return None


def _acceptance(found: Fit, change: Change) -> Change | None:
    """Change that accepts the scatter of a model that differs from the tests by more than noise."""
    scatter = float(np.nanmax(found.scatter))
    if not found.dependent or scatter <= change.model_error or scatter > LARGEST_ERROR:
        return None
    return replace(change, model_error=float(np.ceil(100.0 * scatter) / 100.0))
