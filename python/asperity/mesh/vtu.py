"""VTU files that carry the names of blocks and joints."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import meshio


def write_vtu(path: Path, mesh: meshio.Mesh, names: Iterable[tuple[str, int, int]]) -> None:
    """Write a mesh of meshio with its names as field data; a file that is there is replaced as a whole.

    names: of the MaterialIDs, each with its number and dimension, which meshio.read returns as field_data.
    """
    lines = (
        f'<DataArray type="Int64" Name="{name}" NumberOfTuples="2" format="ascii">{number} {d}</DataArray>'
        for name, number, d in names
    )
    field = "\n".join(("<UnstructuredGrid>", "<FieldData>", *lines, "</FieldData>", ""))
    part = path.with_name(f".{path.name}.{os.getpid()}.vtu")
    try:
        mesh.write(part)
        part.write_bytes(part.read_bytes().replace(b"<UnstructuredGrid>", field.encode(), 1))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
