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

import itertools
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from petsc4py import PETSc
from scipy.sparse import csr_array

from ..contract import Floats
from ..mesh.shapes import Integers
from .model import INT, Model
from .ranks import COMM, total, totals
from .response import Clock, LawError, Response, respond
from .state import State

NUMBERS = itertools.count(1)
"""Of the solvers, in the prefix of their options: PETSc keeps these for all solvers of a prefix."""

DIRECT = (
    "-ksp_type preonly -pc_type lu -pc_factor_mat_solver_type mumps -mat_mumps_icntl_6 0 -mat_mumps_icntl_8 0"
)
"""Options of PETSc for the linear equations; others replace them.

MUMPS neither permutes nor scales: the entries of a tangent differ by 1e8 at most, and the order of the
elimination is then that of the pattern alone, whatever was factored before.
"""

MULTIGRID = (
    "-ksp_type fgmres -ksp_rtol 1e-7 -ksp_gmres_restart 200 -ksp_max_it 1000 "
    "-pc_gamg_threshold 0.02 -mg_levels_ksp_type chebyshev -mg_levels_ksp_max_it 1 -mg_levels_pc_type sor"
)
"""More of them for `-pc_type gamg`, a symmetric preconditioner, as conjugate gradients need it.

The threshold keeps open joints, whose stiffness is zero, from joining blocks on the coarse levels.  GMRES
would judge the preconditioned residual, which falls long before that of the equations.
"""

STALE, STALE_RTOL = 4, 1e-3
"""Iterations of GMRES with the factor of an iteration before, in space, and by how much they reduce."""

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
The forces on each loose body, in which the solids have no part, must be below the tolerance or FINEST, too.
"""

PATIENT_BELOW = 100.0
"""Residual over the largest one that counts as none below which no attempt is given up early."""

HOPELESS = 10, 5, 0.9, 0.2
"""From which iteration on an attempt ends whose last ones did not lower the residual.

How many last ones; share of the least residual before them, and of the one before them, that is no fall.
In two walls up to their ends this ends none of 136 attempts that find an equilibrium, and saves a third of
the iterations of those that do not.
"""

ROOT, MOST_ROOT, BRACKET, BISECT = 1e-2, 25, 1e-12, 8
"""The root of a search: its value over that at the start, most calls, least bracket, calls before halves."""


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

    balance: of the forces at x.
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


class Equations:
    """The tangent of a model whose components `fixed` are prescribed, and the solvers of it."""

    def __init__(self, model: Model, fixed: Integers, options: str) -> None:
        """Lay out the matrix: entries of the solids, of the joints and of the diagonal, by one list."""
        self.model, self.fixed = model, fixed
        m, d = model, model.d
        self.free = np.ones(m.n * d)
        self.free[fixed] = 0.0
        first = m.map.local_range[0] * d
        solids = m.K.copy()
        solids.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        # columns of the fixed components meet zeros, because the iterates have the prescribed values
        solids.zeroRowsColumns((fixed + first).astype(INT), diag=0.0)
        pointers, columns, values = solids.getValuesCSR()
        solids.destroy()
        kept = values != 0.0
        rows = np.repeat(np.arange(m.n * d), np.diff(pointers))[kept] + first
        self._of_solids = values[kept]
        # joints: d x d of a point are a product with its 9 tangents, and stand in four places
        count = len(m.pairs)
        point = np.arange(count).reshape(-1, 1, 1, 1, 1)
        i, j = np.arange(d).reshape(1, -1, 1, 1, 1), np.arange(d).reshape(1, 1, -1, 1, 1)
        k, other = np.arange(3).reshape(1, 1, 1, -1, 1), np.arange(3)
        entry = m.area[point] * m.axes[point, k, i] * m.axes[point, other, j]
        at = np.flatnonzero(entry)
        shape = np.broadcast_shapes(entry.shape)
        p, a, b, e, f = np.unravel_index(at, shape)
        places = (p * d + a) * d + b, 9 * p + 3 * e + f
        self._of_points = csr_array((entry.ravel()[at], places), shape=(count * d * d, 9 * count))
        free = m.spread(self.free)
        here = np.arange(m.n + m.map.num_ghosts, dtype=np.int32)
        numbers = (m.map.local_to_global(here).astype(np.int64)[:, None] * d + np.arange(d)).ravel()
        side, other, point, i, j = (x.ravel() for x in np.indices((2, 2, count, d, d)))
        row, column = m.pairs[point, side] * d + i, m.pairs[point, other] * d + j
        kept_joints = (free[row] * free[column] > 0.0) & (m.area[point] > 0.0)
        row, column, side, other = (
            row[kept_joints],
            column[kept_joints],
            side[kept_joints],
            other[kept_joints],
        )
        self._take = ((point * d + i) * d + j)[kept_joints]
        self._sign = np.where(side == other, 1.0, -1.0)
        diagonal = np.arange(m.n * d) + first
        all_rows = np.concatenate([rows, numbers[row], diagonal]).astype(INT)
        all_columns = np.concatenate([columns[kept], numbers[column], diagonal]).astype(INT)
        self.A = PETSc.Mat().create(COMM)
        self.A.setSizes(m.K.getSizes(), d)
        self.A.setType(PETSc.Mat.Type.AIJ)
        self.A.setPreallocationCOO(all_rows, all_columns)
        self.b, self.y = self.A.createVecs()
        self.A.setNearNullSpace(self._rigid())
        self.options = options
        self.solvers: dict[bool, Solver] = {}
        self.last: Solver | None = None

    def _rigid(self) -> PETSc.NullSpace:
        """Rigid motions, for algebraic multigrid."""
        x = self.b.duplicate()
        x.setBlockSize(self.model.d)
        x.array[:] = self.model.x.ravel()
        return PETSc.NullSpace().createRigidBody(x)

    def assemble(self, D: Floats, task: Task, soft: float, symmetric: bool) -> None:
        """Set the tangent to that with the tangents D (p, 3, 3) of the points."""
        m = self.model
        joints = np.asarray(self._of_points @ D.ravel())[self._take] * self._sign
        diagonal = np.where(self.free > 0.0, task.drag / task.dt + soft * m.diagonal, m.scale)
        # entries of another kind may follow
        self.A.setOption(PETSc.Mat.Option.SYMMETRIC, symmetric)
        values = np.concatenate([(1.0 + task.damping) * self._of_solids, joints, diagonal])
        self.A.setValuesCOO(values, PETSc.InsertMode.INSERT_VALUES)

    def step(self, r: Floats, symmetric: bool, fresh: bool) -> tuple[Floats | None, int, int]:
        """Solve for the step against a residual; with the numbers of iterations and of factorizations.

        The step is None where there is no solution.
        """
        if symmetric not in self.solvers:
            self.solvers[symmetric] = Solver(self.A, self.model.d, self.options, symmetric)
        solver = self.last = self.solvers[symmetric]
        self.b.array[:] = -r
        try:
            iterations, factored, good = solver.solve(self.b, self.y, fresh)
        except (PETSc.Error, ValueError):
            self.solvers.pop(symmetric).destroy()
            self.last = None
            raise
        dx: Floats = self.y.array_r.copy()
        return (dx if good else None), iterations, factored

    def factor(self) -> tuple[float, float, float]:
        """Entries of the last factor by MUMPS, operations of its elimination and GB; 0 by other solvers."""
        return self.last.factor() if self.last else (0.0, 0.0, 0.0)

    def destroy(self) -> None:
        """Release the factors, which Python's garbage collector does not reach."""
        for solver in self.solvers.values():
            solver.destroy()
        self.solvers.clear()
        self.last = None
        self.A.destroy()


