"""Meshes with joints as input of host programs."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Iterator, Mapping
from itertools import chain, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..cards.blocks import KRATOS
from ..contract import Floats, refuse
from ..material import ModelWarning
from ..options import replace_file
from .shapes import Integers, corners
from .split import Joint, Jointed, default_tangent

if TYPE_CHECKING:
    from ..interface import Interface

HEAD = "mesh with joints of asperity"  # first words of a file, after the sign of a comment

LABEL = r"[A-Za-z_][\w-]*"
"""Names that Abaqus, CalculiX and Kratos can read: those of Abaqus/CAE, too."""

ABAQUS = {
    "triangle": "CPE3", "triangle6": "CPE6", "quad": "CPE4", "quad8": "CPE8", "tetra": "C3D4",
    "tetra10": "C3D10", "wedge": "C3D6", "hexahedron": "C3D8", "hexahedron20": "C3D20",
}  # fmt: skip
"""Solids of Abaqus and CalculiX; replace CPE by CPS for plane stress."""

COHESIVE = {(2, 2): "COH2D4", (3, 3): "COH3D6", (3, 4): "COH3D8"}
"""Cohesive elements of Abaqus by dimension and number of nodes of a face."""

SOLIDS = {2: "quad", 3: "wedge", 4: "hexahedron"}
"""Cells between two faces, by the number of corners of a face."""

TWENTY = [*range(12), *range(16, 20), *range(12, 16)]
"""Nodes of a hexahedron of 20 nodes in the order of Kratos: its upright edges come before the upper ones."""

CONDITIONS = {2: "LineLoadCondition2D", 3: "SurfaceLoadCondition3D"}
"""Conditions of Kratos on the faces of groups and joints, before their number of nodes."""

SINGULAR = 0.05
"""Directions in which the normals at a node differ by less are left out when its layers get a thickness."""


def write(
    path: Path | str,
    mesh: Jointed,
    host: str | None = None,
    laws: Mapping[str, Interface] | None = None,
    layer: float = 0.0,
) -> list[Path]:
    """Write a mesh for a host and return the files.

    host: abaqus, calculix, kratos, ogs or vtu; by default that of the ending .inp, .mdpa, .vtu.  laws: of
    joints by name, whose material blocks are written, too.  layer: thickness of the solids by which
    CalculiX and OpenGeoSys represent joints.

    Raises ValueError for a law without a joint, for elements that the host does not have, and for layers that
    are too thick.
    """
    path, laws = Path(path), dict(laws or {})
    host = host or {".inp": "abaqus", ".mdpa": "kratos", ".vtu": "vtu"}.get(path.suffix)
    refuse(host not in WRITERS, f"{path}: host {host}: expected one of {', '.join(WRITERS)}")
    if unknown := sorted(set(laws) - set(mesh.joints)):
        raise ValueError(f"law of {unknown[0]}: expected a joint of the mesh: {', '.join(mesh.joints)}")
    if (host in ("calculix", "ogs")) != (layer > 0.0):
        what = "the thickness of its layers, > 0" if not layer else "none: its joints have no thickness"
        raise ValueError(f"layer = {layer:g}: expected {what}, for {host}")
    for name in (*mesh.names, *mesh.joints, *mesh.groups, *mesh.sets, *mesh.surfaces):
        if host in ("abaqus", "calculix", "kratos") and not re.fullmatch(LABEL, name, re.ASCII):
            raise ValueError(
                f"name {name!r}: expected a letter, then letters, digits, underscores, hyphens, for {host}"
            )
    if host not in ("kratos", "vtu"):
        _check_faces(mesh, host)
    if layer:
        _check_layer(mesh, layer)
    return WRITERS[host](path, mesh, laws, layer)


def _check_faces(mesh: Jointed, host: str) -> None:
    """Raise ValueError for joints between faces that a host has no element for; Kratos has all of them."""
    for name, joint in ((name, one) for name, parts in mesh.joints.items() for one in parts):
        count, k = joint.minus.shape
        if (mesh.dimension, k) not in COHESIVE:
            raise ValueError(f"joint {name}: {count} faces of {k} nodes: expected linear ones for {host}")
        if (mesh.points[joint.minus] != mesh.points[joint.plus]).any():
            raise ValueError(f"joint {name}: its sides are a period apart: expected one place for {host}")


def _check_layer(mesh: Jointed, h: float) -> None:
    """Raise ValueError for a layer that does not fit into the cells beside it; warn of one with tips."""
    centres = np.concatenate([mesh.points[cells].mean(1) for cells in mesh.cells.values()])
    for name, joint in ((name, one) for name, parts in mesh.joints.items() for one in parts):
        away = centres[joint.cells] - mesh.points[joint.minus].mean(1)[:, None]
        most = 2.0 * float(np.abs(np.einsum("fsd,fd->fs", away, joint.axes[:, 0])).min())
        refuse(h >= most, f"layer = {h:g}: expected less than {most:.3g}, for the cells at joint {name}")
        if joint.tips:
            text = f"joint {name} ends inside the mesh, where its layer has no thickness: its last elements"
            warnings.warn(f"{text} are too stiff, and break too early", ModelWarning, stacklevel=3)


def layer_points(mesh: Jointed, h: float) -> Floats:
    """Nodes whose joints have the thickness h: both faces of a joint move apart by h/2, into the blocks."""
    d = mesh.dimension
    square, side = np.zeros((len(mesh.points), d, d)), np.zeros((len(mesh.points), d))
    for joint in chain(*mesh.joints.values()):
        normal = np.repeat(joint.axes[:, 0], joint.minus.shape[1], axis=0)
        for nodes, sign in ((joint.minus.ravel(), -1.0), (joint.plus.ravel(), 1.0)):
            np.add.at(square, nodes, normal[:, :, None] * normal[:, None])
            np.add.at(side, nodes, sign * normal)
    inverse = np.linalg.pinv(square, rcond=SINGULAR, hermitian=True)
    return mesh.points + 0.5 * h * np.einsum("nij,nj->ni", inverse, side)


def _blocks(mesh: Jointed) -> Iterator[tuple[str, str, Integers, Integers]]:
    """Type, name of the block, cells and their numbers through all types, block by block."""
    before = 0
    for kind, cells in mesh.cells.items():
        order = np.argsort(mesh.block[kind], kind="stable")
        ends = np.searchsorted(mesh.block[kind][order], range(len(mesh.names) + 1))
        for name, (first, last) in zip(mesh.names, pairwise(ends), strict=True):
            if last > first:
                yield kind, name, cells[order[first:last]], before + order[first:last]
        before += len(cells)


def _between(joint: Joint, d: int) -> Integers:
    """Nodes of the cells between the corners of both faces, in the order of VTK."""
    c = corners(d, joint.minus.shape[1])
    plus = joint.plus[:, :c]
    return np.concatenate([joint.minus[:, :c], plus[:, ::-1] if d == 2 else plus], 1)


def _lines(form: str, *columns: NDArray[Any]) -> str:
    """Lines of numbers; form: of a line."""
    rows = np.column_stack([np.asarray(one) for one in columns])
    return (form * len(rows)) % tuple(rows.ravel().tolist())


def _numbered(form: str, first: int, data: Integers, text: str = "%d", by: str = ", ") -> str:
    """Lines of elements or nodes with their numbers from `first`."""
    return _lines(f"{form}{by}{by.join([text] * data.shape[1])}\n", np.arange(first, first + len(data)), data)


def _inp(path: Path, mesh: Jointed, laws: dict[str, Interface], layer: float) -> list[Path]:
    """Abaqus with cohesive elements, CalculiX with layers."""
    d, points = mesh.dimension, layer_points(mesh, layer) if layer else mesh.points
    refuse(layer and d == 2, "a plane mesh: expected solids for calculix, whose UMATs are those of solids")
    if unknown := sorted(set(mesh.cells) - set(ABAQUS)):
        raise ValueError(f"cells of the type {unknown[0]}: expected one of {', '.join(ABAQUS)}")
    text = [f"** {HEAD}\n*Node\n", _numbered("%d", 1, points, "%.15g")]
    number, written = 1, np.zeros(sum(map(len, mesh.cells.values())), np.int64)
    for kind, block, cells, rows in _blocks(mesh):
        text.append(f"*Element, type={ABAQUS[kind]}, elset={block}\n" + _numbered("%d", number, cells + 1))
        written[rows] = np.arange(number, number + len(cells))
        number += len(cells)
    orientations = []
    for name, parts in mesh.joints.items():
        card, sets = "", []
        for joint in parts:
            k = joint.minus.shape[1]
            N, Tx = joint.axes[:, 0], joint.axes[:, 1]
            if d == 3 and not layer and np.abs(Tx - default_tangent(N)).max() > 1e-6:
                raise ValueError(
                    f"joint {name}: expected no direction for abaqus, whose Tx is the projection of x; turn "
                    "the pattern, or give the section an *Orientation"
                )
            kind, parts_of = COHESIVE[d, k], [(name, slice(None))]
            if layer:
                kind = {3: "C3D6", 4: "C3D8"}[k]
                tangents = joint.axes[:, 1:].reshape(len(joint.area), -1).round(9) + 0.0
                axes, at = np.unique(tangents, axis=0, return_inverse=True)
                parts_of = [(f"{name}_{len(sets) + i}", at.ravel() == i - 1) for i in range(1, len(axes) + 1)]
                sets += [elset for elset, _ in parts_of]
                for (elset, _), one in zip(parts_of, axes, strict=True):
                    line = ", ".join(f"{x:.9g}" for x in one)
                    orientations.append(f"*Orientation, name={elset}, system=rectangular\n{line}\n")
            for elset, which in parts_of:
                some = _between(joint, d)[which] + 1
                text.append(f"*Element, type={kind}, elset={elset}\n" + _numbered("%d", number, some))
                number += len(some)
        if name in laws and not layer:
            card = laws[name].card("abaqus", name=name, dimension=d)
        elif name in laws:
            whole = laws[name].card("calculix", name=name, h=layer)
            card, section = whole.split("*SOLID SECTION, ")
            material = section.split("MATERIAL=")[1].strip()
            section = f"*SOLID SECTION, ELSET={{0}}, MATERIAL={material}, ORIENTATION={{0}}\n"
            card += "".join(map(section.format, sets))
        orientations.append(card)
    for group in mesh.groups:
        text.append(f"*Nset, nset={group}\n" + _list(mesh.nodes(group) + 1))
    for name, cells in mesh.sets.items():
        text.append(f"*Elset, elset={name}\n" + _list(np.sort(written[cells])))
    for name, rows in mesh.surfaces.items():
        lines = _lines("%d, S%d\n", written[rows[:, 0]], rows[:, 1])
        text.append(f"*Surface, type=element, name={name}\n" + lines)
    replace_file(path, "".join(text + orientations))
    return [path]


def _list(numbers: Integers) -> str:
    """Lines of 16 numbers."""
    rows = (numbers[i : i + 16].tolist() for i in range(0, len(numbers), 16))
    return "".join(", ".join(map(str, row)) + "\n" for row in rows)


def _mdpa(path: Path, mesh: Jointed, laws: dict[str, Interface], layer: float) -> list[Path]:
    """Kratos: parts of the model by block, joint, group; properties by block and joint; materials as JSON."""
    d = mesh.dimension
    names = {name: k for k, name in enumerate((*mesh.names, *mesh.joints), 1)}
    points = np.zeros((len(mesh.points), 3))
    points[:, :d] = mesh.points
    text = [f"// {HEAD}\nBegin ModelPartData\nEnd ModelPartData\n"]
    text += [f"Begin Properties {k}\nEnd Properties\n" for k in range(len(names) + 1)]
    text += ["Begin Nodes\n", _numbered("%d", 1, points, "%.15g", " "), "End Nodes\n"]
    number, parts = 1, {name: (np.zeros(0, np.int64), [np.zeros(0, np.int64)]) for name in names}

    def add(name: str, element: str, nodes: Integers) -> None:
        nonlocal number
        form = f"%d {names[name]}"
        text.append(f"Begin Elements {element}\n{_numbered(form, number, nodes + 1, by=' ')}End Elements\n")
        used, numbers = parts[name]
        parts[name] = np.union1d(used, nodes), [*numbers, np.arange(number, number + len(nodes))]
        number += len(nodes)

    written = np.zeros(sum(map(len, mesh.cells.values())), np.int64)
    for kind, block, cells, rows in _blocks(mesh):
        written[rows] = np.arange(number, number + len(cells))
        cells = cells[:, TWENTY] if kind == "hexahedron20" else cells
        add(block, f"SmallDisplacementElement{d}D{cells.shape[1]}N", cells)
    for name, some in mesh.joints.items():
        for joint in some:
            k = joint.minus.shape[1]
            add(name, f"{KRATOS[d][1]}{k}Plus{k}N", np.concatenate([joint.minus, joint.plus], 1))
    none = np.zeros(0, np.int64)
    conditions: dict[str, list[Integers]] = {}
    last = 1
    for name, rows in mesh.surfaces.items():
        for nodes in mesh.face_nodes(rows):
            kind = f"{CONDITIONS[d]}{nodes.shape[1]}N"
            text.append(
                f"Begin Conditions {kind}\n{_numbered('%d 0', last, nodes + 1, by=' ')}End Conditions\n"
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
        for what, one in (*lists, ("Conditions", np.concatenate(conditions.get(name, [none])))):
            text.append(f"Begin SubModelPart{what}\n{_lines('%d' + chr(10), one)}End SubModelPart{what}\n")
        text.append("End SubModelPart\n")
    if not laws:
        replace_file(path, "".join(text))
        return [path]
    cards = []
    for name, law in laws.items():
        [card] = json.loads(law.card("kratos", name=name, dimension=d))["properties"]
        cards.append(card | {"model_part_name": f"Main.{name}", "properties_id": names[name]})
    other = path.with_suffix(".json")
    replace_file(path, "".join(text))
    replace_file(other, json.dumps({"properties": cards}, indent=2) + "\n")
    return [path, other]


def _vtu(path: Path, mesh: Jointed, laws: dict[str, Interface], layer: float) -> list[Path]:
    """VTU of blocks and joints with N, Tx, Ty; MaterialIDs: the numbers of the blocks, then of the joints.

    Their names are field data with the number and the dimension.

    OpenGeoSys has two components in the plane, and a right-handed pair of axes: Tx is N turned to the left.
    """
    import meshio

    from .vtu import write_vtu

    d, points = mesh.dimension, layer_points(mesh, layer) if layer else mesh.points
    refuse(laws, f"laws of {', '.join(laws)}: expected none in a .vtu file")
    cells = [(kind, data) for kind, data in mesh.cells.items()]
    number = [mesh.block[kind] for kind in mesh.cells]
    axes = [np.broadcast_to(np.eye(d), (len(one), d, d)) for one in number]
    sense = np.array([1.0, -1.0])[:, None] if layer and d == 2 else 1.0
    for k, parts in enumerate(mesh.joints.values()):
        for joint in parts:
            between = _between(joint, d)
            cells.append((SOLIDS[between.shape[1] // 2], between))
            number.append(np.full(len(between), len(mesh.names) + k))
            axes.append(joint.axes * sense)
    room = 0 if layer else 3 - d
    axes = [np.pad(one, ((0, 0), (0, 0), (0, room))) for one in axes]
    data = {name: [one[:, k] for one in axes] for k, name in enumerate(("N", "Tx", "Ty")[:d])}
    data["MaterialIDs"] = [one.astype(np.int32) for one in number]
    points = np.pad(points, ((0, 0), (0, 3 - d)))
    names = [(name, k, d - (name in mesh.joints)) for k, name in enumerate((*mesh.names, *mesh.joints))]
    write_vtu(path, meshio.Mesh(points, cells, {"origin": mesh.origin}, data), names)
    return [path]


WRITERS = {"abaqus": _inp, "calculix": _inp, "kratos": _mdpa, "ogs": _vtu, "vtu": _vtu}  # writers by host
