"""Slope and height of asperities by profiles that the law has and has not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from .assumptions import at_once, first_only, halves_of
from .evidence import first_stroke
from .gauges import rigid_form, with_shape, with_starts
from .intervals import Assumption
from .ladder import BRITTLE, GAIN, criteria
from .model import SPRINGS, rows_of
from .rigid import CONTRACTING, LINE, SHAPES, SLOPES, SOFTENINGS, WITHOUT
from .shear_test import ShearTest
from .squares import SEARCHED, Solution, refitted

STARTS, OWN = "other starts", "slope of the law"
"""Names of starts of slip and dilation that fit best, and of the law beside another shape."""


def in_place_of_bond(solutions: Sequence[Solution], index: int, bic: Sequence[float]) -> int:
    """Place of the joint without bond whose asperities, of another shape, explain tests better than a bond.

    A profile that the law does not have must not make a bond.
    """
    chosen = solutions[index]
    sloped = [
        i
        for i, solution in enumerate(solutions)
        if not solution.model.bond and {"theta", "height"} <= {*solution.model.free}
    ]
    if not (chosen.model.bond and sloped and first_only(chosen.problem.tests)):
        return index
    rock = min(sloped, key=lambda i: bic[i])
    form = rigid_form(solutions[rock], chosen.problem.tests)
    if form is None:
        return index
    others = [with_shape(form, name) for name in (LINE, CONTRACTING)]
    # a dilation that the bond does not meet is no reason for a joint that meets the strength less well
    as_strong = [other.mean_squares["tau"] < chosen.mean_squares["tau"] for other in others]
    own, *values = criteria([chosen, *others])
    better = (value < own - GAIN for value, strong in zip(values, as_strong, strict=True) if strong)
    return rock if any(better) else index


def shaped(chosen: Solution, tests: Sequence[ShearTest], given: Mapping[str, float]) -> list[Solution]:
    """Closed form of the law, and with the shapes that it does not have, of tests without reversals.

    given: values of the user, which stay.  Empty where there is no such form.
    """
    bond = chosen.model.bond
    if not (first_only(tests) and (bond or {"theta", "height"} <= {*chosen.model.free})):
        return []
    form = at_once(chosen, tests, given, BRITTLE) if bond else rigid_form(chosen, tests)
    forms = [form] if form else []
    if form and "crush" in form.model.free:
        # what looks like crushed asperities may be their profile
        whole = form.model.without("crush", crush=0.0)
        forms.append(refitted(form, tests, whole, tolerance=SEARCHED))
    others = [with_shape(own, name) for own in forms for name in (SOFTENINGS if bond else SLOPES)]
    return [*forms[:1], *others]


def of_profile(
    chosen: Solution, law: Solution, tests: Sequence[ShearTest], forms: Sequence[Solution]
) -> Iterator[Assumption]:
    """Constants of asperities whose slope falls otherwise than that of the choice, from other starts, too.

    A first slope is that of a profile, and the tests may not show which one it is.  Nor do they show where a
    gauge was set to zero, which moves the slope along the profile.  Of cycles the first strokes are compared.
    law: fit of the law.  forms: those of `shaped`.
    """
    if chosen.model.bond or "theta" not in chosen.model.free:
        return
    alone = first_only(tests)
    if not alone:
        tests = [rows_of(test, first_stroke(test)) for test in tests]
    form = rigid_form(law, tests, () if alone else ("W0",))
    if form is None:
        return
    own, others = chosen if alone else form, list(forms[1:])
    if not alone and "height" in form.model.free:
        others = [with_shape(form, name) for name in SLOPES]
    made = [(with_starts(form), STARTS)] if alone else []
    for solution in others:
        name = solution.model.shape + ", not crushed" * (
            "crush" in {*form.model.free} - {*solution.model.free}
        )
        made += [(solution, name)] if solution is not chosen else [(law, OWN)]
        made += [(with_starts(solution), f"{name}, {STARTS}")] if alone else []
    first = criteria([own, *(solution for solution, _ in made)])
    apart: dict[str, Mapping[str, float]] = {}
    for (solution, name), value in zip(made, first[1:], strict=True):
        # crush belongs to the profile, too, and a spring goes with the start of the slip
        parts = tuple(part for part in chosen.model.free if part not in ("crush", "W0", *SPRINGS))
        # a profile that explains the tests better than the law excludes others, too
        allowed, halves, shape = value < min(first) + GAIN, halves_of(solution), solution.model.shape
        if shape and (allowed or value < first[0] - GAIN):
            if shape not in apart:
                whole = with_shape(form, shape)
                apart[shape] = halves_of(whole, left_out(whole))
            wide = apart[shape]
            halves = {part: max(half, wide.get(part, 0.0)) for part, half in halves.items()}
        yield Assumption(name, value - first[0], solution.values, allowed, parts, halves, shape in apart)


def left_out(form: Solution) -> list[Solution]:
    """Fits of a closed form without each of its tests."""
    tests = list(form.problem.tests)
    rest = [tests[:i] + tests[i + 1 :] for i in range(len(tests))] if len(tests) > 1 else []
    return [refitted(form, some, tolerance=SEARCHED) for some in rest]


def of_strength(
    chosen: Solution, tests: Sequence[ShearTest], given: Mapping[str, float]
) -> Iterator[Assumption]:
    """Bond, friction, slope and height where the slope of the dilation adds none, as in models of masonry.

    given: values of the user, which stay.
    """
    form = at_once(chosen, tests, given, BRITTLE) if "theta" in chosen.model.free else None
    if form is None:
        return
    ends = "height" in chosen.model.free
    names = [name for name in SHAPES if name.startswith(WITHOUT) and (ends or name == WITHOUT)]
    others = [with_shape(form, name) for name in names]
    first, *values = criteria([chosen, *others])
    least = min(first, *values) + GAIN
    for name, other, value in zip(names, others, values, strict=True):
        parts = tuple(name for name in other.model.free if name != "crush")
        yield Assumption(name, value - first, other.values, value < least, parts, halves_of(other))
