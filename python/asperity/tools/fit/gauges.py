"""Closed forms with other shapes, and with the starts of slip and dilation that fit best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...contract import Floats
from .model import KS, KT
from .series import Rigid
from .shear_test import ShearTest
from .squares import Solution, refitted, solve
from .thresholds import CANDIDATES, FARTHEST, ROUNDS, SEARCHED


@dataclass(frozen=True, eq=False)
class Started(Rigid):
    """Rigid sides behind a spring, where slip and dilation of each test start at the values that fit best.

    Both are found for each test anew, whatever the constants are, so that they are no further constants.
    """

    def curves(self, values: Mapping[str, float]) -> list[tuple[Floats, Floats, int]]:
        """tau, s_N and the number of rows of each test, from its best starts on."""
        return [self._started(i, values) for i in range(len(self.tests))]

    @cached_property
    def scales(self) -> list[tuple[float, float]]:
        """Range of tau and of s_N of each test, as of the residuals."""
        rows = self.rows.groupby(["test", "name"]).scale.first()
        return [(rows[i, "tau"], rows.get((i, "dilation"), 1.0)) for i in range(len(self.tests))]

    def _started(self, number: int, values: Mapping[str, float]) -> tuple[Floats, Floats, int]:
        """tau, s_N and the number of rows of a test."""
        test = self.tests[number]
        slips, (of_tau, of_s_N) = self.paths[number][0], self.scales[number]
        farthest = FARTHEST * float(np.ptp(slips))
        outside, tau, s_N, _ = self.outside(values, test, slips[-1] + farthest)

        def at(starts: Floats) -> tuple[Floats, Floats, Floats]:
            """Sum of squares, strength and opening, a row for each start of the slip."""
            slips_of_test = slips - starts[:, None]
            strength, opening = np.interp(slips_of_test, outside, tau), np.interp(slips_of_test, outside, s_N)
            squares = np.sum(((strength[:, 1:] - test.tau) / of_tau) ** 2, axis=1)
            if test.s_N is not None:
                opening = opening + np.mean(test.s_N - opening[:, 1:], axis=1)[:, None]
                squares += np.sum(((opening[:, 1:] - test.s_N) * self.weight / of_s_N) ** 2, axis=1)
            return squares, strength, opening

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
        _, strength, opening = at(np.array([middle + part * reach]))
        return strength[0], opening[0], slips.size


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
