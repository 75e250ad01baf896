"""Model of shear-box tests: residuals as a function of the constants on their scales."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..contract import Floats
from ..interface import Interface
from ..pattern import Pattern
from ..steps import slip_path, thinned
from .constants import from_scale, material_of
from .shear_test import ShearTest

SIDES = 8
"""Inclined planes of the default pattern: RP-8 is nearly isotropic and cheap."""

INCREMENTS = 200
"""Smallest number of increments along a test, with which a fit begins."""

PRELOAD = 50
"""Increments in which sigma_N is applied before the slip."""

PENALTY = 3.0
"""Residual, in multiples of the range, added to a row that the model does not reach (lost equilibrium)."""

LEAST_SPREAD = 0.05
"""Smallest scale of the dilation of a test, as a fraction of the largest dilation of all tests.

A test with less dilation shows mostly noise.
"""

MOST_SEARCHED = 80
"""Rows of a test, and increments, from which the starts search."""


class SlipPath(NamedTuple):
    """Slips (P,) of the model for a test, from zero on, and which of them are rows of the test."""

    slips: Floats
    rows: np.ndarray


class Part(NamedTuple):
    """Residuals of one column of a test: its number, its name and values, their scale, and the place."""

    number: int
    name: str
    measured: Floats
    scale: float
    place: slice


@dataclass(frozen=True, eq=False)
class Problem:
    """Residuals of measured tests as a function of the constants on their scales.

    tests: the measured tests.  free: names of the constants to identify.  fixed: values of the others.
    bounds: of the free ones.  sides: inclined planes of the pattern.  direction: of the slip, degrees.
    increments: smallest number along a test.  refinement: number of sub-increments of each of these and of
    each preload increment.  weight: of the residuals of the dilation.
    """

    tests: Sequence[ShearTest]
    free: tuple[str, ...]
    fixed: Mapping[str, float]
    bounds: Mapping[str, tuple[float, float]]
    sides: int = SIDES
    direction: float = 0.0
    increments: int = INCREMENTS
    refinement: int = 1
    weight: float = 1.0

    @cached_property
    def paths(self) -> list[SlipPath]:
        """Load paths of the model, in steps of at most the length of the path over `increments`."""
        found = []
        for test in self.tests:
            nodes = np.append(0.0, test.slip)
            lengths = np.abs(np.diff(nodes))
            parts = np.maximum(1, np.ceil(lengths / lengths.sum() * self.increments - 1e-9).astype(int))
            rows = np.cumsum(np.append(0, parts * self.refinement))
            found.append(SlipPath(np.interp(np.arange(rows[-1] + 1), rows, nodes), rows[1:]))
        return found

    @cached_property
    def parts(self) -> list[Part]:
        """Parts of the residuals; their scale is the range, or for an envelope its peak."""
        least = LEAST_SPREAD * max([0.0, *(np.ptp(one.s_N) for one in self.tests if one.s_N is not None)])
        parts: list[Part] = []
        for number, test in enumerate(self.tests):
            columns = [("tau", test.tau, float(np.ptp([0.0, *test.tau] if test.envelope else test.tau)))]
            scale = 0.0 if test.s_N is None else max(float(np.ptp(test.s_N)), least)
            if scale > 0.0:
                columns.append(("dilation", test.s_N, scale))
            for column in columns:
                start = parts[-1].place.stop if parts else 0
                parts.append(Part(number, *column, slice(start, start + test.slip.size)))
        return parts

    @cached_property
    def is_dilation(self) -> np.ndarray:
        """Mask of the residuals of s_N."""
        return np.concatenate([np.full(one.measured.size, one.name == "dilation") for one in self.parts])

    def values(self, x: Floats) -> dict[str, float]:
        """Values of all constants by name, from the free ones on their scales."""
        found = {name: float(from_scale(name, value)) for name, value in zip(self.free, x, strict=True)}
        return dict(self.fixed) | found

    def interface(self, values: Mapping[str, float]) -> Interface:
        """The interface with these constants."""
        return Interface(material_of(values), Pattern.regular(self.sides, values["theta"], values["flat"]))

    def curves(self, values: Mapping[str, float]) -> list[tuple[Floats, Floats, int]]:
        """tau, s_N and the number of converged rows of each test, from `slip_curve`."""
        interface, preload = self.interface(values), self.refinement * PRELOAD
        pairs = zip(self.tests, self.paths, strict=True)
        return [slip_curve(interface, test, path, self.direction, preload) for test, path in pairs]

    def residuals(self, x: Floats) -> Floats:
        """Model less measurement, divided by the range of tau or of s_N of each test, with their weights."""
        found, curves = [], self.curves(self.values(x))
        for number, name, measured, scale, _ in self.parts:
            rows, (tau, s_N, done) = self.paths[number].rows, curves[number]
            model = at_rows(self.tests[number], tau, rows) if name == "tau" else s_N[rows]
            weight = 1.0 if name == "tau" else self.weight
            found.append(weight * ((model - measured) / scale + PENALTY * (rows >= done)))
        return np.concatenate(found)

    def coarse(self) -> Problem:
        """Problem with few rows and increments, on which the starts search."""
        tests = []
        for test in self.tests:
            rows = thinned(test.slip, MOST_SEARCHED) if test.slip.size > MOST_SEARCHED else slice(None)
            columns = {name: getattr(test, name) for name in ("slip", "tau", "s_N", "path_N")}
            some = {name: one if one is None else one[rows] for name, one in columns.items()}
            tests.append(replace(test, **some, lines=()))
        return replace(self, tests=tests, increments=min(self.increments, MOST_SEARCHED))


def at_rows(test: ShearTest, tau: Floats, rows: np.ndarray) -> Floats:
    """Shear traction of the model in the rows of a test; the peak of an envelope is the largest one."""
    return np.array([tau.max(), tau[rows[1]]]) if test.envelope else tau[rows]


def slip_curve(
    interface: Interface, test: ShearTest, path: SlipPath, direction: float, preload: int
) -> tuple[Floats, Floats, int]:
    """tau along the slip and s_N since its start, (T,) each, and the number of converged rows.

    The model of a shear box: `Interface.confined_slip` under sigma_N and k_N of the test, without its
    state and events.  A measured normal traction is prescribed, straight between the rows of the test.  Rows
    without equilibrium repeat the last one.
    """
    n = path.slips.size
    load, slide = slip_path(direction, path.slips, test.sigma_N, preload, test.k_N)
    if test.path_N is not None:
        slide = replace(slide, t_N=np.interp(np.arange(n), [0, *path.rows], [test.sigma_N, *test.path_N]))
    history = interface.rows([load, slide])[0].after_step(1)
    done = len(history)
    if done == 0:
        return np.zeros(n), np.zeros(n), 0
    place = np.minimum(np.arange(n), done - 1)
    return history.tau_along(direction)[place], (history.dilation - history.dilation[0])[place], done
