"""A wall on the ranks of MPI: its forces, stiffness and linear solver, with PETSc."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from asperity.contract import Floats
from asperity.interface import Interface, Update
from masonry import Joints, Masonry, Mesh
from mpi4py import MPI
from petsc4py import PETSc

COMM, INT, ADD = MPI.COMM_WORLD, PETSc.IntType, PETSc.InsertMode.ADD_VALUES

KRYLOV = "-ksp_type gmres -ksp_gmres_restart 300 -ksp_max_it 3000 "
SOLVERS = {
    "mumps": "-ksp_type preonly -pc_type lu -pc_factor_mat_solver_type mumps",
    "bricks": KRYLOV
    + "-pc_type mg -pc_mg_galerkin both -mg_levels_ksp_type richardson -mg_levels_ksp_max_it 1 "
    "-mg_levels_pc_type bjacobi -mg_levels_sub_pc_type lu -mg_coarse_ksp_type preonly -mg_coarse_pc_type lu "
    "-mg_coarse_pc_factor_mat_solver_type mumps",
}
"""Options of PETSc: direct, or two levels with the rigid motions of every half-brick as the coarse space."""


class NotConvergedError(RuntimeError):
    """A step that has no solution; all ranks raise it."""


def total(x: float) -> float:
    """Sum over the ranks."""
    return COMM.allreduce(float(x))


def largest(x: Floats) -> float:
    """Largest absolute value on all ranks."""
    return COMM.allreduce(float(np.abs(x).max(initial=0.0)), MPI.MAX)


class Wall(Mesh):
    """Part of a wall: displacements and forces are arrays of the owned nodes, (own * d,)."""

    def __init__(
        self,
        masonry: Masonry,
        laws: tuple[Interface, Interface],
        elements: Sequence[int],
        grid: Sequence[int],
    ) -> None:
        """Build the part of this rank; grid: ranks along length, height."""
        super().__init__(masonry, laws, elements, grid, COMM.rank)
        if not COMM.allreduce(bool(self.pushed.any()), MPI.LOR):
            raise ValueError(
                f"elements = {tuple(elements)}: expected nodes of the beam at the level {masonry.level:g} mm"
            )
        ghosts, size = self.nodes[self.own :].astype(INT), (self.own * self.d, None)
        self.vector = PETSc.Vec().createGhost(ghosts, size, bsize=self.d)
        self.clock = {"law": 0.0, "assembly": 0.0, "solve": 0.0}
        self.linear = 0
        self._make_matrix()

    def _make_matrix(self) -> None:
        """Stiffness of the half-bricks, with room for the joints."""
        d, nd = self.d, self.own * self.d
        r, c = np.nonzero(np.kron(self.K[0].reshape(self.nn, d, self.nn, d).any((1, 3)), np.ones((d, d))))
        columns = (c + (self.lo + np.arange(self.nb) * self.nn)[:, None] * d).ravel()
        values = np.where(self.stiff[:, None], self.K[1][r, c], self.K[0][r, c])
        rows = np.r_[0, np.cumsum(np.tile(np.bincount(r), self.nb))].astype(INT)
        self.M = PETSc.Mat().createAIJ(((nd, None), (nd, None)), bsize=d)
        self.M.setPreallocationNNZ((np.diff(rows) + 2 * d, 2 * d))
        self.M.setValuesCSR(rows, columns.astype(INT), values.ravel(), ADD)
        for g in self.joints:
            rows = (self.nodes[g.nodes][:, :, None] * d + np.arange(d)).reshape(-1, 2 * d).astype(INT)
            pointers = (2 * d * np.arange(rows.size + 1)).astype(INT)
            g.where = pointers, np.repeat(rows, 2 * d, 0).ravel(), rows.ravel()
            self._add(self.M, g, np.zeros((len(rows), 2, d, 2, d)))
        self.M.assemble()

    @staticmethod
    def _add(matrix: PETSc.Mat, g: Joints, blocks: Floats) -> None:
        """Add the blocks of pairs of nodes."""
        pointers, columns, rows = g.where
        matrix.setValuesIJV(pointers, columns, blocks.ravel(), ADD, rows)

    def restrain(self, fixed: np.ndarray, solver: str) -> None:
        """Prescribe the components `fixed` of the owned nodes and the ghosts, (nodes, d)."""
        self.free = ~fixed[: self.own].ravel()
        self.base = self.M.duplicate(copy=True)
        rows = np.flatnonzero(~self.free) + self.lo * self.d
        self.base.zeroRowsColumns(rows.astype(INT), diag=np.abs(self.K[0]).max())
        self.A = self.base.duplicate(copy=True)
        for g in self.joints:
            free = ~fixed[g.nodes]
            g.keep = free[:, :, :, None, None] & free[:, None, None]
        self.ksp = PETSc.KSP().create()
        self.ksp.setOperators(self.A)
        if solver == "bricks":
            self._two_levels(self.ksp.getPC())
        self.ksp.setTolerances(rtol=1e-6)
        self.ksp.setFromOptions()

    def _two_levels(self, pc: PETSc.PC) -> None:
        """Coarse space: rigid motions of every half-brick; smoother: the half-bricks one by one."""
        d, nb = self.d, self.nb
        x = self.X[: self.own].reshape(nb, self.nn, d)
        x = (x - x.mean(1, keepdims=True)) / 50.0
        turns = [(p, q) for p in range(d) for q in range(p)]
        m = d + len(turns)
        Z = np.zeros((nb, self.nn, d, m))
        Z[..., range(d), range(d)] = 1.0
        for k, (p, q) in enumerate(turns):
            Z[..., p, d + k], Z[..., q, d + k] = x[..., q], -x[..., p]
        Z = Z.reshape(-1, m) * self.free[:, None]
        P = PETSc.Mat().createAIJ(((len(Z), None), (nb * m, None)), bsize=(d, m), nnz=(m, 0))
        columns = (self.lo // self.nn + np.repeat(np.arange(nb), self.nn * d))[:, None] * m + np.arange(m)
        P.setValuesCSR((np.arange(len(Z) + 1) * m).astype(INT), columns.ravel().astype(INT), Z.ravel())
        P.assemble()
        PETSc.Options()["mg_levels_pc_bjacobi_local_blocks"] = nb
        pc.setType("mg")
        pc.setMGLevels(2)
        pc.setMGInterpolation(1, P)

    def spread(self, u: Floats) -> Floats:
        """Displacements (nodes, d) of the owned nodes and the ghosts."""
        self.vector.array[:] = u
        self.vector.ghostUpdate(PETSc.InsertMode.INSERT, PETSc.ScatterMode.FORWARD)
        with self.vector.localForm() as v:
            return v.array.reshape(-1, self.d).copy()

    def gather(self, u: Floats | None, tractions: Sequence[Floats]) -> Floats:
        """Forces of tractions in the joints and, at displacements of `spread`, of the half-bricks."""
        f = np.zeros((len(self.nodes), self.d))
        if u is not None:
            bricks = u[: self.own].reshape(self.nb, -1)
            f[: self.own] = np.where(self.stiff[:, None], bricks @ self.K[1], bricks @ self.K[0]).reshape(
                -1, self.d
            )
        f = f.ravel()
        for g, t in zip(self.joints, tractions, strict=True):
            dof = g.nodes[:, :, None] * self.d + np.arange(self.d)
            f += np.bincount(dof.ravel(), g.forces(t).ravel(), len(f))
        return self.collect(f)

    def collect(self, f: Floats) -> Floats:
        """Sums of the ranks at the owned nodes."""
        with self.vector.localForm() as v:
            v.array[:] = f.ravel()
        self.vector.ghostUpdate(ADD, PETSc.ScatterMode.REVERSE)
        return self.vector.array.copy()

    def update(self, u: Floats, dt: float) -> Floats:
        """Internal forces; the law is called for the points of this rank."""
        here, begin, message = self.spread(u), time.process_time(), ""
        self.trial: list[tuple[Floats, Update]] = []
        try:
            for g in self.joints:
                s = g.separation(here)
                self.trial.append((s, g.law.update(s, g.state, g.s, dt)))
        except ValueError as error:
            message = str(error)
        self.clock["law"] += time.process_time() - begin
        if worst := max(COMM.allgather(message)):
            raise NotConvergedError(f"the law: {worst}")
        return self.gather(here, [r.traction for _, r in self.trial])

    def tangent_times(self, u: Floats) -> Floats:
        """Forces of displacements by the stiffness of the last update."""
        here, parts = self.spread(u), zip(self.joints, self.trial, strict=True)
        return self.gather(
            here, [np.einsum("pkl,pl->pk", r.tangent, g.separation(here)) for g, (_, r) in parts]
        )

    def accept(self, F: Floats) -> None:
        """Take the last update as the end of a step, with its internal forces."""
        for g, (s, r) in zip(self.joints, self.trial, strict=True):
            g.growth, g.moved = np.maximum(r.state[:, 0] - g.state[:, 0], 0.0), s - g.s
            g.s, g.state = s, r.state
        self.accepted, self.F = self.trial, F

    def solve(self, *right: Floats, diagonal: Floats | float = 0.0) -> list[Floats]:
        """Solutions with the stiffness of the last update and a diagonal."""
        begin = time.process_time()
        self.base.copy(self.A, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        for g, (_, r) in zip(self.joints, self.trial, strict=True):
            self._add(self.A, g, g.blocks(r.tangent) * g.keep)
        self.A.assemble()
        if np.ndim(diagonal):
            entries = self.A.getDiagonal()
            entries.array += diagonal * self.free
            self.A.setDiagonal(entries)
        self.clock["assembly"] += time.process_time() - begin
        begin, out = time.process_time(), []
        x, b = self.A.createVecs()
        for one in right:
            b.array[:] = one * self.free
            self.ksp.solve(b, x)
            self.linear += self.ksp.getIterationNumber()
            if self.ksp.getConvergedReason() < 0:
                raise NotConvergedError(f"linear solver: reason {self.ksp.getConvergedReason()}")
            out.append(x.array.copy())
        self.clock["solve"] += time.process_time() - begin
        return out
