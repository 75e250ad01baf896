"""Constants of the law from shear-box tests: least squares on the forward model, by lmfit."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ... import contract
from ...contract import Floats
from ...parallel import map_in_order
from . import model
from .checks import refuse, shows_dilation, warn_if
from .model import BOND, INCLINED, KS, MORTAR, PLAUSIBLE, ROCK, SCALES, SIDES, Problem, plausible
from .records import ShearTest
from .result import BETTER, ENOUGH, REFINE, SAME, Fit

STEP = 1.0e-3
"""Step of the differences on the scales of the constants, relative to their ranges of the order of one.

The error of central ones is STEP**2 times the third derivative, 1e-6 where the law is smooth; that of the
solver, 1e-13 to 1e-12 over STEP, is far below.
"""

SAMPLES, STARTS_TRIED, AGREEING, MORE_STARTS = 48, 5, 3, 3
"""Points of a Latin hypercube, the best of which are the starts; number of starts; where fewer than AGREEING
reach the smallest sum, up to MORE_STARTS times as many: one in four ends in the local minimum of a curve that
never softens (small s_f).
"""

FOUND, SEARCHED, MOST_EVALUATIONS = 1.0e-8, 1.0e-4, 60
"""Relative change of the sum of squares at which the least squares end, and a search from a start; largest
number of evaluations of the model in each, besides those for derivatives.
"""

MOST_WEIGHT = 5.0
"""Largest weight of the dilation beside tau, which weighs each by its own scatter, and its inverse."""

REFINEMENTS, MOST_ROWS = 3, 400000
"""Largest number of refinements, which divide an increment by at most 64, and of increments of a test in the
finest model: 150 MB of state for nine planes.
"""


def fit(
    tests: Sequence[ShearTest],
    free: Sequence[str] | None = None,
    fixed: Mapping[str, float] | None = None,
    start: Mapping[str, float] | None = None,
    sides: int | None = None,
    direction: float = 0.0,
    starts: int = STARTS_TRIED,
    model_error: float = 0.0,
    joint: str = model.AUTO,
    tick: Callable[[str], object] = lambda _: None,
) -> Fit:
    """Least-squares constants of measured tests, which `read_tests` returns or which are made of arrays.

    free, fixed: names, and values by name, theta in degrees. Without `free` those are free that shear-box
    tests show and that are not fixed, and names that begin with + are added to them; others have their
    default. start: an additional start, by name. sides: inclined planes (None: 8, or 0 for tests without
    dilation and theta). direction: of the slip, degrees. starts: number of starts. model_error: accepted
    scatter, over the range, of a model that differs from the tests by more than noise; it widens the
    intervals. joint: "mortar" with a bond, "rock" without, or "auto", that with the smaller information
    criterion. tick: called with the name of every part of a fit when it is done. The fit is a result if its
    `failed_checks` are empty.

    Raises ValueError for inadmissible names and values and for fewer data than the free constants need.

    Examples
    --------
    >>> import numpy as np
    >>> from asperity import Interface, Material, Pattern
    >>> from asperity.tools.fit import ShearTest, fit
    >>> joint = Interface(Material(1.5, 0.15, 0.9, 0.5, kc=20.0), Pattern.regular(2, 20.0))
    >>> box = joint.confined_slip(0.0, np.linspace(0.0, 0.6, 31), sigma_N=-1.0)
    >>> test = ShearTest("box", box.slip_along()[1:], box.tau[1:], (box.dilation - box.dilation[0])[1:], -1.0)
    >>> known = {"sigma0": 1.5, "Gc": 0.15, "eta": 0.9, "kc": 20.0, "flat": 1 / 3}
    >>> found = fit([test], free=["mu", "theta"], fixed=known, sides=2, starts=2)
    >>> {name: round(one.value, 3) for name, one in found.estimates.items()}
    {'mu': 0.5, 'theta': 20.0}
    """
    proper = isinstance(tests, Sequence) and tests and all(isinstance(one, ShearTest) for one in tests)
    refuse(not proper, f"tests = {contract.shown(tests)}: expected a list of tests, as that of read_tests")
    refuse(isinstance(free, str), f"free = {free!r}: expected a sequence of names")
    whole = 1 <= contract.number("starts", starts) <= SAMPLES and starts == int(starts)
    refuse(not whole, f"starts = {starts!r}: expected 1 to {SAMPLES}, a whole number")
    fraction = 0.0 <= model_error < 1.0
    refuse(not fraction, f"model_error = {model_error:g}: expected a fraction of the range, 0 to 1")
    refuse(not np.isfinite(direction), f"direction = {direction:g}: expected a finite angle in degrees")
    fixed, start = dict(fixed or {}), dict(start or {})
    named = {*(name.lstrip("+") for name in free or ()), *fixed, *start}
    # a dilation that never changes was not measured; one that is noise shows that there is none
    noise = not {*INCLINED} & named and not shows_dilation(tests)
    warn_if(
        noise and any(one.s_N is not None and np.ptp(one.s_N) for one in tests),
        "the dilation of the tests is noise: the joint is taken as flat",
    )
    tests = [
        replace(one, s_N=None) if one.s_N is not None and (noise or not np.ptp(one.s_N) > 0.0) else one
        for one in tests
    ]
    forms = _forms(named, joint)
    problems = [problem_of(tests, form, free, fixed, start, sides, direction) for form in forms]
    rough = {one.form: replace(search(one, start, starts, tick), model_error=model_error) for one in problems}
    criteria = {form: float(one.result.bic) for form, one in rough.items()}
    form = min(rough, key=lambda one: criteria[one])
    # a bond that the tests do not determine is not there if they fit as well without
    needless = len(rough) > 1 and BETTER * rough[ROCK].costs[0] <= rough[MORTAR].costs[0]
    if needless and rough[MORTAR].loose_bond:
        form = ROCK
    found = _refined(problems[forms.index(form)], replace(rough[form], criteria=criteria), tick)
    if form == MORTAR and needless and found.loose_bond:
        found = _refined(problems[forms.index(ROCK)], replace(rough[ROCK], criteria=criteria), tick)
    return found


def search(
    problem: Problem,
    start: Mapping[str, float],
    starts: int = 1,
    tick: Callable[[str], object] = lambda _: None,
) -> Fit:
    """Fit of few rows in few increments, from a start, if any, and the best points of a Latin hypercube.

    It ends where AGREEING of the starts reach the same smallest sum of squares.
    """
    coarse, ranked, found = problem.coarse(), [], []
    if set(start) != set(problem.free) or starts > 1:
        points = _hypercube(coarse)
        costs = [float(r @ r) for r in map_in_order(coarse.residuals, points, None)]
        ranked = [points[i] for i in np.argsort(costs)]
    if start:
        ranked.insert(0, coarse.x((coarse.values(ranked[0]) if ranked else {}) | dict(start)))
    for x in ranked[: MORE_STARTS * starts if starts > 1 else 1]:
        sums = sorted(float(one.chisqr) for one in found)
        if len(sums) >= starts and sums[min(AGREEING, starts) - 1] <= SAME * sums[0]:
            break
        found.append(minimise(coarse.residuals, coarse.free, x, coarse.ends, SEARCHED))
        tick(f"start {len(found)} of {starts}, {problem.form}")
    found.sort(key=lambda one: float(one.chisqr))
    return Fit(coarse, found[0], tuple(float(one.chisqr) for one in found))


def _hypercube(problem: Problem) -> list[Floats]:
    """Points on the scales of the constants, SAMPLES of a Latin hypercube."""
    from scipy.stats import qmc

    ranges = []
    for name in ("s_f" if name == "Gc" else name for name in problem.free):
        low, high = model.to_scale(name, plausible(name, *problem.size, PLAUSIBLE | model.STARTS))
        margin = 0.0 if name in model.STARTS else (high - low) / 3.0
        ranges.append((low + margin, high - margin))
    sampler = qmc.LatinHypercube(len(ranges), rng=0)
    points = qmc.scale(sampler.random(SAMPLES), *np.transpose(ranges))
    if "Gc" in problem.free:
        points[:, problem.free.index("Gc")] += [np.log(0.5 * problem.values(x)["sigma0"]) for x in points]
    return list(np.clip(points, *problem.ends))


def _refined(problem: Problem, rough: Fit, tick: Callable[[str], object]) -> Fit:
    """Fit of all rows, whose increments are divided until they move no constant."""
    # residuals that are no noise say nothing about weights
    tau, dilation = rough.scatter
    if not rough.dependent and dilation > 0.0:
        problem = replace(problem, weight=float(np.clip(tau / dilation, 1.0 / MOST_WEIGHT, MOST_WEIGHT)))
    x, slopes = rough.x, lambda x: differences(problem.residuals, x)
    while True:
        result = minimise(problem.residuals, problem.free, x, problem.ends, FOUND, slopes)
        found = replace(rough, problem=problem, result=result)
        parts = problem.refinement * REFINE
        finer = replace(problem, refinement=parts)
        shift = found.shift_by(finer.residuals(found.x) - found.residuals)
        tick(f"1/{parts} of the increments")
        longest = max(slips.size for slips, _ in finer.paths)
        if shift <= ENOUGH or parts > REFINE**REFINEMENTS or REFINE * longest > MOST_ROWS:
            return replace(found, shift=shift)
        # the derivatives of the coarser model are near enough
        x, problem, slopes = found.x, finer, lambda _, known=found.result.jac: known


def minimise(
    residuals: Callable[[Floats], Floats],
    names: Sequence[str],
    x: Floats,
    ends: Floats,
    tolerance: float = FOUND,
    derivatives: Callable[[Floats], Floats] | None = None,
    step: float = STEP,
) -> Any:
    """Result of lmfit for constants on their scales, between the ends (2, p), from x on.

    derivatives: of the residuals; None: forward differences with a step.
    """
    import lmfit

    parameters, margin = lmfit.Parameters(), 1e-6 * np.ptp(ends, axis=0)
    for name, *row in zip(names, np.clip(x, ends[0] + margin, ends[1] - margin), *ends, strict=True):
        parameters.add(name, row[0], min=row[1], max=row[2])

    def vector(parameters: Any) -> Floats:
        return np.array([*parameters.valuesdict().values()])

    def jacobian(x: Floats) -> Floats:
        return derivatives(x) if derivatives else differences(residuals, x, step, residuals(x))

    # the errors of constants without influence are no numbers
    with np.errstate(divide="ignore", invalid="ignore"):
        result = lmfit.minimize(
            lambda now: residuals(vector(now)),
            parameters,
            method="least_squares",
            jac=lambda now: jacobian(vector(now)),
            x_scale="jac",
            max_nfev=MOST_EVALUATIONS,
            **{"ftol": tolerance, "xtol": 10.0 * tolerance, "gtol": tolerance},
        )
    if result.aborted:
        result.x = vector(result.params)
        result.jac = jacobian(result.x)
    return result


def differences(
    residuals: Callable[[Floats], Floats], x: Floats, step: float = STEP, here: Floats | None = None
) -> Floats:
    """Derivatives of residuals by central differences, or with the residuals at x by forward ones."""
    steps = np.diag(step * np.maximum(1.0, 0.1 * np.abs(x)))
    found = np.array(map_in_order(residuals, [*(x + steps), *(x - steps if here is None else [])], None))
    if here is None:
        return (found[: x.size] - found[x.size :]).T / (2.0 * np.diag(steps))
    return (found - here).T / np.diag(steps)


def _forms(names: Collection[str], joint: str) -> list[str]:
    """Forms of a joint that are possible with these constants free or set; raises ValueError."""
    of_bond = [name for name in BOND if name in names]
    known = joint in (ROCK, MORTAR, model.AUTO)
    refuse(not known, f"joint = {joint!r}: expected {ROCK}, {MORTAR} or {model.AUTO}")
    bond = f"{', '.join(of_bond)}: expected without {KS}, which is that of a joint without bond"
    refuse(of_bond and (KS in names or joint == ROCK), bond)
    refuse(KS in names and joint == MORTAR, f"{KS}: expected without a bond, --joint {ROCK}")
    possible = [MORTAR] if of_bond else [ROCK] if KS in names else [MORTAR, ROCK]
    return possible if joint == model.AUTO else [joint]


def _default_free(problem: Problem, form: str, fixed: Mapping[str, float]) -> list[str]:
    """Constants that are free unless they are set: those which shear-box tests of this form can show.

    theta needs a measured dilation, flat and kc this or theta, and height a dilation that ends.
    """
    tests, free = problem.tests, [KS, "mu"] if form == ROCK else ["sigma0", "Gc", "eta", "mu"]
    dilates = any(test.s_N is not None for test in tests)
    if any(test.envelope for test in tests):
        return free[-1:] if form == ROCK else ["sigma0", "mu"]
    if problem.sides == 0 or not (dilates or fixed.get("theta")):
        return free
    free += ["theta"] * dilates + ["flat", "kc"]
    return free + ["height"] * any(test.saturates for test in tests)


def problem_of(
    tests: Sequence[ShearTest],
    form: str,
    wanted: Sequence[str] | None,
    fixed: Mapping[str, float],
    start: Mapping[str, float],
    sides: int | None,
    direction: float,
) -> Problem:
    """Problem of a fit; raises ValueError for inadmissible names and values and too few data."""

    def only(what: str, names: Collection[str], allowed: Collection[str], text: str) -> None:
        other = ", ".join(name for name in names if name not in allowed)
        refuse(other, f"{what}: {other}{text}")

    free = [name.removeprefix("+") for name in wanted or ()]
    for what, names in (("free", free), ("set", fixed), ("start", start)):
        only(what, names, SCALES, f" is unknown: expected one of {', '.join(SCALES)}")
    only("free, set", free, {*SCALES} - {*fixed}, ": expected it free or set, not both")
    sloped = [name for name, value in fixed.items() if value and name != "flat"]
    if sides is None:
        inclines = {*INCLINED} & {*free, *sloped} or any(test.s_N is not None for test in tests)
        sides = SIDES if inclines else 0
    empty = Problem(list(tests), (), {}, sides, float(direction))
    if wanted is None or any(name.startswith("+") for name in wanted):
        shown = _default_free(empty, form, fixed)
        free = [name for name in shown if name not in fixed and name not in free] + free
    once = free and len(set(free)) == len(free)
    refuse(not once, f"free: {', '.join(free) or 'none'}: expected names, each once")
    only("start", start, free, f": expected one of the free ones, {', '.join(free)}")
    for what, names in (("free", free), ("set", sloped)) if sides == 0 else ():
        even = {*SCALES} - {*INCLINED}
        only(what, names, even, ": expected inclined planes, which sides = 0 does not have")
    # the contact of a joint without bond is stiff
    usual = {"kc": 20.0} if form == ROCK else {}
    known = model.DEFAULTS | usual | ({"theta": 0.0} if sides == 0 else {}) | dict(fixed)
    names = [name for name in SCALES if name not in (BOND if form == ROCK else (KS,))]
    missing = next((name for name in names if name not in free and name not in known), "")
    why = " (no dilation was measured that shows it)" if missing == "theta" and wanted is None else ""
    refuse(missing, f"{missing}: expected it among the free ones, or a value, --set {missing}={why}")
    flattest, theta = PLAUSIBLE["theta"][0], known.get("theta", 0.0)
    angle = f"set: theta = {theta:g}: expected degrees, 0 or at least {flattest:g} (a radian is 57.3)"
    refuse(0.0 < theta < flattest, angle)
    values = {name: contract.number(name, known[name]) for name in names if name not in free}
    problem = replace(empty, free=tuple(free), fixed=values)
    # refuses values that no joint has
    problem.interface(problem.values(problem.ends.mean(axis=0)))
    count, least = len(problem.rows), 2 * len(free)
    few = f"{count} values in {len(tests)} tests: expected more than {least}, twice the {len(free)} free"
    refuse(count <= least, f"{few} constants")
    return problem
