"""Rupture and friction of an increment in the reference: what the law books, and the sum over fine parts.

`fine` divides the straight step of an increment into parts and carries the state from part to part; its sums
converge to what the law dissipates along the step, however long that is.  Arrays are those of reference.py.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from . import plane
from .plane import Floats, Parameters


def bond(parameters: Parameters, s: Floats) -> tuple[Floats, Floats]:
    """Energy of the bond except for that of its pressure, and the square of 1 + beta, (6)."""
    opening, slip = plane.positive(s[..., 0]) ** 2, (s[..., 1:] ** 2).sum(-1)
    energy = 0.5 * parameters.Kn * opening + 0.5 * parameters.Kt * slip
    return energy, opening / parameters.s0**2 + slip / parameters.s02**2


def of_part(
    parameters: Parameters, s: tuple[Floats, Floats], alpha: tuple[Floats, Floats], ends: Floats
) -> Floats:
    """Energy of the bond that growing damage releases in a small part; ends: by the trapezoidal rule.

    On the damage surface 1 + beta is r = 1/(1 - eta alpha), so that d alpha = dr/(eta r^2), and the energy
    of the bond is Y_1 r^2: its integral over the damage is Y_1 times the change of r over eta.  A bond that
    viscosity has left with more separation than its damage has the trapezoidal rule.
    """
    (first, q), (last, r) = bond(parameters, s[0]), bond(parameters, s[1])
    Y = last / np.where(r > 0.0, r, 1.0)
    Y = 0.5 * (Y + np.where(q > 0.0, first / np.where(q > 0.0, q, 1.0), Y))
    start, end = (1.0 / (1.0 - parameters.eta * a) for a in alpha)
    behind = (q > (1.0 + 2.0**-26) * start**2) | (parameters.tau_v > 0.0)
    return np.where(behind, ends, Y * (end - start) / parameters.eta)


def rupture(
    parameters: Parameters,
    s: tuple[Floats, Floats],
    contact: tuple[Floats, Floats],
    slip: tuple[Floats, Floats],
    alpha: tuple[Floats, Floats],
    branch: NDArray[np.int8],
    part: bool,
) -> Floats:
    """Rupture of an increment by the trapezoidal rule.

    In a small part of a step, where the contact does not stick, that of the bond is exact.
    """
    grown = alpha[1] - alpha[0]
    by_ends = [plane.release_rate(parameters, *x) * grown for x in zip(s, contact, slip, strict=True)]
    if part:
        ends = 0.5 * (bond(parameters, s[0])[0] + bond(parameters, s[1])[0]) * grown
        more = np.where(branch == plane.STICK, 0.0, of_part(parameters, s, alpha, ends) - ends)
        by_ends = [x + more for x in by_ends]
    return 0.5 * (by_ends[0] + by_ends[1])


def long(parameters: Parameters, s_old: Floats, s: Floats, dt: float) -> NDArray[np.bool_]:
    """Whether the library takes the accounts of increments by their phases (docs/theory.md, section 6).

    It does so where the separation moves by more than a twentieth of the geometric mean of s_0 and s_f.
    """
    s_0 = min(parameters.s0, parameters.s02)
    part = dt / (dt + parameters.tau_v) if parameters.tau_v else 1.0  # of the way, that the damage goes
    return part * np.linalg.norm(s - s_old, axis=-1) > 0.05 * s_0 / np.sqrt(1.0 - parameters.eta)
