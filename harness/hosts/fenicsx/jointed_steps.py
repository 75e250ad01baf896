"""Steps of a model by SNES of PETSc."""

from __future__ import annotations

from collections.abc import Callable

from jointed_model import ADD, INT, LawError, Model  # isort: skip  # loads MPI
import numpy as np
from asperity.contract import Floats
from jointed_mesh import COMM, agree, doubles, total
from jointed_water import Mixing
from mpi4py import MPI
from petsc4py import PETSc

OPTIONS = (
    "-ksp_type preonly -pc_type lu -pc_factor_mat_solver_type mumps "
    "-options_left 0 -snes_max_it 20 "
    "-snes_linesearch_type bisection -snes_linesearch_max_it 25 -snes_linesearch_rtol 1e-2"
)
"""Options of PETSc for the equations of a step; others replace them."""

MULTIGRID = (
    "-ksp_type fgmres -ksp_rtol 1e-7 -ksp_gmres_restart 200 -ksp_max_it 1000 "
    "-pc_gamg_threshold 0.02 -mg_levels_ksp_type chebyshev -mg_levels_ksp_max_it 1 -mg_levels_pc_type sor"
)
"""More of them for `-pc_type gamg`, a symmetric preconditioner, as conjugate gradients need it.

The threshold keeps open joints, whose stiffness is zero, from joining blocks on the coarse levels.  GMRES
would judge the preconditioned residual, which falls long before that of the equations.
"""

SUM = PETSc.NormType.NORM_1
"""Sum of the magnitudes of all components, on all ranks."""

VANISHED = 1e-3
"""Share of the largest forces of the steps before below which forces count as this share."""


def _wrong(name: str, values: Floats | float, shape: tuple[int, ...]) -> str:
    """What is wrong with values for some components, or nothing."""
    if np.shape(values) != shape:
        return (
            f"{name} of the shape {np.shape(values)}: expected {shape}, one for each component on this rank"
        )
    return "" if np.isfinite(values).all() else f"{name}: expected finite numbers"


SOFT = 1e-8
"""Share of the largest stiffness that the tangent has more where blocks may float: always in passes."""

THROWN = 1e3
"""Residual over the forces, or over the first one, beyond which the tangent before was singular."""

PASSES, SAME_DAMAGE, SAME_FORCE = 8, 1e-3, 1e-4
"""Most passes of a step, and errors below which no further pass is made."""

CLOSE_DAMAGE, CLOSE_FORCE, FINISH = 0.05, 0.003, 6
"""Errors of a pass below which Newton's method goes on from its solution, with so many iterations."""

SAME_WATER, MOST_WATER = 1e-6, 60
"""Error of a pressure that depends on openings over the largest one, and most equilibria of a step."""

MIXED = 0.3, 6
"""Share of the difference by which such a pressure moves, and changes before that correct it."""


