"""Steps along a path of conditions: cut where they fail, by passes where short ones fail and no loads change.

Newton's method begins, and goes on after a step by passes that it has ended or whose errors are small.

    while at is not the end
        move = step, or what is left
        report = solve(state, conditions(at + move)), by Newton's method or by passes, from the change before,
                  unless that was a jump under loads, whose energies do not balance
        no state, or water has no pressure there: keep the old state; the step becomes half, a quarter under
                  loads; too short: the path is stopped
                  no loads change, Newton's method failed, and half of the step is short: passes take it
                  passes failed under loads that change: Newton's method follows
                  too short under loads that change: the parameter becomes an unknown, and the path goes along
                  the branch of equilibria, to the end or to a limit load, where the parameter turns
        passes under loads that change: Newton's method ends them, or there is no state
        errors of the passes too large: keep the old state; the step is repeated with less of its length,
                  unless it is the shortest one and no loads change
        energies of the path do not balance, by this step, and no loads change: keep the old state; the step
                  is repeated in halves, down to a share of the largest one and to the least
        no loads change, and the equilibrium is not stable: it is left for one beside it; where one is on each
                  side the step is repeated in halves, as of two joints the one that softens first opens
        else: take the new state; the step grows

A `Follow` holds two states, the last and the one before, and the numbers of these rules.  What fails leaves
nothing behind, because nothing of a state is written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import astuple, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..contract import Floats
from ..mesh.shapes import place
from .branch import Branch
from .conditions import Conditions, held
from .equilibrium import Report, Terms, begun, solve
from .ledger import SNAP, Ledger, ledger_after, ledger_of, work_of
from .model import Model
from .passes import PASSES
from .ranks import agree, called, real, total, totals, whole_number
from .stability import beside
from .state import State, read, write
from .stopped import Stopped
from .water import WATER, Water

FAST, GROWTH = 6, 1.5
"""A step grows after at most FAST iterations."""

CUT = 0.5, 0.25
"""Share of a step after a failure without and under loads, where most failures are those of a limit load."""

ERRORS = 0.1, 0.01
"""Errors of a step by passes, of a damage and of forces, beyond which a shorter one replaces it."""

ENOUGH = 0.01
"""Errors of a step by passes, over those, up to which Newton's method goes on."""

MISSING, FINEST = 3e-3, 0.03125
"""Energy that a path may miss, over its work and the change of the strain energy; and the finest share.

The work of a step is a trapezoid, which is wrong where a crack runs: a step after which the path misses more,
and which adds more than the finest share of that, is taken again in halves, down to the finest share of the
largest step.  A prestress that the path releases counts as strain energy.
"""

SAME = 1.0 + 1e-6
"""Quotient of lengths of steps that are the same but for rounding."""

LIMIT = 0.05
"""Error of forces of a shortest step beyond which the path ends; no step is short enough for a snap."""

SHORT = 0.22
"""Share of the largest step up to which a step is short."""

SHORTEST = 10.0
"""Least step by passes over that of Newton's method."""

LEFT = 12
"""Most equilibria of a step that are left as they are not stable: of n joints that soften at once n - 1."""

NOISE = 1e-8
"""Change of the loads in the largest step, over the forces, up to which it is that of rounding errors."""

FLAT = 1e-6
"""Share of the shortest step by which the parameter must grow in a step of the branch; else it turns."""

LOOK, LEVEL = 80, 1e-5
"""Most attempts on a branch; share of the parameter that a limit may still gain while separations double."""

LIMIT_LOAD, LAW, NOT_FOUND = "limit", "law has no result", "not found"
"""Kinds of the end of a path under loads."""

RULES = "cuts", "repeated", "taken", "count", "by_passes", "jumped"
"""Whole numbers that a run goes on from."""

OF_BRANCH = "step", "least", "count", "cuts"
"""Numbers of a branch that a run goes on from."""


