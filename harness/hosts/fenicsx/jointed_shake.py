"""Time steps of a model with mass: base motion, stiffness-proportional damping, a ledger of energies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from jointed_steps import Steps  # isort: skip  # loads MPI
import numpy as np
from asperity import contract
from asperity.contract import Floats
from jointed_mesh import COMM, agree, doubles, total
from jointed_model import Model
from jointed_saved import read, write
from mpi4py import MPI
from petsc4py import PETSc

RHO = 0.5
"""Spectral radius at infinity: with it bodies that hit each other gain no energy."""

GAIN = 0.01
"""Share of the energies in play that a step may gain, and by which their balance may rise in a run."""

ROOM, SHORT = 0.5, 1.0 / 64.0
"""Share of what is left of that rise that a step may gain which is longer than a share of the largest one."""

QUIET = 1e-3
"""Share of the elastic energy that counts as in play where nothing moves."""

GROWTH, FAST = 1.5, 8
"""A step grows back after at most FAST iterations."""


NUMBERS = "at", "next", "gained", "_spent", "_start", "_lowest", "_risen", "_size"
"""Numbers that a run goes on from."""


@dataclass(frozen=True)
class Ledger:
    """Energies of a model: at a time, or since the start (spent, damped, work)."""

    kinetic: float = 0.0
    elastic: float = 0.0
    stored: float = 0.0
    spent: float = 0.0
    damped: float = 0.0
    work: float = 0.0

    @property
    def balance(self) -> float:
        """Energy that nobody has given: at rest a constant, else it falls by numerical damping."""
        return self.kinetic + self.elastic + self.stored + self.spent + self.damped - self.work


class Shake:
    """Time steps of a model whose base may move, by Bossak's alpha method.

    The joints and the solids act with their forces at the end of a step, as contact needs; the inertia is
    blended.  Displacements, velocities and accelerations are those against the base.  The fixed components
    stay where they are.

    at: time.  v, a: velocity and acceleration, (n d,).  ledger: energies; a step that gains too much of
    them is cut, and a run whose balance has risen by more than GAIN of those in play stops at its end with a
    reason.  gained: sum of what steps have gained, over the largest energies in play.  cuts, taken: steps
    that were cut, and that count.
    """

    def __init__(
        self,
        steps: Steps,
        mass: Floats,
        load: Floats,
        step: float,
        least: float = 0.0,
        ground: Callable[[float], Floats] | None = None,
        beta: float = 0.0,
        rho: float = RHO,
    ) -> None:
        """Begin at rest at the last step of `steps`, which carries the load.

        The model has no water, whose work the ledger would not have.  mass: of the components, (n d,), as
        `np.abs(model.body([density] * d))`.  load: constant forces.  step: largest step; least: the smallest,
        step/1000 if 0.  ground: acceleration of the base at a time, (d,).  beta: damping of the solids over
        their stiffness, time; damping by mass would brake a slip.  rho: 0 to 1, from strong to no numerical
        damping.  `v` may be set before the first step.
        """
        m, least = steps.model, least or 1e-3 * step
        water = total(np.abs(m.water.outer).sum() + np.abs(m.water.p).sum())
        good = self._fits(mass, m) and bool(np.all(mass > 0.0))
        agree(
            f"water in the model: expected none, its forces sum up to {water:g}" if water else "",
            "" if good else f"mass: expected finite numbers above 0 of the shape {m.u.shape}",
            "" if self._fits(load, m) else f"load: expected finite numbers of the shape {m.u.shape}",
            "" if 0.0 < least <= step < np.inf else f"step = {step}, least = {least}: expected 0 < least",
            "" if 0.0 <= beta < np.inf else f"beta = {beta}: expected >= 0",
            "" if 0.0 <= rho <= 1.0 else f"rho = {rho}: expected 0 to 1",
        )  # fmt: skip
        self.steps, self.mass, self.load = steps, np.array(mass, float), np.array(load, float)
        self.ground, self.beta = ground, beta
        self.am = (rho - 1.0) / (rho + 1.0)
        self.gamma, self.newmark = 0.5 - self.am, 0.25 * (1.0 - self.am) ** 2
        self.at, self.most, self.least, self.next = 0.0, step, least, step
        self.cuts, self.taken, self.gained, self.reason = 0, 0, 0.0, ""
        self.K, self._damped, self._share = m.K, None, 0.0
        self.free = np.ones(m.u.shape)
        self.free[steps.fixed] = 0.0
        self.v, self.a = 0.0 * m.u, 0.0 * m.u
        self._begun, self._size, self._risen = False, 0.0, 0.0

    @staticmethod
    def _fits(values: Floats, m: Model) -> bool:
        """Whether there is a finite number for each component on this rank."""
        return np.shape(values) == m.u.shape and bool(np.isfinite(values).all())

    def _begin(self) -> None:
        """Acceleration at the start, and the energies there."""
        m = self.steps.model
        agree("" if self._fits(self.v, m) else f"v: expected finite numbers of the shape {m.u.shape}")
        x = self.steps.x.duplicate()
        x.array[:] = m.u + 0.0
        # the joints at rest, without a rate of their dashpots
        forces = m.forces(x, np.finfo(float).max ** 0.25)
        damping = self.beta * self._times(self.v)
        self.force = self._force(0.0)
        self.a = self.free * (self.force - forces - damping) / self.mass
        self.ledger = self._energies(0.0, 0.0)
        self._spent = self.ledger.spent
        self._start, self._lowest, self._begun = self.ledger.balance, self.ledger.balance, True
        self._size = self._in_play(self.ledger)

    def _force(self, t: float) -> Floats:
        """Loads and inertia of the base at a time."""
        if self.ground is None:
            return self.load
        m, given = self.steps.model, doubles(f"ground at {t:g}", self.ground(t))
        good = given.shape == (m.d,) and bool(np.isfinite(given).all())
        agree("" if good else f"ground at {t:g}: expected {m.d} finite components, not {given.tolist()}")
        return self.load - self.mass * np.tile(given, m.n)

    def _times(self, w: Floats) -> Floats:
        """Forces of the solids at displacements or velocities."""
        x, y = self.steps.x.duplicate(), self.steps.x.duplicate()
        x.array[:] = w
        self.K.mult(x, y)
        return y.array.copy()

    def _energies(self, damped: float, work: float) -> Ledger:
        """Energies now, with sums since the start."""
        m, kind = self.steps.model, contract.statev_index("stored")
        stored = sum((m.area[p] @ g[:, kind]).sum() for p, g in zip(m.parts, m.state, strict=True))
        elastic = total(m.u @ (0.5 * self._times(m.u) + m.stressed))
        return Ledger(0.5 * total(self.mass @ self.v**2), elastic, total(stored), m.spent(), damped, work)

    def _in_play(self, now: Ledger) -> float:
        """Size of the energies that move."""
        spent = now.spent - self._spent if self._begun else 0.0
        quiet = QUIET * (abs(now.elastic) + abs(now.stored))
        return max(self._size, now.kinetic, spent + now.damped, abs(now.work), quiet)

    def advance(self, end: float) -> bool:
        """Take one step towards a time, or cut it; whether it was taken."""
        agree("" if self.at < end < np.inf else f"end = {end}: expected a time after {self.at:g}")
        if not self._begun:
            self._begin()
        left = end - self.at
        last = left <= self.next * (1.0 + 1e-6)
        dt = left if last else min(self.next, 0.5 * left)  # no step of a tiny rest
        m, before = self.steps.model, (self.v, self.a, self.force, self.ledger)
        model = m.u, m.s, m.state, self.steps.largest
        good = self._solve(end if last else self.at + dt, dt)
        message = self.steps.message
        if good:
            size = self._in_play(self.ledger)
            gain = self.ledger.balance - before[3].balance
            risen = self.ledger.balance - self._lowest
            most = ROOM * max(GAIN * size + gain - risen, 0.0) if dt > SHORT * self.most else GAIN * size
            if gain > most:
                good, message = False, f"the step gains {gain:.2g}, the energies in play are {size:.2g}"
        if not good:
            self.v, self.a, self.force, self.ledger = before
            m.u, m.s, m.state, self.steps.largest = model
            self.cuts, self.next = self.cuts + 1, 0.5 * dt
            if self.next < self.least:
                self.reason = f"stopped at {self.at:.5g}: {message}"
            return False
        self._size, self.gained = size, self.gained + max(gain, 0.0) / (size or 1.0)
        self._lowest = min(self._lowest, self.ledger.balance)
        self._risen = max(self._risen, self.ledger.balance - self._lowest)
        self.at, self.taken = end if last else self.at + dt, self.taken + 1
        if last and self._risen > GAIN * size:
            text = f"all energies have risen by {self._risen:.2g}, of {size:.2g} in play"
            self.reason = f"ended at {self.at:.5g}, but {text}: expected at most {GAIN:g} of it"
            self.reason += ", try a smaller step"
        if not last and self.steps.iterations <= FAST:
            self.next = min(GROWTH * dt, self.most)
        return True

    def run(self, end: float) -> bool:
        """Take steps to a time; whether they reached it."""
        agree("" if self.at <= end < np.inf else f"end = {end}: expected a time, {self.at:g} or later")
        while not self.reason and self.at < end:
            self.advance(end)
        return not self.reason

    def save(self, file: str | Path) -> None:
        """Write what a run goes on from, FILE.RANK.npz."""
        if not self._begun:
            self._begin()
        write(
            file,
            self.steps.model,
            v=self.v,
            a=self.a,
            force=self.force,
            ledger=astuple(self.ledger),
            times=[self.steps.largest, *(getattr(self, name) for name in NUMBERS)],
            counts=[self.cuts, self.taken],
        )

    def resume(self, file: str | Path) -> None:
        """Go on from the files of a run with the same mesh, laws and ranks."""
        m = self.steps.model
        sizes = {"ledger": (len(fields(Ledger)),), "times": (1 + len(NUMBERS),), "counts": (2,)}
        saved = read(file, m, v=m.u.shape, a=m.u.shape, force=m.u.shape, **sizes)
        self.v, self.a, self.force = saved["v"], saved["a"], saved["force"]
        self.ledger = Ledger(*saved["ledger"].tolist())
        self.steps.largest, *numbers = saved["times"].tolist()
        for name, value in zip(NUMBERS, numbers, strict=True):
            setattr(self, name, value)
        self.cuts, self.taken = saved["counts"].tolist()
        self._begun = True

    def _solve(self, t: float, dt: float) -> bool:
        """Solve a step, and end it."""
        s, m, b, g = self.steps, self.steps.model, self.newmark, self.gamma
        u, v, a, begin = m.u, self.v, self.a, self.force
        old = v / (b * dt) + (0.5 / b - 1.0) * a
        # velocity at the end = rate u + w
        rate = g / (b * dt)
        w = -rate * u + (1.0 - g / b) * v + dt * (1.0 - 0.5 * g / b) * a
        force = self._force(t)
        ahead = dt * v + 0.5 * dt**2 * a
        inertia = self.mass * ((1.0 - self.am) * old - self.am * a)
        s.drag = self.mass * (1.0 - self.am) / (b * dt)
        try:
            m.K = self._with_damping(self.beta * rate)
            good = s.solve(u[s.fixed], force + inertia - self.beta * self._times(w), dt, ahead)
        finally:
            m.K = self.K
        if not COMM.allreduce(good, MPI.LAND):
            return False
        change = m.u - u
        new = self.free * (change / (b * dt**2) - old)
        self.v = self.free * (v + dt * ((1.0 - g) * a + g * new))
        self.a, self.force = new, force
        mean = change / dt
        damped = self.ledger.damped + dt * self.beta * total(mean @ self._times(mean))
        self.ledger = self._energies(damped, self.ledger.work + 0.5 * total((begin + force) @ change))
        return True

    def _with_damping(self, share: float) -> PETSc.Mat:
        """Stiffness of the solids with that of their damping in a step."""
        if share == 0.0:
            return self.K
        if share != self._share or self._damped is None:
            self._damped = self._damped or self.K.duplicate(copy=True)
            self.K.copy(self._damped)
            self._damped.scale(1.0 + share)
            self._share = share
        return self._damped
