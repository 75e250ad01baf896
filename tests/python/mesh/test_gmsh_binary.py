"""Binary files of gmsh have all that their texts have, and are refused where bytes are lost."""

from __future__ import annotations

import struct
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from asperity import ModelWarning
from asperity.mesh import split

from mesh import drawn_meshes

DRAWN = 40
"""Drawn files, of both formats."""

CUTS = 12
"""Places at which each file is cut off."""

SIZES = {2: 3, 3: 4}
"""Nodes of triangles and quadrilaterals, by gmsh's number of the type."""


def sections(text: str) -> dict[str, list[list[str]]]:
    """Words of the lines of each section."""
    parts: dict[str, list[list[str]]] = {}
    for line in text.splitlines():
        if line.startswith("$"):
            rows = parts.setdefault(line[1:], [])
        else:
            rows.append(line.split())
    return parts


def packed(order: str, kinds: str, words: Iterator[str]) -> bytes:
    """The next words as numbers of these kinds: i, Q or d."""
    values = [next(words) for _ in kinds]
    return struct.pack(
        f"{order}{kinds}", *(float(v) if k == "d" else int(v) for k, v in zip(kinds, values, strict=True))
    )


def entities(order: str, words: Iterator[str], count: list[int]) -> bytes:
    """Section $Entities, of curves, surfaces and volumes."""
    data = struct.pack(f"{order}4Q", *count)
    for _ in range(sum(count)):
        data += packed(order, "idddddd", words)
        for _ in range(2):
            n = int(next(words))
            data += struct.pack(f"{order}Q", n) + packed(order, "i" * n, words)
    return data


def binary(text: str, order: str) -> bytes:
    """A drawn file in binary, with bytes in this order: < or >."""
    parts = sections(text)
    version = parts["MeshFormat"][0][0]
    names = "\n".join(" ".join(words) for words in parts["PhysicalNames"])
    data = f"$MeshFormat\n{version} 1 8\n".encode() + struct.pack(f"{order}i", 1)
    data += f"\n$EndMeshFormat\n$PhysicalNames\n{names}\n$EndPhysicalNames\n".encode()
    nodes, elements = parts["Nodes"], parts["Elements"]
    if version == "2.2":
        data += f"$Nodes\n{len(nodes) - 1}\n".encode()
        data += b"".join(packed(order, "iddd", iter(row)) for row in nodes[1:])
        data += f"\n$EndNodes\n$Elements\n{len(elements) - 1}\n".encode()
        for row in elements[1:]:
            data += packed(order, "iii", iter((row[1], "1", row[2])))
            data += packed(order, "i" * (len(row) - 2), iter([row[0], *row[3:]]))
    else:
        rows = parts["Entities"]
        words = iter([word for row in rows[1:] for word in row])
        data += b"$Entities\n" + entities(order, words, [*map(int, rows[0])]) + b"\n$EndEntities\n"
        words = iter([word for row in nodes for word in row])
        count = len(nodes[2:]) // 2
        data += b"$Nodes\n" + packed(order, "QQQQiiiQ" + count * "Q" + 3 * count * "d", words)
        data += b"\n$EndNodes\n$Elements\n" + packed(order, "QQQQ", iter(elements[0]))
        k = 1
        while k < len(elements):
            n = int(elements[k][3])
            data += packed(order, "iiiQ", iter(elements[k]))
            words = iter([word for row in elements[k + 1 : k + 1 + n] for word in row])
            data += packed(order, "Q" * n * (1 + SIZES[int(elements[k][2])]), words)
            k += 1 + n
    return data + b"\n$EndElements\n"


def test_drawn_files(tmp_path: Path) -> None:
    """The mesh is that of the text: nodes, cells, blocks, groups, joints; cut off, a file is refused."""
    text, packed = tmp_path / "text.msh", tmp_path / "binary.msh"
    for seed in range(DRAWN):
        draw = np.random.default_rng([seed, 11])
        text.write_text(drawn_meshes.gmsh(seed).files["mesh.msh"], encoding="utf-8")
        data = binary(text.read_text(encoding="utf-8"), "<>"[seed % 2])
        packed.write_bytes(data)
        expected, mesh = split(text), split(packed)
        assert mesh.summary() == expected.summary()
        assert mesh.points == pytest.approx(expected.points, abs=0.0)
        for cut in draw.integers(1, len(data) - len("$EndElements\n") - 1, CUTS):
            packed.write_bytes(data[:cut])
            with pytest.raises(ValueError, match=r"binary.msh.*expected") as caught:
                split(packed)
            assert "\n" not in str(caught.value)


def test_changed_bytes(tmp_path: Path) -> None:
    """A file with a changed byte is refused in one line, or is a mesh; there is no other error."""
    path = tmp_path / "binary.msh"
    for seed in range(DRAWN):
        draw = np.random.default_rng([seed, 12])
        data = bytearray(binary(drawn_meshes.gmsh(seed).files["mesh.msh"], "<"))
        for k in draw.integers(0, len(data), 3):
            data[k] = int(draw.integers(256))
        path.write_bytes(data)
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore", ModelWarning)
                split(path)
        except ValueError as error:
            assert "\n" not in str(error)


def test_formats_that_are_not_read(tmp_path: Path) -> None:
    """They are named."""
    path = tmp_path / "mesh.msh"
    path.write_text(
        drawn_meshes.gmsh(0).files["mesh.msh"].replace("2.2 0 8", "4 0 8").replace("4.1 0", "4 0")
    )
    with pytest.raises(ValueError, match=r"format 4: expected 2.2 or 4.1 \(Mesh.MshFileVersion\)"):
        split(path)
