"""Steps along a path: cut where they fail, by passes where short ones fail, too."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from jointed_steps import PASSES, Steps  # isort: skip  # loads MPI
import numpy as np
from asperity.contract import Floats
from jointed_mesh import total
from jointed_saved import read, write

FAST, GROWTH = 6, 1.5
"""A step grows after at most FAST iterations."""

ERRORS = 0.1, 0.01
"""Errors of a step by passes, of a damage and of forces, beyond which a shorter one replaces it."""

LIMIT = 0.05
"""Error of forces of a shortest step beyond which the path ends; no step is short enough for a snap."""

UNDER_LOADS = 1e-3
"""The same of forces where loads change, because a limit load must not be passed."""

CALM, CALM_DAMAGE, CALM_FORCE = 3, 0.02, 0.01
"""Newton's method goes on after CALM steps by passes with errors below these."""

AGAIN = 2, 8
"""Factor of CALM where Newton's method fails again within CALM steps, and the largest product of them."""

SHORT = 0.22
"""Share of the largest step below which a step is short."""

SHORTEST = 10.0
"""Least step by passes over that of Newton's method."""


COUNTS = "cuts", "repeated", "taken", "count", "by_passes", "calm", "patience", "newton"
"""Whole numbers that a run goes on from."""


class Follow:
    """Steps along a path whose parameter is `at`; they are cut where they fail.

    conditions: displacements of the fixed components and loads at a value of the parameter, for which it may
    give pressures of the model, too.  Where a short step by Newton's method fails, steps by passes follow
    (`Steps.solve_by_passes`) until they are calm.
    """

    def __init__(
        self,
        steps: Steps,
        conditions: Callable[[float], tuple[Floats, Floats]],
        step: float,
        most: float,
        least: float = 1e-5,
        passes: int = PASSES,
        limit: float = LIMIT,
        errors: tuple[float, float] = ERRORS,
    ) -> None:
        """Begin at 0 with a step, which grows up to `most` and is cut down to `least`.

        passes: most of a step; 0: none.  errors: of a step by passes, of a damage and of forces over those of
        the model, beyond which a shorter one replaces it; under loads that change the second is UNDER_LOADS
        at most.  limit: of the error of forces, above which no step is taken; a path ends there.
        """
        if not 0.0 < least <= step <= most < np.inf:
            raise ValueError(
                f"step = {step}, most = {most}, least = {least}: expected 0 < least <= step <= most"
            )
        if passes < 0 or not 0.0 < limit < 1.0 or not all(0.0 < error < 1.0 for error in errors):
            text = f"passes = {passes}, limit = {limit}, errors = {errors}"
            raise ValueError(f"{text}: expected at least 0 passes, and limit and errors between 0 and 1")
        self.steps, self.conditions, self.step, self.most, self.least = steps, conditions, step, most, least
        self.passes, self.limit, self.errors = passes, limit, (errors[0], min(errors[1], limit))
        self.shortest = min(SHORTEST * least, most)
        self.at, self.move, self.last = 0.0, 0.0, 0.0 * steps.model.u
        self.jump = [0.0 * s for s in steps.model.s]
        self.by_passes, self.always, self.calm, self.patience, self.newton = False, False, 0, 1, CALM
        self.cuts, self.repeated, self.taken, self.count, self.reason = 0, 0, 0, 0, ""

    def advance(self, end: float) -> bool:
        """Take one step towards a value, or cut it; whether it was taken."""
        m, left = self.steps.model, end - self.at
        last = abs(left) <= self.step * (1.0 + 1e-6)  # no step of rounding errors is left
        move = left if last else float(np.copysign(self.step, left))
        loads = self.conditions(self.at)[1] + m.water.outer
        before, largest, water = (m.u, m.s, m.state), self.steps.largest, m.water.p
        values, load = self.conditions(end if last else self.at + move)

        def loaded() -> bool:
            change = np.abs(load + m.water.outer - loads).sum() + np.abs(m.water.p - water).sum()
            return total(change) > 0.0

        under_loads = loaded()
        if not self._solve(values, load, move):
            self.cuts += 1
            m.water.p = water
            self._cut(move, 0.5, self.steps.message, under_loads)
            return False
        under_loads = under_loads or loaded()  # by a flow
        damage, force = self.steps.errors
        most = self.errors[0], min(self.errors[1], UNDER_LOADS) if under_loads else self.errors[1]
        excess = max(damage / most[0], force / most[1])
        shortest = abs(move) <= self.shortest * (1.0 + 1e-6) and not under_loads
        if excess > 1.0 and not (shortest and force <= self.limit):
            m.u, m.s, m.state = before
            self.steps.largest, m.water.p = largest, water
            self.repeated += 1
            text = f"the last pass has an error of {force:.2g} of the forces and {damage:.2g} of a damage"
            self._cut(move, min(0.7, max(0.25, 0.8 / excess)), text, under_loads, self.shortest)
            return False
        self.last, self.move = m.u - before[0], move
        self.jump = [new - old for new, old in zip(m.s, before[1], strict=True)]
        self.at, self.count = end if last else self.at + move, self.count + 1
        self._grow(excess)
        return True

    def _solve(self, values: Floats, load: Floats, move: float) -> bool:
        """Solve a step from the last one, whose change goes on."""
        m, ratio = self.steps.model, move / self.move if self.move * move > 0.0 else 0.0
        if self.by_passes:
            aim = [s + ratio * jump for s, jump in zip(m.s, self.jump, strict=True)]
            good = self.steps.solve_by_passes(
                values, load, abs(move), aim, ratio * self.last, self.passes, not self.always
            )
        else:
            good = self.steps.solve(values, load, abs(move), ratio * self.last)
        self.taken += self.steps.iterations
        return good

    def _cut(self, move: float, share: float, message: str, under_loads: bool, shortest: float = 0.0) -> None:
        """Make the next step a share of this one; end the path where it is too short already.

        Near a limit load passes may fail where Newton's method does not, which is tried there, too.
        """
        if self.by_passes and under_loads and not self.always:
            self.by_passes, self.step = False, abs(move)
            return
        floor = 0.0 if under_loads else shortest
        self.step = max(share * abs(move), floor)
        if self.step < self.least or abs(move) <= floor * (1.0 + 1e-6):
            self.reason = f"stopped at {self.at:.5g}: {message}"
        again = self.newton < CALM  # steps since the last passes
        if self.passes and not self.by_passes and (again or self.step <= SHORT * self.most):
            self.by_passes, self.calm = True, 0
            self.patience = min(AGAIN[0] * self.patience, AGAIN[1]) if again else 1

    def _grow(self, excess: float) -> None:
        """Choose the next step and its method."""
        if not self.by_passes:
            self.newton += 1
            if self.steps.iterations <= FAST:
                self.step = min(GROWTH * self.step, self.most)
            return
        growth = min(GROWTH, max(0.7, 0.8 / max(excess, 1e-9)))
        self.step = min(max(growth * self.step, self.shortest), self.most)
        damage, force = self.steps.errors
        self.calm = self.calm + 1 if damage < CALM_DAMAGE and force < CALM_FORCE else 0
        self.by_passes, self.newton = self.always or self.calm < self.patience * CALM, 0

    def save(self, file: str | Path) -> None:
        """Write what a run goes on from, FILE.RANK.npz."""
        write(
            file,
            self.steps.model,
            {"jump": self.jump},
            last=self.last,
            now=[self.at, self.move, self.step, self.steps.largest, self.steps.floating],
            counts=[getattr(self, name) for name in COUNTS],
        )

    def resume(self, file: str | Path) -> None:
        """Go on from the files of a run with the same mesh, laws and ranks."""
        m = self.steps.model
        saved = read(file, m, ("jump",), last=m.u.shape, now=(5,), counts=(len(COUNTS),))
        self.last, self.jump = saved["last"], [saved[f"jump{k}"] for k in range(len(self.jump))]
        self.at, self.move, self.step, self.steps.largest, floating = saved["now"].tolist()
        self.steps.floating = bool(floating)
        for name, value in zip(COUNTS, saved["counts"].tolist(), strict=True):
            setattr(self, name, value)
