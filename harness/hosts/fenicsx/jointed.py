"""Meshes with joints on FEniCSx: elastic solids by UFL, joints by the law at pairs of nodes, steps by PETSc.

The ranks of MPI share the mesh.  A joint belongs to the rank of its cell on the minus side, which has the
cell on the plus side as a ghost.
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from mpi4py import MPI  # isort: skip  # loads the library of MPI that dolfinx needs
import basix.ufl
import dolfinx.fem.petsc as fp
import numpy as np
import ufl
from asperity import contract
from asperity.contract import Floats
from asperity.interface import Interface, Update
from asperity.mesh import Jointed
from dolfinx import cpp, fem, graph, la, mesh
from petsc4py import PETSc

sys.path.append(str(Path(__file__).parent.parent))  # of paraview_files, where it is not beside this file
import paraview_files

COMM, INT, ADD = MPI.COMM_WORLD, PETSc.IntType, PETSc.InsertMode.ADD_VALUES

BASIX = {
    "triangle": [0, 1, 2], "quad": [0, 1, 3, 2], "tetra": [0, 1, 2, 3],
    "hexahedron": [0, 1, 3, 2, 4, 5, 7, 6],
}  # fmt: skip
"""Nodes of the cells of meshio in the order of dolfinx."""

NAMES = {"quad": "quadrilateral", "tetra": "tetrahedron"}
"""Names of cells in dolfinx, where meshio has others."""

OPTIONS = (
    "-ksp_type preonly -pc_type lu -pc_factor_mat_solver_type mumps "
    "-options_left 0 -snes_linesearch_type cp -snes_max_it 40 -snes_divergence_tolerance 1e30 "
    "-pc_mg_galerkin both -mg_levels_ksp_type gmres -mg_levels_ksp_max_it 2 -mg_levels_pc_asm_type basic "
    "-mg_levels_pc_asm_overlap 1 -mg_levels_sub_pc_type lu -mg_coarse_pc_type lu "
    "-mg_coarse_pc_factor_mat_solver_type mumps"
)
"""Options of PETSc for the equations of a step, those for `-pc_type mg`, too; others replace them."""

FAST, GROWTH = 6, 1.5
"""A step grows after at most FAST iterations."""


def _abort(*error: object) -> None:
    """End all ranks where one has an error that nobody handles."""
    sys.__excepthook__(*error)
    COMM.Abort(1)


if COMM.size > 1:
    sys.excepthook = _abort


def total(x: float) -> float:
    """Sum over the ranks."""
    return float(COMM.allreduce(float(x)))


class Model:
    """Nodes, solids and joints on this rank.

    x (n, d): owned nodes.  u: displacements of the last step, (n d,).  names: of the blocks.  s, state: of
    the points of the joints by law.
    """

    def __init__(
        self,
        jointed: Jointed | None,
        laws: Mapping[str, Interface],
        E: float | Mapping[str, float],
        nu: float,
        thickness: float = 1.0,
        plane: str = "stress",
    ) -> None:
        """Distribute a mesh, which rank 0 has; laws: of its joints; E: of all solids, or by block."""
        cells, points, shared = _whole(jointed, laws) if COMM.rank == 0 else (None,) * 3
        kind, d, block, self.names, self.groups, faces = COMM.bcast(shared)
        minus, plus, law, axes, weight, sides = faces
        self.laws, self.d = list(laws.values()), d
        self.thickness = thickness if d == 2 else 1.0
        if COMM.rank > 0:
            cells, points = np.zeros((0, len(BASIX[kind])), np.int64), np.zeros((0, d))
        element = basix.ufl.element("Lagrange", NAMES.get(kind, kind), 1, shape=(d,))
        parts = None if COMM.size == 1 else lambda *words: _partition(*words[1:], sides)
        self.mesh = m = mesh.create_mesh(COMM, cells, ufl.Mesh(element), points, parts)
        self.V = fem.functionspace(m, ("Lagrange", 1, (d,)))
        self.map = self.V.dofmap.index_map
        self.n = self.map.size_local
        self.x = self.V.tabulate_dof_coordinates()[: self.n, :d]
        # local numbers of cells and nodes
        original = m.topology.original_cell_index
        self.cell_block = block[original]
        order = np.argsort(original)
        at = np.minimum(np.searchsorted(original[order], sides[:, 0]), len(order) - 1)
        here = order[at]
        mine = (original[here] == sides[:, 0]) & (here < m.topology.index_map(d).size_local)
        node = np.empty(len(m.geometry.input_global_indices), np.int64)
        node[m.geometry.dofmap.ravel()] = self.V.dofmap.list.ravel()
        self._order = np.argsort(m.geometry.input_global_indices)
        self._known = m.geometry.input_global_indices[self._order]
        self._node = node[self._order]
        minus, plus, law, axes, weight = (one[mine] for one in (minus, plus, law, axes, weight))
        self._points(self.local(minus), self.local(plus), law, axes, self.thickness * weight)
        self._stiffness(E, nu, plane)
        self.u, self.clock, self.linear = np.zeros(self.n * d), 0.0, 0

    def local(self, nodes: np.ndarray) -> np.ndarray:
        """Local numbers of nodes of the mesh that this rank has."""
        return self._node[np.searchsorted(self._known, nodes)].astype(np.int32)

    def group(self, name: str) -> tuple[np.ndarray, Floats]:
        """Owned nodes of a group, and their shares in its area."""
        if name not in self.groups:
            raise ValueError(f"{name}: no such group: expected one of {', '.join(self.groups)}")
        nodes, area = self.groups[name]
        at = np.minimum(np.searchsorted(self._known, nodes), len(self._known) - 1)
        local = np.where(self._known[at] == nodes, self._node[at], self.n)
        return local[local < self.n], self.thickness * area[local < self.n]

    def dofs(self, nodes: np.ndarray, *components: int) -> np.ndarray:
        """Components of owned nodes, as indices or a mask of them."""
        nodes = np.flatnonzero(nodes) if nodes.dtype == bool else nodes
        return (nodes[:, None] * self.d + np.array(components, np.int64)).ravel()

    def _points(
        self, minus: np.ndarray, plus: np.ndarray, law: np.ndarray, axes: Floats, weight: Floats
    ) -> None:
        """Points at the pairs of nodes; those of faces with the same law, nodes and axes are one point."""
        self.sides, k = np.stack([minus, plus]), minus.shape[1]
        rounded = (1e7 * axes.reshape(len(axes), self.d**2)).round().astype(np.int64)
        corner = np.concatenate([np.repeat(law, k)[:, None], np.repeat(rounded, k, 0)], 1)
        key = np.column_stack([corner[:, 0], minus.ravel(), plus.ravel(), corner[:, 1:]])
        key, first, point = np.unique(key, axis=0, return_index=True, return_inverse=True)
        self.face_points = point.reshape(-1, k)
        self.area = np.bincount(point.ravel(), weight.ravel(), len(first)) * (key[:, 1] != key[:, 2])
        self.pairs = key[:, 1:3].astype(np.int32)
        self.axes = np.zeros((len(first), 3, self.d))
        self.axes[:, : self.d] = np.repeat(axes, k, 0)[first]
        ends = np.searchsorted(key[:, 0], range(len(self.laws) + 1))
        self.parts = [slice(a, b) for a, b in itertools.pairwise(ends)]
        self.s = [np.zeros((p.stop - p.start, 3)) for p in self.parts]
        self.state = [np.zeros((len(s), one.nstatv)) for s, one in zip(self.s, self.laws, strict=True)]

    def _stiffness(self, E: float | Mapping[str, float], nu: float, plane: str) -> None:
        """Matrix of the solids, with room for the joints."""
        d, V = self.d, self.V
        young = fem.Function(fem.functionspace(self.mesh, ("DG", 0)))
        given = E if isinstance(E, Mapping) else dict.fromkeys(self.names, E)
        if missing := set(self.names) - set(given):
            raise ValueError(f"E of {', '.join(given)}: expected one of {', '.join(sorted(missing))}, too")
        values = np.array([given[name] for name in self.names], float)
        young.x.array[young.function_space.dofmap.list.ravel()] = values[self.cell_block]
        u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
        stress = d == 2 and plane == "stress"
        lam, G = young * nu / ((1 - nu**2) if stress else (1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
        e, f = ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))
        form = fem.form((lam * ufl.tr(e) * ufl.tr(f) + 2 * G * ufl.inner(e, f)) * self.thickness * ufl.dx)
        self.K = PETSc.Mat().create(COMM)
        self.K.setSizes(((d * self.n, None),) * 2, d)
        self.K.setType("aij")
        here = np.arange(self.n + self.map.num_ghosts, dtype=np.int32)
        self.K.setLGMap(PETSc.LGMap().create(self.map.local_to_global(here).astype(INT), d, COMM))
        self.K.setUp()
        dof = (self.pairs[:, :, None] * d + np.arange(d)).reshape(-1, 2 * d).astype(INT)
        pointers = (2 * d * np.arange(dof.size + 1)).astype(INT)
        self.where = pointers, np.repeat(dof, 2 * d, 0).ravel(), dof.ravel()
        self._add(self.K, np.zeros(4 * d * d * len(dof)))  # first, while all entries are new
        fp.assemble_matrix(self.K, form)
        self.K.assemble()
        self.K.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        self.scale = float(COMM.allreduce(np.abs(self.K.getDiagonal().array_r).max(initial=0.0), MPI.MAX))
        self._f, self._u = fem.Function(V), fem.Function(V)

    def _add(self, A: PETSc.Mat, values: Floats) -> None:
        """Add the blocks of the pairs of nodes."""
        pointers, columns, rows = self.where
        A.setValuesLocalIJV(pointers, columns, values, ADD, rows)

    def solid(self, *blocks: str) -> Floats:
        """1 at the components of nodes of these blocks, 0 elsewhere, (n d,)."""
        inside = np.isin(self.cell_block, [self.names.index(name) for name in blocks])
        found = np.zeros((self.n + self.map.num_ghosts, self.d))
        found[self.V.dofmap.list[inside]] = 1.0
        return found[: self.n].ravel()

    def body(self, force: Sequence[float]) -> Floats:
        """Nodal forces of a force per volume."""
        form = ufl.inner(fem.Constant(self.mesh, np.array(force, float)), ufl.TestFunction(self.V))
        b = fem.assemble_vector(fem.form(form * self.thickness * ufl.dx))
        b.scatter_reverse(la.InsertMode.add)
        return b.array[: self.n * self.d].copy()

    def forces(self, x: PETSc.Vec, dt: float) -> Floats:
        """Internal forces (n d,); separations and results of the law are kept in `trial`."""
        d = self.d
        u = self.spread(x.array_r).reshape(-1, d)
        f = self._f.x.array.reshape(-1, d)
        f[:] = 0.0
        self.trial: list[tuple[Floats, Update]] = []
        message, begin = "", time.process_time()
        jump = np.einsum("pkd,pd->pk", self.axes, u[self.pairs[:, 1]] - u[self.pairs[:, 0]])
        try:
            for p, law, state, s in zip(self.parts, self.laws, self.state, self.s, strict=True):
                self.trial.append((jump[p], law.update(jump[p], state, s, dt)))
        except ValueError as error:
            message = str(error)
        self.clock += time.process_time() - begin
        if worst := max(COMM.allgather(message)):
            raise LawError(worst)
        traction = np.concatenate([r.traction for _, r in self.trial])
        t = np.einsum("pkd,pk,p->pd", self.axes, traction, self.area)
        np.add.at(f, self.pairs, np.stack([-t, t], 1))
        self._f.x.scatter_reverse(la.InsertMode.add)
        y = x.duplicate()
        self.K.mult(x, y)
        return y.array + f.ravel()[: d * self.n]

    def spread(self, u: Floats) -> Floats:
        """Displacements of the owned nodes and the ghosts."""
        self._u.x.array[: len(u)] = u
        self._u.x.scatter_forward()
        return self._u.x.array

    def tangent(self, A: PETSc.Mat) -> None:
        """Stiffness with the tangents of the last forces."""
        self.K.copy(A, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        tangent = np.concatenate([r.tangent for _, r in self.trial])
        k = np.einsum("pkd,pkl,ple,p->pde", self.axes, tangent, self.axes, self.area, optimize=True)
        self._add(A, np.einsum("ij,pde->pidje", [[1.0, -1.0], [-1.0, 1.0]], k).ravel())
        A.assemble()

    def accept(self, x: PETSc.Vec) -> None:
        """End a step."""
        self.u = x.array_r.copy()
        self.s, self.state = [s for s, _ in self.trial], [r.state for _, r in self.trial]

    def spent(self) -> float:
        """Energy of rupture and friction of all joints."""
        kinds = [contract.statev_index(name) for name in ("rupture", "friction")]
        found = [(self.area[p] @ g[:, kinds]).sum() for p, g in zip(self.parts, self.state, strict=True)]
        return total(sum(found))


class LawError(RuntimeError):
    """The law has no result for a separation."""


def _weights(x: Floats) -> Floats:
    """Shares (f, k) of the corners x (f, k, d) of faces in their area."""
    k = x.shape[1]
    if k == 1:
        return np.zeros(x.shape[:2])
    edge = np.roll(x, -1, axis=1) - x
    if k == 2:
        return 0.5 * np.linalg.norm(edge, axis=2)
    cross = np.linalg.norm(np.cross(edge, np.roll(edge, 1, axis=1)), axis=2)
    return cross / (6 if k == 3 else 4)


def _whole(jointed: Jointed, laws: Mapping[str, Interface]) -> tuple:
    """Cells and nodes of a mesh, and what all ranks need of it."""
    kind, d = ", ".join(jointed.cells), jointed.dimension
    if kind not in BASIX:
        raise ValueError(f"cells of the types {kind}: expected one of {', '.join(BASIX)} for fenicsx")
    if set(laws) != set(jointed.joints):
        raise ValueError(f"laws of {', '.join(laws)}: expected those of {', '.join(jointed.joints)}")
    rows = []
    for name, parts in jointed.joints.items():
        for one in parts:
            law, weight = np.full(len(one.area), list(laws).index(name)), _weights(jointed.points[one.minus])
            rows.append((one.minus, one.plus, law, one.axes, weight, one.cells))
    groups = {}
    for name, some in jointed.groups.items():
        area = np.zeros(len(jointed.points))
        for nodes in some:
            np.add.at(area, nodes, _weights(jointed.points[nodes]))
        groups[name] = jointed.nodes(name), area[jointed.nodes(name)]
    cells = jointed.cells[kind][:, BASIX[kind]].astype(np.int64)
    faces = [np.concatenate(column) for column in zip(*rows, strict=True)]
    return cells, jointed.points, (kind, d, jointed.block[kind], jointed.names, groups, faces)


def _partition(count: int, types: list, cells: list, sides: np.ndarray) -> object:
    """Ranks of the cells here by dolfinx' partitioner, which has the joints as edges, too."""
    dual = cpp.mesh.build_dual_graph(COMM, types, cells, 2)
    if COMM.rank == 0:
        n = len(dual.offsets) - 1
        inside = np.stack([np.repeat(np.arange(n), np.diff(dual.offsets)), dual.array], 1)
        ends = np.concatenate([inside, sides, sides[:, ::-1]])
        ends = ends[np.argsort(ends[:, 0], kind="stable")]
        offsets = np.searchsorted(ends[:, 0], range(n + 1)).astype(np.int32)
        dual = cpp.graph.AdjacencyList_int64(ends[:, 1].copy(), offsets)
    rank = graph.partitioner()(COMM, count, dual, False).array
    if COMM.rank > 0:
        return graph.adjacencylist(np.zeros(0, np.int32), np.zeros(1, np.int32))._cpp_object
    ghost = np.stack([sides[:, 1], rank[sides[:, 0]]], 1)[rank[sides[:, 0]] != rank[sides[:, 1]]]
    rows = np.concatenate([np.stack([np.arange(len(rank)), rank], 1), np.unique(ghost, axis=0)])
    rows = rows[np.argsort(rows[:, 0], kind="stable")]  # the owner comes first
    offsets = np.searchsorted(rows[:, 0], range(len(rank) + 1)).astype(np.int32)
    return graph.adjacencylist(rows[:, 1].astype(np.int32), offsets)._cpp_object


