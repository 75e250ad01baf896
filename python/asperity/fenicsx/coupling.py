"""Linear steps in which water follows the openings: the flow and the joints are one system of equations.

A change v of the pressures moves the model by U v = tangent^-1 B' A v, which changes the pressures by
W B U v.  The whole change of the pressures solves (I - W B U) v = W B dx, with the step dx of given
pressures.  Neither matrix is made: U is a solution with the factor at hand, W B one of a flow; GMRES does
the rest.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..contract import Floats
from .ranks import totals
from .tangent import Equations
from .water import Water

ENOUGH, MOST = 1e-6, 200
"""Share of the right-hand side to which GMRES goes, and most iterations."""

ROUNDING = 1e-14
"""Share of the right-hand side below which a new direction is one of rounding errors."""


class Followed:
    """Steps from separations s (p, 3), at which the water has its pressures."""

    def __init__(self, q: Equations, water: Water, s: Floats, symmetric: bool = False) -> None:
        """Keep what a step needs; the first one factors the tangent, which is assembled."""
        self.q, self.moves, self.symmetric, self.fresh = q, water.moves, symmetric, True
        self.followed = water.following(s)

    def _solved(self, r: Floats) -> Floats | None:
        """Step of given pressures against a residual."""
        dx, _, _ = self.q.step(r, self.symmetric, self.fresh)
        self.fresh = False
        # a singular tangent may have a step that is not finite
        return None if dx is None or not np.isfinite(totals(float(np.abs(dx).sum()))[0]) else dx

    def step(self, r: Floats, given: Floats | float = 0.0) -> Floats | None:
        """Step against a residual, with that of the water; None where there is no solution.

        given (n d,): displacements of fixed components, whose forces r has.
        """
        dx = self._solved(r)
        if dx is None:
            return None
        dx = dx + given
        if not self.moves:
            return dx
        more = self._solved(-self._pressed(self.change(self.followed(self.q.model.separations(dx)))))
        return None if more is None else dx + more

    def change(self, wanted: Floats) -> Floats:
        """Change (p,) of the pressures of which `wanted` is left when the joints have followed it."""

        def remainder(v: Floats) -> Floats:
            dx = self._solved(-self._pressed(v))
            return v if dx is None else v - self.followed(self.q.model.separations(dx))

        return solved(remainder, wanted)

    def _pressed(self, p: Floats) -> Floats:
        """Forces (n d,) of pressures (p,) on both sides of the joints, on the free components."""
        return self.q.model.pulled(np.outer(p, [1.0, 0.0, 0.0])) * self.q.free


def solved(matrix: Callable[[Floats], Floats], b: Floats) -> Floats:
    """Solution of matrix(v) = b by GMRES, where each rank has a part of v; NaN where one is not finite."""
    size = float(np.sqrt(totals(b @ b)[0]))
    if not size or not np.isfinite(size):
        return 0.0 * b
    base, H = [b / size], np.zeros((MOST + 1, MOST))
    y: Floats = np.zeros(0)
    for k in range(MOST):
        w = matrix(base[k])
        for _ in range(2):  # once more for rounding errors
            shares = np.array(totals(*(v @ w for v in base)))
            H[: k + 1, k] += shares
            w = w - shares @ np.array(base)
        H[k + 1, k] = np.sqrt(totals(w @ w)[0])
        if not np.isfinite(H[k + 1, k]):
            return np.nan * b
        first = np.zeros(k + 2)
        first[0] = size
        y = np.asarray(np.linalg.lstsq(H[: k + 2, : k + 1], first)[0])
        rest = np.linalg.norm(H[: k + 2, : k + 1] @ y - first)
        if rest <= ENOUGH * size or H[k + 1, k] <= ROUNDING * size:
            break
        base.append(w / H[k + 1, k])
    return np.asarray(y @ np.array(base[: len(y)]))
