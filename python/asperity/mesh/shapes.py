"""Cells of meshio that are read and written: their faces, corners and orientation."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ..contract import Floats

Integers = NDArray[np.int64]

_HEXAHEDRON = ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_MIDDLES = (
    (8, 9, 10, 11), (12, 13, 14, 15), (8, 17, 12, 16), (9, 18, 13, 17), (10, 19, 14, 18), (11, 16, 15, 19),
)  # fmt: skip

FACES: dict[str, tuple[tuple[int, ...], ...]] = {
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "triangle6": ((0, 1, 3), (1, 2, 4), (2, 0, 5)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "quad8": ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7)),
    "quad9": ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7)),
    "tetra": ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)),
    "tetra10": ((0, 1, 2, 4, 5, 6), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (0, 2, 3, 6, 9, 7)),
    "wedge": ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "hexahedron": _HEXAHEDRON,
    "hexahedron20": tuple(a + b for a, b in zip(_HEXAHEDRON, _MIDDLES, strict=True)),
}
"""Nodes of the faces of a cell, as Abaqus' S1, S2, ...: corners around it, then the middles of its edges."""

FACETS = {
    (2, 2): "line",
    (2, 3): "line3",
    (3, 3): "triangle",
    (3, 4): "quad",
    (3, 6): "triangle6",
    (3, 8): "quad8",
}
"""Cells that are faces, by the dimension of the solids and the number of nodes."""

PLANE = ("triangle", "triangle6", "quad", "quad8", "quad9")
"""Cells of plane meshes; in a mesh with solids they are faces."""

MIRRORED = {
    "triangle": (0, 2, 1), "triangle6": (0, 2, 1, 5, 4, 3), "quad": (0, 3, 2, 1),
    "quad8": (0, 3, 2, 1, 7, 6, 5, 4), "quad9": (0, 3, 2, 1, 7, 6, 5, 4, 8), "tetra": (0, 2, 1, 3),
    "tetra10": (0, 2, 1, 3, 6, 5, 4, 7, 9, 8), "wedge": (3, 4, 5, 0, 1, 2),
    "hexahedron": (4, 5, 6, 7, 0, 1, 2, 3),
    "hexahedron20": (4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19),
}  # fmt: skip
"""Order of the nodes of a cell that turns it inside out."""

STITCHED = "are those of both sides, and cannot open: expected nodes for each side but where a joint ends"
"""What is wrong with nodes that stitch a joint together."""

_CORNERS = {
    "triangle": ((0, 1, 2),),
    "quad": tuple((k, (k + 1) % 4, (k + 3) % 4) for k in range(4)),
    "tetra": ((0, 1, 2, 3),),
    "wedge": (*((k, (k + 1) % 3, (k + 2) % 3, k + 3) for k in range(3)),
              *((k + 3, (k + 2) % 3 + 3, (k + 1) % 3 + 3, k) for k in range(3))),
    "hexahedron": (*((k, (k + 1) % 4, (k + 3) % 4, k + 4) for k in range(4)),
                   *((k + 4, (k + 3) % 4 + 4, (k + 1) % 4 + 4, k) for k in range(4))),
}  # fmt: skip
"""Corners with their neighbours, right-handed in a cell of positive size."""


def place(x: Floats) -> str:
    """A place in a message: (x, y) or (x, y, z)."""
    return "(" + ", ".join(f"{coordinate:.6g}" for coordinate in (np.asarray(x) + 0.0).tolist()) + ")"


def in_cells(*cells: Integers) -> Integers:
    """Numbers of the nodes of cells, each once."""
    used = np.zeros(max((int(rows.max()) for rows in cells if rows.size), default=-1) + 1, bool)
    for rows in cells:
        used[rows.ravel()] = True
    return np.flatnonzero(used)


def stitches(sides: Iterable[tuple[Integers, Integers]]) -> Integers:
    """Nodes that both sides (f, k) of joints have where these do not end.

    Joints end at nodes or edges of one face alone; faces that have all nodes in common do not count.
    """
    none = np.zeros(0, np.int64)
    common, ends, within = [none], [none], [none]
    parts: dict[int, list[Integers]] = {}
    for lower, upper in sides:
        open_ = (lower != upper).any(1)
        label = np.minimum(lower, upper)[open_]  # one for each place but those at which joints meet
        common.append(label[(lower == upper)[open_]])
        edges = [label] if label.shape[1] == 2 else [label, np.roll(label, -1, axis=1)]
        parts.setdefault(len(edges), []).append(np.sort(np.stack(edges, 2).reshape(-1, len(edges)), axis=1))
    nodes = np.unique(np.concatenate(common))
    for rows in parts.values():
        edges_of, count = np.unique(np.concatenate(rows), axis=0, return_counts=True)
        ends.append(edges_of[count == 1].ravel())
        within.append(edges_of[(count > 1) & np.isin(edges_of, nodes).all(1)].ravel())
    return np.union1d(np.setdiff1d(nodes, np.concatenate(ends)), np.concatenate(within))


def dimension(kind: str) -> int:
    """Dimension of a cell: 0 to 3."""
    if kind.startswith(("vertex", "line")):
        return int(kind.startswith("line"))
    return 2 if kind.startswith(("triangle", "quad")) else 3


def corners(d: int, nodes: int) -> int:
    """Number of corners of a face with so many nodes."""
    return 2 if d == 2 else {3: 3, 4: 4, 6: 3, 8: 4}[nodes]


def backward(d: int, nodes: int) -> Integers:
    """Order of the nodes of a face that turns its normal round."""
    c = corners(d, nodes)
    middles = c + np.arange(nodes - c)[::-1]
    order = [1, 0] if d == 2 else [0, *range(c - 1, 0, -1)]
    return np.concatenate([np.array(order, np.int64), middles.astype(np.int64)])


def corner_sizes(kind: str, x: Floats) -> Floats:
    """Size of the edges' parallelogram or parallelepiped at each corner (m, c) of cells x (m, k, d)."""
    at = _CORNERS[kind.rstrip("0123456789")]
    places = np.ascontiguousarray(x[:, : max(map(max, at)) + 1].transpose(1, 2, 0))
    sizes = np.empty((len(x), len(at)))
    for k, (corner, *ends) in enumerate(at):
        u, v, *w = (places[end] - places[corner] for end in ends)
        if not w:
            sizes[:, k] = u[0] * v[1] - u[1] * v[0]
            continue
        sizes[:, k] = w[0][0] * (u[1] * v[2] - u[2] * v[1])
        sizes[:, k] += w[0][1] * (u[2] * v[0] - u[0] * v[2])
        sizes[:, k] += w[0][2] * (u[0] * v[1] - u[1] * v[0])
    return sizes


def area(x: Floats) -> tuple[Floats, Floats]:
    """Normals (f, d) and areas of faces with the corners x (f, k, d); in 2D the edge turned to the left."""
    if x.shape[2] == 2:
        edge = x[:, 1] - x[:, 0]
        normal = np.stack([-edge[:, 1], edge[:, 0]], 1)
    elif x.shape[1] == 3:
        normal = 0.5 * np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    else:
        normal = 0.5 * np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
    size = np.linalg.norm(normal, axis=1)
    return normal / np.where(size > 0.0, size, 1.0)[:, None], size
