"""VTU files that carry the names of blocks and joints."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .jointed import Jointed
from .writing import between, layer_points

if TYPE_CHECKING:
    import meshio

    from ..interface import Interface

SOLIDS = {2: "quad", 3: "wedge", 4: "hexahedron"}
"""Cells between two faces, by the number of corners of a face."""


def write_vtu(path: Path, mesh: meshio.Mesh, names: Iterable[tuple[str, int, int]]) -> None:
    """Write a mesh of meshio with its names as field data; a file that is there is replaced as a whole.

    names: of the MaterialIDs, each with its number and dimension, which meshio.read returns as field_data.
    """
    lines = (
        f'<DataArray type="Int64" Name="{name}" NumberOfTuples="2" format="ascii">{number} {d}</DataArray>'
        for name, number, d in names
    )
    field = "\n".join(("<UnstructuredGrid>", "<FieldData>", *lines, "</FieldData>", ""))
    part = path.with_name(f".{path.name}.{os.getpid()}.vtu")
    try:
        mesh.write(part)
        part.write_bytes(part.read_bytes().replace(b"<UnstructuredGrid>", field.encode(), 1))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def write(path: Path, mesh: Jointed, laws: dict[str, Interface], layer: float, host: str) -> list[Path]:
    """VTU of blocks and joints with N, Tx, Ty; MaterialIDs: the numbers of the blocks, then of the joints.

    Their names are field data with the number and the dimension.

    OpenGeoSys has two components in the plane, and a right-handed pair of axes: Tx is N turned to the left.
    """
    import meshio

    d, points = mesh.dimension, layer_points(mesh, layer) if layer else mesh.points
    if laws:
        raise ValueError(f"laws of {', '.join(laws)}: expected none in a .vtu file")
    cells = [(kind, data) for kind, data in mesh.cells.items()]
    number = [mesh.block[kind] for kind in mesh.cells]
    axes = [np.broadcast_to(np.eye(d), (len(numbers), d, d)) for numbers in number]
    sense = np.array([1.0, -1.0])[:, None] if layer and d == 2 else 1.0
    for k, parts in enumerate(mesh.joints.values()):
        for joint in parts:
            cell = between(joint, d)
            cells.append((SOLIDS[cell.shape[1] // 2], cell))
            number.append(np.full(len(cell), len(mesh.names) + k))
            axes.append(joint.axes * sense)
    room = 0 if layer else 3 - d
    axes = [np.pad(frames, ((0, 0), (0, 0), (0, room))) for frames in axes]
    data = {name: [frames[:, k] for frames in axes] for k, name in enumerate(("N", "Tx", "Ty")[:d])}
    data["MaterialIDs"] = [numbers.astype(np.int32) for numbers in number]
    points = np.pad(points, ((0, 0), (0, 3 - d)))
    names = [(name, k, d - (name in mesh.joints)) for k, name in enumerate((*mesh.names, *mesh.joints))]
    write_vtu(path, meshio.Mesh(points, cells, {"origin": mesh.origin}, data), names)
    return [path]
