"""Gauges that were not set to zero: the start of slip and dilation of each test, which the rows may show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...contract import Floats
from .assumptions import PATTERNS
from .evidence import cycles, noise
from .ladder import GAIN, criteria, independent
from .model import KS, KT
from .rigid import LAW, SLOPES, has_closed_form
from .series import Rigid, sign_of
from .shear_test import ShearTest
from .squares import SEARCHED, Solution, refitted, solve

FARTHEST, CANDIDATES, ROUNDS = 0.12, 13, 3
"""Largest start of a slip over its range; number of those that are tried, and how often, closer each time."""

RESTS, STRONG, NEAR, STEPS, FIRST_ROWS, DEVIATIONS = 0.1, 0.5, 0.25, 1.5, 8, 3.0
"""Traction over the largest one of a row at rest, and of one that shows the elastic slip; distance of two
starts over this slip, and over the step of the rows, in which they are the same; rows that lead to the
dilation at the start; and standard deviations of noise that a start of the dilation exceeds.
"""


@dataclass(frozen=True, eq=False)
class Started(Rigid):
    """Rigid sides behind a spring, where slip and dilation of each test start at the values that fit best.

    Both are found for each test anew, whatever the constants are, so that they are no further constants.
    """

    def curves(self, values: Mapping[str, float]) -> list[tuple[Floats, Floats, int]]:
        """tau, s_N and the number of rows of each test, from its best starts on."""
        return [self._started(i, values)[0] for i in range(len(self.tests))]

    def starts(self, values: Mapping[str, float]) -> list[tuple[float, float]]:
        """Slip and dilation of each test at its start."""
        return [self._started(i, values)[1] for i in range(len(self.tests))]

    @cached_property
    def scales(self) -> list[tuple[float, float]]:
        """Range of tau and of s_N of each test, as of the residuals."""
        rows = self.rows.groupby(["test", "name"]).scale.first()
        return [(rows[i, "tau"], rows.get((i, "dilation"), 1.0)) for i in range(len(self.tests))]

    def _started(
        self, number: int, values: Mapping[str, float]
    ) -> tuple[tuple[Floats, Floats, int], tuple[float, float]]:
        """Curves of a test, and slip and dilation at its start."""
        test, sign = self.tests[number], sign_of(self.tests[number])
        slips, (of_tau, of_s_N) = self.paths[number][0], self.scales[number]
        farthest = FARTHEST * float(np.ptp(slips))
        outside, tau, s_N, _ = self.outside(values, test, slips[-1] + farthest)

        def at(starts: Floats) -> tuple[Floats, Floats, Floats, Floats]:
            """Sum of squares, strength, opening and its start, a row for each start of the slip."""
            own = slips - starts[:, None]
            strength, opening = np.interp(own, outside, tau), np.interp(own, outside, s_N)
            squares, offset = np.sum(((strength[:, 1:] - test.tau) / of_tau) ** 2, axis=1), 0.0 * starts
            if test.s_N is not None:
                offset = np.mean(test.s_N - opening[:, 1:], axis=1)
                opening = opening + offset[:, None]
                squares += np.sum(((opening[:, 1:] - test.s_N) * self.weight / of_s_N) ** 2, axis=1)
            return squares, strength, opening, offset

        middle, reach = 0.0, farthest
        for _ in range(ROUNDS):
            starts = np.clip(middle + reach * np.linspace(-1.0, 1.0, CANDIDATES), -farthest, farthest)
            squares = at(starts)[0]
            best = int(np.clip(np.argmin(squares), 1, CANDIDATES - 2))
            middle, reach = float(starts[best]), float(starts[best + 1] - starts[best])
        # the least value of the parabola through the last three
        below, here, above = squares[best - 1 : best + 2]
        bend = below - 2.0 * here + above
        part = float(np.clip(0.5 * (below - above) / bend, -1.0, 1.0)) if bend > 0.0 else 0.0
        _, strength, opening, offset = at(np.array([middle + part * reach]))
        return (strength[0], opening[0], slips.size), (sign * (middle + part * reach), float(offset[0]))


def rigid_form(chosen: Solution, tests: Sequence[ShearTest], left_out: Sequence[str] = ()) -> Solution | None:
    """Fit of the same model with rigid sides behind a spring, which has a closed form; None without one.

    left_out: constants that the tests do not need, as wear in a first stroke.
    """
    model = replace(chosen.model, free=tuple(name for name in chosen.model.free if name not in left_out))
    if KS in model.free:
        model = model.instead(KS, KT)
    elif KS in model.fixed and not model.series:
        fixed = {name: value for name, value in model.fixed.items() if name not in (KS, "kc")}
        model = replace(model, fixed=fixed | {KT: 0.5 * chosen.values[KS]})
    if model.name in PATTERNS:
        model = replace(model, sides=2, fixed={**model.fixed, "flat": 0.0})
    problem = model.problem(tests, chosen.problem.weight, chosen.problem.direction)
    if not has_closed_form(problem.free, problem.fixed, problem.sides, problem.direction):
        return None
    return refitted(chosen, tests, model, tolerance=SEARCHED)


def with_shape(form: Solution, shape: str) -> Solution:
    """Fit of a closed form with another shape."""
    model = replace(form.model, shape=shape)
    return refitted(form, form.problem.tests, model, tolerance=SEARCHED) if shape else form


def with_starts(form: Solution) -> Solution:
    """Fit of a closed form from the starts of the gauges that fit best."""
    own, shape = form.problem, form.model.shape
    rest = (own.free, own.fixed, own.sides, own.direction, own.increments)
    other = Started(own.tests, *rest, own.weight, shape)
    return Solution(form.model, other, *solve(other, form.x, SEARCHED))


def from_starts(chosen: Solution, tests: Sequence[ShearTest]) -> tuple[list[ShearTest], list[str]]:
    """Tests from the starts of their gauges on, where the rows show that these lie apart from 0; and notes.

    The tests must be explained much better with them than by any shape of the asperities without; and the
    rows about the start must say the same without any law.  Not in cycles.
    """
    form = None if cycles(tests) else rigid_form(chosen, chosen.model.problem(tests).coarse().tests)
    if form is None:
        return list(tests), []
    sloped = {"theta", "height"} <= {*form.model.free} and not form.model.bond
    held = [with_shape(form, shape) for shape in ((LAW, *SLOPES) if sloped else (LAW,))]
    free = [with_starts(own) for own in held]
    best = int(np.argmin(criteria(free)))
    *without, after = criteria([*held, free[best]])
    before = min(without)
    further = sum(1 + (test.s_N is not None) for test in tests)
    after += further * float(np.log(max(2.0, sum(independent(free[best]).values()))))
    if before - after < GAIN:
        return list(tests), []
    moved, notes = [], []
    problem = free[best].problem
    assert isinstance(problem, Started)
    for test, (slip, s_N) in zip(tests, problem.starts(free[best].values), strict=True):
        apart, same = _compared(test, slip)
        opens = same and _shows_dilation(test, slip, s_N)
        slips = apart and same
        moved.append(_moved(test, slip if slips else 0.0, s_N if opens else 0.0))
        parts = [f"slip {slip:.3g}"] * slips + [f"dilation {s_N:.3g}"] * opens
        if parts:
            name = test.name.replace("\\", "/").rsplit("/", 1)[-1]
            text = f"{name} begins at {' and '.join(parts)}, which was taken off"
            notes.append(f"{text}: a gauge was not set to zero, or the specimen settled")
    return moved, notes


def _moved(test: ShearTest, slip: float, s_N: float) -> ShearTest:
    """Test whose slip and dilation count from other starts; before that of the slip it rests."""
    sign, opening = sign_of(test), None if test.s_N is None else test.s_N - s_N
    own = test.slip - slip
    rests = np.maximum.accumulate(sign * own) <= 0.0
    sigma_N = test.sigma_N - test.k_N * s_N * test.extrapolated
    return replace(test, slip=np.where(rests, 0.0, own), s_N=opening, sigma_N=sigma_N)


def _crossing(test: ShearTest) -> tuple[float, float]:
    """Slip where the line of the first rows leads to tau = 0, and from there to half of the strength."""
    sign = sign_of(test)
    slip, tau = sign * test.slip, sign * test.tau
    strong = int(np.argmax(tau >= STRONG * tau.max()))
    resting = np.flatnonzero(tau[:strong] < RESTS * tau.max())
    rows = slice(int(resting[-1]) if resting.size else 0, strong + 1)
    if strong == rows.start or not np.ptp(slip[rows]) > 0.0:
        return float(slip[0]), 0.0
    line = np.polyfit(slip[rows], tau[rows], 1)
    start = -line[1] / line[0] if line[0] > 0.0 else slip[0]
    return float(start), float(slip[strong] - start)


def _compared(test: ShearTest, start: float) -> tuple[bool, bool]:
    """Whether a start lies a step from 0 at least; and whether the elastic line of the rows begins there."""
    seen, elastic = _crossing(test)
    step, own = float(np.median(np.abs(np.diff(test.slip)))), sign_of(test) * start
    same = abs(seen - own) <= max(STEPS * step, NEAR * elastic)
    apart = abs(own) >= step
    return apart, bool(same and (not apart or (seen * own > 0.0 and abs(seen) >= 0.5 * abs(own))))


def _shows_dilation(test: ShearTest, slip: float, start: float) -> bool:
    """Whether the dilation of the first rows leads to this one at the start of the slip, too."""
    if test.s_N is None or test.s_N.size <= FIRST_ROWS:
        return False
    if abs(test.tau[0]) >= STRONG * np.abs(test.tau).max():  # the joint may slide in the first row
        return False
    own = sign_of(test) * (test.slip - slip)
    first = slice(0, max(FIRST_ROWS, int(np.sum(own < 0.0))))
    rests = own[first] <= max(0.0, float(own[0]))
    seen = float(np.mean(test.s_N[first][rests]))
    if own[0] > 0.0:
        seen = float(np.polynomial.Polynomial.fit(own[first], test.s_N[first], 2)(0.0))
    least = DEVIATIONS * noise(test.s_N) / np.sqrt(max(1, int(np.sum(rests))))
    return bool(min(abs(start), abs(seen)) > least and abs(seen - start) <= 0.5 * abs(start))
