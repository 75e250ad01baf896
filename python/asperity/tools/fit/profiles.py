"""Slope and height of asperities by profiles that the law has and has not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...contract import Floats
from .assumptions import beside, first_only, halves_of
from .evidence import first_stroke
from .intervals import Assumption
from .ladder import GAIN, criteria, independent
from .model import KS, KT, SCALES
from .rigid import Profile, exponential, has_closed_form, parabola
from .series import Parabola
from .shear_test import ShearTest
from .squares import SEARCHED, Solution, refitted, solve

LINE = "a slope that falls along a line"
"""Name of the profile that ends."""


def of_profile(chosen: Solution, tests: Sequence[ShearTest]) -> Iterator[Assumption]:
    """Constants of asperities whose slope falls along a straight line, as that of the law does not.

    A first slope is that of a profile, and the tests may not show which one it is.
    """
    model = chosen.model
    if model.bond or not {"theta", "height"} <= {*model.free} or not first_only(tests):
        return
    if KS in model.free:
        model = model.instead(KS, KT)
    elif KS in model.fixed:
        fixed = {name: value for name, value in model.fixed.items() if name not in (KS, "kc")}
        model = replace(model, fixed=fixed | {KT: 0.5 * chosen.values[KS]})
    weight, start = chosen.problem.weight, refitted(chosen, tests, model, tolerance=SEARCHED)
    problem = start.problem
    rest = (problem.free, problem.fixed, problem.sides, problem.direction)
    if not has_closed_form(*rest):
        return
    straight = Parabola(problem.tests, *rest, problem.increments, weight)
    solution = Solution(model, straight, *solve(straight, start.x, SEARCHED))
    first, second = criteria([chosen, solution])
    # crush belongs to the profile, too
    parts = tuple(name for name in model.free if name != "crush")
    difference, halves = second - first, halves_of(solution)
    yield Assumption(LINE, difference, solution.values, difference < GAIN, parts, halves)


def of_dilation(chosen: Solution, tests: Sequence[ShearTest]) -> Iterator[Assumption]:
    """Slope and height beside a bond by the dilation alone, as those of rigid joints of two profiles.

    Their spring in series is that of the dilation, as the law may have put the elastic slip elsewhere.
    """
    measured = any(test.s_N is not None for test in tests)
    if not (chosen.model.bond and "theta" in chosen.model.free and measured):
        return
    yield _alone(chosen, tests, exponential, "the dilation alone")
    if "height" in chosen.model.free:
        yield _alone(chosen, tests, parabola, LINE)


def _alone(chosen: Solution, tests: Sequence[ShearTest], profile: Profile, name: str) -> Assumption:
    """Slope and height of a profile, from the first strokes."""
    from scipy.optimize import least_squares

    stress, length = chosen.problem.size
    slips, tractions, dilations, scales = [], [], [], []
    for test in tests:
        if test.s_N is not None:
            rows = first_stroke(test)
            slips.append(np.abs(test.slip[rows]))
            tractions.append(np.abs(test.tau[rows]))
            scales.append(max(float(np.ptp(test.s_N)), 1e-300))
            dilations.append(test.s_N[rows] / scales[-1])
    ends = "height" in chosen.model.free

    def misfit(x: Floats) -> Floats:
        slope, height = float(np.exp(x[0])), float(np.exp(x[-1])) if ends else 0.0
        own = [np.maximum(0.0, s - t / np.exp(x[1])) for s, t in zip(slips, tractions, strict=True)]
        heights = [profile(u, slope, height)[1] for u in own]
        return np.concatenate([z / s - d for z, s, d in zip(heights, scales, dilations, strict=True)])

    start = [np.log(np.tan(np.radians(chosen.values["theta"])))]
    start += [np.log(chosen.values.get(KT, 10.0 * stress / length))]
    if ends:
        start.append(np.log(max(chosen.values["height"], 1e-9)))
    least = least_squares(misfit, start, max_nfev=50)
    values = {"theta": float(np.degrees(np.arctan(np.exp(least.x[0]))))}
    values |= {"height": float(np.exp(least.x[-1]))} if ends else {}
    square = float(np.mean(least.fun**2))
    # twice the standard deviation of rows of which as many are independent as in the fit
    rows = square * least.fun.size / max(1.0, independent(chosen)["dilation"])
    sizes = 2.0 * np.sqrt(np.maximum(np.diag(np.linalg.pinv(least.jac.T @ least.jac)) * rows, 0.0))
    theta = np.radians(values["theta"])
    of_theta = float(np.degrees(sizes[0] * np.sin(theta) * np.cos(theta)))
    of_theta /= 1.0 if SCALES["theta"] == "linear" else values["theta"]
    halves = {"theta": of_theta, "height": float(sizes[-1])}
    return beside(chosen, square, values, name, "dilation", ("theta", "height"), halves)
