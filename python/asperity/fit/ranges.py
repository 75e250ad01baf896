"""Which parameters a fit may have: defaults, bounds, ranges of the starts, and their checks."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence

import numpy as np

from .. import contract
from ..contract import Floats
from .checks import LARGEST_RATIO
from .model import BOND, KS, SCALES, TIMELESS, Problem
from .shear_test import ShearTest

DEFAULT_FREE = ("sigma0", "Gc", "eta", "mu", "theta", "flat", "kc")
"""Parameters that are free unless they are set: by default every parameter is fitted."""

FLAT_FREE = ("sigma0", "Gc", "eta", "mu")
"""The same for a flat joint: its closing stiffness shows in no shear-box test."""

INCLINED = ("theta", "flat", "height", "W0")
"""Parameters of inclined planes."""

DEFAULT_FIXED = {"eta": 0.9} | {
    row.name: row.default for row in TIMELESS if row.default is not None and row.name != "theta"
}
"""Values of parameters that a given list of free ones leaves out."""

SAMPLES = 48
"""Points of a Latin hypercube; the best of them are the starts."""

RANGES = {
    "sigma0": ("stress", (1e-3, 30.0), (0.05, 2.0)),
    "Gc": ("work", (1e-6, 150.0), (0.01, 1.5)),
    "eta": ("", (0.05, 0.995), (0.4, 0.97)),
    "mu": ("", (0.01, 2.0), (0.15, 1.0)),
    "theta": ("", (0.5, 75.0), (5.0, 45.0)),
    "flat": ("", (0.005, 0.95), (0.1, 0.6)),
    "kc": ("", (0.1, 1e3), (0.5, 50.0)),
    "height": ("length", (1e-3, 1e3), (0.03, 3.0)),
    "W0": ("work", (1e-3, 1e3), (0.05, 5.0)),
    "closure": ("length", (1e-5, 1e2), (1e-3, 0.3)),
    "damage0": ("", (0.01, 0.99), (0.05, 0.95)),
    KS: ("stiffness", (1e-2, 1e5), (1.0, 1e3)),
    "s_f": ("length", (0.0, 0.0), (0.02, 1.5)),
}
RANGES |= {"sigma02": RANGES["sigma0"], "Gc2": RANGES["Gc"]}
"""Unit, bounds and range of the starts of a parameter; stress and length are the largest of the tests.

