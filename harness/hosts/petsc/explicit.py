"""Explicit dynamics of a wall: central differences, with masses for a time step of 1."""

from __future__ import annotations

import numpy as np
from asperity.contract import Floats
from distributed import NotConvergedError, Wall, total

SETTLE = 1.0
"""The top reaches its speed, and velocities decay, while it moves by so much, mm."""

DAMPING = 0.2
"""Damping by the stiffness of the half-bricks, as a part of the time step."""

SAFETY = 2.0
"""Masses over those of the stability limit; friction couples the components of the joints beyond it."""


class Explicit:
    """Motion of a wall from rest at u, with a top that moves by at most `rate` in a step, along `push`."""

    def __init__(self, wall: Wall, u: Floats, push: Floats, load: Floats, rate: float) -> None:
        """Bound the frequencies by the sums of the rows of the virgin stiffness (Gershgorin)."""
        self.wall, self.u, self.push, self.load, self.rate = wall, u, push, load, rate
        sums = [np.abs(K).sum(1).reshape(-1, wall.d) for K in wall.K]
        bound = np.zeros((len(wall.nodes), wall.d))
        bound[: wall.own] = np.concatenate([sums[int(stiff)] for stiff in wall.stiff])
        for g in wall.joints:
            tangent = g.law.update(np.zeros((1, 3)), dt=1.0).tangent[0]
            row = 2.0 * np.abs(g.axes.T @ tangent @ g.axes).sum(1)
            np.add.at(bound, g.nodes, (g.area[:, None] * row)[:, None])
        bound = wall.collect(bound).reshape(-1, wall.d)
        self.mass = np.repeat(SAFETY * bound.max(1) / 4.0, wall.d)
        self.none = [np.zeros((len(g.area), 3)) for g in wall.joints]
        self.v, self.F = np.zeros_like(u), wall.F
        self.steps, self.work, self.kinetic = 0, 0.0, 0.0

    def move(self, left: float) -> float:
        """Move the top by `left` and return by how much it moved; wall.F is the mean force meanwhile."""
        w, decay, done, count, forces = self.wall, self.rate / SETTLE / 2.0, 0.0, 0, 0.0
        while done < left:
            self.steps, count = self.steps + 1, count + 1
            speed = self.rate * min(1.0, 0.5 * self.steps * self.rate / SETTLE)
            drag = w.gather(w.spread(DAMPING * self.v), self.none)
            pull = (self.load - self.F - drag) * w.free / self.mass
            self.v = ((1.0 - decay) * self.v + pull) / (1.0 + decay) * w.free + speed * self.push
            self.u, done = self.u + self.v, done + speed
            self.F = w.update(self.u, speed)
            w.accept(self.F)
            forces = forces + self.F
            self.work += speed * total(self.F @ self.push)
        kinetic = 0.5 * total(self.mass @ (self.v * w.free) ** 2)
        if not kinetic <= 1.0 + abs(self.work):
            raise NotConvergedError("kinetic energy above the work of the top: expected smaller steps")
        if self.steps * self.rate >= 2.0 * SETTLE:
            self.kinetic = max(self.kinetic, kinetic / self.work)
        w.F = forces / count
        return done
