"""Distribution of a mesh with joints over the ranks of MPI.

A joint belongs to the rank of its cell on the minus side, which has the cell on the plus side as a ghost.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from dolfinx import cpp, graph
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..contract import Floats
from ..interface import Interface
from ..mesh import Jointed
from ..mesh.shapes import FACES, Integers
from .ranks import COMM

BASIX = {
    "triangle": [0, 1, 2], "quad": [0, 1, 3, 2], "tetra": [0, 1, 2, 3],
    "hexahedron": [0, 1, 3, 2, 4, 5, 7, 6],
}  # fmt: skip
"""Nodes of the cells of meshio in the order of dolfinx."""

NAMES = {"quad": "quadrilateral", "tetra": "tetrahedron"}
"""Names of cells in dolfinx, where meshio has others."""


def _weights(x: Floats, turned: bool) -> Floats:
    """Shares (f, k) of the corners x (f, k, d) of faces in their area; turned: of surfaces of revolution."""
    k = x.shape[1]
    if k == 1:
        return np.zeros(x.shape[:2])
    edge = np.roll(x, -1, axis=1) - x
    if k == 2:
        r = x[:, :, 0]
        width = 2.0 * np.pi * (2.0 * r + np.roll(r, 1, axis=1)) / 3.0 if turned else 1.0
        return np.asarray(0.5 * np.linalg.norm(edge, axis=2) * width)
    cross = np.linalg.norm(np.cross(edge, np.roll(edge, 1, axis=1)), axis=2)
    return np.asarray(cross / (6 if k == 3 else 4))


@dataclass(frozen=True)
class Group:
    """A group on all ranks: nodes, their shares in its area, and their places before joints doubled them.

    faces (f, k): nodes of its faces, right-handed about the normal out of the cells; corners (f, k, d).
    message: why they cannot carry a pressure.
    """

    nodes: Integers
    area: Floats
    places: Integers
    faces: Integers
    corners: Floats
    message: str


def _group(jointed: Jointed, name: str) -> Group:
    nodes, area = jointed.nodes(name), np.zeros(len(jointed.points))
    for face_nodes in jointed.groups[name]:
        np.add.at(area, face_nodes, _weights(jointed.points[face_nodes], jointed.axisymmetric))
    faces, message = np.zeros((0, 2), np.int64), "expected a group of faces"
    if name in jointed.surfaces:
        [faces] = jointed.face_nodes(jointed.surfaces[name])
        [(kind, cells)] = jointed.cells.items()
        near = cells[np.isin(cells, nodes).sum(1) >= faces.shape[1]]
        all_faces = np.sort(np.concatenate([near[:, list(face)] for face in FACES[kind]]))
        known, count = np.unique(all_faces, axis=0, return_counts=True)
        inner = len({*map(tuple, known[count > 1].tolist())} & {*map(tuple, np.sort(faces).tolist())})
        message = f"{inner} of its {len(faces)} faces are inside the solids" if inner else ""
    corners = jointed.points[faces]
    return Group(nodes, area[nodes], jointed.origin[nodes], faces, corners, message)


def distributed(jointed: Jointed, laws: Mapping[str, Interface]) -> tuple[Integers, Floats, Any]:
    """Cells and nodes of a mesh, and what all ranks need of it."""
    kind, d = ", ".join(jointed.cells), jointed.dimension
    if kind not in BASIX:
        raise ValueError(f"cells of the types {kind}: expected one type for fenicsx, of {', '.join(BASIX)}")
    if set(laws) != set(jointed.joints):
        raise ValueError(f"laws of {', '.join(laws)}: expected those of {', '.join(jointed.joints)}")
    rows = []
    for name, parts in jointed.joints.items():
        for part in parts:
            law, weight = (
                np.full(len(part.area), list(laws).index(name)),
                _weights(jointed.points[part.minus], jointed.axisymmetric),
            )
            places, corners = jointed.origin[part.minus], jointed.points[part.minus]
            rows.append((part.minus, part.plus, law, part.axes, weight, part.cells, places, corners))
    groups = {name: _group(jointed, name) for name in jointed.groups}
    cells = jointed.cells[kind][:, BASIX[kind]].astype(np.int64)
    faces = [np.concatenate(column) for column in zip(*rows, strict=True)]
    ends = cells.ravel(), np.repeat(cells[:, 0], cells.shape[1])
    links = coo_array((np.ones(cells.size, np.int8), ends), shape=(len(jointed.points),) * 2)
    _, body = connected_components(links, directed=False)
    bodies = body[cells[:, 0]].astype(np.int64)
    shared = kind, d, jointed.axisymmetric, jointed.block[kind], jointed.names, groups, faces, bodies
    return cells, jointed.points, shared


def partition(count: int, types: list[Any], cells: list[Any], sides: Integers) -> object:
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
