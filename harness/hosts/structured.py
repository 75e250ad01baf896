"""Structured meshes: the cells between lines along each axis, for the structures and tests of the hosts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import permutations

import meshio
import numpy as np
from asperity.contract import Floats
from asperity.mesh.shapes import Integers
from numpy.typing import ArrayLike

AROUND = {
    2: ((0,), (1,)),
    4: ((0, 0), (1, 0), (1, 1), (0, 1)),
    8: tuple((a, b, c) for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))),
}
"""Corners of a cell in the order of its nodes, by position along each axis of the cell."""

KINDS = {2: "line", 4: "quad", 8: "hexahedron"}
"""Cells by their number of nodes."""

QUADRATIC = {
    "triangle6": "01 12 20", "quad8": "01 12 23 30", "tetra10": "01 12 20 03 13 23",
    "hexahedron20": "01 12 23 30 45 56 67 74 04 15 26 37",
}  # fmt: skip
"""Edges of a cell in the order of the nodes in their middles."""

SIDES = ("left", "right", "bottom", "top", "front", "back")
"""Groups of the faces at the ends of the first, the last and the second of three axes."""


def grid_cells(parts: Sequence[int]) -> Integers:
    """Nodes of the cells of a grid, whose nodes along the last axis change fastest."""
    shape = [n + 1 for n in parts]
    grid = np.arange(np.prod(shape)).reshape(shape)
    cut = slice(None, -1), slice(1, None)
    return np.stack([grid[tuple(cut[a] for a in at)].ravel() for at in AROUND[2 ** len(shape)]], axis=-1)


def grid(
    *axes: ArrayLike,
    block: ArrayLike = 0,
    names: Mapping[str, int] | None = None,
    sides: Sequence[str] = SIDES,
) -> meshio.Mesh:
    """Mesh between lines; block: tags of the cells (n, m, ...), names: of tags, sides: of the groups."""
    d, parts = len(axes), [len(np.asarray(axis)) - 1 for axis in axes]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, d).astype(float)
    number = np.arange(len(points)).reshape([n + 1 for n in parts])
    cells, tags = [grid_cells(parts)], [np.broadcast_to(block, parts).ravel().astype(int)]
    groups = {}
    for k, name in enumerate(sides[: 2 * d]):
        axis = (0, d - 1, 1)[k // 2]
        face = grid_cells(parts[:axis] + parts[axis + 1 :])
        cells.append(number.take(-(k % 2), axis).ravel()[face])
        tags.append(np.full(len(face), -1 - k))
        groups[name] = np.array([-1 - k, d - 1])
    groups |= {name: np.array([tag, d]) for name, tag in (names or {}).items()}
    kinds = [(KINDS[nodes.shape[1]], nodes) for nodes in cells]
    return meshio.Mesh(points, kinds, cell_data={"gmsh:physical": tags}, field_data=groups)


def simplices(points: Floats, cells: Integers) -> Integers:
    """Triangles or tetrahedra in the cells of a grid: paths of edges between opposite corners."""
    d = points.shape[1]
    corner = {at: k for k, at in enumerate(AROUND[2**d])}
    steps = [np.eye(d, dtype=int)[list(order)] for order in permutations(range(d))]
    paths = [[corner[tuple(at)] for at in np.cumsum([[0] * d, *moves], axis=0).tolist()] for moves in steps]
    corners = cells[:, paths].reshape(-1, d + 1)
    wrong = np.linalg.det(points[corners[:, 1:]] - points[corners[:, :1]]) < 0.0
    corners[wrong, :2] = corners[wrong, 1::-1]
    return corners