class Solver:
    """Linear equations with the tangent of one kind: symmetric in passes, of the law in Newton's method."""

    def __init__(self, A: PETSc.Mat, d: int, options: str, symmetric: bool) -> None:
        """Choose Cholesky for LU and conjugate gradients for FGMRES where the tangent is symmetric."""
        chosen, database = words_of(options), PETSc.Options()
        multigrid = chosen.get("pc_type") == "gamg"
        database.setValue("options_left", 0)
        prefix = f"asperity_{next(NUMBERS)}_"
        settings = words_of(DIRECT) | (words_of(MULTIGRID) if multigrid else {}) | chosen
        self.names, self.chosen = [prefix + name for name in settings], options
        # those of the levels of multigrid are read where a mesh has these levels
        self.unread = [name for name in chosen if not name.startswith("mg_")]
        self.ksp = ksp = PETSc.KSP().create(COMM)
        self.stale: PETSc.KSP | None = None
        for name, value in zip(self.names, settings.values(), strict=True):
            database.setValue(name, value)
        ksp.setOptionsPrefix(prefix)
        ksp.setOperators(A)
        try:
            self._run(ksp.setFromOptions)
        except (PETSc.Error, ValueError):
            self.destroy()
            raise
        pc = ksp.getPC()
        self.direct = pc.getType() == PETSc.PC.Type.LU
        if symmetric and self.direct:
            kind = pc.getFactorSolverType()
            pc.setType(PETSc.PC.Type.CHOLESKY)
            pc.setFactorSolverType(kind)
        if symmetric and multigrid and "ksp_type" not in chosen:
            ksp.setType(PETSc.KSP.Type.CG)
            ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        if d == 3 and self.direct and ksp.getType() == PETSc.KSP.Type.PREONLY:
            self.stale = PETSc.KSP().create(COMM)
            self.stale.setPC(pc)
            self.stale.setOperators(A)
            self.stale.setType(PETSc.KSP.Type.GMRES)
            self.stale.setPCSide(PETSc.PC.Side.RIGHT)
            self.stale.setTolerances(rtol=STALE_RTOL, max_it=STALE)
        self.worn = True
        self.factored = False

    def solve(self, b: PETSc.Vec, y: PETSc.Vec, fresh: bool) -> tuple[int, int, bool]:
        """Solve, with an old factor where it does; iterations, factorizations, and whether it is solved."""
        pc, spent = self.ksp.getPC(), 0
        if self.stale and not (fresh or self.worn):
            pc.setReusePreconditioner(True)
            try:
                self.stale.solve(b, y)
            finally:
                pc.setReusePreconditioner(False)
            spent = self.stale.getIterationNumber()
            self.worn = spent >= 0.7 * STALE
            if self.stale.getConvergedReason() > 0:
                return spent, 0, True
        self.worn = False
        self._run(self.ksp.solve, b, y)
        self._read()
        good = self.ksp.getConvergedReason() > 0
        self.factored = self.factored or (self.direct and good)
        return spent + self.ksp.getIterationNumber(), 1, good

    def _run(self, call: Callable[..., object], *words: object) -> None:
        """Call PETSc; raise ValueError where it refuses the options of a caller."""
        try:
            call(*words)
        except PETSc.Error as error:
            if not self.chosen:
                raise
            reason = str(error).splitlines()[-1].removeprefix(f"[{COMM.rank}] ")
            text = f"options {self.chosen!r}: PETSc ends with {reason!r}"
            raise ValueError(f"{text}: expected types and numbers that it has") from None

    def _read(self) -> None:
        """Refuse options that nothing has read once the equations are solved."""
        options, prefix = PETSc.Options(), self.ksp.getOptionsPrefix()
        unread = [name for name in self.unread if not options.used(prefix + name)]
        self.unread = []
        if unread:
            raise ValueError(f"-{unread[0]}: expected an option that these solvers of PETSc read")

    def destroy(self) -> None:
        """Release the factors and the options."""
        self.ksp.destroy()
        if self.stale:
            self.stale.destroy()
        for name in self.names:
            PETSc.Options().delValue(name)

    def factor(self) -> tuple[float, float, float]:
        """Entries of the factor by MUMPS, operations of its elimination and GB; 0 by other solvers."""
        pc = self.ksp.getPC()
        # without a factor PETSc hands out no matrix
        if not self.factored or pc.getFactorSolverType() != PETSc.Mat.SolverType.MUMPS:
            return 0.0, 0.0, 0.0
        factor = pc.getFactorMatrix()
        entries, gigabytes = factor.getMumpsInfog(29), factor.getMumpsInfog(22) / 1e3
        entries = entries if entries >= 0 else -1e6 * entries  # in millions where they are many
        return float(entries), float(factor.getMumpsRinfog(3)), float(gigabytes)


