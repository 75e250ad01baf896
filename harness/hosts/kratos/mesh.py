"""Meshes with joints as input of Kratos."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from asperity.mesh.jointed import Jointed
from asperity.mesh.shapes import Integers
from asperity.mesh.writing import HEAD, blocks, lines, numbered
from asperity.options import replace_file

from .card import ELEMENTS

if TYPE_CHECKING:
    from asperity.interface import Interface

TWENTY = [*range(12), *range(16, 20), *range(12, 16)]
"""Nodes of a hexahedron of 20 nodes in the order of Kratos: its upright edges come before the upper ones."""

CONDITIONS = {2: "LineLoadCondition2D", 3: "SurfaceLoadCondition3D"}
"""Conditions of Kratos on the faces of groups and joints, before their number of nodes."""


def write(path: Path, mesh: Jointed, laws: dict[str, Interface], layer: float, host: str) -> list[Path]:
    """Kratos: parts of the model by block, joint, group; properties by block and joint; materials as JSON."""
    d = mesh.dimension
    names = {name: k for k, name in enumerate((*mesh.names, *mesh.joints), 1)}
    points = np.zeros((len(mesh.points), 3))
    points[:, :d] = mesh.points
    text = [f"// {HEAD}\nBegin ModelPartData\nEnd ModelPartData\n"]
    text += [f"Begin Properties {k}\nEnd Properties\n" for k in range(len(names) + 1)]
    text += ["Begin Nodes\n", numbered("%d", 1, points, "%.15g", " "), "End Nodes\n"]
    number, parts = 1, {name: (np.zeros(0, np.int64), [np.zeros(0, np.int64)]) for name in names}

    def add(name: str, element: str, nodes: Integers) -> None:
        nonlocal number
        form = f"%d {names[name]}"
        text.append(f"Begin Elements {element}\n{numbered(form, number, nodes + 1, by=' ')}End Elements\n")
        used, numbers = parts[name]
        parts[name] = np.union1d(used, nodes), [*numbers, np.arange(number, number + len(nodes))]
        number += len(nodes)

    written = np.zeros(sum(map(len, mesh.cells.values())), np.int64)
    for kind, block, cells, rows in blocks(mesh):
        written[rows] = np.arange(number, number + len(cells))
        cells = cells[:, TWENTY] if kind == "hexahedron20" else cells
        add(block, f"SmallDisplacementElement{d}D{cells.shape[1]}N", cells)
    for name, parts_of_joint in mesh.joints.items():
        for joint in parts_of_joint:
            k = joint.minus.shape[1]
            add(name, f"{ELEMENTS[d][1]}{k}Plus{k}N", np.concatenate([joint.minus, joint.plus], 1))
    none = np.zeros(0, np.int64)
    conditions: dict[str, list[Integers]] = {}
    last = 1
    for name, rows in mesh.surfaces.items():
        for nodes in mesh.face_nodes(rows):
            kind = f"{CONDITIONS[d]}{nodes.shape[1]}N"
            text.append(
                f"Begin Conditions {kind}\n{numbered('%d 0', last, nodes + 1, by=' ')}End Conditions\n"
            )
            conditions.setdefault(name, []).append(np.arange(last, last + len(nodes)))
            here, numbers = parts.get(name, (none, [none]))
            parts[name] = np.union1d(here, nodes), numbers
            last += len(nodes)
    for name in mesh.groups:
        here, numbers = parts.get(name, (none, [none]))
        parts[name] = np.union1d(here, mesh.nodes(name)), numbers
    for name, cells in mesh.sets.items():
        here, numbers = parts.get(name, (none, [none]))
        parts[name] = np.union1d(here, mesh.nodes_of(cells)), [*numbers, np.sort(written[cells])]
    for name, (nodes, numbers) in parts.items():
        text.append(f"Begin SubModelPart {name}\n")
        lists = ("Nodes", nodes + 1), ("Elements", np.concatenate(numbers))
        for table, entries in (*lists, ("Conditions", np.concatenate(conditions.get(name, [none])))):
            text.append(
                f"Begin SubModelPart{table}\n{lines('%d' + chr(10), entries)}End SubModelPart{table}\n"
            )
        text.append("End SubModelPart\n")
    if not laws:
        replace_file(path, "".join(text))
        return [path]
    cards = []
    for name, law in laws.items():
        [card] = json.loads(law.card(host, name=name, dimension=d))["properties"]
        cards.append(card | {"model_part_name": f"Main.{name}", "properties_id": names[name]})
    properties = path.with_suffix(".json")
    replace_file(path, "".join(text))
    replace_file(properties, json.dumps({"properties": cards}, indent=2) + "\n")
    return [path, properties]