class Steps:
    """Steps of a model under prescribed displacements and loads.

    fixed: owned components that are prescribed.  drag: forces over displacements in a step of the time 1.
    """

    def __init__(
        self,
        model: Model,
        fixed: np.ndarray,
        tolerance: float = 1e-6,
        options: str = "",
        drag: Floats | float = 0.0,
    ) -> None:
        """Set up SNES; tolerance: of the residual over the sum of prescribed forces and loads."""
        self.model, self.fixed, self.tolerance = model, np.unique(fixed), tolerance
        self.drag = np.broadcast_to(drag, model.u.shape) * np.ones(1)
        self.rows = (self.fixed + model.map.local_range[0] * model.d).astype(INT)
        self.load, self.iterations, self.message, self.size = 0.0 * model.u, 0, "", 1.0
        self.reaction = 0.0 * model.u
        database = PETSc.Options()
        database.insertString(f"{OPTIONS} {options}")
        self.snes = PETSc.SNES().create(COMM)
        self.x = model.K.createVecRight()
        self.A = model.K.duplicate()
        self.A.setNearNullSpace(self._rigid())
        self.snes.setFunction(self._residual, self.x.duplicate())
        self.snes.setJacobian(self._jacobian, self.A)
        self.snes.setFromOptions()
        if self.snes.getKSP().getPC().getType() == PETSc.PC.Type.MG:
            self._two_levels()

    def _two_levels(self) -> None:
        """Solve the part of each block on a rank by itself, and the rigid motions of all parts together."""
        m, pc = self.model, self.snes.getKSP().getPC()
        block = np.zeros(m.n + m.map.num_ghosts, np.int64)
        block[m.V.dofmap.list] = m.cell_block[:, None]
        names, part, count = np.unique(block[: m.n], return_inverse=True, return_counts=True)
        motions = np.stack([v.array_r for v in self.A.getNearNullSpace().getVecs()], 1)
        n, w = motions.shape
        first = COMM.scan(len(names) * w) - len(names) * w + w * np.repeat(part, m.d)
        rows = (w * np.arange(n + 1)).astype(INT), (first[:, None] + np.arange(w)).ravel().astype(INT)
        P = PETSc.Mat().createAIJ(((n, None), (len(names) * w, None)), csr=(*rows, motions.ravel()))
        pc.setMGLevels(2)
        pc.setMGInterpolation(1, P)
        nodes = np.split(np.argsort(part, kind="stable"), np.cumsum(count)[:-1])
        dofs = [(m.dofs(one, *range(m.d)) + m.map.local_range[0] * m.d).astype(INT) for one in nodes]
        one_by_one = pc.getMGSmoother(1).getPC()
        one_by_one.setType(PETSc.PC.Type.ASM)
        one_by_one.setASMLocalSubdomains(
            len(dofs), [PETSc.IS().createGeneral(one, PETSc.COMM_SELF) for one in dofs]
        )
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
        self.model.tangent(A)
        if self.drag.any():
            slow = self.x.duplicate()
            slow.array[:] = self.drag / self.dt
            A.setDiagonal(slow, ADD)
        A.zeroRows(self.rows, diag=self.model.scale)

    def solve(self, values: Floats, load: Floats, dt: float = 1.0, ahead: Floats | float = 0.0) -> bool:
        """Solve a step to displacements of the fixed components and loads; whether it converged.

        ahead: guess of the change of the displacements.
        """
        self.values, self.load, self.dt, self.message = values, load, dt, ""
        self.x.array[:] = self.model.u + ahead
        self.size = max(self.size, total(np.abs(load).sum()))
        self.snes.setTolerances(rtol=0.0, atol=self.tolerance * self.size, stol=0.0)
        self.snes.solve(None, self.x)
        self.model.linear += self.snes.getLinearSolveIterations()
        self.iterations, reason = self.snes.getIterationNumber(), self.snes.getConvergedReason()
        if reason <= 0:
            self.message = self.message or f"SNES ends with {reason} after {self.iterations} iterations"
            return False
        self.size = max(total(np.abs(self.reaction[self.fixed]).sum()), total(np.abs(load).sum()), 1e-12)
        self.model.accept(self.x)
        return True