def words_of(options: str) -> dict[str, str]:
    """Options of PETSc by their names."""
    names: dict[str, str] = {}
    name = ""
    for word in options.split():
        if word.startswith("-") and not word[1:2].isdigit() and word[1:2] != ".":
            name = word[1:]
            names[name] = ""
        elif not name:
            raise ValueError(f"options {options!r}: expected options of PETSc, as -pc_type gamg")
        else:
            names[name] = word
    if wrong := [name for name in names if name.startswith("snes_")]:
        raise ValueError(f"-{wrong[0]}: expected options of PETSc for linear equations")
    return names


_KEPT: weakref.WeakKeyDictionary[Model, tuple[tuple[bytes, str], Equations]] = weakref.WeakKeyDictionary()
"""The last equations of each model: they are those of any other call with the same components and options."""


def equations_of(model: Model, fixed: Integers, options: str) -> Equations:
    """Equations of a model with these components fixed, kept for the next call."""
    key, kept = (fixed.tobytes(), options), _KEPT.get(model)
    if total(float(kept is None or kept[0] != key)) > 0.0:
        new = Equations(model, fixed, options)
        if kept:
            kept[1].destroy()
        kept = _KEPT[model] = key, new
    assert kept
    return kept[1]


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
        return respond(m, start, s, task.dt, task.p, aim, clock)

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
            q.assemble(response.D, task, SOFT if convex or floating else 0.0, convex)
            dx, inner, count = q.step(now.full, convex, iteration == 0)
            linear, factored = linear + inner, factored + count
            if dx is None or not np.isfinite(totals(float(np.abs(dx).sum()))[0]):
                if floating or convex:
                    return found(False, "the tangent has no solution")
                floating = True
                q.assemble(response.D, task, SOFT, convex)
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
    first, last, least, before = HOPELESS
    if len(residuals) <= first:
        return False
    now = min(residuals[-last:])
    fallen = now <= least * min(residuals[:-last]) or now <= before * residuals[-last - 1]
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
        if not low < a < high or k > BISECT:
            a = 0.5 * (low + high)
        new = at(s + a * ds)
        f = work(a, new)
        # the method of Illinois: a side that stays counts half
        if f * start > 0.0:
            low, at_low, at_high, side = a, f, at_high * (0.5 if side == 1 else 1.0), 1
        else:
            high, at_high, at_low, side = a, f, at_low * (0.5 if side == -1 else 1.0), -1
    return a, new
