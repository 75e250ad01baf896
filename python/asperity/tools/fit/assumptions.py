"""What a fit assumes, each replaced by its alternatives, which the intervals contain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from .evidence import first_stroke, guesses
from .intervals import Assumption, Intervals, spreads
from .ladder import GAIN, STIFF, Model, independent
from .model import KS, KT, SPRINGS, to_scale
from .shear_test import ShearTest
from .squares import SEARCHED, Solution, solve

SIDES, FLAT, BRITTLE, RIGID, TIMES = 8, 1.0 / 3.0, 0.99, 1.0 - 1.0e-6, 2.0
PATTERNS = ("8 sides", "flat 1/3")
PLACES = ("spring in series", "spring in the joint", "elastic slip of the bond (eta)")
RIGID_FRICTION = "friction from the first slip on"
"""Pattern and flat plane in place of two sides; eta in place of 0.999; and factor on a given stiffness; and
names of other patterns, of other places of the elastic slip and of friction beside a bond that grows at once.
"""


def alternatives(
    chosen: Solution, solutions: Sequence[Solution], bic: Sequence[float], index: int
) -> list[tuple[Solution, Model]]:
    """Models in place of the chosen one, and the solutions from which their fits start."""
    base, made = chosen.model, []

    def add(model: Model, name: str, start: Solution = chosen) -> None:
        made.append((start, replace(model, name=name)))

    def fixed(**values: float) -> Model:
        return replace(base, fixed={**base.fixed, **values})

    if base.bond and KT in base.free and "eta" not in base.fixed:
        add(fixed(eta=BRITTLE), "friction that grows with the damage of the bond")
        add(base.instead(KT, "eta"), "elastic slip of the bond (eta)")
    if base.bond and "eta" in base.free and first_only(chosen.problem.tests):
        add(base.instead("eta", KT), "spring in series")
    if "theta" in base.free:
        # on one stroke of a rigid joint without crushed asperities the pattern has no effect
        if {"crush", "W0"} & {*base.free} or not base.series or base.bond:
            if base.sides == 2:
                add(replace(base, sides=SIDES), PATTERNS[0])
            if "flat" not in base.fixed:
                add(fixed(flat=FLAT), PATTERNS[1])
        if KT in base.free and not base.bond:
            contact = {"kc": STIFF} if first_only(chosen.problem.tests) else {}
            add(base.instead(KT, KS, **contact), PLACES[1])
        elif KS in base.free and not first_only(chosen.problem.tests):
            add(base.instead(KS, KT), PLACES[0])
        elif KS in base.free and "W0" not in base.free:
            series = base.instead(KS, KT)
            add(
                replace(series, fixed={k: v for k, v in series.fixed.items() if k != "kc"}),
                "spring in series",
            )
    for name in ("ks", "kc", "kT"):
        if name in base.fixed and any(name in solution.model.fixed for solution in solutions):
            value = base.fixed[name]
            add(fixed(**{name: TIMES * value}), f"{name} {TIMES * value:.3g}")
            add(fixed(**{name: value / TIMES}), f"{name} {value / TIMES:.3g}")
    ladder = solutions[index].model
    if any(name in base.fixed and name in ladder.free for name in SPRINGS):
        # a spring that the rows do not show was taken as rigid
        add(ladder, PLACES[0] if KT in ladder.free else PLACES[1], solutions[index])
    for i, (solution, value) in enumerate(zip(solutions, bic, strict=True)):
        if i != index and value < min(bic) + GAIN:
            label = "+".join(solution.model.free)
            add(solution.model, f"{'mortar' if solution.model.bond else 'rock'}, {label}", solution)
    return made


def first_only(tests: Sequence[ShearTest]) -> bool:
    """Whether no slip is reversed."""
    return all(first_stroke(test).stop == test.slip.size for test in tests)


def of_friction(
    chosen: Solution, tests: Sequence[ShearTest], given: Mapping[str, float]
) -> Iterator[Assumption]:
    """Bond beside which friction acts from the first slip on, as on rigid sides, while that of the law grows.

    given: values of the user, which stay.
    """
    solution = at_once(chosen, tests, given, RIGID)
    if solution is None:
        return
    # a spring that the law does not need, as its friction is late, is no further constant
    square, own = (max(fit.mean_squares["tau"], 1e-12) for fit in (solution, chosen))
    difference = independent(chosen)["tau"] * float(np.log(square / own))
    parts, halves = ("mu", "sigma0", "Gc", KT), halves_of(solution)
    yield Assumption(RIGID_FRICTION, difference, solution.values, difference < GAIN, parts, halves)


def at_once(
    chosen: Solution, tests: Sequence[ShearTest], given: Mapping[str, float], eta: float
) -> Solution | None:
    """Closed form of a bond beside which friction acts at once, with a spring in series; None without one."""
    model = chosen.model
    if not model.bond or "eta" in given or not first_only(tests):
        return None
    free = tuple(name for name in model.free if name not in ("eta", KT))
    fixed = {name: value for name, value in model.fixed.items() if name != KT} | {"eta": eta}
    if KT in given:
        fixed[KT] = given[KT]
    else:
        free = (KT, *free)
    if model.name in PATTERNS:
        fixed["flat"] = 0.0
    rigid = Model(free, min(model.sides, 2), fixed)
    problem = rigid.problem(tests, chosen.problem.weight, chosen.problem.direction)
    known = chosen.values
    if KT not in model.free:
        known = known | {KT: guesses(tests)[KT]}
    closed = problem.closed_form()
    if not closed.is_closed_form:
        return None
    return Solution(rigid, closed, *solve(closed, closed.x(known), SEARCHED))


def halves_of(solution: Solution, left_out: Sequence[Solution] = ()) -> dict[str, float]:
    """Half widths of the intervals of a solution, on the scales of its constants.

    left_out: fits without each of the tests.
    """
    own, halves = Intervals(solution, spreads(solution, left_out), []), {}
    for name in solution.model.free:
        low, high = (float(to_scale(name, end)) for end in own.of(name)[1:])
        halves[name] = 0.5 * (high - low)
    return halves
