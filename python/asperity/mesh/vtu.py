"""VTU files: the mesh with the names of blocks and joints, and one file for each group."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..contract import Floats
from .jointed import Jointed
from .shapes import FACETS, Integers, in_cells
from .writing import HEAD, between, layer_points

if TYPE_CHECKING:
    import meshio

    from ..interface import Interface

SOLIDS = {2: "quad", 3: "wedge", 4: "hexahedron"}
"""Cells between two faces, by the number of corners of a face."""


@dataclass(frozen=True)
class Part:
    """Cells of a group: their kind, nodes (m, k), and the cells (m,) of the whole mesh, of nodes none."""

    kind: str
    nodes: Integers
    cells: Integers


def write_vtu(path: Path, mesh: meshio.Mesh, names: Iterable[tuple[str, int, int]]) -> None:
    """Write a mesh of meshio with its names as field data; a file that is there is replaced as a whole.

    names: of the MaterialIDs, each with its number and dimension, which meshio.read returns as field_data.
    """
    lines = [
        f'<DataArray type="Int64" Name="{name}" NumberOfTuples="2" format="ascii">{number} {d}</DataArray>'
        for name, number, d in names
    ]
    data = ["<FieldData>", *lines, "</FieldData>"] if lines else []
    field = "\n".join((f"<!-- {HEAD} -->", "<UnstructuredGrid>", *data, ""))
    part = path.with_name(f".{path.name}.{os.getpid()}.vtu")
    try:
        mesh.write(part)
        part.write_bytes(part.read_bytes().replace(b"<UnstructuredGrid>", field.encode(), 1))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def write(path: Path, mesh: Jointed, laws: dict[str, Interface], layer: float, host: str) -> list[Path]:
    """VTU of blocks and joints with N, Tx, Ty; MaterialIDs: the numbers of the blocks, then of the joints.

    Their names are field data with the number and the dimension.  Groups that are no blocks are files beside
    it, FILE_GROUP.vtu, with the numbers of their nodes and cells in the whole mesh, as OpenGeoSys wants of
    its boundaries: bulk_node_ids, bulk_element_ids.

    OpenGeoSys has two components in the plane, and a right-handed pair of axes: Tx is N turned to the left.
    """
    import meshio

    d, points = mesh.dimension, layer_points(mesh, layer) if layer else mesh.points
    groups = beside(path, mesh)
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
    for file, group in groups.items():
        _write_group(file, points, group)
    return [path, *groups]


def beside(path: Path, mesh: Jointed) -> dict[Path, list[Part]]:
    """Files of the groups that are no blocks and no joints, FILE_GROUP.vtu, and what they have.

    These are cells, faces or nodes; of a group that has several of them the others are FILE_GROUP_faces.vtu
    and FILE_GROUP_nodes.vtu.  Raises ValueError where two groups have one file.
    """
    files: dict[Path, list[Part]] = {}
    taken = {path.name.lower(): ""}
    for name in dict.fromkeys((*mesh.groups, *mesh.sets)):
        if name in mesh.joints:
            continue
        for ending, parts in _parts_of(mesh, name).items():
            label = re.sub(r"[^\w.+-]+", "_", name) + ending
            file = path.with_name(f"{path.stem}_{label}.vtu")
            if file.name.lower() in taken:
                other = taken[file.name.lower()]
                raise ValueError(f"groups {other!r} and {name!r}: one file {file}: expected other names")
            taken[file.name.lower()] = name
            files[file] = parts
    return files


def _parts_of(mesh: Jointed, name: str) -> dict[str, list[Part]]:
    """Cells of a group, its faces, whose normals point out of their cells, and nodes that these have not."""
    parts: dict[str, list[Part]] = {"cells": [], "faces": [], "nodes": []}
    first = 0
    for kind, data in mesh.cells.items():
        at = mesh.sets.get(name, np.zeros(0, np.int64)) - first
        at = at[(at >= 0) & (at < len(data))]
        parts["cells"] += [Part(kind, data[at], first + at)] if len(at) else []
        first += len(data)
    for nodes, cells in mesh.faces(mesh.surfaces[name]) if name in mesh.surfaces else ():
        parts["faces"].append(Part(FACETS[mesh.dimension, nodes.shape[1]], nodes, cells))
    known = in_cells(*(part.nodes for part in (*parts["cells"], *parts["faces"])))
    single = np.setdiff1d(mesh.nodes(name) if name in mesh.groups else known, known)
    parts["nodes"] = [Part("vertex", single[:, None], single[:0])] if len(single) else []
    full = [what for what in parts if parts[what]]
    return {f"_{what}" if what != full[0] else "": parts[what] for what in full}


def _write_group(path: Path, points: Floats, parts: list[Part]) -> None:
    """Write a group with the numbers of its nodes and cells in the whole mesh."""
    import meshio

    used = in_cells(*(part.nodes for part in parts))
    cells = [(part.kind, np.searchsorted(used, part.nodes)) for part in parts]
    inside = all(len(part.cells) for part in parts)
    numbers = {"bulk_element_ids": [part.cells.astype("u8") for part in parts]} if inside else {}
    nodes = {"bulk_node_ids": used.astype("u8")}
    write_vtu(path, meshio.Mesh(points[used], cells, nodes, numbers), ())
