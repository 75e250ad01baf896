"""Dissipation control for `joint.Newton`: prescribed displacements turn back where a structure snaps back."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from joint import Floats, Newton, NotConverged
from scipy.sparse.linalg import splu


@dataclass
class DissipationControl:
    """Steps that dissipate a given energy (Gutiérrez 2004, Verhoosel et al. 2009).

    The prescribed displacements are a factor times `pattern`; the force is what does work on the factor. If
    the structure unloads to its origin, as with damage without friction, a step from (factor_0, force_0)
    dissipates (force_0 factor - factor_0 force)/2. This is the equation for the factor. Where a step
    dissipates nothing, the structure is elastic or separated; the factor then grows by `move`.

    energy: largest of a step.  move: of the factor, within the elastic range.  most: iterations of a step.
    """

    newton: Newton
    pattern: Floats
    energy: float
    move: float
    most: int = 12
    factor: float = 0.0
    force: float = 0.0
    part: float = 0.0
    last: tuple[Floats, float] | None = field(default=None, repr=False)

    def step(self, u: Floats) -> Floats:
        """Displacements after a step; accepts the state. The energy is halved until the step converges."""
        ended = False
        while True:
            try:
                new, factor, force, iterations = self._solve(u)
            except NotConverged:
                if ended or self.last is None:
                    raise
                if self.part == 0.0:
                    # no equilibrium at a larger factor
                    self.part = self._most()
                elif self.part > 1e-6 * self.energy:
                    self.part /= 2
                else:
                    # nothing is left to dissipate
                    self.part, ended = 0.0, True
                continue
            if self.part > 0.0 or self._dissipated(factor, force) <= self.energy:
                break
            if ended:
                raise NotConverged("the energy of a step is exceeded, however small it is")
            self.part, self.last = self._most(), (new - u, factor - self.factor)
        self.last = new - u, factor - self.factor
        self.factor, self.force = factor, force
        if self.part > 0.0 and 2 * iterations <= self.most:
            self.part = min(2 * self.part, self._most())
        self.newton.joint.accept(new)
        return new

    def _most(self) -> float:
        """Largest energy of the next step: a part of what is stored, so that the end is not overrun."""
        return min(self.energy, 0.125 * self.factor * self.force)

    def _dissipated(self, factor: float, force: float) -> float:
        """Energy that a step to this factor and force dissipates."""
        return 0.5 * (self.force * factor - self.factor * force)

    def _solve(self, u: Floats) -> tuple[Floats, float, float, int]:
        """Displacements, factor, force and iterations of a step; two right sides share a factorisation."""
        newton, fixed, pattern = self.newton, self.newton.fixed, self.pattern
        free = np.setdiff1d(np.arange(len(u)), fixed)
        factor, load = self.factor, np.zeros(len(u))
        if self.part > 0.0 and self.last is not None:
            # the tangent at the start is that of unloading: begin beyond it
            u, factor = u + self.last[0], factor + self.last[1]
        for iteration in range(self.most + 1):
            out, tangent, norm = newton.residual(u, load, free)
            force = float(pattern @ out[fixed])
            if self.part > 0.0:
                missing, scale = self.part - self._dissipated(factor, force), self.part
            else:
                missing, scale = self.factor + self.move - factor, self.move
            if norm <= newton.tolerance and abs(missing) <= 1e-6 * scale:
                return u, factor, force, iteration
            total = (newton.stiffness + tangent).tocsr()
            along, correction = np.zeros(len(u)), np.zeros(len(u))
            along[fixed] = pattern
            solve = splu(total[free][:, free].tocsc()).solve
            along[free] = solve(-(total[free][:, fixed] @ pattern))
            correction[free] = solve(-out[free])
            # changes of the force by the correction, and by a unit of the factor
            by_correction = float(pattern @ (total[fixed] @ correction))
            by_factor = float(pattern @ (total[fixed] @ along))
            if self.part > 0.0:
                move = (missing + 0.5 * self.factor * by_correction) / (
                    0.5 * (self.force - self.factor * by_factor)
                )
            else:
                move = missing
            u, factor = u + correction + move * along, factor + move
            newton.iterations += 1
        raise NotConverged(f"{self.most} iterations, residual {norm:.1e}")
