"""Runs of OpenGeoSys: meshes as VTU files, patches of the project, the run, and its output."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

POINT, LINE, QUADRILATERAL, HEXAHEDRON = 1, 3, 9, 12
"""Cell types of VTK."""

TYPES = {"i4": "Int32", "i8": "Int64", "u8": "UInt64", "f8": "Float64", "u1": "UInt8"}
"""Names of VTK by those of NumPy."""


@dataclass(frozen=True)
class Run:
    """A run: exit code, output, and the folder of its VTU files."""

    code: int
    output: str
    folder: Path

    @property
    def iterations(self) -> list[int]:
        """Iterations of Newton's method in every attempted step."""
        found = re.findall(r"^info: Iteration #(\d+) started", self.output, re.MULTILINE)
        numbers = [int(one) for one in found]
        return [n for n, after in zip(numbers, [*numbers[1:], 1], strict=True) if after == 1]

    @property
    def rejected(self) -> int:
        """Number of rejected steps."""
        m = re.search(r"rejected steps are (\d+)", self.output)
        assert m, self.output
        return int(m[1])

    def steps(self) -> tuple[Floats, list[dict[str, Floats]]]:
        """Times (T,) and the fields at the nodes of every output, by name."""
        (collection,) = self.folder.glob("*.pvd")
        sets = ET.parse(collection).getroot().iter("DataSet")
        rows = [(float(one.attrib["timestep"]), one.attrib["file"]) for one in sets]
        return np.array([time for time, _ in rows]), [fields(self.folder / name) for _, name in rows]


def write_mesh(
    path: Path,
    points: ArrayLike,
    cells: ArrayLike,
    kind: int,
    of_points: Mapping[str, ArrayLike] | None = None,
    of_cells: Mapping[str, ArrayLike] | None = None,
) -> None:
    """Write a mesh of cells of one kind, with fields of its points and cells.

    points (n, 2 or 3); cells (m, nodes of a cell), from 0.
    """
    xyz = np.zeros((len(np.asarray(points)), 3))
    xyz[:, : np.shape(points)[1]] = points
    nodes = np.asarray(cells, dtype="i8")
    arrays = {
        "PointData": {name: np.asarray(field) for name, field in (of_points or {}).items()},
        "CellData": {name: np.asarray(field) for name, field in (of_cells or {}).items()},
        "Points": {"Points": xyz},
        "Cells": {
            "connectivity": nodes.ravel(),
            "offsets": nodes.shape[1] * np.arange(1, len(nodes) + 1, dtype="i8"),
            "types": np.full(len(nodes), kind, dtype="u1"),
        },
    }
    root = ET.Element("VTKFile", type="UnstructuredGrid", version="1.0", byte_order="LittleEndian")
    piece = ET.SubElement(ET.SubElement(root, "UnstructuredGrid"), "Piece")
    piece.attrib |= {"NumberOfPoints": str(len(xyz)), "NumberOfCells": str(len(nodes))}
    for group, members in arrays.items():
        parent = ET.SubElement(piece, group)
        for name, field in members.items():
            kind_name = TYPES[field.dtype.str[1:]]
            array = ET.SubElement(parent, "DataArray", type=kind_name, Name=name, format="ascii")
            if field.ndim > 1:
                array.attrib["NumberOfComponents"] = str(field.shape[1])
            array.text = " ".join(map(repr, field.ravel().tolist()))
    ET.ElementTree(root).write(path)


def write_part(path: Path, points: Floats, cells: ArrayLike, kind: int) -> None:
    """Write a part of the boundary, its cells given by nodes of the whole mesh, from 0."""
    nodes = np.asarray(cells)
    used, local = np.unique(nodes, return_inverse=True)
    ids = {"bulk_node_ids": used.astype("u8")}
    write_mesh(path, points[used], local.reshape(nodes.shape), kind, ids)


def fields(path: Path) -> dict[str, Floats]:
    """Fields at the nodes of an output in ASCII, (n,) or (n, components), and `Points` (n, 3)."""
    found = {}
    piece = ET.parse(path).getroot().find(".//Piece")
    assert piece is not None, path
    for array in [*piece.iterfind("PointData/DataArray"), *piece.iterfind("Points/DataArray")]:
        values = np.array((array.text or "").split(), dtype=float)
        n = int(array.attrib.get("NumberOfComponents", 1))
        found[array.attrib["Name"]] = values if n == 1 else values.reshape(-1, n)
    return found


def program() -> Path:
    """Path of ogs, which its wheel installs beside this Python."""
    return Path(sys.executable).parent / "ogs"


def run(project: Path, folder: Path, *patches: str) -> Run:
    """Run a project with patches (texts) on the meshes of a folder, with one thread; output in `out`.

    The code is not 0 where OpenGeoSys ended with an error.
    """
    command = [str(program()), str(project), "-m", str(folder), "-o", str(folder / "out")]
    out = folder / "out"
    out.mkdir(exist_ok=True)
    for old in [*out.glob("*.vtu"), *out.glob("*.pvd")]:
        old.unlink()
    for k, patch in enumerate(patches):
        (folder / f"patch_{k}.xml").write_text(patch, encoding="utf-8")
        command += ["-p", str(folder / f"patch_{k}.xml")]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    return Run(done.returncode, done.stdout + done.stderr, folder / "out")


def changed(*changes: tuple[str, str, str]) -> str:
    """Patch of (what, where, text): what is add, replace or remove, where a path in the project."""
    lines = [f'<{what} sel="{where}">{text}</{what}>' for what, where, text in changes]
    return "\n".join(['<?xml version="1.0"?>', "<OpenGeoSysProjectDiff>", *lines, "</OpenGeoSysProjectDiff>"])


def values(name: str, numbers: Sequence[float]) -> tuple[str, str, str]:
    """Change of the values of a curve of the project."""
    return "replace", f"/*/curves/curve[name='{name}']/values/text()", " ".join(map(repr, numbers))
