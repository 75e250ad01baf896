"""A joint with a spring in series along the slip, whose slip is the measured one less that of the spring."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property

import numpy as np

from ...contract import Floats
from .model import KT, PRELOAD, Problem, slip_curve
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
        found = []
        for test in self.tests:
            slips = np.append(0.0, np.maximum.accumulate(_sign(test) * test.slip))
            found.append((slips, np.arange(1, slips.size)))
        return found

    def curves(self, values: Mapping[str, float]) -> list[tuple[Floats, Floats, int]]:
        """tau, s_N and the number of rows with equilibrium of each test."""
        joint, found, stiffness = self.interface(values), [], values[KT]
        for test, (slips, _) in zip(self.tests, self.paths, strict=True):
            top, sign = slips[-1], _sign(test)
            early = np.geomspace(1e-4, 0.1, 25) * top
            own = np.unique(np.concatenate([[0.0], early, np.linspace(0.0, top, self.increments + 1)]))
            rows, alone = np.arange(1, own.size), test
            if test.path_N is not None:
                at = np.maximum.accumulate(np.maximum(0.0, sign * (test.slip - test.tau / stiffness)))
                path = np.interp(own[1:], at, test.path_N)
                alone = replace(test, slip=own[1:], tau=own[1:], s_N=None, lines=(), path_N=path)
            tau, s_N, done = slip_curve(joint, alone, sign * own, rows, self.direction, PRELOAD)
            # softening steeper than the spring is passed at one measured slip
            outside = np.maximum.accumulate(own + sign * tau / stiffness) + 1e-12 * top * np.arange(own.size)
            lost = slips.size
            if done < own.size:
                lost = int(np.searchsorted(slips, outside[max(done - 1, 0)]))
            found.append((np.interp(slips, outside, tau), np.interp(slips, outside, s_N), lost))
        return found


def _sign(test: ShearTest) -> float:
    """Sign of the slip of a test."""
    return float(np.sign(test.slip[np.argmax(np.abs(test.slip))]))
