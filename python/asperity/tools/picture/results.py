"""Steps of a PVD file: solids and joints, with their displacements and fields."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...contract import Floats
from ...mesh.files import read_mesh

if TYPE_CHECKING:
    import meshio

JOINTS = {"quad": 4, "wedge": 6, "hexahedron": 8}
"""Cells between the two faces of a joint, and their number of nodes."""

EXPECTED = "a file of results that an example writes with --pvd"


@dataclass(frozen=True)
class Results:
    """A step of a structure.

    solids: places (n, 3) and displacements (n, 3), type and nodes of cells.  x, u (f, k, 3): places and
    displacements of the middles between the faces of the joints, by number of nodes.  fields: damage, slip,
    opening, shear and normal traction by name, as far as they are there.  part: number of the joint of each
    face in `names`.
    """

    time: float
    solids: list[tuple[Floats, Floats, str, NDArray[np.int64]]]
    x: list[Floats]
    u: list[Floats]
    fields: dict[str, list[Floats]]
    part: list[NDArray[np.int64]]
    names: list[str]

    @property
    def plane(self) -> bool:
        """Whether all solids are in x and y."""
        return all(kind.startswith(("triangle", "quad")) for _, _, kind, _ in self.solids)

    @property
    def scale(self) -> float:
        """Factor 1, 2 or 5 times a power of 10: displacements are at most a twentieth of the size."""
        size = np.ptp(np.concatenate([x for x, *_ in self.solids]), axis=0).max()
        most = max(float(np.abs(u).max()) for _, u, *_ in self.solids)
        if not most > 0.0:
            return 1.0
        power = 10.0 ** np.floor(np.log10(0.05 * size / most))
        return float(max(digit * power for digit in (1.0, 2.0, 5.0) if digit * power * most <= 0.05 * size))


def read_results(pvd: Path) -> list[Results]:
    """Steps of a PVD file, from one or several files each; ValueError with the file and what is missing."""
    if not pvd.is_file():
        raise ValueError(f"{pvd}: no such file: expected {EXPECTED}")
    try:
        entries = list(ET.parse(pvd).getroot().iter("DataSet"))
        named = [(float(entry.attrib["timestep"]), entry.attrib["file"]) for entry in entries]
    except (ET.ParseError, KeyError, ValueError) as error:
        raise ValueError(f"{pvd}: {error}: expected {EXPECTED}") from None
    rows: dict[float, list[meshio.Mesh]] = {}
    for time, file in named:
        rows.setdefault(time, []).append(read_mesh(pvd.parent / file, EXPECTED, "picture"))
    steps = [_step(pvd, time, meshes) for time, meshes in rows.items()]
    if not steps:
        raise ValueError(f"{pvd}: no steps: expected {EXPECTED}")
    return steps


def _step(pvd: Path, time: float, meshes: list[meshio.Mesh]) -> Results:
    """Results of the files of a step; joints are those with a field `separation`."""
    solids, x, u, part = [], [], [], []
    fields: dict[str, list[Floats]] = {}
    names: dict[int, str] = {}
    for mesh in meshes:
        moved = mesh.point_data.get("displacement")
        if moved is None:
            raise ValueError(f"{pvd}: no displacement of a part: expected {EXPECTED}")
        if "separation" not in mesh.cell_data:
            solids += [(mesh.points, moved, block.type, np.asarray(block.data)) for block in mesh.cells]
            continue
        names |= {int(ids[0]): name for name, ids in mesh.field_data.items()}
        for k, cells in enumerate(mesh.cells):
            if cells.type not in JOINTS:
                raise ValueError(f"{pvd}: joints of the type {cells.type}: expected {', '.join(JOINTS)}")
            data = np.asarray(cells.data)
            half = data.shape[1] // 2
            opposite = data[:, half:][:, ::-1] if half == 2 else data[:, half:]
            middle = [0.5 * (places[data[:, :half]] + places[opposite]) for places in (mesh.points, moved)]
            x.append(middle[0])
            u.append(middle[1])
            for name, values in _fields({name: blocks[k] for name, blocks in mesh.cell_data.items()}).items():
                fields.setdefault(name, []).append(values)
            numbers = mesh.cell_data.get("MaterialIDs")
            part.append(
                np.zeros(len(data), np.int64) if numbers is None else np.asarray(numbers[k], np.int64)
            )
    if not solids or not x:
        raise ValueError(f"{pvd}: expected solids and joints in every step, as an example writes with --pvd")
    known = sorted({int(k) for ids in part for k in np.unique(ids)})
    part = [np.searchsorted(known, ids) for ids in part]
    whole = {name: values for name, values in fields.items() if len(values) == len(x)}
    return Results(time, solids, x, u, whole, part, [names.get(k, f"joint {k}") for k in known])


def _fields(data: dict[str, Floats]) -> dict[str, Floats]:
    """Fields that can be drawn, of those in a file."""
    fields = {name: np.asarray(data[name], float) for name in ("damage",) if name in data}
    for name, along, across in (("separation", "slip", "opening"), ("traction", "shear", "normal")):
        if name in data:
            vector = np.asarray(data[name], float)
            fields[along] = np.linalg.norm(vector[:, 1:], axis=1)
            fields[across] = vector[:, 0]
    return fields
