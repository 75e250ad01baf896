"""Newton's method for given pressures, whose line search looks at the separations of the joints alone.

Residual, free components:  r(x) = K x + damping K (x - u) + drag (x - u)/dt + stress + B' A t(B x) - load
with the displacements u at the start, separations B x and areas A of the points, tractions t of the law.

    x = u + ahead, with the prescribed values
    until |r| <= tolerance * forces                      # sums of magnitudes
        dx = - tangent^-1 r                              # the tangent has those of the points at x
        if dx . r(x + dx) has another sign than dx . r(x), a = root of dx . r(x + a dx), else a = 1
        x = x + a dx, unless the residual is thrown far off: the tangent is softened and dx found again
        end where the residual has not fallen for long, or after the most iterations

K dx and B dx are computed once, so that dx . r(x + a dx) costs a call of the law and a scalar product.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contract import Floats
from .ranks import totals
from .response import Clock, LawError, Response, respond
from .state import State
from .tangent import Equations

SMALLEST_SHARE = 1e-3
"""Share of the largest forces of the steps before below which forces count as this share."""

SOFT = 1e-8
"""Share of the stiffness of the solids that the tangent has more where blocks may float: always in passes.

It is that of each component: a share of the largest one would slow down what stands on a stiff foundation.
"""

SINGULAR = 1e3
"""Residual over the forces, or over the first one, beyond which the tangent was singular.

The iteration is then taken again with a softened one: from a block that flew off there is no way back.
"""

ROUNDING, COARSEST, FINEST = float(np.finfo(float).eps), 1e-4, 1e-6
"""Rounding errors of displacements over these, and the largest share of the forces that they may cause.

A residual below what they cause by the stiffness of the solids counts as none, though the tolerance is finer:
no iteration makes it smaller. It is .49 to .57 of that in a dam of 3e12 to 3e17 Pa up to its overturning.
The forces along rigid motions that nothing holds, in which solids have no part, must be below the tolerance,
or below FINEST, too.
"""

PATIENT_BELOW = 100.0
"""Residual over the largest one that counts as none below which no attempt is given up early."""

FIRST_JUDGED = 10
"""Iteration from which on an attempt ends early whose last iterations did not lower the residual.

With this number and the three below, two walls up to their ends lose none of 136 attempts that find an
equilibrium, and save a third of the iterations of those that do not.
"""

WINDOW = 5
"""Last iterations whose least residual is compared with those before them: a single one may rise."""

FALL_OF_LEAST = 0.9
"""Least residual of the window over the least one before it, up to which the residual has fallen."""

FALL_OF_LAST = 0.2
"""Least residual of the window over the one just before it, up to which the residual has fallen.

An attempt whose residual has risen far and falls again has not yet come below its least one.
"""

ROOT = 1e-2
"""Work of the residual along a step, over that at its start, that counts as none in a line search.

The next iteration corrects what is left of it, and a better root costs further calls of the law.
"""

MOST_ROOT = 25
"""Most calls of the law in which a line search looks for its root, or halves the step."""

BRACKET = 1e-12
"""Width of the bracket of a root, over the step, below which the search ends, as where the law jumps."""

LAST_SECANT = 8
"""Number, from 0 on, of the last call for which a line search takes a secant.

