"""Model of a shear-box record: residuals by transformed parameters, and their derivatives."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from .. import _core
from ..contract import Floats
from ..interface import Interface
from ..material import Material
from ..pattern import Pattern, direction_vector
from ..slip_curves import ROW
from .records import ShearTest

SIDES = 8
"""Inclined planes: RP-8, nearly the same in every direction and cheap."""

INCREMENTS = 200
"""Least number along a test, where a fit begins."""

PRELOAD = 50
"""Increments of sigma_N before the slip."""

STEP = 1.0e-3
"""Step of central differences in the transformed parameters, which are of the order of one.

Their error is STEP**2 from the third derivative, 1e-6 where the law is smooth; that of the solver, 1e-13 to
1e-12 over STEP, is far below.  A row that a kink passes within the step (a plane begins to slip, breaks or
opens) gets a mean of both slopes: that of the standard errors of a good record, which are as large.
"""

FINER = 0.1
"""Share of STEP by which the derivatives are checked."""

PENALTY = 3.0
"""Residual, in spreads, added to a row that the model does not reach: equilibrium lost."""

LEAST_SPREAD = 0.05
"""Least scale of the dilation of a test, of the largest in the record: the rest would be mostly noise."""

LARGEST_EXPONENT = 700.0
"""Of e in doubles."""


@dataclass(frozen=True)
class Scale:
    """A transform of a parameter to the whole real line: logarithm, or logit of its share of `top`."""

    top: float = np.inf

    def to(self, value: float) -> float:
        """Transformed value."""
        return float(np.log(value) if self.top == np.inf else np.log(value / (self.top - value)))

    def back(self, x: float) -> float:
        """Value of a transformed one; intervals may be wider than doubles are."""
        x = float(np.clip(x, -LARGEST_EXPONENT, LARGEST_EXPONENT))
        return float(np.exp(x) if self.top == np.inf else self.top / (1.0 + np.exp(-x)))


SCALES = {
    "sigma0": Scale(),
    "Gc": Scale(),
    "eta": Scale(1.0),
    "mu": Scale(),
    "theta": Scale(90.0),
    "flat": Scale(1.0),
    "kc": Scale(),
}
"""Parameters that may be identified, and their transforms."""


@dataclass(frozen=True, eq=False)
class _Path:
    """Slips (P,) of the model for a test, from zero on, and which of them are the rows of the record."""

    slips: Floats
    rows: np.ndarray


@dataclass(frozen=True, eq=False)
class Problem:
    """Residuals of a record by transformed parameters.

    tests: the record.  free: names of what is identified, fixed: values of the others.  sides, direction:
    pattern and where the box slips (degrees).  increments: least number along a test; refinement: into how
    many parts each of them and those of the preload are cut.
    """

    tests: Sequence[ShearTest]
    free: tuple[str, ...]
    fixed: Mapping[str, float]
    bounds: Mapping[str, tuple[float, float]]
    sides: int = SIDES
    direction: float = 0.0
    increments: int = INCREMENTS
    refinement: int = 1
    paths: list[_Path] = field(init=False)
    spreads: list[tuple[float, float]] = field(init=False)

    def __post_init__(self) -> None:
        """Paths and scales."""
        paths = [_path(test.slip, self.increments, self.refinement) for test in self.tests]
        object.__setattr__(self, "paths", paths)
        dilations = [0.0 if test.s_N is None else float(np.ptp(test.s_N)) for test in self.tests]
        least = LEAST_SPREAD * max(dilations)
        spreads = [
            (float(np.ptp(test.tau)), max(d, least)) for test, d in zip(self.tests, dilations, strict=True)
        ]
        object.__setattr__(self, "spreads", spreads)

    @property
    def dilation(self) -> bool:
        """Whether any test has dilation that says something."""
        return any(test.s_N is not None and spread[1] > 0.0 for test, spread in self._pairs)

    @property
    def _pairs(self) -> list[tuple[ShearTest, tuple[float, float]]]:
        return list(zip(self.tests, self.spreads, strict=True))

    @cached_property
    def is_dilation(self) -> np.ndarray:
        """Which residuals are those of s_N."""
        parts = []
        for test, spread in self._pairs:
            parts.append(np.zeros(test.slip.size, dtype=bool))
            if test.s_N is not None and spread[1] > 0.0:
                parts.append(np.ones(test.slip.size, dtype=bool))
        return np.concatenate(parts)

    def values(self, x: Floats) -> dict[str, float]:
        """Parameters by name."""
        return dict(self.fixed) | {
            name: SCALES[name].back(value) for name, value in zip(self.free, x, strict=True)
        }

    def interface(self, values: Mapping[str, float]) -> Interface:
        """The interface with these parameters."""
        return Interface(material_of(values), Pattern.regular(self.sides, values["theta"], values["flat"]))

    def curves(self, values: Mapping[str, float]) -> list[tuple[Floats, Floats, int]]:
        """For each test tau and s_N along its path, and how many rows converged: `slip_curve`."""
        interface = self.interface(values)
        pairs = zip(self.tests, self.paths, strict=True)
        preload = self.refinement * PRELOAD
        return [slip_curve(interface, test, path.slips, self.direction, preload) for test, path in pairs]

    def residuals(self, x: Floats) -> Floats:
        """Model less record, of the spread of tau and of s_N of each test."""
        parts = []
        curves = self.curves(self.values(x))
        for (test, spread), path, (tau, s_N, done) in zip(self._pairs, self.paths, curves, strict=True):
            rows = path.rows
            lost = PENALTY * (rows >= done)
            parts.append((tau[rows] - test.tau) / spread[0] + lost)
            if test.s_N is not None and spread[1] > 0.0:
                parts.append((s_N[rows] - test.s_N) / spread[1] + lost)
        return np.concatenate(parts)

    def jacobian(self, x: Floats, step: float = STEP) -> Floats:
        """Central differences of the residuals, the evaluations on all processors."""
        shifts = step * np.eye(x.size)
        points = [x + sign * shift for shift in shifts for sign in (1.0, -1.0)]
        found = each(self.residuals, points)
        return np.column_stack([(a - b) / (2.0 * step) for a, b in zip(found[::2], found[1::2], strict=True)])


def material_of(values: Mapping[str, float]) -> Material:
    """Material of parameters by name."""
    return Material(*(values[name] for name in ("sigma0", "Gc", "eta", "mu")), kc=values["kc"])


def each(function: Callable[[Floats], Floats], points: Sequence[Floats]) -> list[Floats]:
    """Function at several points at once; the library releases the lock of the interpreter."""
    with ThreadPoolExecutor(min(os.cpu_count() or 1, len(points))) as pool:
        return list(pool.map(function, points))


def _path(slip: Floats, increments: int, refinement: int) -> _Path:
    """From zero through the slips of a record, no increment longer than its length over `increments`.

    Each increment is cut into `refinement` parts.
    """
    nodes = np.concatenate([[0.0], slip])
    lengths = np.abs(np.diff(nodes))
    parts = np.maximum(1, np.ceil(lengths / lengths.sum() * increments - 1e-9).astype(int)) * refinement
    pieces = [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(nodes[:-1], nodes[1:], parts, strict=True)]
    return _Path(np.concatenate([[0.0], *pieces]), np.cumsum(parts))


def slip_curve(
    interface: Interface, test: ShearTest, slips: Floats, direction: float, preload: int
) -> tuple[Floats, Floats, int]:
    """tau along the slip and s_N since its start, (T,) each, and how many rows converged.

    The model of a shear box: `Interface.confined_slip` under sigma_N and k_N of the test, without its
    state and events.  Rows without equilibrium repeat the last one.
    """
    n = slips.size
    rows = np.empty((1, n, ROW))
    found, _ = _core.interface_slip_curves(
        interface._props,
        np.array([direction]),
        np.array([test.sigma_N]),
        np.array([test.k_N]),
        slips,
        preload,
        rows.T,
    )
    done = max(int(np.atleast_1d(found)[0]), 0)
    s_N, _, t_x, t_y, _, _ = rows[0].T
    e_x, e_y = direction_vector(direction)
    tau, s_N = t_x * e_x + t_y * e_y, s_N - s_N[0]
    if 0 < done < n:
        tau[done:], s_N[done:] = tau[done - 1], s_N[done - 1]
    return tau, s_N, done
