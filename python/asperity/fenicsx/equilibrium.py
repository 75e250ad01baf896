"""`solve`: the only function that finds an equilibrium; it changes nothing and returns a report.

p = pressures of the water at the openings of the state
find an equilibrium with p, by Newton's method or by passes
where p depends on openings: change p as water and joints follow each other, and find again until they agree;
    no equilibrium with the new p: half of its change
state = the new one, or None with a reason
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..contract import Floats
from ..mesh.shapes import Integers
from .conditions import Conditions, held
from .coupling import Followed
from .measures import Measures, measure
from .model import Model
from .newton import SOFT, Task, newton, share
from .passes import PASSES, Passed, by_passes
from .ranks import agree, doubles, expect, largest, real, total, whole_number
from .response import Clock, LawError, respond
from .state import State, frozen
from .tangent import equations_of, words_of
from .water import WATER, Water, WaterError

SAME_WATER, MOST_WATER = 1e-6, 60
"""Error of a pressure that depends on openings over the largest one, and most equilibria of a step."""

HALVES = 4
"""How often a change of such a pressure is halved where no equilibrium follows it."""

SEARCHES = "root", "residual", "none"
"""How far along a step: to the root of its work, until the Euclidean residual falls, all of it."""


@dataclass(frozen=True)
class Terms:
    """What the equations have beside joints and solids, and how they are solved.

    dt: duration of the step.  drag (n d,): forces over displacements in a step of the time 1.  damping: share
    of the stiffness of the solids that resists the displacements of the step.  tolerance: of the residual
    over the prescribed forces, loads or pressures; all are sums of magnitudes, so that the same tolerance
    holds in a mesh of any size.  ahead: guess of the change of the displacements; openings (p, 3): guess of
    the separations that water follows, default those of the state.  at: of the new state; default: that of
    the old one.
    passes: most of them; 0: Newton's method.  aim (p, 3): separations of the first pass, default those of the
    state; finish: whether Newton's method ends the passes where it can.
    iterations: most of a solution.  search: see SEARCHES.  options: of PETSc, for the linear equations.
    """

    dt: float = 1.0
    drag: ArrayLike = 0.0
    damping: float = 0.0
    tolerance: float = 1e-6
    ahead: ArrayLike = 0.0
    openings: Floats | None = None
    at: float | None = None
    passes: int = 0
    aim: Floats | None = None
    finish: bool = True
    iterations: int = 20
    search: str = "root"
    options: str = ""


@dataclass(frozen=True)
class Report:
    """What `solve` found: a new state, or None with the reason; its arrays are read-only.

    residual: sum of its magnitudes over `size`, the forces; also after passes that of the law itself.
    floor: what of it rounding errors of the displacements may cause; where it is above the tolerance, a
    residual below it counts.
    errors: of a solution by passes, largest of a damage and of forces over those of the model; 0 where
    Newton's method ends it.  equilibria: more than one where pressures depend on openings.  reaction (n d,):
    internal forces less loads, those of the fixed components.  x (n d,): last displacements, also where there
    is no state.  load (n d,): with the pressures on faces.  fixed: components, sorted.  first, p (p,):
    pressures in the joints at the openings before, and the last ones.  rates: inflows of each flow by group.
    linear, factored: iterations and factorizations of the linear equations; law: processor seconds in the
    law.  factor: entries, operations and GB of the last factor.  between: the model, and the state before.
    stable: whether the model stays there by itself, as a path finds in steps without changing loads; None
    where that is not judged: under such loads, by passes, outside paths.
    """

    state: State | None
    reason: str
    residual: float
    size: float
    floor: float
    iterations: int
    passes: int
    errors: tuple[float, float]
    equilibria: int
    reaction: Floats
    x: Floats
    load: Floats
    fixed: Integers
    first: Floats
    p: Floats
    rates: tuple[Mapping[str, float], ...] = ()
    linear: int = 0
    factored: int = 0
    law: float = 0.0
    factor: tuple[float, float, float] = field(default=(0.0, 0.0, 0.0))
    between: tuple[Model, State] | None = None
    stable: bool | None = None

    def __post_init__(self) -> None:
        """Make the arrays read-only: a path goes on from them."""
        for name in ("reaction", "x", "load", "first", "p"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        object.__setattr__(self, "fixed", frozen(self.fixed, np.int64))

    @property
    def measures(self) -> dict[str, Measures]:
        """Measures of each joint in the new state, by its name; all ranks must ask. Empty without a state."""
        if self.state is None or self.between is None:
            return {}
        model, old = self.between
        return {name: measure(model, name, self.state, old) for name in model.joints}

    @property
    def good(self) -> bool:
        """Whether there is a new state."""
        return self.state is not None

    def taken(self) -> State:
        """Return the new state; raises RuntimeError with the reason where there is none."""
        if self.state is None:
            raise RuntimeError(f"no equilibrium: {self.reason}")
        return self.state


def _check(model: Model, terms: Terms) -> tuple[Floats, Floats]:
    """Drag and guess by component; raises ValueError that names what is wrong."""
    size = model.n * model.d
    expect(str, options=terms.options)
    words_of(terms.options)
    drag, ahead = doubles("drag", terms.drag), doubles("ahead", terms.ahead)
    tolerance = terms.tolerance
    checks = {
        f"dt = {terms.dt}: expected above 0": real(terms.dt) and terms.dt > 0.0,
        f"damping = {terms.damping}: expected at least 0": real(terms.damping) and terms.damping >= 0.0,
        f"tolerance = {tolerance}: expected between 0 and 1": real(tolerance) and 0.0 < tolerance < 1.0,
        f"passes = {terms.passes}: expected a whole number of at least 0": whole_number(terms.passes, 0),
        f"iterations = {terms.iterations}: expected a whole number of at least 1": whole_number(
            terms.iterations, 1
        ),
        f"search = {terms.search!r}: expected one of {', '.join(SEARCHES)}": terms.search in SEARCHES,
        f"at = {terms.at}: expected a finite number": terms.at is None or real(terms.at),
    }
    for name, values in (("drag", drag), ("ahead", ahead)):
        checks[f"{name} of the shape {values.shape}: expected one or {(size,)}"] = values.shape in (
            (),
            (size,),
        )
        checks[f"{name}: expected finite numbers"] = bool(np.isfinite(values).all())
    for name, given in (("openings", terms.openings), ("aim", terms.aim)):
        if given is not None:
            values = doubles(name, given)
            shape = len(model.pairs), 3
            text = f"{name} of the shape {values.shape}: expected finite numbers of the shape {shape}"
            checks[text] = values.shape == shape and bool(np.isfinite(values).all())
    checks["drag: expected at least 0"] = bool((drag >= 0.0).all())
    agree(next((text for text, good in checks.items() if not good), ""))
    return np.broadcast_to(drag, size), np.broadcast_to(ahead, size)


def begun(model: Model, state: State, terms: Terms | None) -> Terms:
    """Terms, or those without drag; raises ValueError on all ranks unless the state is of the model."""
    terms = Terms() if terms is None else terms
    expect(Model, model=model)
    expect(State, state=state)
    expect(Terms, terms=terms)
    state.check(model)
    return terms


def solve(model: Model, state: State, conditions: Conditions, terms: Terms | None = None) -> Report:
    """Find the equilibrium that follows a state under conditions; model and state stay as they are.

    A pressure of openings that is negative there, or that its function refuses, is a reason of the report.
    Raises ValueError on all ranks for wrong input, by its name.
    """
    terms = begun(model, state, terms)
    drag, ahead = _check(model, terms)
    prescribed, clock = held(model, conditions), Clock()
    if not total(len(prescribed.fixed)) and not total(drag.sum()):
        raise ValueError("nothing is fixed and there is no drag: expected components that hold the model")
    water = Water(model, conditions.pressures, conditions.flows)
    load = prescribed.load + water.outer
    q = equations_of(model, prescribed.fixed, terms.options)
    first, reason = state.p, ""
    rates: tuple[dict[str, float], ...] = ()
    try:
        first, rates = water.at(state.s)
        p = first if terms.openings is None else water.at(terms.openings)[0]
    except WaterError as error:
        p, reason = first, f"{WATER}: {error}"
    x, balanced, spent = state.u + ahead, p, np.zeros(3, int)
    equilibria, halved, left = 0, 0, 0.0
    done: Passed | None = None
    while not reason:
        if equilibria == MOST_WATER:
            reason = f"the pressure of water still changes by {left:.2g} after {MOST_WATER} equilibria"
            break
        equilibria += 1
        task = Task(prescribed.values, load, p, terms.dt, drag, terms.damping, terms.tolerance, terms.search)
        try:
            if terms.passes:
                aim = state.s if terms.aim is None else terms.aim
                done = by_passes(q, state, task, x, aim, terms.passes, terms.finish, terms.iterations, clock)
            else:
                found = newton(q, state, task, x, terms.iterations, state.floating, None, clock)
                done = Passed(found, 0, (0.0, 0.0), found.share)
        except LawError as error:
            reason = f"the law: {error}"
            break
        found = done.found
        spent += found.iterations, found.linear, found.factored
        convex, refused, followed = any(done.errors), "", None
        try:
            if found.good and water.moves:
                wanted, rates = water.at(found.s)
                left = largest(wanted - p)
                if left > SAME_WATER * largest(p):
                    followed = Followed(q, water, found.s, convex)
        except WaterError as error:
            refused = f"{WATER}: {error}"
        if not (found.good and not refused) and equilibria > 1 and halved < HALVES:
            p, halved = 0.5 * (p + balanced), halved + 1  # with less of the change there may be one
            continue
        x, balanced, reason = found.x, p, refused or found.reason
        if reason or not followed:
            break
        r = found.response
        assert r
        q.assemble(r.D, drag / terms.dt, terms.damping, SOFT if convex or found.floating else 0.0, convex)
        spent[2] += 1
        p = np.maximum(p + followed.change(wanted - p), 0.0)
    nothing = np.zeros(model.n * model.d)
    new: State | None = None
    if not reason and done and done.found.response:
        found, t = done.found, done.found.response.t
        # iterates have no dissipated energies
        joints = respond(model, state, found.s, terms.dt, p, clock=clock).joints
        new = State(
            found.x, found.s, t, joints, p, found.balance.reaction + load, state.stress, nothing, nothing,
            max(state.scale, found.balance.size), state.floating or found.floating,
            state.at if terms.at is None else terms.at,
        )  # fmt: skip
    iterations, linear, factored = spent.tolist()
    return Report(
        new,
        reason,
        done.residual if done else np.nan,
        done.found.balance.size if done else np.nan,
        share(done.found.balance.floor, done.found.balance.size) if done else np.nan,
        iterations,
        done.passes if done else 0,
        done.errors if done else (0.0, 0.0),
        equilibria,
        done.found.balance.reaction if done else nothing,
        x,
        load,
        prescribed.fixed,
        first,
        p,
        rates,
        linear,
        factored,
        clock.seconds,
        q.factor(),
        (model, state),
    )


__all__ = ["PASSES", "Report", "Terms", "begun", "solve"]