The 16 calls after it halve the bracket, which they narrow also where secants stay on one side.
"""


@dataclass(frozen=True)
class Task:
    """What an equilibrium is asked for; values of the fixed components, load and pressures of the points."""

    values: Floats
    load: Floats
    p: Floats
    dt: float
    drag: Floats
    damping: float
    tolerance: float
    search: str


@dataclass(frozen=True)
class Balance:
    """Forces at displacements.

    reaction: internal forces less loads; full: the residual.  residual, size: sums of the magnitudes of the
    residual and of the forces.  floor: what rounding errors of the displacements cause of the first.  enough:
    residual that counts as none.
    """

    reaction: Floats
    full: Floats
    residual: float
    size: float
    floor: float
    enough: float


@dataclass(frozen=True)
class Found:
    """Where the iterations end, `good` as equilibrium.

    balance: of the forces at x.  response: that of an iterate, without dissipated energies.
    """

    good: bool
    x: Floats
    s: Floats
    response: Response | None
    balance: Balance
    iterations: int
    linear: int
    factored: int
    floating: bool
    reason: str

    @property
    def share(self) -> float:
        """Residual over the forces."""
        return share(self.balance.residual, self.balance.size)


def share(residual: float, size: float) -> float:
    """Residual over the forces; 0 where there is nothing at all."""
    if size == 0.0:
        return 0.0 if residual == 0.0 else np.inf
    return residual / size


def balance_of(q: Equations, start: State, task: Task, x: Floats, t: Floats) -> Balance:
    """Balance of the forces at displacements x (n d,) with total tractions t (p, 3)."""
    m, moved = q.model, x - start.u
    reaction = m.bodies.balanced(m.stiff(x)) + start.stress + m.pulled(t) - task.load
    if task.damping:
        reaction += task.damping * m.stiff(moved)
    full = (reaction + task.drag / task.dt * moved) * q.free
    parts = np.abs(full).sum(), np.abs(reaction[q.fixed]).sum(), m.diagonal @ np.abs(x)
    residual, reactions, solids, *loads = totals(*parts, np.abs(task.load).sum(), m.area @ task.p)
    size, floor = max(reactions, *loads, SMALLEST_SHARE * start.scale), ROUNDING * solids
    enough = task.tolerance * size
    if enough < residual <= min(floor, COARSEST * size):
        outer = m.pulled(t) - task.load + task.drag / task.dt * moved
        if m.bodies.loose(outer, q.fixed) <= max(enough, FINEST * size):
            enough = floor
    return Balance(reaction, full, residual, size, floor, enough)


def newton(
    equations: Equations,
    start: State,
    task: Task,
    x: Floats,
    most: int,
    floating: bool = False,
    aim: Floats | None = None,
    clock: Clock | None = None,
) -> Found:
    """Find displacements that balance the forces from x, (n d,), in at most so many iterations.

    aim: separations by whose damage, friction bounds and slopes the problem is convex.  floating: whether the
    tangent is softened from the start.
    """
    q, m = equations, equations.model
    x = x.copy()
    x[q.fixed] = task.values
    s = m.separations(x)
    drag = task.drag / task.dt
    linear, factored, first = 0, 0, 0.0
    response: Response | None = None
    residuals: list[float] = []
    now = Balance(0.0 * x, 0.0 * x, np.nan, np.nan, np.nan, 0.0)

    def at(s: Floats) -> Response:
        return respond(m, start, s, task.dt, task.p, aim, clock, iterate=True)

    def balance(new: Response | None) -> None:
        nonlocal response, now
        assert new
        response, now = new, balance_of(q, start, task, x, new.t)

    def found(good: bool, reason: str = "") -> Found:
        return Found(
            good, x, s, response, now, max(len(residuals) - 1, 0), linear, factored, floating, reason
        )

    try:
        balance(at(s))
        before = x, s, response
        for iteration in range(most + 1):
            if iteration and now.residual <= now.enough:
                # what belongs to x itself counts: separations that went far and back have rounding errors
                s = m.separations(x)
                balance(at(s))
            residuals.append(now.residual)
            if not np.isfinite(now.residual):
                return found(False, "the residual is not finite")
            if now.residual <= now.enough:
                return found(True)
            if iteration == 0:
                first = now.residual
            elif now.residual > SINGULAR * max(first, now.size) and not floating:
                floating, (x, s, response) = True, before
                balance(response)
                residuals[-1] = now.residual
            if iteration == most or hopeless(residuals, now.enough):
                text = f"the residual is {share(now.residual, now.size):.2g} of the forces"
                text += f" after {iteration} iterations: expected at most {share(now.enough, now.size):.2g}"
                if now.floor > now.enough:
                    text += f", rounding errors alone cause {share(now.floor, now.size):.2g}"
                return found(False, text)
            convex = aim is not None
            assert response
            softened = SOFT if convex or floating else 0.0
            q.assemble(response.D, task.drag / task.dt, task.damping, softened, convex)
            dx, inner, count = q.step(now.full, convex, iteration == 0)
            linear, factored = linear + inner, factored + count
            if dx is None or not np.isfinite(totals(float(np.abs(dx).sum()))[0]):
                if floating or convex:
                    return found(False, "the tangent has no solution")
                floating = True
                q.assemble(response.D, task.drag / task.dt, task.damping, SOFT, convex)
                dx, inner, count = q.step(now.full, convex, True)
                linear, factored = linear + inner, factored + count
                if dx is None:
                    return found(False, "the tangent has no solution")
            before = x, s, response
            ds, dlines = m.separations(dx), (1.0 + task.damping) * m.stiff(dx) + drag * dx
            a, new = _searched(q, task, response, s, now.full, dx, ds, dlines, at)
            x, s = x + a * dx, s + a * ds
            balance(new)
        raise AssertionError("the loop ends by a return")
    except LawError as error:
        return found(False, f"the law: {error}")


def hopeless(residuals: list[float], enough: float) -> bool:
    """Whether the residuals say that more iterations will not end at one that is small enough."""
    if len(residuals) <= FIRST_JUDGED:
        return False
    now, before = min(residuals[-WINDOW:]), residuals[:-WINDOW]
    fallen = now <= FALL_OF_LEAST * min(before) or now <= FALL_OF_LAST * before[-1]
    return not fallen and now > PATIENT_BELOW * enough


def _searched(
    q: Equations,
    task: Task,
    old: Response,
    s: Floats,
    full: Floats,
    dx: Floats,
    ds: Floats,
    dlines: Floats,
    at: Any,
) -> tuple[float, Response]:
    """Length of a step and the response there."""
    m = q.model
    weights = (m.area[:, None] * ds).ravel()
    start, slope = totals(dx @ full, dx @ dlines)

    def work(a: float, new: Response) -> float:
        return start + a * slope + totals(weights @ (new.t - old.t).ravel())[0]

    a, new = 1.0, at(s + ds)
    if task.search == "none":
        return a, new
    if task.search == "residual":
        before = float(np.sqrt(totals(full @ full)[0]))
        for _ in range(MOST_ROOT):
            change = (a * dlines + m.pulled(new.t - old.t)) * q.free
            if np.sqrt(totals((full + change) @ (full + change))[0]) <= (1.0 - 1e-4 * a) * before:
                break
            a *= 0.5
            new = at(s + a * ds)
        return a, new
    f = work(a, new)
    if f * start >= 0.0:
        return a, new
    low, at_low, high, at_high, side = 0.0, start, a, f, 0
    for k in range(MOST_ROOT):
        if abs(f) <= ROOT * abs(start) or high - low < BRACKET:
            break
        a = (low * at_high - high * at_low) / (at_high - at_low)
        if not low < a < high or k > LAST_SECANT:
            a = 0.5 * (low + high)
        new = at(s + a * ds)
        f = work(a, new)
        # the method of Illinois: a side that stays counts half
        if f * start > 0.0:
            low, at_low, at_high, side = a, f, at_high * (0.5 if side == 1 else 1.0), 1
        else:
            high, at_high, at_low, side = a, f, at_low * (0.5 if side == -1 else 1.0), -1
    return a, new