class Follow:
    """Steps along a path whose parameter is `at`; they are cut where they fail.

    conditions: displacements of the fixed components and loads at a value of the parameter.
    """

    def __init__(
        self,
        steps: Steps,
        conditions: Callable[[float], tuple[Floats, Floats]],
        step: float,
        most: float,
        least: float = 1e-5,
    ) -> None:
        """Begin at 0 with a step, which grows up to `most` and is cut down to `least`."""
        self.steps, self.conditions, self.step, self.most, self.least = steps, conditions, step, most, least
        self.at, self.move, self.last = 0.0, 0.0, 0.0 * steps.model.u
        self.cuts, self.taken, self.count, self.reason = 0, 0, 0, ""

    def advance(self, end: float) -> bool:
        """Take one step towards a value, or cut it; whether it was taken."""
        model, left = self.steps.model, end - self.at
        last = abs(left) <= self.step * (1.0 + 1e-6)  # no step of rounding errors is left
        move = left if last else float(np.copysign(self.step, left))
        ahead = self.last * (move / self.move) if self.move * move > 0.0 else 0.0
        before = model.u
        good = self.steps.solve(*self.conditions(end if last else self.at + move), abs(move), ahead)
        self.taken += self.steps.iterations
        if not good:
            self.cuts, self.step = self.cuts + 1, abs(move) / 2.0
            if self.step < self.least:
                self.reason = f"stopped at {self.at:.5g}: {self.steps.message}"
            return False
        self.last, self.move = model.u - before, move
        self.at, self.count = end if last else self.at + move, self.count + 1
        if self.steps.iterations <= FAST:
            self.step = min(GROWTH * self.step, self.most)
        return True

    def save(self, file: Path) -> None:
        """Write what a run goes on from, FILE.RANK.npz."""
        now = np.array([self.at, self.move, self.step, self.cuts, self.taken, self.count, self.steps.size])
        m = self.steps.model
        joints = {f"{name}{k}": one for name in ("s", "state") for k, one in enumerate(getattr(m, name))}
        new = file.with_suffix(f".{COMM.rank}.new.npz")
        np.savez(new, u=m.u, last=self.last, now=now, **joints)
        new.replace(file.with_suffix(f".{COMM.rank}.npz"))  # whole even if the run is ended here

    def resume(self, file: Path) -> None:
        """Go on from the files of a run with the same mesh, laws and ranks."""
        m, found = self.steps.model, dict(np.load(file.with_suffix(f".{COMM.rank}.npz")))
        same = [
            found[f"{name}{k}"].shape == one.shape
            for name in ("s", "state")
            for k, one in enumerate(getattr(m, name))
        ]
        if not COMM.allreduce(bool(all(same) and found["u"].shape == m.u.shape), MPI.LAND):
            raise ValueError(f"{file}: expected the files of a run with the same mesh, laws and ranks")
        m.u, self.last = found["u"], found["last"]
        m.s, m.state = ([found[f"{name}{k}"] for k in range(len(m.laws))] for name in ("s", "state"))
        self.at, self.move, self.step, *counts, self.steps.size = found["now"].tolist()
        self.cuts, self.taken, self.count = map(int, counts)


