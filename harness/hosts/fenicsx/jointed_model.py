"""Elastic solids by UFL and joints by the law at pairs of nodes, shared by the ranks of MPI."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Mapping, Sequence

from jointed_mesh import BASIX, COMM, NAMES, agree, distributed, doubles, partition, total  # isort: skip  # loads MPI
import basix.ufl
import dolfinx.fem.petsc as fp
import numpy as np
import ufl
from asperity import contract
from asperity.contract import Floats
from asperity.interface import Interface, Update
from asperity.mesh import Jointed
from dolfinx import fem, la, mesh
from jointed_water import ROUNDING, Flow, Pressure, Water
from mpi4py import MPI
from numpy.typing import ArrayLike
from petsc4py import PETSc

INT, ADD = PETSc.IntType, PETSc.InsertMode.ADD_VALUES


class LawError(RuntimeError):
    """The law has no result for a separation."""


def _check_elastic(
    E: dict[str, float], names: Sequence[str], nu: float, thickness: float, plane: str
) -> None:
    """Refuse constants of the solids that are out of range."""
    if missing := [name for name in names if name not in E]:
        raise ValueError(f"E of {', '.join(E)}: expected one of {', '.join(missing)}, too")
    if unknown := [name for name in E if name not in names]:
        raise ValueError(f"E of {unknown[0]}: no such block: expected one of {', '.join(names)}")
    for name, value in E.items():
        if not 0.0 < value < np.inf:
            raise ValueError(f"E of {name} = {value}: expected above 0")
    if not -1.0 < nu < 0.5:
        raise ValueError(f"nu = {nu}: expected -1 < nu < 0.5")
    if not 0.0 < thickness < np.inf:
        raise ValueError(f"thickness = {thickness}: expected above 0")
    if plane not in ("stress", "strain"):
        raise ValueError(f"plane = {plane!r}: expected 'stress' or 'strain'")


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
        cells, points, shared, message = None, None, None, ""
        if COMM.rank == 0:
            try:
                cells, points, shared = distributed(jointed, laws)
            except ValueError as error:
                message = str(error)
        agree(message)
        kind, d, block, self.names, self.groups, faces = COMM.bcast(shared)
        young = dict(E) if isinstance(E, Mapping) else dict.fromkeys(self.names, E)
        _check_elastic(young, self.names, nu, thickness, plane)
        minus, plus, law, axes, weight, sides, places, corners = faces
        self.laws, self.joints, self.d = list(laws.values()), list(laws), d
        self.thickness = thickness if d == 2 else 1.0
        if COMM.rank > 0:
            cells, points = np.zeros((0, len(BASIX[kind])), np.int64), np.zeros((0, d))
        element = basix.ufl.element("Lagrange", NAMES.get(kind, kind), 1, shape=(d,))
        parts = None if COMM.size == 1 else lambda *words: partition(*words[1:], sides)
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
        of_all = law, places, corners, mine
        self.face_cells = block[sides[mine]]
        minus, plus, law, axes, weight = (column[mine] for column in (minus, plus, law, axes, weight))
        self.face_joint = law
        self._points(self.local(minus), self.local(plus), law, axes, self.thickness * weight)
        self._stiffness(young, nu, plane)
        self.u, self.clock, self.linear = np.zeros(self.n * d), 0.0, 0
        self.water, self.stressed = Water(self, of_all), 0.0 * self.u
        self.aim: list[Floats] | None = None

    def local(self, nodes: np.ndarray) -> np.ndarray:
        """Local numbers of nodes of the mesh that this rank has."""
        return self._node[np.searchsorted(self._known, nodes)].astype(np.int32)

    def owned(self, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Local numbers of those nodes of the mesh that this rank owns, and which these are."""
        at = np.minimum(np.searchsorted(self._known, nodes), len(self._known) - 1)
        local = np.where(self._known[at] == nodes, self._node[at], self.n)
        return local[local < self.n], local < self.n

    def group(self, name: str) -> tuple[np.ndarray, Floats]:
        """Owned nodes of a group, and their shares in its area."""
        if name not in self.groups:
            raise ValueError(f"{name}: no such group: expected one of {', '.join(self.groups)}")
        local, here = self.owned(self.groups[name].nodes)
        return local, self.thickness * self.groups[name].area[here]

    def dofs(self, nodes: np.ndarray, *components: int) -> np.ndarray:
        """Components of owned nodes, as indices or a mask of them."""
        nodes = np.asarray(nodes)
        if bad := [component for component in components if component not in range(self.d)]:
            raise ValueError(f"component {bad[0]}: expected 0 to {self.d - 1} in {self.d}D")
        if nodes.dtype == bool:
            if nodes.shape != (self.n,):
                raise ValueError(f"a mask of the shape {nodes.shape}: expected one for {self.n} nodes")
            nodes = np.flatnonzero(nodes)
        if len(nodes) and not 0 <= nodes.min() <= nodes.max() < self.n:
            raise ValueError(f"nodes {nodes.min()} to {nodes.max()}: expected owned ones, 0 to {self.n - 1}")
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
        self.state = [np.zeros((len(s), law.nstatv)) for s, law in zip(self.s, self.laws, strict=True)]

    def _stiffness(self, E: Mapping[str, float], nu: float, plane: str) -> None:
        """Matrix of the solids, with room for the joints."""
        d, V = self.d, self.V
        young = fem.Function(fem.functionspace(self.mesh, ("DG", 0)))
        values = np.array([E[name] for name in self.names], float)
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

    def _numbers(self, blocks: Sequence[str]) -> list[int]:
        """Numbers of blocks."""
        if unknown := [name for name in blocks if name not in self.names]:
            raise ValueError(f"{unknown[0]}: no such block: expected one of {', '.join(self.names)}")
        return [self.names.index(name) for name in blocks]

    def solid(self, *blocks: str) -> Floats:
        """1 at the components of nodes of these blocks, 0 elsewhere, (n d,)."""
        inside = np.isin(self.cell_block, self._numbers(blocks))
        mask = np.zeros((self.n + self.map.num_ghosts, self.d))
        mask[self.V.dofmap.list[inside]] = 1.0
        return mask[: self.n].ravel()

    def _inside(self, blocks: Sequence[str]) -> fem.Function:
        """1 in the cells of these blocks, 0 elsewhere; without names 1 in all."""
        indicator = fem.Function(fem.functionspace(self.mesh, ("DG", 0)))
        inside = np.isin(self.cell_block, self._numbers(blocks or self.names))
        indicator.x.array[indicator.function_space.dofmap.list.ravel()] = inside
        return indicator

    def body(self, force: Sequence[float], *blocks: str) -> Floats:
        """Nodal forces of a force per volume, (d,), in these blocks; default: in all."""
        vector = doubles("force", force)
        if vector.shape != (self.d,) or not np.isfinite(vector).all():
            raise ValueError(f"force {vector.tolist()}: expected {self.d} finite components")
        form = ufl.inner(fem.Constant(self.mesh, vector.copy()), ufl.TestFunction(self.V))
        return self._assembled(self._inside(blocks) * form)

    def _assembled(self, form: ufl.Form) -> Floats:
        """Nodal forces of a virtual work per volume."""
        b = fem.assemble_vector(fem.form(form * self.thickness * ufl.dx))
        b.scatter_reverse(la.InsertMode.add)
        return b.array[: self.n * self.d].copy()

    def pressure(self, name: str, p: Pressure) -> None:
        """Give the pressure of water, >= 0, in a joint, on both of its sides, or on a group of faces.

        p: a number, or a function of places (n, d) that returns n of them or one.  In a joint it may be a
        function of places and openings s_N (n,): each step then repeats its equilibrium until p belongs to
        the openings.  Tractions of the joints are total: the law carries t_N + p.
        """
        self.water.give(name, p)

    def flow(
        self,
        joints: str | Sequence[str],
        given: Mapping[str, Pressure],
        viscosity: float,
        a_0: float | Mapping[str, float] = 0.0,
        a_min: float = 0.0,
        weight: Sequence[float] | None = None,
    ) -> Flow:
        """Let water flow along joints, q = -a^3/(12 viscosity) (grad p - weight), steady with every step.

        a = max(a_min, a_0 + s_N) is the aperture; a_0 may be given by joint.  given: pressures by group,
        where its nodes are those of the joints.  weight: of the water, force per volume (d,).  The flow goes
        through where the joints meet and replaces an earlier one along the same joints.  Raises ValueError
        where nodes of a joint are cut off from every given pressure.
        """
        return self.water.flow(joints, given, viscosity, a_0, a_min, weight)

    def initial(
        self,
        stress: ArrayLike | Callable[[Floats], Floats],
        *blocks: str,
        damage: float = 0.0,
    ) -> None:
        """Give the solids an initial stress, tension positive, before the first step.

        stress: (d, d), or a function of places (n, d) that returns (n, d, d), linear in each cell.  blocks:
        all by default.  Joints inside them carry the total traction of this stress at zero separation, with a
        damage of their planes and the pressure that they have; raises ValueError where they cannot.
        """
        agree("initial stress: expected before the first step" if np.any(self.u) else "")
        size = self.d, self.d

        def tensors(x: Floats) -> Floats:
            values, message = doubles("stress", stress(x) if callable(stress) else stress), ""
            if values.shape not in (size, (len(x), *size)):
                message = f"stress of the shape {values.shape}: expected {size} or {(len(x), *size)}"
            elif not np.isfinite(values).all() or (
                np.abs(values - values.swapaxes(-1, -2)).max(initial=0.0)
                > 1e-9 * np.abs(values).max(initial=0.0)
            ):
                message = "stress: expected finite, symmetric components"
            agree(message)
            return np.broadcast_to(values, (len(x), *size))

        given = fem.Function(fem.functionspace(self.mesh, ("DG", 1, size)))
        given.interpolate(lambda x: tensors(x[: self.d].T).reshape(-1, self.d**2).T)
        virtual = ufl.grad(ufl.TestFunction(self.V))
        self.stressed = self._assembled(self._inside(blocks) * ufl.inner(given, virtual))
        inside = np.isin(self.face_cells, self._numbers(blocks or self.names)).all(1)
        stressed = np.zeros(len(self.pairs), bool)
        stressed[self.face_points[inside]] = True
        stressed &= self.area > 0.0
        # nodal forces as those of the solids beside, for no other ones balance them
        places, shares = self.water.quadrature()
        axes = self.axes[self.face_points[:, 0]]
        on = np.einsum(
            "fqij,fj->fqi", tensors(places.reshape(-1, self.d)).reshape(*places.shape, -1), axes[:, 0]
        )
        traction = np.zeros((len(self.pairs), 3))
        forces = np.einsum("fqk,fqd,fcd->fkc", self.thickness * shares, on, axes, optimize=True)
        np.add.at(traction, self.face_points[inside], forces[inside])
        traction /= np.where(self.area > 0.0, self.area, np.inf)[:, None]
        free = traction + np.outer(self.water.p, [1.0, 0.0, 0.0])
        free = np.abs(free).max(1) <= ROUNDING * np.abs(traction).max(initial=0.0)  # as at the surface
        traction[free] = np.outer(-self.water.p[free], [1.0, 0.0, 0.0])
        message = ""
        for k, (p, law) in enumerate(zip(self.parts, self.laws, strict=True)):
            at = stressed[p]
            try:
                self.state[k][at] = law.initial(traction[p][at], damage, p=self.water.p[p][at])
            except ValueError as error:
                message = message or f"{self.joints[k]}: {error}"
        agree(message)

    def forces(self, x: PETSc.Vec, dt: float) -> Floats:
        """Internal forces (n d,); separations and results of the law are kept in `trial`.

        With an `aim`, separations by law, damage, bounds of friction and slopes are those of the law there.
        """
        d = self.d
        u = self.spread(x.array_r).reshape(-1, d)
        f = self._f.x.array.reshape(-1, d)
        f[:] = 0.0
        self.trial: list[tuple[Floats, Update]] = []
        message, begin = "", time.process_time()
        jump = np.einsum("pkd,pd->pk", self.axes, u[self.pairs[:, 1]] - u[self.pairs[:, 0]])
        try:
            for k, (p, law) in enumerate(zip(self.parts, self.laws, strict=True)):
                aim, water = None if self.aim is None else self.aim[k], self.water.p[p]
                new = law.update(jump[p], self.state[k], self.s[k], dt, aim=aim, p=water)
                self.trial.append((jump[p], new))
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
        return y.array + f.ravel()[: d * self.n] + self.stressed

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

    def frozen(self, dt: float) -> tuple[float, float]:
        """Errors of the last forces by their aim: largest of a damage, sum of those of nodal forces."""
        damage, force = 0.0, 0.0
        for k, (p, law) in enumerate(zip(self.parts, self.laws, strict=True)):
            s, result = self.trial[k]
            taken, true = (
                law.update(separation, self.state[k], self.s[k], dt, p=self.water.p[p])
                for separation in (self.aim[k], s)
            )
            first, step = contract.N_POINT_STATEV, contract.N_PLANE_STATEV
            planes = slice(first, first + step * law.n_planes, step)
            alpha = (true.state[:, planes], taken.state[:, planes])
            damage = max(damage, np.abs(np.subtract(*alpha)).max(initial=0.0))
            error = np.linalg.norm(true.traction - result.traction, axis=1)
            force += float(self.area[p] @ error)
        return COMM.allreduce(float(damage), MPI.MAX), total(force)

    def accept(self, x: PETSc.Vec) -> None:
        """End a step."""
        self.u = x.array_r.copy()
        self.s, self.state = [s for s, _ in self.trial], [r.state for _, r in self.trial]

    def spent(self) -> float:
        """Energy of rupture and friction of all joints."""
        kinds = [contract.statev_index(name) for name in ("rupture", "friction")]
        spent = [(self.area[p] @ g[:, kinds]).sum() for p, g in zip(self.parts, self.state, strict=True)]
        return total(sum(spent))
