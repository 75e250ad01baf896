"""Curves of the cases of the paper, and what figures find in them, as lines of a page."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from asperity.case_files import SlipTest, drive, read_case, slip_tests
from asperity.contract import Floats
from asperity.installed import named_case
from asperity.pattern import Pattern
from asperity.steps import turns_of
from pandas import DataFrame, concat
from scipy.integrate import trapezoid

from .fracture_energy import fracture_energy

FIVE = Pattern.regular(4, 30.0, flat=0.2)  # the five planes of Table 3
MOST_ROWS = 101  # approximate number of rows of a curve in a CSV
REACHED = 5.0e-4  # difference, MPa, below which a traction is the residual strength
ROUNDING = 1.0e-12  # differences below this are rounding errors, which change from machine to machine


@dataclass(frozen=True, eq=False)
class Curve:
    """Rows of a slip test from s_L = 0 on, mm and MPa, with the preload if there is one.

    lost: whether it ends because no equilibrium is left.  tau_across: traction left of the direction.
    """

    test: SlipTest
    lost: bool
    s_L: Floats
    tau_L: Floats
    tau_across: Floats
    s_N: Floats
    damage: Floats
    t_N: Floats

    @property
    def name(self) -> str:
        """Value of the sweep."""
        return signed(self.test.value or 0.0)

    @property
    def energy(self) -> float:
        """Area under the curve (40) by the trapezoid rule over its rows, N/mm."""
        return float(trapezoid(self.tau_L, self.s_L))

    @property
    def strength(self) -> float:
        """Residual strength in closed form, MPa."""
        test, sides = self.test, max(self.test.pattern.m, 1)
        away = (test.direction + 180.0 / sides) % (360.0 / sides) - 180.0 / sides
        return abs(test.sigma_N) * float(test.material.residual_strength(test.pattern.theta, away))


@dataclass(frozen=True)
class Case:
    """Results of a case file; name: what distinguishes it from the others of a figure."""

    name: str
    curves: tuple[Curve, ...]


def run_case(stem: str) -> Case:
    """Run a case of the paper by the driver; raises ValueError with its message if that fails."""
    path = named_case(stem)
    results, case, curves = drive(path), read_case(path), []
    for test in slip_tests(case):
        rows, angle, first = results[test.value], test.direction, test.preload - 1
        tractions = rows.tau_along(angle), rows.tau_along(angle + 90.0)
        columns = rows.slip_along(angle), *tractions, rows.dilation, rows.damage, rows.traction[:, 0]
        shown = (column[first:] if test.preload else np.append(0.0, column) for column in columns)
        curves.append(Curve(test, rows.lost, *shown))
    return Case(case.title.rpartition(": ")[2].rpartition(", ")[2], tuple(curves))


def curve_rows(cases: Iterable[Case]) -> DataFrame:
    """Some rows of all curves of cases, the last of each included, with the values that identify it."""
    parts = []
    for curve in (curve for case in cases for curve in case.curves):
        test, last = curve.test, len(curve.s_L) - 1
        columns = {"eta": test.material.eta, "m": test.pattern.m, "theta_m": test.pattern.theta}
        columns |= {"theta_L": test.direction, "sigma_N": test.sigma_N}
        columns |= {name: getattr(curve, name) for name in ("s_L", "tau_L", "tau_across", "s_N", "damage")}
        parts.append(DataFrame(columns).iloc[[*range(0, last, max(1, -(-last // (MOST_ROWS - 1)))), last]])
    return concat(parts)


def signed(value: float) -> str:
    """Text of a number, with a minus sign instead of a hyphen."""
    return f"{value:g}".replace("-", "−")


def ends(case: Case) -> str:
    """Traction at the end of each curve and residual strength, and where equilibrium ends."""
    ends_of_curves = (f"{c.name}: {_share(c)}" for c in case.curves if not c.lost)
    beyond = "no equilibrium beyond $s_L$ ="
    lost = (f"; {c.name}: {beyond} {c.s_L[-1]:.4f} mm" for c in case.curves if c.lost)
    return f"{', '.join(ends_of_curves)}{''.join(lost)}."


def _share(curve: Curve) -> str:
    """Traction at the end of a curve, and the residual strength where it differs."""
    end, strength = curve.tau_L[-1], curve.strength
    return f"{end:.3f}" if abs(end - strength) < REACHED else f"{end:.3f} of {strength:.3f}"


def spread(case: Case) -> str:
    """Smallest and largest traction at the end."""
    tau = np.array([c.tau_L[-1] for c in case.curves])
    return f"{tau.min():.3f} to {tau.max():.3f}, spread {percent(tau)}."


def strokes(case: Case) -> str:
    """Traction at the ends of the strokes of cycles, and the area of the closed loop of the last two."""
    parts = []
    for c in (c for c in case.curves if c.test.sigma_N < 0.0):
        turns = turns_of(c.s_L)
        tau = ", ".join(f"{c.tau_L[i]:.3f}".replace("-", "−") for i in turns[1:])
        work = trapezoid(c.tau_L[turns[-3] :], c.s_L[turns[-3] :])
        parts.append(f"{signed(c.test.sigma_N)}: {tau}, loop {work:.3f}")
    return f"{'; '.join(parts)}."


def climb(case: Case) -> str:
    """Slope of the dilation at the end, and up the planes that face the slip."""
    slopes = [np.diff(c.s_N)[-1] / np.diff(c.s_L)[-1] for c in case.curves if not c.lost]
    test = case.curves[0].test
    limit = np.tan(np.radians(test.pattern.theta)) * np.cos(np.radians(test.direction))
    ends = f"{min(slopes):.4f} to {max(slopes):.4f}"
    return f"slope of the dilation at 0.6 mm {ends}, up the facing planes {limit:.4f}."


def energies(case: Case) -> str:
    """Energies by the rows of the curves, and converged ones."""
    tests = [c.test for c in case.curves]
    exact = [fracture_energy(t.material, t.pattern, np.array([t.direction])).values[0] for t in tests]
    parts = (
        f"{c.name}°: {c.energy:.6f}, {converged:.6f}" for c, converged in zip(case.curves, exact, strict=True)
    )
    return f"{'; '.join(parts)}."


def percent(values: Floats) -> str:
    """Largest over smallest value, less 1."""
    return f"{100.0 * (values.max() / values.min() - 1.0):.2f} %"
