"""Mesh files: readers of this package, registered by ending and first line, and meshio for all others."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from ..installed import needed
from .raw import RawMesh

FIRST = 4096  # bytes of a file in which its first line is looked for
EXPECTED = "a mesh that meshio reads"


@dataclass(frozen=True)
class Reader:
    """Reader of the files whose names have an ending and whose start fits an expression.

    module, function: of this package, from the path of a file to a RawMesh.
    """

    ending: str
    start: bytes
    module: str
    function: str

    def takes(self, path: Path, head: bytes) -> bool:
        """Whether a file is one of this reader."""
        return path.suffix.lower() == self.ending and bool(re.search(self.start, head))

    def read(self, path: Path) -> RawMesh:
        """Mesh of a file."""
        reader: Callable[[Path], RawMesh] = getattr(
            import_module(f"{__package__}.{self.module}"), self.function
        )
        return reader(path)


READERS = [
    Reader(".inp", b"", "abaqus", "read_deck"),
    Reader(".msh", rb"\$MeshFormat\s+[0-9.]+\s+[01]\s+[0-9]+\s", "gmsh", "read_msh"),
    Reader(".msh", rb"\A\s*\$NOD", "gmsh", "refuse_format_1"),
]
"""Readers in the order in which they are asked; further ones are appended."""


def read_raw(path: Path) -> RawMesh:
    """Mesh of a file; raises ValueError with the name of the file, why, and what was expected."""
    if not path.is_file():
        raise ValueError(f"{path}: no such file: expected a mesh, such as .msh of gmsh, .inp or .vtu")
    with path.open("rb") as file:
        head = file.read(FIRST)
    if reader := next((reader for reader in READERS if reader.takes(path, head)), None):
        return reader.read(path)
    from .others import raw_of

    return raw_of(read_mesh(path, EXPECTED, "mesh"))


def read_mesh(path: Path, expected: str, extra: str) -> Any:
    """Mesh of meshio of a file; raises ValueError with the name of the file, why, and what was expected.

    extra: of the package, which brings meshio; ModuleNotFoundError names it.
    """
    needed(extra, "meshio")
    import meshio

    if any(path.suffix.lower() == reader.ending for reader in READERS):
        with path.open("rb") as file:
            head = file.read(FIRST)
        if any(reader.takes(path, head) for reader in READERS):
            raw = read_raw(path)
            return meshio.Mesh(raw.points, [(entry.kind, np.array(entry.nodes)) for entry in raw.cells])
        expected += ", of gmsh in format 2.2 or 4.1 (Mesh.MshFileVersion)"
    said = StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said), np.errstate(over="ignore"):
            mesh = meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio prints and exits where it cannot read
        text = (" ".join(said.getvalue().split()) or str(error)).rstrip(".")
        raise ValueError(f"{path}: {text or type(error).__name__}: expected {expected}") from None
    points = np.asarray(mesh.points)
    for block in mesh.cells:
        data = np.asarray(block.data)
        if data.dtype.kind not in "iu" or (data.size and not 0 <= data.min() <= data.max() < len(points)):
            raise ValueError(f"{path}: a {block.type} has nodes that are not there: expected {expected}")
    legacy = path.suffix.lower() == ".vtk"
    counted = re.search(rb"\nCELL_TYPES\s+(\d+)", path.read_bytes()) if legacy else None
    if counted and int(counted[1]) != (count := sum(len(block.data) for block in mesh.cells)):
        raise ValueError(f"{path}: {count} cells of {int(counted[1])} are read: expected {expected}")
    return mesh
