"""The fit of shear-box tests: ladder of models, choice, other assumptions, blind predictions, verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ... import contract
from ...pattern import Pattern
from ..tables import warn_if
from .intervals import (
    AT_ONCE,
    Assumption,
    Estimate,
    Intervals,
    assumed,
    guessed,
    is_near_bond,
    softens,
    spreads,
    unseen,
    unseen_bond,
)
from .model import AUTO, CRUSHING, INCLINED, KS, KT, MORTAR, ROCK, SCALES, SIDES, SPRINGS, Model
from .rigid import LAW, SHAPES, SLOPES, WITHOUT
from .search import (
    Solution,
    by_law,
    check_known,
    choose,
    criteria,
    guesses,
    in_place_of_bond,
    is_noise,
    ladder,
    other_misfit,
    refitted,
    residuals,
    searched,
    shaped,
    with_crushing,
)
from .shear_test import ShearTest, check_copies, cycles, excludes_lift, shows_dilation, under_pressure
from .thresholds import BOUND_DISTANCE, GAIN, GOOD, NO_WIDTH, STIFF, WEIGHTS
from .verdict import (
    Comparison,
    Errors,
    Fit,
    blind,
    compared,
    errors_of,
    grade_of,
    missed_peaks,
    of_law,
    remarks,
    short,
    too_little,
    undetermined,
)


def fit(
    tests: Sequence[ShearTest],
    joint: str = AUTO,
    fixed: Mapping[str, float] | None = None,
    free: Sequence[str] | None = None,
    sides: int = SIDES,
    direction: float = 0.0,
    tick: Callable[[str], object] = lambda _: None,
) -> Fit:
    """Constants of measured tests, which `read_tests` returns or which are made of arrays.

    joint: "rock" without bond, "mortar" with one, or "auto", that which the tests support.  fixed: values
    that are known from elsewhere, by name, theta in degrees.
    free: these constants alone, in place of the ladder of models.  sides: inclined planes of the pattern.
    direction: of the slip, degrees.  tick: called with the name of every part of the fit when it begins.  The
    fit is a result if its `reasons` are empty.

    Raises ValueError for inadmissible names and values and for tests with too few rows.

    Examples
    --------
    >>> import numpy as np
    >>> from asperity import Interface, Material, Pattern
    >>> from asperity.tools.fit import ShearTest, fit
    >>> joint = Interface(Material.from_joint(kn=2e4, ks=1e3, mu=0.5), Pattern.regular(2, 20.0, flat=0.0))
    >>> slips, tests = np.linspace(0.0, 0.6, 31), []
    >>> for sigma_N in (-1.0, -2.0):
    ...     box = joint.confined_slip(0.0, slips, sigma_N=sigma_N)
    ...     opening = (box.dilation - box.dilation[0])[1:]
    ...     tests.append(ShearTest(f"{sigma_N}", slips[1:], box.tau[1:], opening, sigma_N))
    >>> result = fit(tests, joint="rock")
    >>> {name: round(result.values[name], 2) for name in ("mu", "theta")}
    {'mu': 0.5, 'theta': 20.0}
    """
    known = _checked(tests, joint, fixed or {}, free, sides, direction)
    usable = [_without_noise(test) for test in tests]
    shown = [test for test in usable if test.s_N is not None]
    # a dilation that was measured tells asperities from a bond
    measured = bool(shown)
    if shown and not {*INCLINED} & {*known} and not shows_dilation(shown):
        measured = all(excludes_lift(test) for test in shown)
        text = "" if measured else ", too much to see asperities in"
        warn_if(
            True, f"the dilation of the tests is noise{text}: the constants are those of the strength alone"
        )
        usable = [replace(test, s_N=None) for test in usable]
    strength = {name: known.pop(name) for name in CRUSHING if name in known}
    if free is not None:
        fixed_here = {"flat": 0.0} | known
        models = [Model(tuple(free), sides, fixed_here)]
    else:
        models = ladder(usable, joint, known, sides)
    rows = sum(test.slip.size for test in tests)
    if not models and joint == ROCK and not under_pressure(usable):
        raise ValueError("no pressure: a joint without bond carries nothing: expected joint mortar or auto")
    if not models:
        raise ValueError(f"{rows} rows in {len(tests)} tests: expected at least 6, for two constants")
    return _fit(usable, models, direction, tick, free is not None, measured, strength)


def _checked(
    tests: Sequence[ShearTest],
    joint: str,
    fixed: Mapping[str, float],
    free: Sequence[str] | None,
    sides: int,
    direction: float,
) -> dict[str, float]:
    """The known values, after a check of all arguments."""
    proper = isinstance(tests, Sequence) and tests and all(isinstance(test, ShearTest) for test in tests)
    if not proper:
        raise ValueError(f"tests = {contract.shown(tests)}: expected a list of tests, as that of read_tests")
    if joint not in (ROCK, MORTAR, AUTO):
        raise ValueError(f"joint = {joint!r}: expected {ROCK}, {MORTAR} or {AUTO}")
    if isinstance(free, str):
        raise ValueError(f"free = {free!r}: expected a sequence of names")
    if not np.isfinite(direction):
        raise ValueError(f"direction = {direction:g}: expected a finite angle in degrees")
    for what, names in (("fixed", fixed), ("free", free or ())):
        unknown = next((name for name in names if name not in SCALES), "")
        if unknown:
            raise ValueError(f"{what}: {unknown} is unknown: expected one of {', '.join(SCALES)}")
    crushing = ", ".join(name for name in CRUSHING if name in (free or ()))
    if crushing:
        raise ValueError(f"free: {crushing}: expected known, --set, as shear tests below fc do not show it")
    unused = ", ".join(name for name in CRUSHING if name in fixed)
    if unused and not fixed.get("fc"):
        raise ValueError(f"{unused}: expected with fc > 0, without which it has no effect")
    if free is not None:
        if not free or len({*free}) < len(free):
            raise ValueError(f"free: {', '.join(free) or 'none'}: expected names, each once")
        twice = ", ".join(name for name in free if name in fixed)
        if twice:
            raise ValueError(f"{twice}: expected it free or fixed, not both")
    bond = [name for name in ("sigma0", "Gc", "eta", "damage0") if name in fixed or name in (free or ())]
    if bond and (joint == ROCK or KS in fixed or KS in (free or ())):
        raise ValueError(
            f"{', '.join(bond)}: expected without {KS}, and not for rock: these are constants of a bond"
        )
    known = {name: contract.number(name, value) for name, value in fixed.items()}
    if not under_pressure(tests) and "mu" not in (free or ()):
        # without a pressure no row shows the friction
        known.setdefault("mu", 0.0)
    if free is not None:
        constants = {*free, *known}
        needed = ["sigma0", "Gc", "mu"] if {"sigma0", "Gc"} & constants else ["mu"]
        if len(needed) == 1 and not {KS, KT} & constants:
            needed.append(KS)
        if {"height", "crush", "W0", "flat"} & {*free}:
            needed.append("theta")
        missing = next((name for name in needed if name not in constants), "")
        if missing:
            raise ValueError(f"{missing}: expected it among the free ones, or a value, --set {missing}=")
    check_known(known)
    if sides != int(sides) or sides < 0:
        raise ValueError(f"sides = {sides!r}: expected a whole number, 0 or more")
    Pattern.regular(int(sides), known.get("theta") or 10.0, flat=known.get("flat", 0.0))
    check_copies(tests)
    return known


def _without_noise(test: ShearTest) -> ShearTest:
    """Test without a dilation that never changes, which was not measured."""
    return test if test.s_N is None or np.ptp(test.s_N) > 0.0 else replace(test, s_N=None)


def _fit(
    tests: list[ShearTest],
    models: list[Model],
    direction: float,
    tick: Callable[[str], object],
    of_user: bool = False,
    measured: bool = True,
    strength: Mapping[str, float] = MappingProxyType({}),
) -> Fit:
    """Fit by a ladder of models.

    of_user: the model is that of the user, which no other one replaces.
    measured: whether a test had a dilation.  strength: constants of a known compressive strength.
    """
    guess, known = guesses(tests), models[0].fixed
    solutions = _climbed(tests, models, guess, direction, tick)
    index, bic = choose(solutions)
    index = index if of_user else in_place_of_bond(solutions, index, bic)
    found, notes = (solutions[index], []) if of_user else _spring(tests, solutions[index], guess, direction)
    tick("all rows")
    own = by_law(refitted(found, tests, weight=_weight(found)))
    tick("other assumptions")
    forms = shaped(own, tests, known, of_user)
    chosen = _of_shape(own, forms, known)
    assumptions = [*assumed(chosen, own, tests, forms)]
    notes += _of_assumptions(own, chosen, assumptions, bool(forms) or of_user or cycles(tests))
    bare = _in_law(chosen, tests)
    law = with_crushing(bare, strength) if strength else bare
    tick("blind predictions")
    fitted = compared(law.problem, law.values)
    predicted, left_out = blind(chosen, tests)
    pressed = Intervals(chosen, spreads(chosen, left_out), assumptions)
    intervals = replace(pressed, assumptions=[*assumptions, *unseen(chosen, tests, pressed)])
    estimates = {name: intervals.of(name) for name in chosen.model.free}
    errors = errors_of(law, tests, fitted, predicted)
    loose = undetermined(estimates, _unshown(chosen))
    reasons: list[str] = []
    for is_reason, text in (
        *_of_crushing(bare, law, fitted),
        *_of_errors(errors, tests),
        *_of_peaks(fitted, tests),
        *_of_widths(estimates, loose, pressed, left_out, tests),
        *((True, text) for text in too_little(chosen, tests)),
        *_of_bond(chosen, law, solutions, bic, models, measured),
        *((False, text) for text in remarks(chosen, tests)),
        *_of_friction(tests, known),
    ):
        (reasons if is_reason else notes).append(text)
    tried = [(other.model.free, value - bic[index]) for other, value in zip(solutions, bic, strict=True)]
    grade = grade_of(max(errors.of_law.values()))
    judged = (fitted, predicted, errors.all, grade, reasons, notes, intervals.assumptions, tried, loose)
    return Fit(tests, law, intervals, estimates, *judged)


def _climbed(
    tests: list[ShearTest],
    models: Sequence[Model],
    guess: Mapping[str, float],
    direction: float,
    tick: Callable[[str], object],
) -> list[Solution]:
    """Solutions of a ladder of models, each from those of smaller ones on."""
    solutions: list[Solution] = []
    for model in models:
        tick("+".join(model.free))
        smaller = [solution for solution in solutions if {*solution.model.free} < {*model.free}]
        if any(is_noise(solution) for solution in smaller):
            continue
        starts = [
            {**guess, **{k: v for k, v in solution.values.items() if k in model.free}}
            for solution in reversed(smaller[-2:])
        ]
        solutions.append(searched(tests, model, [*starts, guess], direction))
    return solutions


def _weight(solution: Solution) -> float:
    """Weight of the dilation beside the strength, by which both have the same scatter."""
    scatter = solution.scatter
    if "dilation" not in scatter:
        return 1.0
    return float(np.clip(scatter["tau"] / max(scatter["dilation"], 1e-12), *WEIGHTS))


def _of_shape(own: Solution, forms: Sequence[Solution], known: Mapping[str, float]) -> Solution:
    """The fit of the law, or that of the shape by which the tests are explained better.

    Its constants mean the same, and give the law the peaks and ends of the tests.
    """
    usable = [form for form in forms if not form.model.shape.startswith(WITHOUT)]
    values = criteria([own, *usable])
    # a stiffness of the joint that the user gives has no closed form
    better = min(values) < min(values[:2]) - GAIN and KS not in known
    return usable[int(np.argmin(values[1:]))] if better else own


def _of_assumptions(
    own: Solution, chosen: Solution, assumptions: Sequence[Assumption], tried: bool
) -> Iterator[str]:
    """Notes about shapes and assumptions that the tests prefer; tried: whether there could be any."""
    if not tried and (own.model.bond or "theta" in own.model.free):
        yield (
            "other shapes of slope and softening were not tried: sides, direction or known constants leave "
            "no closed form"
        )
    if chosen is not own:
        constants = ", ".join(f"{n} {own.values[n]:.3g}" for n in own.model.free if n not in SPRINGS)
        shape = chosen.model.shape
        yield f"the tests have another shape than the law, {shape}; the law's own best: {constants}"
    told = (assumption for assumption in assumptions if assumption.name in BETTER)
    preferred = min(told, key=lambda assumption: assumption.difference, default=None)
    if preferred and preferred.difference < -GAIN:
        constants = ", ".join(f"{name} {preferred.values[name]:.3g}" for name in preferred.parts)
        yield f"{BETTER[preferred.name.split(',')[0]]}: {constants}"


def _in_law(chosen: Solution, tests: Sequence[ShearTest]) -> Solution:
    """The constants of a fit in the law itself."""
    if not chosen.problem.is_closed_form:
        return chosen
    problem = of_law(chosen, tests, chosen.problem.weight)
    return Solution(replace(chosen.model, shape=LAW), problem, chosen.x, residuals(problem, chosen.x))


def _of_errors(errors: Errors, tests: Sequence[ShearTest]) -> Iterator[tuple[bool, str]]:
    """What the errors say of the law: whether it is a reason why there is no result, and a sentence."""
    beyond = errors.of_law
    grade, worst = grade_of(max(beyond.values())), max(beyond, key=lambda name: beyond[name])
    if grade == "poor":
        most = errors.worst.get(worst, "")
        where = f", most in {short(most)}" if most and len(tests) > 1 else ""
        yield True, f"the law misses the {worst} by {errors.all[worst]:.0%}{where}"
    if grade != grade_of(max(errors.all.values())):
        spread = {n: value for n, value in errors.spread.items() if value > GOOD and "blind" not in n}
        differ = ", ".join(f"{name} {value:.0%}" for name, value in spread.items())
        text = f"; the tests differ (standard deviation: {differ})" if differ else ""
        yield (
            False,
            "the grade leaves out the noise of the measured numbers and what differs from test to test"
            f"{text}",
        )


def _of_crushing(bare: Solution, law: Solution, fitted: Sequence[Comparison]) -> Iterator[tuple[bool, str]]:
    """The same of a compressive strength that the fit leaves out: by how much it moves a number of a test."""
    if not other_misfit(law.residuals, bare.residuals):
        return
    moved = [0.0]
    for one, other in zip(compared(bare.problem, bare.values), fitted, strict=True):
        moved += [
            abs(other.predicted[name] - one.predicted[name]) / max(abs(one.predicted[name]), 1e-300)
            for name in one.errors
        ]
    fc, begin = law.values["fc"], law.values["fc"] / (3.0 if law.values.get("kp") else 1.0)
    text = (
        f"fc = {fc:.3g}, which the fit leaves out, moves a peak, a residual or a dilation by {max(moved):.0%}"
    )
    where = f"tests of which sqrt(p^2 + Css tau^2) stays below {begin:.3g} do not crush the joint"
    yield max(moved) > GOOD, f"{text}: {where}"


def _of_peaks(fitted: Sequence[Comparison], tests: Sequence[ShearTest]) -> Iterator[tuple[bool, str]]:
    """The same of the peaks that the law misses most, above and below."""
    for missed, limit, sentence in missed_peaks(fitted, tests):
        if missed > limit:
            expected = f"expected at most {limit:.0%} beyond noise and scatter of specimens"
            yield True, f"{sentence}, {expected}: another law is needed, or the specimens differ"
        elif missed > GOOD:
            yield False, sentence


def _at_bounds(chosen: Solution) -> list[str]:
    """Constants at an end of their plausible range."""
    low, high = chosen.problem.ends if chosen.x.size else (chosen.x, chosen.x)
    near = np.minimum(chosen.x - low, high - chosen.x) < BOUND_DISTANCE * (high - low)
    return [name for name, at_bound in zip(chosen.model.free, near, strict=True) if at_bound]


def _unshown(chosen: Solution) -> list[str]:
    """Constants whose value is that of a bound or of an assumption, however narrow the interval is."""
    elastic = ["Gc"] if "Gc" in chosen.model.free and not softens(chosen) else []
    return [*_at_bounds(chosen), *elastic]


def _of_widths(
    estimates: Mapping[str, Estimate],
    loose: Sequence[str],
    pressed: Intervals,
    left_out: Sequence[Solution],
    tests: Sequence[ShearTest],
) -> Iterator[tuple[bool, str]]:
    """The same of constants that are not determined; pressed: intervals without what no row shows."""
    no_width = [name for name, one in estimates.items() if one.half < NO_WIDTH and name not in SPRINGS]
    if no_width:
        yield True, f"the interval of {', '.join(no_width)} has no width: the rows do not show it"
    unshown = _unshown(pressed.solution)
    for name in loose:
        value, below, above = estimates[name]
        text = f"{name} is not determined: {value:.3g} [{below:.3g}, {above:.3g}]"
        if name in SPRINGS:
            yield False, f"{text}; the other constants do not depend on it"
        elif name == "crush" or (name in HOLDS and not undetermined({name: pressed.of(name)}, unshown)):
            yield False, f"{text}; the strengths hold {HOLDS.get(name, HOLDS['theta'])}"
        elif pressed.by_tests(name) and name not in unshown:
            without = [fit.values[name] for fit in left_out]
            ends = int(np.argmin(without)), int(np.argmax(without))
            apart = " and ".join(f"{without[i]:.3g} without {short(tests[i].name)}" for i in ends)
            yield True, f"{text}; it is {apart}; further specimens would show it"
        else:
            yield True, f"{text}; {HELP.get(name, 'further tests')} would show it"


def _of_bond(
    chosen: Solution,
    law: Solution,
    solutions: Sequence[Solution],
    bic: Sequence[float],
    models: Sequence[Model],
    measured: bool,
) -> Iterator[tuple[bool, str]]:
    """The same of a bond that the tests do not show, or of one that may be there."""
    if not chosen.model.bond:
        if is_near_bond(solutions, bic):
            yield False, "the tests do not exclude a bond beside the friction and the asperities"
        return
    auto = _joint_of(models) == AUTO
    if auto:
        yield from ((True, text) for text in guessed(chosen, solutions, bic, measured))
    reason, note = unseen_bond(law, auto, models[0].fixed)
    yield from ((is_reason, text) for is_reason, text in ((True, reason), (False, note)) if text)


def _of_friction(tests: Sequence[ShearTest], known: Mapping[str, float]) -> Iterator[tuple[bool, str]]:
    """The same of a friction that is assumed to be 0."""
    if not under_pressure(tests):
        yield (
            False,
            "no pressure: nothing is known about the friction; mu = 0 is assumed unless it is given",
        )
    elif known.get("mu") == 0.0:
        yield (
            False,
            "mu = 0 was given: a joint without friction, with the strength of its bond or slope alone",
        )


def _joint_of(models: Sequence[Model]) -> str:
    """Form of the joints of a ladder."""
    forms = {MORTAR if model.bond else ROCK for model in models}
    return forms.pop() if len(forms) == 1 else AUTO


BETTER = {name: f"a {name} in place of that of the law explains the tests better" for name in SLOPES}
BETTER |= dict.fromkeys(
    (name for name in SHAPES if name.startswith(WITHOUT)),
    "the slope of the dilation adds less friction than that of the law; without any",
)
BETTER[AT_ONCE] = "friction acts before the bond is damaged; from the first slip on"
"""What tests say that prefer another assumption."""

HOLDS = {"theta": "between the pressures of the tests", "height": "up to the slips of the tests"}
"""Where strengths hold without a constant that is beyond the rows."""

HELP = {
    "mu": "rows beyond the peak, up to the residual strength",
    "theta": "a measured dilation, or a second pressure",
    "height": "a longer slip, until the dilation ends",
    "sigma0": "more rows about the peak, or a smaller pressure",
    "Gc": "more rows between peak and residual strength",
    "crush": "tests at pressures further apart",
    "W0": "more cycles",
}
"""What shows a constant."""


def _spring(
    tests: list[ShearTest], solution: Solution, guess: Mapping[str, float], direction: float
) -> tuple[Solution, list[str]]:
    """The model with a rigid spring where the rows do not show it; and notes.

    A constant at the value that means stiff is stiff, and not undetermined.
    """
    if KT not in solution.model.free or cycles(tests):
        return solution, []
    stress, length = solution.problem.size
    start = [{**guess, **solution.values}, guess]
    stiff = solution.model.without(KT, **{KT: STIFF * stress / length})
    rigid = searched(tests, stiff, start, direction, 1)
    with_spring, without = criteria([solution, rigid])
    if without < with_spring:
        return rigid, ["the spring in series (kT) is rigid: the rows do not show its stiffness"]
    return solution, []
