"""Meshes with joints as input of Abaqus, with cohesive elements, and of CalculiX, with layers."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..cards.blocks import FIELD
from ..contract import Floats
from ..material import ModelWarning
from ..options import replace_file
from .jointed import Jointed
from .shapes import Integers
from .split import default_tangent
from .writing import HEAD, between, blocks, layer_points, lines, numbered

if TYPE_CHECKING:
    from ..interface import Interface

SOLIDS = {
    "triangle": "CPE3", "triangle6": "CPE6", "quad": "CPE4", "quad8": "CPE8", "tetra": "C3D4",
    "tetra10": "C3D10", "wedge": "C3D6", "hexahedron": "C3D8", "hexahedron20": "C3D20",
}  # fmt: skip
"""Solids by kind of cells; replace CPE by CPS for plane stress."""

COHESIVE = {(2, 2): "COH2D4", (3, 3): "COH3D6", (3, 4): "COH3D8"}
"""Cohesive elements of Abaqus by dimension and number of nodes of a face."""

POWER = 1e-3, 1e15
"""Sizes between which 15 digits need no power of ten, and no more zeros than a field has room for."""


def write(path: Path, mesh: Jointed, laws: dict[str, Interface], layer: float, host: str) -> list[Path]:
    """Abaqus with cohesive elements, CalculiX with layers."""
    d, points = mesh.dimension, layer_points(mesh, layer) if layer else mesh.points
    if layer and d == 2:
        raise ValueError(f"a plane mesh: expected solids for {host}, whose UMATs are those of solids")
    if unknown := sorted(set(mesh.cells) - set(SOLIDS)):
        raise ValueError(f"cells of the type {unknown[0]}: expected one of {', '.join(SOLIDS)}")
    text = [f"** {HEAD}\n*Node\n", numbered("%d", 1, _in_fields(points), "%.15g")]
    number, written = 1, np.zeros(sum(map(len, mesh.cells.values())), np.int64)
    types = _types(mesh)
    for _, block, cells, rows in blocks(mesh):
        for name in np.unique(types[rows]).tolist():
            chosen = types[rows] == name
            text.append(f"*Element, type={name}, elset={block}\n" + numbered("%d", number, cells[chosen] + 1))
            written[rows[chosen]] = np.arange(number, number + chosen.sum())
            number += int(chosen.sum())
    orientations = []
    elsets: dict[str, None] = {}  # of the joints
    for name, parts in mesh.joints.items():
        card, sets = "", list[str]()
        for joint in parts:
            k = joint.minus.shape[1]
            N, Tx = joint.axes[:, 0], joint.axes[:, 1]
            if d == 3 and not layer and np.abs(Tx - default_tangent(N)).max() > 1e-6:
                raise ValueError(
                    f"joint {name}: expected no direction for {host}, whose Tx is the projection of x; turn "
                    "the pattern, or give the section an *Orientation"
                )
            kind, parts_of = COHESIVE[d, k], [(name, slice(None))]
            kind = "COHAX4" if mesh.axisymmetric else kind
            if layer:
                kind = {3: "C3D6", 4: "C3D8"}[k]
                tangents = joint.axes[:, 1:].reshape(len(joint.area), -1).round(9) + 0.0
                axes, at = np.unique(tangents, axis=0, return_inverse=True)
                parts_of = [(f"{name}_{len(sets) + i}", at.ravel() == i - 1) for i in range(1, len(axes) + 1)]
                sets += [elset for elset, _ in parts_of]
                for (elset, _), tangent in zip(parts_of, axes, strict=True):
                    line = ", ".join(f"{x:.9g}" for x in tangent)
                    orientations.append(f"*Orientation, name={elset}, system=rectangular\n{line}\n")
            elsets |= dict.fromkeys(elset for elset, _ in parts_of)
            for elset, chosen in parts_of:
                elements = between(joint, d)[chosen] + 1
                text.append(f"*Element, type={kind}, elset={elset}\n" + numbered("%d", number, elements))
                number += len(elements)
        if name in laws and not layer:
            card = laws[name].card(host, name=name, dimension=d)
        elif name in laws:
            card_text = laws[name].card(host, name=name, h=layer)
            card, section = card_text.split("*SOLID SECTION, ")
            material = section.split("MATERIAL=")[1].strip()
            section = f"*SOLID SECTION, ELSET={{0}}, MATERIAL={material}, ORIENTATION={{0}}\n"
            card += "".join(map(section.format, sets))
        orientations.append(card)
    for kind, names in (
        ("elements", [*mesh.names, *mesh.sets, *elsets]),
        ("nodes", mesh.groups),
        ("faces", mesh.surfaces),
    ):
        upper = [name.upper() for name in names]
        if twice := [name for name in names if upper.count(name.upper()) > 1]:
            raise ValueError(
                f"sets of {kind} {' and '.join(twice)}: one name for {host}: expected other names"
            )
    for group in mesh.groups:
        text.append(f"*Nset, nset={group}\n" + _list(mesh.nodes(group) + 1))
    for name, cells in mesh.sets.items():
        text.append(f"*Elset, elset={name}\n" + _list(np.sort(written[cells])))
    for name, rows in mesh.surfaces.items():
        faces = lines("%d, S%d\n", written[rows[:, 0]], rows[:, 1])
        text.append(f"*Surface, type=element, name={name}\n" + faces)
    replace_file(path, "".join(text + orientations))
    return [path]


def _types(mesh: Jointed) -> NDArray[np.str_]:
    """Types of all elements: those of the deck that are solids of Abaqus, else the ones of `SOLIDS`."""
    types = []
    for kind, cells in mesh.cells.items():
        of_file = mesh.types.get(kind, np.full(len(cells), ""))
        solid = np.char.startswith(of_file, ("CPE" if mesh.dimension == 2 else "C3D"))
        solid |= np.char.startswith(of_file, "CPS") & (mesh.dimension == 2)
        usual = SOLIDS[kind].replace("CPE", "CAX") if mesh.axisymmetric else SOLIDS[kind]
        solid = np.char.startswith(of_file, "CAX") if mesh.axisymmetric else solid
        if count := int(((of_file != "") & ~solid).sum()):
            text = f"{count} elements of the types {', '.join(np.unique(of_file[~solid]).tolist())}"
            warnings.warn(f"{text} become {usual}", ModelWarning, stacklevel=4)
        types.append(np.where(solid, of_file, usual))
    return np.concatenate(types)


def _in_fields(points: Floats) -> Floats:
    """Places for fields; small and large ones, which need a power of ten, are rounded."""
    places, size = points.copy(), np.abs(points)
    which = (size > 0.0) & ((size < POWER[0]) | (size >= POWER[1]))
    places[which] = [float(f"{x:.{FIELD - 7}g}") for x in points[which].tolist()]
    return places


def _list(numbers: Integers) -> str:
    """Lines of 16 numbers."""
    rows = (numbers[i : i + 16].tolist() for i in range(0, len(numbers), 16))
    return "".join(", ".join(map(str, row)) + "\n" for row in rows)
