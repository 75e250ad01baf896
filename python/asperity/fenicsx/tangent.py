"""The tangent of a model as a matrix of PETSc, and the solvers of the linear equations with it."""

from __future__ import annotations

import itertools
import weakref
from collections.abc import Callable

import numpy as np
from petsc4py import PETSc
from scipy.sparse import csr_array

from ..contract import Floats
from ..mesh.shapes import Integers
from .model import INT, Model
from .ranks import COMM, total

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


class Equations:
    """The tangent of a model whose components `fixed` are prescribed, and the solvers of it."""

    def __init__(self, model: Model, fixed: Integers, options: str) -> None:
        """Lay out the matrix: entries of the solids, of the joints and of the diagonal, by one list."""
        self._model, self.fixed = weakref.ref(model), fixed
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

    @property
    def model(self) -> Model:
        """The model, which the equations do not keep: they are kept as long as it is."""
        model = self._model()
        assert model
        return model

    def _rigid(self) -> PETSc.NullSpace:
        """Rigid motions, for algebraic multigrid."""
        x = self.b.duplicate()
        x.setBlockSize(self.model.d)
        x.array[:] = self.model.x.ravel()
        return PETSc.NullSpace().createRigidBody(x)

    def assemble(self, D: Floats, drag: Floats, damping: float, soft: float, symmetric: bool) -> None:
        """Set the tangent to that with the tangents D (p, 3, 3) of the points.

        drag (n d,): forces over the displacements of the step.  damping, soft: shares of the stiffness of the
        solids that are added, of all of it and of its diagonal.
        """
        m = self.model
        joints = np.asarray(self._of_points @ D.ravel())[self._take] * self._sign
        diagonal = np.where(self.free > 0.0, drag + soft * m.diagonal, m.scale)
        # entries of another kind may follow
        self.A.setOption(PETSc.Mat.Option.SYMMETRIC, symmetric)
        values = np.concatenate([(1.0 + damping) * self._of_solids, joints, diagonal])
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
        names, self.chosen = [prefix + name for name in settings], options
        self.forget = weakref.finalize(self, _forget, names)
        self.forget.atexit = False
        # those of the levels of multigrid are read where a mesh has these levels
        self.unread = [name for name in chosen if not name.startswith("mg_")]
        self.ksp = ksp = PETSc.KSP().create(COMM)
        self.stale: PETSc.KSP | None = None
        for name, value in zip(names, settings.values(), strict=True):
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
        self.forget()

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


def _forget(names: list[str]) -> None:
    """Take options out of those of PETSc."""
    for name in names:
        PETSc.Options().delValue(name)


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
