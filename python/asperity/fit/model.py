"""Model of shear-box tests: residuals as a function of the constants on their scales."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..contract import Floats
from ..interface import Interface, slip_path
from ..pattern import Pattern
from ..steps import thinned
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


@dataclass(frozen=True, eq=False)
class SlipPath:
    """Slips (P,) of the model for a test, from zero on, and which of them are rows of the test."""

    slips: Floats
    rows: np.ndarray


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
    paths: list[SlipPath] = field(init=False)
    spreads: list[tuple[float, float]] = field(init=False)

    def __post_init__(self) -> None:
        """Load paths of the model and scales of the residuals."""
        paths = [_path(test.slip, self.increments, self.refinement) for test in self.tests]
        object.__setattr__(self, "paths", paths)
        dilations = [0.0 if test.s_N is None else float(np.ptp(test.s_N)) for test in self.tests]
        least = LEAST_SPREAD * max(dilations)
        # the scale of an envelope is its peak
        ranges = [float(np.ptp([0.0, *test.tau] if test.envelope else test.tau)) for test in self.tests]
        spreads = [(one, max(d, least)) for one, d in zip(ranges, dilations, strict=True)]
        object.__setattr__(self, "spreads", spreads)

    @property
    def dilation(self) -> bool:
        """Whether any test has a dilation that is not zero."""
        return bool(self.is_dilation.any())

    @cached_property
    def parts(self) -> list[tuple[ShearTest, str, slice]]:
        """Parts of the residuals: test, column (tau or dilation) and place."""
        parts, at = [], 0
        for test, (_, spread) in zip(self.tests, self.spreads, strict=True):
            for column in ("tau", "dilation")[: 1 + (test.s_N is not None and spread > 0.0)]:
                parts.append((test, column, slice(at, at + test.slip.size)))
                at += test.slip.size
        return parts

    @cached_property
    def is_dilation(self) -> np.ndarray:
        """Mask of the residuals of s_N."""
        return np.concatenate([np.full(test.slip.size, name == "dilation") for test, name, _ in self.parts])

    def values(self, x: Floats) -> dict[str, float]:
        """Values of all constants by name, from the free ones on their scales."""
        return dict(self.fixed) | {
            name: float(from_scale(name, value)) for name, value in zip(self.free, x, strict=True)
        }

    def interface(self, values: Mapping[str, float]) -> Interface:
        """The interface with these constants."""
        return Interface(material_of(values), Pattern.regular(self.sides, values["theta"], values["flat"]))

    def curves(self, values: Mapping[str, float]) -> list[tuple[Floats, Floats, int]]:
        """tau, s_N and the number of converged rows of each test, from `slip_curve`."""
        interface = self.interface(values)
        pairs = zip(self.tests, self.paths, strict=True)
        preload = self.refinement * PRELOAD
        return [slip_curve(interface, test, path, self.direction, preload) for test, path in pairs]

    def residuals(self, x: Floats) -> Floats:
        """Model less measurement, divided by the range of tau or of s_N of each test, with their weights."""
        parts = []
        curves = self.curves(self.values(x))
        for test, spread, path, (tau, s_N, done) in zip(
            self.tests, self.spreads, self.paths, curves, strict=True
        ):
            rows = path.rows
            lost = PENALTY * (rows >= done)
            parts.append((at_rows(test, tau, rows) - test.tau) / spread[0] + lost)
            if test.s_N is not None and spread[1] > 0.0:
                parts.append(self.weight * ((s_N[rows] - test.s_N) / spread[1] + lost))
        return np.concatenate(parts)

    def coarse(self) -> Problem:
        """Problem with few rows and increments, on which the starts search."""
        tests = []
        for test in self.tests:
            rows = thinned(test.slip, MOST_SEARCHED) if test.slip.size > MOST_SEARCHED else slice(None)
            columns = {name: getattr(test, name) for name in ("slip", "tau", "s_N", "path_N")}
            some = {name: one if one is None else one[rows] for name, one in columns.items()}
            tests.append(replace(test, **some, lines=()))
        return replace(self, tests=tests, increments=min(self.increments, MOST_SEARCHED))


def _path(slip: Floats, increments: int, refinement: int) -> SlipPath:
    """Slips from zero through those of a test, in steps of at most the length of the path over `increments`.

    Each increment is divided into `refinement` sub-increments.
    """
    nodes = np.concatenate([[0.0], slip])
    lengths = np.abs(np.diff(nodes))
    parts = np.maximum(1, np.ceil(lengths / lengths.sum() * increments - 1e-9).astype(int)) * refinement
    pieces = [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(nodes[:-1], nodes[1:], parts, strict=True)]
    return SlipPath(np.concatenate([[0.0], *pieces]), np.cumsum(parts))


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
        normal = np.interp(np.arange(n), [0, *path.rows], [test.sigma_N, *test.path_N])
        slide = replace(slide, t_N=normal)
    history, _ = interface.rows([load, slide])
    history = history.after_step(1)
    done = len(history)
    if done == 0:
        return np.zeros(n), np.zeros(n), 0
    # rows without equilibrium repeat the last one
    place = np.minimum(np.arange(n), done - 1)
    tau = history.tau_along(direction)
    return tau[place], (history.dilation - history.dilation[0])[place], done
