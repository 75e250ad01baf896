"""Meshes with joints as a starter deck of OpenRadioss."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from asperity.contract import Floats
from asperity.material import ModelWarning
from asperity.mesh.jointed import Joint, Jointed
from asperity.mesh.shapes import Integers
from asperity.mesh.writing import HEAD, between, blocks, lines, numbered
from asperity.options import replace_file

if TYPE_CHECKING:
    from asperity.interface import Interface

SOLIDS = {"tetra": "TETRA4", "tetra10": "TETRA10", "wedge": "PENTA6", "hexahedron": "BRICK"}
MOST_ANGLE = 1.0
"""Degrees between Tx and edge 1-2 of an element without a warning."""


def write(path: Path, mesh: Jointed, laws: dict[str, Interface], layer: float, host: str) -> list[Path]:
    """OpenRadioss: nodes, a part for each block and joint, groups, surfaces; materials of the joints.

    Materials and properties of the blocks are the user's: number k of block k.
    """
    if mesh.dimension == 2:
        raise ValueError(f"a plane mesh: expected solids for {host}, whose connection elements are bricks")
    if unknown := sorted(set(mesh.cells) - set(SOLIDS)):
        raise ValueError(f"cells of the type {unknown[0]}: expected one of {', '.join(SOLIDS)}")
    text = [
        f"# {HEAD}\n#RADIOSS STARTER\n",
        f"/BEGIN\n{path.stem.removesuffix('_0000')}\n      2022         0\n",
        *["                  Mg                  mm                   s\n"] * 2,
        "/NODE\n",
        lines("%10d" + 3 * "%20.13g" + "\n", np.arange(1, len(mesh.points) + 1), mesh.points),
    ]
    number, written = 1, np.zeros(sum(map(len, mesh.cells.values())), np.int64)
    parts = {name: k for k, name in enumerate((*mesh.names, *mesh.joints), 1)}
    for kind, block, cells, rows in blocks(mesh):
        text.append(_elements(SOLIDS[kind], parts[block], number, cells))
        written[rows] = np.arange(number, number + len(cells))
        number += len(cells)
    for name, joints in mesh.joints.items():
        for joint in joints:
            if joint.minus.shape[1] != 4:
                raise ValueError(
                    f"joint {name}: faces of {joint.minus.shape[1]} nodes: expected 4 for {host}, whose "
                    "connection elements are bricks"
                )
            _check_tangents(name, mesh.points, joint)
            text.append(_elements("BRICK", parts[name], number, between(joint, 3)))
            number += len(joint.area)
    for name, k in parts.items():
        text.append(f"/PART/{k}\n{name}\n{k:>10}{k:>10}{0:>10}\n")
    for name, law in laws.items():
        card = law.card(host, name=name)
        text.append(re.sub(r"^(/[A-Z]+/[A-Z]+\d+/)1$", rf"\g<1>{parts[name]}", card, flags=re.MULTILINE))
    count = 1
    for keyword, sets in (
        ("GRNOD/NODE", {name: mesh.nodes(name) + 1 for name in mesh.groups}),
        ("GRBRIC/BRIC", {name: np.sort(written[cells]) for name, cells in mesh.sets.items()}),
    ):
        for name, members in sets.items():
            text.append(f"/{keyword}/{count}\n{name}\n{_list(members)}")
            count += 1
    for name, rows in mesh.surfaces.items():
        text.append(f"/SURF/SEG/{count}\n{name}\n")
        first = 1
        for nodes in mesh.face_nodes(rows):
            text.append(numbered("%10d", first, nodes[:, :4] + 1, "%10d", ""))
            first += len(nodes)
        count += 1
    replace_file(path, "".join(text) + "/END\n")
    return [path]


def _elements(keyword: str, part: int, first: int, nodes: Integers) -> str:
    """Elements of a part; those of ten nodes have a line for their number."""
    ten = "\n" if nodes.shape[1] > 8 else ""
    form = "%10d" + ten + "%10d" * nodes.shape[1] + "\n"
    return f"/{keyword}/{part}\n" + lines(form, np.arange(first, first + len(nodes)), nodes + 1)


def _check_tangents(name: str, points: Floats, joint: Joint) -> None:
    """Warn where Tx, which is edge 1-2 of an element, is not that of the joint."""
    x = points[joint.minus]
    edge = x[:, 1] - x[:, 0] + x[:, 2] - x[:, 3]
    cosine = np.einsum("fd,fd->f", edge, joint.axes[:, 1]) / np.linalg.norm(edge, axis=1)
    angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))).max(initial=0.0)
    if angle > MOST_ANGLE:
        warnings.warn(
            f"joint {name}: Tx is edge 1-2 of its elements, up to {angle:.3g} degrees from that of the mesh",
            ModelWarning,
            stacklevel=4,
        )


def _list(numbers: Integers) -> str:
    """Lines of ten numbers."""
    rows = (numbers[i : i + 10].tolist() for i in range(0, len(numbers), 10))
    return "".join("".join(f"{number:>10}" for number in row) + "\n" for row in rows)
