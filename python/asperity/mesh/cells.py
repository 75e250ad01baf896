"""The cells of a mesh, their faces, and the blocks and groups by name."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..contract import Floats
from ..material import ModelWarning
from .faces import Faces, faces_of, key_of, locate
from .files import read_raw
from .groups import blocks_of, groups_of
from .node_places import NodePlaces
from .others import raw_of
from .raw import Pairs, RawMesh, Rows
from .shapes import FACES, MIRRORED, PLANE, Integers, area, corner_sizes, corners, dimension, in_cells, place
from .touching import check_hinges, check_touching, joined

if TYPE_CHECKING:
    import meshio

NO_SIZE = 1e-9  # size of a cell over that of a square or cube of its longest side, below which it has none

DEGENERATE = {
    "quad": ": write those that are triangles as such (CPE3)",
    "hexahedron": ": write those that are wedges or tetrahedra as such (C3D6, C3D4)",
    "wedge": ": write those that are tetrahedra as such (C3D4)",
}
"""What to do about cells with a node twice."""


def read(mesh: RawMesh | meshio.Mesh | Path | str) -> RawMesh:
    """Mesh of a file, or of meshio; ValueError with the name of the file."""
    if isinstance(mesh, str | Path):
        return read_raw(Path(mesh))
    return mesh if isinstance(mesh, RawMesh) else raw_of(mesh)


@dataclass(frozen=True)
class Solids:
    """Cells of a mesh by type, the block of each, their faces, and named groups.

    block (m,): number in `names`.  centres (m, d): of the cells.  facets: nodes of the named faces, and the
    cells of which alone they are faces, or -1.  sets:
    cells of the groups that are no blocks.  spots: nodes of the groups of points, and of lines in space, as
    numbered before nodes were joined.  before: those of the places in the cells.  types: of the elements of a
    deck of Abaqus.  left_out: groups of faces of the file that are not read, and why.
    joints: those of the file.
    """

    points: Floats
    cells: dict[str, Integers]
    block: Integers
    names: list[str]
    centres: Floats
    faces: list[Faces]
    facets: dict[str, list[tuple[Integers, Integers]]]
    sets: dict[str, Integers]
    spots: dict[str, Integers]
    before: Integers
    types: dict[str, NDArray[np.str_]]
    left_out: Mapping[str, str]
    joints: Mapping[str, tuple[Pairs, ...]]

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.points.shape[1])

    @cached_property
    def places_of(self) -> NodePlaces:
        """Places in the cells of sets of nodes."""
        sizes = np.concatenate([np.full(len(rows), rows.shape[1]) for rows in self.cells.values()])
        return NodePlaces(self.before, sizes, self.block, list(self.sets.values()))


def solids(mesh: RawMesh, blocks: str | None, join: float | None = None) -> Solids:
    """Solids of a mesh, or the cells of a plane one; ValueError for types and groups that do not fit.

    blocks: cell data, or names of the groups that are blocks, with commas.  join: distance of nodes that
    become one; 0: blocks that touch without common faces stay apart; None: they are refused.
    """
    d, kinds = _kinds(mesh)
    points = _finite(mesh, d, kinds)
    arrays = Arrays.of(mesh, kinds)
    if join and mesh.joints:
        text = f"join = {join:g}: the file has the joints {', '.join(mesh.joints)}, which it would close"
        raise ValueError(f"{text}: expected no --join, or a file without their elements")
    apart = arrays.cells
    node = joined(points, in_cells(*apart.values()), join) if join else np.arange(len(points))
    cells = {kind: node[rows] for kind, rows in apart.items()}
    centres = np.concatenate([points[rows].mean(1) for rows in cells.values()])
    choice = (
        None if blocks is None or blocks in mesh.numbers else [word.strip() for word in blocks.split(",")]
    )
    groups = groups_of(mesh, blocks if choice is None else None)
    members = arrays.members(groups)
    names, block = blocks_of(members, arrays.members(mesh.parts), choice, centres, mesh)
    cells, apart, convex = _sound(cells, apart, points, centres, block, names, arrays.label)
    faces = faces_of(cells, points, d)
    for face in faces:
        face.check_middles(points)
    _check_folds(convex, faces, points, centres)
    if join is None or join > 0.0:
        bonded = [np.stack([side.lower, side.upper], 2) for sides in mesh.joints.values() for side in sides]
        check_touching(points, faces, block, names, mesh.labels, join or 0.0, bonded)
        check_hinges(points, cells, faces, block, names, mesh.labels, bonded)
    return Solids(
        points,
        cells,
        block,
        names,
        centres,
        faces,
        _facets(arrays, groups, node, faces_of(arrays.cells, points, d) if join else [], d),
        {name: rows for name, rows in members.items() if name not in names},
        _spots(mesh, groups, d),
        np.concatenate([rows.ravel() for rows in apart.values()]),
        arrays.types(),
        mesh.left_out,
        mesh.joints,
    )


def _kinds(mesh: RawMesh) -> tuple[int, list[str]]:
    """Dimension of a mesh, and the kinds of its solids, in their order; ValueError for unknown kinds."""
    kinds = {entry.kind for entry in mesh.cells}
    d = 3 if kinds & (set(FACES) - set(PLANE)) else 2
    here = sorted(kind for kind in kinds & set(FACES) if (kind in PLANE) == (d == 2))
    unknown = sorted(kind for kind in kinds - set(FACES) if dimension(kind) >= d or not here)
    if unknown or not here:
        raise ValueError(f"cells of the types {', '.join(unknown or kinds)}: expected {', '.join(FACES)}")
    return d, here


def _finite(mesh: RawMesh, d: int, kinds: list[str]) -> Floats:
    """Places of the nodes (n, d); ValueError with the number of one that is not finite."""
    points = np.ascontiguousarray((_plane(mesh, kinds) if d == 2 else mesh.points)[:, :d])
    if (bad := ~np.isfinite(points).all(1)).any():
        where = f"{mesh.labels.node(np.flatnonzero(bad)[0])} at {place(points[bad][0])}"
        raise ValueError(f"{where}: expected finite places")
    return points


@dataclass(frozen=True)
class Arrays:
    """Arrays of a mesh whose cells are its solids: by kind, and the number of the first solid of each."""

    mesh: RawMesh
    by_kind: dict[str, list[int]]
    first: dict[int, int]

    @classmethod
    def of(cls, mesh: RawMesh, kinds: list[str]) -> Arrays:
        """Arrays of these kinds; ValueError where they have no cells."""
        by_kind = {kind: [k for k, entry in enumerate(mesh.cells) if entry.kind == kind] for kind in kinds}
        order = [k for numbers in by_kind.values() for k in numbers]
        starts = np.cumsum([0, *(len(mesh.cells[k].nodes) for k in order)])
        if not starts[-1]:
            raise ValueError(f"no cells: expected some of the types {', '.join(FACES)}")
        return cls(mesh, by_kind, dict(zip(order, starts.tolist(), strict=False)))

    @cached_property
    def cells(self) -> dict[str, Integers]:
        """Nodes of the solids, by kind."""
        rows = {
            kind: np.concatenate([self.mesh.cells[k].nodes for k in numbers])
            for kind, numbers in self.by_kind.items()
        }
        return {kind: nodes for kind, nodes in rows.items() if len(nodes)}

    def types(self) -> dict[str, NDArray[np.str_]]:
        """Types of the solids in their file, by kind."""
        return {
            kind: np.concatenate([self.mesh.cells[k].types for k in self.by_kind[kind]])
            for kind in self.cells
        }

    def members(self, groups: Mapping[str, Rows]) -> dict[str, Integers]:
        """Numbers of the solids of groups that have some."""
        members = {
            name: np.concatenate(
                [np.zeros(0, np.int64), *(self.first[k] + rows[k] for k in self.first if len(rows[k]))]
            )
            for name, rows in groups.items()
        }
        return {name: np.unique(numbers) for name, numbers in members.items() if len(numbers)}

    @cached_property
    def _starts(self) -> Integers:
        """Number, through all arrays of the file, of the first cell of each array."""
        return np.cumsum([0, *(len(entry.nodes) for entry in self.mesh.cells)])

    def label(self, solid: int) -> str:
        """Name of a solid in a message."""
        k = next(k for k, begin in reversed(self.first.items()) if begin <= solid)
        return self.mesh.labels.cell(int(self._starts[k]) + solid - self.first[k])

    def owners(self, k: int) -> Integers:
        """Solid of which alone each cell of an array is a face, or -1."""
        number = np.full(int(self._starts[-1]) + 1, -1, np.int64)  # the last one for none
        for i, begin in self.first.items():
            number[self._starts[i] : self._starts[i + 1]] = begin + np.arange(len(self.mesh.cells[i].nodes))
        return np.asarray(number[self.mesh.cells[k].owner])


def _facets(
    arrays: Arrays, groups: Mapping[str, Rows], node: Integers, sides: list[Faces], d: int
) -> dict[str, list[tuple[Integers, Integers]]]:
    """Faces of the groups that have some, each once, and the solids of which alone they are faces, or -1.

    node: that each node becomes when nodes are joined.  sides: faces of the solids before.
    """
    pieces: dict[str, list[tuple[Integers, Integers]]] = {}
    for k, entry in enumerate(arrays.mesh.cells):
        here = {name: rows[k] for name, rows in groups.items() if len(rows[k])}
        if dimension(entry.kind) != d - 1 or not here:
            continue
        rows = np.concatenate([*here.values()])
        owner = _of_one_cell(entry.nodes[rows], arrays.owners(k)[rows], sides, d)
        ends = np.cumsum([len(part) for part in here.values()])[:-1]
        for name, part, owner_of in zip(here, np.split(rows, ends), np.split(owner, ends), strict=True):
            pieces.setdefault(name, []).append((node[entry.nodes[part]], owner_of))
    order = [name for name in groups if name in pieces]
    return {name: _once(pieces[name], d) for name in order}


def _spots(mesh: RawMesh, groups: Mapping[str, Rows], d: int) -> dict[str, Integers]:
    """Nodes of the groups of points, of lines in space, and of the named nodes."""
    spots: dict[str, list[Integers]] = {}
    for name, rows in groups.items():
        for entry, part in zip(mesh.cells, rows, strict=True):
            if len(part) and dimension(entry.kind) < d - 1:
                spots.setdefault(name, []).append(entry.nodes[part].ravel())
    for name, at in mesh.spots.items():
        spots.setdefault(name, []).append(at)
    return {name: np.unique(np.concatenate(nodes)) for name, nodes in spots.items()}


def _check_folds(convex: NDArray[np.bool_], faces: list[Faces], points: Floats, centres: Floats) -> None:
    """Raise ValueError, with number and place, for convex cells on one side of their common face."""
    for face in faces:
        x = points[face.nodes[face.first][:, : corners(points.shape[1], face.nodes.shape[1])]]
        pair = np.stack([face.cell[face.first], face.cell[face.second]], 1)
        away = np.einsum("fsd,fd->fs", centres[pair] - x.mean(1)[:, None], area(x)[0])
        if (over := (away[:, 0] * away[:, 1] > 0.0) & convex[pair].all(1)).any():
            text = f"{over.sum()} pairs of cells overlap, on one side of their common face"
            raise ValueError(f"{text}, as at {place(x[over].mean(1)[0])}: expected cells on both sides")


def _of_one_cell(facets: Integers, owner: Integers, sides: list[Faces], d: int) -> Integers:
    """Cell of each facet: the given one, or the only one that has it among faces before nodes are joined."""
    owner = owner.copy()
    for face in sides:
        if corners(d, facets.shape[1]) == corners(d, face.nodes.shape[1]):
            row = locate(face, facets, d)
            alone = (row >= 0) & (owner < 0)
            alone[alone] = face.number[row[alone]] < 0
            owner[alone] = face.cell[row[alone]]
    return owner


def _plane(mesh: RawMesh, kinds: list[str]) -> Floats:
    """Nodes of a mesh in x and y; ValueError for one in another plane or in space."""
    points = mesh.points
    used = in_cells(*(entry.nodes for entry in mesh.cells if entry.kind in kinds))
    spread = np.ptp(points[used], axis=0) if len(used) else np.zeros(3)
    if len(spread) == 3 and spread[2] > 1e-9 * spread.max():
        z = points[used, 2]
        flat = [name for name, size in zip("xyz", spread, strict=True) if size <= 1e-9 * spread.max()]
        text = f"z from {z.min():g} to {z.max():g}" + (f", {flat[0]} constant" if flat else "")
        raise ValueError(f"{text}: expected a plane mesh in x and y, or solids")
    return points


def _sound(
    cells: dict[str, Integers],
    apart: dict[str, Integers],
    points: Floats,
    centres: Floats,
    block: Integers,
    names: list[str],
    label: Callable[[int], str],
) -> tuple[dict[str, Integers], dict[str, Integers], NDArray[np.bool_]]:
    """Cells of positive size, and which are convex.

    Those inside out are turned; ValueError for those without size, or twice.

    apart: the cells before nodes were joined, which are turned, too.  label: name of a cell in a message.
    """
    sound, sound_apart, first, turned, uneven = {}, {}, 0, 0, 0
    convex = []
    measure = "area" if points.shape[1] == 2 else "volume"
    for kind, data in cells.items():
        x = points[data]
        sizes = corner_sizes(kind, x)
        scale = np.ptp(x, axis=1).max(1)[:, None] ** points.shape[1]
        alike = np.sort(data, axis=1)
        ordered = np.lexsort(alike.T[::-1])
        again = ordered[1:][(alike[ordered[1:]] == alike[ordered[:-1]]).all(1)]
        for wrong, text, way_out in (
            ((np.diff(alike, axis=1) == 0).any(1), "have a node twice", DEGENERATE.get(kind, "")),
            (np.isin(np.arange(len(data)), again), "are there twice", ""),
            ((np.abs(sizes.mean(1, keepdims=True)) <= NO_SIZE * scale).any(1), f"have no {measure}", ""),
        ):
            if wrong.any():
                k = int(np.flatnonzero(wrong)[0]) + first
                where = f"{label(k)} of block {names[block[k]]} at {place(centres[k])}"
                raise ValueError(
                    f"{wrong.sum()} of {len(data)} cells ({kind}) {text}, as {where}: expected none{way_out}"
                )
        back = sizes.mean(1) < 0.0
        least = (sizes * np.where(back, -1.0, 1.0)[:, None]).min(1)
        uneven += int((least < -NO_SIZE * scale[:, 0]).sum())
        convex.append(least > 0.0)
        sound[kind], sound_apart[kind] = (
            np.where(back[:, None], nodes[:, list(MIRRORED[kind])], nodes) for nodes in (data, apart[kind])
        )
        turned, first = turned + int(back.sum()), first + len(data)
    if uneven:
        text = f"{uneven} cells have corners of negative {measure}"
        why = "their nodes are in a wrong order, or they are distorted"
        warnings.warn(f"{text}: {why}", ModelWarning, stacklevel=4)
    if turned:
        warnings.warn(f"{turned} cells of negative {measure} were turned round", ModelWarning, stacklevel=4)
    return sound, sound_apart, np.concatenate(convex)


def _once(facets: list[tuple[Integers, Integers]], d: int) -> list[tuple[Integers, Integers]]:
    """Faces of a group, each once, in one array for each number of nodes."""
    unique = []
    for size in sorted({faces.shape[1] for faces, _ in facets}):
        alike = [pair for pair in facets if pair[0].shape[1] == size]
        rows, owner = (np.concatenate(column) for column in zip(*alike, strict=True))
        _, first = np.unique(np.column_stack([key_of(rows, d), owner]), axis=0, return_index=True)
        unique.append((rows[np.sort(first)], owner[np.sort(first)]))
    return unique
