"""Resultants of forces on the bodies of a model: solids whose cells share nodes, between joints."""

from __future__ import annotations

import numpy as np

from ..contract import Floats
from ..mesh.shapes import Integers
from .ranks import COMM

STILL = 1e-9
"""Square of what a rigid motion moves of the fixed components, over the largest one, that counts as none.

Rounding errors are 1e-16 of it; two fixed nodes hold a body of up to 3e4 times their distance.
"""


class Bodies:
    """Forces and moments on bodies, whose nodes all ranks share.

    Moments are those about the middle of the nodes of a body; one of revolution has an axial force alone.
    """

    def __init__(self, number: Integers, count: int, x: Floats, axisymmetric: bool) -> None:
        """Sort owned nodes x (n, d) by the number of their body."""
        self.number, self.count, self.d = number, count, x.shape[1]
        nodes, *middle = self._sums(np.ones(len(x)), *x.T)
        self.nodes = np.maximum(nodes, 1.0)
        self.arm = x - (np.array(middle) / self.nodes).T[number]
        self.turns = [(0, 1)] if self.d == 2 else [(1, 2), (2, 0), (0, 1)]
        self.along = np.ones(self.d)
        if axisymmetric:
            self.turns, self.along[0] = [], 0.0
        turned = [self._turned(i, j) for i, j in self.turns]
        rows = [self._sums(*((a * b).sum(1) for b in turned)) for a in turned]
        inertia = np.moveaxis(np.array(rows).reshape(len(turned), len(turned), count), 2, 0)
        self.size = np.sqrt(np.trace(inertia, axis1=1, axis2=2) / self.nodes)
        self.inverse = np.linalg.pinv(inertia)

    def _sums(self, *columns: Floats) -> Floats:
        """Sums of columns (n,) over the nodes of each body, on all ranks."""
        rows = np.array([np.bincount(self.number, column, self.count) for column in columns])
        return np.asarray(COMM.allreduce(rows) if COMM.size > 1 else rows)

    def _turned(self, i: int, j: int) -> Floats:
        """Displacements (n, d) of a rotation from axis i to j."""
        u = np.zeros_like(self.arm)
        u[:, i], u[:, j] = -self.arm[:, j], self.arm[:, i]
        return np.asarray(u)

    def _resultants(self, f: Floats) -> tuple[Floats, Floats]:
        """Forces (count, d) and moments (count, 1 or 3) of forces (n, d)."""
        sums = self._sums(*f.T, *((self._turned(i, j) * f).sum(1) for i, j in self.turns)).T
        return sums[:, : self.d] * self.along, sums[:, self.d :]

    def balanced(self, forces: Floats) -> Floats:
        """Forces (n d,) without their resultants, as those of solids must be but for rounding."""
        f: Floats = forces.reshape(-1, self.d)
        force, moment = self._resultants(f)
        spin = np.einsum("bij,bj->bi", self.inverse, moment)[self.number]
        f = f - (force / self.nodes[:, None])[self.number]
        for k, (i, j) in enumerate(self.turns):
            f = f - spin[:, k : k + 1] * self._turned(i, j)
        return np.asarray(f.ravel())

    def loose(self, forces: Floats, fixed: Integers) -> float:
        """Sum of the magnitudes of forces (n d,) along rigid motions of bodies that move no fixed component.

        Rotations count over the size of their body.
        """
        f, held = forces.reshape(-1, self.d), np.zeros_like(self.arm)
        held.flat[fixed] = 1.0
        size = np.where(self.size > 0.0, self.size, np.inf)[self.number, None]
        motions = [np.broadcast_to(way, f.shape) for way in np.diag(self.along)]
        motions += [self._turned(i, j) / size for i, j in self.turns]
        products = self._sums(*((a * b * held).sum(1) for a in motions for b in motions))
        squares, ways = np.linalg.eigh(products.T.reshape(self.count, len(motions), len(motions)))
        free = ways * (squares <= STILL * squares[:, -1:])[:, None]
        along = self._sums(*((a * f).sum(1) for a in motions)).T
        return float(np.abs(np.einsum("bij,bkj,bk->bi", free, free, along)).sum())
