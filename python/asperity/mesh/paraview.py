"""Results of structures for ParaView: a PVD file, and for every step a VTU file of solids and one of joints.

Writing needs meshio (`pip install "asperity[paraview]"`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from numpy.typing import NDArray

from .. import contract
from ..contract import Floats
from .shapes import Integers
from .vtu import write_vtu

JOINTS = {4: "quad", 6: "wedge", 8: "hexahedron"}
"""Cells between the two faces of a joint, by their number of nodes."""

OF_STATE = ("damage", "stored", "rupture", "friction")
"""State variables that are fields: the damage, and energies per area."""


@dataclass(frozen=True)
class Step:
    """Results of a step: time, nodes (n, 2 or 3) and their displacement, solids and joints with their nodes.

    kind: type of the solids in meshio.  The nodes of a joint are those of one face and then, in the order of
    VTK, of the other one.  separation and traction (N, Tx, Ty) and state of the points of the joints have the
    shape (joints, points of a joint, components); the fields are means over the points.  block, joint:
    numbers of the blocks of the solids and of the joints in `blocks` and `names`, which the files carry.
    others: further fields of the joints, (joints, points of a joint).
    """

    time: float
    nodes: Floats
    displacement: Floats
    kind: str
    solids: Integers
    joints: Integers
    separation: Floats
    traction: Floats
    state: Floats
    block: Integers | None = None
    joint: Integers | None = None
    blocks: Sequence[str] = ()
    names: Sequence[str] = ()
    others: Mapping[str, Floats] = field(default_factory=dict)

    def write(self, folder: Path, label: str) -> list[str]:
        """Write solids_LABEL.vtu and joints_LABEL.vtu; returns the names.

        Raises ValueError where the results are not those of all nodes or joints.
        """
        if self.displacement.shape != self.nodes.shape:
            raise ValueError(f"displacement has shape {self.displacement.shape}: expected {self.nodes.shape}")
        of_joints = {name: getattr(self, name) for name in ("separation", "traction", "state")}
        for name, values in (of_joints | dict(self.others)).items():
            if len(values) != len(self.joints):
                raise ValueError(f"{name} of {len(values)} joints: expected {len(self.joints)}")
        fields = {name: values.mean(1) for name, values in self.others.items()}
        fields |= {name: self.state[..., contract.statev_index(name)].mean(1) for name in OF_STATE}
        fields |= {"separation": self.separation.mean(1), "traction": self.traction.mean(1)}
        d, joints = self.nodes.shape[1], JOINTS[self.joints.shape[1]]
        here, there = (
            {} if numbers is None else {"MaterialIDs": np.asarray(numbers, np.int64)}
            for numbers in (self.block, self.joint)
        )
        for part, names, kind, cells, data in (
            ("solids", self.blocks, self.kind, self.solids, here),
            ("joints", self.names, joints, self.joints, fields | there),
        ):
            named = [(name, k, d - (part == "joints")) for k, name in enumerate(names)]
            write_vtu(folder / f"{part}_{label}.vtu", self._mesh(kind, cells, data), named)
        return [f"solids_{label}.vtu", f"joints_{label}.vtu"]

    def _mesh(self, kind: str, cells: Integers, fields: Mapping[str, NDArray[Any]]) -> meshio.Mesh:
        """Mesh in three dimensions, as ParaView wants it."""
        nodes, moved = (np.pad(x, ((0, 0), (0, 3 - x.shape[1]))) for x in (self.nodes, self.displacement))
        of_cells = {name: [field] for name, field in fields.items()}
        return meshio.Mesh(nodes, [(kind, cells)], {"displacement": moved}, of_cells)


def write(pvd: Path, steps: Iterable[Step]) -> None:
    """Write the steps: FILE.pvd, which ParaView opens, and a folder FILE with two VTU files for each step."""
    folder = folder_of(pvd)
    write_collection(pvd, [(step.time, step.write(folder, f"{k:04}")) for k, step in enumerate(steps)])


def folder_of(pvd: Path) -> Path:
    """Make the folder of the VTU files of FILE.pvd; ValueError for another ending."""
    if pvd.suffix != ".pvd":
        raise ValueError(f"{pvd}: expected a name that ends with .pvd")
    folder = pvd.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def write_collection(pvd: Path, steps: Iterable[tuple[float, Iterable[str]]]) -> None:
    """Write FILE.pvd with times and the names of files in its folder."""
    lines = [
        f'<DataSet timestep="{time!r}" part="{part}" file="{pvd.stem}/{name}"/>'
        for time, names in steps
        for part, name in enumerate(names)
    ]
    head = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1">', "<Collection>"]
    pvd.write_text("\n".join([*head, *lines, "</Collection>", "</VTKFile>", ""]), encoding="utf-8")
