"""Elastic solids by UFL and joints by the law at pairs of nodes, shared by the ranks of MPI."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import basix.ufl
import dolfinx.fem.petsc as fp
import numpy as np
import ufl
from dolfinx import fem, la, mesh
from numpy.typing import NDArray
from petsc4py import PETSc
from scipy.sparse import csr_array

from ..contract import Floats
from ..interface import Interface
from ..mesh import Jointed
from ..mesh.shapes import Integers
from .bodies import Bodies
from .distribution import BASIX, NAMES, Group, distributed, partition
from .ranks import COMM, agree, doubles, expect, largest, real, whole_number

INT, ADD = PETSc.IntType, PETSc.InsertMode.ADD_VALUES

POINTS = ("x", "area", "pairs", "axes", "sides", "face_points", "face_joint", "face_cells", "cell_block")
"""Arrays of a model that a caller may read."""


def _check_elastic(
    E: Mapping[str, float], names: Sequence[str], nu: float, thickness: float, plane: str
) -> None:
    """Refuse constants of the solids that are out of range."""
    if missing := [name for name in names if name not in E]:
        raise ValueError(f"E of {', '.join(E)}: expected one of {', '.join(missing)}, too")
    if unknown := [name for name in E if name not in names]:
        raise ValueError(f"E of {unknown[0]}: no such block: expected one of {', '.join(names)}")
    for name, value in E.items():
        if not real(value) or value <= 0.0:
            raise ValueError(f"E of {name} = {value}: expected above 0")
    if not real(nu) or not -1.0 < nu < 0.5:
        raise ValueError(f"nu = {nu}: expected -1 < nu < 0.5")
    if not real(thickness) or thickness <= 0.0:
        raise ValueError(f"thickness = {thickness}: expected above 0")
    if plane not in ("stress", "strain"):
        raise ValueError(f"plane = {plane!r}: expected 'stress' or 'strain'")


class Model:
    """Nodes, solids and joints on this rank; nothing of it changes once it is made.

    x (n, d): owned nodes.  names: of the blocks.  joints: names of the joints, whose laws are `laws`.  Points
    of the joints, in the order of the laws: pairs (p, 2) of nodes, axes (p, 3, d) N, Tx, Ty, area (p,) and
    places (p, d); parts: slices of the points of each joint.  bodies: solids whose cells
    share nodes.  K: matrix of the solids with its
    diagonal (n d,), scale: the largest entry of that.
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
        """Distribute a mesh, which rank 0 has; laws: of its joints; E: of all solids, or by block.

        thickness: of a plane mesh.  Forces and areas of a body of revolution are those of the whole
        turn; its nodes at r = 0 need u_r = 0.
        """
        expect(Mapping, laws=laws)
        expect(Interface, **{f"laws of {name}": law for name, law in laws.items()})
        cells, points, shared, message = None, None, None, ""
        if COMM.rank == 0:
            try:
                if not isinstance(jointed, Jointed):
                    kind = type(jointed).__name__
                    raise ValueError(f"mesh of the type {kind}: expected Jointed, as of asperity.mesh.split")
                cells, points, shared = distributed(jointed, laws)
            except ValueError as error:
                message = str(error)
        agree(message)
        kind, d, turned, block, names, groups, faces, bodies = COMM.bcast(shared)
        self.names: list[str] = names
        self.groups: dict[str, Group] = groups
        young = dict(E) if isinstance(E, Mapping) else dict.fromkeys(self.names, E)
        _check_elastic(young, self.names, nu, thickness, plane)
        minus, plus, law, axes, weight, sides, places, corners = faces
        self.laws, self.joints, self.d = list(laws.values()), list(laws), int(d)
        self.props = [one.props() for one in self.laws]
        if (turned or d == 3) and thickness != 1.0:
            whole = "of a body of revolution, which is whole" if turned else "in 3D, where the mesh has it"
            raise ValueError(f"thickness = {thickness}: expected 1 {whole}")
        self.thickness = thickness
        self.axisymmetric: bool = turned
        if COMM.rank > 0:
            cells, points = np.zeros((0, len(BASIX[kind])), np.int64), np.zeros((0, d))
        element = basix.ufl.element("Lagrange", NAMES.get(kind, kind), 1, shape=(d,))
        parts = (
            None
            if COMM.size == 1
            else lambda comm, count, types, cells: partition(count, types, cells, sides)
        )
        self.mesh = m = mesh.create_mesh(COMM, cells, ufl.Mesh(element), points, parts)
        self.V = fem.functionspace(m, ("Lagrange", 1, (d,)))
        self.map = self.V.dofmap.index_map
        self.n: int = self.map.size_local
        self.x: Floats = self.V.tabulate_dof_coordinates()[: self.n, :d].copy()
        # local numbers of cells and nodes
        original = m.topology.original_cell_index
        self.cell_block: Integers = block[original]
        body = np.zeros(self.n + self.map.num_ghosts, np.int64)
        body[self.V.dofmap.list] = bodies[original][:, None]
        self.bodies = Bodies(body[: self.n], int(bodies.max()) + 1, self.x, self.axisymmetric)
        order = np.argsort(original)
        at = np.minimum(np.searchsorted(original[order], sides[:, 0]), len(order) - 1)
        here = order[at]
        mine = (original[here] == sides[:, 0]) & (here < m.topology.index_map(d).size_local)
        node = np.empty(len(m.geometry.input_global_indices), np.int64)
        node[m.geometry.dofmap.ravel()] = self.V.dofmap.list.ravel()
        self._order = np.argsort(m.geometry.input_global_indices)
        self._known = m.geometry.input_global_indices[self._order]
        self._node = node[self._order]
        # of the faces on all ranks: joint, places, corners, and whether a face is here
        self.faces = law, places, corners, mine
        self.face_cells: Integers = block[sides[mine]]
        minus, plus, law, axes, weight = (column[mine] for column in (minus, plus, law, axes, weight))
        self.face_joint: Integers = law
        self._points(self.local(minus), self.local(plus), law, axes, self.thickness * weight)
        self._operators()
        self._stiffness(young, nu, plane)
        for name in (*POINTS, "places"):
            getattr(self, name).flags.writeable = False
        self._made = True

    def __setattr__(self, name: str, value: object) -> None:
        """Refuse a change of a model that is made."""
        if getattr(self, "_made", False):
            raise AttributeError(f"{name}: a Model does not change once it is made")
        super().__setattr__(name, value)

    def around(self, x: Any) -> Any:
        """Thickness at places x (d, ...), arrays or of UFL: 2 pi r of a body of revolution."""
        return 2.0 * np.pi * x[0] if self.axisymmetric else self.thickness

    def local(self, nodes: Integers) -> Integers:
        """Local numbers of nodes of the mesh that this rank has."""
        found: Integers = self._node[np.searchsorted(self._known, nodes)]
        return found

    def owned(self, nodes: Integers) -> tuple[Integers, NDArray[np.bool_]]:
        """Local numbers of those nodes of the mesh that this rank owns, and which these are."""
        at = np.minimum(np.searchsorted(self._known, nodes), len(self._known) - 1)
        local: Integers = np.where(self._known[at] == nodes, self._node[at], self.n)
        return local[local < self.n], np.asarray(local < self.n)

    def group(self, name: str) -> tuple[Integers, Floats]:
        """Owned nodes of a group, and their shares in its area."""
        if name not in self.groups:
            raise ValueError(f"{name}: no such group: expected one of {', '.join(self.groups)}")
        local, here = self.owned(self.groups[name].nodes)
        return local, self.thickness * self.groups[name].area[here]

    def dofs(self, nodes: Integers, *components: int) -> Integers:
        """Components of owned nodes, as indices or a mask of them."""
        nodes = np.asarray(nodes)
        if not components:
            raise ValueError(f"no components: expected one or more, of 0 to {self.d - 1}")
        if bad := [k for k in components if not whole_number(k, 0) or k >= self.d]:
            raise ValueError(f"component {bad[0]}: expected 0 to {self.d - 1} in {self.d}D")
        if nodes.ndim != 1 or (len(nodes) and nodes.dtype.kind not in "biu"):
            text = f"nodes of the type {nodes.dtype} and the shape {nodes.shape}"
            raise ValueError(f"{text}: expected a row of indices, or a mask")
        if nodes.dtype == bool:
            if nodes.shape != (self.n,):
                raise ValueError(f"a mask of the shape {nodes.shape}: expected one for {self.n} nodes")
            nodes = np.flatnonzero(nodes)
        if len(nodes) and not 0 <= nodes.min() <= nodes.max() < self.n:
            raise ValueError(f"nodes {nodes.min()} to {nodes.max()}: expected owned ones, 0 to {self.n - 1}")
        return (nodes[:, None] * self.d + np.array(components, np.int64)).ravel().astype(np.int64)

    def _points(self, minus: Integers, plus: Integers, law: Integers, axes: Floats, weight: Floats) -> None:
        """Points at the pairs of nodes; those of faces with the same law, nodes and axes are one point."""
        self.sides, k = np.stack([minus, plus]), minus.shape[1]
        rounded = (1e7 * axes.reshape(len(axes), self.d**2)).round().astype(np.int64)
        corner = np.concatenate([np.repeat(law, k)[:, None], np.repeat(rounded, k, 0)], 1)
        key = np.column_stack([corner[:, 0], minus.ravel(), plus.ravel(), corner[:, 1:]])
        key, first, point = np.unique(key, axis=0, return_index=True, return_inverse=True)
        self.face_points: Integers = point.reshape(-1, k)
        self.area: Floats = np.bincount(point.ravel(), weight.ravel(), len(first)) * (key[:, 1] != key[:, 2])
        self.pairs: Integers = key[:, 1:3].copy()
        self.axes: Floats = np.zeros((len(first), 3, self.d))
        self.axes[:, : self.d] = np.repeat(axes, k, 0)[first]
        ends = np.searchsorted(key[:, 0], range(len(self.laws) + 1))
        self.parts = [slice(int(a), int(b)) for a, b in itertools.pairwise(ends)]
        self.places: Floats = self.V.tabulate_dof_coordinates()[self.pairs[:, 0], : self.d].copy()

    def _operators(self) -> None:
        """Matrices from displacements here, with those of ghosts, to separations, and back to forces."""
        d, count = self.d, len(self.pairs)
        side, point, axis, component = np.indices((2, count, 3, d)).reshape(4, -1)
        values = np.where(side == 0, -1.0, 1.0) * self.axes[point, axis, component]
        kept = (values != 0.0) & (self.area[point] > 0.0)
        rows, columns = 3 * point + axis, self.pairs[point, side] * d + component
        shape = 3 * count, (self.n + self.map.num_ghosts) * d
        self._apart = csr_array((values[kept], (rows[kept], columns[kept])), shape=shape)
        weighted = values * self.area[point]
        self._pull = csr_array((weighted[kept], (columns[kept], rows[kept])), shape=shape[::-1])

    def _stiffness(self, E: Mapping[str, float], nu: float, plane: str) -> None:
        """Matrix of the solids."""
        d, V = self.d, self.V
        young = fem.Function(fem.functionspace(self.mesh, ("DG", 0)))
        values = np.array([E[name] for name in self.names], float)
        young.x.array[young.function_space.dofmap.list.ravel()] = values[self.cell_block]
        u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
        stress = d == 2 and plane == "stress" and not self.axisymmetric
        lam, G = young * nu / ((1 - nu**2) if stress else (1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
        e, f, x = ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v)), ufl.SpatialCoordinate(self.mesh)
        hoop = (u[0] / x[0], v[0] / x[0]) if self.axisymmetric else (0, 0)
        work = lam * (ufl.tr(e) + hoop[0]) * (ufl.tr(f) + hoop[1])
        work += 2 * G * (ufl.inner(e, f) + hoop[0] * hoop[1])
        form = fem.form(work * self.around(x) * ufl.dx)
        self.K = fp.assemble_matrix(form)
        self.K.assemble()
        self.diagonal: Floats = self.K.getDiagonal().array_r.copy()
        self.scale = largest(self.diagonal)
        # room of their own for sums over ranks: their content is nobody's
        self._f, self._u = fem.Function(V), fem.Function(V)
        self._in, self._out = self.K.createVecs()

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

    def inside(self, blocks: Sequence[str]) -> Any:
        """1 in the cells of these blocks, 0 elsewhere; without names 1 in all."""
        indicator = fem.Function(fem.functionspace(self.mesh, ("DG", 0)))
        inside = np.isin(self.cell_block, self._numbers(blocks or self.names))
        indicator.x.array[indicator.function_space.dofmap.list.ravel()] = inside
        return indicator

    def faces_inside(self, blocks: Sequence[str]) -> NDArray[np.bool_]:
        """Which faces of joints here have these blocks on both sides; without names all."""
        return np.asarray(np.isin(self.face_cells, self._numbers(blocks or self.names)).all(1))

    def body(self, force: Sequence[float] | Floats, *blocks: str) -> Floats:
        """Nodal forces of a force per volume, (d,), in these blocks; default: in all."""
        vector = doubles("force", force)
        if vector.shape != (self.d,) or not np.isfinite(vector).all():
            raise ValueError(f"force {vector.tolist()}: expected {self.d} finite components")
        form = ufl.inner(fem.Constant(self.mesh, vector.copy()), ufl.TestFunction(self.V))
        return self.assembled(self.inside(blocks) * form)

    def assembled(self, form: Any) -> Floats:
        """Nodal forces of a virtual work per volume."""
        around = self.around(ufl.SpatialCoordinate(self.mesh))
        b = fem.assemble_vector(fem.form(form * around * ufl.dx))
        b.scatter_reverse(la.InsertMode.add)
        forces: Floats = b.array[: self.n * self.d].copy()
        return forces

    def spread(self, u: Floats) -> Floats:
        """Displacements of the owned nodes and the ghosts."""
        if COMM.size == 1:
            return u
        self._u.x.array[: len(u)] = u
        self._u.x.scatter_forward()
        spread: Floats = self._u.x.array.copy()
        return spread

    def gathered(self, f: Floats) -> Floats:
        """Forces on the owned nodes, of those that each rank has on its nodes and ghosts."""
        if COMM.size == 1:
            return f
        self._f.x.array[:] = f
        self._f.x.scatter_reverse(la.InsertMode.add)
        gathered: Floats = self._f.x.array[: self.d * self.n].copy()
        return gathered

    def separations(self, u: Floats) -> Floats:
        """Separations (p, 3) of the points at displacements (n d,)."""
        return np.asarray(self._apart @ self.spread(u)).reshape(-1, 3)

    def pulled(self, traction: Floats) -> Floats:
        """Nodal forces (n d,) of tractions (p, 3) of the points."""
        return self.gathered(np.asarray(self._pull @ traction.ravel()))

    def stiff(self, u: Floats) -> Floats:
        """Forces of the solids at displacements, or velocities, (n d,)."""
        self._in.array[:] = u
        self.K.mult(self._in, self._out)
        forces: Floats = self._out.array_r.copy()
        return forces
