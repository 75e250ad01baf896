"""Steps in time of a model with mass: base motion, stiffness-proportional damping, a ledger of energies.

    while the time is not the end
        report = solve(state, conditions, with inertia as drag, damping and load)    # Bossak's alpha method
        no state, or a step that gains too much energy: keep the old state; the step becomes half;
                  too short: the run is stopped
        else: take the new state with its velocity and acceleration; the step grows
    at the end the run is stopped where the balance of all energies has risen by too much

A `Shake` holds a state, the ledger of energies, and the numbers of these rules.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, fields, replace
from pathlib import Path

import numpy as np

from ..contract import Floats
from .conditions import Conditions, held
from .equilibrium import Report, Terms, begun, solve
from .ledger import Ledger, ledger_of, opened
from .model import Model
from .ranks import agree, called, doubles, largest, real, total
from .response import respond
from .state import State, read, write
from .stopped import Stopped
from .water import Water

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

NUMBERS = "next", "gained", "_spent", "_start", "_lowest", "_risen", "_size"
"""Numbers that a run goes on from."""


class Shake:
    """Time steps of a model whose base may move, by Bossak's alpha method.

    The joints and the solids act with their forces at the end of a step, as contact needs; the inertia is
    blended.  Displacements, velocities and accelerations are those against the base.  The fixed components
    stay where they are.

    state: of the last step, with its velocity and acceleration.  at: its time.  ledger: energies; a step that
    gains too much of them is cut, and a run whose balance has risen by more than GAIN of those in play stops
    at its end with a reason.  gained: sum of what steps have gained, over the largest energies in play.
    cuts, taken: steps that were cut, and that count.
    """

    def __init__(
        self,
        model: Model,
        state: State,
        conditions: Conditions,
        mass: Floats,
        step: float,
        least: float = 0.0,
        ground: Callable[[float], Floats] | None = None,
        beta: float = 0.0,
        rho: float = RHO,
        terms: Terms | None = None,
    ) -> None:
        """Begin at the time 0 with a state that the conditions hold, and with its velocity.

        conditions: constant ones; the ledger has the work of the loads and of the water.  mass: of the
        components, (n d,), as `np.abs(model.body([density] * d))`.  step: largest step; least: the smallest,
        step/1000 if 0.  ground: acceleration of the base at a time, (d,).  beta: damping of the solids over
        their stiffness, time; damping by mass would brake a slip.  rho: 0 to 1, from strong to no numerical
        damping.  terms: without passes, drag and damping.
        """
        given = begun(model, state, terms)
        for name, value in {"step": step, "least": least, "beta": beta, "rho": rho}.items():
            agree("" if real(value) else f"{name} = {value}: expected a finite number")
        agree("" if ground is None or callable(ground) else f"ground {ground!r}: expected a function of time")
        m, least = model, least or 1e-3 * step
        prescribed = held(m, conditions)
        moved = largest(state.u[prescribed.fixed] - prescribed.values)
        mass = doubles("mass", mass)
        good = mass.shape == state.u.shape and bool(np.isfinite(mass).all()) and bool(np.all(mass > 0.0))
        agree(
            "" if good else f"mass: expected finite numbers above 0 of the shape {state.u.shape}",
            "" if 0.0 < least <= step else f"step = {step}, least = {least}: expected 0 < least <= step",
            "" if beta >= 0.0 else f"beta = {beta}: expected >= 0",
            "" if 0.0 <= rho <= 1.0 else f"rho = {rho}: expected 0 to 1",
            "" if not (given.passes or given.damping or np.any(given.drag))
            else "passes, drag or damping of the terms: expected none, the steps have their own",
            "" if moved <= 1e-9 * largest(state.u)
            else f"values of the fixed components differ from the state by {moved:g}: they stay",
        )  # fmt: skip
        self.model, self.mass, self.ground, self.beta = m, mass.copy(), ground, beta
        self.conditions = replace(conditions, fixed=prescribed.fixed, values=state.u[prescribed.fixed])
        self.water = Water(m, conditions.pressures, conditions.flows)
        self.load, self.terms = prescribed.load, terms or Terms(tolerance=1e-8)
        self.am = (rho - 1.0) / (rho + 1.0)
        self.gamma, self.newmark = 0.5 - self.am, 0.25 * (1.0 - self.am) ** 2
        self.most, self.least, self.next = step, least, step
        self.cuts, self.taken, self.gained, self.reason = 0, 0, 0.0, ""
        self.free = np.ones(state.u.shape)
        self.free[prescribed.fixed] = 0.0
        self.report: Report | None = None
        # the joints at rest, without a rate of their dashpots
        p, _ = self.water.at(state.s)
        t = respond(m, state, state.s, float(np.finfo(float).max ** 0.25), p).t
        forces = m.stiff(state.u) + state.stress + m.pulled(t)
        damping = beta * m.stiff(state.v)
        a = self.free * (self._force(0.0) + self.water.outer - forces - damping) / self.mass
        self.state = replace(state, v=self.free * state.v, a=a, p=p, t=t, forces=forces, at=0.0)
        self._size, self._risen, self._spent = 0.0, 0.0, 0.0
        self.ledger = self._energies(self.state, 0.0, 0.0)
        self._spent = self.ledger.spent
        self._start = self._lowest = self.ledger.balance
        self._size = self._in_play(self.ledger)

    @property
    def at(self) -> float:
        """Time of the last step."""
        return self.state.at

    def _force(self, t: float) -> Floats:
        """Loads and inertia of the base at a time."""
        if self.ground is None:
            return self.load
        m, acceleration = self.model, doubles(f"ground at {t:g}", called(self.ground, t))
        good = acceleration.shape == (m.d,) and bool(np.isfinite(acceleration).all())
        agree(
            "" if good else f"ground at {t:g}: expected {m.d} finite components, not {acceleration.tolist()}"
        )
        return self.load - self.mass * np.tile(acceleration, m.n)

    def _energies(self, state: State, damped: float, work: float) -> Ledger:
        """Energies of a state, with sums since the start."""
        kinetic = 0.5 * total(self.mass @ state.v**2)
        return ledger_of(self.model, state, damped, work, kinetic)

    def _in_play(self, now: Ledger) -> float:
        """Size of the energies that move."""
        spent = now.spent - self._spent
        quiet = QUIET * (abs(now.elastic) + abs(now.stored))
        return max(self._size, now.kinetic, spent + now.damped, abs(now.work), quiet)

    def advance(self, end: float) -> bool:
        """Take one step towards a time, or cut it; whether it was taken.

        At the time itself there is no step to take.  Raises Stopped where the run has ended before.
        """
        self._check(end)
        if end == self.at:
            return False
        if self.reason:
            raise Stopped(self.reason)
        duration = end - self.at
        last = duration <= self.next * (1.0 + 1e-6)
        dt = duration if last else min(self.next, 0.5 * duration)  # no step of a tiny rest
        state, ledger, message = self._solve(end if last else self.at + dt, dt)
        size, gain, risen = self._size, 0.0, 0.0
        if state:
            size = self._in_play(ledger)
            gain, risen = ledger.balance - self.ledger.balance, ledger.balance - self._lowest
            most = ROOM * max(GAIN * size + gain - risen, 0.0) if dt > SHORT * self.most else GAIN * size
            if gain > most:
                state, message = None, f"the step gains {gain:.2g}, the energies in play are {size:.2g}"
        if state is None:
            self.cuts, self.next = self.cuts + 1, 0.5 * dt
            if self.next < self.least:
                self.reason = f"stopped at {self.at:.5g}: {message}"
            return False
        self.state, self.ledger, self.taken = state, ledger, self.taken + 1
        self._size, self.gained = size, self.gained + max(gain, 0.0) / (size or 1.0)
        self._lowest = min(self._lowest, ledger.balance)
        self._risen = max(self._risen, ledger.balance - self._lowest)
        if last and self._risen > GAIN * size:
            text = f"all energies have risen by {self._risen:.2g}, of {size:.2g} in play"
            self.reason = f"ended at {self.at:.5g}, but {text}: expected at most {GAIN:g} of it"
            self.reason += ", try a smaller step"
        if not last and self.report and self.report.iterations <= FAST:
            self.next = min(GROWTH * dt, self.most)
        return True

    def _check(self, end: float) -> None:
        """Refuse an end that is no time from now on."""
        good = real(end) and end >= self.at
        agree("" if good else f"end = {end}: expected a time, {self.at:g} or later")

    def run(self, end: float) -> State:
        """Take steps to a time; raises Stopped where the run ends before, or its energies have risen."""
        self._check(end)
        while self.at < end:
            self.advance(end)
        if self.reason:
            raise Stopped(self.reason)
        return self.state

    def save(self, file: str | Path) -> None:
        """Write what a run goes on from, FILE.RANK.npz."""
        numbers = [getattr(self, name) for name in NUMBERS]
        counts = [self.cuts, self.taken]
        write(file, {"state": self.state}, ledger=astuple(self.ledger), numbers=numbers, counts=counts)

    def resume(self, file: str | Path) -> None:
        """Go on from the files of a run with the same mesh, laws and ranks."""
        shapes = {"ledger": (len(fields(Ledger)),), "numbers": (len(NUMBERS),), "counts": (2,)}
        states, saved = read(file, self.model, ("state",), **shapes)
        self.state, self.ledger = states["state"], Ledger(*saved["ledger"].tolist())
        for name, value in zip(NUMBERS, saved["numbers"].tolist(), strict=True):
            setattr(self, name, value)
        self.cuts, self.taken = saved["counts"].tolist()
        self.reason = ""

    def _solve(self, t: float, dt: float) -> tuple[State | None, Ledger, str]:
        """Find a step; its state, energies, and why there is none."""
        m, b, g, old = self.model, self.newmark, self.gamma, self.state
        u, v, a = old.u, old.v, old.a
        begin, force = self._force(old.at), self._force(t)
        # acceleration at the end = (x - u)/(b dt^2) - before; velocity = rate (x - u) + after
        before, rate = v / (b * dt) + (0.5 / b - 1.0) * a, g / (b * dt)
        after = (1.0 - g / b) * v + dt * (1.0 - 0.5 * g / b) * a
        inertia = self.mass * ((1.0 - self.am) * before - self.am * a)
        load = force + inertia
        if self.beta:
            load = load - self.beta * m.stiff(after)
        terms = replace(
            self.terms,
            dt=dt,
            at=t,
            drag=self.mass * (1.0 - self.am) / (b * dt),
            damping=self.beta * rate,
            ahead=self.free * (dt * v + 0.5 * dt**2 * a),
        )
        report = self.report = solve(m, old, replace(self.conditions, load=load), terms)
        if report.state is None:
            return None, self.ledger, report.reason
        change = report.state.u - u
        new = self.free * (change / (b * dt**2) - before)
        velocity = self.free * (v + dt * ((1.0 - g) * a + g * new))
        state = replace(report.state, v=velocity, a=new)
        mean, damped = change / dt, self.ledger.damped
        if self.beta:
            damped += dt * self.beta * total(mean @ m.stiff(mean))
        work = total((0.5 * (begin + force) + self.water.outer) @ change) + opened(m, old, state)
        return state, self._energies(state, damped, self.ledger.work + work), ""
