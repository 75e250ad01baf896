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


@cache
def places(increments: int) -> Floats:
    """Slips over the largest one at which a joint is followed, closer to each other at the start."""
    early = np.geomspace(1e-4, 0.1, 25)
    return np.unique(np.concatenate([[0.0], early, np.linspace(0.0, 1.0, increments + 1)]))


def sign_of(test: ShearTest) -> float:
    """Sign of the slip of a test."""
    return float(np.sign(test.slip[np.argmax(np.abs(test.slip))]))
