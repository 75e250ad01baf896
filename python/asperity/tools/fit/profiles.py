"""Shapes of slope and softening that the law has and has not, and other starts of slip and dilation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from .intervals import Assumption, Intervals, spreads
from .model import SPRINGS, rows_of, to_scale
from .rigid import SHAPES
from .search import Solution, criteria, ends, refitted, rigid_form, slopes_of, with_shape, with_starts
from .shear_test import ShearTest, cycles, first_slope, first_stroke
from .thresholds import GAIN, SEARCHED

STARTS, SHAPE_OF_LAW, AT_ONCE = "gauge offsets", "shape of the law", "friction at once behind a spring"
UNCRUSHED, ENDED_HERE = "the slope that the tests show", "a dilation that ends with the rows"
"""Names of starts of slip and dilation that fit best, of the law beside another shape, of a bond in closed
form, whose friction does not wait for the damage, of a slope that the pressure does not crush, and of a
height that the rows reach.
"""


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
