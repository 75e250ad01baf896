"""Energies of a model: what is stored and spent is what the loads have done."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .. import contract
from ..contract import Floats
from ..mesh.shapes import Integers
from .model import Model
from .ranks import total, totals
from .state import State

SNAP = 0.01
"""Share of the work of a step and of what joints spend in it that a snap releases at least."""


@dataclass(frozen=True)
class Ledger:
    """Energies of a model: now, or since the start (damped by solids and drag, work, released).

    elastic: of the solids.  stored, spent: of the joints; spent is that of rupture, friction and crushing.
    work: of the loads, of the prescribed displacements, and of the water in the joints.  released: by snaps,
    as the motion that a path of equilibria leaves out would have it.
    """

    kinetic: float = 0.0
    elastic: float = 0.0
    stored: float = 0.0
    spent: float = 0.0
    damped: float = 0.0
    work: float = 0.0
    released: float = 0.0

    @property
    def strain(self) -> float:
        """What solids and joints can give back."""
        return self.elastic + self.stored

    @property
    def balance(self) -> float:
        """Energy that nobody has given: at rest a constant, else it falls by numerical damping."""
        return self.kinetic + self.strain + self.spent + self.damped + self.released - self.work

    def unbalanced(self, start: float) -> float:
        """Change of the balance since one over the work."""
        gained = self.balance - start
        return gained / abs(self.work) if self.work else gained


def energy_of(m: Model, state: State, name: str) -> float:
    """Sum over all joints of an energy per area: stored, rupture, friction or, with fc, crushing."""
    rows = zip(m.laws, m.parts, state.joints, strict=True)
    named = (
        (contract.statev_names(law.n_planes, yields=law.material.fc > 0.0), part, joint)
        for law, part, joint in rows
    )
    # the energy of crushing is the last of a state, whatever comes before
    sums = (
        float(m.area[part] @ joint[:, -1 if name == "crushing" else names.index(name)])
        for names, part, joint in named
        if name in names
    )
    return total(sum(sums))


def ledger_of(m: Model, state: State, damped: float, work: float, kinetic: float = 0.0) -> Ledger:
    """Energies of a state, with sums since the start."""
    stored, *spent = (energy_of(m, state, name) for name in ("stored", "rupture", "friction", "crushing"))
    elastic = total(state.u @ (0.5 * m.stiff(state.u) + state.stress))
    return Ledger(kinetic, elastic, stored, sum(spent), damped, work)


def ledger_after(m: Model, before: Ledger, state: State, damped: float, done: Done) -> Ledger:
    """Energies after a step, in which drag and loads had these.

    What is missing counts as released where a snap alone explains it: strain energy and dead loads have given
    as much, and more than the errors of a step and than forces between those at both ends leave in doubt.
    """
    now = ledger_of(m, state, before.damped + damped, before.work + done.work)
    now = replace(now, released=before.released)
    short = before.balance - now.balance
    errors = max(done.doubt, SNAP * (abs(done.work) + abs(now.spent - before.spent)))
    snap = errors < short <= before.strain - now.strain + done.dead
    return replace(now, released=now.released + short) if snap else now


@dataclass(frozen=True)
class Done:
    """Work of loads, fixed components and water in a step, and by how much it differs at most.

    doubt: where each force has any value between those at both ends.  dead: work of the loads that do not
    change, less what fixed components take of it.
    """

    work: float
    doubt: float
    dead: float


def opened(m: Model, old: State, new: State) -> float:
    """Work of the water in the joints between two states."""
    return total(m.area @ (0.5 * (old.p + new.p) * (new.s - old.s)[:, 0]))


def work_of(m: Model, old: State, new: State, loads: tuple[Floats, Floats], fixed: Integers) -> Done:
    """Work between two states of loads (n d,) at both, of the fixed components, and of the water.

    Forces change in proportion to the displacements.
    """
    moved = new.u - old.u
    same = loads[0] == loads[1]
    same[fixed] = False
    forces, half = 0.5 * (loads[0] + loads[1]), 0.5 * (loads[1] - loads[0])
    forces[fixed] = 0.5 * (old.forces + new.forces)[fixed]
    half[fixed] = 0.5 * (new.forces - old.forces)[fixed]
    opening = m.area * (new.s - old.s)[:, 0]
    work, doubt, wet, dead, held = totals(
        forces @ moved,
        np.abs(half * moved).sum(),
        np.abs(0.5 * (new.p - old.p) * opening).sum(),
        forces[same] @ moved[same],
        forces[fixed] @ moved[fixed],
    )
    return Done(work + opened(m, old, new), doubt + wet, max(dead + min(held, 0.0), 0.0))
