"""Results of structures for ParaView: a PVD file, and for every step a VTU file of solids and one of joints.

Writing needs meshio (`pip install "asperity[paraview]"`).  A script of your own may have a copy of this file.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from asperity import contract
from numpy.typing import NDArray

if TYPE_CHECKING:
    import meshio

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

CELLS = {4: "quad", 8: "hexahedron"}
"""Name of a cell by its number of nodes."""

AROUND = {
    2: ((0,), (1,)),
    4: ((0, 0), (1, 0), (1, 1), (0, 1)),
    8: tuple((a, b, c) for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))),
}
"""Corners of a cell in the order of its nodes, by position along each axis of the cell."""

ENERGIES = ("stored", "rupture", "friction")
"""Energies among the state variables, which are fields of their own."""


@dataclass(frozen=True)
class Structure:
    """Nodes (n, 2 or 3), solids (k, 4 or 8) and joints (j, 4 or 8), whose nodes count from 0.

    The nodes of a cell have the order of VTK: around a quadrilateral, or around the lower face of a
    hexahedron and then around its upper face.  parts is the number of integration points of a joint along
    each of its axes: from node 0 to node 1, from there to node 2 and, in 3D, from the lower to the upper
    face.  Every integration point becomes a cell of the joint; that along the last axis changes fastest.
    """

    nodes: Floats
    solids: Integers
    joints: Integers
    parts: tuple[int, ...]

    @property
    def points(self) -> int:
        """Number of integration points of all joints."""
        return len(self.joints) * int(np.prod(self.parts))

    def on_parts(self, values: Floats) -> Floats:
        """Values of the nodes, (n, ...), at the corners of the cells of the integration points."""
        places = np.indices([n + 1 for n in self.parts]).reshape(len(self.parts), -1, 1)
        places = places / np.reshape(self.parts, (-1, 1, 1))
        at = np.transpose(AROUND[self.joints.shape[1]])[:, None]
        shares = np.where(at, places, 1.0 - places).prod(axis=0)
        found = np.einsum("gc,ec...->eg...", shares, values[self.joints])
        return found.reshape(-1, *values.shape[1:])

    def parts_of_joints(self) -> Integers:
        """Cells of the integration points, joint by joint."""
        cells = grid_cells(self.parts)
        size = np.prod([n + 1 for n in self.parts])
        return (size * np.arange(len(self.joints))[:, None, None] + cells).reshape(-1, cells.shape[1])


def grid_cells(parts: Sequence[int]) -> Integers:
    """Nodes of the cells of a grid, whose nodes along the last axis change fastest."""
    shape = [n + 1 for n in parts]
    grid = np.arange(np.prod(shape)).reshape(shape)
    cut = slice(None, -1), slice(1, None)
    return np.stack([grid[tuple(cut[a] for a in at)].ravel() for at in AROUND[2 ** len(shape)]], axis=-1)


@dataclass(frozen=True)
class Step:
    """Results of a step: time, displacement (n, 2 or 3) of nodes, and values of the integration points.

    separation, traction (points, 3) are (N, Tx, Ty); state (points, nstatv).  structure is that of this step,
    where cells were added during the run.
    """

    time: float
    displacement: Floats
    separation: Floats
    traction: Floats
    state: Floats
    structure: Structure | None = None

    def fields(self) -> dict[str, Floats]:
        """Fields of the joints by name."""
        names = ("damage", *ENERGIES)
        found = {name: self.state[:, contract.statev_index(name)] for name in names}
        slip = self.separation[:, 1:]
        return found | {"dilation": self.separation[:, 0], "slip": slip, "traction": self.traction}


def write(pvd: Path, structure: Structure, steps: Iterable[Step]) -> None:
    """Write the steps: FILE.pvd, which ParaView opens, and a folder FILE with two VTU files for each step.

    Both kinds of files have the displacement at the nodes.  Those of the joints have, for each integration
    point, damage, dilation (s_N), slip (s_Tx, s_Ty), traction (N, Tx, Ty) and the energies per area stored,
    rupture and friction.  Raises ValueError where a name does not end with .pvd or a shape does not fit.
    """
    folder = folder_of(pvd)
    names: list[tuple[float, list[str]]] = []
    for k, step in enumerate(steps):
        now = step.structure or structure
        if step.displacement.shape != now.nodes.shape:
            shape = step.displacement.shape
            raise ValueError(f"displacement has shape {shape}: expected {now.nodes.shape}")
        for name in ("separation", "traction", "state"):
            found = len(getattr(step, name))
            if found != now.points:
                raise ValueError(f"{name} of {found} points: expected {now.points}, of all joints")
        moved = now.on_parts(step.displacement)
        joints = (now.on_parts(now.nodes), now.parts_of_joints(), moved, step.fields())
        files = {
            f"solids_{k:04}.vtu": _mesh(now.nodes, now.solids, step.displacement),
            f"joints_{k:04}.vtu": _mesh(*joints),
        }
        for name, mesh in files.items():
            mesh.write(folder / name)
        names.append((step.time, [*files]))
    write_collection(pvd, names)


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


def _mesh(
    points: Floats, cells: Integers, displacement: Floats, fields: dict[str, Floats] | None = None
) -> meshio.Mesh:
    """Mesh in three dimensions, as ParaView wants it."""
    import meshio

    of_points = {"displacement": _in_space(displacement)}
    of_cells = {name: [field] for name, field in (fields or {}).items()}
    return meshio.Mesh(_in_space(points), [(CELLS[cells.shape[1]], cells)], of_points, of_cells)


def _in_space(values: Floats) -> Floats:
    """Vectors (n, 3) of (n, 2 or 3)."""
    out = np.zeros((len(values), 3))
    out[:, : values.shape[1]] = values
    return out