class Follow:
    """Steps along a path whose parameter is `at`, from 0 on.

    conditions: what holds and loads the model at a value of the parameter; it must return the same for the
    same value.  state: of the last step, `before` that of the one before.  report: of the last attempt.
    count: steps.  cuts, repeated: attempts that failed, or left errors or energies too large.  taken:
    iterations of all attempts.  reason: why the path is stopped, or empty; kind: where loads change,
    LIMIT_LOAD, LAW or NOT_FOUND.  mechanism (n d,): how the model moves at a limit load, of the length 1.
    ledger: energies since the start, `start` that of it.  fork: value up to which two ways were seen.

    Under loads short steps end at the first limit load, even where equilibria farther away carry more;
    `beyond` goes on from there.
    """

    def __init__(
        self,
        model: Model,
        state: State,
        conditions: Callable[[float], Conditions],
        step: float,
        most: float | None = None,
        least: float = 1e-5,
        terms: Terms | None = None,
        passes: int = PASSES,
        limit: float = LIMIT,
        errors: tuple[float, float] = ERRORS,
        always: bool = False,
    ) -> None:
        """Begin at 0 with a step, which grows up to `most` and is cut down to `least`.

        passes: most of a step; 0: none.  errors: of a step by passes, of a damage and of forces over those of
        the model, beyond which a shorter one replaces it.  limit: of the error of forces, above which no step
        is taken; a path ends there.  always: all steps by passes.  Where loads change Newton's method ends
        passes, as a limit load must not be passed.  terms: of the equations, without damping; duration, guess
        and passes are those of the steps.
        """
        most = step if most is None else most
        steps, shares = (least, step, most), (limit, *np.ravel(np.asarray(errors, object)))
        good = all(map(real, steps)) and 0.0 < least <= step <= most
        text = f"step = {step}, most = {most}, least = {least}"
        agree("" if good else f"{text}: expected 0 < least <= step <= most")
        good = whole_number(passes, 0) and len(shares) == 3 and all(real(x) and 0.0 < x < 1.0 for x in shares)
        text = f"passes = {passes}, limit = {limit}, errors = {errors}: expected a whole number of passes, "
        agree("" if good else f"{text}limit and 2 errors between 0 and 1")
        agree("always with passes = 0: expected at least 1" if always and not passes else "")
        self.model, self.conditions, self.terms = model, conditions, begun(model, state, terms)
        damping = self.terms.damping
        agree(f"damping = {damping}: expected none on a path, whose ledger has drag alone" if damping else "")
        agree("" if callable(conditions) else f"conditions {conditions!r}: expected a function of a number")
        self.state = self.before = replace(state, at=0.0)
        self.step, self.most, self.least = step, most, least
        self.passes, self.limit, self.errors = passes, limit, (shares[1], min(shares[2], limit))
        self.always, self.by_passes, self.shortest = always, always, min(SHORTEST * least, most)
        self.jumped, self.fork = False, 0.0
        self.cuts, self.repeated, self.taken, self.count, self.reason = 0, 0, 0, 0, ""
        self.kind = ""
        self.branch: Branch | None = None
        self.ledger = ledger_of(model, state, 0.0, 0.0)
        self.start = self.ledger
        self.mechanism: Floats | None = None
        self.report: Report | None = None
        self._load: Floats | None = None

    @property
    def at(self) -> float:
        """Parameter of the last step."""
        return self.state.at

    @property
    def unbalanced(self) -> float:
        """Change of the balance of all energies over the work; that which snaps release is in the ledger."""
        return self.ledger.unbalanced(self.start.balance)

    def to(self, end: float) -> Iterator[Report]:
        """Take steps to a value, and yield the report of each; raises Stopped where the path ends before."""
        while self.at != end:
            if self.advance(end):
                assert self.report
                yield self.report

    def run(self, end: float) -> State:
        """Take steps to a value; raises Stopped where the path ends before."""
        for _ in self.to(end):
            pass
        return self.state

    def run_to_limit(self, end: float) -> State:
        """Take steps up to a limit load; returns the last state before.

        Raises Stopped where the path ends and the tangent shows no limit, and ValueError at the end.
        """
        try:
            self.run(end)
        except Stopped:
            if self.kind == LIMIT_LOAD:
                return self.state
            raise
        raise ValueError(f"end = {end:g}: the path reaches it: expected a value beyond the limit")

    def advance(self, end: float) -> bool:
        """Take one step towards a value, or cut it; whether it was taken.

        At the value itself there is no step to take.  Raises Stopped where the path has ended before.
        """
        agree("" if real(end) else f"end = {end}: expected a finite number")
        if end == self.at:
            return False
        if self.reason:
            raise Stopped(self.reason)
        if self.branch and (end - self.at) * (self.at - self.before.at) < 0.0:
            self.branch = None  # back from a limit load
        if self.branch:
            return self._along(copy(self.branch), end)
        distance = end - self.at
        last = abs(distance) <= self.step * SAME  # no step of rounding errors is left
        move = distance if last else float(np.copysign(self.step, distance))
        at = end if last else self.at + move
        report, under_loads = self._attempt(at, move)
        self.report = report
        if report.state is None:
            self.cuts += 1
            self._cut(move, CUT[under_loads], report.reason, under_loads)
            if self.reason and under_loads:
                self._leave(move)
            return False
        if not under_loads:
            left = self._left(report, at, move)
            if left is None:
                self.fork = at
                self.repeated += 1
                self.step = 0.5 * abs(move)
                return False
            report = self.report = left
        damage, force = report.errors
        excess = max(damage / self.errors[0], force / self.errors[1])
        shortest = abs(move) <= self.shortest * SAME and not under_loads
        if excess > 1.0 and not (shortest and force <= self.limit):
            self.repeated += 1
            text = f"the last pass has an error of {force:.2g} of the forces and {damage:.2g} of a damage"
            self._cut(move, min(0.7, max(0.25, 0.8 / excess)), text, under_loads, self.shortest)
            return False
        moved = report.taken().u - self.state.u
        drag = np.broadcast_to(self.terms.drag, moved.shape)
        ledger = self._ledger_after(report, total(drag @ moved**2) / abs(move))
        half, least = 0.5 * abs(move), self.shortest if self.by_passes else self.least
        chosen = under_loads or self.always or half * SAME < max(FINEST * self.most, least)
        if not chosen and self._unbalanced(ledger):
            self.repeated += 1
            self.step = half
            return False
        released, work = ledger.released - self.ledger.released, ledger.work - self.ledger.work
        missed = ledger.balance - self.ledger.balance - released
        self.jumped = under_loads and abs(missed) > SNAP * abs(work)
        self._take(report, ledger)
        self._grow(excess, report)
        return True

    def _unbalanced(self, ledger: Ledger) -> bool:
        """Whether the path misses too much at the end of a step with this ledger, by what the step misses."""
        old, start = self.ledger, self.start
        size = abs(ledger.strain - start.strain) + max(abs(ledger.work), abs(old.work))
        most, missed = MISSING * size, abs(ledger.balance - start.balance)
        by_step = abs(ledger.balance - old.balance) > FINEST * most
        return by_step and missed > max(most, abs(old.balance - start.balance))

    def _ledger_after(self, report: Report, damped: float = 0.0) -> Ledger:
        """Energies at the state of a report; damped: that of the drag in the step."""
        new = report.taken()
        done = work_of(self.model, self.state, new, (self._loads(), report.load), report.fixed)
        return ledger_after(self.model, self.ledger, new, damped, done)

    def _take(self, report: Report, ledger: Ledger) -> None:
        """Go on from the state of a report, with its energies."""
        self.before, self.state, self._load = self.state, report.taken(), report.load
        self.ledger, self.count = ledger, self.count + 1
        if (self.fork - self.at) * (self.at - self.before.at) <= 0.0:
            self.fork = self.at

    def _leave(self, move: float) -> None:
        """Let the parameter be an unknown, where a shortest step under loads fails; tell where it cannot."""
        if self.report and self.report.reason.startswith("the law"):
            self.kind = LAW
        elif total(np.abs(self.state.s - self.before.s).sum()) == 0.0:
            self.kind = NOT_FOUND
        else:
            self.branch, self.reason, self.step = self._branch(abs(move)), "", abs(move)
            return
        self.reason = self.reason.replace(":", f", {self.kind}:", 1)

    def beyond(self, most: float) -> Branch:
        """Branch from the last step on, where the parameter may fall; most: its largest step.

        Raises ValueError where the separations of the last two states are the same.  Drag has no part in it.
        """
        return self._branch(self.terms.dt, most)

    def _branch(self, dt: float, most: float = float(np.finfo(float).max)) -> Branch:
        """Branch from the last state, with steps of a duration."""
        terms = replace(self.terms, dt=dt, drag=0.0)
        branch = Branch(self.model, self.state, self.before, self.conditions, most, terms, self.ledger)
        branch.start = self.start.balance
        return branch

    def _along(self, branch: Branch, end: float) -> bool:
        """Take one step along a copy of the branch, or tell why the path ends."""
        way, first = float(np.sign(end - self.at)), self.state
        taken = branch.advance()
        report = self.report = branch.report
        if not taken:
            self.branch, self.cuts = branch, self.cuts + 1
            if branch.reason:
                self.kind = LAW if "the law" in branch.reason else NOT_FOUND
                self.reason = branch.reason.replace(":", f", {self.kind}:", 1)
            return False
        assert report
        self.taken += report.iterations
        gained = way * (branch.at - first.at)
        if gained <= FLAT * self.step:
            self._limit(branch.state.u - first.u)
            return False
        goes_on: Branch | None = branch
        if way * (branch.at - end) >= 0.0:
            share = (end - first.at) / (branch.at - first.at)
            report, _ = self._attempt(end, end - first.at, ahead=share * (branch.state.u - first.u), passes=0)
            self.report, goes_on = report, None
            if report.state is None:
                self.branch = None
                self.kind, self.reason = NOT_FOUND, f"stopped at {self.at:.5g}, {NOT_FOUND}: {report.reason}"
                return False
        ledger = self._ledger_after(report)
        self.branch = goes_on
        self._take(report, ledger)
        if self.branch and branch.count + branch.cuts >= LOOK:
            still = gained * branch.size / branch.length
            if still <= LEVEL * abs(self.at):
                self._limit(self.state.u - self.before.u)
            else:
                self.kind = NOT_FOUND
                text = f"the load still grows after {LOOK} attempts, by {still:.2g} while separations double"
                self.reason = f"stopped at {self.at:.5g}, {NOT_FOUND}: {text}"
        return True

    def _limit(self, moved: Floats) -> None:
        """End at a limit load, beyond which the model moves by these displacements (n d,)."""
        m, means = self.model, []
        self.kind, self.mechanism = LIMIT_LOAD, moved / (np.sqrt(totals(moved @ moved)[0]) or 1.0)
        rows = moved.reshape(-1, m.d)
        for name in m.names:
            inside = m.solid(name).reshape(-1, m.d)[:, :1]
            means.append(np.array(totals(*(inside * rows).sum(0))) / (totals(inside.sum())[0] or 1.0))
        k = int(np.argmax(np.linalg.norm(means, axis=1)))
        way = means[k] / (np.abs(means[k]).max() or 1.0)
        text = "the load turns here, and an equilibrium farther away may carry more"
        text += f"; block {m.names[k]} moves most, along {place(way.round(3))}"
        self.reason = f"stopped at {self.at:.5g}, {LIMIT_LOAD}: {text}"

    def _loads(self) -> Floats:
        """Loads at the last step."""
        if self._load is None:
            now = called(self.conditions, self.at)
            water = Water(self.model, now.pressures, now.flows)
            self._load = held(self.model, now).load + water.outer
        return self._load

    def _attempt(self, at: float, move: float, **others: Any) -> tuple[Report, bool]:
        """Solve a step; its report, and whether loads change in it."""
        report, loads, pressed = self._solve(at, move, **others), self._loads(), self.state.p
        taken = report.iterations

        noise = NOISE * self.state.scale * abs(move) / self.most

        def loaded(p: Floats) -> bool:
            forces = np.abs(report.load - loads).sum() + self.model.area @ np.abs(p - pressed)
            return bool(total(forces) > noise)

        under_loads = loaded(report.first) or (report.state is not None and loaded(report.p))  # or by a flow
        under_loads = under_loads or report.reason.startswith(WATER)
        if under_loads and report.state is not None and any(report.errors):
            ways = {"ahead": report.x - self.state.u, "passes": 0, "iterations": self.terms.iterations}
            ended = self._solve(at, move, **ways)
            taken += ended.iterations
            report = replace(ended, passes=report.passes)
        self.taken += taken
        return report, under_loads

    def _left(self, report: Report, at: float, move: float) -> Report | None:
        """Report of a stable equilibrium, that of a report or beside it; the report where none is found.

        None where there are two and a shorter step may show which is the first one.
        """
        if any(report.errors):
            return report
        terms = replace(self.terms, dt=abs(move))
        for _ in range(LEFT):
            ways = beside(report, terms)
            if ways is None:
                return replace(report, stable=True)
            if len(ways) > 1 and 0.5 * abs(move) * SAME >= self.least:
                return None
            for x in ways:
                other = self._solve(at, move, ahead=x - self.state.u, passes=0)
                self.taken += other.iterations
                if other.state is not None:
                    report = other
                    break
            else:
                break
        return replace(report, stable=False)

    def _solve(self, at: float, move: float, **others: Any) -> Report:
        """Solve a step from the last one, whose change goes on; with other terms."""
        old, moved = self.state, self.state.at - self.before.at
        ratio = move / moved if moved * move > 0.0 and not self.jumped else 0.0
        terms = replace(
            self.terms,
            dt=abs(move),
            at=at,
            ahead=ratio * (old.u - self.before.u),
            passes=self.passes if self.by_passes else 0,
            aim=old.s + ratio * (old.s - self.before.s),
            finish=not self.always,
        )
        return solve(self.model, old, called(self.conditions, at), replace(terms, **others))

    def _cut(self, move: float, share: float, message: str, under_loads: bool, shortest: float = 0.0) -> None:
        """Make the next step a share of this one, or let passes take it; end the path where it is too short.

        Where loads change Newton's method alone is tried: beyond a limit load passes fail, too.
        """
        floor = 0.0 if under_loads else shortest
        step = max(share * abs(move), floor)
        # passes would go on along one of two ways
        forked = move * (self.fork - self.at) > 0.0 and step >= self.least
        if under_loads:
            self.by_passes = self.always
        elif self.passes and not self.by_passes and step <= SHORT * self.most and not forked:
            self.by_passes, self.step = True, abs(move)
            return
        self.step = step
        if step < self.least or abs(move) <= floor * SAME:
            self.reason = f"stopped at {self.at:.5g}: {message}"

    def _grow(self, excess: float, report: Report) -> None:
        """Choose the next step and its method."""
        if not self.by_passes:
            if report.iterations <= FAST:
                self.step = min(GROWTH * self.step, self.most)
            return
        growth = min(GROWTH, max(0.7, 0.8 / max(excess, 1e-9)))
        self.step = min(max(growth * self.step, self.shortest), self.most)
        self.by_passes = self.always or excess > ENOUGH

    def save(self, file: str | Path) -> None:
        """Write what a run goes on from, FILE.RANK.npz."""
        states = {"state": self.state, "before": self.before}
        rules = [getattr(self, name) for name in RULES]
        ledger = [*astuple(self.ledger), *astuple(self.start)]
        branch = [getattr(self.branch, name, 0.0) for name in OF_BRANCH]
        write(file, states, step=self.step, fork=self.fork, rules=rules, ledger=ledger, branch=branch)

    def resume(self, file: str | Path) -> None:
        """Go on from the files of a run with the same mesh, laws and ranks; one that ended tries again."""
        sizes = {"rules": len(RULES), "ledger": 2 * len(fields(Ledger)), "branch": len(OF_BRANCH)}
        shapes = {"step": (), "fork": (), **{name: (size,) for name, size in sizes.items()}}
        states, numbers = read(file, self.model, ("state", "before"), **shapes)
        self.ledger, self.start = (Ledger(*row.tolist()) for row in np.split(numbers["ledger"], 2))
        self.state, self.before, self.step = states["state"], states["before"], float(numbers["step"])
        self.fork = float(numbers["fork"])
        for name, value in zip(RULES, numbers["rules"].tolist(), strict=True):
            setattr(self, name, bool(value) if name in ("by_passes", "jumped") else value)
        self.report, self._load, self.reason, self.kind, self.mechanism = None, None, "", "", None
        self.branch = self._branch(self.step) if numbers["branch"].any() else None
        for name, value in zip(OF_BRANCH, numbers["branch"].tolist(), strict=True):
            if self.branch:
                setattr(self.branch, name, value)
