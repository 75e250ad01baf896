"""Mesh files: decks of Abaqus and files of gmsh by readers of this package, others by meshio."""

from __future__ import annotations

import re
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from ..installed import needed


def read_mesh(path: Path, expected: str, extra: str) -> Any:
    """Mesh of a file by meshio; raises ValueError with the name of the file, why, and what was expected.

    extra: of the package, which brings meshio; ModuleNotFoundError names it.
    """
    needed(extra, "meshio")
    import meshio

    from . import abaqus, gmsh

    if path.suffix.lower() == ".inp":
        return abaqus.read_deck(path)
    if path.suffix.lower() == ".msh" and gmsh.is_gmsh(path):
        return gmsh.read_msh(path)
    if path.suffix.lower() == ".msh":
        expected += ", of gmsh in format 2.2 or 4.1 (Mesh.MshFileVersion)"
        if gmsh.is_format_1(path):
            raise ValueError(f"{path}: format 1 of gmsh: expected {expected}")
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
