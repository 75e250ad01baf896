"""Search for the cheapest pattern of a load case: regular patterns against a fine one of the same surface.

A load case (class LoadCase) is a range of normal tractions and a slip path on a surface. The surface is
isotropic (planes of one inclination in every azimuth, slip in any direction) or planar (a ridge with slip
across it).  docs/how-to/select.md describes the command.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ... import contract
from ...contract import Floats
from ...interface import Interface
from ...material import Material
from ...pattern import Pattern
from ..slip_curves import SlipCurves, slip_curves

REFERENCE_SIDES = 64  # sides of the fine pattern, whose mean over directions is the reference
SEARCH_AVERAGE = (1.0 / 12.0, 3.0 / 12.0, 5.0 / 12.0)
CHECK_AVERAGE = (1.0 / 16.0, 3.0 / 16.0, 5.0 / 16.0, 7.0 / 16.0)
"""Directions of the reference as fractions of the angle between two planes, for the search and the check.

By symmetry half of this angle is enough; the mean over all directions is by the midpoint rule.
"""

SEARCH = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Directions of the search as fractions of the angle between neighbouring planes of symmetry."""

CHECK = (0.0, 0.09, 0.19, 0.31, 0.42, 0.58, 0.69, 0.81, 0.91, 1.0)
"""Directions of the check: none of the search's except both ends."""

STEP = 1.0 / 80.0  # increment of the search as a multiple of s_f (that of the paper for Table 2)
FINER = 1.7  # factor from the increments of the search to those of the check
LEAST_ROWS, MOST_ROWS = 60, 4000  # smallest and largest number of increments of a path
PRELOAD = 50  # increments of the preload
FULLY_DAMAGED = 1.0 - 1.0e-9
"""The residual strength counts if the damage of the reference at the end is at least this."""

Tick = Callable[[str], object]
"""Function that is called with the name of a pattern after its run, for a progress bar."""


@dataclass(frozen=True)
class LoadCase:
    """Load case of an interface: material, surface, stress range and slip path.

    theta, flat: inclination (degrees) and flat fraction of the surface; sigma_N: constant normal tractions,
    stress; turns: slips at the reversals and at the end of a path from 0, length (one: monotonic).  planar:
    whether the surface is a ridge with slip along `direction` (degrees) only; otherwise slip has any
    direction, and the selected pattern is turned so that no plane faces across this one.  Raises ValueError
    that names every inadmissible value.
    """

    material: Material
    theta: float
    sigma_N: tuple[float, ...]
    turns: tuple[float, ...]
    flat: float = contract.default("flat")
    planar: bool = False
    direction: float = 0.0

    def __post_init__(self) -> None:
        """Check the values that pattern and material do not check."""
        self.regular(REFERENCE_SIDES)
        for name in ("tau_v", "c"):
            if (value := getattr(self.material, name)) > 0.0:
                raise ValueError(f"{name} = {value:g}: expected 0, because a load case has no rate")
        if self.material.W0 > 0.0 and not (self.planar or self.smooth):
            raise ValueError(
                f"W0 = {self.material.W0:g}: expected 0, or a planar load case: a facet wears by the work "
                "per area of its own, so that W0 belongs to one pattern"
            )
        if not np.isfinite(self.direction):
            raise ValueError(f"direction = {self.direction!r}: expected a finite angle")
        for name, values in (("sigma_N", self.sigma_N), ("turns", self.turns)):
            if len(values) == 0 or not np.all(np.isfinite(values)):
                raise ValueError(f"{name} = {values}: expected one or more finite numbers")
        if not np.any(np.diff([0.0, *self.turns])):
            raise ValueError(f"turns = {self.turns}: expected a path of some length")

    @property
    def smooth(self) -> bool:
        """Whether the surface is flat."""
        return self.theta == 0.0 or self.flat == 1.0

    def regular(self, sides: int, turn: float = 0.0) -> Pattern:
        """Regular pattern of the surface; 0 sides give the flat plane."""
        return Pattern.regular(sides, self.theta if sides else 0.0, self.flat, turn)

    def slips(self, finer: float = 1.0) -> Floats:
        """Path in equal increments of at most STEP s_f, with LEAST_ROWS to MOST_ROWS rows."""
        lengths = np.abs(np.diff([0.0, *self.turns]))
        rows = finer * np.clip(lengths.sum() / (STEP * self.material.s_f), LEAST_ROWS, MOST_ROWS)
        parts = np.maximum(1, np.ceil(rows * lengths / lengths.sum())).astype(int)
        ends = np.cumsum([0, *parts])
        return np.interp(np.arange(1, ends[-1] + 1), ends, [0.0, *self.turns])

    def directions(self, sides: int, shares: Sequence[float]) -> Floats:
        """Directions in which a pattern is run, degrees: from a plane of symmetry to the next."""
        if self.planar:
            return np.array([self.direction])
        return np.array([0.0]) if sides == 0 else 180.0 / sides * np.array(shares)

    def residual_error(self, sides: int) -> float:
        """Relative difference of the residual strengths between two planes and up a plane.

        Asperities that end or wear end at the strength mu in every direction; before, the curves differ.
        Those that are crushed have no closed form: the ends of the curves are compared.
        """
        material, ends = self.material, contract.of_asperities()
        if self.smooth or any(getattr(material, name) for name in ends) or (self.planar and sides == 2):
            return 0.0
        dense = float(material.residual_strength(self.theta))
        weakest = float(material.residual_strength(self.theta, 180.0 / sides)) if sides else material.mu
        if dense == np.inf:
            return 0.0 if weakest == np.inf else 1.0
        return abs(1.0 - weakest / dense) if dense > 0.0 else 0.0


