"""Total measured fracture energy G_T (40) at sigma_N = 0 over the direction of slip, and Table 5."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.material import Material
from asperity.pattern import Pattern
from asperity.tools.slip_curves import slip_curves
from scipy.integrate import trapezoid

TABLE_5 = {
    "RT": (2, "0.3475", "0.2963", "1.1727"),
    "RP-3": (3, "0.3391", "0.3241", "1.0463"),
    "RP-4": (4, "0.3338", "0.3333", "1.0014"),
    "RP-6": (6, "0.3352", "0.3312", "1.0120"),
    "RP-32": (32, "0.3332", "0.3330", "1.0006"),
}
"""Inclined planes of a pattern of Table 4; largest and smallest energy, N/mm, and their ratio, as printed."""

MATERIAL = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)  # Table 2: MPa, N/mm
THETA = 30.0  # inclination of the planes of Section 4.4, degrees
DIRECTIONS = 360.0 / 64.0 * np.arange(64)  # the 64 directions of Table 5, degrees
STEP = 0.0025  # displacement intervals of the paper, mm
SAMPLING = (9, 10)  # first point after s_L = 0, interval: give Table 5 to the last digit (inferred)
SPAN = 1.05  # end of a path in multiples of s_f; every plane is fully damaged at a slip of s_f
COARSEST, FINEST = 420, 107520  # increments of the first and last halving; 0.1 s_f and s_f are rows
NO_TRACTION = 1.0e-9  # traction at the end of a path, relative to sigma0, that counts as zero


@dataclass(frozen=True, eq=False)
class Energies:
    """G_T (C,) in the directions (C,), degrees; error (C,): change by the last halving of the steps."""

    directions: Floats
    values: Floats
    error: Floats

    @property
    def spread(self) -> float:
        """Largest over smallest, minus 1."""
        return float(self.values.max() / self.values.min()) - 1.0


def pattern(name: str) -> Pattern:
    """A pattern of Table 4 at 30 degrees."""
    return Pattern.regular(TABLE_5[name][0], THETA)


def distinct(pattern: Pattern, directions: Floats) -> tuple[Floats, np.ndarray]:
    """Directions that are not equivalent by symmetry of a regular pattern, and the index of each given one.

    Rotations and mirror planes of the pattern map each angle into [0, 180/m]; others are left as they are.
    """
    if pattern.m < 2:  # listed planes have no symmetry that is known
        return directions, np.arange(len(directions))
    period = 360.0 / pattern.m
    folded = np.abs((directions - pattern.turn + period / 2.0) % period - period / 2.0)
    # equal up to rounding errors of the mapping
    values, inverse = np.unique(np.round(folded, 9), return_inverse=True)
    return values + pattern.turn, inverse


def fracture_energy(
    material: Material, pattern: Pattern, directions: Floats = DIRECTIONS, tolerance: float = 1.0e-6
) -> Energies:
    """G_T of a regular pattern at sigma_N = 0; steps are halved until it changes by less than tolerance Gc.

    G_T is the work of the path by the trapezoid rule over all rows.  Raises ValueError where the interface
    still carries a traction at the end or the number of steps becomes too large.
    """
    angles, place = distinct(pattern, np.asarray(directions, dtype=float))
    last = np.full(len(angles), np.inf)
    n = COARSEST
    while n <= FINEST:
        slips = SPAN * material.s_f * np.arange(1, n + 1) / n
        curves = slip_curves(Interface(material, pattern), angles, slips, preload=1)
        if (curves.rows < n).any():
            raise ValueError(f"no equilibrium at sigma_N = 0 in direction {angles[curves.rows.argmin()]:g}")
        traction = np.abs(curves.tau_L[:, -1]).max()
        if not traction <= NO_TRACTION * material.sigma0:
            raise ValueError(
                f"traction {traction:g} at s_L = {slips[-1]:g}: expected a fully damaged, open interface"
            )
        error = np.abs(curves.work[:, -1] - last)
        last, n = curves.work[:, -1], 2 * n
        if error.max() < tolerance * material.Gc:
            return Energies(np.asarray(directions), last[place], error[place])
    raise ValueError(
        f"G_T changes by {error.max():g} with {FINEST} increments: expected less than {tolerance:g}"
    )


def sampled(name: str) -> tuple[str, str, str]:
    """Largest and smallest energy of a pattern of Table 5, and their ratio, as the paper prints them.

    The area is by the trapezoid rule over s_L = 0 and the rows of SAMPLING, with the steps of the paper, for
    the distinct ones of the 64 directions.
    """
    first, interval = SAMPLING
    n = int(np.ceil(SPAN * MATERIAL.s_f / STEP)) + 2 * interval
    angles, _ = distinct(pattern(name), DIRECTIONS)
    curves = slip_curves(Interface(MATERIAL, pattern(name)), angles, STEP * np.arange(1, n + 1), preload=1)
    rows = np.s_[first - 1 :: interval]
    tau = np.pad(curves.tau_L[:, rows], ((0, 0), (1, 0)))
    areas = trapezoid(tau, np.append(0.0, curves.slips[rows]))
    return f"{areas.max():.4f}", f"{areas.min():.4f}", f"{areas.max() / areas.min():.4f}"
