"""An equilibrium by passes: convex problems, each of which has a solution, until they are those of the law.

    aim = separations that are guessed
    for each pass
        x = equilibrium with damage, friction bounds and slopes of the law at aim; contact is free
        errors = those of the damage at aim, and of the forces of the law at x
        end where both are small
        aim = separations at x
        where the errors are close, go on once by a few iterations of Newton's method

Where the passes converge, the equilibrium is that of the law.  Else its errors say what is left of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..contract import Floats
from .newton import Found, Task, newton, share
from .ranks import largest, total
from .response import Clock, damages, respond
from .state import State
from .tangent import Equations

PASSES = 60
"""Most passes of a step: each costs an equilibrium, but steps that end early are short, and then many.

Of 12 snaps of a bar and 3 peeled beams paths with 8, 24, 40 and 60 cross 6, 11, 14 and 15.  Two walls that
snap take 1577 and 1037 factorizations with 8 passes, which leave errors in 12 steps; 1126 and 1030 with 60.
"""

SAME_DAMAGE = 1e-3
"""Error of a damage, which lies between 0 and 1, below which no further pass is made."""

SAME_FORCE = 1e-4
"""Error of the forces, over those of the model, below which no further pass is made."""

CLOSE_DAMAGE = 0.05
"""Error of a damage below which Newton's method goes on from the solution of a pass."""

CLOSE_FORCE = 0.003
"""Error of the forces, over those of the model, below which Newton's method goes on from a pass."""

FINISH = 6
"""Most iterations of Newton's method from a pass that is close; where they fail, another pass follows."""


@dataclass(frozen=True)
class Passed:
    """The last equilibrium found, passes, errors of a damage and of forces over those of the model.

    residual: of the law itself, over the forces, as the tolerance.
    """

    found: Found
    passes: int
    errors: tuple[float, float]
    residual: float


def by_passes(
    equations: Equations,
    start: State,
    task: Task,
    x: Floats,
    aim: Floats,
    most: int,
    finish: bool,
    iterations: int,
    clock: Clock,
) -> Passed:
    """Find an equilibrium by at most so many passes from x and separations (p, 3) of the first aim.

    finish: whether Newton's method, whose tangent is not symmetric, is tried once from a pass that is close.
    """
    spent, passes, errors, untried, floating = np.zeros(3, int), 0, (0.0, 0.0), finish, start.floating
    at = aim
    while True:
        passes += 1
        found = newton(equations, start, task, x, iterations, floating, at, clock)
        spent += found.iterations, found.linear, found.factored
        residual = found.share
        if not found.good:
            break
        floating = floating or found.floating
        damage, force, unbalanced = _errors(equations, start, task, found, at, clock)
        size = found.balance.size
        errors, residual = (damage, share(force, size)), share(unbalanced, size)
        if (damage < SAME_DAMAGE and errors[1] < SAME_FORCE) or passes == most:
            break
        x, at = found.x, found.s
        if untried and damage < CLOSE_DAMAGE and errors[1] < CLOSE_FORCE:
            untried = False  # another pass follows where it fails
            done = newton(equations, start, task, x, min(FINISH, iterations), floating, None, clock)
            spent += done.iterations, done.linear, done.factored
            if done.good:
                found, errors, residual = done, (0.0, 0.0), done.share
                break
    numbers = dict(zip(("iterations", "linear", "factored"), spent.tolist(), strict=True))
    return Passed(replace(found, **numbers), passes, errors, residual)


def _errors(
    equations: Equations, start: State, task: Task, found: Found, aim: Floats, clock: Clock
) -> tuple[float, float, float]:
    """Errors of a pass by its aim: largest of a damage, sum of those of forces, residual of the law."""
    m = equations.model
    assert found.response
    taken, true = (respond(m, start, s, task.dt, task.p, None, clock, True) for s in (aim, found.s))
    damage = largest(damages(m, true.joints) - damages(m, taken.joints))
    force = float(m.area @ np.linalg.norm(true.t - found.response.t, axis=1))
    full = (found.balance.full + m.pulled(true.t - found.response.t)) * equations.free
    return damage, total(force), total(np.abs(full).sum())
