"""What a figure of the paper gives: its curves, picture, findings and numbers, and their texts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import trapezoid

from ..case_files import SlipTest, drive, read_case, slip_tests
from ..contract import Floats
from ..history import History
from ..installed import named_case
from ..pattern import Pattern
from ..steps import turns_of
from .fracture_energy import Energies

FIVE = Pattern.regular(4, 30.0, flat=0.2)
"""The five planes of Table 3."""

MOST_ROWS = 101
"""Approximate number of rows of a curve in a CSV."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Rows of a slip test, mm and MPa; the curve begins at s_L = 0, with the preload if there is one."""

    test: SlipTest
    history: History

    @property
    def lost(self) -> bool:
        """Whether it ends because no equilibrium is left."""
        return self.history.lost

    def of(self, column: Floats) -> Floats:
        """Rows of the curve of a column of the history."""
        return column[self.test.preload - 1 :] if self.test.preload else np.append(0.0, column)

    @cached_property
    def s_L(self) -> Floats:
        """Slip along the direction."""
        return self.of(self.history.slip_along(self.test.direction))

    @cached_property
    def s_N(self) -> Floats:
        """Opening."""
        return self.of(self.history.dilation)

    @cached_property
    def tau_L(self) -> Floats:
        """Traction along the direction."""
        return self.of(self.history.tau_along(self.test.direction))

    @property
    def energy(self) -> float:
        """Area under the curve (40) by the trapezoid rule over its rows, N/mm."""
        return float(trapezoid(self.tau_L, self.s_L))


@dataclass(frozen=True)
class Case:
    """Results of a case file; name: name of the swept value."""

    title: str
    name: str
    curves: tuple[Curve, ...]

    def at(self, value: float) -> Curve:
        """Curve for a value of the sweep."""
        return next(curve for curve in self.curves if curve.test.value == value)


@dataclass(frozen=True, eq=False)
class Outcome:
    """Result of a figure or table: picture (None: a table), findings, header and lines of its CSV."""

    figure: Figure | None
    came_out: tuple[str, ...]
    header: str
    lines: tuple[str, ...]


@dataclass(frozen=True)
class Entry:
    """A figure or table of the paper.

    cases: stems of the case files, whose results are the arguments of `make`, which computes and draws.
    """

    number: str
    cases: tuple[str, ...]
    make: Callable[..., Outcome]

    @property
    def stem(self) -> str:
        """Name of the files, and of the markers of a page."""
        if self.number.startswith("Table"):
            return self.number.lower().replace(" ", "")
        digits = self.number.rstrip("ab")
        return f"figure{int(digits):02d}{self.number[len(digits) :]}"

    def run(self) -> Outcome:
        """Run the cases, compute and draw."""
        return self.make(*(run_case(stem) for stem in self.cases))


def run_case(stem: str) -> Case:
    """Run a case of the paper by the driver; raises ValueError with its message if that fails."""
    path = named_case(stem)
    results, case = drive(path), read_case(path)
    return Case(case.title, case.sweep, tuple(Curve(one, results[one.value]) for one in slip_tests(case)))


ROUNDING = 1.0e-12
"""Differences below this are rounding errors, which change from machine to machine."""


def numbers(*values: float) -> str:
    """Cells of a CSV with six digits; values within ROUNDING are zero."""
    return ",".join(f"{value if abs(value) > ROUNDING else 0.0:.6g}" for value in values)


def small(difference: float) -> str:
    """Text of a difference, which may be a rounding error."""
    return f"{difference:.0e}" if difference > ROUNDING else f"below {ROUNDING:.0e}"


def _thinned(curve: Curve) -> list[int]:
    """Indices of the rows of a curve in the CSV, the last row included."""
    last = len(curve.s_L) - 1
    return sorted({*range(0, last, max(1, -(-last // (MOST_ROWS - 1)))), last})


def curves_csv(parts: Sequence[tuple[Sequence[float], Curve]], names: str) -> tuple[str, tuple[str, ...]]:
    """Header and lines of curves, each with the values that identify the curve."""
    lines = []
    for values, c in parts:
        across = c.of(c.history.tau_along(c.test.direction + 90.0))
        columns = c.s_L, c.tau_L, across, c.s_N, c.of(c.history.damage)
        lines += [numbers(*values, *(column[i] for column in columns)) for i in _thinned(c)]
    return f"{names},s_L,tau_L,tau_across,s_N,damage", tuple(lines)


def pattern_csv(parts: Sequence[tuple[str, Pattern]]) -> tuple[str, tuple[str, ...]]:
    """Header and lines of patterns: normal and weight of each plane."""
    lines = [
        f"{name},{k + 1},{numbers(*normal, weight)}"
        for name, p in parts
        for k, (normal, weight) in enumerate(zip(p.normals, p.weights, strict=True))
    ]
    return "pattern,k,n_N,n_Tx,n_Ty,gamma", tuple(lines)


def signed(value: float) -> str:
    """Text of a number, with a minus sign instead of a hyphen."""
    return f"{value:g}".replace("-", "−")


def loop_work(curve: Curve) -> float:
    """Area of the closed loop of the last two strokes, stress*length."""
    first = turns_of(curve.s_L)[-3]
    return float(trapezoid(curve.tau_L[first:], curve.s_L[first:]))


SURE = 2.0e-6
"""Smallest spread that is printed.

The last change of the steps changes the largest and the smallest energy by 1e-6 of Gc each, so a smaller
spread may be an error of the steps.
"""


def energy_range(energies: Energies) -> str:
    """Text of the largest and smallest energy, and their spread."""
    sure = energies.spread >= SURE
    spread = f"spread {100.0 * energies.spread:.2g} %" if sure else f"spread below {100.0 * SURE:g} %"
    return f"{energies.values.max():.6f} to {energies.values.min():.6f} N/mm, {spread}"
