"""Steps along a path, cut where they fail."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from jointed_steps import Steps  # isort: skip  # loads MPI
import numpy as np
from asperity.contract import Floats
from jointed_mesh import COMM
from mpi4py import MPI

FAST, GROWTH = 6, 1.5
"""A step grows after at most FAST iterations."""


class Follow:
    """Steps along a path whose parameter is `at`; they are cut where they fail.

    conditions: displacements of the fixed components and loads at a value of the parameter.
    """

    def __init__(
        self,
        steps: Steps,
        conditions: Callable[[float], tuple[Floats, Floats]],
        step: float,
        most: float,
        least: float = 1e-5,
    ) -> None:
        """Begin at 0 with a step, which grows up to `most` and is cut down to `least`."""
        if not 0.0 < least <= step <= most < np.inf:
            raise ValueError(
                f"step = {step}, most = {most}, least = {least}: expected 0 < least <= step <= most"
            )
        self.steps, self.conditions, self.step, self.most, self.least = steps, conditions, step, most, least
        self.at, self.move, self.last = 0.0, 0.0, 0.0 * steps.model.u
        self.cuts, self.taken, self.count, self.reason = 0, 0, 0, ""

    def advance(self, end: float) -> bool:
        """Take one step towards a value, or cut it; whether it was taken."""
        model, left = self.steps.model, end - self.at
        last = abs(left) <= self.step * (1.0 + 1e-6)  # no step of rounding errors is left
        move = left if last else float(np.copysign(self.step, left))
        ahead = self.last * (move / self.move) if self.move * move > 0.0 else 0.0
        before = model.u
        good = self.steps.solve(*self.conditions(end if last else self.at + move), abs(move), ahead)
        self.taken += self.steps.iterations
        if not good:
            self.cuts, self.step = self.cuts + 1, abs(move) / 2.0
            if self.step < self.least:
                self.reason = f"stopped at {self.at:.5g}: {self.steps.message}"
            return False
        self.last, self.move = model.u - before, move
        self.at, self.count = end if last else self.at + move, self.count + 1
        if self.steps.iterations <= FAST:
            self.step = min(GROWTH * self.step, self.most)
        return True

    def save(self, file: Path) -> None:
        """Write what a run goes on from, FILE.RANK.npz."""
        now = np.array([self.at, self.move, self.step, self.cuts, self.taken, self.count, self.steps.largest])
        m = self.steps.model
        joints = {f"{name}{k}": one for name in ("s", "state") for k, one in enumerate(getattr(m, name))}
        new = file.with_suffix(f".{COMM.rank}.new.npz")
        np.savez(new, u=m.u, last=self.last, now=now, **joints)
        new.replace(file.with_suffix(f".{COMM.rank}.npz"))  # whole even if the run is ended here

    def resume(self, file: Path) -> None:
        """Go on from the files of a run with the same mesh, laws and ranks."""
        m, found = self.steps.model, dict(np.load(file.with_suffix(f".{COMM.rank}.npz")))
        same = [
            found[f"{name}{k}"].shape == one.shape
            for name in ("s", "state")
            for k, one in enumerate(getattr(m, name))
        ]
        if not COMM.allreduce(bool(all(same) and found["u"].shape == m.u.shape), MPI.LAND):
            raise ValueError(f"{file}: expected the files of a run with the same mesh, laws and ranks")
        m.u, self.last = found["u"], found["last"]
        m.s, m.state = ([found[f"{name}{k}"] for k in range(len(m.laws))] for name in ("s", "state"))
        self.at, self.move, self.step, *counts, self.steps.largest = found["now"].tolist()
        self.cuts, self.taken, self.count = map(int, counts)
