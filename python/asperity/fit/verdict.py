"""Whether a fit is a result, and which fit to try next where it is not."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .constants import AUTO
from .model import SIDES
from .outcome import ENOUGH, LEAST_ERROR, Fit
from .shear_test import saturates

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


@dataclass(frozen=True)
class Outlier:
    """Row that the fit misses by far more than its neighbours; moves: constants, in standard errors."""

    place: str
    text: str
    moves: float


@dataclass(frozen=True)
class Change:
    """Arguments of a fit: inclined planes, free constants (None: the usual), values, model error, form."""

    sides: int | None = None
    free: tuple[str, ...] | None = None
    fixed: Mapping[str, float] = field(default_factory=dict)
    model_error: float = 0.0
    joint: str = AUTO


Fitted = Callable[[Change], Fit]
"""Function that fits the same tests with other arguments."""


def refusals(found: Fit) -> list[str]:
    """Reasons why the constants must not be used; none if the fit is a result."""
    reasons = [f"{name} is not determined" for name in found.undetermined if name not in found.at_bounds]
    reasons += [f"{name} is at its {_end(found, name)} bound" for name in found.at_bounds]
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
        reasons.append(f"outliers move the constants ({', '.join(moving)})")
    return reasons


def _end(found: Fit, name: str) -> str:
    low, high = found.problem.bounds[name]
    middle = np.sqrt(low * high) if low > 0.0 else 0.5 * (low + high)
    return f"lower ({low:.3g})" if found.values[name] < middle else f"upper ({high:.3g})"


def outliers(found: Fit) -> list[Outlier]:
    """Rows with residuals far beyond those of all others and of their neighbours."""
    rows = []
    for test, name, place in found.problem.parts:
        residuals = found.residuals[place]
        scale = ROBUST * float(np.median(np.abs(residuals)))
        padded = np.abs(np.concatenate([residuals[1:2], residuals, residuals[-2:-1]]))
        beside = np.maximum(padded[:-2], padded[2:])
        far = (np.abs(residuals) > OUTLYING * scale) & (beside < ALONE * np.abs(residuals))
        for i in np.flatnonzero(far).tolist():
            size = residuals[i] / scale if scale > 0.0 else np.inf
            rows.append((place.start + i, test, name, i, size))
    good = np.setdiff1d(np.arange(found.residuals.size), [row[0] for row in rows])
    noise = ROBUST * float(np.median(np.abs(found.residuals[good])))
    errors = np.maximum(noise * np.linalg.norm(found.inverse, axis=1), np.finfo(float).tiny)
    told = []
    for place, test, name, i, size in rows:
        moves = float(np.max(np.abs(found.inverse[:, place] * found.residuals[place]) / errors))
        value = float((test.tau if name == "tau" else test.s_N)[i])  # type: ignore[index]
        line = f"{test.name}: line {test.lines[i]}" if test.lines else f"{test.name}: row {i + 1}"
        text = (
            f"outlier: {line}, {name} {value:g} is {abs(size):.0f} standard deviations off the fit and moves "
            f"a constant by {moves:.1g} standard errors"
        )
        told.append(Outlier(line, text, moves))
    return told


def propose(found: Fit, change: Change, fitted: Fitted) -> tuple[Change, Fit] | None:
    """Arguments with which the same tests give a result, and this fit; None if none is found.

    change: arguments of the fit that was found.  The changes add up, where they fit better: crush for tests
    at several pressures, wear in cycles whose dilation ends, another pattern, free values; then the customary
    values of constants that the tests do not tell, then the acceptance of a model error.
    """
    problem = found.problem
    ways: list[Callable[[Change], list[Change]]] = []
    if problem.sides > 0 and any(saturates(test) for test in problem.tests):
        ways.append(lambda now: _freeing(found, now, "height"))
        if any(len(test.turns) > 1 for test in problem.tests):
            ways.append(lambda now: _freeing(found, now, "W0"))
    pressures = np.abs([test.pressed for test in problem.tests])
    if problem.sides > 0 and pressures.max() > SEVERAL * pressures.min():
        ways.insert(0, lambda now: _freeing(found, now, "crush") + _freeing(found, now, "crush", "height"))
    if change.sides is None:
        ways.append(lambda now: [replace(now, sides=sides) for sides in PATTERNS if sides != problem.sides])
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


def _freeing(found: Fit, change: Change, *names: str) -> list[Change]:
    """Change that adds free constants, unless one is free or has a value."""
    if {*names} & {*found.problem.free, *change.fixed}:
        return []
    more = names if change.free else tuple(f"+{name}" for name in names)
    return [replace(change, free=(*(change.free or ()), *more))]


def _is_better(other: Fit, found: Fit) -> bool:
    ratio = other.costs[0] / found.costs[0]
    return ratio < BETTER or (ratio < AS_GOOD and not refusals(other))


def _value(found: Fit, change: Change) -> Change | None:
    """Change that sets the customary value of a constant that the tests do not tell, if there is one."""
    for name in dict.fromkeys([*found.undetermined, *found.at_bounds]):
        one = found.estimates[name]
        inside = [value for value in CUSTOMARY.get(name, ()) if value == 0.0 or one.low <= value <= one.high]
        if inside:
            left = change.free and tuple(free for free in change.free if free.lstrip("+") != name)
            return replace(change, free=left or None, fixed=dict(change.fixed) | {name: inside[0]})
    return None


def _acceptance(found: Fit, change: Change) -> Change | None:
    """Change that accepts the scatter of a model that differs from the tests by more than noise."""
    scatter = float(np.nanmax(found.scatter))
    if not found.dependent or scatter <= change.model_error or scatter > LARGEST_ERROR:
        return None
    return replace(change, model_error=float(np.ceil(100.0 * scatter) / 100.0))
