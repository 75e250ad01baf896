"""Equilibria along a path whose parameter is an unknown, too: a limit load, and what is carried beyond.

Unknown are displacements x and the parameter `at` of the conditions:

    r(x, at) = 0,   mean over the joints of d . (s(x) - s) = step

with the separations s of the last state, and the direction d of their last change, of the length 1 in the
mean of its squares over the area.  Water follows the openings of each iteration, also in the tangent.

    x, at = on from the last change
    until |r| <= tolerance * forces
        A dx = -r,  A dq = -dr/d(at)                         # one tangent
        d(at) = what the second equation asks for
        x, at = x + dx + d(at) dq, at + d(at)
    no equilibrium: keep the old state; the step becomes half; else: take the new one; the step grows
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from ..contract import Floats
from .conditions import Conditions, Held, held
from .coupling import Followed
from .equilibrium import Report, Terms, begun, solve
from .ledger import Ledger, ledger_after, ledger_of, work_of
from .model import Model
from .newton import Task, balance_of
from .ranks import agree, called, doubles, largest, real, totals
from .response import LawError, respond
from .state import State
from .stopped import Stopped
from .tangent import equations_of
from .water import Water

FAST = 6
"""Most iterations of a step after which the next one is longer: more say that the step is long enough."""

GROWTH = 1.5
"""Factor by which a step grows.  It is below the 2 that a failed attempt takes off again."""

LEAST = 1e-4
"""Least step over the first one, below which the branch ends: that is 14 halves of it."""

SHIFT = 1e-12
"""Share of the stiffness of the solids that the tangent has more: it is singular where a block slides."""

APART = 1e-4
"""Share of the parameter by which its derivative is taken."""


class Branch:
    """Steps along a path beyond its limit load, where the parameter falls.

    state: of the last step, `before` that of the one before.  report: of the last attempt.  at: parameter.
    count, cuts, taken: steps, attempts that failed, iterations.  reason: why it is stopped, or empty.
    ledger: energies since the start, whose balance was `start` then.
    """

    def __init__(
        self,
        model: Model,
        state: State,
        before: State,
        conditions: Callable[[float], Conditions],
        most: float,
        terms: Terms | None = None,
        ledger: Ledger | None = None,
    ) -> None:
        """Begin at a state with the step from the state before.

        conditions: as those of `Follow`.  most: largest step, root of the mean of the squares of the change
        of the separations over the area.  terms: of the equations, without drag; dt is the duration of every
        step.
        """
        self.model, self.conditions, self.terms = model, conditions, begun(model, state, terms)
        begun(model, before, terms)
        agree("" if callable(conditions) else f"conditions {conditions!r}: expected a function of a number")
        self.state, self.before, self.most = state, before, most
        self.length = self._length(state.s - before.s)
        drag = largest(doubles("drag", self.terms.drag))
        agree(
            "" if real(most) and most > 0.0 else f"most = {most}: expected above 0",
            "" if self.length > 0.0 else "both states have the same separations: expected a step of a path",
            "" if drag == self.terms.damping == 0.0 else "drag or damping: expected none on a branch",
        )  # fmt: skip
        self.step = min(self.length, most)
        self.least = LEAST * self.step
        self.count, self.cuts, self.taken, self.reason = 0, 0, 0, ""
        self.ledger = ledger or ledger_of(model, state, 0.0, 0.0)
        self.start = self.ledger.balance
        self.report: Report | None = None

    @property
    def at(self) -> float:
        """Parameter of the last step."""
        return self.state.at

    @property
    def size(self) -> float:
        """Root of the mean of the squares of the separations over the area."""
        return self._length(self.state.s)

    @property
    def unbalanced(self) -> float:
        """Change of the balance of all energies over the work; that which snaps release is in the ledger."""
        return self.ledger.unbalanced(self.start)

    def _length(self, s: Floats) -> float:
        """Root of the mean of the squares of separations (p, 3) over the area."""
        area = self.model.area
        squares, total_area = totals(area @ (s**2).sum(1), area.sum())
        return float(np.sqrt(squares / (total_area or 1.0)))

    def to(self, ended: Callable[[State], bool]) -> Iterator[Report]:
        """Take steps until a state is said to be the last, and yield the report of each.

        Raises Stopped where the branch ends before.
        """
        while not ended(self.state):
            if self.advance():
                assert self.report
                yield self.report

    def advance(self) -> bool:
        """Take one step, or cut it; whether it was taken.

        Raises Stopped where the branch has ended before.
        """
        if self.reason:
            raise Stopped(self.reason)
        old, new = self.state, None
        x, at, iterations, reason = self._located()
        self.taken += iterations
        if not reason:
            openings = self.model.separations(x)
            terms = replace(self.terms, at=at, ahead=x - old.u, openings=openings, passes=0)
            report = self.report = solve(self.model, old, called(self.conditions, at), terms)
            new, reason = report.state, report.reason
            self.report = replace(report, iterations=iterations + report.iterations)
        if new is None:
            self.cuts, self.step = self.cuts + 1, 0.5 * self.step
            if self.step < self.least:
                self.reason = f"stopped at {self.at:.5g}: {reason}"
            return False
        loads = self._given(old.at)[1], report.load
        done = work_of(self.model, old, new, loads, report.fixed)
        self.ledger = ledger_after(self.model, self.ledger, new, 0.0, done)
        self.before, self.state, self.count = old, new, self.count + 1
        self.length = self._length(new.s - old.s)
        if iterations <= FAST:
            self.step = min(GROWTH * self.step, self.most)
        return True

    def _given(self, at: float) -> tuple[Held, Floats, Water]:
        """Conditions at a parameter, loads with the pressures on faces, and the water."""
        given = called(self.conditions, at)
        water = Water(self.model, given.pressures, given.flows)
        now = held(self.model, given)
        return now, now.load + water.outer, water

    def _located(self) -> tuple[Floats, float, int, str]:
        """Displacements and parameter of the next step, iterations, and why there are none."""
        m, old = self.model, self.state
        change = old.s - self.before.s
        ratio = self.step / self.length
        weights = m.area[:, None] * change / (self.length * totals(m.area.sum())[0])
        x, at = old.u + ratio * (old.u - self.before.u), old.at + ratio * (old.at - self.before.at)
        none, t = np.zeros(len(x)), self.terms
        q = equations_of(m, self._given(old.at)[0].fixed, t.options)
        for iteration in range(t.iterations + 1):
            h = APART * (abs(at) or 1.0)
            try:  # an iterate may be where there are no conditions, or no water
                (now, load, water), (then, more, wetter) = self._given(at), self._given(at + h)
                x[q.fixed] = now.values
                s = m.separations(x)
                (p, _), (wet, _) = water.at(s), wetter.at(s)
                steps = Followed(q, water, s)
            except ValueError as error:
                return x, at, iteration, f"the conditions at {at:.5g}: {error}"
            try:
                response = respond(m, old, s, t.dt, p, iterate=True)
            except LawError as error:
                return x, at, iteration, f"the law: {error}"
            task = Task(now.values, load, p, t.dt, none, 0.0, t.tolerance, t.search)
            balance = balance_of(q, old, task, x, response.t)
            missing = self.step - totals((weights * (s - old.s)).sum())[0]
            if balance.residual <= balance.enough and abs(missing) <= 1e-6 * self.step:
                return x, at, iteration, ""
            if iteration == t.iterations or not np.isfinite(balance.residual):
                break
            moved = none.copy()
            moved[q.fixed] = (then.values - now.values) / h
            pulled = np.einsum("pij,pj->pi", response.D, m.separations(moved))
            pulled[:, 0] -= (wet - p) / h
            slope = (m.stiff(moved) + m.pulled(pulled) - (more - load) / h) * q.free
            q.assemble(response.D, task.drag / task.dt, task.damping, SHIFT, False)
            first, second = steps.step(balance.full), steps.step(slope, moved)
            if first is None or second is None:
                return x, at, iteration, "the tangent has no solution"
            reached, rate = totals(
                (weights * m.separations(first)).sum(), (weights * m.separations(second)).sum()
            )
            if not np.isfinite(reached) or not rate:
                break
            forward = (missing - reached) / rate
            x, at = x + first + forward * second, at + forward
        return x, at, t.iterations, "the iterations end without an equilibrium"