class Output:
    """Results for ParaView: FILE.pvd, and in a folder FILE the solids and joints of every rank and step."""

    def __init__(self, model: Model, pvd: Path) -> None:
        """Make the folder; FILE must end with .pvd."""
        self.model, self.pvd, self.names, m = model, pvd, [], model
        self.folder = paraview_files.folder_of(pvd)
        kind = {there: here for here, there in NAMES.items()}
        self.kind = kind.get(name := m.mesh.topology.cell_name(), name)
        own = m.mesh.topology.index_map(m.d).size_local
        self.solids = m.V.dofmap.list[:own][:, np.argsort(BASIX[self.kind])]
        x = m.V.tabulate_dof_coordinates()[m.sides]
        self.near = np.ptp(x, axis=0).max((1, 2)) < 1e-9 * np.ptp(m.x)  # those across a period are not drawn
        low, high = m.sides[:, self.near]
        self.joints = np.concatenate([low, high[:, ::-1] if m.d == 2 else high], 1)

    def write(self, time: float) -> None:
        """Write a step: displacements; damage, separation, traction and energies of the joints."""
        m = self.model
        nodes, u = m.V.tabulate_dof_coordinates()[:, : m.d], m.spread(m.u).reshape(-1, m.d)
        results = [law.update(s, state, s, 1.0) for law, s, state in zip(m.laws, m.s, m.state, strict=True)]
        room = contract.N_POINT_STATEV  # laws may have another number of planes
        values = m.s, [r.traction for r in results], [state[:, :room] for state in m.state]
        of_faces = (np.concatenate(one)[m.face_points[self.near]] for one in values)
        step = paraview_files.Step(time, nodes, u, self.kind, self.solids, self.joints, *of_faces)
        files = step.write(self.folder, f"{len(self.names):04}_{COMM.rank}")
        self.names.append((time, [*itertools.chain(*COMM.allgather(files))]))
        if COMM.rank == 0:
            paraview_files.write_collection(self.pvd, self.names)