Starts are drawn of s_f in place of Gc, because the tests show the size of s_f.
"""


def needed(sides: int | None, given: Container[str]) -> list[str]:
    """Parameters that are free or set in a fit in which these are given."""
    names = FLAT_FREE if sides == 0 else DEFAULT_FREE
    return [KS, *(name for name in names if name not in BOND)] if KS in given else list(names)


def _sizes(tests: Sequence[ShearTest]) -> dict[str, float]:
    """Sizes of the units of RANGES."""
    stress = max(float(np.abs(test.tau).max()) for test in tests)
    length = max(float(np.abs(test.slip).max()) for test in tests)
    more = {"work": stress * length, "stiffness": stress / length}
    return {"": 1.0, "stress": stress, "length": length} | more


def checked_problem(
    tests: Sequence[ShearTest],
    free: Sequence[str],
    fixed: Mapping[str, float],
    bounds: Mapping[str, tuple[float, float]],
    sides: int,
    direction: float,
    increments: int,
) -> Problem:
    """Problem of a fit; raises ValueError for inadmissible names, values, bounds and too few data."""
    if not tests:
        raise ValueError("no tests: expected at least one")
    for what, names in (("free", free), ("set", fixed), ("bounds", bounds)):
        unknown = [name for name in names if name not in SCALES]
        if unknown:
            raise ValueError(f"{what}: {unknown[0]}: expected one of {', '.join(SCALES)}")
    if not free or len(set(free)) < len(free):
        raise ValueError(f"free: {', '.join(free) or 'none'}: expected names, each once")
    both = [name for name in free if name in fixed]
    if both:
        raise ValueError(f"{both[0]}: expected it free or set, not both")
    bound = [name for name in bounds if name not in free]
    if bound:
        raise ValueError(f"bounds: {bound[0]}: expected one of the free ones, {', '.join(free)}")
    unbonded = KS in free or KS in fixed
    of_bond = [name for name in BOND if unbonded and (name in free or name in fixed)]
    if of_bond:
        raise ValueError(f"{', '.join(of_bond)}: expected without ks, which is that of a joint without bond")
    known = DEFAULT_FIXED | ({"theta": 0.0} if sides == 0 else {}) | dict(fixed)
    names = [name for name in SCALES if name not in (BOND if unbonded else (KS,))]
    missing = [name for name in names if name not in free and name not in known]
    if missing:
        raise ValueError(f"{missing[0]}: expected it among the free ones, or a value set")
    inclined = [name for name in INCLINED if name in free]
    if sides == 0 and inclined:
        raise ValueError(
            f"free: {', '.join(inclined)}: expected inclined planes, which sides = 0 does not have"
        )
    flattest = RANGES["theta"][1][0]
    if 0.0 < known.get("theta", 0.0) < flattest:
        raise ValueError(
            f"set: theta = {known['theta']:g}: expected degrees, 0 or at least {flattest:g} "
            f"(a radian is {np.degrees(1.0):.1f})"
        )
    sizes = _sizes(tests)
    within = {}
    for name in free:
        unit, (low, high), _ = RANGES[name]
        within[name] = low * sizes[unit], high * sizes[unit]
    for name, (low, high) in bounds.items():
        if not 0.0 < low < high < SCALES[name].top:
            raise ValueError(
                f"bounds: {name} = {low:g}, {high:g}: expected 0 < low < high < {SCALES[name].top:g}"
            )
        within[name] = (low, high)
    if not np.isfinite(direction):
        raise ValueError(f"direction = {direction:g}: expected a finite angle in degrees")
    set_values = {
        name: contract.number(name, value)
        for name, value in known.items()
        if name in names and name not in free
    }
    problem = Problem(list(tests), tuple(free), set_values, within, sides, float(direction), increments)
    problem.interface(set_values | {name: float(np.sqrt(low * high)) for name, (low, high) in within.items()})
    if not unbonded:
        _check_lengths(problem, sizes["length"])
    count = problem.is_dilation.size
    if count <= 2 * len(free):
        raise ValueError(
            f"{count} values in {len(tests)} tests: expected more than {2 * len(free)}, twice "
            f"the {len(free)} free parameters"
        )
    return problem


def _check_lengths(problem: Problem, length: float) -> None:
    """Raise ValueError where the slips cannot have the unit of 2 Gc/sigma0."""
    ends = [
        [problem.fixed[name]] * 2 if name in problem.fixed else problem.bounds[name]
        for name in ("Gc", "sigma0")
    ]
    shortest, longest = 2.0 * ends[0][0] / ends[1][1], 2.0 * ends[0][1] / ends[1][0]
    if not shortest / LARGEST_RATIO <= length <= LARGEST_RATIO * longest:
        raise ValueError(
            f"column slip: up to {length:g} where s_f = 2 Gc/sigma0 is {shortest:g} to {longest:g}: expected "
            f"the unit of Gc/sigma0 (a ratio from {1.0 / LARGEST_RATIO:g} to {LARGEST_RATIO:g})"
        )


def hypercube(problem: Problem, seed: int) -> list[Floats]:
    """Transformed parameters of SAMPLES points of a Latin hypercube."""
    sizes = _sizes(problem.tests)
    rng = np.random.default_rng(seed)
    strata = rng.permuted(np.tile(np.arange(SAMPLES), (len(problem.free), 1)), axis=1).T
    points = []
    for row in (strata + rng.random(strata.shape)) / SAMPLES:
        values = dict(problem.fixed)
        for name, share in zip(problem.free, row, strict=True):
            unit, _, (a, b) = RANGES["s_f" if name == "Gc" else name]
            values[name] = float(a * sizes[unit] * (b / a) ** share)
        if "Gc" in problem.free:
            values["Gc"] *= 0.5 * values["sigma0"]
        points.append(np.array([SCALES[name].to(values[name]) for name in problem.free]))
    return points