class Errors(NamedTuple):
    """Largest errors over directions and normal tractions, relative to the reference.

    tau_L, transverse: L2 norms over the path of the error of the traction along the slip and across it, over
    the L2 norm of the reference traction along the slip.  s_N: L2 norm of the error of the dilation over the
    larger of that of the reference and s0.  residual: error of the residual strength (closed form, or the
    traction at the end where asperities are crushed), 0 where the load case does not reach this strength.
    NaN: not computed, because another error was too large.
    """

    tau_L: float = 0.0
    transverse: float = 0.0
    s_N: float = 0.0
    residual: float = 0.0

    @property
    def worst(self) -> float:
        """Largest of the errors."""
        return float(np.nanmax(self))

    @classmethod
    def largest(cls, *several: Errors) -> Errors:
        """Largest of several values of each error."""
        return cls(*np.max(several, axis=0).tolist())


@dataclass(frozen=True)
class Candidate:
    """Pattern and its errors in the search."""

    name: str
    pattern: Pattern
    errors: Errors

    @property
    def planes(self) -> int:
        """Number of planes."""
        return len(self.pattern.weights)


@dataclass(frozen=True)
class Selection(Candidate):
    """The cheapest pattern that meets a tolerance.

    errors: the larger ones of the search and of the independent check.  uncertainty: difference between the
    reference and its mean over other directions, which is added to the errors; 0 for a planar surface, whose
    reference has the planes of the surface.  tried: the candidates in the order in which they were run.
    """

    case: LoadCase
    tolerance: float
    uncertainty: float
    tried: tuple[Candidate, ...]
    lost: tuple[tuple[float, float], ...] = ()
    """sigma_N and length of path at which the reference loses equilibrium; nothing beyond is compared."""

    @property
    def reference(self) -> str:
        """Name of the reference."""
        return "RT" if self.case.planar else f"RP-{REFERENCE_SIDES}"

    @property
    def interface(self) -> Interface:
        """Interface with the selected pattern."""
        return Interface(self.case.material, self.pattern)


class NoPatternError(ValueError):
    """No candidate meets the tolerance; `best` has the smallest error."""

    def __init__(self, message: str, best: Candidate) -> None:
        """Message and the best candidate."""
        super().__init__(message)
        self.best = best


