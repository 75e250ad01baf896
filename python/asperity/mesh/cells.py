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
from .raw import Pairs, RawMesh
from .shapes import FACES, MIRRORED, PLANE, Integers, area, corner_sizes, corners, dimension, in_cells, place
from .touching import check_touching, joined

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
    kinds = {entry.kind for entry in mesh.cells}
    d = 3 if kinds & (set(FACES) - set(PLANE)) else 2
    here = sorted(kind for kind in kinds & set(FACES) if (kind in PLANE) == (d == 2))
    unknown = sorted(kind for kind in kinds - set(FACES) if dimension(kind) >= d or not here)
    if unknown or not here:
        raise ValueError(f"cells of the types {', '.join(unknown or kinds)}: expected {', '.join(FACES)}")
    points = np.ascontiguousarray((_plane(mesh, here) if d == 2 else mesh.points)[:, :d])
    labels = mesh.labels
    if (bad := ~np.isfinite(points).all(1)).any():
        where = f"{labels.node(np.flatnonzero(bad)[0])} at {place(points[bad][0])}"
        raise ValueError(f"{where}: expected finite places")
    parts = {kind: [k for k, entry in enumerate(mesh.cells) if entry.kind == kind] for kind in here}
    data = [entry.nodes for entry in mesh.cells]
    apart = {kind: np.concatenate([data[k] for k in numbers]) for kind, numbers in parts.items()}
    apart = {kind: rows for kind, rows in apart.items() if len(rows)}
    if not apart:
        raise ValueError(f"no cells: expected some of the types {', '.join(FACES)}")
    used = in_cells(*apart.values())
    if join and mesh.joints:
        text = f"join = {join:g}: the file has the joints {', '.join(mesh.joints)}, which it would close"
        raise ValueError(f"{text}: expected no --join, or a file without their elements")
    node = joined(points, used, join) if join else np.arange(len(points))
    cells = {kind: node[rows] for kind, rows in apart.items()}
    centres = np.concatenate([points[rows].mean(1) for rows in cells.values()])
    first = dict(zip((k for numbers in parts.values() for k in numbers), _starts(data, parts), strict=True))
    choice = (
        None if blocks is None or blocks in mesh.numbers else [word.strip() for word in blocks.split(",")]
    )
    groups = groups_of(mesh, blocks if choice is None else None)
    members: dict[str, Integers] = {}
    spots: dict[str, Integers] = {}
    parts_of_facets: dict[str, list[tuple[Integers, Integers]]] = {}
    number = np.full(sum(map(len, data)) + 1, -1, np.int64)  # of a cell; the last one for none
    starts = np.cumsum([0, *map(len, data)])
    for k, begin in first.items():
        number[starts[k] : starts[k + 1]] = begin + np.arange(len(data[k]))
    owner = [number[entry.owner] for entry in mesh.cells]
    sides = faces_of(apart, points, d) if join else []
    facets_in: dict[int, list[tuple[str, Integers]]] = {}
    for name, rows_by_array in groups.items():
        for k, rows in enumerate(rows_by_array):
            if len(rows) and k in first:
                members[name] = np.union1d(members.get(name, np.zeros(0, np.int64)), first[k] + rows)
            elif not len(rows):
                continue
            elif dimension(mesh.cells[k].kind) == d - 1:
                parts_of_facets.setdefault(name, [])
                facets_in.setdefault(k, []).append((name, rows))
            else:
                spots[name] = np.union1d(spots.get(name, np.zeros(0, np.int64)), data[k][rows].ravel())
    for k, entries in sorted(facets_in.items()):
        rows = np.concatenate([rows for _, rows in entries])
        owner_of = _of_one_cell(data[k][rows], owner[k][rows], sides, d)
        ends = np.cumsum([0, *(len(rows) for _, rows in entries)])
        for (name, rows), first_row, last_row in zip(entries, ends, ends[1:], strict=False):
            facets_of = node[data[k][rows]], owner_of[first_row:last_row]
            parts_of_facets[name].append(facets_of)
    for name, at in mesh.spots.items():
        spots[name] = np.union1d(spots.get(name, np.zeros(0, np.int64)), at)
    instances = {
        name: np.concatenate([first[k] + rows for k, rows in enumerate(rows_by_array) if k in first])
        for name, rows_by_array in mesh.parts.items()
    }
    instances = {name: rows for name, rows in instances.items() if len(rows)}
    names, block = blocks_of(members, instances, choice, centres, mesh)
    sets = {name: rows for name, rows in members.items() if name not in names}
    in_file = np.concatenate([starts[k] + np.arange(len(data[k])) for k in first])
    cells, apart, convex = _sound(
        cells, apart, points, centres, block, names, lambda k: labels.cell(in_file[k])
    )
    faces = faces_of(cells, points, d)
    for face in faces:
        face.check_middles(points)
    _check_folds(convex, faces, points, centres)
    facets = {name: _once(pieces, d) for name, pieces in parts_of_facets.items()}
    if join is None or join > 0.0:
        bonded = [np.stack([side.lower, side.upper], 2) for sides in mesh.joints.values() for side in sides]
        check_touching(points, faces, block, names, labels, join or 0.0, bonded)
    types = {kind: np.concatenate([mesh.cells[k].types for k in parts[kind]]) for kind in cells}
    before = np.concatenate([rows.ravel() for rows in apart.values()])
    return Solids(
        points,
        cells,
        block,
        names,
        centres,
        faces,
        facets,
        sets,
        spots,
        before,
        types,
        mesh.left_out,
        mesh.joints,
    )


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


def _starts(data: list[Integers], parts: dict[str, list[int]]) -> Integers:
    """Number of the first cell of each array of cells, in the order of `parts`."""
    counts = [len(data[k]) for numbers in parts.values() for k in numbers]
    return np.cumsum([0, *counts])[:-1]


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
