"""A joint with a spring in series along the slip, whose slip is the measured one less that of the spring."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np

from ...contract import Floats
from .model import KS, KT, PRELOAD, Problem, slip_curve
from .rigid import LAW, SHAPES, rigid_curve
from .shear_test import ShearTest
from .thresholds import CANDIDATES, FARTHEST, ROUNDS


class Series(Problem):
    """First strokes of a joint with a spring of the stiffness kT in series: measured slip u + tau(u)/kT.

    The law runs along the slip u of the joint itself; tau and s_N are interpolated at the measured slips.
    Specimen, box and matedness are such a spring; the shear stiffness of a joint lies in its inclined planes,
    so that it dilates before it slides.
    """

    @cached_property
    def paths(self) -> list[tuple[Floats, np.ndarray]]:
        """Measured slips (P,) of each test, from zero on, and which of them are rows of the test."""
        paths = []
        for test in self.tests:
            slips = np.append(0.0, np.maximum.accumulate(sign_of(test) * test.slip))
            paths.append((slips, np.arange(1, slips.size)))
        return paths

    def curves(self, values: Mapping[str, float]) -> list[tuple[Floats, Floats, int]]:
        """tau, s_N and the number of rows with equilibrium of each test."""
        curves = []
        for test, (slips, _) in zip(self.tests, self.paths, strict=True):
            outside, tau, s_N, done = self.outside(values, test, slips[-1])
            lost = slips.size
            if done < outside.size:
                lost = int(np.searchsorted(slips, outside[max(done - 1, 0)]))
            curves.append((np.interp(slips, outside, tau), np.interp(slips, outside, s_N), lost))
        return curves

    def outside(
        self, values: Mapping[str, float], test: ShearTest, top: float
    ) -> tuple[Floats, Floats, Floats, int]:
        """Measured slips, tau and s_N of a test, (P,) each, up to slips of the joint of the size top.

        And the number of rows with equilibrium.
        """
        stiffness, sign = 1.0 / self.compliance(values), sign_of(test)
        slips = top * places(self.increments)
        alone = test
        if test.path_N is not None:
            at = np.maximum.accumulate(np.maximum(0.0, sign * (test.slip - test.tau / stiffness)))
            path = np.interp(slips[1:], at, test.path_N)
            alone = replace(test, slip=slips[1:], tau=slips[1:], s_N=None, lines=(), path_N=path)
        tau, s_N, done = self.slid(values, alone, sign * slips)
        # softening steeper than the spring is passed at one measured slip
        outside = np.maximum.accumulate(slips + sign * tau / stiffness) + 1e-12 * top * np.arange(slips.size)
        return outside, tau, s_N, done

    def compliance(self, values: Mapping[str, float]) -> float:
        """Slip over traction of what lies in series with `slid`, length/stress."""
        return 1.0 / values[KT]

    def slid(self, values: Mapping[str, float], test: ShearTest, slips: Floats) -> tuple[Floats, Floats, int]:
        """tau, s_N and the number of rows with equilibrium of the joint alone, as `slip_curve`."""
        rows = np.arange(1, slips.size)
        return slip_curve(self.props(values), test, slips, rows, self.direction, PRELOAD)


class CyclicSeries(Problem):
    """The same with reversals of the slip, where the driver has the spring: x is the way of its far end."""

    def curves(self, values: Mapping[str, float]) -> list[tuple[Floats, Floats, int]]:
        """tau, s_N and the number of rows with equilibrium of each test."""
        props, pairs = self.props(values), zip(self.tests, self.paths, strict=True)
        return [slip_curve(props, test, *path, self.direction, PRELOAD, values[KT]) for test, path in pairs]


@dataclass(frozen=True, eq=False)
class Rigid(Series):
    """The same in the closed form of two rigid sides, from which a search begins.

    shape: name of that of slope and softening, which the law has or has not.
    """

    shape: str = LAW
    is_closed_form = True

    def compliance(self, values: Mapping[str, float]) -> float:
        """Slip over traction of the spring and of the joint before it slides, length/stress."""
        if SHAPES[self.shape].rises:
            return 1e-9 / values[KT]
        if KS in values:
            return 1.0 / values[KT] + 1.0 / values[KS]
        return 1.0 / values[KT] + 2.0 * (1.0 - values["eta"]) * values["Gc"] / values["sigma0"] ** 2

    def slid(self, values: Mapping[str, float], test: ShearTest, slips: Floats) -> tuple[Floats, Floats, int]:
        """tau and s_N of the closed form."""
        tau, s_N = rigid_curve(test, np.abs(slips), values, SHAPES[self.shape])
        return sign_of(test) * tau, s_N, slips.size


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


@cache
def places(increments: int) -> Floats:
    """Slips over the largest one at which a joint is followed, closer to each other at the start."""
    early = np.geomspace(1e-4, 0.1, 25)
    return np.unique(np.concatenate([[0.0], early, np.linspace(0.0, 1.0, increments + 1)]))


def sign_of(test: ShearTest) -> float:
    """Sign of the slip of a test."""
    return float(np.sign(test.slip[np.argmax(np.abs(test.slip))]))