class Steps:
    """Steps of a model under prescribed displacements and loads.

    fixed: owned components that are prescribed.  drag: forces over displacements in a step of the time 1.
    errors: of the last step by passes, largest of a damage and of forces over those of the model; 0 where
    Newton's method ends it.  floating: whether a tangent was singular, as where a block lies in no contact;
    from then on it has a share of the largest stiffness more, while the equations stay.
    equilibria: of the last step, more than one where pressures of water depend on openings.
    """

    def __init__(
        self,
        model: Model,
        fixed: np.ndarray,
        tolerance: float = 1e-6,
        options: str = "",
        drag: Floats | float = 0.0,
    ) -> None:
        """Set up SNES; tolerance: of the residual over the prescribed forces, loads or pressures.

        Both are sums of magnitudes, so that the same tolerance holds in a mesh of any size.
        """
        self.model, self.fixed, self.tolerance = model, np.unique(np.asarray(fixed, np.int64)), tolerance
        if not 0.0 < tolerance < 1.0:
            raise ValueError(f"tolerance = {tolerance}: expected between 0 and 1")
        inside = not len(self.fixed) or 0 <= self.fixed[0] <= self.fixed[-1] < len(model.u)
        agree(
            "" if inside else f"fixed {self.fixed[[0, -1]]}: expected components 0 to {len(model.u) - 1}",
            _wrong("drag", drag, np.ndim(drag) * model.u.shape),
        )
        self.drag = np.broadcast_to(drag, model.u.shape) * np.ones(1)
        if not COMM.allreduce(len(self.fixed)) and not total(np.abs(self.drag).sum()):
            raise ValueError("nothing is fixed and there is no drag: expected components that hold the model")
        self.rows = (self.fixed + model.map.local_range[0] * model.d).astype(INT)
        self.load, self.iterations, self.message = 0.0 * model.u, 0, ""
        self.reaction, self.size, self.largest = 0.0 * model.u, 0.0, 0.0
        self.passes, self.errors, self.equilibria, self.floating, self.first = 0, (0.0, 0.0), 0, False, 0.0
        database = PETSc.Options()
        database.insertString(f"{OPTIONS} {options}")
        multigrid = database.getString("pc_type") == PETSc.PC.Type.GAMG
        if multigrid:
            database.insertString(f"{MULTIGRID} {options}")
        # both kinds of tangents have their own iterations, unless those are given
        self.conjugate = multigrid and "-ksp_type" not in options.split()
        self.restart = database.getInt("ksp_gmres_restart", 30)
        self.snes = PETSc.SNES().create(COMM)
        self.factored = False
        self.x = model.K.createVecRight()
        self.A = model.K.duplicate()
        self.A.setNearNullSpace(self._rigid())
        self.snes.setFunction(self._residual, self.x.duplicate())
        self.snes.setJacobian(self._jacobian, self.A)
        self.snes.setConvergenceTest(self._judge)
        search = database.getString("snes_linesearch_type")
        try:
            self.snes.getLineSearch().setType(search)
        except PETSc.Error as error:
            version = ".".join(map(str, PETSc.Sys.getVersion()))
            text = (
                f"PETSc {version} has no line search {search}: expected PETSc 3.24 or later, or another one, "
            )
            raise ValueError(f"{text}such as -snes_linesearch_type cp") from error
        self.snes.setFromOptions()

    def _rigid(self) -> PETSc.NullSpace:
        """Rigid motions, for algebraic multigrid."""
        x = self.x.duplicate()
        x.setBlockSize(self.model.d)
        x.array[:] = self.model.x.ravel()
        return PETSc.NullSpace().createRigidBody(x)

    def _residual(self, snes: PETSc.SNES, x: PETSc.Vec, f: PETSc.Vec) -> None:
        try:
            self.reaction = self.model.forces(x, self.dt) - self.load
        except LawError as error:
            self.message = f"the law: {error}"
            f.array[:] = np.nan  # outside the domain, as PETSc takes it
            return
        f.array[:] = self.reaction + self.drag / self.dt * (x.array_r - self.model.u)
        f.array[self.fixed] = self.model.scale * (x.array_r[self.fixed] - self.values)

    def _jacobian(self, snes: PETSc.SNES, x: PETSc.Vec, A: PETSc.Mat, P: PETSc.Mat) -> None:
        convex = self.model.aim is not None
        A.setOption(PETSc.Mat.Option.SYMMETRIC, False)  # before entries of another kind
        self.model.tangent(A)
        soft = SOFT * self.model.scale if convex or self.floating else 0.0
        more = self.x.duplicate()
        more.array[:] = self.drag / self.dt + soft
        A.setDiagonal(more, ADD)
        if convex:  # the fixed components have their values, so that their columns meet zeros
            A.zeroRowsColumns(self.rows, diag=self.model.scale)
            A.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        else:
            A.zeroRows(self.rows, diag=self.model.scale)

    def _solver(self) -> None:
        """For the symmetric tangent of passes choose Cholesky for LU, conjugate gradients for FGMRES."""
        ksp, convex = self.snes.getKSP(), self.model.aim is not None
        pc, kinds = ksp.getPC(), (PETSc.PC.Type.LU, PETSc.PC.Type.CHOLESKY)
        old, new = kinds if convex else kinds[::-1]
        if pc.getType() == old:
            solver = pc.getFactorSolverType()
            pc.setType(new)
            pc.setFactorSolverType(solver)
            self.factored = False
        if self.conjugate and convex != (ksp.getType() == PETSc.KSP.Type.CG):
            if convex:
                ksp.setType(PETSc.KSP.Type.CG)
                ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
            else:
                ksp.setType(PETSc.KSP.Type.FGMRES)
                ksp.setGMRESRestart(self.restart)

    def factor(self) -> tuple[float, float, float]:
        """Entries of the last factor by MUMPS, operations of its elimination and GB; 0 by other solvers."""
        pc = self.snes.getKSP().getPC()
        direct = pc.getType() in (PETSc.PC.Type.LU, PETSc.PC.Type.CHOLESKY)
        # without a factor PETSc hands out no matrix
        if not (direct and self.factored) or pc.getFactorSolverType() != PETSc.Mat.SolverType.MUMPS:
            return 0.0, 0.0, 0.0
        factor = pc.getFactorMatrix()
        entries, gigabytes = factor.getMumpsInfog(29), factor.getMumpsInfog(22) / 1e3
        entries = entries if entries >= 0 else -1e6 * entries  # in millions where they are many
        return float(entries), factor.getMumpsRinfog(3), gigabytes

    def destroy(self) -> None:
        """Release the factors, which Python's garbage collector does not reach."""
        self.snes.destroy()

    def solve(self, values: Floats, load: Floats, dt: float = 1.0, ahead: Floats | float = 0.0) -> bool:
        """Solve a step to displacements of the fixed components and loads; whether it converged.

        ahead: guess of the change of the displacements.
        """
        self.passes, self.errors = 0, (0.0, 0.0)
        return self._with_water(self.model.u + ahead, lambda x: self._find(values, load, dt, x))

    def solve_by_passes(
        self,
        values: Floats,
        load: Floats,
        dt: float,
        aim: list[Floats],
        ahead: Floats | float = 0.0,
        most: int = PASSES,
        finish: bool = True,
    ) -> bool:
        """Solve a step by convex problems; whether they converged, with `errors` of the result.

        Damage, bounds of friction and slopes of the joints are those of the law at `aim`, separations by law:
        first a guess, then the solution of the pass before.  Contact is free.  Each pass is the minimum of a
        convex energy; where the passes converge, the step is that of the law.  finish: whether Newton's
        method, whose tangent is not symmetric, is tried once from a pass that is close.
        """  # fmt: skip

        def find(x: Floats) -> bool:
            iterations, good, at, untried = 0, False, aim, finish
            try:
                for self.passes in range(1, most + 1):
                    x[self.fixed] = values
                    self.model.aim = at
                    good = self._find(values, load, dt, x)
                    iterations += self.iterations
                    if not good:
                        break
                    damage, force = self.model.frozen(dt)
                    self.errors = damage, force / self.size
                    if damage < SAME_DAMAGE and self.errors[1] < SAME_FORCE:
                        break
                    x, at = self.x.array_r.copy(), [s for s, _ in self.model.trial]
                    close = damage < CLOSE_DAMAGE and self.errors[1] < CLOSE_FORCE
                    if close and untried and self.passes < most:  # another pass follows where it fails
                        untried = False
                        if self._finish(values, load, dt, x):
                            iterations, self.errors = iterations + self.iterations, (0.0, 0.0)
                            break
                        iterations += self.iterations
            finally:
                self.model.aim, self.iterations = None, iterations
            return good

        return self._with_water(self.model.u + ahead, find)

    def _finish(self, values: Floats, load: Floats, dt: float, x: Floats) -> bool:
        """Go on by a few iterations of Newton's method; whether they converge."""
        self.model.aim = None
        *_, most = self.snes.getTolerances()
        self.snes.setTolerances(max_it=min(FINISH, most))
        try:
            return self._find(values, load, dt, x.copy())
        finally:
            self.snes.setTolerances(max_it=most)

    def _with_water(self, x: Floats, find: Callable[[Floats], bool]) -> bool:
        """Find the equilibrium from x, again until pressures belong to its openings, and accept it."""
        water, mixing, iterations = self.model.water, Mixing(*MIXED), 0
        before = water.p
        for self.equilibria in range(1, MOST_WATER + 1):
            good = find(x)
            iterations, x = iterations + self.iterations, self.x.array_r.copy()
            if not good:
                break
            aim = water.aim([s for s, _ in self.model.trial])
            left = 0.0 if aim is None else COMM.allreduce(np.abs(aim - water.p).max(initial=0.0), MPI.MAX)
            if left <= SAME_WATER * COMM.allreduce(water.p.max(initial=0.0), MPI.MAX):
                self.iterations = iterations
                self.model.accept(self.x)
                return True
            water.p = mixing.mixed(water.p, aim)
        else:
            self.message = f"the pressure of water still changes by {left:.2g} after {MOST_WATER} equilibria"
        water.p, self.iterations = before, iterations
        return False

    def _find(self, values: Floats, load: Floats, dt: float, start: Floats) -> bool:
        """Find displacements `x` that balance the forces; whether they do."""
        values, load = doubles("values", values), doubles("load", load)
        agree(
            _wrong("values", values, self.fixed.shape),
            _wrong("load", load, self.model.u.shape),
            "" if 0.0 < dt < np.inf else f"dt = {dt}: expected above 0",
        )
        self.values, self.load, self.dt, self.message = values, load + self.model.water.outer, dt, ""
        self.x.array[:] = start
        self._solver()
        self.snes.solve(None, self.x)
        self.model.linear += self.snes.getLinearSolveIterations()
        self.factored = self.factored or self.snes.getLinearSolveIterations() > 0
        self.iterations, reason = self.snes.getIterationNumber(), self.snes.getConvergedReason()
        if reason <= 0:
            self.message = self.message or f"SNES ends with {reason} after {self.iterations} iterations"
            return False
        # some line searches report convergence where they find no way down; and the state must be that of x
        left = self.x.duplicate()
        self._residual(self.snes, self.x, left)
        unbalanced = left.norm(SUM)
        if not self._small(unbalanced):
            text = f"SNES reports convergence ({reason}) after {self.iterations} iterations, but the residual"
            text += f" is {unbalanced / self.size:.2g} of the forces: expected at most {self.tolerance:g}"
            self.message = self.message or text
            return False
        self.largest = max(self.largest, self.size)
        return True

    def _small(self, residual: float) -> bool:
        """Whether the sum of a residual is small against the forces of its last call, kept as `size`."""
        forces = total(np.abs(self.reaction[self.fixed]).sum()), total(np.abs(self.load).sum())
        forces = *forces, total(self.model.area @ self.model.water.p)
        self.size = max(*forces, VANISHED * self.largest)
        return residual <= self.tolerance * self.size

    def _judge(self, snes: PETSc.SNES, iteration: int, norms: tuple[float, float, float]) -> int:
        """Reason to end the iterations, or 0; norms: Euclidean, of x, its last change and the residual."""
        reason = PETSc.SNES.ConvergedReason
        if not np.isfinite(norms[2]):
            return reason.DIVERGED_FNORM_NAN
        residual = snes.getFunction()[0].norm(SUM)
        if self._small(residual):
            return reason.CONVERGED_FNORM_ABS
        if iteration == 0:
            self.first = residual
        elif residual > THROWN * max(self.first, self.size):
            self.floating = True
        return reason.DIVERGED_MAX_IT if iteration >= snes.getTolerances()[3] else reason.ITERATING
