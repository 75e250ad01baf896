"""Faces of the cells of meshio, and the blocks and groups of a mesh by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..contract import Floats
from .files import read_mesh

if TYPE_CHECKING:
    import meshio

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
"""Nodes of the faces of a cell: corners around the face, then the middles of its edges from the first on."""

PLANE = ("triangle", "triangle6", "quad", "quad8", "quad9")
"""Cells of plane meshes; in a mesh with solids they are faces."""


def corners(d: int, nodes: int) -> int:
    """Number of corners of a face with so many nodes."""
    return 2 if d == 2 else {3: 3, 4: 4, 6: 3, 8: 4}[nodes]


def read(mesh: meshio.Mesh | Path | str) -> meshio.Mesh:
    """Mesh of a file that meshio can read; ValueError with the name of the file."""
    if not isinstance(mesh, str | Path):
        return mesh
    if not Path(mesh).is_file():
        raise ValueError(f"{mesh}: no such file: expected a mesh, such as .msh of gmsh, .inp or .vtu")
    return read_mesh(Path(mesh), "a mesh that meshio reads", "mesh")


def tags(mesh: meshio.Mesh, data: str | None) -> tuple[list[str], list[Integers]]:
    """Names, and for each array of cells the number of the name of every cell (-1: none).

    data: name of the cell data; by default the physical groups of gmsh, or its entities, or the cell sets, or
    the only integer cell data.
    """
    found: dict[str, list[Any]] = mesh.cell_data
    whole = [name for name, one in found.items() if all(np.asarray(part).dtype.kind in "iu" for part in one)]
    if data is None and "gmsh:physical" not in found and any(name[:5] != "gmsh:" for name in mesh.cell_sets):
        return _sets(mesh)
    known = [name for name in (data, "gmsh:physical", "gmsh:geometrical") if name in whole]
    if data is not None and data not in whole:
        raise ValueError(
            f"blocks = {data}: expected integer cell data of the mesh: {', '.join(whole) or 'none'}"
        )
    if not known and len(whole) != 1:
        raise ValueError(
            f"the mesh has no groups: expected physical groups of gmsh, cell sets or cell data {whole}"
        )
    data = (known or whole)[0]
    dimensions = [_dimension(block.type) for block in mesh.cells]
    called = {(dim, tag): name for name, (tag, dim) in mesh.field_data.items() if "phys" in data}
    parts = [np.asarray(part, np.int64) for part in found[data]]
    least, room = min(int(part.min(initial=0)) for part in parts), 1 << 40  # larger than a tag
    keys = [d * room + part - least for d, part in zip(dimensions, parts, strict=True)]
    found_keys, number = np.unique(np.concatenate(keys), return_inverse=True)
    pairs = [(key // room, key % room + least) for key in found_keys.tolist()]
    names = [called.get(pair, f"block_{pair[1]}") for pair in pairs]
    return names, np.split(number, np.cumsum([len(key) for key in keys])[:-1])


def _sets(mesh: meshio.Mesh) -> tuple[list[str], list[Integers]]:
    """Cell sets; a cell that is in more than one of them has the name of the smallest."""
    parts = {
        name: [np.asarray([] if one is None else one, np.int64) for one in some]
        for name, some in mesh.cell_sets.items()
        if not name.startswith("gmsh:")
    }
    names = sorted(parts, key=lambda name: -sum(len(one) for one in parts[name]))
    out = [np.full(len(block.data), -1, np.int64) for block in mesh.cells]
    for k, name in enumerate(names):
        for where, one in zip(out, parts[name], strict=True):
            where[one] = k
    order = np.argsort(names)
    place = np.append(np.argsort(order), -1)
    return [names[k] for k in order], [place[one] for one in out]


def _dimension(kind: str) -> int:
    if kind.startswith(("vertex", "line")):
        return int(kind.startswith("line"))
    return 2 if kind in PLANE else 3


@dataclass
class Faces:
    """Faces with one number of nodes.

    nodes, place (f, k): nodes and their places among those of all cells.  cell (f,): of a face.
    first, second: faces that are the same.  number (f,): that of their pair, or -1.
    """

    nodes: Integers
    place: Integers
    cell: Integers
    key: Integers

    def pair(self, points: Floats) -> None:
        """Find the faces that are the same."""
        order = np.lexsort(self.key.T[::-1])
        same = (self.key[order[1:]] == self.key[order[:-1]]).all(1)
        if (same[1:] & same[:-1]).any():
            where = points[self.nodes[order[1:-1][same[1:] & same[:-1]][0]]].mean(0)
            raise ValueError(f"a face at {where} has more than two cells: expected one or two")
        self.first, self.second = order[:-1][same], order[1:][same]
        self.number = np.full(len(order), -1, np.int64)
        self.number[self.first] = self.number[self.second] = np.arange(len(self.first))


@dataclass(frozen=True)
class Solids:
    """Cells of a mesh by type, the block of each, their faces, and named faces.

    block (m,): number in `names`.  centres (m, d): of the cells.  facets: nodes of the named faces.
    """

    points: Floats
    cells: dict[str, Integers]
    block: Integers
    names: list[str]
    centres: Floats
    faces: list[Faces]
    facets: dict[str, list[Integers]]

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.points.shape[1]


def solids(mesh: meshio.Mesh, blocks: str | None) -> Solids:
    """Solids of a mesh, or the cells of a plane one; ValueError for types and groups that do not fit."""
    names, tag = tags(mesh, blocks)
    kinds = {block.type for block in mesh.cells}
    d = 3 if kinds & (set(FACES) - set(PLANE)) else 2
    here = sorted(kind for kind in kinds & set(FACES) if (kind in PLANE) == (d == 2))
    unknown = sorted(kind for kind in kinds - set(FACES) if _dimension(kind) == 3)
    if unknown or not here:
        raise ValueError(f"cells of the types {', '.join(unknown or kinds)}: expected {', '.join(FACES)}")
    points = np.asarray(mesh.points, float)
    z = points[:, 2:]
    if d == 2 and np.ptp(z, axis=0).any():
        raise ValueError(f"z from {z.min():g} to {z.max():g}: expected a plane mesh or solids")
    points = np.ascontiguousarray(points[:, :d])
    facets: dict[str, list[Integers]] = {}
    parts = {kind: [k for k, one in enumerate(mesh.cells) if one.type == kind] for kind in here}
    cells = {
        kind: np.concatenate([np.asarray(mesh.cells[k].data, np.int64) for k in some])
        for kind, some in parts.items()
    }
    of_cell = np.concatenate([tag[k] for some in parts.values() for k in some])
    if (bad := int((of_cell < 0).sum())) > 0:
        raise ValueError(f"{bad} of {len(of_cell)} cells are in no block: expected a group for each")
    for one, numbers in zip(mesh.cells, tag, strict=True):
        for number in np.unique(numbers[numbers >= 0]) if _dimension(one.type) == d - 1 else ():
            facets.setdefault(names[number], []).append(np.asarray(one.data, np.int64)[numbers == number])
    used, of_cell = np.unique(of_cell, return_inverse=True)
    centres = np.concatenate([points[data].mean(1) for data in cells.values()])
    return Solids(points, cells, of_cell, [names[k] for k in used], centres, _faces(cells, points, d), facets)


def _key(nodes: Integers, d: int) -> Integers:
    """Corners that tell a face from others: its smallest two or three numbers."""
    return np.sort(nodes[:, : corners(d, nodes.shape[1])], axis=1)[:, :d]


def _faces(cells: dict[str, Integers], points: Floats, d: int) -> list[Faces]:
    """Faces of all cells by their number of nodes, with the pairs that are inside."""
    parts: dict[int, list[tuple[Integers, Integers, Integers]]] = {}
    cell, place = 0, 0
    for kind, data in cells.items():
        for size in sorted({len(face) for face in FACES[kind]}):
            local = np.array([face for face in FACES[kind] if len(face) == size])
            where = place + data.shape[1] * np.arange(len(data))[:, None, None] + local
            owner = np.repeat(cell + np.arange(len(data)), len(local))
            parts.setdefault(size, []).append(
                (data[:, local].reshape(-1, size), where.reshape(-1, size), owner)
            )
        cell, place = cell + len(data), place + data.size
    found = []
    for some in parts.values():
        nodes, where, owner = (np.concatenate(one) for one in zip(*some, strict=True))
        found.append(Faces(nodes, where, owner, _key(nodes, d)))
        found[-1].pair(points)
    return found


def locate(face: Faces, facets: Integers, d: int) -> Integers:
    """Number of a face for each facet, or -1."""
    key = _key(facets, d)
    known = np.zeros(max(int(face.key.max()), int(key.max())) + 1, bool)
    known[key] = True
    near = np.flatnonzero(known[face.key].all(1))
    _, number = np.unique(np.concatenate([face.key[near], key]), axis=0, return_inverse=True)
    number = number.ravel()
    row = np.full(int(number.max(initial=0)) + 1, -1, np.int64)
    row[number[: len(near)]] = near
    return row[number[len(near) :]]
