"""What to try next where a fit is no result."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ... import contract
from .fitting import problem_of, search
from .model import ENDING, ROCK, SIDES
from .result import BETTER, Fit, failed_checks

Arguments = dict[str, Any]
"""Arguments of `fit`, by name, and "accept", whether the constants are taken as they are."""

PATTERNS = (SIDES, 2, 0)
"""Inclined planes of the patterns that are tried where the user has given none."""

LARGEST_ERROR = 0.1
"""Largest scatter, as a fraction of the range, that is proposed to be accepted."""

CUSTOMARY = {"flat": (1.0 / 3.0,), "kc": (20.0, 100.0, 1.0), "eta": (0.9,)}
CUSTOMARY |= dict.fromkeys(ENDING, (0.0,))
"""Values of constants that the tests do not determine: the first one inside the interval, or 0 for none."""

SEVERAL = 1.2
"""Ratio of two pressures at which strength over pressure is compared."""

VALUE = "VALUE"
"""A value that the user has to find."""


def proposal(found: Fit, given: Arguments, before: Sequence[Arguments] = ()) -> tuple[Arguments, str]:
    """Changes of the arguments of a fit that is no result, and why they are proposed.

    before: arguments that were tried, to which no change leads back.
    The first of: another model that fits better; customary values of constants that the tests do not
    determine; no bond; theta from elsewhere; the acceptance of a model error; a value from elsewhere; these
    constants as they are.
    """
    loose = dict.fromkeys([*found.undetermined, *found.at_bounds])
    if not ({*loose} <= {*CUSTOMARY} and len(failed_checks(found)) == len(loose)):
        cost = float(np.sum(replace(found.problem.coarse(), weight=1.0).residuals(found.x) ** 2))
        tried = _tried(found, given, before)
        _, other, change = min(tried, key=lambda one: one[0], default=(np.inf, np.inf, {}))
        if other < BETTER * cost:
            return change, f"fits better: sum of squares {other:.4g} after {cost:.4g}"
    for name in loose:
        one = found.estimates[name]
        inside = [value for value in CUSTOMARY.get(name, ()) if value == 0.0 or one.low <= value <= one.high]
        change = _setting(given, name, inside[0]) if inside else {}
        if change and given | change not in before:
            return change, f"sets {name} to a usual value"
    if ROCK in found.criteria and found.loose_bond:
        return {"joint": ROCK}, "if the joint has no bond; a bond needs rows up to the residual strength"
    problem, scatter = found.problem, float(np.nanmax(found.scatter))
    curves = not any(test.envelope for test in problem.tests)
    unshown = not problem.is_dilation.any() and ("theta" in problem.free or not problem.fixed["theta"])
    unknown = ["theta"] * (unshown and curves and given.get("sides") is None)
    if found.misses and not unknown and found.model_error < scatter <= LARGEST_ERROR:
        accepted = float(np.ceil(100.0 * scatter) / 100.0)
        return {
            "model_error": accepted
        }, "accepts a law that differs from the tests by this part of the range"
    unknown += [name for name in loose if name not in found.at_bounds and not found.misses]
    if unknown:
        where = f"with the value of {unknown[0]} from another test: these tests do not contain it"
        return _setting(given, unknown[0], VALUE), where
    look = "look first where test and fit differ: units, signs, pattern (--sides), rows to leave out"
    return {"accept": True}, f"takes these constants as they are; {look}"


def _setting(given: Arguments, name: str, value: object) -> Arguments:
    """Change by which a constant has a value and is not free."""
    left = tuple(free for free in given.get("free") or () if free.lstrip("+") != name)
    return {"free": left or None, "fixed": given.get("fixed", {}) | {name: value}}


def _tried(
    found: Fit, given: Arguments, before: Sequence[Arguments]
) -> Iterator[tuple[float, float, Arguments]]:
    """Criterion (BIC), sum of squares and change of the arguments of other models from these constants on."""
    problem, free, fixed = found.problem, given.get("free"), given.get("fixed", {})
    for change in _changes(found, given):
        now = {"free": free, "fixed": fixed, "sides": given.get("sides")} | change
        if given | change in before:
            continue
        try:
            other = problem_of(
                problem.tests, problem.form, now["free"], now["fixed"], {}, now["sides"], problem.direction
            )
        except ValueError:
            continue
        start = {name: found.values[name] for name in other.free if found.values.get(name)}
        one = search(other, start)
        yield float(one.result.bic), one.costs[0], change


def _changes(found: Fit, given: Arguments) -> Iterator[Arguments]:
    """Changes of the model: weak asperities at several pressures, wear in cycles, a pattern, no values."""
    problem, tests, free = found.problem, found.problem.tests, given.get("free") or ()
    pressures, inclined = np.abs([test.pressed for test in tests]), problem.sides > 0
    ends = inclined and any(test.saturates for test in tests)
    form = {"joint": ROCK} if problem.form == ROCK else {}
    strength, height, work = map(contract.of_asperities, ("stress", "length", "stress*length"))
    for wanted, names in (
        (inclined and pressures.max() > SEVERAL * pressures.min(), strength),
        (inclined and pressures.max() > SEVERAL * pressures.min(), strength + height),
        (ends, height),
        (ends and any(len(test.turns) > 1 for test in tests), work),
    ):
        if wanted and not {*names} & {*problem.free, *given.get("fixed", {})}:
            yield form | {"free": (*free, *(names if free else (f"+{name}" for name in names)))}
    if given.get("sides") is None:
        yield from ({"sides": sides} for sides in PATTERNS if sides != problem.sides)
    if given.get("fixed"):
        yield {"free": None, "fixed": {}}
