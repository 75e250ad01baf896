"""Shapes of slope and softening that the law has and has not, and other starts of slip and dilation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from .intervals import Assumption, Intervals, spreads
from .ladder import Model, criteria
from .model import KS, KT, SPRINGS, rows_of, to_scale
from .rigid import CONTRACTING, SHAPES, SLOPES, SOFTENINGS, WITHOUT
from .series import Started
from .shear_test import ShearTest, cycles, first_slope, first_stroke
from .squares import Solution, guesses, refitted, solve
from .thresholds import GAIN, SEARCHED

STARTS, SHAPE_OF_LAW, AT_ONCE = "gauge offsets", "shape of the law", "friction at once behind a spring"
UNCRUSHED, ENDED_HERE = "the slope that the tests show", "a dilation that ends with the rows"
"""Names of starts of slip and dilation that fit best, of the law beside another shape, of a bond in closed
form, whose friction does not wait for the damage, of a slope that the pressure does not crush, and of a
height that the rows reach.
"""


def rigid_form(chosen: Solution, tests: Sequence[ShearTest], left_out: Sequence[str] = ()) -> Solution | None:
    """The same model with rigid sides behind a spring, which has a closed form; None without one.

    left_out: constants that the tests do not need, as wear in a first stroke.
    """
    if chosen.problem.is_closed_form:
        return chosen
    free = tuple(name for name in chosen.model.free if name not in left_out)
    model = replace(chosen.model, free=free)
    if KS in model.free:
        model = model.instead(KS, KT)
    elif KS in model.fixed and not model.series:
        fixed = {name: value for name, value in model.fixed.items() if name not in (KS, "kc")}
        model = replace(model, fixed=fixed | {KT: 0.5 * chosen.values[KS]})
    problem = model.problem(tests, chosen.problem.weight, chosen.problem.direction)
    return refitted(chosen, tests, model, tolerance=SEARCHED) if problem.is_closed_form else None


def with_shape(form: Solution, shape: str) -> Solution:
    """Fit of a closed form with another shape."""
    model = replace(form.model, shape=shape)
    return refitted(form, form.problem.tests, model, tolerance=SEARCHED) if shape else form


def with_starts(form: Solution) -> Solution:
    """Fit of a closed form from the starts of the gauges that fit best."""
    problem, shape = form.problem, form.model.shape
    rest = (problem.free, problem.fixed, problem.sides, problem.direction, problem.increments)
    other = Started(problem.tests, *rest, problem.weight, shape)
    return Solution(form.model, other, *solve(other, form.x, SEARCHED))


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
    if not (chosen.model.bond and sloped and not cycles(chosen.problem.tests)):
        return index
    rock = min(sloped, key=lambda i: bic[i])
    form = rigid_form(solutions[rock], chosen.problem.tests)
    if form is None:
        return index
    others = [with_shape(form, name) for name in slopes_of(chosen.problem.tests)]
    # a dilation that the bond does not meet is no reason for a joint that meets the strength less well
    as_strong = [other.mean_squares["tau"] < chosen.mean_squares["tau"] for other in others]
    own, *values = criteria([chosen, *others])
    better = (value < own - GAIN for value, strong in zip(values, as_strong, strict=True) if strong)
    return rock if any(better) else index


def shaped(
    chosen: Solution, tests: Sequence[ShearTest], known: Mapping[str, float], of_user: bool = False
) -> list[Solution]:
    """Closed form of the law, and with the shapes that it does not have, of tests without reversals.

    known: values of the user, which stay.  of_user: the model is that of the user, which has no other shape.
    Empty where there is no such form.
    """
    free, bond = {*chosen.model.free}, chosen.model.bond
    if cycles(tests) or not (bond or free & {"theta", "height"}):
        return []
    form = at_once(chosen, tests, known) if bond else rigid_form(chosen, tests)
    names = slopes_of(tests) if not bond and ends(chosen.model) else ()
    if bond:
        apart = [name for name in SHAPES if name.startswith(WITHOUT) and "theta" in free]
        names = (*SOFTENINGS, *apart)
    return [form, *(with_shape(form, name) for name in names if not of_user)] if form else []


def ends(model: Model) -> bool:
    """Whether the slope of a model ends, at a height that is fitted or known."""
    return "height" in model.free or model.fixed.get("height", 0.0) > 0.0


def slopes_of(tests: Sequence[ShearTest]) -> tuple[str, ...]:
    """Slopes that tests may show; strengths alone show no contraction."""
    opens = any(test.s_N is not None for test in tests)
    return SLOPES if opens else tuple(name for name in SLOPES if name != CONTRACTING)


def at_once(chosen: Solution, tests: Sequence[ShearTest], known: Mapping[str, float]) -> Solution | None:
    """Closed form of a bond, beside which friction acts at once, with a spring in series; None without one.

    Where few rows rise to the peak, they show neither the spring nor the damage for which friction waits.
    """
    model, values = chosen.model, chosen.values
    if chosen.problem.is_closed_form and (KT in model.free or KT in known):
        return chosen
    free = tuple(name for name in model.free if name not in ("eta", KT))
    fixed = {name: value for name, value in model.fixed.items() if name not in ("eta", KT) or name in known}
    if KT not in known:
        free = (KT, *free)
    # an eta below 1 that is known has no closed form
    rigid = Model(free, model.sides, fixed)
    problem = rigid.problem(tests, chosen.problem.weight, chosen.problem.direction)
    if KT not in model.free:
        values = values | {KT: guesses(tests)[KT]}
    if not problem.is_closed_form:
        return None
    return Solution(rigid, problem, *solve(problem, problem.x(values), SEARCHED))


def assumed(
    chosen: Solution, law: Solution, tests: Sequence[ShearTest], forms: Sequence[Solution]
) -> Iterator[Assumption]:
    """Constants by other shapes than that of the choice, and by other starts of slip and dilation.

    A first slope is that of a profile, and the tests may not show which one it is.  Nor do they show where a
    gauge was set to zero, which moves the slope along the profile.  Of cycles the first strokes are compared.
    law: fit of the law.  forms: those of `shaped`.
    """
    own, alone, bond = chosen, not cycles(tests), chosen.model.bond
    if not (alone or bond) and "theta" in chosen.model.free:
        strokes = [rows_of(test, first_stroke(test)) for test in tests]
        first = rigid_form(law, strokes, ("W0",))
        names = slopes_of(tests) if first and ends(first.model) else ()
        forms = [first, *(with_shape(first, name) for name in names)] if first else []
        own = forms[0] if forms else chosen
    if not forms:
        return
    form, made = forms[0], []
    if alone:
        differs = law.problem.is_closed_form or "mu" in law.model.free or law.values.get("mu", 0.0) > 0.0
        made = [(form, AT_ONCE)] if bond and form is not law and differs else []
        made += [] if bond else [(with_starts(form), STARTS)]
    for solution in forms[1:]:
        name = solution.model.shape
        made += [(solution, name)] if solution is not chosen else [(law, SHAPE_OF_LAW)]
        made += [(with_starts(solution), f"{name}, {STARTS}")] if alone and not bond else []
    # crush belongs to the profile, too, and a spring goes with the start of the slip
    parts = tuple(part for part in chosen.model.free if part not in ("crush", "W0", *SPRINGS))
    values = criteria([own, *(solution for solution, _ in made)])
    apart: dict[str, Mapping[str, float]] = {}
    for (solution, name), value in zip(made, values[1:], strict=True):
        # a shape that explains the tests better than the law excludes others, too
        allowed, shape = value < min(values) + GAIN, solution.model.shape
        # the closed form of a bond moves the constants, and has their width
        halves = halves_of(solution) if allowed and name != AT_ONCE else {}
        if allowed and shape:
            if shape not in apart:
                whole = next(other for other in forms if other.model.shape == shape)
                apart[shape] = halves_of(whole, left_out(whole))
            halves = {part: max(half, apart[shape].get(part, 0.0)) for part, half in halves.items()}
        shown = tuple(part for part in parts if part in solution.model.free)
        yield Assumption(name, value - values[0], solution.values, allowed, shown, halves, shape in apart)


def unseen(chosen: Solution, tests: Sequence[ShearTest], intervals: Intervals) -> Iterator[Assumption]:
    """The slope and the height that the rows show, where those of the fit are larger.

    Both are extrapolations.  A slope without pressure, by crush: one that wears ends sooner under pressure,
    too, and is no smaller at first.  And a height beyond the rows: their dilation may end with them.
    intervals: those without these assumptions.
    """
    shown = float(np.degrees(np.arctan(max(map(first_slope, tests)))))
    if {"theta", "crush"} <= {*chosen.model.free} and 0.0 < shown < chosen.values["theta"]:
        yield Assumption(UNCRUSHED, 0.0, {"theta": shown}, True, ("theta",), {"theta": 0.0}, True)
    if "height" in chosen.model.free and chosen.values["theta"] > 0.0:
        values, slope = chosen.values, float(np.tan(np.radians(chosen.values["theta"])))
        compliance = sum(1.0 / values[name] for name in SPRINGS if name in values)
        way = max(float(np.max(np.abs(test.slip) - compliance * np.abs(test.tau))) for test in tests)
        reached = SHAPES[chosen.model.shape].profile(np.array([max(0.0, way)]), slope, values["height"])[1]
        if 0.0 < float(reached[0]) < intervals.of("height").low:
            height = {"height": float(reached[0])}
            yield Assumption(ENDED_HERE, 0.0, height, True, ("height",), {"height": 0.0}, True)


def left_out(form: Solution) -> list[Solution]:
    """Fits of a closed form without each of its tests."""
    tests = list(form.problem.tests)
    rest = [tests[:i] + tests[i + 1 :] for i in range(len(tests))] if len(tests) > 1 else []
    return [refitted(form, some, tolerance=SEARCHED) for some in rest]


def halves_of(solution: Solution, left_out: Sequence[Solution] = ()) -> dict[str, float]:
    """Half widths of the intervals of a solution, on the scales of its constants.

    left_out: fits without each of the tests.
    """
    intervals, halves = Intervals(solution, spreads(solution, left_out), []), {}
    for name in solution.model.free:
        low, high = (float(to_scale(name, end)) for end in intervals.of(name)[1:])
        halves[name] = 0.5 * (high - low)
    return halves
