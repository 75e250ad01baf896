"""Steps of a wall: Newton's method with a line search, and path control."""

from __future__ import annotations

import numpy as np
from asperity.contract import Floats
from distributed import NotConvergedError, Wall, largest, total

HALVINGS = 5
"""Most halvings of an iteration."""


class Steps:
    """Steps of a wall under a load; `tolerance` is that of the residual over the largest force.

    drag: a force on the half-bricks per volume and speed, which carries loose ones over sudden moves.
    """

    def __init__(self, wall: Wall, tolerance: float, most: int, drag: float) -> None:
        """Take at most `most` iterations in a step."""
        self.wall, self.tolerance, self.most = wall, tolerance, most
        self.drag = np.repeat(drag * wall.volume, wall.d)

    def rest(self, F: Floats, load: Floats, drag: Floats | float = 0.0) -> tuple[Floats, float, bool]:
        """Residual, its norm, and whether it is small."""
        free = self.wall.free
        R = (F - load + drag) * free
        scale = max(largest(F[~free]), largest(load), 1.0)
        return R, total(R @ R) ** 0.5, largest(R) <= self.tolerance * scale

    def newton(
        self, u: Floats, change: Floats, load: Floats, dt: float, last: Floats | None = None
    ) -> Floats:
        """Displacements after prescribed changes, which are zero where u is free.

        last: a change of u that is extrapolated to this step; without it the first iteration is linear.
        An iteration is halved until the residual falls, and the best try is taken.
        """
        wall, first = self.wall, last is None and largest(change) > 0.0
        start, slow = u, self.drag / dt
        if last is not None:
            u, change = np.where(wall.free, u + last, u + change), 0.0 * change
        self.iterations, F = 0, wall.update(u, dt)
        for iteration in range(self.most + 1):
            self.iterations = iteration
            R, norm, small = self.rest(F, load, slow * (u - start))
            if small and not first:
                wall.accept(F)
                return u
            if iteration == self.most or not np.isfinite(norm):
                break
            ahead = wall.tangent_times(change) + slow * change if first else 0.0
            (du,) = wall.solve(-R - ahead, diagonal=slow)
            best = None
            for factor in 0.5 ** np.arange(HALVINGS + 1):
                new = u + factor * (du + change)
                F = wall.update(new, dt)
                n = self.rest(F, load, slow * (new - start))[1]
                if best is None or n < best[0]:
                    best = n, new, F, wall.trial
                if first or n < (1.0 - 0.1 * factor) * norm:
                    break
            (_, u, F, wall.trial), change, first = best, 0.0 * change, False
        raise NotConvergedError(f"residual {norm:.2g} N after {self.iterations} iterations")

    def path(self, u: Floats, push: Floats, load: Floats, part: float) -> Floats:
        """Displacements after a step of path control; how far the top moves along `push` is unknown.

        Separations, weighted by the last growth of damage, move by `part` of their last move.
        """
        wall, F = self.wall, self.wall.F
        weights = [g.area * g.growth for g in wall.joints]
        sizes = [np.linalg.norm(g.moved, axis=1) for g in wall.joints]
        whole = max(total(sum(float(w.sum()) for w in weights)), 1e-30)
        along = [
            (g.growth / np.maximum(size, 1e-30))[:, None] * g.moved
            for g, size in zip(wall.joints, sizes, strict=True)
        ]
        c = wall.gather(None, along) / whole
        self.length = part * total(sum(float(w @ s) for w, s in zip(weights, sizes, strict=True))) / whole
        wall.trial, start = wall.accepted, u  # the tangent of the last step, in which damage grows
        for iteration in range(self.most + 1):
            self.iterations = iteration
            R, norm, small = self.rest(F, load)
            if small and iteration:
                wall.accept(F)
                return u
            if iteration == self.most or not np.isfinite(norm):
                break
            by_rest, by_push = wall.solve(-R, -wall.tangent_times(push))
            move = (self.length - total(c @ (u - start + by_rest))) / total(c @ (by_push + push))
            u = u + by_rest + move * (by_push + push)
            F = wall.update(u, 0.0)
        raise NotConvergedError(f"residual {norm:.2g} N after {self.iterations} iterations on the path")
