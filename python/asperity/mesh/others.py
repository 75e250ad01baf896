"""Meshes of meshio, which reads VTK and other formats, as meshes between readers and `split`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .groups import PHYSICAL, numbered_groups
from .labels import Labels
from .raw import Cells, RawMesh
from .shapes import dimension

if TYPE_CHECKING:
    import meshio

GHOSTS = ("vtkGhostType", "vtkGhostLevels")
"""Cell data of VTK in which cells that another rank has are not 0."""


def raw_of(mesh: meshio.Mesh) -> RawMesh:
    """Mesh of meshio; ValueError where it has cells of other ranks."""
    arrays: dict[str, list[Any]] = mesh.cell_data
    numbers = {name: tuple(map(np.asarray, parts)) for name, parts in arrays.items()}
    for name in GHOSTS:
        if count := sum(int(np.count_nonzero(part)) for part in numbers.get(name, ())):
            text = f"{count} cells are ghosts, of another rank, by {name}"
            raise ValueError(f"{text}: expected the whole mesh without ghosts")
    cells = tuple(
        Cells.plain(block.type, np.asarray(block.data, np.int64).reshape(len(block.data), -1))
        for block in mesh.cells
    )
    tags = {name: int(tag) for name, (tag, _) in mesh.field_data.items()}
    groups = {
        name: tuple(np.asarray([] if part is None else part, np.int64) for part in rows)
        for name, rows in sorted(mesh.cell_sets.items(), key=lambda item: (tags.get(item[0], 0), item[0]))
        if not name.startswith("gmsh:")
    }
    if PHYSICAL in numbers:
        called = {(int(dim), int(tag)): name for name, (tag, dim) in mesh.field_data.items()}
        dimensions = [dimension(entry.kind) for entry in cells]
        groups = {**numbered_groups(numbers[PHYSICAL], dimensions, called), **groups}
    spots = {name: np.asarray(nodes, np.int64).ravel() for name, nodes in (mesh.point_sets or {}).items()}
    points = np.asarray(mesh.points, float)
    return RawMesh(points, cells, Labels.none(), groups, spots, numbers)