class Reference:
    """Mean curves of the fine pattern over directions along a path; planar: those of the three planes.

    means: traction along the slip and dilation (2, n) for each normal traction, up to a loss of equilibrium.
    damaged: whether the path reaches the residual strength, for each.
    """

    def __init__(
        self, case: LoadCase, finer: float, average: Sequence[float], executor: Executor | None = None
    ) -> None:
        """Run refined increments in directions that are fractions of the angle between planes."""
        self.case, self.executor, self.slips = case, executor, case.slips(finer)
        if case.planar:
            runs = self._runs(case.regular(2, case.direction), np.array([case.direction]))
        else:
            runs = self._runs(case.regular(REFERENCE_SIDES), 360.0 / REFERENCE_SIDES * np.array(average))
        self.means: list[Floats] = []
        self.damaged: list[bool] = []
        for sigma_N, run in zip(case.sigma_N, runs, strict=True):
            rows = int(run.rows.min())
            if rows < 1:
                raise ValueError(
                    f"sigma_N = {sigma_N:g}: expected a normal traction under which the surface can slip, "
                    "the reference has no equilibrium"
                )
            self.means.append(np.stack([curve[:, :rows].mean(axis=0) for curve in (run.tau_L, run.s_N)]))
            self.damaged.append(bool(sigma_N < 0.0 and run.damage[:, -1].min() >= FULLY_DAMAGED))

    @property
    def lost(self) -> tuple[tuple[float, float], ...]:
        """sigma_N and length of path at which equilibrium is lost before the end of the path."""
        length = np.cumsum(np.abs(np.diff(self.slips, prepend=0.0)))
        ends = zip(self.case.sigma_N, (mean.shape[1] for mean in self.means), strict=True)
        return tuple((sigma_N, float(length[n - 1])) for sigma_N, n in ends if n < self.slips.size)

    def mean_error(self, reference: Reference) -> float:
        """Difference from the mean curves of another reference with the same increments."""
        pairs = zip(self.means, reference.means, strict=True)
        return max(
            self._error(curves, mean.shape[1], mean[:1], 0.0, mean[1:]).worst for curves, mean in pairs
        )

    def errors(self, pattern: Pattern, angles: Floats) -> Errors:
        """Errors of a pattern in directions (degrees), without the closed form of the residual strength."""
        several = []
        for mean, damaged, run in zip(self.means, self.damaged, self._runs(pattern, angles), strict=True):
            several.append(self._error(mean, run.rows, run.tau_L, run.tau_across, run.s_N))
            crushed = any(getattr(self.case.material, name) for name in contract.of_asperities("stress"))
            if damaged and crushed and run.rows.min() == mean.shape[1]:
                end = float(np.abs(run.tau_L[:, -1] / mean[0, -1] - 1.0).max())
                several.append(Errors(residual=end))
        return Errors.largest(*several)

    def _runs(self, pattern: Pattern, angles: Floats) -> list[SlipCurves]:
        """Curves of a pattern in directions, for each normal traction."""
        interface = Interface(self.case.material, pattern)
        arguments = self.slips, self.case.sigma_N, PRELOAD, self.executor
        return [
            slip_curves(interface, angles, arguments[0], sigma_N, *arguments[2:]) for sigma_N in arguments[1]
        ]

    def _error(
        self, mean: Floats, rows: NDArray[np.int_] | int, tau_L: Floats, across: Floats | float, s_N: Floats
    ) -> Errors:
        """Errors of curves (C, T) under one normal traction, as far as the reference and all of them go."""
        n = min(mean.shape[1], np.min(rows))
        # a pattern that loses equilibrium elsewhere has no small error
        if n < 1 or np.any(np.abs(rows - mean.shape[1]) > max(1, 0.01 * self.slips.size)):
            return Errors(1.0, 1.0, 1.0)
        tau, dilation = mean[:, :n]
        along = float(np.linalg.norm(tau)) or 1.0
        size = max(float(np.linalg.norm(dilation)), np.sqrt(n) * self.case.material.s_0)
        across = np.broadcast_to(across, tau_L.shape)[:, :n]
        differences = (tau_L[:, :n] - tau, along), (across, along), (s_N[:, :n] - dilation, size)
        return Errors(*(float(np.linalg.norm(away, axis=1).max() / scale) for away, scale in differences))


def select(
    case: LoadCase,
    tolerance: float,
    tick: Tick = lambda name: None,
    executor: Executor | None = None,
) -> Selection:
    """Pattern with the fewest planes whose errors plus the uncertainty of the reference meet the tolerance.

    A second run in other directions with finer increments confirms every result.  tolerance: relative,
    0 < tolerance < 1.  executor: as in `parallel.map_in_order`.  Raises ValueError for another tolerance,
    NoPatternError if no candidate meets it.
    """
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"tolerance = {tolerance!r}: expected 0 < tolerance < 1")
    dense = Reference(case, 1.0, SEARCH_AVERAGE, executor)
    check = Reference(case, FINER, CHECK_AVERAGE, executor)
    turned = dense if case.planar else Reference(case, 1.0, CHECK_AVERAGE, executor)
    uncertainty = dense.mean_error(turned)

    def candidate(sides: int, most: float = np.inf) -> Candidate:
        """Errors of a pattern; where that of the residual strength exceeds `most`, the others are NaN."""
        pattern = case.regular(sides, case.direction if case.planar else 0.0)
        residual = case.residual_error(sides) if any(dense.damaged) else 0.0
        errors = Errors(np.nan, np.nan, np.nan, residual)
        if residual <= most:
            errors = Errors.largest(
                Errors(residual=residual), dense.errors(pattern, case.directions(sides, SEARCH))
            )
            if errors.worst <= most:
                errors = Errors.largest(errors, check.errors(pattern, case.directions(sides, CHECK)))
        return Candidate({0: "flat", 2: "RT"}.get(sides, f"RP-{sides}"), pattern, errors)

    tried: list[Candidate] = []
    inclined = () if case.smooth else (2,) if case.planar else range(2, REFERENCE_SIDES)
    for sides in (0, *inclined):
        trial = candidate(sides, tolerance)
        tick(trial.name)
        tried.append(trial)
        if trial.errors.worst + uncertainty <= tolerance:
            pattern = trial.pattern
            if not case.planar and pattern.across(case.direction):
                pattern = pattern.turned_from(case.direction)
            rest = case, tolerance, uncertainty, tuple(tried), dense.lost
            return Selection(trial.name, pattern, trial.errors, *rest)
    # patterns that the residual strength excludes have no curves
    run = [candidate(sides), *(trial for trial in tried if not np.isnan(trial.errors.tau_L))]
    best = min(reversed(run), key=lambda trial: trial.errors.worst)
    raise NoPatternError(
        f"no pattern up to {best.name} meets the tolerance {tolerance:g}: {best.name} has an error of "
        f"{best.errors.worst:.2g}, the reference one of {uncertainty:.2g}",
        best,
    )
